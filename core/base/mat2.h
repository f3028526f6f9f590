/* 2 x 2 matrices, row-major double[4] = (xx, xy, yx, yy), and symmetric plane tensors.
 *
 * A stress is double[4] = (xx, yy, zz, xy), tension-positive, Pa.
 * Everything here uses + - * / and sqrt only in an order fixed by the source, except where a
 * comment says otherwise, so that the bits do not depend on the maths library. */
#ifndef TMDEMPM_BASE_MAT2_H
#define TMDEMPM_BASE_MAT2_H

#include <math.h>

static inline void mat2_identity(double a[4])
{
	a[0] = a[3] = 1.0;
	a[1] = a[2] = 0.0;
}

/* c = a b; c may be a or b. */
static inline void mat2_multiply(const double a[4], const double b[4], double c[4])
{
	double xx = a[0] * b[0] + a[1] * b[2], xy = a[0] * b[1] + a[1] * b[3];
	double yx = a[2] * b[0] + a[3] * b[2], yy = a[2] * b[1] + a[3] * b[3];
	c[0] = xx, c[1] = xy, c[2] = yx, c[3] = yy;
}

static inline double mat2_determinant(const double a[4]) { return a[0] * a[3] - a[1] * a[2]; }

/* b = a^-1; the caller makes sure that det(a) != 0. */
static inline void mat2_inverse(const double a[4], double b[4])
{
	double s = 1.0 / mat2_determinant(a), xx = a[3] * s, yy = a[0] * s;
	b[1] = -a[1] * s, b[2] = -a[2] * s, b[0] = xx, b[3] = yy;
}

/* e = exp(a), the closed 2 x 2 form (methods-rve: exponential map of the cell).
 * Uses exp, cosh/sinh or cos/sin: host only, never in the kernel. */
void mat2_exp(const double a[4], double e[4]);

/* a = ln(e) of a matrix whose turn is less than a right angle: the inverse of mat2_exp() there.  Host only. */
void mat2_log(const double e[4], double a[4]);

/* Hencky strain ln U of a deformation gradient: (xx, yy, xy).  Host only (uses log). */
void mat2_log_stretch(const double f[4], double strain[3]);

#endif
