#include "run/fragments.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"

static const double BROKEN = 0.9;    /* damage: what has parted into two fields is not strained to the last */
static const double NEIGHBOUR = 1.1; /* spacings at birth: along the rows of the lattice, not across */
static const double TOUCHING = 1.6;  /* broken points that belong to one crack: across too */
static const double PARTED = 2.5;    /* spacings now: so far apart no law holds neighbours */

/* ---- boxes in the body at birth ---- */

struct boxes {
	double low[2], size;
	int nx, ny;
	int *first, *point; /* points of box b: point[first[b]] .. point[first[b + 1] - 1] */
};

static void boxes_free(struct boxes *boxes)
{
	free(boxes->first);
	free(boxes->point);
}

static int box_of(const struct boxes *boxes, const double X[2])
{
	return (int)((X[1] - boxes->low[1]) / boxes->size) * boxes->nx + (int)((X[0] - boxes->low[0]) / boxes->size);
}

static int boxes_create(struct boxes *boxes, const struct fragment_points *p, double size)
{
	double high[2] = {-INFINITY, -INFINITY};
	*boxes = (struct boxes){.low = {INFINITY, INFINITY}, .size = size};
	for (int k = 0; k < p->n; k++)
		for (int c = 0; c < 2; c++) {
			boxes->low[c] = fmin(boxes->low[c], p->X[k][c]);
			high[c] = fmax(high[c], p->X[k][c]);
		}
	double nx = p->n ? floor((high[0] - boxes->low[0]) / size) + 1.0 : 1.0,
		   ny = p->n ? floor((high[1] - boxes->low[1]) / size) + 1.0 : 1.0;
	if (!(nx * ny < 1e9))
		return error_set(STATUS_INPUT, "points lie %.3g boxes of %g m apart, expected a body", nx * ny, size);
	boxes->nx = (int)nx, boxes->ny = (int)ny;
	boxes->first = calloc((size_t)boxes->nx * (size_t)boxes->ny + 2, sizeof *boxes->first);
	boxes->point = malloc(((size_t)p->n + 1) * sizeof *boxes->point);
	if (!boxes->first || !boxes->point)
		return error_set(STATUS_RESOURCE, "out of memory for the neighbours of %d points", p->n);
	for (int k = 0; k < p->n; k++)
		boxes->first[box_of(boxes, p->X[k]) + 2]++;
	for (int b = 0; b < boxes->nx * boxes->ny; b++)
		boxes->first[b + 1] += boxes->first[b];
	for (int k = 0; k < p->n; k++)
		boxes->point[boxes->first[box_of(boxes, p->X[k]) + 1]++] = k;
	return STATUS_OK;
}

static int is_broken(const struct fragment_points *p, int k) { return p->damage[k] >= BROKEN; }

static double distance2(const double a[2], const double b[2])
{
	return (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]);
}

/* ---- sets ---- */

static int root_of(int *parent, int k)
{
	while (parent[k] != k)
		k = parent[k] = parent[parent[k]];
	return k;
}

static void unite(int *parent, int k, int m)
{
	k = root_of(parent, k), m = root_of(parent, m);
	parent[k > m ? k : m] = k > m ? m : k;
}

/* Broken points that lie beside each other, or whole ones that do and have not parted. */
static void join(const struct fragment_points *p, int broken, int k, int m, int *parent)
{
	double spacing = fmin(p->spacing[k], p->spacing[m]), reach = (broken ? TOUCHING : NEIGHBOUR) * spacing;
	if (p->body[k] == p->body[m] && is_broken(p, m) == broken && distance2(p->X[k], p->X[m]) <= reach * reach &&
		(broken || distance2(p->x[k], p->x[m]) <= PARTED * PARTED * spacing * spacing))
		unite(parent, k, m);
}

