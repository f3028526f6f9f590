#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "base/expression.h"
#include "study/private.h"

/* ---- selections ---- */

int plan_knob(const struct study *study, const char *name)
{
	for (int k = 0; k < study->n_knobs; k++)
		if (!strcmp(study->knobs[k].name, name))
			return k;
	return -1;
}

/* By name, or by number: "1e-4" is "0.0001". */
static int choice_find(const struct study_knob *knob, const char *name)
{
	char *end;
	double value = strtod(name, &end);
	for (int k = 0; k < knob->n_choices; k++)
		if (!strcmp(knob->choices[k].name, name))
			return k;
	for (int k = 0; k < knob->n_choices; k++)
		if (*name && !*end && knob->choices[k].value == value)
			return k;
	return -1;
}

/* Takes "knob=value" off a selection; false at its end. */
static bool selection_next(const char **at, char knob[SCENE_NAME], char value[SCENE_NAME])
{
	while (**at == ' ' || **at == ',')
		++*at;
	if (!**at)
		return false;
	int length = (int)strcspn(*at, ",");
	int equals = (int)strcspn(*at, "=,");
	int blank = equals, end = length;
	const char *from = *at + equals + (equals < length);
	while (blank > 0 && (*at)[blank - 1] == ' ')
		blank--;
	while (*from == ' ')
		from++;
	while (end > 0 && (*at)[end - 1] == ' ')
		end--;
	int n = (int)(*at + end - from);
	snprintf(knob, SCENE_NAME, "%.*s", blank, *at);
	snprintf(value, SCENE_NAME, "%.*s", n > 0 ? n : 0, from);
	*at += length;
	return true;
}

int plan_check_selection(const struct study *study, const char *selection)
{
	char knob[SCENE_NAME], value[SCENE_NAME];
	for (const char *at = selection; selection_next(&at, knob, value);) {
		int k = plan_knob(study, knob);
		if (k < 0)
			return error_set(STATUS_INPUT, "names \"%s\", expected \"knob=value, ...\" with names of knobs", knob);
		if (choice_find(&study->knobs[k], value) < 0)
			return error_set(STATUS_INPUT, "names %s = \"%s\", expected one of this knob's values", knob, value);
	}
	return STATUS_OK;
}

/* Sets what a selection names; `fixed` (if given) marks those knobs. */
static void selection_apply(const struct study *study, const char *selection, int *choice, bool *fixed)
{
	char knob[SCENE_NAME], value[SCENE_NAME];
	for (const char *at = selection; selection_next(&at, knob, value);) {
		int k = plan_knob(study, knob);
		choice[k] = choice_find(&study->knobs[k], value);
		if (fixed)
			fixed[k] = true;
	}
}

bool plan_same_but_seed(const struct study *study, const struct combination *a, const struct combination *b)
{
	bool same = a->off == b->off;
	for (int k = 0; k < study->n_knobs; k++)
		same = same && (study->knobs[k].seed || a->choice[k] == b->choice[k]);
	return same;
}

bool plan_matches(const struct study *study, const int *choice, const char *selection)
{
	char knob[SCENE_NAME], value[SCENE_NAME];
	for (const char *at = selection; selection_next(&at, knob, value);) {
		int k = plan_knob(study, knob);
		if (k < 0 || choice[k] != choice_find(&study->knobs[k], value))
			return false;
	}
	return true;
}

/* ---- expressions of knobs ---- */

bool plan_lookup(void *context, const char *name, double *value)
{
	const struct plan_place *place = context;
	int k = plan_knob(place->study, name);
	if (k < 0)
		return false;
	*value = place->study->knobs[k].choices[place->choice[k]].value;
	return !isnan(*value);
}

int plan_value(const struct study *study, const int *choice, const char *expression, double *value)
{
	struct plan_place place = {study, choice};
	return expression_value(expression, plan_lookup, &place, value);
}

/* One $(...): the name of a knob alone gives its text, anything else a number. */
static int template_piece(FILE *out, const struct study *study, const int *choice, const char *expression)
{
	double value;
	int k = plan_knob(study, expression);
	if (k >= 0) {
		fputs(study->knobs[k].choices[choice[k]].name, out);
		return STATUS_OK;
	}
	CHECK(plan_value(study, choice, expression, &value));
	fprintf(out, "%.15g", value);
	return STATUS_OK;
}

/* The bracket that closes the one at `at`. */
static const char *bracket_end(const char *at)
{
	int depth = 0;
	for (; *at; at++) {
		depth += *at == '(' ? 1 : *at == ')' ? -1 : 0;
		if (depth == 0)
			return at;
	}
	return NULL;
}

