/* Where the ways between points and nodes fail: the limit of the step under each scheme, noise of points that cross
 * cells, what the nodes do not see of the points' velocities, and the viscosity of PIC.
 *
 * 1. core/mpm/limit.c says that X = (dt w)^2 < 2 is what is safe with USL; that USF and MUSL bear q X < 4, which is at
 *    least c dt/h = 1 wherever the points lie (also with the linear shape, which has no safe step with USL), but for
 * APIC, which gives all back to the nodes (q = 1).  Bounds: so it is, and the guard's limit is above the true one of
 * none.
 * 2. Cell crossing (canonical: L = 25, E = 100, rho = 1, v0 = 0.75 sin(pi x/2L), so that points move by 1.2 cells;
 * MUSL): sigma(X, t) = v0 sqrt(E rho) cos(pi X/2L) sin(c pi t/2L).  With the linear shape the gradient of a point jumps
 * from +1/h to -1/h as it crosses, and its force sigma V/h goes to another node: an error of the order of the stress.
 *    Bound: uGIMP with 4 points per cell within 7% of the largest stress (RMS), linear beyond three times that.  No
 * guard: nothing diverges; a run of the linear shape in which points have crossed ends with a warning.
 * 3. Points have more velocities than nodes.  What of them the nodes do not see, v - S v_I, FLIP keeps for ever, a
 * share a of PIC leaves (1 - a)^n, XPIC(m) and APIC nothing.  Under FLIP it grows with the motion.
 * 4. PIC is a viscosity nu = a h^2/dt (1/6 + l^2/3) (uGIMP, half the domain l h: the second moment of the weights there
 *    and back), which grows as dt falls.  Its Courant number nu dt/h^2 is at most 1/4 for a = 1: no step makes it
 *    unstable. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "../common/elastic_scene.h"
#include "../common/near.h"
#include "../common/shaken_block.h"
#include "mpm/mpm_private.h"

struct scheme {
	const char *name;
	enum mpm_transfer transfer;
	int m;
	double pic;
};

static const struct scheme schemes[] = {
	{"flip", MPM_FLIP, 2, 0.0},    {"pic 0.1", MPM_FLIP, 2, 0.1}, {"pic", MPM_FLIP, 2, 1.0},
	{"xpic(2)", MPM_XPIC, 2, 0.0}, {"xpic(5)", MPM_XPIC, 5, 0.0}, {"fmpm(2)", MPM_FMPM, 2, 0.0},
	{"fmpm(5)", MPM_FMPM, 5, 0.0}, {"apic", MPM_APIC, 2, 0.0},
};
enum { SCHEMES = sizeof schemes / sizeof *schemes };
static const enum mpm_order orders[] = {MPM_USL, MPM_USF, MPM_MUSL};

static void choose(struct scene *scene, const struct scheme *scheme, enum mpm_order order)
{
	scene->mpm.transfer = scheme->transfer, scene->mpm.order = order;
	scene->mpm.xpic_order = scheme->m, scene->mpm.xpic_every = 1;
	scene->mpm.pic_fraction = scheme->pic;
}

/* ---- 1: limits ---- */

static bool grows(const struct shaken_block *block, const struct scheme *scheme, enum mpm_order order, double courant)
{
	struct elastic_scene s;
	struct scene *scene = shaken_scene(&s, block, courant);
	scene->guards.time_step = false;
	choose(scene, scheme, order);
	struct mpm *mpm = start(scene);
	shake(mpm, block);
	double first = 0.0;
	bool grown = false;
	for (int k = 0; k < 400 && !grown; k++) {
		grown = mpm_step(mpm) != STATUS_OK;
		first = k < 4 ? fmax(first, largest_stress(mpm)) : first;
		grown = grown || largest_stress(mpm) > 100.0 * first;
	}
	mpm_free(mpm);
	return grown;
}

