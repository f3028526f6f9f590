#include "law/twins.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "rve/pool.h"

static unsigned char *state_at(const struct twins *t, int slot)
{
	return t->states + (size_t)slot * rve_state_bytes(t->model);
}

/* Of whole 64-bit words, of which all that is hashed here consists. */
static uint64_t hash_words(uint64_t hash, const void *data, size_t bytes)
{
	for (size_t k = 0; k < bytes / sizeof hash; k++) {
		uint64_t word;
		memcpy(&word, (const unsigned char *)data + k * sizeof word, sizeof word);
		hash = (hash ^ word) * UINT64_C(0x9e3779b97f4a7c15);
		hash ^= hash >> 29;
	}
	return hash;
}

/* ---- who is equal ---- */

static int *bucket(const struct twins *t, uint64_t hash, uint64_t probe)
{
	return &t->table[(hash + probe) & (uint64_t)(t->table_size - 1)];
}

static void clear_table(struct twins *t) { memset(t->table, 0xff, (size_t)t->table_size * sizeof *t->table); }

static void count_sharers(struct twins *t)
{
	memset(t->sharers, 0, (size_t)t->n * sizeof *t->sharers);
	t->shared = 0;
	for (int k = 0; k < t->n; k++) {
		t->sharers[t->home[k]]++;
		t->shared += t->home[k] != k;
	}
}

void twins_find(struct twins *t)
{
	size_t bytes = rve_state_bytes(t->model);
	clear_table(t);
	for (int k = 0; k < t->n; k++) {
		uint64_t hash = hash_words(0, state_at(t, k), bytes), probe = 0;
		int *at = bucket(t, hash, probe);
		while (*at >= 0 && memcmp(state_at(t, *at), state_at(t, k), bytes) != 0)
			at = bucket(t, hash, ++probe);
		*at = *at < 0 ? k : *at;
		t->home[k] = *at;
	}
	count_sharers(t);
}

static void copy(struct twins *t, struct rve_pool *pool, int to, int from)
{
	memcpy(state_at(t, to), state_at(t, from), rve_state_bytes(t->model));
	rve_pool_touched(pool, to);
}

void twins_write_out(struct twins *t, struct rve_pool *pool)
{
	for (int k = 0; k < t->n && t->shared > 0; k++)
		if (t->home[k] != k)
			copy(t, pool, k, t->home[k]);
}

/* ---- life ---- */

static void *array(size_t n, size_t size) { return calloc(n > 0 ? n : 1, size); }

int twins_create(struct twins **result, const struct rve_model *model, unsigned char *states, int n_points)
{
	size_t n = (size_t)n_points;
	struct twins *t = *result = calloc(1, sizeof *t);
	if (!t)
		return error_set(STATUS_RESOURCE, "out of memory for twins of %d RVEs", n_points);
	*t = (struct twins){.model = model, .states = states, .n = n_points, .table_size = 16};
	while (t->table_size < 2 * n_points)
		t->table_size *= 2;
	t->table = array((size_t)t->table_size, sizeof *t->table);
	t->home = array(n, sizeof *t->home), t->sharers = array(n, sizeof *t->sharers);
	t->first = array(n, sizeof *t->first), t->slot = array(n, sizeof *t->slot);
	t->member = array(n, sizeof *t->member);
	t->L = array(n, sizeof *t->L), t->dT = array(n, sizeof *t->dT), t->T = array(n, sizeof *t->T);
	t->stress = array(n, sizeof *t->stress), t->heat = array(n, sizeof *t->heat);
	t->conductivity = array(n, sizeof *t->conductivity), t->modulus = array(n, sizeof *t->modulus);
	if (!t->table || !t->home || !t->sharers || !t->first || !t->slot || !t->member || !t->L || !t->dT || !t->T ||
		!t->stress || !t->heat || !t->conductivity || !t->modulus)
		return error_set(STATUS_RESOURCE, "out of memory for twins of %d RVEs", n_points);
	twins_find(t);
	return STATUS_OK;
}

void twins_free(struct twins *t)
{
	if (!t)
		return;
	void *const arrays[] = {t->table, t->home, t->sharers, t->first, t->slot,         t->member, t->L,
							t->dT,    t->T,    t->stress,  t->heat,  t->conductivity, t->modulus};
	for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++)
		free(arrays[k]);
	free(t);
}

/* ---- one call ---- */

