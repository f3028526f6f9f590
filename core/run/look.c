#include "run/look.h"

#include <dirent.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/error.h"
#include "io/h5.h"
#include "run/inspected.h"
#include "run/run_private.h"

/* What a look keeps of the run. */
struct look_parts {
	struct scene *scene;
	struct mpm *mpm;
	struct run_fields *fields;
	struct inspected *inspected; /* by the scene; of a checkpoint also by those who steered */
	struct rve_model *model;     /* of an RVE file or a packing */
	bool *has_rve;               /* by the points' ids */
	unsigned char *state;        /* of its own, of a snapshot, an RVE file or a packing */
};

/* The points of a state of a run, in the order of the file or of storage. */
struct look_points {
	hid_t snapshot; /* -1: the values are the simulation's */
	int n, *id;
	double (*x)[2];
};

/* ---- the scene that the state belongs to ---- */

/* The loader reads files. */
static int look_load_scene(struct look *look, const char *text)
{
	char path[FILE_PATH];
	CHECK(file_scratch(path, "scene"));
	FILE *out = fopen(path, "w");
	bool written = out && fputs(text, out) >= 0;
	written = out && !fclose(out) && written;
	int status = written ? scene_load(&look->parts->scene, path, 0, NULL, stderr)
						 : error_set(STATUS_RESOURCE, "cannot write the temporary file %s", path);
	unlink(path);
	if (status == STATUS_INPUT)
		return error_set(status, "this release cannot read the scene that is stored in %s", look->source);
	CHECK(status);
	snprintf(look->title, sizeof look->title, "%s", look->parts->scene->title);
	return STATUS_OK;
}

/* Points and laws as they were born; the text is freed. */
static int look_make_mpm(struct look *look, char *text)
{
	struct look_parts *parts = look->parts;
	int status = look_load_scene(look, text);
	free(text);
	CHECK(status);
	CHECK(mpm_create(&parts->mpm, parts->scene));
	const struct particles *p = &parts->mpm->p;
	parts->has_rve = calloc((size_t)p->n + 1, sizeof *parts->has_rve);
	if (!parts->has_rve)
		return error_set(STATUS_RESOURCE, "out of memory");
	for (int k = 0; k < p->n; k++)
		parts->has_rve[p->id[k]] = parts->mpm->laws[p->law[k]]->type->rve_view != NULL;
	CHECK(fields_create(&parts->fields, parts->mpm));
	return inspected_create(&parts->inspected, parts->mpm, parts->fields);
}

/* ---- values of the points ---- */

/* A field of all points, n * components values. */
static int look_field(const struct look *look, const struct look_points *points, const char *name, int components,
					  double *values)
{
	if (points->snapshot >= 0) {
		char dataset[96];
		snprintf(dataset, sizeof dataset, "points/%s", name);
		return h5_read(points->snapshot, dataset, H5T_NATIVE_DOUBLE, (hsize_t)points->n * (hsize_t)components, values,
					   look->source);
	}
	int f = fields_find(look->parts->fields, name);
	if (f < 0)
		return error_set(STATUS_INPUT, "%s: there is no field `%s`", look->source, name);
	fields_get(look->parts->fields, look->parts->mpm, f, values);
	return STATUS_OK;
}

/* Of one point. */
static int look_value(const struct look *look, const struct look_points *points, int point, const char *name,
					  int components, double *value)
{
	double *all = malloc(sizeof *all * ((size_t)points->n * (size_t)components + 1));
	if (!all)
		return error_set(STATUS_RESOURCE, "out of memory");
	int status = look_field(look, points, name, components, all);
	if (status == STATUS_OK)
		memcpy(value, all + (size_t)point * (size_t)components, sizeof *value * (size_t)components);
	free(all);
	return status;
}

/* The law of the point with this id. */
static struct law *look_law(const struct look *look, int id)
{
	const struct mpm *mpm = look->parts->mpm;
	return mpm->laws[mpm->p.law[mpm_point_by_id(mpm, id)]];
}

