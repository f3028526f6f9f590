#include "run/fragments_cli.h"

#include <dirent.h>
#include <errno.h>
#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/error.h"
#include "base/mat2.h"
#include "io/csv.h"
#include "io/h5.h"
#include "io/vtk.h"
#include "run/fragments.h"
#include "run/viewer.h"

static const char help[] =
	"usage: tmdempm fragments RUN_FOLDER|run.h5 [--time T] [--out FOLDER]\n"
	"\n"
	"Finds the pieces into which the bodies of a run have broken, and its cracks.  Writes into FOLDER "
	"(RUN_FOLDER/fragments):\n"
	"  pieces.csv        of one snapshot, the largest first: area, mass, place, diameter of equal area, roundness\n"
	"  distribution.csv  of the same: share of the pieces, and of their area, that are no wider than each diameter\n"
	"  series.csv        of every snapshot: number, mean diameter and its deviation (by number, and by area), roundness,\n"
	"                    largest, broken area\n"
	"  cracks.vtp        the middle of what is broken, as lines\n"
	"pipelines/fragments_chart.py FOLDER... draws the distributions.\n"
	"  --time T          s: the snapshot that is nearest (the last)\n";

/* ---- a snapshot's points ---- */

struct loaded {
	double time, *damage, *mass, *spacing;
	double (*X)[2], (*x)[2];
	int *body;
	struct fragment_points points;
};

static void loaded_free(struct loaded *l)
{
	free(l->damage), free(l->mass), free(l->spacing), free(l->X), free(l->x), free(l->body);
	*l = (struct loaded){0};
}

/* points/NAME of n rows into a new array. */
static int read_field(hid_t file, const char *name, int n, int components, double **values, const char *path)
{
	char dataset[96];
	snprintf(dataset, sizeof dataset, "points/%s", name);
	*values = malloc(((size_t)n * (size_t)components + 1) * sizeof **values);
	if (!*values)
		return error_set(STATUS_RESOURCE, "out of memory for %d points", n);
	return h5_read(file, dataset, H5T_NATIVE_DOUBLE, (hsize_t)n * (hsize_t)components, *values, path);
}

/* Places at birth and spacings, from what a snapshot holds. */
static int derive(hid_t file, struct loaded *l, double thickness, const char *path)
{
	double *way = NULL, *F = NULL, *volume = NULL, *body = NULL;
	int n = l->points.n, status = read_field(file, "displacement", n, 3, &way, path);
	if (status == STATUS_OK)
		status = read_field(file, "deformation_gradient", n, 4, &F, path);
	if (status == STATUS_OK)
		status = read_field(file, "volume", n, 1, &volume, path);
	if (status == STATUS_OK)
		status = read_field(file, "body", n, 1, &body, path);
	for (int k = 0; k < n && status == STATUS_OK; k++) {
		l->X[k][0] = l->x[k][0] - way[3 * k], l->X[k][1] = l->x[k][1] - way[3 * k + 1];
		l->spacing[k] = sqrt(volume[k] / (mat2_determinant(F + 4 * (size_t)k) * thickness));
		l->body[k] = (int)body[k];
	}
	free(way), free(F), free(volume), free(body);
	return status;
}

static int load_from(hid_t file, struct loaded *l, const char *path)
{
	hsize_t rows, columns;
	double thickness, *x = NULL;
	if (!h5_has(file, "points/damage"))
		return error_set(STATUS_INPUT, "%s: its points have no damage, expected a run with a law that breaks", path);
	CHECK(h5_size(file, "points/damage", &rows, &columns, path));
	CHECK(h5_read_number(file, "time", &l->time, path));
	CHECK(h5_read_number(file, "thickness", &thickness, path));
	int n = (int)rows;
	l->points.n = n;
	CHECK(read_field(file, "damage", n, 1, &l->damage, path));
	CHECK(read_field(file, "mass", n, 1, &l->mass, path));
	CHECK(read_field(file, "position", n, 2, &x, path));
	l->x = (double(*)[2])x;
	l->X = malloc(((size_t)n + 1) * sizeof *l->X);
	l->spacing = malloc(((size_t)n + 1) * sizeof *l->spacing);
	l->body = malloc(((size_t)n + 1) * sizeof *l->body);
	if (!l->X || !l->spacing || !l->body)
		return error_set(STATUS_RESOURCE, "out of memory for %d points", n);
	CHECK(derive(file, l, thickness, path));
	l->points = (struct fragment_points){.n = n,
										 .X = (const double(*)[2])l->X,
										 .x = (const double(*)[2])l->x,
										 .damage = l->damage,
										 .spacing = l->spacing,
										 .mass = l->mass,
										 .body = l->body};
	return STATUS_OK;
}

static int load(struct loaded *l, const char *path)
{
	hid_t file;
	*l = (struct loaded){0};
	CHECK(h5_open(&file, path));
	int status = load_from(file, l, path);
	H5Fclose(file);
	if (status != STATUS_OK)
		loaded_free(l);
	return status;
}

/* ---- what is written ---- */

