/* timeout: 240
 * The devices' kernel on this processor with a POSIX thread for every thread of a block, watched by the thread sanitizer:
 * no race, the serial kernel's bits for any number of threads; and it does report each meeting of threads that is left
 * out.  Skipped where the compiler has no thread sanitizer.
 *
 * Threads meet at two barriers in turn: at one that is used again at once, those that leave it and those that come back
 * to it are ordered by it, which may hide that a barrier is missing. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <omp.h>
#include <pthread.h>
#include <sys/wait.h>
#include <cmocka.h>

#define RVE_EMULATION
#define RVE_KERNEL_SUFFIX _emulated
#define RVE_TASK_BYTES sizeof(struct rve_task)
#define RVE_TASK_MODEL_BYTES sizeof(struct rve_task_model)
#include "entry.h"

#include "../common/rve_case.h"
#include "../common/device_case.h"

#ifdef __SANITIZE_THREAD__
enum { WATCHED = 1 };
#else
enum { WATCHED = 0 };
#endif
enum { REPORTED = 66 };

/* ---- a block ---- */

_Thread_local int emulated_thread, emulated_block;
int emulated_threads, emulated_blocks;

static pthread_barrier_t barriers[2];
static int left_out; /* the meeting of a block that does not take place, counted from 1; 0 = none */
static _Thread_local int meetings, turns;

void emulated_sync(void)
{
	if (++meetings != left_out)
		pthread_barrier_wait(&barriers[turns++ % 2]);
}

struct launch {
	struct rve_task *tasks;
	int n;
	const struct rve_device *device;
};

struct rve_device {
	struct rve_task_model model;
	real *tables;
	unsigned char *states, *scratch;
	int threads;
};

struct thread {
	pthread_t id;
	int number, block;
	const struct launch *launch;
};

static void *thread_run(void *argument)
{
	const struct thread *thread = argument;
	const struct launch *launch = thread->launch;
	emulated_thread = thread->number, emulated_block = thread->block, meetings = turns = 0;
	rve_device_advance(launch->tasks, launch->n, &launch->device->model, launch->device->tables, launch->device->states,
					   launch->device->scratch);
	return NULL;
}

/* ---- as a device ---- */

static int list(struct rve_device_info *devices, int most, char *why, size_t why_bytes)
{
	(void)why, (void)why_bytes;
	if (most > 0)
		devices[0] = (struct rve_device_info){.name = "emulated", .driver = "threads", .units = 1};
	return most > 0;
}

static void close_device(struct rve_device *d)
{
	free(d->tables), free(d->states), free(d->scratch);
	free(d);
}

static int open_device(struct rve_device **device, int number, const struct rve_device_setup *setup)
{
	(void)number;
	const size_t table = sizeof(real) * TABLE_FIELDS * (size_t)setup->layout->stride;
	struct rve_device *d = *device = calloc(1, sizeof *d);
	assert_non_null(d);
	d->model = (struct rve_task_model){*setup->layout, *setup->constants};
	d->threads = setup->threads;
	d->tables = malloc(table * (size_t)setup->n_variants);
	d->states = malloc((size_t)setup->layout->bytes * (size_t)setup->n_places);
	d->scratch = malloc((size_t)setup->layout->scratch * 2);
	assert_true(d->tables && d->states && d->scratch);
	for (int v = 0; v < setup->n_variants; v++)
		memcpy((char *)d->tables + table * (size_t)v, setup->tables[v], table);
	return STATUS_OK;
}

static int put(struct rve_device *d, int place, const void *state)
{
	memcpy(d->states + (size_t)place * (size_t)d->model.layout.bytes, state, (size_t)d->model.layout.bytes);
	return STATUS_OK;
}

static int get(struct rve_device *d, int place, void *state)
{
	memcpy(state, d->states + (size_t)place * (size_t)d->model.layout.bytes, (size_t)d->model.layout.bytes);
	return STATUS_OK;
}

