/* `tmdempm study`: one scene (or one `rve load`), run with many settings, each compared with a reference.
 *
 * A study file names a scene, knobs and what they may be set to, a reference (an exact solution, one combination
 * of the knobs, or a table), and norms of the difference to it.  Every combination is run by a child process in a
 * folder of its own; what has been run is not run again.  Then the errors, what they cost, and whether gates are
 * met are written to study.csv and drawn.  The keys of a study file stand in core/study/keys.c and, each with its
 * meaning, in scenarios/studies/reference.cfg. */
#ifndef TMDEMPM_STUDY_STUDY_H
#define TMDEMPM_STUDY_STUDY_H

#include <stdbool.h>
#include <stdio.h>

struct study_options {
	const char *out; /* folder; each study has one of its own below it */
	int jobs;        /* runs at a time, at least 1 */
	bool fresh;      /* repeat runs that are done */
	bool no_charts;
	bool list; /* say what would be run, and stop */
	int n_sets;
	const char *const *sets; /* path=value, of the study file */
};

/* Runs the studies one after the other.  STATUS_GUARD if a gate was missed (the message names norm, value, bound
 * and combination), STATUS_INPUT for wrong files (told on stderr), STATUS_INTERRUPTED after SIGINT or SIGTERM. */
int study_run(int n_files, char *const *files, const struct study_options *options);

/* Prints every key of a study file with its meaning. */
void study_print_keys(FILE *out);

#endif
