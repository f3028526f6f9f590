/* labels: slow
 * timeout: 240
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

#include <dlfcn.h>

#include "../../gpu/opencl_api.h"
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

/* `work` on oclgrind in a process of its own; what it logs. */
static void run_apart(void (*work)(void), char *log, size_t bytes)
{
	remove(log_file);
	fflush(NULL);
	pid_t child = fork();
	assert_true(child >= 0);
	if (child == 0) {
		work();
		_exit(0); /* a spoilt kernel may also end in a guard */
	}
	int status;
	assert_int_equal(waitpid(child, &status, 0), child);
	FILE *file = fopen(log_file, "r");
	assert_non_null(file);
	log[fread(log, 1, bytes - 1, file)] = '\0';
	fclose(file);
}

/* A life of RVEs life_first .. life_first + life_n - 1. */
static int life_first, life_n, life_calls;

static void live(void)
{
	struct rve_model *model = device_case_model(64);
	struct device_case c;
	struct rve_pool *pool;
	char note[1024];
	device_case_start(&c, model);
	c.first = life_first, c.n = life_n;
	int status = rve_pool_create(&pool, model, c.states + (size_t)c.first * rve_state_bytes(model), c.n, "opencl:0", 64,
								 note, sizeof note);
	for (int k = 0; k < life_calls && status == STATUS_OK; k++)
		status = device_case_advance(&c, pool, 4e-2);
	rve_pool_free(pool);
}

static void life(int first, int n, int calls, char *log, size_t bytes)
{
	life_first = first, life_n = n, life_calls = calls;
	run_apart(live, log, bytes);
}

static void clean(void **unused)
{
	(void)unused;
	static char log[4096];
	text_read();
	life(0, DEVICE_CASE_RVES, 3, log, sizeof log);
	assert_string_equal(log, "");
}

/* oclgrind's watch over uninitialised values, which knows no `freeze` of optimised code. */
static void watch_uninitialised(int on)
{
	setenv("OCLGRIND_UNINITIALIZED", on ? "1" : "0", 1);
	setenv("OCLGRIND_BUILD_OPTIONS", on ? "-cl-opt-disable" : "", 1);
}

/* The smallest program of which oclgrind says what is not true: the host writes both halves of a buffer, one after the
 * other, and a kernel copies the first.  (Its shadow of a buffer is only as long as the host's last write to it.) */
static void two_halves(void)
{
	static struct opencl_api cl;
	void *library = dlopen("libOpenCL.so.1", RTLD_NOW);
#define FIND(result, name, arguments) *(void **)&cl.name = dlsym(library, #name);
	OPENCL_FUNCTIONS(FIND)
	const char *text = "kernel void copy(global const int *from, global int *to) { to[0] = from[2]; }";
	cl_platform_id platform;
	cl_device_id device;
	cl_int code;
	const size_t one = 1;
	const int half[2] = {1, 2};
	cl.clGetPlatformIDs(1, &platform, NULL);
	cl.clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 1, &device, NULL);
	cl_context context = cl.clCreateContext(NULL, 1, &device, NULL, NULL, &code);
	cl_command_queue queue = cl.clCreateCommandQueue(context, device, 0, &code);
	cl_program program = cl.clCreateProgramWithSource(context, 1, &text, NULL, &code);
	cl.clBuildProgram(program, 1, &device, "", NULL, NULL);
	cl_kernel kernel = cl.clCreateKernel(program, "copy", &code);
	cl_mem from = cl.clCreateBuffer(context, CL_MEM_READ_WRITE, 2 * sizeof half, NULL, &code);
	cl_mem to = cl.clCreateBuffer(context, CL_MEM_READ_WRITE, sizeof half, NULL, &code);
	cl.clEnqueueWriteBuffer(queue, from, 1, 0, sizeof half, half, 0, NULL, NULL);
	cl.clEnqueueWriteBuffer(queue, from, 1, sizeof half, sizeof half, half, 0, NULL, NULL);
	cl.clSetKernelArg(kernel, 0, sizeof from, &from);
	cl.clSetKernelArg(kernel, 1, sizeof to, &to);
	cl.clEnqueueNDRangeKernel(queue, kernel, 1, NULL, &one, &one, 0, NULL, NULL);
	cl.clFinish(queue);
}

static void oclgrinds_limit(void **unused)
{
	(void)unused;
	static char log[4096];
	watch_uninitialised(1);
	run_apart(two_halves, log, sizeof log);
	watch_uninitialised(0);
	if (!strstr(log, "Uninitialized value written"))
		print_message("this oclgrind knows better: clean_of_uninitialised() may take all RVEs at once\n");
}

/* So it calls all states uninitialised but the one that was written last: one RVE at a time. */
static void clean_of_uninitialised(void **unused)
{
	(void)unused;
	static char log[4096];
	text_read();
	watch_uninitialised(1);
	for (int first = 0; first < DEVICE_CASE_RVES; first += 4) { /* the first is sheared, the last bonded, torn and heated */
		life(first, 1, 2, log, sizeof log);
		assert_string_equal(log, "");
	}
	watch_uninitialised(0);
}

static void found(const char *words)
{
	static char log[4096];
	life(0, 2, 1, log, sizeof log);
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
	text_plant("void state_load(", "WORK_ROW(WORK_ROTATION)[i] = 0.0;", ""); /* scratch memory holds what it held */
	static char log[4096];
	watch_uninitialised(1);
	life(0, 1, 1, log, sizeof log);
	watch_uninitialised(0);
	assert_non_null(strstr(log, "Uninitialized value written"));
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
	setenv("OCLGRIND_MAX_ERRORS", "5", 1);
	setenv("OCLGRIND_LOG", log_file, 1);
	const struct CMUnitTest tests[] = {cmocka_unit_test(clean), cmocka_unit_test(oclgrinds_limit), cmocka_unit_test(clean_of_uninitialised),
									   cmocka_unit_test(planted_race),
									   cmocka_unit_test(planted_bounds), cmocka_unit_test(planted_uninitialised),
									   cmocka_unit_test(planted_divergence)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
