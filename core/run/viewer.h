/* The engine's end of the frame interface: builds frames, starts and feeds tmdempm-viewer. */
#ifndef TMDEMPM_RUN_VIEWER_H
#define TMDEMPM_RUN_VIEWER_H

#include <stdint.h>

#include "run/frame.h"

/* ---- building a frame in memory (reading one: frame.h) ---- */

struct frame_builder; /* grows as needed; reusable */

/* NULL on lack of memory, here and in every call below; the builder stays valid and frame_finish() fails too. */
struct frame_builder *frame_builder_create(void);
void frame_builder_free(struct frame_builder *builder);
void frame_begin(struct frame_builder *builder, int64_t step, double time, const char *title, const char *temperature_unit);

/* Adds a channel (enum frame_kind); the pointer is valid until the next frame_channel_add. */
struct frame_channel *frame_channel_add(struct frame_builder *builder, const char *name, int kind, int64_t n_points,
					int64_t n_cells);

/* Adds an array to the last channel; the pointer (components * count values, zeroed, 64-byte aligned) is valid
 * until the next frame_array_add. */
void *frame_array_add(struct frame_builder *builder, const char *name, const char *unit, int location, int type,
		      int components, int64_t count);

/* Lays the frame out as in a slot; returns it (valid until the next frame_begin) and its size. */
const void *frame_finish(struct frame_builder *builder, int64_t *bytes);

/* ---- the viewer process ----
 *
 * All calls come from one thread, and from the one that lives as long as the process (the main thread): the
 * kernel ends the viewer when the thread that started it ends. */

struct viewer;

/* Starts tmdempm-viewer (viewer_program()) for these images and waits until it is ready.  Its output goes to
 * `log_path` (appended; NULL = our standard error).  STATUS_RESOURCE with the cure when it is not built or does
 * not start. */
int viewer_start(struct viewer **viewer, int n_images, const struct frame_image *images, const char *log_path);

/* Copies the frame into a free slot and asks for image number `image` at `path` (written under a temporary
 * name and renamed by the viewer, while the caller goes on).  Waits for a free slot up to the time-out; images
 * are never dropped.  A viewer that died or hangs is restarted once for each kind of failure, with what it had
 * still to draw; then STATUS_RESOURCE, now and in later calls (the caller warns once and goes on without). */
int viewer_draw(struct viewer *viewer, const void *frame, int64_t bytes, int image, const char *path);

/* Waits until everything asked for is drawn (or failed); the same failures as viewer_draw(). */
int viewer_flush(struct viewer *viewer);

/* What went wrong since the last call and the run's log should say (restart, picture that failed), one line
 * each; NULL = nothing.  Valid until the next call. */
const char *viewer_notice(struct viewer *viewer);

/* Seconds without any answer after which a viewer counts as hung; 60. */
void viewer_set_timeout(struct viewer *viewer, double seconds);

/* Seconds that the engine has waited for the viewer so far. */
double viewer_waited(const struct viewer *viewer);

/* The viewer's process id; 0 if none runs. */
int viewer_pid(const struct viewer *viewer);

/* Waits for outstanding pictures, ends the viewer and frees `viewer` (NULL is allowed).  Returns the number of
 * pictures that were asked for and not made. */
int viewer_finish(struct viewer *viewer);

/* The viewer's executable: $TMDEMPM_VIEWER, or tmdempm-viewer beside this program (or in ../bin); NULL if none. */
const char *viewer_program(void);

#endif
