#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "scene/private.h"

enum { BASES_MAX = 16 };

/* ---- one override ---- */

/* Where an assignment has got to: a node and what the table says about it. */
struct spot {
	struct node *node;
	const struct scene_key *key; /* NULL at the root and inside a value such as gravity.[0] */
	char path[PATH_LENGTH];
	struct node *grown; /* the first node that got a new child on the way, to undo it if the value is wrong */
};

static bool takes_text(const struct scene_key *key)
{
	if (!key)
		return false;
	return key->text || key->type == KEY_STRING || key->type == KEY_NAME || key->type == KEY_CHOICE ||
		   key->type == KEY_ENUM || key->type == KEY_FLAG;
}

/* The value of an assignment: libconfig's syntax; a string may come without its quotes. */
static struct node *parse_value(struct loader *loader, bool bare, const char *text, struct scene_place place,
								const char *path)
{
	if (bare && text[0] != '"' && text[0] != '(' && text[0] != '[' && text[0] != '{') {
		struct node *node = node_new(loader, NODE_STRING, place);
		node->string = loader_string(loader, text);
		return node;
	}
	size_t size = strlen(text) + 16;
	char *assignment = loader_alloc(loader, size);
	snprintf(assignment, size, "value = %s", text);
	struct source source;
	if (!source_text(loader, assignment, place, &source))
		return NULL;
	struct node *tree = tree_parse(loader, &source, path);
	if (tree && (tree->n != 1 || strcmp(tree->children[0]->name, "value"))) {
		problem_at(loader, place, path, "'%s' is not one value, expected one", text);
		return NULL;
	}
	return tree ? tree->children[0] : NULL;
}

static void unknown(struct loader *loader, struct scene_place place, const char *path)
{
	char nearest[PATH_LENGTH];
	keys_nearest(loader->kind->tables->keys, path, nearest);
	problem_at(loader, place, path, "is not known, expected a key of the %s such as %s", loader->kind->name, nearest);
}

/* The element that one component of a path means: an index, or the name of a group in the list. */
static int element_index(const struct node *list, const char *component, size_t length)
{
	if (component[0] == '[') {
		char *end;
		errno = 0;
		long k = strtol(component + 1, &end, 10);
		bool whole = end > component + 1 && end == component + length - 1 && *end == ']';
		return whole && !errno && k >= 0 && k <= list->n ? (int)k : -1;
	}
	for (int k = 0; k < list->n; k++) {
		const struct node *name = list->children[k]->type == NODE_GROUP ? node_find(list->children[k], "name") : NULL;
		if (name && name->type == NODE_STRING && strlen(name->string) == length &&
			!memcmp(name->string, component, length))
			return k;
	}
	return -1;
}

static void grow(struct loader *loader, struct spot *spot, struct node *child)
{
	node_append(loader, spot->node, child);
	if (!spot->grown)
		spot->grown = spot->node;
}

/* One step into a list or array; false (recorded) if there is no such element. */
static bool step_element(struct loader *loader, struct spot *spot, const char *component, size_t length, bool last,
						 struct scene_place place)
{
	struct node *list = spot->node;
	bool holds = list->type == NODE_LIST || list->type == NODE_ARRAY;
	int k = holds ? element_index(list, component, length) : -1;
	if (k < 0 || (k == list->n && !(last && spot->key && spot->key->type == KEY_LIST))) {
		if (!holds)
			problem_at(loader, place, spot->path, "is %s, expected a list to take '%.*s' of", node_kind(list),
					   (int)length, component);
		else if (list->n == 0)
			problem_at(loader, place, spot->path, "has no entry '%.*s' yet, expected %s", (int)length, component,
					   spot->key && spot->key->type == KEY_LIST ? "[0] to make its first one" : "its whole value");
		else
			problem_at(loader, place, spot->path, "has no entry '%.*s', expected [0] to [%d]%s", (int)length, component,
					   list->n - 1, spot->key && spot->key->type == KEY_LIST ? " or the name of one" : "");
		return false;
	}
	if (k == list->n)
		grow(loader, spot, node_new(loader, NODE_GROUP, place));
	spot->node = list->children[k];
	size_t used = strlen(spot->path);
	snprintf(spot->path + used, sizeof spot->path - used, ".[%d]", k);
	return true;
}

/* What a key that is not there yet starts from: its default, so that one entry of it can be changed. */
static struct node *node_of_default(struct loader *loader, const struct scene_key *key, struct scene_place place)
{
	if (key->value) {
		char text[128];
		struct source source;
		snprintf(text, sizeof text, "value = %s", key->value);
		source_text(loader, text, place, &source);
		return tree_parse(loader, &source, "")->children[0];
	}
	return node_new(loader,
					key->type == KEY_LIST    ? NODE_LIST
					: key->type == KEY_GROUP ? NODE_GROUP
											 : NODE_ARRAY,
					place);
}

/* One step into a group, which grows the key if the table knows it. */
static bool step_key(struct loader *loader, struct spot *spot, const struct scene_table *tables, const char *component,
					 size_t length, const char *whole, struct scene_place place)
{
	char name[SCENE_NAME];
	const struct scene_key *keys = tables_choose(tables, spot->node), *key = NULL;
	if (length < sizeof name) {
		memcpy(name, component, length), name[length] = '\0';
		key = keys ? keys_find(keys, name) : NULL;
	}
	if (!key || spot->node->type != NODE_GROUP) {
		unknown(loader, place, whole);
		return false;
	}
	struct node *next = node_find(spot->node, name);
	if (!next) {
		next = node_of_default(loader, key, place);
		next->name = loader_string(loader, name);
		grow(loader, spot, next);
	}
	spot->node = next, spot->key = key;
	size_t used = strlen(spot->path);
	snprintf(spot->path + used, sizeof spot->path - used, "%s%s", used ? "." : "", name);
	return true;
}

