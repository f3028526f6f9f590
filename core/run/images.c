#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "run/frame_build.h"
#include "run/run_private.h"

struct images {
	const struct mpm *mpm;
	struct sink sink;
	char folder[FILE_PATH];
	long long *every; /* steps, of each image of the scene */
	double *seconds;  /* s, the same as it was asked for */
	bool *missing;    /* its RVE is not inspected, which has been said */
	int n, capacity;
	char **files;
};

static void image_describe(struct frame_image *to, const struct scene_image *from)
{
	memset(to, 0, sizeof *to);
	snprintf(to->name, sizeof to->name, "%.63s", from->name);
	to->kind = from->kind == SCENE_IMAGE_RVE;
	snprintf(to->field, sizeof to->field, "%.63s", from->field);
	to->component = from->component;
	snprintf(to->rve, sizeof to->rve, "%.63s", from->rve);
	if (from->before)
		frame_birth_name(to->before, from->rve);
	memcpy(to->view, from->view, sizeof to->view);
	to->size[0] = from->size[0], to->size[1] = from->size[1];
	snprintf(to->map, sizeof to->map, "%.63s", from->map);
	snprintf(to->unit, sizeof to->unit, "%.15s", from->unit);
	to->range_auto = from->range_auto;
	to->range[0] = from->range[0], to->range[1] = from->range[1];
}

static int images_start(struct images *images)
{
	const struct scene *scene = images->mpm->scene;
	struct frame_image *described = calloc((size_t)scene->n_images, sizeof *described);
	if (!described)
		return error_set(STATUS_RESOURCE, "out of memory");
	for (int i = 0; i < scene->n_images; i++)
		image_describe(&described[i], &scene->images[i]);
	char path[FILE_PATH];
	int status = file_join(path, images->folder, "images");
	if (status == STATUS_OK)
		status = file_make_folder(path);
	if (status == STATUS_OK)
		status = file_join(path, images->folder, "log.txt");
	if (status == STATUS_OK)
		status = viewer_start(&images->sink.viewer, scene->n_images, described, path);
	free(described);
	return status;
}

static void image_set_every(struct images *images, int i, double seconds)
{
	images->seconds[i] = seconds;
	images->every[i] = schedule_steps(images->mpm->scene, seconds);
}

int images_set_every(struct images *images, const char *name, double seconds)
{
	const struct scene *scene = images->mpm->scene;
	char known[512] = "none";
	for (int i = 0; i < scene->n_images; i++) {
		size_t used = i ? strlen(known) : 0;
		snprintf(known + used, sizeof known - used, "%s%s", i ? ", " : "", scene->images[i].name);
		if (!strcmp(scene->images[i].name, name))
			return image_set_every(images, i, seconds), STATUS_OK;
	}
	return error_set(STATUS_INPUT, "there is no picture \"%s\", expected one of the scene's: %s", name, known);
}

double images_every(const struct images *images, int i) { return images->seconds[i]; }

int images_create(struct images **result, const struct mpm *mpm, const char *folder, struct run_log *log)
{
	*result = NULL;
	const struct scene *scene = mpm->scene;
	struct images *images = calloc(1, sizeof *images);
	if (!images)
		return error_set(STATUS_RESOURCE, "out of memory");
	size_t n = (size_t)scene->n_images + 1;
	images->every = calloc(n, sizeof *images->every);
	images->seconds = calloc(n, sizeof *images->seconds);
	images->missing = calloc(n, sizeof *images->missing);
	if (!images->every || !images->seconds || !images->missing) {
		images_free(images);
		return error_set(STATUS_RESOURCE, "out of memory");
	}
	images->mpm = mpm;
	images->sink = (struct sink){.products = "pictures", .log = log};
	snprintf(images->folder, sizeof images->folder, "%s", folder);
	for (int i = 0; i < scene->n_images; i++)
		image_set_every(images, i, scene->images[i].every);
	if (scene->n_images > 0 && images_start(images) != STATUS_OK)
		sink_absent(&images->sink);
	*result = images;
	return STATUS_OK;
}

static bool image_due(const struct images *images, int i, long long step, bool last)
{
	return schedule_due(images->every[i], step) || (last && images->every[i] > 0);
}

bool images_due(const struct images *images, long long step, bool last)
{
	for (int i = 0; images->sink.viewer && i < images->mpm->scene->n_images; i++)
		if (image_due(images, i, step, last))
			return true;
	return false;
}

static int images_remember(struct images *images, const char *file)
{
	if (images->n == images->capacity) {
		int capacity = 2 * images->capacity + 64;
		char **larger = realloc(images->files, sizeof *larger * (size_t)capacity);
		if (!larger)
			return error_set(STATUS_RESOURCE, "out of memory");
		images->files = larger, images->capacity = capacity;
	}
	images->files[images->n] = strdup(file);
	return images->files[images->n] ? (images->n++, STATUS_OK) : error_set(STATUS_RESOURCE, "out of memory");
}

/* Steering may have taken away the RVE of a picture. */
static bool image_has_subject(struct images *images, const void *frame, int i)
{
	const struct scene_image *image = &images->mpm->scene->images[i];
	char channel[FRAME_NAME];
	if (image->kind != SCENE_IMAGE_RVE)
		return true;
	snprintf(channel, sizeof channel, "rve_%.48s_discs", image->rve);
	bool there = frame_find_channel(frame, channel) >= 0;
	if (!there && !images->missing[i])
		log_warning(images->sink.log, "picture %s is not drawn: the RVE %s is not inspected (now)", image->name,
					image->rve);
	images->missing[i] = !there;
	return there;
}

static int image_draw(struct images *images, const void *frame, int64_t bytes, int i, long long step)
{
	char name[SCENE_NAME + 48], path[FILE_PATH];
	snprintf(name, sizeof name, "images/%s_%08lld.png", images->mpm->scene->images[i].name, step);
	CHECK(file_join(path, images->folder, name));
	CHECK(viewer_draw(images->sink.viewer, frame, bytes, i, path));
	return images_remember(images, name);
}

void images_draw(struct images *images, const void *frame, int64_t bytes, long long step, bool last)
{
	for (int i = 0; images->sink.viewer && i < images->mpm->scene->n_images; i++)
		if (image_due(images, i, step, last) && image_has_subject(images, frame, i) &&
			image_draw(images, frame, bytes, i, step) != STATUS_OK)
			sink_lost(&images->sink);
	sink_notices(&images->sink);
}

struct sink *images_sink(struct images *images) { return images ? &images->sink : NULL; }

int images_count(const struct images *images) { return images ? images->n : 0; }

const char *images_file(const struct images *images, int i) { return images->files[i]; }

void images_free(struct images *images)
{
	if (!images)
		return;
	sink_finish(&images->sink);
	for (int i = 0; i < images->n; i++)
		free(images->files[i]);
	free(images->files);
	free(images->every), free(images->seconds), free(images->missing);
	free(images);
}
