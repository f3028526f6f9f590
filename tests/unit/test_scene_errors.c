/* Wrong scenes: every message names file and line, says what is wrong and what was expected, and one slip gives
 * one message.  A case replaces one piece of a good scene; the message is due on the line of the replacement. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#define TEMPORARY_FILE "/tmp/test_scene_errors_XXXXXX" /* for temporary_file.h */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "../common/temporary_file.h"
#include "base/error.h"
#include "scene/scene.h"

static const char good[] =
	"units = { temperature = \"C\"; };\n"
	"grid = {\n"
	"	origin = [0, 0];\n"
	"	size = [2, 1.0];\n"
	"	cell = 0.1;\n"
	"};\n"
	"time = {\n"
	"	end = 2;\n"
	"	step = 1e-4;\n"
	"};\n"
	"mpm = { shape = \"ugimp\"; };\n"
	"laws = ( { name = \"law\"; type = \"thermoelastic\"; young = 1e6; poisson = 0.25; } );\n"
	"materials = (\n"
	"	{ name = \"m\"; law = \"law\"; density = 1000; heat_capacity = 500; conductivity = 2; },\n"
	"	{ name = \"g\"; heat_capacity = 500; law = { type = \"rve\"; packing = { pressure = 1e4; }; }; }\n"
	");\n"
	"bodies = (\n"
	"	{ name = \"b\"; material = \"m\"; box = [0.5, 0.3, 1.0, 0.6]; temperature = 25; },\n"
	"	{ name = \"c\"; material = \"g\"; polygon = ([1.2, 0.3], [1.6, 0.3], [1.4, 0.7]); }\n"
	");\n"
	"walls = (\n"
	"	{ name = \"ground\"; line = ([0, 0.3], [2, 0.3]); friction = 0.5; },\n"
	"	{ name = \"roof\"; box = [0.5, 0.6, 1.0, 0.8]; }\n"
	");\n"
	"boundaries = ( { name = \"hot\"; box = [0.5, 0.3, 1.0, 0.3]; temperature = 50; } );\n"
	"stages = ( { name = \"s\"; duration = 1.0; walls = (\"ground\"); }, { name = \"t\"; } );\n"
	"probes = ( { name = \"p\"; at = [0.7, 0.5]; } );\n"
	"regions = ( { name = \"r\"; box = [0.0, 0.0, 1.0, 1.0]; } );\n"
	"inspect = ( { name = \"i\"; at = [1.4, 0.4]; } );\n"
	"output = { snapshot_every = 0.5; };\n"
	"images = (\n"
	"	{ name = \"T\"; field = \"temperature\"; range = [10.0, 50.0]; },\n"
	"	{ name = \"R\"; kind = \"rve\"; rve = \"i\"; field = \"radius\"; }\n"
	");\n";

