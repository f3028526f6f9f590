#include <dirent.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "io/h5.h"
#include "io/vtk.h"
#include "run/frame_build.h"
#include "run/run_private.h"
#include "version.h"

enum { STEP_DIGITS = 8 };

/* One .pvd: the files of one channel over time. */
struct series {
	char name[FRAME_NAME];
	char end[4]; /* vtp or vti */
	int n, capacity;
	struct series_entry {
		long long step;
		double time;
	} * entries;
	char file[FRAME_NAME + 8]; /* NAME.pvd */
};

struct snapshots {
	const struct mpm *mpm;
	struct run_fields *fields;
	const struct inspected *inspected;
	char folder[FILE_PATH];
	long long *steps; /* of the snap/ files */
	int n, capacity;
	int n_series;
	struct series *series;
	double *values; /* one field of all points, or of the grid */
};

/* ---- lists ---- */

static int snapshots_add_step(struct snapshots *s, long long step)
{
	for (int i = 0; i < s->n; i++)
		if (s->steps[i] == step)
			return STATUS_OK;
	if (s->n == s->capacity) {
		int capacity = 2 * s->capacity + 64;
		long long *larger = realloc(s->steps, sizeof *larger * (size_t)capacity);
		if (!larger)
			return error_set(STATUS_RESOURCE, "out of memory");
		s->steps = larger, s->capacity = capacity;
	}
	int i = s->n++;
	for (; i > 0 && s->steps[i - 1] > step; i--)
		s->steps[i] = s->steps[i - 1];
	s->steps[i] = step;
	return STATUS_OK;
}

static int series_add(struct series *series, long long step, double time)
{
	if (series->n > 0 && series->entries[series->n - 1].step == step)
		return STATUS_OK;
	if (series->n == series->capacity) {
		int capacity = 2 * series->capacity + 64;
		struct series_entry *larger = realloc(series->entries, sizeof *larger * (size_t)capacity);
		if (!larger)
			return error_set(STATUS_RESOURCE, "out of memory");
		series->entries = larger, series->capacity = capacity;
	}
	series->entries[series->n++] = (struct series_entry){step, time};
	return STATUS_OK;
}

static struct series *series_find(struct snapshots *s, const char *name)
{
	for (int i = 0; i < s->n_series; i++)
		if (!strcmp(s->series[i].name, name))
			return &s->series[i];
	struct series *larger = realloc(s->series, ((size_t)s->n_series + 1) * sizeof *larger);
	if (!larger)
		return NULL;
	s->series = larger;
	struct series *series = &s->series[s->n_series++];
	*series = (struct series){0};
	snprintf(series->name, sizeof series->name, "%s", name);
	snprintf(series->file, sizeof series->file, "%s.pvd", name);
	snprintf(series->end, sizeof series->end, "vtp");
	return series;
}

static int series_write(const struct snapshots *s, const struct series *series)
{
	char path[FILE_PATH];
	CHECK(file_join(path, s->folder, series->file));
	struct file_output output;
	CHECK(file_output_begin(&output, path));
	output.unsynced = true;
	fprintf(output.stream,
			"<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n"
			"<Collection>\n");
	for (int i = 0; i < series->n; i++)
		fprintf(output.stream, "<DataSet timestep=\"%.17g\" part=\"0\" file=\"vtk/%s_%0*lld.%s\"/>\n",
				series->entries[i].time, series->name, STEP_DIGITS, series->entries[i].step, series->end);
	fprintf(output.stream, "</Collection>\n</VTKFile>\n");
	return file_output_commit(&output);
}

/* ---- a restart takes up the lists where the checkpoint cut them ---- */

static int series_read(struct snapshots *s, const char *file)
{
	char path[FILE_PATH], name[FRAME_NAME];
	snprintf(name, sizeof name, "%.*s", (int)(strlen(file) - strlen(".pvd")), file);
	struct series *series = series_find(s, name);
	CHECK(file_join(path, s->folder, file));
	char *text;
	size_t size;
	CHECK(file_read(&text, &size, path));
	int status = STATUS_OK;
	for (char *at = text; series && status == STATUS_OK && (at = strstr(at, "<DataSet timestep=\"")); at++) {
		double time = strtod(at + strlen("<DataSet timestep=\""), NULL);
		const char *quote = strstr(at, "file=\"vtk/"), *end = quote ? strchr(quote + 6, '"') : NULL;
		if (!end)
			continue;
		long long step = strtoll(end - 4 - STEP_DIGITS, NULL, 10);
		memcpy(series->end, end - 3, 3);
		if (step <= s->mpm->step)
			status = series_add(series, step, time);
	}
	free(text);
	return status == STATUS_OK && series ? series_write(s, series) : status;
}

