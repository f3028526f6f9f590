/* The passes of kernel.h.  Included by kernel_*.c only, each with a MPM_KERNEL of its own. */
#include <math.h>
#include <string.h>

#include "base/mat2.h"
#include "mpm/kernel.h"
#include "mpm/point.h"
#include "rve/vector.h"

typedef double two __attribute__((vector_size(16), may_alias));
typedef double four __attribute__((vector_size(32), may_alias));
typedef int32_t whole __attribute__((vector_size(VECTOR_WIDTH * 4), may_alias));
typedef double loose_vec __attribute__((vector_size(VECTOR_BYTES), may_alias, aligned(8)));

#define ALIGNED __attribute__((aligned(64)))

INLINE whole vec_truncated(vec x) { return __builtin_convertvector(x, whole); }
INLINE vec vec_of_whole(whole i) { return __builtin_convertvector(i, vec); }
INLINE vec vec_magnitude(vec x) { return (vec)((ivec)x & INT64_MAX); }

/* The points of a vector: those of a chunk of n from number k on.  The last one repeats where there are no more. */
struct lanes {
	int at[VECTOR_WIDTH];
	bool together; /* they lie side by side in storage */
};

INLINE struct lanes lanes_of(int n, const int *point, int k)
{
	struct lanes lanes;
	int apart = 0;
	for (int l = 0; l < VECTOR_WIDTH; l++) {
		lanes.at[l] = point[k + l < n ? k + l : n - 1];
		apart |= lanes.at[l] - lanes.at[0] - l;
	}
	lanes.together = apart == 0;
	return lanes;
}

/* Rows of a table of the chunk, by number. */
INLINE struct lanes lanes_in_row(int n, int k)
{
	struct lanes lanes;
	for (int l = 0; l < VECTOR_WIDTH; l++)
		lanes.at[l] = k + l < n ? k + l : n - 1;
	lanes.together = k + VECTOR_WIDTH <= n;
	return lanes;
}

/* A number of each. */
INLINE vec vec_of(const double *numbers, const struct lanes *lanes)
{
	vec x = {0.0};
	if (lanes->together)
		return *(const loose_vec *)(numbers + lanes->at[0]);
	for (int l = 0; l < VECTOR_WIDTH; l++)
		x[l] = numbers[lanes->at[l]];
	return x;
}

INLINE void vec_of2(const double (*numbers)[2], const struct lanes *lanes, vec x[2])
{
	const double *p[VECTOR_WIDTH];
	for (int l = 0; l < VECTOR_WIDTH; l++)
		p[l] = numbers[lanes->at[l]];
	vec_fetch2(p, 0, &x[0], &x[1]);
}

INLINE void vec_of4(const double (*numbers)[4], const struct lanes *lanes, vec x[4])
{
	const double *p[VECTOR_WIDTH];
	for (int l = 0; l < VECTOR_WIDTH; l++)
		p[l] = numbers[lanes->at[l]];
	vec_fetch4(p, &x[0], &x[1], &x[2], &x[3]);
}

#include "mpm/kernel_shape.h"

#include "mpm/kernel_transfer.h"

#include "mpm/kernel_heat.h"

const struct mpm_kernel MPM_KERNEL = {
	.fill = {linear_fill, ugimp_fill, cpdi_fill},
	.scatter_stripe = scatter_stripe_any,
	.gather_block = gather_block_any,
	.flow_stripe = flow_stripe_any,
};
