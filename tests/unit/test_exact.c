/* The exact solutions solve their equations: the differential equations by central differences, boundary and initial
 * values, and the printed tables of the sources. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "../common/near.h"
#include "base/error.h"
#include "exact/exact.h"

/* A solution with its parameters at their defaults, or set. */
struct case_of {
	const struct exact_solution *s;
	double p[EXACT_PARAMETERS_MAX];
};

static struct case_of make(const char *name, const char *const *sets)
{
	struct case_of c = {.s = exact_find(name)};
	if (!c.s)
		fail_msg("no solution %s", name);
	exact_defaults(c.s, c.p);
	for (int k = 0; sets && sets[k]; k++)
		assert_int_equal(exact_set(c.s, c.p, sets[k]), STATUS_OK);
	return c;
}

static double at(const struct case_of *c, enum exact_field f, double x, double y, double t)
{
	const double X[2] = {x, y};
	return exact_value(c->s, c->p, X, t, f);
}

/* Central differences of fourth order. */
static double slope(const struct case_of *c, enum exact_field f, const double z[3], int along, double d)
{
	double sum = 0.0;
	const double w[4] = {1.0 / 12, -2.0 / 3, 2.0 / 3, -1.0 / 12}, step[4] = {-2, -1, 1, 2};
	for (int k = 0; k < 4; k++) {
		double q[3] = {z[0], z[1], z[2]};
		q[along] += step[k] * d;
		sum += w[k] * at(c, f, q[0], q[1], q[2]);
	}
	return sum / d;
}

static double curvature(const struct case_of *c, enum exact_field f, const double z[3], int along, double d)
{
	double sum = 0.0;
	const double w[5] = {-1.0 / 12, 4.0 / 3, -5.0 / 2, 4.0 / 3, -1.0 / 12};
	for (int k = 0; k < 5; k++) {
		double q[3] = {z[0], z[1], z[2]};
		q[along] += (k - 2) * d;
		sum += w[k] * at(c, f, q[0], q[1], q[2]);
	}
	return sum / (d * d);
}

/* T_t = a (T_xx + T_yy) */
static void conducts(const struct case_of *c, double a, int dimensions, const double z[3])
{
	double lap = 0.0;
	for (int k = 0; k < dimensions; k++)
		lap += curvature(c, EXACT_TEMPERATURE, z, k, 1e-3);
	double rate = slope(c, EXACT_TEMPERATURE, z, 2, 1e-3);
	assert_near(a * lap, rate, 1e-5 * (1.0 + fabs(rate)));
}

static void test_conduction(void **state)
{
	(void)state;
	const char *const sets[] = {"diffusivity=0.3", "temperature_start=10", "temperature_step=40", NULL};
	const struct {
		const char *name;
		int dimensions;
	} all[] = {{"rod", 1}, {"square", 2}, {"plate", 1}, {"half_space", 1}};
	const double z[3][3] = {{0.3, 0.4, 0.03}, {0.7, 0.15, 0.1}, {0.5, 0.8, 0.4}};
	for (size_t k = 0; k < sizeof all / sizeof *all; k++) {
		struct case_of c = make(all[k].name, sets);
		for (int i = 0; i < 3; i++)
			conducts(&c, 0.3, all[k].dimensions, z[i]);
		/* the start, the heated surface, and the end */
		assert_near(at(&c, EXACT_TEMPERATURE, 0.5, 0.5, 0.0), 10.0, 0.0);
		assert_near(at(&c, EXACT_TEMPERATURE, 0.5, 0.5, 1e-4), 10.0, 1e-12);
		assert_near(at(&c, EXACT_TEMPERATURE, k == 0 ? 1.0 : 0.0, 0.5, 0.1), 50.0, 1e-12);
		assert_near(at(&c, EXACT_TEMPERATURE, 0.5, 0.5, 1e5), k == 0 ? 30.0 : 50.0, 0.1);
		assert_true(isnan(at(&c, EXACT_TEMPERATURE, -0.1, 0.5, 0.1)));
		assert_true(isnan(at(&c, EXACT_STRESS_XY, 0.5, 0.5, 0.1)));
		assert_true(isnan(at(&c, EXACT_TEMPERATURE, 0.5, 0.5, -0.1)));
	}
	/* the two forms of the series meet where one gives way to the other: F = 0.02 */
	struct case_of c = make("plate", (const char *const[]){"diffusivity=1", NULL});
	assert_near(at(&c, EXACT_TEMPERATURE, 0.2, 0.0, 0.02 * (1 - 1e-13)),
				at(&c, EXACT_TEMPERATURE, 0.2, 0.0, 0.02 * (1 + 1e-13)), 1e-10);
}

