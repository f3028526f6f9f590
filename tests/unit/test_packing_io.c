/* Packings on disk: every bit there and back, mistakes told with their line, a cache that cannot do harm. */
/* timeout: 120 */
#include <dirent.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#include "base/error.h"
#include "io/file.h"
#include "rve/packing.h"

static char folder[] = "/tmp/tmdempm-packing-XXXXXX";
static const struct rve_packing_params small = {
	.discs = 100,
	.radius_min = 0.25e-3,
	.radius_max = 0.5e-3,
	.pressure = 50e3,
	.mu = 0.5,
	.void_ratio = NAN,
	.seed = 7,
};
static struct rve_params grains;

static const char *in_folder(const char *name)
{
	static char path[4][FILE_PATH];
	static int k;
	k = (k + 1) % 4;
	assert_int_equal(file_join(path[k], folder, name), 0);
	return path[k];
}

static void remove_tree(const char *path)
{
	char inside[FILE_PATH];
	DIR *dir = opendir(path);
	for (struct dirent *entry; dir && (entry = readdir(dir));) {
		if (strcmp(entry->d_name, ".") == 0 || strcmp(entry->d_name, "..") == 0)
			continue;
		file_join(inside, path, entry->d_name);
		remove_tree(inside);
	}
	if (dir)
		closedir(dir);
	remove(path);
}

static int make_folder(void **state)
{
	(void)state;
	rve_params_default(&grains);
	return mkdtemp(folder) && setenv("XDG_CACHE_HOME", folder, 1) == 0 ? 0 : -1;
}

static int remove_folder(void **state)
{
	(void)state;
	remove_tree(folder);
	return 0;
}

/* The only packing in the cache folder; NULL if there is none. */
static const char *cache_file(int *count)
{
	static char path[FILE_PATH];
	const char *packings = in_folder("tmdempm/packings");
	DIR *dir = opendir(packings);
	*count = 0;
	for (struct dirent *entry; dir && (entry = readdir(dir));)
		if (strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0) {
			file_join(path, packings, entry->d_name);
			++*count;
		}
	if (dir)
		closedir(dir);
	return *count ? path : NULL;
}

static void assert_same(const struct rve_packing *a, const struct rve_packing *b)
{
	assert_int_equal(a->n_discs, b->n_discs);
	assert_int_equal(a->n_contacts, b->n_contacts);
	assert_memory_equal(a->H, b->H, sizeof a->H);
	assert_memory_equal(a->x, b->x, (size_t)a->n_discs * sizeof *a->x);
	assert_memory_equal(a->r, b->r, (size_t)a->n_discs * sizeof *a->r);
	if (a->n_contacts > 0) {
		assert_memory_equal(a->pair, b->pair, (size_t)a->n_contacts * sizeof *a->pair);
		assert_memory_equal(a->ft, b->ft, (size_t)a->n_contacts * sizeof *a->ft);
	}
}

static void hdf5_keeps_every_bit(void **state)
{
	(void)state;
	struct rve_packing *a, *b;
	assert_int_equal(rve_packing_generate(&a, &small, &grains), 0);
	assert_true(a->n_contacts > 100);
	const char *path = in_folder("P.h5");
	assert_int_equal(rve_packing_write(a, path), 0);
	assert_int_equal(rve_packing_read(&b, path), 0);
	assert_same(a, b);
	assert_memory_equal(&a->pressure, &b->pressure, sizeof(double));
	assert_memory_equal(&a->mu, &b->mu, sizeof(double));
	assert_memory_equal(&a->void_ratio, &b->void_ratio, sizeof(double));
	assert_memory_equal(&a->unbalanced, &b->unbalanced, sizeof(double));
	assert_int_equal(a->seed, b->seed);

	/* the same packing gives the same file */
	char *first, *second;
	size_t n, m;
	assert_int_equal(file_read(&first, &n, path), 0);
	sleep(1); /* another second on the clock */
	assert_int_equal(rve_packing_write(b, path), 0);
	assert_int_equal(file_read(&second, &m, path), 0);
	assert_int_equal(n, m);
	assert_memory_equal(first, second, n);
	free(first);
	free(second);
	rve_packing_free(a);
	rve_packing_free(b);
}

