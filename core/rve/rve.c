/* The host side of the RVE: models, start states, and what decides about a cell between two kernel calls. */
#include "rve/rve.h"

#include <math.h>
#include <omp.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "base/mat2.h"
#include "rve/model.h"
#include "rve/pool.h"
#include "rve/pace.h"
#include "rve/quiet.h"

static const double pi = 3.14159265358979323846;
static const struct rve_motion rest; /* for measuring */

void rve_params_default(struct rve_params *params)
{
	*params = (struct rve_params){.path = RVE_SERIAL,
								  .kn = 1e6,
								  .ks = 1e6,
								  .mu = 0.5,
								  .damping_ratio = 0.2,
								  .grain_density = 2650.0,
								  .thickness = 0.075,
								  .expansion = 1e-4,
								  .resistance = 1e4,
								  .pace_calm = 1.0,
								  .step_factor = 0.4,
								  .strain_per_step = 5e-5,
								  .pressure_scaling = 1,
								  .n_max = 20,
								  .skin = 0.2,
								  .gas = 1,
								  .gas_pressure = 20.0,
								  .gas_stretch = 1.12,
								  .bond_strength = 0.0,
								  .bond_mu = 0.5,
								  .bond_melting = INFINITY,
								  .bond_reference = NAN,
								  .quiet_change = 0.0,
								  .quiet_strain = 1e-4,
								  .quiet_unbalanced = 0.02,
								  .step_guard = 1,
								  .overlap_max = 0.5};
}

const char *rve_path_name(int path)
{
	static const char *const names[] = {"serial", "simd", "single"};
	return names[path];
}

int rve_path_number(const char *name)
{
	for (int path = RVE_SERIAL; path <= RVE_SIMD_SINGLE; path++)
		if (!strcmp(name, rve_path_name(path)))
			return path;
	return -1;
}

double rve_step_factor_limit(const struct rve_params *params)
{
	double zeta = params->damping_ratio;
	double rolling = 0.5 * sqrt(params->kn / fmax(params->ks, 1e-12 * params->kn));
	return fmin(rolling, 0.62 * (sqrt(1.0 + zeta * zeta) - zeta));
}

int rve_params_check(const struct rve_params *params)
{
	double limit = rve_step_factor_limit(params);
	if (!params->step_guard || params->step_factor <= limit)
		return STATUS_OK;
	return error_set(
		STATUS_INPUT,
		"step_factor = %g is above %.3g, the largest that is safe with ks/kn = %g and a damping_ratio of %g; "
		"cure: step_factor = %.2g or less",
		params->step_factor, limit, params->ks / params->kn, params->damping_ratio, limit);
}

/* ---- the model ---- */

static int place_array(int *end, int bytes)
{
	int begin = (*end + 63) / 64 * 64;
	*end = begin + bytes;
	return begin;
}

static int layout_make(struct rve_layout *layout, int n, double skin, double r_min, double r_max)
{
	layout->n = n;
	layout->stride = (n + 1 + ROW_PAD - 1) / ROW_PAD * ROW_PAD; /* a ghost at least */
	/* discs in the plane have six neighbours on average at most; a wide skin reaches the second ones */
	layout->levels = 3 + (int)ceil(pi * (1.0 + r_max / r_min) * (1.0 + 0.5 * skin));
	layout->pairs = (int)(n * 3.0 * fmax(1.0, (2.0 + skin) * (2.0 + skin) / 4.84)) + ROW_PAD * layout->levels;
	layout->pair_stride = (layout->pairs + 1 + 7) / 8 * 8;
	layout->grid = (int)sqrt((double)n);
	if (layout->pair_stride > UINT16_MAX)
		return error_set(STATUS_INPUT, "an RVE of %d discs: too many, at most %d", n,
						 (int)((long)n * UINT16_MAX / layout->pair_stride));
	if (layout->levels > RVE_LEVELS_MAX)
		return error_set(STATUS_INPUT, "radii from %g to %g m: the ratio is too wide, at most about 9", r_min, r_max);
	int end = sizeof(struct rve_head);
	layout->disc = place_array(&end, (int)sizeof(real) * DISC_STATE_FIELDS * layout->stride);
	layout->disc32 = place_array(&end, (int)sizeof(real32) * DISC32_FIELDS * layout->stride);
	layout->ft = place_array(&end, (int)sizeof(real) * layout->pairs);
	layout->fd = place_array(&end, (int)sizeof(real32) * layout->pairs);
	layout->damping = place_array(&end, (int)sizeof(real32) * layout->pairs);
	layout->pair_j = place_array(&end, (int)sizeof(index16) * layout->pairs);
	layout->id = place_array(&end, (int)sizeof(index16) * layout->stride);
	layout->flag = place_array(&end, layout->pairs);
	layout->entry = place_array(&end, (int)sizeof(index16) * layout->levels * layout->stride);
	layout->bytes = (end + 63) / 64 * 64;
	layout->scratch = rve_kernel_scratch_bytes(layout);
	return STATUS_OK;
}