static void join_all(const struct boxes *boxes, const struct fragment_points *p, int broken, int *parent)
{
	for (int k = 0; k < p->n; k++) {
		if (is_broken(p, k) != broken)
			continue;
		int at = box_of(boxes, p->X[k]), i = at % boxes->nx, j = at / boxes->nx;
		for (int b = j > 0 ? j - 1 : 0; b <= j + 1 && b < boxes->ny; b++)
			for (int a = i > 0 ? i - 1 : 0; a <= i + 1 && a < boxes->nx; a++)
				for (int q = boxes->first[b * boxes->nx + a]; q < boxes->first[b * boxes->nx + a + 1]; q++)
					if (boxes->point[q] < k)
						join(p, broken, k, boxes->point[q], parent);
	}
}

static double largest_spacing(const struct fragment_points *p)
{
	double most = 0.0;
	for (int k = 0; k < p->n; k++)
		most = fmax(most, p->spacing[k]);
	return most > 0.0 ? most : 1.0;
}

/* parent[] of sets of points of one kind; the caller frees it. */
static int find_sets(const struct fragment_points *p, int broken, int **parent)
{
	struct boxes boxes = {0};
	*parent = malloc(((size_t)p->n + 1) * sizeof **parent);
	int status = *parent ? boxes_create(&boxes, p, TOUCHING * largest_spacing(p))
						 : error_set(STATUS_RESOURCE, "out of memory for %d points", p->n);
	for (int k = 0; k < p->n && status == STATUS_OK; k++)
		(*parent)[k] = k;
	if (status == STATUS_OK)
		join_all(&boxes, p, broken, *parent);
	boxes_free(&boxes);
	return status;
}

/* ---- pieces ---- */

static int by_size(const void *a, const void *b)
{
	const struct fragment *f = a, *g = b;
	return f->area != g->area ? (f->area < g->area) - (f->area > g->area) : f->points - g->points;
}

/* Diameter, and roundness by the longer axis of the ellipse of equal moments: 4 sqrt(largest eigenvalue). */
static void shape_of(struct fragment *f, const double moment[3])
{
	double mean = 0.5 * (moment[0] + moment[1]), d = 0.5 * (moment[0] - moment[1]);
	double longer = 4.0 * sqrt(mean + sqrt(d * d + moment[2] * moment[2]));
	f->diameter = sqrt(4.0 * f->area / M_PI);
	f->roundness = fmin(4.0 * f->area / (M_PI * longer * longer), 1.0);
}

/* Sums of the pieces, which are numbered as they come; then their order by size. */
static int measure(struct fragments *result, const struct fragment_points *p)
{
	struct fragment *list = calloc((size_t)result->count + 1, sizeof *list);
	double(*moment)[3] = calloc((size_t)result->count + 1, sizeof *moment),
	(*middle)[2] = calloc((size_t)result->count + 1, sizeof *middle);
	int *rank = malloc(((size_t)result->count + 1) * sizeof *rank), status = STATUS_OK;
	result->list = list;
	if (!list || !moment || !middle || !rank)
		status = error_set(STATUS_RESOURCE, "out of memory for %d pieces", result->count);
	for (int round = 0; round < 2 && status == STATUS_OK; round++)
		for (int k = 0; k < p->n; k++) {
			double area = p->spacing[k] * p->spacing[k];
			if (result->label[k] < 0) {
				result->broken += round ? 0.0 : area;
				continue;
			}
			struct fragment *f = &list[result->label[k]];
			double *m = moment[result->label[k]], *c = middle[result->label[k]];
			if (round == 0) {
				f->points++, f->body = p->body[k], f->mass += p->mass[k], f->area += area;
				for (int a = 0; a < 2; a++)
					f->centre[a] += p->mass[k] * p->x[k][a], c[a] += area * p->X[k][a];
				continue;
			}
			double dx = p->X[k][0] - c[0] / f->area, dy = p->X[k][1] - c[1] / f->area;
			m[0] += area * (dx * dx + area / 12.0) / f->area, m[1] += area * (dy * dy + area / 12.0) / f->area;
			m[2] += area * dx * dy / f->area;
		}
	for (int f = 0; f < result->count && status == STATUS_OK; f++) {
		list[f].centre[0] /= list[f].mass, list[f].centre[1] /= list[f].mass;
		shape_of(&list[f], moment[f]);
		rank[f] = list[f].points;
		list[f].points = f; /* who it was, while they are sorted */
	}
	if (status == STATUS_OK) {
		qsort(list, (size_t)result->count, sizeof *list, by_size);
		int *now = malloc(((size_t)result->count + 1) * sizeof *now);
		for (int f = 0; f < result->count && now; f++) {
			now[list[f].points] = f;
			list[f].points = rank[list[f].points];
		}
		for (int k = 0; k < p->n && now; k++)
			result->label[k] = result->label[k] < 0 ? -1 : now[result->label[k]];
		status = now ? status : error_set(STATUS_RESOURCE, "out of memory");
		free(now);
	}
	free(moment), free(middle), free(rank);
	return status;
}

