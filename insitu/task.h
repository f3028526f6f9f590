// What a viewer process is there for: pictures, scripts of ParaView Catalyst, or a live connection.
#pragma once

#include <string>

#include "frame_view.h"

class task
{
  public:
	virtual ~task() = default;

	// Deals with a DRAW or FRAME and answers it (DONE, KEPT); false with a reason: it is answered FAILED.
	virtual bool work(const frame_message &request, const frame_view &frame, std::string &error) = 0;

	// A descriptor that also wants attention, -1 = none; and how long to wait for anything, ms, -1 = for ever.
	virtual int descriptor() { return -1; }
	virtual int patience() { return -1; }
	// Called when the descriptor is readable or patience has run out.
	virtual void attend() {}
};
