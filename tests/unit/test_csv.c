/* CSV files and the atomic writer under them: RFC 4180 there and back, every mistake with its line. */
#include <dirent.h>
#include <fcntl.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#include "base/error.h"
#include "io/csv.h"
#include "io/file.h"

static char folder[] = "/tmp/tmdempm-csv-XXXXXX";

static const char *in_folder(const char *name)
{
	static char path[4][FILE_PATH];
	static int k;
	k = (k + 1) % 4;
	assert_int_equal(file_join(path[k], folder, name), 0);
	return path[k];
}

static char *contents(const char *path)
{
	static char *text;
	size_t size;
	free(text);
	assert_int_equal(file_read(&text, &size, path), 0);
	return text;
}

static void put(const char *path, const char *text) { assert_int_equal(file_write(path, text, strlen(text)), 0); }

static int is_dot(const char *name) { return strcmp(name, ".") == 0 || strcmp(name, "..") == 0; }

/* How many files the folder holds: nothing temporary may be left. */
static int count_files(void)
{
	int n = 0;
	DIR *dir = opendir(folder);
	assert_non_null(dir);
	for (struct dirent *entry; (entry = readdir(dir));)
		n += !is_dot(entry->d_name);
	closedir(dir);
	return n;
}

static void clear(void)
{
	DIR *dir = opendir(folder);
	assert_non_null(dir);
	for (struct dirent *entry; (entry = readdir(dir));)
		if (!is_dot(entry->d_name))
			remove(in_folder(entry->d_name));
	closedir(dir);
}

static int make_folder(void **state)
{
	(void)state;
	return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state)
{
	(void)state;
	clear();
	return rmdir(folder);
}

static void numbers_keep_their_bits(void **state)
{
	(void)state;
	const double values[] = {0.1,      -1.0 / 3.0, 5e-324, 1.7976931348623157e308, -0.0,
							 INFINITY, NAN,        -NAN,   123456789012345678.0};
	enum { N = sizeof values / sizeof *values };
	const char *path = in_folder("numbers.csv");
	struct csv_writer *w;
	assert_int_equal(csv_create(&w, path), 0);
	csv_comment(w, "a line\nof its own");
	for (int k = 0; k < N; k++)
		csv_name(w, "value", "J");
	assert_int_equal(csv_end_row(w), 0);
	for (int k = 0; k < N; k++)
		csv_number(w, values[k]);
	assert_int_equal(csv_end_row(w), 0);
	assert_false(file_exists(path)); /* not there before it is complete */
	assert_int_equal(csv_close(w), 0);

	struct csv_table *t;
	assert_int_equal(csv_read(&t, path, NULL), 0);
	assert_int_equal(t->columns, N);
	assert_int_equal(t->rows, 1);
	assert_int_equal(t->lines[0], 3);
	assert_string_equal(t->comments[0], " a line of its own");
	char *text;
	size_t size;
	assert_int_equal(file_read(&text, &size, path), 0);
	assert_non_null(strstr(text, ",nan,nan,")); /* one word for it, with either sign */
	free(text);
	for (int k = 0; k < N; k++)
		assert_true(isnan(values[k]) ? isnan(t->values[k]) : memcmp(&values[k], &t->values[k], sizeof(double)) == 0);
	csv_table_free(t);
}

static void cells_are_quoted_as_rfc_4180_says(void **state)
{
	(void)state;
	const char *path = in_folder("quoted.csv");
	struct csv_writer *w;
	assert_int_equal(csv_create(&w, path), 0);
	csv_text(w, "a, \"b\"");
	csv_text(w, "two\nlines");
	csv_name(w, "time", "s");
	csv_end_row(w);
	csv_integer(w, -1234567890123LL);
	csv_number(w, 0.5);
	csv_number(w, 2.0);
	csv_end_row(w);
	assert_int_equal(csv_close(w), 0);
	assert_string_equal(contents(path), "\"a, \"\"b\"\"\",\"two\nlines\",time [s]\r\n-1234567890123,0.5,2\r\n");

	struct csv_table *t;
	assert_int_equal(csv_read(&t, path, NULL), 0);
	assert_string_equal(t->names[0], "a, \"b\"");
	assert_string_equal(t->names[1], "two\nlines");
	assert_int_equal(csv_column(t, "time"), 2);
	assert_int_equal(csv_column(t, "tim"), -1);
	assert_int_equal(t->lines[0], 3); /* the header takes two lines */
	csv_table_free(t);
}

