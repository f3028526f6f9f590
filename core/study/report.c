#include "study/report.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "base/expression.h"
#include "io/csv.h"
#include "run/json.h"
#include "run/machine.h"
#include "study/job.h"
#include "version.h"

/* ---- stability ---- */

const char *verdict_name(enum verdict verdict)
{
	static const char *const names[] = {"none",         "stable",       "guarded",
										"conservative", "guarded late", "garbage unguarded"};
	return names[verdict];
}

/* Does any criterion say that what a run gave means nothing?  A run that died gave nothing. */
static bool is_garbage(const struct plan *plan, const struct combination *c)
{
	const struct study *study = plan->study;
	bool garbage = c->result.outcome == OUTCOME_FAILED;
	for (int k = 0; k < study->n_norms; k++) {
		const double *told = study->reference.kind == STUDY_NO_REFERENCE ? c->result.value : c->result.error;
		bool itself = study->reference.kind == STUDY_FINEST && &plan->combinations[c->reference] == c;
		if (!isnan(study->norms[k].garbage) && !itself)
			garbage |= !(fabs(told[k]) <= study->norms[k].garbage);
	}
	return garbage;
}

enum verdict verdict_of(const struct plan *plan, const struct combination *c)
{
	if (c->partner < 0)
		return VERDICT_NONE;
	const struct combination *other = &plan->combinations[c->partner];
	const struct combination *on = c->off ? other : c, *off = c->off ? c : other;
	if (on->result.outcome == OUTCOME_NONE || off->result.outcome == OUTCOME_NONE)
		return VERDICT_NONE;
	if (on->result.outcome == OUTCOME_DONE || on->result.outcome == OUTCOME_FAILED)
		return is_garbage(plan, on) ? VERDICT_GARBAGE : VERDICT_STABLE;
	if (on->result.outcome == OUTCOME_GUARD && on->result.cost.steps > 0 && is_garbage(plan, on))
		return VERDICT_LATE;
	return is_garbage(plan, off) ? VERDICT_GUARDED : VERDICT_CONSERVATIVE;
}

/* ---- study.csv ---- */

static void norm_names(struct csv_writer *w, const struct study *study, const char *ending)
{
	for (int k = 0; k < study->n_norms; k++) {
		char name[SCENE_NAME + 32];
		snprintf(name, sizeof name, "%s.%s", study->norms[k].name, ending);
		csv_name(w, name, study->norms[k].unit);
	}
}

static int csv_header(struct csv_writer *w, const struct study *study)
{
	for (int k = 0; k < study->n_knobs; k++)
		csv_name(w, study->knobs[k].name, study->knobs[k].unit);
	if (study->stability) {
		csv_text(w, "guards");
		csv_text(w, "verdict");
	}
	csv_text(w, "outcome");
	csv_text(w, "reference");
	csv_name(w, "wall", "s");
	csv_name(w, "cpu", "s");
	csv_name(w, "setup", "s");
	csv_name(w, "steps", "-");
	csv_name(w, "points", "-");
	csv_name(w, "point_steps", "-");
	csv_name(w, "disc_steps", "-");
	norm_names(w, study, "value");
	norm_names(w, study, "error");
	csv_text(w, "reason");
	csv_text(w, "folder");
	return csv_end_row(w);
}

static int csv_row(struct csv_writer *w, const struct plan *plan, const struct combination *c)
{
	const struct study *study = plan->study;
	const struct cost *cost = &c->result.cost;
	for (int k = 0; k < study->n_knobs; k++)
		csv_text(w, study->knobs[k].choices[c->choice[k]].name);
	if (study->stability) {
		csv_text(w, c->off ? "off" : "on");
		csv_text(w, verdict_name(verdict_of(plan, c)));
	}
	csv_text(w, outcome_name(c->result.outcome));
	csv_text(w, c->reference >= 0 && &plan->combinations[c->reference] == c ? "yes" : "no");
	csv_number(w, cost->wall);
	csv_number(w, cost->cpu);
	csv_number(w, cost->setup);
	csv_number(w, cost->steps);
	csv_number(w, cost->points);
	csv_number(w, cost->steps * cost->points);
	csv_number(w, cost->disc_steps);
	for (int k = 0; k < study->n_norms; k++)
		csv_number(w, c->result.value[k]);
	for (int k = 0; k < study->n_norms; k++)
		csv_number(w, c->result.error[k]);
	csv_text(w, c->result.reason);
	csv_text(w, strstr(c->folder, "runs/") ? strstr(c->folder, "runs/") : c->folder);
	return csv_end_row(w);
}

