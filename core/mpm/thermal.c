/* The thermal pass: heat from the points to the nodes, conduction, sources and imposed temperatures there.
 *
 * The sum of all flows is that of the sources (gradients add up to zero), so heat is conserved to round-off.
 *
 * Where a node's temperature is imposed, its points are drawn towards it by the difference from what they
 * carry.  That is read off by T_p + grad T.(x_I - x_p), not by the plain mean: the points of a boundary node
 * all lie on one side of it, and their mean would be wrong by the slope times the distance to their centre. */
#include <math.h>

#include "mpm/mpm_private.h"

/* Remapped temperature; imposed values replace it before heat flows. */
static void begin_row(struct mpm *mpm, struct mpm_work *w, int j)
{
	struct grid *grid = &mpm->grid;
	for (int i = w->row_low[j]; i <= w->row_high[j]; i++) {
		size_t node = (size_t)j * (size_t)grid->nx + (size_t)i;
		double capacity = w->sums[node].capacity, T = capacity > 0.0 ? w->sums[node].heat / capacity : 0.0;
		grid->heat_capacity[node] = capacity;
		grid->T[node] = grid->T_new[node] = T;
		w->fixed_heat[node] = w->fixed_lift[node] = 0.0;
		if (capacity > 0.0 && !isnan(w->fixed_T[node]))
			grid->T_new[node] = w->fixed_T[node];
	}
}

/* Sources that belong to nodes: friction heat of walls. */
static void source_row(struct mpm *mpm, struct mpm_work *w, int j)
{
	for (int i = w->row_low[j]; i <= w->row_high[j]; i++) {
		size_t node = (size_t)j * (size_t)mpm->grid.nx + (size_t)i;
		w->sums[node].flow = w->wall_heat && w->sums[node].capacity > 0.0 ? w->wall_heat[node] / w->thermal_dt : 0.0;
	}
}

static void advance_row(struct mpm *mpm, struct mpm_work *w, int j, double dt)
{
	for (int i = w->row_low[j]; i <= w->row_high[j]; i++) {
		size_t node = (size_t)j * (size_t)mpm->grid.nx + (size_t)i;
		double capacity = w->sums[node].capacity, heat = dt * w->sums[node].flow;
		if (!(capacity > 0.0))
			continue;
		if (isnan(w->fixed_T[node]))
			mpm->grid.T_new[node] += heat / capacity;
		else
			w->fixed_heat[node] -= heat; /* what must come from outside to keep the temperature */
	}
}

static struct heat_sum end_row(struct mpm *mpm, struct mpm_work *w, int j)
{
	struct heat_sum sum = {0};
	for (int i = w->row_low[j]; i <= w->row_high[j]; i++) {
		size_t node = (size_t)j * (size_t)mpm->grid.nx + (size_t)i;
		double capacity = w->sums[node].capacity;
		if (capacity > 0.0 && !isnan(w->fixed_T[node])) {
			mpm->grid.T[node] += w->fixed_lift[node] / capacity;
			w->fixed_heat[node] += capacity * (w->fixed_T[node] - mpm->grid.T[node]);
		}
		double heat = w->fixed_heat[node];
		sum.in += heat > 0.0 ? heat : 0.0;
		sum.out -= heat < 0.0 ? heat : 0.0;
		if (w->wall_heat && w->sums[node].capacity > 0.0) {
			sum.walls += w->wall_heat[node];
			w->wall_heat[node] = 0.0;
		}
	}
	return sum;
}

static bool reaches(const struct point_heat *heat, const double x[2])
{
	const struct scene_boundary *b = heat->boundary;
	return heat->on && x[0] >= b->min[0] && x[0] <= b->max[0] && x[1] >= b->min[1] && x[1] <= b->max[1];
}

/* The virtual layer of eq. 10. */
double thermal_boundary(const struct mpm_work *w, const double x[2], double T)
{
	double sum = 0.0;
	for (int f = 0; f < w->n_point_heats; f++) {
		const struct point_heat *heat = &w->point_heats[f];
		if (reaches(heat, x))
			sum += (heat->flux + heat->coefficient * (heat->ambient - T)) / heat->boundary->layer;
	}
	return sum;
}

