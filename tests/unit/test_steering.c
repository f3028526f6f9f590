/* Steering: the language of its commands; who pauses a run and when it goes on; what is logged, repeated and taken up.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "base/error.h"
#include "run/log.h"
#include "run/steering.h"
#include "scene/scene.h"

/* ---- the language ---- */

static void commands_come_back(void **unused)
{
	(void)unused;
	static const char *const texts[][2] = {
		{"pause=1", "pause=1"},
		{" pause = 0 ", "pause=0"},
		{"pause=hold", "pause=hold"},
		{"step=12", "step=12"},
		{"checkpoint=1", "checkpoint=1"},
		{"stop=1", "stop=1"},
		{"inspect.A-1=point:0", "inspect.A-1=point:0"},
		{"inspect.x=at:0.1,-2e-3", NULL},
		{"inspect.a=most_sheared", "inspect.a=most_sheared"},
		{"inspect.a=none", "inspect.a=none"},
		{"images.warm.every=0.1", NULL},
		{"images.warm.every=0", "images.warm.every=0"},
		{"images.images.every=2", "images.images.every=2"},
	};
	for (size_t k = 0; k < sizeof texts / sizeof *texts; k++) {
		struct steering_command first, second;
		char a[STEERING_TEXT], b[STEERING_TEXT];
		assert_int_equal(steering_parse(&first, texts[k][0]), STATUS_OK);
		steering_print(&first, a);
		if (texts[k][1])
			assert_string_equal(a, texts[k][1]);
		assert_int_equal(steering_parse(&second, a), STATUS_OK);
		steering_print(&second, b);
		assert_string_equal(a, b);
		assert_memory_equal(&first.every, &second.every, sizeof first.every);
		assert_memory_equal(&first.at, &second.at, sizeof first.at);
	}
}

static void nonsense_is_refused(void **unused)
{
	(void)unused;
	char name[] = "inspect.0123456789012345678901234567890123456789012345678901234567890123=none", longer[600];
	memset(longer, 'x', sizeof longer - 1);
	longer[sizeof longer - 1] = '\0';
	const char *const texts[][2] = {
		{"", "NAME=VALUE"},
		{"pause", "NAME=VALUE"},
		{"=1", "NAME=VALUE"},
		{"pause=2", "pause=hold"},
		{"pause=", "pause=hold"},
		{"step=0", "at least 1"},
		{"step=-1", "at least 1"},
		{"step=1.5", "at least 1"},
		{"step=99999999999999999999", "at least 1"},
		{"stop=0", "stop=1"},
		{"checkpoint=yes", "checkpoint=1"},
		{"inspect.=none", "a name"},
		{"inspect.a b=none", "a name"},
		{"inspect.a/../b=none", "a name"},
		{"inspect.point:=at:1,1", "a name"},
		{name, "at most 63"},
		{"inspect.a=point:", "number of a point"},
		{"inspect.a=point:-1", "number of a point"},
		{"inspect.a=point:5x", "number of a point"},
		{"inspect.a=point:4294967296", "number of a point"},
		{"inspect.a=at:1", "a place"},
		{"inspect.a=at:1;2", "a place"},
		{"inspect.a=at:nan,0", "a place"},
		{"inspect.a=at:1,2,3", "a place"},
		{"inspect.a=coldest", "hottest, most_sheared"},
		{"images.every=1", "images.NAME.every"},
		{"images.a.size=1", "images.NAME.every"},
		{"images.a.every=-1", "interval"},
		{"images.a.every=inf", "interval"},
		{"gravity=3", "one of pause="},
		{"pause=1\nstop=1", "control characters"},
		{longer, "at most"},
	};
	for (size_t k = 0; k < sizeof texts / sizeof *texts; k++) {
		struct steering_command command;
		if (steering_parse(&command, texts[k][0]) != STATUS_INPUT || !strstr(error_message(), texts[k][1]))
			fail_msg("%s: %s", texts[k][0], error_message());
	}
}

/* ---- a run that is none ---- */

struct world {
	long long step;
	char folder[64], log[128], acts[1024], said[4096];
	struct steering *steering;
	int event; /* readable: somebody will say what `next` is when the run is paused */
	const char *next[8];
	int n_next, served, waits;
	int answers, status;
	char answer[512];
};