static void readers_take_what_people_write(void **state)
{
	(void)state;
	const char *path = in_folder("loose.csv");
	put(path, "# first\n\n  1 , 2e3\r\n#second\r\n\t3,\"4\"\r\r5,6");
	struct csv_table *t;
	assert_int_equal(csv_read(&t, path, "a,b"), 0);
	assert_null(t->names);
	assert_int_equal(t->rows, 3);
	const double expected[] = {1, 2000, 3, 4, 5, 6};
	assert_memory_equal(t->values, expected, sizeof expected);
	assert_int_equal(t->lines[1], 5);
	assert_int_equal(t->n_comments, 2);
	assert_int_equal(t->comment_lines[1], 4);
	assert_string_equal(t->comments[1], "second");
	csv_table_free(t);
	put(path, "");
	assert_int_equal(csv_read(&t, path, NULL), 0);
	assert_int_equal(t->rows, 0);
	csv_table_free(t);
}

static void mistakes_are_told_with_their_line(void **state)
{
	(void)state;
	const struct {
		const char *text, *message;
	} cases[] = {
		{"1,2\n3\n", ":2: 1 cell, expected 2 (a,b)"},
		{"1,2\n3,4,5\n", ":2: 3 cells, expected 2 (a,b)"},
		{"# c\na,b\n1,x2\n", ":3: cell 2 is \"x2\", expected a number"},
		{"1,2\n,4\n", ":2: cell 1 is \"\", expected a number"},
		{"a,b\nc,d\n", ":2: cell 1 is \"c\", expected a number"},
		{"1,\"2\n\n", ":1: a quoted cell does not end, expected a closing \""},
		{"1,\"2\"3\n", ":1: text after a quoted cell, expected a comma or the end of the row"},
		{"1,2 3\n", ":1: cell 2 is \"2 3\", expected a number"},
	};
	const char *path = in_folder("wrong.csv");
	for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
		char expected[FILE_PATH + 200];
		struct csv_table *t;
		put(path, cases[k].text);
		snprintf(expected, sizeof expected, "%s%s", path, cases[k].message);
		assert_int_equal(csv_read(&t, path, "a,b"), STATUS_INPUT);
		assert_null(t);
		assert_string_equal(error_message(), expected);
	}
	struct csv_table *t;
	assert_int_equal(file_write(path, "1,2\n3,\0\n", 8), 0);
	assert_int_equal(csv_read(&t, path, "a,b"), STATUS_INPUT);
	assert_non_null(strstr(error_message(), ":2: a zero byte"));
	assert_int_equal(csv_read(&t, in_folder("absent.csv"), NULL), STATUS_RESOURCE);
	assert_non_null(strstr(error_message(), "absent.csv"));
	assert_int_equal(csv_read(&t, folder, NULL), STATUS_RESOURCE);
}

static void rows_are_there_when_they_end_and_can_be_cut(void **state)
{
	(void)state;
	const char *path = in_folder("history.csv");
	struct csv_writer *w;
	assert_int_equal(csv_open(&w, path, false), 0);
	csv_name(w, "time", "s");
	csv_end_row(w);
	for (int k = 1; k <= 3; k++) {
		csv_number(w, 0.1 * k);
		assert_int_equal(csv_end_row(w), 0);
	}
	csv_number(w, 0.4); /* a row that has not ended is not in the file */
	assert_string_equal(contents(path),
						"time [s]\r\n0.10000000000000001\r\n0.20000000000000001\r\n0.30000000000000004\r\n");
	assert_int_equal(csv_sync(w), 0);
	csv_abandon(w);

	FILE *torn = fopen(path, "a");
	fputs("0.0", torn); /* as a crash in the middle of a write leaves it */
	fclose(torn);
	assert_int_equal(csv_cut(path, 0.2), 0);
	assert_string_equal(contents(path), "time [s]\r\n0.10000000000000001\r\n0.20000000000000001\r\n");
	assert_int_equal(csv_open(&w, path, true), 0);
	csv_number(w, 7.0);
	csv_end_row(w);
	assert_int_equal(csv_close(w), 0);
	assert_string_equal(contents(path), "time [s]\r\n0.10000000000000001\r\n0.20000000000000001\r\n7\r\n");
	assert_int_equal(csv_cut(path, 0.1 * 3), 0);
	assert_int_equal(csv_cut(in_folder("absent.csv"), 1.0), 0);
}

