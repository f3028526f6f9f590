#include <libconfig.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scene/private.h"

/* ---- building ---- */

struct node *node_new(struct loader *loader, enum node_type type, struct scene_place place)
{
	struct node *node = loader_alloc(loader, sizeof *node);
	node->type = type, node->place = place;
	return node;
}

void node_append(struct loader *loader, struct node *parent, struct node *child)
{
	parent->children = loader_grow(loader, parent->children, parent->n, &parent->capacity, sizeof *parent->children);
	parent->children[parent->n++] = child;
}

struct node *node_find(const struct node *group, const char *name)
{
	for (int k = 0; group && k < group->n; k++)
		if (group->children[k]->name && !strcmp(group->children[k]->name, name))
			return group->children[k];
	return NULL;
}

const char *node_kind(const struct node *node)
{
	static const char *const kinds[] = {"a group",  "a list",     "an array", "an integer",
										"a number", "true/false", "a string"};
	return kinds[node->type];
}

/* ---- from libconfig ---- */

static struct scene_place place_of(const struct source *source, int line)
{
	int k = line < 1 ? 0 : line > source->n_lines ? source->n_lines - 1 : line - 1;
	return source->places[k];
}

static struct node *convert(struct loader *loader, const struct source *source, const config_setting_t *s)
{
	/* s->line, not config_setting_source_line(), which cuts it to 16 bits */
	struct node *node = node_new(loader, NODE_GROUP, place_of(source, (int)s->line));
	if (s->name)
		node->name = loader_string(loader, s->name);
	switch (s->type) {
	case CONFIG_TYPE_GROUP:
		node->type = NODE_GROUP;
		break;
	case CONFIG_TYPE_LIST:
		node->type = NODE_LIST;
		break;
	case CONFIG_TYPE_ARRAY:
		node->type = NODE_ARRAY;
		break;
	case CONFIG_TYPE_INT:
		node->type = NODE_INTEGER, node->integer = s->value.ival;
		break;
	case CONFIG_TYPE_INT64:
		node->type = NODE_INTEGER, node->integer = s->value.llval;
		break;
	case CONFIG_TYPE_FLOAT:
		node->type = NODE_NUMBER, node->number = s->value.fval;
		break;
	case CONFIG_TYPE_BOOL:
		node->type = NODE_BOOL, node->integer = s->value.ival != 0;
		break;
	default:
		node->type = NODE_STRING;
		node->string = loader_string(loader, s->value.sval ? s->value.sval : "");
	}
	if (node->type == NODE_INTEGER)
		node->number = (double)node->integer;
	for (int k = 0; config_setting_is_aggregate(s) && k < config_setting_length(s); k++) {
		const config_setting_t *child = config_setting_get_elem(s, (unsigned)k);
		if (!child->name || !strstr(child->name, DUPLICATE_MARK))
			node_append(loader, node, convert(loader, source, child));
	}
	return node;
}

struct node *tree_parse(struct loader *loader, const struct source *source, const char *path)
{
	config_t config;
	config_init(&config);
	loader->config = &config; /* a jump out of here must not leak it */
	struct node *root = NULL;
	if (config_read_string(&config, source->text))
		root = convert(loader, source, config_root_setting(&config));
	else
		problem_at(loader, place_of(source, config_error_line(&config)), path,
				   "%s, expected name = value; or name = { ... };",
				   config_error_text(&config) ? config_error_text(&config) : "syntax error");
	loader->config = NULL;
	config_destroy(&config);
	return root;
}

/* ---- walking ---- */

struct node *tree_walk(struct node *root, const char *path)
{
	struct node *node = root;
	while (node && *path) {
		size_t length = strcspn(path, ".");
		struct node *next = NULL;
		if (*path == '[') {
			long k = strtol(path + 1, NULL, 10);
			if (k >= 0 && k < node->n)
				next = node->children[k];
		} else {
			for (int k = 0; !next && k < node->n; k++) {
				const char *name = node->children[k]->name;
				if (name && strlen(name) == length && !memcmp(name, path, length))
					next = node->children[k];
			}
		}
		if (!next)
			break;
		node = next;
		path += length + (path[length] == '.');
	}
	return node;
}

/* ---- to text ---- */

/* The shortest decimal that reads back as the same bits; libconfig itself keeps 15 digits only. */
static void write_number(double value, FILE *out)
{
	char text[40];
	for (int digits = 15; digits <= 17; digits++) {
		snprintf(text, sizeof text, "%.*g", digits, value);
		if (strtod(text, NULL) == value)
			break;
	}
	fputs(text, out);
	if (!strpbrk(text, ".en"))
		fputs(".0", out);
}

static void write_string(const char *text, FILE *out)
{
	fputc('"', out);
	for (; *text; text++)
		if (*text == '"' || *text == '\\')
			fprintf(out, "\\%c", *text);
		else if ((unsigned char)*text < ' ')
			fprintf(out, "\\x%02x", (unsigned char)*text);
		else
			fputc(*text, out);
	fputc('"', out);
}

static void indent(int depth, FILE *out)
{
	for (int k = 0; k < depth; k++)
		fputc('\t', out);
}

static void write_node(const struct node *node, int depth, FILE *out);

static void write_members(const struct node *group, int depth, FILE *out)
{
	for (int k = 0; k < group->n; k++) {
		indent(depth, out);
		fprintf(out, "%s = ", group->children[k]->name);
		write_node(group->children[k], depth, out);
		fputs(";\n", out);
	}
}

static void write_elements(const struct node *list, int depth, FILE *out)
{
	fputc('(', out);
	for (int k = 0; k < list->n; k++) {
		fputs(k ? ", " : "", out);
		write_node(list->children[k], depth, out);
	}
	fputc(')', out);
}

static bool is_long(const struct node *node) { return node->integer != (int)node->integer; }

/* libconfig takes an array of one type only: an override may have put [1, 0.5] together. */
static void write_array(const struct node *array, FILE *out)
{
	bool floats = false, longs = false;
	for (int k = 0; k < array->n; k++) {
		floats |= array->children[k]->type == NODE_NUMBER;
		longs |= array->children[k]->type == NODE_INTEGER && is_long(array->children[k]);
	}
	fputc('[', out);
	for (int k = 0; k < array->n; k++) {
		const struct node *node = array->children[k];
		fputs(k ? ", " : "", out);
		if (node->type == NODE_INTEGER)
			fprintf(out, "%lld%s", node->integer, floats ? ".0" : longs ? "L" : "");
		else
			write_node(node, 0, out);
	}
	fputc(']', out);
}

static void write_node(const struct node *node, int depth, FILE *out)
{
	switch (node->type) {
	case NODE_GROUP:
		fputs("{\n", out);
		write_members(node, depth + 1, out);
		indent(depth, out);
		fputc('}', out);
		break;
	case NODE_LIST:
		write_elements(node, depth, out);
		break;
	case NODE_ARRAY:
		write_array(node, out);
		break;
	case NODE_INTEGER:
		fprintf(out, "%lld%s", node->integer, is_long(node) ? "L" : "");
		break;
	case NODE_NUMBER:
		write_number(node->number, out);
		break;
	case NODE_BOOL:
		fputs(node->integer ? "true" : "false", out);
		break;
	case NODE_STRING:
		write_string(node->string, out);
		break;
	}
}

void tree_write(const struct node *root, FILE *out) { write_members(root, 0, out); }
