/* Values imposed on nodes in boxes: velocities, temperatures (also those of heated walls). */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "mpm/mpm_private.h"

static const double ON_BOX = 1e-9; /* of h */

/* The nodes of a box; one that reaches the scene's edge also holds the ghost nodes beyond it. */
static void box_nodes(const struct mpm *mpm, const struct scene_boundary *b, int low[2], int high[2])
{
	const struct grid *grid = &mpm->grid;
	const int count[2] = {grid->nx, grid->ny};
	for (int c = 0; c < 2; c++) {
		double min = (b->min[c] - grid->origin[c]) / grid->spacing[c],
			   max = (b->max[c] - grid->origin[c]) / grid->spacing[c];
		low[c] = min < GHOST_CELLS + ON_BOX ? 0 : (int)fmin(ceil(min - ON_BOX), count[c]);
		high[c] = max > count[c] - 1 - GHOST_CELLS - ON_BOX ? count[c] - 1 : (int)fmax(floor(max + ON_BOX), -1.0);
	}
}

static void impose(struct mpm *mpm, const struct scene_boundary *b, double temperature)
{
	struct mpm_work *w = mpm_work(mpm);
	int low[2], high[2];
	box_nodes(mpm, b, low, high);
	for (int j = low[1]; j <= high[1]; j++)
		for (int i = low[0]; i <= high[0]; i++) {
			size_t node = (size_t)j * (size_t)mpm->grid.nx + (size_t)i;
			for (int c = 0; c < 2; c++)
				if (w->fixed_v && !isnan(b->velocity[c]))
					w->fixed_v[node][c] = b->velocity[c];
			if (w->fixed_T && !isnan(temperature))
				w->fixed_T[node] = temperature, w->fixed_T_wall[node] = -1;
		}
}

/* Half a step of grace: times are sums of steps. */
static bool boundary_active(const struct mpm *mpm, const struct scene_boundary *b)
{
	double now = mpm->time + 0.5 * mpm->scene->time.step;
	return now >= b->from && now < b->until;
}

/* Nodes that the points of a driving body touch; at the end of the step they move with it, and so do the fields of
 * bodies that are welded to it there. */
void boundaries_drive(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	struct shape_lists lists;
	double end = mpm->time + mpm->dt;
	for (int k = 0; k < mpm->p.n; k++) {
		const struct scene_body *body = &mpm->scene->bodies[mpm->p.body[k]];
		if (!body->drives || mpm_cell_of(w, mpm->p.x[k]) < 0)
			continue;
		double share = end < body->drive_ramp ? end / body->drive_ramp : 1.0;
		const double v[2] = {share * body->drive[0], share * body->drive[1]};
		mpm->shape->fill(&w->shape_grid, &w->shape_points, 1, &k, &lists);
		for (int a = 0; a < lists.nodes; a++) {
			if (!(lists.weight[a][0] > ON_BOX))
				continue;
			if (w->contact && contact_drive(mpm, lists.node[a][0], mpm->p.body[k], v))
				continue;
			memcpy(w->fixed_v[lists.node[a][0]], v, sizeof v);
		}
	}
}

static void rebuild(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	size_t nodes = w->n_nodes;
	for (size_t k = 0; k < nodes; k++) {
		if (w->fixed_T)
			w->fixed_T[k] = NAN, w->fixed_T_wall[k] = -1;
		if (w->fixed_v)
			w->fixed_v[k][0] = w->fixed_v[k][1] = NAN;
	}
	for (int e = 0; w->fixed_T && e < w->n_wall_nodes; e++) {
		double T = w->wall_T[w->wall_nodes[e].wall];
		if (!isnan(T)) {
			w->fixed_T[w->wall_nodes[e].node] = T;
			w->fixed_T_wall[w->wall_nodes[e].node] = w->wall_nodes[e].wall;
		}
	}
	for (int b = 0; b < mpm->scene->n_boundaries; b++)
		if (w->boundary_on[b])
			impose(mpm, &mpm->scene->boundaries[b], w->boundary_T[b]);
	if (w->drives && !w->contact)
		boundaries_drive(mpm);
	w->imposes_T = false;
	for (size_t k = 0; w->fixed_T && k < nodes; k++)
		w->imposes_T = w->imposes_T || !isnan(w->fixed_T[k]);
}

/* Takes a new value; true if it differs. */
static bool renew(double *held, double value)
{
	bool same = *held == value || (isnan(*held) && isnan(value));
	*held = value;
	return !same;
}