static const struct {
	const char *old, *new, *message;
} wrong[] = {
	/* syntax and literals */
	{"cell = 0.1;", "cell = ;", "syntax error, expected name = value;"},
	{"cell = 0.1;", "cell 0.1;", "'cell' is no value, expected a number, true, false, a \"string\" or name = value"},
	{"cell = 0.1;", "cell = 0.1; cell = 0.2;", "'cell' is defined twice, expected once (first at"},
	{"cell = 0.1;", "cell = 0.1x;", "'0.1x' is no number"},
	{"cell = 0.1;", "cell = nan;", "'nan' is no value"},
	{"cell = 0.1;", "cell = 1e999;", "grid.cell is inf, expected a finite number: a number > 0 (m)"},
	{"cell = 0.1;", "cell = 99999999999999999999;", "integer 99999999999999999999 does not fit 64 bits"},
	{"\"ugimp\"; };", "\"ugimp; };", "a string is not closed on its line, expected '\"'"},
	{"mpm = { shape", "mpm = { @include \"x\" shape", "@include is not understood, expected a line of its own"},
	{"cell = 0.1;", "\n@include \"nothing.cfg\"\n", "nothing.cfg' (No such file or directory), expected a scene file"},
	{"cell = 0.1;", "cell = 0.1; )", "')' closes the '{' of"},
	{"cell = 0.1;", "cell = 0.1; /* and so on", "a comment is not closed, expected '*/'"},
	{"cell = 0.1;", "cell = 0.1; \x01", "byte 0x01 has no meaning here"},
	{"(\"ground\")", "(\"ground\",)", "',' before ')', expected a value or no comma"},
	{"temperature = 25;", "velocity = [1, 0]; motion = { solution = \"periodic\"; };",
	 "bodies.[0].velocity is given with a motion, expected one of the two"},
	{"[1.4, 0.7]); }",
	 "[1.4, 0.7]); motion = { solution = \"periodic\"; parameters = (\"phase_x=1\"); force = false; }; }",
	 "bodies.[1].motion begins with a deformation of law 'g', expected one of type"},
	{"[1.4, 0.7]); }", "[1.4, 0.7]); motion = { solution = \"periodic\"; }; }",
	 "bodies.[1].motion is imposed on law 'g', expected one of type \"thermoelastic\", or force = false"},
	/* keys and types */
	{"cell = 0.1;", "cel = 0.1;", "grid.cel is not known, expected another key (did you mean 'cell'?)"},
	{"mpm = { shape", "mmp = { shape", "mmp is not known, expected another key (did you mean 'mpm'?)"},
	{"young = 1e6", "young = 1e6; stiffness = 3",
	 "laws.[0].stiffness is not known, expected one of name, type, young,"},
	{"cell = 0.1;", "cell = \"small\";", "grid.cell is a string, expected a number > 0 (m)"},
	{"[2, 1.0]", "[2, 1.0, 3]", "grid.size has 3 values, expected two numbers [x, y] > 0 (m)"},
	{"[2, 1.0]", "2", "grid.size is an integer, expected two numbers [x, y] > 0 (m)"},
	{"friction = 0.5", "friction = true", "walls.[0].friction is true/false, expected a number from 0 to 100"},
	{"mpm = { shape = \"ugimp\"; };", "mpm = 3;", "mpm is an integer, expected a group { ... }"},
	{"shape = \"ugimp\"", "shape = \"gimp\"", "mpm.shape is \"gimp\", expected one of \"ugimp\", \"linear\", \"cpdi\""},
	{"laws = ( {", "laws = ( 5, {", "laws.[0] is an integer, expected a group { ... }"},
	{"name = \"roof\"", "name = \"the roof\"", "is \"the roof\", expected a name of letters, digits, _ and -"},
	{"type = \"thermoelastic\"", "type = \"elastic\"",
	 "laws.[0].type is \"elastic\", expected one of \"thermoelastic\", \"rve\""},
	{"type = \"rve\";", "", "materials.[1].law has no type, expected \"thermoelastic\", \"rve\" or \"neohookean_rankine\""},
	{"pressure = 1e4;", "pressure = 1e4; discs = 400.0;",
	 "packing.discs is a number, expected an integer from 16 to 16000"},
	{"pressure = 1e4;", "pressure = 1e4; seed = -1;", "packing.seed is -1, expected an integer from 0 to 4294967295"},
	/* missing */
	{"density = 1000;", "", "materials.[0].density is missing, expected a number > 0 (kg/m3)"},
	{"heat_capacity = 500; law", "law", "materials.[1].heat_capacity is missing though heat is on"},
	{"pressure = 1e4;", "", "materials.[1].law.packing.pressure is missing"},
	{"box = [0.5, 0.6, 1.0, 0.8];", "", "walls.[1] has no shape, expected line, box, polygon or wedge"},
	/* impossible numbers */
	{"density = 1000", "density = -1000", "materials.[0].density is -1000, expected a number > 0 (kg/m3)"},
	{"poisson = 0.25", "poisson = 0.5", "laws.[0].poisson is 0.5, expected a number between -1 and 0.5"},
	{"step = 1e-4", "step = 0", "time.step is 0, expected a number > 0 (s)"},
	{"end = 2;", "end = 1e-5;", "time.end is 1e-05 s, expected at least one step of 0.0001 s"},
	{"step = 1e-4", "step = 3e-3", "time.step is 0.003 s, over the limit of material 'm', expected at most 0.002887 s"},
	{"temperature = 25", "temperature = -300",
	 "bodies.[0].temperature is -300, below absolute zero, expected at least -273.15 C"},
	{"size = [2, 1.0];", "size = [2, 1.03];",
	 "grid.size is 1.03 m in y, expected a whole number of cells of 0.1 m, such as 1"},
	{"temperature = 25;", "points_per_cell = 5;", "bodies.[0].points_per_cell is 5, expected 1, 4, 9 or 16"},
	{"pressure = 1e4;", "pressure = 1e4; radius_min = 1e-3;",
	 "packing.radius_min is 0.001 m, expected at most radius_max = 0.0005 m"},
	{"pressure = 1e4;", "pressure = 1e4; lattice = \"square\"; discs = 300;",
	 "packing.discs is 300 on a square lattice, expected a square number such as 289"},
	/* geometry */
	{"[0.5, 0.3, 1.0, 0.6]", "[0.05, 0.3, 1.0, 0.6]",
	 "bodies.[0].box reaches x = 0.05 m, outside the grid, expected 0.1 to 1.9 m"},
	{"[0.5, 0.3, 1.0, 0.6]", "[0.51, 0.31, 0.52, 0.32]",
	 "bodies.[0].box holds no point of the lattice (spacing 0.05 m)"},
	{"[0.5, 0.3, 1.0, 0.6]", "[1.0, 0.3, 0.5, 0.6]", "bodies.[0].box has xmin = 1 > xmax = 0.5"},
	{"[1.4, 0.7]", "[1.4, 0.7], [1.2, 0.7], [1.6, 0.35]", "bodies.[1].polygon cuts or touches itself near"},
	{", [1.4, 0.7]", "", "bodies.[1].polygon has 2 corners, expected at least 3"},
	{"[1.4, 0.7]", "[1.8, 0.3]", "bodies.[1].polygon cuts or touches itself"},
	{"[1.2, 0.3], [1.6, 0.3]", "[0.8, 0.3], [1.6, 0.3]", "bodies.[1].polygon overlaps body 'b', for instance at"},
	{"([0, 0.3], [2, 0.3])", "([0, 0.3], [0, 0.3])", "walls.[0].line has no length, expected two different points"},
	{"[0.5, 0.3, 1.0, 0.3]", "[0.52, 0.32, 0.58, 0.38]", "boundaries.[0].box holds no node of the grid"},
	{"temperature = 50", "from = 1", "boundaries.[0] imposes nothing"},
	{"temperature = 50", "flux = 50", "boundaries.[0].box holds no point at the start to be heated"},
	{"friction = 0.5", "from = 1; until = 0.5", "walls.[0].until is 0.5 s, expected more than from = 1 s"},
	/* heat */
	{"conductivity = 2;", "conductivity = 2; latent_heat = 5;",
	 "materials.[0].latent_heat is given though the material does not freeze, expected freezing ="},
	{"conductivity = 2;", "conductivity = 2; freezing = [1.0, 0.0];",
	 "materials.[0].freezing falls, expected two temperatures"},
	{"conductivity = 2;", "conductivity = 2; freezing = [-300.0, 0.0];",
	 "materials.[0].freezing holds -300, below absolute zero, expected at least -273.15 C"},
	{"conductivity = 2;", "conductivity = 2; freezing = -1.0;", "materials.[0].freezing is a number, expected two"},
	{"temperature = 50", "temperature_table = ([0.0, 50.0])",
	 "boundaries.[0].temperature_table has 1 row, expected rows ([s, value], [s, value], ...), two at least"},
	{"temperature = 50", "temperature_table = ([0.0, 50.0], [0.0, 60.0])",
	 "boundaries.[0].temperature_table goes from 0 s to 0 s, expected rows"},
	{"temperature = 50", "temperature_table = ([0.0, 50.0], [1.0, -300.0])",
	 "boundaries.[0].temperature_table holds -300, below absolute zero"},
	{"temperature = 50", "temperature = 50; temperature_table = ([0, 50], [1, 60])",
	 "boundaries.[0].temperature is given beside boundaries.[0].temperature_table, expected one of the two"},
	{"temperature = 50", "convection = { coefficient = 5; }", "boundaries.[0].convection has no ambient"},
	{"temperature = 50", "convection = { ambient = 5; }", "boundaries.[0].convection has no coefficient"},
	{"friction = 0.5", "temperature = 5; temperature_table = ([0, 50], [1, 60])",
	 "walls.[0].temperature is given beside walls.[0].temperature_table"},
	{"temperature = 25", "temperature_gradient = [-1e3, 0.0]",
	 "bodies.[0].temperature_gradient cools the body to -206.85 K at (1, 0.3), expected no temperature below"},
	{"mpm = { shape = \"ugimp\"; };", "thermal = { time_scale = 0; };",
	 "thermal.time_scale is 0, expected a number > 0"},
	/* references */
	{"law = \"law\"", "law = \"lav\"",
	 "materials.[0].law \"lav\" is not defined, expected a name in laws (did you mean \"law\"?)"},
	{"material = \"m\"", "material = \"steel\"",
	 "bodies.[0].material \"steel\" is not defined, expected a name in materials"},
	{"name = \"roof\"", "name = \"ground\"",
	 "walls.[1].name is \"ground\" again, expected a name of its own (first at"},
	{"walls = (\"ground\")", "walls = (\"grounds\")",
	 "stages.[0].walls \"grounds\" is not defined, expected a name in walls"},
	{"rve = \"i\"", "rve = \"k\"",
	 "images.[1].rve \"k\" is not defined, expected a name in inspect (did you mean \"i\"?)"},
	{"field = \"radius\"", "field = \"stress\"",
	 "images.[1].field is \"stress\", expected a field of an RVE"},
	/* the rest */
	{"duration = 1.0;", "", "stages.[0].duration is missing"},
	{"{ name = \"t\"; }", "{ name = \"t\"; duration = 0.5; }", "ends the stages at 1.5 s, before time.end = 2 s"},
	{"duration = 1.0;", "duration = 1.0; then = (\"explode\");",
	 "stages.[0].then holds \"explode\", expected a list of"},
	/* bonds */
	{"duration = 1.0;", "duration = 1.0; then = (\"install_bonds\");",
	 "stages.[0].then installs bonds, expected a law of type \"rve\" with bonds = {"},
	{"packing = { pressure = 1e4; };", "packing = { pressure = 1e4; }; bonds = { strength = 0.02; };",
	 "bonds of law 'g' are never installed, expected a stage with then = (\"install_bonds\"), or strength = 0"},
	{"packing = { pressure = 1e4; };", "packing = { pressure = 1e4; }; bonds = { strength = 0.2; };",
	 "materials.[1].law.bonds.strength is 0.2, expected less than skin = 0.2"},
	{"packing = { pressure = 1e4; };", "packing = { pressure = 1e4; }; bonds = { softening = \"linear\"; };",
	 "materials.[1].law.bonds.melting is missing, expected the temperature at which linear softening ends"},
	{"packing = { pressure = 1e4; };",
	 "packing = { pressure = 1e4; }; bonds = { softening = \"linear\"; melting = -5.0; };",
	 "materials.[1].law.bonds.reference is 0 C, expected less than melting = -5 C"},
	{"packing = { pressure = 1e4; };", "packing = { pressure = 1e4; }; bonds = { melting = -300.0; };",
	 "materials.[1].law.bonds.melting is -300, below absolute zero"},
	{"at = [0.7, 0.5]", "at = [0.7, 1.5]", "probes.[0].at is (0.7, 1.5), outside the grid"},
	{"at = [0.7, 0.5]", "material = [0.7, 0.8]", "probes.[0].material is (0.7, 0.8), in no body"},
	{"at = [0.7, 0.5]", "id = 99999", "probes.[0].id is 99999, expected a point from 0 to"},
	{"at = [0.7, 0.5]", "at = [0.7, 0.5]; id = 3", "probes.[0] has 2 places, expected one of"},
	{"at = [1.4, 0.4]", "at = [0.7, 0.5]", "inspect.[0].at is a point of law 'law', which has no RVE"},
	{"[10.0, 50.0]", "[50.0, 10.0]", "images.[0].range is [50, 10], expected min < max"},
	{"[0.0, 0.0, 1.0, 1.0]", "[0.0, 0.0, 1.0, 0.0]", "regions.[0].box has no area"},
	{"snapshot_every = 0.5", "snapshot_every = -0.5", "output.snapshot_every is -0.5, expected a number >= 0 (s)"},
	{"shape = \"ugimp\"", "transfer = \"pic\"",
	 "mpm.transfer is \"pic\", expected one of \"flip\", \"xpic\", \"fmpm\", \"apic\""},
	{"shape = \"ugimp\"", "order = \"last\"", "mpm.order is \"last\", expected one of \"usl\", \"usf\", \"musl\""},
	{"shape = \"ugimp\"", "xpic_order = 3",
	 "mpm.xpic_order is 3, but transfer is \"flip\", expected transfer = \"xpic\""},
	{"shape = \"ugimp\"", "transfer = \"xpic\"; xpic_order = 0", "mpm.xpic_order is 0, expected"},
	{"shape = \"ugimp\"", "transfer = \"apic\"; xpic_every = 5",
	 "mpm.xpic_every is 5, but transfer is \"apic\", expected transfer = \"xpic\""},
	{"shape = \"ugimp\"", "transfer = \"apic\"; pic_fraction = 0.1",
	 "mpm.pic_fraction is 0.1, but with transfer = \"apic\" no step is FLIP, expected 0"},
	{"shape = \"ugimp\"", "transfer = \"fmpm\"; pic_fraction = 0.1",
	 "mpm.pic_fraction is 0.1, but with transfer = \"fmpm\" no step is FLIP, expected 0, or xpic_every > 1"},
	{"shape = \"ugimp\"", "transfer = \"fmpm\"; order = \"musl\"; xpic_every = 4",
	 "mpm.xpic_every is 4, but FMPM in some steps only is unstable with order = \"musl\", expected 1"},
	{"shape = \"ugimp\"", "damping_particle = 2e4",
	 "mpm.damping_particle takes more than the whole velocity in one step"},
};

