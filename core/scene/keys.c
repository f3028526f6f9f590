/* Everything that a scene can say: names, types, units, defaults, limits, meaning.  This table drives the
 * parser, the checks, the suggestions, and the test of scenarios/reference.cfg. */
#include <ctype.h>
#include <stdlib.h>
#include <string.h>

#include "scene/custom.h"
#include "scene/private.h"

/* A table is read line by line, so it keeps its own layout. */
/* clang-format off */
#define AT(s, field) .offset = offsetof(struct s, field)
#define LIST(s, array, counter) \
	.type = KEY_LIST, .offset = offsetof(struct s, array), .n_offset = offsetof(struct s, counter), \
	.element_size = sizeof *((struct s *)0)->array
#define CHOICES(...) .choices = (const char *const[]){__VA_ARGS__, NULL}
#define KEYS(table) .tables = (const struct scene_table[]){{NULL, table}, {NULL, NULL}}
#define SERIES .expected = "rows ([s, value], [s, value], ...), two at least, in the order of time"
#define END {.name = NULL}

static const struct scene_key units_keys[] = {
	{.name = "temperature", .type = KEY_FLAG, AT(scene_units, celsius), .value = "\"K\"", CHOICES("K", "C"),
	 .doc = "unit of every temperature in the scene and in its outputs"},
	END};

static const struct scene_key grid_keys[] = {
	{.name = "origin", .type = KEY_FLOATS, AT(scene_grid, origin), .count = 2, .unit = "m", .required = true,
	 .doc = "lower left node"},
	{.name = "size", .type = KEY_FLOATS, AT(scene_grid, size), .count = 2, .unit = "m", .required = true, .range = RANGE_POSITIVE,
	 .doc = "width and height, a whole number of cells each"},
	{.name = "cell", .type = KEY_FLOAT, AT(scene_grid, cell), .unit = "m", .required = true, .range = RANGE_POSITIVE,
	 .doc = "edge of the square cells"},
	{.name = "thickness", .type = KEY_FLOAT, AT(scene_grid, thickness), .unit = "m", .value = "1.0", .range = RANGE_POSITIVE,
	 .doc = "out of plane; gives masses, forces and energies"},
	{.name = "follow", .type = KEY_CUSTOM, .absent = "the grid stays as it is", .text = true, .read = read_grid_follow,
	 .expected = "the name of a moving wall",
	 .doc = "name of a moving wall: the grid is stretched with it, so that its face stays on a row of nodes"},
	{.name = "fixed", .type = KEY_FLOATS, AT(scene_grid, fixed), .count = 2, .unit = "m", .absent = "the origin",
	 .doc = "the place that does not move when the grid follows a wall"},
	END};

static const struct scene_key time_keys[] = {
	{.name = "end", .type = KEY_FLOAT, AT(scene_time, end), .unit = "s", .required = true, .range = RANGE_POSITIVE,
	 .doc = "when the run is done"},
	{.name = "step", .type = KEY_FLOAT, AT(scene_time, step), .unit = "s", .required = true, .range = RANGE_POSITIVE,
	 .doc = "fixed time step"},
	{.name = "step_factor", .type = KEY_FLOAT, AT(scene_time, step_factor), .value = "1.0", .range = RANGE_WITHIN, .min = 0.01, .max = 1.0,
	 .doc = "b of the limit step <= b cell sqrt(density / P-wave modulus), beyond which a step is refused"},
	{.name = "thermal_steps", .type = KEY_INT, AT(scene_time, thermal_steps), .value = "1", .range = RANGE_WITHIN, .min = 1, .max = 1000,
	 .doc = "thermal sub-steps in each mechanical step"},
	{.name = "thermal_every", .type = KEY_INT, AT(scene_time, thermal_every), .value = "1", .range = RANGE_WITHIN, .min = 1, .max = 1000000,
	 .doc = "or one thermal step every so many mechanical steps"},
	END};

static const struct scene_key mpm_keys[] = {
	{.name = "shape", .type = KEY_CHOICE, AT(scene_mpm, shape), .value = "\"ugimp\"", CHOICES("ugimp", "linear", "cpdi"),
	 .doc = "shape functions: over the points' undeformed squares, from single places, or from the corners of their deformed domains"},
	{.name = "transfer", .type = KEY_ENUM, AT(scene_mpm, transfer), .value = "\"flip\"", .choices = mpm_transfer_names,
	 .doc = "how velocities go from the nodes to the points; tmdempm info says how"},
	{.name = "xpic_order", .type = KEY_INT, AT(scene_mpm, xpic_order), .value = "2", .range = RANGE_WITHIN, .min = 1, .max = 100,
	 .doc = "m of XPIC(m) and FMPM(m); 1 is PIC, each order more costs one pass over the points"},
	{.name = "xpic_every", .type = KEY_INT, AT(scene_mpm, xpic_every), .value = "1", .range = RANGE_WITHIN, .min = 1, .max = 1000000,
	 .doc = "they act in one step of so many, the others are FLIP"},
	{.name = "order", .type = KEY_ENUM, AT(scene_mpm, order), .value = "\"usl\"", .choices = mpm_order_names,
	 .doc = "when stresses are updated: usl = last in the step, usf = first, musl = last, from the points' new velocities"},
	{.name = "pic_fraction", .type = KEY_FLOAT, AT(scene_mpm, pic_fraction), .value = "0.0", .range = RANGE_WITHIN, .min = 0.0, .max = 1.0,
	 .doc = "share of PIC in the velocity update of each FLIP step; smooths like a viscosity of about 0.19 pic_fraction cell^2 / step"},
	{.name = "damping_particle", .type = KEY_FLOAT, AT(scene_mpm, damping_particle), .unit = "1/s", .value = "0.0",
	 .range = RANGE_NOT_NEGATIVE, .doc = "damping rate of the points' velocity"},
	{.name = "damping_grid", .type = KEY_FLOAT, AT(scene_mpm, damping_grid), .unit = "1/s", .value = "0.0",
	 .range = RANGE_NOT_NEGATIVE, .doc = "damping rate of the nodes' velocity"},
	{.name = "confining_pressure", .type = KEY_FLOAT, AT(scene_mpm, confining_pressure), .unit = "Pa", .value = "0.0",
	 .range = RANGE_NOT_NEGATIVE, .doc = "pressure that acts on every free surface and follows it"},
	{.name = "contact_fields", .type = KEY_INT, AT(scene_mpm, contact_fields), .absent = "one for each node", .range = RANGE_WITHIN, .min = 1, .max = 100000000,
	 .doc = "most extra fields of nodes at which bodies meet, beyond the first of each node; only with contacts"},
	END};

static const struct scene_key thermal_keys[] = {
	{.name = "on", .type = KEY_BOOL, AT(scene_thermal, on), .absent = "true if a material has a heat_capacity or something is heated",
	 .doc = "heat is conducted and stored; false = no thermal pass"},
	{.name = "friction_heat", .type = KEY_BOOL, AT(scene_thermal, friction_heat), .value = "true",
	 .doc = "friction between the discs of RVEs heats the points"},
	{.name = "time_scale", .type = KEY_FLOAT, AT(scene_thermal, time_scale), .value = "1.0", .range = RANGE_POSITIVE,
	 .doc = "heat conduction, fluxes and convection run so many times faster than the mechanics; friction heat, times of tables and from/until do not"},
	END};

/* ---- laws ---- */

