/* The responses of kernel.h.  Included by kernel_*.c only, each with a LAW_KERNEL of its own. */
#include <string.h>

#include "base/lanes.h"
#include "law/kernel.h"
#include "law/rankine.h"
#include "law/series.h"
#include "law/thermoelastic.h"

/* atanh_ratio() and log_by_ratio() of series.h, in their order of operations. */
VECFN vec vec_atanh_ratio(vec q2)
{
	vec ratio = ATANH_SERIES(q2);
	mask short_ = mask_above(vec_set(ATANH_MOST), q2);
	if (mask_all(short_))
		return ratio;
	for (int l = 0; l < VECTOR_WIDTH; l++)
		ratio[l] = atanh_ratio(q2[l]);
	return ratio;
}

VECFN vec vec_log_by_ratio(vec J)
{
	vec z = (J - 1.0) / (J + 1.0);
	return 2.0 * z * vec_atanh_ratio(z * z);
}

/* The points of a vector: of a batch those from k on, the last one repeated where there are no more. */
struct members {
	int k, n; /* the first, and how many are not repeated */
	struct lanes points, slots;
	unsigned failed; /* bit l: lane l cannot respond */
};

VECFN struct members members_of(const struct law_batch *batch, int k, int to)
{
	struct members members = {
		.k = k, .points = lanes_in_row(to, k), .n = to - k < VECTOR_WIDTH ? to - k : VECTOR_WIDTH};
	for (int l = 0; l < VECTOR_WIDTH; l++)
		members.slots.at[l] = batch->slot[members.points.at[l]];
	return members;
}

/* Marks lanes that fail. */
VECFN void fail(struct members *members, mask fails)
{
	vec one = vec_where(fails, vec_set(1.0));
	if (!mask_any(fails))
		return;
	for (int l = 0; l < members->n; l++)
		members->failed |= one[l] != 0.0 ? 1u << l : 0u;
}

/* The first of those points that failed, or `none`. */
VECFN int first_failed(const struct members *members, int none)
{
	return members->failed ? members->k + __builtin_ctz(members->failed) : none;
}

/* F of each: a caller's array need not be aligned. */
VECFN void vec_deformation(const struct law_batch *batch, const struct members *members, vec F[4])
{
	double rows[VECTOR_WIDTH][4] ALIGNED;
	const double *p[VECTOR_WIDTH];
	for (int l = 0; l < VECTOR_WIDTH; l++) {
		memcpy(rows[l], batch->F[members->points.at[l]], sizeof rows[l]);
		p[l] = rows[l];
	}
	vec_fetch4(p, &F[0], &F[1], &F[2], &F[3]);
}

/* Four numbers of each state, at `offset` in records of `stride` numbers. */
VECFN void vec_of_states(const void *states, int stride, int offset, const struct members *members, vec x[4])
{
	const double *p[VECTOR_WIDTH];
	for (int l = 0; l < VECTOR_WIDTH; l++)
		p[l] = (const double *)states + (size_t)members->slots.at[l] * (size_t)stride + offset;
	vec_fetch4(p, &x[0], &x[1], &x[2], &x[3]);
}

VECFN void put_states(void *states, int stride, int offset, const struct members *members, const vec x[4])
{
	double rows[VECTOR_WIDTH][4] ALIGNED;
	vec_put4(rows[0], x[0], x[1], x[2], x[3]);
	for (int l = 0; l < members->n; l++)
		if (!(members->failed >> l & 1u))
			*(four *)((double *)states + (size_t)members->slots.at[l] * (size_t)stride + offset) =
				*(const four *)rows[l];
}

/* A number of each point of the batch. */
VECFN void put_numbers(double *numbers, const struct members *members, vec x)
{
	double row[VECTOR_WIDTH] ALIGNED;
	if (members->n == VECTOR_WIDTH && !members->failed) {
		*(loose_vec *)&numbers[members->k] = x;
		return;
	}
	vec_store(row, x);
	for (int l = 0; l < members->n; l++)
		if (!(members->failed >> l & 1u))
			numbers[members->k + l] = row[l];
}

/* What all laws here give: stress (xx yy zz xy), modulus, heat; they leave conduction to the material. */
VECFN void put_response(struct law_batch *batch, const struct members *members, const vec stress[4], vec modulus,
						vec heat)
{
	double rows[VECTOR_WIDTH][4] ALIGNED;
	vec_put4(rows[0], stress[0], stress[1], stress[2], stress[3]);
	for (int l = 0; l < members->n; l++)
		if (!(members->failed >> l & 1u))
			memcpy(batch->stress[members->k + l], rows[l], sizeof rows[l]);
	put_numbers(batch->modulus, members, modulus);
	put_numbers(batch->heat, members, heat);
	memset(batch->conductivity[members->k], 0, (size_t)members->n * sizeof *batch->conductivity);
}

#include "law/kernel_hencky.h"

#include "law/kernel_rankine.h"

const struct law_kernel LAW_KERNEL = {.hencky = hencky, .rankine = rankine};
