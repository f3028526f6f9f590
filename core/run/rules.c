#include "run/rules.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"

const struct rve_rule rve_rules[] = {
	{"hottest", "temperature", -INFINITY, "the highest temperature", "no point has an RVE"},
	{"most_sheared", "strain_deviatoric", -INFINITY, "the largest deviatoric strain", "no point has an RVE"},
	{"highest_pressure", "rve_pressure", -INFINITY, "the highest pressure in the plane", "no point has an RVE"},
	{"most_broken", "broken_bonds", 0.0, "the most broken bonds", "no bond has broken"},
	{NULL, NULL, 0.0, NULL, NULL},
};

const struct rve_rule *rve_rule_find(const char *name)
{
	for (const struct rve_rule *rule = rve_rules; rule->name; rule++)
		if (!strcmp(rule->name, name))
			return rule;
	return NULL;
}

int rve_rule_choose(const struct rve_rule *rule, int n, const int *id, const double *value)
{
	int best = -1;
	for (int k = 0; k < n; k++) {
		if (!(value[k] > rule->above)) /* nor NAN */
			continue;
		if (best < 0 || value[k] > value[best] || (value[k] == value[best] && id[k] < id[best]))
			best = k;
	}
	return best;
}

int rve_rule_point(const struct rve_rule *rule, const struct mpm *mpm, struct run_fields *fields, int *point)
{
	int f = fields_find(fields, rule->field);
	*point = -1;
	if (f < 0)
		return STATUS_OK;
	double *value = malloc(sizeof *value * ((size_t)mpm->p.n + 1));
	if (!value)
		return error_set(STATUS_RESOURCE, "out of memory");
	fields_get(fields, mpm, f, value);
	for (int k = 0; k < mpm->p.n; k++)
		if (!mpm->laws[mpm->p.law[k]]->type->rve_view)
			value[k] = NAN;
	*point = rve_rule_choose(rule, mpm->p.n, mpm->p.id, value);
	free(value);
	return STATUS_OK;
}
