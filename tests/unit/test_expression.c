/* Arithmetic in text: values by hand, precedence, names, mistakes. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "../common/near.h"
#include "base/error.h"
#include "base/expression.h"

static bool lookup(void *context, const char *name, double *value)
{
	(void)context;
	*value = !strcmp(name, "x") ? 3.0 : !strcmp(name, "region.silo.mass") ? 100.0 : !strcmp(name, "a-b") ? 7.0 : 0.0;
	return *value != 0.0;
}

static void values(void **state)
{
	(void)state;
	static const struct {
		const char *text;
		double value;
	} cases[] = {{"1 + 2 * 3", 7},
				 {"(1 + 2) * 3", 9},
				 {"7 - 2 - 1", 4},
				 {"8 / 4 / 2", 1},
				 {"2 ^ 3 ^ 2", 512},
				 {"-2 ^ 2", -4},
				 {"2 ^ -1", 0.5},
				 {"- -3", 3},
				 {"1.5e-3*2", 3e-3},
				 {".5", 0.5},
				 {" x*x ", 9},
				 {"region.silo.mass/100", 1},
				 {"'a-b' - x", 4},
				 {"sqrt(16)+abs(-2)", 6},
				 {"min(x, 2) + max(x, 5)", 7},
				 {"exp(log(5))", 5},
				 {"round(2.6)", 3}};
	for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
		double value;
		if (expression_value(cases[k].text, lookup, NULL, &value) != STATUS_OK)
			fail_msg("%s: %s", cases[k].text, error_message());
		assert_near(value, cases[k].value, 1e-12);
	}
}

static void mistakes(void **state)
{
	(void)state;
	static const char *const cases[][2] = {{"1 +", "expected a number, a name or ("},
										   {"1 2", "expected an operator or the end"},
										   {"(1", "expected a closing )"},
										   {"y", "y is not known here"},
										   {"sin(1)", "no function is called sin"},
										   {"min(1)", "expected a comma"},
										   {"'x", "expected a number, a name or ("},
										   {"", "expected a number, a name or ("},
										   {"1 $ 2", "expected an operator or the end"}};
	double value;
	for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
		assert_int_equal(expression_value(cases[k][0], lookup, NULL, &value), STATUS_INPUT);
		if (!strstr(error_message(), cases[k][1]))
			fail_msg("%s: expected %s, got %s", cases[k][0], cases[k][1], error_message());
	}
	char deep[1000];
	memset(deep, '(', sizeof deep - 1), deep[sizeof deep - 1] = '\0';
	assert_int_equal(expression_value(deep, lookup, NULL, &value), STATUS_INPUT);
}

int main(void)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(values), cmocka_unit_test(mistakes)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
