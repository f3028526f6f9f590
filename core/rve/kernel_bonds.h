/* Bonds: how strong they are, where they are kept.  Included by kernel.h only.
 *
 * A bond is a flag of a pair.  It must be in the list as long as it is intact, though its discs may have parted: an
 * intact bond has -delta <= beta_s R <= beta_s r_max, which rve_model_create() holds below the skin; bonds that one
 * sub-step has stretched beyond that are broken before a new list is made (bonds_tear).  So every intact bond is in
 * every list. */

/* What bonds bear at the temperature of this sub-step. */
THREADFN void bonds_soften(SHARED const struct rve_place *at)
{
	at->block->bond_force = bond_bears(at->constants, at->block->bond_temperature, at->call->sub_steps);
}

BLOCKFN void bonds_load(SHARED const struct rve_place *at)
{
	const int slots = at->block->head.level_first[at->block->head.levels];
	if (at->block->head.bonds_installed > 0)
		FOR_THREADS(p, slots) WORK_PAIR(WORK_BOND)[p] = (real)STATE_FLAG[p];
}

BLOCKFN void bonds_store(SHARED const struct rve_place *at)
{
	const int slots = at->block->head.level_first[at->block->head.levels];
	if (at->block->head.bonds_installed > 0)
		FOR_THREADS(p, slots) STATE_FLAG[p] = (unsigned char)WORK_PAIR(WORK_BOND)[p];
}
