/* The RVE kernel: one text for every target (dialect.h).
 *
 * A periodic cell of discs follows the macroscopic deformation; discs move in addition by their
 * fluctuation velocity v, and the stress is what the contacts carry (TM-DEMPM sections 3.1 to 3.4).
 *
 *   cell           H <- A H                                     A = exp(L dt / N)
 *   coordinates    x = H s,  ds/dt = H^-1 v
 *   fluctuation    dv/dt = f/m + W v - D v                      (objective: a rotation only rotates v)
 *   contact        du = (v_j - v_i) dt + D b - spins;  W never enters
 *                  f_n = max(0, kn delta - c du_n),  f_t <- clip(f_t - ks du_t, mu f_n)
 *   stress         sigma = -(1/V) sym(sum f b + sum m v v),     eqs. 31 and 33
 *   conductivity   k = 1/(kappa V) sum l l / |l|,               eq. 34
 *   elasticity     D = (1/V) sum (kn n l n l + ks t l t l),     eq. 58
 *   bond           f_n = kn delta - c du_n of either sign, f_t <- f_t - ks du_t, until -kn delta > F or
 *                  |f_t| > mu_b F with F = beta(T) kn R,        eqs. 38 to 40
 *
 * The force on j is f_n n + f_t t with n from i to j and t = n turned by +90 degrees.  A sub-step moves the
 * cell and the discs, finds the forces there, and kicks: a state holds positions at a time and velocities
 * half a sub-step later, and the stress is that of its positions. */
#ifndef TMDEMPM_RVE_KERNEL_H
#define TMDEMPM_RVE_KERNEL_H

#include "rve/kernel_common.h"

/* Scratch arrays: over rows, over slots (where contact forces are left for j), whole numbers. */
enum {
	WORK_SX,
	WORK_SY,
	WORK_VX,
	WORK_VY,
	WORK_W,
	WORK_ROTATION,
	WORK_FX,
	WORK_FY,
	WORK_TORQUE,
	WORK_R,
	WORK_MASS,
	WORK_DT_MASS,
	WORK_DT_INERTIA,
	WORK_ROW_FIELDS
};
enum { WORK_FT, WORK_PX, WORK_PY, WORK_TJ, WORK_BOND, WORK_PAIR_FIELDS }; /* WORK_BOND: of a cell with bonds only */
enum { WORK_J, WORK_J_OLD, WORK_PAIR_INDICES };
enum {
	WORK_ID,
	WORK_CELL,
	WORK_SORTED,
	WORK_DEGREE,
	WORK_ROW_INDICES,
};
enum { ID_ROW, ID_ROW_OLD, ID_OWNED, ID_OTHERS, ID_INDICES }; /* over discs in the packing's order */
enum { RIM_X, RIM_Y, RIM_R, RIM_FIELDS }; /* neighbour search: discs and their images around the cell, at most 4 n */

/* What a block shares. */
struct rve_block {
	real lanes[LANE_FIELDS][LANES];
	struct rve_head head;
	real H_inv[4], drift[4];  /* drift: H^-1 dt before the sub-step's motion */
	real scale, scale_step; /* radius / reference radius, its increase in one sub-step */
	real bond_temperature;  /* K, absolute */
	real bond_force;        /* N/m: what a bond bears now / (r_i + r_j) */
	int grid[2], status;
	int levels_old;
	index16 level_rows_old[RVE_LEVELS_MAX], level_first_old[RVE_LEVELS_MAX];
};

/* Where things are. */
struct rve_place {
	SHARED const struct rve_layout *layout;
	SHARED const struct rve_constants *constants;
	SHARED const struct rve_call *call;
	GLOBAL const real *table;
	GLOBAL struct rve_head *head;
	GLOBAL unsigned char *state;
	SHARED struct rve_block *block;
	LOCAL real *row, *pair, *rim;
	LOCAL int *pair_index, *row_index, *id_index, *entry, *rim_id, *cell_start, *rim_start, *key_start;
	LOCAL index16 *neighbours; /* layout->levels + 1 for each disc */
};

