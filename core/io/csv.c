#include "io/csv.h"

#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/error.h"
#include "io/file.h"

/* ---- writing ---- */

struct csv_writer {
	struct file_output output; /* of csv_create(); output.stream is the stream in both cases */
	bool in_place;
	char *row; /* the row being built */
	size_t length, capacity;
	int cells;
	bool failed; /* memory */
};

static void row_put(struct csv_writer *w, const char *text, size_t n)
{
	if (w->length + n > w->capacity) {
		size_t capacity = 2 * (w->length + n) + 256;
		char *larger = realloc(w->row, capacity);
		if (!larger) {
			w->failed = true;
			return;
		}
		w->row = larger;
		w->capacity = capacity;
	}
	memcpy(w->row + w->length, text, n);
	w->length += n;
}

static void cell_begin(struct csv_writer *w)
{
	if (w->cells++ > 0)
		row_put(w, ",", 1);
}

void csv_text(struct csv_writer *w, const char *text)
{
	cell_begin(w);
	if (!strpbrk(text, ",\"\r\n") && text[0] != '#') {
		row_put(w, text, strlen(text));
		return;
	}
	row_put(w, "\"", 1);
	for (; *text; text++)
		row_put(w, *text == '"' ? "\"\"" : text, *text == '"' ? 2 : 1);
	row_put(w, "\"", 1);
}

void csv_name(struct csv_writer *w, const char *name, const char *unit)
{
	char cell[512];
	snprintf(cell, sizeof cell, "%s [%s]", name, unit);
	csv_text(w, cell);
}

void csv_number(struct csv_writer *w, double value)
{
	char cell[40];
	cell_begin(w);
	if (isnan(value)) /* whatever its sign: printf() would show that */
		row_put(w, "nan", 3);
	else
		row_put(w, cell, (size_t)snprintf(cell, sizeof cell, "%.17g", value));
}

void csv_integer(struct csv_writer *w, long long value)
{
	char cell[40];
	cell_begin(w);
	row_put(w, cell, (size_t)snprintf(cell, sizeof cell, "%lld", value));
}

void csv_comment(struct csv_writer *w, const char *text)
{
	row_put(w, "# ", 2);
	for (; *text; text++) /* a comment is one line */
		row_put(w, *text == '\n' || *text == '\r' ? " " : text, 1);
	csv_end_row(w); /* a failure stays in the stream and is reported by the next row or the close */
}

static int write_failed(const struct csv_writer *w, int reason)
{
	return error_set(STATUS_RESOURCE, "cannot write %s: %s", w->output.path, strerror(reason));
}

int csv_end_row(struct csv_writer *w)
{
	row_put(w, "\r\n", 2);
	size_t n = w->length;
	w->length = 0;
	w->cells = 0;
	if (w->failed)
		return write_failed(w, ENOMEM);
	if (fwrite(w->row, 1, n, w->output.stream) != n || (w->in_place && fflush(w->output.stream) != 0))
		return write_failed(w, errno);
	return STATUS_OK;
}

int csv_sync(struct csv_writer *w)
{
	if (fflush(w->output.stream) != 0 || (fsync(fileno(w->output.stream)) != 0 && errno != EINVAL))
		return write_failed(w, errno);
	return STATUS_OK;
}

static int writer_new(struct csv_writer **writer)
{
	*writer = calloc(1, sizeof **writer);
	return *writer ? STATUS_OK : error_set(STATUS_RESOURCE, "no memory for a CSV writer");
}

int csv_create(struct csv_writer **writer, const char *path)
{
	CHECK(writer_new(writer));
	int status = file_output_begin(&(*writer)->output, path);
	if (status != STATUS_OK) {
		free(*writer);
		*writer = NULL;
	}
	return status;
}

int csv_open(struct csv_writer **writer, const char *path, bool append)
{
	CHECK(writer_new(writer));
	struct csv_writer *w = *writer;
	w->in_place = true;
	int n = snprintf(w->output.path, sizeof w->output.path, "%s", path);
	errno = ENAMETOOLONG;
	w->output.stream = n < FILE_PATH ? fopen(path, append ? "ae" : "we") : NULL;
	if (w->output.stream) {
		/* a row reaches the system in one write, whatever its length */
		setvbuf(w->output.stream, NULL, _IOFBF, 1 << 16);
		return STATUS_OK;
	}
	int status = write_failed(w, errno);
	free(w);
	*writer = NULL;
	return status;
}

