/* The energy ledger.
 *
 * With F_I the force on a node and vbar_I the mean of its velocities before and after, the grid's kinetic
 * energy changes by dt sum F_I.vbar_I, exactly.  From there (S: from nodes to points, dv_I: change of a
 * node, d: what PIC, damping, XPIC, FMPM or APIC do to a point beyond FLIP, v_flip = v + S dv):
 *  - FLIP keeps less than the grid has: 1/2 (sum m_I |dv_I|^2 - sum m_p |S dv|^2) is lost;
 *  - d takes - sum m_p (v_flip.d + |d|^2/2);
 *  - APIC's grid moves with the affine motion of the points too, whose energy is not the points': of what the
 *    forces do on the grid, sum m_I v_I.dv_I - sum m_p v.S dv is done on that;
 *  - the points move with S v + (S dv + d)/2 (eq. 27), so gravity's potential changes by what gravity did on
 *    the grid, but for dt/2 g. sum m_p d; APIC's move with v + S dv + d, which makes it dt/2 g. sum m_p (S dv + 2 d).
 * All are summed directly and make up loss_numerical, with the impacts on walls and one thing more:
 *  - the law receives dt/2 (Q0 + Q1), with Q0 and Q1 the power of the stress before and after its update on the L
 *    in which the points strain (the trapezoid), and the grid gave dt/2 (P0 + P1), with P0 and P1 the power of the
 *    internal forces on the nodes' velocities before and after the step.  dt/2 (P0 + P1 - Q0 - Q1) is lost.  USL
 *    strains with the velocities after the step: Q0 = P1, and neither is summed.  USL and MUSL update the stress last:
 *    Q1 is summed on the next way to the grid.  (With MUSL and USF what is lost holds the remapping, and what walls
 *    hold back of the velocities in which points strain.)
 * What the internal force does on the grid and what the laws say they received is not reconciled: apart from
 * that known difference it is an error of the method and shows in the residual. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/mat2.h"
#include "mpm/point.h"

const struct field mpm_ledger_fields[] = {
	{"energy_kinetic", "J", 1, "of the points"},
	{"energy_elastic", "J", 1, "stored by the laws, counted from zero force"},
	{"energy_rve_kinetic", "J", 1, "of the discs' fluctuations"},
	{"energy_gravity", "J", 1, "- m g.x, counted from the origin of coordinates"},
	{"energy_thermal", "J", 1, "heat content with the latent heat, counted from the start"},
	{"work_boundary", "J", 1,
	 "done by moving walls, imposed velocities, confining pressure, tractions and the body force of motions"},
	{"work_walls_friction", "J", 1, "turned into heat at walls"},
	{"heat_rve_friction", "J", 1, "turned into heat in RVEs"},
	{"loss_dashpot", "J", 1, "of the dashpots in RVEs"},
	{"loss_bond", "J", 1, "of broken bonds"},
	{"loss_fracture", "J", 1, "taken by cracks, as heat or surface"},
	{"work_contact_friction", "J", 1, "turned into heat where bodies touch"},
	{"loss_contact", "J", 1, "of bodies that meet"},
	{"loss_numerical", "J", 1, "transfers between points and nodes, damping, remapping, impacts on walls"},
	{"work_expansion", "J", 1, "done by thermal expansion"},
	{"energy_discarded", "J", 1, "dropped with gas, re-seeded RVEs and points that left"},
	{"heat_in", "J", 1, "into the material, through boundaries and walls"},
	{"heat_out", "J", 1, "out of it, through boundaries and walls"},
	{"energy_residual", "J", 1, "mechanical energy that does not add up"},
	{"heat_residual", "J", 1, "heat that does not add up"},
};
const int mpm_ledger_fields_count = sizeof mpm_ledger_fields / sizeof *mpm_ledger_fields;
_Static_assert(sizeof mpm_ledger_fields / sizeof *mpm_ledger_fields == sizeof(struct mpm_ledger) / sizeof(double),
			   "one field for each double of the ledger, in the same order");

/* ---- sums of every step ---- */

