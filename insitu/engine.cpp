#include "engine.h"

#include <cerrno>
#include <cstdio>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>

void engine_send(int kind, int slot, const std::string &text, int n)
{
	frame_message message = {};
	message.kind = kind;
	message.slot = slot;
	message.image = -1;
	message.n = n;
	snprintf(message.text, sizeof message.text, "%s", text.c_str());
	while (send(FRAME_FD_SOCKET, &message, sizeof message, MSG_NOSIGNAL) < 0 && errno == EINTR)
		continue;
}

bool engine_receive(void *packet, size_t bytes)
{
	ssize_t n;
	do
		n = recv(FRAME_FD_SOCKET, packet, bytes, 0);
	while (n < 0 && errno == EINTR);
	return n == ssize_t(bytes);
}

engine_memory::~engine_memory()
{
	for (auto &map : maps)
		if (map.start)
			munmap(map.start, size_t(map.bytes));
}

const void *engine_memory::at(const frame_message &request)
{
	struct stat file;
	if (request.slot < 0 || request.slot >= SLOTS || request.offset < 0 || request.bytes <= 0 ||
		fstat(FRAME_FD_MEMORY, &file) < 0 || request.bytes > file.st_size ||
		request.offset > file.st_size - request.bytes)
		return nullptr;
	auto &map = maps[request.slot];
	if (map.start && map.offset == request.offset && map.bytes >= request.bytes)
		return map.start;
	if (map.start)
		munmap(map.start, size_t(map.bytes));
	map = {mmap(nullptr, size_t(request.bytes), PROT_READ, MAP_SHARED, FRAME_FD_MEMORY, request.offset), request.offset,
		   request.bytes};
	if (map.start == MAP_FAILED)
		map.start = nullptr;
	return map.start;
}
