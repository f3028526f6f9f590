#include <ctype.h>
#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "scene/private.h"

enum { FILE_BYTES_MAX = 1 << 24, TEXT_BYTES_MAX = 1 << 26, INCLUDES_MAX = 16, NESTING_MAX = 64 };

struct name_list {
	int n, capacity;
	struct {
		const char *name;
		struct scene_place place;
	} * names;
};

/* An open bracket, and the names already used in it if it is a group. */
struct level {
	char bracket;
	struct scene_place place;
	struct name_list names;
};

enum array_kind { ARRAY_AS_WRITTEN, ARRAY_OF_INT64, ARRAY_OF_FLOATS };

/* The text being put together, over all files included in each other. */
struct assembly {
	struct loader *loader;
	struct source *source;
	size_t bytes, capacity;
	int depth; /* of includes */
	const char *including[INCLUDES_MAX];
	int n_levels;
	struct level levels[NESTING_MAX];
	enum array_kind array;
	bool fatal; /* the text cannot be parsed */
};

/* One file (or a piece of text) on its way into the assembly. */
struct reader {
	const char *at, *end;
	struct scene_place place;
	bool fixed;      /* a piece of text: its place does not advance */
	bool line_empty; /* nothing but blanks so far on this line */
	char before;     /* the last character that was neither blank nor comment */
};

char *path_beside(struct loader *loader, const char *file, const char *name)
{
	const char *slash = name[0] == '/' ? NULL : strrchr(file, '/');
	size_t folder = slash ? (size_t)(slash - file) + 1 : 0;
	char *path = scene_alloc(loader, folder + strlen(name) + 1);
	memcpy(path, file, folder);
	memcpy(path + folder, name, strlen(name) + 1);
	return path;
}

/* ---- output ---- */

static void put(struct assembly *a, char c)
{
	if (a->bytes + 2 > a->capacity) {
		a->capacity = a->capacity ? 2 * a->capacity : 4096;
		char *grown = loader_alloc(a->loader, a->capacity);
		if (a->bytes)
			memcpy(grown, a->source->text, a->bytes);
		a->source->text = grown;
	}
	a->source->text[a->bytes++] = c;
	a->source->text[a->bytes] = '\0';
}

static void put_text(struct assembly *a, const char *from, size_t n)
{
	for (size_t k = 0; k < n; k++)
		put(a, from[k]);
}

static void end_line(struct assembly *a, struct scene_place place)
{
	struct source *s = a->source;
	s->places = loader_grow(a->loader, s->places, s->n_lines, &s->capacity, sizeof *s->places);
	s->places[s->n_lines++] = place;
	put(a, '\n');
}

#define FATAL(a, r, ...) ((a)->fatal = true, problem_at((a)->loader, (r)->place, "", __VA_ARGS__))

/* ---- names and brackets ---- */

static void open_bracket(struct assembly *a, struct reader *r, char c)
{
	if (a->n_levels == NESTING_MAX) {
		FATAL(a, r, "brackets nested deeper than %d, expected a %s", NESTING_MAX, a->loader->kind->name);
		r->at = r->end;
		return;
	}
	a->levels[a->n_levels++] = (struct level){.bracket = c, .place = r->place};
}

static void close_bracket(struct assembly *a, struct reader *r, char c, int base)
{
	char open = c == '}' ? '{' : c == ')' ? '(' : '[';
	if (a->n_levels == base) {
		FATAL(a, r, "'%c' closes nothing, expected '%c' before it", c, open);
		return;
	}
	struct level *level = &a->levels[--a->n_levels];
	if (level->bracket != open) {
		FATAL(a, r, "'%c' closes the '%c' of %s:%d, expected '%c'", c, level->bracket, level->place.file,
			  level->place.line,
			  level->bracket == '{'   ? '}'
			  : level->bracket == '(' ? ')'
									  : ']');
		r->at = r->end; /* what follows would be misread */
	}
}

/* Is this name the left side of an assignment? */
static bool assigns(const char *at, const char *end)
{
	while (at < end && isspace((unsigned char)*at))
		at++;
	return at < end && (*at == '=' || *at == ':');
}

static void note_name(struct assembly *a, struct reader *r, const char *name, size_t length)
{
	struct name_list *list = &a->levels[a->n_levels - 1].names;
	for (int k = 0; k < list->n; k++)
		if (strlen(list->names[k].name) == length && !memcmp(list->names[k].name, name, length)) {
			struct scene_place first = list->names[k].place;
			problem_at(a->loader, r->place, "", "'%.*s' is defined twice, expected once (first at %s:%d)", (int)length,
					   name, first.file, first.line);
			char mark[48];
			put_text(a, mark, (size_t)snprintf(mark, sizeof mark, DUPLICATE_MARK "%d", a->loader->n_problems));
			return;
		}
	list->names = loader_grow(a->loader, list->names, list->n, &list->capacity, sizeof *list->names);
	char *copy = loader_alloc(a->loader, length + 1);
	memcpy(copy, name, length);
	list->names[list->n].name = copy, list->names[list->n].place = r->place, list->n++;
}

