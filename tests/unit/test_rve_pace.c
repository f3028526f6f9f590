/* Longer DEM steps where they matter little: what they may change, and what is said of it. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include "../common/near.h"
#include "../common/rve_case.h"

static const double dt = 1e-4;
static const double shear[4] = {0.0, 2.0, 0.0, 0.0}, slow[4] = {0.0, 0.05, 0.0, 0.0};

enum { PACKINGS = 6 };

static int compare(const void *a, const void *b)
{
	double x = *(const double *)a, y = *(const double *)b;
	return (x > y) - (x < y);
}

/* Shears cells of 10 kPa, opened by `opening` first, at constant volume: the mean pressure of the second half, the median
 * of six packings (one that jams where the others do not says nothing of inertia); the last cell's counts. */
static double go(const struct rve_params *params, double opening, struct rve_info *info)
{
	double pressures[PACKINGS] = {0};
	for (int k = 0; k < PACKINGS; k++) {
		struct rve_case c;
		struct rve_packing *packing = case_packing(10e3, 0.5, (unsigned)k + 1);
		case_start(&c, params, packing);
		rve_packing_free(packing);
		const double L[4] = {0.5 * opening / dt / 50, 0.0, 0.0, 0.5 * opening / dt / 50};
		case_advance(&c, L, 0.0, dt, 50);
		for (int call = 0; call < 1600; call++) {
			case_advance(&c, shear, 0.0, dt, 1);
			if (call >= 800)
				pressures[k] -= 0.5 * (c.stress[0] + c.stress[1]) / 800;
		}
		*info = case_info(&c);
		case_end(&c);
	}
	qsort(pressures, PACKINGS, sizeof *pressures, compare);
	return 0.5 * (pressures[PACKINGS / 2 - 1] + pressures[PACKINGS / 2]);
}

/* What inertia adds to the stress of cells that slow shear leaves without any is no more than what was allowed; twice
 * that in cells that are about to jam, opened by 0.002. */
static void test_error_is_kept(void **state)
{
	(void)state;
	static const double openings[] = {2e-3, 1e-2, 3e-2}, allowed[] = {30.0, 100.0, 300.0};
	for (int o = 0; o < 3; o++) {
		struct rve_params params;
		struct rve_info info;
		rve_params_default(&params);
		params.n_max = 0;
		params.gas = 0;
		double exact = go(&params, openings[o], &info);
		for (int a = 0; a < 3; a++) {
			params.pace_stress = allowed[a];
			double paced = go(&params, openings[o], &info);
			double saved = (double)info.paced_saved / (double)(info.paced_saved + info.total_sub_steps);
			print_message("  opened by %5.3f: %5.1f Pa; %3g Pa allowed: %6.1f Pa, saves %.0f%%\n", openings[o], exact,
						  allowed[a], paced, 100 * saved);
			assert_true(info.paced_error_most <= allowed[a] * 1.001);
			assert_true(paced - exact < (o == 0 ? 2 : 1) * allowed[a]);
			assert_true(saved > 0.3);
		}
	}
}

/* Off: not another sub-step.  On: what was saved and what was done make up what would have been done. */
static void test_counts(void **state)
{
	(void)state;
	struct rve_params params;
	rve_params_default(&params);
	struct rve_case plain, paced;
	case_start_loose(&plain, &params, 10e3);
	params.pace_stress = 1000.0;
	case_start_loose(&paced, &params, 10e3);
	case_advance(&plain, shear, 0.0, dt, 1), case_advance(&paced, shear, 0.0, dt, 1);
	struct rve_info a = case_info(&plain), b = case_info(&paced);
	assert_true(a.paced_calls == 0 && a.paced_saved == 0 && b.paced_calls == 1 && b.paced_saved > 0);
	assert_int_equal(a.total_sub_steps, b.total_sub_steps + b.paced_saved);
	assert_true(b.paced_error_most > 0.0 && b.paced_error_most <= 1000.1 && b.paced_error_sum == b.paced_error_most);
	case_end(&plain), case_end(&paced);
}

/* Contacts at rest let a step be longer; once they slide, it is as short as without. */
static void test_calm(void **state)
{
	(void)state;
	struct rve_params params;
	rve_params_default(&params);
	params.pace_calm = 4.0, params.pace_unbalanced = 0.02, params.pace_sliding = 0.05;
	params.n_max = 0;
	struct rve_case c;
	case_start_loose(&c, &params, 100e3);
	static const double strain[4] = {0.0, 3.6, 0.0, 0.0}; /* 1.8e-4 in a call, 4 sub-steps of 5e-5 */
	case_advance(&c, slow, 0.0, dt, 1);                   /* so that the state of the contacts is known */
	print_message("  unbalanced %.3g, sliding %.3g\n", case_info(&c).unbalanced, case_info(&c).sliding_fraction);
	case_advance(&c, strain, 0.0, dt, 1);
	assert_int_equal(case_info(&c).sub_steps, 1);
	case_advance(&c, strain, 0.0, dt, 400);
	struct rve_info info = case_info(&c);
	assert_true(info.sliding_fraction > 0.05 || info.unbalanced > 0.02);
	long long before = info.paced_calls;
	case_advance(&c, strain, 0.0, dt, 1);
	info = case_info(&c);
	assert_true(info.sub_steps >= 4 && info.paced_calls == before);
	case_end(&c);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_error_is_kept),
		cmocka_unit_test(test_counts),
		cmocka_unit_test(test_calm),
	};
	case_path = RVE_SIMD;
	return cmocka_run_group_tests(tests, NULL, NULL);
}
