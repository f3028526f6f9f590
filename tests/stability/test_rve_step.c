/* The DEM step, found by walking past it: a packing that is knocked once comes to rest, or its discs turn about in
 * every step from then on.
 *
 * Theory.  Leapfrog is stable while dt w < 2, w being the fastest motion of any disc.  With dt = f sqrt(m_min/kn): a
 * disc that rolls on z tangential springs has w^2 = 2 z ks/m (its neighbours make it more), so f falls as sqrt(kn/ks);
 * a dashpot of the ratio zeta takes a motion along the normals to f (sqrt(1 + zeta^2) - zeta).  Measured here: 0.56
 * sqrt(kn/ks) or 0.7 (sqrt(1 + zeta^2) - zeta), whichever is less; rve_step_factor_limit() stays 4% to 25% below.  The
 * default 0.4 is unstable with ks = 2 kn or zeta = 1, which nothing said before.
 *
 * What it looks like: the mean pressure of a cell stays right for long, while friction heat becomes negative; the
 * kinetic energy between two half steps is negative at once, and that is what the guard looks at. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include "../common/near.h"
#include "../common/rve_case.h"

static const double rest[4] = {0}, knock[4] = {1.0, 0.0, 0.0, -1.0};

struct contact_kind {
	double pressure, mu; /* of the packing */
	double ks, zeta;     /* ks over kn */
};

static void start_kind(struct rve_case *c, const struct contact_kind *kind, double factor, int guard)
{
	struct rve_params params;
	struct rve_packing *packing = case_packing(kind->pressure, kind->mu, 1);
	rve_params_default(&params);
	params.ks *= kind->ks;
	params.damping_ratio = kind->zeta;
	params.step_factor = factor;
	params.step_guard = guard;
	case_start(c, &params, packing);
	rve_packing_free(packing);
}

/* Is there unrest some time after a knock? */
static int jitters(const struct contact_kind *kind, double factor)
{
	struct rve_case c;
	start_kind(&c, kind, factor, 0);
	int status = case_try(&c, knock, 0.0, 1e-5);
	for (int k = 0; k < 2500 && status == STATUS_OK; k++)
		status = case_try(&c, rest, 0.0, 1e-4);
	struct rve_info info = case_info(&c);
	case_end(&c);
	return status != STATUS_OK || info.kinetic < -1e-7 * info.elastic;
}

static double critical_factor(const struct contact_kind *kind)
{
	double low = 0.1, high = 1.2;
	for (int k = 0; k < 6; k++) {
		double middle = sqrt(low * high);
		*(jitters(kind, middle) ? &high : &low) = middle;
	}
	return low;
}

static void test_critical_factor(void **state)
{
	(void)state;
	const struct contact_kind kinds[] = {
		{100e3, 0.01, 1.0, 0.2}, {100e3, 0.5, 1.0, 0.2},  {10e3, 0.5, 1.0, 0.2},
		{100e3, 0.01, 0.3, 0.2}, {100e3, 0.01, 2.0, 0.2}, {100e3, 0.5, 4.0, 0.2},
		{100e3, 0.01, 1.0, 0.0}, {100e3, 0.01, 1.0, 0.5}, {100e3, 0.01, 1.0, 1.0},
	};
	print_message("  packing (kPa, mu), ks/kn, zeta: critical factor, theory, guard\n");
	for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
		const struct contact_kind *kind = &kinds[k];
		struct rve_params params;
		rve_params_default(&params);
		params.ks *= kind->ks, params.damping_ratio = kind->zeta;
		double truth = critical_factor(kind), guard = rve_step_factor_limit(&params);
		double theory = fmin(0.56 / sqrt(kind->ks), 0.7 * (sqrt(1.0 + kind->zeta * kind->zeta) - kind->zeta));
		print_message("    %.0f %.2f, %.1f, %.1f: %.3f, %.3f, %.3f\n", 1e-3 * kind->pressure, kind->mu, kind->ks,
					  kind->zeta, truth, theory, guard);
		assert_true(guard < truth);
		assert_true(guard > 0.65 * truth);
	}
}

/* A step that is too large is refused before anything is made. */
static void test_refused(void **state)
{
	(void)state;
	struct rve_params params;
	struct rve_model *model;
	rve_params_default(&params);
	params.ks *= 2.0;
	struct rve_packing *packing = case_packing(100e3, 0.5, 1);
	const struct rve_packing *const packings[1] = {packing};
	assert_int_equal(rve_model_create(&model, &params, 1, packings), STATUS_INPUT);
	assert_non_null(strstr(error_message(), "ks/kn = 2"));
	assert_non_null(strstr(error_message(), "cure: step_factor = 0.35"));
	rve_packing_free(packing);
}

struct walk {
	int status, calls;
	double pressure; /* Pa, at the end */
	double friction; /* over work */
};

/* At rest after a knock, or sheared by 0.1, with the guard of the running cell alone (that of the model would refuse).
 */
static struct walk go(double factor, int sheared, int guard)
{
	const struct contact_kind dense = {100e3, 0.01, 1.0, 0.2};
	const double shear[4] = {0.0, 1.0, 0.0, 0.0};
	struct walk walk = {STATUS_OK, 0, 0.0, 0.0};
	struct rve_case c;
	start_kind(&c, &dense, factor, 0);
	c.model->params.step_guard = guard;
	walk.status = case_try(&c, knock, 0.0, 1e-5);
	for (; walk.calls < (sheared ? 100 : 3000) && walk.status == STATUS_OK; walk.calls++)
		walk.status = case_try(&c, sheared ? shear : rest, 0.0, sheared ? 1e-3 : 1e-4);
	struct rve_info info = case_info(&c);
	walk.pressure = info.pressure;
	walk.friction = info.friction / info.work;
	case_end(&c);
	return walk;
}

/* Beyond the limit the guard of the running cell stops it while pressure and friction heat are right; without it the
 * friction heat becomes negative, many times the work. */
static void test_guard_comes_first(void **state)
{
	(void)state;
	for (int sheared = 0; sheared < 2; sheared++) {
		struct walk right = go(0.4, sheared, 1), off = go(0.8, sheared, 0), on = go(0.8, sheared, 1);
		char message[256];
		snprintf(message, sizeof message, "%s", error_message());
		print_message(
			"  %s: friction / work %.3f; at twice the step %.3f, pressure %.3g; guard after %d calls, %.5f, %.3g "
			"Pa\n    %s\n",
			sheared ? "sheared" : "at rest", right.friction, off.friction, off.pressure, on.calls, on.friction,
			on.pressure, message);
		assert_int_equal(right.status, STATUS_OK);
		assert_true(off.status == STATUS_OK && off.friction < -1.0);
		assert_int_equal(on.status, STATUS_GUARD);
		assert_non_null(strstr(message, "turn about in every DEM step"));
		assert_non_null(strstr(message, "smaller step_factor"));
		assert_near(on.pressure, 100e3, 3e3);
		assert_true(fabs(on.friction) < 0.05);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_critical_factor),
		cmocka_unit_test(test_refused),
		cmocka_unit_test(test_guard_comes_first),
	};
	return CASE_RUN_ON_EACH_PATH(tests);
}