/* Held ends, and sigma = K (u_x - beta (T - T0)), uniform along the rod. */
static void test_rod(void **state)
{
	(void)state;
	struct case_of c = make("rod", NULL);
	for (int k = 1; k < 6; k++) {
		double t = 0.05 * k * k, z[3] = {0.17 * k, 0.0, t};
		double sigma = at(&c, EXACT_STRESS_XX, z[0], 0.0, t);
		double strain = slope(&c, EXACT_DISPLACEMENT_X, z, 0, 1e-3) - 1e-4 * at(&c, EXACT_TEMPERATURE, z[0], 0.0, t);
		assert_near(1.33e7 * strain, sigma, 1e-4 * fabs(sigma));
		assert_near(at(&c, EXACT_DISPLACEMENT_X, 0.0, 0.0, t), 0.0, 1e-15);
		assert_near(at(&c, EXACT_DISPLACEMENT_X, 1.0, 0.0, t), 0.0, 1e-15);
	}
	assert_near(at(&c, EXACT_STRESS_XX, 0.5, 0.0, 1e3), -0.5 * 1.33e7 * 1e-4 * 50.0, 1e-6);
}

/* Motions: velocity, acceleration, deformation gradient and its gradient are the derivatives of the displacement. */
static void check_motion(const struct exact_solution *s, const double *p, const double X[2], double t)
{
	const double step[4] = {-2, -1, 1, 2}, weight[4] = {1.0 / 12, -2.0 / 3, 2.0 / 3, -1.0 / 12};
	struct exact_motion m, near;
	double scale = 2e-3, d[3] = {scale, scale, 2e-3 * t}, sum[3][8] = {{0.0}};
	assert_true(s->motion(p, X, t, &m));
	for (int along = 0; along < 3; along++)
		for (int k = 0; k < 4; k++) {
			double Y[2] = {X[0], X[1]}, time = t;
			*(along < 2 ? &Y[along] : &time) += step[k] * d[along];
			assert_true(s->motion(p, Y, time, &near));
			const double of[8] = {near.u[0], near.u[1], near.v[0], near.v[1],
								  near.F[0], near.F[1], near.F[2], near.F[3]};
			for (int i = 0; i < 8; i++)
				sum[along][i] += weight[k] * of[i] / d[along];
		}
	for (int i = 0; i < 2; i++) {
		double fast = fabs(m.v[0]) + fabs(m.v[1]), hard = fabs(m.a[0]) + fabs(m.a[1]);
		assert_near(sum[2][i], m.v[i], 1e-6 * fast);
		assert_near(sum[2][2 + i], m.a[i], 1e-6 * hard);
		for (int J = 0; J < 2; J++)
			assert_near((i == J) + sum[J][i], m.F[2 * i + J], 1e-6);
	}
	for (int K = 0; K < 2; K++)
		for (int i = 0; i < 4; i++)
			assert_near(sum[K][4 + i], m.dF[K][i], 1e-5 * (1.0 + fabs(m.dF[K][i])));
}

