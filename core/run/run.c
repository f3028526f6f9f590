#include "run/run.h"

#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/error.h"
#include "rve/pool.h"
#include "run/folder.h"
#include "run/frame_build.h"
#include "run/run_private.h"

long long schedule_steps(const struct scene *scene, double seconds)
{
	if (!(seconds > 0) || !isfinite(seconds))
		return 0;
	long long steps = llround(seconds / scene->time.step);
	return steps > 0 ? steps : 1;
}

bool schedule_due(long long every, long long step) { return every > 0 && step % every == 0; }

static int run_path(const struct run *run, const char *name, char path[FILE_PATH])
{
	return file_join(path, run->folder, name);
}

/* ---- output ---- */

int run_output(struct run *run, bool last)
{
	struct mpm *mpm = run->mpm;
	double start = clock_seconds(), waited = watch_waited(run);
	bool row_due = schedule_due(run->history_every, mpm->step);
	if (row_due || last) {
		mpm_measure(mpm);
		CHECK(history_row(run->history, row_due));
	}
	bool snapshot = schedule_due(run->snapshot_every, mpm->step) || (last && run->snapshot_every > 0);
	bool vtk = snapshot && run->scene->output.vtk;
	unsigned watchers = watch_due(run, last);
	const void *frame = NULL;
	int64_t bytes = 0;
	double begun = clock_seconds();
	if (vtk || watchers)
		CHECK(frame_build(run->builder, mpm, run->fields, run->inspected, &frame, &bytes));
	if (watchers)
		watch_show(run, watchers, frame, bytes, last, clock_seconds() - begun);
	if (snapshot)
		CHECK(snapshots_write(run->snapshots, vtk ? frame : NULL));
	run->output_time += clock_seconds() - start - (watch_waited(run) - waited);
	return STATUS_OK;
}

/* Everything that was written before the checkpoint is on disk before the checkpoint is. */
static int run_save(struct run *run, const char *name, bool whole)
{
	char path[FILE_PATH];
	double start = clock_seconds(), waited = watch_waited(run);
	watch_flush(run);
	CHECK(history_sync(run->history));
	CHECK(paths_sync(run->paths));
	CHECK(steering_sync(run->steering));
	CHECK(run_path(run, name, path));
	CHECK(checkpoint_write(path, run->mpm, &run->memory, whole));
	run->output_time += clock_seconds() - start - (watch_waited(run) - waited);
	return STATUS_OK;
}

int run_checkpoint(struct run *run) { return run_save(run, "checkpoint.h5", true); }

/* ---- the loop ---- */

static bool run_is_finite(const struct mpm *mpm)
{
	const struct particles *p = &mpm->p;
	for (int i = 0; i < p->n; i++)
		if (!isfinite(p->x[i][0] + p->x[i][1] + p->v[i][0] + p->v[i][1] + p->F[i][0] + p->F[i][1] + p->F[i][2] +
					  p->F[i][3] + p->stress[i][0] + p->stress[i][1] + p->stress[i][2] + p->stress[i][3] + p->T[i]))
			return false;
	return true;
}

/* A guard stopped the run: the state is kept where it can be of use; the message is the guard's.  In the middle
 * of a step the last checkpoint stays what a restart, with other guards, goes on from. */
static int run_guarded(struct run *run)
{
	bool whole = !run->mpm->within_step;
	char message[2048];
	snprintf(message, sizeof message, "%s", error_message());
	if (!run_is_finite(run->mpm))
		return error_set(STATUS_GUARD, "%s (the state is not finite: checkpoint.h5 is still the last good one)",
						 message);
	int status = run_output(run, true);
	if (status == STATUS_OK)
		status = run_save(run, whole ? "checkpoint.h5" : "guard.h5", whole);
	if (status != STATUS_OK)
		log_warning(&run->log, "the state could not be saved: %s", error_message());
	return error_set(STATUS_GUARD, "%s", message);
}

static int run_loop(struct run *run)
{
	struct mpm *mpm = run->mpm;
	if (mpm->step == 0)
		CHECK(run_output(run, run->last_step == 0));
	while (mpm->step < run->last_step) {
		CHECK(steered_between(run));
		if (signals_stop() || steering_stops(run->steering))
			break;
		int status = mpm_step(mpm);
		if (status == STATUS_GUARD)
			return run_guarded(run);
		CHECK(status);
		CHECK(paths_record(run->paths));
		CHECK(run_output(run, mpm->step == run->last_step));
		if (signals_take_checkpoint()) {
			CHECK(run_checkpoint(run));
			log_line(&run->log, "checkpoint at step %lld, time %.6g s", mpm->step, mpm->time);
		} else if (schedule_due(run->checkpoint_every, mpm->step) && mpm->step < run->last_step) {
			CHECK(run_checkpoint(run));
		}
		progress_update(run, false);
	}
	CHECK(run_checkpoint(run));
	progress_update(run, true);
	if (mpm->step < run->last_step)
		return error_set(STATUS_INTERRUPTED,
						 "interrupted at step %lld, time %.6g s: continue with --restart %s/checkpoint.h5", mpm->step,
						 mpm->time, run->folder);
	return STATUS_OK;
}

