#include "io/file.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/error.h"

static int path_too_long(const char *path)
{
	return error_set(STATUS_INPUT, "%.60s...: this path is too long, at most %d bytes are possible", path,
					 FILE_PATH - 1);
}

int file_join(char path[FILE_PATH], const char *folder, const char *name)
{
	size_t length = strlen(folder);
	bool alone = length == 0 || name[0] == '/';
	const char *slash = alone || folder[length - 1] == '/' ? "" : "/";
	int n = snprintf(path, FILE_PATH, "%s%s%s", alone ? "" : folder, slash, name);
	return n < FILE_PATH ? STATUS_OK : path_too_long(folder);
}

int file_folder(char folder[FILE_PATH], const char *path)
{
	const char *slash = strrchr(path, '/');
	size_t length = slash == path ? 1 : slash ? (size_t)(slash - path) : 0;
	if (length >= FILE_PATH)
		return path_too_long(path);
	memcpy(folder, path, length);
	folder[length] = '\0';
	if (length == 0)
		strcpy(folder, ".");
	return STATUS_OK;
}

bool file_exists(const char *path) { return access(path, F_OK) == 0; }

bool file_is_folder(const char *path)
{
	struct stat s;
	return stat(path, &s) == 0 && S_ISDIR(s.st_mode);
}

bool file_has_end(const char *path, const char *end)
{
	size_t n = strlen(path), m = strlen(end);
	return n >= m && strcasecmp(path + n - m, end) == 0;
}

int file_make_folder(const char *path)
{
	char part[FILE_PATH];
	size_t length = strlen(path);
	if (length >= sizeof part)
		return path_too_long(path);
	for (size_t k = 1; k <= length; k++) {
		if (path[k] != '/' && path[k] != '\0')
			continue;
		memcpy(part, path, k);
		part[k] = '\0';
		if (mkdir(part, 0777) == 0 || file_is_folder(part))
			continue;
		int reason = errno;
		return error_set(STATUS_RESOURCE, "cannot make the folder %s: %s", part,
						 strerror(reason == EEXIST ? ENOTDIR : reason));
	}
	return STATUS_OK;
}

int file_temporary(char temporary[FILE_PATH], const char *path)
{
	static atomic_uint counter;
	const char *slash = strrchr(path, '/');
	int folder = slash ? (int)(slash - path) + 1 : 0;
	unsigned k = atomic_fetch_add(&counter, 1);
	int n = snprintf(temporary, FILE_PATH, "%.*s.%s.%ld-%u.tmp", folder, path, path + folder, (long)getpid(), k);
	return n < FILE_PATH ? STATUS_OK : path_too_long(path);
}

/* The process of a name made by file_temporary(), 0 if it is none of those. */
static long temporary_process(const char *name)
{
	if (name[0] != '.' || !file_has_end(name, ".tmp"))
		return 0;
	const char *dot = name + strlen(name) - strlen(".tmp");
	while (dot > name && dot[-1] != '.')
		dot--;
	char *end;
	long process = strtol(dot, &end, 10);
	return end != dot && *end == '-' && process > 0 ? process : 0;
}

static int scratch_name(char path[FILE_PATH], const char *name)
{
	const char *folder = getenv("TMPDIR");
	char pattern[64];
	snprintf(pattern, sizeof pattern, "tmdempm-%.40s-XXXXXX", name);
	return file_join(path, folder && *folder ? folder : "/tmp", pattern);
}

int file_scratch(char path[FILE_PATH], const char *name)
{
	CHECK(scratch_name(path, name));
	int file = mkstemp(path);
	if (file < 0)
		return error_set(STATUS_RESOURCE, "cannot make the temporary file %s: %s", path, strerror(errno));
	close(file);
	return STATUS_OK;
}

int file_scratch_folder(char path[FILE_PATH], const char *name)
{
	CHECK(scratch_name(path, name));
	return mkdtemp(path) ? STATUS_OK
						 : error_set(STATUS_RESOURCE, "cannot make the temporary folder %s: %s", path, strerror(errno));
}

