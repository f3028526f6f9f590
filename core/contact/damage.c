/* The faces of cracks: where a body that breaks has two fields at a node (DP-MPM section 3.2; Homel and Herbold 2017).
 *
 * Damage d of the points is smoothed, D = sum V d w / sum V w with w = 1 - 3 r^2 + 2 r^3 over the diagonal of a cell.
 * Its gradient points from either side to a crack between them.  Of the points that touch a node the one with the
 * largest gradient tells the direction; a point whose own gradient goes against it is on the other side.  The node has
 * a field for each side when it is separable: a point is broken, and the mean damage on both sides is above
 * SEPARABLE_MEAN.
 *
 * Points hardly move in a few steps, so gradients are looked at every GRADIENT_STEPS only, and kept with the points.
 * Labels keep bodies apart, whatever their damage; two free faces of one body that meet, without a crack between them,
 * are welded. */
#include <math.h>
#include <string.h>

#include "contact/private.h"

enum { GRADIENT_STEPS = 8 };
static const double DAMAGED = 1e-9; /* less is none */
static const double SEPARABLE_MEAN = 0.25;

/* ---- smoothed damage ---- */

/* Cells in which a point is damaged, and those beside them as far as the kernel reaches.  False if there are none. */
static bool find_hot_cells(const struct mpm *mpm, struct contact *c)
{
	const struct mpm_work *w = mpm_work(mpm);
	memset(c->hot, 0, (size_t)w->cells_x * (size_t)w->cells_y * sizeof *c->hot);
	bool any = false;
	for (int cell = 0; cell < w->cells_x * w->cells_y; cell++) {
		bool damaged = false;
		for (int k = w->cell_first[cell]; k < w->cell_first[cell + 1] && !damaged; k++)
			damaged = mpm->p.damage[w->order[k]] > DAMAGED && c->own[c->label[mpm->p.body[w->order[k]]]] >= 0;
		if (!damaged)
			continue;
		int i = cell % w->cells_x, j = cell / w->cells_x;
		any = true;
		for (int b = j < 2 ? 0 : j - 2; b <= j + 2 && b < w->cells_y; b++)
			for (int a = i < 2 ? 0 : i - 2; a <= i + 2 && a < w->cells_x; a++)
				c->hot[b * w->cells_x + a] = true;
	}
	return any;
}

/* Sums of the kernel about a point, over the points of its body. */
static void gradient_at(const struct mpm *mpm, const struct contact *c, int q, double gradient[2])
{
	const struct mpm_work *w = mpm_work(mpm);
	const struct particles *p = &mpm->p;
	const double radius2 = 2.0 * mpm->grid.h * mpm->grid.h, inverse2 = 1.0 / radius2;
	int i = w->cell[q] % w->cells_x, j = w->cell[q] / w->cells_x, label = c->label[p->body[q]];
	int low = i < 2 ? 0 : i - 2, high = i + 2 > w->cells_x - 1 ? w->cells_x - 1 : i + 2;
	double D = 0.0, S = 0.0, gD[2] = {0.0, 0.0}, gS[2] = {0.0, 0.0};
	for (int b = j < 2 ? 0 : j - 2; b <= j + 2 && b < w->cells_y; b++)
		for (int k = w->cell_first[b * w->cells_x + low]; k < w->cell_first[b * w->cells_x + high + 1]; k++) {
			int o = w->order[k];
			double x = p->x[q][0] - p->x[o][0], y = p->x[q][1] - p->x[o][1], r2 = (x * x + y * y) * inverse2;
			if (r2 >= 1.0 || c->label[p->body[o]] != label)
				continue;
			double r = sqrt(r2), V = p->volume0[o], weight = V * (1.0 - r2 * (3.0 - 2.0 * r)),
				   slope = V * 6.0 * (r - 1.0) * inverse2, d = p->damage[o];
			S += weight, D += weight * d;
			gS[0] += slope * x, gS[1] += slope * y;
			gD[0] += slope * x * d, gD[1] += slope * y * d;
		}
	D /= S;
	for (int a = 0; a < 2; a++)
		gradient[a] = (gD[a] - D * gS[a]) / S;
}