static int template_write(FILE *out, const struct study *study, const int *choice, const char *text)
{
	for (const char *at = text; *at;) {
		if (at[0] != '$' || at[1] != '(') {
			fputc(*at++, out);
			continue;
		}
		const char *end = bracket_end(at + 1);
		if (!end)
			return error_set(STATUS_INPUT, "\"%s\": $( is never closed, expected )", text);
		char expression[STUDY_TEXT];
		snprintf(expression, sizeof expression, "%.*s", (int)(end - at - 2), at + 2);
		int status = template_piece(out, study, choice, expression);
		if (status != STATUS_OK)
			return error_context(status, "\"%s\"", text);
		at = end + 1;
	}
	return STATUS_OK;
}

static int template_fill(char **result, const struct study *study, const int *choice, const char *text)
{
	size_t size;
	*result = NULL;
	FILE *out = open_memstream(result, &size);
	if (!out)
		return error_set(STATUS_RESOURCE, "out of memory");
	int status = template_write(out, study, choice, text);
	if (fclose(out) != 0 && status == STATUS_OK)
		status = error_set(STATUS_RESOURCE, "out of memory");
	return status;
}

/* ---- what a combination sets ---- */

static int sets_add(struct combination *c, const struct study *study, const struct study_texts *texts)
{
	const char **larger = realloc(c->sets.items, (size_t)(c->sets.n + texts->n + 1) * sizeof *larger);
	if (!larger)
		return error_set(STATUS_RESOURCE, "out of memory");
	c->sets.items = larger;
	for (int k = 0; k < texts->n; k++) {
		char *text;
		int status = template_fill(&text, study, c->choice, texts->items[k]);
		if (status != STATUS_OK) {
			free(text);
			return status;
		}
		c->sets.items[c->sets.n++] = text;
	}
	return STATUS_OK;
}

/* Runs of a study draw nothing and write what its norms need; the study itself has the last word. */
static struct study_texts quiet_sets(const struct study *study)
{
	static const char *const sets[] = {"images=()", "output.vtk=false", "output.checkpoint_every=0",
									   "output.snapshot_every=0"};
	struct study_texts texts = {.n = study->load.n ? 0 : 4, .items = (const char **)sets};
	for (int k = 0; k < study->n_norms; k++)
		if (study->norms[k].points[0] && texts.n == 4)
			texts.n = 3;
	return texts;
}

static int combination_sets(struct combination *c, const struct study *study)
{
	struct study_texts quiet = quiet_sets(study);
	CHECK(sets_add(c, study, &quiet));
	CHECK(sets_add(c, study, study->load.n ? &study->load : &study->scene.set));
	for (int k = 0; k < study->n_knobs; k++) {
		CHECK(sets_add(c, study, &study->knobs[k].set));
		CHECK(sets_add(c, study, &study->knobs[k].choices[c->choice[k]].set));
	}
	return c->off ? sets_add(c, study, &study->guards_off) : STATUS_OK;
}

static void combination_name(struct combination *c, const struct study *study)
{
	size_t used = 0;
	for (int k = 0; k < study->n_knobs && used < sizeof c->name; k++)
		used += (size_t)snprintf(c->name + used, sizeof c->name - used, "%s%s=%s", k ? ", " : "", study->knobs[k].name,
								 study->knobs[k].choices[c->choice[k]].name);
	if (c->off && used < sizeof c->name)
		snprintf(c->name + used, sizeof c->name - used, ", guards off");
}

/* ---- the list ---- */

static int plan_find(const struct plan *plan, const int *choice, bool off)
{
	size_t size = (size_t)plan->study->n_knobs * sizeof *choice;
	for (int k = 0; k < plan->n; k++)
		if (plan->combinations[k].off == off && !memcmp(plan->combinations[k].choice, choice, size))
			return k;
	return -1;
}

/* The number of the combination, made if it is new. */
static int plan_add(struct plan *plan, const int *choice, bool off, bool asked, int *number)
{
	const struct study *study = plan->study;
	int k = plan_find(plan, choice, off);
	if (k < 0) {
		if (plan->n == plan->capacity) {
			int capacity = 2 * plan->capacity + 32;
			struct combination *larger = realloc(plan->combinations, (size_t)capacity * sizeof *larger);
			if (!larger)
				return error_set(STATUS_RESOURCE, "out of memory");
			plan->combinations = larger, plan->capacity = capacity;
		}
		k = plan->n++;
		struct combination *c = &plan->combinations[k];
		*c = (struct combination){.off = off, .partner = -1, .reference = -1};
		c->choice = malloc((size_t)study->n_knobs * sizeof *choice);
		c->result.value = malloc(((size_t)study->n_norms + 1) * sizeof(double));
		c->result.error = malloc(((size_t)study->n_norms + 1) * sizeof(double));
		if (!c->choice || !c->result.value || !c->result.error)
			return error_set(STATUS_RESOURCE, "out of memory");
		memcpy(c->choice, choice, (size_t)study->n_knobs * sizeof *choice);
		combination_name(c, study);
		CHECK(combination_sets(c, study));
	}
	plan->combinations[k].asked |= asked;
	if (number)
		*number = k;
	return STATUS_OK;
}

