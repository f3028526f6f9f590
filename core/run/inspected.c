#include "run/inspected.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"

bool inspected_has_rve(const struct mpm *mpm, int point)
{
	return point >= 0 && mpm->laws[mpm->p.law[point]]->type->rve_view;
}

int inspected_nearest(const struct mpm *mpm, const double at[2])
{
	const struct particles *p = &mpm->p;
	int best = -1;
	double least = INFINITY;
	for (int k = 0; k < p->n; k++) {
		double distance = hypot(p->x[k][0] - at[0], p->x[k][1] - at[1]);
		if (inspected_has_rve(mpm, k) && (distance < least || (distance == least && p->id[k] < p->id[best])))
			best = k, least = distance;
	}
	return best;
}

static int lowest_id(const struct mpm *mpm)
{
	int best = -1;
	for (int k = 0; k < mpm->p.n; k++)
		if (inspected_has_rve(mpm, k) && (best < 0 || mpm->p.id[k] < mpm->p.id[best]))
			best = k;
	return best;
}

int inspected_point(const struct inspected *inspected, const struct inspected_rve *rve, int *point)
{
	const struct mpm *mpm = inspected->mpm;
	if (rve->rule) {
		CHECK(rve_rule_point(rve->rule, mpm, inspected->fields, point));
		*point = *point < 0 ? lowest_id(mpm) : *point;
	} else {
		*point = mpm_point_by_id(mpm, rve->id);
	}
	*point = inspected_has_rve(mpm, *point) ? *point : -1;
	return STATUS_OK;
}

struct inspected_rve *inspected_find(const struct inspected *inspected, const char *name)
{
	for (int i = 0; i < inspected->n; i++)
		if (!strcmp(inspected->rves[i].name, name))
			return &inspected->rves[i];
	return NULL;
}

/* A rule, or a place, needs something to choose from. */
static int none_to_choose(void) { return error_set(STATUS_INPUT, "no point of this run has an RVE"); }

int inspected_choose(const struct inspected *inspected, struct steering_command *command, struct inspected_rve *rve)
{
	const struct mpm *mpm = inspected->mpm;
	*rve = (struct inspected_rve){.id = -1, .since = -1};
	snprintf(rve->name, sizeof rve->name, "%s", command->name);
	if (command->target == STEER_RULE)
		return rve->rule = command->rule, lowest_id(mpm) >= 0 ? STATUS_OK : none_to_choose();
	if (command->target == STEER_AT) {
		int nearest = inspected_nearest(mpm, command->at);
		if (nearest < 0)
			return none_to_choose();
		command->target = STEER_POINT;
		command->point = mpm->p.id[nearest];
	}
	int point = mpm_point_by_id(mpm, rve->id = command->point);
	if (point < 0)
		return error_set(STATUS_INPUT, "there is no point %d, expected one of 0 to %d", rve->id, mpm->p.n - 1);
	if (!inspected_has_rve(mpm, point))
		return error_set(STATUS_INPUT, "point %d has no RVE: its law is %s", rve->id,
						 mpm->laws[mpm->p.law[point]]->name);
	return STATUS_OK;
}

bool inspected_is(const struct inspected *inspected, const struct inspected_rve *rve)
{
	const struct inspected_rve *there = inspected_find(inspected, rve->name);
	return there && there->rule == rve->rule && (rve->rule || there->id == rve->id);
}

int inspected_set(struct inspected *inspected, const struct inspected_rve *rve)
{
	struct inspected_rve *there = inspected_find(inspected, rve->name);
	if (there)
		return *there = *rve, STATUS_OK;
	struct inspected_rve *larger = realloc(inspected->rves, ((size_t)inspected->n + 1) * sizeof *larger);
	if (!larger)
		return error_set(STATUS_RESOURCE, "out of memory");
	inspected->rves = larger;
	larger[inspected->n++] = *rve;
	return STATUS_OK;
}

void inspected_remove(struct inspected *inspected, const char *name)
{
	struct inspected_rve *rve = inspected_find(inspected, name), *end = inspected->rves + inspected->n;
	if (!rve)
		return;
	memmove(rve, rve + 1, (size_t)(end - rve - 1) * sizeof *rve);
	inspected->n--;
}

static int inspected_add_scene(struct inspected *inspected, const struct scene_inspect *from)
{
	const struct mpm *mpm = inspected->mpm;
	struct inspected_rve rve = {.id = (int)from->id, .since = -1};
	snprintf(rve.name, sizeof rve.name, "%s", from->name);
	if (from->rule[0])
		rve.rule = rve_rule_find(from->rule);
	else if (from->id < 0)
		rve.id = mpm->p.id[mpm_point_nearest_initial(mpm, from->at)];
	return inspected_set(inspected, &rve);
}

int inspected_create(struct inspected **result, const struct mpm *mpm, struct run_fields *fields)
{
	*result = calloc(1, sizeof **result);
	if (!*result)
		return error_set(STATUS_RESOURCE, "out of memory");
	**result = (struct inspected){.mpm = mpm, .fields = fields};
	for (int i = 0; i < mpm->scene->n_inspect; i++)
		CHECK(inspected_add_scene(*result, &mpm->scene->inspect[i]));
	return STATUS_OK;
}

void inspected_free(struct inspected *inspected)
{
	if (!inspected)
		return;
	free(inspected->rves);
	free(inspected);
}