static const struct scene_key packing_keys[] = {
	{.name = "file", .type = KEY_CUSTOM, AT(scene_packing, file), .absent = "the packing is generated from the keys below", .text = true,
	 .expected = "a file name ending in .h5 or .csv", .read = read_packing_file,
	 .doc = "a stored packing, its path as seen from this file"},
	{.name = "lattice", .type = KEY_CHOICE, AT(scene_packing, lattice), .value = "\"random\"", CHOICES("random", "square"),
	 .doc = "how the discs start: at random, or on a square lattice of discs of radius_max without noise"},
	{.name = "discs", .type = KEY_INT, AT(scene_packing, discs), .value = "400", .range = RANGE_WITHIN, .min = 16, .max = 16000,
	 .doc = "number of discs"},
	{.name = "radius_min", .type = KEY_FLOAT, AT(scene_packing, radius_min), .unit = "m", .value = "0.25e-3", .range = RANGE_POSITIVE,
	 .doc = "smallest radius of a uniform distribution"},
	{.name = "radius_max", .type = KEY_FLOAT, AT(scene_packing, radius_max), .unit = "m", .value = "0.5e-3", .range = RANGE_POSITIVE,
	 .doc = "largest radius"},
	{.name = "pressure", .type = KEY_FLOAT, AT(scene_packing, pressure), .unit = "Pa", .absent = "only with file",
	 .range = RANGE_POSITIVE, .doc = "isotropic pressure of consolidation"},
	{.name = "mu", .type = KEY_FLOAT, AT(scene_packing, mu), .value = "0.5", .range = RANGE_WITHIN, .min = 0.0, .max = 10.0,
	 .doc = "friction during consolidation: 0.01 packs densely, 0.5 loosely"},
	{.name = "void_ratio", .type = KEY_FLOAT, AT(scene_packing, void_ratio), .absent = "whatever mu gives",
	 .range = RANGE_WITHIN, .min = 0.1, .max = 0.4, .doc = "target; mu is then found by bisection"},
	{.name = "seed", .type = KEY_UNSIGNED, AT(scene_packing, seed), .value = "1", .range = RANGE_WITHIN, .min = 0, .max = 4294967295.0,
	 .doc = "of the random numbers; the same seed gives the same packing"},
	END};

static const struct scene_key bonds_keys[] = {
	{.name = "strength", .type = KEY_FLOAT, AT(scene_bonds, strength), .value = "0.0", .range = RANGE_WITHIN, .min = 0.0, .max = 1.0,
	 .doc = "a bond bears this times kn times the mean radius of its two discs in tension; 0 = no bonds; less than skin"},
	{.name = "mu", .type = KEY_FLOAT, AT(scene_bonds, mu), .value = "0.5", .range = RANGE_WITHIN, .min = 0.0, .max = 10.0,
	 .doc = "and this times its tensile strength in shear"},
	{.name = "melting", .type = KEY_TEMPERATURE, AT(scene_bonds, melting), .absent = "never",
	 .doc = "above this temperature every bond breaks, for good"},
	{.name = "softening", .type = KEY_FLAG, AT(scene_bonds, linear), .value = "\"step\"", CHOICES("step", "linear"),
	 .doc = "whether the strength is whole up to melting, or falls to nothing there in proportion"},
	{.name = "reference", .type = KEY_TEMPERATURE, AT(scene_bonds, reference), .absent = "0 C",
	 .doc = "at and below this temperature the strength of linear softening is whole"},
	END};

static const struct scene_key quiet_keys[] = {
	{.name = "change", .type = KEY_FLOAT, AT(scene_quiet, change), .value = "0.0", .range = RANGE_WITHIN, .min = 0.0, .max = 1.0,
	 .doc = "the discs of an RVE wait, and its stress follows its elastic tensor, until the stress has changed by this share of the pressure; bounds the error of the stress; 0 = they do not wait"},
	{.name = "strain", .type = KEY_FLOAT, AT(scene_quiet, strain), .value = "1e-4", .range = RANGE_WITHIN, .min = 0.0, .max = 0.01,
	 .doc = "and until the RVE has been strained by this"},
	{.name = "unbalanced", .type = KEY_FLOAT, AT(scene_quiet, unbalanced), .value = "0.02", .range = RANGE_WITHIN, .min = 0.0, .max = 1.0,
	 .doc = "and only where the mean net force on a disc / mean contact force is below this"},
	END};

static const struct scene_key pace_keys[] = {
	{.name = "stress", .type = KEY_FLOAT, AT(scene_pace, stress), .unit = "Pa", .value = "0.0", .range = RANGE_NOT_NEGATIVE,
	 .doc = "a DEM step may be as long as inertia in it changes the stress by this, by estimate: RVEs of low pressure need fewer; a hundredth of the pressures that matter; 0 = off"},
	{.name = "calm", .type = KEY_FLOAT, AT(scene_pace, calm), .value = "1.0", .range = RANGE_WITHIN, .min = 1.0, .max = 20.0,
	 .doc = "where the contacts are calm it may be this many times as long as strain_per_step allows; 1 = off"},
	{.name = "unbalanced", .type = KEY_FLOAT, AT(scene_pace, unbalanced), .value = "0.02", .range = RANGE_WITHIN, .min = 0.0, .max = 1.0,
	 .doc = "calm: the mean net force on a disc / mean contact force is below this"},
	{.name = "sliding", .type = KEY_FLOAT, AT(scene_pace, sliding), .value = "0.05", .range = RANGE_WITHIN, .min = 0.0, .max = 1.0,
	 .doc = "and the share of contacts that slide below this"},
	END};

static const struct scene_key economy_keys[] = {
	{.name = "twins", .type = KEY_BOOL, AT(scene_economy, twins), .value = "true",
	 .doc = "RVEs that are equal bit for bit, and told the same, are computed once; changes no bit"},
	{.name = "pace", .type = KEY_GROUP, AT(scene_economy, pace), KEYS(pace_keys), .doc = "longer DEM steps where that matters little"},
	{.name = "quiet", .type = KEY_GROUP, AT(scene_economy, quiet), KEYS(quiet_keys), .doc = "RVEs to which little happens"},
	END};

const char *const scene_law_type_names[] = {"thermoelastic", "rve", "neohookean_rankine", NULL};

#define LAW_KEYS \
	{.name = "name", .type = KEY_NAME, AT(scene_law, name), .absent = "the material's name (in the list laws it is required)", \
	 .doc = "by which materials refer to the law"}, \
	{.name = "type", .type = KEY_ENUM, AT(scene_law, type), .required = true, .choices = scene_law_type_names, \
	 .doc = "thermoelasticity, a cell of discs behind every point, or a brittle solid"}

static const struct scene_key thermoelastic_keys[] = {
	LAW_KEYS,
	{.name = "young", .type = KEY_FLOAT, AT(scene_law, thermoelastic.young), .unit = "Pa", .required = true, .range = RANGE_POSITIVE,
	 .doc = "Young's modulus"},
	{.name = "poisson", .type = KEY_FLOAT, AT(scene_law, thermoelastic.poisson), .required = true, .range = RANGE_BETWEEN, .min = -1.0,
	 .max = 0.5, .doc = "Poisson's ratio"},
	{.name = "expansion", .type = KEY_FLOAT, AT(scene_law, thermoelastic.expansion), .unit = "1/K", .value = "0.0", .range = RANGE_WITHIN,
	 .min = -0.1, .max = 0.1, .doc = "linear thermal expansion"},
	{.name = "plane", .type = KEY_FLAG, AT(scene_law, thermoelastic.plane_stress), .value = "\"strain\"", CHOICES("strain", "stress"),
	 .doc = "what holds out of the plane"},
	{.name = "elasticity", .type = KEY_FLAG, AT(scene_law, thermoelastic.neo_hookean), .value = "\"hencky\"", CHOICES("hencky", "neo_hookean"),
	 .doc = "stress by logarithmic strain, for stretches from 0.21 to 1.39; or neo-Hookean, for large strain"},
	END};

