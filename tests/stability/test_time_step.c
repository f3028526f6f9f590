/* The mechanical time step of explicit MPM (order USL, FLIP), found by walking past it.
 *
 * Theory (core/mpm/limit.c): a mode with (dt w)^2 = X that only one point carries is stable below X = 2, one of many
 * points below X = 4/(2 - q) <= 4.  For one point by itself in one direction X = (c dt/h)^2 S with
 *     S = sum_I h^2 w_I,x^2 / w_I:  linear 1/f + 1/(1-f);  uGIMP in the middle of its cells, |f| < l: 2/l +
 * (f/l)^2/w_mid, and in two directions (1 + r) S on the diagonal, r = nu/(1-nu).  So c dt/h < sqrt(2 / ((1 + r) S)):
 * for uGIMP with 4 points per cell between 0.39 and 0.5 (nu = 0.3), for the linear shape anything down to zero.  h/c
 * itself, the limit of eq. 30, is never safe.
 *
 * Bound asserted: the guard's limit is at no place of the lattice above the true one (the step at which a random shake
 * grows), and not below 0.65 of it. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#include <cmocka.h>

#include "../common/elastic_scene.h"
#include "../common/near.h"
#include "../common/shaken_block.h"
#include "mpm/mpm_private.h"

/* Does a weak shake grow a hundred times over in 400 steps? */
static bool grows(const struct shaken_block *b, double courant)
{
	struct elastic_scene s;
	struct scene *scene = shaken_scene(&s, b, courant);
	scene->guards.time_step = false;
	struct mpm *mpm = start(scene);
	shake(mpm, b);
	double first = 0.0;
	bool grown = false;
	for (int k = 0; k < 400 && !grown; k++) {
		grown = mpm_step(mpm) != STATUS_OK;
		if (k < 4)
			first = fmax(first, largest_stress(mpm));
		grown = grown || largest_stress(mpm) > 100.0 * first;
	}
	mpm_free(mpm);
	return grown;
}

/* Is the step above what the guard takes for the limit? */
static bool guarded(const struct shaken_block *b, double courant)
{
	struct elastic_scene s;
	struct mpm *mpm;
	if (mpm_create(&mpm, shaken_scene(&s, b, courant)) != STATUS_OK)
		return true;
	bool above = mpm_work(mpm)->limit.motion > 2.0;
	mpm_free(mpm);
	return above;
}

static double limit_of(const struct shaken_block *b, bool (*above)(const struct shaken_block *, double))
{
	double low = 0.02, high = 1.2;
	for (int k = 0; k < 9; k++) {
		double middle = sqrt(low * high);
		*(above(b, middle) ? &high : &low) = middle;
	}
	return low;
}

/* One point by itself: the closed form. */
static void test_lone_point(void **state)
{
	(void)state;
	print_message("  one point, c dt/h: shape, points per cell, place, nu: true, theory, guard\n");
	for (int linear = 0; linear < 2; linear++)
		for (int k = 0; k < 6; k++) {
			const double f = (k / 2 + 0.5) / 6.0 * (linear ? 1.0 : 0.5), nu = k % 2 ? 0.3 : 0.0; /* place, cells */
			struct shaken_block b = {.shape = linear ? "linear" : "ugimp",
									 .points_per_cell = 4,
									 .columns = 1,
									 .rows = 1,
									 .offset = {f - 0.25, f - 0.25},
									 .poisson = nu,
									 .shake = 1e-9};
			const double l = 0.25, middle = 1.0 - (f * f + l * l) / (2.0 * l);
			double S = linear ? 1.0 / f + 1.0 / (1.0 - f) : 2.0 / l + f * f / (l * l) / middle;
			double theory = sqrt(2.0 / (S * (1.0 + nu / (1.0 - nu))));
			double truth = limit_of(&b, grows), guard = limit_of(&b, guarded);
			print_message("    %s 4, %.3f, %.1f: %.3f, %.3f, %.3f\n", b.shape, f, nu, truth, theory, guard);
			assert_near(truth / theory, 1.0, 0.03);
			assert_near(guard / theory, 1.0, 0.03);
		}
}

