#include "io/vtk.h"

#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "io/file.h"
#include "run/frame.h"

struct vtk_file {
	FILE *stream;
	const unsigned char *frame;
	const struct frame_channel *channel;
	int number;        /* of the channel */
	int64_t *cells[2]; /* connectivity, offsets */
};

static const struct frame_array *vtk_arrays(const void *frame)
{
	const struct frame_header *header = frame;
	return (const void *)((const struct frame_channel *)(header + 1) + header->n_channels);
}

const char *vtk_file_end(int kind) { return kind == FRAME_IMAGE ? "vti" : "vtp"; }

static const char *vtk_type(int type)
{
	switch (type) {
	case FRAME_F32:
		return "Float32";
	case FRAME_I32:
		return "Int32";
	case FRAME_I64:
		return "Int64";
	case FRAME_U8:
		return "UInt8";
	default:
		return "Float64";
	}
}

static uint64_t vtk_type_bytes(int type)
{
	return type == FRAME_U8 ? 1 : type == FRAME_F32 || type == FRAME_I32 ? 4 : 8;
}

/* Bytes as base64, the only binary form that is text.  Appended raw data would be smaller, but Expat since its
 * security fixes of 2024 (deferred parsing) hands it to VTK's parser as XML, and VTK up to 9.2 refuses the file. */
struct vtk_base64 {
	FILE *stream;
	unsigned char pending[3];
	int n;
};

static void base64_flush(struct vtk_base64 *out)
{
	static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
	const unsigned char *b = out->pending;
	if (out->n == 0)
		return;
	const char quad[4] = {digits[b[0] >> 2], digits[(b[0] & 3) << 4 | b[1] >> 4],
						  out->n > 1 ? digits[(b[1] & 15) << 2 | b[2] >> 6] : '=',
						  out->n > 2 ? digits[b[2] & 63] : '='};
	fwrite(quad, 1, sizeof quad, out->stream);
	memset(out->pending, 0, sizeof out->pending);
	out->n = 0;
}

static void base64_write(struct vtk_base64 *out, const void *data, uint64_t bytes)
{
	for (uint64_t k = 0; k < bytes; k++) {
		out->pending[out->n++] = ((const unsigned char *)data)[k];
		if (out->n == 3)
			base64_flush(out);
	}
}

static void vtk_block(struct vtk_file *file, const char *name, const char *type, int components, const void *data,
					  uint64_t bytes)
{
	struct vtk_base64 out = {.stream = file->stream};
	fprintf(file->stream, "<DataArray type=\"%s\" Name=\"%s\" NumberOfComponents=\"%d\" format=\"binary\">\n", type,
			name, components);
	base64_write(&out, &bytes, sizeof bytes);
	base64_write(&out, data, bytes);
	base64_flush(&out);
	fprintf(file->stream, "\n</DataArray>\n");
}

static void vtk_array(struct vtk_file *file, const struct frame_array *array, const char *name)
{
	vtk_block(file, name, vtk_type(array->type), array->components, file->frame + array->offset,
			  vtk_type_bytes(array->type) * (uint64_t)array->components * (uint64_t)array->count);
}

/* All arrays of the channel at one location, between <tag> and </tag>. */
static void vtk_data(struct vtk_file *file, const char *tag, int location)
{
	const struct frame_header *header = (const void *)file->frame;
	const struct frame_array *arrays = vtk_arrays(file->frame);
	fprintf(file->stream, "<%s>\n", tag);
	for (int a = 0; a < header->n_arrays; a++)
		if (arrays[a].channel == file->number && arrays[a].location == location)
			vtk_array(file, &arrays[a], arrays[a].name);
	fprintf(file->stream, "</%s>\n", tag);
}

static const struct frame_array *vtk_geometry(const struct vtk_file *file, const char *name)
{
	const struct frame_header *header = (const void *)file->frame;
	const struct frame_array *arrays = vtk_arrays(file->frame);
	for (int a = 0; a < header->n_arrays; a++)
		if (arrays[a].channel == file->number && arrays[a].location == FRAME_GEOMETRY && !strcmp(arrays[a].name, name))
			return &arrays[a];
	return NULL;
}

/* Points are used in order by every kind of cell; only where one cell ends and the next begins differs. */
static int vtk_cells(struct vtk_file *file, const char *tag)
{
	int64_t n_points = file->channel->n_points, n_cells = file->channel->n_cells;
	const struct frame_array *cuts = vtk_geometry(file, "offsets");
	int per_cell = file->channel->kind == FRAME_QUADS ? 4 : file->channel->kind == FRAME_SEGMENTS ? 2 : 1;
	if (file->channel->kind == FRAME_POLYLINES && !cuts)
		return error_set(STATUS_RESOURCE, "the channel %s has no offsets", file->channel->name);
	file->cells[0] = malloc(sizeof(int64_t) * (size_t)(n_points + 1));
	file->cells[1] = malloc(sizeof(int64_t) * (size_t)(n_cells + 1));
	if (!file->cells[0] || !file->cells[1])
		return error_set(STATUS_RESOURCE, "out of memory");
	for (int64_t i = 0; i < n_points; i++)
		file->cells[0][i] = i;
	for (int64_t c = 0; c < n_cells; c++)
		file->cells[1][c] = cuts ? ((const int32_t *)(file->frame + cuts->offset))[c + 1] : per_cell * (c + 1);
	fprintf(file->stream, "<%s>\n", tag);
	vtk_block(file, "connectivity", "Int64", 1, file->cells[0], 8 * (uint64_t)n_points);
	vtk_block(file, "offsets", "Int64", 1, file->cells[1], 8 * (uint64_t)n_cells);
	fprintf(file->stream, "</%s>\n", tag);
	return STATUS_OK;
}