static int snapshots_scan(struct snapshots *s, const char *folder, int (*take)(struct snapshots *, const char *file),
						  const char *end)
{
	DIR *stream = opendir(folder);
	if (!stream)
		return errno == ENOENT ? STATUS_OK : error_set(STATUS_RESOURCE, "cannot read %s: %s", folder, strerror(errno));
	int status = STATUS_OK;
	for (struct dirent *entry; status == STATUS_OK && (entry = readdir(stream));)
		if (entry->d_name[0] != '.' && file_has_end(entry->d_name, end))
			status = take(s, entry->d_name);
	closedir(stream);
	return status;
}

static int snapshots_take_file(struct snapshots *s, const char *file)
{
	long long step = strtoll(file, NULL, 10);
	return step <= s->mpm->step ? snapshots_add_step(s, step) : STATUS_OK;
}

static int series_compare(const void *a, const void *b)
{
	return strcmp(((const struct series *)a)->name, ((const struct series *)b)->name);
}

static int snapshots_write_links(const struct snapshots *s);

static int snapshots_take_up(struct snapshots *s)
{
	char below[FILE_PATH];
	CHECK(file_join(below, s->folder, "snap"));
	CHECK(snapshots_scan(s, below, snapshots_take_file, ".h5"));
	CHECK(snapshots_scan(s, s->folder, series_read, ".pvd"));
	if (s->n_series)
		qsort(s->series, (size_t)s->n_series, sizeof *s->series, series_compare); /* folders have no order */
	return s->n ? snapshots_write_links(s) : STATUS_OK;
}

int snapshots_create(struct snapshots **result, const struct inspected *inspected, const char *folder, bool restart)
{
	*result = NULL;
	struct snapshots *s = calloc(1, sizeof *s);
	if (!s)
		return error_set(STATUS_RESOURCE, "out of memory");
	const struct mpm *mpm = s->mpm = inspected->mpm;
	s->fields = inspected->fields;
	s->inspected = inspected;
	snprintf(s->folder, sizeof s->folder, "%s", folder);
	size_t points = 6 * (size_t)mpm->p.n, nodes = (size_t)mpm->grid.nx * (size_t)mpm->grid.ny;
	s->values = malloc(sizeof(double) * ((points > nodes ? points : nodes) + 1));
	int status = s->values ? STATUS_OK : error_set(STATUS_RESOURCE, "out of memory");
	if (status == STATUS_OK && restart)
		status = snapshots_take_up(s);
	if (status != STATUS_OK)
		snapshots_free(s);
	else
		*result = s;
	return status;
}

void snapshots_free(struct snapshots *s)
{
	if (!s)
		return;
	for (int i = 0; i < s->n_series; i++)
		free(s->series[i].entries);
	free(s->series);
	free(s->steps);
	free(s->values);
	free(s);
}

int snapshots_count(const struct snapshots *s) { return s ? s->n : 0; }

const char *snapshots_series(const struct snapshots *s, int i)
{
	return s && i < s->n_series ? s->series[i].file : NULL;
}

/* ---- run.h5 ---- */

static int snapshots_write_links_into(const struct snapshots *s, hid_t file)
{
	CHECK(h5_attribute_text(file, ".", "program", "tmdempm " TMDEMPM_VERSION));
	CHECK(h5_attribute_text(file, ".", "temperature_unit", scene_temperature_unit(s->mpm->scene)));
	CHECK(h5_write_text(file, "scene", s->mpm->scene->text));
	hid_t group;
	CHECK(h5_group(&group, file, "snapshots"));
	int status = STATUS_OK;
	for (int i = 0; i < s->n && status == STATUS_OK; i++) {
		char name[32], target[48];
		snprintf(name, sizeof name, "%0*lld", STEP_DIGITS, s->steps[i]);
		snprintf(target, sizeof target, "snap/%s.h5", name);
		status = h5_link(group, name, target, "/");
	}
	H5Gclose(group);
	return status;
}

