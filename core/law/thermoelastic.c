/* Isotropic thermoelasticity in the logarithmic (Hencky) strain.
 *
 * h = ln V = 1/2 ln(F F^T); Kirchhoff stress tau = lambda tr(h) I + 2 mu h - (3 lambda + 2 mu) alpha dT I; the
 * Cauchy stress is tau / det F.  It is a function of F and T alone: exactly objective, without drift, with a stored
 * energy in closed form; at small strain it is linear thermoelasticity.  The rank-one convexity of this energy ends at
 * principal stretches of about 0.21 and 1.39 (Bruhns, Xiao, Meyers 2001), which is the law's domain of validity.
 *
 * Plane strain by default.  In plane stress lambda is 2 lambda mu / (lambda + 2 mu), and the stress is that per initial
 * thickness: the grid knows the area of a point, not how thick it has become. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "base/mat2.h"
#include "law/law.h"

struct model {
	double lambda, mu;   /* Pa, in the plane */
	double lambda_zz;    /* Pa, sigma_zz by tr(h): lambda, or 0 in plane stress */
	double thermal;      /* Pa/K, in the plane */
	double thermal_zz;   /* Pa/K, out of it */
	double expansion;    /* 1/K */
	double expansion_zz; /* 1/K of elastic strain out of the plane: -alpha where it is held, 0 where it is free */
	double lambda_3d;    /* Pa */
	double modulus;      /* Pa, P-wave at rest */
};

struct state {
	double warming;   /* K since birth */
	double pressure;  /* Pa, tr(tau) of the last step: works on thermal expansion */
	double elastic;   /* J/m3 */
	double expansion; /* J/m3 */
};

static struct state *state_of(const struct law *law, int slot) { return (struct state *)law->states + slot; }

static int thermoelastic_create(struct law *law, const struct scene_law *scene, int n_points, const int *variant)
{
	(void)variant;
	const struct scene_law_thermoelastic *s = &scene->thermoelastic;
	struct model *m = calloc(1, sizeof *m);
	law->model = m;
	law->state_bytes = sizeof(struct state);
	size_t bytes = ((size_t)n_points * sizeof(struct state) + 63) / 64 * 64 + 64;
	law->states = aligned_alloc(64, bytes);
	if (!m || !law->states)
		return error_set(STATUS_RESOURCE, "out of memory for %d points of law '%s'", n_points, law->name);
	memset(law->states, 0, bytes);
	double lambda = s->young * s->poisson / ((1.0 + s->poisson) * (1.0 - 2.0 * s->poisson));
	m->mu = s->young / (2.0 * (1.0 + s->poisson));
	m->lambda_3d = lambda;
	m->expansion = s->expansion;
	double thermal = (3.0 * lambda + 2.0 * m->mu) * s->expansion;
	if (s->plane_stress) {
		m->lambda = 2.0 * lambda * m->mu / (lambda + 2.0 * m->mu);
		m->thermal = thermal * 2.0 * m->mu / (lambda + 2.0 * m->mu);
	} else {
		m->lambda = m->lambda_zz = lambda;
		m->thermal = m->thermal_zz = thermal;
		m->expansion_zz = -s->expansion;
	}
	m->modulus = m->lambda + 2.0 * m->mu;
	law->coupling = fabs(m->lambda) / m->modulus;
	return STATUS_OK;
}

static void thermoelastic_destroy(struct law *law)
{
	free(law->model);
	free(law->states);
}

/* atanh(q)/q as a function of q^2 < 1; the series to round-off where it is short. */
static inline double atanh_ratio(double q2)
{
	if (q2 < 1e-3)
		return 1.0 + q2 * (1.0 / 3 + q2 * (1.0 / 5 + q2 * (1.0 / 7 + q2 * (1.0 / 9 + q2 * (1.0 / 11)))));
	double q = sqrt(q2);
	return 0.5 * log((1.0 + q) / (1.0 - q)) / q;
}

/* ln V = 1/2 ln b of a deformation gradient: (xx, yy, xy) and its trace ln J.  With b = m I + d, d^2 = r^2 I:
 * ln b = ln(J^2)/2 I + atanh(r/m)/r d; and ln J = 2 atanh((J - 1)/(J + 1)). */
static inline void log_left_stretch(const double F[4], double J, double h[3], double *trace)
{
	double bxx = F[0] * F[0] + F[1] * F[1], byy = F[2] * F[2] + F[3] * F[3], bxy = F[0] * F[2] + F[1] * F[3];
	double m = 0.5 * (bxx + byy), d = 0.5 * (bxx - byy), im = 1.0 / m;
	double k = 0.5 * im * atanh_ratio((d * d + bxy * bxy) * im * im);
	double z = (J - 1.0) / (J + 1.0), ln_j = 2.0 * z * atanh_ratio(z * z);
	h[0] = 0.5 * ln_j + k * d;
	h[1] = 0.5 * ln_j - k * d;
	h[2] = k * bxy;
	*trace = ln_j;
}

