/* The list of pairs that may touch.  Included by kernel.h only.
 *
 * Pairs are those nearer than r_i + r_j + skin when the list is built, sorted by i, then j, i < j.  The list
 * is right while sigma_min(H H_ref^-1) (2 r_max + skin) - 2 u_max >= 2 r_max, u_max being the largest
 * non-affine displacement since.  That bound holds for every pair if the largest radii lose most by it: so a
 * sigma_min above 1 counts as 1, and radii that shrink by cooling count as if they did not.  The nearest image of
 * a pair in reach is unique while the cell is at least 2 (2 r_max + skin) wide. */

enum { FOLDED = 16 }; /* lanes */

/* The two largest ways of all lanes, in the first FOLDED. */
BLOCKFN void displacements_fold(SHARED const struct rve_place *at)
{
	SHARED real *most = at->block->lanes[LANE_DISPLACEMENT], *second = at->block->lanes[LANE_SECOND];
	for (int from = FOLDED; from < LANES; from += FOLDED)
		FOR_THREADS(lane, FOLDED)
		{
			real a = most[lane], b = most[lane + from];
			most[lane] = real_max(a, b);
			second[lane] = real_max(real_min(a, b), real_max(second[lane], second[lane + from]));
		}
}

/* Is the list still right?  The same for all threads. */
BLOCKFN int neighbours_valid(SHARED const struct rve_place *at)
{
	SHARED struct rve_block *block = at->block;
	SHARED const real *most = block->lanes[LANE_DISPLACEMENT], *second = block->lanes[LANE_SECOND];
	real first = most[0], next = second[0];
	for (int lane = 1; lane < FOLDED; lane++) {
		next = real_max(real_min(first, most[lane]), real_max(next, second[lane]));
		first = real_max(first, most[lane]);
	}
	return list_valid(&block->head, at->constants, block->scale, real_sqrt(first), real_sqrt(next));
}

/* Ends the discs' stretch of motion since the last build: its displacement is booked, places are in the reduced cell. */
BLOCKFN void discs_rebase(SHARED const struct rve_place *at)
{
	SHARED struct rve_block *block = at->block;
	const real hxx = block->head.H[0], hxy = block->head.H[1], hyx = block->head.H[2], hyy = block->head.H[3];
	LOCAL real *sx = WORK_ROW(WORK_SX), *sy = WORK_ROW(WORK_SY);
	GLOBAL real32 *ref_x = STATE_DISC32(DISC32_REF_X), *ref_y = STATE_DISC32(DISC32_REF_Y);
	GLOBAL real32 *ux = STATE_DISC32(DISC32_UX), *uy = STATE_DISC32(DISC32_UY);
	const real moved = at->call->rebuild ? 0.0 : 1.0;
	real T[4], H[4] = {hxx, hxy, hyx, hyy};
	cell_reduce(H, T);
	FOR_THREADS(i, at->layout->n)
	{
		real qx = (sx[i] - (real)ref_x[i]) * moved, qy = (sy[i] - (real)ref_y[i]) * moved;
		ux[i] += (real32)(hxx * qx + hxy * qy);
		uy[i] += (real32)(hyx * qx + hyy * qy);
		real x = T[0] * sx[i] + T[1] * sy[i], y = T[2] * sx[i] + T[3] * sy[i];
		x -= real_nearest(x), y -= real_nearest(y);
		sx[i] = x < 0.0 ? x + 1.0 : x;
		sy[i] = y < 0.0 ? y + 1.0 : y;
	}
}

/* The cell itself, when all discs have seen what it was. */
BLOCKFN void cell_rebase(SHARED const struct rve_place *at)
{
	SHARED struct rve_block *block = at->block;
	ONE_THREAD
	{
		real T[4], H[4] = {block->head.H[0], block->head.H[1], block->head.H[2], block->head.H[3]};
		cell_reduce(H, T);
		for (int k = 0; k < 4; k++)
			block->head.H[k] = block->head.H_ref[k] = H[k];
		cell_invert(block->head.H, block->H_inv);
		block->head.scale_ref = block->scale;
		block->head.rebuilds++;
	}
}


THREADFN int clamp_cell(real x, int least, int most)
{
	return (int)real_min(real_max(x, (real)least), (real)most); /* also where x is not a number */
}

/* The cell of a grid that each disc is in, each at least one reach wide.  Sets block->status if the cell of the discs has
 * become too slender for a list. */
