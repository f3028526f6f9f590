/* Same bits for any number of threads and across a restart; every guard fires and says why. */
/* timeout: 120 */
#include <math.h>
#include <omp.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "../common/elastic_scene.h"
#include "../common/saved_state.h"
#include "../common/near.h"
#include "base/error.h"
#include "base/mat2.h"
#include "mpm/mpm.h"
#include "mpm/mpm_private.h"

/* Everything at once: two laws, heat, walls of all kinds, a moving one, stages, damping; big enough for threads. */
static struct scene *everything(struct elastic_scene *s)
{
	struct scene *scene = elastic_scene_init(s, 60, 48, 0.05, 1e6, 0.3, 1000.0, 2e-4);
	scene->n_laws = scene->n_materials = 2;
	s->laws[1].thermoelastic.young = 2e6;
	scene->gravity[1] = -9.81;
	scene->mpm.pic_fraction = 0.01;
	scene->mpm.damping_grid = 0.1;
	elastic_scene_heat(s, 1e-5, 1.0, 300.0);
	scene->time.thermal_every = 2;
	elastic_scene_box(s, 9, 0.3, 0.15, 1.7, 1.0)->temperature = 300.0;
	struct scene_body *ball = elastic_scene_box(s, 4, 0.8, 1.1, 1.4, 1.5);
	ball->material = 1, ball->velocity[0] = 2.0, ball->velocity[1] = -1.5, ball->temperature = 350.0;
	struct scene_wall *floor = elastic_scene_line(s, 0.0, 0.15, 3.0, 0.15);
	floor->friction = 0.5, floor->heat_share = 0.5;
	const double wedge[] = {1.9, 0.15, 2.9, 0.15, 2.9, 1.15};
	elastic_scene_wall(s, SCENE_WALL_POLYGON, 3, wedge)->friction = 0.3;
	struct scene_wall *plate = elastic_scene_line(s, 0.25, 0.1, 0.25, 1.2);
	plate->vertices[0][1] = 1.2, plate->vertices[1][1] = 0.1;
	plate->velocity[0] = 0.2, plate->temperature = 320.0;
	s->stages[0] = (struct scene_stage){.duration = 0.012, .damping = 5.0, .n_walls = -1, .then_zero_velocity = false};
	s->stages[1] = (struct scene_stage){.duration = INFINITY, .n_walls = -1};
	scene->n_stages = 2;
	return scene;
}

/* The transfer schemes and orders, and how long they are run: the first ones as long as needed to see everything. */
static const struct {
	enum mpm_transfer transfer;
	enum mpm_order order;
	int xpic_order, xpic_every;
	const char *shape;
	int steps;    /* more than 64: across a change of stage and a re-sort */
	bool follows; /* the grid is stretched with the plate */
} schemes[] = {
	{MPM_FLIP, MPM_USL, 2, 1, "ugimp", 180, false}, {MPM_XPIC, MPM_USF, 3, 4, "ugimp", 70, true},
	{MPM_FMPM, MPM_MUSL, 2, 1, "ugimp", 70, false}, {MPM_APIC, MPM_USL, 2, 1, "ugimp", 70, false},
	{MPM_APIC, MPM_MUSL, 2, 1, "ugimp", 70, true},  {MPM_APIC, MPM_USF, 2, 1, "linear", 70, false},
};
enum { SCHEMES = sizeof schemes / sizeof *schemes };

static struct scene *everything_by(struct elastic_scene *s, int k)
{
	struct scene *scene = everything(s);
	scene->mpm.transfer = schemes[k].transfer, scene->mpm.order = schemes[k].order;
	scene->mpm.xpic_order = schemes[k].xpic_order, scene->mpm.xpic_every = schemes[k].xpic_every;
	snprintf(scene->mpm.shape, sizeof scene->mpm.shape, "%s", schemes[k].shape);
	scene->grid.follows = schemes[k].follows, scene->grid.follow = 2, scene->grid.fixed[0] = 3.0;
	return scene;
}

