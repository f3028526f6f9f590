/* States of the packed kernel, made from those of the serial kernel and back. */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "rve/model.h"

static const double turn = 4294967296.0; /* coordinates of a cell vector in single precision */

static double number(const struct rve_layout *layout, const unsigned char *at, int k)
{
	return layout->single ? (double)((const real32 *)at)[k] : ((const real *)at)[k];
}

static void set_number(const struct rve_layout *layout, unsigned char *at, int k, double value)
{
	if (layout->single)
		((real32 *)at)[k] = (real32)value;
	else
		((real *)at)[k] = value;
}

/* A coordinate, in cell vectors, or the place at the last build, as whole numbers. */
static double whole_to_place(const void *whole, int k) { return (double)((const uint32_t *)whole)[k] / turn; }

static int32_t place_to_whole(double place, double *rest)
{
	double s = (place - floor(place)) * turn, whole = floor(s + 0.5);
	*rest = s - whole;
	return (int32_t)(uint32_t)(uint64_t)whole;
}

void rve_packed_table(const struct rve_model *model, const real *table, unsigned char *packed)
{
	const struct rve_layout *serial = &model->serial;
	const double dt = model->constants.dt;
	for (int i = 0; i <= serial->n; i++) { /* the ghost too */
		const double step_inertia = i < serial->n ? table[TABLE_DT_INERTIA * serial->stride + i] * dt : 1.0;
		set_number(&model->layout, packed, PACKED_TABLE * i, table[TABLE_R * serial->stride + i]);
		set_number(&model->layout, packed, PACKED_TABLE * i + 1, table[TABLE_MASS * serial->stride + i]);
		set_number(&model->layout, packed, PACKED_TABLE * i + 2, table[TABLE_DT_MASS * serial->stride + i] * dt);
		set_number(&model->layout, packed, PACKED_TABLE * i + 3, step_inertia);
	}
}

static unsigned char *packed_disc(const struct rve_layout *layout, const unsigned char *state, int field)
{
	return (unsigned char *)(uintptr_t)state + layout->disc +
		   (size_t)field * (size_t)layout->stride * (layout->single ? sizeof(real32) : sizeof(real));
}

static real32 *disc32(const struct rve_layout *layout, const unsigned char *state, int field)
{
	return (real32 *)((unsigned char *)(uintptr_t)state + layout->disc32) + field * layout->stride;
}

static real *serial_disc(const struct rve_layout *layout, const unsigned char *state, int field)
{
	return (real *)((unsigned char *)(uintptr_t)state + layout->disc) + field * layout->stride;
}

/* Row `from` of the serial state becomes row `to` of the packed one. */
static void pack_disc(const struct rve_model *model, const unsigned char *serial, int from, unsigned char *packed,
					  int to)
{
	const struct rve_layout *s = &model->serial, *p = &model->layout;
	const double dt = model->constants.dt;
	for (int axis = 0; axis < 2; axis++) {
		double place = serial_disc(s, serial, DISC_SX + axis)[from];
		real32 *ref = disc32(p, packed, DISC32_REF_X + axis) + to;
		const real32 ref_from = disc32(s, serial, DISC32_REF_X + axis)[from];
		if (p->single) {
			double rest, none;
			((int32_t *)packed_disc(p, packed, PACKED_SX + axis))[to] = place_to_whole(place, &rest);
			((real32 *)packed_disc(p, packed, PACKED_REST_X + axis))[to] = (real32)rest;
			*(int32_t *)ref = place_to_whole((double)ref_from, &none);
		} else {
			((real *)packed_disc(p, packed, PACKED_SX + axis))[to] = place;
			*ref = ref_from;
		}
	}
	for (int f = 0; f < 3; f++)
		set_number(p, packed_disc(p, packed, PACKED_VX + f), to, serial_disc(s, serial, DISC_VX + f)[from] * dt);
	for (int f = DISC32_UX; f <= DISC32_ROTATION; f++)
		disc32(p, packed, f)[to] = disc32(s, serial, f)[from];
	((index16 *)(packed + p->id))[to] = ((const index16 *)(serial + s->id))[from];
}

static void unpack_disc(const struct rve_model *model, const unsigned char *packed, int from, unsigned char *serial,
						int to)
{
	const struct rve_layout *s = &model->serial, *p = &model->layout;
	for (int axis = 0; axis < 2; axis++) {
		const double place = rve_place(p, packed, from, axis);
		serial_disc(s, serial, DISC_SX + axis)[to] = place;
		disc32(s, serial, DISC32_REF_X + axis)[to] = (real32)(place - rve_way(p, packed, from, axis));
	}
	for (int f = 0; f < 3; f++)
		serial_disc(s, serial, DISC_VX + f)[to] =
			number(p, packed_disc(p, packed, PACKED_VX + f), from) / model->constants.dt;
	for (int f = DISC32_UX; f <= DISC32_ROTATION; f++)
		disc32(s, serial, f)[to] = disc32(p, packed, f)[from];
	((index16 *)(serial + s->id))[to] = ((const index16 *)(packed + p->id))[from];
}

