#include "rve/drive.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "base/mat2.h"
#include "io/csv.h"

const struct field rve_columns[RVE_COLUMNS] = {
	[RVE_STRAIN_XX] = {"strain_xx", "-", 1, "ln U, xx"},
	[RVE_STRAIN_YY] = {"strain_yy", "-", 1, "ln U, yy"},
	[RVE_STRAIN_VOL] = {"strain_vol", "-", 1, "ln J"},
	[RVE_STRESS_XX] = {"stress_xx", "Pa", 1, "Cauchy stress, tension-positive"},
	[RVE_STRESS_YY] = {"stress_yy", "Pa", 1, "Cauchy stress, tension-positive"},
	[RVE_STRESS_XY] = {"stress_xy", "Pa", 1, "Cauchy stress, tension-positive"},
	[RVE_VOID_RATIO] = {"void_ratio", "-", 1, "voids over solids, by area"},
	[RVE_COORDINATION] = {"coordination", "-", 1, "contacts of a disc, mean"},
	[RVE_SLIDING_FRACTION] = {"sliding_fraction", "-", 1, "contacts at the Coulomb limit"},
	[RVE_WORK] = {"work", "J", 1, "of the stress on the strain, and what was stored at the first row"},
	[RVE_FRICTION_HEAT] = {"friction_heat", "J", 1, "slip at contacts"},
	[RVE_DASHPOT] = {"dashpot", "J", 1, "lost in normal dashpots"},
	[RVE_BOND] = {"bond", "J", 1, "lost with broken bonds"},
	[RVE_ELASTIC] = {"elastic", "J", 1, "stored in contacts"},
	[RVE_KINETIC] = {"kinetic", "J", 1, "of the fluctuations"},
	[RVE_CONDUCTIVITY_XX] = {"conductivity_xx", "W/(m K)", 1, "eq. 34"},
	[RVE_CONDUCTIVITY_YY] = {"conductivity_yy", "W/(m K)", 1, "eq. 34"},
};

int rve_load_find(const char *name)
{
	static const char *const names[] = {"isochoric", "biaxial", "shear", "iso", "path"};
	for (int k = 0; k < 5; k++)
		if (strcmp(name, names[k]) == 0)
			return k;
	return -1;
}

/* ---- paths ---- */

#define PATH_CELLS "duration,L11,L12,L21,L22,dT and, of a law with bonds, T,bonds"

static int check_path(const struct csv_table *t)
{
	if (t->rows == 0)
		return error_set(STATUS_INPUT, "%s: no rows, expected " PATH_CELLS, t->path);
	if (t->columns != PATH_T && t->columns != PATH_COLUMNS)
		return error_set(STATUS_INPUT, "%s:%d: %d cells, expected " PATH_CELLS, t->path, t->lines[0], t->columns);
	for (int k = 0; k < t->rows; k++) {
		const double *row = t->values + t->columns * k;
		for (int c = 0; c < t->columns; c++)
			if (!isfinite(row[c]))
				return error_set(STATUS_INPUT, "%s:%d: cell %d is %g, expected a finite number", t->path, t->lines[k],
								 c + 1, row[c]);
		if (!(row[PATH_DURATION] > 0.0))
			return error_set(STATUS_INPUT, "%s:%d: the duration is %g, expected a positive number of seconds", t->path,
							 t->lines[k], row[PATH_DURATION]);
	}
	return STATUS_OK;
}

int rve_path_read(struct rve_path *path, const char *file)
{
	struct csv_table *t;
	*path = (struct rve_path){0};
	CHECK(csv_read(&t, file, NULL));
	int status = check_path(t);
	if (status == STATUS_OK && !(path->rows = calloc((size_t)(unsigned)t->rows, sizeof *path->rows)))
		status = error_set(STATUS_RESOURCE, "no memory for the path %s", file);
	if (status == STATUS_OK) {
		path->n = t->rows;
		path->bonded = t->columns == PATH_COLUMNS;
		for (int k = 0; k < t->rows; k++)
			memcpy(path->rows[k], t->values + t->columns * k, (size_t)t->columns * sizeof *t->values);
	}
	csv_table_free(t);
	return status;
}

void rve_path_free(struct rve_path *path)
{
	free(path->rows);
	*path = (struct rve_path){0};
}

/* ---- one RVE ---- */

