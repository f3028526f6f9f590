/* RVEs that go through a hard life on this processor and on a device: sheared until lists are rebuilt and cells reduced,
 * heated, bonded, torn.  Include after cmocka.h and rve_case.h. */
#ifndef TESTS_COMMON_DEVICE_CASE_H
#define TESTS_COMMON_DEVICE_CASE_H

#include <unistd.h>

#include "rve/pool.h"

enum { DEVICE_CASE_RVES = 5 };

struct device_case {
	struct rve_model *model;
	int first, n; /* which of them live */
	unsigned char *states;
	double stress[DEVICE_CASE_RVES][4], heat[DEVICE_CASE_RVES], conductivity[DEVICE_CASE_RVES][3],
		modulus[DEVICE_CASE_RVES], T[DEVICE_CASE_RVES];
};

static inline void device_case_start(struct device_case *c, struct rve_model *model)
{
	memset(c, 0, sizeof *c);
	c->model = model;
	c->n = DEVICE_CASE_RVES;
	c->states = aligned_alloc(64, DEVICE_CASE_RVES * rve_state_bytes(model));
	assert_non_null(c->states);
	for (int k = 0; k < DEVICE_CASE_RVES; k++) {
		unsigned char *state = c->states + (size_t)k * rve_state_bytes(model);
		assert_int_equal(rve_init(model, 0, state), STATUS_OK);
		c->T[k] = 293.0;
		if (k >= 3)
			rve_install_bonds(model, state);
	}
}

static inline void device_case_end(struct device_case *c) { free(c->states); }

/* One call: shear, biaxial, rotation, tension of a bonded one, heating of a bonded one. */
static inline int device_case_advance(struct device_case *c, struct rve_pool *pool, double strain)
{
	const double way[DEVICE_CASE_RVES][4] = {
		{0.0, 1.0, 0.0, 0.0}, {0.5, 0.1, 0.0, -0.6}, {0.0, -1.0, 1.0, 0.0}, {0.3, 0.0, 0.2, 0.1}, {0.0, 0.5, 0.5, 0.0}};
	double L[DEVICE_CASE_RVES][4], dT[DEVICE_CASE_RVES];
	for (int k = 0; k < DEVICE_CASE_RVES; k++) {
		for (int q = 0; q < 4; q++)
			L[k][q] = way[k][q] * strain / 1e-4;
		dT[k] = k == 1 ? 2.0 : k == 4 ? 15.0 : 0.0;
		c->T[k] += dT[k];
	}
	struct rve_batch batch = {.n = c->n,
							  .states = c->states + (size_t)c->first * rve_state_bytes(c->model),
							  .L = (const double(*)[4])L + c->first,
							  .dT = dT + c->first,
							  .T = c->T + c->first,
							  .pool = pool,
							  .dt = 1e-4,
							  .stress = c->stress + c->first,
							  .heat = c->heat + c->first,
							  .conductivity = c->conductivity + c->first,
							  .modulus = c->modulus + c->first};
	return rve_advance(c->model, &batch);
}

/* Bit for bit: the answers of the last call and, once fetched, the states. */
static inline void device_case_equal(const struct device_case *a, const struct device_case *b)
{
	assert_memory_equal(a->stress, b->stress, sizeof a->stress);
	assert_memory_equal(a->heat, b->heat, sizeof a->heat);
	assert_memory_equal(a->conductivity, b->conductivity, sizeof a->conductivity);
	assert_memory_equal(a->modulus, b->modulus, sizeof a->modulus);
	size_t bytes = rve_state_bytes(a->model);
	for (int k = 0; k < DEVICE_CASE_RVES; k++)
		assert_memory_equal(a->states + (size_t)k * bytes, b->states + (size_t)k * bytes, bytes);
}

/* The model of that life; free with rve_model_free(). */
static inline struct rve_model *device_case_model(int discs)
{
	struct rve_params params;
	struct rve_packing *packing;
	struct rve_model *model;
	rve_params_default(&params);
	params.bond_strength = 0.02;
	params.bond_melting = 400.0;
	params.bond_reference = 300.0;
	params.n_max = 4; /* few sub-steps, far apart: simulators are slow */
	const struct rve_packing_params how = {.discs = discs,
										   .radius_min = 0.25e-3,
										   .radius_max = 0.5e-3,
										   .pressure = 100e3,
										   .mu = 0.5,
										   .void_ratio = NAN,
										   .seed = 1};
	struct rve_params grains;
	rve_params_default(&grains);
	if (rve_packing_cached(&packing, &how, &grains) != STATUS_OK)
		fail_msg("%s", error_message());
	const struct rve_packing *const packings[1] = {packing};
	if (rve_model_create(&model, &params, 1, packings) != STATUS_OK)
		fail_msg("%s", error_message());
	rve_packing_free(packing);
	return model;
}

/* Here and at `where`, in blocks of so many threads: the same bits in every answer and in the states at the end. */
static inline void device_case_lives_equal(struct rve_model *model, const char *where, int threads)
{
	struct device_case here, there;
	struct rve_pool *pool;
	char note[1024];
	device_case_start(&here, model);
	device_case_start(&there, model);
	if (rve_pool_create(&pool, model, there.states, DEVICE_CASE_RVES, where, threads, note, sizeof note) != STATUS_OK)
		fail_msg("%s", error_message());
	assert_non_null(pool);
	for (int k = 0; k < 4; k++) {
		assert_int_equal(device_case_advance(&here, NULL, 4e-2), STATUS_OK);
		if (device_case_advance(&there, pool, 4e-2) != STATUS_OK)
			fail_msg("%s", error_message());
		assert_memory_equal(here.stress, there.stress, sizeof here.stress);
	}
	assert_int_equal(rve_pool_fetch(pool, -1), STATUS_OK);
	device_case_equal(&here, &there);
	struct rve_info info;
	rve_get_info(model, here.states, &info);
	assert_true(info.rebuilds > 0);
	rve_get_info(model, here.states + 3 * rve_state_bytes(model), &info);
	assert_true(info.bonds_intact < info.bonds_installed);
	rve_pool_free(pool);
	device_case_end(&here);
	device_case_end(&there);
}

/* Chooses the OpenCL driver that is this library, whose device's name begins so, for this process; `file` is to name it
 * (the OpenCL library finds its drivers by files that do).  0 = there is none. */
static inline int device_case_driver(const char *library, const char *name, const char *file)
{
	struct rve_device_info devices[RVE_DEVICES_MOST];
	char why[256];
	FILE *icd = access(library, R_OK) == 0 ? fopen(file, "w") : NULL;
	if (!icd)
		return 0;
	fprintf(icd, "%s\n", library);
	fclose(icd);
	setenv("OCL_ICD_VENDORS", file, 1);
	setenv("OCLGRIND_LOCAL_MEM_SIZE", "131072", 1);
	for (int b = 0; rve_backends[b]; b++)
		if (!strcmp(rve_backends[b]->name, "opencl"))
			return rve_backends[b]->list(devices, RVE_DEVICES_MOST, why, sizeof why) > 0 && !devices[0].unfit[0] &&
				   !strncmp(devices[0].name, name, strlen(name));
	return 0;
}

#endif
