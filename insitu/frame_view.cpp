#include "frame_view.h"

#include <cstring>

#include <vtkCellArray.h>
#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkIntArray.h>
#include <vtkLongLongArray.h>
#include <vtkPoints.h>
#include <vtkTypeInt64Array.h>
#include <vtkUnsignedCharArray.h>

namespace
{
bool terminated(const char *text, size_t size) { return memchr(text, '\0', size) != nullptr; }

// An array that can tell whether others use its values: VTK's arrays share them without sharing the array.
template <class array_type> class lent_array : public array_type
{
  public:
	static vtkSmartPointer<lent_array> make()
	{
		auto *array = new lent_array;
		array->InitializeObjectBase();
		return vtkSmartPointer<lent_array>::Take(array);
	}
	bool shared() { return this->GetReferenceCount() > 1 || this->Buffer->GetReferenceCount() > 1; }
};

template <class array_type, class value_type>
vtkSmartPointer<vtkDataArray> wrap(const frame_array &array, const void *data)
{
	auto wrapped = lent_array<array_type>::make();
	wrapped->SetName(array.name);
	wrapped->SetNumberOfComponents(array.components);
	// 1: VTK never frees or writes it.
	wrapped->SetArray(const_cast<value_type *>(static_cast<const value_type *>(data)), array.count * array.components,
					  1);
	return wrapped;
}

template <class array_type> bool values_shared(vtkDataArray *array)
{
	auto *lent = dynamic_cast<lent_array<array_type> *>(array);
	return lent && lent->shared();
}

// Cells of `size` consecutive points each.
vtkSmartPointer<vtkCellArray> consecutive_cells(int64_t n, int size)
{
	auto ids = vtkSmartPointer<vtkTypeInt64Array>::New();
	ids->SetNumberOfValues(n * size);
	for (int64_t k = 0; k < n * size; k++)
		ids->SetValue(k, k);
	auto cells = vtkSmartPointer<vtkCellArray>::New();
	cells->SetData(size, ids);
	return cells;
}
} // namespace

bool frame_view::open(const void *start, int64_t bytes, std::string &error)
{
	memory = start;
	error = "a frame that is cut or damaged";
	if (bytes < int64_t(sizeof(struct frame_header)))
		return false;
	const struct frame_header &h = header();
	if (h.magic != FRAME_MAGIC || h.version != FRAME_VERSION) {
		error = "a frame of another version: engine and viewer are not from the same build";
		return false;
	}
	int64_t tables = int64_t(sizeof h);
	if (h.bytes > bytes || h.n_channels < 0 || h.n_arrays < 0)
		return false;
	tables +=
		int64_t(h.n_channels) * int64_t(sizeof(frame_channel)) + int64_t(h.n_arrays) * int64_t(sizeof(frame_array));
	if (tables > h.bytes || !terminated(h.title, sizeof h.title))
		return false;
	for (int c = 0; c < h.n_channels; c++)
		if (!terminated(channel(c).name, FRAME_NAME) || !terminated(channel(c).note, sizeof channel(c).note) ||
			channel(c).kind < FRAME_VERTICES || channel(c).kind > FRAME_IMAGE)
			return false;
	for (int a = 0; a < h.n_arrays; a++) {
		const frame_array &array = frame_arrays(memory)[a];
		int64_t size = frame_type_bytes(array.type);
		if (!terminated(array.name, FRAME_NAME) || !terminated(array.unit, FRAME_UNIT) || size == 0 ||
			array.channel < 0 || array.channel >= h.n_channels || array.components < 1 || array.components > 64 ||
			array.count < 0 || array.offset < tables || array.offset > h.bytes ||
			array.count > (h.bytes - array.offset) / (size * array.components))
			return false;
	}
	error.clear();
	return true;
}

vtkSmartPointer<vtkDataArray> frame_view::array(int channel, const std::string &name) const
{
	const frame_array *found = find_array(channel, name);
	return found ? array(*found) : nullptr;
}

vtkSmartPointer<vtkDataArray> frame_view::array(const frame_array &array) const
{
	const void *data = frame_data(memory, &array);
	switch (array.type) {
	case FRAME_F64:
		return wrap<vtkDoubleArray, double>(array, data);
	case FRAME_F32:
		return wrap<vtkFloatArray, float>(array, data);
	case FRAME_I32:
		return wrap<vtkIntArray, int>(array, data);
	case FRAME_I64:
		return wrap<vtkLongLongArray, long long>(array, data);
	default:
		return wrap<vtkUnsignedCharArray, unsigned char>(array, data);
	}
}

bool frame_view::shared(vtkDataArray *array)
{
	return values_shared<vtkDoubleArray>(array) || values_shared<vtkFloatArray>(array) ||
		   values_shared<vtkIntArray>(array) || values_shared<vtkLongLongArray>(array) ||
		   values_shared<vtkUnsignedCharArray>(array);
}

double frame_view::value(const frame_array &array, int64_t k, int c) const
{
	const void *data = frame_data(memory, &array);
	int64_t i = k * array.components + c;
	switch (array.type) {
	case FRAME_F64:
		return static_cast<const double *>(data)[i];
	case FRAME_F32:
		return double(static_cast<const float *>(data)[i]);
	case FRAME_I32:
		return static_cast<const int32_t *>(data)[i];
	case FRAME_I64:
		return double(static_cast<const int64_t *>(data)[i]);
	default:
		return static_cast<const uint8_t *>(data)[i];
	}
}

vtkSmartPointer<vtkPolyData> frame_view::geometry(int c, vtkDataArray *coordinates) const
{
	const frame_channel &channel = this->channel(c);
	static const int cell_size[] = {0, 1, 4, 2};
	if (!coordinates || coordinates->GetNumberOfComponents() != 3 || channel.kind == FRAME_IMAGE)
		return nullptr;
	auto points = vtkSmartPointer<vtkPoints>::New();
	points->SetData(coordinates);
	auto data = vtkSmartPointer<vtkPolyData>::New();
	data->SetPoints(points);
	int64_t n_points = coordinates->GetNumberOfTuples();
	if (channel.kind == FRAME_POLYLINES) {
		const frame_array *offsets = find_array(c, "offsets");
		auto cells = vtkSmartPointer<vtkCellArray>::New();
		for (int64_t k = 0; offsets && k + 1 < offsets->count; k++) {
			int64_t from = int64_t(value(*offsets, k)), to = int64_t(value(*offsets, k + 1));
			if (from < 0 || to < from || to > n_points)
				return nullptr;
			cells->InsertNextCell(int(to - from));
			for (int64_t p = from; p < to; p++)
				cells->InsertCellPoint(p);
		}
		data->SetLines(cells);
		return data;
	}
	int size = cell_size[channel.kind];
	auto cells = consecutive_cells(n_points / size, size);
	if (channel.kind == FRAME_QUADS)
		data->SetPolys(cells);
	else if (channel.kind == FRAME_SEGMENTS)
		data->SetLines(cells);
	else
		data->SetVerts(cells);
	return data;
}

std::string frame_view::names(int channel) const
{
	std::string all;
	for (int a = 0; a < header().n_arrays; a++) {
		const frame_array &array = frame_arrays(memory)[a];
		if (array.channel == channel && array.location != FRAME_GEOMETRY)
			all += (all.empty() ? "" : ", ") + std::string(array.name);
	}
	return all.empty() ? "none" : all;
}
