/* Numbers of points in short vectors (rve/vector.h), in double precision: fetched by index, put back by index.  For
 * texts that are compiled for several instruction sets, which all give the same bits. */
#ifndef TMDEMPM_BASE_LANES_H
#define TMDEMPM_BASE_LANES_H

#include <stdbool.h>

#include "rve/vector.h"

typedef double two __attribute__((vector_size(16), may_alias));
typedef double four __attribute__((vector_size(32), may_alias));
typedef int32_t whole __attribute__((vector_size(VECTOR_WIDTH * 4), may_alias));
typedef double loose_vec __attribute__((vector_size(VECTOR_BYTES), may_alias, aligned(8)));

#define ALIGNED __attribute__((aligned(64)))

VECFN whole vec_truncated(vec x) { return __builtin_convertvector(x, whole); }
VECFN vec vec_of_whole(whole i) { return __builtin_convertvector(i, vec); }
VECFN bool mask_all(mask m)
{
#ifdef VECTOR_512
	return m == 0xff;
#else
	return !mask_any(~m);
#endif
}
VECFN vec vec_magnitude(vec x) { return (vec)((ivec)x & INT64_MAX); }

/* The points of a vector: those of a chunk of n from number k on.  The last one repeats where there are no more. */
struct lanes {
	int at[VECTOR_WIDTH];
	bool together; /* they lie side by side in storage */
};

VECFN struct lanes lanes_of(int n, const int *point, int k)
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
VECFN struct lanes lanes_in_row(int n, int k)
{
	struct lanes lanes;
	for (int l = 0; l < VECTOR_WIDTH; l++)
		lanes.at[l] = k + l < n ? k + l : n - 1;
	lanes.together = k + VECTOR_WIDTH <= n;
	return lanes;
}

/* A number of each. */
VECFN vec vec_of(const double *numbers, const struct lanes *lanes)
{
	vec x = {0.0};
	if (lanes->together)
		return *(const loose_vec *)(numbers + lanes->at[0]);
	for (int l = 0; l < VECTOR_WIDTH; l++)
		x[l] = numbers[lanes->at[l]];
	return x;
}

VECFN void vec_of2(const double (*numbers)[2], const struct lanes *lanes, vec x[2])
{
	const double *p[VECTOR_WIDTH];
	for (int l = 0; l < VECTOR_WIDTH; l++)
		p[l] = numbers[lanes->at[l]];
	vec_fetch2(p, 0, &x[0], &x[1]);
}

VECFN void vec_of4(const double (*numbers)[4], const struct lanes *lanes, vec x[4])
{
	const double *p[VECTOR_WIDTH];
	for (int l = 0; l < VECTOR_WIDTH; l++)
		p[l] = numbers[lanes->at[l]];
	vec_fetch4(p, &x[0], &x[1], &x[2], &x[3]);
}

#endif
