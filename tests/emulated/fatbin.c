/* In the place of a program's kernel for NVIDIA's GPUs, for a program that meets none: libcuda.c looks at nothing of it. */
#include "text.h"

const unsigned char gpu_kernel_fatbin[] = "emulated";
const unsigned long gpu_kernel_fatbin_bytes = sizeof gpu_kernel_fatbin;
