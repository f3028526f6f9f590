/* Lists of the shape functions (shape.h), a vector of points at a time.  Included by kernel.h only.
 *
 * The last vector of a chunk repeats the last point where there are no more. */

/* Places in cells of the grid, from node (0, 0). */
INLINE void vec_places(const struct shape_grid *grid, const struct shape_points *points, const struct lanes *lanes,
					   vec *x, vec *y)
{
	vec place[2];
	vec_of2(points->x, lanes, place);
	*x = (place[0] - vec_set(grid->origin[0])) * vec_set(grid->inverse_h[0]);
	*y = (place[1] - vec_set(grid->origin[1])) * vec_set(grid->inverse_h[1]);
}

/* The body of a vector of points, -1 if they are of several. */
INLINE int vec_body(const struct shape_points *points, const struct lanes *lanes)
{
	int body = points->body[lanes->at[0]], differs = 0;
	for (int l = 1; l < VECTOR_WIDTH; l++)
		differs |= points->body[lanes->at[l]] ^ body;
	return differs ? -1 : body;
}

/* Entries from number k on of lists that begin at the nodes `first` of the grid, as tensor products of n
 * one-dimensional lists. */
INLINE void tensor_product(int n, whole first, int nx, const vec *wx, const vec *wy, const vec *gx, const vec *gy,
						   int k, struct shape_lists *lists)
{
	for (int b = 0; b < n; b++)
		for (int a = 0; a < n; a++) {
			int e = b * n + a;
			*(whole *)&lists->node[e][k] = first + (b * nx + a);
			vec_store(&lists->weight[e][k], wx[a] * wy[b]);
			vec_store(&lists->grad_x[e][k], gx[a] * wy[b]);
			vec_store(&lists->grad_y[e][k], wx[a] * gy[b]);
		}
}

static void linear_fill(const struct shape_grid *grid, const struct shape_points *points, int n, const int *point,
						struct shape_lists *lists)
{
	const vec one = vec_set(1.0);
	const vec gx[2] = {vec_set(-grid->inverse_h[0]), vec_set(grid->inverse_h[0])};
	const vec gy[2] = {vec_set(-grid->inverse_h[1]), vec_set(grid->inverse_h[1])};
	lists->side = 2, lists->nodes = 4;
	for (int k = 0; k < n; k += VECTOR_WIDTH) {
		const struct lanes lanes = lanes_of(n, point, k);
		vec x, y;
		vec_places(grid, points, &lanes, &x, &y);
		whole i = vec_truncated(x), j = vec_truncated(y);
		x -= vec_of_whole(i), y -= vec_of_whole(j);
		const vec wx[2] = {one - x, x}, wy[2] = {one - y, y};
		tensor_product(2, j * grid->nx + i, grid->nx, wx, wy, gx, gy, k, lists);
	}
}

/* The linear hat function averaged over the domain [f - l, f + l] (uGIMP, in units of h), on the node
 * nearest to the point (middle) and its two neighbours; f in [-1/2, 1/2] is counted from the middle node.
 * One formula for all positions: with c = f clamped to [-l, l] the left weight is (l - c)^2 / 4l plus what
 * f lies beyond -l, and so on.  The weights add up to 1 and the gradients to 0 by construction. */
INLINE void ugimp_1d(vec f, vec l, vec inverse_2l, vec s, vec w[3], vec g[3])
{
	const vec none = vec_set(0.0);
	vec c = vec_min(vec_max(f, -l), l), left = l - c, right = l + c, beyond = f - c;
	w[0] = vec_set(0.5) * left * left * inverse_2l - vec_min(beyond, none);
	w[2] = vec_set(0.5) * right * right * inverse_2l + vec_max(beyond, none);
	w[1] = vec_set(1.0) - w[0] - w[2];
	g[0] = -left * inverse_2l * s;
	g[2] = right * inverse_2l * s;
	g[1] = -(g[0] + g[2]);
}

