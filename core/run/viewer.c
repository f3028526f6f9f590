/* Starts, feeds, watches and buries tmdempm-viewer.  Whatever the viewer does (abort, hang, kill -9), the
 * engine goes on; however the engine ends, the viewer ends with it (PR_SET_PDEATHSIG, and end of file on the
 * socket). */
#define _GNU_SOURCE /* memfd_create, close_range, fallocate */

#include "run/viewer.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <poll.h>
#include <signal.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "base/error.h"

enum {
	N_SLOTS = 3,
	N_FAILURES = 16,
	NOTICE = 4096,
	FAILURE_HUNG = -1, /* beside wait statuses, which are not negative */
	LIVE_GRACE = 20,   /* ticks that a live viewer has for its last frame */
	TICK_MS = 100      /* of waiting; a longer tick than this was a sleep of ours (Ctrl-Z) and does not count */
};

/* KEPT: worked through, but the viewer still refers to it. */
enum slot_state { SLOT_FREE, SLOT_BUSY, SLOT_KEPT };

struct slot {
	int64_t offset, capacity; /* in the memory file */
	void *map;
	enum slot_state state;
	long long number; /* order of the requests */
	struct frame_message request;
};

struct viewer {
	char program[PATH_MAX];
	char *log_path;
	struct frame_message purpose; /* what a new process is told first, */
	int n_parts;                  /* and the packets that follow it */
	size_t part_bytes;
	char *parts;
	void (*hear)(void *data, const struct frame_message *message);
	void *hear_data;
	pid_t pid; /* 0 = none runs */
	int socket, memory;
	int64_t memory_bytes;
	struct slot slots[N_SLOTS];
	long long n_requests;
	int n_failed;                         /* pictures asked for and not made */
	int n_failures, failures[N_FAILURES]; /* kinds seen; each is forgiven once */
	bool ready;
	char given_up[1024];    /* why, "" = still at work */
	double timeout, waited; /* s */
	double cpu_ended, cpu_start; /* s: of processes that have ended; of this one when it was ready */
	char notice[NOTICE], notice_out[NOTICE];
};

bool viewer_is_live(const struct viewer *viewer) { return viewer->purpose.kind == FRAME_MSG_LIVE; }

/* What is not made when this viewer fails. */
static const char *viewer_products(const struct viewer *viewer)
{
	return viewer_is_live(viewer) ? "live connection" : viewer->purpose.kind == FRAME_MSG_SCRIPTS ? "scripts" : "pictures";
}

