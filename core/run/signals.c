#include <errno.h>
#include <signal.h>
#include <stdint.h>
#include <string.h>
#include <sys/eventfd.h>
#include <time.h>
#include <unistd.h>

#include "run/run_private.h"

static volatile sig_atomic_t stop_signal, checkpoint_wanted;
static volatile sig_atomic_t stop_second; /* of the monotonic clock, when the first request to stop came */
static int signals_event = -1;            /* readable when a signal has come: any thread may have taken it */

static void signals_wake(void)
{
	int error = errno;
	if (signals_event >= 0 && write(signals_event, &(uint64_t){1}, sizeof(uint64_t)) < 0)
		errno = error; /* full: it is readable already */
	errno = error;
}

/* A second request to stop ends the program at once, but one request may arrive twice: timeout(1), shells and
 * job schedulers signal the process and then its group. */
static void signals_on_stop(int number)
{
	struct timespec now;
	clock_gettime(CLOCK_MONOTONIC, &now);
	if (!stop_signal) {
		stop_second = (sig_atomic_t)now.tv_sec;
		stop_signal = number;
	} else if ((sig_atomic_t)now.tv_sec - stop_second > 1) {
		signal(number, SIG_DFL);
		raise(number);
	}
	signals_wake();
}

static void signals_on_user(int number)
{
	(void)number;
	checkpoint_wanted = 1;
	signals_wake();
}

void signals_install(void)
{
	struct sigaction action;
	if (signals_event < 0)
		signals_event = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
	memset(&action, 0, sizeof action);
	action.sa_flags = SA_RESTART;
	sigemptyset(&action.sa_mask);
	action.sa_handler = signals_on_stop;
	sigaction(SIGINT, &action, NULL);
	sigaction(SIGTERM, &action, NULL);
	struct sigaction hangup;
	if (sigaction(SIGHUP, NULL, &hangup) == 0 && hangup.sa_handler != SIG_IGN) /* nohup stays in force */
		sigaction(SIGHUP, &action, NULL);
	action.sa_handler = signals_on_user;
	sigaction(SIGUSR1, &action, NULL);
	action.sa_handler = SIG_IGN; /* a viewer that died is found by the write that fails */
	sigaction(SIGPIPE, &action, NULL);
	stop_signal = checkpoint_wanted = 0;
}

int signals_stop(void) { return stop_signal; }

int signals_descriptor(void) { return signals_event; }

bool signals_take_checkpoint(void)
{
	uint64_t count;
	if (checkpoint_wanted && signals_event >= 0 && read(signals_event, &count, sizeof count) < 0)
		count = 0; /* nobody waits on it */
	bool wanted = checkpoint_wanted;
	checkpoint_wanted = 0;
	return wanted;
}
