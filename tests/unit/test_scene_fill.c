/* Filling bodies with points: counts that the paper gives, edges, holes of the lattice. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

#include <stdio.h>
#include <string.h>
#include <unistd.h>

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

/* ---- cuts, turns, files: scenes as users write them ---- */

static void put(const char *folder, const char *name, const void *text, size_t size)
{
	char path[256];
	snprintf(path, sizeof path, "%s/%s", folder, name);
	FILE *out = fopen(path, "wb");
	assert_non_null(out);
	assert_int_equal(fwrite(text, 1, size, out), size);
	assert_int_equal(fclose(out), 0);
}

static const char *const files[] = {"s.cfg", "a.csv", "a.vtp", "a.pgm", "b.pgm"};

/* Points of a body with this shape, on cells of 0.1 with 4 points; -1 if the scene is refused, with the message. */
static int points_of(const char *folder, const char *shape, double (**x)[2], char message[512])
{
	char path[256], text[2048];
	struct scene *scene;
	snprintf(path, sizeof path, "%s/s.cfg", folder);
	snprintf(text, sizeof text,
			 "grid = { origin = [-2.0, -2.0]; size = [4.0, 4.0]; cell = 0.1; };\n"
			 "time = { end = 1.0; step = 1e-4; };\n"
			 "materials = ( { name = \"m\"; density = 1000.0; law = { type = \"thermoelastic\"; young = 1e6; poisson = "
			 "0.3; }; "
			 "} );\nbodies = ( { name = \"b\"; material = \"m\"; %s } );\n",
			 shape);
	put(folder, "s.cfg", text, strlen(text));
	FILE *errors = fmemopen(message, 512, "w");
	int status = scene_load(&scene, path, 0, NULL, errors), n = -1;
	fclose(errors);
	if (status == 0)
		assert_int_equal(scene_body_points(scene, &scene->bodies[0], x, &n), 0);
	if (status == 0)
		scene_free(scene);
	return n;
}

static int count_of(const char *folder, const char *shape)
{
	double(*x)[2] = NULL;
	char message[512] = "";
	int n = points_of(folder, shape, &x, message);
	if (n < 0)
		fail_msg("%s", message);
	free(x);
	return n;
}

static void refused(const char *folder, const char *shape, const char *expected)
{
	double(*x)[2] = NULL;
	char message[512] = "";
	assert_int_equal(points_of(folder, shape, &x, message), -1);
	if (!strstr(message, expected))
		fail_msg("%s, expected %s", message, expected);
}

