/* The frame: what the engine hands to its viewers, and how.
 *
 * Viewers live in another process (tmdempm-viewer).  The engine starts it with two inherited descriptors:
 * an anonymous memory file (memfd) that holds a ring of slots, and a SOCK_SEQPACKET socket for short
 * messages.  Nothing has a name in the system, so nothing outlives the two processes.
 *
 * A slot holds one frame: struct frame_header, n_channels struct frame_channel, n_arrays struct
 * frame_array, then the arrays' data at their offsets (64-byte aligned), so that a reader can wrap them
 * without a copy.  Both sides are built together: the structs are the format (FRAME_VERSION guards it). */
#ifndef TMDEMPM_RUN_FRAME_H
#define TMDEMPM_RUN_FRAME_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { FRAME_NAME = 64, FRAME_UNIT = 16, FRAME_VERSION = 2, FRAME_MAGIC = 0x50444d54 };

enum frame_type { FRAME_F64 = 1, FRAME_F32, FRAME_I32, FRAME_I64, FRAME_U8 };
enum frame_location { FRAME_POINT = 0, FRAME_CELL = 1, FRAME_GEOMETRY = 2 };
enum frame_kind {
	FRAME_VERTICES = 1, /* one vertex for each point */
	FRAME_QUADS,        /* 4 consecutive points make a quad */
	FRAME_SEGMENTS,     /* 2 consecutive points make a line */
	FRAME_POLYLINES,    /* array "offsets" (I32, cells + 1) cuts the points into lines */
	FRAME_IMAGE         /* regular grid of nodes: dims, origin, spacing */
};

struct frame_array {
	char name[FRAME_NAME];
	char unit[FRAME_UNIT];
	int32_t channel;    /* index */
	int32_t location;   /* enum frame_location; geometry: "coordinates" (F64, 3), "offsets" */
	int32_t type;       /* enum frame_type */
	int32_t components; /* 1, 3, 6 (xx yy zz xy yz xz) */
	int64_t count;      /* tuples */
	int64_t offset;     /* bytes from the start of the slot */
};

/* What is known of an RVE as a whole, beside its discs and contacts. */
enum frame_rve_flag { FRAME_RVE_FLYING = 1, FRAME_RVE_FROZEN = 2, FRAME_RVE_BIRTH = 4 };
struct frame_rve {
	double time;        /* s, of this RVE */
	int64_t point;      /* id; -1: it belongs to no point (a packing, an RVE driven alone) */
	double stress[4];   /* Pa, xx yy zz xy, tension positive */
	double strain[4];   /* Hencky strain ln U, xx yy zz xy */
	double fabric[3];   /* mean n n of the contact normals, xx yy xy; 0 without contacts */
	double void_ratio, coordination;
	double temperature; /* in the frame's unit; NAN = unknown */
	int32_t bonds_installed, bonds_intact;
	int32_t flags;      /* enum frame_rve_flag */
	int32_t pad;
	char rule[32];      /* that chose the point ("hottest"); "" = it is a fixed one */
};

struct frame_channel {
	char name[FRAME_NAME]; /* points, domains, grid, walls, rve_NAME_discs, rve_NAME_contacts */
	int32_t kind;          /* enum frame_kind */
	int32_t pad;
	int64_t n_points, n_cells;
	int32_t dims[2];       /* FRAME_IMAGE: nodes in x and y */
	double origin[2], spacing[2]; /* m */
	double cell_matrix[4]; /* RVE channels: H, columns are the lattice vectors, m; else 0 */
	char note[256];        /* RVE channels: "p = 9.8 kPa, e = 0.243 ..." ; else "" */
	struct frame_rve rve;  /* RVE channels; else 0 */
};

struct frame_header {
	uint32_t magic, version;
	int64_t step;
	double time; /* s */
	int64_t bytes; /* of the frame */
	int32_t n_channels, n_arrays;
	char temperature_unit[4]; /* "C" or "K": temperature arrays are in it already */
	char title[256];
};

