/* Rules that choose an RVE among all: the hottest, the most sheared ...
 *
 * A rule looks for the largest value of a field of the points (run/fields.h), so that a running simulation, its
 * snapshots and its checkpoint are asked in the same way. */
#ifndef TMDEMPM_RUN_RULES_H
#define TMDEMPM_RUN_RULES_H

#include "run/fields.h"

struct rve_rule {
	const char *name;
	const char *field; /* scalar; the largest value is chosen */
	double above;      /* values that are not above this choose nothing */
	const char *doc;
	const char *nothing; /* what it means when nothing is chosen */
};

/* Every rule there is; the last has the name NULL. */
extern const struct rve_rule rve_rules[];

/* NULL if there is none of this name. */
const struct rve_rule *rve_rule_find(const char *name);

/* Index of the point that a rule chooses by its field's values, -1 if none; among equals the one with the lowest id.
 * Points without an RVE have NAN. */
int rve_rule_choose(const struct rve_rule *rule, int n, const int *id, const double *value);

/* The same of a simulation as it is: the point's index in storage, or -1.  Returns STATUS_RESOURCE without memory. */
int rve_rule_point(const struct rve_rule *rule, const struct mpm *mpm, struct run_fields *fields, int *point);

#endif
