/* Life of the whole, and its one step. */
#include "mpm/mpm.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/error.h"
#include "base/mat2.h"
#include "mpm/mpm_private.h"

static long long now_ns(void)
{
	struct timespec t;
	clock_gettime(CLOCK_MONOTONIC, &t);
	return t.tv_sec * 1000000000LL + t.tv_nsec;
}

/* ---- the laws ---- */

/* The points of law l, as they lie in storage. */
static struct law_batch law_batch_of(struct mpm *mpm, int l)
{
	struct mpm_work *w = mpm_work(mpm);
	struct particles *p = &mpm->p;
	int at = w->law_start[l];
	return (struct law_batch){.n = w->law_start[l + 1] - at,
							  .slot = p->slot + at,
							  .F = (const double(*)[4])(p->F + at),
							  .L = (const double(*)[4])(p->L + at),
							  .T = p->T_smooth + at,
							  .dT = p->dT + at,
							  .dt = mpm->dt,
							  .stress = p->stress + at,
							  .heat = p->heat + at,
							  .conductivity = p->conductivity + at,
							  .modulus = p->modulus + at,
							  .damage = p->damage ? p->damage + at : NULL,
							  .failed = -1};
}

static int advance_laws(struct mpm *mpm)
{
	for (int l = 0; l < mpm->n_laws; l++) {
		struct law_batch batch = law_batch_of(mpm, l);
		int status = mpm->laws[l]->type->advance(mpm->laws[l], &batch);
		if (status != STATUS_OK)
			return guard_law(mpm, status, batch.failed < 0 ? -1 : mpm_work(mpm)->law_start[l] + batch.failed);
	}
	return STATUS_OK;
}

/* The laws' heat waits for the thermal step that will spend it. */
static void collect_heat(struct mpm *mpm)
{
	struct particles *p = &mpm->p;
	for (int l = 0; l < mpm->n_laws && mpm->thermal; l++) {
		const int *start = mpm_work(mpm)->law_start;
		if (mpm->laws[l]->type->friction && !mpm->scene->thermal.friction_heat)
			continue;
#pragma omp parallel for schedule(static) if (mpm_parallel(mpm))
		for (int k = start[l]; k < start[l + 1]; k++)
			p->heat_pending[k] += p->heat[k] * mat2_determinant(p->F[k]) * p->volume0[k] * mpm->dt;
	}
}

static int update_stress(struct mpm *mpm)
{
	long long start = now_ns();
	CHECK(advance_laws(mpm));
	mpm->law_time_ns += now_ns() - start;
	collect_heat(mpm);
	return STATUS_OK;
}

/* ---- one step ---- */

int mpm_step(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	enum mpm_order order = mpm->scene->mpm.order;
	long long start = now_ns(), law_before = mpm->law_time_ns;
	CHECK(guard_residual(mpm));
	stage_begin_step(mpm);
	CHECK(grid_place(mpm));
	walls_update(mpm);
	boundaries_update(mpm);
	mpm_sort(mpm);
	CHECK(guard_inside(mpm));
	if (mpm->step % RESORT_STEPS == 0)
		mpm_resort_storage(mpm);
	CHECK(guard_cohesion(mpm));
	if (w->contact)
		CHECK(contact_find_fields(mpm));

	if (order == MPM_USF) {
		mpm->within_step = true;
		mpm_strain_points(mpm);
		CHECK(update_stress(mpm));
	}
	mpm_clear_grid(mpm);
	mpm_points_to_grid(mpm);
	if (w->contact)
		contact_gather(mpm);
	if (w->limit_nodes && limit_due(mpm))
		limit_look(mpm);
	CHECK(guard_step(mpm, STATUS_GUARD));
	CHECK(guard_energy(mpm));
	mpm->within_step = true;
	if (w->body_force)
		motion_forces(mpm);
	mpm_integrate_nodes(mpm);
	mpm_finish_nodes(mpm);
	if (w->thermal_dt > 0.0)
		mpm_heat_nodes(mpm);
	mpm_filter_nodes(mpm);
	mpm_grid_to_points(mpm);
	if (order == MPM_MUSL)
		mpm_strain_points(mpm);
	if (w->limit_nodes)
		limit_follow(mpm);

	ledger_add_step(mpm);
	if (w->contact)
		contact_fold(mpm);
	walls_move(mpm);
	mpm->step++;
	mpm->time = (double)mpm->step * mpm->dt;
	CHECK(guard_points(mpm));
	if (order != MPM_USF)
		CHECK(update_stress(mpm));
	CHECK(stage_end_step(mpm));
	mpm->within_step = false;
	if (mpm->scene->guards.energy_residual > 0.0 && mpm->step % RESIDUAL_STEPS == 0)
		mpm_measure(mpm);
	mpm->mpm_time_ns += now_ns() - start - (mpm->law_time_ns - law_before);
	return STATUS_OK;
}

