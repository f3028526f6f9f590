#include "rve/from_scene.h"

#include <math.h>
#include <string.h>

#include "base/error.h"

void rve_params_from_scene(struct rve_params *params, const struct scene_law_rve *law)
{
	rve_params_default(params);
	static const enum rve_code_path paths[] = {RVE_SIMD, RVE_SERIAL, RVE_SIMD, RVE_SIMD_SINGLE};
	params->path = paths[law->path];
	params->kn = law->kn;
	params->ks = law->ks;
	params->mu = law->mu;
	params->damping_ratio = law->damping_ratio;
	params->grain_density = law->grain_density;
	params->thickness = law->disc_thickness;
	params->expansion = law->expansion;
	params->resistance = law->resistance;
	params->step_factor = law->step_factor;
	params->strain_per_step = law->strain_per_step;
	params->pressure_scaling = law->pressure_scaling;
	params->n_max = law->n_max;
	params->skin = law->skin;
	params->gas = law->gas;
	params->gas_pressure = law->gas_pressure;
	params->gas_stretch = law->gas_stretch;
	params->step_guard = law->step_guard;
	params->pace_stress = law->economy.pace.stress;
	params->pace_calm = law->economy.pace.calm;
	params->pace_unbalanced = law->economy.pace.unbalanced;
	params->pace_sliding = law->economy.pace.sliding;
	params->quiet_change = law->economy.quiet.change;
	params->quiet_strain = law->economy.quiet.strain;
	params->quiet_unbalanced = law->economy.quiet.unbalanced;
	params->overlap_max = law->overlap_max;
	params->bond_strength = law->bonds.strength;
	params->bond_mu = law->bonds.mu;
	params->bond_melting = law->bonds.melting;
	params->bond_reference = law->bonds.linear ? law->bonds.reference : NAN;
}

int rve_packing_from_scene(struct rve_packing **packing, const struct scene_law_rve *law, int variant)
{
	const struct scene_packing *p = &law->packing;
	if (p->file[0] && variant > 0)
		return error_set(STATUS_INPUT, "the packing %s is one file, expected no variants of it", p->file);
	if (p->file[0])
		return rve_packing_read(packing, p->file);
	struct rve_params grains;
	rve_params_from_scene(&grains, law);
	grains.step_factor =
		fmin(grains.step_factor, rve_step_factor_limit(&grains)); /* a study may walk past it, a packing not */
	const struct rve_packing_params how = {
		.discs = p->discs,
		.radius_min = p->radius_min,
		.radius_max = p->radius_max,
		.pressure = p->pressure,
		.mu = p->mu,
		.void_ratio = p->void_ratio,
		.seed = p->seed + (unsigned)variant,
		.square_lattice = strcmp(p->lattice, "square") == 0,
	};
	return rve_packing_cached(packing, &how, &grains);
}