static void when(void *data, long long *step, double *time)
{
	const struct world *w = data;
	*step = w->step;
	*time = 0.1 * (double)w->step;
}

static int act(void *data, struct steering_command *command, long long since, char said[STEERING_SAID])
{
	struct world *w = data;
	char text[STEERING_TEXT];
	size_t used = strlen(w->acts);
	if (command->verb == STEER_INSPECT && !strcmp(command->name, "bad"))
		return error_set(STATUS_RESOURCE, "no disk");
	if (command->target == STEER_AT) {
		command->target = STEER_POINT;
		command->point = 7;
	}
	steering_print(command, text);
	snprintf(w->acts + used, sizeof w->acts - used, "%lld:%s(%lld) ", w->step, text, since);
	snprintf(said, STEERING_SAID, "done");
	return STATUS_OK;
}

static void hear(void *data, const char *text)
{
	struct world *w = data;
	size_t used = strlen(w->said);
	snprintf(w->said + used, sizeof w->said - used, "%s\n", text);
}

static void describe(void *data, FILE *to) { fprintf(to, "step %lld\n", ((struct world *)data)->step); }

static void waits(void *data) { ((struct world *)data)->waits++; }

static int event_of(void *data) { return ((struct world *)data)->event; }

static void serve(void *data)
{
	struct world *w = data;
	w->served++;
	if (w->n_next > 0 && steering_paused(w->steering)) {
		steering_offer(w->steering, "someone", w->next[0]);
		memmove(w->next, w->next + 1, sizeof w->next - sizeof *w->next);
		w->n_next--;
	}
}

static void told(void *asker, int status, const char *text)
{
	struct world *w = asker;
	w->answers++;
	w->status = status;
	snprintf(w->answer, sizeof w->answer, "%s", text);
}

static void world_steer(struct world *w, const struct steering_script *script)
{
	struct steering_host host = {w, when, act, hear, describe, waits};
	struct steering_transport transport = {event_of, serve, w};
	assert_int_equal(steering_create(&w->steering, &host, w->log, script), STATUS_OK);
	steering_add_transport(w->steering, &transport);
}

static void world_open(struct world *w)
{
	*w = (struct world){.event = eventfd(1, EFD_CLOEXEC)};
	snprintf(w->folder, sizeof w->folder, "/tmp/test_steering.XXXXXX");
	assert_non_null(mkdtemp(w->folder));
	snprintf(w->log, sizeof w->log, "%s/steering.csv", w->folder);
	world_steer(w, NULL);
}

static void world_end(struct world *w)
{
	assert_int_equal(steering_close(w->steering), STATUS_OK);
	steering_free(w->steering);
	w->steering = NULL;
}

static void world_close(struct world *w)
{
	if (w->steering)
		world_end(w);
	close(w->event);
	unlink(w->log);
	rmdir(w->folder);
}

/* Steps until the run is paused (its transport is asked to go on) or `steps` are done. */
static void world_run(struct world *w, int steps)
{
	for (int k = 0; k < steps; k++) {
		assert_int_equal(steering_between(w->steering), STATUS_OK);
		w->step++;
	}
}

static char *world_log(const struct world *w)
{
	static char text[4096];
	FILE *in = fopen(w->log, "r");
	size_t n = in ? fread(text, 1, sizeof text - 1, in) : 0;
	if (in)
		fclose(in);
	text[n] = '\0';
	return text;
}

/* ---- pausing ---- */

static void commands_are_taken_between_steps(void **unused)
{
	(void)unused;
	struct world w;
	world_open(&w);
	world_run(&w, 3);
	assert_string_equal(world_log(&w), ""); /* nobody has steered: no file */
	assert_int_equal(access(w.log, F_OK), -1);
	steering_ask(w.steering, "me", "inspect.a=at:1,2", told, &w);
	steering_ask(w.steering, "me", "inspect.b=hottest", told, &w);
	assert_int_equal(w.answers, 0);
	world_run(&w, 1);
	assert_int_equal(w.answers, 2);
	assert_string_equal(w.acts, "3:inspect.a=point:7(-1) 3:inspect.b=hottest(-1) ");
	/* what was done exactly, not what was asked for */
	assert_non_null(strstr(world_log(&w), "time [s],step [-],source,command\r\n"
										  "0.30000000000000004,3,me,inspect.a=point:7\r\n"
										  "0.30000000000000004,3,me,inspect.b=hottest\r\n"));
	world_close(&w);
}