/* ---- birth ---- */

/* What XPIC, FMPM, USF and MUSL need beside the rest. */
static int create_projection(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	const struct scene_mpm *s = &mpm->scene->mpm;
	size_t nodes = w->n_nodes, n = (size_t)mpm->p.n;
	bool strain = s->order != MPM_USL, filter = s->transfer == MPM_XPIC || s->transfer == MPM_FMPM;
	if (strain || filter) {
		w->projected = aligned_alloc(64, nodes * sizeof *w->projected);
		if (!w->projected)
			return error_set(STATUS_RESOURCE, "out of memory for %zu nodes", nodes);
		memset(w->projected, 0, nodes * sizeof *w->projected);
	}
	if (strain)
		w->strain_power = calloc(n / BLOCK_POINTS + 1, sizeof *w->strain_power);
	if (s->order == MPM_MUSL)
		w->way = calloc(n, sizeof *w->way);
	return (strain && !w->strain_power) || (s->order == MPM_MUSL && !w->way)
			   ? error_set(STATUS_RESOURCE, "out of memory for %zu points", n)
			   : STATUS_OK;
}

static int create_work(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	const struct grid *grid = &mpm->grid;
	size_t nodes = w->n_nodes, n = (size_t)mpm->p.n, rows = nodes / (size_t)grid->nx;
	w->kernel = mpm_kernel_here();
	w->shape_grid.nx = grid->nx;
	w->cells_x = grid->nx - 1, w->cells_y = grid->ny - 1;
	w->n_stripes = (w->cells_y + STRIPE_ROWS - 1) / STRIPE_ROWS;
	w->internal_force_scale = 1.0;
	w->cell = malloc((n + 1) * sizeof *w->cell);
	w->order = malloc((n + 1) * sizeof *w->order);
	w->permutation = malloc((n + 1) * sizeof *w->permutation);
	w->scratch = malloc((n + 1) * particles_widest());
	w->cell_first = calloc((size_t)w->cells_x * (size_t)w->cells_y + 2, sizeof *w->cell_first);
	w->row_low = calloc(rows, sizeof *w->row_low);
	w->row_high = calloc(rows, sizeof *w->row_high);
	w->sums = aligned_alloc(64, nodes * sizeof *w->sums);
	w->stripe_sums = calloc((size_t)w->n_stripes, sizeof *w->stripe_sums);
	w->block_sums = calloc(n / BLOCK_POINTS + 1, sizeof *w->block_sums);
	w->row_sums = calloc(rows, sizeof *w->row_sums);
	w->heat_sums = calloc(rows, sizeof *w->heat_sums);
	bool complete = w->cell && w->order && w->permutation && w->scratch && w->cell_first && w->row_low && w->row_high &&
					w->sums && w->stripe_sums && w->block_sums && w->row_sums && w->heat_sums;
	if (complete)
		memset(w->sums, 0, nodes * sizeof *w->sums);
	if (mpm->scene->guards.time_step || mpm->scene->guards.thermal_step) {
		w->limit_nodes = calloc(nodes, sizeof *w->limit_nodes);
		w->limit_sums = calloc((size_t)w->n_stripes, sizeof *w->limit_sums);
		w->limit_points = calloc(n + 1, sizeof *w->limit_points);
		complete = complete && w->limit_nodes && w->limit_sums && w->limit_points;
	}
	if (mpm->scene->mpm.confining_pressure != 0.0) {
		w->confining = calloc(nodes, sizeof *w->confining);
		w->seen = calloc(nodes, sizeof *w->seen);
		complete = complete && w->confining && w->seen;
	}
	bool driven = loads_points(mpm) || w->penalty;
	for (int b = 0; b < mpm->scene->n_bodies; b++)
		driven = driven || (mpm->scene->bodies[b].motion.solution && mpm->scene->bodies[b].motion.force);
	if (driven)
		w->body_force = calloc(nodes, sizeof *w->body_force);
	complete = complete && (!driven || w->body_force);
	return complete ? STATUS_OK : error_set(STATUS_RESOURCE, "out of memory for %zu points on %zu nodes", n, nodes);
}

