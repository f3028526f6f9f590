#include <math.h>

#include "base/mat2.h"
#include "run/frame_build.h"

static const double DRAWN_STRETCH_RATIO = 2.5, DRAWN_AREA_MIN = 0.25, DRAWN_AREA_MAX = 1.5;

/* Stretches (principal, descending) limited for the drawing. */
static void frame_limit_stretches(double stretch[2])
{
	double area = stretch[0] * stretch[1], ratio = stretch[1] > 0 ? stretch[0] / stretch[1] : INFINITY;
	if (!(area >= DRAWN_AREA_MIN))
		area = DRAWN_AREA_MIN;
	if (area > DRAWN_AREA_MAX)
		area = DRAWN_AREA_MAX;
	if (!(ratio <= DRAWN_STRETCH_RATIO))
		ratio = DRAWN_STRETCH_RATIO;
	stretch[0] = sqrt(area * ratio);
	stretch[1] = sqrt(area / ratio);
}

/* F = V R with V symmetric; the limit acts on the eigenvalues of V. */
static void frame_drawn_gradient(const double F[4], double drawn[4])
{
	double a = F[0] + F[3], b = F[2] - F[1], norm = sqrt(a * a + b * b);
	double R[4] = {1, 0, 0, 1}, V[4], turned_back[4];
	if (norm > 0)
		R[0] = R[3] = a / norm, R[1] = -b / norm, R[2] = b / norm;
	turned_back[0] = R[0], turned_back[1] = R[2], turned_back[2] = R[1], turned_back[3] = R[3];
	mat2_multiply(F, turned_back, V);
	double mean = 0.5 * (V[0] + V[3]), half = 0.5 * (V[0] - V[3]), shear = 0.5 * (V[1] + V[2]);
	double radius = sqrt(half * half + shear * shear);
	double stretch[2] = {mean + radius, mean - radius};
	double c = radius > 0 ? half / radius : 1, s = radius > 0 ? shear / radius : 0; /* cos, sin of twice the angle */
	frame_limit_stretches(stretch);
	mean = 0.5 * (stretch[0] + stretch[1]), radius = 0.5 * (stretch[0] - stretch[1]);
	double limited[4] = {mean + radius * c, radius * s, radius * s, mean - radius * c};
	mat2_multiply(limited, R, drawn);
}

void frame_domain(const double x[2], const double F[4], double side, double corners[4][2])
{
	static const double signs[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
	double drawn[4];
	frame_drawn_gradient(F, drawn);
	for (int c = 0; c < 4; c++) {
		double X = 0.5 * side * signs[c][0], Y = 0.5 * side * signs[c][1];
		corners[c][0] = x[0] + drawn[0] * X + drawn[1] * Y;
		corners[c][1] = x[1] + drawn[2] * X + drawn[3] * Y;
	}
}
