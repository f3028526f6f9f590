/* The vectorised passes of the MPM (mpm/kernel.h): the bits of plain loops over the points, and the same on every
 * instruction set. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "../common/elastic_scene.h"
#include "../common/near.h"
#include "mpm/mpm.h"
#include "mpm/point.h"
#include "rve/model.h"

enum { KINDS = 11 };

/* Two blocks, one of which turns, that meet; each kind asks for other parts of the passes. */
static struct scene *kind_of_scene(struct elastic_scene *s, const char *shape, int kind)
{
	struct scene *scene = elastic_scene_init(s, 24, 14, 0.1, 1e5, 0.3, 1000.0, 1e-3);
	snprintf(scene->mpm.shape, sizeof scene->mpm.shape, "%s", shape);
	scene->guards.time_step = scene->guards.numerical_fracture = false;
	s->laws[0].thermoelastic.neo_hookean = true;
	s->laws[0].thermoelastic.expansion = 1e-4;
	s->materials[0].conductivity = 2.0, s->materials[0].heat_capacity = 0.5;
	scene->gravity[1] = -9.81;
	elastic_scene_box(s, 4, 0.33, 0.31, 0.97, 0.8)->velocity[0] = 2.0;
	struct scene_body *other = elastic_scene_box(s, 9, 1.1, 0.42, 1.7, 0.9);
	other->velocity[0] = -1.5, other->temperature = 310.0;
	scene->thermal.on = kind >= 1 && kind <= 3;
	if (kind == 2) { /* imposed temperatures and heat through points */
		elastic_scene_boundary(s, 0.3, 0.3, 0.5, 0.9)->temperature = 350.0;
		struct scene_boundary *b = elastic_scene_boundary(s, 1.4, 0.3, 1.8, 1.0);
		b->flux = 1e3, b->convection.coefficient = 20.0, b->convection.ambient = 280.0;
	}
	if (kind == 3)
		scene->time.thermal_every = 3, scene->time.thermal_steps = 2;
	if (kind == 4)
		scene->mpm.pic_fraction = 0.02, scene->mpm.damping_particle = 1.0, scene->mpm.damping_grid = 0.5;
	if (kind == 5)
		scene->mpm.transfer = MPM_APIC;
	if (kind == 6)
		scene->mpm.transfer = MPM_XPIC, scene->mpm.order = MPM_MUSL;
	if (kind == 7)
		scene->mpm.confining_pressure = 1e3;
	if (kind == 8)
		elastic_scene_contact(s, 0.3);
	if (kind == 9) /* this law holds less */
		s->laws[0].thermoelastic.neo_hookean = false, scene->bodies[0].velocity[0] = 0.5,
		scene->bodies[1].velocity[0] = -0.5;
	if (kind == 10) { /* they break each other */
		s->laws[0].type = SCENE_LAW_RANKINE;
		s->laws[0].rankine = (struct scene_law_rankine){.young = 1e5,
														.poisson = 0.2,
														.expansion = 1e-4,
														.strength = 500.0,
														.fracture_energy = 5.0,
														.heat_share = 1.0,
														.cell = 0.1};
		elastic_scene_contact(s, 0.3)->cracks = true;
	}
	return scene;
}

static bool same(const void *a, const void *b, size_t bytes) { return memcmp(a, b, bytes) == 0; }

static void assert_same_points(const struct mpm *a, const struct mpm *b)
{
	size_t n = (size_t)a->p.n;
	assert_int_equal(a->p.n, b->p.n);
	assert_true(same(a->p.id, b->p.id, n * sizeof *a->p.id));
	assert_true(same(a->p.x, b->p.x, n * sizeof *a->p.x));
	assert_true(same(a->p.v, b->p.v, n * sizeof *a->p.v));
	assert_true(same(a->p.F, b->p.F, n * sizeof *a->p.F));
	assert_true(same(a->p.L, b->p.L, n * sizeof *a->p.L));
	assert_true(same(a->p.stress, b->p.stress, n * sizeof *a->p.stress));
	assert_true(same(a->p.T, b->p.T, n * sizeof *a->p.T));
	assert_true(same(a->p.T_smooth, b->p.T_smooth, n * sizeof *a->p.T_smooth));
}

