/* The RVEs that are inspected now, by name: those of the scene, until steering changes them. */
#ifndef TMDEMPM_RUN_INSPECTED_H
#define TMDEMPM_RUN_INSPECTED_H

#include "run/steering_command.h"

struct inspected_rve {
	char name[SCENE_NAME];
	const struct rve_rule *rule; /* chosen anew whenever something is drawn or written; NULL = a fixed point: */
	int id;
	long long since; /* step at which steering began to inspect it; -1 = the scene does, from the first step */
};

struct inspected {
	const struct mpm *mpm;
	struct run_fields *fields;
	int n;
	struct inspected_rve *rves; /* in the scene's order, then as they came */
};

int inspected_create(struct inspected **inspected, const struct mpm *mpm, struct run_fields *fields);
void inspected_free(struct inspected *inspected);

/* NULL if there is none of this name. */
struct inspected_rve *inspected_find(const struct inspected *inspected, const char *name);

/* What a command to inspect (not `none`) means now; a place in it (at:) becomes the point that is there.  STATUS_INPUT
 * if there is no such RVE. */
int inspected_choose(const struct inspected *inspected, struct steering_command *command, struct inspected_rve *rve);

/* Is just that inspected already under this name? */
bool inspected_is(const struct inspected *inspected, const struct inspected_rve *rve);

/* Adds `rve`, or puts it in the place of that of its name. */
int inspected_set(struct inspected *inspected, const struct inspected_rve *rve);
void inspected_remove(struct inspected *inspected, const char *name);

/* Where its point is stored now.  A rule that finds nothing (no bond has broken) takes the lowest id; -1 if the point
 * has no RVE or is gone.  Points with an RVE only; among equals the lowest id. */
int inspected_point(const struct inspected *inspected, const struct inspected_rve *rve, int *point);

/* The point with an RVE that is nearest to `at` now (of equals the lowest id), or -1. */
int inspected_nearest(const struct mpm *mpm, const double at[2]);

/* Is there an RVE behind the point at this place in storage (-1: no)? */
bool inspected_has_rve(const struct mpm *mpm, int point);

#endif
