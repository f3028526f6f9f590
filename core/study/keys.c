/* Everything that a study file can say, read and checked by the scenes' loader. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "scene/private.h"
#include "study/private.h"

#define READER(name)                                                                                                   \
	static void name(struct loader *loader, const struct scene_key *key, struct node *node, void *target,              \
					 const char *path)

/* The name of a file, as seen from the file in which it stands (a variant's base may be elsewhere). */
READER(read_file)
{
	if (node->type != NODE_STRING || !node->string[0] || strlen(node->string) >= SCENE_PATH / 2) {
		problem_at(loader, node->place, path, "is %s, expected %s", node_kind(node), key->expected);
		return;
	}
	snprintf((char *)target + key->offset, SCENE_PATH, "%s", path_beside(loader, node->place.file, node->string));
}

/* A list of strings, numbers, true and false: all kept as texts. */
READER(read_texts)
{
	struct study_texts *texts = (struct study_texts *)((char *)target + key->offset);
	if (node->type != NODE_LIST && node->type != NODE_ARRAY) {
		problem_at(loader, node->place, path, "is %s, expected %s", node_kind(node), key->expected);
		return;
	}
	texts->items = scene_alloc(loader, ((size_t)node->n + 1) * sizeof *texts->items);
	for (int k = 0; k < node->n; k++) {
		const struct node *item = node->children[k];
		char text[40];
		if (item->type == NODE_STRING)
			snprintf(text, sizeof text, "%s", "");
		else if (item->type == NODE_BOOL)
			snprintf(text, sizeof text, "%s", item->integer ? "true" : "false");
		else if (item->type == NODE_INTEGER)
			snprintf(text, sizeof text, "%lld", item->integer);
		else if (item->type == NODE_NUMBER)
			snprintf(text, sizeof text, "%.15g", item->number);
		else {
			problem_at(loader, item->place, path, "holds %s, expected %s", node_kind(item), key->expected);
			return;
		}
		texts->items[texts->n++] = scene_string(loader, item->type == NODE_STRING ? item->string : text);
	}
}

/* A group of names, each with a number or an expression: parameters of an exact solution. */
READER(read_parameters)
{
	struct study_reference *reference = target;
	(void)key;
	if (node->type != NODE_GROUP) {
		problem_at(loader, node->place, path, "is %s, expected %s", node_kind(node), key->expected);
		return;
	}
	reference->parameters = scene_alloc(loader, ((size_t)node->n + 1) * sizeof *reference->parameters);
	for (int k = 0; k < node->n; k++) {
		const struct node *item = node->children[k];
		struct study_parameter *p = &reference->parameters[reference->n_parameters++];
		snprintf(p->name, sizeof p->name, "%s", item->name);
		if (item->type == NODE_STRING)
			snprintf(p->value, sizeof p->value, "%s", item->string);
		else if (item->type == NODE_INTEGER || item->type == NODE_NUMBER)
			snprintf(p->value, sizeof p->value, "%.17g", item->number);
		else
			problem_at(loader, item->place, path, "holds %s, expected %s", node_kind(item), key->expected);
	}
}

/* Two names of knobs, or one. */
READER(read_map)
{
	struct study *study = target;
	struct study_texts texts = {0};
	const struct scene_key as_texts = {.offset = 0, .expected = key->expected};
	read_texts(loader, &as_texts, node, &texts, path);
	if (texts.n > 2)
		problem_at(loader, node->place, path, "has %d knobs, expected %s", texts.n, key->expected);
	for (int k = 0; k < texts.n && k < 2; k++)
		snprintf(study->map[k], sizeof study->map[k], "%s", texts.items[k]);
}

/* clang-format off */
#define AT(s, field) .offset = offsetof(struct s, field)
#define TEXT(s, field) .type = KEY_STRING, AT(s, field), .count = sizeof ((struct s *)0)->field
#define TEXTS(s, field) .type = KEY_CUSTOM, AT(s, field), .read = read_texts
#define LIST(s, array, counter) \
	.type = KEY_LIST, .offset = offsetof(struct s, array), .n_offset = offsetof(struct s, counter), \
	.element_size = sizeof *((struct s *)0)->array
