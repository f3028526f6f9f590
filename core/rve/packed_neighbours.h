/* The list of pairs of the packed kernel.  Included by packed.h only.
 *
 * Same pairs, same owners and same validity as the serial kernel's (kernel_neighbours.h).  Rows are sorted by how many
 * of their own pairs touch, then by how many there are, and a row's touching pairs come first: the later levels of a
 * block are then the ones that packed_pairs() leaves early.  Scalars in double: this is done every 20 to 60 sub-steps.
 */

/* Discs and their images around the cell, sorted by grid cell: at most 4 n. */
struct packed_rim {
	num *x, *y, *r; /* m */
	int *row;
};

enum { PACKED_TOUCHES = 1 << 16 };

struct packed_search {
	struct packed_rim rim;
	double *x, *y; /* cell coordinates of the rows, between 0 and 1 */
	int *cell, *sorted, *start, *rim_start, *keys;
	int *pair_a, *pair_b; /* rows of all pairs in reach; TOUCHES is set in b where they touch */
	int *order, *place;   /* old row of each new row, and back */
	int *mark, *mark_of;  /* by row: slot of the pair with it, and whose */
	index16 *near;        /* by row: its own pairs, the touching ones from the front, the others from the back */
	index16 *touch, *own; /* how many */
	num *ft;
	real32 *fd, *damping;
	unsigned char *flag;
	num *moved;
};

/* Pairs that can be noted, and room behind them for what one disc finds. */
static inline long packed_pairs_most(const struct rve_layout *layout) { return layout->pairs + 256; }

static inline long packed_build_scratch(const struct rve_layout *layout)
{
	const long row = layout->stride, grid = layout->grid, levels = layout->levels + 1;
	long bytes = (long)sizeof(num) * 3 * (4 * row + LANE_COUNT) + (long)sizeof(double) * 2 * row;
	bytes += (long)sizeof(int) * 2 * packed_pairs_most(layout);
	bytes += (long)sizeof(int) *
			 (4 * row + LANE_COUNT + 6 * row + grid * grid + 1 + (grid + 2) * (grid + 2) + 1 + levels * levels + 1);
	bytes += (long)sizeof(index16) * (levels + 2) * row;
	bytes += (long)(sizeof(num) + 2 * sizeof(real32) + 1) * layout->pairs + (long)sizeof(num) * row;
	return bytes + 20 * 64;
}

static inline void *packed_take(unsigned char **free, size_t bytes)
{
	void *taken = *free;
	*free += (bytes + 63) / 64 * 64;
	return taken;
}

static inline void packed_search_open(const struct packed_place *at, struct packed_search *s)
{
	const size_t row = (size_t)at->layout->stride, grid = (size_t)at->layout->grid, pairs = (size_t)at->layout->pairs;
	const size_t levels = (size_t)at->layout->levels + 1;
	unsigned char *free = at->free;
	num **of_rim[] = {&s->rim.x, &s->rim.y, &s->rim.r};
	for (int k = 0; k < 3; k++)
		*of_rim[k] = packed_take(&free, sizeof(num) * (4 * row + LANE_COUNT));
	s->rim.row = packed_take(&free, sizeof(int) * (4 * row + LANE_COUNT));
	s->pair_a = packed_take(&free, sizeof(int) * (size_t)packed_pairs_most(at->layout));
	s->pair_b = packed_take(&free, sizeof(int) * (size_t)packed_pairs_most(at->layout));
	s->x = packed_take(&free, sizeof(double) * row);
	s->y = packed_take(&free, sizeof(double) * row);
	int **of_rows[] = {&s->cell, &s->sorted, &s->order, &s->place, &s->mark, &s->mark_of};
	for (int k = 0; k < 6; k++)
		*of_rows[k] = packed_take(&free, sizeof(int) * row);
	s->start = packed_take(&free, sizeof(int) * (grid * grid + 1));
	s->rim_start = packed_take(&free, sizeof(int) * ((grid + 2) * (grid + 2) + 1));
	s->keys = packed_take(&free, sizeof(int) * (levels * levels + 1));
	s->near = packed_take(&free, sizeof(index16) * levels * row);
	s->touch = packed_take(&free, sizeof(index16) * row);
	s->own = packed_take(&free, sizeof(index16) * row);
	s->ft = packed_take(&free, sizeof(num) * pairs);
	s->fd = packed_take(&free, sizeof(real32) * pairs);
	s->damping = packed_take(&free, sizeof(real32) * pairs);
	s->flag = packed_take(&free, pairs);
	s->moved = packed_take(&free, sizeof(num) * row);
}

