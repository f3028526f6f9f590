#include "rve/pace.h"

#include <math.h>

/* Inertia raises the stress of a cell by 15 I p, that of the loose packings, the larger one, in replayed paths: 0.19 p at
 * I = 0.012, 0.52 at 0.037 (scenarios/studies/rve_strain_step.cfg).  A cell that slow shear would leave without stress
 * at its volume has Bagnold's stress, some 1600 I^2 p: less in wider ones, up to twice that where it is about to jam
 * (tests/unit/test_rve_pace.c). */
static const double stress_per_inertia = 15.0, collisional = 40.0;

/* The largest relative error, and the I that keeps it. */
static double error_of(double inertia)
{
	return fmax(stress_per_inertia * inertia, collisional * inertia * collisional * inertia);
}

static double inertia_for(double error) { return fmin(error / stress_per_inertia, sqrt(error) / collisional); }

double pace_inertia(const struct rve_model *model, double strain_per_step, double pressure)
{
	return strain_per_step / model->constants.dt * model->diameter * sqrt(model->params.grain_density / pressure);
}

static int calm(const struct rve_params *params, const struct rve_head *head)
{
	return head->contacts > 0.0 && head->unbalanced < params->pace_unbalanced &&
		   head->sliding < params->pace_sliding * head->contacts;
}

/* N for a limit of the sub-step's strain, as a real number so that it cannot overflow. */
static double steps_for(double strain, double limit) { return fmax(1.0, fmin(ceil(strain / limit), 1e9)); }

int pace_sub_steps(const struct rve_model *model, struct rve_head *head, double strain)
{
	const struct rve_params *params = &model->params;
	double scale = fmax(rve_stress_scale(head), 0.0), limit = params->strain_per_step;
	if (params->pressure_scaling)
		limit *= fmax(0.1, fmin(1.0, sqrt(scale / 100e3)));
	double most = params->n_max > 0 ? params->n_max : 1e9;
	double wanted = steps_for(strain, limit), taken = wanted;
	if (params->pace_calm > 1.0 && calm(params, head))
		taken = steps_for(strain, params->pace_calm * limit);
	if (params->pace_stress > 0.0) {
		/* a stress below the error that is allowed need not be resolved: its RVE counts as one of that stress */
		double pressure = fmax(scale, params->pace_stress);
		double inertia = inertia_for(params->pace_stress / pressure);
		taken = fmin(taken, steps_for(strain, inertia / pace_inertia(model, 1.0, pressure)));
	}
	if (taken < wanted && taken < most) {
		double pressure = fmax(scale, fmax(params->pace_stress, 1.0)); /* a cell without stress counts as 1 Pa */
		double error = error_of(pace_inertia(model, strain / taken, pressure)) * pressure;
		head->paced_calls++;
		head->paced_saved += (int64)(fmin(wanted, most) - taken);
		head->paced_error_sum += error;
		head->paced_error_most = fmax(head->paced_error_most, error);
	}
	if (taken > most)
		head->clamped++;
	return (int)fmin(taken, most);
}