int fragments_find(struct fragments *result, const struct fragment_points *p)
{
	int *parent = NULL;
	*result = (struct fragments){.n = p->n, .label = malloc(((size_t)p->n + 1) * sizeof *result->label)};
	int status = result->label ? find_sets(p, 0, &parent) : error_set(STATUS_RESOURCE, "out of memory");
	for (int k = 0; k < p->n && status == STATUS_OK; k++) /* a root is the lowest of its set: it comes first */
		result->label[k] = is_broken(p, k)           ? -1
						   : root_of(parent, k) == k ? result->count++
													 : result->label[root_of(parent, k)];
	if (status == STATUS_OK)
		status = measure(result, p);
	free(parent);
	if (status != STATUS_OK)
		fragments_free(result);
	return status;
}

void fragments_free(struct fragments *fragments)
{
	free(fragments->label);
	free(fragments->list);
	*fragments = (struct fragments){0};
}

struct fragment_summary fragments_summary(const struct fragments *fragments)
{
	struct fragment_summary s = {.count = fragments->count, .broken = fragments->broken};
	double square = 0.0, by_area = 0.0, area = 0.0, n = fragments->count;
	for (int f = 0; f < fragments->count; f++) {
		s.diameter_mean += fragments->list[f].diameter / n;
		s.roundness_mean += fragments->list[f].roundness / n;
		area += fragments->list[f].area;
	}
	for (int f = 0; f < fragments->count; f++)
		s.area_mean += fragments->list[f].area / area * fragments->list[f].diameter;
	for (int f = 0; f < fragments->count; f++) {
		square += pow(fragments->list[f].diameter - s.diameter_mean, 2.0) / n;
		by_area += fragments->list[f].area / area * pow(fragments->list[f].diameter - s.area_mean, 2.0);
	}
	s.diameter_deviation = sqrt(square), s.area_deviation = sqrt(by_area);
	s.largest = fragments->count ? fragments->list[0].area : 0.0;
	return s;
}

/* ---- cracks ---- */

int fragments_crack(struct crack *crack, const struct fragment_points *p, const double at[2], double reach)
{
	int *parent = NULL;
	int status = find_sets(p, 1, &parent);
	*crack = (struct crack){.tip = {NAN, NAN}, .angle = NAN};
	char *begins = status == STATUS_OK ? calloc((size_t)p->n + 1, 1) : NULL;
	for (int k = 0; k < p->n && begins; k++)
		if (is_broken(p, k) && distance2(p->X[k], at) <= reach * reach)
			begins[root_of(parent, k)] = 1;
	for (int k = 0; k < p->n && begins; k++)
		if (is_broken(p, k) && begins[root_of(parent, k)] && distance2(p->X[k], at) > crack->length * crack->length) {
			crack->length = sqrt(distance2(p->X[k], at));
			crack->angle = atan2(p->X[k][1] - at[1], p->X[k][0] - at[0]);
			crack->tip[0] = p->x[k][0], crack->tip[1] = p->x[k][1];
		}
	if (status == STATUS_OK && !begins)
		status = error_set(STATUS_RESOURCE, "out of memory for the cracks of %d points", p->n);
	free(begins), free(parent);
	return status;
}

