#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/error.h"
#include "mpm/shape.h"
#include "run/json.h"
#include "run/run_private.h"
#include "rve/model.h"
#include "version.h"

enum { INERTIA_BINS = 12, REPORT_NAME = 128 };

static double report_loop_time(const struct run *run)
{
	if (run->loop_time > 0)
		return run->loop_time;
	return run->loop_start > 0 ? clock_seconds() - run->loop_start : 0;
}

static double report_rate(double amount, double seconds) { return seconds > 0 ? amount / seconds : 0; }

static void report_options(struct json *json, const struct run *run)
{
	const struct run_options *options = run->options;
	json_open(json, "options", '{');
	json_text(json, "scene", options->scene_path);
	json_open(json, "set", '[');
	for (int i = 0; i < options->n_sets; i++)
		json_text(json, NULL, options->sets[i]);
	json_close(json, ']');
	json_text(json, "out", run->folder);
	json_text(json, "device", options->device);
	json_text(json, "devices", run->devices); /* what that meant; null where no law asks */
	json_integer(json, "threads", run->threads);
	json_text(json, "restart", options->restart); /* null if it was none */
	json_number(json, "until", options->until);
	json_text(json, "steering", options->steering);
	json_close(json, '}');
}

static void report_times(struct json *json, const struct run *run)
{
	json_open(json, "seconds", '{');
	json_number(json, "setup", run->setup_time);
	json_number(json, "law", 1e-9 * (double)run->mpm->law_time_ns);
	json_number(json, "mpm", 1e-9 * (double)run->mpm->mpm_time_ns);
	json_number(json, "output", run->output_time);
	json_number(json, "viewer_wait", watch_waited(run));
	json_number(json, "total", report_loop_time(run));
	json_number(json, "cpu", run->loop_cpu);
	json_number(json, "paused", steering_pause_time(run->steering)); /* not in the total */
	json_close(json, '}');
}

/* The share of the run's time that viewers have taken: what the engine waited and worked for them, and their processor
 * time, spread over the cores. */
static double report_viewer_share(const struct run *run)
{
	struct live_counts live = {0};
	long cores = sysconf(_SC_NPROCESSORS_ONLN);
	double cost = watch_waited(run), total = report_loop_time(run);
	live_get_counts(run->live, &live);
	for (int k = 0; k < WATCHERS; k++)
		cost += watch_cpu(run, k) / (double)(cores > 0 ? cores : 1);
	return total > 0 ? (cost + live.seconds) / total : 0;
}

static void report_viewers(struct json *json, const struct run *run)
{
	static const char *const names[WATCHERS] = {"cpu_images", "cpu_scripts", "cpu_live"};
	struct live_counts live;
	json_open(json, "viewers", '{');
	json_number(json, "share", report_viewer_share(run));
	for (int k = 0; k < WATCHERS; k++)
		json_number(json, names[k], watch_cpu(run, k));
	if (live_get_counts(run->live, &live)) {
		json_open(json, "live", '{');
		json_integer(json, "clients", live.clients);
		json_integer(json, "shown", live.shown);
		json_integer(json, "dropped", live.dropped);
		json_integer(json, "thinned_out", live.thinned);
		json_number(json, "share_max", live.share_max);
		json_close(json, '}');
	}
	json_close(json, '}');
}

