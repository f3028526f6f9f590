#include "display.h"

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <X11/Xlib.h>

namespace
{
// VTK calls abort() on a server without GLX (some remote displays), so it is asked first.
bool usable()
{
	Display *server = XOpenDisplay(nullptr);
	if (!server)
		return false;
	int opcode, event, failure;
	bool glx = XQueryExtension(server, "GLX", &opcode, &event, &failure);
	XCloseDisplay(server);
	return glx;
}

[[noreturn]] void run_xvfb(pid_t viewer, int report)
{
	// SIGTERM, so that it removes its lock files.  A session of its own keeps the terminal's signals away.
	prctl(PR_SET_PDEATHSIG, SIGTERM);
	if (getppid() != viewer)
		_exit(126);
	setsid();
	for (int s : {SIGINT, SIGTERM, SIGHUP, SIGUSR1, SIGUSR2})
		signal(s, SIG_DFL);
	dup2(report, 3); // above 3 everything is close-on-exec
	char number[] = "3";
	// Without MIT-SHM no shared memory segment can outlive a crash.
	execlp("Xvfb", "Xvfb", "-displayfd", number, "-screen", "0", "64x64x24", "-nolisten", "tcp", "-noreset",
		   "-extension", "MIT-SHM", static_cast<char *>(nullptr));
	_exit(127);
}

// The number that Xvfb writes once it listens; "" if it ends, or says nothing for half a minute.
std::string read_number(int fd)
{
	std::string text;
	for (int tick = 0; tick < 300; tick++) {
		pollfd ready = {fd, POLLIN, 0};
		if (poll(&ready, 1, 100) <= 0)
			continue;
		char c[16];
		ssize_t n = read(fd, c, sizeof c);
		if (n > 0)
			text.append(c, size_t(n));
		if (n == 0 || (n < 0 && errno != EINTR))
			return "";
		if (text.find('\n') != std::string::npos)
			return text.substr(0, text.find('\n'));
	}
	return "";
}

// Waits for a child's end, up to `ticks` of 0.1 s; then `pid` is 0.  True if there is no such child any more.
bool ended(int &pid, int ticks, int &status)
{
	for (; pid > 0 && waitpid(pid, &status, WNOHANG) == 0; ticks--) {
		if (ticks <= 0)
			return false;
		poll(nullptr, 0, 100);
	}
	pid = 0;
	return true;
}
} // namespace

bool display::open(std::string &log, std::string &error)
{
	if (getenv("DISPLAY") && usable())
		return true;
	int ends[2];
	if (pipe2(ends, O_CLOEXEC) < 0) {
		error = std::string("cannot create a pipe: ") + strerror(errno);
		return false;
	}
	pid_t viewer = getpid();
	xvfb = fork();
	if (xvfb == 0)
		run_xvfb(viewer, ends[1]);
	::close(ends[1]);
	std::string number = xvfb > 0 ? read_number(ends[0]) : "";
	::close(ends[0]);
	if (!number.empty()) {
		setenv("DISPLAY", (":" + number).c_str(), 1);
		if (usable()) {
			log = "no usable display: drawing on an Xvfb of our own (:" + number + ")";
			return true;
		}
	}
	int status = 0;
	bool absent = xvfb > 0 && ended(xvfb, 20, status) && WIFEXITED(status) && WEXITSTATUS(status) == 127;
	error = absent
				? "pictures need an X server: install xvfb (apt-get install xvfb), or set DISPLAY"
				: "there is no usable display, and Xvfb does not start or has no GLX (its messages are in the viewer's "
				  "log); reinstall xvfb and libgl1-mesa-dri, or set DISPLAY";
	return false;
}

display::~display()
{
	int status;
	if (xvfb > 0)
		kill(xvfb, SIGTERM);
	if (!ended(xvfb, 20, status)) {
		kill(xvfb, SIGKILL);
		waitpid(xvfb, nullptr, 0);
	}
}
