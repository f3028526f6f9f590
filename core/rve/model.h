/* Private to rve/: what stands behind struct rve_model. */
#ifndef TMDEMPM_RVE_MODEL_H
#define TMDEMPM_RVE_MODEL_H

#include "rve/packing.h"
#include "rve/rve.h"
#include "rve/state.h"

typedef void rve_kernel(const struct rve_layout *, const struct rve_constants *, const struct rve_call *,
						GLOBAL const real *, GLOBAL unsigned char *, LOCAL unsigned char *, int *);

struct rve_variant {
	real *table;                 /* TABLE_FIELDS disc arrays */
	unsigned char *packed_table; /* packed paths: PACKED_TABLE numbers for each disc and the ghost */
	unsigned char *serial_start; /* the state at birth, as the serial kernel makes it */
	unsigned char *start;        /* the same for this model's path */
	double volume;               /* m3 */
	double solid_area;           /* m2, sum pi r^2 at the reference temperature */
	double void_ratio;
};

struct rve_model {
	struct rve_params params;
	struct rve_layout layout; /* of its states */
	struct rve_layout serial; /* the same on the serial path */
	struct rve_constants constants;
	double diameter; /* m, mean */
	int n_variants, n_threads;
	struct rve_variant *variants;
	rve_kernel *kernel;
	rve_packed_kernel *packed; /* NULL on the serial path */
	unsigned char *scratch;    /* for each thread: the kernel's, then room for one state */
	size_t scratch_stride;
	int kept; /* where in it that room begins */
};

/* Name of the instruction set that the kernel runs on: "base", "v3", "v4".  The best that the processor has;
 * the environment variable TMDEMPM_ISA chooses a lower one (all give the same bits). */
const char *rve_isa(void);

/* Scratch memory of a thread. */
unsigned char *rve_scratch(const struct rve_model *model, int thread);

/* What happens to an RVE in one call. */
struct rve_motion {
	double L[4];                /* 1/s, acts for `duration` */
	double dT;                  /* K, by which the temperature rises */
	double T;                   /* K, absolute, at the end */
	double duration;            /* s */
	const unsigned char *ahead; /* the state that the thread works on next, or NULL */
};

/* What the discs press each other with, Pa. */
double rve_stress_scale(const struct rve_head *head);

/* sub_steps of dt_DEM that share the motion; sub_steps = 0 measures the state.  `rebuild`: the neighbour list is not
 * valid. */
enum rve_kernel_status rve_sub_steps(const struct rve_model *model, void *state, unsigned char *scratch,
									 const struct rve_motion *motion, int sub_steps, int rebuild);

struct rve_outcome {
	enum {
		OUTCOME_OK,
		OUTCOME_RATE,
		OUTCOME_STRAIN,
		OUTCOME_OVERLAP,
		OUTCOME_NAN,
		OUTCOME_CROWDED,
		OUTCOME_JITTER
	} kind;
	double value;
};

/* One RVE of a batch on this thread, as rve_advance() does it. */
struct rve_motion rve_batch_motion(const struct rve_batch *batch, int k);
struct rve_outcome rve_advance_one(const struct rve_model *model, void *state, unsigned char *scratch,
								   struct rve_motion motion);

/* The batch's answers for RVE k; `friction`: its ledger's before the call. */
void rve_answer(const struct rve_model *model, struct rve_batch *batch, int k, const struct rve_head *head,
				double friction);

/* Sets the message of a failure; number = what it calls the RVE. */
int rve_report_failure(const struct rve_params *params, int number, struct rve_outcome outcome);

/* For a kernel that runs elsewhere.  Plain: the call asks for nothing but the kernel (the RVE does not fly, is not frozen
 * nor nearly too slender).  begin: what to call it with; end: what has become of it. */
int rve_is_plain(const struct rve_model *model, const struct rve_head *head, const struct rve_motion *motion);
struct rve_call rve_begin(const struct rve_model *model, struct rve_head *head, const struct rve_motion *motion);
struct rve_outcome rve_end(const struct rve_model *model, struct rve_head *head, int status);

/* From what the serial path keeps to what the model's, a packed one, does. */
void rve_packed_table(const struct rve_model *model, const real *table, unsigned char *packed);
void rve_pack(const struct rve_model *model, const void *serial_state, void *packed_state);

/* What a state of either layout holds. */
double rve_place(const struct rve_layout *layout, const void *state, int row, int axis); /* cell coordinate */
/* What the coordinate has changed by since the list was made. */
double rve_way(const struct rve_layout *layout, const void *state, int row, int axis);
double rve_tangential(const struct rve_layout *layout, const void *state, int slot); /* N */
/* Turns the discs' velocities. */
void rve_rotate_velocities(const struct rve_layout *layout, void *state, const double R[4]);
/* The slot of the pair number `level` that a row owns, -1 if there is none. */
int rve_slot(const struct rve_layout *layout, const void *state, int row, int level);

/* Fills a contact between the discs of slot p and the row that owns it; 0 if they neither touch nor are bonded. */
int rve_inspect_slot(const struct rve_model *model, const unsigned char *state, int row, int p,
					 struct rve_contact *contact);

/* For a state that the kernel does not advance: breaks its bonds if they melt at T (K, absolute). */
void rve_melt_bonds(const struct rve_model *model, void *state, double T);

#endif
