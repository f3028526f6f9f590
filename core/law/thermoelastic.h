/* Parameters and state of the thermoelastic law (thermoelastic.c), shared with its kernel. */
#ifndef TMDEMPM_LAW_THERMOELASTIC_H
#define TMDEMPM_LAW_THERMOELASTIC_H

#include <stdbool.h>

struct thermoelastic_model {
	double lambda, mu;   /* Pa, in the plane */
	double lambda_zz;    /* Pa, sigma_zz by tr(h): lambda, or 0 in plane stress */
	double thermal;      /* Pa/K, in the plane */
	double thermal_zz;   /* Pa/K, out of it */
	double expansion;    /* 1/K */
	double expansion_zz; /* 1/K of elastic strain out of the plane: -alpha where it is held, 0 where it is free */
	double lambda_3d;    /* Pa */
	double modulus;      /* Pa, P-wave at rest */
	bool neo_hookean;
	const struct law_kernel *kernel;
};

/* Logarithms of the principal stretches between which the energy in ln V is rank-one convex. */
#define HENCKY_LEAST -1.5530
#define HENCKY_MOST (1.0 / 3.0)

struct thermoelastic_state {
	double warming;   /* K since birth */
	double pressure;  /* Pa, tr(tau) of the last step: works on thermal expansion */
	double elastic;   /* J/m3 */
	double expansion; /* J/m3 */
};

#endif
