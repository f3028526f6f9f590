#include "run/frame_rve.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "base/mat2.h"

/* What is drawn: contacts, then broken bonds whose discs have parted; both also at the cell's other border. */
struct frame_drawn {
	struct frame_builder *builder;
	const struct frame_rve_view *view;
	struct frame_rve rve; /* as a whole */
	double H[4];
	char note[256];
	int n_discs, n_contacts, n_drawn;
	struct rve_disc *discs;
	struct rve_contact *contacts;
	int *image;
	bool failed;
};

static void *drawn_array(struct frame_drawn *d, const char *name, const char *unit, int location, int type,
						 int components, int n)
{
	void *data = d->failed ? NULL : frame_array_add(d->builder, name, unit, location, type, components, n);
	d->failed |= !data;
	return data;
}

/* One member of n structs, `stride` bytes apart, as an array; `first` is that of the first. */
static void drawn_reals(struct frame_drawn *d, const char *name, const char *unit, int location, int n,
						const double *first, size_t stride)
{
	double *to = drawn_array(d, name, unit, location, FRAME_F64, 1, n);
	for (int k = 0; to && k < n; k++)
		to[k] = *(const double *)((const char *)first + (size_t)k * stride);
}

static void drawn_integers(struct frame_drawn *d, const char *name, int location, int n, const int *first,
						   size_t stride)
{
	int32_t *to = drawn_array(d, name, "-", location, FRAME_I32, 1, n);
	for (int k = 0; to && k < n; k++)
		to[k] = *(const int *)((const char *)first + (size_t)k * stride);
}

static void drawn_channel(struct frame_drawn *d, const char *what, int kind, int n_points, int n_cells)
{
	char name[FRAME_NAME];
	snprintf(name, sizeof name, "rve_%.48s_%s", d->view->name, what);
	struct frame_channel *channel = d->failed ? NULL : frame_channel_add(d->builder, name, kind, n_points, n_cells);
	d->failed |= !channel;
	if (!channel)
		return;
	memcpy(channel->cell_matrix, d->H, sizeof channel->cell_matrix);
	memcpy(channel->note, d->note, sizeof channel->note);
	channel->rve = d->rve;
}

static void drawn_discs(struct frame_drawn *d)
{
	const struct rve_disc *discs = d->discs;
	int n = d->n_discs;
	double temperature = d->view->temperature;
	drawn_channel(d, "discs", FRAME_VERTICES, n, n);
	double(*x)[3] = drawn_array(d, "coordinates", "m", FRAME_GEOMETRY, FRAME_F64, 3, n);
	for (int i = 0; x && i < n; i++)
		x[i][0] = discs[i].x, x[i][1] = discs[i].y;
	drawn_reals(d, "radius", "m", FRAME_POINT, n, &discs->radius, sizeof *discs);
	double(*u)[3] = drawn_array(d, "displacement", "m", FRAME_POINT, FRAME_F64, 3, n);
	for (int i = 0; u && i < n; i++)
		u[i][0] = discs[i].displacement[0], u[i][1] = discs[i].displacement[1];
	drawn_reals(d, "rotation", "rad", FRAME_POINT, n, &discs->rotation, sizeof *discs);
	drawn_integers(d, "coordination", FRAME_POINT, n, &discs->contacts, sizeof *discs);
	drawn_reals(d, "temperature", d->view->celsius ? "C" : "K", FRAME_POINT, n, &temperature, 0);
}

static void drawn_contacts(struct frame_drawn *d)
{
	const struct rve_contact *contacts = d->contacts;
	int n = d->n_drawn;
	size_t stride = sizeof *contacts;
	drawn_channel(d, "contacts", FRAME_SEGMENTS, 2 * n, n);
	double(*x)[3] = drawn_array(d, "coordinates", "m", FRAME_GEOMETRY, FRAME_F64, 3, 2 * n);
	for (int k = 0; x && k < n; k++)
		for (int end = 0; end < 2; end++)
			x[2 * k + end][0] = contacts[k].ends[end][0], x[2 * k + end][1] = contacts[k].ends[end][1];
	drawn_reals(d, "normal_force", "N", FRAME_CELL, n, &contacts->normal_force, stride);
	drawn_reals(d, "tangential_force", "N", FRAME_CELL, n, &contacts->tangential_force, stride);
	drawn_reals(d, "mobilisation", "-", FRAME_CELL, n, &contacts->mobilisation, stride);
	drawn_integers(d, "sliding", FRAME_CELL, n, &contacts->sliding, stride);
	drawn_integers(d, "bond", FRAME_CELL, n, &contacts->bond, stride);
	drawn_integers(d, "image", FRAME_CELL, n, d->image, sizeof *d->image);
}

/* Contacts across the cell's border twice, once at each border, so that force chains can be read there;
 * `image` marks the second copy. */