/* Is there an RVE behind point k? */
static bool look_has_rve(const struct look *look, const struct look_points *points, int k)
{
	int id = points->id[k];
	return id >= 0 && id < look->parts->mpm->p.n && look->parts->has_rve[id];
}

/* ---- choosing ---- */

static int look_find_id(const struct look_points *points, long long id)
{
	for (int k = 0; k < points->n; k++)
		if (points->id[k] == id)
			return k;
	return -1;
}

/* One of the states that a snapshot carries. */
struct look_stored {
	char name[SCENE_NAME];
	long long id;
	bool anonymous; /* "point_412", of no inspection */
};

/* Number k of them; false after the last. */
static bool look_stored(hid_t snapshot, int k, struct look_stored *stored)
{
	hid_t group = h5_has(snapshot, "rve") ? H5Gopen2(snapshot, "rve", H5P_DEFAULT) : -1;
	H5G_info_t info = {.nlinks = 0};
	bool there = group >= 0 && H5Gget_info(group, &info) >= 0 && (hsize_t)k < info.nlinks &&
				 H5Lget_name_by_idx(group, ".", H5_INDEX_NAME, H5_ITER_INC, (hsize_t)k, stored->name,
									sizeof stored->name, H5P_DEFAULT) > 0;
	hid_t set = there ? H5Dopen2(group, stored->name, H5P_DEFAULT) : -1;
	there = there && set >= 0 && h5_read_integer(set, "id", &stored->id, "snapshot") == STATUS_OK;
	stored->anonymous = there && !strncmp(stored->name, "point_", 6) &&
						strspn(stored->name + 6, "0123456789") == strlen(stored->name + 6);
	if (set >= 0)
		H5Dclose(set);
	if (group >= 0)
		H5Gclose(group);
	return there;
}

static void look_append(char *list, size_t size, const char *name)
{
	size_t used = strlen(list);
	snprintf(list + used, size - used, "%s%s", used ? ", " : "", name);
}

/* An inspected RVE: a snapshot says which point it followed, a checkpoint belongs to the scene that does. */
static int look_by_name(const struct look *look, const struct look_points *points, const char *name, int *point)
{
	const struct inspected *inspected = look->parts->inspected;
	char all[512] = "";
	struct look_stored stored;
	for (int k = 0; points->snapshot >= 0 && look_stored(points->snapshot, k, &stored); k++) {
		if (!stored.anonymous)
			look_append(all, sizeof all, stored.name);
		if (!strcmp(stored.name, name))
			*point = look_find_id(points, stored.id);
	}
	for (int i = 0; points->snapshot < 0 && i < inspected->n; i++) {
		look_append(all, sizeof all, inspected->rves[i].name);
		if (!strcmp(inspected->rves[i].name, name))
			CHECK(inspected_point(inspected, &inspected->rves[i], point));
	}
	if (*point >= 0)
		return STATUS_OK;
	return error_set(STATUS_INPUT, "--name %s: expected the name of an RVE that is inspected in %s (%s)", name,
					 look->source, *all ? all : "there is none");
}

/* The nearest of those with an RVE. */
static int look_nearest(const struct look *look, const struct look_points *points, const double at[2])
{
	int best = -1;
	double least = INFINITY;
	for (int k = 0; k < points->n; k++) {
		double distance = hypot(points->x[k][0] - at[0], points->x[k][1] - at[1]);
		if (look_has_rve(look, points, k) &&
			(distance < least || (distance == least && points->id[k] < points->id[best])))
			best = k, least = distance;
	}
	return best;
}