static void report_counts(struct json *json, const struct run *run)
{
	struct law_counts counts;
	double seconds = report_loop_time(run), steps = (double)(run->mpm->step - run->first_step);
	run_counts(run, &counts);
	double disc_steps = (double)(counts.disc_steps - run->first_disc_steps - counts.twin_disc_steps); /* computed */
	json_open(json, "rates", '{');
	json_number(json, "point_steps_per_second", report_rate(steps * run->mpm->p.n, seconds));
	json_number(json, "disc_steps_per_second", report_rate(disc_steps, seconds));
	json_number(json, "disc_steps_per_second_of_law", report_rate(disc_steps, 1e-9 * (double)run->mpm->law_time_ns));
	json_close(json, '}');
	json_open(json, "rve", '{');
	json_integer(json, "disc_steps", counts.disc_steps);
	json_integer(json, "gas", counts.gas);
	json_integer(json, "frozen", counts.frozen);
	json_integer(json, "reseeded", counts.reseeded);
	json_integer(json, "clamped", counts.clamped);
	json_integer(json, "rebuilds", counts.rebuilds);
	json_open(json, "economy", '{');
	json_integer(json, "twin_steps", counts.twin_calls);
	json_integer(json, "twin_disc_steps", counts.twin_disc_steps);
	json_integer(json, "computed_steps", counts.calls);
	json_integer(json, "quiet_steps", counts.quiet_calls);
	json_integer(json, "quiet_caught_up", counts.quiet_caught);
	if (counts.quiet_caught > 0) {
		json_number(json, "quiet_stress_error_mean", counts.quiet_error_sum / (double)counts.quiet_caught);
		json_number(json, "quiet_stress_error_most", counts.quiet_error_most);
	}
	json_integer(json, "paced_steps", counts.paced_calls);
	json_integer(json, "paced_disc_steps_saved", counts.paced_saved);
	if (counts.paced_calls > 0) {
		json_number(json, "paced_stress_error_mean", counts.paced_error_sum / (double)counts.paced_calls);
		json_number(json, "paced_stress_error_most", counts.paced_error_most);
	}
	json_close(json, '}');
	json_integer(json, "bonds_installed", counts.bonds_installed);
	json_integer(json, "bonds_intact", counts.bonds_intact);
	json_open(json, "inertial_number_histogram", '[');
	for (int i = 0; i < INERTIA_BINS; i++)
		json_integer(json, NULL, counts.inertia[i]);
	json_close(json, ']');
	json_text(json, "inertial_number_bins", "below 1e-6, then two bins a decade up to 1e-1, then above");
	json_close(json, '}');
}

/* The files of a run, relative to its folder. */
struct report_files {
	int n, capacity;
	char (*names)[REPORT_NAME];
};

static void report_add_file(struct report_files *files, const struct run *run, const char *below, const char *name)
{
	char path[FILE_PATH], there[REPORT_NAME];
	if (snprintf(there, sizeof there, "%s%s", below, name) >= REPORT_NAME ||
		file_join(path, run->folder, there) != STATUS_OK || !file_exists(path))
		return;
	if (files->n == files->capacity) {
		int capacity = 2 * files->capacity + 32;
		char(*larger)[REPORT_NAME] = realloc(files->names, (size_t)capacity * sizeof *larger);
		if (!larger)
			return;
		files->names = larger, files->capacity = capacity;
	}
	memcpy(files->names[files->n++], there, REPORT_NAME);
}

/* Start states and paths of inspected RVEs, by name. */
static void report_add_rves(struct report_files *files, const struct run *run)
{
	char path[FILE_PATH];
	struct dirent **entries;
	int n = file_join(path, run->folder, "rve") == STATUS_OK ? scandir(path, &entries, NULL, alphasort) : -1;
	for (int k = 0; k < n; k++) {
		if (entries[k]->d_name[0] != '.')
			report_add_file(files, run, "rve/", entries[k]->d_name);
		free(entries[k]);
	}
	if (n >= 0)
		free(entries);
}

static struct report_files report_list(const struct run *run)
{
	static const char *const always[] = {"history.csv",   "run.json", "log.txt", "steering.csv",
										 "checkpoint.h5", "guard.h5", "run.h5"};
	struct report_files files = {0};
	for (size_t k = 0; k < sizeof always / sizeof *always; k++)
		report_add_file(&files, run, "", always[k]);
	report_add_rves(&files, run);
	for (int i = 0; snapshots_series(run->snapshots, i); i++)
		report_add_file(&files, run, "", snapshots_series(run->snapshots, i));
	return files;
}

static void report_outcome(struct json *json, const struct run *run, const char *state)
{
	const struct run_log *log = &run->log;
	json_open(json, "warnings", '[');
	for (int i = 0; i < log->n_warnings && i < LOG_WARNINGS; i++)
		json_text(json, NULL, log->warnings[i]);
	json_close(json, ']');
	json_integer(json, "warnings_count", log->n_warnings);
	if (strcmp(state, "done") && strcmp(state, "running"))
		json_text(json, "reason", error_message());
	json_open(json, "files", '[');
	struct report_files files = report_list(run);
	for (int i = 0; i < files.n; i++)
		json_text(json, NULL, files.names[i]);
	free(files.names);
	json_close(json, ']');
	json_integer(json, "steered", steering_count(run->steering));
	json_integer(json, "snapshots", snapshots_count(run->snapshots));
	json_open(json, "images", '[');
	for (int i = 0; i < images_count(run->images); i++)
		json_text(json, NULL, images_file(run->images, i));
	json_close(json, ']');
}

