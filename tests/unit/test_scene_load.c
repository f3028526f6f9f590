/* What a scene file becomes: defaults, units, includes, variants, overrides, its text. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "../common/near.h"
#include "scene/compare.h"
#include "scene/scene.h"

/* ---- scenes in a folder of their own ---- */

static char folder[] = "/tmp/test_scene_load_XXXXXX";

static const char *put(const char *name, const char *text)
{
	static char path[8][256];
	static int turn;
	char *p = path[turn = (turn + 1) % 8];
	snprintf(p, sizeof path[0], "%s/%s", folder, name);
	FILE *out = fopen(p, "w");
	assert_non_null(out);
	fputs(text, out);
	fclose(out);
	return p;
}

static int make_folder(void **state)
{
	(void)state;
	char sub[64];
	if (!mkdtemp(folder))
		return -1;
	snprintf(sub, sizeof sub, "%s/parts", folder);
	return mkdir(sub, 0755);
}

static int remove_folder(void **state)
{
	(void)state;
	char command[128];
	snprintf(command, sizeof command, "rm -r %s", folder);
	return system(command);
}

static struct scene *load(const char *path, int n, const char *const *sets)
{
	struct scene *scene;
	assert_int_equal(scene_load(&scene, path, n, sets, stderr), 0);
	return scene;
}

#define LOAD(path, ...)                                                                                                \
	load(path, (int)(sizeof(const char *[]){__VA_ARGS__} / sizeof(char *)), (const char *[]){__VA_ARGS__})

static const char small[] =
	"units = { temperature = \"C\"; };\n"
	"grid = { origin = [0, 0]; size = [2, 1.0]; cell = 0.1; };\n"
	"time = { end = 2; step = 1e-4; };\n"
	"materials = ( { name = \"m\"; density = 1000; heat_capacity = 500; conductivity = 2;\n"
	"	law = { type = \"thermoelastic\"; young = 1000000; poisson = 0.25; }; } );\n"
	"bodies = ( { name = \"b\"; material = \"m\"; box = [0.5, 0.3, 1.0, 0.6]; temperature = 25; } );\n"
	"walls = ( { name = \"ground\"; line = ([0, 0.3], [2, 0.3]); },\n"
	"	{ name = \"roof\"; box = [0.5, 0.6, 1.0, 0.8]; friction = 0.3; } );\n";

/* ---- defaults and units ---- */

static void defaults_are_filled_in(void **state)
{
	(void)state;
	struct scene *s = load(put("small.cfg", small), 0, NULL);
	assert_true(s->grid.thickness == 1.0 && s->grid.size[0] == 2.0);
	assert_string_equal(s->mpm.shape, "ugimp");
	assert_true(s->thermal.on && s->thermal.friction_heat);
	assert_true(s->bodies[0].temperature == 298.15);
	assert_int_equal(s->bodies[0].points_per_cell, 4);
	assert_true(isnan(s->bodies[0].lattice_origin[0]));
	assert_true(s->walls[0].depth == 0.2 && isinf(s->walls[0].until) && isnan(s->walls[0].temperature));
	assert_int_equal(s->walls[0].shape, SCENE_WALL_LINE);
	assert_int_equal(s->walls[1].shape, SCENE_WALL_POLYGON);
	assert_int_equal(s->walls[1].place.line, 8);
	assert_true(s->output.history_every == 0.01 && s->output.snapshot_every == 0.1);
	assert_string_equal(s->laws[s->materials[0].law].name, "m");
	assert_true(isnan(s->materials[0].reference_temperature));
	assert_true(scene_temperature_out(s, 300.0) == 300.0 - 273.15 && scene_temperature_in(s, 0.0) == 273.15);
	assert_string_equal(scene_temperature_unit(s), "C");
	scene_free(s);
}

