/* Damaged scenes: cut short, with bytes changed, pieces moved.  Whatever comes, the loader returns a scene or an
 * input error with a message, and (under the sanitizers) touches and leaks no memory that it should not. */
#define _GNU_SOURCE /* memfd_create */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "base/error.h"
#include "scene/scene.h"

static char path[64]; /* of a file in memory: thousands of scenes should not wait for a disk */
static int file;
static char *seeds[3];
static uint64_t random_state = 1;

static uint32_t draw(uint32_t below)
{
	random_state = random_state * 6364136223846793005u + 1442695040888963407u;
	return (uint32_t)(random_state >> 33) % below;
}

static char *slurp(const char *name)
{
	char full[512], *text = calloc(1, 1 << 16);
	snprintf(full, sizeof full, SOURCE_DIR "/scenarios/%s", name);
	FILE *in = fopen(full, "r");
	assert_non_null(in);
	assert_true(fread(text, 1, (1 << 16) - 1, in) > 100);
	fclose(in);
	return text;
}

static int set_up(void **state)
{
	(void)state;
	file = memfd_create("scene", 0);
	snprintf(path, sizeof path, "/proc/self/fd/%d", file);
	seeds[0] = slurp("reference.cfg");
	seeds[1] = slurp("tm_dempm/column_quick.cfg");
	seeds[2] = slurp("tm_dempm/silo_forced_quick.cfg");
	return file < 0 ? -1 : 0;
}

static int tear_down(void **state)
{
	(void)state;
	for (int k = 0; k < 3; k++)
		free(seeds[k]);
	return close(file);
}

static void write_scene(const char *bytes, size_t n)
{
	assert_int_equal(ftruncate(file, 0), 0);
	assert_int_equal(pwrite(file, bytes, n, 0), (ssize_t)n);
}

/* Loads `n` bytes as a scene. */
static void load(const char *bytes, size_t n, int n_sets, const char *const *sets)
{
	write_scene(bytes, n);
	char *messages;
	size_t size;
	struct scene *scene;
	FILE *errors = open_memstream(&messages, &size);
	int status = scene_load(&scene, path, n_sets, sets, errors);
	fclose(errors);
	assert_true(status == STATUS_OK ? scene != NULL && size == 0 : status == STATUS_INPUT && !scene && size > 0);
	free(messages);
	scene_free(scene);
}

static void cut_short(void **state)
{
	(void)state;
	for (int s = 0; s < 3; s++)
		for (size_t n = 0, length = strlen(seeds[s]); n < length; n += 1 + draw(40))
			load(seeds[s], n, 0, NULL);
}

/* Digits are left alone: a finer cell only costs time. */
static void bytes_changed(void **state)
{
	(void)state;
	static const char likely[] = "{}()[]=:;,\"'.#/*@\\\n\t -+eELx\0abt";
	for (int round = 0; round < 800; round++) {
		char *text = strdup(seeds[round % 3]);
		size_t length = strlen(text);
		for (uint32_t k = 0, n = 1 + draw(4); k < n; k++) {
			char *at = &text[draw((uint32_t)length)];
			if (*at < '0' || *at > '9')
				*at = draw(3) ? likely[draw(sizeof likely - 1)] : (char)draw(256);
		}
		load(text, length, 0, NULL);
		free(text);
	}
}

static void pieces_moved(void **state)
{
	(void)state;
	for (int round = 0; round < 400; round++) {
		const char *a = seeds[draw(2)], *b = seeds[draw(2)];
		uint32_t la = (uint32_t)strlen(a), lb = (uint32_t)strlen(b), cut = draw(la), from = draw(lb);
		uint32_t piece = draw(lb - from < 300 ? lb - from : 300), skip = draw(la - cut < 100 ? la - cut : 100);
		char *text = malloc(la + piece + 1);
		memcpy(text, a, cut);
		memcpy(text + cut, b + from, piece);
		memcpy(text + cut + piece, a + cut + skip, la - cut - skip);
		load(text, la + piece - skip, 0, NULL);
		free(text);
	}
}

static void overrides_garbled(void **state)
{
	(void)state;
	static const char *const paths[] = {"walls.[0].friction",
										"materials.[0].law.packing.discs",
										"bodies.[0].polygon.[0].[1]",
										"stages.[1].walls",
										"title",
										"gravity.[1]",
										"images.[2]",
										"walls.gate.line",
										"laws"};
	static const char bits[] = ".[]()={}\"0-1a eL,;@#\\";
	for (int round = 0; round < 600; round++) {
		char set[128];
		snprintf(set, sizeof set, "%s=", paths[draw(sizeof paths / sizeof *paths)]);
		if (draw(3) == 0)
			set[draw((uint32_t)strlen(set))] = bits[draw(sizeof bits - 1)];
		for (uint32_t k = 0, n = draw(12), used = (uint32_t)strlen(set); k < n; k++)
			set[used + k] = bits[draw(sizeof bits - 1)], set[used + k + 1] = '\0';
		const char *sets[] = {set};
		write_scene(seeds[1], strlen(seeds[1]));
		struct scene *scene;
		int status = scene_load(&scene, path, 1, sets, NULL);
		assert_true(status == STATUS_OK || status == STATUS_INPUT);
		scene_free(scene);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(cut_short),
		cmocka_unit_test(bytes_changed),
		cmocka_unit_test(pieces_moved),
		cmocka_unit_test(overrides_garbled),
	};
	return cmocka_run_group_tests(tests, set_up, tear_down);
}