static void test_motions(void **state)
{
	(void)state;
	const struct {
		const char *name;
		double t;
	} all[] = {{"periodic", 3.3e-3},
			   {"axis_aligned", 3.3e-3},
			   {"vortex", 0.3},
			   {"expanding_ring", 4e-3},
			   {"bar_vibration", 1.3}};
	for (size_t k = 0; k < sizeof all / sizeof *all; k++) {
		struct case_of c = make(all[k].name, NULL);
		bool around = exact_parameter(c.s, "inner") >= 0;
		for (int i = 0; i < 8; i++) {
			double R = around ? c.p[0] + (c.p[1] - c.p[0]) * (0.1 + 0.1 * i) : 0.0;
			const double X[2] = {around ? R * cos(i + 0.3) : 0.05 + 0.11 * i,
								 around ? R * sin(i + 0.3) : 0.9 - 0.1 * i};
			check_motion(c.s, c.p, X, all[k].t);
		}
		const double outside[2] = {100.0, 0.0};
		struct exact_motion m;
		assert_int_equal(c.s->motion(c.p, outside, 0.1, &m),
						 !strcmp(all[k].name, "periodic") || !strcmp(all[k].name, "vortex"));
	}
	/* no deformation on the radii of the vortex, no radial one on those of the ring */
	struct case_of c = make("vortex", NULL);
	struct exact_motion m;
	assert_true(c.s->motion(c.p, (const double[2]){0.0, 1.25}, 0.5, &m));
	for (int i = 0; i < 4; i++)
		assert_near(m.F[i], i % 3 == 0, 1e-13);
	assert_true(c.s->motion(c.p, (const double[2]){1.0, 0.0}, 0.5, &m));
	assert_near(m.u[1], sin(1.0), 1e-13); /* one radian in the middle */
	c = make("expanding_ring", NULL);
	assert_true(c.s->motion(c.p, (const double[2]){0.6, 0.0}, 0.005, &m));
	assert_near(m.F[0], 1.0, 1e-13);
	assert_near(m.u[0], 0.02, 1e-15);
	assert_true(c.s->motion(c.p, (const double[2]){0.4, 0.0}, 0.005, &m));
	assert_near(m.F[0], 1.0, 1e-13);
}

/* sigma = M u_x, rho v_t = sigma_x, v = u_t: of the bars, away from the fronts; the column is in equilibrium. */
static void test_bars(void **state)
{
	(void)state;
	struct case_of bar = make("bar_vibration", NULL), impact = make("bar_impact", NULL), column = make("column", NULL);
	const double z[3] = {7.0, 0.0, 3.0};
	assert_near(100.0 * slope(&bar, EXACT_DISPLACEMENT_X, z, 0, 0.1), at(&bar, EXACT_STRESS_XX, z[0], 0.0, z[2]), 1e-8);
	assert_near(slope(&bar, EXACT_STRESS_XX, z, 0, 0.02), slope(&bar, EXACT_VELOCITY_X, z, 2, 0.02), 1e-8);
	assert_near(at(&bar, EXACT_VELOCITY_X, 25.0, 0.0, 0.0), 0.1, 1e-15);
	const double wave = sqrt(1e6 / 1000.0);
	for (int k = 0; k < 3; k++) {
		const double y[3] = {0.4, 0.0, (0.2 + k) / wave};
		assert_near(1e6 * slope(&impact, EXACT_DISPLACEMENT_X, y, 0, 1e-3), at(&impact, EXACT_STRESS_XX, y[0], 0, y[2]),
					1e-6);
		assert_near(slope(&impact, EXACT_DISPLACEMENT_X, y, 2, 1e-4), at(&impact, EXACT_VELOCITY_X, y[0], 0, y[2]),
					1e-9);
		assert_near(at(&impact, EXACT_STRESS_XX, y[0], 0, y[2]), k == 1 ? -1000.0 * wave * 0.1 : 0.0, 1e-9);
		assert_near(at(&impact, EXACT_VELOCITY_X, y[0], 0, y[2]), 0.1 * (k - 1), 0.0);
	}
	assert_near(at(&impact, EXACT_DISPLACEMENT_X, 1.0, 0.0, 2.5 / wave), 0.1 * 0.5 / wave, 1e-15);
	const double h[3] = {0.0, 20.0, 0.0};
	assert_near(slope(&column, EXACT_STRESS_YY, h, 1, 0.5), 80.0 * 9.81, 1e-8);
	assert_near(1e6 * slope(&column, EXACT_DISPLACEMENT_Y, h, 1, 0.5), at(&column, EXACT_STRESS_YY, 0.0, 20.0, 0.0),
				1e-6);
	assert_near(at(&column, EXACT_STRESS_YY, 0.0, 50.0, 0.0), 0.0, 0.0);
}