static int csv_rows(struct csv_writer *w, const struct plan *plan)
{
	CHECK(csv_header(w, plan->study));
	for (int k = 0; k < plan->n; k++)
		CHECK(csv_row(w, plan, &plan->combinations[k]));
	return STATUS_OK;
}

static int csv_file(const struct plan *plan, const char *folder, const char *name,
					int (*rows)(struct csv_writer *, const struct plan *))
{
	char path[FILE_PATH];
	struct csv_writer *w;
	CHECK(file_join(path, folder, name));
	CHECK(csv_create(&w, path));
	int status = rows(w, plan);
	if (status == STATUS_OK)
		return csv_close(w);
	csv_abandon(w);
	return status;
}

int report_write_csv(const struct plan *plan, const char *folder)
{
	return csv_file(plan, folder, "study.csv", csv_rows);
}

/* ---- summary.csv: over seeds ---- */

struct statistics {
	int n;
	double sum, squares;
};

static void add(struct statistics *s, double value)
{
	if (isnan(value))
		return;
	s->n++, s->sum += value, s->squares += value * value;
}

static double mean(const struct statistics *s) { return s->n ? s->sum / s->n : NAN; }

/* Of one run, not of the mean. */
static double deviation(const struct statistics *s)
{
	if (s->n < 2)
		return NAN;
	return sqrt(fmax(s->squares - s->sum * s->sum / s->n, 0.0) / (s->n - 1));
}

static bool first_of_group(const struct plan *plan, int i)
{
	for (int k = 0; k < i; k++)
		if (plan_same_but_seed(plan->study, &plan->combinations[k], &plan->combinations[i]))
			return false;
	return true;
}

static void csv_statistics(struct csv_writer *w, const struct statistics *s)
{
	csv_number(w, mean(s));
	csv_number(w, deviation(s));
}

static int summary_row(struct csv_writer *w, const struct plan *plan, const struct combination *c)
{
	const struct study *study = plan->study;
	struct statistics cpu = {0};
	int runs = 0;
	for (int k = 0; k < study->n_knobs; k++)
		if (!study->knobs[k].seed)
			csv_text(w, study->knobs[k].choices[c->choice[k]].name);
	for (int i = 0; i < plan->n; i++)
		if (plan_same_but_seed(study, &plan->combinations[i], c) &&
			plan->combinations[i].result.outcome == OUTCOME_DONE) {
			runs++;
			add(&cpu, plan->combinations[i].result.cost.cpu);
		}
	csv_integer(w, runs);
	csv_number(w, mean(&cpu));
	for (int k = 0; k < study->n_norms; k++) {
		struct statistics value = {0}, error = {0};
		for (int i = 0; i < plan->n; i++) {
			const struct combination *other = &plan->combinations[i];
			if (!plan_same_but_seed(study, other, c) || other->result.outcome != OUTCOME_DONE)
				continue;
			add(&value, other->result.value[k]);
			add(&error, other->result.error[k]);
		}
		csv_statistics(w, &value);
		csv_statistics(w, &error);
	}
	return csv_end_row(w);
}

static int summary_rows(struct csv_writer *w, const struct plan *plan)
{
	static const char *const endings[] = {"value", "value_deviation", "error", "error_deviation"};
	const struct study *study = plan->study;
	for (int k = 0; k < study->n_knobs; k++)
		if (!study->knobs[k].seed)
			csv_name(w, study->knobs[k].name, study->knobs[k].unit);
	csv_name(w, "runs", "-");
	csv_name(w, "cpu", "s");
	for (int k = 0; k < study->n_norms; k++)
		for (int e = 0; e < 4; e++) {
			char name[SCENE_NAME + 32];
			snprintf(name, sizeof name, "%s.%s", study->norms[k].name, endings[e]);
			csv_name(w, name, study->norms[k].unit);
		}
	CHECK(csv_end_row(w));
	for (int i = 0; i < plan->n; i++)
		if (first_of_group(plan, i))
			CHECK(summary_row(w, plan, &plan->combinations[i]));
	return STATUS_OK;
}

int report_write_summary(const struct plan *plan, const char *folder)
{
	bool seeds = false;
	for (int k = 0; k < plan->study->n_knobs; k++)
		seeds |= plan->study->knobs[k].seed;
	return seeds ? csv_file(plan, folder, "summary.csv", summary_rows) : STATUS_OK;
}

/* ---- study.json: what a chart needs beside the numbers ---- */

