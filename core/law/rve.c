/* The law of granular matter: behind every point stands an RVE (rve/rve.h) that the point's deformation drives. */
#include "rve/rve.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "law/law.h"
#include "law/twins.h"
#include "rve/from_scene.h"
#include "rve/packing.h"
#include "rve/pool.h"

static const struct field fields[] = {
	{"void_ratio", "-", 1, "pore area / disc area of the RVE"},
	{"coordination", "-", 1, "contacts per disc: 2 contacts / discs"},
	{"sliding_fraction", "-", 1, "share of the contacts at the Coulomb limit"},
	{"bond_fraction", "-", 1, "share of the installed bonds that are intact"},
	{"broken_bonds", "-", 1, "installed bonds that have broken"},
	{"sub_steps", "-", 1, "DEM steps that the last step took"},
	{"gas", "-", 1, "1 where the point flies freely and its RVE rests"},
	{"frozen", "-", 1, "1 where the RVE's cell could follow the deformation no further"},
	{"inertial_number", "-", 1, "strain per DEM step / dt_DEM, times d sqrt(rho / p)"},
	{"overlap", "-", 1, "largest overlap of two discs / the smaller radius"},
	{"rve_pressure", "Pa", 1, "mean pressure in the plane of the RVE"},
	{"rve_temperature", "K", 1, "temperature of the RVE from its reference, where radii are those of the packing"},
};
enum { N_FIELDS = sizeof fields / sizeof *fields };

static double field_value(const struct rve_info *info, int f)
{
	const double values[N_FIELDS] = {info->void_ratio,
									 info->coordination,
									 info->sliding_fraction,
									 info->bond_fraction,
									 info->bonds_installed - info->bonds_intact,
									 info->sub_steps,
									 info->flags & RVE_GAS ? 1.0 : 0.0,
									 info->flags & RVE_FROZEN ? 1.0 : 0.0,
									 info->inertial_number,
									 info->max_overlap,
									 info->pressure,
									 info->temperature};
	return values[f];
}

/* The state that holds what is true of a point: its own, or the one that it shares with its twins. */
static int home_of(const struct law *law, int slot) { return law->twins ? law->twins->home[slot] : slot; }

static unsigned char *state_of(const struct law *law, int slot)
{
	return law->states + (size_t)home_of(law, slot) * law->state_bytes;
}

/* Packings 0 .. n-1 of the law, and the model made of them. */
static int make_model(struct law *law, const struct scene_law *scene, int n)
{
	struct rve_params params;
	struct rve_model *model = NULL;
	rve_params_from_scene(&params, &scene->rve);
	CHECK(rve_params_check(&params)); /* before packings are made for nothing */
	struct rve_packing **packings = calloc((size_t)n, sizeof *packings);
	int status = packings ? STATUS_OK : error_set(STATUS_RESOURCE, "out of memory for %d packings", n);
	for (int v = 0; v < n && status == STATUS_OK; v++)
		status = rve_packing_from_scene(&packings[v], &scene->rve, v);
	if (status == STATUS_OK)
		status = rve_model_create(&model, &params, n, (const struct rve_packing *const *)packings);
	for (int v = 0; packings && v < n; v++)
		rve_packing_free(packings[v]);
	free(packings);
	law->model = model;
	return status;
}

static int create(struct law *law, const struct scene_law *scene, int n_points, const int *variant)
{
	int n = 1;
	for (int k = 0; k < n_points; k++)
		n = variant && variant[k] >= n ? variant[k] + 1 : n;
	int status = make_model(law, scene, n);
	if (status != STATUS_OK)
		return error_context(status, "%s:%d: law %s", scene->place.file ? scene->place.file : "scene",
							 scene->place.line, scene->name);
	double void_ratio = 0.0;
	for (int v = 0; v < n; v++)
		void_ratio += rve_void_ratio(law->model, v) / n;
	law->path = rve_path(law->model);
	law->density = scene->rve.grain_density / (1.0 + void_ratio);
	law->coupling = 1.0 / 3.0; /* measured: xxyy / xxxx is 0.09 dense, 0.32 loose */
	law->model_hash = rve_packings_hash(law->model);
	law->state_bytes = rve_state_bytes(law->model);
	size_t bytes = law->state_bytes * (size_t)(n_points > 0 ? n_points : 1);
	law->states = aligned_alloc(64, bytes);
	if (!law->states)
		return error_set(STATUS_RESOURCE, "law %s: %.0f MB for %d RVEs of %d discs are not to be had", scene->name,
						 (double)bytes * 1e-6, n_points, rve_discs(law->model));
	for (int k = 0; k < n_points; k++)
		CHECK(rve_init(law->model, variant ? variant[k] : 0, state_of(law, k)));
	return scene->rve.economy.twins ? twins_create(&law->twins, law->model, law->states, n_points) : STATUS_OK;
}

