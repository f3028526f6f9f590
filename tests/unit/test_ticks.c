/* Numbers and units on scales. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "base/ticks.h"

static void check_ticks(double low, double high, int n, const char *expected)
{
	double values[TICKS_MAX], step;
	int count = ticks_make(low, high, n, values, &step);
	char all[512] = "";
	for (int k = 0; k < count; k++) {
		char text[TICKS_LABEL];
		ticks_label(values[k], step, fmax(fabs(low), fabs(high)), text);
		strcat(all, k ? " " : "");
		strcat(all, text);
	}
	assert_string_equal(all, expected);
}

static void test_labels(void **state)
{
	(void)state;
	check_ticks(0, 100, 5, "0 20 40 60 80 100");
	check_ticks(20, 21, 5, "20.0 20.2 20.4 20.6 20.8 21.0");
	check_ticks(-1, 1, 4, "-1.0 -0.5 0 0.5 1.0");
	check_ticks(-3, 3, 5, "-3 -2 -1 0 1 2 3");
	check_ticks(-0.6, 0.6, 5, "-0.6 -0.4 -0.2 0 0.2 0.4 0.6");
	check_ticks(0.3, 0.7, 4, "0.3 0.4 0.5 0.6 0.7");
	check_ticks(0, 1, 4, "0 0.25 0.50 0.75 1.00");
	check_ticks(0, 40000, 4, "0 10000 20000 30000 40000");
	check_ticks(0, 6e5, 3, "0 2e5 4e5 6e5");
	check_ticks(-5e-6, 5e-6, 4, "-5.0e-6 -2.5e-6 0 2.5e-6 5.0e-6");
	check_ticks(0.9e6, 1.2e6, 3, "9e5 1.0e6 1.1e6 1.2e6");
}

static void test_widen(void **state)
{
	(void)state;
	double a[2] = {20.03, 58.7};
	ticks_widen(a, 5, 0);
	assert_true(fabs(a[0] - 20) < 1e-12 && fabs(a[1] - 60) < 1e-12);
	double b[2] = {-0.7, 3.1};
	ticks_widen(b, 5, 1);
	assert_true(b[0] == -b[1] && b[1] >= 3.1);
	double c[2] = {20, 20}, d[2] = {0, 0}, e[2] = {-3e5, -3e5};
	ticks_widen(c, 5, 0), ticks_widen(d, 5, 0), ticks_widen(e, 5, 0);
	assert_true(c[0] < 20 && c[1] > 20);
	assert_true(d[0] < 0 && d[1] > 0);
	assert_true(e[0] < -3e5 && e[1] > -3e5);
	double f[2] = {0, 50};
	ticks_widen(f, 5, 0); /* already nice: stays */
	assert_true(f[0] == 0 && f[1] == 50);
}

static void check_unit(const char *unit, double largest, const char *shown, double factor)
{
	char text[TICKS_UNIT];
	assert_true(fabs(ticks_unit(unit, largest, text) / factor - 1) < 1e-12);
	assert_string_equal(text, shown);
}

static void test_units(void **state)
{
	(void)state;
	check_unit("Pa", 2e5, "kPa", 1e-3);
	check_unit("Pa", 1e6, "MPa", 1e-6);
	check_unit("Pa", 50, "Pa", 1);
	check_unit("Pa", 1e-3, "Pa", 1);
	check_unit("m", 2e-5, "\xc2\xb5m", 1e6);
	check_unit("m", 2e-3, "mm", 1e3);
	check_unit("m", 5e4, "m", 1);
	check_unit("m/s", 0.5, "m/s", 1);
	check_unit("K", 5e3, "K", 1);
	check_unit("-", 1e-6, "-", 1);
	assert_true(fabs(ticks_unit_factor("Pa", "kPa") / 1e-3 - 1) < 1e-12);
	assert_true(fabs(ticks_unit_factor("m", "um") / 1e6 - 1) < 1e-12);
	assert_true(ticks_unit_factor("K", "K") == 1);
	assert_true(ticks_unit_factor("K", "Pa") == 0);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_labels),
		cmocka_unit_test(test_widen),
		cmocka_unit_test(test_units),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
