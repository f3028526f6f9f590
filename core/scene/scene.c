#include "scene/scene.h"

#include <errno.h>
#include <libconfig.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "scene/private.h"

/* ---- memory: two arenas, one for loading, one that lives with the scene ---- */

struct block {
	struct block *next;
	size_t used, size;
	_Alignas(max_align_t) unsigned char bytes[];
};

static void *arena_alloc(struct block **arena, size_t bytes)
{
	size_t rounded = (bytes + 15) & ~(size_t)15;
	if (!*arena || (*arena)->size - (*arena)->used < rounded) {
		size_t size = rounded > 16384 ? rounded : 16384;
		struct block *block = calloc(1, sizeof *block + size);
		if (!block)
			return NULL;
		block->size = size, block->next = *arena;
		*arena = block;
	}
	void *memory = (*arena)->bytes + (*arena)->used;
	(*arena)->used += rounded;
	return memory;
}

void arena_free(struct block *arena)
{
	while (arena) {
		struct block *next = arena->next;
		free(arena);
		arena = next;
	}
}

void *loader_alloc(struct loader *loader, size_t bytes)
{
	void *memory = arena_alloc(&loader->scratch, bytes);
	if (!memory)
		longjmp(loader->no_memory, 1);
	return memory;
}

void *scene_alloc(struct loader *loader, size_t bytes)
{
	struct block *arena = loader->scene->storage;
	void *memory = arena_alloc(&arena, bytes);
	loader->scene->storage = arena;
	if (!memory)
		longjmp(loader->no_memory, 1);
	return memory;
}

char *loader_string(struct loader *loader, const char *text)
{
	return memcpy(loader_alloc(loader, strlen(text) + 1), text, strlen(text) + 1);
}

char *scene_string(struct loader *loader, const char *text)
{
	return memcpy(scene_alloc(loader, strlen(text) + 1), text, strlen(text) + 1);
}

void *loader_grow(struct loader *loader, void *array, int n, int *capacity, size_t element)
{
	if (n < *capacity)
		return array;
	*capacity = *capacity ? 2 * *capacity : 8;
	void *grown = loader_alloc(loader, (size_t)*capacity * element);
	if (n)
		memcpy(grown, array, (size_t)n * element);
	return grown;
}

/* ---- problems ---- */

char *path_print(char path[PATH_LENGTH], const char *format, ...)
{
	va_list args;
	va_start(args, format);
	vsnprintf(path, PATH_LENGTH, format, args);
	va_end(args);
	return path;
}

static void record(struct loader *loader, struct scene_place place, const char *path, const char *format, va_list args)
{
	char message[1024];
	vsnprintf(message, sizeof message, format, args);
	loader->problems =
		loader_grow(loader, loader->problems, loader->n_problems, &loader->capacity_problems, sizeof *loader->problems);
	struct problem *problem = &loader->problems[loader->n_problems];
	problem->place = place, problem->order = loader->n_problems++;
	problem->path = loader_string(loader, path), problem->message = loader_string(loader, message);
}

void problem_at(struct loader *loader, struct scene_place place, const char *path, const char *format, ...)
{
	va_list args;
	va_start(args, format);
	record(loader, place, path, format, args);
	va_end(args);
}

void problem_of(struct loader *loader, const char *path, const char *format, ...)
{
	va_list args;
	va_start(args, format);
	record(loader, tree_walk(loader->root, path)->place, path, format, args);
	va_end(args);
}

void loader_taint(struct loader *loader, const char *path)
{
	problem_at(loader, loader->root->place, path, "%s", "");
	loader->problems[loader->n_problems - 1].message = NULL;
}

bool loader_clean(const struct loader *loader, const char *format, ...)
{
	char path[PATH_LENGTH];
	va_list args;
	va_start(args, format);
	vsnprintf(path, sizeof path, format, args);
	va_end(args);
	size_t length = strlen(path);
	for (int k = 0; k < loader->n_problems; k++) {
		const char *other = loader->problems[k].path;
		if (!strncmp(other, path, length) && (other[length] == '\0' || other[length] == '.'))
			return false;
	}
	return true;
}

