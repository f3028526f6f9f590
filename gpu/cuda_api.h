/* The part of CUDA's driver interface that cuda.c uses, so that no header and no library is needed to build: the driver
 * is looked for at run time.  Names, types and numbers are those of NVIDIA's documentation. */
#ifndef TMDEMPM_GPU_CUDA_API_H
#define TMDEMPM_GPU_CUDA_API_H

#include <stddef.h>
#include <stdint.h>

typedef int CUresult, CUdevice;
typedef struct CUctx_st *CUcontext;
typedef struct CUmod_st *CUmodule;
typedef struct CUfunc_st *CUfunction;
typedef struct CUstream_st *CUstream;
typedef uintptr_t CUdeviceptr;

enum {
	CUDA_SUCCESS = 0,
	CU_STREAM_NON_BLOCKING = 1,
	CU_DEVICE_ATTRIBUTE_MULTIPROCESSOR_COUNT = 16,
	CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MAJOR = 75,
	CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MINOR = 76
};

/* name here, name in the library, arguments */
#define CUDA_FUNCTIONS(X)                                                                                              \
	X(init, cuInit, (unsigned))                                                                                        \
	X(driver_version, cuDriverGetVersion, (int *))                                                                     \
	X(error_string, cuGetErrorString, (CUresult, const char **))                                                       \
	X(device_count, cuDeviceGetCount, (int *))                                                                         \
	X(device_get, cuDeviceGet, (CUdevice *, int))                                                                      \
	X(device_name, cuDeviceGetName, (char *, int, CUdevice))                                                           \
	X(device_memory, cuDeviceTotalMem_v2, (size_t *, CUdevice))                                                        \
	X(device_attribute, cuDeviceGetAttribute, (int *, int, CUdevice))                                                  \
	X(context_retain, cuDevicePrimaryCtxRetain, (CUcontext *, CUdevice))                                               \
	X(context_release, cuDevicePrimaryCtxRelease_v2, (CUdevice))                                                       \
	X(context_use, cuCtxSetCurrent, (CUcontext))                                                                       \
	X(module_load, cuModuleLoadData, (CUmodule *, const void *))                                                       \
	X(module_unload, cuModuleUnload, (CUmodule))                                                                       \
	X(module_function, cuModuleGetFunction, (CUfunction *, CUmodule, const char *))                                    \
	X(occupancy, cuOccupancyMaxActiveBlocksPerMultiprocessor, (int *, CUfunction, int, size_t))                        \
	X(allocate, cuMemAlloc_v2, (CUdeviceptr *, size_t))                                                                \
	X(release, cuMemFree_v2, (CUdeviceptr))                                                                            \
	X(to_device, cuMemcpyHtoD_v2, (CUdeviceptr, const void *, size_t))                                                 \
	X(to_host, cuMemcpyDtoH_v2, (void *, CUdeviceptr, size_t))                                                         \
	X(to_device_async, cuMemcpyHtoDAsync_v2, (CUdeviceptr, const void *, size_t, CUstream))                            \
	X(to_host_async, cuMemcpyDtoHAsync_v2, (void *, CUdeviceptr, size_t, CUstream))                                    \
	X(stream_create, cuStreamCreate, (CUstream *, unsigned))                                                           \
	X(stream_destroy, cuStreamDestroy_v2, (CUstream))                                                                  \
	X(stream_wait, cuStreamSynchronize, (CUstream))                                                                    \
	X(launch, cuLaunchKernel,                                                                                          \
	  (CUfunction, unsigned, unsigned, unsigned, unsigned, unsigned, unsigned, unsigned, CUstream, void **, void **))

struct cuda_api {
#define CUDA_MEMBER(name, symbol, arguments) CUresult(*name) arguments;
	CUDA_FUNCTIONS(CUDA_MEMBER)
#undef CUDA_MEMBER
};

#endif
