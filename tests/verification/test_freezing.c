/* Freezing and thawing against Neumann's similarity solution of the half space, and the heat that they take. */
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

static const double MELTING = 273.15, END = 0.1;

/* The half space of the table with its defaults, in kelvin. */
struct half_space {
	const struct exact_solution *s;
	double p[EXACT_PARAMETERS_MAX], surface, start; /* K */
};

static double parameter(const struct half_space *h, const char *name) { return h->p[exact_parameter(h->s, name)]; }

static struct half_space half_space_init(double surface, double begin)
{
	struct half_space h = {.s = exact_find("neumann"), .surface = surface, .start = begin};
	exact_defaults(h.s, h.p);
	h.p[exact_parameter(h.s, "temperature_melting")] = MELTING;
	h.p[exact_parameter(h.s, "temperature_surface")] = surface;
	h.p[exact_parameter(h.s, "temperature_start")] = begin;
	return h;
}

static double exact_temperature(const struct half_space *h, double x, double t)
{
	const double X[2] = {x, 0.0};
	return exact_value(h->s, h->p, X, t, EXACT_TEMPERATURE);
}

static double exact_front(const struct half_space *h, double t)
{
	double low = 0.0, high = 1.0;
	for (int k = 0; k < 50; k++) {
		double x = 0.5 * (low + high);
		*((exact_temperature(h, x, t) > MELTING) == (h->surface > MELTING) ? &low : &high) = x;
	}
	return low;
}

static void freeze(struct elastic_scene *s, const struct half_space *h, double width)
{
	struct scene_material *m = &s->materials[0];
	elastic_scene_heat(s, 0.0, parameter(h, "heat_capacity"), parameter(h, "conductivity"));
	m->freezing[0] = MELTING - 0.5 * width, m->freezing[1] = MELTING + 0.5 * width;
	m->latent_heat = parameter(h, "latent_heat");
	m->heat_capacity_frozen = parameter(h, "heat_capacity_frozen");
	m->conductivity_frozen = parameter(h, "conductivity_frozen");
}

/* A bar of 1.6 m, one row of cells.  The interval of freezing has a width, K, that may be zero. */
static struct mpm *bar(struct elastic_scene *s, const struct half_space *half, double h, double width)
{
	double limit = parameter(half, "heat_capacity_frozen") * h * h / (2.0 * parameter(half, "conductivity_frozen"));
	struct scene *scene = elastic_scene_init(s, (int)lround(1.6 / h), 1, h, 1e-3, 0.0, 1.0, 0.8 * limit);
	freeze(s, half, width);
	elastic_scene_box(s, 4, 0.0, 0.0, 1.6, h)->temperature = half->start;
	elastic_scene_boundary(s, 0.0, 0.0, 0.0, h)->temperature = half->surface;
	return start(scene);
}

struct errors {
	double temperature; /* rms over the bar and the second half of the run, of the whole range */
	double front;       /* m, at the end, by the share of the bar that has changed */
	double heat;        /* residual, of the heat given */
};

static struct errors errors_of(double surface, double begin, double h, double width)
{
	struct elastic_scene s;
	struct half_space half = half_space_init(surface, begin);
	struct errors e = {0.0, 0.0, 0.0};
	struct mpm *mpm = bar(&s, &half, h, width);
	int samples = 0, every = (int)lround(END / 40.0 / mpm->dt);
	double changed = 0.0;
	while (mpm->time < END) {
		ok(mpm_step(mpm));
		for (int k = 0; mpm->time > 0.5 * END && mpm->step % every == 0 && k < mpm->p.n; k++, samples++)
			e.temperature += pow(mpm->p.T_smooth[k] - exact_temperature(&half, mpm->p.x[k][0], mpm->time), 2.0);
	}
	for (int k = 0; k < mpm->p.n; k++)
		changed += (surface > MELTING ? mpm->p.thawed[k] : 1.0 - mpm->p.thawed[k]) * mpm->p.volume0[k] / h;
	mpm_measure(mpm);
	e.temperature = sqrt(e.temperature / samples) / fabs(surface - begin);
	e.front = fabs(changed - exact_front(&half, mpm->time));
	e.heat = fabs(mpm->ledger.heat_residual) / fmax(mpm->ledger.heat_in, mpm->ledger.heat_out);
	print_message("%s, h = %g m, interval %g K: temperature %.2e of the range, front %.2e of %.3g m, heat %.1e\n",
				  surface > MELTING ? "thawing" : "freezing", h, width, e.temperature, e.front,
				  exact_front(&half, mpm->time), e.heat);
	mpm_free(mpm);
	return e;
}

/* Both errors fall with the grid, and the ledger closes. */
static void converges(double surface, double begin)
{
	struct errors e[3];
	for (int k = 0; k < 3; k++) {
		e[k] = errors_of(surface, begin, 0.04 / (1 << k), 0.0);
		assert_true(e[k].heat < 1e-9);
	}
	assert_true(e[0].temperature / e[2].temperature > 2.8); /* order 3/4 at least */
	assert_true(e[0].front / e[2].front > 2.8);
	assert_true(e[2].temperature < 4e-3);
	assert_true(e[2].front < 0.3 * 0.01); /* of a cell */
}

static void test_freezing(void **state)
{
	(void)state;
	converges(263.15, 278.15);
}

static void test_thawing(void **state)
{
	(void)state;
	converges(293.15, 268.15);
}

/* The width of the interval changes little as long as it is small, and loses no heat however small it is. */
static void test_interval(void **state)
{
	(void)state;
	const double widths[] = {1e-9, 1e-3, 0.2};
	for (int k = 0; k < 3; k++) {
		struct errors e = errors_of(263.15, 278.15, 0.02, widths[k]);
		assert_true(e.heat < 1e-9);
		assert_true(e.temperature < 8e-3);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_freezing),
		cmocka_unit_test(test_thawing),
		cmocka_unit_test(test_interval),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