/* The layout of packed states for the discs of a serial one. */
static void layout_pack(struct rve_layout *layout, const struct rve_layout *serial, int single)
{
	const int lanes = single ? 16 : 8, number = single ? (int)sizeof(real32) : (int)sizeof(real);
	*layout = *serial;
	layout->lanes = lanes;
	layout->single = single;
	layout->stride = (serial->n + lanes - 1) / lanes * lanes;
	layout->pairs = (serial->pairs + 2 * lanes * serial->levels + lanes - 1) / lanes * lanes; /* blocks are less even */
	layout->pair_stride = layout->pairs;
	int end = sizeof(struct rve_head);
	layout->disc = place_array(&end, number * (single ? PACKED_FIELDS : PACKED_REST_X) * layout->stride);
	layout->disc32 = place_array(&end, (int)sizeof(real32) * DISC32_FIELDS * layout->stride);
	layout->ft = place_array(&end, number * layout->pairs);
	layout->fd = place_array(&end, (int)sizeof(real32) * layout->pairs);
	layout->damping = place_array(&end, (int)sizeof(real32) * layout->pairs);
	layout->pair_j = place_array(&end, (int)sizeof(index16) * layout->pairs);
	layout->id = place_array(&end, (int)sizeof(index16) * layout->stride);
	layout->flag = place_array(&end, layout->pairs);
	layout->first = place_array(&end, (int)sizeof(index16) * (layout->stride / lanes + 1));
	layout->entry = 0;
	layout->bytes = (end + 63) / 64 * 64;
	layout->scratch = single ? rve_packed32_scratch(layout) : rve_packed64_scratch(layout);
}

static int variant_tables(const struct rve_model *model, struct rve_variant *variant, const struct rve_packing *packing)
{
	const struct rve_layout *layout = &model->serial;
	size_t table_bytes = sizeof(real) * TABLE_FIELDS * (size_t)layout->stride;
	variant->table = aligned_alloc(64, (table_bytes + 63) / 64 * 64);
	variant->serial_start = aligned_alloc(64, (size_t)layout->bytes);
	variant->start = aligned_alloc(64, (size_t)model->layout.bytes);
	variant->packed_table = aligned_alloc(64, (sizeof(real) * PACKED_TABLE * (size_t)(layout->n + 1) + 63) / 64 * 64);
	if (!variant->table || !variant->serial_start || !variant->start || !variant->packed_table)
		return error_set(STATUS_RESOURCE, "out of memory for an RVE of %d discs", layout->n);
	memset(variant->table, 0, table_bytes);
	memset(variant->serial_start, 0, (size_t)layout->bytes);
	variant->solid_area = 0.0;
	for (int i = 0; i < layout->n; i++) {
		double r = packing->r[i], area = pi * r * r,
			   mass = model->params.grain_density * area * model->params.thickness;
		variant->solid_area += area;
		variant->table[TABLE_R * layout->stride + i] = r;
		variant->table[TABLE_MASS * layout->stride + i] = mass;
		variant->table[TABLE_DT_MASS * layout->stride + i] = model->constants.dt / mass;
		variant->table[TABLE_DT_INERTIA * layout->stride + i] = model->constants.dt / (0.5 * mass * r * r);
	}
	for (int i = layout->n; i < layout->stride;
		 i++) { /* the ghost: so small that it touches nothing, and does not move */
		variant->table[TABLE_R * layout->stride + i] = -1e6;
		variant->table[TABLE_MASS * layout->stride + i] = 1.0;
	}
	variant->volume = mat2_determinant(packing->H) * model->params.thickness;
	variant->void_ratio = mat2_determinant(packing->H) / variant->solid_area - 1.0;
	return STATUS_OK;
}

static struct rve_head *head_of(const void *state) { return (struct rve_head *)(uintptr_t)state; }

static real *state_discs(const struct rve_layout *layout, const void *state, int field)
{
	return (real *)((unsigned char *)(uintptr_t)state + layout->disc) + field * layout->stride;
}

/* Tangential forces of a packing's contacts, put where the state's pairs are; the same seen from either disc. */
static void variant_forces(const struct rve_layout *layout, struct rve_variant *variant,
						   const struct rve_packing *packing)
{
	const struct rve_head *head = head_of(variant->serial_start);
	const index16 *pair_j = (const index16 *)(variant->serial_start + layout->pair_j),
				  *id = (const index16 *)(variant->serial_start + layout->id);
	real *ft = (real *)(variant->serial_start + layout->ft);
	for (int level = 0; level < head->levels; level++)
		for (int row = 0; row < head->level_rows[level]; row++) {
			int p = head->level_first[level] + row, a = id[row], b = id[pair_j[p]];
			for (int c = 0; c < packing->n_contacts; c++)
				if ((packing->pair[c][0] == a && packing->pair[c][1] == b) ||
					(packing->pair[c][0] == b && packing->pair[c][1] == a))
					ft[p] = packing->ft[c];
		}
}

static struct rve_call call_of(const struct rve_motion *motion, int sub_steps, int rebuild)
{
	struct rve_call call = {.sub_steps = sub_steps, .rebuild = rebuild, .temperature = motion->T - motion->dT};
	const double *L = motion->L;
	double h = sub_steps > 0 ? motion->duration / sub_steps : 0.0;
	double spin = 0.5 * (L[1] - L[2]) * h;
	double increment[4] = {L[0] * h, L[1] * h, L[2] * h, L[3] * h}, rotation[4] = {0.0, spin, -spin, 0.0};
	mat2_exp(increment, call.A);
	mat2_exp(rotation, call.B);
	call.D[0] = L[0] * h, call.D[1] = L[3] * h, call.D[2] = 0.5 * (L[1] + L[2]) * h;
	call.B[0] -= call.D[0], call.B[1] -= call.D[2], call.B[2] -= call.D[2], call.B[3] -= call.D[1];
	call.heating = sub_steps > 0 ? motion->dT / sub_steps : 0.0;
	return call;
}