/* Walks a path, making what the table knows and the tree lacks. */
static bool follow(struct loader *loader, struct spot *spot, const struct node *root, const char *path,
				   struct scene_place place)
{
	for (const char *at = path;; at += strcspn(at, ".") + 1) {
		size_t n = strcspn(at, ".");
		bool last = at[n] == '\0';
		const struct scene_table *tables = spot->node == root ? loader->kind->tables
										   : spot->key        ? spot->key->tables
															  : NULL;
		if (spot->node->type == NODE_GROUP && tables) {
			if (!step_key(loader, spot, tables, at, n, path, place))
				return false;
		} else {
			if (!step_element(loader, spot, at, n, last, place))
				return false;
			/* an element of a list of groups is a group of that key; one inside a value has no key of its own */
			if (spot->key && spot->key->type != KEY_LIST)
				spot->key = NULL;
		}
		if (last)
			return true;
	}
}

void tree_set(struct loader *loader, struct node *root, const char *assignment, struct scene_place place)
{
	const char *equals = strchr(assignment, '=');
	if (!equals || equals == assignment) {
		problem_at(loader, place, "", "'%s' assigns nothing, expected path=value such as grid.cell=0.1", assignment);
		return;
	}
	size_t length = (size_t)(equals - assignment);
	while (length && strchr(" \t", assignment[length - 1]))
		length--;
	while (length && strchr(" \t", *assignment))
		assignment++, length--;
	char *path = loader_alloc(loader, length + 1);
	memcpy(path, assignment, length);
	if (length >= PATH_LENGTH - 16) {
		problem_at(loader, place, "", "a path of %zu characters, expected a shorter one", length);
		return;
	}
	const char *value = equals + 1 + strspn(equals + 1, " \t");

	struct spot spot = {.node = root};
	bool found = follow(loader, &spot, root, path, place);
	bool bare = spot.node->name ? takes_text(spot.key) : spot.node->type == NODE_STRING;
	struct node *parsed = found ? parse_value(loader, bare, value, place, spot.path) : NULL;
	if (parsed) {
		char *name = spot.node->name;
		*spot.node = *parsed;
		spot.node->name = name;
	} else if (spot.grown) {
		spot.grown->n--;
	}
}

/* ---- variants ---- */

struct chain {
	const struct chain *up;
	const char *path;
	int depth;
};

static struct node *load(struct loader *loader, const char *path, struct scene_place from, const struct chain *up);

static struct node *load_variant(struct loader *loader, struct node *variant, const struct chain *chain)
{
	struct node *base = node_find(variant, "base"), *set = node_find(variant, "set"),
				*title = node_find(variant, "title");
	for (int k = 0; k < variant->n; k++) {
		struct node *child = variant->children[k];
		if (child != base && child != set && child != title)
			problem_at(loader, child->place, child->name,
					   "stands in a variant, expected only title, base and set = (\"%s=...\")", child->name);
	}
	if (!base) {
		problem_at(loader, set->place, "set", "needs a %s to change, expected base = \"file.cfg\" beside it",
				   loader->kind->name);
		return NULL;
	}
	if (base->type != NODE_STRING) {
		problem_at(loader, base->place, "base", "is %s, expected the name of a %s file in quotes", node_kind(base),
				   loader->kind->name);
		return NULL;
	}
	struct node *root = load(loader, path_beside(loader, chain->path, base->string), base->place, chain);
	if (!root)
		return NULL;
	if (title) {
		struct node *old = node_find(root, "title");
		if (old)
			*old = *title;
		else
			node_append(loader, root, title);
	}
	if (set && set->type != NODE_LIST && set->type != NODE_ARRAY) {
		problem_at(loader, set->place, "set", "is %s, expected a list of strings: (\"path=value\", ...)",
				   node_kind(set));
		return root;
	}
	for (int k = 0; set && k < set->n; k++) {
		struct node *s = set->children[k];
		if (s->type == NODE_STRING)
			tree_set(loader, root, s->string, s->place);
		else
			problem_at(loader, s->place, "set", "holds %s, expected a string \"path=value\"", node_kind(s));
	}
	return root;
}

static struct node *load(struct loader *loader, const char *path, struct scene_place from, const struct chain *up)
{
	struct chain chain = {.up = up, .path = path, .depth = up ? up->depth + 1 : 0};
	for (const struct chain *c = up; c; c = c->up)
		if (!strcmp(c->path, path) || chain.depth > BASES_MAX) {
			problem_at(loader, from, "base", "comes back to '%s', expected a chain that ends", path);
			return NULL;
		}
	struct source source;
	if (!source_read(loader, path, from, &source))
		return NULL;
	struct node *root = tree_parse(loader, &source, "");
	if (root && (node_find(root, "base") || node_find(root, "set")))
		return load_variant(loader, root, &chain);
	return root;
}

struct node *tree_load(struct loader *loader, const char *path, struct scene_place from)
{
	return load(loader, path, from, NULL);
}
