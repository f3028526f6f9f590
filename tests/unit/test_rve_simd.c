/* timeout: 120 */
/* The packed kernel (short vectors, in double and in single precision) against the serial one, which is its oracle. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include "../common/near.h"
#include "../common/rve_case.h"

/* How far a path may be from the serial one, Pa at 100 kPa and relative elsewhere. */
struct bound {
	int path;
	double step, shear; /* in one sub-step from the same state; after a strain of 1e-3 */
};
static const struct bound bounds[] = {{RVE_SIMD, 1e-8, 1e-5}, {RVE_SIMD_SINGLE, 1.0, 2.0}};
enum { PATHS = sizeof bounds / sizeof *bounds };

struct couple {
	struct rve_case serial, packed;
};

static void couple_start(struct couple *c, struct rve_params params, int path, double pressure)
{
	params.path = RVE_SERIAL;
	case_start_loose(&c->serial, &params, pressure);
	params.path = path;
	case_start_loose(&c->packed, &params, pressure);
}

static void couple_end(struct couple *c)
{
	case_end(&c->serial);
	case_end(&c->packed);
}

static void couple_advance(struct couple *c, const double L[4], double dT, int calls)
{
	case_advance(&c->serial, L, dT, 1e-3, calls);
	case_advance(&c->packed, L, dT, 1e-3, calls);
}

/* The largest difference of a stress component, Pa. */
static double couple_difference(const struct couple *c)
{
	double most = 0.0;
	for (int q = 0; q < 4; q++)
		most = fmax(most, fabs(c->serial.stress[q] - c->packed.stress[q]));
	return most;
}

/* Everything else that a state says of itself, within `relative`. */
static void couple_compare(const struct couple *c, double relative)
{
	struct rve_info a = case_info(&c->serial), b = case_info(&c->packed);
	const double scale = a.elastic;
	assert_near(a.work, b.work, relative * scale);
	assert_near(a.elastic, b.elastic, relative * scale);
	assert_near(a.kinetic, b.kinetic, relative * scale);
	assert_near(a.friction, b.friction, relative * scale);
	assert_near(a.dashpot, b.dashpot, relative * scale);
	assert_near(a.bond, b.bond, relative * scale);
	assert_near(a.expansion, b.expansion, relative * scale);
	assert_near(a.max_overlap, b.max_overlap, 10.0 * relative * a.max_overlap);
	assert_near(a.unbalanced, b.unbalanced, 1e3 * relative * a.unbalanced);
	assert_near(c->serial.modulus, c->packed.modulus, relative * c->serial.modulus);
	for (int k = 0; k < 3; k++)
		assert_near(c->serial.conductivity[k], c->packed.conductivity[k], relative * c->serial.conductivity[0]);
	assert_int_equal(a.n_contacts, b.n_contacts);
	assert_int_equal(a.bonds_installed, b.bonds_installed);
	assert_int_equal(a.bonds_intact, b.bonds_intact);
	assert_int_equal(a.total_sub_steps, b.total_sub_steps);
}

/* Moves both and holds them to `most` Pa. */
static void couple_agrees(struct rve_params params, int path, const double L[4], double dT, int calls, const char *words,
						  double most)
{
	struct couple c;
	couple_start(&c, params, path, 100e3);
	couple_advance(&c, L, dT, calls);
	printf("  %s: %s differs by %.2g Pa\n", rve_path_name(path), words, couple_difference(&c));
	assert_true(couple_difference(&c) < most);
	couple_compare(&c, most * 1e-4);
	couple_end(&c);
}

static void test_one_step(void **arg)
{
	(void)arg;
	static const double L[4] = {-0.01, 0.1, 0.02, 0.01};
	struct rve_params params;
	rve_params_default(&params);
	params.n_max = 1;
	for (int k = 0; k < PATHS; k++)
		couple_agrees(params, bounds[k].path, L, 0.1, 1, "one step", bounds[k].step);
}

/* In slow shear, in the linear range: what rounding does there is not yet chaos.  The list is not made anew. */
static void test_shear_of_a_thousandth(void **arg)
{
	(void)arg;
	static const double L[4] = {0.0, 0.1, 0.0, 0.0};
	struct rve_params params;
	rve_params_default(&params);
	for (int k = 0; k < PATHS; k++)
		couple_agrees(params, bounds[k].path, L, 0.0, 10, "a shear of 1e-3", bounds[k].shear);
}

/* Bonds that hold, that tear by tension, and that melt. */
static void test_bonds(void **arg)
{
	(void)arg;
	struct rve_params params;
	rve_params_default(&params);
	params.bond_strength = 0.01;
	params.bond_melting = 8.0;
	params.bond_reference = 0.0;
	for (int k = 0; k < PATHS; k++) {
		struct couple c;
		couple_start(&c, params, bounds[k].path, 100e3);
		rve_install_bonds(c.serial.model, c.serial.state);
		rve_install_bonds(c.packed.model, c.packed.state);
		static const double stretch[4] = {0.2, 0.0, 0.0, 0.05}, rest[4] = {0};
		couple_advance(&c, stretch, 0.0, 10);
		struct rve_info torn = case_info(&c.packed);
		assert_true(torn.bonds_intact > 0 && torn.bonds_intact < torn.bonds_installed);
		assert_true(couple_difference(&c) < 10.0 * bounds[k].shear);
		couple_compare(&c, bounds[k].shear * 1e-4);
		couple_advance(&c, rest, 0.9, 10);
		assert_int_equal(case_info(&c.packed).bonds_intact, 0);
		assert_int_equal(case_info(&c.serial).bonds_intact, 0);
		couple_end(&c);
	}
}

