/* timeout: 180 */
/* The laws that an RVE keeps, each with its bound. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include "../common/near.h"
#include "../common/rve_case.h"
#include "base/mat2.h"

static const double rest[4] = {0};

/* Objectivity: turned by 4 rad in 800 steps, the stress is Q sigma Q^T of the same RVE held still for as many
 * steps, and the turn itself has rubbed nothing. */
static void test_rigid_rotation(void **arg)
{
	(void)arg;
	static const double densities[] = {0.01, 0.5};
	struct rve_params params;
	rve_params_default(&params);
	for (int k = 0; k < 2; k++) {
		struct rve_packing *packing = case_packing(100e3, densities[k], 1);
		struct rve_case turned, still;
		case_start(&turned, &params, packing);
		case_start(&still, &params, packing);
		rve_packing_free(packing);
		const double spin = 4.0 / (800 * 1e-4), L[4] = {0.0, -spin, spin, 0.0}, angle[4] = {0.0, -4.0, 4.0, 0.0};
		case_advance(&turned, L, 0.0, 1e-4, 800);
		case_advance(&still, rest, 0.0, 1e-4, 800);
		double Q[4], Qt[4], s[4] = {still.stress[0], still.stress[3], still.stress[3], still.stress[1]};
		mat2_exp(angle, Q);
		Qt[0] = Q[0], Qt[1] = Q[2], Qt[2] = Q[1], Qt[3] = Q[3];
		mat2_multiply(Q, s, s);
		mat2_multiply(s, Qt, s);
		assert_near(turned.stress[0] / 100e3, s[0] / 100e3, 1e-9);
		assert_near(turned.stress[1] / 100e3, s[3] / 100e3, 1e-9);
		assert_near(turned.stress[3] / 100e3, s[1] / 100e3, 1e-9);
		struct rve_info a = case_info(&turned), b = case_info(&still);
		assert_near((a.friction - b.friction) / a.elastic, 0.0, 1e-12);
		assert_near(a.volume / b.volume, 1.0, 1e-12);
		assert_near(a.void_ratio, b.void_ratio, 1e-12);
		case_end(&turned);
		case_end(&still);
	}
}

/* The ledger closes: work + expansion = elastic + kinetic + friction + dashpot within 1e-3 of the work for I <= 4e-4,
 * 4e-3 at fifty times that pace. */
static void test_energy_is_accounted_for(void **arg)
{
	(void)arg;
	static const struct {
		double strain_per_step, heating, bound;
	} cases[] = {{4e-6, 0.0, 1e-3}, {4e-6, 0.05, 1e-3}, {5e-5, 0.0, 2e-3}, {5e-5, 0.25, 2e-3}, {2e-4, 0.0, 4e-3}};
	for (int k = 0; k < 5; k++) {
		struct rve_params params;
		struct rve_case c;
		rve_params_default(&params);
		params.strain_per_step = cases[k].strain_per_step;
		params.pressure_scaling = 0;
		params.n_max = 0;
		case_start_loose(&c, &params, 100e3);
		const double L[4] = {0.0, 1.0, 0.0, 0.0};
		double start = case_info(&c).work;
		case_advance(&c, L, cases[k].heating, 1e-3, 100);
		struct rve_info info = case_info(&c);
		double off = case_residual(&info) / (info.work - start);
		print_message("  I = %.1e, %g K: residual %.1e of the work, dashpot %.1f%%\n", info.inertial_number,
					  info.temperature, off, 100.0 * info.dashpot / (info.work - start));
		assert_near(off, 0.0, cases[k].bound);
		assert_true(info.friction > 0.5 * (info.work - start));
		/* the heat of a call is the friction of the call */
		double friction = info.friction;
		case_advance(&c, L, 0.0, 1e-3, 1);
		info = case_info(&c);
		assert_near(c.heat * info.volume * 1e-3, info.friction - friction, 1e-12 * info.friction);
		case_end(&c);
	}
}

