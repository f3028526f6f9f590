#include "base/ticks.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

/* Relative slack for comparing multiples of a step with the ends of a range. */
static const double SLACK = 1e-9;

double ticks_step(double span, int n)
{
	static const double nice[] = {1, 2, 2.5, 5, 10};
	double raw = span / (n > 0 ? n : 1), power = pow(10, floor(log10(raw)));
	for (size_t k = 0; k < sizeof nice / sizeof *nice; k++)
		if (raw <= nice[k] * power * (1 + SLACK))
			return nice[k] * power;
	return 10 * power;
}

void ticks_widen(double range[2], int n, int symmetric)
{
	double largest = fmax(fabs(range[0]), fabs(range[1]));
	if (symmetric) {
		range[0] = -largest;
		range[1] = largest;
	}
	if (!(range[1] - range[0] > 1e-9 * largest)) {
		double middle = 0.5 * (range[0] + range[1]), half = largest > 0 ? 0.5 * pow(10, floor(log10(largest))) : 0.5;
		range[0] = middle - half;
		range[1] = middle + half;
	}
	double step = ticks_step(range[1] - range[0], n);
	range[0] = step * floor(range[0] / step + SLACK);
	range[1] = step * ceil(range[1] / step - SLACK);
}

static bool is_multiple(double value, double step)
{
	double k = value / step;
	return fabs(k - round(k)) < 1e-6;
}

int ticks_make(double low, double high, int n, double values[TICKS_MAX], double *step)
{
	*step = ticks_step(high - low, n);
	static const int others[] = {1, -1, 2, -2};
	for (int k = 0; k < 4 && !(is_multiple(low, *step) && is_multiple(high, *step)); k++) {
		double other = ticks_step(high - low, n + others[k]);
		if (is_multiple(low, other) && is_multiple(high, other))
			*step = other;
	}
	double first = ceil(low / *step - SLACK), last = floor(high / *step + SLACK);
	int count = 0;
	for (double k = first; k <= last && count < TICKS_MAX; k++)
		values[count++] = k == 0 ? 0 : k * *step;
	return count;
}

/* Decimals that tell multiples of `step` apart: 0.25 -> 2, 20 -> 0. */
static int decimals_of(double step)
{
	for (int d = 0; d < 15; d++) {
		double scaled = step * pow(10, d);
		if (fabs(scaled - round(scaled)) < 1e-6 * scaled)
			return d;
	}
	return 15;
}

void ticks_label(double value, double step, double largest, char text[TICKS_LABEL])
{
	if (fabs(value) < 1e-6 * step) {
		snprintf(text, TICKS_LABEL, "0");
	} else if (largest < 99999.5 && largest >= 1e-2 && decimals_of(step) <= 4) {
		snprintf(text, TICKS_LABEL, "%.*f", decimals_of(step), value);
	} else {
		int exponent = (int)floor(log10(fabs(value)) + SLACK);
		double power = pow(10, exponent);
		snprintf(text, TICKS_LABEL, "%.*fe%d", decimals_of(step / power), value / power, exponent);
	}
}

struct prefix {
	const char *text;
	double factor;
};
static const struct prefix prefixes[] = {{"G", 1e9},  {"M", 1e6},         {"k", 1e3}, {"", 1},
										 {"m", 1e-3}, {"\xc2\xb5", 1e-6}, {"n", 1e-9}};
enum { N_PREFIXES = sizeof prefixes / sizeof *prefixes };

/* Units that take prefixes, and the largest and smallest that readers are used to. */
static const struct {
	const char *unit;
	double most, least;
} scalable[] = {
	{"Pa", 1e9, 1},   {"N", 1e6, 1e-6},    {"m", 1, 1e-9},      {"J", 1e9, 1e-9},    {"W", 1e6, 1e-6},
	{"m/s", 1, 1e-6}, {"W/m3", 1e9, 1e-3}, {"J/m3", 1e9, 1e-3}, {"W/m2", 1e9, 1e-3}, {"N/m", 1e6, 1e-6},
};
enum { N_SCALABLE = sizeof scalable / sizeof *scalable };

double ticks_unit(const char *unit, double largest, char shown[TICKS_UNIT])
{
	snprintf(shown, TICKS_UNIT, "%s", unit);
	if (!(largest > 0) || (largest >= 0.1 && largest < 1000))
		return 1;
	for (int s = 0; s < N_SCALABLE; s++) {
		if (strcmp(unit, scalable[s].unit) != 0)
			continue;
		for (int p = 0; p < N_PREFIXES; p++) {
			double factor = prefixes[p].factor;
			if (factor > scalable[s].most * 1.5 || factor < scalable[s].least / 1.5)
				continue;
			bool last = p + 1 == N_PREFIXES || prefixes[p + 1].factor < scalable[s].least / 1.5;
			if (largest >= factor * (1 - SLACK) || last) {
				snprintf(shown, TICKS_UNIT, "%s%s", prefixes[p].text, unit);
				return 1 / factor;
			}
		}
	}
	return 1;
}

/* Splits "kPa" into its factor and "Pa"; 0 if the rest is not `base`. */
static double factor_of(const char *unit, const char *base)
{
	for (int p = 0; p < N_PREFIXES; p++) {
		size_t n = strlen(prefixes[p].text);
		if (strncmp(unit, prefixes[p].text, n) == 0 && strcmp(unit + n, base) == 0)
			return prefixes[p].factor;
	}
	if (unit[0] == 'u' && strcmp(unit + 1, base) == 0)
		return 1e-6;
	return 0;
}

double ticks_unit_factor(const char *from, const char *to)
{
	if (strcmp(from, to) == 0)
		return 1;
	for (int s = 0; s < N_SCALABLE; s++) {
		double a = factor_of(from, scalable[s].unit), b = factor_of(to, scalable[s].unit);
		if (a > 0 && b > 0)
			return a / b;
	}
	return 0;
}
