/* The order of the points by grid cell, and the part of the grid that they use. */
#include <string.h>

#include "mpm/mpm_private.h"

int mpm_cell_of(const struct mpm_work *w, const double x[2])
{
	const double *s = w->shape_grid.inverse_h;
	double fx = (x[0] - w->shape_grid.origin[0]) * s[0], fy = (x[1] - w->shape_grid.origin[1]) * s[1];
	if (!(fx >= GHOST_CELLS && fy >= GHOST_CELLS && fx <= w->cells_x - GHOST_CELLS && fy <= w->cells_y - GHOST_CELLS))
		return -1;
	return (int)fy * w->cells_x + (int)fx;
}

/* Columns of nodes that row j of grid cells needs: low > high if it is empty. */
static void cell_row_extent(const struct mpm_work *w, int j, int *low, int *high)
{
	const int *first = w->cell_first + j * w->cells_x;
	*low = 1, *high = 0;
	if (first[0] == first[w->cells_x])
		return;
	int a = 0, b = w->cells_x - 1;
	while (first[a + 1] == first[0])
		a++;
	while (first[b] == first[w->cells_x])
		b--;
	*low = a, *high = b;
}

static void find_active_nodes(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	int nx = mpm->grid.nx, ny = mpm->grid.ny, reach = mpm->shape->reach;
	for (int j = 0; j < ny; j++)
		w->row_low[j] = nx, w->row_high[j] = -1;
	for (int j = 0; j < w->cells_y; j++) {
		int low, high;
		cell_row_extent(w, j, &low, &high);
		if (low > high)
			continue;
		low = low - reach < 0 ? 0 : low - reach;
		high = high + 1 + reach > nx - 1 ? nx - 1 : high + 1 + reach;
		int from = j - reach < 0 ? 0 : j - reach, to = j + 1 + reach > ny - 1 ? ny - 1 : j + 1 + reach;
		for (int row = from; row <= to; row++) {
			w->row_low[row] = low < w->row_low[row] ? low : w->row_low[row];
			w->row_high[row] = high > w->row_high[row] ? high : w->row_high[row];
		}
	}
}

/* Counting sort: points of one cell stay in storage order, so the result depends on nothing else. */
void mpm_sort(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	const struct particles *p = &mpm->p;
	int cells = w->cells_x * w->cells_y;
	int *first = w->cell_first;
	memset(first, 0, ((size_t)cells + 1) * sizeof *first);
	for (int k = 0; k < p->n; k++) {
		int c = mpm_cell_of(w, p->x[k]);
		w->cell[k] = c;
		if (c >= 0)
			first[c]++;
	}
	int sum = 0;
	for (int c = 0; c < cells; c++) {
		int count = first[c];
		first[c] = sum;
		sum += count;
	}
	for (int k = 0; k < p->n; k++)
		if (w->cell[k] >= 0)
			w->order[first[w->cell[k]]++] = k;
	/* every entry has moved to its cell's end: move them back */
	memmove(first + 1, first, (size_t)cells * sizeof *first);
	first[0] = 0;
	w->n_inside = sum;
	w->n_blocks = (sum + BLOCK_POINTS - 1) / BLOCK_POINTS;
	find_active_nodes(mpm);
}

void mpm_resort_storage(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	struct particles *p = &mpm->p;
	int next[mpm->n_laws + 1]; /* the points of a law stay together: its batch is a piece of every array */
	memcpy(next, w->law_start, (size_t)mpm->n_laws * sizeof *next);
	for (int i = 0; i < w->n_inside; i++)
		w->permutation[next[p->law[w->order[i]]]++] = w->order[i];
	for (int k = 0; k < p->n; k++)
		if (w->cell[k] < 0)
			w->permutation[next[p->law[k]]++] = k;
	bool same = true;
	for (int k = 0; k < p->n && same; k++)
		same = w->permutation[k] == k;
	if (same)
		return;
	particles_permute(p, w->permutation, w->scratch);
	mpm_sort(mpm);
}