/* What a pair remembers. */
static void pack_pair(const struct rve_model *model, const unsigned char *serial, int from, unsigned char *packed,
					  int to)
{
	const struct rve_layout *s = &model->serial, *p = &model->layout;
	set_number(p, packed + p->ft, to, ((const real *)(serial + s->ft))[from] + 0.0); /* no -0 */
	((real32 *)(packed + p->fd))[to] = ((const real32 *)(serial + s->fd))[from];
	((real32 *)(packed + p->damping))[to] = ((const real32 *)(serial + s->damping))[from];
	packed[p->flag + to] = serial[s->flag + from];
}

static void unpack_pair(const struct rve_model *model, const unsigned char *packed, int from, unsigned char *serial,
						int to)
{
	const struct rve_layout *s = &model->serial, *p = &model->layout;
	((real *)(serial + s->ft))[to] = number(p, packed + p->ft, from);
	((real32 *)(serial + s->fd))[to] = ((const real32 *)(packed + p->fd))[from];
	((real32 *)(serial + s->damping))[to] = ((const real32 *)(packed + p->damping))[from];
	serial[s->flag + to] = packed[p->flag + from];
}

void rve_pack(const struct rve_model *model, const void *serial_state, void *packed_state)
{
	const struct rve_layout *s = &model->serial, *p = &model->layout;
	const unsigned char *serial = serial_state;
	const struct rve_head *head = serial_state;
	unsigned char *packed = packed_state;
	const int lanes = p->lanes, blocks = p->stride / lanes;
	index16 *first = (index16 *)(packed + p->first), *pair_j = (index16 *)(packed + p->pair_j);
	memset(packed, 0, (size_t)p->bytes);
	memcpy(packed, serial, sizeof *head);
	struct rve_head *to = packed_state;
	to->levels = to->entry_levels = 0;
	memset(to->level_rows, 0, sizeof to->level_rows);
	memset(to->level_first, 0, sizeof to->level_first);
	memset(to->entry_first, 0, sizeof to->entry_first);
	for (int i = 0; i < p->n; i++)
		pack_disc(model, serial, i, packed, i);
	for (int i = p->n; i < p->stride; i++)
		((index16 *)(packed + p->id))[i] = (index16)p->n;
	for (int p_slot = 0; p_slot < p->pairs; p_slot++)
		pair_j[p_slot] = (index16)p->stride;
	int sum = 0;
	for (int block = 0; block < blocks; block++) {
		first[block] = (index16)sum;
		for (int level = 0; level < head->levels && head->level_rows[level] > block * lanes; level++)
			sum++;
	}
	first[blocks] = (index16)sum;
	for (int level = 0; level < head->levels; level++)
		for (int i = 0; i < head->level_rows[level]; i++) {
			const int from = head->level_first[level] + i, slot = (first[i / lanes] + level) * lanes + i % lanes;
			pair_j[slot] = ((const index16 *)(serial + s->pair_j))[from];
			pack_pair(model, serial, from, packed, slot);
		}
}

int rve_slot(const struct rve_layout *layout, const void *state, int row, int level)
{
	if (layout->lanes == 0) {
		const struct rve_head *head = state;
		return level < head->levels && row < head->level_rows[level] ? head->level_first[level] + row : -1;
	}
	const unsigned char *bytes = state;
	const index16 *first = (const index16 *)(bytes + layout->first) + row / layout->lanes;
	const int slot = (first[0] + level) * layout->lanes + row % layout->lanes;
	return first[0] + level < first[1] && ((const index16 *)(bytes + layout->pair_j))[slot] != layout->stride ? slot
																											  : -1;
}

double rve_place(const struct rve_layout *layout, const void *state, int row, int axis)
{
	const unsigned char *place = packed_disc(layout, state, PACKED_SX + axis);
	if (!layout->single)
		return ((const real *)place)[row];
	return whole_to_place(place, row) + number(layout, packed_disc(layout, state, PACKED_REST_X + axis), row) / turn;
}

double rve_way(const struct rve_layout *layout, const void *state, int row, int axis)
{
	const real32 *ref = disc32(layout, state, DISC32_REF_X + axis);
	if (!layout->single)
		return rve_place(layout, state, row, axis) - (double)ref[row];
	double way = rve_place(layout, state, row, axis) - whole_to_place(ref, row);
	return way - rint(way);
}

void rve_rotate_velocities(const struct rve_layout *layout, void *state, const double R[4])
{
	unsigned char *vx = packed_disc(layout, state, PACKED_VX), *vy = packed_disc(layout, state, PACKED_VY);
	for (int i = 0; i < layout->n; i++) {
		double x = number(layout, vx, i), y = number(layout, vy, i);
		set_number(layout, vx, i, R[0] * x + R[1] * y);
		set_number(layout, vy, i, R[2] * x + R[3] * y);
	}
}

double rve_tangential(const struct rve_layout *layout, const void *state, int slot)
{
	return number(layout, (const unsigned char *)state + layout->ft, slot);
}