static double now(void)
{
	struct timespec t;
	clock_gettime(CLOCK_MONOTONIC, &t);
	return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

__attribute__((format(printf, 2, 3))) static void note(struct viewer *viewer, const char *format, ...)
{
	size_t used = strlen(viewer->notice);
	va_list args;
	va_start(args, format);
	if (used + 2 < NOTICE) {
		if (used)
			viewer->notice[used++] = '\n';
		vsnprintf(viewer->notice + used, NOTICE - used, format, args);
	}
	va_end(args);
}

const char *viewer_notice(struct viewer *viewer)
{
	if (!viewer->notice[0])
		return NULL;
	memcpy(viewer->notice_out, viewer->notice, NOTICE);
	viewer->notice[0] = '\0';
	return viewer->notice_out;
}

void viewer_set_timeout(struct viewer *viewer, double seconds) { viewer->timeout = seconds; }
double viewer_waited(const struct viewer *viewer) { return viewer->waited; }
int viewer_pid(const struct viewer *viewer) { return (int)viewer->pid; }

const char *viewer_program(void)
{
	static char path[PATH_MAX];
	const char *asked = getenv("TMDEMPM_VIEWER");
	if (asked && *asked)
		return access(asked, X_OK) == 0 && strlen(asked) < PATH_MAX ? strcpy(path, asked) : NULL;
	char self[PATH_MAX];
	ssize_t n = readlink("/proc/self/exe", self, sizeof self - 1);
	if (n <= 0)
		return NULL;
	self[n] = '\0';
	char *name = strrchr(self, '/');
	if (!name)
		return NULL;
	*name = '\0';
	static const char *const places[] = {"", "/../bin"};
	for (size_t k = 0; k < sizeof places / sizeof *places; k++) {
		int length = snprintf(path, sizeof path, "%s%s/tmdempm-viewer", self, places[k]);
		if (length < (int)sizeof path && access(path, X_OK) == 0)
			return path;
	}
	return NULL;
}

bool viewer_has_catalyst(void)
{
	char path[PATH_MAX];
	const char *program = viewer_program(), *name = program ? strrchr(program, '/') : NULL;
	int length = name ? snprintf(path, sizeof path, "%.*stmdempm-catalyst.so", (int)(name + 1 - program), program) : -1;
	return length > 0 && length < (int)sizeof path && access(path, R_OK) == 0;
}

/* ---- memory: slots in one anonymous file; a slot that must grow moves to the file's end ---- */

static int memory_create(struct viewer *viewer)
{
	viewer->memory = memfd_create("tmdempm-frames", MFD_CLOEXEC | MFD_ALLOW_SEALING);
	if (viewer->memory < 0)
		return error_set(STATUS_RESOURCE, "cannot create memory for frames: %s", strerror(errno));
	/* Nobody can cut the file under our mapping (which would be a SIGBUS here). */
	if (fcntl(viewer->memory, F_ADD_SEALS, F_SEAL_SHRINK) < 0)
		return error_set(STATUS_RESOURCE, "cannot seal the memory for frames: %s", strerror(errno));
	return STATUS_OK;
}

static int slot_fit(struct viewer *viewer, struct slot *slot, int64_t bytes)
{
	if (bytes <= slot->capacity)
		return STATUS_OK;
	int64_t page = sysconf(_SC_PAGESIZE);
	int64_t capacity = (bytes + bytes / 2 + page - 1) / page * page;
	/* Reserved now: a full memory is an error here instead of a SIGBUS in the copy. */
	int failure = posix_fallocate(viewer->memory, viewer->memory_bytes, capacity);
	if (failure)
		return error_set(STATUS_RESOURCE, "no memory for a frame of %lld bytes: %s", (long long)bytes,
						 strerror(failure));
	void *map = mmap(NULL, (size_t)capacity, PROT_READ | PROT_WRITE, MAP_SHARED, viewer->memory, viewer->memory_bytes);
	if (map == MAP_FAILED)
		return error_set(STATUS_RESOURCE, "cannot map a frame of %lld bytes: %s", (long long)bytes, strerror(errno));
	if (slot->map) {
		munmap(slot->map, (size_t)slot->capacity);
		fallocate(viewer->memory, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, slot->offset, slot->capacity);
	}
	slot->offset = viewer->memory_bytes;
	slot->capacity = capacity;
	slot->map = map;
	viewer->memory_bytes += capacity;
	return STATUS_OK;
}

/* ---- the process ---- */

/* Between fork and exec: only async-signal-safe calls (other threads may have held locks). */
static void child_run(const char *program, pid_t engine, int socket, int memory, int log)
{
	static char *const arguments[] = {"tmdempm-viewer", NULL};
	extern char **environ;
	prctl(PR_SET_PDEATHSIG, SIGKILL);
	if (getppid() != engine)
		_exit(126);
	/* Ctrl-C and `kill` reach the whole group; the engine alone decides what they mean. */
	static const int ignored[] = {SIGINT, SIGTERM, SIGHUP, SIGUSR1, SIGUSR2};
	for (size_t k = 0; k < sizeof ignored / sizeof *ignored; k++)
		signal(ignored[k], SIG_IGN);
	signal(SIGPIPE, SIG_DFL);
	sigset_t none;
	sigemptyset(&none);
	sigprocmask(SIG_SETMASK, &none, NULL);

	socket = fcntl(socket, F_DUPFD, 16);
	memory = fcntl(memory, F_DUPFD, 16);
	int null = open("/dev/null", O_RDWR);
	if (log >= 0)
		log = fcntl(log, F_DUPFD, 16);
	dup2(null, 0);
	dup2(log >= 0 ? log : 2, 1);
	if (log >= 0)
		dup2(log, 2);
	dup2(socket, FRAME_FD_SOCKET);
	dup2(memory, FRAME_FD_MEMORY);
	if (close_range(FRAME_FD_MEMORY + 1, ~0U, 0) < 0) { /* kernel before 5.9 */
		long most = sysconf(_SC_OPEN_MAX);
		for (int fd = FRAME_FD_MEMORY + 1; fd < (most > 0 && most < 65536 ? most : 65536); fd++)
			close(fd);
	}
	execve(program, arguments, environ);
	_exit(127);
}

static int process_spawn(struct viewer *viewer)
{
	int ends[2];
	if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) < 0)
		return error_set(STATUS_RESOURCE, "cannot create a socket for the viewer: %s", strerror(errno));
	int log = -1;
	if (viewer->log_path && (log = open(viewer->log_path, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666)) < 0) {
		close(ends[0]), close(ends[1]);
		return error_set(STATUS_RESOURCE, "cannot write %s: %s", viewer->log_path, strerror(errno));
	}
	pid_t engine = getpid(), pid = fork();
	if (pid == 0)
		child_run(viewer->program, engine, ends[1], viewer->memory, log);
	int failure = errno;
	close(ends[1]);
	if (log >= 0)
		close(log);
	if (pid < 0) {
		close(ends[0]);
		return error_set(STATUS_RESOURCE, "cannot start the viewer: %s", strerror(failure));
	}
	viewer->socket = ends[0];
	viewer->pid = pid;
	viewer->ready = false;
	return STATUS_OK;
}

