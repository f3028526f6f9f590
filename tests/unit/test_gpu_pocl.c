/* labels: slow
 * timeout: 240
 * The kernel's text as OpenCL computes the bits of the serial kernel, whatever the size of a block: by PoCL, which
 * compiles it for this processor with a compiler of its own.  Skipped without PoCL. */
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
	struct rve_model *small = device_case_model(64), *usual = device_case_model(400);
	for (int s = 0; s < 4; s++) {
		device_case_lives_equal(small, "opencl:0", sizes[s]);
		device_case_lives_equal(usual, "opencl:0", sizes[s]);
		device_case_lives_equal(usual, "opencl:0,cpu", sizes[s]);
	}
	rve_model_free(small);
	rve_model_free(usual);
}

int main(void)
{
	setenv("POCL_CACHE_DIR", BUILD_DIR "/test-pocl", 1);
	if (!device_case_driver("/usr/lib/x86_64-linux-gnu/libpocl.so.2", "pthread", BUILD_DIR "/test_gpu_pocl.icd")) {
		printf("SKIPPED: test_gpu_pocl: there is no PoCL\n");
		return 77;
	}
	const struct CMUnitTest tests[] = {cmocka_unit_test(same_bits)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