/* ---- helpers ---- */

/* `good` with one piece replaced; the line of the replacement. */
static int replace(const char *old, const char *new, char *text, size_t size)
{
	const char *at = strstr(good, old);
	if (!at)
		fail_msg("the good scene has no %s", old);
	int line = 1;
	for (const char *c = good; c < at; c++)
		line += *c == '\n';
	snprintf(text, size, "%.*s%s%s", (int)(at - good), good, new, at + strlen(old));
	return line;
}

/* The messages of a scene that must be refused. */
static char *refusal(int n_sets, const char *const *sets)
{
	char *messages = NULL;
	size_t size;
	struct scene *scene;
	FILE *out = open_memstream(&messages, &size);
	int status = scene_load(&scene, path, n_sets, sets, out);
	fclose(out);
	if (status != STATUS_INPUT || scene)
		fail_msg("status %d, expected %d: %s", status, STATUS_INPUT, messages);
	return messages;
}

/* ---- tests ---- */

static void the_good_scene_is_good(void **state)
{
	(void)state;
	struct scene *scene;
	write_file(good);
	assert_int_equal(scene_load(&scene, path, 0, NULL, stderr), 0);
	scene_free(scene);
}

static void one_slip_gives_one_message(void **state)
{
	(void)state;
	for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) {
		char text[4096], place[64];
		int line = replace(wrong[k].old, wrong[k].new, text, sizeof text);
		write_file(text);
		char *messages = refusal(0, NULL);
		line += wrong[k].new[0] == '\n';
		snprintf(place, sizeof place, "%s:%d: ", path, line);
		if (strncmp(messages, place, strlen(place)) || !strstr(messages, wrong[k].message) ||
			strchr(messages, '\n') != messages + strlen(messages) - 1)
			fail_msg("case %zu (%s): expected one message at %s%s, got\n%s", k, wrong[k].new, place, wrong[k].message,
					 messages);
		free(messages);
	}
}

