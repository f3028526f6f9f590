/* Conduction of heat, alone and with the stress it makes. */
#include <math.h>

#include "exact/private.h"

double exact_erfcx(double x)
{
	if (x < 10.0)
		return exp(x * x) * erfc(x);
	double y = 1.0 / (2.0 * x * x);
	return (1.0 - y * (1.0 - 3.0 * y * (1.0 - 5.0 * y * (1.0 - 7.0 * y)))) / (x * sqrt(M_PI));
}

/* Images for short times, the series for long ones: both to round-off where they change over. */
double exact_slab(double x, double fourier)
{
	double sum = 0.0;
	if (fourier <= 0.0)
		return x > 0.0 && x < 1.0 ? 1.0 : 0.0;
	if (fourier < 0.02) {
		double r = 2.0 * sqrt(fourier);
		for (int k = -2; k <= 2; k++)
			sum += (k % 2 ? -1.0 : 1.0) * erf((x + k) / r);
		return sum;
	}
	for (int n = 1; n < 20; n += 2)
		sum += 4.0 / M_PI * exp(-n * n * M_PI * M_PI * fourier) * sin(n * M_PI * x) / n;
	return sum;
}

/* ---- the Danilovskaya bar ---- */

enum {
	BAR_YOUNG,
	BAR_POISSON,
	BAR_DENSITY,
	BAR_CAPACITY,
	BAR_CONDUCTIVITY,
	BAR_EXPANSION,
	BAR_SHOCK,
	BAR_START,
};

static const struct exact_parameter danilovskaya_parameters[] = {
	[BAR_YOUNG] = {"young", "Pa", 1.0, "Young's modulus"},
	[BAR_POISSON] = {"poisson", "-", 0.0, "Poisson's ratio (plane strain, held sideways)"},
	[BAR_DENSITY] = {"density", "kg/m3", 1.0, "density"},
	[BAR_CAPACITY] = {"heat_capacity", "J/(kg K)", 1.0, "specific heat capacity"},
	[BAR_CONDUCTIVITY] = {"conductivity", "W/(m K)", 1.0, "thermal conductivity"},
	[BAR_EXPANSION] = {"expansion", "1/K", 1e-6, "linear thermal expansion"},
	[BAR_SHOCK] = {"shock", "K", 100.0, "sudden rise of the temperature at x = 0"},
	[BAR_START] = {"temperature_start", "T", 0.0, "temperature before it"},
};

/* E = rho = c = k = 1, in units of the shock: temperature, velocity, displacement, stress; t > 0.  With z+- = x/2r +- r
 * and g = exp(-x^2/4t) the front at t = x changes exp(t - x) erfc(z-) for g erfcx(-z-) and adds the jump. */
static double danilovskaya_unit(double x, double t, enum exact_field field)
{
	double r = sqrt(t), g = exp(-x * x / (4.0 * t)), plus = g * exact_erfcx(x / (2.0 * r) + r), z = x / (2.0 * r) - r;
	bool ahead = t < x;
	double minus = ahead ? exp(t - x) * erfc(z) : g * exact_erfcx(-z);
	switch (field) {
	case EXACT_TEMPERATURE:
		return erfc(x / (2.0 * r));
	case EXACT_VELOCITY_X:
		return ahead ? 0.5 * (minus - plus) : -0.5 * (minus + plus);
	case EXACT_DISPLACEMENT_X:
		return (ahead ? 0.5 * (minus - plus) : 1.0 - 0.5 * (minus + plus)) - 2.0 * sqrt(t / M_PI) * g +
			   x * erfc(x / (2.0 * r));
	default:
		return ahead ? -0.5 * (minus + plus) : 0.5 * (minus - plus);
	}
}

static double danilovskaya_value(const double *p, const double X[2], double t, enum exact_field field)
{
	double nu = p[BAR_POISSON], modulus = p[BAR_YOUNG] * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu));
	double c = sqrt(modulus / p[BAR_DENSITY]), a = p[BAR_CONDUCTIVITY] / (p[BAR_DENSITY] * p[BAR_CAPACITY]);
	double stress = p[BAR_YOUNG] / (1.0 - 2.0 * nu) * p[BAR_EXPANSION] * p[BAR_SHOCK];
	double unit[EXACT_FIELDS] = {[EXACT_TEMPERATURE] = p[BAR_SHOCK],
								 [EXACT_DISPLACEMENT_X] = stress / modulus * a / c,
								 [EXACT_VELOCITY_X] = stress / modulus * c,
								 [EXACT_STRESS_XX] = stress};
	double start = field == EXACT_TEMPERATURE ? p[BAR_START] : 0.0;
	if (X[0] < 0.0)
		return NAN;
	return t > 0.0 ? start + unit[field] * danilovskaya_unit(X[0] * c / a, t * c * c / a, field) : start;
}

const struct exact_solution exact_danilovskaya = {
	.name = "danilovskaya",
	.doc = "half space x > 0 whose free surface is suddenly heated: waves and diffusion (TM-DEMPM 5.1.1)",
	.fields = EXACT_BIT(EXACT_TEMPERATURE) | EXACT_BIT(EXACT_DISPLACEMENT_X) | EXACT_BIT(EXACT_VELOCITY_X) |
			  EXACT_BIT(EXACT_STRESS_XX),
	EXACT_PARAMETERS(danilovskaya_parameters),
	.value = danilovskaya_value,
};

/* ---- the rod between two temperatures ---- */

enum { ROD_LENGTH, ROD_DIFFUSIVITY, ROD_START, ROD_STEP, ROD_MODULUS, ROD_EXPANSION };

