/* Packings on disk: HDF5 (exact), CSV (other codes' packings), and the user's cache of generated ones. */
#include <errno.h>
#include <float.h>
#include <hdf5.h>
#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/error.h"
#include "base/hash.h"
#include "base/mat2.h"
#include "io/csv.h"
#include "io/file.h"
#include "rve/packing.h"

static const char format_name[] = "tmdempm packing 1";
enum { DISCS_MAX = 65535 }; /* neighbours are 16-bit numbers */

static int no_memory(const char *path) { return error_set(STATUS_RESOURCE, "no memory for the packing %s", path); }

/* One of which nothing is known yet but its size. */
static struct rve_packing *packing_new(int n_discs, int n_contacts)
{
	struct rve_packing *p = rve_packing_alloc(n_discs, n_contacts);
	if (p)
		p->pressure = p->mu = p->unbalanced = NAN;
	return p;
}

/* ---- is it a packing? ---- */

/* What a reader calls the discs and contacts of its file: a line of it, or a number. */
struct place {
	const char *path;
	const int *lines; /* of the discs, or NULL */
	int cell_line;    /* of H, or 0 */
};

static int disc_error(const struct place *at, int i, const char *format, ...) __attribute__((format(printf, 3, 4)));

static int disc_error(const struct place *at, int i, const char *format, ...)
{
	char text[512];
	va_list args;
	va_start(args, format);
	vsnprintf(text, sizeof text, format, args);
	va_end(args);
	if (at->lines)
		return error_set(STATUS_INPUT, "%s:%d: %s", at->path, at->lines[i], text);
	return error_set(STATUS_INPUT, "%s: disc %d: %s", at->path, i, text);
}

static int cell_error(const struct place *at, const char *text)
{
	if (at->cell_line)
		return error_set(STATUS_INPUT, "%s:%d: %s", at->path, at->cell_line, text);
	return error_set(STATUS_INPUT, "%s: %s", at->path, text);
}

static int check_cell(const struct rve_packing *p, const struct place *at)
{
	for (int k = 0; k < 4; k++)
		if (!isfinite(p->H[k]))
			return cell_error(at, "the cell H is not finite, expected four lengths in metres");
	if (!(mat2_determinant(p->H) > 0.0))
		return cell_error(at, "det(H) is not positive, expected the lattice vectors as columns, the second to the "
							  "left of the first");
	return STATUS_OK;
}

static int check_discs(const struct rve_packing *p, const struct place *at)
{
	for (int i = 0; i < p->n_discs; i++) {
		if (!isfinite(p->x[i][0]) || !isfinite(p->x[i][1]))
			return disc_error(at, i, "its centre is (%g, %g), expected finite numbers", p->x[i][0], p->x[i][1]);
		if (!(p->r[i] > 0.0) || !isfinite(p->r[i]))
			return disc_error(at, i, "its radius is %g, expected a positive number of metres", p->r[i]);
	}
	if (!(rve_packing_void_ratio(p) > 0.0))
		return cell_error(at, "the discs fill more than the whole cell, expected H, centres and radii in metres");
	return STATUS_OK;
}

static int check_contacts(const struct rve_packing *p, const struct place *at)
{
	for (int c = 0; c < p->n_contacts; c++) {
		const int *q = p->pair[c];
		if (!(0 <= q[0] && q[0] < q[1] && q[1] < p->n_discs))
			return error_set(STATUS_INPUT, "%s: contact %d joins the discs %d and %d, expected 0 <= i < j < %d",
							 at->path, c, q[0], q[1], p->n_discs);
		if (!isfinite(p->ft[c]))
			return error_set(STATUS_INPUT, "%s: contact %d has no finite tangential force", at->path, c);
	}
	return STATUS_OK;
}

static int check_packing(const struct rve_packing *p, const struct place *at)
{
	CHECK(check_cell(p, at));
	CHECK(check_discs(p, at));
	return check_contacts(p, at);
}

/* ---- CSV ---- */

