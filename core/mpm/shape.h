/* Shape functions: for each point a short list of (node, weight, gradient).
 *
 * Everything else in the step only walks these lists, so a new shape function is one entry of shapes[].
 * Lists are filled for a chunk of points at a time, stay in the first cache level and are used up by the
 * pass that asked for them; no array of weights ever goes through memory. */
#ifndef TMDEMPM_MPM_SHAPE_H
#define TMDEMPM_MPM_SHAPE_H

#include <stdbool.h>

enum {
	SHAPE_CHUNK = 32,    /* points in one buffer */
	SHAPE_MAX_NODES = 16 /* of any shape function */
};

/* The lists of a chunk.  Entry a of point k is number k * max_nodes + a; every point has exactly
 * max_nodes entries, those that it does not need with weight and gradient zero.  They are a square of nodes: entry
 * j * sqrt(max_nodes) + i is the node (i, j) steps from the first, its weight the product of one in x and one in y. */
struct shape_lists {
	int node[SHAPE_CHUNK * SHAPE_MAX_NODES];
	double weight[SHAPE_CHUNK * SHAPE_MAX_NODES]; /* - */
	double grad_x[SHAPE_CHUNK * SHAPE_MAX_NODES]; /* 1/m */
	double grad_y[SHAPE_CHUNK * SHAPE_MAX_NODES];
} __attribute__((aligned(64)));

/* What a fill function has to know of the grid: node (i, j) = j * nx + i lies at
 * origin + (i / inverse_h[0], j / inverse_h[1]). */
struct shape_grid {
	double origin[2];    /* m */
	double inverse_h[2]; /* 1/m, in x and y */
	int nx;
};

struct shape {
	const char *name;
	const char *doc;
	int max_nodes;
	bool affine_by_gradient; /* APIC's D is singular at nodes: C is taken as the gradient (mpm/point.h) */
	int reach;               /* a point in grid cell i has nodes i - reach .. i + 1 + reach in each direction */

	/* Of a point with half its domain `half` over h: the nodes that it touches lie less than this many cells away, */
	double (*support)(double half);
	/* and the most that sum_I h^2 (dw_I/dx)^2 / w_I can be in one direction, wherever it is; INFINITY = no bound. */
	double (*lone)(double half);

	/* Lists of the n <= SHAPE_CHUNK points point[0..n-1] at x[point[k]].  half[size[point[k]]] is half the
	 * side of their undeformed domain over h, 0 < half <= 1/2. */
	void (*fill)(const struct shape_grid *grid, int n, const int *point, const double (*x)[2], const int *size,
				 const double *half, struct shape_lists *lists);
};

/* Every shape function there is, NULL-terminated. */
extern const struct shape *const shapes[];

/* By name, or NULL. */
const struct shape *shape_find(const char *name);

#endif
