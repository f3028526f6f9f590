/* timeout: 180 */
/* The RVE engine as a machine: its bits, its lists, its sums, its refusals. */
#include <omp.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include "../common/near.h"
#include "../common/rve_case.h"
#include "base/mat2.h"

static const double shear[4] = {0.3, 1.0, -0.4, -0.3};

/* Bits of a state after a path with rebuilds, rotation, heat and quiet steps. */
static uint64_t walk(struct rve_case *c)
{
	static const double rest[4] = {0};
	case_advance(c, shear, 0.01, 1e-3, 60);
	case_advance(c, rest, 0.0, 1e-3, 5);
	uint64_t hash = 0xcbf29ce484222325u;
	for (size_t k = 0; k < rve_state_bytes(c->model); k++)
		hash = (hash ^ c->state[k]) * 0x100000001b3u;
	return hash;
}

static void same_bits_on_every_instruction_set(int path)
{
	static const char *const names[] = {"base", "v3", "v4"};
	struct rve_params params;
	rve_params_default(&params);
	params.path = path;
	uint64_t bits[3];
	for (int k = 0; k < 3; k++) {
		struct rve_case c;
		setenv("TMDEMPM_ISA", names[k], 1);
		if (strcmp(rve_isa(), names[k]) != 0)
			print_message("  this processor cannot run %s: %s again\n", names[k], rve_isa());
		case_start_loose(&c, &params, 100e3);
		bits[k] = walk(&c);
		assert_true(case_info(&c).rebuilds > 2);
		case_end(&c);
	}
	unsetenv("TMDEMPM_ISA");
	assert_true(bits[0] == bits[1]);
	assert_true(bits[0] == bits[2]);
}

static void test_same_bits_on_every_instruction_set(void **arg)
{
	(void)arg;
	same_bits_on_every_instruction_set(RVE_SERIAL); /* the path whose turn it is */
	same_bits_on_every_instruction_set(RVE_SIMD_SINGLE);
}

static void test_packing_is_a_pure_function_of_its_seed(void **arg)
{
	(void)arg;
	struct rve_params grains;
	rve_params_default(&grains);
	struct rve_packing_params how = {.discs = 100,
									 .radius_min = 0.25e-3,
									 .radius_max = 0.5e-3,
									 .pressure = 100e3,
									 .mu = 0.1,
									 .void_ratio = NAN,
									 .seed = 7};
	struct rve_packing *a, *b, *other;
	setenv("TMDEMPM_ISA", "base", 1);
	assert_int_equal(rve_packing_generate(&a, &how, &grains), STATUS_OK);
	unsetenv("TMDEMPM_ISA");
	omp_set_num_threads(1);
	assert_int_equal(rve_packing_generate(&b, &how, &grains), STATUS_OK);
	how.seed = 8;
	assert_int_equal(rve_packing_generate(&other, &how, &grains), STATUS_OK);
	assert_memory_equal(a->x, b->x, sizeof *a->x * 100);
	assert_memory_equal(a->r, b->r, sizeof *a->r * 100);
	assert_int_equal(a->n_contacts, b->n_contacts);
	assert_memory_equal(a->ft, b->ft, sizeof *a->ft * (size_t)a->n_contacts);
	assert_true(memcmp(a->x, other->x, sizeof *a->x * 100) != 0);
	assert_true(a->unbalanced < 1e-4);
	rve_packing_free(a);
	rve_packing_free(b);
	rve_packing_free(other);
}

static void test_packing_starts_at_its_pressure_and_rests(void **arg)
{
	(void)arg;
	struct rve_params params;
	rve_params_default(&params);
	static const double rest[4] = {0};
	static const double pressures[] = {10e3, 100e3};
	for (int k = 0; k < 2; k++) {
		struct rve_case c;
		case_start_loose(&c, &params, pressures[k]);
		rve_evaluate(c.model, c.state, c.stress, c.conductivity, &c.modulus);
		for (int turn = 0; turn < 2; turn++) {
			assert_near(c.stress[0], -pressures[k], 5e-3 * pressures[k]);
			assert_near(c.stress[1], -pressures[k], 5e-3 * pressures[k]);
			assert_near(c.stress[3], 0.0, 5e-3 * pressures[k]);
			case_advance(&c, rest, 0.0, 1e-4, 2000);
		}
		case_end(&c);
	}
}

static void test_void_ratio_is_met(void **arg)
{
	(void)arg;
	struct rve_params grains;
	rve_params_default(&grains);
	struct rve_packing_params how = {.discs = 100,
									 .radius_min = 0.25e-3,
									 .radius_max = 0.5e-3,
									 .pressure = 100e3,
									 .mu = 0.5,
									 .void_ratio = 0.19,
									 .seed = 3};
	struct rve_packing *packing;
	assert_int_equal(rve_packing_generate(&packing, &how, &grains), STATUS_OK);
	assert_near(packing->void_ratio, 0.19, 5e-3);
	assert_near(rve_packing_void_ratio(packing), packing->void_ratio, 1e-12);
	rve_packing_free(packing);
	how.void_ratio = 0.9;
	assert_int_equal(rve_packing_generate(&packing, &how, &grains), STATUS_INPUT);
	assert_null(packing);
	assert_non_null(strstr(error_message(), "out of reach"));
}

