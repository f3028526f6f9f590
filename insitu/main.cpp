// tmdempm-viewer: reads frames from the engine's shared memory and makes pictures of them, runs scripts of ParaView
// Catalyst on them, or shows them to a ParaView that is connected (core/run/frame.h).  The engine starts one process
// for each of these; it ends when the engine says so, or ends.

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <fcntl.h>
#include <memory>
#include <poll.h>
#include <string>
#include <vector>

#include "catalyst_module.h"
#include "display.h"
#include "engine.h"
#include "image_sink.h"
#include "self_test.h"

namespace
{
// Pictures: one DRAW, one PNG.
class picture_task : public task
{
  public:
	picture_task(std::vector<frame_image> images) : images(std::move(images)), pictures(image_sink_create()) {}

	bool work(const frame_message &request, const frame_view &frame, std::string &error) override
	{
		if (request.image < 0 || size_t(request.image) >= images.size()) {
			error = "there is no image number " + std::to_string(request.image);
			return false;
		}
		if (!pictures->draw(frame, images[size_t(request.image)], request.text, error)) {
			error = std::string(request.text) + ": " + error;
			return false;
		}
		engine_send(FRAME_MSG_DONE, request.slot);
		return true;
	}

  private:
	std::vector<frame_image> images;
	std::unique_ptr<sink> pictures;
};

// The packets that follow the purpose of this process.
template <class part> bool receive_parts(int n, std::vector<part> &parts)
{
	parts.resize(n > 0 ? size_t(n) : 0);
	for (part &p : parts)
		if (!engine_receive(&p, sizeof p))
			return false;
	return true;
}

bool open_display(display &display, std::string &error)
{
	std::string log;
	if (!display.open(log, error))
		return false;
	if (!log.empty())
		fprintf(stderr, "tmdempm-viewer: %s\n", log.c_str());
	return true;
}

// What this process is for, as the engine's first message tells; null with a reason in `error`, which is empty if the
// engine has gone.
std::unique_ptr<task> make_task(display &display, std::string &error)
{
	frame_message purpose;
	error.clear();
	if (!engine_receive(&purpose, sizeof purpose))
		return nullptr;
	purpose.text[sizeof purpose.text - 1] = '\0';
	if (purpose.kind == FRAME_MSG_IMAGES) {
		std::vector<frame_image> images;
		if (!receive_parts(purpose.n, images) || !open_display(display, error))
			return nullptr;
		return std::make_unique<picture_task>(images);
	}
	if (purpose.kind == FRAME_MSG_SCRIPTS) {
		std::vector<frame_message> parts;
		std::vector<std::string> scripts;
		bool draws = false;
		if (!receive_parts(purpose.n, parts))
			return nullptr;
		for (frame_message &part : parts) {
			part.text[sizeof part.text - 1] = '\0';
			scripts.push_back(part.text);
			draws = draws || catalyst_script_draws(part.text);
		}
		if (draws && !open_display(display, error))
			return nullptr;
		return catalyst_scripts(scripts, purpose.text, error);
	}
	if (purpose.kind == FRAME_MSG_LIVE)
		return catalyst_live(purpose.text, purpose.n, error);
	error = "a message of another version: engine and viewer are not from the same build";
	return nullptr;
}

void answer(engine_memory &memory, task &task, frame_message &request)
{
	std::string error = "cannot map the frame";
	frame_view frame;
	bool made = false;
	request.text[sizeof request.text - 1] = '\0';
	const void *start = memory.at(request);
	try {
		made = start && frame.open(start, request.bytes, error) && task.work(request, frame, error);
	} catch (const std::exception &failure) {
		error = failure.what();
	}
	if (!made)
		engine_send(FRAME_MSG_FAILED, request.slot, error);
}

// Answers requests until the engine says QUIT or is gone.
void serve(engine_memory &memory, task &task)
{
	for (;;) {
		pollfd ready[] = {{FRAME_FD_SOCKET, POLLIN, 0}, {task.descriptor(), POLLIN, 0}};
		int n = poll(ready, 2, task.patience());
		if (n < 0 && errno != EINTR)
			return;
		if (n >= 0 && (n == 0 || ready[1].revents))
			task.attend();
		if (n <= 0 || !ready[0].revents)
			continue;
		frame_message request;
		if (!engine_receive(&request, sizeof request) || request.kind == FRAME_MSG_QUIT)
			return;
		answer(memory, task, request);
	}
}
} // namespace

int main(int argc, char **argv)
{
	signal(SIGPIPE, SIG_IGN);
	if (argc == 3 && !strcmp(argv[1], "--self-test"))
		return self_test(argv[2]);
	// Our children must hold neither: the end of the socket is how either side learns of the other's death.
	if (fcntl(FRAME_FD_SOCKET, F_SETFD, FD_CLOEXEC) < 0 || fcntl(FRAME_FD_MEMORY, F_SETFD, FD_CLOEXEC) < 0) {
		fprintf(stderr,
				"tmdempm-viewer is started by tmdempm, which hands it frames.  By hand: tmdempm-viewer --self-test "
				"display|gl|catalyst|live\n");
		return 2;
	}
	display display;
	engine_memory memory; // outlives the task, whose arrays lie in it
	std::string error;
	std::unique_ptr<task> task = make_task(display, error);
	if (!task) {
		engine_send(FRAME_MSG_FAILED, -1, error);
		return 4;
	}
	engine_send(FRAME_MSG_READY);
	serve(memory, *task);
	return 0;
}
