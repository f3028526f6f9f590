/* The packed RVE kernel in double precision for x86-64-v3 (compiled with -march=x86-64-v3, called only where that
 * runs). */
#define RVE_KERNEL_SUFFIX 64_v3
#include "rve/packed.h"
#include "rve/peak.h"