/* The files in the order in which they were read, then the command line. */
static int file_rank(const struct loader *loader, const char *file)
{
	for (int k = 0; k < loader->n_files; k++)
		if (loader->files[k] == file)
			return k;
	return loader->n_files;
}

static void sort_problems(struct loader *loader)
{
	for (int k = 1; k < loader->n_problems; k++) { /* insertion: there are few, and it keeps their order */
		struct problem moved = loader->problems[k];
		int rank = file_rank(loader, moved.place.file), j = k;
		for (; j > 0; j--) {
			const struct problem *before = &loader->problems[j - 1];
			int before_rank = file_rank(loader, before->place.file);
			if (before_rank < rank || (before_rank == rank && before->place.line <= moved.place.line))
				break;
			loader->problems[j] = *before;
		}
		loader->problems[j] = moved;
	}
}

/* Returns their number; prints them if there is where. */
static int print_problems(const struct loader *loader, FILE *out)
{
	int n = 0;
	for (int k = 0; k < loader->n_problems; k++) {
		const struct problem *p = &loader->problems[k];
		n += p->message != NULL;
		if (!out || !p->message)
			continue;
		fputs(p->place.file, out);
		if (p->place.line > 0)
			fprintf(out, ":%d", p->place.line);
		fprintf(out, ": %s%s%s\n", p->path, *p->path ? " " : "", p->message);
	}
	return n;
}

/* ---- loading ---- */

static void write_text(struct loader *loader)
{
	size_t size;
	FILE *out = open_memstream(&loader->buffer, &size);
	if (!out)
		longjmp(loader->no_memory, 1);
	tree_write(loader->root, out);
	if (fclose(out))
		longjmp(loader->no_memory, 1);
	loader->scene->text = scene_string(loader, loader->buffer);
}

/* Walls that a variant has switched off leave the scene; stages forget them. */
static void drop_inactive_walls(struct loader *loader)
{
	struct scene *scene = loader->scene;
	int *kept = loader_alloc(loader, ((size_t)scene->n_walls + 1) * sizeof *kept), n = 0;
	for (int k = 0; k < scene->n_walls; k++) {
		kept[k] = scene->walls[k].active ? n : -1;
		if (scene->walls[k].active)
			scene->walls[n++] = scene->walls[k];
	}
	scene->n_walls = n;
	scene->grid.follows = scene->grid.follows && kept[scene->grid.follow] >= 0;
	scene->grid.follow = scene->grid.follows ? kept[scene->grid.follow] : 0;
	for (int s = 0; s < scene->n_stages; s++) {
		struct scene_stage *stage = &scene->stages[s];
		int m = 0;
		for (int i = 0; i < stage->n_walls; i++)
			if (kept[stage->walls[i]] >= 0)
				stage->walls[m++] = kept[stage->walls[i]];
		if (stage->n_walls >= 0)
			stage->n_walls = m;
	}
}

static void finish(struct loader *loader, void *target)
{
	(void)target;
	read_places(loader);
	finish_scene(loader);
	check_scene(loader);
	if (loader->n_problems)
		return;
	write_text(loader);
	drop_inactive_walls(loader);
}

static const struct file_kind scene_kind = {"scene", scene_root_tables, finish};

static void load(struct loader *loader, const char *path, int n_sets, const char *const *sets)
{
	struct scene_place given = {scene_string(loader, path), 0};
	loader->root = tree_load(loader, path, given);
	for (int k = 0; loader->root && k < n_sets; k++) {
		size_t size = strlen(sets[k]) + 8;
		char *name = scene_alloc(loader, size);
		snprintf(name, size, "--set %s", sets[k]);
		tree_set(loader, loader->root, sets[k], (struct scene_place){name, 0});
	}
	if (!loader->root)
		return;
	read_group(loader, loader->kind->tables->keys, loader->root, loader->target, "");
	loader->kind->finish(loader, loader->target);
}

static void release(struct loader *loader)
{
	for (int b = 0; loader->points && b < loader->scene->n_bodies; b++)
		free(loader->points[b]);
	if (loader->config)
		config_destroy(loader->config);
	if (loader->stream)
		fclose(loader->stream);
	free(loader->buffer);
	arena_free(loader->scratch);
	free(loader);
}

