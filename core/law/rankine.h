/* Parameters and state of the law that breaks (neohookean_rankine.c), shared with its kernel. */
#ifndef TMDEMPM_LAW_RANKINE_H
#define TMDEMPM_LAW_RANKINE_H

#include <math.h>
#include <stdbool.h>

struct rankine_model {
	double K, G;     /* Pa */
	double coupling; /* 3 alpha, 1/K */
	double young;    /* Pa */
	double energy;   /* J/m2 */
	double cell;     /* m */
	double heat_share;
	bool unilateral, projected;
	const struct law_kernel *kernel;
};

struct rankine_state {
	double warming;   /* K from the reference */
	double J;         /* det F of the last step */
	double strength;  /* Pa */
	double R;         /* Pa, at least the strength */
	double softening; /* H */
	double damage;
	double psi;       /* J/m3, of psi0 what damage takes */
	double entropy;   /* Pa/K, 3 alpha (1 - d) U' */
	double elastic;   /* J/m3: psi */
	double fracture;  /* J/m3, taken by damage so far */
	double expansion; /* J/m3, put in by thermal expansion so far */
	double began;     /* 1: damage has begun, the band's width is set */
};

/* H of a band of width l; infinite where it would snap back. */
static inline double rankine_softening(const struct rankine_model *m, double strength, double l)
{
	double brittle = strength * strength * l / (2.0 * m->young * m->energy);
	return brittle < 1.0 ? brittle / (1.0 - brittle) : INFINITY;
}

/* Width of the band that a crack with normal (c, s) makes, m. */
static inline double rankine_band_width(const struct rankine_model *m, double c, double s)
{
	return m->projected ? m->cell * (fabs(c) + fabs(s)) : M_SQRT2 * m->cell;
}

#endif
