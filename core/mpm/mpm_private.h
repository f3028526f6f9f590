/* What the files of core/mpm share among themselves (and with their own tests).
 *
 * Same bits for any number of threads: points are listed by grid cell (order[]), rows of grid cells are
 * grouped in stripes of STRIPE_ROWS; stripes of one parity touch no node in common, so all even stripes
 * add to the grid at once, then all odd ones, each in its own fixed order.  Every sum is made of partial
 * sums over fixed pieces (stripes, blocks of points, rows of nodes) that are then added up in turn. */
#ifndef TMDEMPM_MPM_PRIVATE_H
#define TMDEMPM_MPM_PRIVATE_H

#include <math.h>

#include "contact/contact.h"
#include "mpm/kernel.h"
#include "mpm/mpm.h"
#include "mpm/shape.h"

enum {
	STRIPE_ROWS = 4,       /* rows of grid cells; more than 2 reach + 1, so that equal parities never meet */
	BLOCK_POINTS = 256,    /* points in one piece of the way back from the grid */
	RESORT_STEPS = 64,     /* storage follows the order by cells every so many steps, counted from step 0 */
	GHOST_CELLS = 1,       /* grid cells beyond the scene's box, for domains that reach over its edge */
	WALL_SWEEPS = 4,       /* over the walls of a node that feels several */
	RESIDUAL_STEPS = 100,  /* the energy ledger is judged at least every so many steps */
	PARALLEL_POINTS = 4096 /* below this a pass is too short to wake other threads for it */
};

/* What points add to a node; one cache line. */
struct node_sum {
	double momentum[2]; /* kg m/s */
	double force[2];    /* N, internal: - sum V sigma grad w */
	double mass;        /* kg */
	double capacity;    /* J/K */
	double heat;        /* J: sum m c T w */
	double flow;        /* W: heat flow and sources into the node */
} __attribute__((aligned(64)));

/* Partial results of one stripe on the way to the grid. */
struct stripe_sum {
	double stiffness;             /* max of M / rho, m2/s2 */
	double diffusivity;           /* max of k / (rho c), m2/s */
	int stiffest, most_diffusive; /* storage index, -1 = none */
	int bad;                      /* storage index of the first point with a non-finite stress, -1 */
	double power;                 /* W, sum V sigma : L with the L in which the points strained last */
	double heat_given;            /* J, of the laws */
	double heat_in, heat_out;     /* J, through boundaries with a flux or convection */
};

/* Partial results of one block of points on the way back. */
struct block_sum {
	double increment; /* sum m |S dv|^2, J */
	double damped;    /* sum m (v_flip . d + |d|^2 / 2), J */
	double carried;   /* sum m v . S dv, J; of APIC only */
	double push[2];   /* sum m (2 x' - 2 S v - S dv) with x' the rate at which the point moves, kg m/s */
	double discarded; /* J, kinetic energy of parked points */
	int bad, left;    /* storage index of the first non-finite point, of the first that left the grid; -1 */
};

/* Partial results of one row of nodes. */
struct row_sum {
	double increment;                    /* sum m |dv|^2, J */
	double carried;                      /* sum m v.dv, J; of APIC only */
	double power;                        /* W, of the internal forces on the nodes, see ledger.c */
	double gravity, confining;           /* J, work of gravity and of the confining pressure */
	double motion;                       /* J, work of the body force of motions */
	double velocity_work, velocity_loss; /* J, of imposed velocities */
};

/* What a node needs where velocities go between points and nodes beside the step itself; one cache line. */
struct node_projection {
	double sum[2];    /* m/s, of XPIC and FMPM: goes to the points */
	double term[2];   /* m/s, of their series */
	double back[2];   /* kg m/s, momentum that comes from the points */
	double strain[2]; /* m/s, USF and MUSL: from which the points strain */
} __attribute__((aligned(64)));

/* The same of the thermal pass. */
struct heat_sum {
	double in, out; /* J, at imposed temperatures of boundaries and walls */
	double walls;   /* J, wall friction handed to the material */
};

/* The solid of a wall where it is now: a polygon, counter-clockwise, and the box around it; m. */
struct wall_solid {
	int n;
	double (*v)[2];
	double low[2], high[2];
};

