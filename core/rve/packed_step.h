/* One sub-step of the packed kernel: discs, contact forces; and the homogenisation.  Included by packed.h only. */

#define EACH_PART _Pragma("GCC unroll 4") for (int part = 0; part < BLOCK_PARTS; part++)

/* Adds a block's sum to the lanes of a total. */
VECFN void lanes_add(struct packed_place *at, int field, const vec sum[BLOCK_PARTS])
{
	num lane[LANE_COUNT] __attribute__((aligned(64)));
	EACH_PART vec_store(lane + part * VECTOR_WIDTH, sum[part]);
	for (int k = 0; k < LANE_COUNT; k++)
		at->lanes[field][k] += (double)lane[k];
}

/* Moves coordinates by `way` (in COORD_UNIT); what is left over goes to `rest`.  The new ones, as they stand in
 * records. */
VECFN vec coord_move(coord *s, num *rest, vec way)
{
#ifdef RVE_FLOAT
	vec sum = vec_load(rest) + way;
	ivec whole = vec_whole(sum), to = coord_moved(coord_load(s), whole);
	vec_store(rest, sum - __builtin_convertvector(whole, vec));
	coord_store(s, to);
	return (vec)to;
#else
	(void)rest;
	vec to = vec_load(s) + way;
	vec_store(s, to);
	return to;
#endif
}

VECFN vec coord_as_record(const coord *s)
{
#ifdef RVE_FLOAT
	return (vec)coord_load(s);
#else
	return vec_load(s);
#endif
}

/* The way since the list was made, in COORD_UNIT. */
VECFN vec coord_since(vec now, const real32 *ref)
{
#ifdef RVE_FLOAT
	return coord_way((ivec)now, coord_load((const coord *)ref));
#else
	return now - vec_load32(ref);
#endif
}

/* Where the other discs of the pairs are in memory. */
static inline void packed_offsets(struct packed_place *at)
{
	const int slots = at->first[at->layout->stride / LANE_COUNT] * LANE_COUNT;
	for (int p = 0; p < slots; p++)
		at->offset[p] = VELOCITY * (uint32_t)sizeof(num) * at->pair_j[p];
}

/* Constants of the discs in rows; no forces. */
static inline void packed_load(struct packed_place *at)
{
	const int stride = at->layout->stride;
	for (int row = 0; row < stride; row += VECTOR_WIDTH) {
		const num *from[VECTOR_WIDTH];
		for (int k = 0; k < VECTOR_WIDTH; k++)
			from[k] = at->table + PACKED_TABLE * at->id[row + k];
		vec r, mass, step_mass, step_inertia;
		vec_fetch4(from, &r, &mass, &step_mass, &step_inertia);
		vec_store(at->r + row, r), vec_store(at->mass + row, mass);
		vec_store(at->step_mass + row, step_mass), vec_store(at->step_inertia + row, step_inertia);
		vec_store(at->rotation + row, vec_set(0));
	}
	packed_offsets(at);
	memset(at->force, 0, sizeof(num) * RECORD * (size_t)(stride + 1));
	num *ghost = at->record + RECORD * stride;
	memset(ghost, 0, sizeof(num) * RECORD);
	ghost[2] = (num)PACKED_GHOST_RADIUS;
	memset(at->velocity + VELOCITY * stride, 0, sizeof(num) * VELOCITY);
}

/* The records of the discs as they are. */
static inline void packed_records(struct packed_place *at)
{
	for (int row = 0; row < at->layout->stride; row += VECTOR_WIDTH) {
		vec_put4(at->record + RECORD * row, coord_as_record(at->sx + row), coord_as_record(at->sy + row),
				 vec_load(at->r + row), vec_load(at->w + row));
		vec_put2(at->velocity + VELOCITY * row, vec_load(at->vx + row), vec_load(at->vy + row));
	}
}

/* Net forces and torques of a vector of rows; their records are left empty. */
VECFN void forces_take(struct packed_place *at, int row, vec *fx, vec *fy, vec *torque)
{
	const int stride = at->layout->stride;
	num *force = at->force + RECORD * row;
	const num *from[VECTOR_WIDTH];
	vec x, y, t, none;
	for (int k = 0; k < VECTOR_WIDTH; k++)
		from[k] = force + RECORD * k;
	vec_fetch4(from, &x, &y, &t, &none);
	for (int k = 0; k < RECORD; k++)
		vec_store(force + VECTOR_WIDTH * k, vec_set(0));
	*fx = x + vec_load(at->own + row);
	*fy = y + vec_load(at->own + stride + row);
	*torque = t + vec_load(at->own + 2 * stride + row);
}

