/* What acts between the fields of a node: contact forces with friction, and where their work goes.
 *
 * Fields a and b with masses m_a, m_b touch where they move into each other, (v_a - v_b).n > 0 at the end of the free
 * step, and where their gap is closed.  The impulse along n that stops them is m_a m_b/(m_a + m_b) (v_a - v_b).n
 * (eq. 75), that of friction at most mu times as much (eq. 76).
 *
 * n: the mass gradient of the heavier field, of the lighter, their difference, or the difference of their directions
 * (eq. 74), whichever parts the points of both by most.  A body's gradient says nothing of the contact where another of
 * its faces is as near: at the leading edge of a slider its own is turned forward, the base's is not; at the end of a
 * face that both share only a difference is right.  (One rule alone turns such edges into brakes: the heavier one
 * wherever the face lies between two rows of nodes.)
 *
 * Gap: nodes feel bodies a cell before they touch.  What counts is the distance along n between the foremost points of
 * both, less what their domains reach.
 *
 * Work: an impulse does the work impulse times mean velocity, the mean of before any force and after all of them.
 * Times the mean slip it is the heat of friction, exactly what the grid loses; the product with the slip after the free
 * step, which is what the force is computed from, would be several times too much. */
#include <math.h>
#include <string.h>

#include "contact/private.h"
#include "mpm/point.h"

static const double GAP_TOLERANCE = 0.1; /* of h: nearer than this is touching */
static const double BEYOND = 0.5;        /* of h */
static const double FLAT = 1e-9;         /* of h: normals that part the points by as much as another are as good */
enum {
	SWEEPS = 8, /* over the pairs of a node where three units or more meet */
	PAIRS_MOST = CONTACT_FIELDS_MOST * (CONTACT_FIELDS_MOST - 1) / 2
};

/* ---- sums of the fields ---- */

static void gather_stripe(struct mpm *mpm, struct mpm_work *w, int stripe)
{
	struct shape_lists lists;
	struct contact *c = w->contact;
	const struct particles *p = &mpm->p;
	int i, last, n, chunk[SHAPE_CHUNK];
	mpm_stripe_points(w, stripe, &i, &last);
	while ((n = contact_pick(w, c->near, &i, last, chunk)) > 0) {
		w->kernel->fill[mpm->shape->number](&w->shape_grid, &w->shape_points, n, chunk, &lists);
		for (int k = 0; k < n; k++) {
			double m = p->mass[chunk[k]], volume = mat2_determinant(p->F[chunk[k]]) * p->volume0[chunk[k]];
			for (int a = 0; a < lists.nodes; a++) {
				int node = lists.node[a][k];
				if (c->first[node] < 0 || lists.weight[a][k] == 0.0)
					continue;
				struct contact_field *field = contact_field_of(mpm, c, node, chunk[k]);
				field->gradient[0] += lists.grad_x[a][k] * m;
				field->gradient[1] += lists.grad_y[a][k] * m;
				field->volume += lists.weight[a][k] * volume;
			}
		}
	}
}

void contact_gather(struct mpm *mpm)
{
	if (mpm_work(mpm)->contact->n_places > 0)
		mpm_each_stripe(mpm, gather_stripe);
}

/* A field that has mass, while its place is worked on. */
struct unit {
	int field;
	double mass, volume;
	double v[2]; /* m/s */
	double gradient[2];
	double heat, capacity; /* J, J/K */
};

static int find_units(const struct mpm *mpm, const struct contact *c, const struct contact_place *place,
					  struct unit units[CONTACT_FIELDS_MOST])
{
	int n = 0;
	for (int k = place->first; k < place->first + place->n; k++) {
		const struct contact_field *field = &c->fields[k];
		const struct node_sum *sum = &mpm_work(mpm)->sums[field->node];
		if (!(sum->mass > 0.0))
			continue;
		units[n] = (struct unit){
			.field = k, .mass = sum->mass, .volume = field->volume, .heat = sum->heat, .capacity = sum->capacity};
		memcpy(units[n].gradient, field->gradient, sizeof units[n].gradient);
		memcpy(units[n].v, mpm->grid.v_new[field->node], sizeof units[n].v);
		n++;
	}
	return n;
}

/* ---- normal and gap ---- */

/* What parts two units: the candidates for n, and how far the points of a and b reach along them, m. */
struct parting {
	int a, b; /* indices of the units */
	int n_normals;
	double normal[4][2];
	double top[4], bottom[4]; /* of a, of b; from the node */
};

