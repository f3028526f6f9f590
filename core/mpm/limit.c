/* Where the explicit step is stable: it depends on where the points lie in their grid cells.
 *
 * On given places the nodes' motion obeys m dv/dt = - K u with K = sum V G^T C G of the points.  With the largest
 * eigenvalue w^2 of K/m and X = (dt w)^2, a mode of the order USL with FLIP is multiplied in a step by the roots z of
 *     z^2 - (2 - X) z + 1 - (1 - q) X = 0,
 * q in 0..1 being what is left of a change of that mode when it went to the points and back (consistent over lumped
 * mass): stable while X < 4 / (2 - q).  A finite element has q = 1 and X < 4, which is dt < h sqrt(rho/M); a mode that
 * only one point carries has q = 0, and X < 2 is what is always safe.  USF and MUSL are stable while q X < 4: what
 * makes X large makes q small, and h sqrt(rho/M) is safe wherever the points lie, also with the linear shape.  But APIC
 * and FMPM(m) give (almost) all of a change back to the nodes: X < 4 is what is safe with them.
 *
 * X is bounded point by point.  In one direction the eigenvalues of K/m are those of A_pq = sum_I dw_pI dw_qI V_q
 * M_q/m_I between points, and for any positive weights x none of them is above the largest of (|A| x)_p / x_p
 * (Collatz): with x = 1, and if that says too much with x = |A| x a few times.  Nodes whose velocity is imposed do not
 * count.  The two directions b, c are coupled by the ratio r = lambda/M of the law as the normal strains of a point by
 * itself are, (b + c)/2 + sqrt((b - c)^2/4 + r^2 b c), which is exact for such a point.  Against the spectral radius of
 * whole steps of blocks, lone points and heaps the limit that follows is never above the true one
 * (tests/stability/test_time_step.c).
 *
 * The linear shape has no bound of its own: a node that a point has just begun to touch has next to no mass, and a
 * point that enters a grid cell calls for a look.  What counts is how long that lasts: the growth of the point's
 * stress, the product of X - 1 over the steps in which X is above 2, is kept with the point, and only a growth by
 * GROWTH_MOST stops the run.  A surface that moves at v with C = c dt/h lets it grow by 4^N in N = C c/2v steps.
 *
 * Heat that flows in several passes between two remappings obeys dT/dt = - A T on the nodes, stable while dt times the
 * largest eigenvalue of A is below 2: the same sums with k for M and heat capacity for mass, without coupling.
 * In a single pass the points' remapping tames the small nodes, and the limit of the lumped Q4 (guard.c) is enough. */
#include <math.h>
#include <string.h>

#include "base/mat2.h"
#include "mpm/mpm_private.h"

enum {
	LIMIT_STEPS = 16, /* between two looks while all is well */
	LIMIT_SWEEPS = 5  /* at most, for a sharper bound */
};
static const double WATCH = 2.0; /* from this X on every step is looked at */

#define INLINE static inline __attribute__((always_inline))

/* ---- is a look needed? ---- */

/* What X is multiplied by, so that 2 is the limit; 0 = h sqrt(rho/M) is enough. */
static double severity(const struct scene_mpm *s)
{
	if (s->order == MPM_USL)
		return 1.0;
	return s->transfer == MPM_APIC || s->transfer == MPM_FMPM ? 0.5 : 0.0;
}

/* The factor s in X <= s (dt/h)^2 M/rho for any places of the points: INFINITY where the shape has no such bound. */
static double worst_place(const struct mpm *mpm)
{
	double worst = 0.0, coupling = 0.0;
	for (int b = 0; b < mpm->scene->n_bodies; b++)
		worst = fmax(worst, mpm->shape->lone(mpm_work(mpm)->half[b]));
	for (int l = 0; l < mpm->n_laws; l++)
		coupling = fmax(coupling, mpm->laws[l]->coupling);
	return worst * (1.0 + coupling);
}

bool limit_due(const struct mpm *mpm)
{
	const struct mpm_work *w = mpm_work(mpm);
	const double b = mpm->scene->time.step_factor, k = mpm->dt / fmin(mpm->grid.spacing[0], mpm->grid.spacing[1]);
	double stiffness = 0.0;
	if (mpm->step % LIMIT_STEPS != 0 && w->total.limit_watched == 0.0)
		return false;
	for (int s = 0; s < w->n_stripes; s++)
		stiffness = fmax(stiffness, w->stripe_sums[s].stiffness);
	double share = severity(&mpm->scene->mpm);
	bool motion =
		mpm->scene->guards.time_step && share > 0.0 && share * worst_place(mpm) * stiffness * k * k > 2.0 * b * b;
	bool heat = mpm->scene->guards.thermal_step && w->thermal_dt > 0.0 && mpm->scene->time.thermal_steps > 1;
	return motion || heat;
}

