/* The thermal step, found by walking past it: random temperatures on a free block that stands still.
 *
 * Theory.  Between two remappings the nodes' temperatures obey dT/dt = - A T, and an explicit pass is stable while
 * dt times the largest eigenvalue of A is below 2.  For the lumped Q4 element that is dt <= rho c h^2/2k, whatever the
 * mesh's size: with D = k dt/(rho c h^2), D <= 1/2.  In MPM the points carry the temperature, and a mode
 * that they cannot carry (Q < 1, see core/mpm/limit.c) is forgotten: in a single pass QA counts, whose largest
 * eigenvalue is 3/2 of D instead of 4 D for many points and a linear shape (D <= 4/3), and the nodes with little mass
 * are tamed.  Several passes in one step iterate A itself, and there a node that a point has just begun to touch makes
 * any step unstable: the failing region that the guard rho c h^2/2k alone does not see.
 *
 * Bounds asserted: D = 1/2 is safe in a single pass wherever the points lie; in several passes the guard's limit is
 * nowhere above the true one (and where small nodes decide, little below it; a mode that the points forget at the end
 * of the step may be worth a factor of three). */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "../common/elastic_scene.h"
#include "../common/near.h"
#include "mpm/mpm_private.h"

struct lattice {
	const char *shape;
	int side; /* points per side of a cell */
	double offset[2];
	int passes, every;
	double drift; /* cells per thermal step */
};

/* rho c = h = 1, k = D of one pass with a step of 1. */
static struct scene *warm_block(struct elastic_scene *s, const struct lattice *l, double D)
{
	double x = 3.0 + l->offset[0], y = 3.0 + l->offset[1];
	double step = (double)l->passes / l->every;
	struct scene *scene = elastic_scene_init(s, l->drift > 0.0 ? 16 : 10, 9, 1.0, 1e-12, 0.0, 1.0, step);
	snprintf(scene->mpm.shape, sizeof scene->mpm.shape, "%s", l->shape);
	elastic_scene_heat(s, 0.0, 1.0, D);
	scene->time.thermal_steps = l->passes, scene->time.thermal_every = l->every;
	struct scene_body *body = elastic_scene_box(s, l->side * l->side, x, y, x + 3.0, y + 2.0);
	body->lattice_origin[0] = l->offset[0], body->lattice_origin[1] = l->offset[1];
	body->velocity[0] = l->drift / l->passes;
	return scene;
}

static double spread(const struct mpm *mpm)
{
	double low = INFINITY, high = -INFINITY;
	for (int k = 0; k < mpm->p.n; k++)
		low = fmin(low, mpm->p.T[k]), high = fmax(high, mpm->p.T[k]);
	return high - low;
}

static void warm_at_random(struct mpm *mpm)
{
	unsigned long long random = 12345;
	for (int k = 0; k < mpm->p.n; k++) {
		random = random * 6364136223846793005ULL + 1442695040888963407ULL;
		mpm->p.T[k] += (double)(random >> 33) / 2147483648.0;
	}
}

/* Does the span of the temperatures grow?  Heat can only even them out. */
static bool grows(const struct lattice *l, double D)
{
	struct elastic_scene s;
	struct scene *scene = warm_block(&s, l, D);
	scene->guards.thermal_step = false;
	struct mpm *mpm = start(scene);
	warm_at_random(mpm);
	double first = spread(mpm);
	bool grown = false;
	for (int k = 0; k < 300 * l->every && !grown; k++)
		grown = mpm_step(mpm) != STATUS_OK || !(spread(mpm) < 10.0 * first);
	mpm_free(mpm);
	return grown;
}

static bool guarded(const struct lattice *l, double D)
{
	struct elastic_scene s;
	struct mpm *mpm;
	if (mpm_create(&mpm, warm_block(&s, l, D)) != STATUS_OK)
		return true;
	mpm_free(mpm);
	return false;
}

