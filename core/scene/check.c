/* What no single key can tell: geometry, references, limits.  Each check looks only at what has been read
 * without fault, so that one slip gives one message. */
#include <math.h>
#include <string.h>

#include "base/error.h"
#include "scene/geometry.h"
#include "scene/private.h"

static const double TOUCHING = 1e-6; /* cells: nearer than this is touching, not crossing */

/* "list.[k].key" in buffer[PATH_LENGTH]. */
static const char *path_to(char *buffer, const char *list, int k, const char *key)
{
	return path_print(buffer, "%s.[%d]%s%s", list, k, *key ? "." : "", key);
}

static bool clean_element(const struct loader *loader, const char *list, int k)
{
	return loader_clean(loader, "%s.[%d]", list, k);
}

/* ---- grid and time ---- */

static void check_grid(struct loader *loader)
{
	const struct scene_grid *grid = &loader->scene->grid;
	double nodes = 1.0;
	for (int a = 0; a < 2; a++) {
		double cells = grid->size[a] / grid->cell, whole = fmax(1.0, round(cells));
		nodes *= whole + 1.0;
		if (fabs(cells - whole) > 1e-6 * whole)
			problem_of(loader, "grid.size",
					   "is %.10g m in %c, expected a whole number of cells of %.10g m, such as %.10g", grid->size[a],
					   "xy"[a], grid -> cell, whole * grid -> cell);
		else if (whole < 3.0)
			problem_of(loader, "grid.size", "is %.0f cells in %c, expected at least 3", whole, "xy"[a]);
	}
	if (nodes > 1e8)
		problem_of(loader, "grid.cell", "makes %.3g nodes, expected at most 1e8: larger cells or a smaller grid",
				   nodes);
}

static void check_time(struct loader *loader)
{
	const struct scene_time *time = &loader->scene->time;
	const struct scene_mpm *mpm = &loader->scene->mpm;
	if (time->end < time->step)
		problem_of(loader, "time.end", "is %g s, expected at least one step of %g s", time->end, time->step);
	else if (time->end / time->step > 1e12)
		problem_of(loader, "time.step", "makes %.3g steps, expected at most 1e12", time->end / time->step);
	if (time->thermal_steps > 1 && time->thermal_every > 1)
		problem_of(loader, "time.thermal_every", "is %d and thermal_steps is %d, expected one of them to be 1",
				   time->thermal_every, time->thermal_steps);
	if (!loader_clean(loader, "mpm"))
		return;
	if (mpm->damping_particle * time->step + mpm->pic_fraction > 1.0)
		problem_of(loader, "mpm.damping_particle",
				   "takes more than the whole velocity in one step of %g s, expected at most %g 1/s", time->step,
				   (1.0 - mpm->pic_fraction) / time->step);
	if (mpm->damping_grid * time->step > 1.0)
		problem_of(loader, "mpm.damping_grid",
				   "takes more than the whole velocity in one step of %g s, expected at most %g 1/s", time->step,
				   1.0 / time->step);
}

/* ---- the schemes ---- */

/* What is said of a scheme that is not used would do nothing. */
static void check_transfer(struct loader *loader)
{
	const struct scene_mpm *mpm = &loader->scene->mpm;
	bool filters = mpm->transfer == MPM_XPIC || mpm->transfer == MPM_FMPM;
	const char *name = mpm_transfer_names[mpm->transfer];
	if (!filters && mpm->xpic_order != 2)
		problem_of(loader, "mpm.xpic_order", "is %d, but transfer is \"%s\", expected transfer = \"xpic\" or \"fmpm\"",
				   mpm->xpic_order, name);
	if (!filters && mpm->xpic_every != 1)
		problem_of(loader, "mpm.xpic_every", "is %d, but transfer is \"%s\", expected transfer = \"xpic\" or \"fmpm\"",
				   mpm->xpic_every, name);
	/* in a bar at rest it grows from noise, in windows of the step down to 0.3 of the limit */
	if (mpm->transfer == MPM_FMPM && mpm->xpic_every > 1 && mpm->order != MPM_USL)
		problem_of(
			loader, "mpm.xpic_every",
			"is %d, but FMPM in some steps only is unstable with order = \"%s\", expected 1, transfer = \"xpic\", or "
			"order = \"usl\"",
			mpm->xpic_every, mpm_order_names[mpm->order]);
	if (mpm->pic_fraction > 0.0 && (mpm->transfer == MPM_APIC || (filters && mpm->xpic_every == 1)))
		problem_of(loader, "mpm.pic_fraction", "is %g, but with transfer = \"%s\" no step is FLIP, expected 0%s",
				   mpm->pic_fraction, name, filters ? ", or xpic_every > 1" : "");
}

/* ---- names ---- */

static void check_unique(struct loader *loader, const char *list)
{
	const struct node *elements = node_find(loader->root, list);
	for (int k = 0; elements && k < elements->n; k++) {
		const struct node *name = node_find(elements->children[k], "name");
		for (int j = 0; name && name->type == NODE_STRING && j < k; j++) {
			const struct node *other = node_find(elements->children[j], "name");
			if (other && other->type == NODE_STRING && !strcmp(name->string, other->string)) {
				char path[PATH_LENGTH];
				problem_at(loader, name->place, path_to(path, list, k, "name"),
						   "is \"%s\" again, expected a name of its own (first at %s:%d)", name->string,
						   other->place.file, other->place.line);
				break;
			}
		}
	}
}

static void check_names(struct loader *loader)
{
	static const char *const lists[] = {"laws",   "materials", "bodies", "walls",   "boundaries", "stages",
										"probes", "regions",   "cracks", "inspect", "images"};
	for (size_t k = 0; k < sizeof lists / sizeof *lists; k++)
		check_unique(loader, lists[k]);
	const struct node *laws = node_find(loader->root, "laws");
	char path[PATH_LENGTH];
	for (int k = 0; laws && k < laws->n; k++)
		if (laws->children[k]->type == NODE_GROUP && !node_find(laws->children[k], "name"))
			problem_at(loader, laws->children[k]->place, path_to(path, "laws", k, "name"),
					   "is missing, expected a name by which materials refer to the law");
}

/* ---- laws and materials ---- */

/* Where a law was said: in the list, or by the material that owns it. */
static void law_path(const struct loader *loader, int law, char *path)
{
	const struct node *list = node_find(loader->root, "laws");
	int listed = list ? list->n : 0;
	path_to(path, "laws", law, "");
	for (int k = 0; law >= listed && k < loader->scene->n_materials; k++)
		if (loader->scene->materials[k].law == law)
			path_to(path, "materials", k, "law");
}

