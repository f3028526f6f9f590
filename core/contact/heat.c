/* Heat between the fields of a node.
 *
 * The conductance of a contact grows with its pressure, hc = h0 (p/p0)^e (DP-MPM eq. 11); over the surface that belongs
 * to the node it is hc A, and A = f/p.  It grows no further than rho c h/2 dt, where a step would take the points of a
 * cell to the other body's temperature: the resistance that is left then is less than that of a cell.
 *
 * The temperature at the face is not the mean of a field's points, which all lie on one side of it: that would be wrong
 * by the slope times the distance to their centre, and with it the flow.  The slope of the grid at the points says what
 * is missing; that in turn depends on the nodes at the face, so it is looked at a few times over.  (A plane through the
 * points themselves would amplify what noise of theirs the nodes cannot see.)
 *
 * What flows is decided at the face, whose place between the rows of nodes is known.  Then a straight line of
 * temperatures in a body is steady at every node that it reaches, also where it has next to no mass: conduction brings
 * each node the flux times the area of the face that belongs to it, and that is what the contact takes.
 *
 * Bonded fields are one body: their temperatures change at one rate, that of their sum. */
#include <math.h>

#include "contact/private.h"

enum { LIFTS = 3 }; /* each leaves about a third of the error before */

/* ---- temperatures at the face ---- */

static void lift_stripe(struct mpm *mpm, struct mpm_work *w, int stripe)
{
	struct shape_lists lists;
	struct contact *c = w->contact;
	const struct particles *p = &mpm->p;
	const struct grid *grid = &mpm->grid;
	int first, last;
	mpm_stripe_points(w, stripe, &first, &last);
	for (int i = first; i < last; i++) {
		int q = w->order[i];
		double gx = 0.0, gy = 0.0, capacity = p->mass[q] * p->capacity[q];
		if (!contact_is_near(mpm, q))
			continue;
		mpm_lists(mpm, 1, &q, &lists);
		for (int a = 0; a < lists.nodes; a++) {
			gx += lists.grad_x[a] * grid->T[lists.node[a]];
			gy += lists.grad_y[a] * grid->T[lists.node[a]];
		}
		for (int a = 0; a < lists.nodes; a++) {
			int node = mpm_home(mpm, lists.node[a]);
			if (c->first[node] < 0)
				continue;
			double x = grid->origin[0] + node % grid->nx * grid->spacing[0] - p->x[q][0],
				   y = grid->origin[1] + node / grid->nx * grid->spacing[1] - p->x[q][1];
			struct contact_field *field = contact_field_of(c, node, c->label[p->body[q]]);
			field->lift += capacity * lists.weight[a] * (gx * x + gy * y);
			field->slope[0] += capacity * lists.weight[a] * gx;
			field->slope[1] += capacity * lists.weight[a] * gy;
		}
	}
}

static bool conducts(const struct mpm *mpm, const struct contact_pair *pair)
{
	return pair->push > 0.0 && pair->area > 0.0 && mpm->scene->contacts[pair->contact].conductance > 0.0;
}

static void mark_unit(const struct mpm *mpm, struct contact *c, const struct contact_place *place, int unit)
{
	for (int k = place->first; k < place->first + place->n; k++) {
		struct contact_field *field = &c->fields[k];
		field->conducts = field->conducts || (field->unit == unit && isnan(mpm_work(mpm)->fixed_T[field->node]));
	}
}

static bool mark_conducting(const struct mpm *mpm, struct contact *c)
{
	bool any = false;
	for (int k = 0; k < c->n_fields; k++)
		c->fields[k].plain = mpm->grid.T[c->fields[k].node];
	for (int k = 0; k < c->n_places; k++) {
		const struct contact_place *place = &c->places[k];
		for (int m = place->first_pair; m < place->first_pair + place->n_pairs; m++)
			if (conducts(mpm, &c->pairs[m])) {
				mark_unit(mpm, c, place, c->pairs[m].a);
				mark_unit(mpm, c, place, c->pairs[m].b);
				any = true;
			}
	}
	return any;
}

void contact_set_temperatures(struct mpm *mpm)
{
	struct contact *c = mpm_work(mpm)->contact;
	if (!mark_conducting(mpm, c))
		return;
	for (int look = 0; look < LIFTS; look++) {
		for (int k = 0; k < c->n_fields; k++)
			c->fields[k].lift = c->fields[k].slope[0] = c->fields[k].slope[1] = 0.0;
		mpm_each_stripe(mpm, lift_stripe);
		for (int k = 0; k < c->n_fields; k++) {
			const struct contact_field *field = &c->fields[k];
			double capacity = mpm_work(mpm)->sums[field->node].capacity;
			if (field->conducts && capacity > 0.0)
				mpm->grid.T[field->node] = mpm->grid.T_new[field->node] = field->plain + field->lift / capacity;
		}
	}
}

