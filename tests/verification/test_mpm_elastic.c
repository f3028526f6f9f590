/* The MPM with the thermoelastic law against closed forms: statics, waves, walls, energy. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <time.h>

#include <cmocka.h>

#include "../common/elastic_scene.h"
#include "../common/near.h"
#include "exact/exact.h"
#include "mpm/mpm.h"

/* Largest |residual| over the work done, looking every `every` steps. */
static double run_and_watch(struct mpm *mpm, int n, int every, double work)
{
	double worst = 0.0;
	for (int k = 0; k < n; k += every) {
		steps(mpm, every);
		mpm_measure(mpm);
		worst = fmax(worst, fabs(mpm->ledger.energy_residual));
	}
	return worst / work;
}

/* Column of 50 m and 80 kg/m3 under its own weight between frictionless walls: sigma_yy = -rho g (l0 - Y), whatever the
 * law. */
static void test_column(void **state)
{
	(void)state;
	struct elastic_scene s;
	const struct exact_solution *exact = exact_find("column");
	double p[EXACT_PARAMETERS_MAX], h = 2.5, mean[20] = {0}, worst = 0.0;
	exact_defaults(exact, p);
	double height = p[exact_parameter(exact, "length")], rho = p[exact_parameter(exact, "density")],
		   g = p[exact_parameter(exact, "gravity")];
	struct scene *scene = elastic_scene_init(&s, 6, 26, h, 1e6, 0.3, rho, 0.01);
	scene->gravity[1] = -g;
	scene->mpm.damping_particle = 6.0;
	elastic_scene_box(&s, 4, h, 2.0 * h, 5.0 * h, 2.0 * h + height);
	elastic_scene_line(&s, 0.0, 2.0 * h, 6.0 * h, 2.0 * h);
	elastic_scene_line(&s, h, 26.0 * h, h, 0.0)->contact = SCENE_WALL_SLIP;
	elastic_scene_line(&s, 5.0 * h, 0.0, 5.0 * h, 26.0 * h)->contact = SCENE_WALL_SLIP;
	struct mpm *mpm = start(scene);
	steps(mpm, 1500);
	/* the nodes hold the mean of the points of a grid cell, not each point */
	for (int k = 0; k < mpm->p.n; k++)
		mean[(int)(mpm->p.x0[k][1] / h) - 2] += mpm->p.stress[k][1] / 16.0;
	for (int j = 0; j < 20; j++) {
		const double X[2] = {0.0, (j + 0.5) * h};
		worst = fmax(worst, fabs(mean[j] - exact_value(exact, p, X, mpm->time, EXACT_STRESS_YY)));
	}
	print_message("column: worst error %.3g %% of rho g l0\n", 100 * worst / (rho * g * height));
	assert_true(worst < 6e-3 * rho * g * height); /* at the foot, where domains overlap by the strain of 3% */
	assert_near(mpm->walls[0].force[1], -sum_mass(mpm) * g, 1e-3 * sum_mass(mpm) * g);
	mpm_free(mpm);
}

/* Two equal bars meet: they exchange their velocities after the wave has gone there and back, and the energy closes. */
static void test_bars_collide(void **state)
{
	(void)state;
	struct elastic_scene s;
	const double v0 = 0.1, h = 0.05, length = 1.0, E = 1e6, rho = 1000.0;
	struct scene *scene = elastic_scene_init(&s, 60, 6, h, E, 0.0, rho, 2e-4);
	elastic_scene_box(&s, 4, 0.3, 0.1, 0.3 + length, 0.2)->velocity[0] = v0;
	elastic_scene_box(&s, 4, 0.4 + length, 0.1, 0.4 + 2 * length, 0.2)->velocity[0] = -v0;
	struct mpm *mpm = start(scene);
	double kinetic = 0.5 * sum_mass(mpm) * v0 * v0;
	double worst = run_and_watch(mpm, 4000, 10, kinetic);
	double v = 0.0, m = 0.0;
	for (int k = 0; k < mpm->p.n; k++)
		if (mpm->p.body[k] == 0)
			v += mpm->p.mass[k] * mpm->p.v[k][0], m += mpm->p.mass[k];
	print_message("bars: residual %.3g %% of the kinetic energy, rebound %.4f v0, numerical loss %.3g %%\n",
				  100 * worst, v / m / v0, 100 * mpm->ledger.loss_numerical / kinetic);
	assert_near(v / m, -v0, 0.03 * v0);
	assert_true(worst < 1e-4);
	mpm_free(mpm);
}