static void check_packing(struct loader *loader, const struct scene_packing *packing, const char *law)
{
	char path[PATH_LENGTH];
	if (packing->file[0])
		return;
	if (isnan(packing->pressure)) {
		problem_of(loader, path_print(path, "%s.packing.pressure", law),
				   "is missing, expected the pressure of consolidation > 0 (Pa), or a file");
	}
	if (packing->radius_min > packing->radius_max) {
		problem_of(loader, path_print(path, "%s.packing.radius_min", law),
				   "is %g m, expected at most radius_max = %g m", packing->radius_min, packing->radius_max);
	}
	int side = (int)lround(sqrt((double)packing->discs));
	if (packing->lattice[0] && side * side != packing->discs) {
		problem_of(loader, path_print(path, "%s.packing.discs", law),
				   "is %d on a square lattice, expected a square number such as %d", packing->discs, side * side);
	}
}

/* The group `bonds` of a law, NULL if it has none. */
static const struct node *bonds_of(const struct loader *loader, int law)
{
	char path[PATH_LENGTH], inner[PATH_LENGTH];
	law_path(loader, law, path);
	const struct node *node = tree_walk(loader->root, path_print(inner, "%s.bonds", path));
	return node && node->name && !strcmp(node->name, "bonds") ? node : NULL;
}

static void check_bonds(struct loader *loader, const struct scene_law_rve *rve, const char *law)
{
	const struct scene_bonds *bonds = &rve->bonds;
	char path[PATH_LENGTH];
	if (bonds->strength >= rve->skin)
		problem_of(loader, path_print(path, "%s.bonds.strength", law),
				   "is %g, expected less than skin = %g: bonded discs that part must stay neighbours", bonds->strength,
				   rve->skin);
	if (bonds->linear && isinf(bonds->melting))
		problem_of(loader, path_print(path, "%s.bonds.melting", law),
				   "is missing, expected the temperature at which linear softening ends");
	else if (bonds->linear && bonds->reference >= bonds->melting)
		problem_of(loader, path_print(path, "%s.bonds.reference", law), "is %g %s, expected less than melting = %g %s",
				   scene_temperature_out(loader->scene, bonds->reference), scene_temperature_unit(loader->scene),
				   scene_temperature_out(loader->scene, bonds->melting), scene_temperature_unit(loader->scene));
}

/* The softening of a point snaps back where its band is as wide as 2 E Gf / strength^2: half of that is asked for. */
static void check_rankine(struct loader *loader, const struct scene_law_rankine *law, const char *path)
{
	double longest = law->young * law->fracture_energy / (law->strength * law->strength);
	if (loader_clean(loader, "grid") && loader->scene->grid.cell * M_SQRT2 > longest) {
		char key[PATH_LENGTH];
		problem_of(
			loader, path_print(key, "%s.fracture_energy", path),
			"is too small for cells of %g m: a cracking point would snap back, expected cells of %.4g m or less = "
			"young fracture_energy / (sqrt(2) strength^2), or a fracture_energy of %.4g J/m2",
			loader->scene->grid.cell, longest / M_SQRT2,
			loader->scene->grid.cell * M_SQRT2 * law->strength * law->strength / law->young);
	}
}

static void check_laws(struct loader *loader)
{
	for (int k = 0; k < loader->scene->n_laws; k++) {
		char path[PATH_LENGTH];
		const struct scene_law *law = &loader->scene->laws[k];
		law_path(loader, k, path);
		if (!loader_clean(loader, "%s", path))
			continue;
		if (law->type == SCENE_LAW_RVE) {
			check_packing(loader, &law->rve.packing, path);
			check_bonds(loader, &law->rve, path);
		} else if (law->type == SCENE_LAW_RANKINE) {
			check_rankine(loader, &law->rankine, path);
		} else if (law->thermoelastic.neo_hookean && law->thermoelastic.plane_stress) {
			char key[PATH_LENGTH];
			problem_of(loader, path_print(key, "%s.plane", path),
					   "is \"stress\", expected \"strain\" with elasticity = \"neo_hookean\"");
		}
	}
}

/* P-wave modulus of a solid at small strain, Pa. */
static double p_wave_modulus(const struct scene_law *law)
{
	bool rankine = law->type == SCENE_LAW_RANKINE;
	double e = rankine ? law->rankine.young : law->thermoelastic.young;
	double nu = rankine ? law->rankine.poisson : law->thermoelastic.poisson;
	return !rankine && law->thermoelastic.plane_stress ? e / (1.0 - nu * nu)
													   : e * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu));
}

/* The two step limits, where the file tells enough: dt <= b h sqrt(rho/M), dt_thermal <= rho c h^2 / (2 k). */
static void check_step(struct loader *loader, const struct scene_material *material)
{
	const struct scene *scene = loader->scene;
	const struct scene_law *law = &scene->laws[material->law];
	double h = scene->grid.cell, step = scene->time.step, density = material->density;
	if (law->type == SCENE_LAW_RVE && isnan(density))
		density = law->rve.grain_density; /* the bulk is lighter: what is over this limit is over the true one */
	if (law->type != SCENE_LAW_RVE) {
		double limit = scene->time.step_factor * h * sqrt(density / p_wave_modulus(law));
		if (scene->guards.time_step && step > limit)
			problem_of(loader, "time.step",
					   "is %g s, over the limit of material '%s', expected at most %.4g s = %g cell sqrt(density / M)",
					   step, material->name, limit, scene->time.step_factor);
	}
	double thermal_step = step * scene->thermal.time_scale * scene->time.thermal_every / scene->time.thermal_steps;
	double capacity = fmin(material->heat_capacity, material->heat_capacity_frozen);
	double thermal_limit =
		density * capacity * h * h / (2.0 * fmax(material->conductivity, material->conductivity_frozen));
	if (scene->thermal.on && scene->guards.thermal_step && thermal_step > thermal_limit)
		problem_of(loader, scene->time.thermal_every > 1 ? "time.thermal_every" : "time.step",
				   "makes thermal steps of %g s, over the limit of material '%s', expected at most %.4g s = density "
				   "heat_capacity "
				   "cell^2 / (2 conductivity)%s",
				   thermal_step, material->name, thermal_limit,
				   scene->time.thermal_every > 1 ? "" : ", or more time.thermal_steps");
}

