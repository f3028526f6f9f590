#include "run/history.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "io/csv.h"
#include "run/fragments.h"

enum { LEDGER_COLUMNS = 8, NAME_BYTES = 160 };

/* What the ledger of an RVE gives, in the order of struct law_ledger. */
static const char *const ledger_names[LEDGER_COLUMNS] = {"work",    "elastic", "kinetic",   "friction",
														 "dashpot", "bond",    "expansion", "discarded"};

/* A probe's value is a weighted mean over points: one point, its initial neighbours, or those around a place. */
struct probe {
	int n;
	int *id;        /* MATERIAL and ID: who they are */
	int *point;     /* where they lie in storage, found for each row */
	double *weight; /* sum 1 */
};

struct history {
	const struct mpm *mpm;
	struct run_fields *fields;
	struct csv_writer *csv;
	struct probe *probes;
	double **columns; /* [fields][n * components], only with probes */
	bool breaks;      /* some law does: pieces are columns */
	double *spacing;  /* m, by point, of its lattice; only where something breaks */
	bool rve;         /* some law has RVEs: their ledgers are columns */
	struct history_memory *memory;
};

/* ---- probes ---- */

/* The points around X in the initial body, bilinear in the distance to them; its spacing is that of the
 * lattice of the nearest point. */
static void probe_material(struct probe *probe, const struct mpm *mpm, const double X[2])
{
	const struct particles *p = &mpm->p;
	int nearest = mpm_point_nearest_initial(mpm, X);
	if (nearest < 0)
		return;
	double side = sqrt(p->volume0[nearest] / mpm->scene->grid.thickness) * (1 + 1e-9), sum = 0;
	for (int i = 0; i < p->n; i++) {
		double dx = fabs(p->x0[i][0] - X[0]) / side, dy = fabs(p->x0[i][1] - X[1]) / side;
		double weight = p->body[i] == p->body[nearest] && dx < 1 && dy < 1 ? (1 - dx) * (1 - dy) : 0;
		if (weight > 1e-6 && probe->n < 16) {
			probe->id[probe->n] = p->id[i];
			probe->weight[probe->n++] = weight;
			sum += weight;
		}
	}
	if (probe->n == 0) {
		probe->id[0] = p->id[nearest];
		probe->weight[0] = sum = 1;
		probe->n = 1;
	}
	for (int k = 0; k < probe->n; k++)
		probe->weight[k] /= sum;
}

/* The points within one grid cell of a fixed place now, by volume and a tent; none: no value. */
static void probe_at(struct probe *probe, const struct mpm *mpm, const double X[2])
{
	const struct particles *p = &mpm->p;
	double h = mpm->grid.h, sum = 0;
	probe->n = 0;
	for (int i = 0; i < p->n; i++) {
		double dx = fabs(p->x[i][0] - X[0]) / h, dy = fabs(p->x[i][1] - X[1]) / h;
		if (dx < 1 && dy < 1) {
			probe->point[probe->n] = i;
			probe->weight[probe->n] = (1 - dx) * (1 - dy) * p->mass[i];
			sum += probe->weight[probe->n++];
		}
	}
	for (int k = 0; k < probe->n; k++)
		probe->weight[k] /= sum;
}

static void probe_find(struct probe *probe, const struct mpm *mpm)
{
	for (int k = 0; k < probe->n; k++)
		probe->point[k] = mpm_point_by_id(mpm, probe->id[k]);
}

static int probes_create(struct history *history)
{
	const struct scene *scene = history->mpm->scene;
	history->probes = calloc((size_t)scene->n_probes + 1, sizeof *history->probes);
	if (!history->probes)
		return error_set(STATUS_RESOURCE, "out of memory");
	for (int i = 0; i < scene->n_probes; i++) {
		const struct scene_probe *from = &scene->probes[i];
		struct probe *probe = &history->probes[i];
		size_t most = from->kind == SCENE_PROBE_AT ? (size_t)history->mpm->p.n : 16;
		probe->id = malloc(sizeof *probe->id * (most + 1));
		probe->point = malloc(sizeof *probe->point * (most + 1));
		probe->weight = malloc(sizeof *probe->weight * (most + 1));
		if (!probe->id || !probe->point || !probe->weight)
			return error_set(STATUS_RESOURCE, "out of memory");
		if (from->kind == SCENE_PROBE_ID) {
			probe->n = 1, probe->id[0] = (int)from->id, probe->weight[0] = 1;
		} else if (from->kind == SCENE_PROBE_MATERIAL) {
			probe_material(probe, history->mpm, from->at);
		}
	}
	return STATUS_OK;
}