/* Slips that are noticed on another line, or that have more than one consequence. */
static void expect(const char *old, const char *new, int n, const char *const *expected)
{
	char text[4096];
	replace(old, new, text, sizeof text);
	write_file(text);
	char *messages = refusal(0, NULL), *at = messages;
	for (int k = 0; k < n; k++) {
		char place[512];
		snprintf(place, sizeof place, "%s:%s", path, expected[k]);
		char *end = strchr(at, '\n');
		if (!end || strncmp(at, place, strlen(place)))
			fail_msg("expected %s, got\n%s", place, at);
		at = end + 1;
	}
	if (*at)
		fail_msg("not expected: %s", at);
	free(messages);
}

#define EXPECT(old, new, ...)                                                                                          \
	expect(old, new, (int)(sizeof(const char *[]){__VA_ARGS__} / sizeof(char *)), (const char *[]){__VA_ARGS__})

static void messages_elsewhere(void **state)
{
	(void)state;
	EXPECT("	cell = 0.1;\n", "", "2: grid.cell is missing, expected a number > 0 (m): edge of the square cells");
	EXPECT("conductivity = 2", "conductivity = 1e9",
		   "9: time.step makes thermal steps of 0.0001 s, over the limit of material 'm', expected at most 2.5e-06 s");
	EXPECT("conductivity = 2", "conductivity = 2; freezing = [0, 0]; conductivity_frozen = 1e9",
		   "9: time.step makes thermal steps of 0.0001 s, over the limit of material 'm', expected at most 2.5e-06 s");
	EXPECT("mpm = { shape = \"ugimp\"; };", "thermal = { time_scale = 3e10; };",
		   "9: time.step makes thermal steps of 3e+06 s, over the limit of material 'm', expected at most 1250 s");
	EXPECT("[0, 0.3], [2, 0.3]", "[2, 0.3], [0, 0.3]",
		   "22: walls.[0].line stands in body 'b' at the start: 40 of its points are in the solid",
		   "22: walls.[0].line stands in body 'c' at the start:");
	EXPECT("[0, 0.3], [2, 0.3]", "[0, 0.35], [2, 0.35]", "22: walls.[0].line stands in body 'b' at the start: 10 of",
		   "22: walls.[0].line stands in body 'c' at the start:");
	EXPECT("line = ([0, 0.3], [2, 0.3])", "polygon = ([0.0, 0.51], [2.0, 0.51], [2.0, 0.52], [0.0, 0.52])",
		   "22: walls.[0].polygon cuts body 'b' at the start near",
		   "22: walls.[0].polygon cuts body 'c' at the start near");
	EXPECT("grid = {", "goods = {", "1: grid is missing, expected a group { ... }: the background grid",
		   "2: goods is not known, expected one of title, units, grid");
	EXPECT("grid = {", "grd = {", "2: grd is not known, expected another key (did you mean 'grid'?)");
	EXPECT("cell = 0.1;", "", "2: grid.cell is missing");
	EXPECT("mpm = {", "mpm = {{", "11: '{' is never closed");
}

