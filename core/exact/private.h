/* What the files of core/exact share. */
#ifndef TMDEMPM_EXACT_PRIVATE_H
#define TMDEMPM_EXACT_PRIVATE_H

#include "exact/exact.h"

#define EXACT_BIT(field) (1u << (field))
#define EXACT_PARAMETERS(table) .parameters = table, .n_parameters = sizeof(table) / sizeof *(table)

/* (4/pi) sum exp(-(2m+1)^2 pi^2 F) sin((2m+1) pi x) / (2m+1): what is left after the Fourier number F = a t / L^2 of
 * 1 in (0, 1) with 0 on the ends; 0 <= x <= 1. */
double exact_slab(double x, double fourier);

/* exp(x^2) erfc(x) */
double exact_erfcx(double x);

#endif
