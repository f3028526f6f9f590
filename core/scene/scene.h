/* The scene: everything that a scenario file says, validated, in SI units and kelvin.
 *
 * scene_load() reads a libconfig file (with `base`/`set` variants, `@include`, `--set` overrides),
 * checks it whole and returns plain data; nothing else in the program sees libconfig.  Every key with
 * its default, unit and meaning stands in scenarios/reference.cfg; the table that drives both the
 * parser and the checks is in keys.c.
 *
 * Quantities that a scene may leave out are NAN (doubles) or stated otherwise beside the field. */
#ifndef TMDEMPM_SCENE_SCENE_H
#define TMDEMPM_SCENE_SCENE_H

#include <stdbool.h>
#include <stddef.h>

#include "exact/exact.h"
#include "mpm/scheme.h"

enum { SCENE_NAME = 64, SCENE_PATH = 1024 };

/* Where in which file a thing was said, for messages that can only be given later. */
struct scene_place {
	const char *file; /* owned by the scene; "--set path=value" for an override */
	int line;         /* 0 for an override */
};

/* What changes in time: rows of (s, value), linear between them, held before the first and behind the last. */
struct scene_series {
	int n;             /* 0 = there is none */
	double (*rows)[2]; /* times strictly increase */
};

struct scene_units {
	bool celsius; /* the scene speaks in degrees Celsius; inside, everything is kelvin */
};

struct scene_grid {
	double origin[2]; /* m, lower left node */
	double size[2];   /* m, a whole number of cells */
	double cell;      /* m, square cells */
	double thickness; /* m out of plane, default 1 */
	bool follows;     /* the grid is stretched with a moving wall: see mpm/grid.c */
	int follow;       /* that wall's index */
	double fixed[2];  /* m, the place that stays where it is then; default the origin */
};

struct scene_time {
	double end;         /* s */
	double step;        /* s, fixed */
	double step_factor; /* b of eq. 30: a step above b h sqrt(rho/M) is refused; default 1 */
	int thermal_steps;  /* > 1: thermal sub-steps in each mechanical step; default 1 */
	int thermal_every;  /* > 1: one thermal step every so many mechanical steps; default 1 */
};

struct scene_mpm {
	char shape[SCENE_NAME]; /* "ugimp" (default), "linear", "cpdi": names of the table shapes[] */
	enum mpm_transfer transfer;
	enum mpm_order order;
	int xpic_order;            /* m of XPIC(m), FMPM(m); default 2 */
	int xpic_every;            /* they act in every k-th step, the others are plain FLIP; default 1 */
	double pic_fraction;       /* alpha_PIC, fraction per step, eqs. 25-27, of the steps that are FLIP; default 0 */
	double damping_particle;   /* alpha_p, 1/s; default 0 */
	double damping_grid;       /* alpha_g, 1/s; default 0 */
	int contact_fields;        /* extra fields of nodes at which bodies meet; 0 = one for each node */
	double confining_pressure; /* Pa; sigma + p_c I in the internal force (methods-mpm); default 0 */
};

struct scene_thermal {
	bool on;            /* default: true if anything in the scene needs heat; false = no thermal pass */
	bool friction_heat; /* RVE friction heats the points; default true */
	double time_scale;  /* conduction, fluxes and convection run so many times faster than the rest; default 1 */
};

/* ---- laws ---- */

enum scene_law_type { SCENE_LAW_THERMOELASTIC, SCENE_LAW_RVE, SCENE_LAW_RANKINE };
extern const char *const scene_law_type_names[]; /* in the order of the enum, NULL-terminated */

struct scene_law_thermoelastic {
	double young;      /* Pa */
	double poisson;    /* - */
	double expansion;  /* 1/K, linear */
	bool plane_stress; /* default false: plane strain */
	bool neo_hookean;  /* default false: hencky */
};

/* Neo-Hookean thermoelasticity that breaks by Rankine's criterion: law/neohookean_rankine.c. */
struct scene_law_rankine {
	double young, poisson, expansion; /* Pa, -, 1/K */
	double strength;                  /* Pa, tensile; the mean where it is scattered */
	double fracture_energy;           /* J/m2 */
	bool unilateral;                  /* default false: damage takes compression with it too */
	bool projected;                   /* length of the band from the crack's direction; default false: cell sqrt(2) */
	double heat_share;                /* chi, of the fracture energy that becomes heat; default 1 */
	double weibull;                   /* modulus of the scatter of the strength; 0 = none (default) */
	unsigned seed;
	double cell;                      /* m, the grid's */
};