static void writer_free(struct csv_writer *w)
{
	free(w->row);
	free(w);
}

int csv_close(struct csv_writer *w)
{
	int status = STATUS_OK;
	if (w->failed) {
		status = write_failed(w, ENOMEM);
		csv_abandon(w);
		return status;
	}
	if (w->in_place) {
		bool failed = ferror(w->output.stream);
		if (fclose(w->output.stream) != 0)
			status = write_failed(w, errno);
		else if (failed)
			status = write_failed(w, EIO);
	} else {
		status = file_output_commit(&w->output);
	}
	writer_free(w);
	return status;
}

void csv_abandon(struct csv_writer *w)
{
	if (!w)
		return;
	if (w->in_place)
		fclose(w->output.stream);
	else
		file_output_abandon(&w->output);
	writer_free(w);
}

/* ---- reading, one row at a time ---- */

struct cursor {
	const char *path;
	char *at, *end; /* rest of the text; *end is a zero byte */
	int line;       /* of `at` */
	char **cells;   /* of the last row */
	int n_cells, capacity;
};

static int row_error(const struct cursor *c, int line, const char *format, ...) __attribute__((format(printf, 3, 4)));

static int row_error(const struct cursor *c, int line, const char *format, ...)
{
	char text[1024];
	va_list args;
	va_start(args, format);
	vsnprintf(text, sizeof text, format, args);
	va_end(args);
	return error_set(STATUS_INPUT, "%s:%d: %s", c->path, line, text);
}

/* CR and CRLF become LF, so that the parser knows one line end only. */
static void unify_line_ends(char *text, size_t *size)
{
	size_t n = 0;
	for (size_t k = 0; k < *size; k++) {
		bool crlf = text[k] == '\r' && k + 1 < *size && text[k + 1] == '\n';
		if (!crlf)
			text[n++] = text[k] == '\r' ? '\n' : text[k];
	}
	text[n] = '\0';
	*size = n;
}

static bool is_blank(char c) { return c == ' ' || c == '\t'; }

/* Unquotes in place the cell that begins with the quote at c->at; leaves the cursor behind it. */
static int cell_unquote(struct cursor *c, char **cell)
{
	int line = c->line;
	char *from = c->at + 1, *to = from;
	*cell = to;
	for (; from < c->end && !(from[0] == '"' && from[1] != '"'); from++) {
		from += *from == '"';
		c->line += *from == '\n';
		*to++ = *from;
	}
	if (from >= c->end)
		return row_error(c, line, "a quoted cell does not end, expected a closing \"");
	for (from++; is_blank(*from);)
		from++;
	if (from < c->end && *from != ',' && *from != '\n')
		return row_error(c, c->line, "text after a quoted cell, expected a comma or the end of the row");
	*to = '\0';
	c->at = from;
	return STATUS_OK;
}

/* Takes the cell at the cursor, without blanks around it, and steps over its comma or line end. */
static int cell_next(struct cursor *c, char **cell, bool *last)
{
	char *to = NULL;
	while (is_blank(*c->at))
		c->at++;
	if (*c->at == '"') {
		CHECK(cell_unquote(c, cell));
	} else {
		*cell = c->at;
		c->at += strcspn(c->at, ",\n");
		if (c->at < c->end && !*c->at)
			return row_error(c, c->line, "a zero byte, expected text");
		for (to = c->at; to > *cell && is_blank(to[-1]);)
			to--;
	}
	*last = *c->at != ',';
	if (c->at < c->end) {
		c->line += *c->at == '\n';
		c->at++;
	}
	if (to)
		*to = '\0';
	return STATUS_OK;
}

static int row_next(struct cursor *c)
{
	bool last = false;
	c->n_cells = 0;
	while (!last) {
		if (c->n_cells == c->capacity) {
			c->capacity = 2 * c->capacity + 32;
			char **larger = realloc(c->cells, (size_t)c->capacity * sizeof *larger);
			if (!larger)
				return error_set(STATUS_RESOURCE, "no memory to read %s", c->path);
			c->cells = larger;
		}
		CHECK(cell_next(c, &c->cells[c->n_cells], &last));
		c->n_cells++;
	}
	return STATUS_OK;
}

