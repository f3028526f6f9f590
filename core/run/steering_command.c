#include "run/steering_command.h"

#include <ctype.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"

const char steering_help[] =
	"  pause=1 | pause=0          stops between two steps; goes on\n"
	"  pause=hold                 pauses for as long as this connection lasts (with -)\n"
	"  step=N                     N steps, then paused\n"
	"  checkpoint=1               saves the state\n"
	"  stop=1                     saves and leaves (exit code 130), as SIGTERM\n"
	"  inspect.NAME=point:ID      inspects the RVE of this point under this name, which may be new\n"
	"  inspect.NAME=at:X,Y        that of the point nearest to (X, Y) now, m\n"
	"  inspect.NAME=RULE          hottest, most_sheared, highest_pressure or most_broken: whichever it is when "
	"something\n"
	"                             is drawn or written\n"
	"  inspect.NAME=none          no longer\n"
	"  images.NAME.every=SECONDS  another interval for a picture of the scene; 0 = no more\n";

static int expected(const char *text, const char *what)
{
	return error_set(STATUS_INPUT, "`%s`: expected %s", text, what);
}

/* What scene files take for a name. */
static bool is_name(const char *text, size_t n)
{
	for (size_t k = 0; k < n; k++)
		if (!isalnum((unsigned char)text[k]) && text[k] != '_' && text[k] != '-')
			return false;
	return n > 0 && n < SCENE_NAME;
}

static int parse_name(struct steering_command *command, const char *text, const char *name, size_t n)
{
	if (!is_name(name, n))
		return expected(text, "a name of letters, digits, _ and -, at most 63");
	memcpy(command->name, name, n);
	command->name[n] = '\0';
	return STATUS_OK;
}

static bool parse_whole(const char *text, long long most, long long *number)
{
	char *end;
	*number = strtoll(text, &end, 10);
	return isdigit((unsigned char)*text) && !*end && *number <= most;
}

static bool parse_number(const char *text, char end, double *number, const char **rest)
{
	char *stop;
	*number = strtod(text, &stop);
	*rest = stop + 1;
	return stop != text && *stop == end && isfinite(*number);
}

static int parse_pause(struct steering_command *command, const char *text, const char *value)
{
	static const char *const words[] = {"0", "1", "hold"};
	for (int k = 0; k < 3; k++)
		if (!strcmp(value, words[k]))
			return command->pause = (enum steering_pause)k, STATUS_OK;
	return expected(text, "pause=1, pause=0 or pause=hold");
}

static int parse_target(struct steering_command *command, const char *text, const char *value)
{
	long long id;
	const char *rest;
	char what[256] = "point:ID, at:X,Y, none or one of the rules";
	if (!strcmp(value, "none"))
		return command->target = STEER_NOTHING, STATUS_OK;
	if (!strncmp(value, "point:", 6)) {
		command->target = STEER_POINT;
		if (!parse_whole(value + 6, INT_MAX, &id))
			return expected(text, "the number of a point behind point:");
		return command->point = (int)id, STATUS_OK;
	}
	if (!strncmp(value, "at:", 3)) {
		command->target = STEER_AT;
		bool place =
			parse_number(value + 3, ',', &command->at[0], &rest) && parse_number(rest, '\0', &command->at[1], &rest);
		return place ? STATUS_OK : expected(text, "a place X,Y in m behind at:");
	}
	command->target = STEER_RULE;
	command->rule = rve_rule_find(value);
	for (const struct rve_rule *rule = rve_rules; rule->name; rule++)
		snprintf(what + strlen(what), sizeof what - strlen(what), "%s%s", rule == rve_rules ? " " : ", ", rule->name);
	return command->rule ? STATUS_OK : expected(text, what);
}

static int parse_image(struct steering_command *command, const char *text, const char *key, const char *value)
{
	const char *dot = strrchr(key, '.'), *rest;
	command->verb = STEER_IMAGE;
	if (dot <= key + strlen("images") || strcmp(dot, ".every"))
		return expected(text, "images.NAME.every=SECONDS");
	CHECK(parse_name(command, text, key + strlen("images."), (size_t)(dot - key) - strlen("images.")));
	if (!parse_number(value, '\0', &command->every, &rest) || command->every < 0)
		return expected(text, "an interval in s, 0 = no more");
	return STATUS_OK;
}