/* A state of the serial path as it is, with a new list if asked for. */
static int measure_serial(const struct rve_model *model, void *state, int rebuild)
{
	const struct rve_call call = call_of(&rest, 0, rebuild);
	int status = KERNEL_OK;
	model->kernel(&model->serial, &model->constants, &call, model->variants[head_of(state)->variant].table, state,
				  rve_scratch(model, 0), &status);
	return status;
}

static int variant_start(struct rve_model *model, int number, const struct rve_packing *packing)
{
	const struct rve_layout *layout = &model->serial;
	struct rve_variant *variant = &model->variants[number];
	struct rve_head *head = head_of(variant->serial_start);
	double inverse[4];
	mat2_inverse(packing->H, inverse);
	for (int k = 0; k < 4; k++)
		head->H[k] = head->H_ref[k] = packing->H[k];
	mat2_identity(head->F);
	head->variant = number;
	for (int i = 0; i < layout->n; i++) {
		const double *x = packing->x[i];
		((index16 *)(variant->serial_start + layout->id))[i] = (index16)i;
		state_discs(layout, variant->serial_start, DISC_SX)[i] = inverse[0] * x[0] + inverse[1] * x[1];
		state_discs(layout, variant->serial_start, DISC_SY)[i] = inverse[2] * x[0] + inverse[3] * x[1];
	}
	for (int i = layout->n; i < layout->stride; i++)
		((index16 *)(variant->serial_start + layout->id))[i] = (index16)layout->n;
	int status = measure_serial(model, variant->serial_start, 1);
	if (status == KERNEL_SLENDER)
		return error_set(STATUS_INPUT,
						 "the packing's cell is narrower than twice a disc's reach (%g m): more discs, "
						 "closer radii or a smaller skin",
						 4.0 * model->constants.r_max + 2.0 * model->constants.skin);
	if (status != KERNEL_OK)
		return error_set(STATUS_INPUT, "the packing's discs overlap too much to be neighbours");
	variant_forces(layout, variant, packing);
	measure_serial(model, variant->serial_start, 0);
	head->ledger[LEDGER_WORK] = head->ledger[LEDGER_ELASTIC] + head->ledger[LEDGER_KINETIC];
	head->rebuilds = 0;
	if (!model->packed) {
		memcpy(variant->start, variant->serial_start, (size_t)layout->bytes);
		return STATUS_OK;
	}
	rve_packed_table(model, variant->table, variant->packed_table);
	rve_pack(model, variant->serial_start, variant->start);
	return STATUS_OK;
}

/* Single precision errs by about 1 Pa from 10 to 100 kPa, in packings of 1 kPa by up to 60 Pa, most of it chaos:
 * scenarios/studies/rve_precision.cfg.  Asked of packings only: where material comes loose in a run, single errs by
 * thousandths of the pressure down to that of the gas state (tests/unit/test_rve_simd.c). */
static const double single_pressure = 10e3; /* Pa */

static int check_precision(const struct rve_params *params, const struct rve_packing *packing)
{
	if (params->path != RVE_SIMD_SINGLE || !(packing->pressure < single_pressure))
		return STATUS_OK;
	return error_set(STATUS_INPUT,
					 "path = \"single\" errs by too much in a packing at %g Pa, expected %g Pa at least; cure: "
					 "path = \"simd\"",
					 packing->pressure, single_pressure);
}

static int model_fill(struct rve_model *model, const struct rve_params *params, int n,
					  const struct rve_packing *const *packings)
{
	double r_min = INFINITY, r_max = 0.0, r_sum = 0.0;
	for (int v = 0; v < n; v++) {
		CHECK(check_precision(params, packings[v]));
		if (packings[v]->n_discs != packings[0]->n_discs)
			return error_set(STATUS_INPUT, "packings of %d and %d discs in one law: variants need equal numbers",
							 packings[0]->n_discs, packings[v]->n_discs);
		for (int i = 0; i < packings[v]->n_discs; i++) {
			r_min = fmin(r_min, packings[v]->r[i]);
			r_max = fmax(r_max, packings[v]->r[i]);
			r_sum += packings[v]->r[i];
		}
	}
	if (!(params->bond_strength < params->skin))
		return error_set(
			STATUS_INPUT,
			"bonds of strength %g: expected less than the skin of %g, so that bonded discs stay neighbours",
			params->bond_strength, params->skin);
	int discs = packings[0]->n_discs;
	double mass_min = params->grain_density * params->thickness * pi * r_min * r_min;
	double dt = params->step_factor * sqrt(mass_min / params->kn);
	int softening = isfinite(params->bond_melting) && isfinite(params->bond_reference);
	model->diameter = 2.0 * r_sum / ((double)n * discs);
	model->constants =
		(struct rve_constants){.kn = params->kn,
							   .ks = params->ks,
							   .mu = params->mu,
							   .expansion = params->expansion,
							   .resistance = params->resistance,
							   .thickness = params->thickness,
							   .dt = dt,
							   .r_max = r_max,
							   .skin = params->skin * r_max,
							   .damping = 2.0 * params->damping_ratio * sqrt(params->kn) / dt,
							   .bond_force = 0.5 * params->bond_strength * params->kn,
							   .bond_mu = params->bond_mu,
							   .bond_melting = params->bond_melting,
							   .bond_slope = softening ? 1.0 / (params->bond_melting - params->bond_reference) : 0.0};
	CHECK(layout_make(&model->serial, discs, params->skin, r_min, r_max));
	model->layout = model->serial;
	if (model->packed)
		layout_pack(&model->layout, &model->serial, params->path == RVE_SIMD_SINGLE);
	model->kept = model->serial.scratch > model->layout.scratch ? model->serial.scratch : model->layout.scratch;
	model->scratch_stride = (size_t)(model->kept + model->layout.bytes);
	model->scratch = aligned_alloc(64, model->scratch_stride * (size_t)model->n_threads);
	model->variants = calloc((size_t)n, sizeof *model->variants);
	if (!model->scratch || !model->variants)
		return error_set(STATUS_RESOURCE, "out of memory for the RVE model");
	model->n_variants = n;
	for (int v = 0; v < n; v++) {
		CHECK(variant_tables(model, &model->variants[v], packings[v]));
		CHECK(variant_start(model, v, packings[v]));
	}
	return STATUS_OK;
}

