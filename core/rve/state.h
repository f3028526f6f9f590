/* Private to rve/: how the state of an RVE lies in memory, and what the kernel is told.
 *
 * A state is one block of bytes without pointers: struct rve_head, then arrays whose places are in
 * struct rve_layout.
 *
 * Discs stand in rows.  Each pair belongs to one of its two discs, its i (neighbours_find tells which); rows are
 * sorted by how many pairs a disc owns, so that level l holds the pair number l of the discs in rows 0 .. m_l - 1
 * side by side: the pair of row i lies in slot level_first[l] + i.  A level is filled up to a multiple of ROW_PAD with
 * pairs to the ghost, row n, that touches nothing.  So a sub-step reads and adds up the i side in order, and only the
 * j side through an index: entry[k][row] are the slots whose j the disc is.
 *
 * That is the serial kernel's state.  The packed kernel's (packed.h) has the same head and the same pairs with the same
 * owners, and is smaller: rows come in blocks of LANE_COUNT (8 in double, 16 in single precision), a block has as many
 * levels as the disc in it that owns most, and the pair number l of row i of block k lies in slot
 * (first[k] + l) LANE_COUNT + i % LANE_COUNT.  Missing pairs and missing rows are pairs of and to a ghost; the record of
 * the ghost that pairs point to has the number `stride`.  There are no entries: the j side is added to as it comes.
 * Velocities are displacements in one sub-step.  Single precision: see PACKED_REST_X. */
#ifndef TMDEMPM_RVE_STATE_H
#define TMDEMPM_RVE_STATE_H

#include "rve/dialect.h"

enum { RVE_LEVELS_MAX = 40, RVE_INERTIA_BINS = 12, ROW_PAD = 8 };

/* Arrays over discs: `real` */
enum { DISC_SX, DISC_SY, DISC_VX, DISC_VY, DISC_W, DISC_STATE_FIELDS };
/* and single precision: place at the last list build (cell coordinates), non-affine displacement until then (m),
 * rotation (rad) */
enum { DISC32_REF_X, DISC32_REF_Y, DISC32_UX, DISC32_UY, DISC32_ROTATION, DISC32_FIELDS };
/* Constants of the discs of a packing, in its order: radius at the reference temperature (m), mass (kg), dt/m, dt/I */
enum { TABLE_R, TABLE_MASS, TABLE_DT_MASS, TABLE_DT_INERTIA, TABLE_FIELDS };

/* Arrays over rows of a packed state, of its precision: velocities are displacements in one sub-step (m, rad).  In single
 * precision coordinates are whole numbers, 2^-32 of the cell that wrap around, as are the places at the last list
 * build; REST is what is left of a motion below that (only there). */
enum { PACKED_SX, PACKED_SY, PACKED_VX, PACKED_VY, PACKED_W, PACKED_REST_X, PACKED_REST_Y, PACKED_FIELDS };
/* Records of its table, one for each disc and the ghost: radius, mass, dt^2/m, dt^2/I. */
enum { PACKED_TABLE = 4 };
#define PACKED_GHOST_RADIUS (-1e6)

/* Ledger entries, J of the cell with its z. */
enum {
	LEDGER_WORK,
	LEDGER_ELASTIC,
	LEDGER_KINETIC,
	LEDGER_FRICTION,
	LEDGER_DASHPOT,
	LEDGER_BOND,
	LEDGER_EXPANSION,
	LEDGER_DISCARDED,
	LEDGER_FIELDS
};

/* What becomes of a bond: the values of the state's flags. */
enum { BOND_NONE, BOND_INTACT, BOND_BROKEN };

/* A quiet RVE: what its discs have not gone through yet (quiet.h).  Zeros where calls = 0. */
struct rve_held {
	real motion[4]; /* deformation gradient */
	real heating;   /* K */
	real stress[4]; /* Pa, of the discs as they are */
	real stored;    /* J, booked as elastic meanwhile */
	int64 calls;
};

struct rve_head {
	real H[4];        /* m, columns are the cell vectors a and b */
	real H_ref[4];    /* at the last list build */
	real F[4];        /* macroscopic deformation gradient since birth */
	real temperature; /* K from the reference */
	real scale_ref;   /* radius / reference radius at the last list build */
	real gap;         /* gas and frozen: ln(J / J when it began) */
	/* of the last step */
	real stress[4];      /* Pa */
	real contact_sum[3]; /* J: sum sym(f b), xx yy xy */
	real expansion_sum;  /* J: sum kn overlap (r0_i + r0_j) */
	real conductivity[3], modulus, tensor[6];
	real contacts, sliding, max_overlap, unbalanced, inertial_number;
	real ledger[LEDGER_FIELDS];
	int64 total_sub_steps;
	int levels, entry_levels;
	index16 level_rows[RVE_LEVELS_MAX]; /* m_l */
	index16 level_first[RVE_LEVELS_MAX + 1];
	index16 entry_first[RVE_LEVELS_MAX]; /* rows from here on have entries in level k */
	struct rve_held held;
	int64 quiet_calls, quiet_caught; /* so far: calls in which the discs waited, and caught up */
	real quiet_error_sum, quiet_error_most; /* of the stress / its scale, when they caught up */
	int64 paced_calls, paced_saved;      /* so far: calls with fewer sub-steps than strain_per_step asks for; how many fewer */
	real paced_error_sum, paced_error_most; /* Pa, estimated of the stress in those calls */
	unsigned inertia[RVE_INERTIA_BINS];  /* calls by inertial number */
	int sub_steps, flags, variant, reseeded, rebuilds, clamped;
	int bonds_installed, bonds_intact;
};

