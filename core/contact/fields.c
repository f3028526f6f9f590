/* Which fields meet at which node. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "contact/private.h"

/* ---- life ---- */

int contact_slots(const struct mpm *mpm)
{
	const struct scene *scene = mpm->scene;
	if (scene->n_contacts == 0)
		return 0;
	return scene->mpm.contact_fields > 0 ? scene->mpm.contact_fields : mpm->grid.nx * mpm->grid.ny;
}

int contact_slots_used(const struct mpm *mpm) { return mpm_work(mpm)->contact->n_slots; }

static bool names(const struct scene_contact *s, int body)
{
	bool named = s->n_bodies == 0;
	for (int k = 0; k < s->n_bodies; k++)
		named = named || s->bodies[k] == body;
	return named;
}

/* Bodies that a contact names get a label of their own; if one names none, all do.  The others share the last. */
static void find_labels(const struct scene *scene, struct contact *c)
{
	int n = 0;
	bool shared = false;
	for (int b = 0; b < scene->n_bodies; b++) {
		bool named = false;
		for (int k = 0; k < scene->n_contacts; k++)
			named = named || names(&scene->contacts[k], b);
		c->label[b] = named ? n++ : -1;
		shared = shared || !named;
	}
	for (int b = 0; b < scene->n_bodies; b++)
		c->label[b] = c->label[b] < 0 ? n : c->label[b];
	c->n_labels = n + shared;
}

/* Between two bodies, or (a = b) the faces of cracks in one. */
static bool joins(const struct scene_contact *s, int a, int b)
{
	if (a == b)
		return (s->n_bodies == 1 || s->cracks) && names(s, a);
	return s->n_bodies != 1 && names(s, a) && names(s, b);
}

/* A contact that names its bodies comes before one that names none, whatever their order in the scene. */
static void find_pairs(const struct scene *scene, struct contact *c)
{
	for (int k = 0; k < c->n_labels * c->n_labels; k++)
		c->pair[k] = -1;
	for (int k = 0; k < c->n_labels; k++)
		c->own[k] = -1;
	for (int pass = 0; pass < 2; pass++)
		for (int k = 0; k < scene->n_contacts; k++) {
			const struct scene_contact *s = &scene->contacts[k];
			if ((s->n_bodies == 0) != (pass == 0))
				continue;
			for (int a = 0; a < scene->n_bodies; a++)
				for (int b = 0; b < scene->n_bodies; b++) {
					int la = c->label[a], lb = c->label[b];
					if (joins(s, a, b) && (a == b || la != lb))
						*(a == b ? &c->own[la] : &c->pair[la * c->n_labels + lb]) = k;
				}
		}
	for (int k = 0; k < c->n_labels; k++)
		c->cracks = c->cracks || c->own[k] >= 0;
}

int contact_create(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	const struct scene *scene = mpm->scene;
	if (scene->n_contacts == 0)
		return STATUS_OK;
	size_t nodes = (size_t)mpm->grid.nx * (size_t)mpm->grid.ny, slots = (size_t)contact_slots(mpm);
	size_t cells = (size_t)w->cells_x * (size_t)w->cells_y, bodies = (size_t)scene->n_bodies;
	struct contact *c = w->contact = calloc(1, sizeof *c);
	if (!c)
		return error_set(STATUS_RESOURCE, "out of memory for contacts");
	c->slots_most = (int)slots;
	c->label = calloc(bodies, sizeof *c->label);
	c->pair = calloc(bodies * bodies, sizeof *c->pair);
	c->own = calloc(bodies, sizeof *c->own);
	c->places = calloc(slots, sizeof *c->places);
	c->fields = calloc(2 * slots, sizeof *c->fields);
	c->pairs = calloc(slots * CONTACT_FIELDS_MOST / 2, sizeof *c->pairs);
	c->first = malloc(nodes * sizeof *c->first);
	c->home = calloc(slots, sizeof *c->home);
	c->cell_label = calloc(cells, sizeof *c->cell_label);
	c->near = calloc(cells, sizeof *c->near);
	c->meets = calloc(nodes, sizeof *c->meets);
	c->direction = calloc(nodes, sizeof *c->direction);
	c->hot = calloc(cells, sizeof *c->hot);
	c->broken = calloc(cells, sizeof *c->broken);
	c->marked = calloc(cells, sizeof *c->marked);
	if (!c->label || !c->pair || !c->own || !c->hot || !c->broken || !c->marked || !c->direction || !c->places ||
		!c->fields || !c->pairs || !c->first || !c->home || !c->cell_label || !c->near || !c->meets)
		return error_set(STATUS_RESOURCE, "out of memory for %zu extra fields of %zu nodes", slots, nodes);
	for (size_t k = 0; k < nodes; k++)
		c->first[k] = -1;
	find_labels(scene, c);
	find_pairs(scene, c);
	c->cracks = c->cracks && mpm->p.damage;
	return STATUS_OK;
}

