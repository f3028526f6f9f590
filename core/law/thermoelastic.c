/* Isotropic thermoelasticity at finite strain, in two kinds.
 *
 * The deformation gradient is F = Fe exp(alpha dT): what is not thermal expansion is elastic.  Both kinds are functions
 * of F and T alone, exactly objective, without drift, with a stored energy in closed form, and linear thermoelasticity
 * at small strain.  tau is the Kirchhoff stress; the Cauchy stress is tau / det F.
 *
 * hencky: in the logarithmic strain h = ln V = 1/2 ln(F F^T),
 *     tau = lambda tr(h) I + 2 mu h - (3 lambda + 2 mu) alpha dT I.
 * The rank-one convexity of its energy ends at principal stretches of 0.2116 and exp(1/3) = 1.3956 (Bruhns, Xiao,
 * Meyers 2001): beyond, a small disturbance grows without end, so a point that gets there stops the run.
 *
 * neo_hookean: compressible, with be = Fe Fe^T and Je = det Fe (Simo and Pister 1984),
 *     tau = mu (be - I) + lambda ln(Je) I,
 *     W = mu/2 (tr be - 3 - 2 ln Je) + lambda/2 (ln Je)^2.
 * Its acoustic tensor, mu (n.be n) I + (mu + lambda (1 - ln Je)) n (x) n per initial volume, stays positive up to at
 * least Je = exp(1 + mu/lambda); it is for large strain.
 *
 * Plane strain by default.  In plane stress (hencky only) lambda is 2 lambda mu / (lambda + 2 mu), and the stress is
 * that per initial thickness: the grid knows the area of a point, not how thick it has become. */
#include <math.h>

#include "base/error.h"
#include "base/mat2.h"
#include "law/kernel.h"
#include "law/series.h"
#include "law/thermoelastic.h"

static struct thermoelastic_state *state_of(const struct law *law, int slot)
{
	return (struct thermoelastic_state *)law->states + slot;
}

