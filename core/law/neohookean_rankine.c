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
#include "law/kernel.h"
#include "law/rankine.h"

static struct rankine_state *state_of(const struct law *law, int slot)
{
	return (struct rankine_state *)law->states + slot;
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
	const struct rankine_model *m = law->model;
	for (int k = 0; k < law->n_points; k++) {
		struct rankine_state *state = state_of(law, k);
		*state = (struct rankine_state){.J = 1.0, .strength = s->strength * scatter(s, k)};
		state->R = state->strength;
		state->softening = rankine_softening(m, state->strength, M_SQRT2 * m->cell);
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
	CHECK(law_allocate(law, sizeof(struct rankine_model), sizeof(struct rankine_state)));
	struct rankine_model *m = law->model;
	*m = (struct rankine_model){.K = s->young / (3.0 * (1.0 - 2.0 * s->poisson)),
								.G = s->young / (2.0 * (1.0 + s->poisson)),
								.coupling = 3.0 * s->expansion,
								.young = s->young,
								.energy = s->fracture_energy,
								.cell = s->cell,
								.heat_share = s->heat_share,
								.unilateral = s->unilateral,
								.projected = s->projected,
								.kernel = law_kernel_here()};
	law->coupling = fabs(m->K - 2.0 / 3.0 * m->G) / (m->K + 4.0 / 3.0 * m->G);
	return begin_states(law, scene);
}

/* ---- response ---- */

static int run_batch(const struct law *law, struct law_batch *batch, double dt)
{
	const struct rankine_model *m = law->model;
	int failed = law_each_block(law, batch, dt, m->kernel->rankine);
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
		const struct rankine_state *s = state_of(law, slot[k]);
		const double values[] = {s->damage, expm1(5.0 * s->damage) / expm1(5.0), s->strength, s->elastic, s->fracture};
		out[k] = values[f];
	}
}

static void rankine_ledger(const struct law *law, int slot, struct law_ledger *ledger)
{
	const struct rankine_state *s = state_of(law, slot);
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
