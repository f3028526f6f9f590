#include <ctype.h>
#include <math.h>
#include <string.h>

#include "scene/private.h"

/* ---- saying what is expected ---- */

static const char *bare_expected(const struct scene_key *key)
{
	switch (key->type) {
	case KEY_BOOL:
		return "true or false";
	case KEY_INT:
	case KEY_UNSIGNED:
	case KEY_LONG:
		return "an integer";
	case KEY_FLOAT:
		return "a number";
	case KEY_TEMPERATURE:
		return "a temperature";
	case KEY_STRING:
		return "a string in quotes";
	case KEY_NAME:
		return "a name in quotes, of letters, digits, _ and -";
	case KEY_FLOATS:
		return key->count == 2 ? "two numbers [x, y]" : "numbers [xmin, ymin, xmax, ymax]";
	case KEY_INTS:
		return "two integers [x, y]";
	case KEY_GROUP:
		return "a group { ... }";
	case KEY_LIST:
		return "a list of groups ( { ... }, { ... } )";
	default:
		return "a value";
	}
}

static void add(char *text, size_t size, const char *more)
{
	size_t used = strlen(text);
	snprintf(text + used, size - used, "%s", more);
}

void describe_expected(const struct scene_key *key, char *text, size_t size)
{
	char range[96] = "";
	snprintf(text, size, "%s", key->expected ? key->expected : bare_expected(key));
	if (key->choices) {
		snprintf(text, size, "one of ");
		for (int k = 0; key->choices[k]; k++) {
			add(text, size, k ? ", \"" : "\"");
			add(text, size, key->choices[k]);
			add(text, size, "\"");
		}
	}
	switch (key->range) {
	case RANGE_ANY:
		break;
	case RANGE_POSITIVE:
		snprintf(range, sizeof range, " > 0");
		break;
	case RANGE_NOT_NEGATIVE:
		snprintf(range, sizeof range, " >= 0");
		break;
	case RANGE_WITHIN:
		snprintf(range, sizeof range, " from %.10g to %.10g", key->min, key->max);
		break;
	case RANGE_BETWEEN:
		snprintf(range, sizeof range, " between %.10g and %.10g", key->min, key->max);
		break;
	}
	add(text, size, range);
	if (key->unit) {
		snprintf(range, sizeof range, " (%s)", key->unit);
		add(text, size, range);
	}
}

static void wrong_type(struct loader *loader, const struct scene_key *key, const struct node *node, const char *path)
{
	char expected[512];
	describe_expected(key, expected, sizeof expected);
	problem_at(loader, node->place, path, "is %s, expected %s", node_kind(node), expected);
}

/* ---- numbers ---- */

double temperature_in(const struct loader *loader, double value) { return scene_temperature_in(loader->scene, value); }

/* Finite and in the key's range? */
static bool number_fits(struct loader *loader, const struct scene_key *key, const struct node *node, double value,
						const char *path)
{
	bool fits = isfinite(value);
	switch (key->range) {
	case RANGE_ANY:
		break;
	case RANGE_POSITIVE:
		fits = fits && value > 0.0;
		break;
	case RANGE_NOT_NEGATIVE:
		fits = fits && value >= 0.0;
		break;
	case RANGE_WITHIN:
		fits = fits && value >= key->min && value <= key->max;
		break;
	case RANGE_BETWEEN:
		fits = fits && value > key->min && value < key->max;
		break;
	}
	if (!fits) {
		char expected[512];
		describe_expected(key, expected, sizeof expected);
		problem_at(loader, node->place, path, "is %.10g, expected %s%s", value,
				   isfinite(value) ? "" : "a finite number: ", expected);
	}
	return fits;
}

static bool read_number(struct loader *loader, const struct scene_key *key, const struct node *node, double *value,
						const char *path)
{
	if (node->type != NODE_NUMBER && node->type != NODE_INTEGER) {
		wrong_type(loader, key, node, path);
		return false;
	}
	*value = node->number;
	return number_fits(loader, key, node, node->number, path);
}

static bool read_integer(struct loader *loader, const struct scene_key *key, const struct node *node, long long least,
						 long long most, long long *value, const char *path)
{
	if (node->type != NODE_INTEGER) {
		wrong_type(loader, key, node, path);
		return false;
	}
	*value = node->integer;
	if (node->integer >= least && node->integer <= most)
		return number_fits(loader, key, node, node->number, path);
	char expected[512];
	describe_expected(key, expected, sizeof expected);
	problem_at(loader, node->place, path, "is %lld, expected %s", node->integer, expected);
	return false;
}

