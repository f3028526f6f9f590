/* The MPM step: what must hold exactly. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

#include "../common/elastic_scene.h"
#include "../common/near.h"
#include "mpm/mpm.h"

/* Two blocks that fly into each other, spinning a little: mass and momentum to round-off in every step. */
static void test_mass_and_momentum(void **state)
{
	(void)state;
	for (int linear = 0; linear < 2; linear++) {
		struct elastic_scene s;
		struct scene *scene = elastic_scene_init(&s, 24, 12, 0.1, 1e5, 0.3, 1000.0, 1e-3);
		if (linear)
			snprintf(scene->mpm.shape, sizeof scene->mpm.shape, "linear");
		/* both hold in a step that is not stable, and in blocks that the grid tears */
		scene->guards.time_step = scene->guards.numerical_fracture = false;
		/* with linear functions corner points are stretched to 3.6: more than the Hencky law allows */
		s.laws[0].thermoelastic.neo_hookean = linear;
		elastic_scene_box(&s, 4, 0.33, 0.31, 0.9, 0.8)->velocity[0] = 1.0;
		elastic_scene_box(&s, 9, 1.1, 0.42, 1.7, 0.9)->velocity[0] = -0.5;
		struct mpm *mpm;
		ok(mpm_create(&mpm, scene));
		double mass = sum_mass(mpm), px = sum_momentum(mpm, 0), py = sum_momentum(mpm, 1);
		for (int step = 0; step < 300; step++) {
			ok(mpm_step(mpm));
			assert_near(sum_nodal_mass(mpm) / mass, 1.0, 1e-12);
			assert_near(sum_momentum(mpm, 0), px, 1e-12 * mass);
			assert_near(sum_momentum(mpm, 1), py, 1e-12 * mass);
		}
		mpm_free(mpm);
	}
}

/* x(t) of a free fall is exact for the trapezoid of eq. 27: x0 + v0 t + g t^2/2. */
static void test_free_fall(void **state)
{
	(void)state;
	struct elastic_scene s;
	struct scene *scene = elastic_scene_init(&s, 12, 30, 0.1, 1e6, 0.3, 1000.0, 1e-3);
	scene->gravity[1] = -9.81;
	struct scene_body *body = elastic_scene_box(&s, 4, 0.4, 2.0, 0.8, 2.4);
	body->velocity[0] = 0.3, body->velocity[1] = 1.0;
	struct mpm *mpm;
	ok(mpm_create(&mpm, scene));
	for (int step = 0; step < 600; step++)
		ok(mpm_step(mpm));
	double t = mpm->time;
	for (int k = 0; k < mpm->p.n; k++) {
		assert_near(mpm->p.v[k][1], 1.0 - 9.81 * t, 1e-11);
		assert_near(mpm->p.x[k][0] - mpm->p.x0[k][0], 0.3 * t, 1e-11);
		assert_near(mpm->p.x[k][1] - mpm->p.x0[k][1], t - 0.5 * 9.81 * t * t, 1e-11);
		for (int c = 0; c < 4; c++)
			assert_near(mpm->p.stress[k][c], 0.0, 1e-6);
	}
	mpm_measure(mpm);
	assert_near(mpm->ledger.energy_residual, 0.0, 1e-9 * 9.81 * sum_mass(mpm));
	mpm_free(mpm);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_mass_and_momentum),
		cmocka_unit_test(test_free_fall),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
