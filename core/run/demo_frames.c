#include "run/demo_frames.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/mat2.h"
#include "run/viewer.h"

/* ---- hopper ---- */

/* The left half; the right one mirrors it. */
static const double hopper[][2] = {{0.5, 4.0}, {4.0, 2.0}, {4.25, 2.0}, {1.0, 4.2}, {1.0, 11.0}, {0.5, 11.0}};
enum { HOPPER = sizeof hopper / sizeof *hopper, WALLS = 4 };

/* Half width of the material at height y, 0 where there is none. */
static double half_width(double y)
{
	if (y > 4.2)
		return y < 9.5 ? 4.0 : 0;
	if (y > 2.0)
		return 0.75 + (y - 2.0) * (4.0 - 0.75) / 2.2;
	return 0.75 - 0.1 * (2.0 - y);
}

static void silo_walls(struct frame_builder *builder)
{
	int n_points = 2 * HOPPER + 2 + 4;
	frame_channel_add(builder, "walls", FRAME_POLYLINES, n_points, WALLS);
	double(*x)[3] = frame_array_add(builder, "coordinates", "m", FRAME_GEOMETRY, FRAME_F64, 3, n_points);
	if (!x)
		return;
	for (int k = 0; k < HOPPER; k++) {
		x[k][0] = hopper[k][0];
		x[HOPPER + k][0] = 10 - hopper[HOPPER - 1 - k][0];
		x[k][1] = hopper[k][1];
		x[HOPPER + k][1] = hopper[HOPPER - 1 - k][1];
	}
	double(*ground)[3] = x + 2 * HOPPER, (*plate)[3] = ground + 2; /* plate: switched off, must not be drawn */
	ground[0][0] = 0, ground[1][0] = 10;
	ground[0][1] = ground[1][1] = 0.25;
	plate[0][0] = plate[3][0] = 3, plate[1][0] = plate[2][0] = 7;
	plate[0][1] = plate[1][1] = 1.6, plate[2][1] = plate[3][1] = 1.9;
	int32_t *offsets = frame_array_add(builder, "offsets", "-", FRAME_GEOMETRY, FRAME_I32, 1, WALLS + 1);
	for (int k = 0; offsets && k <= WALLS; k++)
		offsets[k] = (int[]){0, HOPPER, 2 * HOPPER, 2 * HOPPER + 2, n_points}[k];
	int32_t *closed = frame_array_add(builder, "closed", "-", FRAME_CELL, FRAME_I32, 1, WALLS);
	if (closed)
		closed[0] = closed[1] = closed[3] = 1;
	int32_t *active = frame_array_add(builder, "active", "-", FRAME_CELL, FRAME_I32, 1, WALLS);
	if (active)
		active[0] = active[1] = active[2] = 1;
}

static double silo_area(void)
{
	double area = 0;
	for (double y = 0.305; y < 9.5; y += 0.01)
		area += 0.01 * 2 * half_width(y);
	return area;
}

/* Lattice points inside the hopper, m; the caller frees them. */
static double (*silo_points(double spacing, int *count))[2]
{
	int rows = (int)(9.2 / spacing), n = 0;
	for (int j = 0; j < rows; j++)
		n += 2 * (int)(half_width(0.3 + (j + 0.5) * spacing) / spacing);
	double(*points)[2] = malloc(sizeof *points * (size_t)(n + 1));
	*count = n;
	for (int j = 0, p = 0; points && j < rows; j++) {
		double y = 0.3 + (j + 0.5) * spacing;
		int half = (int)(half_width(y) / spacing);
		for (int i = -half; i < half; i++, p++) {
			points[p][0] = 5 + spacing * (i + 0.5) + (y < 2 ? 0.04 * sin(3 * y + i) : 0);
			points[p][1] = y - (y < 2 ? 0.1 * cos(i) * (2 - y) : 0);
		}
	}
	return points;
}

static double temperature_at(const double p[2])
{
	double wall = half_width(p[1]) - fabs(p[0] - 5);
	return 20 + 33 * exp(-wall * wall / 0.4) * (p[1] < 4.4) + 12 * exp(-pow(p[0] - 5, 2) - 0.1 * pow(p[1] - 4, 2));
}

