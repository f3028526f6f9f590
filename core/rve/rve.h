/* The representative volume: a periodic cell of ~400 discs that is the constitutive law of a point.
 *
 * An RVE's state is plain data of a fixed size (rve_state_bytes), without pointers.  rve_advance() is
 * the one hot function.  Equations and decisions: TM-DEMPM sections 3 and 4; see kernel.h.
 * Stress is tension-positive, (xx, yy, zz, xy) in Pa; L is row-major, 1/s. */
#ifndef TMDEMPM_RVE_RVE_H
#define TMDEMPM_RVE_RVE_H

#include <stddef.h>

struct rve_packing; /* packing.h */
struct rve_pool;    /* pool.h: where states are computed */
struct rve_model;   /* parameters and start packings of all RVEs of one law; read-only once made */

/* How RVEs are computed.  Serial is the reference; the others have their own states and, each, their own bits. */
enum rve_code_path {
	RVE_SERIAL,     /* double precision: kernel.h */
	RVE_SIMD,       /* double precision in short vectors: packed.h */
	RVE_SIMD_SINGLE /* the same in single precision */
};

/* "serial", "simd", "single"; and back, -1 for another name. */
const char *rve_path_name(int path);
int rve_path_number(const char *name);

struct rve_params {
	int path;               /* enum rve_code_path; packings are made with RVE_SERIAL whatever it is */
	double kn, ks;          /* N/m */
	double mu;              /* - */
	double damping_ratio;   /* zeta of the normal dashpot */
	double grain_density;   /* kg/m3 */
	double thickness;       /* z, m */
	double expansion;       /* beta, 1/K, eq. 37 */
	double resistance;      /* kappa, K/(W m), eq. 34 */
	double step_factor;     /* dt_DEM / sqrt(m_min/kn) */
	double strain_per_step; /* deps_max at 100 kPa */
	int pressure_scaling;   /* deps = deps_max min(1, sqrt(p/100 kPa)), not below deps_max/10 */
	int n_max;              /* most sub-steps in one call; 0 = no clamp */
	double skin;            /* Verlet skin / r_max */
	int gas;                /* gas state on */
	double gas_pressure;    /* Pa */
	double gas_stretch;     /* J / J_ref */
	double bond_strength;   /* beta_s: a bond bears beta_s kn R, R the mean radius of its discs; 0 = no bonds; below skin */
	double bond_mu;         /* mu_b: and mu_b times that in shear */
	double bond_melting;    /* T_c, K: above it every bond breaks; INFINITY = never */
	double bond_reference;  /* K: beta falls linearly from beta_s here to 0 at T_c; NAN: it is beta_s up to T_c */
	int step_guard;         /* guard: a step above its limit is refused, and discs that jitter in it stop the run; 1 */
	double pace_stress;     /* Pa: error of the stress that longer sub-steps may cause; 0 = none */
	double pace_calm;       /* sub-steps this many times as long where the contacts are calm; 1 = off */
	double pace_unbalanced; /* calm: unbalanced force below this */
	double pace_sliding;    /* and a share of sliding contacts below this */
	double quiet_change;    /* quiet RVEs wait until the stress would have changed by this share; 0 = none waits */
	double quiet_strain;    /* and at most by this strain */
	double quiet_unbalanced; /* and only where the unbalanced force is below this */
	double overlap_max;     /* guard: largest overlap / smaller radius; at 0.5 a small disc is half-way to being passed through */
};

/* TM-DEMPM table 1 and the decisions of the design. */
void rve_params_default(struct rve_params *params);

/* The largest step_factor that is safe for these stiffnesses and this damping: below what was measured by walking past
 * it in dense packings (tests/stability/test_rve_step.c).  The stiffest motion is the rolling of the smallest disc on
 * the tangential springs, 0.56 sqrt(kn/ks), or a damped push along the normals, 0.7 (sqrt(1 + zeta^2) - zeta). */
double rve_step_factor_limit(const struct rve_params *params);

/* STATUS_INPUT if the step is above that limit and the guard is on. */
int rve_params_check(const struct rve_params *params);

/* A model from n packings of equal disc count (variants).  Copies what it needs. */
int rve_model_create(struct rve_model **model, const struct rve_params *params, int n, const struct rve_packing *const *packings);
void rve_model_free(struct rve_model *model);

size_t rve_state_bytes(const struct rve_model *model);
int rve_discs(const struct rve_model *model);
int rve_variants(const struct rve_model *model); /* packings that it is made of */
const char *rve_path(const struct rve_model *model); /* rve_path_name() of its own */
double rve_void_ratio(const struct rve_model *model, int variant); /* of the start packing */

/* A hash of the start packings (radii and states at birth): states go on with the packings they began with only. */
unsigned long long rve_packings_hash(const struct rve_model *model);
double rve_time_step(const struct rve_model *model);               /* dt_DEM, s */

/* Puts the start state of packing `variant` into `state` (64-byte aligned, rve_state_bytes). */
int rve_init(const struct rve_model *model, int variant, void *state);

/* The n states at `states` as states of a model that differs from theirs in its path only, at `converted` (64-byte
 * aligned).  What a path does not keep (single precision) is rounded; to and fro, states of a path keep what they
 * hold but not their bits.  STATUS_INPUT: an RVE is too crowded for the other path; STATUS_RESOURCE: no memory. */
int rve_convert(const struct rve_model *model, int n, const unsigned char *states, const struct rve_model *to,
				unsigned char *converted);