static const struct scene_key rve_keys[] = {
	LAW_KEYS,
	{.name = "packing", .type = KEY_GROUP, AT(scene_law, rve.packing), KEYS(packing_keys), .required = true,
	 .doc = "the cell's discs at the start"},
	{.name = "bonds", .type = KEY_GROUP, AT(scene_law, rve.bonds), KEYS(bonds_keys),
	 .doc = "between discs, once a stage has installed them; at contacts that carry force"},
	{.name = "path", .type = KEY_ENUM, AT(scene_law, rve.path), .value = "\"auto\"", CHOICES("auto", "serial", "simd", "single"),
	 .doc = "how RVEs are computed: plainly, the reference and what devices do; in short vectors, 1.8 times as fast; these in single precision, 2.5 times, for packings of 10 kPa or more; auto is simd, on devices serial, after a restart what the run began with"},
	{.name = "economy", .type = KEY_GROUP, AT(scene_law, rve.economy), KEYS(economy_keys),
	 .doc = "what need not be computed, and how wrong that may be"},
	{.name = "kn", .type = KEY_FLOAT, AT(scene_law, rve.kn), .unit = "N/m", .value = "1e6", .range = RANGE_POSITIVE,
	 .doc = "normal contact stiffness"},
	{.name = "ks", .type = KEY_FLOAT, AT(scene_law, rve.ks), .unit = "N/m", .value = "1e6", .range = RANGE_NOT_NEGATIVE,
	 .doc = "tangential contact stiffness"},
	{.name = "mu", .type = KEY_FLOAT, AT(scene_law, rve.mu), .value = "0.5", .range = RANGE_WITHIN, .min = 0.0, .max = 10.0,
	 .doc = "friction between discs"},
	{.name = "damping_ratio", .type = KEY_FLOAT, AT(scene_law, rve.damping_ratio), .value = "0.2", .range = RANGE_WITHIN, .min = 0.0,
	 .max = 1.0, .doc = "of the normal dashpot, relative to critical damping"},
	{.name = "grain_density", .type = KEY_FLOAT, AT(scene_law, rve.grain_density), .unit = "kg/m3", .value = "2650.0",
	 .range = RANGE_POSITIVE, .doc = "of the discs; the material's bulk density is this / (1 + void ratio)"},
	{.name = "disc_thickness", .type = KEY_FLOAT, AT(scene_law, rve.disc_thickness), .unit = "m", .value = "0.075",
	 .range = RANGE_POSITIVE, .doc = "z of the cell, enters its volume only"},
	{.name = "expansion", .type = KEY_FLOAT, AT(scene_law, rve.expansion), .unit = "1/K", .value = "1e-4", .range = RANGE_WITHIN,
	 .min = -0.1, .max = 0.1, .doc = "linear thermal expansion of the discs"},
	{.name = "resistance", .type = KEY_FLOAT, AT(scene_law, rve.resistance), .unit = "K/(W m)", .value = "1e4", .range = RANGE_POSITIVE,
	 .doc = "thermal resistance of a contact per length of its branch"},
	{.name = "step_factor", .type = KEY_FLOAT, AT(scene_law, rve.step_factor), .value = "0.4", .range = RANGE_WITHIN, .min = 0.001,
	 .max = 2.0, .doc = "DEM step / sqrt(smallest mass / kn); unstable above 0.57 with ks = kn and damping_ratio 0.2, above less if either is larger"},
	{.name = "strain_per_step", .type = KEY_FLOAT, AT(scene_law, rve.strain_per_step), .value = "5e-5", .range = RANGE_WITHIN, .min = 1e-9,
	 .max = 0.01, .doc = "largest strain in one DEM step at 100 kPa: 5e-5 good, 2e-4 economy, 1e-6 with n_max = 0 reference"},
	{.name = "pressure_scaling", .type = KEY_BOOL, AT(scene_law, rve.pressure_scaling), .value = "true",
	 .doc = "strain_per_step shrinks as sqrt(p / 100 kPa), to a tenth at most"},
	{.name = "n_max", .type = KEY_INT, AT(scene_law, rve.n_max), .value = "20", .range = RANGE_WITHIN, .min = 0, .max = 1000000,
	 .doc = "most DEM steps in one step of the scene; 0 = as many as strain_per_step asks for"},
	{.name = "skin", .type = KEY_FLOAT, AT(scene_law, rve.skin), .value = "0.2", .range = RANGE_WITHIN, .min = 0.01, .max = 2.0,
	 .doc = "margin of the neighbour list / largest radius"},
	{.name = "gas", .type = KEY_BOOL, AT(scene_law, rve.gas), .value = "true",
	 .doc = "points whose discs have lost touch fly without stress and cost nothing"},
	{.name = "gas_pressure", .type = KEY_FLOAT, AT(scene_law, rve.gas_pressure), .unit = "Pa", .value = "20.0",
	 .range = RANGE_NOT_NEGATIVE, .doc = "below which"},
	{.name = "gas_stretch", .type = KEY_FLOAT, AT(scene_law, rve.gas_stretch), .value = "1.12", .range = RANGE_WITHIN, .min = 1.0,
	 .max = 10.0, .doc = "and above which volume ratio that happens"},
	{.name = "overlap_max", .type = KEY_FLOAT, AT(scene_law, rve.overlap_max), .value = "0.5", .range = RANGE_WITHIN, .min = 0.001,
	 .max = 1.0, .doc = "overlap / smaller radius at which the run is stopped"},
	END};

static const struct scene_key rankine_keys[] = {
	LAW_KEYS,
	{.name = "young", .type = KEY_FLOAT, AT(scene_law, rankine.young), .unit = "Pa", .required = true, .range = RANGE_POSITIVE,
	 .doc = "Young's modulus"},
	{.name = "poisson", .type = KEY_FLOAT, AT(scene_law, rankine.poisson), .required = true, .range = RANGE_BETWEEN, .min = -1.0,
	 .max = 0.5, .doc = "Poisson's ratio"},
	{.name = "expansion", .type = KEY_FLOAT, AT(scene_law, rankine.expansion), .unit = "1/K", .value = "0.0", .range = RANGE_WITHIN,
	 .min = -0.1, .max = 0.1, .doc = "linear thermal expansion; with heat, stretching cools by it"},
	{.name = "strength", .type = KEY_FLOAT, AT(scene_law, rankine.strength), .unit = "Pa", .required = true, .range = RANGE_POSITIVE,
	 .doc = "largest principal stress that it bears"},
	{.name = "fracture_energy", .type = KEY_FLOAT, AT(scene_law, rankine.fracture_energy), .unit = "J/m2", .required = true,
	 .range = RANGE_POSITIVE, .doc = "that a crack takes per area; cells must be smaller than young fracture_energy / (sqrt(2) strength^2)"},
	{.name = "compression", .type = KEY_FLAG, AT(scene_law, rankine.unilateral), .value = "\"scaled\"", CHOICES("scaled", "whole"),
	 .doc = "whether damage takes all of the stress, or only the principal stresses that pull"},
	{.name = "band", .type = KEY_FLAG, AT(scene_law, rankine.projected), .value = "\"diagonal\"", CHOICES("diagonal", "projected"),
	 .doc = "width over which a crack's opening is spread: the cell's diagonal, or its width along the stress that opens it"},
	{.name = "heat_share", .type = KEY_FLOAT, AT(scene_law, rankine.heat_share), .value = "1.0", .range = RANGE_WITHIN, .min = 0.0, .max = 1.0,
	 .doc = "share of the fracture energy that becomes heat; 0: it stays in the new surfaces"},
	{.name = "weibull", .type = KEY_FLOAT, AT(scene_law, rankine.weibull), .value = "0.0", .range = RANGE_NOT_NEGATIVE,
	 .doc = "modulus of the strength's scatter from point to point about its mean; 0 = the same everywhere"},
	{.name = "seed", .type = KEY_UNSIGNED, AT(scene_law, rankine.seed), .value = "1", .range = RANGE_WITHIN, .min = 0, .max = 4294967295.0,
	 .doc = "of that scatter"},
	END};

#define LAW_TABLES \
	.tables = (const struct scene_table[]){ \
		{"thermoelastic", thermoelastic_keys}, {"rve", rve_keys}, {"neohookean_rankine", rankine_keys}, {NULL, NULL}}