void contact_free(struct mpm *mpm)
{
	struct contact *c = mpm_work(mpm)->contact;
	if (!c)
		return;
	free(c->label);
	free(c->pair);
	free(c->places);
	free(c->fields);
	free(c->pairs);
	free(c->first);
	free(c->home);
	free(c->cell_label);
	free(c->near);
	free(c->meets);
	free(c->direction);
	free(c->own);
	free(c->hot);
	free(c->broken);
	free(c->marked);
	free(c);
}

size_t contact_memory(const struct mpm *mpm)
{
	const struct contact *c = mpm_work(mpm)->contact;
	if (!c)
		return 0;
	size_t nodes = (size_t)mpm->grid.nx * (size_t)mpm->grid.ny, slots = (size_t)c->slots_most;
	return slots * (sizeof *c->places + 2 * sizeof *c->fields + CONTACT_FIELDS_MOST / 2 * sizeof *c->pairs +
					sizeof *c->home) +
		   nodes * (sizeof *c->first + sizeof *c->cell_label + sizeof *c->near + sizeof *c->meets +
					sizeof *c->direction + sizeof *c->hot + sizeof *c->broken + sizeof *c->marked);
}

/* ---- where fields meet ---- */

static void forget_places(const struct mpm *mpm, struct contact *c)
{
	for (int k = 0; k < c->n_places; k++)
		c->first[c->places[k].node] = -1;
	c->n_places = c->n_fields = c->n_slots = c->n_pairs = 0;
	memset(c->near, 0, (size_t)mpm_work(mpm)->cells_x * (size_t)mpm_work(mpm)->cells_y * sizeof *c->near);
}

static void label_cells_of_row(const struct mpm *mpm, struct contact *c, int j)
{
	const struct mpm_work *w = mpm_work(mpm);
	for (int cell = j * w->cells_x; cell < (j + 1) * w->cells_x; cell++) {
		int label = CELL_EMPTY;
		bool broken = false;
		for (int k = w->cell_first[cell]; k < w->cell_first[cell + 1]; k++) {
			int of_point = c->label[mpm->p.body[w->order[k]]];
			label = label == CELL_EMPTY || label == of_point ? of_point : CELL_MIXED;
			broken = broken || (c->cracks && mpm->p.damage[w->order[k]] >= CONTACT_BROKEN && c->own[of_point] >= 0);
		}
		c->cell_label[cell] = label;
		c->broken[cell] = broken;
	}
}

void contact_cells_about(const struct mpm *mpm, int i, int j, int low[2], int high[2])
{
	const struct mpm_work *w = mpm_work(mpm);
	int reach = mpm->shape->reach;
	low[0] = i - 1 - reach < 0 ? 0 : i - 1 - reach;
	low[1] = j - 1 - reach < 0 ? 0 : j - 1 - reach;
	high[0] = i + reach > w->cells_x - 1 ? w->cells_x - 1 : i + reach;
	high[1] = j + reach > w->cells_y - 1 ? w->cells_y - 1 : j + reach;
}