static const struct exact_parameter rod_parameters[] = {
	[ROD_LENGTH] = {"length", "m", 1.0, "of the rod, 0 <= x <= length"},
	[ROD_DIFFUSIVITY] = {"diffusivity", "m2/s", 0.1, "k / (rho c)"},
	[ROD_START] = {"temperature_start", "T", 0.0, "at the start, and at x = 0 for ever"},
	[ROD_STEP] = {"temperature_step", "K", 50.0, "sudden rise at x = length"},
	[ROD_MODULUS] = {"modulus", "Pa", 1.33e7, "uniaxial stiffness along the rod"},
	[ROD_EXPANSION] = {"expansion", "1/K", 1e-4, "thermal strain at that stiffness"},
};

/* Quasi-static: the stress is uniform and holds the rod's length. */
static double rod_value(const double *p, const double X[2], double t, enum exact_field field)
{
	double x = X[0] / p[ROD_LENGTH], F = p[ROD_DIFFUSIVITY] * t / (p[ROD_LENGTH] * p[ROD_LENGTH]);
	double T = x, u = 0.5 * x * (x - 1.0), sigma = 0.5;
	if (x < 0.0 || x > 1.0)
		return NAN;
	if (t <= 0.0)
		return field == EXACT_TEMPERATURE ? p[ROD_START] + (x == 1.0 ? p[ROD_STEP] : 0.0) : 0.0;
	int terms = (int)fmin(2000.0, 4.0 + 2.0 / sqrt(F)); /* until exp(-n^2 pi^2 F) is round-off */
	for (int n = 1; n <= terms; n++) {
		double sign = n % 2 ? -1.0 : 1.0, e = exp(-n * n * M_PI * M_PI * F), k = n * M_PI;
		T += 2.0 * sign / k * e * sin(k * x);
		u -= 2.0 * sign / (k * k) * e * (cos(k * x) - x * sign + x - 1.0);
		sigma -= n % 2 ? 4.0 / (k * k) * e : 0.0;
	}
	if (field == EXACT_TEMPERATURE)
		return p[ROD_START] + p[ROD_STEP] * T;
	double strain = p[ROD_EXPANSION] * p[ROD_STEP];
	return field == EXACT_STRESS_XX ? -p[ROD_MODULUS] * strain * sigma : strain * p[ROD_LENGTH] * u;
}

const struct exact_solution exact_rod = {
	.name = "rod",
	.doc = "rod held at both ends, one of them suddenly heated: conduction and quasi-static stress (TM-DEMPM 5.2.1)",
	.fields = EXACT_BIT(EXACT_TEMPERATURE) | EXACT_BIT(EXACT_DISPLACEMENT_X) | EXACT_BIT(EXACT_STRESS_XX),
	EXACT_PARAMETERS(rod_parameters),
	.value = rod_value,
};

/* ---- squares, plates, half spaces ---- */

enum { SLAB_LENGTH, SLAB_DIFFUSIVITY, SLAB_START, SLAB_STEP };

static const struct exact_parameter slab_parameters[] = {
	[SLAB_LENGTH] = {"length", "m", 1.0, "of the body, from 0 to length"},
	[SLAB_DIFFUSIVITY] = {"diffusivity", "m2/s", 0.1, "k / (rho c)"},
	[SLAB_START] = {"temperature_start", "T", 0.0, "at the start"},
	[SLAB_STEP] = {"temperature_step", "K", 50.0, "sudden rise at the surface"},
};

static double slab_value(const double *p, const double X[2], double t, int directions)
{
	double L = p[SLAB_LENGTH], F = p[SLAB_DIFFUSIVITY] * t / (L * L), left = 1.0;
	for (int c = 0; c < directions; c++) {
		if (X[c] < 0.0 || X[c] > L)
			return NAN;
		left *= exact_slab(X[c] / L, F);
	}
	return p[SLAB_START] + p[SLAB_STEP] * (1.0 - left);
}

static double square_value(const double *p, const double X[2], double t, enum exact_field field)
{
	(void)field;
	return slab_value(p, X, t, 2);
}

static double plate_value(const double *p, const double X[2], double t, enum exact_field field)
{
	(void)field;
	return slab_value(p, X, t, 1);
}

const struct exact_solution exact_square = {
	.name = "square",
	.doc = "square suddenly heated on its four sides: conduction (TM-DEMPM 5.2.2)",
	.fields = EXACT_BIT(EXACT_TEMPERATURE),
	EXACT_PARAMETERS(slab_parameters),
	.value = square_value,
};

const struct exact_solution exact_plate = {
	.name = "plate",
	.doc = "plate 0 <= x <= length suddenly heated on both faces: conduction",
	.fields = EXACT_BIT(EXACT_TEMPERATURE),
	EXACT_PARAMETERS(slab_parameters),
	.value = plate_value,
};

enum { HALF_DIFFUSIVITY, HALF_START, HALF_STEP };

static const struct exact_parameter half_space_parameters[] = {
	[HALF_DIFFUSIVITY] = {"diffusivity", "m2/s", 0.1, "k / (rho c)"},
	[HALF_START] = {"temperature_start", "T", 0.0, "at the start"},
	[HALF_STEP] = {"temperature_step", "K", 50.0, "sudden rise at x = 0"},
};

static double half_space_value(const double *p, const double X[2], double t, enum exact_field field)
{
	(void)field;
	if (X[0] < 0.0)
		return NAN;
	double r = 2.0 * sqrt(p[HALF_DIFFUSIVITY] * t);
	return p[HALF_START] + p[HALF_STEP] * (r > 0.0 ? erfc(X[0] / r) : X[0] == 0.0);
}

const struct exact_solution exact_half_space = {
	.name = "half_space",
	.doc = "half space x > 0 suddenly heated on its surface: conduction",
	.fields = EXACT_BIT(EXACT_TEMPERATURE),
	EXACT_PARAMETERS(half_space_parameters),
	.value = half_space_value,
};
