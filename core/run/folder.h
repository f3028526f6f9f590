/* The output folder: who may write where. */
#ifndef TMDEMPM_RUN_FOLDER_H
#define TMDEMPM_RUN_FOLDER_H

#include <stdbool.h>

#include "io/file.h"

/* The folder of a run: --out, or the checkpoint's own folder on a restart, or `NAME.out` in the working
 * directory, where NAME is the scene file's name without its end. */
int folder_name(char folder[FILE_PATH], const char *out, const char *restart, const char *scene_path);

/* May a run write there?  A folder that is not empty is refused (STATUS_INPUT) unless `force` is given or a
 * run is restarted in its own folder.  Looks only; nothing is written. */
int folder_check(const char *folder, bool force, bool restart);

/* Makes the folder.  With `force` an old folder that is not empty is moved to the first
 * free `FOLDER.old-N`, never deleted; its new name comes back in moved[FILE_PATH] ("" = nothing moved).
 * The folder is this process's until *lock is closed, at the latest when the process ends, however it ends:
 * a second run that wants it, also by a restart or by force, gets STATUS_INPUT. */
int folder_make(const char *folder, bool force, char moved[FILE_PATH], int *lock);

#endif