/* A point before it has its place in storage. */
struct birth {
	double x[2];
	int body, material, variant;
	double temperature;
};

static int births_of_body(const struct scene *scene, int b, struct birth **births, int *n)
{
	const struct scene_body *body = &scene->bodies[b];
	double(*x)[2];
	int count;
	CHECK(scene_body_points(scene, body, &x, &count));
	if (count == 0)
		return error_set(STATUS_INPUT,
						 "%s:%d: body '%s' holds no point, expected at least one lattice point strictly inside",
						 body->place.file ? body->place.file : scene->path, body->place.line, body->name);
	struct birth *grown = realloc(*births, (size_t)(*n + count) * sizeof *grown);
	if (!grown) {
		free(x);
		return error_set(STATUS_RESOURCE, "out of memory for the points of body '%s'", body->name);
	}
	*births = grown;
	for (int k = 0; k < count; k++) {
		struct birth *birth = &grown[*n + k];
		int layer = scene_body_layer(body, x[k][1]);
		*birth = (struct birth){.x = {x[k][0], x[k][1]}, .body = b};
		birth->material = layer < 0 ? body->material : body->layers[layer].material;
		birth->temperature =
			(layer < 0 ? body->temperature : body->layers[layer].temperature) + scene_body_warming(body, birth->x);
		birth->variant = body->variants > 1 ? k % body->variants : 0;
	}
	*n += count;
	free(x);
	return STATUS_OK;
}

/* Instances for the laws that have points; law_start says where in storage their points lie. */
static int create_laws(struct mpm *mpm, int n, const struct birth *births)
{
	struct mpm_work *w = mpm_work(mpm);
	const struct scene *scene = mpm->scene;
	mpm->laws = calloc((size_t)scene->n_laws + 1, sizeof *mpm->laws);
	w->law_start = calloc((size_t)scene->n_laws + 2, sizeof *w->law_start);
	w->law_names = calloc((size_t)scene->n_laws + 1, sizeof *w->law_names);
	w->law_of_scene = malloc(((size_t)scene->n_laws + 1) * sizeof *w->law_of_scene);
	int *variant = malloc(((size_t)n + 1) * sizeof *variant);
	int status = mpm->laws && w->law_start && w->law_names && w->law_of_scene && variant
					 ? STATUS_OK
					 : error_set(STATUS_RESOURCE, "out of memory for laws");
	for (int s = 0; s < scene->n_laws && status == STATUS_OK; s++) {
		int count = 0;
		for (int k = 0; k < n; k++)
			if (scene->materials[births[k].material].law == s)
				variant[count++] = births[k].variant;
		w->law_of_scene[s] = count > 0 ? mpm->n_laws : -1;
		if (count == 0)
			continue;
		status = law_create(&mpm->laws[mpm->n_laws], &scene->laws[s], count, variant);
		if (status != STATUS_OK)
			break;
		snprintf(w->law_names[mpm->n_laws], sizeof *w->law_names, "laws/%s", scene->laws[s].name);
		mpm->n_laws++;
		w->law_start[mpm->n_laws] = w->law_start[mpm->n_laws - 1] + count;
	}
	free(variant);
	return status;
}