/* Which code computes, and where devices help: how many RVEs each of them has. */
static void report_code_path(const struct run *run, char *path, size_t size)
{
	checkpoint_code_path(run->mpm, path, size);
	for (int l = 0; run->devices && l < run->mpm->n_laws; l++) {
		const struct law *law = run->mpm->laws[l];
		char shares[CODE_PATH];
		size_t used = strlen(path);
		if (!law->type->shares)
			continue;
		law->type->shares(law, shares, sizeof shares);
		snprintf(path + used, size - used, "; RVEs of %s: %s", law->name, shares);
	}
}

static void report_fill(struct json *json, const struct run *run, const char *state)
{
	char code_path[2 * CODE_PATH];
	report_code_path(run, code_path, sizeof code_path);
	json_open(json, NULL, '{');
	json_text(json, "program", "tmdempm");
	json_text(json, "version", TMDEMPM_VERSION);
	json_text(json, "compiler", TMDEMPM_COMPILER);
	json_text(json, "build", TMDEMPM_BUILD_TYPE);
	json_text(json, "code_path", code_path);
	json_text(json, "rve_isa", rve_isa());
	json_text(json, "state", state);
	json_text(json, "title", run->scene->title);
	report_options(json, run);
	json_integer(json, "points", run->mpm->p.n);
	json_integer(json, "nodes", (long long)run->mpm->grid.nx * run->mpm->grid.ny);
	json_integer(json, "first_step", run->first_step);
	json_integer(json, "step", run->mpm->step);
	json_number(json, "time", run->mpm->time);
	json_number(json, "dt", run->mpm->dt);
	if (run->mpm->thermal)
		json_number(json, "thermal_time_scale", run->scene->thermal.time_scale);
	report_times(json, run);
	report_viewers(json, run);
	report_counts(json, run);
	report_outcome(json, run, state);
	json_close(json, '}');
}

/* ---- what no guard stops ---- */

static void judge_crossing(struct run *run)
{
	const struct mpm *mpm = run->mpm;
	int crossed = 0;
	if (isfinite(mpm->shape->lone(0.25)))
		return;
	for (int k = 0; k < mpm->p.n; k++) {
		bool far = false;
		for (int c = 0; c < 2; c++)
			far |= fabs(mpm->p.x[k][c] - grid_carried(mpm, mpm->p.x0[k][c], c)) > mpm->grid.spacing[c];
		crossed += far;
	}
	if (crossed > 0)
		log_warning(
			&run->log,
			"%d points have crossed grid cells with mpm.shape = \"%s\": their stress is noisy by a good part of "
			"itself; mpm.shape = \"ugimp\" is not",
			crossed, mpm->shape->name);
}

/* Shares of the calls beyond which the mean stress is not to be trusted (methods-rve: 40% at I = 0.037). */
static void judge_inertia(struct run *run)
{
	static const double most = 0.05;
	struct law_counts counts;
	double calls = 0.0, fast = 0.0;
	run_counts(run, &counts);
	for (int i = 0; i < INERTIA_BINS; i++)
		calls += (double)counts.inertia[i], fast += i >= INERTIA_BINS - 2 ? (double)counts.inertia[i] : 0.0;
	if (calls > 0.0 && fast > most * calls)
		log_warning(
			&run->log,
			"%.0f%% of the RVEs' steps had an inertial number above 0.03, where the mean stress is too large by "
			"40%% and more; a smaller time.step, rve.strain_per_step or a larger n_max makes them slower",
			100.0 * fast / calls);
	if (calls > 0.0 && (double)counts.clamped > most * calls)
		log_warning(&run->log,
					"n_max cut the DEM steps of %.0f%% of the RVEs' steps: they were strained faster than "
					"strain_per_step allows",
					100.0 * (double)counts.clamped / calls);
}

void report_judge(struct run *run)
{
	judge_crossing(run);
	judge_inertia(run);
}