BLOCKFN void discs_bin(SHARED const struct rve_place *at)
{
	SHARED struct rve_block *block = at->block;
	LOCAL const real *sx = WORK_ROW(WORK_SX), *sy = WORK_ROW(WORK_SY);
	LOCAL int *cell = WORK_ROW_INDEX(WORK_CELL);
	const real reach = 2.0 * at->constants->r_max * block->scale + at->constants->skin;
	const real hxx = block->head.H[0], hxy = block->head.H[1], hyx = block->head.H[2], hyy = block->head.H[3];
	const real area = hxx * hyy - hxy * hyx;
	const int nx = clamp_cell(area / real_sqrt(hxy * hxy + hyy * hyy) / reach, 2, at->layout->grid);
	const int ny = clamp_cell(area / real_sqrt(hxx * hxx + hyx * hyx) / reach, 2, at->layout->grid);
	FOR_THREADS(i, at->layout->n) cell[i] = clamp_cell(sy[i] * ny, 0, ny - 1) * nx + clamp_cell(sx[i] * nx, 0, nx - 1);
	ONE_THREAD
	{
		block->grid[0] = nx;
		block->grid[1] = ny;
		if (!(cell_least_width(block->head.H) >= 2.0 * reach))
			block->status = KERNEL_SLENDER;
	}
}

/* Discs sorted into those cells by counting; where the images of a rim all around will stand. */
BLOCKFN void discs_sort(SHARED const struct rve_place *at)
{
	LOCAL const int *cell = WORK_ROW_INDEX(WORK_CELL);
	LOCAL int *sorted = WORK_ROW_INDEX(WORK_SORTED), *start = at->cell_start, *rim_start = at->rim_start;
	const int nx = at->block->grid[0], ny = at->block->grid[1], columns = nx + 2, rows = ny + 2;
	ONE_THREAD
	{
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
		for (int y = 0, c = 0; y < rows; y++) {
			int from = (y == 0 ? ny - 1 : y == ny + 1 ? 0 : y - 1) * nx;
			for (int x = 0; x < columns; x++, c++) {
				int k = from + (x == 0 ? nx - 1 : x == nx + 1 ? 0 : x - 1);
				rim_start[c + 1] = rim_start[c] + start[k + 1] - start[k];
			}
		}
	}
}

/* Discs once more, with that rim and their places in metres, so that a disc's neighbours stand in three rows of cells
 * side by side. */
BLOCKFN void rim_fill(SHARED const struct rve_place *at)
{
	SHARED const struct rve_block *block = at->block;
	LOCAL const real *sx = WORK_ROW(WORK_SX), *sy = WORK_ROW(WORK_SY), *radius = WORK_ROW(WORK_R);
	LOCAL const int *id = WORK_ROW_INDEX(WORK_ID), *sorted = WORK_ROW_INDEX(WORK_SORTED);
	LOCAL const int *start = at->cell_start, *rim_start = at->rim_start;
	LOCAL real *rim_x = at->rim, *rim_y = rim_x + 4 * at->layout->stride, *rim_r = rim_y + 4 * at->layout->stride;
	const real hxx = block->head.H[0], hxy = block->head.H[1], hyx = block->head.H[2], hyy = block->head.H[3];
	const real scale = block->scale;
	const int nx = block->grid[0], ny = block->grid[1], columns = nx + 2, rows = ny + 2;
	FOR_THREADS(c, columns * rows)
	{
		int x = c % columns - 1, y = c / columns - 1;
		int turn_x = x < 0 ? -1 : x == nx ? 1 : 0, turn_y = y < 0 ? -1 : y == ny ? 1 : 0;
		int from = start[(y - turn_y * ny) * nx + x - turn_x * nx];
		for (int k = rim_start[c]; k < rim_start[c + 1]; k++) {
			const int i = sorted[from++];
			real px = sx[i] + turn_x, py = sy[i] + turn_y;
			at->rim_id[k] = id[i];
			rim_x[k] = hxx * px + hxy * py;
			rim_y[k] = hyx * px + hyy * py;
			rim_r[k] = radius[i] * scale;
		}
	}
}

/* The neighbours of the disc in a row: a list of those whose pairs it owns, and how many others there are.  Of two
 * discs of even and odd index the lower one owns the pair, else the higher one: half of each disc's pairs, and always
 * the same.  More than the capacity are not all in the list. */