static int thermoelastic_create(struct law *law, const struct scene_law *scene, int n_points, const int *variant)
{
	(void)n_points, (void)variant;
	const struct scene_law_thermoelastic *s = &scene->thermoelastic;
	CHECK(law_allocate(law, sizeof(struct thermoelastic_model), sizeof(struct thermoelastic_state)));
	struct thermoelastic_model *m = law->model;
	double lambda = s->young * s->poisson / ((1.0 + s->poisson) * (1.0 - 2.0 * s->poisson));
	m->mu = s->young / (2.0 * (1.0 + s->poisson));
	m->lambda_3d = lambda;
	m->expansion = s->expansion;
	m->neo_hookean = s->neo_hookean;
	m->kernel = law_kernel_here();
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

/* ln V = 1/2 ln b of a deformation gradient: (xx, yy, xy) and its trace ln J.  With b = m I + d, d^2 = r^2 I:
 * ln b = ln(J^2)/2 I + atanh(r/m)/r d. */
static inline void log_left_stretch(const double F[4], double J, double h[3], double *trace)
{
	double bxx = F[0] * F[0] + F[1] * F[1], byy = F[2] * F[2] + F[3] * F[3], bxy = F[0] * F[2] + F[1] * F[3];
	double m = 0.5 * (bxx + byy), d = 0.5 * (bxx - byy), im = 1.0 / m;
	double k = 0.5 * im * atanh_ratio((d * d + bxy * bxy) * im * im);
	double ln_j = log_by_ratio(J);
	h[0] = 0.5 * ln_j + k * d;
	h[1] = 0.5 * ln_j - k * d;
	h[2] = k * bxy;
	*trace = ln_j;
}

/* z - ln(1 + z), also where it is small. */
static inline double log_excess(double z)
{
	if (fabs(z) < 1e-2)
		return z * z *
			   (1.0 / 2 - z * (1.0 / 3 - z * (1.0 / 4 - z * (1.0 / 5 - z * (1.0 / 6 - z * (1.0 / 7 - z / 8))))));
	return z - log1p(z);
}

/* Stress, modulus and stored energy of one neo-Hookean point; returns tr(tau), or NAN if the point is turned inside
 * out. With e = be - I, so that small strains keep their digits. */
static inline double neo_hookean_respond(const struct thermoelastic_model *m, const double F[4], double warming,
										 double stress[4], double *modulus, double *elastic)
{
	double J = mat2_determinant(F), ij = 1.0 / J, free_strain = m->expansion * warming;
	if (!(J > 0.0))
		return NAN;
	double cold = free_strain != 0.0 ? exp(-2.0 * free_strain) : 1.0, ezz = cold - 1.0;
	double exx = cold * (F[0] * F[0] + F[1] * F[1]) - 1.0, eyy = cold * (F[2] * F[2] + F[3] * F[3]) - 1.0;
	double exy = cold * (F[0] * F[2] + F[1] * F[3]), product = exx * eyy - exy * exy, grown = exx + eyy + product;
	double ln_j = 0.5 * log1p(grown) - free_strain, iso = m->lambda * ln_j;
	double xx = m->mu * exx + iso, yy = m->mu * eyy + iso, zz = m->mu * ezz + iso;
	stress[0] = xx * ij, stress[1] = yy * ij, stress[2] = zz * ij, stress[3] = m->mu * exy * ij;
	/* the fastest wave runs along the largest stretch; beyond exp(1 + mu/lambda) it is the shear wave */
	double d = 0.5 * (exx - eyy), most = m->mu * (1.0 + 0.5 * (exx + eyy) + sqrt(d * d + exy * exy));
	double along = m->mu + m->lambda * (1.0 - ln_j);
	*modulus = (most + (along > 0.0 ? along : 0.0)) * ij;
	*elastic = 0.5 * m->mu * (log_excess(grown) - product + log_excess(ezz)) + 0.5 * m->lambda * ln_j * ln_j;
	return xx + yy + zz;
}

/* Says why a point could not respond. */
static int left_domain(struct law_batch *batch, const struct law *law, int k)
{
	double e[3], J = mat2_determinant(batch->F[k]);
	batch->failed = k;
	if (!(J > 0.0))
		return error_set(
			STATUS_GUARD,
			"law '%s': the point is turned inside out, det F = %.3g; cure: a smaller time.step, or a finer grid",
			law->name, J);
	mat2_log_stretch(batch->F[k], e);
	double mean = 0.5 * (e[0] + e[1]), d = hypot(0.5 * (e[0] - e[1]), e[2]);
	return error_set(STATUS_GUARD,
					 "law '%s': stretched to %.3g and %.3g it leaves its domain of validity, elastic stretches from "
					 "%.3g to %.3g, beyond which the Hencky law is unstable; cure: elasticity = \"neo_hookean\", or a "
					 "load that strains it less",
					 law->name, exp(mean - d), exp(mean + d), exp(HENCKY_LEAST), exp(HENCKY_MOST));
}

static int neo_hookean(const struct law *law, struct law_batch *batch, double time, int from, int to)
{
	const struct thermoelastic_model *m = law->model;
	int failed = to;
	for (int k = from; k < to; k++) {
		struct thermoelastic_state *s = state_of(law, batch->slot[k]);
		double warming = s->warming + (time > 0.0 ? batch->dT[k] : 0.0), elastic = 0.0;
		double pressure = neo_hookean_respond(m, batch->F[k], warming, batch->stress[k], &batch->modulus[k], &elastic);
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
	return failed;
}

static int run_batch(const struct law *law, struct law_batch *batch, double time)
{
	const struct thermoelastic_model *m = law->model;
	int failed = law_each_block(law, batch, time, m->neo_hookean ? neo_hookean : m->kernel->hencky);
	return failed < batch->n ? left_domain(batch, law, failed) : STATUS_OK;
}

static int thermoelastic_evaluate(const struct law *law, struct law_batch *batch) { return run_batch(law, batch, 0.0); }
static int thermoelastic_advance(struct law *law, struct law_batch *batch) { return run_batch(law, batch, batch->dt); }

/* ---- the derivative of P = tau F^-T ---- */

/* Change of tau and tau itself (xx, yy, xy) with F in the direction G.  For the logarithm of b = m I + d, d^2 = r^2 I,
 * see log_left_stretch(). */
static void hencky_derivative(const struct thermoelastic_model *m, const double F[4], const double G[4],
							  double volumetric, double tau[3], double change[3])
{
	double h[3], trace, J = mat2_determinant(F);
	log_left_stretch(F, J, h, &trace);
	double bxx = F[0] * F[0] + F[1] * F[1], byy = F[2] * F[2] + F[3] * F[3], bxy = F[0] * F[2] + F[1] * F[3];
	double mean = 0.5 * (bxx + byy), d = 0.5 * (bxx - byy), r2 = d * d + bxy * bxy, q2 = r2 / (mean * mean);
	double gxx = 2.0 * (F[0] * G[0] + F[1] * G[1]), gyy = 2.0 * (F[2] * G[2] + F[3] * G[3]);
	double gxy = G[0] * F[2] + G[1] * F[3] + F[0] * G[2] + F[1] * G[3], gm = 0.5 * (gxx + gyy), gd = 0.5 * (gxx - gyy);
	double ratio = atanh_ratio(q2), half_r2 = d * gd + bxy * gxy; /* change of r^2 / 2 */
	double slope = q2 < 1e-3 ? 1.0 / 3 + q2 * (2.0 / 5 + q2 * (3.0 / 7 + q2 * (4.0 / 9 + q2 * (5.0 / 11))))
							 : 0.5 / q2 * (1.0 / (1.0 - q2) - ratio);
	double k = ratio / mean;
	double gk = -k * gm / mean + slope * 2.0 * (half_r2 - q2 * mean * gm) / (mean * mean * mean);
	double iso = m->lambda * volumetric + m->mu * volumetric; /* ln b = ln J I + k d: its isotropic part */
	tau[0] = m->lambda * trace + 2.0 * m->mu * h[0], tau[1] = m->lambda * trace + 2.0 * m->mu * h[1];
	tau[2] = 2.0 * m->mu * h[2];
	change[0] = iso + m->mu * (gk * d + k * gd), change[1] = iso - m->mu * (gk * d + k * gd);
	change[2] = m->mu * (gk * bxy + k * gxy);
}

static void neo_hookean_derivative(const struct thermoelastic_model *m, const double F[4], const double G[4],
								   double volumetric, double tau[3], double change[3])
{
	double iso = m->lambda * log(mat2_determinant(F)), mu = m->mu;
	tau[0] = mu * (F[0] * F[0] + F[1] * F[1] - 1.0) + iso, tau[1] = mu * (F[2] * F[2] + F[3] * F[3] - 1.0) + iso;
	tau[2] = mu * (F[0] * F[2] + F[1] * F[3]);
	change[0] = 2.0 * mu * (F[0] * G[0] + F[1] * G[1]) + m->lambda * volumetric;
	change[1] = 2.0 * mu * (F[2] * G[2] + F[3] * G[3]) + m->lambda * volumetric;
	change[2] = mu * (G[0] * F[2] + G[1] * F[3] + F[0] * G[2] + F[1] * G[3]);
}

/* dP = d tau F^-T - tau F^-T G^T F^-T */
static void thermoelastic_piola_derivative(const struct law *law, const double F[4], const double G[4], double dP[4])
{
	const struct thermoelastic_model *m = law->model;
	double inverse[4], g[4], tau[3], change[3];
	mat2_inverse(F, inverse);
	mat2_multiply(G, inverse, g); /* velocity gradient of the change */
	(m->neo_hookean ? neo_hookean_derivative : hencky_derivative)(m, F, G, g[0] + g[3], tau, change);
	const double a[4] = {change[0] - tau[0] * g[0] - tau[2] * g[1], change[2] - tau[0] * g[2] - tau[2] * g[3],
						 change[2] - tau[2] * g[0] - tau[1] * g[1], change[1] - tau[2] * g[2] - tau[1] * g[3]};
	const double transposed[4] = {inverse[0], inverse[2], inverse[1], inverse[3]};
	mat2_multiply(a, transposed, dP);
}

static void thermoelastic_export(const struct law *law, int f, int n, const int *slot, double *out)
{
	(void)f;
	for (int k = 0; k < n; k++)
		out[k] = state_of(law, slot[k])->elastic;
}

static void thermoelastic_ledger(const struct law *law, int slot, struct law_ledger *ledger)
{
	const struct thermoelastic_state *s = state_of(law, slot);
	*ledger = (struct law_ledger){.work = s->elastic - s->expansion, .elastic = s->elastic, .expansion = s->expansion};
}

static void thermoelastic_reset(struct law *law, int slot) { state_of(law, slot)->expansion = 0.0; }

static const struct field thermoelastic_fields[] = {
	{"energy_elastic", "J/m3", 1, "stored elastic energy, per initial volume"},
};

const struct law_type law_thermoelastic = {
	.name = "thermoelastic",
	.doc =
		"isotropic at finite strain with thermal expansion: hencky (logarithmic strain; plane strain or plane stress) "
		"or neo_hookean",
	.cohesive = true,
	.fields = thermoelastic_fields,
	.n_fields = sizeof thermoelastic_fields / sizeof *thermoelastic_fields,
	.create = thermoelastic_create,
	.destroy = law_release,
	.evaluate = thermoelastic_evaluate,
	.advance = thermoelastic_advance,
	.export_field = thermoelastic_export,
	.piola_derivative = thermoelastic_piola_derivative,
	.ledger = thermoelastic_ledger,
	.reset_ledger = thermoelastic_reset,
};