static void what_fails_is_answered_and_forgotten(void **unused)
{
	(void)unused;
	struct world w;
	world_open(&w);
	steering_ask(w.steering, "me", "inspect.bad=hottest", told, &w);
	world_run(&w, 1);
	assert_int_equal(w.status, STATUS_RESOURCE);
	assert_string_equal(w.answer, "no disk");
	steering_ask(w.steering, "me", "nonsense", told, &w);
	steering_offer(w.steering, "paraview", "more nonsense");
	world_run(&w, 1);
	assert_int_equal(w.status, STATUS_INPUT);
	assert_non_null(strstr(w.said, "paraview: refused: `more nonsense`"));
	assert_string_equal(world_log(&w), "");
	/* more than a queue holds is refused, not stored without end */
	w.answers = 0;
	for (int k = 0; k < 2000; k++)
		steering_ask(w.steering, "me", "inspect.c=hottest", told, &w);
	assert_int_equal(w.answers, 1000);
	assert_int_equal(w.status, STATUS_RESOURCE);
	world_close(&w);
}

static void steps_are_counted(void **unused)
{
	(void)unused;
	struct world w;
	world_open(&w);
	steering_ask(w.steering, "me", "step=3", told, &w);
	world_run(&w, 3);
	assert_int_equal(w.answers, 0); /* the third step is done, the run has not come back yet */
	steering_ask(w.steering, "me", "step=1", told, &w);
	w.next[w.n_next++] = "step=2";
	w.next[w.n_next++] = "pause=0";
	assert_false(steering_paused(w.steering));
	world_run(&w, 1); /* the three are answered: paused; then step=1 is taken */
	assert_int_equal(w.answers, 1);
	assert_string_equal(w.answer, "paused at step 3, time 0.3 s");
	world_run(&w, 1); /* paused at 4: step=2 comes */
	assert_int_equal(w.answers, 2);
	assert_string_equal(w.answer, "paused at step 4, time 0.4 s");
	assert_int_equal(w.n_next, 1);
	world_run(&w, 2); /* at 6 pause=0 comes */
	assert_int_equal(w.n_next, 0);
	assert_int_equal(w.step, 7);
	assert_false(steering_paused(w.steering));
	/* two sets of steps at once make no sense */
	steering_ask(w.steering, "me", "step=5", told, &w);
	steering_ask(w.steering, "you", "step=5", told, &w);
	world_run(&w, 1);
	assert_int_equal(w.status, STATUS_INPUT);
	/* the end of the run is an answer too */
	world_end(&w);
	assert_int_equal(w.status, STATUS_RESOURCE);
	assert_string_equal(w.answer, "the run has ended");
	world_close(&w);
}

static void a_pause_ends_with_its_source(void **unused)
{
	(void)unused;
	struct world w;
	world_open(&w);
	steering_offer(w.steering, "paraview", "pause=1");
	steering_offer(w.steering, "other", "pause=1");
	steering_ask(w.steering, "me", "pause=hold", told, &w);
	w.next[w.n_next++] = "step=1";
	world_run(&w, 1);
	assert_int_equal(w.answers, 1);
	steering_source_lost(w.steering, "paraview");
	steering_source_lost(w.steering, "other");
	steering_source_lost(w.steering, "someone"); /* who asked for a step */
	steering_source_lost(w.steering, "stranger");
	w.next[w.n_next++] = "inspect.a=hottest"; /* still held by me */
	w.next[w.n_next++] = "pause=0";
	world_run(&w, 1);
	assert_int_equal(w.n_next, 0);
	assert_non_null(strstr(w.acts, "1:inspect.a=hottest"));
	steering_ask(w.steering, "me", "pause=hold", told, &w);
	w.next[w.n_next++] = "step=1";
	world_run(&w, 1);
	steering_source_lost(w.steering, "someone");
	steering_forget(w.steering, &w);
	assert_false(steering_paused(w.steering));
	world_run(&w, 1);
	assert_non_null(strstr(w.said, "me, which had paused the run, has gone: the run goes on"));
	/* a pause that nobody holds stays */
	steering_ask(w.steering, "me", "pause=1", told, &w);
	w.next[w.n_next++] = "inspect.b=hottest";
	w.next[w.n_next++] = "pause=0";
	world_run(&w, 1);
	assert_int_equal(w.n_next, 0);
	/* nobody can hold a pause without being there */
	steering_offer(w.steering, "paraview", "pause=hold");
	world_run(&w, 1);
	assert_non_null(strstr(w.said, "pause=hold needs a connection"));
	world_close(&w);
}

