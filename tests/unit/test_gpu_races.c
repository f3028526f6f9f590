/* timeout: 240
 * oclgrind finds nothing to blame in the kernel's text as OpenCL: no race, no access out of bounds, no call that OpenCL
 * forbids, no barrier that only some threads reach; and it does find one of each that is planted.  Skipped without
 * oclgrind. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <sys/wait.h>
#include <unistd.h>
#include <cmocka.h>

#include "../common/rve_case.h"
#include "../common/device_case.h"

/* The text that the backend compiles: here instead of the program's own, so that it can be spoilt. */
enum { TEXT_MOST = 1 << 18 };
unsigned char gpu_kernel_text[TEXT_MOST];
unsigned long gpu_kernel_text_bytes;

static const char log_file[] = BUILD_DIR "/test_gpu_races.log";

static void text_read(void)
{
	FILE *file = fopen(BUILD_DIR "/generated/rve_kernel.txt", "r");
	assert_non_null(file);
	gpu_kernel_text_bytes = fread(gpu_kernel_text, 1, TEXT_MOST - 1, file);
	assert_true(gpu_kernel_text_bytes > 10000 && gpu_kernel_text_bytes < TEXT_MOST - 1000);
	gpu_kernel_text[gpu_kernel_text_bytes] = '\0';
	fclose(file);
}

/* Behind the first `behind`, replaces the next `what` by `by`. */
static void text_plant(const char *behind, const char *what, const char *by)
{
	char *text = (char *)gpu_kernel_text, *at = strstr(text, behind);
	assert_non_null(at);
	at = strstr(at, what);
	assert_non_null(at);
	memmove(at + strlen(by), at + strlen(what), strlen(at + strlen(what)) + 1);
	memcpy(at, by, strlen(by));
	gpu_kernel_text_bytes = strlen(text);
}

/* A life on oclgrind in a process of its own; what it logs. */
static void life(int calls, char *log, size_t bytes)
{
	remove(log_file);
	fflush(NULL);
	pid_t child = fork();
	assert_true(child >= 0);
	if (child == 0) {
		struct rve_model *model = device_case_model(64);
		struct device_case c;
		struct rve_pool *pool;
		char note[1024];
		device_case_start(&c, model);
		int status = rve_pool_create(&pool, model, c.states, DEVICE_CASE_RVES, "opencl:0", 64, note, sizeof note);
		for (int k = 0; k < calls && status == STATUS_OK; k++)
			status = device_case_advance(&c, pool, 4e-2);
		rve_pool_free(pool);
		_exit(status); /* a spoilt kernel may also end in a guard */
	}
	int status;
	assert_int_equal(waitpid(child, &status, 0), child);
	FILE *file = fopen(log_file, "r");
	assert_non_null(file);
	log[fread(log, 1, bytes - 1, file)] = '\0';
	fclose(file);
}

static void clean(void **unused)
{
	(void)unused;
	static char log[4096];
	text_read();
	life(3, log, sizeof log);
	assert_string_equal(log, "");
}

static void found(const char *words)
{
	static char log[4096];
	life(1, log, sizeof log);
	if (!strstr(log, words))
		fail_msg("expected `%s` in the log:\n%s", words, log);
}

static void planted_race(void **unused)
{
	(void)unused;
	text_read();
	text_plant("", "PHASE(if (forces && FINE) contacts(at, k + 1 == call->sub_steps, bonded));",
			   "contacts(at, k + 1 == call->sub_steps, bonded);"); /* forces are gathered before all are there */
	found("data race");
}

static void planted_uninitialised(void **unused)
{
	(void)unused;
	text_read();
	text_plant("void cell_move(", "= 0.0, block->lanes[LANE_SECOND][lane] = 0.0;", "= 0.0;");
	found("Uninitialized");
}

static void planted_bounds(void **unused)
{
	(void)unused;
	text_read();
	text_plant("void rows_load(", "TABLE(TABLE_R)[id[i]]", "TABLE(TABLE_R)[id[i] + 100000]");
	found("Invalid read");
}

static void planted_divergence(void **unused)
{
	(void)unused;
	text_read();
	text_plant("void kick(", "const real dt", "if (get_local_id(0) < 16) SYNC(); const real dt");
	found("divergence");
}

int main(void)
{
	static const char driver[] = "/usr/lib/oclgrind/liboclgrind-rt-icd.so";
	FILE *file = access(driver, R_OK) == 0 && rve_backends[0] ? fopen(BUILD_DIR "/test_gpu_races.icd", "w") : NULL;
	if (!file) {
		printf("SKIPPED: test_gpu_races: there is no oclgrind\n");
		return 77;
	}
	fprintf(file, "%s\n", driver);
	fclose(file);
	setenv("OCL_ICD_VENDORS", BUILD_DIR "/test_gpu_races.icd", 1);
	setenv("OCLGRIND_LOCAL_MEM_SIZE", "131072", 1);
	setenv("OCLGRIND_CHECK_API", "1", 1);
	setenv("OCLGRIND_DATA_RACES", "1", 1);
	setenv("OCLGRIND_UNINITIALIZED", "1", 1);
	setenv("OCLGRIND_MAX_ERRORS", "5", 1);
	setenv("OCLGRIND_LOG", log_file, 1);
	const struct CMUnitTest tests[] = {cmocka_unit_test(clean), cmocka_unit_test(planted_race),
									   cmocka_unit_test(planted_bounds), cmocka_unit_test(planted_uninitialised),
									   cmocka_unit_test(planted_divergence)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
