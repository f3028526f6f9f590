/* timeout: 300
 *
 * Bodies that touch: what must hold whatever the scene (momentum, energy, heat, bits), and the scenes in which methods
 * of this kind fail: faces between rows of nodes, leading edges, corners, three bodies at a node, thin bodies, slots.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>
#include <omp.h>

#include "../common/elastic_scene.h"
#include "../common/near.h"
#include "../common/saved_state.h"
#include "contact/private.h"
#include "mpm/mpm_private.h"

static const double H = 1e-3, STEP = 5e-8; /* m, s: a wave goes a third of a cell in a step */

/* Aluminium on cells of 1 mm. */
static struct scene *metal(struct elastic_scene *s, int cells_x, int cells_y)
{
	struct scene *scene = elastic_scene_init(s, cells_x, cells_y, H, 70e9, 0.3, 2700.0, STEP);
	snprintf(scene->mpm.shape, sizeof scene->mpm.shape, "ugimp");
	return scene;
}

/* A box in cells, its points on a lattice that begins at its own corner. */
static struct scene_body *box(struct elastic_scene *s, double x0, double y0, double x1, double y1)
{
	struct scene_body *body = elastic_scene_box(s, 4, x0 * H, y0 * H, x1 * H, y1 * H);
	body->lattice_origin[0] = x0 * H, body->lattice_origin[1] = y0 * H;
	return body;
}

static struct scene_body *disc(struct elastic_scene *s, double x, double y, double radius)
{
	enum { CORNERS = 8 };
	double corners[2 * CORNERS];
	for (int k = 0; k < CORNERS; k++) {
		corners[2 * k] = (x + radius * cos(2.0 * M_PI * k / CORNERS)) * H;
		corners[2 * k + 1] = (y + radius * sin(2.0 * M_PI * k / CORNERS)) * H;
	}
	struct scene_body *body = elastic_scene_body(s, 4, CORNERS, corners);
	body->centre[0] = x * H, body->centre[1] = y * H, body->radius = radius * H;
	return body;
}

static double body_velocity(const struct mpm *mpm, int body, int c)
{
	double momentum = 0.0, mass = 0.0;
	for (int k = 0; k < mpm->p.n; k++)
		if (mpm->p.body[k] == body)
			momentum += mpm->p.mass[k] * mpm->p.v[k][c], mass += mpm->p.mass[k];
	return momentum / mass;
}

static double fastest(const struct mpm *mpm, int body)
{
	double most = 0.0;
	for (int k = 0; k < mpm->p.n; k++)
		if (mpm->p.body[k] == body)
			most = fmax(most, hypot(mpm->p.v[k][0], mpm->p.v[k][1]));
	return most;
}

/* ---- sums ---- */

/* Two discs meet off their centres, with friction. */
static struct scene *collision(struct elastic_scene *s, double friction)
{
	struct scene *scene = metal(s, 30, 24);
	disc(s, 9.0, 10.0, 4.0)->velocity[0] = 20.0;
	disc(s, 18.0, 13.0, 4.0)->velocity[0] = -10.0;
	elastic_scene_contact(s, friction);
	return scene;
}

static void test_momentum(void **state)
{
	(void)state;
	struct elastic_scene s;
	struct mpm *mpm = start(collision(&s, 0.4));
	double before[2] = {sum_momentum(mpm, 0), sum_momentum(mpm, 1)}, scale = 0.0;
	for (int k = 0; k < mpm->p.n; k++)
		scale += mpm->p.mass[k] * fabs(mpm->p.v[k][0]);
	steps(mpm, 1500);
	mpm_measure(mpm);
	assert_true(mpm->ledger.work_contact_friction > 0.0);
	assert_true(body_velocity(mpm, 0, 0) < 10.0 && body_velocity(mpm, 1, 0) > 0.0);
	assert_true(body_velocity(mpm, 1, 1) > 1.0);
	for (int c = 0; c < 2; c++)
		assert_near(sum_momentum(mpm, c), before[c], 1e-12 * scale);
	assert_true(fabs(mpm->ledger.energy_residual) < 1e-6 * mpm->ledger.energy_kinetic);
	mpm_free(mpm);
}