/* What only means something beside another key. */
static void check_freezing(struct loader *loader, int k)
{
	static const char *const frozen[] = {"latent_heat", "heat_capacity_frozen", "conductivity_frozen"};
	const struct scene *scene = loader->scene;
	const struct node *node = node_find(loader->root, "materials")->children[k];
	char path[PATH_LENGTH];
	bool freezes = !isnan(scene->materials[k].freezing[0]);
	for (size_t f = 0; f < sizeof frozen / sizeof *frozen && !freezes; f++)
		if (node_find(node, frozen[f]))
			problem_of(
				loader, path_to(path, "materials", k, frozen[f]),
				"is given though the material does not freeze, expected freezing = [frozen below, thawed above]");
	if (freezes && !scene->thermal.on)
		problem_of(loader, path_to(path, "materials", k, "freezing"), "is given though heat is off, expected heat");
	if (freezes && scene->thermal.on && scene->time.thermal_steps > 1 && loader_clean(loader, "time"))
		problem_of(loader, "time.thermal_steps",
				   "is %d though material '%s' freezes, expected 1: thermal sub-steps know no latent heat",
				   scene->time.thermal_steps, scene->materials[k].name);
}

static void check_cracks(struct loader *loader)
{
	const struct scene *scene = loader->scene;
	bool breaks = false;
	for (int k = 0; k < scene->n_laws; k++)
		breaks = breaks || scene->laws[k].type == SCENE_LAW_RANKINE;
	if (scene->n_cracks > 0 && !breaks)
		problem_of(loader, "cracks", "are given though nothing can break, expected a law of type \"%s\"",
				   scene_law_type_names[SCENE_LAW_RANKINE]);
}

static void check_materials(struct loader *loader)
{
	const struct scene *scene = loader->scene;
	char path[PATH_LENGTH];
	for (int k = 0; k < scene->n_materials; k++) {
		const struct scene_material *material = &scene->materials[k];
		if (!clean_element(loader, "materials", k) || material->law < 0)
			continue;
		law_path(loader, material->law, path);
		if (!loader_clean(loader, "%s", path))
			continue;
		bool elastic = scene->laws[material->law].type != SCENE_LAW_RVE;
		if (elastic && isnan(material->density))
			problem_of(loader, path_to(path, "materials", k, "density"), "is missing, expected a number > 0 (kg/m3)");
		if (scene->thermal.on && isnan(material->heat_capacity))
			problem_of(loader, path_to(path, "materials", k, "heat_capacity"),
					   "is missing though heat is on, expected a number > 0 (J/(kg K))");
		if (scene->thermal.on && elastic && isnan(material->conductivity))
			problem_of(loader, path_to(path, "materials", k, "conductivity"),
					   "is missing though heat is on, expected a number >= 0 (W/(m K))");
		check_freezing(loader, k);
		if (clean_element(loader, "materials", k) && loader_clean(loader, "time") && loader_clean(loader, "grid") &&
			loader_clean(loader, "thermal"))
			check_step(loader, material);
	}
}

/* ---- bodies and walls ---- */

/* A polygon with area that does not cut itself. */
static bool check_polygon(struct loader *loader, const char *path, int n, const double (*v)[2])
{
	int i, j;
	double tolerance = TOUCHING * loader->scene->grid.cell;
	if (n < 3) {
		problem_of(loader, path, "has %d corner%s, expected at least 3", n, n == 1 ? "" : "s");
		return false;
	}
	if (polygon_is_simple(n, v, tolerance, &i, &j) && fabs(polygon_area(n, v)) > tolerance * tolerance)
		return true;
	if (i < n)
		problem_of(loader, path, "cuts or touches itself near (%g, %g), expected corners in order around it", v[i][0],
				   v[i][1]);
	else
		problem_of(loader, path, "has no area, expected corners in order around it");
	return false;
}

static const char *shape_key(const struct loader *loader, const char *list, int k)
{
	static const char *const shapes[] = {"polygon", "box", "wedge", "line", "disc", "ring", "outline", "mask"};
	const struct node *elements = node_find(loader->root, list);
	for (size_t s = 0; s < sizeof shapes / sizeof *shapes; s++)
		if (node_find(elements->children[k], shapes[s]))
			return shapes[s];
	return "";
}

static void check_in_grid(struct loader *loader, const char *path, const struct scene_body *body)
{
	const struct scene_grid *grid = &loader->scene->grid;
	double margin = grid->cell * (1.0 - TOUCHING);
	for (int i = 0; i < body->n_vertices; i++)
		for (int a = 0; a < 2; a++) {
			double low = grid->origin[a] + margin, high = grid->origin[a] + grid->size[a] - margin,
				   x = body->vertices[i][a];
			if (x < low || x > high) {
				problem_of(loader, path,
						   "reaches %c = %g m, outside the grid, expected %g to %g m (one cell of margin)", "xy"[a], x,
						   grid -> origin[a] + grid -> cell, grid -> origin[a] + grid -> size[a] - grid -> cell);
				return;
			}
		}
}

static void check_layers(struct loader *loader, int k)
{
	const struct scene_body *body = &loader->scene->bodies[k];
	for (int j = 1; j < body->n_layers; j++)
		if (body->layers[j].top <= body->layers[j - 1].top) {
			char path[PATH_LENGTH];
			problem_of(loader, path_print(path, "bodies.[%d].layers.[%d].top", k, j),
					   "is %g m, expected more than the %g m of the layer below", body->layers[j].top,
					   body->layers[j - 1].top);
		}
}

/* A gradient is steepest at the corners. */
static void check_gradient(struct loader *loader, int k)
{
	const struct scene_body *body = &loader->scene->bodies[k];
	double coldest = body->temperature;
	for (int j = 0; j < body->n_layers; j++)
		coldest = fmin(coldest, body->layers[j].temperature);
	for (int i = 0; i < body->n_vertices; i++) {
		double T = coldest + scene_body_warming(body, body->vertices[i]);
		if (T < 0.0) {
			char path[PATH_LENGTH];
			problem_of(loader, path_to(path, "bodies", k, "temperature_gradient"),
					   "cools the body to %.6g K at (%g, %g), expected no temperature below absolute zero", T,
					   body->vertices[i][0], body->vertices[i][1]);
			return;
		}
	}
}

