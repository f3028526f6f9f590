/* Numerical fracture: neighbours of a body between which the grid passes too little force, whatever the law says.
 *
 * With s points in a row of a grid cell and a shape function that reaches 1 + l cells to either side (linear l = 0,
 * uGIMP l = 1/2s) pairs can share no node any more from a stretch of s (1 + 2 l) on, where their places in the cell are
 * unlucky, and none does at s (2 + 2 l).  But a stretched row of domains has gaps long before: the sum of V grad w over
 * the points no longer vanishes inside a body of uniform stress, pairs on unlucky places give way, and all further
 * stretch gathers between them while both unload.  That shows as a distance which their deformation gradients know
 * nothing of: |x_b - x_a| - |(F_a + F_b)/2 (X_b - X_a)|, over the distance at birth.  Pulled bars lose half
 * of their energy at stretches of 1.2 (uGIMP, 1 point per cell; linear, 4) to 2.2 (uGIMP, 16), and GAP_MOST is reached
 * before; noise of FLIP in points that move freely stays below it (tests/stability/test_numerical_fracture.c).
 *
 * Only bodies of a law whose points stay neighbours are watched: what flows parts and meets others.  Of a law that breaks
 * those that are whole: where damage has begun, the law parts them. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/error.h"
#include "mpm/mpm_private.h"

enum { COHESION_STEPS = 8 }; /* between two looks */
static const double GAP_MOST = 0.2;

struct lattice_place {
	long i, j;
	int body;
};

static bool before(const struct lattice_place *a, const struct lattice_place *b)
{
	return a->body != b->body ? a->body < b->body : a->j != b->j ? a->j < b->j : a->i < b->i;
}

/* Bodies are born row by row from the bottom, each row from the left: a second look that follows the first one row
 * above finds every upper neighbour in one pass. */
static void find_neighbours(int n, const struct lattice_place *at, int (*neighbours)[2])
{
	for (int id = 0, up = 0; id < n; id++) {
		const struct lattice_place *a = &at[id], above = {a->i, a->j + 1, a->body};
		while (up < n && before(&at[up], &above))
			up++;
		bool right = id + 1 < n && at[id + 1].body == a->body && at[id + 1].j == a->j && at[id + 1].i == a->i + 1;
		bool upper = up < n && at[up].body == a->body && at[up].j == above.j && at[up].i == a->i;
		neighbours[id][0] = right ? id + 1 : -1;
		neighbours[id][1] = upper ? up : -1;
	}
}

int cohesion_create(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	const struct particles *p = &mpm->p;
	bool watched = false;
	for (int l = 0; l < mpm->n_laws; l++)
		watched = watched || mpm->laws[l]->type->cohesive;
	if (!watched || !mpm->scene->guards.numerical_fracture)
		return STATUS_OK;
	struct lattice_place *at = malloc(((size_t)p->n + 1) * sizeof *at);
	w->neighbours = malloc(((size_t)p->n + 1) * sizeof *w->neighbours);
	w->storage_of = malloc(((size_t)p->n + 1) * sizeof *w->storage_of);
	if (!at || !w->neighbours || !w->storage_of) {
		free(at);
		return error_set(STATUS_RESOURCE, "out of memory for the neighbours of %d points", p->n);
	}
	for (int k = 0; k < p->n; k++) {
		const struct scene_body *body = &mpm->scene->bodies[p->body[k]];
		double spacing = scene_body_spacing(mpm->scene, body), origin[2];
		double X[2] = {p->x0[k][0], p->x0[k][1]};
		scene_body_lattice(mpm->scene, body, origin);
		scene_body_turn(body, -1.0, X);
		at[p->id[k]] = (struct lattice_place){.i = lround((X[0] - origin[0]) / spacing - 0.5),
											  .j = lround((X[1] - origin[1]) / spacing - 0.5),
											  .body = p->body[k]};
	}
	find_neighbours(p->n, at, w->neighbours);
	free(at);
	return STATUS_OK;
}

void cohesion_free(struct mpm *mpm)
{
	free(mpm_work(mpm)->neighbours);
	free(mpm_work(mpm)->storage_of);
}

/* Do two points whose shape functions reach `a` and `b` cells share a node? */
static bool in_touch(const struct mpm_work *w, const double x[2], double a, const double y[2], double b)
{
	for (int c = 0; c < 2; c++) {
		double fx = (x[c] - w->shape_grid.origin[c]) * w->shape_grid.inverse_h[c];
		double fy = (y[c] - w->shape_grid.origin[c]) * w->shape_grid.inverse_h[c];
		double low = floor(fmax(fx - a, fy - b)) + 1.0, high = ceil(fmin(fx + a, fy + b)) - 1.0;
		if (low > high)
			return false;
	}
	return true;
}

/* By how much two points are further apart than their deformation gradients say, over their distance at birth. */
static double gap(const struct particles *p, int k, int m)
{
	double D[2] = {p->x0[m][0] - p->x0[k][0], p->x0[m][1] - p->x0[k][1]}, told[2];
	for (int c = 0; c < 2; c++)
		told[c] = 0.5 * ((p->F[k][2 * c] + p->F[m][2 * c]) * D[0] + (p->F[k][2 * c + 1] + p->F[m][2 * c + 1]) * D[1]);
	double dx = p->x[m][0] - p->x[k][0], dy = p->x[m][1] - p->x[k][1];
	double apart = sqrt(dx * dx + dy * dy);
	return (apart - sqrt(told[0] * told[0] + told[1] * told[1])) / sqrt(D[0] * D[0] + D[1] * D[1]);
}

bool cohesion_lost(const struct mpm *mpm, int *point, int *neighbour)
{
	const struct mpm_work *w = mpm_work(mpm);
	const struct particles *p = &mpm->p;
	if (!w->neighbours || mpm->step % COHESION_STEPS != 0)
		return false;
	for (int k = 0; k < p->n; k++)
		w->storage_of[p->id[k]] = k;
	for (int id = 0; id < p->n; id++)
		for (int side = 0; side < 2; side++) {
			int k = w->storage_of[id], other = w->neighbours[id][side];
			int m = other >= 0 ? w->storage_of[other] : -1;
			if (m < 0 || !mpm->laws[p->law[k]]->type->cohesive || !mpm->laws[p->law[m]]->type->cohesive ||
				w->cell[k] < 0 || w->cell[m] < 0 || (p->damage && (p->damage[k] > 0.0 || p->damage[m] > 0.0)))
				continue;
			double a = mpm->shape->support(w->half[p->body[k]], p->F[k]),
				   b = mpm->shape->support(w->half[p->body[m]], p->F[m]);
			if (!in_touch(w, p->x[k], a, p->x[m], b) || gap(p, k, m) > GAP_MOST) {
				*point = k, *neighbour = m;
				return true;
			}
		}
	return false;
}