static void csv_keeps_the_discs(void **state)
{
	(void)state;
	struct rve_packing *a, *b;
	assert_int_equal(rve_packing_generate(&a, &small, &grains), 0);
	assert_int_equal(rve_packing_write(a, in_folder("P.csv")), 0);
	assert_int_equal(rve_packing_read(&b, in_folder("P.csv")), 0);
	a->n_contacts = 0; /* tangential forces start at zero */
	assert_same(a, b);
	assert_true(b->void_ratio == rve_packing_void_ratio(a));
	assert_true(isnan(b->pressure));
	rve_packing_free(a);
	rve_packing_free(b);
}

static void other_codes_csv_loads(void **state)
{
	(void)state;
	struct rve_packing *p;
	const char *path = in_folder("yade.csv"), *text = "# made with another code\n"
													  "# Here is how\n"
													  "#H 4e-3 1e-3 0 4e-3 m (row-major), periodic\r\n"
													  "id,x,y,r\n"
													  "17, 1e-3, 1e-3, 1e-3\n"
													  "3, 5e-3, 3e-3, 0.9e-3\n";
	assert_int_equal(file_write(path, text, strlen(text)), 0);
	assert_int_equal(rve_packing_read(&p, path), 0);
	const double H[4] = {4e-3, 1e-3, 0, 4e-3};
	assert_memory_equal(p->H, H, sizeof H);
	assert_int_equal(p->n_discs, 2);
	assert_int_equal(p->n_contacts, 0);
	assert_true(p->x[1][0] == 5e-3 && p->x[1][1] == 3e-3 && p->r[1] == 0.9e-3);
	rve_packing_free(p);
}

#define CELL "# H 4e-3 0 0 4e-3\n"

static void mistakes_in_csv_are_told(void **state)
{
	(void)state;
	const struct {
		const char *text, *message;
	} cases[] = {
		{"1,0,0,1e-3\n", ":1: no line gives the cell"},
		{"# H 4e-3 0 0\n1,0,0,1e-3\n", ":1: the cell has fewer than four numbers"},
		{CELL "1,0,0,1e-3\n" CELL, ":3: a second cell (the first is in line 1)"},
		{"#\n# H 4e-3 0 0 -4e-3\n1,0,0,1e-3\n", ":2: det(H) is not positive"},
		{"# H 4e-3 0 0 inf\n1,0,0,1e-3\n", ":1: the cell H is not finite"},
		{CELL, ": 0 discs, expected rows id,x,y,r"},
		{CELL "1,0,0\n", ":2: 3 cells, expected 4 (id,x,y,r)"},
		{CELL "1,0,0,1e-3\n2,zwei,0,1e-3\n", ":3: cell 2 is \"zwei\", expected a number"},
		{CELL "1,0,0,1e-3\n2,0,nan,1e-3\n", ":3: its centre is (0, nan), expected finite numbers"},
		{CELL "1,0,0,1e-3\n2,0,0,-1e-3\n", ":3: its radius is -0.001, expected a positive number"},
		{CELL "1,0,0,0\n", ":2: its radius is 0, expected a positive number"},
		{CELL "5,0,0,1e-3\n4,0,0,1e-3\n5,2e-3,0,1e-3\n", ":4: disc 5 is there already (line 2)"},
		{CELL "1.5,0,0,1e-3\n", ":2: the id is 1.5, expected a whole number"},
		{CELL "1,0,0,1\n", ":1: the discs fill more than the whole cell"},
	};
	const char *path = in_folder("wrong.csv");
	for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
		struct rve_packing *p;
		assert_int_equal(file_write(path, cases[k].text, strlen(cases[k].text)), 0);
		assert_int_equal(rve_packing_read(&p, path), STATUS_INPUT);
		assert_null(p);
		assert_int_equal(strncmp(error_message(), path, strlen(path)), 0);
		if (!strstr(error_message(), cases[k].message))
			fail_msg("\"%s\" does not say \"%s\"", error_message(), cases[k].message);
	}
}