static double probe_mean(const struct history *history, int i, const double *values, int stride, int component)
{
	const struct probe *probe = &history->probes[i];
	double sum = probe->n ? 0 : NAN;
	for (int k = 0; k < probe->n; k++)
		sum += probe->weight[k] * values[(size_t)probe->point[k] * (size_t)stride + (size_t)component];
	return sum;
}

static void probe_ledgers(const struct history *history, int i, double out[LEDGER_COLUMNS])
{
	const struct mpm *mpm = history->mpm;
	const struct probe *probe = &history->probes[i];
	for (int c = 0; c < LEDGER_COLUMNS; c++)
		out[c] = probe->n ? 0 : NAN;
	for (int k = 0; k < probe->n; k++) {
		int point = probe->point[k];
		const struct law *law = mpm->laws[mpm->p.law[point]];
		struct law_ledger ledger;
		law->type->ledger(law, mpm->p.slot[point], &ledger);
		const double values[LEDGER_COLUMNS] = {ledger.work,    ledger.elastic, ledger.kinetic,   ledger.friction,
											   ledger.dashpot, ledger.bond,    ledger.expansion, ledger.discarded};
		for (int c = 0; c < LEDGER_COLUMNS; c++)
			out[c] += probe->weight[k] * values[c];
	}
}

/* ---- the header ---- */

static void history_name(struct history *history, const char *prefix, const char *owner, const char *what,
						 const char *ending, const char *unit)
{
	char name[NAME_BYTES];
	snprintf(name, sizeof name, "%s%s%s%s%s", prefix, owner, *owner ? "." : "", what, ending);
	csv_name(history->csv, name, unit);
}

static void history_probe_header(struct history *history, const char *owner)
{
	history_name(history, "", owner, "position", "_x", "m");
	history_name(history, "", owner, "position", "_y", "m");
	for (int f = 0; f < history->fields->n; f++) {
		const struct run_field *field = &history->fields->fields[f];
		for (int c = 0; c < field->field->components; c++) {
			const char *ending = field_component_ending(field->field->components, c);
			if (ending)
				history_name(history, "", owner, field->field->name, ending, field->unit);
		}
	}
	for (int c = 0; history->rve && c < LEDGER_COLUMNS; c++)
		history_name(history, "", owner, "rve_", ledger_names[c], "J/m3");
}

static void history_fracture_header(struct history *history)
{
	const struct scene *scene = history->mpm->scene;
	static const struct {
		const char *name, *unit;
	} pieces[] = {{"fragments.count", "-"},     {"fragments.diameter_mean", "m"}, {"fragments.diameter_deviation", "m"},
				  {"fragments.roundness", "-"}, {"fragments.largest", "m2"},      {"fragments.broken", "m2"}},
	  crack[] = {{"tip_x", "m"}, {"tip_y", "m"}, {"length", "m"}, {"speed", "m/s"}, {"angle", "deg"}};
	for (size_t k = 0; history->breaks && k < sizeof pieces / sizeof *pieces; k++)
		csv_name(history->csv, pieces[k].name, pieces[k].unit);
	for (int c = 0; c < scene->n_cracks; c++)
		for (size_t k = 0; k < sizeof crack / sizeof *crack; k++)
			history_name(history, "crack.", scene->cracks[c].name, crack[k].name, "", crack[k].unit);
}

static int history_header(struct history *history)
{
	const struct scene *scene = history->mpm->scene;
	csv_name(history->csv, "time", "s");
	csv_name(history->csv, "step", "-");
	csv_name(history->csv, "dt", "s");
	for (int f = 0; f < mpm_ledger_fields_count; f++)
		csv_name(history->csv, mpm_ledger_fields[f].name, mpm_ledger_fields[f].unit);
	for (int r = 0; r < scene->n_regions; r++) {
		history_name(history, "region.", scene->regions[r].name, "mass", "", "kg");
		history_name(history, "region.", scene->regions[r].name, "flow", "", "kg/s");
		history_name(history, "region.", scene->regions[r].name, "volume", "", "m3");
		history_name(history, "region.", scene->regions[r].name, "temperature", "", scene_temperature_unit(scene));
	}
	for (int w = 0; w < scene->n_walls; w++) {
		history_name(history, "wall.", scene->walls[w].name, "force_x", "", "N");
		history_name(history, "wall.", scene->walls[w].name, "force_y", "", "N");
		history_name(history, "wall.", scene->walls[w].name, "friction_heat", "", "J");
		history_name(history, "wall.", scene->walls[w].name, "heat", "", "J");
	}
	history_fracture_header(history);
	for (int i = 0; i < scene->n_probes; i++)
		history_probe_header(history, scene->probes[i].name);
	return csv_end_row(history->csv);
}

