/* Heat through boundaries that convect or change in time, bodies that begin with a gradient, and heat on a clock of
 * its own. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

#include "../common/elastic_scene.h"
#include "../common/near.h"
#include "exact/exact.h"
#include "mpm/mpm.h"

/* ---- convection ---- */

/* A block that conducts so well that it has one temperature: m c dT/dt = A H (T_air - T). */
static void test_lumped(void **state)
{
	(void)state;
	struct elastic_scene s;
	struct scene *scene = elastic_scene_init(&s, 8, 4, 0.1, 1e6, 0.2, 1000.0, 1e-3);
	elastic_scene_heat(&s, 0.0, 1.0, 1000.0);
	elastic_scene_box(&s, 4, 0.2, 0.0, 0.6, 0.4)->temperature = 300.0;
	struct scene_boundary *air = elastic_scene_boundary(&s, 0.5, 0.0, 0.6, 0.4);
	air->convection.coefficient = 200.0, air->convection.ambient = 340.0;
	struct mpm *mpm = start(scene);
	steps(mpm, 3000);
	double exact = 340.0 - 40.0 * exp(-200.0 * 0.4 / (1000.0 * 0.16) * mpm->time);
	for (int k = 0; k < mpm->p.n; k++)
		assert_near(mpm->p.T[k], exact, 0.5); /* Biot number 0.08: the block is nearly even */
	mpm_measure(mpm);
	const struct mpm_ledger *l = &mpm->ledger;
	assert_near(l->heat_in, 160.0 * (exact - 300.0), 0.01 * l->heat_in);
	assert_near(l->heat_out, 0.0, 0.0);
	assert_near(l->heat_residual, 0.0, 1e-9 * l->heat_in);
	mpm_free(mpm);
}

/* The plate in air of another temperature: the layer's mean temperature stands for that of its surface, so the error
 * falls with the cell, as layer does. */
static double plate_error(int cells, double biot)
{
	struct elastic_scene s;
	const struct exact_solution *exact = exact_find("cooling");
	double p[EXACT_PARAMETERS_MAX], h = 1.0 / cells, sum = 0.0;
	exact_defaults(exact, p);
	p[exact_parameter(exact, "biot")] = biot;
	p[exact_parameter(exact, "temperature_start")] = 300.0;
	struct scene *scene = elastic_scene_init(&s, cells, 2, h, 1e-3, 0.0, 1.0, 0.2 * h * h / 0.1);
	elastic_scene_heat(&s, 0.0, 1.0, 0.1);
	elastic_scene_box(&s, 4, 0.0, 0.0, 1.0, 2 * h)->temperature = 300.0;
	struct scene_boundary *air = elastic_scene_boundary(&s, 1.0 - h, 0.0, 1.0, 2 * h);
	air->convection.coefficient = 0.1 * biot, air->convection.ambient = 350.0;
	struct mpm *mpm = start(scene);
	steps(mpm, (int)lround(2.0 / mpm->dt));
	for (int k = 0; k < mpm->p.n; k++) {
		const double X[2] = {mpm->p.x[k][0], 0.0};
		sum += pow((mpm->p.T[k] - exact_value(exact, p, X, mpm->time, EXACT_TEMPERATURE)) / 50.0, 2.0);
	}
	mpm_measure(mpm);
	assert_near(mpm->ledger.heat_residual, 0.0, 1e-9 * mpm->ledger.heat_in);
	double rms = sqrt(sum / mpm->p.n);
	print_message("plate in air, %d cells, Biot %g: rms %.2e of the step\n", cells, biot, rms);
	mpm_free(mpm);
	return rms;
}

static void test_plate(void **state)
{
	(void)state;
	const double biots[] = {1.0, 10.0};
	for (int k = 0; k < 2; k++) {
		double coarse = plate_error(10, biots[k]), fine = plate_error(40, biots[k]);
		assert_true(coarse / fine > 3.0);
		assert_true(fine < 0.1 * biots[k] / 40.0); /* of the layer's own Biot number */
	}
}

