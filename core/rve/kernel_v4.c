/* The RVE kernel for x86-64-v4 (compiled with -march=x86-64-v4, called only where that runs). */
#define RVE_KERNEL_SUFFIX _v4
#include "rve/kernel.h"