/* The discs' part of a sub-step.  `kick`: by the forces of the last configuration; `move`: the next sub-step's motion,
 * with the inverse of the cell before it; velocities turn and thin out with the cell.  `measure`: sums over discs,
 * after the kick; kinetic energy is centred on the time of the positions. */
VECFN void packed_discs_of_kind(struct packed_place *at, const double H_inv[4], const int kick, const int move,
								const int measure)
{
	const double *H = at->head->H, *B = at->call->B, *D = at->call->D, dt = at->constants->dt;
	const vec gxx = vec_set((num)(H_inv[0] / COORD_UNIT)), gxy = vec_set((num)(H_inv[1] / COORD_UNIT));
	const vec gyx = vec_set((num)(H_inv[2] / COORD_UNIT)), gyy = vec_set((num)(H_inv[3] / COORD_UNIT));
	const vec hxx = vec_set((num)(H[0] * COORD_UNIT)), hxy = vec_set((num)(H[1] * COORD_UNIT));
	const vec hyx = vec_set((num)(H[2] * COORD_UNIT)), hyy = vec_set((num)(H[3] * COORD_UNIT));
	const vec bxx = vec_set((num)B[0]), bxy = vec_set((num)B[1]), byx = vec_set((num)B[2]), byy = vec_set((num)B[3]);
	const vec dxx = vec_set((num)D[0]), dyy = vec_set((num)D[1]), dxy2 = vec_set((num)(2.0 * D[2]));
	const vec half = vec_set((num)0.5), dt2 = vec_set((num)(dt * dt));
	vec work[BLOCK_PARTS], most[BLOCK_PARTS], second[BLOCK_PARTS], vxx[BLOCK_PARTS], vyy[BLOCK_PARTS], vxy[BLOCK_PARTS];
	vec kinetic[BLOCK_PARTS], unbalanced[BLOCK_PARTS];
	EACH_PART
	{
		work[part] = most[part] = second[part] = vxx[part] = vyy[part] = vxy[part] = vec_set(0);
		kinetic[part] = unbalanced[part] = vec_set(0);
	}
	for (int block = 0; block < at->layout->stride; block += LANE_COUNT) {
		EACH_PART
		{
			const int row = block + part * VECTOR_WIDTH;
			vec x = vec_load(at->vx + row), y = vec_load(at->vy + row), w = vec_load(at->w + row);
			const vec mass = vec_load(at->mass + row);
			if (kick || measure) {
				const vec step_mass = vec_load(at->step_mass + row), step_inertia = vec_load(at->step_inertia + row);
				vec fx, fy, torque;
				forces_take(at, row, &fx, &fy, &torque);
				if (kick) {
					x += fx * step_mass;
					y += fy * step_mass;
					w += torque * step_inertia;
					vec_store(at->w + row, w);
					vec_store(at->rotation + row, vec_load(at->rotation + row) + w);
				}
				if (measure) {
					vec before_x = x - fx * step_mass, before_y = y - fy * step_mass,
						before_w = w - torque * step_inertia;
					vxx[part] += mass * x * x;
					vyy[part] += mass * y * y;
					vxy[part] += mass * x * y;
					kinetic[part] +=
						half * (mass * (x * before_x + y * before_y) + dt2 / step_inertia * (w * before_w));
					unbalanced[part] += vec_sqrt(fx * fx + fy * fy);
				}
			}
			if (move) {
				vec px = coord_move(at->sx + row, at->rest_x + row, gxx * x + gxy * y);
				vec py = coord_move(at->sy + row, at->rest_y + row, gyx * x + gyy * y);
				work[part] -= mass * (x * (dxx * x + dxy2 * y) + dyy * y * y);
				vec turned_x = bxx * x + bxy * y, turned_y = byx * x + byy * y;
				x = turned_x, y = turned_y;
				vec qx = coord_since(px, at->ref_x + row), qy = coord_since(py, at->ref_y + row);
				vec ux = hxx * qx + hxy * qy, uy = hyx * qx + hyy * qy, uu = ux * ux + uy * uy;
				second[part] = vec_max(vec_min(uu, most[part]), second[part]);
				most[part] = vec_max(uu, most[part]);
				vec_put4(at->record + RECORD * row, px, py, vec_load(at->r + row), w);
				vec_put2(at->velocity + VELOCITY * row, x, y);
			}
			vec_store(at->vx + row, x);
			vec_store(at->vy + row, y);
		}
	}
	if (move) {
		num first_of[LANE_COUNT] __attribute__((aligned(64))), second_of[LANE_COUNT] __attribute__((aligned(64)));
		EACH_PART
		{
			vec_store(first_of + part * VECTOR_WIDTH, most[part]);
			vec_store(second_of + part * VECTOR_WIDTH, second[part]);
		}
		double a = 0.0, b = 0.0;
		for (int k = 0; k < LANE_COUNT; k++) {
			double p = (double)first_of[k], q = (double)second_of[k];
			b = real_max(real_min(a, p), real_max(b, q));
			a = real_max(p, a);
		}
		at->displacement = real_sqrt(a), at->second = real_sqrt(b);
		lanes_add(at, LANE_KINETIC_WORK, work);
	}
	if (measure) {
		lanes_add(at, LANE_VXX, vxx);
		lanes_add(at, LANE_VYY, vyy);
		lanes_add(at, LANE_VXY, vxy);
		lanes_add(at, LANE_KINETIC, kinetic);
		lanes_add(at, LANE_UNBALANCED, unbalanced);
	}
}