/* One contact of a node with a wall: normals point into the material.  With two normals (a convex corner
 * of the wall) the node is blocked only if it moves against both. */
struct wall_node {
	int node, wall;
	int normals;
	double normal[2][2];
};

/* What the contact did in this step: velocity changes of the node, m/s. */
struct wall_effect {
	double normal[2];                  /* unit vector that acted */
	double push, drag;                 /* along the normal, along the tangent (normal turned by +90 degrees) */
	double impulse[2];                 /* kg m/s, on the material */
	double boundary, friction, impact; /* J */
};

/* What the points that touch a node bring to the limit of the step: see limit.c.  First sums, then over mass (1/s2) and
 * heat capacity (1/s). */
struct limit_node {
	double motion[2], heat[2];
};

/* And of a point: weight of each direction, (dt w)^2 / b^2. */
struct limit_point {
	double weight[2], X;
};

/* Largest values of the last look, and the points that have them (storage index, -1 = none). */
struct limit_sum {
	double motion; /* (dt w)^2 / b^2: stable below 2 */
	double heat;   /* dt times the largest rate of a pass of heat conduction: stable below 2 */
	double growth; /* ln of the stress's growth */
	int stiffest, hottest, grown;
};

/* Sums since the start (or zero_ledger); saved with the state. */
struct mpm_sums {
	double work_boundary, work_boundary_turnover; /* J; turnover: absolute values per step */
	double work_walls_friction;
	double loss_numerical, discarded;
	double heat_in, heat_out, heat_given, heat_walls;
	double start_kinetic, start_elastic, start_rve_kinetic, start_gravity, start_thermal; /* J */
	double start_step;
	double work_gravity;
	double scale;         /* J, most work done so far: what the residual is compared with */
	double loss_most;     /* J, largest loss_numerical so far: what has come back since was made of nothing */
	double limit_watched; /* 1: the next step is looked at, the limit is near or may have moved */
	double work_contact_friction, loss_contact, heat_contacts;
};

/* How a material freezes.  Specific enthalpy J/kg, counted from all frozen at `low`: linear below, through the
 * interval (even one without width) and above. */
struct freezing {
	bool on;
	double low, high;      /* K */
	double frozen, thawed; /* J/(kg K), sensible heat capacity */
	double all;            /* J/kg, enthalpy at which all is thawed: sensible heat of the interval + latent heat */
	double conductivity;   /* W/(m K) when frozen; NAN = as thawed */
};

/* Heat brought to the points of a box, as it is in this step. */
struct point_heat {
	const struct scene_boundary *boundary;
	bool on;
	double flux;                 /* W/m2 */
	double coefficient, ambient; /* W/(m2 K), K; 0 without convection */
};

struct contact; /* contact/private.h */
struct penalty; /* contact/penalty.c */

struct mpm_work {
	struct contact *contact; /* NULL: one field at every node */
	struct penalty *penalty; /* contact/penalty.c; NULL: no wall of this kind */
	size_t n_nodes;          /* entries of an array by node: the grid's, and behind them room for extra fields */
	const struct mpm_kernel *kernel;
	int n_rows;              /* of nodes now: the grid's, and behind them those of extra fields, nx slots a row */
	struct shape_grid shape_grid;
	struct shape_points shape_points;
	double *half;                      /* by body: half a point's domain over h */
	double (*edge)[4];                 /* by body: both edges of it, m */
	int *law_start;                    /* n_laws + 1: the points of law l are stored from law_start[l] on */
	char (*law_names)[SCENE_NAME + 8]; /* "laws/NAME", of the states in the checkpoint */
	int *law_of_scene;                 /* scene law -> index in mpm->laws, -1 = has no points */
	double *conductivity;              /* by material: W/(m K), NAN = from the law */
	struct freezing *freezing;         /* by material */
	bool freezes;                      /* some material does */
	double *start_warming;             /* K, by id: see mpm_start_warming(); NULL = none */

	/* order by cells */
	int cells_x, cells_y;
	int *cell;       /* of each point; -1 = parked outside */
	int *order;      /* storage indices by cell */
	int *cell_first; /* cells + 1 */
	int n_inside;
	int *row_low, *row_high; /* by row of nodes: columns in use, low > high = none */
	int n_stripes, n_blocks;
	void *scratch; /* of the largest column of the points */
	int *permutation;

