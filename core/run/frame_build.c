#include "run/frame_build.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "rve/rve.h"

struct frame_work {
	struct frame_builder *builder;
	const struct mpm *mpm;
	struct run_fields *fields;
	bool failed; /* out of memory */
};

static struct frame_channel *frame_new_channel(struct frame_work *work, const char *name, int kind, int64_t points,
											   int64_t cells)
{
	struct frame_channel *channel = frame_channel_add(work->builder, name, kind, points, cells);
	work->failed |= !channel;
	return channel;
}

static void *frame_new_array(struct frame_work *work, const char *name, const char *unit, int location, int type,
							 int components, int64_t count)
{
	if (work->failed)
		return NULL;
	void *data = frame_array_add(work->builder, name, unit, location, type, components, count);
	work->failed |= !data;
	return data;
}

static double (*frame_coordinates(struct frame_work *work, int64_t count))[3]
{
	return frame_new_array(work, "coordinates", "m", FRAME_GEOMETRY, FRAME_F64, 3, count);
}

/* ---- points and their domains ---- */

static void frame_point_arrays(struct frame_work *work, int location)
{
	const struct particles *p = &work->mpm->p;
	int32_t *id = frame_new_array(work, "id", "-", location, FRAME_I32, 1, p->n);
	if (id)
		memcpy(id, p->id, (size_t)p->n * sizeof *id);
	int32_t *material = frame_new_array(work, "material", "-", location, FRAME_I32, 1, p->n);
	if (material)
		memcpy(material, p->material, (size_t)p->n * sizeof *material);
	for (int f = 0; f < work->fields->n; f++) {
		const struct run_field *field = &work->fields->fields[f];
		double *values =
			frame_new_array(work, field->field->name, field->unit, location, FRAME_F64, field->field->components, p->n);
		if (values)
			fields_get(work->fields, work->mpm, f, values);
	}
}

static void frame_points(struct frame_work *work)
{
	const struct particles *p = &work->mpm->p;
	if (!frame_new_channel(work, "points", FRAME_VERTICES, p->n, p->n))
		return;
	double(*x)[3] = frame_coordinates(work, p->n);
	for (int i = 0; x && i < p->n; i++)
		x[i][0] = p->x[i][0], x[i][1] = p->x[i][1], x[i][2] = 0;
	frame_point_arrays(work, FRAME_POINT);
}

static void frame_domains(struct frame_work *work)
{
	const struct particles *p = &work->mpm->p;
	double thickness = work->mpm->scene->grid.thickness;
	if (!frame_new_channel(work, "domains", FRAME_QUADS, 4 * (int64_t)p->n, p->n))
		return;
	double(*x)[3] = frame_coordinates(work, 4 * (int64_t)p->n);
	for (int i = 0; x && i < p->n; i++) {
		double corners[4][2];
		frame_domain(p->x[i], p->F[i], sqrt(p->volume0[i] / thickness), corners);
		for (int c = 0; c < 4; c++)
			x[4 * i + c][0] = corners[c][0], x[4 * i + c][1] = corners[c][1], x[4 * i + c][2] = 0;
	}
	frame_point_arrays(work, FRAME_CELL);
}

/* ---- grid and walls ---- */

