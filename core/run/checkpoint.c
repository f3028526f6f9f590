#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "io/h5.h"
#include "run/run_private.h"
#include "scene/compare.h"

enum { CHECKPOINT_VERSION = 4 };

void checkpoint_code_path(const struct mpm *mpm, char *path, size_t size)
{
	path[0] = '\0';
	for (int l = 0; l < mpm->n_laws; l++) {
		const struct law *law = mpm->laws[l];
		size_t used = strlen(path);
		if (law->path)
			snprintf(path + used, size - used, "%s%s in law %s", used > 0 ? ", " : "", law->path, law->name);
	}
	if (!path[0])
		snprintf(path, size, "double precision, no RVEs");
}

static hid_t checkpoint_type(char type)
{
	switch (type) {
	case 'i':
		return H5T_NATIVE_INT;
	case 'q':
		return H5T_NATIVE_LLONG;
	case 'b':
		return H5T_NATIVE_UCHAR;
	default:
		return H5T_NATIVE_DOUBLE;
	}
}

static int checkpoint_arrays(struct mpm *mpm, struct mpm_state_array **arrays, int *n)
{
	*n = mpm_state(mpm, NULL);
	*arrays = calloc((size_t)*n + 1, sizeof **arrays);
	if (!*arrays)
		return error_set(STATUS_RESOURCE, "out of memory");
	mpm_state(mpm, *arrays);
	return STATUS_OK;
}

/* The path of each law's states, by the law's name. */
static int checkpoint_write_paths(hid_t file, const struct mpm *mpm)
{
	hid_t group;
	CHECK(h5_group(&group, file, "paths"));
	int status = STATUS_OK;
	for (int l = 0; l < mpm->n_laws && status == STATUS_OK; l++)
		if (mpm->laws[l]->path)
			status = h5_attribute_text(group, ".", mpm->laws[l]->name, mpm->laws[l]->path);
	H5Gclose(group);
	return status;
}

static int checkpoint_write_head(hid_t file, const struct mpm *mpm, const struct history_memory *memory, bool whole)
{
	CHECK(h5_attribute_text(file, ".", "format", whole ? "tmdempm checkpoint" : "tmdempm state at a guard"));
	CHECK(h5_attribute_integer(file, ".", "version", CHECKPOINT_VERSION));
	char code_path[CODE_PATH];
	checkpoint_code_path(mpm, code_path, sizeof code_path);
	CHECK(h5_attribute_text(file, ".", "code_path", code_path));
	CHECK(checkpoint_write_paths(file, mpm));
	CHECK(h5_attribute_integer(file, ".", "step", mpm->step));
	CHECK(h5_attribute_number(file, ".", "time", mpm->time));
	CHECK(h5_write_text(file, "scene", mpm->scene->text));
	hid_t group;
	CHECK(h5_group(&group, file, "history"));
	int status = h5_attribute_number(group, ".", "time", memory->time);
	if (status == STATUS_OK)
		status =
			h5_write(group, "region_mass", H5T_NATIVE_DOUBLE, (hsize_t)mpm->scene->n_regions, 0, memory->region_mass);
	if (status == STATUS_OK && mpm->scene->n_cracks > 0)
		status =
			h5_write(group, "crack_length", H5T_NATIVE_DOUBLE, (hsize_t)mpm->scene->n_cracks, 0, memory->crack_length);
	H5Gclose(group);
	return status;
}

static int checkpoint_write_state(hid_t file, struct mpm *mpm)
{
	struct mpm_state_array *arrays;
	unsigned long long hashes[mpm->n_laws + 1];
	int n;
	for (int l = 0; l < mpm->n_laws; l++)
		hashes[l] = mpm->laws[l]->model_hash;
	CHECK(mpm_write_out(mpm));
	CHECK(checkpoint_arrays(mpm, &arrays, &n));
	hid_t group = -1;
	int status = h5_group(&group, file, "state");
	if (status == STATUS_OK)
		status = h5_write(group, "model_hashes", H5T_NATIVE_ULLONG, (hsize_t)mpm->n_laws, 0, hashes);
	for (int a = 0; a < n && status == STATUS_OK; a++)
		status = h5_write(group, arrays[a].name, checkpoint_type(arrays[a].type), arrays[a].count, 0, arrays[a].data);
	if (group >= 0)
		H5Gclose(group);
	free(arrays);
	return status;
}

