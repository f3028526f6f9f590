#include "channels.h"

#include <cstdlib>
#include <cstring>

#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkImageData.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkStringArray.h>
#include <vtkTypeInt64Array.h>

channels::channels(const frame_view &frame)
{
	for (int c = 0; c < frame.header().n_channels; c++)
		add(frame, c);
}

channels &channels::operator=(channels &&other)
{
	if (this != &other) {
		release();
		list = std::move(other.list);
		lent = std::move(other.lent);
		other.list.clear();
		other.lent.clear();
	}
	return *this;
}

// What stands beside the arrays: time, units, and what is known of an RVE.
static void add_field_data(const frame_view &frame, int c, vtkFieldData *fields)
{
	const frame_channel &channel = frame.channel(c);
	vtkNew<vtkDoubleArray> time, cell;
	time->SetName("time");
	time->InsertNextValue(frame.header().time);
	fields->AddArray(time);
	vtkNew<vtkTypeInt64Array> step;
	step->SetName("step");
	step->InsertNextValue(frame.header().step);
	fields->AddArray(step);
	vtkNew<vtkStringArray> units;
	units->SetName("units");
	for (int a = 0; a < frame.header().n_arrays; a++) {
		const frame_array &array = frame_arrays(&frame.header())[a];
		if (array.channel == c && array.location != FRAME_GEOMETRY)
			units->InsertNextValue(std::string(array.name) + "=" + array.unit);
	}
	fields->AddArray(units);
	if (channel.note[0] == '\0')
		return;
	vtkNew<vtkStringArray> note;
	note->SetName("note");
	note->InsertNextValue(channel.note);
	fields->AddArray(note);
	cell->SetName("cell_matrix");
	for (double h : channel.cell_matrix)
		cell->InsertNextValue(h);
	fields->AddArray(cell);
}

static vtkSmartPointer<vtkImageData> make_image(const frame_channel &channel)
{
	auto image = vtkSmartPointer<vtkImageData>::New();
	image->SetDimensions(channel.dims[0], channel.dims[1], 1);
	image->SetOrigin(channel.origin[0], channel.origin[1], 0);
	image->SetSpacing(channel.spacing[0], channel.spacing[1], 1);
	return image;
}

void channels::add(const frame_view &frame, int c)
{
	const frame_channel &channel = frame.channel(c);
	vtkSmartPointer<vtkDataSet> data;
	if (channel.kind == FRAME_IMAGE) {
		data = make_image(channel);
	} else {
		const frame_array *coordinates = frame.find_array(c, "coordinates");
		vtkSmartPointer<vtkDataArray> points = coordinates ? lend(frame, *coordinates) : nullptr;
		data = points ? frame.geometry(c, points) : nullptr;
	}
	if (!data)
		return;
	for (int a = 0; a < frame.header().n_arrays; a++) {
		const frame_array &array = frame_arrays(&frame.header())[a];
		if (array.channel != c || array.location == FRAME_GEOMETRY)
			continue;
		vtkDataSetAttributes *attributes = array.location == FRAME_POINT
											   ? static_cast<vtkDataSetAttributes *>(data->GetPointData())
											   : data->GetCellData();
		int64_t expected = array.location == FRAME_POINT ? data->GetNumberOfPoints() : data->GetNumberOfCells();
		if (array.count == expected)
			attributes->AddArray(lend(frame, array));
	}
	add_field_data(frame, c, data->GetFieldData());
	list.push_back({channel.name, data});
}

vtkSmartPointer<vtkDataArray> channels::lend(const frame_view &frame, const frame_array &array)
{
	lent.push_back(frame.array(array));
	return lent.back();
}

void channels::release()
{
	list.clear();
	for (auto &array : lent) {
		if (!frame_view::shared(array))
			continue;
		size_t bytes = size_t(array->GetNumberOfValues()) * size_t(array->GetDataTypeSize());
		void *copy = malloc(bytes + 1);
		if (!copy)
			abort(); // there is no way on: whoever holds the array would read what the engine writes next
		memcpy(copy, array->GetVoidPointer(0), bytes);
		array->SetVoidArray(copy, array->GetNumberOfValues(), 0, vtkAbstractArray::VTK_DATA_ARRAY_FREE);
	}
	lent.clear();
}
