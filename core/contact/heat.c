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
 * each node the flux times the area of the face that belongs to it, and that is what the contact takes. */
#include <math.h>

#include "contact/private.h"

enum { LIFTS = 3 }; /* each leaves about a third of the error before */

/* ---- temperatures at the face ---- */

/* Point q, number k of its lists. */
static void lift_point(const struct mpm *mpm, struct contact *c, const struct shape_lists *lists, int k, int q)
{
	const struct particles *p = &mpm->p;
	const struct grid *grid = &mpm->grid;
	double gx = 0.0, gy = 0.0, capacity = p->mass[q] * p->capacity[q];
	for (int a = 0; a < lists->nodes; a++) {
		gx += lists->grad_x[a][k] * grid->T[lists->node[a][k]];
		gy += lists->grad_y[a][k] * grid->T[lists->node[a][k]];
	}
	for (int a = 0; a < lists->nodes; a++) {
		int node = mpm_home(mpm, lists->node[a][k]);
		if (c->first[node] < 0)
			continue;
		double x = grid->origin[0] + node % grid->nx * grid->spacing[0] - p->x[q][0],
			   y = grid->origin[1] + node / grid->nx * grid->spacing[1] - p->x[q][1];
		struct contact_field *field = contact_field_of(mpm, c, node, q);
		field->lift += capacity * lists->weight[a][k] * (gx * x + gy * y);
		field->slope[0] += capacity * lists->weight[a][k] * gx;
		field->slope[1] += capacity * lists->weight[a][k] * gy;
	}
}

static void lift_stripe(struct mpm *mpm, struct mpm_work *w, int stripe)
{
	struct shape_lists lists;
	struct contact *c = w->contact;
	int i, last, n, chunk[SHAPE_CHUNK];
	mpm_stripe_points(w, stripe, &i, &last);
	while ((n = contact_pick(w, c->marked, &i, last, chunk)) > 0) {
		mpm_lists(mpm, n, chunk, &lists);
		for (int k = 0; k < n; k++)
			lift_point(mpm, c, &lists, k, chunk[k]);
	}
}

static bool conducts(const struct mpm *mpm, const struct contact_pair *pair)
{
	return pair->push > 0.0 && pair->area > 0.0 && mpm->scene->contacts[pair->contact].conductance > 0.0;
}

static bool place_conducts(const struct mpm *mpm, const struct contact_place *place)
{
	const struct contact *c = mpm_work(mpm)->contact;
	bool any = false;
	for (int k = place->first; k < place->first + place->n; k++)
		any = any || c->fields[k].conducts;
	return any;
}

static bool mark_conducting(const struct mpm *mpm, struct contact *c)
{
	for (int k = 0; k < c->n_fields; k++)
		c->fields[k].plain = mpm->grid.T[c->fields[k].node];
	for (int k = 0; k < c->n_places; k++) {
		const struct contact_place *place = &c->places[k];
		for (int m = place->first_pair; m < place->first_pair + place->n_pairs; m++)
			if (conducts(mpm, &c->pairs[m])) {
				c->fields[c->pairs[m].a].conducts = c->fields[c->pairs[m].b].conducts = true;
			}
	}
	return contact_mark_cells(mpm, place_conducts);
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
			if (field->conducts && capacity > 0.0 && isnan(mpm_work(mpm)->fixed_T[field->node]))
				mpm->grid.T[field->node] = mpm->grid.T_new[field->node] = field->plain + field->lift / capacity;
		}
	}
}

/* ---- flows ---- */

/* The temperature of a field at the face of a pair, K. */
static double face_temperature(const struct mpm *mpm, const struct contact_field *field,
							   const struct contact_pair *pair)
{
	double slope = field->slope[0] * pair->normal[0] + field->slope[1] * pair->normal[1];
	return mpm->grid.T_new[field->node] + slope / mpm_work(mpm)->sums[field->node].capacity * pair->face;
}

static void conduct(const struct mpm *mpm, const struct contact *c, const struct contact_pair *pair, double dt)
{
	const struct scene_contact *s = &mpm->scene->contacts[pair->contact];
	const struct contact_field *a = &c->fields[pair->a], *b = &c->fields[pair->b];
	if (!conducts(mpm, pair))
		return;
	double relative = pair->push / (mpm->dt * pair->area * s->conductance_pressure);
	double conductance =
		s->conductance * (s->conductance_exponent == 1.0 ? relative : pow(relative, s->conductance_exponent));
	double most = 0.5 * pair->capacity * mpm->grid.h / dt;
	double flow =
		fmin(conductance, most) * pair->area * (face_temperature(mpm, b, pair) - face_temperature(mpm, a, pair));
	mpm_work(mpm)->sums[a->node].flow += flow;
	mpm_work(mpm)->sums[b->node].flow -= flow;
}

static void exchange_at(const struct mpm *mpm, const struct contact *c, const struct contact_place *place, double dt)
{
	const struct mpm_work *w = mpm_work(mpm);
	for (int k = place->first; k < place->first + place->n; k++)
		w->sums[c->fields[k].node].flow += c->fields[k].heat / w->thermal_dt;
	for (int k = place->first_pair; k < place->first_pair + place->n_pairs; k++)
		conduct(mpm, c, &c->pairs[k], dt);
}

void contact_exchange_heat(struct mpm *mpm, double dt)
{
	const struct contact *c = mpm_work(mpm)->contact;
#pragma omp parallel for schedule(static) if (mpm_parallel(mpm))
	for (int k = 0; k < c->n_places; k++)
		exchange_at(mpm, c, &c->places[k], dt);
}