	struct node_sum *sums;
	double (*confining)[2];  /* m2: sum V grad w; NULL without confining pressure */
	double (*body_force)[2]; /* N, by node, of bodies that follow a motion, of tractions and penalty walls; NULL = none */
	bool *seen;              /* by node, of a walk over the nodes beside a wall; NULL without confining pressure */
	double *wall_heat;       /* J, by node: wall friction heat that waits for the thermal step; NULL = none */
	double *fixed_T;         /* K, by node: imposed temperature, NAN = free; NULL without heat */
	bool imposes_T;          /* some node has an imposed temperature */
	int *fixed_T_wall;       /* by node: the wall that imposes it, -1 = a boundary */
	double *fixed_lift;      /* J, by node: sum m c w grad T.(x_I - x_p) where the temperature is imposed */
	double *fixed_heat;      /* J, by node: heat that the imposed temperature cost in this step */
	double (*fixed_v)[2];    /* m/s, by node: imposed velocity, NAN = free; NULL = none */
	double (*fixed_push)[2]; /* kg m/s, by node: what imposing it cost in this step */
	bool *boundary_on;       /* by scene boundary, at the last look */
	double *boundary_T;      /* K, by scene boundary: imposed in this step, NAN = free */
	double *wall_T;          /* K, by scene wall: the same, NAN = insulating */
	bool boundaries_stale;   /* the walls have changed since then */
	bool drives;             /* a body imposes its velocity on nodes */
	int n_point_heats;
	struct point_heat *point_heats; /* the boundaries with a flux or convection */

	int n_wall_nodes, wall_node_capacity, n_wall_groups;
	int n_grid_wall_nodes, n_grid_wall_groups; /* of these, those at nodes of the grid; the others at extra fields */
	struct wall_node *wall_nodes; /* by node, then wall */
	struct wall_effect *wall_effects;
	int *wall_group;           /* n_wall_groups + 1: the entries of one node */
	bool *wall_on;             /* by scene wall, at the last look */
	struct wall_solid *solids; /* by scene wall */
	double (*wall_found)[2];   /* offset at which its nodes were found */

	struct limit_node *limit_nodes; /* NULL = no guard asks for it */
	struct limit_point *limit_points;
	struct limit_sum *limit_sums, limit; /* by stripe; of all, at the last look */
	int (*neighbours)[2];                /* by id: to the right and above on the lattice of the body, -1 = none */
	int *storage_of;                     /* by id; filled when it is needed */

	struct stripe_sum *stripe_sums;
	struct block_sum *block_sums;
	struct row_sum *row_sums;
	struct heat_sum *heat_sums;
	struct mpm_sums total;
	double alpha_p, alpha_g, alpha_pic; /* as fractions of this step */
	bool filtered;                      /* XPIC or FMPM act in this step */
	bool filters_step;                  /* FMPM: they act on the velocities after the step */
	struct node_projection *projected;  /* NULL if nothing needs it */
	double (*way)[2];                   /* m, MUSL: by how much points will move when they have strained; else NULL */
	double *strain_power;               /* W, by block, USF and MUSL: of the old stress on the strain rate; else NULL */
	double thermal_dt;                  /* s of thermal time, of this step's thermal pass; 0 = none in this step */

	double internal_force_scale; /* 1; a test plants an error here to see the residual guard fire */
	char residual_message[256];  /* set by mpm_measure() when the residual is beyond its bound */
};

static inline struct mpm_work *mpm_work(const struct mpm *mpm) { return mpm->work; }
static inline bool mpm_parallel(const struct mpm *mpm) { return mpm->p.n >= PARALLEL_POINTS; }

/* Fills the lists of n points. */
static inline void mpm_lists(const struct mpm *mpm, int n, const int *point, struct shape_lists *lists)
{
	const struct mpm_work *w = mpm_work(mpm);
	w->kernel->fill[mpm->shape->number](&w->shape_grid, &w->shape_points, n, point, lists);
	if (w->contact)
		contact_redirect(mpm, n, point, lists);
}