static void frame_grid(struct frame_work *work)
{
	const struct grid *grid = &work->mpm->grid;
	int64_t n = (int64_t)grid->nx * grid->ny;
	struct frame_channel *channel =
		frame_new_channel(work, "grid", FRAME_IMAGE, n, (int64_t)(grid->nx - 1) * (grid->ny - 1));
	if (!channel)
		return;
	channel->dims[0] = grid->nx, channel->dims[1] = grid->ny;
	channel->origin[0] = grid->origin[0], channel->origin[1] = grid->origin[1];
	channel->spacing[0] = grid->spacing[0], channel->spacing[1] = grid->spacing[1];
	double *mass = frame_new_array(work, "mass", "kg", FRAME_POINT, FRAME_F64, 1, n);
	if (mass)
		memcpy(mass, grid->mass, (size_t)n * sizeof *mass);
	double(*v)[3] = frame_new_array(work, "velocity", "m/s", FRAME_POINT, FRAME_F64, 3, n);
	for (int64_t i = 0; v && i < n; i++)
		if (grid->mass[i] > 0)
			v[i][0] = grid->v_new[i][0], v[i][1] = grid->v_new[i][1];
	if (!work->mpm->thermal)
		return;
	double *T =
		frame_new_array(work, "temperature", scene_temperature_unit(work->mpm->scene), FRAME_POINT, FRAME_F64, 1, n);
	for (int64_t i = 0; T && i < n; i++)
		T[i] = grid->mass[i] > 0 ? scene_temperature_out(work->mpm->scene, grid->T_new[i]) : NAN;
}

static bool frame_wall_active(const struct mpm *mpm, int w)
{
	const struct scene *scene = mpm->scene;
	const struct scene_wall *wall = &scene->walls[w];
	if (mpm->time < wall->from || mpm->time >= wall->until)
		return false;
	if (mpm->stage < 0 || mpm->stage >= scene->n_stages || scene->stages[mpm->stage].n_walls < 0)
		return true;
	for (int i = 0; i < scene->stages[mpm->stage].n_walls; i++)
		if (scene->stages[mpm->stage].walls[i] == w)
			return true;
	return false;
}

/* A polygon's outline is closed by its first corner. */
static int frame_wall_points(const struct scene_wall *wall)
{
	return wall->n_vertices + (wall->shape == SCENE_WALL_POLYGON ? 1 : 0);
}

/* The walls that are active now, where they are now. */
static void frame_walls(struct frame_work *work)
{
	const struct mpm *mpm = work->mpm;
	const struct scene *scene = mpm->scene;
	int n_points = 0, n_walls = 0;
	for (int w = 0; w < scene->n_walls; w++)
		if (frame_wall_active(mpm, w))
			n_points += frame_wall_points(&scene->walls[w]), n_walls++;
	if (!n_walls || !frame_new_channel(work, "walls", FRAME_POLYLINES, n_points, n_walls))
		return;
	double(*x)[3] = frame_coordinates(work, n_points);
	for (int w = 0, i = 0; x && w < scene->n_walls; w++)
		if (frame_wall_active(mpm, w))
			for (int v = 0; v < frame_wall_points(&scene->walls[w]); v++, i++)
				for (int c = 0; c < 2; c++)
					x[i][c] = scene->walls[w].vertices[v % scene->walls[w].n_vertices][c] + mpm->wall_offset[w][c];
	int32_t *offsets = frame_new_array(work, "offsets", "-", FRAME_GEOMETRY, FRAME_I32, 1, n_walls + 1);
	for (int w = 0, cell = 0; offsets && w < scene->n_walls; w++)
		if (frame_wall_active(mpm, w))
			offsets[cell + 1] = offsets[cell] + frame_wall_points(&scene->walls[w]), cell++;
	int32_t *number = frame_new_array(work, "wall", "-", FRAME_CELL, FRAME_I32, 1, n_walls);
	for (int w = 0, cell = 0; number && w < scene->n_walls; w++)
		if (frame_wall_active(mpm, w))
			number[cell++] = w;
	double(*force)[3] = frame_new_array(work, "force", "N", FRAME_CELL, FRAME_F64, 3, n_walls);
	for (int w = 0, cell = 0; force && w < scene->n_walls; w++)
		if (frame_wall_active(mpm, w)) {
			force[cell][0] = mpm->walls[w].force[0];
			force[cell++][1] = mpm->walls[w].force[1];
		}
}

/* ---- RVEs ---- */

/* One member of n structs, `stride` bytes apart, as an array; `first` is that of the first. */
static void frame_reals(struct frame_work *work, const char *name, const char *unit, int location, int n,
						const double *first, size_t stride)
{
	double *to = frame_new_array(work, name, unit, location, FRAME_F64, 1, n);
	for (int k = 0; to && k < n; k++)
		to[k] = *(const double *)((const char *)first + (size_t)k * stride);
}

