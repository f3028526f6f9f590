#include "run/steer_cli.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "base/error.h"
#include "run/steering_socket.h"

static const char usage[] =
	"usage: tmdempm steer DIR [COMMAND...]\n"
	"       tmdempm steer DIR -\n"
	"\n"
	"Steers the run that works in the folder DIR.  Without a command it says how the run stands.  Each command is "
	"done\n"
	"between two steps and answered when it is done; with - they come from the standard input, a line each, and the\n"
	"answers are `ok ...` or `error STATUS ...`.  What was steered stands in DIR/steering.csv, and\n"
	"`tmdempm run SCENE --steering steering.csv` repeats it at the same steps (but for pauses and steps).\n"
	"\n";

/* One line of the engine's answer without its end.  STATUS_RESOURCE if the run has ended. */
static int receive(FILE *from, char **line, size_t *size)
{
	ssize_t n = getline(line, size, from);
	if (n <= 0)
		return error_set(STATUS_RESOURCE, "the run has ended without an answer");
	(*line)[strcspn(*line, "\n")] = '\0';
	return STATUS_OK;
}

static int send_line(int descriptor, const char *command)
{
	char line[2 * STEERING_TEXT];
	size_t n = (size_t)snprintf(line, sizeof line, "%.*s\n", (int)sizeof line - 2, command);
	if (strchr(command, '\n'))
		return error_set(STATUS_INPUT, "`%s`: expected one line", command);
	/* a run that refused us has said why, and one that is gone says nothing: receive() tells */
	if (send(descriptor, line, n, MSG_NOSIGNAL) != (ssize_t)n)
		shutdown(descriptor, SHUT_WR);
	return STATUS_OK;
}

/* Sends a command and takes its answer: lines, then `ok` or `error`.  With `raw` all of that is printed as it comes. */
static int ask(int descriptor, FILE *from, const char *command, bool raw)
{
	char *line = NULL;
	size_t size = 0;
	int status = send_line(descriptor, command);
	bool over = false;
	while (status == STATUS_OK && !over && (status = receive(from, &line, &size)) == STATUS_OK) {
		char *words = line;
		bool ok = !strncmp(line, "ok", 2) && (line[2] == ' ' || !line[2]), wrong = !strncmp(line, "error ", 6);
		over = ok || wrong;
		if (raw || !over)
			puts(line);
		else if (ok && line[2])
			puts(line + 3);
		if (wrong) {
			status = (int)strtol(line + 6, &words, 10);
			error_set(status, "%s", words + (*words == ' '));
		}
	}
	fflush(stdout);
	free(line);
	return status;
}

/* Commands from the standard input; the first failure is the result, and only the end of the run is the end. */
static int ask_all(int descriptor, FILE *from)
{
	char *line = NULL, first[1024] = "";
	size_t size = 0;
	int result = STATUS_OK;
	while (getline(&line, &size, stdin) > 0) {
		line[strcspn(line, "\n")] = '\0';
		if (!*line)
			continue;
		int status = ask(descriptor, from, line, true);
		if (status != STATUS_OK && result == STATUS_OK)
			result = status, snprintf(first, sizeof first, "%s", error_message());
		if (feof(from) || ferror(from))
			break;
	}
	free(line);
	return result == STATUS_OK ? result : error_set(result, "%s", first);
}

int cli_steer(int argc, char **argv)
{
	int descriptor, status = STATUS_OK;
	if (argc == 2 && (!strcmp(argv[1], "--help") || !strcmp(argv[1], "-h")))
		return printf("%s%s", usage, steering_help), STATUS_OK;
	if (argc < 2 || argv[1][0] == '-')
		return error_set(STATUS_INPUT, "steer: which run? expected tmdempm steer DIR [COMMAND...]");
	for (int k = 2; k < argc && strcmp(argv[k], "-") != 0; k++) { /* none is done if one is no command */
		struct steering_command command;
		CHECK(steering_parse(&command, argv[k]));
	}
	CHECK(steering_socket_connect(&descriptor, argv[1]));
	FILE *from = fdopen(descriptor, "r");
	if (!from) {
		close(descriptor);
		return error_set(STATUS_RESOURCE, "out of memory");
	}
	if (argc == 2)
		status = ask(descriptor, from, "state", false);
	for (int k = 2; k < argc && status == STATUS_OK; k++)
		status = strcmp(argv[k], "-") ? ask(descriptor, from, argv[k], false) : ask_all(descriptor, from);
	fclose(from);
	return status;
}
