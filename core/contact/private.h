/* Inside of core/contact. */
#ifndef TMDEMPM_CONTACT_PRIVATE_H
#define TMDEMPM_CONTACT_PRIVATE_H

#include "contact/contact.h"
#include "mpm/mpm_private.h"

/* One field of a node that has several.  Sums are over the points of the field; S is the weight of the node. */
struct contact_field {
	int node;           /* index in the arrays by node: the grid's own, or a slot */
	int label;          /* of the body */
	int unit;           /* field (index) that stands for the fields bonded to this one; -1 = no mass here */
	double gradient[2]; /* kg/m, sum m grad S: points out of the body */
	double volume;      /* m3, sum V S */
	double bond[2];     /* kg m/s, from the fields bonded to this one, in this step */
	double heat;        /* J, of friction, in this step */
	double pressure;    /* Pa, of the contacts of this field's unit, in this step */
};

/* A node with several fields: fields[first .. first + n - 1], in the order of their labels. */
struct contact_place {
	int node, first, n;
	int first_pair, n_pairs;
	double friction, impact, heat; /* J in this step: turned into heat, lost, given to the points */
};

/* Two units that may touch at a node. */
struct contact_pair {
	int a, b;          /* fields that stand for the units */
	int contact;       /* index into the scene's contacts */
	double normal[2];  /* unit vector, from a to b */
	double area;       /* m2, of the surface that belongs to this node */
	double push, drag; /* kg m/s on b, along the normal and along the normal turned by +90 degrees; 0 = apart */
};

/* Sums of the units of a place while it is worked on. */
struct contact_unit {
	int field; /* that stands for it */
	double mass, volume;
	double v[2];
	double gradient[2];
	double heat, capacity; /* J, J/K */
};

struct contact {
	int n_labels;
	int *label; /* by body */
	int *pair;  /* label * n_labels + label -> index into the scene's contacts, -1 = bonded */

	int n_slots, slots_most;
	int n_places, n_fields, n_pairs;
	struct contact_place *places; /* by node */
	struct contact_field *fields;
	struct contact_pair *pairs;
	int *first;      /* by grid node: its first field, -1 = it has one only */
	int *home;       /* by slot: the grid's node that it belongs to */
	int *cell_label; /* by grid cell: label of its points, or one of the below */
	bool *near;      /* by grid cell: a point in it may belong to a field of such a node */
	bool *mixed;     /* by grid node: several labels in reach */

};

enum { CELL_EMPTY = -1, CELL_MIXED = -2 };

/* The grid cells whose points reach node (i, j): columns and rows low .. high. */
void contact_cells_about(const struct mpm *mpm, int i, int j, int low[2], int high[2]);

/* The field of a place to which a point belongs; NULL only for a point that does not touch the node. */
static inline struct contact_field *contact_field_of(const struct contact *c, int node, int label)
{
	struct contact_field *field = &c->fields[c->first[node]];
	while (field->label != label)
		field++;
	return field;
}

/* Is any of a chunk's points near a node with several fields? */
static inline bool contact_is_near(const struct mpm *mpm, int point)
{
	const struct mpm_work *w = mpm_work(mpm);
	return w->contact->near[w->cell[point]];
}

#endif
