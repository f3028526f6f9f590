#include "run/bench.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "run/json.h"
#include "run/machine.h"
#include "version.h"

static int bench_compare(const void *a, const void *b)
{
	double x = *(const double *)a, y = *(const double *)b;
	return (x > y) - (x < y);
}

double bench_report(bool json, const char *name, const double *values, int repeats, const char *unit, int threads)
{
	double sorted[64];
	int n = repeats < 64 ? repeats : 64;
	memcpy(sorted, values, (size_t)n * sizeof *sorted);
	qsort(sorted, (size_t)n, sizeof *sorted, bench_compare);
	double median = n % 2 ? sorted[n / 2] : 0.5 * (sorted[n / 2 - 1] + sorted[n / 2]);
	if (!json) {
		printf("%-24s %12.5g %-18s (%.5g .. %.5g, %d repeats, %d %s)\n", name, median, unit, sorted[0], sorted[n - 1],
			   n, threads, threads == 1 ? "thread" : "threads");
		fflush(stdout);
		return median;
	}
	struct json line = {.stream = stdout};
	json_open(&line, NULL, '{');
	json_text(&line, "name", name);
	json_number(&line, "value", median);
	json_text(&line, "unit", unit);
	json_number(&line, "min", sorted[0]);
	json_number(&line, "max", sorted[n - 1]);
	json_integer(&line, "repeats", n);
	json_integer(&line, "threads", threads);
	json_close(&line, '}');
	putchar('\n');
	fflush(stdout);
	return median;
}

void bench_header(bool json, int threads)
{
	if (json)
		return;
	struct machine machine;
	machine_look(&machine);
	printf("tmdempm %s, %s, %s; %s (%s), %d %s\n", TMDEMPM_VERSION, TMDEMPM_COMPILER, TMDEMPM_BUILD_TYPE,
		   machine.processor, machine.isa, threads, threads == 1 ? "thread" : "threads");
}