static void test_threads(void **state)
{
	(void)state;
	const int threads[3] = {1, 2, 4};
	for (int scheme = 0; scheme < SCHEMES; scheme++) {
		struct elastic_scene s;
		struct scene *scene = everything_by(&s, scheme);
		struct saved one;
		for (int k = 0; k < 3; k++) {
			omp_set_num_threads(threads[k]);
			struct mpm *mpm = start(scene);
			assert_true(mpm_parallel(mpm));
			steps(mpm, scheme == 0 ? schemes[scheme].steps : 24); /* nothing else happens to the others */
			mpm_measure(mpm);
			if (k == 0)
				save(mpm, &one);
			else
				assert_same(mpm, &one);
			mpm_free(mpm);
		}
		discard(&one);
	}
	omp_set_num_threads(1);
}

/* Half the steps + restart + half, across a change of stage, a re-sort and an odd thermal step. */
static void test_restart(void **state)
{
	(void)state;
	for (int scheme = 0; scheme < SCHEMES; scheme++) {
		struct elastic_scene s;
		struct scene *scene = everything_by(&s, scheme);
		struct saved half, whole;
		struct mpm *mpm = start(scene);
		int first = schemes[scheme].steps / 2 + 1, second = schemes[scheme].steps - first;
		steps(mpm, first);
		mpm_measure(mpm);
		save(mpm, &half);
		steps(mpm, second);
		save(mpm, &whole);
		mpm_free(mpm);
		mpm = start(scene);
		load(mpm, &half);
		assert_same(mpm, &half);
		steps(mpm, second);
		assert_same(mpm, &whole);
		assert_int_equal(mpm->stage, 1);
		assert_int_equal(mpm->grid.spacing[0] != mpm->grid.h, schemes[scheme].follows);
		mpm_free(mpm);
		discard(&half);
		discard(&whole);
	}
}

static void assert_says(const char *what)
{
	if (!strstr(error_message(), what))
		fail_msg("\"%s\" does not say \"%s\"", error_message(), what);
}

static struct scene *falling_block(struct elastic_scene *s, double young)
{
	struct scene *scene = elastic_scene_init(s, 20, 20, 0.1, young, 0.2, 1000.0, 1e-3);
	scene->gravity[1] = -9.81;
	elastic_scene_box(s, 4, 0.5, 0.4, 1.2, 1.0);
	elastic_scene_line(s, 0.0, 0.3, 2.0, 0.3)->friction = 0.2;
	return scene;
}

static void test_step_limit(void **state)
{
	(void)state;
	struct elastic_scene s;
	struct scene *scene = falling_block(&s, 1e6);
	struct mpm *mpm = start(scene);
	steps(mpm, 10);
	double limit = 0.1 * sqrt(1000.0 / (1e6 * 0.8 / (1.2 * 0.6)));
	assert_near(mpm->stable_step, limit, 1e-3 * limit);
	scene->time.step = 1.01 * mpm->stable_step;
	assert_int_equal(mpm_step(mpm), STATUS_GUARD);
	assert_says("step 10, t = ");
	assert_says("above the limit");
	assert_says("cure: ");
	mpm_free(mpm);
	/* a scene that begins over the limit is wrong from the start */
	assert_int_equal(mpm_create(&mpm, scene), STATUS_INPUT);
	assert_null(mpm);
	/* the factor of eq. 30 shifts both limits, that of the points' places too */
	scene->time.step = 0.0012;
	ok(mpm_create(&mpm, scene));
	mpm_free(mpm);
	scene->time.step_factor = 0.5;
	assert_int_equal(mpm_create(&mpm, scene), STATUS_INPUT);
	assert_says("as they lie in their grid cells");
	assert_says("cure: ");
	/* and a study may walk past them */
	scene->guards.time_step = false;
	scene->time.step = 0.004;
	ok(mpm_create(&mpm, scene));
	ok(mpm_step(mpm));
	mpm_free(mpm);
}