/* Convection takes its part of the step limit: rho c over (2 k / h^2 + H / (2 layer)). */
static void test_limit(void **state)
{
	(void)state;
	struct elastic_scene s;
	struct scene *scene = elastic_scene_init(&s, 8, 4, 0.1, 1e-3, 0.0, 1.0, 1.0);
	elastic_scene_heat(&s, 0.0, 1.0, 1e-3);
	elastic_scene_box(&s, 4, 0.2, 0.0, 0.6, 0.4)->temperature = 300.0;
	struct scene_boundary *air = elastic_scene_boundary(&s, 0.2, 0.0, 0.6, 0.4);
	air->layer = 0.4, air->convection.coefficient = 1.0, air->convection.ambient = 340.0;
	double limit = 1.0 / (2e-3 / 0.01 + 1.0 / 0.8);
	struct mpm *mpm;
	scene->time.step = 1.001 * limit;
	assert_int_equal(mpm_create(&mpm, scene), STATUS_INPUT);
	assert_non_null(strstr(error_message(), "less what convection takes"));
	scene->time.step = 0.999 * limit;
	mpm = start(scene);
	steps(mpm, 400);
	for (int k = 0; k < mpm->p.n; k++)
		assert_near(mpm->p.T[k], 340.0, 1.0);
	mpm_free(mpm);
}

/* ---- what changes in time ---- */

/* A half space whose surface warms by `rate` K/s: rate t 4 i2erfc(x / 2 sqrt(a t)) (Carslaw & Jaeger 2.5). */
static double ramp(double x, double t, double a, double rate)
{
	double z = x / (2.0 * sqrt(a * t));
	return rate * t * ((1.0 + 2.0 * z * z) * erfc(z) - 2.0 / sqrt(M_PI) * z * exp(-z * z));
}

static double ramp_error(double h, int thermal_every)
{
	struct elastic_scene s;
	double rows[2][2] = {{0.0, 300.0}, {2.0, 400.0}}, sum = 0.0;
	struct scene *scene =
		elastic_scene_init(&s, (int)lround(2.0 / h), 1, h, 1e-3, 0.0, 1.0, h * h / 0.4 / thermal_every);
	scene->time.thermal_every = thermal_every;
	elastic_scene_heat(&s, 0.0, 1.0, 0.1);
	elastic_scene_box(&s, 4, 0.0, 0.0, 2.0, h)->temperature = 300.0;
	elastic_scene_boundary(&s, 0.0, 0.0, 0.0, h)->temperature_table = (struct scene_series){2, rows};
	struct mpm *mpm = start(scene);
	steps(mpm, (int)lround(1.0 / mpm->dt));
	for (int k = 0; k < mpm->p.n; k++)
		sum += pow(mpm->p.T[k] - 300.0 - ramp(mpm->p.x[k][0], mpm->time, 0.1, 50.0), 2.0);
	mpm_measure(mpm);
	assert_near(mpm->ledger.heat_residual, 0.0, 1e-9 * mpm->ledger.heat_in);
	double rms = sqrt(sum / mpm->p.n) / 50.0;
	print_message("ramp, h = %g m, thermal step every %d: rms %.2e\n", h, thermal_every, rms);
	mpm_free(mpm);
	return rms;
}

static void test_temperature_table(void **state)
{
	(void)state;
	double coarse = ramp_error(0.1, 1), fine = ramp_error(0.025, 1);
	assert_true(coarse / fine > 6.0);
	assert_true(fine < 1e-3);
	assert_true(ramp_error(0.025, 3) < 1e-3);
}

/* The heat that a flux brings is the integral of its table, kinks and all, and nothing is brought outside from/until.
 */
