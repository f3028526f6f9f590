/* Speed of the MPM on one core: whole mpm_step() calls on an elastic column that swings under its weight,
 * 4 points in each grid cell, ledger and guards included; and what each transfer scheme and order costs, and the fields
 * of bodies and cracks. */
#include "run/bench.h"

#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "base/error.h"
#include "mpm/mpm.h"

enum { REPEATS = 7, POINT_STEPS = 1000000, BREAK_STEPS = 5 /* for each cell of a side */ };
static const double BREAK_STRENGTH = 2e3, BREAK_ENERGY = 0.1, BREAK_SPEED = 0.5; /* Pa, J/m2, m/s */

static double thread_seconds(void)
{
	struct timespec now;
	clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
	return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* What a scene points to. */
struct column {
	struct scene scene;
	struct scene_law law;
	struct scene_material material;
	struct scene_body body[4];
	struct scene_contact contact;
	struct scene_wall walls[3];
	double corners[4][4][2], lines[3][2][2];
};

static void column_wall(struct column *c, int w, double x0, double y0, double x1, double y1,
						enum scene_wall_contact contact)
{
	c->lines[w][0][0] = x0, c->lines[w][0][1] = y0, c->lines[w][1][0] = x1, c->lines[w][1][1] = y1;
	c->walls[w] = (struct scene_wall){.n_vertices = 2,
									  .vertices = c->lines[w],
									  .depth = 2.0 * c->scene.grid.cell,
									  .contact = contact,
									  .temperature = NAN,
									  .until = INFINITY};
}

static void column_body(struct column *c, int b, double x, double y, double width, double height)
{
	const double corners[4][2] = {{x, y}, {x + width, y}, {x + width, y + height}, {x, y + height}};
	memcpy(c->corners[b], corners, sizeof corners);
	c->body[b] = (struct scene_body){.name = "column",
									 .n_vertices = 4,
									 .vertices = c->corners[b],
									 .lattice_origin = {NAN, NAN},
									 .points_per_cell = 4,
									 .temperature = 300.0,
									 .variants = 1};
}

/* The same square as four bodies that touch: an eighth of the nodes has several fields. */
static void part_column(struct column *c, int side)
{
	const double h = c->scene.grid.cell;
	for (int b = 0; b < 4; b++)
		column_body(c, b, 2 * h, (2 + side / 4 * b) * h, side * h, (b < 3 ? side / 4 : side - 3 * (side / 4)) * h);
	c->contact = (struct scene_contact){.friction = 0.3, .softening = {NAN, NAN}, .conductance_pressure = 1.0};
	c->scene.contacts = &c->contact, c->scene.n_contacts = 1, c->scene.n_bodies = 4;
}

/* A square of side by side cells of 1 cm of a soft solid on a floor between smooth walls. */
static void column_scene(struct column *c, const char *shape, int side, bool thermal)
{
	const double h = 0.01, young = 1e6, density = 1000.0, l = side * h;
	*c = (struct column){0};
	struct scene *s = &c->scene;
	snprintf(s->path, sizeof s->path, "bench");
	s->grid = (struct scene_grid){.size = {(side + 4) * h, (side + 8) * h}, .cell = h, .thickness = 1.0};
	s->time = (struct scene_time){1.0, 0.4 * h / sqrt(young / density), 1.0, 1, 1};
	snprintf(s->mpm.shape, sizeof s->mpm.shape, "%s", shape);
	s->mpm.xpic_order = 2, s->mpm.xpic_every = 1;
	s->thermal.on = thermal;
	s->thermal.time_scale = 1.0;
	s->gravity[1] = -9.81;
	s->guards = (struct scene_guards){
		.points_leaving = true, .time_step = true, .thermal_step = true, .numerical_fracture = true};
	c->law = (struct scene_law){
		.name = "elastic", .type = SCENE_LAW_THERMOELASTIC, .thermoelastic = {young, 0.3, 1e-5, false}};
	c->material = (struct scene_material){.name = "solid",
										  .density = density,
										  .heat_capacity = 1000.0,
										  .conductivity = 10.0,
										  .reference_temperature = NAN,
										  .freezing = {NAN, NAN}};
	column_body(c, 0, 2 * h, 2 * h, l, l);
	column_wall(c, 0, 0.0, 2 * h, (side + 4) * h, 2 * h, SCENE_WALL_FRICTIONAL);
	column_wall(c, 1, 2 * h, (side + 8) * h, 2 * h, 0.0, SCENE_WALL_SLIP);
	column_wall(c, 2, 2 * h + l, 0.0, 2 * h + l, (side + 8) * h, SCENE_WALL_SLIP);
	s->laws = &c->law, s->materials = &c->material, s->bodies = c->body, s->walls = c->walls;
	s->n_laws = s->n_materials = s->n_bodies = 1, s->n_walls = 3;
}

static int run_steps(struct mpm *mpm, int steps, double *rate)
{
	double start = thread_seconds();
	for (int k = 0; k < steps; k++)
		CHECK(mpm_step(mpm));
	*rate = (double)mpm->p.n * steps / (thread_seconds() - start);
	return STATUS_OK;
}

static int bench_case(bool json, const char *name, const char *shape, int side, bool thermal, bool parted)
{
	struct column column;
	struct mpm *mpm;
	column_scene(&column, shape, side, thermal);
	if (parted)
		part_column(&column, side);
	CHECK(mpm_create(&mpm, &column.scene));
	int steps = POINT_STEPS / mpm->p.n + 1, status = STATUS_OK;
	double rates[REPEATS];
	status = run_steps(mpm, steps / 4 + 1, &rates[0]); /* warm */
	for (int k = 0; k < REPEATS && status == STATUS_OK; k++)
		status = run_steps(mpm, steps, &rates[k]);
	if (status == STATUS_OK)
		bench_report(json, name, rates, REPEATS, "point-steps/s", 1);
	mpm_free(mpm);
	return status;
}

/* ---- what fields of their own cost ---- */

/* The square is of a weak solid and falls on the floor: it goes on breaking while it is looked at (of 10k points, a sixth is
 * damaged at first and most in the end). */
static void break_column(struct column *c)
{
	const double h = c->scene.grid.cell;
	c->law.type = SCENE_LAW_RANKINE;
	c->law.rankine = (struct scene_law_rankine){.young = 1e6,
												.poisson = 0.2,
												.expansion = 1e-5,
												.strength = BREAK_STRENGTH,
												.fracture_energy = BREAK_ENERGY,
												.heat_share = 1.0,
												.cell = h};
	c->body[0].velocity[1] = -BREAK_SPEED;
	c->contact = (struct scene_contact){
		.cracks = true, .friction = 0.3, .softening = {NAN, NAN}, .heat_share = 1.0, .conductance_pressure = 1.0};
	c->scene.contacts = &c->contact, c->scene.n_contacts = 1;
}

/* Gives the state of one to another that differs by its contacts only. */
static int take_over(struct mpm *to, struct mpm *from)
{
	int n = mpm_state(from, NULL), m = mpm_state(to, NULL);
	struct mpm_state_array have[n], want[m];
	mpm_state(from, have), mpm_state(to, want);
	CHECK(mpm_write_out(from));
	for (int k = 0; k < m; k++)
		for (int i = 0; i < n; i++)
			if (strcmp(have[i].name, want[k].name) == 0 && have[i].count == want[k].count)
				memcpy(want[k].data, have[i].data,
					   want[k].count * (want[k].type == 'b'   ? 1
										: want[k].type == 'i' ? sizeof(int)
															  : sizeof(double)));
	return mpm_restored(to);
}

/* How much longer a step takes with contacts than without, in turns: of four bodies that touch, or of one that has
 * broken up. */
static int bench_partition(bool json, const char *name, int side, bool broken)
{
	struct column columns[2];
	struct mpm *mpm[2] = {NULL, NULL};
	double costs[REPEATS], rate;
	int status = STATUS_OK;
	for (int k = 0; k < 2 && status == STATUS_OK; k++) {
		column_scene(&columns[k], "cpdi", side, false);
		if (broken)
			break_column(&columns[k]);
		else
			part_column(&columns[k], side);
		columns[k].scene.n_contacts = k;
		status = mpm_create(&mpm[k], &columns[k].scene);
	}
	if (status == STATUS_OK && broken)
		status = run_steps(mpm[1], BREAK_STEPS * side, &rate);
	if (status == STATUS_OK && broken)
		status = take_over(mpm[0], mpm[1]);
	for (int k = -1; k < REPEATS && status == STATUS_OK; k++) { /* the first warms */
		double rates[2] = {0.0, 0.0};
		for (int m = 0; m < 2 && status == STATUS_OK; m++)
			status = run_steps(mpm[m], POINT_STEPS / mpm[m]->p.n / 4 + 1, &rates[m]);
		if (k >= 0)
			costs[k] = 100.0 * (rates[0] / rates[1] - 1.0);
	}
	if (status == STATUS_OK)
		bench_report(json, name, costs, REPEATS, "% of a step", 1);
	mpm_free(mpm[0]);
	mpm_free(mpm[1]);
	return status;
}

/* ---- schemes ---- */

struct scheme_case {
	const char *name;
	enum mpm_transfer transfer;
	enum mpm_order order;
	int xpic_order;
};

/* Time of a step over that of FLIP in the order USL, in turns with it, so that a busy machine weighs on both. */
static int bench_scheme(bool json, const struct scheme_case *scheme)
{
	struct column columns[2];
	struct mpm *mpm[2] = {NULL, NULL};
	double costs[REPEATS];
	int status = STATUS_OK;
	for (int k = 0; k < 2; k++)
		column_scene(&columns[k], "ugimp", 50, false);
	columns[1].scene.mpm.transfer = scheme->transfer, columns[1].scene.mpm.order = scheme->order;
	columns[1].scene.mpm.xpic_order = scheme->xpic_order;
	for (int k = 0; k < 2 && status == STATUS_OK; k++)
		status = mpm_create(&mpm[k], &columns[k].scene);
	for (int k = -1; k < REPEATS && status == STATUS_OK; k++) { /* the first warms */
		double rates[2] = {0.0, 0.0};
		for (int m = 0; m < 2 && status == STATUS_OK; m++)
			status = run_steps(mpm[m], POINT_STEPS / mpm[m]->p.n / 2 + 1, &rates[m]);
		if (k >= 0)
			costs[k] = rates[0] / rates[1];
	}
	if (status == STATUS_OK)
		bench_report(json, scheme->name, costs, REPEATS, "times flip, usl", 1);
	mpm_free(mpm[0]);
	mpm_free(mpm[1]);
	return status;
}

int bench_mpm(bool json)
{
	static const struct {
		const char *name, *shape;
		int side; /* 4 side^2 points */
		bool thermal, parted;
	} cases[] = {
		{"mpm_linear_10k", "linear", 50, false, false},      {"mpm_linear_100k", "linear", 158, false, false},
		{"mpm_ugimp_10k", "ugimp", 50, false, false},        {"mpm_ugimp_100k", "ugimp", 158, false, false},
		{"mpm_ugimp_thermal_10k", "ugimp", 50, true, false}, {"mpm_ugimp_thermal_100k", "ugimp", 158, true, false},
		{"mpm_cpdi_10k", "cpdi", 50, false, false},          {"mpm_cpdi_100k", "cpdi", 158, false, false},
		{"mpm_cpdi_thermal_10k", "cpdi", 50, true, false},   {"mpm_cpdi_thermal_100k", "cpdi", 158, true, false},
		{"mpm_cpdi_contact_10k", "cpdi", 50, false, true},   {"mpm_cpdi_contact_100k", "cpdi", 158, false, true},
	};
	static const struct {
		const char *name;
		int side;
		bool broken;
	} partitions[] = {{"mpm_partition_10k", 50, false},
					  {"mpm_partition_100k", 158, false},
					  {"mpm_partition_broken_10k", 50, true},
					  {"mpm_partition_broken_100k", 158, true}};
	static const struct scheme_case schemes[] = {
		{"mpm_xpic1", MPM_XPIC, MPM_USL, 1}, {"mpm_xpic2", MPM_XPIC, MPM_USL, 2}, {"mpm_xpic3", MPM_XPIC, MPM_USL, 3},
		{"mpm_xpic5", MPM_XPIC, MPM_USL, 5}, {"mpm_fmpm2", MPM_FMPM, MPM_USL, 2}, {"mpm_apic", MPM_APIC, MPM_USL, 2},
		{"mpm_usf", MPM_FLIP, MPM_USF, 2},   {"mpm_musl", MPM_FLIP, MPM_MUSL, 2},
	};
	int threads = omp_get_max_threads(), status = STATUS_OK;
	omp_set_num_threads(1);
	bench_header(json, 1);
	for (size_t k = 0; k < sizeof cases / sizeof *cases && status == STATUS_OK; k++)
		status = bench_case(json, cases[k].name, cases[k].shape, cases[k].side, cases[k].thermal, cases[k].parted);
	for (size_t k = 0; k < sizeof partitions / sizeof *partitions && status == STATUS_OK; k++)
		status = bench_partition(json, partitions[k].name, partitions[k].side, partitions[k].broken);
	for (size_t k = 0; k < sizeof schemes / sizeof *schemes && status == STATUS_OK; k++)
		status = bench_scheme(json, &schemes[k]);
	omp_set_num_threads(threads);
	return status;
}
