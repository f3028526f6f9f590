/* Freezing and thawing against Neumann's similarity solution of the half space, and the heat that they take. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

#include "../common/elastic_scene.h"
#include "../common/near.h"
#include "mpm/mpm.h"

static const double MELTING = 273.15, LATENT = 80.0;
static const double C[2] = {2.0, 4.0}, K[2] = {2.2, 0.6}; /* frozen, thawed; density 1 */

/* A half space at `start` whose face is held at `face`, on the other side of MELTING. */
struct neumann {
	double face, start;
	int near;            /* the phase at the face: 0 frozen, 1 thawed */
	double diffusivity[2];
	double lambda;       /* the front lies at 2 lambda sqrt(a_near t) */
};

/* Balance of heat at the front (Carslaw & Jaeger, Conduction of Heat in Solids, 11.2), zero at lambda. */
static double balance(const struct neumann *n, double lambda)
{
	int i = n->near, o = 1 - i;
	double ratio = sqrt(n->diffusivity[i] / n->diffusivity[o]), near = fabs(MELTING - n->face),
		   far = fabs(n->start - MELTING);
	return exp(-lambda * lambda) / erf(lambda) -
		   K[o] / K[i] * ratio * far / near * exp(-lambda * lambda * ratio * ratio) / erfc(lambda * ratio) -
		   lambda * LATENT * sqrt(M_PI) / (C[i] * near);
}

static struct neumann neumann_init(double face, double start)
{
	struct neumann n = {.face = face, .start = start, .near = face > start};
	double low = 1e-6, high = 3.0;
	for (int phase = 0; phase < 2; phase++)
		n.diffusivity[phase] = K[phase] / C[phase];
	for (int k = 0; k < 100; k++) {
		n.lambda = 0.5 * (low + high);
		*(balance(&n, n.lambda) > 0.0 ? &low : &high) = n.lambda;
	}
	return n;
}

static double neumann_front(const struct neumann *n, double t) { return 2.0 * n->lambda * sqrt(n->diffusivity[n->near] * t); }

static double neumann_temperature(const struct neumann *n, double x, double t)
{
	double a = n->diffusivity[n->near], b = n->diffusivity[1 - n->near];
	if (x < neumann_front(n, t))
		return n->face + (MELTING - n->face) * erf(x / (2.0 * sqrt(a * t))) / erf(n->lambda);
	return n->start + (MELTING - n->start) * erfc(x / (2.0 * sqrt(b * t))) / erfc(n->lambda * sqrt(a / b));
}

static void freeze(struct elastic_scene *s, double low, double high)
{
	s->materials[0].freezing[0] = low, s->materials[0].freezing[1] = high;
	s->materials[0].latent_heat = LATENT;
	s->materials[0].heat_capacity_frozen = C[0], s->materials[0].conductivity_frozen = K[0];
}

/* A bar of 1.5 m, one row of cells.  The interval of freezing has a width, K, that may be zero. */
static struct mpm *bar(struct elastic_scene *s, const struct neumann *n, double h, double width, double dt)
{
	struct scene *scene = elastic_scene_init(s, (int)lround(1.5 / h), 1, h, 1e-3, 0.0, 1.0, dt);
	elastic_scene_heat(s, 0.0, C[1], K[1]);
	freeze(s, MELTING - 0.5 * width, MELTING + 0.5 * width);
	elastic_scene_box(s, 4, 0.0, 0.0, 1.5, h)->temperature = n->start;
	elastic_scene_boundary(s, 0.0, 0.0, 0.0, h)->temperature = n->face;
	return start(scene);
}

struct errors {
	double temperature; /* rms over the bar and the run, of the whole range */
	double front;       /* m, at the end */
	double heat;        /* residual of the heat given */
};

static struct errors neumann_errors(double face, double begin, double h, double width)
{
	struct elastic_scene s;
	struct neumann n = neumann_init(face, begin);
	struct errors e = {0.0, 0.0, 0.0};
	double dt = 0.4 * C[0] * h * h / K[0], changed = 0.0;
	struct mpm *mpm = bar(&s, &n, h, width, dt);
	int samples = 0;
	while (mpm->time < 0.4) {
		ok(mpm_step(mpm));
		for (int k = 0; mpm->time > 0.1 && k < mpm->p.n; k++, samples++)
			e.temperature += pow(mpm->p.T_smooth[k] - neumann_temperature(&n, mpm->p.x[k][0], mpm->time), 2.0);
	}
	for (int k = 0; k < mpm->p.n; k++)
		changed += (n.near ? mpm->p.thawed[k] : 1.0 - mpm->p.thawed[k]) * mpm->p.volume0[k] / h;
	mpm_measure(mpm);
	e.temperature = sqrt(e.temperature / samples) / fabs(face - begin);
	e.front = fabs(changed - neumann_front(&n, mpm->time));
	e.heat = fabs(mpm->ledger.heat_residual) / fmax(mpm->ledger.heat_in, mpm->ledger.heat_out);
	print_message("%s, h = %g m, interval %g K: temperature %.2e of the range, front %.2e of %.3g m, heat %.1e\n",
				  n.near ? "thawing" : "freezing", h, width, e.temperature, e.front, neumann_front(&n, mpm->time), e.heat);
	mpm_free(mpm);
	return e;
}

/* Both errors fall with the grid, and the ledger closes. */
static void converges(double face, double begin, double width)
{
	const double sizes[] = {0.05, 0.025, 0.0125};
	struct errors e[3];
	for (int k = 0; k < 3; k++) {
		e[k] = neumann_errors(face, begin, sizes[k], width);
		assert_true(e[k].heat < 1e-9);
	}
	assert_true(e[0].temperature / e[2].temperature > 2.8); /* order 3/4 at least */
	assert_true(e[2].temperature < 4e-3);
	assert_true(e[2].front < 2e-3);
}

static void test_freezing(void **state)
{
	(void)state;
	converges(263.15, 278.15, 0.0);
}

static void test_thawing(void **state)
{
	(void)state;
	converges(293.15, 268.15, 0.0);
}

int main(void)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(test_freezing), cmocka_unit_test(test_thawing)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
