/* `tmdempm bench`: measured, not claimed.  Each case is repeated; value = median. */
#ifndef TMDEMPM_RUN_BENCH_H
#define TMDEMPM_RUN_BENCH_H

#include <stdbool.h>

/* One result, whose median it returns: a JSON object on one line (name, value, unit, min, max, repeats, threads) or a readable line. */
double bench_report(bool json, const char *name, const double *values, int repeats, const char *unit, int threads);

/* Prints machine, compiler and threads as a readable header (nothing for JSON, whose lines stand alone). */
void bench_header(bool json, int threads);

int bench_rve(bool json);
int bench_mpm(bool json);
int bench_image(bool json);

#endif
