/* Equilibrium, and the wave of an impact. */
#include <math.h>

#include "exact/private.h"

/* ---- the column under its own weight ---- */

enum { COLUMN_LENGTH, COLUMN_DENSITY, COLUMN_GRAVITY, COLUMN_MODULUS };

static const struct exact_parameter column_parameters[] = {
	[COLUMN_LENGTH] = {"length", "m", 50.0, "l0, of the column before it is loaded, 0 <= Y <= length"},
	[COLUMN_DENSITY] = {"density", "kg/m3", 80.0, "density before it is loaded"},
	[COLUMN_GRAVITY] = {"gravity", "m/s2", 9.81, "downwards"},
	[COLUMN_MODULUS] = {"modulus", "Pa", 1e6, "uniaxial stiffness"},
};

static double column_value(const double *p, const double X[2], double t, enum exact_field field)
{
	(void)t;
	double weight = p[COLUMN_DENSITY] * p[COLUMN_GRAVITY], L = p[COLUMN_LENGTH], Y = X[1];
	if (Y < 0.0 || Y > L)
		return NAN;
	return field == EXACT_STRESS_YY ? -weight * (L - Y) : -weight / p[COLUMN_MODULUS] * Y * (L - 0.5 * Y);
}

const struct exact_solution exact_column = {
	.name = "column",
	.doc =
		"column under its own weight, held sideways: stress_yy = -rho g (l0 - Y) by any law, displacement_y at small "
		"strain",
	.fields = EXACT_BIT(EXACT_STRESS_YY) | EXACT_BIT(EXACT_DISPLACEMENT_Y),
	EXACT_PARAMETERS(column_parameters),
	.value = column_value,
};

/* ---- heated and held ---- */

enum { HELD_YOUNG, HELD_POISSON, HELD_EXPANSION, HELD_WARMING };

static const struct exact_parameter restrained_parameters[] = {
	[HELD_YOUNG] = {"young", "Pa", 1e7, "Young's modulus"},
	[HELD_POISSON] = {"poisson", "-", 0.0, "Poisson's ratio"},
	[HELD_EXPANSION] = {"expansion", "1/K", 1e-5, "linear thermal expansion"},
	[HELD_WARMING] = {"temperature_step", "K", 20.0, "warming"},
};

static double restrained_value(const double *p, const double X[2], double t, enum exact_field field)
{
	(void)X, (void)t, (void)field;
	return -p[HELD_YOUNG] * p[HELD_EXPANSION] * p[HELD_WARMING] / (1.0 - 2.0 * p[HELD_POISSON]);
}

const struct exact_solution exact_restrained = {
	.name = "restrained",
	.doc = "body held on all sides and warmed: -E alpha dT / (1 - 2 nu) in every direction",
	.fields = EXACT_BIT(EXACT_STRESS_XX) | EXACT_BIT(EXACT_STRESS_YY) | EXACT_BIT(EXACT_STRESS_ZZ),
	EXACT_PARAMETERS(restrained_parameters),
	.value = restrained_value,
};

/* ---- the bar that hits a wall ---- */

enum { IMPACT_LENGTH, IMPACT_MODULUS, IMPACT_DENSITY, IMPACT_VELOCITY };

static const struct exact_parameter impact_parameters[] = {
	[IMPACT_LENGTH] = {"length", "m", 1.0, "of the bar, 0 <= X <= length"},
	[IMPACT_MODULUS] = {"modulus", "Pa", 1e6, "uniaxial stiffness"},
	[IMPACT_DENSITY] = {"density", "kg/m3", 1000.0, "density"},
	[IMPACT_VELOCITY] = {"velocity", "m/s", 0.1, "V, towards the wall at x = 0, which it reaches at t = 0"},
};

/* The wave of -rho c V runs to the free end and comes back as a release; then the bar leaves with V. */
static double impact_value(const double *p, const double X[2], double t, enum exact_field field)
{
	double L = p[IMPACT_LENGTH], c = sqrt(p[IMPACT_MODULUS] / p[IMPACT_DENSITY]), V = p[IMPACT_VELOCITY], x = X[0];
	if (x < 0.0 || x > L)
		return NAN;
	double arrival = x / c, release = (2.0 * L - x) / c;
	bool before = t < arrival, after = t >= release;
	if (field == EXACT_STRESS_XX)
		return before || after ? 0.0 : -p[IMPACT_DENSITY] * c * V;
	if (field == EXACT_VELOCITY_X)
		return before ? -V : after ? V : 0.0;
	return before ? -V * t : -V * arrival + (after ? V * (t - release) : 0.0);
}

const struct exact_solution exact_bar_impact = {
	.name = "bar_impact",
	.doc = "bar that hits a rigid wall: the uniaxial stress wave there and back, and the rebound, at small strain",
	.fields = EXACT_BIT(EXACT_STRESS_XX) | EXACT_BIT(EXACT_VELOCITY_X) | EXACT_BIT(EXACT_DISPLACEMENT_X),
	EXACT_PARAMETERS(impact_parameters),
	.value = impact_value,
};
