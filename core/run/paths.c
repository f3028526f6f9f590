#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "io/csv.h"
#include "run/run_private.h"

struct path {
	int id;       /* of the point */
	int point;    /* where it lay last: storage is sorted now and then */
	bool bonded;  /* its law has bonds: rows say the absolute temperature, and when they are installed */
	double dT, T; /* K, of the point at the end of the last step: what USF's law sees in the next one */
	struct csv_writer *csv;
};

struct paths {
	const struct mpm *mpm;
	int n;
	struct path *paths;
};

/* Keeps the comments, the header and the first `rows` rows.  The number of rows that were there comes back
 * in *found. */
static int path_cut(const char *file, long long rows, long long *found)
{
	*found = 0;
	if (!file_exists(file))
		return STATUS_OK;
	char *text;
	size_t size;
	CHECK(file_read(&text, &size, file));
	size_t keep = 0;
	long long row = -1; /* the header */
	for (size_t start = 0; start < size;) {
		const char *end = memchr(text + start, '\n', size - start);
		if (!end)
			break; /* torn by a crash */
		size_t next = (size_t)(end - text) + 1;
		if (text[start] != '#')
			row++;
		if (row <= rows)
			keep = next;
		start = next;
	}
	*found = row < rows ? row : rows;
	int status = keep == size ? STATUS_OK : file_write(file, text, keep);
	free(text);
	return status;
}

static int path_row(struct path *path, const struct mpm *mpm, const double L[4], double dT, double T, bool bonds)
{
	csv_number(path->csv, mpm->dt);
	for (int c = 0; c < 4; c++)
		csv_number(path->csv, L[c]);
	csv_number(path->csv, dT);
	if (path->bonded) {
		csv_number(path->csv, T);
		csv_integer(path->csv, bonds);
	}
	return csv_end_row(path->csv);
}

static void path_keep(struct path *path, const struct mpm *mpm)
{
	path->dT = mpm->p.dT[path->point], path->T = mpm->p.T_smooth[path->point];
}

/* A new one begins with what the law was told before the first step. */
static int path_open(struct path *path, const struct mpm *mpm, const char *file, bool append)
{
	static const double rest[4] = {0};
	double warming = mpm_start_warming(mpm, path->id);
	static const char *const names[] = {"duration", "L11", "L12", "L21", "L22", "dT", "T", "bonds"};
	path_keep(path, mpm);
	CHECK(csv_open(&path->csv, file, append));
	if (append)
		return STATUS_OK;
	for (int c = 0; c < (path->bonded ? 8 : 6); c++)
		csv_text(path->csv, names[c]);
	CHECK(csv_end_row(path->csv));
	return isnan(warming) ? STATUS_OK : path_row(path, mpm, rest, warming, mpm->p.T_smooth[path->point], false);
}

static int paths_add(struct paths *paths, const struct scene_inspect *inspect, const char *folder, bool restart,
					 struct run_log *log)
{
	const struct mpm *mpm = paths->mpm;
	const struct scene *scene = mpm->scene;
	int point = inspect->id >= 0 ? mpm_point_by_id(mpm, (int)inspect->id) : mpm_point_nearest_initial(mpm, inspect->at);
	char below[FILE_PATH], file[FILE_PATH], name[SCENE_NAME + 16];
	CHECK(file_join(below, folder, "rve"));
	CHECK(file_make_folder(below));
	snprintf(name, sizeof name, "%s_path.csv", inspect->name);
	CHECK(file_join(file, below, name));
	struct path *path = &paths->paths[paths->n];
	path->id = mpm->p.id[point];
	path->point = point;
	path->bonded = scene->laws[scene->materials[mpm->p.material[point]].law].rve.bonds.strength > 0.0;
	long long rows = mpm->step + !isnan(mpm_start_warming(mpm, path->id)), found;
	if (restart)
		CHECK(path_cut(file, rows, &found));
	if (restart && found != rows) {
		log_warning(log,
					"rve/%s is not written: this folder has no record of it from the first step on, and a part "
					"of a path cannot be replayed",
					name);
		return STATUS_OK;
	}
	paths->n++;
	return path_open(path, mpm, file, restart);
}

int paths_create(struct paths **result, const struct mpm *mpm, const char *folder, bool restart, struct run_log *log)
{
	*result = NULL;
	struct paths *paths = calloc(1, sizeof *paths);
	if (!paths || !(paths->paths = calloc((size_t)mpm->scene->n_inspect + 1, sizeof *paths->paths))) {
		free(paths);
		return error_set(STATUS_RESOURCE, "out of memory");
	}
	paths->mpm = mpm;
	int status = STATUS_OK;
	for (int i = 0; i < mpm->scene->n_inspect && status == STATUS_OK; i++)
		status = paths_add(paths, &mpm->scene->inspect[i], folder, restart, log);
	if (status != STATUS_OK) {
		paths_close(paths);
		return status;
	}
	*result = paths;
	return STATUS_OK;
}

int paths_record(struct paths *paths)
{
	const struct mpm *mpm = paths->mpm;
	for (int i = 0; i < paths->n; i++) {
		struct path *path = &paths->paths[i];
		if (mpm->p.id[path->point] != path->id)
			path->point = mpm_point_by_id(mpm, path->id);
		if (mpm->scene->mpm.order != MPM_USF)
			path_keep(path, mpm);
		CHECK(path_row(path, mpm, mpm->p.L[path->point], path->dT, path->T, mpm->bonds_installed));
		path_keep(path, mpm);
	}
	return STATUS_OK;
}

int paths_sync(struct paths *paths)
{
	for (int i = 0; i < paths->n; i++)
		CHECK(csv_sync(paths->paths[i].csv));
	return STATUS_OK;
}

int paths_close(struct paths *paths)
{
	if (!paths)
		return STATUS_OK;
	int status = STATUS_OK;
	for (int i = 0; i < paths->n; i++) {
		int closed = paths->paths[i].csv ? csv_close(paths->paths[i].csv) : STATUS_OK;
		status = status ? status : closed;
	}
	free(paths->paths);
	free(paths);
	return status;
}