static void add_normal(struct parting *parting, double x, double y)
{
	double length = sqrt(x * x + y * y);
	int k = parting->n_normals;
	if (!(length > 0.0))
		return;
	parting->normal[k][0] = x / length, parting->normal[k][1] = y / length;
	parting->top[k] = -INFINITY, parting->bottom[k] = INFINITY;
	parting->n_normals++;
}

static struct parting begin_parting(const struct unit *units, int a, int b)
{
	struct parting parting = {.a = a, .b = b};
	const double *of_a = units[a].gradient, *of_b = units[b].gradient;
	double scale[2] = {units[a].volume / units[a].mass, units[b].volume / units[b].mass};
	bool a_first = units[a].mass >= units[b].mass;
	add_normal(&parting, a_first ? of_a[0] : -of_b[0], a_first ? of_a[1] : -of_b[1]);
	add_normal(&parting, a_first ? -of_b[0] : of_a[0], a_first ? -of_b[1] : of_a[1]);
	add_normal(&parting, scale[0] * of_a[0] - scale[1] * of_b[0], scale[0] * of_a[1] - scale[1] * of_b[1]);
	double la = sqrt(of_a[0] * of_a[0] + of_a[1] * of_a[1]), lb = sqrt(of_b[0] * of_b[0] + of_b[1] * of_b[1]);
	if (la > 0.0 && lb > 0.0)
		add_normal(&parting, of_a[0] / la - of_b[0] / lb, of_a[1] / la - of_b[1] / lb);
	return parting;
}

/* m2, of the face between two units at a node: a body may have more of its surface there, not less. */
static double face_area(const struct unit *a, const struct unit *b, const double n[2])
{
	double of_a = (a->gradient[0] * n[0] + a->gradient[1] * n[1]) * a->volume / a->mass;
	double of_b = -(b->gradient[0] * n[0] + b->gradient[1] * n[1]) * b->volume / b->mass;
	return fmin(of_a, of_b);
}

/* One point of a unit at x from the node. */
static void reach_of_point(const struct mpm *mpm, int q, int unit, const double x[2], int n, struct parting *partings)
{
	const double *F = mpm->p.F[q], half = mpm_work(mpm)->half[mpm->p.body[q]] * mpm->grid.h;
	const double reach_most = half * (fabs(F[0]) + fabs(F[1]) + fabs(F[2]) + fabs(F[3])); /* spares most roots */
	for (int k = 0; k < n; k++) {
		struct parting *parting = &partings[k];
		for (int c = 0; c < parting->n_normals && (parting->a == unit || parting->b == unit); c++) {
			const double *m = parting->normal[c];
			double at = x[0] * m[0] + x[1] * m[1], *top = &parting->top[c], *bottom = &parting->bottom[c];
			if (parting->a == unit ? at + reach_most <= *top : at - reach_most >= *bottom)
				continue;
			double gx = F[0] * m[0] + F[2] * m[1], gy = F[1] * m[0] + F[3] * m[1];
			double reach = half * sqrt(gx * gx + gy * gy);
			if (parting->a == unit)
				*top = at + reach > *top ? at + reach : *top;
			else
				*bottom = at - reach < *bottom ? at - reach : *bottom;
		}
	}
}

/* How far the points of a place reach along all its candidates.  Points count that the node can feel, and those beyond
 * them over which the foremost of the other body may stand. */
static void reach_of_points(const struct mpm *mpm, const struct contact *c, const struct contact_place *place,
							int n_units, const struct unit *units, int n, struct parting *partings)
{
	const struct mpm_work *w = mpm_work(mpm);
	const struct grid *grid = &mpm->grid;
	int i = place->node % grid->nx, j = place->node / grid->nx, low[2], high[2];
	contact_cells_about(mpm, i, j, low, high);
	for (int b = low[1]; b <= high[1]; b++)
		for (int k = w->cell_first[b * w->cells_x + low[0]]; k < w->cell_first[b * w->cells_x + high[0] + 1]; k++) {
			int q = w->order[k], unit = 0;
			double x[2] = {mpm->p.x[q][0] - grid->origin[0] - i * grid->spacing[0],
						   mpm->p.x[q][1] - grid->origin[1] - j * grid->spacing[1]};
			double support = mpm->shape->support(w->half[mpm->p.body[q]], mpm->p.F[q]) + BEYOND;
			if (fabs(x[0]) >= support * grid->spacing[0] || fabs(x[1]) >= support * grid->spacing[1])
				continue;
			int field = (int)(contact_field_of(mpm, c, place->node, q) - c->fields);
			while (unit < n_units && units[unit].field != field)
				unit++;
			if (unit < n_units)
				reach_of_point(mpm, q, unit, x, n, partings);
		}
}

