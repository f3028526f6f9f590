/* Points to grid and back (TM-DEMPM section 2).  Included by kernel_text.h only. */

/* What a scene asks of a pass; the hot sets are known when it is compiled. */
enum {
	PART_HEAT = 1,     /* this is a thermal step */
	PART_CONFINED = 2, /* confining pressure */
	PART_DAMPED = 4,   /* PIC or damping */
	PART_FILTERED = 8, /* XPIC or FMPM in this step */
	PART_AFFINE = 16,  /* APIC */
	PART_STRAIN = 32   /* USL: points strain with the velocities that move them */
};

static inline int side_of(int nodes) { return nodes == 16 ? 4 : nodes == 9 ? 3 : 2; }

/* ---- points to grid ---- */

/* What the points of a chunk bring to a node, in the order of struct node_sum. */
struct brought {
	double straight[SHAPE_CHUNK][4]; /* times weight: momentum; times grad x: the stress on that side */
	double across[SHAPE_CHUNK][4];   /* times grad y: that on the other */
	double held[SHAPE_CHUNK][4];     /* times weight: mass, heat capacity, heat */
	double volume[SHAPE_CHUNK];      /* m3 */
	double stiffness[SHAPE_CHUNK];   /* m2/s2 */
	double power[SHAPE_CHUNK];       /* W */
	bool sound;                      /* all stresses are numbers */
} ALIGNED;

INLINE void bring_points(const struct mpm *mpm, const int *chunk, int n, int parts, struct brought *brought)
{
	const struct particles *p = &mpm->p;
	const vec none = vec_set(0.0);
	brought->sound = true;
	for (int k = 0; k < n; k += VECTOR_WIDTH) {
		const struct lanes lanes = lanes_of(n, chunk, k);
		vec F[4], s[4], L[4], v[2], m = vec_of(p->mass, &lanes);
		vec_of4((const double(*)[4])p->F, &lanes, F);
		vec_of4((const double(*)[4])p->stress, &lanes, s);
		vec_of4((const double(*)[4])p->L, &lanes, L);
		vec_of2((const double(*)[2])p->v, &lanes, v);
		vec volume = (F[0] * F[3] - F[1] * F[2]) * vec_of(p->volume0, &lanes);
		vec stiffness = vec_of(p->modulus, &lanes) * volume / m;
		vec unsound = (s[0] + s[1] + s[2] + s[3]) + stiffness;
		vec_store(&brought->volume[k], volume);
		vec_store(&brought->stiffness[k], stiffness);
		vec_store(&brought->power[k], volume * (s[0] * L[0] + s[3] * (L[1] + L[2]) + s[1] * L[3]));
		brought->sound = brought->sound && !mask_any(mask_different(unsound - unsound, none));
		vec fxx = -volume * s[0], fyy = -volume * s[1], fxy = -volume * s[3];
		vec_put4(brought->straight[k], m * v[0], m * v[1], fxx, fxy);
		vec_put4(brought->across[k], none, none, fxy, fyy);
		vec capacity = none, heat = none;
		if (parts & PART_HEAT)
			capacity = m * vec_of(p->capacity, &lanes), heat = capacity * vec_of(p->T, &lanes);
		vec_put4(brought->held[k], m, capacity, heat, none);
	}
}

INLINE void scatter_point(struct mpm_work *w, const struct shape_lists *lists, int k, int nodes, int parts,
						  const struct brought *brought)
{
	const four straight = *(const four *)brought->straight[k], across = *(const four *)brought->across[k];
	const four held = *(const four *)brought->held[k];
	const double mass = brought->held[k][0], volume = brought->volume[k];
	for (int a = 0; a < nodes; a++) {
		const double weight = lists->weight[a][k], gx = lists->grad_x[a][k], gy = lists->grad_y[a][k];
		struct node_sum *node = &w->sums[lists->node[a][k]];
		*(four *)node->momentum += (four){weight, weight, gx, gx} * straight + gy * across;
		if (parts & PART_HEAT)
			*(four *)&node->mass += weight * held;
		else
			node->mass += weight * mass;
		if (parts & PART_CONFINED) {
			w->confining[lists->node[a][k]][0] += gx * volume;
			w->confining[lists->node[a][k]][1] += gy * volume;
		}
	}
}