/* A square lattice of 20 x 20 discs of 5 mm: D1111 = kn / z; warmed by 50 K between fixed sides it presses by D1111
 * beta dT more. */
static void test_square_lattice(void **arg)
{
	(void)arg;
	struct rve_params params;
	rve_params_default(&params);
	const struct rve_packing_params how = {.discs = 400,
										   .radius_min = 5e-3,
										   .radius_max = 5e-3,
										   .pressure = 100e3,
										   .mu = 0.5,
										   .void_ratio = NAN,
										   .seed = 1,
										   .square_lattice = 1};
	struct rve_packing *packing;
	struct rve_case c;
	assert_int_equal(rve_packing_generate(&packing, &how, &params), STATUS_OK);
	case_start(&c, &params, packing);
	rve_packing_free(packing);
	struct rve_info info = case_info(&c);
	assert_near(info.void_ratio, 0.254, 1e-3);
	assert_near(info.pressure, 100e3, 1e-6);
	assert_near(info.coordination, 4.0, 1e-12);
	assert_near(info.elastic_tensor[0] / 13.37e6, 1.0, 5e-3);
	assert_near(info.elastic_tensor[0], params.kn / params.thickness, 1e-6 * info.elastic_tensor[0]);
	rve_evaluate(c.model, c.state, c.stress, c.conductivity, &c.modulus);
	assert_near(c.conductivity[0], 0.134, 1e-3);
	assert_near(c.modulus, info.elastic_tensor[0], 1e-6 * c.modulus);
	/* the tangent is what a small strain measures */
	const double before = c.stress[0], probe[4] = {1e-6, 0.0, 0.0, 0.0};
	case_advance(&c, probe, 0.0, 1.0, 1);
	case_advance(&c, rest, 0.0, 1e-3, 2000);
	assert_near((c.stress[0] - before) / 1e-6 / info.elastic_tensor[0], 1.0, 1e-3);
	const double back[4] = {-1e-6, 0.0, 0.0, 0.0};
	case_advance(&c, back, 0.0, 1.0, 1);
	/* thermal stress: -D1111 beta dT = -66.7 kPa to first order */
	case_advance(&c, rest, 0.5, 1e-3, 100);
	case_advance(&c, rest, 0.0, 1e-3, 2000);
	assert_near(c.stress[0] - before, -67.2e3, 0.1e3);
	info = case_info(&c);
	assert_near(info.void_ratio, 0.242, 1e-3);
	assert_near(case_residual(&info) / info.work, 0.0, 1e-9);
	case_end(&c);
}

/* Forty times round: the cell is re-based again and again and nothing is lost. */
static void test_shear_strain_of_forty(void **arg)
{
	(void)arg;
	struct rve_params params;
	struct rve_case c;
	rve_params_default(&params);
	params.strain_per_step = 4e-4;
	params.n_max = 0;
	case_start_loose(&c, &params, 100e3);
	const double L[4] = {0.0, 1.0, 0.0, 0.0};
	double start = case_info(&c).work, volume = case_info(&c).volume, ratio = 0.0;
	for (int k = 0; k < 4000; k++) {
		case_advance(&c, L, 0.0, 1e-2, 1);
		ratio += c.stress[3] / case_info(&c).pressure / 4000;
	}
	struct rve_info info = case_info(&c);
	double a = hypot(info.H[0], info.H[2]), b = hypot(info.H[1], info.H[3]),
		   ab = info.H[0] * info.H[1] + info.H[2] * info.H[3];
	print_message("  shear stress / pressure %.3f, residual %.1e of the work, %d lists\n", ratio,
				  case_residual(&info) / (info.work - start), info.rebuilds);
	assert_near(info.F[1], 40.0, 1e-9);
	assert_near(info.volume / volume, 1.0, 1e-9);
	assert_true(fabs(ab) < 0.6 * fmin(a * a, b * b));
	assert_near(case_residual(&info) / (info.work - start), 0.0, 9e-3);
	assert_near(ratio, 0.287, 0.06);
	assert_int_equal(info.flags, 0);
	case_end(&c);
}

