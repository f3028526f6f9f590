/* Which nodes a wall holds, with which normals, and what it does to them. */
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

static const double H = 0.05;

/* Contacts of the node at x, y; returns how many, the first in *first. */
static int contacts_at(const struct mpm *mpm, double x, double y, int wall, struct wall_node found[8])
{
	const struct mpm_work *w = mpm_work(mpm);
	int i = (int)lround((x - mpm->grid.origin[0]) / H), j = (int)lround((y - mpm->grid.origin[1]) / H), n = 0;
	for (int e = 0; e < w->n_wall_nodes; e++)
		if (w->wall_nodes[e].node == j * mpm->grid.nx + i && w->wall_nodes[e].wall == wall && n < 8)
			found[n++] = w->wall_nodes[e];
	return n;
}

static void assert_normal(const double n[2], double x, double y)
{
	assert_near(n[0], x, 1e-12);
	assert_near(n[1], y, 1e-12);
}

/* Half a hopper, as one polygon: 45 degrees up to y = 1.4, then upright; a plate between the sides. */
static struct scene *hopper(struct elastic_scene *s)
{
	struct scene *scene = elastic_scene_init(s, 28, 44, H, 1e6, 0.2, 1000.0, 1e-4);
	scene->grid.origin[0] = -0.2, scene->grid.origin[1] = 0.2;
	const double left[] = {-0.2, 1.0, 0.4, 1.0, 0.0, 1.4, 0.0, 2.4, -0.2, 2.4};
	elastic_scene_wall(s, SCENE_WALL_POLYGON, 5, left);
	const double plate[] = {0.0, 1.85, 1.0, 1.85, 1.0, 2.05, 0.0, 2.05};
	elastic_scene_wall(s, SCENE_WALL_POLYGON, 4, plate)->velocity[1] = -0.2;
	elastic_scene_box(s, 4, 0.5, 1.0, 0.9, 1.8);
	return scene;
}

static void test_hopper_normals(void **state)
{
	(void)state;
	struct elastic_scene s;
	struct mpm *mpm;
	struct wall_node c[8];
	const double r = sqrt(0.5);
	ok(mpm_create(&mpm, hopper(&s)));
	/* the slope, and the upright side */
	assert_int_equal(contacts_at(mpm, 0.2, 1.2, 0, c), 1);
	assert_int_equal(c[0].normals, 1);
	assert_normal(c[0].normal[0], r, r);
	assert_int_equal(contacts_at(mpm, 0.0, 1.6, 0, c), 1);
	assert_normal(c[0].normal[0], 1.0, 0.0);
	/* where they meet the wall is hollow: both hold */
	assert_int_equal(contacts_at(mpm, 0.0, 1.4, 0, c), 2);
	assert_normal(c[0].normal[0], r, r);
	assert_normal(c[1].normal[0], 1.0, 0.0);
	/* the lip of the outlet is a sharp edge: only what goes against both of its faces is stopped */
	assert_int_equal(contacts_at(mpm, 0.4, 1.0, 0, c), 1);
	assert_int_equal(c[0].normals, 2);
	/* behind the plate the side is covered, below and above it is not */
	assert_int_equal(contacts_at(mpm, 0.0, 1.95, 0, c), 0);
	assert_int_equal(contacts_at(mpm, 0.0, 1.85, 0, c), 1);
	assert_normal(c[0].normal[0], 1.0, 0.0);
	/* and the plate's own sides, which the silo covers, hold nothing */
	assert_int_equal(contacts_at(mpm, 0.05, 1.85, 1, c), 1);
	assert_normal(c[0].normal[0], 0.0, -1.0);
	assert_int_equal(contacts_at(mpm, 0.0, 1.9, 1, c), 1);
	assert_normal(c[0].normal[0], 0.0, -1.0);
	/* nothing outside the solid */
	assert_int_equal(contacts_at(mpm, 0.25, 1.25, 0, c), 0);
	/* the plate moves on, and takes its nodes with it */
	for (int k = 0; k < 2600; k++)
		ok(mpm_step(mpm));
	assert_near(mpm->wall_offset[1][1], -0.2 * 0.26, 1e-12);
	walls_update(mpm);
	assert_int_equal(contacts_at(mpm, 0.5, 1.8, 1, c), 1);
	assert_int_equal(contacts_at(mpm, 0.5, 2.05, 1, c), 0);
	mpm_free(mpm);
}