/* Two blocks one after the other: so one has several tasks. */
static int submit(struct rve_device *d, int n, struct rve_task *tasks)
{
	const struct launch launch = {tasks, n, d};
	struct thread *threads = calloc((size_t)d->threads, sizeof *threads);
	assert_non_null(threads);
	emulated_threads = d->threads, emulated_blocks = 2;
	for (int block = 0; block < emulated_blocks; block++) {
		for (int k = 0; k < 2; k++)
			pthread_barrier_init(&barriers[k], NULL, (unsigned)d->threads);
		for (int t = 0; t < d->threads; t++) {
			threads[t] = (struct thread){.number = t, .block = block, .launch = &launch};
			assert_int_equal(pthread_create(&threads[t].id, NULL, thread_run, &threads[t]), 0);
		}
		for (int t = 0; t < d->threads; t++)
			pthread_join(threads[t].id, NULL);
		for (int k = 0; k < 2; k++)
			pthread_barrier_destroy(&barriers[k]);
	}
	free(threads);
	return STATUS_OK;
}

static int wait_for(struct rve_device *d, int n, struct rve_task *tasks)
{
	(void)d, (void)n, (void)tasks;
	return STATUS_OK;
}

static const struct rve_backend emulated = {.name = "emulated",
											.doc = "the devices' kernel with threads of this processor",
											.list = list,
											.open = open_device,
											.close = close_device,
											.put = put,
											.get = get,
											.submit = submit,
											.wait = wait_for};
const struct rve_backend *const rve_backends[] = {&emulated, NULL};

/* ---- tests ---- */

static void same_bits(void **unused)
{
	(void)unused;
	static const int sizes[] = {1, 7, 16, 32};
	struct rve_model *model = device_case_model(64);
	for (int s = 0; s < 4; s++)
		device_case_lives_equal(model, "emulated", sizes[s]);
	rve_model_free(model);
}

/* In a process of its own: what it ends with, and what the sanitizer says. */
static int apart(int meeting, char *said, size_t bytes)
{
	char command[256];
	snprintf(command, sizeof command, "TSAN_OPTIONS='exitcode=%d halt_on_error=1' %s/tests/test_gpu_emulation %d 2>&1",
			 REPORTED, BUILD_DIR, meeting);
	FILE *child = popen(command, "r");
	assert_non_null(child);
	said[fread(said, 1, bytes - 1, child)] = '\0';
	char rest[4096];
	while (fread(rest, 1, sizeof rest, child) > 0)
		continue;
	return WEXITSTATUS(pclose(child));
}

/* The meetings of the first RVE: one for its task, two that load it, four sub-steps of five, the sums.  What a phase writes
 * another thread reads in the next, so that each is missed; but for those before a cell moves, which touches nothing that
 * the phase before it does. */
static void planted(void **unused)
{
	(void)unused;
	enum { LOADED = 3, SUB_STEP = 5, SUB_STEPS = 4, LAST = 33 };
	static char said[65536];
	assert_int_equal(apart(0, said, sizeof said), 0);
	for (int meeting = 1; meeting <= LAST; meeting++) {
		const int moves_next = meeting >= LOADED && (meeting - LOADED) % SUB_STEP == 0 && meeting < LOADED + SUB_STEPS * SUB_STEP;
		if (!moves_next && (apart(meeting, said, sizeof said) != REPORTED || !strstr(said, "data race")))
			fail_msg("meeting %d is not missed", meeting);
	}
}

/* A life without one of the meetings. */
static int life(int meeting)
{
	struct rve_model *model = device_case_model(64);
	struct device_case c;
	struct rve_pool *pool;
	char note[1024];
	left_out = meeting;
	device_case_start(&c, model);
	if (rve_pool_create(&pool, model, c.states, DEVICE_CASE_RVES, "emulated", 7, note, sizeof note) != STATUS_OK)
		return 1;
	for (int k = 0; k < 2; k++)
		if (device_case_advance(&c, pool, 4e-2) != STATUS_OK)
			return 1;
	rve_pool_free(pool);
	device_case_end(&c);
	rve_model_free(model);
	return 0;
}

int main(int argc, char **argv)
{
	omp_set_num_threads(1); /* the sanitizer does not know how OpenMP's threads meet */
	if (argc > 1)
		return life(atoi(argv[1]));
	if (!WATCHED) {
		printf("SKIPPED: test_gpu_emulation: it is built without the thread sanitizer\n");
		return 77;
	}
	const struct CMUnitTest tests[] = {cmocka_unit_test(same_bits), cmocka_unit_test(planted)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