/* Does a node need more than one field, and why? */
static enum contact_meeting meeting_at(const struct mpm *mpm, const struct contact *c, int i, int j)
{
	int low[2], high[2], found = CELL_EMPTY;
	contact_cells_about(mpm, i, j, low, high);
	for (int b = low[1]; b <= high[1]; b++)
		for (int a = low[0]; a <= high[0]; a++) {
			int label = c->cell_label[b * mpm_work(mpm)->cells_x + a];
			if (label == CELL_EMPTY || label == found)
				continue;
			if (label == CELL_MIXED || found != CELL_EMPTY)
				return LABELS_MEET;
			found = label;
		}
	return c->cracks && found >= 0 && contact_sides(mpm, c, i, j, found, c->direction[j * mpm->grid.nx + i])
			   ? SIDES_MEET
			   : NOTHING_MEETS;
}

/* Puts a label into a sorted list of n; returns how many there are then, more than `most` if it found no room. */
static int insert_label(int *labels, int n, int most, int label)
{
	int at = n;
	while (at > 0 && labels[at - 1] > label)
		at--;
	if (at > 0 && labels[at - 1] == label)
		return n;
	if (n == most)
		return most + 1;
	memmove(labels + at + 1, labels + at, (size_t)(n - at) * sizeof *labels);
	labels[at] = label;
	return n + 1;
}

/* The labels of the points whose cells reach a node, in order; marks these cells. */
static int labels_about(const struct mpm *mpm, struct contact *c, int i, int j, int labels[CONTACT_FIELDS_MOST])
{
	const struct mpm_work *w = mpm_work(mpm);
	int low[2], high[2], n = 0;
	contact_cells_about(mpm, i, j, low, high);
	for (int b = low[1]; b <= high[1]; b++)
		for (int a = low[0]; a <= high[0] && n <= CONTACT_FIELDS_MOST; a++) {
			int cell = b * w->cells_x + a, label = c->cell_label[cell];
			c->near[cell] = true;
			if (label >= 0)
				n = insert_label(labels, n, CONTACT_FIELDS_MOST, label);
			for (int k = w->cell_first[cell];
				 label == CELL_MIXED && k < w->cell_first[cell + 1] && n <= CONTACT_FIELDS_MOST; k++)
				n = insert_label(labels, n, CONTACT_FIELDS_MOST, c->label[mpm->p.body[w->order[k]]]);
		}
	return n;
}

static int too_many(const struct mpm *mpm, int i, int j, const char *what, int most, const char *cure)
{
	const struct grid *grid = &mpm->grid;
	return error_set(
		STATUS_GUARD,
		"step %lld, t = %.6g s: at the node (%.6g, %.6g) m %s than %d; cure: %s (state: start of the step)", mpm->step,
		mpm->time, grid->origin[0] + i * grid->spacing[0], grid->origin[1] + j * grid->spacing[1], what, most, cure);
}

/* The fields of a node in the order of their labels, a body that is welded to an earlier one with it; returns how many,
 * more than CONTACT_FIELDS_MOST if there is no room. */
static int fields_about(const struct mpm *mpm, struct contact *c, int i, int j,
						struct contact_field fields[CONTACT_FIELDS_MOST])
{
	int labels[CONTACT_FIELDS_MOST], n_labels = labels_about(mpm, c, i, j, labels), n = 0;
	if (n_labels > CONTACT_FIELDS_MOST)
		return n_labels;
	for (int k = 0; k < n_labels; k++) {
		bool joined = false;
		for (int m = 0; m < n && !joined; m++)
			joined = contact_joins(c, fields[m].label, labels[k]);
		if (joined)
			continue;
		struct contact_field field = {.label = labels[k]};
		int node = j * mpm->grid.nx + i;
		field.sided =
			c->meets[node] == SIDES_MEET || (c->cracks && contact_sides(mpm, c, i, j, labels[k], field.direction));
		if (c->meets[node] == SIDES_MEET)
			memcpy(field.direction, c->direction[node], sizeof field.direction);
		if (n + field.sided + 1 > CONTACT_FIELDS_MOST)
			return CONTACT_FIELDS_MOST + 1;
		fields[n++] = field;
		if (field.sided)
			fields[n] = field, fields[n++].side = 1;
	}
	return n;
}

