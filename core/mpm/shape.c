#include "mpm/shape.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

/* The tensor product of n one-dimensional lists in each direction, beginning at node `first`. */
static inline __attribute__((always_inline)) void tensor_product(int n, int first, int nx, const double *wx,
																 const double *wy, const double *gx, const double *gy,
																 int *node, double *weight, double *grad_x,
																 double *grad_y)
{
	for (int b = 0; b < n; b++)
		for (int a = 0; a < n; a++) {
			node[b * n + a] = first + b * nx + a;
			weight[b * n + a] = wx[a] * wy[b];
			grad_x[b * n + a] = gx[a] * wy[b];
			grad_y[b * n + a] = wx[a] * gy[b];
		}
}

static void linear_fill(const struct shape_grid *grid, const struct shape_points *points, int n, const int *point,
						struct shape_lists *lists)
{
	const double(*x)[2] = points->x;
	lists->side = 2, lists->nodes = 4;
	const double sx = grid->inverse_h[0], sy = grid->inverse_h[1];
	const double gx[2] = {-sx, sx}, gy[2] = {-sy, sy};
	for (int k = 0; k < n; k++) {
		double fx = (x[point[k]][0] - grid->origin[0]) * sx, fy = (x[point[k]][1] - grid->origin[1]) * sy;
		int i = (int)fx, j = (int)fy;
		fx -= i, fy -= j;
		const double wx[2] = {1.0 - fx, fx}, wy[2] = {1.0 - fy, fy};
		tensor_product(2, j * grid->nx + i, grid->nx, wx, wy, gx, gy, lists->node + 4 * k, lists->weight + 4 * k,
					   lists->grad_x + 4 * k, lists->grad_y + 4 * k);
	}
}

/* The linear hat function averaged over the domain [f - l, f + l] (uGIMP, in units of h), on the node
 * nearest to the point (middle) and its two neighbours; f in [-1/2, 1/2] is counted from the middle node.
 * One formula for all positions: with c = f clamped to [-l, l] the left weight is (l - c)^2 / 4l plus what
 * f lies beyond -l, and so on.  The weights add up to 1 and the gradients to 0 by construction. */
static inline __attribute__((always_inline)) void ugimp_1d(double f, double l, double inverse_2l, double s, double w[3],
														   double g[3])
{
	double c = f < -l ? -l : f;
	c = c > l ? l : c;
	double left = l - c, right = l + c, beyond = f - c;
	w[0] = 0.5 * left * left * inverse_2l - (beyond < 0.0 ? beyond : 0.0);
	w[2] = 0.5 * right * right * inverse_2l + (beyond > 0.0 ? beyond : 0.0);
	w[1] = 1.0 - w[0] - w[2];
	g[0] = -left * inverse_2l * s;
	g[2] = right * inverse_2l * s;
	g[1] = -(g[0] + g[2]);
}

static void ugimp_fill(const struct shape_grid *grid, const struct shape_points *points, int n, const int *point,
					   struct shape_lists *lists)
{
	const double(*x)[2] = points->x;
	lists->side = 3, lists->nodes = 9;
	const double sx = grid->inverse_h[0], sy = grid->inverse_h[1];
	for (int k = 0; k < n; k++) {
		double fx = (x[point[k]][0] - grid->origin[0]) * sx, fy = (x[point[k]][1] - grid->origin[1]) * sy;
		int i = (int)(fx + 0.5), j = (int)(fy + 0.5); /* nearest node */
		double l = points->half[points->body[point[k]]], inverse_2l = 0.5 / l;
		double wx[3], wy[3], gx[3], gy[3];
		ugimp_1d(fx - i, l, inverse_2l, sx, wx, gx);
		ugimp_1d(fy - j, l, inverse_2l, sy, wy, gy);
		tensor_product(3, (j - 1) * grid->nx + i - 1, grid->nx, wx, wy, gx, gy, lists->node + 9 * k,
					   lists->weight + 9 * k, lists->grad_x + 9 * k, lists->grad_y + 9 * k);
	}
}