/* The momentum of a point's affine motion, which adds up to none. */
INLINE void scatter_affine(const struct mpm *mpm, struct mpm_work *w, const struct shape_lists *lists, int k, int p,
						   int side)
{
	double r[2], C[4], m = mpm->p.mass[p];
	first_node(mpm, lists, k, p, r);
	affine_matrix(mpm, lists, k, p, side, r, C);
	for (int a = 0; a < side * side; a++) {
		double x[2], wm = lists->weight[a][k] * m;
		struct node_sum *node = &w->sums[lists->node[a][k]];
		node_of_list(mpm, r, a, side, x);
		node->momentum[0] += wm * (C[0] * x[0] + C[1] * x[1]);
		node->momentum[1] += wm * (C[2] * x[0] + C[3] * x[1]);
	}
}

/* What bounds the step, whether the state is sound, and the power of the stress. */
INLINE void check_points(const struct mpm *mpm, const int *chunk, int n, const struct brought *brought,
						 struct stripe_sum *sum)
{
	for (int k = 0; k < n; k++) {
		sum->power += brought->power[k];
		if (brought->stiffness[k] > sum->stiffness)
			sum->stiffness = brought->stiffness[k], sum->stiffest = chunk[k];
	}
	for (int k = 0; k < n && !brought->sound && sum->bad < 0; k++)
		if (!(finite4(mpm->p.stress[chunk[k]]) && isfinite(brought->stiffness[k])))
			sum->bad = chunk[k];
}

INLINE void check_point_heat(const struct mpm *mpm, struct stripe_sum *sum, int p, double volume)
{
	const struct particles *points = &mpm->p;
	double diffusivity = mpm_conductance(mpm, p, volume) / (points->mass[p] * points->capacity[p]);
	if (diffusivity > sum->diffusivity)
		sum->diffusivity = diffusivity, sum->most_diffusive = p;
	if (!isfinite(diffusivity + points->T[p]) && sum->bad < 0)
		sum->bad = p;
}

INLINE void scatter_chunk(const struct mpm *mpm, struct mpm_work *w, const struct shape_lists *lists, const int *chunk,
						  int n, int nodes, int parts, struct stripe_sum *sum)
{
	struct brought brought;
	bring_points(mpm, chunk, n, parts, &brought);
	check_points(mpm, chunk, n, &brought, sum);
	for (int k = 0; k < n; k++) {
		if (parts & PART_HEAT)
			check_point_heat(mpm, sum, chunk[k], brought.volume[k]);
		scatter_point(w, lists, k, nodes, parts, &brought);
		if (parts & PART_AFFINE)
			scatter_affine(mpm, w, lists, k, chunk[k], side_of(nodes));
	}
}

INLINE void scatter_stripe(const struct mpm *mpm, struct mpm_work *w, int stripe, int nodes, int parts)
{
	struct shape_lists lists;
	int first, last;
	mpm_stripe_points(w, stripe, &first, &last);
	struct stripe_sum sum = {.stiffest = -1, .most_diffusive = -1, .bad = -1};
	for (int i = first; i < last; i += SHAPE_CHUNK) {
		const int *chunk = w->order + i, n = last - i < SHAPE_CHUNK ? last - i : SHAPE_CHUNK;
		mpm_lists(mpm, n, chunk, &lists);
		if (nodes == SHAPE_MAX_NODES && lists.nodes == 9)
			scatter_chunk(mpm, w, &lists, chunk, n, 9, parts, &sum);
		else
			scatter_chunk(mpm, w, &lists, chunk, n, nodes, parts, &sum);
	}
	w->stripe_sums[stripe] = sum;
}

/* One copy of the loop for each shape and the usual sets of parts, so that the inner loops have fixed lengths. */
INLINE void scatter_stripe_of(struct mpm *mpm, struct mpm_work *w, int stripe, int nodes, int parts)
{
	if (parts == 0)
		scatter_stripe(mpm, w, stripe, nodes, 0);
	else if (parts == PART_HEAT)
		scatter_stripe(mpm, w, stripe, nodes, PART_HEAT);
	else if (parts == PART_AFFINE)
		scatter_stripe(mpm, w, stripe, nodes, PART_AFFINE);
	else
		scatter_stripe(mpm, w, stripe, nodes, parts);
}

static void scatter_stripe_any(struct mpm *mpm, struct mpm_work *w, int stripe)
{
	int nodes = mpm->shape->max_nodes;
	int parts =
		(w->thermal_dt > 0.0 ? PART_HEAT : 0) | (w->confining ? PART_CONFINED : 0) | (mpm->p.affine ? PART_AFFINE : 0);
	if (nodes == 9)
		scatter_stripe_of(mpm, w, stripe, 9, parts);
	else if (nodes == 4)
		scatter_stripe_of(mpm, w, stripe, 4, parts);
	else
		scatter_stripe_of(mpm, w, stripe, SHAPE_MAX_NODES, parts);
}

/* ---- grid to points ---- */

