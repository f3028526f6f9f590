/* The thermoelastic law: small strain, objectivity, thermal stress, energy. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "../common/near.h"
#include "base/error.h"
#include "base/mat2.h"
#include "law/law.h"

static const double E = 2e7, NU = 0.3, ALPHA = 1e-4;

/* One point of the law, driven by hand. */
struct point {
	struct law *law;
	double F[1][4], L[1][4], T[1], dT[1], stress[1][4], heat[1], conductivity[1][3], modulus[1];
	int slot[1];
};

static struct law_batch batch_of(struct point *p, double dt)
{
	return (struct law_batch){.n = 1,
							  .slot = p->slot,
							  .F = (const double(*)[4])p->F,
							  .L = (const double(*)[4])p->L,
							  .T = p->T,
							  .dT = p->dT,
							  .dt = dt,
							  .stress = p->stress,
							  .heat = p->heat,
							  .conductivity = p->conductivity,
							  .modulus = p->modulus,
							  .failed = -1};
}

static void point_create(struct point *p, bool plane_stress, double nu)
{
	memset(p, 0, sizeof *p);
	struct scene_law scene = {.name = "elastic", .type = SCENE_LAW_THERMOELASTIC};
	scene.thermoelastic = (struct scene_law_thermoelastic){E, nu, ALPHA, plane_stress};
	int variant = 0;
	assert_int_equal(law_create(&p->law, &scene, 1, &variant), STATUS_OK);
	mat2_identity(p->F[0]);
}

/* F <- exp(L dt) F, then the law. */
static int point_advance(struct point *p, const double L[4], double dT, double dt)
{
	double A[4], e[4];
	memcpy(p->L[0], L, sizeof p->L[0]);
	for (int c = 0; c < 4; c++)
		A[c] = L[c] * dt;
	mat2_exp(A, e);
	mat2_multiply(e, p->F[0], p->F[0]);
	p->dT[0] = dT;
	p->T[0] += dT;
	struct law_batch batch = batch_of(p, dt);
	return p->law->type->advance(p->law, &batch);
}

static struct law_ledger ledger_of(const struct point *p)
{
	struct law_ledger ledger;
	p->law->type->ledger(p->law, 0, &ledger);
	return ledger;
}

/* Hooke's law in plane strain and plane stress, to the order of the strain. */
static void test_small_strain(void **state)
{
	(void)state;
	for (int plane_stress = 0; plane_stress < 2; plane_stress++) {
		struct point p;
		point_create(&p, plane_stress, NU);
		const double L[4] = {3e-7, 2e-7, 4e-7, -1e-7};
		assert_int_equal(point_advance(&p, L, 0.0, 1.0), STATUS_OK);
		double c = plane_stress ? E / (1 - NU * NU) : E * (1 - NU) / ((1 + NU) * (1 - 2 * NU));
		double d = plane_stress ? NU * c : c * NU / (1 - NU);
		assert_near(p.stress[0][0], c * 3e-7 - d * 1e-7, 1e-6 * E * 3e-7);
		assert_near(p.stress[0][1], d * 3e-7 - c * 1e-7, 1e-6 * E * 3e-7);
		assert_near(p.stress[0][2], plane_stress ? 0.0 : NU * (p.stress[0][0] + p.stress[0][1]), 1e-6 * E * 3e-7);
		assert_near(p.stress[0][3], E / (1 + NU) * 3e-7, 1e-6 * E * 3e-7);
		assert_near(p.modulus[0], c, 1e-5 * c);
		law_free(p.law);
	}
}

/* Ten turns: a body without stress keeps none, a stretched one carries its stress around. */
static void test_ten_turns(void **state)
{
	(void)state;
	const double turn = 2.0 * M_PI, rotate[4] = {0.0, -turn, turn, 0.0}, still[4] = {0},
				 stretch[4] = {0.05, 0.03, 0.01, -0.02};
	struct point p, q;
	point_create(&p, false, NU);
	point_create(&q, false, NU);
	assert_int_equal(point_advance(&q, stretch, 0.0, 1.0), STATUS_OK);
	double before[4];
	memcpy(before, q.stress[0], sizeof before);
	for (int step = 0; step < 10000; step++) {
		assert_int_equal(point_advance(&p, rotate, 0.0, 1e-3), STATUS_OK);
		assert_int_equal(point_advance(&q, rotate, 0.0, 1e-3), STATUS_OK);
	}
	assert_int_equal(point_advance(&q, still, 0.0, 1e-3), STATUS_OK);
	for (int c = 0; c < 4; c++) {
		assert_near(p.stress[0][c], 0.0, 1e-12 * E);
		assert_near(q.stress[0][c], before[c], 1e-12 * E);
	}
	/* and half way round it is turned: a quarter of a turn exchanges the normal stresses */
	for (int step = 0; step < 250; step++)
		assert_int_equal(point_advance(&q, rotate, 0.0, 1e-3), STATUS_OK);
	assert_near(q.stress[0][0], before[1], 1e-12 * E);
	assert_near(q.stress[0][1], before[0], 1e-12 * E);
	assert_near(q.stress[0][3], -before[3], 1e-12 * E);
	law_free(p.law);
	law_free(q.law);
}

/* Heat a point that is held: -E alpha dT/(1 - 2 nu) in plane strain, /(1 - nu) in plane stress; free in y,
 * plane strain: /(1 - nu). */