/* The compilations that this processor runs. */
static void choose_kernels(struct rve_model *model)
{
	static rve_kernel *const kernels[] = {rve_kernel_base,
#ifdef RVE_KERNEL_X86
										  rve_kernel_v3, rve_kernel_v4
#endif
	};
	static rve_packed_kernel *const packed[][2] = {{rve_packed64_base, rve_packed32_base},
#ifdef RVE_KERNEL_X86
												   {rve_packed64_v3, rve_packed32_v3},
												   {rve_packed64_v4, rve_packed32_v4}
#endif
	};
	const char *isa = rve_isa();
	const int k = strcmp(isa, "v4") == 0 ? 2 : strcmp(isa, "v3") == 0 ? 1 : 0;
	model->kernel = kernels[k];
	model->packed = model->params.path == RVE_SERIAL ? NULL : packed[k][model->params.path == RVE_SIMD_SINGLE];
}

int rve_model_create(struct rve_model **model, const struct rve_params *params, int n,
					 const struct rve_packing *const *packings)
{
	*model = NULL;
	CHECK(rve_params_check(params));
	*model = calloc(1, sizeof **model);
	if (!*model)
		return error_set(STATUS_RESOURCE, "out of memory for the RVE model");
	(*model)->params = *params;
	(*model)->n_threads = omp_get_max_threads() > omp_get_num_procs() ? omp_get_max_threads() : omp_get_num_procs();
	choose_kernels(*model);
	int status = model_fill(*model, params, n, packings);
	if (status != STATUS_OK) {
		rve_model_free(*model);
		*model = NULL;
	}
	return status;
}

void rve_model_free(struct rve_model *model)
{
	if (!model)
		return;
	for (int v = 0; v < model->n_variants; v++) {
		free(model->variants[v].table);
		free(model->variants[v].packed_table);
		free(model->variants[v].serial_start);
		free(model->variants[v].start);
	}
	free(model->variants);
	free(model->scratch);
	free(model);
}

unsigned char *rve_scratch(const struct rve_model *model, int thread)
{
	return model->scratch + model->scratch_stride * (size_t)thread;
}

size_t rve_state_bytes(const struct rve_model *model) { return (size_t)model->layout.bytes; }
int rve_discs(const struct rve_model *model) { return model->layout.n; }
int rve_variants(const struct rve_model *model) { return model->n_variants; }
const char *rve_path(const struct rve_model *model) { return rve_path_name(model->params.path); }
double rve_void_ratio(const struct rve_model *model, int variant) { return model->variants[variant].void_ratio; }
double rve_time_step(const struct rve_model *model) { return model->constants.dt; }

int rve_init(const struct rve_model *model, int variant, void *state)
{
	if (variant < 0 || variant >= model->n_variants)
		return error_set(STATUS_INPUT, "RVE variant %d: there are %d", variant, model->n_variants);
	memcpy(state, model->variants[variant].start, (size_t)model->layout.bytes);
	return STATUS_OK;
}

/* ---- one RVE through one call ---- */

enum rve_kernel_status rve_sub_steps(const struct rve_model *model, void *state, unsigned char *scratch,
									 const struct rve_motion *motion, int sub_steps, int rebuild)
{
	const struct rve_variant *variant = &model->variants[head_of(state)->variant];
	const struct rve_call call = call_of(motion, sub_steps, rebuild);
	int status = KERNEL_OK;
	if (model->packed)
		model->packed(&model->layout, &model->constants, &call, variant->packed_table, state, motion->ahead, scratch,
					  &status);
	else
		model->kernel(&model->serial, &model->constants, &call, variant->table, state, scratch, &status);
	return (enum rve_kernel_status)status;
}

static double pressure_of(const struct rve_head *head) { return -0.5 * (head->stress[0] + head->stress[1]); }

/* What the discs press each other with, Pa.  Where bonds pull, a pressure of zero or less does not say it. */
double rve_stress_scale(const struct rve_head *head)
{
	return head->bonds_intact > 0 ? fmax(fmax(fabs(head->stress[0]), fabs(head->stress[1])), fabs(head->stress[3]))
								  : pressure_of(head);
}

static int stressless(const struct rve_model *model, const struct rve_head *head)
{
	return rve_stress_scale(head) < model->params.gas_pressure;
}

static double stored_energy(const struct rve_head *head)
{
	return head->ledger[LEDGER_ELASTIC] + head->ledger[LEDGER_KINETIC];
}

static double principal_rate(const double L[4])
{
	double mean = 0.5 * (L[0] + L[3]), half = 0.5 * (L[0] - L[3]), shear = 0.5 * (L[1] + L[2]);
	return fabs(mean) + sqrt(half * half + shear * shear);
}

