/* timeout: 120 */
/* Twins: a law whose equal RVEs share a state computes the bits of one where every point has its own. */
#include <omp.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "law/law.h"
#include "law/twins.h"

enum { N = 12 };

static const double hot = 300.0; /* K: bonds melt above 290 K */

struct side {
	struct law *law;
	double F[N][4], stress[N][4], heat[N], conductivity[N][3], modulus[N];
	int failed;
};

static struct scene_law scene_of(bool twins)
{
	struct scene_law scene = {.name = "sand", .type = SCENE_LAW_RVE};
	scene.rve = (struct scene_law_rve){.packing = {.discs = 64,
												   .radius_min = 0.25e-3,
												   .radius_max = 0.5e-3,
												   .pressure = 10e3,
												   .mu = 0.5,
												   .void_ratio = NAN,
												   .seed = 3},
									   .bonds = {.strength = 0.02, .mu = 0.5, .melting = 290.0},
									   .economy = {.twins = twins},
									   .kn = 1e6,
									   .ks = 1e6,
									   .mu = 0.5,
									   .damping_ratio = 0.2,
									   .grain_density = 2650.0,
									   .disc_thickness = 0.075,
									   .expansion = 1e-4,
									   .resistance = 1e4,
									   .step_factor = 0.4,
									   .strain_per_step = 5e-5,
									   .pressure_scaling = true,
									   .n_max = 20,
									   .skin = 0.2,
									   .gas = true,
									   .gas_pressure = 20.0,
									   .gas_stretch = 1.12,
									   .overlap_max = 0.5,
									   .step_guard = true};
	return scene;
}

/* Two packings: the first half of the points and the second. */
static void start(struct side *s, bool twins)
{
	struct scene_law scene = scene_of(twins);
	int variant[N];
	for (int k = 0; k < N; k++)
		variant[k] = k >= N / 2;
	memset(s, 0, sizeof *s);
	if (law_create(&s->law, &scene, N, variant) != STATUS_OK)
		fail_msg("%s", error_message());
}

/* Points 3g .. 3g + 2 of step `step` are told the same until they part, one after the other. */
static void motion(int step, double L[N][4], double dT[N], double T[N])
{
	for (int k = 0; k < N; k++) {
		bool parted = step >= 4 + 3 * (k % 3) && k % 3 > 0;
		L[k][0] = 0.1 * (k / 3), L[k][1] = 0.3 + (parted ? 1e-13 * k : 0.0), L[k][2] = -0.2, L[k][3] = -0.1;
		dT[k] = k / 3 == 1 ? 1e-3 : 0.0;
		T[k] = k == 5 && step > 12 ? hot : 280.0;
	}
}

static int step_of(struct side *s, int step, const int *slot, int n)
{
	double L[N][4], dT[N], T[N], few_L[N][4], few_dT[N], few_T[N];
	motion(step, L, dT, T);
	for (int k = 0; k < n; k++) {
		memcpy(few_L[k], L[slot[k]], sizeof few_L[k]);
		few_dT[k] = dT[slot[k]], few_T[k] = T[slot[k]];
	}
	struct law_batch batch = {.n = n,
							  .slot = slot,
							  .F = (const double(*)[4])s->F,
							  .L = (const double(*)[4])few_L,
							  .T = few_T,
							  .dT = few_dT,
							  .dt = 1e-3,
							  .stress = s->stress,
							  .heat = s->heat,
							  .conductivity = s->conductivity,
							  .modulus = s->modulus};
	int status = s->law->type->advance(s->law, &batch);
	s->failed = batch.failed;
	return status;
}

static void assert_same_outputs(const struct side *a, const struct side *b)
{
	assert_memory_equal(a->stress, b->stress, sizeof a->stress);
	assert_memory_equal(a->heat, b->heat, sizeof a->heat);
	assert_memory_equal(a->conductivity, b->conductivity, sizeof a->conductivity);
	assert_memory_equal(a->modulus, b->modulus, sizeof a->modulus);
}

/* What a reader sees of every point while it shares, and the bytes once they are written out. */
static void assert_same_states(const struct side *a, const struct side *b)
{
	for (int k = 0; k < N; k++) {
		struct law_ledger la, lb;
		a->law->type->ledger(a->law, k, &la), b->law->type->ledger(b->law, k, &lb);
		assert_memory_equal(&la, &lb, sizeof la);
		const struct rve_model *model;
		const void *sa, *sb;
		a->law->type->rve_view(a->law, k, &model, &sa), b->law->type->rve_view(b->law, k, &model, &sb);
		assert_memory_equal(sa, sb, a->law->state_bytes);
	}
	a->law->type->write_out(a->law);
	assert_memory_equal(a->law->states, b->law->states, N * a->law->state_bytes);
}

