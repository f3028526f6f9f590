/* The engine's end of the frame interface: builds frames, starts and feeds tmdempm-viewer. */
#ifndef TMDEMPM_RUN_VIEWER_H
#define TMDEMPM_RUN_VIEWER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "run/frame.h"

/* ---- building a frame in memory ---- */

struct frame_builder; /* grows as needed; reusable */

struct frame_builder *frame_builder_create(void);
void frame_builder_free(struct frame_builder *builder);
void frame_begin(struct frame_builder *builder, int64_t step, double time, const char *title, const char *temperature_unit);
/* Adds a channel; the pointer is valid until the next frame_channel_add. */
struct frame_channel *frame_channel_add(struct frame_builder *builder, const char *name, int kind, int64_t n_points, int64_t n_cells);
/* Adds an array to the last channel; the pointer (components * count values, zeroed) is valid until the next frame_array_add. */
void *frame_array_add(struct frame_builder *builder, const char *name, const char *unit, int location, int type, int components, int64_t count);
/* Lays the frame out as in a slot; returns it and its size. NULL on lack of memory. */
const void *frame_finish(struct frame_builder *builder, int64_t *bytes);

/* ---- reading one (engine-side writers of .vtp use it too; header-only access is fine as well) ---- */
const struct frame_channel *frame_channels(const void *frame);
const struct frame_array *frame_arrays(const void *frame);
int frame_find_channel(const void *frame, const char *name); /* index or -1 */
const struct frame_array *frame_find_array(const void *frame, int channel, const char *name);

/* ---- the viewer process ---- */

struct viewer;

/* Starts tmdempm-viewer (found beside this program, or $TMDEMPM_VIEWER) for these images.
 * STATUS_RESOURCE with the cure when it is not built or does not start. */
int viewer_start(struct viewer **viewer, int n_images, const struct frame_image *images, const char *log_path);

/* Copies the frame into a free slot and asks for image number `image` at `path` (written under a temporary
 * name and renamed by the viewer).  Waits for a free slot up to a time-out; images are never dropped.
 * A viewer that died is restarted once, then STATUS_RESOURCE (the caller warns and goes on without). */
int viewer_draw(struct viewer *viewer, const void *frame, int64_t bytes, int image, const char *path);

/* Seconds that the engine has waited for the viewer so far. */
double viewer_waited(const struct viewer *viewer);

/* Waits for outstanding pictures and ends the viewer.  Returns the number of pictures that failed. */
int viewer_finish(struct viewer *viewer);

/* Is a viewer installed?  Its path, or NULL. */
const char *viewer_program(void);

#endif
