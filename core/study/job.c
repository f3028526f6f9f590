#define _GNU_SOURCE /* asprintf */

#include <errno.h>
#include <fcntl.h>
#include <ftw.h>
#include <inttypes.h>
#include <math.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/error.h"
#include "base/hash.h"
#include "io/csv.h"
#include "run/json.h"
#include "sources.h"
#include "study/job.h"
#include "version.h"

static const char *const outcome_names[] = {"none", "done", "guard", "refused", "failed"};

const char *outcome_name(enum outcome outcome) { return outcome_names[outcome]; }

/* ---- who is who: a name for people and a hash of everything that decides the results ---- */

/* What a law reads from a file is not in the scene's text. */
static int hash_packings(uint64_t *hash, const struct scene *scene)
{
	for (int k = 0; k < scene->n_laws; k++) {
		const struct scene_law *law = &scene->laws[k];
		char *data;
		size_t size;
		if (law->type != SCENE_LAW_RVE || !law->rve.packing.file[0])
			continue;
		CHECK(file_read(&data, &size, law->rve.packing.file));
		*hash = hash_bytes(*hash, data, size);
		free(data);
	}
	return STATUS_OK;
}

/* Loading the scene also tells every mistake before the first run begins. */
static int hash_scene(uint64_t *hash, const struct study *study, const struct combination *c)
{
	struct scene *scene;
	char *messages = NULL;
	size_t size;
	FILE *errors = open_memstream(&messages, &size);
	if (!errors)
		return error_set(STATUS_RESOURCE, "out of memory");
	int status = scene_load(&scene, study->scene.file, c->sets.n, c->sets.items, errors);
	fclose(errors);
	if (status == STATUS_INPUT && study->stability) /* limits are what is studied: this is one */
		error_set(status, "%.*s", (int)strcspn(messages, "\n"), messages);
	else if (status != STATUS_OK)
		fputs(messages, stderr), error_context(status, "%s: %s", study->file, c->name);
	free(messages);
	CHECK(status);
	char threads[32];
	snprintf(threads, sizeof threads, "%d threads", study->scene.threads);
	*hash = hash_text(hash_text(*hash, scene->text), threads);
	status = hash_packings(hash, scene);
	scene_free(scene);
	return status;
}

/* The file that an option of `rve load` names, as seen from the study's; "" if it names none. */
static int option_file(char path[FILE_PATH], const struct study *study, const char *option)
{
	static const char *const files[] = {"scene=", "path=", "packing="};
	char folder[FILE_PATH];
	path[0] = '\0';
	for (size_t k = 0; k < sizeof files / sizeof *files; k++)
		if (!strncmp(option, files[k], strlen(files[k]))) {
			CHECK(file_folder(folder, study->file));
			CHECK(file_join(path, folder, option + strlen(files[k])));
		}
	return STATUS_OK;
}

static int hash_load(uint64_t *hash, const struct study *study, const struct combination *c)
{
	for (int k = 0; k < c->sets.n; k++) {
		char path[FILE_PATH], *text;
		size_t size;
		*hash = hash_text(*hash, c->sets.items[k]);
		CHECK(option_file(path, study, c->sets.items[k]));
		if (!path[0])
			continue;
		CHECK(file_read(&text, &size, path));
		*hash = hash_bytes(*hash, text, size);
		free(text);
	}
	return STATUS_OK;
}

/* Letters, digits and a few signs; the rest would trouble shells and people. */
static void folder_text(char text[80], const struct study *study, const struct combination *c)
{
	size_t n = 0;
	for (int k = 0; k < study->n_knobs; k++)
		for (const char *at = study->knobs[k].choices[c->choice[k]].name, *end = at + strlen(at) + 1;
			 at < end && n < 78; at++)
			text[n++] = !*at ? '_'
						: strchr("+-.", *at) || (*at >= '0' && *at <= '9') || ((*at | 32) >= 'a' && (*at | 32) <= 'z')
							? *at
							: '-';
	text[n ? n - 1 : 0] = '\0';
}

