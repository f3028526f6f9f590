#include "base/mat2.h"

/* sinh(q)/q as a function of q^2, for either sign of q^2, exact to round-off through zero. */
static double sinhc(double q2)
{
	if (fabs(q2) < 1e-2)
		return 1.0 + q2 / 6.0 * (1.0 + q2 / 20.0 * (1.0 + q2 / 42.0 * (1.0 + q2 / 72.0 * (1.0 + q2 / 110.0))));
	if (q2 > 0.0)
		return sinh(sqrt(q2)) / sqrt(q2);
	return sin(sqrt(-q2)) / sqrt(-q2);
}

void mat2_exp(const double a[4], double e[4])
{
	double s = 0.5 * (a[0] + a[3]); /* a = s I + d, d^2 = q2 I */
	double d = 0.5 * (a[0] - a[3]);
	double q2 = d * d + a[1] * a[2];
	double c = q2 > 0.0 ? cosh(sqrt(q2)) : cos(sqrt(-q2));
	double k = sinhc(q2), es = exp(s);
	e[0] = es * (c + k * d);
	e[1] = es * k * a[1];
	e[2] = es * k * a[2];
	e[3] = es * (c - k * d);
}

/* q / sinh(q) as a function of sinh^2(q), for either sign of it. */
static double q_per_sinh(double sinh2)
{
	if (fabs(sinh2) < 1e-3)
		return 1.0 -
			   sinh2 / 6.0 * (1.0 - sinh2 * 9.0 / 20.0 * (1.0 - sinh2 * 25.0 / 42.0 * (1.0 - sinh2 * 49.0 / 72.0)));
	if (sinh2 > 0.0)
		return asinh(sqrt(sinh2)) / sqrt(sinh2);
	return asin(sqrt(-sinh2)) / sqrt(-sinh2);
}

void mat2_log(const double e[4], double a[4])
{
	/* e = s (c I + d), d without trace, d^2 = sinh^2(q) I, s = sqrt(det e) */
	double s = sqrt(mat2_determinant(e)), d = 0.5 * (e[0] - e[3]) / s, xy = e[1] / s, yx = e[2] / s;
	double k = q_per_sinh(d * d + xy * yx), mean = log(s);
	a[0] = mean + k * d, a[3] = mean - k * d;
	a[1] = k * xy, a[2] = k * yx;
}

void mat2_log_stretch(const double f[4], double strain[3])
{
	/* C = F^T F = U^2; ln U = 1/2 ln C by its spectral decomposition */
	double cxx = f[0] * f[0] + f[2] * f[2], cyy = f[1] * f[1] + f[3] * f[3];
	double cxy = f[0] * f[1] + f[2] * f[3];
	double mean = 0.5 * (cxx + cyy), d = 0.5 * (cxx - cyy), r = hypot(d, cxy);
	double det = mat2_determinant(f);
	double big = mean + r, small = det * det / big; /* product of eigenvalues = det^2 */
	double m = 0.25 * (log(big) + log(small));
	double k = r > 0.0 ? 0.25 * (log(big) - log(small)) / r : 0.0;
	strain[0] = m + k * d;
	strain[1] = m - k * d;
	strain[2] = k * cxy;
}