int file_kind_load(const struct file_kind *kind, struct scene **storage, void *target, const char *path, int n_sets,
				   const char *const *sets, void *errors)
{
	*storage = NULL;
	if (strlen(path) >= SCENE_PATH)
		return error_set(STATUS_INPUT, "'%.60s...' is too long a path, expected at most %d characters", path,
						 SCENE_PATH - 1);
	struct loader *loader = calloc(1, sizeof *loader);
	struct scene *read = calloc(1, sizeof *read);
	int status = STATUS_RESOURCE;
	if (!loader || !read) {
		free(loader);
		free(read);
		return error_set(status, "no memory to load '%s'", path);
	}
	loader->kind = kind, loader->scene = read, loader->target = target ? target : read;
	if (setjmp(loader->no_memory)) {
		status = error_set(STATUS_RESOURCE, "no memory to load '%s'", path);
	} else {
		snprintf(read->path, sizeof read->path, "%s", path);
		load(loader, path, n_sets, sets);
		sort_problems(loader);
		int n = print_problems(loader, errors);
		status = STATUS_OK;
		if (n)
			status = error_set(loader->unreadable ? STATUS_RESOURCE : STATUS_INPUT, "%s: %d error%s", path, n,
							   n == 1 ? "" : "s");
	}
	release(loader);
	if (status)
		scene_free(read);
	else
		*storage = read;
	return status;
}

int scene_load(struct scene **scene, const char *path, int n_sets, const char *const *sets, void *errors)
{
	return file_kind_load(&scene_kind, scene, NULL, path, n_sets, sets, errors);
}

void scene_free(struct scene *scene)
{
	if (scene)
		arena_free(scene->storage);
	free(scene);
}

/* ---- values in time ---- */

double scene_value_at(double constant, const struct scene_series *series, double time)
{
	const double(*rows)[2] = (const double(*)[2])series->rows;
	if (series->n == 0)
		return constant;
	int k = 0;
	while (k < series->n && rows[k][0] <= time)
		k++;
	if (k == 0 || k == series->n)
		return rows[k ? k - 1 : 0][1];
	double share = (time - rows[k - 1][0]) / (rows[k][0] - rows[k - 1][0]);
	return rows[k - 1][1] + share * (rows[k][1] - rows[k - 1][1]);
}

bool scene_wall_heats(const struct scene_wall *wall) { return !isnan(wall->temperature) || wall->temperature_table.n; }

bool scene_boundary_heats_nodes(const struct scene_boundary *boundary)
{
	return !isnan(boundary->temperature) || boundary->temperature_table.n;
}

bool scene_presses(const struct scene *scene)
{
	bool presses = scene->n_contacts > 0;
	for (int k = 0; k < scene->n_walls; k++)
		presses = presses || scene->walls[k].contact == SCENE_WALL_PENALTY;
	return presses;
}

bool scene_boundary_loads_points(const struct scene_boundary *boundary)
{
	return !isnan(boundary->traction[0]) || !isnan(boundary->traction[1]);
}

bool scene_boundary_heats_points(const struct scene_boundary *boundary)
{
	return !isnan(boundary->flux) || boundary->flux_table.n || boundary->convection.coefficient > 0.0;
}

/* ---- temperatures ---- */

static const double CELSIUS_ZERO = 273.15; /* K */

double scene_temperature_out(const struct scene *scene, double kelvin)
{
	return scene->units.celsius ? kelvin - CELSIUS_ZERO : kelvin;
}

double scene_temperature_in(const struct scene *scene, double value)
{
	return scene->units.celsius ? value + CELSIUS_ZERO : value;
}

const char *scene_temperature_unit(const struct scene *scene) { return scene->units.celsius ? "C" : "K"; }

double scene_grid_face(const struct scene *scene, int c)
{
	const struct scene_wall *wall = &scene->walls[scene->grid.follow];
	double face = NAN, fixed = scene->grid.fixed[c];
	for (int k = 0; k < wall->n_vertices; k++)
		if (isnan(face) || fabs(wall->vertices[k][c] - fixed) < fabs(face - fixed))
			face = wall->vertices[k][c];
	return face;
}
