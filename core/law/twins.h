/* Twins: points whose RVEs are equal, bit for bit, share one state as long as the same happens to them.
 *
 * An RVE's bits depend on its state and on what it is told, so the results are those of RVEs of their own, exactly.
 * A point that parts gets a copy of the state.  Points that have parted do not meet again: their states keep what they
 * went through.  Only a restart looks once more which are equal. */
#ifndef TMDEMPM_LAW_TWINS_H
#define TMDEMPM_LAW_TWINS_H

#include <stdbool.h>

#include "rve/rve.h"

struct twins {
	const struct rve_model *model;
	unsigned char *states; /* the law's */
	int n;
	int *home;                              /* [n]: the slot whose state is that of slot k; home[home[k]] == home[k] */
	int *sharers;                           /* [n]: how many slots have slot k as their home */
	int shared;                             /* slots that are not at home: 0 = there are no twins left */
	long long saved_calls, saved_sub_steps; /* since create: of points whose twin was computed */
	/* of one call: the distinct RVEs, by their first point in the batch */
	int *first, *slot, *member, *table;
	int table_size;
	double (*L)[4], *dT, *T;
	double (*stress)[4], *heat, (*conductivity)[3], *modulus;
};

/* For n states that are there.  Looks which of them are equal. */
int twins_create(struct twins **twins, const struct rve_model *model, unsigned char *states, int n);
void twins_free(struct twins *twins);

/* After the states were replaced: looks again. */
void twins_find(struct twins *twins);

/* rve_advance() of a batch over these states, computing equal ones once. */
int twins_advance(struct twins *twins, struct rve_batch *batch);

/* Copies every state to where it belongs, for who reads all of them as bytes.  They must have been fetched from `pool`
 * (NULL = there is none). */
void twins_write_out(struct twins *twins, struct rve_pool *pool);

#endif
