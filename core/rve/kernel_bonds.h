/* Bonds: how strong they are, where they are kept.  Included by kernel.h only.
 *
 * A bond is a flag of a pair.  It must be in the list as long as it is intact, though its discs may have parted: an
 * intact bond has -delta <= beta_s R <= beta_s r_max, which rve_model_create() holds below the skin; bonds that one
 * sub-step has stretched beyond that are broken before a new list is made (bonds_tear).  So every intact bond is in
 * every list. */

/* Force that no bond reaches, for measuring: a state is measured without changing it. */
#define BOND_UNBREAKABLE 1e300

/* beta(T) of eq. 40: a step at T_c, or linear below it.  Above T_c nothing holds, however it is pressed. */
THREADFN void bonds_soften(const struct rve_place *at)
{
	SHARED struct rve_block *block = at->block;
	const struct rve_constants *c = at->constants;
	const real T = block->bond_temperature;
	real share = c->bond_slope > 0.0 ? real_min((c->bond_melting - T) * c->bond_slope, 1.0) : 1.0;
	block->bond_force = T > c->bond_melting ? -BOND_UNBREAKABLE : c->bond_force * share;
	if (at->call->sub_steps == 0)
		block->bond_force = BOND_UNBREAKABLE;
}

BLOCKFN void bonds_load(const struct rve_place *at)
{
	const int slots = at->block->head.level_first[at->block->head.levels];
	if (at->block->head.bonds_installed > 0)
		FOR_THREADS(p, slots) WORK_PAIR(WORK_BOND)[p] = (real)STATE_FLAG[p];
}

BLOCKFN void bonds_store(const struct rve_place *at)
{
	const int slots = at->block->head.level_first[at->block->head.levels];
	if (at->block->head.bonds_installed > 0)
		FOR_THREADS(p, slots) STATE_FLAG[p] = (unsigned char)WORK_PAIR(WORK_BOND)[p];
}