#define WORK_ROW(f) (at->row + (f)*at->layout->stride)
#define WORK_PAIR(f) (at->pair + (f)*at->layout->pair_stride)
#define WORK_PAIR_INDEX(f) (at->pair_index + (f)*at->layout->pair_stride)
#define WORK_ROW_INDEX(f) (at->row_index + (f)*at->layout->stride)
#define WORK_ID_INDEX(f) (at->id_index + (f)*at->layout->stride)
#define WORK_ENTRY(level) (at->entry + (level)*at->layout->stride)
#define TABLE(f) (at->table + (f)*at->layout->stride)
#define STATE_DISC(f) ((GLOBAL real *)(at->state + at->layout->disc) + (f)*at->layout->stride)
#define STATE_DISC32(f) ((GLOBAL real32 *)(at->state + at->layout->disc32) + (f)*at->layout->stride)
#define STATE_FT ((GLOBAL real *)(at->state + at->layout->ft))
#define STATE_FD ((GLOBAL real32 *)(at->state + at->layout->fd))
#define STATE_DAMPING ((GLOBAL real32 *)(at->state + at->layout->damping))
#define STATE_J ((GLOBAL index16 *)(at->state + at->layout->pair_j))
#define STATE_ID ((GLOBAL index16 *)(at->state + at->layout->id))
#define STATE_FLAG (at->state + at->layout->flag)
#define STATE_ENTRY(level) ((GLOBAL index16 *)(at->state + at->layout->entry) + (level)*at->layout->stride)

#include "rve/kernel_bonds.h"
#include "rve/kernel_neighbours.h"
#include "rve/kernel_step.h"

BLOCKFN void head_load(SHARED const struct rve_place *at)
{
	SHARED struct rve_block *block = at->block;
	ONE_THREAD
	{
		block->head = *at->head;
		block->status = KERNEL_OK;
		block->scale = 1.0 + at->constants->expansion * block->head.temperature;
		block->scale_step = at->constants->expansion * at->call->heating;
		block->bond_temperature = at->call->temperature;
		bonds_soften(at);
		cell_invert(block->head.H, block->H_inv);
	}
}

BLOCKFN void state_load(SHARED const struct rve_place *at)
{
	SHARED struct rve_block *block = at->block;
	for (int f = 0; f < DISC_STATE_FIELDS; f++)
		FOR_THREADS(i, at->layout->stride) WORK_ROW(f)[i] = STATE_DISC(f)[i];
	FOR_THREADS(i, at->layout->stride)
	{
		WORK_ROW_INDEX(WORK_ID)[i] = STATE_ID[i];
		WORK_ROW(WORK_ROTATION)[i] = 0.0;
	}
	const int slots = block->head.level_first[block->head.levels];
	FOR_THREADS(p, slots)
	{
		WORK_PAIR(WORK_FT)[p] = STATE_FT[p];
		WORK_PAIR_INDEX(WORK_J)[p] = STATE_J[p];
	}
	bonds_load(at);
	for (int level = 0; level < block->head.entry_levels; level++) {
		const int first = block->head.entry_first[level];
		FOR_THREADS_FROM(i, first, at->layout->n) WORK_ENTRY(level)[i] = STATE_ENTRY(level)[i];
	}
	for (int q = 0; q < LANE_FIELDS; q++)
		FOR_THREADS(lane, LANES) block->lanes[q][lane] = 0.0;
	slots_clear(at);
	rows_load(at);
}

BLOCKFN void state_store(SHARED const struct rve_place *at)
{
	for (int f = 0; f < DISC_STATE_FIELDS; f++)
		FOR_THREADS(i, at->layout->n) STATE_DISC(f)[i] = WORK_ROW(f)[i];
	FOR_THREADS(i, at->layout->n) STATE_DISC32(DISC32_ROTATION)[i] += (real32)WORK_ROW(WORK_ROTATION)[i];
	const int slots = at->block->head.level_first[at->block->head.levels];
	FOR_THREADS(p, slots) STATE_FT[p] = WORK_PAIR(WORK_FT)[p];
	bonds_store(at);
	ONE_THREAD *at->head = at->block->head;
}

#define FINE (block->status == KERNEL_OK)