/* The grid's node of an entry of a list: the same, or that in whose place an extra field stands. */
static inline int mpm_home(const struct mpm *mpm, int node)
{
	return mpm_work(mpm)->contact ? contact_home(mpm, node) : node;
}

/* The points of a stripe: order[first .. last - 1]. */
static inline void mpm_stripe_points(const struct mpm_work *w, int stripe, int *first, int *last)
{
	int from = stripe * STRIPE_ROWS, to = from + STRIPE_ROWS < w->cells_y ? from + STRIPE_ROWS : w->cells_y;
	*first = w->cell_first[from * w->cells_x];
	*last = w->cell_first[to * w->cells_x];
}

/* Conductivity xx yy xy of a point, W/(m K): the material's or the law's; of frozen and thawed by their shares. */
static inline void mpm_point_conductivity(const struct mpm *mpm, int p, double conductivity[3])
{
	const struct mpm_work *w = mpm_work(mpm);
	int material = mpm->p.material[p];
	double k = w->conductivity[material];
	const double *law = mpm->p.conductivity[p];
	conductivity[0] = isnan(k) ? law[0] : k;
	conductivity[1] = isnan(k) ? law[1] : k;
	conductivity[2] = isnan(k) ? law[2] : 0.0;
	double frozen = w->freezes ? w->freezing[material].conductivity : NAN, thawed = mpm->p.thawed[p];
	if (isnan(frozen))
		return;
	for (int c = 0; c < 3; c++)
		conductivity[c] = thawed * conductivity[c] + (1.0 - thawed) * (c < 2 ? frozen : 0.0);
}

/* ---- particles.c ---- */
int particles_create(struct particles *p, int n, bool affine, bool damage, bool contacts, bool pressure);
void particles_free(struct particles *p);
/* New storage index k gets what was at permutation[k]. */
void particles_permute(struct particles *p, const int *permutation, void *scratch);
size_t particles_bytes(const struct particles *p);
size_t particles_widest(void);
/* Takes a point's motion away. */
void point_stop(struct particles *p, int k);
/* Appends the columns to the list of state arrays (or only counts). */
int particles_state(struct particles *p, struct mpm_state_array *arrays, int at);

/* ---- grid.c ---- */
#define GRID_LEAST                                                                                                     \
	0.5 /* least cell edge of a grid that follows a wall, of that at the start; its inverse the largest */
int grid_create(struct mpm *mpm);
/* Puts the nodes where they are in this step; STATUS_GUARD if a grid that follows a wall has been stretched too far. */
int grid_place(struct mpm *mpm);

/* ---- sort.c ---- */
/* Grid cell of a place, -1 outside the scene's box (and for NaN). */
int mpm_cell_of(const struct mpm_work *w, const double x[2]);
void mpm_sort(struct mpm *mpm);
void mpm_resort_storage(struct mpm *mpm);

/* ---- transfer.c ---- */
void mpm_clear_grid(struct mpm *mpm);
void mpm_points_to_grid(struct mpm *mpm);
void mpm_integrate_nodes(struct mpm *mpm);
void mpm_finish_nodes(struct mpm *mpm);
void mpm_grid_to_points(struct mpm *mpm);
/* Calls scatter() for every stripe, those that share no node at the same time. */
void mpm_each_stripe(struct mpm *mpm, void (*scatter)(struct mpm *, struct mpm_work *, int stripe));
/* Beyond the grid: parked, without motion, where it is. */
void point_park(struct particles *p, int k, struct block_sum *sum);

/* ---- project.c ---- */
void mpm_filter_nodes(struct mpm *mpm);
void mpm_strain_points(struct mpm *mpm);

/* ---- motion.c ---- */
/* Does some boundary load points? */
bool loads_points(const struct mpm *mpm);
/* Puts a point of a body with a motion where that begins. */
int motion_begin(struct mpm *mpm, int p, const double X[2]);
/* The nodes' body forces of this step, of motions, tractions and penalty walls. */
void motion_forces(struct mpm *mpm);

