#include "rve/rve_file.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "base/hash.h"
#include "io/h5.h"
#include "rve/model.h"

enum { RVE_FILE_VERSION = 1, PACKINGS_MAX = 1000 };

static const char format_name[] = "tmdempm rve";

/* Every parameter by name: what is not written here a reader would not know. */
static const struct {
	const char *name;
	size_t offset;
	bool integer;
} params_table[] = {
#define NUMBER(field)                                                                                                  \
	{                                                                                                                  \
#field, offsetof(struct rve_params, field), false                                                              \
	}
#define INTEGER(field)                                                                                                 \
	{                                                                                                                  \
#field, offsetof(struct rve_params, field), true                                                               \
	}
	INTEGER(path),
	NUMBER(kn),
	NUMBER(ks),
	NUMBER(mu),
	NUMBER(damping_ratio),
	NUMBER(grain_density),
	NUMBER(thickness),
	NUMBER(expansion),
	NUMBER(resistance),
	NUMBER(step_factor),
	NUMBER(strain_per_step),
	INTEGER(pressure_scaling),
	INTEGER(n_max),
	NUMBER(skin),
	INTEGER(gas),
	NUMBER(gas_pressure),
	NUMBER(gas_stretch),
	NUMBER(bond_strength),
	NUMBER(bond_mu),
	NUMBER(bond_melting),
	NUMBER(bond_reference),
	INTEGER(step_guard),
	NUMBER(overlap_max),
	NUMBER(pace_stress),
	NUMBER(pace_calm),
	NUMBER(pace_unbalanced),
	NUMBER(pace_sliding),
	NUMBER(quiet_change),
	NUMBER(quiet_strain),
	NUMBER(quiet_unbalanced),
};
_Static_assert(sizeof(struct rve_params) == 232, "a parameter has come or gone: params_table above must know it");
enum { PARAMS = sizeof params_table / sizeof *params_table };

/* States are copied as they lie in memory: a hash of how they do, for those that lie otherwise. */
static long long layout_hash(const struct rve_model *model)
{
	uint64_t hash = hash_bytes(HASH_START, &model->layout, sizeof model->layout);
	const int sizes[] = {(int)sizeof(struct rve_head),
						 (int)sizeof(real),
						 (int)sizeof(index16),
						 DISC_STATE_FIELDS,
						 DISC32_FIELDS,
						 LEDGER_FIELDS};
	return (long long)hash_bytes(hash, sizes, sizeof sizes);
}

/* ---- writing ---- */

static int write_origin(hid_t file, const struct rve_origin *origin)
{
	CHECK(h5_attribute_text(file, ".", "name", origin->name));
	CHECK(h5_attribute_text(file, ".", "law", origin->law));
	CHECK(h5_attribute_integer(file, ".", "point", origin->point));
	CHECK(h5_attribute_integer(file, ".", "step", origin->step));
	CHECK(h5_attribute_number(file, ".", "time", origin->time));
	return h5_attribute_number(file, ".", "temperature", origin->T);
}

static int write_params(hid_t file, const struct rve_params *params)
{
	hid_t group;
	int status = STATUS_OK;
	CHECK(h5_group(&group, file, "parameters"));
	for (int k = 0; k < PARAMS && status == STATUS_OK; k++) {
		const char *at = (const char *)params + params_table[k].offset;
		status = params_table[k].integer ? h5_attribute_integer(group, ".", params_table[k].name, *(const int *)at)
										 : h5_attribute_number(group, ".", params_table[k].name, *(const double *)at);
	}
	H5Gclose(group);
	return status;
}