double mpm_convection_as_conduction(const struct mpm *mpm, int p, double volume)
{
	const struct mpm_work *w = mpm_work(mpm);
	double sum = 0.0, h = fmin(mpm->grid.spacing[0], mpm->grid.spacing[1]);
	for (int f = 0; f < w->n_point_heats; f++)
		if (reaches(&w->point_heats[f], mpm->p.x[p]))
			sum += w->point_heats[f].coefficient / w->point_heats[f].boundary->layer;
	return 0.25 * h * h * sum * volume;
}

void thermal_lift(const struct mpm *mpm, struct mpm_work *w, const struct shape_lists *lists, int k, int p, double gx,
				  double gy)
{
	const struct grid *grid = &mpm->grid;
	double capacity = mpm->p.mass[p] * mpm->p.capacity[p];
	for (int a = 0; a < lists->nodes; a++) {
		int node = lists->node[a][k];
		if (isnan(w->fixed_T[node]))
			continue;
		int home = mpm_home(mpm, node);
		double x = grid->origin[0] + home % grid->nx * grid->spacing[0],
			   y = grid->origin[1] + home / grid->nx * grid->spacing[1];
		w->fixed_lift[node] += capacity * lists->weight[a][k] * (gx * (x - mpm->p.x[p][0]) + gy * (y - mpm->p.x[p][1]));
	}
}

static void scatter_flows(struct mpm *mpm, struct mpm_work *w, double dt, bool first_pass, bool last_pass)
{
	for (int parity = 0; parity < 2; parity++) {
#pragma omp parallel for schedule(dynamic) if (mpm_parallel(mpm))
		for (int stripe = parity; stripe < w->n_stripes; stripe += 2)
			w->kernel->flow_stripe(mpm, w, stripe, dt, first_pass, last_pass);
	}
}

void mpm_heat_nodes(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	int passes = mpm->scene->time.thermal_steps, rows = w->n_rows;
	double dt = w->thermal_dt / passes;
#pragma omp parallel for schedule(static) if (mpm_parallel(mpm))
	for (int j = 0; j < rows; j++)
		begin_row(mpm, w, j);
	if (w->contact)
		contact_set_temperatures(mpm);
	for (int pass = 0; pass < passes; pass++) {
#pragma omp parallel for schedule(static) if (mpm_parallel(mpm))
		for (int j = 0; j < rows; j++)
			source_row(mpm, w, j);
		scatter_flows(mpm, w, dt, pass == 0, pass == passes - 1);
		if (w->contact)
			contact_exchange_heat(mpm, dt);
#pragma omp parallel for schedule(static) if (mpm_parallel(mpm))
		for (int j = 0; j < rows; j++)
			advance_row(mpm, w, j, dt);
	}
#pragma omp parallel for schedule(static) if (mpm_parallel(mpm))
	for (int j = 0; j < rows; j++)
		w->heat_sums[j] = end_row(mpm, w, j);
}

/* The gradient that a body begins with, read off at imposed nodes as the steps will do. */
static void lift_at_birth(struct mpm *mpm, struct mpm_work *w)
{
	struct shape_lists lists;
	for (int i = 0; i < w->n_inside; i++) {
		int p = w->order[i];
		const double *g = mpm->scene->bodies[mpm->p.body[p]].temperature_gradient;
		mpm_lists(mpm, 1, &p, &lists);
		thermal_lift(mpm, w, &lists, 0, p, g[0], g[1]);
	}
	for (size_t node = 0; node < w->n_nodes; node++)
		if (!isnan(w->fixed_T[node]) && w->sums[node].capacity > 0.0)
			mpm->grid.T[node] += w->fixed_lift[node] / w->sums[node].capacity;
}

/* The smooth temperature at birth: what the law will see change. */
void mpm_remap_temperature(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	struct shape_lists lists;
	for (int j = 0; j < w->n_rows; j++)
		begin_row(mpm, w, j);
	if (w->imposes_T)
		lift_at_birth(mpm, w);
	for (int i = 0; i < w->n_inside; i++) {
		int p = w->order[i];
		mpm_lists(mpm, 1, &p, &lists);
		double T = 0.0;
		for (int a = 0; a < lists.nodes; a++)
			T += lists.weight[a][0] * mpm->grid.T[lists.node[a][0]];
		mpm->p.T_smooth[p] = T;
	}
}
