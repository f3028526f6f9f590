/* timeout: 120 */
/* Bonds between the discs of an RVE: in closed form on a lattice, and what they keep in a packing. */
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
enum { SIDE = 4, DISCS = SIDE * SIDE };
static const double r = 0.5e-3, lattice_pressure = 10.0;

/* A square lattice that touches with next to no force: each row and each column of discs is one chain, a strain of the
 * cell strains every contact of a chain alike, and no disc moves against the cell. */
static void start_lattice(struct rve_case *c, const struct rve_params *params)
{
	const struct rve_packing_params how = {.discs = DISCS,
										   .radius_min = r,
										   .radius_max = r,
										   .pressure = lattice_pressure,
										   .mu = 0.5,
										   .void_ratio = NAN,
										   .seed = 1,
										   .square_lattice = 1};
	struct rve_packing *packing;
	assert_int_equal(rve_packing_generate(&packing, &how, params), STATUS_OK);
	case_start(c, params, packing);
	rve_packing_free(packing);
	rve_install_bonds(c->model, c->state);
	struct rve_info info = case_info(c);
	assert_int_equal(info.bonds_installed, 2 * DISCS);
	assert_int_equal(info.bonds_intact, 2 * DISCS);
	assert_near(info.bond_fraction, 1.0, 0.0);
}

/* Sub-steps of 1e-5, so slow that dashpots carry next to nothing. */
static struct rve_params bonded_params(double strength)
{
	struct rve_params params;
	rve_params_default(&params);
	params.bond_strength = strength;
	params.strain_per_step = 1e-5;
	params.pressure_scaling = 0;
	params.n_max = 0;
	params.damping_ratio = 0.0;
	return params;
}

static void assert_books_close(const struct rve_case *c, double relative_to)
{
	struct rve_info info = case_info(c);
	assert_near(case_residual(&info) / relative_to, 0.0, 1e-3);
}

/* Pulled along x the chains bear F = beta kn r each, reached at a gap of beta r; then x carries nothing, y what it did,
 * and what was stored in the bonds is released. */
static void test_tension(void **arg)
{
	(void)arg;
	const double beta = 0.05, kn = 1e6, z = 0.075, F = beta * kn * r, pull[4] = {1.0, 0.0, 0.0, 0.0};
	struct rve_params params = bonded_params(beta);
	struct rve_case c;
	start_lattice(&c, &params);
	double most = 0.0, length = 0.0, across = case_info(&c).H[3] / SIDE;
	while (case_info(&c).bonds_intact == 2 * DISCS && case_info(&c).F[0] < 1.2) {
		most = fmax(most, c.stress[0]);
		length = case_info(&c).H[0] / SIDE;
		case_advance(&c, pull, 0.0, 1e-5, 1);
	}
	assert_near(most * across * z / F, 1.0, 1e-3);
	assert_near((length - 2.0 * r) / (beta * r), 1.0, 1e-3);
	struct rve_info info = case_info(&c);
	assert_int_equal(info.bonds_intact, DISCS);
	assert_int_equal(info.n_contacts, DISCS);
	assert_near(c.stress[0], 0.0, 1e-6 * most);
	assert_near(info.bond / (DISCS * 0.5 * F * F / kn), 1.0, 2e-3);
	assert_near(info.friction, 0.0, 0.0);
	assert_books_close(&c, info.bond);
	/* a broken bond pulls no more, and the others go on for good */
	const double push[4] = {-1.0, 0.0, 0.0, 0.0};
	case_advance(&c, push, 0.0, 1e-5, 4000);
	case_advance(&c, pull, 0.0, 1e-5, 8000);
	assert_near(c.stress[0], 0.0, 1e-6 * most);
	assert_int_equal(case_info(&c).bonds_intact, DISCS);
	case_end(&c);
}

/* Sheared by gamma every contact slides by gamma / 2 of its length: f_t = ks gamma r, until mu_b F.  What Coulomb
 * leaves of it is nothing at this pressure, so all is released, and none of it is friction heat. */
