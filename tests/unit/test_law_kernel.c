/* The vectorised responses of laws (law/kernel.h): a point answers in a batch as it does alone, on every instruction
 * set, and what fails leaves its state as it was. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/error.h"
#include "base/mat2.h"
#include "law/law.h"

enum { POINTS = 77, STEPS = 30 };

struct batch {
	struct law *law;
	int slot[POINTS];
	double F[POINTS][4], L[POINTS][4], T[POINTS], dT[POINTS];
	double stress[POINTS][4], heat[POINTS], conductivity[POINTS][3], modulus[POINTS], damage[POINTS];
};

static struct scene_law kind_of_law(int kind)
{
	struct scene_law law = {.name = "law", .type = kind < 3 ? SCENE_LAW_THERMOELASTIC : SCENE_LAW_RANKINE};
	if (kind < 3)
		law.thermoelastic = (struct scene_law_thermoelastic){
			.young = 1e7, .poisson = 0.3, .expansion = 1e-4, .plane_stress = kind == 1, .neo_hookean = kind == 2};
	else
		law.rankine = (struct scene_law_rankine){.young = 1e9,
												 .poisson = 0.2,
												 .expansion = 1e-5,
												 .strength = 3e6,
												 .fracture_energy = 5e3,
												 .heat_share = 0.9,
												 .cell = 0.1,
												 .unilateral = kind == 4,
												 .projected = kind == 5};
	return law;
}

static struct batch *begin(int kind)
{
	struct scene_law scene = kind_of_law(kind);
	const int variant[POINTS] = {0};
	struct batch *b = calloc(1, sizeof *b);
	assert_non_null(b);
	assert_int_equal(law_create(&b->law, &scene, POINTS, variant), STATUS_OK);
	for (int k = 0; k < POINTS; k++) {
		b->slot[k] = kind % 2 ? k : (k * 30 + 4) % POINTS; /* states in order, or anyhow */
		mat2_identity(b->F[k]);
		b->T[k] = 300.0;
	}
	return b;
}

static void finish(struct batch *b)
{
	law_free(b->law);
	free(b);
}

/* Point k strains by more the larger k is: the first ones by what the series serve, the last ones not. */
static void strain(struct batch *b, int step)
{
	for (int k = 0; k < POINTS; k++) {
		double scale = 1e-6 * pow(1.1, k), phase = 0.3 * k + 0.2 * step;
		const double e[4] = {1.0 + scale * cos(phase), scale * sin(2.0 * phase), -scale * sin(phase),
							 1.0 + scale * cos(1.7 * phase)};
		mat2_multiply(e, b->F[k], b->F[k]);
		b->dT[k] = 0.1 * sin(phase);
		b->T[k] += b->dT[k];
	}
}

static int advance(struct batch *b, int from, int n)
{
	struct law_batch batch = {.n = n,
							  .slot = b->slot + from,
							  .F = (const double(*)[4])(b->F + from),
							  .L = (const double(*)[4])(b->L + from),
							  .T = b->T + from,
							  .dT = b->dT + from,
							  .dt = 1e-3,
							  .stress = b->stress + from,
							  .heat = b->heat + from,
							  .conductivity = b->conductivity + from,
							  .modulus = b->modulus + from,
							  .damage = b->law->type->breaks ? b->damage + from : NULL,
							  .failed = -1};
	int status = b->law->type->advance(b->law, &batch);
	return status == STATUS_OK ? -1 : from + batch.failed;
}

static void assert_same(const struct batch *a, const struct batch *b)
{
	size_t states = POINTS * a->law->state_bytes;
	assert_memory_equal(a->stress, b->stress, sizeof a->stress);
	assert_memory_equal(a->heat, b->heat, sizeof a->heat);
	assert_memory_equal(a->modulus, b->modulus, sizeof a->modulus);
	assert_memory_equal(a->damage, b->damage, sizeof a->damage);
	assert_memory_equal(a->law->states, b->law->states, states);
}

static void test_batch_and_alone(void **state)
{
	(void)state;
	static const char *const sets[] = {"base", "v3", "v4"};
	for (int kind = 0; kind < 6; kind++)
		for (int set = 0; set < 3; set++) {
			setenv("TMDEMPM_ISA", "base", 1);
			struct batch *alone = begin(kind);
			setenv("TMDEMPM_ISA", sets[set], 1);
			struct batch *all = begin(kind);
			double damage = 0.0;
			for (int step = 0; step < STEPS; step++) {
				strain(alone, step), strain(all, step);
				for (int k = 0; k < POINTS; k++)
					assert_int_equal(advance(alone, k, 1), -1);
				assert_int_equal(advance(all, 0, POINTS), -1);
				assert_same(alone, all);
				for (int k = 0; k < POINTS; k++)
					damage += all->damage[k];
			}
			assert_true(kind < 3 ? damage == 0.0 : damage > 0.0);
			finish(alone), finish(all);
		}
	unsetenv("TMDEMPM_ISA");
}

static void test_failure(void **state)
{
	(void)state;
	for (int kind = 0; kind < 6; kind++) {
		struct batch *b = begin(kind);
		unsigned char *states = malloc(POINTS * b->law->state_bytes);
		assert_non_null(states);
		strain(b, 0);
		assert_int_equal(advance(b, 0, POINTS), -1);
		strain(b, 1);
		b->F[41][0] = b->F[70][0] = -1.0; /* turned inside out */
		memcpy(states, b->law->states, POINTS * b->law->state_bytes);
		assert_int_equal(advance(b, 0, POINTS), 41);
		for (int k = 0; k < POINTS; k++) {
			size_t bytes = b->law->state_bytes, at = (size_t)b->slot[k] * bytes;
			bool same = memcmp(states + at, b->law->states + at, bytes) == 0;
			assert_true(same == (k == 41 || k == 70));
		}
		free(states);
		finish(b);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_batch_and_alone),
		cmocka_unit_test(test_failure),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
