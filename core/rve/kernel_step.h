/* One sub-step: move, contact forces, gather, kick; and the homogenisation.  Included by kernel.h only. */

/* The cell; radii grow. */
BLOCKFN void cell_move(SHARED const struct rve_place *at)
{
	SHARED struct rve_block *block = at->block;
	SHARED const struct rve_call *call = at->call;
	ONE_THREAD
	{
		for (int k = 0; k < 4; k++)
			block->drift[k] = block->H_inv[k] * at->constants->dt;
		cell_step(call->A, block->head.H);
		cell_invert(block->head.H, block->H_inv);
		block->head.temperature += call->heating;
		block->scale = 1.0 + at->constants->expansion * block->head.temperature;
		block->bond_temperature += call->heating;
		bonds_soften(at);
	}
	FOR_THREADS(lane, LANES) { block->lanes[LANE_DISPLACEMENT][lane] = 0.0, block->lanes[LANE_SECOND][lane] = 0.0; }
}

/* The discs in the cell; velocities turn and thin out with it. */
BLOCKFN void discs_move(SHARED const struct rve_place *at)
{
	SHARED struct rve_block *block = at->block;
	SHARED const struct rve_call *call = at->call;
	const real gxx = block->drift[0], gxy = block->drift[1], gyx = block->drift[2], gyy = block->drift[3];
	LOCAL real *sx = WORK_ROW(WORK_SX), *sy = WORK_ROW(WORK_SY);
	LOCAL real *vx = WORK_ROW(WORK_VX), *vy = WORK_ROW(WORK_VY);
	LOCAL const real *mass = WORK_ROW(WORK_MASS);
	GLOBAL const real32 *ref_x = STATE_DISC32(DISC32_REF_X), *ref_y = STATE_DISC32(DISC32_REF_Y);
	SHARED real *most = block->lanes[LANE_DISPLACEMENT], *second = block->lanes[LANE_SECOND];
	SHARED real *kinetic_work = block->lanes[LANE_KINETIC_WORK];
	const real hxx = block->head.H[0], hxy = block->head.H[1], hyx = block->head.H[2], hyy = block->head.H[3];
	const real bxx = call->B[0], bxy = call->B[1], byx = call->B[2], byy = call->B[3];
	const real dxx = call->D[0], dyy = call->D[1], dxy = call->D[2];
	for (int base = 0; base < at->layout->n; base += LANES) {
		const int count = at->layout->n - base < LANES ? at->layout->n - base : LANES;
		FOR_THREADS(lane, count)
		{
			const int i = base + lane;
			real x = vx[i], y = vy[i];
			real px = sx[i] + gxx * x + gxy * y, py = sy[i] + gyx * x + gyy * y;
			kinetic_work[lane] -= mass[i] * (x * (dxx * x + dxy * y) + y * (dxy * x + dyy * y));
			vx[i] = bxx * x + bxy * y;
			vy[i] = byx * x + byy * y;
			sx[i] = px;
			sy[i] = py;
			real qx = px - (real)ref_x[i], qy = py - (real)ref_y[i];
			real ux = hxx * qx + hxy * qy, uy = hyx * qx + hyy * qy;
			real uu = ux * ux + uy * uy;
			second[lane] = real_max(real_min(uu, most[lane]), second[lane]);
			most[lane] = real_max(uu, most[lane]);
		}
	}
}

/* What contacts_of_level() does about bonds. */
enum { BONDS_ABSENT, BONDS_PRESENT, BONDS_TEAR };

/* Forces of the pairs of one level: added up for i, left in the pair's slot for j.  `last`: also everything that the
 * homogenisation needs.  BONDS_TEAR: instead of all that, bonds of discs that have parted too far are broken.
 *
 * An intact bond is the contact's spring, dashpot and tangential spring without their limits: in both directions, so
 * that what its dashpot takes is the same expression as a contact's.  What is stored in a bond when it breaks, less
 * what the contact that is left still stores, is released: the work of the sub-step's mean forces and the change of the
 * stored energy say how much, 1/2 kn delta_old delta of the normal spring where it pulled. */