static void add_nodes(struct mpm *mpm, struct mpm_work *w, double *boundary)
{
	struct mpm_sums *t = &w->total;
	double increment = 0.0, power = 0.0, carried = 0.0;
	for (int j = 0; j < w->n_rows; j++) {
		const struct row_sum *row = &w->row_sums[j];
		increment += row->increment;
		carried += row->carried;
		power += row->power;
		t->work_gravity += row->gravity;
		*boundary += row->confining + row->motion + row->velocity_work;
		t->loss_numerical += row->velocity_loss;
	}
	for (int s = 0; s < w->n_stripes; s++)
		power -= w->stripe_sums[s].power;
	for (int b = 0; b < w->n_blocks && w->strain_power; b++)
		power -= w->strain_power[b];
	t->loss_numerical += 0.5 * increment + carried + 0.5 * mpm->dt * power;
}

static void add_points(struct mpm *mpm, struct mpm_work *w)
{
	struct mpm_sums *t = &w->total;
	const double *g = mpm->scene->gravity;
	double increment = 0.0, damped = 0.0, carried = 0.0, push[2] = {0.0, 0.0};
	for (int b = 0; b < w->n_blocks; b++) {
		const struct block_sum *block = &w->block_sums[b];
		increment += block->increment;
		damped += block->damped;
		carried += block->carried;
		push[0] += block->push[0], push[1] += block->push[1];
		t->discarded += block->discarded;
	}
	t->loss_numerical += -0.5 * increment - damped - carried + 0.5 * mpm->dt * (g[0] * push[0] + g[1] * push[1]);
}

/* Adds what a contact's wall carries of the confining pressure at a node: on the surface that turns to the wall. */
static void add_confining_at(struct mpm *mpm, const struct mpm_work *w, int e, int node)
{
	const double *n = w->wall_effects[e].normal, *outward = w->confining[node];
	double area = -(outward[0] * n[0] + outward[1] * n[1]),
		   force = mpm->scene->mpm.confining_pressure * fmax(area, 0.0);
	mpm->walls[w->wall_nodes[e].wall].force[0] -= force * n[0];
	mpm->walls[w->wall_nodes[e].wall].force[1] -= force * n[1];
}

/* The nodes feel sigma + p_c I, so that every surface carries p_c; where a wall does, it is given back to its force.
 * A surface that ends between two rows of nodes is held by both: those in contact and, once, those beside them. */
static void add_confining_reaction(struct mpm *mpm, struct mpm_work *w, int wall)
{
	const int nx = mpm->grid.nx, ny = mpm->grid.ny;
	memset(w->seen, 0, (size_t)nx * (size_t)ny * sizeof *w->seen);
	for (int e = 0; e < w->n_wall_nodes; e++)
		if (w->wall_nodes[e].wall == wall)
			w->seen[w->wall_nodes[e].node] = true;
	for (int e = 0; e < w->n_wall_nodes; e++) {
		if (w->wall_nodes[e].wall != wall || w->wall_effects[e].push == 0.0)
			continue;
		int node = w->wall_nodes[e].node, i = node % nx, j = node / nx;
		add_confining_at(mpm, w, e, node);
		for (int b = j > 0 ? j - 1 : 0; b <= j + 1 && b < ny; b++)
			for (int a = i > 0 ? i - 1 : 0; a <= i + 1 && a < nx; a++) {
				int beside = b * nx + a;
				if (!w->seen[beside] && mpm->grid.mass[beside] > 0.0)
					add_confining_at(mpm, w, e, beside);
				w->seen[beside] = true;
			}
	}
}

static void add_walls(struct mpm *mpm, struct mpm_work *w, double *boundary)
{
	struct mpm_sums *t = &w->total;
	for (int wall = 0; wall < mpm->scene->n_walls; wall++)
		for (int c = 0; c < 2; c++)
			mpm->walls[wall].force[c] = w->penalty ? penalty_on_wall(mpm, wall)[c] : 0.0;
	for (int e = 0; e < w->n_wall_nodes; e++) {
		const struct wall_effect *effect = &w->wall_effects[e];
		const struct wall_node *contact = &w->wall_nodes[e];
		struct mpm_wall_sums *wall = &mpm->walls[contact->wall];
		wall->force[0] -= effect->impulse[0] / mpm->dt;
		wall->force[1] -= effect->impulse[1] / mpm->dt;
		wall->friction_heat += effect->friction;
		*boundary += effect->boundary;
		t->work_walls_friction += effect->friction;
		t->loss_numerical += effect->impact;
		bool repeated = e > 0 && contact[-1].node == contact->node && contact[-1].wall == contact->wall;
		if (w->thermal_dt > 0.0 && !repeated && w->fixed_T_wall[contact->node] == contact->wall &&
			w->sums[contact->node].capacity > 0.0 && mpm->grid.mass[contact->node] > 0.0)
			wall->heat += w->fixed_heat[contact->node];
	}
	for (int wall = 0; w->confining && wall < mpm->scene->n_walls; wall++)
		add_confining_reaction(mpm, w, wall);
}

