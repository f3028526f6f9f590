#define _GNU_SOURCE /* O_PATH, accept4, SO_PEERCRED */
#include "run/steering_socket.h"

#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "base/error.h"
#include "io/file.h"

enum { CLIENTS = 16, LINES = 4096 };

static const char socket_name[] = "steering.socket";

struct client {
	struct steering_socket *owner;
	int descriptor; /* -1 = free */
	bool waiting;   /* for the answer to its last line */
	bool ended;     /* says no more, but listens */
	size_t used;
	char lines[LINES]; /* received and not yet taken */
};

struct steering_socket {
	struct steering *steering; /* NULL: the run has ended */
	int folder;                /* borrowed */
	int listener, epoll;
	bool bound;
	struct client clients[CLIENTS];
};

/* The socket's address through the open folder, whose path may be longer than an address can be. */
static struct sockaddr_un address_of(int folder)
{
	struct sockaddr_un address = {.sun_family = AF_UNIX};
	snprintf(address.sun_path, sizeof address.sun_path, "/proc/self/fd/%d/%s", folder, socket_name);
	return address;
}

/* ---- clients ---- */

static void client_drop(struct client *client)
{
	if (client->descriptor < 0)
		return;
	close(client->descriptor); /* epoll forgets it with that */
	client->descriptor = -1;
	if (client->owner->steering)
		steering_forget(client->owner->steering, client);
}

/* What a client does not take at once is lost with it. */
static void client_send(struct client *client, const char *text, size_t n)
{
	if (client->descriptor >= 0 && send(client->descriptor, text, n, MSG_NOSIGNAL | MSG_DONTWAIT) != (ssize_t)n)
		client_drop(client);
}

static void client_answer(struct client *client, int status, const char *text)
{
	char line[STEERING_SAID + 1024];
	int n = status == STATUS_OK ? snprintf(line, sizeof line - 1, "ok %s", text)
								: snprintf(line, sizeof line - 1, "error %d %s", status, text);
	n = n < (int)sizeof line - 2 ? n : (int)sizeof line - 2;
	for (int k = 0; k < n; k++)
		if (line[k] == '\n')
			line[k] = ' ';
	line[n++] = '\n';
	client_send(client, line, (size_t)n);
}

static void client_state(struct client *client)
{
	char *text = NULL;
	size_t size = 0;
	FILE *stream = open_memstream(&text, &size);
	if (!stream) {
		client_answer(client, STATUS_RESOURCE, "out of memory");
		return;
	}
	steering_describe(client->owner->steering, stream);
	fprintf(stream, "ok\n");
	if (fclose(stream) == 0)
		client_send(client, text, size);
	free(text);
}

static void client_answered(void *asker, int status, const char *text);

/* Takes the lines that have come, up to one whose answer takes time. */
static void client_take(struct client *client)
{
	char *end;
	while (client->descriptor >= 0 && !client->waiting && (end = memchr(client->lines, '\n', client->used))) {
		char line[LINES];
		size_t n = (size_t)(end - client->lines);
		memcpy(line, client->lines, n);
		line[n - (n > 0 && line[n - 1] == '\r')] = '\0';
		line[n] = '\0';
		client->used -= n + 1;
		memmove(client->lines, end + 1, client->used);
		if (!strcmp(line, "state")) {
			client_state(client);
		} else {
			client->waiting = true;
			steering_ask(client->owner->steering, "steer", line, client_answered, client);
		}
	}
}

static void client_answered(void *asker, int status, const char *text)
{
	struct client *client = asker;
	client->waiting = false;
	client_answer(client, status, text);
	client_take(client);
	if (client->ended && !client->waiting)
		client_drop(client);
}

/* It has shut its end: what it said before is still answered, unless it has hung up. */
static void client_end(struct client *client, bool hung_up)
{
	struct epoll_event none = {.data.ptr = client};
	client->ended = true;
	if (hung_up || !client->waiting || epoll_ctl(client->owner->epoll, EPOLL_CTL_MOD, client->descriptor, &none) != 0)
		client_drop(client);
}

static void client_read(struct client *client, bool hung_up)
{
	size_t room = LINES - client->used;
	ssize_t n = room ? recv(client->descriptor, client->lines + client->used, room, MSG_DONTWAIT) : -1;
	if (n < 0 && room && (errno == EAGAIN || errno == EINTR))
		return;
	if (n < 0) /* broken, or it talks without end */
		client_drop(client);
	if (n == 0)
		client_end(client, hung_up);
	if (n > 0)
		client->used += (size_t)n, client_take(client);
}

/* ---- the listener ---- */

static bool client_may(int descriptor)
{
	struct ucred who;
	socklen_t size = sizeof who;
	return getsockopt(descriptor, SOL_SOCKET, SO_PEERCRED, &who, &size) == 0 && (who.uid == geteuid() || who.uid == 0);
}