/* The limit of the points' places is that of the last look, also where a restart or zero_ledger lies between. */
static void test_last_look(void **state)
{
	(void)state;
	struct elastic_scene s;
	struct mpm *mpm = start(falling_block(&s, 1e4));
	mpm->lattice_limit = 123.0; /* of another place, as a checkpoint brings it */
	steps(mpm, 1);
	assert_near(mpm->lattice_limit, 123.0, 0.0);
	mpm_work(mpm)->total.limit_watched = 1.0;
	ledger_start(mpm);
	assert_near(mpm_work(mpm)->total.limit_watched, 1.0, 0.0);
	steps(mpm, 1);
	mpm_free(mpm);
	/* the look at birth is no step: points that just reach into a cell know no limit, but nothing has grown */
	struct scene *scene = elastic_scene_init(&s, 20, 20, 0.1, 1e6, 0.2, 1000.0, 1e-3);
	snprintf(scene->mpm.shape, sizeof scene->mpm.shape, "linear");
	elastic_scene_box(&s, 4, 0.5, 0.5, 1.11, 1.0)->lattice_origin[0] = 0.025001;
	mpm = start(scene);
	assert_true(mpm_work(mpm)->limit.motion > 2.0);
	for (int k = 0; k < mpm->p.n; k++)
		assert_near(mpm->p.growth[k], 0.0, 0.0);
	mpm_free(mpm);
}

static void test_thermal_limit(void **state)
{
	(void)state;
	struct elastic_scene s;
	struct scene *scene = falling_block(&s, 1e6);
	elastic_scene_heat(&s, 0.0, 1.0, 6000.0); /* rho c h^2/2k = 0.83 ms */
	struct mpm *mpm;
	assert_int_equal(mpm_create(&mpm, scene), STATUS_INPUT);
	assert_says("heat conduction");
	scene->time.thermal_steps = 3;
	ok(mpm_create(&mpm, scene));
	steps(mpm, 20);
	mpm_free(mpm);
}

static void test_leaving(void **state)
{
	(void)state;
	struct elastic_scene s;
	struct scene *scene = falling_block(&s, 1e6);
	scene->n_walls = 0;
	struct mpm *mpm = start(scene);
	int status = STATUS_OK;
	for (int k = 0; k < 1000 && status == STATUS_OK; k++)
		status = mpm_step(mpm);
	assert_int_equal(status, STATUS_GUARD);
	assert_says("left the grid");
	assert_near(mpm->time, sqrt(2.0 * 0.425 / 9.81), 2e-3);
	/* and it does not go on without them, should one try */
	assert_int_equal(mpm_step(mpm), STATUS_GUARD);
	assert_says("outside the grid");
	mpm_free(mpm);
	/* or they are parked, and the rest goes on, until all are gone */
	scene->guards.points_leaving = false;
	mpm = start(scene);
	double energy = 0.0;
	steps(mpm, 1000);
	mpm_measure(mpm);
	for (int k = 0; k < mpm->p.n; k++) {
		assert_true(mpm->p.x[k][1] < 0.0);
		assert_near(mpm->p.v[k][1], 0.0, 0.0);
		energy += mpm->p.mass[k] * 9.81 * (mpm->p.x0[k][1] - mpm->p.x[k][1]);
	}
	assert_near(mpm->ledger.energy_discarded, energy, 0.02 * energy);
	mpm_free(mpm);
}

static void test_not_a_number(void **state)
{
	(void)state;
	struct elastic_scene s;
	struct mpm *mpm = start(falling_block(&s, 1e6));
	steps(mpm, 5);
	mpm->p.stress[mpm_point_by_id(mpm, 17)][1] = NAN;
	assert_int_equal(mpm_step(mpm), STATUS_GUARD);
	assert_says("point 17 at");
	assert_says("not a number");
	mpm_free(mpm);
	mpm = start(falling_block(&s, 1e6));
	mpm->p.v[mpm_point_by_id(mpm, 17)][1] = NAN;
	assert_int_equal(mpm_step(mpm), STATUS_GUARD);
	assert_says("not a number");
	mpm_free(mpm);
}

/* A point that is turned inside out: the law's guard comes with the point's name. */
static void test_law_guard(void **state)
{
	(void)state;
	struct elastic_scene s;
	struct scene *scene = falling_block(&s, 1e6);
	scene->guards.numerical_fracture = false; /* would see it first */
	struct mpm *mpm = start(scene);
	int point = mpm_point_by_id(mpm, 23);
	mpm->p.F[point][0] = -1.0, mpm->p.modulus[point] = 0.0;
	for (int c = 0; c < 4; c++)
		mpm->p.stress[point][c] = 0.0;
	assert_int_equal(mpm_step(mpm), STATUS_GUARD);
	assert_says("point 23 at");
	assert_says("inside out");
	assert_true(mpm->within_step);
	mpm_free(mpm);
}