static void files_that_are_no_packings(void **state)
{
	(void)state;
	struct rve_packing *p;
	assert_int_equal(rve_packing_read(&p, in_folder("absent.h5")), STATUS_RESOURCE);
	assert_non_null(strstr(error_message(), "absent.h5: No such file"));
	assert_int_equal(rve_packing_read(&p, in_folder("P.vtk")), STATUS_INPUT);
	assert_non_null(strstr(error_message(), "expected a name that ends in .h5 or .csv"));
	assert_int_equal(file_write(in_folder("text.h5"), "hello", 5), 0);
	assert_int_equal(rve_packing_read(&p, in_folder("text.h5")), STATUS_INPUT);
	assert_non_null(strstr(error_message(), "text.h5: not a packing, expected a packing in HDF5"));
	assert_null(p);

	assert_int_equal(rve_packing_generate(&p, &small, &grains), 0);
	assert_int_equal(rve_packing_write(p, in_folder("no/such/folder/P.h5")), STATUS_RESOURCE);
	assert_non_null(strstr(error_message(), "No such file"));
	assert_int_equal(rve_packing_write(p, in_folder("P.txt")), STATUS_INPUT);
	rve_packing_free(p);
}

/* Any damage is seen before the HDF5 library, which may crash on it, opens the file. */
static void damaged_hdf5_is_refused(void **state)
{
	(void)state;
	struct rve_packing *whole, *p;
	char *bytes;
	size_t size;
	const char *path = in_folder("P.h5");
	assert_int_equal(rve_packing_generate(&whole, &small, &grains), 0);
	assert_int_equal(rve_packing_write(whole, path), 0);
	assert_int_equal(file_read(&bytes, &size, path), 0);
	const char *damaged = in_folder("damaged.h5");
	for (size_t k = 0; k < 400; k++) {
		size_t at = k * 2654435761u % size;
		bytes[at] ^= (char)(1 << k % 8);
		assert_int_equal(file_write(damaged, bytes, size), 0);
		bytes[at] ^= (char)(1 << k % 8);
		assert_int_equal(rve_packing_read(&p, damaged), STATUS_INPUT);
		assert_null(p);
	}
	for (size_t length = 0; length < size; length += size / 37) {
		assert_int_equal(file_write(damaged, bytes, length), 0);
		assert_int_equal(rve_packing_read(&p, damaged), STATUS_INPUT);
	}
	free(bytes);
	rve_packing_free(whole);
}

static void cache_gives_the_same_packing(void **state)
{
	(void)state;
	struct rve_packing *fresh, *first, *second, *other;
	struct stat before, after;
	int count;
	assert_int_equal(rve_packing_generate(&fresh, &small, &grains), 0);
	assert_int_equal(rve_packing_cached(&first, &small, &grains), 0);
	assert_int_equal(stat(cache_file(&count), &before), 0);
	assert_int_equal(count, 1);
	assert_int_equal(rve_packing_cached(&second, &small, &grains), 0);
	assert_int_equal(stat(cache_file(&count), &after), 0);
	assert_int_equal(before.st_ino, after.st_ino); /* not written again */
	assert_same(fresh, first);
	assert_same(fresh, second);

	struct rve_packing_params how = small;
	how.seed = 8;
	assert_int_equal(rve_packing_cached(&other, &how, &grains), 0);
	assert_int_not_equal(memcmp(other->x, fresh->x, sizeof *fresh->x), 0);
	cache_file(&count);
	assert_int_equal(count, 2);
	rve_packing_free(fresh);
	rve_packing_free(first);
	rve_packing_free(second);
	rve_packing_free(other);
	remove_tree(in_folder("tmdempm"));
}

