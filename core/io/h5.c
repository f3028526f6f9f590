#include "io/h5.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/error.h"

/* The innermost frame of the library's error stack that quotes the system's reason, else its first text. */
static herr_t h5_find_reason(unsigned n, const H5E_error2_t *frame, void *data)
{
	char *reason = data;
	const char *text = frame->desc ? frame->desc : "";
	const char *quoted = strstr(text, "error message = '");
	if (quoted) {
		quoted += strlen("error message = '");
		snprintf(reason, 256, "%.*s", (int)strcspn(quoted, "'"), quoted);
		return 1;
	}
	if (n == 0)
		snprintf(reason, 256, "HDF5: %.200s", text);
	return 0;
}

static int h5_fail(const char *what, const char *name)
{
	char reason[256] = "HDF5 gives no reason";
	H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, h5_find_reason, reason);
	return error_set(STATUS_RESOURCE, "cannot %s %s: %s", what, name, reason);
}

/* The library must not print its stack: h5_fail() says what matters. */
static void h5_quiet(void) { H5Eset_auto2(H5E_DEFAULT, NULL, NULL); }

void h5_start(void) { H5dont_atexit(); }

int h5_begin(struct h5_output *output, const char *path)
{
	h5_quiet();
	output->file = -1;
	CHECK(file_join(output->path, "", path));
	CHECK(file_temporary(output->temporary, path));
	output->file = H5Fcreate(output->temporary, H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
	if (output->file < 0)
		return h5_fail("create", path);
	return STATUS_OK;
}

static int h5_finish(struct h5_output *output, int (*rename_it)(const char *temporary, const char *path))
{
	hid_t file = output->file;
	if (H5Fflush(file, H5F_SCOPE_LOCAL) < 0) {
		int status = h5_fail("write", output->path);
		h5_abandon(output);
		return status;
	}
	output->file = -1;
	if (H5Fclose(file) < 0) {
		int status = h5_fail("write", output->path);
		unlink(output->temporary);
		return status;
	}
	return rename_it(output->temporary, output->path);
}

int h5_commit(struct h5_output *output) { return h5_finish(output, file_commit); }

int h5_publish(struct h5_output *output) { return h5_finish(output, file_publish); }

void h5_abandon(struct h5_output *output)
{
	if (output->file < 0)
		return;
	H5Fclose(output->file);
	unlink(output->temporary);
	output->file = -1;
}

int h5_open(hid_t *file, const char *path)
{
	h5_quiet();
	*file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
	if (*file < 0) {
		int status = h5_fail("read", path);
		if (file_exists(path) && H5Fis_hdf5(path) <= 0)
			return error_set(STATUS_INPUT, "%s is not an HDF5 file", path);
		return status;
	}
	return STATUS_OK;
}

int h5_group(hid_t *group, hid_t parent, const char *name)
{
	hid_t create = H5Pcreate(H5P_GROUP_CREATE);
	H5Pset_obj_track_times(create, false);
	*group = H5Gcreate2(parent, name, H5P_DEFAULT, create, H5P_DEFAULT);
	int status = *group < 0 ? h5_fail("write", name) : STATUS_OK;
	H5Pclose(create);
	return status;
}

/* Every other call of the library forgets why the last one failed: h5_fail() comes first. */
static int h5_write_space(hid_t parent, const char *name, hid_t type, hid_t space, const void *data)
{
	hid_t create = H5Pcreate(H5P_DATASET_CREATE), link = H5Pcreate(H5P_LINK_CREATE);
	H5Pset_obj_track_times(create, false);
	H5Pset_create_intermediate_group(link, 1);
	bool empty = H5Sget_simple_extent_npoints(space) == 0;
	hid_t set = H5Dcreate2(parent, name, type, space, link, create, H5P_DEFAULT);
	int status = set < 0 ? h5_fail("write", name) : STATUS_OK;
	if (status == STATUS_OK && !empty && H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) < 0)
		status = h5_fail("write", name);
	if (set >= 0 && H5Dclose(set) < 0 && status == STATUS_OK)
		status = h5_fail("write", name);
	H5Pclose(create);
	H5Pclose(link);
	return status;
}

int h5_write(hid_t parent, const char *name, hid_t type, hsize_t rows, hsize_t columns, const void *data)
{
	hsize_t size[2] = {rows, columns};
	hid_t space = H5Screate_simple(columns ? 2 : 1, size, NULL);
	int status = h5_write_space(parent, name, type, space, data);
	H5Sclose(space);
	return status;
}

static hid_t h5_text_type(const char *text)
{
	hid_t type = H5Tcopy(H5T_C_S1);
	size_t size = strlen(text);
	H5Tset_size(type, size ? size : 1);
	H5Tset_strpad(type, H5T_STR_NULLPAD);
	H5Tset_cset(type, H5T_CSET_UTF8);
	return type;
}

int h5_write_text(hid_t parent, const char *name, const char *text)
{
	hid_t type = h5_text_type(text), space = H5Screate(H5S_SCALAR);
	int status = h5_write_space(parent, name, type, space, text);
	H5Sclose(space);
	H5Tclose(type);
	return status;
}

