/* Speed of one RVE on one core: whole rve_advance() calls, list rebuilds and homogenisation included. */
#include "run/bench.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "base/error.h"
#include "rve/packing.h"
#include "rve/rve.h"

enum { DISCS = 400, REPEATS = 5, SUB_STEPS_PER_CALL = 20 };

static double thread_seconds(void)
{
	struct timespec now;
	clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
	return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Shears one RVE on and on at constant volume for `calls` calls; disc-steps per second. */
static int shear(const struct rve_model *model, unsigned char *state, double strain_per_call, int calls, double *rate)
{
	const double dt = 1e-3;
	double stress[1][4], heat[1], conductivity[1][3], modulus[1], dT[1] = {0};
	const double L[1][4] = {{0.0, 2.0 * strain_per_call / dt, 0.0, 0.0}}; /* twice its largest principal rate */
	struct rve_batch batch = {.n = 1,
							  .states = state,
							  .L = L,
							  .dT = dT,
							  .dt = dt,
							  .stress = stress,
							  .heat = heat,
							  .conductivity = conductivity,
							  .modulus = modulus};
	struct rve_info before, after;
	rve_get_info(model, state, &before);
	double start = thread_seconds();
	for (int k = 0; k < calls; k++)
		CHECK(rve_advance(model, &batch));
	double elapsed = thread_seconds() - start;
	rve_get_info(model, state, &after);
	*rate = (double)(after.total_sub_steps - before.total_sub_steps) * rve_discs(model) / elapsed;
	return STATUS_OK;
}

/* One case: `strain_per_step` decides how violent it is; the default rebuilds its list about every 40 sub-steps, 2e-4
 * (the economy setting) about every 15.  Strong bonds hold lumps together for as long as is measured. */
static int bench_case(bool json, const char *name, const struct rve_packing *packing, double strain_per_step,
					  double bond_strength, int path)
{
	struct rve_params params;
	rve_params_default(&params);
	params.path = path;
	params.strain_per_step = strain_per_step;
	params.pressure_scaling = 0;
	params.bond_strength = bond_strength;
	const struct rve_packing *const packings[1] = {packing};
	struct rve_model *model;
	CHECK(rve_model_create(&model, &params, 1, packings));
	unsigned char *state = aligned_alloc(64, rve_state_bytes(model));
	double rates[REPEATS], strain = strain_per_step * (SUB_STEPS_PER_CALL - 0.5);
	int status = state ? rve_init(model, 0, state) : error_set(STATUS_RESOURCE, "out of memory for one RVE");
	if (status == STATUS_OK) {
		rve_install_bonds(model, state);
		status = shear(model, state, strain, 200, &rates[0]); /* from the packing into flow */
	}
	for (int k = 0; k < REPEATS && status == STATUS_OK; k++)
		status = shear(model, state, strain, 2000, &rates[k]);
	if (status == STATUS_OK)
		bench_report(json, name, rates, REPEATS, "disc-steps/s", 1);
	free(state);
	rve_model_free(model);
	return status;
}

int bench_rve(bool json)
{
	struct rve_params params;
	rve_params_default(&params);
	const struct rve_packing_params how = {.discs = DISCS,
										   .radius_min = 0.25e-3,
										   .radius_max = 0.5e-3,
										   .pressure = 100e3,
										   .mu = 0.5,
										   .void_ratio = NAN,
										   .seed = 1};
	struct rve_packing *packing;
	CHECK(rve_packing_cached(&packing, &how, &params));
	bench_header(json, 1);
	static const char *const paths[] = {"serial", "simd", "single"};
	int status = STATUS_OK;
	for (int path = 0; path < 3 && status == STATUS_OK; path++) {
		char name[64];
		snprintf(name, sizeof name, "rve_%s", paths[path]);
		status = bench_case(json, name, packing, 5e-5, 0.0, path);
		snprintf(name, sizeof name, "rve_%s_violent", paths[path]);
		if (status == STATUS_OK)
			status = bench_case(json, name, packing, 2e-4, 0.0, path);
		snprintf(name, sizeof name, "rve_%s_bonded", paths[path]);
		if (status == STATUS_OK)
			status = bench_case(json, name, packing, 5e-5, 0.1, path);
	}
	rve_packing_free(packing);
	return status;
}
