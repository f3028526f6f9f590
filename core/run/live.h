/* The live connection to a ParaView: frames are offered, never awaited. */
#ifndef TMDEMPM_RUN_LIVE_H
#define TMDEMPM_RUN_LIVE_H

#include <stdbool.h>
#include <stdint.h>

#include "run/run.h"
#include "run/sink.h"
#include "scene/scene.h"

struct live;
struct steering;

/* Reads "22222" or "host:22222"; STATUS_INPUT if it is neither. */
int live_address(const char *text, char host[SCENE_NAME], int *port);

/* Starts the viewer of the live connection if the scene or --live asks for one, and says what a person has to do to
 * see it; `*live` stays usable without.  */
int live_create(struct live **live, const struct scene *scene, const struct run_options *options, const char *folder,
				struct run_log *log);

/* Commands of the client go to `steering` as source "paraview". */
void live_steer(struct live *live, struct steering *steering);

/* Is a frame wanted now?  At every so many steps while a client is there and keeps up, and the viewer's share of the
 * run's time allows; `now` = at this step in any case (the run's last; a pause begins).  Takes what the viewer has to
 * say, so it is called at each step. */
bool live_due(struct live *live, long long step, bool now);

/* Would a client get a frame now, whatever is due? */
bool live_ready(struct live *live);

/* Offers a frame of which live_due() or live_ready() was told; `seconds` = what it took to make it. */
void live_offer(struct live *live, const void *frame, int64_t bytes, bool last, double seconds);

struct live_counts {
	long long shown;   /* frames that a client was offered and got */
	long long dropped; /* frames that were due while the viewer was busy with its client */
	long long thinned; /* frames that were due and left out for the share of time */
	int clients;       /* that have come */
	double seconds;    /* of the engine, for making and copying frames */
	double share_max;  /* what the share may be */
};
/* False if no live connection was asked for. */
bool live_get_counts(const struct live *live, struct live_counts *counts);

struct sink *live_sink(struct live *live);
void live_free(struct live *live);

#endif