/* What happens to one node: v before, what the wall makes of it. */
static void assert_contact(struct mpm *mpm, double x, double y, double vx, double vy, double ux, double uy)
{
	int i = (int)lround((x - mpm->grid.origin[0]) / H), j = (int)lround((y - mpm->grid.origin[1]) / H);
	int node = j * mpm->grid.nx + i;
	mpm->grid.mass[node] = 1.0;
	mpm->grid.v_new[node][0] = vx, mpm->grid.v_new[node][1] = vy;
	walls_apply(mpm);
	assert_near(mpm->grid.v_new[node][0], ux, 1e-12);
	assert_near(mpm->grid.v_new[node][1], uy, 1e-12);
	mpm->grid.mass[node] = 0.0;
}

static void test_contact(void **state)
{
	(void)state;
	struct elastic_scene s;
	struct mpm *mpm;
	struct scene *scene = hopper(&s);
	ok(mpm_create(&mpm, scene));
	/* smooth: the normal part is removed, the tangent stays; what leaves is free */
	assert_contact(mpm, 0.2, 1.2, 0.0, -1.0, 0.5, -0.5);
	assert_contact(mpm, 0.2, 1.2, 0.3, 0.1, 0.3, 0.1);
	/* the lip: past it down, under it to the left, but not into it */
	assert_contact(mpm, 0.4, 1.0, 0.0, -1.0, 0.0, -1.0);
	assert_contact(mpm, 0.4, 1.0, -1.0, -0.5, -1.0, -0.5);
	assert_contact(mpm, 0.4, 1.0, -1.0, 0.2, -1.0, 0.0);
	/* the hollow corner holds against both */
	assert_contact(mpm, 0.0, 1.4, -1.0, -1.0, 0.0, 0.0);
	/* the plate: unilateral against its own velocity */
	assert_contact(mpm, 0.5, 1.85, 0.3, 0.0, 0.3, -0.2);
	assert_contact(mpm, 0.5, 1.85, 0.3, -0.5, 0.3, -0.5);
	/* friction takes at most mu times what the normal takes, never more than there is */
	s.walls[0].friction = 0.5;
	assert_contact(mpm, 0.0, 1.6, -0.2, -1.0, 0.0, -0.9);
	assert_contact(mpm, 0.0, 1.6, -2.0, -0.8, 0.0, 0.0);
	s.walls[0].contact = SCENE_WALL_SLIP;
	assert_contact(mpm, 0.0, 1.6, 0.7, -1.0, 0.0, -1.0);
	s.walls[0].contact = SCENE_WALL_STICK;
	assert_contact(mpm, 0.0, 1.6, 0.7, -1.0, 0.0, 0.0);
	mpm_free(mpm);
}

