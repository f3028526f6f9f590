/* Where RVEs are computed: on one or several devices, on this processor, or on both together.
 *
 * Each state lives where it was advanced last.  Its head is always here as well, so that what an RVE says of itself
 * (rve_get_info) needs no copy; its arrays come back by rve_pool_fetch().  RVEs that need more than the kernel (those
 * that fly, are frozen or nearly too slender) are advanced here.  As all devices run the kernel's text, the bits do not
 * depend on who computes what: shares follow the measured cost. */
#ifndef TMDEMPM_RVE_POOL_H
#define TMDEMPM_RVE_POOL_H

#include <stddef.h>

#include "rve/device.h"
#include "rve/rve.h"

struct rve_pool;

/* Is this a list of devices: `auto`, or NAME[:N] and `cpu`, separated by commas?  STATUS_INPUT with a message. */
int rve_devices_check(const char *devices);

/* Whether there is something to compute on other than this processor: a device that is named, for `auto` a GPU that will
 * do.  Devices compute what the path "serial" does. */
int rve_devices_any(const char *devices);

/* For n states at `states`, which stay the caller's.  `devices` as above; *pool = NULL: the processor alone.  `note` says
 * in words what was chosen, and with `auto` also why not something else.  STATUS_RESOURCE if a device that is named
 * cannot be used.  `threads`: of a block, 0 = the device's usual number. */
int rve_pool_create(struct rve_pool **pool, const struct rve_model *model, unsigned char *states, int n,
					const char *devices, int threads, char *note, size_t note_bytes);
void rve_pool_free(struct rve_pool *pool);

/* rve_advance() of a batch over these states.  STATUS_RESOURCE if a device is lost and what it held with it. */
int rve_pool_advance(struct rve_pool *pool, struct rve_batch *batch);

/* Makes the state of this slot (all: -1) whole in the caller's memory.  Without a pool it always is. */
int rve_pool_fetch(struct rve_pool *pool, int slot);

/* The caller has changed the state of this slot (all: -1) in its memory, whole.  May come without a pool. */
void rve_pool_touched(struct rve_pool *pool, int slot);

/* How many RVEs are where now, for reports: "opencl:0 NAME 1500, cpu 100". */
void rve_pool_shares(const struct rve_pool *pool, char *words, size_t bytes);

#endif
