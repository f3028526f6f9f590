/* The packed RVE kernel: the physics of kernel.h on states that are worked on in place, in short vectors (vector.h).
 *
 * The serial kernel is its oracle; kernel.h has the equations.  What differs is how the work is laid out (state.h has
 * the layout) and the order of sums:
 *
 *  - The contacts of LANE_COUNT discs are one block: the discs' own side is added up in registers, the other side goes
 *    disc by disc into the records of forces, in the order of the list.  Sums over contacts and discs are kept for each
 *    lane and added up in a fixed tree.  So nothing depends on the width of the processor's vectors.
 *  - Velocities are displacements in one sub-step, m and rad: the factor dt is in the tables.
 *  - A block of pairs of which none touches, nor did before, ends after its distances.
 *  - The kick of a sub-step and the motion of the next one are one pass over the discs.
 *
 * In single precision (RVE_FLOAT) coordinates are whole numbers that wrap around, in 2^-32 of the cell, and what is
 * less than that is carried on in `rest`: a plain single would lose steps of 1e-9.  The cell and all totals are double.
 */
#ifndef TMDEMPM_RVE_PACKED_H
#define TMDEMPM_RVE_PACKED_H

#include "rve/kernel_cell.h"
#include "rve/kernel_common.h"
#include "rve/vector.h"

/* Sums that a block keeps in registers, for each lane. */
struct packed_sums {
	vec of[LANE_TOTALS][BLOCK_PARTS];
};

struct packed_place {
	const struct rve_layout *layout;
	const struct rve_constants *constants;
	const struct rve_call *call;
	const num *table; /* records of PACKED_TABLE numbers, in the packing's order */
	unsigned char *state;
	const unsigned char *ahead;
	struct rve_head *head;
	double H_inv[4], scale, scale_step, bond_temperature, bond_force;
	double displacement, second; /* m: the two largest non-affine ways since the list was made */
	double lanes[LANE_TOTALS][LANE_COUNT];
	/* state */
	coord *sx, *sy;
	num *vx, *vy, *w, *rest_x, *rest_y;
	real32 *ref_x, *ref_y, *ux, *uy, *turned;
	num *ft;
	real32 *fd, *damping;
	index16 *pair_j, *id, *first;
	unsigned char *flag;
	/* scratch */
	num *r, *mass, *step_mass, *step_inertia, *rotation; /* of the rows */
	num *own;                                            /* forces x, y and torques from the pairs that a row owns */
	num *record, *velocity, *force;
	uint32_t *offset;    /* of the pairs: bytes to the velocity of the other disc */
	unsigned char *free; /* the rest of it: for the neighbour search */
};

#include "rve/packed_neighbours.h"
#include "rve/packed_step.h"

static inline void packed_open(struct packed_place *at, unsigned char *scratch)
{
	const struct rve_layout *layout = at->layout;
	const int stride = layout->stride;
	unsigned char *state = at->state;
	num *disc = (num *)(state + layout->disc);
	real32 *disc32 = (real32 *)(state + layout->disc32);
	at->head = (struct rve_head *)state;
	at->sx = (coord *)disc, at->sy = (coord *)(disc + stride);
	at->vx = disc + PACKED_VX * stride, at->vy = disc + PACKED_VY * stride, at->w = disc + PACKED_W * stride;
	at->rest_x = disc + PACKED_REST_X * stride, at->rest_y = disc + PACKED_REST_Y * stride;
	at->ref_x = disc32 + DISC32_REF_X * stride, at->ref_y = disc32 + DISC32_REF_Y * stride;
	at->ux = disc32 + DISC32_UX * stride, at->uy = disc32 + DISC32_UY * stride;
	at->turned = disc32 + DISC32_ROTATION * stride;
	at->ft = (num *)(state + layout->ft);
	at->fd = (real32 *)(state + layout->fd);
	at->damping = (real32 *)(state + layout->damping);
	at->pair_j = (index16 *)(state + layout->pair_j);
	at->id = (index16 *)(state + layout->id);
	at->first = (index16 *)(state + layout->first);
	at->flag = state + layout->flag;
	num *row = (num *)scratch;
	at->r = row, at->mass = row + stride, at->step_mass = row + 2 * stride, at->step_inertia = row + 3 * stride;
	at->rotation = row + 4 * stride, at->own = row + 5 * stride;
	at->record = row + 8 * stride;
	at->velocity = at->record + RECORD * (stride + LANE_COUNT);
	at->force = at->velocity + VELOCITY * (stride + LANE_COUNT);
	at->offset = (uint32_t *)(at->force + RECORD * (stride + LANE_COUNT));
	at->free = (unsigned char *)(at->offset + layout->pairs);
	at->scale = 1.0 + at->constants->expansion * at->head->temperature;
	at->scale_step = at->constants->expansion * at->call->heating;
	at->bond_temperature = at->call->temperature;
	at->bond_force = bond_bears(at->constants, at->bond_temperature, at->call->sub_steps);
	cell_invert(at->head->H, at->H_inv);
	memset(at->lanes, 0, sizeof at->lanes);
}

/* Where one sub-step takes the cell, the radii and the bonds' strength. */
static inline void packed_cell_step(struct packed_place *at)
{
	const struct rve_call *call = at->call;
	cell_step(call->A, at->head->H);
	cell_invert(at->head->H, at->H_inv);
	at->head->temperature += call->heating;
	at->scale = 1.0 + at->constants->expansion * at->head->temperature;
	at->bond_temperature += call->heating;
	at->bond_force = bond_bears(at->constants, at->bond_temperature, call->sub_steps);
}

/* One RVE, call->sub_steps sub-steps.  `scratch` is layout->scratch bytes, 64-byte aligned. */
KERNEL(rve_packed)
(const struct rve_layout *layout, const struct rve_constants *constants, const struct rve_call *call,
 GLOBAL const void *table, GLOBAL unsigned char *state, GLOBAL const unsigned char *ahead, LOCAL unsigned char *scratch,
 int *status)
{
	struct packed_place place = {
		.layout = layout, .constants = constants, .call = call, .table = table, .state = state, .ahead = ahead};
	struct packed_place *at = &place;
	packed_open(at, scratch);
	packed_load(at);
	const int bonded = at->head->bonds_intact > 0, grows = call->heating != 0.0;
	*status = KERNEL_OK;
	if (call->rebuild && (*status = packed_build(at, 0)) != KERNEL_OK)
		return;
	for (int k = 0; k < call->sub_steps; k++) {
		double gx[4] = {at->H_inv[0], at->H_inv[1], at->H_inv[2], at->H_inv[3]};
		packed_cell_step(at);
		packed_discs(at, gx, k > 0, 1, 0);
		if (!packed_valid(at)) {
			if (bonded)
				packed_tear(at);
			if ((*status = packed_build(at, 1)) != KERNEL_OK)
				return;
		}
		packed_contacts(at, k + 1 == call->sub_steps, bonded, grows);
	}
	if (call->sub_steps == 0) {
		packed_records(at);
		packed_contacts(at, 1, bonded, 0);
	}
	packed_finish(at);
}

static inline int packed_scratch(const struct rve_layout *layout)
{
	const long row = layout->stride + LANE_COUNT;
	const long bytes = (long)sizeof(num) * (8 + 2 * RECORD + VELOCITY) * row + (long)sizeof(uint32_t) * layout->pairs +
					   packed_build_scratch(layout);
	return (int)((bytes + 63) / 64 * 64);
}

#endif