static bool parse_number(const char *cell, double *value)
{
	char *end;
	*value = strtod(cell, &end);
	return end != cell && *end == '\0';
}

/* ---- tables ---- */

void csv_table_free(struct csv_table *t)
{
	if (!t)
		return;
	for (int k = 0; t->names && k < t->columns; k++)
		free(t->names[k]);
	for (int k = 0; k < t->n_comments; k++)
		free(t->comments[k]);
	free(t->path);
	free(t->names);
	free(t->values);
	free(t->lines);
	free(t->comments);
	free(t->comment_lines);
	free(t);
}

/* Makes room for one more of `size` bytes; the capacity doubles at powers of two. */
static int grow(void *array, int n, size_t size)
{
	void **p = array;
	if (n > 0 && (n & (n - 1)) != 0)
		return STATUS_OK;
	void *larger = realloc(*p, (n ? 2 * (size_t)n : 1) * size);
	if (!larger)
		return error_set(STATUS_RESOURCE, "no memory to read a CSV file");
	*p = larger;
	return STATUS_OK;
}

static int table_comment(struct csv_table *t, struct cursor *c)
{
	CHECK(grow(&t->comments, t->n_comments, sizeof *t->comments));
	CHECK(grow(&t->comment_lines, t->n_comments, sizeof *t->comment_lines));
	size_t n = strcspn(c->at, "\n");
	char *text = strndup(c->at + 1, n - 1);
	if (!text)
		return error_set(STATUS_RESOURCE, "no memory to read a CSV file");
	t->comments[t->n_comments] = text;
	t->comment_lines[t->n_comments++] = c->line++;
	c->at += n + (c->at[n] == '\n');
	return STATUS_OK;
}

static int table_header(struct csv_table *t, const struct cursor *c)
{
	t->names = calloc((size_t)t->columns, sizeof *t->names);
	for (int k = 0; k < t->columns; k++)
		if (!t->names || !(t->names[k] = strdup(c->cells[k])))
			return error_set(STATUS_RESOURCE, "no memory to read a CSV file");
	return STATUS_OK;
}

static int table_row(struct csv_table *t, const struct cursor *c, int line)
{
	CHECK(grow(&t->values, t->rows, (size_t)t->columns * sizeof *t->values));
	CHECK(grow(&t->lines, t->rows, sizeof *t->lines));
	for (int k = 0; k < t->columns; k++)
		if (!parse_number(c->cells[k], &t->values[(size_t)t->rows * (size_t)t->columns + (size_t)k]))
			return row_error(c, line, "cell %d is \"%.40s\", expected a number", k + 1, c->cells[k]);
	t->lines[t->rows++] = line;
	return STATUS_OK;
}

static int table_line(struct csv_table *t, struct cursor *c, const char *expected)
{
	double number;
	int line = c->line;
	if (*c->at == '#')
		return table_comment(t, c);
	CHECK(row_next(c));
	if (c->n_cells == 1 && !c->cells[0][0])
		return STATUS_OK; /* an empty line */
	if (t->columns == 0)
		t->columns = c->n_cells;
	if (c->n_cells != t->columns)
		return row_error(c, line, "%d cell%s, expected %d%s%s%s", c->n_cells, c->n_cells == 1 ? "" : "s", t->columns,
						 expected ? " (" : " as in the rows above", expected ? expected : "", expected ? ")" : "");
	if (t->rows == 0 && !t->names && !parse_number(c->cells[0], &number))
		return table_header(t, c);
	return table_row(t, c, line);
}

int csv_read(struct csv_table **table, const char *path, const char *expected)
{
	char *text;
	size_t size;
	*table = NULL;
	CHECK(file_read(&text, &size, path));
	unify_line_ends(text, &size);
	struct csv_table *t = calloc(1, sizeof *t);
	struct cursor c = {.path = path, .at = text, .end = text + size, .line = 1};
	int status = STATUS_OK;
	if (!t || !(t->path = strdup(path)))
		status = error_set(STATUS_RESOURCE, "no memory to read %s", path);
	for (const char *e = expected; status == STATUS_OK && e; e = strchr(e + 1, ','))
		t->columns++;
	while (status == STATUS_OK && c.at < c.end)
		status = table_line(t, &c, expected);
	free(c.cells);
	free(text);
	if (status == STATUS_OK)
		*table = t;
	else
		csv_table_free(t);
	return status;
}