#define CHOICES(...) .choices = (const char *const[]){__VA_ARGS__, NULL}
#define KEYS(table) .tables = (const struct scene_table[]){{NULL, table}, {NULL, NULL}}
#define END {.name = NULL}
#define SETS "a list of strings (\"path=value\", ...)"
#define SELECTION "a selection of knobs such as \"transfer=flip, dt=1e-4\""

static const struct scene_key scene_keys[] = {
	{.name = "file", .type = KEY_CUSTOM, AT(study_scene, file), .absent = "only with load", .read = read_file,
	 .expected = "the name of a scene file in quotes", .doc = "the scene, as seen from this file"},
	{.name = "set", TEXTS(study_scene, set), .absent = "nothing", .expected = SETS,
	 .doc = "what all runs set; $(...) holds an expression of knobs. Runs draw no pictures, and write no snapshots unless a norm needs them"},
	{.name = "threads", .type = KEY_INT, AT(study_scene, threads), .value = "1", .range = RANGE_WITHIN, .min = 1, .max = 4096,
	 .doc = "of each run"},
	END};

static const struct scene_key choice_keys[] = {
	{.name = "name", TEXT(study_choice, name), .required = true, .doc = "of the choice"},
	{.name = "value", .type = KEY_FLOAT, AT(study_choice, value), .absent = "the name, if it is a number",
	 .doc = "of the knob in expressions and on axes"},
	{.name = "set", TEXTS(study_choice, set), .absent = "nothing", .expected = SETS, .doc = "what this choice sets, with $(...)"},
	END};

static const struct scene_key knob_keys[] = {
	{.name = "name", .type = KEY_NAME, AT(study_knob, name), .required = true, .doc = "of the knob; in expressions, its value"},
	{.name = "label", TEXT(study_knob, label), .absent = "the name", .doc = "in charts"},
	{.name = "unit", TEXT(study_knob, unit), .value = "\"-\"", .doc = "of its values"},
	{.name = "seed", .type = KEY_BOOL, AT(study_knob, seed), .value = "false", .doc = "its values differ in chance only: error bars"},
	{.name = "path", TEXT(study_knob, path), .absent = "only set", .doc = "what its values are set to: short for set = (\"PATH=$(NAME)\")"},
	{.name = "set", TEXTS(study_knob, set), .absent = "only path", .expected = SETS, .doc = "what every value sets, with $(...)"},
	{.name = "values", TEXTS(study_knob, list), .absent = "only choices", .expected = "a list of numbers or strings",
	 .doc = "what the knob is turned to"},
	{.name = "choices", LIST(study_knob, choices, n_choices), KEYS(choice_keys), .absent = "only values",
	 .doc = "named values, each with a list of what it sets"},
	END};

static const struct scene_key reference_keys[] = {
	{.name = "exact", TEXT(study_reference, exact), .absent = "another reference", .doc = "name of an exact solution"},
	{.name = "parameters", .type = KEY_CUSTOM, AT(study_reference, parameters), .absent = "none", .read = read_parameters,
	 .expected = "a group { name = number or \"expression of knobs\"; ... }", .doc = "of the exact solution"},
	{.name = "finest", TEXT(study_reference, finest), .absent = "another reference",
	 .doc = SELECTION ": every run is compared with the one that has these values and is like it otherwise"},
	{.name = "mean", .type = KEY_BOOL, AT(study_reference, mean), .value = "false",
	 .doc = "with finest: the mean over its seeds, not seed by seed"},
	{.name = "table", .type = KEY_CUSTOM, AT(study_reference, table), .absent = "another reference", .read = read_file,
	 .expected = "the name of a CSV file in quotes",
	 .doc = "a CSV file with the columns that the norms name, as seen from this file"},
	END};

static const struct scene_key gate_keys[] = {
	{.name = "bound", .type = KEY_FLOAT, AT(study_gate, bound), .required = true, .range = RANGE_NOT_NEGATIVE,
	 .doc = "the largest error that passes"},
	{.name = "where", TEXT(study_gate, where), .absent = "everywhere", .doc = SELECTION},
	END};

