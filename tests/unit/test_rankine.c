/* The law neohookean_rankine against closed forms: softening and its energy, heat of stretching, objectivity, free
 * energy. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "../common/law_point.h"
#include "../common/near.h"

/* Steel, as weak as strains have to stay small for closed forms. */
static const double E = 190e9, STRENGTH = 57e6, GF = 22.13e3, CELL = 1.0, ALPHA = 1e-5;

static struct scene_law steel(double poisson)
{
	struct scene_law law = {.name = "steel", .type = SCENE_LAW_RANKINE};
	law.rankine = (struct scene_law_rankine){.young = E,
											 .poisson = poisson,
											 .expansion = ALPHA,
											 .strength = STRENGTH,
											 .fracture_energy = GF,
											 .heat_share = 1.0,
											 .cell = CELL};
	return law;
}

static int stretch(struct point *p, double xx, double yy, double xy, double dT)
{
	const double L[4] = {xx, xy, 0.0, yy};
	return point_advance(p, L, dT, 1.0);
}

/* A bar with nu = 0: E e up to the strength, then a straight line to nothing at 2 Gf / (strength l). */
static void test_bar(void **state)
{
	(void)state;
	struct point p;
	struct scene_law law = steel(0.0);
	law.rankine.expansion = 0.0;
	const double l = sqrt(2.0) * CELL, last = 2.0 * GF / (STRENGTH * l), peak = STRENGTH / E, step = peak / 200.0;
	double work = 0.0, before = 0.0, damage = 0.0;
	point_begin(&p, &law);
	for (double e = step; e < 1.3 * last; e += step) {
		assert_int_equal(stretch(&p, step, 0.0, 0.0, 0.0), STATUS_OK);
		double expected = e < peak ? E * e : fmax(STRENGTH * (last - e) / (last - peak), 0.0);
		assert_near(p.stress[0][0], expected, 3e-3 * STRENGTH);
		assert_true(p.damage[0] >= damage);
		damage = p.damage[0];
		work += 0.5 * (before + p.stress[0][0]) * step;
		before = p.stress[0][0];
	}
	assert_near(p.damage[0], 1.0, 0.0);
	assert_near(p.modulus[0], 0.0, 0.0);
	struct law_ledger ledger = ledger_of(&p);
	assert_near(work, GF / l, 3e-3 * GF / l);
	assert_near(ledger.fracture, GF / l, 3e-3 * GF / l);
	assert_near(ledger.elastic, 0.0, 1e-9 * GF / l);
	/* let go and pulled again it bears nothing */
	for (int k = 0; k < 100; k++)
		stretch(&p, -step, 0.0, 0.0, 0.0);
	assert_near(p.damage[0], 1.0, 0.0);
	assert_near(p.stress[0][0], 0.0, 0.0);
	law_free(p.law);
}

/* Unloading goes back along the secant, and compression leaves a whole bar whole. */
static void test_secant(void **state)
{
	(void)state;
	struct point p;
	struct scene_law law = steel(0.0);
	const double peak = STRENGTH / E;
	law.rankine.expansion = 0.0;
	for (int unilateral = 0; unilateral < 2; unilateral++) {
		law.rankine.unilateral = unilateral;
		point_begin(&p, &law);
		stretch(&p, -5.0 * peak, 0.0, 0.0, 0.0);
		assert_near(p.damage[0], 0.0, 0.0);
		stretch(&p, 5.0 * peak, 0.0, 0.0, 0.0);
		for (int k = 0; k < 140; k++)
			stretch(&p, 0.01 * peak, 0.0, 0.0, 0.0);
		double d = p.damage[0], s = p.stress[0][0];
		assert_in_range((int)(1000 * d), 100, 900);
		for (int k = 0; k < 70; k++)
			stretch(&p, -0.01 * peak, 0.0, 0.0, 0.0);
		assert_near(p.damage[0], d, 0.0);
		assert_near(p.stress[0][0], 0.5 * s, 2e-3 * s);
		for (int k = 0; k < 210; k++)
			stretch(&p, -0.01 * peak, 0.0, 0.0, 0.0);
		assert_near(p.stress[0][0], -1.4 * peak * E * (unilateral ? 1.0 : 1.0 - d), 3e-3 * STRENGTH);
		law_free(p.law);
	}
}