static int material_error(const struct scene *scene, int m, const char *what)
{
	const struct scene_material *material = &scene->materials[m];
	return error_set(STATUS_INPUT, "%s:%d: material '%s': %s",
					 material->place.file ? material->place.file : scene->path, material->place.line, material->name,
					 what);
}

/* Puts a point into storage. */
static int give_birth(struct mpm *mpm, const struct birth *birth, int id, int at, int slot)
{
	const struct scene *scene = mpm->scene;
	struct particles *p = &mpm->p;
	const struct scene_material *material = &scene->materials[birth->material];
	const struct scene_body *body = &scene->bodies[birth->body];
	int l = mpm_work(mpm)->law_of_scene[material->law];
	double side = scene_body_spacing(scene, body),
		   density = isnan(material->density) ? mpm->laws[l]->density : material->density;
	if (!(density > 0.0))
		return material_error(scene, birth->material, "no density, expected one here or a law that has one");
	if (mpm->thermal && !(material->heat_capacity > 0.0))
		return material_error(scene, birth->material, "no heat_capacity, expected one where there is heat");
	p->id[at] = id, p->body[at] = birth->body, p->material[at] = birth->material, p->law[at] = l, p->slot[at] = slot;
	for (int c = 0; c < 2; c++) {
		p->x[at][c] = p->x0[at][c] = birth->x[c];
		p->v[at][c] = body->velocity[c];
	}
	mat2_identity(p->F[at]);
	if (body->motion.solution)
		CHECK(motion_begin(mpm, at, birth->x));
	p->volume0[at] = side * side * scene->grid.thickness;
	p->mass[at] = density * p->volume0[at];
	p->T[at] = p->T_smooth[at] = birth->temperature;
	p->capacity[at] = mpm->thermal ? material->heat_capacity : 0.0;
	p->thawed[at] = 1.0;
	freezing_begin(mpm, at);
	p->dT[at] = isnan(material->reference_temperature) ? 0.0 : birth->temperature - material->reference_temperature;
	return STATUS_OK;
}

/* Storage begins in the order of birth within each law, as the laws' slots do. */
static int create_points(struct mpm *mpm, int n, const struct birth *births)
{
	struct mpm_work *w = mpm_work(mpm);
	const struct scene *scene = mpm->scene;
	bool breaks = false;
	for (int l = 0; l < mpm->n_laws; l++)
		breaks = breaks || mpm->laws[l]->type->breaks;
	CHECK(particles_create(&mpm->p, n, scene->mpm.transfer == MPM_APIC, breaks, scene->n_contacts > 0, scene_presses(scene)));
	CHECK(freezing_create(mpm));
	int next[scene->n_laws + 1];
	memset(next, 0, sizeof next);
	for (int k = 0; k < n; k++) {
		int l = w->law_of_scene[scene->materials[births[k].material].law];
		CHECK(give_birth(mpm, &births[k], k, w->law_start[l] + next[l], next[l]));
		next[l]++;
	}
	w->half = calloc((size_t)scene->n_bodies + 1, sizeof *w->half);
	w->conductivity = calloc((size_t)scene->n_materials + 1, sizeof *w->conductivity);
	w->edge = calloc((size_t)scene->n_bodies + 1, sizeof *w->edge);
	if (!w->half || !w->edge || !w->conductivity)
		return error_set(STATUS_RESOURCE, "out of memory");
	for (int b = 0; b < scene->n_bodies; b++) {
		double spacing = scene_body_spacing(scene, &scene->bodies[b]);
		w->half[b] = 0.5 * spacing / scene->grid.cell;
		double c = cos(scene->bodies[b].angle), s = sin(scene->bodies[b].angle);
		w->edge[b][0] = w->edge[b][3] = spacing * c;
		w->edge[b][1] = spacing * s, w->edge[b][2] = -spacing * s;
	}
	w->shape_points = (struct shape_points){.x = (const double(*)[2])mpm->p.x,
											.F = (const double(*)[4])mpm->p.F,
											.body = mpm->p.body,
											.half = w->half,
											.edge = (const double(*)[4])w->edge};
	for (int m = 0; m < scene->n_materials; m++)
		w->conductivity[m] = scene->materials[m].conductivity;
	return STATUS_OK;
}

