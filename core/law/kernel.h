/* Responses of laws in closed form, for short vectors of points, once for each instruction set: kernel_text.h is
 * compiled for several of them (kernel_base.c, kernel_v3.c, kernel_v4.c), which give the same bits; see mpm/kernel.h.
 */
#ifndef TMDEMPM_LAW_KERNEL_H
#define TMDEMPM_LAW_KERNEL_H

#include "law/law.h"

/* Responds for the points from .. to - 1 of a batch, at least one; time = 0: nothing passes.  Returns the first that
 * could not, whose state is as it was, or `to`. */
typedef int law_respond(const struct law *law, struct law_batch *batch, double time, int from, int to);

struct law_kernel {
	law_respond *hencky;  /* thermoelastic.c */
	law_respond *rankine; /* neohookean_rankine.c */
};

extern const struct law_kernel law_kernel_base;
#if defined(__x86_64__) && defined(__GNUC__)
#define LAW_KERNEL_X86
extern const struct law_kernel law_kernel_v3, law_kernel_v4;
#endif

/* The best that this processor runs (or TMDEMPM_ISA wants). */
const struct law_kernel *law_kernel_here(void);

/* Responds for all points of a batch, in parallel; returns the first that could not, or how many there are. */
int law_each_block(const struct law *law, struct law_batch *batch, double time, law_respond *respond);

#endif
