/* Functions of strain by short series: laws call them for every point of every step. */
#ifndef TMDEMPM_LAW_SERIES_H
#define TMDEMPM_LAW_SERIES_H

#include <math.h>

/* atanh(q)/q by its series, to round-off while q^2 is less than ATANH_MOST; of a number or of a vector of them. */
#define ATANH_MOST 1e-3
#define ATANH_SERIES(q2) (1.0 + q2 * (1.0 / 3 + q2 * (1.0 / 5 + q2 * (1.0 / 7 + q2 * (1.0 / 9 + q2 * (1.0 / 11))))))

/* atanh(q)/q as a function of q^2 < 1. */
static inline double atanh_ratio(double q2)
{
	if (q2 < ATANH_MOST)
		return ATANH_SERIES(q2);
	double q = sqrt(q2);
	return 0.5 * log((1.0 + q) / (1.0 - q)) / q;
}

/* exp(s) by its series, to the last bit or so while |s| is less than SERIES_MOST; of a number or of a vector of them.
 */
#define SERIES_MOST 0.01
#define EXP_SERIES(s)                                                                                                  \
	(1.0 + s * (1.0 + s * (1.0 / 2 + s * (1.0 / 6 + s * (1.0 / 24 + s * (1.0 / 120 + s * (1.0 / 720)))))))

static inline double exp_by_series(double s) { return fabs(s) < SERIES_MOST ? EXP_SERIES(s) : exp(s); }

/* ln J = 2 atanh((J - 1)/(J + 1)). */
static inline double log_by_ratio(double J)
{
	double z = (J - 1.0) / (J + 1.0);
	return 2.0 * z * atanh_ratio(z * z);
}

#endif