static void count_inertia(const struct rve_model *model, struct rve_head *head, double strain_per_step)
{
	static const double bounds[RVE_INERTIA_BINS - 1] = {1e-6, 3.1622776601683795e-6, 1e-5, 3.1622776601683795e-5,
														1e-4, 3.1622776601683795e-4, 1e-3, 3.1622776601683795e-3,
														1e-2, 3.1622776601683795e-2, 1e-1};
	double pressure = fmax(rve_stress_scale(head), 1.0); /* Pa; a cell without stress counts as 1 Pa */
	head->inertial_number = pace_inertia(model, strain_per_step, pressure);
	int bin = 0;
	while (bin < RVE_INERTIA_BINS - 1 && head->inertial_number >= bounds[bin])
		bin++;
	head->inertia[bin]++;
}

/* The stored energy leaves the books with a state that is put aside; no stress, no conduction. */
static void gas_enter(struct rve_head *head)
{
	head->flags |= RVE_GAS;
	head->gap = 0.0;
	head->ledger[LEDGER_DISCARDED] += stored_energy(head);
	head->ledger[LEDGER_ELASTIC] = head->ledger[LEDGER_KINETIC] = 0.0;
	memset(head->stress, 0, sizeof head->stress);
	memset(head->conductivity, 0, sizeof head->conductivity);
	memset(head->tensor, 0, sizeof head->tensor);
	head->modulus = head->contacts = head->sliding = head->inertial_number = head->max_overlap = 0.0;
	head->sub_steps = 0;
}

/* The share of a call's strain that is left once the gap has closed; 0 while it stays open. */
static double gas_share(struct rve_head *head, double volumetric)
{
	head->gap += volumetric;
	return head->gap > 0.0 ? 0.0 : fmin(1.0, head->gap / volumetric);
}

static void gas_leave(const struct rve_model *model, void *state, unsigned char *scratch)
{
	struct rve_head *head = head_of(state);
	head->flags &= ~RVE_GAS;
	head->gap = 0.0;
	rve_sub_steps(model, state, scratch, &rest, 0, 0);
	head->ledger[LEDGER_DISCARDED] -= stored_energy(head);
}

/* A cell that can be deformed no further, or has been pulled apart, gives way to the start packing at the same volume.
 * Its bonds are gone with it. */
static int reseed(const struct rve_model *model, void *state, unsigned char *scratch)
{
	const struct rve_layout *layout = &model->layout;
	struct rve_head kept = *head_of(state), *head = head_of(state);
	memcpy(state, model->variants[kept.variant].start, (size_t)layout->bytes);
	double stretch = sqrt(mat2_determinant(kept.F));
	for (int k = 0; k < 4; k++) {
		head->H[k] *= stretch;
		head->F[k] = kept.F[k];
	}
	memset((unsigned char *)state + layout->ft, 0,
		   (layout->single ? sizeof(real32) : sizeof(real)) * (size_t)layout->pairs);
	head->temperature = kept.temperature;
	memcpy(head->ledger, kept.ledger, sizeof head->ledger);
	memcpy(head->inertia, kept.inertia, sizeof head->inertia);
	head->total_sub_steps = kept.total_sub_steps;
	head->rebuilds = kept.rebuilds, head->clamped = kept.clamped, head->reseeded = kept.reseeded + 1;
	head->bonds_installed = kept.bonds_installed;
	head->quiet_calls = kept.quiet_calls, head->quiet_caught = kept.quiet_caught;
	head->quiet_error_sum = kept.quiet_error_sum, head->quiet_error_most = kept.quiet_error_most;
	head->paced_calls = kept.paced_calls, head->paced_saved = kept.paced_saved;
	head->paced_error_sum = kept.paced_error_sum, head->paced_error_most = kept.paced_error_most;
	int status = rve_sub_steps(model, state, scratch, &rest, 0, 1);
	head->ledger[LEDGER_DISCARDED] += stored_energy(&kept) - stored_energy(head);
	return status;
}

static void rotate_tensor(double *xx, double *yy, double *xy, const double R[4])
{
	double a = *xx, b = *yy, c = *xy;
	double px = R[0] * a + R[1] * c, py = R[0] * c + R[1] * b, qx = R[2] * a + R[3] * c, qy = R[2] * c + R[3] * b;
	*xx = px * R[0] + py * R[1];
	*yy = qx * R[2] + qy * R[3];
	*xy = px * R[2] + py * R[3];
}

/* A frozen cell only turns; what its stress works on the strain is discarded. */
static void frozen_advance(const struct rve_model *model, void *state, const struct rve_motion *motion)
{
	struct rve_head *head = head_of(state);
	const double *L = motion->L, dt = motion->duration;
	double spin = 0.5 * (L[1] - L[2]) * dt, rotation[4] = {0.0, spin, -spin, 0.0}, R[4];
	mat2_exp(rotation, R);
	mat2_multiply(R, head->H, head->H);
	mat2_multiply(R, head->H_ref, head->H_ref);
	rve_rotate_velocities(&model->layout, state, R);
	rotate_tensor(&head->stress[0], &head->stress[1], &head->stress[3], R);
	rotate_tensor(&head->contact_sum[0], &head->contact_sum[1], &head->contact_sum[2], R);
	rotate_tensor(&head->conductivity[0], &head->conductivity[1], &head->conductivity[2], R);
	double volume = mat2_determinant(head->F) * model->variants[head->variant].volume;
	double power = head->stress[0] * L[0] + head->stress[1] * L[3] + head->stress[3] * (L[1] + L[2]);
	head->ledger[LEDGER_WORK] += power * volume * dt;
	head->ledger[LEDGER_DISCARDED] += power * volume * dt;
	head->gap += (L[0] + L[3]) * dt;
	head->temperature += motion->dT;
	rve_melt_bonds(model, state, motion->T);
	head->sub_steps = 0;
}

