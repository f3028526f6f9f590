/* Freezing and thawing: points carry the share that is thawed beside their temperature, which together are their
 * enthalpy.  Increments of temperature from the grid bring sensible heat, the enthalpy takes it up, and the
 * temperature follows from it: nothing is lost however narrow the interval and however large the step. */
#include <math.h>
#include <stdlib.h>

#include "base/error.h"
#include "mpm/mpm_private.h"

int freezing_create(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	const struct scene *scene = mpm->scene;
	w->freezing = calloc((size_t)scene->n_materials + 1, sizeof *w->freezing);
	if (!w->freezing)
		return error_set(STATUS_RESOURCE, "out of memory");
	for (int m = 0; m < scene->n_materials; m++) {
		const struct scene_material *s = &scene->materials[m];
		double width = s->freezing[1] - s->freezing[0], mean = 0.5 * (s->heat_capacity + s->heat_capacity_frozen);
		w->freezing[m] = (struct freezing){.on = mpm->thermal && !isnan(width),
										   .low = s->freezing[0],
										   .high = s->freezing[1],
										   .frozen = s->heat_capacity_frozen,
										   .thawed = s->heat_capacity,
										   .all = mean * width + s->latent_heat,
										   .conductivity = s->conductivity_frozen};
		w->freezes = w->freezes || w->freezing[m].on;
	}
	return STATUS_OK;
}

static void set_share(struct mpm *mpm, const struct freezing *f, int p, double share)
{
	mpm->p.thawed[p] = share;
	mpm->p.capacity[p] = share * f->thawed + (1.0 - share) * f->frozen;
}

void freezing_begin(struct mpm *mpm, int p)
{
	const struct freezing *f = &mpm_work(mpm)->freezing[mpm->p.material[p]];
	double T = mpm->p.T[p];
	if (f->on)
		set_share(mpm, f, p, T >= f->high ? 1.0 : T <= f->low ? 0.0 : (T - f->low) / (f->high - f->low));
}

/* J/kg, counted from all frozen at f->low. */
static double enthalpy(const struct freezing *f, double T, double share)
{
	if (share >= 1.0)
		return f->all + f->thawed * (T - f->high);
	return share > 0.0 ? f->all * share : f->frozen * (T - f->low);
}

double freezing_heat(const struct mpm *mpm, int p)
{
	const struct freezing *f = &mpm_work(mpm)->freezing[mpm->p.material[p]];
	double m = mpm->p.mass[p], T = mpm->p.T[p];
	return f->on ? m * enthalpy(f, T, mpm->p.thawed[p]) : m * mpm->p.capacity[p] * T;
}

void freezing_absorb(struct mpm *mpm, int p, double dT)
{
	const struct freezing *f = &mpm_work(mpm)->freezing[mpm->p.material[p]];
	double content = enthalpy(f, mpm->p.T[p], mpm->p.thawed[p]) + mpm->p.capacity[p] * dT;
	if (content >= f->all) {
		mpm->p.T[p] = f->high + (content - f->all) / f->thawed;
		set_share(mpm, f, p, 1.0);
	} else if (content <= 0.0) {
		mpm->p.T[p] = f->low + content / f->frozen;
		set_share(mpm, f, p, 0.0);
	} else {
		set_share(mpm, f, p, content / f->all);
		mpm->p.T[p] = f->low + mpm->p.thawed[p] * (f->high - f->low);
	}
}
