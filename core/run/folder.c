#include "run/folder.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/error.h"

int folder_name(char folder[FILE_PATH], const char *out, const char *restart, const char *scene_path)
{
	if (out)
		return file_join(folder, "", out);
	if (restart)
		return file_folder(folder, restart);
	const char *name = strrchr(scene_path, '/');
	name = name ? name + 1 : scene_path;
	const char *end = strrchr(name, '.');
	int length = end && end != name ? (int)(end - name) : (int)strlen(name);
	if (snprintf(folder, FILE_PATH, "%.*s.out", length, name) >= FILE_PATH)
		return error_set(STATUS_INPUT, "%s: the name is too long", scene_path);
	return STATUS_OK;
}

/* 1 if the folder is there and holds anything, 0 if not, -1 with a message if it cannot be said. */
static int folder_is_used(const char *folder)
{
	DIR *stream = opendir(folder);
	if (!stream) {
		if (errno == ENOENT)
			return 0;
		error_set(errno == ENOTDIR ? STATUS_INPUT : STATUS_RESOURCE, "cannot use %s as output folder: %s", folder,
				  strerror(errno));
		return -1;
	}
	int used = 0;
	for (struct dirent *entry; !used && (entry = readdir(stream));)
		used = strcmp(entry->d_name, ".") && strcmp(entry->d_name, "..");
	closedir(stream);
	return used;
}

static bool folder_has_history(const char *folder)
{
	char path[FILE_PATH];
	return file_join(path, folder, "history.csv") == STATUS_OK && file_exists(path);
}

int folder_check(const char *folder, bool force, bool restart)
{
	int used = folder_is_used(folder);
	if (used < 0)
		return file_exists(folder) && !file_is_folder(folder) ? STATUS_INPUT : STATUS_RESOURCE;
	if (!used || (restart ? folder_has_history(folder) : force))
		return STATUS_OK;
	if (restart)
		return error_set(STATUS_INPUT,
						 "the folder %s is not empty and no run's: give the folder of the run that is "
						 "continued, or a new one, with --out",
						 folder);
	return error_set(STATUS_INPUT,
					 "the output folder %s is not empty: choose another with --out, or move it aside with "
					 "--force",
					 folder);
}

static int folder_move_aside(const char *folder, char moved[FILE_PATH])
{
	for (int n = 1; n < 10000; n++) {
		if (snprintf(moved, FILE_PATH, "%.*s.old-%d", (int)(strlen(folder) - (folder[strlen(folder) - 1] == '/')),
					 folder, n) >= FILE_PATH)
			return error_set(STATUS_INPUT, "%s: the name is too long", folder);
		if (file_exists(moved))
			continue;
		if (rename(folder, moved) != 0)
			return error_set(STATUS_RESOURCE, "cannot move %s to %s: %s", folder, moved, strerror(errno));
		return STATUS_OK;
	}
	return error_set(STATUS_RESOURCE, "cannot move %s aside: too many old folders", folder);
}

static int folder_lock(const char *folder, int *lock)
{
	*lock = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
	if (*lock < 0)
		return error_set(STATUS_RESOURCE, "cannot open %s: %s", folder, strerror(errno));
	/* file systems without locks do without this protection */
	if (flock(*lock, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK)
		return STATUS_OK;
	close(*lock);
	*lock = -1;
	return error_set(STATUS_INPUT,
					 "another run is writing to %s: wait for its end, or choose another folder with --out", folder);
}

int folder_make(const char *folder, bool force, char moved[FILE_PATH], int *lock)
{
	moved[0] = '\0';
	if (force && folder_is_used(folder) > 0) {
		CHECK(folder_lock(folder, lock));
		int status = folder_move_aside(folder, moved);
		close(*lock);
		CHECK(status);
	}
	CHECK(file_make_folder(folder));
	return folder_lock(folder, lock);
}