/* ---- flows ---- */

/* Heat capacity of a unit, J/K, and its temperature now, K. */
static double unit_capacity(const struct mpm *mpm, const struct contact *c, const struct contact_place *place, int unit,
							double *T)
{
	double capacity = 0.0, heat = 0.0;
	for (int k = place->first; k < place->first + place->n; k++)
		if (c->fields[k].unit == unit) {
			double of_field = mpm_work(mpm)->sums[c->fields[k].node].capacity;
			capacity += of_field;
			heat += of_field * mpm->grid.T_new[c->fields[k].node];
		}
	*T = capacity > 0.0 ? heat / capacity : 0.0;
	return capacity;
}

/* The temperature of a unit at the face of a pair, K. */
static double face_temperature(const struct mpm *mpm, const struct contact *c, const struct contact_place *place,
							   const struct contact_pair *pair, int unit, double *capacity)
{
	double T, slope = 0.0;
	*capacity = unit_capacity(mpm, c, place, unit, &T);
	for (int k = place->first; k < place->first + place->n; k++)
		if (c->fields[k].unit == unit)
			slope += c->fields[k].slope[0] * pair->normal[0] + c->fields[k].slope[1] * pair->normal[1];
	return *capacity > 0.0 ? T + slope / *capacity * pair->face : T;
}

static void add_flow(const struct mpm *mpm, const struct contact *c, const struct contact_place *place, int unit,
					 double capacity, double flow)
{
	for (int k = place->first; k < place->first + place->n; k++)
		if (c->fields[k].unit == unit) {
			struct node_sum *sum = &mpm_work(mpm)->sums[c->fields[k].node];
			sum->flow += flow * sum->capacity / capacity;
		}
}

static void conduct(const struct mpm *mpm, const struct contact *c, const struct contact_place *place,
					const struct contact_pair *pair, double dt)
{
	const struct scene_contact *s = &mpm->scene->contacts[pair->contact];
	double Ca, Cb;
	if (!conducts(mpm, pair))
		return;
	double Ta = face_temperature(mpm, c, place, pair, pair->a, &Ca),
		   Tb = face_temperature(mpm, c, place, pair, pair->b, &Cb);
	if (!(Ca > 0.0) || !(Cb > 0.0))
		return;
	double relative = pair->push / (mpm->dt * pair->area * s->conductance_pressure);
	double conductance =
		s->conductance * (s->conductance_exponent == 1.0 ? relative : pow(relative, s->conductance_exponent));
	double most = 0.5 * pair->capacity * mpm->grid.h / dt;
	double flow = fmin(conductance, most) * pair->area * (Tb - Ta);
	add_flow(mpm, c, place, pair->a, Ca, flow);
	add_flow(mpm, c, place, pair->b, Cb, -flow);
}

static void share_among_bonded(const struct mpm *mpm, const struct contact *c, const struct contact_place *place,
							   int unit)
{
	double T, capacity = unit_capacity(mpm, c, place, unit, &T), flow = 0.0;
	int members = 0;
	for (int k = place->first; k < place->first + place->n; k++)
		if (c->fields[k].unit == unit)
			members++, flow += mpm_work(mpm)->sums[c->fields[k].node].flow;
	for (int k = place->first; k < place->first + place->n && members > 1 && capacity > 0.0; k++)
		if (c->fields[k].unit == unit) {
			struct node_sum *sum = &mpm_work(mpm)->sums[c->fields[k].node];
			sum->flow = flow * sum->capacity / capacity;
		}
}

static void exchange_at(const struct mpm *mpm, const struct contact *c, const struct contact_place *place, double dt)
{
	const struct mpm_work *w = mpm_work(mpm);
	for (int k = place->first; k < place->first + place->n; k++)
		w->sums[c->fields[k].node].flow += c->fields[k].heat / w->thermal_dt;
	for (int k = place->first_pair; k < place->first_pair + place->n_pairs; k++)
		conduct(mpm, c, place, &c->pairs[k], dt);
	for (int k = place->first; k < place->first + place->n; k++)
		if (c->fields[k].unit == k)
			share_among_bonded(mpm, c, place, k);
}

void contact_exchange_heat(struct mpm *mpm, double dt)
{
	const struct contact *c = mpm_work(mpm)->contact;
#pragma omp parallel for schedule(static) if (mpm_parallel(mpm))
	for (int k = 0; k < c->n_places; k++)
		exchange_at(mpm, c, &c->places[k], dt);
}
