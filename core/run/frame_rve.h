/* The part of a frame that shows one RVE: channels `rve_NAME_discs` and `rve_NAME_contacts`. */
#ifndef TMDEMPM_RUN_FRAME_RVE_H
#define TMDEMPM_RUN_FRAME_RVE_H

#include <stdbool.h>

#include "run/viewer.h"
#include "rve/rve.h"

struct frame_rve_view {
	const char *name;
	const char *rule; /* that chose the point; NULL or "" = it is a fixed one */
	const struct rve_model *model;
	const void *state;
	double time;        /* s */
	long long point;    /* id; -1 = none */
	double stress[4];   /* Pa, of the point: xx yy zz xy */
	double F[4];        /* deformation gradient of the point, row-major */
	double temperature; /* of the point in the frame's unit; NAN = unknown */
	bool birth;         /* its start packing, for a picture beside another one; not written to files */
	bool celsius;       /* that unit */
	bool thermal;       /* temperature matters: it is named beside the picture */
};

/* Adds the two channels to the frame that is being built. */
int frame_rve_add(struct frame_builder *builder, const struct frame_rve_view *view);

#endif