/* Mass, momentum and force of the fields add up to those of a scene in which the bodies are welded. */
static void test_fields_add_up(void **state)
{
	(void)state;
	double sums[2][4] = {{0.0}};
	for (int fields = 0; fields < 2; fields++) {
		struct elastic_scene s;
		struct scene *scene = metal(&s, 20, 20);
		box(&s, 4.0, 4.3, 14.0, 8.3);
		box(&s, 5.0, 8.3, 11.0, 12.3)->velocity[0] = 30.0;
		if (fields)
			elastic_scene_contact(&s, 0.3);
		struct mpm *mpm = start(scene);
		for (int k = 0; k < mpm->p.n; k++)
			mpm->p.stress[k][1] = -1e6 * (1.0 + mpm->p.x[k][1] / H);
		steps(mpm, 1);
		const struct mpm_work *w = mpm_work(mpm);
		if (fields) {
			assert_true(contact_slots_used(mpm) > 10);
		} else { /* no field beside the grid's, no room for one, no pass */
			assert_null(w->contact);
			assert_int_equal(w->n_rows, mpm->grid.ny);
			assert_int_equal(w->n_nodes, mpm->grid.nx * mpm->grid.ny);
			assert_null(mpm->p.contact_pressure);
		}
		for (int j = 0; j < w->n_rows; j++)
			for (int i = w->row_low[j]; i <= w->row_high[j]; i++) {
				int node = j * mpm->grid.nx + i;
				double y = mpm_home(mpm, node) / mpm->grid.nx; /* moments tell nodes apart */
				sums[fields][0] += w->sums[node].mass * y;
				sums[fields][1] += w->sums[node].momentum[0] * y;
				sums[fields][2] += w->sums[node].force[1] * y;
			}
		for (int node = 0; node < mpm->grid.nx * mpm->grid.ny; node++) /* as those see it who look at the grid */
			sums[fields][3] += mpm->grid.mass[node] * mpm->grid.v_new[node][0];
		mpm_free(mpm);
	}
	for (int k = 0; k < 4; k++)
		assert_near(sums[1][k], sums[0][k], 1e-12 * fabs(sums[0][k]));
}

/* ---- separation ---- */

/* Flush bodies that are pulled apart do not feel each other, whatever the place of their face in the grid. */
static void test_pull_apart(void **state)
{
	(void)state;
	for (double at = 0.0; at < 0.95; at += 0.1) {
		struct elastic_scene s;
		struct scene *scene = metal(&s, 20, 24);
		box(&s, 4.0, 4.0 + at, 14.0, 8.0 + at);
		box(&s, 6.0, 8.0 + at, 12.0, 12.0 + at)->velocity[1] = 20.0;
		elastic_scene_contact(&s, 0.3);
		struct mpm *mpm = start(scene);
		steps(mpm, 1000);
		assert_true(fastest(mpm, 0) == 0.0);
		assert_near(body_velocity(mpm, 1, 1), 20.0, 1e-11);
		mpm_free(mpm);
	}
}

/* Bodies that meet feel each other when they are near, not a cell before. */
static void test_first_touch(void **state)
{
	(void)state;
	for (double at = 0.0; at < 0.95; at += 0.1) {
		struct elastic_scene s;
		struct scene *scene = metal(&s, 20, 24);
		box(&s, 4.0, 4.0 + at, 14.0, 8.0 + at);
		box(&s, 6.0, 9.5 + at, 12.0, 13.5 + at)->velocity[1] = -20.0;
		elastic_scene_contact(&s, 0.3);
		struct mpm *mpm = start(scene);
		int n = 0;
		while (fastest(mpm, 0) == 0.0 && n++ < 3000)
			steps(mpm, 1);
		double gap = 1.5 - n * 20.0 * STEP / H;
		if (!(gap < 0.3 && gap > -0.3))
			fail_msg("face at %g: first touch at a gap of %g cells", at, gap);
		mpm_free(mpm);
	}
}

