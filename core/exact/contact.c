/* Heat through a contact. */
#include <math.h>

#include "exact/private.h"

enum {
	BLOCKS_LENGTH,
	BLOCKS_CONDUCTIVITY,
	BLOCKS_PRESSURE,
	BLOCKS_CONDUCTANCE,
	BLOCKS_REFERENCE,
	BLOCKS_EXPONENT,
	BLOCKS_COLD,
	BLOCKS_HOT
};

static const struct exact_parameter blocks_parameters[] = {
	[BLOCKS_LENGTH] = {"length", "m", 2.5e-3, "l of each block: the lower 0 <= Y < length, the upper up to 2 length"},
	[BLOCKS_CONDUCTIVITY] = {"conductivity", "W/(m K)", 150.0, "of both"},
	[BLOCKS_PRESSURE] = {"pressure", "Pa", 60e6, "p between them"},
	[BLOCKS_CONDUCTANCE] = {"conductance", "W/(m2 K)", 1e3, "of the contact at its reference pressure"},
	[BLOCKS_REFERENCE] = {"conductance_pressure", "Pa", 1e6, "that pressure"},
	[BLOCKS_EXPONENT] = {"conductance_exponent", "-", 1.0, "e: the conductance grows as p^e"},
	[BLOCKS_COLD] = {"temperature_cold", "T", 20.0, "at Y = 0"},
	[BLOCKS_HOT] = {"temperature_hot", "T", 50.0, "at Y = 2 length"},
};

/* Steady: straight lines to the temperatures of the two faces (DP-MPM eq. 90). */
static double blocks_value(const double *p, const double X[2], double t, enum exact_field field)
{
	(void)t;
	double l = p[BLOCKS_LENGTH], y = X[1], cold = p[BLOCKS_COLD], hot = p[BLOCKS_HOT];
	if (y < 0.0 || y > 2.0 * l)
		return NAN;
	if (field == EXACT_STRESS_YY)
		return -p[BLOCKS_PRESSURE];
	double conductance = p[BLOCKS_CONDUCTANCE] * pow(p[BLOCKS_PRESSURE] / p[BLOCKS_REFERENCE], p[BLOCKS_EXPONENT]);
	double ratio = conductance * l / p[BLOCKS_CONDUCTIVITY], share = ratio / (1.0 + 2.0 * ratio);
	return y < l ? cold + (hot - cold) * share * y / l : hot - (hot - cold) * share * (2.0 * l - y) / l;
}

const struct exact_solution exact_contact_blocks = {
	.name = "contact_blocks",
	.doc = "two blocks pressed together, one warm, one cold, with a contact whose conductance grows with the pressure: "
		   "the steady temperatures, and the stress_yy of the load",
	.fields = EXACT_BIT(EXACT_TEMPERATURE) | EXACT_BIT(EXACT_STRESS_YY),
	EXACT_PARAMETERS(blocks_parameters),
	.value = blocks_value,
};