static const struct scene_key norm_keys[] = {
	{.name = "name", .type = KEY_NAME, AT(study_norm, name), .required = true, .doc = "of the norm: its columns in study.csv"},
	{.name = "label", TEXT(study_norm, label), .absent = "the name", .doc = "in charts"},
	{.name = "kind", .type = KEY_ENUM, AT(study_norm, kind), .value = "\"rms\"", CHOICES("rms", "max", "mean", "end", "reach"),
	 .doc = "root mean square or largest difference; difference of the means, of the last values, of the abscissae at which level is reached"},
	{.name = "column", TEXT(study_norm, column), .absent = "only points",
	 .doc = "a column of the run's history (of the curve of an RVE), or an expression of columns and knobs"},
	{.name = "abscissa", TEXT(study_norm, abscissa), .value = "\"time\"", .doc = "a column, the number of the row (\"row\") or an expression, over which the curve is taken"},
	{.name = "points", TEXT(study_norm, points), .absent = "only column",
	 .doc = "a field of the points in a snapshot, such as temperature, stress_xx or displacement, against the exact solution; rms weighs by volume"},
	{.name = "exact", TEXT(study_norm, exact), .absent = "the column's or field's own name",
	 .doc = "an expression of fields of the exact solution"},
	{.name = "at", .type = KEY_FLOATS, AT(study_norm, at), .count = 2, .unit = "m", .absent = "where the column's probe starts",
	 .doc = "place of the exact solution in the initial body"},
	{.name = "from", .type = KEY_FLOAT, AT(study_norm, from), .absent = "the whole curve", .doc = "where on the abscissa it begins"},
	{.name = "until", .type = KEY_FLOAT, AT(study_norm, until), .absent = "the whole curve", .doc = "where it ends"},
	{.name = "level", .type = KEY_FLOAT, AT(study_norm, level), .absent = "only for reach", .doc = "what is reached"},
	{.name = "time", .type = KEY_FLOAT, AT(study_norm, time), .unit = "s", .absent = "the last", .doc = "of the snapshot, within 1%; the exact solution is that of its own time"},
	{.name = "scale", .type = KEY_FLOAT, AT(study_norm, scale), .value = "1.0", .range = RANGE_POSITIVE, .doc = "values and errors are divided by it"},
	{.name = "unit", TEXT(study_norm, unit), .value = "\"-\"", .doc = "of what is left"},
	{.name = "relative", .type = KEY_BOOL, AT(study_norm, relative), .value = "false", .doc = "the error is divided by the reference's value"},
	{.name = "gate", .type = KEY_FLOAT, AT(study_norm, gate), .absent = "none", .range = RANGE_NOT_NEGATIVE,
	 .doc = "the largest error that passes, everywhere"},
	{.name = "gates", LIST(study_norm, gates, n_gates), KEYS(gate_keys), .absent = "none", .doc = "bounds for some combinations"},
	{.name = "garbage", .type = KEY_FLOAT, AT(study_norm, garbage), .absent = "no criterion", .range = RANGE_NOT_NEGATIVE,
	 .doc = "stability: an error (without a reference, a value) beyond it, or none at all, means that the result is garbage"},
	END};

static const struct scene_key order_keys[] = {
	{.name = "norm", .type = KEY_NAME, AT(study_order, norm), .required = true, .doc = "name of a norm"},
	{.name = "knob", .type = KEY_NAME, AT(study_order, knob), .required = true, .doc = "name of a knob"},
	{.name = "where", TEXT(study_order, where), .absent = "everywhere", .doc = SELECTION},
	{.name = "least", .type = KEY_FLOAT, AT(study_order, least), .required = true, .doc = "slope of log error over log knob that passes"},
	END};

static const struct scene_key curve_keys[] = {
	{.name = "label", TEXT(study_curve, label), .required = true, .doc = "in the map"},
	{.name = "y", TEXT(study_curve, y), .required = true,
	 .doc = "an expression of the first knob of the map that gives the second; with one knob, its value"},
	END};