static void add_heat(struct mpm_work *w)
{
	struct mpm_sums *t = &w->total;
	for (int j = 0; j < w->n_rows; j++) {
		t->heat_in += w->heat_sums[j].in;
		t->heat_out += w->heat_sums[j].out;
		t->heat_walls += w->heat_sums[j].walls;
	}
	for (int s = 0; s < w->n_stripes; s++) {
		t->heat_given += w->stripe_sums[s].heat_given;
		t->heat_in += w->stripe_sums[s].heat_in;
		t->heat_out += w->stripe_sums[s].heat_out;
	}
}

/* The work done so far: what was there at the start, what gravity did, what boundaries put in or took.  The
 * largest value over the steps (and the work of thermal expansion) is what the residual is compared with. */
static double work_scale(const struct mpm_sums *t)
{
	return t->start_kinetic + t->start_elastic + t->start_rve_kinetic + fabs(t->work_gravity) +
		   t->work_boundary_turnover;
}

double ledger_loss(const struct mpm *mpm)
{
	const struct mpm_work *w = mpm_work(mpm);
	double power = 0.0;
	for (int s = 0; s < w->n_stripes && mpm->scene->mpm.order != MPM_USF; s++)
		power += w->stripe_sums[s].power;
	return w->total.loss_numerical - 0.5 * mpm->dt * power;
}

void ledger_add_step(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	double boundary = 0.0;
	add_nodes(mpm, w, &boundary);
	add_points(mpm, w);
	add_walls(mpm, w, &boundary);
	if (w->contact)
		contact_add_to_ledger(mpm);
	if (w->thermal_dt > 0.0)
		add_heat(w);
	w->total.work_boundary += boundary;
	w->total.work_boundary_turnover += fabs(boundary);
	w->total.scale = fmax(w->total.scale, work_scale(&w->total));
}

/* ---- the state as it is ---- */

/* J, dt/2 Q1 of the last step as long as no way to the grid has summed it. */
static double power_to_come(const struct mpm *mpm)
{
	const struct particles *p = &mpm->p;
	double power = 0.0;
	if (mpm->scene->mpm.order == MPM_USF)
		return 0.0;
	for (int k = 0; k < p->n; k++)
		power += stress_power(p->stress[k], p->L[k], mat2_determinant(p->F[k]) * p->volume0[k]);
	return 0.5 * mpm->dt * power;
}

/* What is stored now and what the laws have counted since their last reset. */
static void measure_points(const struct mpm *mpm, struct mpm_ledger *l)
{
	const struct particles *p = &mpm->p;
	const double *g = mpm->scene->gravity;
	for (int k = 0; k < p->n; k++) {
		struct law_ledger law;
		const struct law *owner = mpm->laws[p->law[k]];
		owner->type->ledger(owner, p->slot[k], &law);
		double m = p->mass[k], volume = p->volume0[k];
		l->energy_kinetic += 0.5 * m * (p->v[k][0] * p->v[k][0] + p->v[k][1] * p->v[k][1]);
		l->energy_gravity -= m * (g[0] * p->x[k][0] + g[1] * p->x[k][1]);
		l->energy_thermal += mpm->thermal ? freezing_heat(mpm, k) : 0.0;
		l->energy_elastic += volume * law.elastic;
		l->energy_rve_kinetic += volume * law.kinetic;
		l->heat_rve_friction += volume * law.friction;
		l->loss_dashpot += volume * law.dashpot;
		l->loss_bond += volume * law.bond;
		l->loss_fracture += volume * law.fracture;
		l->work_expansion += volume * law.expansion;
		l->energy_discarded += volume * law.discarded;
	}
}

