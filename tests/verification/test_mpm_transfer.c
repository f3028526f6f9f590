/* Transfer schemes and orders of the MPM against closed forms: what they keep, what they damp, and the energy ledger
 * of every one of them. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

#include "../common/elastic_scene.h"
#include "../common/near.h"
#include "mpm/mpm.h"
#include "mpm/mpm_private.h"

static const char *const shape_names[] = {"ugimp", "linear"};

/* Every scheme that a scene can ask for. */
struct scheme {
	enum mpm_transfer transfer;
	int order, every;
	double pic;
};

static const struct scheme schemes[] = {
	{MPM_FLIP, 2, 1, 0.0}, {MPM_FLIP, 2, 1, 0.05}, {MPM_XPIC, 1, 1, 0.0}, {MPM_XPIC, 3, 1, 0.0}, {MPM_XPIC, 2, 4, 0.01},
	{MPM_FMPM, 1, 1, 0.0}, {MPM_FMPM, 3, 1, 0.0},  {MPM_FMPM, 2, 4, 0.0}, {MPM_APIC, 2, 1, 0.0},
};
enum { SCHEMES = sizeof schemes / sizeof *schemes, ORDERS = 3 };

static void choose(struct scene *scene, const struct scheme *scheme, int order, const char *shape)
{
	scene->mpm.transfer = scheme->transfer, scene->mpm.order = order;
	scene->mpm.xpic_order = scheme->order, scene->mpm.xpic_every = scheme->every;
	scene->mpm.pic_fraction = scheme->pic;
	snprintf(scene->mpm.shape, sizeof scene->mpm.shape, "%s", shape);
}

static const char *name_of(const struct scheme *scheme)
{
	static char name[64];
	snprintf(name, sizeof name, "%s(%d)/%d, pic %g", mpm_transfer_names[scheme->transfer], scheme->order, scheme->every,
			 scheme->pic);
	return name;
}

/* About the origin, with the spin that an affine motion B holds; kg m2/s. */
static double angular_momentum(const struct mpm *mpm)
{
	double sum = 0.0;
	for (int k = 0; k < mpm->p.n; k++) {
		const double *x = mpm->p.x[k], *v = mpm->p.v[k], *B = mpm->p.affine ? mpm->p.affine[k] : NULL;
		sum += mpm->p.mass[k] * (x[0] * v[1] - x[1] * v[0]);
		if (B && !mpm->shape->affine_by_gradient)
			sum += mpm->p.mass[k] * (B[2] - B[1]);
	}
	return sum;
}

/* Points that cross cells of linear shapes leave nodes of nearly no mass behind, and USL does not bear that: with
 * linear shapes the bodies of these tests move by less than that, for their last STEPS_LINEAR steps only. */
enum { STEPS = 300, STEPS_LINEAR = 80 };

/* A free square that moves and spins, for a quarter of a turn. */
static struct mpm *spinning(struct elastic_scene *s, const struct scheme *scheme, int order, bool linear, double *spin)
{
	struct scene *scene = elastic_scene_init(s, 20, 20, 0.1, 1e6, 0.3, 1000.0, 1e-3);
	choose(scene, scheme, order, shape_names[linear]);
	double at = linear ? 0.6 : 0.63, omega = linear ? 0.5 : 5.0;
	elastic_scene_box(s, 4, at, at, at + 0.6, at + 0.6);
	struct mpm *mpm = start(scene);
	*spin = 0.0;
	for (int k = 0; k < mpm->p.n; k++) {
		double x = mpm->p.x[k][0] - at - 0.3, y = mpm->p.x[k][1] - at - 0.3;
		mpm->p.v[k][0] = omega * (0.06 - y), mpm->p.v[k][1] = omega * (0.04 + x);
		*spin += mpm->p.mass[k] * omega * (x * x + y * y);
	}
	ledger_start(mpm);
	return mpm;
}

/* Momentum to round-off by every scheme, angular momentum to round-off by APIC with uGIMP. */
static void test_momentum(void **state)
{
	(void)state;
	for (int k = 0; k < 2 * ORDERS * SCHEMES; k++) {
		const struct scheme *scheme = &schemes[k / 2 % SCHEMES];
		int order = k / 2 / SCHEMES, linear = k % 2;
		struct elastic_scene s;
		double spin, worst = 0.0;
		struct mpm *mpm = spinning(&s, scheme, order, linear, &spin);
		double px = sum_momentum(mpm, 0), py = sum_momentum(mpm, 1), mass = sum_mass(mpm);
		double before = angular_momentum(mpm);
		for (int step = 0; step < (linear ? STEPS_LINEAR : STEPS); step++) {
			steps(mpm, 1);
			assert_near(sum_momentum(mpm, 0), px, 1e-12 * mass);
			assert_near(sum_momentum(mpm, 1), py, 1e-12 * mass);
			worst = fmax(worst, fabs(angular_momentum(mpm) - before));
		}
		print_message("%-5s %-7s %-24s spin changes by %.2g of itself\n", mpm_order_names[order], shape_names[linear],
					  name_of(scheme), worst / spin);
		if (scheme->transfer == MPM_APIC && !linear)
			assert_true(worst < 1e-12 * spin);
		mpm_free(mpm);
	}
}

/* The ledger of every scheme and order closes: a block that falls on a floor with friction, slides and bounces, beside
 * it another one that an imposed velocity pulls. */
static void test_ledger(void **state)
{
	(void)state;
	for (int k = 0; k < 2 * ORDERS * SCHEMES; k++) {
		const struct scheme *scheme = &schemes[k / 2 % SCHEMES];
		int order = k / 2 / SCHEMES, linear = k % 2;
		struct elastic_scene s;
		struct scene *scene = elastic_scene_init(&s, 40, 16, 0.1, 1e6, 0.2, 1000.0, 5e-4);
		choose(scene, scheme, order, shape_names[linear]);
		scene->gravity[1] = -9.81;
		scene->mpm.damping_particle = 0.1, scene->mpm.damping_grid = 0.1;
		double bottom = linear ? 0.3 : 0.4;
		elastic_scene_box(&s, 4, 0.5, bottom, 1.2, bottom + 0.5)->velocity[0] = linear ? 0.3 : 1.5;
		elastic_scene_box(&s, 4, 2.5, 0.3, 3.1, 0.8);
		elastic_scene_line(&s, 0.0, 0.3, 4.0, 0.3)->friction = 0.3;
		elastic_scene_boundary(&s, 3.0, 0.3, 3.1, 0.8)->velocity[0] = 0.1;
		struct mpm *mpm = start(scene);
		double worst = 0.0;
		for (int step = 0; step < (linear ? STEPS_LINEAR : 2 * STEPS); step += 5) {
			steps(mpm, 5);
			mpm_measure(mpm);
			worst = fmax(worst, fabs(mpm->ledger.energy_residual));
		}
		double work = mpm_work(mpm)->total.scale;
		print_message("%-5s %-7s %-24s residual %.2g, numerical loss %.3g of the work %.4g J\n", mpm_order_names[order],
					  shape_names[linear], name_of(scheme), worst / work, mpm->ledger.loss_numerical / work, work);
		assert_true(worst < 1e-4 * work);
		mpm_free(mpm);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_momentum),
		cmocka_unit_test(test_ledger),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
