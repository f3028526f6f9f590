// The viewer's end of the frame interface (core/run/frame.h): messages, and the memory that frames lie in.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "run/frame.h"

// Sends a message to the engine; a longer text than a packet holds is cut.
void engine_send(int kind, int slot = -1, const std::string &text = "", int n = 0);

// Takes one packet.  False: the engine is gone.
bool engine_receive(void *packet, size_t bytes);

// Where the frames of the engine's slots lie here.  A slot stays mapped where it is until the engine has moved it,
// which it does only when nobody refers to it any more.
class engine_memory
{
  public:
	~engine_memory();
	// Start of a request's frame; null if it cannot be mapped.
	const void *at(const frame_message &request);

  private:
	static constexpr int SLOTS = 16;
	struct
	{
		void *start;
		int64_t offset, bytes;
	} maps[SLOTS] = {};
};
