/* The thermoelastic law: small strain, objectivity, thermal stress, energy. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "../common/law_point.h"
#include "../common/near.h"

static const double E = 2e7, NU = 0.3, ALPHA = 1e-4;

static void point_create_kind(struct point *p, bool plane_stress, bool neo_hookean, double nu)
{
	struct scene_law scene = {.name = "elastic", .type = SCENE_LAW_THERMOELASTIC};
	scene.thermoelastic = (struct scene_law_thermoelastic){E, nu, ALPHA, plane_stress, neo_hookean};
	point_begin(p, &scene);
}

static void point_create(struct point *p, bool plane_stress, double nu)
{
	point_create_kind(p, plane_stress, false, nu);
}

/* Hooke's law in plane strain and plane stress, to the order of the strain. */
static void test_small_strain(void **state)
{
	(void)state;
	for (int kind = 0; kind < 3; kind++) {
		struct point p;
		bool plane_stress = kind == 1;
		point_create_kind(&p, plane_stress, kind == 2, NU);
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
static void ten_turns(bool neo_hookean)
{
	const double turn = 2.0 * M_PI, rotate[4] = {0.0, -turn, turn, 0.0}, still[4] = {0},
				 stretch[4] = {0.05, 0.03, 0.01, -0.02};
	struct point p, q;
	point_create_kind(&p, false, neo_hookean, NU);
	point_create_kind(&q, false, neo_hookean, NU);
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

static void test_ten_turns(void **state)
{
	(void)state;
	ten_turns(false);
	ten_turns(true);
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
	for (int kind = 0; kind < 3; kind++) {
		struct point p;
		point_create_kind(&p, kind == 1, kind == 2, NU);
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

/* The same for the neo-Hookean law: tau = mu (l^2 - 1) + lambda ln l, pressed to half and drawn to four times, warm;
 * and its energy keeps its digits at a strain of 1e-7. */
static void test_neo_hookean(void **state)
{
	(void)state;
	const double mu = E / (2 * (1 + NU)), lambda = E * NU / ((1 + NU) * (1 - 2 * NU)), dT = 30.0;
	for (int k = 0; k < 2; k++) {
		struct point p;
		point_create_kind(&p, false, true, NU);
		double l = k ? 4.0 : 0.5, hot = exp(ALPHA * dT), e = l / hot, ln_j = log(e / (hot * hot));
		const double L[4] = {log(l), 0.0, 0.0, 0.0};
		assert_int_equal(point_advance(&p, L, dT, 1.0), STATUS_OK);
		assert_near(p.stress[0][0], (mu * (e * e - 1) + lambda * ln_j) / l, 1e-13 * E * l);
		assert_near(p.stress[0][1], (mu * (1 / (hot * hot) - 1) + lambda * ln_j) / l, 1e-13 * E * l);
		assert_near(p.stress[0][2], p.stress[0][1], 1e-13 * E * l);
		assert_near(ledger_of(&p).elastic,
					0.5 * mu * (e * e + 2 / (hot * hot) - 3 - 2 * ln_j) + 0.5 * lambda * ln_j * ln_j,
					1e-13 * E * l * l);
		law_free(p.law);
	}
	struct point p;
	point_create_kind(&p, false, true, NU);
	const double L[4] = {1e-7, 0.0, 0.0, 0.0};
	assert_int_equal(point_advance(&p, L, 0.0, 1.0), STATUS_OK);
	double m = lambda + 2 * mu;
	assert_near(ledger_of(&p).elastic, 0.5 * m * 1e-14, 1e-6 * m * 1e-14);
	law_free(p.law);
}

/* Deformations over the domain of the Hencky law, turned and sheared. */
static void sample(int k, int n, double most, double F[4])
{
	double a = log(0.22) + (log(most) - log(0.22)) * (k % n) / (n - 1), b = a + (log(most) - a) * (k / n) / (n - 1);
	double turn = 0.7 * k, axis = 1.3 * k;
	const double R[4] = {cos(turn), -sin(turn), sin(turn), cos(turn)};
	const double Q[4] = {cos(axis), -sin(axis), sin(axis), cos(axis)}, S[4] = {exp(a), 0.0, 0.0, exp(b)};
	mat2_multiply(R, S, F);
	mat2_multiply(F, Q, F);
}

/* The derivative of P = J sigma F^-T is that of its differences, along any direction. */
static void test_piola_derivative(void **state)
{
	(void)state;
	const double G[4] = {0.7, -0.4, 0.9, 0.3}, d = 1e-3, weight[4] = {1.0 / 12, -2.0 / 3, 2.0 / 3, -1.0 / 12};
	for (int kind = 0; kind < 3; kind++) {
		struct point p;
		point_create_kind(&p, kind == 1, kind == 2, NU);
		for (int k = 0; k < 36; k++) {
			double F[4], dP[4], sum[4] = {0.0}, scale = 0.0;
			sample(k, 6, 1.37, F);
			p.law->type->piola_derivative(p.law, F, G, dP);
			for (int s = 0; s < 4; s++) {
				double inverse[4];
				for (int c = 0; c < 4; c++)
					p.F[0][c] = F[c] + (s < 2 ? s - 2 : s - 1) * d * G[c];
				struct law_batch batch = batch_of(&p, 1.0);
				assert_int_equal(p.law->type->evaluate(p.law, &batch), STATUS_OK);
				mat2_inverse(p.F[0], inverse);
				const double *t = p.stress[0], J = mat2_determinant(p.F[0]);
				const double sigma[4] = {t[0], t[3], t[3], t[1]};
				const double transposed[4] = {inverse[0], inverse[2], inverse[1], inverse[3]};
				double P[4];
				mat2_multiply(sigma, transposed, P);
				for (int c = 0; c < 4; c++)
					sum[c] += weight[s] * J * P[c] / d;
			}
			for (int c = 0; c < 4; c++)
				scale = fmax(scale, fabs(dP[c]));
			for (int c = 0; c < 4; c++)
				assert_near(sum[c], dP[c], 1e-6 * scale);
		}
		law_free(p.law);
	}
}

/* The modulus bounds the acoustic tensor, 1/J of A : (n F^T n), and is no more than 1.01 times its fastest wave (twice,
 * of the Hencky law under strong compression); that tensor is positive where the law says it is valid. */
static void test_modulus(void **state)
{
	(void)state;
	for (int kind = 0; kind < 2; kind++) {
		struct point p;
		point_create_kind(&p, false, kind == 1, NU);
		double loosest = 0.0, least = INFINITY;
		for (int k = 0; k < 100; k++) {
			double most = 0.0;
			sample(k, 10, kind ? 3.0 : 1.39, p.F[0]);
			const double *F = p.F[0];
			struct law_batch batch = batch_of(&p, 1.0);
			assert_int_equal(p.law->type->evaluate(p.law, &batch), STATUS_OK);
			for (int i = 0; i < 60; i++) {
				double n[2] = {cos(M_PI * i / 60), sin(M_PI * i / 60)}, q[2][2], J = mat2_determinant(F);
				double N[2] = {F[0] * n[0] + F[2] * n[1], F[1] * n[0] + F[3] * n[1]};
				for (int c = 0; c < 2; c++) {
					const double G[4] = {c ? 0.0 : N[0], c ? 0.0 : N[1], c ? N[0] : 0.0, c ? N[1] : 0.0};
					double dP[4];
					p.law->type->piola_derivative(p.law, F, G, dP);
					q[0][c] = (dP[0] * N[0] + dP[1] * N[1]) / J, q[1][c] = (dP[2] * N[0] + dP[3] * N[1]) / J;
				}
				double mean = 0.5 * (q[0][0] + q[1][1]), r = hypot(0.5 * (q[0][0] - q[1][1]), q[0][1]);
				assert_near(q[0][1], q[1][0], 1e-9 * fabs(mean));
				most = fmax(most, mean + r);
				least = fmin(least, mean - r);
			}
			assert_true(p.modulus[0] >= most * (1.0 - 1e-3)); /* of the 60 directions */
			loosest = fmax(loosest, p.modulus[0] / most);
		}
		print_message("%s: modulus at most %.2f of the acoustic tensor, whose least eigenvalue is %.3g E\n",
					  kind ? "neo-Hookean" : "Hencky", loosest, least / E);
		assert_true(loosest < (kind ? 1.01 : 2.0));
		assert_true(least > 0.0);
		law_free(p.law);
	}
}

/* Walked past on both sides the Hencky law stops the run, and says where its validity ended; heat that stretches the
 * point freely does not count, and the neo-Hookean law walks on. */
static void test_domain(void **state)
{
	(void)state;
	const double limit[2] = {1.3956, 0.2116};
	for (int k = 0; k < 2; k++) {
		const double L[4] = {k ? -1.0 : 1.0, 0.4, -0.4, 0.0};
		struct point p, q;
		point_create(&p, false, NU);
		point_create_kind(&q, false, true, NU);
		int status = STATUS_OK, steps = 0;
		double e[3] = {0.0};
		while (status == STATUS_OK && steps++ < 10000) {
			mat2_log_stretch(p.F[0], e);
			status = point_advance(&p, L, 0.0, 1e-3);
		}
		double r = hypot(0.5 * (e[0] - e[1]), e[2]), last = exp(0.5 * (e[0] + e[1]) + (k ? -r : r));
		assert_int_equal(status, STATUS_GUARD);
		assert_non_null(strstr(error_message(), "leaves its domain of validity"));
		assert_non_null(strstr(error_message(), "neo_hookean"));
		assert_near(last, limit[k], 2e-3 * limit[k]);
		for (int i = 0; i < 2 * steps; i++)
			assert_int_equal(point_advance(&q, L, 0.0, 1e-3), STATUS_OK);
		law_free(p.law);
		law_free(q.law);
	}
	struct point p;
	point_create(&p, false, NU);
	const double grow[4] = {0.5, 0.0, 0.0, 0.5};
	assert_int_equal(point_advance(&p, grow, 0.5 / ALPHA, 1.0), STATUS_OK);
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
		cmocka_unit_test(test_small_strain),
		cmocka_unit_test(test_ten_turns),
		cmocka_unit_test(test_restrained_heating),
		cmocka_unit_test(test_energy_is_the_work),
		cmocka_unit_test(test_large_strain),
		cmocka_unit_test(test_inside_out),
		cmocka_unit_test(test_neo_hookean),
		cmocka_unit_test(test_piola_derivative),
		cmocka_unit_test(test_modulus),
		cmocka_unit_test(test_domain),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