int job_name(const struct study *study, struct combination *c, const char *folder)
{
	uint64_t hash =
		hash_text(HASH_START, TMDEMPM_VERSION " " TMDEMPM_COMPILER " " TMDEMPM_BUILD_TYPE " " ENGINE_SOURCES_HASH);
	char text[80], name[160];
	CHECK((study->load.n ? hash_load : hash_scene)(&hash, study, c));
	snprintf(c->hash, sizeof c->hash, "%016" PRIx64, hash);
	folder_text(text, study, c);
	snprintf(name, sizeof name, "runs/%s%s-%.10s", text, c->off ? "_off" : "", c->hash);
	return file_join(c->folder, folder, name);
}

/* ---- what is kept of a run: outcome.txt, written when it has ended ---- */

static int outcome_path(const struct combination *c, char path[FILE_PATH])
{
	return file_join(path, c->folder, "outcome.txt");
}

static int outcome_write(const struct combination *c)
{
	char path[FILE_PATH];
	struct file_output out;
	const struct cost *cost = &c->result.cost;
	CHECK(outcome_path(c, path));
	CHECK(file_output_begin(&out, path));
	fprintf(out.stream,
			"combination %s\noutcome %s\nwall %.9g\ncpu %.9g\nsetup %.9g\nsteps %.17g\npoints %.17g\ndisc_steps "
			"%.17g\nreason %s\n",
			c->name, outcome_name(c->result.outcome), cost->wall, cost->cpu, cost->setup, cost->steps, cost->points,
			cost->disc_steps, c->result.reason);
	return file_output_commit(&out);
}

/* The line that begins with `name`, without it; NULL if there is none. */
static const char *outcome_line(const char *text, const char *name)
{
	size_t n = strlen(name);
	for (const char *at = text; at; at = strchr(at, '\n') ? strchr(at, '\n') + 1 : NULL)
		if (!strncmp(at, name, n) && at[n] == ' ')
			return at + n + 1;
	return NULL;
}

static double outcome_number(const char *text, const char *name)
{
	const char *at = outcome_line(text, name);
	return at ? strtod(at, NULL) : NAN;
}

bool job_recall(struct combination *c)
{
	char path[FILE_PATH], *text;
	size_t size;
	struct result *r = &c->result;
	if (outcome_path(c, path) != STATUS_OK || !file_exists(path) || file_read(&text, &size, path) != STATUS_OK)
		return false;
	const char *outcome = outcome_line(text, "outcome"), *reason = outcome_line(text, "reason");
	for (int k = OUTCOME_DONE; outcome && k <= OUTCOME_FAILED; k++)
		if (!strncmp(outcome, outcome_names[k], strlen(outcome_names[k])))
			r->outcome = (enum outcome)k;
	snprintf(r->reason, sizeof r->reason, "%.*s", reason ? (int)strcspn(reason, "\n") : 0, reason ? reason : "");
	r->cost = (struct cost){outcome_number(text, "wall"),   outcome_number(text, "cpu"),
							outcome_number(text, "setup"),  outcome_number(text, "steps"),
							outcome_number(text, "points"), outcome_number(text, "disc_steps")};
	free(text);
	return r->outcome != OUTCOME_NONE;
}

static int remove_entry(const char *path, const struct stat *stat, int type, struct FTW *walk)
{
	(void)stat, (void)type, (void)walk;
	return remove(path);
}

/* What an interrupted run has left; the folder is this study's own. */
static int folder_clear(const char *folder)
{
	if (file_exists(folder) && nftw(folder, remove_entry, 16, FTW_DEPTH | FTW_PHYS) != 0)
		return error_set(STATUS_RESOURCE, "cannot clear %s: %s", folder, strerror(errno));
	return file_make_folder(folder);
}

/* ---- the child ---- */

enum { ARGUMENTS_MAX = 1024 };

struct arguments {
	int n;
	char *items[ARGUMENTS_MAX];
};

static int argument(struct arguments *a, const char *format, const char *text)
{
	if (a->n + 1 == ARGUMENTS_MAX || asprintf(&a->items[a->n], format, text) < 0)
		return error_set(STATUS_RESOURCE, "too many settings for one run");
	a->items[++a->n] = NULL;
	return STATUS_OK;
}