/* Waits for the process to end, up to `ticks`.  True: it is gone and forgotten; *status is 0 if nobody knows
 * (SIGCHLD ignored by whoever started us). */
static bool process_wait(struct viewer *viewer, int ticks, int *status)
{
	for (*status = 0; viewer->pid; ticks--) {
		pid_t pid = waitpid(viewer->pid, status, WNOHANG);
		if (pid == viewer->pid || (pid < 0 && errno != EINTR))
			viewer->pid = 0;
		else if (ticks <= 0)
			return false;
		else
			poll(NULL, 0, TICK_MS);
	}
	return true;
}

static double process_cpu(const struct viewer *viewer)
{
	clockid_t id;
	struct timespec t;
	if (!viewer->pid || clock_getcpuclockid(viewer->pid, &id) != 0 || clock_gettime(id, &t) != 0)
		return 0;
	return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

double viewer_cpu(struct viewer *viewer)
{
	double now = viewer->ready ? process_cpu(viewer) - viewer->cpu_start : 0;
	return viewer->cpu_ended + (now > 0 ? now : 0);
}

/* Ends the process for good if it still runs; returns its wait status.  One that even SIGKILL cannot end at
 * once (it waits for a dead disk) is left to die alone. */
static int process_bury(struct viewer *viewer)
{
	int status;
	viewer->cpu_ended = viewer_cpu(viewer);
	viewer->ready = false;
	if (!process_wait(viewer, 0, &status)) {
		kill(viewer->pid, SIGKILL);
		process_wait(viewer, 50, &status);
	}
	if (viewer->socket >= 0)
		close(viewer->socket);
	viewer->pid = 0;
	viewer->socket = -1;
	return status;
}

/* A process whose socket has ended is about to end itself: gives it a moment, so that its own status is the
 * one we report. */
static int process_reap_dying(struct viewer *viewer)
{
	int status, killed;
	viewer->cpu_ended = viewer_cpu(viewer);
	viewer->ready = false;
	bool gone = process_wait(viewer, viewer_is_live(viewer) ? 1 : 20, &status);
	killed = process_bury(viewer);
	return gone ? status : killed;
}

static void failure_describe(int kind, char *text, size_t size)
{
	if (kind == FAILURE_HUNG)
		snprintf(text, size, "did not answer in time");
	else if (WIFSIGNALED(kind))
		snprintf(text, size, "was ended by signal %d (%s)", WTERMSIG(kind), strsignal(WTERMSIG(kind)));
	else if (WEXITSTATUS(kind) == 127)
		snprintf(text, size, "could not be executed");
	else
		snprintf(text, size, "ended by itself with exit code %d", WEXITSTATUS(kind));
}

/* ---- messages ---- */

/* False: the viewer is dead, or has not read for a whole time-out. */
static bool message_send(struct viewer *viewer, const void *message, size_t bytes)
{
	for (double silence = 0; silence <= viewer->timeout; silence += 1e-3 * TICK_MS) {
		ssize_t n = send(viewer->socket, message, bytes, MSG_NOSIGNAL | MSG_DONTWAIT);
		if (n == (ssize_t)bytes)
			return true;
		if (n < 0 && errno != EINTR && errno != EAGAIN)
			return false;
		poll(&(struct pollfd){.fd = viewer->socket, .events = POLLOUT}, 1, TICK_MS);
	}
	return false;
}

static void slot_release(struct viewer *viewer, int k, bool failed)
{
	if (k < 0 || k >= N_SLOTS || viewer->slots[k].state == SLOT_FREE)
		return;
	viewer->n_failed += failed && viewer->slots[k].state == SLOT_BUSY;
	viewer->slots[k].state = SLOT_FREE;
}

static void message_handle(struct viewer *viewer, struct frame_message *message)
{
	message->text[sizeof message->text - 1] = '\0';
	switch (message->kind) {
	case FRAME_MSG_READY:
		viewer->ready = true;
		viewer->cpu_start = process_cpu(viewer);
		break;
	case FRAME_MSG_KEPT:
		if (message->slot >= 0 && message->slot < N_SLOTS && viewer->slots[message->slot].state == SLOT_BUSY)
			viewer->slots[message->slot].state = SLOT_KEPT;
		break;
	case FRAME_MSG_DONE:
		slot_release(viewer, message->slot, false);
		break;
	case FRAME_MSG_FAILED:
		if (message->slot >= 0)
			note(viewer, "%s: %s", viewer->purpose.kind == FRAME_MSG_IMAGES ? "picture not made" : "frame not used",
				 message->text);
		else
			snprintf(viewer->given_up, sizeof viewer->given_up, "%s", message->text);
		slot_release(viewer, message->slot, true);
		break;
	default:
		if (viewer->hear)
			viewer->hear(viewer->hear_data, message);
		break;
	}
}

void viewer_listen(struct viewer *viewer, void (*hear)(void *data, const struct frame_message *message), void *data)
{
	viewer->hear = hear;
	viewer->hear_data = data;
}

enum answer { ANSWER, ANSWER_NONE, ANSWER_END };

/* Takes one message, waiting up to `ms`. */
static enum answer message_take(struct viewer *viewer, int ms)
{
	struct pollfd poll_fd = {.fd = viewer->socket, .events = POLLIN};
	if (poll(&poll_fd, 1, ms) <= 0)
		return ANSWER_NONE;
	struct frame_message message;
	ssize_t n = recv(viewer->socket, &message, sizeof message, MSG_DONTWAIT);
	if (n < 0 && errno == ECONNRESET) /* it died with our messages unread; its own last words come after this */
		n = recv(viewer->socket, &message, sizeof message, MSG_DONTWAIT);
	if (n == (ssize_t)sizeof message) {
		message_handle(viewer, &message);
		return ANSWER;
	}
	return n < 0 && (errno == EAGAIN || errno == EINTR) ? ANSWER_NONE : ANSWER_END;
}

/* ---- states to wait for ---- */

static bool is_ready(const struct viewer *viewer) { return viewer->ready; }

static int slot_free(const struct viewer *viewer)
{
	for (int k = 0; k < N_SLOTS; k++)
		if (viewer->slots[k].state == SLOT_FREE)
			return k;
	return -1;
}

static bool has_free_slot(const struct viewer *viewer) { return slot_free(viewer) >= 0; }

static bool is_idle(const struct viewer *viewer)
{
	for (int k = 0; k < N_SLOTS; k++)
		if (viewer->slots[k].state == SLOT_BUSY)
			return false;
	return true;
}

/* Takes messages until `reached`; every answer starts the time-out again.  False: the viewer is dead (and
 * buried) or has said that it cannot work; *kind tells how. */
static bool wait_until(struct viewer *viewer, bool (*reached)(const struct viewer *), int *kind)
{
	double start = now(), silence = 0;
	bool alive = true;
	while (message_take(viewer, 0) == ANSWER)
		continue;
	while (alive && !reached(viewer)) {
		double before = now();
		enum answer answer = message_take(viewer, TICK_MS);
		double tick = now() - before;
		silence = answer == ANSWER ? 0 : silence + (tick < 2e-3 * TICK_MS ? tick : 2e-3 * TICK_MS);
		if (answer == ANSWER_END || viewer->given_up[0]) {
			*kind = process_reap_dying(viewer);
			alive = false;
		} else if (silence > viewer->timeout) {
			process_bury(viewer);
			*kind = FAILURE_HUNG;
			alive = false;
		}
	}
	viewer->waited += now() - start;
	return alive;
}

/* Starts a process and tells it what it is for. */
static int viewer_begin(struct viewer *viewer)
{
	CHECK(process_spawn(viewer));
	for (int k = 0; k < N_SLOTS; k++)
		if (viewer->slots[k].state == SLOT_KEPT)
			viewer->slots[k].state = SLOT_FREE;
	bool sent = message_send(viewer, &viewer->purpose, sizeof viewer->purpose);
	for (int k = 0; sent && k < viewer->n_parts; k++)
		sent = message_send(viewer, viewer->parts + (size_t)k * viewer->part_bytes, viewer->part_bytes);
	return STATUS_OK; /* if it died already, the next wait sees that */
}

/* The same, and waits until it is ready. */
static int viewer_launch(struct viewer *viewer)
{
	CHECK(viewer_begin(viewer));
	int kind = 0;
	if (wait_until(viewer, is_ready, &kind))
		return STATUS_OK;
	if (viewer->given_up[0])
		return error_set(STATUS_RESOURCE, "%s", viewer->given_up);
	char how[256];
	failure_describe(kind, how, sizeof how);
	return error_set(STATUS_RESOURCE, "the viewer %s %s at its start (see %s)", viewer->program, how,
					 viewer->log_path ? viewer->log_path : "its messages");
}

static int viewer_give_up(struct viewer *viewer)
{
	process_bury(viewer);
	for (int k = 0; k < N_SLOTS; k++)
		slot_release(viewer, k, true);
	return error_set(STATUS_RESOURCE, "%s; no more %s in this run", viewer->given_up, viewer_products(viewer));
}

static bool failure_is_new(struct viewer *viewer, int kind)
{
	for (int k = 0; k < viewer->n_failures; k++)
		if (viewer->failures[k] == kind)
			return false;
	if (viewer->n_failures == N_FAILURES)
		return false;
	viewer->failures[viewer->n_failures++] = kind;
	return true;
}

/* Sends again, in their order, what the dead viewer had not drawn: the frames still lie in their slots. */
static bool resend(struct viewer *viewer)
{
	long long last = -1;
	for (;;) {
		struct slot *next = NULL;
		for (int k = 0; k < N_SLOTS; k++) {
			struct slot *slot = &viewer->slots[k];
			if (slot->state == SLOT_BUSY && slot->number > last && (!next || slot->number < next->number))
				next = slot;
		}
		if (!next)
			return true;
		if (!message_send(viewer, &next->request, sizeof next->request))
			return false;
		last = next->number;
	}
}

/* After a death of this kind: restarts once, else gives up for good. */
static int viewer_recover(struct viewer *viewer, int kind)
{
	char how[256];
	failure_describe(kind, how, sizeof how);
	if (viewer->given_up[0])
		return viewer_give_up(viewer);
	if (!failure_is_new(viewer, kind)) {
		snprintf(viewer->given_up, sizeof viewer->given_up, "the viewer %s again", how);
		return viewer_give_up(viewer);
	}
	note(viewer, "the viewer %s; starting it again", how);
	if (viewer_is_live(viewer)) /* whoever watches sees the next frame, not those that the dead one had */
		for (int k = 0; k < N_SLOTS; k++)
			slot_release(viewer, k, true);
	if ((viewer_is_live(viewer) ? viewer_begin : viewer_launch)(viewer) != STATUS_OK) {
		if (!viewer->given_up[0])
			snprintf(viewer->given_up, sizeof viewer->given_up, "%s", error_message());
		return viewer_give_up(viewer);
	}
	resend(viewer); /* if it dies here, the next wait sees that */
	return STATUS_OK;
}

/* Waits for a state, across restarts. */
static int viewer_await(struct viewer *viewer, bool (*reached)(const struct viewer *))
{
	int kind;
	while (!viewer->given_up[0] && !wait_until(viewer, reached, &kind))
		CHECK(viewer_recover(viewer, kind));
	return viewer->given_up[0] ? viewer_give_up(viewer) : STATUS_OK;
}

/* ---- the interface ---- */

static void viewer_free(struct viewer *viewer)
{
	process_bury(viewer);
	for (int k = 0; k < N_SLOTS; k++)
		if (viewer->slots[k].map)
			munmap(viewer->slots[k].map, (size_t)viewer->slots[k].capacity);
	if (viewer->memory >= 0)
		close(viewer->memory);
	free(viewer->parts);
	free(viewer->log_path);
	free(viewer);
}

static int viewer_create(struct viewer **out, const struct frame_message *purpose, const void *parts, size_t part_bytes,
						 const char *log_path)
{
	*out = NULL;
	const char *program = viewer_program();
	if (!program)
		return error_set(STATUS_RESOURCE, "tmdempm-viewer is not there: install paraview-dev, python3-paraview, "
										  "libpython3-dev and xvfb and build with -DTMDEMPM_INSITU=ON (or name "
										  "it in TMDEMPM_VIEWER)");
	struct viewer *viewer = calloc(1, sizeof *viewer);
	if (!viewer)
		return error_set(STATUS_RESOURCE, "no memory for the viewer");
	int n = purpose->kind == FRAME_MSG_LIVE ? 0 : purpose->n;
	viewer->socket = viewer->memory = -1;
	viewer->timeout = 60;
	snprintf(viewer->program, sizeof viewer->program, "%s", program);
	viewer->purpose = *purpose;
	viewer->n_parts = n, viewer->part_bytes = part_bytes;
	viewer->parts = malloc(part_bytes * (size_t)n + 1);
	viewer->log_path = log_path ? strdup(log_path) : NULL;
	if (!viewer->parts || (log_path && !viewer->log_path)) {
		viewer_free(viewer);
		return error_set(STATUS_RESOURCE, "no memory for the viewer");
	}
	if (n)
		memcpy(viewer->parts, parts, part_bytes * (size_t)n);
	*out = viewer;
	return STATUS_OK;
}

static int viewer_start_for(struct viewer **viewer, const struct frame_message *purpose, const void *parts,
							size_t part_bytes, const char *log_path)
{
	struct viewer *made = NULL;
	*viewer = NULL;
	CHECK(viewer_create(&made, purpose, parts, part_bytes, log_path));
	int status = memory_create(made);
	if (status == STATUS_OK)
		status = viewer_launch(made);
	if (status != STATUS_OK) {
		viewer_free(made);
		return status;
	}
	*viewer = made;
	return STATUS_OK;
}

int viewer_start(struct viewer **viewer, int n_images, const struct frame_image *images, const char *log_path)
{
	struct frame_message purpose = {.kind = FRAME_MSG_IMAGES, .slot = -1, .image = -1, .n = n_images};
	return viewer_start_for(viewer, &purpose, images, sizeof *images, log_path);
}

int viewer_start_scripts(struct viewer **viewer, int n_scripts, const char *const *scripts, const char *folder,
						 const char *log_path)
{
	struct frame_message purpose = {.kind = FRAME_MSG_SCRIPTS, .slot = -1, .image = -1, .n = n_scripts};
	*viewer = NULL;
	struct frame_message *parts = calloc((size_t)n_scripts + 1, sizeof *parts);
	if (!parts)
		return error_set(STATUS_RESOURCE, "no memory for the viewer");
	bool fits = snprintf(purpose.text, sizeof purpose.text, "%s", folder) < (int)sizeof purpose.text;
	for (int k = 0; k < n_scripts; k++) {
		parts[k] = (struct frame_message){.kind = FRAME_MSG_SCRIPT, .slot = -1, .image = -1};
		fits &= snprintf(parts[k].text, sizeof parts[k].text, "%s", scripts[k]) < (int)sizeof parts[k].text;
	}
	int status = fits ? viewer_start_for(viewer, &purpose, parts, sizeof *parts, log_path)
					  : error_set(STATUS_RESOURCE, "the path of a script is too long");
	free(parts);
	return status;
}

int viewer_start_live(struct viewer **viewer, const char *host, int port, const char *log_path)
{
	struct frame_message purpose = {.kind = FRAME_MSG_LIVE, .slot = -1, .image = -1, .n = port};
	snprintf(purpose.text, sizeof purpose.text, "%s", host);
	return viewer_start_for(viewer, &purpose, NULL, 0, log_path);
}

/* Copies a frame into a free slot and asks for the work; there is one. */
static int viewer_request(struct viewer *viewer, const void *frame, struct frame_message *request)
{
	request->slot = slot_free(viewer);
	struct slot *slot = &viewer->slots[request->slot];
	CHECK(slot_fit(viewer, slot, request->bytes));
	memcpy(slot->map, frame, (size_t)request->bytes);
	request->offset = slot->offset;
	slot->request = *request;
	slot->number = viewer->n_requests++;
	slot->state = SLOT_BUSY;
	if (message_send(viewer, request, sizeof *request))
		return STATUS_OK;
	return viewer_recover(viewer, process_reap_dying(viewer));
}

/* The same, waiting for the slot. */
static int viewer_request_surely(struct viewer *viewer, const void *frame, struct frame_message *request)
{
	long long before = viewer->n_requests;
	int status = viewer_await(viewer, has_free_slot);
	if (status == STATUS_OK)
		status = viewer_request(viewer, frame, request);
	if (status != STATUS_OK && viewer->n_requests == before)
		viewer->n_failed++; /* else its slot has been counted */
	return status;
}

int viewer_draw(struct viewer *viewer, const void *frame, int64_t bytes, int image, const char *path)
{
	struct frame_message draw = {.kind = FRAME_MSG_DRAW, .bytes = bytes, .image = image};
	if (snprintf(draw.text, sizeof draw.text, "%s", path) >= (int)sizeof draw.text) {
		viewer->n_failed++;
		return error_set(STATUS_RESOURCE, "the path of a picture is too long: %s", path);
	}
	return viewer_request_surely(viewer, frame, &draw);
}

int viewer_give(struct viewer *viewer, const void *frame, int64_t bytes, bool last)
{
	struct frame_message give = {.kind = FRAME_MSG_FRAME, .bytes = bytes, .image = -1, .n = last};
	return viewer_request_surely(viewer, frame, &give);
}

int viewer_poll(struct viewer *viewer)
{
	if (viewer->given_up[0])
		return viewer_give_up(viewer);
	enum answer answer;
	while ((answer = message_take(viewer, 0)) == ANSWER)
		continue;
	if (answer == ANSWER_END || viewer->given_up[0])
		return viewer_recover(viewer, process_reap_dying(viewer));
	return STATUS_OK;
}

bool viewer_idle(struct viewer *viewer)
{
	return viewer_poll(viewer) == STATUS_OK && viewer->ready && is_idle(viewer) && has_free_slot(viewer);
}

int viewer_offer(struct viewer *viewer, const void *frame, int64_t bytes, bool last)
{
	struct frame_message offer = {.kind = FRAME_MSG_FRAME, .bytes = bytes, .image = -1, .n = last};
	return viewer_request(viewer, frame, &offer);
}

int viewer_descriptor(const struct viewer *viewer) { return viewer->socket; }

void viewer_forgive(struct viewer *viewer) { viewer->n_failures = 0; }

int viewer_flush(struct viewer *viewer) { return viewer_await(viewer, is_idle); }

/* A live viewer may hang with its client: it has a moment for its last frame and to say goodbye, no more. */
static void viewer_leave(struct viewer *viewer, const struct frame_message *quit)
{
	int status;
	for (int tick = 0; tick < LIVE_GRACE && viewer->pid && !is_idle(viewer); tick++)
		if (message_take(viewer, TICK_MS) == ANSWER_END)
			break;
	if (viewer->pid && send(viewer->socket, quit, sizeof *quit, MSG_NOSIGNAL | MSG_DONTWAIT) > 0 && is_idle(viewer))
		process_wait(viewer, LIVE_GRACE / 2, &status);
	process_bury(viewer);
}

int viewer_finish(struct viewer *viewer)
{
	if (!viewer)
		return 0;
	struct frame_message quit = {.kind = FRAME_MSG_QUIT, .slot = -1, .image = -1};
	if (viewer_is_live(viewer)) {
		viewer_leave(viewer, &quit);
	} else {
		viewer_flush(viewer);
		if (viewer->pid && message_send(viewer, &quit, sizeof quit))
			process_reap_dying(viewer);
	}
	int failed = viewer_is_live(viewer) ? 0 : viewer->n_failed;
	viewer_free(viewer);
	return failed;
}