static int add_place(struct mpm *mpm, struct contact *c, int i, int j)
{
	const int nodes = mpm->grid.nx * mpm->grid.ny, node = j * mpm->grid.nx + i;
	struct contact_field fields[CONTACT_FIELDS_MOST];
	int n = fields_about(mpm, c, i, j, fields);
	if (n > CONTACT_FIELDS_MOST)
		return too_many(mpm, i, j, "more bodies and sides of cracks meet", CONTACT_FIELDS_MOST,
						"a smaller grid.cell, or fewer bodies with contacts of their own");
	if (n < 2)
		return STATUS_OK;
	if (c->n_slots + n - 1 > c->slots_most)
		return too_many(mpm, i, j, "the scene needs more extra fields", c->slots_most, "a larger mpm.contact_fields");
	struct contact_place *place = &c->places[c->n_places++];
	*place = (struct contact_place){.node = node, .first = c->n_fields, .n = n, .first_pair = c->n_pairs};
	c->first[node] = c->n_fields;
	for (int k = 0; k < n; k++) {
		struct contact_field *field = &c->fields[c->n_fields++];
		*field = fields[k];
		field->node = node;
		if (k > 0) {
			c->home[c->n_slots] = node;
			field->node = nodes + c->n_slots++;
		}
	}
	c->n_pairs += n * (n - 1) / 2;
	return STATUS_OK;
}

/* The slots become rows of nodes behind those of the grid. */
static void add_rows(struct mpm *mpm, const struct contact *c)
{
	struct mpm_work *w = mpm_work(mpm);
	int nx = mpm->grid.nx;
	w->n_rows = mpm->grid.ny + (c->n_slots + nx - 1) / nx;
	for (int k = mpm->grid.ny; k < w->n_rows; k++) {
		int left = c->n_slots - (k - mpm->grid.ny) * nx;
		w->row_low[k] = 0;
		w->row_high[k] = (left < nx ? left : nx) - 1;
	}
}

/* What boundaries impose on a node holds for all of its fields. */
static void copy_imposed(struct mpm *mpm, const struct contact *c)
{
	struct mpm_work *w = mpm_work(mpm);
	int nodes = mpm->grid.nx * mpm->grid.ny;
	for (int s = 0; s < c->n_slots; s++) {
		int slot = nodes + s, home = c->home[s];
		if (w->fixed_v)
			memcpy(w->fixed_v[slot], w->fixed_v[home], sizeof w->fixed_v[slot]);
		if (w->fixed_T)
			w->fixed_T[slot] = w->fixed_T[home], w->fixed_T_wall[slot] = w->fixed_T_wall[home];
	}
}

bool contact_mark_cells(const struct mpm *mpm, bool (*wanted)(const struct mpm *, const struct contact_place *))
{
	const struct mpm_work *w = mpm_work(mpm);
	struct contact *c = w->contact;
	bool any = false;
	memset(c->marked, 0, (size_t)w->cells_x * (size_t)w->cells_y * sizeof *c->marked);
	for (int k = 0; k < c->n_places; k++) {
		int node = c->places[k].node, low[2], high[2];
		if (!wanted(mpm, &c->places[k]))
			continue;
		any = true;
		contact_cells_about(mpm, node % mpm->grid.nx, node / mpm->grid.nx, low, high);
		for (int b = low[1]; b <= high[1]; b++)
			for (int a = low[0]; a <= high[0]; a++)
				c->marked[b * w->cells_x + a] = true;
	}
	return any;
}