/* Keys that do not go together, however far apart they stand. */
static void opposites(void **state)
{
	(void)state;
	const char *sets[] = {"time.thermal_steps=4", "materials.m.freezing=[0, 0]"};
	write_file(good);
	char *messages = refusal(2, sets);
	assert_non_null(strstr(messages, "time.thermal_steps is 4 though material 'm' freezes, expected 1"));
	free(messages);
}

/* All errors of a file, in the order of its lines, whatever kind they are. */
static void all_errors_are_reported(void **state)
{
	(void)state;
	write_file(
		"grid = { origin = [0, 0]; size = [2, 1]; cell = 0.1; cell = 0.2;\n" /* twice */
		"	colour = 3; };\n"                                                /* unknown */
		"time = { end = 1; step = -1e-4; };\n"                               /* negative */
		"materials = ( { name = \"m\"; density = \"heavy\";\n"               /* type */
		"	law = { type = \"thermoelastic\"; young = 1e6;\n"                /* poisson missing */
		"	}; } );\n"
		"bodies = ( { name = \"b\"; material = \"m\"; box = [0.5, 0.3, 9.0, 0.6]; },\n" /* (hidden by the grid's) */
		"	{ name = \"b\"; material = \"n\"; box = [1.1, 0.3, 1.6]; } );\n"            /* three */
		"walls = ( { name = \"w\"; friction = -1; } );\n");
	const char *sets[] = {"walls.w.frction=3", "time.end"};
	char *messages = refusal(2, sets);
	static const char *const expected[] = {
		":1: 'cell' is defined twice",
		":2: grid.colour is not known",
		":3: time.step is -0.0001",
		":4: materials.[0].density is a string",
		":5: materials.[0].law.poisson is missing",
		":8: bodies.[1].material \"n\" is not defined",
		":8: bodies.[1].box has 3 values",
		":8: bodies.[1].name is \"b\" again",
		":9: walls.[0].friction is -1",
		"--set walls.w.frction=3: walls.w.frction is not known, expected a key of the "
		"scene such as walls.[].friction",
		"--set time.end: 'time.end' assigns nothing, expected path=value"};
	char *at = messages;
	for (size_t k = 0; k < sizeof expected / sizeof *expected; k++) {
		char *end = strchr(at, '\n'), *found = strstr(at, expected[k]);
		if (!end || !found || found > end)
			fail_msg("expected %s, got\n%s", expected[k], at);
		at = end + 1;
	}
	assert_string_equal(at, "");
	free(messages);
}