/* Ends the stretch of motion since the last build: its displacement is booked, the cell reduced, coordinates brought
 * between 0 and 1. */
static inline void packed_rebase(struct packed_place *at, struct packed_search *s, const int moved)
{
	double *H = at->head->H, T[4];
	const double hxx = H[0] * COORD_UNIT, hxy = H[1] * COORD_UNIT, hyx = H[2] * COORD_UNIT, hyy = H[3] * COORD_UNIT;
	const int n = at->layout->n;
	for (int i = 0; i < n && moved; i++) {
#ifdef RVE_FLOAT
		double qx = coord_apart(at->sx[i], ((const coord *)at->ref_x)[i]),
			   qy = coord_apart(at->sy[i], ((const coord *)at->ref_y)[i]);
#else
		double qx = at->sx[i] - (double)at->ref_x[i], qy = at->sy[i] - (double)at->ref_y[i];
#endif
		at->ux[i] += (real32)(hxx * qx + hxy * qy);
		at->uy[i] += (real32)(hyx * qx + hyy * qy);
	}
	cell_reduce(H, T);
	for (int i = 0; i < n; i++) {
#ifdef RVE_FLOAT
		const int32_t t[4] = {(int32_t)T[0], (int32_t)T[1], (int32_t)T[2], (int32_t)T[3]};
		uint32_t x = (uint32_t)at->sx[i], y = (uint32_t)at->sy[i];
		uint32_t to_x = (uint32_t)t[0] * x + (uint32_t)t[1] * y, to_y = (uint32_t)t[2] * x + (uint32_t)t[3] * y;
		num rest_x = (num)T[0] * at->rest_x[i] + (num)T[1] * at->rest_y[i];
		num rest_y = (num)T[2] * at->rest_x[i] + (num)T[3] * at->rest_y[i];
		at->sx[i] = (coord)to_x, at->sy[i] = (coord)to_y;
		at->rest_x[i] = rest_x, at->rest_y[i] = rest_y;
		s->x[i] = (double)to_x * COORD_UNIT, s->y[i] = (double)to_y * COORD_UNIT;
#else
		double x = T[0] * at->sx[i] + T[1] * at->sy[i], y = T[2] * at->sx[i] + T[3] * at->sy[i];
		x -= real_nearest(x), y -= real_nearest(y);
		at->sx[i] = s->x[i] = x < 0.0 ? x + 1.0 : x;
		at->sy[i] = s->y[i] = y < 0.0 ? y + 1.0 : y;
#endif
	}
	for (int k = 0; k < 4; k++)
		at->head->H_ref[k] = H[k];
	cell_invert(H, at->H_inv);
	at->head->scale_ref = at->scale;
	at->head->rebuilds++;
}

static inline int packed_clamp(double x, int least, int most)
{
	return (int)real_min(real_max(x, (double)least), (double)most); /* also where x is not a number */
}

/* Discs sorted into the cells of a grid, each at least one reach wide, with a rim of images around it.  The numbers of
 * cells along each direction. */
