/* The packed RVE kernel in single precision for any processor. */
#define RVE_FLOAT
#define RVE_KERNEL_SUFFIX 32_base
#include "rve/packed.h"

int rve_packed32_scratch(const struct rve_layout *layout) { return packed_scratch(layout); }