/* What is drawn and written is the same, disc by disc and contact by contact. */
static void test_inspection(void **arg)
{
	(void)arg;
	static struct rve_disc discs[2][400];
	struct rve_params params;
	rve_params_default(&params);
	const double L[4] = {0.0, 0.1, 0.0, 0.0};
	for (int k = 0; k < PATHS; k++) {
		struct couple c;
		couple_start(&c, params, bounds[k].path, 100e3);
		couple_advance(&c, L, 0.1, 3);
		const int capacity = rve_contact_capacity(c.serial.model);
		struct rve_contact *a = malloc(sizeof *a * (size_t)capacity), *b = malloc(sizeof *b * (size_t)capacity);
		const double relative = 1e-4 * bounds[k].shear;
		int n = rve_inspect(c.serial.model, c.serial.state, discs[0], a, capacity);
		assert_int_equal(n, rve_inspect(c.packed.model, c.packed.state, discs[1], b, capacity));
		for (int i = 0; i < 400; i++) {
			assert_near(discs[0][i].x, discs[1][i].x, relative * 1e-5);
			assert_near(discs[0][i].y, discs[1][i].y, relative * 1e-5);
			assert_near(discs[0][i].radius, discs[1][i].radius, 1e-12);
			assert_near(discs[0][i].displacement[0], discs[1][i].displacement[0], relative * 1e-5);
			assert_near(discs[0][i].displacement[1], discs[1][i].displacement[1], relative * 1e-5);
			assert_near(discs[0][i].rotation, discs[1][i].rotation, relative);
			assert_int_equal(discs[0][i].contacts, discs[1][i].contacts);
		}
		for (int p = 0; p < n; p++) {
			int q = 0;
			while (q < n && (b[q].i != a[p].i || b[q].j != a[p].j))
				q++;
			assert_true(q < n);
			assert_near(a[p].normal_force, b[q].normal_force, 10.0 * relative + 1e-6);
			assert_near(a[p].tangential_force, b[q].tangential_force, 10.0 * relative + 1e-6);
		}
		free(a);
		free(b);
		couple_end(&c);
	}
}

/* Beyond a strain of 1e-3 single cells go their own ways; what holds on the average is the friction of the material. */
static void test_flow(void **arg)
{
	(void)arg;
	struct rve_params params;
	rve_params_default(&params);
	for (int k = 0; k < PATHS; k++) {
		struct couple c;
		double shear[2] = {0.0}, pressure[2] = {0.0};
		const double L[4] = {0.0, 2.0, 0.0, 0.0};
		couple_start(&c, params, bounds[k].path, 100e3);
		couple_advance(&c, L, 0.0, 100);
		for (int step = 0; step < 600; step++) {
			couple_advance(&c, L, 0.0, 1);
			shear[0] += c.serial.stress[3], pressure[0] -= 0.5 * (c.serial.stress[0] + c.serial.stress[1]);
			shear[1] += c.packed.stress[3], pressure[1] -= 0.5 * (c.packed.stress[0] + c.packed.stress[1]);
		}
		double ratio[2] = {shear[0] / pressure[0], shear[1] / pressure[1]};
		printf("  %s: shear / pressure in flow %.3f, serial %.3f\n", rve_path_name(bounds[k].path), ratio[1], ratio[0]);
		assert_near(ratio[1], ratio[0], 0.02);
		struct rve_info info = case_info(&c.packed);
		assert_near(case_residual(&info), 0.0, 2e-3 * info.work);
		assert_true(info.rebuilds > 50);
		couple_end(&c);
	}
}

static void convert(const struct rve_case *from, struct rve_case *to)
{
	if (rve_convert(from->model, 1, from->state, to->model, to->state) != STATUS_OK)
		fail_msg("%s", error_message());
	to->T = from->T;
}