static void assert_same_counts(const struct side *a, const struct side *b)
{
	struct law_counts ca, cb;
	a->law->type->counts(a->law, &ca), b->law->type->counts(b->law, &cb);
	assert_int_equal(cb.twin_calls, 0);
	ca.twin_calls = ca.twin_disc_steps = 0;
	assert_memory_equal(&ca, &cb, sizeof ca);
}

static void reset_ledgers(struct side *s)
{
	for (int k = 0; k < N; k++)
		s->law->type->reset_ledger(s->law, k);
}

static const int storage[N] = {7, 3, 0, 1,  11, 2,
							   4, 5, 6, 10, 9,  8}; /* points do not lie in the order of their slots */

static void test_same_bits(void **arg)
{
	(void)arg;
	struct side twins, alone;
	start(&twins, true), start(&alone, false);
	assert_int_equal(twins.law->twins->shared, N - 2);
	for (int step = 0; step < 20; step++) {
		omp_set_num_threads(step % 2 ? 3 : 1);
		assert_int_equal(step_of(&twins, step, storage, N), STATUS_OK);
		assert_int_equal(step_of(&alone, step, storage, N), STATUS_OK);
		assert_same_outputs(&twins, &alone);
		assert_same_states(&twins, &alone);
		if (step == 2)
			twins.law->type->install_bonds(twins.law), alone.law->type->install_bonds(alone.law);
		if (step == 3)
			reset_ledgers(&twins), reset_ledgers(&alone);
		if (step == 2) /* each triple is a group, and 6 parts the packings as it parts triples */
			assert_int_equal(twins.law->twins->shared, N - 4);
	}
	assert_same_counts(&twins, &alone);
	assert_int_equal(twins.law->twins->shared, 0);
	/* of each of the four triples one point was saved for 7 steps, one for 10 */
	assert_int_equal(twins.law->twins->saved_calls, 4 * (7 + 10));
	law_free(twins.law), law_free(alone.law);
}

static void test_restored_states_share_again(void **arg)
{
	(void)arg;
	struct side twins, again;
	start(&twins, true), start(&again, true);
	for (int step = 0; step < 8; step++)
		assert_int_equal(step_of(&twins, step, storage, N), STATUS_OK);
	twins.law->type->write_out(twins.law);
	memcpy(again.law->states, twins.law->states, N * twins.law->state_bytes);
	again.law->type->restored(again.law);
	assert_int_equal(again.law->twins->shared, twins.law->twins->shared);
	assert_true(again.law->twins->shared > 0);
	for (int step = 8; step < 14; step++) {
		assert_int_equal(step_of(&twins, step, storage, N), STATUS_OK);
		assert_int_equal(step_of(&again, step, storage, N), STATUS_OK);
	}
	assert_same_outputs(&twins, &again);
	assert_same_states(&twins, &again);
	law_free(twins.law), law_free(again.law);
}

static void test_a_part_of_the_points(void **arg)
{
	(void)arg;
	static const int some[] = {1, 4, 7};
	struct side twins, alone;
	start(&twins, true), start(&alone, false);
	assert_int_equal(step_of(&twins, 0, some, 3), STATUS_OK);
	assert_int_equal(step_of(&alone, 0, some, 3), STATUS_OK);
	assert_same_outputs(&twins, &alone);
	assert_same_states(&twins, &alone);
	law_free(twins.law), law_free(alone.law);
}

/* The guard names the point that it names without twins. */
static void test_same_failure(void **arg)
{
	(void)arg;
	struct side twins, alone;
	char message[1024];
	start(&twins, true), start(&alone, false);
	for (int s = 0; s < 2; s++) {
		struct side *side = s ? &alone : &twins;
		double L[N][4] = {{0}}, dT[N] = {0}, T[N] = {0};
		L[6][1] = L[9][1] = 5e3; /* a strain of 2.5 in a step */
		struct law_batch batch = {.n = N,
								  .slot = storage,
								  .L = (const double(*)[4])L,
								  .T = T,
								  .dT = dT,
								  .dt = 1e-3,
								  .stress = side->stress,
								  .heat = side->heat,
								  .conductivity = side->conductivity,
								  .modulus = side->modulus};
		assert_int_equal(side->law->type->advance(side->law, &batch), STATUS_GUARD);
		assert_int_equal(batch.failed, 6);
		if (s)
			assert_string_equal(message, error_message());
		snprintf(message, sizeof message, "%s", error_message());
	}
	assert_same_states(&twins, &alone);
	law_free(twins.law), law_free(alone.law);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_same_bits),
		cmocka_unit_test(test_restored_states_share_again),
		cmocka_unit_test(test_a_part_of_the_points),
		cmocka_unit_test(test_same_failure),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