/* `# H Hxx Hxy Hyx Hyy ...`: 1 if the comment is one, 0 if not, -1 if it begins like one but is not whole. */
static int parse_cell_comment(const char *text, double H[4])
{
	text += strspn(text, " \t");
	if (text[0] != 'H' || !strchr(" \t:=", text[1]) || !text[1])
		return 0;
	text++;
	for (int k = 0; k < 4; k++) {
		char *end;
		text += strspn(text, " \t,;:=");
		H[k] = strtod(text, &end);
		if (end == text)
			return k == 0 ? 0 : -1; /* a sentence that begins with H */
		text = end;
	}
	return 1;
}

static int csv_cell(const struct csv_table *t, double H[4], int *line)
{
	double found[4];
	*line = 0;
	for (int k = 0; k < t->n_comments; k++) {
		int is = parse_cell_comment(t->comments[k], found);
		if (is < 0)
			return error_set(STATUS_INPUT,
							 "%s:%d: the cell has fewer than four numbers, expected `# H Hxx Hxy Hyx Hyy`", t->path,
							 t->comment_lines[k]);
		if (is && *line)
			return error_set(STATUS_INPUT, "%s:%d: a second cell (the first is in line %d), expected one `# H` line",
							 t->path, t->comment_lines[k], *line);
		if (is) {
			memcpy(H, found, sizeof found);
			*line = t->comment_lines[k];
		}
	}
	if (!*line)
		return error_set(STATUS_INPUT, "%s:1: no line gives the cell, expected `# H Hxx Hxy Hyx Hyy` in metres",
						 t->path);
	return STATUS_OK;
}

static int compare_ids(const void *a, const void *b)
{
	const double *const *x = a, *const *y = b;
	if (**x != **y)
		return **x < **y ? -1 : 1;
	return *x < *y ? -1 : *x > *y; /* the later row is the one at fault */
}

static int csv_check_ids(const struct csv_table *t)
{
	const double **order = malloc((size_t)t->rows * sizeof *order);
	if (!order)
		return no_memory(t->path);
	int status = STATUS_OK;
	for (int i = 0; i < t->rows; i++)
		order[i] = t->values + 4 * i;
	for (int i = 0; i < t->rows && status == STATUS_OK; i++)
		if (*order[i] != rint(*order[i]) || fabs(*order[i]) > 1e15)
			status = error_set(STATUS_INPUT, "%s:%d: the id is %g, expected a whole number", t->path, t->lines[i],
							   *order[i]);
	qsort(order, (size_t)t->rows, sizeof *order, compare_ids);
	for (int i = 1; i < t->rows && status == STATUS_OK; i++)
		if (*order[i] == *order[i - 1])
			status =
				error_set(STATUS_INPUT, "%s:%d: disc %.0f is there already (line %d), expected each id once", t->path,
						  t->lines[(order[i] - t->values) / 4], *order[i], t->lines[(order[i - 1] - t->values) / 4]);
	free(order);
	return status;
}

static int csv_to_packing(struct rve_packing **packing, const struct csv_table *t)
{
	struct place at = {.path = t->path, .lines = t->lines};
	double H[4];
	CHECK(csv_cell(t, H, &at.cell_line));
	if (t->rows < 1 || t->rows > DISCS_MAX)
		return error_set(STATUS_INPUT, "%s: %d discs, expected rows id,x,y,r for 1 to %d discs", t->path, t->rows,
						 (int)DISCS_MAX);
	CHECK(csv_check_ids(t));
	struct rve_packing *p = packing_new(t->rows, 0);
	if (!p)
		return no_memory(t->path);
	memcpy(p->H, H, sizeof H);
	for (int i = 0; i < t->rows; i++) {
		memcpy(p->x[i], t->values + 4 * i + 1, sizeof p->x[i]);
		p->r[i] = t->values[4 * i + 3];
	}
	int status = check_packing(p, &at);
	if (status != STATUS_OK) {
		rve_packing_free(p);
		return status;
	}
	p->void_ratio = rve_packing_void_ratio(p);
	*packing = p;
	return STATUS_OK;
}

static int read_csv(struct rve_packing **packing, const char *path)
{
	struct csv_table *t;
	CHECK(csv_read(&t, path, "id,x,y,r"));
	int status = csv_to_packing(packing, t);
	csv_table_free(t);
	return status;
}

