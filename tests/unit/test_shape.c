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

/* Edges of the undeformed domains, m; the last two lie askew, at 30 and 75 degrees. */
static const double edges[4][4] = {
	{0.25, 0.0, 0.0, 0.25},
	{0.125, 0.0, 0.0, 0.125},
	{0.25 / 3 * 0.8660254037844387, 0.25 / 3 * 0.5, -0.25 / 3 * 0.5, 0.25 / 3 * 0.8660254037844387},
	{0.0161761906, 0.0603703626, -0.0603703626, 0.0161761906}};
static const double undeformed[4] = {1.0, 0.0, 0.0, 1.0};

static void fill_deformed(const struct shape *shape, const double x[2], const double F[4], int size,
						  struct shape_lists *lists)
{
	int point = 0;
	const struct shape_points points = {(const double(*)[2])x, (const double(*)[4])F, &size, side_half, edges};
	shape->fill(&grid, &points, 1, &point, lists);
}

static void fill_one(const struct shape *shape, const double x[2], int size, struct shape_lists *lists)
{
	fill_deformed(shape, x, undeformed, size, lists);
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
			/* from half to twice its size, sheared and turned, also beyond what a domain may reach */
			const double F[4] = {0.5 + 1.5 * uniform(&seed), uniform(&seed) - 0.5, uniform(&seed) - 0.5,
								 0.5 + 1.5 * uniform(&seed)};
			fill_deformed(shapes[s], x, F, trial % 4, &lists);
			double w = 0.0, gx = 0.0, gy = 0.0, wx[2] = {0, 0}, gxx = 0.0, gyy = 0.0, gxy = 0.0;
			for (int a = 0; a < lists.nodes; a++) {
				w += lists.weight[a][0], gx += lists.grad_x[a][0], gy += lists.grad_y[a][0];
				for (int c = 0; c < 2; c++)
					wx[c] += lists.weight[a][0] * node_x(lists.node[a][0], c);
				gxx += lists.grad_x[a][0] * node_x(lists.node[a][0], 0), gyy += lists.grad_y[a][0] * node_x(lists.node[a][0], 1);
				gxy += lists.grad_x[a][0] * node_x(lists.node[a][0], 1);
				assert_true(lists.weight[a][0] >= -1e-16);
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
		for (int trial = 0; trial < 2000 && shapes[s]->tensor; trial++) {
			const double x[2] = {grid.origin[0] + 0.25 * (2.0 + 7.0 * uniform(&seed)),
								 grid.origin[1] + 0.25 * (2.0 + 7.0 * uniform(&seed))};
			const double y[2] = {x[0] + eps, x[1]};
			fill_one(shapes[s], x, trial % 4, &here);
			fill_one(shapes[s], y, trial % 4, &there);
			if (here.node[0][0] != there.node[0][0])
				continue;
			for (int a = 0; a < here.nodes; a++)
				assert_near((there.weight[a][0] - here.weight[a][0]) / eps, here.grad_x[a][0], 2e-5);
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
				double d = fabs(at - node_x(lists.node[a][0], 0)) / 0.25;
				y[a] += d < 1.0 ? (1.0 - d) / steps : 0.0;
			}
		}
		for (int a = 0; a < 3; a++)
			assert_near(lists.weight[a][0] + lists.weight[a + 3][0] + lists.weight[a + 6][0], y[a], 1e-6);
	}
}

/* The hat function of a node at a place. */
static double hat(int node, double x, double y)
{
	double a = 1.0 - fabs(x - node_x(node, 0)) / 0.25, b = 1.0 - fabs(y - node_x(node, 1)) / 0.25;
	return a > 0.0 && b > 0.0 ? a * b : 0.0;
}

/* CPDI against its definition: with edges r1, r2 and the corners' values bilinear between them, the gradient at the
 * centre solves grad . r1 = (S2 + S3 - S1 - S4)/2, grad . r2 = (S3 + S4 - S1 - S2)/2. */
