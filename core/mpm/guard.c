/* Stability guards: each says step, time, point, reason and cure. */
#include <math.h>
#include <stdio.h>

#include "base/error.h"
#include "base/mat2.h"
#include "mpm/mpm_private.h"

/* "step N, t = ...: point ID at (x, y) m" */
static void where(const struct mpm *mpm, int p, char text[160])
{
	snprintf(text, 160, "step %lld, t = %.6g s: point %d at (%.6g, %.6g) m", mpm->step, mpm->time, mpm->p.id[p],
			 mpm->p.x[p][0], mpm->p.x[p][1]);
}

/* Largest steps, s, and the points that set them (storage index, -1 = none). */
static void find_limits(const struct mpm *mpm, double *wave, int *stiffest, double *heat, int *most_diffusive)
{
	const struct mpm_work *w = mpm_work(mpm);
	const struct scene_time *t = &mpm->scene->time;
	double stiffness = 0.0, diffusivity = 0.0, h = fmin(mpm->grid.spacing[0], mpm->grid.spacing[1]);
	*stiffest = *most_diffusive = -1;
	for (int s = 0; s < w->n_stripes; s++) {
		const struct stripe_sum *sum = &w->stripe_sums[s];
		if (sum->stiffness > stiffness)
			stiffness = sum->stiffness, *stiffest = sum->stiffest;
		if (sum->diffusivity > diffusivity)
			diffusivity = sum->diffusivity, *most_diffusive = sum->most_diffusive;
	}
	*wave = stiffness > 0.0 ? t->step_factor * h / sqrt(stiffness) : INFINITY;
	double thermal = diffusivity > 0.0 ? h * h / (2.0 * diffusivity) : INFINITY; /* of thermal time */
	*heat = thermal * t->thermal_steps / t->thermal_every / mpm->scene->thermal.time_scale;
}

/* What is left when a guard fires on the way to the grid: USF has already strained the points. */
static const char *state_at(const struct mpm *mpm)
{
	return mpm->within_step ? "within the step, not fit to go on from" : "start of the step";
}

/* Where a shape has a bound for lone points its limit follows the points slowly, and a scene that begins above it is
 * wrong from the start; without one it may come and go as points cross grid cells: the growth decides. */
static int guard_motion(const struct mpm *mpm, int status, double wave, int stiffest)
{
	const struct mpm_work *w = mpm_work(mpm);
	const struct particles *p = &mpm->p;
	double dt = mpm->scene->time.step, b = mpm->scene->time.step_factor, lattice = mpm->lattice_limit;
	char text[160];
	if (dt > wave) {
		double density = p->mass[stiffest] / (p->volume0[stiffest] * mat2_determinant(p->F[stiffest]));
		where(mpm, stiffest, text);
		return error_set(
			status,
			"%s: time.step = %.4g s is above the limit %.4g s = %g h sqrt(rho/M) with M = %.4g Pa, rho = %.4g "
			"kg/m3; cure: time.step of %.2g s or less, or a larger grid.cell (state: %s)",
			text, dt, wave, b, p->modulus[stiffest], density, fmin(wave, lattice), state_at(mpm));
	}
	bool bounded = isfinite(mpm->shape->lone(0.25)), starts = status == STATUS_INPUT;
	if (starts ? bounded && w->limit.motion > 2.0 : w->limit.growth > log(GROWTH_MOST)) {
		where(mpm, starts ? w->limit.stiffest : w->limit.grown, text);
		return error_set(status,
						 "%s: time.step = %.4g s is above the limit %.4g s = %g sqrt(2)/w of the points as they lie in "
						 "their grid cells; cure: %s (state: %s)",
						 text, dt, lattice, b,
						 bounded ? "that time.step or less, or a larger grid.cell"
								 : "mpm.shape = \"ugimp\": the linear shape has no safe step for a point that has just "
								   "entered a grid cell",
						 state_at(mpm));
	}
	return STATUS_OK;
}

static int guard_heat(const struct mpm *mpm, int status, double heat, int diffusive)
{
	const struct mpm_work *w = mpm_work(mpm);
	double dt = mpm->scene->time.step, passes = mpm->scene->time.thermal_steps;
	char text[160];
	if (dt > heat * (1.0 + 1e-9)) {
		where(mpm, diffusive, text);
		return error_set(
			status,
			"%s: time.step = %.4g s is above the limit of heat conduction %.4g s (rho c h^2/2k%s, %g thermal steps "
			"in %d, thermal.time_scale %g); cure: time.step of %.2g s or less, or time.thermal_steps = %d (state: %s)",
			text, dt, heat,
			mpm_convection_as_conduction(mpm, diffusive, 1.0) > 0.0 ? ", less what convection takes" : "", passes,
			mpm->scene->time.thermal_every, mpm->scene->thermal.time_scale, heat, (int)ceil(dt / heat * passes),
			state_at(mpm));
	}
	if (passes > 1.0 && w->limit.heat > 2.0) {
		where(mpm, w->limit.hottest, text);
		return error_set(
			status,
			"%s: time.thermal_steps = %g are too few for heat conduction on the points as they lie in their "
			"grid cells; cure: time.thermal_steps = %d, or a smaller time.step (state: %s)",
			text, passes, (int)ceil(0.5 * w->limit.heat * passes), state_at(mpm));
	}
	return STATUS_OK;
}