/* ---- sliding ---- */

/* A slider on a long base, whose face is `at` cells above a row of nodes. */
static struct scene *slider(struct elastic_scene *s, double at, double friction, double gravity)
{
	struct scene *scene = metal(s, 40, 16);
	const double bottom = 1.0 + at, face = 4.0 + at;
	box(s, 2.0, bottom, 38.0, face);
	box(s, 6.0, face, 14.0, face + 4.0)->velocity[0] = 30.0;
	elastic_scene_line(s, 0.0, bottom * H, 40.0 * H, bottom * H)->contact = SCENE_WALL_STICK;
	elastic_scene_contact(s, friction);
	scene->gravity[1] = -gravity;
	return scene;
}

/* Without friction it goes on at its speed; leading and trailing edges are where other normals brake. */
static void test_slide_without_friction(void **state)
{
	(void)state;
	for (double at = 0.0; at < 0.95; at += 0.3) {
		struct elastic_scene s;
		struct mpm *mpm = start(slider(&s, at, 0.0, 0.0));
		steps(mpm, 4000);                        /* six cells */
		if (!(body_velocity(mpm, 1, 0) > 29.97)) /* 0.1% */
			fail_msg("face at %g: 30 m/s have become %g", at, body_velocity(mpm, 1, 0));
		mpm_free(mpm);
	}
}

/* Coulomb: m dv/dt = - mu m g; the heat of friction is what the ledger says, and what the points have got. */
static void test_slide_with_friction(void **state)
{
	(void)state;
	const double mu = 0.3, g = 2e5;
	for (int k = 0; k < 2; k++) {
		struct elastic_scene s;
		struct scene *scene = slider(&s, k * 0.4, mu, g);
		elastic_scene_heat(&s, 0.0, 900.0, 150.0);
		scene->mpm.pic_fraction = 1e-3; /* settles under its weight */
		struct mpm *mpm = start(scene);
		steps(mpm, 4000);
		double t = mpm->time, expected = 30.0 - mu * g * t;
		mpm_measure(mpm);
		assert_near(body_velocity(mpm, 1, 0), expected, 0.05 * mu * g * t);
		const struct mpm_ledger *l = &mpm->ledger;
		assert_true(l->work_contact_friction > 0.0);
		assert_near(l->energy_thermal, l->work_contact_friction, 1e-9 * l->work_contact_friction);
		assert_true(fabs(l->heat_residual) < 1e-9 * l->work_contact_friction);
		assert_true(fabs(l->energy_residual) < 1e-3 * l->work_contact_friction);
		mpm_free(mpm);
	}
}

/* ---- heat ---- */

/* A warm block pressed on a cold one: what one gives the other gets, and only while they touch. */
static void test_conduction(void **state)
{
	(void)state;
	for (int apart = 0; apart < 2; apart++) {
		struct elastic_scene s;
		struct scene *scene = metal(&s, 16, 20);
		elastic_scene_heat(&s, 0.0, 900.0, 150.0);
		scene->thermal.time_scale = 1e4;
		box(&s, 4.0, 4.0, 10.0, 8.0)->temperature = 300.0;
		struct scene_body *warm = box(&s, 4.0, 8.0, 10.0, 12.0);
		warm->temperature = 400.0, warm->velocity[1] = apart ? 5.0 : -5.0;
		elastic_scene_contact(&s, 0.0)->conductance = 1e-4; /* at 1 Pa */
		struct mpm *mpm = start(scene);
		steps(mpm, 60);
		mpm_measure(mpm);
		double content = 0.0, cold = 0.0, capacity = 900.0;
		for (int k = 0; k < mpm->p.n; k++) {
			content += mpm->p.mass[k] * capacity * mpm->p.T[k];
			cold += mpm->p.body[k] == 0 ? mpm->p.mass[k] * capacity * (mpm->p.T[k] - 300.0) : 0.0;
		}
		assert_true(apart ? cold == 0.0 : cold > 1e-3);
		assert_near(mpm->ledger.energy_thermal, mpm->ledger.work_contact_friction, 1e-12 * content);
		mpm_free(mpm);
	}
}

