/* Rigid walls on the nodes: unilateral, with Coulomb friction, fixed or moving.
 *
 * A wall holds the nodes in or on its solid.  The normal is that of the nearest face that material can
 * reach: faces that lie in another wall or outside the scene do not count.  Where two faces are equally
 * near, a convex corner of the wall blocks only what moves against both, any other pair blocks each. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "mpm/mpm_private.h"
#include "scene/geometry.h"

static const double ON_SURFACE = 1e-6; /* of h: nearer than this is on it; scene files round their decimals */
static const double PROBE = 1e-3;      /* of h: how far before a face one looks whether it is covered */
static const double REACH = 1.5;       /* of h: how far from a point the nodes of its domain can lie */
enum { LOOKS = 6 };                    /* places on either side at which a covered face is looked at */

/* ---- geometry ---- */

/* Corners of the solid where it is now, counter-clockwise: a line's is the strip behind it.  Returns their
 * number; v has room for n_vertices + 4. */
static int wall_corners(const struct mpm *mpm, int wall, double (*v)[2])
{
	const struct scene_wall *s = &mpm->scene->walls[wall];
	const double *offset = mpm->wall_offset[wall];
	int n = s->n_vertices;
	for (int k = 0; k < n; k++)
		v[k][0] = s->vertices[k][0] + offset[0], v[k][1] = s->vertices[k][1] + offset[1];
	if (s->shape == SCENE_WALL_POLYGON)
		return n;
	double tx = v[1][0] - v[0][0], ty = v[1][1] - v[0][1], length = hypot(tx, ty);
	double back[2] = {ty / length * s->depth, -tx / length * s->depth}; /* to the right of first -> second */
	double a[2] = {v[0][0], v[0][1]}, b[2] = {v[1][0], v[1][1]};
	const double corners[4][2] = {
		{b[0], b[1]}, {a[0], a[1]}, {a[0] + back[0], a[1] + back[1]}, {b[0] + back[0], b[1] + back[1]}};
	memcpy(v, corners, sizeof corners);
	return 4;
}

/* Keeps the solid as it lies now, with the box around it. */
static void solid_update(struct mpm *mpm, int wall)
{
	struct wall_solid *solid = &mpm_work(mpm)->solids[wall];
	solid->n = wall_corners(mpm, wall, solid->v);
	for (int c = 0; c < 2; c++) {
		solid->low[c] = INFINITY, solid->high[c] = -INFINITY;
		for (int k = 0; k < solid->n; k++) {
			solid->low[c] = fmin(solid->low[c], solid->v[k][c]);
			solid->high[c] = fmax(solid->high[c], solid->v[k][c]);
		}
	}
}

bool wall_contains(const struct mpm *mpm, int wall, const double x[2], double tolerance)
{
	const struct wall_solid *s = &mpm_work(mpm)->solids[wall];
	if (x[0] < s->low[0] || x[1] < s->low[1] || x[0] > s->high[0] || x[1] > s->high[1])
		return false;
	return polygon_contains(s->n, (const double(*)[2])s->v, x, tolerance);
}

bool mpm_wall_active(const struct mpm *mpm, int wall)
{
	const struct scene *scene = mpm->scene;
	const struct scene_wall *s = &scene->walls[wall];
	/* half a step of grace: times are sums of steps */
	double now = mpm->time + 0.5 * scene->time.step;
	if (now < s->from || now >= s->until)
		return false;
	if (scene->n_stages == 0 || scene->stages[mpm->stage].n_walls < 0)
		return true;
	const struct scene_stage *stage = &scene->stages[mpm->stage];
	for (int k = 0; k < stage->n_walls; k++)
		if (stage->walls[k] == wall)
			return true;
	return false;
}

/* Nearest point of the segment ab to x. */
static void nearest_on_segment(const double a[2], const double b[2], const double x[2], double nearest[2])
{
	double tx = b[0] - a[0], ty = b[1] - a[1];
	double s = ((x[0] - a[0]) * tx + (x[1] - a[1]) * ty) / (tx * tx + ty * ty);
	s = s < 0.0 ? 0.0 : s > 1.0 ? 1.0 : s;
	nearest[0] = a[0] + s * tx, nearest[1] = a[1] + s * ty;
}

