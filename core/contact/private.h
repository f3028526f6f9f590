/* Inside of core/contact. */
#ifndef TMDEMPM_CONTACT_PRIVATE_H
#define TMDEMPM_CONTACT_PRIVATE_H

#include "contact/contact.h"
#include "mpm/mpm_private.h"

/* One field of a node that has several.  Sums are over the points of the field; S is the weight of the node. */
struct contact_field {
	int node;            /* index in the arrays by node: the grid's own, or a slot */
	int label;           /* of the body; others that are welded to it have joined it here */
	int side;            /* of a crack in it: 0 or 1 */
	bool sided;          /* there are both */
	double direction[2]; /* 1/m: points whose damage gradient goes against it are on side 1 */
	double gradient[2];  /* kg/m, sum m grad S: points out of the body */
	double volume;       /* m3, sum V S */
	double heat;         /* J, of friction, in this step */
	double plain, lift;  /* K, J: mean of the points' temperatures, and what their slope adds at the node */
	double slope[2];     /* J/m, sum m c S grad T */
	bool conducts;       /* to another body, in this step */
	double pressure;     /* Pa, of its contacts in this step */
};

/* A node with several fields: fields[first .. first + n - 1], in the order of their labels. */
struct contact_place {
	int node, first, n;
	int first_pair, n_pairs;
	double friction, impact, heat; /* J in this step: turned into heat, lost, given to the points */
};

/* Two fields that touch at a node. */
struct contact_pair {
	int a, b;          /* indices of the fields */
	int contact;       /* index into the scene's contacts */
	double normal[2];  /* unit vector, from a to b */
	double area;       /* m2, of the surface that belongs to this node */
	double capacity;   /* J/(m3 K), of the one that holds less heat */
	double face;       /* m, where the face lies along the normal, from the node */
	double push, drag; /* kg m/s on b, along the normal and along the normal turned by +90 degrees; 0 = apart */
};

struct contact {
	int n_labels;
	int *label;  /* by body */
	int *pair;   /* label * n_labels + label -> index into the scene's contacts, -1 = welded */
	int *own;    /* label -> the contact between the faces of its own cracks, -1 = they are welded */
	bool cracks; /* some label has one, and the law breaks */

	int n_slots, slots_most;
	int n_places, n_fields, n_pairs;
	struct contact_place *places; /* by node */
	struct contact_field *fields;
	struct contact_pair *pairs;
	int *first;             /* by grid node: its first field, -1 = it has one only */
	int *home;              /* by slot: the grid's node that it belongs to */
	int *cell_label;        /* by grid cell: label of its points, or one of the below */
	bool *near;             /* by grid cell: a point in it may belong to a field of such a node */
	unsigned char *meets;   /* by grid node: enum contact_meeting */
	double (*direction)[2]; /* by grid node where SIDES_MEET: tells them apart */
	bool *hot;              /* by grid cell: near damage, at the last look */
	bool *broken;           /* by grid cell: a point in it is broken, of a body whose cracks have faces */
	bool *marked;           /* by grid cell: whose points have to do with a pass, see contact_mark_cells() */
};

#define CONTACT_BROKEN 0.9999 /* damage from which a point counts as broken */

enum { CELL_EMPTY = -1, CELL_MIXED = -2 };

/* The grid cells whose points reach node (i, j): columns and rows low .. high. */
void contact_cells_about(const struct mpm *mpm, int i, int j, int low[2], int high[2]);

enum contact_meeting { NOTHING_MEETS, LABELS_MEET, SIDES_MEET };

/* Marks the cells about those places for which `wanted` says so; false if there are none. */
bool contact_mark_cells(const struct mpm *mpm, bool (*wanted)(const struct mpm *, const struct contact_place *));

/* Gradients of the points' damage, 1/m, every few steps. */
void contact_find_gradients(struct mpm *mpm);

/* Does a node have points of a body on both sides of a crack that is through?  Then `direction` tells them apart. */
bool contact_sides(const struct mpm *mpm, const struct contact *c, int i, int j, int label, double direction[2]);

static inline int contact_side(const double direction[2], const double gradient[2])
{
	return direction[0] * gradient[0] + direction[1] * gradient[1] < 0.0;
}

/* Is a body part of the field of another (or its own)? */
static inline bool contact_joins(const struct contact *c, int field, int label)
{
	return field == label || c->pair[field * c->n_labels + label] < 0;
}

/* The field of a place to which point q, near its node, belongs. */
static inline struct contact_field *contact_field_of(const struct mpm *mpm, const struct contact *c, int node, int q)
{
	struct contact_field *field = &c->fields[c->first[node]];
	int label = c->label[mpm->p.body[q]];
	while (!contact_joins(c, field->label, label))
		field++;
	return field->sided ? field + contact_side(field->direction, mpm->p.damage_gradient[q]) : field;
}

/* The next points of order[*i .. last - 1] in cells for which `wanted` holds, at most a chunk of them; how many. */
static inline int contact_pick(const struct mpm_work *w, const bool *wanted, int *i, int last, int *points)
{
	int n = 0;
	for (; *i < last && n < SHAPE_CHUNK; ++*i) {
		points[n] = w->order[*i];
		n += wanted[w->cell[points[n]]];
	}
	return n;
}

/* Is any of a chunk's points near a node with several fields? */
static inline bool contact_is_near(const struct mpm *mpm, int point)
{
	const struct mpm_work *w = mpm_work(mpm);
	return w->contact->near[w->cell[point]];
}

#endif