bool read_numbers(struct loader *loader, const struct scene_key *key, struct node *node, int n, double *values,
				  const char *path)
{
	if ((node->type != NODE_ARRAY && node->type != NODE_LIST) || node->n != n) {
		char expected[512];
		describe_expected(key, expected, sizeof expected);
		if (node->type == NODE_ARRAY || node->type == NODE_LIST)
			problem_at(loader, node->place, path, "has %d value%s, expected %s", node->n, node->n == 1 ? "" : "s",
					   expected);
		else
			wrong_type(loader, key, node, path);
		return false;
	}
	for (int k = 0; k < n; k++)
		if (!read_number(loader, key, node->children[k], &values[k], path))
			return false;
	return true;
}

/* A list of [x, y]; returns their number, 0 on a problem. */
int read_points(struct loader *loader, const struct scene_key *key, struct node *node, double (**points)[2],
				const char *path)
{
	if (node->type != NODE_LIST) {
		wrong_type(loader, key, node, path);
		return 0;
	}
	double(*read)[2] = scene_alloc(loader, ((size_t)node->n + 1) * sizeof *read);
	for (int k = 0; k < node->n; k++) {
		char at[PATH_LENGTH];
		path_print(at, "%s.[%d]", path, k);
		struct scene_key point = {.type = KEY_FLOATS, .count = 2, .unit = key->unit};
		if (!read_numbers(loader, &point, node->children[k], 2, read[k], at))
			return 0;
	}
	*points = read;
	return node->n;
}

/* ---- text ---- */

static bool read_text(struct loader *loader, const struct scene_key *key, const struct node *node, char *out,
					  size_t size, const char *path)
{
	if (node->type != NODE_STRING) {
		wrong_type(loader, key, node, path);
		return false;
	}
	if (strlen(node->string) >= size) {
		problem_at(loader, node->place, path, "has %zu characters, expected at most %zu", strlen(node->string),
				   size - 1);
		return false;
	}
	memcpy(out, node->string, strlen(node->string) + 1);
	return true;
}

/* Names become columns and files: nothing that a file system or a table reader could trip over. */
static void read_name(struct loader *loader, const struct scene_key *key, const struct node *node, char *out,
					  const char *path)
{
	if (!read_text(loader, key, node, out, SCENE_NAME, path))
		return;
	bool good = out[0] && out[0] != '-';
	for (const char *c = out; *c; c++)
		good = good && (isalnum((unsigned char)*c) || *c == '_' || *c == '-') && !(*c & 0x80);
	if (!good)
		problem_at(loader, node->place, path, "is \"%s\", expected a name of letters, digits, _ and -", out);
}

/* The index of the choice; -1 (recorded) if it is none. */
static int read_choice(struct loader *loader, const struct scene_key *key, const struct node *node, const char *path)
{
	if (node->type != NODE_STRING) {
		wrong_type(loader, key, node, path);
		return -1;
	}
	for (int k = 0; key->choices[k]; k++)
		if (!strcmp(key->choices[k], node->string))
			return k;
	char expected[512];
	describe_expected(key, expected, sizeof expected);
	problem_at(loader, node->place, path, "is \"%s\", expected %s", node->string, expected);
	return -1;
}

int read_reference(struct loader *loader, struct node *node, const char *list, const char *path)
{
	const struct node *candidates = node_find(loader->root, list);
	const char *nearest = NULL;
	int best = 3;
	for (int k = 0; candidates && k < candidates->n; k++) {
		const struct node *name =
			candidates->children[k]->type == NODE_GROUP ? node_find(candidates->children[k], "name") : NULL;
		if (!name || name->type != NODE_STRING)
			continue;
		int distance = edit_distance(name->string, node->string);
		if (!distance)
			return k;
		if (distance < best || candidates->n == 1)
			best = distance, nearest = name->string;
	}
	if (nearest)
		problem_at(loader, node->place, path, "\"%s\" is not defined, expected a name in %s (did you mean \"%s\"?)",
				   node->string, list, nearest);
	else
		problem_at(loader, node->place, path, "\"%s\" is not defined, expected a name in %s", node->string, list);
	return -1;
}

/* ---- groups and lists ---- */

static void read_value(struct loader *loader, const struct scene_key *key, struct node *node, void *base,
					   const char *path);

