/* Points to grid, the nodes' step, grid to points (TM-DEMPM section 2; order USL). */
#include <math.h>
#include <string.h>

#include "base/mat2.h"
#include "mpm/mpm_private.h"

#define INLINE static inline __attribute__((always_inline))

/* ---- points to grid ---- */

void mpm_clear_grid(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	int nx = mpm->grid.nx, ny = mpm->grid.ny;
#pragma omp parallel for schedule(static) if (mpm_parallel(mpm))
	for (int j = 0; j < ny; j++) {
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

/* Is everything that the force needs a number?  The sum of the parts is one only if all are. */
INLINE bool finite4(const double a[4]) { return isfinite(a[0] + a[1] + a[2] + a[3]); }

INLINE void scatter_point(const struct mpm *mpm, struct mpm_work *w, const struct shape_lists *lists, int at, int p,
						  int nodes, bool heat, bool confined, double volume)
{
	const struct particles *points = &mpm->p;
	const double *s = points->stress[p];
	const double m = points->mass[p], px = m * points->v[p][0], py = m * points->v[p][1];
	const double fxx = -volume * s[0], fyy = -volume * s[1], fxy = -volume * s[3];
	const double capacity = heat ? m * points->capacity[p] : 0.0, content = heat ? capacity * points->T[p] : 0.0;
	for (int a = 0; a < nodes; a++) {
		double weight = lists->weight[at + a], gx = lists->grad_x[at + a], gy = lists->grad_y[at + a];
		struct node_sum *node = &w->sums[lists->node[at + a]];
		node->momentum[0] += weight * px;
		node->momentum[1] += weight * py;
		node->force[0] += gx * fxx + gy * fxy;
		node->force[1] += gx * fxy + gy * fyy;
		node->mass += weight * m;
		if (heat) {
			node->capacity += weight * capacity;
			node->heat += weight * content;
		}
		if (confined) {
			w->confining[lists->node[at + a]][0] += gx * volume;
			w->confining[lists->node[at + a]][1] += gy * volume;
		}
	}
}

/* What bounds the step, whether the state is sound, and the power of the stress. */
INLINE void check_point(const struct mpm *mpm, struct stripe_sum *sum, int p, double volume)
{
	const struct particles *points = &mpm->p;
	const double *s = points->stress[p], *L = points->L[p];
	double stiffness = points->modulus[p] * volume / points->mass[p];
	sum->power += volume * (s[0] * L[0] + s[3] * (L[1] + L[2]) + s[1] * L[3]);
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

INLINE void scatter_stripe(const struct mpm *mpm, struct mpm_work *w, int stripe, int nodes, bool heat, bool confined)
{
	struct shape_lists lists;
	const struct particles *points = &mpm->p;
	int rows = w->cells_y, from = stripe * STRIPE_ROWS, to = from + STRIPE_ROWS < rows ? from + STRIPE_ROWS : rows;
	int first = w->cell_first[from * w->cells_x], last = w->cell_first[to * w->cells_x];
	struct stripe_sum sum = {.stiffest = -1, .most_diffusive = -1, .bad = -1};
	for (int i = first; i < last; i += SHAPE_CHUNK) {
		const int *chunk = w->order + i, n = last - i < SHAPE_CHUNK ? last - i : SHAPE_CHUNK;
		mpm->shape->fill(&w->shape_grid, n, chunk, (const double(*)[2])points->x, points->body, w->half, &lists);
		for (int k = 0; k < n; k++) {
			double volume = mat2_determinant(points->F[chunk[k]]) * points->volume0[chunk[k]];
			check_point(mpm, &sum, chunk[k], volume);
			if (heat)
				check_point_heat(mpm, &sum, chunk[k], volume);
			scatter_point(mpm, w, &lists, k * nodes, chunk[k], nodes, heat, confined, volume);
		}
	}
	w->stripe_sums[stripe] = sum;
}

/* One copy of the loop for each shape and set of passes, so that the inner loops have fixed lengths. */
static void scatter_stripe_any(const struct mpm *mpm, struct mpm_work *w, int stripe)
{
	int nodes = mpm->shape->max_nodes;
	bool heat = w->thermal_dt > 0.0;
	if (w->confining)
		scatter_stripe(mpm, w, stripe, nodes, heat, true);
	else if (nodes == 9 && heat)
		scatter_stripe(mpm, w, stripe, 9, true, false);
	else if (nodes == 9)
		scatter_stripe(mpm, w, stripe, 9, false, false);
	else if (nodes == 4 && heat)
		scatter_stripe(mpm, w, stripe, 4, true, false);
	else if (nodes == 4)
		scatter_stripe(mpm, w, stripe, 4, false, false);
	else
		scatter_stripe(mpm, w, stripe, nodes, heat, false);
}

void mpm_points_to_grid(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	for (int parity = 0; parity < 2; parity++) {
#pragma omp parallel for schedule(dynamic) if (mpm_parallel(mpm))
		for (int stripe = parity; stripe < w->n_stripes; stripe += 2)
			scatter_stripe_any(mpm, w, stripe);
	}
}

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
	for (int j = 0; j < mpm->grid.ny; j++)
		integrate_row(mpm, w, j);
	walls_apply(mpm);
	if (!w->fixed_v)
		return;
#pragma omp parallel for schedule(static) if (mpm_parallel(mpm))
	for (int j = 0; j < mpm->grid.ny; j++)
		impose_velocities(mpm, w, j);
}

/* The nodes' share of the ledger, from the velocities as they became: the kinetic energy of the grid
 * changes by the forces' impulses times the mean velocity, exactly. */
static struct row_sum finish_row(const struct mpm *mpm, const struct mpm_work *w, int j)
{
	struct row_sum sum = {0};
	const struct grid *grid = &mpm->grid;
	const double *g = mpm->scene->gravity, confining = mpm->scene->mpm.confining_pressure;
	for (int i = w->row_low[j]; i <= w->row_high[j]; i++) {
		size_t node = (size_t)j * (size_t)grid->nx + (size_t)i;
		for (int c = 0; c < 2; c++) {
			double dv = grid->v_new[node][c] - grid->v[node][c], mean = 0.5 * (grid->v_new[node][c] + grid->v[node][c]);
			sum.increment += grid->mass[node] * dv * dv;
			sum.power -= w->sums[node].force[c] * grid->v[node][c];
			sum.gravity += grid->mass[node] * g[c] * mean * mpm->dt;
			if (w->confining && grid->mass[node] > 0.0)
				sum.confining -= confining * w->confining[node][c] * mean * mpm->dt;
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
	for (int j = 0; j < mpm->grid.ny; j++)
		w->row_sums[j] = finish_row(mpm, w, j);
	walls_account(mpm);
}

/* ---- grid to points ---- */

struct gathered {
	double v[2], v_new[2]; /* m/s */
	double L[4];           /* 1/s */
	double T_new, dT;      /* K */
};

INLINE struct gathered gather_point(const struct grid *grid, const struct shape_lists *lists, int at, int nodes,
									bool heat)
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
		g.L[0] += u[0] * gx;
		g.L[2] += u[1] * gx;
		g.L[1] += u[0] * gy;
		g.L[3] += u[1] * gy;
		if (heat) {
			g.T_new += weight * grid->T_new[node];
			g.dT += weight * (grid->T_new[node] - grid->T[node]);
		}
	}
	return g;
}

/* exp(A) F.  The series serves the small increments of a stable step to the last bit or so, without a call to
 * the maths library; what lies outside goes the general way. */
INLINE void deform(double F[4], const double L[4], double dt)
{
	double A[4] = {L[0] * dt, L[1] * dt, L[2] * dt, L[3] * dt}, e[4];
	double s = 0.5 * (A[0] + A[3]), d = 0.5 * (A[0] - A[3]), q2 = d * d + A[1] * A[2];
	if (fabs(s) < 0.01 && fabs(q2) < 1e-4) {
		double es =
			1.0 + s * (1.0 + s * (1.0 / 2 + s * (1.0 / 6 + s * (1.0 / 24 + s * (1.0 / 120 + s * (1.0 / 720))))));
		double c = 1.0 + q2 * (1.0 / 2 + q2 * (1.0 / 24 + q2 * (1.0 / 720 + q2 * (1.0 / 40320))));
		double k = es * (1.0 + q2 * (1.0 / 6 + q2 * (1.0 / 120 + q2 * (1.0 / 5040 + q2 * (1.0 / 362880)))));
		c *= es;
		e[0] = c + k * d, e[1] = k * A[1], e[2] = k * A[2], e[3] = c - k * d;
	} else {
		mat2_exp(A, e);
	}
	mat2_multiply(e, F, F);
}

/* Velocity by eq. 26, position by eq. 27 with its sign put right: x moves with the mean of the remapped
 * velocity before the step and the particle's change, which makes the potential energy of gravity close. */
INLINE void move_point(struct particles *p, int k, const struct gathered *g, const struct mpm_work *w, double dt,
					   bool damped, struct block_sum *sum)
{
	double m = p->mass[k];
	for (int c = 0; c < 2; c++) {
		double v = p->v[k][c], gain = g->v_new[c] - g->v[c], flip = v + gain, change = gain;
		sum->increment += m * gain * gain;
		if (damped) {
			double d = (w->alpha_pic - w->alpha_g) * g->v[c] - (w->alpha_pic + w->alpha_p) * v;
			sum->damped += m * d * (flip + 0.5 * d);
			sum->push[c] += m * d;
			change += d;
		}
		p->v[k][c] = v + change;
		p->x[k][c] += dt * (g->v[c] + 0.5 * change);
	}
}

static bool inside(const struct mpm_work *w, const double x[2])
{
	const double *s = w->shape_grid.inverse_h;
	double fx = (x[0] - w->shape_grid.origin[0]) * s[0], fy = (x[1] - w->shape_grid.origin[1]) * s[1];
	return fx >= GHOST_CELLS && fy >= GHOST_CELLS && fx <= w->cells_x - GHOST_CELLS && fy <= w->cells_y - GHOST_CELLS;
}

/* Beyond the grid: parked, without motion, where it is. */
static void park_point(struct particles *p, int k, struct block_sum *sum)
{
	sum->discarded += 0.5 * p->mass[k] * (p->v[k][0] * p->v[k][0] + p->v[k][1] * p->v[k][1]);
	memset(p->v[k], 0, sizeof p->v[k]);
	memset(p->L[k], 0, sizeof p->L[k]);
	p->dT[k] = 0.0;
}

INLINE void gather_block(struct mpm *mpm, struct mpm_work *w, int block, int nodes, bool heat, bool damped)
{
	struct shape_lists lists;
	struct particles *p = &mpm->p;
	const double dt = mpm->dt;
	int first = block * BLOCK_POINTS, last = first + BLOCK_POINTS < w->n_inside ? first + BLOCK_POINTS : w->n_inside;
	struct block_sum sum = {.bad = -1, .left = -1};
	for (int i = first; i < last; i += SHAPE_CHUNK) {
		const int *chunk = w->order + i, n = last - i < SHAPE_CHUNK ? last - i : SHAPE_CHUNK;
		mpm->shape->fill(&w->shape_grid, n, chunk, (const double(*)[2])p->x, p->body, w->half, &lists);
		for (int k = 0; k < n; k++) {
			int q = chunk[k];
			struct gathered g = gather_point(&mpm->grid, &lists, k * nodes, nodes, heat);
			move_point(p, q, &g, w, dt, damped, &sum);
			memcpy(p->L[q], g.L, sizeof g.L);
			deform(p->F[q], g.L, dt);
			if (heat) {
				if (w->freezes && w->freezing[p->material[q]].on)
					freezing_absorb(mpm, q, g.dT);
				else
					p->T[q] += g.dT;                 /* eq. 28 */
				p->dT[q] = g.T_new - p->T_smooth[q]; /* eq. 29 feeds the law only */
				p->T_smooth[q] = g.T_new;
			} else if (mpm->thermal) {
				p->dT[q] = 0.0; /* a mechanical step between two thermal ones */
			}
			if (!isfinite(p->x[q][0] + p->x[q][1] + p->v[q][0] + p->v[q][1]) || !finite4(p->F[q]) ||
				(heat && !isfinite(p->T[q])))
				sum.bad = sum.bad < 0 ? q : sum.bad;
			else if (!inside(w, p->x[q])) {
				sum.left = sum.left < 0 ? q : sum.left;
				if (!mpm->scene->guards.points_leaving)
					park_point(p, q, &sum);
			}
		}
	}
	w->block_sums[block] = sum;
}

static void gather_block_any(struct mpm *mpm, struct mpm_work *w, int block)
{
	int nodes = mpm->shape->max_nodes;
	bool heat = w->thermal_dt > 0.0, damped = w->alpha_pic != 0.0 || w->alpha_p != 0.0 || w->alpha_g != 0.0;
	if (nodes == 9 && heat)
		gather_block(mpm, w, block, 9, true, true);
	else if (nodes == 9 && damped)
		gather_block(mpm, w, block, 9, false, true);
	else if (nodes == 9)
		gather_block(mpm, w, block, 9, false, false);
	else if (nodes == 4 && heat)
		gather_block(mpm, w, block, 4, true, true);
	else if (nodes == 4)
		gather_block(mpm, w, block, 4, false, damped);
	else
		gather_block(mpm, w, block, nodes, heat, true);
}

void mpm_grid_to_points(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
#pragma omp parallel for schedule(static) if (mpm_parallel(mpm))
	for (int block = 0; block < w->n_blocks; block++)
		gather_block_any(mpm, w, block);
}
