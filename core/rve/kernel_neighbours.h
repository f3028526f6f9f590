/* The list of pairs that may touch.  Included by kernel.h only.
 *
 * Pairs are those nearer than r_i + r_j + skin when the list is built, sorted by i, then j, i < j.  The list
 * is right while sigma_min(H H_ref^-1) (2 r_max + skin) - 2 u_max >= 2 r_max, u_max being the largest
 * non-affine displacement since: the bound holds for every pair, since with sigma_min <= 1 (a larger one counts as 1) the largest radii lose most.   The nearest image of a
 * pair in reach is unique while the cell is at least 2 (2 r_max + skin) wide. */

BLOCKFN int neighbours_valid(const struct rve_place *at)
{
	SHARED struct rve_block *block = at->block;
	SHARED real *displacement = block->lanes[LANE_DISPLACEMENT];
	for (int width = LANES / 2; width > 0; width /= 2) {
		FOR_THREADS(lane, width) displacement[lane] = real_max(displacement[lane + width], displacement[lane]);
		SYNC();
	}
	const real r_max = at->constants->r_max;
	real stretch = real_min(cell_least_stretch(block->head.H, block->head.H_ref), 1.0);
	real reach = stretch * (2.0 * r_max * block->head.scale_ref + at->constants->skin);
	return reach - 2.0 * real_sqrt(displacement[0]) >= 2.0 * r_max * block->scale;
}

/* Ends the stretch of motion since the last build: its displacement is booked, the cell reduced. */
BLOCKFN void neighbours_rebase(const struct rve_place *at)
{
	SHARED struct rve_block *block = at->block;
	const real hxx = block->head.H[0], hxy = block->head.H[1], hyx = block->head.H[2], hyy = block->head.H[3];
	LOCAL real *sx = WORK_DISC(WORK_SX), *sy = WORK_DISC(WORK_SY);
	GLOBAL real32 *ref_x = STATE_DISC32(DISC32_REF_X), *ref_y = STATE_DISC32(DISC32_REF_Y);
	GLOBAL real32 *ux = STATE_DISC32(DISC32_UX), *uy = STATE_DISC32(DISC32_UY);
	const real moved = at->call->rebuild ? 0.0 : 1.0;
	real T[4], H[4] = {hxx, hxy, hyx, hyy};
	cell_reduce(H, T);
	SYNC();
	FOR_THREADS(i, at->layout->n)
	{
		real qx = (sx[i] - (real)ref_x[i]) * moved, qy = (sy[i] - (real)ref_y[i]) * moved;
		ux[i] += (real32)(hxx * qx + hxy * qy);
		uy[i] += (real32)(hyx * qx + hyy * qy);
		real x = T[0] * sx[i] + T[1] * sy[i], y = T[2] * sx[i] + T[3] * sy[i];
		x -= real_nearest(x), y -= real_nearest(y);
		sx[i] = x < 0.0 ? x + 1.0 : x;
		sy[i] = y < 0.0 ? y + 1.0 : y;
		ref_x[i] = (real32)sx[i];
		ref_y[i] = (real32)sy[i];
	}
	ONE_THREAD {
		for (int k = 0; k < 4; k++)
			block->head.H[k] = block->head.H_ref[k] = H[k];
		cell_invert(block->head.H, block->H_inv);
		block->head.scale_ref = block->scale;
		block->head.rebuilds++;
	}
	SYNC();
}

THREADFN int clamp_cell(real x, int cells)
{
	return (int)real_min(real_max(x, 0.0), (real)(cells - 1)); /* also where x is not a number */
}

/* Discs sorted into the cells of a grid, cells at least one reach wide, by counting. */
BLOCKFN void neighbours_sort(const struct rve_place *at)
{
	SHARED struct rve_block *block = at->block;
	LOCAL const real *sx = WORK_DISC(WORK_SX), *sy = WORK_DISC(WORK_SY);
	LOCAL int *cell = WORK_DISC_INDEX(WORK_CELL), *sorted = WORK_DISC_INDEX(WORK_SORTED);
	LOCAL int *start = at->cell_start;
	ONE_THREAD {
		SHARED real *H = block->head.H;
		real reach = 2.0 * at->constants->r_max * block->scale + at->constants->skin;
		real area = H[0] * H[3] - H[1] * H[2];
		real width_x = area / real_sqrt(H[1] * H[1] + H[3] * H[3]), width_y = area / real_sqrt(H[0] * H[0] + H[2] * H[2]);
		block->grid[0] = 1 + clamp_cell(width_x / reach - 1.0, at->layout->grid);
		block->grid[1] = 1 + clamp_cell(width_y / reach - 1.0, at->layout->grid);
	}
	SYNC();
	const int nx = block->grid[0], ny = block->grid[1];
	FOR_THREADS(i, at->layout->n) cell[i] = clamp_cell(sy[i] * ny, ny) * nx + clamp_cell(sx[i] * nx, nx);
	SYNC();
	ONE_THREAD {
		for (int c = 0; c <= nx * ny; c++)
			start[c] = 0;
		for (int i = 0; i < at->layout->n; i++)
			start[cell[i]]++;
		for (int c = 0, sum = 0; c <= nx * ny; c++) {
			int count = start[c];
			start[c] = sum;
			sum += count;
		}
		for (int i = 0; i < at->layout->n; i++)
			sorted[start[cell[i]]++] = i; /* start[c] becomes the end of c = the start of c + 1 */
	}
	SYNC();
}

