/* Looking into a run, finished or not: one RVE of it, from a checkpoint or a snapshot; or into an RVE file. */
#ifndef TMDEMPM_RUN_LOOK_H
#define TMDEMPM_RUN_LOOK_H

#include "io/file.h"
#include "run/frame_rve.h"
#include "run/rules.h"
#include "rve/rve_file.h"

/* Which RVE of a run; exactly one of them is given. */
struct look_choice {
	const char *name;            /* of an inspection, or NULL */
	long long point;             /* id, or -1 */
	double at[2];                /* m, as the points lie now; NAN = not given */
	const struct rve_rule *rule; /* or NULL */
};

struct look {
	struct frame_rve_view view; /* model, state and the point's own values */
	struct rve_origin origin;
	char source[FILE_PATH];   /* the file that the state lies in */
	char folder[FILE_PATH];   /* of the run; "" = none */
	char title[256];          /* of the scene, or "" */
	double x[2];              /* m, where the point is; NAN without one */
	long long skip;           /* rows that its recorded path has before it; -1 = no run */
	char path[FILE_PATH];     /* that path, if there is one; "" = none */
	char name[48];            /* in pictures: of the inspection, "point_412", or of the file */
	struct look_parts *parts; /* private */
};

/* `source` is a run's folder, its run.h5, checkpoint.h5, guard.h5 or snap/NNNNNNNN.h5; or an RVE file or a packing,
 * which hold one RVE (then nothing is chosen, choice may be NULL).  `time` (s) chooses among the states of a run: that
 * which is nearest; NAN = the last.  STATUS_INPUT where there is no such RVE, with the command that would make it. */
int look_open(struct look *look, const char *source, double time, const struct look_choice *choice);
void look_close(struct look *look); /* also after a failure */

#endif
