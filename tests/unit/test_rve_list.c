/* When the list of neighbours of an RVE must be made anew. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#define RVE_KERNEL_SUFFIX _of_this_test
#include "rve/kernel.h"

static const double r_max = 0.5e-3, skin = 0.1e-3;

/* Is the list valid in a square cell with radii `scale` times their reference (1 when it was made), the cell `stretch`
 * times as wide, two discs having moved by `way` each? */
static int valid(double scale, double stretch, double way)
{
	static struct rve_block block;
	const struct rve_constants constants = {.r_max = r_max, .skin = skin};
	const struct rve_place place = {.constants = &constants, .block = &block};
	memset(&block, 0, sizeof block);
	block.head.H_ref[0] = block.head.H_ref[3] = 0.02;
	block.head.H[0] = 0.02 * stretch, block.head.H[3] = 0.02 / stretch;
	block.head.scale_ref = 1.0;
	block.scale = scale;
	block.lanes[LANE_DISPLACEMENT][3] = block.lanes[LANE_DISPLACEMENT][70] = way * way;
	displacements_fold(&place);
	return neighbours_valid(&place);
}

static void test_way(void **state)
{
	(void)state;
	assert_true(valid(1.0, 1.0, 0.499 * skin));
	assert_false(valid(1.0, 1.0, 0.501 * skin));
}

static void test_strain(void **state)
{
	(void)state;
	const double most = 1.0 + skin / (2.0 * r_max);
	assert_true(valid(1.0, 0.999 * most, 0.0));
	assert_false(valid(1.0, 1.001 * most, 0.0));
	assert_false(valid(1.0, 1.0 / (1.001 * most), 0.0));
}

static void test_heat(void **state)
{
	(void)state;
	const double most = 1.0 + skin / (2.0 * r_max);
	assert_true(valid(0.999 * most, 1.0, 0.0));
	assert_false(valid(1.001 * most, 1.0, 0.0));
}

/* Discs that shrink leave room between the large ones; between small ones hardly any. */
static void test_cold(void **state)
{
	(void)state;
	assert_true(valid(0.9, 1.0, 0.499 * skin));
	assert_false(valid(0.9, 1.0, 0.501 * skin));
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_way),
		cmocka_unit_test(test_strain),
		cmocka_unit_test(test_heat),
		cmocka_unit_test(test_cold),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