static inline void packed_sort(const struct packed_place *at, struct packed_search *s, double reach, int grid[2])
{
	const double *H = at->head->H, area = H[0] * H[3] - H[1] * H[2];
	const int n = at->layout->n;
	const int nx = packed_clamp(area / real_sqrt(H[1] * H[1] + H[3] * H[3]) / reach, 2, at->layout->grid);
	const int ny = packed_clamp(area / real_sqrt(H[0] * H[0] + H[2] * H[2]) / reach, 2, at->layout->grid);
	int *start = s->start;
	memset(start, 0, sizeof(int) * (size_t)(nx * ny + 1));
	for (int i = 0; i < n; i++) {
		int c = packed_clamp(s->y[i] * ny, 0, ny - 1) * nx + packed_clamp(s->x[i] * nx, 0, nx - 1);
		s->cell[i] = c;
		start[c + 1]++;
	}
	for (int c = 0; c < nx * ny; c++)
		start[c + 1] += start[c];
	for (int i = 0; i < n; i++)
		s->sorted[start[s->cell[i]]++] = i; /* start[c] becomes the end of c, which is the start of c + 1 */
	memmove(start + 1, start, sizeof(int) * (size_t)(nx * ny));
	start[0] = 0;
	int k = 0;
	for (int y = -1, c = 0; y <= ny; y++) {
		const int turn_y = y < 0 ? -1 : y == ny ? 1 : 0, line = (y - turn_y * ny) * nx;
		for (int x = -1; x <= nx; x++, c++) {
			const int turn_x = x < 0 ? -1 : x == nx ? 1 : 0, from = line + x - turn_x * nx;
			s->rim_start[c] = k;
			for (int q = start[from]; q < start[from + 1]; q++, k++) {
				const int i = s->sorted[q];
				const double px = s->x[i] + turn_x, py = s->y[i] + turn_y;
				s->rim.row[k] = i;
				s->rim.x[k] = (num)(H[0] * px + H[1] * py);
				s->rim.y[k] = (num)(H[2] * px + H[3] * py);
				s->rim.r[k] = (num)((double)at->r[i] * at->scale);
			}
		}
	}
	s->rim_start[(nx + 2) * (ny + 2)] = k;
	for (int q = k; q < k + LANE_COUNT; q++) { /* read with the last ones, and left out */
		s->rim.x[q] = s->rim.y[q] = s->rim.r[q] = 0;
		s->rim.row[q] = 0;
	}
	grid[0] = nx, grid[1] = ny;
}

/* Those of the discs begin .. end - 1 of the rim that are in reach of disc a of it, behind the `found` pairs that there
 * are already. */
VECFN int packed_look(struct packed_search *s, int a, int begin, int end, vec skin, int found)
{
	const struct packed_rim *rim = &s->rim;
	const vec x0 = vec_set(rim->x[a]), y0 = vec_set(rim->y[a]), r0 = vec_set(rim->r[a]);
	const int row = rim->row[a];
	for (int b = begin; b < end; b += VECTOR_WIDTH) {
		const vec dx = vec_loadu(rim->x + b) - x0, dy = vec_loadu(rim->y + b) - y0;
		const vec radii = vec_loadu(rim->r + b) + r0, square = dx * dx + dy * dy, cut = radii + skin;
		const mask in = mask_above(cut * cut, square) & mask_first(end - b);
		for (int k = 0; k < VECTOR_WIDTH; k++)
			s->pair_a[found + k] = row;
		found += ints_pick(s->pair_b + found, rim->row + b, in, mask_above(radii * radii, square), PACKED_TOUCHES);
	}
	return found;
}

/* All pairs in reach, each once: a disc with the later ones of its cell and with its right neighbour, and with the
 * three cells above.  Their number; -1: there is no room for so many. */
