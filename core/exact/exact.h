/* Exact and manufactured solutions: one table for tests, studies, scenes and people.
 *
 * A solution is found by name, has parameters with units and defaults, and gives some of the fields of
 * exact_fields[], which are called as the columns of a probe in history.csv.  It is a function of the place
 * X in the initial body, the time and the parameters, without a state:
 *
 *     const struct exact_solution *s = exact_find("danilovskaya");
 *     double p[EXACT_PARAMETERS_MAX];
 *     exact_defaults(s, p);
 *     CHECK(exact_set(s, p, "shock=50"));
 *     double sigma = exact_value(s, p, X, t, EXACT_STRESS_XX);
 *
 * Places, times and results are in SI units; a temperature is in the unit of the parameters it is made of
 * (K or C: only differences enter).  Where a solution has nothing to say (a field that it lacks, a place
 * outside its body, a time beyond its validity) the value is NAN.
 *
 * Manufactured solutions have a motion(): X -> x with its velocity, acceleration, deformation gradient and
 * the gradient of that, all in closed form.  With the derivative of a law's stress (law.h) this gives the body
 * force b = a - Div P / rho0 under which a body of that law moves so. */
#ifndef TMDEMPM_EXACT_EXACT_H
#define TMDEMPM_EXACT_EXACT_H

#include <stdbool.h>

#include "base/field.h"

enum { EXACT_PARAMETERS_MAX = 12 };

enum exact_field {
	EXACT_TEMPERATURE,
	EXACT_DISPLACEMENT_X,
	EXACT_DISPLACEMENT_Y,
	EXACT_VELOCITY_X,
	EXACT_VELOCITY_Y,
	EXACT_STRESS_XX, /* Cauchy stress, tension positive */
	EXACT_STRESS_YY,
	EXACT_STRESS_ZZ,
	EXACT_STRESS_XY,
	EXACT_FIELDS
};

/* Names as in history.csv behind the probe's name, and units. */
extern const struct field exact_fields[EXACT_FIELDS];

struct exact_parameter {
	const char *name, *unit;
	double value; /* default */
	const char *doc;
};

/* A motion at one material point. */
struct exact_motion {
	double u[2], v[2], a[2]; /* m, m/s, m/s2 */
	double F[4];             /* deformation gradient dx_i/dX_J, row-major */
	double dF[2][4];         /* dF/dX and dF/dY, 1/m */
};

struct exact_solution {
	const char *name;
	const char *doc; /* what it solves, where it holds, its source */
	unsigned fields; /* bit f set: gives field f; of a solution with motion(): displacement and velocity, added there */
	int n_parameters;
	const struct exact_parameter *parameters;

	/* One of the solution's fields; NULL where motion() says it all. */
	double (*value)(const double *parameters, const double X[2], double t, enum exact_field field);

	/* NULL where the solution is not a motion that any law could be made to follow; false outside of the body. */
	bool (*motion)(const double *parameters, const double X[2], double t, struct exact_motion *motion);
};

/* Every solution there is, NULL-terminated. */
extern const struct exact_solution *const exact_solutions[];

/* By name, or NULL. */
const struct exact_solution *exact_find(const char *name);

/* Fills parameters[n_parameters] with the defaults. */
void exact_defaults(const struct exact_solution *solution, double *parameters);

/* Index of a parameter, or -1. */
int exact_parameter(const struct exact_solution *solution, const char *name);

/* Takes "name=value".  STATUS_INPUT with what is known if the name is not, or the value is no finite number. */
int exact_set(const struct exact_solution *solution, double *parameters, const char *assignment);

/* Field by its name in history.csv ("stress_xx"), or -1. */
int exact_field_find(const char *name);
bool exact_has(const struct exact_solution *solution, enum exact_field field);

/* The value of a field; NAN where there is none. */
double exact_value(const struct exact_solution *solution, const double *parameters, const double X[2], double t,
				   enum exact_field field);

/* Prints the table, or one solution with its parameters and fields, to the standard output. */
void exact_print(const struct exact_solution *solution);

/* `tmdempm exact NAME [--set parameter=value]... --at x,y --times a,b,c|from:to:n`: CSV on the standard output.
 * argv[0] = "exact".  Returns a status. */
int cli_exact(int argc, char **argv);

#endif