/* Verbs whose only value is 1. */
static int parse_now(struct steering_command *command, enum steering_verb verb, const char *text, const char *value)
{
	command->verb = verb;
	return strcmp(value, "1") ? expected(text, verb == STEER_STOP ? "stop=1" : "checkpoint=1") : STATUS_OK;
}

static int parse_words(struct steering_command *command, const char *text, const char *key, const char *value)
{
	if (!strcmp(key, "pause"))
		return command->verb = STEER_PAUSE, parse_pause(command, text, value);
	if (!strcmp(key, "checkpoint"))
		return parse_now(command, STEER_CHECKPOINT, text, value);
	if (!strcmp(key, "stop"))
		return parse_now(command, STEER_STOP, text, value);
	if (!strcmp(key, "step")) {
		command->verb = STEER_STEP;
		bool steps = parse_whole(value, LLONG_MAX / 2, &command->steps) && command->steps > 0;
		return steps ? STATUS_OK : expected(text, "a whole number of steps, at least 1");
	}
	if (!strncmp(key, "inspect.", 8)) {
		command->verb = STEER_INSPECT;
		CHECK(parse_name(command, text, key + 8, strlen(key + 8)));
		return parse_target(command, text, value);
	}
	if (!strncmp(key, "images.", 7))
		return parse_image(command, text, key, value);
	return expected(text, "one of pause=, step=, checkpoint=1, stop=1, inspect.NAME=, images.NAME.every=");
}

int steering_parse(struct steering_command *command, const char *text)
{
	char line[STEERING_TEXT];
	*command = (struct steering_command){.point = -1, .at = {NAN, NAN}};
	while (isspace((unsigned char)*text))
		text++;
	size_t n = strlen(text);
	while (n > 0 && isspace((unsigned char)text[n - 1]))
		n--;
	for (size_t k = 0; k < n; k++)
		if (iscntrl((unsigned char)text[k]))
			return error_set(STATUS_INPUT, "a command with control characters, expected one line of text");
	if (n >= sizeof line)
		return error_set(STATUS_INPUT, "a command of %zu bytes, expected at most %zu", n, sizeof line - 1);
	snprintf(line, sizeof line, "%.*s", (int)n, text);
	char whole[STEERING_TEXT], *equals = strchr(line, '=');
	memcpy(whole, line, sizeof whole);
	if (!equals || equals == line)
		return expected(whole, "NAME=VALUE");
	char *end = equals, *value = equals + 1;
	while (end > line && isspace((unsigned char)end[-1]))
		end--;
	*end = '\0';
	while (isspace((unsigned char)*value))
		value++;
	return parse_words(command, whole, line, value);
}

void steering_print(const struct steering_command *c, char text[STEERING_TEXT])
{
	static const char *const pauses[] = {"0", "1", "hold"};
	const size_t size = STEERING_TEXT;
	switch (c->verb) {
	case STEER_PAUSE:
		snprintf(text, size, "pause=%s", pauses[c->pause]);
		return;
	case STEER_STEP:
		snprintf(text, size, "step=%lld", c->steps);
		return;
	case STEER_CHECKPOINT:
	case STEER_STOP:
		snprintf(text, size, "%s=1", c->verb == STEER_STOP ? "stop" : "checkpoint");
		return;
	case STEER_IMAGE:
		snprintf(text, size, "images.%s.every=%.17g", c->name, c->every);
		return;
	case STEER_INSPECT:
		break;
	}
	if (c->target == STEER_POINT)
		snprintf(text, size, "inspect.%s=point:%d", c->name, c->point);
	else if (c->target == STEER_AT)
		snprintf(text, size, "inspect.%s=at:%.17g,%.17g", c->name, c->at[0], c->at[1]);
	else
		snprintf(text, size, "inspect.%s=%s", c->name, c->target == STEER_RULE ? c->rule->name : "none");
}

bool steering_lasts(const struct steering_command *command)
{
	return command->verb == STEER_INSPECT || command->verb == STEER_IMAGE;
}