/* ---- a row ---- */

static void history_regions(struct history *history, bool scheduled)
{
	const struct mpm *mpm = history->mpm;
	double elapsed = mpm->time - history->memory->time;
	for (int r = 0; r < mpm->scene->n_regions; r++) {
		struct mpm_region_values values;
		mpm_region(mpm, &mpm->scene->regions[r], &values);
		csv_number(history->csv, values.mass);
		csv_number(history->csv, elapsed > 0 ? (history->memory->region_mass[r] - values.mass) / elapsed : 0.0);
		csv_number(history->csv, values.volume);
		csv_number(history->csv, scene_temperature_out(mpm->scene, values.temperature));
		if (scheduled)
			history->memory->region_mass[r] = values.mass;
	}
}

static void history_pieces(struct history *history, const struct fragment_summary *s)
{
	csv_integer(history->csv, s->count);
	csv_number(history->csv, s->diameter_mean);
	csv_number(history->csv, s->diameter_deviation);
	csv_number(history->csv, s->roundness_mean);
	csv_number(history->csv, s->largest);
	csv_number(history->csv, s->broken);
}

static int history_crack(struct history *history, const struct fragment_points *points, int c, bool scheduled)
{
	const struct scene_crack *scene = &history->mpm->scene->cracks[c];
	struct crack crack;
	double elapsed = history->mpm->time - history->memory->time;
	CHECK(fragments_crack(&crack, points, scene->at, scene->reach));
	csv_number(history->csv, crack.tip[0]);
	csv_number(history->csv, crack.tip[1]);
	csv_number(history->csv, crack.length);
	csv_number(history->csv, elapsed > 0 ? (crack.length - history->memory->crack_length[c]) / elapsed : 0.0);
	csv_number(history->csv, crack.angle * 180.0 / M_PI - scene->axis);
	if (scheduled)
		history->memory->crack_length[c] = crack.length;
	return STATUS_OK;
}

/* Pieces and cracks, from the points as they are. */
static int history_fracture(struct history *history, bool scheduled)
{
	const struct mpm *mpm = history->mpm;
	const struct particles *p = &mpm->p;
	if (!history->breaks)
		return STATUS_OK;
	for (int k = 0; k < p->n; k++)
		history->spacing[k] = sqrt(p->volume0[k] / mpm->grid.thickness);
	const struct fragment_points points = {.n = p->n,
										   .X = (const double(*)[2])p->x0,
										   .x = (const double(*)[2])p->x,
										   .damage = p->damage,
										   .spacing = history->spacing,
										   .mass = p->mass,
										   .body = p->body};
	struct fragments fragments;
	CHECK(fragments_find(&fragments, &points));
	struct fragment_summary summary = fragments_summary(&fragments);
	fragments_free(&fragments);
	history_pieces(history, &summary);
	for (int c = 0; c < mpm->scene->n_cracks; c++)
		CHECK(history_crack(history, &points, c, scheduled));
	return STATUS_OK;
}

static void history_probe(struct history *history, int i)
{
	const struct mpm *mpm = history->mpm;
	const struct scene_probe *probe = &mpm->scene->probes[i];
	if (probe->kind == SCENE_PROBE_AT)
		probe_at(&history->probes[i], mpm, probe->at);
	else
		probe_find(&history->probes[i], mpm);
	for (int c = 0; c < 2; c++)
		csv_number(history->csv,
				   probe->kind == SCENE_PROBE_AT ? probe->at[c] : probe_mean(history, i, mpm->p.x[0], 2, c));
	for (int f = 0; f < history->fields->n; f++) {
		int components = history->fields->fields[f].field->components;
		for (int c = 0; c < components; c++)
			if (field_component_ending(components, c))
				csv_number(history->csv, probe_mean(history, i, history->columns[f], components, c));
	}
	double ledger[LEDGER_COLUMNS];
	if (history->rve)
		probe_ledgers(history, i, ledger);
	for (int c = 0; history->rve && c < LEDGER_COLUMNS; c++)
		csv_number(history->csv, ledger[c]);
}

