/* `tmdempm check`: what a run of this scene would be, without writing anything of it. */
#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <string.h>

#include "base/error.h"
#include "base/mat2.h"
#include "mpm/shape.h"
#include "run/run_private.h"
#include "rve/rve.h"

static const double CHECK_SECONDS = 1.5; /* of measured steps */

static void check_passes(const struct mpm *mpm)
{
	const struct scene *scene = mpm->scene;
	printf("passes     %s shape functions, order %s, transfer %s", mpm->shape->name, mpm_order_names[scene->mpm.order],
		   mpm_transfer_names[scene->mpm.transfer]);
	if (scene->mpm.transfer == MPM_XPIC || scene->mpm.transfer == MPM_FMPM)
		printf("(%d) in one step of %d", scene->mpm.xpic_order, scene->mpm.xpic_every);
	if (scene->mpm.pic_fraction > 0)
		printf(" with %g PIC a step", scene->mpm.pic_fraction);
	printf("\n           %s\n", mpm->thermal ? "heat: thermal pass on the same grid" : "no heat: no thermal pass");
	if (mpm->thermal && scene->time.thermal_steps > 1)
		printf("           %d thermal sub-steps in each step\n", scene->time.thermal_steps);
	if (mpm->thermal && scene->time.thermal_every > 1)
		printf("           one thermal step every %d steps\n", scene->time.thermal_every);
	if (mpm->thermal && scene->thermal.time_scale != 1.0)
		printf("           TIME SCALE: heat conduction, fluxes and convection run %g times faster than the mechanics\n",
			   scene->thermal.time_scale);
	for (int l = 0; l < mpm->n_laws; l++)
		printf("           law %s (%s): %d points, %.1f kB of state each\n", mpm->laws[l]->name,
			   mpm->laws[l]->type->name, mpm->laws[l]->n_points, 1e-3 * (double)mpm->laws[l]->state_bytes);
	if (scene->n_walls + scene->n_boundaries + scene->n_stages > 0)
		printf("           %d walls, %d boundary values, %d stages\n", scene->n_walls, scene->n_boundaries,
			   scene->n_stages);
}

static long check_rves(const struct mpm *mpm, int *discs)
{
	long n = 0;
	*discs = 0;
	for (int l = 0; l < mpm->n_laws; l++) {
		const struct law *law = mpm->laws[l];
		const struct rve_model *model;
		const void *state;
		if (!law->type->rve_view || law->n_points == 0 || law->type->rve_view(law, 0, &model, &state) != STATUS_OK)
			continue;
		n += law->n_points;
		*discs = rve_discs(model);
	}
	return n;
}

/* What bonds make of the discs, Pa: F / (2 R z) = beta kn / (2 z), whatever the radii. */
static void check_bonds(const struct scene *scene)
{
	for (int k = 0; k < scene->n_laws; k++) {
		const struct scene_law_rve *rve = &scene->laws[k].rve;
		const struct scene_bonds *bonds = &rve->bonds;
		if (scene->laws[k].type != SCENE_LAW_RVE || !(bonds->strength > 0.0))
			continue;
		printf("bonds      law %s: a bond bears what %.4g kPa are on its discs", scene->laws[k].name,
			   1e-3 * bonds->strength * rve->kn / (2.0 * rve->disc_thickness));
		if (isfinite(bonds->melting))
			printf(", %s %.6g %s", bonds->linear ? "softening up to" : "up to",
				   scene_temperature_out(scene, bonds->melting), scene_temperature_unit(scene));
		printf("\n");
	}
}

static void check_sizes(const struct mpm *mpm)
{
	int discs;
	long rves = check_rves(mpm, &discs);
	printf("points     %d\nnodes      %d x %d = %d, cells of %g m\n", mpm->p.n, mpm->grid.nx, mpm->grid.ny,
		   mpm->grid.nx * mpm->grid.ny, mpm->grid.h);
	if (rves)
		printf("RVEs       %ld of %d discs each\n", rves, discs);
	else
		printf("RVEs       none\n");
	check_bonds(mpm->scene);
	printf("memory     %.1f MB\n", 1e-6 * (double)mpm_memory(mpm));
}