static void drawn_expand(struct frame_drawn *d, int n)
{
	d->n_drawn = n;
	for (int k = 0; k < n; k++) {
		int sx = d->contacts[k].shift[0], sy = d->contacts[k].shift[1];
		if (!sx && !sy)
			continue;
		struct rve_contact *copy = &d->contacts[d->n_drawn];
		*copy = d->contacts[k];
		d->image[d->n_drawn++] = 1;
		for (int end = 0; end < 2; end++) {
			copy->ends[end][0] -= d->H[0] * sx + d->H[1] * sy;
			copy->ends[end][1] -= d->H[2] * sx + d->H[3] * sy;
		}
	}
}

static void drawn_fabric(struct frame_drawn *d)
{
	double *fabric = d->rve.fabric;
	int used = 0;
	for (int k = 0; k < d->n_contacts; k++) {
		const struct rve_contact *c = &d->contacts[k];
		double x = c->ends[1][0] - c->ends[0][0], y = c->ends[1][1] - c->ends[0][1], l2 = x * x + y * y;
		if (c->normal_force == 0.0)
			continue;
		fabric[0] += x * x / l2, fabric[1] += y * y / l2, fabric[2] += x * y / l2;
		used++;
	}
	for (int k = 0; used && k < 3; k++)
		fabric[k] /= used;
}

static void drawn_note(struct frame_drawn *d, const struct rve_info *info)
{
	const struct frame_rve_view *view = d->view;
	size_t size = sizeof d->note;
	int n = 0;
	if (view->point >= 0)
		n += snprintf(d->note, size, "point %lld%s%s%s, ", view->point, *d->rve.rule ? " (" : "", d->rve.rule,
					  *d->rve.rule ? ")" : "");
	n += snprintf(d->note + n, size - (size_t)n, "p = %.3g kPa, e = %.3f, Z = %.2f", info->pressure * 1e-3,
				  info->void_ratio, info->coordination);
	if (view->thermal)
		n += snprintf(d->note + n, size - (size_t)n, ", T = %.5g %s", view->temperature,
					  view->celsius ? "\302\260C" : "K");
	if (info->bonds_installed > 0)
		n += snprintf(d->note + n, size - (size_t)n, ", bonds %.0f%%", 100.0 * info->bond_fraction);
	if (info->flags & RVE_GAS)
		n += snprintf(d->note + n, size - (size_t)n, ", flying");
	if (info->flags & RVE_FROZEN)
		snprintf(d->note + n, size - (size_t)n, ", frozen");
}

static void drawn_whole(struct frame_drawn *d, const struct rve_info *info)
{
	const struct frame_rve_view *view = d->view;
	double strain[3];
	mat2_log_stretch(view->F, strain);
	d->rve = (struct frame_rve){
		.time = view->time,
		.point = view->point,
		.strain = {strain[0], strain[1], 0.0, strain[2]},
		.void_ratio = info->void_ratio,
		.coordination = info->coordination,
		.temperature = view->thermal ? view->temperature : NAN,
		.bonds_installed = info->bonds_installed,
		.bonds_intact = info->bonds_intact,
		.flags = (info->flags & RVE_GAS ? FRAME_RVE_FLYING : 0) | (info->flags & RVE_FROZEN ? FRAME_RVE_FROZEN : 0) |
				 (view->birth ? FRAME_RVE_BIRTH : 0),
	};
	snprintf(d->rve.rule, sizeof d->rve.rule, "%s", view->rule ? view->rule : "");
	memcpy(d->rve.stress, view->stress, sizeof d->rve.stress);
	memcpy(d->H, info->H, sizeof d->H);
	drawn_fabric(d);
	drawn_note(d, info);
}

int frame_rve_add(struct frame_builder *builder, const struct frame_rve_view *view)
{
	int capacity = rve_contact_capacity(view->model);
	struct frame_drawn d = {.builder = builder, .view = view, .n_discs = rve_discs(view->model)};
	struct rve_info info;
	rve_get_info(view->model, view->state, &info);
	d.discs = malloc(sizeof *d.discs * (size_t)d.n_discs);
	d.contacts = malloc(sizeof *d.contacts * 2 * (size_t)(capacity + 1));
	d.image = calloc(2 * (size_t)(capacity + 1), sizeof *d.image);
	d.failed = !d.discs || !d.contacts || !d.image;
	if (!d.failed) {
		d.n_contacts = rve_inspect(view->model, view->state, d.discs, d.contacts, capacity);
		int parted = rve_inspect_parted(view->model, view->state, d.contacts + d.n_contacts, capacity - d.n_contacts);
		drawn_whole(&d, &info);
		drawn_expand(&d, d.n_contacts + parted);
		drawn_discs(&d);
		drawn_contacts(&d);
	}
	free(d.discs), free(d.contacts), free(d.image);
	return d.failed ? error_set(STATUS_RESOURCE, "out of memory for the frame of an RVE") : STATUS_OK;
}
