/* timeout: 600
 *
 * A cylinder on a rigid plane (scenarios/dp_mpm/hertz.cfg) against Hertz: root mean square error of the pressure that
 * the nodes of the face see, by the force that comes to each, within 0.13, 0.10 and 0.07 of its largest value on cells
 * of 0.2, 0.1 and 0.05 mm, falling; the force on the plane within 1% of the load. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

#include "../common/elastic_scene.h"
#include "../common/near.h"

static const double FORCE = 78.35, RADIUS = 8e-3, YOUNG = 10e9, THICKNESS = 1e-3; /* N, m, Pa, m: of the half */

static double hat(double x) { return fabs(x) < 1.0 ? 1.0 - fabs(x) : 0.0; }

/* Pressure that a node i of the face sees: the force that comes to it over its share of the face. */
static double nodal(const struct mpm *mpm, int i)
{
	enum { SAMPLES = 32 };
	double sum = 0.0, h = mpm->grid.h, face = 0.5 * h;
	for (int k = 0; k < mpm->p.n; k++)
		for (int s = 0; s < SAMPLES && mpm->p.contact_pressure[k] > 0.0; s++) {
			double x = mpm->p.x0[k][0] + face * ((s + 0.5) / SAMPLES - 0.5);
			sum += mpm->p.contact_pressure[k] * face / SAMPLES * hat(x / h - i);
		}
	return sum / (i == 0 ? 0.5 * h : h);
}

/* What it should be by Hertz, with half width b and pressure `most` in the middle. */
static double exact(int i, double h, double b, double most)
{
	enum { SAMPLES = 4000 };
	double sum = 0.0;
	for (int s = 0; s < SAMPLES; s++) {
		double x = (s + 0.5) / SAMPLES * b;
		sum += most * sqrt(1.0 - x * x / (b * b)) * hat(x / h - i) * b / SAMPLES;
	}
	return sum / (i == 0 ? 0.5 * h : h);
}

/* Of the nodes that should or do feel pressure, relative to the largest. */
static double error_of(const struct mpm *mpm, double *centre)
{
	double load = 2.0 * FORCE / THICKNESS, b = sqrt(4.0 * load * RADIUS / (M_PI * YOUNG));
	double most = 2.0 * load / (M_PI * b), h = mpm->grid.h, sum = 0.0;
	int n = 0;
	for (int i = 0;; i++) {
		double found = nodal(mpm, i), expected = exact(i, h, b, most);
		if (found == 0.0 && expected == 0.0)
			break;
		sum += (found - expected) * (found - expected), n++;
		if (i == 0)
			*centre = found / expected;
	}
	return sqrt(sum / n) / most;
}

static double press(double cell, double *force, double *centre)
{
	struct scene *scene;
	char sets[2][64];
	snprintf(sets[0], sizeof sets[0], "grid.cell=%g", cell);
	snprintf(sets[1], sizeof sets[1], "time.step=%g", 8e-5 * cell);
	const char *const set[] = {sets[0], sets[1]};
	assert_int_equal(scene_load(&scene, SOURCE_DIR "/scenarios/dp_mpm/hertz.cfg", 2, set, stderr), STATUS_OK);
	struct mpm *mpm = start(scene);
	steps(mpm, (int)lround(scene->time.end / scene->time.step));
	*force = -mpm->walls[0].force[1];
	double error = error_of(mpm, centre);
	mpm_free(mpm);
	scene_free(scene);
	return error;
}

#ifndef CELLS
#define CELLS 2 /* test_hertz_long.c goes on to the third */
#endif

static void test_hertz(void **state)
{
	(void)state;
	static const struct {
		double cell, bound;
	} cases[] = {{0.2e-3, 0.13}, {0.1e-3, 0.10}, {0.05e-3, 0.07}};
	double last = INFINITY;
	for (size_t k = 0; k < CELLS; k++) {
		double force, centre = NAN, error = press(cases[k].cell, &force, &centre);
		print_message("cell %g mm: error %.4f, force %.3f of the load, pressure at the centre %.3f of the exact one\n",
					  1e3 * cases[k].cell, error, force / FORCE, centre);
		assert_near(force, FORCE, 0.01 * FORCE);
		assert_true(error <= cases[k].bound);
		assert_true(error < last);
		last = error;
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(test_hertz)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