/* What the nodes say to the points of a chunk. */
struct gathered {
	double v[SHAPE_CHUNK][4];                   /* m/s: before the step, after it */
	double L[SHAPE_CHUNK][4];                   /* 1/s */
	double filtered[SHAPE_CHUNK][2];            /* m/s, of XPIC and FMPM */
	double T_new[SHAPE_CHUNK], dT[SHAPE_CHUNK]; /* K */
} ALIGNED;

INLINE void gather_point(const struct grid *grid, const struct mpm_work *w, const struct shape_lists *lists, int k,
						 int nodes, int parts, struct gathered *g)
{
	two v = {0.0, 0.0}, u = v, along_x = v, along_y = v, filtered = v;
	double T_new = 0.0, dT = 0.0;
	for (int a = 0; a < nodes; a++) {
		const int node = lists->node[a][k];
		const double weight = lists->weight[a][k];
		const two of_node = *(const two *)grid->v_new[node];
		v += weight * *(const two *)grid->v[node];
		u += weight * of_node;
		if (parts & PART_STRAIN) {
			along_x += of_node * lists->grad_x[a][k];
			along_y += of_node * lists->grad_y[a][k];
		}
		if (parts & PART_FILTERED)
			filtered += weight * *(const two *)w->projected[node].sum;
		if (parts & PART_HEAT) {
			T_new += weight * grid->T_new[node];
			dT += weight * (grid->T_new[node] - grid->T[node]);
		}
	}
	*(two *)&g->v[k][0] = v, *(two *)&g->v[k][2] = u;
	if (parts & PART_STRAIN)
		*(four *)g->L[k] = (four){along_x[0], along_y[0], along_x[1], along_y[1]};
	if (parts & PART_FILTERED)
		*(two *)g->filtered[k] = filtered;
	if (parts & PART_HEAT)
		g->T_new[k] = T_new, g->dT[k] = dT;
}

/* What the points of a chunk become, and what they add to the sums: one row for each direction. */
struct moved {
	double v[SHAPE_CHUNK][2], x[SHAPE_CHUNK][2], F[SHAPE_CHUNK][4]; /* x: or the way owed */
	double increment[2][SHAPE_CHUNK], damped[2][SHAPE_CHUNK], carried[2][SHAPE_CHUNK], push[2][SHAPE_CHUNK];
} ALIGNED;

/* Velocity by eq. 26, position by eq. 27 with its sign put right: x moves with the mean of the remapped velocity
 * before the step and the particle's change, which makes the potential energy of gravity close, to the last bit
 * in free fall.  That holds for whatever changes the velocity, as long as it keeps the momentum of the grid, so it
 * is the rule of FLIP, XPIC and FMPM.  APIC's points go with their new velocity, as in its source: only a way along
 * the momentum leaves the angular momentum as it was (the mean turns a spinning body's momentum by dt^2/2 V x a in
 * every step).  They are half a step ahead of gravity then, which the ledger books.  (FMPM's source moves with the
 * mean of the point's own velocities; the Danilovskaya bar does not tell these rules apart.)
 * PIC, damping and the filter add d to FLIP's velocity; APIC is PIC in whole.
 * way: where the displacement goes, m.  v and x: what they have become. */
INLINE void move_points(const struct mpm_work *w, const struct particles *p, const struct lanes *lanes,
						const struct lanes *row, int k, double dt, int parts, const struct gathered *g,
						const double (*way)[2], struct moved *moved, vec v[2], vec x[2])
{
	const double of_grid = w->alpha_pic - w->alpha_g, of_point = w->alpha_pic + w->alpha_p;
	vec m = vec_of(p->mass, lanes), gathered[4], filtered[2] = {m, m};
	vec_of2((const double(*)[2])p->v, lanes, v);
	vec_of2(way, lanes, x);
	vec_of4((const double(*)[4])g->v, row, gathered);
	if (parts & PART_FILTERED)
		vec_of2((const double(*)[2])g->filtered, row, filtered);
	for (int c = 0; c < 2; c++) {
		vec gain = gathered[2 + c] - gathered[c], flip = v[c] + gain, change = gain;
		vec_store(&moved->increment[c][k], m * gain * gain);
		if (parts & (PART_DAMPED | PART_FILTERED | PART_AFFINE)) {
			vec d = of_grid * gathered[c] - of_point * v[c];
			if (parts & PART_FILTERED)
				d += w->filters_step ? filtered[c] - flip : filtered[c] - v[c];
			vec_store(&moved->damped[c][k], m * d * (flip + 0.5 * d));
			vec push = d;
			if (parts & PART_AFFINE)
				push = gain + 2.0 * d;
			vec_store(&moved->push[c][k], m * push);
			change += d;
		}
		if (parts & PART_AFFINE)
			vec_store(&moved->carried[c][k], m * v[c] * gain);
		v[c] += change;
		vec rate = gathered[c] + 0.5 * change;
		if (parts & PART_AFFINE)
			rate = v[c];
		x[c] += dt * rate;
	}
	vec_put2(moved->v[k], v[0], v[1]);
	vec_put2(moved->x[k], x[0], x[1]);
}

