/* What the parts of the driver share. */
#ifndef TMDEMPM_RUN_RUN_PRIVATE_H
#define TMDEMPM_RUN_RUN_PRIVATE_H

#include "io/file.h"
#include "mpm/mpm.h"
#include "run/fields.h"
#include "run/history.h"
#include "run/inspected.h"
#include "run/live.h"
#include "run/log.h"
#include "run/run.h"
#include "run/sink.h"
#include "run/steering_socket.h"
#include "run/viewer.h"

/* Times of a scene are met at whole steps: every so many, 0 = never. */
long long schedule_steps(const struct scene *scene, double seconds);
bool schedule_due(long long every, long long step);

/* ---- paths.c: rve/NAME_path.csv of the inspected points (not of those that a rule chooses) ---- */

struct paths;

/* Opens the files; on a restart (first_step > 0, same folder) they are cut there.  Points whose path is not
 * whole are not recorded: a warning says so. */
int paths_create(struct paths **paths, const struct inspected *inspected, const char *folder, bool restart,
				 struct run_log *log);
/* Steering begins to inspect a fixed point: its RVE as it is now goes to rve/NAME_STEP.h5, from which `rve load` drives
 * it along rve/NAME_STEP_path.csv; what was recorded under this name ends.  And ends it without another. */
int paths_start(struct paths *paths, const struct inspected_rve *rve);
int paths_stop(struct paths *paths, const char *name);
int paths_record(struct paths *paths); /* after each step: what the laws got */
int paths_sync(struct paths *paths);
int paths_close(struct paths *paths);

/* ---- checkpoint.c ---- */

/* The state and nothing else: equal states make equal files.  A state that is not `whole` (a guard stopped in the
 * middle of a step) is written to be looked at; checkpoint_read() refuses it. */
int checkpoint_write(const char *path, struct mpm *mpm, const struct history_memory *memory, bool whole);

/* Which code's bits a run has, on whatever device: "simd in law sand". */
enum { CODE_PATH = 512 };
void checkpoint_code_path(const struct mpm *mpm, char *path, size_t size);

/* RVEs whose path the scene leaves open are computed as devices (--device) compute them, if there are any. */
void run_choose_paths(struct scene *scene, const char *devices);

/* The laws that can, to these devices; `note` says what was chosen, "" if no law asks.  STATUS_INPUT if devices are named
 * that no law can use, STATUS_RESOURCE if one of them cannot be used. */
int run_use_devices(struct mpm *mpm, const char *devices, char *note, size_t note_bytes);

/* Reads the state into an MPM made from the same scene. STATUS_INPUT if the file is of another scene (the
 * message names the first setting that differs), another code path, or broken.  Where the scene leaves the path of its
 * RVEs open, a law goes on on the path of its states; `allow_path_change`: these are converted to the path that the law
 * was made with. */
int checkpoint_read(const char *path, struct mpm *mpm, struct history_memory *memory, bool allow_path_change);

/* For looking only: the scene's text (free() it), and the state into an MPM made from it, also one at a guard. */
int checkpoint_read_scene(const char *path, char **text);
int checkpoint_look(const char *path, struct mpm *mpm);

/* The same questions about the scene without reading the state: asked before anything is made. */
int checkpoint_check_scene(const char *path, const struct scene *scene);

/* ---- snapshot.c: snap/NNNNNNNN.h5 and run.h5; vtk/NAME_NNNNNNNN.vtp and NAME.pvd ---- */

struct snapshots;

int snapshots_create(struct snapshots **snapshots, const struct inspected *inspected, const char *folder, bool restart);
void snapshots_free(struct snapshots *snapshots);

/* Writes the state as it is; `frame` feeds the VTK files (NULL = none). */
int snapshots_write(struct snapshots *snapshots, const void *frame);
int snapshots_count(const struct snapshots *snapshots);
/* The .pvd files, by number; NULL after the last. */
const char *snapshots_series(const struct snapshots *snapshots, int i);

/* ---- images.c ---- */

struct images;

/* Do the fields and components that a scene's pictures ask for exist?  All messages go to `errors` (a FILE *). */
int images_check(const struct scene *scene, void *errors);

/* Starts the viewer if the scene asks for pictures; without one the run goes on and a warning says what to install. */
int images_create(struct images **images, const struct mpm *mpm, const char *folder, struct run_log *log);
bool images_due(const struct images *images, long long step, bool last);
/* Another interval from now on, s, 0 = never.  STATUS_INPUT if the scene has no picture of this name. */
int images_set_every(struct images *images, const char *name, double seconds);
double images_every(const struct images *images, int i);
/* Asks for the pictures that are due. */
void images_draw(struct images *images, const void *frame, int64_t bytes, long long step, bool last);
struct sink *images_sink(struct images *images);
int images_count(const struct images *images);
const char *images_file(const struct images *images, int i); /* relative to the folder, in the order of drawing */
void images_free(struct images *images);