static inline int packed_find(const struct packed_place *at, struct packed_search *s, const int grid[2])
{
	const int columns = grid[0] + 2, most = at->layout->pairs;
	/* a little more where coordinates in metres are single */
	const vec skin = vec_set((num)(at->constants->skin * VECTOR_PICK(1.0, 1.0001)));
	int found = 0;
	for (int y = 0; y < grid[1]; y++)
		for (int x = 0; x < grid[0]; x++) {
			const int c = (y + 1) * columns + x + 1, above = c + columns - 1;
			for (int a = s->rim_start[c]; a < s->rim_start[c + 1]; a++) {
				found = packed_look(s, a, a + 1, s->rim_start[c + 2], skin, found);
				if (found > most)
					return -1;
				found = packed_look(s, a, s->rim_start[above], s->rim_start[above + 3], skin, found);
				if (found > most)
					return -1;
			}
		}
	return found;
}

/* Gives each pair to the disc that owns it: of two discs of even and odd index the lower one, else the higher one.  0
 * if one has too many. */
static inline int packed_deal(const struct packed_place *at, struct packed_search *s, int pairs)
{
	const int levels = at->layout->levels + 1;
	memset(s->own, 0, sizeof(index16) * (size_t)at->layout->stride);
	memset(s->touch, 0, sizeof(index16) * (size_t)at->layout->stride);
	for (int k = 0; k < pairs; k++) {
		const int a = s->pair_a[k], b = s->pair_b[k] & (PACKED_TOUCHES - 1), touches = s->pair_b[k] / PACKED_TOUCHES;
		const int ia = at->id[a], ib = at->id[b], swap = -(((ia ^ ib) & 1) ^ (ia < ib));
		const int owner = a ^ ((a ^ b) & swap), other = b ^ ((a ^ b) & swap);
		const int own = s->own[owner], touch = s->touch[owner];
		if (own + 1 >= levels)
			return 0;
		s->near[owner * levels + (touches ? touch : levels - 1 - (own - touch))] = (index16)other;
		s->touch[owner] = (index16)(touch + touches);
		s->own[owner] = (index16)(own + 1);
	}
	return 1;
}

/* New rows by touching pairs, then by all, the most first: `by_all` instead by all alone, which needs the fewest slots.
 * The blocks' first levels; slots needed. */
static inline int packed_order(const struct packed_place *at, struct packed_search *s, int by_all)
{
	const int n = at->layout->n, stride = at->layout->stride, levels = at->layout->levels + 1, keys = levels * levels;
	int *start = s->keys;
#define KEY(i) ((by_all ? 0 : levels - 1 - s->touch[i]) * levels + levels - 1 - s->own[i])
	memset(start, 0, sizeof(int) * (size_t)(keys + 1));
	for (int i = 0; i < n; i++)
		start[KEY(i) + 1]++;
	for (int k = 0; k < keys; k++)
		start[k + 1] += start[k];
	for (int k = 0; k < n; k++) { /* cell by cell: neighbours are near in memory */
		const int i = s->sorted[k], row = start[KEY(i)]++;
		s->order[row] = i;
		s->place[i] = row;
	}
#undef KEY
	int sum = 0;
	for (int block = 0; block < stride / LANE_COUNT; block++) {
		int most = 0;
		for (int row = block * LANE_COUNT; row < (block + 1) * LANE_COUNT && row < n; row++)
			most = s->own[s->order[row]] > most ? s->own[s->order[row]] : most;
		at->first[block] = (index16)sum;
		sum += most;
	}
	at->first[stride / LANE_COUNT] = (index16)sum;
	return sum * LANE_COUNT;
}