static int arguments_run(struct arguments *a, const struct study *study, const struct combination *c, const char *out)
{
	char threads[16];
	snprintf(threads, sizeof threads, "%d", study->scene.threads);
	CHECK(argument(a, "%s", "run"));
	CHECK(argument(a, "%s", study->scene.file));
	CHECK(argument(a, "%s", "--quiet"));
	CHECK(argument(a, "--threads=%s", threads));
	CHECK(argument(a, "--out=%s", out));
	for (int k = 0; k < c->sets.n; k++)
		CHECK(argument(a, "--set=%s", c->sets.items[k]));
	return STATUS_OK;
}

/* An option that a knob sets replaces that of all runs; `set` may be given many times. */
static bool option_is_last(const struct combination *c, int k)
{
	if (!strncmp(c->sets.items[k], "set=", 4))
		return true;
	size_t n = strcspn(c->sets.items[k], "=");
	for (int j = k + 1; j < c->sets.n; j++)
		if (strcspn(c->sets.items[j], "=") == n && !strncmp(c->sets.items[j], c->sets.items[k], n))
			return false;
	return true;
}

static int arguments_load(struct arguments *a, const struct study *study, const struct combination *c, const char *out)
{
	char path[FILE_PATH];
	CHECK(argument(a, "%s", "rve"));
	CHECK(argument(a, "%s", "load"));
	for (int k = 0; k < c->sets.n; k++) {
		CHECK(option_file(path, study, c->sets.items[k]));
		if (!option_is_last(c, k))
			continue;
		char option[FILE_PATH + 32];
		snprintf(option, sizeof option, "--%.*s=%s", (int)strcspn(c->sets.items[k], "="), c->sets.items[k], path);
		CHECK(argument(a, path[0] ? "%s" : "--%s", path[0] ? option : c->sets.items[k]));
	}
	return argument(a, "--out=%s", out);
}

/* Runs in the child; ends it. */
static void child(char *const *arguments, const char *program, const char *log, const sigset_t *unblocked, pid_t parent)
{
	prctl(PR_SET_PDEATHSIG, SIGTERM); /* no run outlives its study */
	sigprocmask(SIG_SETMASK, unblocked, NULL);
	int in = open("/dev/null", O_RDONLY), out = open(log, O_WRONLY | O_CREAT | O_TRUNC, 0666);
	if (getppid() != parent || in < 0 || out < 0 || dup2(in, 0) < 0 || dup2(out, 1) < 0 || dup2(out, 2) < 0)
		_exit(STATUS_RESOURCE);
	execv(program, arguments);
	_exit(STATUS_RESOURCE);
}

static int spawn(const struct arguments *a, const char *program, const char *log, pid_t *pid)
{
	sigset_t unblocked;
	pid_t parent = getpid();
	sigemptyset(&unblocked);
	fflush(NULL);
	*pid = fork();
	if (*pid < 0)
		return error_set(STATUS_RESOURCE, "cannot start a run: %s", strerror(errno));
	if (*pid == 0)
		child(a->items, program, log, &unblocked, parent);
	return STATUS_OK;
}

int job_start(const struct study *study, struct combination *c, const char *program, pid_t *pid)
{
	char out[FILE_PATH], log[FILE_PATH];
	CHECK(folder_clear(c->folder));
	CHECK(file_join(out, c->folder, study->load.n ? "curve.csv" : "out"));
	CHECK(file_join(log, c->folder, "messages.txt"));
	struct arguments *a = calloc(1, sizeof *a);
	int status = a ? argument(a, "%s", program) : error_set(STATUS_RESOURCE, "out of memory");
	if (status == STATUS_OK)
		status = study->load.n ? arguments_load(a, study, c, out) : arguments_run(a, study, c, out);
	if (status == STATUS_OK)
		status = spawn(a, program, log, pid);
	for (int k = 0; a && k < a->n; k++)
		free(a->items[k]);
	free(a);
	return status;
}

/* ---- its end ---- */