static void grid_that_follows(void **state)
{
	(void)state;
	static const char *const cases[][4] = {
		{"follow=\"roof\"", "fixed=[0, 0.3]", "[0, 0]",
		 "grid.follow is wall 'roof', which does not move, expected a wall with a velocity"},
		{"follow=\"rof\"", "fixed=[0, 0.3]", "[0, -1]",
		 "grid.follow \"rof\" is not defined, expected a name in walls (did you mean \"roof\"?)"},
		{"follow=\"roof\"", "fixed=[0, 0.33]", "[0, -1]", "grid.fixed is y = 0.33 m, between two rows of nodes"},
		{"follow=\"roof\"", "fixed=[0.5, 0]", "[-1, 0]", "grid.fixed is x = 0.5 m, on the face of wall 'roof'"},
	};
	for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
		char sets[3][64];
		const char *list[] = {sets[0], sets[1], sets[2]};
		snprintf(sets[0], sizeof sets[0], "grid.%s", cases[k][0]);
		snprintf(sets[1], sizeof sets[1], "grid.%s", cases[k][1]);
		snprintf(sets[2], sizeof sets[2], "walls.roof.velocity=%s", cases[k][2]);
		write_file(good);
		char *messages = refusal(3, list);
		if (!strstr(messages, cases[k][3]))
			fail_msg("expected %s, got\n%s", cases[k][3], messages);
		free(messages);
	}
}