int history_row(struct history *history, bool scheduled)
{
	const struct mpm *mpm = history->mpm;
	csv_number(history->csv, mpm->time);
	csv_integer(history->csv, mpm->step);
	csv_number(history->csv, mpm->dt);
	const double *ledger = (const double *)&mpm->ledger;
	for (int f = 0; f < mpm_ledger_fields_count; f++)
		csv_number(history->csv, ledger[f]);
	history_regions(history, scheduled);
	for (int w = 0; w < mpm->scene->n_walls; w++) {
		csv_number(history->csv, mpm->walls[w].force[0]);
		csv_number(history->csv, mpm->walls[w].force[1]);
		csv_number(history->csv, mpm->walls[w].friction_heat);
		csv_number(history->csv, mpm->walls[w].heat);
	}
	CHECK(history_fracture(history, scheduled));
	for (int f = 0; history->columns && f < history->fields->n; f++)
		fields_get(history->fields, mpm, f, history->columns[f]);
	for (int i = 0; i < mpm->scene->n_probes; i++)
		history_probe(history, i);
	if (scheduled)
		history->memory->time = mpm->time;
	return csv_end_row(history->csv);
}

int history_sync(struct history *history) { return csv_sync(history->csv); }

/* ---- life ---- */

static int history_allocate(struct history *history)
{
	const struct mpm *mpm = history->mpm;
	for (int l = 0; l < mpm->n_laws; l++)
		history->rve |= mpm->laws[l]->type->rve_view != NULL, history->breaks |= mpm->laws[l]->type->breaks;
	if (history->breaks && !(history->spacing = malloc(((size_t)mpm->p.n + 1) * sizeof *history->spacing)))
		return error_set(STATUS_RESOURCE, "out of memory");
	CHECK(probes_create(history));
	if (mpm->scene->n_probes == 0)
		return STATUS_OK;
	history->columns = calloc((size_t)history->fields->n + 1, sizeof *history->columns);
	for (int f = 0; history->columns && f < history->fields->n; f++) {
		size_t count = (size_t)mpm->p.n * (size_t)history->fields->fields[f].field->components;
		history->columns[f] = malloc((count + 1) * sizeof(double));
		if (!history->columns[f])
			return error_set(STATUS_RESOURCE, "out of memory");
	}
	return history->columns ? STATUS_OK : error_set(STATUS_RESOURCE, "out of memory");
}

int history_memory_create(struct history_memory *memory, int n_regions, int n_cracks)
{
	memory->time = NAN;
	memory->region_mass = calloc((size_t)n_regions + 1, sizeof(double));
	memory->crack_length = calloc((size_t)n_cracks + 1, sizeof(double));
	return memory->region_mass && memory->crack_length ? STATUS_OK : error_set(STATUS_RESOURCE, "out of memory");
}

void history_memory_free(struct history_memory *memory)
{
	free(memory->region_mass);
	free(memory->crack_length);
	memory->region_mass = memory->crack_length = NULL;
}

int history_create(struct history **result, const char *path, const struct mpm *mpm, struct run_fields *fields,
				   struct history_memory *memory, bool append)
{
	*result = NULL;
	struct history *history = calloc(1, sizeof *history);
	if (!history)
		return error_set(STATUS_RESOURCE, "out of memory");
	history->mpm = mpm;
	history->fields = fields;
	history->memory = memory;
	int status = history_allocate(history);
	if (status == STATUS_OK && append)
		status = csv_cut(path, memory->time);
	if (status == STATUS_OK)
		status = csv_open(&history->csv, path, append);
	if (status == STATUS_OK && !append)
		status = history_header(history);
	if (status != STATUS_OK) {
		history_close(history);
		return status;
	}
	*result = history;
	return STATUS_OK;
}

int history_close(struct history *history)
{
	if (!history)
		return STATUS_OK;
	int status = history->csv ? csv_close(history->csv) : STATUS_OK;
	for (int i = 0; history->probes && i < history->mpm->scene->n_probes; i++) {
		free(history->probes[i].id);
		free(history->probes[i].point);
		free(history->probes[i].weight);
	}
	for (int f = 0; history->columns && f < history->fields->n; f++)
		free(history->columns[f]);
	free(history->columns);
	free(history->spacing);
	free(history->probes);
	free(history);
	return status;
}
