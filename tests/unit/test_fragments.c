/* Pieces of broken bodies: number, size, shape; cracks: where they begin, how they run; and their lines. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

#include "../common/near.h"
#include "run/fragments.h"

enum { SIDE = 40, N = SIDE * SIDE };

/* A square of SIDE by SIDE points, 0.5 apart, shaken out of order, moved. */
struct block {
	double X[N][2], x[N][2], damage[N], spacing[N], mass[N];
	int body[N];
};

static struct fragment_points block_points(struct block *b)
{
	for (int k = 0; k < N; k++) {
		int at = (int)((k * 997LL) % N);
		b->X[k][0] = 0.5 * (at % SIDE + 0.5), b->X[k][1] = 0.5 * (at / SIDE + 0.5);
		b->x[k][0] = b->X[k][0] + 3.0, b->x[k][1] = b->X[k][1] - 1.0;
		b->damage[k] = 0.3, b->spacing[k] = 0.5, b->mass[k] = 2.0, b->body[k] = 0;
	}
	return (struct fragment_points){.n = N,
									.X = (const double(*)[2])b->X,
									.x = (const double(*)[2])b->x,
									.damage = b->damage,
									.spacing = b->spacing,
									.mass = b->mass,
									.body = b->body};
}

static void test_pieces(void **state)
{
	(void)state;
	static struct block b;
	struct fragment_points p = block_points(&b);
	struct fragments f;
	assert_int_equal(fragments_find(&f, &p), 0);
	assert_int_equal(f.count, 1);
	assert_near(f.list[0].area, 400.0, 1e-9);
	assert_near(f.list[0].centre[0], 13.0, 1e-9);
	assert_near(f.list[0].roundness, 3.0 / M_PI, 1e-9); /* a square: moments of a disc sqrt(4/3) as wide */
	fragments_free(&f);

	/* a broken row and a diagonal of one point: what only corners hold together is apart */
	for (int k = 0; k < N; k++) {
		double x = b.X[k][0], y = b.X[k][1];
		if (fabs(y - 10.25) < 0.1 || (y > 10.5 && fabs(x - 20.0 + (y - 10.5)) < 0.3))
			b.damage[k] = 1.0;
	}
	assert_int_equal(fragments_find(&f, &p), 0);
	assert_int_equal(f.count, 3);
	assert_near(f.list[0].area, 200.0, 1e-9);
	double sum = f.broken;
	for (int k = 0; k < f.count; k++)
		sum += f.list[k].area;
	assert_near(sum, 400.0, 1e-9);
	for (int k = 0; k < N; k++)
		assert_true((f.label[k] < 0) == (b.damage[k] >= 0.9));
	struct fragment_summary s = fragments_summary(&f);
	assert_near(s.diameter_mean, (f.list[0].diameter + f.list[1].diameter + f.list[2].diameter) / 3.0, 1e-12);
	double by_area = 0.0, area = 0.0, square = 0.0;
	for (int k = 0; k < 3; k++)
		by_area += f.list[k].area * f.list[k].diameter, area += f.list[k].area;
	assert_near(s.area_mean, by_area / area, 1e-12);
	for (int k = 0; k < 3; k++)
		square += f.list[k].area * pow(f.list[k].diameter - s.area_mean, 2.0) / area;
	assert_near(s.area_deviation, sqrt(square), 1e-12);
	assert_near(s.largest, 200.0, 1e-9);
	fragments_free(&f);
}

/* Another body, or points that are far apart now, are other pieces. */
static void test_parted(void **state)
{
	(void)state;
	static struct block b;
	struct fragment_points p = block_points(&b);
	struct fragments f;
	for (int k = 0; k < N; k++) {
		b.body[k] = b.X[k][0] > 15.0;
		b.x[k][1] += b.X[k][1] > 10.0 ? 2.0 : 0.0;
	}
	assert_int_equal(fragments_find(&f, &p), 0);
	assert_int_equal(f.count, 4);
	assert_near(f.list[0].area, 150.0, 1e-9);
	assert_near(f.list[3].area, 50.0, 1e-9);
	fragments_free(&f);
}

static void test_disc(void **state)
{
	(void)state;
	static struct block b;
	struct fragment_points p = block_points(&b);
	struct fragments f;
	for (int k = 0; k < N; k++)
		b.damage[k] = hypot(b.X[k][0] - 10.0, b.X[k][1] - 10.0) < 9.0 ? 0.0 : 1.0;
	assert_int_equal(fragments_find(&f, &p), 0);
	assert_int_equal(f.count, 1);
	assert_near(f.list[0].diameter, 18.0, 0.1);
	assert_near(f.list[0].roundness, 1.0, 0.01);
	fragments_free(&f);
}

/* A crack of 60 degrees from the middle of the left side; another one that is not its own. */
static void test_crack(void **state)
{
	(void)state;
	static struct block b;
	struct fragment_points p = block_points(&b);
	struct crack crack;
	const double at[2] = {0.0, 2.0}, c = cos(M_PI / 3.0), s = sin(M_PI / 3.0);
	assert_int_equal(fragments_crack(&crack, &p, at, 1.0), 0);
	assert_near(crack.length, 0.0, 0.0);
	assert_true(isnan(crack.angle));
	for (int k = 0; k < N; k++) {
		double x = b.X[k][0] - at[0], y = b.X[k][1] - at[1], along = c * x + s * y, across = c * y - s * x;
		b.damage[k] = (fabs(across) < 0.5 && along < 12.0) || b.X[k][0] > 19.0 ? 1.0 : 0.0;
	}
	assert_int_equal(fragments_crack(&crack, &p, at, 1.0), 0);
	assert_near(crack.length, 12.0, 0.5);
	assert_near(crack.angle, M_PI / 3.0, 0.05);
	assert_near(crack.tip[0], 3.0 + 12.0 * c, 0.7);
	assert_near(crack.tip[1], 1.0 + 12.0 * s, 0.7);

	double(*nodes)[2], length = 0.0;
	int n_nodes, (*segments)[2], n;
	assert_int_equal(fragments_lines(&p, &nodes, &n_nodes, &segments, &n), 0);
	assert_int_equal(n, n_nodes - 2); /* two trees */
	for (int k = 0; k < n; k++)
		length += hypot(nodes[segments[k][0]][0] - nodes[segments[k][1]][0],
						nodes[segments[k][0]][1] - nodes[segments[k][1]][1]);
	assert_near(length, 12.0 + 19.0, 5.0);
	free(nodes), free(segments);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_pieces),
		cmocka_unit_test(test_parted),
		cmocka_unit_test(test_disc),
		cmocka_unit_test(test_crack),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