static void test_shear(void **arg)
{
	(void)arg;
	const double beta = 0.05, mu_b = 0.4, kn = 1e6, F = beta * kn * r, shear[4] = {0.0, 1.0, 0.0, 0.0};
	struct rve_params params = bonded_params(beta);
	params.bond_mu = mu_b;
	params.mu = 0.0;
	struct rve_case c;
	start_lattice(&c, &params);
	int calls = 0;
	while (case_info(&c).bonds_intact == 2 * DISCS && calls < 100000) {
		case_advance(&c, shear, 0.0, 1e-5, 1);
		calls++;
	}
	assert_near(1e-5 * calls * 1e6 * r / (mu_b * F), 1.0, 2e-3);
	struct rve_info info = case_info(&c);
	assert_int_equal(info.bonds_intact, 0);
	assert_near(info.bond / (2 * DISCS * 0.5 * mu_b * F * mu_b * F / kn), 1.0, 5e-3);
	assert_near(info.friction, 0.0, 0.0);
	assert_near(c.stress[3], 0.0, 10.0);
	assert_books_close(&c, info.bond);
	case_end(&c);
}

/* Pressed as hard as may be, and held by bonds against all of Coulomb, none breaks. */
static void test_compression_never_breaks(void **arg)
{
	(void)arg;
	struct rve_params params = bonded_params(1e-3);
	struct rve_case c;
	const double press[4] = {-1.0, 0.0, 0.0, -1.0};
	start_lattice(&c, &params);
	case_advance(&c, press, 0.0, 1e-4, 2000);
	assert_int_equal(case_info(&c).bonds_intact, 2 * DISCS);
	assert_true(case_info(&c).pressure > 1e6);
	assert_near(case_info(&c).bond, 0.0, 0.0);
	case_end(&c);
}

/* Up to T_c bonds are whole; above it they all go, pressed ones too, and do not come back with the cold. */
static void test_melting(void **arg)
{
	(void)arg;
	struct rve_params params = bonded_params(0.05);
	params.bond_melting = 10.0;
	params.expansion = 0.0;
	struct rve_case c;
	const double press[4] = {-1e-3, 0.0, 0.0, -1e-3}, pull[4] = {1e-3, 0.0, 0.0, 1e-3};
	start_lattice(&c, &params);
	case_advance(&c, press, 0.0, 1.0, 5);
	case_advance(&c, rest, 1.0, 1e-3, 10); /* T = T_c exactly */
	assert_int_equal(case_info(&c).bonds_intact, 2 * DISCS);
	double pressure = case_info(&c).pressure;
	case_advance(&c, rest, 0.01, 1e-3, 1);
	assert_int_equal(case_info(&c).bonds_intact, 0);
	assert_int_equal(case_info(&c).bonds_installed, 2 * DISCS);
	assert_near(case_info(&c).pressure, pressure, 1e-9 * pressure); /* pressed contacts carry on */
	assert_near(case_info(&c).bond, 0.0, 1e-20);
	case_advance(&c, rest, -1.0, 1e-3, 10);
	case_advance(&c, pull, 0.0, 1.0, 20);
	assert_near(c.stress[0], 0.0, 1e-6 * pressure);
	assert_int_equal(case_info(&c).bonds_intact, 0);
	case_end(&c);
}

/* Linear softening: half-way between the reference and T_c half the force, below the reference no more than all. */
static void test_softening(void **arg)
{
	(void)arg;
	static const double temperatures[] = {-20.0, 0.0, 5.0, 9.0}, shares[] = {1.0, 1.0, 0.5, 0.1};
	const double beta = 0.05, z = 0.075, pull[4] = {1.0, 0.0, 0.0, 0.0};
	for (int k = 0; k < 4; k++) {
		struct rve_params params = bonded_params(beta);
		params.bond_melting = 10.0;
		params.bond_reference = 0.0;
		params.expansion = 0.0;
		struct rve_case c;
		start_lattice(&c, &params);
		c.T = temperatures[k];
		double most = 0.0, across = case_info(&c).H[3] / SIDE;
		while (case_info(&c).bonds_intact == 2 * DISCS) {
			case_advance(&c, pull, 0.0, 1e-5, 1);
			most = fmax(most, c.stress[0]);
		}
		assert_near(most * across * z / (shares[k] * beta * params.kn * r), 1.0, 5e-3);
		case_end(&c);
	}
}

