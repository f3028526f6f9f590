/* Bodies that touch: several velocity and temperature fields at a node, and what acts between them
 * (DP-MPM sections 3.2 and 3.3).
 *
 * A node at which two bodies meet carries one field for each of them.  The first field lives in the grid's own node;
 * the others get a slot from a pool that lies behind the grid's nodes in every array by node, in rows of their own.
 * The lists of (node, weight, gradient) of the points that belong to such a field are sent to its slot as they are
 * filled, so that every pass over points or rows of nodes works on fields without knowing of them.  Nothing of this
 * exists in a scene without contacts: no slot, no pass, no branch but one.
 *
 * Bodies of one label share a field: those that no contact of the scene names.  At a node a body is welded to the first
 * one there with which it has no contact: it joins its field.  The faces of a crack share one until it is through; a
 * field for each side before that would hide the opening of the crack from the strain of the points beside it.
 *
 * In a step, after the nodes' free step and before the walls: fields that move into each other and touch exchange the
 * impulse that stops them, and a Coulomb share of what stops their slip. */
#ifndef TMDEMPM_CONTACT_CONTACT_H
#define TMDEMPM_CONTACT_CONTACT_H

#include <stdbool.h>
#include <stddef.h>

struct mpm;
struct shape_lists;

enum { CONTACT_FIELDS_MOST = 8 }; /* at one node */

/* How many slots a scene's pool has: 0 without contacts. */
int contact_slots(const struct mpm *mpm);

/* And how many are in use in this step. */
int contact_slots_used(const struct mpm *mpm);

/* Sets work->contact (NULL if the scene has no contacts).  STATUS_RESOURCE for lack of memory. */
int contact_create(struct mpm *mpm);
void contact_free(struct mpm *mpm);
size_t contact_memory(const struct mpm *mpm);

/* After the points have been sorted, before they go to the grid: which fields meet where in this step.
 * STATUS_GUARD, with the node and the cure, if a node would need more fields than there are. */
int contact_find_fields(struct mpm *mpm);

/* The grid's node of a node or slot. */
int contact_home(const struct mpm *mpm, int node);

/* Gives a velocity to the field of a node to which a body belongs.  False if the node has one field
 * only. */
bool contact_drive(struct mpm *mpm, int node, int body, const double v[2]);

/* Sends the lists of n points, just filled, to the slots of their fields. */
void contact_redirect(const struct mpm *mpm, int n, const int *point, struct shape_lists *lists);

/* After the points have gone to the grid: the sums that normals and gaps come from. */
void contact_gather(struct mpm *mpm);

/* After the nodes' free step: the contact forces' change of the new velocities. */
void contact_apply(struct mpm *mpm);

/* When the new velocities are final: where the work of the contacts went, and the pressure at the points. */
void contact_account(struct mpm *mpm);

/* The temperatures of fields that conduct heat to another, before heat flows in this step: at the node, not at the
 * centre of the points that lie on one side of it. */
void contact_set_temperatures(struct mpm *mpm);

/* Heat that flows between and into the fields of a node in one pass of dt seconds of thermal time: adds to the nodes'
 * flows, W.  Conduction adds up to zero. */
void contact_exchange_heat(struct mpm *mpm, double dt);

/* At the end of a step, for those who look at the grid: a node's values become those of all its fields, sums of mass and
 * force, means of velocity and temperature. */
void contact_fold(struct mpm *mpm);

/* Adds the sums of this step to the ledger. */
void contact_add_to_ledger(struct mpm *mpm);

/* ---- penalty walls (penalty.c) ---- */

/* Sets work->penalty (NULL if the scene has no such wall). */
int penalty_create(struct mpm *mpm);
void penalty_free(struct mpm *mpm);

/* The forces of this step, from where the points are. */
void penalty_push(struct mpm *mpm);
const double *penalty_force(const struct mpm *mpm, int point);  /* N */
const double *penalty_on_wall(const struct mpm *mpm, int wall); /* N */
double penalty_pressure(const struct mpm *mpm, int point);      /* Pa; 0 without such walls */

#endif
