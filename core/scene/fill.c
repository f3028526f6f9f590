#include <math.h>
#include <stdlib.h>

#include "base/error.h"
#include "scene/geometry.h"
#include "scene/scene.h"

/* Points nearer to an edge than this share of their spacing lie on it: scene files round their decimals. */
static const double ON_EDGE = 1e-6;

/* More points than this in one body is a slip of the pen, not a scene. */
static const double POINTS_MAX = 1e8;

double scene_body_spacing(const struct scene *scene, const struct scene_body *body)
{
	return scene->grid.cell / sqrt((double)body->points_per_cell);
}

void scene_body_turn(const struct scene_body *body, double direction, double x[2])
{
	if (body->angle == 0.0)
		return;
	double c = cos(body->angle), s = direction * sin(body->angle);
	double dx = x[0] - body->pivot[0], dy = x[1] - body->pivot[1];
	x[0] = body->pivot[0] + c * dx - s * dy, x[1] = body->pivot[1] + s * dx + c * dy;
}

/* A pixel counts whole: an image has no finer edge than that. */
static bool mask_contains(const struct scene_body *body, const double x[2])
{
	const struct scene_mask *mask = &body->mask;
	double X[2] = {x[0], x[1]};
	scene_body_turn(body, -1.0, X);
	double i = floor((X[0] - mask->origin[0]) / mask->pixel), j = floor((X[1] - mask->origin[1]) / mask->pixel);
	return i >= 0.0 && j >= 0.0 && i < mask->nx && j < mask->ny && mask->inside[(int)j * mask->nx + (int)i];
}

static bool outline_contains(const struct scene_body *body, const double x[2], double tolerance)
{
	const double(*v)[2] = (const double(*)[2])body->vertices;
	if (body->mask.inside)
		return mask_contains(body, x);
	if (body->radius > 0.0) {
		double distance = hypot(x[0] - body->centre[0], x[1] - body->centre[1]);
		return distance < body->radius - tolerance && (body->hole == 0.0 || distance > body->hole + tolerance);
	}
	if (tolerance < 0.0 && polygon_distance(body->n_vertices, v, x) <= -tolerance)
		return true;
	return polygon_contains(body->n_vertices, v, x, fmax(tolerance, 0.0));
}

bool scene_body_contains(const struct scene_body *body, const double x[2], double tolerance)
{
	bool inside = outline_contains(body, x, tolerance);
	for (int k = 0; k < body->n_cuts && inside; k++)
		inside = !outline_contains(&body->cuts[k], x, -tolerance);
	return inside;
}

/* The indices i of lattice coordinates origin + (i + 1/2) s that can lie in the body's extent along `axis`. */
static void lattice_range(const struct scene_body *body, int axis, double origin, double s, double *first, double *last)
{
	double low = INFINITY, high = -INFINITY;
	for (int k = 0; k < body->n_vertices; k++) {
		double v[2] = {body->vertices[k][0], body->vertices[k][1]};
		scene_body_turn(body, -1.0, v);
		low = fmin(low, v[axis]);
		high = fmax(high, v[axis]);
	}
	*first = floor((low - origin) / s - 0.5);
	*last = ceil((high - origin) / s - 0.5);
}

void scene_body_lattice(const struct scene *scene, const struct scene_body *body, double origin[2])
{
	for (int a = 0; a < 2; a++)
		origin[a] = isnan(body->lattice_origin[a]) ? scene->grid.origin[a] : body->lattice_origin[a];
}

int scene_body_points(const struct scene *scene, const struct scene_body *body, double (**x)[2], int *n)
{
	double s = scene_body_spacing(scene, body), origin[2], first[2], last[2];
	*x = NULL, *n = 0;
	scene_body_lattice(scene, body, origin);
	for (int a = 0; a < 2; a++)
		lattice_range(body, a, origin[a], s, &first[a], &last[a]);
	double columns = last[0] - first[0] + 1.0, rows = last[1] - first[1] + 1.0;
	if (!(columns * rows <= POINTS_MAX))
		return error_set(STATUS_INPUT, "body '%s' spans %.3g lattice points, expected at most %.0g", body->name,
						 columns * rows, POINTS_MAX);
	double(*points)[2] = NULL;
	int count = 0, capacity = 0;
	for (int j = 0; j < (int)rows; j++)
		for (int i = 0; i < (int)columns; i++) {
			double p[2] = {origin[0] + (first[0] + i + 0.5) * s, origin[1] + (first[1] + j + 0.5) * s};
			scene_body_turn(body, 1.0, p);
			if (!scene_body_contains(body, p, ON_EDGE * s))
				continue;
			if (count == capacity) {
				capacity = capacity ? 2 * capacity : 1024;
				double(*grown)[2] = realloc(points, (size_t)capacity * sizeof *points);
				if (!grown) {
					free(points);
					return error_set(STATUS_RESOURCE, "no memory for the points of body '%s'", body->name);
				}
				points = grown;
			}
			points[count][0] = p[0], points[count][1] = p[1], count++;
		}
	*x = points, *n = count;
	return STATUS_OK;
}

double scene_body_warming(const struct scene_body *body, const double x[2])
{
	const double *g = body->temperature_gradient, *at = body->temperature_at;
	return g[0] * (x[0] - at[0]) + g[1] * (x[1] - at[1]);
}

int scene_body_layer(const struct scene_body *body, double y)
{
	for (int k = 0; k < body->n_layers; k++)
		if (y < body->layers[k].top || k == body->n_layers - 1)
			return k;
	return -1;
}