BLOCKFN void contacts_of_level(SHARED const struct rve_place *at, const int level, const int last, const int bonds)
{
	SHARED struct rve_block *block = at->block;
	SHARED const struct rve_constants *constants = at->constants;
	const real kn = constants->kn, ks = constants->ks, mu = constants->mu, dt = constants->dt;
	const real half_compliance = 0.5 / ks, half_softness = 0.5 / kn;
	const real bond_force = block->bond_force, bond_mu = constants->bond_mu;
	const real scale = block->scale;
	const real hxx = block->head.H[0], hxy = block->head.H[1], hyx = block->head.H[2], hyy = block->head.H[3];
	const real still = at->call->sub_steps > 0 ? 1.0 : 0.0; /* 0: measured without motion */
	const real step = dt * still, growth = block->scale_step * still;
	const real dxx = at->call->D[0] * still, dyy = at->call->D[1] * still, dxy = at->call->D[2] * still;
	const int first = block->head.level_first[level], rows = block->head.level_first[level + 1] - first;
	LOCAL const int *pair_j = WORK_PAIR_INDEX(WORK_J) + first;
	LOCAL const real *sx = WORK_ROW(WORK_SX), *sy = WORK_ROW(WORK_SY);
	LOCAL const real *vx = WORK_ROW(WORK_VX), *vy = WORK_ROW(WORK_VY), *w = WORK_ROW(WORK_W);
	LOCAL const real *radius = WORK_ROW(WORK_R);
	LOCAL real *force_x = WORK_ROW(WORK_FX), *force_y = WORK_ROW(WORK_FY), *torque = WORK_ROW(WORK_TORQUE);
	GLOBAL const real32 *damping = STATE_DAMPING + first;
	GLOBAL real32 *dashpot_force = STATE_FD + first;
	LOCAL real *tangential = WORK_PAIR(WORK_FT) + first, *bond = WORK_PAIR(WORK_BOND) + first;
	LOCAL real *slot_x = WORK_PAIR(WORK_PX) + first, *slot_y = WORK_PAIR(WORK_PY) + first,
			   *slot_t = WORK_PAIR(WORK_TJ) + first;
	SHARED real(*sum)[LANES] = block->lanes;

	for (int base = 0; base < rows; base += LANES) {
		const int count = rows - base < LANES ? rows - base : LANES;
		FOR_THREADS(lane, count)
		{
			const int i = base + lane, j = pair_j[i];
			/* branch to the nearest image: unique while the cell is wide enough (neighbours_build) */
			real ax = sx[j] - sx[i], ay = sy[j] - sy[i];
			ax -= real_nearest(ax);
			ay -= real_nearest(ay);
			real bx = hxx * ax + hxy * ay, by = hyx * ax + hyy * ay;
			real length = real_sqrt(real_max(bx * bx + by * by, 1e-60)),
				 inverse = 1.0 / length; /* the ghost may coincide */
			real nx = bx * inverse, ny = by * inverse;
			real ri = radius[i] * scale, rj = radius[j] * scale;
			real overlap = ri + rj - length, indent = 0.5 * overlap;
			/* relative displacement in this sub-step: fluctuations and stretching, without the rotation */
			real ex = dxx * bx + dxy * by, ey = dxy * bx + dyy * by;
			real ux = (vx[j] - vx[i]) * step + ex, uy = (vy[j] - vy[i]) * step + ey;
			real ai = ri - indent, aj = rj - indent, spin = ai * w[i] + aj * w[j];
			real un = ux * nx + uy * ny, ut = uy * nx - ux * ny - spin * step;
			/* normal force: spring and dashpot, never pulling */
			real spring = kn * real_max(overlap, 0.0);
			real pushed = real_max(spring - (real)damping[i] * un, 0.0);
			real fn = overlap > 0.0 ? pushed : 0.0;
			/* tangential force: spring up to the Coulomb limit; the rest of the displacement slips */
			real cap = mu * fn, ft_old = tangential[i], trial = ft_old - ks * ut;
			int holds = 0, breaks = 0;
			real released = 0.0;
			if (bonds) {
				real bears = bond_force * (radius[i] + radius[j]), shear = trial < 0.0 ? -trial : trial;
				real force = kn * overlap, force_old = kn * (overlap + un - growth * (radius[i] + radius[j]));
				int was = bond[i] == BOND_INTACT;
				holds = was & (-force <= bears) & (shear <= bond_mu * bears);
				breaks = was & !holds;
				released = overlap < 0.0 ? half_softness * force_old * force : 0.0;
				fn = holds ? force - (real)damping[i] * un : fn;
				spring = holds ? force : spring;
				cap = holds ? BOND_UNBREAKABLE : cap;
			}
			if (bonds == BONDS_TEAR) {
				int torn = breaks & (overlap < 0.0);
				sum[LANE_BOND][lane] += torn ? released + half_compliance * ft_old * trial : 0.0;
				tangential[i] = torn ? 0.0 : ft_old;
				bond[i] = torn ? BOND_BROKEN : bond[i];
				continue;
			}
			real fd = fn - spring, fd_old = (real)dashpot_force[i];
			real ft = real_max(real_min(trial, cap), -cap), slip = (ft_old + ft) * (trial - ft);
			if (bonds) {
				bond[i] = breaks ? BOND_BROKEN : bond[i];
				sum[LANE_BOND][lane] += breaks ? released + half_compliance * slip : 0.0;
				slip = breaks ? 0.0 : slip;
			}
			real fx = fn * nx - ft * ny, fy = fn * ny + ft * nx;
			tangential[i] = ft;
			dashpot_force[i] = (real32)fd;
			force_x[i] -= fx;
			force_y[i] -= fy;
			torque[i] -= ai * ft;
			slot_x[i] = fx;
			slot_y[i] = fy;
			slot_t[i] = aj * ft;
			sum[LANE_WORK][lane] -= fx * ex + fy * ey;
			sum[LANE_EXPANSION][lane] += spring * (radius[i] + radius[j]);
			sum[LANE_FRICTION][lane] += slip;
			sum[LANE_DASHPOT][lane] -= (fd_old + fd) * un;
			if (last) {
				real touching = (overlap > 0.0) | holds ? 1.0 : 0.0, pressed = fn;
				if (bonds) {
					pressed = fn < 0.0 ? -fn : fn;
					sum[LANE_BONDS][lane] += holds ? 1.0 : 0.0;
				}
				real l = touching * length, ll = l * length;
				real xx = nx * nx, yy = ny * ny, xy = nx * ny;
				real ft_size = ft < 0.0 ? -ft : ft;
				sum[LANE_SXX][lane] += fx * bx;
				sum[LANE_SYY][lane] += fy * by;
				sum[LANE_SXY][lane] += 0.5 * (fx * by + fy * bx);
				sum[LANE_LXX][lane] += l * xx;
				sum[LANE_LYY][lane] += l * yy;
				sum[LANE_LXY][lane] += l * xy;
				sum[LANE_N40][lane] += ll * xx * xx;
				sum[LANE_N04][lane] += ll * yy * yy;
				sum[LANE_N22][lane] += ll * xx * yy;
				sum[LANE_N31][lane] += ll * xx * xy;
				sum[LANE_N13][lane] += ll * yy * xy;
				sum[LANE_OVERLAP_FORCE][lane] += spring * (radius[i] + radius[j]);
				sum[LANE_ELASTIC][lane] += 0.5 * spring * overlap + half_compliance * ft * ft;
				sum[LANE_CONTACTS][lane] += touching;
				sum[LANE_SLIDING][lane] += (fn > 0.0 ? 1.0 : 0.0) * (ft_size >= cap ? 1.0 : 0.0);
				sum[LANE_FORCE][lane] += pressed;
				sum[LANE_OVERLAP][lane] = real_max(touching * overlap / real_min(ri, rj), sum[LANE_OVERLAP][lane]);
			}
		}
	}
}