static const struct scene_key root_keys[] = {
	{.name = "title", TEXT(study, title), .value = "\"\"", .doc = "of charts"},
	{.name = "kind", .type = KEY_FLAG, AT(study, stability), .value = "\"error\"", CHOICES("error", "stability"),
	 .doc = "error against cost; or where a method fails, and whether a guard tells, every combination with and without guards"},
	{.name = "scene", .type = KEY_GROUP, AT(study, scene), KEYS(scene_keys), .absent = "load", .doc = "what is run"},
	{.name = "load", TEXTS(study, load), .absent = "scene", .expected = "a list of options of `tmdempm rve load` (\"rate=1\", ...)",
	 .doc = "or one RVE alone: all options of rve load but out, such as \"rate=1\"; files are as seen from this file; knobs set options too"},
	{.name = "knobs", LIST(study, knobs, n_knobs), KEYS(knob_keys), .required = true, .doc = "what is varied"},
	{.name = "plan", .type = KEY_ENUM, AT(study, plan), .value = "\"product\"", CHOICES("product", "one_at_a_time", "list"),
	 .doc = "every value with every other; each knob alone, the others as in around; or the list combinations"},
	{.name = "around", TEXT(study, base), .absent = "the first value of each", .doc = SELECTION " for one_at_a_time"},
	{.name = "combinations", TEXTS(study, combinations), .absent = "only for list", .expected = "a list of selections of knobs",
	 .doc = "selections; a knob that one does not name takes all its values"},
	{.name = "reference", .type = KEY_GROUP, AT(study, reference), KEYS(reference_keys), .absent = "none: values only",
	 .doc = "what results are compared with"},
	{.name = "norms", LIST(study, norms, n_norms), KEYS(norm_keys), .required = true, .doc = "how they are compared"},
	{.name = "orders", LIST(study, orders, n_orders), KEYS(order_keys), .absent = "none", .doc = "orders of convergence that are demanded"},
	{.name = "against", TEXTS(study, against), .absent = "none", .expected = "a list of names of knobs",
	 .doc = "knobs over which errors are drawn, with the observed order"},
	{.name = "guards_off", TEXTS(study, guards_off), .absent = "only for stability", .expected = SETS, .doc = "what turns all guards off"},
	{.name = "map", .type = KEY_CUSTOM, AT(study, map), .absent = "only for stability", .read = read_map,
	 .expected = "one or two names of knobs", .doc = "knobs along the axes of the stability map"},
	{.name = "curves", LIST(study, curves, n_curves), KEYS(curve_keys), .absent = "none", .doc = "theory, drawn into the map"},
	END};
/* clang-format on */

static const struct scene_table root_tables[] = {{NULL, root_keys}, {NULL, NULL}};

/* ---- what no single key can tell ---- */

/* Values and choices become one list of choices; a path becomes a set. */
static void finish_knob(struct loader *loader, struct study_knob *knob, const char *path)
{
	int n = knob->list.n + knob->n_choices;
	if (!knob->list.n == !knob->n_choices) {
		problem_of(loader, path, "has %s, expected one of values and choices",
				   knob->n_choices ? "values and choices" : "nothing to turn it to");
		return;
	}
	if (!knob->label[0])
		snprintf(knob->label, sizeof knob->label, "%s", knob->name);
	if (knob->list.n)
		knob->choices = scene_alloc(loader, (size_t)n * sizeof *knob->choices);
	for (int k = 0; k < n; k++) {
		struct study_choice *choice = &knob->choices[k];
		if (knob->list.n) {
			snprintf(choice->name, sizeof choice->name, "%s", knob->list.items[k]);
			choice->value = NAN;
		}
		char *end;
		double value = strtod(choice->name, &end);
		if (isnan(choice->value) && choice->name[0] && !*end)
			choice->value = value;
		if (!choice->name[0] || strpbrk(choice->name, ",=;"))
			problem_of(loader, path, "has the value \"%s\", expected one without comma, equals sign and semicolon",
					   choice->name);
		for (int j = 0; j < k; j++)
			if (!strcmp(knob->choices[j].name, choice->name))
				problem_of(loader, path, "has the value \"%s\" twice, expected it once", choice->name);
	}
	knob->n_choices = n;
	if (knob->path[0]) {
		struct study_texts set = {.n = knob->set.n + 1};
		set.items = scene_alloc(loader, (size_t)set.n * sizeof *set.items);
		char text[2 * STUDY_TEXT];
		snprintf(text, sizeof text, "%s=$(%s)", knob->path, knob->name);
		set.items[0] = scene_string(loader, text);
		for (int k = 0; k < knob->set.n; k++)
			set.items[k + 1] = knob->set.items[k];
		knob->set = set;
	}
}

static void check_selection(struct loader *loader, const struct study *study, const char *selection, const char *path)
{
	if (selection[0] && plan_check_selection(study, selection) != STATUS_OK)
		problem_of(loader, path, "%s", error_message());
}

