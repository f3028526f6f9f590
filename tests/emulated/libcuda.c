/* A libcuda.so.1 for tests of gpu/cuda.c on machines without a GPU: the driver's interface, behind it the kernel's text on
 * this processor.  Its devices are called `emulated`.  FAKE_CUDA in the environment, NAME=NUMBER separated by commas, says
 * what goes wrong:
 *
 *   devices=2      how many there are (1)
 *   capability=70  compute capability (80)
 *   init=803       what cuInit answers (0)
 *   module=209     what loading a kernel answers (0)
 *   memory=100000  bytes of a device (1e9)
 *   launch=7       launch number 7, counted from 1 over all devices, and those after it are refused
 *   lost=7         launch number 7 begins, and the device that it was on never answers again
 *   slow=20        a launch takes at least so many milliseconds
 */
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define RVE_EMULATION
#define RVE_KERNEL_SUFFIX _emulated
#define RVE_TASK_BYTES sizeof(struct rve_task)
#define RVE_TASK_MODEL_BYTES sizeof(struct rve_task_model)
#include "entry.h"

#include "cuda_api.h"

enum { DEVICES_MOST = 8, LAUNCH_REFUSED = 701, NOT_THERE = 46, OUT_OF_MEMORY = 2, INVALID = 1 };

_Thread_local int emulated_thread, emulated_block; /* one thread for all: a block is a loop */
int emulated_threads = 1, emulated_blocks = 1;

void emulated_sync(void) {}

struct CUctx_st {
	int device;
};

struct block {
	size_t bytes;
	int device;
	max_align_t memory[];
};

static struct CUctx_st contexts[DEVICES_MOST];
static size_t used[DEVICES_MOST];
static int is_lost[DEVICES_MOST], launches;
static _Thread_local CUcontext current;

static double setting(const char *name, double usual)
{
	const char *all = getenv("FAKE_CUDA");
	size_t length = strlen(name);
	for (const char *at = all; at && *at; at += strcspn(at, ","), at += *at == ',')
		if (!strncmp(at, name, length) && at[length] == '=')
			return atof(at + length + 1);
	return usual;
}

static CUresult here(void) { return !current ? INVALID : is_lost[current->device] ? NOT_THERE : CUDA_SUCCESS; }

CUresult cuInit(unsigned flags) { return flags ? INVALID : (CUresult)setting("init", CUDA_SUCCESS); }

CUresult cuDriverGetVersion(int *version) { return *version = 13000, CUDA_SUCCESS; }

CUresult cuGetErrorString(CUresult code, const char **words)
{
	static const struct {
		CUresult code;
		const char *words;
	} known[] = {{INVALID, "invalid argument"},
				 {OUT_OF_MEMORY, "out of memory"},
				 {NOT_THERE, "CUDA-capable device(s) is/are busy or unavailable"},
				 {100, "no CUDA-capable device is detected"},
				 {209, "no kernel image is available for execution on the device"},
				 {LAUNCH_REFUSED, "too many resources requested for launch"},
				 {803, "system has unsupported display driver / cuda driver combination"}};
	*words = NULL;
	for (size_t k = 0; k < sizeof known / sizeof *known; k++)
		if (known[k].code == code)
			*words = known[k].words;
	return *words ? CUDA_SUCCESS : INVALID;
}

CUresult cuDeviceGetCount(int *n) { return *n = (int)setting("devices", 1.0), CUDA_SUCCESS; }

CUresult cuDeviceGet(CUdevice *device, int number)
{
	int n;
	cuDeviceGetCount(&n);
	*device = number;
	return number >= 0 && number < n && number < DEVICES_MOST ? CUDA_SUCCESS : INVALID;
}

CUresult cuDeviceGetName(char *name, int bytes, CUdevice device)
{
	(void)device;
	return snprintf(name, (size_t)bytes, "emulated"), CUDA_SUCCESS;
}

CUresult cuDeviceTotalMem_v2(size_t *bytes, CUdevice device)
{
	(void)device;
	return *bytes = (size_t)setting("memory", 1e9), CUDA_SUCCESS;
}

CUresult cuDeviceGetAttribute(int *value, int which, CUdevice device)
{
	(void)device;
	int capability = (int)setting("capability", 80.0);
	*value = which == CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MAJOR	 ? capability / 10
			 : which == CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MINOR ? capability % 10
																	 : 2;
	return CUDA_SUCCESS;
}

CUresult cuDevicePrimaryCtxRetain(CUcontext *context, CUdevice device)
{
	*context = &contexts[device];
	contexts[device].device = device;
	return is_lost[device] ? NOT_THERE : CUDA_SUCCESS;
}

CUresult cuDevicePrimaryCtxRelease_v2(CUdevice device) { return device >= 0 ? CUDA_SUCCESS : INVALID; }

CUresult cuCtxSetCurrent(CUcontext context) { return current = context, CUDA_SUCCESS; }