/* What other programs can read: the cell, the discs and the contacts as they are. */
static int write_readable(hid_t file, const struct rve_model *model, const void *state)
{
	int n = rve_discs(model), capacity = rve_contact_capacity(model);
	struct rve_disc *discs = calloc((size_t)n, sizeof *discs);
	struct rve_contact *contacts = calloc((size_t)capacity + 1, sizeof *contacts);
	int m = discs && contacts ? rve_inspect(model, state, discs, contacts, capacity) : 0;
	double(*x)[2] = malloc(sizeof *x * (size_t)n), *r = malloc(sizeof *r * (size_t)n);
	double(*force)[2] = malloc(sizeof *force * (size_t)(m + 1));
	int(*pair)[4] = malloc(sizeof *pair * (size_t)(m + 1)), *bond = malloc(sizeof *bond * (size_t)(m + 1));
	struct rve_info info;
	rve_get_info(model, state, &info);
	int status = discs && contacts && x && r && force && pair && bond
					 ? h5_write(file, "cell", H5T_NATIVE_DOUBLE, 2, 2, info.H)
					 : error_set(STATUS_RESOURCE, "out of memory for an RVE of %d discs", n);
	for (int i = 0; status == STATUS_OK && i < n; i++)
		x[i][0] = discs[i].x, x[i][1] = discs[i].y, r[i] = discs[i].radius;
	for (int c = 0; status == STATUS_OK && c < m; c++) {
		const struct rve_contact *k = &contacts[c];
		memcpy(pair[c], (int[4]){k->i, k->j, k->shift[0], k->shift[1]}, sizeof *pair);
		force[c][0] = k->normal_force, force[c][1] = k->tangential_force, bond[c] = k->bond;
	}
	if (status == STATUS_OK)
		status = h5_write(file, "disc_position", H5T_NATIVE_DOUBLE, (hsize_t)n, 2, x);
	if (status == STATUS_OK)
		status = h5_write(file, "disc_radius", H5T_NATIVE_DOUBLE, (hsize_t)n, 0, r);
	if (status == STATUS_OK)
		status = h5_write(file, "contact_pair", H5T_NATIVE_INT, (hsize_t)m, 4, pair);
	if (status == STATUS_OK)
		status = h5_write(file, "contact_force", H5T_NATIVE_DOUBLE, (hsize_t)m, 2, force);
	if (status == STATUS_OK)
		status = h5_write(file, "contact_bond", H5T_NATIVE_INT, (hsize_t)m, 0, bond);
	free(discs), free(contacts), free(x), free(r), free(force), free(pair), free(bond);
	return status;
}

/* How all packings of the law began: cells, discs in the packing's order, and the states, which have every bit. */
static int write_birth(hid_t file, const struct rve_model *model, uint64_t *hash)
{
	const struct rve_layout *layout = &model->layout;
	size_t n = (size_t)layout->n, variants = (size_t)model->n_variants, bytes = (size_t)layout->bytes;
	double *radius = malloc(sizeof *radius * n * variants), (*x)[2] = malloc(sizeof *x * n * variants);
	double(*cell)[4] = malloc(sizeof *cell * variants);
	unsigned char *starts = malloc(bytes * variants);
	struct rve_disc *discs = calloc(n, sizeof *discs);
	int status = radius && x && cell && starts && discs
					 ? STATUS_OK
					 : error_set(STATUS_RESOURCE, "out of memory for %zu packings", variants);
	for (size_t v = 0; status == STATUS_OK && v < variants; v++) {
		const struct rve_variant *variant = &model->variants[v];
		rve_inspect(model, variant->start, discs, NULL, 0);
		for (size_t i = 0; i < n; i++)
			x[v * n + i][0] = discs[i].x, x[v * n + i][1] = discs[i].y;
		memcpy(cell[v], ((const struct rve_head *)variant->start)->H, sizeof *cell);
		memcpy(radius + v * n, variant->table + TABLE_R * model->serial.stride, sizeof *radius * n);
		memcpy(starts + v * bytes, variant->start, bytes);
	}
	if (status == STATUS_OK) {
		*hash = hash_bytes(*hash, radius, sizeof *radius * n * variants);
		*hash = hash_bytes(*hash, starts, bytes * variants);
		status = h5_write(file, "birth/radius", H5T_NATIVE_DOUBLE, variants, n, radius);
	}
	if (status == STATUS_OK)
		status = h5_write(file, "birth/position", H5T_NATIVE_DOUBLE, variants, 2 * n, x);
	if (status == STATUS_OK)
		status = h5_write(file, "birth/cell", H5T_NATIVE_DOUBLE, variants, 4, cell);
	if (status == STATUS_OK)
		status = h5_write(file, "birth/state", H5T_NATIVE_UCHAR, variants, bytes, starts);
	free(radius), free(x), free(cell), free(starts), free(discs);
	return status;
}