struct driver {
	const struct rve_drive *drive;
	const struct rve_packing *packing;
	struct rve_model *model;
	void *state;
	double strain_per_step, dt; /* s, macroscopic duration of one sub-step at the rate R */
	double T;                   /* K, absolute, after the last call */
	double stress[4], conductivity[3], modulus;
	double integral[3]; /* of the servo's relative errors: xx, yy, xy */
	double F0[4];       /* inverse of F at the first row */
	int reached;        /* iso: P has been reached */
	int bonded;         /* bonds are installed before the load */
	rve_row_function *row;
	void *context;
	struct rve_drive_report *report;
};

static int advance(struct driver *d, const double L[4], double dT, double dt)
{
	double heat;
	struct rve_batch batch = {
		.n = 1,
		.states = d->state,
		.L = (const double(*)[4])L,
		.dT = &dT,
		.T = &d->T,
		.dt = dt,
		.stress = &d->stress,
		.heat = &heat,
		.conductivity = &d->conductivity,
		.modulus = &d->modulus,
	};
	if (d->drive->stop && *d->drive->stop)
		return error_set(STATUS_INTERRUPTED, "interrupted");
	return rve_advance(d->model, &batch);
}

/* Is a stress that the servo should hold more than 1% off?  Until iso has reached P it holds nothing. */
static int off_pressure(struct driver *d)
{
	double p = d->drive->pressure, bound = 0.01 * p;
	int xx = fabs(d->stress[0] + p) > bound, yy = fabs(d->stress[1] + p) > bound;
	if (d->drive->load == RVE_LOAD_BIAXIAL)
		return xx;
	if (d->drive->load != RVE_LOAD_ISO)
		return 0;
	d->reached |= !xx && !yy;
	return d->reached && (xx || yy);
}

static int give_row(struct driver *d)
{
	struct rve_info *info = &d->report->last;
	double F[4], strain[3];
	rve_get_info(d->model, d->state, info);
	mat2_multiply(info->F, d->F0, F);
	mat2_log_stretch(F, strain);
	const double row[RVE_COLUMNS] = {
		[RVE_STRAIN_XX] = strain[0],
		[RVE_STRAIN_YY] = strain[1],
		[RVE_STRAIN_VOL] = strain[0] + strain[1],
		[RVE_STRESS_XX] = d->stress[0],
		[RVE_STRESS_YY] = d->stress[1],
		[RVE_STRESS_XY] = d->stress[3],
		[RVE_VOID_RATIO] = info->void_ratio,
		[RVE_COORDINATION] = info->coordination,
		[RVE_SLIDING_FRACTION] = info->sliding_fraction,
		[RVE_WORK] = info->work,
		[RVE_FRICTION_HEAT] = info->friction,
		[RVE_DASHPOT] = info->dashpot,
		[RVE_BOND] = info->bond,
		[RVE_ELASTIC] = info->elastic,
		[RVE_KINETIC] = info->kinetic,
		[RVE_CONDUCTIVITY_XX] = d->conductivity[0],
		[RVE_CONDUCTIVITY_YY] = d->conductivity[1],
	};
	d->report->rows++;
	d->report->rows_off_pressure += off_pressure(d);
	return d->row(d->context, row);
}

/* ---- servo ---- */

/* Strain of the next sub-step that brings a stress to its target: proportional and integral, scaled by the
 * affine modulus, which is the stiffest answer that the springs can give, and no larger than `limit`.  Dashpots answer
 * a change of rate with about as much again: a proportional share above 0.55 would oscillate. */
static double servo(struct driver *d, int component, double error, double limit)
{
	const double proportional = 0.35, integral = 0.05;
	double floor = 1e-3 * d->drive->pressure / limit; /* a stressless RVE has no modulus of its own */
	double e = error / fmax(d->modulus, floor), sum = d->integral[component] + integral * e;
	double strain = proportional * e + sum;
	if (fabs(strain) <= limit) {
		d->integral[component] = sum; /* frozen while the limit bites, so that it does not wind up */
		return -strain;
	}
	return strain > 0.0 ? -limit : limit;
}

static void servo_isotropic(struct driver *d, double L[4])
{
	double p = d->drive->pressure, limit = d->strain_per_step;
	L[0] = servo(d, 0, d->stress[0] + p, limit) / d->dt;
	L[3] = servo(d, 1, d->stress[1] + p, limit) / d->dt;
	L[1] = L[2] = 0.5 * servo(d, 2, 2.0 * d->stress[3], limit) / d->dt;
}

/* Are all stresses within 0.3% of their targets, and the discs at rest? */
static int consolidated(const struct driver *d)
{
	struct rve_info info;
	double p = d->drive->pressure, bound = 0.003 * p;
	if (fabs(d->stress[0] + p) > bound || fabs(d->stress[1] + p) > bound || fabs(d->stress[3]) > bound)
		return 0;
	rve_get_info(d->model, d->state, &info);
	return info.kinetic <= 1e-4 * info.elastic;
}

