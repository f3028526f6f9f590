/* What acts between the fields of a node: bonds, contact forces with friction, and where their work goes.
 *
 * Units a and b with masses m_a, m_b touch where they move into each other, (v_a - v_b).n > 0 at the end of the free
 * step, and where their gap is closed.  The impulse along n that stops them is m_a m_b/(m_a + m_b) (v_a - v_b).n
 * (eq. 75), that of friction at most mu times as much (eq. 76).
 *
 * n: the mass gradient of the heavier unit or of the lighter, whichever parts the points of both by more.  A body's
 * gradient says nothing of the contact where another of its faces is as near: at the leading edge of a slider its own is
 * turned forward, the base's is not.  (The heavier one alone, or a mean of both, eq. 74, turns such edges into brakes,
 * the former wherever the face lies between two rows of nodes.)
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
	int first, last;
	mpm_stripe_points(w, stripe, &first, &last);
	for (int i = first; i < last; i++) {
		int q = w->order[i];
		if (!contact_is_near(mpm, q))
			continue;
		mpm->shape->fill(&w->shape_grid, &w->shape_points, 1, &q, &lists);
		double m = p->mass[q], volume = mat2_determinant(p->F[q]) * p->volume0[q];
		for (int a = 0; a < lists.nodes; a++) {
			int node = lists.node[a];
			if (c->first[node] < 0 || lists.weight[a] == 0.0)
				continue;
			struct contact_field *field = contact_field_of(c, node, c->label[p->body[q]]);
			field->gradient[0] += lists.grad_x[a] * m;
			field->gradient[1] += lists.grad_y[a] * m;
			field->volume += lists.weight[a] * volume;
		}
	}
}

void contact_gather(struct mpm *mpm)
{
	if (mpm_work(mpm)->contact->n_places > 0)
		mpm_each_stripe(mpm, gather_stripe);
}

/* ---- units ---- */

/* Fields that are bonded to each other form one unit, for which the first of them stands. */
static void bond_fields(const struct mpm *mpm, struct contact *c, const struct contact_place *place)
{
	for (int k = place->first; k < place->first + place->n; k++) {
		struct contact_field *field = &c->fields[k];
		field->unit = mpm_work(mpm)->sums[field->node].mass > 0.0 ? k : -1;
		for (int other = place->first; other < k && field->unit >= 0; other++) {
			const struct contact_field *before = &c->fields[other];
			if (before->unit < 0 || c->pair[before->label * c->n_labels + field->label] >= 0)
				continue;
			for (int m = place->first, merged = field->unit; m <= k; m++)
				if (c->fields[m].unit == merged)
					c->fields[m].unit = before->unit;
		}
	}
}

/* The units of a place; returns their number. */
static int sum_units(const struct mpm *mpm, const struct contact *c, const struct contact_place *place,
					 struct contact_unit units[CONTACT_FIELDS_MOST])
{
	const struct mpm_work *w = mpm_work(mpm);
	int n = 0;
	for (int k = place->first; k < place->first + place->n; k++) {
		const struct contact_field *field = &c->fields[k];
		if (field->unit < 0)
			continue;
		int u = 0;
		while (u < n && units[u].field != field->unit)
			u++;
		if (u == n)
			units[n++] = (struct contact_unit){.field = field->unit};
		const struct node_sum *sum = &w->sums[field->node];
		units[u].mass += sum->mass;
		units[u].volume += field->volume;
		units[u].heat += sum->heat, units[u].capacity += sum->capacity;
		for (int d = 0; d < 2; d++) {
			units[u].v[d] += sum->mass * mpm->grid.v_new[field->node][d];
			units[u].gradient[d] += field->gradient[d];
		}
	}
	for (int u = 0; u < n; u++)
		units[u].v[0] /= units[u].mass, units[u].v[1] /= units[u].mass;
	return n;
}

/* Bonded fields change by the acceleration of their sum.  (To draw their velocities together instead would act like
 * PIC on the flanks of every crack that is not yet one.) */