static void a_stop_stops_also_a_pause(void **unused)
{
	(void)unused;
	struct world w;
	world_open(&w);
	steering_offer(w.steering, "me", "pause=1");
	w.next[w.n_next++] = "checkpoint=1";
	w.next[w.n_next++] = "stop=1";
	world_run(&w, 1);
	assert_true(steering_stops(w.steering));
	assert_string_equal(w.acts, "0:checkpoint=1(-1) ");
	assert_int_equal(w.waits, 2); /* those who watch saw the pause, and what came of the first command */
	world_close(&w);
}

static void idle_runs_look_rarely(void **unused)
{
	(void)unused;
	struct world w;
	world_open(&w);
	double start = clock_seconds();
	world_run(&w, 100000);
	assert_true(w.served >= 1 && w.served <= 2 + (int)((clock_seconds() - start) / 5e-3)); /* one look each 5 ms */
	world_close(&w);
}

/* ---- the log ---- */

static void write_text(const char *path, const char *text)
{
	FILE *out = fopen(path, "w");
	fputs(text, out);
	fclose(out);
}

static const char log_text[] = "time [s],step [-],source,command\r\n"
							   "0.10000000000000001,1,me,pause=1\r\n"
							   "0.10000000000000001,1,me,inspect.a=point:3\r\n"
							   "0.20000000000000001,2,me,step=1\r\n"
							   "0.20000000000000001,2,me,stop=1\r\n"
							   "0.20000000000000001,2,me,images.w.every=0.5\r\n"
							   "0.40000000000000002,4,\"a, \"\"b\"\"\",checkpoint=1\r\n"
							   "0.5,5,me,inspect.a=none\r\n"
							   "0.59999999999999998,6,me,stop=1\r\n";

static void a_log_is_repeated(void **unused)
{
	(void)unused;
	struct world w;
	struct steering_script script;
	char path[128];
	world_open(&w);
	snprintf(path, sizeof path, "%s/other.csv", w.folder);
	write_text(path, log_text);
	assert_int_equal(steering_script_read(&script, path), STATUS_OK);
	assert_int_equal(script.n, 8);
	world_end(&w);
	world_steer(&w, &script);
	world_run(&w, 6);
	assert_false(steering_stops(w.steering)); /* the first stop was not the end */
	world_run(&w, 1);
	assert_true(steering_stops(w.steering));
	assert_string_equal(w.acts,
						"1:inspect.a=point:3(-1) 2:images.w.every=0.5(-1) 4:checkpoint=1(-1) 5:inspect.a=none(-1) ");
	assert_int_equal(steering_count(w.steering), 5);
	world_end(&w);
	/* and the log of the repetition can be repeated */
	struct steering_script again;
	assert_int_equal(steering_script_read(&again, w.log), STATUS_OK);
	assert_int_equal(again.n, 5);
	steering_script_free(&again);
	steering_script_free(&script);
	unlink(path);
	world_close(&w);
}

static void what_is_no_log_is_refused(void **unused)
{
	(void)unused;
	static const char *const texts[][2] = {
		{"", ":1: is empty"},
		{"time,step,command\n", ":1: expected the columns time,step,source,command"},
		{"time,step,source,command,more\n", ":1: expected the columns"},
		{"time,step,source,command\n0,1,me\n", ":2: 3 cells, expected 4"},
		{"time,step,source,command\n0,x,me,pause=1\n", ":2: time and step"},
		{"time,step,source,command\n0,3,me,stop=1\n0,2,me,stop=1\n", ":3: step 2 comes after step 3"},
		{"time,step,source,command\n# a comment\n\n0,1,me,stop=2\n", ":4: `stop=2`: expected stop=1"},
	};
	struct world w;
	char path[128];
	world_open(&w);
	snprintf(path, sizeof path, "%s/other.csv", w.folder);
	for (size_t k = 0; k < sizeof texts / sizeof *texts; k++) {
		struct steering_script script;
		write_text(path, texts[k][0]);
		if (steering_script_read(&script, path) != STATUS_INPUT || !strstr(error_message(), texts[k][1]))
			fail_msg("%s", error_message());
		assert_null(script.rows);
	}
	unlink(path);
	world_close(&w);
}