/* What the guard of a scheme and order takes for the limit. */
static double guard_limit(const struct shaken_block *block, const struct scheme *scheme, enum mpm_order order)
{
	double low = 0.1, high = 1.2;
	for (int k = 0; k < 8; k++) {
		struct elastic_scene s;
		struct mpm *mpm;
		double middle = sqrt(low * high);
		struct scene *scene = shaken_scene(&s, block, middle);
		choose(scene, scheme, order);
		int status = mpm_create(&mpm, scene);
		bool above = status != STATUS_OK || mpm_work(mpm)->limit.motion > 2.0;
		*(above ? &high : &low) = middle;
		mpm_free(mpm);
	}
	return low;
}

static double true_limit(const struct shaken_block *block, const struct scheme *scheme, enum mpm_order order)
{
	double low = 0.1, high = 2.5;
	for (int k = 0; k < 8; k++) {
		double middle = sqrt(low * high);
		*(grows(block, scheme, order, middle) ? &high : &low) = middle;
	}
	return low;
}

static void test_limit_of_schemes(void **state)
{
	(void)state;
	const struct shaken_block blocks[] = {{"ugimp", 4, 6, 4, {0.02, 0.015}, 0.3, 0.0, 1e-9},
										  {"ugimp", 1, 4, 3, {1e-6, 1e-6}, 0.3, 0.0, 1e-9},
										  {"ugimp", 9, 6, 6, {0.4, 0.4}, 0.3, 0.0, 1e-9},
										  {"linear", 4, 6, 4, {0.26, 0.27}, 0.3, 0.0, 1e-9},
										  {"linear", 1, 4, 3, {0.4, 0.0}, 0.3, 0.0, 1e-9}};
	double least[3] = {INFINITY, INFINITY, INFINITY};
	for (size_t b = 0; b < sizeof blocks / sizeof *blocks; b++) {
		print_message("  %s %d, offset %.2f %.2f, nu = 0.3: true limit (guard's) of c dt/h with usl, usf, musl\n",
					  blocks[b].shape, blocks[b].points_per_cell, blocks[b].offset[0], blocks[b].offset[1]);
		for (int k = 0; k < SCHEMES; k++) {
			print_message("    %-8s", schemes[k].name);
			for (int o = 0; o < 3; o++) {
				double truth = true_limit(&blocks[b], &schemes[k], orders[o]);
				double guard = guard_limit(&blocks[b], &schemes[k], orders[o]);
				print_message("  %.3f (%.3f)", truth, guard);
				assert_true(guard < 1.04 * truth);
				least[o] = fmin(least[o], schemes[k].transfer == MPM_APIC ? INFINITY : truth);
			}
			print_message("\n");
		}
	}
	assert_true(least[0] < 0.15 && least[1] > 1.0 && least[2] > 1.0);
}

/* ---- 2: cell crossing ---- */

/* RMS error of the stress over a period and the bar, over its largest value. */
static double crossing_error(const char *shape, int side, double v0, int *guard)
{
	struct elastic_scene s;
	const double L = 25.0, E = 100.0, pi = acos(-1.0), c = sqrt(E), omega = pi * c / (2.0 * L);
	struct scene *scene = elastic_scene_init(&s, 30, 3, 1.0, E, 0.0, 1.0, 0.01);
	snprintf(scene->mpm.shape, sizeof scene->mpm.shape, "%s", shape);
	scene->mpm.order = MPM_MUSL;
	elastic_scene_box(&s, side * side, 1.0, 1.0, 1.0 + L, 2.0);
	elastic_scene_line(&s, 1.0, 3.0, 1.0, 0.0)->contact = SCENE_WALL_SLIP;
	struct mpm *mpm = start(scene);
	for (int k = 0; k < mpm->p.n; k++)
		mpm->p.v[k][0] = v0 * sin(pi * (mpm->p.x0[k][0] - 1.0) / (2.0 * L));
	double sum = 0.0, n = 0.0;
	*guard = 0;
	while (mpm->time < 2.0 * pi / omega && *guard == 0) {
		if (mpm_step(mpm) != STATUS_OK) {
			*guard = 1;
			break;
		}
		for (int k = 0; k < mpm->p.n && mpm->step % 10 == 0; k++) {
			double exact = v0 * c * cos(pi * (mpm->p.x0[k][0] - 1.0) / (2.0 * L)) * sin(omega * mpm->time);
			double error = (mpm->p.stress[k][0] - exact) / (v0 * c);
			sum += error * error, n += 1.0;
		}
	}
	mpm_free(mpm);
	return sqrt(sum / n);
}