/* ---- from the scene to the first step ---- */

static int run_set_times(struct run *run)
{
	const struct scene *scene = run->scene;
	double end = isnan(run->options->until) ? scene->time.end : run->options->until;
	if (!(end >= 0) || end / scene->time.step > 9e15)
		return error_set(STATUS_INPUT, "--until: expected a time in s, at least 0");
	run->last_step = (long long)ceil(end / scene->time.step - 1e-6);
	run->history_every = schedule_steps(scene, scene->output.history_every);
	run->snapshot_every = schedule_steps(scene, scene->output.snapshot_every);
	run->checkpoint_every = schedule_steps(scene, scene->output.checkpoint_every);
	return STATUS_OK;
}

void run_choose_paths(struct scene *scene, const char *devices)
{
	const bool any = rve_devices_any(devices);
	for (int l = 0; any && l < scene->n_laws; l++)
		if (scene->laws[l].type == SCENE_LAW_RVE && scene->laws[l].rve.path == SCENE_RVE_AUTO)
			scene->laws[l].rve.path = SCENE_RVE_SERIAL;
}

int run_use_devices(struct mpm *mpm, const char *devices, char *note, size_t note_bytes)
{
	note[0] = '\0';
	for (int l = 0; l < mpm->n_laws && strcmp(devices, "cpu") != 0; l++) {
		struct law *law = mpm->laws[l];
		if (law->type->use_devices)
			CHECK(law->type->use_devices(law, devices, note, note_bytes));
	}
	if (!note[0] && strcmp(devices, "cpu") != 0 && strcmp(devices, "auto") != 0)
		return error_set(STATUS_INPUT,
						 "--device %s: no law of this scene computes on devices, only RVEs do; leave the option out or "
						 "say --device cpu",
						 devices);
	return STATUS_OK;
}

static int run_prepare(struct run *run)
{
	const struct run_options *options = run->options;
	bool restart = options->restart != NULL;
	CHECK(folder_name(run->folder, options->out, options->restart, options->scene_path));
	CHECK(scene_load(&run->scene, options->scene_path, options->n_sets, options->sets, stderr));
	CHECK(images_check(run->scene, stderr));
	if (options->steering)
		CHECK(steering_script_read(&run->script, options->steering));
	CHECK(scripts_check(options));
	CHECK(run_set_times(run));
	CHECK(folder_check(run->folder, options->force, restart));
	if (restart)
		CHECK(checkpoint_check_scene(options->restart, run->scene));
	if (options->threads > 0)
		omp_set_num_threads(options->threads);
	run->threads = omp_get_max_threads();
	run_choose_paths(run->scene, options->device);
	CHECK(mpm_create(&run->mpm, run->scene));
	CHECK(history_memory_create(&run->memory, run->scene->n_regions, run->scene->n_cracks));
	if (restart)
		CHECK(checkpoint_read(options->restart, run->mpm, &run->memory, options->allow_path_change));
	CHECK(run_use_devices(run->mpm, options->device, run->device_note, sizeof run->device_note));
	run->devices = run->device_note[0] ? run->device_note : NULL;
	if (run->mpm->step > run->last_step)
		return error_set(STATUS_INPUT, "%s stands at %.9g s, after the end of this run", options->restart,
						 run->mpm->time);
	run->first_step = run->mpm->step;
	CHECK(fields_create(&run->fields, run->mpm));
	return inspected_create(&run->inspected, run->mpm, run->fields);
}

/* What a run that was killed had begun to write here. */
static void run_sweep(const struct run *run)
{
	static const char *const places[] = {"", "snap", "vtk", "rve"};
	char path[FILE_PATH];
	for (size_t k = 0; k < sizeof places / sizeof *places; k++)
		if (run_path(run, places[k], path) == STATUS_OK)
			file_sweep(path);
}

static int run_open(struct run *run)
{
	char path[FILE_PATH], moved[FILE_PATH];
	CHECK(folder_make(run->folder, run->options->force && !run->options->restart, moved, &run->folder_lock));
	if (run->options->restart)
		run_sweep(run);
	CHECK(run_path(run, "log.txt", path));
	CHECK(log_open(&run->log, path));
	if (moved[0])
		log_line(&run->log, "the old folder is now %s", moved);
	CHECK(run_path(run, "history.csv", path));
	bool continues = run->options->restart && file_exists(path);
	CHECK(history_create(&run->history, path, run->mpm, run->fields, &run->memory, continues));
	CHECK(watch_open(run));
	CHECK(steered_open(run, continues));
	CHECK(paths_create(&run->paths, run->inspected, run->folder, run->options->restart, &run->log));
	CHECK(snapshots_create(&run->snapshots, run->inspected, run->folder, continues));
	run->builder = frame_builder_create();
	if (!run->builder)
		return error_set(STATUS_RESOURCE, "out of memory");
	return report_write(run, "running");
}

