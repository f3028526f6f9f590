/* Points to grid, the nodes' step, grid to points (TM-DEMPM section 2); what is done for each point: kernel_transfer.h.
 */
#include <math.h>
#include <string.h>

#include "mpm/mpm_private.h"

/* ---- points to grid ---- */

void mpm_clear_grid(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	int nx = mpm->grid.nx, rows = w->n_rows;
#pragma omp parallel for schedule(static) if (mpm_parallel(mpm))
	for (int j = 0; j < rows; j++) {
		int low = w->row_low[j], n = w->row_high[j] - low + 1;
		memset(mpm->grid.mass + (size_t)j * (size_t)nx, 0, (size_t)nx * sizeof *mpm->grid.mass);
		if (n <= 0)
			continue;
		size_t first = (size_t)j * (size_t)nx + (size_t)low;
		memset(w->sums + first, 0, (size_t)n * sizeof *w->sums);
		if (w->confining)
			memset(w->confining + first, 0, (size_t)n * sizeof *w->confining);
	}
}

void mpm_each_stripe(struct mpm *mpm, void (*scatter)(struct mpm *, struct mpm_work *, int))
{
	struct mpm_work *w = mpm_work(mpm);
	for (int parity = 0; parity < 2; parity++) {
#pragma omp parallel for schedule(dynamic) if (mpm_parallel(mpm))
		for (int stripe = parity; stripe < w->n_stripes; stripe += 2)
			scatter(mpm, w, stripe);
	}
}

void mpm_points_to_grid(struct mpm *mpm) { mpm_each_stripe(mpm, mpm_work(mpm)->kernel->scatter_stripe); }

/* ---- nodes ---- */

/* The step of the free nodes; walls come after it. */
static void integrate_row(struct mpm *mpm, struct mpm_work *w, int j)
{
	struct grid *grid = &mpm->grid;
	const double *g = mpm->scene->gravity;
	const double dt = mpm->dt, scale = w->internal_force_scale, confining = mpm->scene->mpm.confining_pressure;
	for (int i = w->row_low[j]; i <= w->row_high[j]; i++) {
		size_t node = (size_t)j * (size_t)grid->nx + (size_t)i;
		const struct node_sum *sum = &w->sums[node];
		grid->mass[node] = sum->mass;
		for (int c = 0; c < 2; c++) {
			if (!(sum->mass > 0.0)) {
				grid->v[node][c] = grid->v_new[node][c] = grid->force[node][c] = 0.0;
				continue;
			}
			double f = scale * sum->force[c] + sum->mass * g[c];
			if (w->confining)
				f -= confining * w->confining[node][c];
			if (w->body_force)
				f += w->body_force[node][c];
			grid->force[node][c] = f;
			grid->v[node][c] = sum->momentum[c] / sum->mass;
			grid->v_new[node][c] = grid->v[node][c] + f / sum->mass * dt;
		}
	}
}

/* Imposed velocities come last and win over everything else. */
static void impose_velocities(struct mpm *mpm, struct mpm_work *w, int j)
{
	for (int i = w->row_low[j]; i <= w->row_high[j]; i++) {
		size_t node = (size_t)j * (size_t)mpm->grid.nx + (size_t)i;
		for (int c = 0; c < 2; c++) {
			double u = w->fixed_v[node][c];
			w->fixed_push[node][c] = 0.0;
			if (isnan(u) || !(mpm->grid.mass[node] > 0.0))
				continue;
			w->fixed_push[node][c] = mpm->grid.mass[node] * (u - mpm->grid.v_new[node][c]);
			mpm->grid.v_new[node][c] = u;
		}
	}
}

void mpm_integrate_nodes(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
#pragma omp parallel for schedule(static) if (mpm_parallel(mpm))
	for (int j = 0; j < w->n_rows; j++)
		integrate_row(mpm, w, j);
	if (w->contact)
		contact_apply(mpm);
	walls_apply(mpm);
	if (!w->fixed_v)
		return;
#pragma omp parallel for schedule(static) if (mpm_parallel(mpm))
	for (int j = 0; j < w->n_rows; j++)
		impose_velocities(mpm, w, j);
}

/* The nodes' share of the ledger, from the velocities as they became: the kinetic energy of the grid
 * changes by the forces' impulses times the mean velocity, exactly. */
static struct row_sum finish_row(const struct mpm *mpm, const struct mpm_work *w, int j)
{
	struct row_sum sum = {0};
	const struct grid *grid = &mpm->grid;
	const double *g = mpm->scene->gravity, confining = mpm->scene->mpm.confining_pressure;
	const bool strain_apart = mpm->scene->mpm.order != MPM_USL, affine = mpm->p.affine != NULL;
	for (int i = w->row_low[j]; i <= w->row_high[j]; i++) {
		size_t node = (size_t)j * (size_t)grid->nx + (size_t)i;
		for (int c = 0; c < 2; c++) {
			double dv = grid->v_new[node][c] - grid->v[node][c], mean = 0.5 * (grid->v_new[node][c] + grid->v[node][c]);
			sum.increment += grid->mass[node] * dv * dv;
			sum.power -= w->sums[node].force[c] * grid->v[node][c];
			if (strain_apart)
				sum.power -= w->sums[node].force[c] * grid->v_new[node][c];
			if (affine)
				sum.carried += grid->mass[node] * grid->v[node][c] * dv;
			sum.gravity += grid->mass[node] * g[c] * mean * mpm->dt;
			if (w->confining && grid->mass[node] > 0.0)
				sum.confining -= confining * w->confining[node][c] * mean * mpm->dt;
			if (w->body_force)
				sum.motion += w->body_force[node][c] * mean * mpm->dt;
			if (w->fixed_v && !isnan(w->fixed_v[node][c])) {
				sum.velocity_work += w->fixed_push[node][c] * w->fixed_v[node][c];
				sum.velocity_loss -= w->fixed_push[node][c] * (mean - w->fixed_v[node][c]);
			}
		}
	}
	return sum;
}

void mpm_finish_nodes(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
#pragma omp parallel for schedule(static) if (mpm_parallel(mpm))
	for (int j = 0; j < w->n_rows; j++)
		w->row_sums[j] = finish_row(mpm, w, j);
	walls_account(mpm);
	if (w->contact)
		contact_account(mpm);
}

/* ---- grid to points ---- */

void point_park(struct particles *p, int k, struct block_sum *sum)
{
	sum->discarded += 0.5 * p->mass[k] * (p->v[k][0] * p->v[k][0] + p->v[k][1] * p->v[k][1]);
	point_stop(p, k);
	memset(p->L[k], 0, sizeof p->L[k]);
	p->dT[k] = 0.0;
}

void mpm_grid_to_points(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
#pragma omp parallel for schedule(static) if (mpm_parallel(mpm))
	for (int block = 0; block < w->n_blocks; block++)
		w->kernel->gather_block(mpm, w, block);
}