static const struct scene_key material_keys[] = {
	{.name = "name", .type = KEY_NAME, AT(scene_material, name), .required = true, .doc = "by which bodies refer to the material"},
	{.name = "law", .type = KEY_CUSTOM, AT(scene_material, law), .required = true, .text = true, .read = read_material_law,
	 .expected = "the name of a law, or a law in braces: { type = ...; ... }", LAW_TABLES,
	 .doc = "name of a law in laws, or a law of its own in braces"},
	{.name = "density", .type = KEY_FLOAT, AT(scene_material, density), .unit = "kg/m3", .range = RANGE_POSITIVE,
	 .absent = "grain_density / (1 + void ratio) of an rve; else required", .doc = "bulk density at the start"},
	{.name = "heat_capacity", .type = KEY_FLOAT, AT(scene_material, heat_capacity), .unit = "J/(kg K)", .range = RANGE_POSITIVE,
	 .absent = "only without heat", .doc = "specific heat capacity"},
	{.name = "conductivity", .type = KEY_FLOAT, AT(scene_material, conductivity), .unit = "W/(m K)", .range = RANGE_NOT_NEGATIVE,
	 .absent = "from the contacts of an rve; else only without heat", .doc = "thermal conductivity"},
	{.name = "reference_temperature", .type = KEY_TEMPERATURE, AT(scene_material, reference_temperature),
	 .absent = "the temperature at the start", .doc = "at which the thermal strain is zero"},
	{.name = "freezing", .type = KEY_CUSTOM, AT(scene_material, freezing), .absent = "it does not freeze", .read = read_freezing,
	 .expected = "two temperatures [frozen below, thawed above], the same or rising",
	 .doc = "[frozen below, thawed above]; between them the latent heat is spread evenly; heat_capacity and conductivity are those of the thawed material"},
	{.name = "latent_heat", .type = KEY_FLOAT, AT(scene_material, latent_heat), .unit = "J/kg", .absent = "none", .range = RANGE_NOT_NEGATIVE,
	 .doc = "that thawing takes and freezing gives, per mass of the bulk"},
	{.name = "heat_capacity_frozen", .type = KEY_FLOAT, AT(scene_material, heat_capacity_frozen), .unit = "J/(kg K)", .range = RANGE_POSITIVE,
	 .absent = "heat_capacity", .doc = "when frozen"},
	{.name = "conductivity_frozen", .type = KEY_FLOAT, AT(scene_material, conductivity_frozen), .unit = "W/(m K)", .range = RANGE_NOT_NEGATIVE,
	 .absent = "as when thawed", .doc = "when frozen, also of an rve"},
	END};

/* ---- bodies and walls ---- */

static const struct scene_key layer_keys[] = {
	{.name = "top", .type = KEY_FLOAT, AT(scene_layer, top), .unit = "m", .required = true, .doc = "upper y of the layer"},
	{.name = "material", .type = KEY_CUSTOM, AT(scene_layer, material), .absent = "the body's material", .text = true,
	 .read = read_material_name, .expected = "the name of a material", .doc = "name of a material"},
	{.name = "temperature", .type = KEY_TEMPERATURE, AT(scene_layer, temperature), .absent = "the body's temperature",
	 .doc = "at the start"},
	END};

static const struct scene_key motion_keys[] = {
	{.name = "solution", .type = KEY_CUSTOM, .absent = "no motion", .text = true, .read = read_motion_solution,
	 .expected = "a solution of `tmdempm exact` that is a motion", .doc = "one of the motions of `tmdempm exact`; X is the place in the scene"},
	{.name = "parameters", .type = KEY_CUSTOM, .absent = "its defaults", .read = read_motion_parameters,
	 .expected = "a list of \"name=value\"", .doc = "of the solution, as (\"amplitude=0.01\", ...)"},
	{.name = "force", .type = KEY_BOOL, AT(scene_motion, force), .value = "true",
	 .doc = "a body force keeps the body on the motion; false: it is born with it, then free"},
	END};

static const struct scene_key mask_keys[] = {
	{.name = "file", .type = KEY_CUSTOM, AT(scene_mask, file), .absent = "no mask", .text = true, .read = read_mask_file,
	 .expected = "a file name ending in .pgm", .doc = "a grey image, PGM (P2 or P5, up to 255), its path as seen from this file; from PNG: convert grains.png grains.pgm"},
	{.name = "pixel", .type = KEY_FLOAT, AT(scene_mask, pixel), .unit = "m", .absent = "only without a mask", .range = RANGE_POSITIVE,
	 .doc = "edge of a pixel"},
	{.name = "origin", .type = KEY_FLOATS, AT(scene_mask, origin), .count = 2, .unit = "m", .value = "[0.0, 0.0]",
	 .doc = "lower left corner of the image"},
	{.name = "level", .type = KEY_INTS, AT(scene_mask, level), .count = 2, .value = "[128, 255]",
	 .doc = "least and greatest grey value of the region: grains of different values are bodies of one image"},
	END};

static const struct scene_key cut_keys[] = {
	{.name = "box", .type = KEY_CUSTOM, .unit = "m", .absent = "only with another shape", .read = read_body_shape,
	 .expected = "[xmin, ymin, xmax, ymax]", .doc = "as of a body"},
	{.name = "polygon", .type = KEY_CUSTOM, .unit = "m", .absent = "only with another shape", .read = read_body_shape,
	 .expected = "([x, y], [x, y], [x, y], ...)", .doc = "as of a body"},
	{.name = "disc", .type = KEY_CUSTOM, .unit = "m", .absent = "only with another shape", .read = read_body_circle,
	 .expected = "[x, y, radius] with radius > 0", .doc = "as of a body"},
	END};

static const struct scene_key body_keys[] = {
	{.name = "name", .type = KEY_NAME, AT(scene_body, name), .required = true, .doc = "of the body"},
	{.name = "material", .type = KEY_CUSTOM, AT(scene_body, material), .required = true, .text = true, .read = read_material_name,
	 .expected = "the name of a material", .doc = "name of a material"},
	{.name = "box", .type = KEY_CUSTOM, .unit = "m", .absent = "only with another shape", .read = read_body_shape,
	 .expected = "[xmin, ymin, xmax, ymax]", .doc = "the region, as [xmin, ymin, xmax, ymax]"},
	{.name = "polygon", .type = KEY_CUSTOM, .unit = "m", .absent = "only with another shape", .read = read_body_shape,
	 .expected = "([x, y], [x, y], [x, y], ...)", .doc = "the region, as its corners ([x, y], ...) in order"},
	{.name = "disc", .type = KEY_CUSTOM, .unit = "m", .absent = "only with another shape", .read = read_body_circle,
	 .expected = "[x, y, radius] with radius > 0", .doc = "the region, as [x, y, radius]"},
	{.name = "ring", .type = KEY_CUSTOM, .unit = "m", .absent = "only with another shape", .read = read_body_circle,
	 .expected = "[x, y, inner, outer] with 0 < inner < outer", .doc = "the region between two circles, as [x, y, inner radius, outer radius]"},
	{.name = "outline", .type = KEY_CUSTOM, .text = true, .absent = "only with another shape", .read = read_body_outline,
	 .expected = "a file name ending in .csv or .vtp", .doc = "the region, as its corners in order in a file: rows x,y in m, or the first cell of a .vtp (ascii)"},
	{.name = "mask", .type = KEY_GROUP, AT(scene_body, mask), KEYS(mask_keys), .absent = "only with another shape",
	 .doc = "the region, as an image"},
	{.name = "cuts", LIST(scene_body, cuts, n_cuts), KEYS(cut_keys), .absent = "none", .doc = "regions taken out of the body: notches, holes"},
	{.name = "angle", .type = KEY_FLOAT, AT(scene_body, angle), .unit = "deg", .value = "0.0", .range = RANGE_WITHIN, .min = -360.0, .max = 360.0,
	 .doc = "by which region, cuts and lattice are turned counter-clockwise; the domains of its points turn with shape = \"cpdi\" only"},
	{.name = "pivot", .type = KEY_FLOATS, AT(scene_body, pivot), .count = 2, .unit = "m", .value = "[0.0, 0.0]",
	 .doc = "about which"},
	{.name = "lattice_origin", .type = KEY_FLOATS, AT(scene_body, lattice_origin), .count = 2, .unit = "m", .absent = "the grid's origin",
	 .doc = "points sit strictly inside the region at lattice_origin + (i + 1/2, j + 1/2) spacing"},
	{.name = "points_per_cell", .type = KEY_INT, AT(scene_body, points_per_cell), .value = "4", .range = RANGE_WITHIN, .min = 1, .max = 16,
	 .doc = "1, 4, 9 or 16; the spacing is cell / sqrt(points_per_cell)"},
	{.name = "temperature", .type = KEY_TEMPERATURE, AT(scene_body, temperature), .absent = "20 C", .doc = "at the start"},
	{.name = "temperature_gradient", .type = KEY_FLOATS, AT(scene_body, temperature_gradient), .count = 2, .unit = "K/m", .value = "[0.0, 0.0]",
	 .doc = "at the start, added to the temperatures of the body and its layers"},
	{.name = "temperature_at", .type = KEY_FLOATS, AT(scene_body, temperature_at), .count = 2, .unit = "m",
	 .absent = "the lower left corner of the box around the body", .doc = "where those temperatures hold"},
	{.name = "velocity", .type = KEY_FLOATS, AT(scene_body, velocity), .count = 2, .unit = "m/s", .value = "[0.0, 0.0]",
	 .doc = "at the start"},
	{.name = "drive", .type = KEY_FLOATS, AT(scene_body, drive), .count = 2, .unit = "m/s", .absent = "free",
	 .doc = "velocity of a rigid driver: imposed on every node that the body's points touch"},
	{.name = "drive_ramp", .type = KEY_FLOAT, AT(scene_body, drive_ramp), .unit = "s", .value = "0.0", .range = RANGE_NOT_NEGATIVE,
	 .doc = "time in which that rises from nothing, in a straight line"},
	{.name = "motion", .type = KEY_GROUP, AT(scene_body, motion), KEYS(motion_keys), .absent = "none",
	 .doc = "an exact motion that the body is born with and follows, for verification"},
	{.name = "variants", .type = KEY_INT, AT(scene_body, variants), .value = "1", .range = RANGE_WITHIN, .min = 1, .max = 1000,
	 .doc = "number of packings (seed, seed + 1, ...) dealt out to the points in turn"},
	{.name = "layers", LIST(scene_body, layers, n_layers), KEYS(layer_keys), .absent = "one material",
	 .doc = "fills of different material or temperature, from the bottom up"},
	END};