/* How to make (or where to find) the packing of an RVE law; see rve/packing.h. */
struct scene_packing {
	char file[SCENE_PATH];         /* .h5 or .csv, resolved relative to the scene's file; "" = generate */
	char lattice[SCENE_NAME];      /* "" = random; "square" = noise-free square lattice */
	int discs;                     /* 400 */
	double radius_min, radius_max; /* m, uniform; 0.25e-3, 0.5e-3 */
	double pressure;               /* Pa, isotropic consolidation */
	double mu;                     /* friction during consolidation */
	double void_ratio;             /* NAN, or the target (mu found by bisection) */
	unsigned seed;                 /* 1 */
};

/* Bonds between the discs of an RVE law (eqs. 38 to 40); a stage installs them. */
struct scene_bonds {
	double strength;  /* beta_s: a bond bears beta_s kn R, R the mean radius of its discs; 0 = none (default) */
	double mu;        /* mu_b: and mu_b times that in shear; 0.5 */
	double melting;   /* T_c, K: above it all bonds break; infinity = never (default) */
	bool linear;      /* the strength falls linearly from `reference` to T_c; default false: it is whole up to T_c */
	double reference; /* K; at and below it the strength of linear softening is whole; default 0 C */
};

enum scene_rve_path { SCENE_RVE_AUTO, SCENE_RVE_SERIAL, SCENE_RVE_SIMD, SCENE_RVE_SINGLE };
/* What is not computed; see law/twins.h. */
struct scene_economy {
	bool twins; /* RVEs that are equal bit for bit are computed once; true */
	struct scene_pace {
		double stress;     /* Pa; 0 = off */
		double calm;       /* 1 = off */
		double unbalanced; /* 0.02 */
		double sliding;    /* 0.05 */
	} pace;
	struct scene_quiet {
		double change;     /* of the stress / pressure, up to which discs wait; 0 = they never do */
		double strain;     /* and up to this strain; 1e-4 */
		double unbalanced; /* and only below this unbalanced force; 0.02 */
	} quiet;
};

struct scene_law_rve {
	struct scene_packing packing;
	struct scene_bonds bonds;
	enum scene_rve_path path; /* auto */
	struct scene_economy economy;
	double kn, ks;          /* N/m; 1e6 each */
	double mu;              /* 0.5 */
	double damping_ratio;   /* zeta; 0.2 */
	double grain_density;   /* kg/m3; 2650 */
	double disc_thickness;  /* z, m; 0.075 */
	double expansion;       /* beta, 1/K; 1e-4 */
	double resistance;      /* kappa, K/(W m); 1e4 */
	double step_factor;     /* dt_DEM = factor sqrt(m_min/kn); 0.4 */
	double strain_per_step; /* deps_max at 100 kPa; 5e-5 */
	bool pressure_scaling;  /* deps = deps_max min(1, sqrt(p/100 kPa)), >= deps_max/10; true */
	int n_max;              /* 20; 0 = no clamp */
	double skin;            /* Verlet skin / r_max; 0.2 */
	bool gas;               /* free-flying points cost nothing; true */
	double gas_pressure;    /* 20 Pa */
	double gas_stretch;     /* 1.12 */
	double overlap_max;     /* guard: overlap / smaller radius; 0.5 */
	bool step_guard;        /* guards.dem_step */
};

struct scene_law {
	char name[SCENE_NAME];
	enum scene_law_type type;
	struct scene_law_thermoelastic thermoelastic;
	struct scene_law_rve rve;
	struct scene_law_rankine rankine;
	struct scene_place place;
};

struct scene_material {
	char name[SCENE_NAME];
	int law;                      /* index into laws */
	double density;               /* bulk, kg/m3; NAN = from the RVE: grain density / (1 + e) */
	double heat_capacity;         /* J/(kg K); NAN where there is no heat */
	double conductivity;          /* W/(m K); NAN = from the law */
	double reference_temperature; /* K, where thermal strain is zero; NAN = the point's temperature at birth */
	double freezing[2];           /* K: frozen at and below the first, thawed at and above the second; NAN = neither */
	double latent_heat;           /* J/kg, from frozen to thawed; 0 */
	double heat_capacity_frozen;  /* J/(kg K); heat_capacity */
	double conductivity_frozen;   /* W/(m K); NAN = as thawed */
	struct scene_place place;
};

/* ---- bodies ---- */

struct scene_layer {
	double top; /* m, upper y of this layer; layers from the bottom up */
	int material;
	double temperature; /* K */
};

