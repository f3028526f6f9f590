/* RVE files: one RVE in the middle of its life, whole, so that `rve load` drives it on with the bits of the run.
 *
 * A packing (packing.h) is how an RVE is born.  An RVE file holds what came of it: the state with its velocities,
 * contact history, bonds, temperature and ledgers, and what that state relies on: the law's parameters and the packings
 * that the law began with (they give the DEM step and the neighbour lists' capacities, and re-seed a slender cell). */
#ifndef TMDEMPM_RVE_RVE_FILE_H
#define TMDEMPM_RVE_RVE_FILE_H

#include <stdbool.h>

#include "rve/packing.h"
#include "rve/rve.h"

/* Where an RVE was found; for people, and for what goes on from it. */
struct rve_origin {
	char name[64];   /* of its inspection, or "" */
	char law[64];    /* of the scene, or "" */
	long long point; /* its id, or -1 */
	long long step;  /* of the run; 0 at birth */
	double time;     /* s */
	double T;        /* K, absolute: what its bonds melt by; NAN = unknown */
};

struct rve_file {
	struct rve_origin origin;
	struct rve_params params;
	int n_packings;
	struct rve_packing **packings; /* at birth, of the law's variants; what a model needs is in `starts` beside them */
	unsigned char *starts;         /* n_packings states at birth */
	unsigned char *state;          /* 64-byte aligned */
	size_t state_bytes;
	unsigned long long hash; /* of the packings at birth and the state: equal hashes, equal bits */
};

/* Writes a state of `model` as the RVE file `path` (.h5).  Written under a temporary name and renamed. */
int rve_file_write(const char *path, const struct rve_model *model, const void *state, const struct rve_origin *origin);

/* Is it an RVE file, whole or damaged?  False for packings and for what cannot be read. */
bool rve_file_is(const char *path);

/* STATUS_INPUT, with what is wrong, for other files, other releases' files and damaged ones. */
int rve_file_read(struct rve_file **file, const char *path);
void rve_file_free(struct rve_file *file);

/* The model that the state belongs to, with the file's parameters or others (friction, stepping ...).  STATUS_INPUT if
 * `params` ask for another layout of states (skin) than the file's. */
int rve_file_model(struct rve_model **model, const struct rve_file *file, const struct rve_params *params);

#endif