static int write_csv(const struct rve_packing *p, const char *path)
{
	char text[512];
	struct csv_writer *w;
	CHECK(csv_create(&w, path));
	snprintf(text, sizeof text, "packing of %d discs: void ratio %.6g, pressure %.6g Pa, mu %.6g, seed %u", p->n_discs,
			 p->void_ratio, p->pressure, p->mu, p->seed);
	csv_comment(w, text);
	csv_comment(w, "tangential forces are not kept here (they are in .h5)");
	snprintf(text, sizeof text, "H %.17g %.17g %.17g %.17g (m, row-major; columns are the lattice vectors)", p->H[0],
			 p->H[1], p->H[2], p->H[3]);
	csv_comment(w, text);
	csv_comment(w, "id,x [m],y [m],r [m]");
	for (int i = 0; i < p->n_discs; i++) {
		csv_integer(w, i);
		csv_number(w, p->x[i][0]);
		csv_number(w, p->x[i][1]);
		csv_number(w, p->r[i]);
		int status = csv_end_row(w);
		if (status != STATUS_OK) {
			csv_abandon(w);
			return status;
		}
	}
	return csv_close(w);
}

/* ---- HDF5 ---- */

/* The HDF5 library may crash on damaged files, so a file begins with a user block (a part that HDF5 leaves
 * to its user) with a hash of all that follows; the library only sees files whose hash is right. */
enum { USER_BLOCK = 512 };

static void user_block(char block[USER_BLOCK], const char *text, size_t size)
{
	memset(block, 0, USER_BLOCK);
	snprintf(block, USER_BLOCK, "%s; the rest of this file is HDF5, FNV-1a %016" PRIx64 "\n", format_name,
			 hash_bytes(HASH_START, text + USER_BLOCK, size - USER_BLOCK));
}

static int seal(const char *path)
{
	char block[USER_BLOCK], *text;
	size_t size;
	CHECK(file_read(&text, &size, path));
	user_block(block, text, size);
	free(text);
	FILE *stream = fopen(path, "r+e");
	bool failed = !stream || fwrite(block, 1, sizeof block, stream) != sizeof block;
	if (stream && fclose(stream) != 0)
		failed = true;
	return failed ? error_set(STATUS_RESOURCE, "cannot write %s: %s", path, strerror(errno)) : STATUS_OK;
}

static int not_a_packing(const char *path, const char *what)
{
	return error_set(STATUS_INPUT, "%s: %s, expected a packing in HDF5 as `tmdempm rve pack` writes it", path, what);
}

static int check_seal(const char *path)
{
	char block[USER_BLOCK], *text;
	size_t size;
	CHECK(file_read(&text, &size, path));
	int status = STATUS_OK;
	if (size <= USER_BLOCK || strncmp(text, format_name, strlen(format_name)) != 0) {
		status = not_a_packing(path, "not a packing");
	} else {
		user_block(block, text, size);
		if (memcmp(block, text, USER_BLOCK) != 0)
			status = not_a_packing(path, "the file is damaged or was changed (its hash is wrong)");
	}
	free(text);
	return status;
}

/* One dataset with its unit; returns 0 or -1. */
static int put_dataset(hid_t file, const char *name, const char *unit, int rank, const hsize_t *dims, hid_t file_type,
					   hid_t type, const void *data)
{
	int failed = -1;
	hid_t space = H5Screate_simple(rank, dims, NULL), how = H5Pcreate(H5P_DATASET_CREATE);
	H5Pset_obj_track_times(how, 0); /* the same packing gives the same bytes */
	hid_t set = H5Dcreate2(file, name, file_type, space, H5P_DEFAULT, how, H5P_DEFAULT);
	hid_t string = H5Tcopy(H5T_C_S1), scalar = H5Screate(H5S_SCALAR);
	H5Tset_size(string, strlen(unit) + 1);
	hid_t attribute = set < 0 ? -1 : H5Acreate2(set, "unit", string, scalar, H5P_DEFAULT, H5P_DEFAULT);
	if (set >= 0 && attribute >= 0 && H5Awrite(attribute, string, unit) >= 0 &&
		(H5Sget_simple_extent_npoints(space) == 0 || H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0))
		failed = 0;
	if (attribute >= 0)
		H5Aclose(attribute);
	if (set >= 0)
		H5Dclose(set);
	H5Sclose(scalar), H5Tclose(string), H5Pclose(how), H5Sclose(space);
	return failed;
}