static void apply_bonds(struct mpm *mpm, struct contact *c, const struct contact_place *place)
{
	const struct mpm_work *w = mpm_work(mpm);
	struct grid *grid = &mpm->grid;
	for (int u = place->first; u < place->first + place->n; u++) {
		double mass = 0.0, change[2] = {0.0, 0.0};
		int members = 0;
		for (int k = place->first; k < place->first + place->n; k++) {
			int node = c->fields[k].node;
			if (c->fields[k].unit != u)
				continue;
			members++;
			mass += w->sums[node].mass;
			for (int d = 0; d < 2; d++)
				change[d] += w->sums[node].mass * (grid->v_new[node][d] - grid->v[node][d]);
		}
		for (int k = place->first; k < place->first + place->n && members > 1; k++)
			for (int d = 0; d < 2 && c->fields[k].unit == u; d++) {
				int node = c->fields[k].node;
				double bonded = grid->v[node][d] + change[d] / mass;
				c->fields[k].bond[d] = w->sums[node].mass * (bonded - grid->v_new[node][d]);
				grid->v_new[node][d] = bonded;
			}
	}
}

/* ---- normal and gap ---- */

/* What parts two units: the candidates for n, and how far the points of a and b reach along them, m. */
struct parting {
	int a, b; /* units */
	int n_normals;
	double normal[2][2], area[2];
	double top[2], bottom[2]; /* of a, of b; from the node */
};

static void add_normal(struct parting *parting, const struct contact_unit *unit, double sign)
{
	double length = sqrt(unit->gradient[0] * unit->gradient[0] + unit->gradient[1] * unit->gradient[1]);
	int k = parting->n_normals;
	if (!(length > 0.0))
		return;
	parting->normal[k][0] = sign * unit->gradient[0] / length;
	parting->normal[k][1] = sign * unit->gradient[1] / length;
	parting->area[k] = length * unit->volume / unit->mass;
	parting->top[k] = -INFINITY, parting->bottom[k] = INFINITY;
	parting->n_normals++;
}

static struct parting begin_parting(const struct contact_unit *units, int a, int b)
{
	struct parting parting = {.a = a, .b = b};
	bool a_first = units[a].mass >= units[b].mass;
	add_normal(&parting, &units[a_first ? a : b], a_first ? 1.0 : -1.0);
	add_normal(&parting, &units[a_first ? b : a], a_first ? -1.0 : 1.0);
	return parting;
}

/* One point of a unit at x from the node. */
static void reach_of_point(const struct mpm *mpm, int q, int unit, const double x[2], int n, struct parting *partings)
{
	const double *F = mpm->p.F[q], half = mpm_work(mpm)->half[mpm->p.body[q]] * mpm->grid.h;
	for (int k = 0; k < n; k++) {
		struct parting *parting = &partings[k];
		for (int c = 0; c < parting->n_normals && (parting->a == unit || parting->b == unit); c++) {
			const double *m = parting->normal[c];
			double gx = F[0] * m[0] + F[2] * m[1], gy = F[1] * m[0] + F[3] * m[1];
			double at = x[0] * m[0] + x[1] * m[1], reach = half * sqrt(gx * gx + gy * gy);
			if (parting->a == unit)
				parting->top[c] = fmax(parting->top[c], at + reach);
			else
				parting->bottom[c] = fmin(parting->bottom[c], at - reach);
		}
	}
}

/* How far the points of a place reach along all its candidates.  Points count that the node can feel. */
static void reach_of_points(const struct mpm *mpm, const struct contact *c, const struct contact_place *place, int n_units,
							const struct contact_unit *units, int n, struct parting *partings)
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
			double support = mpm->shape->support(w->half[mpm->p.body[q]], mpm->p.F[q]);
			if (fabs(x[0]) >= support * grid->spacing[0] || fabs(x[1]) >= support * grid->spacing[1])
				continue;
			int field = contact_field_of(c, place->node, c->label[mpm->p.body[q]])->unit;
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
	if (parting->n_normals == 2 && parting->bottom[1] - parting->top[1] >
									   parting->bottom[0] - parting->top[0] + FLAT * mpm->grid.h)
		best = 1;
	double gap = parting->bottom[best] - parting->top[best];
	return parting->n_normals > 0 && gap <= GAP_TOLERANCE * mpm->grid.h ? best : -1;
}