static void silo_domains(struct frame_builder *builder, const double (*points)[2], int n, double spacing)
{
	static const double corners[4][2] = {{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}};
	frame_channel_add(builder, "domains", FRAME_QUADS, 4 * n, n);
	double(*x)[3] = frame_array_add(builder, "coordinates", "m", FRAME_GEOMETRY, FRAME_F64, 3, 4 * n);
	for (int k = 0; x && k < 4 * n; k++)
		for (int d = 0; d < 2; d++)
			x[k][d] = points[k / 4][d] + spacing * corners[k % 4][d];
	double *temperature = frame_array_add(builder, "temperature", "T", FRAME_CELL, FRAME_F64, 1, n);
	for (int p = 0; temperature && p < n; p++)
		temperature[p] = temperature_at(points[p]);
	double(*stress)[6] = frame_array_add(builder, "stress", "Pa", FRAME_CELL, FRAME_F64, 6, n);
	for (int p = 0; stress && p < n; p++) {
		stress[p][1] = -1.1e4 * (9.5 - points[p][1]);
		stress[p][0] = 0.4 * stress[p][1];
		stress[p][3] = 2.5e4 * sin(points[p][0] - 5) * exp(-0.2 * points[p][1]);
	}
}

const void *demo_frame_silo(struct frame_builder *builder, int n, double time, int64_t *bytes)
{
	double spacing = sqrt(silo_area() / n);
	int count;
	double(*points)[2] = silo_points(spacing, &count);
	if (!points)
		return NULL;
	frame_begin(builder, 1000, time, "Silo, forced discharge (made up)", "C");
	silo_domains(builder, (const double(*)[2])points, count, spacing);
	silo_walls(builder);
	free(points);
	return frame_finish(builder, bytes);
}

/* ---- RVE ---- */

struct demo_disc {
	double s[2], u[2], r, force[2]; /* s fractional; u moved since the start, m */
	int contacts;
};

struct demo_pair {
	int i, j;
	double branch[2], overlap;
};

static double random_unit(uint64_t *state)
{
	*state = *state * 6364136223846793005u + 1442695040888963407u;
	return (double)(*state >> 11) / 9007199254740992.0;
}

/* Overlapping pairs of nearest images (the demo's cells are wide enough for that). */
static int find_pairs(const struct demo_disc *discs, int n, const double H[4], struct demo_pair *pairs, int capacity)
{
	int count = 0;
	for (int i = 0; i < n; i++)
		for (int j = i + 1; j < n && count < capacity; j++) {
			double a = discs[j].s[0] - discs[i].s[0], b = discs[j].s[1] - discs[i].s[1];
			a -= round(a), b -= round(b);
			double x = H[0] * a + H[1] * b, y = H[2] * a + H[3] * b, reach = discs[i].r + discs[j].r;
			if (x * x + y * y < reach * reach)
				pairs[count++] = (struct demo_pair){i, j, {x, y}, reach - sqrt(x * x + y * y)};
		}
	return count;
}

/* Pushes overlapping discs apart, down the gradient of the overlap energy. */
static int relax(struct demo_disc *discs, int n, const double H[4], struct demo_pair *pairs, int capacity)
{
	double inverse[4];
	mat2_inverse(H, inverse);
	int count = 0;
	for (int round = 0; round < 400; round++) {
		count = find_pairs(discs, n, H, pairs, capacity);
		for (int p = 0; p < count; p++) {
			const struct demo_pair *c = &pairs[p];
			double l = hypot(c->branch[0], c->branch[1]);
			for (int d = 0; d < 2; d++) {
				discs[c->i].force[d] -= c->overlap * c->branch[d] / l;
				discs[c->j].force[d] += c->overlap * c->branch[d] / l;
			}
		}
		for (int i = 0; i < n; i++) {
			double dx = 0.3 * discs[i].force[0], dy = 0.3 * discs[i].force[1];
			discs[i].s[0] += inverse[0] * dx + inverse[1] * dy;
			discs[i].s[1] += inverse[2] * dx + inverse[3] * dy;
			discs[i].u[0] += dx, discs[i].u[1] += dy;
			discs[i].force[0] = discs[i].force[1] = 0;
		}
	}
	return count;
}