static void test_same_bits_for_any_number_of_threads(void **arg)
{
	(void)arg;
	enum { N = 12 };
	struct rve_params params;
	rve_params_default(&params);
	params.bond_strength = 0.05;
	omp_set_num_threads(4);
	struct rve_case c;
	case_start_loose(&c, &params, 100e3);
	size_t bytes = rve_state_bytes(c.model);
	unsigned char *states[3];
	static double stress[3][N][4], heat[3][N];
	for (int t = 0; t < 3; t++) {
		omp_set_num_threads(1 << t);
		states[t] = aligned_alloc(64, N * bytes);
		double L[N][4], dT[N], conductivity[N][3], modulus[N];
		int slot[N];
		for (int k = 0; k < N; k++) {
			slot[k] = (5 * k + 3) % N;
			for (int q = 0; q < 4; q++)
				L[k][q] = shear[q] * (1.0 + k);
			dT[k] = 0.01 * k;
			rve_init(c.model, 0, states[t] + (size_t)k * bytes);
			if (k % 3)
				rve_install_bonds(c.model, states[t] + (size_t)k * bytes);
		}
		struct rve_batch batch = {.n = N,
								  .states = states[t],
								  .slot = slot,
								  .L = (const double(*)[4])L,
								  .dT = dT,
								  .dt = 1e-4,
								  .stress = stress[t],
								  .heat = heat[t],
								  .conductivity = conductivity,
								  .modulus = modulus};
		for (int step = 0; step < 20; step++)
			assert_int_equal(rve_advance(c.model, &batch), STATUS_OK);
	}
	for (int t = 1; t < 3; t++) {
		assert_memory_equal(states[0], states[t], N * bytes);
		assert_memory_equal(stress[0], stress[t], sizeof stress[0]);
		assert_memory_equal(heat[0], heat[t], sizeof heat[0]);
	}
	for (int t = 0; t < 3; t++)
		free(states[t]);
	omp_set_num_threads(1);
	case_end(&c);
}

static void test_a_copy_goes_on_with_the_same_bits(void **arg)
{
	(void)arg;
	struct rve_params params;
	rve_params_default(&params);
	struct rve_case c, copy;
	case_start_loose(&c, &params, 100e3);
	case_start_loose(&copy, &params, 100e3);
	case_advance(&c, shear, 0.01, 1e-3, 37);
	memcpy(copy.state, c.state, rve_state_bytes(c.model));
	case_advance(&c, shear, 0.01, 1e-3, 40);
	case_advance(&copy, shear, 0.01, 1e-3, 40);
	assert_memory_equal(c.state, copy.state, rve_state_bytes(c.model));
	case_end(&copy);
	case_end(&c);
}

/* Every contact of the cell, found by comparing all discs and their images, is one that the engine has. */
static int contacts_by_brute_force(const struct rve_case *c)
{
	static struct rve_disc disc[400];
	struct rve_info info = case_info(c);
	int found = 0;
	rve_inspect(c->model, c->state, disc, NULL, 0);
	for (int i = 0; i < 400; i++)
		for (int j = i + 1; j < 400; j++)
			for (int k = 0; k < 9; k++) {
				double sx = k % 3 - 1, sy = k / 3 - 1;
				double dx = disc[j].x - disc[i].x + info.H[0] * sx + info.H[1] * sy;
				double dy = disc[j].y - disc[i].y + info.H[2] * sx + info.H[3] * sy;
				found += sqrt(dx * dx + dy * dy) < disc[i].radius + disc[j].radius;
			}
	return found;
}

static void test_no_contact_is_missed(void **arg)
{
	(void)arg;
	static const double paths[4][4] = {
		{0.0, 1.0, 0.0, 0.0}, {1.0, 0.0, 0.0, -1.0}, {-0.2, 3.0, -3.0, 0.2}, {0.0, 0.0, 1.0, 0.0}};
	struct rve_params params;
	rve_params_default(&params);
	params.strain_per_step = 2e-4;
	for (int k = 0; k < 4; k++) {
		struct rve_case c;
		case_start_loose(&c, &params, 100e3);
		for (int step = 0; step < 60; step++) {
			case_advance(&c, paths[k], step % 2 ? 0.5 : -0.5, 1e-3, 5);
			assert_int_equal(contacts_by_brute_force(&c), case_info(&c).n_contacts);
		}
		assert_true(case_info(&c).rebuilds > 5);
		case_end(&c);
	}
}