/* Where the arrays of scratch memory are: layout->scratch bytes less those of a block, 64-byte aligned. */
THREADFN void place_scratch(SHARED struct rve_place *place, LOCAL unsigned char *scratch)
{
	SHARED const struct rve_layout *layout = place->layout;
	place->row = (LOCAL real *)scratch;
	place->pair = place->row + WORK_ROW_FIELDS * layout->stride;
	place->rim = place->pair + WORK_PAIR_FIELDS * layout->pair_stride;
	place->pair_index = (LOCAL int *)(place->rim + RIM_FIELDS * 4 * layout->stride);
	place->row_index = place->pair_index + WORK_PAIR_INDICES * layout->pair_stride;
	place->id_index = place->row_index + WORK_ROW_INDICES * layout->stride;
	place->entry = place->id_index + ID_INDICES * layout->stride;
	place->rim_id = place->entry + layout->levels * layout->stride;
	place->cell_start = place->rim_id + 4 * layout->stride;
	place->rim_start = place->cell_start + layout->grid * layout->grid + 1;
	place->key_start = place->rim_start + (layout->grid + 2) * (layout->grid + 2) + 1;
	place->neighbours = (LOCAL index16 *)(place->key_start + (layout->levels + 1) * (layout->levels + 1) + 1);
}

/* One RVE, call->sub_steps sub-steps. */
BLOCKFN void block_advance(SHARED const struct rve_place *at, GLOBAL int *status)
{
	SHARED const struct rve_call *call = at->call;
	SHARED struct rve_block *block = at->block;

	PHASE(head_load(at));
	PHASE(state_load(at));
	const int bonded = block->head.bonds_intact > 0; /* those that have all lost theirs are as if they had had none */
	/* turn -1: the state as it is gets its first list, or is only measured */
	for (int k = call->rebuild || call->sub_steps == 0 ? -1 : 0; k < call->sub_steps && FINE; k++) {
		const int moves = k >= 0;
		PHASE(if (moves) cell_move(at));
		PHASE(if (moves) discs_move(at));
		PHASE(if (moves) displacements_fold(at));
		if (moves ? !neighbours_valid(at) : call->rebuild) {
			PHASE(if (bonded && moves) bonds_tear(at));
			PHASE(history_keep(at), discs_rebase(at));
			PHASE(cell_rebase(at));
			PHASE(discs_bin(at));
			PHASE(if (FINE) discs_sort(at));
			PHASE(if (FINE) rim_fill(at));
			PHASE(if (FINE) neighbours_find(at));
			PHASE(rows_sort(at));
			PHASE(if (FINE) rows_leave(at));
			PHASE(if (FINE) rows_enter(at));
			PHASE(if (FINE) pairs_write(at));
			PHASE(if (FINE) entries_collect(at));
			PHASE(if (FINE) entries_write(at), slots_clear(at));
		}
		const int forces = moves || call->sub_steps == 0;
		PHASE(if (forces && FINE) contacts(at, k + 1 == call->sub_steps, bonded));
		PHASE(if (forces && FINE) gather(at), kick(at, moves));
	}
	PHASE(if (FINE) discs_measure(at));
	for (int width = LANES / 2; width > 0; width /= 2)
		PHASE(lanes_halve(at, width));
	PHASE(if (FINE) homogenise(at), state_store(at));
	ONE_THREAD *status = block->status;
}

#ifdef RVE_HOST

KERNEL(rve_kernel)
(const struct rve_layout *layout, const struct rve_constants *constants, const struct rve_call *call,
 GLOBAL const real *table, GLOBAL unsigned char *state, LOCAL unsigned char *scratch, int *status)
{
	struct rve_block *block = (struct rve_block *)(void *)scratch;
	struct rve_place place = {.layout = layout,
							  .constants = constants,
							  .call = call,
							  .table = table,
							  .head = (struct rve_head *)(void *)state,
							  .state = state,
							  .block = block};
	place_scratch(&place, scratch + sizeof *block);
	block_advance(&place, status);
}

/* Bytes of scratch memory that the kernel needs. */
static inline int kernel_scratch_bytes(const struct rve_layout *layout)
{
	const long row = layout->stride, pair = layout->pair_stride, grid = layout->grid, keys = layout->levels + 1;
	long bytes = (long)sizeof(struct rve_block);
	bytes += (long)sizeof(real) * (WORK_ROW_FIELDS * row + WORK_PAIR_FIELDS * pair + RIM_FIELDS * 4 * row);
	bytes +=
		(long)sizeof(int) * (WORK_PAIR_INDICES * pair + (WORK_ROW_INDICES + ID_INDICES + layout->levels + 4) * row);
	bytes += (long)sizeof(int) * (grid * grid + 1 + (grid + 2) * (grid + 2) + 1 + keys * keys + 1);
	bytes += (long)sizeof(index16) * (layout->levels + 1) * layout->n;
	return (int)((bytes + 63) / 64 * 64);
}

#endif

#endif