/* Temperatures of all sorts come in the scene's unit; tables are linear between their rows and held outside. */
static void heat_is_read(void **state)
{
	(void)state;
	struct scene *s =
		LOAD(put("small.cfg", small), "materials.m.freezing = [-0.5, 0]", "materials.m.latent_heat = 5e4",
			 "walls.roof.temperature_table = ([1, 10], [2, 20], [4, 0])", "bodies.b.temperature_gradient = [0, -2]",
			 "boundaries.[0] = { name = \"air\"; box = [0.5, 0.3, 0.6, 0.6]; convection = { coefficient = 5; "
			 "ambient_table = ([0, 0], [1, 30]); }; flux_table = ([0, 1], [1, 3]); }");
	const struct scene_material *m = &s->materials[0];
	assert_true(m->freezing[0] == 272.65 && m->freezing[1] == 273.15 && m->latent_heat == 5e4);
	assert_true(m->heat_capacity_frozen == 500.0 && isnan(m->conductivity_frozen));
	assert_true(s->thermal.time_scale == 1.0);
	const double at[][2] = {{0.0, 10.0}, {1.0, 10.0}, {1.5, 15.0}, {2.0, 20.0}, {3.0, 10.0}, {4.0, 0.0}, {9.0, 0.0}};
	const struct scene_wall *roof = &s->walls[1];
	for (size_t k = 0; k < sizeof at / sizeof *at; k++)
		assert_near(scene_value_at(roof->temperature, &roof->temperature_table, at[k][0]), 273.15 + at[k][1], 1e-12);
	assert_true(scene_value_at(7.0, &s->walls[0].temperature_table, 1.0) == 7.0);
	assert_true(scene_wall_heats(roof) && !scene_wall_heats(&s->walls[0]));
	const struct scene_boundary *air = &s->boundaries[0];
	assert_true(scene_boundary_heats_points(air) && !scene_boundary_heats_nodes(air));
	assert_near(scene_value_at(air->convection.ambient, &air->convection.ambient_table, 0.5), 288.15, 1e-12);
	assert_near(scene_value_at(air->flux, &air->flux_table, 0.5), 2.0, 1e-12); /* W/m2, no temperature */
	assert_near(scene_body_warming(&s->bodies[0], (const double[2]){0.9, 0.5}), -0.4, 1e-12);
	scene_free(s);
}

static void rve_defaults_are_those_of_the_paper(void **state)
{
	(void)state;
	struct scene *s =
		LOAD(put("small.cfg", small), "materials.[0].law = { type = \"rve\"; packing = { pressure = 1e5; }; }");
	const struct scene_law_rve *rve = &s->laws[0].rve;
	assert_int_equal(s->laws[0].type, SCENE_LAW_RVE);
	assert_int_equal(rve->packing.discs, 400);
	assert_true(rve->packing.radius_min == 0.25e-3 && rve->packing.radius_max == 0.5e-3);
	assert_true(rve->packing.pressure == 1e5 && isnan(rve->packing.void_ratio));
	assert_string_equal(rve->packing.lattice, "");
	assert_string_equal(rve->packing.file, "");
	assert_int_equal(rve->packing.seed, 1);
	assert_true(rve->kn == 1e6 && rve->ks == 1e6 && rve->mu == 0.5 && rve->damping_ratio == 0.2);
	assert_true(rve->grain_density == 2650.0 && rve->disc_thickness == 0.075 && rve->expansion == 1e-4);
	assert_true(rve->resistance == 1e4 && rve->step_factor == 0.4 && rve->strain_per_step == 5e-5);
	assert_true(rve->pressure_scaling && rve->n_max == 20 && rve->skin == 0.2);
	assert_true(rve->gas && rve->gas_pressure == 20.0 && rve->gas_stretch == 1.12 && rve->overlap_max == 0.5);
	scene_free(s);
}

static void polygons_are_turned_counter_clockwise(void **state)
{
	(void)state;
	struct scene *s = LOAD(put("small.cfg", small),
						   "bodies = ({name=\"b\"; material=\"m\"; polygon=((0.5,0.3),(0.5,0.6),[1,0.3]);})");
	const struct scene_body *b = &s->bodies[0];
	assert_int_equal(b->n_vertices, 3);
	double area = 0.0;
	for (int k = 0; k < 3; k++)
		area += b->vertices[k][0] * b->vertices[(k + 1) % 3][1] - b->vertices[(k + 1) % 3][0] * b->vertices[k][1];
	assert_true(fabs(area - 0.15) < 1e-15);
	scene_free(s);
}

/* ---- includes and variants ---- */