/* One sub-step parts the discs by more than the skin and asks for a new list, in which they are no pair any more: their
 * bonds break before, and what they release is booked: 1/2 kn delta_old delta, delta_old = delta + D b. */
static void test_torn_bonds_are_booked(void **arg)
{
	(void)arg;
	struct rve_params params = bonded_params(0.1);
	struct rve_case c;
	const double pull[4] = {4e-2, 0.0, 0.0, 0.0}, tear[4] = {0.08, 0.0, 0.0, -0.12};
	start_lattice(&c, &params);
	case_advance(&c, pull, 0.0, 1.0, 1);
	struct rve_info before = case_info(&c);
	assert_int_equal(before.bonds_intact, 2 * DISCS);
	rve_model_free(c.model);
	params.strain_per_step = 1.0; /* the same model but for this */
	struct rve_case other;
	start_lattice(&other, &params);
	c.model = other.model;
	free(other.state);
	case_advance(&c, tear, 0.0, 1.0, 1);
	struct rve_info info = case_info(&c);
	assert_int_equal(info.sub_steps, 1);
	assert_int_equal(info.rebuilds, before.rebuilds + 1);
	assert_int_equal(info.bonds_intact, DISCS);
	double length = info.H[0] / SIDE, delta = 2.0 * r - length, delta_old = delta + tear[0] * length;
	assert_true(-delta > params.skin * r);
	assert_near((info.bond - before.bond) / (DISCS * 0.5 * params.kn * delta_old * delta), 1.0, 1e-9);
	case_end(&c);
}

/* A bonded cell in tension has no pressure and yet is no gas. */
static void test_tension_is_no_gas(void **arg)
{
	(void)arg;
	struct rve_params params = bonded_params(0.19);
	params.strain_per_step = 1e-4;
	struct rve_case c;
	const double apart[4] = {0.08, 0.0, 0.0, 0.08};
	start_lattice(&c, &params);
	case_advance(&c, apart, 0.0, 0.1, 10);
	assert_true(mat2_determinant(case_info(&c).F) > params.gas_stretch);
	assert_int_equal(case_info(&c).flags, 0);
	assert_int_equal(case_info(&c).bonds_intact, 2 * DISCS);
	assert_true(c.stress[0] > 1e5 && c.stress[1] > 1e5);
	case_end(&c);
}

/* Chains that have come apart fly with the bonds that they have; what melts in flight is melted when they land. */
static void test_bonds_in_flight(void **arg)
{
	(void)arg;
	for (int heated = 0; heated < 2; heated++) {
		struct rve_params params = bonded_params(0.01);
		params.bond_melting = 10.0;
		params.expansion = 0.0;
		struct rve_case c;
		const double apart[4] = {1.0, 0.0, 0.0, 0.0}, together[4] = {-1.0, 0.0, 0.0, 0.0};
		start_lattice(&c, &params);
		case_advance(&c, apart, 0.0, 1e-3, 200);
		assert_true(case_info(&c).flags & RVE_GAS);
		assert_int_equal(case_info(&c).bonds_intact, DISCS);
		case_advance(&c, apart, heated ? 11.0 : 9.0, 1e-3, 1);
		case_advance(&c, together, heated ? -11.0 : -9.0, 1e-3, 1);
		case_advance(&c, together, 0.0, 1e-3, 150);
		assert_int_equal(case_info(&c).flags & RVE_GAS, 0);
		assert_int_equal(case_info(&c).bonds_intact, heated ? 0 : DISCS);
		case_end(&c);
	}
}

/* ---- packings ---- */

static void start_packing(struct rve_case *c, const struct rve_params *params)
{
	case_start_loose(c, params, 25e3);
	rve_install_bonds(c->model, c->state);
	assert_int_equal(case_info(c).bonds_installed, case_info(c).n_contacts);
}

