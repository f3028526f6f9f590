/* Readers of the values that are more than a number or a word; see keys.c. */
#include "scene/custom.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/error.h"
#include "scene/geometry.h"
#include "scene/private.h"

static bool is_string(struct loader *loader, const struct scene_key *key, const struct node *node, const char *path)
{
	if (node->type == NODE_STRING)
		return true;
	problem_at(loader, node->place, path, "is %s, expected %s", node_kind(node), key->expected);
	return false;
}

/* ---- laws and materials ---- */

/* Seen from the file in which it stands; from the working directory on the command line.  The tree keeps the
 * absolute path, so that the scene's text means the same wherever it is stored. */
void read_packing_file(struct loader *loader, const struct scene_key *key, struct node *node, void *target,
					   const char *path)
{
	struct scene_packing *packing = target;
	char absolute[PATH_MAX];
	if (!is_string(loader, key, node, path))
		return;
	const char *dot = strrchr(node->string, '.');
	if (!dot || (strcmp(dot, ".h5") && strcmp(dot, ".csv"))) {
		problem_at(loader, node->place, path, "is \"%s\", expected %s", node->string, key->expected);
		return;
	}
	const char *seen = node->place.line > 0 ? path_beside(loader, node->place.file, node->string) : node->string;
	if (!realpath(seen, absolute) || access(absolute, R_OK)) {
		problem_at(loader, node->place, path, "'%s' cannot be read, expected a packing", seen);
		return;
	}
	if (strlen(absolute) >= sizeof packing->file) {
		problem_at(loader, node->place, path, "'%s' is too long a path, expected at most %zu characters", absolute,
				   sizeof packing->file - 1);
		return;
	}
	memcpy(packing->file, absolute, strlen(absolute) + 1);
	node->string = loader_string(loader, absolute);
}

/* A law in braces joins the scene's laws, behind those of the list; it is called like its material. */
static int append_law(struct loader *loader, const struct scene_key *key, struct node *node, const char *material,
					  const char *path)
{
	struct scene *scene = loader->scene;
	struct scene_law *laws = scene_alloc(loader, (size_t)(scene->n_laws + 1) * sizeof *laws),
					 *law = &laws[scene->n_laws];
	if (scene->n_laws)
		memcpy(laws, scene->laws, (size_t)scene->n_laws * sizeof *laws);
	scene->laws = laws;
	law->place = node->place;
	const struct scene_key *keys = tables_choose(key->tables, node);
	if (keys) {
		read_group(loader, keys, node, law, path);
	} else {
		const struct node *type = node_find(node, "type");
		problem_at(loader, type ? type->place : node->place, path,
				   type ? "has a type that is not known, expected \"%s\", \"%s\" or \"%s\""
						: "has no type, expected \"%s\", \"%s\" or \"%s\"",
				   scene_law_type_names[0], scene_law_type_names[1], scene_law_type_names[2]);
	}
	if (!law->name[0])
		snprintf(law->name, sizeof law->name, "%s", material);
	return scene->n_laws++;
}

void read_material_law(struct loader *loader, const struct scene_key *key, struct node *node, void *target,
					   const char *path)
{
	struct scene_material *material = target;
	material->law = -1;
	if (node->type == NODE_GROUP)
		material->law = append_law(loader, key, node, material->name, path);
	else if (is_string(loader, key, node, path))
		material->law = read_reference(loader, node, "laws", path);
}

void read_material_name(struct loader *loader, const struct scene_key *key, struct node *node, void *target,
						const char *path)
{
	int *material = (int *)((char *)target + key->offset);
	*material = -1;
	if (is_string(loader, key, node, path))
		*material = read_reference(loader, node, "materials", path);
}

/* A temperature that stands in a row or a pair; false (recorded) below absolute zero. */
static bool to_kelvin(struct loader *loader, struct node *node, double *value, const char *path)
{
	double given = *value;
	*value = temperature_in(loader, given);
	if (*value >= 0.0)
		return true;
	problem_at(loader, node->place, path, "holds %.10g, below absolute zero, expected at least %s", given,
			   loader->scene->units.celsius ? "-273.15 C" : "0 K");
	return false;
}

/* Two temperatures, K; false (recorded) if they are none. */
static bool read_temperatures(struct loader *loader, const struct scene_key *key, struct node *node, double between[2],
							  const char *path)
{
	if (!read_numbers(loader, key, node, 2, between, path))
		return false;
	for (int k = 0; k < 2; k++)
		if (!to_kelvin(loader, node, &between[k], path))
			return false;
	return true;
}

