/* One RVE driven alone: element tests (biaxial, isochoric, simple shear, isotropic) and the replay of a
 * recorded path.  Stress is tension-positive; strain is ln U since the first row. */
#ifndef TMDEMPM_RVE_DRIVE_H
#define TMDEMPM_RVE_DRIVE_H

#include "base/field.h"
#include "rve/packing.h"
#include "rve/rve.h"
#include "rve/rve_file.h"

enum rve_load {
	RVE_LOAD_ISOCHORIC, /* L = diag(R, -R) */
	RVE_LOAD_BIAXIAL,   /* y is shortened at R, a servo holds sigma_xx at -P (the shortening waits for it), L_xy = 0 */
	RVE_LOAD_SHEAR,     /* L_12 = R at constant volume */
	RVE_LOAD_ISO,       /* a servo (no faster than R) brings and holds sigma at -P I */
	RVE_LOAD_PATH       /* rows of duration, L11, L12, L21, L22, dT, and where there are bonds T and `bonds` */
};

/* "isochoric" ... -> enum rve_load, or -1. */
int rve_load_find(const char *name);

enum { PATH_DURATION, PATH_L, PATH_DT = PATH_L + 4, PATH_T, PATH_BONDS, PATH_COLUMNS };

/* A recorded path, one entry for each call of rve_advance() in the run. */
struct rve_path {
	int n;
	int bonded; /* it has the last two columns */
	/* duration (s), L11, L12, L21, L22 (1/s), dT (K); T (K, absolute, after the call), bonds (1: installed then) */
	double (*rows)[PATH_COLUMNS];
};

int rve_path_read(struct rve_path *path, const char *file);
void rve_path_free(struct rve_path *path);

struct rve_drive {
	enum rve_load load;
	double rate;              /* R, 1/s */
	double strain;            /* R times the duration of the load */
	double pressure;          /* P of biaxial and iso, Pa */
	double temperature;       /* K, reached before the first row */
	double start_temperature; /* K, absolute, of the packing: what bonds melt by; a path says it itself */
	double strain_per_step;   /* S: the strain of a sub-step is min(R dt_DEM, S); not for a path */
	int rows;                 /* after the first; 0 = every row of a path */
	int skip;                 /* rows at the beginning of the path that are left out */
	const struct rve_path *path;
	const struct rve_file *from; /* not NULL: goes on from this state; the packing is not looked at */
	int install;              /* bonds are installed before the load also in a state that goes on */
	const char *save;         /* not NULL: the RVE file that the end is written to */
	const volatile int *stop; /* not NULL: STATUS_INTERRUPTED soon after it becomes non-zero */
};

enum {
	RVE_STRAIN_XX,
	RVE_STRAIN_YY,
	RVE_STRAIN_VOL,
	RVE_STRESS_XX,
	RVE_STRESS_YY,
	RVE_STRESS_XY,
	RVE_VOID_RATIO,
	RVE_COORDINATION,
	RVE_SLIDING_FRACTION,
	RVE_WORK,
	RVE_FRICTION_HEAT,
	RVE_DASHPOT,
	RVE_BOND,
	RVE_ELASTIC,
	RVE_KINETIC,
	RVE_CONDUCTIVITY_XX,
	RVE_CONDUCTIVITY_YY,
	RVE_COLUMNS
};

/* Name, unit and meaning of each column. */
extern const struct field rve_columns[RVE_COLUMNS];

/* Receives the rows; anything but 0 ends the drive with that status. */
typedef int rve_row_function(void *context, const double row[RVE_COLUMNS]);

/* What the drive did; filled in on failure too. */
struct rve_drive_report {
	int rows;
	int rows_off_pressure; /* rows of a servo load with a held stress more than 1% from -P */
	struct rve_info last;
};

/* Drives one RVE that starts as `packing`, or goes on from drive->from.  The first row is the state in which the load begins: after heating
 * and, for biaxial, after consolidation to P; ledgers and strain count from there (of a path: from birth).  Bonds, if
 * the parameters have any, are installed after the consolidation, before the heating (and a second consolidation); on a
 * path where its rows say so.  An RVE that goes on keeps the bonds that it has.
 * STATUS_GUARD when the RVE leaves its domain of validity, or the consolidation takes a strain of more than 0.5;
 * the rows until then have been given. */
int rve_drive(const struct rve_packing *packing, const struct rve_params *params, const struct rve_drive *drive,
			  rve_row_function *row, void *context, struct rve_drive_report *report);

#endif