/* In n steps from rest a first-order step does 1/n of the work wrong: the bound counts only when n is large enough. */
static void judge_residual(struct mpm *mpm, struct mpm_work *w)
{
	double bound = mpm->scene->guards.energy_residual, residual = fabs(mpm->ledger.energy_residual);
	double steps = (double)mpm->step - w->total.start_step, scale = w->total.scale + fabs(mpm->ledger.work_expansion);
	if (!(bound > 0.0) || steps * bound < 2.0 || residual <= bound * scale)
		return;
	snprintf(w->residual_message, sizeof w->residual_message,
			 "the energy ledger does not add up: residual %.3g J, %.3g%% of the work done (%.3g J), allowed %.3g%%",
			 mpm->ledger.energy_residual, 100.0 * residual / scale, scale, 100.0 * bound);
}

void mpm_measure(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	struct mpm_sums *t = &w->total;
	struct mpm_ledger l = {0};
	measure_points(mpm, &l);
	l.work_boundary = t->work_boundary;
	l.work_walls_friction = t->work_walls_friction;
	l.work_contact_friction = t->work_contact_friction;
	l.loss_contact = t->loss_contact;
	l.loss_numerical = t->loss_numerical - power_to_come(mpm);
	l.energy_discarded += t->discarded;
	l.heat_in = t->heat_in, l.heat_out = t->heat_out;
	double now = l.energy_kinetic + l.energy_elastic + l.energy_rve_kinetic + l.energy_gravity;
	double start = t->start_kinetic + t->start_elastic + t->start_rve_kinetic + t->start_gravity;
	l.energy_residual = now - start - l.work_boundary - l.work_expansion + l.work_walls_friction + l.heat_rve_friction +
						l.loss_dashpot + l.loss_bond + l.loss_fracture + l.work_contact_friction + l.loss_contact +
						l.loss_numerical + l.energy_discarded;
	l.energy_thermal -= t->start_thermal;
	l.heat_residual = l.energy_thermal - l.heat_in + l.heat_out - t->heat_given - t->heat_walls - t->heat_contacts;
	mpm->ledger = l;
	judge_residual(mpm, w);
}

void ledger_start(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	struct particles *p = &mpm->p;
	for (int k = 0; k < p->n; k++) {
		mpm->laws[p->law[k]]->type->reset_ledger(mpm->laws[p->law[k]], p->slot[k]);
		p->heat_friction_sum[k] = 0.0;
	}
	for (int wall = 0; wall < mpm->scene->n_walls; wall++)
		mpm->walls[wall].friction_heat = mpm->walls[wall].heat = 0.0;
	struct mpm_ledger l = {0};
	measure_points(mpm, &l);
	w->total = (struct mpm_sums){.start_kinetic = l.energy_kinetic,
								 .start_elastic = l.energy_elastic,
								 .start_rve_kinetic = l.energy_rve_kinetic,
								 .start_gravity = l.energy_gravity,
								 .start_thermal = l.energy_thermal,
								 .loss_numerical = power_to_come(mpm),
								 .start_step = (double)mpm->step,
								 .limit_watched = w->total.limit_watched};
	w->total.scale = work_scale(&w->total);
}

void mpm_region(const struct mpm *mpm, const struct scene_region *region, struct mpm_region_values *values)
{
	const struct particles *p = &mpm->p;
	double mass = 0.0, volume = 0.0, capacity = 0.0, heat = 0.0;
	for (int k = 0; k < p->n; k++) {
		const double *x = p->x[k];
		if (x[0] < region->min[0] || x[1] < region->min[1] || x[0] >= region->max[0] || x[1] >= region->max[1])
			continue;
		double c = mpm->thermal ? p->mass[k] * p->capacity[k] : p->mass[k];
		mass += p->mass[k];
		volume += mat2_determinant(p->F[k]) * p->volume0[k];
		capacity += c;
		heat += c * p->T[k];
	}
	values->mass = mass;
	values->volume = volume;
	values->temperature = capacity > 0.0 ? heat / capacity : NAN;
}
