/* The list of pairs that may touch.  Included by kernel.h only.
 *
 * Pairs are those nearer than r_i + r_j + skin when the list is built, sorted by i, then j, i < j.  The list
 * is right while sigma_min(H H_ref^-1) (2 r_max + skin) - 2 u_max >= 2 r_max, u_max being the largest
 * non-affine displacement since.  That bound holds for every pair if the largest radii lose most by it: so a
 * sigma_min above 1 counts as 1, and radii that shrink by cooling count as if they did not.  The nearest image of
 * a pair in reach is unique while the cell is at least 2 (2 r_max + skin) wide. */

BLOCKFN int neighbours_valid(const struct rve_place *at)
{
	SHARED struct rve_block *block = at->block;
	SHARED real *most = block->lanes[LANE_DISPLACEMENT], *second = block->lanes[LANE_SECOND];
	for (int width = LANES / 2; width > 0; width /= 2) {
		FOR_THREADS(lane, width)
		{
			real a = most[lane], b = most[lane + width];
			most[lane] = real_max(a, b);
			second[lane] = real_max(real_min(a, b), real_max(second[lane], second[lane + width]));
		}
		SYNC();
	}
	const real r_max = at->constants->r_max;
	real stretch = real_min(cell_least_stretch(block->head.H, block->head.H_ref), 1.0);
	real reach = stretch * (2.0 * r_max * block->head.scale_ref + at->constants->skin);
	real scale = real_max(block->scale, stretch * block->head.scale_ref);
	return reach - real_sqrt(most[0]) - real_sqrt(second[0]) >= 2.0 * r_max * scale;
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

THREADFN int clamp_cell(real x, int least, int most)
{
	return (int)real_min(real_max(x, (real)least), (real)most); /* also where x is not a number */
}

/* Discs sorted into the cells of a grid, each at least one reach wide, by counting; then once more with a rim of
 * images all around and their places in metres, so that a disc's neighbours stand in three rows of cells side by
 * side. */
BLOCKFN void neighbours_sort(const struct rve_place *at)
{
	SHARED struct rve_block *block = at->block;
	LOCAL const real *sx = WORK_DISC(WORK_SX), *sy = WORK_DISC(WORK_SY);
	GLOBAL const real *radius = TABLE(TABLE_R);
	LOCAL int *cell = WORK_DISC_INDEX(WORK_CELL), *sorted = WORK_DISC_INDEX(WORK_SORTED);
	LOCAL int *start = at->cell_start, *rim_start = at->rim_start;
	const real reach = 2.0 * at->constants->r_max * block->scale + at->constants->skin, scale = block->scale;
	const real hxx = block->head.H[0], hxy = block->head.H[1], hyx = block->head.H[2], hyy = block->head.H[3];
	const real area = hxx * hyy - hxy * hyx;
	const int nx = clamp_cell(area / real_sqrt(hxy * hxy + hyy * hyy) / reach, 2, at->layout->grid);
	const int ny = clamp_cell(area / real_sqrt(hxx * hxx + hyx * hyx) / reach, 2, at->layout->grid);
	const int columns = nx + 2, rows = ny + 2;
	FOR_THREADS(i, at->layout->n) cell[i] = clamp_cell(sy[i] * ny, 0, ny - 1) * nx + clamp_cell(sx[i] * nx, 0, nx - 1);
	SYNC();
	ONE_THREAD {
		for (int c = 0; c <= nx * ny; c++)
			start[c] = 0;
		for (int i = 0; i < at->layout->n; i++)
			start[cell[i] + 1]++;
		for (int c = 0; c < nx * ny; c++)
			start[c + 1] += start[c];
		for (int i = 0; i < at->layout->n; i++)
			sorted[start[cell[i]]++] = i; /* start[c] becomes the end of c, which is the start of c + 1 */
		for (int c = nx * ny; c > 0; c--)
			start[c] = start[c - 1];
		start[0] = 0;
		rim_start[0] = 0;
		for (int c = 0; c < columns * rows; c++) {
			int x = (c % columns + nx - 1) % nx, y = (c / columns + ny - 1) % ny;
			rim_start[c + 1] = rim_start[c] + start[y * nx + x + 1] - start[y * nx + x];
		}
		block->grid[0] = nx;
		block->grid[1] = ny;
	}
	SYNC();
	FOR_THREADS(c, columns * rows)
	{
		int x = c % columns - 1, y = c / columns - 1;
		int turn_x = x < 0 ? -1 : x == nx ? 1 : 0, turn_y = y < 0 ? -1 : y == ny ? 1 : 0;
		int from = start[(y - turn_y * ny) * nx + x - turn_x * nx];
		for (int k = rim_start[c]; k < rim_start[c + 1]; k++) {
			const int i = sorted[from++];
			real px = sx[i] + turn_x, py = sy[i] + turn_y;
			at->rim_disc[k] = i;
			at->rim[RIM_X * 4 * at->layout->stride + k] = hxx * px + hxy * py;
			at->rim[RIM_Y * 4 * at->layout->stride + k] = hyx * px + hyy * py;
			at->rim[RIM_R * 4 * at->layout->stride + k] = radius[i] * scale;
		}
	}
	SYNC();
}

/* The neighbours j > i of disc i.  Returns how many; more than the capacity are not all in the list. */
THREADFN int neighbours_find(const struct rve_place *at, int i, LOCAL index16 *list)
{
	const int nx = at->block->grid[0], columns = nx + 2, capacity = at->layout->levels;
	LOCAL const int *start = at->rim_start, *disc = at->rim_disc;
	LOCAL const real *x = at->rim + RIM_X * 4 * at->layout->stride, *y = at->rim + RIM_Y * 4 * at->layout->stride;
	LOCAL const real *r = at->rim + RIM_R * 4 * at->layout->stride;
	const real *H = at->block->head.H;
	const real si = WORK_DISC(WORK_SX)[i], ti = WORK_DISC(WORK_SY)[i];
	const real xi = H[0] * si + H[1] * ti, yi = H[2] * si + H[3] * ti;
	const real reach = TABLE(TABLE_R)[i] * at->block->scale + at->constants->skin;
	const int c = WORK_DISC_INDEX(WORK_CELL)[i], first = c / nx * columns + c % nx;
	int found = 0;
	for (int row = 0; row < 3; row++) {
		const int begin = start[first + row * columns], end = start[first + row * columns + 3];
		for (int k = begin; k < end; k++) {
			real dx = x[k] - xi, dy = y[k] - yi, cut = r[k] + reach;
			list[found < capacity ? found : capacity] = (index16)disc[k];
			found += (dx * dx + dy * dy < cut * cut) & (disc[k] > i); /* without a branch: most are no neighbours */
		}
	}
	return found;
}

/* What the pairs of the old list remember, out of the way of the new one. */
BLOCKFN void history_keep(const struct rve_place *at)
{
	LOCAL const int *pair_j = WORK_PAIR_INDEX(WORK_J);
	LOCAL int *old_first = WORK_DISC_INDEX(WORK_FIRST_OLD), *old_j = WORK_PAIR_INDEX(WORK_J_OLD);
	LOCAL real *old_ft = WORK_PAIR(WORK_PX), *old_fd = WORK_PAIR(WORK_PY), *old_flag = WORK_PAIR(WORK_T);
	FOR_THREADS(p, at->block->head.n_pairs)
	{
		old_j[p] = pair_j[p];
		old_ft[p] = WORK_PAIR(WORK_FT)[p];
		old_fd[p] = (real)STATE_FD[p];
		old_flag[p] = (real)STATE_FLAG[p];
	}
	FOR_THREADS(i, at->layout->n + 1) old_first[i] = STATE_FIRST[i];
	SYNC();
}

/* The pairs of disc i and what they remember. */
THREADFN void pairs_write(const struct rve_place *at, int i)
{
	LOCAL const index16 *list = at->neighbours + (long)i * (at->layout->levels + 1);
	LOCAL const int *old_j = WORK_PAIR_INDEX(WORK_J_OLD);
	const int begin = STATE_FIRST[i], end = STATE_FIRST[i + 1];
	const int old_begin = WORK_DISC_INDEX(WORK_FIRST_OLD)[i], old_end = WORK_DISC_INDEX(WORK_FIRST_OLD)[i + 1];
	for (int p = begin; p < end; p++) {
		const int j = list[p - begin];
		int old = old_begin;
		while (old < old_end && old_j[old] != j)
			old++;
		const int known = old < old_end;
		WORK_PAIR_INDEX(WORK_I)[p] = i;
		WORK_PAIR_INDEX(WORK_J)[p] = j;
		STATE_I[p] = (index16)i;
		STATE_J[p] = (index16)j;
		WORK_PAIR(WORK_FT)[p] = known ? WORK_PAIR(WORK_PX)[old] : 0.0;
		STATE_FD[p] = known ? (real32)WORK_PAIR(WORK_PY)[old] : 0.0f;
		STATE_FLAG[p] = known ? (unsigned char)WORK_PAIR(WORK_T)[old] : 0;
	}
}

/* The slot that holds no force, for discs with fewer neighbours than others. */
BLOCKFN void slots_clear(const struct rve_place *at)
{
	ONE_THREAD {
		for (int f = WORK_PX; f <= WORK_T; f += 2)
			WORK_PAIR(f)[at->layout->pairs] = 0.0;
	}
}

/* Which slots each disc gathers: entry[level][i].  A short walk, done by one thread. */
BLOCKFN void entries_write(const struct rve_place *at)
{
	SHARED struct rve_block *block = at->block;
	LOCAL int *degree = WORK_DISC_INDEX(WORK_DEGREE);
	LOCAL const int *pair_i = WORK_PAIR_INDEX(WORK_I), *pair_j = WORK_PAIR_INDEX(WORK_J);
	const int n = at->layout->n, stride = at->layout->stride, capacity = at->layout->levels;
	LOCAL int *entry = WORK_ENTRY(0);
	FOR_THREADS(i, n) degree[i] = 0;
	SYNC();
	ONE_THREAD {
		for (int p = 0; p < block->head.n_pairs; p++) {
			const int i = pair_i[p], j = pair_j[p];
			if (degree[i] < capacity && degree[j] < capacity) {
				entry[degree[i] * stride + i] = p;
				entry[degree[j] * stride + j] = p + at->layout->pair_stride;
			}
			degree[i]++;
			degree[j]++;
		}
		int levels = 0;
		for (int i = 0; i < n; i++)
			levels = degree[i] > levels ? degree[i] : levels;
		block->head.levels = levels;
		if (levels > capacity)
			block->status = KERNEL_CROWDED;
		for (int level = 0; level < levels && level < capacity; level++) {
			int last = n;
			while (degree[last - 1] <= level)
				last--;
			block->head.level_discs[level] = (index16)last;
		}
	}
	SYNC();
	for (int level = 0; level < block->head.levels && level < capacity; level++)
		FOR_THREADS(i, n)
		{
			int e = degree[i] > level ? entry[level * stride + i] : at->layout->pairs;
			entry[level * stride + i] = e;
			STATE_ENTRY(level)[i] = (index16)e;
		}
	SYNC();
}

/* Discs' lists put one after the other; sets STATE_FIRST, n_pairs. */
BLOCKFN void pairs_count(const struct rve_place *at)
{
	SHARED struct rve_block *block = at->block;
	LOCAL const int *degree = WORK_DISC_INDEX(WORK_DEGREE);
	ONE_THREAD {
		int pairs = 0, most = 0;
		for (int i = 0; i < at->layout->n; i++) {
			STATE_FIRST[i] = (index16)pairs;
			pairs += degree[i];
			most = degree[i] > most ? degree[i] : most;
		}
		if (pairs > at->layout->pairs || most > at->layout->levels)
			block->status = KERNEL_CROWDED;
		STATE_FIRST[at->layout->n] = (index16)pairs;
		block->head.n_pairs = pairs;
	}
	SYNC();
}

/* A new list for the configuration as it is.  Sets block->status if the cell has become too slender or
 * crowded for one. */
BLOCKFN void neighbours_build(const struct rve_place *at)
{
	SHARED struct rve_block *block = at->block;
	const int n = at->layout->n;
	LOCAL int *degree = WORK_DISC_INDEX(WORK_DEGREE);
	LOCAL const int *pair_i = WORK_PAIR_INDEX(WORK_I), *pair_j = WORK_PAIR_INDEX(WORK_J);
	GLOBAL const real *mass = TABLE(TABLE_MASS);
	GLOBAL real32 *damping = STATE_DAMPING;
	const real factor = at->constants->damping;
	history_keep(at);
	neighbours_rebase(at);
	real reach = 2.0 * at->constants->r_max * block->scale + at->constants->skin;
	if (!(cell_least_width(block->head.H) >= 2.0 * reach)) {
		ONE_THREAD block->status = KERNEL_SLENDER;
		SYNC();
		return;
	}
	neighbours_sort(at);
	FOR_THREADS(i, n) degree[i] = neighbours_find(at, i, at->neighbours + (long)i * (at->layout->levels + 1));
	SYNC();
	pairs_count(at);
	if (block->status != KERNEL_OK)
		return;
	FOR_THREADS(i, n) pairs_write(at, i);
	SYNC();
	entries_write(at);
	FOR_THREADS(p, block->head.n_pairs)
	{
		real a = mass[pair_i[p]], b = mass[pair_j[p]];
		damping[p] = (real32)(factor * real_sqrt(a * b / (a + b)));
	}
	slots_clear(at);
	SYNC();
}