static void test_instruction_sets(void **state)
{
	(void)state;
	static const char *const sets[] = {"base", "v3", "v4"};
	for (int k = 1; k < 3; k++) {
		setenv("TMDEMPM_ISA", sets[k], 1);
		if (strcmp(rve_isa(), sets[k]) != 0)
			print_message("  this processor cannot run %s: %s again\n", sets[k], rve_isa());
	}
	for (int c = 0; shapes[c]; c++)
		for (int kind = 0; kind < KINDS; kind++) {
			struct elastic_scene s[3];
			struct mpm *mpm[3];
			for (int k = 0; k < 3; k++) {
				setenv("TMDEMPM_ISA", sets[k], 1);
				ok(mpm_create(&mpm[k], kind_of_scene(&s[k], shapes[c]->name, kind)));
				for (int step = 0; step < 150; step++)
					ok(mpm_step(mpm[k]));
				mpm_measure(mpm[k]);
			}
			for (int k = 1; k < 3; k++) {
				assert_same_points(mpm[0], mpm[k]);
				assert_true(same(&mpm[0]->ledger, &mpm[k]->ledger, sizeof mpm[0]->ledger));
			}
			int broken = 0;
			for (int q = 0; q < mpm[0]->p.n && kind == 10; q++)
				broken += mpm[0]->p.damage[q] == 1.0;
			assert_true(kind != 10 || (broken > 5 && broken < mpm[0]->p.n));
			for (int k = 0; k < 3; k++)
				mpm_free(mpm[k]);
		}
	unsetenv("TMDEMPM_ISA");
}

/* ---- plain loops ---- */

static void plain_stripe(const struct mpm *mpm, int stripe, struct node_sum *sums)
{
	const struct mpm_work *w = mpm_work(mpm);
	const struct particles *p = &mpm->p;
	struct shape_lists lists;
	int first, last;
	mpm_stripe_points(w, stripe, &first, &last);
	for (int i = first; i < last; i++) {
		int q = w->order[i], k = (i - first) % SHAPE_CHUNK;
		if (k == 0) /* CPDI's rounding depends on the chunk */
			mpm_lists(mpm, last - i < SHAPE_CHUNK ? last - i : SHAPE_CHUNK, w->order + i, &lists);
		double m = p->mass[q], V = mat2_determinant(p->F[q]) * p->volume0[q];
		double fxx = -V * p->stress[q][0], fyy = -V * p->stress[q][1], fxy = -V * p->stress[q][3];
		for (int a = 0; a < lists.nodes; a++) {
			double weight = lists.weight[a][k], gx = lists.grad_x[a][k], gy = lists.grad_y[a][k];
			struct node_sum *node = &sums[lists.node[a][k]];
			for (int c = 0; c < 2; c++)
				node->momentum[c] += weight * (m * p->v[q][c]);
			node->force[0] += gx * fxx + gy * fxy;
			node->force[1] += gx * fxy + gy * fyy;
			node->mass += weight * m;
			if (w->thermal_dt > 0.0) {
				node->capacity += weight * (m * p->capacity[q]);
				node->heat += weight * (m * p->capacity[q] * p->T[q]);
			}
		}
	}
}

static void plain_to_grid(const struct mpm *mpm, struct node_sum *sums)
{
	for (int parity = 0; parity < 2; parity++)
		for (int stripe = parity; stripe < mpm_work(mpm)->n_stripes; stripe += 2)
			plain_stripe(mpm, stripe, sums);
}