static void test_flux_table(void **state)
{
	(void)state;
	for (int every = 1; every <= 2; every++) {
		struct elastic_scene s;
		double rows[4][2] = {{0.1, 0.0}, {0.2, 1000.0}, {0.3, 1000.0}, {0.5, -500.0}};
		struct scene *scene = elastic_scene_init(&s, 10, 4, 0.1, 1e6, 0.2, 1000.0, 1e-3);
		scene->time.thermal_every = every;
		elastic_scene_heat(&s, 0.0, 1.0, 50.0);
		elastic_scene_box(&s, 4, 0.1, 0.0, 0.9, 0.4);
		struct scene_boundary *lamp = elastic_scene_boundary(&s, 0.1, 0.0, 0.2, 0.4);
		lamp->flux_table = (struct scene_series){4, rows}, lamp->until = 0.6;
		struct mpm *mpm = start(scene);
		steps(mpm, 1000);
		mpm_measure(mpm);
		/* up to the zero at 13/30 s, then down and on until 0.6 s */
		double in = 0.4 * (0.5 * 0.1 + 0.1 + 0.5 * 2.0 / 15.0) * 1000.0, out = 0.4 * (0.5 * 1.0 / 15.0 + 0.1) * 500.0;
		assert_near(mpm->ledger.heat_in - mpm->ledger.heat_out, in - out, 1e-9 * in);
		assert_near(mpm->ledger.heat_in, in, 1e-4 * in); /* the step that holds the zero counts as one */
		assert_near(mpm->ledger.heat_residual, 0.0, 1e-9 * in);
		mpm_free(mpm);
	}
}

/* A wall's table that does not change is its temperature, bit for bit; one that does heats by what it says. */
static void test_wall_table(void **state)
{
	(void)state;
	double T[3];
	for (int k = 0; k < 3; k++) {
		struct elastic_scene s;
		double rows[2][2] = {{0.0, 323.15}, {0.5, k == 2 ? 303.15 : 323.15}};
		struct scene *scene = elastic_scene_init(&s, 10, 6, 0.1, 1e6, 0.2, 1000.0, 1e-3);
		elastic_scene_heat(&s, 0.0, 1.0, 100.0);
		elastic_scene_box(&s, 4, 0.2, 0.2, 0.8, 0.5)->temperature = 283.15;
		struct scene_wall *wall = elastic_scene_line(&s, 0.2, 0.6, 0.2, 0.0);
		if (k == 0)
			wall->temperature = 323.15;
		else
			wall->temperature_table = (struct scene_series){2, rows};
		struct mpm *mpm = start(scene);
		steps(mpm, 2000);
		T[k] = mpm->p.T[mpm_point_by_id(mpm, 0)];
		mpm_measure(mpm);
		assert_near(mpm->walls[0].heat, mpm->ledger.heat_in - mpm->ledger.heat_out, 1e-9 * mpm->ledger.heat_in);
		mpm_free(mpm);
	}
	assert_true(T[0] == T[1]);
	assert_true(T[2] < T[0] - 10.0);
}

/* ---- gradient ---- */

/* A linear profile between two temperatures is steady, and the law, born in it, feels no change. */
static void test_gradient(void **state)
{
	(void)state;
	struct elastic_scene s;
	struct scene *scene = elastic_scene_init(&s, 10, 6, 0.1, 1e6, 0.2, 1000.0, 1e-3);
	elastic_scene_heat(&s, 1e-4, 1.0, 1000.0);
	struct scene_body *body = elastic_scene_box(&s, 4, 0.1, 0.1, 0.9, 0.5);
	body->temperature = 300.0;
	body->temperature_gradient[0] = 50.0;
	body->temperature_at[0] = 0.5, body->temperature_at[1] = 0.3;
	elastic_scene_boundary(&s, 0.1, 0.0, 0.1, 0.6)->temperature = 280.0;
	elastic_scene_boundary(&s, 0.9, 0.0, 0.9, 0.6)->temperature = 320.0;
	struct mpm *mpm = start(scene);
	steps(mpm, 500);
	double most = 0.0;
	for (int k = 0; k < mpm->p.n; k++) {
		assert_near(mpm->p.T[k], 300.0 + 50.0 * (mpm->p.x0[k][0] - 0.5), 1e-9);
		most = fmax(most, fabs(mpm->p.stress[k][0]));
	}
	assert_true(most < 1e-6); /* Pa, where 1 K would be 170 */
	mpm_measure(mpm);
	double through = 1000.0 * 50.0 * 0.4 * mpm->time;
	assert_near(mpm->ledger.heat_in, through, 1e-9 * through);
	assert_near(mpm->ledger.heat_out, through, 1e-9 * through);
	mpm_free(mpm);
}

