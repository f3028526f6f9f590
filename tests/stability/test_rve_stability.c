/* Where the DEM's explicit integration is stable, and what happens where it is not. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include "../common/near.h"
#include "../common/rve_case.h"

static const double rest[4] = {0};

/* Kinetic energy / elastic energy some time after a knock, with dt_DEM = dt; infinite if a guard fired. */
static double unrest_after_a_knock(double dt)
{
	struct rve_params params;
	struct rve_case c;
	struct rve_packing *packing = case_packing(100e3, 0.01, 1);
	rve_params_default(&params);
	double r_min = packing->r[0];
	for (int i = 0; i < packing->n_discs; i++)
		r_min = fmin(r_min, packing->r[i]);
	params.step_factor = dt / (r_min * sqrt(3.14159265358979324 * params.grain_density * params.thickness / params.kn));
	params.n_max = 1;
	params.step_guard = 0;
	case_start(&c, &params, packing);
	rve_packing_free(packing);
	assert_near(rve_time_step(c.model) / dt, 1.0, 1e-9);
	const double knock[4] = {1.0, 0.0, 0.0, -1.0};
	double unrest = INFINITY;
	int status = case_try(&c, knock, 0.0, 1e-5);
	for (int k = 0; k < 3000 && status == STATUS_OK; k++)
		status = case_try(&c, rest, 0.0, 1e-4);
	struct rve_info info = case_info(&c);
	if (status == STATUS_OK)
		unrest = info.kinetic / info.elastic;
	case_end(&c);
	return unrest;
}

/* The critical step of dense packings is 3.5e-6 s, a few percent more or less from one to the next (0.57 to 0.62
 * sqrt(m_min / kn)); the default is 2.5e-6 s.  Energies half a step apart are of either sign in an alternating motion.
 */
static void test_critical_time_step(void **arg)
{
	(void)arg;
	double below = unrest_after_a_knock(3.25e-6), above = unrest_after_a_knock(4e-6);
	print_message("  kinetic / elastic energy: %.1e at 3.25e-6 s, %.1e at 4e-6 s\n", below, above);
	assert_true(fabs(below) < 1e-8);
	assert_true(fabs(above) > 1e-3);
	struct rve_params params;
	struct rve_case c;
	rve_params_default(&params);
	case_start_loose(&c, &params, 100e3);
	assert_near(rve_time_step(c.model), 2.5e-6, 0.05e-6);
	case_end(&c);
}

/* Squeezed beyond what the contacts describe, the RVE stops with its number, its value and a cure. */
static void test_overlap_guard(void **arg)
{
	(void)arg;
	struct rve_params params;
	struct rve_case c;
	rve_params_default(&params);
	params.n_max = 0;
	case_start_loose(&c, &params, 100e3);
	const double squeeze[4] = {-1.0, 0.0, 0.0, -1.0};
	int status = STATUS_OK, calls = 0;
	while (status == STATUS_OK && calls++ < 400)
		status = case_try(&c, squeeze, 0.0, 1e-3);
	assert_int_equal(status, STATUS_GUARD);
	assert_non_null(strstr(error_message(), "RVE 0"));
	assert_non_null(strstr(error_message(), "smaller radius"));
	assert_non_null(strstr(error_message(), "smaller time step"));
	assert_true(case_info(&c).max_overlap > params.overlap_max);
	assert_true(case_info(&c).max_overlap < 1.2 * params.overlap_max);
	case_end(&c);
}

/* Whatever the surrounding motion throws at it: an error, never a crash or a hang. */
static void test_senseless_motion(void **arg)
{
	(void)arg;
	const double motions[6][4] = {{NAN, 0.0, 0.0, 0.0},  {0.0, INFINITY, 0.0, 0.0}, {-1e5, 0.0, 0.0, -1e5},
								  {1e6, 0.0, 0.0, -1e6}, {0.0, 1e7, 0.0, 0.0},      {1e300, 0.0, 0.0, 1e300}};
	struct rve_params params;
	rve_params_default(&params);
	for (int k = 0; k < 6; k++) {
		struct rve_case c;
		case_start_loose(&c, &params, 100e3);
		int status = STATUS_OK;
		for (int call = 0; call < 5 && status == STATUS_OK; call++)
			status = case_try(&c, motions[k], 0.0, 1e-3);
		assert_int_equal(status, STATUS_GUARD);
		assert_non_null(strstr(error_message(), k < 2 ? "not finite" : "in one step"));
		case_end(&c);
	}
}

/* Discs pushed into one another at one blow leave no list of neighbours, and no state to go on from. */
static void test_crowded_cell(void **arg)
{
	(void)arg;
	struct rve_params params;
	struct rve_case c;
	rve_params_default(&params);
	case_start_loose(&c, &params, 100e3);
	const double squeeze[4] = {-900.0, 0.0, 0.0, -900.0};
	assert_int_equal(case_try(&c, squeeze, 0.0, 1e-3), STATUS_GUARD);
	assert_non_null(strstr(error_message(), "more neighbours"));
	assert_true(isnan(c.stress[0]));
	case_end(&c);
}

/* The lowest failing member of a batch is named, whatever thread found it. */
static void test_failed_member_is_named(void **arg)
{
	(void)arg;
	enum { N = 6 };
	struct rve_params params;
	struct rve_case c;
	rve_params_default(&params);
	case_start_loose(&c, &params, 100e3);
	size_t bytes = rve_state_bytes(c.model);
	unsigned char *states = aligned_alloc(64, N * bytes);
	double L[N][4] = {{0}}, dT[N] = {0}, stress[N][4], heat[N], conductivity[N][3], modulus[N];
	for (int k = 0; k < N; k++)
		rve_init(c.model, 0, states + (size_t)k * bytes);
	L[2][0] = L[4][1] = NAN;
	struct rve_batch batch = {.n = N,
							  .states = states,
							  .L = (const double(*)[4])L,
							  .dT = dT,
							  .dt = 1e-3,
							  .stress = stress,
							  .heat = heat,
							  .conductivity = conductivity,
							  .modulus = modulus};
	assert_int_equal(rve_advance(c.model, &batch), STATUS_GUARD);
	assert_int_equal(batch.failed, 2);
	assert_non_null(strstr(error_message(), "RVE 2"));
	free(states);
	case_end(&c);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_critical_time_step),     cmocka_unit_test(test_overlap_guard),
		cmocka_unit_test(test_senseless_motion),       cmocka_unit_test(test_crowded_cell),
		cmocka_unit_test(test_failed_member_is_named),
	};
	return CASE_RUN_ON_EACH_PATH(tests);
}
