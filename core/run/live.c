#include "run/live.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/error.h"
#include "io/file.h"
#include "run/run_private.h"
#include "run/steering.h"

static const char SOURCE[] = "paraview";
static const double SILENCE = 5.0; /* s, after which one says that the client does not keep up */
static const double SLACK = 0.2;   /* s of a viewer's time beyond its share: a first look is not to wait for minutes */

struct live {
	struct sink sink;
	struct steering *steering;
	char host[SCENE_NAME];
	int port, every; /* every so many steps */
	bool asked, linked, thins, silent;
	int pid, fed; /* viewer processes: the one at work, the one that has had its first frame */
	long long shown_before, dropped_before; /* when this client came */
	double since, cpu_before;               /* the same, s */
	double busy_since;                      /* s, 0 = it keeps up */
	struct live_counts counts;
};

int live_address(const char *text, char host[SCENE_NAME], int *port)
{
	const char *colon = strrchr(text, ':'), *number = colon ? colon + 1 : text;
	char *end;
	long value = strtol(number, &end, 10);
	size_t length = colon ? (size_t)(colon - text) : 0;
	if (end == number || *end || value < 1 || value > 65534 || length >= SCENE_NAME || (colon && length == 0))
		return error_set(STATUS_INPUT, "--live %s: expected a port (1 .. 65534) or host:port", text);
	snprintf(host, SCENE_NAME, "%.*s", colon ? (int)length : 9, colon ? text : "127.0.0.1");
	*port = (int)value;
	return STATUS_OK;
}

/* ---- what is heard ---- */

static void live_come(struct live *live)
{
	live->linked = true;
	live->counts.clients++;
	live->shown_before = live->counts.shown, live->dropped_before = live->counts.dropped;
	live->since = clock_seconds();
	live->cpu_before = viewer_cpu(live->sink.viewer);
	live->counts.seconds = 0;
	live->busy_since = 0;
	live->thins = live->silent = false;
	viewer_forgive(live->sink.viewer);
	log_line(live->sink.log, "live: ParaView has connected");
}

static void live_go(struct live *live)
{
	if (!live->linked)
		return;
	live->linked = false;
	log_line(live->sink.log, "live: ParaView has gone; it was shown %lld frames, %lld were dropped",
			 live->counts.shown - live->shown_before, live->counts.dropped - live->dropped_before);
	steering_source_lost(live->steering, SOURCE);
}

static void live_hear(void *data, const struct frame_message *message)
{
	struct live *live = data;
	if (message->kind == FRAME_MSG_NOTE)
		log_warning(live->sink.log, "%s", message->text);
	else if (message->kind == FRAME_MSG_LINK)
		(message->n ? live_come : live_go)(live);
	else if (message->kind == FRAME_MSG_STEER)
		steering_offer(live->steering, SOURCE, message->text);
}

static void live_serve(struct live *live)
{
	if (!live->sink.viewer)
		return;
	int status = viewer_poll(live->sink.viewer);
	if (status != STATUS_OK || viewer_pid(live->sink.viewer) != live->pid)
		live_go(live); /* with the viewer that had it */
	live->pid = viewer_pid(live->sink.viewer);
	sink_notices(&live->sink);
	if (status != STATUS_OK)
		sink_lost(&live->sink);
}

static int live_descriptor(void *data)
{
	const struct live *live = data;
	return live->sink.viewer ? viewer_descriptor(live->sink.viewer) : -1;
}

static void live_serve_transport(void *data) { live_serve(data); }

void live_steer(struct live *live, struct steering *steering)
{
	struct steering_transport transport = {live_descriptor, live_serve_transport, live};
	live->steering = steering;
	if (live->sink.viewer)
		steering_add_transport(steering, &transport);
}

/* ---- start ---- */

static void live_explain(const struct live *live)
{
	char machine[256] = "this-machine";
	gethostname(machine, sizeof machine - 1);
	int port = live->port;
	struct run_log *log = live->sink.log;
	log_line(log, "live: waits for a ParaView that listens at %s:%d, now or later", live->host, port);
	if (strcmp(live->host, "127.0.0.1") && strcmp(live->host, "localhost")) {
		log_line(log, "live:   start there  paraview --live %d  or choose Catalyst > Connect, port %d", port, port);
		return;
	}
	log_line(log, "live:   on this machine:  paraview --live %d  or Catalyst > Connect, port %d; coloured at once: "
				  "paraview --script=pipelines/live.py", port, port);
	log_line(log, "live:   on another one:  ssh -R %d:localhost:%d -R %d:localhost:%d %s  and the same there", port, port,
			 port + 1, port + 1, machine);
}

