/* Scenes for the tests of the MPM, put together in memory: one thermoelastic law and material, boxes, walls. */
#ifndef TESTS_COMMON_ELASTIC_SCENE_H
#define TESTS_COMMON_ELASTIC_SCENE_H

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "mpm/mpm.h"
#include "scene/scene.h"

enum { ELASTIC_MOST = 8 };

struct elastic_scene {
	struct scene scene;
	struct scene_law laws[2];
	struct scene_material materials[2];
	struct scene_body bodies[ELASTIC_MOST];
	struct scene_wall walls[ELASTIC_MOST];
	struct scene_boundary boundaries[ELASTIC_MOST];
	struct scene_stage stages[ELASTIC_MOST];
	struct scene_contact contacts[ELASTIC_MOST];
	double vertices[2 * ELASTIC_MOST][8][2];
	int n_polygons;
};

/* A grid of cells_x by cells_y cells of size h from the origin; E, nu, rho; no gravity, no heat. */
static inline struct scene *elastic_scene_init(struct elastic_scene *s, int cells_x, int cells_y, double h,
											   double young, double poisson, double density, double step)
{
	memset(s, 0, sizeof *s);
	struct scene *scene = &s->scene;
	snprintf(scene->path, sizeof scene->path, "test.cfg");
	scene->grid = (struct scene_grid){.size = {cells_x * h, cells_y * h}, .cell = h, .thickness = 1.0};
	scene->time =
		(struct scene_time){.end = 1.0, .step = step, .step_factor = 1.0, .thermal_steps = 1, .thermal_every = 1};
	snprintf(scene->mpm.shape, sizeof scene->mpm.shape, "ugimp");
	scene->mpm.xpic_order = 2, scene->mpm.xpic_every = 1;
	scene->thermal.friction_heat = true;
	scene->thermal.time_scale = 1.0;
	scene->guards = (struct scene_guards){
		.points_leaving = true, .time_step = true, .thermal_step = true, .numerical_fracture = true};
	scene->laws = s->laws, scene->n_laws = 1;
	scene->materials = s->materials, scene->n_materials = 1;
	scene->bodies = s->bodies, scene->walls = s->walls, scene->boundaries = s->boundaries, scene->stages = s->stages;
	scene->contacts = s->contacts;
	for (int k = 0; k < 2; k++) {
		snprintf(s->laws[k].name, sizeof s->laws[k].name, "elastic%d", k);
		s->laws[k].type = SCENE_LAW_THERMOELASTIC;
		s->laws[k].thermoelastic = (struct scene_law_thermoelastic){.young = young, .poisson = poisson};
		snprintf(s->materials[k].name, sizeof s->materials[k].name, "stuff%d", k);
		s->materials[k] = (struct scene_material){.law = k,
												  .density = density,
												  .heat_capacity = 1.0,
												  .conductivity = 0.0,
												  .reference_temperature = NAN,
												  .freezing = {NAN, NAN},
												  .heat_capacity_frozen = 1.0,
												  .conductivity_frozen = NAN};
	}
	return scene;
}

/* A polygon of n corners x0, y0, x1, y1 ... */
static inline double (*elastic_scene_polygon(struct elastic_scene *s, int n, const double *corners))[2]
{
	double(*v)[2] = s->vertices[s->n_polygons++];
	memcpy(v, corners, (size_t)n * sizeof *v);
	return v;
}

static inline struct scene_body *elastic_scene_body(struct elastic_scene *s, int points_per_cell, int n,
													const double *corners)
{
	struct scene_body *body = &s->bodies[s->scene.n_bodies++];
	*body = (struct scene_body){.n_vertices = n,
								.vertices = elastic_scene_polygon(s, n, corners),
								.lattice_origin = {NAN, NAN},
								.points_per_cell = points_per_cell,
								.temperature = 293.15,
								.variants = 1};
	snprintf(body->name, sizeof body->name, "body%d", s->scene.n_bodies);
	return body;
}

static inline struct scene_body *elastic_scene_box(struct elastic_scene *s, int points_per_cell, double x0, double y0,
												   double x1, double y1)
{
	const double corners[] = {x0, y0, x1, y0, x1, y1, x0, y1};
	return elastic_scene_body(s, points_per_cell, 4, corners);
}

