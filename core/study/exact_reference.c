#include "study/exact_reference.h"

#include "base/error.h"
#include "base/expression.h"

int exact_reference_get(struct exact_reference *reference, const struct study *study, const int *choice)
{
	const struct study_reference *named = &study->reference;
	reference->solution = exact_find(named->exact);
	if (!reference->solution)
		return error_set(STATUS_INPUT, "%s: there is no exact solution \"%s\", expected one that `tmdempm exact` lists",
						 study->file, named->exact);
	exact_defaults(reference->solution, reference->parameters);
	for (int k = 0; k < named->n_parameters; k++) {
		const struct study_parameter *p = &named->parameters[k];
		char assignment[SCENE_NAME + 40];
		double value;
		CHECK(plan_value(study, choice, p->value, &value));
		snprintf(assignment, sizeof assignment, "%s=%.17g", p->name, value);
		int status = exact_set(reference->solution, reference->parameters, assignment);
		if (status != STATUS_OK)
			return error_context(status, "%s: reference.parameters", study->file);
	}
	return STATUS_OK;
}

struct exact_place {
	const struct exact_reference *reference;
	const double *X;
	double t;
};

static bool exact_lookup(void *context, const char *name, double *value)
{
	const struct exact_place *place = context;
	int field = exact_field_find(name);
	if (field < 0 || !exact_has(place->reference->solution, (enum exact_field)field))
		return false;
	*value = exact_value(place->reference->solution, place->reference->parameters, place->X, place->t,
						 (enum exact_field)field);
	return true;
}

int exact_reference_value(const struct exact_reference *reference, const char *expression, const double X[2], double t,
						  double *value)
{
	struct exact_place place = {reference, X, t};
	int status = expression_value(expression, exact_lookup, &place, value);
	return status == STATUS_INPUT ? error_context(status, "the exact solution %s", reference->solution->name) : status;
}