static int look_by_rule(const struct look *look, const struct look_points *points, const struct rve_rule *rule,
						int *point)
{
	double *value = malloc(sizeof *value * ((size_t)points->n + 1));
	if (!value)
		return error_set(STATUS_RESOURCE, "out of memory");
	int status = look_field(look, points, rule->field, 1, value);
	for (int k = 0; status == STATUS_OK && k < points->n; k++)
		if (!look_has_rve(look, points, k))
			value[k] = NAN;
	if (status == STATUS_OK)
		*point = rve_rule_choose(rule, points->n, points->id, value);
	free(value);
	if (status == STATUS_OK && *point < 0)
		return error_set(STATUS_INPUT, "--rule %s: %s in %s", rule->name, rule->nothing, look->source);
	return status;
}

static int look_choose(const struct look *look, const struct look_points *points, const struct look_choice *choice,
					   int *point)
{
	*point = -1;
	if (!choice || (!choice->name && !choice->rule && choice->point < 0 && isnan(choice->at[0])))
		return error_set(STATUS_INPUT, "%s holds many RVEs, expected --point ID, --at x,y, --rule RULE or --name NAME",
						 look->source);
	if (choice->name)
		CHECK(look_by_name(look, points, choice->name, point));
	else if (choice->rule)
		CHECK(look_by_rule(look, points, choice->rule, point));
	else if (choice->point >= 0)
		*point = look_find_id(points, choice->point);
	else
		*point = look_nearest(look, points, choice->at);
	if (*point < 0 && choice->point >= 0)
		return error_set(STATUS_INPUT, "--point %lld: %s has the points 0 to %d", choice->point, look->source,
						 points->n - 1);
	if (*point < 0 || !look_has_rve(look, points, *point))
		return error_set(STATUS_INPUT, "%s: there is no RVE behind %s", look->source,
						 *point < 0 ? "any point" : "this point, its law has none");
	return STATUS_OK;
}

/* ---- the state ---- */

/* What is the same for all sources: the point's own values. */
static int look_take_point(struct look *look, const struct look_points *points, int point)
{
	const struct scene *scene = look->parts->scene;
	struct frame_rve_view *view = &look->view;
	double stress[6], smooth;
	int id = points->id[point], stored = mpm_point_by_id(look->parts->mpm, id);
	view->point = id;
	view->celsius = scene->units.celsius;
	view->thermal = look->parts->mpm->thermal;
	CHECK(look_value(look, points, point, "stress", 6, stress));
	CHECK(look_value(look, points, point, "temperature", 1, &view->temperature));
	CHECK(look_value(look, points, point, "temperature_smooth", 1, &smooth));
	memcpy(view->stress, stress, sizeof view->stress);
	if (points->snapshot >= 0)
		CHECK(look_value(look, points, point, "deformation_gradient", 4, view->F));
	else
		memcpy(view->F, look->parts->mpm->p.F[stored], sizeof view->F);
	memcpy(look->x, points->x[point], sizeof look->x);
	look->origin.point = id;
	look->origin.T = points->snapshot >= 0 ? scene_temperature_in(scene, smooth) : look->parts->mpm->p.T_smooth[stored];
	snprintf(look->origin.law, sizeof look->origin.law, "%.63s", look_law(look, id)->name);
	return STATUS_OK;
}

/* The name under which the point is inspected, or "". */
static void look_take_name(struct look *look, const struct look_points *points, const char *asked)
{
	const struct inspected *inspected = look->parts->inspected;
	struct look_stored stored;
	char *name = look->origin.name;
	snprintf(name, sizeof look->origin.name, "%.63s", asked ? asked : "");
	for (int k = 0; !*name && points->snapshot >= 0 && look_stored(points->snapshot, k, &stored); k++)
		if (stored.id == look->origin.point && !stored.anonymous)
			snprintf(name, sizeof look->origin.name, "%.63s", stored.name);
	for (int i = 0; !*name && points->snapshot < 0 && i < inspected->n; i++)
		if (!inspected->rves[i].rule && inspected->rves[i].id == look->origin.point)
			snprintf(name, sizeof look->origin.name, "%.63s", inspected->rves[i].name);
}

