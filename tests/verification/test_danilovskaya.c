/* The Danilovskaya bar (TM-DEMPM section 5.1.1): a thermal shock on the free end of a half space, waves and
 * diffusion together, against the exact solution.  E = rho = c = k = 1. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

#include "../common/elastic_scene.h"
#include "../common/near.h"
#include "base/error.h"
#include "mpm/mpm.h"

static const double EXPANSION = 1e-6, SHOCK = 100.0, H = 0.02;

/* exp(x^2) erfc(x). */
static double erfcx(double x)
{
	if (x < 10.0)
		return exp(x * x) * erfc(x);
	double y = 1.0 / (2.0 * x * x);
	return (1.0 - y * (1.0 - 3.0 * y * (1.0 - 5.0 * y))) / (x * sqrt(M_PI));
}

static double exact_temperature(double x, double t) { return erfc(x / (2.0 * sqrt(t))); }

/* sigma / (beta T1) */
static double exact_stress(double x, double t)
{
	double r = sqrt(t), g = exp(-x * x / (4.0 * t)), zp = x / (2.0 * r) + r, zm = x / (2.0 * r) - r;
	if (t < x)
		return -0.5 * (exp(t - x) * erfc(zm) + g * erfcx(zp));
	return 0.5 * g * (erfcx(-zm) - erfcx(zp));
}

/* u / (beta T1) */
static double exact_displacement(double x, double t)
{
	double r = sqrt(t), g = exp(-x * x / (4.0 * t)), zp = x / (2.0 * r) + r, zm = x / (2.0 * r) - r;
	double common = -2.0 * sqrt(t / M_PI) * g + x * erfc(x / (2.0 * r));
	if (t < x)
		return common + 0.5 * (exp(t - x) * erfc(zm) - g * erfcx(zp));
	return 1.0 - 0.5 * g * (erfcx(-zm) + erfcx(zp)) - 2.0 * sqrt(t / M_PI) * g + x * erfc(x / (2.0 * r));
}

static void test_table(void **state)
{
	(void)state;
	const double table[4][4] = {{0.5, .317311, -.405224, .034675},
								{0.9, .456057, -.778878, .177455},
								{1.5, .563703, .077180, .061831},
								{3.0, .683091, .035836, -.383844}};
	for (int k = 0; k < 4; k++) {
		assert_near(exact_temperature(1.0, table[k][0]), table[k][1], 1e-6);
		assert_near(exact_stress(1.0, table[k][0]), table[k][2], 1e-6);
		assert_near(exact_displacement(1.0, table[k][0]), table[k][3], 1e-6);
	}
}

/* 300 cells with one point each; x = 1 lies on a node: the mean of its two neighbours. */
static struct mpm *bar(struct elastic_scene *s, double pic)
{
	struct scene *scene = elastic_scene_init(s, 300, 1, H, 1.0, 0.0, 1.0, 1e-4);
	scene->mpm.pic_fraction = pic;
	elastic_scene_heat(s, EXPANSION, 1.0, 1.0);
	elastic_scene_box(s, 1, 0.0, 0.0, 6.0, H)->temperature = 0.0;
	elastic_scene_boundary(s, 0.0, 0.0, 0.0, H)->temperature = SHOCK;
	elastic_scene_boundary(s, 0.0, 0.0, 6.0, H)->velocity[1] = 0.0;
	elastic_scene_boundary(s, 6.0, 0.0, 6.0, H)->velocity[0] = 0.0;
	struct mpm *mpm;
	if (mpm_create(&mpm, scene) != STATUS_OK)
		fail_msg("%s", error_message());
	return mpm;
}

/* With hardly any PIC nothing smears the front, and before it the error is that of the grid. */
static void test_before_the_front(void **state)
{
	(void)state;
	struct elastic_scene s;
	struct mpm *mpm = bar(&s, 1e-4);
	double sum = 0.0;
	for (int step = 1; step <= 8000; step++) {
		if (mpm_step(mpm) != STATUS_OK)
			fail_msg("%s", error_message());
		int a = mpm_point_by_id(mpm, 49), b = mpm_point_by_id(mpm, 50);
		double sigma =
			0.5 * (mpm->p.stress[a][0] + mpm->p.stress[b][0]) / (EXPANSION * SHOCK) - exact_stress(1.0, mpm->time);
		sum += sigma * sigma / 8000;
	}
	print_message("rms: sigma %.2g before the front\n", sqrt(sum));
	assert_true(sqrt(sum) < 3e-4);
	mpm_free(mpm);
}

static void test_bar(void **state)
{
	(void)state;
	struct elastic_scene s;
	struct mpm *mpm = bar(&s, 0.01);
	double T2 = 0.0, early = 0.0, late = 0.0, u2 = 0.0, worst = 0.0;
	int n_early = 0, n_late = 0, n = 0;
	const double scale = EXPANSION * SHOCK;
	for (int step = 1; step <= 30000; step++) {
		if (mpm_step(mpm) != STATUS_OK)
			fail_msg("%s", error_message());
		if (step % 50 || step < 500)
			continue;
		int a = mpm_point_by_id(mpm, 49), b = mpm_point_by_id(mpm, 50);
		const struct particles *p = &mpm->p;
		double t = mpm->time, T = 0.5 * (p->T[a] + p->T[b]) / SHOCK - exact_temperature(1.0, t);
		double sigma = 0.5 * (p->stress[a][0] + p->stress[b][0]) / scale - exact_stress(1.0, t);
		double u = 0.5 * (p->x[a][0] - p->x0[a][0] + p->x[b][0] - p->x0[b][0]) / scale - exact_displacement(1.0, t);
		T2 += T * T, u2 += u * u, n++;
		if (t < 0.8)
			early += sigma * sigma, n_early++;
		if (t > 1.3)
			late += sigma * sigma, n_late++;
		mpm_measure(mpm);
		worst = fmax(worst, fabs(mpm->ledger.energy_residual) / mpm->ledger.work_expansion);
	}
	print_message("rms: T %.2g, sigma %.2g before the front, %.2g behind it, u %.2g; energy residual %.2g %% of the "
				  "work of expansion\n",
				  sqrt(T2 / n), sqrt(early / n_early), sqrt(late / n_late), sqrt(u2 / n), 100 * worst);
	assert_true(sqrt(T2 / n) < 1e-4);
	assert_true(sqrt(early / n_early) < 4e-3);
	assert_true(sqrt(late / n_late) < 1e-3);
	assert_true(sqrt(u2 / n) < 8e-3);
	assert_true(worst < 1e-6);
	mpm_free(mpm);
}

int main(void)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(test_table), cmocka_unit_test(test_before_the_front),
									   cmocka_unit_test(test_bar)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