static void copy_name(struct assembly *a, struct reader *r)
{
	const char *start = r->at;
	while (r->at < r->end && (isalnum((unsigned char)*r->at) || strchr("-_*", *r->at)) && *r->at)
		r->at++;
	size_t length = (size_t)(r->at - start);
	put_text(a, start, length);
	if (assigns(r->at, r->end))
		note_name(a, r, start, length);
	else if (!(length == 4 && !strncasecmp(start, "true", 4)) && !(length == 5 && !strncasecmp(start, "false", 5)))
		FATAL(a, r, "'%.*s' is no value, expected a number, true, false, a \"string\" or name = value", (int)length,
			  start);
}

/* ---- numbers ---- */

/* Length of the number at `at`, 0 if it is none. */
static size_t scan_number(const char *at, const char *end, bool *is_float, bool *is_hex, size_t *suffix)
{
	const char *p = at;
	*is_float = *is_hex = false, *suffix = 0;
	if (p < end && (*p == '+' || *p == '-'))
		p++;
	if (end - p > 2 && p[0] == '0' && (p[1] == 'x' || p[1] == 'X') && isxdigit((unsigned char)p[2])) {
		*is_hex = true;
		for (p += 2; p < end && isxdigit((unsigned char)*p); p++)
			;
	} else {
		const char *digits = p;
		while (p < end && isdigit((unsigned char)*p))
			p++;
		bool any = p > digits;
		if (p < end && *p == '.') {
			*is_float = true;
			for (p++; p < end && isdigit((unsigned char)*p); p++)
				any = true;
		}
		if (!any)
			return 0;
		if (p < end && (*p == 'e' || *p == 'E')) {
			const char *e = p + 1;
			if (e < end && (*e == '+' || *e == '-'))
				e++;
			if (e < end && isdigit((unsigned char)*e)) {
				*is_float = true;
				for (p = e; p < end && isdigit((unsigned char)*p); p++)
					;
			}
		}
	}
	while (!*is_float && p < end && *p == 'L' && *suffix < 2)
		p++, ++*suffix;
	return (size_t)(p - at);
}

/* libconfig wraps integers beyond 32 bits silently: write those that fit 64 bits with their suffix, refuse the rest.
 * An array must be of one type for libconfig: [0, 0.5] becomes [0.0, 0.5]. */
static void copy_number(struct assembly *a, struct reader *r, size_t length, bool is_float, bool is_hex, size_t suffix)
{
	char text[128];
	put_text(a, r->at, length - suffix);
	if (!is_float) {
		if (length - suffix >= sizeof text) {
			FATAL(a, r, "a number of %zu digits, expected a shorter one", length);
			r->at += length;
			return;
		}
		memcpy(text, r->at, length - suffix), text[length - suffix] = '\0';
		errno = 0;
		long long value = strtoll(text, NULL, is_hex ? 16 : 10);
		if (errno == ERANGE || (is_hex && text[0] == '-'))
			FATAL(a, r, "integer %s does not fit 64 bits, expected %lld to %lld (or a number with a point)", text,
				  LLONG_MIN, LLONG_MAX);
		else if (a->array == ARRAY_OF_FLOATS && !is_hex)
			put_text(a, ".0", 2);
		else if (suffix || a->array == ARRAY_OF_INT64 || value > INT32_MAX || value < INT32_MIN)
			put(a, 'L');
	}
	r->at += length;
	const char *rest = r->at;
	while (r->at < r->end && (isalnum((unsigned char)*r->at) || *r->at == '_'))
		r->at++;
	if (r->at > rest)
		FATAL(a, r, "'%.*s' is no number, expected digits such as 1.5e-3",
			  (int)(r->at - rest + (length < 40 ? (long)length : 40)), rest - (length < 40 ? length : 40));
}

/* What the numbers of the array that begins here have in common. */
static enum array_kind scan_array(const char *at, const char *end)
{
	enum array_kind kind = ARRAY_AS_WRITTEN;
	while (at < end && *at != ']' && *at != '"') {
		bool is_float, is_hex;
		size_t suffix, length = 0;
		if (*at == '#' || (*at == '/' && at + 1 < end && at[1] == '/'))
			while (at < end && *at != '\n')
				at++;
		else
			length = scan_number(at, end, &is_float, &is_hex, &suffix);
		if (length && is_float)
			return ARRAY_OF_FLOATS;
		if (length) {
			char text[32] = "99999999999"; /* whatever is longer than this needs 64 bits too */
			if (length < sizeof text)
				memcpy(text, at, length), text[length] = '\0';
			long long value = strtoll(text, NULL, is_hex ? 16 : 10);
			if (suffix || value > INT32_MAX || value < INT32_MIN)
				kind = ARRAY_OF_INT64;
		}
		at += length ? length : at < end;
	}
	return kind;
}