void read_softening(struct loader *loader, const struct scene_key *key, struct node *node, void *target,
					const char *path)
{
	double given[2];
	if (!read_temperatures(loader, key, node, given, path))
		return;
	if (!(given[0] < given[1]))
		problem_at(loader, node->place, path, "does not rise, expected %s", key->expected);
	memcpy((char *)target + key->offset, given, sizeof given);
}

void read_freezing(struct loader *loader, const struct scene_key *key, struct node *node, void *target,
				   const char *path)
{
	double *between = (double *)((char *)target + key->offset);
	double given[2];
	if (!read_temperatures(loader, key, node, given, path))
		return;
	if (given[0] > given[1])
		problem_at(loader, node->place, path, "falls, expected %s", key->expected);
	memcpy(between, given, sizeof given);
}

void read_series(struct loader *loader, const struct scene_key *key, struct node *node, void *target, const char *path)
{
	struct scene_series *series = (struct scene_series *)((char *)target + key->offset);
	struct scene_key row = *key;
	row.unit = NULL; /* of the value, not of the time */
	series->n = read_points(loader, &row, node, &series->rows, path);
	if (node->type == NODE_LIST && node->n < 2)
		problem_at(loader, node->place, path, "has %d row%s, expected %s", node->n, node->n == 1 ? "" : "s",
				   key->expected);
	for (int k = 1; k < series->n; k++)
		if (!(series->rows[k][0] > series->rows[k - 1][0])) {
			problem_at(loader, node->children[k]->place, path, "goes from %g s to %g s, expected %s",
					   series->rows[k - 1][0], series->rows[k][0], key->expected);
			return;
		}
}

void read_temperature_series(struct loader *loader, const struct scene_key *key, struct node *node, void *target,
							 const char *path)
{
	struct scene_series *series = (struct scene_series *)((char *)target + key->offset);
	read_series(loader, key, node, target, path);
	for (int k = 0; k < series->n; k++)
		if (!to_kelvin(loader, node->children[k], &series->rows[k][1], path))
			return;
}

/* ---- shapes ---- */

static bool read_corners(struct loader *loader, const struct scene_key *key, struct node *node, double low[2],
						 double high[2], const char *path)
{
	double v[4];
	if (!read_numbers(loader, key, node, 4, v, path))
		return false;
	for (int a = 0; a < 2; a++) {
		low[a] = v[a], high[a] = v[a + 2];
		if (low[a] > high[a]) {
			problem_at(loader, node->place, path, "has %cmin = %g > %cmax = %g, expected %s", "xy"[a], low[a], "xy"[a],
					   high[a], key -> expected);
			return false;
		}
	}
	return true;
}

/* The polygon that a key `box`, `polygon` or `wedge` means; its number of corners, 0 on a problem. */
static int read_polygon(struct loader *loader, const struct scene_key *key, struct node *node, double (**vertices)[2],
						const char *path)
{
	double low[2], high[2], leg[4];
	if (!strcmp(key->name, "polygon"))
		return read_points(loader, key, node, vertices, path);
	double(*v)[2] = scene_alloc(loader, 4 * sizeof *v);
	*vertices = v;
	if (!strcmp(key->name, "box")) {
		if (!read_corners(loader, key, node, low, high, path))
			return 0;
		v[0][0] = v[3][0] = low[0], v[1][0] = v[2][0] = high[0];
		v[0][1] = v[1][1] = low[1], v[2][1] = v[3][1] = high[1];
		return 4;
	}
	if (!read_numbers(loader, key, node, 4, leg, path))
		return 0;
	for (int k = 0; k < 3; k++)
		v[k][0] = leg[0] + (k == 1 ? leg[2] : 0.0), v[k][1] = leg[1] + (k == 2 ? leg[3] : 0.0);
	return 3;
}

void read_body_shape(struct loader *loader, const struct scene_key *key, struct node *node, void *target,
					 const char *path)
{
	struct scene_body *body = target;
	if (body->n_vertices)
		problem_at(loader, node->place, path, "is a second shape of this body, expected one");
	body->n_vertices = read_polygon(loader, key, node, &body->vertices, path);
}

/* Corners for what only needs an outline: a multiple of four, so that the extent is exact. */
enum { CIRCLE_CORNERS = 64 };

