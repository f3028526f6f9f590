#include "rve/device.h"

extern const struct rve_backend gpu_cuda, gpu_opencl;

const struct rve_backend *const rve_backends[] = {&gpu_cuda, &gpu_opencl, NULL};

/* gpu/CMakeLists.txt tells nvcc these sizes. */
_Static_assert(sizeof(struct rve_task) == 984, "the size of a task has changed: gpu/CMakeLists.txt");
