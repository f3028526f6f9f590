/* Manufactured motions: what a body does under the body force that makes it do so. */
#include <math.h>
#include <string.h>

#include "exact/private.h"

/* ---- separate in X and Y ---- */

/* Component c moves by A sin(k X_c) sin(w t + phase): adds it to a motion at rest. */
static void add_sine(struct exact_motion *m, int c, double A, double k, double w, double phase, const double X[2],
					 double t)
{
	double s = sin(k * X[c]), angle = w * t + phase, swing = sin(angle);
	m->u[c] = A * s * swing;
	m->v[c] = A * s * w * cos(angle);
	m->a[c] = -A * s * w * w * swing;
	m->F[3 * c] += A * k * cos(k * X[c]) * swing;
	m->dF[c][3 * c] = -A * k * k * s * swing;
}

static void at_rest(struct exact_motion *m) { *m = (struct exact_motion){.F = {1.0, 0.0, 0.0, 1.0}}; }

enum { WAVE_AMPLITUDE, WAVE_LENGTH, WAVE_SPEED, WAVE_PHASE_X, WAVE_PHASE_Y };

static const struct exact_parameter periodic_parameters[] = {
	[WAVE_AMPLITUDE] = {"amplitude", "m", 0.05, "of the displacement"},
	[WAVE_LENGTH] = {"length", "m", 1.0, "of the body, one period"},
	[WAVE_SPEED] = {"wave_speed", "m/s", 100.0, "c, sqrt(E / density) of the original"},
	[WAVE_PHASE_X] = {"phase_x", "-", 0.0, "radians"},
};

static bool periodic_motion(const double *p, const double X[2], double t, struct exact_motion *motion)
{
	double L = p[WAVE_LENGTH];
	at_rest(motion);
	add_sine(motion, 0, p[WAVE_AMPLITUDE], 2.0 * M_PI / L, M_PI * p[WAVE_SPEED] / L, p[WAVE_PHASE_X], X, t);
	return true;
}

const struct exact_solution exact_periodic = {
	.name = "periodic",
	.doc = "manufactured: u_x = A sin(2 pi X/L) sin(c pi t/L + phase_x); the ends of the period stay where they are",
	EXACT_PARAMETERS(periodic_parameters),
	.motion = periodic_motion,
};

static const struct exact_parameter axis_aligned_parameters[] = {
	[WAVE_AMPLITUDE] = {"amplitude", "m", 0.05, "of the displacement"},
	[WAVE_LENGTH] = {"length", "m", 1.0, "of the square body"},
	[WAVE_SPEED] = {"wave_speed", "m/s", 100.0, "c, sqrt(E / density) of the original"},
	[WAVE_PHASE_X] = {"phase_x", "-", 0.0, "radians"},
	[WAVE_PHASE_Y] = {"phase_y", "-", M_PI, "radians"},
};

static bool axis_aligned_motion(const double *p, const double X[2], double t, struct exact_motion *motion)
{
	double L = p[WAVE_LENGTH], k = M_PI / L;
	if (X[0] < 0.0 || X[0] > L || X[1] < 0.0 || X[1] > L)
		return false;
	at_rest(motion);
	for (int c = 0; c < 2; c++)
		add_sine(motion, c, p[WAVE_AMPLITUDE], k, k * p[WAVE_SPEED], p[WAVE_PHASE_X + c], X, t);
	return true;
}

const struct exact_solution exact_axis_aligned = {
	.name = "axis_aligned",
	.doc = "manufactured: u_i = A sin(pi X_i/L) sin(c pi t/L + phase_i) in a square with sliding sides (Wallstedt and "
		   "Guilkey 2008)",
	EXACT_PARAMETERS(axis_aligned_parameters),
	.motion = axis_aligned_motion,
};

/* ---- the generalised vortex ---- */

enum { RING_INNER, RING_OUTER, RING_AMPLITUDE, RING_PERIOD, RING_X, RING_Y };