static void ugimp_fill(const struct shape_grid *grid, const struct shape_points *points, int n, const int *point,
					   struct shape_lists *lists)
{
	const vec half = vec_set(0.5), sx = vec_set(grid->inverse_h[0]), sy = vec_set(grid->inverse_h[1]);
	lists->side = 3, lists->nodes = 9;
	for (int k = 0; k < n; k += VECTOR_WIDTH) {
		const struct lanes lanes = lanes_of(n, point, k);
		vec x, y, l, wx[3], wy[3], gx[3], gy[3];
		vec_places(grid, points, &lanes, &x, &y);
		int body = vec_body(points, &lanes);
		l = vec_set(points->half[body < 0 ? 0 : body]);
		for (int m = 0; m < VECTOR_WIDTH && body < 0; m++)
			l[m] = points->half[points->body[lanes.at[m]]];
		whole i = vec_truncated(x + half), j = vec_truncated(y + half); /* nearest node */
		vec inverse_2l = half / l;
		ugimp_1d(x - vec_of_whole(i), l, inverse_2l, sx, wx, gx);
		ugimp_1d(y - vec_of_whole(j), l, inverse_2l, sy, wy, gy);
		tensor_product(3, (j - 1) * grid->nx + i - 1, grid->nx, wx, wy, gx, gy, k, lists);
	}
}

/* ---- CPDI ----
 *
 * The domain of a point is a parallelogram that deforms with it (Sadeghirad, Brannon and Burghardt 2011): with its
 * edges r1 and r2 the corners are x1..x4 = x + (-r1-r2, r1-r2, r1+r2, -r1+r2)/2, the weight is the mean of the hat
 * function's values there, and the gradient, its mean over the domain when it is bilinear between the corners,
 *     1/(2 r1 x r2) { (S1 - S3) [r1y - r2y, r2x - r1x] + (S2 - S4) [r1y + r2y, -(r1x + r2x)] }.
 * In the half-diagonals a = (r1 + r2)/2 and b = (r1 - r2)/2: x3, x1 = x +- a, x2, x4 = x +- b, and the gradient is
 *     1/(2 a x b) { (S3 - S1) [by, -bx] + (S2 - S4) [-ay, ax] }.
 * Weights and gradients add up to 1 and 0, and give back linear fields exactly, whatever the parallelogram. */

/* Cuts a half-diagonal to SHAPE_DIAGONAL cells. */
INLINE void cut_diagonal(vec *x, vec *y)
{
	vec length2 = *x * *x + *y * *y;
	mask beyond = mask_above(length2, vec_set(SHAPE_DIAGONAL * SHAPE_DIAGONAL));
	if (!mask_any(beyond))
		return;
	vec cut = vec_set(SHAPE_DIAGONAL) / vec_sqrt(length2);
	*x = vec_select(beyond, *x * cut, *x), *y = vec_select(beyond, *y * cut, *y);
}

/* Half-diagonals of points, in cells, cut to SHAPE_DIAGONAL: ax ay bx by.  What is cut is the reach, not the point. */
INLINE void half_diagonals(const struct shape_grid *grid, const struct shape_points *points, const struct lanes *lanes,
						   vec d[4])
{
	const double *of_edge[VECTOR_WIDTH];
	const int body = vec_body(points, lanes);
	for (int l = 0; l < VECTOR_WIDTH; l++)
		of_edge[l] = points->edge[points->body[lanes->at[l]]];
	vec F[4], e[4];
	vec_of4(points->F, lanes, F);
	if (body < 0)
		vec_fetch4(of_edge, &e[0], &e[1], &e[2], &e[3]);
	for (int c = 0; c < 4 && body >= 0; c++)
		e[c] = vec_set(points->edge[body][c]);
	const vec sx = vec_set(0.5 * grid->inverse_h[0]), sy = vec_set(0.5 * grid->inverse_h[1]);
	const vec ux = e[0] + e[2], uy = e[1] + e[3], vx = e[0] - e[2], vy = e[1] - e[3];
	d[0] = (F[0] * ux + F[1] * uy) * sx, d[1] = (F[2] * ux + F[3] * uy) * sy;
	d[2] = (F[0] * vx + F[1] * vy) * sx, d[3] = (F[2] * vx + F[3] * vy) * sy;
	cut_diagonal(&d[0], &d[1]);
	cut_diagonal(&d[2], &d[3]);
}