/* All neighbours of disc i, ascending.  Returns how many, or -1 if there are too many. */
THREADFN int neighbours_find(const struct rve_place *at, int i, LOCAL index16 *list)
{
	SHARED const struct rve_block *block = at->block;
	const int nx = block->grid[0], ny = block->grid[1], capacity = at->layout->levels;
	LOCAL const real *sx = WORK_DISC(WORK_SX), *sy = WORK_DISC(WORK_SY);
	GLOBAL const real *radius = TABLE(TABLE_R);
	LOCAL const int *sorted = WORK_DISC_INDEX(WORK_SORTED), *end = at->cell_start;
	const int c = WORK_DISC_INDEX(WORK_CELL)[i], cx = c % nx, cy = c / nx;
	const int columns = nx < 3 ? nx : 3, rows = ny < 3 ? ny : 3;
	const real hxx = block->head.H[0], hxy = block->head.H[1], hyx = block->head.H[2], hyy = block->head.H[3];
	const real x = sx[i], y = sy[i], scale = block->scale, reach = radius[i] * scale + at->constants->skin;
	int found = 0;
	for (int row = 0; row < rows; row++) {
		int gy = ny < 3 ? row : cy + row - 1;
		gy = gy < 0 ? ny - 1 : gy == ny ? 0 : gy;
		for (int column = 0; column < columns; column++) {
			int gx = nx < 3 ? column : cx + column - 1;
			gx = gx < 0 ? nx - 1 : gx == nx ? 0 : gx;
			const int g = gy * nx + gx;
			for (int k = g > 0 ? end[g - 1] : 0; k < end[g]; k++) {
				const int j = sorted[k];
				real ax = sx[j] - x, ay = sy[j] - y;
				ax -= real_nearest(ax);
				ay -= real_nearest(ay);
				real bx = hxx * ax + hxy * ay, by = hyx * ax + hyy * ay;
				real cut = reach + radius[j] * scale;
				if (!(bx * bx + by * by < cut * cut) || j == i)
					continue;
				if (found == capacity)
					return -1;
				int place = found++;
				for (; place > 0 && list[place - 1] > j; place--)
					list[place] = list[place - 1];
				list[place] = (index16)j;
			}
		}
	}
	return found;
}

/* Where the pairs of each disc (as i) begin in the old list; a copy of what pairs remember. */
BLOCKFN void history_keep(const struct rve_place *at)
{
	SHARED struct rve_block *block = at->block;
	const int n_pairs = block->head.n_pairs;
	LOCAL const int *pair_i = WORK_PAIR_INDEX(WORK_I), *pair_j = WORK_PAIR_INDEX(WORK_J);
	LOCAL int *first = WORK_DISC_INDEX(WORK_FIRST_OLD), *old_j = WORK_PAIR_INDEX(WORK_J_OLD);
	LOCAL real *old_ft = WORK_PAIR(WORK_PX), *old_fd = WORK_PAIR(WORK_PY), *old_flag = WORK_PAIR(WORK_TI);
	FOR_THREADS(p, n_pairs)
	{
		old_j[p] = pair_j[p];
		old_ft[p] = WORK_PAIR(WORK_FT)[p];
		old_fd[p] = (real)STATE_FD[p];
		old_flag[p] = (real)STATE_FLAG[p];
	}
	ONE_THREAD {
		for (int i = 0, p = 0; i <= at->layout->n; i++) {
			first[i] = p;
			while (p < n_pairs && pair_i[p] == i)
				p++;
		}
		block->n_pairs_old = n_pairs;
	}
	SYNC();
}

