/* Builds a frame in memory.  Arrays' data grow in one block while the tables of channels and arrays are still
 * open; frame_finish() puts header, tables and data behind each other. */
#include <stdlib.h>
#include <string.h>

#include "run/frame.h"
#include "run/viewer.h"

enum { ALIGN = 64 };

struct block {
	unsigned char *data; /* ALIGN-byte aligned */
	size_t size, capacity;
};

struct frame_builder {
	struct frame_header header;
	struct block channels, arrays, data, frame;
	int failed; /* out of memory since frame_begin() */
};

static int64_t align_up(int64_t bytes) { return (bytes + ALIGN - 1) / ALIGN * ALIGN; }

/* Grows a block by `bytes` zeroed bytes and returns where they begin; NULL on lack of memory. */
static void *block_grow(struct block *block, size_t bytes)
{
	if (bytes > SIZE_MAX / 32 - block->size) /* more than any machine has; no overflow below */
		return NULL;
	if (!block->data || block->size + bytes > block->capacity) {
		size_t capacity = (size_t)align_up((int64_t)(block->size + bytes + block->capacity / 2 + 1));
		unsigned char *data = aligned_alloc(ALIGN, capacity);
		if (!data)
			return NULL;
		if (block->size)
			memcpy(data, block->data, block->size);
		free(block->data);
		block->data = data;
		block->capacity = capacity;
	}
	unsigned char *start = block->data + block->size;
	memset(start, 0, bytes);
	block->size += bytes;
	return start;
}

/* Copies a name, cut to the size of its field and always terminated. */
static void name_copy(char *to, size_t size, const char *from)
{
	size_t n = strnlen(from, size - 1);
	memcpy(to, from, n);
	to[n] = '\0';
}

struct frame_builder *frame_builder_create(void) { return calloc(1, sizeof(struct frame_builder)); }

void frame_builder_free(struct frame_builder *builder)
{
	if (!builder)
		return;
	free(builder->channels.data);
	free(builder->arrays.data);
	free(builder->data.data);
	free(builder->frame.data);
	free(builder);
}

void frame_begin(struct frame_builder *builder, int64_t step, double time, const char *title,
				 const char *temperature_unit)
{
	builder->header = (struct frame_header){.magic = FRAME_MAGIC, .version = FRAME_VERSION, .step = step, .time = time};
	name_copy(builder->header.title, sizeof builder->header.title, title);
	name_copy(builder->header.temperature_unit, sizeof builder->header.temperature_unit, temperature_unit);
	builder->channels.size = builder->arrays.size = builder->data.size = builder->frame.size = 0;
	builder->failed = 0;
}

struct frame_channel *frame_channel_add(struct frame_builder *builder, const char *name, int kind, int64_t n_points,
										int64_t n_cells)
{
	struct frame_channel *channel = block_grow(&builder->channels, sizeof *channel);
	if (!channel) {
		builder->failed = 1;
		return NULL;
	}
	name_copy(channel->name, sizeof channel->name, name);
	channel->kind = kind;
	channel->n_points = n_points;
	channel->n_cells = n_cells;
	builder->header.n_channels++;
	return channel;
}

void *frame_array_add(struct frame_builder *builder, const char *name, const char *unit, int location, int type,
					  int components, int64_t count)
{
	int64_t bytes = frame_type_bytes(type) * (int64_t)components * count;
	int64_t offset = (int64_t)builder->data.size; /* of the data block; frame_finish() adds where that begins */
	struct frame_array *array = block_grow(&builder->arrays, sizeof *array);
	void *data = array ? block_grow(&builder->data, (size_t)align_up(bytes)) : NULL;
	if (!data) {
		if (array)
			builder->arrays.size -= sizeof *array;
		builder->failed = 1;
		return NULL;
	}
	name_copy(array->name, sizeof array->name, name);
	name_copy(array->unit, sizeof array->unit, unit);
	array->channel = builder->header.n_channels - 1;
	array->location = location;
	array->type = type;
	array->components = components;
	array->count = count;
	array->offset = offset;
	builder->header.n_arrays++;
	return data;
}

const void *frame_finish(struct frame_builder *builder, int64_t *bytes)
{
	if (builder->failed)
		return NULL;
	size_t tables = sizeof(struct frame_header) + builder->channels.size + builder->arrays.size;
	int64_t start = align_up((int64_t)tables);
	builder->frame.size = 0;
	unsigned char *frame = block_grow(&builder->frame, (size_t)start + builder->data.size);
	if (!frame)
		return NULL;

	struct frame_array *arrays = (struct frame_array *)builder->arrays.data;
	builder->header.bytes = start + (int64_t)builder->data.size;
	memcpy(frame, &builder->header, sizeof builder->header);
	if (builder->channels.size)
		memcpy(frame + sizeof builder->header, builder->channels.data, builder->channels.size);
	if (builder->arrays.size)
		memcpy(frame + sizeof builder->header + builder->channels.size, arrays, builder->arrays.size);
	if (builder->data.size)
		memcpy(frame + start, builder->data.data, builder->data.size);
	struct frame_array *placed = (struct frame_array *)(frame + sizeof builder->header + builder->channels.size);
	for (int a = 0; a < builder->header.n_arrays; a++)
		placed[a].offset += start;
	*bytes = builder->header.bytes;
	return frame;
}