/* d psi = sigma : L dt for any small change of any state, warm ones too, as long as damage rests. */
static void test_free_energy(void **state)
{
	(void)state;
	struct point p;
	struct scene_law law = steel(0.3);
	point_begin(&p, &law);
	p.T[0] = 293.15;
	const double start[4] = {4e-4, 1e-4, -4e-5, 5e-5};
	assert_int_equal(point_advance(&p, start, 2.0, 1.0), STATUS_OK);
	assert_in_range((int)(1000 * p.damage[0]), 100, 990);
	const double back[4] = {-8e-5, 0.0, 0.0, 0.0}; /* R stays above what follows */
	assert_int_equal(point_advance(&p, back, 0.0, 1.0), STATUS_OK);
	struct law_ledger at = ledger_of(&p);
	double J = mat2_determinant(p.F[0]);
	for (int c = 0; c < 4; c++) {
		double L[4] = {0.0}, difference, eps = 1e-7;
		const double s[4] = {p.stress[0][0], p.stress[0][3], p.stress[0][3], p.stress[0][1]};
		double expected = J * s[c];
		L[c] = eps;
		point_advance(&p, L, 0.0, 1.0);
		difference = ledger_of(&p).elastic;
		L[c] = -2.0 * eps;
		point_advance(&p, L, 0.0, 1.0);
		difference -= ledger_of(&p).elastic;
		L[c] = eps;
		point_advance(&p, L, 0.0, 1.0);
		assert_near(difference / (2.0 * eps), expected, 1e-5 * STRENGTH);
	}
	assert_near(ledger_of(&p).elastic, at.elastic, 1e-7 * at.elastic);
	law_free(p.law);
}

/* A turn after the stretch turns the stress and changes nothing else; plane strain keeps sigma_zz. */
static void test_objectivity(void **state)
{
	(void)state;
	struct point p, q;
	struct scene_law law = steel(0.3);
	const double L[4] = {8e-4, 3e-4, 1e-4, -2e-4}, a = 0.7, c = cos(a), s = sin(a);
	const double spin[4] = {0.0, -a, a, 0.0};
	point_begin(&p, &law);
	point_begin(&q, &law);
	for (int k = 0; k < 20; k++) {
		point_advance(&p, L, 0.0, 0.05);
		point_advance(&q, L, 0.0, 0.05);
	}
	point_advance(&q, spin, 0.0, 1.0);
	const double *u = p.stress[0], *v = q.stress[0];
	assert_true(p.damage[0] > 0.1);
	assert_near(q.damage[0], p.damage[0], 1e-12);
	assert_near(v[0], c * c * u[0] - 2.0 * c * s * u[3] + s * s * u[1], 1e-9 * STRENGTH);
	assert_near(v[1], s * s * u[0] + 2.0 * c * s * u[3] + c * c * u[1], 1e-9 * STRENGTH);
	assert_near(v[3], c * s * (u[0] - u[1]) + (c * c - s * s) * u[3], 1e-9 * STRENGTH);
	assert_near(v[2], u[2], 1e-9 * STRENGTH);
	assert_near(ledger_of(&q).elastic, ledger_of(&p).elastic, 1e-12 * STRENGTH);
	law_free(p.law);
	law_free(q.law);
}

/* Heat that a step gives per initial volume, J/m3. */
static double heat_of(const struct point *p) { return p->heat[0] * mat2_determinant(p->F[0]); }

/* Stretching a whole solid cools it by 3 alpha T K dV/V per volume (Kelvin); restrained heating presses by 3 alpha K
 * dT. */