/* Fills a body for the checks that follow; n_points stays -1 if it cannot be filled. */
static void fill_body(struct loader *loader, int k)
{
	char path[PATH_LENGTH];
	const struct scene_body *body = &loader->scene->bodies[k];
	int n, status = scene_body_points(loader->scene, body, &loader->points[k], &n);
	if (status == STATUS_RESOURCE)
		longjmp(loader->no_memory, 1);
	if (status)
		problem_of(loader, path_to(path, "bodies", k, ""), "%s", error_message());
	else if (!n)
		problem_of(loader, path_to(path, "bodies", k, shape_key(loader, "bodies", k)),
				   "holds no point of the lattice (spacing %g m), expected a larger body or a smaller cell",
				   scene_body_spacing(loader->scene, body));
	else
		loader->n_points[k] = n;
}

/* Points of body k in body j < k would be matter twice. */
static void check_apart(struct loader *loader, int k)
{
	const struct scene *scene = loader->scene;
	for (int j = 0; j < k; j++) {
		const struct scene_body *other = &scene->bodies[j];
		for (int i = 0; loader->n_points[j] > 0 && i < loader->n_points[k]; i++) {
			const double *p = loader->points[k][i];
			if (scene_body_contains(other, p, TOUCHING * scene->grid.cell)) {
				char path[PATH_LENGTH];
				problem_of(loader, path_to(path, "bodies", k, shape_key(loader, "bodies", k)),
						   "overlaps body '%s', for instance at (%g, %g), expected bodies beside each other",
						   other->name, p[0], p[1]);
				break;
			}
		}
	}
}

/* A body that follows a motion lies in its domain, and is of a law whose stress has a derivative. */
static void check_motion(struct loader *loader, int k)
{
	const struct scene *scene = loader->scene;
	const struct scene_body *body = &scene->bodies[k];
	const struct scene_motion *motion = &body->motion;
	char path[PATH_LENGTH];
	struct exact_motion start;
	bool whole = true;
	if (!motion->solution || !clean_element(loader, "bodies", k))
		return;
	for (int i = 0; i < loader->n_points[k]; i++) {
		if (!motion->solution->motion(motion->parameters, loader->points[k][i], 0.0, &start)) {
			problem_of(loader, path_to(path, "bodies", k, "motion"),
					   "is not defined at (%g, %g), expected a body inside of it (`tmdempm exact %s`)",
					   loader->points[k][i][0], loader->points[k][i][1], motion->solution->name);
			return;
		}
		whole &= start.F[0] == 1.0 && start.F[1] == 0.0 && start.F[2] == 0.0 && start.F[3] == 1.0;
	}
	if (body->velocity[0] != 0.0 || body->velocity[1] != 0.0)
		problem_of(loader, path_to(path, "bodies", k, "velocity"), "is given with a motion, expected one of the two");
	for (int j = -1; j < body->n_layers; j++) {
		int material = j < 0 ? body->material : body->layers[j].material, law = scene->materials[material].law;
		if (law < 0 || (!motion->force && whole))
			continue;
		if (scene->laws[law].type != SCENE_LAW_THERMOELASTIC)
			problem_of(loader, path_to(path, "bodies", k, "motion"),
					   "%s law '%s', expected one of type \"thermoelastic\", or %s",
					   whole ? "is imposed on" : "begins with a deformation of", scene->laws[law].name,
					   whole ? "force = false" : "a motion that begins without");
		else if (motion->force && scene->thermal.on && scene->laws[law].thermoelastic.expansion != 0.0)
			problem_of(loader, path_to(path, "bodies", k, "motion"),
					   "is imposed on law '%s', which expands with heat, expected expansion = 0, or no heat",
					   scene->laws[law].name);
	}
}

static void check_cuts(struct loader *loader, int k)
{
	const struct scene_body *body = &loader->scene->bodies[k];
	char path[PATH_LENGTH];
	for (int j = 0; j < body->n_cuts; j++) {
		path_print(path, "bodies.[%d].cuts.[%d]", k, j);
		if (body->cuts[j].n_vertices == 0)
			problem_of(loader, path, "has no shape, expected box = [...], polygon = (...) or disc = [...]");
		else
			check_polygon(loader, path, body->cuts[j].n_vertices, (const double(*)[2])body->cuts[j].vertices);
	}
}

/* False (recorded) if the body's mask makes no region. */
static bool check_mask(struct loader *loader, int k)
{
	const struct scene_body *body = &loader->scene->bodies[k];
	const struct node *mask = node_find(node_find(loader->root, "bodies")->children[k], "mask");
	char path[PATH_LENGTH];
	path_to(path, "bodies", k, "mask");
	if (!mask)
		return true;
	if (!body->mask.inside || isnan(body->mask.pixel))
		problem_of(loader, path, "has no %s, expected file and pixel", body->mask.inside ? "pixel" : "file");
	else if (body->n_vertices == 0)
		problem_of(loader, path, "'%s' has no pixel from %d to %d, expected some", body->mask.file, body->mask.level[0],
				   body->mask.level[1]);
	else
		return true;
	return false;
}

static void check_bodies(struct loader *loader)
{
	struct scene *scene = loader->scene;
	char path[PATH_LENGTH];
	for (int k = 0; k < scene->n_bodies; k++)
		loader->n_points[k] = -1;
	for (int k = 0; k < scene->n_bodies; k++) {
		struct scene_body *body = &scene->bodies[k];
		if (!clean_element(loader, "bodies", k))
			continue;
		int side = (int)lround(sqrt((double)body->points_per_cell));
		if (side * side != body->points_per_cell)
			problem_of(loader, path_to(path, "bodies", k, "points_per_cell"), "is %d, expected 1, 4, 9 or 16",
					   body->points_per_cell);
		check_layers(loader, k);
		check_gradient(loader, k);
		if (loader_clean(loader, "grid"))
			check_cuts(loader, k);
		path_to(path, "bodies", k, shape_key(loader, "bodies", k));
		if (!check_mask(loader, k))
			continue;
		if (!*shape_key(loader, "bodies", k)) {
			problem_of(loader, path, "has no shape, expected box, polygon, disc, ring, outline or mask");
		} else if (loader_clean(loader, "grid") &&
				   check_polygon(loader, path, body->n_vertices, (const double(*)[2])body->vertices)) {
			check_in_grid(loader, path, body);
			if (!clean_element(loader, "bodies", k))
				continue;
			fill_body(loader, k);
			check_apart(loader, k);
			check_motion(loader, k);
		}
	}
}