/* A guard on the way to the grid leaves a state to go on from, but not with USF, which has strained the points. */
static void test_within_step(void **state)
{
	(void)state;
	struct elastic_scene s;
	struct scene *scene = falling_block(&s, 1e6);
	for (int usf = 0; usf < 2; usf++) {
		scene->time.step = 1e-3;
		scene->mpm.order = usf ? MPM_USF : MPM_USL;
		struct mpm *mpm = start(scene);
		steps(mpm, 3);
		assert_false(mpm->within_step);
		scene->time.step = 0.01;
		assert_int_equal(mpm_step(mpm), STATUS_GUARD);
		assert_says(usf ? "state: within the step" : "state: start of the step");
		assert_int_equal(mpm->within_step, usf);
		mpm_free(mpm);
	}
}

static double largest_stretch(const struct mpm *mpm)
{
	double most = 0.0, e[3];
	for (int k = 0; k < mpm->p.n; k++) {
		mat2_log_stretch(mpm->p.F[k], e);
		most = fmax(most, exp(0.5 * (e[0] + e[1]) + hypot(0.5 * (e[0] - e[1]), e[2])));
	}
	return most;
}

/* A block that flies apart: the Hencky law stops the run where its points pass a stretch of 1.3956, with the books
 * still in order; the neo-Hookean law goes on to twice the stretch. */
static void test_stretched_too_far(void **state)
{
	(void)state;
	for (int neo_hookean = 0; neo_hookean < 2; neo_hookean++) {
		struct elastic_scene s;
		struct scene *scene = elastic_scene_init(&s, 40, 10, 0.05, 1e3, 0.3, 1000.0, 1e-4);
		s.laws[0].thermoelastic.neo_hookean = neo_hookean;
		elastic_scene_box(&s, 4, 0.75, 0.15, 1.25, 0.35);
		struct mpm *mpm = start(scene);
		for (int k = 0; k < mpm->p.n; k++)
			mpm->p.v[k][0] = 4.0 * (mpm->p.x[k][0] - 1.0);
		ledger_start(mpm);
		int status = STATUS_OK;
		double most = 1.0;
		while (status == STATUS_OK && most < 2.0) {
			status = mpm_step(mpm);
			most = largest_stretch(mpm);
		}
		mpm_measure(mpm);
		assert_near(mpm->ledger.energy_residual, 0.0, 1e-3 * mpm_work(mpm)->total.scale);
		assert_int_equal(status, neo_hookean ? STATUS_OK : STATUS_GUARD);
		if (!neo_hookean) {
			assert_near(most, 1.3956, 1e-3);
			assert_says("leaves its domain of validity");
			assert_says("step ");
			assert_says(": point ");
			assert_says("cure: elasticity = \"neo_hookean\"");
		}
		mpm_free(mpm);
	}
}

/* The ledger of a block that falls on a floor, slides and bounces closes; with 1% too much internal force it does not,
 * and the run stops. */
static void test_planted_error(void **state)
{
	(void)state;
	struct elastic_scene s;
	struct scene *scene = falling_block(&s, 1e5);
	s.bodies[0].velocity[0] = 0.5;
	scene->guards.energy_residual = 5e-3;
	double share[3];
	for (int planted = 0; planted < 3; planted++) {
		struct mpm *mpm = start(scene);
		mpm_work(mpm)->internal_force_scale = planted ? 1.01 : 1.0;
		int status = STATUS_OK;
		double worst = 0.0;
		for (int k = 0; k < 1000 && status == STATUS_OK; k++) {
			status = mpm_step(mpm);
			if (planted < 2) /* also where nobody wants a row of the history */
				mpm_measure(mpm);
			worst = fmax(worst, fabs(mpm->ledger.energy_residual) / mpm_work(mpm)->total.scale);
		}
		share[planted] = worst;
		assert_int_equal(status, planted ? STATUS_GUARD : STATUS_OK);
		if (planted) {
			assert_says("ledger does not add up");
			assert_says("cure: ");
		}
		mpm_free(mpm);
	}
	print_message("residual: %.3g %% of the work, %.3g %% with the planted error\n", 100 * share[0], 100 * share[1]);
	assert_true(share[0] < 1e-4);
}

