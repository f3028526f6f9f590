// A frame as VTK data objects, one for each channel, whose arrays lie in the engine's shared memory.
#pragma once

#include <string>
#include <vector>

#include <vtkDataArray.h>
#include <vtkDataObject.h>
#include <vtkSmartPointer.h>

#include "frame_view.h"

class channels
{
  public:
	struct channel {
		std::string name;
		vtkSmartPointer<vtkDataObject> data;
	};

	channels() = default;
	// The memory of the frame must stay as it is until release().
	explicit channels(const frame_view &frame);
	channels(channels &&) = default;
	channels &operator=(channels &&other);
	~channels() { release(); }

	const std::vector<channel> &all() const { return list; }

	// Lets go of the memory: arrays that somebody still refers to (a filter's output, a view's geometry) get a copy of
	// their own first.
	void release();

  private:
	void add(const frame_view &frame, int c);
	vtkSmartPointer<vtkDataArray> lend(const frame_view &frame, const frame_array &array);

	std::vector<channel> list;
	std::vector<vtkSmartPointer<vtkDataArray>> lent;
};