/* Is a place in the scene's box, which a grid that follows a wall takes along? */
static bool in_box(const struct mpm *mpm, const double x[2])
{
	const struct scene_grid *g = &mpm->scene->grid;
	for (int c = 0; c < 2; c++) {
		double low = g->origin[c], high = g->origin[c] + g->size[c];
		if (x[c] < grid_carried(mpm, low, c) || x[c] > grid_carried(mpm, high, c))
			return false;
	}
	return true;
}

/* Can material come to this place before a face of `wall`? */
static bool reachable(const struct mpm *mpm, int wall, const double x[2])
{
	const struct scene_grid *g = &mpm->scene->grid;
	if (!in_box(mpm, x))
		return false;
	for (int other = 0; other < mpm->scene->n_walls; other++)
		if (other != wall && mpm_work(mpm)->wall_on[other] && wall_contains(mpm, other, x, 0.1 * PROBE * g->cell))
			return false;
	return true;
}

struct face {
	int edge;
	double normal[2], distance;
};

static double length_of(double x, double y) { return sqrt(x * x + y * y); }

static double distance_to_edge(const double a[2], const double b[2], const double x[2])
{
	double q[2];
	nearest_on_segment(a, b, x, q);
	return length_of(x[0] - q[0], x[1] - q[1]);
}

/* Normal of an edge and the distance from x to its nearest part that material can reach.  Where another wall
 * covers the nearest point, parts of the edge within a point's reach may still be free.  False if none is. */
static bool look_at_face(const struct mpm *mpm, int wall, const double a[2], const double b[2], const double x[2],
						 struct face *face)
{
	double h = fmax(mpm->grid.spacing[0], mpm->grid.spacing[1]), length = length_of(b[0] - a[0], b[1] - a[1]);
	const double t[2] = {(b[0] - a[0]) / length, (b[1] - a[1]) / length};
	double at = (x[0] - a[0]) * t[0] + (x[1] - a[1]) * t[1];
	at = at < 0.0 ? 0.0 : at > length ? length : at;
	face->normal[0] = t[1], face->normal[1] = -t[0];
	for (int k = 0; k <= 2 * LOOKS; k++) {
		double s = at + (k % 2 ? 1 : -1) * ((k + 1) / 2) * REACH * h / LOOKS;
		s = s < 0.0 ? 0.0 : s > length ? length : s;
		const double y[2] = {a[0] + s * t[0], a[1] + s * t[1]};
		const double before[2] = {y[0] + PROBE * h * face->normal[0], y[1] + PROBE * h * face->normal[1]};
		face->distance = length_of(x[0] - y[0], x[1] - y[1]);
		if (reachable(mpm, wall, before))
			return true;
	}
	return false;
}

/* The two nearest faces of a polygon to x that material can reach; returns how many are equally near: 0, 1 or
 * 2.  If the nearest face of all is covered by another wall, that wall looks after the node, and only free
 * faces count from which a point's domain could reach it. */
static int nearest_faces(const struct mpm *mpm, int wall, int n, const double (*v)[2], const double x[2],
						 struct face faces[2])
{
	double h = fmax(mpm->grid.spacing[0], mpm->grid.spacing[1]), tolerance = ON_SURFACE * h, distance[n],
		   limit = INFINITY;
	int found = 0;
	for (int e = 0; e < n; e++)
		distance[e] = distance_to_edge(v[e], v[(e + 1) % n], x);
	for (int look = 0; look < n; look++) {
		int e = 0; /* from the nearest on; those that were looked at have become infinite */
		for (int f = 1; f < n; f++)
			e = distance[f] < distance[e] ? f : e;
		if (distance[e] > limit + tolerance || (found > 0 && distance[e] > faces[0].distance + tolerance))
			break;
		struct face face = {.edge = e};
		bool reached = look_at_face(mpm, wall, v[e], v[(e + 1) % n], x, &face);
		if (look == 0 && !(reached && face.distance < distance[e] + tolerance))
			limit = REACH * h;
		distance[e] = INFINITY;
		if (!reached || face.distance > limit + tolerance)
			continue;
		if (found == 0 || face.distance < faces[0].distance - tolerance)
			faces[0] = face, found = 1;
		else if (face.distance < faces[0].distance + tolerance && found < 2)
			faces[found++] = face;
	}
	return found;
}

/* Is the corner between two faces (edges of a counter-clockwise polygon) a convex one of the wall? */
static bool convex_corner(int n, const double (*v)[2], int e, int f)
{
	if ((f + 1) % n == e) {
		int swap = e;
		e = f, f = swap;
	} else if ((e + 1) % n != f) {
		return false;
	}
	const double *a = v[e], *b = v[f], *c = v[(f + 1) % n];
	return (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0]) > 0.0;
}

