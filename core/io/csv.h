/* CSV by RFC 4180: cells quoted where they need it, CRLF ends a row, numbers as %.17g (they come back
 * with the same bits).  Header cells read `name [unit]`.  Readers also take LF, spaces around numbers,
 * empty lines and lines that begin with `#`. */
#ifndef TMDEMPM_IO_CSV_H
#define TMDEMPM_IO_CSV_H

#include <stdbool.h>
#include <stddef.h>

/* ---- writing ---- */

struct csv_writer;

/* A file that appears under its name when csv_close() has succeeded (see file.h). */
int csv_create(struct csv_writer **writer, const char *path);

/* A file that grows in place while others read it: every row is handed to the system whole when it ends,
 * so that a reader, or a crash of this process, finds whole rows.  With `append` rows are added to those
 * that are there (csv_cut() first, on a restart), else the file starts empty. */
int csv_open(struct csv_writer **writer, const char *path, bool append);

/* The next cell of the row.  Lack of memory is reported by csv_end_row(). */
void csv_text(struct csv_writer *writer, const char *text);
void csv_name(struct csv_writer *writer, const char *name, const char *unit); /* `name [unit]` */
void csv_number(struct csv_writer *writer, double value);
void csv_integer(struct csv_writer *writer, long long value);

/* A `# text` line; only between rows. */
void csv_comment(struct csv_writer *writer, const char *text);

/* Ends the row.  STATUS_RESOURCE if it could not be written. */
int csv_end_row(struct csv_writer *writer);

/* Makes sure that everything written so far survives a loss of power. */
int csv_sync(struct csv_writer *writer);

/* Closes (and, after csv_create(), renames) and frees the writer, also on failure. */
int csv_close(struct csv_writer *writer);

/* Closes without publishing: after csv_create() nothing is left behind.  NULL is allowed. */
void csv_abandon(struct csv_writer *writer);

/* Keeps the header and the rows whose first column is <= last; drops the others and a last row that was
 * torn by a crash.  `last` is compared exactly: %.17g brings a time back with its bits.
 * A file that is not there is no error. */
int csv_cut(const char *path, double last);

/* ---- reading ---- */

struct csv_table {
	char *path;
	int columns, rows;
	char **names;   /* [columns] header cells as they stand, or NULL if the file has none */
	double *values; /* [rows][columns] */
	int *lines;     /* [rows] line of each row in the file, for messages */
	int n_comments;
	char **comments; /* text after `#`, without line end */
	int *comment_lines;
};

/* Reads a whole table of numbers.  A first row whose first cell is not a number is its header.
 * `expected` says what a row holds ("id,x,y,r") and its commas how many cells; NULL = as many as the first row has.
 * STATUS_INPUT: `file:line: what, what was expected`. */
int csv_read(struct csv_table **table, const char *path, const char *expected);
void csv_table_free(struct csv_table *table);

/* A table of texts with a header. */
struct csv_cells {
	int columns, rows; /* without the header */
	char **cells;      /* [rows][columns] */
	int *lines;        /* [rows] */
	char *text;        /* private: what the cells point into */
};

/* Reads a table whose header has these columns ("time,step,command"; units do not matter), in this order.
 * STATUS_INPUT as above. */
int csv_read_cells(struct csv_cells **table, const char *path, const char *expected);
void csv_cells_free(struct csv_cells *table);

/* Number of the column whose header is `name` or `name [any unit]`, or -1. */
int csv_column(const struct csv_table *table, const char *name);

#endif
