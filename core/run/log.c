#include "run/log.h"

#include <errno.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <time.h>
#include <unistd.h>

#include "base/error.h"

double clock_seconds(void)
{
	struct timespec now;
	clock_gettime(CLOCK_MONOTONIC, &now);
	return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double log_elapsed(const struct run_log *log) { return clock_seconds() - log->start; }

void log_start(struct run_log *log, bool quiet) { *log = (struct run_log){.quiet = quiet, .start = clock_seconds()}; }

int log_open(struct run_log *log, const char *path)
{
	log->file = fopen(path, "ae");
	if (!log->file)
		return error_set(STATUS_RESOURCE, "cannot write %s: %s", path, strerror(errno));
	setvbuf(log->file, NULL, _IOLBF, 0);
	return STATUS_OK;
}

void log_close(struct run_log *log)
{
	if (log->line_open)
		fputc('\n', stderr);
	log->line_open = false;
	if (log->file)
		fclose(log->file);
	log->file = NULL;
	for (int w = 0; w < log->n_warnings && w < LOG_WARNINGS; w++) {
		free(log->warnings[w]);
		log->warnings[w] = NULL;
	}
}

static void log_write(struct run_log *log, bool terminal, const char *prefix, const char *text)
{
	if (log->file)
		fprintf(log->file, "%10.3f %s%s\n", log_elapsed(log), prefix, text);
	if (!terminal)
		return;
	if (log->line_open)
		fputc('\n', stderr);
	log->line_open = false;
	fprintf(stderr, "tmdempm: %s%s\n", prefix, text);
}

void log_line(struct run_log *log, const char *format, ...)
{
	char text[2048];
	va_list args;
	va_start(args, format);
	vsnprintf(text, sizeof text, format, args);
	va_end(args);
	log_write(log, !log->quiet, "", text);
}

void log_warning(struct run_log *log, const char *format, ...)
{
	char text[2048];
	va_list args;
	va_start(args, format);
	vsnprintf(text, sizeof text, format, args);
	va_end(args);
	log_write(log, true, "warning: ", text);
	if (log->n_warnings < LOG_WARNINGS)
		log->warnings[log->n_warnings] = strdup(text);
	log->n_warnings++;
}

void log_progress(struct run_log *log, const char *text)
{
	if (log->quiet)
		return;
	if (isatty(STDERR_FILENO)) {
		struct winsize window;
		bool known = ioctl(STDERR_FILENO, TIOCGWINSZ, &window) == 0 && window.ws_col > 1;
		/* a line that wraps could not be rewritten */
		fprintf(stderr, "\r%.*s\033[K", known ? window.ws_col - 1 : 79, text);
		log->line_open = true;
	} else {
		fprintf(stderr, "%s\n", text);
	}
	fflush(stderr);
}
