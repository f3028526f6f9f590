#include "study/series.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "base/expression.h"

static const double ROUNDING = 1e-9; /* of an abscissa's span */

int series_create(struct series *series, int n)
{
	series->n = n;
	series->x = malloc(((size_t)n + 1) * sizeof *series->x);
	series->y = malloc(((size_t)n + 1) * sizeof *series->y);
	if (series->x && series->y)
		return STATUS_OK;
	series_free(series);
	return error_set(STATUS_RESOURCE, "out of memory");
}

int series_copy(struct series *copy, const struct series *series)
{
	CHECK(series_create(copy, series->n));
	memcpy(copy->x, series->x, (size_t)series->n * sizeof *copy->x);
	memcpy(copy->y, series->y, (size_t)series->n * sizeof *copy->y);
	return STATUS_OK;
}

void series_free(struct series *series)
{
	free(series->x);
	free(series->y);
	*series = (struct series){0};
}

/* ---- from a table ---- */

struct table_row {
	const struct csv_table *table;
	const struct plan_place *place;
	int row;
};

static bool table_lookup(void *context, const char *name, double *value)
{
	const struct table_row *at = context;
	int k = csv_column(at->table, name);
	if (k < 0 && !strcmp(name, "row")) {
		*value = at->row;
		return true;
	}
	if (k < 0)
		return at->place && plan_lookup((void *)at->place, name, value);
	*value = at->table->values[(size_t)at->row * (size_t)at->table->columns + (size_t)k];
	return true;
}

static int series_fill(struct series *series, const struct csv_table *table, const struct plan_place *place,
					   const char *abscissa, const char *column)
{
	int n = 0;
	for (int k = 0; k < table->rows; k++) {
		struct table_row row = {table, place, k};
		double x, y;
		CHECK(expression_value(abscissa, table_lookup, &row, &x));
		CHECK(expression_value(column, table_lookup, &row, &y));
		if (isnan(x))
			continue;
		if (n > 0 && x < series->x[n - 1])
			return error_set(STATUS_INPUT, "the abscissa \"%s\" falls at row %d, expected one that grows (-(%s)?)",
							 abscissa, k + 1, abscissa);
		n += n == 0 || x > series->x[n - 1]; /* of two rows at one place the later one holds */
		series->x[n - 1] = x, series->y[n - 1] = y;
	}
	series->n = n;
	return STATUS_OK;
}

int series_of_table(struct series *series, const struct csv_table *table, const struct plan_place *place,
					const char *abscissa, const char *column)
{
	CHECK(series_create(series, table->rows));
	int status = series_fill(series, table, place, abscissa, column);
	if (status != STATUS_OK)
		series_free(series);
	return status == STATUS_INPUT ? error_context(status, "%s", table->path) : status;
}

/* ---- parts ---- */

static double slack(const struct series *s) { return s->n > 1 ? ROUNDING * (s->x[s->n - 1] - s->x[0]) : 0.0; }

void series_window(struct series *series, double from, double until)
{
	double some = slack(series);
	int n = 0;
	for (int k = 0; k < series->n; k++)
		if (!(series->x[k] < from - some) && !(series->x[k] > until + some)) {
			series->x[n] = series->x[k];
			series->y[n++] = series->y[k];
		}
	series->n = n;
}

double series_at(const struct series *s, double x)
{
	double some = slack(s);
	if (s->n == 0 || x < s->x[0] - some || x > s->x[s->n - 1] + some)
		return NAN;
	int low = 0, high = s->n - 1;
	while (high - low > 1) {
		int middle = (low + high) / 2;
		if (s->x[middle] <= x)
			low = middle;
		else
			high = middle;
	}
	if (high == low || x <= s->x[low])
		return s->y[low];
	if (x >= s->x[high])
		return s->y[high];
	return s->y[low] + (s->y[high] - s->y[low]) * (x - s->x[low]) / (s->x[high] - s->x[low]);
}

/* ---- numbers ---- */

/* Mean over x of y (power 1) or y^2 (power 2). */
static double mean_of(const struct series *s, int power)
{
	double sum = 0.0, width = 0.0;
	for (int k = 0; k < s->n; k++) {
		double left = k > 0 ? s->x[k] - s->x[k - 1] : 0.0, right = k + 1 < s->n ? s->x[k + 1] - s->x[k] : 0.0;
		double weight = s->n == 1 ? 1.0 : 0.5 * (left + right);
		sum += weight * (power == 2 ? s->y[k] * s->y[k] : s->y[k]);
		width += weight;
	}
	return width > 0.0 ? sum / width : NAN;
}

static double largest(const struct series *s)
{
	double most = s->n ? 0.0 : NAN;
	for (int k = 0; k < s->n && !isnan(most); k++)
		most = isnan(s->y[k]) ? NAN : fmax(most, fabs(s->y[k]));
	return most;
}

static double reach(const struct series *s, double level)
{
	for (int k = 0; k < s->n; k++) {
		if (s->y[k] == level)
			return s->x[k];
		if (k > 0 && (s->y[k - 1] < level) != (s->y[k] < level))
			return s->x[k - 1] + (s->x[k] - s->x[k - 1]) * (level - s->y[k - 1]) / (s->y[k] - s->y[k - 1]);
	}
	return NAN;
}

double series_value(const struct series *s, enum study_norm_kind kind, double level)
{
	switch (kind) {
	case NORM_RMS:
		return sqrt(mean_of(s, 2));
	case NORM_MAX:
		return largest(s);
	case NORM_MEAN:
		return mean_of(s, 1);
	case NORM_END:
		return s->n ? s->y[s->n - 1] : NAN;
	case NORM_REACH:
		return reach(s, level);
	}
	return NAN;
}

double series_error(const struct series *a, const struct series *b, enum study_norm_kind kind, double level)
{
	if (kind != NORM_RMS && kind != NORM_MAX)
		return fabs(series_value(a, kind, level) - series_value(b, kind, level));
	struct series difference;
	if (series_create(&difference, b->n) != STATUS_OK)
		return NAN;
	for (int k = 0; k < b->n; k++) {
		difference.x[k] = b->x[k];
		difference.y[k] = series_at(a, b->x[k]) - b->y[k];
	}
	double error = series_value(&difference, kind, level);
	series_free(&difference);
	return error;
}