/* ---- contact ---- */

/* Friction falls with the temperature of the hotter side (DP-MPM eq. 15). */
static double friction_of(const struct scene_contact *s, const struct contact_unit *a, const struct contact_unit *b)
{
	if (isnan(s->softening[0]) || !(a->capacity > 0.0) || !(b->capacity > 0.0))
		return s->friction;
	double T = fmax(a->heat / a->capacity, b->heat / b->capacity);
	double left = fmax(0.0, s->softening[1] - T) / (s->softening[1] - s->softening[0]);
	return s->friction * left * left;
}

struct acting {
	struct contact_pair *pair;
	struct contact_unit *a, *b;
	double friction;
};

/* Pairs of a place that touch, in the order of the fields. */
static int find_pairs(const struct mpm *mpm, struct contact *c, struct contact_place *place, int n,
					  struct contact_unit *units, struct acting *acting)
{
	struct parting partings[PAIRS_MOST];
	int looked = 0;
	place->n_pairs = 0;
	for (int b = 1; b < n; b++)
		for (int a = 0; a < b; a++)
			partings[looked++] = begin_parting(units, a, b);
	if (looked > 0)
		reach_of_points(mpm, c, place, n, units, looked, partings);
	for (int k = 0; k < looked; k++) {
		const struct parting *parting = &partings[k];
		struct contact_unit *a = &units[parting->a], *b = &units[parting->b];
		int best = choose_normal(mpm, parting);
		if (best < 0)
			continue;
		struct contact_pair *pair = &c->pairs[place->first_pair + place->n_pairs];
		*pair = (struct contact_pair){.a = a->field, .b = b->field, .area = parting->area[best]};
		memcpy(pair->normal, parting->normal[best], sizeof pair->normal);
		pair->contact = c->pair[c->fields[a->field].label * c->n_labels + c->fields[b->field].label];
		acting[place->n_pairs++] =
			(struct acting){pair, a, b, friction_of(&mpm->scene->contacts[pair->contact], a, b)};
	}
	return place->n_pairs;
}

