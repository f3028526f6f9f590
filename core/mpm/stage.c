/* Stages: the damping and the walls of a span of time, and what is done when it ends. */
#include "base/error.h"
#include "mpm/mpm_private.h"

double mpm_thermal_step(const struct mpm *mpm)
{
	return mpm->dt * mpm->scene->time.thermal_every * mpm->scene->thermal.time_scale;
}

void stage_begin_step(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	const struct scene *scene = mpm->scene;
	double staged = scene->n_stages > 0 ? scene->stages[mpm->stage].damping : 0.0;
	mpm->dt = scene->time.step;
	mpm->bonds_installed = false;
	w->alpha_p = (scene->mpm.damping_particle + staged) * mpm->dt;
	w->alpha_g = scene->mpm.damping_grid * mpm->dt;
	w->filters_step = scene->mpm.transfer == MPM_FMPM;
	w->filtered = (scene->mpm.transfer == MPM_XPIC || w->filters_step) && (mpm->step + 1) % scene->mpm.xpic_every == 0;
	w->alpha_pic = w->filtered ? 0.0 : scene->mpm.transfer == MPM_APIC ? 1.0 : scene->mpm.pic_fraction;
	int every = scene->time.thermal_every;
	bool due = mpm->thermal && (mpm->step + 1) % every == 0;
	w->thermal_dt = due ? mpm_thermal_step(mpm) : 0.0;
}

/* What the velocities take with them is lost, and booked. */
static void zero_velocities(struct mpm *mpm)
{
	struct particles *p = &mpm->p;
	for (int k = 0; k < p->n; k++) {
		mpm_work(mpm)->total.loss_numerical += 0.5 * p->mass[k] * (p->v[k][0] * p->v[k][0] + p->v[k][1] * p->v[k][1]);
		point_stop(p, k);
	}
}

static int install_bonds(struct mpm *mpm)
{
	for (int l = 0; l < mpm->n_laws; l++)
		if (mpm->laws[l]->type->install_bonds)
			CHECK(mpm->laws[l]->type->install_bonds(mpm->laws[l]));
	mpm->bonds_installed = true;
	return STATUS_OK;
}

int stage_end_step(struct mpm *mpm)
{
	const struct scene *scene = mpm->scene;
	if (mpm->stage + 1 >= scene->n_stages)
		return STATUS_OK;
	const struct scene_stage *stage = &scene->stages[mpm->stage];
	if (mpm->time - mpm->stage_start < stage->duration - 0.5 * mpm->dt)
		return STATUS_OK;
	if (stage->then_install_bonds)
		CHECK(install_bonds(mpm));
	if (stage->then_zero_velocity)
		zero_velocities(mpm);
	if (stage->then_zero_ledger)
		ledger_start(mpm);
	mpm->stage++;
	mpm->stage_start = mpm->time;
	return STATUS_OK;
}
