/* An RVE to test: a model of one packing, a state, and calls that fail the test when they fail.
 * Include after cmocka.h. */
#ifndef TESTS_COMMON_RVE_CASE_H
#define TESTS_COMMON_RVE_CASE_H

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "rve/model.h"
#include "rve/packing.h"
#include "rve/rve.h"

struct rve_case {
	struct rve_model *model;
	unsigned char *state;
	double T;                                         /* K, absolute, moves with dT from 0 */
	double stress[4], heat, conductivity[3], modulus; /* of the last call */
};

/* The path that cases are computed on whose parameters do not name one: programs run their tests on one after the
 * other (CASE_RUN_ON_EACH_PATH). */
static int case_path = RVE_SERIAL;

static inline struct rve_packing *case_packing(double pressure, double mu, unsigned seed)
{
	struct rve_params grains;
	rve_params_default(&grains);
	const struct rve_packing_params how = {.discs = 400,
										   .radius_min = 0.25e-3,
										   .radius_max = 0.5e-3,
										   .pressure = pressure,
										   .mu = mu,
										   .void_ratio = NAN,
										   .seed = seed};
	struct rve_packing *packing;
	if (rve_packing_cached(&packing, &how, &grains) != STATUS_OK)
		fail_msg("%s", error_message());
	return packing;
}

static inline void case_start(struct rve_case *c, const struct rve_params *params, const struct rve_packing *packing)
{
	const struct rve_packing *const packings[1] = {packing};
	struct rve_params on_path = *params;
	if (on_path.path == RVE_SERIAL)
		on_path.path = case_path;
	if (rve_model_create(&c->model, &on_path, 1, packings) != STATUS_OK)
		fail_msg("%s", error_message());
	c->T = 0.0;
	c->state = aligned_alloc(64, rve_state_bytes(c->model));
	assert_non_null(c->state);
	assert_int_equal(rve_init(c->model, 0, c->state), STATUS_OK);
}

/* The usual one: 400 discs, loose, consolidated at `pressure`. */
static inline void case_start_loose(struct rve_case *c, const struct rve_params *params, double pressure)
{
	struct rve_packing *packing = case_packing(pressure, 0.5, 1);
	case_start(c, params, packing);
	rve_packing_free(packing);
}

static inline void case_end(struct rve_case *c)
{
	free(c->state);
	rve_model_free(c->model);
}

/* One call; its status. */
static inline int case_try(struct rve_case *c, const double L[4], double dT, double dt)
{
	struct rve_batch batch = {.n = 1,
							  .states = c->state,
							  .L = (const double(*)[4])L,
							  .dT = &dT,
							  .T = &c->T,
							  .dt = dt,
							  .stress = &c->stress,
							  .heat = &c->heat,
							  .conductivity = &c->conductivity,
							  .modulus = &c->modulus};
	c->T += dT;
	return rve_advance(c->model, &batch);
}

static inline void case_advance(struct rve_case *c, const double L[4], double dT, double dt, int calls)
{
	for (int k = 0; k < calls; k++)
		if (case_try(c, L, dT, dt) != STATUS_OK)
			fail_msg("%s", error_message());
}

static inline struct rve_info case_info(const struct rve_case *c)
{
	struct rve_info info;
	rve_get_info(c->model, c->state, &info);
	return info;
}

/* Runs a group of tests on every path; in single precision a looser tolerance would hide what the others must keep, so
 * only the tests of test_rve_simd.c and of the bits run on it. */
#define CASE_RUN_ON_EACH_PATH(tests)                                                                                   \
	({                                                                                                                 \
		int failed = 0;                                                                                                \
		for (case_path = RVE_SERIAL; case_path <= RVE_SIMD; case_path++) {                                             \
			printf("path %s\n", rve_path_name(case_path));                                                             \
			failed += cmocka_run_group_tests(tests, NULL, NULL);                                                       \
		}                                                                                                              \
		failed;                                                                                                        \
	})

/* What is left of the work once every part of the ledger has had its share, J. */
static inline double case_residual(const struct rve_info *info)
{
	return info->work + info->expansion -
		   (info->elastic + info->kinetic + info->friction + info->dashpot + info->bond + info->discarded);
}

#endif