/* The new pairs with what they remember: `old_first` are the blocks' first levels of the old list. */
static inline void packed_write(struct packed_place *at, struct packed_search *s, const index16 *old_first)
{
	const int n = at->layout->n, stride = at->layout->stride, levels = at->layout->levels + 1;
	const int slots = at->first[stride / LANE_COUNT] * LANE_COUNT, bonded = at->head->bonds_installed > 0;
	memset(s->ft, 0, sizeof(num) * (size_t)slots);
	memset(s->fd, 0, sizeof(real32) * (size_t)slots);
	memset(s->damping, 0, sizeof(real32) * (size_t)slots);
	memset(s->flag, 0, (size_t)slots);
	memset(s->mark_of, -1, sizeof(int) * (size_t)stride);
	/* old slots are looked up in the old list, so that one cannot be written over the other */
	index16 *list = (index16 *)s->rim.x; /* the search is over */
	for (int p = 0; p < slots; p++)
		list[p] = (index16)stride;
	for (int row = 0; row < n; row++) {
		const int a = s->order[row], own = s->own[a], touch = s->touch[a], old = a / LANE_COUNT;
		for (int level = old_first[old]; level < old_first[old + 1]; level++) {
			const int p = level * LANE_COUNT + a % LANE_COUNT, j = at->pair_j[p];
			if (j == stride)
				break;
			s->mark[j] = p, s->mark_of[j] = a;
		}
		const index16 *near = s->near + a * levels;
		int p = at->first[row / LANE_COUNT] * LANE_COUNT + row % LANE_COUNT;
		for (int k = 0; k < own; k++, p += LANE_COUNT) {
			const int b = near[k < touch ? k : levels - 1 - (k - touch)];
			list[p] = (index16)s->place[b];
			if (s->mark_of[b] == a) {
				const int known = s->mark[b];
				s->ft[p] = at->ft[known];
				s->fd[p] = at->fd[known];
				s->damping[p] = at->damping[known];
				if (bonded)
					s->flag[p] = at->flag[known];
			} else {
				double ma = (double)at->mass[a], mb = (double)at->mass[b];
				s->damping[p] = (real32)(at->constants->damping * real_sqrt(ma * mb / (ma + mb)));
			}
		}
	}
	memcpy(at->pair_j, list, sizeof(index16) * (size_t)slots);
	memcpy(at->ft, s->ft, sizeof(num) * (size_t)slots);
	memcpy(at->fd, s->fd, sizeof(real32) * (size_t)slots);
	memcpy(at->damping, s->damping, sizeof(real32) * (size_t)slots);
	if (bonded)
		memcpy(at->flag, s->flag, (size_t)slots);
}

/* Discs move to their new rows. */
static inline void packed_move(struct packed_place *at, struct packed_search *s)
{
	const int n = at->layout->n;
	num *wide[] = {at->vx,        at->vy,           at->w,         at->rotation, at->r, at->mass,
				   at->step_mass, at->step_inertia,
#ifdef RVE_FLOAT
				   at->rest_x,    at->rest_y,       (num *)at->sx, (num *)at->sy
#else
				   at->sx, at->sy
#endif
	};
	for (size_t f = 0; f < sizeof wide / sizeof *wide; f++) {
		for (int i = 0; i < n; i++)
			s->moved[i] = wide[f][s->order[i]];
		memcpy(wide[f], s->moved, sizeof(num) * (size_t)n);
	}
	real32 *narrow[] = {at->ux, at->uy, at->turned}, *moved32 = (real32 *)s->moved;
	for (int f = 0; f < 3; f++) {
		for (int i = 0; i < n; i++)
			moved32[i] = narrow[f][s->order[i]];
		memcpy(narrow[f], moved32, sizeof(real32) * (size_t)n);
	}
	index16 *moved16 = (index16 *)s->moved;
	for (int i = 0; i < n; i++)
		moved16[i] = at->id[s->order[i]];
	memcpy(at->id, moved16, sizeof(index16) * (size_t)n);
	for (int i = 0; i < n; i++) {
#ifdef RVE_FLOAT
		((coord *)at->ref_x)[i] = at->sx[i];
		((coord *)at->ref_y)[i] = at->sy[i];
#else
		at->ref_x[i] = (real32)at->sx[i];
		at->ref_y[i] = (real32)at->sy[i];
#endif
	}
}