int checkpoint_write(const char *path, struct mpm *mpm, const struct history_memory *memory, bool whole)
{
	struct h5_output output;
	CHECK(h5_begin(&output, path));
	int status = checkpoint_write_head(output.file, mpm, memory, whole);
	if (status == STATUS_OK)
		status = checkpoint_write_state(output.file, mpm);
	if (status == STATUS_OK)
		return h5_commit(&output);
	h5_abandon(&output);
	return error_context(status, "%s", path);
}

/* ---- reading ---- */

/* `guarded`: a state in the middle of a step will do. */
static int checkpoint_open(hid_t *file, const char *path, bool guarded)
{
	CHECK(h5_open(file, path));
	char *format = NULL;
	long long version = 0;
	int status = h5_read_attribute_text(*file, "format", &format, path);
	bool at_guard = status == STATUS_OK && !strcmp(format, "tmdempm state at a guard");
	if (at_guard && !guarded)
		status = error_set(STATUS_INPUT,
						   "%s is a state in the middle of a step; restart with the checkpoint.h5 beside it", path);
	else if (status != STATUS_OK || (!at_guard && strcmp(format, "tmdempm checkpoint")))
		status = error_set(STATUS_INPUT, "%s is not a checkpoint of tmdempm", path);
	else
		status = h5_read_integer(*file, "version", &version, path);
	if (status == STATUS_OK && version != CHECKPOINT_VERSION)
		status = error_set(STATUS_INPUT, "%s has the format version %lld, expected %d: it is another release's", path,
						   version, CHECKPOINT_VERSION);
	free(format);
	if (status != STATUS_OK)
		H5Fclose(*file);
	return status;
}

static int checkpoint_compare(hid_t file, const char *path, const struct scene *scene)
{
	char *text, what[1024];
	CHECK(h5_read_text(file, "scene", &text, path));
	int same = scene_compare(text, scene->text, what, sizeof what);
	free(text);
	if (same)
		return STATUS_OK;
	return error_set(STATUS_INPUT,
					 "%s does not belong to this scene: %s; a restart may change time.end, output, images, "
					 "inspect and guards only",
					 path, what);
}

int checkpoint_check_scene(const char *path, const struct scene *scene)
{
	hid_t file;
	CHECK(checkpoint_open(&file, path, false));
	int status = checkpoint_compare(file, path, scene);
	H5Fclose(file);
	return status;
}

static int checkpoint_read_history(hid_t file, const char *path, const struct scene *scene,
								   struct history_memory *memory)
{
	hid_t group = H5Gopen2(file, "history", H5P_DEFAULT);
	if (group < 0)
		return error_set(STATUS_INPUT, "%s holds no `history`", path);
	int status = h5_read_number(group, "time", &memory->time, path);
	if (status == STATUS_OK)
		status = h5_read(group, "region_mass", H5T_NATIVE_DOUBLE, (hsize_t)scene->n_regions, memory->region_mass, path);
	if (status == STATUS_OK && scene->n_cracks > 0)
		status =
			h5_read(group, "crack_length", H5T_NATIVE_DOUBLE, (hsize_t)scene->n_cracks, memory->crack_length, path);
	H5Gclose(group);
	return status;
}

/* A packing that was read from a file, or made by another release, may not be the one of then. */
static int checkpoint_check_models(hid_t state, const char *path, const struct mpm *mpm)
{
	unsigned long long hashes[mpm->n_laws + 1];
	CHECK(h5_read(state, "model_hashes", H5T_NATIVE_ULLONG, (hsize_t)mpm->n_laws, hashes, path));
	for (int l = 0; l < mpm->n_laws; l++)
		if (hashes[l] != mpm->laws[l]->model_hash)
			return error_set(STATUS_INPUT,
							 "%s was computed with other packings in law %s: a packing file has changed, or "
							 "this release makes another packing of the same settings; begin anew, or go on with "
							 "what began it",
							 path, mpm->laws[l]->name);
	return STATUS_OK;
}

