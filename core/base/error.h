/* Errors: every function that can fail returns 0 or a status; the message travels beside it.
 *
 * The statuses are the program's exit codes (see `tmdempm --help`).  A function that fails calls
 * error_set() once, where the cause is known, with a message for the person who wrote the scene;
 * everyone above only passes the status on with CHECK().  The message is per thread. */
#ifndef TMDEMPM_BASE_ERROR_H
#define TMDEMPM_BASE_ERROR_H

enum status {
	STATUS_OK = 0,
	STATUS_INPUT = 2,        /* bad usage or input: what is wrong, what was expected */
	STATUS_GUARD = 3,        /* a method left its domain of validity */
	STATUS_RESOURCE = 4,     /* memory, disk, files, processes */
	STATUS_INTERRUPTED = 130 /* SIGINT or SIGTERM; the state was saved */
};

/* Records the message of a failure on this thread (replacing an earlier one) and returns `status`. */
int error_set(int status, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Puts "text: " before the recorded message; returns `status`.  For adding what was being done. */
int error_context(int status, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* The last recorded message of this thread, "" if none. */
const char *error_message(void);

/* Passes a failure on to the caller. */
#define CHECK(call)                         \
	do {                                    \
		int check_status_ = (call);         \
		if (check_status_ != STATUS_OK)     \
			return check_status_;           \
	} while (0)

#endif
