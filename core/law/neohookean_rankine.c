/* A brittle solid: neo-Hookean thermoelasticity that breaks by Rankine's criterion (DP-MPM section 2).
 *
 * With b_iso = J^(-2/3) F F^T (plane strain: F_zz = 1) and the warming w from the reference temperature the free energy
 * per initial volume is
 *     psi = (1 - d) psi0,  psi0 = U + W - 3 alpha w U',  U = K/2 (ln J)^2,  W = G/2 (tr b_iso - 3),
 * and the Kirchhoff stress of the whole material
 *     tau0 = K ln J I + G dev(b_iso) - 3 alpha K w (1 - ln J)/J I;  tau = (1 - d) tau0.
 * R is the largest principal value of tau0/J that there has been, sigma_zz included, and at least the strength s:
 *     d = (1 + H)(1 - s/R) while R < s (1 + 1/H), then 1,  H = Hb l/(1 - Hb l),  Hb = s^2/(2 E Gf):
 * the stress of a bar falls in a straight line, and Gf per area is taken from a band of width l (Cervera and Chiumenti
 * 2006).  l is the diagonal of a cell; or, `projected`, the width that a cell's band of cracking points was found to
 * have across the direction in which its first point cracks (band_width()).
 *
 * Damage takes D = psi0 d' of the free energy, of which heat_share becomes heat.  With the absolute temperature T the
 * rest of the heat, - T times the rate of the entropy 3 alpha (1 - d) U', cools what is stretched and gives it back
 * where the stress is lost (He + Hin of the paper).
 *
 * unilateral: only the principal values of tau0 that pull are scaled.  That stress has no potential; psi0 is split
 * among its principal values by their squares, and what the ledger then misses is an error of this form. */
#include <math.h>

#include "base/error.h"
#include "base/mat2.h"
#include "law/law.h"
#include "law/series.h"

struct model {
	double K, G;     /* Pa */
	double coupling; /* 3 alpha, 1/K */
	double young;    /* Pa */
	double energy;   /* J/m2 */
	double cell;     /* m */
	double heat_share;
	bool unilateral, projected;
};

struct state {
	double warming;   /* K from the reference */
	double J;         /* det F of the last step */
	double strength;  /* Pa */
	double R;         /* Pa, at least the strength */
	double softening; /* H */
	double damage;
	double psi;       /* J/m3, of psi0 what damage takes */
	double entropy;   /* Pa/K, 3 alpha (1 - d) U' */
	double elastic;   /* J/m3: psi */
	double fracture;  /* J/m3, taken by damage so far */
	double expansion; /* J/m3, put in by thermal expansion so far */
	double began;     /* 1: damage has begun, the band's width is set */
};

static struct state *state_of(const struct law *law, int slot) { return (struct state *)law->states + slot; }

/* ---- the band ---- */

/* H of a band of width l; infinite where it would snap back. */
static double softening_of(const struct model *m, double strength, double l)
{
	double brittle = strength * strength * l / (2.0 * m->young * m->energy);
	return brittle < 1.0 ? brittle / (1.0 - brittle) : INFINITY;
}

/* Width of the band that a crack with normal (c, s) makes, m. */
static double band_width(const struct model *m, double c, double s)
{
	return m->projected ? m->cell * (fabs(c) + fabs(s)) : M_SQRT2 * m->cell;
}

/* ---- birth ---- */

/* A number in (0, 1) of its own for every point and seed (splitmix64). */
static double uniform(unsigned long long seed, unsigned long long k)
{
	unsigned long long z = (seed << 32) + k * 0x9e3779b97f4a7c15ULL + 0x9e3779b97f4a7c15ULL;
	z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
	z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
	z ^= z >> 31;
	return ((double)(z >> 11) + 0.5) / 9007199254740992.0;
}

/* Strength over its mean. */
static double scatter(const struct scene_law_rankine *s, int k)
{
	if (s->weibull == 0.0)
		return 1.0;
	return pow(-log(uniform(s->seed, (unsigned long long)k)), 1.0 / s->weibull) / tgamma(1.0 + 1.0 / s->weibull);
}

static int begin_states(struct law *law, const struct scene_law *scene)
{
	const struct scene_law_rankine *s = &scene->rankine;
	const struct model *m = law->model;
	for (int k = 0; k < law->n_points; k++) {
		struct state *state = state_of(law, k);
		*state = (struct state){.J = 1.0, .strength = s->strength * scatter(s, k)};
		state->R = state->strength;
		state->softening = softening_of(m, state->strength, M_SQRT2 * m->cell);
		if (!(state->softening < 10.0))
			return error_set(
				STATUS_INPUT,
				"%s:%d: law '%s': the scatter makes a point of strength %.4g Pa, which would snap back on "
				"cells of %g m, expected a larger weibull modulus, a larger fracture_energy or smaller cells",
				scene->place.file ? scene->place.file : "scene", scene->place.line, law->name, state->strength,
				m->cell);
	}
	return STATUS_OK;
}

