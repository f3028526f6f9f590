/* Responses of laws for x86-64-v3 (called only where that runs). */
#include "law/kernel.h"
#ifdef LAW_KERNEL_X86
#define LAW_KERNEL law_kernel_v3
#include "law/kernel_text.h"
#endif
