#include "law/kernel.h"

#include <string.h>

#include "rve/model.h"

enum { BLOCK = 256, PARALLEL = 4096 }; /* points in one piece; in a batch that is worth to wake other threads for */

const struct law_kernel *law_kernel_here(void)
{
#ifdef LAW_KERNEL_X86
	const char *isa = rve_isa();
	if (strcmp(isa, "base") != 0)
		return strcmp(isa, "v4") == 0 ? &law_kernel_v4 : &law_kernel_v3;
#endif
	return &law_kernel_base;
}

int law_each_block(const struct law *law, struct law_batch *batch, double time, law_respond *respond)
{
	const int n = batch->n;
	int failed = n;
#pragma omp parallel for schedule(static) reduction(min : failed) if (n >= PARALLEL)
	for (int from = 0; from < n; from += BLOCK) {
		const int to = n - from < BLOCK ? n : from + BLOCK, first = respond(law, batch, time, from, to);
		failed = first < to && first < failed ? first : failed;
	}
	return failed;
}
