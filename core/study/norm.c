#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "study/job.h"
#include "study/points.h"
#include "study/series.h"

/* The curve of a combination, kept while the next norm may want it too. */
struct curve {
	const struct combination *of;
	struct csv_table *table;
};

struct evaluation {
	struct plan *plan;
	struct curve own, reference;
	struct csv_table *table; /* STUDY_TABLE */
	struct exact_reference exact;
};

static bool has_curve(const struct combination *c)
{
	return c->result.outcome == OUTCOME_DONE || c->result.outcome == OUTCOME_GUARD;
}

static int curve_get(struct curve *curve, const struct study *study, const struct combination *c)
{
	char path[FILE_PATH];
	if (curve->of == c)
		return STATUS_OK;
	csv_table_free(curve->table);
	curve->table = NULL, curve->of = NULL;
	CHECK(job_curve(study, c, path));
	if (!file_exists(path)) { /* a guard may stop before the first row */
		curve->table = calloc(1, sizeof *curve->table);
		curve->of = c;
		return curve->table ? STATUS_OK : error_set(STATUS_RESOURCE, "out of memory");
	}
	CHECK(csv_read(&curve->table, path, NULL));
	curve->of = c;
	return STATUS_OK;
}

/* A norm's curve: all of it, and the part that counts. */
struct norm_curve {
	struct series whole, part;
};

static void norm_curve_free(struct norm_curve *curve)
{
	series_free(&curve->whole);
	series_free(&curve->part);
}

static int norm_curve_get(struct norm_curve *curve, const struct csv_table *table, const struct study *study,
						  const struct combination *c, const struct study_norm *norm)
{
	const struct plan_place place = {study, c->choice};
	CHECK(series_of_table(&curve->whole, table, &place, norm->abscissa, norm->column));
	CHECK(series_copy(&curve->part, &curve->whole));
	series_window(&curve->part, norm->from, norm->until);
	return STATUS_OK;
}

/* ---- references ---- */

/* The probe's place at the start: the first row of its position. */
static int probe_place(const struct csv_table *table, const struct study_norm *norm, double X[2])
{
	char name[STUDY_TEXT + 16];
	const char *dot = strrchr(norm->column, '.');
	for (int c = 0; c < 2; c++) {
		snprintf(name, sizeof name, "%.*s.position_%c", dot ? (int)(dot - norm->column) : 0, norm->column, "xy"[c]);
		int k = csv_column(table, name);
		X[c] = !isnan(norm->at[c]) ? norm->at[c] : k >= 0 && table->rows ? table->values[k] : NAN;
	}
	if (isnan(X[0] + X[1]) && table->rows)
		return error_set(STATUS_INPUT,
						 "the norm %s: \"%s\" is no column of a probe, expected one, or `at`, for the exact solution",
						 norm->name, norm->column);
	return STATUS_OK;
}

static int exact_series(struct series *series, const struct evaluation *e, const struct study_norm *norm,
						const struct series *own)
{
	double X[2];
	const char *dot = strrchr(norm->column, '.');
	const char *expression = norm->exact[0] ? norm->exact : dot ? dot + 1 : norm->column;
	CHECK(probe_place(e->own.table, norm, X));
	CHECK(series_create(series, own->n));
	for (int k = 0; k < own->n; k++) {
		series->x[k] = own->x[k];
		int status = exact_reference_value(&e->exact, expression, X, own->x[k], &series->y[k]);
		if (status != STATUS_OK) {
			series_free(series);
			return error_context(status, "the norm %s", norm->name);
		}
	}
	return STATUS_OK;
}

/* The next run, from number *from on, that belongs to the reference of c; NULL after the last. */
static const struct combination *reference_next(const struct plan *plan, const struct combination *c, int *from)
{
	const struct combination *own = &plan->combinations[c->reference];
	if (!plan->study->reference.mean)
		return (*from)++ == 0 ? own : NULL;
	while (*from < plan->n) {
		const struct combination *other = &plan->combinations[(*from)++];
		if (plan_same_but_seed(plan->study, own, other))
			return other;
	}
	return NULL;
}

/* Mean of the reference's runs: number by number and, on the first one's abscissa, place by place. */
static int finest_series(struct series *mean, double *value, struct evaluation *e, const struct combination *c,
						 const struct study_norm *norm)
{
	const struct combination *other;
	int n = 0;
	*value = 0.0;
	for (int from = 0; (other = reference_next(e->plan, c, &from)); n++) {
		struct norm_curve one = {0};
		if (other->result.outcome != OUTCOME_DONE) { /* no reference, no error */
			*value = NAN;
			continue;
		}
		CHECK(curve_get(&e->reference, e->plan->study, other));
		CHECK(norm_curve_get(&one, e->reference.table, e->plan->study, other, norm));
		*value += series_value(&one.part, norm->kind, norm->level);
		if (!mean->x)
			CHECK(series_copy(mean, &one.part));
		else
			for (int k = 0; k < mean->n; k++)
				mean->y[k] += series_at(&one.whole, mean->x[k]);
		norm_curve_free(&one);
	}
	for (int k = 0; k < mean->n; k++)
		mean->y[k] /= n;
	*value /= n;
	return STATUS_OK;
}