/* Is `file` the path of an RVE that steering began to inspect (NAME_STEP_path.csv), of this point, after *step and not
 * after this state? */
static bool look_is_later(const struct look *look, const char *folder, const char *file, long long *step)
{
	const size_t name = strlen(look->origin.name);
	char start[FILE_PATH], state[128], rest[16] = "";
	long long found = -1;
	struct rve_file *rve;
	if (strncmp(file, look->origin.name, name) || sscanf(file + name, "_%8lld%15s", &found, rest) != 2 ||
		strcmp(rest, "_path.csv") || found <= *step || found > look->origin.step)
		return false;
	snprintf(state, sizeof state, "%.63s_%08lld.h5", look->origin.name, found);
	if (file_join(start, folder, state) != STATUS_OK || rve_file_read(&rve, start) != STATUS_OK)
		return false;
	bool same = rve->origin.point == look->origin.point;
	rve_file_free(rve);
	*step = same ? found : *step;
	return same;
}

/* The recorded path that leads on from this state: it begins with the run, or where steering began to inspect. */
static int look_take_path(struct look *look)
{
	char folder[FILE_PATH], name[128];
	long long began = -1;
	look->skip = look->origin.step + !isnan(mpm_start_warming(look->parts->mpm, (int)look->origin.point));
	if (!*look->origin.name)
		return STATUS_OK;
	CHECK(file_join(folder, look->folder, "rve"));
	snprintf(name, sizeof name, "%s_path.csv", look->origin.name);
	DIR *stream = opendir(folder);
	for (struct dirent *entry; stream && (entry = readdir(stream));)
		if (look_is_later(look, folder, entry->d_name, &began))
			snprintf(name, sizeof name, "%.120s", entry->d_name);
	if (stream)
		closedir(stream);
	if (began >= 0)
		look->skip = look->origin.step - began;
	CHECK(file_join(look->path, folder, name));
	if (!file_exists(look->path))
		look->path[0] = '\0';
	return STATUS_OK;
}

/* ---- a checkpoint ---- */

/* The log of those who steered says what was inspected at this state. */
static int look_take_steered(struct look *look)
{
	struct inspected *inspected = look->parts->inspected;
	struct steering_script script;
	char path[FILE_PATH];
	CHECK(file_join(path, look->folder, "steering.csv"));
	if (!file_exists(path))
		return STATUS_OK;
	CHECK(steering_script_read(&script, path));
	int status = STATUS_OK;
	for (int k = 0; k < script.n && script.rows[k].step <= look->origin.step && status == STATUS_OK; k++) {
		struct steering_command *command = &script.rows[k].command;
		struct inspected_rve rve;
		if (command->verb != STEER_INSPECT)
			continue;
		if (command->target == STEER_NOTHING)
			inspected_remove(inspected, command->name);
		else if (inspected_choose(inspected, command, &rve) == STATUS_OK)
			status = inspected_set(inspected, &rve);
	}
	steering_script_free(&script);
	return status;
}

static int look_checkpoint(struct look *look, const struct look_choice *choice)
{
	char *text;
	CHECK(checkpoint_read_scene(look->source, &text));
	CHECK(look_make_mpm(look, text));
	struct mpm *mpm = look->parts->mpm;
	int status = checkpoint_look(look->source, mpm);
	if (status != STATUS_OK)
		return error_context(status, "this release cannot read that state");
	struct look_points points = {.snapshot = -1, .n = mpm->p.n, .id = mpm->p.id, .x = mpm->p.x};
	int point;
	look->origin.step = mpm->step;
	look->origin.time = mpm->time;
	CHECK(look_take_steered(look));
	CHECK(look_choose(look, &points, choice, &point));
	CHECK(look_take_point(look, &points, point));
	look_take_name(look, &points, choice->name);
	const struct law *law = mpm->laws[mpm->p.law[point]];
	return law->type->rve_view(law, mpm->p.slot[point], &look->view.model, &look->view.state);
}

