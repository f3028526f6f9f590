/* The part of OpenCL 1.2 that opencl.c uses, so that no header and no library is needed to build: both are looked for at
 * run time.  Names, types and numbers are those of the Khronos specification. */
#ifndef TMDEMPM_GPU_OPENCL_API_H
#define TMDEMPM_GPU_OPENCL_API_H

#include <stddef.h>
#include <stdint.h>

typedef struct _cl_platform_id *cl_platform_id;
typedef struct _cl_device_id *cl_device_id;
typedef struct _cl_context *cl_context;
typedef struct _cl_command_queue *cl_command_queue;
typedef struct _cl_mem *cl_mem;
typedef struct _cl_program *cl_program;
typedef struct _cl_kernel *cl_kernel;
typedef struct _cl_event *cl_event;
typedef int32_t cl_int;
typedef uint32_t cl_uint;
typedef uint64_t cl_ulong, cl_bitfield;

enum {
	CL_SUCCESS = 0,
	CL_DEVICE_TYPE = 0x1000,
	CL_DEVICE_MAX_COMPUTE_UNITS = 0x1002,
	CL_DEVICE_MAX_WORK_GROUP_SIZE = 0x1004,
	CL_DEVICE_MAX_MEM_ALLOC_SIZE = 0x1010,
	CL_DEVICE_GLOBAL_MEM_SIZE = 0x101F,
	CL_DEVICE_LOCAL_MEM_SIZE = 0x1023,
	CL_DEVICE_NAME = 0x102B,
	CL_DEVICE_VERSION = 0x102F,
	CL_DEVICE_EXTENSIONS = 0x1030,
	CL_PLATFORM_VERSION = 0x0901,
	CL_PLATFORM_NAME = 0x0902,
	CL_PROGRAM_BUILD_LOG = 0x1183,
	CL_KERNEL_WORK_GROUP_SIZE = 0x11B0,
	CL_MEM_READ_WRITE = 1,
	CL_MEM_READ_ONLY = 4
};
#define CL_DEVICE_TYPE_ALL 0xFFFFFFFFu
#define CL_DEVICE_TYPE_GPU 4u

/* result, name, arguments */
#define OPENCL_FUNCTIONS(X)                                                                                            \
	X(cl_int, clGetPlatformIDs, (cl_uint, cl_platform_id *, cl_uint *))                                                \
	X(cl_int, clGetPlatformInfo, (cl_platform_id, cl_uint, size_t, void *, size_t *))                                  \
	X(cl_int, clGetDeviceIDs, (cl_platform_id, cl_bitfield, cl_uint, cl_device_id *, cl_uint *))                       \
	X(cl_int, clGetDeviceInfo, (cl_device_id, cl_uint, size_t, void *, size_t *))                                      \
	X(cl_context, clCreateContext,                                                                                     \
	  (const intptr_t *, cl_uint, const cl_device_id *, void (*)(const char *, const void *, size_t, void *), void *,  \
	   cl_int *))                                                                                                      \
	X(cl_int, clReleaseContext, (cl_context))                                                                          \
	X(cl_command_queue, clCreateCommandQueue, (cl_context, cl_device_id, cl_bitfield, cl_int *))                       \
	X(cl_int, clReleaseCommandQueue, (cl_command_queue))                                                               \
	X(cl_program, clCreateProgramWithSource, (cl_context, cl_uint, const char **, const size_t *, cl_int *))           \
	X(cl_int, clBuildProgram,                                                                                          \
	  (cl_program, cl_uint, const cl_device_id *, const char *, void (*)(cl_program, void *), void *))                 \
	X(cl_int, clGetProgramBuildInfo, (cl_program, cl_device_id, cl_uint, size_t, void *, size_t *))                    \
	X(cl_int, clReleaseProgram, (cl_program))                                                                          \
	X(cl_kernel, clCreateKernel, (cl_program, const char *, cl_int *))                                                 \
	X(cl_int, clReleaseKernel, (cl_kernel))                                                                            \
	X(cl_int, clSetKernelArg, (cl_kernel, cl_uint, size_t, const void *))                                              \
	X(cl_int, clGetKernelWorkGroupInfo, (cl_kernel, cl_device_id, cl_uint, size_t, void *, size_t *))                  \
	X(cl_mem, clCreateBuffer, (cl_context, cl_bitfield, size_t, void *, cl_int *))                                     \
	X(cl_int, clReleaseMemObject, (cl_mem))                                                                            \
	X(cl_int, clEnqueueWriteBuffer,                                                                                    \
	  (cl_command_queue, cl_mem, cl_uint, size_t, size_t, const void *, cl_uint, const cl_event *, cl_event *))        \
	X(cl_int, clEnqueueReadBuffer,                                                                                     \
	  (cl_command_queue, cl_mem, cl_uint, size_t, size_t, void *, cl_uint, const cl_event *, cl_event *))              \
	X(cl_int, clEnqueueNDRangeKernel,                                                                                  \
	  (cl_command_queue, cl_kernel, cl_uint, const size_t *, const size_t *, const size_t *, cl_uint,                  \
	   const cl_event *, cl_event *))                                                                                  \
	X(cl_int, clFlush, (cl_command_queue))                                                                             \
	X(cl_int, clFinish, (cl_command_queue))

struct opencl_api {
#define OPENCL_MEMBER(result, name, arguments) result(*name) arguments;
	OPENCL_FUNCTIONS(OPENCL_MEMBER)
#undef OPENCL_MEMBER
};

#endif