/* At step 4 what began before holds on, and what came later is forgotten. */
static void a_restart_takes_up_what_was_in_force(void **unused)
{
	(void)unused;
	struct world w;
	world_open(&w);
	write_text(w.log, log_text);
	w.step = 4;
	assert_int_equal(steering_restore(w.steering, w.log), STATUS_OK);
	assert_string_equal(w.acts, "4:inspect.a=point:3(1) 4:images.w.every=0.5(2) ");
	assert_null(strstr(world_log(&w), "inspect.a=none"));
	assert_non_null(strstr(world_log(&w), "checkpoint=1"));
	assert_int_equal(steering_count(w.steering), 6);
	assert_false(steering_stops(w.steering));
	world_close(&w);
}

/* A run that was stopped and goes on: its log does not end with the stop, so that a repetition goes on as well. */
static void a_stop_that_was_survived_is_not_repeated(void **unused)
{
	(void)unused;
	struct world w;
	world_open(&w);
	write_text(w.log, log_text);
	w.step = 6;
	assert_int_equal(steering_restore(w.steering, w.log), STATUS_OK);
	world_end(&w);
	assert_non_null(strstr(world_log(&w), "6,me,stop=1\r\n0.60000000000000009,6,restart,pause=0\r\n"));
	world_close(&w);
}

static void another_folders_log_is_copied(void **unused)
{
	(void)unused;
	struct world w;
	char path[128];
	world_open(&w);
	snprintf(path, sizeof path, "%s/other.csv", w.folder);
	write_text(path, log_text);
	w.step = 4;
	assert_int_equal(steering_restore(w.steering, path), STATUS_OK);
	assert_string_equal(w.acts, "4:inspect.a=point:3(1) 4:images.w.every=0.5(2) ");
	assert_int_equal(steering_count(w.steering), 6);
	world_end(&w);
	assert_non_null(strstr(world_log(&w), "0.20000000000000001,2,earlier,images.w.every=0.5\r\n"));
	unlink(path);
	world_close(&w);
}

/* A repetition that is itself interrupted and goes on at step 2, before or after the rows of that step were done. */
static void a_repetition_goes_on_where_it_was(void **unused)
{
	(void)unused;
	static const char done[] = "time [s],step [-],source,command\r\n"
							   "0.10000000000000001,1,log,inspect.a=point:3\r\n%s";
	static const char image[] = "0.20000000000000001,2,log,images.w.every=0.5\r\n";
	for (int k = 0; k < 2; k++) {
		struct world w;
		struct steering_script script;
		char path[128], text[512];
		world_open(&w);
		snprintf(path, sizeof path, "%s/other.csv", w.folder);
		write_text(path, log_text);
		snprintf(text, sizeof text, done, k ? image : "");
		write_text(w.log, text);
		assert_int_equal(steering_script_read(&script, path), STATUS_OK);
		world_end(&w);
		world_steer(&w, &script);
		w.step = 2;
		assert_int_equal(steering_restore(w.steering, w.log), STATUS_OK);
		world_run(&w, 2);
		assert_string_equal(w.acts, k ? "2:inspect.a=point:3(1) 2:images.w.every=0.5(2) "
									  : "2:inspect.a=point:3(1) 2:images.w.every=0.5(-1) ");
		world_end(&w);
		steering_script_free(&script);
		unlink(path);
		world_close(&w);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(commands_come_back),
		cmocka_unit_test(nonsense_is_refused),
		cmocka_unit_test(commands_are_taken_between_steps),
		cmocka_unit_test(what_fails_is_answered_and_forgotten),
		cmocka_unit_test(steps_are_counted),
		cmocka_unit_test(a_pause_ends_with_its_source),
		cmocka_unit_test(a_stop_stops_also_a_pause),
		cmocka_unit_test(idle_runs_look_rarely),
		cmocka_unit_test(a_log_is_repeated),
		cmocka_unit_test(what_is_no_log_is_refused),
		cmocka_unit_test(a_restart_takes_up_what_was_in_force),
		cmocka_unit_test(a_stop_that_was_survived_is_not_repeated),
		cmocka_unit_test(another_folders_log_is_copied),
		cmocka_unit_test(a_repetition_goes_on_where_it_was),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