/* An installed bond changes no force, and the conductivity counts it once. */
static void test_installing_changes_nothing(void **arg)
{
	(void)arg;
	struct rve_params params;
	struct rve_case free_case, c;
	rve_params_default(&params);
	case_start_loose(&free_case, &params, 25e3);
	params.bond_strength = 0.02;
	start_packing(&c, &params);
	case_advance(&free_case, rest, 0.0, 1e-4, 1);
	case_advance(&c, rest, 0.0, 1e-4, 1);
	for (int k = 0; k < 4; k++)
		assert_near(c.stress[k], free_case.stress[k], 1.0);
	for (int k = 0; k < 3; k++)
		assert_near(c.conductivity[k], free_case.conductivity[k], 1e-3);
	case_end(&free_case);
	case_end(&c);
}

/* As the unbonded RVE does, a bonded one with bonds that pull turns its stress by 4 rad and loses nothing by it. */
static void test_rigid_rotation(void **arg)
{
	(void)arg;
	struct rve_params params;
	struct rve_case turned, still;
	rve_params_default(&params);
	params.bond_strength = 0.1;
	start_packing(&turned, &params);
	start_packing(&still, &params);
	const double spin = 4.0 / (800 * 1e-4), L[4] = {0.0, -spin, spin, 0.0}, angle[4] = {0.0, -4.0, 4.0, 0.0};
	const double pull[4] = {5.0, 1.0, 1.0, 2.0};
	case_advance(&turned, pull, 0.0, 1e-4, 10);
	case_advance(&still, pull, 0.0, 1e-4, 10);
	case_advance(&turned, L, 0.0, 1e-4, 800);
	case_advance(&still, rest, 0.0, 1e-4, 800);
	double Q[4], Qt[4], s[4] = {still.stress[0], still.stress[3], still.stress[3], still.stress[1]};
	assert_true(still.stress[0] > 10e3);
	mat2_exp(angle, Q);
	Qt[0] = Q[0], Qt[1] = Q[2], Qt[2] = Q[1], Qt[3] = Q[3];
	mat2_multiply(Q, s, s);
	mat2_multiply(s, Qt, s);
	assert_near(turned.stress[0] / 100e3, s[0] / 100e3, 1e-9);
	assert_near(turned.stress[1] / 100e3, s[3] / 100e3, 1e-9);
	assert_near(turned.stress[3] / 100e3, s[1] / 100e3, 1e-9);
	struct rve_info a = case_info(&turned), b = case_info(&still);
	assert_int_equal(a.bonds_intact, b.bonds_intact);
	assert_near((a.bond - b.bond) / a.elastic, 0.0, 1e-11);
	assert_near((a.friction - b.friction) / a.elastic, 0.0, 1e-11);
	case_end(&turned);
	case_end(&still);
}

/* Which pairs are bonded, from inspection: flag of each pair of discs. */
static int bonded_pairs(const struct rve_case *c, unsigned char (*flag)[400])
{
	static struct rve_contact contact[4000];
	int n = rve_inspect(c->model, c->state, NULL, contact, 4000), intact = 0;
	memset(flag, 0, 400 * sizeof *flag);
	for (int k = 0; k < n; k++) {
		flag[contact[k].i][contact[k].j] = (unsigned char)contact[k].bond;
		intact += contact[k].bond == 1;
		assert_true(contact[k].bond == 1 || contact[k].normal_force >= 0.0);
		assert_true(contact[k].mobilisation >= 0.0 && contact[k].mobilisation <= 1.0);
	}
	return intact;
}

/* Through list after list intact bonds stay with their pair, and none comes back; the ledger closes within 8e-3 of the
 * work, whatever the skin leaves beyond the strength. */