/* A motion of the table of exact solutions (exact/exact.h) that a body is born with and, by a body force, follows. */
struct scene_motion {
	const struct exact_solution *solution;   /* one with motion(); NULL = none */
	double parameters[EXACT_PARAMETERS_MAX]; /* its defaults and what was said */
	bool force;                              /* default true; false: born with the motion, then free */
};

/* A region drawn in an image: pixel (i, j) of row j from the bottom covers origin + (i .. i + 1, j .. j + 1) pixel. */
struct scene_mask {
	char file[SCENE_PATH]; /* "" = none */
	int nx, ny;
	unsigned char *inside; /* [ny][nx]; NULL = no mask */
	double pixel;          /* m */
	double origin[2];      /* m, of the lower left corner */
	int level[2];          /* grey values that belong to the region */
};

struct scene_body {
	char name[SCENE_NAME];
	int material;
	int n_vertices;           /* a box is given as its 4 vertices, a circle as corners on it */
	double (*vertices)[2];    /* m, counter-clockwise after loading */
	struct scene_mask mask;
	double centre[2];         /* m, of a disc or ring */
	double radius, hole;      /* m; radius 0 = a polygon; hole 0 = a disc */
	int n_cuts;
	struct scene_body *cuts;  /* regions taken out of it: only their shapes count */
	double angle;             /* rad, by which shape and lattice have been turned about the pivot; 0 */
	double pivot[2];          /* m */
	double lattice_origin[2]; /* m; NAN = the grid's origin: points sit at (i + 1/2) cell/side from here, before the turn */
	int points_per_cell;      /* 1, 4, 9, 16 */
	double temperature;       /* K */
	double temperature_gradient[2]; /* K/m, added to the temperatures of the body and its layers; 0 */
	double temperature_at[2];       /* m, where those hold */
	double velocity[2];       /* m/s; without a motion */
	bool drives;              /* a velocity is imposed on the nodes that its points touch */
	double drive[2];          /* m/s, that; NAN = free */
	double drive_ramp;        /* s, over which it rises from nothing; 0 */
	struct scene_motion motion;
	int variants;             /* packings with seeds seed .. seed+n-1 dealt out in turn; 1 */
	int n_layers;
	struct scene_layer *layers; /* empty: one material */
	struct scene_place place;
};

/* ---- walls: rigid, nodal, unilateral (methods-mpm, Boundaries) ---- */

enum scene_wall_shape { SCENE_WALL_LINE, SCENE_WALL_POLYGON };
enum scene_wall_contact {
	SCENE_WALL_FRICTIONAL, /* unilateral with Coulomb friction */
	SCENE_WALL_SLIP,       /* normal velocity tied both ways, tangent free */
	SCENE_WALL_STICK,      /* both components tied */
	SCENE_WALL_PENALTY     /* pushes points that have come through it; a line, without friction */
};

struct scene_wall {
	char name[SCENE_NAME];
	enum scene_wall_shape shape; /* boxes and wedges are loaded as polygons */
	int n_vertices;
	double (*vertices)[2]; /* m; a line's solid lies on the right of first -> second; a polygon's inside (CCW) */
	double depth;          /* m, of a line's solid behind it; default 2 cells */
	enum scene_wall_contact contact;
	double stiffness;   /* of a penalty wall: pressure per depth over P-wave modulus / cell; 20 */
	double friction;    /* 0 */
	double velocity[2]; /* m/s; the wall moves with it */
	double temperature; /* K; NAN = insulating, or by the table */
	struct scene_series temperature_table; /* K */
	double heat_share;  /* share of wall friction that heats the material; 0..1, default 0 */
	double from, until; /* s; active in [from, until); 0, infinity */
	bool active;        /* true: a wall with `active = false` is left out of the loaded scene */
	struct scene_place place;
};

/* A surface among its surroundings: heat of coefficient (ambient - T) per area. */
struct scene_convection {
	double coefficient; /* W/(m2 K); NAN = none */
	double ambient;     /* K; NAN = by the table */
	struct scene_series ambient_table; /* K */
};

/* Values imposed on nodes (velocity, temperature), or heat brought to points, inside a box. */
struct scene_boundary {
	char name[SCENE_NAME];
	double min[2], max[2]; /* m, a box; nodes within 1e-9 cell of it count */
	double velocity[2];    /* m/s, each NAN = free */
	double traction[2];    /* Pa, on the points that begin in the box, dead load; each NAN = none */
	double temperature;    /* K; NAN = free, or by the table */
	struct scene_series temperature_table; /* K */
	double flux;           /* W/m2 into the material; NAN = none, or by the table */
	struct scene_series flux_table; /* W/m2 */
	struct scene_convection convection;
	double layer;          /* m, thickness over which heat or traction enters (virtual layer, eq. 10); default one cell */
	double from, until;    /* s */
	struct scene_place place;
};

