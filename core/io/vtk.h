/* VTK's XML files, binary (inline base64), from a channel of a frame: what ParaView opens.
 *
 * One writer for every kind of channel: vertices, quads, segments and polylines become .vtp, images .vti. */
#ifndef TMDEMPM_IO_VTK_H
#define TMDEMPM_IO_VTK_H

/* "vtp" or "vti" for an enum frame_kind. */
const char *vtk_file_end(int kind);

/* Writes channel number `channel` of a laid-out frame (run/frame.h) to `path`, whole or not at all. */
int vtk_write(const char *path, const void *frame, int channel);

#endif
