/* Velocities between points and nodes beside the step itself: S takes them from the nodes to the points, S+ back,
 * weighted by mass.
 *
 * XPIC and FMPM.  What S+ does not see of the points' velocities is their null space.  The series
 *     v(m) = sum_{k < m} (I - S+ S)^k v_I
 * makes nodal velocities with S v(m) = [I - (I - S S+)^m] V out of v_I = S+ V: the points' velocities without their
 * null space, to the order m.  XPIC(m) takes it of the velocities before the step, V_new = S v(m) + S a dt
 * (Hammerquist and Nairn 2017); FMPM(m) of those after it, V_new = S v(m), where it approaches what the full mass
 * matrix would make of the nodes' momentum (Nairn and Hammerquist 2021).
 *
 * Walls and imposed velocities act once, on the nodes' momentum.  For XPIC the series is of velocities that they have
 * not yet touched, and what they do reaches the points by S a dt as in FLIP.  For FMPM it is of velocities as they
 * left them; v(m) at a wall may point into it, but S+ S v(m) is, to the order m, what the wall left, and that is what
 * the wall meets in the next step.  To impose the wall on v(m) once more would take a momentum from the points that
 * no force on the wall accounts for.  The series itself keeps momentum, with walls or without.
 *
 * USF and MUSL.  Points strain with S+ V, before the step (USF) or after it (MUSL), V being in the second case the
 * new velocities but the weights those of the step.  These velocities are held by walls and imposed values first:
 * a strain is no place for a motion that the next moment takes back.  (With USL the strain is of the velocities after
 * the step, which walls have seen.) */
#include "mpm/point.h"

/* ---- the filter of XPIC and FMPM ---- */

static void begin_filter_row(struct mpm *mpm, struct mpm_work *w, int j)
{
	double(*v)[2] = w->filters_step ? mpm->grid.v_new : mpm->grid.v;
	for (int i = w->row_low[j]; i <= w->row_high[j]; i++) {
		size_t k = (size_t)j * (size_t)mpm->grid.nx + (size_t)i;
		struct node_projection *node = &w->projected[k];
		for (int c = 0; c < 2; c++)
			node->sum[c] = node->term[c] = v[k][c], node->back[c] = 0.0;
	}
}

/* back = m_I S+ S term */
INLINE void filter_stripe(struct mpm *mpm, struct mpm_work *w, int stripe, int nodes)
{
	struct shape_lists lists;
	const struct particles *p = &mpm->p;
	int first, last;
	mpm_stripe_points(w, stripe, &first, &last);
	for (int i = first; i < last; i += SHAPE_CHUNK) {
		const int *chunk = w->order + i, n = last - i < SHAPE_CHUNK ? last - i : SHAPE_CHUNK;
		mpm_lists(mpm, n, chunk, &lists);
		const int count = nodes == SHAPE_VARIES ? lists.nodes : nodes;
		for (int k = 0; k < n; k++) {
			double m = p->mass[chunk[k]], v[2] = {0.0, 0.0};
			for (int a = 0; a < count; a++) {
				v[0] += lists.weight[a][k] * w->projected[lists.node[a][k]].term[0];
				v[1] += lists.weight[a][k] * w->projected[lists.node[a][k]].term[1];
			}
			v[0] *= m, v[1] *= m;
			for (int a = 0; a < count; a++) {
				w->projected[lists.node[a][k]].back[0] += lists.weight[a][k] * v[0];
				w->projected[lists.node[a][k]].back[1] += lists.weight[a][k] * v[1];
			}
		}
	}
}

static void filter_stripe_any(struct mpm *mpm, struct mpm_work *w, int stripe)
{
	if (mpm->shape->max_nodes == 9)
		filter_stripe(mpm, w, stripe, 9);
	else if (mpm->shape->max_nodes == 4)
		filter_stripe(mpm, w, stripe, 4);
	else
		filter_stripe(mpm, w, stripe, SHAPE_VARIES);
}

/* The next term of the series. */
static void filter_row(struct mpm *mpm, struct mpm_work *w, int j)
{
	for (int i = w->row_low[j]; i <= w->row_high[j]; i++) {
		size_t k = (size_t)j * (size_t)mpm->grid.nx + (size_t)i;
		struct node_projection *node = &w->projected[k];
		for (int c = 0; c < 2 && mpm->grid.mass[k] > 0.0; c++) {
			node->term[c] -= node->back[c] / mpm->grid.mass[k];
			node->sum[c] += node->term[c];
			node->back[c] = 0.0;
		}
	}
}

void mpm_filter_nodes(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	if (!w->filtered)
		return;
#pragma omp parallel for schedule(static) if (mpm_parallel(mpm))
	for (int j = 0; j < w->n_rows; j++)
		begin_filter_row(mpm, w, j);
	for (int k = 1; k < mpm->scene->mpm.xpic_order; k++) {
		mpm_each_stripe(mpm, filter_stripe_any);
#pragma omp parallel for schedule(static) if (mpm_parallel(mpm))
		for (int j = 0; j < w->n_rows; j++)
			filter_row(mpm, w, j);
	}
}

/* ---- the strain of USF and MUSL ---- */

static void clear_strain_row(struct mpm *mpm, struct mpm_work *w, int j)
{
	for (int i = w->row_low[j]; i <= w->row_high[j]; i++) {
		size_t k = (size_t)j * (size_t)mpm->grid.nx + (size_t)i;
		w->projected[k].back[0] = w->projected[k].back[1] = mpm->grid.mass[k] = 0.0;
	}
}

