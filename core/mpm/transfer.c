/* Points to grid, the nodes' step, grid to points (TM-DEMPM section 2). */
#include <math.h>
#include <string.h>

#include "base/mat2.h"
#include "mpm/point.h"

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

void mpm_clear_grid(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	int nx = mpm->grid.nx, rows = w->n_rows;
#pragma omp parallel for schedule(static) if (mpm_parallel(mpm))
	for (int j = 0; j < rows; j++) {
		int low = w->row_low[j], n = w->row_high[j] - low + 1;
		memset(mpm->grid.mass + (size_t)j * (size_t)nx, 0, (size_t)nx * sizeof *mpm->grid.mass);
		if (n <= 0)
			continue;
		size_t first = (size_t)j * (size_t)nx + (size_t)low;
		memset(w->sums + first, 0, (size_t)n * sizeof *w->sums);
		if (w->confining)
			memset(w->confining + first, 0, (size_t)n * sizeof *w->confining);
	}
}

INLINE void scatter_point(const struct mpm *mpm, struct mpm_work *w, const struct shape_lists *lists, int at, int p,
						  int nodes, int parts, double volume)
{
	const struct particles *points = &mpm->p;
	const double *s = points->stress[p];
	const double m = points->mass[p], px = m * points->v[p][0], py = m * points->v[p][1];
	const double fxx = -volume * s[0], fyy = -volume * s[1], fxy = -volume * s[3];
	const double capacity = parts & PART_HEAT ? m * points->capacity[p] : 0.0;
	const double content = parts & PART_HEAT ? capacity * points->T[p] : 0.0;
	for (int a = 0; a < nodes; a++) {
		double weight = lists->weight[at + a], gx = lists->grad_x[at + a], gy = lists->grad_y[at + a];
		struct node_sum *node = &w->sums[lists->node[at + a]];
		node->momentum[0] += weight * px;
		node->momentum[1] += weight * py;
		node->force[0] += gx * fxx + gy * fxy;
		node->force[1] += gx * fxy + gy * fyy;
		node->mass += weight * m;
		if (parts & PART_HEAT) {
			node->capacity += weight * capacity;
			node->heat += weight * content;
		}
		if (parts & PART_CONFINED) {
			w->confining[lists->node[at + a]][0] += gx * volume;
			w->confining[lists->node[at + a]][1] += gy * volume;
		}
	}
}

/* The momentum of a point's affine motion, which adds up to none. */
INLINE void scatter_affine(const struct mpm *mpm, struct mpm_work *w, const struct shape_lists *lists, int at, int p,
						   int side)
{
	double r[2], C[4], m = mpm->p.mass[p];
	first_node(mpm, lists, at, p, r);
	affine_matrix(mpm, lists, at, p, side, r, C);
	for (int a = 0; a < side * side; a++) {
		double x[2], wm = lists->weight[at + a] * m;
		struct node_sum *node = &w->sums[lists->node[at + a]];
		node_of_list(mpm, r, a, side, x);
		node->momentum[0] += wm * (C[0] * x[0] + C[1] * x[1]);
		node->momentum[1] += wm * (C[2] * x[0] + C[3] * x[1]);
	}
}