/* Totals of the step are clamped, so that a later sweep can take back what an earlier one did too much. */
static void act(const struct acting *acting)
{
	struct contact_pair *pair = acting->pair;
	struct contact_unit *a = acting->a, *b = acting->b;
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

/* The change of a unit's velocity is that of each of its fields. */
static void change_fields(struct mpm *mpm, const struct contact *c, const struct contact_place *place,
						  const struct contact_unit *unit, const double before[2])
{
	for (int k = place->first; k < place->first + place->n; k++)
		for (int d = 0; d < 2 && c->fields[k].unit == unit->field; d++)
			mpm->grid.v_new[c->fields[k].node][d] += unit->v[d] - before[d];
}

static void apply_at(struct mpm *mpm, struct contact *c, struct contact_place *place)
{
	struct contact_unit units[CONTACT_FIELDS_MOST];
	struct acting acting[PAIRS_MOST];
	double before[CONTACT_FIELDS_MOST][2];
	bond_fields(mpm, c, place);
	apply_bonds(mpm, c, place);
	int n = sum_units(mpm, c, place, units), pairs = find_pairs(mpm, c, place, n, units, acting);
	for (int u = 0; u < n; u++)
		memcpy(before[u], units[u].v, sizeof before[u]);
	for (int sweep = 0; sweep < (pairs > 1 ? SWEEPS : 1); sweep++)
		for (int k = 0; k < pairs; k++)
			act(&acting[k]);
	for (int u = 0; u < n && pairs > 0; u++)
		change_fields(mpm, c, place, &units[u], before[u]);
}

void contact_apply(struct mpm *mpm)
{
	struct contact *c = mpm_work(mpm)->contact;
#pragma omp parallel for schedule(static) if (mpm_parallel(mpm))
	for (int k = 0; k < c->n_places; k++)
		apply_at(mpm, c, &c->places[k]);
}

/* ---- where the work went ---- */

/* Mean of the velocities of a unit before and after the step, m/s; and its mass, kg. */
static double mean_velocity(const struct mpm *mpm, const struct contact *c, const struct contact_place *place, int unit,
							double v[2])
{
	double mass = 0.0;
	v[0] = v[1] = 0.0;
	for (int k = place->first; k < place->first + place->n; k++) {
		int node = c->fields[k].node;
		double m = mpm->grid.mass[node];
		if (c->fields[k].unit != unit)
			continue;
		mass += m;
		for (int d = 0; d < 2; d++)
			v[d] += 0.5 * m * (mpm->grid.v[node][d] + mpm->grid.v_new[node][d]);
	}
	v[0] /= mass, v[1] /= mass;
	return mass;
}

/* Gives a unit its heat and its pressure, the former in proportion to the mass of its fields. */
static void give_unit(const struct mpm *mpm, struct contact *c, const struct contact_place *place, int unit,
					  double mass, double heat, double pressure)
{
	for (int k = place->first; k < place->first + place->n; k++) {
		if (c->fields[k].unit != unit)
			continue;
		c->fields[k].heat += heat * mpm->grid.mass[c->fields[k].node] / mass;
		c->fields[k].pressure += pressure;
	}
}

static void account_pair(const struct mpm *mpm, struct contact *c, struct contact_place *place,
						 const struct contact_pair *pair)
{
	double va[2], vb[2], ma = mean_velocity(mpm, c, place, pair->a, va), mb = mean_velocity(mpm, c, place, pair->b, vb);
	const double *n = pair->normal, jump[2] = {va[0] - vb[0], va[1] - vb[1]};
	double tangent_loss = pair->drag * (-jump[0] * n[1] + jump[1] * n[0]);
	double friction = tangent_loss > 0.0 ? tangent_loss : 0.0;
	double heat = mpm->thermal ? mpm->scene->contacts[pair->contact].heat_share * friction : 0.0;
	place->friction += friction;
	place->impact += pair->push * (jump[0] * n[0] + jump[1] * n[1]) + tangent_loss - friction;
	place->heat += heat;
	double pressure = pair->push / (mpm->dt * pair->area);
	give_unit(mpm, c, place, pair->a, ma, 0.5 * heat, pressure);
	give_unit(mpm, c, place, pair->b, mb, 0.5 * heat, pressure);
}

static void account_place(const struct mpm *mpm, struct contact *c, struct contact_place *place)
{
	for (int k = place->first; k < place->first + place->n; k++) {
		const struct contact_field *field = &c->fields[k];
		for (int d = 0; d < 2; d++)
			place->impact -=
				0.5 * field->bond[d] * (mpm->grid.v[field->node][d] + mpm->grid.v_new[field->node][d]);
	}
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
	for (int i = first; i < last; i++) {
		int q = w->order[i];
		double pressure = 0.0;
		if (contact_is_near(mpm, q)) {
			mpm->shape->fill(&w->shape_grid, &w->shape_points, 1, &q, &lists);
			for (int a = 0; a < lists.nodes; a++)
				if (c->first[lists.node[a]] >= 0)
					pressure += lists.weight[a] *
								contact_field_of(c, lists.node[a], c->label[mpm->p.body[q]])->pressure;
		}
		mpm->p.contact_pressure[q] = pressure;
	}
}

void contact_account(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	struct contact *c = w->contact;
#pragma omp parallel for schedule(static) if (mpm_parallel(mpm))
	for (int k = 0; k < c->n_places; k++)
		account_place(mpm, c, &c->places[k]);
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