static inline void packed_discs(struct packed_place *at, const double H_inv[4], int kick, int move, int measure)
{
	if (move && kick)
		packed_discs_of_kind(at, H_inv, 1, 1, 0);
	else if (move)
		packed_discs_of_kind(at, H_inv, 0, 1, 0);
	else if (kick)
		packed_discs_of_kind(at, H_inv, 1, 0, 1);
	else if (measure)
		packed_discs_of_kind(at, H_inv, 0, 0, 1);
}

static inline int packed_valid(const struct packed_place *at)
{
	return list_valid(at->head, at->constants, at->scale, at->displacement, at->second);
}

/* What all contacts of a sub-step share. */
struct packed_contact {
	vec hxx, hxy, hyx, hyy, dxx, dyy, dxy, kn, ks, mu, scale, growth, still, half_compliance, half_softness, bond_force,
		bond_mu;
};

VECFN struct packed_contact packed_contact_of(const struct packed_place *at)
{
	const struct rve_constants *c = at->constants;
	const double *H = at->head->H, *D = at->call->D, unit = COORD_UNIT;
	const double still = at->call->sub_steps > 0 ? 1.0 : 0.0; /* 0: measured without motion */
	/* a single that no bond reaches */
	const double bears = real_max(real_min(at->bond_force, 1e30), -1e30);
	return (struct packed_contact){.hxx = vec_set((num)(H[0] * unit)),
								   .hxy = vec_set((num)(H[1] * unit)),
								   .hyx = vec_set((num)(H[2] * unit)),
								   .hyy = vec_set((num)(H[3] * unit)),
								   .dxx = vec_set((num)D[0]),
								   .dyy = vec_set((num)D[1]),
								   .dxy = vec_set((num)D[2]),
								   .kn = vec_set((num)c->kn),
								   .ks = vec_set((num)c->ks),
								   .mu = vec_set((num)c->mu),
								   .scale = vec_set((num)at->scale),
								   .growth = vec_set((num)(at->scale_step * still)),
								   .still = vec_set((num)still),
								   .half_compliance = vec_set((num)(0.5 / c->ks)),
								   .half_softness = vec_set((num)(0.5 / c->kn)),
								   .bond_force = vec_set((num)bears),
								   .bond_mu = vec_set((num)c->bond_mu)};
}

/* Where pairs are; apart from the rest, so that no store makes the compiler read it again. */
struct packed_pointers {
	const num *record, *velocity;
	const uint32_t *offset;
	num *force, *ft;
	real32 *fd;
	const real32 *damping;
	unsigned char *flag;
};

/* Records of the other discs, by the offset of a pair. */
VECFN const num *packed_velocity(const num *velocity, uint32_t offset)
{
	return (const num *)((const char *)velocity + (size_t)offset);
}

VECFN const num *packed_record(const num *record, uint32_t offset)
{
	return (const num *)((const char *)record + (size_t)offset * (RECORD / VELOCITY));
}

/* The discs of a vector of rows: they own the pairs of their block. */
struct packed_side {
	vec x, y, r, w, vx, vy, radius, fx, fy, torque;
};

/* A vector of pairs that touch, or did before, on its way: branch and what there is of the other discs, then what goes
 * to these. */