/* FLIP: velocity, place and F of each point. */
static void plain_to_points(const struct mpm *mpm, double (*x)[2], double (*v)[2], double (*F)[4])
{
	const struct mpm_work *w = mpm_work(mpm);
	const struct particles *p = &mpm->p;
	struct shape_lists lists;
	for (int i = 0; i < w->n_inside; i++) {
		int q = w->order[i], k = i % BLOCK_POINTS % SHAPE_CHUNK;
		if (k == 0)
			mpm_lists(mpm, w->n_inside - i < SHAPE_CHUNK ? w->n_inside - i : SHAPE_CHUNK, w->order + i, &lists);
		double old[2] = {0.0, 0.0}, new[2] = {0.0, 0.0}, L[4] = {0.0, 0.0, 0.0, 0.0};
		for (int a = 0; a < lists.nodes; a++)
			for (int c = 0; c < 2; c++) {
				int node = lists.node[a][k];
				old[c] += lists.weight[a][k] * mpm->grid.v[node][c];
				new[c] += lists.weight[a][k] * mpm->grid.v_new[node][c];
				L[2 * c] += mpm->grid.v_new[node][c] * lists.grad_x[a][k];
				L[2 * c + 1] += mpm->grid.v_new[node][c] * lists.grad_y[a][k];
			}
		for (int c = 0; c < 2; c++) {
			double gain = new[c] - old[c];
			v[q][c] = p->v[q][c] + gain;
			x[q][c] = p->x[q][c] + mpm->dt * (old[c] + 0.5 * gain);
		}
		memcpy(F[q], p->F[q], sizeof p->F[q]);
		deform(F[q], L, mpm->dt);
	}
}

/* The passes of one step, after some others; returns the largest strain of it. */
static double compare_with_plain(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	size_t n = (size_t)mpm->p.n;
	struct node_sum *sums = aligned_alloc(64, w->n_nodes * sizeof *sums);
	double(*x)[2] = malloc(n * sizeof *x), (*v)[2] = malloc(n * sizeof *v), (*F)[4] = malloc(n * sizeof *F);
	assert_true(sums && x && v && F);
	memset(sums, 0, w->n_nodes * sizeof *sums);
	mpm_sort(mpm);
	mpm_clear_grid(mpm);
	plain_to_grid(mpm, sums);
	mpm_points_to_grid(mpm);
	for (size_t node = 0; node < w->n_nodes; node++) {
		sums[node].flow = w->sums[node].flow;
		assert_true(sums[node].mass == 0.0 || same(&sums[node], &w->sums[node], sizeof *sums));
	}
	mpm_integrate_nodes(mpm);
	plain_to_points(mpm, x, v, F);
	w->thermal_dt = 0.0;
	mpm_grid_to_points(mpm);
	assert_true(same(x, mpm->p.x, n * sizeof *x));
	assert_true(same(v, mpm->p.v, n * sizeof *v));
	assert_true(same(F, mpm->p.F, n * sizeof *F));
	double most = 0.0;
	for (size_t q = 0; q < n; q++)
		most = fmax(most, 0.5 * mpm->dt * fabs(mpm->p.L[q][0] + mpm->p.L[q][3]));
	free(sums), free(x), free(v), free(F);
	return most;
}

static void test_plain_loops(void **state)
{
	(void)state;
	for (int c = 0; shapes[c]; c++)
		for (int kind = 0; kind < 2; kind++)
			for (int fast = 0; fast < 2; fast++) {
				struct elastic_scene s;
				struct scene *scene = kind_of_scene(&s, shapes[c]->name, kind);
				struct mpm *mpm;
				ok(mpm_create(&mpm, scene));
				for (int step = 0; step < 130; step++)
					ok(mpm_step(mpm));
				for (int q = 0; q < mpm->p.n && fast;
					 q++) /* strains by more in a step than the series of exp() serves */
					mpm->p.v[q][q % 2] += 40.0 * sin(q);
				double most = compare_with_plain(mpm);
				assert_true(fast ? most > SERIES_MOST : most < SERIES_MOST);
				mpm_free(mpm);
			}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_instruction_sets),
		cmocka_unit_test(test_plain_loops),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