static const struct exact_parameter vortex_parameters[] = {
	[RING_INNER] = {"inner", "m", 0.75, "radius of the ring"},
	[RING_OUTER] = {"outer", "m", 1.25, "radius of the ring"},
	[RING_AMPLITUDE] = {"amplitude", "-", 1.0, "largest rotation, radians, half way between the radii"},
	[RING_PERIOD] = {"period", "s", 2.0, "of the swing there and back"},
	[RING_X] = {"centre_x", "m", 0.0, "of the ring"},
	[RING_Y] = {"centre_y", "m", 0.0, "of the ring"},
};

/* Q, dQ/dalpha, d2Q/dalpha2 */
static void rotations(double alpha, double Q[3][4])
{
	double c = cos(alpha), s = sin(alpha);
	const double all[3][4] = {{c, -s, s, c}, {-s, -c, c, -s}, {-c, s, -s, -c}};
	memcpy(Q, all, sizeof all);
}

/* x = Q(alpha) X with alpha = g(t) h(R), F = Q + Q'X (x) grad alpha; h and its slope vanish on both radii, so that
 * they need no traction, and whatever lies beyond may rest. */
static bool vortex_motion(const double *p, const double X[2], double t, struct exact_motion *m)
{
	const double d[2] = {X[0] - p[RING_X], X[1] - p[RING_Y]};
	double R = hypot(d[0], d[1]), half = 0.5 * (p[RING_OUTER] - p[RING_INNER]);
	at_rest(m);
	if (R < p[RING_INNER] || R > p[RING_OUTER])
		return true;
	double s = (R - p[RING_INNER] - half) / half, w = 2.0 * M_PI / p[RING_PERIOD];
	double h = (1.0 - s * s) * (1.0 - s * s), h1 = -4.0 * s * (1.0 - s * s) / half,
		   h2 = (12.0 * s * s - 4.0) / (half * half);
	double g = p[RING_AMPLITUDE] * sin(w * t), g1 = p[RING_AMPLITUDE] * w * cos(w * t), Q[3][4];
	double slope[2], second[2][2], turned[3][2]; /* grad alpha, its gradient, Q d, Q'd, Q''d */
	rotations(g * h, Q);
	for (int i = 0; i < 2; i++) {
		slope[i] = g * h1 * d[i] / R;
		for (int j = 0; j < 2; j++)
			second[i][j] = g * ((h2 - h1 / R) * d[i] * d[j] / (R * R) + (i == j ? h1 / R : 0.0));
		for (int k = 0; k < 3; k++)
			turned[k][i] = Q[k][2 * i] * d[0] + Q[k][2 * i + 1] * d[1];
	}
	for (int i = 0; i < 2; i++) {
		m->u[i] = turned[0][i] - d[i];
		m->v[i] = turned[1][i] * g1 * h;
		m->a[i] = turned[2][i] * g1 * h * g1 * h - turned[1][i] * w * w * g * h;
		for (int J = 0; J < 2; J++) {
			m->F[2 * i + J] = Q[0][2 * i + J] + turned[1][i] * slope[J];
			for (int K = 0; K < 2; K++)
				m->dF[K][2 * i + J] = Q[1][2 * i + J] * slope[K] + Q[1][2 * i + K] * slope[J] +
									  turned[2][i] * slope[K] * slope[J] + turned[1][i] * second[J][K];
		}
	}
	return true;
}

const struct exact_solution exact_vortex = {
	.name = "vortex",
	.doc = "manufactured: a ring whose middle swings around in matter at rest, x = Q(alpha) X, alpha = A sin(2 pi "
		   "t/period) (1 - "
		   "s^2)^2 "
		   "(generalised vortex, Kamojjala, Brannon, Sadeghirad, Guilkey 2015)",
	EXACT_PARAMETERS(vortex_parameters),
	.motion = vortex_motion,
};

/* ---- the expanding ring ---- */

static const struct exact_parameter ring_parameters[] = {
	[RING_INNER] = {"inner", "m", 0.4, "radius of the ring"},
	[RING_OUTER] = {"outer", "m", 0.6, "radius of the ring"},
	[RING_AMPLITUDE] = {"amplitude", "m", 0.02, "largest radial displacement of the outer radius"},
	[RING_PERIOD] = {"period", "s", 0.02, "of the swing"},
	[RING_X] = {"centre_x", "m", 0.0, "of the ring"},
	[RING_Y] = {"centre_y", "m", 0.0, "of the ring"},
};