struct packed_near {
	vec bx, by, square, r, w;
	vec fx, fy, torque;
};

/* The distances of a vector of pairs with first slot p.  Is there anything to do? */
VECFN int packed_reach(const struct packed_pointers at, const struct packed_contact *c, const struct packed_side *i,
					   const int p, struct packed_near *near, const int bonds)
{
	const vec zero = vec_set(0);
	const num *from[VECTOR_WIDTH];
	for (int k = 0; k < VECTOR_WIDTH; k++)
		from[k] = packed_record(at.record, at.offset[p + k]);
	vec x, y;
	vec_fetch4(from, &x, &y, &near->r, &near->w);
	/* branch to the nearest image: unique while the cell is wide enough (packed_build) */
	const vec ax = coord_branch(x, i->x), ay = coord_branch(y, i->y);
	near->bx = c->hxx * ax + c->hxy * ay;
	near->by = c->hyx * ax + c->hyy * ay;
	/* the ghost may coincide */
	near->square = vec_max(near->bx * near->bx + near->by * near->by, vec_set(VECTOR_PICK(1e-60, 1e-30F)));
	/* without the root, which takes long; a little more than those that touch */
	const vec touching = (i->radius + near->r * c->scale) * vec_set(VECTOR_PICK(1.0 + 1e-14, 1.0F + 1e-6F));
	const mask touches = mask_above(touching * vec_max(touching, zero), near->square);
	const mask touched =
		mask_or(mask_different(vec_load(at.ft + p), zero), mask_different(vec_load32(at.fd + p), zero));
	const mask works = mask_or(touches, touched);
	return mask_any(bonds ? mask_or(works, mask_flags(at.flag + p, BOND_INTACT)) : works);
}

/* The forces of a vector of pairs: on `i`, on the other discs for packed_react(), and sums.  `last`: also everything
 * that the homogenisation needs.  See contacts_of_level() for bonds. */