/* ---- strings, comments, includes ---- */

static void copy_string(struct assembly *a, struct reader *r)
{
	const char *start = r->at++;
	while (r->at < r->end && *r->at != '"' && *r->at != '\n')
		r->at += *r->at == '\\' && r->at + 1 < r->end && r->at[1] != '\n' ? 2 : 1;
	if (r->at >= r->end || *r->at != '"') {
		FATAL(a, r, "a string is not closed on its line, expected '\"'");
		return;
	}
	r->at++;
	put_text(a, start, (size_t)(r->at - start));
}

/* Comments become blanks; line ends stay. */
static void skip_comment(struct assembly *a, struct reader *r)
{
	if (*r->at == '#' || r->at[1] == '/') {
		while (r->at < r->end && *r->at != '\n')
			r->at++;
		return;
	}
	struct scene_place start = r->place;
	for (r->at += 2; r->end - r->at >= 2 && !(r->at[0] == '*' && r->at[1] == '/'); r->at++)
		if (*r->at == '\n') {
			end_line(a, r->place);
			r->place.line += !r->fixed;
			r->line_empty = true;
		}
	if (r->end - r->at < 2) {
		r->place = start, r->at = r->end;
		FATAL(a, r, "a comment is not closed, expected '*/'");
	} else {
		r->at += 2;
		put(a, ' ');
	}
}

static bool assemble_file(struct assembly *a, const char *path, struct scene_place from);

static void include(struct assembly *a, struct reader *r)
{
	const char *line_end = memchr(r->at, '\n', (size_t)(r->end - r->at));
	if (!line_end)
		line_end = r->end;
	const char *open = r->at + strlen("@include");
	while (open < line_end && (*open == ' ' || *open == '\t'))
		open++;
	const char *close = open < line_end && *open == '"' ? memchr(open + 1, '"', (size_t)(line_end - open - 1)) : NULL;
	const char *rest = close ? close + 1 : NULL;
	while (rest && rest < line_end && isspace((unsigned char)*rest))
		rest++;
	if (!r->line_empty || !close || close == open + 1 || (rest < line_end && *rest != '#' && *rest != '/')) {
		FATAL(a, r, "@include is not understood, expected a line of its own: @include \"file.cfg\"");
	} else {
		size_t length = (size_t)(close - open - 1);
		char *name = loader_alloc(a->loader, length + 1);
		memcpy(name, open + 1, length);
		if (a->source->text && a->bytes && a->source->text[a->bytes - 1] != '\n')
			end_line(a, r->place);
		assemble_file(a, path_beside(a->loader, r->place.file, name), r->place);
	}
	r->at = line_end;
}

/* ---- one file ---- */

static void assemble(struct assembly *a, struct reader *r)
{
	int base = a->n_levels;
	open_bracket(a, r, 'f');            /* names of the file itself... */
	if (base > 0 && a->n_levels > base) /* ...which are those of the place that includes it */
		a->levels[base].names = a->levels[base - 1].names;
	while (r->at < r->end) {
		char c = *r->at;
		bool is_float, is_hex, blank = false;
		size_t suffix, length;
		if (c == '\n') {
			end_line(a, r->place);
			r->place.line += !r->fixed;
			r->line_empty = true, r->at++;
			continue;
		}
		if (c == ' ' || c == '\t' || c == '\r' || c == '\f') {
			put(a, ' '), r->at++, blank = true;
		} else if (c == '#' || (c == '/' && r->end - r->at > 1 && (r->at[1] == '/' || r->at[1] == '*'))) {
			skip_comment(a, r), blank = true;
		} else if (c == '"') {
			if (!(r->before ? strchr("=:,(\"[", r->before) != NULL : a->n_levels > 1))
				FATAL(a, r, "a string has no meaning here, expected name = \"value\" or a comma before it");
			copy_string(a, r);
		} else if (c == '@') {
			include(a, r), blank = true;
		} else if (isalpha((unsigned char)c) || c == '*') {
			copy_name(a, r);
		} else if ((length = scan_number(r->at, r->end, &is_float, &is_hex, &suffix))) {
			copy_number(a, r, length, is_float, is_hex, suffix);
		} else if (strchr("{([", c) && c) {
			put(a, c), r->at++;
			if (c == '[')
				a->array = scan_array(r->at, r->end);
			open_bracket(a, r, c);
		} else if (strchr("})]", c) && c) {
			if (r->before == ',')
				FATAL(a, r, "',' before '%c', expected a value or no comma", c);
			put(a, c), r->at++;
			a->array = ARRAY_AS_WRITTEN;
			close_bracket(a, r, c, base + 1);
		} else if (strchr("=:;,", c) && c) {
			put(a, c), r->at++;
		} else {
			if (isprint((unsigned char)c))
				FATAL(a, r, "'%c' has no meaning here, expected name = value", c);
			else
				FATAL(a, r, "byte 0x%02x has no meaning here, expected text", (unsigned char)c);
			/* one message for a run of rubbish is enough */
			while (r->at < r->end && *r->at != '\n')
				r->at++;
		}
		if (!blank)
			r->line_empty = false, r->before = c;
	}
	if (a->n_levels > base + 1 && !a->fatal) {
		const struct level *level = &a->levels[a->n_levels - 1];
		a->fatal = true;
		problem_at(a->loader, level->place, "", "'%c' is never closed, expected '%c' before the end of the file",
				   level->bracket,
				   level->bracket == '{'   ? '}'
				   : level->bracket == '(' ? ')'
										   : ']');
	}
	if (a->n_levels > base && base > 0)
		a->levels[base - 1].names = a->levels[base].names;
	a->n_levels = base;
	end_line(a, r->place);
}