/* What bounds the step, whether the state is sound, and the power of the stress. */
INLINE void check_point(const struct mpm *mpm, struct stripe_sum *sum, int p, double volume)
{
	const struct particles *points = &mpm->p;
	double stiffness = points->modulus[p] * volume / points->mass[p];
	sum->power += stress_power(points->stress[p], points->L[p], volume);
	if (stiffness > sum->stiffness)
		sum->stiffness = stiffness, sum->stiffest = p;
	if (!(finite4(points->stress[p]) && isfinite(stiffness)) && sum->bad < 0)
		sum->bad = p;
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
	const struct particles *points = &mpm->p;
	for (int k = 0; k < n; k++) {
		double volume = mat2_determinant(points->F[chunk[k]]) * points->volume0[chunk[k]];
		check_point(mpm, sum, chunk[k], volume);
		if (parts & PART_HEAT)
			check_point_heat(mpm, sum, chunk[k], volume);
		scatter_point(mpm, w, lists, k * nodes, chunk[k], nodes, parts, volume);
		if (parts & PART_AFFINE)
			scatter_affine(mpm, w, lists, k * nodes, chunk[k], side_of(nodes));
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

void mpm_each_stripe(struct mpm *mpm, void (*scatter)(struct mpm *, struct mpm_work *, int))
{
	struct mpm_work *w = mpm_work(mpm);
	for (int parity = 0; parity < 2; parity++) {
#pragma omp parallel for schedule(dynamic) if (mpm_parallel(mpm))
		for (int stripe = parity; stripe < w->n_stripes; stripe += 2)
			scatter(mpm, w, stripe);
	}
}

void mpm_points_to_grid(struct mpm *mpm) { mpm_each_stripe(mpm, scatter_stripe_any); }

/* ---- nodes ---- */

/* The step of the free nodes; walls come after it. */
static void integrate_row(struct mpm *mpm, struct mpm_work *w, int j)
{
	struct grid *grid = &mpm->grid;
	const double *g = mpm->scene->gravity;
	const double dt = mpm->dt, scale = w->internal_force_scale, confining = mpm->scene->mpm.confining_pressure;
	for (int i = w->row_low[j]; i <= w->row_high[j]; i++) {
		size_t node = (size_t)j * (size_t)grid->nx + (size_t)i;
		const struct node_sum *sum = &w->sums[node];
		grid->mass[node] = sum->mass;
		for (int c = 0; c < 2; c++) {
			if (!(sum->mass > 0.0)) {
				grid->v[node][c] = grid->v_new[node][c] = grid->force[node][c] = 0.0;
				continue;
			}
			double f = scale * sum->force[c] + sum->mass * g[c];
			if (w->confining)
				f -= confining * w->confining[node][c];
			if (w->body_force)
				f += w->body_force[node][c];
			grid->force[node][c] = f;
			grid->v[node][c] = sum->momentum[c] / sum->mass;
			grid->v_new[node][c] = grid->v[node][c] + f / sum->mass * dt;
		}
	}
}

/* Imposed velocities come last and win over everything else. */
static void impose_velocities(struct mpm *mpm, struct mpm_work *w, int j)
{
	for (int i = w->row_low[j]; i <= w->row_high[j]; i++) {
		size_t node = (size_t)j * (size_t)mpm->grid.nx + (size_t)i;
		for (int c = 0; c < 2; c++) {
			double u = w->fixed_v[node][c];
			w->fixed_push[node][c] = 0.0;
			if (isnan(u) || !(mpm->grid.mass[node] > 0.0))
				continue;
			w->fixed_push[node][c] = mpm->grid.mass[node] * (u - mpm->grid.v_new[node][c]);
			mpm->grid.v_new[node][c] = u;
		}
	}
}

void mpm_integrate_nodes(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
#pragma omp parallel for schedule(static) if (mpm_parallel(mpm))
	for (int j = 0; j < w->n_rows; j++)
		integrate_row(mpm, w, j);
	if (w->contact)
		contact_apply(mpm);
	walls_apply(mpm);
	if (!w->fixed_v)
		return;
#pragma omp parallel for schedule(static) if (mpm_parallel(mpm))
	for (int j = 0; j < w->n_rows; j++)
		impose_velocities(mpm, w, j);
}

/* The nodes' share of the ledger, from the velocities as they became: the kinetic energy of the grid
 * changes by the forces' impulses times the mean velocity, exactly. */
static struct row_sum finish_row(const struct mpm *mpm, const struct mpm_work *w, int j)
{
	struct row_sum sum = {0};
	const struct grid *grid = &mpm->grid;
	const double *g = mpm->scene->gravity, confining = mpm->scene->mpm.confining_pressure;
	const bool strain_apart = mpm->scene->mpm.order != MPM_USL, affine = mpm->p.affine != NULL;
	for (int i = w->row_low[j]; i <= w->row_high[j]; i++) {
		size_t node = (size_t)j * (size_t)grid->nx + (size_t)i;
		for (int c = 0; c < 2; c++) {
			double dv = grid->v_new[node][c] - grid->v[node][c], mean = 0.5 * (grid->v_new[node][c] + grid->v[node][c]);
			sum.increment += grid->mass[node] * dv * dv;
			sum.power -= w->sums[node].force[c] * grid->v[node][c];
			if (strain_apart)
				sum.power -= w->sums[node].force[c] * grid->v_new[node][c];
			if (affine)
				sum.carried += grid->mass[node] * grid->v[node][c] * dv;
			sum.gravity += grid->mass[node] * g[c] * mean * mpm->dt;
			if (w->confining && grid->mass[node] > 0.0)
				sum.confining -= confining * w->confining[node][c] * mean * mpm->dt;
			if (w->body_force)
				sum.motion += w->body_force[node][c] * mean * mpm->dt;
			if (w->fixed_v && !isnan(w->fixed_v[node][c])) {
				sum.velocity_work += w->fixed_push[node][c] * w->fixed_v[node][c];
				sum.velocity_loss -= w->fixed_push[node][c] * (mean - w->fixed_v[node][c]);
			}
		}
	}
	return sum;
}

void mpm_finish_nodes(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
#pragma omp parallel for schedule(static) if (mpm_parallel(mpm))
	for (int j = 0; j < w->n_rows; j++)
		w->row_sums[j] = finish_row(mpm, w, j);
	walls_account(mpm);
	if (w->contact)
		contact_account(mpm);
}

/* ---- grid to points ---- */

struct gathered {
	double v[2], v_new[2]; /* m/s */
	double v_filtered[2];  /* m/s, of XPIC and FMPM */
	double L[4];           /* 1/s */
	double T_new, dT;      /* K */
};

INLINE struct gathered gather_point(const struct grid *grid, const struct mpm_work *w, const struct shape_lists *lists,
									int at, int nodes, int parts)
{
	struct gathered g = {0};
	for (int a = 0; a < nodes; a++) {
		int node = lists->node[at + a];
		double weight = lists->weight[at + a], gx = lists->grad_x[at + a], gy = lists->grad_y[at + a];
		const double *v = grid->v[node], *u = grid->v_new[node];
		g.v[0] += weight * v[0];
		g.v[1] += weight * v[1];
		g.v_new[0] += weight * u[0];
		g.v_new[1] += weight * u[1];
		if (parts & PART_STRAIN) {
			g.L[0] += u[0] * gx;
			g.L[2] += u[1] * gx;
			g.L[1] += u[0] * gy;
			g.L[3] += u[1] * gy;
		}
		if (parts & PART_FILTERED) {
			g.v_filtered[0] += weight * w->projected[node].sum[0];
			g.v_filtered[1] += weight * w->projected[node].sum[1];
		}
		if (parts & PART_HEAT) {
			g.T_new += weight * grid->T_new[node];
			g.dT += weight * (grid->T_new[node] - grid->T[node]);
		}
	}
	return g;
}

/* What PIC, damping and the filter add to FLIP's velocity of a point, m/s (eq. 26).  APIC is PIC in whole. */
INLINE double correction(const struct gathered *g, const struct mpm_work *w, int c, double v, double flip, int parts)
{
	double d = (w->alpha_pic - w->alpha_g) * g->v[c] - (w->alpha_pic + w->alpha_p) * v;
	if (parts & PART_FILTERED)
		d += g->v_filtered[c] - (w->filters_step ? flip : v);
	return d;
}

/* Velocity by eq. 26, position by eq. 27 with its sign put right: x moves with the mean of the remapped velocity
 * before the step and the particle's change, which makes the potential energy of gravity close, to the last bit
 * in free fall.  That holds for whatever changes the velocity, as long as it keeps the momentum of the grid, so it
 * is the rule of FLIP, XPIC and FMPM.  APIC's points go with their new velocity, as in its source: only a way along
 * the momentum leaves the angular momentum as it was (the mean turns a spinning body's momentum by dt^2/2 V x a in
 * every step).  They are half a step ahead of gravity then, which the ledger books.  (FMPM's source moves with the
 * mean of the point's own velocities; the Danilovskaya bar does not tell these rules apart.)
 * way: where the displacement goes, m. */
INLINE void move_point(struct particles *p, int k, const struct gathered *g, const struct mpm_work *w, double dt,
					   int parts, double way[2], struct block_sum *sum)
{
	double m = p->mass[k];
	for (int c = 0; c < 2; c++) {
		double v = p->v[k][c], gain = g->v_new[c] - g->v[c], flip = v + gain, change = gain;
		sum->increment += m * gain * gain;
		if (parts & (PART_DAMPED | PART_FILTERED | PART_AFFINE)) {
			double d = correction(g, w, c, v, flip, parts);
			sum->damped += m * d * (flip + 0.5 * d);
			sum->push[c] += parts & PART_AFFINE ? m * (gain + 2.0 * d) : m * d;
			change += d;
		}
		if (parts & PART_AFFINE)
			sum->carried += m * v * gain;
		p->v[k][c] = v + change;
		way[c] += dt * (parts & PART_AFFINE ? v + change : g->v[c] + 0.5 * change);
	}
}

void point_park(struct particles *p, int k, struct block_sum *sum)
{
	sum->discarded += 0.5 * p->mass[k] * (p->v[k][0] * p->v[k][0] + p->v[k][1] * p->v[k][1]);
	point_stop(p, k);
	memset(p->L[k], 0, sizeof p->L[k]);
	p->dT[k] = 0.0;
}

INLINE void gather_chunk(struct mpm *mpm, struct mpm_work *w, const struct shape_lists *lists, const int *chunk, int n,
						 int nodes, int parts, struct block_sum *sum)
{
	struct particles *p = &mpm->p;
	const double dt = mpm->dt;
	for (int k = 0; k < n; k++) {
		int q = chunk[k];
		struct gathered g = gather_point(&mpm->grid, w, lists, k * nodes, nodes, parts);
		if (parts & PART_AFFINE)
			affine_gather(mpm, lists, k * nodes, q, side_of(nodes), 1.0 - w->alpha_p - w->alpha_g);
		move_point(p, q, &g, w, dt, parts, parts & PART_STRAIN || !w->way ? p->x[q] : w->way[q], sum);
		if (parts & PART_STRAIN) {
			memcpy(p->L[q], g.L, sizeof g.L);
			deform_point(mpm, q, g.L);
		}
		if (parts & PART_HEAT) {
			if (w->freezes && w->freezing[p->material[q]].on)
				freezing_absorb(mpm, q, g.dT);
			else
				p->T[q] += g.dT;                 /* eq. 28 */
			p->dT[q] = g.T_new - p->T_smooth[q]; /* eq. 29 feeds the law only */
			p->T_smooth[q] = g.T_new;
		} else if (mpm->thermal) {
			p->dT[q] = 0.0; /* a mechanical step between two thermal ones */
		}
		check_moved(mpm, w, q, parts & PART_HEAT, sum);
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

void mpm_grid_to_points(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
#pragma omp parallel for schedule(static) if (mpm_parallel(mpm))
	for (int block = 0; block < w->n_blocks; block++)
		gather_block_any(mpm, w, block);
}
