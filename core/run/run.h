/* The driver: builds a run from a scene, steps it, writes everything, survives everything. */
#ifndef TMDEMPM_RUN_RUN_H
#define TMDEMPM_RUN_RUN_H

#include <stdbool.h>

struct run_options {
	const char *scene_path;
	int n_sets;
	const char *const *sets; /* path=value */
	const char *out;         /* folder; NULL = NAME.out in the working directory */
	int threads;             /* 0 = all */
	const char *device;      /* "cpu" */
	const char *restart;     /* checkpoint file or NULL */
	double until;            /* s, NAN = the scene's end */
	const char *steering;    /* log of another run's steering, to be repeated; or NULL */
	bool paused;             /* waits before the first step until somebody says to go on */
	const char *live;        /* "port", "host:port", "" = the scene's or default ones; NULL = not asked for */
	int n_pipelines;
	const char *const *pipelines; /* ParaView Catalyst scripts */
	bool quiet, force, allow_path_change;
};

/* Runs a scene to its end; returns a status (exit code).  Messages of a scene's errors have been written to
 * stderr; of other failures error_message() tells. */
int run_scene(const struct run_options *options);

/* `tmdempm check`. */
int run_check(const char *scene_path, int n_sets, const char *const *sets, int threads, const char *device);

/* `tmdempm info`. */
int run_info(bool json);

#endif
