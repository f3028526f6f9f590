#include "run/steering.h"

#include <poll.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "io/csv.h"
#include "io/file.h"
#include "run/run_private.h"

enum { QUEUE_MOST = 1000, PAUSERS_MOST = 32, SOURCE = 64, WAIT_MS = 1000 };

static const double look_every = 5e-3; /* s between looks at the transports */
static const char log_columns[] = "time,step,source,command";

struct asked {
	char source[SOURCE];
	char *text;
	steering_answer *answer; /* NULL: the log is told */
	void *asker;
};

/* Who wants the run to be paused. */
struct pauser {
	char source[SOURCE];
	void *holder; /* not NULL: as long as this asker is there */
};

struct steering {
	struct steering_host host;
	struct asked *queue;
	int n_queue;
	int n_pausers;
	struct pauser pausers[PAUSERS_MOST];
	long long until;      /* step at which a pause goes on after step=N; -1 = no steps are being done */
	struct asked stepper; /* who asked for them */
	bool stop;
	int n_transports;
	struct steering_transport transports[STEERING_TRANSPORTS];
	double next_look, pause_time; /* s */
	char log_path[FILE_PATH];
	struct csv_writer *log; /* NULL: nothing has been steered yet */
	int n_log;
	int log_status; /* of the first failure to write it */
	const struct steering_script *script;
	int next_row; /* of the script */
};

/* ---- words ---- */

static void now(const struct steering *s, long long *step, double *time) { s->host.when(s->host.data, step, time); }

__attribute__((format(printf, 2, 3))) static void say(const struct steering *s, const char *format, ...)
{
	char text[STEERING_SAID + 512];
	va_list args;
	va_start(args, format);
	vsnprintf(text, sizeof text, format, args);
	va_end(args);
	s->host.say(s->host.data, text);
}

static void where(const struct steering *s, const char *what, char said[STEERING_SAID])
{
	long long step;
	double time;
	now(s, &step, &time);
	snprintf(said, STEERING_SAID, "%s at step %lld, time %.9g s", what, step, time);
}

/* Tells whoever asked, and frees what was asked. */
static void answer(struct steering *s, struct asked *asked, int status, const char *text)
{
	if (asked->answer)
		asked->answer(asked->asker, status, text);
	if (status != STATUS_OK)
		say(s, "steering: %s: refused: %s", asked->source, text);
	free(asked->text);
	*asked = (struct asked){0};
}

/* ---- the log ---- */

static int log_row(struct steering *s, double time, long long step, const char *source, const char *command)
{
	if (!s->log) {
		bool there = file_exists(s->log_path);
		CHECK(csv_open(&s->log, s->log_path, there));
		if (!there) {
			csv_name(s->log, "time", "s");
			csv_name(s->log, "step", "-");
			csv_text(s->log, "source");
			csv_text(s->log, "command");
			CHECK(csv_end_row(s->log));
		}
	}
	csv_number(s->log, time);
	csv_integer(s->log, step);
	csv_text(s->log, source);
	csv_text(s->log, command);
	s->n_log++;
	return csv_end_row(s->log);
}

static void log_command(struct steering *s, const char *source, const struct steering_command *command)
{
	char text[STEERING_TEXT];
	long long step;
	double time;
	now(s, &step, &time);
	steering_print(command, text);
	int status = log_row(s, time, step, source, text);
	if (s->log_status == STATUS_OK)
		s->log_status = status;
}

/* ---- pausing ---- */

bool steering_paused(const struct steering *s) { return s->n_pausers > 0 && s->until < 0; }

static int pauser_add(struct steering *s, const struct asked *asked, bool hold)
{
	void *holder = hold ? asked->asker : NULL;
	int k = 0;
	while (k < s->n_pausers && (strcmp(s->pausers[k].source, asked->source) != 0 || s->pausers[k].holder != holder))
		k++;
	if (k == PAUSERS_MOST)
		return error_set(STATUS_INPUT, "%d others have paused this run", k);
	s->n_pausers += k == s->n_pausers;
	snprintf(s->pausers[k].source, SOURCE, "%s", asked->source);
	s->pausers[k].holder = holder;
	return STATUS_OK;
}

/* Whatever steps were being done are over. */
static void steps_end(struct steering *s)
{
	char said[STEERING_SAID];
	if (s->until < 0)
		return;
	s->until = -1;
	where(s, s->n_pausers ? "paused" : "goes on", said);
	answer(s, &s->stepper, STATUS_OK, said);
}

