/* Heat between the fields of a node.
 *
 * The conductance of a contact grows with its pressure, hc = h0 (p/p0)^e (DP-MPM eq. 11); over the surface that belongs
 * to the node it is hc A, and A = f/p.  A node may hold so little of a body that a step of this flow would take its
 * temperature beyond the other's: it goes as far as both are equal, which is what a perfect conductor would do.
 *
 * Bonded fields are one body: their temperatures change at one rate, that of their sum. */
#include <math.h>

#include "contact/private.h"

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
	double Ta, Tb, Ca = unit_capacity(mpm, c, place, pair->a, &Ta), Cb = unit_capacity(mpm, c, place, pair->b, &Tb);
	if (!(s->conductance > 0.0) || !(pair->push > 0.0) || !(Ca > 0.0) || !(Cb > 0.0))
		return;
	double relative = pair->push / (mpm->dt * pair->area * s->conductance_pressure);
	double conductance = s->conductance * pair->area *
						 (s->conductance_exponent == 1.0 ? relative : pow(relative, s->conductance_exponent));
	double flow = fmin(conductance, Ca * Cb / ((Ca + Cb) * dt)) * (Tb - Ta);
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
