/* JSON, written as it comes: objects, arrays, texts, numbers.  NAN and infinity become null. */
#ifndef TMDEMPM_RUN_JSON_H
#define TMDEMPM_RUN_JSON_H

#include <stdbool.h>
#include <stdio.h>

struct json {
	FILE *stream;
	bool pretty; /* a line for each member; else all on one */
	int depth;
	bool filled; /* the open object or array has members already */
};

/* `name` = NULL inside arrays and at the top. */
void json_open(struct json *json, const char *name, char bracket);
void json_close(struct json *json, char bracket);
void json_text(struct json *json, const char *name, const char *text); /* NULL becomes null */
void json_number(struct json *json, const char *name, double value);
void json_integer(struct json *json, const char *name, long long value);
void json_bool(struct json *json, const char *name, bool value);

/* The number that a member holds in a document that was written here with `pretty`: the first of this name at this
 * depth (1 = of the whole); NAN if there is none. */
double json_find_number(const char *text, int depth, const char *name);

#endif
