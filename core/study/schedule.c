#define _GNU_SOURCE /* wait4 */

#include <errno.h>
#include <limits.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "base/error.h"
#include "run/log.h"
#include "study/job.h"
#include "study/private.h"

struct running {
	pid_t pid;
	int combination;
	double start; /* s */
};

struct schedule {
	struct plan *plan;
	int jobs, n_running, next, n_missing, n_ended;
	struct running *running;
	char program[PATH_MAX];
	bool stopping;
	int status; /* of the study's own doing: the first failure */
};

/* ---- signals: taken in one place, so that none falls between two looks ---- */

static void signals_set(sigset_t *set)
{
	sigemptyset(set);
	sigaddset(set, SIGCHLD);
	sigaddset(set, SIGINT);
	sigaddset(set, SIGTERM);
	sigaddset(set, SIGHUP);
}

static void stop_children(struct schedule *s)
{
	s->stopping = true;
	for (int k = 0; k < s->n_running; k++)
		kill(s->running[k].pid, SIGTERM);
}

/* ---- one run after the other ---- */

static void announce(const struct schedule *s, const struct combination *c, double wall)
{
	const struct result *r = &c->result;
	printf("[%d/%d] %s: %s in %.2f s%s%s\n", s->n_ended, s->n_missing, c->name, outcome_name(r->outcome), wall,
		   r->reason[0] ? ": " : "", r->reason);
	fflush(stdout);
}

static void fail(struct schedule *s, int status)
{
	if (s->status == STATUS_OK)
		s->status = status;
	stop_children(s);
}

static bool is_missing(const struct combination *c) { return c->result.outcome == OUTCOME_NONE; }

static void start_next(struct schedule *s)
{
	while (!s->stopping && s->n_running < s->jobs && s->next < s->plan->n) {
		struct combination *c = &s->plan->combinations[s->next];
		struct running *run = &s->running[s->n_running];
		s->next++;
		if (!is_missing(c) || job_recall(c))
			continue;
		int status = job_start(s->plan->study, c, s->program, &run->pid);
		if (status != STATUS_OK) {
			fail(s, status);
			return;
		}
		run->combination = s->next - 1, run->start = clock_seconds();
		s->n_running++;
	}
}

static double seconds(struct timeval t) { return (double)t.tv_sec + 1e-6 * (double)t.tv_usec; }

static void collect(struct schedule *s)
{
	for (int k = 0; k < s->n_running;) {
		struct running run = s->running[k];
		struct rusage usage;
		int wait_status;
		if (wait4(run.pid, &wait_status, WNOHANG, &usage) != run.pid) {
			k++;
			continue;
		}
		s->running[k] = s->running[--s->n_running];
		struct combination *c = &s->plan->combinations[run.combination];
		double wall = clock_seconds() - run.start;
		if (s->stopping) /* whatever it was in the middle of: it will be run again */
			continue;
		int status = job_end(s->plan->study, c, wait_status, wall, seconds(usage.ru_utime) + seconds(usage.ru_stime));
		s->n_ended++;
		if (status != STATUS_OK)
			fail(s, status);
		else
			announce(s, c, wall);
	}
}

static int schedule_loop(struct schedule *s)
{
	sigset_t set, old;
	const struct timespec second = {1, 0};
	signals_set(&set);
	sigprocmask(SIG_BLOCK, &set, &old);
	for (;;) {
		start_next(s);
		if (s->n_running == 0)
			break;
		int number = sigtimedwait(&set, NULL, &second);
		if (number == SIGINT || number == SIGTERM || number == SIGHUP) {
			stop_children(s);
			if (s->status == STATUS_OK)
				s->status = error_set(STATUS_INTERRUPTED, "interrupted: the same command goes on where it was");
		}
		collect(s);
	}
	sigprocmask(SIG_SETMASK, &old, NULL);
	return s->status;
}

/* ---- the whole ---- */

static int own_program(char program[PATH_MAX])
{
	ssize_t n = readlink("/proc/self/exe", program, PATH_MAX - 1);
	if (n <= 0)
		return error_set(STATUS_RESOURCE, "cannot find this program's own file: %s", strerror(errno));
	program[n] = '\0';
	return STATUS_OK;
}

int schedule_run(struct plan *plan, const struct study_options *options)
{
	struct schedule s = {.plan = plan, .jobs = options->jobs};
	int recalled = 0;
	for (int k = 0; k < plan->n; k++) {
		struct combination *c = &plan->combinations[k];
		if (!c->folder[0]) { /* its scene was refused: it has no folder to look into, or to forget */
			recalled++;
			continue;
		}
		bool known = !options->fresh && job_recall(c);
		if (known && c->result.outcome == OUTCOME_FAILED) /* a full disk, a kill: not the method's doing */
			c->result.outcome = OUTCOME_NONE;
		if (options->fresh || c->result.outcome == OUTCOME_NONE)
			CHECK(job_forget(c));
		recalled += !is_missing(c);
	}
	s.n_missing = plan->n - recalled;
	printf("%s: %d runs, %d of them done before\n", plan->study->title[0] ? plan->study->title : plan->study->file,
		   plan->n, recalled);
	fflush(stdout);
	if (s.n_missing == 0)
		return STATUS_OK;
	CHECK(own_program(s.program));
	s.running = calloc((size_t)s.jobs, sizeof *s.running);
	if (!s.running)
		return error_set(STATUS_RESOURCE, "out of memory");
	int status = schedule_loop(&s);
	free(s.running);
	return status;
}