static int rankine_create(struct law *law, const struct scene_law *scene, int n_points, const int *variant)
{
	(void)n_points, (void)variant;
	const struct scene_law_rankine *s = &scene->rankine;
	CHECK(law_allocate(law, sizeof(struct model), sizeof(struct state)));
	struct model *m = law->model;
	*m = (struct model){.K = s->young / (3.0 * (1.0 - 2.0 * s->poisson)),
						.G = s->young / (2.0 * (1.0 + s->poisson)),
						.coupling = 3.0 * s->expansion,
						.young = s->young,
						.energy = s->fracture_energy,
						.cell = s->cell,
						.heat_share = s->heat_share,
						.unilateral = s->unilateral,
						.projected = s->projected};
	law->coupling = fabs(m->K - 2.0 / 3.0 * m->G) / (m->K + 4.0 / 3.0 * m->G);
	return begin_states(law, scene);
}

/* ---- response ---- */

/* What the whole material would answer. */
struct whole {
	double xx, yy, zz, xy; /* Pa, tau0 */
	double mean, radius;   /* Pa, of its principal values in the plane */
	double psi;            /* J/m3 */
	double slope;          /* Pa, U' */
	double modulus;        /* Pa, per initial volume */
};

static inline struct whole respond(const struct model *m, const double F[4], double J, double warming)
{
	struct whole t;
	double ln_j = log_by_ratio(J), ij = 1.0 / J, iso = exp(-2.0 / 3.0 * ln_j);
	double bxx = iso * (F[0] * F[0] + F[1] * F[1]), byy = iso * (F[2] * F[2] + F[3] * F[3]);
	double bxy = iso * (F[0] * F[2] + F[1] * F[3]), trace = bxx + byy + iso, third = trace * (1.0 / 3.0);
	double heat = m->coupling * m->K * warming, volumetric = m->K * ln_j - heat * (1.0 - ln_j) * ij;
	t.xx = volumetric + m->G * (bxx - third), t.yy = volumetric + m->G * (byy - third);
	t.zz = volumetric + m->G * (iso - third), t.xy = m->G * bxy;
	double d = 0.5 * (t.xx - t.yy), half = 0.5 * (bxx - byy), b_radius = sqrt(half * half + bxy * bxy);
	t.mean = 0.5 * (t.xx + t.yy), t.radius = sqrt(d * d + t.xy * t.xy);
	t.slope = m->K * ln_j * ij;
	t.psi = 0.5 * m->K * ln_j * ln_j + 0.5 * m->G * (trace - 3.0) - m->coupling * warming * t.slope;
	/* acoustic tensor along the largest stretch or across it; second derivatives of U and W along a (x) n */
	double most = 0.5 * (bxx + byy) + b_radius, least = 0.5 * (bxx + byy) - b_radius;
	double along = 5.0 / 9.0 * trace - least * (1.0 / 3.0), bulk = m->K * (1.0 - ln_j) + 3.0 * fabs(heat);
	t.modulus = (bulk > 0.0 ? bulk : 0.0) + m->G * (along > most ? along : most);
	return t;
}

/* The damage of this step, and the band's width at its beginning. */
static inline void advance_damage(const struct model *m, struct state *s, const struct whole *t, double ij)
{
	double plane = t->mean + t->radius, most = (plane > t->zz ? plane : t->zz) * ij;
	if (most <= s->R)
		return;
	if (s->began == 0.0) {
		/* the normal of the crack, by half the angle of the largest principal stress */
		double c2 = t->radius > 0.0 ? 0.5 * (t->xx - t->yy) / t->radius : 1.0;
		s->began = 1.0;
		if (m->projected)
			s->softening = softening_of(
				m, s->strength, band_width(m, sqrt(0.5 * fmax(1.0 + c2, 0.0)), sqrt(0.5 * fmax(1.0 - c2, 0.0))));
	}
	s->R = most;
	double d =
		most < s->strength * (1.0 + 1.0 / s->softening) ? (1.0 + s->softening) * (1.0 - s->strength / most) : 1.0;
	if (d > s->damage)
		s->damage = d;
}

/* tau of the damaged material into stress[] (over J), all of it scaled. */
static inline void scale_all(const struct whole *t, double share, double stress[4])
{
	stress[0] = share * t->xx, stress[1] = share * t->yy, stress[2] = share * t->zz, stress[3] = share * t->xy;
}

/* Or only what pulls; returns the part of psi0 that damage takes. */
static inline double scale_tension(const struct whole *t, double ij, double damage, double stress[4])
{
	double first = t->mean + t->radius, second = t->mean - t->radius;
	double a = first > 0.0 ? 1.0 - damage : 1.0, b = second > 0.0 ? 1.0 - damage : 1.0;
	double mean = 0.5 * (a * first + b * second),
		   ratio = t->radius > 0.0 ? 0.5 * (a * first - b * second) / t->radius : 0.0;
	double d = 0.5 * (t->xx - t->yy);
	stress[0] = (mean + ratio * d) * ij, stress[1] = (mean - ratio * d) * ij;
	stress[2] = (t->zz > 0.0 ? 1.0 - damage : 1.0) * t->zz * ij, stress[3] = ratio * t->xy * ij;
	double pull = (first > 0.0 ? first * first : 0.0) + (second > 0.0 ? second * second : 0.0) +
				  (t->zz > 0.0 ? t->zz * t->zz : 0.0);
	double all = first * first + second * second + t->zz * t->zz;
	return all > 0.0 ? pull / all : 1.0;
}