static int do_pause(struct steering *s, const struct asked *asked, enum steering_pause pause, char said[STEERING_SAID])
{
	if (pause == STEER_PAUSE_HOLD && !asked->asker)
		return error_set(STATUS_INPUT, "pause=hold needs a connection that lasts, expected pause=1");
	if (pause == STEER_GO_ON)
		s->n_pausers = 0;
	else
		CHECK(pauser_add(s, asked, pause == STEER_PAUSE_HOLD));
	steps_end(s);
	where(s, pause == STEER_GO_ON ? "goes on" : "paused", said);
	return STATUS_OK;
}

static int do_steps(struct steering *s, struct asked *asked, long long steps)
{
	long long step;
	double time;
	if (s->until >= 0)
		return error_set(STATUS_INPUT, "the steps that %s asked for are not done yet", s->stepper.source);
	CHECK(pauser_add(s, asked, false));
	now(s, &step, &time);
	s->until = step + steps;
	s->stepper = *asked; /* is answered when they are done */
	*asked = (struct asked){0};
	return STATUS_OK;
}

/* Its pauser has gone. */
static void pauser_lost(struct steering *s, int k)
{
	char source[SOURCE];
	memcpy(source, s->pausers[k].source, sizeof source);
	s->pausers[k] = s->pausers[--s->n_pausers];
	say(s, "steering: %s, which had paused the run, has gone%s", source, s->n_pausers ? "" : ": the run goes on");
	if (s->n_pausers == 0)
		steps_end(s);
}

void steering_source_lost(struct steering *s, const char *source)
{
	for (int k = s->n_pausers - 1; k >= 0; k--)
		if (!strcmp(s->pausers[k].source, source))
			pauser_lost(s, k);
}

void steering_forget(struct steering *s, void *asker)
{
	for (int k = 0; k < s->n_queue; k++)
		if (s->queue[k].asker == asker)
			s->queue[k].answer = NULL, s->queue[k].asker = NULL;
	if (s->stepper.asker == asker)
		s->stepper.answer = NULL, s->stepper.asker = NULL;
	for (int k = s->n_pausers - 1; k >= 0; k--)
		if (s->pausers[k].holder && s->pausers[k].holder == asker)
			pauser_lost(s, k);
}

/* ---- commands ---- */

static int act(struct steering *s, struct steering_command *command, long long since, char said[STEERING_SAID])
{
	said[0] = '\0';
	return s->host.act(s->host.data, command, since, said);
}

static int perform(struct steering *s, struct asked *asked, struct steering_command *command, char said[STEERING_SAID])
{
	switch (command->verb) {
	case STEER_PAUSE:
		return do_pause(s, asked, command->pause, said);
	case STEER_STEP:
		return do_steps(s, asked, command->steps);
	case STEER_STOP:
		s->stop = true;
		where(s, "stops", said);
		return STATUS_OK;
	default:
		return act(s, command, -1, said);
	}
}

static void apply(struct steering *s, struct asked *asked)
{
	struct steering_command command;
	char said[STEERING_SAID], text[STEERING_TEXT], source[SOURCE];
	snprintf(source, sizeof source, "%s", asked->source);
	int status = steering_parse(&command, asked->text);
	if (status == STATUS_OK)
		status = perform(s, asked, &command, said);
	if (status != STATUS_OK) {
		answer(s, asked, status, error_message());
		return;
	}
	steering_print(&command, text);
	log_command(s, source, &command);
	if (command.verb == STEER_STEP) {
		say(s, "steering: %s: %s", source, text);
		return;
	}
	say(s, "steering: %s: %s: %s", source, text, said);
	answer(s, asked, STATUS_OK, said);
}

static void apply_all(struct steering *s)
{
	for (int k = 0; k < s->n_queue; k++) { /* answers may queue more */
		struct asked asked = s->queue[k];
		s->queue[k] = (struct asked){0};
		apply(s, &asked);
	}
	s->n_queue = 0;
}

void steering_ask(struct steering *s, const char *source, const char *command, steering_answer *tell, void *asker)
{
	struct asked asked = {.text = strdup(command), .answer = tell, .asker = asker};
	snprintf(asked.source, sizeof asked.source, "%s", source);
	if (!s->queue || !asked.text || s->n_queue == QUEUE_MOST) {
		answer(s, &asked, STATUS_RESOURCE, "too many commands at once");
		return;
	}
	s->queue[s->n_queue++] = asked;
}

void steering_offer(struct steering *s, const char *source, const char *command)
{
	steering_ask(s, source, command, NULL, NULL);
}