static void corrupt_cache_is_made_again(void **state)
{
	(void)state;
	struct rve_packing *fresh, *p;
	char *bytes;
	size_t size;
	int count;
	assert_int_equal(rve_packing_cached(&fresh, &small, &grains), 0);
	const char *path = cache_file(&count);
	assert_int_equal(file_read(&bytes, &size, path), 0);
	for (int damage = 0; damage < 3; damage++) {
		char *copy = malloc(size);
		memcpy(copy, bytes, size);
		copy[size - 100] ^= 1; /* a tangential force, or what else ends the file */
		memset(copy + size / 2, damage == 2 ? 0xff : copy[size / 2], 64);
		assert_int_equal(file_write(path, copy, damage == 0 ? size / 3 : size), 0);
		free(copy);
		assert_int_equal(rve_packing_cached(&p, &small, &grains), 0);
		assert_same(fresh, p);
		rve_packing_free(p);
		assert_int_equal(rve_packing_read(&p, cache_file(&count)), 0); /* and stored again */
		assert_same(fresh, p);
		rve_packing_free(p);
		assert_int_equal(count, 1);
	}
	free(bytes);
	rve_packing_free(fresh);
	remove_tree(in_folder("tmdempm"));
}

static void unwritable_cache_is_no_error(void **state)
{
	(void)state;
	struct rve_packing *p;
	/* a file where the folder would be: nobody, not even root, can make it */
	assert_int_equal(file_write(in_folder("tmdempm"), "x", 1), 0);
	assert_int_equal(rve_packing_cached(&p, &small, &grains), 0);
	rve_packing_free(p);
	remove(in_folder("tmdempm"));
	unsetenv("XDG_CACHE_HOME");
	char *home = strdup(getenv("HOME") ? getenv("HOME") : "/");
	unsetenv("HOME");
	assert_int_equal(rve_packing_cached(&p, &small, &grains), 0);
	rve_packing_free(p);
	setenv("HOME", home, 1);
	setenv("XDG_CACHE_HOME", folder, 1);
	free(home);
}

static void processes_may_share_the_cache(void **state)
{
	(void)state;
	enum { PROCESSES = 4 };
	pid_t children[PROCESSES];
	struct rve_packing *fresh, *p;
	int count;
	assert_int_equal(rve_packing_generate(&fresh, &small, &grains), 0);
	for (int k = 0; k < PROCESSES; k++) {
		children[k] = fork();
		assert_true(children[k] >= 0);
		if (children[k] > 0)
			continue;
		int failed = 0;
		for (int round = 0; round < 3; round++) {
			failed |= rve_packing_cached(&p, &small, &grains) || p->n_contacts != fresh->n_contacts ||
					  memcmp(p->ft, fresh->ft, (size_t)p->n_contacts * sizeof *p->ft) != 0;
			if (round == 0 && k == 0)
				remove(cache_file(&count)); /* somebody clears the cache meanwhile */
		}
		_exit(failed);
	}
	for (int k = 0; k < PROCESSES; k++) {
		int status;
		assert_int_equal(waitpid(children[k], &status, 0), children[k]);
		assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 0);
	}
	assert_int_equal(rve_packing_read(&p, cache_file(&count)), 0);
	assert_int_equal(count, 1); /* no temporary files are left */
	assert_same(fresh, p);
	rve_packing_free(p);
	rve_packing_free(fresh);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(hdf5_keeps_every_bit),         cmocka_unit_test(csv_keeps_the_discs),
		cmocka_unit_test(other_codes_csv_loads),        cmocka_unit_test(mistakes_in_csv_are_told),
		cmocka_unit_test(files_that_are_no_packings),   cmocka_unit_test(damaged_hdf5_is_refused),
		cmocka_unit_test(cache_gives_the_same_packing), cmocka_unit_test(corrupt_cache_is_made_again),
		cmocka_unit_test(unwritable_cache_is_no_error), cmocka_unit_test(processes_may_share_the_cache),
	};
	return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