/* The limits of eq. 30 and of explicit heat conduction and convection, over all points as they stand. */
static void check_step(const struct mpm *mpm)
{
	const struct scene *scene = mpm->scene;
	const struct particles *p = &mpm->p;
	double mechanical = INFINITY, h = fmin(mpm->grid.spacing[0], mpm->grid.spacing[1]);
	int stiff = 0;
	for (int i = 0; i < p->n; i++) {
		double density = p->mass[i] / (p->volume0[i] * mat2_determinant(p->F[i]));
		double limit = scene->time.step_factor * h * sqrt(density / p->modulus[i]);
		if (limit < mechanical)
			mechanical = limit, stiff = i;
	}
	double thermal_step =
		scene->time.step * scene->thermal.time_scale * scene->time.thermal_every / scene->time.thermal_steps;
	printf("step       %g s, %.1f %% of the mechanical limit %.3g s\n", scene->time.step,
		   100 * scene->time.step / mechanical, mechanical);
	printf("           set by point %d: P-wave modulus %.3g Pa, %g h sqrt(rho/M)\n", p->id[stiff], p->modulus[stiff],
		   scene->time.step_factor);
	if (isfinite(mpm->lattice_limit))
		printf("           %.1f %% of the limit of the points as they lie in their grid cells, %.3g s\n",
			   100 * scene->time.step / mpm->lattice_limit, mpm->lattice_limit);
	if (mpm->thermal && isfinite(mpm->thermal_limit))
		printf("           thermal step %.3g s, %.1f %% of its limit (rho c h^2 / 2k, less what convection takes)\n",
			   thermal_step, 100 * scene->time.step / mpm->thermal_limit);
	if (scene->time.step > mechanical || (mpm->thermal && scene->time.step > mpm->thermal_limit))
		printf("           OVER THE LIMIT, which guards.time_step or thermal_step = false lets pass\n");
}

/* Runs the first steps in memory for a moment, then scales. */
static int check_estimate(struct mpm *mpm, long long steps)
{
	double start = clock_seconds(), now = start;
	long long done = 0;
	while (done < steps && now - start < CHECK_SECONDS) {
		int status = mpm_step(mpm);
		if (status != STATUS_OK)
			return error_context(status, "in the first steps");
		done++;
		now = clock_seconds();
	}
	if (done == 0)
		return STATUS_OK;
	double per_step = (now - start) / (double)done, total = per_step * (double)steps;
	printf("time       %lld steps at %.3g ms: about %.3g s (%.1f min) with %d threads, as the first %lld steps went\n",
		   steps, 1e3 * per_step, total, total / 60, omp_get_max_threads(), done);
	int discs;
	if (check_rves(mpm, &discs))
		printf("           RVEs that are sheared need more sub-steps, flying ones none: expect half to a few times "
			   "that\n");
	return STATUS_OK;
}

/* Where RVEs are computed, and how many begin where. */
static void check_devices(const struct mpm *mpm, const char *devices)
{
	if (!devices[0])
		return;
	printf("devices    %s\n", devices);
	for (int l = 0; l < mpm->n_laws; l++) {
		char shares[1024];
		if (!mpm->laws[l]->type->shares)
			continue;
		mpm->laws[l]->type->shares(mpm->laws[l], shares, sizeof shares);
		printf("           RVEs of %s: %s\n", mpm->laws[l]->name, shares);
	}
}

int run_check(const char *scene_path, int n_sets, const char *const *sets, int threads, const char *device)
{
	char devices[1024] = "";
	struct scene *scene;
	struct mpm *mpm = NULL;
	if (threads > 0)
		omp_set_num_threads(threads);
	CHECK(scene_load(&scene, scene_path, n_sets, sets, stderr));
	int status = images_check(scene, stderr);
	run_choose_paths(scene, device);
	if (status == STATUS_OK)
		status = mpm_create(&mpm, scene);
	if (status == STATUS_OK)
		status = run_use_devices(mpm, device, devices, sizeof devices);
	if (status == STATUS_OK) {
		printf("scene      %s%s%s\n", scene_path, scene->title[0] ? ": " : "", scene->title);
		check_passes(mpm);
		check_sizes(mpm);
		check_step(mpm);
		check_devices(mpm, devices);
		fflush(stdout);
		status = check_estimate(mpm, (long long)ceil(scene->time.end / scene->time.step - 1e-6));
	}
	if (status == STATUS_OK)
		printf("output     history every %g s, snapshots every %g s, checkpoints every %g s, %d probes, %d inspected "
			   "RVEs, %d images\n",
			   scene->output.history_every, scene->output.snapshot_every, scene->output.checkpoint_every,
			   scene->n_probes, scene->n_inspect, scene->n_images);
	if (status == STATUS_OK && scene->n_images > 0 && !viewer_program())
		printf("           no viewer is installed: no pictures (see tmdempm info)\n");
	mpm_free(mpm);
	scene_free(scene);
	return status;
}