/* Confining pressure as sigma + p_c I: a free body comes to rest at sigma = -p_c in the plane, everywhere. */
static void test_confining_pressure(void **state)
{
	(void)state;
	struct elastic_scene s;
	const double p = 1e4;
	struct scene *scene = elastic_scene_init(&s, 12, 12, 0.1, 1e7, 0.2, 1000.0, 5e-4);
	scene->mpm.confining_pressure = p;
	scene->mpm.damping_particle = 100.0;
	elastic_scene_box(&s, 4, 0.33, 0.33, 0.87, 0.81);
	struct mpm *mpm = start(scene);
	double worst = 0.0;
	for (int k = 0; k < 3000; k += 10) {
		steps(mpm, 10);
		mpm_measure(mpm);
		worst = fmax(worst, fabs(mpm->ledger.energy_residual));
	}
	for (int k = 0; k < mpm->p.n; k++) {
		assert_near(mpm->p.stress[k][0], -p, 1e-3 * p);
		assert_near(mpm->p.stress[k][1], -p, 1e-3 * p);
		assert_near(mpm->p.stress[k][3], 0.0, 1e-3 * p);
	}
	print_message("confining: work %.4g J, residual %.3g %%\n", mpm->ledger.work_boundary,
				  100 * worst / mpm->ledger.work_boundary);
	assert_true(worst < 1e-3 * mpm->ledger.work_boundary);
	mpm_free(mpm);
}

/* A block slides along a horizontal floor and comes to rest: deceleration mu g; what it had is friction heat. */
static void test_slide_to_rest(void **state)
{
	(void)state;
	struct elastic_scene s;
	const double mu = 0.4, g = 9.81, v0 = 1.0;
	struct scene *scene = elastic_scene_init(&s, 30, 12, 0.1, 1e7, 0.2, 1000.0, 2e-4);
	scene->gravity[1] = -g;
	scene->mpm.pic_fraction = 0.1;
	elastic_scene_box(&s, 4, 0.4, 0.2, 1.2, 0.6)->velocity[0] = v0;
	struct scene_wall *floor = elastic_scene_line(&s, 0.0, 0.2, 3.0, 0.2);
	floor->friction = mu;
	struct mpm *mpm = start(scene);
	double at = mean_position(mpm, 0), m = sum_mass(mpm);
	double worst = 0.0;
	for (int k = 0; k < 2000; k += 10) {
		steps(mpm, 10);
		mpm_measure(mpm);
		worst = fmax(worst, fabs(mpm->ledger.energy_residual));
	}
	double way = mean_position(mpm, 0) - at, heat = mpm->ledger.work_walls_friction;
	print_message(
		"slide: way %.4f of %.4f m, friction heat %.4f of the kinetic energy, residual %.3g %%, numerical %.3g %%\n",
		way, v0 * v0 / (2 * mu * g), heat / (0.5 * m * v0 * v0), 100 * worst / (0.5 * m * v0 * v0),
		100 * mpm->ledger.loss_numerical / (0.5 * m * v0 * v0));
	assert_near(way, v0 * v0 / (2 * mu * g), 0.03 * way);
	assert_near(heat, 0.5 * m * v0 * v0, 0.03 * 0.5 * m * v0 * v0);
	assert_near(mpm->walls[0].friction_heat, heat, 1e-12 * heat);
	assert_true(worst < 1e-4 * 0.5 * m * v0 * v0);
	mpm_free(mpm);
}