static void add_discs(struct frame_builder *builder, const struct demo_disc *discs, int n, const double H[4])
{
	struct frame_channel *channel = frame_channel_add(builder, "rve_A_discs", FRAME_VERTICES, n, n);
	if (!channel)
		return;
	for (int k = 0; k < 4; k++)
		channel->cell_matrix[k] = H[k];
	snprintf(channel->note, sizeof channel->note,
			 "\xcf\x83xx = \xe2\x88\x92"
			 "12.1 kPa, \xcf\x83yy = \xe2\x88\x92"
			 "8.4 kPa, e = 0.163, coordination 3.9");
	channel->rve = (struct frame_rve){.time = 0.5,
									  .point = 412,
									  .stress = {-12.1e3, -8.4e3, 0, 1.3e3},
									  .strain = {0.012, -0.015, 0, 0.002},
									  .fabric = {0.56, 0.44, 0.03},
									  .void_ratio = 0.163,
									  .coordination = 3.9,
									  .temperature = 23.5};
	double(*x)[3] = frame_array_add(builder, "coordinates", "m", FRAME_GEOMETRY, FRAME_F64, 3, n);
	for (int i = 0; x && i < n; i++) {
		x[i][0] = H[0] * discs[i].s[0] + H[1] * discs[i].s[1];
		x[i][1] = H[2] * discs[i].s[0] + H[3] * discs[i].s[1];
	}
	double *radius = frame_array_add(builder, "radius", "m", FRAME_POINT, FRAME_F64, 1, n);
	for (int i = 0; radius && i < n; i++)
		radius[i] = discs[i].r;
	double(*u)[3] = frame_array_add(builder, "displacement", "m", FRAME_POINT, FRAME_F64, 3, n);
	for (int i = 0; u && i < n; i++)
		u[i][0] = discs[i].u[0], u[i][1] = discs[i].u[1];
	double *rotation = frame_array_add(builder, "rotation", "rad", FRAME_POINT, FRAME_F64, 1, n);
	for (int i = 0; rotation && i < n; i++)
		rotation[i] = 0.4 * sin(40 * discs[i].u[0] / discs[i].r);
	int32_t *coordination = frame_array_add(builder, "coordination", "-", FRAME_POINT, FRAME_I32, 1, n);
	for (int i = 0; coordination && i < n; i++)
		coordination[i] = discs[i].contacts;
}

static void add_contacts(struct frame_builder *builder, const struct demo_disc *discs, const struct demo_pair *pairs,
						 int count, const double H[4], int bonds)
{
	frame_channel_add(builder, "rve_A_contacts", FRAME_SEGMENTS, 2 * count, count);
	double(*x)[3] = frame_array_add(builder, "coordinates", "m", FRAME_GEOMETRY, FRAME_F64, 3, 2 * count);
	for (int p = 0; x && p < count; p++) {
		const struct demo_disc *d = &discs[pairs[p].i];
		x[2 * p][0] = H[0] * d->s[0] + H[1] * d->s[1];
		x[2 * p][1] = H[2] * d->s[0] + H[3] * d->s[1];
		for (int c = 0; c < 2; c++)
			x[2 * p + 1][c] = x[2 * p][c] + pairs[p].branch[c];
	}
	double *normal = frame_array_add(builder, "normal_force", "N", FRAME_CELL, FRAME_F64, 1, count);
	for (int p = 0; normal && p < count; p++)
		normal[p] = 1e6 * pairs[p].overlap * (bonds && p % 9 == 0 ? -0.5 : 1);
	int32_t *sliding = frame_array_add(builder, "sliding", "-", FRAME_CELL, FRAME_I32, 1, count);
	for (int p = 0; sliding && p < count; p++)
		sliding[p] = p % 11 == 3;
	int32_t *bond = frame_array_add(builder, "bond", "-", FRAME_CELL, FRAME_I32, 1, count);
	for (int p = 0; bond && p < count; p++)
		bond[p] = !bonds ? 0 : p % 9 == 0 || p % 4 == 1 ? 1 : p % 13 == 2 ? 2 : 0;
}

const void *demo_frame_rve(struct frame_builder *builder, int n, double stretch, double shear, int bonds,
						   int64_t *bytes)
{
	int capacity = 8 * n;
	struct demo_disc *discs = calloc((size_t)n, sizeof *discs);
	struct demo_pair *pairs = calloc((size_t)capacity, sizeof *pairs);
	const void *frame = NULL;
	if (discs && pairs) {
		uint64_t seed = 1;
		double solid = 0;
		for (int i = 0; i < n; i++) {
			discs[i].s[0] = random_unit(&seed), discs[i].s[1] = random_unit(&seed);
			discs[i].r = 0.25e-3 * (1 + random_unit(&seed));
			solid += 3.141592653589793 * discs[i].r * discs[i].r;
		}
		double side = sqrt(solid / 0.86), a = sqrt(stretch);
		double H[4] = {side * a, side / a * shear, 0, side / a};
		int count = relax(discs, n, H, pairs, capacity);
		for (int p = 0; p < count; p++)
			discs[pairs[p].i].contacts++, discs[pairs[p].j].contacts++;
		frame_begin(builder, 1000, 0.5, "", "C");
		add_discs(builder, discs, n, H);
		add_contacts(builder, discs, pairs, count, H, bonds);
		frame = frame_finish(builder, bytes);
	}
	free(discs);
	free(pairs);
	return frame;
}