static int vtk_poly_data(struct vtk_file *file)
{
	const struct frame_channel *channel = file->channel;
	const struct frame_array *coordinates = vtk_geometry(file, "coordinates");
	if (!coordinates)
		return error_set(STATUS_RESOURCE, "the channel %s has no coordinates", channel->name);
	long long cells = channel->n_cells;
	bool verts = channel->kind == FRAME_VERTICES, polys = channel->kind == FRAME_QUADS;
	fprintf(file->stream,
			"<Piece NumberOfPoints=\"%lld\" NumberOfVerts=\"%lld\" NumberOfLines=\"%lld\" NumberOfStrips=\"0\" "
			"NumberOfPolys=\"%lld\">\n",
			(long long)channel->n_points, verts ? cells : 0, verts || polys ? 0 : cells, polys ? cells : 0);
	vtk_data(file, "PointData", FRAME_POINT);
	vtk_data(file, "CellData", FRAME_CELL);
	fprintf(file->stream, "<Points>\n");
	vtk_array(file, coordinates, "Points");
	fprintf(file->stream, "</Points>\n");
	CHECK(vtk_cells(file, verts ? "Verts" : polys ? "Polys" : "Lines"));
	fprintf(file->stream, "</Piece>\n");
	return STATUS_OK;
}

/* A text of VTK's ASCII form: its bytes as numbers, each text with its zero. */
static void vtk_text(struct vtk_file *file, const char *text)
{
	for (const char *at = text; *at; at++)
		fprintf(file->stream, "%d ", (unsigned char)*at);
}

/* What stands beside the arrays, named as in a live connection: time, step, units, and what is known of an RVE. */
static void vtk_field_data(struct vtk_file *file)
{
	const struct frame_header *header = (const void *)file->frame;
	const struct frame_array *arrays = vtk_arrays(file->frame);
	int n = 0;
	for (int a = 0; a < header->n_arrays; a++)
		n += arrays[a].channel == file->number && arrays[a].location != FRAME_GEOMETRY;
	fprintf(file->stream,
			"<FieldData>\n<DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">"
			"%.17g</DataArray>\n<DataArray type=\"Int64\" Name=\"step\" NumberOfTuples=\"1\" format=\"ascii\">"
			"%lld</DataArray>\n<DataArray type=\"String\" Name=\"units\" NumberOfTuples=\"%d\" format=\"ascii\">",
			header->time, (long long)header->step, n);
	for (int a = 0; a < header->n_arrays; a++)
		if (arrays[a].channel == file->number && arrays[a].location != FRAME_GEOMETRY) {
			vtk_text(file, arrays[a].name);
			vtk_text(file, "=");
			vtk_text(file, arrays[a].unit);
			fprintf(file->stream, "0 ");
		}
	fprintf(file->stream, "</DataArray>\n");
	if (file->channel->note[0]) {
		fprintf(file->stream, "<DataArray type=\"String\" Name=\"note\" NumberOfTuples=\"1\" format=\"ascii\">");
		vtk_text(file, file->channel->note);
		fprintf(file->stream, "0</DataArray>\n");
	}
	fprintf(file->stream, "</FieldData>\n");
}

static int vtk_xml(struct vtk_file *file)
{
	const struct frame_channel *channel = file->channel;
	bool image = channel->kind == FRAME_IMAGE;
	const char *type = image ? "ImageData" : "PolyData";
	fprintf(file->stream,
			"<?xml version=\"1.0\"?>\n<VTKFile type=\"%s\" version=\"1.0\" byte_order=\"LittleEndian\" "
			"header_type=\"UInt64\">\n",
			type);
	char extent[96];
	snprintf(extent, sizeof extent, "0 %d 0 %d 0 0", channel->dims[0] - 1, channel->dims[1] - 1);
	if (image)
		fprintf(file->stream, "<ImageData WholeExtent=\"%s\" Origin=\"%.17g %.17g 0\" Spacing=\"%.17g %.17g 1\">\n",
				extent, channel->origin[0], channel->origin[1], channel->spacing[0], channel->spacing[1]);
	else
		fprintf(file->stream, "<PolyData>\n");
	vtk_field_data(file);
	if (image) {
		fprintf(file->stream, "<Piece Extent=\"%s\">\n", extent);
		vtk_data(file, "PointData", FRAME_POINT);
		vtk_data(file, "CellData", FRAME_CELL);
		fprintf(file->stream, "</Piece>\n");
	} else {
		CHECK(vtk_poly_data(file));
	}
	fprintf(file->stream, "</%s>\n</VTKFile>\n", type);
	return STATUS_OK;
}

int vtk_write(const char *path, const void *frame, int channel)
{
	const struct frame_header *header = frame;
	struct vtk_file file = {
		.frame = frame, .channel = (const struct frame_channel *)(header + 1) + channel, .number = channel};
	struct file_output output;
	int status = file_output_begin(&output, path);
	if (status == STATUS_OK) {
		file.stream = output.stream;
		output.unsynced = true;
		status = vtk_xml(&file);
		if (status == STATUS_OK)
			status = file_output_commit(&output);
		else
			file_output_abandon(&output);
	}
	free(file.cells[0]);
	free(file.cells[1]);
	return status;
}
