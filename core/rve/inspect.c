/* What an RVE looks like inside, for pictures, files and packings. */
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "rve/model.h"

/* Cell coordinates between 0 and 1. */
static double wrapped(double s)
{
	double w = s - floor(s);
	return w < 1.0 ? w : 0.0;
}

static void inspect_disc(const struct rve_model *model, const unsigned char *state, int row, struct rve_disc *disc)
{
	const struct rve_layout *layout = &model->layout;
	const struct rve_head *head = (const struct rve_head *)state;
	const real32 *t = (const real32 *)(state + layout->disc32) + row;
	double x = wrapped(rve_place(layout, state, row, 0)), y = wrapped(rve_place(layout, state, row, 1));
	double qx = rve_way(layout, state, row, 0), qy = rve_way(layout, state, row, 1);
	const double *H = head->H;
	disc->x = H[0] * x + H[1] * y;
	disc->y = H[2] * x + H[3] * y;
	disc->radius = model->variants[head->variant]
					   .table[TABLE_R * model->serial.stride + ((const index16 *)(state + layout->id))[row]] *
				   (1.0 + model->params.expansion * head->temperature);
	disc->displacement[0] = (double)t[DISC32_UX * layout->stride] + H[0] * qx + H[1] * qy;
	disc->displacement[1] = (double)t[DISC32_UY * layout->stride] + H[2] * qx + H[3] * qy;
	disc->rotation = (double)t[DISC32_ROTATION * layout->stride];
	disc->contacts = 0;
}

/* From the disc in row i to the nearest image of the one in row j, m, and that image's shift. */
static void inspect_branch(const struct rve_model *model, const unsigned char *state, int i, int j, int shift[2],
						   double *bx, double *by)
{
	const struct rve_layout *layout = &model->layout;
	const double *H = ((const struct rve_head *)state)->H;
	double sx = wrapped(rve_place(layout, state, j, 0)) - wrapped(rve_place(layout, state, i, 0));
	double sy = wrapped(rve_place(layout, state, j, 1)) - wrapped(rve_place(layout, state, i, 1));
	double kx = -rint(sx), ky = -rint(sy);
	*bx = H[0] * (sx + kx) + H[1] * (sy + ky), *by = H[2] * (sx + kx) + H[3] * (sy + ky);
	shift[0] = (int)kx, shift[1] = (int)ky;
}

/* How near an intact bond is to breaking below T_c. */
static double bond_load(const struct rve_model *model, double normal, double tangential, double radii)
{
	double bears = model->constants.bond_force * radii;
	return fmin(1.0, fmax(-normal / bears, fabs(tangential) / (model->constants.bond_mu * bears)));
}

int rve_inspect_slot(const struct rve_model *model, const unsigned char *state, int i, int p,
					 struct rve_contact *contact)
{
	const struct rve_layout *layout = &model->layout;
	const struct rve_head *head = (const struct rve_head *)state;
	const index16 *id = (const index16 *)(state + layout->id);
	int j = ((const index16 *)(state + layout->pair_j))[p];
	if (id[i] > id[j]) {
		int swap = i;
		i = j, j = swap;
	}
	struct rve_disc a, b;
	inspect_disc(model, state, i, &a);
	inspect_disc(model, state, j, &b);
	double bx, by;
	inspect_branch(model, state, i, j, contact->shift, &bx, &by);
	double overlap = a.radius + b.radius - sqrt(bx * bx + by * by);
	int bond = head->bonds_installed > 0 ? state[layout->flag + p] : BOND_NONE;
	if (!(overlap > 0.0) && bond != BOND_INTACT)
		return 0;
	double normal = model->params.kn * overlap + (double)((const real32 *)(state + layout->fd))[p];
	normal = bond == BOND_INTACT ? normal : fmax(0.0, normal);
	double tangential = rve_tangential(layout, state, p), cap = model->params.mu * normal;
	contact->i = id[i];
	contact->j = id[j];
	contact->ends[0][0] = a.x, contact->ends[0][1] = a.y;
	contact->ends[1][0] = a.x + bx, contact->ends[1][1] = a.y + by;
	contact->normal_force = normal;
	contact->tangential_force = tangential;
	contact->bond = bond;
	if (bond == BOND_INTACT) {
		contact->mobilisation = bond_load(model, model->params.kn * overlap, tangential, a.radius + b.radius);
		contact->sliding = 0;
		return 1;
	}
	contact->mobilisation = cap > 0.0 ? fmin(1.0, fabs(tangential) / cap) : 0.0;
	contact->sliding =
		cap > 0.0 && fabs(tangential) >= cap * (1.0 - 1e-6); /* the dashpot's part is kept in single precision */
	return 1;
}

