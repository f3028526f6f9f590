/* Filling bodies with points: counts that the paper gives, edges, holes of the lattice. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

#include "scene/geometry.h"
#include "scene/scene.h"

static struct scene scene_of(double x, double y, double cell)
{
	struct scene scene = {.grid = {.origin = {x, y}, .cell = cell, .thickness = 1.0}};
	return scene;
}

static int count(const struct scene *scene, int n, double (*v)[2], int per_cell)
{
	struct scene_body body = {
		.n_vertices = n, .vertices = v, .points_per_cell = per_cell, .lattice_origin = {NAN, NAN}};
	double(*x)[2];
	int points;
	assert_int_equal(scene_body_points(scene, &body, &x, &points), 0);
	for (int k = 0; k < points; k++)
		assert_true(polygon_contains(n, (const double(*)[2])v, x[k], 0.0));
	for (int k = 1; k < points; k++) /* the order of birth: rows from the bottom, from the left */
		assert_true(x[k][1] > x[k - 1][1] + 1e-9 || x[k][0] > x[k - 1][0]);
	free(x);
	return points;
}

/* TM-DEMPM section 5.3.2: 1088 points. 368 in the hopper (points on the 45 degree walls do not count) + 18 rows of 40.
 */
static void silo_has_1088_points(void **state)
{
	(void)state;
	double fill[][2] = {{0.4, 1.0}, {0.6, 1.0}, {1.0, 1.4}, {1.0, 1.85}, {0.0, 1.85}, {0.0, 1.4}};
	double hopper[][2] = {{0.4, 1.0}, {0.6, 1.0}, {1.0, 1.4}, {0.0, 1.4}};
	for (int shift = 0; shift < 40; shift++) { /* whatever the rounding of the grid's origin does */
		struct scene scene = scene_of(-0.05 * shift, -0.05 * (shift % 7), 0.05);
		assert_int_equal(count(&scene, 6, fill, 4), 1088);
		assert_int_equal(count(&scene, 4, hopper, 4), 368);
	}
}

static void box_has_all_its_points(void **state)
{
	(void)state;
	struct scene scene = scene_of(-0.3, -0.3, 0.1);
	double box[][2] = {{0.0, 0.0}, {1.0, 0.0}, {1.0, 2.0}, {0.0, 2.0}};
	assert_int_equal(count(&scene, 4, box, 1), 200);
	assert_int_equal(count(&scene, 4, box, 4), 800);
	assert_int_equal(count(&scene, 4, box, 9), 1800);
	assert_int_equal(count(&scene, 4, box, 16), 3200);
}

static void points_on_edges_do_not_count(void **state)
{
	(void)state;
	struct scene scene = scene_of(0.0, 0.0, 1.0);
	double box[][2] = {{0.5, 0.5}, {2.5, 0.5}, {2.5, 2.5}, {0.5, 2.5}};
	assert_int_equal(count(&scene, 4, box, 1), 1);
	double small[][2] = {{0.6, 0.6}, {0.9, 0.6}, {0.9, 0.9}};
	assert_int_equal(count(&scene, 3, small, 1), 0);
}

static void concave_polygon(void **state)
{
	(void)state;
	struct scene scene = scene_of(0.0, 0.0, 1.0);
	double u[][2] = {{0, 0}, {3, 0}, {3, 3}, {2, 3}, {2, 1}, {1, 1}, {1, 3}, {0, 3}};
	assert_int_equal(count(&scene, 8, u, 4), 4 * 7);
}

static void absurd_counts_are_refused(void **state)
{
	(void)state;
	struct scene scene = scene_of(0.0, 0.0, 1e-6);
	double box[][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
	struct scene_body body = {.n_vertices = 4, .vertices = box, .points_per_cell = 1, .lattice_origin = {NAN, NAN}};
	double(*x)[2];
	int n;
	assert_int_equal(scene_body_points(&scene, &body, &x, &n), 2);
	assert_null(x);
}

static void polygons_are_judged(void **state)
{
	(void)state;
	int i, j;
	double bow[][2] = {{0, 0}, {1, 1}, {1, 0}, {0, 1}};
	assert_false(polygon_is_simple(4, (const double(*)[2])bow, 1e-9, &i, &j));
	assert_int_equal(i, 0);
	assert_int_equal(j, 2);
	double spike[][2] = {{0, 0}, {1, 0}, {2, 0}, {1, 0}, {1, 1}};
	assert_false(polygon_is_simple(5, (const double(*)[2])spike, 1e-9, &i, &j));
	double twice[][2] = {{0, 0}, {1, 0}, {1, 0}, {1, 1}};
	assert_false(polygon_is_simple(4, (const double(*)[2])twice, 1e-9, &i, &j));
	double square[][2] = {{0, 0}, {0, 1}, {1, 1}, {1, 0}};
	assert_true(polygon_is_simple(4, (const double(*)[2])square, 1e-9, &i, &j));
	assert_true(polygon_area(4, (const double(*)[2])square) == -1.0);
	polygon_orient(4, square);
	assert_true(polygon_area(4, (const double(*)[2])square) == 1.0);
	/* a vertex in the middle of a straight edge is fine */
	double straight[][2] = {{0, 0}, {0.5, 0}, {1, 0}, {1, 1}};
	assert_true(polygon_is_simple(4, (const double(*)[2])straight, 1e-9, &i, &j));
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(silo_has_1088_points),         cmocka_unit_test(box_has_all_its_points),
		cmocka_unit_test(points_on_edges_do_not_count), cmocka_unit_test(concave_polygon),
		cmocka_unit_test(absurd_counts_are_refused),    cmocka_unit_test(polygons_are_judged),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
