/* The engine's end of the frame interface: builds frames, starts and feeds tmdempm-viewer. */
#ifndef TMDEMPM_RUN_VIEWER_H
#define TMDEMPM_RUN_VIEWER_H

#include <stdbool.h>
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
 * One process for each purpose: pictures, scripts (ParaView Catalyst pipelines), a live connection; so that what hangs
 * in one delays no other.
 *
 * All calls come from one thread, and from the one that lives as long as the process (the main thread): the
 * kernel ends the viewer when the thread that started it ends. */

struct viewer;

/* Starts tmdempm-viewer (viewer_program()) for these images and waits until it is ready.  Its output goes to
 * `log_path` (appended; NULL = our standard error).  STATUS_RESOURCE with the cure when it is not built or does
 * not start. */
int viewer_start(struct viewer **viewer, int n_images, const struct frame_image *images, const char *log_path);

/* The same for Catalyst pipelines (Python), which work in `folder`. */
int viewer_start_scripts(struct viewer **viewer, int n_scripts, const char *const *scripts, const char *folder,
						 const char *log_path);

/* The same for a ParaView that listens at host:port, now or later, and comes and goes as it likes. */
int viewer_start_live(struct viewer **viewer, const char *host, int port, const char *log_path);

/* Who hears of what the viewer says by itself (FRAME_MSG_NOTE, _LINK, _STEER): called from within the calls below. */
void viewer_listen(struct viewer *viewer, void (*hear)(void *data, const struct frame_message *message), void *data);

/* Copies the frame into a free slot and asks for image number `image` at `path` (written under a temporary
 * name and renamed by the viewer, while the caller goes on).  Waits for a free slot up to the time-out; images
 * are never dropped.  A viewer that died or hangs is restarted once for each kind of failure, with what it had
 * still to draw; then STATUS_RESOURCE, now and in later calls (the caller warns once and goes on without). */
int viewer_draw(struct viewer *viewer, const void *frame, int64_t bytes, int image, const char *path);

/* The same for scripts: hands them a frame; `last` = none follows. */
int viewer_give(struct viewer *viewer, const void *frame, int64_t bytes, bool last);

/* Would a frame be taken now?  Never waits.  False also while a viewer starts. */
bool viewer_idle(struct viewer *viewer);

/* Hands a frame to an idle live viewer.  Never waits; a viewer that died is restarted as above, in the background. */
int viewer_offer(struct viewer *viewer, const void *frame, int64_t bytes, bool last);

/* Takes what the viewer has said; never waits.  STATUS_RESOURCE when it is gone for good. */
int viewer_poll(struct viewer *viewer);

/* A descriptor that becomes readable when viewer_poll() has something to take; -1 = none. */
int viewer_descriptor(const struct viewer *viewer);

/* A viewer that has done good work earns another chance for each kind of failure. */
void viewer_forgive(struct viewer *viewer);

/* Waits until everything asked for is done (or failed); the same failures as viewer_draw(). */
int viewer_flush(struct viewer *viewer);

/* What went wrong since the last call and the run's log should say (restart, picture that failed), one line
 * each; NULL = nothing.  Valid until the next call. */
const char *viewer_notice(struct viewer *viewer);

/* Seconds without any answer after which a viewer counts as hung; 60. */
void viewer_set_timeout(struct viewer *viewer, double seconds);

/* Seconds that the engine has waited for the viewer so far. */
double viewer_waited(const struct viewer *viewer);

/* Processor time that the viewers of this purpose have taken since they were ready, s. */
double viewer_cpu(struct viewer *viewer);

bool viewer_is_live(const struct viewer *viewer);

/* The viewer's process id; 0 if none runs. */
int viewer_pid(const struct viewer *viewer);

/* Waits for what is outstanding (of a live viewer: two seconds at most), ends the viewer and frees `viewer` (NULL is
 * allowed).  Returns the number of pictures (frames) that were asked for and not made. */
int viewer_finish(struct viewer *viewer);

/* The viewer's executable: $TMDEMPM_VIEWER, or tmdempm-viewer beside this program (or in ../bin); NULL if none. */
const char *viewer_program(void);

/* Does it have its module for scripts and live connections, tmdempm-catalyst.so beside it? */
bool viewer_has_catalyst(void);

#endif