void limit_follow(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	if (isfinite(mpm->shape->lone(0.25)) || w->total.limit_watched != 0.0 || severity(&mpm->scene->mpm) == 0.0)
		return;
	bool entered = false;
	for (int k = 0; k < mpm->p.n && !entered; k++)
		entered = mpm_cell_of(w, mpm->p.x[k]) != w->cell[k];
	w->total.limit_watched = entered ? 1.0 : 0.0;
}

/* ---- the sums ---- */

/* What a point brings to R of its nodes. */
INLINE void scatter_rigidity(struct mpm_work *w, const struct shape_lists *lists, int k, const double motion[2],
							 double heat)
{
	for (int a = 0; a < lists->nodes; a++) {
		double gx = fabs(lists->grad_x[a][k]), gy = fabs(lists->grad_y[a][k]);
		struct limit_node *node = &w->limit_nodes[lists->node[a][k]];
		node->motion[0] += gx * motion[0];
		node->motion[1] += gy * motion[1];
		node->heat[0] += gx * heat;
		node->heat[1] += gy * heat;
	}
}

static void scatter_stripe(struct mpm *mpm, struct mpm_work *w, int stripe)
{
	struct shape_lists lists;
	const struct particles *p = &mpm->p;
	int first, last;
	mpm_stripe_points(w, stripe, &first, &last);
	for (int i = first; i < last; i += SHAPE_CHUNK) {
		const int *chunk = w->order + i, n = last - i < SHAPE_CHUNK ? last - i : SHAPE_CHUNK;
		mpm_lists(mpm, n, chunk, &lists);
		for (int k = 0; k < n; k++) {
			int q = chunk[k];
			double volume = mat2_determinant(p->F[q]) * p->volume0[q], stiffness = volume * p->modulus[q];
			const double *x = w->limit_points[q].weight, motion[2] = {stiffness * x[0], stiffness * x[1]};
			double heat = w->thermal_dt > 0.0 ? mpm_conductance(mpm, q, volume) : 0.0;
			scatter_rigidity(w, &lists, k, motion, heat);
		}
	}
}

/* Over mass and heat capacity; what is imposed does not move. */
static void finish_row(const struct mpm *mpm, struct mpm_work *w, int j)
{
	for (int i = w->row_low[j]; i <= w->row_high[j]; i++) {
		size_t node = (size_t)j * (size_t)mpm->grid.nx + (size_t)i;
		const struct node_sum *sum = &w->sums[node];
		struct limit_node *limit = &w->limit_nodes[node];
		bool fixed_T = w->fixed_T && !isnan(w->fixed_T[node]);
		for (int c = 0; c < 2; c++) {
			bool fixed = w->fixed_v && !isnan(w->fixed_v[node][c]);
			limit->motion[c] = sum->mass > 0.0 && !fixed ? limit->motion[c] / sum->mass : 0.0;
			limit->heat[c] = sum->capacity > 0.0 && !fixed_T ? limit->heat[c] / sum->capacity : 0.0;
		}
	}
}

/* Walls that tie nodes both ways, along the axes of the grid. */
static void hold_at_walls(const struct mpm *mpm, struct mpm_work *w)
{
	for (int e = 0; e < w->n_wall_nodes; e++) {
		const struct wall_node *contact = &w->wall_nodes[e];
		enum scene_wall_contact kind = mpm->scene->walls[contact->wall].contact;
		for (int c = 0; c < 2; c++)
			if (kind == SCENE_WALL_STICK ||
				(kind == SCENE_WALL_SLIP && contact->normals == 1 && fabs(contact->normal[0][c]) > 1.0 - 1e-12))
				w->limit_nodes[contact->node].motion[c] = 0.0;
	}
}

/* Two row sums and their coupling. */
INLINE double coupled(double b, double c, double r)
{
	double half = 0.5 * (b - c);
	return 0.5 * (b + c) + sqrt(half * half + r * r * b * c);
}