/* Forces and torques of all discs as the i of their pairs.  Levels need not wait for each other: a disc is always the
 * same lane's. */
BLOCKFN void contacts_of_kind(SHARED const struct rve_place *at, const int last, const int bonds)
{
	LOCAL real *fx = WORK_ROW(WORK_FX), *fy = WORK_ROW(WORK_FY), *torque = WORK_ROW(WORK_TORQUE);
	for (int base = 0; base < at->layout->stride; base += LANES) {
		const int count = at->layout->stride - base < LANES ? at->layout->stride - base : LANES;
		FOR_THREADS(lane, count) { fx[base + lane] = 0.0, fy[base + lane] = 0.0, torque[base + lane] = 0.0; }
	}
	for (int level = 0; level < at->block->head.levels; level++)
		contacts_of_level(at, level, last, bonds);
}

/* The same, compiled once for each kind where that pays. */
BLOCKFN void contacts(SHARED const struct rve_place *at, const int last, const int bonded)
{
	if (!SPECIALISED)
		contacts_of_kind(at, last, bonded ? BONDS_PRESENT : BONDS_ABSENT);
	else if (bonded && last)
		contacts_of_kind(at, 1, BONDS_PRESENT);
	else if (bonded)
		contacts_of_kind(at, 0, BONDS_PRESENT);
	else if (last)
		contacts_of_kind(at, 1, BONDS_ABSENT);
	else
		contacts_of_kind(at, 0, BONDS_ABSENT);
}

/* Breaks the bonds that the motion of this sub-step has parted too far, while the old list still has them. */
BLOCKFN void bonds_tear(SHARED const struct rve_place *at)
{
	for (int level = 0; level < at->block->head.levels; level++)
		contacts_of_level(at, level, 0, BONDS_TEAR);
}

