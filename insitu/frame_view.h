// A frame in shared memory, checked, and wrapped into VTK's arrays without a copy.
#pragma once

#include <string>

#include <vtkDataArray.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include "run/frame.h"

class frame_view
{
  public:
	// Checks that everything the frame speaks of lies inside `bytes`; false with a reason in `error`.
	// The memory must outlive the view and every array taken from it.
	bool open(const void *memory, int64_t bytes, std::string &error);

	const struct frame_header &header() const { return *frame_header(memory); }
	int find(const std::string &channel) const { return frame_find_channel(memory, channel.c_str()); }
	const frame_channel &channel(int c) const { return frame_channels(memory)[c]; }
	const frame_array *find_array(int channel, const std::string &name) const
	{
		return frame_find_array(memory, channel, name.c_str());
	}

	// An array as VTK sees it (no copy); null if the channel has none of this name.
	vtkSmartPointer<vtkDataArray> array(const frame_array &array) const;
	vtkSmartPointer<vtkDataArray> array(int channel, const std::string &name) const;

	// Does anybody but the caller, who holds one reference, refer to such an array or to its values?
	static bool shared(vtkDataArray *array);

	// Value k of component c, whatever its type.
	double value(const frame_array &array, int64_t k, int c = 0) const;

	// Points and cells of a channel (not of an image), without data arrays; null if it has no coordinates.
	vtkSmartPointer<vtkPolyData> geometry(int channel) const { return geometry(channel, array(channel, "coordinates")); }
	vtkSmartPointer<vtkPolyData> geometry(int channel, vtkDataArray *coordinates) const;

	// "temperature, stress, ..." for messages.
	std::string names(int channel) const;

  private:
	const void *memory = nullptr;
};