int rve_inspect(const struct rve_model *model, const void *state, struct rve_disc *discs, struct rve_contact *contacts,
				int capacity)
{
	const unsigned char *bytes = state;
	const index16 *id = (const index16 *)(bytes + model->layout.id);
	int n = 0;
	for (int i = 0; discs && i < model->layout.n; i++)
		inspect_disc(model, bytes, i, &discs[id[i]]);
	for (int level = 0; level < model->layout.levels; level++)
		for (int row = 0; row < model->layout.n; row++) {
			struct rve_contact contact;
			const int slot = rve_slot(&model->layout, state, row, level);
			if (slot < 0 || !rve_inspect_slot(model, bytes, row, slot, &contact))
				continue;
			if (discs) {
				discs[contact.i].contacts++;
				discs[contact.j].contacts++;
			}
			if (contacts && n < capacity)
				contacts[n] = contact;
			n++;
		}
	return contacts && n > capacity ? capacity : n;
}

/* Fills a broken bond between discs that do not touch (any more); 0 if the slot holds none. */
static int inspect_parted_slot(const struct rve_model *model, const unsigned char *state, int i, int p,
							   struct rve_contact *contact)
{
	const struct rve_layout *layout = &model->layout;
	const struct rve_head *head = (const struct rve_head *)state;
	const index16 *id = (const index16 *)(state + layout->id);
	int j = ((const index16 *)(state + layout->pair_j))[p];
	struct rve_disc a, b;
	if (head->bonds_installed == 0 || state[layout->flag + p] != BOND_BROKEN)
		return 0;
	inspect_disc(model, state, i, &a);
	inspect_disc(model, state, j, &b);
	double bx, by;
	inspect_branch(model, state, i, j, contact->shift, &bx, &by);
	if (a.radius + b.radius > hypot(bx, by))
		return 0;
	contact->i = id[i], contact->j = id[j], contact->bond = BOND_BROKEN;
	contact->ends[0][0] = a.x, contact->ends[0][1] = a.y;
	contact->ends[1][0] = a.x + bx, contact->ends[1][1] = a.y + by;
	contact->normal_force = contact->tangential_force = contact->mobilisation = 0.0;
	contact->sliding = 0;
	return 1;
}

int rve_inspect_parted(const struct rve_model *model, const void *state, struct rve_contact *contacts, int capacity)
{
	int n = 0;
	for (int level = 0; level < model->layout.levels; level++)
		for (int row = 0; row < model->layout.n && n < capacity; row++) {
			const int slot = rve_slot(&model->layout, state, row, level);
			n += slot >= 0 && inspect_parted_slot(model, state, row, slot, &contacts[n]);
		}
	return n;
}

int rve_contact_capacity(const struct rve_model *model) { return model->layout.pairs; }

/* FNV-1a */
static uint64_t hash_bytes(uint64_t hash, const void *data, size_t size)
{
	const unsigned char *byte = data;
	for (size_t k = 0; k < size; k++)
		hash = (hash ^ byte[k]) * UINT64_C(1099511628211);
	return hash;
}

unsigned long long rve_packings_hash(const struct rve_model *model)
{
	uint64_t hash = UINT64_C(14695981039346656037);
	for (int v = 0; v < model->n_variants; v++) {
		hash = hash_bytes(hash, model->variants[v].table + TABLE_R * model->serial.stride,
						  sizeof(real) * (size_t)model->layout.n);
		hash = hash_bytes(hash, model->variants[v].serial_start, (size_t)model->serial.bytes);
	}
	return hash;
}
