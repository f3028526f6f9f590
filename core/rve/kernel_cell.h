/* The periodic cell: inverse, motion, widths, re-basing. */
#ifndef TMDEMPM_RVE_KERNEL_CELL_H
#define TMDEMPM_RVE_KERNEL_CELL_H

#include "rve/dialect.h"

THREADFN void matrix_invert(const real *H, real *H_inv)
{
	real inverse_det = 1.0 / (H[0] * H[3] - H[1] * H[2]);
	H_inv[0] = H[3] * inverse_det, H_inv[1] = -H[1] * inverse_det;
	H_inv[2] = -H[2] * inverse_det, H_inv[3] = H[0] * inverse_det;
}

/* The same where the block's memory has its own address space. */
THREADFN void cell_invert(const SHARED real *H, SHARED real *H_inv)
{
	real h[4] = {H[0], H[1], H[2], H[3]}, inverse[4];
	matrix_invert(h, inverse);
	for (int k = 0; k < 4; k++)
		H_inv[k] = inverse[k];
}

/* H <- A H */
THREADFN void cell_step(SHARED const real *A, SHARED real *H)
{
	real xx = A[0] * H[0] + A[1] * H[2], xy = A[0] * H[1] + A[1] * H[3];
	real yx = A[2] * H[0] + A[3] * H[2], yy = A[2] * H[1] + A[3] * H[3];
	H[0] = xx, H[1] = xy, H[2] = yx, H[3] = yy;
}

THREADFN real cell_volume(const SHARED real *H, real thickness) { return (H[0] * H[3] - H[1] * H[2]) * thickness; }

/* The smaller singular value of M = H H_ref^-1: how much the closest pair may have come closer. */
THREADFN real cell_least_stretch(const SHARED real *H, const SHARED real *H_ref)
{
	real ref[4] = {H_ref[0], H_ref[1], H_ref[2], H_ref[3]}, r[4];
	matrix_invert(ref, r);
	real xx = H[0] * r[0] + H[1] * r[2], xy = H[0] * r[1] + H[1] * r[3];
	real yx = H[2] * r[0] + H[3] * r[2], yy = H[2] * r[1] + H[3] * r[3];
	real sum = xx + yy, difference = xx - yy, skew = xy - yx, shear = xy + yx;
	return 0.5 * (real_sqrt(sum * sum + skew * skew) - real_sqrt(difference * difference + shear * shear));
}

/* Gauss reduction of the cell vectors a and b.  T (whole numbers) tells what became of coordinates: s <- T s. */
THREADFN void cell_reduce(real *H, real *T)
{
	T[0] = T[3] = 1.0;
	T[1] = T[2] = 0.0;
	for (int turn = 0; turn < 64; turn++) {
		real aa = H[0] * H[0] + H[2] * H[2], bb = H[1] * H[1] + H[3] * H[3], ab = H[0] * H[1] + H[2] * H[3];
		real least = real_min(aa, bb);
		if (!((ab < 0.0 ? -ab : ab) > 0.5000001 * least))
			return;
		real k = real_nearest(ab / least);
		if (aa <= bb) { /* b -= k a, so s_a += k s_b */
			H[1] -= k * H[0], H[3] -= k * H[2];
			T[0] += k * T[2], T[1] += k * T[3];
		} else {
			H[0] -= k * H[1], H[2] -= k * H[3];
			T[2] += k * T[0], T[3] += k * T[1];
		}
	}
}

/* The smaller distance between opposite sides of the cell, m. */
THREADFN real cell_least_width(const SHARED real *H)
{
	real aa = H[0] * H[0] + H[2] * H[2], bb = H[1] * H[1] + H[3] * H[3];
	return (H[0] * H[3] - H[1] * H[2]) / real_sqrt(real_max(aa, bb));
}

#endif