static void failures_leave_the_old_file(void **state)
{
	(void)state;
	clear();
	const char *path = in_folder("kept.csv");
	put(path, "old");
	struct file_output output;
	assert_int_equal(file_output_begin(&output, path), 0);
	fputs("new", output.stream);
	assert_string_equal(contents(path), "old");
	file_output_abandon(&output);
	file_output_abandon(&output);
	assert_string_equal(contents(path), "old");
	assert_int_equal(count_files(), 1);

	/* the stream's descriptor becomes /dev/full: the failure shows only when the buffer is written */
	assert_int_equal(file_output_begin(&output, path), 0);
	int full = open("/dev/full", O_WRONLY);
	assert_true(full >= 0 && dup2(full, fileno(output.stream)) >= 0);
	close(full);
	fputs("new", output.stream);
	assert_int_equal(file_output_commit(&output), STATUS_RESOURCE);
	assert_non_null(strstr(error_message(), "kept.csv"));
	assert_string_equal(contents(path), "old");
	assert_int_equal(count_files(), 1);

	struct csv_writer *w;
	assert_int_equal(csv_create(&w, in_folder("no/such/x.csv")), STATUS_RESOURCE);
	assert_null(w);
	assert_int_equal(csv_create(&w, folder), STATUS_RESOURCE);
	assert_int_equal(csv_open(&w, folder, true), STATUS_RESOURCE);
	assert_int_equal(csv_open(&w, "/dev/full", false), 0);
	csv_number(w, 1.0);
	assert_int_equal(csv_end_row(w), STATUS_RESOURCE);
	assert_int_equal(csv_close(w), STATUS_RESOURCE);
}

static void paths_and_folders(void **state)
{
	(void)state;
	char path[FILE_PATH], long_name[2 * FILE_PATH];
	assert_int_equal(file_join(path, "a/b", "c"), 0);
	assert_string_equal(path, "a/b/c");
	file_join(path, "a/", "c");
	assert_string_equal(path, "a/c");
	file_join(path, "a", "/c");
	assert_string_equal(path, "/c");
	file_join(path, "", "c");
	assert_string_equal(path, "c");
	file_folder(path, "a/b/c");
	assert_string_equal(path, "a/b");
	file_folder(path, "/c");
	assert_string_equal(path, "/");
	file_folder(path, "c");
	assert_string_equal(path, ".");
	memset(long_name, 'x', sizeof long_name);
	long_name[sizeof long_name - 1] = '\0';
	assert_int_equal(file_join(path, "a", long_name), STATUS_INPUT);
	assert_int_equal(file_make_folder(long_name), STATUS_INPUT);
	assert_true(file_has_end("P.H5", ".h5"));
	assert_false(file_has_end("h5", ".h5"));

	snprintf(path, sizeof path, "%s/p/q//r/", folder);
	assert_int_equal(file_make_folder(path), 0);
	assert_int_equal(file_make_folder(path), 0);
	assert_true(file_is_folder(in_folder("p/q/r")));
	put(in_folder("p/file"), "x");
	assert_int_equal(file_make_folder(in_folder("p/file/s")), STATUS_RESOURCE);
	assert_non_null(strstr(error_message(), "p/file: Not a directory"));
	unlink(in_folder("p/file"));
	rmdir(in_folder("p/q/r"));
	rmdir(in_folder("p/q"));
}

/* Temporary files of processes that are gone are swept away; ours, and what only looks like one, stay. */
static void the_dead_leave_nothing(void **state)
{
	(void)state;
	pid_t dead = fork();
	if (dead == 0)
		_exit(0);
	waitpid(dead, NULL, 0);
	char gone[64], ours[64];
	snprintf(gone, sizeof gone, ".a.h5.%ld-3.tmp", (long)dead);
	snprintf(ours, sizeof ours, ".a.h5.%ld-3.tmp", (long)getpid());
	const char *const stays[] = {ours, "a.tmp", ".a.tmp", ".tmp", ".a.12-tmp"};
	put(in_folder(gone), "x");
	for (size_t k = 0; k < sizeof stays / sizeof *stays; k++)
		put(in_folder(stays[k]), "x");
	file_sweep(folder);
	file_sweep("/nowhere");
	assert_false(file_exists(in_folder(gone)));
	for (size_t k = 0; k < sizeof stays / sizeof *stays; k++) {
		assert_true(file_exists(in_folder(stays[k])));
		unlink(in_folder(stays[k]));
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(numbers_keep_their_bits),
		cmocka_unit_test(cells_are_quoted_as_rfc_4180_says),
		cmocka_unit_test(readers_take_what_people_write),
		cmocka_unit_test(mistakes_are_told_with_their_line),
		cmocka_unit_test(rows_are_there_when_they_end_and_can_be_cut),
		cmocka_unit_test(failures_leave_the_old_file),
		cmocka_unit_test(paths_and_folders),
		cmocka_unit_test(the_dead_leave_nothing),
	};
	return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