/* And as the j of their pairs, once all are there. */
BLOCKFN void gather(SHARED const struct rve_place *at)
{
	SHARED const struct rve_head *head = &at->block->head;
	LOCAL real *fx = WORK_ROW(WORK_FX), *fy = WORK_ROW(WORK_FY), *torque = WORK_ROW(WORK_TORQUE);
	LOCAL const real *slot_x = WORK_PAIR(WORK_PX), *slot_y = WORK_PAIR(WORK_PY), *slot_t = WORK_PAIR(WORK_TJ);
	for (int level = 0; level < head->entry_levels; level++) {
		const int first = head->entry_first[level];
		LOCAL const int *entry = WORK_ENTRY(level);
		FOR_THREADS_FROM(i, first, at->layout->n)
		{
			fx[i] += slot_x[entry[i]];
			fy[i] += slot_y[entry[i]];
			torque[i] -= slot_t[entry[i]];
		}
	}
}

BLOCKFN void kick(SHARED const struct rve_place *at, const int moves)
{
	const real dt = at->constants->dt;
	LOCAL real *vx = WORK_ROW(WORK_VX), *vy = WORK_ROW(WORK_VY), *w = WORK_ROW(WORK_W);
	LOCAL real *rotation = WORK_ROW(WORK_ROTATION);
	LOCAL const real *fx = WORK_ROW(WORK_FX), *fy = WORK_ROW(WORK_FY), *torque = WORK_ROW(WORK_TORQUE);
	LOCAL const real *dt_mass = WORK_ROW(WORK_DT_MASS), *dt_inertia = WORK_ROW(WORK_DT_INERTIA);
	if (!moves)
		return;
	FOR_THREADS(i, at->layout->n)
	{
		vx[i] += fx[i] * dt_mass[i];
		vy[i] += fy[i] * dt_mass[i];
		w[i] += torque[i] * dt_inertia[i];
		rotation[i] += w[i] * dt;
	}
}

/* Sums over discs of the last configuration.  Kinetic energy is centred on the time of the positions. */
BLOCKFN void discs_measure(SHARED const struct rve_place *at)
{
	SHARED real(*sum)[LANES] = at->block->lanes;
	LOCAL const real *vx = WORK_ROW(WORK_VX), *vy = WORK_ROW(WORK_VY), *w = WORK_ROW(WORK_W);
	LOCAL const real *fx = WORK_ROW(WORK_FX), *fy = WORK_ROW(WORK_FY), *torque = WORK_ROW(WORK_TORQUE);
	LOCAL const real *dt_mass = WORK_ROW(WORK_DT_MASS), *mass = WORK_ROW(WORK_MASS);
	LOCAL const real *dt_inertia = WORK_ROW(WORK_DT_INERTIA);
	const real dt = at->constants->dt;
	for (int base = 0; base < at->layout->n; base += LANES) {
		const int count = at->layout->n - base < LANES ? at->layout->n - base : LANES;
		FOR_THREADS(lane, count)
		{
			const int i = base + lane;
			real x = vx[i], y = vy[i], m = mass[i];
			real before_x = x - fx[i] * dt_mass[i], before_y = y - fy[i] * dt_mass[i];
			real before_w = w[i] - torque[i] * dt_inertia[i];
			sum[LANE_VXX][lane] += m * x * x;
			sum[LANE_VYY][lane] += m * y * y;
			sum[LANE_VXY][lane] += m * x * y;
			sum[LANE_KINETIC][lane] += 0.5 * (m * (x * before_x + y * before_y) + dt / dt_inertia[i] * w[i] * before_w);
			sum[LANE_UNBALANCED][lane] += real_sqrt(fx[i] * fx[i] + fy[i] * fy[i]);
		}
	}
}

/* One turn of adding up the lanes: after width = LANES / 2, LANES / 4 .. 1 field q is in lanes[q][0]. */
BLOCKFN void lanes_halve(SHARED const struct rve_place *at, const int width)
{
	SHARED struct rve_block *block = at->block;
	for (int q = 0; q < LANE_SUMS; q++)
		FOR_THREADS(lane, width) block->lanes[q][lane] += block->lanes[q][lane + width];
	FOR_THREADS(lane, width)
	block->lanes[LANE_OVERLAP][lane] =
		real_max(block->lanes[LANE_OVERLAP][lane + width], block->lanes[LANE_OVERLAP][lane]);
}

/* Stress, conductivity, elasticity and ledgers from the sums. */
BLOCKFN void homogenise(SHARED const struct rve_place *at)
{
	SHARED struct rve_block *block = at->block;
	ONE_THREAD
	{
		real total[LANE_TOTALS];
		for (int q = 0; q < LANE_TOTALS; q++)
			total[q] = block->lanes[q][0];
		head_from_totals(&block->head, at->constants, at->call, at->layout->n, block->scale_step, total);
	}
}
