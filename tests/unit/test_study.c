/* Studies without their runs: what a file expands to, norms of curves with known answers, wrong files. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#define TEMPORARY_FILE "/tmp/test_study_XXXXXX" /* for temporary_file.h */

#include "../common/near.h"
#include "../common/temporary_file.h"
#include "base/error.h"
#include "study/private.h"
#include "study/report.h"
#include "study/series.h"

static struct study *load(const char *text)
{
	struct study *study;
	write_file(text);
	if (study_load(&study, path, 0, NULL, stderr) != STATUS_OK)
		fail_msg("%s", error_message());
	return study;
}

#define NORMS "norms = ( { name = \"n\"; column = \"a\"; } );\n"
#define KNOBS                                                                                                          \
	"knobs = ( { name = \"scheme\"; choices = ( { name = \"flip\"; }, { name = \"xpic\"; set = (\"mpm.m=$(2*h)\"); } " \
	"); },\n"                                                                                                          \
	"          { name = \"h\"; path = \"grid.cell\"; values = [0.1, 0.05, 0.025]; },\n"                                \
	"          { name = \"seed\"; seed = true; values = [1, 2]; } );\n"
#define SCENE "scene = { file = \"x.cfg\"; set = (\"time.step=$(h^2/4)\", \"a.[0]=[$(h),$(scheme)]\"); };\n"

/* ---- plans ---- */

static void product(void **state)
{
	(void)state;
	struct plan plan;
	struct study *study = load(SCENE KNOBS NORMS);
	assert_int_equal(plan_create(&plan, study), STATUS_OK);
	assert_int_equal(plan.n, 12);
	assert_string_equal(plan.combinations[0].name, "scheme=flip, h=0.1, seed=1");
	assert_string_equal(plan.combinations[11].name, "scheme=xpic, h=0.025, seed=2");
	const struct study_texts *sets = &plan.combinations[11].sets; /* four that keep runs quiet come first */
	assert_int_equal(sets->n, 8);
	assert_string_equal(sets->items[0], "images=()");
	assert_string_equal(sets->items[4], "time.step=0.00015625");
	assert_string_equal(sets->items[5], "a.[0]=[0.025,xpic]");
	assert_string_equal(sets->items[6], "mpm.m=0.05");
	assert_string_equal(sets->items[7], "grid.cell=0.025");
	plan_free(&plan);
	study_free(study);
}

static void one_at_a_time(void **state)
{
	(void)state;
	struct plan plan;
	struct study *study = load(SCENE KNOBS NORMS "plan = \"one_at_a_time\"; around = \"h=5e-2\";");
	assert_int_equal(plan_create(&plan, study), STATUS_OK);
	assert_int_equal(plan.n, 2 * 4); /* base, xpic, two other cells; each with two seeds */
	for (int k = 0; k < plan.n; k++)
		assert_true(plan.combinations[k].choice[0] == 0 || plan.combinations[k].choice[1] == 1);
	plan_free(&plan);
	study_free(study);
}

static void list(void **state)
{
	(void)state;
	struct plan plan;
	struct study *study =
		load(SCENE KNOBS NORMS "plan = \"list\"; combinations = (\"scheme=xpic, seed=2\", \"h=0.1,seed=1\");");
	assert_int_equal(plan_create(&plan, study), STATUS_OK);
	assert_int_equal(plan.n, 3 + 2);
	assert_string_equal(plan.combinations[2].name, "scheme=xpic, h=0.025, seed=2");
	assert_string_equal(plan.combinations[3].name, "scheme=flip, h=0.1, seed=1");
	assert_true(plan_matches(study, plan.combinations[3].choice, "scheme = flip, h = 1e-1"));
	assert_false(plan_matches(study, plan.combinations[3].choice, "scheme=flip, h=0.05"));
	plan_free(&plan);
	study_free(study);
}

/* Runs are compared with the finest one that is like them otherwise; what is not in the plan is added to it. */
static void finest(void **state)
{
	(void)state;
	struct plan plan;
	struct study *study = load(SCENE KNOBS NORMS "plan = \"list\"; combinations = (\"scheme=flip, h=0.1\");\n"
												 "reference = { finest = \"h=0.025\"; };");
	assert_int_equal(plan_create(&plan, study), STATUS_OK);
	assert_int_equal(plan.n, 4);
	for (int k = 0; k < 4; k++) {
		const struct combination *c = &plan.combinations[k], *reference = &plan.combinations[c->reference];
		assert_int_equal(c->asked, k < 2);
		assert_int_equal(reference->choice[1], 2);
		assert_int_equal(reference->choice[2], c->choice[2]);
	}
	assert_int_equal(plan.combinations[3].reference, 3);
	plan_free(&plan);
	study_free(study);
}