/* A strip of the given depth behind a line, over its length; on and off at their times. */
static void test_line_and_times(void **state)
{
	(void)state;
	struct elastic_scene s;
	struct mpm *mpm;
	struct wall_node c[8];
	struct scene *scene = elastic_scene_init(&s, 20, 20, H, 1e6, 0.2, 1000.0, 1e-4);
	elastic_scene_box(&s, 4, 0.4, 0.6, 0.6, 0.8);
	struct scene_wall *line = elastic_scene_line(&s, 0.2, 0.3, 0.7, 0.3); /* solid on the right: below */
	line->from = 0.001, line->until = 0.002;
	ok(mpm_create(&mpm, scene));
	assert_int_equal(contacts_at(mpm, 0.4, 0.3, 0, c), 0);
	for (int k = 0; k < 11; k++)
		ok(mpm_step(mpm));
	assert_int_equal(contacts_at(mpm, 0.4, 0.3, 0, c), 1);
	assert_normal(c[0].normal[0], 0.0, 1.0);
	assert_int_equal(contacts_at(mpm, 0.7, 0.2, 0, c), 1);
	assert_int_equal(contacts_at(mpm, 0.75, 0.3, 0, c), 0);
	assert_int_equal(contacts_at(mpm, 0.4, 0.15, 0, c), 0);
	assert_int_equal(contacts_at(mpm, 0.4, 0.35, 0, c), 0);
	for (int k = 0; k < 10; k++)
		ok(mpm_step(mpm));
	assert_int_equal(contacts_at(mpm, 0.4, 0.3, 0, c), 0);
	mpm_free(mpm);
}

/* A plate compresses a bar by a fifth, past four rows of nodes.  The grid that follows it stays with its face, and the
 * plate feels the Hencky stress of uniaxial strain all the way: E ln(l)/l with nu = 0.  A grid that stays behind
 * loses most of that force whenever the face has left a row. */
static double worst_plate_force(bool follows, double speed)
{
	enum { PERIOD = 128 }; /* steps in which a wave runs along the bar and back: means over it are quasi-static */
	struct elastic_scene s;
	const double young = 1e6, length = 1.0;
	struct scene *scene = elastic_scene_init(&s, 8, 26, H, young, 0.0, 1000.0, 5e-4);
	scene->mpm.pic_fraction = 0.05;
	scene->guards.energy_residual = 0.02;
	elastic_scene_box(&s, 4, 0.15, 0.1, 0.25, 0.1 + length);
	const double base[] = {0.0, 0.0, 0.4, 0.0, 0.4, 0.1, 0.0, 0.1};
	const double plate[] = {0.0, 1.1, 0.4, 1.1, 0.4, 1.2, 0.0, 1.2};
	elastic_scene_wall(&s, SCENE_WALL_POLYGON, 4, base)->contact = SCENE_WALL_SLIP;
	struct scene_wall *moving = elastic_scene_wall(&s, SCENE_WALL_POLYGON, 4, plate);
	moving->contact = SCENE_WALL_SLIP, moving->velocity[1] = -speed;
	scene->grid.follows = follows, scene->grid.follow = 1, scene->grid.fixed[1] = 0.1;
	struct mpm *mpm;
	ok(mpm_create(&mpm, scene));
	double worst = 0.0, mean = 0.0;
	for (int k = 1; k <= 12 * PERIOD; k++) {
		ok(mpm_step(mpm));
		mean += mpm->walls[1].force[1] / PERIOD;
		if (k % PERIOD)
			continue;
		double stretch = 1.0 - speed * (mpm->time - 0.5 * PERIOD * mpm->dt) / length,
			   exact = -young * log(stretch) / stretch * 0.1;
		if (k > 2 * PERIOD)
			worst = fmax(worst, fabs(mean / exact - 1.0));
		mean = 0.0;
	}
	mpm_free(mpm);
	return worst;
}

static void test_grid_follows(void **state)
{
	(void)state;
	double with = worst_plate_force(true, 0.25), without = worst_plate_force(false, 0.25);
	print_message("plate force off by %.2g %% at most on a grid that follows, %.2g %% on one that stays\n",
				  100.0 * with, 100.0 * without);
	assert_true(with < 0.02);
	assert_true(without > 0.1);
	/* pulled out of the box that the scene has at the start, which the grid takes along */
	with = worst_plate_force(true, -0.4);
	print_message("%.2g %% where the plate is pulled\n", 100.0 * with);
	assert_true(with < 0.03);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_hopper_normals),
		cmocka_unit_test(test_contact),
		cmocka_unit_test(test_line_and_times),
		cmocka_unit_test(test_grid_follows),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
