/* Devices that advance RVEs: GPUs and what else speaks CUDA or OpenCL.  rve/ sees them only as the tables of functions
 * that the program was built with (gpu/); a build without that room has none.
 *
 * A device keeps the states of its RVEs between calls; a call brings the heads and motions (struct rve_task) and takes
 * the heads back.  The kernel is the text of the serial kernel, so are its bits. */
#ifndef TMDEMPM_RVE_DEVICE_H
#define TMDEMPM_RVE_DEVICE_H

#include <stddef.h>

#include "rve/task.h"

struct rve_device_info {
	char name[128];
	char driver[128]; /* platform and version */
	double memory;    /* bytes */
	int units;        /* multiprocessors */
	int is_gpu;       /* 0: a processor that is there already, or an emulation */
	char unfit[128];  /* why it cannot compute RVEs; "" = it can */
};

struct rve_device_setup {
	const struct rve_layout *layout;
	const struct rve_constants *constants;
	int n_variants;
	const real *const *tables; /* [n_variants]: TABLE_FIELDS disc arrays */
	int n_places;              /* states that it is to hold */
	int threads;               /* of a block; 0 = the device's usual number */
};

struct rve_device; /* an open one */

struct rve_backend {
	const char *name, *doc;

	/* Fills at most `most` devices and returns how many there are; if none, `why` says what is missing. */
	int (*list)(struct rve_device_info *devices, int most, char *why, size_t why_bytes);

	/* Opens device `number` of the list, compiles what must be compiled, takes the memory.  STATUS_RESOURCE with a
	 * message if something of that fails. */
	int (*open)(struct rve_device **device, int number, const struct rve_device_setup *setup);
	void (*close)(struct rve_device *device);

	/* One whole state to or from the device. */
	int (*put)(struct rve_device *device, int place, const void *state);
	int (*get)(struct rve_device *device, int place, void *state);

	/* Starts the tasks, which stay where they are until wait() has filled in their heads and statuses. */
	int (*submit)(struct rve_device *device, int n, struct rve_task *tasks);
	int (*wait)(struct rve_device *device, int n, struct rve_task *tasks);
};

/* NULL-terminated; in the order in which `auto` tries them. */
extern const struct rve_backend *const rve_backends[];

enum { RVE_DEVICES_MOST = 16 };

#endif