/* Is p inside a line's solid: on its right, no further than its depth? */
static bool behind_line(const struct scene_wall *wall, const double p[2], double tolerance)
{
	const double *a = wall->vertices[0], *b = wall->vertices[1];
	double ex = b[0] - a[0], ey = b[1] - a[1], length = hypot(ex, ey);
	double along = ((p[0] - a[0]) * ex + (p[1] - a[1]) * ey) / length;
	double right = ((p[0] - a[0]) * ey - (p[1] - a[1]) * ex) / length;
	return along > tolerance && along < length - tolerance && right > tolerance && right < wall->depth;
}

/* Do the outlines cross, or does a corner of the wall lie in the body? (A wall too thin to hold a point.) */
static bool outlines_cross(const struct scene_wall *wall, const struct scene_body *body, double tolerance,
						   double where[2])
{
	const double(*v)[2] = (const double(*)[2])body->vertices;
	int edges = wall->shape == SCENE_WALL_LINE ? 1 : wall->n_vertices;
	for (int i = 0; i < wall->n_vertices; i++) {
		const double *a = wall->vertices[i], *b = wall->vertices[(i + 1) % wall->n_vertices];
		where[0] = a[0], where[1] = a[1];
		if (polygon_contains(body->n_vertices, v, a, tolerance))
			return true;
		for (int j = 0; i < edges && j < body->n_vertices; j++)
			if (segments_cross(a, b, v[j], v[(j + 1) % body->n_vertices], tolerance)) {
				where[0] = v[j][0], where[1] = v[j][1];
				return true;
			}
	}
	return false;
}

/* Does this wall stand when the run begins? */
static bool stands_at_start(const struct scene *scene, int k)
{
	const struct scene_wall *wall = &scene->walls[k];
	if (!wall->active || wall->from > 0.0)
		return false;
	const struct scene_stage *first = scene->stages;
	bool stands = !scene->n_stages || first->n_walls < 0;
	for (int i = 0; !stands && i < first->n_walls; i++)
		stands = first->walls[i] == k;
	return stands;
}

static void check_wall_free(struct loader *loader, int k, const char *path)
{
	const struct scene *scene = loader->scene;
	const struct scene_wall *wall = &scene->walls[k];
	double tolerance = TOUCHING * scene->grid.cell, where[2] = {0.0, 0.0};
	for (int b = 0; b < scene->n_bodies; b++) {
		const struct scene_body *body = &scene->bodies[b];
		int inside = 0;
		for (int i = 0; i < loader->n_points[b]; i++) {
			const double *p = loader->points[b][i];
			if (wall->shape == SCENE_WALL_LINE
					? behind_line(wall, p, tolerance)
					: polygon_contains(wall->n_vertices, (const double(*)[2])wall->vertices, p, tolerance)) {
				if (!inside++)
					where[0] = p[0], where[1] = p[1];
			}
		}
		if (loader->n_points[b] < 0)
			continue;
		if (inside)
			problem_of(
				loader, path,
				"stands in body '%s' at the start: %d of its points are in the solid, the first at (%g, %g), expected "
				"the wall beside it%s",
				body->name, inside, where[0], where[1],
				wall->shape == SCENE_WALL_LINE ? " (a line's solid is on its right)" : "");
		else if (outlines_cross(wall, body, tolerance, where))
			problem_of(loader, path, "cuts body '%s' at the start near (%g, %g), expected the wall beside it",
					   body->name, where[0], where[1]);
	}
}

/* A value and its table are two ways to say one thing. */
static void check_one_of(struct loader *loader, const char *list, int k, const char *key, double constant,
						 const struct scene_series *series)
{
	char path[PATH_LENGTH];
	path_to(path, list, k, key);
	if (series->n && !isnan(constant))
		problem_of(loader, path, "is given beside %s_table, expected one of the two", path);
}

/* A penalty wall is a line that pushes, and no more. */
static void check_penalty(struct loader *loader, int k, const char *shape)
{
	const struct scene_wall *wall = &loader->scene->walls[k];
	char path[PATH_LENGTH];
	if (wall->shape != SCENE_WALL_LINE && *shape_key(loader, "walls", k))
		problem_of(loader, shape, "is the shape of a penalty wall, expected a line");
	if (wall->friction > 0.0)
		problem_of(loader, path_to(path, "walls", k, "friction"), "is %g, but penalty walls are smooth, expected 0",
				   wall->friction);
	if (scene_wall_heats(wall))
		problem_of(loader, path_to(path, "walls", k, "temperature"),
				   "is given to a penalty wall, which holds no nodes, expected a boundary's temperature");
}

static void check_walls(struct loader *loader)
{
	struct scene *scene = loader->scene;
	char path[PATH_LENGTH], key[PATH_LENGTH];
	for (int k = 0; k < scene->n_walls; k++) {
		const struct scene_wall *wall = &scene->walls[k];
		if (!clean_element(loader, "walls", k))
			continue;
		path_to(path, "walls", k, shape_key(loader, "walls", k));
		check_one_of(loader, "walls", k, "temperature", wall->temperature, &wall->temperature_table);
		if (wall->until <= wall->from)
			problem_of(loader, path_to(key, "walls", k, "until"), "is %g s, expected more than from = %g s",
					   wall->until, wall->from);
		if (wall->contact == SCENE_WALL_PENALTY)
			check_penalty(loader, k, path);
		if (!*shape_key(loader, "walls", k))
			problem_of(loader, path, "has no shape, expected line, box, polygon or wedge");
		else if (!loader_clean(loader, "grid"))
			continue;
		else if (wall->shape == SCENE_WALL_LINE &&
				 hypot(wall->vertices[1][0] - wall->vertices[0][0], wall->vertices[1][1] - wall->vertices[0][1]) <=
					 TOUCHING * scene->grid.cell)
			problem_of(loader, path, "has no length, expected two different points");
		else if (wall->shape == SCENE_WALL_LINE ||
				 check_polygon(loader, path, wall->n_vertices, (const double(*)[2])wall->vertices))
			if (stands_at_start(scene, k) && loader_clean(loader, "stages"))
				check_wall_free(loader, k, path);
	}
}

static void check_convection(struct loader *loader, int k)
{
	const struct scene_convection *c = &loader->scene->boundaries[k].convection;
	char path[PATH_LENGTH];
	bool ambient = !isnan(c->ambient) || c->ambient_table.n;
	if (!isnan(c->coefficient) && !ambient)
		problem_of(loader, path_to(path, "boundaries", k, "convection"),
				   "has no ambient, expected ambient or ambient_table");
	if (isnan(c->coefficient) && ambient)
		problem_of(loader, path_to(path, "boundaries", k, "convection"),
				   "has no coefficient, expected a number > 0 (W/(m2 K))");
}

