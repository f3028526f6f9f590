/* Heat on the grid against closed forms, and its ledger. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

#include "../common/elastic_scene.h"
#include "../common/near.h"
#include "mpm/mpm.h"

/* Rod with T = 0 at one end and dT at the other: T/dT = x/L + (2/pi) sum ((-1)^n/n) exp(-n^2 pi^2 a t/L^2) sin(n pi
 * x/L). */
static double rod(double x, double fourier)
{
	double T = x;
	for (int n = 1; n < 60; n++)
		T += 2.0 / M_PI * (n % 2 ? -1.0 : 1.0) / n * exp(-n * n * M_PI * M_PI * fourier) * sin(n * M_PI * x);
	return T;
}

static double rod_error(int cells, int thermal_steps, int thermal_every, const char *shape, double *heat_error)
{
	struct elastic_scene s;
	double h = 1.0 / cells, dt = 0.2 * h * h / 0.1 * thermal_steps / thermal_every; /* a = 0.1 m2/s */
	struct scene *scene = elastic_scene_init(&s, cells, 2, h, 1e-3, 0.0, 1.0, dt);
	snprintf(scene->mpm.shape, sizeof scene->mpm.shape, "%s", shape);
	scene->time.thermal_steps = thermal_steps, scene->time.thermal_every = thermal_every;
	elastic_scene_heat(&s, 0.0, 1.0, 0.1);
	elastic_scene_box(&s, 4, 0.0, 0.0, 1.0, 2 * h)->temperature = 300.0;
	elastic_scene_boundary(&s, 0.0, 0.0, 0.0, 2 * h)->temperature = 300.0;
	elastic_scene_boundary(&s, 1.0, 0.0, 1.0, 2 * h)->temperature = 350.0;
	struct mpm *mpm = start(scene);
	double sum = 0.0, worst = 0.0;
	int n = (int)lround(1.0 / dt / thermal_every) * thermal_every;
	steps(mpm, n);
	for (int k = 0; k < mpm->p.n; k++) {
		double error = (mpm->p.T[k] - 300.0) / 50.0 - rod(mpm->p.x[k][0], 0.1 * mpm->time);
		sum += error * error;
		worst = fmax(worst, fabs(error));
	}
	mpm_measure(mpm);
	*heat_error = fabs(mpm->ledger.heat_residual) / mpm->ledger.heat_in;
	print_message("rod, %d cells, %s, %d thermal steps in %d: rms %.3g, worst %.3g of dT; heat residual %.2g\n", cells,
				  shape, thermal_steps, thermal_every, sqrt(sum / mpm->p.n), worst, *heat_error);
	double rms = sqrt(sum / mpm->p.n);
	mpm_free(mpm);
	return rms;
}

static void test_rod(void **state)
{
	(void)state;
	double heat, coarse = rod_error(10, 1, 1, "ugimp", &heat), fine = rod_error(20, 1, 1, "ugimp", &heat);
	assert_true(fine < 2.5e-3);
	assert_true(coarse / fine > 1.8);
	assert_true(heat < 1e-10);
	assert_true(rod_error(20, 1, 1, "linear", &heat) < 2.5e-3);
	assert_true(rod_error(20, 4, 1, "ugimp", &heat) < 2.5e-3);
	assert_true(heat < 1e-10);
	assert_true(rod_error(20, 1, 4, "ugimp", &heat) < 2.5e-3);
	assert_true(heat < 1e-10);
}

/* Insulated, with a hot half, moving and spinning: the heat content stays to 1e-12, the temperatures even out and
 * (as remapped: points keep what the grid cannot see of the initial jump). */