static int write_pieces(const char *folder, const struct fragments *f)
{
	char path[FILE_PATH];
	struct csv_writer *csv;
	static const char *const names[][2] = {{"piece", "-"},    {"body", "-"},     {"points", "-"},
										   {"area", "m2"},    {"mass", "kg"},    {"centre_x", "m"},
										   {"centre_y", "m"}, {"diameter", "m"}, {"roundness", "-"}};
	CHECK(file_join(path, folder, "pieces.csv"));
	CHECK(csv_create(&csv, path));
	for (size_t k = 0; k < sizeof names / sizeof *names; k++)
		csv_name(csv, names[k][0], names[k][1]);
	int status = csv_end_row(csv);
	for (int k = 0; k < f->count && status == STATUS_OK; k++) {
		const struct fragment *p = &f->list[k];
		csv_integer(csv, k), csv_integer(csv, p->body), csv_integer(csv, p->points);
		csv_number(csv, p->area), csv_number(csv, p->mass), csv_number(csv, p->centre[0]),
			csv_number(csv, p->centre[1]);
		csv_number(csv, p->diameter), csv_number(csv, p->roundness);
		status = csv_end_row(csv);
	}
	if (status == STATUS_OK)
		return csv_close(csv);
	csv_abandon(csv);
	return status;
}

/* From the smallest piece up. */
static int write_distribution(const char *folder, const struct fragments *f)
{
	char path[FILE_PATH];
	struct csv_writer *csv;
	double area = 0.0, sum = 0.0;
	for (int k = 0; k < f->count; k++)
		area += f->list[k].area;
	CHECK(file_join(path, folder, "distribution.csv"));
	CHECK(csv_create(&csv, path));
	csv_name(csv, "diameter", "m"), csv_name(csv, "share_of_pieces", "-"), csv_name(csv, "share_of_area", "-");
	int status = csv_end_row(csv);
	for (int k = f->count - 1; k >= 0 && status == STATUS_OK; k--) {
		sum += f->list[k].area;
		csv_number(csv, f->list[k].diameter), csv_number(csv, (double)(f->count - k) / f->count);
		csv_number(csv, sum / area);
		status = csv_end_row(csv);
	}
	if (status == STATUS_OK)
		return csv_close(csv);
	csv_abandon(csv);
	return status;
}

static int write_lines(const char *folder, const struct loaded *l)
{
	char path[FILE_PATH];
	double(*nodes)[2];
	int n_nodes, (*segments)[2], n;
	int64_t bytes;
	struct frame_builder *builder = frame_builder_create();
	int status = fragments_lines(&l->points, &nodes, &n_nodes, &segments, &n);
	if (status == STATUS_OK && builder) {
		frame_begin(builder, 0, l->time, "cracks", "K");
		frame_channel_add(builder, "cracks", FRAME_SEGMENTS, 2 * (int64_t)n, n);
		double *x = frame_array_add(builder, "coordinates", "m", FRAME_GEOMETRY, FRAME_F64, 3, 2 * (int64_t)n);
		for (int s = 0; s < n && x; s++)
			for (int e = 0; e < 2; e++)
				for (int c = 0; c < 2; c++)
					x[6 * s + 3 * e + c] = nodes[segments[s][e]][c];
	}
	const void *frame = status == STATUS_OK && builder ? frame_finish(builder, &bytes) : NULL;
	if (status == STATUS_OK && !frame)
		status = error_set(STATUS_RESOURCE, "out of memory for the lines of cracks");
	if (status == STATUS_OK && (status = file_join(path, folder, "cracks.vtp")) == STATUS_OK)
		status = vtk_write(path, frame, 0);
	free(nodes), free(segments);
	frame_builder_free(builder);
	return status;
}

static int write_state(const char *folder, const char *snapshot)
{
	struct loaded l;
	struct fragments f;
	CHECK(load(&l, snapshot));
	int status = fragments_find(&f, &l.points);
	if (status == STATUS_OK) {
		struct fragment_summary s = fragments_summary(&f);
		printf("t = %.6g s: %d piece%s, mean diameter %.4g m (deviation %.4g m), roundness %.3f, broken %.4g m2\n",
			   l.time, s.count, s.count == 1 ? "" : "s", s.diameter_mean, s.diameter_deviation, s.roundness_mean,
			   s.broken);
		status = write_pieces(folder, &f);
		if (status == STATUS_OK)
			status = write_distribution(folder, &f);
		if (status == STATUS_OK)
			status = write_lines(folder, &l);
		fragments_free(&f);
	}
	loaded_free(&l);
	return status;
}

/* ---- all snapshots ---- */

static int by_name(const void *a, const void *b) { return strcmp(*(char *const *)a, *(char *const *)b); }