/* ---- scripts.c: ParaView Catalyst pipelines ---- */

struct scripts;

/* Are the scripts of the command line there? */
int scripts_check(const struct run_options *options);
/* Starts the viewer if the scene or --pipeline asks for scripts; without one the run goes on, with a warning. */
int scripts_create(struct scripts **scripts, const struct scene *scene, const struct run_options *options,
				   const char *folder, struct run_log *log);
bool scripts_due(const struct scripts *scripts, long long step, bool last);
void scripts_give(struct scripts *scripts, const void *frame, int64_t bytes, bool last);
struct sink *scripts_sink(struct scripts *scripts);
void scripts_free(struct scripts *scripts);

/* ---- watch.c: all of those together ---- */

enum { WATCHERS = 3 }; /* pictures, scripts, live */
enum { WATCH_IMAGES = 1, WATCH_SCRIPTS = 2, WATCH_LIVE = 4 };

struct run;

int watch_open(struct run *run);
/* Who wants a frame of the state as it is: a sum of WATCH_. */
unsigned watch_due(struct run *run, bool last);
/* Hands it to them; `seconds` = what it took to make it. */
void watch_show(struct run *run, unsigned due, const void *frame, int64_t bytes, bool last, double seconds);
/* During a pause: a live client sees the state that the run waits in, and what commands have changed. */
int watch_wait(struct run *run);
/* Returns when everything asked for is drawn and done: before a checkpoint, which says that all before it is. */
void watch_flush(struct run *run);
double watch_waited(const struct run *run);    /* s that the engine has waited for viewers */
double watch_cpu(const struct run *run, int k); /* s of processor time, of watcher k */
/* Waits for what is outstanding and ends the viewers. */
void watch_finish(struct run *run);
void watch_free(struct run *run);

/* ---- signals.c ---- */

void signals_install(void);
int signals_stop(void);             /* the signal that asks to stop, or 0 */
bool signals_take_checkpoint(void); /* SIGUSR1 came; asked once */
int signals_descriptor(void);       /* poll() finds it readable when a signal has come that nobody has taken; -1 = none */

/* ---- the run itself ---- */

struct run {
	const struct run_options *options;
	struct run_log log;
	struct scene *scene;
	struct mpm *mpm;
	struct run_fields *fields;
	struct history *history;
	struct history_memory memory;
	struct inspected *inspected;
	struct steering_script script;
	struct steering *steering;
	struct steering_socket *socket;
	struct paths *paths;
	struct snapshots *snapshots;
	struct images *images;
	struct scripts *scripts;
	struct live *live;
	struct frame_builder *builder;
	char folder[FILE_PATH];
	int folder_lock; /* open as long as the folder is ours */
	int threads;
	long long first_step, last_step;
	long long history_every, snapshot_every, checkpoint_every; /* steps */
	long long first_disc_steps;
	long long waited_step; /* state that a live client has seen during a pause: step and commands so far */
	int waited_commands;
	double loop_start;    /* s, clock_seconds() */
	double loop_time;     /* s, when it is over */
	double loop_cpu;      /* s on all cores, when it is over */
	double setup_time;    /* s */
	double output_time;   /* s, without the wait for the viewer */
	double next_progress; /* s, clock_seconds() */
	char device_note[1024];
	const char *devices; /* where RVEs are computed, in words; NULL = here */
};

/* What is due now, or all that the scene wants at the run's end. */
int run_output(struct run *run, bool last);
int run_checkpoint(struct run *run);

/* ---- steered.c: what steering does to a run ---- */

/* After the pictures and before the paths: both may have been steered before a restart, which `continues` the run in its
 * own folder or goes on in a new one. */
int steered_open(struct run *run, bool continues);

/* Between two steps; pauses do not count as the run's time. */
int steered_between(struct run *run);

/* ---- progress.c and report.c ---- */

void progress_update(struct run *run, bool now);

/* Sum of the laws' counters. */
void run_counts(const struct run *run, struct law_counts *counts);

/* run.json; `state` is "running", "done", "interrupted", "guard" or "failed". */
int report_write(struct run *run, const char *state);

/* Warns of what no guard stops but makes results worse: cells crossed with the linear shape, RVEs driven too fast. */
void report_judge(struct run *run);

/* The table of times, and what was written. */
void report_print(struct run *run);

#endif
