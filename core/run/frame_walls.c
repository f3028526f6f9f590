#include "run/frame_walls.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"

/* The outline of a wall, cut into pieces.  A polygon's last point is its first. */
struct outline {
	int wall, first, n; /* points in the channel */
	int n_edges;
	bool closed;
};

struct wall_frame {
	const struct mpm *mpm;
	struct frame_builder *builder;
	int n_outlines, n_points;
	struct outline *outlines;
	double (*x)[3];           /* m, by point */
	double *pressure, *shear; /* N first, then Pa */
	double *length;           /* m of the outline that belongs to a point */
};

/* ---- outlines ---- */

static void wall_edge(const struct mpm *mpm, int wall, int edge, double ends[2][2])
{
	const struct scene_wall *w = &mpm->scene->walls[wall];
	for (int k = 0; k < 2; k++)
		for (int c = 0; c < 2; c++)
			ends[k][c] = w->vertices[(edge + k) % w->n_vertices][c] + mpm->wall_offset[wall][c];
}

/* Into how many pieces an edge is cut: none is shorter than a cell of the grid, or there would be pieces without a node. */
static int wall_pieces(const struct mpm *mpm, int wall, int edge)
{
	double ends[2][2], h = fmax(mpm->grid.spacing[0], mpm->grid.spacing[1]);
	wall_edge(mpm, wall, edge, ends);
	double pieces = floor(hypot(ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]) / h + 1e-6);
	return pieces > 1 ? (int)fmin(pieces, 1e6) : 1;
}

static void find_outlines(struct wall_frame *f)
{
	for (int w = 0; w < f->mpm->scene->n_walls; w++) {
		const struct scene_wall *wall = &f->mpm->scene->walls[w];
		if (!mpm_wall_active(f->mpm, w))
			continue;
		struct outline *o = &f->outlines[f->n_outlines++];
		*o = (struct outline){.wall = w, .first = f->n_points, .n = 1, .closed = wall->shape == SCENE_WALL_POLYGON};
		o->n_edges = wall->n_vertices - (o->closed ? 0 : 1);
		for (int e = 0; e < o->n_edges; e++)
			o->n += wall_pieces(f->mpm, w, e);
		f->n_points += o->n;
	}
}

static void place_points(struct wall_frame *f, const struct outline *o)
{
	double ends[2][2] = {{0}};
	int p = o->first;
	for (int e = 0; e < o->n_edges; e++) {
		int pieces = wall_pieces(f->mpm, o->wall, e);
		wall_edge(f->mpm, o->wall, e, ends);
		double piece = hypot(ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]) / pieces;
		for (int k = 0; k < pieces; k++, p++) {
			for (int c = 0; c < 2; c++) /* corners keep their bits */
				f->x[p][c] = k == 0 ? ends[0][c] : ends[0][c] + (ends[1][c] - ends[0][c]) * k / pieces;
			f->length[p] += 0.5 * piece;
			f->length[p + 1] += 0.5 * piece;
		}
	}
	f->x[p][0] = ends[1][0], f->x[p][1] = ends[1][1];
}

/* ---- loads ---- */

/* Where a load meets an edge: piece and place (0 .. 1) of its foot; returns how far it is, weighed so that an edge that
 * faces elsewhere comes last. */
static double edge_distance(const struct mpm *mpm, const struct outline *o, int edge, const struct mpm_wall_load *load,
							double *place)
{
	double ends[2][2];
	wall_edge(mpm, o->wall, edge, ends);
	double tx = ends[1][0] - ends[0][0], ty = ends[1][1] - ends[0][1], length = hypot(tx, ty);
	double dx = load->at[0] - ends[0][0], dy = load->at[1] - ends[0][1];
	double s = (dx * tx + dy * ty) / (length * length);
	*place = s < 0 ? 0 : s > 1 ? 1 : s;
	double faces = (load->normal[0] * ty - load->normal[1] * tx) / length; /* polygons are counter-clockwise */
	faces = o->closed ? faces : fabs(faces);
	double distance = hypot(dx - *place * tx, dy - *place * ty);
	return faces > 0.9 ? distance : 1e3 * (1 + distance);
}

/* Shares a load out between the two points beside its foot. */
static void add_load(struct wall_frame *f, const struct outline *o, const struct mpm_wall_load *load)
{
	double best = INFINITY, at = 0, ends[2][2];
	int first = o->first, edge = 0, start = o->first, pieces = 1;
	for (int e = 0; e < o->n_edges; e++) {
		double place, distance = edge_distance(f->mpm, o, e, load, &place);
		int n = wall_pieces(f->mpm, o->wall, e);
		if (distance < best)
			best = distance, at = place, edge = e, start = first, pieces = n;
		first += n;
	}
	wall_edge(f->mpm, o->wall, edge, ends);
	double tx = ends[1][0] - ends[0][0], ty = ends[1][1] - ends[0][1], length = hypot(tx, ty);
	double press = -(load->force[0] * load->normal[0] + load->force[1] * load->normal[1]);
	double drag = (load->force[0] * tx + load->force[1] * ty) / length;
	int piece = (int)fmin(floor(at * pieces), pieces - 1);
	double beyond = at * pieces - piece;
	for (int k = 0; k < 2; k++) {
		f->pressure[start + piece + k] += press * (k ? beyond : 1 - beyond);
		f->shear[start + piece + k] += drag * (k ? beyond : 1 - beyond);
	}
}