/* back = m_I S+ V, with the affine motion of APIC. */
INLINE void momentum_stripe(struct mpm *mpm, struct mpm_work *w, int stripe, int sides)
{
	struct shape_lists lists;
	const struct particles *p = &mpm->p;
	int first, last;
	mpm_stripe_points(w, stripe, &first, &last);
	for (int i = first; i < last; i += SHAPE_CHUNK) {
		const int *chunk = w->order + i, n = last - i < SHAPE_CHUNK ? last - i : SHAPE_CHUNK;
		mpm_lists(mpm, n, chunk, &lists);
		const int side = sides == SHAPE_VARIES ? lists.side : sides;
		for (int k = 0; k < n; k++) {
			int q = chunk[k];
			double r[2] = {0.0, 0.0}, C[4] = {0.0, 0.0, 0.0, 0.0};
			if (p->affine) {
				first_node(mpm, &lists, k, q, r);
				affine_matrix(mpm, &lists, k, q, side, r, C);
			}
			for (int a = 0; a < side * side; a++) {
				double x[2], m = p->mass[q] * lists.weight[a][k];
				double *back = w->projected[lists.node[a][k]].back;
				node_of_list(mpm, r, a, side, x);
				back[0] += m * (p->v[q][0] + C[0] * x[0] + C[1] * x[1]);
				back[1] += m * (p->v[q][1] + C[2] * x[0] + C[3] * x[1]);
				mpm->grid.mass[lists.node[a][k]] += m;
			}
		}
	}
}

static void momentum_stripe_any(struct mpm *mpm, struct mpm_work *w, int stripe)
{
	if (mpm->shape->max_nodes == 9)
		momentum_stripe(mpm, w, stripe, 3);
	else if (mpm->shape->max_nodes == 4)
		momentum_stripe(mpm, w, stripe, 2);
	else
		momentum_stripe(mpm, w, stripe, SHAPE_VARIES);
}

static void strain_row(struct mpm *mpm, struct mpm_work *w, int j)
{
	for (int i = w->row_low[j]; i <= w->row_high[j]; i++) {
		size_t k = (size_t)j * (size_t)mpm->grid.nx + (size_t)i;
		double mass = mpm->grid.mass[k];
		for (int c = 0; c < 2; c++)
			w->projected[k].strain[c] = mass > 0.0 ? w->projected[k].back[c] / mass : 0.0;
	}
}

/* Imposed velocities win over walls, as in the step. */
static void impose_strain_row(struct mpm *mpm, struct mpm_work *w, int j)
{
	for (int i = w->row_low[j]; i <= w->row_high[j]; i++) {
		size_t k = (size_t)j * (size_t)mpm->grid.nx + (size_t)i;
		for (int c = 0; c < 2; c++)
			if (!isnan(w->fixed_v[k][c]))
				w->projected[k].strain[c] = w->fixed_v[k][c];
	}
}

static void strain_velocities(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
#pragma omp parallel for schedule(static) if (mpm_parallel(mpm))
	for (int j = 0; j < w->n_rows; j++)
		clear_strain_row(mpm, w, j);
	mpm_each_stripe(mpm, momentum_stripe_any);
#pragma omp parallel for schedule(static) if (mpm_parallel(mpm))
	for (int j = 0; j < w->n_rows; j++)
		strain_row(mpm, w, j);
	walls_hold(mpm);
	for (int j = 0; j < w->n_rows && w->fixed_v; j++)
		impose_strain_row(mpm, w, j);
}

/* The strain of a block of points, and with MUSL the way that they owe since the step. */
static void strain_block(struct mpm *mpm, struct mpm_work *w, int block)
{
	struct shape_lists lists;
	struct particles *p = &mpm->p;
	const int first = block * BLOCK_POINTS;
	const int last = first + BLOCK_POINTS < w->n_inside ? first + BLOCK_POINTS : w->n_inside;
	w->strain_power[block] = 0.0;
	for (int i = first; i < last; i += SHAPE_CHUNK) {
		const int *chunk = w->order + i, n = last - i < SHAPE_CHUNK ? last - i : SHAPE_CHUNK;
		mpm_lists(mpm, n, chunk, &lists);
		for (int k = 0; k < n; k++) {
			int q = chunk[k];
			double *L = p->L[q];
			memset(L, 0, sizeof p->L[q]);
			for (int a = 0; a < lists.nodes; a++) {
				const double *u = w->projected[lists.node[a][k]].strain;
				L[0] += u[0] * lists.grad_x[a][k], L[1] += u[0] * lists.grad_y[a][k];
				L[2] += u[1] * lists.grad_x[a][k], L[3] += u[1] * lists.grad_y[a][k];
			}
			w->strain_power[block] += stress_power(p->stress[q], L, mat2_determinant(p->F[q]) * p->volume0[q]);
			deform_point(mpm, q, L);
			if (!w->way)
				continue;
			for (int c = 0; c < 2; c++)
				p->x[q][c] += w->way[q][c], w->way[q][c] = 0.0;
			check_moved(mpm, w, q, false, &w->block_sums[block]);
		}
	}
}

void mpm_strain_points(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	strain_velocities(mpm);
#pragma omp parallel for schedule(static) if (mpm_parallel(mpm))
	for (int block = 0; block < w->n_blocks; block++)
		strain_block(mpm, w, block);
}
