/* What several passes do with one point: its strain, its affine motion (APIC), its soundness.  Inlined, because
 * the loops that call it have lengths known when they are compiled. */
#ifndef TMDEMPM_MPM_POINT_H
#define TMDEMPM_MPM_POINT_H

#include <math.h>
#include <string.h>

#include "base/mat2.h"
#include "law/series.h"
#include "mpm/mpm_private.h"

#define INLINE static inline __attribute__((always_inline))

/* Is everything a number?  The sum of the parts is one only if all are. */
INLINE bool finite4(const double a[4]) { return isfinite(a[0] + a[1] + a[2] + a[3]); }

/* cosh(sqrt q2) and sinh(sqrt q2)/sqrt q2, to the last bit or so while |q2| is less than this; of a number or of a
 * vector of them. */
#define SERIES_MOST2 1e-4
#define COSH_SERIES(q2) (1.0 + q2 * (1.0 / 2 + q2 * (1.0 / 24 + q2 * (1.0 / 720 + q2 * (1.0 / 40320)))))
#define SINH_SERIES(q2) (1.0 + q2 * (1.0 / 6 + q2 * (1.0 / 120 + q2 * (1.0 / 5040 + q2 * (1.0 / 362880)))))

/* exp(A) F.  The series serves the small increments of a stable step to the last bit or so, without a call to
 * the maths library; what lies outside goes the general way. */
INLINE void deform(double F[4], const double L[4], double dt)
{
	double A[4] = {L[0] * dt, L[1] * dt, L[2] * dt, L[3] * dt}, e[4];
	double s = 0.5 * (A[0] + A[3]), d = 0.5 * (A[0] - A[3]), q2 = d * d + A[1] * A[2];
	if (fabs(s) < SERIES_MOST && fabs(q2) < SERIES_MOST2) {
		double es = EXP_SERIES(s), c = COSH_SERIES(q2), k = es * SINH_SERIES(q2);
		c *= es;
		e[0] = c + k * d, e[1] = k * A[1], e[2] = k * A[2], e[3] = c - k * d;
	} else {
		mat2_exp(A, e);
	}
	mat2_multiply(e, F, F);
}

/* A broken point's F tells where its domain reaches, and no more: it stays where the domain has become absurd,
 * stretched to 1/half or pressed to a quarter, until the motion brings it back (methods: frozen F). */
INLINE void deform_point(const struct mpm *mpm, int p, const double L[4])
{
	double *F = mpm->p.F[p], old[4];
	if (!mpm->p.damage || mpm->p.damage[p] < 1.0) {
		deform(F, L, mpm->dt);
		return;
	}
	memcpy(old, F, sizeof old);
	deform(F, L, mpm->dt);
	double stretch = F[0] * F[0] + F[1] * F[1] + F[2] * F[2] + F[3] * F[3], J = mat2_determinant(F);
	double before = old[0] * old[0] + old[1] * old[1] + old[2] * old[2] + old[3] * old[3];
	double half = mpm_work(mpm)->half[mpm->p.body[p]];
	if ((half * half * stretch > 1.0 && stretch > before) || (J < 0.25 && J < mat2_determinant(old)))
		memcpy(F, old, sizeof old);
}

/* W, of a stress (xx yy zz xy) in a volume on a velocity gradient. */
INLINE double stress_power(const double s[4], const double L[4], double volume)
{
	return volume * (s[0] * L[0] + s[3] * (L[1] + L[2]) + s[1] * L[3]);
}

INLINE bool inside(const struct mpm_work *w, const double x[2])
{
	const double *s = w->shape_grid.inverse_h;
	double fx = (x[0] - w->shape_grid.origin[0]) * s[0], fy = (x[1] - w->shape_grid.origin[1]) * s[1];
	return fx >= GHOST_CELLS && fy >= GHOST_CELLS && fx <= w->cells_x - GHOST_CELLS && fy <= w->cells_y - GHOST_CELLS;
}

