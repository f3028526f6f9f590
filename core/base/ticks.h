/* Nice numbers for scales: steps of 1, 2, 2.5 and 5 times a power of ten, labels without useless digits, and
 * units with an SI prefix that suits the numbers. */
#ifndef TMDEMPM_BASE_TICKS_H
#define TMDEMPM_BASE_TICKS_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { TICKS_MAX = 24, TICKS_LABEL = 32, TICKS_UNIT = 32 };

/* The nice step that cuts `span` > 0 into about `n` parts. */
double ticks_step(double span, int n);

/* Widens a range of data to whole steps of about `n` parts; one without width gets some around its value.
 * `symmetric`: also makes it symmetric about zero (diverging maps). */
void ticks_widen(double range[2], int n, int symmetric);

/* The multiples of a nice step within [low, high], about n parts; where it can be, both ends are among them.
 * Returns how many (at most TICKS_MAX). */
int ticks_make(double low, double high, int n, double values[TICKS_MAX], double *step);

/* A tick's text with just the digits that `step` needs: "20", "0.25", "1.2e4".  `largest` = the largest
 * magnitude on the scale: all labels of one scale are plain or all have exponents. */
void ticks_label(double value, double step, double largest, char text[TICKS_LABEL]);

/* The unit to show numbers up to `largest` (in `unit`) in, e.g. "kPa" for 2e5 Pa: shown = value * factor.
 * Units without prefixes (K, C, -, rad ...) come back as they are, factor 1. */
double ticks_unit(const char *unit, double largest, char shown[TICKS_UNIT]);

/* Factor from one unit to another of the same kind (Pa to kPa: 1e-3); 0 if they do not fit each other. */
double ticks_unit_factor(const char *from, const char *to);

#ifdef __cplusplus
}
#endif
#endif
