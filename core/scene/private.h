/* Inside of the loader: from files to a tree of nodes, from the tree through the key table to the structs.
 *
 *   source.c  files -> one text: @include, literals, duplicate keys; every output line knows where it came from
 *   tree.c    text -> tree (through libconfig, which nothing else sees), tree -> text
 *   set.c     base/set variants and --set overrides on the tree
 *   keys.c    the table of everything a scene can say
 *   read.c    tree -> struct scene, driven by the table; unknown keys, types, ranges
 *   finish.c  defaults that depend on other values
 *   check.c   what no single key can tell: geometry, references, limits
 *
 * Problems are collected, not thrown; only lack of memory leaves at once (loader->no_memory). */
#ifndef TMDEMPM_SCENE_PRIVATE_H
#define TMDEMPM_SCENE_PRIVATE_H

#include <setjmp.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "scene/scene.h"

enum { PATH_LENGTH = 512 }; /* of a key such as laws.[0].packing.radius_min */

/* ---- the tree ---- */

enum node_type { NODE_GROUP, NODE_LIST, NODE_ARRAY, NODE_INTEGER, NODE_NUMBER, NODE_BOOL, NODE_STRING };

struct node {
	enum node_type type;
	char *name;        /* NULL in lists and arrays */
	long long integer; /* also of a bool */
	double number;     /* also of an integer */
	char *string;
	int n, capacity;
	struct node **children;
	struct scene_place place;
};

/* ---- the key table ---- */

struct loader;
struct scene_key;

enum key_type {
	KEY_BOOL,        /* bool */
	KEY_INT,         /* int */
	KEY_UNSIGNED,    /* unsigned */
	KEY_LONG,        /* long */
	KEY_FLOAT,       /* double; integers are welcome */
	KEY_TEMPERATURE, /* double, in the scene's unit outside, K inside */
	KEY_STRING,      /* char[count] */
	KEY_NAME,        /* char[SCENE_NAME], made of letters, digits, _ and - */
	KEY_CHOICE,      /* char[SCENE_NAME], one of `choices` */
	KEY_ENUM,        /* enum, the index in `choices` */
	KEY_FLAG,        /* bool, the index in `choices` */
	KEY_FLOATS,      /* double[count] */
	KEY_INTS,        /* int[count] */
	KEY_CUSTOM,      /* read() */
	KEY_GROUP,       /* struct at offset, `tables` */
	KEY_LIST         /* pointer at offset, int count at n_offset, elements of element_size, `tables` */
};

enum key_range {
	RANGE_ANY,
	RANGE_POSITIVE,
	RANGE_NOT_NEGATIVE,
	RANGE_WITHIN /* [min, max] */,
	RANGE_BETWEEN /* (min, max) */
};

/* The keys of a group; where the key `type` decides which, one entry for each type. */
struct scene_table {
	const char *type; /* NULL = always; value of the key `type` */
	const struct scene_key *keys;
};

struct scene_key {
	const char *name;
	enum key_type type;
	size_t offset;
	int count;
	size_t n_offset, element_size;
	const char *unit;   /* NULL = none */
	const char *value;  /* default, as it would stand in a file */
	const char *absent; /* or what happens when it is left out, in words */
	bool required;      /* or an error when it is left out */
	enum key_range range;
	double min, max;
	const char *const *choices; /* NULL-terminated */
	const char *expected;       /* KEY_CUSTOM: what a value looks like, for messages */
	bool text;                  /* KEY_CUSTOM: a bare word on the command line is a string */
	void (*read)(struct loader *loader, const struct scene_key *key, struct node *node, void *target, const char *path);
	const struct scene_table *tables; /* ends with keys = NULL */
	const char *doc;
};

extern const struct scene_table scene_root_tables[];

/* The keys of a group: `node` decides where there are several kinds; NULL if it does not. */
const struct scene_key *tables_choose(const struct scene_table *tables, const struct node *node);
const struct scene_key *keys_find(const struct scene_key *keys, const char *name);

/* Calls visit() for every key of the scenes' table, depth first, with its path ("walls.[].friction"). */
void scene_keys_visit(void (*visit)(void *data, const char *path, const struct scene_key *key), void *data);

/* What scenarios/reference.cfg says behind a key: unit, meaning, choices, default. */
void scene_key_comment(const struct scene_key *key, char *text, size_t size);

/* The known path that looks most like `path` (indices are ignored); written to nearest[PATH_LENGTH]. */
void keys_nearest(const struct scene_key *keys, const char *path, char *nearest);

/* Edits that turn one word into the other; swapping neighbours counts one. */
int edit_distance(const char *a, const char *b);

/* ---- the loader ---- */

struct problem {
	struct scene_place place;
	char *path;    /* key concerned; "" = the file */
	char *message; /* NULL: only taints its path */
	int order;
};

struct block; /* of the arena */

