/* The quads that stand for points: true for moderate deformation, readable for any. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "run/frame_build.h"

static double area(double c[4][2])
{
	double sum = 0;
	for (int i = 0; i < 4; i++)
		sum += 0.5 * (c[i][0] * c[(i + 1) % 4][1] - c[(i + 1) % 4][0] * c[i][1]);
	return sum;
}

static void near(double a, double b) { assert_true(fabs(a - b) < 1e-12); }

static void moderate_is_exact(void **unused)
{
	(void)unused;
	const double x[2] = {3, -2}, F[4] = {1.2, 0.3, -0.1, 0.9}; /* stretch ratio 1.6 */
	double c[4][2];
	frame_domain(x, F, 0.5, c);
	near(c[0][0], 3 + 0.25 * (-1.2 - 0.3));
	near(c[0][1], -2 + 0.25 * (0.1 - 0.9));
	near(c[2][0], 3 + 0.25 * (1.2 + 0.3));
	near(area(c), 0.25 * (1.2 * 0.9 + 0.03));
}

static void rotation_is_kept(void **unused)
{
	(void)unused;
	const double x[2] = {0, 0}, a = 2.5, F[4] = {cos(a), -sin(a), sin(a), cos(a)};
	double c[4][2];
	frame_domain(x, F, 2, c);
	near(c[2][0], cos(a) - sin(a));
	near(c[2][1], sin(a) + cos(a));
}

static void slender_is_limited(void **unused)
{
	(void)unused;
	const double x[2] = {0, 0}, F[4] = {20, 0, 0, 1.0 / 20}, shear[4] = {1, 50, 0, 1};
	double c[4][2];
	frame_domain(x, F, 1, c);
	near(area(c), 1);
	near((c[1][0] - c[0][0]) / (c[2][1] - c[1][1]), 2.5);
	frame_domain(x, shear, 1, c);
	near(area(c), 1);
	for (int i = 0; i < 4; i++)
		assert_true(hypot(c[i][0], c[i][1]) < 1.2);
}

static void size_is_limited(void **unused)
{
	(void)unused;
	const double x[2] = {0, 0}, huge[4] = {30, 0, 0, 30}, tiny[4] = {1e-3, 0, 0, 1e-3}, broken[4] = {NAN, 0, 0, 1},
				 flat[4] = {0};
	double c[4][2];
	frame_domain(x, huge, 1, c);
	near(area(c), 1.5);
	frame_domain(x, tiny, 1, c);
	near(area(c), 0.25);
	frame_domain(x, flat, 1, c);
	near(area(c), 0.25);
	frame_domain(x, broken, 1, c); /* nothing to say about the corners, but it must come back */
}

int main(void)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(moderate_is_exact), cmocka_unit_test(rotation_is_kept),
									   cmocka_unit_test(slender_is_limited), cmocka_unit_test(size_is_limited)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
