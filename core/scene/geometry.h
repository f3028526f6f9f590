/* Plane polygons: what filling bodies and checking scenes need.  Vertices in m, any orientation
 * unless stated; closed implicitly. */
#ifndef TMDEMPM_SCENE_GEOMETRY_H
#define TMDEMPM_SCENE_GEOMETRY_H

#include <stdbool.h>

/* Signed area, m2: positive when counter-clockwise. */
double polygon_area(int n, const double (*v)[2]);

/* Turns the polygon counter-clockwise in place. */
void polygon_orient(int n, double (*v)[2]);

/* Distance of a point from the nearest edge, m. */
double polygon_distance(int n, const double (*v)[2], const double p[2]);

/* Strictly inside, and further than `tolerance` (m) from every edge. */
bool polygon_contains(int n, const double (*v)[2], const double p[2], double tolerance);

/* Do the segments ab and cd cross in their interiors?  Touching and overlapping within `tolerance` (m) do not count. */
bool segments_cross(const double a[2], const double b[2], const double c[2], const double d[2], double tolerance);

/* Finds a pair of edges that touch or cross though they are not neighbours, or neighbours that fold back:
 * true if the polygon is simple, else edges i and j (edge k runs from vertex k to k + 1). */
bool polygon_is_simple(int n, const double (*v)[2], double tolerance, int *i, int *j);

#endif