VECFN void packed_pairs(const struct packed_pointers at, const struct packed_contact *c, struct packed_side *i,
						const int p, struct packed_near *near, struct packed_sums *sum, const int part, const int last,
						const int bonds, const int grows)
{
#define SUM(field) sum->of[field][part]
	const vec zero = vec_set(0), one = vec_set(1), half = vec_set((num)0.5);
	const num *from[VECTOR_WIDTH];
	for (int k = 0; k < VECTOR_WIDTH; k++)
		from[k] = packed_velocity(at.velocity, at.offset[p + k]);
	const vec bx = near->bx, by = near->by, rj = near->r, wj = near->w;
	/* root and quotient at the same time */
	const vec length = vec_sqrt(near->square), inverse = length * (one / near->square);
	const vec radii = i->r + rj, radius = rj * c->scale;
	const vec overlap = (i->radius + radius) - length;
	const mask touches = mask_above(overlap, zero);
	mask was = {0};
	if (bonds)
		was = mask_flags(at.flag + p, BOND_INTACT);
	const vec ft_old = vec_load(at.ft + p), fd_old = vec_load32(at.fd + p);
	vec vxj, vyj;
	vec_fetch2(from, 0, &vxj, &vyj);
	const vec nx = bx * inverse, ny = by * inverse, middle = half * overlap;
	/* relative displacement in this sub-step: fluctuations and stretching, without the rotation */
	const vec ex = c->dxx * bx + c->dxy * by, ey = c->dxy * bx + c->dyy * by;
	const vec ai = i->radius - middle, aj = radius - middle;
	vec ux = vxj - i->vx, uy = vyj - i->vy, spin = ai * i->w + aj * wj;
	if (last)
		ux *= c->still, uy *= c->still, spin *= c->still;
	ux += ex, uy += ey;
	const vec un = ux * nx + uy * ny, ut = uy * nx - ux * ny - spin;
	const vec damping = vec_load32(at.damping + p);
	/* normal force: spring and dashpot, never pulling */
	vec spring = c->kn * vec_max(overlap, zero);
	vec fn = vec_where(touches, vec_max(spring - damping * un, zero));
	/* tangential force: spring up to the Coulomb limit; the rest of the displacement slips */
	vec cap = c->mu * fn;
	const vec trial = ft_old - c->ks * ut;
	mask holds = {0}, breaks = {0};
	vec released = zero;
	if (bonds) {
		const vec bears = c->bond_force * radii, force = c->kn * overlap;
		const vec force_old = c->kn * (overlap + un - c->growth * radii);
		const mask gives = mask_above(-force, bears) | mask_above(vec_size(trial), c->bond_mu * bears);
		holds = was & ~gives;
		breaks = was & gives;
		released = vec_where(mask_above(zero, overlap), c->half_softness * force_old * force);
		fn = vec_select(holds, force - damping * un, fn);
		spring = vec_select(holds, force, spring);
		cap = vec_select(holds, vec_set((num)1e30), cap);
	}
	/* exactly +0, not -0, where there is no force, as where pairs are left out */
	const mask joined = bonds ? mask_or(touches, holds) : touches;
	const vec ft = vec_where(joined, vec_max(vec_min(trial, cap), -cap) + zero), fd = vec_where(joined, fn - spring);
	vec slip = (ft_old + ft) * (trial - ft);
	if (bonds) {
		if (mask_any(breaks)) {
			num broken[VECTOR_WIDTH] __attribute__((aligned(64)));
			vec_store(broken, vec_where(breaks, one));
			for (int k = 0; k < VECTOR_WIDTH; k++)
				at.flag[p + k] = broken[k] != 0 ? BOND_BROKEN : at.flag[p + k];
		}
		SUM(LANE_BOND) += vec_where(breaks, released + c->half_compliance * slip);
		slip = vec_select(breaks, zero, slip);
	}
	const vec fx = fn * nx - ft * ny, fy = fn * ny + ft * nx;
	vec_store(at.ft + p, ft);
	vec_store32(at.fd + p, fd);
	i->fx -= fx;
	i->fy -= fy;
	i->torque -= ai * ft;
	near->fx = fx, near->fy = fy, near->torque = -(aj * ft);
	SUM(LANE_WORK) -= fx * ex + fy * ey;
	if (grows)
		SUM(LANE_EXPANSION) += spring * radii;
	SUM(LANE_FRICTION) += slip;
	SUM(LANE_DASHPOT) -= (fd_old + fd) * un;
	if (!last)
		return;
	const vec touching = vec_where(joined, one), pressed = bonds ? vec_size(fn) : fn;
	if (bonds)
		SUM(LANE_BONDS) += vec_where(holds, one);
	const vec l = touching * length, ll = l * length, xx = nx * nx, yy = ny * ny, xy = nx * ny;
	SUM(LANE_SXX) += fx * bx;
	SUM(LANE_SYY) += fy * by;
	SUM(LANE_SXY) += half * (fx * by + fy * bx);
	SUM(LANE_LXX) += l * xx;
	SUM(LANE_LYY) += l * yy;
	SUM(LANE_LXY) += l * xy;
	SUM(LANE_N40) += ll * xx * xx;
	SUM(LANE_N04) += ll * yy * yy;
	SUM(LANE_N22) += ll * xx * yy;
	SUM(LANE_N31) += ll * xx * xy;
	SUM(LANE_N13) += ll * yy * xy;
	SUM(LANE_OVERLAP_FORCE) += spring * radii;
	SUM(LANE_ELASTIC) += half * spring * overlap + c->half_compliance * ft * ft;
	SUM(LANE_CONTACTS) += touching;
	SUM(LANE_SLIDING) += vec_where(mask_above(fn, zero), vec_where(~mask_above(cap, vec_size(ft)), one));
	SUM(LANE_FORCE) += pressed;
	SUM(LANE_OVERLAP) = vec_max(touching * overlap / vec_min(i->radius, radius), SUM(LANE_OVERLAP));
#undef SUM
}

/* The forces of a vector of pairs into the records of the other discs. */
VECFN void packed_react(const struct packed_pointers at, const int p, const struct packed_near *near)
{
	num *to[VECTOR_WIDTH];
	for (int k = 0; k < VECTOR_WIDTH; k++)
		to[k] = (num *)packed_record(at.force, at.offset[p + k]);
	vec_add3(to, near->fx, near->fy, near->torque);
}

VECFN void packed_side_load(const struct packed_place *at, const struct packed_contact *c, struct packed_side *i,
							int row)
{
	i->x = coord_as_record(at->sx + row), i->y = coord_as_record(at->sy + row);
	i->r = vec_load(at->r + row), i->w = vec_load(at->w + row);
	i->vx = vec_load(at->vx + row), i->vy = vec_load(at->vy + row);
	i->radius = i->r * c->scale;
	i->fx = i->fy = i->torque = vec_set(0);
}

