/* The packed RVE kernel in double precision for any processor. */
#define RVE_KERNEL_SUFFIX 64_base
#include "rve/packed.h"
#include "rve/peak.h"

int rve_packed64_scratch(const struct rve_layout *layout) { return packed_scratch(layout); }