/* ---- one norm ---- */

/* A run that a guard stopped is compared as far as it came; of others something must not be missing. */
static void cut_to(struct series *reference, const struct series *own, const struct combination *c)
{
	if (own->n && c->result.outcome == OUTCOME_GUARD)
		series_window(reference, own->x[0], own->x[own->n - 1]);
}

static int reference_series(struct series *reference, double *value, struct evaluation *e, const struct combination *c,
							const struct study_norm *norm, const struct series *own)
{
	struct norm_curve table = {0};
	switch (e->plan->study->reference.kind) {
	case STUDY_NO_REFERENCE:
		return STATUS_OK;
	case STUDY_FINEST:
		return finest_series(reference, value, e, c, norm);
	case STUDY_EXACT:
		CHECK(exact_series(reference, e, norm, own));
		break;
	case STUDY_TABLE:
		CHECK(norm_curve_get(&table, e->table, e->plan->study, c, norm));
		CHECK(series_copy(reference, &table.part));
		norm_curve_free(&table);
		break;
	}
	*value = series_value(reference, norm->kind, norm->level);
	return STATUS_OK;
}

static int column_norm(struct evaluation *e, const struct combination *c, const struct study_norm *norm, double *value,
					   double *error)
{
	const struct study *study = e->plan->study;
	struct norm_curve own = {0};
	struct series reference = {0};
	double reference_value = NAN;
	int status = norm_curve_get(&own, e->own.table, study, c, norm);
	if (status == STATUS_OK)
		status = reference_series(&reference, &reference_value, e, c, norm, &own.part);
	if (status == STATUS_OK)
		*value = series_value(&own.part, norm->kind, norm->level);
	if (status == STATUS_OK && study->reference.kind != STUDY_NO_REFERENCE) {
		bool of_numbers = norm->kind == NORM_MEAN || norm->kind == NORM_END || norm->kind == NORM_REACH;
		cut_to(&reference, &own.whole, c);
		*error = study->reference.mean && of_numbers
					 ? fabs(*value - reference_value)
					 : series_error(of_numbers ? &own.part : &own.whole, &reference, norm->kind, norm->level);
		if (norm->relative)
			*error *= norm->scale / fabs(reference_value);
	}
	norm_curve_free(&own);
	series_free(&reference);
	return status;
}

static int norm_evaluate(struct evaluation *e, struct combination *c, int k)
{
	const struct study *study = e->plan->study;
	const struct study_norm *norm = &study->norms[k];
	double value = NAN, error = NAN;
	int status = STATUS_OK;
	bool itself =
		study->reference.kind == STUDY_FINEST && !study->reference.mean && e->plan->combinations + c->reference == c;
	if (!has_curve(c))
		return STATUS_OK;
	if (norm->points[0]) {
		if (c->result.outcome == OUTCOME_DONE)
			status = points_norm(&e->exact, norm, c->folder, &value, &error);
	} else if ((status = curve_get(&e->own, study, c)) == STATUS_OK && e->own.table->rows > 0) {
		status = column_norm(e, c, norm, &value, &error);
	}
	c->result.value[k] = value / norm->scale;
	c->result.error[k] = itself ? NAN : error / norm->scale;
	return status;
}

static int evaluate(struct evaluation *e)
{
	const struct study *study = e->plan->study;
	if (study->reference.kind == STUDY_TABLE)
		CHECK(csv_read(&e->table, study->reference.table, NULL));
	for (int i = 0; i < e->plan->n; i++) {
		struct combination *c = &e->plan->combinations[i];
		for (int k = 0; k < study->n_norms; k++)
			c->result.value[k] = c->result.error[k] = NAN;
		if (study->reference.kind == STUDY_EXACT)
			CHECK(exact_reference_get(&e->exact, study, c->choice));
		for (int k = 0; k < study->n_norms; k++)
			CHECK(norm_evaluate(e, c, k));
	}
	return STATUS_OK;
}

int norms_evaluate(struct plan *plan)
{
	struct evaluation e = {.plan = plan};
	int status = evaluate(&e);
	csv_table_free(e.own.table);
	csv_table_free(e.reference.table);
	csv_table_free(e.table);
	return status;
}