/* Pulled apart the material flies: no stress, no cost; pressed together again it is there at the volume at which it
 * left. */
static void test_gas_and_back(void **arg)
{
	(void)arg;
	struct rve_params params;
	struct rve_case c;
	rve_params_default(&params);
	params.n_max = 0;
	case_start_loose(&c, &params, 10e3);
	const double apart[4] = {0.5, 0.2, -0.1, 0.5}, together[4] = {-0.5, 0.3, -0.2, -0.5};
	int gas_after = 0;
	for (int k = 0; k < 400; k++) {
		case_advance(&c, apart, 0.0, 1e-3, 1);
		gas_after += !(case_info(&c).flags & RVE_GAS);
	}
	struct rve_info flying = case_info(&c);
	double stretch = mat2_determinant(flying.F);
	assert_near(stretch, exp(0.4), 1e-9);
	assert_true(flying.flags & RVE_GAS);
	assert_near(gas_after, 1e3 * log(params.gas_stretch), 20.0); /* it left soon after the stretch at which it may */
	assert_near(flying.volume / flying.volume0, stretch, 1e-12);
	assert_near(c.stress[0] + c.stress[1] + c.stress[3], 0.0, 0.0);
	assert_near(c.modulus, 0.0, 0.0);
	assert_near(case_residual(&flying) / flying.discarded, 0.0, 0.05);
	long long steps = flying.total_sub_steps;
	case_advance(&c, together, 0.01, 1e-3, 100);
	assert_int_equal(case_info(&c).total_sub_steps, steps);
	case_advance(&c, together, 0.0, 1e-3, 310);
	struct rve_info back = case_info(&c);
	assert_int_equal(back.flags, 0);
	assert_true(back.total_sub_steps > steps);
	assert_true(back.pressure > 1e3);
	/* the volume of the cell is that of the point again */
	assert_near(back.volume / back.volume0 / mat2_determinant(back.F), 1.0, 1e-9);
	assert_near(case_residual(&back) / (back.friction + back.elastic), 0.0, 5e-3);
	case_end(&c);
}

/* A cell can be stretched so far.  Under stress it then stops and is flagged, keeps its stress and its books. */
static void test_a_slender_cell_is_frozen(void **arg)
{
	(void)arg;
	struct rve_params params;
	struct rve_case c;
	rve_params_default(&params);
	params.strain_per_step = 4e-4;
	params.n_max = 0;
	case_start_loose(&c, &params, 100e3);
	const double stretch[4] = {1.0, 0.0, 0.0, -1.0};
	int calls = 0;
	double start = case_info(&c).work;
	while (!(case_info(&c).flags & RVE_FROZEN) && calls < 4000) {
		case_advance(&c, stretch, 0.0, 1e-3, 1);
		calls++;
	}
	struct rve_info info = case_info(&c);
	print_message("  frozen at a stretch of %.2f, residual %.1e of the work\n", exp(1e-3 * calls),
				  case_residual(&info) / (info.work - start));
	assert_true(info.flags & RVE_FROZEN);
	assert_near(exp(1e-3 * calls), 6.0, 1.5);
	assert_near(case_residual(&info) / (info.work - start), 0.0, 9e-3);
	/* it turns with the material */
	double p = -0.5 * (c.stress[0] + c.stress[1]), t = hypot(0.5 * (c.stress[0] - c.stress[1]), c.stress[3]);
	const double turn[4] = {0.0, -5.0, 5.0, 0.0};
	case_advance(&c, turn, 0.0, 1e-3, 100);
	assert_near(-0.5 * (c.stress[0] + c.stress[1]), p, 1e-9 * p);
	assert_near(hypot(0.5 * (c.stress[0] - c.stress[1]), c.stress[3]), t, 1e-9 * p);
	/* and gives way to a fresh one once it is pulled apart */
	const double apart[4] = {1.0, 0.0, 0.0, 1.0};
	case_advance(&c, apart, 0.0, 1e-3, 70);
	info = case_info(&c);
	assert_int_equal(info.reseeded, 1);
	assert_true(!(info.flags & RVE_FROZEN));
	assert_near(info.volume / info.volume0, mat2_determinant(info.F), 1e-9);
	assert_near(case_residual(&info) / (info.work - start), 0.0, 9e-3);
	case_end(&c);
}

