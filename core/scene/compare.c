#include "scene/compare.h"

#include <libconfig.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const free_settings[] = {"title", "output", "images", "inspect", "catalyst", "guards"};
static const char *const free_of_laws[] = {"overlap_max", "path"}; /* the path is asked for when states are read */

/* What is free among a law's settings: in the elements of `list`, or in their groups `inner`. */
static void compare_drop_of_laws(config_setting_t *list, const char *inner)
{
	for (int i = 0; list && i < config_setting_length(list); i++) {
		config_setting_t *law = config_setting_get_elem(list, (unsigned)i);
		if (law && inner)
			law = config_setting_is_group(law) ? config_setting_get_member(law, inner) : NULL;
		for (size_t k = 0; law && config_setting_is_group(law) && k < sizeof free_of_laws / sizeof *free_of_laws; k++)
			if (config_setting_get_member(law, free_of_laws[k]))
				config_setting_remove(law, free_of_laws[k]);
	}
}

static void compare_drop_free(config_t *config)
{
	config_setting_t *root = config_root_setting(config);
	for (size_t i = 0; i < sizeof free_settings / sizeof *free_settings; i++)
		if (config_setting_get_member(root, free_settings[i]))
			config_setting_remove(root, free_settings[i]);
	compare_drop_of_laws(config_setting_get_member(root, "laws"), NULL);
	compare_drop_of_laws(config_setting_get_member(root, "materials"), "law");
	config_setting_t *time = config_setting_get_member(root, "time");
	if (time && config_setting_get_member(time, "end"))
		config_setting_remove(time, "end");
}

static void compare_print(const config_setting_t *setting, char *text, size_t size)
{
	switch (setting ? config_setting_type(setting) : CONFIG_TYPE_NONE) {
	case CONFIG_TYPE_NONE:
		snprintf(text, size, "absent");
		break;
	case CONFIG_TYPE_INT:
	case CONFIG_TYPE_INT64:
		snprintf(text, size, "%lld", config_setting_get_int64(setting));
		break;
	case CONFIG_TYPE_FLOAT:
		snprintf(text, size, "%.15g", config_setting_get_float(setting));
		if (strtod(text, NULL) != config_setting_get_float(setting))
			snprintf(text, size, "%.17g", config_setting_get_float(setting));
		break;
	case CONFIG_TYPE_BOOL:
		snprintf(text, size, "%s", config_setting_get_bool(setting) ? "true" : "false");
		break;
	case CONFIG_TYPE_STRING:
		snprintf(text, size, "\"%.200s\"", config_setting_get_string(setting));
		break;
	default:
		snprintf(text, size, "a group or list of %d", config_setting_length(setting));
	}
}

static int compare_difference(const char *path, const config_setting_t *a, const config_setting_t *b, char *what,
							  size_t size)
{
	char before[256], now[256];
	compare_print(a, before, sizeof before);
	compare_print(b, now, sizeof now);
	snprintf(what, size, "%s: %s before, %s now", path, before, now);
	return 0;
}

static int compare_is_number(const config_setting_t *s)
{
	int type = config_setting_type(s);
	return type == CONFIG_TYPE_INT || type == CONFIG_TYPE_INT64 || type == CONFIG_TYPE_FLOAT;
}

static double compare_number(const config_setting_t *s)
{
	return config_setting_type(s) == CONFIG_TYPE_FLOAT ? config_setting_get_float(s)
													   : (double)config_setting_get_int64(s);
}

static int compare_scalar(const config_setting_t *a, const config_setting_t *b)
{
	if (compare_is_number(a) && compare_is_number(b)) /* 1 and 1.0 are the same value */
		return compare_number(a) == compare_number(b);
	if (config_setting_type(a) != config_setting_type(b))
		return 0;
	if (config_setting_type(a) == CONFIG_TYPE_BOOL)
		return config_setting_get_bool(a) == config_setting_get_bool(b);
	return !strcmp(config_setting_get_string(a), config_setting_get_string(b));
}

static int compare_settings(const char *path, const config_setting_t *a, const config_setting_t *b, char *what,
							size_t size);

static int compare_child(const char *path, const config_setting_t *child, int index, const config_setting_t *a,
						 const config_setting_t *b, char *what, size_t size)
{
	char inner[512];
	const char *name = config_setting_name(child);
	if (name)
		snprintf(inner, sizeof inner, "%s%s%s", path, *path ? "." : "", name);
	else
		snprintf(inner, sizeof inner, "%s.[%d]", path, index);
	return compare_settings(inner, a, b, what, size);
}

/* Members are compared by name, elements by index; what only one side has is a difference. */
static int compare_settings(const char *path, const config_setting_t *a, const config_setting_t *b, char *what,
							size_t size)
{
	if (!a || !b || config_setting_is_aggregate(a) != config_setting_is_aggregate(b))
		return compare_difference(path, a, b, what, size);
	if (!config_setting_is_aggregate(a))
		return compare_scalar(a, b) ? 1 : compare_difference(path, a, b, what, size);
	for (int i = 0; i < config_setting_length(a); i++) {
		const config_setting_t *child = config_setting_get_elem(a, (unsigned)i);
		const char *name = config_setting_name(child);
		const config_setting_t *other =
			name ? config_setting_get_member(b, name) : config_setting_get_elem(b, (unsigned)i);
		if (!compare_child(path, child, i, child, other, what, size))
			return 0;
	}
	for (int i = 0; i < config_setting_length(b); i++) {
		const config_setting_t *child = config_setting_get_elem(b, (unsigned)i);
		const char *name = config_setting_name(child);
		if (name ? !config_setting_get_member(a, name) : i >= config_setting_length(a))
			return compare_child(path, child, i, NULL, child, what, size);
	}
	return 1;
}

int scene_compare(const char *before, const char *now, char *what, size_t size)
{
	config_t a, b;
	config_init(&a);
	config_init(&b);
	int same = 0;
	if (config_read_string(&a, before) != CONFIG_TRUE || config_read_string(&b, now) != CONFIG_TRUE) {
		snprintf(what, size, "its scene cannot be read");
	} else {
		compare_drop_free(&a);
		compare_drop_free(&b);
		same = compare_settings("", config_root_setting(&a), config_root_setting(&b), what, size);
	}
	config_destroy(&a);
	config_destroy(&b);
	return same;
}
