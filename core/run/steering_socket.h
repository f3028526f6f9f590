/* Steering through a socket in the run's folder, for `tmdempm steer` and scripts.
 *
 * A client sends lines, each a command (steering.h) or `state`; each is answered, when it has been done, by
 *   ok WHAT WAS DONE          or          error STATUS WHAT WAS WRONG
 * before which `state` gives lines `name  value`.  A line is taken up when the one before it has been answered.  Only
 * the run's owner (and root) may connect.  The pause of a client stays when it leaves, unless it said pause=hold. */
#ifndef TMDEMPM_RUN_STEERING_SOCKET_H
#define TMDEMPM_RUN_STEERING_SOCKET_H

#include "run/steering.h"

struct steering_socket;

/* Listens in `folder` (open as `descriptor`, and ours alone: a socket that lies there is of a run that was killed), and
 * serves as a transport of `steering`. */
int steering_socket_create(struct steering_socket **socket, struct steering *steering, const char *folder,
						   int descriptor);

/* Removes the socket; after steering_close(), which answers those who wait.  NULL is allowed. */
void steering_socket_close(struct steering_socket *socket);

/* A client's end: connected to the run in this folder.  STATUS_INPUT if there is no such folder, STATUS_RESOURCE if no
 * run works there. */
int steering_socket_connect(int *descriptor, const char *folder);

#endif