/* ---- contacts between bodies (DP-MPM): without one they are welded where they meet ---- */

struct scene_contact {
	int n_bodies;                /* 2; 1: the faces of its own cracks; 0: all pairs that no other contact names */
	int bodies[2];
	bool cracks;                 /* also the faces of cracks in each of the bodies; false */
	double friction;             /* 0 */
	double softening[2];         /* K: at which friction holds, and at which none is left; NAN = it does not fall */
	double heat_share;           /* share of the friction work that heats the bodies, half each; 1 */
	double conductance;          /* W/(m2 K) at conductance_pressure; 0 */
	double conductance_pressure; /* Pa; 1e6 */
	double conductance_exponent; /* 1 */
	struct scene_place place;
};

/* ---- stages ---- */

struct scene_stage {
	char name[SCENE_NAME];
	double duration; /* s; the last may be infinite (until time.end) */
	double damping;  /* 1/s, added to the particle damping */
	int n_walls;     /* -1 = all walls; else only these (within their from/until) */
	int *walls;
	bool then_install_bonds, then_zero_velocity, then_zero_ledger; /* `then = [...]`, done in this order when it ends */
	struct scene_place place;
};

/* ---- what is recorded ---- */

enum scene_probe_kind { SCENE_PROBE_ID, SCENE_PROBE_AT, SCENE_PROBE_MATERIAL };

struct scene_probe {
	char name[SCENE_NAME];
	enum scene_probe_kind kind;
	long id;      /* SCENE_PROBE_ID: the point's id */
	double at[2]; /* m: fixed place (AT), or place in the initial body (MATERIAL) */
	struct scene_place place;
};

struct scene_region {
	char name[SCENE_NAME];
	double min[2], max[2]; /* m */
	struct scene_place place;
};

/* A crack to be followed: from where it begins. */
struct scene_crack {
	char name[SCENE_NAME];
	double at[2]; /* m, in the initial body */
	double axis;  /* deg, direction from which its angle counts */
	double reach; /* m, how far from there its first broken point may lie; default three cells */
	struct scene_place place;
};

/* An RVE to be watched: written to files, its path recorded, drawn. */
struct scene_inspect {
	char name[SCENE_NAME];
	long id; /* -1 = nearest to `at` in the initial body */
	double at[2];
	char rule[SCENE_NAME]; /* "" = a fixed point; else a name of rve_rules (run/rules.h), which chooses it anew */
	struct scene_place place;
};

struct scene_output {
	double history_every;    /* s of simulated time; default end/200 */
	double snapshot_every;   /* s; default end/20; 0 = none */
	double checkpoint_every; /* s of simulated time; default end/10; 0 = only at the end */
	bool vtk;                /* .vtp/.vti/.pvd beside each snapshot; true */
	bool rve_states_all;     /* output.rve_states = "all"; default "inspected" */
};

enum scene_image_kind { SCENE_IMAGE_POINTS, SCENE_IMAGE_RVE };

struct scene_image {
	char name[SCENE_NAME];
	enum scene_image_kind kind;
	char field[SCENE_NAME]; /* a name of the field table; RVE: "displacement", "rotation", "coordination", "radius" */
	int component;          /* -1 = magnitude (or the scalar itself), else 0.. */
	char rve[SCENE_NAME];   /* name in `inspect` */
	bool before;            /* RVE: a second picture on the left, at birth */
	double view[4];         /* m: xmin ymin xmax ymax; NAN = the grid */
	int size[2];            /* pixels */
	char map[SCENE_NAME];   /* "viridis", "inferno", "coolwarm" (diverging) */
	bool range_auto;        /* true: from the data at each image */
	double range[2];        /* in the scene's unit */
	char unit[SCENE_NAME];  /* "" = the field's */
	double every;           /* s; default output.snapshot_every */
	struct scene_place place;
};

struct scene_live {
	bool on;               /* false: only with --live */
	char host[SCENE_NAME]; /* where a ParaView listens */
	int port;              /* and the next one, for the data */
	int every;             /* steps between frames */
	double share;          /* of the run's time that the viewer may take */
};

struct scene_catalyst {
	int n_pipelines;
	char **pipelines; /* absolute paths of scripts */
	double every;     /* s between frames for them; default output.snapshot_every */
	struct scene_live live;
};

