/* CPDI in the step: patches of uniform stress, whatever the shear. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

#include "../common/elastic_scene.h"
#include "../common/near.h"
#include "mpm/mpm_private.h"

static struct mpm *patch(struct elastic_scene *s, const char *shape, int points_per_cell)
{
	struct scene *scene = elastic_scene_init(s, 24, 24, 1.0, 1.0, 0.3, 1.0, 0.01);
	struct mpm *mpm;
	snprintf(scene->mpm.shape, sizeof scene->mpm.shape, "%s", shape);
	scene->guards = (struct scene_guards){0};
	elastic_scene_box(s, points_per_cell, 7.0, 7.0, 17.0, 17.0);
	assert_int_equal(mpm_create(&mpm, scene), STATUS_OK);
	return mpm;
}

/* Largest force on a node that lies `deep` cells inside, over stress times cell, under a uniform stress in the deformed
 * body x = c + F (X - c) + bend ((Y - c)^3, (X - c)^3). */
static double patch_force(const char *shape, int points_per_cell, const double F[4], double bend)
{
	struct elastic_scene s;
	struct mpm *mpm = patch(&s, shape, points_per_cell);
	struct mpm_work *w = mpm_work(mpm);
	double worst = 0.0;
	for (int k = 0; k < mpm->p.n; k++) {
		double X = mpm->p.x0[k][0] - 12.0, Y = mpm->p.x0[k][1] - 12.0;
		mpm->p.x[k][0] = 12.0 + F[0] * X + F[1] * Y + bend * Y * Y * Y,
		mpm->p.x[k][1] = 12.0 + F[2] * X + F[3] * Y + bend * X * X * X;
		memcpy(mpm->p.F[k], F, 4 * sizeof *F);
		mpm->p.F[k][1] += 3.0 * bend * Y * Y, mpm->p.F[k][2] += 3.0 * bend * X * X;
		const double stress[4] = {1.0, -0.4, 0.0, 0.3};
		memcpy(mpm->p.stress[k], stress, sizeof stress);
	}
	mpm_sort(mpm);
	mpm_clear_grid(mpm);
	mpm_points_to_grid(mpm);
	for (int i = 10; i <= 14; i++)
		for (int j = 10; j <= 14; j++) {
			const struct node_sum *node = &w->sums[(j + 1) * mpm->grid.nx + i + 1];
			worst = fmax(worst, fmax(fabs(node->force[0]), fabs(node->force[1])));
		}
	mpm_free(mpm);
	return worst;
}

/* Domains that fill the plane: no force inside, to round-off, also where uGIMP's no longer fit together. */
static void test_patch(void **state)
{
	(void)state;
	const double F[][4] = {{1.0, 0.0, 0.0, 1.0}, {1.0, 0.4, 0.0, 1.0},  {0.8, 0.6, -0.6, 0.8},
						   {1.3, 0.2, 0.1, 0.8}, {0.9, -0.5, 0.3, 1.1}, {1.7, 0.0, 0.0, 0.7}};
	for (int k = 0; k < 6; k++)
		for (int side = 2; side <= 4; side++)
			assert_near(patch_force("cpdi", side * side, F[k], 0.0), 0.0, 1e-13);
	assert_true(patch_force("ugimp", 4, F[5], 0.0) > 0.1);
}

/* Under shear that differs from point to point parallelograms still fit together to the second order (forces are
 * round-off then); what bends more leaves gaps, and forces that fall as the square of the spacing. */
static void test_inhomogeneous_shear(void **state)
{
	(void)state;
	const double F[4] = {1.0, 0.0, 0.0, 1.0};
	double four = patch_force("cpdi", 4, F, 0.005), sixteen = patch_force("cpdi", 16, F, 0.005);
	double square = patch_force("ugimp", 4, F, 0.005);
	print_message("  force of a patch whose shear bends: CPDI, 4 points %.2g, 16 points %.2g; uGIMP %.2g\n", four,
				  sixteen, square);
	assert_true(four < 0.02);
	assert_true(sixteen < 0.3 * four);
	assert_true(four < 0.5 * square);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_patch),
		cmocka_unit_test(test_inhomogeneous_shear),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