static const struct scene_key wall_keys[] = {
	{.name = "name", .type = KEY_NAME, AT(scene_wall, name), .required = true, .doc = "of the wall; its loads are wall.NAME in the history"},
	{.name = "line", .type = KEY_CUSTOM, .unit = "m", .absent = "only with another shape", .read = read_wall_shape,
	 .expected = "([x, y], [x, y])", .doc = "from first to second point ([x, y], [x, y]), solid on its right"},
	{.name = "box", .type = KEY_CUSTOM, .unit = "m", .absent = "only with another shape", .read = read_wall_shape,
	 .expected = "[xmin, ymin, xmax, ymax]", .doc = "solid inside [xmin, ymin, xmax, ymax]"},
	{.name = "polygon", .type = KEY_CUSTOM, .unit = "m", .absent = "only with another shape", .read = read_wall_shape,
	 .expected = "([x, y], [x, y], [x, y], ...)", .doc = "solid inside the corners ([x, y], ...)"},
	{.name = "wedge", .type = KEY_CUSTOM, .unit = "m", .absent = "only with another shape", .read = read_wall_shape,
	 .expected = "[x, y, leg_x, leg_y]",
	 .doc = "solid right-angled triangle with its right angle at x, y and legs along x and y: [x, y, leg_x, leg_y]"},
	{.name = "depth", .type = KEY_FLOAT, AT(scene_wall, depth), .unit = "m", .absent = "two cells", .range = RANGE_POSITIVE,
	 .doc = "of the solid behind a line"},
	{.name = "contact", .type = KEY_ENUM, AT(scene_wall, contact), .value = "\"frictional\"", CHOICES("frictional", "slip", "stick", "penalty"),
	 .doc = "pushes only, with Coulomb friction; or normal velocity tied both ways, no friction; or both tied; or pushes points where their surface has come through, for static contact"},
	{.name = "stiffness", .type = KEY_FLOAT, AT(scene_wall, stiffness), .value = "20.0", .range = RANGE_POSITIVE,
	 .doc = "of a penalty wall: pressure per depth, over P-wave modulus / cell; with 20 time.step stays below 0.3 cell / wave speed"},
	{.name = "friction", .type = KEY_FLOAT, AT(scene_wall, friction), .value = "0.0", .range = RANGE_WITHIN, .min = 0.0, .max = 100.0,
	 .doc = "coefficient of friction"},
	{.name = "velocity", .type = KEY_FLOATS, AT(scene_wall, velocity), .count = 2, .unit = "m/s", .value = "[0.0, 0.0]",
	 .doc = "the wall moves with it while it is active"},
	{.name = "temperature", .type = KEY_TEMPERATURE, AT(scene_wall, temperature), .absent = "insulating",
	 .doc = "of nodes in contact with the wall"},
	{.name = "temperature_table", .type = KEY_CUSTOM, AT(scene_wall, temperature_table), .absent = "constant", .read = read_temperature_series, SERIES,
	 .doc = "or as it changes in time: ([s, temperature], ...), linear between the rows, held outside them"},
	{.name = "heat_share", .type = KEY_FLOAT, AT(scene_wall, heat_share), .value = "0.0", .range = RANGE_WITHIN, .min = 0.0, .max = 1.0,
	 .doc = "share of the friction work at the wall that heats the material"},
	{.name = "from", .type = KEY_FLOAT, AT(scene_wall, from), .unit = "s", .value = "0.0", .range = RANGE_NOT_NEGATIVE,
	 .doc = "active from this time"},
	{.name = "until", .type = KEY_FLOAT, AT(scene_wall, until), .unit = "s", .absent = "for ever", .range = RANGE_POSITIVE,
	 .doc = "until this time"},
	{.name = "active", .type = KEY_BOOL, AT(scene_wall, active), .value = "true",
	 .doc = "false leaves the wall out of the scene, for variants"},
	END};

static const struct scene_key convection_keys[] = {
	{.name = "coefficient", .type = KEY_FLOAT, AT(scene_convection, coefficient), .unit = "W/(m2 K)", .absent = "no convection", .range = RANGE_POSITIVE,
	 .doc = "of heat transfer"},
	{.name = "ambient", .type = KEY_TEMPERATURE, AT(scene_convection, ambient), .absent = "only with ambient_table",
	 .doc = "temperature of the surroundings"},
	{.name = "ambient_table", .type = KEY_CUSTOM, AT(scene_convection, ambient_table), .absent = "constant", .read = read_temperature_series, SERIES,
	 .doc = "or as it changes in time: ([s, temperature], ...)"},
	END};

