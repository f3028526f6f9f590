/* Inside of the studies.
 *
 *   keys.c       study file -> struct study, through the scenes' loader
 *   plan.c       knobs -> combinations; what each of them sets
 *   job.c        one combination as a child process; what is kept of it
 *   schedule.c   which runs are missing, several at a time
 *   series.c     columns of curves over an abscissa
 *   points.c     fields of snapshots
 *   exact.c      the exact solution that a study names
 *   norm.c       value and error of every norm of every combination
 *   report.c     study.csv, study.json, gates, charts */
#ifndef TMDEMPM_STUDY_PRIVATE_H
#define TMDEMPM_STUDY_PRIVATE_H

#include <stdio.h>
#include <sys/types.h>

#include "io/file.h"
#include "scene/scene.h"
#include "study/study.h"

enum { STUDY_TEXT = 256, STUDY_UNIT = 24, STUDY_HASH = 17 };

struct study_texts {
	int n;
	const char **items;
};

/* One value of a knob by name, with what it sets. */
struct study_choice {
	char name[SCENE_NAME];
	double value; /* what the name means in expressions; NAN = nothing */
	struct study_texts set;
};

struct study_knob {
	char name[SCENE_NAME], label[STUDY_TEXT], unit[STUDY_UNIT];
	char path[STUDY_TEXT];   /* shorthand for set = ("PATH=$(NAME)") */
	bool seed;               /* differs in chance only: gives error bars */
	struct study_texts list; /* values as texts */
	int n_choices;
	struct study_choice *choices; /* after loading also those of `list` */
	struct study_texts set;       /* for every value */
	struct scene_place place;
};

enum study_plan { STUDY_PRODUCT, STUDY_ONE_AT_A_TIME, STUDY_LIST };

enum study_reference_kind { STUDY_NO_REFERENCE, STUDY_EXACT, STUDY_FINEST, STUDY_TABLE };

struct study_parameter {
	char name[SCENE_NAME];
	char value[STUDY_TEXT]; /* an expression of knobs */
};

struct study_reference {
	char exact[SCENE_NAME]; /* name of an exact solution, "" = none */
	int n_parameters;
	struct study_parameter *parameters;
	char finest[STUDY_TEXT]; /* a selection of knobs, "" = none */
	bool mean;               /* of the finest runs' seeds; false: each seed against its own */
	char table[SCENE_PATH];  /* a CSV file, "" = none */
	enum study_reference_kind kind;
};

enum study_norm_kind { NORM_RMS, NORM_MAX, NORM_MEAN, NORM_END, NORM_REACH };

struct study_gate {
	double bound;
	char where[STUDY_TEXT]; /* a selection of knobs; "" = everywhere */
};

struct study_norm {
	char name[SCENE_NAME], label[STUDY_TEXT];
	enum study_norm_kind kind;
	char column[STUDY_TEXT];   /* an expression of columns of the curve and knobs, "" = a norm over points */
	char abscissa[STUDY_TEXT]; /* the same; "time" */
	char points[SCENE_NAME];   /* a field of snapshots, or a component of one */
	char exact[STUDY_TEXT];    /* an expression of fields of the exact solution; "" = the column's own name */
	double at[2];              /* m, where the exact solution is taken; NAN = where the column's probe starts */
	double from, until;        /* of the abscissa; NAN = its ends */
	double level;              /* NORM_REACH */
	double time;               /* s, of the snapshot; NAN = the last */
	double scale;              /* errors and values are divided by it */
	char unit[STUDY_UNIT];     /* of what is left */
	bool relative;             /* errors are divided by the reference's value */
	double gate;               /* NAN = none; everywhere */
	int n_gates;
	struct study_gate *gates;
	double garbage; /* stability: beyond it a result means nothing; NAN = no criterion */
	struct scene_place place;
};