static const char stability[] =
	SCENE KNOBS "kind = \"stability\"; guards_off = (\"guards.x=false\"); map = (\"h\", \"scheme\");\n"
				"norms = ( { name = \"v\"; kind = \"max\"; column = \"a\"; garbage = 10.0; } );\n";

static void pairs(void **state)
{
	(void)state;
	struct plan plan;
	struct study *study = load(stability);
	assert_int_equal(plan_create(&plan, study), STATUS_OK);
	assert_int_equal(plan.n, 24);
	for (int k = 0; k < plan.n; k++) {
		const struct combination *c = &plan.combinations[k], *other = &plan.combinations[c->partner];
		assert_int_not_equal(c->off, other->off);
		assert_memory_equal(c->choice, other->choice, 3 * sizeof(int));
		assert_int_equal(c->off, !strcmp(c->sets.items[c->sets.n - 1], "guards.x=false"));
	}
	/* outcome and value with guards, outcome and value without */
	static const struct {
		enum outcome on;
		double value_on;
		enum outcome off;
		double value_off;
		enum verdict verdict;
	} cases[] = {{OUTCOME_DONE, 1, OUTCOME_DONE, 1, VERDICT_STABLE},
				 {OUTCOME_DONE, 11, OUTCOME_DONE, 11, VERDICT_GARBAGE},
				 {OUTCOME_DONE, NAN, OUTCOME_DONE, NAN, VERDICT_GARBAGE},
				 {OUTCOME_FAILED, 1, OUTCOME_FAILED, 1, VERDICT_GARBAGE},
				 {OUTCOME_GUARD, 5, OUTCOME_DONE, 1e9, VERDICT_GUARDED},
				 {OUTCOME_GUARD, 5, OUTCOME_FAILED, NAN, VERDICT_GUARDED},
				 {OUTCOME_GUARD, 5, OUTCOME_DONE, 6, VERDICT_CONSERVATIVE},
				 {OUTCOME_GUARD, 12, OUTCOME_DONE, 1e9, VERDICT_LATE},
				 {OUTCOME_REFUSED, NAN, OUTCOME_DONE, 1e9, VERDICT_GUARDED},
				 {OUTCOME_REFUSED, NAN, OUTCOME_DONE, 1, VERDICT_CONSERVATIVE},
				 {OUTCOME_NONE, NAN, OUTCOME_DONE, 1, VERDICT_NONE}};
	struct combination *on = &plan.combinations[0], *off = &plan.combinations[on->partner];
	for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
		on->result.outcome = cases[k].on, on->result.value[0] = cases[k].value_on, on->result.cost.steps = 10;
		off->result.outcome = cases[k].off, off->result.value[0] = cases[k].value_off;
		assert_int_equal(verdict_of(&plan, on), cases[k].verdict);
		assert_int_equal(verdict_of(&plan, off), cases[k].verdict);
	}
	plan_free(&plan);
	study_free(study);
}

/* ---- norms ---- */

static struct series curve(const char *text, const char *abscissa, const char *column)
{
	struct csv_table *table;
	struct series series;
	write_file(text);
	assert_int_equal(csv_read(&table, path, NULL), STATUS_OK);
	if (series_of_table(&series, table, NULL, abscissa, column) != STATUS_OK)
		fail_msg("%s", error_message());
	csv_table_free(table);
	return series;
}

