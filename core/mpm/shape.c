#include "mpm/shape.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "mpm/kernel.h"

/* ---- lists, by the kernel of this processor ---- */

static void linear_fill(const struct shape_grid *grid, const struct shape_points *points, int n, const int *point,
						struct shape_lists *lists)
{
	mpm_kernel_here()->fill[SHAPE_LINEAR](grid, points, n, point, lists);
}

static void ugimp_fill(const struct shape_grid *grid, const struct shape_points *points, int n, const int *point,
					   struct shape_lists *lists)
{
	mpm_kernel_here()->fill[SHAPE_UGIMP](grid, points, n, point, lists);
}

static void cpdi_fill(const struct shape_grid *grid, const struct shape_points *points, int n, const int *point,
					  struct shape_lists *lists)
{
	mpm_kernel_here()->fill[SHAPE_CPDI](grid, points, n, point, lists);
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
	.number = SHAPE_LINEAR,
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
	.number = SHAPE_UGIMP,
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
	.number = SHAPE_CPDI,
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