static void test_cpdi_is_its_corners(void **state)
{
	(void)state;
	unsigned seed = 11;
	struct shape_lists lists;
	const struct shape *shape = shape_find("cpdi");
	int squares = 0;
	assert_non_null(shape);
	for (int trial = 0; trial < 4000; trial++) {
		const double x[2] = {grid.origin[0] + 0.25 * (2.0 + 7.0 * uniform(&seed)),
							 grid.origin[1] + 0.25 * (2.0 + 7.0 * uniform(&seed))};
		const double F[4] = {0.7 + 0.5 * uniform(&seed), uniform(&seed) - 0.5, uniform(&seed) - 0.5,
							 0.7 + 0.5 * uniform(&seed)};
		const double *e = edges[1 + trial % 3];
		const double r1[2] = {F[0] * e[0] + F[1] * e[1], F[2] * e[0] + F[3] * e[1]};
		const double r2[2] = {F[0] * e[2] + F[1] * e[3], F[2] * e[2] + F[3] * e[3]};
		fill_deformed(shape, x, F, 1 + trial % 3, &lists);
		squares += lists.nodes == 9;
		double all = 0.0;
		for (int a = 0; a < lists.nodes; a++) {
			double S[4], det = r1[0] * r2[1] - r1[1] * r2[0];
			static const double signs[4][2] = {{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}};
			for (int k = 0; k < 4; k++)
				S[k] = hat(lists.node[a][0], x[0] + signs[k][0] * r1[0] + signs[k][1] * r2[0],
						   x[1] + signs[k][0] * r1[1] + signs[k][1] * r2[1]);
			double along = 0.5 * (S[1] + S[2] - S[0] - S[3]), across = 0.5 * (S[2] + S[3] - S[0] - S[1]);
			assert_near(lists.weight[a][0], 0.25 * (S[0] + S[1] + S[2] + S[3]), 1e-14);
			assert_near(lists.grad_x[a][0], (along * r2[1] - across * r1[1]) / det, 1e-11);
			assert_near(lists.grad_y[a][0], (across * r1[0] - along * r2[0]) / det, 1e-11);
			all += lists.weight[a][0];
		}
		assert_near(all, 1.0, 1e-14); /* no corner has been missed */
	}
	assert_in_range(squares, 1000, 4000);
}

/* Limits of the step rest on this: sum (h dw/dx)^2 / w of one point, of domains from half to twice their size. */
static void test_lone(void **state)
{
	(void)state;
	unsigned seed = 5;
	struct shape_lists lists;
	for (int s = 0; shapes[s]; s++)
		for (int trial = 0; trial < 100000 && isfinite(shapes[s]->lone(0.25)); trial++) {
			const double x[2] = {grid.origin[0] + 0.25 * (2.0 + 7.0 * uniform(&seed)),
								 grid.origin[1] + 0.25 * (2.0 + 7.0 * uniform(&seed))};
			double a = 0.5 + 1.5 * uniform(&seed), b = 0.5 + 1.5 * uniform(&seed), t = 6.3 * uniform(&seed),
				   sum[2] = {0.0, 0.0};
			double u = 6.3 * uniform(&seed), c = cos(t), d = sin(t), e = cos(u), f = sin(u);
			const double F[4] = {a * c * e - b * d * f, a * c * f + b * d * e, -a * d * e - b * c * f,
								 b * c * e - a * d * f};
			fill_deformed(shapes[s], x, F, trial % 4, &lists);
			for (int k = 0; k < lists.nodes; k++)
				if (lists.weight[k][0] > 0.0) {
					sum[0] += pow(0.25 * lists.grad_x[k][0], 2.0) / lists.weight[k][0];
					sum[1] += pow(0.25 * lists.grad_y[k][0], 2.0) / lists.weight[k][0];
				}
			assert_true(sum[0] <= shapes[s]->lone(side_half[trial % 4]) * (1.0 + 1e-12));
			assert_true(sum[1] <= shapes[s]->lone(side_half[trial % 4]) * (1.0 + 1e-12));
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
		cmocka_unit_test(test_cpdi_is_its_corners),
		cmocka_unit_test(test_lone),
		cmocka_unit_test(test_names),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
