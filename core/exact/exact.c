#include "exact/exact.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"

const struct field exact_fields[EXACT_FIELDS] = {
	[EXACT_TEMPERATURE] = {"temperature", "K", 1, "temperature, in the unit of its parameters"},
	[EXACT_DISPLACEMENT_X] = {"displacement_x", "m", 1, "way since birth"},
	[EXACT_DISPLACEMENT_Y] = {"displacement_y", "m", 1, "way since birth"},
	[EXACT_VELOCITY_X] = {"velocity_x", "m/s", 1, "velocity"},
	[EXACT_VELOCITY_Y] = {"velocity_y", "m/s", 1, "velocity"},
	[EXACT_STRESS_XX] = {"stress_xx", "Pa", 1, "Cauchy stress"},
	[EXACT_STRESS_YY] = {"stress_yy", "Pa", 1, "Cauchy stress"},
	[EXACT_STRESS_ZZ] = {"stress_zz", "Pa", 1, "Cauchy stress"},
	[EXACT_STRESS_XY] = {"stress_xy", "Pa", 1, "Cauchy stress"},
};

extern const struct exact_solution exact_danilovskaya, exact_rod, exact_square, exact_half_space, exact_plate,
	exact_neumann, exact_cooling, exact_column, exact_restrained, exact_bar_impact, exact_bar_vibration, exact_periodic,
	exact_axis_aligned, exact_vortex, exact_ring, exact_contact_blocks;

const struct exact_solution *const exact_solutions[] = {
	&exact_danilovskaya, &exact_rod,        &exact_square,        &exact_half_space,
	&exact_plate,        &exact_neumann,    &exact_cooling,       &exact_column,
	&exact_restrained,   &exact_bar_impact, &exact_bar_vibration, &exact_periodic,
	&exact_axis_aligned, &exact_vortex,     &exact_ring,
	&exact_contact_blocks,
	NULL,
};

const struct exact_solution *exact_find(const char *name)
{
	for (int s = 0; exact_solutions[s]; s++)
		if (!strcmp(exact_solutions[s]->name, name))
			return exact_solutions[s];
	return NULL;
}

void exact_defaults(const struct exact_solution *solution, double *parameters)
{
	for (int k = 0; k < solution->n_parameters; k++)
		parameters[k] = solution->parameters[k].value;
}

int exact_parameter(const struct exact_solution *solution, const char *name)
{
	for (int k = 0; k < solution->n_parameters; k++)
		if (!strcmp(solution->parameters[k].name, name))
			return k;
	return -1;
}

int exact_set(const struct exact_solution *solution, double *parameters, const char *assignment)
{
	char name[64], known[512] = "", *end;
	size_t length = strcspn(assignment, "=");
	snprintf(name, sizeof name, "%.*s", (int)length, assignment);
	int k = exact_parameter(solution, name);
	for (int i = 0; i < solution->n_parameters; i++)
		snprintf(known + strlen(known), sizeof known - strlen(known), "%s%s", i ? ", " : "",
				 solution->parameters[i].name);
	if (k < 0 || assignment[length] != '=')
		return error_set(STATUS_INPUT, "%s: expected parameter=value with a parameter of '%s': %s", assignment,
						 solution->name, known);
	double value = strtod(assignment + length + 1, &end);
	if (*end || end == assignment + length + 1 || !isfinite(value))
		return error_set(STATUS_INPUT, "%s: expected a finite number (%s)", assignment, solution->parameters[k].unit);
	parameters[k] = value;
	return STATUS_OK;
}

int exact_field_find(const char *name)
{
	for (int f = 0; f < EXACT_FIELDS; f++)
		if (!strcmp(exact_fields[f].name, name))
			return f;
	return -1;
}

/* Fields that a motion gives. */
static bool is_kinematic(enum exact_field field) { return field >= EXACT_DISPLACEMENT_X && field <= EXACT_VELOCITY_Y; }

bool exact_has(const struct exact_solution *solution, enum exact_field field)
{
	return solution->fields >> field & 1u || (solution->motion && is_kinematic(field));
}

double exact_value(const struct exact_solution *solution, const double *parameters, const double X[2], double t,
				   enum exact_field field)
{
	struct exact_motion motion;
	if (!exact_has(solution, field) || !(t >= 0.0))
		return NAN;
	if (!(solution->motion && is_kinematic(field)))
		return solution->value(parameters, X, t, field);
	if (!solution->motion(parameters, X, t, &motion))
		return NAN;
	return field >= EXACT_VELOCITY_X ? motion.v[field - EXACT_VELOCITY_X] : motion.u[field - EXACT_DISPLACEMENT_X];
}

static void print_one(const struct exact_solution *s)
{
	printf("%s: %s\n  fields    ", s->name, s->doc);
	for (int f = 0; f < EXACT_FIELDS; f++)
		if (exact_has(s, f))
			printf(" %s", exact_fields[f].name);
	putchar('\n');
	for (int k = 0; k < s->n_parameters; k++)
		printf("  %-20s %-10g %-9s %s\n", s->parameters[k].name, s->parameters[k].value, s->parameters[k].unit,
			   s->parameters[k].doc);
}

void exact_print(const struct exact_solution *solution)
{
	if (solution) {
		print_one(solution);
		return;
	}
	for (int s = 0; exact_solutions[s]; s++)
		printf("  %-16s %s%s\n", exact_solutions[s]->name, exact_solutions[s]->doc,
			   exact_solutions[s]->motion ? " [motion]" : "");
}