/* A state that has flowed, with bonds and heat, goes on on another path as it would have on its own. */
static void test_conversion(void **arg)
{
	(void)arg;
	static const double L[4] = {0.1, 2.0, 0.0, -0.05};
	struct rve_params params;
	rve_params_default(&params);
	params.bond_strength = 0.01;
	for (int from = RVE_SERIAL; from <= RVE_SIMD_SINGLE; from++)
		for (int to = RVE_SERIAL; to <= RVE_SIMD_SINGLE; to++) {
			struct couple c;
			struct rve_case back;
			couple_start(&c, params, to, 100e3);
			case_end(&c.serial);
			params.path = from;
			case_start_loose(&c.serial, &params, 100e3);
			case_start_loose(&back, &params, 100e3);
			rve_install_bonds(c.serial.model, c.serial.state);
			case_advance(&c.serial, L, 0.1, 1e-3, 60);
			const struct rve_info before = case_info(&c.serial);
			assert_true(before.rebuilds > 20 && before.bonds_intact > 0 && before.bonds_intact < before.bonds_installed);
			if (from == to) { /* what is done to the cases is done twice here, to show that it is the same */
				memcpy(c.packed.state, c.serial.state, rve_state_bytes(c.serial.model));
				c.packed.T = c.serial.T;
			} else
				convert(&c.serial, &c.packed);
			const struct rve_info after = case_info(&c.packed);
			assert_memory_equal(&before, &after, sizeof before);
			assert_int_equal(rve_inspect(c.serial.model, c.serial.state, NULL, NULL, 0),
							 rve_inspect(c.packed.model, c.packed.state, NULL, NULL, 0));
			if (from != to)
				convert(&c.packed, &back);
			couple_advance(&c, L, 0.1, 1);
			const int single = from != to && (from == RVE_SIMD_SINGLE || to == RVE_SIMD_SINGLE);
			const double most = from == to ? 1e-300 : single ? bounds[1].shear : bounds[0].shear;
			printf("  %s to %s: differs by %.2g Pa after a shear of 2e-3\n", rve_path_name(from), rve_path_name(to),
				   couple_difference(&c));
			assert_true(couple_difference(&c) < most);
			if (from != to) { /* and back again */
				case_advance(&back, L, 0.1, 1e-3, 1);
				for (int q = 0; q < 4; q++)
					assert_near(back.stress[q], c.serial.stress[q], most);
			}
			case_end(&back);
			couple_end(&c);
		}
}

/* Where material comes loose, far below the pressure of its packing, single precision must not become wrong: errors of one
 * call from the same state, by pressure, in flow.  Its rms is a thousandth of the pressure, and less the higher that is;
 * what a collision makes of it in a call stays below a twentieth. */
static void test_single_in_loose_material(void **arg)
{
	(void)arg;
	static const double from[] = {20.0, 100.0, 1e3, INFINITY}, rms[] = {5e-3, 3e-3, 1e-3};
	enum { BINS = 3 };
	double most[BINS] = {0.0}, squares[BINS] = {0.0};
	int calls[BINS] = {0};
	struct couple c;
	struct rve_params params;
	rve_params_default(&params);
	couple_start(&c, params, RVE_SIMD_SINGLE, 10e3);
	params.path = RVE_SIMD;
	case_end(&c.serial);
	case_start_loose(&c.serial, &params, 10e3);
	for (int k = 0; k < 1500; k++) {
		/* sheared, and pulled apart or pressed so that its pressure falls to 20 Pa and rises again */
		const double goal = 10e3 * pow(10.0, -2.7 * sin(3.14159265 * k / 1500.0));
		const double grow = case_info(&c.packed).pressure > goal ? 0.02 : -0.02;
		const double L[4] = {grow, 0.5, 0.0, grow};
		convert(&c.packed, &c.serial);
		couple_advance(&c, L, 0.0, 1);
		const double now = case_info(&c.serial).pressure, off = couple_difference(&c) / now;
		for (int bin = 0; bin < BINS; bin++)
			if (now >= from[bin] && now < from[bin + 1]) {
				most[bin] = fmax(most[bin], off);
				squares[bin] += off * off;
				calls[bin]++;
			}
	}
	for (int bin = 0; bin < BINS; bin++) {
		const double mean = sqrt(squares[bin] / calls[bin]);
		printf("  single from %g Pa: %d calls, error of the stress / pressure: rms %.2g, most %.2g\n", from[bin],
			   calls[bin], mean, most[bin]);
		assert_true(calls[bin] > 20);
		assert_true(mean < rms[bin] && most[bin] < 0.05);
	}
	couple_end(&c);
}

static void test_single_is_refused_where_it_errs(void **arg)
{
	(void)arg;
	struct rve_params params;
	struct rve_model *model;
	rve_params_default(&params);
	params.path = RVE_SIMD_SINGLE;
	struct rve_packing *packing = case_packing(100e3, 0.5, 1);
	const struct rve_packing *const packings[1] = {packing};
	packing->pressure = 9.9e3;
	assert_int_equal(rve_model_create(&model, &params, 1, packings), STATUS_INPUT);
	assert_non_null(strstr(error_message(), "path = \"simd\""));
	assert_null(model);
	params.path = RVE_SIMD;
	assert_int_equal(rve_model_create(&model, &params, 1, packings), STATUS_OK);
	rve_model_free(model);
	rve_packing_free(packing);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_one_step), cmocka_unit_test(test_shear_of_a_thousandth),
		cmocka_unit_test(test_bonds),    cmocka_unit_test(test_inspection),
		cmocka_unit_test(test_flow),     cmocka_unit_test(test_single_is_refused_where_it_errs),
		cmocka_unit_test(test_conversion), cmocka_unit_test(test_single_in_loose_material),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