/* ---- time scale ---- */

/* Temperatures after `duration` of thermal time: conduction, flux, convection and freezing, all at once. */
static struct mpm *scaled(struct elastic_scene *s, double scale, double duration)
{
	struct scene *scene = elastic_scene_init(s, 10, 6, 0.1, 1e3, 0.2, 1000.0, 0.02 / scale);
	scene->thermal.time_scale = scale;
	elastic_scene_heat(s, 0.0, 1.0, 100.0);
	struct scene_material *m = &s->materials[0];
	m->freezing[0] = 272.15, m->freezing[1] = 273.15, m->latent_heat = 20.0;
	m->conductivity_frozen = 200.0;
	elastic_scene_box(s, 4, 0.1, 0.1, 0.9, 0.5)->temperature = 275.15;
	elastic_scene_boundary(s, 0.1, 0.0, 0.1, 0.6)->temperature = 263.15;
	elastic_scene_boundary(s, 0.4, 0.4, 0.6, 0.5)->flux = 1e3;
	struct scene_boundary *air = elastic_scene_boundary(s, 0.8, 0.1, 0.9, 0.5);
	air->convection.coefficient = 300.0, air->convection.ambient = 283.15;
	struct mpm *mpm = start(scene);
	steps(mpm, (int)lround(duration * scale / 0.02 / scale));
	mpm_measure(mpm);
	assert_near(mpm->ledger.heat_residual, 0.0, 1e-9 * mpm->ledger.heat_in);
	return mpm;
}

/* S times faster for an S-th of the time is the same, to the last bit for a power of two. */
static void test_time_scale(void **state)
{
	(void)state;
	struct elastic_scene a, b;
	struct mpm *slow = scaled(&a, 1.0, 2.0), *fast = scaled(&b, 64.0, 2.0);
	assert_near(fast->time * 64.0, slow->time, 1e-12);
	assert_near(fast->thermal_limit * 64.0, slow->thermal_limit, 1e-12 * slow->thermal_limit);
	bool frozen = false;
	for (int k = 0; k < slow->p.n; k++) {
		assert_true(slow->p.T[k] == fast->p.T[k]);
		frozen = frozen || slow->p.thawed[k] < 0.5;
	}
	assert_true(frozen);
	assert_near(fast->ledger.heat_in, slow->ledger.heat_in, 1e-12 * slow->ledger.heat_in);
	mpm_free(slow);
	mpm_free(fast);
}

/* Friction heats by what it works, whatever the time scale: it belongs to the mechanics. */
static void test_time_scale_friction(void **state)
{
	(void)state;
	struct elastic_scene s;
	struct scene *scene = elastic_scene_init(&s, 20, 8, 0.1, 1e7, 0.2, 1000.0, 2e-4);
	scene->gravity[1] = -9.81;
	scene->mpm.pic_fraction = 0.1;
	scene->thermal.time_scale = 10.0;
	elastic_scene_heat(&s, 0.0, 1.0, 10.0);
	elastic_scene_box(&s, 4, 0.3, 0.2, 0.9, 0.5)->velocity[0] = 1.0;
	struct scene_wall *floor = elastic_scene_line(&s, 0.0, 0.2, 2.0, 0.2);
	floor->friction = 0.5, floor->heat_share = 1.0;
	struct mpm *mpm = start(scene);
	steps(mpm, 600);
	mpm_measure(mpm);
	assert_true(mpm->ledger.work_walls_friction > 10.0);
	assert_near(mpm->ledger.energy_thermal, mpm->ledger.work_walls_friction, 1e-6 * mpm->ledger.energy_thermal);
	mpm_free(mpm);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_lumped),
		cmocka_unit_test(test_plate),
		cmocka_unit_test(test_limit),
		cmocka_unit_test(test_temperature_table),
		cmocka_unit_test(test_flux_table),
		cmocka_unit_test(test_wall_table),
		cmocka_unit_test(test_gradient),
		cmocka_unit_test(test_time_scale),
		cmocka_unit_test(test_time_scale_friction),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
