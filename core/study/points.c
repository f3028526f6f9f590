#include "study/points.h"

#include <dirent.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "io/h5.h"
#include "run/fields.h"

/* ---- which snapshot ---- */

static int snapshot_time(const char *path, double *time)
{
	hid_t file;
	CHECK(h5_open(&file, path));
	int status = h5_read_number(file, "time", time, path);
	H5Fclose(file);
	return status;
}

/* The file whose time is nearest; NAN = the last one. */
static int snapshot_nearest(const char *folder, double time, char best[FILE_PATH], double *found)
{
	DIR *stream = opendir(folder);
	double distance = INFINITY;
	*found = NAN;
	best[0] = '\0';
	if (!stream)
		return error_set(STATUS_INPUT, "cannot read %s (%s): does the study set output.snapshot_every?", folder,
						 strerror(errno));
	int status = STATUS_OK;
	for (struct dirent *entry; status == STATUS_OK && (entry = readdir(stream));) {
		char path[FILE_PATH];
		double at;
		if (entry->d_name[0] == '.' || !file_has_end(entry->d_name, ".h5"))
			continue;
		if ((status = file_join(path, folder, entry->d_name)) != STATUS_OK ||
			(status = snapshot_time(path, &at)) != STATUS_OK)
			continue;
		double d = isnan(time) ? -at : fabs(at - time);
		if (d < distance) {
			distance = d, *found = at;
			memcpy(best, path, sizeof path);
		}
	}
	closedir(stream);
	return status;
}

static int snapshot_find(const char *folder, double time, char path[FILE_PATH], double *found)
{
	char below[FILE_PATH];
	CHECK(file_join(below, folder, "out/snap"));
	CHECK(snapshot_nearest(below, time, path, found));
	if (!path[0])
		return error_set(STATUS_INPUT, "%s holds no snapshot: does the study set output.snapshot_every?", below);
	if (!isnan(time) && fabs(*found - time) > 0.01 * fabs(time)) /* whole steps; its own time is what counts */
		return error_set(STATUS_INPUT, "%s holds no snapshot of %.9g s (the nearest is of %.9g s)", below, time,
						 *found);
	return STATUS_OK;
}

/* ---- what is in it ---- */

struct points {
	int n, components, first, last; /* components of the field; those that count, as numbers of its columns */
	double *position, *displacement, *volume, *field;
	char name[SCENE_NAME]; /* of the dataset */
};

static void points_free(struct points *p)
{
	free(p->position);
	free(p->displacement);
	free(p->volume);
	free(p->field);
}

static int read_column(double **values, hid_t group, const char *name, int n, int components, const char *path)
{
	hsize_t rows, columns;
	CHECK(h5_size(group, name, &rows, &columns, path));
	if (rows != (hsize_t)n || columns != (hsize_t)components)
		return error_set(STATUS_INPUT, "%s: points/%s has an unexpected size", path, name);
	*values = malloc(((size_t)n * (size_t)components + 1) * sizeof **values);
	if (!*values)
		return error_set(STATUS_RESOURCE, "out of memory");
	return h5_read(group, name, H5T_NATIVE_DOUBLE, rows * columns, *values, path);
}

/* "stress_xx" is a component of the dataset stress; "stress" is all of it. */
static int find_field(struct points *p, hid_t group, const char *wanted, const char *path)
{
	hsize_t rows, columns;
	snprintf(p->name, sizeof p->name, "%s", wanted);
	bool whole = h5_has(group, p->name);
	char *ending = strrchr(p->name, '_');
	if (!whole && ending)
		*ending = '\0';
	if (!h5_has(group, p->name))
		return error_set(STATUS_INPUT, "%s: the points have no field \"%s\"", path, wanted);
	CHECK(h5_size(group, p->name, &rows, &columns, path));
	p->components = (int)columns;
	p->first = 0, p->last = p->components - 1;
	for (int c = 0; c < p->components && !whole; c++) {
		const char *its = field_component_ending(p->components, c);
		if (its && !strcmp(its, wanted + strlen(p->name)))
			p->first = p->last = c, whole = true;
	}
	return whole ? STATUS_OK : error_set(STATUS_INPUT, "%s: the points have no field \"%s\"", path, wanted);
}

static int points_fill(struct points *p, hid_t group, const char *wanted, const char *path)
{
	hsize_t rows, columns;
	CHECK(h5_size(group, "initial_volume", &rows, &columns, path));
	p->n = (int)rows;
	CHECK(find_field(p, group, wanted, path));
	CHECK(read_column(&p->volume, group, "initial_volume", p->n, 1, path));
	CHECK(read_column(&p->position, group, "position", p->n, 2, path));
	CHECK(read_column(&p->displacement, group, "displacement", p->n, 3, path));
	return read_column(&p->field, group, p->name, p->n, p->components, path);
}

static int points_read(struct points *p, const char *wanted, const char *path)
{
	hid_t file, group;
	CHECK(h5_open(&file, path));
	group = H5Gopen2(file, "points", H5P_DEFAULT);
	int status = group < 0 ? error_set(STATUS_INPUT, "%s holds no points", path) : points_fill(p, group, wanted, path);
	if (group >= 0)
		H5Gclose(group);
	H5Fclose(file);
	return status;
}

/* ---- the norm ---- */

/* Squares, over the components that count, of the field of point i and of its error. */
static int point_squares(const struct points *p, int i, const struct exact_reference *exact,
						 const struct study_norm *norm, double t, double squares[2])
{
	const double X[2] = {p->position[2 * i] - p->displacement[3 * i],
						 p->position[2 * i + 1] - p->displacement[3 * i + 1]};
	squares[0] = squares[1] = 0.0;
	for (int c = p->first; c <= p->last; c++) {
		const char *ending = field_component_ending(p->components, c);
		char name[STUDY_TEXT];
		double is = p->field[(size_t)i * (size_t)p->components + (size_t)c], shall;
		if (!ending)
			continue;
		snprintf(name, sizeof name, "%s%s", p->name, ending);
		CHECK(exact_reference_value(exact, norm->exact[0] && p->first == p->last ? norm->exact : name, X, t, &shall));
		squares[0] += is * is;
		squares[1] += (is - shall) * (is - shall);
	}
	return STATUS_OK;
}

static int points_sum(const struct points *p, const struct exact_reference *exact, const struct study_norm *norm,
					  double t, double results[2])
{
	double sum[2] = {0.0, 0.0}, most[2] = {0.0, 0.0}, volume = 0.0;
	for (int i = 0; i < p->n; i++) {
		double squares[2];
		CHECK(point_squares(p, i, exact, norm, t, squares));
		volume += p->volume[i];
		for (int k = 0; k < 2; k++) {
			sum[k] += p->volume[i] * squares[k];
			most[k] = isnan(squares[k]) || isnan(most[k]) ? NAN : fmax(most[k], squares[k]);
		}
	}
	for (int k = 0; k < 2; k++)
		results[k] = sqrt(norm->kind == NORM_MAX ? most[k] : sum[k] / volume);
	return STATUS_OK;
}

int points_norm(const struct exact_reference *exact, const struct study_norm *norm, const char *folder, double *value,
				double *error)
{
	char path[FILE_PATH];
	double time, results[2] = {NAN, NAN};
	struct points p = {0};
	CHECK(snapshot_find(folder, norm->time, path, &time));
	int status = points_read(&p, norm->points, path);
	if (status == STATUS_OK)
		status = points_sum(&p, exact, norm, time, results);
	points_free(&p);
	*value = results[0], *error = results[1];
	return status;
}