static void test_restrained_heating(void **state)
{
	(void)state;
	const double still[4] = {0}, dT = 10.0;
	struct point p;
	point_create(&p, false, NU);
	assert_int_equal(point_advance(&p, still, dT, 1.0), STATUS_OK);
	for (int c = 0; c < 3; c++)
		assert_near(p.stress[0][c], -E * ALPHA * dT / (1 - 2 * NU), 1e-9 * E);
	struct law_ledger l = ledger_of(&p);
	assert_near(l.elastic, 1.5 * E * ALPHA * dT * ALPHA * dT / (1 - 2 * NU), 1e-12 * E);
	assert_near(l.expansion, l.elastic, 1e-12 * E);
	law_free(p.law);
	point_create(&p, true, NU);
	assert_int_equal(point_advance(&p, still, dT, 1.0), STATUS_OK);
	for (int c = 0; c < 2; c++)
		assert_near(p.stress[0][c], -E * ALPHA * dT / (1 - NU), 1e-9 * E);
	assert_near(p.stress[0][2], 0.0, 1e-9 * E);
	l = ledger_of(&p);
	assert_near(l.elastic, E * ALPHA * dT * ALPHA * dT / (1 - NU), 1e-12 * E);
	law_free(p.law);
	/* free to expand in the plane by alpha dT (1 + nu), plane strain: no stress but out of the plane */
	point_create(&p, false, NU);
	const double grow[4] = {ALPHA * dT * (1 + NU), 0.0, 0.0, ALPHA * dT * (1 + NU)};
	assert_int_equal(point_advance(&p, grow, dT, 1.0), STATUS_OK);
	assert_near(p.stress[0][0], 0.0, 1e-9 * E);
	assert_near(p.stress[0][2], -E * ALPHA * dT, 2e-2 * E * ALPHA * dT);
	law_free(p.law);
}

/* The energy of the law is a potential of its stress: its change along a path is the work of tau on D. */
static void test_energy_is_the_work(void **state)
{
	(void)state;
	for (int plane_stress = 0; plane_stress < 2; plane_stress++) {
		struct point p;
		point_create(&p, plane_stress, NU);
		double work = 0.0, thermal = 0.0;
		const int steps = 20000;
		for (int k = 0; k < steps; k++) {
			double t = (k + 0.5) / steps, old[4], J = mat2_determinant(p.F[0]);
			const double L[4] = {0.3 * cos(5 * t), 0.5 * sin(3 * t), -0.8 * cos(2 * t), 0.2 - 0.6 * t};
			memcpy(old, p.stress[0], sizeof old);
			double dT = 200.0 / steps * cos(4 * t), dt = 1.0 / steps;
			assert_int_equal(point_advance(&p, L, dT, dt), STATUS_OK);
			double K = mat2_determinant(p.F[0]), *s = p.stress[0];
			work += 0.5 * dt *
					((old[0] * J + s[0] * K) * L[0] + (old[1] * J + s[1] * K) * L[3] +
					 (old[3] * J + s[3] * K) * (L[1] + L[2]));
			thermal -= 0.5 * ALPHA * dT * ((old[0] + old[1] + old[2]) * J + (s[0] + s[1] + s[2]) * K);
		}
		struct law_ledger l = ledger_of(&p);
		assert_true(l.elastic > 1e4);
		assert_near(l.expansion, thermal, 1e-9 * l.elastic);
		assert_near(l.elastic, work + thermal, 1e-7 * l.elastic);
		assert_near(l.work, l.elastic - l.expansion, 1e-12 * l.elastic);
		p.law->type->reset_ledger(p.law, 0);
		l = ledger_of(&p);
		assert_near(l.expansion, 0.0, 0.0);
		law_free(p.law);
	}
}

/* Uniaxial: tau = M ln(lambda), far beyond the series. */
static void test_large_strain(void **state)
{
	(void)state;
	struct point p;
	point_create(&p, false, NU);
	const double L[4] = {0.0, 0.0, 0.0, -0.7};
	assert_int_equal(point_advance(&p, L, 0.0, 1.0), STATUS_OK);
	double m = E * (1 - NU) / ((1 + NU) * (1 - 2 * NU));
	assert_near(p.stress[0][1], m * -0.7 / exp(-0.7), 1e-12 * m);
	assert_near(p.stress[0][0], p.stress[0][1] * NU / (1 - NU), 1e-12 * m);
	assert_true(p.modulus[0] >= m * 1.7 / exp(-0.7) * (1 - 1e-12));
	law_free(p.law);
}

/* A point turned inside out stops the run and says which. */
static void test_inside_out(void **state)
{
	(void)state;
	struct point p;
	point_create(&p, false, NU);
	p.F[0][0] = -0.1;
	struct law_batch batch = batch_of(&p, 1.0);
	assert_int_equal(p.law->type->advance(p.law, &batch), STATUS_GUARD);
	assert_int_equal(batch.failed, 0);
	assert_non_null(strstr(error_message(), "det F"));
	law_free(p.law);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_small_strain),       cmocka_unit_test(test_ten_turns),
		cmocka_unit_test(test_restrained_heating), cmocka_unit_test(test_energy_is_the_work),
		cmocka_unit_test(test_large_strain),       cmocka_unit_test(test_inside_out),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
