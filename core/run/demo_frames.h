/* Made-up frames that look like those of a run, for the bench and the tests of the viewer: no simulation is
 * behind them. */
#ifndef TMDEMPM_RUN_DEMO_FRAMES_H
#define TMDEMPM_RUN_DEMO_FRAMES_H

#include <stdint.h>

struct frame_builder;

/* A hopper with walls and ground, and about n material points flowing out of it (channels points, domains,
 * walls; fields temperature and stress).  NULL on lack of memory. */
const void *demo_frame_silo(struct frame_builder *builder, int n, double time, int64_t *bytes);

/* n discs (relaxed until they touch at a solid fraction of 0.86) in the cell of aspect ratio `stretch` and shear
 * `shear`, with their contacts; `bonds`: some contacts are bonded.  Channels rve_A_discs, rve_A_contacts. */
const void *demo_frame_rve(struct frame_builder *builder, int n, double stretch, double shear, int bonds, int64_t *bytes);

#endif