static void destroy(struct law *law)
{
	rve_pool_free(law->pool);
	twins_free(law->twins);
	rve_model_free(law->model);
	free(law->states);
}

static int evaluate(const struct law *law, struct law_batch *batch)
{
	for (int k = 0; k < batch->n; k++) {
		rve_evaluate(law->model, state_of(law, batch->slot[k]), batch->stress[k], batch->conductivity[k],
					 &batch->modulus[k]);
		batch->heat[k] = 0.0;
	}
	batch->failed = -1;
	return STATUS_OK;
}

static int advance(struct law *law, struct law_batch *batch)
{
	struct rve_batch rves = {.n = batch->n,
							 .states = law->states,
							 .slot = batch->slot,
							 .L = batch->L,
							 .dT = batch->dT,
							 .T = batch->T,
							 .pool = law->pool,
							 .dt = batch->dt,
							 .stress = batch->stress,
							 .heat = batch->heat,
							 .conductivity = batch->conductivity,
							 .modulus = batch->modulus,
							 .failed = -1};
	int status = law->twins ? twins_advance(law->twins, &rves) : rve_advance(law->model, &rves);
	batch->failed = rves.failed;
	return status == STATUS_OK ? status : error_context(status, "law %s", law->name);
}

static void export_field(const struct law *law, int f, int n, const int *slot, double *out)
{
	for (int k = 0; k < n; k++) {
		struct rve_info info;
		rve_get_info(law->model, state_of(law, slot[k]), &info);
		out[k] = field_value(&info, f);
	}
}

static void ledger(const struct law *law, int slot, struct law_ledger *sums)
{
	struct rve_info info;
	rve_get_info(law->model, state_of(law, slot), &info);
	double per_volume = 1.0 / info.volume0;
	*sums = (struct law_ledger){
		.work = info.work * per_volume,
		.elastic = info.elastic * per_volume,
		.kinetic = info.kinetic * per_volume,
		.friction = info.friction * per_volume,
		.dashpot = info.dashpot * per_volume,
		.bond = info.bond * per_volume,
		.expansion = info.expansion * per_volume,
		.discarded = info.discarded * per_volume,
	};
}

/* All points are reset together, and to reset a state twice is to reset it once. */
static void reset_ledger(struct law *law, int slot) { rve_reset_ledger(law->model, state_of(law, slot)); }

static int write_out(struct law *law)
{
	CHECK(rve_pool_fetch(law->pool, -1));
	if (law->twins)
		twins_write_out(law->twins, law->pool);
	return STATUS_OK;
}

static void restored(struct law *law)
{
	rve_pool_touched(law->pool, -1);
	if (law->twins)
		twins_find(law->twins);
}

