/* The RVE kernel for any processor. */
#define RVE_KERNEL_SUFFIX _base
#include "rve/kernel.h"

int rve_kernel_scratch_bytes(const struct rve_layout *layout) { return kernel_scratch_bytes(layout); }