static const struct scene_key boundary_keys[] = {
	{.name = "name", .type = KEY_NAME, AT(scene_boundary, name), .required = true, .doc = "of the boundary"},
	{.name = "box", .type = KEY_CUSTOM, AT(scene_boundary, min), .n_offset = offsetof(struct scene_boundary, max), .unit = "m", .required = true, .read = read_box,
	 .expected = "[xmin, ymin, xmax, ymax]", .doc = "nodes in [xmin, ymin, xmax, ymax] (which may have no width); points, for a flux, convection or traction"},
	{.name = "velocity_x", .type = KEY_FLOAT, AT(scene_boundary, velocity[0]), .unit = "m/s", .absent = "free",
	 .doc = "imposed on the nodes"},
	{.name = "velocity_y", .type = KEY_FLOAT, AT(scene_boundary, velocity[1]), .unit = "m/s", .absent = "free",
	 .doc = "imposed on the nodes"},
	{.name = "traction_x", .type = KEY_FLOAT, AT(scene_boundary, traction[0]), .unit = "Pa", .absent = "none",
	 .doc = "on the points that begin in the box: each carries traction / layer per initial volume, as a dead load"},
	{.name = "traction_y", .type = KEY_FLOAT, AT(scene_boundary, traction[1]), .unit = "Pa", .absent = "none",
	 .doc = "on the points that begin in the box: each carries traction / layer per initial volume, as a dead load"},
	{.name = "temperature", .type = KEY_TEMPERATURE, AT(scene_boundary, temperature), .absent = "free", .doc = "imposed on the nodes"},
	{.name = "temperature_table", .type = KEY_CUSTOM, AT(scene_boundary, temperature_table), .absent = "constant", .read = read_temperature_series, SERIES,
	 .doc = "or as it changes in time: ([s, temperature], ...), linear between the rows, held outside them"},
	{.name = "flux", .type = KEY_FLOAT, AT(scene_boundary, flux), .unit = "W/m2", .absent = "none", .doc = "heat into the material"},
	{.name = "flux_table", .type = KEY_CUSTOM, AT(scene_boundary, flux_table), .unit = "W/m2", .absent = "constant", .read = read_series, SERIES,
	 .doc = "or as it changes in time: ([s, flux], ...)"},
	{.name = "convection", .type = KEY_GROUP, AT(scene_boundary, convection), KEYS(convection_keys),
	 .doc = "heat exchanged with the surroundings: coefficient (ambient - temperature in the layer)"},
	{.name = "layer", .type = KEY_FLOAT, AT(scene_boundary, layer), .unit = "m", .absent = "one cell", .range = RANGE_POSITIVE,
	 .doc = "depth of the material in the box: each of its points gets the flux or traction / layer per volume"},
	{.name = "from", .type = KEY_FLOAT, AT(scene_boundary, from), .unit = "s", .value = "0.0", .range = RANGE_NOT_NEGATIVE,
	 .doc = "active from this time"},
	{.name = "until", .type = KEY_FLOAT, AT(scene_boundary, until), .unit = "s", .absent = "for ever", .range = RANGE_POSITIVE,
	 .doc = "until this time"},
	END};

static const struct scene_key contact_keys[] = {
	{.name = "bodies", .type = KEY_CUSTOM, .absent = "every pair of bodies that no other contact names", .read = read_contact_bodies,
	 .expected = "the names of two bodies: (\"a\", \"b\"), or of one for its own cracks", .doc = "names of the two bodies; or of one, for the faces of its own cracks"},
	{.name = "cracks", .type = KEY_BOOL, AT(scene_contact, cracks), .value = "false",
	 .doc = "also between the faces of cracks in each of these bodies; without it they are welded, and pass no force where the law has lost its stress"},
	{.name = "friction", .type = KEY_FLOAT, AT(scene_contact, friction), .value = "0.0", .range = RANGE_WITHIN, .min = 0.0, .max = 100.0,
	 .doc = "coefficient of friction"},
	{.name = "softening", .type = KEY_CUSTOM, AT(scene_contact, softening), .absent = "friction does not depend on temperature", .read = read_softening,
	 .expected = "two temperatures [whole at, gone at] that rise",
	 .doc = "[whole at, gone at]: friction falls as ((gone - T) / (gone - whole))^2 with the temperature of the hotter body"},
	{.name = "heat_share", .type = KEY_FLOAT, AT(scene_contact, heat_share), .value = "1.0", .range = RANGE_WITHIN, .min = 0.0, .max = 1.0,
	 .doc = "share of the friction work that heats the bodies, half each; where there is heat"},
	{.name = "conductance", .type = KEY_FLOAT, AT(scene_contact, conductance), .unit = "W/(m2 K)", .value = "0.0", .range = RANGE_NOT_NEGATIVE,
	 .doc = "of heat, at conductance_pressure"},
	{.name = "conductance_pressure", .type = KEY_FLOAT, AT(scene_contact, conductance_pressure), .unit = "Pa", .value = "1e6", .range = RANGE_POSITIVE,
	 .doc = "the contact pressure at which it holds"},
	{.name = "conductance_exponent", .type = KEY_FLOAT, AT(scene_contact, conductance_exponent), .value = "1.0", .range = RANGE_WITHIN, .min = 0.0, .max = 10.0,
	 .doc = "it grows as (pressure / conductance_pressure) to this power"},
	END};

static const struct scene_key stage_keys[] = {
	{.name = "name", .type = KEY_NAME, AT(scene_stage, name), .required = true, .doc = "of the stage"},
	{.name = "duration", .type = KEY_FLOAT, AT(scene_stage, duration), .unit = "s", .absent = "until time.end (the last stage only)",
	 .range = RANGE_POSITIVE, .doc = "how long it lasts"},
	{.name = "damping", .type = KEY_FLOAT, AT(scene_stage, damping), .unit = "1/s", .value = "0.0", .range = RANGE_NOT_NEGATIVE,
	 .doc = "added to mpm.damping_particle"},
	{.name = "walls", .type = KEY_CUSTOM, AT(scene_stage, walls), .absent = "all walls", .read = read_stage_walls,
	 .expected = "a list of names of walls: (\"ground\", ...)", .doc = "names of the walls that stand in this stage"},
	{.name = "then", .type = KEY_CUSTOM, .absent = "nothing", .read = read_stage_then,
	 .expected = "a list of \"install_bonds\", \"zero_velocity\" and \"zero_ledger\"",
	 .doc = "what is done when it ends, in this order: install_bonds (of laws that have bonds), zero_velocity (stop all points), zero_ledger (count energies anew)"},
	END};

/* ---- outputs ---- */

static const struct scene_key probe_keys[] = {
	{.name = "name", .type = KEY_NAME, AT(scene_probe, name), .required = true, .doc = "its columns are NAME.temperature ... in the history"},
	{.name = "at", .type = KEY_CUSTOM, .unit = "m", .absent = "only with another place", .read = read_probe_where,
	 .expected = "[x, y]", .doc = "a fixed place [x, y]"},
	{.name = "material", .type = KEY_CUSTOM, .unit = "m", .absent = "only with another place", .read = read_probe_where,
	 .expected = "[x, y]", .doc = "a place [x, y] in the initial body, which moves with the material"},
	{.name = "id", .type = KEY_CUSTOM, .absent = "only with another place", .read = read_probe_where,
	 .expected = "the number of a point, 0 or more", .doc = "a point by its number, counted body by body, row by row from the lower left"},
	END};

static const struct scene_key region_keys[] = {
	{.name = "name", .type = KEY_NAME, AT(scene_region, name), .required = true,
	 .doc = "its columns are region.NAME.mass, flow, volume and temperature in the history"},
	{.name = "box", .type = KEY_CUSTOM, AT(scene_region, min), .n_offset = offsetof(struct scene_region, max), .unit = "m", .required = true, .read = read_box,
	 .expected = "[xmin, ymin, xmax, ymax]", .doc = "[xmin, ymin, xmax, ymax]"},
	END};

static const struct scene_key crack_keys[] = {
	{.name = "name", .type = KEY_NAME, AT(scene_crack, name), .required = true, .doc = "of the crack; its columns in the history are crack.NAME"},
	{.name = "at", .type = KEY_FLOATS, AT(scene_crack, at), .count = 2, .unit = "m", .required = true,
	 .doc = "where it begins, in the initial body: the end of a notch"},
	{.name = "axis", .type = KEY_FLOAT, AT(scene_crack, axis), .unit = "deg", .value = "0.0", .range = RANGE_WITHIN, .min = -360.0, .max = 360.0,
	 .doc = "direction from which its angle counts, itself from the x axis"},
	{.name = "reach", .type = KEY_FLOAT, AT(scene_crack, reach), .unit = "m", .absent = "three cells", .range = RANGE_POSITIVE,
	 .doc = "how far from there its first broken point may lie"},
	END};