/* The whole file in scratch memory, or NULL with the reason in errno (EFBIG: too large). */
static char *slurp(struct loader *loader, const char *path, size_t *bytes)
{
	FILE *in = fopen(path, "rb");
	if (!in)
		return NULL;
	loader->stream = in;
	size_t n = 0, capacity = 1 << 14;
	char *text = loader_alloc(loader, capacity + 1);
	for (;;) {
		n += fread(text + n, 1, capacity - n, in);
		if (n < capacity || capacity >= FILE_BYTES_MAX)
			break;
		char *grown = loader_alloc(loader, 2 * capacity + 1);
		memcpy(grown, text, n);
		text = grown, capacity *= 2;
	}
	int failure = ferror(in) ? errno : n >= FILE_BYTES_MAX ? EFBIG : 0;
	loader->stream = NULL;
	fclose(in);
	errno = failure;
	*bytes = n;
	return failure ? NULL : text;
}

static bool assemble_file(struct assembly *a, const char *path, struct scene_place from)
{
	struct loader *loader = a->loader;
	struct reader at_from = {.place = from};
	for (int k = 0; k < a->depth; k++)
		if (!strcmp(a->including[k], path)) {
			FATAL(a, &at_from, "'%s' includes itself, expected an end", path);
			return false;
		}
	if (a->depth == INCLUDES_MAX || a->bytes > TEXT_BYTES_MAX) {
		FATAL(a, &at_from, "too many @include, expected at most %d in each other and %d MB in all", INCLUDES_MAX,
			  TEXT_BYTES_MAX >> 20);
		return false;
	}
	size_t bytes = 0;
	char *text = slurp(loader, path, &bytes);
	if (!text) {
		loader->unreadable |= errno != ENOENT && errno != ENOTDIR && errno != EISDIR && errno != EFBIG;
		FATAL(a, &at_from, "cannot read '%s' (%s), expected a %s file", path, strerror(errno), loader->kind->name);
		return false;
	}
	const char *file = scene_string(loader, path);
	loader->files = loader_grow(loader, loader->files, loader->n_files, &loader->capacity_files, sizeof *loader->files);
	loader->files[loader->n_files++] = file;
	struct reader r = {.at = text, .end = text + bytes, .place = {file, 1}, .line_empty = true};
	if (bytes >= 3 && !memcmp(text, "\xef\xbb\xbf", 3)) /* byte order mark */
		r.at += 3;
	a->including[a->depth++] = path;
	assemble(a, &r);
	a->depth--;
	return true;
}

bool source_read(struct loader *loader, const char *path, struct scene_place from, struct source *source)
{
	struct assembly *a = loader_alloc(loader, sizeof *a);
	memset(source, 0, sizeof *source);
	a->loader = loader, a->source = source;
	return assemble_file(a, path, from) && !a->fatal;
}

bool source_text(struct loader *loader, const char *text, struct scene_place place, struct source *source)
{
	struct assembly *a = loader_alloc(loader, sizeof *a);
	struct reader r = {.at = text, .end = text + strlen(text), .place = place, .fixed = true};
	memset(source, 0, sizeof *source);
	a->loader = loader, a->source = source;
	assemble(a, &r);
	return !a->fatal;
}