/* The bits, and what tells whether they are whole. */
static int write_bits(hid_t file, const struct rve_model *model, const void *state)
{
	uint64_t hash = HASH_START;
	CHECK(write_birth(file, model, &hash));
	hash = hash_bytes(hash, state, rve_state_bytes(model));
	CHECK(h5_write(file, "state", H5T_NATIVE_UCHAR, rve_state_bytes(model), 0, state));
	return h5_attribute_integer(file, ".", "hash", (long long)hash);
}

static int write_all(hid_t file, const struct rve_model *model, const void *state, const struct rve_origin *origin)
{
	CHECK(h5_attribute_text(file, ".", "format", format_name));
	CHECK(h5_attribute_integer(file, ".", "version", RVE_FILE_VERSION));
	CHECK(h5_attribute_integer(file, ".", "layout", layout_hash(model)));
	CHECK(write_origin(file, origin));
	CHECK(write_params(file, &model->params));
	CHECK(write_readable(file, model, state));
	return write_bits(file, model, state);
}

int rve_file_write(const char *path, const struct rve_model *model, const void *state, const struct rve_origin *origin)
{
	struct h5_output output;
	if (file_is_folder(path))
		return error_set(STATUS_RESOURCE, "cannot write %s: it is a folder", path);
	CHECK(h5_begin(&output, path));
	int status = write_all(output.file, model, state, origin);
	if (status == STATUS_OK)
		return h5_commit(&output);
	h5_abandon(&output);
	return error_context(status, "%s", path);
}

/* ---- reading ---- */

static int read_short_text(hid_t file, const char *name, char *to, size_t size, const char *path)
{
	char *text;
	CHECK(h5_read_attribute_text(file, name, &text, path));
	snprintf(to, size, "%s", text);
	free(text);
	return STATUS_OK;
}

static int read_origin(hid_t file, struct rve_origin *origin, const char *path)
{
	CHECK(read_short_text(file, "name", origin->name, sizeof origin->name, path));
	CHECK(read_short_text(file, "law", origin->law, sizeof origin->law, path));
	CHECK(h5_read_integer(file, "point", &origin->point, path));
	CHECK(h5_read_integer(file, "step", &origin->step, path));
	CHECK(h5_read_number(file, "time", &origin->time, path));
	return h5_read_number(file, "temperature", &origin->T, path);
}

static int read_params(hid_t file, struct rve_params *params, const char *path)
{
	hid_t group = H5Gopen2(file, "parameters", H5P_DEFAULT);
	if (group < 0)
		return error_set(STATUS_INPUT, "%s holds no `parameters`", path);
	int status = STATUS_OK;
	for (int k = 0; k < PARAMS && status == STATUS_OK; k++) {
		char *at = (char *)params + params_table[k].offset;
		long long integer = 0;
		if (!params_table[k].integer) {
			status = h5_read_number(group, params_table[k].name, (double *)at, path);
			continue;
		}
		status = h5_read_integer(group, params_table[k].name, &integer, path);
		*(int *)at = (int)integer;
	}
	H5Gclose(group);
	return status;
}