static void shapes_of_scenes(void **state)
{
	(void)state;
	char folder[] = "/tmp/test_scene_fill_XXXXXX";
	assert_non_null(mkdtemp(folder));
	/* a unit square has 400 points; a notch of three cells takes 2 * 6 * 5, a hole those inside of it */
	assert_int_equal(count_of(folder, "box = [0.0, 0.0, 1.0, 1.0];"), 400);
	assert_int_equal(count_of(folder, "box = [0.0, 0.0, 1.0, 1.0]; cuts = ( { box = [-0.1, 0.35, 0.5, 0.65]; } );"),
					 340);
	assert_int_equal(count_of(folder, "box = [0.0, 0.0, 1.0, 1.0]; cuts = ( { disc = [0.5, 0.5, 0.08]; }, "
									  "{ polygon = ([0.0, 0.0], [0.1, 0.0], [0.1, 0.1], [0.0, 0.1]); } );"),
					 400 - 4 - 12);
	refused(folder, "box = [0.0, 0.0, 1.0, 1.0]; cuts = ( { } );", "bodies.[0].cuts.[0] has no shape");

	/* turned, the body has the same points, on a turned lattice */
	double(*a)[2], (*b)[2];
	char message[512];
	const double angle = M_PI / 6.0;
	int n =
		points_of(folder, "box = [0.0, 0.0, 1.0, 1.0]; cuts = ( { box = [-0.1, 0.35, 0.5, 0.65]; } );", &a, message);
	int m = points_of(folder,
					  "box = [0.0, 0.0, 1.0, 1.0]; cuts = ( { box = [-0.1, 0.35, 0.5, 0.65]; } ); angle = 30.0; "
					  "pivot = [0.2, -0.1];",
					  &b, message);
	assert_int_equal(n, m);
	for (int k = 0; k < n; k++) {
		double x = a[k][0] - 0.2, y = a[k][1] + 0.1;
		assert_true(fabs(b[k][0] - 0.2 - cos(angle) * x + sin(angle) * y) < 1e-12);
		assert_true(fabs(b[k][1] + 0.1 - sin(angle) * x - cos(angle) * y) < 1e-12);
	}
	free(a), free(b);

	/* outlines in files: the same square, open and closed, as a table and as VTK's */
	const char csv[] = "# m\nx,y\n0,0\r\n1.0, 0\n1 1\n0,1\n0,0\n", torn[] = "0,0\n1,0\n1;1\n";
	const char vtp[] =
		"<VTKFile type=\"PolyData\"><PolyData><Piece><Points><DataArray type=\"Float64\" "
		"NumberOfComponents=\"3\" format=\"ascii\">9 9 0  0 0 0 1 0 0 1 1 0 0 1 0</DataArray></Points><Polys>"
		"<DataArray Name=\"connectivity\" format=\"ascii\">1 2 3 4 0 1 2</DataArray>"
		"<DataArray Name=\"offsets\" format=\"ascii\">4 7</DataArray></Polys></Piece></PolyData></VTKFile>";
	put(folder, "a.csv", csv, strlen(csv));
	put(folder, "a.vtp", vtp, strlen(vtp));
	assert_int_equal(count_of(folder, "outline = \"a.csv\";"), 400);
	assert_int_equal(count_of(folder, "outline = \"a.vtp\";"), 400);
	put(folder, "a.csv", torn, strlen(torn));
	refused(folder, "outline = \"a.csv\";", "a.csv:3: is no row x,y");
	refused(folder, "outline = \"none.csv\";", "cannot be read");
	refused(folder, "outline = \"a.png\";", "expected a file name ending in .csv or .vtp");

	/* masks: rows from the top; a pixel of 0.1 holds 4 points */
	const char plain[] = "P2 # two grains\n3 2\n255\n200 0 50\n200 200 0\n";
	const unsigned char raw[] = {'P', '5', '\n', '3', ' ', '2', '\n', '1', '5', '\n', 15, 0, 3, 15, 15, 0};
	put(folder, "a.pgm", plain, strlen(plain));
	put(folder, "b.pgm", raw, sizeof raw);
	assert_int_equal(count_of(folder, "mask = { file = \"a.pgm\"; pixel = 0.1; };"), 12);
	assert_int_equal(count_of(folder, "mask = { file = \"b.pgm\"; pixel = 0.1; };"), 12);
	assert_int_equal(count_of(folder, "mask = { file = \"b.pgm\"; pixel = 0.2; level = [50, 60]; };"), 16);
	n = points_of(folder, "mask = { file = \"a.pgm\"; pixel = 0.1; origin = [-1.0, 0.5]; level = [50, 50]; };", &a,
				  message);
	assert_int_equal(n, 4);
	assert_true(fabs(a[0][0] + 0.775) < 1e-12 && fabs(a[0][1] - 0.625) < 1e-12);
	free(a);
	refused(folder, "mask = { file = \"a.pgm\"; };", "mask has no pixel");
	refused(folder, "mask = { file = \"a.pgm\"; pixel = 0.1; level = [1, 9]; };", "has no pixel from 1 to 9");
	put(folder, "b.pgm", raw, sizeof raw - 2);
	refused(folder, "mask = { file = \"b.pgm\"; pixel = 0.1; };", "ends early, expected 3 x 2 pixels");
	put(folder, "b.pgm", "\x89PNG", 4);
	refused(folder, "mask = { file = \"b.pgm\"; pixel = 0.1; };", "is no grey image");
	for (size_t k = 0; k < sizeof files / sizeof *files; k++) {
		char path[256];
		snprintf(path, sizeof path, "%s/%s", folder, files[k]);
		unlink(path);
	}
	rmdir(folder);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(silo_has_1088_points),
		cmocka_unit_test(box_has_all_its_points),
		cmocka_unit_test(points_on_edges_do_not_count),
		cmocka_unit_test(concave_polygon),
		cmocka_unit_test(absurd_counts_are_refused),
		cmocka_unit_test(polygons_are_judged),
		cmocka_unit_test(shapes_of_scenes),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