struct rve_batch {
	int n;
	unsigned char *states; /* base; state k begins at states + slot[k] * rve_state_bytes */
	const int *slot;       /* NULL = 0, 1, 2 ... */
	const int *number;     /* what messages call RVE k; NULL = k */
	const double (*L)[4];  /* 1/s */
	const double *dT;      /* temperature increment of this call, K */
	const double *T;       /* absolute temperature at its end, K, at which bonds melt; NULL = they do not */
	struct rve_pool *pool; /* devices that share the states; NULL = this processor alone */
	double dt;             /* macroscopic duration, s: exp(L dt) is applied over N sub-steps of dt_DEM */
	double (*stress)[4];       /* out */
	double *heat;              /* out: friction heat, W/m3 of current volume */
	double (*conductivity)[3]; /* out: xx yy xy, W/(m K) */
	double *modulus;           /* out: P-wave modulus from the affine elastic tensor, Pa */
	int failed;                /* out: lowest k that failed, or -1 */
};

/* Advances every RVE of the batch (OpenMP, dynamic).  The bits depend on nothing but the states and
 * the batch.  STATUS_GUARD (overlap, NaN) names the RVE in the message and sets batch->failed. */
int rve_advance(const struct rve_model *model, struct rve_batch *batch);

/* For benchmarks: `rounds` rounds of arithmetic as fast as the kernels' vectors can do it; how many operations these
 * were.  Adds what comes out to *sum. */
double rve_peak(int rounds, double *sum);

/* Bonds all contacts that carry force (eqs. 38 to 40); bonds that are there stay.  Changes no force.  An RVE that flies
 * or is frozen gets none, nor does any if bond_strength = 0. */
void rve_install_bonds(const struct rve_model *model, void *state);

/* Stress, conductivity and modulus of a state as it is. */
void rve_evaluate(const struct rve_model *model, const void *state, double stress[4], double conductivity[3], double *modulus);

/* Scalars of one state. */
enum rve_flag { RVE_GAS = 1, RVE_FROZEN = 2 };

struct rve_info {
	double H[4];         /* m, columns are the lattice vectors */
	double volume;       /* m3, det(H) z */
	double volume0;      /* m3, of the start packing */
	double F[4];         /* accumulated deformation gradient */
	double temperature;  /* K, change from the reference */
	double void_ratio;
	double coordination; /* 2 contacts / discs */
	double sliding_fraction; /* contacts at the Coulomb limit in the last sub-step */
	int bonds_installed, bonds_intact;
	double bond_fraction;    /* intact / installed; 0 without bonds */
	double pressure;         /* Pa */
	double max_overlap;      /* overlap / smaller radius */
	double elastic_tensor[6]; /* affine: xxxx yyyy xxyy xyxy xxxy yyxy, Pa (eq. 58) */
	int n_contacts;
	int sub_steps;       /* of the last advance */
	double inertial_number;
	double unbalanced;   /* mean net force on a disc / mean normal force */
	unsigned inertia[12]; /* calls so far by inertial number: < 1e-6, then 2 bins a decade, > 1e-1 */
	int flags;           /* enum rve_flag */
	int variant;
	int reseeded, rebuilds, clamped; /* so far */
	long long total_sub_steps;
	/* quiet RVEs: calls so far in which the discs waited and in which they caught up; the error of the stress then,
	 * relative, summed over those and the largest; calls that they have waited now, whose motion H and the discs lack */
	long long quiet_calls, quiet_caught, quiet_waiting;
	double quiet_error_sum, quiet_error_most;
	/* calls so far that had fewer sub-steps than strain_per_step asks for, how many fewer in all; the estimated error of
	 * the stress in them, Pa, summed over the calls and the largest */
	long long paced_calls, paced_saved;
	double paced_error_sum, paced_error_most;
	/* ledgers, J of the cell with its z, since birth or reset; work begins as the energy stored then, so that
	 * work = elastic + kinetic + friction + dashpot + bond + discarded - expansion */
	double work, elastic, kinetic, friction, dashpot, bond, expansion, discarded;
};

void rve_get_info(const struct rve_model *model, const void *state, struct rve_info *info);
void rve_reset_ledger(const struct rve_model *model, void *state);

/* For pictures and files.  Positions are absolute, m, discs wrapped into the cell. */
struct rve_disc {
	double x, y, radius;
	double displacement[2]; /* non-affine, since the start packing, m; without the cell's motion */
	double rotation;        /* rad, relative to the macroscopic spin */
	int contacts;
};

struct rve_contact {
	int i, j;              /* discs */
	int shift[2];          /* j's image: x_j + H shift touches i */
	double ends[2][2];     /* m: centre of i, centre of j's image */
	double normal_force;   /* N, compression positive; only bonds pull */
	double tangential_force; /* N */
	double mobilisation;   /* |f_t| / (mu f_n), 0..1; of an intact bond its load / the strength below T_c */
	int sliding, bond;     /* bond: 0 none, 1 intact, 2 broken */
};

/* Fills discs[rve_discs()] and at most `capacity` contacts; returns the number of contacts.
 * Either pointer may be NULL. */
int rve_inspect(const struct rve_model *model, const void *state, struct rve_disc *discs, struct rve_contact *contacts, int capacity);
int rve_contact_capacity(const struct rve_model *model);

/* The broken bonds whose discs have parted but are neighbours still, as contacts without force; those that are farther
 * apart than the skin are forgotten. */
int rve_inspect_parted(const struct rve_model *model, const void *state, struct rve_contact *contacts, int capacity);

#endif
