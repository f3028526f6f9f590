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
#include "exact/exact.h"
#include "mpm/mpm.h"

static const double EXPANSION = 1e-6, SHOCK = 100.0, H = 0.02;

/* In the units of the table: T/T1, sigma/(beta T1), u/(beta T1). */
static double exact(enum exact_field field, double x, double t)
{
	const struct exact_solution *solution = exact_find("danilovskaya");
	double parameters[EXACT_PARAMETERS_MAX], X[2] = {x, 0.0};
	exact_defaults(solution, parameters);
	return exact_value(solution, parameters, X, t, field) / (field == EXACT_TEMPERATURE ? SHOCK : EXPANSION * SHOCK);
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
		double t = mpm->time, T = 0.5 * (p->T[a] + p->T[b]) / SHOCK - exact(EXACT_TEMPERATURE, 1.0, t);
		double sigma = 0.5 * (p->stress[a][0] + p->stress[b][0]) / scale - exact(EXACT_STRESS_XX, 1.0, t);
		double u =
			0.5 * (p->x[a][0] - p->x0[a][0] + p->x[b][0] - p->x0[b][0]) / scale - exact(EXACT_DISPLACEMENT_X, 1.0, t);
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
	const struct CMUnitTest tests[] = { cmocka_unit_test(test_bar)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