/* F by exp(L dt), in the order of deform(); false if its series does not serve all of them. */
INLINE bool deform_points(const struct particles *p, const struct lanes *lanes, const struct lanes *row, int k,
						  double dt, const struct gathered *g, struct moved *moved)
{
	vec A[4], F[4];
	vec_of4((const double(*)[4])g->L, row, A);
	vec_of4((const double(*)[4])p->F, lanes, F);
	for (int c = 0; c < 4; c++)
		A[c] *= dt;
	vec s = 0.5 * (A[0] + A[3]), d = 0.5 * (A[0] - A[3]), q2 = d * d + A[1] * A[2];
	vec es = EXP_SERIES(s), c = COSH_SERIES(q2), h = es * SINH_SERIES(q2);
	c *= es;
	vec e0 = c + h * d, e1 = h * A[1], e2 = h * A[2], e3 = c - h * d;
	for (int i = 0; i < 2; i++) {
		vec column[2] = {F[i], F[2 + i]};
		F[i] = e0 * column[0] + e1 * column[1], F[2 + i] = e2 * column[0] + e3 * column[1];
	}
	vec_put4(moved->F[k], F[0], F[1], F[2], F[3]);
	vec sum = F[0] + F[1] + F[2] + F[3];
	return !mask_any(mask_or(
		mask_above(vec_magnitude(s), vec_set(0.99 * SERIES_MOST)),
		mask_or(mask_above(vec_magnitude(q2), vec_set(0.99 * SERIES_MOST2)), mask_different(sum - sum, vec_set(0.0)))));
}

/* Are these points, which have moved to x with v, sound and in the grid? */
INLINE bool within(const struct mpm_work *w, const vec x[2], const vec v[2])
{
	const int cells[2] = {w->cells_x, w->cells_y};
	vec sum = x[0] + x[1] + v[0] + v[1];
	mask beyond = mask_different(sum - sum, vec_set(0.0));
	for (int c = 0; c < 2; c++) {
		vec f = (x[c] - w->shape_grid.origin[c]) * w->shape_grid.inverse_h[c];
		beyond = mask_or(beyond,
						 mask_or(mask_above(vec_set(GHOST_CELLS), f), mask_above(f, vec_set(cells[c] - GHOST_CELLS))));
	}
	return !mask_any(beyond);
}

/* The points' temperatures; false if one is no number. */
INLINE bool warm_points(struct mpm *mpm, struct mpm_work *w, const int *chunk, int n, const struct gathered *g)
{
	struct particles *p = &mpm->p;
	double all = 0.0;
	for (int k = 0; k < n; k++) {
		int q = chunk[k];
		if (w->freezes && w->freezing[p->material[q]].on)
			freezing_absorb(mpm, q, g->dT[k]);
		else
			p->T[q] += g->dT[k];                 /* eq. 28 */
		p->dT[q] = g->T_new[k] - p->T_smooth[q]; /* eq. 29 feeds the law only */
		p->T_smooth[q] = g->T_new[k];
		all += p->T[q];
	}
	return isfinite(all);
}

INLINE void add_sums(struct block_sum *sum, const struct moved *moved, int n, int parts)
{
	for (int k = 0; k < n; k++)
		for (int c = 0; c < 2; c++) {
			sum->increment += moved->increment[c][k];
			if (parts & (PART_DAMPED | PART_FILTERED | PART_AFFINE))
				sum->damped += moved->damped[c][k], sum->push[c] += moved->push[c][k];
			if (parts & PART_AFFINE)
				sum->carried += moved->carried[c][k];
		}
}