/* Where the temperature passes zero. */
static double front(const struct case_of *c, double t)
{
	double low = 0.0, high = 3.0;
	for (int k = 0; k < 60; k++) {
		double x = 0.5 * (low + high);
		*((at(c, EXACT_TEMPERATURE, x, 0.0, t) > 0.0) == (at(c, EXACT_TEMPERATURE, 0.0, 0.0, t) > 0.0) ? &low : &high) =
			x;
	}
	return 0.5 * (low + high);
}

/* Both sides conduct, and the heat that comes to the front is the latent heat of what it sweeps. */
static void test_neumann(void **state)
{
	(void)state;
	const char *const thaws[] = {"temperature_start=-3", "temperature_surface=20", "density=2", "latent_heat=40", NULL};
	const double k[2] = {2.2, 0.6}, c[2] = {2.0, 4.0}; /* frozen, thawed: the defaults */
	for (int near = 0; near < 2; near++) {
		struct case_of n = make("neumann", near ? thaws : NULL);
		double density = near ? 2.0 : 1.0, latent = near ? 40.0 : 80.0, t = 0.3, d = 1e-3, x = front(&n, t);
		double before[3] = {x - 0.1, 0.0, t}, behind[3] = {x + 0.1, 0.0, t};
		conducts(&n, k[near] / (density * c[near]), 1, before);
		conducts(&n, k[1 - near] / (density * c[1 - near]), 1, behind);
		before[0] = x - 2.0 * d, behind[0] = x + 2.0 * d;
		double comes = -k[near] * (slope(&n, EXACT_TEMPERATURE, before, 0, d) +
								   2.0 * d * curvature(&n, EXACT_TEMPERATURE, before, 0, d)),
			   goes = -k[1 - near] * (slope(&n, EXACT_TEMPERATURE, behind, 0, d) -
									  2.0 * d * curvature(&n, EXACT_TEMPERATURE, behind, 0, d));
		double takes = (near ? 1.0 : -1.0) * density * latent * (front(&n, t + d) - front(&n, t - d)) / (2.0 * d);
		assert_near(comes - goes, takes, 1e-3 * fabs(takes));
		assert_near(at(&n, EXACT_TEMPERATURE, 0.0, 0.0, t), near ? 20.0 : -10.0, 1e-12);
		assert_near(at(&n, EXACT_TEMPERATURE, 50.0, 0.0, t), near ? -3.0 : 5.0, 1e-12);
		assert_near(at(&n, EXACT_TEMPERATURE, 1.0, 0.0, 0.0), near ? -3.0 : 5.0, 0.0);
	}
	struct case_of both_cold = make("neumann", (const char *const[]){"temperature_start=-3", NULL});
	assert_true(isnan(at(&both_cold, EXACT_TEMPERATURE, 0.5, 0.0, 0.1)));
}

/* Insulated at 0; at the other face the heat that is conducted is what the air brings. */
static void test_cooling(void **state)
{
	(void)state;
	const char *const sets[] = {"diffusivity=0.3", "biot=2.5", "temperature_start=10", "temperature_step=40", NULL};
	struct case_of c = make("cooling", sets);
	for (int k = 0; k < 3; k++) {
		const double t = 0.03 + 0.3 * k, inside[3] = {0.6, 0.0, t}, face[3] = {1.0 - 2e-3, 0.0, t};
		conducts(&c, 0.3, 1, inside);
		double gradient =
			slope(&c, EXACT_TEMPERATURE, face, 0, 1e-3) + 2e-3 * curvature(&c, EXACT_TEMPERATURE, face, 0, 1e-3);
		assert_near(gradient, 2.5 * (50.0 - at(&c, EXACT_TEMPERATURE, 1.0, 0.0, t)), 2e-3 * gradient);
		assert_near(at(&c, EXACT_TEMPERATURE, 1e-4, 0.0, t), at(&c, EXACT_TEMPERATURE, 0.0, 0.0, t), 1e-6);
	}
	assert_near(at(&c, EXACT_TEMPERATURE, 0.5, 0.0, 0.0), 10.0, 0.0);
	assert_near(at(&c, EXACT_TEMPERATURE, 0.2, 0.0, 1e-4), 10.0, 1e-9);
	assert_near(at(&c, EXACT_TEMPERATURE, 0.5, 0.0, 1e3), 50.0, 1e-9);
}