/* Stress, modulus and stored energy of one point; returns tr(tau), or NAN if the point is turned inside out. */
static inline double respond(const struct model *m, const double F[4], double warming, double stress[4],
							 double *modulus, double *elastic)
{
	double J = mat2_determinant(F), h[3], trace, ij = 1.0 / J;
	if (!(J > 0.0))
		return NAN;
	log_left_stretch(F, J, h, &trace);
	double iso = m->lambda * trace - m->thermal * warming;
	double xx = iso + 2.0 * m->mu * h[0], yy = iso + 2.0 * m->mu * h[1], xy = 2.0 * m->mu * h[2];
	double zz = m->lambda_zz * trace - m->thermal_zz * warming;
	stress[0] = xx * ij, stress[1] = yy * ij, stress[2] = zz * ij, stress[3] = xy * ij;
	/* compression stiffens: d tau/d ln V - tau bounds the acoustic tensor */
	double least = (xx < yy ? xx : yy) - fabs(xy);
	*modulus = (m->modulus - (least < 0.0 ? least : 0.0)) * ij;
	/* elastic strains e = h - alpha dT; out of the plane what plane strain holds back, or what makes zz vanish */
	double free_strain = m->expansion * warming, exx = h[0] - free_strain, eyy = h[1] - free_strain;
	double ezz = m->lambda_zz != 0.0 || m->thermal_zz != 0.0
					 ? m->expansion_zz * warming
					 : -m->lambda_3d / (m->lambda_3d + 2.0 * m->mu) * (exx + eyy);
	double e = exx + eyy + ezz;
	*elastic = 0.5 * m->lambda_3d * e * e + m->mu * (exx * exx + eyy * eyy + ezz * ezz + 2.0 * h[2] * h[2]);
	return xx + yy + zz;
}

static int inside_out(struct law_batch *batch, const struct law *law, int k)
{
	batch->failed = k;
	return error_set(
		STATUS_GUARD,
		"law '%s': the point is turned inside out, det F = %.3g; cure: a smaller time.step, or a finer grid", law->name,
		mat2_determinant(batch->F[k]));
}

static int run_batch(const struct law *law, struct law_batch *batch, double time)
{
	const struct model *m = law->model;
	int failed = batch->n;
#pragma omp parallel for schedule(static) reduction(min : failed) if (batch->n >= 4096)
	for (int k = 0; k < batch->n; k++) {
		struct state *s = state_of(law, batch->slot[k]);
		double warming = s->warming + (time > 0.0 ? batch->dT[k] : 0.0), elastic = 0.0;
		double pressure = respond(m, batch->F[k], warming, batch->stress[k], &batch->modulus[k], &elastic);
		batch->heat[k] = 0.0;
		batch->conductivity[k][0] = batch->conductivity[k][1] = batch->conductivity[k][2] = 0.0;
		if (isnan(pressure)) {
			failed = k < failed ? k : failed;
			continue;
		}
		/* of the free thermal strain, by the mean of the stresses before and after: exact along a straight path */
		s->expansion -= 0.5 * (s->pressure + pressure) * m->expansion * (warming - s->warming);
		s->warming = warming;
		s->pressure = pressure;
		s->elastic = elastic;
	}
	return failed < batch->n ? inside_out(batch, law, failed) : STATUS_OK;
}

static int thermoelastic_evaluate(const struct law *law, struct law_batch *batch) { return run_batch(law, batch, 0.0); }
static int thermoelastic_advance(struct law *law, struct law_batch *batch) { return run_batch(law, batch, batch->dt); }

static void thermoelastic_export(const struct law *law, int f, int n, const int *slot, double *out)
{
	(void)f;
	for (int k = 0; k < n; k++)
		out[k] = state_of(law, slot[k])->elastic;
}

static void thermoelastic_ledger(const struct law *law, int slot, struct law_ledger *ledger)
{
	const struct state *s = state_of(law, slot);
	*ledger = (struct law_ledger){.work = s->elastic - s->expansion, .elastic = s->elastic, .expansion = s->expansion};
}

static void thermoelastic_reset(struct law *law, int slot) { state_of(law, slot)->expansion = 0.0; }

static const struct field thermoelastic_fields[] = {
	{"energy_elastic", "J/m3", 1, "stored elastic energy, per initial volume"},
};

const struct law_type law_thermoelastic = {
	.name = "thermoelastic",
	.doc = "isotropic, linear between the logarithmic strain and the Kirchhoff stress, thermal expansion; plane strain "
		   "or plane stress",
	.cohesive = true,
	.fields = thermoelastic_fields,
	.n_fields = sizeof thermoelastic_fields / sizeof *thermoelastic_fields,
	.create = thermoelastic_create,
	.destroy = thermoelastic_destroy,
	.evaluate = thermoelastic_evaluate,
	.advance = thermoelastic_advance,
	.export_field = thermoelastic_export,
	.ledger = thermoelastic_ledger,
	.reset_ledger = thermoelastic_reset,
};