struct scene_guards {
	double energy_residual; /* share of the work done that the residual may reach; 0 = off; default 0.1 */
	double energy_created;  /* share of the work done that the time integration may make of nothing; 0 = off; default 0.75 */
	bool points_leaving;    /* true: a point leaving the grid stops the run */
	bool time_step, thermal_step; /* true: steps above the limits of mechanics and heat conduction stop the run */
	bool dem_step;          /* true: a DEM step above its limit is refused, an RVE whose discs jitter stops the run */
	bool numerical_fracture; /* true: neighbours of an elastic body that the grid tears apart stop the run */
};

struct scene {
	char path[SCENE_PATH]; /* the file as given */
	char *text;            /* the scene as it was read, bases and overrides applied: valid libconfig */
	char title[256];
	struct scene_units units;
	struct scene_grid grid;
	struct scene_time time;
	struct scene_mpm mpm;
	struct scene_thermal thermal;
	double gravity[2]; /* m/s2 */
	int n_laws, n_materials, n_bodies, n_walls, n_boundaries, n_stages;
	struct scene_law *laws;
	struct scene_material *materials;
	struct scene_body *bodies;
	struct scene_wall *walls;
	struct scene_boundary *boundaries;
	struct scene_stage *stages;
	int n_contacts;
	struct scene_contact *contacts;
	int n_probes, n_regions, n_cracks, n_inspect, n_images;
	struct scene_probe *probes;
	struct scene_region *regions;
	struct scene_crack *cracks;
	struct scene_inspect *inspect;
	struct scene_image *images;
	struct scene_output output;
	struct scene_catalyst catalyst;
	struct scene_guards guards;
	void *storage; /* private: strings and arrays live here */
};

/* Reads and checks a scene.  `sets` are n `path=value` overrides, applied last, in order.
 * On failure returns STATUS_INPUT and leaves *scene NULL; all messages (one a line,
 * `file:line: what is wrong, expected what`) have been written to `errors` (a FILE *).
 * STATUS_RESOURCE if a file cannot be read. */
int scene_load(struct scene **scene, const char *path, int n_sets, const char *const *sets, void *errors);

void scene_free(struct scene *scene);

/* Where the face of the wall that the grid follows stands at the start along x (c = 0) or y (1), m: its side nearest to
 * grid.fixed. */
double scene_grid_face(const struct scene *scene, int c);

/* Distance between a body's lattice points, m: cell / sqrt(points_per_cell). */
double scene_body_spacing(const struct scene *scene, const struct scene_body *body);

/* Where that lattice begins, m: its points lie at origin + (i + 1/2, j + 1/2) spacing. */
void scene_body_lattice(const struct scene *scene, const struct scene_body *body, double origin[2]);

/* Turns a place with the body (direction 1), or back (-1). */
void scene_body_turn(const struct scene_body *body, double direction, double x[2]);

/* Is x inside of the body and further than `tolerance` (m) from its outline, or, if that is negative, at most so far
 * outside? */
bool scene_body_contains(const struct scene_body *body, const double x[2], double tolerance);

/* The points of a body: places origin + (i + 1/2, j + 1/2) spacing, turned with it, that lie strictly inside its outline
 * and outside of its cuts (a point on an edge, within 1e-6 of the spacing, does not count), row by row from the bottom, each row
 * from the left: the order of birth, which numbers the points' ids body after body.  The caller frees *x
 * (n entries, m; NULL if none).  STATUS_INPUT for an absurd count, STATUS_RESOURCE for lack of memory. */
int scene_body_points(const struct scene *scene, const struct scene_body *body, double (**x)[2], int *n);

/* What the temperature gradient of a body adds at a place, K. */
double scene_body_warming(const struct scene_body *body, const double x[2]);

/* Index of the layer in which height y lies (the top one above all), -1 without layers. */
int scene_body_layer(const struct scene_body *body, double y);

/* A constant, unless the series has rows: then its value at this time, s. */
double scene_value_at(double constant, const struct scene_series *series, double time);

bool scene_wall_heats(const struct scene_wall *wall);                     /* imposes a temperature on nodes */
bool scene_boundary_heats_nodes(const struct scene_boundary *boundary);   /* the same */
bool scene_boundary_heats_points(const struct scene_boundary *boundary);  /* by a flux or convection */
bool scene_boundary_loads_points(const struct scene_boundary *boundary);  /* by a traction */

/* Are there contact pressures at points: of contacts between bodies or of penalty walls? */
bool scene_presses(const struct scene *scene);

/* K -> the scene's unit, and back. */
double scene_temperature_out(const struct scene *scene, double kelvin);
double scene_temperature_in(const struct scene *scene, double value);

/* "C" or "K". */
const char *scene_temperature_unit(const struct scene *scene);

#endif
