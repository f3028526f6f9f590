/* The part of a frame that shows the walls: channel `walls`. */
#ifndef TMDEMPM_RUN_FRAME_WALLS_H
#define TMDEMPM_RUN_FRAME_WALLS_H

#include "mpm/mpm.h"
#include "run/viewer.h"

/* Adds the outlines of the walls that stand now, where they are now, a polyline each.  Cells: `wall` (number in the
 * scene), `force` (N, of the material on it).  Points, about one for each cell of the grid along the wall:
 * `pressure` (Pa, normal to the wall, pressing) and `shear` (Pa, along the outline), which the nodes that the wall holds
 * have brought to it in the last step, each shared out between the two nearest points of its face: times length and
 * thickness they add up to `force`.  A confining pressure of the scene is not in them. */
int frame_walls_add(struct frame_builder *builder, const struct mpm *mpm);

#endif