/* ---- CPDI ----
 *
 * The domain of a point is a parallelogram that deforms with it (Sadeghirad, Brannon and Burghardt 2011): with its
 * edges r1 and r2 the corners are x1..x4 = x + (-r1-r2, r1-r2, r1+r2, -r1+r2)/2, the weight is the mean of the hat
 * function's values there, and the gradient, its mean over the domain when it is bilinear between the corners,
 *     1/(2 r1 x r2) { (S1 - S3) [r1y - r2y, r2x - r1x] + (S2 - S4) [r1y + r2y, -(r1x + r2x)] }.
 * In the half-diagonals a = (r1 + r2)/2 and b = (r1 - r2)/2: x3, x1 = x +- a, x2, x4 = x +- b, and the gradient is
 *     1/(2 a x b) { (S3 - S1) [by, -bx] + (S2 - S4) [-ay, ax] }.
 * Weights and gradients add up to 1 and 0, and give back linear fields exactly, whatever the parallelogram. */

/* Half-diagonals of a point, in cells, cut to SHAPE_DIAGONAL: ax ay bx by.  What is cut is the reach, not the point. */
static inline __attribute__((always_inline)) void half_diagonals(const struct shape_grid *grid,
																 const struct shape_points *points, int p, double d[4])
{
	const double *F = points->F[p], *e = points->edge[points->body[p]];
	const double sx = 0.5 * grid->inverse_h[0], sy = 0.5 * grid->inverse_h[1];
	const double ux = e[0] + e[2], uy = e[1] + e[3], vx = e[0] - e[2], vy = e[1] - e[3];
	d[0] = (F[0] * ux + F[1] * uy) * sx, d[1] = (F[2] * ux + F[3] * uy) * sy;
	d[2] = (F[0] * vx + F[1] * vy) * sx, d[3] = (F[2] * vx + F[3] * vy) * sy;
	for (int k = 0; k < 4; k += 2) {
		double length2 = d[k] * d[k] + d[k + 1] * d[k + 1];
		if (length2 > SHAPE_DIAGONAL * SHAPE_DIAGONAL) {
			double cut = SHAPE_DIAGONAL / sqrt(length2);
			d[k] *= cut, d[k + 1] *= cut;
		}
	}
}

/* Hat functions of the nodes 0 .. side - 1 at u. */
static inline __attribute__((always_inline)) void hats(int side, double u, double *w)
{
	for (int i = 0; i < side; i++) {
		double left = 1.0 - fabs(u - i);
		w[i] = left > 0.0 ? left : 0.0;
	}
}

/* One point whose place is (fx, fy) cells from its first node. */
static inline __attribute__((always_inline)) void cpdi_point(const struct shape_grid *grid, int side, int first,
															 double fx, double fy, const double d[4], int *node,
															 double *weight, double *grad_x, double *grad_y)
{
	double wx[4][4], wy[4][4];
	hats(side, fx + d[0], wx[0]), hats(side, fy + d[1], wy[0]);
	hats(side, fx - d[0], wx[1]), hats(side, fy - d[1], wy[1]);
	hats(side, fx + d[2], wx[2]), hats(side, fy + d[3], wy[2]);
	hats(side, fx - d[2], wx[3]), hats(side, fy - d[3], wy[3]);
	double area = 0.5 / (d[0] * d[3] - d[1] * d[2]), sx = area * grid->inverse_h[0], sy = area * grid->inverse_h[1];
	double px = sx * d[3], py = -sy * d[2], qx = -sx * d[1], qy = sy * d[0];
	for (int j = 0; j < side; j++)
		for (int i = 0; i < side; i++) {
			double a = wx[0][i] * wy[0][j], b = wx[1][i] * wy[1][j], c = wx[2][i] * wy[2][j], e = wx[3][i] * wy[3][j];
			int at = j * side + i;
			node[at] = first + j * grid->nx + i;
			weight[at] = 0.25 * ((a + b) + (c + e));
			grad_x[at] = (a - b) * px + (c - e) * qx;
			grad_y[at] = (a - b) * py + (c - e) * qy;
		}
}

