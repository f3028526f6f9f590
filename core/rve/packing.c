/* The generator of packings: random placement, servo-controlled isotropic compression, hold. */
#include "rve/packing.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "base/mat2.h"
#include "rve/model.h"

static const double pi = 3.14159265358979323846;

/* ---- random numbers: splitmix64, so that a seed means the same everywhere ---- */

static double random_unit(uint64_t *state)
{
	uint64_t z = *state += 0x9e3779b97f4a7c15u;
	z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
	z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
	return (double)((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

struct rve_packing *rve_packing_alloc(int discs, int contacts)
{
	struct rve_packing *packing = calloc(1, sizeof *packing);
	if (!packing)
		return NULL;
	packing->n_discs = discs;
	packing->n_contacts = contacts;
	packing->x = calloc((size_t)discs, sizeof *packing->x);
	packing->r = calloc((size_t)discs, sizeof *packing->r);
	packing->pair = calloc((size_t)contacts + 1, sizeof *packing->pair);
	packing->ft = calloc((size_t)contacts + 1, sizeof *packing->ft);
	if (packing->x && packing->r && packing->pair && packing->ft)
		return packing;
	rve_packing_free(packing);
	return NULL;
}

static int no_memory(void) { return error_set(STATUS_RESOURCE, "out of memory for a packing"); }

/* ---- the noise-free lattice ---- */

/* Contacts of force p l z carry the pressure p of a square lattice of spacing l = 2 r - f / kn. */
static int square_lattice(struct rve_packing **packing, const struct rve_packing_params *how,
						  const struct rve_params *grains)
{
	int side = (int)lround(sqrt((double)how->discs));
	if (side * side != how->discs)
		return error_set(STATUS_INPUT, "a square lattice of %d discs: expected a square number", how->discs);
	struct rve_packing *p = *packing = rve_packing_alloc(how->discs, 0);
	if (!p)
		return no_memory();
	double r = how->radius_max, spacing = 2.0 * r * grains->kn / (grains->kn + how->pressure * grains->thickness);
	p->H[0] = p->H[3] = side * spacing;
	for (int i = 0; i < how->discs; i++) {
		p->x[i][0] = (i % side + 0.5) * spacing;
		p->x[i][1] = (i / side + 0.5) * spacing;
		p->r[i] = r;
	}
	p->pressure = how->pressure;
	p->mu = how->mu;
	p->void_ratio = rve_packing_void_ratio(p);
	return STATUS_OK;
}

/* ---- random placement ---- */

static int larger_first(const void *a, const void *b)
{
	double x = *(const double *)a, y = *(const double *)b;
	return (x < y) - (x > y);
}

static int fits(const struct rve_packing *p, int i)
{
	for (int j = 0; j < i; j++) {
		double dx = p->x[i][0] - p->x[j][0], dy = p->x[i][1] - p->x[j][1], reach = p->r[i] + p->r[j];
		dx -= p->H[0] * rint(dx / p->H[0]);
		dy -= p->H[3] * rint(dy / p->H[3]);
		if (dx * dx + dy * dy < reach * reach)
			return 0;
	}
	return 1;
}

/* Discs thrown one after the other, largest first, into a square cell that they fill by half. */
static int place_at_random(struct rve_packing *p, const struct rve_packing_params *how)
{
	const double solid_fraction = 0.5;
	const long attempts_max = 100000;
	uint64_t random = how->seed;
	double area = 0.0;
	for (int i = 0; i < p->n_discs; i++) {
		p->r[i] = how->radius_min + (how->radius_max - how->radius_min) * random_unit(&random);
		area += pi * p->r[i] * p->r[i];
	}
	qsort(p->r, (size_t)p->n_discs, sizeof *p->r, larger_first);
	p->H[0] = p->H[3] = sqrt(area / solid_fraction);
	for (int i = 0; i < p->n_discs; i++) {
		long attempts = 0;
		do {
			if (attempts++ == attempts_max)
				return error_set(STATUS_INPUT,
								 "no room for disc %d of %d at a solid fraction of %g: wider radii or another seed", i,
								 p->n_discs, solid_fraction);
			p->x[i][0] = p->H[0] * random_unit(&random);
			p->x[i][1] = p->H[3] * random_unit(&random);
		} while (!fits(p, i));
	}
	return STATUS_OK;
}

/* ---- compression ---- */

static double limited(double x) { return fmax(-1.0, fmin(1.0, x)); }

/* The servo: a rate that grows with the error relative to the target, at most 1/s; sharper than that near the target,
 * where the cell is stiff and answers within a few turns. */
static double servo(double error) { return limited(2.0 * error); }

/* Strains the cell at up to 1/s in each component until the stress is -p I and the discs are at rest. */
static int compress(const struct rve_model *model, unsigned char *state, double pressure)
{
	const double rate = 1.0, stress_tolerance = 1e-3, unbalanced_tolerance = 1e-4;
	const long long sub_steps_max = 20000000;
	const double dt = rve_time_step(model);
	/* the servo's gain is 1/(p rate^-1): in one turn it must correct far less than the whole error */
	double stiffness = model->params.kn / model->params.thickness;
	int turn = (int)fmax(1.0, fmin(20.0, 0.02 * pressure / (stiffness * rate * dt)));
	double slow = fmin(1.0, 0.04 * pressure / (stiffness * rate * dt * turn));
	unsigned char *scratch = rve_scratch(model, 0);
	struct rve_info info;
	for (long long done = 0; done < sub_steps_max; done += turn) {
		double stress[4], conductivity[3], modulus;
		rve_evaluate(model, state, stress, conductivity, &modulus);
		double xx = (-pressure - stress[0]) / pressure, yy = (-pressure - stress[1]) / pressure,
			   xy = -stress[3] / pressure;
		double shear = slow * rate * servo(xy);
		const struct rve_motion motion = {.L = {slow * rate * servo(xx), shear, shear, slow * rate * servo(yy)},
										  .duration = turn * dt};
		if (rve_sub_steps(model, state, scratch, &motion, turn, 0) != KERNEL_OK)
			return error_set(STATUS_GUARD, "the packing collapsed during its compression");
		rve_get_info(model, state, &info);
		if (fabs(xx) < stress_tolerance && fabs(yy) < stress_tolerance && fabs(xy) < stress_tolerance &&
			info.n_contacts > 0 && info.unbalanced < unbalanced_tolerance)
			return STATUS_OK;
	}
	return error_set(STATUS_GUARD, "the packing did not come to rest at %g Pa (unbalanced force ratio %g)", pressure,
					 info.unbalanced);
}

/* The packing that a state is. */
static int packing_from_state(struct rve_packing **packing, const struct rve_model *model, const unsigned char *state)
{
	int discs = rve_discs(model), capacity = rve_contact_capacity(model);
	struct rve_disc *disc = malloc(sizeof *disc * (size_t)discs);
	struct rve_contact *contact = malloc(sizeof *contact * (size_t)capacity);
	struct rve_packing *p = *packing = rve_packing_alloc(discs, capacity);
	if (p && disc && contact) {
		struct rve_info info;
		rve_get_info(model, state, &info);
		memcpy(p->H, info.H, sizeof p->H);
		p->n_contacts = rve_inspect(model, state, disc, contact, capacity);
		for (int i = 0; i < discs; i++) {
			p->x[i][0] = disc[i].x;
			p->x[i][1] = disc[i].y;
			p->r[i] = disc[i].radius;
		}
		for (int c = 0; c < p->n_contacts; c++) {
			p->pair[c][0] = contact[c].i, p->pair[c][1] = contact[c].j;
			p->pair[c][2] = contact[c].shift[0], p->pair[c][3] = contact[c].shift[1];
			p->ft[c] = contact[c].tangential_force;
		}
		p->void_ratio = info.void_ratio;
		p->unbalanced = info.unbalanced;
	}
	int status = p && disc && contact ? STATUS_OK : no_memory();
	free(disc);
	free(contact);
	return status;
}

/* Steps that every seed shares: loose discs, a model of them, compression, the packing. */
static int compressed(struct rve_packing **packing, struct rve_packing *loose, const struct rve_params *grains,
					  double pressure)
{
	struct rve_model *model = NULL;
	const struct rve_packing *const packings[1] = {loose};
	CHECK(rve_model_create(&model, grains, 1, packings));
	unsigned char *state = aligned_alloc(64, rve_state_bytes(model));
	int status = state ? rve_init(model, 0, state) : no_memory();
	if (status == STATUS_OK)
		status = compress(model, state, pressure);
	if (status == STATUS_OK)
		status = packing_from_state(packing, model, state);
	free(state);
	rve_model_free(model);
	return status;
}

static int random_packing(struct rve_packing **packing, const struct rve_packing_params *how,
						  const struct rve_params *grains, double mu)
{
	struct rve_params consolidation = *grains;
	consolidation.path = RVE_SERIAL;
	consolidation.mu = mu;
	consolidation.damping_ratio = 0.2;
	struct rve_packing *loose = rve_packing_alloc(how->discs, 0);
	if (!loose)
		return no_memory();
	int status = place_at_random(loose, how);
	if (status == STATUS_OK)
		status = compressed(packing, loose, &consolidation, how->pressure);
	rve_packing_free(loose);
	if (status != STATUS_OK) {
		rve_packing_free(*packing);
		*packing = NULL;
		return status;
	}
	(*packing)->pressure = how->pressure;
	(*packing)->mu = mu;
	(*packing)->seed = how->seed;
	return STATUS_OK;
}

/* Friction keeps discs from sliding together: the void ratio grows with mu, with the scatter of one packing. */
static int packing_of_void_ratio(struct rve_packing **packing, const struct rve_packing_params *how,
								 const struct rve_params *grains)
{
	const double tolerance = 5e-4;
	double low = 0.0, high = 1.0, reached[2] = {INFINITY, -INFINITY};
	struct rve_packing *best = NULL;
	for (int turn = 0; turn < 14; turn++) {
		double mu = turn == 0 ? low : turn == 1 ? high : 0.5 * (low + high);
		struct rve_packing *p = NULL;
		int status = random_packing(&p, how, grains, mu);
		if (status != STATUS_OK) {
			rve_packing_free(best);
			return status;
		}
		reached[0] = fmin(reached[0], p->void_ratio), reached[1] = fmax(reached[1], p->void_ratio);
		if (p->void_ratio < how->void_ratio)
			low = mu;
		else
			high = mu;
		int better = !best || fabs(p->void_ratio - how->void_ratio) < fabs(best->void_ratio - how->void_ratio);
		rve_packing_free(better ? best : p);
		best = better ? p : best;
		if (fabs(best->void_ratio - how->void_ratio) < tolerance || (turn == 1 && (low == 1.0 || high == 0.0)))
			break;
	}
	*packing = best;
	if (fabs(best->void_ratio - how->void_ratio) < 10.0 * tolerance)
		return STATUS_OK;
	rve_packing_free(best);
	*packing = NULL;
	return error_set(
		STATUS_INPUT,
		"a void ratio of %g is out of reach at %g Pa with seed %u: friction between 0 and 1 gives %.4f to %.4f",
		how->void_ratio, how->pressure, how->seed, reached[0], reached[1]);
}

int rve_packing_generate(struct rve_packing **packing, const struct rve_packing_params *how,
						 const struct rve_params *grains)
{
	*packing = NULL;
	if (how->discs < 16 || !(how->radius_min > 0.0) || !(how->radius_max >= how->radius_min) || !(how->pressure > 0.0))
		return error_set(
			STATUS_INPUT,
			"a packing needs at least 16 discs, radii 0 < radius_min <= radius_max and a positive pressure");
	if (how->square_lattice)
		return square_lattice(packing, how, grains);
	if (!isnan(how->void_ratio))
		return packing_of_void_ratio(packing, how, grains);
	return random_packing(packing, how, grains, how->mu);
}

void rve_packing_free(struct rve_packing *packing)
{
	if (!packing)
		return;
	free(packing->x);
	free(packing->r);
	free(packing->pair);
	free(packing->ft);
	free(packing);
}

double rve_packing_void_ratio(const struct rve_packing *packing)
{
	double area = 0.0;
	for (int i = 0; i < packing->n_discs; i++)
		area += pi * packing->r[i] * packing->r[i];
	return mat2_determinant(packing->H) / area - 1.0;
}