/* Paths of the snapshots in order; free every one and the list. */
static int list_snapshots(const char *folder, char ***list, int *n)
{
	char below[FILE_PATH], path[FILE_PATH];
	int capacity = 0, status = file_join(below, folder, "snap");
	DIR *stream = status == STATUS_OK ? opendir(below) : NULL;
	*list = NULL, *n = 0;
	if (!stream)
		return error_set(STATUS_INPUT, "cannot read %s (%s), expected the folder of a run", below, strerror(errno));
	for (struct dirent *entry; status == STATUS_OK && (entry = readdir(stream));) {
		if (entry->d_name[0] == '.' || !file_has_end(entry->d_name, ".h5"))
			continue;
		if (*n == capacity) {
			capacity = 2 * capacity + 16;
			char **grown = realloc(*list, (size_t)capacity * sizeof *grown);
			status = grown ? status : error_set(STATUS_RESOURCE, "out of memory");
			*list = grown ? grown : *list;
		}
		if (status == STATUS_OK && (status = file_join(path, below, entry->d_name)) == STATUS_OK &&
			!((*list)[(*n)++] = strdup(path)))
			status = error_set(STATUS_RESOURCE, "out of memory");
	}
	closedir(stream);
	if (status == STATUS_OK && *n == 0)
		return error_set(STATUS_INPUT, "%s holds no snapshot, expected a run with output.snapshot_every > 0", below);
	if (status == STATUS_OK)
		qsort(*list, (size_t)*n, sizeof **list, by_name);
	return status;
}

static int series_row(struct csv_writer *csv, const char *snapshot, double *time)
{
	struct loaded l;
	struct fragments f;
	CHECK(load(&l, snapshot));
	*time = l.time;
	int status = fragments_find(&f, &l.points);
	loaded_free(&l);
	CHECK(status);
	struct fragment_summary s = fragments_summary(&f);
	fragments_free(&f);
	csv_number(csv, *time), csv_integer(csv, s.count), csv_number(csv, s.diameter_mean);
	csv_number(csv, s.diameter_deviation), csv_number(csv, s.roundness_mean), csv_number(csv, s.largest);
	csv_number(csv, s.broken), csv_number(csv, s.area_mean), csv_number(csv, s.area_deviation);
	return csv_end_row(csv);
}

/* series.csv; *nearest = the snapshot nearest to the wanted time (NAN = the last). */
static int write_series(const char *folder, char **list, int n, double wanted, int *nearest)
{
	char path[FILE_PATH];
	struct csv_writer *csv;
	double least = INFINITY;
	CHECK(file_join(path, folder, "series.csv"));
	CHECK(csv_create(&csv, path));
	csv_name(csv, "time", "s"), csv_name(csv, "count", "-"), csv_name(csv, "diameter_mean", "m");
	csv_name(csv, "diameter_deviation", "m"), csv_name(csv, "roundness", "-"), csv_name(csv, "largest", "m2");
	csv_name(csv, "broken", "m2"), csv_name(csv, "diameter_mean_by_area", "m");
	csv_name(csv, "diameter_deviation_by_area", "m");
	int status = csv_end_row(csv);
	*nearest = n - 1;
	for (int k = 0; k < n && status == STATUS_OK; k++) {
		double time;
		if ((status = series_row(csv, list[k], &time)) == STATUS_OK && fabs(time - wanted) < least)
			least = fabs(time - wanted), *nearest = k;
	}
	if (status == STATUS_OK)
		return csv_close(csv);
	csv_abandon(csv);
	return status;
}

static int run(const char *folder, const char *out, double time)
{
	char **list;
	int n, nearest, status = list_snapshots(folder, &list, &n);
	if (status == STATUS_OK)
		status = file_make_folder(out);
	if (status == STATUS_OK)
		status = write_series(out, list, n, time, &nearest);
	if (status == STATUS_OK)
		status = write_state(out, list[nearest]);
	if (status == STATUS_OK)
		printf("%s/ pieces.csv distribution.csv series.csv cracks.vtp\n", out);
	for (int k = 0; k < n; k++)
		free(list[k]);
	free(list);
	return status;
}

int cli_fragments(int argc, char **argv)
{
	static const struct option options[] = {{"time", required_argument, NULL, 't'},
											{"out", required_argument, NULL, 'o'},
											{"help", no_argument, NULL, 'h'},
											{NULL, 0, NULL, 0}};
	double time = NAN;
	const char *out = NULL;
	optind = 1;
	for (int c; (c = getopt_long(argc, argv, ":", options, NULL)) != -1;) {
		char *end = "";
		if (c == 'h')
			return fputs(help, stdout), STATUS_OK;
		if (c == 't')
			time = strtod(optarg, &end);
		else if (c == 'o')
			out = optarg;
		else
			return error_set(STATUS_INPUT, "fragments: what is `%s`? (see --help)", argv[optind - 1]);
		if (*end || (c == 't' && !isfinite(time)))
			return error_set(STATUS_INPUT, "fragments: --time %s: expected seconds", optarg);
	}
	if (optind + 1 != argc)
		return error_set(STATUS_INPUT, "fragments: expected one RUN_FOLDER or run.h5 (see --help)");
	char folder[FILE_PATH], beside[FILE_PATH];
	snprintf(folder, sizeof folder, "%s", argv[optind]);
	if (file_has_end(folder, ".h5")) {
		char *slash = strrchr(folder, '/');
		*(slash ? slash : folder) = '\0';
		if (!slash)
			snprintf(folder, sizeof folder, ".");
	}
	CHECK(file_join(beside, folder, "fragments"));
	return run(folder, out ? out : beside, time);
}