static void test_lists_keep_bonds(void **arg)
{
	(void)arg;
	static unsigned char before[400][400], now[400][400];
	static const double skins[] = {0.11, 0.2};
	const double L[4] = {0.5, 2.0, 0.0, -0.5};
	for (int s = 0; s < 2; s++) {
		struct rve_params params;
		struct rve_case c;
		rve_params_default(&params);
		params.bond_strength = 0.1;
		params.skin = skins[s];
		params.n_max = 0;
		start_packing(&c, &params);
		double start = case_info(&c).work;
		int intact = bonded_pairs(&c, before);
		for (int step = 0; step < 150; step++) {
			case_advance(&c, L, 0.0, 1e-3, 1);
			int left = bonded_pairs(&c, now);
			assert_int_equal(left, case_info(&c).bonds_intact);
			assert_true(left <= intact);
			intact = left;
			for (int i = 0; i < 400; i++)
				for (int j = 0; j < 400; j++)
					assert_true(now[i][j] != 1 || before[i][j] == 1);
			memcpy(before, now, sizeof now);
		}
		struct rve_info info = case_info(&c);
		double work = info.work - start;
		print_message("  skin %.2f: %d lists, %d of %d bonds intact, residual %.1e of the work, bonds took %.1f%%\n",
					  skins[s], info.rebuilds, info.bonds_intact, info.bonds_installed, case_residual(&info) / work,
					  100.0 * info.bond / work);
		assert_true(info.rebuilds > 20);
		assert_in_range(info.bonds_intact, 50, info.bonds_installed - 50);
		assert_true(info.bond > 0.0);
		assert_near(case_residual(&info) / work, 0.0, 8e-3);
		case_end(&c);
	}
}

/* Bonds that hold far more than friction could melt in one sub-step: their share of the stored energy goes to the
 * bonds, not to heat, and the stress falls to what friction carries. */
static void test_melting_under_load(void **arg)
{
	(void)arg;
	struct rve_params params;
	struct rve_case c;
	rve_params_default(&params);
	params.bond_strength = 0.15;
	params.bond_melting = 10.0;
	params.n_max = 0;
	start_packing(&c, &params);
	const double L[4] = {1.0, 0.0, 0.0, -1.0};
	double start = case_info(&c).work;
	case_advance(&c, L, 0.0, 1e-3, 20);
	case_advance(&c, rest, 0.0, 1e-3, 500);
	struct rve_info loaded = case_info(&c);
	double held = c.stress[0] - c.stress[1];
	assert_true(held > 2.0 * fabs(loaded.pressure)); /* no friction of 0.5 does that */
	case_advance(&c, rest, 11.0, 1e-3, 1);
	struct rve_info melted = case_info(&c);
	assert_int_equal(melted.bonds_intact, 0);
	assert_true(melted.bond - loaded.bond > 0.3 * loaded.elastic);
	case_advance(&c, rest, 0.0, 1e-3, 2000);
	struct rve_info info = case_info(&c);
	print_message("  stress difference %.0f kPa, melted %.1f kPa at p = %.1f kPa; residual %.1e of the work\n",
				  held / 1e3, (c.stress[0] - c.stress[1]) / 1e3, info.pressure / 1e3,
				  case_residual(&info) / (info.work - start));
	assert_true(c.stress[0] - c.stress[1] < 1.2 * info.pressure);
	assert_near(case_residual(&info) / (info.work - start), 0.0, 8e-3);
	case_end(&c);
}

/* The sum over inspected contacts is the stress: with bonds that pull among them. */
static void test_inspection_adds_up(void **arg)
{
	(void)arg;
	static struct rve_contact contact[4000];
	struct rve_params params;
	struct rve_case c;
	rve_params_default(&params);
	params.bond_strength = 0.1;
	start_packing(&c, &params);
	const double pull[4] = {5.0, 1.0, 1.0, 2.0};
	case_advance(&c, pull, 0.0, 1e-4, 30);
	case_advance(&c, rest, 0.0, 1e-4, 1000);
	int n = rve_inspect(c.model, c.state, NULL, contact, 4000), pulls = 0;
	double xx = 0.0, volume = case_info(&c).volume;
	for (int k = 0; k < n; k++) {
		double bx = contact[k].ends[1][0] - contact[k].ends[0][0], by = contact[k].ends[1][1] - contact[k].ends[0][1];
		double l = hypot(bx, by);
		xx -= (contact[k].normal_force * bx - contact[k].tangential_force * by) / l * bx / volume;
		pulls += contact[k].normal_force < 0.0;
	}
	assert_int_equal(n, case_info(&c).n_contacts);
	assert_true(pulls > 100);
	assert_near(xx / c.stress[0], 1.0, 1e-3);
	case_end(&c);
}

