/* Shape functions: for each point a short list of (node, weight, gradient).
 *
 * Everything else in the step only walks these lists, so a new shape function is one entry of shapes[].
 * Lists are filled for a chunk of points at a time, stay in the first cache level and are used up by the
 * pass that asked for them; no array of weights ever goes through memory. */
#ifndef TMDEMPM_MPM_SHAPE_H
#define TMDEMPM_MPM_SHAPE_H

#include <stdbool.h>

enum {
	SHAPE_CHUNK = 32,     /* points in one buffer */
	SHAPE_MAX_NODES = 16, /* of any shape function */
	SHAPE_VARIES = 0      /* for a number of nodes: as the lists say, chunk by chunk */
};

/* The lists of a chunk: [a][k] is entry a of point k.  Every point has exactly `nodes` entries, those that it does not
 * need with weight and gradient zero.  They are a square of nodes: entry j * side + i is the node (i, j) steps from the
 * first.  Points lie side by side, so that short vectors of them are worked on at once (kernel.h). */
struct shape_lists {
	int side;  /* 2, 3 or 4; the same in every chunk unless the shape says otherwise (varies) */
	int nodes; /* side^2 */
	int node[SHAPE_MAX_NODES][SHAPE_CHUNK] __attribute__((aligned(64)));
	double weight[SHAPE_MAX_NODES][SHAPE_CHUNK] __attribute__((aligned(64))); /* - */
	double grad_x[SHAPE_MAX_NODES][SHAPE_CHUNK];                              /* 1/m */
	double grad_y[SHAPE_MAX_NODES][SHAPE_CHUNK];
};

/* What a fill function has to know of the grid: node (i, j) = j * nx + i lies at
 * origin + (i / inverse_h[0], j / inverse_h[1]). */
struct shape_grid {
	double origin[2];    /* m */
	double inverse_h[2]; /* 1/m, in x and y */
	int nx;
};

/* And of the points, by storage index, and of their bodies. */
struct shape_points {
	const double (*x)[2]; /* m */
	const double (*F)[4]; /* deformation gradient */
	const int *body;
	const double *half;      /* by body: half the side of a point's undeformed domain over h, 0 < half <= 1/2 */
	const double (*edge)[4]; /* by body: both edges of that domain, x y x y, m: it may lie askew in the grid */
};

enum shape_number { SHAPE_LINEAR, SHAPE_UGIMP, SHAPE_CPDI, SHAPE_COUNT };

struct shape {
	enum shape_number number;
	const char *name;
	const char *doc;
	int max_nodes;
	bool varies;             /* lists have 9 entries or 16, as the chunk's points need; else max_nodes */
	bool tensor;             /* weights are products of one in x and one in y: APIC's D is diagonal (mpm/point.h) */
	bool affine_by_gradient; /* APIC's D is singular at nodes: C is taken as the gradient */
	int reach;               /* a point in grid cell i has nodes i - reach .. i + 1 + reach in each direction */

	/* Of a point with half its domain `half` over h, deformed by F: nodes that it touches lie less than this many cells
	 * away, */
	double (*support)(double half, const double F[4]);
	/* and the most that sum_I h^2 (dw_I/dx)^2 / w_I can be in one direction, wherever it is; INFINITY = no bound. */
	double (*lone)(double half);

	/* Lists of the 0 < n <= SHAPE_CHUNK points point[0..n-1].  Passes over many points call what it calls (kernel.h).
	 */
	void (*fill)(const struct shape_grid *grid, const struct shape_points *points, int n, const int *point,
				 struct shape_lists *lists);
};

/* Every shape function there is, NULL-terminated. */
extern const struct shape *const shapes[];

/* Half-diagonals of a CPDI domain are cut to this many cells, so that its corners stay in the cells beside its own
 * (Homel, Brannon and Guilkey 2016). */
#define SHAPE_DIAGONAL 0.999

/* By name, or NULL. */
const struct shape *shape_find(const char *name);

#endif
