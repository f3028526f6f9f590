/* labels: slow
 * timeout: 240
 * The kernel's text as OpenCL computes the bits of the serial kernel, whatever the size of a block: by oclgrind, which
 * interprets it.  Skipped without oclgrind. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <cmocka.h>

#include "../common/rve_case.h"
#include "../common/device_case.h"

static void same_bits(void **unused)
{
	(void)unused;
	static const int sizes[] = {32, 64, 128, 256};
	struct rve_model *model = device_case_model(64);
	for (int s = 0; s < 4; s++)
		device_case_lives_equal(model, "opencl:0", sizes[s]);
	device_case_lives_equal(model, "opencl:0,cpu", 32);
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

int main(void)
{
	if (!device_case_driver("/usr/lib/oclgrind/liboclgrind-rt-icd.so", "Oclgrind", BUILD_DIR "/test_gpu_oclgrind.icd")) {
		printf("SKIPPED: test_gpu_opencl: there is no oclgrind\n");
		return 77;
	}
	const struct CMUnitTest tests[] = {cmocka_unit_test(words), cmocka_unit_test(same_bits),
									   cmocka_unit_test(no_such_device)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
