/* Which compilation of the kernel this processor can run. */
#include "rve/model.h"

#include <stdlib.h>
#include <string.h>

#if defined(__x86_64__) && defined(__GNUC__)
static int has_v3(void)
{
	__builtin_cpu_init();
	return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2");
}

static int has_v4(void)
{
	return has_v3() && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
		   __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
		   __builtin_cpu_supports("avx512vl");
}
#else
static int has_v3(void) { return 0; }
static int has_v4(void) { return 0; }
#endif

const char *rve_isa(void)
{
	const char *wanted = getenv("TMDEMPM_ISA");
	int limit = wanted && strcmp(wanted, "base") == 0 ? 0 : wanted && strcmp(wanted, "v3") == 0 ? 1 : 2;
	if (limit >= 2 && has_v4())
		return "v4";
	return limit >= 1 && has_v3() ? "v3" : "base";
}