/* Reports a key that nobody knows; returns the one that was probably meant, NULL if none is near. */
static const struct scene_key *unknown_key(struct loader *loader, const struct scene_key *keys, const struct node *node,
										   const char *path)
{
	const struct scene_key *nearest = NULL;
	int best = 1 + (int)strlen(node->name) / 3;
	if (best < 2)
		best = 2;
	for (const struct scene_key *key = keys; key->name; key++) {
		int distance = edit_distance(node->name, key->name);
		if (distance < best)
			best = distance, nearest = key;
	}
	if (nearest) {
		problem_at(loader, node->place, path, "is not known, expected another key (did you mean '%s'?)", nearest->name);
		return nearest;
	}
	char known[512] = "";
	for (const struct scene_key *key = keys; key->name; key++) {
		add(known, sizeof known, key == keys ? "" : ", ");
		add(known, sizeof known, key->name);
	}
	problem_at(loader, node->place, path, "is not known, expected one of %s", known);
	return NULL;
}

/* What a value that is left out becomes. */
static void set_absent(const struct scene_key *key, void *base)
{
	char *at = (char *)base + key->offset;
	switch (key->type) {
	case KEY_FLOAT:
	case KEY_TEMPERATURE:
		*(double *)at = NAN;
		break;
	case KEY_LONG:
		*(long *)at = -1;
		break;
	case KEY_FLOATS:
		for (int k = 0; k < key->count; k++)
			((double *)at)[k] = NAN;
		break;
	default:
		break;
	}
}

static void read_default(struct loader *loader, const struct scene_key *key, void *base, const char *path)
{
	char text[128];
	struct source source;
	struct scene_place place = {"default", 0};
	snprintf(text, sizeof text, "value = %s", key->value);
	source_text(loader, text, place, &source);
	read_value(loader, key, tree_parse(loader, &source, path)->children[0], base, path);
}

static void read_absent(struct loader *loader, const struct scene_key *key, const struct node *group, void *base,
						const char *path)
{
	set_absent(key, base);
	if (key->value) {
		read_default(loader, key, base, path);
	} else if (key->required) {
		char expected[512];
		describe_expected(key, expected, sizeof expected);
		problem_at(loader, group->place, path, "is missing, expected %s: %s", expected, key->doc);
	} else if (key->type == KEY_GROUP) {
		struct node *empty = node_new(loader, NODE_GROUP, group->place);
		read_group(loader, tables_choose(key->tables, empty), empty, (char *)base + key->offset, path);
	}
}

void read_group(struct loader *loader, const struct scene_key *keys, struct node *group, void *target, const char *path)
{
	enum { MEANT_MAX = 16 };
	const struct scene_key *meant[MEANT_MAX];
	char at[PATH_LENGTH];
	const char *dot = *path ? "." : "";
	int n_meant = 0;
	for (int k = 0; k < group->n; k++)
		if (!keys_find(keys, group->children[k]->name)) {
			path_print(at, "%s%s%.64s", path, dot, group->children[k]->name);
			meant[n_meant] = unknown_key(loader, keys, group->children[k], at);
			n_meant += meant[n_meant] && n_meant + 1 < MEANT_MAX;
		}
	for (const struct scene_key *key = keys; key->name; key++) {
		struct node *node = node_find(group, key->name);
		bool misspelled = false; /* then it is not missing as well */
		for (int k = 0; k < n_meant; k++)
			misspelled |= meant[k] == key;
		path_print(at, "%s%s%s", path, dot, key->name);
		if (node)
			read_value(loader, key, node, target, at);
		else if (misspelled && key->required)
			loader_taint(loader, at);
		else
			read_absent(loader, key, group, target, at);
	}
}

/* Reads one group of a list, or reports which kinds there are when its `type` does not tell. */
static void read_element(struct loader *loader, const struct scene_key *key, struct node *node, void *target,
						 const char *path)
{
	if (node->type != NODE_GROUP) {
		problem_at(loader, node->place, path, "is %s, expected a group { ... }", node_kind(node));
		return;
	}
	const struct scene_key *keys = tables_choose(key->tables, node);
	if (keys) {
		read_group(loader, keys, node, target, path);
		return;
	}
	char at[PATH_LENGTH];
	path_print(at, "%s.type", path);
	const struct scene_key *type = keys_find(key->tables->keys, "type");
	struct node *given = node_find(node, "type");
	if (given)
		read_value(loader, type, given, target, at);
	else
		read_absent(loader, type, node, target, at);
}

