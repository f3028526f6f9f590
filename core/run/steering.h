/* Steering a run while it runs: commands as text, from a ParaView that watches, from `tmdempm steer`, or from a log.
 *
 *   pause=1 | pause=0          stops between two steps; goes on
 *   pause=hold                 the same for as long as its source is there
 *   step=N                     N steps, then (still) paused
 *   checkpoint=1               saves the state
 *   stop=1                     as SIGTERM: saves and leaves
 *   inspect.NAME=point:ID      inspects the RVE of this point under that name; NAME may be new
 *   inspect.NAME=at:X,Y        that of the point which is nearest to (X, Y) now
 *   inspect.NAME=RULE          hottest, most_sheared, highest_pressure, most_broken: followed over time
 *   inspect.NAME=none          no longer
 *   images.NAME.every=SECONDS  another interval for a picture of the scene; 0 = no more
 *
 * Commands are taken between two steps, in the order in which they came, and what they did is logged in steering.csv.
 * No command can harm the run: one that is wrong is answered and forgotten. */
#ifndef TMDEMPM_RUN_STEERING_H
#define TMDEMPM_RUN_STEERING_H

#include <stdbool.h>

struct steering;

/* Queues a command.  `source` says who wants it ("paraview"): it stands in the log, and a pause belongs to it.
 * Never fails towards the caller: what is wrong is said in the run's log. */
void steering_offer(struct steering *steering, const char *source, const char *command);

/* The source has gone (its client has left, died, or cannot be reached): a run that it has paused goes on. */
void steering_source_lost(struct steering *steering, const char *source);

/* Something that brings commands.  While the run is paused, serve() is called when descriptor() (>= 0; asked anew for
 * each wait) is readable, and once a second in any case; while it runs, its owner serves it. */
struct steering_transport {
	int (*descriptor)(void *data);
	void (*serve)(void *data);
	void *data;
};
void steering_add_transport(struct steering *steering, const struct steering_transport *transport);

/* Is the run paused, or going to be between this step and the next? */
bool steering_paused(const struct steering *steering);

#endif