/* Sizes and byte offsets, the same for all RVEs of a model. */
struct rve_layout {
	int n;            /* discs */
	int stride;       /* of disc arrays, in entries */
	int pairs;        /* capacity, in slots; also the slot that always holds zero force */
	int pair_stride;  /* of pair arrays, in entries */
	int levels;       /* capacity: most neighbours of one disc */
	int grid;         /* most cells of the neighbour search along one direction */
	int disc, disc32; /* offsets */
	int ft;           /* real: tangential force, N */
	int fd;           /* real32: dashpot force of the last sub-step, N */
	int damping;      /* real32: dashpot coefficient / dt, N/m */
	int pair_j;       /* index16: row */
	int id;           /* index16[stride]: the packing's index of the disc in each row */
	int flag;         /* unsigned char: BOND_NONE ... */
	int entry;        /* index16[levels][stride]; not packed */
	int first;        /* packed only: index16[stride / LANE_COUNT + 1], a block's first level */
	int lanes;        /* packed only: rows of a block */
	int single;       /* packed only: in single precision */
	int bytes;        /* of a state, a multiple of 64 */
	int scratch;      /* bytes of a block's scratch memory */
};

/* Constants of a model. */
struct rve_constants {
	real kn, ks, mu; /* N/m, N/m, - */
	real expansion;  /* 1/K */
	real resistance; /* K/(W m) */
	real thickness;  /* m */
	real dt;         /* s, dt_DEM */
	real r_max;      /* m */
	real skin;       /* m */
	real damping;    /* 2 zeta sqrt(kn) / dt */
	/* a bond bears bond_force (r_i + r_j) = beta_s kn R in tension, bond_mu times that in shear (eqs. 38 to 40) */
	real bond_force;   /* N/m, beta_s kn / 2 */
	real bond_mu;      /* - */
	real bond_melting; /* K: above it nothing holds */
	real bond_slope;   /* 1/K, of the linear law: the share (T_c - T) slope of the force, at most 1; 0 = all of it */
};

/* One call for one RVE. */
struct rve_call {
	int sub_steps;    /* 0: only measure the state as it is */
	int rebuild;      /* 1: the neighbour list is not valid (a new state) */
	real A[4];        /* exp(L dt / sub_steps): moves the cell */
	real B[4];        /* R - D dt/sub_steps, R = exp(W dt / sub_steps): moves fluctuation velocities */
	real D[3];        /* strain of one sub-step, xx yy xy */
	real heating;     /* K in one sub-step */
	real temperature; /* K, absolute, before the first one: what bonds melt at */
};

enum rve_kernel_status { KERNEL_OK, KERNEL_SLENDER, KERNEL_CROWDED };

#ifdef RVE_HOST

/* Advances one RVE.  Unless the status is KERNEL_OK, the state is neither the old one nor a new one: a caller that goes
 * on from there has kept a copy.  `table` = TABLE_FIELDS disc arrays. */
void rve_kernel_base(const struct rve_layout *layout, const struct rve_constants *constants,
					 const struct rve_call *call, GLOBAL const real *table, GLOBAL unsigned char *state,
					 LOCAL unsigned char *scratch, int *status);
void rve_kernel_v3(const struct rve_layout *layout, const struct rve_constants *constants, const struct rve_call *call,
				   GLOBAL const real *table, GLOBAL unsigned char *state, LOCAL unsigned char *scratch, int *status);
void rve_kernel_v4(const struct rve_layout *layout, const struct rve_constants *constants, const struct rve_call *call,
				   GLOBAL const real *table, GLOBAL unsigned char *state, LOCAL unsigned char *scratch, int *status);

/* Bytes of scratch memory that a block needs. */
int rve_kernel_scratch_bytes(const struct rve_layout *layout);

/* The packed kernel in double and in single precision; `table`: PACKED_TABLE numbers of that precision for each disc
 * and the ghost; `ahead`: the state that comes next, fetched from memory meanwhile, or NULL. */
typedef void rve_packed_kernel(const struct rve_layout *layout, const struct rve_constants *constants,
							   const struct rve_call *call, GLOBAL const void *table, GLOBAL unsigned char *state,
							   GLOBAL const unsigned char *ahead, LOCAL unsigned char *scratch, int *status);
rve_packed_kernel rve_packed64_base, rve_packed64_v3, rve_packed64_v4;
rve_packed_kernel rve_packed32_base, rve_packed32_v3, rve_packed32_v4;

/* Operations of `rounds` rounds of arithmetic in double precision: peak.h. */
typedef double rve_peak_kernel(int rounds, double *sum);
rve_peak_kernel rve_peak64_base, rve_peak64_v3, rve_peak64_v4;

int rve_packed64_scratch(const struct rve_layout *layout);
int rve_packed32_scratch(const struct rve_layout *layout);

#endif

#endif
