/* timeout: 120 */
/* Quiet RVEs: their discs wait while little happens; what that must not change, and how wrong it may be. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include "../common/near.h"
#include "../common/rve_case.h"
#include "base/mat2.h"

static const double pressure = 10e3, dt = 1e-4;

static void start(struct rve_case *c, double change)
{
	struct rve_params params;
	rve_params_default(&params);
	params.quiet_change = change;
	case_start_loose(c, &params, pressure);
}

static void test_logarithm(void **arg)
{
	(void)arg;
	static const double cases[][4] = {
		{0}, {1e-9, 3e-9, -2e-9, 1e-9}, {0.1, 0.3, -0.2, -0.4}, {-0.2, 1.2, -1.1, 0.1}, {0.5, 0.4, 0.6, -0.5}};
	for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
		double e[4], a[4];
		mat2_exp(cases[k], e);
		mat2_log(e, a);
		for (int c = 0; c < 4; c++)
			assert_near(a[c], cases[k][c], 4e-16 + 1e-14 * fabs(cases[k][c]));
	}
}

/* What the discs do with the sum is what they do with it in one call. */
static void test_waits_then_goes_the_whole_way(void **arg)
{
	(void)arg;
	const double L[4] = {0.0, 2e-3, -1e-3, -3e-3}; /* 10 Pa in a call */
	struct rve_case quiet, busy;
	start(&quiet, 0.02), start(&busy, 0.0);
	double before[4];
	rve_evaluate(quiet.model, quiet.state, before, quiet.conductivity, &quiet.modulus);
	struct rve_info info;
	int calls = 0;
	do {
		case_advance(&quiet, L, 0.0, dt, 1);
		info = case_info(&quiet);
		assert_true(fabs(quiet.stress[1] - before[1]) <= 0.021 * pressure || info.quiet_caught == 1);
		assert_int_equal(quiet.heat == 0.0, info.quiet_caught == 0);
	} while (++calls < 1000 && info.quiet_caught == 0);
	assert_in_range(calls, 5, 200);
	assert_int_equal(info.quiet_calls, calls - 1);
	assert_int_equal(info.quiet_waiting, 0);
	assert_true(info.total_sub_steps > 0);
	double whole[4] = {calls * L[0], calls * L[1], calls * L[2], calls * L[3]};
	case_advance(&busy, whole, 0.0, dt, 1);
	struct rve_info other = case_info(&busy);
	for (int k = 0; k < 4; k++) {
		assert_near(info.H[k], other.H[k], 1e-12 * fabs(other.H[0]));
		assert_near(info.F[k], other.F[k], 1e-12);
	}
	assert_int_equal(info.total_sub_steps, other.total_sub_steps);
	assert_near(quiet.stress[1], busy.stress[1], 1e-6 * pressure);
	assert_near(info.friction, other.friction, 1e-6 * other.friction);
	case_end(&quiet), case_end(&busy);
}

/* To and fro, warmer and colder, a ledger that starts anew while discs wait: all the work is somewhere. */
static void test_energy(void **arg)
{
	(void)arg;
	struct rve_case c;
	start(&c, 0.05);
	struct rve_info info = case_info(&c);
	double worked = info.work, turnover = 0.0;
	int anew = 0;
	rve_evaluate(c.model, c.state, c.stress, c.conductivity, &c.modulus);
	for (int k = 0; k < 600; k++) {
		const double s = (k % 50 < 20 ? 1.0 : -0.7) * (k < 400 ? 4e-2 : 0.3);
		const double L[4] = {s, 0.5 * s, 0.2 * s, -0.6 * s};
		double from[4];
		memcpy(from, c.stress, sizeof from);
		case_advance(&c, L, k % 7 == 0 ? 2e-3 : 0.0, dt, 1);
		info = case_info(&c);
		double volume = mat2_determinant(info.F) * info.volume0, work = 0.0;
		work += 0.5 * (from[0] + c.stress[0]) * L[0] + 0.5 * (from[1] + c.stress[1]) * L[3];
		work += 0.5 * (from[3] + c.stress[3]) * (L[1] + L[2]);
		worked += work * volume * dt, turnover += fabs(work * volume * dt);
		if (!anew && k >= 300 && info.quiet_waiting > 0) {
			anew = 1;
			rve_reset_ledger(c.model, c.state);
			info = case_info(&c);
			assert_near(info.work, info.elastic + info.kinetic, 1e-15);
			worked = info.work, turnover = 0.0;
		}
		assert_near(case_residual(&info), 0.0, 4e-3 * (turnover + info.elastic));
	}
	print_message("  %lld calls waited, %lld caught up, discarded %.3g of %.3g J\n", info.quiet_calls,
				  info.quiet_caught, info.discarded, turnover);
	assert_true(anew && info.quiet_calls > 100 && info.quiet_caught >= 10);
	/* the ledger's work is the scene's where discs waited; where they moved it is their own, finer sum */
	assert_near(info.work, worked, 0.02 * turnover);
	assert_true(fabs(info.discarded) < 0.05 * turnover);
	assert_true(info.quiet_error_most > 0.0 && info.quiet_error_sum < 0.05 * (double)info.quiet_caught);
	case_end(&c);
}

