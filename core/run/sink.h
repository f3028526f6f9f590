/* What sinks with a viewer process have in common: its notices go to the log, its cost to the report, and when it is
 * gone for good the run goes on without. */
#ifndef TMDEMPM_RUN_SINK_H
#define TMDEMPM_RUN_SINK_H

#include "run/log.h"
#include "run/viewer.h"

struct sink {
	const char *products;  /* "pictures": what there is no more of when the viewer is gone */
	struct run_log *log;
	struct viewer *viewer; /* NULL: none (any more) */
	double waited, cpu;    /* s, of a viewer that has ended */
};

/* A viewer could not be started: error_message() says why, once, and the run goes on without. */
void sink_absent(struct sink *sink);
/* What the viewer has to tell goes to the log. */
void sink_notices(struct sink *sink);
/* A call has failed for good: says so and ends the viewer. */
void sink_lost(struct sink *sink);
/* Returns when everything asked for is done. */
void sink_flush(struct sink *sink);
/* Waits for what is outstanding and ends the viewer. */
void sink_finish(struct sink *sink);

double sink_waited(const struct sink *sink); /* s that the engine has waited */
double sink_cpu(const struct sink *sink);    /* s of processor time that the viewer has taken */

#endif