/* ---- finding the nodes ---- */

static void add_contact(struct mpm_work *w, const struct wall_node *contact)
{
	if (w->n_wall_nodes < w->wall_node_capacity)
		w->wall_nodes[w->n_wall_nodes++] = *contact;
}

static void add_polygon_node(struct mpm *mpm, int wall, int n, const double (*v)[2], int node, const double x[2])
{
	struct face faces[2] = {{0}};
	int found = nearest_faces(mpm, wall, n, v, x, faces);
	if (found == 0)
		return;
	struct wall_node contact = {.node = node, .wall = wall, .normals = 1};
	memcpy(contact.normal[0], faces[0].normal, sizeof contact.normal[0]);
	if (found == 2 && convex_corner(n, v, faces[0].edge, faces[1].edge)) {
		contact.normals = 2;
		memcpy(contact.normal[1], faces[1].normal, sizeof contact.normal[1]);
	}
	add_contact(mpm_work(mpm), &contact);
	if (found == 2 && contact.normals == 1) {
		memcpy(contact.normal[0], faces[1].normal, sizeof contact.normal[0]);
		add_contact(mpm_work(mpm), &contact);
	}
}

static void add_line_node(struct mpm *mpm, int wall, const double (*v)[2], int node)
{
	/* wall_corners() begins with the face, from second to first: its right is the material's side */
	double tx = v[1][0] - v[0][0], ty = v[1][1] - v[0][1], length = hypot(tx, ty);
	struct wall_node contact = {.node = node, .wall = wall, .normals = 1, .normal = {{ty / length, -tx / length}}};
	add_contact(mpm_work(mpm), &contact);
}