static void test_point_in_wall(void **state)
{
	(void)state;
	struct elastic_scene s;
	struct scene *scene = falling_block(&s, 1e6);
	const double box[] = {1.1, 0.9, 1.6, 0.9, 1.6, 1.4, 1.1, 1.4};
	elastic_scene_wall(&s, SCENE_WALL_POLYGON, 4, box);
	struct mpm *mpm;
	assert_int_equal(mpm_create(&mpm, scene), STATUS_INPUT);
	assert_says("covers points");
}

/* Stages: damping only in the first; at its end velocities and ledger begin anew. */
static void test_stages(void **state)
{
	(void)state;
	struct elastic_scene s;
	struct scene *scene = falling_block(&s, 1e6);
	s.stages[0] = (struct scene_stage){
		.duration = 0.02, .damping = 20.0, .n_walls = -1, .then_zero_velocity = true, .then_zero_ledger = true};
	s.stages[1] = (struct scene_stage){.duration = INFINITY, .n_walls = 0};
	scene->n_stages = 2;
	struct mpm *mpm = start(scene);
	steps(mpm, 19);
	assert_int_equal(mpm->stage, 0);
	assert_true(mpm->p.v[0][1] < -0.1);
	steps(mpm, 1);
	assert_int_equal(mpm->stage, 1);
	assert_near(mpm->stage_start, 0.02, 1e-12);
	mpm_measure(mpm);
	assert_near(mpm->ledger.energy_kinetic, 0.0, 0.0);
	assert_near(mpm->ledger.loss_numerical, 0.0, 1e-9);
	assert_near(mpm->ledger.energy_residual, 0.0, 1e-9);
	steps(mpm, 200);
	mpm_measure(mpm);
	assert_near(mpm->ledger.energy_kinetic, 0.5 * sum_mass(mpm) * pow(9.81 * 0.2, 2),
				1e-6 * mpm->ledger.energy_kinetic);
	assert_near(mpm->ledger.energy_residual, 0.0, 1e-9 * mpm->ledger.energy_kinetic);
	mpm_free(mpm);
}

/* A ledger that begins anew in a loaded body: what the energy guards compare with is what is stored there, not zero. */
static void test_ledger_begins_loaded(void **state)
{
	(void)state;
	struct elastic_scene s;
	struct scene *scene = elastic_scene_init(&s, 20, 20, 0.1, 1e6, 0.2, 1000.0, 1e-3);
	scene->gravity[1] = -9.81;
	elastic_scene_box(&s, 4, 0.5, 0.3, 1.2, 1.0);
	elastic_scene_line(&s, 0.0, 0.3, 2.0, 0.3);
	s.stages[0] = (struct scene_stage){
		.duration = 0.1, .damping = 50.0, .n_walls = -1, .then_zero_velocity = true, .then_zero_ledger = true};
	s.stages[1] = (struct scene_stage){.duration = INFINITY, .n_walls = -1};
	scene->n_stages = 2;
	struct mpm *mpm = start(scene);
	steps(mpm, 100);
	assert_int_equal(mpm->stage, 1);
	mpm_measure(mpm);
	assert_true(mpm->ledger.energy_elastic > 0.0);
	assert_near(mpm_work(mpm)->total.scale, mpm->ledger.energy_elastic, 1e-12 * mpm->ledger.energy_elastic);
	steps(mpm, 20);
	mpm_free(mpm);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_threads),           cmocka_unit_test(test_restart),
		cmocka_unit_test(test_step_limit),        cmocka_unit_test(test_last_look),
		cmocka_unit_test(test_thermal_limit),     cmocka_unit_test(test_leaving),
		cmocka_unit_test(test_not_a_number),      cmocka_unit_test(test_law_guard),
		cmocka_unit_test(test_within_step),       cmocka_unit_test(test_planted_error),
		cmocka_unit_test(test_point_in_wall),     cmocka_unit_test(test_stages),
		cmocka_unit_test(test_stretched_too_far), cmocka_unit_test(test_ledger_begins_loaded),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