/* A grid that follows a wall: along the wall's motion its face and the fixed place are rows of nodes. */
static void check_follow(struct loader *loader)
{
	const struct scene *scene = loader->scene;
	const struct scene_grid *grid = &scene->grid;
	if (!grid->follows || !loader_clean(loader, "walls") || !loader_clean(loader, "grid"))
		return;
	const struct scene_wall *wall = &scene->walls[grid->follow];
	if (wall->velocity[0] == 0.0 && wall->velocity[1] == 0.0)
		problem_of(loader, "grid.follow", "is wall '%s', which does not move, expected a wall with a velocity",
				   wall->name);
	for (int c = 0; c < 2; c++) {
		double face = scene_grid_face(scene, c), fixed = grid->fixed[c];
		double rows[2] = {(fixed - grid->origin[c]) / grid->cell, (face - grid->origin[c]) / grid->cell};
		if (wall->velocity[c] == 0.0)
			continue;
		if (fabs(rows[0] - round(rows[0])) > TOUCHING)
			problem_of(loader, "grid.fixed", "is %c = %g m, between two rows of nodes, expected it on one", "xy"[c],
					   fixed);
		else if (fabs(rows[1] - round(rows[1])) > TOUCHING)
			problem_of(loader, "grid.follow",
					   "has its face at %c = %g m, between two rows of nodes, expected it on one", "xy"[c], face);
		else if (fabs(rows[1] - rows[0]) < 0.5)
			problem_of(loader, "grid.fixed", "is %c = %g m, on the face of wall '%s', expected it elsewhere", "xy"[c],
					   fixed, wall -> name);
	}
}

/* Heat through a surface goes to the points of a box, and so does a traction: is there one, unless heat comes to them
 * later? */
static void check_points_of_box(struct loader *loader, int k)
{
	const struct scene *scene = loader->scene;
	const struct scene_boundary *b = &scene->boundaries[k];
	char path[PATH_LENGTH];
	bool loads = scene_boundary_loads_points(b), holds = b->from > 0.0 && !loads;
	for (int n = 0; n < scene->n_bodies && !holds; n++) {
		if (loader->n_points[n] < 0)
			return;
		for (int i = 0; i < loader->n_points[n] && !holds; i++) {
			const double *x = loader->points[n][i];
			holds = x[0] >= b->min[0] && x[0] <= b->max[0] && x[1] >= b->min[1] && x[1] <= b->max[1];
		}
	}
	if (!holds)
		problem_of(loader, path_to(path, "boundaries", k, "box"),
				   "holds no point at the start to be %s, expected one that reaches %g m (layer) into a body",
				   loads ? "loaded" : "heated", b->layer);
}

static void check_boundaries(struct loader *loader)
{
	const struct scene *scene = loader->scene;
	const struct scene_grid *grid = &scene->grid;
	char path[PATH_LENGTH];
	for (int k = 0; k < scene->n_boundaries; k++) {
		const struct scene_boundary *b = &scene->boundaries[k];
		if (!clean_element(loader, "boundaries", k))
			continue;
		bool nodal = !isnan(b->velocity[0]) || !isnan(b->velocity[1]) || scene_boundary_heats_nodes(b);
		check_one_of(loader, "boundaries", k, "temperature", b->temperature, &b->temperature_table);
		check_one_of(loader, "boundaries", k, "flux", b->flux, &b->flux_table);
		check_one_of(loader, "boundaries", k, "convection.ambient", b->convection.ambient,
					 &b->convection.ambient_table);
		check_convection(loader, k);
		bool of_points = scene_boundary_heats_points(b) || scene_boundary_loads_points(b);
		if (!nodal && !of_points && clean_element(loader, "boundaries", k))
			problem_of(loader, path_to(path, "boundaries", k, ""),
					   "imposes nothing, expected velocity_x, velocity_y, temperature, flux, convection, traction_x or "
					   "traction_y");
		if (b->until <= b->from)
			problem_of(loader, path_to(path, "boundaries", k, "until"), "is %g s, expected more than from = %g s",
					   b->until, b->from);
		bool holds = true;
		for (int a = 0; a < 2; a++) {
			double first = ceil((b->min[a] - grid->origin[a]) / grid->cell - 1e-9);
			double last = floor((b->max[a] - grid->origin[a]) / grid->cell + 1e-9);
			holds = holds && fmax(first, 0.0) <= fmin(last, round(grid->size[a] / grid->cell));
		}
		if (nodal && !holds && loader_clean(loader, "grid"))
			problem_of(loader, path_to(path, "boundaries", k, "box"),
					   "holds no node of the grid, expected one at least (cells of %g m from "
					   "(%g, %g))",
					   grid->cell, grid->origin[0], grid->origin[1]);
		if (of_points && clean_element(loader, "boundaries", k))
			check_points_of_box(loader, k);
	}
}

static void check_stages(struct loader *loader)
{
	const struct scene *scene = loader->scene;
	char path[PATH_LENGTH];
	double sum = 0.0;
	if (!loader_clean(loader, "stages"))
		return;
	for (int k = 0; k < scene->n_stages; k++) {
		sum += scene->stages[k].duration;
		if (k + 1 < scene->n_stages && isinf(scene->stages[k].duration))
			problem_of(loader, path_to(path, "stages", k, "duration"),
					   "is missing, expected a number > 0 (s): only the last stage may go "
					   "on until time.end");
	}
	if (scene->n_stages && loader_clean(loader, "time") && sum < scene->time.end * (1.0 - 1e-9))
		problem_of(loader, path_to(path, "stages", scene->n_stages - 1, "duration"),
				   "ends the stages at %g s, before time.end = %g s, expected none for the last stage, or a longer one",
				   sum, scene->time.end);
}