static void json_knobs(struct json *json, const struct study *study)
{
	json_open(json, "knobs", '[');
	for (int k = 0; k < study->n_knobs; k++) {
		const struct study_knob *knob = &study->knobs[k];
		json_open(json, NULL, '{');
		json_text(json, "name", knob->name);
		json_text(json, "label", knob->label);
		json_text(json, "unit", knob->unit);
		json_bool(json, "seed", knob->seed);
		json_open(json, "choices", '[');
		for (int c = 0; c < knob->n_choices; c++)
			json_text(json, NULL, knob->choices[c].name);
		json_close(json, ']');
		json_open(json, "values", '[');
		for (int c = 0; c < knob->n_choices; c++)
			json_number(json, NULL, knob->choices[c].value);
		json_close(json, ']');
		json_close(json, '}');
	}
	json_close(json, ']');
}

static void json_norms(struct json *json, const struct study *study)
{
	static const char *const kinds[] = {"rms", "max", "mean", "end", "reach"};
	json_open(json, "norms", '[');
	for (int k = 0; k < study->n_norms; k++) {
		const struct study_norm *norm = &study->norms[k];
		json_open(json, NULL, '{');
		json_text(json, "name", norm->name);
		json_text(json, "label", norm->label);
		json_text(json, "unit", norm->unit);
		json_text(json, "kind", kinds[norm->kind]);
		json_number(json, "garbage", norm->garbage);
		json_open(json, "gates", '[');
		if (!isnan(norm->gate))
			json_number(json, NULL, norm->gate);
		for (int g = 0; g < norm->n_gates; g++)
			json_number(json, NULL, norm->gates[g].bound);
		json_close(json, ']');
		json_close(json, '}');
	}
	json_close(json, ']');
}

struct curve_place {
	const char *knob;
	double x;
};

static bool curve_lookup(void *context, const char *name, double *value)
{
	const struct curve_place *place = context;
	*value = place->x;
	return !strcmp(name, place->knob);
}

/* A theory curve over the range of the map's first knob. */
static void json_curve(struct json *json, const struct study *study, const struct study_curve *curve)
{
	enum { SAMPLES = 200 };
	const struct study_knob *knob = &study->knobs[plan_knob(study, study->map[0])];
	double low = INFINITY, high = -INFINITY;
	for (int c = 0; c < knob->n_choices; c++) {
		low = fmin(low, knob->choices[c].value);
		high = fmax(high, knob->choices[c].value);
	}
	json_open(json, NULL, '{');
	json_text(json, "label", curve->label);
	for (int axis = 0; axis < 2; axis++) {
		json_open(json, axis ? "y" : "x", '[');
		for (int i = 0; i < SAMPLES; i++) {
			double t = (double)i / (SAMPLES - 1), y = NAN;
			struct curve_place place = {knob->name, low > 0.0 ? low * pow(high / low, t) : low + (high - low) * t};
			if (expression_value(curve->y, curve_lookup, &place, &y) != STATUS_OK)
				y = NAN;
			json_number(json, NULL, axis ? y : place.x);
		}
		json_close(json, ']');
	}
	json_close(json, '}');
}

static void json_fill(struct json *json, const struct plan *plan)
{
	const struct study *study = plan->study;
	struct machine machine;
	machine_look(&machine);
	json_open(json, NULL, '{');
	json_text(json, "program", "tmdempm " TMDEMPM_VERSION);
	json_text(json, "processor", machine.processor);
	json_text(json, "title", study->title);
	json_text(json, "kind", study->stability ? "stability" : "error");
	json_text(json, "reference",
			  study->reference.kind == STUDY_EXACT    ? study->reference.exact
			  : study->reference.kind == STUDY_FINEST ? study->reference.finest
			  : study->reference.kind == STUDY_TABLE  ? study->reference.table
													  : NULL);
	json_bool(json, "reference_mean", study->reference.mean);
	json_knobs(json, study);
	json_norms(json, study);
	json_open(json, "against", '[');
	for (int k = 0; k < study->against.n; k++)
		json_text(json, NULL, study->against.items[k]);
	json_close(json, ']');
	json_open(json, "map", '[');
	for (int k = 0; k < 2 && study->map[k][0]; k++)
		json_text(json, NULL, study->map[k]);
	json_close(json, ']');
	json_open(json, "curves", '[');
	for (int k = 0; k < study->n_curves && study->map[0][0]; k++)
		json_curve(json, study, &study->curves[k]);
	json_close(json, ']');
	json_close(json, '}');
}

int report_write_json(const struct plan *plan, const char *folder)
{
	char path[FILE_PATH];
	struct file_output output;
	CHECK(file_join(path, folder, "study.json"));
	CHECK(file_output_begin(&output, path));
	struct json json = {.stream = output.stream, .pretty = true};
	json_fill(&json, plan);
	fputc('\n', output.stream);
	return file_output_commit(&output);
}

/* ---- gates ---- */