static void check_norm(struct loader *loader, const struct study *study, struct study_norm *norm, int k)
{
	char path[PATH_LENGTH];
	path_print(path, "norms.[%d]", k);
	if (!norm->column[0] == !norm->points[0])
		problem_of(loader, path, "has %s, expected one of them",
				   norm->column[0] ? "column and points" : "neither column nor points");
	if (norm->points[0] && study->reference.kind != STUDY_EXACT)
		problem_of(loader, path, "is over points, expected an exact solution as reference");
	if (norm->points[0] && norm->kind != NORM_RMS && norm->kind != NORM_MAX)
		problem_of(loader, path, "is over points, expected rms or max");
	if (norm->points[0] && study->load.n)
		problem_of(loader, path, "is over points, which rve load has not, expected column");
	if ((norm->kind == NORM_REACH) != !isnan(norm->level))
		problem_of(loader, path, "has %s, expected both or none of kind = \"reach\" and level",
				   isnan(norm->level) ? "kind = \"reach\" without level" : "a level");
	if (study->stability && norm->gate >= 0.0)
		problem_of(loader, path, "has a gate, expected garbage in a study of stability");
	if (!norm->label[0])
		snprintf(norm->label, sizeof norm->label, "%s", norm->name);
	if (study->load.n && !strcmp(norm->abscissa, "time"))
		problem_of(loader, path,
				   "has no abscissa, expected a column of the curve such as strain_yy (rve load writes no time)");
	for (int j = 0; j < norm->n_gates; j++) {
		char gate[PATH_LENGTH];
		path_print(gate, "norms.[%d].gates.[%d].where", k, j);
		check_selection(loader, study, norm->gates[j].where, gate);
	}
}

static void check_reference(struct loader *loader, struct study *study)
{
	struct study_reference *r = &study->reference;
	int n = !!r->exact[0] + !!r->finest[0] + !!r->table[0];
	if (n > 1)
		problem_of(loader, "reference", "has %d of exact, finest and table, expected one", n);
	r->kind = r->exact[0] ? STUDY_EXACT : r->finest[0] ? STUDY_FINEST : r->table[0] ? STUDY_TABLE : STUDY_NO_REFERENCE;
	check_selection(loader, study, r->finest, "reference.finest");
}

static void check_knob_name(struct loader *loader, const struct study *study, const char *name, const char *path)
{
	if (name[0] && plan_knob(study, name) < 0)
		problem_of(loader, path, "names \"%s\", expected the name of a knob", name);
}

static void check_stability(struct loader *loader, const struct study *study)
{
	bool criterion = false;
	for (int k = 0; k < study->n_norms; k++)
		criterion |= !isnan(study->norms[k].garbage);
	if (!study->stability) {
		if (study->guards_off.n || study->map[0][0] || criterion)
			problem_of(loader, "kind", "is \"error\", expected \"stability\" with guards_off, map or garbage");
		return;
	}
	if (!study->guards_off.n)
		problem_of(loader, "guards_off", "is missing, expected what turns the guards off, in a study of stability");
	if (!study->map[0][0])
		problem_of(loader, "map", "is missing, expected one or two names of knobs, in a study of stability");
	if (!criterion)
		problem_of(loader, "norms", "has no garbage, expected a norm that tells when a result means nothing");
	check_knob_name(loader, study, study->map[0], "map");
	check_knob_name(loader, study, study->map[1], "map");
}

static void check_lists(struct loader *loader, const struct study *study)
{
	for (int k = 0; k < study->against.n; k++)
		check_knob_name(loader, study, study->against.items[k], "against");
	for (int k = 0; k < study->combinations.n; k++)
		check_selection(loader, study, study->combinations.items[k], "combinations");
	check_selection(loader, study, study->base, "around");
	if ((study->plan == STUDY_LIST) != (study->combinations.n > 0))
		problem_of(loader, "combinations", "%s, expected both or none of plan = \"list\" and combinations",
				   study->combinations.n ? "are given" : "are missing");
	if (study->base[0] && study->plan != STUDY_ONE_AT_A_TIME)
		problem_of(loader, "around", "is given, expected it with plan = \"one_at_a_time\" only");
	for (int k = 0; k < study->n_orders; k++) {
		bool known = false;
		char path[PATH_LENGTH];
		path_print(path, "orders.[%d].norm", k);
		for (int j = 0; j < study->n_norms; j++)
			known |= !strcmp(study->norms[j].name, study->orders[k].norm);
		if (!known && study->orders[k].norm[0])
			problem_of(loader, path, "names \"%s\", expected the name of a norm", study->orders[k].norm);
		path_print(path, "orders.[%d].knob", k);
		check_knob_name(loader, study, study->orders[k].knob, path);
		path_print(path, "orders.[%d].where", k);
		check_selection(loader, study, study->orders[k].where, path);
	}
}