/* Hat functions of the nodes 0 .. side - 1 at u. */
INLINE void hats(int side, vec u, vec *w)
{
	for (int i = 0; i < side; i++)
		w[i] = vec_max(vec_set(1.0) - vec_magnitude(u - vec_set(i)), vec_set(0.0));
}

/* Entries from number k on of points whose places are (x, y) cells from their first nodes. */
INLINE void cpdi_points(const struct shape_grid *grid, int side, whole first, vec x, vec y, const vec d[4], int k,
						struct shape_lists *lists)
{
	vec wx[4][4], wy[4][4];
	hats(side, x + d[0], wx[0]), hats(side, y + d[1], wy[0]);
	hats(side, x - d[0], wx[1]), hats(side, y - d[1], wy[1]);
	hats(side, x + d[2], wx[2]), hats(side, y + d[3], wy[2]);
	hats(side, x - d[2], wx[3]), hats(side, y - d[3], wy[3]);
	vec area = vec_set(0.5) / (d[0] * d[3] - d[1] * d[2]);
	vec sx = area * vec_set(grid->inverse_h[0]), sy = area * vec_set(grid->inverse_h[1]);
	vec px = sx * d[3], py = -sy * d[2], qx = -sx * d[1], qy = sy * d[0];
	for (int j = 0; j < side; j++)
		for (int i = 0; i < side; i++) {
			vec a = wx[0][i] * wy[0][j], b = wx[1][i] * wy[1][j], c = wx[2][i] * wy[2][j], e = wx[3][i] * wy[3][j];
			int entry = j * side + i;
			*(whole *)&lists->node[entry][k] = first + (j * grid->nx + i);
			vec_store(&lists->weight[entry][k], vec_set(0.25) * ((a + b) + (c + e)));
			vec_store(&lists->grad_x[entry][k], (a - b) * px + (c - e) * qx);
			vec_store(&lists->grad_y[entry][k], (a - b) * py + (c - e) * qy);
		}
}

INLINE void cpdi_chunk(const struct shape_grid *grid, const struct shape_points *points, int n, const int *point,
					   vec (*d)[4], int side, struct shape_lists *lists)
{
	/* three nodes about the nearest one, or four about the cell */
	const vec nearest = vec_set(side == 3 ? 0.5 : 0.0);
	lists->side = side, lists->nodes = side * side;
	for (int k = 0; k < n; k += VECTOR_WIDTH) {
		const struct lanes lanes = lanes_of(n, point, k);
		vec x, y;
		vec_places(grid, points, &lanes, &x, &y);
		whole i = vec_truncated(x + nearest) - 1, j = vec_truncated(y + nearest) - 1;
		cpdi_points(grid, side, j * grid->nx + i, x - vec_of_whole(i), y - vec_of_whole(j), d[k / VECTOR_WIDTH], k,
					lists);
	}
}

/* A chunk in which every corner lies within half a cell of its point in both directions needs three nodes a side. */
static void cpdi_fill(const struct shape_grid *grid, const struct shape_points *points, int n, const int *point,
					  struct shape_lists *lists)
{
	vec d[SHAPE_CHUNK / VECTOR_WIDTH][4], most = vec_set(0.0);
	for (int k = 0; k < n; k += VECTOR_WIDTH) {
		const struct lanes lanes = lanes_of(n, point, k);
		vec *of_points = d[k / VECTOR_WIDTH];
		half_diagonals(grid, points, &lanes, of_points);
		for (int c = 0; c < 4; c++)
			most = vec_max(vec_magnitude(of_points[c]), most);
	}
	if (mask_any(mask_above(most, vec_set(0.5))))
		cpdi_chunk(grid, points, n, point, d, 4, lists);
	else
		cpdi_chunk(grid, points, n, point, d, 3, lists);
}