static void test_cell_crossing(void **state)
{
	(void)state;
	double error[2][2];
	int guard;
	print_message("  cell crossing: RMS error of the stress over its amplitude: shape, points per cell, v0\n");
	for (int linear = 0; linear < 2; linear++)
		for (int fast = 0; fast < 2; fast++)
			for (int side = 1; side <= 2; side++) {
				error[linear][fast] = crossing_error(linear ? "linear" : "ugimp", side, fast ? 0.75 : 0.1, &guard);
				print_message("    %s %d, %.2f: %.3f%s\n", linear ? "linear" : "ugimp", side * side, fast ? 0.75 : 0.1,
							  error[linear][fast], guard ? " until stopped by a guard" : "");
			}
	assert_true(error[0][0] < 0.07 && error[0][1] < 0.07);
	assert_true(error[1][0] < 0.07); /* nothing crosses */
	assert_true(error[1][1] > 3.0 * error[0][1]);
}

/* ---- 3: what the nodes do not see ---- */

/* Energy of v - S v_I over all kinetic energy, with the weights as they are now. */
static double unseen(struct mpm *mpm)
{
	struct shape_lists lists;
	const struct mpm_work *w = mpm_work(mpm);
	double hidden = 0.0, all = 0.0;
	mpm_sort(mpm);
	mpm_clear_grid(mpm);
	mpm_points_to_grid(mpm);
	for (int i = 0; i < w->n_inside; i++) {
		int p = w->order[i];
		double v[2] = {0.0, 0.0};
		mpm_lists(mpm, 1, &p, &lists);
		for (int a = 0; a < lists.nodes; a++)
			for (int c = 0; c < 2; c++)
				if (w->sums[lists.node[a][0]].mass > 0.0)
					v[c] += lists.weight[a][0] * w->sums[lists.node[a][0]].momentum[c] / w->sums[lists.node[a][0]].mass;
		for (int c = 0; c < 2; c++) {
			hidden += pow(mpm->p.v[p][c] - v[c], 2.0);
			all += pow(mpm->p.v[p][c], 2.0);
		}
	}
	return hidden / all;
}

/* A block whose points move against each other in each cell, +-v in turn: momentum zero at every node, by symmetry. */
static void test_unseen_velocities(void **state)
{
	(void)state;
	print_message("  velocities that no node sees, after 100 steps: scheme: share left\n");
	for (int k = 0; k < SCHEMES; k++) {
		struct elastic_scene s;
		struct scene *scene = elastic_scene_init(&s, 12, 12, 1.0, 1.0, 0.0, 1.0, 0.2);
		snprintf(scene->mpm.shape, sizeof scene->mpm.shape, "linear");
		choose(scene, &schemes[k], MPM_USL);
		elastic_scene_box(&s, 4, 3.0, 3.0, 9.0, 9.0);
		struct mpm *mpm = start(scene);
		for (int p = 0; p < mpm->p.n; p++) {
			int i = (int)(2.0 * mpm->p.x[p][0]) % 2, j = (int)(2.0 * mpm->p.x[p][1]) % 2;
			mpm->p.v[p][0] = (i == j ? 1.0 : -1.0) * 1e-6;
		}
		double before = 0.0, after = 0.0;
		for (int p = 0; p < mpm->p.n; p++)
			before += pow(mpm->p.v[p][0], 2.0);
		steps(mpm, 100);
		for (int p = 0; p < mpm->p.n; p++)
			after += pow(mpm->p.v[p][0], 2.0);
		double left = sqrt(after / before);
		print_message("    %-8s %.3g\n", schemes[k].name, left);
		double kept = schemes[k].transfer == MPM_FLIP ? pow(1.0 - schemes[k].pic, 100.0) : 0.0;
		assert_near(left, kept, 0.01); /* the rest is strain that points off the cells' middle have felt */
		mpm_free(mpm);
	}
}

