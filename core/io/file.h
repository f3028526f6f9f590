/* Files: whole or not at all.
 *
 * Whatever the engine writes appears under its name only when it is complete: it is written under a
 * temporary name in the same folder, synced, renamed, and the folder is synced.  A crash or a full disk
 * leaves the old file (or none) and at most a hidden `.NAME.PID-N.tmp`.
 * All functions return 0 or STATUS_RESOURCE with the system's reason, unless stated otherwise. */
#ifndef TMDEMPM_IO_FILE_H
#define TMDEMPM_IO_FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

enum { FILE_PATH = 4096 }; /* bytes of every path buffer here, with its end */

/* `folder/name` into path[FILE_PATH]; an absolute name or an empty folder gives the name alone.
 * STATUS_INPUT if it does not fit. */
int file_join(char path[FILE_PATH], const char *folder, const char *name);

/* The folder part of a path ("." if it has none) into folder[FILE_PATH]. */
int file_folder(char folder[FILE_PATH], const char *path);

bool file_exists(const char *path);
bool file_is_folder(const char *path);

/* Does the name end in `end` (".h5")?  Lower and upper case are the same. */
bool file_has_end(const char *path, const char *end);

/* mkdir -p; a folder that exists is no error, also when another process makes it at the same time. */
int file_make_folder(const char *path);

/* A fresh hidden name in the folder of `path`, unique among threads and processes; for libraries that
 * open files by name (HDF5).  Finish with file_commit() or unlink(). */
int file_temporary(char temporary[FILE_PATH], const char *path);

/* An empty file, or a folder, for the while, named after `name` in TMPDIR (or /tmp); the caller removes it. */
int file_scratch(char path[FILE_PATH], const char *name);
int file_scratch_folder(char path[FILE_PATH], const char *name);

/* Removes the temporary files of processes that have ended (kill -9, power) from a folder; what cannot be removed
 * stays. */
void file_sweep(const char *folder);

/* Syncs the closed file `temporary`, renames it to `path` and syncs the folder.  On failure the temporary
 * file is removed and `path` is as it was. */
int file_commit(const char *temporary, const char *path);

/* Renames only: whole after a crash of this process, perhaps not after a loss of power.  For files of which a
 * run writes many and could make them again. */
int file_publish(const char *temporary, const char *path);

/* The same for streams. */
struct file_output {
	bool unsynced; /* set it after file_output_begin(): file_publish() will do */
	FILE *stream; /* write here */
	char path[FILE_PATH], temporary[FILE_PATH];
};

int file_output_begin(struct file_output *output, const char *path);
int file_output_commit(struct file_output *output);   /* closes the stream in any case; reports every write error */
void file_output_abandon(struct file_output *output); /* closes and removes; harmless after a commit */

/* A whole file into memory: `size` bytes and a terminating zero; the caller frees *text. */
int file_read(char **text, size_t *size, const char *path);

/* `size` bytes as the whole file `path`. */
int file_write(const char *path, const void *data, size_t size);

#endif
