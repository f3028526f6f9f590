/* `tmdempm bench image`: what a picture costs, from the engine's frame to the renamed PNG. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "base/error.h"
#include "io/file.h"
#include "run/bench.h"
#include "run/demo_frames.h"
#include "run/log.h"
#include "run/viewer.h"

enum { REPEATS = 5, POINTS = 5000, DISCS = 400, STARTS = 3 };

static const struct frame_image bench_images[] = {
	{.name = "points",
	 .field = "temperature",
	 .component = -1,
	 .view = {0, 0, 10, 12},
	 .size = {1000, 800},
	 .map = "inferno",
	 .range = {20, 60}},
	{.name = "rve",
	 .kind = 1,
	 .field = "displacement",
	 .component = -1,
	 .rve = "A",
	 .size = {1000, 800},
	 .map = "viridis",
	 .range_auto = 1},
};
enum { N_IMAGES = sizeof bench_images / sizeof *bench_images };

/* One picture after the other, the first (which warms everything up) not counted. */
static int bench_draw(struct viewer *viewer, const void *frame, int64_t bytes, int image, const char *path,
					  double seconds[REPEATS])
{
	if (!frame)
		return error_set(STATUS_RESOURCE, "out of memory for a frame");
	for (int k = -1; k < REPEATS; k++) {
		double start = clock_seconds();
		CHECK(viewer_draw(viewer, frame, bytes, image, path));
		CHECK(viewer_flush(viewer));
		if (k >= 0)
			seconds[k] = clock_seconds() - start;
	}
	return STATUS_OK;
}

static int bench_pictures(bool json, struct viewer *viewer, const char *path)
{
	struct frame_builder *builder = frame_builder_create();
	if (!builder)
		return error_set(STATUS_RESOURCE, "out of memory for a frame");
	int64_t bytes = 0;
	double seconds[REPEATS];
	const void *frame = demo_frame_silo(builder, POINTS, 0.5, &bytes);
	int status = bench_draw(viewer, frame, bytes, 0, path, seconds);
	if (status == STATUS_OK) {
		bench_report(json, "image_1000x800", seconds, REPEATS, "s", 1);
		frame = demo_frame_rve(builder, DISCS, 1, 0, 0, &bytes);
		status = bench_draw(viewer, frame, bytes, 1, path, seconds);
	}
	if (status == STATUS_OK)
		bench_report(json, "image_rve_1000x800", seconds, REPEATS, "s", 1);
	frame_builder_free(builder);
	const char *notice = viewer_notice(viewer);
	if (status == STATUS_OK && notice)
		status = error_set(STATUS_RESOURCE, "%s", notice);
	return status;
}

/* Start and end of viewers; leaves the last one running. */
static int bench_starts(bool json, struct viewer **viewer, const char *log)
{
	double seconds[STARTS];
	for (int k = 0; k < STARTS; k++) {
		viewer_finish(*viewer);
		double start = clock_seconds();
		CHECK(viewer_start(viewer, N_IMAGES, bench_images, log));
		seconds[k] = clock_seconds() - start;
	}
	bench_report(json, "image_viewer_start", seconds, STARTS, "s", 1);
	return STATUS_OK;
}

int bench_image(bool json)
{
	char folder[FILE_PATH], path[FILE_PATH], log[FILE_PATH];
	CHECK(file_scratch_folder(folder, "bench"));
	CHECK(file_join(path, folder, "bench.png"));
	CHECK(file_join(log, folder, "viewer.log"));
	struct viewer *viewer = NULL;
	int status = bench_starts(json, &viewer, log);
	if (status == STATUS_OK)
		status = bench_pictures(json, viewer, path);
	viewer_finish(viewer);
	unlink(path);
	unlink(log);
	rmdir(folder);
	return status;
}