static void frame_integers(struct frame_work *work, const char *name, int location, int n, const int *first,
						   size_t stride)
{
	int32_t *to = frame_new_array(work, name, "-", location, FRAME_I32, 1, n);
	for (int k = 0; to && k < n; k++)
		to[k] = *(const int *)((const char *)first + (size_t)k * stride);
}

static void frame_discs(struct frame_work *work, const char *name, const struct rve_disc *discs, int n,
						const double H[4], const char *note, double temperature)
{
	char channel_name[FRAME_NAME];
	snprintf(channel_name, sizeof channel_name, "rve_%.48s_discs", name);
	struct frame_channel *channel = frame_new_channel(work, channel_name, FRAME_VERTICES, n, n);
	if (!channel)
		return;
	memcpy(channel->cell_matrix, H, sizeof channel->cell_matrix);
	snprintf(channel->note, sizeof channel->note, "%s", note);
	double(*x)[3] = frame_coordinates(work, n);
	for (int i = 0; x && i < n; i++)
		x[i][0] = discs[i].x, x[i][1] = discs[i].y;
	frame_reals(work, "radius", "m", FRAME_POINT, n, &discs->radius, sizeof *discs);
	double(*u)[3] = frame_new_array(work, "displacement", "m", FRAME_POINT, FRAME_F64, 3, n);
	for (int i = 0; u && i < n; i++)
		u[i][0] = discs[i].displacement[0], u[i][1] = discs[i].displacement[1];
	frame_reals(work, "rotation", "rad", FRAME_POINT, n, &discs->rotation, sizeof *discs);
	frame_integers(work, "coordination", FRAME_POINT, n, &discs->contacts, sizeof *discs);
	frame_reals(work, "temperature", scene_temperature_unit(work->mpm->scene), FRAME_POINT, n, &temperature, 0);
}

/* Contacts across the cell's border twice, once at each border, so that force chains can be read there;
 * `image` marks the second copy. */
static int frame_expand_contacts(struct rve_contact *contacts, int *image, int n, const double H[4])
{
	int total = n;
	for (int k = 0; k < n; k++) {
		image[k] = 0;
		int sx = contacts[k].shift[0], sy = contacts[k].shift[1];
		if (!sx && !sy)
			continue;
		contacts[total] = contacts[k];
		image[total] = 1;
		for (int end = 0; end < 2; end++) {
			contacts[total].ends[end][0] -= H[0] * sx + H[1] * sy;
			contacts[total].ends[end][1] -= H[2] * sx + H[3] * sy;
		}
		total++;
	}
	return total;
}

static void frame_contact_numbers(struct frame_work *work, const struct rve_contact *contacts, const int *image, int n)
{
	size_t stride = sizeof *contacts;
	frame_reals(work, "normal_force", "N", FRAME_CELL, n, &contacts->normal_force, stride);
	frame_reals(work, "tangential_force", "N", FRAME_CELL, n, &contacts->tangential_force, stride);
	frame_reals(work, "mobilisation", "-", FRAME_CELL, n, &contacts->mobilisation, stride);
	frame_integers(work, "sliding", FRAME_CELL, n, &contacts->sliding, stride);
	frame_integers(work, "bond", FRAME_CELL, n, &contacts->bond, stride);
	frame_integers(work, "image", FRAME_CELL, n, image, sizeof *image);
}

