/* Arithmetic in text: numbers, names, + - * / ^, brackets, and sqrt, abs, exp, log, round, min, max.
 *
 * A name is letters, digits, _ and dots ("region.silo.mass"); in single quotes it may hold anything.  What a name
 * means is the caller's: columns of a table, knobs of a study. */
#ifndef TMDEMPM_BASE_EXPRESSION_H
#define TMDEMPM_BASE_EXPRESSION_H

#include <stdbool.h>

/* The value of a name; false if it has none. */
typedef bool expression_lookup(void *context, const char *name, double *value);

/* STATUS_INPUT: what is wrong with the text, and where in it. */
int expression_value(const char *text, expression_lookup *lookup, void *context, double *value);

#endif