/* ---- thermal.c ---- */
void mpm_heat_nodes(struct mpm *mpm);
void mpm_remap_temperature(struct mpm *mpm);
/* W/m3 that fluxes and convection bring to a point at x; T: of the grid there, K. */
double thermal_boundary(const struct mpm_work *w, const double x[2], double T);
/* What the slope (gx, gy) of the temperature, K/m, says of imposed nodes from where point p is, number k of its lists. */
void thermal_lift(const struct mpm *mpm, struct mpm_work *w, const struct shape_lists *lists, int k, int p, double gx,
				  double gy);
/* W m2/K: the conductivity times volume that would take as much of the step limit as convection at a point. */
double mpm_convection_as_conduction(const struct mpm *mpm, int p, double volume);

/* W m2/K, what bounds the thermal step of a point: its volume times at least the larger eigenvalue of its conductivity,
 * and what convection adds. */
static inline double mpm_conductance(const struct mpm *mpm, int p, double volume)
{
	double tensor[3];
	mpm_point_conductivity(mpm, p, tensor);
	double conductance = (fmax(tensor[0], tensor[1]) + fabs(tensor[2])) * volume;
	return mpm_work(mpm)->n_point_heats ? conductance + mpm_convection_as_conduction(mpm, p, volume) : conductance;
}

/* ---- freezing.c ---- */
int freezing_create(struct mpm *mpm);
/* Sets the thawed share and heat capacity of a point by its temperature. */
void freezing_begin(struct mpm *mpm, int p);
/* Gives a point of a freezing material the sensible heat of dT, K, and finds its temperature. */
void freezing_absorb(struct mpm *mpm, int p, double dT);
/* Heat content of a point, J, up to a constant of its material. */
double freezing_heat(const struct mpm *mpm, int p);

/* ---- wall.c ---- */
int walls_create(struct mpm *mpm);
void walls_free(struct mpm *mpm);
/* Is x inside the wall's solid, further than `tolerance` (m) from its surface? */
bool wall_contains(const struct mpm *mpm, int wall, const double x[2], double tolerance);
/* Looks again which walls are on, where they are and which nodes they hold. */
void walls_update(struct mpm *mpm);
/* What holds a node of the grid holds its extra fields. */
void walls_add_fields(struct mpm *mpm);
void walls_apply(struct mpm *mpm);
void walls_hold(struct mpm *mpm);
void walls_account(struct mpm *mpm);
void walls_move(struct mpm *mpm);

/* ---- boundary.c ---- */
int boundaries_create(struct mpm *mpm);
void boundaries_free(struct mpm *mpm);
void boundaries_update(struct mpm *mpm);
/* With contacts: the velocities of driving bodies, once the fields of this step are known. */
void boundaries_drive(struct mpm *mpm);

/* ---- limit.c: how far the step is from its limit on the points' places ---- */
enum { GROWTH_MOST = 100 }; /* of a point's stress beyond the limit before the run is stopped */
bool limit_due(const struct mpm *mpm);
/* After the points have moved: one that enters a grid cell calls for a look where the shape has no bound. */
void limit_follow(struct mpm *mpm);
/* After the points have gone to the grid: fills w->limit and the points' growth. */
void limit_look(struct mpm *mpm);

/* ---- cohesion.c: neighbours that the grid connects no more ---- */
int cohesion_create(struct mpm *mpm);
void cohesion_free(struct mpm *mpm);
bool cohesion_lost(const struct mpm *mpm, int *point, int *neighbour);

/* ---- ledger.c ---- */
/* J, loss_numerical at the start of a step, after the points have gone to the grid. */
double ledger_loss(const struct mpm *mpm);
void ledger_add_step(struct mpm *mpm);
void ledger_start(struct mpm *mpm);

/* ---- guard.c: STATUS_GUARD (or `status`) with step, time, point, reason and cure ---- */
int guard_step(struct mpm *mpm, int status);
int guard_inside(const struct mpm *mpm);
int guard_cohesion(const struct mpm *mpm);
int guard_points(const struct mpm *mpm);
int guard_residual(const struct mpm *mpm);
int guard_energy(struct mpm *mpm);
int guard_law(const struct mpm *mpm, int status, int point);

/* ---- stage.c ---- */
/* s of thermal time that one thermal pass covers: conduction runs time_scale times faster than the clock. */
double mpm_thermal_step(const struct mpm *mpm);
void stage_begin_step(struct mpm *mpm);
int stage_end_step(struct mpm *mpm);

#endif
