/* scenarios/reference.cfg is true: it loads, it holds every key of the table with its default, and behind each
 * key stands what the table says about it.  (That it holds nothing else follows from its loading.) */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include <libconfig.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene/private.h"

#define REFERENCE SOURCE_DIR "/scenarios/reference.cfg"

static config_t reference;
static char *lines[2000];
static int n_lines;

/* ---- reading the file once more, without the loader ---- */

static int open_reference(void **state)
{
	(void)state;
	FILE *in = fopen(REFERENCE, "r");
	assert_non_null(in);
	char line[1024];
	while (fgets(line, sizeof line, in)) {
		assert_true(n_lines < 2000);
		line[strcspn(line, "\n")] = '\0';
		lines[n_lines++] = strdup(line);
	}
	fclose(in);
	config_init(&reference);
	assert_true(config_read_file(&reference, REFERENCE));
	return 0;
}

static int close_reference(void **state)
{
	(void)state;
	config_destroy(&reference);
	for (int k = 0; k < n_lines; k++)
		free(lines[k]);
	return 0;
}

/* ---- one key of the table against the file ---- */

struct search {
	char wanted[PATH_LENGTH];
	const struct scene_key *key;
	char comment[1024];
	config_t fallback;
	int found, explained, as_default;
};

static int same_value(const config_setting_t *a, const config_setting_t *b)
{
	if (config_setting_is_number(a) && config_setting_is_number(b)) {
		double x = a->type == CONFIG_TYPE_FLOAT ? a->value.fval : (double)config_setting_get_int64(a);
		double y = b->type == CONFIG_TYPE_FLOAT ? b->value.fval : (double)config_setting_get_int64(b);
		return x == y;
	}
	if (a->type != b->type)
		return 0;
	if (a->type == CONFIG_TYPE_STRING)
		return !strcmp(a->value.sval ? a->value.sval : "", b->value.sval ? b->value.sval : "");
	if (a->type == CONFIG_TYPE_BOOL)
		return a->value.ival == b->value.ival;
	int n = config_setting_length(a), same = n == config_setting_length(b);
	for (int k = 0; same && k < n; k++)
		same = same_value(config_setting_get_elem(a, (unsigned)k), config_setting_get_elem(b, (unsigned)k));
	return same;
}

static void look(struct search *search, const config_setting_t *setting, const char *path)
{
	if (!strcmp(path, search->wanted)) {
		const char *comment = strstr(lines[setting->line - 1], "# ");
		search->found++;
		search->explained += comment && !strcmp(comment + 2, search->comment);
		if (search->key->value)
			search->as_default += same_value(setting, config_lookup(&search->fallback, "value"));
	}
	if (!config_setting_is_aggregate(setting))
		return;
	for (int k = 0; k < config_setting_length(setting); k++) {
		const config_setting_t *child = config_setting_get_elem(setting, (unsigned)k);
		char below[PATH_LENGTH];
		path_print(below, "%s%s%s", path, *path ? "." : "", child->name ? child->name : "[]");
		look(search, child, below);
	}
}

/* A material's own law has the keys of the list of laws: said once is enough. */
static void visit(void *data, const char *path, const struct scene_key *key)
{
	static const char own[] = "materials.[].law.";
	int *n = data;
	bool is_own = !strncmp(path, own, strlen(own));
	struct search search = {.key = key};
	path_print(search.wanted, "%s%s", is_own ? "laws.[]." : "", is_own ? path + strlen(own) : path);
	scene_key_comment(key, search.comment, sizeof search.comment);
	config_init(&search.fallback);
	if (key->value) {
		char text[256];
		snprintf(text, sizeof text, "value = %s;", key->value);
		assert_true(config_read_string(&search.fallback, text));
	}
	look(&search, config_root_setting(&reference), "");
	if (!search.found && is_own) { /* as laws.[].packing.file, given in a material's law only */
		path_print(search.wanted, "%s", path);
		look(&search, config_root_setting(&reference), "");
	} else if (!search.found && !strncmp(path, "laws.[].", 8)) {
		path_print(search.wanted, "%s%s", own, path + 8);
		look(&search, config_root_setting(&reference), "");
	}
	if (!search.found)
		fail_msg("%s is missing in reference.cfg", path);
	if (!search.explained)
		fail_msg("reference.cfg does not say behind %s: # %s", path, search.comment);
	if (key->value && !search.as_default)
		fail_msg("reference.cfg does not show %s with its default, %s", path, key->value);
	config_destroy(&search.fallback);
	++*n;
}

static void every_key_is_there(void **state)
{
	(void)state;
	int n = 0;
	scene_keys_visit(visit, &n);
	assert_true(n > 150);
}

static void it_loads(void **state)
{
	(void)state;
	struct scene *scene;
	assert_int_equal(scene_load(&scene, REFERENCE, 0, NULL, stderr), 0);
	assert_int_equal(scene->n_laws, 4);
	assert_int_equal(scene->n_walls, 4);
	scene_free(scene);
}

/* Every key says what it is; a value cannot be both required and defaulted. */
static void check_key(void *data, const char *path, const struct scene_key *key)
{
	(void)data;
	if (!key->doc || !key->doc[0])
		fail_msg("%s has no documentation", path);
	bool group = key->type == KEY_GROUP;
	if (!!key->value + !!key->absent + key->required != 1 && !(group && !key->value && !key->absent))
		fail_msg("%s: one of value, absent and required", path);
	if ((key->type == KEY_CUSTOM) != (key->read != NULL) || (key->type == KEY_CUSTOM && !key->expected))
		fail_msg("%s: a custom key needs read and expected, others must not have them", path);
	if ((key->type == KEY_GROUP || key->type == KEY_LIST) && !key->tables)
		fail_msg("%s has no keys", path);
}

static void the_table_is_sound(void **state)
{
	(void)state;
	scene_keys_visit(check_key, NULL);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(the_table_is_sound),
		cmocka_unit_test(it_loads),
		cmocka_unit_test(every_key_is_there),
	};
	return cmocka_run_group_tests(tests, open_reference, close_reference);
}
