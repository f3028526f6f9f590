/* Conduction with freezing or thawing, and with convection at a surface. */
#include <math.h>

#include "exact/private.h"

/* ---- the half space that freezes or thaws ---- */

enum {
	PHASE_DENSITY,
	PHASE_LATENT,
	PHASE_CAPACITY,
	PHASE_CONDUCTIVITY,
	PHASE_CAPACITY_FROZEN,
	PHASE_CONDUCTIVITY_FROZEN,
	PHASE_MELTING,
	PHASE_START,
	PHASE_SURFACE,
};

static const struct exact_parameter neumann_parameters[] = {
	[PHASE_DENSITY] = {"density", "kg/m3", 1.0, "density"},
	[PHASE_LATENT] = {"latent_heat", "J/kg", 80.0, "latent heat"},
	[PHASE_CAPACITY] = {"heat_capacity", "J/(kg K)", 4.0, "specific heat capacity when thawed"},
	[PHASE_CONDUCTIVITY] = {"conductivity", "W/(m K)", 0.6, "thermal conductivity when thawed"},
	[PHASE_CAPACITY_FROZEN] = {"heat_capacity_frozen", "J/(kg K)", 2.0, "specific heat capacity when frozen"},
	[PHASE_CONDUCTIVITY_FROZEN] = {"conductivity_frozen", "W/(m K)", 2.2, "thermal conductivity when frozen"},
	[PHASE_MELTING] = {"temperature_melting", "T", 0.0, "at which it freezes and thaws"},
	[PHASE_START] = {"temperature_start", "T", 5.0, "at the start"},
	[PHASE_SURFACE] = {"temperature_surface", "T", -10.0, "at x = 0, on the other side of melting than the start"},
};

/* What conducts on either side of the front: [0] at the surface, [1] beyond. */
struct sides {
	double k[2], a[2]; /* W/(m K), m2/s */
	double step[2];    /* K, from melting to the surface, to the start: absolute values */
	double latent;     /* J/m3, over what a kelvin takes at the surface's side: K */
};

/* Heat that comes to the front less what it takes, as lambda grows from more to less (Carslaw & Jaeger, Conduction of
 * Heat in Solids, 2nd ed., 11.2). */
static double front_balance(const struct sides *s, double lambda)
{
	double ratio = sqrt(s->a[0] / s->a[1]), beyond = lambda * ratio;
	double near = s->step[0] * exp(-lambda * lambda) / erf(lambda);
	double far = s->step[1] * s->k[1] / s->k[0] * ratio / exact_erfcx(beyond);
	return near - far - lambda * s->latent * sqrt(M_PI);
}

/* The front lies at 2 lambda sqrt(a t). */
static double front_lambda(const struct sides *s)
{
	double low = 0.0, high = 1.0;
	while (front_balance(s, high) > 0.0 && high < 20.0)
		high *= 2.0;
	for (int k = 0; k < 60; k++) {
		double middle = 0.5 * (low + high);
		*(front_balance(s, middle) > 0.0 ? &low : &high) = middle;
	}
	return 0.5 * (low + high);
}

static double neumann_value(const double *p, const double X[2], double t, enum exact_field field)
{
	(void)field;
	double surface = p[PHASE_SURFACE] - p[PHASE_MELTING], start = p[PHASE_START] - p[PHASE_MELTING];
	if (X[0] < 0.0 || !(surface * start <= 0.0) || surface == 0.0)
		return NAN;
	if (t <= 0.0)
		return X[0] > 0.0 ? p[PHASE_START] : p[PHASE_SURFACE];
	double k[2] = {p[PHASE_CONDUCTIVITY_FROZEN], p[PHASE_CONDUCTIVITY]},
		   c[2] = {p[PHASE_CAPACITY_FROZEN], p[PHASE_CAPACITY]};
	int near = surface > 0.0;
	struct sides s = {.k = {k[near], k[1 - near]}, .step = {fabs(surface), fabs(start)}};
	for (int side = 0; side < 2; side++)
		s.a[side] = s.k[side] / (p[PHASE_DENSITY] * c[side ? 1 - near : near]);
	s.latent = p[PHASE_LATENT] / c[near];
	double lambda = front_lambda(&s), z = X[0] / (2.0 * sqrt(s.a[0] * t));
	if (z < lambda)
		return p[PHASE_SURFACE] - surface * erf(z) / erf(lambda);
	double ratio = sqrt(s.a[0] / s.a[1]);
	return p[PHASE_START] - start * erfc(z * ratio) / erfc(lambda * ratio);
}

const struct exact_solution exact_neumann = {
	.name = "neumann",
	.doc = "half space x > 0 that freezes or thaws from its surface (Neumann's two-phase Stefan problem)",
	.fields = EXACT_BIT(EXACT_TEMPERATURE),
	EXACT_PARAMETERS(neumann_parameters),
	.value = neumann_value,
};

/* ---- the plate in moving air ---- */

enum { COOLING_LENGTH, COOLING_DIFFUSIVITY, COOLING_BIOT, COOLING_START, COOLING_STEP };

static const struct exact_parameter cooling_parameters[] = {
	[COOLING_LENGTH] = {"length", "m", 1.0, "from the insulated face x = 0 to the face in the air"},
	[COOLING_DIFFUSIVITY] = {"diffusivity", "m2/s", 0.1, "k / (rho c)"},
	[COOLING_BIOT] = {"biot", "-", 1.0, "Biot number: coefficient of heat transfer length / k"},
	[COOLING_START] = {"temperature_start", "T", 0.0, "at the start"},
	[COOLING_STEP] = {"temperature_step", "K", 50.0, "of the air above the start"},
};

/* The root of z tan z = Bi between n pi and (n + 1/2) pi. */
static double cooling_root(double biot, int n)
{
	double low = n * M_PI, high = (n + 0.5) * M_PI;
	for (int k = 0; k < 60; k++) {
		double z = 0.5 * (low + high);
		*(z * tan(z) < biot ? &low : &high) = z;
	}
	return 0.5 * (low + high);
}

/* Carslaw & Jaeger 3.11: theta = sum 4 sin z / (2 z + sin 2z) exp(-z^2 F) cos(z x / L). */
static double cooling_value(const double *p, const double X[2], double t, enum exact_field field)
{
	(void)field;
	double x = X[0] / p[COOLING_LENGTH], F = p[COOLING_DIFFUSIVITY] * t / (p[COOLING_LENGTH] * p[COOLING_LENGTH]);
	double left = F > 0.0 ? 0.0 : 1.0;
	if (x < 0.0 || x > 1.0 || !(p[COOLING_BIOT] > 0.0))
		return NAN;
	int terms = F > 0.0 ? (int)fmin(2000.0, 4.0 + 2.0 / sqrt(F)) : 0; /* until exp(-z^2 F) is round-off */
	for (int n = 0; n < terms; n++) {
		double z = cooling_root(p[COOLING_BIOT], n);
		left += 4.0 * sin(z) / (2.0 * z + sin(2.0 * z)) * exp(-z * z * F) * cos(z * x);
	}
	return p[COOLING_START] + p[COOLING_STEP] * (1.0 - left);
}

const struct exact_solution exact_cooling = {
	.name = "cooling",
	.doc = "plate 0 <= x <= length, insulated at 0, in air of another temperature at length: conduction and convection",
	.fields = EXACT_BIT(EXACT_TEMPERATURE),
	EXACT_PARAMETERS(cooling_parameters),
	.value = cooling_value,
};
