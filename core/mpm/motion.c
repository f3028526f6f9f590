/* Body forces: of bodies that are born with an exact motion (exact/exact.h), which keeps them on it, and of tractions,
 * which are spread over the points that begin in a layer (eq. 10), and of penalty walls (contact/penalty.c). */
#include <math.h>
#include <string.h>

#include "base/error.h"
#include "mpm/mpm_private.h"

int motion_begin(struct mpm *mpm, int p, const double X[2])
{
	struct particles *points = &mpm->p;
	const struct scene_body *body = &mpm->scene->bodies[points->body[p]];
	const struct scene_motion *motion = &body->motion;
	struct exact_motion start;
	if (!motion->solution->motion(motion->parameters, X, 0.0, &start))
		return error_set(STATUS_INPUT, "%s: body '%s' has a point at (%g, %g), where motion '%s' is not defined",
						 mpm->scene->path, body->name, X[0], X[1], motion->solution->name);
	if (motion->force && !mpm->laws[points->law[p]]->type->piola_derivative)
		return error_set(STATUS_INPUT, "%s: body '%s': no body force is known for motion '%s' and a law of type '%s'",
						 mpm->scene->path, body->name, motion->solution->name, mpm->laws[points->law[p]]->type->name);
	for (int c = 0; c < 2; c++) {
		points->x[p][c] = X[c] + start.u[c];
		points->v[p][c] = start.v[c];
	}
	memcpy(points->F[p], start.F, sizeof start.F);
	return STATUS_OK;
}

/* b = a - Div P / rho0, m/s2; the divergence by the chain rule, sum_J dP/dF : dF/dX_J. */
static void body_force(const struct mpm *mpm, int p, double b[2])
{
	const struct particles *points = &mpm->p;
	const struct scene_motion *motion = &mpm->scene->bodies[points->body[p]].motion;
	const struct law *law = mpm->laws[points->law[p]];
	struct exact_motion m;
	double along_x[4], along_y[4], volume = points->volume0[p] / points->mass[p];
	motion->solution->motion(motion->parameters, points->x0[p], mpm->time, &m);
	law->type->piola_derivative(law, m.F, m.dF[0], along_x);
	law->type->piola_derivative(law, m.F, m.dF[1], along_y);
	b[0] = m.a[0] - volume * (along_x[0] + along_y[1]);
	b[1] = m.a[1] - volume * (along_x[2] + along_y[3]);
}

bool loads_points(const struct mpm *mpm)
{
	bool loads = false;
	for (int b = 0; b < mpm->scene->n_boundaries; b++)
		loads = loads || scene_boundary_loads_points(&mpm->scene->boundaries[b]);
	return loads;
}

/* What tractions add to the body force of a point, m/s2. */
static void add_tractions(const struct mpm *mpm, int p, double b[2])
{
	const double *x = mpm->p.x0[p], volume = mpm->p.volume0[p] / mpm->p.mass[p];
	for (int k = 0; k < mpm->scene->n_boundaries; k++) {
		const struct scene_boundary *s = &mpm->scene->boundaries[k];
		if (!mpm_work(mpm)->boundary_on[k] || x[0] < s->min[0] || x[0] > s->max[0] || x[1] < s->min[1] ||
			x[1] > s->max[1])
			continue;
		for (int c = 0; c < 2; c++)
			b[c] += isnan(s->traction[c]) ? 0.0 : volume * s->traction[c] / s->layer;
	}
}

static void push_stripe(struct mpm *mpm, struct mpm_work *w, int stripe)
{
	struct shape_lists lists;
	const struct particles *points = &mpm->p;
	int first, last;
	mpm_stripe_points(w, stripe, &first, &last);
	for (int i = first; i < last; i += SHAPE_CHUNK) {
		const int *chunk = w->order + i, n = last - i < SHAPE_CHUNK ? last - i : SHAPE_CHUNK;
		mpm_lists(mpm, n, chunk, &lists);
		for (int k = 0; k < n; k++) {
			const struct scene_motion *motion = &mpm->scene->bodies[points->body[chunk[k]]].motion;
			double b[2] = {0.0, 0.0};
			if (motion->solution && motion->force)
				body_force(mpm, chunk[k], b);
			add_tractions(mpm, chunk[k], b);
			for (int c = 0; c < 2 && w->penalty; c++)
				b[c] += penalty_force(mpm, chunk[k])[c] / points->mass[chunk[k]];
			if (b[0] == 0.0 && b[1] == 0.0)
				continue;
			for (int a = 0; a < lists.nodes; a++) {
				double mass = lists.weight[a][k] * points->mass[chunk[k]];
				w->body_force[lists.node[a][k]][0] += mass * b[0];
				w->body_force[lists.node[a][k]][1] += mass * b[1];
			}
		}
	}
}

void motion_forces(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	if (w->penalty)
		penalty_push(mpm);
	memset(w->body_force, 0, w->n_nodes * sizeof *w->body_force);
	mpm_each_stripe(mpm, push_stripe);
}