static void wrong_overrides(void **state)
{
	(void)state;
	static const char *const cases[][2] = {
		{"grid.cel=0.1", "--set grid.cel=0.1: grid.cel is not known, expected a key of the scene such as grid.cell"},
		{"friction=0.1", "friction is not known, expected a key of the scene such as walls.[].friction"},
		{"cell=0.1", "cell is not known, expected a key of the scene such as grid.cell"},
		{"walls.[2].friction=0.1", "walls has no entry '[2]', expected [0] to [1] or the name of one"},
		{"walls.[-1].friction=0.1", "walls has no entry '[-1]', expected [0] to [1] or the name of one"},
		{"walls.floor.friction=0.1", "walls has no entry 'floor', expected [0] to [1] or the name of one"},
		{"grid.cell=small", "'small' is no value"},
		{"grid.cell=0.1; end = 3", "'0.1; end = 3' is not one value, expected one"},
		{"grid.cell=", "syntax error"},
		{"=3", "'=3' assigns nothing"},
		{"grid.size.[2]=3", "grid.size has no entry '[2]', expected [0] to [1]"},
		{"grid.cell.[0]=3", "grid.cell is a number, expected a list to take '[0]' of"},
		{"images.[0].view.[0]=3", "images.[0].view has no entry '[0]' yet, expected its whole value"},
		{"walls.[0].line.[0].[1]=0.5", "walls.[0].line stands in body"},
		{"materials.g.law.packing.discs=3",
		 "--set materials.g.law.packing.discs=3: materials.[1].law.packing.discs is 3"},
		{"materials.m.law.packing.discs=3", "materials.[0].law is a string, expected a list to take 'packing' of"},
		{"laws.law.kn=3", "laws.law.kn is not known, expected a key of the scene such as laws.[].kn"},
		{"mpm.shape=bspline",
		 "--set mpm.shape=bspline: mpm.shape is \"bspline\", expected one of \"ugimp\", \"linear\", \"cpdi\""},
		{"grid=", "syntax error"},
		{"walls=(", "'(' is never closed, expected ')'"},
	};
	write_file(good);
	for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
		char *messages = refusal(1, cases[k]);
		if (!strstr(messages, cases[k][1]))
			fail_msg("%s: expected %s, got\n%s", cases[k][0], cases[k][1], messages);
		free(messages);
	}
}