static int checkpoint_read_state(hid_t file, const char *path, struct mpm *mpm)
{
	struct mpm_state_array *arrays;
	int n;
	hid_t group = H5Gopen2(file, "state", H5P_DEFAULT);
	if (group < 0)
		return error_set(STATUS_INPUT, "%s holds no `state`", path);
	int status = checkpoint_arrays(mpm, &arrays, &n);
	if (status == STATUS_OK)
		status = checkpoint_check_models(group, path, mpm);
	for (int a = 0; a < n && status == STATUS_OK; a++)
		status = h5_read(group, arrays[a].name, checkpoint_type(arrays[a].type), arrays[a].count, arrays[a].data, path);
	H5Gclose(group);
	free(arrays);
	return status == STATUS_OK ? mpm_restored(mpm) : status;
}

/* The path that the law's states in the file are of; free() it. */
static int checkpoint_path_of(hid_t file, const char *path, const struct law *law, char **stored)
{
	hid_t group = H5Gopen2(file, "paths", H5P_DEFAULT);
	if (group < 0)
		return error_set(STATUS_INPUT, "%s holds no `paths`", path);
	int status = h5_read_attribute_text(group, law->name, stored, path);
	H5Gclose(group);
	return status;
}

/* Takes the law to where the file's states are; `wanted`: where it was, if it is to go back there when it has them. */
static int checkpoint_follow_path(hid_t file, const char *path, struct law *law, bool allow_path_change,
								  const char **wanted)
{
	const bool open = law->scene->rve.path == SCENE_RVE_AUTO;
	char *stored;
	CHECK(checkpoint_path_of(file, path, law, &stored));
	int status = STATUS_OK;
	if (strcmp(stored, law->path) != 0 && !open && !allow_path_change)
		status = error_set(STATUS_INPUT,
						   "%s was computed on the path `%s` in law %s, this run would use `%s`: the bits would change; "
						   "--allow-path-change converts the states",
						   path, stored, law->name, law->path);
	else if (strcmp(stored, law->path) != 0) {
		*wanted = allow_path_change ? law->path : NULL;
		status = law->type->change_path(law, stored);
	}
	free(stored);
	return status;
}

/* Reads states of whatever path; they stay on it unless they may be changed to what the run would use. */
static int checkpoint_read_on_paths(hid_t file, const char *path, struct mpm *mpm, bool allow_path_change)
{
	const char *wanted[mpm->n_laws + 1];
	memset(wanted, 0, sizeof wanted);
	for (int l = 0; l < mpm->n_laws; l++)
		if (mpm->laws[l]->path)
			CHECK(checkpoint_follow_path(file, path, mpm->laws[l], allow_path_change, &wanted[l]));
	CHECK(checkpoint_read_state(file, path, mpm));
	for (int l = 0; l < mpm->n_laws; l++)
		if (wanted[l])
			CHECK(mpm->laws[l]->type->change_path(mpm->laws[l], wanted[l]));
	return STATUS_OK;
}

int checkpoint_read(const char *path, struct mpm *mpm, struct history_memory *memory, bool allow_path_change)
{
	hid_t file;
	CHECK(checkpoint_open(&file, path, false));
	int status = checkpoint_compare(file, path, mpm->scene);
	if (status == STATUS_OK)
		status = checkpoint_read_history(file, path, mpm->scene, memory);
	if (status == STATUS_OK)
		status = checkpoint_read_on_paths(file, path, mpm, allow_path_change);
	H5Fclose(file);
	return status;
}

/* ---- looking into one ---- */

int checkpoint_read_scene(const char *path, char **text)
{
	hid_t file;
	*text = NULL;
	CHECK(checkpoint_open(&file, path, true));
	int status = h5_read_text(file, "scene", text, path);
	H5Fclose(file);
	return status;
}

int checkpoint_look(const char *path, struct mpm *mpm)
{
	hid_t file;
	CHECK(checkpoint_open(&file, path, true));
	int status = checkpoint_read_on_paths(file, path, mpm, false);
	H5Fclose(file);
	return status;
}