static int put_attribute(hid_t file, const char *name, hid_t file_type, hid_t type, const void *value)
{
	hid_t scalar = H5Screate(H5S_SCALAR);
	hid_t attribute = H5Acreate2(file, name, file_type, scalar, H5P_DEFAULT, H5P_DEFAULT);
	int failed = attribute < 0 || H5Awrite(attribute, type, value) < 0 ? -1 : 0;
	if (attribute >= 0)
		H5Aclose(attribute);
	H5Sclose(scalar);
	return failed;
}

static int put_text(hid_t file, const char *name, const char *text)
{
	hid_t string = H5Tcopy(H5T_C_S1);
	H5Tset_size(string, strlen(text) + 1);
	int failed = put_attribute(file, name, string, string, text);
	H5Tclose(string);
	return failed;
}

static int put_double(hid_t file, const char *name, double value)
{
	return put_attribute(file, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &value);
}

static int put_packing(hid_t file, const struct rve_packing *p, const char *key)
{
	const hsize_t cell[2] = {2, 2}, discs[2] = {(hsize_t)p->n_discs, 2}, pairs[2] = {(hsize_t)p->n_contacts, 4};
	unsigned seed = p->seed;
	int failed = put_text(file, "format", format_name);
	if (key)
		failed |= put_text(file, "key", key);
	failed |= put_double(file, "pressure", p->pressure);
	failed |= put_double(file, "mu", p->mu);
	failed |= put_double(file, "void_ratio", p->void_ratio);
	failed |= put_double(file, "unbalanced", p->unbalanced);
	failed |= put_attribute(file, "seed", H5T_STD_U32LE, H5T_NATIVE_UINT, &seed);
	failed |= put_dataset(file, "cell", "m", 2, cell, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, p->H);
	failed |= put_dataset(file, "disc_position", "m", 2, discs, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, p->x);
	failed |= put_dataset(file, "disc_radius", "m", 1, discs, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, p->r);
	failed |= put_dataset(file, "contact_pair", "-", 2, pairs, H5T_STD_I32LE, H5T_NATIVE_INT, p->pair);
	failed |= put_dataset(file, "contact_tangential_force", "N", 1, pairs, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, p->ft);
	return failed;
}

/* The library prints its error stack by default; our callers get one line instead. */
static void hdf5_quiet(void) { H5Eset_auto2(H5E_DEFAULT, NULL, NULL); }

static int write_h5(const struct rve_packing *p, const char *path, const char *key)
{
	char temporary[FILE_PATH];
	hdf5_quiet();
	if (file_is_folder(path))
		return error_set(STATUS_RESOURCE, "cannot write %s: it is a folder", path);
	CHECK(file_temporary(temporary, path));
	hid_t how = H5Pcreate(H5P_FILE_CREATE);
	H5Pset_userblock(how, USER_BLOCK);
	errno = 0;
	hid_t file = H5Fcreate(temporary, H5F_ACC_EXCL, how, H5P_DEFAULT);
	int failed = file < 0 ? -1 : put_packing(file, p, key), reason = errno;
	H5Pclose(how);
	if (file >= 0 && H5Fclose(file) < 0)
		failed = -1, reason = errno;
	int status = STATUS_OK;
	if (failed)
		status = error_set(STATUS_RESOURCE, "cannot write %s: %s", path,
						   reason ? strerror(reason) : "the HDF5 library failed");
	if (status == STATUS_OK)
		status = seal(temporary);
	if (status == STATUS_OK)
		return file_commit(temporary, path);
	unlink(temporary);
	return status;
}

static int get_attribute(hid_t file, const char *name, hid_t type, void *value)
{
	hid_t attribute = H5Aopen(file, name, H5P_DEFAULT);
	if (attribute < 0)
		return -1;
	hid_t space = H5Aget_space(attribute);
	int failed = H5Sget_simple_extent_npoints(space) != 1 || H5Aread(attribute, type, value) < 0 ? -1 : 0;
	H5Sclose(space);
	H5Aclose(attribute);
	return failed;
}