/* Forces and torques of all discs. */
VECFN void packed_contacts_of_kind(struct packed_place *at, const int last, const int bonds, const int grows)
{
	const int stride = at->layout->stride, blocks = stride / LANE_COUNT;
	const int fields = last ? LANE_OVERLAP + 1 : LANE_KINETIC_WORK;
	const struct packed_contact contact = packed_contact_of(at);
	const struct packed_pointers pairs = {.record = at->record,
										  .velocity = at->velocity,
										  .offset = at->offset,
										  .force = at->force,
										  .ft = at->ft,
										  .fd = at->fd,
										  .damping = at->damping,
										  .flag = at->flag};
	const index16 *const first = at->first;
	struct packed_sums sum;
#pragma GCC unroll 32
	for (int field = 0; field < fields; field++)
		EACH_PART sum.of[field][part] = vec_set(0);
	const int share = (at->layout->flag / blocks + 63) / 64 * 64; /* of what is read of each state */
	for (int block = 0; block < blocks; block++) {
		if (last && at->ahead)
			for (int k = 0; k < share; k += 64)
				__builtin_prefetch(at->ahead + block * share + k, 1, 2);
		struct packed_side side[BLOCK_PARTS];
		EACH_PART packed_side_load(at, &contact, &side[part], block * LANE_COUNT + part * VECTOR_WIDTH);
		for (int level = first[block]; level < first[block + 1]; level++)
			EACH_PART
			{
				const int p = level * LANE_COUNT + part * VECTOR_WIDTH;
				struct packed_near near;
				if (packed_reach(pairs, &contact, &side[part], p, &near, bonds)) {
					packed_pairs(pairs, &contact, &side[part], p, &near, &sum, part, last, bonds, grows);
					packed_react(pairs, p, &near);
				}
			}
		EACH_PART
		{
			const int row = block * LANE_COUNT + part * VECTOR_WIDTH;
			vec_store(at->own + row, side[part].fx);
			vec_store(at->own + stride + row, side[part].fy);
			vec_store(at->own + 2 * stride + row, side[part].torque);
		}
	}
#pragma GCC unroll 32
	for (int field = 0; field < fields && field < LANE_VXX; field++)
		lanes_add(at, field, sum.of[field]);
	if (last) {
		num lane[LANE_COUNT] __attribute__((aligned(64)));
		EACH_PART vec_store(lane + part * VECTOR_WIDTH, sum.of[LANE_OVERLAP][part]);
		for (int k = 0; k < LANE_COUNT; k++)
			at->lanes[LANE_OVERLAP][k] = (double)lane[k];
	}
}

/* The same, compiled once for each kind. */
static inline void packed_contacts(struct packed_place *at, int last, int bonded, int grows)
{
	if (bonded && last)
		packed_contacts_of_kind(at, 1, 1, 1);
	else if (bonded)
		packed_contacts_of_kind(at, 0, 1, 1);
	else if (last)
		packed_contacts_of_kind(at, 1, 0, 1);
	else if (grows)
		packed_contacts_of_kind(at, 0, 0, 1);
	else
		packed_contacts_of_kind(at, 0, 0, 0);
}

/* The last kick, and what the state says of itself. */
static inline void packed_finish(struct packed_place *at)
{
	const struct rve_constants *c = at->constants;
	const int moved = at->call->sub_steps > 0;
	packed_discs(at, at->H_inv, moved, 0, 1);
	for (int row = 0; row < at->layout->stride && moved; row++)
		at->turned[row] += (real32)at->rotation[row];
	double total[LANE_TOTALS];
	for (int q = 0; q < LANE_SUMS; q++) {
		double *lane = at->lanes[q];
		for (int width = LANE_COUNT / 2; width > 0; width /= 2)
			for (int k = 0; k < width; k++)
				lane[k] += lane[k + width];
		total[q] = lane[0];
	}
	total[LANE_OVERLAP] = 0.0;
	for (int k = 0; k < LANE_COUNT; k++)
		total[LANE_OVERLAP] = real_max(at->lanes[LANE_OVERLAP][k], total[LANE_OVERLAP]);
	/* from displacements in one sub-step to velocities */
	static const int kinetic[] = {LANE_KINETIC_WORK, LANE_VXX, LANE_VYY, LANE_VXY, LANE_KINETIC};
	for (int q = 0; q < 5; q++)
		total[kinetic[q]] *= 1.0 / (c->dt * c->dt);
	head_from_totals(at->head, c, at->call, at->layout->n, at->scale_step, total);
}