static bool same_motion(const struct rve_batch *batch, int a, int b)
{
	return !memcmp(batch->L[a], batch->L[b], sizeof batch->L[a]) &&
		   !memcmp(&batch->dT[a], &batch->dT[b], sizeof(double)) &&
		   (!batch->T || !memcmp(&batch->T[a], &batch->T[b], sizeof(double)));
}

/* member[k] = the distinct RVE of the batch's point k, first[] = by which point it is known.  Returns how many. */
static int sort_out(struct twins *t, const struct rve_batch *batch)
{
	int distinct = 0;
	clear_table(t);
	for (int k = 0; k < batch->n; k++) {
		int home = t->home[batch->slot[k]], *at = NULL;
		if (t->sharers[home] > 1) {
			uint64_t word = (uint64_t)home, probe = 0, hash = hash_words(0, &word, sizeof word);
			hash = hash_words(hash_words(hash, batch->L[k], sizeof batch->L[k]), &batch->dT[k], sizeof(double));
			at = bucket(t, hash, probe);
			while (*at >= 0 && (t->home[batch->slot[t->first[*at]]] != home || !same_motion(batch, t->first[*at], k)))
				at = bucket(t, hash, ++probe);
		}
		if (!at || *at < 0)
			t->first[distinct] = k;
		if (at && *at < 0)
			*at = distinct;
		t->member[k] = at && t->first[*at] != k ? *at : distinct;
		distinct += t->member[k] == distinct;
	}
	return distinct;
}

/* Each distinct RVE gets a slot of its own: the home's for those who stay with it, a copy for those who part. */
static int part(struct twins *t, const struct rve_batch *batch, int distinct)
{
	for (int d = 0; d < distinct; d++)
		t->slot[d] = -1;
	for (int k = 0; k < batch->n; k++)
		if (t->home[batch->slot[k]] == batch->slot[k])
			t->slot[t->member[k]] = batch->slot[k];
	for (int d = 0; d < distinct; d++)
		if (t->slot[d] < 0) {
			t->slot[d] = batch->slot[t->first[d]];
			CHECK(rve_pool_fetch(batch->pool, t->home[t->slot[d]]));
			copy(t, batch->pool, t->slot[d], t->home[t->slot[d]]);
		}
	for (int k = 0; k < batch->n; k++)
		t->home[batch->slot[k]] = t->slot[t->member[k]];
	count_sharers(t);
	return STATUS_OK;
}

static void hand_out(struct twins *t, struct rve_batch *batch)
{
	for (int k = 0; k < batch->n; k++) {
		int d = t->member[k];
		memcpy(batch->stress[k], t->stress[d], sizeof batch->stress[k]);
		memcpy(batch->conductivity[k], t->conductivity[d], sizeof batch->conductivity[k]);
		batch->heat[k] = t->heat[d];
		batch->modulus[k] = t->modulus[d];
		if (t->first[d] != k) {
			struct rve_info info;
			rve_get_info(t->model, state_at(t, t->slot[d]), &info);
			t->saved_calls++;
			t->saved_sub_steps += info.sub_steps;
		}
	}
}

int twins_advance(struct twins *t, struct rve_batch *batch)
{
	if (batch->n != t->n && t->shared > 0) { /* those that are left behind must not see their home move */
		CHECK(rve_pool_fetch(batch->pool, -1));
		twins_write_out(t, batch->pool);
		for (int k = 0; k < t->n; k++)
			t->home[k] = k;
		count_sharers(t);
	}
	if (t->shared == 0)
		return rve_advance(t->model, batch);
	int distinct = sort_out(t, batch);
	CHECK(part(t, batch, distinct));
	for (int d = 0; d < distinct; d++) {
		int k = t->first[d];
		memcpy(t->L[d], batch->L[k], sizeof t->L[d]);
		t->dT[d] = batch->dT[k];
		t->T[d] = batch->T ? batch->T[k] : 0.0;
	}
	struct rve_batch few = *batch;
	few.n = distinct, few.slot = t->slot, few.number = t->first;
	few.L = (const double(*)[4])t->L, few.dT = t->dT, few.T = batch->T ? t->T : NULL;
	few.stress = t->stress, few.heat = t->heat, few.conductivity = t->conductivity, few.modulus = t->modulus;
	int status = rve_advance(t->model, &few);
	hand_out(t, batch);
	batch->failed = few.failed < 0 ? -1 : t->first[few.failed];
	return status;
}