static void judge_point(const struct mpm *mpm, struct mpm_work *w, const struct shape_lists *lists, int k, int p,
						struct limit_sum *sum)
{
	struct limit_point *point = &w->limit_points[p];
	double motion[2] = {0.0, 0.0}, heat[2] = {0.0, 0.0}, row[2];
	for (int a = 0; a < lists->nodes; a++) {
		double gx = fabs(lists->grad_x[a][k]), gy = fabs(lists->grad_y[a][k]);
		const struct limit_node *node = &w->limit_nodes[lists->node[a][k]];
		motion[0] += gx * node->motion[0], motion[1] += gy * node->motion[1];
		heat[0] += gx * node->heat[0], heat[1] += gy * node->heat[1];
	}
	for (int c = 0; c < 2; c++) {
		row[c] = mpm->p.modulus[p] > 0.0 && point->weight[c] > 0.0 ? motion[c] / point->weight[c] : 0.0;
		point->weight[c] = motion[c];
	}
	double step = mpm->dt / mpm->scene->time.step_factor;
	point->X = severity(&mpm->scene->mpm) * step * step * coupled(row[0], row[1], mpm->laws[mpm->p.law[p]]->coupling);
	double Y = w->thermal_dt / mpm->scene->time.thermal_steps * fmax(heat[0], heat[1]);
	if (point->X > sum->motion)
		sum->motion = point->X, sum->stiffest = p;
	if (Y > sum->heat)
		sum->heat = Y, sum->hottest = p;
}

static struct limit_sum judge_stripe(const struct mpm *mpm, struct mpm_work *w, int stripe)
{
	struct shape_lists lists;
	struct limit_sum sum = {.stiffest = -1, .grown = -1, .hottest = -1};
	int first, last;
	mpm_stripe_points(w, stripe, &first, &last);
	for (int i = first; i < last; i += SHAPE_CHUNK) {
		const int *chunk = w->order + i, n = last - i < SHAPE_CHUNK ? last - i : SHAPE_CHUNK;
		mpm_lists(mpm, n, chunk, &lists);
		for (int k = 0; k < n; k++)
			judge_point(mpm, w, &lists, k, chunk[k], &sum);
	}
	return sum;
}

/* One product |A| x, and what it says. */
static struct limit_sum sweep(struct mpm *mpm, struct mpm_work *w)
{
	int rows = w->n_rows;
	struct limit_sum most = {.stiffest = -1, .grown = -1, .hottest = -1};
#pragma omp parallel for schedule(static) if (mpm_parallel(mpm))
	for (int j = 0; j < rows; j++)
		if (w->row_high[j] >= w->row_low[j])
			memset(w->limit_nodes + (size_t)j * (size_t)mpm->grid.nx + (size_t)w->row_low[j], 0,
				   (size_t)(w->row_high[j] - w->row_low[j] + 1) * sizeof *w->limit_nodes);
	mpm_each_stripe(mpm, scatter_stripe);
#pragma omp parallel for schedule(static) if (mpm_parallel(mpm))
	for (int j = 0; j < rows; j++)
		finish_row(mpm, w, j);
	hold_at_walls(mpm, w);
#pragma omp parallel for schedule(dynamic) if (mpm_parallel(mpm))
	for (int stripe = 0; stripe < w->n_stripes; stripe++)
		w->limit_sums[stripe] = judge_stripe(mpm, w, stripe);
	for (int s = 0; s < w->n_stripes; s++) {
		const struct limit_sum *sum = &w->limit_sums[s];
		if (sum->motion > most.motion)
			most.motion = sum->motion, most.stiffest = sum->stiffest;
		if (sum->heat > most.heat)
			most.heat = sum->heat, most.hottest = sum->hottest;
	}
	return most;
}

/* The growth of the stresses goes on or ends. */
static void grow(struct mpm *mpm, struct mpm_work *w)
{
	for (int i = 0; i < w->n_inside; i++) {
		int p = w->order[i];
		double *growth = &mpm->p.growth[p], X = w->limit_points[p].X;
		*growth = X > 2.0 ? *growth + log(X - 1.0) : 0.0;
		if (*growth > w->limit.growth)
			w->limit.growth = *growth, w->limit.grown = p;
	}
}

void limit_look(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	for (int p = 0; p < mpm->p.n; p++)
		w->limit_points[p].weight[0] = w->limit_points[p].weight[1] = 1.0;
	w->limit = sweep(mpm, w);
	double heat = w->limit.heat;
	int hottest = w->limit.hottest;
	for (int k = 1; k < LIMIT_SWEEPS && w->limit.motion > 2.0; k++)
		w->limit = sweep(mpm, w);
	w->limit.heat = heat, w->limit.hottest = hottest;
	grow(mpm, w);
	if (w->limit.motion > 0.0)
		mpm->lattice_limit = mpm->dt * sqrt(2.0 / w->limit.motion);
	w->total.limit_watched = w->limit.motion > WATCH ? 1.0 : 0.0;
}
