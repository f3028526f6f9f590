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

static void linear_fill(const struct shape_grid *grid, int n, const int *point, const double (*x)[2], const int *size,
						const double *half, struct shape_lists *lists)
{
	(void)size, (void)half;
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

static void ugimp_fill(const struct shape_grid *grid, int n, const int *point, const double (*x)[2], const int *size,
					   const double *half, struct shape_lists *lists)
{
	const double sx = grid->inverse_h[0], sy = grid->inverse_h[1];
	for (int k = 0; k < n; k++) {
		double fx = (x[point[k]][0] - grid->origin[0]) * sx, fy = (x[point[k]][1] - grid->origin[1]) * sy;
		int i = (int)(fx + 0.5), j = (int)(fy + 0.5); /* nearest node */
		double l = half[size[point[k]]], inverse_2l = 0.5 / l;
		double wx[3], wy[3], gx[3], gy[3];
		ugimp_1d(fx - i, l, inverse_2l, sx, wx, gx);
		ugimp_1d(fy - j, l, inverse_2l, sy, wy, gy);
		tensor_product(3, (j - 1) * grid->nx + i - 1, grid->nx, wx, wy, gx, gy, lists->node + 9 * k,
					   lists->weight + 9 * k, lists->grad_x + 9 * k, lists->grad_y + 9 * k);
	}
}

static double linear_support(double half) { return (void)half, 1.0; }
static double linear_lone(double half) { return (void)half, INFINITY; }
static double ugimp_support(double half) { return 1.0 + half; }
static double ugimp_lone(double half) { return 2.0 / half + 1.0 / (1.0 - half); }

static const struct shape shape_linear = {
	.name = "linear",
	.doc = "bilinear, 4 nodes; the cheapest; points that cross grid cells make noise",
	.max_nodes = 4,
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
	.reach = 1,
	.support = ugimp_support,
	.lone = ugimp_lone,
	.fill = ugimp_fill,
};

const struct shape *const shapes[] = {&shape_ugimp, &shape_linear, NULL};

const struct shape *shape_find(const char *name)
{
	for (int i = 0; shapes[i]; i++)
		if (strcmp(shapes[i]->name, name) == 0)
			return shapes[i];
	return NULL;
}
