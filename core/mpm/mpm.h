/* The material point method at the scale of the scene: grid, points, walls, heat, ledger, one step.
 *
 * One step reads like the paper (TM-DEMPM section 2; here in the order USL): weights, to grid, forces, heat,
 * integrate, walls, to points, law.  The passes a scene needs are chosen once, in mpm_create(). */
#ifndef TMDEMPM_MPM_MPM_H
#define TMDEMPM_MPM_MPM_H

#include <stdbool.h>

#include "law/law.h"
#include "mpm/particles.h"
#include "scene/scene.h"

struct shape; /* shape.h */

/* Nodes nx by ny, node (i, j) = j * nx + i at origin + (i, j) spacing; one ghost cell lies around the scene's box.
 * Arrays have nx * ny entries and are valid after a step where mass > 0. */
struct grid {
	int nx, ny;
	double origin[2], spacing[2]; /* m, as they are now: a grid may follow a wall (grid.c) */
	double h, thickness;  /* m, edge of a cell at the start; out of plane */
	double *mass;         /* kg */
	double (*v)[2];       /* m/s, at the start of the step (momentum / mass, walls not yet felt) */
	double (*v_new)[2];   /* m/s, at its end */
	double (*force)[2];   /* N, internal + external, without walls */
	double *heat_capacity;/* J/K; NULL without heat */
	double *T, *T_new;    /* K */
};

/* The energy ledger, J.  Rates are summed from their own mechanisms; nothing is a difference of others.
 * The names are the columns of history.csv. */
struct mpm_ledger {
	/* what is there now */
	double energy_kinetic, energy_elastic, energy_rve_kinetic, energy_gravity, energy_thermal;
	/* what has passed since the start (or zero_ledger) */
	double work_boundary;       /* by moving walls, imposed velocities, confining pressure, body force of motions, tractions */
	double work_walls_friction; /* turned into heat at walls */
	double heat_rve_friction;   /* turned into heat in RVEs */
	double loss_dashpot, loss_bond, loss_fracture;
	double work_contact_friction; /* turned into heat where bodies touch */
	double loss_contact;        /* of bodies that meet */
	double loss_numerical;      /* transfers between points and nodes, damping, remapping, unilateral impacts on walls */
	double work_expansion;      /* by thermal expansion */
	double energy_discarded;    /* gas, re-seeded */
	double heat_in, heat_out;   /* through boundaries and walls */
	/* what does not add up */
	double energy_residual;     /* mechanical */
	double heat_residual;       /* thermal */
};
extern const struct field mpm_ledger_fields[]; /* in the order of the struct's doubles */
extern const int mpm_ledger_fields_count;

struct mpm_wall_sums {
	double force[2];      /* N, of the material on the wall, mean over the last step */
	double friction_heat; /* J so far */
	double heat;          /* J into the material from a heated wall so far */
};

/* One array of the state, for the checkpoint.  `bytes` per entry, `count` entries. */
struct mpm_state_array {
	const char *name;
	void *data;
	char type; /* 'd' double, 'i' int, 'q' long long, 'b' bytes */
	size_t count;
};

struct mpm {
	const struct scene *scene; /* borrowed */
	struct grid grid;
	struct particles p;
	int n_laws;
	struct law **laws;         /* one for each scene law that has points */
	const struct shape *shape;
	bool thermal;              /* the thermal pass runs */
	long long step;            /* steps done */
	double time;               /* s */
	double dt;                 /* s, of the last step */
	int stage;                 /* index of the current stage */
	double stage_start;        /* s */
	bool bonds_installed;      /* by the stage that ended with the last step */
	bool within_step;          /* a step has begun to change the points and has not come to its end */
	struct mpm_wall_sums *walls; /* one for each scene wall */
	double (*wall_offset)[2];  /* m, how far each wall has moved */
	struct mpm_ledger ledger;  /* filled by mpm_measure(), which a step calls now and then to judge the residual */
	double stable_step;        /* s, b h sqrt(rho/M) of the last step's stiffest point (thermal limit included) */
	double lattice_limit;      /* s, limit of the points as they lie in their grid cells at the last look; INFINITY = far */
	double thermal_limit;      /* s, the largest time.step that heat conduction allowed in its last step */
	long long law_time_ns, mpm_time_ns; /* wall time so far in the law and in everything else of the step */
	void *work;                /* private: see mpm_private.h */
};

/* Fills the bodies with points (strictly inside, on the lattice), creates the laws, finds the walls' nodes
 * and evaluates the laws' start state.  STATUS_INPUT messages name the scene's file:line. */
int mpm_create(struct mpm **mpm, const struct scene *scene);
void mpm_free(struct mpm *mpm);

/* One step of scene->time.step.  STATUS_GUARD with step, time, point, reason and cure: NaN, step over the
 * limit, point leaving the grid, law guards, energy residual.  After a guard the state is that of the step's
 * start or end, as the message says, and can be saved. */
int mpm_step(struct mpm *mpm);

/* Fills mpm->ledger and the regions' and points' derived values from the state as it is. */
void mpm_measure(struct mpm *mpm);

/* Where a place of the scene, x (c = 0) or y (1), has gone with a grid that follows a wall, m. */
double grid_carried(const struct mpm *mpm, double place, int c);

/* Does the scene's wall act in the step that starts now (its times, the stage's walls)? */
bool mpm_wall_active(const struct mpm *mpm, int wall);

/* What the material did to a wall at one node of the grid in the last step. */
struct mpm_wall_load {
	int wall;
	double at[2];     /* m, the node */
	double normal[2]; /* of the wall's face, into the material */
	double force[2];  /* N, on the wall, mean over the step */
};

/* The loads of the last step, n at most, in the order of the nodes; returns how many there are.  Their sum is
 * mpm->walls[].force (without the confining pressure that a scene may add to it). */
int mpm_wall_loads(const struct mpm *mpm, struct mpm_wall_load *loads, int n);

/* Sums over a box of the scene. */
struct mpm_region_values {
	double mass, volume; /* kg, m3 */
	double temperature;  /* K, mean by heat capacity, NAN if empty */
};
void mpm_region(const struct mpm *mpm, const struct scene_region *region, struct mpm_region_values *values);

/* Storage index of the point with this id, or of the point nearest to `at` in the initial body. */
int mpm_point_by_id(const struct mpm *mpm, int id);
int mpm_point_nearest_initial(const struct mpm *mpm, const double at[2]);

/* Temperature change that the law of the point with this id was told before the first step, in one call of time.step
 * without motion: from the reference temperature to that at birth, K.  NAN if the laws were told nothing. */
double mpm_start_warming(const struct mpm *mpm, int id);

/* Every array that makes up the state (points, laws' states, ledger sums, walls, time).  Returns how many;
 * pass arrays = NULL to ask.  Before reading them call mpm_write_out(), after writing into them mpm_restored(). */
int mpm_state(struct mpm *mpm, struct mpm_state_array *arrays);
int mpm_write_out(struct mpm *mpm);
int mpm_restored(struct mpm *mpm);

/* Bytes that the run will need beside the files (points, grid, laws). */
size_t mpm_memory(const struct mpm *mpm);

#endif