void read_body_circle(struct loader *loader, const struct scene_key *key, struct node *node, void *target,
					  const char *path)
{
	struct scene_body *body = target;
	bool ring = !strcmp(key->name, "ring");
	double v[4] = {0.0};
	if (body->n_vertices)
		problem_at(loader, node->place, path, "is a second shape of this body, expected one");
	if (!read_numbers(loader, key, node, ring ? 4 : 3, v, path))
		return;
	double outer = ring ? v[3] : v[2], inner = ring ? v[2] : 0.0;
	if (ring && !(inner > 0.0 && outer > inner)) {
		problem_at(loader, node->place, path, "has radii %g and %g, expected %s", inner, outer, key->expected);
		return;
	}
	if (!(outer > 0.0)) {
		problem_at(loader, node->place, path, "has radius %g, expected %s", outer, key->expected);
		return;
	}
	body->centre[0] = v[0], body->centre[1] = v[1], body->radius = outer, body->hole = inner;
	body->n_vertices = CIRCLE_CORNERS;
	body->vertices = scene_alloc(loader, CIRCLE_CORNERS * sizeof *body->vertices);
	for (int k = 0; k < CIRCLE_CORNERS; k++) {
		double angle = 2.0 * M_PI * k / CIRCLE_CORNERS;
		body->vertices[k][0] = v[0] + outer * cos(angle), body->vertices[k][1] = v[1] + outer * sin(angle);
	}
}

void read_wall_shape(struct loader *loader, const struct scene_key *key, struct node *node, void *target,
					 const char *path)
{
	struct scene_wall *wall = target;
	if (wall->n_vertices)
		problem_at(loader, node->place, path, "is a second shape of this wall, expected one");
	bool line = !strcmp(key->name, "line");
	wall->shape = line ? SCENE_WALL_LINE : SCENE_WALL_POLYGON;
	wall->n_vertices = line ? read_points(loader, key, node, &wall->vertices, path)
							: read_polygon(loader, key, node, &wall->vertices, path);
	if (line && wall->n_vertices && wall->n_vertices != 2)
		problem_at(loader, node->place, path, "has %d points, expected two: %s", wall->n_vertices, key->expected);
}

void read_box(struct loader *loader, const struct scene_key *key, struct node *node, void *target, const char *path)
{
	read_corners(loader, key, node, (double *)((char *)target + key->offset),
				 (double *)((char *)target + key->n_offset), path);
}

void read_grid_follow(struct loader *loader, const struct scene_key *key, struct node *node, void *target,
					  const char *path)
{
	struct scene_grid *grid = target;
	if (!is_string(loader, key, node, path))
		return;
	grid->follow = read_reference(loader, node, "walls", path);
	grid->follows = grid->follow >= 0;
}

/* ---- motions ---- */

static bool is_string_list(struct loader *loader, const struct scene_key *key, const struct node *node,
						   const char *path)
{
	bool good = node->type == NODE_LIST || node->type == NODE_ARRAY;
	for (int k = 0; good && k < node->n; k++)
		good = node->children[k]->type == NODE_STRING;
	if (!good)
		problem_at(loader, node->place, path, "is %s, expected %s",
				   node->type == NODE_STRING ? "a single string" : "no such list", key->expected);
	return good;
}

void read_motion_solution(struct loader *loader, const struct scene_key *key, struct node *node, void *target,
						  const char *path)
{
	struct scene_motion *motion = target;
	char known[256] = "";
	if (!is_string(loader, key, node, path))
		return;
	const struct exact_solution *solution = exact_find(node->string);
	for (int s = 0; exact_solutions[s]; s++)
		if (exact_solutions[s]->motion)
			snprintf(known + strlen(known), sizeof known - strlen(known), "%s%s", *known ? ", " : "",
					 exact_solutions[s]->name);
	if (!solution || !solution->motion) {
		problem_at(loader, node->place, path, "is \"%s\", expected one of %s", node->string, known);
		return;
	}
	motion->solution = solution;
	exact_defaults(solution, motion->parameters);
}

void read_motion_parameters(struct loader *loader, const struct scene_key *key, struct node *node, void *target,
							const char *path)
{
	struct scene_motion *motion = target;
	if (!is_string_list(loader, key, node, path))
		return;
	if (!motion->solution && loader_clean(loader, "%.*s", (int)(strrchr(path, '.') - path), path))
		problem_at(loader, node->place, path, "are given without a solution, expected one");
	for (int k = 0; motion->solution && k < node->n; k++)
		if (exact_set(motion->solution, motion->parameters, node->children[k]->string) != STATUS_OK)
			problem_at(loader, node->children[k]->place, path, "has %s", error_message());
}

/* ---- contacts ---- */

void read_contact_bodies(struct loader *loader, const struct scene_key *key, struct node *node, void *target,
						 const char *path)
{
	struct scene_contact *contact = target;
	if (!is_string_list(loader, key, node, path))
		return;
	if (node->n < 1 || node->n > 2) {
		problem_at(loader, node->place, path, "has %d names, expected %s", node->n, key->expected);
		return;
	}
	contact->n_bodies = node->n;
	for (int k = 0; k < node->n; k++)
		contact->bodies[k] = read_reference(loader, node->children[k], "bodies", path);
}