/* y = 2 x on [0, 1]: the trapezoidal mean of y is exact; so are, with steps of 1/4, the sums for y^2. */
static void norms(void **state)
{
	(void)state;
	struct series s = curve("time [s],v [m]\r\n0,0\r\n0.25,0.5\r\n0.5,1\r\n0.75,1.5\r\n1,2\r\n", "time", "v");
	assert_near(series_value(&s, NORM_MEAN, 0), 1.0, 1e-15);
	assert_near(series_value(&s, NORM_RMS, 0), sqrt((0.5 * 0.0 + 0.25 + 1.0 + 2.25 + 0.5 * 4.0) / 4.0), 1e-15);
	assert_near(series_value(&s, NORM_MAX, 0), 2.0, 0);
	assert_near(series_value(&s, NORM_END, 0), 2.0, 0);
	assert_near(series_value(&s, NORM_REACH, 1.25), 0.625, 1e-15);
	assert_true(isnan(series_value(&s, NORM_REACH, 3.0)));
	assert_near(series_at(&s, 0.1), 0.2, 1e-15);
	assert_true(isnan(series_at(&s, 1.1)));
	assert_near(series_at(&s, 1.0 + 1e-12), 2.0, 0);
	series_window(&s, 0.5, NAN);
	assert_int_equal(s.n, 3);
	assert_near(series_value(&s, NORM_MEAN, 0), 1.5, 1e-15);
	series_free(&s);
}

/* The same curve on another time grid has no error; one that is off by a constant has that. */
static void errors(void **state)
{
	(void)state;
	struct series a = curve("time [s],v [m]\n0,0\n0.5,1\n1,2\n", "time", "v");
	struct series b = curve("time [s],v [m]\n0,0\n0.1,0.2\n0.9,1.8\n1,2\n", "time", "v");
	struct series c = curve("time [s],v [m],w [m]\n0,1,2\n0.3,1,2.6\n1,1,4\n", "time", "w - v");
	struct series d = curve("time [s],v [m]\n0,0\n0.5,1\n", "time", "v");
	struct series e = curve("time [s],v [m]\n0,0\n0.5,nan\n1,2\n", "time", "v");
	for (int kind = NORM_RMS; kind <= NORM_REACH; kind++) {
		assert_near(series_error(&a, &b, kind, 1.2), 0.0, 1e-15);
		assert_near(series_error(&c, &a, kind, 1.2), kind == NORM_REACH ? 0.5 : 1.0, 1e-15);
		assert_near(series_error(&a, &c, kind, 1.2), kind == NORM_REACH ? 0.5 : 1.0, 1e-15);
	}
	assert_true(isnan(series_error(&d, &a, NORM_RMS, 0))); /* too short: not a small error */
	assert_true(isnan(series_error(&d, &a, NORM_MAX, 0)));
	assert_true(isnan(series_error(&e, &a, NORM_MAX, 0)));
	assert_true(isnan(series_error(&e, &a, NORM_RMS, 0)));
	series_free(&a), series_free(&b), series_free(&c), series_free(&d), series_free(&e);
}

static void abscissae(void **state)
{
	(void)state;
	const char *falling = "strain [-],p [Pa]\n0,1\n-0.1,2\n-0.2,3\n";
	struct series s = curve(falling, "-strain", "2*p");
	assert_near(series_at(&s, 0.15), 5.0, 1e-14);
	series_free(&s);
	struct csv_table *table;
	assert_int_equal(csv_read(&table, path, NULL), STATUS_OK);
	assert_int_equal(series_of_table(&s, table, NULL, "strain", "p"), STATUS_INPUT);
	assert_non_null(strstr(error_message(), "falls at row 2, expected one that grows"));
	assert_int_equal(series_of_table(&s, table, NULL, "-strain", "q"), STATUS_INPUT);
	assert_non_null(strstr(error_message(), "q is not known here"));
	csv_table_free(table);
}

/* ---- wrong files ---- */

