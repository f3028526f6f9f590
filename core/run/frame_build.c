#include "run/frame_build.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "run/frame_rve.h"
#include "run/frame_walls.h"

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

/* ---- grid ---- */

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

/* ---- RVEs ---- */

void frame_birth_name(char name[FRAME_NAME], const char *rve) { snprintf(name, FRAME_NAME, "%.40s_birth", rve); }

/* The start packing of an RVE that is shown. */
static void frame_birth(struct frame_work *work, const struct frame_rve_view *now)
{
	char name[FRAME_NAME];
	struct frame_rve_view birth = {
		.name = name, .rule = "", .model = now->model, .point = now->point, .F = {1, 0, 0, 1}, .celsius = now->celsius};
	struct rve_info info;
	double conductivity[3], modulus;
	void *state = aligned_alloc(64, (rve_state_bytes(now->model) + 63) / 64 * 64);
	frame_birth_name(name, now->name);
	rve_get_info(now->model, now->state, &info);
	work->failed |= !state || rve_init(now->model, info.variant, state) != STATUS_OK;
	if (!work->failed) {
		birth.state = state;
		birth.temperature = NAN;
		birth.birth = true;
		rve_evaluate(now->model, state, birth.stress, conductivity, &modulus);
		work->failed |= frame_rve_add(work->builder, &birth) != STATUS_OK;
	}
	free(state);
}

static void frame_inspected(struct frame_work *work, const struct inspected *inspected, const struct inspected_rve *rve)
{
	const struct mpm *mpm = work->mpm;
	struct frame_rve_view view = {.name = rve->name,
								  .rule = rve->rule ? rve->rule->name : "",
								  .celsius = mpm->scene->units.celsius,
								  .thermal = mpm->thermal};
	int point;
	work->failed |= inspected_point(inspected, rve, &point) != STATUS_OK;
	const struct law *law = point >= 0 ? mpm->laws[mpm->p.law[point]] : NULL;
	if (!law || law->type->rve_view(law, mpm->p.slot[point], &view.model, &view.state) != STATUS_OK)
		return;
	view.time = mpm->time;
	view.point = mpm->p.id[point];
	memcpy(view.stress, mpm->p.stress[point], sizeof view.stress);
	memcpy(view.F, mpm->p.F[point], sizeof view.F);
	view.temperature = scene_temperature_out(mpm->scene, mpm->p.T[point]);
	work->failed |= frame_rve_add(work->builder, &view) != STATUS_OK;
	for (int i = 0; i < mpm->scene->n_images; i++)
		if (mpm->scene->images[i].before && !strcmp(mpm->scene->images[i].rve, rve->name)) {
			frame_birth(work, &view);
			return;
		}
}

int frame_build(struct frame_builder *builder, const struct mpm *mpm, struct run_fields *fields,
				const struct inspected *inspected, const void **frame, int64_t *bytes)
{
	const struct scene *scene = mpm->scene;
	struct frame_work work = {builder, mpm, fields, false};
	frame_begin(builder, mpm->step, mpm->time, scene->title, scene_temperature_unit(scene));
	frame_points(&work);
	frame_domains(&work);
	frame_grid(&work);
	work.failed |= frame_walls_add(builder, mpm) != STATUS_OK;
	for (int i = 0; i < inspected->n; i++)
		frame_inspected(&work, inspected, &inspected->rves[i]);
	*frame = work.failed ? NULL : frame_finish(builder, bytes);
	return *frame ? STATUS_OK : error_set(STATUS_RESOURCE, "out of memory for a frame");
}