static int snapshots_write_links(const struct snapshots *s)
{
	char path[FILE_PATH];
	struct h5_output output;
	CHECK(file_join(path, s->folder, "run.h5"));
	CHECK(h5_begin(&output, path));
	int status = snapshots_write_links_into(s, output.file);
	if (status == STATUS_OK)
		return h5_publish(&output);
	h5_abandon(&output);
	return error_context(status, "%s", path);
}

/* ---- snap/NNNNNNNN.h5 ---- */

static int snapshot_dataset(hid_t group, const char *name, const char *unit, hid_t type, hsize_t rows, int components,
							const void *data)
{
	CHECK(h5_write(group, name, type, rows, components > 1 ? (hsize_t)components : 0, data));
	return h5_attribute_text(group, name, "unit", unit);
}

static int snapshot_points(const struct snapshots *s, hid_t group)
{
	const struct particles *p = &s->mpm->p;
	hsize_t n = (hsize_t)p->n;
	CHECK(snapshot_dataset(group, "id", "-", H5T_NATIVE_INT, n, 1, p->id));
	CHECK(snapshot_dataset(group, "body", "-", H5T_NATIVE_INT, n, 1, p->body));
	CHECK(snapshot_dataset(group, "material", "-", H5T_NATIVE_INT, n, 1, p->material));
	CHECK(snapshot_dataset(group, "position", "m", H5T_NATIVE_DOUBLE, n, 2, p->x));
	CHECK(snapshot_dataset(group, "deformation_gradient", "-", H5T_NATIVE_DOUBLE, n, 4, p->F));
	CHECK(snapshot_dataset(group, "mass", "kg", H5T_NATIVE_DOUBLE, n, 1, p->mass));
	CHECK(snapshot_dataset(group, "initial_volume", "m3", H5T_NATIVE_DOUBLE, n, 1, p->volume0));
	for (int f = 0; f < s->fields->n; f++) {
		const struct run_field *field = &s->fields->fields[f];
		if (h5_has(group, field->field->name))
			continue;
		fields_get(s->fields, s->mpm, f, s->values);
		CHECK(snapshot_dataset(group, field->field->name, field->unit, H5T_NATIVE_DOUBLE, n, field->field->components,
							   s->values));
	}
	return STATUS_OK;
}

static int snapshot_grid(const struct snapshots *s, hid_t group)
{
	const struct grid *grid = &s->mpm->grid;
	hsize_t n = (hsize_t)grid->nx * (hsize_t)grid->ny;
	CHECK(h5_attribute_integer(group, ".", "nx", grid->nx));
	CHECK(h5_attribute_integer(group, ".", "ny", grid->ny));
	CHECK(h5_attribute_number(group, ".", "origin_x", grid->origin[0]));
	CHECK(h5_attribute_number(group, ".", "origin_y", grid->origin[1]));
	CHECK(h5_attribute_number(group, ".", "spacing_x", grid->spacing[0]));
	CHECK(h5_attribute_number(group, ".", "spacing_y", grid->spacing[1]));
	CHECK(snapshot_dataset(group, "mass", "kg", H5T_NATIVE_DOUBLE, n, 1, grid->mass));
	CHECK(snapshot_dataset(group, "velocity", "m/s", H5T_NATIVE_DOUBLE, n, 2, grid->v_new));
	if (!s->mpm->thermal)
		return STATUS_OK;
	for (hsize_t i = 0; i < n; i++)
		s->values[i] = grid->mass[i] > 0 ? scene_temperature_out(s->mpm->scene, grid->T_new[i]) : NAN;
	return snapshot_dataset(group, "temperature", scene_temperature_unit(s->mpm->scene), H5T_NATIVE_DOUBLE, n, 1,
							s->values);
}