/* Brings the RVE to sigma = -P I, whatever it was packed at, and waits until it stays there. */
static int consolidate(struct driver *d)
{
	const int wait = 500, most = (int)(0.5 / d->strain_per_step);
	for (int step = 0, steady = 0; steady < wait; step++) {
		double L[4];
		if (step > most && step > 100 * wait)
			return error_set(
				STATUS_GUARD,
				"the servo reached sigma_xx = %.4g Pa and sigma_yy = %.4g Pa, expected %.4g Pa; the packing may "
				"be too loose to carry it",
				d->stress[0], d->stress[1], -d->drive->pressure);
		servo_isotropic(d, L);
		CHECK(advance(d, L, 0.0, d->dt));
		steady = consolidated(d) ? steady + 1 : 0;
	}
	return STATUS_OK;
}

/* ---- loads ---- */

/* Contacts that rearrange can shed stress faster than a servo follows: the shortening waits until it is back. */
static int waiting(const struct driver *d)
{
	return d->drive->load == RVE_LOAD_BIAXIAL && fabs(d->stress[0] + d->drive->pressure) > 0.007 * d->drive->pressure;
}

static void load_gradient(struct driver *d, double L[4], int wait)
{
	double R = d->drive->rate;
	memset(L, 0, 4 * sizeof *L);
	switch (d->drive->load) {
	case RVE_LOAD_ISOCHORIC:
		L[0] = R, L[3] = -R;
		break;
	case RVE_LOAD_BIAXIAL:
		L[0] = servo(d, 0, d->stress[0] + d->drive->pressure, 10.0 * d->strain_per_step) / d->dt;
		L[3] = wait ? 0.0 : -R;
		break;
	case RVE_LOAD_SHEAR:
		L[1] = R;
		break;
	case RVE_LOAD_ISO:
		servo_isotropic(d, L);
		break;
	case RVE_LOAD_PATH:
		break;
	}
}

/* `steps` sub-steps of the load, in calls of one if a servo must see the stress of each. */
static int strain_by(struct driver *d, long steps)
{
	const int waits_most = 1000; /* a packing that cannot carry P at all goes on without it */
	const long most = d->drive->load == RVE_LOAD_BIAXIAL || d->drive->load == RVE_LOAD_ISO ? 1 : 16;
	for (int waits = 0; steps > 0 || waiting(d);) {
		double L[4];
		int wait = waiting(d) && waits < waits_most;
		if (steps == 0 && !wait)
			break;
		long n = wait ? 1 : steps < most ? steps : most;
		load_gradient(d, L, wait);
		CHECK(advance(d, L, 0.0, (double)n * d->dt));
		steps -= wait ? 0 : n;
		waits += wait;
	}
	return STATUS_OK;
}

/* Rows stand at equal strains, so that the sub-steps between two of them are a whole number and a hair smaller. */
static int run_load(struct driver *d)
{
	double strain = d->drive->strain, most = ceil(strain / d->strain_per_step * (1.0 - 1e-9));
	if (most == 0.0)
		return STATUS_OK;
	int rows = d->drive->rows < most ? d->drive->rows : (int)most;
	long steps = lround(ceil(strain / rows / d->strain_per_step * (1.0 - 1e-9)));
	d->dt = strain / rows / (double)steps / d->drive->rate;
	for (int r = 1; r <= rows; r++) {
		CHECK(strain_by(d, steps));
		CHECK(give_row(d));
	}
	if (d->drive->load == RVE_LOAD_ISO && !d->reached)
		d->report->rows_off_pressure = d->report->rows;
	return STATUS_OK;
}

static int run_path(struct driver *d)
{
	const struct rve_path *path = d->drive->path;
	int n = path->n - d->drive->skip, rows = d->drive->rows == 0 || d->drive->rows > n ? n : d->drive->rows;
	for (int k = 0, r = 1; k < n; k++) {
		const double *row = path->rows[d->drive->skip + k];
		d->T = row[PATH_T];
		CHECK(advance(d, row + PATH_L, row[PATH_DT], row[PATH_DURATION]));
		if (row[PATH_BONDS] != 0.0)
			rve_install_bonds(d->model, d->state);
		if (k + 1 < (int)((double)n * r / rows + 0.5))
			continue;
		CHECK(give_row(d));
		r++;
	}
	return STATUS_OK;
}