static void wrong_variants(void **state)
{
	(void)state;
	static const char *const cases[][2] = {
		{"base = \"nothing.cfg\";",
		 ":1: cannot read '/tmp/nothing.cfg' (No such file or directory), expected a scene file"},
		{"title = \"x\";\nbase = \"%s\";", ":2: base comes back to '/tmp/test_scene_errors_"},
		{"set = (\"grid.cell=1\");", ":1: set needs a scene to change, expected base"},
		{"base = 3;", ":1: base is an integer, expected the name of a scene file in quotes"},
		{"base = \"none\";\ngrid = { cell = 0.1; };",
		 ":2: grid stands in a variant, expected only title, base and set"},
	};
	for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
		char text[256], text2[512];
		const char *percent = strstr(cases[k][0], "%s");
		snprintf(text, sizeof text, "%s", cases[k][0]);
		if (percent)
			snprintf(text2, sizeof text2, "%.*s%s%s", (int)(percent - cases[k][0]), text, strrchr(path, '/') + 1,
					 percent + 2);
		write_file(percent ? text2 : text);
		char *messages = refusal(0, NULL);
		if (!strstr(messages, cases[k][1]))
			fail_msg("%s: expected %s, got\n%s", cases[k][0], cases[k][1], messages);
		free(messages);
	}
	char text[256];
	snprintf(text, sizeof text, "@include \"%s\"\n", path);
	write_file(text);
	char *messages = refusal(0, NULL);
	assert_non_null(strstr(messages, "includes itself, expected an end"));
	free(messages);
}

static void unreadable_files(void **state)
{
	(void)state;
	struct scene *scene;
	FILE *null = fopen("/dev/null", "w");
	assert_int_equal(scene_load(&scene, "/nowhere/at/all.cfg", 0, NULL, null), STATUS_INPUT);
	assert_int_equal(scene_load(&scene, "/tmp", 0, NULL, null), STATUS_INPUT);
	assert_int_equal(scene_load(&scene, "/dev/zero", 0, NULL, null), STATUS_INPUT);
	assert_non_null(strstr(error_message(), "/dev/zero: 1 error"));
	fclose(null);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(the_good_scene_is_good),
		cmocka_unit_test(one_slip_gives_one_message),
		cmocka_unit_test(messages_elsewhere),
		cmocka_unit_test(all_errors_are_reported),
		cmocka_unit_test(opposites),
		cmocka_unit_test(grid_that_follows),
		cmocka_unit_test(wrong_overrides),
		cmocka_unit_test(wrong_variants),
		cmocka_unit_test(unreadable_files),
	};
	return cmocka_run_group_tests(tests, make_file, remove_file);
}