/* What this run may do wrong without being stopped. */
static void announce_guards(struct run *run)
{
	const struct scene_guards *g = &run->scene->guards;
	const struct {
		const char *name;
		bool on;
	} guards[] = {{"energy_residual", g->energy_residual > 0.0},
				  {"energy_created", g->energy_created > 0.0},
				  {"time_step", g->time_step},
				  {"thermal_step", g->thermal_step},
				  {"dem_step", g->dem_step},
				  {"numerical_fracture", g->numerical_fracture}};
	for (size_t k = 0; k < sizeof guards / sizeof *guards; k++)
		if (!guards[k].on)
			log_warning(&run->log, "guards.%s is off: nothing stops this run where its results become wrong",
						guards[k].name);
}

static void run_announce(struct run *run)
{
	const struct run_options *options = run->options;
	struct law_counts counts;
	log_line(&run->log, "%s: %d points, %d x %d nodes, %lld steps of %g s, %d threads, output in %s",
			 options->scene_path, run->mpm->p.n, run->mpm->grid.nx, run->mpm->grid.ny, run->last_step - run->first_step,
			 run->scene->time.step, run->threads, run->folder);
	if (run->devices)
		log_line(&run->log, "RVEs on %s", run->devices);
	if (options->restart)
		log_line(&run->log, "continues %s from step %lld, time %.9g s", options->restart, run->mpm->step,
				 run->mpm->time);
	if (run->mpm->thermal && run->scene->thermal.time_scale != 1.0)
		log_warning(
			&run->log,
			"thermal.time_scale: heat conduction, fluxes and convection run %g times faster than the mechanics and "
			"the clock; friction heat does not",
			run->scene->thermal.time_scale);
	announce_guards(run);
	run_counts(run, &counts);
	run->first_disc_steps = counts.disc_steps;
}

/* ---- life ---- */

static int run_all(struct run *run)
{
	double start = clock_seconds();
	CHECK(run_prepare(run));
	signals_install();
	CHECK(run_open(run));
	run_announce(run);
	run->loop_start = clock_seconds();
	run->setup_time = run->loop_start - start;
	clock_t cpu = clock();
	int status = run_loop(run);
	run->loop_time = clock_seconds() - run->loop_start;
	run->loop_cpu = (double)(clock() - cpu) / CLOCKS_PER_SEC;
	return status;
}

static void run_close(struct run *run)
{
	log_close(&run->log);
	watch_free(run);
	snapshots_free(run->snapshots);
	frame_builder_free(run->builder);
	steering_free(run->steering);
	steering_script_free(&run->script);
	inspected_free(run->inspected);
	fields_free(run->fields);
	history_memory_free(&run->memory);
	mpm_free(run->mpm);
	scene_free(run->scene);
}

static const char *run_state(int status)
{
	switch (status) {
	case STATUS_OK:
		return "done";
	case STATUS_INTERRUPTED:
		return "interrupted";
	case STATUS_GUARD:
		return "guard";
	default:
		return "failed";
	}
}

/* Closes the files, whatever happened; the first failure counts. */
static int run_finish(struct run *run, int status)
{
	char message[2048];
	snprintf(message, sizeof message, "%s", status == STATUS_OK ? "" : error_message());
	watch_finish(run);
	int closed[] = {steering_close(run->steering), history_close(run->history), paths_close(run->paths)};
	steering_socket_close(run->socket);
	for (size_t i = 0; i < sizeof closed / sizeof *closed; i++)
		if (status == STATUS_OK && closed[i] != STATUS_OK)
			status = closed[i], snprintf(message, sizeof message, "%s", error_message());
	if (status != STATUS_OK)
		error_set(status, "%s", message); /* the reason that run.json gives */
	if (run->log.file && run->loop_start > 0) {
		report_judge(run);
		int reported = report_write(run, run_state(status));
		if (status == STATUS_OK && reported != STATUS_OK)
			status = reported, snprintf(message, sizeof message, "%s", error_message());
		report_print(run);
	}
	if (run->log.file && status != STATUS_OK)
		fprintf(run->log.file, "%10.3f %s\n", log_elapsed(&run->log), message);
	return status == STATUS_OK ? status : error_set(status, "%s", message);
}

int run_scene(const struct run_options *options)
{
	struct run *run = calloc(1, sizeof *run);
	if (!run)
		return error_set(STATUS_RESOURCE, "out of memory");
	run->options = options;
	log_start(&run->log, options->quiet);
	int status = run_finish(run, run_all(run));
	run_close(run);
	free(run);
	return status;
}
