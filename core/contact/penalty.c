/* Penalty walls, for static contact (DP-MPM eq. 87).
 *
 * A wall of this kind does not hold nodes, which feel a curved body a cell before it touches: it pushes points.  A
 * point near the outline of its body at birth stands for the piece of surface before it.  Its gap is its distance from
 * the wall less what it had from the outline; a closed gap of depth u makes the pressure kn u, with kn = stiffness
 * M/cell (M: P-wave modulus), on the face V/l of the point, l being its spacing.  The force goes to the nodes with the
 * point's weights.
 *
 * The gap is that in the middle of the step.  A point moves by the mean of its velocities before and after it
 * (transfer.c): a spring on the place before would gain energy in every step, on the middle it gains none.
 *
 * The force has a potential, so that under damping the body comes to rest where it belongs: dynamic relaxation is
 * mpm.damping_particle.  Explicit steps feel the stiffness as an oscillator of a point's mass on kn: they stay below
 * 0.3 cell / wave speed with the default. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "contact/private.h"
#include "scene/geometry.h"

struct penalty {
	double *depth;         /* m, by id: from the outline at birth; NAN = not near it */
	double *pressure;      /* Pa, by storage index, in this step */
	double (*force)[2];    /* N, the same */
	double (*on_walls)[2]; /* N, by wall */
};

static bool any_wall(const struct mpm *mpm)
{
	bool any = false;
	for (int k = 0; k < mpm->scene->n_walls; k++)
		any = any || mpm->scene->walls[k].contact == SCENE_WALL_PENALTY;
	return any;
}

/* Distance of a place in a body from its outline, m. */
static double depth_of(const struct scene_body *body, const double x[2])
{
	if (!(body->radius > 0.0))
		return polygon_distance(body->n_vertices, (const double(*)[2])body->vertices, x);
	double r = hypot(x[0] - body->centre[0], x[1] - body->centre[1]), outer = body->radius - r;
	return body->hole > 0.0 ? fmin(outer, r - body->hole) : outer;
}

int penalty_create(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	const struct particles *p = &mpm->p;
	size_t n = (size_t)p->n;
	if (!any_wall(mpm))
		return STATUS_OK;
	struct penalty *penalty = w->penalty = calloc(1, sizeof *penalty);
	if (!penalty)
		return error_set(STATUS_RESOURCE, "out of memory for penalty walls");
	penalty->depth = calloc(n, sizeof *penalty->depth);
	penalty->pressure = calloc(n, sizeof *penalty->pressure);
	penalty->force = calloc(n, sizeof *penalty->force);
	penalty->on_walls = calloc((size_t)mpm->scene->n_walls, sizeof *penalty->on_walls);
	if (!penalty->depth || !penalty->pressure || !penalty->force || !penalty->on_walls)
		return error_set(STATUS_RESOURCE, "out of memory for penalty walls and %zu points", n);
	for (int k = 0; k < p->n; k++) {
		const struct scene_body *body = &mpm->scene->bodies[p->body[k]];
		double depth = depth_of(body, p->x0[k]);
		penalty->depth[p->id[k]] = depth < scene_body_spacing(mpm->scene, body) ? depth : NAN;
	}
	return STATUS_OK;
}

void penalty_free(struct mpm *mpm)
{
	struct penalty *penalty = mpm_work(mpm)->penalty;
	if (!penalty)
		return;
	free(penalty->depth);
	free(penalty->pressure);
	free(penalty->force);
	free(penalty->on_walls);
	free(penalty);
}

/* Distance of a place before the face of a line from it, m, and its normal; infinite beside it. */
static double distance_from(const struct mpm *mpm, int wall, const double x[2], double normal[2])
{
	const struct scene_wall *s = &mpm->scene->walls[wall];
	const double *a = s->vertices[0], *b = s->vertices[1], *offset = mpm->wall_offset[wall];
	double tx = b[0] - a[0], ty = b[1] - a[1], length = hypot(tx, ty);
	double rx = x[0] - a[0] - offset[0], ry = x[1] - a[1] - offset[1], along = (rx * tx + ry * ty) / length;
	normal[0] = -ty / length, normal[1] = tx / length;
	return along >= 0.0 && along <= length ? rx * normal[0] + ry * normal[1] : INFINITY;
}

static void push_point(struct mpm *mpm, struct penalty *penalty, int wall, int k)
{
	const struct particles *p = &mpm->p;
	const struct scene_body *body = &mpm->scene->bodies[p->body[k]];
	const double x[2] = {p->x[k][0] + 0.5 * mpm->dt * p->v[k][0], p->x[k][1] + 0.5 * mpm->dt * p->v[k][1]};
	double n[2], pressed = penalty->depth[p->id[k]] - distance_from(mpm, wall, x, n);
	if (!(pressed > 0.0))
		return;
	double pressure = mpm->scene->walls[wall].stiffness * p->modulus[k] / mpm->grid.h * pressed;
	double face = p->volume0[k] / scene_body_spacing(mpm->scene, body);
	penalty->pressure[k] += pressure;
	for (int c = 0; c < 2; c++) {
		penalty->force[k][c] += pressure * face * n[c];
		penalty->on_walls[wall][c] -= pressure * face * n[c];
	}
}

void penalty_push(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	struct penalty *penalty = w->penalty;
	size_t n = (size_t)mpm->p.n;
	memset(penalty->pressure, 0, n * sizeof *penalty->pressure);
	memset(penalty->force, 0, n * sizeof *penalty->force);
	memset(penalty->on_walls, 0, (size_t)mpm->scene->n_walls * sizeof *penalty->on_walls);
	for (int k = 0; k < mpm->p.n; k++) /* few are near an outline */
		for (int wall = 0; wall < mpm->scene->n_walls && !isnan(penalty->depth[mpm->p.id[k]]); wall++)
			if (w->wall_on[wall] && mpm->scene->walls[wall].contact == SCENE_WALL_PENALTY)
				push_point(mpm, penalty, wall, k);
	if (!w->contact)
		memcpy(mpm->p.contact_pressure, penalty->pressure, n * sizeof *penalty->pressure);
}

const double *penalty_force(const struct mpm *mpm, int k) { return mpm_work(mpm)->penalty->force[k]; }

const double *penalty_on_wall(const struct mpm *mpm, int wall) { return mpm_work(mpm)->penalty->on_walls[wall]; }

double penalty_pressure(const struct mpm *mpm, int k)
{
	const struct penalty *penalty = mpm_work(mpm)->penalty;
	return penalty ? penalty->pressure[k] : 0.0;
}