int csv_column(const struct csv_table *t, const char *name)
{
	size_t n = strlen(name);
	for (int k = 0; t->names && k < t->columns; k++)
		if (strncmp(t->names[k], name, n) == 0 && (!t->names[k][n] || strncmp(t->names[k] + n, " [", 2) == 0))
			return k;
	return -1;
}

/* ---- texts ---- */

void csv_cells_free(struct csv_cells *t)
{
	if (!t)
		return;
	free(t->cells);
	free(t->lines);
	free(t->text);
	free(t);
}

/* Does the header have the columns of `expected`? */
static bool cells_header(const struct cursor *c, const char *expected)
{
	for (int k = 0; k < c->n_cells; k++) {
		size_t n = strcspn(expected, ",");
		const char *rest = c->cells[k] + n;
		if (strncmp(c->cells[k], expected, n) != 0 || (*rest && strncmp(rest, " [", 2) != 0))
			return false;
		expected += n + (expected[n] == ',' && k + 1 < c->n_cells);
	}
	return !*expected;
}

static int cells_line(struct csv_cells *t, struct cursor *c, const char *expected)
{
	int line = c->line;
	if (*c->at == '#') {
		size_t n = strcspn(c->at, "\n");
		c->at += n + (c->at[n] == '\n'), c->line++;
		return STATUS_OK;
	}
	CHECK(row_next(c));
	if (c->n_cells == 1 && !c->cells[0][0])
		return STATUS_OK;
	if (!t->columns)
		return t->columns = c->n_cells,
			   cells_header(c, expected) ? STATUS_OK : row_error(c, line, "expected the columns %s", expected);
	if (c->n_cells != t->columns)
		return row_error(c, line, "%d cells, expected %d (%s)", c->n_cells, t->columns, expected);
	for (int k = 0; k < t->columns; k++) {
		CHECK(grow(&t->cells, t->rows * t->columns + k, sizeof *t->cells));
		t->cells[t->rows * t->columns + k] = c->cells[k];
	}
	CHECK(grow(&t->lines, t->rows, sizeof *t->lines));
	t->lines[t->rows++] = line;
	return STATUS_OK;
}

int csv_read_cells(struct csv_cells **table, const char *path, const char *expected)
{
	size_t size;
	struct csv_cells *t = calloc(1, sizeof *t);
	*table = NULL;
	if (!t)
		return error_set(STATUS_RESOURCE, "no memory to read %s", path);
	int status = file_read(&t->text, &size, path);
	if (status != STATUS_OK) {
		free(t);
		return status;
	}
	unify_line_ends(t->text, &size);
	struct cursor c = {.path = path, .at = t->text, .end = t->text + size, .line = 1};
	while (status == STATUS_OK && c.at < c.end)
		status = cells_line(t, &c, expected);
	if (status == STATUS_OK && !t->columns)
		status = row_error(&c, 1, "is empty, expected the columns %s", expected);
	free(c.cells);
	if (status == STATUS_OK)
		*table = t;
	else
		csv_cells_free(t);
	return status;
}

/* ---- cutting ---- */

/* Length of the line at `text`, with its end; 0 if it has none. */
static size_t line_length(const char *text)
{
	const char *end = strchr(text, '\n');
	return end ? (size_t)(end - text) + 1 : 0;
}

int csv_cut(const char *path, double last)
{
	char *text;
	size_t size, kept = 0, length;
	if (!file_exists(path))
		return STATUS_OK;
	CHECK(file_read(&text, &size, path));
	for (char *at = text; (length = line_length(at)) > 0; at += length) {
		char *end;
		double first = strtod(at, &end);
		bool number = end != at && (*end == ',' || *end == '\r' || *end == '\n');
		if (number && !(first <= last))
			continue;
		memmove(text + kept, at, length);
		kept += length;
	}
	int status = kept < size ? file_write(path, text, kept) : STATUS_OK;
	free(text);
	return status;
}