static int h5_attribute(hid_t parent, const char *object, const char *name, hid_t type, const void *value)
{
	hid_t space = H5Screate(H5S_SCALAR);
	hid_t attribute = H5Acreate_by_name(parent, object, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
	int status = STATUS_OK;
	if (attribute < 0 || H5Awrite(attribute, type, value) < 0)
		status = h5_fail("write the attribute", name);
	if (attribute >= 0)
		H5Aclose(attribute);
	H5Sclose(space);
	return status;
}

int h5_attribute_text(hid_t parent, const char *object, const char *name, const char *text)
{
	hid_t type = h5_text_type(text);
	int status = h5_attribute(parent, object, name, type, text);
	H5Tclose(type);
	return status;
}

int h5_attribute_number(hid_t parent, const char *object, const char *name, double value)
{
	return h5_attribute(parent, object, name, H5T_NATIVE_DOUBLE, &value);
}

int h5_attribute_integer(hid_t parent, const char *object, const char *name, long long value)
{
	return h5_attribute(parent, object, name, H5T_NATIVE_LLONG, &value);
}

/* Opens a dataset that must be there. */
static int h5_open_set(hid_t *set, hid_t parent, const char *name, const char *path)
{
	if (!h5_has(parent, name))
		return error_set(STATUS_INPUT, "%s holds no `%s`", path, name);
	*set = H5Dopen2(parent, name, H5P_DEFAULT);
	return *set < 0 ? h5_fail("read", path) : STATUS_OK;
}

int h5_read(hid_t parent, const char *name, hid_t type, hsize_t count, void *data, const char *path)
{
	hid_t set = H5I_INVALID_HID;
	CHECK(h5_open_set(&set, parent, name, path));
	hid_t space = H5Dget_space(set);
	hssize_t there = H5Sget_simple_extent_npoints(space);
	int status = STATUS_OK;
	if (there < 0 || (hsize_t)there != count)
		status = error_set(STATUS_INPUT, "%s: `%s` holds %lld values, expected %llu", path, name, (long long)there,
						   (unsigned long long)count);
	else if (count && H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) < 0)
		status = h5_fail("read", path);
	H5Sclose(space);
	H5Dclose(set);
	return status;
}

int h5_size(hid_t parent, const char *name, hsize_t *rows, hsize_t *columns, const char *path)
{
	hsize_t size[2] = {0, 1};
	hid_t set = H5I_INVALID_HID;
	CHECK(h5_open_set(&set, parent, name, path));
	hid_t space = H5Dget_space(set);
	int rank = H5Sget_simple_extent_ndims(space);
	if (rank == 1 || rank == 2)
		H5Sget_simple_extent_dims(space, size, NULL);
	H5Sclose(space);
	H5Dclose(set);
	*rows = size[0], *columns = size[1];
	return rank == 1 || rank == 2 ? STATUS_OK : error_set(STATUS_INPUT, "%s: `%s` is no table", path, name);
}

int h5_read_text(hid_t parent, const char *name, char **text, const char *path)
{
	*text = NULL;
	if (!h5_has(parent, name))
		return error_set(STATUS_INPUT, "%s holds no `%s`", path, name);
	hid_t set = H5Dopen2(parent, name, H5P_DEFAULT);
	if (set < 0)
		return h5_fail("read", path);
	hid_t type = H5Dget_type(set);
	int status = STATUS_OK;
	if (H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type))
		status = error_set(STATUS_INPUT, "%s: `%s` is not a text of fixed length", path, name);
	else if (!(*text = calloc(1, H5Tget_size(type) + 1)))
		status = error_set(STATUS_RESOURCE, "out of memory");
	else if (H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, *text) < 0)
		status = h5_fail("read", path);
	H5Tclose(type);
	H5Dclose(set);
	if (status != STATUS_OK) {
		free(*text);
		*text = NULL;
	}
	return status;
}

static int h5_read_attribute(hid_t parent, const char *name, hid_t type, void *value, const char *path)
{
	if (H5Aexists(parent, name) <= 0)
		return error_set(STATUS_INPUT, "%s holds no attribute `%s`", path, name);
	hid_t attribute = H5Aopen(parent, name, H5P_DEFAULT);
	int status = STATUS_OK;
	if (attribute < 0 || H5Aread(attribute, type, value) < 0)
		status = h5_fail("read", path);
	if (attribute >= 0)
		H5Aclose(attribute);
	return status;
}

int h5_read_number(hid_t parent, const char *name, double *value, const char *path)
{
	return h5_read_attribute(parent, name, H5T_NATIVE_DOUBLE, value, path);
}

int h5_read_integer(hid_t parent, const char *name, long long *value, const char *path)
{
	return h5_read_attribute(parent, name, H5T_NATIVE_LLONG, value, path);
}

int h5_read_attribute_text(hid_t parent, const char *name, char **text, const char *path)
{
	*text = NULL;
	if (H5Aexists(parent, name) <= 0)
		return error_set(STATUS_INPUT, "%s holds no attribute `%s`", path, name);
	hid_t attribute = H5Aopen(parent, name, H5P_DEFAULT);
	if (attribute < 0)
		return h5_fail("read", path);
	hid_t type = H5Aget_type(attribute);
	int status = STATUS_OK;
	if (H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type))
		status = error_set(STATUS_INPUT, "%s: the attribute `%s` is not a text", path, name);
	else if (!(*text = calloc(1, H5Tget_size(type) + 1)))
		status = error_set(STATUS_RESOURCE, "out of memory");
	else if (H5Aread(attribute, type, *text) < 0)
		status = h5_fail("read", path);
	H5Tclose(type);
	H5Aclose(attribute);
	return status;
}

bool h5_has(hid_t parent, const char *name) { return H5Lexists(parent, name, H5P_DEFAULT) > 0; }

int h5_link(hid_t parent, const char *name, const char *file, const char *object)
{
	if (H5Lcreate_external(file, object, parent, name, H5P_DEFAULT, H5P_DEFAULT) < 0)
		return h5_fail("write the link", name);
	return STATUS_OK;
}
