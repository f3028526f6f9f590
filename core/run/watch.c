/* Those who look at a run: pictures, scripts, a live ParaView.  One frame serves all that want one at a step. */
#include "base/error.h"
#include "run/frame_build.h"
#include "run/run_private.h"

static struct sink *watch_sink(const struct run *run, int k)
{
	return k == 0 ? images_sink(run->images) : k == 1 ? scripts_sink(run->scripts) : live_sink(run->live);
}

int watch_open(struct run *run)
{
	CHECK(images_create(&run->images, run->mpm, run->folder, &run->log));
	CHECK(scripts_create(&run->scripts, run->scene, run->options, run->folder, &run->log));
	return live_create(&run->live, run->scene, run->options, run->folder, &run->log);
}

unsigned watch_due(struct run *run, bool last)
{
	long long step = run->mpm->step;
	return (images_due(run->images, step, last) ? WATCH_IMAGES : 0) |
		   (scripts_due(run->scripts, step, last) ? WATCH_SCRIPTS : 0) |
		   (live_due(run->live, step, last) ? WATCH_LIVE : 0);
}

void watch_show(struct run *run, unsigned due, const void *frame, int64_t bytes, bool last, double seconds)
{
	if (due & WATCH_LIVE) /* first: it never waits */
		live_offer(run->live, frame, bytes, last, seconds);
	if (due & WATCH_IMAGES)
		images_draw(run->images, frame, bytes, run->mpm->step, last);
	if (due & WATCH_SCRIPTS)
		scripts_give(run->scripts, frame, bytes, last);
}

int watch_wait(struct run *run)
{
	const void *frame;
	int64_t bytes;
	double begun = clock_seconds();
	bool seen = run->waited_step == run->mpm->step && run->waited_commands == steering_count(run->steering);
	if (seen || !live_ready(run->live))
		return STATUS_OK;
	CHECK(frame_build(run->builder, run->mpm, run->fields, run->inspected, &frame, &bytes));
	live_offer(run->live, frame, bytes, false, clock_seconds() - begun);
	run->waited_step = run->mpm->step;
	run->waited_commands = steering_count(run->steering);
	return STATUS_OK;
}

void watch_flush(struct run *run)
{
	if (run->images)
		sink_flush(images_sink(run->images));
	if (run->scripts)
		sink_flush(scripts_sink(run->scripts));
}

double watch_waited(const struct run *run)
{
	double waited = 0;
	for (int k = 0; k < WATCHERS; k++)
		waited += watch_sink(run, k) ? sink_waited(watch_sink(run, k)) : 0;
	return waited;
}

double watch_cpu(const struct run *run, int k) { return watch_sink(run, k) ? sink_cpu(watch_sink(run, k)) : 0; }

void watch_finish(struct run *run)
{
	for (int k = 0; k < WATCHERS; k++)
		if (watch_sink(run, k))
			sink_finish(watch_sink(run, k));
}

void watch_free(struct run *run)
{
	images_free(run->images);
	scripts_free(run->scripts);
	live_free(run->live);
}
