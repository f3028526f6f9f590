/* The packed RVE kernel in single precision for x86-64-v4 (compiled with -march=x86-64-v4, called only where that
 * runs). */
#define RVE_FLOAT
#define RVE_KERNEL_SUFFIX 32_v4
#include "rve/packed.h"
