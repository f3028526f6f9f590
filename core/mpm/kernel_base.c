/* The passes of the MPM for any processor. */
#define MPM_KERNEL mpm_kernel_base
#include "mpm/kernel_text.h"
