/* `tmdempm exact`. */
#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "exact/exact.h"

static const char help[] =
	"usage: tmdempm exact [NAME [--set parameter=value]... --at x,y --times T]\n"
	"\n"
	"Prints an exact solution at one place of the initial body as CSV.\n"
	"  NAME          of the table; without it the table is printed, with it alone its parameters\n"
	"  --set p=v     changes a parameter; any number of times\n"
	"  --at x,y      m\n"
	"  --times T     s: a,b,c or from:to:n (n + 1 times, both ends included)\n";

struct times {
	double from, to; /* of a range */
	long intervals;
	const char *list; /* or NULL */
};

static int parse_at(double at[2], const char *text)
{
	char *end, *last;
	at[0] = strtod(text, &end);
	if (end == text || *end != ',')
		return error_set(STATUS_INPUT, "--at %s: expected x,y in metres", text);
	at[1] = strtod(end + 1, &last);
	if (last == end + 1 || *last || !isfinite(at[0]) || !isfinite(at[1]))
		return error_set(STATUS_INPUT, "--at %s: expected x,y in metres", text);
	return STATUS_OK;
}

static int parse_times(struct times *times, const char *text)
{
	*times = (struct times){.list = text};
	char *end = NULL;
	if (strchr(text, ':')) {
		times->list = NULL;
		times->from = strtod(text, &end);
		times->to = *end == ':' ? strtod(end + 1, &end) : NAN;
		times->intervals = *end == ':' ? strtol(end + 1, &end, 10) : 0;
		if (*end || !(times->to >= times->from) || times->from < 0.0 || times->intervals < 1)
			return error_set(STATUS_INPUT, "--times %s: expected from:to:n with 0 <= from <= to and n >= 1", text);
		return STATUS_OK;
	}
	for (const char *at = text;; at = end + 1) {
		double t = strtod(at, &end);
		if (end == at || !(t >= 0.0) || (*end && *end != ','))
			return error_set(STATUS_INPUT, "--times %s: expected times >= 0 (s) as a,b,c or from:to:n", text);
		if (!*end)
			return STATUS_OK;
	}
}

static void print_row(const struct exact_solution *s, const double *parameters, const double at[2], double t)
{
	printf("%.17g", t);
	for (int f = 0; f < EXACT_FIELDS; f++)
		if (exact_has(s, f))
			printf(",%.17g", exact_value(s, parameters, at, t, f));
	putchar('\n');
}

static void print_table(const struct exact_solution *s, const double *parameters, const double at[2],
						const struct times *times)
{
	printf("time [s]");
	for (int f = 0; f < EXACT_FIELDS; f++)
		if (exact_has(s, f))
			printf(",%s [%s]", exact_fields[f].name, exact_fields[f].unit);
	putchar('\n');
	for (long k = 0; !times->list && k <= times->intervals; k++)
		print_row(s, parameters, at, times->from + (times->to - times->from) * (double)k / (double)times->intervals);
	for (const char *text = times->list; text && *text;) {
		char *end;
		print_row(s, parameters, at, strtod(text, &end));
		text = *end ? end + 1 : end;
	}
}

int cli_exact(int argc, char **argv)
{
	static const struct option options[] = {{"set", required_argument, NULL, 's'},
											{"at", required_argument, NULL, 'a'},
											{"times", required_argument, NULL, 't'},
											{"help", no_argument, NULL, 'h'},
											{NULL, 0, NULL, 0}};
	const char *name = argc > 1 && argv[1][0] != '-' ? argv[1] : NULL;
	const struct exact_solution *s = name ? exact_find(name) : NULL;
	if (name && !s)
		return error_set(STATUS_INPUT, "exact: `%s` is no solution; `tmdempm exact` lists them", name);
	double parameters[EXACT_PARAMETERS_MAX], at[2] = {NAN, NAN};
	struct times times = {.intervals = -1};
	if (s)
		exact_defaults(s, parameters);
	optind = name ? 2 : 1;
	for (int c; (c = getopt_long(argc, argv, "+:", options, NULL)) != -1;) {
		if (c == 'h')
			return fputs(help, stdout), STATUS_OK;
		if (c == 's' && s)
			CHECK(exact_set(s, parameters, optarg));
		else if (c == 'a' && s)
			CHECK(parse_at(at, optarg));
		else if (c == 't' && s)
			CHECK(parse_times(&times, optarg));
		else
			return error_set(STATUS_INPUT, "exact: what is `%s`? expected NAME first, then its options (see --help)",
							 argv[optind - 1]);
	}
	if (optind < argc)
		return error_set(STATUS_INPUT, "exact: `%s` is too much", argv[optind]);
	if (isnan(at[0]) != (times.intervals < 0))
		return error_set(STATUS_INPUT, "exact: expected --at and --times together");
	if (isnan(at[0]))
		exact_print(s);
	else
		print_table(s, parameters, at, &times);
	return STATUS_OK;
}
