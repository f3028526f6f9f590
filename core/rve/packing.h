/* Packings: the start states of RVEs.  A packing is a pure function of its parameters and seed. */
#ifndef TMDEMPM_RVE_PACKING_H
#define TMDEMPM_RVE_PACKING_H

#include "rve/rve.h"

struct rve_packing {
	double H[4];     /* m, columns are the lattice vectors */
	int n_discs;
	double (*x)[2];  /* m */
	double *r;       /* m */
	int n_contacts;  /* tangential forces; 0 = all start at zero (CSV packings) */
	int (*pair)[4];  /* i < j, image shift of j */
	double *ft;      /* N, on the normal turned by +90 degrees */
	/* how it came about, for info and the file's attributes */
	double pressure, mu, void_ratio, unbalanced;
	unsigned seed;
};

struct rve_packing_params {
	int discs;
	double radius_min, radius_max; /* m */
	double pressure;   /* Pa */
	double mu;         /* during consolidation */
	double void_ratio; /* NAN, or a target: mu by bisection */
	unsigned seed;
	int square_lattice; /* 1: noise-free square lattice, discs a square number, radius_max; compressed to `pressure` */
};

/* Generates: random placement at solid fraction 0.5, servo-controlled isotropic compression (with D_xy)
 * at 1/s to `pressure`, hold until the unbalanced force ratio is below 1e-4.  Serial kernel. */
int rve_packing_generate(struct rve_packing **packing, const struct rve_packing_params *how, const struct rve_params *grains);

/* The same, from the user's cache folder ($XDG_CACHE_HOME or ~/.cache, /tmdempm/packings), keyed by a
 * hash of every parameter; generated and stored when absent.  An unwritable cache is no error. */
int rve_packing_cached(struct rve_packing **packing, const struct rve_packing_params *how, const struct rve_params *grains);

/* .h5 (exact) or .csv (contracts: `# H Hxx Hxy Hyx Hyy`, then id,x,y,r); chosen by the name's end.
 * Errors name file:line.  Written under a temporary name and renamed. */
int rve_packing_read(struct rve_packing **packing, const char *path);
int rve_packing_write(const struct rve_packing *packing, const char *path);

/* Is it a packing in HDF5, by its first words? */
int rve_packing_is(const char *path);

/* Room for a packing, all zero but the two numbers; NULL without memory. */
struct rve_packing *rve_packing_alloc(int discs, int contacts);
void rve_packing_free(struct rve_packing *packing);

/* e = det(H) / sum(pi r^2) - 1 (overlaps not corrected). */
double rve_packing_void_ratio(const struct rve_packing *packing);

#endif
