/* One point of a law, driven by hand.  Include after <cmocka.h>. */
#ifndef TESTS_COMMON_LAW_POINT_H
#define TESTS_COMMON_LAW_POINT_H

#include <string.h>

#include "base/error.h"
#include "base/mat2.h"
#include "law/law.h"

struct point {
	struct law *law;
	double F[1][4], L[1][4], T[1], dT[1], stress[1][4], heat[1], conductivity[1][3], modulus[1], damage[1];
	int slot[1];
};

static inline struct law_batch batch_of(struct point *p, double dt)
{
	return (struct law_batch){.n = 1,
							  .slot = p->slot,
							  .F = (const double(*)[4])p->F,
							  .L = (const double(*)[4])p->L,
							  .T = p->T,
							  .dT = p->dT,
							  .dt = dt,
							  .stress = p->stress,
							  .heat = p->heat,
							  .conductivity = p->conductivity,
							  .modulus = p->modulus,
							  .damage = p->damage,
							  .failed = -1};
}

static inline void point_begin(struct point *p, const struct scene_law *scene)
{
	int variant = 0;
	memset(p, 0, sizeof *p);
	assert_int_equal(law_create(&p->law, scene, 1, &variant), STATUS_OK);
	mat2_identity(p->F[0]);
}

/* F <- exp(L dt) F, then the law. */
static inline int point_advance(struct point *p, const double L[4], double dT, double dt)
{
	double A[4], e[4];
	memcpy(p->L[0], L, sizeof p->L[0]);
	for (int c = 0; c < 4; c++)
		A[c] = L[c] * dt;
	mat2_exp(A, e);
	mat2_multiply(e, p->F[0], p->F[0]);
	p->dT[0] = dT;
	p->T[0] += dT;
	struct law_batch batch = batch_of(p, dt);
	return p->law->type->advance(p->law, &batch);
}

static inline struct law_ledger ledger_of(const struct point *p)
{
	struct law_ledger ledger;
	p->law->type->ledger(p->law, 0, &ledger);
	return ledger;
}

#endif