/* u_R = A sin(2 pi t/period) (c3 R^3 + c2 R^2 + c1 R): its slope vanishes on both radii, which are free of traction if
 * nu = 0.  x = (1 + f) X with f = u_R / R. */
static bool ring_motion(const double *p, const double X[2], double t, struct exact_motion *m)
{
	const double d[2] = {X[0] - p[RING_X], X[1] - p[RING_Y]};
	double R = hypot(d[0], d[1]), in = p[RING_INNER], out = p[RING_OUTER], scale = out * out * (out - 3.0 * in);
	if (R < in || R > out)
		return false;
	double c3 = -2.0 / scale, c2 = 3.0 * (in + out) / scale, c1 = -6.0 * in * out / scale;
	double w = 2.0 * M_PI / p[RING_PERIOD], swing = p[RING_AMPLITUDE] * sin(w * t);
	double f = c3 * R * R + c2 * R + c1, f1 = swing * (2.0 * c3 + c2 / R), f2 = -swing * c2 / (R * R * R);
	for (int i = 0; i < 2; i++) {
		m->u[i] = swing * f * d[i];
		m->v[i] = p[RING_AMPLITUDE] * w * cos(w * t) * f * d[i];
		m->a[i] = -w * w * m->u[i];
		for (int J = 0; J < 2; J++) { /* f1 = f'/R, f2 = f1'/R */
			m->F[2 * i + J] = (i == J ? 1.0 + swing * f : 0.0) + f1 * d[i] * d[J];
			for (int K = 0; K < 2; K++)
				m->dF[K][2 * i + J] = f1 * ((i == J ? d[K] : 0.0) + (i == K ? d[J] : 0.0) + (J == K ? d[i] : 0.0)) +
									  f2 * d[i] * d[J] * d[K];
		}
	}
	return true;
}

const struct exact_solution exact_ring = {
	.name = "expanding_ring",
	.doc = "manufactured: a ring that breathes, u_R a cubic in R without slope on both radii; free of traction if "
		   "poisson = "
		   "0 (Wallstedt and Guilkey 2008)",
	EXACT_PARAMETERS(ring_parameters),
	.motion = ring_motion,
};

/* ---- the bar that swings by itself ---- */

enum { BAR_LENGTH, BAR_MODULUS, BAR_DENSITY, BAR_VELOCITY };

static const struct exact_parameter vibration_parameters[] = {
	[BAR_LENGTH] = {"length", "m", 25.0, "of the bar, held at X = 0, free at the other end"},
	[BAR_MODULUS] = {"modulus", "Pa", 100.0, "uniaxial stiffness"},
	[BAR_DENSITY] = {"density", "kg/m3", 1.0, "density"},
	[BAR_VELOCITY] = {"velocity", "m/s", 0.1, "of the free end at the start"},
};

static double bar_frequency(const double *p)
{
	return 0.5 * M_PI / p[BAR_LENGTH] * sqrt(p[BAR_MODULUS] / p[BAR_DENSITY]);
}

static bool vibration_motion(const double *p, const double X[2], double t, struct exact_motion *motion)
{
	double w = bar_frequency(p);
	if (X[0] < 0.0 || X[0] > p[BAR_LENGTH])
		return false;
	at_rest(motion);
	add_sine(motion, 0, p[BAR_VELOCITY] / w, 0.5 * M_PI / p[BAR_LENGTH], w, 0.0, X, t);
	return true;
}

static double vibration_value(const double *p, const double X[2], double t, enum exact_field field)
{
	struct exact_motion motion;
	(void)field;
	return vibration_motion(p, X, t, &motion) ? p[BAR_MODULUS] * (motion.F[0] - 1.0) : NAN;
}

const struct exact_solution exact_bar_vibration = {
	.name = "bar_vibration",
	.doc = "bar with v0 sin(pi X/2L) at the start: its first mode, at small strain (the cell-crossing test)",
	.fields = EXACT_BIT(EXACT_STRESS_XX),
	EXACT_PARAMETERS(vibration_parameters),
	.value = vibration_value,
	.motion = vibration_motion,
};