int guard_step(struct mpm *mpm, int status)
{
	const struct mpm_work *w = mpm_work(mpm);
	char text[160];
	const char *state = state_at(mpm);
	for (int s = 0; s < w->n_stripes; s++)
		if (w->stripe_sums[s].bad >= 0) {
			where(mpm, w->stripe_sums[s].bad, text);
			return error_set(
				STATUS_GUARD,
				"%s: its stress, modulus or temperature is not a number; cure: a smaller time.step, and check "
				"the law's parameters (state: %s)",
				text, state);
		}
	double wave, heat;
	int stiffest, diffusive;
	find_limits(mpm, &wave, &stiffest, &heat, &diffusive);
	if (w->thermal_dt > 0.0)
		mpm->thermal_limit = heat;
	mpm->stable_step = fmin(wave, mpm->thermal ? mpm->thermal_limit : INFINITY);
	if (mpm->scene->guards.time_step)
		CHECK(guard_motion(mpm, status, wave, stiffest));
	if (mpm->scene->guards.thermal_step && w->thermal_dt > 0.0)
		CHECK(guard_heat(mpm, status, heat, diffusive));
	return STATUS_OK;
}

/* Points that had left when the state was saved (or whose place is no number) take part in nothing. */
int guard_inside(const struct mpm *mpm)
{
	const struct mpm_work *w = mpm_work(mpm);
	if (!mpm->scene->guards.points_leaving || w->n_inside == mpm->p.n)
		return STATUS_OK;
	char text[160];
	int k = 0;
	while (w->cell[k] >= 0)
		k++;
	where(mpm, k, text);
	return error_set(STATUS_GUARD,
					 "%s: it lies outside the grid; cure: a larger grid, a wall in its way, or guards.points_leaving = "
					 "false (state: start of the step)",
					 text);
}

int guard_cohesion(const struct mpm *mpm)
{
	int point, other;
	char text[160];
	if (!cohesion_lost(mpm, &point, &other))
		return STATUS_OK;
	where(mpm, point, text);
	return error_set(
		STATUS_GUARD,
		"%s: the grid tears it from its neighbour %d at (%.6g, %.6g) m, not the law: their distance is not what "
		"their deformation gradients say; cure: a larger points_per_cell, mpm.shape = \"ugimp\", or "
		"guards.numerical_fracture = false (state: start of the step)",
		text, mpm->p.id[other], mpm->p.x[other][0], mpm->p.x[other][1]);
}

int guard_points(const struct mpm *mpm)
{
	const struct mpm_work *w = mpm_work(mpm);
	char text[160];
	for (int b = 0; b < w->n_blocks; b++) {
		const struct block_sum *sum = &w->block_sums[b];
		if (sum->bad >= 0) {
			where(mpm, sum->bad, text);
			return error_set(
				STATUS_GUARD,
				"%s: its motion or temperature is not a number; cure: a smaller time.step (state: end of the "
				"step, not fit to go on from)",
				text);
		}
		if (sum->left >= 0 && mpm->scene->guards.points_leaving) {
			where(mpm, sum->left, text);
			return error_set(
				STATUS_GUARD,
				"%s: it has left the grid; cure: a larger grid, a wall in its way, or guards.points_leaving = "
				"false (state: end of the step)",
				text);
		}
	}
	return STATUS_OK;
}

int guard_residual(const struct mpm *mpm)
{
	const struct mpm_work *w = mpm_work(mpm);
	if (!w->residual_message[0])
		return STATUS_OK;
	return error_set(
		STATUS_GUARD,
		"step %lld, t = %.6g s: %s; cure: a smaller time.step, or guards.energy_residual (state: start of the step)",
		mpm->step, mpm->time, w->residual_message);
}

/* What has come back of the numerical losses was made of nothing: an explicit step beyond its limit does that before
 * anything else shows.  The energy that comes and goes with the half step between stress and velocity stays well below
 * the bound. */
int guard_energy(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	double bound = mpm->scene->guards.energy_created, loss = ledger_loss(mpm);
	w->total.loss_most = fmax(w->total.loss_most, loss);
	double created = w->total.loss_most - loss;
	if (!(bound > 0.0) || created <= bound * (w->total.scale + fabs(mpm->ledger.work_expansion)))
		return STATUS_OK;
	mpm_measure(mpm);              /* the work of thermal expansion as it is now */
	w->residual_message[0] = '\0'; /* which is judged between steps: USF is within one here */
	double scale = w->total.scale + fabs(mpm->ledger.work_expansion);
	if (created <= bound * scale)
		return STATUS_OK;
	return error_set(
		STATUS_GUARD,
		"step %lld, t = %.6g s: the time integration has made %.3g J of nothing, %.3g%% of the work done (%.3g J), "
		"allowed %.3g%%: it is unstable; cure: a smaller time.step, or guards.energy_created (state: %s)",
		mpm->step, mpm->time, created, 100.0 * created / scale, scale, 100.0 * bound, state_at(mpm));
}

int guard_law(const struct mpm *mpm, int status, int point)
{
	char text[160];
	if (point < 0)
		return error_context(status, "step %lld, t = %.6g s", mpm->step, mpm->time);
	where(mpm, point, text);
	return error_context(status, "%s (state: within the step, not fit to go on from)", text);
}
