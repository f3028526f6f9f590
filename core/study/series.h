/* Columns of curves over an abscissa, and norms of their differences. */
#ifndef TMDEMPM_STUDY_SERIES_H
#define TMDEMPM_STUDY_SERIES_H

#include "io/csv.h"
#include "study/private.h"

struct series {
	int n;
	double *x, *y; /* x grows */
};

/* Both are expressions of the table's columns, by name without unit, and of the knobs of `place` (NULL = none).
 * STATUS_INPUT if a name is not known, or the abscissa does not grow. */
int series_of_table(struct series *series, const struct csv_table *table, const struct plan_place *place,
					const char *abscissa, const char *column);

int series_create(struct series *series, int n);
int series_copy(struct series *copy, const struct series *series);
void series_free(struct series *series);

/* Keeps what lies within; NAN = no bound.  A bound may be missed by rounding. */
void series_window(struct series *series, double from, double until);

/* Linear in between; NAN outside (but for rounding). */
double series_at(const struct series *series, double x);

/* One number of a series over x, by the trapezoidal rule: RMS, MAX (of the magnitude), MEAN, END, or REACH: the
 * first x at which y crosses `level`, NAN if it never does. */
double series_value(const struct series *series, enum study_norm_kind kind, double level);

/* The norm of a - b at the places of b (RMS, MAX), or the difference of their numbers.  For the former `a` had better
 * reach beyond b: it is interpolated. */
double series_error(const struct series *a, const struct series *b, enum study_norm_kind kind, double level);

#endif