THREADFN void neighbours_of(SHARED const struct rve_place *at, int row)
{
	const int columns = at->block->grid[0] + 2, nx = at->block->grid[0], capacity = at->layout->levels;
	const int id = WORK_ROW_INDEX(WORK_ID)[row];
	LOCAL index16 *list = at->neighbours + (long)id * (at->layout->levels + 1);
	LOCAL const int *start = at->rim_start, *rim_id = at->rim_id;
	LOCAL const real *x = at->rim, *y = x + 4 * at->layout->stride, *r = y + 4 * at->layout->stride;
	SHARED const real *H = at->block->head.H;
	const real s = WORK_ROW(WORK_SX)[row], t = WORK_ROW(WORK_SY)[row];
	const real x0 = H[0] * s + H[1] * t, y0 = H[2] * s + H[3] * t;
	const real reach = WORK_ROW(WORK_R)[row] * at->block->scale + at->constants->skin;
	const int c = WORK_ROW_INDEX(WORK_CELL)[row], first = c / nx * columns + c % nx;
	int near = 0, owned = 0;
	for (int k3 = 0; k3 < 3; k3++) {
		const int begin = start[first + k3 * columns], end = start[first + k3 * columns + 3];
		for (int k = begin; k < end; k++) { /* without a branch: most are no neighbours */
			real dx = x[k] - x0, dy = y[k] - y0, cut = r[k] + reach;
			const int other = rim_id[k], is_near = dx * dx + dy * dy < cut * cut;
			list[owned < capacity ? owned : capacity] = (index16)other;
			owned += is_near & (((id ^ other) & 1) ^ (id > other));
			near += is_near;
		}
	}
	WORK_ID_INDEX(ID_OWNED)[id] = owned;
	WORK_ID_INDEX(ID_OTHERS)[id] = near - 1 - owned; /* it is near itself */
}

BLOCKFN void neighbours_find(SHARED const struct rve_place *at) { FOR_THREADS(i, at->layout->n) neighbours_of(at, i); }

/* What the pairs of the old list remember, out of the way of the new one. */
BLOCKFN void history_keep(SHARED const struct rve_place *at)
{
	SHARED struct rve_block *block = at->block;
	const int slots = block->head.level_first[block->head.levels];
	LOCAL const int *id = WORK_ROW_INDEX(WORK_ID), *pair_j = WORK_PAIR_INDEX(WORK_J);
	LOCAL int *old_row = WORK_ID_INDEX(ID_ROW_OLD), *old_j = WORK_PAIR_INDEX(WORK_J_OLD);
	LOCAL real *old_ft = WORK_PAIR(WORK_PX), *old_fd = WORK_PAIR(WORK_PY), *old_bond = WORK_PAIR(WORK_TJ);
	LOCAL const real *bond = WORK_PAIR(WORK_BOND);
	FOR_THREADS(p, slots)
	{
		old_j[p] = id[pair_j[p]];
		old_ft[p] = WORK_PAIR(WORK_FT)[p];
		old_fd[p] = (real)STATE_FD[p];
	}
	if (block->head.bonds_installed > 0)
		FOR_THREADS(p, slots) old_bond[p] = bond[p];
	FOR_THREADS(i, at->layout->n) old_row[id[i]] = i;
	ONE_THREAD
	{
		block->levels_old = block->head.levels;
		for (int level = 0; level < RVE_LEVELS_MAX; level++) {
			block->level_rows_old[level] = block->head.level_rows[level];
			block->level_first_old[level] = block->head.level_first[level];
		}
	}
}

/* New rows: by how many pairs a disc owns, the most first, then by how many others it has, the fewest first (who owns
 * many has few others, so that the levels of entries have few holes).  Sizes of the levels.  Sets block->status if the
 * cell has become too crowded; does nothing if it has one already. */