/* A fixed-length text attribute into text[size]. */
static int get_text(hid_t file, const char *name, char *text, size_t size)
{
	hid_t attribute = H5Aopen(file, name, H5P_DEFAULT);
	if (attribute < 0)
		return -1;
	hid_t type = H5Aget_type(attribute), space = H5Aget_space(attribute);
	int failed = -1;
	if (H5Tget_class(type) == H5T_STRING && H5Tis_variable_str(type) == 0 && H5Tget_size(type) <= size &&
		H5Sget_simple_extent_npoints(space) == 1 && H5Aread(attribute, type, text) >= 0) {
		text[H5Tget_size(type) - 1] = '\0';
		failed = 0;
	}
	H5Sclose(space), H5Tclose(type), H5Aclose(attribute);
	return failed;
}

/* Extent of a dataset that must have `rank` dimensions, the second (if any) of `width`; -1 if it is not so. */
static long dataset_rows(hid_t file, const char *name, int rank, hsize_t width)
{
	hsize_t dims[2] = {0, width};
	hid_t set = H5Dopen2(file, name, H5P_DEFAULT);
	if (set < 0)
		return -1;
	hid_t space = H5Dget_space(set);
	bool fits = H5Sget_simple_extent_ndims(space) == rank && H5Sget_simple_extent_dims(space, dims, NULL) == rank &&
				dims[1] == width && dims[0] < 1000000;
	H5Sclose(space);
	H5Dclose(set);
	return fits ? (long)dims[0] : -1;
}

static int get_dataset(hid_t file, const char *name, hid_t type, void *data)
{
	hid_t set = H5Dopen2(file, name, H5P_DEFAULT);
	if (set < 0)
		return -1;
	int failed = H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) < 0 ? -1 : 0;
	H5Dclose(set);
	return failed;
}

static int get_packing(hid_t file, struct rve_packing *p, const char *path)
{
	int failed = get_attribute(file, "pressure", H5T_NATIVE_DOUBLE, &p->pressure);
	failed |= get_attribute(file, "mu", H5T_NATIVE_DOUBLE, &p->mu);
	failed |= get_attribute(file, "void_ratio", H5T_NATIVE_DOUBLE, &p->void_ratio);
	failed |= get_attribute(file, "unbalanced", H5T_NATIVE_DOUBLE, &p->unbalanced);
	failed |= get_attribute(file, "seed", H5T_NATIVE_UINT, &p->seed);
	failed |= get_dataset(file, "cell", H5T_NATIVE_DOUBLE, p->H);
	failed |= get_dataset(file, "disc_position", H5T_NATIVE_DOUBLE, p->x);
	failed |= get_dataset(file, "disc_radius", H5T_NATIVE_DOUBLE, p->r);
	if (p->n_contacts > 0) {
		failed |= get_dataset(file, "contact_pair", H5T_NATIVE_INT, p->pair);
		failed |= get_dataset(file, "contact_tangential_force", H5T_NATIVE_DOUBLE, p->ft);
	}
	if (failed)
		return not_a_packing(path, "an attribute or a dataset is missing or damaged");
	return check_packing(p, &(struct place){.path = path});
}

/* `key`, if given, must be the file's. */
static int open_packing(hid_t file, struct rve_packing **packing, const char *path, const char *key)
{
	char text[2048];
	if (get_text(file, "format", text, sizeof text) || strcmp(text, format_name) != 0)
		return not_a_packing(path, "not a packing (attribute `format`)");
	if (key && (get_text(file, "key", text, sizeof text) || strcmp(text, key) != 0))
		return not_a_packing(path, "made with other parameters");
	long n = dataset_rows(file, "disc_position", 2, 2), m = dataset_rows(file, "contact_pair", 2, 4);
	if (n < 1 || n > DISCS_MAX || m < 0 || dataset_rows(file, "cell", 2, 2) != 2 ||
		dataset_rows(file, "disc_radius", 1, 0) != n || dataset_rows(file, "contact_tangential_force", 1, 0) != m)
		return not_a_packing(path, "datasets are missing or of wrong shape");
	struct rve_packing *p = packing_new((int)n, (int)m);
	if (!p)
		return no_memory(path);
	int status = get_packing(file, p, path);
	if (status == STATUS_OK)
		*packing = p;
	else
		rve_packing_free(p);
	return status;
}

