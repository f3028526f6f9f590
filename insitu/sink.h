// A sink makes something of a frame.  The viewer hands every frame to the sink that its request names.
#pragma once

#include <string>

#include "frame_view.h"

class sink
{
  public:
	virtual ~sink() = default;
	// Draws `image` of this frame to `path`; false with a reason for the user in `error`.
	virtual bool draw(const frame_view &frame, const frame_image &image, const std::string &path,
					  std::string &error) = 0;
};