/* Blocks on a shifted lattice: their edges and corners decide. */
static void test_blocks(void **state)
{
	(void)state;
	const double offsets[] = {1e-6, 0.02, 0.1, 0.26, 0.4};
	static const char *const names[] = {"ugimp", "linear", "cpdi"};
	double least[3] = {9.0, 9.0, 9.0}, narrow = 9.0;
	print_message("  blocks, nu = 0.3: shape, points per cell: true limit / guard's limit of c dt/h by offset\n");
	for (int shape = 0; shape < 3; shape++)
		for (int side = 1; side <= 4; side++) {
			print_message("    %-6s %2d:", names[shape], side * side);
			for (int k = 0; k < 5; k++) {
				struct shaken_block b = {.shape = names[shape],
										 .points_per_cell = side * side,
										 .columns = 3 * side,
										 .rows = 2 * side,
										 .offset = {offsets[k], 0.7 * offsets[k]},
										 .poisson = 0.3,
										 .shake = 1e-9};
				double truth = limit_of(&b, grows), guard = limit_of(&b, guarded);
				print_message("  %.2f: %.3f/%.3f", offsets[k], truth, guard);
				assert_true(guard < 1.02 * truth);
				least[shape] = fmin(least[shape], truth);
				narrow = fmin(narrow, guard / truth);
			}
			print_message("\n");
		}
	print_message("  least true limit: ugimp %.3f, linear %.3f, cpdi %.3f; the guard's is at least %.2f of the "
				  "true one\n",
				  least[0], least[1], least[2], narrow);
	assert_true(narrow > 0.65);
	assert_true(least[0] < 0.55 && least[1] < 0.3); /* h/c is a failing region, and was not guarded */
}

/* Drifts with all guards but `time_step` off; the status, and the largest stress over the first one. */
static int drift(const struct shaken_block *b, double courant, bool time_step, double created, double *growth)
{
	struct elastic_scene s;
	struct scene *scene = shaken_scene(&s, b, courant);
	scene->guards = (struct scene_guards){.points_leaving = true, .time_step = time_step, .energy_created = created};
	struct mpm *mpm = start(scene);
	shake(mpm, b);
	double first = 0.0;
	int status = STATUS_OK;
	*growth = 0.0;
	for (int k = 0; k < 1500 && status == STATUS_OK && *growth < 1e4; k++) {
		status = mpm_step(mpm);
		if (k < 20)
			first = fmax(first, largest_stress(mpm));
		*growth = largest_stress(mpm) / first;
	}
	mpm_free(mpm);
	return status;
}

/* A block that starts where its step is safe and drifts to where it is not: without the guards its stress explodes;
 * with them the run stops while the stress is what it was, and can be saved. */
static void test_guard_comes_first(void **state)
{
	(void)state;
	const struct {
		struct shaken_block block;
		double courant;
	} cases[] = {
		{{"ugimp", 16, 8, 8, {0.45, 0.45}, 0.0, 0.002, 1e-4}, 0.56},
		{{"linear", 4, 6, 4, {0.1, 0.1}, 0.3, 0.005, 1e-4}, 0.3},
		{{"linear", 4, 6, 4, {0.1, 0.1}, 0.3, 0.001, 1e-4}, 0.1},
	};
	for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
		double off, on, late;
		drift(&cases[k].block, cases[k].courant, false, 0.0, &off);
		int status = drift(&cases[k].block, cases[k].courant, true, 0.0, &on);
		char message[512];
		snprintf(message, sizeof message, "%s", error_message());
		int second = drift(&cases[k].block, cases[k].courant, false, 0.25, &late);
		print_message(
			"  %s %d, c dt/h = %.2f: stress grows to %.3g without guards, %.3g at the guard of the step, %.3g at "
			"that of the energy\n    %s\n",
			cases[k].block.shape, cases[k].block.points_per_cell, cases[k].courant, off, on, late, message);
		assert_true(off > 1e3);
		assert_int_equal(status, STATUS_GUARD);
		assert_non_null(strstr(message, "as they lie in their grid cells"));
		assert_non_null(strstr(message, "cure: "));
		assert_non_null(strstr(message, "state: start of the step"));
		assert_true(on < 10.0);
		assert_int_equal(second, STATUS_GUARD);
		assert_non_null(strstr(error_message(), "made"));
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_lone_point),
		cmocka_unit_test(test_blocks),
		cmocka_unit_test(test_guard_comes_first),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
