#include "run/sink.h"

#include "base/error.h"

void sink_absent(struct sink *sink)
{
	log_warning(sink->log, "no %s: %s", sink->products, error_message());
	sink->viewer = NULL;
}

void sink_notices(struct sink *sink)
{
	const char *notice;
	while (sink->viewer && (notice = viewer_notice(sink->viewer)))
		log_warning(sink->log, "viewer: %s", notice);
}

void sink_lost(struct sink *sink)
{
	log_warning(sink->log, "no more %s: %s", sink->products, error_message());
	sink_finish(sink);
}

void sink_flush(struct sink *sink)
{
	if (!sink->viewer)
		return;
	int status = viewer_flush(sink->viewer);
	sink_notices(sink);
	if (status != STATUS_OK)
		sink_lost(sink);
}

double sink_waited(const struct sink *sink)
{
	return sink->waited + (sink->viewer ? viewer_waited(sink->viewer) : 0);
}

double sink_cpu(const struct sink *sink) { return sink->cpu + (sink->viewer ? viewer_cpu(sink->viewer) : 0); }

void sink_finish(struct sink *sink)
{
	if (!sink->viewer)
		return;
	struct viewer *viewer = sink->viewer;
	sink->waited += viewer_waited(viewer);
	double start = clock_seconds();
	if (!viewer_is_live(viewer))
		viewer_flush(viewer); /* what fails here is counted by viewer_finish() */
	sink_notices(sink);
	sink->cpu += viewer_cpu(viewer);
	sink->viewer = NULL;
	int failed = viewer_finish(viewer);
	sink->waited += clock_seconds() - start;
	if (failed > 0)
		log_warning(sink->log, "%d %s could not be made; the reason stands in log.txt", failed, sink->products);
}
