/* Fields of the points of a snapshot against an exact solution. */
#ifndef TMDEMPM_STUDY_POINTS_H
#define TMDEMPM_STUDY_POINTS_H

#include "study/exact_reference.h"

/* The norm (RMS by volume, MAX) of a field in the snapshot of a run that norm->time names, and of its difference to
 * the exact solution; folder = the run's.  STATUS_INPUT if there is no such snapshot or field. */
int points_norm(const struct exact_reference *exact, const struct study_norm *norm, const char *folder, double *value,
				double *error);

#endif
