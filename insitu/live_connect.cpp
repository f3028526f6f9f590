// Where the live link may connect to, and for how long it may try.
//
// ParaView's link blocks for minutes at a host that swallows packets.  And it asks the listening ParaView for the name
// of its machine and connects to that for the data: a name that means nothing here, or another machine, when ParaView
// is reached through an ssh tunnel; then it calls abort().  The two functions of the C library that VTK uses are
// therefore taken over here: names lead to the host that was asked for, and attempts are bounded.
#include "live_connect.h"

#include <cerrno>
#include <cstring>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <unistd.h>

namespace
{
constexpr int PATIENCE = 2; // s
std::string target;

bool resolve(const std::string &host, in_addr &address)
{
	addrinfo wish = {}, *found = nullptr;
	wish.ai_family = AF_INET; // all that VTK's sockets know
	wish.ai_socktype = SOCK_STREAM;
	if (getaddrinfo(host.c_str(), nullptr, &wish, &found) != 0)
		return false;
	address = reinterpret_cast<sockaddr_in *>(found->ai_addr)->sin_addr;
	freeaddrinfo(found);
	return true;
}
} // namespace

void live_connect_to(const std::string &host)
{
	target = host;
	setenv("RES_OPTIONS", "timeout:1 attempts:1", 0); // a dead name server is to be no reason to wait
}

extern "C" struct hostent *gethostbyname(const char *name)
{
	static in_addr address;
	static char *addresses[] = {reinterpret_cast<char *>(&address), nullptr}, *aliases[] = {nullptr};
	static hostent entry;
	if (!resolve(target.empty() ? name : target, address))
		return nullptr;
	entry = {const_cast<char *>(name), aliases, AF_INET, int(sizeof address), addresses};
	return &entry;
}

extern "C" int connect(int fd, const struct sockaddr *address, socklen_t size)
{
	bool bounded = address && address->sa_family == AF_INET;
	timeval before = {}, patience = {PATIENCE, 0};
	socklen_t length = sizeof before;
	// Linux bounds a connect() by the time-out for sending.
	bounded = bounded && getsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &before, &length) == 0 &&
			  setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience) == 0;
	int result = int(syscall(SYS_connect, fd, address, size)), failure = errno;
	if (bounded)
		setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &before, sizeof before);
	// VTK takes EINPROGRESS for a connection on its way and would wait for it.
	errno = result < 0 && bounded && failure == EINPROGRESS ? ETIMEDOUT : failure;
	return result;
}