/* ---- bits ---- */

/* Big enough for several threads: two warm blocks, one sliding on the other, over a wall. */
static struct scene *big(struct elastic_scene *s)
{
	struct scene *scene = metal(s, 64, 40);
	elastic_scene_heat(s, 1e-5, 900.0, 150.0);
	box(s, 4.0, 2.0, 60.0, 16.3);
	struct scene_body *top = box(s, 10.0, 16.3, 40.0, 32.3);
	top->velocity[0] = 20.0, top->velocity[1] = -5.0, top->temperature = 350.0;
	elastic_scene_line(s, 0.0, 2.0 * H, 64.0 * H, 2.0 * H)->friction = 0.2;
	struct scene_contact *contact = elastic_scene_contact(s, 0.3);
	contact->conductance = 1e-3;
	contact->softening[0] = 290.0, contact->softening[1] = 900.0;
	return scene;
}

static void test_same_bits(void **state)
{
	(void)state;
	struct elastic_scene s;
	struct saved whole, half;
	struct scene *scene = big(&s);
	omp_set_num_threads(1);
	struct mpm *mpm = start(scene);
	assert_true(mpm->p.n >= PARALLEL_POINTS);
	steps(mpm, 40);
	save(mpm, &half);
	steps(mpm, 40);
	assert_true(mpm->ledger.work_contact_friction >= 0.0);
	save(mpm, &whole);
	mpm_free(mpm);
	omp_set_num_threads(3);
	mpm = start(scene);
	steps(mpm, 80);
	assert_same(mpm, &whole);
	mpm_free(mpm);
	mpm = start(scene); /* and across a restart */
	load(mpm, &half);
	steps(mpm, 40);
	assert_same(mpm, &whole);
	mpm_free(mpm);
	omp_set_num_threads(1);
	discard(&half);
	discard(&whole);
}

/* ---- where methods of this kind fail ---- */

/* Flush corners: two blocks of one width meet face to face.  At the ends of the face both gradients are askew, and yet
 * nothing goes sideways, nothing rubs, and they part again with most of their speed. */
static void test_flush_corners(void **state)
{
	(void)state;
	for (double at = 0.0; at < 0.95; at += 0.3) {
		struct elastic_scene s;
		struct scene *scene = metal(&s, 18, 24);
		box(&s, 5.0 + at, 4.0 + at, 11.0 + at, 9.0 + at)->velocity[1] = 10.0;
		box(&s, 5.0 + at, 9.1 + at, 11.0 + at, 14.1 + at)->velocity[1] = -10.0;
		elastic_scene_contact(&s, 0.3);
		struct mpm *mpm = start(scene);
		steps(mpm, 400);
		mpm_measure(mpm);
		assert_near(body_velocity(mpm, 0, 0), 0.0, 0.05);
		assert_near(body_velocity(mpm, 1, 0), 0.0, 0.05);
		if (!(body_velocity(mpm, 1, 1) > 6.0))
			fail_msg("corner at %g: 10 m/s come back as %g", at, body_velocity(mpm, 1, 1));
		if (!(mpm->ledger.work_contact_friction < 0.01 * mpm->ledger.energy_kinetic))
			fail_msg("corner at %g: friction of %g J", at,
					 mpm->ledger.work_contact_friction / mpm->ledger.energy_kinetic);
		mpm_free(mpm);
	}
}

