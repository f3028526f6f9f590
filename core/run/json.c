#include "run/json.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static void json_string(FILE *stream, const char *text)
{
	fputc('"', stream);
	for (const unsigned char *c = (const unsigned char *)text; *c; c++) {
		if (*c == '"' || *c == '\\')
			fprintf(stream, "\\%c", *c);
		else if (*c < 0x20)
			fprintf(stream, "\\u%04x", *c);
		else
			fputc(*c, stream);
	}
	fputc('"', stream);
}

static void json_line(struct json *json)
{
	if (!json->pretty)
		return;
	fputc('\n', json->stream);
	for (int i = 0; i < json->depth; i++)
		fputc('\t', json->stream);
}

static void json_member(struct json *json, const char *name)
{
	if (json->filled)
		fputs(json->pretty ? "," : ", ", json->stream);
	if (json->depth > 0)
		json_line(json);
	json->filled = true;
	if (name) {
		json_string(json->stream, name);
		fputs(": ", json->stream);
	}
}

void json_open(struct json *json, const char *name, char bracket)
{
	json_member(json, name);
	fputc(bracket, json->stream);
	json->depth++;
	json->filled = false;
}

void json_close(struct json *json, char bracket)
{
	json->depth--;
	if (json->filled)
		json_line(json);
	fputc(bracket, json->stream);
	json->filled = true;
}

void json_text(struct json *json, const char *name, const char *text)
{
	json_member(json, name);
	if (text)
		json_string(json->stream, text);
	else
		fputs("null", json->stream);
}

void json_number(struct json *json, const char *name, double value)
{
	json_member(json, name);
	if (isfinite(value))
		fprintf(json->stream, "%.10g", value);
	else
		fputs("null", json->stream);
}

void json_integer(struct json *json, const char *name, long long value)
{
	json_member(json, name);
	fprintf(json->stream, "%lld", value);
}

void json_bool(struct json *json, const char *name, bool value)
{
	json_member(json, name);
	fputs(value ? "true" : "false", json->stream);
}

double json_find_number(const char *text, int depth, const char *name)
{
	char line[128] = "\n";
	size_t n = 1;
	while (depth-- > 0 && n < 32)
		line[n++] = '\t';
	n += (size_t)snprintf(line + n, sizeof line - n, "\"%s\": ", name);
	const char *at = strstr(text, line);
	char *end;
	if (!at)
		return NAN;
	double value = strtod(at + n, &end);
	return end == at + n ? NAN : value;
}
