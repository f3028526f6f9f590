/* Responses of laws for any processor. */
#define LAW_KERNEL law_kernel_base
#include "law/kernel_text.h"