/* Writes the pairs of disc i (those with j > i) with what they remember. */
THREADFN void pairs_write(const struct rve_place *at, int i)
{
	const struct rve_constants *constants = at->constants;
	LOCAL const index16 *list = at->neighbours + (long)i * at->layout->levels;
	LOCAL const int *first_old = WORK_DISC_INDEX(WORK_FIRST_OLD), *old_j = WORK_PAIR_INDEX(WORK_J_OLD);
	GLOBAL const real *mass = TABLE(TABLE_MASS);
	const int degree = WORK_DISC_INDEX(WORK_DEGREE)[i];
	int p = WORK_DISC_INDEX(WORK_FIRST)[i], old = first_old[i];
	const int old_end = first_old[i + 1];
	for (int k = 0; k < degree; k++) {
		const int j = list[k];
		if (j < i)
			continue;
		while (old < old_end && old_j[old] < j)
			old++;
		const int known = old < old_end && old_j[old] == j;
		WORK_PAIR_INDEX(WORK_I)[p] = i;
		WORK_PAIR_INDEX(WORK_J)[p] = j;
		STATE_I[p] = (index16)i;
		STATE_J[p] = (index16)j;
		WORK_PAIR(WORK_FT)[p] = known ? WORK_PAIR(WORK_PX)[old] : 0.0;
		STATE_FD[p] = known ? (real32)WORK_PAIR(WORK_PY)[old] : 0.0f;
		STATE_FLAG[p] = known ? (unsigned char)WORK_PAIR(WORK_TI)[old] : 0;
		STATE_DAMPING[p] = (real32)(constants->damping * real_sqrt(mass[i] * mass[j] / (mass[i] + mass[j])));
		p++;
	}
}

/* Where the slots of disc i's pairs are: entry[level][i]. */
THREADFN void entries_write(const struct rve_place *at, int i)
{
	LOCAL const index16 *list = at->neighbours + (long)i * at->layout->levels;
	LOCAL const int *first = WORK_DISC_INDEX(WORK_FIRST), *pair_j = WORK_PAIR_INDEX(WORK_J);
	const int degree = WORK_DISC_INDEX(WORK_DEGREE)[i];
	int mine = first[i];
	for (int k = 0; k < at->block->head.levels; k++) {
		int e = at->layout->pairs; /* the slot of no force */
		if (k < degree && list[k] > i)
			e = mine++;
		if (k < degree && list[k] < i) {
			int p = first[list[k]];
			while (pair_j[p] != i)
				p++;
			e = p | ENTRY_J;
		}
		STATE_ENTRY(k)[i] = (index16)e;
	}
}

/* A new list for the configuration as it is.  Sets block->status if the cell has become too slender or
 * crowded for one. */
BLOCKFN void neighbours_build(const struct rve_place *at)
{
	SHARED struct rve_block *block = at->block;
	const int n = at->layout->n;
	LOCAL int *degree = WORK_DISC_INDEX(WORK_DEGREE), *first = WORK_DISC_INDEX(WORK_FIRST);
	history_keep(at);
	neighbours_rebase(at);
	real reach = 2.0 * at->constants->r_max * block->scale + at->constants->skin;
	if (!(cell_least_width(block->head.H) >= 2.0 * reach)) {
		ONE_THREAD block->status = KERNEL_SLENDER;
		SYNC();
		return;
	}
	neighbours_sort(at);
	FOR_THREADS(i, n) degree[i] = neighbours_find(at, i, at->neighbours + (long)i * at->layout->levels);
	SYNC();
	ONE_THREAD {
		int pairs = 0, levels = 0;
		for (int k = 0; k < at->layout->levels; k++)
			block->head.level_discs[k] = 0;
		for (int i = 0; i < n; i++) {
			LOCAL const index16 *list = at->neighbours + (long)i * at->layout->levels;
			first[i] = pairs;
			for (int k = 0; k < degree[i]; k++) {
				pairs += list[k] > i;
				block->head.level_discs[k] = (index16)(i + 1);
			}
			levels = degree[i] > levels ? degree[i] : levels;
			if (degree[i] < 0)
				block->status = KERNEL_CROWDED;
		}
		if (pairs > at->layout->pairs)
			block->status = KERNEL_CROWDED;
		block->head.n_pairs = pairs;
		block->head.levels = levels;
	}
	SYNC();
	if (block->status != KERNEL_OK)
		return;
	FOR_THREADS(i, n) pairs_write(at, i);
	SYNC();
	FOR_THREADS(i, n) entries_write(at, i);
	for (int f = WORK_PX; f <= WORK_TJ; f++)
		ONE_THREAD WORK_PAIR(f)[at->layout->pairs] = 0.0;
	SYNC();
}