/* The candidate that leaves most room between the units; -1 if they do not touch along it. */
static int choose_normal(const struct mpm *mpm, const struct parting *parting)
{
	int best = 0;
	for (int k = 1; k < parting->n_normals; k++)
		if (parting->bottom[k] - parting->top[k] > parting->bottom[best] - parting->top[best] + FLAT * mpm->grid.h)
			best = k;
	double gap = parting->bottom[best] - parting->top[best];
	return parting->n_normals > 0 && gap <= GAP_TOLERANCE * mpm->grid.h ? best : -1;
}

/* ---- contact ---- */

/* Friction falls with the temperature of the hotter side (DP-MPM eq. 15). */
static double friction_of(const struct scene_contact *s, const struct unit *a, const struct unit *b)
{
	if (isnan(s->softening[0]) || !(a->capacity > 0.0) || !(b->capacity > 0.0))
		return s->friction;
	double T = fmax(a->heat / a->capacity, b->heat / b->capacity);
	double left = fmax(0.0, s->softening[1] - T) / (s->softening[1] - s->softening[0]);
	return s->friction * left * left;
}

struct acting {
	struct contact_pair *pair;
	struct unit *a, *b;
	double friction;
};

/* Do two units that are alone at a node move into each other, whatever the normal? */
static bool approach(const struct parting *parting, const struct unit *a, const struct unit *b)
{
	bool any = false;
	for (int k = 0; k < parting->n_normals; k++)
		any = any || (a->v[0] - b->v[0]) * parting->normal[k][0] + (a->v[1] - b->v[1]) * parting->normal[k][1] > 0.0;
	return any;
}

/* Pairs of a place that touch, in the order of the fields. */
static int find_pairs(const struct mpm *mpm, struct contact *c, struct contact_place *place, int n, struct unit *units,
					  struct acting *acting)
{
	struct parting partings[PAIRS_MOST];
	int looked = 0;
	place->n_pairs = 0;
	for (int b = 1; b < n; b++)
		for (int a = 0; a < b; a++)
			partings[looked++] = begin_parting(units, a, b);
	if (n == 2 && !approach(&partings[0], &units[0], &units[1]))
		return 0;
	if (looked > 0)
		reach_of_points(mpm, c, place, n, units, looked, partings);
	for (int k = 0; k < looked; k++) {
		const struct parting *parting = &partings[k];
		struct unit *a = &units[parting->a], *b = &units[parting->b];
		int best = choose_normal(mpm, parting);
		if (best < 0)
			continue;
		struct contact_pair *pair = &c->pairs[place->first_pair + place->n_pairs];
		*pair = (struct contact_pair){.a = a->field, .b = b->field, .area = face_area(a, b, parting->normal[best])};
		pair->capacity = fmin(a->capacity / a->volume, b->capacity / b->volume);
		pair->face = 0.5 * (parting->top[best] + parting->bottom[best]);
		memcpy(pair->normal, parting->normal[best], sizeof pair->normal);
		int la = c->fields[a->field].label, lb = c->fields[b->field].label;
		pair->contact = la == lb ? c->own[la] : c->pair[la * c->n_labels + lb];
		if (pair->contact < 0)
			continue;
		acting[place->n_pairs++] = (struct acting){pair, a, b, friction_of(&mpm->scene->contacts[pair->contact], a, b)};
	}
	return place->n_pairs;
}

/* Totals of the step are clamped, so that a later sweep can take back what an earlier one did too much. */
static void act(const struct acting *acting)
{
	struct contact_pair *pair = acting->pair;
	struct unit *a = acting->a, *b = acting->b;
	const double *n = pair->normal;
	double reduced = a->mass * b->mass / (a->mass + b->mass);
	double jump[2] = {a->v[0] - b->v[0], a->v[1] - b->v[1]};
	double push = pair->push + reduced * (jump[0] * n[0] + jump[1] * n[1]),
		   drag = pair->drag + reduced * (-jump[0] * n[1] + jump[1] * n[0]);
	push = push > 0.0 ? push : 0.0;
	double limit = acting->friction * push;
	drag = drag > limit ? limit : drag < -limit ? -limit : drag;
	double dn = push - pair->push, dt = drag - pair->drag;
	const double impulse[2] = {dn * n[0] - dt * n[1], dn * n[1] + dt * n[0]};
	for (int d = 0; d < 2; d++)
		a->v[d] -= impulse[d] / a->mass, b->v[d] += impulse[d] / b->mass;
	pair->push = push, pair->drag = drag;
}

