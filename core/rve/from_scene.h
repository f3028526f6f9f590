/* The parameters of an RVE law as a scene gives them: one place, so that a run and `tmdempm rve load
 * --scene` drive the same RVE. */
#ifndef TMDEMPM_RVE_FROM_SCENE_H
#define TMDEMPM_RVE_FROM_SCENE_H

#include "rve/packing.h"
#include "rve/rve.h"
#include "scene/scene.h"

void rve_params_from_scene(struct rve_params *params, const struct scene_law_rve *law);

/* The packing of variant number `variant`: the law's file, or generated with its seed + variant (cached). */
int rve_packing_from_scene(struct rve_packing **packing, const struct scene_law_rve *law, int variant);

#endif