static const struct scene_key inspect_keys[] = {
	{.name = "name", .type = KEY_NAME, AT(scene_inspect, name), .required = true, .doc = "of the RVE in files and pictures"},
	{.name = "at", .type = KEY_FLOATS, AT(scene_inspect, at), .count = 2, .unit = "m", .absent = "only with another place",
	 .doc = "the RVE of the point nearest to [x, y] at the start"},
	{.name = "id", .type = KEY_LONG, AT(scene_inspect, id), .absent = "only with another place", .range = RANGE_NOT_NEGATIVE,
	 .doc = "or of the point with this number"},
	{.name = "rule", .type = KEY_CHOICE, AT(scene_inspect, rule), .absent = "only with another place",
	 CHOICES("hottest", "most_sheared", "highest_pressure", "most_broken"),
	 .doc = "or whichever it is each time something is drawn or written (of equals the lowest number); no path is recorded"},
	END};

static const struct scene_key output_keys[] = {
	{.name = "history_every", .type = KEY_FLOAT, AT(scene_output, history_every), .unit = "s", .absent = "time.end / 200",
	 .range = RANGE_POSITIVE, .doc = "between rows of history.csv"},
	{.name = "snapshot_every", .type = KEY_FLOAT, AT(scene_output, snapshot_every), .unit = "s", .absent = "time.end / 20",
	 .range = RANGE_NOT_NEGATIVE, .doc = "between snapshots; 0 = none"},
	{.name = "checkpoint_every", .type = KEY_FLOAT, AT(scene_output, checkpoint_every), .unit = "s", .absent = "time.end / 10",
	 .range = RANGE_NOT_NEGATIVE, .doc = "between checkpoints; 0 = only at the end"},
	{.name = "vtk", .type = KEY_BOOL, AT(scene_output, vtk), .value = "true", .doc = "write .vtp, .vti and .pvd beside each snapshot"},
	{.name = "rve_states", .type = KEY_FLAG, AT(scene_output, rve_states_all), .value = "\"inspected\"", CHOICES("inspected", "all"),
	 .doc = "which RVE states a snapshot carries"},
	END};

static const struct scene_key image_keys[] = {
	{.name = "name", .type = KEY_NAME, AT(scene_image, name), .required = true, .doc = "of the files images/NAME_*.png"},
	{.name = "kind", .type = KEY_ENUM, AT(scene_image, kind), .value = "\"points\"", CHOICES("points", "rve"),
	 .doc = "the scene, its points drawn as the domains they own, or one RVE"},
	{.name = "field", .type = KEY_NAME, AT(scene_image, field), .required = true,
	 .doc = "a field of the points (tmdempm info lists them); of an RVE: displacement, rotation, coordination, temperature or "
			"radius"},
	{.name = "component", .type = KEY_CUSTOM, AT(scene_image, component), .value = "\"magnitude\"", .text = true, .read = read_component,
	 .expected = "\"magnitude\", x, y, xx, yy, zz or xy", .doc = "magnitude (or the scalar itself), x, y, xx, yy, zz or xy"},
	{.name = "rve", .type = KEY_NAME, AT(scene_image, rve), .absent = "only for points", .doc = "name in inspect"},
	{.name = "before", .type = KEY_BOOL, AT(scene_image, before), .value = "false",
	 .doc = "of an RVE: beside how it was at birth; wants a wide size"},
	{.name = "view", .type = KEY_FLOATS, AT(scene_image, view), .count = 4, .unit = "m", .absent = "the grid, or the RVE's cell",
	 .doc = "[xmin, ymin, xmax, ymax]"},
	{.name = "size", .type = KEY_INTS, AT(scene_image, size), .count = 2, .unit = "pixels", .value = "[1000, 800]", .range = RANGE_WITHIN,
	 .min = 16, .max = 8192, .doc = "width and height"},
	{.name = "map", .type = KEY_CHOICE, AT(scene_image, map), .value = "\"viridis\"", CHOICES("viridis", "inferno", "coolwarm"),
	 .doc = "colours; coolwarm is for signed fields"},
	{.name = "range", .type = KEY_CUSTOM, AT(scene_image, range_auto), .value = "\"auto\"", .text = true, .read = read_range,
	 .expected = "\"auto\" or [min, max]", .doc = "of the colours: auto (from the data of each image) or [min, max] in the unit shown"},
	{.name = "unit", .type = KEY_STRING, AT(scene_image, unit), .count = 16, .absent = "the field's",
	 .doc = "written at the colour bar"},
	{.name = "every", .type = KEY_FLOAT, AT(scene_image, every), .unit = "s", .absent = "output.snapshot_every", .range = RANGE_POSITIVE,
	 .doc = "between pictures"},
	END};

static const struct scene_key live_keys[] = {
	{.name = "on", .type = KEY_BOOL, AT(scene_live, on), .value = "false", .doc = "look for a listening ParaView without being told by --live"},
	{.name = "host", .type = KEY_STRING, AT(scene_live, host), .count = SCENE_NAME, .value = "\"127.0.0.1\"", .doc = "where it listens"},
	{.name = "port", .type = KEY_INT, AT(scene_live, port), .value = "22222", .range = RANGE_WITHIN, .min = 1, .max = 65534,
	 .doc = "at this port; the data goes to the next one"},
	{.name = "every", .type = KEY_INT, AT(scene_live, every), .value = "10", .range = RANGE_WITHIN, .min = 1, .max = 1000000000,
	 .doc = "steps between frames that it is offered"},
	{.name = "share", .type = KEY_FLOAT, AT(scene_live, share), .value = "0.2", .range = RANGE_WITHIN, .min = 0.0, .max = 1.0,
	 .doc = "of the run's time that this may take; beyond it frames thin out"},
	END};

static const struct scene_key catalyst_keys[] = {
	{.name = "pipelines", .type = KEY_CUSTOM, .absent = "none", .read = read_pipelines,
	 .expected = "a list of scripts: (\"../pipelines/images.py\", ...)", .doc = "scripts of ParaView Catalyst (Python), seen from this file"},
	{.name = "every", .type = KEY_FLOAT, AT(scene_catalyst, every), .unit = "s", .absent = "output.snapshot_every", .range = RANGE_POSITIVE,
	 .doc = "between frames that they get"},
	{.name = "live", .type = KEY_GROUP, AT(scene_catalyst, live), KEYS(live_keys), .doc = "a ParaView that watches the run"},
	END};

static const struct scene_key guards_keys[] = {
	{.name = "energy_residual", .type = KEY_FLOAT, AT(scene_guards, energy_residual), .value = "0.1", .range = RANGE_NOT_NEGATIVE,
	 .doc = "share of the work done that may go astray before the run is stopped; 0 = off"},
	{.name = "points_leaving", .type = KEY_BOOL, AT(scene_guards, points_leaving), .value = "true",
	 .doc = "a point that leaves the grid stops the run"},
	{.name = "energy_created", .type = KEY_FLOAT, AT(scene_guards, energy_created), .value = "0.75", .range = RANGE_NOT_NEGATIVE,
	 .doc = "share of the work done that the time integration may make of nothing before the run is stopped; 0 = off"},
	{.name = "time_step", .type = KEY_BOOL, AT(scene_guards, time_step), .value = "true",
	 .doc = "a step above the mechanical limit stops the run; false: for studies of stability only"},
	{.name = "thermal_step", .type = KEY_BOOL, AT(scene_guards, thermal_step), .value = "true",
	 .doc = "a step above the limit of heat conduction stops the run; false: for studies of stability only"},
	{.name = "dem_step", .type = KEY_BOOL, AT(scene_guards, dem_step), .value = "true",
	 .doc = "a DEM step above its limit is refused, an RVE whose discs jitter stops the run; false: for studies of stability only"},
	{.name = "numerical_fracture", .type = KEY_BOOL, AT(scene_guards, numerical_fracture), .value = "true",
	 .doc = "neighbours of an elastic body that the grid tears apart, not the law, stop the run; false: for studies of stability only"},
	END};

/* ---- the whole ---- */

