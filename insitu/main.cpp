// tmdempm-viewer: reads frames from the engine's shared memory and makes pictures of them (core/run/frame.h).
// The engine starts it; it ends when the engine says so, or ends.

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <fcntl.h>
#include <string>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>
#include <vector>

#include "display.h"
#include "frame_view.h"
#include "image_sink.h"

namespace
{
// The engine's memory file, mapped as far as it has grown.
class memory
{
  public:
	~memory() { release(); }
	const void *at(int64_t offset, int64_t bytes)
	{
		if (offset < 0 || bytes < 0 || offset > INT64_MAX - bytes)
			return nullptr;
		if (offset + bytes > size && !map())
			return nullptr;
		return offset + bytes <= size ? static_cast<const char *>(start) + offset : nullptr;
	}

  private:
	bool map()
	{
		struct stat file;
		release();
		if (fstat(FRAME_FD_MEMORY, &file) < 0 || file.st_size == 0)
			return false;
		void *mapped = mmap(nullptr, size_t(file.st_size), PROT_READ, MAP_SHARED, FRAME_FD_MEMORY, 0);
		if (mapped == MAP_FAILED)
			return false;
		start = mapped;
		size = file.st_size;
		return true;
	}
	void release()
	{
		if (start)
			munmap(start, size_t(size));
		start = nullptr;
		size = 0;
	}
	void *start = nullptr;
	int64_t size = 0;
};

void send_message(int kind, int slot, const std::string &text = "")
{
	frame_message message = {};
	message.kind = kind;
	message.slot = slot;
	message.image = -1;
	snprintf(message.text, sizeof message.text, "%s", text.c_str());
	while (send(FRAME_FD_SOCKET, &message, sizeof message, MSG_NOSIGNAL) < 0 && errno == EINTR)
		continue;
}

// False: the engine is gone.
bool receive(void *packet, size_t bytes)
{
	ssize_t n;
	do
		n = recv(FRAME_FD_SOCKET, packet, bytes, 0);
	while (n < 0 && errno == EINTR);
	return n == ssize_t(bytes);
}

bool draw(memory &memory, sink &pictures, const std::vector<frame_image> &images, const frame_message &request,
		  std::string &error)
{
	frame_view frame;
	const void *start = memory.at(request.offset, request.bytes);
	if (!start) {
		error = "cannot map the frame";
		return false;
	}
	if (request.image < 0 || size_t(request.image) >= images.size()) {
		error = "there is no image number " + std::to_string(request.image);
		return false;
	}
	return frame.open(start, request.bytes, error) &&
		   pictures.draw(frame, images[size_t(request.image)], request.text, error);
}

// Answers requests until the engine says QUIT or is gone.
void serve(sink &pictures)
{
	memory memory;
	std::vector<frame_image> images;
	frame_message request;
	while (receive(&request, sizeof request) && request.kind != FRAME_MSG_QUIT) {
		if (request.kind == FRAME_MSG_IMAGES) {
			images.resize(request.n > 0 ? size_t(request.n) : 0);
			for (frame_image &image : images)
				if (!receive(&image, sizeof image))
					return;
			send_message(FRAME_MSG_READY, -1);
		} else if (request.kind == FRAME_MSG_DRAW) {
			std::string error;
			bool made = false;
			request.text[sizeof request.text - 1] = '\0';
			try {
				made = draw(memory, pictures, images, request, error);
			} catch (const std::exception &failure) {
				error = failure.what();
			}
			if (made)
				send_message(FRAME_MSG_DONE, request.slot);
			else
				send_message(FRAME_MSG_FAILED, request.slot, std::string(request.text) + ": " + error);
		}
	}
}
} // namespace

int main()
{
	// Our children must hold neither: the end of the socket is how either side learns of the other's death.
	if (fcntl(FRAME_FD_SOCKET, F_SETFD, FD_CLOEXEC) < 0 || fcntl(FRAME_FD_MEMORY, F_SETFD, FD_CLOEXEC) < 0) {
		fprintf(stderr,
				"tmdempm-viewer is started by tmdempm, which hands it frames; there is nothing to do by hand.\n");
		return 2;
	}
	display display;
	std::string log, error;
	if (!display.open(log, error)) {
		send_message(FRAME_MSG_FAILED, -1, error);
		return 4;
	}
	if (!log.empty())
		fprintf(stderr, "tmdempm-viewer: %s\n", log.c_str());
	serve(*image_sink_create());
	return 0;
}