static const struct {
	const char *text, *message;
} wrong[] = {
	{"", "knobs is missing, expected a list of groups"},
	{KNOBS NORMS, ":1: neither scene nor load is given, expected one of scene and load"},
	{SCENE "load = (\"rate=1\");" KNOBS NORMS, "both scene and load are given, expected one"},
	{SCENE NORMS "knob = 1;", ":3: knob is not known, expected another key (did you mean 'knobs'?)"},
	{SCENE NORMS "knobs = ( { name = \"a\"; } );",
	 ":3: knobs.[0] has nothing to turn it to, expected one of values and choices"},
	{SCENE NORMS "knobs = ( { name = \"a\"; values = [1, 1]; } );", "knobs.[0] has the value \"1\" twice"},
	{SCENE NORMS "knobs = ( { name = \"a\"; values = (\"x=1\"); } );",
	 "expected one without comma, equals sign and semicolon"},
	{SCENE NORMS "knobs = ( { name = \"a\"; values = [1]; }, { name = \"a\"; values = [2]; } );",
	 "knobs has \"a\" twice"},
	{SCENE NORMS "knobs = ( { name = \"points\"; values = [1]; } );",
	 "knobs has the name \"points\", a column of study.csv"},
	{SCENE NORMS "knobs = ( { name = \"a\"; values = 3; } );",
	 "knobs.[0].values is an integer, expected a list of numbers or strings"},
	{SCENE KNOBS "norms = ( { name = \"n\"; } );", "norms.[0] has neither column nor points"},
	{SCENE KNOBS "norms = ( { name = \"n\"; points = \"temperature\"; } );",
	 "is over points, expected an exact solution as reference"},
	{SCENE KNOBS "norms = ( { name = \"n\"; column = \"a\"; kind = \"reach\"; } );",
	 "has kind = \"reach\" without level"},
	{SCENE KNOBS "norms = ( { name = \"n\"; column = \"a\"; kind = \"l2\"; } );",
	 "norms.[0].kind is \"l2\", expected one of \"rms\""},
	{SCENE KNOBS "norms = ( { name = \"n\"; column = \"a\"; gates = ( { bound = 1.0; where = \"hh=1\"; } ); } );",
	 "norms.[0].gates.[0].where names \"hh\", expected \"knob=value, ...\""},
	{SCENE KNOBS "norms = ( { name = \"n\"; column = \"a\"; gate = -1.0; } );",
	 "norms.[0].gate is -1, expected a number >= 0"},
	{SCENE KNOBS NORMS "reference = { finest = \"h=0.3\"; };",
	 "reference.finest names h = \"0.3\", expected one of this knob's values"},
	{SCENE KNOBS NORMS "reference = { finest = \"h=0.1\"; exact = \"danilovskaya\"; };",
	 "reference has 2 of exact, finest and table"},
	{SCENE KNOBS NORMS "plan = \"list\";", "combinations are missing, expected both or none"},
	{SCENE KNOBS NORMS "around = \"h=0.1\";", "around is given, expected it with plan = \"one_at_a_time\" only"},
	{SCENE KNOBS NORMS "against = (\"hh\");", "against names \"hh\", expected the name of a knob"},
	{SCENE KNOBS NORMS "orders = ( { norm = \"m\"; knob = \"h\"; least = 1.0; } );", "orders.[0].norm names \"m\""},
	{SCENE KNOBS NORMS "kind = \"stability\";", "guards_off is missing"},
	{SCENE KNOBS NORMS "map = (\"h\");", "kind is \"error\", expected \"stability\""},
	{"load = (\"rate=1\");" KNOBS NORMS, "has no abscissa, expected a column of the curve"},
};

static void wrong_files(void **state)
{
	(void)state;
	for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) {
		struct study *study;
		char *messages;
		size_t size;
		FILE *errors = open_memstream(&messages, &size);
		write_file(wrong[k].text);
		assert_int_equal(study_load(&study, path, 0, NULL, errors), STATUS_INPUT);
		assert_null(study);
		fclose(errors);
		if (!strstr(messages, wrong[k].message) || strncmp(messages, path, strlen(path)))
			fail_msg("%s\nexpected %s, got\n%s", wrong[k].text, wrong[k].message, messages);
		free(messages);
	}
}

static void wrong_templates(void **state)
{
	(void)state;
	static const char *const cases[][2] = {{"a=$(h", "$( is never closed"},
										   {"a=$(2*scheme)", "scheme is not known here"},
										   {"a=$(h+)", "cannot be understood"}};
	for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
		char text[2048];
		struct plan plan;
		snprintf(text, sizeof text, "scene = { file = \"x.cfg\"; set = (\"%s\"); };" KNOBS NORMS, cases[k][0]);
		struct study *study = load(text);
		assert_int_equal(plan_create(&plan, study), STATUS_INPUT);
		if (!strstr(error_message(), cases[k][1]) || !strstr(error_message(), path))
			fail_msg("%s: expected %s, got %s", cases[k][0], cases[k][1], error_message());
		study_free(study);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(product),         cmocka_unit_test(one_at_a_time), cmocka_unit_test(list),
		cmocka_unit_test(finest),          cmocka_unit_test(pairs),         cmocka_unit_test(norms),
		cmocka_unit_test(errors),          cmocka_unit_test(abscissae),     cmocka_unit_test(wrong_files),
		cmocka_unit_test(wrong_templates),
	};
	return cmocka_run_group_tests(tests, make_file, remove_file);
}
