/* Which compilation of the passes runs here. */
#include "mpm/kernel.h"

#include <string.h>

#include "rve/model.h"

const struct mpm_kernel *mpm_kernel_here(void)
{
#ifdef MPM_KERNEL_X86
	const char *isa = rve_isa();
	if (strcmp(isa, "base") != 0)
		return strcmp(isa, "v4") == 0 ? &mpm_kernel_v4 : &mpm_kernel_v3;
#endif
	return &mpm_kernel_base;
}
