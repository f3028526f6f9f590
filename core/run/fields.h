/* Every field of the points: the table that history, snapshots, .vtp and frames share.
 *
 * The points' own fields (mpm/particles.h) come first, then those that the laws of this scene export;
 * a field that two laws give under one name is one field.  Temperatures come in the scene's unit. */
#ifndef TMDEMPM_RUN_FIELDS_H
#define TMDEMPM_RUN_FIELDS_H

#include <stdbool.h>

#include "base/field.h"
#include "mpm/mpm.h"

struct run_field {
	const struct field *field;
	const char *unit; /* as written to files: "T" has become "C" or "K" */
	int particle;     /* number in particle_fields, or -1 */
};

struct run_fields {
	int n;
	struct run_field *fields;
	double *values; /* private: one law's values */
	int *slots, *points;
};

int fields_create(struct run_fields **fields, const struct mpm *mpm);
void fields_free(struct run_fields *fields);

/* Field f of all points in storage order into out[n * components]; NAN where the point's law has no such field. */
void fields_get(struct run_fields *fields, const struct mpm *mpm, int f, double *out);

/* Number of the field of this name, or -1. */
int fields_find(const struct run_fields *fields, const char *name);

/* "" , "_x" .. "_y", "_xx" .. : the ending of component c in a column's name; NULL for components that are
 * always zero in two dimensions (z, yz, xz). */
const char *field_component_ending(int components, int c);

#endif