static inline struct scene_wall *elastic_scene_wall(struct elastic_scene *s, enum scene_wall_shape shape, int n,
													const double *corners)
{
	struct scene_wall *wall = &s->walls[s->scene.n_walls++];
	*wall = (struct scene_wall){.shape = shape,
								.n_vertices = n,
								.vertices = elastic_scene_polygon(s, n, corners),
								.depth = 2.0 * s->scene.grid.cell,
								.temperature = NAN,
								.until = INFINITY};
	snprintf(wall->name, sizeof wall->name, "wall%d", s->scene.n_walls);
	return wall;
}

/* The solid lies on the right of first -> second. */
static inline struct scene_wall *elastic_scene_line(struct elastic_scene *s, double x0, double y0, double x1, double y1)
{
	const double ends[] = {x0, y0, x1, y1};
	return elastic_scene_wall(s, SCENE_WALL_LINE, 2, ends);
}

static inline struct scene_boundary *elastic_scene_boundary(struct elastic_scene *s, double x0, double y0, double x1,
															double y1)
{
	struct scene_boundary *b = &s->boundaries[s->scene.n_boundaries++];
	*b = (struct scene_boundary){.min = {x0, y0},
								 .max = {x1, y1},
								 .velocity = {NAN, NAN},
								 .traction = {NAN, NAN},
								 .temperature = NAN,
								 .flux = NAN,
								 .convection = {.coefficient = NAN, .ambient = NAN},
								 .layer = s->scene.grid.cell,
								 .until = INFINITY};
	return b;
}

/* Between all bodies, until it is told which. */
static inline struct scene_contact *elastic_scene_contact(struct elastic_scene *s, double friction)
{
	struct scene_contact *contact = &s->contacts[s->scene.n_contacts++];
	*contact = (struct scene_contact){.friction = friction,
									  .softening = {NAN, NAN},
									  .heat_share = 1.0,
									  .conductance_pressure = 1.0,
									  .conductance_exponent = 1.0};
	return contact;
}

static inline void elastic_scene_heat(struct elastic_scene *s, double expansion, double heat_capacity,
									  double conductivity)
{
	s->scene.thermal.on = true;
	for (int k = 0; k < 2; k++) {
		s->laws[k].thermoelastic.expansion = expansion;
		s->materials[k].heat_capacity = s->materials[k].heat_capacity_frozen = heat_capacity;
		s->materials[k].conductivity = conductivity;
	}
}

static inline double sum_mass(const struct mpm *mpm)
{
	double sum = 0.0;
	for (int k = 0; k < mpm->p.n; k++)
		sum += mpm->p.mass[k];
	return sum;
}

static inline double sum_nodal_mass(const struct mpm *mpm)
{
	double sum = 0.0;
	for (int k = 0; k < mpm->grid.nx * mpm->grid.ny; k++)
		sum += mpm->grid.mass[k];
	return sum;
}

static inline double sum_momentum(const struct mpm *mpm, int c)
{
	double sum = 0.0;
	for (int k = 0; k < mpm->p.n; k++)
		sum += mpm->p.mass[k] * mpm->p.v[k][c];
	return sum;
}

static inline double mean_position(const struct mpm *mpm, int c)
{
	double sum = 0.0;
	for (int k = 0; k < mpm->p.n; k++)
		sum += mpm->p.mass[k] * mpm->p.x[k][c];
	return sum / sum_mass(mpm);
}

/* ---- runs (after <cmocka.h>) ---- */

static inline void ok(int status)
{
	if (status != STATUS_OK)
		print_error("status %d: %s\n", status, error_message());
	assert_int_equal(status, STATUS_OK);
}

static inline struct mpm *start(const struct scene *scene)
{
	struct mpm *mpm;
	ok(mpm_create(&mpm, scene));
	return mpm;
}

static inline void steps(struct mpm *mpm, int n)
{
	for (int k = 0; k < n; k++)
		ok(mpm_step(mpm));
}

#endif