static int fill(struct mpm *mpm)
{
	struct birth *births = NULL;
	int n = 0, status = STATUS_OK;
	for (int b = 0; b < mpm->scene->n_bodies && status == STATUS_OK; b++)
		status = births_of_body(mpm->scene, b, &births, &n);
	if (status == STATUS_OK && n == 0)
		status = error_set(STATUS_INPUT, "%s: no bodies, expected at least one", mpm->scene->path);
	if (status == STATUS_OK)
		status = create_laws(mpm, n, births);
	if (status == STATUS_OK)
		status = create_points(mpm, n, births);
	free(births);
	return status;
}

/* No point may begin in a wall. */
static int check_walls(const struct mpm *mpm)
{
	const struct scene *scene = mpm->scene;
	for (int wall = 0; wall < scene->n_walls; wall++)
		for (int k = 0; k < mpm->p.n && mpm_work(mpm)->wall_on[wall]; k++)
			if (wall_contains(mpm, wall, mpm->p.x[k], 1e-6 * mpm->grid.h)) {
				const struct scene_wall *s = &scene->walls[wall];
				const struct scene_body *body = &scene->bodies[mpm->p.body[k]];
				return error_set(
					STATUS_INPUT,
					"%s:%d: wall '%s' covers points of body '%s' (one at %.6g, %.6g m), expected them apart",
					s->place.file ? s->place.file : scene->path, s->place.line, s->name, body->name, mpm->p.x[k][0],
					mpm->p.x[k][1]);
			}
	return STATUS_OK;
}

/* The laws' start state: they are told the way from their reference temperature to that at birth. */
static int start_laws(struct mpm *mpm)
{
	struct particles *p = &mpm->p;
	bool warm = false;
	for (int k = 0; k < p->n; k++)
		warm = warm || p->dT[k] != 0.0;
	mpm->dt = mpm->scene->time.step;
	if (warm) {
		double *warming = mpm_work(mpm)->start_warming = calloc((size_t)p->n, sizeof *warming);
		if (!warming)
			return error_set(STATUS_RESOURCE, "out of memory");
		for (int k = 0; k < p->n; k++)
			warming[p->id[k]] = p->dT[k];
		CHECK(advance_laws(mpm));
	}
	memset(p->dT, 0, (size_t)p->n * sizeof *p->dT);
	for (int l = 0; l < mpm->n_laws; l++) {
		struct law_batch batch = law_batch_of(mpm, l);
		CHECK(mpm->laws[l]->type->evaluate(mpm->laws[l], &batch));
	}
	return STATUS_OK;
}

static int create_all(struct mpm *mpm)
{
	const struct scene *scene = mpm->scene;
	mpm->thermal = scene->thermal.on;
	mpm->shape = shape_find(scene->mpm.shape);
	if (!mpm->shape)
		return error_set(STATUS_INPUT, "%s: mpm.shape = \"%s\" is unknown, see `tmdempm info` for what there is",
						 scene->path, scene->mpm.shape);
	CHECK(grid_create(mpm));
	CHECK(fill(mpm));
	CHECK(penalty_create(mpm));
	CHECK(create_work(mpm));
	CHECK(create_projection(mpm));
	CHECK(contact_create(mpm));
	CHECK(walls_create(mpm));
	CHECK(grid_place(mpm));
	CHECK(boundaries_create(mpm));
	CHECK(cohesion_create(mpm));
	CHECK(start_laws(mpm));
	stage_begin_step(mpm);
	walls_update(mpm);
	boundaries_update(mpm);
	CHECK(check_walls(mpm));

	/* one look at the grid: the smooth temperature, and is the step stable? */
	mpm_sort(mpm);
	if (mpm_work(mpm)->contact)
		CHECK(contact_find_fields(mpm));
	mpm_clear_grid(mpm);
	mpm_work(mpm)->thermal_dt = mpm->thermal ? mpm_thermal_step(mpm) : 0.0;
	mpm_points_to_grid(mpm);
	if (mpm->thermal)
		mpm_remap_temperature(mpm);
	if (mpm_work(mpm)->limit_nodes)
		limit_look(mpm);
	int status = guard_step(mpm, STATUS_INPUT);
	if (status != STATUS_OK)
		return error_context(status, "%s: time.step", scene->path);
	/* that look was no step: nothing has grown, and a restart's last look was another one */
	memset(mpm->p.growth, 0, (size_t)mpm->p.n * sizeof *mpm->p.growth);
	mpm_work(mpm)->limit.growth = 0.0;
	mpm_clear_grid(mpm);
	ledger_start(mpm);
	mpm_measure(mpm);
	return STATUS_OK;
}

