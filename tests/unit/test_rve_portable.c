/* timeout: 120 */
/* The packed kernel as processors without any instruction set of vector.h compute it: the same bits.  In single
 * precision with RVE_FLOAT: test_rve_portable_single.c. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include "../common/rve_case.h"

#define RVE_PORTABLE
#ifdef RVE_FLOAT
#define RVE_KERNEL_SUFFIX 32_portable
static const int path = RVE_SIMD_SINGLE;
#else
#define RVE_KERNEL_SUFFIX 64_portable
static const int path = RVE_SIMD;
#endif

rve_packed_kernel DIALECT_JOIN(rve_packed, RVE_KERNEL_SUFFIX);
#include "rve/packed.h"

static void cases_start(struct rve_case c[2], struct rve_params params, double pressure)
{
	params.path = path;
	for (int k = 0; k < 2; k++)
		case_start_loose(&c[k], &params, pressure);
	c[1].model->packed = DIALECT_JOIN(rve_packed, RVE_KERNEL_SUFFIX);
	assert_int_equal(packed_scratch(&c[1].model->layout), c[1].model->layout.scratch);
}

static void cases_advance(struct rve_case c[2], const double L[4], double dT, int calls)
{
	for (int k = 0; k < 2; k++)
		case_advance(&c[k], L, dT, 1e-3, calls);
	assert_memory_equal(c[0].state, c[1].state, rve_state_bytes(c[0].model));
}

static void cases_end(struct rve_case c[2])
{
	for (int k = 0; k < 2; k++)
		case_end(&c[k]);
}

/* Shear with new lists, with and without heat. */
static void test_flow(void **arg)
{
	(void)arg;
	static const double L[4] = {-0.1, 2.0, 0.5, 0.1}, rest[4] = {0};
	struct rve_case c[2];
	struct rve_params params;
	rve_params_default(&params);
	cases_start(c, params, 100e3);
	cases_advance(c, L, 0.0, 150);
	cases_advance(c, L, 0.5, 20);
	assert_true(case_info(&c[1]).rebuilds > 20);
	cases_advance(c, rest, 0.0, 5);
	cases_end(c);
}

/* Bonds that hold, tear and melt. */
static void test_bonds(void **arg)
{
	(void)arg;
	static const double L[4] = {0.2, 0.0, 0.0, 0.05}, rest[4] = {0};
	struct rve_case c[2];
	struct rve_params params;
	rve_params_default(&params);
	params.bond_strength = 0.01;
	params.bond_melting = 8.0;
	params.bond_reference = 0.0;
	cases_start(c, params, 100e3);
	for (int k = 0; k < 2; k++)
		rve_install_bonds(c[k].model, c[k].state);
	cases_advance(c, L, 0.0, 30);
	const struct rve_info torn = case_info(&c[1]);
	assert_true(torn.bonds_intact > 0 && torn.bonds_intact < torn.bonds_installed);
	cases_advance(c, rest, 0.9, 10);
	assert_int_equal(case_info(&c[1]).bonds_intact, 0);
	cases_end(c);
}

/* Pulled apart until it flies, and pressed together again. */
static void test_gas(void **arg)
{
	(void)arg;
	static const double out[4] = {2.0, 0.0, 0.0, 2.0}, in[4] = {-2.0, 0.0, 0.0, -2.0};
	struct rve_case c[2];
	struct rve_params params;
	rve_params_default(&params);
	cases_start(c, params, 10e3);
	cases_advance(c, out, 0.0, 40);
	assert_true(case_info(&c[1]).flags & RVE_GAS);
	cases_advance(c, in, 0.0, 40);
	assert_false(case_info(&c[1]).flags & RVE_GAS);
	cases_end(c);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_flow),
		cmocka_unit_test(test_bonds),
		cmocka_unit_test(test_gas),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