static void apply_at(struct mpm *mpm, struct contact *c, struct contact_place *place)
{
	struct unit units[CONTACT_FIELDS_MOST];
	struct acting acting[PAIRS_MOST];
	int n = find_units(mpm, c, place, units), pairs = find_pairs(mpm, c, place, n, units, acting);
	for (int sweep = 0; sweep < (pairs > 1 ? SWEEPS : 1); sweep++)
		for (int k = 0; k < pairs; k++)
			act(&acting[k]);
	for (int u = 0; u < n && pairs > 0; u++)
		memcpy(mpm->grid.v_new[c->fields[units[u].field].node], units[u].v, sizeof units[u].v);
}

void contact_apply(struct mpm *mpm)
{
	struct contact *c = mpm_work(mpm)->contact;
#pragma omp parallel for schedule(static) if (mpm_parallel(mpm))
	for (int k = 0; k < c->n_places; k++)
		apply_at(mpm, c, &c->places[k]);
}

/* ---- where the work went ---- */

static void account_pair(const struct mpm *mpm, struct contact *c, struct contact_place *place,
						 const struct contact_pair *pair)
{
	const struct grid *grid = &mpm->grid;
	struct contact_field *fields[2] = {&c->fields[pair->a], &c->fields[pair->b]};
	int a = fields[0]->node, b = fields[1]->node;
	const double *n = pair->normal,
				 jump[2] = {0.5 * (grid->v[a][0] + grid->v_new[a][0] - grid->v[b][0] - grid->v_new[b][0]),
							0.5 * (grid->v[a][1] + grid->v_new[a][1] - grid->v[b][1] - grid->v_new[b][1])};
	double tangent_loss = pair->drag * (-jump[0] * n[1] + jump[1] * n[0]);
	double friction = tangent_loss > 0.0 ? tangent_loss : 0.0;
	double heat = mpm->thermal ? mpm->scene->contacts[pair->contact].heat_share * friction : 0.0;
	place->friction += friction;
	place->impact += pair->push * (jump[0] * n[0] + jump[1] * n[1]) + tangent_loss - friction;
	place->heat += heat;
	for (int k = 0; k < 2; k++) {
		fields[k]->heat += 0.5 * heat;
		fields[k]->pressure += pair->area > 0.0 ? pair->push / (mpm->dt * pair->area) : 0.0;
	}
}

static void account_place(const struct mpm *mpm, struct contact *c, struct contact_place *place)
{
	for (int k = place->first_pair; k < place->first_pair + place->n_pairs; k++)
		if (c->pairs[k].push > 0.0)
			account_pair(mpm, c, place, &c->pairs[k]);
}

/* The pressure that a block of points feels from the fields that they belong to. */
static void press_block(struct mpm *mpm, int block)
{
	struct shape_lists lists;
	const struct mpm_work *w = mpm_work(mpm);
	const struct contact *c = w->contact;
	const int first = block * BLOCK_POINTS,
			  last = first + BLOCK_POINTS < w->n_inside ? first + BLOCK_POINTS : w->n_inside;
	for (int i = first; i < last; i++)
		mpm->p.contact_pressure[w->order[i]] = penalty_pressure(mpm, w->order[i]);
	int i = first, n, chunk[SHAPE_CHUNK];
	while ((n = contact_pick(w, c->marked, &i, last, chunk)) > 0) {
		w->kernel->fill[mpm->shape->number](&w->shape_grid, &w->shape_points, n, chunk, &lists);
		for (int k = 0; k < n; k++)
			for (int a = 0; a < lists.nodes; a++)
				if (c->first[lists.node[a][k]] >= 0)
					mpm->p.contact_pressure[chunk[k]] +=
						lists.weight[a][k] * contact_field_of(mpm, c, lists.node[a][k], chunk[k])->pressure;
	}
}

static bool place_presses(const struct mpm *mpm, const struct contact_place *place)
{
	const struct contact *c = mpm_work(mpm)->contact;
	bool any = false;
	for (int k = place->first; k < place->first + place->n; k++)
		any = any || c->fields[k].pressure > 0.0;
	return any;
}

void contact_account(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	struct contact *c = w->contact;
#pragma omp parallel for schedule(static) if (mpm_parallel(mpm))
	for (int k = 0; k < c->n_places; k++)
		account_place(mpm, c, &c->places[k]);
	contact_mark_cells(mpm, place_presses);
#pragma omp parallel for schedule(static) if (mpm_parallel(mpm))
	for (int block = 0; block < w->n_blocks; block++)
		press_block(mpm, block);
}

void contact_add_to_ledger(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	const struct contact *c = w->contact;
	for (int k = 0; k < c->n_places; k++) {
		w->total.work_contact_friction += c->places[k].friction;
		w->total.loss_contact += c->places[k].impact;
		w->total.heat_contacts += c->places[k].heat;
	}
}