struct edge {
	double length;
	int a, b;
};

static int by_length(const void *a, const void *b)
{
	const struct edge *e = a, *f = b;
	return e->length != f->length ? (e->length > f->length) - (e->length < f->length)
		   : e->a != f->a         ? e->a - f->a
								  : e->b - f->b;
}

/* Centres of the broken points of each box; node[box] = its number or -1. */
static int line_nodes(const struct fragment_points *p, const struct boxes *boxes, double (*nodes)[2], int *node)
{
	int n = 0;
	for (int b = 0; b < boxes->nx * boxes->ny; b++) {
		double sum[2] = {0.0, 0.0};
		int count = 0;
		for (int q = boxes->first[b]; q < boxes->first[b + 1]; q++)
			if (is_broken(p, boxes->point[q]))
				sum[0] += p->x[boxes->point[q]][0], sum[1] += p->x[boxes->point[q]][1], count++;
		node[b] = count ? n : -1;
		if (count)
			nodes[n][0] = sum[0] / count, nodes[n][1] = sum[1] / count, n++;
	}
	return n;
}

/* Edges between boxes that touch: to the right, and the three above. */
static int line_edges(const struct boxes *boxes, const double (*nodes)[2], const int *node, struct edge *edges)
{
	static const int steps[4][2] = {{1, 0}, {-1, 1}, {0, 1}, {1, 1}};
	int n = 0;
	for (int j = 0; j < boxes->ny; j++)
		for (int i = 0; i < boxes->nx; i++)
			for (int s = 0; s < 4; s++) {
				int a = i + steps[s][0], b = j + steps[s][1];
				if (node[j * boxes->nx + i] < 0 || a < 0 || a >= boxes->nx || b >= boxes->ny ||
					node[b * boxes->nx + a] < 0)
					continue;
				int u = node[j * boxes->nx + i], v = node[b * boxes->nx + a];
				edges[n++] = (struct edge){sqrt(distance2(nodes[u], nodes[v])), u, v};
			}
	return n;
}

int fragments_lines(const struct fragment_points *p, double (**nodes)[2], int *n_nodes, int (**segments)[2],
					int *n_segments)
{
	struct boxes boxes = {0};
	*nodes = NULL, *segments = NULL, *n_nodes = *n_segments = 0;
	int status = boxes_create(&boxes, p, 2.0 * largest_spacing(p));
	size_t n = (size_t)boxes.nx * (size_t)boxes.ny + 1;
	int *node = malloc(n * sizeof *node), *parent = malloc(n * sizeof *parent);
	struct edge *edges = malloc(4 * n * sizeof *edges);
	*nodes = malloc(n * sizeof **nodes), *segments = malloc(n * sizeof **segments);
	if (status == STATUS_OK && !(node && parent && edges && *nodes && *segments))
		status = error_set(STATUS_RESOURCE, "out of memory for the lines of cracks");
	if (status == STATUS_OK) {
		*n_nodes = line_nodes(p, &boxes, *nodes, node);
		int n_edges = line_edges(&boxes, (const double(*)[2]) * nodes, node, edges);
		qsort(edges, (size_t)n_edges, sizeof *edges, by_length);
		for (int k = 0; k < *n_nodes; k++)
			parent[k] = k;
		for (int e = 0; e < n_edges; e++)
			if (root_of(parent, edges[e].a) != root_of(parent, edges[e].b)) {
				unite(parent, edges[e].a, edges[e].b);
				(*segments)[*n_segments][0] = edges[e].a, (*segments)[(*n_segments)++][1] = edges[e].b;
			}
	}
	free(node), free(parent), free(edges);
	boxes_free(&boxes);
	return status;
}
