/* The passes over points that decide the speed of the MPM, once for each instruction set.
 *
 * kernel_text.h is compiled for several of them (kernel_base.c, kernel_v3.c, kernel_v4.c); the one that runs here is
 * chosen when a scene is created (TMDEMPM_ISA, as for the RVEs).  What is arithmetic of one point is done for a vector
 * of points, each lane in the order of operations that a single one would see, never contracted; sums over points are
 * taken in their turn.  So the bits are those of any other instruction set, and of a plain loop. */
#ifndef TMDEMPM_MPM_KERNEL_H
#define TMDEMPM_MPM_KERNEL_H

#include "mpm/shape.h"

struct mpm;
struct mpm_work;

struct mpm_kernel {
	/* by enum shape_number; see shape.h */
	void (*fill[SHAPE_COUNT])(const struct shape_grid *grid, const struct shape_points *points, int n, const int *point,
							  struct shape_lists *lists);
	void (*scatter_stripe)(struct mpm *mpm, struct mpm_work *w, int stripe); /* to the grid */
	void (*gather_block)(struct mpm *mpm, struct mpm_work *w, int block);    /* and back */
	/* A pass of heat over dt: flows and sources; the first looks at imposed temperatures, the last spends the sources.
	 */
	void (*flow_stripe)(struct mpm *mpm, struct mpm_work *w, int stripe, double dt, bool first_pass, bool last_pass);
};

extern const struct mpm_kernel mpm_kernel_base;
#if defined(__x86_64__) && defined(__GNUC__)
#define MPM_KERNEL_X86
extern const struct mpm_kernel mpm_kernel_v3, mpm_kernel_v4;
#endif

/* The best that this processor runs (or TMDEMPM_ISA wants). */
const struct mpm_kernel *mpm_kernel_here(void);

#endif
