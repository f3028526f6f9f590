/* One combination as a child process; what is kept of it. */
#ifndef TMDEMPM_STUDY_JOB_H
#define TMDEMPM_STUDY_JOB_H

#include "study/private.h"

const char *outcome_name(enum outcome outcome);

/* Gives a combination its hash and its folder DIR/runs/...  Loads its scene: STATUS_INPUT (told on stderr) if a
 * setting is wrong. */
int job_name(const struct study *study, struct combination *c, const char *folder);

/* Looks whether a combination has been run before; its outcome is in `result` if so. */
bool job_recall(struct combination *c);

/* Removes what an earlier run said about its outcome. */
int job_forget(struct combination *c);

/* Starts its child process in a fresh folder. */
int job_start(const struct study *study, struct combination *c, const char *program, pid_t *pid);

/* Keeps outcome and cost of a child that has ended; wall and cpu [s] as the system measured them. */
int job_end(const struct study *study, struct combination *c, int wait_status, double wall, double cpu);

/* The curve of a combination: history.csv, or what `rve load` wrote. */
int job_curve(const struct study *study, const struct combination *c, char path[FILE_PATH]);

#endif