struct loader {
	jmp_buf no_memory;
	const struct file_kind *kind;
	void *target;          /* what the table fills; for scenes, `scene` itself */
	struct block *scratch; /* arena of the tree, the sources, the problems; freed after loading */
	struct scene *scene;   /* also the owner of the memory that outlives loading */
	struct node *root;
	int n_problems, capacity_problems;
	struct problem *problems;
	int n_files, capacity_files;
	const char **files;    /* in the order of reading, for sorting */
	int n_lists_laws;      /* laws of the list; those of materials follow */
	int *n_points;         /* of each body, -1 = unknown */
	double (**points)[2];  /* malloc'ed by scene_body_points */
	void *config, *stream; /* live libconfig or stdio objects, so that a jump leaks nothing */
	char *buffer;
	bool unreadable; /* a file was there but could not be read */
};

/* ---- files with a key table of their own (scenes, studies) ---- */

struct file_kind {
	const char *name; /* "scene", for messages */
	const struct scene_table *tables;
	/* After the keys are read: dependent defaults, and what no single key can tell. */
	void (*finish)(struct loader *loader, void *target);
};

/* Reads a file through the table of `kind` into *target (zeroed); the strings and lists in it live in *storage,
 * which scene_free() frees.  Messages go to `errors` (a FILE *).  STATUS_INPUT, or STATUS_RESOURCE. */
int file_kind_load(const struct file_kind *kind, struct scene **storage, void *target, const char *path, int n_sets,
				   const char *const *sets, void *errors);

void *loader_alloc(struct loader *loader, size_t bytes); /* zeroed; never NULL; until loading ends */
void *scene_alloc(struct loader *loader, size_t bytes);  /* the same, as long as the scene lives */
char *loader_string(struct loader *loader, const char *text);
char *scene_string(struct loader *loader, const char *text);
void arena_free(struct block *arena);

/* Grows a scratch array to hold one more. */
void *loader_grow(struct loader *loader, void *array, int n, int *capacity, size_t element);

/* Prints the path of a key, cut if absurdly long; returns it. */
char *path_print(char path[PATH_LENGTH], const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Records a problem: "what is wrong, expected what". */
void problem_at(struct loader *loader, struct scene_place place, const char *path, const char *format, ...)
	__attribute__((format(printf, 4, 5)));

/* The same about a key, found in the tree as deep as it is there. */
void problem_of(struct loader *loader, const char *path, const char *format, ...) __attribute__((format(printf, 3, 4)));

/* Makes a path count as wrong without a message of its own: one was given elsewhere. */
void loader_taint(struct loader *loader, const char *path);

/* Has nothing been found wrong at or below this path? */
bool loader_clean(const struct loader *loader, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* ---- source.c ---- */

struct source {
	char *text;            /* in the arena, valid input for libconfig apart from syntax */
	int n_lines, capacity; /* line k + 1 of the text came from places[k] */
	struct scene_place *places;
};

/* Reads a file with everything it includes; false when there is nothing to parse (problems were recorded at
 * `from`, or at the fault). */
bool source_read(struct loader *loader, const char *path, struct scene_place from, struct source *source);

/* The same from a piece of text that stands at `place`. */
bool source_text(struct loader *loader, const char *text, struct scene_place place, struct source *source);

/* `name` as seen from the folder of `file`. */
char *path_beside(struct loader *loader, const char *file, const char *name);

/* A duplicate key is reported by source.c and carries this mark behind its name for tree.c to drop it. */
#define DUPLICATE_MARK "*again"

/* ---- tree.c ---- */

/* NULL on a syntax error (recorded). */
struct node *tree_parse(struct loader *loader, const struct source *source, const char *path);
struct node *node_find(const struct node *group, const char *name);
struct node *node_new(struct loader *loader, enum node_type type, struct scene_place place);
void node_append(struct loader *loader, struct node *parent, struct node *child);
const char *node_kind(const struct node *node); /* "a number", "a list" ... */
void tree_write(const struct node *root, FILE *out);

/* Deepest node along a path. */
struct node *tree_walk(struct node *root, const char *path);

/* ---- set.c ---- */

/* The tree of a file, its bases loaded and their overrides applied; NULL if there is none. */
struct node *tree_load(struct loader *loader, const char *path, struct scene_place from);

/* Applies one `path=value`. */
void tree_set(struct loader *loader, struct node *root, const char *assignment, struct scene_place place);

/* ---- read.c ---- */

void read_places(struct loader *loader);
void read_group(struct loader *loader, const struct scene_key *keys, struct node *group, void *target,
				const char *path);
bool read_numbers(struct loader *loader, const struct scene_key *key, struct node *node, int n, double *values,
				  const char *path);
int read_points(struct loader *loader, const struct scene_key *key, struct node *node, double (**points)[2],
				const char *path);
int read_reference(struct loader *loader, struct node *node, const char *list, const char *path);
void describe_expected(const struct scene_key *key, char *text, size_t size);
double temperature_in(const struct loader *loader, double value);

/* ---- finish.c, check.c ---- */

void finish_scene(struct loader *loader);
void check_scene(struct loader *loader);

#endif