static double limit_of(const struct lattice *l, bool (*above)(const struct lattice *, double))
{
	double low = 1e-3, high = 8.0;
	for (int k = 0; k < 10; k++) {
		double middle = sqrt(low * high);
		*(above(l, middle) ? &high : &low) = middle;
	}
	return low;
}

static const double offsets[] = {0.0, 0.02, 0.1, 0.26, 0.4};

/* One pass for each step, and one pass every three steps. */
static void test_single_pass(void **state)
{
	(void)state;
	double least = INFINITY;
	print_message("  single passes: true limit of D = k dt/(rho c h^2) by offset (guard: 0.5)\n");
	for (int every = 1; every <= 3; every += 2)
		for (int linear = 0; linear < 2; linear++)
			for (int side = 1; side <= 3; side++) {
				print_message("    %s %d, every %d:", linear ? "linear" : "ugimp ", side * side, every);
				for (int k = 0; k < 5; k++) {
					struct lattice l = {
						linear ? "linear" : "ugimp", side, {offsets[k], 0.7 * offsets[k]}, 1, every, 0.0};
					double truth = limit_of(&l, grows);
					print_message("  %.2f: %.3f", offsets[k], truth);
					assert_near(limit_of(&l, guarded), 0.5, 0.005);
					least = fmin(least, truth);
				}
				print_message("\n");
			}
	print_message("  least: %.3f\n", least);
	assert_true(least > 0.5);
}

static void test_several_passes(void **state)
{
	(void)state;
	double narrow = INFINITY, least = INFINITY;
	print_message("  20 passes in a step: true limit / guard's limit of D by offset\n");
	for (int linear = 0; linear < 2; linear++)
		for (int side = 1; side <= 3; side++) {
			print_message("    %s %d:", linear ? "linear" : "ugimp ", side * side);
			for (int k = 0; k < 5; k++) {
				struct lattice l = {linear ? "linear" : "ugimp", side, {offsets[k], 0.7 * offsets[k]}, 20, 1, 0.0};
				double truth = limit_of(&l, grows), guard = limit_of(&l, guarded);
				print_message("  %.2f: %.3f/%.3f", offsets[k], truth, guard);
				assert_true(guard < 1.02 * truth);
				narrow = fmin(narrow, guard / truth), least = fmin(least, truth);
			}
			print_message("\n");
		}
	print_message("  least true limit %.3f; the guard's is at least %.2f of the true one\n", least, narrow);
	assert_true(narrow > 0.25);
	assert_true(least < 0.2); /* a failing region that rho c h^2/2k does not see */
}

/* A block that drifts from a safe place of the lattice to one where its passes are unstable. */
static void test_guard_comes_first(void **state)
{
	(void)state;
	const struct lattice l = {"ugimp", 1, {0.5, 0.0}, 20, 1, 0.005};
	for (int guard = 0; guard < 2; guard++) {
		struct elastic_scene s;
		struct scene *scene = warm_block(&s, &l, 0.46);
		scene->guards.thermal_step = guard;
		struct mpm *mpm = start(scene);
		warm_at_random(mpm);
		double first = spread(mpm), most = 0.0;
		int status = STATUS_OK;
		for (int k = 0; k < 200 && status == STATUS_OK; k++) {
			status = mpm_step(mpm);
			most = fmax(most, spread(mpm) / first);
		}
		print_message("  %s guard: the temperatures' span grows to %.3g of what it was\n", guard ? "with" : "without",
					  most);
		if (guard) {
			assert_int_equal(status, STATUS_GUARD);
			assert_non_null(strstr(error_message(), "too few for heat conduction"));
			assert_non_null(strstr(error_message(), "cure: time.thermal_steps = "));
			print_message("    %s\n", error_message());
			assert_true(most < 1.5);
		} else {
			assert_true(!(most < 100.0));
		}
		mpm_free(mpm);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_single_pass),
		cmocka_unit_test(test_several_passes),
		cmocka_unit_test(test_guard_comes_first),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