/* The last line of what it said, without the program's name. */
static void reason_from_messages(struct combination *c)
{
	char path[FILE_PATH], *text;
	size_t size;
	if (file_join(path, c->folder, "messages.txt") != STATUS_OK || file_read(&text, &size, path) != STATUS_OK)
		return;
	while (size > 0 && strchr("\r\n", text[size - 1]))
		text[--size] = '\0';
	const char *line = strrchr(text, '\n');
	line = line ? line + 1 : text;
	for (const char *at = line; *at;) { /* `--help` hints are no reason */
		if (*at++ != '`' || !strstr(line, "lists the options"))
			continue;
		*strrchr(text, '\n') = '\0';
		line = strrchr(text, '\n') ? strrchr(text, '\n') + 1 : text;
		break;
	}
	if (!strncmp(line, "tmdempm", 7) && strstr(line, ": "))
		line = strstr(line, ": ") + 2;
	snprintf(c->result.reason, sizeof c->result.reason, "%s", line);
	free(text);
}

static void cost_of_run(struct combination *c)
{
	char path[FILE_PATH], *text;
	size_t size;
	struct cost *cost = &c->result.cost;
	if (file_join(path, c->folder, "out/run.json") != STATUS_OK || !file_exists(path) ||
		file_read(&text, &size, path) != STATUS_OK)
		return;
	cost->wall = json_find_number(text, 2, "total");
	cost->cpu = json_find_number(text, 2, "cpu");
	cost->setup = json_find_number(text, 2, "setup");
	cost->steps = json_find_number(text, 1, "step");
	cost->points = json_find_number(text, 1, "points");
	cost->disc_steps = json_find_number(text, 2, "disc_steps");
	free(text);
}

/* `rve load` ends by "... rows, N sub-steps in T s": its CPU time without the making of the packing. */
static void cost_of_load(struct combination *c)
{
	char path[FILE_PATH], *text;
	size_t size;
	struct cost *cost = &c->result.cost;
	if (file_join(path, c->folder, "messages.txt") != STATUS_OK || file_read(&text, &size, path) != STATUS_OK)
		return;
	const char *at = strstr(text, " rows, ");
	double steps, seconds;
	if (at && sscanf(at, " rows, %lf sub-steps in %lf s", &steps, &seconds) == 2) {
		cost->setup = fmax(cost->cpu - seconds, 0.0);
		cost->wall = fmax(cost->wall - cost->setup, seconds);
		cost->cpu = seconds;
		cost->steps = steps;
		cost->points = 1;
	}
	free(text);
}

int job_end(const struct study *study, struct combination *c, int wait_status, double wall, double cpu)
{
	struct result *r = &c->result;
	int code = WIFEXITED(wait_status) ? WEXITSTATUS(wait_status) : -1;
	r->cost = (struct cost){wall, cpu, NAN, NAN, NAN, NAN};
	r->reason[0] = '\0';
	r->outcome = code == STATUS_OK      ? OUTCOME_DONE
				 : code == STATUS_GUARD ? OUTCOME_GUARD
				 : code == STATUS_INPUT ? OUTCOME_REFUSED
										: OUTCOME_FAILED;
	if (code == STATUS_INTERRUPTED)
		return folder_clear(c->folder);
	if (study->load.n)
		cost_of_load(c);
	else
		cost_of_run(c);
	if (WIFSIGNALED(wait_status))
		snprintf(r->reason, sizeof r->reason, "ended by signal %d (%s)", WTERMSIG(wait_status),
				 strsignal(WTERMSIG(wait_status)));
	else if (code != STATUS_OK)
		reason_from_messages(c);
	return outcome_write(c);
}

int job_forget(struct combination *c)
{
	char path[FILE_PATH];
	CHECK(outcome_path(c, path));
	if (unlink(path) != 0 && errno != ENOENT && errno != ENOTDIR)
		return error_set(STATUS_RESOURCE, "cannot remove %s: %s", path, strerror(errno));
	return STATUS_OK;
}

int job_curve(const struct study *study, const struct combination *c, char path[FILE_PATH])
{
	return file_join(path, c->folder, study->load.n ? "curve.csv" : "out/history.csv");
}