/* A block that is sheared to and fro: what the nodes do not see grows under FLIP until it is a good part of what is
 * left of the motion; schemes that forget it have none. */
static void test_unseen_grows(void **state)
{
	(void)state;
	double share[SCHEMES];
	print_message("  a block that is sheared to and fro: share of the kinetic energy that no node sees, energy left\n");
	for (int k = 0; k < SCHEMES; k++) {
		struct elastic_scene s;
		struct scene *scene = elastic_scene_init(&s, 20, 20, 1.0, 1.0, 0.3, 1.0, 0.2);
		choose(scene, &schemes[k], MPM_USL);
		s.laws[0].thermoelastic.neo_hookean = true;
		elastic_scene_box(&s, 4, 6.0, 6.0, 14.0, 14.0);
		struct mpm *mpm = start(scene);
		for (int p = 0; p < mpm->p.n; p++) {
			mpm->p.v[p][0] = 0.2 * sin((mpm->p.x[p][1] - 6.0) * acos(-1.0) / 4.0);
			mpm->p.v[p][1] = 0.2 * sin((mpm->p.x[p][0] - 6.0) * acos(-1.0) / 4.0);
		}
		steps(mpm, 1000);
		share[k] = unseen(mpm);
		mpm_measure(mpm);
		double left = (mpm->ledger.energy_kinetic + mpm->ledger.energy_elastic) / (0.5 * 0.2 * 0.2 * 64.0);
		print_message("    %-8s %.3g, %.3g\n", schemes[k].name, share[k], left);
		mpm_free(mpm);
	}
	assert_true(share[0] > 0.1);
	for (int k = 3; k < SCHEMES; k++)
		assert_true(share[k] < 0.1 * share[0]);
}

/* ---- 4: the viscosity of PIC ---- */

static void test_viscosity_of_pic(void **state)
{
	(void)state;
	const double pi = acos(-1.0), length = 32.0;
	print_message("  viscosity of PIC over a h^2/dt: points per cell, a, dt: measured (theory)\n");
	for (int side = 1; side <= 4; side++)
		for (int k = 0; k < 4; k++) {
			struct elastic_scene s;
			const double pic = k < 2 ? 0.1 : k < 3 ? 0.5 : 1.0, dt = k % 2 ? 0.5 : 0.05, l = 0.5 / side;
			struct scene *scene = elastic_scene_init(&s, 38, 5, 1.0, 1e-9, 0.0, 1.0, dt);
			scene->mpm.pic_fraction = pic;
			elastic_scene_box(&s, side * side, 3.0, 2.0, 3.0 + length, 3.0);
			struct mpm *mpm = start(scene);
			double first = 0.0, last = 0.0;
			for (int p = 0; p < mpm->p.n; p++) {
				double wave = cos(2.0 * pi * (mpm->p.x[p][0] - 3.0) / length);
				mpm->p.v[p][1] = 1e-9 * wave;
				first += mpm->p.v[p][1] * wave;
			}
			int n = (int)(30.0 / pic);
			steps(mpm, n);
			for (int p = 0; p < mpm->p.n; p++)
				last += mpm->p.v[p][1] * cos(2.0 * pi * (mpm->p.x0[p][0] - 3.0) / length);
			double nu = log(first / last) / (n * dt * pow(2.0 * pi / length, 2.0)), unit = pic / dt;
			double theory = 1.0 / 6.0 + l * l / 3.0;
			print_message("    %2d, %.1f, %.2f: %.4f (%.4f)\n", side * side, pic, dt, nu / unit, theory);
			assert_near(nu / unit / theory, 1.0, 0.03);
			mpm_free(mpm);
		}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_limit_of_schemes),  cmocka_unit_test(test_cell_crossing),
		cmocka_unit_test(test_unseen_velocities), cmocka_unit_test(test_unseen_grows),
		cmocka_unit_test(test_viscosity_of_pic),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