/* In the solid or on its surface? */
static bool solid_holds(const struct wall_solid *s, const double x[2], double on_surface)
{
	bool inside = false;
	for (int k = 0; k < s->n; k++) {
		const double *a = s->v[k], *b = s->v[(k + 1) % s->n];
		if (distance_to_edge(a, b, x) <= on_surface)
			return true;
		if ((a[1] > x[1]) != (b[1] > x[1]))
			inside ^= x[0] < a[0] + (x[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
	}
	return inside;
}

static void find_wall_nodes(struct mpm *mpm, int wall)
{
	const struct grid *grid = &mpm->grid;
	const struct wall_solid *solid = &mpm_work(mpm)->solids[wall];
	const double(*v)[2] = (const double(*)[2])solid->v;
	const int count[2] = {grid->nx, grid->ny};
	int low[2], high[2];
	for (int c = 0; c < 2; c++) {
		low[c] = (int)fmax(0.0, floor((solid->low[c] - grid->origin[c]) / grid->spacing[c]));
		high[c] = (int)fmin(count[c] - 1.0, ceil((solid->high[c] - grid->origin[c]) / grid->spacing[c]));
	}
	for (int j = low[1]; j <= high[1]; j++)
		for (int i = low[0]; i <= high[0]; i++) {
			const double x[2] = {grid->origin[0] + i * grid->spacing[0], grid->origin[1] + j * grid->spacing[1]};
			if (!solid_holds(solid, x, ON_SURFACE * grid->h))
				continue;
			if (mpm->scene->walls[wall].shape == SCENE_WALL_LINE)
				add_line_node(mpm, wall, v, j * grid->nx + i);
			else
				add_polygon_node(mpm, wall, solid->n, v, j * grid->nx + i, x);
		}
}

/* Order of the contacts: by node, then wall, then normal, whatever way they were found. */
static int compare_contacts(const void *a, const void *b)
{
	const struct wall_node *p = a, *q = b;
	if (p->node != q->node)
		return p->node < q->node ? -1 : 1;
	if (p->wall != q->wall)
		return p->wall < q->wall ? -1 : 1;
	for (int c = 0; c < 2; c++)
		if (p->normal[0][c] != q->normal[0][c])
			return p->normal[0][c] < q->normal[0][c] ? -1 : 1;
	return 0;
}

void walls_update(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	bool changed = false;
	w->n_wall_nodes = w->n_grid_wall_nodes, w->n_wall_groups = w->n_grid_wall_groups;
	for (int wall = 0; wall < mpm->scene->n_walls; wall++) {
		bool on = mpm_wall_active(mpm, wall);
		const double *at = mpm->wall_offset[wall], *found = w->wall_found[wall];
		changed = changed || on != w->wall_on[wall] || (on && (at[0] != found[0] || at[1] != found[1]));
		w->wall_on[wall] = on;
		memcpy(w->wall_found[wall], at, sizeof w->wall_found[wall]);
	}
	if (!changed)
		return;
	w->n_wall_nodes = 0;
	for (int wall = 0; wall < mpm->scene->n_walls; wall++)
		solid_update(mpm, wall);
	for (int wall = 0; wall < mpm->scene->n_walls; wall++)
		if (w->wall_on[wall] && mpm->scene->walls[wall].contact != SCENE_WALL_PENALTY)
			find_wall_nodes(mpm, wall);
	qsort(w->wall_nodes, (size_t)w->n_wall_nodes, sizeof *w->wall_nodes, compare_contacts);
	w->n_wall_groups = 0;
	for (int e = 0; e < w->n_wall_nodes; e++)
		if (e == 0 || w->wall_nodes[e].node != w->wall_nodes[e - 1].node)
			w->wall_group[w->n_wall_groups++] = e;
	w->wall_group[w->n_wall_groups] = w->n_wall_nodes;
	w->n_grid_wall_nodes = w->n_wall_nodes, w->n_grid_wall_groups = w->n_wall_groups;
	w->boundaries_stale = true; /* walls impose temperatures too */
}

/* The group of contacts of a node of the grid, -1 = none. */
static int group_of(const struct mpm_work *w, int node)
{
	int low = 0, high = w->n_grid_wall_groups;
	while (low < high) {
		int middle = (low + high) / 2;
		if (w->wall_nodes[w->wall_group[middle]].node < node)
			low = middle + 1;
		else
			high = middle;
	}
	return low < w->n_grid_wall_groups && w->wall_nodes[w->wall_group[low]].node == node ? low : -1;
}

void walls_add_fields(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	int nodes = mpm->grid.nx * mpm->grid.ny;
	w->n_wall_nodes = w->n_grid_wall_nodes, w->n_wall_groups = w->n_grid_wall_groups;
	for (int slot = nodes; slot < nodes + contact_slots_used(mpm); slot++) {
		int group = group_of(w, mpm_home(mpm, slot));
		if (group < 0)
			continue;
		for (int e = w->wall_group[group]; e < w->wall_group[group + 1]; e++) {
			struct wall_node contact = w->wall_nodes[e];
			contact.node = slot;
			add_contact(w, &contact);
		}
		w->wall_group[++w->n_wall_groups] = w->n_wall_nodes;
	}
}

/* ---- contact ---- */

/* The normal that acts: of a convex corner the one that is least violated, none if one is not. */
static bool acting_normal(const struct wall_node *contact, const double relative[2], double normal[2])
{
	const double(*n)[2] = contact->normal;
	int pick = 0;
	if (contact->normals == 2) {
		double a = relative[0] * n[0][0] + relative[1] * n[0][1], b = relative[0] * n[1][0] + relative[1] * n[1][1];
		if (a >= 0.0 || b >= 0.0)
			return false;
		pick = b > a;
	}
	normal[0] = n[pick][0], normal[1] = n[pick][1];
	return true;
}

/* One contact acts on its node's velocity.  Push and drag are totals of the step and are clamped as such, so
 * that a later sweep can take back what an earlier one did too much. */
static void contact_act(const struct scene_wall *s, const struct wall_node *contact, struct wall_effect *effect,
						double v[2])
{
	const double relative[2] = {v[0] - s->velocity[0], v[1] - s->velocity[1]};
	if (effect->push == 0.0 && !acting_normal(contact, relative, effect->normal))
		return;
	const double *n = effect->normal;
	double vn = relative[0] * n[0] + relative[1] * n[1], vt = -relative[0] * n[1] + relative[1] * n[0];
	double push = effect->push - vn, drag = effect->drag - vt;
	if (s->contact == SCENE_WALL_FRICTIONAL) {
		push = push > 0.0 ? push : 0.0;
		double limit = s->friction * push;
		drag = drag > limit ? limit : drag < -limit ? -limit : drag;
	} else if (s->contact == SCENE_WALL_SLIP) {
		drag = 0.0;
	}
	double dn = push - effect->push, dt = drag - effect->drag;
	v[0] += dn * n[0] - dt * n[1];
	v[1] += dn * n[1] + dt * n[0];
	effect->push = push, effect->drag = drag;
}

void walls_apply(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
#pragma omp parallel for schedule(static) if (mpm_parallel(mpm))
	for (int g = 0; g < w->n_wall_groups; g++) {
		int first = w->wall_group[g], last = w->wall_group[g + 1], node = w->wall_nodes[first].node;
		memset(w->wall_effects + first, 0, (size_t)(last - first) * sizeof *w->wall_effects);
		if (!(mpm->grid.mass[node] > 0.0))
			continue;
		for (int sweep = 0; sweep < (last - first > 1 ? WALL_SWEEPS : 1); sweep++)
			for (int e = first; e < last; e++)
				contact_act(&mpm->scene->walls[w->wall_nodes[e].wall], &w->wall_nodes[e], &w->wall_effects[e],
							mpm->grid.v_new[node]);
	}
}

/* A contact allows no motion into its wall, and none at all against what ties it. */
static void contact_hold(const struct scene_wall *s, const struct wall_node *contact, double v[2])
{
	const double relative[2] = {v[0] - s->velocity[0], v[1] - s->velocity[1]};
	double n[2];
	if (s->contact == SCENE_WALL_STICK) {
		memcpy(v, s->velocity, 2 * sizeof *v);
	} else if (acting_normal(contact, relative, n)) {
		double vn = relative[0] * n[0] + relative[1] * n[1];
		if (s->contact == SCENE_WALL_FRICTIONAL && vn > 0.0)
			return;
		v[0] -= vn * n[0];
		v[1] -= vn * n[1];
	}
}

/* What walls allow of the velocities in which points strain (USF, MUSL).  No force acts and nothing is booked:
 * friction, a force, has its say in the step itself. */
void walls_hold(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
#pragma omp parallel for schedule(static) if (mpm_parallel(mpm))
	for (int g = 0; g < w->n_wall_groups; g++) {
		int first = w->wall_group[g], last = w->wall_group[g + 1], node = w->wall_nodes[first].node;
		for (int sweep = 0; sweep < (last - first > 1 ? WALL_SWEEPS : 1) && mpm->grid.mass[node] > 0.0; sweep++)
			for (int e = first; e < last; e++)
				contact_hold(&mpm->scene->walls[w->wall_nodes[e].wall], &w->wall_nodes[e], w->projected[node].strain);
	}
}

/* Where the work of a contact went: its impulse times the wall's velocity is work done by the wall; times the
 * mean slip it is friction; times the mean normal velocity it is lost in the impact. */
static void wall_contact_account(struct mpm *mpm, struct mpm_work *w, int e)
{
	struct wall_effect *effect = &w->wall_effects[e];
	const struct scene_wall *s = &mpm->scene->walls[w->wall_nodes[e].wall];
	int node = w->wall_nodes[e].node;
	double m = mpm->grid.mass[node];
	const double *v = mpm->grid.v[node], *u = mpm->grid.v_new[node], *n = effect->normal;
	const double slip[2] = {0.5 * (v[0] + u[0]) - s->velocity[0], 0.5 * (v[1] + u[1]) - s->velocity[1]};
	double normal_loss = -m * effect->push * (slip[0] * n[0] + slip[1] * n[1]);
	double tangent_loss = -m * effect->drag * (-slip[0] * n[1] + slip[1] * n[0]);
	effect->impulse[0] = m * (effect->push * n[0] - effect->drag * n[1]);
	effect->impulse[1] = m * (effect->push * n[1] + effect->drag * n[0]);
	effect->boundary = effect->impulse[0] * s->velocity[0] + effect->impulse[1] * s->velocity[1];
	bool rubs = s->contact == SCENE_WALL_FRICTIONAL;
	effect->friction = rubs ? tangent_loss : 0.0;
	effect->impact = rubs ? normal_loss : normal_loss + tangent_loss;
	if (w->wall_heat)
		w->wall_heat[node] += s->heat_share * effect->friction;
}

void walls_account(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
#pragma omp parallel for schedule(static) if (mpm_parallel(mpm))
	for (int g = 0; g < w->n_wall_groups; g++)
		for (int e = w->wall_group[g]; e < w->wall_group[g + 1]; e++)
			wall_contact_account(mpm, w, e);
}

int mpm_wall_loads(const struct mpm *mpm, struct mpm_wall_load *loads, int n)
{
	const struct mpm_work *w = mpm_work(mpm);
	const struct grid *grid = &mpm->grid;
	int count = 0;
	for (int e = 0; e < w->n_wall_nodes && mpm->dt > 0.0; e++) {
		const struct wall_effect *effect = &w->wall_effects[e];
		if (effect->push == 0.0)
			continue;
		if (count < n) {
			struct mpm_wall_load *load = &loads[count];
			int node = contact_home(mpm, w->wall_nodes[e].node), place[2] = {node % grid->nx, node / grid->nx};
			load->wall = w->wall_nodes[e].wall;
			for (int c = 0; c < 2; c++) {
				load->at[c] = grid->origin[c] + place[c] * grid->spacing[c];
				load->normal[c] = effect->normal[c];
				load->force[c] = -effect->impulse[c] / mpm->dt;
			}
		}
		count++;
	}
	return count;
}

void walls_move(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	for (int wall = 0; wall < mpm->scene->n_walls; wall++)
		if (w->wall_on[wall])
			for (int c = 0; c < 2; c++)
				mpm->wall_offset[wall][c] += mpm->scene->walls[wall].velocity[c] * mpm->dt;
}

/* ---- life ---- */

/* Most contacts that a wall can have: its box moves, its size does not, but the cells may shrink. */
static size_t most_contacts(const struct mpm *mpm, int wall)
{
	const struct wall_solid *solid = &mpm_work(mpm)->solids[wall];
	size_t nodes = 1;
	double least = mpm->grid.h * (mpm->scene->grid.follows ? GRID_LEAST : 1.0);
	for (int c = 0; c < 2; c++) {
		double count = fmin((solid->high[c] - solid->low[c]) / least + 3.0, c == 0 ? mpm->grid.nx : mpm->grid.ny);
		nodes *= (size_t)count + 1;
	}
	return 2 * nodes;
}

int walls_create(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	size_t n = (size_t)mpm->scene->n_walls, capacity = 1;
	mpm->walls = calloc(n + 1, sizeof *mpm->walls);
	mpm->wall_offset = calloc(n + 1, sizeof *mpm->wall_offset);
	w->wall_on = calloc(n + 1, sizeof *w->wall_on);
	w->wall_found = calloc(n + 1, sizeof *w->wall_found);
	w->solids = calloc(n + 1, sizeof *w->solids);
	bool complete = mpm->walls && mpm->wall_offset && w->wall_on && w->wall_found && w->solids;
	for (size_t wall = 0; wall < n && complete; wall++) {
		w->solids[wall].v = calloc((size_t)mpm->scene->walls[wall].n_vertices + 4, sizeof *w->solids[wall].v);
		complete = w->solids[wall].v != NULL;
	}
	if (!complete)
		return error_set(STATUS_RESOURCE, "out of memory for %zu walls", n);
	bool heats = false;
	for (int wall = 0; wall < mpm->scene->n_walls; wall++) {
		solid_update(mpm, wall);
		capacity += most_contacts(mpm, wall);
		heats = heats || mpm->scene->walls[wall].heat_share > 0.0;
	}
	/* each extra field may meet as many walls as a node does */
	capacity += (size_t)(contact_slots(mpm) * 2 * mpm->scene->n_walls);
	w->wall_node_capacity = (int)capacity;
	w->wall_nodes = calloc(capacity, sizeof *w->wall_nodes);
	w->wall_effects = calloc(capacity, sizeof *w->wall_effects);
	w->wall_group = calloc(capacity + 1, sizeof *w->wall_group);
	if (heats && mpm->thermal)
		w->wall_heat = calloc(w->n_nodes, sizeof *w->wall_heat);
	if (!w->wall_nodes || !w->wall_effects || !w->wall_group || (heats && mpm->thermal && !w->wall_heat))
		return error_set(STATUS_RESOURCE, "out of memory for the nodes of %zu walls", n);
	return STATUS_OK;
}

void walls_free(struct mpm *mpm)
{
	struct mpm_work *w = mpm_work(mpm);
	free(mpm->walls);
	free(mpm->wall_offset);
	free(w->wall_on);
	free(w->wall_found);
	for (int wall = 0; w->solids && wall < mpm->scene->n_walls; wall++)
		free(w->solids[wall].v);
	free(w->solids);
	free(w->wall_nodes);
	free(w->wall_effects);
	free(w->wall_group);
	free(w->wall_heat);
}
