/* Constitutive laws: a table of functions, and instances that own the states of their points.
 *
 * A law turns a batch of points' deformation and temperature into stress, heat source, conductivity
 * and wave modulus.  It never sees the grid; the MPM never sees which law runs.  Its state is a fixed
 * number of bytes for each point, free of pointers, so that a checkpoint, a message or a copy to a
 * device is a memcpy. */
#ifndef TMDEMPM_LAW_LAW_H
#define TMDEMPM_LAW_LAW_H

#include <stddef.h>

#include "base/field.h"
#include "scene/scene.h"

/* One call.  All arrays have n entries; entry k belongs to the state slot[k].  Slots are unique in a batch. */
struct law_batch {
	int n;
	const int *slot;
	const double (*F)[4];  /* deformation gradient after the step, row-major */
	const double (*L)[4];  /* velocity gradient of the step, 1/s */
	const double *T;       /* smooth temperature after the step, K */
	const double *dT;      /* its increment in this step, K */
	double dt;             /* s */
	double (*stress)[4];   /* out: xx yy zz xy, Pa, tension-positive */
	double *heat;          /* out: W/m3 of current volume */
	double (*conductivity)[3]; /* out: xx yy xy, W/(m K) */
	double *modulus;       /* out: P-wave modulus, Pa */
	double *damage;        /* out: 0 whole .. 1 broken; NULL unless some law of the scene breaks */
	int failed;            /* out, on failure: the lowest k that failed, else -1 */
};

/* Energies of one point since its birth (or the last reset), J per m3 of its initial volume.
 * work = elastic + kinetic + friction + dashpot + bond + fracture + discarded - expansion, up to the law's own error. */
struct law_ledger {
	double work;      /* of the stress on the strain, as the law itself integrates it */
	double elastic;   /* stored now, counted from zero force */
	double kinetic;   /* of fluctuations, now */
	double friction;  /* turned into heat so far */
	double dashpot;
	double bond;
	double fracture;  /* taken by damage so far, as heat or surface */
	double expansion; /* put in by thermal expansion */
	double discarded; /* dropped with re-seeded or gas states */
};

/* Counters of a law's run report, summed over its points. */
struct law_counts {
	long long disc_steps;  /* discs times sub-steps */
	long long gas;         /* points in the gas state now */
	long long frozen;      /* points frozen for slenderness now */
	long long reseeded;    /* RVEs replaced so far */
	long long clamped;     /* point-steps in which n_max cut the number of sub-steps */
	long long rebuilds;    /* neighbour lists built */
	long long bonds_installed, bonds_intact;
	long long twin_calls, twin_disc_steps; /* of these, since the run began: not computed, a twin's was */
	long long calls;       /* point-steps so far, quiet ones and flying ones aside */
	long long quiet_calls, quiet_caught; /* point-steps so far in which discs waited, in which they caught up */
	double quiet_error_sum, quiet_error_most; /* relative error of the stress then, summed and largest */
	long long paced_calls, paced_saved; /* point-steps so far with longer DEM steps, disc-steps that this saved */
	double paced_error_sum, paced_error_most; /* estimated error of the stress in them, Pa, summed and largest */
	long long inertia[12]; /* histogram of inertial numbers: < 1e-6, then 2 bins a decade, > 1e-1 */
};

struct law;
struct rve_model; /* rve/rve.h */

struct law_type {
	const char *name;
	const char *doc;
	bool breaks;   /* it fills batch->damage */
	bool friction; /* its heat is of friction: thermal.friction_heat */
	bool cohesive; /* its points stay neighbours for good: pulled out of each other's reach the grid has torn them, not the law */
	const struct field *fields; /* what export() can give, beside stress and heat */
	int n_fields;

	/* Makes the model and n_points states.  variant[k] in 0..n-1 chooses the packing of point k.
	 * Sets law->density where the scene leaves it to the law. */
	int (*create)(struct law *law, const struct scene_law *scene, int n_points, const int *variant);
	void (*destroy)(struct law *law);

	/* Stress, conductivity and modulus of the states as they are (heat = 0); no time passes. */
	int (*evaluate)(const struct law *law, struct law_batch *batch);

	/* One step.  Parallel over points inside.  STATUS_GUARD with batch->failed and a message. */
	int (*advance)(struct law *law, struct law_batch *batch);

	/* Change of the first Piola-Kirchhoff stress P (row-major, Pa, in the plane) of an unheated point as its F changes in
	 * the direction G: what a manufactured motion needs.  NULL where the law has no closed form for it. */
	void (*piola_derivative)(const struct law *law, const double F[4], const double G[4], double dP[4]);

	/* Field number f of n states into out[n * components]. */
	void (*export_field)(const struct law *law, int f, int n, const int *slot, double *out);

	void (*ledger)(const struct law *law, int slot, struct law_ledger *ledger);
	/* friction, dashpot ... start again from zero; asked for all points of the law together */
	void (*reset_ledger)(struct law *law, int slot);
	void (*counts)(const struct law *law, struct law_counts *counts); /* may be NULL */

	/* A stage's action install_bonds: bonds the grains of every point where they touch; NULL where there are none. */
	int (*install_bonds)(struct law *law);

	/* Before law->states is read as bytes: points may share a state meanwhile.  And after it was replaced.  NULL where
	 * every point has its state to itself. */
	int (*write_out)(struct law *law);
	void (*restored)(struct law *law);

	/* Makes its states, as they are, those of another path, before use_devices().  NULL where there is but one. */
	int (*change_path)(struct law *law, const char *path);

	/* Takes its points to these devices (--device; rve/pool.h); `note` says what was chosen.  NULL where a law computes
	 * here only. */
	int (*use_devices)(struct law *law, const char *devices, char *note, size_t note_bytes);
	void (*shares)(const struct law *law, char *words, size_t bytes); /* where its points are now */

	/* The RVE behind a state, for rve_inspect() and rve_get_info(); NULL where the law has none. */
	int (*rve_view)(const struct law *law, int slot, const struct rve_model **model, const void **state);
};

/* An instance: one scene law with its points. */
struct law {
	const struct law_type *type;
	char name[SCENE_NAME];
	const struct scene_law *scene; /* what it was made from; the caller's */
	const char *path;     /* which code computes its states; NULL: there is but one */
	double density;       /* bulk at birth, kg/m3; NAN if the law has no opinion */
	double coupling;      /* lambda / P-wave modulus at rest, 0..1: couples the two directions in the step's limit; 1 unless create() says less */
	struct twins *twins;  /* law/twins.h; NULL: every point has its state to itself */
	struct rve_pool *pool; /* rve/pool.h; NULL: this processor computes all of it */
	void *model;          /* parameters; rebuilt from the scene, never saved */
	unsigned long long model_hash; /* of what the states rely on beside the scene's text (packings); 0 = nothing */
	int n_points;
	size_t state_bytes;
	unsigned char *states; /* n_points * state_bytes, 64-byte aligned; saved as it is */
};

/* Every law there is, NULL-terminated; `tmdempm info` prints it. */
extern const struct law_type *const law_types[];

/* The type of a scene's law; NULL if this build does not have it. */
const struct law_type *law_type_of(const struct scene_law *scene);

/* For create(): law->model and the states of law->n_points points, of so many bytes each and all zero; STATUS_RESOURCE
 * if memory is short.  And the destroy() of a law that has no more than these. */
int law_allocate(struct law *law, size_t model_bytes, size_t state_bytes);
void law_release(struct law *law);

/* Creates the instance for a scene's law. */
int law_create(struct law **law, const struct scene_law *scene, int n_points, const int *variant);
void law_free(struct law *law);

#endif