static int live_start(struct live *live, const char *folder)
{
	char log[FILE_PATH];
	CHECK(file_join(log, folder, "log.txt"));
	CHECK(viewer_start_live(&live->sink.viewer, live->host, live->port, log));
	viewer_listen(live->sink.viewer, live_hear, live);
	live->pid = viewer_pid(live->sink.viewer);
	live_explain(live);
	return STATUS_OK;
}

int live_create(struct live **result, const struct scene *scene, const struct run_options *options, const char *folder,
				struct run_log *log)
{
	struct live *live = *result = calloc(1, sizeof *live);
	if (!live)
		return error_set(STATUS_RESOURCE, "out of memory");
	const struct scene_live *wish = &scene->catalyst.live;
	live->sink = (struct sink){.products = "live connection", .log = log};
	live->every = wish->every;
	live->counts.share_max = wish->share;
	live->asked = wish->on || options->live;
	live->port = wish->port;
	snprintf(live->host, sizeof live->host, "%s", wish->host);
	if (options->live && options->live[0])
		CHECK(live_address(options->live, live->host, &live->port));
	if (live->asked && live_start(live, folder) != STATUS_OK)
		sink_absent(&live->sink);
	return STATUS_OK;
}

/* ---- frames ---- */

/* The share of the time since the client came that its viewer takes: on the other cores of the machine, and here. */
static bool live_within_share(struct live *live)
{
	long cores = sysconf(_SC_NPROCESSORS_ONLN);
	double cost = live->counts.seconds + (viewer_cpu(live->sink.viewer) - live->cpu_before) / (double)(cores > 0 ? cores : 1);
	bool within = cost <= live->counts.share_max * (clock_seconds() - live->since) + SLACK;
	if (!within && !live->thins)
		log_line(live->sink.log, "live: frames thin out: they would take more than %g%% of the run's time (catalyst.live.share)",
				 100 * live->counts.share_max);
	live->thins |= !within;
	return within;
}

/* A client that hangs is said once, and that it is back. */
static bool live_keeps_up(struct live *live)
{
	bool idle = viewer_idle(live->sink.viewer);
	double time = clock_seconds();
	if (idle) {
		if (live->silent)
			log_line(live->sink.log, "live: ParaView answers again; %lld frames were dropped since it came",
					 live->counts.dropped - live->dropped_before);
		live->busy_since = 0;
		live->silent = false;
		return true;
	}
	if (live->busy_since == 0)
		live->busy_since = time;
	if (!live->silent && time - live->busy_since > SILENCE) {
		log_line(live->sink.log, "live: ParaView does not answer; frames for it are dropped meanwhile");
		live->silent = true;
	}
	return false;
}

bool live_due(struct live *live, long long step, bool now)
{
	live_serve(live);
	if (!live->sink.viewer)
		return false;
	if (live->fed != live->pid) /* before its first frame a viewer has nothing to show, and looks for nobody */
		return viewer_idle(live->sink.viewer);
	if (!live->linked || (!now && step % live->every))
		return false;
	if (!live_keeps_up(live)) {
		live->counts.dropped++;
		return false;
	}
	if (!live->sink.viewer)
		return false;
	if (now || live_within_share(live))
		return true;
	live->counts.thinned++;
	return false;
}

bool live_ready(struct live *live)
{
	live_serve(live);
	return live->linked && live->sink.viewer && viewer_idle(live->sink.viewer);
}

void live_offer(struct live *live, const void *frame, int64_t bytes, bool last, double seconds)
{
	double start = clock_seconds();
	if (!live->sink.viewer)
		return;
	live->fed = live->pid;
	live->counts.shown += live->linked;
	if (viewer_offer(live->sink.viewer, frame, bytes, last) != STATUS_OK)
		sink_lost(&live->sink);
	live->counts.seconds += seconds + clock_seconds() - start;
}

bool live_get_counts(const struct live *live, struct live_counts *counts)
{
	if (live)
		*counts = live->counts;
	return live && live->asked;
}

struct sink *live_sink(struct live *live) { return live ? &live->sink : NULL; }

void live_free(struct live *live)
{
	if (!live)
		return;
	sink_finish(&live->sink);
	free(live);
}
