#include "scene/geometry.h"

#include <math.h>

static double cross(const double o[2], const double a[2], const double b[2])
{
	return (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
}

double polygon_area(int n, const double (*v)[2])
{
	double sum = 0.0;
	for (int k = 1; k + 1 < n; k++)
		sum += cross(v[0], v[k], v[k + 1]);
	return 0.5 * sum;
}

void polygon_orient(int n, double (*v)[2])
{
	if (polygon_area(n, (const double(*)[2])v) >= 0.0)
		return;
	for (int i = 0, j = n - 1; i < j; i++, j--) {
		double x = v[i][0], y = v[i][1];
		v[i][0] = v[j][0], v[i][1] = v[j][1];
		v[j][0] = x, v[j][1] = y;
	}
}

static double segment_distance(const double a[2], const double b[2], const double p[2])
{
	double ex = b[0] - a[0], ey = b[1] - a[1];
	double px = p[0] - a[0], py = p[1] - a[1];
	double length2 = ex * ex + ey * ey;
	double s = length2 > 0.0 ? (px * ex + py * ey) / length2 : 0.0;
	s = fmin(1.0, fmax(0.0, s));
	return hypot(px - s * ex, py - s * ey);
}

double polygon_distance(int n, const double (*v)[2], const double p[2])
{
	double nearest = INFINITY;
	for (int k = 0; k < n; k++)
		nearest = fmin(nearest, segment_distance(v[k], v[(k + 1) % n], p));
	return nearest;
}

bool polygon_contains(int n, const double (*v)[2], const double p[2], double tolerance)
{
	bool inside = false;
	for (int i = 0, j = n - 1; i < n; j = i++)
		if ((v[i][1] > p[1]) != (v[j][1] > p[1])) {
			double x = v[i][0] + (p[1] - v[i][1]) / (v[j][1] - v[i][1]) * (v[j][0] - v[i][0]);
			inside ^= p[0] < x;
		}
	return inside && polygon_distance(n, v, p) > tolerance;
}

/* On which side of the line ab does p lie: -1, 0 (within the tolerance), 1? */
static int side(const double a[2], const double b[2], const double p[2], double tolerance)
{
	double length = hypot(b[0] - a[0], b[1] - a[1]);
	double distance = length > 0.0 ? cross(a, b, p) / length : 0.0;
	return distance > tolerance ? 1 : distance < -tolerance ? -1 : 0;
}

bool segments_cross(const double a[2], const double b[2], const double c[2], const double d[2], double tolerance)
{
	return side(a, b, c, tolerance) * side(a, b, d, tolerance) < 0 &&
		   side(c, d, a, tolerance) * side(c, d, b, tolerance) < 0;
}

static bool segments_touch(const double a[2], const double b[2], const double c[2], const double d[2], double tolerance)
{
	return segments_cross(a, b, c, d, tolerance) || segment_distance(a, b, c) <= tolerance ||
		   segment_distance(a, b, d) <= tolerance || segment_distance(c, d, a) <= tolerance ||
		   segment_distance(c, d, b) <= tolerance;
}

bool polygon_is_simple(int n, const double (*v)[2], double tolerance, int *i, int *j)
{
	for (*i = 0; *i < n; (*i)++) {
		const double *a = v[*i], *b = v[(*i + 1) % n], *c = v[(*i + 2) % n];
		*j = (*i + 1) % n;
		/* neighbours share b: only an edge without length or one that runs back is wrong */
		if (hypot(b[0] - a[0], b[1] - a[1]) <= tolerance || segment_distance(a, b, c) <= tolerance ||
			segment_distance(b, c, a) <= tolerance)
			return false;
		for (*j = *i + 2; *j < n; (*j)++)
			if (!(*i == 0 && *j == n - 1) && segments_touch(a, b, v[*j], v[(*j + 1) % n], tolerance))
				return false;
	}
	return true;
}