/* The first and the last point of a polygon are one. */
static void close_outline(double *values, const struct outline *o)
{
	if (o->closed)
		values[o->first] = values[o->first + o->n - 1] = values[o->first] + values[o->first + o->n - 1];
}

static int add_loads(struct wall_frame *f)
{
	int n = mpm_wall_loads(f->mpm, NULL, 0);
	struct mpm_wall_load *loads = malloc(sizeof *loads * (size_t)(n + 1));
	if (!loads)
		return error_set(STATUS_RESOURCE, "out of memory for %d loads of walls", n);
	mpm_wall_loads(f->mpm, loads, n);
	for (int o = 0; o < f->n_outlines; o++) {
		const struct outline *outline = &f->outlines[o];
		for (int k = 0; k < n; k++)
			if (loads[k].wall == outline->wall)
				add_load(f, outline, &loads[k]);
		close_outline(f->pressure, outline);
		close_outline(f->shear, outline);
		close_outline(f->length, outline);
		for (int p = outline->first; p < outline->first + outline->n; p++) {
			double area = f->length[p] * f->mpm->grid.thickness;
			f->pressure[p] = area > 0 ? f->pressure[p] / area : 0;
			f->shear[p] = area > 0 ? f->shear[p] / area : 0;
		}
	}
	free(loads);
	return STATUS_OK;
}

/* ---- the channel ---- */

static int add_cells(struct wall_frame *f)
{
	int n = f->n_outlines;
	int32_t *offsets = frame_array_add(f->builder, "offsets", "-", FRAME_GEOMETRY, FRAME_I32, 1, n + 1);
	for (int o = 0; offsets && o < n; o++)
		offsets[o + 1] = f->outlines[o].first + f->outlines[o].n;
	int32_t *number = frame_array_add(f->builder, "wall", "-", FRAME_CELL, FRAME_I32, 1, n);
	for (int o = 0; number && o < n; o++)
		number[o] = f->outlines[o].wall;
	double(*force)[3] = frame_array_add(f->builder, "force", "N", FRAME_CELL, FRAME_F64, 3, n);
	for (int o = 0; force && o < n; o++)
		for (int c = 0; c < 2; c++)
			force[o][c] = f->mpm->walls[f->outlines[o].wall].force[c];
	return offsets && number && force ? STATUS_OK : error_set(STATUS_RESOURCE, "out of memory for a frame");
}

/* Pointers into the frame end with the next array, so that everything is worked out beforehand. */
static int add_points(struct wall_frame *f)
{
	const struct {
		const char *name, *unit;
		int location, components;
		const void *values;
	} arrays[] = {{"coordinates", "m", FRAME_GEOMETRY, 3, f->x},
				  {"pressure", "Pa", FRAME_POINT, 1, f->pressure},
				  {"shear", "Pa", FRAME_POINT, 1, f->shear}};
	for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++) {
		size_t bytes = sizeof(double) * (size_t)(arrays[k].components * f->n_points);
		void *to = frame_array_add(f->builder, arrays[k].name, arrays[k].unit, arrays[k].location, FRAME_F64,
								   arrays[k].components, f->n_points);
		if (!to)
			return error_set(STATUS_RESOURCE, "out of memory for a frame");
		memcpy(to, arrays[k].values, bytes);
	}
	return STATUS_OK;
}

static int add_channel(struct wall_frame *f)
{
	size_t n = (size_t)f->n_points + 1;
	f->x = calloc(n, sizeof *f->x);
	f->pressure = calloc(n, sizeof *f->pressure);
	f->shear = calloc(n, sizeof *f->shear);
	f->length = calloc(n, sizeof *f->length);
	if (!f->x || !f->pressure || !f->shear || !f->length ||
		!frame_channel_add(f->builder, "walls", FRAME_POLYLINES, f->n_points, f->n_outlines))
		return error_set(STATUS_RESOURCE, "out of memory for a frame");
	for (int o = 0; o < f->n_outlines; o++)
		place_points(f, &f->outlines[o]);
	CHECK(add_loads(f));
	CHECK(add_points(f));
	return add_cells(f);
}

int frame_walls_add(struct frame_builder *builder, const struct mpm *mpm)
{
	struct wall_frame f = {.mpm = mpm, .builder = builder};
	f.outlines = calloc((size_t)mpm->scene->n_walls + 1, sizeof *f.outlines);
	int status = f.outlines ? STATUS_OK : error_set(STATUS_RESOURCE, "out of memory for a frame");
	if (status == STATUS_OK)
		find_outlines(&f);
	if (status == STATUS_OK && f.n_outlines > 0)
		status = add_channel(&f);
	free(f.outlines);
	free(f.x);
	free(f.pressure);
	free(f.shear);
	free(f.length);
	return status;
}
