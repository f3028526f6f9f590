/* Material points, structure of arrays.  Index = storage order, which is sorted by grid cell from time
 * to time; `id` is for life.  All in SI units and kelvin. */
#ifndef TMDEMPM_MPM_PARTICLES_H
#define TMDEMPM_MPM_PARTICLES_H

#include <stdbool.h>
#include <stddef.h>

#include "base/field.h"
#include "scene/scene.h"

struct particles {
	int n;
	int *id;            /* 0 .. n-1 in the order of birth */
	int *body;          /* index into the scene's bodies */
	int *material;      /* index into the scene's materials */
	int *law;           /* index into mpm->laws */
	int *slot;          /* state of that law */
	double (*x)[2];     /* m */
	double (*x0)[2];    /* m, at birth */
	double (*v)[2];     /* m/s */
	double (*F)[4];     /* deformation gradient, row-major */
	double (*L)[4];     /* velocity gradient of the last step, 1/s */
	double *mass;       /* kg (with the grid's thickness) */
	double *volume0;    /* m3 at birth; now: det(F) volume0 */
	double (*stress)[4];/* Pa: xx yy zz xy */
	double *modulus;    /* P-wave modulus, Pa */
	double *damage;     /* 0 whole .. 1 broken; NULL unless some law of the scene breaks */
	double *T;          /* K, carried by increments (eq. 28) */
	double *T_smooth;   /* K, remapped (eq. 29), input of the law only */
	double *dT;         /* K, the increment of T_smooth that the law saw in the last step */
	double *heat;       /* W/m3, from the law */
	double (*conductivity)[3]; /* W/(m K): xx yy xy */
	double *capacity;   /* J/(kg K), sensible */
	double *thawed;     /* share of the point's mass that is not frozen; 1 where nothing freezes */
	double *heat_pending; /* J, heat of the law that waits for the next thermal step */
	double (*affine)[4]; /* APIC: B of its affine motion, m2/s, or C, 1/s (mpm/point.h); else NULL */
	double (*damage_gradient)[2]; /* 1/m, of the smoothed damage, at the last look; NULL without contacts or damage */
	double *contact_pressure; /* Pa, in the last step; NULL without contacts and penalty walls */
	double *heat_friction_sum; /* J/m3 of initial volume, heat received from the law so far */
	double *growth;     /* ln of its stress's growth while the step is above its limit: see limit.c */
};

/* Fields of the points themselves (a law adds its own): velocity, displacement, stress, strain,
 * deviatoric strain, temperature, heat source, density ... */
extern const struct field particle_fields[];
extern const int particle_fields_count;

/* Has field f a meaning in this scene? */
bool particle_field_applies(const struct scene *scene, int f);

struct mpm;

/* Field f of all points in storage order into out[n * components]; temperatures in K. */
void particle_field_get(const struct mpm *mpm, int f, double *out);

#endif