static void check_names(struct loader *loader, const struct study *study)
{
	static const char *const columns[] = {"guards", "verdict", "outcome",     "reference",  "wall",   "cpu",    "setup",
										  "steps",  "points",  "point_steps", "disc_steps", "reason", "folder", "runs"};
	for (int k = 0; k < study->n_knobs; k++)
		for (size_t j = 0; j < sizeof columns / sizeof *columns; j++)
			if (!strcmp(study->knobs[k].name, columns[j]))
				problem_at(loader, study->knobs[k].place, "knobs",
						   "has the name \"%s\", a column of study.csv, expected another", columns[j]);
	for (int k = 0; k < study->n_knobs; k++)
		for (int j = 0; j < k; j++)
			if (!strcmp(study->knobs[k].name, study->knobs[j].name))
				problem_at(loader, study->knobs[k].place, "knobs", "has \"%s\" twice, expected names of their own",
						   study->knobs[k].name);
	for (int k = 0; k < study->n_norms; k++)
		for (int j = 0; j < k; j++)
			if (!strcmp(study->norms[k].name, study->norms[j].name))
				problem_at(loader, study->norms[k].place, "norms", "has \"%s\" twice, expected names of their own",
						   study->norms[k].name);
}

static void check_study(struct loader *loader, void *target)
{
	struct study *study = target;
	const struct node *knobs = node_find(loader->root, "knobs"), *norms = node_find(loader->root, "norms");
	snprintf(study->file, sizeof study->file, "%s", loader->scene->path);
	for (int k = 0; k < study->n_knobs; k++)
		study->knobs[k].place = knobs->children[k]->place;
	for (int k = 0; k < study->n_norms; k++)
		study->norms[k].place = norms->children[k]->place;
	bool scene = study->scene.file[0] != '\0';
	if (scene == (study->load.n > 0))
		problem_at(loader, loader->root->place, "", "%s, expected one of scene and load",
				   scene ? "both scene and load are given" : "neither scene nor load is given");
	if (loader->n_problems) /* what follows relies on values that are sound */
		return;
	for (int k = 0; k < study->n_knobs; k++) {
		char path[PATH_LENGTH];
		path_print(path, "knobs.[%d]", k);
		finish_knob(loader, &study->knobs[k], path);
	}
	check_names(loader, study);
	if (loader->n_problems)
		return;
	check_reference(loader, study);
	for (int k = 0; k < study->n_norms; k++)
		check_norm(loader, study, &study->norms[k], k);
	check_lists(loader, study);
	check_stability(loader, study);
}

static const struct file_kind study_kind = {"study", root_tables, check_study};

int study_load(struct study **result, const char *path, int n_sets, const char *const *sets, void *errors)
{
	struct study *study = calloc(1, sizeof *study);
	*result = NULL;
	if (!study)
		return error_set(STATUS_RESOURCE, "no memory to load '%s'", path);
	int status = file_kind_load(&study_kind, &study->storage, study, path, n_sets, sets, errors);
	if (status == STATUS_OK)
		*result = study;
	else
		free(study);
	return status;
}

void study_free(struct study *study)
{
	if (study)
		scene_free(study->storage);
	free(study);
}

/* ---- for people ---- */

static void print_keys(FILE *out, const struct scene_key *keys, int depth)
{
	for (; keys->name; keys++) {
		char comment[1024];
		scene_key_comment(keys, comment, sizeof comment);
		fprintf(out, "%*s%-*s %s%s\n", 2 + 2 * depth, "", 16 - 2 * depth, keys->name,
				keys->type == KEY_LIST    ? "( { ... }, ... )  "
				: keys->type == KEY_GROUP ? "{ ... }  "
										  : "",
				comment);
		if (keys->tables)
			print_keys(out, keys->tables->keys, depth + 1);
	}
}

void study_print_keys(FILE *out)
{
	fputs("keys of a study file:\n", out);
	print_keys(out, root_keys, 0);
}
