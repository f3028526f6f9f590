/* The exact solution that a study names, with its parameters as a combination has them. */
#ifndef TMDEMPM_STUDY_EXACT_REFERENCE_H
#define TMDEMPM_STUDY_EXACT_REFERENCE_H

#include "exact/exact.h"
#include "study/private.h"

struct exact_reference {
	const struct exact_solution *solution;
	double parameters[EXACT_PARAMETERS_MAX];
};

/* STATUS_INPUT if there is no such solution or parameter. */
int exact_reference_get(struct exact_reference *reference, const struct study *study, const int *choice);

/* An expression of fields of the solution at a place and a time; STATUS_INPUT if one is not known. */
int exact_reference_value(const struct exact_reference *reference, const char *expression, const double X[2], double t,
						  double *value);

#endif