/* How many pairs a row owns. */
static int own_pairs(const struct rve_layout *layout, const void *state, int row)
{
	int own = 0;
	while (rve_slot(layout, state, row, own) >= 0)
		own++;
	return own;
}

/* The rows of the packed state in the serial one's order, those that own most pairs first; and where each has gone. */
static void sort_rows(const struct rve_model *model, const unsigned char *packed, index16 *rows, index16 *place)
{
	int n = 0;
	for (int own = model->serial.levels; own >= 0; own--)
		for (int i = 0; i < model->layout.n; i++)
			if (own_pairs(&model->layout, packed, i) == own) {
				rows[n] = (index16)i;
				place[i] = (index16)n++;
			}
}

/* Pairs, level by level; 0 if there is no room for them. */
static int unpack_pairs(const struct rve_model *model, const unsigned char *packed, unsigned char *serial,
						const index16 *rows, const index16 *place)
{
	const struct rve_layout *s = &model->serial, *p = &model->layout;
	const index16 *pair_j = (const index16 *)(packed + p->pair_j);
	struct rve_head *head = (struct rve_head *)serial;
	int sum = 0;
	for (int level = 0; level <= s->levels; level++) {
		head->level_first[level] = (index16)sum;
		int count = 0;
		while (count < p->n && own_pairs(p, packed, rows[count]) > level)
			count++;
		if (count == 0)
			return 1;
		const int padded = (count + ROW_PAD - 1) / ROW_PAD * ROW_PAD;
		if (level == s->levels || sum + padded > s->pairs)
			return 0;
		for (int row = 0; row < padded; row++) {
			const int slot = row < count ? rve_slot(p, packed, rows[row], level) : -1;
			((index16 *)(serial + s->pair_j))[sum + row] = slot < 0 ? (index16)s->n : place[pair_j[slot]];
			if (slot >= 0)
				unpack_pair(model, packed, slot, serial, sum + row);
		}
		head->level_rows[level] = (index16)count;
		head->levels = level + 1;
		sum += padded;
	}
	return 0;
}

/* The slots whose j a disc is: entries_write().  `degree`: room for n numbers. */
static void write_entries(const struct rve_layout *s, unsigned char *serial, index16 *degree)
{
	struct rve_head *head = (struct rve_head *)serial;
	index16 *entry = (index16 *)(serial + s->entry);
	memset(degree, 0, sizeof *degree * (size_t)s->n);
	head->entry_levels = 0;
	for (int k = 0; k < s->levels * s->stride; k++)
		entry[k] = (index16)s->pairs;
	for (int level = 0; level < head->levels; level++)
		for (int i = 0; i < head->level_rows[level]; i++) {
			const int slot = head->level_first[level] + i, j = ((const index16 *)(serial + s->pair_j))[slot];
			entry[degree[j]++ * s->stride + j] = (index16)slot;
			head->entry_levels = degree[j] > head->entry_levels ? degree[j] : head->entry_levels;
		}
	for (int level = 0; level < head->entry_levels; level++) {
		int first = 0;
		while (degree[first] <= level)
			first++;
		head->entry_first[level] = (index16)(first / ROW_PAD * ROW_PAD);
	}
}

/* `rows`: room for 2 n numbers.  0 if the serial state has no room for so many neighbours. */
static int unpack(const struct rve_model *model, const unsigned char *packed, unsigned char *serial, index16 *rows)
{
	const struct rve_layout *s = &model->serial;
	memset(serial, 0, (size_t)s->bytes);
	memcpy(serial, packed, sizeof(struct rve_head));
	sort_rows(model, packed, rows, rows + s->n);
	for (int i = 0; i < s->n; i++)
		unpack_disc(model, packed, rows[i], serial, i);
	for (int i = s->n; i < s->stride; i++)
		((index16 *)(serial + s->id))[i] = (index16)s->n;
	if (!unpack_pairs(model, packed, serial, rows, rows + s->n))
		return 0;
	write_entries(s, serial, rows);
	return 1;
}

int rve_convert(const struct rve_model *model, int n, const unsigned char *states, const struct rve_model *to,
				unsigned char *converted)
{
	unsigned char *between = aligned_alloc(64, (size_t)model->serial.bytes);
	index16 *rows = malloc(2 * sizeof *rows * (size_t)model->serial.n);
	int status = between && rows ? STATUS_OK : error_set(STATUS_RESOURCE, "out of memory for converting RVEs");
	for (int k = 0; k < n && status == STATUS_OK; k++) {
		const unsigned char *state = states + (size_t)k * (size_t)model->layout.bytes;
		unsigned char *out = converted + (size_t)k * (size_t)to->layout.bytes;
		unsigned char *serial = to->packed ? between : out;
		if (!model->packed)
			memcpy(serial, state, (size_t)model->serial.bytes);
		else if (!unpack(model, state, serial, rows))
			status = error_set(STATUS_INPUT, "RVE %d has more neighbours than the path \"serial\" has room for", k);
		if (to->packed && status == STATUS_OK)
			rve_pack(to, serial, out);
	}
	free(between);
	free(rows);
	return status;
}