int report_write(struct run *run, const char *state)
{
	char path[FILE_PATH];
	struct file_output output;
	CHECK(file_join(path, run->folder, "run.json"));
	CHECK(file_output_begin(&output, path));
	struct json json = {.stream = output.stream, .pretty = true};
	report_fill(&json, run, state);
	fputc('\n', output.stream);
	return file_output_commit(&output);
}

/* ---- for people ---- */

static void report_task(struct run *run, const char *task, double seconds, double total)
{
	log_line(&run->log, "  %-16s %9.2f s %5.1f %%", task, seconds, total > 0 ? 100 * seconds / total : 0);
}

/* What was not computed, and how wrong that may be. */
static void report_economy(struct run *run, const struct law_counts *counts)
{
	double steps = (double)(counts->disc_steps - run->first_disc_steps);
	if (counts->twin_disc_steps > 0)
		log_line(&run->log, "economy: twins saved %lld RVE steps, %.1f%% of all disc-steps; exact", counts->twin_calls,
				 100.0 * (double)counts->twin_disc_steps / steps);
	if (counts->quiet_calls > 0)
		log_line(&run->log,
				 "economy: quiet RVEs waited in %lld steps, %.1f%% of all; when they caught up (%lld times) their stress "
				 "was off by %.2g of the pressure on average, %.2g at most",
				 counts->quiet_calls,
				 100.0 * (double)counts->quiet_calls / (double)(counts->quiet_calls + counts->calls), counts->quiet_caught,
				 counts->quiet_error_sum / fmax((double)counts->quiet_caught, 1.0), counts->quiet_error_most);
	if (counts->paced_calls > 0)
		log_line(&run->log,
				 "economy: longer DEM steps in %.1f%% of the RVEs' steps saved %.1f%% of all disc-steps; they change the "
				 "stress by an estimated %.3g Pa on average, %.3g Pa at most",
				 100.0 * (double)counts->paced_calls / (double)counts->calls,
				 100.0 * (double)counts->paced_saved / ((double)counts->paced_saved + (double)counts->disc_steps),
				 counts->paced_error_sum / (double)counts->paced_calls, counts->paced_error_most);
}

static void report_print_times(struct run *run)
{
	double law = 1e-9 * (double)run->mpm->law_time_ns, mpm = 1e-9 * (double)run->mpm->mpm_time_ns;
	double viewer = watch_waited(run), total = report_loop_time(run);
	double steps = (double)(run->mpm->step - run->first_step);
	struct law_counts counts;
	run_counts(run, &counts);
	log_line(&run->log, "time per task (wall clock, %d threads):", run->threads);
	report_task(run, "law", law, total);
	report_task(run, "mpm", mpm, total);
	report_task(run, "output", run->output_time, total);
	report_task(run, "viewer wait", viewer, total);
	report_task(run, "total", total, total);
	if (report_viewer_share(run) > 0)
		log_line(&run->log, "  viewers took %.1f %% of the time (waited for, and on the machine's cores)",
				 100 * report_viewer_share(run));
	log_line(&run->log, "  %.4g point-steps/s, %.4g disc-steps/s", report_rate(steps * run->mpm->p.n, total),
			 report_rate((double)(counts.disc_steps - run->first_disc_steps - counts.twin_disc_steps), total));
	if (counts.disc_steps > 0)
		log_line(&run->log, "RVEs: %lld flying, %lld frozen, %lld re-seeded, %lld steps with N clamped", counts.gas,
				 counts.frozen, counts.reseeded, counts.clamped);
	report_economy(run, &counts);
	if (counts.bonds_installed > 0)
		log_line(&run->log, "bonds: %lld of %lld intact", counts.bonds_intact, counts.bonds_installed);
}

void report_print(struct run *run)
{
	report_print_times(run);
	if (run->log.quiet)
		return;
	printf("%s/\n", run->folder);
	struct report_files files = report_list(run);
	for (int i = 0; i < files.n; i++)
		if (!strcmp(files.names[i], "run.h5"))
			printf("  run.h5 (%d snapshots)\n", snapshots_count(run->snapshots));
		else
			printf("  %s\n", files.names[i]);
	free(files.names);
	for (int i = 0; i < images_count(run->images); i++)
		printf("  %s\n", images_file(run->images, i));
	fflush(stdout);
}
