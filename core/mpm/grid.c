/* The background grid: its arrays, and where its nodes are.
 *
 * A grid may follow a moving wall: it is stretched along the wall's motion, about a fixed place, so that the wall's
 * face stays on the row of nodes on which it began (and a wall through the fixed place on its row).  Nodes carry
 * nothing from step to step, so a grid can be placed anew in each.  Without this a plate acts on whole rows of nodes,
 * and its force drops each time that its face leaves one behind. */
#include <math.h>
#include <stdlib.h>

#include "base/error.h"
#include "mpm/mpm_private.h"

int grid_create(struct mpm *mpm)
{
	struct grid *grid = &mpm->grid;
	const struct scene_grid *s = &mpm->scene->grid;
	grid->h = s->cell;
	grid->thickness = s->thickness;
	grid->nx = (int)lround(s->size[0] / s->cell) + 1 + 2 * GHOST_CELLS;
	grid->ny = (int)lround(s->size[1] / s->cell) + 1 + 2 * GHOST_CELLS;
	mpm_work(mpm)->shape_grid.nx = grid->nx;
	/* extra fields lie behind the grid's nodes, in rows like theirs */
	size_t rows = (size_t)grid->ny + ((size_t)contact_slots(mpm) + (size_t)grid->nx - 1) / (size_t)grid->nx;
	size_t n = mpm_work(mpm)->n_nodes = (size_t)grid->nx * rows;
	mpm_work(mpm)->n_rows = grid->ny;
	grid->mass = calloc(n, sizeof *grid->mass);
	grid->v = calloc(n, sizeof *grid->v);
	grid->v_new = calloc(n, sizeof *grid->v_new);
	grid->force = calloc(n, sizeof *grid->force);
	bool complete = grid->mass && grid->v && grid->v_new && grid->force;
	if (mpm->thermal) {
		grid->heat_capacity = calloc(n, sizeof *grid->heat_capacity);
		grid->T = calloc(n, sizeof *grid->T);
		grid->T_new = calloc(n, sizeof *grid->T_new);
		complete = complete && grid->heat_capacity && grid->T && grid->T_new;
	}
	return complete ? STATUS_OK : error_set(STATUS_RESOURCE, "out of memory for a grid of %zu nodes", n);
}

int grid_place(struct mpm *mpm)
{
	struct grid *grid = &mpm->grid;
	const struct scene *scene = mpm->scene;
	const struct scene_grid *s = &scene->grid;
	const struct scene_wall *wall = s->follows ? &scene->walls[s->follow] : NULL;
	struct shape_grid *shape_grid = &mpm_work(mpm)->shape_grid;
	for (int c = 0; c < 2; c++) {
		double origin = s->origin[c] - GHOST_CELLS * s->cell;
		grid->spacing[c] = s->cell;
		grid->origin[c] = origin;
		if (wall && wall->velocity[c] != 0.0) {
			double factor = 1.0 + mpm->wall_offset[s->follow][c] / (scene_grid_face(scene, c) - s->fixed[c]);
			if (!(factor >= GRID_LEAST && factor <= 1.0 / GRID_LEAST))
				return error_set(STATUS_GUARD,
								 "step %lld, t = %.6g s: the grid that follows wall '%s' has been stretched by %.3g, "
								 "expected %g to %g; cure: an earlier time.end, or a grid that does not follow (state: "
								 "start of the step)",
								 mpm->step, mpm->time, wall->name, factor, GRID_LEAST, 1.0 / GRID_LEAST);
			grid->spacing[c] = s->cell * factor;
			grid->origin[c] = s->fixed[c] + (origin - s->fixed[c]) * factor;
		}
		shape_grid->origin[c] = grid->origin[c];
		shape_grid->inverse_h[c] = 1.0 / grid->spacing[c];
	}
	return STATUS_OK;
}

double grid_carried(const struct mpm *mpm, double place, int c)
{
	const struct scene_grid *s = &mpm->scene->grid;
	double stretch = mpm->grid.spacing[c] / s->cell;
	return stretch == 1.0 ? place : s->fixed[c] + (place - s->fixed[c]) * stretch;
}