static void fold_place(struct mpm *mpm, const struct contact *c, const struct contact_place *place)
{
	struct grid *grid = &mpm->grid;
	double mass = 0.0, capacity = 0.0, heat = 0.0, v[2][2] = {{0.0}}, force[2] = {0.0};
	for (int k = place->first; k < place->first + place->n; k++) {
		int node = c->fields[k].node;
		double m = grid->mass[node], C = mpm->thermal ? grid->heat_capacity[node] : 0.0;
		mass += m, capacity += C, heat += C > 0.0 ? C * grid->T_new[node] : 0.0;
		for (int d = 0; d < 2; d++)
			v[0][d] += m * grid->v[node][d], v[1][d] += m * grid->v_new[node][d], force[d] += grid->force[node][d];
	}
	grid->mass[place->node] = mass;
	for (int d = 0; d < 2 && mass > 0.0; d++) {
		grid->v[place->node][d] = v[0][d] / mass, grid->v_new[place->node][d] = v[1][d] / mass;
		grid->force[place->node][d] = force[d];
	}
	if (capacity > 0.0)
		grid->heat_capacity[place->node] = capacity, grid->T_new[place->node] = heat / capacity;
}

void contact_fold(struct mpm *mpm)
{
	const struct contact *c = mpm_work(mpm)->contact;
#pragma omp parallel for schedule(static) if (mpm_parallel(mpm))
	for (int k = 0; k < c->n_places; k++)
		fold_place(mpm, c, &c->places[k]);
}

bool contact_drive(struct mpm *mpm, int node, int body, const double v[2])
{
	struct mpm_work *w = mpm_work(mpm);
	const struct contact *c = w->contact;
	int label = c->label[body];
	if (c->first[node] < 0)
		return false;
	struct contact_field *field = &c->fields[c->first[node]];
	while (!contact_joins(c, field->label, label))
		field++;
	memcpy(w->fixed_v[field->node], v, sizeof w->fixed_v[field->node]);
	if (field->sided)
		memcpy(w->fixed_v[field[1].node], v, sizeof w->fixed_v[field[1].node]);
	return true;
}

int contact_find_fields(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	struct contact *c = w->contact;
	forget_places(mpm, c);
	contact_find_gradients(mpm);
#pragma omp parallel for schedule(static) if (mpm_parallel(mpm))
	for (int j = 0; j < w->cells_y; j++)
		label_cells_of_row(mpm, c, j);
#pragma omp parallel for schedule(static) if (mpm_parallel(mpm))
	for (int j = 0; j < mpm->grid.ny; j++)
		for (int i = w->row_low[j]; i <= w->row_high[j]; i++)
			c->meets[j * mpm->grid.nx + i] = meeting_at(mpm, c, i, j);
	for (int j = 0; j < mpm->grid.ny; j++)
		for (int i = w->row_low[j]; i <= w->row_high[j]; i++)
			if (c->meets[j * mpm->grid.nx + i] != NOTHING_MEETS)
				CHECK(add_place(mpm, c, i, j));
	add_rows(mpm, c);
	copy_imposed(mpm, c);
	if (w->drives)
		boundaries_drive(mpm);
	walls_add_fields(mpm);
	return STATUS_OK;
}

int contact_home(const struct mpm *mpm, int node)
{
	int nodes = mpm->grid.nx * mpm->grid.ny;
	return node < nodes ? node : mpm_work(mpm)->contact->home[node - nodes];
}

void contact_redirect(const struct mpm *mpm, int n, const int *point, struct shape_lists *lists)
{
	const struct contact *c = mpm_work(mpm)->contact;
	for (int k = 0; k < n; k++) {
		if (!contact_is_near(mpm, point[k]))
			continue;
		for (int a = 0; a < lists->nodes; a++)
			if (c->first[lists->node[a][k]] >= 0)
				lists->node[a][k] = contact_field_of(mpm, c, lists->node[a][k], point[k])->node;
	}
}
