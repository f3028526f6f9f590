/* How many DEM steps a step of the scene is cut into.
 *
 * The strain of a call is applied in N sub-steps of pseudo-time, so that N sets how far inertia counts: the inertial
 * number I = deps/dt_DEM d sqrt(rho/p) of a sub-step's strain deps.  `strain_per_step` bounds deps (in proportion to
 * sqrt(p), which keeps I); `economy.pace` lets it be longer where that changes the stress little. */
#ifndef TMDEMPM_RVE_PACE_H
#define TMDEMPM_RVE_PACE_H

#include "rve/model.h"
#include "rve/state.h"

/* I of a sub-step of this strain at a pressure > 0, Pa. */
double pace_inertia(const struct rve_model *model, double strain_per_step, double pressure);

/* Sub-steps for a call of this strain (largest principal value); counts what n_max cuts and what pace saves. */
int pace_sub_steps(const struct rve_model *model, struct rve_head *head, double strain);

#endif
