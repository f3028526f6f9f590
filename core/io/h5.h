/* HDF5: whole arrays and attributes, with the system's reason in every message.
 *
 * Files are written under a temporary name (file.h) and appear with h5_commit().  Objects carry no
 * times, so that equal contents are equal bytes.  All functions return 0 or a status:
 * STATUS_RESOURCE when the file system or the library fails, STATUS_INPUT when a file that is read
 * does not hold what is expected. */
#ifndef TMDEMPM_IO_H5_H
#define TMDEMPM_IO_H5_H

#include <hdf5.h>
#include <stdbool.h>

#include "io/file.h"

/* To be called before anything else of the library.  Left alone, it tries at exit to write what a full disk
 * has refused before, and crashes; every file here is closed by the one who opened it. */
void h5_start(void);

struct h5_output {
	hid_t file;
	char path[FILE_PATH], temporary[FILE_PATH];
};

int h5_begin(struct h5_output *output, const char *path);
int h5_commit(struct h5_output *output);
int h5_publish(struct h5_output *output);  /* without waiting for the disk, see file_publish() */
void h5_abandon(struct h5_output *output); /* closes and removes; harmless after a commit */

/* Opens an existing file for reading; close with H5Fclose(). */
int h5_open(hid_t *file, const char *path);

/* Makes the group `name` below `parent`; close with H5Gclose(). */
int h5_group(hid_t *group, hid_t parent, const char *name);

/* The dataset `name` of rank 1 (columns = 0: `rows` values) or rank 2, of a native memory type; groups
 * that its name passes through ("a/b") are made. */
int h5_write(hid_t parent, const char *name, hid_t type, hsize_t rows, hsize_t columns, const void *data);

/* A text as a scalar string dataset. */
int h5_write_text(hid_t parent, const char *name, const char *text);

/* Attributes of the object `object` ("." = parent itself). */
int h5_attribute_text(hid_t parent, const char *object, const char *name, const char *text);
int h5_attribute_number(hid_t parent, const char *object, const char *name, double value);
int h5_attribute_integer(hid_t parent, const char *object, const char *name, long long value);

/* Rows and columns (1 of a dataset of rank 1) of a dataset. */
int h5_size(hid_t parent, const char *name, hsize_t *rows, hsize_t *columns, const char *path);

/* Reads exactly `count` values into data; `path` names the file in messages. */
int h5_read(hid_t parent, const char *name, hid_t type, hsize_t count, void *data, const char *path);
int h5_read_text(hid_t parent, const char *name, char **text, const char *path); /* free() it */
int h5_read_number(hid_t parent, const char *name, double *value, const char *path);
int h5_read_integer(hid_t parent, const char *name, long long *value, const char *path);
int h5_read_attribute_text(hid_t parent, const char *name, char **text, const char *path);
bool h5_has(hid_t parent, const char *name);

/* `parent/name` shows the object `object` of the file `file` (a path relative to this file). */
int h5_link(hid_t parent, const char *name, const char *file, const char *object);

#endif