static inline void packed_records(struct packed_place *at);
static inline void packed_offsets(struct packed_place *at);

/* A new list for the configuration as it is.  `moved`: there was one before.  KERNEL_SLENDER or KERNEL_CROWDED if the
 * cell has become that. */
static __attribute__((noinline)) int packed_build(struct packed_place *at, int moved)
{
	struct packed_search search, *s = &search;
	index16 old_first[UINT16_MAX / LANE_COUNT + 2];
	const int blocks = at->layout->stride / LANE_COUNT;
	packed_search_open(at, s);
	packed_rebase(at, s, moved);
	const double reach = 2.0 * at->constants->r_max * at->scale + at->constants->skin;
	if (!(cell_least_width(at->head->H) >= 2.0 * reach))
		return KERNEL_SLENDER;
	int grid[2];
	packed_sort(at, s, reach, grid);
	const int pairs = packed_find(at, s, grid);
	if (pairs < 0 || !packed_deal(at, s, pairs))
		return KERNEL_CROWDED;
	memcpy(old_first, at->first, sizeof(index16) * (size_t)(blocks + 1));
	if (packed_order(at, s, 0) > at->layout->pairs && packed_order(at, s, 1) > at->layout->pairs)
		return KERNEL_CROWDED;
	packed_write(at, s, old_first);
	packed_move(at, s);
	packed_records(at);
	packed_offsets(at);
	return KERNEL_OK;
}

/* Breaks the bonds that the motion of this sub-step has parted too far, while the old list still has them: the energy
 * is that of contacts_of_level(). */
static inline void packed_tear(struct packed_place *at)
{
	const struct rve_constants *c = at->constants;
	const double *H = at->head->H, *D = at->call->D;
	for (int row = 0; row < at->layout->n; row++)
		for (int level = at->first[row / LANE_COUNT]; level < at->first[row / LANE_COUNT + 1]; level++) {
			const int p = level * LANE_COUNT + row % LANE_COUNT, j = at->pair_j[p];
			if (at->flag[p] != BOND_INTACT)
				continue;
#ifdef RVE_FLOAT
			double ax = coord_apart(at->sx[j], at->sx[row]) * COORD_UNIT,
				   ay = coord_apart(at->sy[j], at->sy[row]) * COORD_UNIT;
#else
			double ax = at->sx[j] - at->sx[row], ay = at->sy[j] - at->sy[row];
			ax -= real_nearest(ax), ay -= real_nearest(ay);
#endif
			double bx = H[0] * ax + H[1] * ay, by = H[2] * ax + H[3] * ay, length = real_sqrt(bx * bx + by * by);
			double nx = bx / length, ny = by / length;
			double ri = (double)at->r[row], rj = (double)at->r[j], overlap = (ri + rj) * at->scale - length;
			double ux = (double)at->vx[j] - (double)at->vx[row] + D[0] * bx + D[2] * by;
			double uy = (double)at->vy[j] - (double)at->vy[row] + D[2] * bx + D[1] * by;
			double ai = ri * at->scale - 0.5 * overlap, aj = rj * at->scale - 0.5 * overlap;
			double un = ux * nx + uy * ny;
			double ut = uy * nx - ux * ny - (ai * (double)at->w[row] + aj * (double)at->w[j]);
			double ft = (double)at->ft[p], trial = ft - c->ks * ut, bears = at->bond_force * (ri + rj);
			double force = c->kn * overlap, force_old = c->kn * (overlap + un - at->scale_step * (ri + rj));
			double shear = trial < 0.0 ? -trial : trial;
			if (!(overlap < 0.0) || ((-force <= bears) & (shear <= c->bond_mu * bears)))
				continue;
			at->lanes[LANE_BOND][row % LANE_COUNT] += 0.5 / c->kn * force_old * force + 0.5 / c->ks * ft * trial;
			at->ft[p] = 0;
			at->flag[p] = BOND_BROKEN;
		}
}