/* Three bodies at a node: two that slide past each other on a third.  Three fields; momentum; nobody passes. */
static void test_three_bodies(void **state)
{
	(void)state;
	struct elastic_scene s;
	struct scene *scene = metal(&s, 26, 18);
	box(&s, 3.0, 3.0, 23.0, 6.4);
	struct scene_body *left = box(&s, 5.0, 6.4, 12.0, 11.4), *right = box(&s, 12.2, 6.4, 19.2, 11.4);
	left->velocity[0] = 5.0, left->velocity[1] = -3.0;
	right->velocity[0] = -5.0, right->velocity[1] = -3.0;
	elastic_scene_contact(&s, 0.2);
	struct mpm *mpm = start(scene);
	int most = 0;
	for (int k = 0; k < 60; k++) {
		steps(mpm, 20);
		const struct contact *c = mpm_work(mpm)->contact;
		for (int place = 0; place < c->n_places; place++)
			most = c->places[place].n > most ? c->places[place].n : most;
	}
	assert_int_equal(most, 3);
	assert_near(sum_momentum(mpm, 0), 0.0, 1e-12 * sum_mass(mpm) * 5.0);
	mpm_measure(mpm);
	assert_true(fabs(mpm->ledger.energy_residual) < 1e-3 * mpm->ledger.energy_kinetic);
	assert_true(body_velocity(mpm, 1, 0) < 0.0 && body_velocity(mpm, 2, 0) > 0.0);
	mpm_free(mpm);
}

/* A pool that is too small is an error with the node and the cure, not a wrong result. */
static void test_pool(void **state)
{
	(void)state;
	struct elastic_scene s;
	struct scene *scene = slider(&s, 0.0, 0.0, 0.0);
	struct mpm *mpm;
	scene->mpm.contact_fields = 5;
	assert_int_equal(mpm_create(&mpm, scene), STATUS_GUARD);
	assert_non_null(strstr(error_message(), "at the node ("));
	assert_non_null(strstr(error_message(), "mpm.contact_fields"));
}

/* A sheet one cell thick between two blocks that meet: all three fields of a node at once, and nothing comes through.
 */
static void test_thin_body(void **state)
{
	(void)state;
	struct elastic_scene s;
	struct scene *scene = metal(&s, 18, 24);
	box(&s, 5.0, 4.3, 11.0, 9.3)->velocity[1] = 10.0;
	box(&s, 5.0, 9.5, 11.0, 10.5);
	box(&s, 5.0, 10.7, 11.0, 15.7)->velocity[1] = -10.0;
	elastic_scene_contact(&s, 0.2);
	struct mpm *mpm = start(scene);
	for (int k = 0; k < 40; k++) {
		double most[3] = {-INFINITY, -INFINITY, -INFINITY}, least[3] = {INFINITY, INFINITY, INFINITY};
		steps(mpm, 20);
		for (int p = 0; p < mpm->p.n; p++) {
			int b = mpm->p.body[p];
			most[b] = fmax(most[b], mpm->p.x[p][1]), least[b] = fmin(least[b], mpm->p.x[p][1]);
		}
		assert_true(least[1] > most[0] && least[2] > most[1]);
	}
	assert_true(body_velocity(mpm, 2, 1) > 0.0 && body_velocity(mpm, 0, 1) < 0.0);
	mpm_free(mpm);
}

/* Parallel slots of 1, 2 and 3 cells between bodies that go side by side: nobody feels the other, at any place in the
 * grid, though up to two cells both reach the same nodes. */
