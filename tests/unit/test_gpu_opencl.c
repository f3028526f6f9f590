/* labels: slow
 * timeout: 240
 * The kernel's text as OpenCL computes the bits of the serial kernel, whatever the size of a block: by oclgrind, which
 * interprets it.  Skipped without oclgrind. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <unistd.h>
#include <cmocka.h>

#include "../common/rve_case.h"
#include "../common/device_case.h"

static void lives_equal(struct rve_model *model, const char *where, int threads)
{
	struct device_case here, there;
	struct rve_pool *pool;
	char note[1024];
	device_case_start(&here, model);
	device_case_start(&there, model);
	if (rve_pool_create(&pool, model, there.states, DEVICE_CASE_RVES, where, threads, note, sizeof note) != STATUS_OK)
		fail_msg("%s", error_message());
	assert_non_null(pool);
	for (int k = 0; k < 4; k++) {
		assert_int_equal(device_case_advance(&here, NULL, 4e-2), STATUS_OK);
		if (device_case_advance(&there, pool, 4e-2) != STATUS_OK)
			fail_msg("%s", error_message());
		assert_memory_equal(here.stress, there.stress, sizeof here.stress);
	}
	assert_int_equal(rve_pool_fetch(pool, -1), STATUS_OK);
	device_case_equal(&here, &there);
	struct rve_info info;
	rve_get_info(model, here.states, &info);
	assert_true(info.rebuilds > 0);
	rve_get_info(model, here.states + 3 * rve_state_bytes(model), &info);
	assert_true(info.bonds_intact < info.bonds_installed);
	rve_pool_free(pool);
	device_case_end(&here);
	device_case_end(&there);
}

static void same_bits(void **unused)
{
	(void)unused;
	static const int sizes[] = {32, 64, 128, 256};
	struct rve_model *model = device_case_model(64);
	for (int s = 0; s < 4; s++)
		lives_equal(model, "opencl:0", sizes[s]);
	lives_equal(model, "opencl:0,cpu", 32);
	rve_model_free(model);
}

static void no_such_device(void **unused)
{
	(void)unused;
	struct rve_model *model = device_case_model(64);
	struct device_case c;
	struct rve_pool *pool;
	char note[1024];
	device_case_start(&c, model);
	assert_int_equal(rve_pool_create(&pool, model, c.states, DEVICE_CASE_RVES, "opencl:77", 0, note, sizeof note),
					 STATUS_RESOURCE);
	assert_null(pool);
	assert_non_null(strstr(error_message(), "OpenCL device 77: there"));
	assert_int_equal(rve_pool_create(&pool, model, c.states, DEVICE_CASE_RVES, "opencl:0", 100000, note, sizeof note),
					 STATUS_RESOURCE);
	assert_non_null(strstr(error_message(), "blocks of 100000 threads"));
	device_case_end(&c);
	rve_model_free(model);
}

static void words(void **unused)
{
	(void)unused;
	static const char *const good[] = {"auto", "cpu", "cuda", "opencl", "opencl:3", "cuda:0,cuda:1,cpu"};
	static const char *const bad[] = {"", "gpu", "opencl:", "opencl:x", "opencl:1:2", "cpu,", "auto,cpu", "cuda 1", "opencl:123456"};
	for (size_t k = 0; k < sizeof good / sizeof *good; k++)
		assert_int_equal(rve_devices_check(good[k]), STATUS_OK);
	for (size_t k = 0; k < sizeof bad / sizeof *bad; k++)
		assert_int_equal(rve_devices_check(bad[k]), STATUS_INPUT);
}

/* The library finds its drivers by files that name them. */
static int choose_oclgrind(void)
{
	static const char driver[] = "/usr/lib/oclgrind/liboclgrind-rt-icd.so";
	FILE *file = access(driver, R_OK) == 0 ? fopen(BUILD_DIR "/test_gpu_oclgrind.icd", "w") : NULL;
	if (!file)
		return 0;
	fprintf(file, "%s\n", driver);
	fclose(file);
	setenv("OCL_ICD_VENDORS", BUILD_DIR "/test_gpu_oclgrind.icd", 1);
	setenv("OCLGRIND_LOCAL_MEM_SIZE", "131072", 1);
	return 1;
}

int main(void)
{
	struct rve_device_info devices[RVE_DEVICES_MOST];
	char why[256] = "this build has no OpenCL";
	int n = 0;
	if (!choose_oclgrind()) {
		printf("SKIPPED: test_gpu_opencl: there is no oclgrind\n");
		return 77;
	}
	for (int b = 0; rve_backends[b]; b++)
		if (!strcmp(rve_backends[b]->name, "opencl"))
			n = rve_backends[b]->list(devices, RVE_DEVICES_MOST, why, sizeof why);
	if (n == 0 || devices[0].unfit[0] || !strstr(devices[0].name, "Oclgrind")) {
		printf("SKIPPED: test_gpu_opencl: %s\n", n ? devices[0].name : why);
		return 77;
	}
	const struct CMUnitTest tests[] = {cmocka_unit_test(words), cmocka_unit_test(same_bits),
									   cmocka_unit_test(no_such_device)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