/* One point; false if it is turned inside out.  dt = 0: nothing passes. */
static inline bool respond_point(const struct model *m, struct state *s, struct law_batch *batch, int k, double dt)
{
	double J = mat2_determinant(batch->F[k]), ij = 1.0 / J;
	if (!(J > 0.0))
		return false;
	double dT = dt > 0.0 ? batch->dT[k] : 0.0, warming = s->warming + dT, before = s->damage;
	struct whole t = respond(m, batch->F[k], J, warming);
	advance_damage(m, s, &t, ij);
	double share = 1.0;
	if (m->unilateral)
		share = scale_tension(&t, ij, s->damage, batch->stress[k]);
	else
		scale_all(&t, (1.0 - s->damage) * ij, batch->stress[k]);
	double psi = share * t.psi, entropy = m->coupling * (1.0 - share * s->damage) * t.slope;
	double taken = 0.5 * (s->psi + psi) * (s->damage - before);
	/* the mean of before and after: exact along a straight path */
	s->expansion -= 0.5 * (s->entropy + entropy) * dT;
	s->fracture += taken;
	batch->heat[k] =
		dt > 0.0 ? (m->heat_share * taken - (batch->T[k] - 0.5 * dT) * (entropy - s->entropy)) * ij / dt : 0.0;
	s->warming = warming, s->J = J, s->psi = psi, s->entropy = entropy;
	s->elastic = t.psi - s->damage * psi;
	/* a broken point still has to be held when it is pressed */
	batch->modulus[k] = (m->unilateral ? 1.0 : 1.0 - s->damage) * t.modulus * ij;
	batch->conductivity[k][0] = batch->conductivity[k][1] = batch->conductivity[k][2] = 0.0;
	if (batch->damage)
		batch->damage[k] = s->damage;
	return true;
}

static int run_batch(const struct law *law, struct law_batch *batch, double dt)
{
	const struct model *m = law->model;
	int failed = batch->n;
#pragma omp parallel for schedule(static) reduction(min : failed) if (batch->n >= 4096)
	for (int k = 0; k < batch->n; k++)
		if (!respond_point(m, state_of(law, batch->slot[k]), batch, k, dt))
			failed = k < failed ? k : failed;
	if (failed == batch->n)
		return STATUS_OK;
	batch->failed = failed;
	return error_set(
		STATUS_GUARD,
		"law '%s': the point is turned inside out, det F = %.3g; cure: a smaller time.step, or a finer grid", law->name,
		mat2_determinant(batch->F[failed]));
}

static int rankine_evaluate(const struct law *law, struct law_batch *batch) { return run_batch(law, batch, 0.0); }
static int rankine_advance(struct law *law, struct law_batch *batch) { return run_batch(law, batch, batch->dt); }

/* ---- what is shown ---- */

static const struct field rankine_fields[] = {
	{"damage", "-", 1, "0 whole, 1 broken"},
	{"damage_regular", "-", 1, "(exp(5 d) - 1)/(exp(5) - 1) of the damage d: shows what is nearly broken"},
	{"strength", "Pa", 1, "tensile strength"},
	{"energy_elastic", "J/m3", 1, "stored elastic energy, per initial volume"},
	{"energy_fracture", "J/m3", 1, "taken by damage, per initial volume"},
};

static void rankine_export(const struct law *law, int f, int n, const int *slot, double *out)
{
	for (int k = 0; k < n; k++) {
		const struct state *s = state_of(law, slot[k]);
		const double values[] = {s->damage, expm1(5.0 * s->damage) / expm1(5.0), s->strength, s->elastic, s->fracture};
		out[k] = values[f];
	}
}

static void rankine_ledger(const struct law *law, int slot, struct law_ledger *ledger)
{
	const struct state *s = state_of(law, slot);
	*ledger = (struct law_ledger){.work = s->elastic + s->fracture - s->expansion,
								  .elastic = s->elastic,
								  .fracture = s->fracture,
								  .expansion = s->expansion};
}

static void rankine_reset(struct law *law, int slot)
{
	state_of(law, slot)->expansion = state_of(law, slot)->fracture = 0.0;
}

const struct law_type law_neohookean_rankine = {
	.name = "neohookean_rankine",
	.doc = "a brittle solid: neo-Hookean thermoelasticity with Rankine damage, which heats and cools it (DP-MPM "
		   "section 2)",
	.breaks = true,
	.cohesive = true,
	.fields = rankine_fields,
	.n_fields = sizeof rankine_fields / sizeof *rankine_fields,
	.create = rankine_create,
	.destroy = law_release,
	.evaluate = rankine_evaluate,
	.advance = rankine_advance,
	.export_field = rankine_export,
	.ledger = rankine_ledger,
	.reset_ledger = rankine_reset,
};