/* The cell cannot follow this call: a fresh one if it carries nothing, else it stays as it was before. */
static int slender(const struct rve_model *model, void *state, unsigned char *scratch, const struct rve_motion *motion)
{
	struct rve_head *head = head_of(state);
	if (stressless(model, head) && mat2_determinant(head->F) >= 1.0) {
		head->temperature += motion->dT;
		return reseed(model, state, scratch);
	}
	head->flags |= RVE_FROZEN;
	head->gap = 0.0;
	frozen_advance(model, state, motion);
	return KERNEL_OK;
}

/* Whether the cell may become too slender within `strain`: its state must be kept then. */
static int nearly_slender(const struct rve_model *model, const struct rve_head *head, double strain)
{
	const double *H = head->H;
	double longest = sqrt(fmax(H[0] * H[0] + H[2] * H[2], H[1] * H[1] + H[3] * H[3]));
	double reach =
		2.0 * model->constants.r_max * (1.0 + model->constants.expansion * head->temperature) + model->constants.skin;
	return mat2_determinant(H) / longest < 3.0 * reach * exp(2.0 * strain);
}

/* The kinetic energy is centred between two half steps, sum m v_before v_after / 2: where it is negative the discs turn
 * about in every step, which only an unstable step does.  At this share of the elastic energy the pressure is still
 * right within 1e-3; a collision as a whole, with all motion in one phase, stays below it by w^2 dt^2/4. */
static const double jitter_most = 3e-3;

static struct rve_outcome check_state(const struct rve_model *model, const struct rve_head *head)
{
	double sum = head->stress[0] + head->stress[1] + head->stress[3];
	if (!isfinite(sum))
		return (struct rve_outcome){OUTCOME_NAN, sum};
	if (head->max_overlap > model->params.overlap_max)
		return (struct rve_outcome){OUTCOME_OVERLAP, head->max_overlap};
	double kinetic = head->ledger[LEDGER_KINETIC], elastic = head->ledger[LEDGER_ELASTIC];
	if (model->params.step_guard && kinetic < -jitter_most * elastic)
		return (struct rve_outcome){OUTCOME_JITTER, -kinetic / elastic};
	return (struct rve_outcome){OUTCOME_OK, 0.0};
}

/* The kernel left the lists half new: nothing may go on from here. */
static struct rve_outcome spoilt(struct rve_head *head)
{
	for (int k = 0; k < 4; k++)
		head->stress[k] = NAN;
	return (struct rve_outcome){OUTCOME_CROWDED, head->max_overlap};
}

/* What becomes of an RVE that the kernel has advanced. */
static struct rve_outcome settle(const struct rve_model *model, struct rve_head *head, int status)
{
	if (status != KERNEL_OK)
		return spoilt(head);
	double stretch = mat2_determinant(head->H) * model->params.thickness / model->variants[head->variant].volume;
	if (model->params.gas && !(head->flags & RVE_FROZEN) && stressless(model, head) &&
		stretch > model->params.gas_stretch)
		gas_enter(head);
	return check_state(model, head);
}

static const double strain_most = 1.0; /* in one call: far beyond what any time step should bring */

static int motion_is_finite(const struct rve_motion *motion)
{
	const double *L = motion->L;
	return isfinite(principal_rate(L) * motion->duration) && isfinite(L[1] - L[2]) && isfinite(motion->dT) &&
		   isfinite(motion->T);
}

/* Radii that grow strain the contacts too. */
static double motion_strain(const struct rve_model *model, const struct rve_motion *motion)
{
	return fmax(principal_rate(motion->L) * motion->duration, fabs(model->params.expansion * motion->dT));
}

static int plan_sub_steps(const struct rve_model *model, struct rve_head *head, const struct rve_motion *motion)
{
	int sub_steps = pace_sub_steps(model, head, motion_strain(model, motion));
	count_inertia(model, head, principal_rate(motion->L) * motion->duration / sub_steps);
	return sub_steps;
}