static void counts(const struct law *law, struct law_counts *sums)
{
	memset(sums, 0, sizeof *sums);
	for (int k = 0; k < law->n_points; k++) {
		struct rve_info info;
		rve_get_info(law->model, state_of(law, k), &info);
		sums->disc_steps += info.total_sub_steps * rve_discs(law->model);
		sums->gas += (info.flags & RVE_GAS) != 0;
		sums->frozen += (info.flags & RVE_FROZEN) != 0;
		sums->reseeded += info.reseeded;
		sums->clamped += info.clamped;
		sums->rebuilds += info.rebuilds;
		sums->quiet_calls += info.quiet_calls;
		sums->quiet_caught += info.quiet_caught;
		sums->quiet_error_sum += info.quiet_error_sum;
		sums->quiet_error_most = fmax(sums->quiet_error_most, info.quiet_error_most);
		sums->paced_calls += info.paced_calls;
		sums->paced_saved += info.paced_saved * rve_discs(law->model);
		sums->paced_error_sum += info.paced_error_sum;
		sums->paced_error_most = fmax(sums->paced_error_most, info.paced_error_most);
		sums->bonds_installed += info.bonds_installed;
		sums->bonds_intact += info.bonds_intact;
		for (int bin = 0; bin < 12; bin++)
			sums->inertia[bin] += info.inertia[bin], sums->calls += info.inertia[bin];
	}
	if (law->twins) {
		sums->twin_calls = law->twins->saved_calls;
		sums->twin_disc_steps = law->twins->saved_sub_steps * rve_discs(law->model);
	}
}

static int install_bonds(struct law *law)
{
	CHECK(rve_pool_fetch(law->pool, -1));
	for (int k = 0; k < law->n_points; k++) /* twins get the same bonds once more */
		rve_install_bonds(law->model, state_of(law, k));
	rve_pool_touched(law->pool, -1);
	return STATUS_OK;
}

/* A new model on this path takes over the states. */
static int change_path(struct law *law, const char *path)
{
	static const enum scene_rve_path paths[] = {SCENE_RVE_SERIAL, SCENE_RVE_SIMD, SCENE_RVE_SINGLE};
	struct scene_law on_path = *law->scene;
	struct law next = *law;
	const int number = rve_path_number(path);
	if (number < 0)
		return error_set(STATUS_INPUT, "law %s: this release has no path \"%s\" for RVEs", law->name, path);
	on_path.rve.path = paths[number];
	CHECK(write_out(law));
	int status = make_model(&next, &on_path, rve_variants(law->model));
	if (status != STATUS_OK)
		return error_context(status, "law %s", law->name);
	next.path = rve_path(next.model);
	next.state_bytes = rve_state_bytes(next.model);
	next.twins = NULL;
	next.states = aligned_alloc(64, next.state_bytes * (size_t)(law->n_points > 0 ? law->n_points : 1));
	status = next.states ? rve_convert(law->model, law->n_points, law->states, next.model, next.states)
						 : error_set(STATUS_RESOURCE, "out of memory for %d RVEs", law->n_points);
	if (status == STATUS_OK && law->twins)
		status = twins_create(&next.twins, next.model, next.states, law->n_points);
	struct law *left = status == STATUS_OK ? law : &next; /* what is left over */
	twins_free(left->twins);
	rve_model_free(left->model);
	free(left->states);
	if (status != STATUS_OK)
		return error_context(status, "law %s", law->name);
	*law = next;
	return STATUS_OK;
}

static int use_devices(struct law *law, const char *devices, char *note, size_t note_bytes)
{
	rve_pool_free(law->pool);
	return rve_pool_create(&law->pool, law->model, law->states, law->n_points, devices, 0, note, note_bytes);
}

static void shares(const struct law *law, char *words, size_t bytes)
{
	snprintf(words, bytes, "cpu %d", law->n_points);
	if (law->pool)
		rve_pool_shares(law->pool, words, bytes);
}

static int rve_view(const struct law *law, int slot, const struct rve_model **model, const void **state)
{
	*model = law->model;
	*state = state_of(law, slot);
	return rve_pool_fetch(law->pool, home_of(law, slot));
}

const struct law_type law_rve = {
	.name = "rve",
	.doc = "granular matter: a periodic cell of discs behind every point (TM-DEMPM section 3)",
	.friction = true,
	.fields = fields,
	.n_fields = N_FIELDS,
	.create = create,
	.destroy = destroy,
	.evaluate = evaluate,
	.advance = advance,
	.export_field = export_field,
	.ledger = ledger,
	.reset_ledger = reset_ledger,
	.counts = counts,
	.install_bonds = install_bonds,
	.change_path = change_path,
	.use_devices = use_devices,
	.shares = shares,
	.write_out = write_out,
	.restored = restored,
	.rve_view = rve_view,
};
