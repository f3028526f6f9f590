#include "rve/device.h"

extern const struct rve_backend gpu_cuda, gpu_opencl;

const struct rve_backend *const rve_backends[] = {&gpu_cuda, &gpu_opencl, NULL};
