/* Catalyst pipelines of a scene and of the command line: scripts in ParaView's Python that get frames. */
#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "run/run_private.h"

struct scripts {
	struct sink sink;
	long long every; /* steps */
};

/* Traceback of a script that was dropped, and the like. */
static void scripts_hear(void *data, const struct frame_message *message)
{
	struct scripts *scripts = data;
	if (message->kind == FRAME_MSG_NOTE)
		log_warning(scripts->sink.log, "%s", message->text);
}

int scripts_check(const struct run_options *options)
{
	char absolute[PATH_MAX];
	for (int k = 0; k < options->n_pipelines; k++)
		if (!realpath(options->pipelines[k], absolute))
			return error_set(STATUS_INPUT, "--pipeline %s: cannot be read, expected a script of ParaView Catalyst",
							 options->pipelines[k]);
	return STATUS_OK;
}

static int scripts_start(struct scripts *scripts, int n, const char *const *paths, const char *folder)
{
	char place[FILE_PATH], log[FILE_PATH];
	CHECK(file_join(place, folder, "catalyst"));
	CHECK(file_make_folder(place));
	CHECK(file_join(log, folder, "log.txt"));
	char *absolute_place = realpath(place, NULL), *absolute_log = realpath(log, NULL);
	int status = !absolute_place || !absolute_log
					 ? error_set(STATUS_RESOURCE, "%s is not there", folder)
					 : viewer_start_scripts(&scripts->sink.viewer, n, paths, absolute_place, absolute_log);
	free(absolute_place);
	free(absolute_log);
	if (status == STATUS_OK)
		viewer_listen(scripts->sink.viewer, scripts_hear, scripts);
	return status;
}

int scripts_create(struct scripts **result, const struct scene *scene, const struct run_options *options,
				   const char *folder, struct run_log *log)
{
	int n_scene = scene->catalyst.n_pipelines, n = n_scene + options->n_pipelines;
	struct scripts *scripts = calloc(1, sizeof *scripts);
	const char **paths = calloc((size_t)n + 1, sizeof *paths);
	char **absolute = calloc((size_t)n + 1, sizeof *absolute);
	int status = scripts && paths && absolute ? STATUS_OK : error_set(STATUS_RESOURCE, "out of memory");
	for (int k = 0; k < n && status == STATUS_OK; k++) {
		if (k >= n_scene && !(absolute[k] = realpath(options->pipelines[k - n_scene], NULL)))
			status = error_set(STATUS_INPUT, "--pipeline %s: cannot be read", options->pipelines[k - n_scene]);
		paths[k] = k < n_scene ? scene->catalyst.pipelines[k] : absolute[k];
	}
	if (status == STATUS_OK) {
		scripts->sink = (struct sink){.products = "scripts", .log = log};
		scripts->every = schedule_steps(scene, scene->catalyst.every);
		if (n > 0 && scripts_start(scripts, n, paths, folder) != STATUS_OK)
			sink_absent(&scripts->sink);
	}
	for (int k = 0; absolute && k < n; k++)
		free(absolute[k]);
	free(absolute);
	free(paths);
	if (status != STATUS_OK)
		free(scripts), scripts = NULL;
	*result = scripts;
	return status;
}

bool scripts_due(const struct scripts *scripts, long long step, bool last)
{
	return scripts->sink.viewer && (last || schedule_due(scripts->every, step));
}

void scripts_give(struct scripts *scripts, const void *frame, int64_t bytes, bool last)
{
	if (viewer_give(scripts->sink.viewer, frame, bytes, last) != STATUS_OK)
		sink_lost(&scripts->sink);
	sink_notices(&scripts->sink);
}

struct sink *scripts_sink(struct scripts *scripts) { return scripts ? &scripts->sink : NULL; }

void scripts_free(struct scripts *scripts)
{
	if (!scripts)
		return;
	sink_finish(&scripts->sink);
	free(scripts);
}