static void read_list(struct loader *loader, const struct scene_key *key, struct node *node, void *base,
					  const char *path)
{
	if (node->type != NODE_LIST && !(node->type == NODE_ARRAY && node->n == 0)) {
		wrong_type(loader, key, node, path);
		return;
	}
	char *elements = scene_alloc(loader, ((size_t)node->n + 1) * key->element_size);
	memcpy((char *)base + key->offset, &elements, sizeof elements);
	*(int *)((char *)base + key->n_offset) = node->n;
	if (key->required && node->n == 0)
		problem_at(loader, node->place, path, "is empty, expected at least one { ... }: %s", key->doc);
	for (int k = 0; k < node->n; k++) {
		char at[PATH_LENGTH];
		path_print(at, "%s.[%d]", path, k);
		read_element(loader, key, node->children[k], elements + (size_t)k * key->element_size, at);
	}
}

static void read_value(struct loader *loader, const struct scene_key *key, struct node *node, void *base,
					   const char *path)
{
	void *at = (char *)base + key->offset;
	long long integer = 0;
	double numbers[4];
	int choice;
	switch (key->type) {
	case KEY_BOOL:
		if (node->type == NODE_BOOL)
			*(bool *)at = node->integer != 0;
		else
			wrong_type(loader, key, node, path);
		break;
	case KEY_INT:
		if (read_integer(loader, key, node, -2147483648LL, 2147483647LL, &integer, path))
			*(int *)at = (int)integer;
		break;
	case KEY_UNSIGNED:
		if (read_integer(loader, key, node, 0, 4294967295LL, &integer, path))
			*(unsigned *)at = (unsigned)integer;
		break;
	case KEY_LONG:
		if (read_integer(loader, key, node, -9223372036854775807LL, 9223372036854775807LL, &integer, path))
			*(long *)at = (long)integer;
		break;
	case KEY_FLOAT:
		if (read_number(loader, key, node, &numbers[0], path))
			*(double *)at = numbers[0];
		break;
	case KEY_TEMPERATURE:
		if (!read_number(loader, key, node, &numbers[0], path))
			break;
		*(double *)at = temperature_in(loader, numbers[0]);
		if (*(double *)at < 0.0)
			problem_at(loader, node->place, path, "is %.10g, below absolute zero, expected at least %s", numbers[0],
					   loader->scene->units.celsius ? "-273.15 C" : "0 K");
		break;
	case KEY_FLOATS:
		if (read_numbers(loader, key, node, key->count, numbers, path))
			memcpy(at, numbers, (size_t)key->count * sizeof *numbers);
		break;
	case KEY_INTS:
		if (read_numbers(loader, key, node, key->count, numbers, path))
			for (int k = 0; k < key->count; k++) {
				if (node->children[k]->type != NODE_INTEGER)
					wrong_type(loader, key, node->children[k], path);
				((int *)at)[k] = (int)numbers[k];
			}
		break;
	case KEY_STRING:
		read_text(loader, key, node, at, (size_t)key->count, path);
		break;
	case KEY_NAME:
		read_name(loader, key, node, at, path);
		break;
	case KEY_CHOICE:
		if ((choice = read_choice(loader, key, node, path)) >= 0)
			snprintf(at, SCENE_NAME, "%s", key->choices[choice]);
		break;
	case KEY_ENUM:
		if ((choice = read_choice(loader, key, node, path)) >= 0)
			*(int *)at = choice; /* an enum without negative values has the size of int */
		break;
	case KEY_FLAG:
		if ((choice = read_choice(loader, key, node, path)) >= 0)
			*(bool *)at = choice != 0;
		break;
	case KEY_CUSTOM:
		key->read(loader, key, node, base, path);
		break;
	case KEY_GROUP:
		if (node->type == NODE_GROUP)
			read_group(loader, tables_choose(key->tables, node), node, at, path);
		else
			wrong_type(loader, key, node, path);
		break;
	case KEY_LIST:
		read_list(loader, key, node, base, path);
		break;
	}
}

/* Where each element of a list stands, for messages that come later. */
#define PLACES(field, name)                                                                                            \
	do {                                                                                                               \
		const struct node *list_ = node_find(loader->root, name);                                                      \
		for (int k_ = 0; list_ && k_ < list_->n && k_ < loader->scene->n_##field; k_++)                                \
			loader->scene->field[k_].place = list_->children[k_]->place;                                               \
	} while (0)

void read_places(struct loader *loader)
{
	PLACES(laws, "laws");
	PLACES(materials, "materials");
	PLACES(bodies, "bodies");
	PLACES(walls, "walls");
	PLACES(boundaries, "boundaries");
	PLACES(contacts, "contacts");
	PLACES(stages, "stages");
	PLACES(probes, "probes");
	PLACES(regions, "regions");
	PLACES(cracks, "cracks");
	PLACES(inspect, "inspect");
	PLACES(images, "images");
}
