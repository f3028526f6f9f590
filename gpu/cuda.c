/* RVEs on NVIDIA's GPUs, through the driver. */
#include <dlfcn.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "cuda_api.h"
#include "rve/device.h"
#include "text.h"

/* Registers are enough for 3 blocks of 128 threads on a multiprocessor or for 6 of 64, shared memory for 4 (A100) or 6. */
enum { USUAL_THREADS = 64 };

enum { MEMORY_TASKS, MEMORY_MODEL, MEMORY_TABLES, MEMORY_STATES, MEMORY_SCRATCH, MEMORIES };

struct rve_device {
	CUdevice id;
	char name[128];
	CUcontext context;
	CUmodule module;
	CUfunction kernel;
	CUstream stream;
	CUdeviceptr memory[MEMORIES];
	size_t state_bytes;
	unsigned threads;
	int capacity, blocks, units;
};

/* ---- the driver ---- */

static struct cuda_api cu;
static char missing[256]; /* what is missing; "" = nothing */

static const char *cuda_error(CUresult code)
{
	const char *words = NULL;
	return cu.error_string && cu.error_string(code, &words) == CUDA_SUCCESS && words ? words : "the driver refuses";
}

static void cuda_load(void)
{
	void *library = dlopen("libcuda.so.1", RTLD_NOW | RTLD_LOCAL);
	if (!library) {
		snprintf(missing, sizeof missing, "there is no libcuda.so.1: no driver of an NVIDIA GPU");
		return;
	}
#define CUDA_FIND(name, symbol, arguments)            \
	*(void **)&cu.name = dlsym(library, #symbol);     \
	if (!cu.name)                                     \
		snprintf(missing, sizeof missing, "libcuda.so.1 lacks " #symbol ": the driver is too old");
	CUDA_FUNCTIONS(CUDA_FIND)
#undef CUDA_FIND
	CUresult code = missing[0] ? CUDA_SUCCESS : cu.init(0);
	if (code != CUDA_SUCCESS)
		snprintf(missing, sizeof missing, "the driver does not start: %s (error %d)", cuda_error(code), code);
}

static const char *cuda_missing(void)
{
	static pthread_once_t once = PTHREAD_ONCE_INIT;
	pthread_once(&once, cuda_load);
	return missing[0] ? missing : NULL;
}

static int failed(const struct rve_device *d, const char *what, CUresult code)
{
	return error_set(STATUS_RESOURCE, "CUDA device %s: %s: %s (error %d)", d->name, what, cuda_error(code), code);
}

#define CU_CHECK(device, what, call)                  \
	do {                                              \
		CUresult code_ = (call);                      \
		if (code_ != CUDA_SUCCESS)                    \
			return failed(device, what, code_);       \
	} while (0)

/* ---- what there is ---- */

static int attribute(CUdevice id, int which)
{
	int value = 0;
	return cu.device_attribute(&value, which, id) == CUDA_SUCCESS ? value : 0;
}

static void describe(CUdevice id, struct rve_device_info *info)
{
	int version = 0;
	size_t memory = 0;
	int major = attribute(id, CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MAJOR);
	int minor = attribute(id, CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MINOR);
	memset(info, 0, sizeof *info);
	cu.device_name(info->name, sizeof info->name - 1, id);
	cu.driver_version(&version);
	cu.device_memory(&memory, id);
	snprintf(info->driver, sizeof info->driver, "CUDA %d.%d, sm_%d%d", version / 1000, version % 1000 / 10, major, minor);
	info->memory = (double)memory;
	info->units = attribute(id, CU_DEVICE_ATTRIBUTE_MULTIPROCESSOR_COUNT);
	info->is_gpu = 1;
	if (gpu_kernel_fatbin_bytes == 0)
		snprintf(info->unfit, sizeof info->unfit, "this program was built without nvcc: use opencl, or build with it");
	else if (major * 10 + minor < 75)
		snprintf(info->unfit, sizeof info->unfit, "its compute capability is %d.%d, expected at least 7.5", major, minor);
}

static int cuda_list(struct rve_device_info *devices, int most, char *why, size_t why_bytes)
{
	int n = 0;
	const char *lack = cuda_missing();
	if (!lack && cu.device_count(&n) != CUDA_SUCCESS)
		n = 0;
	n = n < most ? n : most;
	if (n == 0)
		snprintf(why, why_bytes, "%s", lack ? lack : "the driver has no device");
	for (int k = 0; k < n; k++) {
		CUdevice id;
		if (cu.device_get(&id, k) == CUDA_SUCCESS)
			describe(id, &devices[k]);
	}
	return n;
}

/* ---- opening ---- */

static int take(struct rve_device *d, int which, const char *what, size_t bytes)
{
	CUresult code = cu.allocate(&d->memory[which], bytes);
	if (code != CUDA_SUCCESS)
		return error_set(STATUS_RESOURCE, "CUDA device %s: %.0f MB for %s are not to be had: %s (error %d)", d->name,
						 (double)bytes * 1e-6, what, cuda_error(code), code);
	return STATUS_OK;
}

static int take_memory(struct rve_device *d, const struct rve_device_setup *setup)
{
	const struct rve_task_model model = {*setup->layout, *setup->constants};
	size_t table = sizeof(real) * TABLE_FIELDS * (size_t)setup->layout->stride;
	size_t places = (size_t)(setup->n_places > 0 ? setup->n_places : 1);
	d->state_bytes = (size_t)setup->layout->bytes;
	d->capacity = (int)places;
	int blocks;
	CU_CHECK(d, "asking about the kernel", cu.occupancy(&blocks, d->kernel, (int)d->threads, 0));
	if (blocks < 1 || d->units < 1)
		return error_set(STATUS_RESOURCE, "CUDA device %s: it has no room for a block of %u threads", d->name, d->threads);
	d->blocks = blocks * d->units < d->capacity ? blocks * d->units : d->capacity;
	CHECK(take(d, MEMORY_STATES, "the states of RVEs", places * d->state_bytes));
	CHECK(take(d, MEMORY_SCRATCH, "the blocks", (size_t)d->blocks * (size_t)setup->layout->scratch));
	CHECK(take(d, MEMORY_TASKS, "the motions of RVEs", places * sizeof(struct rve_task)));
	CHECK(take(d, MEMORY_MODEL, "the model", sizeof model));
	CHECK(take(d, MEMORY_TABLES, "the model", table * (size_t)setup->n_variants));
	CU_CHECK(d, "writing to it", cu.to_device(d->memory[MEMORY_MODEL], &model, sizeof model));
	for (int v = 0; v < setup->n_variants; v++)
		CU_CHECK(d, "writing to it",
				 cu.to_device(d->memory[MEMORY_TABLES] + table * (size_t)v, setup->tables[v], table));
	return STATUS_OK;
}

static int open_on(struct rve_device *d, const struct rve_device_setup *setup)
{
	CU_CHECK(d, "opening it", cu.context_retain(&d->context, d->id));
	CU_CHECK(d, "opening it", cu.context_use(d->context));
	CU_CHECK(d, "loading the kernel", cu.module_load(&d->module, gpu_kernel_fatbin));
	CU_CHECK(d, "finding the kernel", cu.module_function(&d->kernel, d->module, "rve_device_advance"));
	CU_CHECK(d, "opening it", cu.stream_create(&d->stream, CU_STREAM_NON_BLOCKING));
	d->threads = (unsigned)(setup->threads > 0 ? setup->threads : USUAL_THREADS);
	return take_memory(d, setup);
}

static void cuda_close(struct rve_device *d)
{
	if (!d)
		return;
	if (d->context) {
		cu.context_use(d->context);
		for (int k = 0; k < MEMORIES; k++)
			if (d->memory[k])
				cu.release(d->memory[k]);
		if (d->stream)
			cu.stream_destroy(d->stream);
		if (d->module)
			cu.module_unload(d->module);
		cu.context_release(d->id);
	}
	free(d);
}

static int cuda_open(struct rve_device **device, int number, const struct rve_device_setup *setup)
{
	struct rve_device_info devices[RVE_DEVICES_MOST];
	char why[256];
	*device = NULL;
	int n = cuda_list(devices, RVE_DEVICES_MOST, why, sizeof why);
	if (n == 0)
		return error_set(STATUS_RESOURCE, "CUDA: %s", why);
	if (number < 0 || number >= n)
		return error_set(STATUS_RESOURCE, "CUDA device %d: there %s %d", number, n == 1 ? "is" : "are", n);
	if (devices[number].unfit[0])
		return error_set(STATUS_RESOURCE, "CUDA device %s: %s", devices[number].name, devices[number].unfit);
	struct rve_device *d = calloc(1, sizeof *d);
	if (!d)
		return error_set(STATUS_RESOURCE, "out of memory");
	memcpy(d->name, devices[number].name, sizeof d->name);
	d->units = devices[number].units;
	CUresult code = cu.device_get(&d->id, number);
	int status = code == CUDA_SUCCESS ? open_on(d, setup) : failed(d, "opening it", code);
	if (status == STATUS_OK)
		*device = d;
	else
		cuda_close(d);
	return status;
}

/* ---- work ---- */

static int cuda_put(struct rve_device *d, int place, const void *state)
{
	CU_CHECK(d, "opening it", cu.context_use(d->context));
	CU_CHECK(d, "writing to it",
			 cu.to_device(d->memory[MEMORY_STATES] + (size_t)place * d->state_bytes, state, d->state_bytes));
	return STATUS_OK;
}

static int cuda_get(struct rve_device *d, int place, void *state)
{
	CU_CHECK(d, "opening it", cu.context_use(d->context));
	CU_CHECK(d, "reading from it",
			 cu.to_host(state, d->memory[MEMORY_STATES] + (size_t)place * d->state_bytes, d->state_bytes));
	return STATUS_OK;
}

static int cuda_submit(struct rve_device *d, int n, struct rve_task *tasks)
{
	if (n == 0)
		return STATUS_OK;
	void *arguments[] = {&d->memory[MEMORY_TASKS],  &n,
						 &d->memory[MEMORY_MODEL],  &d->memory[MEMORY_TABLES],
						 &d->memory[MEMORY_STATES], &d->memory[MEMORY_SCRATCH]};
	size_t bytes = (size_t)n * sizeof *tasks;
	unsigned blocks = (unsigned)(n < d->blocks ? n : d->blocks);
	CU_CHECK(d, "opening it", cu.context_use(d->context));
	CU_CHECK(d, "writing to it", cu.to_device_async(d->memory[MEMORY_TASKS], tasks, bytes, d->stream));
	CU_CHECK(d, "starting the kernel",
			 cu.launch(d->kernel, blocks, 1, 1, d->threads, 1, 1, 0, d->stream, arguments, NULL));
	return STATUS_OK;
}

static int cuda_wait(struct rve_device *d, int n, struct rve_task *tasks)
{
	if (n == 0)
		return STATUS_OK;
	CU_CHECK(d, "opening it", cu.context_use(d->context));
	CU_CHECK(d, "reading from it",
			 cu.to_host_async(tasks, d->memory[MEMORY_TASKS], (size_t)n * sizeof *tasks, d->stream));
	CU_CHECK(d, "waiting for it", cu.stream_wait(d->stream));
	return STATUS_OK;
}

const struct rve_backend gpu_cuda = {
	.name = "cuda",
	.doc = "RVEs on an NVIDIA GPU (compute capability 7.5 or later)",
	.list = cuda_list,
	.open = cuda_open,
	.close = cuda_close,
	.put = cuda_put,
	.get = cuda_get,
	.submit = cuda_submit,
	.wait = cuda_wait,
};