struct rve_outcome rve_advance_one(const struct rve_model *model, void *state, unsigned char *scratch,
									  struct rve_motion motion)
{
	struct rve_head *head = head_of(state);
	struct quiet_debt debt = {0};
	const struct rve_motion whole = motion; /* the call, as far as it is not taken apart below */
	const double *L = whole.L, dT = whole.dT, dt = whole.duration;
	double volumetric = (L[0] + L[3]) * dt, rate = principal_rate(L);
	double increment[4] = {L[0] * dt, L[1] * dt, L[2] * dt, L[3] * dt}, move[4];
	if (!motion_is_finite(&motion))
		return (struct rve_outcome){OUTCOME_RATE, rate};
	mat2_exp(increment, move);
	mat2_multiply(move, head->F, head->F);
	if (head->flags & RVE_FROZEN) {
		frozen_advance(model, state, &motion);
		if (head->gap > log(model->params.gas_stretch) && reseed(model, state, scratch) != KERNEL_OK)
			return spoilt(head);
		return check_state(model, head);
	}
	if (head->flags & RVE_GAS) {
		double share = gas_share(head, volumetric);
		if (share == 0.0) {
			head->temperature += dT;
			rve_melt_bonds(model, state, motion.T);
			return (struct rve_outcome){OUTCOME_OK, 0.0};
		}
		motion.duration = share * dt;
		gas_leave(model, state, scratch);
	} else if (quiet_hold(model, head, &motion, &debt))
		return check_state(model, head);
	double strain = motion_strain(model, &motion);
	if (strain > strain_most)
		return (struct rve_outcome){OUTCOME_STRAIN, strain};
	int sub_steps = plan_sub_steps(model, head, &motion);
	unsigned char *kept = scratch + model->kept;
	int keep = nearly_slender(model, head, strain);
	if (keep)
		memcpy(kept, state, (size_t)model->layout.bytes);
	int status = rve_sub_steps(model, state, scratch, &motion, sub_steps, 0);
	if (status == KERNEL_SLENDER && keep) {
		memcpy(state, kept, (size_t)model->layout.bytes);
		quiet_forget(head);
		status = slender(model, state, scratch, &whole);
	} else
		quiet_settle(model, head, &debt);
	return settle(model, head, status);
}

/* ---- the same where the kernel runs elsewhere ---- */

int rve_is_plain(const struct rve_model *model, const struct rve_head *head, const struct rve_motion *motion)
{
	double strain = motion_strain(model, motion);
	return motion_is_finite(motion) && head->flags == 0 && strain <= strain_most && !nearly_slender(model, head, strain);
}

struct rve_call rve_begin(const struct rve_model *model, struct rve_head *head, const struct rve_motion *motion)
{
	const double *L = motion->L, dt = motion->duration;
	double increment[4] = {L[0] * dt, L[1] * dt, L[2] * dt, L[3] * dt}, move[4];
	mat2_exp(increment, move);
	mat2_multiply(move, head->F, head->F);
	return call_of(motion, plan_sub_steps(model, head, motion), 0);
}

struct rve_outcome rve_end(const struct rve_model *model, struct rve_head *head, int status)
{
	return settle(model, head, status);
}

int rve_report_failure(const struct rve_params *params, int k, struct rve_outcome outcome)
{
	switch (outcome.kind) {
	case OUTCOME_OVERLAP:
		return error_set(
			STATUS_GUARD,
			"RVE %d: discs overlap by %.3g of the smaller radius, limit %g: the material is squeezed "
			"beyond what the contacts describe; a smaller time step, a smaller strain_per_step, a larger n_max or "
			"stiffer contacts help",
			k, outcome.value, params->overlap_max);
	case OUTCOME_RATE:
		return error_set(
			STATUS_GUARD,
			"RVE %d: the velocity gradient or the heating is not finite (%g 1/s): the motion around it has "
			"become unstable; a smaller time step helps",
			k, outcome.value);
	case OUTCOME_STRAIN:
		return error_set(STATUS_GUARD,
						 "RVE %d: strained by %.3g in one step, at most 1 makes sense: the motion around it has become "
						 "unstable; a smaller time step helps",
						 k, outcome.value);
	case OUTCOME_JITTER:
		return error_set(
			STATUS_GUARD,
			"RVE %d: its discs turn about in every DEM step (kinetic energy between the steps -%.2g of the "
			"elastic energy): the step is unstable; a smaller step_factor (now %g) helps",
			k, outcome.value, params->step_factor);
	case OUTCOME_CROWDED:
		return error_set(
			STATUS_GUARD,
			"RVE %d: more neighbours than discs side by side can have (overlap %.3g of the smaller radius): "
			"a smaller time step or a smaller strain_per_step helps",
			k, outcome.value);
	default:
		return error_set(STATUS_GUARD,
						 "RVE %d: the stress is not a number: the discs' motion has become unstable; a smaller "
						 "step_factor (now %g, at most about 0.5) helps",
						 k, params->step_factor);
	}
}

struct rve_motion rve_batch_motion(const struct rve_batch *batch, int k)
{
	const double *L = batch->L[k];
	return (struct rve_motion){
		.L = {L[0], L[1], L[2], L[3]}, .dT = batch->dT[k], .T = batch->T ? batch->T[k] : 0.0, .duration = batch->dt};
}

static unsigned char *batch_state(const struct rve_model *model, const struct rve_batch *batch, int k)
{
	return batch->states + (size_t)(batch->slot ? batch->slot[k] : k) * (size_t)model->layout.bytes;
}

void rve_answer(const struct rve_model *model, struct rve_batch *batch, int k, const struct rve_head *head,
				double friction)
{
	double volume = mat2_determinant(head->H) * model->params.thickness;
	batch->heat[k] = batch->dt > 0.0 ? (head->ledger[LEDGER_FRICTION] - friction) / (volume * batch->dt) : 0.0;
	memcpy(batch->stress[k], head->stress, sizeof head->stress);
	memcpy(batch->conductivity[k], head->conductivity, sizeof head->conductivity);
	batch->modulus[k] = head->modulus;
}