/* Sizes of what follows, and room for it. */
static int read_sizes(hid_t file, struct rve_file *f, size_t *discs, const char *path)
{
	hsize_t variants, n, twice, bytes, rows, columns;
	CHECK(h5_size(file, "birth/radius", &variants, &n, path));
	CHECK(h5_size(file, "birth/position", &rows, &twice, path));
	CHECK(h5_size(file, "birth/state", &columns, &bytes, path));
	if (variants < 1 || variants > PACKINGS_MAX || n < 1 || n > UINT16_MAX || rows != variants || twice != 2 * n ||
		columns != variants || bytes < sizeof(struct rve_head) || bytes % 64)
		return error_set(STATUS_INPUT, "%s is damaged: its datasets do not belong together", path);
	*discs = n;
	f->state_bytes = bytes;
	f->packings = calloc(variants, sizeof *f->packings);
	f->starts = malloc(variants * bytes);
	f->state = aligned_alloc(64, bytes);
	f->n_packings = (int)variants;
	for (int v = 0; f->packings && v < f->n_packings; v++)
		if (!(f->packings[v] = rve_packing_alloc((int)n, 0)))
			return error_set(STATUS_RESOURCE, "no memory for %s", path);
	return f->packings && f->starts && f->state ? STATUS_OK : error_set(STATUS_RESOURCE, "no memory for %s", path);
}

static void fill_packings(struct rve_file *f, size_t n, const double *radius, const double (*x)[2],
						  const double (*cell)[4])
{
	for (int k = 0; k < f->n_packings; k++) {
		struct rve_packing *p = f->packings[k];
		size_t v = (size_t)k;
		memcpy(p->H, cell[v], sizeof p->H);
		memcpy(p->r, radius + v * n, sizeof *radius * n);
		memcpy(p->x, x[v * n], sizeof *x * n);
		p->pressure = p->mu = p->unbalanced = NAN;
		p->void_ratio = rve_packing_void_ratio(p);
	}
}

static int read_bits(hid_t file, struct rve_file *f, const char *path)
{
	size_t n = 0;
	long long stored = 0;
	CHECK(read_sizes(file, f, &n, path));
	size_t all = n * (size_t)f->n_packings, bytes = f->state_bytes * (size_t)f->n_packings;
	double *radius = malloc(sizeof *radius * all), (*x)[2] = malloc(sizeof *x * all);
	double(*cell)[4] = malloc(sizeof *cell * (size_t)f->n_packings);
	int status = radius && x && cell ? STATUS_OK : error_set(STATUS_RESOURCE, "no memory for %s", path);
	if (status == STATUS_OK)
		status = h5_read(file, "birth/radius", H5T_NATIVE_DOUBLE, all, radius, path);
	if (status == STATUS_OK)
		status = h5_read(file, "birth/position", H5T_NATIVE_DOUBLE, 2 * all, x, path);
	if (status == STATUS_OK)
		status = h5_read(file, "birth/cell", H5T_NATIVE_DOUBLE, 4 * (hsize_t)f->n_packings, cell, path);
	if (status == STATUS_OK)
		status = h5_read(file, "birth/state", H5T_NATIVE_UCHAR, bytes, f->starts, path);
	if (status == STATUS_OK)
		status = h5_read(file, "state", H5T_NATIVE_UCHAR, f->state_bytes, f->state, path);
	if (status == STATUS_OK)
		status = h5_read_integer(file, "hash", &stored, path);
	if (status == STATUS_OK) {
		uint64_t hash = hash_bytes(HASH_START, radius, sizeof *radius * all);
		hash = hash_bytes(hash_bytes(hash, f->starts, bytes), f->state, f->state_bytes);
		f->hash = hash;
		if ((long long)hash != stored)
			status = error_set(STATUS_INPUT, "%s is damaged or was changed: its hash is wrong", path);
		else
			fill_packings(f, n, radius, (const double(*)[2])x, (const double(*)[4])cell);
	}
	free(radius), free(x), free(cell);
	return status;
}