static int read_h5(struct rve_packing **packing, const char *path, const char *key)
{
	hdf5_quiet();
	CHECK(check_seal(path));
	hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
	if (file < 0)
		return not_a_packing(path, "the HDF5 library cannot open it");
	int status = open_packing(file, packing, path, key);
	H5Fclose(file);
	return status;
}

/* ---- the two by name ---- */

int rve_packing_is(const char *path)
{
	char head[sizeof format_name] = "";
	FILE *stream = fopen(path, "rbe");
	size_t n = stream ? fread(head, 1, sizeof head - 1, stream) : 0;
	if (stream)
		fclose(stream);
	return n == sizeof head - 1 && !strcmp(head, format_name);
}

static int wrong_end(const char *path)
{
	return error_set(STATUS_INPUT, "%s: unknown kind of packing, expected a name that ends in .h5 or .csv", path);
}

int rve_packing_read(struct rve_packing **packing, const char *path)
{
	*packing = NULL;
	if (file_has_end(path, ".h5"))
		return read_h5(packing, path, NULL);
	return file_has_end(path, ".csv") ? read_csv(packing, path) : wrong_end(path);
}

int rve_packing_write(const struct rve_packing *packing, const char *path)
{
	if (file_has_end(path, ".h5"))
		return write_h5(packing, path, NULL);
	return file_has_end(path, ".csv") ? write_csv(packing, path) : wrong_end(path);
}

/* ---- cache ---- */

/* Everything that decides the bits of a generated packing, as text: parameters in hexadecimal floating
 * point and a hash of the sources that generate it (set by the build). */
static void cache_key(char *key, size_t size, const struct rve_packing_params *how, const struct rve_params *g)
{
	snprintf(key, size,
			 "%s; sources %s; discs %d radii %a %a pressure %a mu %a void_ratio %a seed %u square %d; "
			 "kn %a ks %a damping %a density %a thickness %a step_factor %a skin %a",
			 format_name, RVE_SOURCES_HASH, how->discs, how->radius_min, how->radius_max, how->pressure, how->mu,
			 how->void_ratio, how->seed, how->square_lattice, g->kn, g->ks, g->damping_ratio, g->grain_density,
			 g->thickness, g->step_factor, g->skin);
}

/* $XDG_CACHE_HOME (ignored if relative, as its specification says) or ~/.cache; 0 if there is neither. */
static bool cache_path(char path[FILE_PATH], const char *key)
{
	char folder[FILE_PATH], name[64];
	const char *cache = getenv("XDG_CACHE_HOME"), *home = getenv("HOME");
	if (cache && cache[0] == '/')
		snprintf(folder, sizeof folder, "%s/tmdempm/packings", cache);
	else if (home && home[0] == '/')
		snprintf(folder, sizeof folder, "%s/.cache/tmdempm/packings", home);
	else
		return false;
	snprintf(name, sizeof name, "%016" PRIx64 ".h5", hash_bytes(HASH_START, key, strlen(key)));
	return file_join(path, folder, name) == STATUS_OK;
}

/* The cache only saves time: whatever keeps it from being written, the packing is there. */
static void cache_store(const struct rve_packing *packing, const char *path, const char *key)
{
	char folder[FILE_PATH];
	if (file_folder(folder, path) == STATUS_OK && file_make_folder(folder) == STATUS_OK)
		(void)write_h5(packing, path, key);
}

int rve_packing_cached(struct rve_packing **packing, const struct rve_packing_params *how,
					   const struct rve_params *grains)
{
	char key[2048], path[FILE_PATH];
	*packing = NULL;
	cache_key(key, sizeof key, how, grains);
	bool cache = cache_path(path, key);
	if (cache && file_exists(path) && read_h5(packing, path, key) == STATUS_OK)
		return STATUS_OK;
	CHECK(rve_packing_generate(packing, how, grains));
	if (cache)
		cache_store(*packing, path, key);
	return STATUS_OK;
}