static void frame_contacts(struct frame_work *work, const char *name, const struct rve_contact *contacts,
						   const int *image, int n, const double H[4], const char *note)
{
	char channel_name[FRAME_NAME];
	snprintf(channel_name, sizeof channel_name, "rve_%.48s_contacts", name);
	struct frame_channel *channel = frame_new_channel(work, channel_name, FRAME_SEGMENTS, 2 * (int64_t)n, n);
	if (!channel)
		return;
	memcpy(channel->cell_matrix, H, sizeof channel->cell_matrix);
	snprintf(channel->note, sizeof channel->note, "%s", note);
	double(*x)[3] = frame_coordinates(work, 2 * (int64_t)n);
	for (int k = 0; x && k < n; k++)
		for (int end = 0; end < 2; end++)
			x[2 * k + end][0] = contacts[k].ends[end][0], x[2 * k + end][1] = contacts[k].ends[end][1];
	frame_contact_numbers(work, contacts, image, n);
}

static void frame_rve_note(const struct mpm *mpm, const struct rve_info *info, int point, char note[256])
{
	int n = snprintf(note, 256, "p = %.3g kPa, e = %.3f, Z = %.2f", info->pressure * 1e-3, info->void_ratio,
					 info->coordination);
	if (mpm->thermal)
		n += snprintf(note + n, 256 - (size_t)n, ", T = %.5g %s%s", scene_temperature_out(mpm->scene, mpm->p.T[point]),
					  mpm->scene->units.celsius ? "\302\260" : "", scene_temperature_unit(mpm->scene));
	if (info->bonds_installed > 0)
		n += snprintf(note + n, 256 - (size_t)n, ", bonds %.0f%%", 100.0 * info->bond_fraction);
	if (info->flags & RVE_GAS)
		n += snprintf(note + n, 256 - (size_t)n, ", flying");
	if (info->flags & RVE_FROZEN)
		snprintf(note + n, 256 - (size_t)n, ", frozen");
}

static void frame_rve(struct frame_work *work, const struct scene_inspect *inspect)
{
	const struct mpm *mpm = work->mpm;
	int point = inspect->id >= 0 ? mpm_point_by_id(mpm, (int)inspect->id) : mpm_point_nearest_initial(mpm, inspect->at);
	const struct law *law = point >= 0 ? mpm->laws[mpm->p.law[point]] : NULL;
	const struct rve_model *model;
	const void *state;
	if (!law || !law->type->rve_view || law->type->rve_view(law, mpm->p.slot[point], &model, &state) != STATUS_OK)
		return;
	struct rve_info info;
	char note[256];
	rve_get_info(model, state, &info);
	frame_rve_note(mpm, &info, point, note);
	int n = rve_discs(model), capacity = rve_contact_capacity(model);
	struct rve_disc *discs = malloc(sizeof *discs * (size_t)n);
	struct rve_contact *contacts = malloc(sizeof *contacts * 2 * (size_t)(capacity + 1));
	int *image = malloc(sizeof *image * 2 * (size_t)(capacity + 1));
	if (discs && contacts && image) {
		int n_contacts = rve_inspect(model, state, discs, contacts, capacity);
		int n_drawn = frame_expand_contacts(contacts, image, n_contacts < capacity ? n_contacts : capacity, info.H);
		frame_discs(work, inspect->name, discs, n, info.H, note, scene_temperature_out(mpm->scene, mpm->p.T[point]));
		frame_contacts(work, inspect->name, contacts, image, n_drawn, info.H, note);
	} else {
		work->failed = true;
	}
	free(discs);
	free(contacts);
	free(image);
}

int frame_build(struct frame_builder *builder, const struct mpm *mpm, struct run_fields *fields, const void **frame,
				int64_t *bytes)
{
	const struct scene *scene = mpm->scene;
	struct frame_work work = {builder, mpm, fields, false};
	frame_begin(builder, mpm->step, mpm->time, scene->title, scene_temperature_unit(scene));
	frame_points(&work);
	frame_domains(&work);
	frame_grid(&work);
	frame_walls(&work);
	for (int i = 0; i < scene->n_inspect; i++)
		frame_rve(&work, &scene->inspect[i]);
	*frame = work.failed ? NULL : frame_finish(builder, bytes);
	return *frame ? STATUS_OK : error_set(STATUS_RESOURCE, "out of memory for a frame");
}