BLOCKFN void rows_sort(SHARED const struct rve_place *at)
{
	SHARED struct rve_block *block = at->block;
	LOCAL const int *owned = WORK_ID_INDEX(ID_OWNED), *others = WORK_ID_INDEX(ID_OTHERS);
	LOCAL int *row = WORK_ID_INDEX(ID_ROW), *id = WORK_ROW_INDEX(WORK_ID), *start = at->key_start;
	const int n = at->layout->n, capacity = at->layout->levels, keys = (capacity + 1) * (capacity + 1);
	ONE_THREAD
	{
		if (block->status != KERNEL_OK)
			return;
		int most = 0;
		for (int k = 0; k <= keys; k++)
			start[k] = 0;
		for (int i = 0; i < n; i++) {
			int degree = owned[i] + others[i];
			most = degree > most ? degree : most;
		}
		if (most > capacity)
			block->status = KERNEL_CROWDED;
		for (int i = 0; i < n && most <= capacity; i++)
			start[(capacity - owned[i]) * (capacity + 1) + others[i] + 1]++;
		for (int k = 0; k < keys; k++)
			start[k + 1] += start[k];
		for (int i = 0; i < n && most <= capacity; i++) {
			row[i] = start[(capacity - owned[i]) * (capacity + 1) + others[i]]++;
			id[row[i]] = i;
		}
		int first = 0, levels = 0;
		for (int rows = n; levels < capacity && most <= capacity; levels++) {
			while (rows > 0 && owned[id[rows - 1]] <= levels)
				rows--;
			if (rows == 0)
				break;
			block->head.level_rows[levels] = (index16)rows;
			block->head.level_first[levels] = (index16)first;
			first += (rows + ROW_PAD - 1) / ROW_PAD * ROW_PAD;
			if (first > at->layout->pairs) {
				block->status = KERNEL_CROWDED;
				break;
			}
		}
		block->head.levels = levels;
		block->head.level_first[levels] = (index16)first;
	}
}

/* The constants of the discs, in rows. */
BLOCKFN void rows_load(SHARED const struct rve_place *at)
{
	LOCAL const int *id = WORK_ROW_INDEX(WORK_ID);
	FOR_THREADS(i, at->layout->stride)
	{
		WORK_ROW(WORK_R)[i] = TABLE(TABLE_R)[id[i]];
		WORK_ROW(WORK_MASS)[i] = TABLE(TABLE_MASS)[id[i]];
		WORK_ROW(WORK_DT_MASS)[i] = TABLE(TABLE_DT_MASS)[id[i]];
		WORK_ROW(WORK_DT_INERTIA)[i] = TABLE(TABLE_DT_INERTIA)[id[i]];
	}
}

/* What discs take along to their new rows, where the images of the neighbour search were. */
#define MOVED(f) (at->rim + (f)*at->layout->stride)
#define MOVED32(f) MOVED(WORK_ROTATION + 1 + (f)-DISC32_UX)
typedef char moved_fit[WORK_ROTATION + 1 + DISC32_ROTATION - DISC32_UX < RIM_FIELDS * 4 ? 1 : -1];

BLOCKFN void rows_leave(SHARED const struct rve_place *at)
{
	LOCAL const int *id = WORK_ROW_INDEX(WORK_ID), *old_row = WORK_ID_INDEX(ID_ROW_OLD);
	for (int f = WORK_SX; f <= WORK_ROTATION; f++) {
		LOCAL const real *field = WORK_ROW(f);
		LOCAL real *moved = MOVED(f);
		FOR_THREADS(i, at->layout->n) moved[i] = field[old_row[id[i]]];
	}
	for (int f = DISC32_UX; f <= DISC32_ROTATION; f++) {
		GLOBAL const real32 *field = STATE_DISC32(f);
		LOCAL real *moved = MOVED32(f);
		FOR_THREADS(i, at->layout->n) moved[i] = (real)field[old_row[id[i]]];
	}
}

BLOCKFN void rows_enter(SHARED const struct rve_place *at)
{
	LOCAL const int *id = WORK_ROW_INDEX(WORK_ID);
	const int n = at->layout->n;
	for (int f = WORK_SX; f <= WORK_ROTATION; f++) {
		LOCAL real *field = WORK_ROW(f);
		LOCAL const real *moved = MOVED(f);
		FOR_THREADS(i, n) field[i] = moved[i];
	}
	for (int f = DISC32_UX; f <= DISC32_ROTATION; f++) {
		GLOBAL real32 *field = STATE_DISC32(f);
		LOCAL const real *moved = MOVED32(f);
		FOR_THREADS(i, n) field[i] = (real32)moved[i];
	}
	FOR_THREADS(i, n)
	{
		STATE_DISC32(DISC32_REF_X)[i] = (real32)WORK_ROW(WORK_SX)[i];
		STATE_DISC32(DISC32_REF_Y)[i] = (real32)WORK_ROW(WORK_SY)[i];
		STATE_ID[i] = (index16)id[i];
	}
	rows_load(at);
}

