#include "base/expression.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"

enum { DEPTH_MAX = 64, NAME_MAX_BYTES = 256 };

struct parser {
	const char *text, *at;
	expression_lookup *lookup;
	void *context;
	int depth;
};

static int parse_sum(struct parser *p, double *value);

static int wrong(const struct parser *p, const char *expected)
{
	return error_set(STATUS_INPUT, "\"%s\" cannot be understood at \"%.20s\", expected %s", p->text, p->at, expected);
}

static void skip_blanks(struct parser *p)
{
	while (isspace((unsigned char)*p->at))
		p->at++;
}

static bool take(struct parser *p, char c)
{
	skip_blanks(p);
	if (*p->at != c)
		return false;
	p->at++;
	return true;
}

/* f(a) or f(a, b), behind its opening bracket. */
static int parse_call(struct parser *p, const char *name, double *value)
{
	static const struct {
		const char *name;
		double (*one)(double), (*two)(double, double);
	} functions[] = {{"sqrt", sqrt, NULL},   {"abs", fabs, NULL}, {"exp", exp, NULL}, {"log", log, NULL},
					 {"round", round, NULL}, {"min", NULL, fmin}, {"max", NULL, fmax}};
	for (size_t k = 0; k < sizeof functions / sizeof *functions; k++) {
		double a, b = 0.0;
		if (strcmp(functions[k].name, name))
			continue;
		CHECK(parse_sum(p, &a));
		if (functions[k].two) {
			if (!take(p, ','))
				return wrong(p, "a comma and a second value");
			CHECK(parse_sum(p, &b));
		}
		*value = functions[k].one ? functions[k].one(a) : functions[k].two(a, b);
		return take(p, ')') ? STATUS_OK : wrong(p, "a closing )");
	}
	return error_set(STATUS_INPUT, "\"%s\": no function is called %s, expected sqrt, abs, exp, log, round, min or max",
					 p->text, name);
}

static int parse_name(struct parser *p, double *value)
{
	char name[NAME_MAX_BYTES];
	bool quoted = *p->at == '\'';
	const char *start = p->at + quoted, *end = start;
	if (quoted)
		end += strcspn(start, "'");
	else
		while (isalnum((unsigned char)*end) || *end == '_' || *end == '.')
			end++;
	if (end == start || (quoted && !*end) || end - start >= NAME_MAX_BYTES)
		return wrong(p, "a number, a name or (");
	memcpy(name, start, (size_t)(end - start)), name[end - start] = '\0';
	p->at = end + quoted;
	if (!quoted && take(p, '('))
		return parse_call(p, name, value);
	if (!p->lookup || !p->lookup(p->context, name, value))
		return error_set(STATUS_INPUT, "\"%s\": %s is not known here", p->text, name);
	return STATUS_OK;
}

static int parse_atom(struct parser *p, double *value)
{
	char *end;
	skip_blanks(p);
	if (take(p, '(')) {
		CHECK(parse_sum(p, value));
		return take(p, ')') ? STATUS_OK : wrong(p, "a closing )");
	}
	if (!isdigit((unsigned char)*p->at) && *p->at != '.')
		return parse_name(p, value);
	*value = strtod(p->at, &end);
	if (end == p->at)
		return wrong(p, "a number");
	p->at = end;
	return STATUS_OK;
}

/* -a ^ b is -(a ^ b); a ^ b ^ c is a ^ (b ^ c). */
static int parse_power(struct parser *p, double *value)
{
	double exponent;
	if (p->depth == DEPTH_MAX)
		return wrong(p, "fewer brackets");
	p->depth++;
	if (take(p, '-')) {
		CHECK(parse_power(p, value));
		*value = -*value;
	} else {
		CHECK(parse_atom(p, value));
		if (take(p, '^')) {
			CHECK(parse_power(p, &exponent));
			*value = pow(*value, exponent);
		}
	}
	p->depth--;
	return STATUS_OK;
}

static int parse_product(struct parser *p, double *value)
{
	double factor;
	CHECK(parse_power(p, value));
	for (;;) {
		if (take(p, '*')) {
			CHECK(parse_power(p, &factor));
			*value *= factor;
		} else if (take(p, '/')) {
			CHECK(parse_power(p, &factor));
			*value /= factor;
		} else {
			return STATUS_OK;
		}
	}
}

static int parse_sum(struct parser *p, double *value)
{
	double term;
	CHECK(parse_product(p, value));
	for (;;) {
		if (take(p, '+')) {
			CHECK(parse_product(p, &term));
			*value += term;
		} else if (take(p, '-')) {
			CHECK(parse_product(p, &term));
			*value -= term;
		} else {
			return STATUS_OK;
		}
	}
}

int expression_value(const char *text, expression_lookup *lookup, void *context, double *value)
{
	struct parser p = {.text = text, .at = text, .lookup = lookup, .context = context};
	CHECK(parse_sum(&p, value));
	skip_blanks(&p);
	return *p.at ? wrong(&p, "an operator or the end") : STATUS_OK;
}