static struct client *client_free(struct steering_socket *s)
{
	for (int k = 0; k < CLIENTS; k++)
		if (s->clients[k].descriptor < 0)
			return &s->clients[k];
	return NULL;
}

static void socket_accept(struct steering_socket *s)
{
	int descriptor = accept4(s->listener, NULL, NULL, SOCK_CLOEXEC);
	if (descriptor < 0)
		return;
	struct client *client = client_may(descriptor) ? client_free(s) : NULL;
	struct epoll_event event = {.events = EPOLLIN, .data.ptr = client};
	if (!client || epoll_ctl(s->epoll, EPOLL_CTL_ADD, descriptor, &event) != 0) {
		static const char busy[] = "error 4 too many clients, or not the owner of this run\n";
		if (send(descriptor, busy, sizeof busy - 1, MSG_NOSIGNAL | MSG_DONTWAIT) < 0)
			errno = 0; /* it is gone */
		close(descriptor);
		return;
	}
	client->descriptor = descriptor;
	client->used = 0;
	client->waiting = client->ended = false;
}

static int socket_descriptor(void *data) { return ((struct steering_socket *)data)->epoll; }

static void socket_serve(void *data)
{
	struct steering_socket *s = data;
	struct epoll_event events[CLIENTS + 1];
	int n = epoll_wait(s->epoll, events, CLIENTS + 1, 0);
	for (int k = 0; k < n; k++) {
		struct client *client = events[k].data.ptr;
		if (!client)
			socket_accept(s);
		else if (client->descriptor >= 0)
			client_read(client, events[k].events & EPOLLHUP);
	}
}

/* ---- life ---- */

static int socket_listen(struct steering_socket *s, const char *folder)
{
	struct sockaddr_un address = address_of(s->folder);
	struct epoll_event event = {.events = EPOLLIN, .data.ptr = NULL};
	s->epoll = epoll_create1(EPOLL_CLOEXEC);
	s->listener = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
	if (s->epoll < 0 || s->listener < 0)
		return error_set(STATUS_RESOURCE, "cannot make a socket: %s", strerror(errno));
	unlinkat(s->folder, socket_name, 0);
	/* the mode that its name gets: nobody else connects, not even for a moment */
	if (fchmod(s->listener, 0600) != 0 || bind(s->listener, (struct sockaddr *)&address, sizeof address) != 0)
		return error_set(STATUS_RESOURCE, "cannot make %s/%s: %s", folder, socket_name, strerror(errno));
	s->bound = true;
	if (listen(s->listener, CLIENTS) != 0 || epoll_ctl(s->epoll, EPOLL_CTL_ADD, s->listener, &event) != 0)
		return error_set(STATUS_RESOURCE, "cannot listen at %s/%s: %s", folder, socket_name, strerror(errno));
	return STATUS_OK;
}

int steering_socket_create(struct steering_socket **result, struct steering *steering, const char *folder,
						   int descriptor)
{
	struct steering_socket *s = *result = calloc(1, sizeof *s);
	if (!s)
		return error_set(STATUS_RESOURCE, "out of memory");
	*s = (struct steering_socket){.steering = steering, .folder = descriptor, .listener = -1, .epoll = -1};
	for (int k = 0; k < CLIENTS; k++)
		s->clients[k] = (struct client){.owner = s, .descriptor = -1};
	int status = socket_listen(s, folder);
	if (status != STATUS_OK) {
		steering_socket_close(s);
		*result = NULL;
		return status;
	}
	struct steering_transport transport = {socket_descriptor, socket_serve, s};
	steering_add_transport(steering, &transport);
	return STATUS_OK;
}

void steering_socket_close(struct steering_socket *s)
{
	if (!s)
		return;
	s->steering = NULL;
	if (s->bound)
		unlinkat(s->folder, socket_name, 0);
	for (int k = 0; k < CLIENTS; k++)
		client_drop(&s->clients[k]);
	if (s->listener >= 0)
		close(s->listener);
	if (s->epoll >= 0)
		close(s->epoll);
	free(s);
}

int steering_socket_connect(int *descriptor, const char *folder)
{
	*descriptor = -1;
	int at = open(folder, O_PATH | O_DIRECTORY | O_CLOEXEC);
	if (at < 0)
		return error_set(STATUS_INPUT, "%s: %s, expected the folder of a run", folder, strerror(errno));
	struct sockaddr_un address = address_of(at);
	int status = STATUS_OK, made = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
	if (made < 0)
		status = error_set(STATUS_RESOURCE, "cannot make a socket: %s", strerror(errno));
	else if (connect(made, (struct sockaddr *)&address, sizeof address) != 0)
		status = error_set(STATUS_RESOURCE, "%s: %s", folder,
						   errno == EACCES || errno == EPERM ? "this run belongs to another user"
															 : "no run is working in this folder now");
	close(at);
	if (status == STATUS_OK)
		*descriptor = made;
	else if (made >= 0)
		close(made);
	return status;
}