static int read_format(hid_t file, const char *path)
{
	char *format;
	long long version = 0;
	int status = h5_read_attribute_text(file, "format", &format, path);
	if (status != STATUS_OK || strcmp(format, format_name) != 0)
		status = error_set(STATUS_INPUT, "%s is not an RVE file, expected one that `tmdempm rve extract` wrote", path);
	else
		status = h5_read_integer(file, "version", &version, path);
	free(format);
	if (status == STATUS_OK && version != RVE_FILE_VERSION)
		status = error_set(STATUS_INPUT, "%s has the format version %lld, expected %d: it is another release's", path,
						   version, RVE_FILE_VERSION);
	return status;
}

/* Does this release keep states as the file does?  Only a model of the file's own parameters can tell. */
static int check_layout(hid_t file, const struct rve_file *f, const char *path)
{
	struct rve_model *model;
	long long stored;
	CHECK(h5_read_integer(file, "layout", &stored, path));
	int status = rve_model_create(&model, &f->params, f->n_packings, (const struct rve_packing *const *)f->packings);
	if (status != STATUS_OK)
		return error_context(status, "%s", path);
	bool same = layout_hash(model) == stored && rve_state_bytes(model) == f->state_bytes;
	int variant = ((const struct rve_head *)f->state)->variant;
	rve_model_free(model);
	if (!same || variant < 0 || variant >= f->n_packings)
		return error_set(STATUS_INPUT,
						 "%s holds a state as another release keeps it, which this one cannot go on from; extract it "
						 "again with this release",
						 path);
	return STATUS_OK;
}

static int read_all(hid_t file, struct rve_file *f, const char *path)
{
	CHECK(read_format(file, path));
	CHECK(read_origin(file, &f->origin, path));
	CHECK(read_params(file, &f->params, path));
	CHECK(read_bits(file, f, path));
	return check_layout(file, f, path);
}

int rve_file_read(struct rve_file **result, const char *path)
{
	hid_t file;
	*result = NULL;
	CHECK(h5_open(&file, path));
	struct rve_file *f = calloc(1, sizeof *f);
	int status = f ? read_all(file, f, path) : error_set(STATUS_RESOURCE, "no memory for %s", path);
	H5Fclose(file);
	if (status == STATUS_OK)
		*result = f;
	else
		rve_file_free(f);
	return status;
}

/* Packings begin with a text of their own, HDF5 that we write otherwise with its signature. */
bool rve_file_is(const char *path)
{
	hid_t file;
	char head[4] = "", *format = NULL;
	FILE *stream = fopen(path, "rbe");
	bool is = stream && fread(head, 1, sizeof head, stream) == sizeof head && !memcmp(head, "\x89HDF", sizeof head);
	if (stream)
		fclose(stream);
	if (!is || h5_open(&file, path) != STATUS_OK)
		return is;
	is = h5_read_attribute_text(file, "format", &format, path) == STATUS_OK && !strcmp(format, format_name);
	free(format);
	H5Fclose(file);
	return is;
}

void rve_file_free(struct rve_file *file)
{
	if (!file)
		return;
	for (int v = 0; file->packings && v < file->n_packings; v++)
		rve_packing_free(file->packings[v]);
	free(file->packings);
	free(file->starts);
	free(file->state);
	free(file);
}

int rve_file_model(struct rve_model **result, const struct rve_file *file, const struct rve_params *params)
{
	struct rve_model *model;
	*result = NULL;
	if (params->skin != file->params.skin)
		return error_set(STATUS_INPUT, "the skin is %g, expected %g: an RVE file goes on with its own", params->skin,
						 file->params.skin);
	if (params->path != file->params.path)
		return error_set(STATUS_INPUT, "the path is `%s`, expected `%s`: an RVE file goes on with its own",
						 rve_path_name(params->path), rve_path_name(file->params.path));
	CHECK(rve_model_create(&model, params, file->n_packings, (const struct rve_packing *const *)file->packings));
	for (int v = 0; v < file->n_packings; v++)
		memcpy(model->variants[v].start, file->starts + (size_t)v * file->state_bytes, file->state_bytes);
	*result = model;
	return STATUS_OK;
}