static void test_insulated(void **state)
{
	(void)state;
	struct elastic_scene s;
	struct scene *scene = elastic_scene_init(&s, 20, 12, 0.1, 1e6, 0.2, 1000.0, 1e-3);
	elastic_scene_heat(&s, 0.0, 2.0, 800.0);
	elastic_scene_box(&s, 4, 0.3, 0.3, 0.7, 0.7)->temperature = 400.0;
	elastic_scene_box(&s, 4, 0.7, 0.3, 1.1, 0.7)->temperature = 300.0;
	for (int b = 0; b < 2; b++)
		s.bodies[b].velocity[0] = 0.5, s.bodies[b].velocity[1] = 0.1;
	struct mpm *mpm = start(scene);
	double content = 0.0, capacity = 2.0 * sum_mass(mpm);
	for (int k = 0; k < mpm->p.n; k++)
		content += 2.0 * mpm->p.mass[k] * mpm->p.T[k];
	for (int step = 0; step < 1000; step++) {
		ok(mpm_step(mpm));
		double now = 0.0;
		for (int k = 0; k < mpm->p.n; k++)
			now += 2.0 * mpm->p.mass[k] * mpm->p.T[k];
		assert_near(now / content, 1.0, 1e-12);
	}
	for (int k = 0; k < mpm->p.n; k++)
		assert_near(mpm->p.T_smooth[k], content / capacity, 1.0);
	mpm_measure(mpm);
	assert_near(mpm->ledger.heat_residual, 0.0, 1e-12 * content);
	assert_near(mpm->ledger.heat_in, 0.0, 0.0);
	mpm_free(mpm);
}

/* A flux of 1 kW/m2 through the left face of an insulated block: the heat that came in is flux * area * time. */
static void test_flux(void **state)
{
	(void)state;
	struct elastic_scene s;
	struct scene *scene = elastic_scene_init(&s, 10, 4, 0.1, 1e6, 0.2, 1000.0, 1e-3);
	elastic_scene_heat(&s, 0.0, 1.0, 50.0);
	elastic_scene_box(&s, 4, 0.1, 0.0, 0.9, 0.4);
	elastic_scene_boundary(&s, 0.1, 0.0, 0.2, 0.4)->flux = 1000.0;
	struct mpm *mpm = start(scene);
	steps(mpm, 500);
	mpm_measure(mpm);
	assert_near(mpm->ledger.heat_in, 1000.0 * 0.4 * 0.5, 1e-9 * 200.0);
	assert_near(mpm->ledger.energy_thermal, 200.0, 1e-8);
	assert_near(mpm->ledger.heat_residual, 0.0, 1e-8);
	mpm_free(mpm);
}

/* Held on all sides and heated through: -E alpha dT/(1 - 2 nu); the elastic energy is the work of expansion. */
static void test_restrained(void **state)
{
	(void)state;
	struct elastic_scene s;
	const double E = 1e7, nu = 0.25, alpha = 1e-5, dT = 20.0;
	struct scene *scene = elastic_scene_init(&s, 6, 6, 0.1, E, nu, 1000.0, 5e-4);
	elastic_scene_heat(&s, alpha, 1.0, 1000.0);
	elastic_scene_box(&s, 4, 0.1, 0.1, 0.5, 0.5)->temperature = 300.0;
	elastic_scene_boundary(&s, 0.0, 0.0, 0.6, 0.6)->temperature = 300.0 + dT;
	double lines[4][4] = {{0.0, 0.1, 0.6, 0.1}, {0.6, 0.5, 0.0, 0.5}, {0.1, 0.6, 0.1, 0.0}, {0.5, 0.0, 0.5, 0.6}};
	for (int k = 0; k < 4; k++)
		elastic_scene_line(&s, lines[k][0], lines[k][1], lines[k][2], lines[k][3])->contact = SCENE_WALL_SLIP;
	struct mpm *mpm = start(scene);
	steps(mpm, 400);
	double exact = -E * alpha * dT / (1.0 - 2.0 * nu);
	for (int k = 0; k < mpm->p.n; k++)
		for (int c = 0; c < 3; c++)
			assert_near(mpm->p.stress[k][c], exact, 1e-6 * fabs(exact));
	mpm_measure(mpm);
	const struct mpm_ledger *l = &mpm->ledger;
	assert_near(l->energy_elastic, 0.16 * 1.5 * E * alpha * dT * alpha * dT / (1.0 - 2.0 * nu),
				1e-5 * l->energy_elastic);
	assert_near(l->work_expansion, l->energy_elastic, 1e-6 * l->energy_elastic);
	assert_near(l->energy_residual, 0.0, 1e-6 * l->energy_elastic);
	mpm_free(mpm);
}