struct verdicts {
	int missed, met;
	char first[1024];
};

static void miss(struct verdicts *v, const char *text)
{
	if (v->missed++ == 0)
		snprintf(v->first, sizeof v->first, "%s", text);
	fprintf(stderr, "gate missed: %s\n", text);
}

/* A run that has not ended well passes no gate. */
static void gate(struct verdicts *v, const struct combination *c, const struct study_norm *norm, double error,
				 double bound)
{
	char text[1024];
	if (c->result.outcome == OUTCOME_DONE && error <= bound) {
		v->met++;
		return;
	}
	if (c->result.outcome == OUTCOME_DONE)
		snprintf(text, sizeof text, "%s is %.4g, expected at most %.4g (%s)", norm->name, error, bound, c->name);
	else
		snprintf(text, sizeof text, "%s could not be had, expected at most %.4g (%s): %s %.400s", norm->name, bound,
				 c->name, outcome_name(c->result.outcome), c->result.reason);
	miss(v, text);
}

static void gates_of(struct verdicts *v, const struct plan *plan, const struct combination *c)
{
	const struct study *study = plan->study;
	bool itself = c->reference >= 0 && !study->reference.mean && &plan->combinations[c->reference] == c;
	for (int k = 0; k < study->n_norms && c->asked && !itself; k++) {
		const struct study_norm *norm = &study->norms[k];
		if (!isnan(norm->gate))
			gate(v, c, norm, c->result.error[k], norm->gate);
		for (int g = 0; g < norm->n_gates; g++)
			if (plan_matches(study, c->choice, norm->gates[g].where))
				gate(v, c, norm, c->result.error[k], norm->gates[g].bound);
	}
}

/* Slope of log error over log knob by least squares, over the runs that are like c but for this knob and seeds. */
static double observed_order(const struct plan *plan, const struct combination *c, int knob, int norm)
{
	const struct study *study = plan->study;
	double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
	for (int i = 0; i < plan->n; i++) {
		const struct combination *other = &plan->combinations[i];
		bool like = other->off == c->off && other->asked;
		for (int k = 0; k < study->n_knobs; k++)
			like = like && (k == knob || study->knobs[k].seed || other->choice[k] == c->choice[k]);
		double x = log(study->knobs[knob].choices[other->choice[knob]].value), y = log(other->result.error[norm]);
		bool itself = other->reference >= 0 && &plan->combinations[other->reference] == other;
		if (!like || itself)
			continue;
		if (other->result.outcome != OUTCOME_DONE)
			return NAN;
		n++, sx += x, sy += y, sxx += x * x, sxy += x * y;
	}
	return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

/* Is c the first of those that differ in the knob and seeds only? */
static bool first_along(const struct plan *plan, int i, int knob)
{
	const struct study *study = plan->study;
	for (int j = 0; j < i; j++) {
		bool like = plan->combinations[j].off == plan->combinations[i].off;
		for (int k = 0; k < study->n_knobs; k++)
			like = like && (k == knob || study->knobs[k].seed ||
							plan->combinations[j].choice[k] == plan->combinations[i].choice[k]);
		if (like)
			return false;
	}
	return true;
}

static void order_gate(struct verdicts *v, const struct plan *plan, const struct study_order *order)
{
	const struct study *study = plan->study;
	int knob = plan_knob(study, order->knob), norm = 0, groups = 0;
	while (strcmp(study->norms[norm].name, order->norm))
		norm++;
	for (int i = 0; i < plan->n; i++) {
		const struct combination *c = &plan->combinations[i];
		char text[1024];
		if (!first_along(plan, i, knob) || !plan_matches(study, c->choice, order->where))
			continue;
		double slope = observed_order(plan, c, knob, norm);
		groups++;
		snprintf(text, sizeof text, "the order of %s in %s is %.3f, expected at least %.3g (from %s)", order->norm,
				 order->knob, slope, order->least, c->name);
		if (slope >= order->least) {
			v->met++;
			printf("%s\n", text);
		} else {
			miss(v, text);
		}
	}
	if (!groups)
		miss(v, "an order is demanded where no run is");
}

int report_gates(const struct plan *plan)
{
	struct verdicts v = {0};
	for (int i = 0; i < plan->n; i++)
		gates_of(&v, plan, &plan->combinations[i]);
	for (int k = 0; k < plan->study->n_orders; k++)
		order_gate(&v, plan, &plan->study->orders[k]);
	if (v.missed)
		return error_set(STATUS_GUARD, "%s: %d of %d gates missed: %s", plan->study->file, v.missed, v.missed + v.met,
						 v.first);
	if (v.met)
		printf("%d gates met\n", v.met);
	return STATUS_OK;
}
