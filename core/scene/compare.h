/* Do two scenes describe the same physics?  Asked before a restart. */
#ifndef TMDEMPM_SCENE_COMPARE_H
#define TMDEMPM_SCENE_COMPARE_H

#include <stddef.h>

/* Compares the texts of two scenes (as in scene->text) setting by setting, leaving aside what a restart
 * may change: `title`, `output`, `images`, `inspect`, `guards`, the laws' `overlap_max` and `path`, and `time.end`.
 * Returns 1 if the rest is equal; 0 with the first difference ("walls.[2].friction: 0.5 before, 0.3 now")
 * in what[size]. */
int scene_compare(const char *before, const char *now, char *what, size_t size);

#endif
