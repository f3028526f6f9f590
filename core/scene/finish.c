/* Defaults that depend on other values. */
#include <math.h>
#include <string.h>

#include "scene/geometry.h"
#include "scene/private.h"

static const double ROOM_TEMPERATURE = 293.15, FREEZING_TEMPERATURE = 273.15; /* K */

static double otherwise(double value, double fallback) { return isnan(value) ? fallback : value; }

/* Without a word about it, heat is on if the scene says anything that only makes sense with heat. */
static bool needs_heat(const struct scene *scene)
{
	bool needs = false;
	for (int k = 0; k < scene->n_materials; k++)
		needs |= !isnan(scene->materials[k].heat_capacity);
	for (int k = 0; k < scene->n_walls; k++)
		needs |= scene->walls[k].active && (scene_wall_heats(&scene->walls[k]) || scene->walls[k].heat_share > 0.0);
	for (int k = 0; k < scene->n_boundaries; k++)
		needs |=
			scene_boundary_heats_nodes(&scene->boundaries[k]) || scene_boundary_heats_points(&scene->boundaries[k]);
	return needs;
}

/* Puts a shape where it stays, counter-clockwise. */
static void turn_shape(const struct scene_body *body, struct scene_body *shape)
{
	for (int j = 0; j < shape->n_vertices; j++)
		scene_body_turn(body, 1.0, shape->vertices[j]);
	scene_body_turn(body, 1.0, shape->centre);
	polygon_orient(shape->n_vertices, shape->vertices);
}

/* Grey values become the region, and its extent stands for its outline. */
static void finish_mask(struct loader *loader, struct scene_body *body)
{
	struct scene_mask *mask = &body->mask;
	int low[2] = {mask->nx, mask->ny}, high[2] = {0, 0};
	if (!mask->inside || !(mask->pixel > 0.0) || body->n_vertices > 0)
		return;
	for (int j = 0; j < mask->ny; j++)
		for (int i = 0; i < mask->nx; i++) {
			unsigned char *pixel = &mask->inside[(size_t)j * (size_t)mask->nx + (size_t)i];
			*pixel = *pixel >= mask->level[0] && *pixel <= mask->level[1];
			if (*pixel) {
				low[0] = i < low[0] ? i : low[0], low[1] = j < low[1] ? j : low[1];
				high[0] = i >= high[0] ? i + 1 : high[0], high[1] = j >= high[1] ? j + 1 : high[1];
			}
		}
	if (high[0] == 0)
		return;
	body->n_vertices = 4;
	body->vertices = scene_alloc(loader, 4 * sizeof *body->vertices);
	for (int k = 0; k < 4; k++) {
		body->vertices[k][0] = mask->origin[0] + mask->pixel * (k == 1 || k == 2 ? high[0] : low[0]);
		body->vertices[k][1] = mask->origin[1] + mask->pixel * (k >= 2 ? high[1] : low[1]);
	}
}

static void finish_bodies(struct loader *loader, const struct node *bodies)
{
	struct scene *scene = loader->scene;
	for (int k = 0; k < scene->n_bodies; k++) {
		struct scene_body *body = &scene->bodies[k];
		body->temperature = otherwise(body->temperature, ROOM_TEMPERATURE);
		body->angle *= M_PI / 180.0;
		body->drives = !isnan(body->drive[0]);
		finish_mask(loader, body);
		turn_shape(body, body);
		for (int j = 0; j < body->n_cuts; j++)
			turn_shape(body, &body->cuts[j]);
		for (int a = 0; a < 2; a++) {
			double low = INFINITY;
			for (int j = 0; j < body->n_vertices; j++)
				low = fmin(low, body->vertices[j][a]);
			body->temperature_at[a] = otherwise(body->temperature_at[a], low);
		}
		const struct node *layers = k < bodies->n ? node_find(bodies->children[k], "layers") : NULL;
		for (int j = 0; layers && j < body->n_layers; j++) {
			struct scene_layer *layer = &body->layers[j];
			layer->temperature = otherwise(layer->temperature, body->temperature);
			if (!node_find(layers->children[j], "material"))
				layer->material = body->material;
		}
	}
}