/* A material whose reference temperature is not that of its body is born with thermal stress. */
static void test_reference_temperature(void **state)
{
	(void)state;
	struct elastic_scene s;
	const double E = 1e7, nu = 0.25, alpha = 1e-5;
	struct scene *scene = elastic_scene_init(&s, 6, 6, 0.1, E, nu, 1000.0, 4e-4);
	elastic_scene_heat(&s, alpha, 1.0, 1000.0);
	s.materials[0].reference_temperature = 280.0;
	elastic_scene_box(&s, 4, 0.1, 0.1, 0.5, 0.5)->temperature = 300.0;
	struct mpm *mpm = start(scene);
	assert_near(mpm->p.stress[0][0], -E * alpha * 20.0 / (1.0 - 2.0 * nu), 1e-6);
	assert_near(mpm->p.dT[0], 0.0, 0.0);
	mpm_free(mpm);
}

/* Wall friction handed to the material warms it by what the ledger says. */
static void test_friction_heat(void **state)
{
	(void)state;
	struct elastic_scene s;
	struct scene *scene = elastic_scene_init(&s, 20, 8, 0.1, 1e7, 0.2, 1000.0, 2e-4);
	scene->gravity[1] = -9.81;
	scene->mpm.pic_fraction = 0.1;
	scene->time.thermal_every = 3;
	elastic_scene_heat(&s, 0.0, 1.0, 10.0);
	elastic_scene_box(&s, 4, 0.3, 0.2, 0.9, 0.5)->velocity[0] = 1.0;
	struct scene_wall *floor = elastic_scene_line(&s, 0.0, 0.2, 2.0, 0.2);
	floor->friction = 0.5, floor->heat_share = 0.6;
	struct mpm *mpm = start(scene);
	steps(mpm, 1200);
	mpm_measure(mpm);
	const struct mpm_ledger *l = &mpm->ledger;
	assert_true(l->work_walls_friction > 0.9 * 0.5 * sum_mass(mpm));
	assert_near(l->energy_thermal, 0.6 * l->work_walls_friction, 1e-3 * l->work_walls_friction);
	assert_near(l->heat_residual, 0.0, 1e-6 * l->energy_thermal);
	mpm_free(mpm);
}

/* A heated wall: the heat it gives is what the material gains; the wall's own count agrees with the ledger. */
static void test_heated_wall(void **state)
{
	(void)state;
	struct elastic_scene s;
	struct scene *scene = elastic_scene_init(&s, 10, 6, 0.1, 1e6, 0.2, 1000.0, 1e-3);
	elastic_scene_heat(&s, 0.0, 1.0, 100.0);
	elastic_scene_box(&s, 4, 0.2, 0.2, 0.8, 0.5)->temperature = 283.15;
	elastic_scene_line(&s, 0.2, 0.6, 0.2, 0.0)->temperature = 323.15;
	struct mpm *mpm = start(scene);
	steps(mpm, 1000);
	mpm_measure(mpm);
	const struct mpm_ledger *l = &mpm->ledger;
	assert_true(l->heat_in > 0.0);
	assert_near(l->energy_thermal, l->heat_in - l->heat_out, 1e-9 * l->heat_in);
	assert_near(mpm->walls[0].heat, l->heat_in - l->heat_out, 1e-9 * l->heat_in);
	/* a half space until the far end feels it: 2 k dT sqrt(t/(pi a)) */
	double a = 100.0 / 1000.0, exact = 2.0 * 100.0 * 40.0 * sqrt(mpm->time / (M_PI * a)) * 0.3;
	assert_near(l->heat_in, exact, 0.02 * exact);
	mpm_free(mpm);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_rod),
		cmocka_unit_test(test_insulated),
		cmocka_unit_test(test_flux),
		cmocka_unit_test(test_restrained),
		cmocka_unit_test(test_reference_temperature),
		cmocka_unit_test(test_friction_heat),
		cmocka_unit_test(test_heated_wall),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