static void test_kelvin(void **state)
{
	(void)state;
	struct point p;
	struct scene_law law = steel(0.3);
	const double K = E / (3.0 * (1.0 - 0.6)), e = 2e-5;
	point_begin(&p, &law);
	p.T[0] = 300.0;
	stretch(&p, e, e, 0.0, 0.0);
	assert_near(heat_of(&p), -3.0 * ALPHA * 300.0 * K * 2.0 * e, 1e-4 * 6.0 * ALPHA * 300.0 * K * e);
	stretch(&p, -e, -e, 0.0, 0.0);
	stretch(&p, 0.0, 0.0, 0.0, 10.0);
	for (int c = 0; c < 3; c++)
		assert_near(p.stress[0][c], -3.0 * ALPHA * K * 10.0, 1e-6 * K * ALPHA);
	law_free(p.law);
}

/* The first law: with the heat given back as temperature, psi + T s + c (T - T0) grows by the work alone, from whole to
 * broken, whatever the path; without its share of heat by what fracture took less. */
static void test_first_law(void **state)
{
	(void)state;
	for (int share = 0; share < 2; share++) {
		struct point p;
		struct scene_law law = steel(0.25);
		law.rankine.heat_share = share;
		const double c = 3.6e6, T0 = 300.0; /* J/(m3 K) */
		point_begin(&p, &law);
		p.T[0] = T0;
		double work = 0.0, given = 0.0, dT = 0.0, coldest = T0;
		for (int k = 0; k < 20000; k++) {
			const double L[4] = {3e-7, 2e-7 * sin(0.001 * k), 0.0, 1e-7 * cos(0.002 * k)}, *s = p.stress[0];
			double J = mat2_determinant(p.F[0]), power = J * (s[0] * L[0] + s[3] * L[1] + s[1] * L[3]);
			assert_int_equal(point_advance(&p, L, dT, 1.0), STATUS_OK);
			J = mat2_determinant(p.F[0]);
			work += 0.5 * (power + J * (s[0] * L[0] + s[3] * L[1] + s[1] * L[3]));
			given += heat_of(&p);
			dT = heat_of(&p) / c;
			coldest = fmin(coldest, p.T[0]);
		}
		struct law_ledger ledger = ledger_of(&p);
		assert_near(p.damage[0], 1.0, 0.0);
		assert_near(ledger.work, work, 2e-4 * work); /* mechanical: elastic + fracture - expansion */
		/* broken, nothing is stored and no entropy held: what was put in is heat, or in the surfaces */
		assert_near(given + (share ? 0.0 : ledger.fracture), work, 1e-3 * work);
		assert_true(coldest < T0 - 1e-3); /* before it breaks */
		assert_near(p.T[0] - T0, given / c, 1e-3 * given / c + 1e-6);
		law_free(p.law);
	}
}

/* Weibull: mean and scatter of many points, the same for the same seed. */
static void test_weibull(void **state)
{
	(void)state;
	enum { N = 40000 };
	struct scene_law scene = steel(0.3);
	scene.rankine.cell = 0.1, scene.rankine.weibull = 8.0, scene.rankine.seed = 7;
	static double strength[2][N];
	static int slot[N], variant[N];
	for (int round = 0; round < 2; round++) {
		struct law *law;
		assert_int_equal(law_create(&law, &scene, N, variant), STATUS_OK);
		for (int k = 0; k < N; k++)
			slot[k] = k;
		law->type->export_field(law, 2, N, slot, strength[round]);
		law_free(law);
	}
	double sum = 0.0, square = 0.0;
	for (int k = 0; k < N; k++)
		sum += strength[0][k] / N, square += strength[0][k] * strength[0][k] / N;
	double a = tgamma(1.0 + 1.0 / 8.0), b = tgamma(1.0 + 2.0 / 8.0);
	assert_memory_equal(strength[0], strength[1], sizeof strength[0]);
	assert_near(sum, STRENGTH, 0.003 * STRENGTH);
	assert_near(sqrt(square - sum * sum) / sum, sqrt(b / (a * a) - 1.0), 0.003);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_bar),         cmocka_unit_test(test_secant), cmocka_unit_test(test_free_energy),
		cmocka_unit_test(test_objectivity), cmocka_unit_test(test_kelvin), cmocka_unit_test(test_first_law),
		cmocka_unit_test(test_weibull),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