static int snapshot_rve(const struct snapshots *s, hid_t group, const char *name, int point)
{
	const struct law *law = s->mpm->laws[s->mpm->p.law[point]];
	const struct rve_model *model;
	const void *state;
	CHECK(law->type->rve_view(law, s->mpm->p.slot[point], &model, &state));
	CHECK(h5_write(group, name, H5T_NATIVE_UCHAR, law->state_bytes, 0, state));
	CHECK(h5_attribute_integer(group, name, "id", s->mpm->p.id[point]));
	CHECK(h5_attribute_integer(group, name, "packings", (long long)law->model_hash));
	CHECK(h5_attribute_text(group, name, "path", law->path));
	return h5_attribute_text(group, name, "law", law->name);
}

/* The states of the inspected RVEs by name, or of all by their point's id. */
static int snapshot_rves(const struct snapshots *s, hid_t group)
{
	const struct mpm *mpm = s->mpm;
	for (int i = 0; i < s->inspected->n; i++) {
		const struct inspected_rve *rve = &s->inspected->rves[i];
		int point;
		CHECK(inspected_point(s->inspected, rve, &point));
		if (point >= 0)
			CHECK(snapshot_rve(s, group, rve->name, point));
		if (point >= 0 && rve->rule)
			CHECK(h5_attribute_text(group, rve->name, "rule", rve->rule->name));
	}
	for (int p = 0; mpm->scene->output.rve_states_all && p < mpm->p.n; p++) {
		char name[32];
		snprintf(name, sizeof name, "point_%d", mpm->p.id[p]);
		if (mpm->laws[mpm->p.law[p]]->type->rve_view)
			CHECK(snapshot_rve(s, group, name, p));
	}
	return STATUS_OK;
}

static int snapshot_part(const struct snapshots *s, hid_t file, const char *name,
						 int (*fill)(const struct snapshots *, hid_t))
{
	hid_t group;
	CHECK(h5_group(&group, file, name));
	int status = fill(s, group);
	H5Gclose(group);
	return status;
}

static int snapshot_fill(const struct snapshots *s, hid_t file)
{
	CHECK(h5_attribute_number(file, ".", "time", s->mpm->time));
	CHECK(h5_attribute_integer(file, ".", "step", s->mpm->step));
	CHECK(h5_attribute_number(file, ".", "thickness", s->mpm->grid.thickness));
	CHECK(snapshot_part(s, file, "points", snapshot_points));
	CHECK(snapshot_part(s, file, "grid", snapshot_grid));
	return snapshot_part(s, file, "rve", snapshot_rves);
}

static int snapshot_write_h5(struct snapshots *s)
{
	char path[FILE_PATH], name[48];
	snprintf(name, sizeof name, "snap/%0*lld.h5", STEP_DIGITS, s->mpm->step);
	CHECK(file_join(path, s->folder, "snap"));
	CHECK(file_make_folder(path));
	CHECK(file_join(path, s->folder, name));
	struct h5_output output;
	CHECK(h5_begin(&output, path));
	int status = snapshot_fill(s, output.file);
	if (status != STATUS_OK) {
		h5_abandon(&output);
		return error_context(status, "%s", path);
	}
	CHECK(h5_publish(&output));
	CHECK(snapshots_add_step(s, s->mpm->step));
	return snapshots_write_links(s);
}

static int snapshot_write_vtk(struct snapshots *s, const void *frame)
{
	const struct frame_header *header = frame;
	const struct frame_channel *channels = frame_channels(frame);
	char path[FILE_PATH], name[FRAME_NAME + 48];
	CHECK(file_join(path, s->folder, "vtk"));
	CHECK(file_make_folder(path));
	for (int c = 0; c < header->n_channels; c++) {
		if (channels[c].rve.flags & FRAME_RVE_BIRTH)
			continue;
		struct series *series = series_find(s, channels[c].name);
		if (!series)
			return error_set(STATUS_RESOURCE, "out of memory");
		snprintf(series->end, sizeof series->end, "%s", vtk_file_end(channels[c].kind));
		snprintf(name, sizeof name, "vtk/%s_%0*lld.%s", series->name, STEP_DIGITS, (long long)header->step,
				 series->end);
		CHECK(file_join(path, s->folder, name));
		CHECK(vtk_write(path, frame, c));
		CHECK(series_add(series, header->step, header->time));
		CHECK(series_write(s, series));
	}
	return STATUS_OK;
}

int snapshots_write(struct snapshots *s, const void *frame)
{
	CHECK(snapshot_write_h5(s));
	return frame ? snapshot_write_vtk(s, frame) : STATUS_OK;
}
