/* The RVE kernel for x86-64-v3 (compiled with -march=x86-64-v3, called only where that runs). */
#define RVE_KERNEL_SUFFIX _v3
#include "rve/kernel.h"