INLINE void gather_chunk(struct mpm *mpm, struct mpm_work *w, const struct shape_lists *lists, const int *chunk, int n,
						 int nodes, int parts, struct block_sum *sum)
{
	struct gathered g;
	struct moved moved;
	struct particles *p = &mpm->p;
	double(*way)[2] = parts & PART_STRAIN || !w->way ? p->x : w->way;
	bool plain = way == p->x;
	for (int k = 0; k < n; k++) {
		gather_point(&mpm->grid, w, lists, k, nodes, parts, &g);
		if (parts & PART_AFFINE)
			affine_gather(mpm, lists, k, chunk[k], side_of(nodes), 1.0 - w->alpha_p - w->alpha_g);
	}
	for (int k = 0; k < n; k += VECTOR_WIDTH) {
		const struct lanes lanes = lanes_of(n, chunk, k), row = lanes_in_row(n, k);
		vec v[2], x[2];
		move_points(w, p, &lanes, &row, k, mpm->dt, parts, &g, (const double(*)[2])way, &moved, v, x);
		plain = within(w, x, v) && plain;
		if (parts & PART_STRAIN)
			plain = deform_points(p, &lanes, &row, k, mpm->dt, &g, &moved) && plain;
	}
	for (int k = 0; k < n && p->damage; k++)
		plain = plain && p->damage[chunk[k]] < 1.0;
	if (parts & PART_HEAT)
		plain = warm_points(mpm, w, chunk, n, &g) && plain;
	for (int k = 0; k < n; k++) {
		int q = chunk[k];
		*(two *)p->v[q] = *(const two *)moved.v[k];
		*(two *)way[q] = *(const two *)moved.x[k];
		if (parts & PART_STRAIN) {
			*(four *)p->L[q] = *(const four *)g.L[k];
			if (plain)
				*(four *)p->F[q] = *(const four *)moved.F[k];
		}
		if (!(parts & PART_HEAT) && mpm->thermal)
			p->dT[q] = 0.0; /* a mechanical step between two thermal ones */
	}
	add_sums(sum, &moved, n, parts);
	for (int k = 0; k < n && !plain; k++) {
		if (parts & PART_STRAIN)
			deform_point(mpm, chunk[k], g.L[k]);
		check_moved(mpm, w, chunk[k], parts & PART_HEAT, sum);
	}
}

INLINE void gather_block(struct mpm *mpm, struct mpm_work *w, int block, int nodes, int parts)
{
	struct shape_lists lists;
	const int first = block * BLOCK_POINTS;
	const int last = first + BLOCK_POINTS < w->n_inside ? first + BLOCK_POINTS : w->n_inside;
	struct block_sum sum = {.bad = -1, .left = -1};
	for (int i = first; i < last; i += SHAPE_CHUNK) {
		const int *chunk = w->order + i, n = last - i < SHAPE_CHUNK ? last - i : SHAPE_CHUNK;
		mpm_lists(mpm, n, chunk, &lists);
		if (nodes == SHAPE_MAX_NODES && lists.nodes == 9)
			gather_chunk(mpm, w, &lists, chunk, n, 9, parts, &sum);
		else
			gather_chunk(mpm, w, &lists, chunk, n, nodes, parts, &sum);
	}
	w->block_sums[block] = sum;
}

/* As scatter_stripe_of().  With heat the damping is always looked at: a thermal step has other work to do. */
INLINE void gather_block_of(struct mpm *mpm, struct mpm_work *w, int block, int nodes, int parts)
{
	enum {
		FLIP = PART_STRAIN,
		DAMPED = FLIP | PART_DAMPED,
		HEAT = DAMPED | PART_HEAT,
		FILTERED = FLIP | PART_FILTERED,
		AFFINE = DAMPED | PART_AFFINE
	};
	if (parts == FLIP)
		gather_block(mpm, w, block, nodes, FLIP);
	else if (parts == DAMPED)
		gather_block(mpm, w, block, nodes, DAMPED);
	else if ((parts | PART_DAMPED) == HEAT)
		gather_block(mpm, w, block, nodes, HEAT);
	else if (parts == FILTERED)
		gather_block(mpm, w, block, nodes, FILTERED);
	else if (parts == AFFINE)
		gather_block(mpm, w, block, nodes, AFFINE);
	else
		gather_block(mpm, w, block, nodes, parts);
}

static void gather_block_any(struct mpm *mpm, struct mpm_work *w, int block)
{
	int nodes = mpm->shape->max_nodes;
	bool damped = w->alpha_pic != 0.0 || w->alpha_p != 0.0 || w->alpha_g != 0.0;
	int parts = (w->thermal_dt > 0.0 ? PART_HEAT : 0) | (damped ? PART_DAMPED : 0) | (w->filtered ? PART_FILTERED : 0) |
				(mpm->p.affine ? PART_AFFINE : 0) | (mpm->scene->mpm.order == MPM_USL ? PART_STRAIN : 0);
	if (nodes == 9)
		gather_block_of(mpm, w, block, 9, parts);
	else if (nodes == 4)
		gather_block_of(mpm, w, block, 4, parts);
	else
		gather_block_of(mpm, w, block, SHAPE_MAX_NODES, parts);
}