/* A quiet RVE may turn as it likes: its stress turns with it, and nothing else happens. */
static void test_turns(void **arg)
{
	(void)arg;
	const double w = 4.0 / (800 * dt), L[4] = {0.0, -w, w, 0.0};
	struct rve_case c;
	start(&c, 0.0);
	static const double rest[4] = {0}, shear[4] = {0.0, 0.2, 0.0, 0.0};
	case_advance(&c, shear, 0.0, dt, 10);
	case_advance(&c, rest, 0.0, dt, 5000); /* until no contact slides */
	c.model->params.quiet_change = 0.02;
	double before[4];
	memcpy(before, c.stress, sizeof before);
	assert_true(fabs(before[3]) > 100.0);
	struct rve_info info = case_info(&c);
	double friction = info.friction;
	long long steps = info.total_sub_steps;
	case_advance(&c, L, 0.0, dt, 800);
	info = case_info(&c);
	double cs = cos(4.0), sn = sin(4.0);
	double xx = cs * cs * before[0] + sn * sn * before[1] - 2.0 * cs * sn * before[3];
	double xy = cs * sn * (before[0] - before[1]) + (cs * cs - sn * sn) * before[3];
	assert_near(c.stress[0], xx, 2e-3 * pressure); /* the discs go on calming down */
	assert_near(c.stress[3], xy, 2e-3 * pressure);
	assert_near(info.friction, friction, 1e-9);
	assert_in_range(info.total_sub_steps - steps, 100, 300); /* once in 0.02 rad */
	case_end(&c);
}

/* Against RVEs that always move, along a path of small loads: the stress stays within the bound. */
static void test_error_is_bounded(void **arg)
{
	(void)arg;
	const double change = 0.05;
	struct rve_case quiet, busy;
	start(&quiet, change), start(&busy, 0.0);
	double sum = 0.0, square = 0.0;
	const int calls = 2000;
	for (int k = 0; k < calls; k++) {
		double s = 6e-3 * sin(0.01 * k);
		const double L[4] = {-0.3 * s, s, 0.0, s};
		case_advance(&quiet, L, 0.0, dt, 1);
		case_advance(&busy, L, 0.0, dt, 1);
		double off = (quiet.stress[1] - busy.stress[1]) / pressure;
		sum += off, square += off * off;
	}
	struct rve_info info = case_info(&quiet), other = case_info(&busy);
	assert_true(fabs(sum / calls) < change);
	assert_true(sqrt(square / calls) < change);
	assert_true(4 * info.total_sub_steps < other.total_sub_steps);
	print_message("  rms %.4f of the pressure, %lld of %lld DEM steps\n", sqrt(square / calls), info.total_sub_steps,
				  other.total_sub_steps);
	case_end(&quiet), case_end(&busy);
}

/* Bonds melt when they must, also those of discs that wait. */
static void test_bonds_melt(void **arg)
{
	(void)arg;
	static const double rest[4] = {0};
	struct rve_params params;
	rve_params_default(&params);
	params.quiet_change = 0.05, params.bond_strength = 0.02, params.bond_melting = 1.0;
	struct rve_case c;
	case_start_loose(&c, &params, pressure);
	rve_install_bonds(c.model, c.state);
	case_advance(&c, rest, 0.09, dt, 11);
	struct rve_info info = case_info(&c);
	assert_true(info.quiet_waiting > 0 && info.bonds_intact > 0);
	assert_near(info.temperature, 0.99, 1e-12);
	case_advance(&c, rest, 0.09, dt, 1);
	info = case_info(&c);
	assert_int_equal(info.bonds_intact, 0);
	assert_near(info.temperature, 1.08, 1e-12);
	case_end(&c);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_logarithm),        cmocka_unit_test(test_waits_then_goes_the_whole_way),
		cmocka_unit_test(test_energy),           cmocka_unit_test(test_turns),
		cmocka_unit_test(test_error_is_bounded), cmocka_unit_test(test_bonds_melt),
	};
	return CASE_RUN_ON_EACH_PATH(tests);
}