/* Heats (or cools) the RVE in its cell, slowly for its contacts. */
static int heat(struct driver *d)
{
	static const double rest[4];
	const int steps = 1000;
	for (int k = 0; k < steps; k++) {
		d->T = d->drive->start_temperature + d->drive->temperature * (k + 1) / steps;
		CHECK(advance(d, rest, d->drive->temperature / steps, d->dt));
	}
	return STATUS_OK;
}

/* Brings the RVE to where its load begins. */
static int prepare(struct driver *d)
{
	int biaxial = d->drive->load == RVE_LOAD_BIAXIAL, warms = d->drive->temperature != 0.0;
	d->T = d->drive->start_temperature;
	if (d->bonded && biaxial)
		CHECK(consolidate(d));
	if (d->bonded)
		rve_install_bonds(d->model, d->state);
	if (warms)
		CHECK(heat(d));
	if (biaxial && (warms || !d->bonded))
		CHECK(consolidate(d));
	return STATUS_OK;
}

static int run(struct driver *d)
{
	struct rve_info info;
	rve_evaluate(d->model, d->state, d->stress, d->conductivity, &d->modulus);
	mat2_identity(d->F0);
	if (d->drive->load == RVE_LOAD_PATH) {
		CHECK(give_row(d));
		return run_path(d);
	}
	CHECK(prepare(d));
	rve_reset_ledger(d->model, d->state);
	rve_get_info(d->model, d->state, &info);
	mat2_inverse(info.F, d->F0);
	CHECK(give_row(d));
	return run_load(d);
}

static int make_model(struct driver *d, const struct rve_params *params)
{
	return d->drive->from ? rve_file_model(&d->model, d->drive->from, params)
						  : rve_model_create(&d->model, params, 1, &d->packing);
}

/* Stepping of an element test: the strain of a sub-step is min(R dt_DEM, S), nothing clamps or scales it. */
static int set_stepping(struct driver *d, struct rve_params *params)
{
	const struct rve_drive *drive = d->drive;
	params->pressure_scaling = 0;
	params->n_max = 0;
	CHECK(make_model(d, params));
	d->strain_per_step = fmin(drive->rate * rve_time_step(d->model), drive->strain_per_step);
	d->dt = d->strain_per_step / drive->rate;
	rve_model_free(d->model);
	/* the largest eigenvalue of D counts, which is R/2 in simple shear; rve_advance() rounds sub-steps up, so a hair
	 * more */
	params->strain_per_step = d->strain_per_step * (drive->load == RVE_LOAD_SHEAR ? 0.5 : 1.0) * (1.0 + 1e-9);
	return STATUS_OK;
}

/* The state in which the drive begins. */
static int begin(struct driver *d)
{
	const struct rve_file *from = d->drive->from;
	d->state = aligned_alloc(64, (rve_state_bytes(d->model) + 63) / 64 * 64);
	if (!d->state)
		return error_set(STATUS_RESOURCE, "no memory for an RVE");
	if (!from)
		return rve_init(d->model, 0, d->state);
	memcpy(d->state, from->state, from->state_bytes);
	return STATUS_OK;
}

/* The end as an RVE file.  Its temperature is known where the load or the state that it began with knew one. */
static int save(const struct driver *d)
{
	const struct rve_drive *drive = d->drive;
	struct rve_origin origin = {.point = -1, .T = NAN};
	if (drive->from)
		origin = drive->from->origin;
	origin.T += drive->temperature;
	if (drive->load == RVE_LOAD_PATH) {
		origin.step += drive->path->n - drive->skip;
		for (int k = drive->skip; k < drive->path->n; k++) {
			origin.time += drive->path->rows[k][PATH_DURATION];
			origin.T += drive->path->rows[k][PATH_DT];
		}
		if (drive->path->bonded)
			origin.T = d->T;
	}
	return rve_file_write(drive->save, d->model, d->state, &origin);
}

int rve_drive(const struct rve_packing *packing, const struct rve_params *params, const struct rve_drive *drive,
			  rve_row_function *row, void *context, struct rve_drive_report *report)
{
	struct rve_params p = *params;
	struct driver d = {.drive = drive, .packing = packing, .row = row, .context = context, .report = report};
	d.bonded = params->bond_strength > 0.0 && (!drive->from || drive->install);
	*report = (struct rve_drive_report){0};
	if (drive->load != RVE_LOAD_PATH)
		CHECK(set_stepping(&d, &p));
	CHECK(make_model(&d, &p));
	int status = begin(&d);
	if (status == STATUS_OK) {
		status = run(&d);
		rve_get_info(d.model, d.state, &report->last);
	}
	if (status == STATUS_OK && drive->save)
		status = save(&d);
	free(d.state);
	rve_model_free(d.model);
	return status;
}