static const struct scene_key root_keys[] = {
	{.name = "title", .type = KEY_STRING, AT(scene, title), .count = sizeof ((struct scene *)0)->title, .value = "\"\"",
	 .doc = "shown in pictures and reports"},
	{.name = "units", .type = KEY_GROUP, AT(scene, units), KEYS(units_keys), .doc = "everything else is in SI units"},
	{.name = "grid", .type = KEY_GROUP, AT(scene, grid), KEYS(grid_keys), .required = true, .doc = "the background grid"},
	{.name = "time", .type = KEY_GROUP, AT(scene, time), KEYS(time_keys), .required = true, .doc = "duration and steps"},
	{.name = "mpm", .type = KEY_GROUP, AT(scene, mpm), KEYS(mpm_keys), .doc = "the material point method"},
	{.name = "thermal", .type = KEY_GROUP, AT(scene, thermal), KEYS(thermal_keys), .doc = "heat"},
	{.name = "gravity", .type = KEY_FLOATS, AT(scene, gravity), .count = 2, .unit = "m/s2", .value = "[0.0, 0.0]",
	 .doc = "acceleration of gravity"},
	{.name = "laws", LIST(scene, laws, n_laws), LAW_TABLES, .absent = "none: materials bring their own", .doc = "constitutive laws"},
	{.name = "materials", LIST(scene, materials, n_materials), KEYS(material_keys), .required = true, .doc = "what bodies are made of"},
	{.name = "bodies", LIST(scene, bodies, n_bodies), KEYS(body_keys), .required = true, .doc = "regions filled with points"},
	{.name = "walls", LIST(scene, walls, n_walls), KEYS(wall_keys), .absent = "none", .doc = "rigid walls"},
	{.name = "boundaries", LIST(scene, boundaries, n_boundaries), KEYS(boundary_keys), .absent = "none",
	 .doc = "values imposed on nodes, heat fluxes"},
	{.name = "contacts", LIST(scene, contacts, n_contacts), KEYS(contact_keys), .absent = "none: bodies are welded where they meet",
	 .doc = "bodies that touch and part, rub and exchange heat"},
	{.name = "stages", LIST(scene, stages, n_stages), KEYS(stage_keys), .absent = "one stage until time.end",
	 .doc = "protocols: stages of one run, one after the other"},
	{.name = "probes", LIST(scene, probes, n_probes), KEYS(probe_keys), .absent = "none", .doc = "points recorded in history.csv"},
	{.name = "regions", LIST(scene, regions, n_regions), KEYS(region_keys), .absent = "none",
	 .doc = "boxes whose mass, flow, volume and mean temperature go to history.csv"},
	{.name = "cracks", LIST(scene, cracks, n_cracks), KEYS(crack_keys), .absent = "none",
	 .doc = "cracks whose tip, length and angle go to history.csv, with the number and size of the pieces"},
	{.name = "inspect", LIST(scene, inspect, n_inspect), KEYS(inspect_keys), .absent = "none",
	 .doc = "RVEs written to files with their path, to be drawn"},
	{.name = "output", .type = KEY_GROUP, AT(scene, output), KEYS(output_keys), .doc = "what is written, how often"},
	{.name = "images", LIST(scene, images, n_images), KEYS(image_keys), .absent = "none", .doc = "pictures drawn during the run"},
	{.name = "catalyst", .type = KEY_GROUP, AT(scene, catalyst), KEYS(catalyst_keys), .doc = "ParaView in the run: scripts, a live view"},
	{.name = "guards", .type = KEY_GROUP, AT(scene, guards), KEYS(guards_keys), .doc = "limits at which a run is stopped"},
	END};

const struct scene_table scene_root_tables[] = {{NULL, root_keys}, {NULL, NULL}};

/* clang-format on */

/* ---- looking things up ---- */

const struct scene_key *keys_find(const struct scene_key *keys, const char *name)
{
	for (; keys->name; keys++)
		if (!strcmp(keys->name, name))
			return keys;
	return NULL;
}

const struct scene_key *tables_choose(const struct scene_table *tables, const struct node *node)
{
	if (!tables || !tables->type)
		return tables ? tables->keys : NULL;
	const struct node *type = node_find(node, "type");
	for (; type && type->type == NODE_STRING && tables->keys; tables++)
		if (!strcmp(tables->type, type->string))
			return tables->keys;
	return NULL;
}

static void visit_keys(const struct scene_key *keys, const char *prefix,
					   void (*visit)(void *data, const char *path, const struct scene_key *key), void *data)
{
	for (; keys->name; keys++) {
		char path[PATH_LENGTH];
		snprintf(path, sizeof path, "%s%s", prefix, keys->name);
		visit(data, path, keys);
		size_t used = strlen(path);
		snprintf(path + used, sizeof path - used, keys->type == KEY_LIST ? ".[]." : ".");
		for (const struct scene_table *t = keys->tables; t && t->keys; t++)
			visit_keys(t->keys, path, visit, data);
	}
}

void scene_keys_visit(void (*visit)(void *data, const char *path, const struct scene_key *key), void *data)
{
	visit_keys(root_keys, "", visit, data);
}

static void append(char *text, size_t size, const char *more)
{
	size_t used = strlen(text);
	snprintf(text + used, size - used, "%s", more);
}

void scene_key_comment(const struct scene_key *key, char *text, size_t size)
{
	text[0] = '\0';
	if (key->unit) {
		append(text, size, "[");
		append(text, size, key->unit);
		append(text, size, "] ");
	}
	append(text, size, key->doc);
	for (int k = 0; key->choices && key->choices[k]; k++) {
		append(text, size, k ? ", \"" : "; one of \"");
		append(text, size, key->choices[k]);
		append(text, size, "\"");
	}
	append(text, size, key->required ? "; required" : key->value ? "; default " : key->absent ? "; if left out: " : "");
	append(text, size, key->value ? key->value : key->absent && !key->required ? key->absent : "");
}

/* ---- suggestions ---- */

static int minimum(int a, int b) { return a < b ? a : b; }

int edit_distance(const char *a, const char *b)
{
	enum { LONGEST = 120 };
	int la = (int)strlen(a), lb = (int)strlen(b), row[3][LONGEST + 1];
	if (la > LONGEST || lb > LONGEST)
		return la > lb ? la : lb;
	for (int j = 0; j <= lb; j++)
		row[0][j] = j;
	for (int i = 1; i <= la; i++) {
		int *now = row[i % 3], *up = row[(i + 2) % 3], *upper = row[(i + 1) % 3];
		now[0] = i;
		for (int j = 1; j <= lb; j++) {
			now[j] = minimum(minimum(up[j], now[j - 1]) + 1, up[j - 1] + (a[i - 1] != b[j - 1]));
			if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
				now[j] = minimum(now[j], upper[j - 2] + 1);
		}
	}
	return row[la % 3][lb];
}

struct search {
	char plain[PATH_LENGTH]; /* the path looked for, indices emptied */
	const char *last;        /* its last component */
	int best;
	char *nearest;
};

static void consider(void *data, const char *path, const struct scene_key *key)
{
	struct search *search = data;
	int distance = 2 * edit_distance(search->plain, path);
	if (!strcmp(search->last, key->name)) /* the right word in the wrong place */
		distance -= distance / 2;
	if (distance < search->best) {
		search->best = distance;
		snprintf(search->nearest, PATH_LENGTH, "%s", path);
	}
}

void keys_nearest(const struct scene_key *keys, const char *path, char *nearest)
{
	struct search search = {.best = 1 << 20, .nearest = nearest};
	size_t n = 0;
	for (const char *at = path; *at && n + 2 < sizeof search.plain; at++) {
		search.plain[n++] = *at;
		if (*at == '[')
			while (at[1] && at[1] != ']')
				at++;
	}
	search.plain[n] = '\0';
	const char *dot = strrchr(search.plain, '.');
	search.last = dot ? dot + 1 : search.plain;
	nearest[0] = '\0';
	visit_keys(keys, "", consider, &search);
}