static inline __attribute__((always_inline)) void cpdi_chunk(const struct shape_grid *grid, const double (*x)[2], int n,
															 const int *point, const double (*d)[4], int side,
															 struct shape_lists *lists)
{
	lists->side = side, lists->nodes = side * side;
	for (int k = 0; k < n; k++) {
		double fx = (x[point[k]][0] - grid->origin[0]) * grid->inverse_h[0],
			   fy = (x[point[k]][1] - grid->origin[1]) * grid->inverse_h[1];
		/* three nodes about the nearest one, or four about the cell */
		int i = (int)(side == 3 ? fx + 0.5 : fx) - 1, j = (int)(side == 3 ? fy + 0.5 : fy) - 1, at = k * side * side;
		cpdi_point(grid, side, j * grid->nx + i, fx - i, fy - j, d[k], lists->node + at, lists->weight + at,
				   lists->grad_x + at, lists->grad_y + at);
	}
}

/* A chunk in which every corner lies within half a cell of its point in both directions needs three nodes a side. */
static void cpdi_fill(const struct shape_grid *grid, const struct shape_points *points, int n, const int *point,
					  struct shape_lists *lists)
{
	double d[SHAPE_CHUNK][4], most = 0.0;
	for (int k = 0; k < n; k++) {
		half_diagonals(grid, points, point[k], d[k]);
		for (int c = 0; c < 4; c++)
			most = fabs(d[k][c]) > most ? fabs(d[k][c]) : most;
	}
	if (most <= 0.5)
		cpdi_chunk(grid, points->x, n, point, (const double(*)[4])d, 3, lists);
	else
		cpdi_chunk(grid, points->x, n, point, (const double(*)[4])d, 4, lists);
}

/* ---- the table ---- */

static double linear_support(double half, const double F[4]) { return (void)half, (void)F, 1.0; }
static double linear_lone(double half) { return (void)half, INFINITY; }
static double ugimp_support(double half, const double F[4]) { return (void)F, 1.0 + half; }
static double ugimp_lone(double half) { return 2.0 / half + 1.0 / (1.0 - half); }

static double cpdi_support(double half, const double F[4])
{
	double x = fabs(F[0]) + fabs(F[1]), y = fabs(F[2]) + fabs(F[3]);
	return 1.0 + fmin(half * fmax(x, y), SHAPE_DIAGONAL);
}

/* Fits what random domains gave, turned anyhow, pressed to half their size or stretched to twice
 * (tests/unit/test_shape.c tries it): 5.6 for a square of half 1/4, 12.4 for the worst.  What is pressed more is found
 * by looking, every so many steps (limit.c). */
static double cpdi_lone(double half) { return 2.0 * M_SQRT2 / half + 2.0 / (1.0 - half); }

static const struct shape shape_linear = {
	.name = "linear",
	.doc = "bilinear, 4 nodes; the cheapest; points that cross grid cells make noise",
	.max_nodes = 4,
	.tensor = true,
	.affine_by_gradient = true,
	.reach = 0,
	.support = linear_support,
	.lone = linear_lone,
	.fill = linear_fill,
};

static const struct shape shape_ugimp = {
	.name = "ugimp",
	.doc = "generalised interpolation over the undeformed domain of the point, 9 nodes",
	.max_nodes = 9,
	.tensor = true,
	.reach = 1,
	.support = ugimp_support,
	.lone = ugimp_lone,
	.fill = ugimp_fill,
};

static const struct shape shape_cpdi = {
	.name = "cpdi",
	.doc = "interpolation from the corners of the point's deformed domain, 9 nodes or 16; for large stretch and shear",
	.max_nodes = SHAPE_MAX_NODES,
	.varies = true,
	.reach = 1,
	.support = cpdi_support,
	.lone = cpdi_lone,
	.fill = cpdi_fill,
};

const struct shape *const shapes[] = {&shape_ugimp, &shape_linear, &shape_cpdi, NULL};

const struct shape *shape_find(const char *name)
{
	for (int i = 0; shapes[i]; i++)
		if (strcmp(shapes[i]->name, name) == 0)
			return shapes[i];
	return NULL;
}
