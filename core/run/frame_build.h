/* The frame of a run: what files and viewers get, from the state of the MPM and its RVEs.
 *
 * Channels (contracts of the frame): `points`, `domains`, `grid`, `walls`, and for each inspected RVE
 * `rve_NAME_discs` and `rve_NAME_contacts`. */
#ifndef TMDEMPM_RUN_FRAME_BUILD_H
#define TMDEMPM_RUN_FRAME_BUILD_H

#include "run/inspected.h"
#include "run/viewer.h"

/* Lays out the frame of the state as it is; valid until the next frame_begin() of this builder. */
int frame_build(struct frame_builder *builder, const struct mpm *mpm, struct run_fields *fields,
				const struct inspected *inspected, const void **frame, int64_t *bytes);

/* The RVE of this name as it was at birth has a channel of its own where a picture asks for it. */
void frame_birth_name(char name[FRAME_NAME], const char *rve);

/* The quad that stands for a point: 4 corners, counter-clockwise, in m.
 *
 * A square of the point's initial area deformed by F.  Points that have flowed through an outlet carry
 * an F whose ellipse is hundreds of times longer than wide; drawn as they are, such quads hide everything.
 * So for the drawing (only) the ratio of the principal stretches is limited to 2.5, keeping area and
 * direction, and the area to 0.25 .. 1.5 of the initial one (a flying point's F grows without meaning). */
void frame_domain(const double x[2], const double F[4], double side, double corners[4][2]);

#endif