/* The pairs of one level with what they remember, and its pairs to the ghost. */
BLOCKFN void pairs_of_level(SHARED const struct rve_place *at, int level)
{
	SHARED const struct rve_block *block = at->block;
	LOCAL const int *id = WORK_ROW_INDEX(WORK_ID), *new_row = WORK_ID_INDEX(ID_ROW),
					*old_row = WORK_ID_INDEX(ID_ROW_OLD);
	LOCAL const int *old_j = WORK_PAIR_INDEX(WORK_J_OLD);
	LOCAL const real *mass = WORK_ROW(WORK_MASS);
	const int first = block->head.level_first[level], rows = block->head.level_rows[level];
	const int padded = block->head.level_first[level + 1] - first;
	const real factor = at->constants->damping;
	const int bonded = block->head.bonds_installed > 0;
	GLOBAL real32 *damping = STATE_DAMPING + first;
	LOCAL int *pair_j = WORK_PAIR_INDEX(WORK_J) + first;
	FOR_THREADS(i, padded)
	{
		const int p = first + i, owner = i < rows ? id[i] : 0;
		const int j = i < rows ? at->neighbours[(long)owner * (at->layout->levels + 1) + level] : at->layout->n;
		const int row = i < rows ? new_row[j] : at->layout->n, was = old_row[owner];
		int known = -1;
		for (int k = 0; k < block->levels_old && was < block->level_rows_old[k]; k++)
			known = old_j[block->level_first_old[k] + was] == j ? block->level_first_old[k] + was : known;
		pair_j[i] = row;
		STATE_J[p] = (index16)row;
		WORK_PAIR(WORK_FT)[p] = known >= 0 ? WORK_PAIR(WORK_PX)[known] : 0.0;
		STATE_FD[p] = known >= 0 ? (real32)WORK_PAIR(WORK_PY)[known] : 0.0f;
		if (bonded)
			WORK_PAIR(WORK_BOND)[p] = known >= 0 ? WORK_PAIR(WORK_TJ)[known] : BOND_NONE;
	}
	FOR_THREADS(i, padded)
	{
		real a = mass[i], b = mass[pair_j[i]];
		damping[i] = (real32)(factor * real_sqrt(a * b / (a + b)));
	}
}

BLOCKFN void pairs_write(SHARED const struct rve_place *at)
{
	for (int level = 0; level < at->block->head.levels; level++)
		pairs_of_level(at, level);
	FOR_THREADS(i, at->layout->n) WORK_ROW_INDEX(WORK_DEGREE)[i] = 0;
}

/* Which slots each disc gathers as a pair's j.  A short walk, done by one thread. */
BLOCKFN void entries_collect(SHARED const struct rve_place *at)
{
	SHARED struct rve_block *block = at->block;
	LOCAL int *degree = WORK_ROW_INDEX(WORK_DEGREE), *entry = WORK_ENTRY(0);
	LOCAL const int *pair_j = WORK_PAIR_INDEX(WORK_J);
	const int n = at->layout->n, stride = at->layout->stride;
	ONE_THREAD
	{
		for (int level = 0; level < block->head.levels; level++)
			for (int i = 0; i < block->head.level_rows[level]; i++) {
				const int p = block->head.level_first[level] + i, j = pair_j[p];
				entry[degree[j]++ * stride + j] = p;
			}
		int levels = 0;
		for (int i = 0; i < n; i++)
			levels = degree[i] > levels ? degree[i] : levels;
		block->head.entry_levels = levels;
		for (int level = 0; level < levels; level++) {
			int first = 0;
			while (degree[first] <= level)
				first++;
			block->head.entry_first[level] = (index16)(first / ROW_PAD * ROW_PAD);
		}
	}
}

/* Those that have fewer than others gather the slot without a force. */
BLOCKFN void entries_write(SHARED const struct rve_place *at)
{
	LOCAL const int *degree = WORK_ROW_INDEX(WORK_DEGREE);
	for (int level = 0; level < at->block->head.entry_levels; level++) {
		const int first = at->block->head.entry_first[level];
		LOCAL int *entry = WORK_ENTRY(level);
		FOR_THREADS_FROM(i, first, at->layout->n)
		{
			const int e = degree[i] > level ? entry[i] : at->layout->pairs;
			entry[i] = e;
			STATE_ENTRY(level)[i] = (index16)e;
		}
	}
}

/* The slot that holds no force, for discs with fewer entries than others. */
BLOCKFN void slots_clear(SHARED const struct rve_place *at)
{
	ONE_THREAD
	{
		WORK_PAIR(WORK_PX)[at->layout->pairs] = 0.0;
		WORK_PAIR(WORK_PY)[at->layout->pairs] = 0.0;
		WORK_PAIR(WORK_TJ)[at->layout->pairs] = 0.0;
	}
}
