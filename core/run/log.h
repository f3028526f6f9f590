/* What a run says: log.txt, and the terminal unless it was asked to be quiet. */
#ifndef TMDEMPM_RUN_LOG_H
#define TMDEMPM_RUN_LOG_H

#include <stdbool.h>
#include <stdio.h>

enum { LOG_WARNINGS = 64 };

struct run_log {
	FILE *file;     /* log.txt; NULL before it is open */
	bool quiet;     /* nothing but warnings and errors on the terminal */
	bool line_open; /* a progress line stands on the terminal without its end */
	double start;   /* s, monotonic clock */
	int n_warnings; /* all of them; the first LOG_WARNINGS are kept for run.json */
	char *warnings[LOG_WARNINGS];
};

void log_start(struct run_log *log, bool quiet);
int log_open(struct run_log *log, const char *path); /* appends */
void log_close(struct run_log *log);

/* A line for people; a warning is also counted and repeated in run.json. */
void log_line(struct run_log *log, const char *format, ...) __attribute__((format(printf, 2, 3)));
void log_warning(struct run_log *log, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* The progress line: rewritten in place on a terminal, else a line of its own. */
void log_progress(struct run_log *log, const char *text);

/* Seconds since log_start(). */
double log_elapsed(const struct run_log *log);

/* Monotonic seconds. */
double clock_seconds(void);

#endif