void contact_find_gradients(struct mpm *mpm)
{
	const struct mpm_work *w = mpm_work(mpm);
	struct contact *c = w->contact;
	struct particles *p = &mpm->p;
	if (!c->cracks || mpm->step % GRADIENT_STEPS != 0)
		return;
	memset(p->damage_gradient, 0, (size_t)p->n * sizeof *p->damage_gradient);
	if (!find_hot_cells(mpm, c))
		return;
#pragma omp parallel for schedule(dynamic, BLOCK_POINTS) if (mpm_parallel(mpm))
	for (int k = 0; k < w->n_inside; k++) {
		int q = w->order[k];
		if (c->hot[w->cell[q]] && c->own[c->label[p->body[q]]] >= 0)
			gradient_at(mpm, c, q, p->damage_gradient[q]);
	}
}

/* ---- the sides of a node ---- */

/* Calls for each point of a body that a node can feel. */
#define FOR_POINTS_ABOUT(mpm, w, low, high, q)                                                                         \
	for (int row_ = (low)[1]; row_ <= (high)[1]; row_++)                                                               \
		for (int k_ = (w)->cell_first[row_ * (w)->cells_x + (low)[0]], q;                                              \
			 k_ < (w)->cell_first[row_ * (w)->cells_x + (high)[0] + 1] && ((q = (w)->order[k_]), true); k_++)

/* What a point counts for at a node: a hat over its reach; 0 if the node does not feel it.  The means that are made
 * with it are compared with a coarse bound: its true weight would cost more than it is worth. */
static double share(const struct mpm *mpm, int i, int j, int q)
{
	const struct mpm_work *w = mpm_work(mpm);
	const struct grid *grid = &mpm->grid;
	double support = mpm->shape->support(w->half[mpm->p.body[q]], mpm->p.F[q]);
	double x = 1.0 - fabs(mpm->p.x[q][0] - grid->origin[0] - i * grid->spacing[0]) / (support * grid->spacing[0]),
		   y = 1.0 - fabs(mpm->p.x[q][1] - grid->origin[1] - j * grid->spacing[1]) / (support * grid->spacing[1]);
	return x > 0.0 && y > 0.0 ? x * y : 0.0;
}

/* Has a crack come through between both sides of a node (eqs. 70, 71)? */
static bool separable(const struct mpm *mpm, const struct contact *c, int i, int j, int label,
					  const double direction[2])
{
	const struct mpm_work *w = mpm_work(mpm);
	const struct particles *p = &mpm->p;
	double mass[2] = {0.0, 0.0}, damage[2] = {0.0, 0.0};
	int low[2], high[2];
	bool broken = false;
	contact_cells_about(mpm, i, j, low, high);
	FOR_POINTS_ABOUT(mpm, w, low, high, q)
	{
		double m = c->label[p->body[q]] == label ? share(mpm, i, j, q) * p->mass[q] : 0.0;
		int side = contact_side(direction, p->damage_gradient[q]);
		mass[side] += m, damage[side] += m * p->damage[q];
		broken = broken || (m > 0.0 && p->damage[q] >= CONTACT_BROKEN);
	}
	return broken && mass[0] > 0.0 && mass[1] > 0.0 && damage[0] > SEPARABLE_MEAN * mass[0] &&
		   damage[1] > SEPARABLE_MEAN * mass[1];
}

bool contact_sides(const struct mpm *mpm, const struct contact *c, int i, int j, int label, double direction[2])
{
	const struct mpm_work *w = mpm_work(mpm);
	const struct particles *p = &mpm->p;
	int low[2], high[2], first = -1;
	double most = 0.0;
	direction[0] = direction[1] = 0.0;
	if (c->own[label] < 0)
		return false;
	contact_cells_about(mpm, i, j, low, high);
	bool near = false;
	for (int b = low[1]; b <= high[1]; b++)
		for (int a = low[0]; a <= high[0]; a++)
			near = near || c->broken[b * w->cells_x + a];
	if (!near)
		return false;
	FOR_POINTS_ABOUT(mpm, w, low, high, q)
	{
		double g2 =
			p->damage_gradient[q][0] * p->damage_gradient[q][0] + p->damage_gradient[q][1] * p->damage_gradient[q][1];
		/* of equal ones that which was born first: storage must not decide */
		if (g2 > 0.0 && (g2 > most || (g2 == most && p->id[q] < p->id[first])) && c->label[p->body[q]] == label &&
			share(mpm, i, j, q) > 0.0)
			most = g2, first = q;
	}
	if (first < 0)
		return false;
	memcpy(direction, p->damage_gradient[first], 2 * sizeof *direction);
	return separable(mpm, c, i, j, label, direction);
}