/* Every value of the knobs that are not fixed. */
static int plan_product(struct plan *plan, int *choice, const bool *fixed, int knob)
{
	if (knob == plan->study->n_knobs)
		return plan_add(plan, choice, false, true, NULL);
	if (fixed[knob])
		return plan_product(plan, choice, fixed, knob + 1);
	for (int v = 0; v < plan->study->knobs[knob].n_choices; v++) {
		choice[knob] = v;
		CHECK(plan_product(plan, choice, fixed, knob + 1));
	}
	return STATUS_OK;
}

/* The base, and one knob after the other through its values; all that with every seed. */
static int plan_one_at_a_time(struct plan *plan, int *choice, bool *fixed)
{
	const struct study *study = plan->study;
	size_t size = (size_t)study->n_knobs * sizeof *choice;
	int *base = malloc(size);
	if (!base)
		return error_set(STATUS_RESOURCE, "out of memory");
	memset(base, 0, size);
	selection_apply(study, study->base, base, NULL);
	memcpy(choice, base, size);
	for (int k = 0; k < study->n_knobs; k++)
		fixed[k] = !study->knobs[k].seed;
	int status = plan_product(plan, choice, fixed, 0);
	for (int k = 0; k < study->n_knobs && status == STATUS_OK; k++) {
		if (study->knobs[k].seed)
			continue;
		memcpy(choice, base, size);
		fixed[k] = false;
		status = plan_product(plan, choice, fixed, 0);
		fixed[k] = true;
	}
	free(base);
	return status;
}

static int plan_list(struct plan *plan, int *choice, bool *fixed)
{
	const struct study *study = plan->study;
	for (int k = 0; k < study->combinations.n; k++) {
		memset(fixed, 0, (size_t)study->n_knobs * sizeof *fixed);
		selection_apply(study, study->combinations.items[k], choice, fixed);
		CHECK(plan_product(plan, choice, fixed, 0));
	}
	return STATUS_OK;
}

static int plan_references(struct plan *plan, int *choice)
{
	const struct study *study = plan->study;
	if (study->reference.kind != STUDY_FINEST)
		return STATUS_OK;
	for (int k = 0; k < plan->n; k++) { /* grows: a reference is its own reference */
		int number;
		memcpy(choice, plan->combinations[k].choice, (size_t)study->n_knobs * sizeof *choice);
		selection_apply(study, study->reference.finest, choice, NULL);
		CHECK(plan_add(plan, choice, plan->combinations[k].off, false, &number));
		plan->combinations[k].reference = number;
	}
	return STATUS_OK;
}

/* A stability study runs everything once more, without guards. */
static int plan_partners(struct plan *plan)
{
	int n = plan->n;
	for (int k = 0; k < n && plan->study->stability; k++) {
		int number;
		CHECK(plan_add(plan, plan->combinations[k].choice, true, true, &number));
		plan->combinations[k].partner = number;
		plan->combinations[number].partner = k;
	}
	return STATUS_OK;
}

static int plan_fill(struct plan *plan, int *choice, bool *fixed)
{
	switch (plan->study->plan) {
	case STUDY_PRODUCT:
		CHECK(plan_product(plan, choice, fixed, 0));
		break;
	case STUDY_ONE_AT_A_TIME:
		CHECK(plan_one_at_a_time(plan, choice, fixed));
		break;
	case STUDY_LIST:
		CHECK(plan_list(plan, choice, fixed));
		break;
	}
	CHECK(plan_partners(plan));
	return plan_references(plan, choice);
}

int plan_create(struct plan *plan, const struct study *study)
{
	*plan = (struct plan){.study = study};
	int *choice = calloc((size_t)study->n_knobs, sizeof *choice);
	bool *fixed = calloc((size_t)study->n_knobs, sizeof *fixed);
	int status = choice && fixed ? plan_fill(plan, choice, fixed) : error_set(STATUS_RESOURCE, "out of memory");
	free(choice);
	free(fixed);
	if (status != STATUS_OK) {
		plan_free(plan);
		return status == STATUS_INPUT ? error_context(status, "%s", study->file) : status;
	}
	return status;
}

void plan_free(struct plan *plan)
{
	for (int k = 0; k < plan->n; k++) {
		struct combination *c = &plan->combinations[k];
		for (int i = 0; i < c->sets.n; i++)
			free((char *)c->sets.items[i]);
		free(c->sets.items);
		free(c->choice);
		free(c->result.value);
		free(c->result.error);
	}
	free(plan->combinations);
	*plan = (struct plan){0};
}
