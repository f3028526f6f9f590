/* Functions of strain by short series: laws call them for every point of every step. */
#ifndef TMDEMPM_LAW_SERIES_H
#define TMDEMPM_LAW_SERIES_H

#include <math.h>

/* atanh(q)/q as a function of q^2 < 1; the series to round-off where it is short. */
static inline double atanh_ratio(double q2)
{
	if (q2 < 1e-3)
		return 1.0 + q2 * (1.0 / 3 + q2 * (1.0 / 5 + q2 * (1.0 / 7 + q2 * (1.0 / 9 + q2 * (1.0 / 11)))));
	double q = sqrt(q2);
	return 0.5 * log((1.0 + q) / (1.0 - q)) / q;
}

/* ln J = 2 atanh((J - 1)/(J + 1)). */
static inline double log_by_ratio(double J)
{
	double z = (J - 1.0) / (J + 1.0);
	return 2.0 * z * atanh_ratio(z * z);
}

#endif