static void finish_materials(struct scene *scene, const struct node *materials)
{
	for (int k = 0; k < scene->n_materials; k++) {
		struct scene_material *material = &scene->materials[k];
		if (!node_find(materials->children[k], "freezing"))
			material->freezing[0] = material->freezing[1] = NAN;
		material->latent_heat = otherwise(material->latent_heat, 0.0);
		material->heat_capacity_frozen = otherwise(material->heat_capacity_frozen, material->heat_capacity);
	}
}

static void finish_contacts(struct scene *scene, const struct node *contacts)
{
	for (int k = 0; k < scene->n_contacts; k++)
		if (!node_find(contacts->children[k], "softening"))
			scene->contacts[k].softening[0] = scene->contacts[k].softening[1] = NAN;
}

static void finish_walls(struct scene *scene)
{
	for (int k = 0; k < scene->n_walls; k++) {
		struct scene_wall *wall = &scene->walls[k];
		wall->depth = otherwise(wall->depth, 2.0 * scene->grid.cell);
		wall->until = otherwise(wall->until, INFINITY);
		if (wall->shape == SCENE_WALL_POLYGON)
			polygon_orient(wall->n_vertices, wall->vertices);
	}
	for (int k = 0; k < scene->n_boundaries; k++) {
		struct scene_boundary *boundary = &scene->boundaries[k];
		boundary->layer = otherwise(boundary->layer, scene->grid.cell);
		boundary->until = otherwise(boundary->until, INFINITY);
	}
}

static void finish_output(struct scene *scene)
{
	struct scene_output *output = &scene->output;
	double end = scene->time.end;
	output->history_every = otherwise(output->history_every, end / 200.0);
	output->snapshot_every = otherwise(output->snapshot_every, end / 20.0);
	output->checkpoint_every = otherwise(output->checkpoint_every, end / 10.0);
	double pictures = output->snapshot_every > 0.0 ? output->snapshot_every : end / 20.0;
	scene->catalyst.every = otherwise(scene->catalyst.every, pictures);
	for (int k = 0; k < scene->n_images; k++) {
		struct scene_image *image = &scene->images[k];
		image->every = otherwise(image->every, pictures);
		for (int a = 0; a < 2 && image->kind == SCENE_IMAGE_POINTS; a++) {
			image->view[a] = otherwise(image->view[a], scene->grid.origin[a]);
			image->view[a + 2] = otherwise(image->view[a + 2], scene->grid.origin[a] + scene->grid.size[a]);
		}
	}
}

static void finish_rve(struct scene_law_rve *rve)
{
	if (!strcmp(rve->packing.lattice, "random"))
		rve->packing.lattice[0] = '\0';
	rve->bonds.melting = otherwise(rve->bonds.melting, INFINITY);
	rve->bonds.reference = otherwise(rve->bonds.reference, FREEZING_TEMPERATURE);
}

void finish_scene(struct loader *loader)
{
	struct scene *scene = loader->scene;
	const struct node *thermal = node_find(loader->root, "thermal"), *stages = node_find(loader->root, "stages");
	if (!thermal || !node_find(thermal, "on"))
		scene->thermal.on = needs_heat(scene);
	for (int k = 0; k < scene->n_laws; k++)
		finish_rve(&scene->laws[k].rve), scene->laws[k].rve.step_guard = scene->guards.dem_step,
										 scene->laws[k].rankine.cell = scene->grid.cell;
	if (scene->n_materials)
		finish_materials(scene, node_find(loader->root, "materials"));
	if (scene->n_bodies)
		finish_bodies(loader, node_find(loader->root, "bodies"));
	finish_walls(scene);
	if (scene->n_contacts)
		finish_contacts(scene, node_find(loader->root, "contacts"));
	for (int a = 0; a < 2; a++)
		scene->grid.fixed[a] = otherwise(scene->grid.fixed[a], scene->grid.origin[a]);
	for (int k = 0; k < scene->n_stages; k++) {
		scene->stages[k].duration = otherwise(scene->stages[k].duration, INFINITY);
		if (!node_find(stages->children[k], "walls"))
			scene->stages[k].n_walls = -1;
	}
	for (int k = 0; k < scene->n_cracks; k++)
		scene->cracks[k].reach = otherwise(scene->cracks[k].reach, 3.0 * scene->grid.cell);
	finish_output(scene);
}