static void test_slots(void **state)
{
	(void)state;
	for (int width = 1; width <= 3; width++) {
		struct elastic_scene s;
		struct scene *scene = metal(&s, 40, 18);
		box(&s, 3.0, 3.4, 13.0, 6.4)->velocity[0] = 30.0;
		box(&s, 3.0, 6.4 + width, 13.0, 9.4 + width)->velocity[0] = 20.0;
		elastic_scene_contact(&s, 0.5);
		struct mpm *mpm = start(scene);
		steps(mpm, 1500);
		assert_near(body_velocity(mpm, 0, 0), 30.0, 1e-11);
		assert_near(body_velocity(mpm, 1, 0), 20.0, 1e-11);
		mpm_free(mpm);
	}
}

/* Nodes with next to nothing of a body: a point's domain that reaches a row of nodes by a hair, under load. */
static void test_tiny_masses(void **state)
{
	(void)state;
	for (int k = 0; k < 3; k++) {
		struct elastic_scene s;
		struct scene *scene = metal(&s, 20, 24);
		double face = 8.0 + (k == 0 ? 1e-9 : k == 1 ? 1e-6 : 1.0 - 1e-7);
		box(&s, 5.0, face - 4.0, 12.0, face);
		box(&s, 6.0, face, 11.0, face + 4.0)->velocity[1] = -10.0;
		elastic_scene_contact(&s, 0.3);
		struct mpm *mpm = start(scene);
		for (int n = 0; n < 50; n++) {
			steps(mpm, 10);
			assert_true(fastest(mpm, 0) < 30.0 && fastest(mpm, 1) < 30.0);
		}
		assert_true(body_velocity(mpm, 1, 1) > body_velocity(mpm, 0, 1));
		mpm_free(mpm);
	}
}

/* ---- cracks ---- */

/* A bar whose halves fly apart: it breaks in the middle. */
static struct scene *breaking(struct elastic_scene *s, bool contacts)
{
	struct scene *scene = metal(s, 40, 12);
	snprintf(scene->mpm.shape, sizeof scene->mpm.shape, "cpdi");
	s->laws[0].type = SCENE_LAW_RANKINE;
	s->laws[0].rankine = (struct scene_law_rankine){
		.young = 70e9, .poisson = 0.0, .strength = 50e6, .fracture_energy = 100.0, .heat_share = 1.0, .cell = H};
	box(s, 12.0, 4.0, 28.0, 8.0);
	if (contacts) {
		struct scene_contact *own = elastic_scene_contact(s, 0.2);
		own->n_bodies = 1;
	}
	return scene;
}

static struct mpm *fly_apart(struct elastic_scene *s, bool contacts)
{
	struct mpm *mpm = start(breaking(s, contacts));
	for (int k = 0; k < mpm->p.n; k++)
		mpm->p.v[k][0] = mpm->p.x[k][0] < 20.0 * H ? -10.0 : 10.0;
	return mpm;
}

/* Of the points that began right (or left) of the middle: mean velocity, or their extreme place. */
static double half_bar(const struct mpm *mpm, bool right, bool place)
{
	double sum = 0.0, n = 0.0, end = right ? INFINITY : -INFINITY;
	for (int k = 0; k < mpm->p.n; k++) {
		double x = mpm->p.x[k][0];
		if ((mpm->p.x0[k][0] > 20.0 * H) != right)
			continue;
		sum += mpm->p.v[k][0], n += 1.0;
		end = right ? fmin(end, x) : fmax(end, x);
	}
	return place ? end : sum / n;
}

/* The halves part for good, pass no force then, and do not pass through each other when they come back. */
static void test_crack(void **state)
{
	(void)state;
	struct elastic_scene s;
	struct mpm *mpm = fly_apart(&s, true);
	steps(mpm, 1000);
	double away = half_bar(mpm, true, false);
	assert_true(away > 8.0);
	assert_near(half_bar(mpm, false, false), -away, 1e-9);
	mpm_measure(mpm);
	assert_near(mpm->ledger.loss_fracture, 4.0 * H * 100.0, 0.5 * 4.0 * H * 100.0); /* Gf times the width */
	steps(mpm, 1000);
	assert_near(half_bar(mpm, true, false), away, 1e-9);
	for (int k = 0; k < mpm->p.n; k++)
		mpm->p.v[k][0] = -mpm->p.v[k][0];
	double least = INFINITY;
	for (int k = 0; k < 40; k++) {
		steps(mpm, 100);
		least = fmin(least, half_bar(mpm, true, true) - half_bar(mpm, false, true));
	}
	assert_true(least > -0.5 * H);
	assert_true(half_bar(mpm, true, false) > 0.0);
	assert_near(sum_momentum(mpm, 0), 0.0, 1e-12 * sum_mass(mpm) * 10.0);
	mpm_free(mpm);
}