/* Down a wedge of 45 degrees whose face goes through nodes: acceleration g (sin - mu cos). */
static void test_wedge(void **state)
{
	(void)state;
	const double mu_all[3] = {0.0, 0.3, 1.2}, g = 9.81, c = sqrt(0.5);
	for (int k = 0; k < 3; k++) {
		struct elastic_scene s;
		double mu = mu_all[k];
		struct scene *scene = elastic_scene_init(&s, 40, 40, 0.05, 1e6, 0.2, 1000.0, 2e-4);
		scene->gravity[1] = -g;
		scene->mpm.pic_fraction = mu > 1.0 ? 0.3 : 0.05; /* what sticks must be able to calm down */
		const double wedge[] = {0.0, 0.0, 2.0, 0.0, 0.0, 2.0};
		elastic_scene_wall(&s, SCENE_WALL_POLYGON, 3, wedge)->friction = mu;
		const double block[] = {0.2, 1.8, 0.6, 1.4, 0.75, 1.55, 0.35, 1.95};
		elastic_scene_body(&s, 4, 4, block);
		struct mpm *mpm = start(scene);
		const double along[2] = {c, -c};
		steps(mpm, 500);
		double v1 = (sum_momentum(mpm, 0) * along[0] + sum_momentum(mpm, 1) * along[1]) / sum_mass(mpm);
		double heat1 = (mpm_measure(mpm), mpm->ledger.work_walls_friction);
		double x1 = mean_position(mpm, 0), y1 = mean_position(mpm, 1);
		steps(mpm, 1500);
		double v2 = (sum_momentum(mpm, 0) * along[0] + sum_momentum(mpm, 1) * along[1]) / sum_mass(mpm);
		double expected = g * c * (1 - mu) > 0 ? g * c * (1 - mu) : 0.0, measured = (v2 - v1) / (1500 * 2e-4);
		mpm_measure(mpm);
		double way = (mean_position(mpm, 0) - x1) * along[0] + (mean_position(mpm, 1) - y1) * along[1];
		double friction = mu * sum_mass(mpm) * g * c * way, heat = mpm->ledger.work_walls_friction - heat1;
		print_message(
			"wedge mu = %.1f: acceleration %.4f, expected %.4f; heat %.5g of %.5g J; residual %.3g J of %.4g J\n", mu,
			measured, expected, heat, friction, mpm->ledger.energy_residual, mpm->ledger.energy_kinetic);
		assert_near(measured, expected, 0.03 * g * c);
		if (expected > 0.0)
			assert_near(heat, friction, 0.03 * sum_mass(mpm) * g * c * way);
		mpm_free(mpm);
	}
}

/* A plate presses a free column at 0.02 m/s: its reaction is the stress of the column, also where all around a
 * confining pressure acts that the nodes at the plate do not feel. */
static void press_column(double confining)
{
	struct elastic_scene s;
	const double E = 1e6, h = 0.1, height = 1.0, speed = 0.02;
	struct scene *scene = elastic_scene_init(&s, 8, 16, h, E, 0.0, 1000.0, 5e-4);
	scene->mpm.damping_particle = 20.0;
	scene->mpm.confining_pressure = confining;
	elastic_scene_box(&s, 4, 0.2, 0.2, 0.6, 0.2 + height);
	elastic_scene_line(&s, 0.0, 0.2, 0.8, 0.2);
	struct scene_wall *plate = elastic_scene_line(&s, 0.8, 0.2 + height, 0.0, 0.2 + height);
	plate->velocity[1] = -speed;
	struct mpm *mpm = start(scene);
	double worst = 0.0;
	for (int k = 0; k < 4000; k += 10) {
		steps(mpm, 10);
		mpm_measure(mpm);
		worst = fmax(worst, fabs(mpm->ledger.energy_residual));
	}
	/* half way up, away from the nodes of the plate, which do not move with it */
	double stress = 0.0, width = 0.0, n = 0.0;
	for (int k = 0; k < mpm->p.n; k++)
		if (fabs(mpm->p.x0[k][1] - 0.2 - 0.5 * height) < 2.0 * h)
			stress += mpm->p.stress[k][1], width += 0.4 * mpm->p.F[k][0], n += 1.0;
	stress /= n, width /= n;
	print_message("plate: reaction %.4g N, mean stress %.4g Pa on %.4g m2, nominal %.4g Pa, work %.4g J, elastic %.4g "
				  "J, loss %.3g J, residual %.3g %%\n",
				  mpm->walls[1].force[1], stress, width, -E * speed * 2.0 / height, mpm->ledger.work_boundary,
				  mpm->ledger.energy_elastic, mpm->ledger.loss_numerical, 100 * worst / mpm->ledger.work_boundary);
	assert_near(mpm->walls[1].force[1], -width * stress, 0.02 * fabs(width * stress));
	assert_near(mpm->walls[0].force[1], width * stress, 0.02 * fabs(width * stress));
	assert_true(worst < 1e-3 * mpm->ledger.work_boundary);
	mpm_free(mpm);
}

static void test_plate(void **state)
{
	(void)state;
	press_column(0.0);
	press_column(2e4);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_column),
		cmocka_unit_test(test_bars_collide),
		cmocka_unit_test(test_confining_pressure),
		cmocka_unit_test(test_slide_to_rest),
		cmocka_unit_test(test_wedge),
		cmocka_unit_test(test_plate),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