struct study_order { /* a slope that is demanded */
	char norm[SCENE_NAME], knob[SCENE_NAME], where[STUDY_TEXT];
	double least;
	struct scene_place place;
};

struct study_curve { /* drawn into a stability map */
	char label[STUDY_TEXT];
	char y[STUDY_TEXT]; /* an expression of the horizontal knob */
};

struct study_scene {
	char file[SCENE_PATH]; /* "" = none */
	struct study_texts set;
	int threads;
};

struct study {
	char title[STUDY_TEXT];
	bool stability; /* kind */
	struct study_scene scene;
	struct study_texts load; /* options of `rve load`, "name=value"; n = 0: a scene is run */
	int n_knobs;
	struct study_knob *knobs;
	enum study_plan plan;
	char base[STUDY_TEXT]; /* ONE_AT_A_TIME: what the others stay at; default: first values */
	struct study_texts combinations;
	struct study_reference reference;
	int n_norms;
	struct study_norm *norms;
	int n_orders;
	struct study_order *orders;
	struct study_texts against; /* knobs to draw errors over */
	struct study_texts guards_off;
	char map[2][SCENE_NAME]; /* knobs of the axes, "" = none */
	int n_curves;
	struct study_curve *curves;
	char file[SCENE_PATH]; /* of the study itself */
	struct scene *storage;
};

/* ---- keys.c ---- */

int study_load(struct study **study, const char *path, int n_sets, const char *const *sets, void *errors);
void study_free(struct study *study);

/* ---- plan.c ---- */

enum outcome { OUTCOME_NONE, OUTCOME_DONE, OUTCOME_GUARD, OUTCOME_REFUSED, OUTCOME_FAILED };

struct cost {
	double wall, cpu, setup; /* s: of the loop, of the loop on all cores, before it */
	double steps, points, disc_steps;
};

/* What became of one run. */
struct result {
	enum outcome outcome;
	char reason[512];
	struct cost cost;
	double *value, *error; /* [n_norms] NAN where there is none */
};

struct combination {
	int *choice;             /* [n_knobs] */
	bool off;                /* a stability study's second run: without guards */
	bool asked;              /* for itself, not only as a reference */
	int partner;             /* the same with guards (without, for those with), -1 = none */
	int reference;           /* another combination, itself, or -1 */
	char name[STUDY_TEXT];   /* "transfer=flip, dt=0.0001" */
	char hash[STUDY_HASH];   /* of everything that decides its results */
	char folder[FILE_PATH];  /* DIR/runs/NAME-HASH */
	struct study_texts sets; /* of the scene, or options of `rve load` */
	struct result result;
};

struct plan {
	const struct study *study;
	int n, capacity;
	struct combination *combinations;
};

/* Every combination that the study asks for, and those that others are compared with. */
int plan_create(struct plan *plan, const struct study *study);
void plan_free(struct plan *plan);

/* Does a combination have the values that a selection "knob=value, knob=value" names? */
bool plan_matches(const struct study *study, const int *choice, const char *selection);

/* Do two combinations differ in nothing but their seed? */
bool plan_same_but_seed(const struct study *study, const struct combination *a, const struct combination *b);

/* STATUS_INPUT if a selection names what is not there. */
int plan_check_selection(const struct study *study, const char *selection);

int plan_knob(const struct study *study, const char *name);

/* Values of knobs for expressions (an expression_lookup); the context is a struct plan_place. */
struct plan_place {
	const struct study *study;
	const int *choice;
};
bool plan_lookup(void *context, const char *name, double *value);

/* An expression of knobs. */
int plan_value(const struct study *study, const int *choice, const char *expression, double *value);

/* ---- schedule.c ---- */

int schedule_run(struct plan *plan, const struct study_options *options);

/* ---- norm.c ---- */

/* Value and error of every norm of every run; what cannot be had is NAN.  STATUS_INPUT if a norm names a column or
 * a field that the runs do not have. */
int norms_evaluate(struct plan *plan);

#endif
