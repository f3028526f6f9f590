/* The passes of the MPM for x86-64-v4 (called only where that runs). */
#include "mpm/kernel.h"
#ifdef MPM_KERNEL_X86
#define MPM_KERNEL mpm_kernel_v4
#include "mpm/kernel_text.h"
#endif
