/* history.csv: one row at each scheduled step: time, energies, regions, walls, probes. */
#ifndef TMDEMPM_RUN_HISTORY_H
#define TMDEMPM_RUN_HISTORY_H

#include <stdbool.h>

#include "mpm/mpm.h"
#include "run/fields.h"

struct history;

/* What the next row needs from the last one; part of the checkpoint. */
struct history_memory {
	double time;         /* s, of the last scheduled row; NAN before the first */
	double *region_mass; /* kg, at that row, [n_regions] */
	double *crack_length; /* m, at that row, [n_cracks] */
};

int history_memory_create(struct history_memory *memory, int n_regions, int n_cracks);
void history_memory_free(struct history_memory *memory);

/* Opens `path`; with `append` rows are added to those up to the memory's time, else the file starts with its
 * header.  `memory` stays the caller's and is kept up to date. */
int history_create(struct history **history, const char *path, const struct mpm *mpm, struct run_fields *fields,
				   struct history_memory *memory, bool append);
int history_close(struct history *history); /* NULL is allowed */

/* A row of the state as it is.  `scheduled` rows are what the next one's flows refer to; a row between
 * (at the end of a run) leaves no trace in the memory, so that a restart repeats the same rows. */
int history_row(struct history *history, bool scheduled);
int history_sync(struct history *history);

#endif
