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

int guard_step(struct mpm *mpm, int status)
{
	const struct mpm_work *w = mpm_work(mpm);
	const struct particles *p = &mpm->p;
	char text[160];
	const char *state = mpm->scene->mpm.order == MPM_USF && status == STATUS_GUARD
							? "within the step, not fit to go on from"
							: "start of the step";
	for (int s = 0; s < w->n_stripes; s++)
		if (w->stripe_sums[s].bad >= 0) {
			where(mpm, w->stripe_sums[s].bad, text);
			return error_set(
				STATUS_GUARD,
				"%s: its stress, modulus or temperature is not a number; cure: a smaller time.step, and check "
				"the law's parameters (state: %s)",
				text, state);
		}
	double wave, heat, dt = mpm->scene->time.step;
	int stiffest, diffusive;
	find_limits(mpm, &wave, &stiffest, &heat, &diffusive);
	if (w->thermal_dt > 0.0)
		mpm->thermal_limit = heat;
	mpm->stable_step = fmin(wave, mpm->thermal ? mpm->thermal_limit : INFINITY);
	if (dt > wave) {
		double density = p->mass[stiffest] / (p->volume0[stiffest] * mat2_determinant(p->F[stiffest]));
		where(mpm, stiffest, text);
		return error_set(
			status,
			"%s: time.step = %.4g s is above the limit %.4g s = %g h sqrt(rho/M) with M = %.4g Pa, rho = %.4g "
			"kg/m3; cure: time.step of %.2g s or less, or a larger grid.cell (state: %s)",
			text, dt, wave, mpm->scene->time.step_factor, p->modulus[stiffest], density, wave, state);
	}
	if (w->thermal_dt > 0.0 && dt > heat * (1.0 + 1e-9)) {
		where(mpm, diffusive, text);
		return error_set(
			status,
			"%s: time.step = %.4g s is above the limit of heat conduction %.4g s (rho c h^2/2k%s, %d thermal steps "
			"in %d, thermal.time_scale %g); cure: time.step of %.2g s or less, or time.thermal_steps = %d (state: %s)",
			text, dt, heat,
			mpm_convection_as_conduction(mpm, diffusive, 1.0) > 0.0 ? ", less what convection takes" : "",
			mpm->scene->time.thermal_steps, mpm->scene->time.thermal_every, mpm->scene->thermal.time_scale, heat,
			(int)ceil(dt / heat * mpm->scene->time.thermal_steps), state);
	}
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

int guard_law(const struct mpm *mpm, int status, int point)
{
	char text[160];
	if (point < 0)
		return error_context(status, "step %lld, t = %.6g s", mpm->step, mpm->time);
	where(mpm, point, text);
	return error_context(status, "%s (state: within the step, not fit to go on from)", text);
}
