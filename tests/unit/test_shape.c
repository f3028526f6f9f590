/* Shape functions: partition of unity, linear reproduction of the linear ones, gradients that are the weights'. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

#include "../common/near.h"
#include "mpm/shape.h"

static const struct shape_grid grid = {{-0.3, 0.1}, {1.0 / 0.25, 1.0 / 0.25}, 12};
static const double side_half[4] = {0.5, 0.25, 0.5 / 3, 0.125};

/* Pseudo-random number in [0, 1). */
static double uniform(unsigned *seed)
{
	*seed = *seed * 1664525u + 1013904223u;
	return (*seed >> 8) / 16777216.0;
}

static void fill_one(const struct shape *shape, const double x[2], int size, struct shape_lists *lists)
{
	int point = 0;
	shape->fill(&grid, 1, &point, (const double(*)[2])x, &size, side_half, lists);
}

static double node_x(int node, int c)
{
	return grid.origin[c] + (c ? node / grid.nx : node % grid.nx) / grid.inverse_h[c];
}

static void test_sums(void **state)
{
	(void)state;
	unsigned seed = 1;
	struct shape_lists lists;
	for (int s = 0; shapes[s]; s++)
		for (int trial = 0; trial < 2000; trial++) {
			const double x[2] = {grid.origin[0] + 0.25 * (2.0 + 7.0 * uniform(&seed)),
								 grid.origin[1] + 0.25 * (2.0 + 7.0 * uniform(&seed))};
			fill_one(shapes[s], x, trial % 4, &lists);
			double w = 0.0, gx = 0.0, gy = 0.0, wx[2] = {0, 0}, gxx = 0.0, gyy = 0.0, gxy = 0.0;
			for (int a = 0; a < shapes[s]->max_nodes; a++) {
				w += lists.weight[a], gx += lists.grad_x[a], gy += lists.grad_y[a];
				for (int c = 0; c < 2; c++)
					wx[c] += lists.weight[a] * node_x(lists.node[a], c);
				gxx += lists.grad_x[a] * node_x(lists.node[a], 0), gyy += lists.grad_y[a] * node_x(lists.node[a], 1);
				gxy += lists.grad_x[a] * node_x(lists.node[a], 1);
				assert_true(lists.weight[a] >= -1e-16);
			}
			assert_near(w, 1.0, 4e-16 * 4);
			assert_near(gx, 0.0, 1e-14);
			assert_near(gy, 0.0, 1e-14);
			/* both reproduce linear fields, uGIMP too: its average over a symmetric domain */
			assert_near(wx[0], x[0], 1e-14);
			assert_near(wx[1], x[1], 1e-14);
			assert_near(gxx, 1.0, 1e-13);
			assert_near(gyy, 1.0, 1e-13);
			assert_near(gxy, 0.0, 1e-13);
		}
}

/* Gradients against differences of the weights, away from the kinks. */
static void test_gradients(void **state)
{
	(void)state;
	unsigned seed = 7;
	struct shape_lists here, there;
	const double eps = 1e-7;
	for (int s = 0; shapes[s]; s++)
		for (int trial = 0; trial < 2000; trial++) {
			const double x[2] = {grid.origin[0] + 0.25 * (2.0 + 7.0 * uniform(&seed)),
								 grid.origin[1] + 0.25 * (2.0 + 7.0 * uniform(&seed))};
			const double y[2] = {x[0] + eps, x[1]};
			fill_one(shapes[s], x, trial % 4, &here);
			fill_one(shapes[s], y, trial % 4, &there);
			if (here.node[0] != there.node[0])
				continue;
			for (int a = 0; a < shapes[s]->max_nodes; a++)
				assert_near((there.weight[a] - here.weight[a]) / eps, here.grad_x[a], 2e-5);
		}
}

/* uGIMP is the mean of the hat function over the domain: against a fine sum. */
static void test_ugimp_is_an_average(void **state)
{
	(void)state;
	unsigned seed = 3;
	struct shape_lists lists;
	const struct shape *shape = shape_find("ugimp");
	assert_non_null(shape);
	for (int trial = 0; trial < 200; trial++) {
		const double x[2] = {grid.origin[0] + 0.25 * (2.0 + 7.0 * uniform(&seed)), grid.origin[1] + 0.25 * 4.0};
		int size = trial % 4;
		fill_one(shape, x, size, &lists);
		double y[9];
		for (int a = 0; a < 9; a++)
			y[a] = 0.0;
		const int steps = 4000;
		for (int k = 0; k < steps; k++) {
			double at = x[0] + 0.25 * side_half[size] * (2.0 * (k + 0.5) / steps - 1.0);
			for (int a = 0; a < 9; a++) {
				double d = fabs(at - node_x(lists.node[a], 0)) / 0.25;
				y[a] += d < 1.0 ? (1.0 - d) / steps : 0.0;
			}
		}
		for (int a = 0; a < 3; a++)
			assert_near(lists.weight[a] + lists.weight[a + 3] + lists.weight[a + 6], y[a], 1e-6);
	}
}

static void test_names(void **state)
{
	(void)state;
	assert_non_null(shape_find("linear"));
	assert_null(shape_find("quadratic-ish"));
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_sums),
		cmocka_unit_test(test_gradients),
		cmocka_unit_test(test_ugimp_is_an_average),
		cmocka_unit_test(test_names),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