/* ---- stages ---- */

void read_stage_walls(struct loader *loader, const struct scene_key *key, struct node *node, void *target,
					  const char *path)
{
	struct scene_stage *stage = target;
	if (!is_string_list(loader, key, node, path))
		return;
	stage->n_walls = node->n;
	stage->walls = scene_alloc(loader, ((size_t)node->n + 1) * sizeof *stage->walls);
	for (int k = 0; k < node->n; k++)
		stage->walls[k] = read_reference(loader, node->children[k], "walls", path);
}

void read_stage_then(struct loader *loader, const struct scene_key *key, struct node *node, void *target,
					 const char *path)
{
	struct scene_stage *stage = target;
	if (!is_string_list(loader, key, node, path))
		return;
	for (int k = 0; k < node->n; k++) {
		const struct node *what = node->children[k];
		if (!strcmp(what->string, "install_bonds"))
			stage->then_install_bonds = true;
		else if (!strcmp(what->string, "zero_velocity"))
			stage->then_zero_velocity = true;
		else if (!strcmp(what->string, "zero_ledger"))
			stage->then_zero_ledger = true;
		else
			problem_at(loader, what->place, path, "holds \"%s\", expected %s", what->string, key->expected);
	}
}

/* ---- probes and images ---- */

void read_probe_where(struct loader *loader, const struct scene_key *key, struct node *node, void *target,
					  const char *path)
{
	struct scene_probe *probe = target;
	probe->id = -1;
	if (!strcmp(key->name, "id")) {
		probe->kind = SCENE_PROBE_ID;
		if (node->type == NODE_INTEGER && node->integer >= 0)
			probe->id = (long)node->integer;
		else
			problem_at(loader, node->place, path, "is %s, expected %s",
					   node->type == NODE_INTEGER ? "negative" : node_kind(node), key->expected);
		return;
	}
	probe->kind = !strcmp(key->name, "at") ? SCENE_PROBE_AT : SCENE_PROBE_MATERIAL;
	read_numbers(loader, key, node, 2, probe->at, path);
}

void read_component(struct loader *loader, const struct scene_key *key, struct node *node, void *target,
					const char *path)
{
	static const struct {
		const char *name;
		int index;
	} components[] = {{"magnitude", -1}, {"x", 0}, {"y", 1}, {"xx", 0}, {"yy", 1}, {"zz", 2}, {"xy", 3}};
	struct scene_image *image = target;
	if (!is_string(loader, key, node, path))
		return;
	for (size_t k = 0; k < sizeof components / sizeof *components; k++)
		if (!strcmp(node->string, components[k].name)) {
			image->component = components[k].index;
			return;
		}
	problem_at(loader, node->place, path, "is \"%s\", expected %s", node->string, key->expected);
}

void read_range(struct loader *loader, const struct scene_key *key, struct node *node, void *target, const char *path)
{
	struct scene_image *image = target;
	image->range_auto = node->type == NODE_STRING && !strcmp(node->string, "auto");
	if (image->range_auto)
		return;
	if (node->type == NODE_STRING)
		problem_at(loader, node->place, path, "is \"%s\", expected %s", node->string, key->expected);
	else if (read_numbers(loader, key, node, 2, image->range, path) && image->range[0] >= image->range[1])
		problem_at(loader, node->place, path, "is [%g, %g], expected min < max", image->range[0], image->range[1]);
}

/* ---- catalyst ---- */

/* As with packings: absolute in the scene's text, so that it means the same wherever that is stored. */
void read_pipelines(struct loader *loader, const struct scene_key *key, struct node *node, void *target,
					const char *path)
{
	struct scene_catalyst *catalyst = target;
	char absolute[PATH_MAX];
	if (!is_string_list(loader, key, node, path))
		return;
	catalyst->pipelines = scene_alloc(loader, ((size_t)node->n + 1) * sizeof *catalyst->pipelines);
	for (int k = 0; k < node->n; k++) {
		struct node *script = node->children[k];
		const char *seen =
			script->place.line > 0 ? path_beside(loader, script->place.file, script->string) : script->string;
		if (!realpath(seen, absolute) || access(absolute, R_OK)) {
			problem_at(loader, script->place, path, "'%s' cannot be read, expected a script of ParaView Catalyst", seen);
			continue;
		}
		script->string = loader_string(loader, absolute);
		catalyst->pipelines[catalyst->n_pipelines++] = scene_string(loader, absolute);
	}
}