/* Bonds need a law that describes them and a stage that installs them (and ends: not the last). */
static void check_installing(struct loader *loader)
{
	const struct scene *scene = loader->scene;
	char path[PATH_LENGTH];
	int stage = -1, law = -1;
	if (!loader_clean(loader, "stages") || !loader_clean(loader, "laws") || !loader_clean(loader, "materials"))
		return;
	for (int k = scene->n_stages - 1; k >= 0; k--)
		stage = scene->stages[k].then_install_bonds ? k : stage;
	for (int k = scene->n_laws - 1; k >= 0; k--)
		law = scene->laws[k].type == SCENE_LAW_RVE && bonds_of(loader, k) ? k : law;
	if (stage >= 0 && law < 0)
		problem_of(loader, path_to(path, "stages", stage, "then"),
				   "installs bonds, expected a law of type \"rve\" with bonds = { strength = ...; }");
	else if (stage >= 0 && stage == scene->n_stages - 1)
		problem_of(loader, path_to(path, "stages", stage, "then"),
				   "installs bonds when the last stage ends, expected that of a stage before it");
	else if (stage < 0 && law >= 0 && scene->laws[law].rve.bonds.strength > 0.0)
		problem_at(loader, bonds_of(loader, law)->place, "bonds",
				   "of law '%s' are never installed, expected a stage with then = (\"install_bonds\"), or strength = 0",
				   scene->laws[law].name);
}

/* ---- what is recorded ---- */

static long all_points(const struct loader *loader)
{
	long n = 0;
	for (int b = 0; b < loader->scene->n_bodies; b++) {
		if (loader->n_points[b] < 0)
			return -1;
		n += loader->n_points[b];
	}
	return n;
}

static bool in_grid(const struct scene_grid *grid, const double at[2])
{
	return at[0] >= grid->origin[0] && at[0] <= grid->origin[0] + grid->size[0] && at[1] >= grid->origin[1] &&
		   at[1] <= grid->origin[1] + grid->size[1];
}

static bool in_a_body(const struct scene *scene, const double at[2])
{
	for (int b = 0; b < scene->n_bodies; b++)
		if (scene_body_contains(&scene->bodies[b], at, -TOUCHING * scene->grid.cell))
			return true;
	return false;
}

static void check_id(struct loader *loader, const char *path, long id)
{
	long n = all_points(loader);
	if (n >= 0 && id >= n)
		problem_of(loader, path, "is %ld, expected a point from 0 to %ld", id, n - 1);
}

static void check_probes(struct loader *loader)
{
	const struct scene *scene = loader->scene;
	const struct node *list = node_find(loader->root, "probes");
	char path[PATH_LENGTH];
	for (int k = 0; k < scene->n_probes; k++) {
		const struct scene_probe *probe = &scene->probes[k];
		const struct node *node = list->children[k];
		if (!clean_element(loader, "probes", k))
			continue;
		int said = !!node_find(node, "at") + !!node_find(node, "material") + !!node_find(node, "id");
		if (said != 1)
			problem_of(loader, path_to(path, "probes", k, ""),
					   "has %d places, expected one of at = [x, y], material = [x, y], id = n", said);
		else if (probe->kind == SCENE_PROBE_ID)
			check_id(loader, path_to(path, "probes", k, "id"), probe->id);
		else if (probe->kind == SCENE_PROBE_AT && loader_clean(loader, "grid") && !in_grid(&scene->grid, probe->at))
			problem_of(loader, path_to(path, "probes", k, "at"),
					   "is (%g, %g), outside the grid, expected a place in it", probe->at[0], probe->at[1]);
		else if (probe->kind == SCENE_PROBE_MATERIAL && all_points(loader) >= 0 && !in_a_body(scene, probe->at))
			problem_of(loader, path_to(path, "probes", k, "material"),
					   "is (%g, %g), in no body, expected a place in one", probe->at[0], probe->at[1]);
	}
}

static void check_regions(struct loader *loader)
{
	const struct scene *scene = loader->scene;
	char path[PATH_LENGTH];
	for (int k = 0; k < scene->n_regions; k++) {
		const struct scene_region *r = &scene->regions[k];
		if (!clean_element(loader, "regions", k))
			continue;
		if (r->min[0] >= r->max[0] || r->min[1] >= r->max[1])
			problem_of(loader, path_to(path, "regions", k, "box"), "has no area, expected [xmin, ymin, xmax, ymax]");
	}
}

/* The point of this number, or the one nearest to a place; NULL if there is none. */
static const double *find_point(const struct loader *loader, long id, const double at[2],
								const struct scene_body **body)
{
	const double *found = NULL;
	double nearest = INFINITY;
	for (int b = 0; b < loader->scene->n_bodies; b++) {
		const double(*x)[2] = (const double(*)[2])loader->points[b];
		int n = loader->n_points[b];
		if (id >= 0 && id < n) {
			*body = &loader->scene->bodies[b];
			return x[id];
		}
		for (int i = 0; id < 0 && i < n; i++) {
			double distance = hypot(x[i][0] - at[0], x[i][1] - at[1]);
			if (distance < nearest)
				nearest = distance, found = x[i], *body = &loader->scene->bodies[b];
		}
		id -= id >= 0 ? n : 0;
	}
	return found;
}

/* The law of that point, NULL if it cannot be told. */
static const struct scene_law *law_of_point(const struct loader *loader, long id, const double at[2])
{
	const struct scene *scene = loader->scene;
	const struct scene_body *body = NULL;
	const double *x = find_point(loader, id, at, &body);
	if (!x)
		return NULL;
	int layer = scene_body_layer(body, x[1]);
	int material = layer >= 0 ? body->layers[layer].material : body->material;
	int law = material >= 0 ? scene->materials[material].law : -1;
	char path[PATH_LENGTH];
	if (law < 0)
		return NULL;
	law_path(loader, law, path);
	return loader_clean(loader, "%s", path) ? &scene->laws[law] : NULL;
}

/* A rule needs something to choose from: bodies with RVEs, for broken bonds such with bonds. */
static void check_rule(struct loader *loader, const struct scene_inspect *inspect, const char *path)
{
	const struct scene *scene = loader->scene;
	bool bonds = !strcmp(inspect->rule, "most_broken"), found = false;
	if (!loader_clean(loader, "laws") || !loader_clean(loader, "materials") || !loader_clean(loader, "bodies"))
		return;
	for (int m = 0; m < scene->n_materials; m++) {
		const struct scene_law *law = scene->materials[m].law >= 0 ? &scene->laws[scene->materials[m].law] : NULL;
		found |= law && law->type == SCENE_LAW_RVE && (!bonds || law->rve.bonds.strength > 0.0);
	}
	if (!found)
		problem_of(loader, path, "has nothing to choose from, expected a law of type \"rve\"%s",
				   bonds ? " with bonds" : "");
}