/* One picture that a scene asks for; sent once, when the viewer starts. */
struct frame_image {
	char name[FRAME_NAME];
	int32_t kind;          /* 0 points (domains, walls, grid), 1 RVE */
	char field[FRAME_NAME];
	int32_t component;     /* -1 magnitude or scalar */
	char rve[FRAME_NAME];
	char before[FRAME_NAME]; /* an RVE that is drawn on its left, as it was before; "" = none */
	double view[4];        /* m: xmin ymin xmax ymax; NAN = all there is (channel "grid" if sent) */
	int32_t size[2];       /* pixels */
	char map[FRAME_NAME];  /* viridis, inferno, coolwarm (diverging: an automatic range is symmetric, but of temperatures) */
	char unit[FRAME_UNIT]; /* shown unit; "" = the array's, with an SI prefix that suits the numbers */
	int32_t range_auto;    /* 1: from the data of each picture */
	double range[2];       /* in `unit`, or in the array's unit where that is "" */
};

/* The descriptors that the viewer inherits, beside 0, 1, 2 (log). */
enum { FRAME_FD_SOCKET = 3, FRAME_FD_MEMORY = 4 };

/* Messages, one packet each.  The first says what this viewer process is for:
 * IMAGES (then n packets of struct frame_image), SCRIPTS (then n packets SCRIPT: ParaView Catalyst pipelines) or LIVE
 * (a ParaView that watches).  The viewer answers READY, or FAILED with slot -1: it cannot work and ends.
 *
 * Then the engine sends DRAW (a picture) or FRAME (scripts and live) for a slot that it has filled, and QUIT at the end.
 * The viewer answers DONE or FAILED (text): the slot is free again; or KEPT: the frame has been dealt with, but VTK still
 * refers to the slot, which a later DONE frees.  What else it has to say:
 * NOTE for the run's log, LINK when a live client has come (n = 1) or gone (n = 0), STEER with a command of that client
 * ("pause=1"). */
enum frame_message_kind {
	FRAME_MSG_IMAGES = 1, FRAME_MSG_DRAW, FRAME_MSG_QUIT, FRAME_MSG_SCRIPTS, FRAME_MSG_SCRIPT, FRAME_MSG_LIVE,
	FRAME_MSG_FRAME,
	FRAME_MSG_READY = 100, FRAME_MSG_DONE, FRAME_MSG_FAILED, FRAME_MSG_KEPT, FRAME_MSG_NOTE, FRAME_MSG_LINK,
	FRAME_MSG_STEER
};

enum { FRAME_TEXT = 1024 };

struct frame_message {
	int32_t kind;
	int32_t slot;           /* DRAW, FRAME, DONE, KEPT, FAILED */
	int64_t offset, bytes;  /* DRAW, FRAME: where in the memory file the slot lies */
	int32_t image;          /* DRAW: index into the images */
	int32_t n;              /* IMAGES, SCRIPTS: how many; LIVE: the port; LINK; FRAME: 1 = the last of the run */
	char text[FRAME_TEXT];  /* DRAW: path of the PNG; SCRIPTS: folder to work in; SCRIPT: its path; LIVE: host; else words */
};

/* ---- reading a frame ---- */

static inline const struct frame_header *frame_header(const void *frame) { return (const struct frame_header *)frame; }

static inline const struct frame_channel *frame_channels(const void *frame)
{
	return (const struct frame_channel *)((const char *)frame + sizeof(struct frame_header));
}

static inline const struct frame_array *frame_arrays(const void *frame)
{
	return (const struct frame_array *)(frame_channels(frame) + frame_header(frame)->n_channels);
}

/* Index of a channel, or -1. */
static inline int frame_find_channel(const void *frame, const char *name)
{
	for (int c = 0; c < frame_header(frame)->n_channels; c++)
		if (strncmp(frame_channels(frame)[c].name, name, FRAME_NAME) == 0)
			return c;
	return -1;
}

/* An array of a channel, or NULL (also for channel -1). */
static inline const struct frame_array *frame_find_array(const void *frame, int channel, const char *name)
{
	for (int a = 0; a < frame_header(frame)->n_arrays; a++)
		if (frame_arrays(frame)[a].channel == channel && strncmp(frame_arrays(frame)[a].name, name, FRAME_NAME) == 0)
			return &frame_arrays(frame)[a];
	return NULL;
}

static inline const void *frame_data(const void *frame, const struct frame_array *array)
{
	return (const char *)frame + array->offset;
}

/* Bytes of one value; 0 for an unknown type. */
static inline int frame_type_bytes(int type)
{
	return type == FRAME_F64 || type == FRAME_I64 ? 8 : type == FRAME_F32 || type == FRAME_I32 ? 4 : type == FRAME_U8;
}

#ifdef __cplusplus
}
#endif
#endif
