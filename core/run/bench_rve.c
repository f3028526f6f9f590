/* Speed of RVEs: whole rve_advance() calls, list rebuilds and homogenisation included, beside what this core can do at
 * all, measured in the same run. */
#include "run/bench.h"

#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#ifdef __linux__
#include <linux/perf_event.h>
#include <sys/ioctl.h>
#include <sys/syscall.h>
#include <unistd.h>
#endif

#include "base/error.h"
#include "rve/packing.h"
#include "rve/rve.h"

enum { DISCS = 400, REPEATS = 5, SUB_STEPS_PER_CALL = 20, CELLS = 1600 };

static double thread_seconds(void)
{
	struct timespec now;
	clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
	return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Of all threads, for each of two. */
static double half_process_seconds(void)
{
	struct timespec now;
	clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
	return 0.5 * ((double)now.tv_sec + 1e-9 * (double)now.tv_nsec);
}

static double wall_seconds(void)
{
	struct timespec now;
	clock_gettime(CLOCK_MONOTONIC, &now);
	return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* ---- what the core can do ---- */

/* Multiplications and additions that do not wait for each other, apart as the kernels make them; flop/s. */
static double multiply_add(void)
{
	double sum = 0.0, start = thread_seconds(), operations = rve_peak(10000000, &sum);
	double elapsed = thread_seconds() - start;
	return sum == 0.0 ? NAN : operations / elapsed;
}

/* Reading and writing memory that no cache holds, as much of either; B/s of both. */
static double copy_bandwidth(void)
{
	const size_t bytes = (size_t)64 << 20;
	char *from = malloc(bytes), *to = malloc(bytes);
	double best = 0.0;
	for (int turn = 0; from && to && turn < 5; turn++) {
		memset(from, turn, turn < 2 ? bytes : 1);
		double start = thread_seconds();
		memcpy(to, from, bytes);
		best = fmax(best, 2.0 * (double)bytes / (thread_seconds() - start));
	}
	free(from);
	free(to);
	return best;
}

/* Instructions of this thread, if the processor's counters can be had; else -1. */
static int counter_open(void)
{
#ifdef __linux__
	struct perf_event_attr what = {.type = PERF_TYPE_HARDWARE,
								   .size = sizeof what,
								   .config = PERF_COUNT_HW_INSTRUCTIONS,
								   .exclude_kernel = 1,
								   .exclude_hv = 1};
	return (int)syscall(SYS_perf_event_open, &what, 0, -1, -1, 0);
#else
	return -1;
#endif
}

static double counter_read(int counter)
{
#ifdef __linux__
	long long count;
	if (counter >= 0 && read(counter, &count, sizeof count) == (ssize_t)sizeof count)
		return (double)count;
#endif
	(void)counter;
	return NAN;
}

/* ---- cases ---- */

struct bench_case {
	const char *name;
	double strain_per_step; /* decides how violent it is */
	double bond_strength;
	int cells, sub_steps; /* RVEs, and sub-steps in one call */
};

/* The first rebuilds its list about every 40 sub-steps, the second about every 15.  Strong bonds hold lumps together
 * for as long as is measured.  A scene: more RVEs than caches hold, each touched once in a step. */
static const struct bench_case cases[] = {
	{"", 5e-5, 0.0, 1, SUB_STEPS_PER_CALL},
	{"_violent", 2e-4, 0.0, 1, SUB_STEPS_PER_CALL},
	{"_bonded", 5e-5, 0.1, 1, SUB_STEPS_PER_CALL},
	{"_scene", 5e-5, 0.0, CELLS, 1},
};
enum { BENCH_CASES = sizeof cases / sizeof *cases };

struct bench_cells {
	struct rve_model *model;
	int n;
	unsigned char *states;
	double (*L)[4], (*stress)[4], (*conductivity)[3], *dT, *heat, *modulus;
};

static void cells_free(struct bench_cells *cells)
{
	rve_model_free(cells->model);
	free(cells->states), free(cells->L), free(cells->stress), free(cells->conductivity);
	free(cells->dT), free(cells->heat), free(cells->modulus);
}

static int cells_create(struct bench_cells *cells, const struct bench_case *c, const struct rve_packing *packing,
						int path)
{
	struct rve_params params;
	rve_params_default(&params);
	params.path = path;
	params.strain_per_step = c->strain_per_step;
	params.pressure_scaling = 0;
	params.bond_strength = c->bond_strength;
	const struct rve_packing *const packings[1] = {packing};
	*cells = (struct bench_cells){.n = c->cells};
	CHECK(rve_model_create(&cells->model, &params, 1, packings));
	const size_t n = (size_t)c->cells;
	cells->states = aligned_alloc(64, rve_state_bytes(cells->model) * n);
	cells->L = calloc(n, sizeof *cells->L), cells->stress = calloc(n, sizeof *cells->stress);
	cells->conductivity = calloc(n, sizeof *cells->conductivity), cells->dT = calloc(n, sizeof *cells->dT);
	cells->heat = calloc(n, sizeof *cells->heat), cells->modulus = calloc(n, sizeof *cells->modulus);
	if (!cells->states || !cells->L || !cells->stress || !cells->conductivity || !cells->dT || !cells->heat ||
		!cells->modulus)
		return error_set(STATUS_RESOURCE, "out of memory for %d RVEs", c->cells);
	for (int k = 0; k < c->cells; k++) {
		unsigned char *state = cells->states + (size_t)k * rve_state_bytes(cells->model);
		CHECK(rve_init(cells->model, 0, state));
		rve_install_bonds(cells->model, state);
		/* simple shear: twice its largest principal rate; never the same twice */
		cells->L[k][1] = 2.0 * c->strain_per_step * (c->sub_steps - 0.5) / 1e-3 * (1.0 + 1e-4 * k / c->cells);
	}
	return STATUS_OK;
}

static double cells_sub_steps(const struct bench_cells *cells)
{
	double sum = 0.0;
	for (int k = 0; k < cells->n; k++) {
		struct rve_info info;
		rve_get_info(cells->model, cells->states + (size_t)k * rve_state_bytes(cells->model), &info);
		sum += (double)info.total_sub_steps;
	}
	return sum;
}

/* Shears on at constant volume for `calls` calls; disc-steps per second. */
static int cells_shear(const struct bench_cells *cells, int calls, double (*clock)(void), double *rate)
{
	struct rve_batch batch = {.n = cells->n,
							  .states = cells->states,
							  .L = (const double(*)[4])cells->L,
							  .dT = cells->dT,
							  .dt = 1e-3,
							  .stress = cells->stress,
							  .heat = cells->heat,
							  .conductivity = cells->conductivity,
							  .modulus = cells->modulus};
	double before = cells_sub_steps(cells), start = clock();
	for (int k = 0; k < calls; k++)
		CHECK(rve_advance(cells->model, &batch));
	double elapsed = clock() - start;
	*rate = (cells_sub_steps(cells) - before) * rve_discs(cells->model) / elapsed;
	return STATUS_OK;
}

/* Instructions for each contact of each sub-step, of one RVE. */
static int cells_instructions(bool json, const struct bench_cells *cells, const char *name)
{
	const int counter = counter_open();
	struct rve_info info;
	double before_steps = cells_sub_steps(cells), before = counter_read(counter), rate;
	int status = cells_shear(cells, 20, thread_seconds, &rate);
	double count = counter_read(counter) - before;
	rve_get_info(cells->model, cells->states, &info);
	count /= (cells_sub_steps(cells) - before_steps) * info.n_contacts;
#ifdef __linux__
	if (counter >= 0)
		close(counter);
#endif
	if (status == STATUS_OK && isfinite(count))
		bench_report(json, name, &count, 1, "instructions/contact", 1);
	else if (status == STATUS_OK && !json)
		printf("%-24s %12s instructions/contact (this machine gives no counters)\n", name, "-");
	return status;
}

static int bench_case(bool json, const struct bench_case *c, const struct rve_packing *packing, int path, int threads,
					  double (*clock)(void), double *median_rate, double *state_bytes)
{
	struct bench_cells cells;
	char name[64];
	double rates[REPEATS], warm;
	const int calls = c->cells > 1 ? 3 : 1500;
	omp_set_num_threads(threads);
	int status = cells_create(&cells, c, packing, path);
	if (status == STATUS_OK)
		status = cells_shear(&cells, c->cells > 1 ? 1 : 200, wall_seconds, &warm); /* from the packing into flow */
	for (int k = 0; k < REPEATS && status == STATUS_OK; k++)
		status = cells_shear(&cells, calls, clock, &rates[k]);
	snprintf(name, sizeof name, "rve_%s%s%s", rve_path_name(path), c->name,
			 threads == 1            ? ""
			 : clock == wall_seconds ? "_two_threads"
									 : "_two_threads_cpu");
	if (status == STATUS_OK)
		*median_rate = bench_report(json, name, rates, REPEATS, "disc-steps/s", threads);
	snprintf(name, sizeof name, "rve_%s_instructions", rve_path_name(path));
	if (status == STATUS_OK && c == &cases[0])
		status = cells_instructions(json, &cells, name);
	if (status == STATUS_OK)
		*state_bytes = (double)rve_state_bytes(cells.model);
	cells_free(&cells);
	omp_set_num_threads(1);
	return status;
}

/* What a disc-step asks for: 2.3 pairs in reach with about 70 flops each up to their distance, 1.6 contacts with about
 * 55 more, 50 for the disc. */
static const double flops = 220.0;

static int bench_path(bool json, const struct rve_packing *packing, int path, double peak, double bandwidth)
{
	double rates[BENCH_CASES], both, bytes;
	char name[64];
	for (int c = 0; c < BENCH_CASES; c++)
		CHECK(bench_case(json, &cases[c], packing, path, 1, thread_seconds, &rates[c], &bytes));
	/* twice as many flops in a vector of singles */
	double share = rates[0] * flops / (path == RVE_SIMD_SINGLE ? 2.0 * peak : peak);
	snprintf(name, sizeof name, "rve_%s_share", rve_path_name(path));
	bench_report(json, name, &share, 1, "of multiply_add", 1);
	snprintf(name, sizeof name, "rve_%s_state", rve_path_name(path));
	bench_report(json, name, &bytes, 1, "B", 1);
	/* each state once from memory and back in each sub-step */
	share = 2.0 * bytes * rates[BENCH_CASES - 1] / DISCS / bandwidth;
	snprintf(name, sizeof name, "rve_%s_scene_share", rve_path_name(path));
	bench_report(json, name, &share, 1, "of copy", 1);
	if (omp_get_num_procs() < 2)
		return STATUS_OK;
	/* by the clock; and by CPU time, which others on the machine disturb less, but which sees no waiting */
	for (int cpu = 0; cpu < 2; cpu++) {
		CHECK(bench_case(json, &cases[BENCH_CASES - 1], packing, path, 2, cpu ? half_process_seconds : wall_seconds,
						 &both, &bytes));
		both *= 1.0 / rates[BENCH_CASES - 1];
		snprintf(name, sizeof name, "rve_%s_speedup%s", rve_path_name(path), cpu ? "_cpu" : "");
		bench_report(json, name, &both, 1, "by two threads", 2);
	}
	return STATUS_OK;
}

int bench_rve(bool json)
{
	struct rve_params params;
	rve_params_default(&params);
	const struct rve_packing_params how = {.discs = DISCS,
										   .radius_min = 0.25e-3,
										   .radius_max = 0.5e-3,
										   .pressure = 100e3,
										   .mu = 0.5,
										   .void_ratio = NAN,
										   .seed = 1};
	struct rve_packing *packing;
	double peak[REPEATS], bandwidth[REPEATS];
	CHECK(rve_packing_cached(&packing, &how, &params));
	bench_header(json, 1);
	for (int k = 0; k < REPEATS; k++)
		peak[k] = multiply_add(), bandwidth[k] = copy_bandwidth();
	double most = bench_report(json, "multiply_add", peak, REPEATS, "flop/s", 1);
	double copy = bench_report(json, "copy", bandwidth, REPEATS, "B/s", 1);
	int status = STATUS_OK;
	for (int path = RVE_SERIAL; path <= RVE_SIMD_SINGLE && status == STATUS_OK; path++)
		status = bench_path(json, packing, path, most, copy);
	rve_packing_free(packing);
	return status;
}