/* The table of the design, and the equations in units of another material. */
static void test_danilovskaya(void **state)
{
	(void)state;
	const double table[4][4] = {{0.5, .317311, -.405224, .034675},
								{0.9, .456057, -.778878, .177455},
								{1.5, .563703, .077180, .061831},
								{3.0, .683091, .035836, -.383844}};
	struct case_of c = make("danilovskaya", (const char *const[]){"expansion=1", "shock=1", NULL});
	for (int k = 0; k < 4; k++) {
		assert_near(at(&c, EXACT_TEMPERATURE, 1.0, 0.0, table[k][0]), table[k][1], 1e-6);
		assert_near(at(&c, EXACT_STRESS_XX, 1.0, 0.0, table[k][0]), table[k][2], 1e-6);
		assert_near(at(&c, EXACT_DISPLACEMENT_X, 1.0, 0.0, table[k][0]), table[k][3], 1e-6);
	}
	c = make("danilovskaya", (const char *const[]){"young=3", "poisson=0.2", "density=0.5", "heat_capacity=4",
												   "conductivity=1.5", "expansion=2e-3", "shock=7", NULL});
	const double modulus = 3.0 * 0.8 / (1.2 * 0.6), thermal = 3.0 / 0.6 * 2e-3, front = 1.0 / sqrt(modulus / 0.5);
	for (int k = 0; k < 2; k++) {
		const double z[3] = {1.0, 0.0, (k ? 1.6 : 0.6) * front};
		double T = at(&c, EXACT_TEMPERATURE, z[0], 0.0, z[2]);
		conducts(&c, 1.5 / (0.5 * 4.0), 1, z);
		assert_near(modulus * slope(&c, EXACT_DISPLACEMENT_X, z, 0, 1e-3) - thermal * T,
					at(&c, EXACT_STRESS_XX, z[0], 0.0, z[2]), 1e-8);
		assert_near(slope(&c, EXACT_DISPLACEMENT_X, z, 2, 1e-3), at(&c, EXACT_VELOCITY_X, z[0], 0.0, z[2]), 1e-8);
		assert_near(slope(&c, EXACT_STRESS_XX, z, 0, 1e-3), 0.5 * slope(&c, EXACT_VELOCITY_X, z, 2, 1e-3), 1e-7);
	}
	assert_near(at(&c, EXACT_STRESS_XX, 0.0, 0.0, 0.7), 0.0, 1e-15);
}

/* The table is sound, and mistakes are told. */
static void test_table(void **state)
{
	(void)state;
	for (int k = 0; exact_solutions[k]; k++) {
		const struct exact_solution *s = exact_solutions[k];
		assert_ptr_equal(exact_find(s->name), s);
		assert_true(s->n_parameters <= EXACT_PARAMETERS_MAX);
		assert_true(s->value || s->motion);
		for (int i = 0; i < s->n_parameters; i++)
			assert_int_equal(exact_parameter(s, s->parameters[i].name), i);
	}
	struct case_of c = make("rod", NULL);
	assert_int_equal(exact_set(c.s, c.p, "lenght=2"), STATUS_INPUT);
	assert_non_null(strstr(error_message(), "length, diffusivity"));
	assert_int_equal(exact_set(c.s, c.p, "length"), STATUS_INPUT);
	assert_int_equal(exact_set(c.s, c.p, "length=2x"), STATUS_INPUT);
	assert_null(exact_find("rods"));
	assert_int_equal(exact_field_find("stress_xx"), EXACT_STRESS_XX);
	assert_int_equal(exact_field_find("stress"), -1);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_table),   cmocka_unit_test(test_conduction), cmocka_unit_test(test_rod),
		cmocka_unit_test(test_neumann), cmocka_unit_test(test_cooling),    cmocka_unit_test(test_danilovskaya),
		cmocka_unit_test(test_motions), cmocka_unit_test(test_bars),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