/* Bits of a bonded state after lists, breaking, softening and melting of some. */
static uint64_t walk(struct rve_case *c, int calls)
{
	static const double shear[4] = {0.3, 1.0, -0.4, -0.3};
	case_advance(c, shear, 0.05, 1e-3, calls);
	uint64_t hash = 0xcbf29ce484222325u;
	for (size_t k = 0; k < rve_state_bytes(c->model); k++)
		hash = (hash ^ c->state[k]) * 0x100000001b3u;
	return hash;
}

static struct rve_params soft_params(void)
{
	struct rve_params params;
	rve_params_default(&params);
	params.bond_strength = 0.05;
	params.bond_melting = 10.0;
	params.bond_reference = 0.0;
	params.n_max = 0;
	return params;
}

static void test_same_bits_on_every_instruction_set(void **arg)
{
	(void)arg;
	static const char *const names[] = {"base", "v3", "v4"};
	struct rve_params params = soft_params();
	uint64_t bits[3];
	for (int k = 0; k < 3; k++) {
		struct rve_case c;
		setenv("TMDEMPM_ISA", names[k], 1);
		if (strcmp(rve_isa(), names[k]) != 0)
			print_message("  this processor cannot run %s: %s again\n", names[k], rve_isa());
		start_packing(&c, &params);
		bits[k] = walk(&c, 60);
		struct rve_info info = case_info(&c);
		assert_true(info.rebuilds > 2);
		assert_in_range(info.bonds_intact, 20, info.bonds_installed - 20);
		case_end(&c);
	}
	unsetenv("TMDEMPM_ISA");
	assert_true(bits[0] == bits[1]);
	assert_true(bits[0] == bits[2]);
}

/* A state is all that there is to a bonded RVE too: what a checkpoint saves goes on with the same bits. */
static void test_a_copy_goes_on_with_the_same_bits(void **arg)
{
	(void)arg;
	struct rve_params params = soft_params();
	struct rve_case c, copy;
	start_packing(&c, &params);
	case_start_loose(&copy, &params, 25e3);
	walk(&c, 30);
	memcpy(copy.state, c.state, rve_state_bytes(c.model));
	copy.T = c.T;
	assert_true(walk(&c, 60) == walk(&copy, 60));
	assert_in_range(case_info(&c).bonds_intact, 1, case_info(&c).bonds_installed - 1);
	case_end(&copy);
	case_end(&c);
}

static void test_too_strong_for_the_list(void **arg)
{
	(void)arg;
	struct rve_params params;
	struct rve_model *model;
	rve_params_default(&params);
	params.bond_strength = params.skin;
	struct rve_packing *packing = case_packing(25e3, 0.5, 1);
	assert_int_equal(rve_model_create(&model, &params, 1, (const struct rve_packing *const *)&packing), STATUS_INPUT);
	assert_non_null(strstr(error_message(), "expected less than the skin"));
	rve_packing_free(packing);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_tension),
		cmocka_unit_test(test_shear),
		cmocka_unit_test(test_compression_never_breaks),
		cmocka_unit_test(test_melting),
		cmocka_unit_test(test_softening),
		cmocka_unit_test(test_torn_bonds_are_booked),
		cmocka_unit_test(test_tension_is_no_gas),
		cmocka_unit_test(test_bonds_in_flight),
		cmocka_unit_test(test_installing_changes_nothing),
		cmocka_unit_test(test_rigid_rotation),
		cmocka_unit_test(test_lists_keep_bonds),
		cmocka_unit_test(test_melting_under_load),
		cmocka_unit_test(test_inspection_adds_up),
		cmocka_unit_test(test_same_bits_on_every_instruction_set),
		cmocka_unit_test(test_a_copy_goes_on_with_the_same_bits),
		cmocka_unit_test(test_too_strong_for_the_list),
	};
	return CASE_RUN_ON_EACH_PATH(tests);
}