static void check_inspect(struct loader *loader)
{
	const struct scene *scene = loader->scene;
	char path[PATH_LENGTH];
	for (int k = 0; k < scene->n_inspect; k++) {
		const struct scene_inspect *inspect = &scene->inspect[k];
		if (!clean_element(loader, "inspect", k))
			continue;
		bool at = !isnan(inspect->at[0]), id = inspect->id >= 0, rule = inspect->rule[0];
		path_to(path, "inspect", k, at ? "at" : id ? "id" : rule ? "rule" : "");
		if (at + id + rule != 1) {
			problem_of(loader, path, "has %s, expected one of at = [x, y], id = n, rule = \"hottest\"",
					   at + id + rule ? "two places" : "no place");
			continue;
		}
		if (rule) {
			check_rule(loader, inspect, path);
			continue;
		}
		if (all_points(loader) < 0)
			continue;
		if (at && !in_a_body(scene, inspect->at))
			problem_of(loader, path, "is (%g, %g), in no body, expected a place in one", inspect->at[0],
					   inspect->at[1]);
		if (!at)
			check_id(loader, path, inspect->id);
		if (!clean_element(loader, "inspect", k))
			continue;
		const struct scene_law *law = law_of_point(loader, inspect->id, inspect->at);
		if (law && law->type != SCENE_LAW_RVE)
			problem_of(loader, path, "is a point of law '%s', which has no RVE, expected one of a law of type \"rve\"",
					   law->name);
	}
}

static void check_images(struct loader *loader)
{
	static const char *const rve_fields[] = {"displacement", "rotation", "coordination", "temperature", "radius"};
	const struct scene *scene = loader->scene;
	const struct node *list = node_find(loader->root, "images");
	char path[PATH_LENGTH];
	for (int k = 0; k < scene->n_images; k++) {
		const struct scene_image *image = &scene->images[k];
		if (!clean_element(loader, "images", k))
			continue;
		if (node_find(list->children[k], "view") &&
			(image->view[0] >= image->view[2] || image->view[1] >= image->view[3]))
			problem_of(loader, path_to(path, "images", k, "view"), "has no area, expected [xmin, ymin, xmax, ymax]");
		struct node *rve = node_find(list->children[k], "rve");
		if (image->kind != SCENE_IMAGE_RVE) {
			if (rve)
				problem_at(loader, rve->place, path_to(path, "images", k, "rve"),
						   "is given for a picture of points, expected kind = \"rve\"");
			if (image->before)
				problem_of(loader, path_to(path, "images", k, "before"),
						   "is given for a picture of points, expected kind = \"rve\"");
			continue;
		}
		if (rve)
			read_reference(loader, rve, "inspect", path_to(path, "images", k, "rve"));
		else
			problem_of(loader, path_to(path, "images", k, "rve"), "is missing, expected a name in inspect");
		bool known = false;
		for (size_t f = 0; f < sizeof rve_fields / sizeof *rve_fields; f++)
			known |= !strcmp(image->field, rve_fields[f]);
		if (!known)
			problem_of(loader, path_to(path, "images", k, "field"),
					   "is \"%s\", expected a field of an RVE: displacement, rotation, coordination, temperature or "
					   "radius",
					   image->field);
	}
}

/* ---- contacts ---- */

static bool same_pair(const struct scene_contact *a, const struct scene_contact *b)
{
	return a->n_bodies == b->n_bodies &&
		   (a->n_bodies == 0 || (a->n_bodies == 1 && a->bodies[0] == b->bodies[0]) ||
			(a->n_bodies == 2 && ((a->bodies[0] == b->bodies[0] && a->bodies[1] == b->bodies[1]) ||
								  (a->bodies[0] == b->bodies[1] && a->bodies[1] == b->bodies[0]))));
}

static void check_contact(struct loader *loader, int k)
{
	const struct scene *scene = loader->scene;
	const struct scene_contact *contact = &scene->contacts[k];
	char path[PATH_LENGTH];
	if (contact->n_bodies == 2 && contact->bodies[0] == contact->bodies[1])
		problem_of(loader, path_to(path, "contacts", k, "bodies"), "names body '%s' twice, expected two bodies",
				   scene->bodies[contact->bodies[0]].name);
	for (int j = 0; j < k; j++)
		if (clean_element(loader, "contacts", j) && same_pair(contact, &scene->contacts[j]))
			problem_of(loader, path_to(path, "contacts", k, "bodies"),
					   "is the same pair as contacts.[%d], expected one contact for a pair", j);
	if (!scene->thermal.on && (contact->conductance > 0.0 || !isnan(contact->softening[0])))
		problem_of(loader, path_to(path, "contacts", k, contact->conductance > 0.0 ? "conductance" : "softening"),
				   "is given in a scene without heat, expected thermal.on = true");
}

static void check_contacts(struct loader *loader)
{
	const struct scene *scene = loader->scene;
	if (scene->n_contacts == 0)
		return;
	for (int k = 0; k < scene->n_contacts; k++)
		if (clean_element(loader, "contacts", k))
			check_contact(loader, k);
	if (!loader_clean(loader, "time") || !loader_clean(loader, "mpm"))
		return;
	/* heat that waits belongs to a field, and the next step may have others */
	if (scene->thermal.on && scene->time.thermal_every > 1)
		problem_of(
			loader, "time.thermal_every",
			"is %d, but with contacts heat flows in every step, expected 1, and thermal.time_scale for slow heat",
			scene->time.thermal_every);
	if (scene->mpm.confining_pressure > 0.0)
		problem_of(
			loader, "mpm.confining_pressure",
			"is %g Pa, but where bodies meet there is no telling which surface is free, expected 0 with contacts",
			scene->mpm.confining_pressure);
}

void check_scene(struct loader *loader)
{
	struct scene *scene = loader->scene;
	loader->n_points = loader_alloc(loader, ((size_t)scene->n_bodies + 1) * sizeof *loader->n_points);
	loader->points = loader_alloc(loader, ((size_t)scene->n_bodies + 1) * sizeof *loader->points);
	check_names(loader);
	if (loader_clean(loader, "grid"))
		check_grid(loader);
	if (loader_clean(loader, "time"))
		check_time(loader);
	if (loader_clean(loader, "mpm"))
		check_transfer(loader);
	check_laws(loader);
	check_cracks(loader);
	check_materials(loader);
	check_stages(loader);
	check_installing(loader);
	check_bodies(loader);
	check_walls(loader);
	check_follow(loader);
	check_boundaries(loader);
	check_contacts(loader);
	check_probes(loader);
	check_regions(loader);
	check_inspect(loader);
	check_images(loader);
}