/* Values of this step's thermal pass: temperatures at its end, fluxes and ambients at the middle of the time that it
 * covers, which is exact for a table's straight lines. */
static void update_heat(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	const struct scene *scene = mpm->scene;
	double end = mpm->time + mpm->dt, middle = end - 0.5 * mpm->dt * scene->time.thermal_every;
	for (int wall = 0; wall < scene->n_walls; wall++) {
		const struct scene_wall *s = &scene->walls[wall];
		if (renew(&w->wall_T[wall], scene_value_at(s->temperature, &s->temperature_table, end)))
			w->boundaries_stale = true;
	}
	for (int b = 0; b < scene->n_boundaries; b++) {
		const struct scene_boundary *s = &scene->boundaries[b];
		if (renew(&w->boundary_T[b], scene_value_at(s->temperature, &s->temperature_table, end)))
			w->boundaries_stale = true;
	}
	for (int f = 0; f < w->n_point_heats; f++) {
		struct point_heat *heat = &w->point_heats[f];
		const struct scene_convection *c = &heat->boundary->convection;
		double flux = scene_value_at(heat->boundary->flux, &heat->boundary->flux_table, middle);
		heat->flux = isnan(flux) ? 0.0 : flux;
		heat->coefficient = isnan(c->coefficient) ? 0.0 : c->coefficient;
		heat->ambient = heat->coefficient > 0.0 ? scene_value_at(c->ambient, &c->ambient_table, middle) : 0.0;
		heat->on = w->boundary_on[heat->boundary - scene->boundaries];
	}
}

void boundaries_update(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	for (int b = 0; b < mpm->scene->n_boundaries; b++) {
		bool on = boundary_active(mpm, &mpm->scene->boundaries[b]);
		w->boundaries_stale = w->boundaries_stale || on != w->boundary_on[b];
		w->boundary_on[b] = on;
	}
	if (mpm->thermal)
		update_heat(mpm);
	if (w->boundaries_stale || w->drives)
		rebuild(mpm);
	w->boundaries_stale = false;
}

int boundaries_create(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	size_t nodes = w->n_nodes, n = (size_t)mpm->scene->n_boundaries;
	bool velocities = false, complete = true;
	w->boundary_on = calloc(n + 1, sizeof *w->boundary_on);
	w->boundary_T = calloc(n + 1, sizeof *w->boundary_T);
	w->wall_T = calloc((size_t)mpm->scene->n_walls + 1, sizeof *w->wall_T);
	w->point_heats = calloc(n + 1, sizeof *w->point_heats);
	complete = w->boundary_on && w->boundary_T && w->wall_T && w->point_heats;
	for (int b = 0; b < mpm->scene->n_boundaries && complete; b++) {
		const struct scene_boundary *boundary = &mpm->scene->boundaries[b];
		velocities = velocities || !isnan(boundary->velocity[0]) || !isnan(boundary->velocity[1]);
		if (mpm->thermal && scene_boundary_heats_points(boundary))
			w->point_heats[w->n_point_heats++].boundary = boundary;
	}
	for (int b = 0; b < mpm->scene->n_bodies; b++)
		w->drives = w->drives || mpm->scene->bodies[b].drives;
	if (velocities || w->drives) {
		w->fixed_v = calloc(nodes, sizeof *w->fixed_v);
		w->fixed_push = calloc(nodes, sizeof *w->fixed_push);
		complete = complete && w->fixed_v && w->fixed_push;
	}
	if (mpm->thermal) {
		w->fixed_T = calloc(nodes, sizeof *w->fixed_T);
		w->fixed_T_wall = calloc(nodes, sizeof *w->fixed_T_wall);
		w->fixed_lift = calloc(nodes, sizeof *w->fixed_lift);
		w->fixed_heat = calloc(nodes, sizeof *w->fixed_heat);
		complete = complete && w->fixed_T && w->fixed_T_wall && w->fixed_lift && w->fixed_heat;
	}
	w->boundaries_stale = true;
	return complete ? STATUS_OK
					: error_set(STATUS_RESOURCE, "out of memory for the boundary values of %zu nodes", nodes);
}

void boundaries_free(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	free(w->boundary_on);
	free(w->boundary_T);
	free(w->wall_T);
	free(w->point_heats);
	free(w->fixed_v);
	free(w->fixed_push);
	free(w->fixed_T);
	free(w->fixed_T_wall);
	free(w->fixed_lift);
	free(w->fixed_heat);
}