void steering_describe(const struct steering *s, FILE *to)
{
	const char *state = steering_paused(s) ? "paused by" : s->n_pausers ? "does steps, then paused by" : "runs";
	fprintf(to, "state      %s", state);
	for (int k = 0; k < s->n_pausers; k++)
		fprintf(to, "%s %s", k ? "," : "", s->pausers[k].source);
	fprintf(to, "\n");
	s->host.describe(s->host.data, to);
}

/* ---- a log that is repeated ---- */

void steering_script_free(struct steering_script *script)
{
	free(script->rows);
	*script = (struct steering_script){0};
}

static int script_row(struct steering_row *row, char *const cells[4], long long before)
{
	char *ends[2];
	row->time = strtod(cells[0], &ends[0]);
	row->step = strtoll(cells[1], &ends[1], 10);
	if (!*cells[0] || *ends[0] || !*cells[1] || *ends[1] || row->step < 0)
		return error_set(STATUS_INPUT, "time and step are \"%s\" and \"%s\", expected numbers", cells[0], cells[1]);
	if (row->step < before)
		return error_set(STATUS_INPUT, "step %lld comes after step %lld", row->step, before);
	return steering_parse(&row->command, cells[3]);
}

int steering_script_read(struct steering_script *script, const char *path)
{
	struct csv_cells *table;
	*script = (struct steering_script){0};
	CHECK(csv_read_cells(&table, path, log_columns));
	script->rows = calloc((size_t)table->rows + 1, sizeof *script->rows);
	int status = script->rows ? STATUS_OK : error_set(STATUS_RESOURCE, "out of memory");
	for (int k = 0; k < table->rows && status == STATUS_OK; k++) {
		status = script_row(&script->rows[k], table->cells + 4 * (size_t)k, k ? script->rows[k - 1].step : 0);
		if (status != STATUS_OK)
			error_context(status, "%s:%d", path, table->lines[k]);
		script->n = k + 1;
	}
	csv_cells_free(table);
	if (status != STATUS_OK)
		steering_script_free(script);
	return status;
}

/* Pauses and steps are of the moment.  A stop is repeated where the log ends with it; else that run was continued. */
static bool row_is_repeated(const struct steering *s, int k)
{
	enum steering_verb verb = s->script->rows[k].command.verb;
	return steering_lasts(&s->script->rows[k].command) || verb == STEER_CHECKPOINT ||
		   (verb == STEER_STOP && k == s->script->n - 1);
}

static void repeat_due(struct steering *s)
{
	long long step;
	double time;
	char said[STEERING_SAID], text[STEERING_TEXT];
	now(s, &step, &time);
	for (; s->next_row < s->script->n && s->script->rows[s->next_row].step <= step; s->next_row++) {
		struct steering_command command = s->script->rows[s->next_row].command;
		struct asked asked = {.source = "log"};
		if (!row_is_repeated(s, s->next_row))
			continue;
		steering_print(&command, text);
		if (perform(s, &asked, &command, said) == STATUS_OK) {
			log_command(s, "log", &command);
			say(s, "steering: repeated: %s: %s", text, said);
		} else {
			say(s, "steering: cannot be repeated: %s: %s", text, error_message());
		}
	}
}

/* ---- between two steps ---- */

void steering_add_transport(struct steering *s, const struct steering_transport *transport)
{
	if (s->n_transports < STEERING_TRANSPORTS)
		s->transports[s->n_transports++] = *transport;
}

/* Serves the transports that have something, waiting up to `ms` for one; all of them if nothing comes in that time. */
static void look(struct steering *s, int ms)
{
	struct pollfd fds[STEERING_TRANSPORTS + 1];
	int n = s->n_transports;
	for (int k = 0; k < n; k++)
		fds[k] = (struct pollfd){s->transports[k].descriptor(s->transports[k].data), POLLIN, 0};
	fds[n] = (struct pollfd){signals_descriptor(), POLLIN, 0};
	int ready = poll(fds, (nfds_t)n + 1, ms);
	for (int k = 0; k < n; k++)
		if (ms > 0 ? ready == 0 || fds[k].revents : fds[k].revents)
			s->transports[k].serve(s->transports[k].data);
}

static void wait_paused(struct steering *s)
{
	double start = clock_seconds();
	char said[STEERING_SAID];
	while (steering_paused(s) && !s->stop && !signals_stop() && s->log_status == STATUS_OK) {
		struct steering_command save = {.verb = STEER_CHECKPOINT};
		if (signals_take_checkpoint())
			say(s, "%s", act(s, &save, -1, said) == STATUS_OK ? said : error_message());
		if (s->host.waits)
			s->host.waits(s->host.data);
		look(s, s->n_queue > 0 || !steering_paused(s) ? 0 : WAIT_MS); /* they may have said something */
		apply_all(s);
	}
	s->pause_time += clock_seconds() - start;
}

