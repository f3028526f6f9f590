/* timeout: 120 */
/* The packed kernel against the serial one, which is its oracle; its bits. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include "../common/near.h"
#include "../common/rve_case.h"

static const int paths[] = {RVE_SIMD, RVE_SIMD_SINGLE};

/* Runs both from the same packing: the largest difference of a stress component, Pa, along the way. */
static double largest_difference(int path, double pressure, double strain_per_call, int calls, double dT, int sub_steps)
{
	struct rve_params params;
	rve_params_default(&params);
	params.n_max = sub_steps;
	struct rve_case serial, packed;
	case_start_loose(&serial, &params, pressure);
	params.path = path;
	case_start_loose(&packed, &params, pressure);
	const double L[4] = {0.0, 2.0 * strain_per_call / 1e-3, 0.0, 0.0};
	double most = 0.0;
	for (int k = 0; k < calls; k++) {
		case_advance(&serial, L, dT, 1e-3, 1);
		case_advance(&packed, L, dT, 1e-3, 1);
		for (int q = 0; q < 4; q++)
			most = fmax(most, fabs(serial.stress[q] - packed.stress[q]));
		if (k == 0 || k == calls - 1)
			printf("path %d call %d: %g %g %g | %g %g %g  mod %g %g heat %g %g k %g %g contacts %d %d diff %g\n", path, k,
				   serial.stress[0], serial.stress[1], serial.stress[3], packed.stress[0], packed.stress[1], packed.stress[3],
				   serial.modulus, packed.modulus, serial.heat, packed.heat, serial.conductivity[0], packed.conductivity[0],
				   case_info(&serial).n_contacts, case_info(&packed).n_contacts, most);
	}
	struct rve_info a = case_info(&serial), b = case_info(&packed);
	printf("  work %g %g el %g %g kin %g %g fr %g %g da %g %g ex %g %g | res %g %g unb %g %g ov %g %g slid %g %g rebuilds %d %d\n", a.work, b.work, a.elastic, b.elastic, a.kinetic,
		   b.kinetic, a.friction, b.friction, a.dashpot, b.dashpot, a.expansion, b.expansion, case_residual(&a), case_residual(&b),
		   a.unbalanced, b.unbalanced, a.max_overlap, b.max_overlap, a.sliding_fraction, b.sliding_fraction, a.rebuilds, b.rebuilds);
	case_end(&serial);
	case_end(&packed);
	return most;
}

static void test_first(void **arg)
{
	(void)arg;
	for (int k = 0; k < 2; k++) {
		largest_difference(paths[k], 100e3, 5e-5, 1, 0.1, 1);
		largest_difference(paths[k], 100e3, 5e-5, 20, 0.0, 1);
		largest_difference(paths[k], 100e3, 1e-3, 100, 0.01, 20);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_first),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