int mpm_create(struct mpm **result, const struct scene *scene)
{
	*result = NULL;
	struct mpm *mpm = calloc(1, sizeof *mpm);
	if (!mpm)
		return error_set(STATUS_RESOURCE, "out of memory");
	mpm->scene = scene;
	mpm->lattice_limit = INFINITY;
	mpm->work = calloc(1, sizeof(struct mpm_work));
	int status = mpm->work ? create_all(mpm) : error_set(STATUS_RESOURCE, "out of memory");
	if (status == STATUS_OK)
		*result = mpm;
	else
		mpm_free(mpm);
	return status;
}

void mpm_free(struct mpm *mpm)
{
	if (!mpm)
		return;
	struct mpm_work *w = mpm_work(mpm);
	struct grid *grid = &mpm->grid;
	void *arrays[] = {grid->mass, grid->v, grid->v_new, grid->force, grid->heat_capacity, grid->T, grid->T_new};
	for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++)
		free(arrays[k]);
	for (int l = 0; l < mpm->n_laws; l++)
		law_free(mpm->laws[l]);
	free(mpm->laws);
	particles_free(&mpm->p);
	if (w) {
		walls_free(mpm);
		boundaries_free(mpm);
		cohesion_free(mpm);
		contact_free(mpm);
		penalty_free(mpm);
		void *private[] = {w->half,        w->law_start,    w->law_names,    w->law_of_scene,  w->conductivity,
						   w->cell,        w->order,        w->cell_first,   w->row_low,       w->row_high,
						   w->scratch,     w->permutation,  w->sums,         w->confining,     w->stripe_sums,
						   w->block_sums,  w->row_sums,     w->heat_sums,    w->start_warming, w->seen,
						   w->projected,   w->strain_power, w->way,          w->freezing,      w->body_force,
						   w->limit_nodes, w->limit_sums,   w->limit_points, w->edge};
		for (size_t k = 0; k < sizeof private / sizeof *private; k++)
			free(private[k]);
		free(w);
	}
	free(mpm);
}

/* ---- look-up ---- */

int mpm_point_by_id(const struct mpm *mpm, int id)
{
	for (int k = 0; k < mpm->p.n; k++)
		if (mpm->p.id[k] == id)
			return k;
	return -1;
}

/* Of equally near points the one born first, so that the answer does not depend on storage. */
int mpm_point_nearest_initial(const struct mpm *mpm, const double at[2])
{
	const struct particles *p = &mpm->p;
	int best = -1;
	double least = INFINITY;
	for (int k = 0; k < p->n; k++) {
		double dx = p->x0[k][0] - at[0], dy = p->x0[k][1] - at[1], d = dx * dx + dy * dy;
		if (d < least || (d == least && p->id[k] < p->id[best]))
			least = d, best = k;
	}
	return best;
}

double mpm_start_warming(const struct mpm *mpm, int id)
{
	const double *warming = mpm_work(mpm)->start_warming;
	return warming ? warming[id] : NAN;
}

/* ---- state ---- */

static int add_array(struct mpm_state_array *arrays, int at, const char *name, void *data, char type, size_t count)
{
	if (arrays)
		arrays[at] = (struct mpm_state_array){name, data, type, count};
	return at + 1;
}