/* Without stress a slender cell is replaced at once. */
static void test_a_slender_cell_without_stress_is_replaced(void **arg)
{
	(void)arg;
	struct rve_params params;
	struct rve_case c;
	rve_params_default(&params);
	params.strain_per_step = 4e-4;
	params.n_max = 0;
	params.gas = 0;
	case_start_loose(&c, &params, 10e3);
	const double apart[4] = {1.0, 0.0, 0.0, 1.0}, stretch[4] = {1.0, 0.0, 0.0, -1.0};
	case_advance(&c, apart, 0.0, 1e-3, 250);
	case_advance(&c, stretch, 0.0, 1e-3, 3000);
	struct rve_info info = case_info(&c);
	assert_true(info.reseeded >= 1);
	assert_near(info.volume / info.volume0, mat2_determinant(info.F), 1e-8);
	assert_near(info.void_ratio, (1.0 + rve_void_ratio(c.model, 0)) * mat2_determinant(info.F) - 1.0, 1e-8);
	case_end(&c);
}

/* The number of sub-steps follows the strain of a call and the pressure; where n_max cuts it, that is counted. */
static void test_sub_steps_follow_the_strain(void **arg)
{
	(void)arg;
	struct rve_params params;
	struct rve_case c;
	rve_params_default(&params);
	case_start_loose(&c, &params, 100e3);
	const double L[4] = {1.0, 0.0, 0.0, -1.0};
	case_advance(&c, rest, 0.0, 1e-3, 1);
	assert_int_equal(case_info(&c).sub_steps, 1);
	case_advance(&c, L, 0.0, 4.9e-4, 1);
	assert_in_range(case_info(&c).sub_steps, 10, 11); /* 100 kPa within the packing's tolerance */
	assert_int_equal(case_info(&c).clamped, 0);
	case_advance(&c, L, 0.0, 4e-3, 1);
	assert_int_equal(case_info(&c).sub_steps, params.n_max);
	assert_int_equal(case_info(&c).clamped, 1);
	case_end(&c);
	case_start_loose(&c, &params, 100e3); /* discs that grow strain their contacts as a motion would */
	case_advance(&c, rest, 4.9, 1e-3, 1);
	assert_in_range(case_info(&c).sub_steps, 10, 11);
	case_end(&c);
	case_start_loose(&c, &params, 10e3); /* at a tenth of the pressure steps are smaller by its root */
	case_advance(&c, L, 0.0, 1.5e-4, 1);
	assert_in_range(case_info(&c).sub_steps, 9, 11);
	unsigned calls = 0;
	struct rve_info info = case_info(&c);
	for (int bin = 0; bin < 12; bin++)
		calls += info.inertia[bin];
	assert_int_equal(calls, 1);
	case_end(&c);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_rigid_rotation),
		cmocka_unit_test(test_energy_is_accounted_for),
		cmocka_unit_test(test_square_lattice),
		cmocka_unit_test(test_shear_strain_of_forty),
		cmocka_unit_test(test_gas_and_back),
		cmocka_unit_test(test_a_slender_cell_is_frozen),
		cmocka_unit_test(test_a_slender_cell_without_stress_is_replaced),
		cmocka_unit_test(test_sub_steps_follow_the_strain),
	};
	return CASE_RUN_ON_EACH_PATH(tests);
}
