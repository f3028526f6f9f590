#include <stdio.h>
#include <string.h>

#include "base/error.h"
#include "run/run_private.h"

static void steered_when(void *data, long long *step, double *time)
{
	const struct run *run = data;
	*step = run->mpm->step;
	*time = run->mpm->time;
}

static void steered_say(void *data, const char *text) { log_line(&((struct run *)data)->log, "%s", text); }

/* ---- the inspected RVEs ---- */

/* What is inspected under a name, in words. */
static int steered_name(const struct run *run, const struct inspected_rve *rve, char *text, size_t size)
{
	int point;
	CHECK(inspected_point(run->inspected, rve, &point));
	int id = point >= 0 ? run->mpm->p.id[point] : -1;
	snprintf(text, size, rve->rule ? "%s (now point %d)" : "%spoint:%d", rve->rule ? rve->rule->name : "", id);
	return STATUS_OK;
}

static int steered_inspect(struct run *run, struct steering_command *command, long long since, char said[STEERING_SAID])
{
	struct inspected_rve rve;
	char what[128];
	if (command->target == STEER_NOTHING) {
		if (!inspected_find(run->inspected, command->name))
			return error_set(STATUS_INPUT, "no RVE is inspected as \"%s\"", command->name);
		snprintf(said, STEERING_SAID, "%s is no longer inspected", command->name);
		inspected_remove(run->inspected, command->name);
		return since < 0 ? paths_stop(run->paths, command->name) : STATUS_OK;
	}
	CHECK(inspected_choose(run->inspected, command, &rve));
	rve.since = since < 0 ? run->mpm->step : since;
	CHECK(steered_name(run, &rve, what, sizeof what));
	snprintf(said, STEERING_SAID, "%s is %s", rve.name, what);
	if (inspected_is(run->inspected, &rve))
		return STATUS_OK;
	if (since < 0)
		CHECK(rve.rule ? paths_stop(run->paths, rve.name) : paths_start(run->paths, &rve));
	return inspected_set(run->inspected, &rve);
}

/* ---- one command ---- */

static int steered_save(struct run *run, char said[STEERING_SAID])
{
	CHECK(run_checkpoint(run));
	snprintf(said, STEERING_SAID, "checkpoint at step %lld, time %.6g s", run->mpm->step, run->mpm->time);
	return STATUS_OK;
}

static int steered_act(void *data, struct steering_command *command, long long since, char said[STEERING_SAID])
{
	struct run *run = data;
	switch (command->verb) {
	case STEER_CHECKPOINT:
		return steered_save(run, said);
	case STEER_IMAGE:
		snprintf(said, STEERING_SAID, "picture %s every %g s", command->name, command->every);
		return images_set_every(run->images, command->name, command->every);
	default:
		return steered_inspect(run, command, since, said);
	}
}

static void steered_describe(void *data, FILE *to)
{
	const struct run *run = data;
	const struct scene *scene = run->scene;
	char what[128];
	fprintf(to, "step       %lld of %lld\n", run->mpm->step, run->last_step);
	fprintf(to, "time       %.9g s of %.9g s\n", run->mpm->time, (double)run->last_step * scene->time.step);
	for (int i = 0; i < run->inspected->n; i++)
		if (steered_name(run, &run->inspected->rves[i], what, sizeof what) == STATUS_OK)
			fprintf(to, "inspect    %s=%s\n", run->inspected->rves[i].name, what);
	for (int i = 0; i < scene->n_images; i++)
		fprintf(to, "image      %s every %.9g s\n", scene->images[i].name, images_every(run->images, i));
}

static void steered_waits(void *data) { watch_wait(data); }

/* ---- life ---- */

/* The log that says what was in force: ours, or, in a new folder, that beside the checkpoint. */
static int steered_restore(struct run *run, const char *ours, bool continues)
{
	char folder[FILE_PATH], beside[FILE_PATH];
	CHECK(file_folder(folder, run->options->restart));
	CHECK(file_join(beside, folder, "steering.csv"));
	return steering_restore(run->steering, continues ? ours : beside);
}

int steered_open(struct run *run, bool continues)
{
	struct steering_host host = {run, steered_when, steered_act, steered_say, steered_describe, steered_waits};
	char log[FILE_PATH];
	CHECK(file_join(log, run->folder, "steering.csv"));
	CHECK(steering_create(&run->steering, &host, log, run->options->steering ? &run->script : NULL));
	live_steer(run->live, run->steering);
	if (run->options->restart)
		CHECK(steered_restore(run, log, continues));
	if (run->options->paused)
		steering_offer(run->steering, "--paused", "pause=1");
	int status = steering_socket_create(&run->socket, run->steering, run->folder, run->folder_lock);
	if (status != STATUS_OK && run->options->paused)
		return error_context(status, "--paused: `tmdempm steer` could not let this run go on");
	if (status != STATUS_OK) /* as on file systems without sockets */
		log_line(&run->log, "`tmdempm steer` cannot reach this run: %s", error_message());
	return STATUS_OK;
}

int steered_between(struct run *run)
{
	double before = steering_pause_time(run->steering);
	int status = steering_between(run->steering);
	run->loop_start += steering_pause_time(run->steering) - before;
	return status;
}