static void includes_are_found_beside_their_file(void **state)
{
	(void)state;
	put("parts/law.cfg", "law = { type = \"thermoelastic\"; young = 3e6;\n@include \"deeper.cfg\" // twice nested\n};");
	put("parts/deeper.cfg", "\xef\xbb\xbfpoisson = 0.1;\r\n");
	const char *path =
		put("includes.cfg", "grid = { origin = [0, 0]; size = [2, 1]; cell = 0.1; };\n"
							"time = { end = 1; step = 1e-4; };\n"
							"materials = (\n	{\n		name = \"m\"; density = 1e3;\n"
							"		@include \"parts/law.cfg\"\n	}\n);\n"
							"bodies = ( { name = \"b\"; material = \"m\"; box = [0.5, 0.3, 1.0, 0.6]; } );\n");
	assert_int_equal(chdir("/"), 0); /* wherever one stands */
	struct scene *s = load(path, 0, NULL);
	assert_true(s->laws[0].thermoelastic.young == 3e6 && s->laws[0].thermoelastic.poisson == 0.1);
	assert_int_equal(s->bodies[0].place.line, 9);
	assert_false(s->thermal.on);
	scene_free(s);
}

static void variants_chain(void **state)
{
	(void)state;
	put("small.cfg", small);
	put("parts/one.cfg", "base = \"../small.cfg\";\nset = (\"grid.cell = 0.05\", \"walls.roof.friction=0.4\");\n");
	const char *two = put(
		"two.cfg", "title = \"two\"; base = \"parts/one.cfg\"; set = (\"walls.[0].friction = 0.5\", \"time.end=1\");");
	struct scene *s = load(two, 0, NULL);
	assert_string_equal(s->title, "two");
	assert_true(s->grid.cell == 0.05 && s->walls[1].friction == 0.4 && s->walls[0].friction == 0.5);
	assert_true(s->time.end == 1.0 && s->output.snapshot_every == 0.05);
	assert_true(s->walls[0].depth == 0.1);
	scene_free(s);
}

static void overrides_come_last(void **state)
{
	(void)state;
	put("small.cfg", small);
	const char *v = put("v.cfg", "base = \"small.cfg\"; set = (\"grid.cell = 0.05\");");
	struct scene *s = LOAD(v, "grid.cell=0.025", "grid.thickness=2", "title=no quotes = needed", "mpm.shape=linear",
						   "bodies.[0].velocity.[1] = -1.5", "walls.[2]={name=\"new\"; wedge=[0.0, 0.3, 0.2, 0.2];}",
						   "gravity=[0, -9.81]", "stages = ({ name = \"only\"; walls = (\"new\"); })",
						   "units.temperature = K", "bodies.b.temperature = 300",
						   "images=({name=\"i\"; field=\"velocity\"; component=\"y\"; range=(0, 1.5);})");
	assert_true(s->grid.cell == 0.025 && s->grid.thickness == 2.0 && s->gravity[1] == -9.81 && s->gravity[0] == 0.0);
	assert_string_equal(s->title, "no quotes = needed");
	assert_string_equal(s->mpm.shape, "linear");
	assert_true(s->bodies[0].velocity[1] == -1.5 && s->bodies[0].velocity[0] == 0.0 &&
				s->bodies[0].temperature == 300.0);
	assert_int_equal(s->n_walls, 3);
	assert_int_equal(s->walls[2].n_vertices, 3);
	assert_int_equal(s->stages[0].n_walls, 1);
	assert_int_equal(s->stages[0].walls[0], 2);
	assert_int_equal(s->images[0].component, 1);
	assert_true(!s->images[0].range_auto && s->images[0].range[1] == 1.5);
	assert_string_equal(s->walls[2].place.file, "--set walls.[2]={name=\"new\"; wedge=[0.0, 0.3, 0.2, 0.2];}");
	scene_free(s);
}

static void inactive_walls_are_left_out(void **state)
{
	(void)state;
	struct scene *s = LOAD(put("small.cfg", small), "walls.ground.active=false",
						   "stages=({name=\"a\"; walls=(\"ground\", \"roof\");})");
	assert_int_equal(s->n_walls, 1);
	assert_string_equal(s->walls[0].name, "roof");
	assert_int_equal(s->stages[0].n_walls, 1);
	assert_int_equal(s->stages[0].walls[0], 0);
	scene_free(s);
}

/* libconfig 1.5 alone would read 3000000000 as -1294967296, and refuse [0, 1.5]. */
static void numbers_keep_their_value(void **state)
{
	(void)state;
	struct scene *s =
		LOAD(put("small.cfg", small), "materials.[0].law.young=3000000000", "materials.[0].density=0x7fffffff",
			 "time.step=1e-5", "grid.origin=[0, -0.0]", "materials.[0].conductivity=9000000000L");
	assert_true(s->laws[0].thermoelastic.young == 3e9 && s->materials[0].density == 2147483647.0);
	assert_true(s->materials[0].conductivity == 9e9);
	scene_free(s);
}