int steering_between(struct steering *s)
{
	long long step;
	double time;
	if (s->until >= 0) {
		now(s, &step, &time);
		if (step >= s->until)
			steps_end(s);
	}
	if (s->script && s->next_row < s->script->n)
		repeat_due(s);
	double clock = clock_seconds();
	if (clock >= s->next_look) {
		s->next_look = clock + look_every;
		look(s, 0);
	}
	apply_all(s);
	if (steering_paused(s))
		wait_paused(s);
	return s->log_status;
}

bool steering_stops(const struct steering *s) { return s->stop; }

int steering_count(const struct steering *s) { return s ? s->n_log : 0; }

double steering_pause_time(const struct steering *s) { return s ? s->pause_time : 0; }

/* ---- life ---- */

int steering_create(struct steering **steering, const struct steering_host *host, const char *log,
					const struct steering_script *script)
{
	struct steering *s = calloc(1, sizeof *s);
	*steering = s;
	if (!s || !(s->queue = calloc(QUEUE_MOST, sizeof *s->queue)))
		return error_set(STATUS_RESOURCE, "out of memory");
	s->host = *host;
	s->until = -1;
	s->script = script;
	snprintf(s->log_path, sizeof s->log_path, "%s", log);
	return STATUS_OK;
}

/* What a script has before the state that goes on, or what our own log says has been done at it, is not done again. */
static void skip_done(struct steering *s, const struct steering_script *done, long long step)
{
	int last = done->n;
	while (last > 0 && done->rows[last - 1].step == step)
		last--;
	while (s->script && s->next_row < s->script->n && s->script->rows[s->next_row].step <= step) {
		char a[STEERING_TEXT], b[STEERING_TEXT];
		bool is_done = s->script->rows[s->next_row].step < step || !row_is_repeated(s, s->next_row);
		steering_print(&s->script->rows[s->next_row].command, a);
		for (; !is_done && last < done->n; last++) {
			steering_print(&done->rows[last].command, b);
			is_done = !strcmp(a, b);
		}
		if (!is_done)
			return;
		s->next_row++;
	}
}

static void restore_row(struct steering *s, const struct steering_row *row)
{
	struct steering_command command = row->command;
	char said[STEERING_SAID], text[STEERING_TEXT];
	steering_print(&command, text);
	if (steering_lasts(&command) && act(s, &command, row->step, said) != STATUS_OK)
		say(s, "steering: %s, which was in force, cannot be taken up: %s", text, error_message());
}

int steering_restore(struct steering *s, const char *from)
{
	struct steering_script done = {0};
	long long step;
	double time;
	bool ours = !strcmp(from, s->log_path);
	now(s, &step, &time);
	if (ours)
		CHECK(csv_cut(from, time));
	if (file_exists(from))
		CHECK(steering_script_read(&done, from));
	while (done.n > 0 && !(done.rows[done.n - 1].time <= time))
		done.n--;
	int status = STATUS_OK;
	for (int k = 0; k < done.n && status == STATUS_OK; k++) {
		char text[STEERING_TEXT];
		restore_row(s, &done.rows[k]);
		steering_print(&done.rows[k].command, text);
		s->n_log += ours;
		if (!ours)
			status = log_row(s, done.rows[k].time, done.rows[k].step, "earlier", text);
	}
	skip_done(s, &done, step);
	/* a stop that the run went on after is not the end of the log */
	if (status == STATUS_OK && done.n > 0 && done.rows[done.n - 1].command.verb == STEER_STOP)
		status = log_row(s, time, step, "restart", "pause=0");
	steering_script_free(&done);
	return status;
}

int steering_sync(struct steering *s) { return s->log ? csv_sync(s->log) : STATUS_OK; }

int steering_close(struct steering *s)
{
	static const char ended[] = "the run has ended";
	if (!s)
		return STATUS_OK;
	if (s->until >= 0)
		answer(s, &s->stepper, STATUS_RESOURCE, ended);
	for (int k = 0; k < s->n_queue; k++)
		answer(s, &s->queue[k], STATUS_RESOURCE, ended);
	s->n_queue = 0;
	int status = s->log ? csv_close(s->log) : STATUS_OK;
	s->log = NULL;
	return status;
}

void steering_free(struct steering *s)
{
	if (!s)
		return;
	free(s->queue);
	free(s);
}