CUresult cuModuleLoadData(CUmodule *module, const void *image)
{
	*module = (CUmodule)(uintptr_t)image;
	return image ? (CUresult)setting("module", CUDA_SUCCESS) : INVALID;
}

CUresult cuModuleUnload(CUmodule module) { return module ? CUDA_SUCCESS : INVALID; }

CUresult cuModuleGetFunction(CUfunction *function, CUmodule module, const char *name)
{
	*function = (CUfunction)module;
	return strcmp(name, "rve_device_advance") == 0 ? CUDA_SUCCESS : 500;
}

#ifndef FAKE_CUDA_OLD /* a driver of long ago lacks one of the functions */
CUresult cuOccupancyMaxActiveBlocksPerMultiprocessor(int *blocks, CUfunction function, int threads, size_t shared)
{
	*blocks = 4;
	return function && threads > 0 && shared == 0 ? CUDA_SUCCESS : INVALID;
}
#endif

CUresult cuMemAlloc_v2(CUdeviceptr *memory, size_t bytes)
{
	size_t most;
	if (here() != CUDA_SUCCESS)
		return here();
	cuDeviceTotalMem_v2(&most, current->device);
	if (bytes == 0 || used[current->device] + bytes > most)
		return bytes ? OUT_OF_MEMORY : INVALID;
	struct block *block = malloc(sizeof *block + bytes);
	if (!block)
		return OUT_OF_MEMORY;
	block->bytes = bytes, block->device = current->device;
	memset(block->memory, 0xff, bytes); /* nobody may rely on zeros: not a number */
	used[block->device] += bytes;
	*memory = (CUdeviceptr)block->memory;
	return CUDA_SUCCESS;
}

CUresult cuMemFree_v2(CUdeviceptr memory)
{
	struct block *block = (struct block *)(memory - offsetof(struct block, memory));
	used[block->device] -= block->bytes;
	free(block);
	return here();
}

CUresult cuMemcpyHtoD_v2(CUdeviceptr to, const void *from, size_t bytes)
{
	if (here() == CUDA_SUCCESS)
		memcpy((void *)to, from, bytes);
	return here();
}

CUresult cuMemcpyDtoH_v2(void *to, CUdeviceptr from, size_t bytes)
{
	if (here() == CUDA_SUCCESS)
		memcpy(to, (const void *)from, bytes);
	return here();
}

CUresult cuMemcpyHtoDAsync_v2(CUdeviceptr to, const void *from, size_t bytes, CUstream stream)
{
	return stream ? cuMemcpyHtoD_v2(to, from, bytes) : INVALID;
}

CUresult cuMemcpyDtoHAsync_v2(void *to, CUdeviceptr from, size_t bytes, CUstream stream)
{
	return stream ? cuMemcpyDtoH_v2(to, from, bytes) : INVALID;
}

CUresult cuStreamCreate(CUstream *stream, unsigned flags)
{
	*stream = (CUstream)(void *)current;
	return flags == CU_STREAM_NON_BLOCKING ? here() : INVALID;
}

CUresult cuStreamDestroy_v2(CUstream stream) { return stream ? CUDA_SUCCESS : INVALID; }

CUresult cuStreamSynchronize(CUstream stream) { return stream ? here() : INVALID; }

CUresult cuLaunchKernel(CUfunction function, unsigned blocks, unsigned y, unsigned z, unsigned threads, unsigned block_y,
						unsigned block_z, unsigned shared, CUstream stream, void **arguments, void **extra)
{
	static pthread_mutex_t one_at_a_time = PTHREAD_MUTEX_INITIALIZER;
	if (!function || !stream || extra || shared || y * z * block_y * block_z != 1 || blocks == 0 || threads == 0)
		return INVALID;
	if (here() != CUDA_SUCCESS)
		return here();
	const int number = ++launches, refused = (int)setting("launch", 0.0);
	if (refused > 0 && number >= refused)
		return LAUNCH_REFUSED;
	if (number == (int)setting("lost", 0.0)) {
		is_lost[current->device] = 1;
		return CUDA_SUCCESS; /* that it is lost shows when it is waited for */
	}
	const double slow = setting("slow", 0.0);
	const struct timespec pause = {(time_t)(slow / 1e3), (long)((slow / 1e3 - (double)(long)(slow / 1e3)) * 1e9)};
	nanosleep(&pause, NULL);
	pthread_mutex_lock(&one_at_a_time);
	emulated_blocks = (int)blocks;
	for (emulated_block = 0; emulated_block < emulated_blocks; emulated_block++)
		rve_device_advance(*(struct rve_task **)arguments[0], *(int *)arguments[1],
						   *(const struct rve_task_model **)arguments[2], *(const real **)arguments[3],
						   *(unsigned char **)arguments[4], *(unsigned char **)arguments[5]);
	pthread_mutex_unlock(&one_at_a_time);
	return CUDA_SUCCESS;
}
