#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "io/csv.h"
#include "run/run_private.h"
#include "rve/rve_file.h"

struct path {
	char name[SCENE_NAME];
	int id;       /* of the point */
	int point;    /* where it lay last: storage is sorted now and then */
	bool bonded;  /* its law has bonds: rows say the absolute temperature, and when they are installed */
	double dT, T; /* K, of the point at the end of the last step: what USF's law sees in the next one */
	struct csv_writer *csv;
};

struct paths {
	const struct mpm *mpm;
	char folder[FILE_PATH];
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

/* The header; from the first step on also what the law was told before it. */
static int path_begin(struct path *path, const struct mpm *mpm, bool first)
{
	static const double rest[4] = {0};
	static const char *const names[] = {"duration", "L11", "L12", "L21", "L22", "dT", "T", "bonds"};
	double warming = first ? mpm_start_warming(mpm, path->id) : NAN;
	for (int c = 0; c < (path->bonded ? 8 : 6); c++)
		csv_text(path->csv, names[c]);
	CHECK(csv_end_row(path->csv));
	return isnan(warming) ? STATUS_OK : path_row(path, mpm, rest, warming, mpm->p.T_smooth[path->point], false);
}

/* rve/NAME_path.csv of a path that begins with the packing; rve/NAME_STEP.h5 and rve/NAME_STEP_path.csv of one that
 * steering began. */
static int path_file(const struct paths *paths, const struct inspected_rve *rve, const char *end, char file[FILE_PATH])
{
	char below[FILE_PATH], name[SCENE_NAME + 48], step[32] = "";
	if (rve->since >= 0)
		snprintf(step, sizeof step, "_%08lld", rve->since);
	snprintf(name, sizeof name, "%s%s%s", rve->name, step, end);
	CHECK(file_join(below, paths->folder, "rve"));
	CHECK(file_make_folder(below));
	return file_join(file, below, name);
}

/* `path` records the point from now on; one that goes on after a restart has its rows already. */
static int paths_take(struct paths *paths, const struct inspected_rve *rve, int point, bool append)
{
	const struct mpm *mpm = paths->mpm;
	char file[FILE_PATH];
	struct path *larger = realloc(paths->paths, ((size_t)paths->n + 1) * sizeof *larger);
	if (!larger)
		return error_set(STATUS_RESOURCE, "out of memory");
	paths->paths = larger;
	CHECK(path_file(paths, rve, "_path.csv", file));
	const struct scene_law *law = &mpm->scene->laws[mpm->scene->materials[mpm->p.material[point]].law];
	struct path *path = &paths->paths[paths->n];
	*path = (struct path){.id = mpm->p.id[point], .point = point, .bonded = law->rve.bonds.strength > 0.0};
	snprintf(path->name, sizeof path->name, "%s", rve->name);
	path_keep(path, mpm);
	CHECK(csv_open(&path->csv, file, append));
	paths->n++;
	if (append)
		return STATUS_OK;
	return path_begin(path, mpm, rve->since < 0);
}

/* Of an RVE that the run inspects as it begins (again). */
static int paths_add(struct paths *paths, const struct inspected_rve *rve, int point, bool restart, struct run_log *log)
{
	const struct mpm *mpm = paths->mpm;
	char file[FILE_PATH];
	long long rows = rve->since < 0 ? mpm->step + !isnan(mpm_start_warming(mpm, rve->id)) : mpm->step - rve->since;
	long long found = 0;
	CHECK(path_file(paths, rve, "_path.csv", file));
	if (restart)
		CHECK(path_cut(file, rows, &found));
	bool there = restart && file_exists(file);
	if (!there && (!restart || rows == 0))
		return paths_take(paths, rve, point, false);
	if (there && found == rows)
		return paths_take(paths, rve, point, true);
	log_warning(log,
				"rve/%s is not written: this folder has no record of it from the first step on, and a part "
				"of a path cannot be replayed",
				strrchr(file, '/') + 1);
	return STATUS_OK;
}

int paths_create(struct paths **result, const struct inspected *inspected, const char *folder, bool restart,
				 struct run_log *log)
{
	struct paths *paths = *result = calloc(1, sizeof *paths);
	if (!paths)
		return error_set(STATUS_RESOURCE, "out of memory");
	paths->mpm = inspected->mpm;
	snprintf(paths->folder, sizeof paths->folder, "%s", folder);
	for (int i = 0; i < inspected->n; i++) {
		const struct inspected_rve *rve = &inspected->rves[i];
		int point = -1;
		if (!rve->rule)
			CHECK(inspected_point(inspected, rve, &point));
		if (point >= 0)
			CHECK(paths_add(paths, rve, point, restart, log));
	}
	return STATUS_OK;
}

/* The state in which a path begins that does not begin with the packing. */
static int paths_write_start(const struct paths *paths, const struct inspected_rve *rve, int point)
{
	const struct mpm *mpm = paths->mpm;
	const struct law *law = mpm->laws[mpm->p.law[point]];
	struct rve_origin origin = {.point = rve->id, .step = mpm->step, .time = mpm->time, .T = mpm->p.T_smooth[point]};
	const struct rve_model *model;
	const void *state;
	char file[FILE_PATH];
	snprintf(origin.name, sizeof origin.name, "%s", rve->name);
	snprintf(origin.law, sizeof origin.law, "%.63s", law->name);
	CHECK(path_file(paths, rve, ".h5", file));
	CHECK(law->type->rve_view(law, mpm->p.slot[point], &model, &state));
	return rve_file_write(file, model, state, &origin);
}

/* Those of a name among the first n. */
static int paths_stop_among(struct paths *paths, const char *name, int n)
{
	int status = STATUS_OK;
	for (int i = n - 1; i >= 0; i--) {
		if (strcmp(paths->paths[i].name, name) != 0)
			continue;
		int closed = csv_close(paths->paths[i].csv);
		status = status ? status : closed;
		paths->n--;
		memmove(&paths->paths[i], &paths->paths[i + 1], (size_t)(paths->n - i) * sizeof *paths->paths);
	}
	return status;
}

int paths_start(struct paths *paths, const struct inspected_rve *rve)
{
	int point = mpm_point_by_id(paths->mpm, rve->id), before = paths->n;
	CHECK(paths_write_start(paths, rve, point));
	CHECK(paths_take(paths, rve, point, false));
	return paths_stop_among(paths, rve->name, before);
}

int paths_stop(struct paths *paths, const char *name) { return paths_stop_among(paths, name, paths->n); }

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
