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
#include <stdio.h>

#include "run/steering_command.h"

struct steering;

/* ---- what brings commands ---- */

/* Queues a command.  `source` says who wants it ("paraview"): it stands in the log, and a pause belongs to it.
 * Never fails towards the caller: what is wrong is said in the run's log. */
void steering_offer(struct steering *steering, const char *source, const char *command);

/* The source has gone (its client has left, died, or cannot be reached): a run that it has paused goes on, unless
 * another source has paused it too. */
void steering_source_lost(struct steering *steering, const char *source);

/* The same for an asker who is told what became of it: `answer` is called once, with STATUS_OK and what was done when
 * that is done (of step=N: after the steps), or with another status and what was wrong. */
typedef void steering_answer(void *asker, int status, const char *text);
void steering_ask(struct steering *steering, const char *source, const char *command, steering_answer *answer,
				  void *asker);

/* The asker has gone: no more answers to it, and what it holds (pause=hold) goes on. */
void steering_forget(struct steering *steering, void *asker);

/* Something that brings commands: serve() is called between two steps when descriptor() (asked anew each time; -1 =
 * none) is readable, which is looked at every few milliseconds; during a pause also once a second in any case. */
struct steering_transport {
	int (*descriptor)(void *data);
	void (*serve)(void *data);
	void *data;
};
enum { STEERING_TRANSPORTS = 4 };
void steering_add_transport(struct steering *steering, const struct steering_transport *transport);

/* Is the run paused (and not doing the steps of step=N)? */
bool steering_paused(const struct steering *steering);

/* The run as it is, for people: `name  value` lines. */
void steering_describe(const struct steering *steering, FILE *to);

/* ---- the run ---- */

enum { STEERING_SAID = 512 };

/* What a run lets steering do.  All calls come from within the calls below. */
struct steering_host {
	void *data;
	void (*when)(void *data, long long *step, double *time);
	/* Inspects, sets an interval or saves.  `since` >= 0: a restart takes up what has been in force since that step;
	 * -1: it begins now.  May put an exact command in the place of one that says where (at:); that is logged.  `said` =
	 * what was done.  What fails is no failure of the run. */
	int (*act)(void *data, struct steering_command *command, long long since, char said[STEERING_SAID]);
	void (*say)(void *data, const char *text); /* to the run's log */
	void (*describe)(void *data, FILE *to);    /* what steering itself does not know */
	/* During a pause, each time that something may have changed: those who watch see it.  NULL = nobody does. */
	void (*waits)(void *data);
};

/* A log to be repeated: steering.csv of another run. */
struct steering_script {
	int n;
	struct steering_row {
		long long step;
		double time; /* s */
		struct steering_command command;
	} * rows;
};

/* STATUS_INPUT with file:line for what is no log of steering. */
int steering_script_read(struct steering_script *script, const char *path);
void steering_script_free(struct steering_script *script);

/* `log` is where steering.csv will be, made with its first row; `script` (may be NULL) stays the caller's. */
int steering_create(struct steering **steering, const struct steering_host *host, const char *log,
					const struct steering_script *script);

/* A restart: takes up what the log `from` says was in force at the state that goes on.  Our own log is cut there; of
 * another folder's, the rows are copied to ours. */
int steering_restore(struct steering *steering, const char *from);

/* Between two steps: what has been asked for is done; returns when the run shall go on.  A failure is that of the log.
 */
int steering_between(struct steering *steering);

/* Has somebody asked to stop? */
bool steering_stops(const struct steering *steering);

/* How many commands stand in the log, and the seconds spent in pauses. */
int steering_count(const struct steering *steering);
double steering_pause_time(const struct steering *steering);

int steering_sync(struct steering *steering);

/* The run has ended: whoever still waits is told so, and the log is closed.  NULL is allowed, here and below. */
int steering_close(struct steering *steering);
void steering_free(struct steering *steering);

#endif
