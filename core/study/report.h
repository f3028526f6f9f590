/* What a study writes: study.csv, summary.csv, study.json; and what it demands. */
#ifndef TMDEMPM_STUDY_REPORT_H
#define TMDEMPM_STUDY_REPORT_H

#include "study/private.h"

/* A stability study's verdict on a pair of runs. */
enum verdict {
	VERDICT_NONE,
	VERDICT_STABLE,       /* sound, and no guard minds */
	VERDICT_GUARDED,      /* a guard stops what would become garbage, before it is */
	VERDICT_CONSERVATIVE, /* a guard stops what would stay sound */
	VERDICT_LATE,         /* a guard stops what is garbage already */
	VERDICT_GARBAGE       /* garbage, and no guard tells */
};

const char *verdict_name(enum verdict verdict);

/* Of the pair that a combination belongs to; NONE if the study is not of stability, or a run is missing. */
enum verdict verdict_of(const struct plan *plan, const struct combination *c);

/* A row for each run; the same averaged over seeds (if there are any); what charts need to know beside. */
int report_write_csv(const struct plan *plan, const char *folder);
int report_write_summary(const struct plan *plan, const char *folder);
int report_write_json(const struct plan *plan, const char *folder);

/* STATUS_GUARD if a gate is missed, with the message that names the norm, its value, the bound and the combination
 * (of several the first; all are printed on stderr). */
int report_gates(const struct plan *plan);

#endif