void file_sweep(const char *folder)
{
	DIR *stream = opendir(folder);
	if (!stream)
		return;
	for (struct dirent *entry; (entry = readdir(stream));) {
		long process = temporary_process(entry->d_name);
		if (process && kill((pid_t)process, 0) != 0 && errno == ESRCH)
			unlinkat(dirfd(stream), entry->d_name, 0);
	}
	closedir(stream);
}

/* Some file systems cannot sync a folder (EINVAL); then there is nothing more that could be done. */
static int sync_path(const char *path, int flags)
{
	int fd = open(path, flags | O_CLOEXEC);
	if (fd < 0)
		return error_set(STATUS_RESOURCE, "cannot open %s to sync it: %s", path, strerror(errno));
	int reason = fsync(fd) == 0 || errno == EINVAL || errno == ENOTSUP ? 0 : errno;
	close(fd);
	return reason ? error_set(STATUS_RESOURCE, "cannot sync %s: %s", path, strerror(reason)) : STATUS_OK;
}

int file_publish(const char *temporary, const char *path)
{
	if (rename(temporary, path) == 0)
		return STATUS_OK;
	int reason = errno;
	unlink(temporary);
	return error_set(STATUS_RESOURCE, "cannot write %s: %s", path, strerror(reason));
}

int file_commit(const char *temporary, const char *path)
{
	char folder[FILE_PATH];
	int status = file_folder(folder, path);
	if (status == STATUS_OK)
		status = sync_path(temporary, O_RDONLY);
	if (status != STATUS_OK) {
		unlink(temporary);
		return status;
	}
	CHECK(file_publish(temporary, path));
	return sync_path(folder, O_RDONLY | O_DIRECTORY);
}

int file_output_begin(struct file_output *output, const char *path)
{
	output->stream = NULL;
	output->unsynced = false;
	if (strlen(path) >= sizeof output->path)
		return path_too_long(path);
	strcpy(output->path, path);
	if (file_is_folder(path))
		return error_set(STATUS_RESOURCE, "cannot write %s: it is a folder", path);
	CHECK(file_temporary(output->temporary, path));
	output->stream = fopen(output->temporary, "wxe");
	if (!output->stream)
		return error_set(STATUS_RESOURCE, "cannot write %s: %s", path, strerror(errno));
	return STATUS_OK;
}

int file_output_commit(struct file_output *output)
{
	/* the system's reason was in errno when a write failed; nothing since then sets it to a better one */
	int failed = ferror(output->stream), reason = errno == ENOSPC || errno == EDQUOT || errno == EFBIG ? errno : EIO;
	if (fclose(output->stream) != 0)
		failed = 1, reason = errno;
	output->stream = NULL;
	if (failed) {
		unlink(output->temporary);
		return error_set(STATUS_RESOURCE, "cannot write %s: %s", output->path, strerror(reason));
	}
	return (output->unsynced ? file_publish : file_commit)(output->temporary, output->path);
}

void file_output_abandon(struct file_output *output)
{
	if (!output->stream)
		return;
	fclose(output->stream);
	output->stream = NULL;
	unlink(output->temporary);
}

int file_read(char **text, size_t *size, const char *path)
{
	*text = NULL;
	*size = 0;
	FILE *stream = fopen(path, "re");
	if (!stream)
		return error_set(STATUS_RESOURCE, "cannot read %s: %s", path, strerror(errno));
	size_t capacity = 0;
	for (;;) {
		if (capacity - *size < 2) {
			capacity = capacity ? 2 * capacity : 65536;
			char *larger = realloc(*text, capacity);
			if (!larger) {
				errno = ENOMEM;
				break;
			}
			*text = larger;
		}
		size_t n = fread(*text + *size, 1, capacity - *size - 1, stream);
		*size += n;
		if (n > 0)
			continue;
		if (ferror(stream))
			break;
		fclose(stream);
		(*text)[*size] = '\0';
		return STATUS_OK;
	}
	int reason = errno;
	fclose(stream);
	free(*text);
	*text = NULL;
	return error_set(STATUS_RESOURCE, "cannot read %s: %s", path, strerror(reason));
}

int file_write(const char *path, const void *data, size_t size)
{
	struct file_output output;
	CHECK(file_output_begin(&output, path));
	fwrite(data, 1, size, output.stream);
	return file_output_commit(&output);
}
