/* RVEs on OpenCL devices (1.2 and later, double precision). */
#include <dlfcn.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "opencl_api.h"
#include "rve/device.h"
#include "text.h"

enum { PLATFORMS_MOST = 16, BLOCKS_PER_UNIT = 4, USUAL_THREADS = LANES };

struct rve_device {
	cl_device_id id;
	char name[128];
	cl_context context;
	cl_command_queue queue;
	cl_program program;
	cl_kernel kernel;
	cl_mem tasks, model, tables, states, scratch;
	size_t state_bytes, threads;
	int capacity, blocks;
};

/* ---- the library ---- */

static struct opencl_api cl;
static const char *missing; /* what the library lacks; NULL = nothing */

static void opencl_load(void)
{
	void *library = dlopen("libOpenCL.so.1", RTLD_NOW | RTLD_LOCAL);
	if (!library) {
		missing = "there is no libOpenCL.so.1: install an OpenCL driver (a GPU's own, or pocl-opencl-icd)";
		return;
	}
#define OPENCL_FIND(result, name, arguments)                     \
	*(void **)&cl.name = dlsym(library, #name);                  \
	if (!cl.name)                                                \
		missing = "libOpenCL.so.1 lacks " #name ": it is older than OpenCL 1.2";
	OPENCL_FUNCTIONS(OPENCL_FIND)
#undef OPENCL_FIND
}

static const char *opencl_missing(void)
{
	static pthread_once_t once = PTHREAD_ONCE_INIT;
	pthread_once(&once, opencl_load);
	return missing;
}

static const char *opencl_error(cl_int code)
{
	static const struct {
		cl_int code;
		const char *words;
	} known[] = {{-2, "the device is not available"},
				 {-3, "there is no compiler for the device"},
				 {-4, "the device's memory is full"},
				 {-5, "the device is out of resources"},
				 {-6, "out of memory on the host"},
				 {-11, "the kernel could not be compiled"},
				 {-36, "the command queue is gone"},
				 {-54, "a work group of this size cannot be"},
				 {-61, "a buffer of this size cannot be"}};
	for (size_t k = 0; k < sizeof known / sizeof *known; k++)
		if (known[k].code == code)
			return known[k].words;
	return "the driver refuses";
}

static int failed(const struct rve_device *d, const char *what, cl_int code)
{
	return error_set(STATUS_RESOURCE, "OpenCL device %s: %s: %s (error %d)", d->name, what, opencl_error(code), code);
}

#define CL_CHECK(device, what, call)                  \
	do {                                              \
		cl_int code_ = (call);                        \
		if (code_ != CL_SUCCESS)                      \
			return failed(device, what, code_);       \
	} while (0)

/* ---- what there is ---- */

static void info_text(cl_device_id id, cl_uint what, char *text, size_t bytes)
{
	memset(text, 0, bytes);
	char whole[4096] = "";
	if (cl.clGetDeviceInfo(id, what, sizeof whole - 1, whole, NULL) == CL_SUCCESS)
		snprintf(text, bytes, "%.*s", (int)bytes - 1, whole);
}

static cl_ulong info_number(cl_device_id id, cl_uint what, size_t bytes)
{
	cl_ulong value = 0; /* little-endian: smaller types end up at its start */
	return cl.clGetDeviceInfo(id, what, bytes, &value, NULL) == CL_SUCCESS ? value : 0;
}

static void describe(cl_device_id id, cl_platform_id platform, struct rve_device_info *info)
{
	char extensions[4096], version[512] = "";
	memset(info, 0, sizeof *info);
	info_text(id, CL_DEVICE_NAME, info->name, sizeof info->name);
	cl.clGetPlatformInfo(platform, CL_PLATFORM_VERSION, sizeof version - 1, version, NULL);
	snprintf(info->driver, sizeof info->driver, "%.120s", version);
	info->memory = (double)info_number(id, CL_DEVICE_GLOBAL_MEM_SIZE, sizeof(cl_ulong));
	info->units = (int)info_number(id, CL_DEVICE_MAX_COMPUTE_UNITS, sizeof(cl_uint));
	info->is_gpu = (info_number(id, CL_DEVICE_TYPE, sizeof(cl_bitfield)) & CL_DEVICE_TYPE_GPU) != 0;
	info_text(id, CL_DEVICE_EXTENSIONS, extensions, sizeof extensions);
	cl_ulong local = info_number(id, CL_DEVICE_LOCAL_MEM_SIZE, sizeof(cl_ulong));
	if (!strstr(extensions, "cl_khr_fp64"))
		snprintf(info->unfit, sizeof info->unfit, "it has no double precision (cl_khr_fp64)");
	else if (local < 40 * 1024)
		snprintf(info->unfit, sizeof info->unfit, "it has %d kB of local memory, a block needs 40", (int)(local / 1024));
}

/* All devices of all platforms, in the order in which the library tells them. */
static int find(cl_device_id *ids, struct rve_device_info *devices, int most)
{
	cl_platform_id platforms[PLATFORMS_MOST];
	cl_uint n_platforms = 0;
	int n = 0;
	if (cl.clGetPlatformIDs(PLATFORMS_MOST, platforms, &n_platforms) != CL_SUCCESS)
		return 0;
	for (cl_uint p = 0; p < n_platforms && p < PLATFORMS_MOST; p++) {
		cl_device_id found[RVE_DEVICES_MOST];
		cl_uint n_found = 0;
		if (cl.clGetDeviceIDs(platforms[p], CL_DEVICE_TYPE_ALL, RVE_DEVICES_MOST, found, &n_found) != CL_SUCCESS)
			continue;
		for (cl_uint k = 0; k < n_found && k < RVE_DEVICES_MOST && n < most; k++, n++) {
			ids[n] = found[k];
			describe(found[k], platforms[p], &devices[n]);
		}
	}
	return n;
}

static int opencl_list(struct rve_device_info *devices, int most, char *why, size_t why_bytes)
{
	cl_device_id ids[RVE_DEVICES_MOST];
	const char *lack = opencl_missing();
	int n = lack ? 0 : find(ids, devices, most < RVE_DEVICES_MOST ? most : RVE_DEVICES_MOST);
	if (n == 0)
		snprintf(why, why_bytes, "%s",
				 lack ? lack : "libOpenCL finds no device: install an OpenCL driver (a GPU's own, or pocl-opencl-icd)");
	return n;
}

/* ---- opening ---- */

static int build(struct rve_device *d)
{
	cl_int code;
	char options[128], log[2048] = "";
	const char *text = (const char *)gpu_kernel_text;
	const size_t length = gpu_kernel_text_bytes;
	snprintf(options, sizeof options, "-cl-std=CL1.2 -DRVE_TASK_BYTES=%zu -DRVE_TASK_MODEL_BYTES=%zu",
			 sizeof(struct rve_task), sizeof(struct rve_task_model));
	d->program = cl.clCreateProgramWithSource(d->context, 1, &text, &length, &code);
	CL_CHECK(d, "reading the kernel", code);
	code = cl.clBuildProgram(d->program, 1, &d->id, options, NULL, NULL);
	if (code != CL_SUCCESS) {
		cl.clGetProgramBuildInfo(d->program, d->id, CL_PROGRAM_BUILD_LOG, sizeof log - 1, log, NULL);
		return error_set(STATUS_RESOURCE, "OpenCL device %s: compiling the kernel: %s (error %d)\n%s", d->name,
						 opencl_error(code), code, log);
	}
	d->kernel = cl.clCreateKernel(d->program, "rve_device_advance", &code);
	CL_CHECK(d, "finding the kernel", code);
	return STATUS_OK;
}

static int choose_threads(struct rve_device *d, int wanted)
{
	size_t most = 0;
	CL_CHECK(d, "asking about the kernel",
			 cl.clGetKernelWorkGroupInfo(d->kernel, d->id, CL_KERNEL_WORK_GROUP_SIZE, sizeof most, &most, NULL));
	d->threads = wanted > 0 ? (size_t)wanted : USUAL_THREADS;
	while (wanted == 0 && d->threads > most && d->threads > 1)
		d->threads /= 2;
	if (d->threads > most || d->threads == 0)
		return error_set(STATUS_RESOURCE, "OpenCL device %s: blocks of %d threads, it can do %zu", d->name, wanted, most);
	return STATUS_OK;
}

static int buffer(struct rve_device *d, cl_mem *memory, const char *what, size_t bytes)
{
	cl_int code;
	*memory = cl.clCreateBuffer(d->context, CL_MEM_READ_WRITE, bytes, NULL, &code);
	if (code != CL_SUCCESS)
		return error_set(STATUS_RESOURCE, "OpenCL device %s: %.0f MB for %s are not to be had: %s (error %d)", d->name,
						 (double)bytes * 1e-6, what, opencl_error(code), code);
	return STATUS_OK;
}

static int upload(struct rve_device *d, cl_mem memory, size_t at, size_t bytes, const void *data)
{
	CL_CHECK(d, "writing to it", cl.clEnqueueWriteBuffer(d->queue, memory, 1, at, bytes, data, 0, NULL, NULL));
	return STATUS_OK;
}

static int take_memory(struct rve_device *d, const struct rve_device_setup *setup)
{
	const struct rve_task_model model = {*setup->layout, *setup->constants};
	size_t table = sizeof(real) * TABLE_FIELDS * (size_t)setup->layout->stride;
	size_t places = (size_t)(setup->n_places > 0 ? setup->n_places : 1);
	d->state_bytes = (size_t)setup->layout->bytes;
	d->capacity = (int)places;
	d->blocks = BLOCKS_PER_UNIT * (int)info_number(d->id, CL_DEVICE_MAX_COMPUTE_UNITS, sizeof(cl_uint));
	d->blocks = d->blocks > d->capacity ? d->capacity : d->blocks > 0 ? d->blocks : 1;
	CHECK(buffer(d, &d->states, "the states of RVEs", places * d->state_bytes));
	CHECK(buffer(d, &d->scratch, "the blocks", (size_t)d->blocks * (size_t)setup->layout->scratch));
	CHECK(buffer(d, &d->tasks, "the motions of RVEs", places * sizeof(struct rve_task)));
	CHECK(buffer(d, &d->model, "the model", sizeof model));
	CHECK(buffer(d, &d->tables, "the model", table * (size_t)setup->n_variants));
	CHECK(upload(d, d->model, 0, sizeof model, &model));
	for (int v = 0; v < setup->n_variants; v++)
		CHECK(upload(d, d->tables, table * (size_t)v, table, setup->tables[v]));
	return STATUS_OK;
}

static int set_arguments(struct rve_device *d)
{
	cl_mem *const memory[] = {&d->tasks, NULL, &d->model, &d->tables, &d->states, &d->scratch};
	for (cl_uint k = 0; k < sizeof memory / sizeof *memory; k++)
		if (memory[k])
			CL_CHECK(d, "preparing the kernel", cl.clSetKernelArg(d->kernel, k, sizeof(cl_mem), memory[k]));
	return STATUS_OK;
}

static int open_on(struct rve_device *d, const struct rve_device_setup *setup)
{
	cl_int code;
	d->context = cl.clCreateContext(NULL, 1, &d->id, NULL, NULL, &code);
	CL_CHECK(d, "opening it", code);
	d->queue = cl.clCreateCommandQueue(d->context, d->id, 0, &code);
	CL_CHECK(d, "opening it", code);
	CHECK(build(d));
	CHECK(choose_threads(d, setup->threads));
	CHECK(take_memory(d, setup));
	return set_arguments(d);
}

static void opencl_close(struct rve_device *d)
{
	if (!d)
		return;
	cl_mem memory[] = {d->tasks, d->model, d->tables, d->states, d->scratch};
	for (size_t k = 0; k < sizeof memory / sizeof *memory; k++)
		if (memory[k])
			cl.clReleaseMemObject(memory[k]);
	if (d->kernel)
		cl.clReleaseKernel(d->kernel);
	if (d->program)
		cl.clReleaseProgram(d->program);
	if (d->queue)
		cl.clReleaseCommandQueue(d->queue);
	if (d->context)
		cl.clReleaseContext(d->context);
	free(d);
}

static int opencl_open(struct rve_device **device, int number, const struct rve_device_setup *setup)
{
	struct rve_device_info devices[RVE_DEVICES_MOST];
	cl_device_id ids[RVE_DEVICES_MOST];
	*device = NULL;
	if (opencl_missing())
		return error_set(STATUS_RESOURCE, "OpenCL: %s", opencl_missing());
	int n = find(ids, devices, RVE_DEVICES_MOST);
	if (number < 0 || number >= n)
		return error_set(STATUS_RESOURCE, "OpenCL device %d: there %s %d", number, n == 1 ? "is" : "are", n);
	if (devices[number].unfit[0])
		return error_set(STATUS_RESOURCE, "OpenCL device %s: %s", devices[number].name, devices[number].unfit);
	struct rve_device *d = calloc(1, sizeof *d);
	if (!d)
		return error_set(STATUS_RESOURCE, "out of memory");
	d->id = ids[number];
	memcpy(d->name, devices[number].name, sizeof d->name);
	int status = open_on(d, setup);
	if (status == STATUS_OK)
		*device = d;
	else
		opencl_close(d);
	return status;
}

/* ---- work ---- */

static int opencl_put(struct rve_device *d, int place, const void *state)
{
	return upload(d, d->states, (size_t)place * d->state_bytes, d->state_bytes, state);
}

static int opencl_get(struct rve_device *d, int place, void *state)
{
	CL_CHECK(d, "reading from it",
			 cl.clEnqueueReadBuffer(d->queue, d->states, 1, (size_t)place * d->state_bytes, d->state_bytes, state, 0,
									NULL, NULL));
	return STATUS_OK;
}

/* The queue is in order: what is read afterwards has been computed. */
static int opencl_submit(struct rve_device *d, int n, struct rve_task *tasks)
{
	size_t local = d->threads, global = local * (size_t)(n < d->blocks ? n : d->blocks);
	size_t bytes = (size_t)n * sizeof *tasks;
	if (n == 0)
		return STATUS_OK;
	CL_CHECK(d, "writing to it", cl.clEnqueueWriteBuffer(d->queue, d->tasks, 0, 0, bytes, tasks, 0, NULL, NULL));
	CL_CHECK(d, "starting the kernel", cl.clSetKernelArg(d->kernel, 1, sizeof n, &n));
	CL_CHECK(d, "starting the kernel",
			 cl.clEnqueueNDRangeKernel(d->queue, d->kernel, 1, NULL, &global, &local, 0, NULL, NULL));
	CL_CHECK(d, "starting the kernel", cl.clFlush(d->queue));
	return STATUS_OK;
}

static int opencl_wait(struct rve_device *d, int n, struct rve_task *tasks)
{
	size_t bytes = (size_t)n * sizeof *tasks;
	if (n == 0)
		return STATUS_OK;
	CL_CHECK(d, "waiting for it", cl.clEnqueueReadBuffer(d->queue, d->tasks, 1, 0, bytes, tasks, 0, NULL, NULL));
	return STATUS_OK;
}

const struct rve_backend gpu_opencl = {
	.name = "opencl",
	.doc = "RVEs on an OpenCL device (1.2 or later, double precision)",
	.list = opencl_list,
	.open = opencl_open,
	.close = opencl_close,
	.put = opencl_put,
	.get = opencl_get,
	.submit = opencl_submit,
	.wait = opencl_wait,
};