/* ---- a snapshot ---- */

/* 'quoted' for a shell, appended. */
static void look_quote(char *command, size_t size, const char *word)
{
	size_t n = strlen(command);
	bool plain =
		*word && strspn(word, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./=,:+-") == strlen(word);
	if (plain) {
		snprintf(command + n, size - n, " %s", word);
		return;
	}
	n += (size_t)snprintf(command + n, size - n, " '");
	for (; *word && n + 8 < size; word++)
		n += (size_t)snprintf(command + n, size - n, *word == '\'' ? "'\\''" : "%c", *word);
	snprintf(command + n, size - n, "'");
}

/* A string of JSON at `at` (its opening quote); returns what follows it. */
static const char *look_unquote(const char *at, char *text, size_t size)
{
	size_t n = 0;
	for (at++; *at && *at != '"'; at++) {
		at += at[0] == '\\' && at[1];
		if (n + 1 < size)
			text[n++] = *at;
	}
	text[n] = '\0';
	return *at ? at + 1 : at;
}

/* The scene and its changes as run.json names them, appended to a command. */
static void look_quote_scene(const struct look *look, char *command, size_t size)
{
	char path[FILE_PATH], word[FILE_PATH], *json = NULL;
	size_t bytes;
	if (file_join(path, look->folder, "run.json") != STATUS_OK || file_read(&json, &bytes, path) != STATUS_OK)
		json = NULL;
	const char *options = json ? strstr(json, "\"options\"") : NULL;
	const char *scene = options ? strstr(options, "\"scene\": \"") : NULL;
	if (scene)
		look_unquote(scene + strlen("\"scene\": "), word, sizeof word);
	look_quote(command, size, scene ? word : "SCENE.cfg");
	const char *at = scene ? strstr(scene, "\"set\": [") : NULL;
	for (at = at ? at + strlen("\"set\": [") : NULL; at && (at += strcspn(at, "\"]")) && *at == '"';) {
		at = look_unquote(at, word, sizeof word);
		look_quote(command, size, "--set");
		look_quote(command, size, word);
	}
	free(json);
}

static int look_attribute(const char *path, const char *name, double *value)
{
	hid_t file;
	CHECK(h5_open(&file, path));
	int status = h5_read_number(file, name, value, path);
	H5Fclose(file);
	return status;
}

/* The snapshot does not carry this RVE: what it has, and how to get the one that was asked for. */
static int look_missing(const struct look *look, hid_t snapshot, int id)
{
	char command[8192], there[1024] = "", checkpoint[FILE_PATH], number[64], out[FILE_PATH];
	double time;
	struct look_stored stored;
	for (int k = 0; look_stored(snapshot, k, &stored); k++)
		look_append(there, sizeof there, stored.name);
	snprintf(command, sizeof command, "tmdempm run");
	look_quote_scene(look, command, sizeof command);
	snprintf(number, sizeof number, "%.12g", look->origin.time);
	snprintf(out, sizeof out, "%.4000s.t%s", look->folder, number);
	if (file_join(checkpoint, look->folder, "checkpoint.h5") == STATUS_OK && file_exists(checkpoint) &&
		look_attribute(checkpoint, "time", &time) == STATUS_OK && time <= look->origin.time) {
		look_quote(command, sizeof command, "--restart");
		look_quote(command, sizeof command, checkpoint);
	}
	for (const char *const *word = (const char *const[]){"--until", number, "--out", out, NULL}; *word; word++)
		look_quote(command, sizeof command, *word);
	return error_set(STATUS_INPUT,
					 "%s carries the states of the inspected RVEs only (%s), not that of point %d.  This makes it:\n"
					 "  %s\n"
					 "and then `tmdempm rve show %s --point %d`.  With output.rve_states = \"all\" every snapshot "
					 "carries all",
					 look->source, *there ? there : "there are none", id, command, out, id);
}

/* The law's model becomes that of the path that the state was computed on. */
static int look_follow_path(const struct look *look, hid_t set, struct law *law)
{
	char *path;
	CHECK(h5_read_attribute_text(set, "path", &path, look->source));
	int status = strcmp(path, law->path) != 0 ? law->type->change_path(law, path) : STATUS_OK;
	free(path);
	return status;
}

static int look_read_state(struct look *look, hid_t set, struct law *law)
{
	long long packings;
	hsize_t bytes;
	hid_t space = H5Dget_space(set);
	bytes = (hsize_t)H5Sget_simple_extent_npoints(space);
	H5Sclose(space);
	if (H5Aexists(set, "packings") <= 0)
		return error_set(STATUS_INPUT,
						 "%s does not say with which packings it was computed: an earlier release wrote it",
						 look->source);
	CHECK(h5_read_integer(set, "packings", &packings, look->source));
	CHECK(look_follow_path(look, set, law));
	if (bytes != law->state_bytes || packings != (long long)law->model_hash)
		return error_set(STATUS_INPUT,
						 "%s was computed with other packings in law %s, or by another release: its states cannot be "
						 "read here",
						 look->source, law->name);
	look->parts->state = aligned_alloc(64, (bytes + 63) / 64 * 64);
	if (!look->parts->state)
		return error_set(STATUS_RESOURCE, "out of memory");
	if (H5Dread(set, H5T_NATIVE_UCHAR, H5S_ALL, H5S_ALL, H5P_DEFAULT, look->parts->state) < 0)
		return error_set(STATUS_RESOURCE, "cannot read %s", look->source);
	look->view.state = look->parts->state;
	look->view.model = law->model;
	return STATUS_OK;
}

/* Among the states that a snapshot carries, the one of this point, under whatever name. */
static int look_find_state(struct look *look, hid_t snapshot, int id)
{
	struct look_stored stored;
	for (int k = 0; look_stored(snapshot, k, &stored); k++) {
		char dataset[SCENE_NAME + 8];
		if (stored.id != id)
			continue;
		snprintf(dataset, sizeof dataset, "rve/%s", stored.name);
		hid_t set = H5Dopen2(snapshot, dataset, H5P_DEFAULT);
		int status = look_read_state(look, set, look_law(look, id));
		H5Dclose(set);
		return status;
	}
	return look_missing(look, snapshot, id);
}

static int look_snapshot_points(struct look *look, struct look_points *points, const struct look_choice *choice)
{
	hsize_t n, columns;
	int point;
	CHECK(h5_size(points->snapshot, "points/id", &n, &columns, look->source));
	if ((int)n != look->parts->mpm->p.n)
		return error_set(STATUS_INPUT, "%s holds %d points, the scene beside it has %d", look->source, (int)n,
						 look->parts->mpm->p.n);
	points->n = (int)n;
	points->id = malloc(sizeof *points->id * (n + 1));
	points->x = malloc(sizeof *points->x * (n + 1));
	if (!points->id || !points->x)
		return error_set(STATUS_RESOURCE, "out of memory");
	CHECK(h5_read(points->snapshot, "points/id", H5T_NATIVE_INT, n, points->id, look->source));
	CHECK(h5_read(points->snapshot, "points/position", H5T_NATIVE_DOUBLE, 2 * n, points->x, look->source));
	CHECK(h5_read_number(points->snapshot, "time", &look->origin.time, look->source));
	CHECK(h5_read_integer(points->snapshot, "step", &look->origin.step, look->source));
	CHECK(look_choose(look, points, choice, &point));
	CHECK(look_take_point(look, points, point));
	look_take_name(look, points, choice->name);
	return look_find_state(look, points->snapshot, points->id[point]);
}

static int look_snapshot(struct look *look, const struct look_choice *choice)
{
	char run[FILE_PATH], *text;
	hid_t file;
	CHECK(file_join(run, look->folder, "run.h5"));
	if (!file_exists(run))
		return error_set(STATUS_INPUT, "%s: the run.h5 with its scene is missing, expected it at %s", look->source,
						 run);
	CHECK(h5_open(&file, run));
	int status = h5_read_text(file, "scene", &text, run);
	H5Fclose(file);
	CHECK(status);
	CHECK(look_make_mpm(look, text));
	struct look_points points = {0};
	CHECK(h5_open(&points.snapshot, look->source));
	status = look_snapshot_points(look, &points, choice);
	free(points.id), free(points.x);
	H5Fclose(points.snapshot);
	return status;
}

/* ---- an RVE file or a packing ---- */

/* It belongs to no point here: stress and deformation are its own. */
static void look_take_rve(struct look *look)
{
	struct rve_info info;
	double conductivity[3], modulus;
	rve_get_info(look->view.model, look->view.state, &info);
	rve_evaluate(look->view.model, look->view.state, look->view.stress, conductivity, &modulus);
	memcpy(look->view.F, info.F, sizeof look->view.F);
	look->view.point = look->origin.point;
	look->view.temperature = look->origin.T;
	look->view.thermal = !isnan(look->origin.T);
}

static int look_rve_file(struct look *look)
{
	struct rve_file *file;
	CHECK(rve_file_read(&file, look->source));
	int status = rve_file_model(&look->parts->model, file, &file->params);
	look->origin = file->origin;
	look->parts->state = file->state;
	file->state = NULL;
	rve_file_free(file);
	CHECK(status);
	look->view.model = look->parts->model;
	look->view.state = look->parts->state;
	look_take_rve(look);
	return STATUS_OK;
}

static int look_packing(struct look *look)
{
	struct rve_packing *packing;
	struct rve_params params;
	rve_params_default(&params);
	CHECK(rve_packing_read(&packing, look->source));
	int status = rve_model_create(&look->parts->model, &params, 1, (const struct rve_packing *const *)&packing);
	rve_packing_free(packing);
	CHECK(status);
	look->parts->state = aligned_alloc(64, (rve_state_bytes(look->parts->model) + 63) / 64 * 64);
	if (!look->parts->state)
		return error_set(STATUS_RESOURCE, "out of memory");
	CHECK(rve_init(look->parts->model, 0, look->parts->state));
	look->view.model = look->parts->model;
	look->view.state = look->parts->state;
	look_take_rve(look);
	return STATUS_OK;
}

/* ---- which file ---- */

/* Takes the file if its time is nearer to the one that is asked for; NAN asks for the last. */
static void look_nearer(struct look *look, const char *path, double time, double *least)
{
	double of_file;
	if (look_attribute(path, "time", &of_file) != STATUS_OK)
		return;
	double far = isnan(time) ? -of_file : fabs(of_file - time);
	if (!(far < *least))
		return;
	*least = far;
	snprintf(look->source, sizeof look->source, "%s", path);
}

/* Of a run's folder: the checkpoint, which holds every RVE, or the snapshot nearest in time. */
static int look_find_source(struct look *look, double time)
{
	char path[FILE_PATH], snapshots[FILE_PATH];
	double least = INFINITY;
	look->source[0] = '\0';
	CHECK(file_join(path, look->folder, "checkpoint.h5"));
	if (file_exists(path))
		look_nearer(look, path, time, &least);
	CHECK(file_join(snapshots, look->folder, "snap"));
	DIR *stream = isnan(time) && look->source[0] ? NULL : opendir(snapshots);
	for (struct dirent *entry; stream && (entry = readdir(stream));)
		if (entry->d_name[0] != '.' && file_has_end(entry->d_name, ".h5") &&
			file_join(path, snapshots, entry->d_name) == STATUS_OK)
			look_nearer(look, path, time, &least);
	if (stream)
		closedir(stream);
	return look->source[0]
			   ? STATUS_OK
			   : error_set(STATUS_INPUT, "%s holds no checkpoint.h5 and no snap/*.h5: expected a run's folder",
						   look->folder);
}

static int look_run(struct look *look, const struct look_choice *choice)
{
	hid_t file;
	char *format = NULL;
	CHECK(h5_open(&file, look->source));
	bool snapshot = h5_has(file, "points") && h5_has(file, "grid");
	bool other = !snapshot && h5_read_attribute_text(file, "format", &format, look->source) != STATUS_OK;
	free(format);
	H5Fclose(file);
	if (other)
		return error_set(STATUS_INPUT,
						 "%s is neither a run.h5, a checkpoint, a snapshot, an RVE file nor a packing of tmdempm",
						 look->source);
	return snapshot ? look_snapshot(look, choice) : look_checkpoint(look, choice);
}

/* The run's folder of a file in it. */
static int look_find_folder(struct look *look)
{
	char folder[FILE_PATH];
	CHECK(file_folder(folder, look->source));
	const char *last = strrchr(folder, '/');
	last = last ? last + 1 : folder;
	if (strcmp(last, "snap"))
		return file_join(look->folder, "", folder);
	return last == folder ? file_join(look->folder, "", ".") : file_folder(look->folder, folder);
}

static int look_any(struct look *look, const char *source, double time, const struct look_choice *choice)
{
	CHECK(file_join(look->source, "", source));
	bool csv = file_has_end(source, ".csv"), folder = file_is_folder(source);
	bool run = folder || !strcmp(strrchr(source, '/') ? strrchr(source, '/') + 1 : source, "run.h5");
	if (!file_exists(source))
		return error_set(STATUS_INPUT, "%s does not exist, expected a run's folder, a file of it, or an RVE file",
						 source);
	if (!run && !isnan(time))
		return error_set(STATUS_INPUT, "--time is given with %s, which holds one time; expected a run's folder",
						 source);
	if (run) {
		CHECK(folder ? file_join(look->folder, "", source) : look_find_folder(look));
		CHECK(look_find_source(look, time));
	} else if (csv || rve_file_is(source)) {
		return csv ? look_packing(look) : look_rve_file(look);
	} else if (rve_packing_is(source)) {
		return look_packing(look);
	} else {
		CHECK(look_find_folder(look));
	}
	CHECK(look_run(look, choice));
	return look_take_path(look);
}

static void look_take_title(struct look *look)
{
	const char *file = strrchr(look->source, '/');
	file = file ? file + 1 : look->source;
	if (*look->origin.name)
		snprintf(look->name, sizeof look->name, "%.47s", look->origin.name);
	else if (look->origin.point >= 0)
		snprintf(look->name, sizeof look->name, "point_%lld", look->origin.point);
	else
		snprintf(look->name, sizeof look->name, "%.*s", (int)strcspn(file, "."), file);
	look->view.name = look->name;
}

int look_open(struct look *look, const char *source, double time, const struct look_choice *choice)
{
	*look = (struct look){.origin = {.point = -1, .T = NAN}, .x = {NAN, NAN}, .skip = -1};
	look->parts = calloc(1, sizeof *look->parts);
	if (!look->parts)
		return error_set(STATUS_RESOURCE, "out of memory");
	CHECK(look_any(look, source, time, choice));
	look->view.time = look->origin.time;
	look_take_title(look);
	return STATUS_OK;
}

void look_close(struct look *look)
{
	struct look_parts *parts = look->parts;
	if (!parts)
		return;
	inspected_free(parts->inspected);
	fields_free(parts->fields);
	mpm_free(parts->mpm);
	scene_free(parts->scene);
	rve_model_free(parts->model);
	free(parts->has_rve);
	free(parts->state);
	free(parts);
	look->parts = NULL;
}
