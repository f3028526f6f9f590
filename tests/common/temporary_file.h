/* A file of its own for a cmocka program, TEMPORARY_FILE: set-up, tear-down, and writing it anew (after <cmocka.h>). */
#ifndef TESTS_COMMON_TEMPORARY_FILE_H
#define TESTS_COMMON_TEMPORARY_FILE_H

#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

static char path[] = TEMPORARY_FILE;

static int make_file(void **state)
{
	(void)state;
	int file = mkstemp(path);
	return file < 0 ? -1 : close(file);
}

static int remove_file(void **state)
{
	(void)state;
	return unlink(path);
}

static void write_file(const char *text)
{
	FILE *out = fopen(path, "w");
	assert_non_null(out);
	fputs(text, out);
	assert_int_equal(fclose(out), 0);
}

#endif