/* Sides of cracks and the memory of their gradients across a restart, between two looks at them. */
static void test_crack_same_bits(void **state)
{
	(void)state;
	struct elastic_scene s;
	struct saved whole, half;
	struct mpm *mpm = fly_apart(&s, true);
	steps(mpm, 203);
	save(mpm, &half);
	steps(mpm, 100);
	assert_true(contact_slots_used(mpm) > 0);
	save(mpm, &whole);
	mpm_free(mpm);
	mpm = start(&s.scene);
	load(mpm, &half);
	steps(mpm, 100);
	assert_same(mpm, &whole);
	mpm_free(mpm);
	discard(&half);
	discard(&whole);
}

/* ---- every scheme ---- */

/* Whatever the transfer and the order: no momentum is lost, no energy made, and the bodies part again. */
static void test_schemes(void **state)
{
	(void)state;
	static const struct {
		enum mpm_transfer transfer;
		enum mpm_order order;
		const char *shape;
	} schemes[] = {{MPM_FLIP, MPM_USF, "ugimp"},  {MPM_XPIC, MPM_MUSL, "ugimp"}, {MPM_FMPM, MPM_USL, "ugimp"},
				   {MPM_APIC, MPM_USL, "ugimp"},  {MPM_APIC, MPM_MUSL, "cpdi"},  {MPM_FLIP, MPM_USL, "cpdi"},
				   {MPM_FLIP, MPM_MUSL, "linear"}};
	for (size_t k = 0; k < sizeof schemes / sizeof *schemes; k++) {
		struct elastic_scene s;
		struct scene *scene = collision(&s, 0.2);
		scene->mpm.transfer = schemes[k].transfer, scene->mpm.order = schemes[k].order;
		snprintf(scene->mpm.shape, sizeof scene->mpm.shape, "%s", schemes[k].shape);
		struct mpm *mpm = start(scene);
		double scale = 0.0;
		for (int p = 0; p < mpm->p.n; p++)
			scale += mpm->p.mass[p] * fabs(mpm->p.v[p][0]);
		double before = sum_momentum(mpm, 0);
		steps(mpm, 1500);
		mpm_measure(mpm);
		assert_near(sum_momentum(mpm, 0), before, 1e-12 * scale);
		assert_true(body_velocity(mpm, 1, 0) > body_velocity(mpm, 0, 0));
		assert_true(fabs(mpm->ledger.energy_residual) < 0.02 * mpm->ledger.energy_kinetic);
		mpm_free(mpm);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_momentum),
		cmocka_unit_test(test_fields_add_up),
		cmocka_unit_test(test_pull_apart),
		cmocka_unit_test(test_first_touch),
		cmocka_unit_test(test_slide_without_friction),
		cmocka_unit_test(test_slide_with_friction),
		cmocka_unit_test(test_conduction),
		cmocka_unit_test(test_flush_corners),
		cmocka_unit_test(test_three_bodies),
		cmocka_unit_test(test_pool),
		cmocka_unit_test(test_thin_body),
		cmocka_unit_test(test_slots),
		cmocka_unit_test(test_tiny_masses),
		cmocka_unit_test(test_same_bits),
		cmocka_unit_test(test_crack),
		cmocka_unit_test(test_crack_same_bits),
		cmocka_unit_test(test_schemes),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
