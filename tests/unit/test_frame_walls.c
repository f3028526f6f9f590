/* The walls of a frame: outlines, and the pressure along them, which adds up to the force on each wall and is that of
 * the material's weight. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "../common/elastic_scene.h"
#include "../common/near.h"
#include "mpm/mpm.h"
#include "run/frame_walls.h"

static const double H = 0.1, DENSITY = 1000.0, HEIGHT = 0.6, WIDTH = 0.8;

/* A block, 0.8 wide and 0.6 high, on a floor (a polygon) between two upright walls that it touches. */
static struct scene *block(struct elastic_scene *s)
{
	struct scene *scene = elastic_scene_init(s, 12, 12, H, 1e6, 0.3, DENSITY, 2e-4);
	const double floor[] = {0.0, 0.0, 1.2, 0.0, 1.2, 0.2, 0.0, 0.2}, left[] = {0.2, 1.0, 0.2, 0.2},
				 right[] = {1.0, 0.2, 1.0, 1.0};
	elastic_scene_wall(s, SCENE_WALL_POLYGON, 4, floor);
	elastic_scene_wall(s, SCENE_WALL_LINE, 2, left)->contact = SCENE_WALL_SLIP;
	elastic_scene_wall(s, SCENE_WALL_LINE, 2, right)->contact = SCENE_WALL_SLIP;
	elastic_scene_box(s, 4, 0.2, 0.2, 1.0, 0.8);
	scene->gravity[1] = -9.8;
	scene->mpm.damping_particle = 20.0;
	return scene;
}

struct walls {
	const void *frame;
	int channel;
	const int32_t *offsets, *wall;
	const double *force, *x, *pressure, *shear;
};

static const void *array(const struct walls *w, const char *name)
{
	const struct frame_array *found = frame_find_array(w->frame, w->channel, name);
	assert_non_null(found);
	return frame_data(w->frame, found);
}

static struct walls look(struct frame_builder *builder, const struct mpm *mpm)
{
	struct walls w;
	int64_t bytes;
	frame_begin(builder, mpm->step, mpm->time, "", "C");
	ok(frame_walls_add(builder, mpm));
	w.frame = frame_finish(builder, &bytes);
	assert_non_null(w.frame);
	w.channel = frame_find_channel(w.frame, "walls");
	w.offsets = array(&w, "offsets"), w.wall = array(&w, "wall"), w.force = array(&w, "force");
	w.x = array(&w, "coordinates"), w.pressure = array(&w, "pressure"), w.shear = array(&w, "shear");
	return w;
}

/* Integral of the pressure times the normal, and of the shear times the tangent, along an outline: N, per metre of
 * thickness.  `side` = +1 if the material is on the right of the outline (a polygon's), -1 if on its left. */
static void integrate(const struct walls *w, int cell, double side, double sum[2])
{
	sum[0] = sum[1] = 0;
	for (int p = w->offsets[cell]; p + 1 < w->offsets[cell + 1]; p++) {
		double tx = w->x[3 * (p + 1)] - w->x[3 * p], ty = w->x[3 * (p + 1) + 1] - w->x[3 * p + 1];
		double pressure = 0.5 * (w->pressure[p] + w->pressure[p + 1]), shear = 0.5 * (w->shear[p] + w->shear[p + 1]);
		sum[0] += -side * pressure * ty + shear * tx;
		sum[1] += side * pressure * tx + shear * ty;
	}
}

static void test_pressure(void **state)
{
	(void)state;
	struct elastic_scene s;
	struct mpm *mpm;
	ok(mpm_create(&mpm, block(&s)));
	struct frame_builder *builder = frame_builder_create();
	struct walls w = look(builder, mpm);
	for (int p = 0; p < w.offsets[3]; p++)
		assert_true(w.pressure[p] == 0 && w.shear[p] == 0); /* nothing has happened yet */
	for (int k = 0; k < 4000; k++)
		ok(mpm_step(mpm));
	w = look(builder, mpm);

	/* pieces of a cell each; a polygon ends where it begins */
	assert_int_equal(w.offsets[1], 12 + 2 + 12 + 2 + 1);
	assert_int_equal(w.offsets[2] - w.offsets[1], 8 + 1);
	assert_true(w.x[0] == w.x[3 * 28] && w.x[1] == w.x[3 * 28 + 1]);
	assert_true(w.pressure[0] == w.pressure[28]);

	/* what stands on each wall */
	const double side[] = {1, -1, -1};
	for (int cell = 0; cell < 3; cell++) {
		double sum[2];
		integrate(&w, cell, side[cell], sum);
		for (int c = 0; c < 2; c++)
			assert_near(sum[c], w.force[3 * cell + c], 1e-9 * DENSITY * 9.8);
	}
	assert_near(w.force[1], -DENSITY * 9.8 * HEIGHT * WIDTH, 0.02 * DENSITY * 9.8 * HEIGHT * WIDTH);

	/* in the middle of the floor: the weight of what stands above */
	for (int p = 0; p < w.offsets[1]; p++)
		if (w.x[3 * p + 1] == 0.2 && fabs(w.x[3 * p] - 0.6) < 0.25)
			assert_near(w.pressure[p], DENSITY * 9.8 * HEIGHT, 0.1 * DENSITY * 9.8 * HEIGHT);
	/* none where there is no material, under the floor and above the block */
	for (int p = 0; p < w.offsets[1]; p++)
		if (w.x[3 * p + 1] < 0.1)
			assert_true(w.pressure[p] == 0);
	for (int p = w.offsets[1]; p < w.offsets[3]; p++)
		if (w.x[3 * p + 1] > 0.95)
			assert_true(w.pressure[p] == 0);
	frame_builder_free(builder);
	mpm_free(mpm);
}

int main(void)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(test_pressure)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