static void test_inspection_adds_up_to_the_stress(void **arg)
{
	(void)arg;
	struct rve_params params;
	rve_params_default(&params);
	struct rve_case c;
	case_start_loose(&c, &params, 100e3);
	case_advance(&c, shear, 0.0, 1e-3, 30);
	static struct rve_disc disc[400];
	struct rve_contact *contact = malloc(sizeof *contact * (size_t)rve_contact_capacity(c.model));
	int n = rve_inspect(c.model, c.state, disc, contact, rve_contact_capacity(c.model));
	struct rve_info info = case_info(&c);
	double sum[3] = {0}, sliding = 0.0;
	int ends = 0;
	for (int k = 0; k < n; k++) {
		double bx = contact[k].ends[1][0] - contact[k].ends[0][0], by = contact[k].ends[1][1] - contact[k].ends[0][1];
		double length = hypot(bx, by), nx = bx / length, ny = by / length;
		double fx = contact[k].normal_force * nx - contact[k].tangential_force * ny;
		double fy = contact[k].normal_force * ny + contact[k].tangential_force * nx;
		sum[0] -= fx * bx, sum[1] -= fy * by, sum[2] -= 0.5 * (fx * by + fy * bx);
		sliding += contact[k].sliding;
		const int *shift = contact[k].shift;
		assert_true(contact[k].i < contact[k].j);
		assert_near(disc[contact[k].j].x + info.H[0] * shift[0] + info.H[1] * shift[1], contact[k].ends[1][0], 1e-12);
		assert_near(disc[contact[k].j].y + info.H[2] * shift[0] + info.H[3] * shift[1], contact[k].ends[1][1], 1e-12);
	}
	for (int i = 0; i < 400; i++)
		ends += disc[i].contacts;
	assert_int_equal(n, info.n_contacts);
	assert_int_equal(ends, 2 * n);
	assert_near(sliding / n, info.sliding_fraction, 1e-12);
	/* the rest is the fluctuations' part, a hundredth of a percent here */
	assert_near(sum[0] / info.volume, c.stress[0], 1e-3 * info.pressure);
	assert_near(sum[1] / info.volume, c.stress[1], 1e-3 * info.pressure);
	assert_near(sum[2] / info.volume, c.stress[3], 1e-3 * info.pressure);
	free(contact);
	case_end(&c);
}

static void test_momentum_is_conserved(void **arg)
{
	(void)arg;
	struct rve_params params;
	rve_params_default(&params);
	struct rve_case c;
	case_start_loose(&c, &params, 100e3);
	case_advance(&c, shear, 0.0, 1e-3, 200);
	const struct rve_layout *layout = &c.model->layout;
	const real *disc = (const real *)(c.state + layout->disc),
			   *mass = c.model->variants[0].table + TABLE_MASS * c.model->serial.stride;
	const index16 *id = (const index16 *)(c.state + layout->id);
	double sum[2] = {0}, size = 0.0;
	for (int i = 0; i < layout->n; i++) {
		double x = disc[DISC_VX * layout->stride + i], y = disc[DISC_VY * layout->stride + i];
		double m = mass[id[i]];
		sum[0] += m * x, sum[1] += m * y, size += m * hypot(x, y);
	}
	assert_true(size > 0.0);
	assert_near(sum[0] / size, 0.0, 1e-11);
	assert_near(sum[1] / size, 0.0, 1e-11);
	case_end(&c);
}

static void test_refusals_name_their_cause(void **arg)
{
	(void)arg;
	struct rve_params params;
	rve_params_default(&params);
	const struct rve_packing_params how = {.discs = 16,
										   .radius_min = 0.25e-3,
										   .radius_max = 0.25e-3,
										   .pressure = 1e5,
										   .mu = 0.5,
										   .void_ratio = NAN,
										   .seed = 1,
										   .square_lattice = 1};
	struct rve_packing_params wrong = how;
	struct rve_packing *few, *packing, *none;
	struct rve_model *model;
	wrong.discs = 20;
	assert_int_equal(rve_packing_generate(&none, &wrong, &params), STATUS_INPUT);
	assert_non_null(strstr(error_message(), "square number"));
	assert_int_equal(rve_packing_generate(&few, &how, &params), STATUS_OK);
	params.skin = 2.0;
	assert_int_equal(rve_model_create(&model, &params, 1, (const struct rve_packing *const *)&few), STATUS_INPUT);
	assert_non_null(strstr(error_message(), "narrower"));
	assert_null(model);
	rve_params_default(&params);
	packing = case_packing(100e3, 0.5, 1);
	const struct rve_packing *const both[2] = {packing, few};
	assert_int_equal(rve_model_create(&model, &params, 2, both), STATUS_INPUT);
	assert_non_null(strstr(error_message(), "400 and 16"));
	rve_packing_free(few);
	rve_packing_free(packing);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_same_bits_on_every_instruction_set),
		cmocka_unit_test(test_packing_is_a_pure_function_of_its_seed),
		cmocka_unit_test(test_packing_starts_at_its_pressure_and_rests),
		cmocka_unit_test(test_void_ratio_is_met),
		cmocka_unit_test(test_same_bits_for_any_number_of_threads),
		cmocka_unit_test(test_a_copy_goes_on_with_the_same_bits),
		cmocka_unit_test(test_no_contact_is_missed),
		cmocka_unit_test(test_inspection_adds_up_to_the_stress),
		cmocka_unit_test(test_momentum_is_conserved),
		cmocka_unit_test(test_refusals_name_their_cause),
	};
	return CASE_RUN_ON_EACH_PATH(tests);
}