/* ---- the scene's text ---- */

static void text_says_the_same(void **state)
{
	(void)state;
	put("packing.csv", "# H 1 0 0 1\nid,x,y,r\n0,0,0,0.1\n");
	put("small.cfg", small);
	const char *v = put("v.cfg", "base = \"small.cfg\"; title = \"a \\\"b\\\" \\\\ \xc3\xa4\";\n"
								 "set = (\"gravity=[0.0, -9.8]\", \"gravity.[0]=3\", "
								 "\"grid.thickness=0.1234567890123456789\", \"materials.[0].density=3000000000\",\n"
								 "\"materials.[1]={name=\\\"n\\\"; heat_capacity=1; law={type=\\\"rve\\\"; "
								 "packing={file=\\\"packing.csv\\\";};};}\");");
	struct scene *a = load(v, 0, NULL);
	char *text = strdup(a->text), away[128];
	snprintf(away, sizeof away, "%s/packing.csv", folder);
	assert_string_equal(a->laws[1].rve.packing.file, away);
	struct scene *b = load(put("parts/again.cfg", text), 0, NULL);
	assert_string_equal(text, b->text);
	char what[256];
	assert_int_equal(scene_compare(text, text, what, sizeof what), 1); /* libconfig itself can read it */
	assert_true(b->gravity[0] == 3.0 && b->gravity[1] == -9.8);
	assert_string_equal(a->title, b->title);
	assert_true(a->grid.thickness == b->grid.thickness && a->materials[0].density == b->materials[0].density);
	assert_string_equal(b->laws[1].rve.packing.file, away);
	free(text);
	scene_free(a);
	scene_free(b);
}

/* ---- the scenes of the tree ---- */

static void scenes_of_the_tree_load(void **state)
{
	(void)state;
	static const struct {
		const char *name;
		int points, walls;
	} scenes[] = {
		{"silo_forced", 1088, 4}, {"silo_free", 1088, 3}, {"silo_forced_quick", 268, 4}, {"column_quick", 200, 3}};
	for (size_t k = 0; k < sizeof scenes / sizeof *scenes; k++) {
		char path[512];
		snprintf(path, sizeof path, SOURCE_DIR "/scenarios/tm_dempm/%s.cfg", scenes[k].name);
		struct scene *s = load(path, 0, NULL);
		double(*x)[2];
		int n;
		assert_int_equal(scene_body_points(s, &s->bodies[0], &x, &n), 0);
		free(x);
		assert_int_equal(n, scenes[k].points);
		assert_int_equal(s->n_walls, scenes[k].walls);
		assert_int_equal(s->laws[0].rve.packing.discs, 400);
		assert_true(s->thermal.on);
		scene_free(s);
	}
}

static void presets_load(void **state)
{
	(void)state;
	static const char *const presets[] = {
		"quartz_sand_dense", "quartz_sand_loose", "steel", "rock", "aluminium", "polymer"};
	for (size_t k = 0; k < sizeof presets / sizeof *presets; k++) {
		char text[2048];
		snprintf(text, sizeof text,
				 "grid = { origin = [0, 0]; size = [2, 1]; cell = 0.1; }; time = { end = 1e-3; step = 1e-6; };\n"
				 "materials = ( { name = \"m\";\n@include \"" SOURCE_DIR "/scenarios/materials/%s.cfg\"\n} );\n"
				 "bodies = ( { name = \"b\"; material = \"m\"; box = [0.5, 0.3, 1.0, 0.6]; } );\n",
				 presets[k]);
		struct scene *s = load(put("preset.cfg", text), 0, NULL);
		assert_true(s->thermal.on);
		scene_free(s);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(defaults_are_filled_in),
		cmocka_unit_test(heat_is_read),
		cmocka_unit_test(rve_defaults_are_those_of_the_paper),
		cmocka_unit_test(polygons_are_turned_counter_clockwise),
		cmocka_unit_test(includes_are_found_beside_their_file),
		cmocka_unit_test(variants_chain),
		cmocka_unit_test(overrides_come_last),
		cmocka_unit_test(inactive_walls_are_left_out),
		cmocka_unit_test(numbers_keep_their_value),
		cmocka_unit_test(text_says_the_same),
		cmocka_unit_test(scenes_of_the_tree_load),
		cmocka_unit_test(presets_load),
	};
	return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