int mpm_state(struct mpm *mpm, struct mpm_state_array *arrays)
{
	struct mpm_work *w = mpm_work(mpm);
	size_t walls = (size_t)mpm->scene->n_walls;
	int n = particles_state(&mpm->p, arrays, 0);
	for (int l = 0; l < mpm->n_laws; l++)
		n = add_array(arrays, n, w->law_names[l], mpm->laws[l]->states, 'b',
					  (size_t)mpm->laws[l]->n_points * mpm->laws[l]->state_bytes);
	n = add_array(arrays, n, "mpm/step", &mpm->step, 'q', 1);
	n = add_array(arrays, n, "mpm/time", &mpm->time, 'd', 1);
	n = add_array(arrays, n, "mpm/dt", &mpm->dt, 'd', 1);
	n = add_array(arrays, n, "mpm/stage", &mpm->stage, 'i', 1);
	n = add_array(arrays, n, "mpm/stage_start", &mpm->stage_start, 'd', 1);
	n = add_array(arrays, n, "mpm/stable_step", &mpm->stable_step, 'd', 1);
	n = add_array(arrays, n, "mpm/lattice_limit", &mpm->lattice_limit, 'd', 1);
	n = add_array(arrays, n, "mpm/thermal_limit", &mpm->thermal_limit, 'd', 1);
	n = add_array(arrays, n, "mpm/ledger_sums", &w->total, 'd', sizeof w->total / sizeof(double));
	if (walls) {
		n = add_array(arrays, n, "walls/sums", mpm->walls, 'd', walls * sizeof *mpm->walls / sizeof(double));
		n = add_array(arrays, n, "walls/offset", mpm->wall_offset, 'd', walls * 2);
	}
	if (w->wall_heat)
		n = add_array(arrays, n, "grid/wall_heat", w->wall_heat, 'd', (size_t)mpm->grid.nx * (size_t)mpm->grid.ny);
	return n;
}

int mpm_write_out(struct mpm *mpm)
{
	for (int l = 0; l < mpm->n_laws; l++)
		if (mpm->laws[l]->type->write_out)
			CHECK(mpm->laws[l]->type->write_out(mpm->laws[l]));
	return STATUS_OK;
}

int mpm_restored(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	if (mpm->step < 0 || mpm->stage < 0 || (mpm->stage > 0 && mpm->stage >= mpm->scene->n_stages))
		return error_set(STATUS_INPUT, "the saved state is at step %lld of stage %d, which this scene does not have",
						 mpm->step, mpm->stage);
	for (int l = 0; l < mpm->n_laws; l++)
		if (mpm->laws[l]->type->restored)
			mpm->laws[l]->type->restored(mpm->laws[l]);
	w->boundaries_stale = true;
	w->residual_message[0] = '\0';
	mpm->within_step = false;
	CHECK(grid_place(mpm));
	walls_update(mpm);
	boundaries_update(mpm);
	return STATUS_OK;
}

size_t mpm_memory(const struct mpm *mpm)
{
	const struct mpm_work *w = mpm_work(mpm);
	size_t nodes = w->n_nodes, n = (size_t)mpm->p.n;
	size_t per_node = sizeof(struct node_sum) + 7 * sizeof(double) + (mpm->thermal ? 6 * sizeof(double) : 0) +
					  (w->fixed_v ? 4 * sizeof(double) : 0) +
					  ((w->confining != NULL) + (w->body_force != NULL)) * 2 * sizeof(double) + sizeof(int) +
					  (w->projected ? sizeof *w->projected : 0);
	per_node += w->limit_nodes ? sizeof *w->limit_nodes : 0;
	size_t bytes = particles_bytes(&mpm->p) +
				   n * (3 * sizeof(int) + particles_widest() + (w->way ? sizeof *w->way : 0)) + nodes * per_node +
				   (size_t)w->wall_node_capacity * (sizeof(struct wall_node) + sizeof(struct wall_effect));
	bytes += contact_memory(mpm);
	for (int l = 0; l < mpm->n_laws; l++)
		bytes += (size_t)mpm->laws[l]->n_points * mpm->laws[l]->state_bytes;
	return bytes;
}