int rve_advance(const struct rve_model *model, struct rve_batch *batch)
{
	if (batch->pool)
		return rve_pool_advance(batch->pool, batch);
	struct rve_outcome worst = {OUTCOME_OK, 0.0};
	int threads = omp_get_max_threads() < model->n_threads ? omp_get_max_threads() : model->n_threads;
	threads = threads < batch->n ? threads : batch->n > 0 ? batch->n : 1; /* no team for a single RVE */
	batch->failed = -1;
	/* a few at a time, so that a thread knows what comes next; as many chunks as keep the threads even */
	const int chunk = batch->n / (16 * threads) > 8 ? 8 : batch->n / (16 * threads) + 1;
#pragma omp parallel for schedule(dynamic, chunk) num_threads(threads)
	for (int k = 0; k < batch->n; k++) {
		unsigned char *state = batch_state(model, batch, k);
		const struct rve_head *head = head_of(state);
		double friction = head->ledger[LEDGER_FRICTION];
		struct rve_motion motion = rve_batch_motion(batch, k);
		motion.ahead = k + 1 < batch->n && (k + 1) % chunk != 0 ? batch_state(model, batch, k + 1) : NULL;
		struct rve_outcome outcome = rve_advance_one(model, state, rve_scratch(model, omp_get_thread_num()), motion);
		rve_answer(model, batch, k, head, friction);
		if (outcome.kind != OUTCOME_OK) {
#pragma omp critical(rve_failure)
			if (batch->failed < 0 || k < batch->failed) {
				batch->failed = k;
				worst = outcome;
			}
		}
	}
	if (batch->failed < 0)
		return STATUS_OK;
	return rve_report_failure(&model->params, batch->number ? batch->number[batch->failed] : batch->failed, worst);
}

void rve_evaluate(const struct rve_model *model, const void *state, double stress[4], double conductivity[3],
				  double *modulus)
{
	(void)model;
	const struct rve_head *head = head_of(state);
	memcpy(stress, head->stress, sizeof head->stress);
	memcpy(conductivity, head->conductivity, sizeof head->conductivity);
	*modulus = head->modulus;
}

double rve_peak(int rounds, double *sum)
{
#ifdef RVE_KERNEL_X86
	const char *isa = rve_isa();
	if (strcmp(isa, "base") != 0)
		return strcmp(isa, "v4") == 0 ? rve_peak64_v4(rounds, sum) : rve_peak64_v3(rounds, sum);
#endif
	return rve_peak64_base(rounds, sum);
}

/* ---- what a state says of itself ---- */

void rve_get_info(const struct rve_model *model, const void *state, struct rve_info *info)
{
	const struct rve_head *head = head_of(state);
	const struct rve_variant *variant = &model->variants[head->variant];
	double temperature = head->temperature + head->held.heating;
	double scale = 1.0 + model->params.expansion * temperature;
	memset(info, 0, sizeof *info);
	memcpy(info->H, head->H, sizeof info->H);
	memcpy(info->F, head->F, sizeof info->F);
	info->volume0 = variant->volume;
	info->volume = head->flags & (RVE_GAS | RVE_FROZEN) || head->held.calls > 0 ? mat2_determinant(head->F) * variant->volume
														: mat2_determinant(head->H) * model->params.thickness;
	info->temperature = temperature;
	info->void_ratio = info->volume / model->params.thickness / (variant->solid_area * scale * scale) - 1.0;
	info->coordination = 2.0 * head->contacts / model->layout.n;
	info->sliding_fraction = head->contacts > 0.0 ? head->sliding / head->contacts : 0.0;
	info->bonds_installed = head->bonds_installed, info->bonds_intact = head->bonds_intact;
	info->bond_fraction = head->bonds_installed > 0 ? (double)head->bonds_intact / head->bonds_installed : 0.0;
	info->pressure = pressure_of(head);
	info->max_overlap = head->max_overlap;
	memcpy(info->elastic_tensor, head->tensor, sizeof info->elastic_tensor);
	info->n_contacts = (int)head->contacts;
	info->sub_steps = head->sub_steps;
	info->inertial_number = head->inertial_number;
	info->flags = head->flags;
	info->variant = head->variant;
	info->reseeded = head->reseeded, info->rebuilds = head->rebuilds, info->clamped = head->clamped;
	info->total_sub_steps = head->total_sub_steps;
	info->unbalanced = head->unbalanced;
	info->quiet_calls = head->quiet_calls, info->quiet_caught = head->quiet_caught;
	info->quiet_waiting = head->held.calls;
	info->quiet_error_sum = head->quiet_error_sum, info->quiet_error_most = head->quiet_error_most;
	info->paced_calls = head->paced_calls, info->paced_saved = head->paced_saved;
	info->paced_error_sum = head->paced_error_sum, info->paced_error_most = head->paced_error_most;
	for (int bin = 0; bin < RVE_INERTIA_BINS; bin++)
		info->inertia[bin] = head->inertia[bin];
	info->work = head->ledger[LEDGER_WORK];
	info->elastic = head->ledger[LEDGER_ELASTIC];
	info->kinetic = head->ledger[LEDGER_KINETIC];
	info->friction = head->ledger[LEDGER_FRICTION];
	info->dashpot = head->ledger[LEDGER_DASHPOT];
	info->bond = head->ledger[LEDGER_BOND];
	info->expansion = head->ledger[LEDGER_EXPANSION];
	info->discarded = head->ledger[LEDGER_DISCARDED];
}

void rve_reset_ledger(const struct rve_model *model, void *state)
{
	(void)model;
	struct rve_head *head = head_of(state);
	double elastic = head->ledger[LEDGER_ELASTIC], kinetic = head->ledger[LEDGER_KINETIC];
	memset(head->ledger, 0, sizeof head->ledger);
	head->ledger[LEDGER_ELASTIC] = elastic;
	head->ledger[LEDGER_KINETIC] = kinetic;
	head->ledger[LEDGER_WORK] = elastic + kinetic;
}