/* After a point has moved: is its motion a number, is it still in the grid? */
INLINE void check_moved(struct mpm *mpm, struct mpm_work *w, int q, bool heat, struct block_sum *sum)
{
	struct particles *p = &mpm->p;
	if (!isfinite(p->x[q][0] + p->x[q][1] + p->v[q][0] + p->v[q][1]) || !finite4(p->F[q]) ||
		(heat && !isfinite(p->T[q])))
		sum->bad = sum->bad < 0 ? q : sum->bad;
	else if (!inside(w, p->x[q])) {
		sum->left = sum->left < 0 ? q : sum->left;
		if (!mpm->scene->guards.points_leaving)
			point_park(p, q, sum);
	}
}

/* ---- APIC: the affine motion of a point, V + C (x - x_p) (Jiang and others 2015) ----
 *
 * A point carries B = sum w v (x_I - x_p)^T of the nodes' velocities, and C = B D^-1 with D = sum w (x_I - x_p)
 * (x_I - x_p)^T, which is diagonal where weights are tensor products.  B, not C, is what keeps angular momentum
 * when the point has moved in its cell and D has changed.  With the linear shape D vanishes at the nodes, and the
 * identity B D^-1 = sum v (grad w)^T holds only where B was taken: there C itself is carried, at the price of the
 * angular momentum that D's change makes. */

/* The first node of point p, number k of its chunk, as seen from it, m. */
INLINE void first_node(const struct mpm *mpm, const struct shape_lists *lists, int k, int p, double r[2])
{
	const struct grid *grid = &mpm->grid;
	int node = mpm_home(mpm, lists->node[0][k]);
	r[0] = grid->origin[0] + node % grid->nx * grid->spacing[0] - mpm->p.x[p][0];
	r[1] = grid->origin[1] + node / grid->nx * grid->spacing[1] - mpm->p.x[p][1];
}

/* Entry a of its list, when the first is at r. */
INLINE void node_of_list(const struct mpm *mpm, const double r[2], int a, int side, double at[2])
{
	at[0] = r[0] + a % side * mpm->grid.spacing[0];
	at[1] = r[1] + a / side * mpm->grid.spacing[1];
}

/* C from what the point carries; r from first_node(). */
INLINE void affine_matrix(const struct mpm *mpm, const struct shape_lists *lists, int k, int p, int side,
						  const double r[2], double C[4])
{
	const double *B = mpm->p.affine[p];
	if (mpm->shape->affine_by_gradient) {
		memcpy(C, B, 4 * sizeof *C);
		return;
	}
	double D[3] = {0.0, 0.0, 0.0};
	for (int a = 0; a < side * side; a++) {
		double x[2];
		node_of_list(mpm, r, a, side, x);
		D[0] += lists->weight[a][k] * x[0] * x[0];
		D[1] += lists->weight[a][k] * x[1] * x[1];
		if (!mpm->shape->tensor)
			D[2] += lists->weight[a][k] * x[0] * x[1];
	}
	if (mpm->shape->tensor) {
		C[0] = B[0] / D[0], C[1] = B[1] / D[1], C[2] = B[2] / D[0], C[3] = B[3] / D[1];
		return;
	}
	double s = 1.0 / (D[0] * D[1] - D[2] * D[2]);
	for (int c = 0; c < 4; c += 2)
		C[c] = s * (B[c] * D[1] - B[c + 1] * D[2]), C[c + 1] = s * (B[c + 1] * D[0] - B[c] * D[2]);
}

/* What the point is to carry: `share` of the nodes' velocities after the step. */
INLINE void affine_gather(struct mpm *mpm, const struct shape_lists *lists, int k, int p, int side, double share)
{
	double r[2], B[4] = {0.0, 0.0, 0.0, 0.0};
	first_node(mpm, lists, k, p, r);
	for (int a = 0; a < side * side; a++) {
		const double *v = mpm->grid.v_new[lists->node[a][k]];
		double x[2];
		node_of_list(mpm, r, a, side, x);
		x[0] *= lists->weight[a][k], x[1] *= lists->weight[a][k];
		if (mpm->shape->affine_by_gradient)
			x[0] = lists->grad_x[a][k], x[1] = lists->grad_y[a][k];
		B[0] += v[0] * x[0], B[1] += v[0] * x[1];
		B[2] += v[1] * x[0], B[3] += v[1] * x[1];
	}
	for (int c = 0; c < 4; c++)
		mpm->p.affine[p][c] = share * B[c];
}

#endif
