/* What the serial and the packed kernel of an RVE have in common: the sums they make, and what one thread does with
 * scalars.  Double precision in both. */
#ifndef TMDEMPM_RVE_KERNEL_COMMON_H
#define TMDEMPM_RVE_KERNEL_COMMON_H

#include "rve/kernel_cell.h"
#include "rve/state.h"

enum {
	/* sums over all sub-steps of the call */
	LANE_WORK,
	LANE_EXPANSION,
	LANE_FRICTION,
	LANE_DASHPOT,
	LANE_BOND,
	LANE_KINETIC_WORK,
	/* of the last configuration */
	LANE_CALL_FIELDS,
	LANE_SXX = LANE_CALL_FIELDS,
	LANE_SYY,
	LANE_SXY,
	LANE_LXX,
	LANE_LYY,
	LANE_LXY,
	LANE_N40,
	LANE_N04,
	LANE_N22,
	LANE_N31,
	LANE_N13,
	LANE_OVERLAP_FORCE,
	LANE_ELASTIC,
	LANE_CONTACTS,
	LANE_BONDS,
	LANE_SLIDING,
	LANE_FORCE,
	LANE_VXX,
	LANE_VYY,
	LANE_VXY,
	LANE_KINETIC,
	LANE_UNBALANCED,
	LANE_SUMS,
	LANE_OVERLAP = LANE_SUMS, /* largest, not summed */
	LANE_TOTALS,
	/* of the serial kernel's last motion: largest, not summed */
	LANE_DISPLACEMENT = LANE_TOTALS,
	LANE_SECOND,
	LANE_FIELDS
};

/* Force that no bond reaches, for measuring: a state is measured without changing it. */
#define BOND_UNBREAKABLE 1e300

/* What a bond bears at T (K, absolute) / (r_i + r_j), N/m: beta(T) of eq. 40, a step at T_c or linear below it.  Above
 * T_c nothing holds, however it is pressed. */
THREADFN real bond_bears(SHARED const struct rve_constants *c, const real T, const int sub_steps)
{
	real share = c->bond_slope > 0.0 ? real_min((c->bond_melting - T) * c->bond_slope, 1.0) : 1.0;
	real bears = T > c->bond_melting ? -BOND_UNBREAKABLE : c->bond_force * share;
	return sub_steps == 0 ? BOND_UNBREAKABLE : bears;
}

/* Upper bound over all directions of the stiffness against uniaxial strain: mean and the two harmonics. */
THREADFN real stiffest(const SHARED real *C)
{
	real xxxx = C[0], yyyy = C[1], mixed = C[2] + 2.0 * C[3], xxxy = C[4], yyxy = C[5];
	real mean = (3.0 * (xxxx + yyyy) + 2.0 * mixed) * 0.125;
	real c2 = 0.5 * (xxxx - yyyy), s2 = xxxy + yyxy;
	real c4 = (xxxx + yyyy - 2.0 * mixed) * 0.125, s4 = 0.5 * (xxxy - yyxy);
	return mean + real_sqrt(c2 * c2 + s2 * s2) + real_sqrt(c4 * c4 + s4 * s4);
}

/* Is a list still right after the two largest non-affine ways (m)?  kernel_neighbours.h says why. */
THREADFN int list_valid(const SHARED struct rve_head *head, SHARED const struct rve_constants *c, const real scale,
						const real first, const real second)
{
	real stretch = real_min(cell_least_stretch(head->H, head->H_ref), 1.0);
	real reach = stretch * (2.0 * c->r_max * head->scale_ref + c->skin);
	real largest = real_max(scale, stretch * head->scale_ref);
	return reach - first - second >= 2.0 * c->r_max * largest;
}

/* What a state says of itself, and its ledgers, from the sums over its contacts and discs. */
THREADFN void head_from_totals(SHARED struct rve_head *head, SHARED const struct rve_constants *c,
							   SHARED const struct rve_call *call, const int n, const real scale_step, const real total[LANE_TOTALS])
{
	SHARED const real *D = call->D;
	real v = 1.0 / cell_volume(head->H, c->thickness);
	if (call->sub_steps > 0) {
		/* trapezoid: the sums hold every configuration after a sub-step whole, the first one not at all */
		real first = head->contact_sum[0] * D[0] + head->contact_sum[1] * D[1] + 2.0 * head->contact_sum[2] * D[2];
		real final = total[LANE_SXX] * D[0] + total[LANE_SYY] * D[1] + 2.0 * total[LANE_SXY] * D[2];
		head->ledger[LEDGER_WORK] += total[LANE_WORK] + total[LANE_KINETIC_WORK] + 0.5 * (final - first);
		real grown = total[LANE_EXPANSION] + 0.5 * (head->expansion_sum - total[LANE_OVERLAP_FORCE]);
		head->ledger[LEDGER_EXPANSION] += grown * scale_step;
		head->ledger[LEDGER_FRICTION] += 0.5 / c->ks * total[LANE_FRICTION];
		head->ledger[LEDGER_DASHPOT] += 0.5 * total[LANE_DASHPOT];
		head->ledger[LEDGER_BOND] += total[LANE_BOND];
	}
	head->ledger[LEDGER_ELASTIC] = total[LANE_ELASTIC];
	head->ledger[LEDGER_KINETIC] = total[LANE_KINETIC];
	head->contact_sum[0] = total[LANE_SXX];
	head->contact_sum[1] = total[LANE_SYY];
	head->contact_sum[2] = total[LANE_SXY];
	head->expansion_sum = total[LANE_OVERLAP_FORCE];
	head->stress[0] = -v * (total[LANE_SXX] + total[LANE_VXX]);
	head->stress[1] = -v * (total[LANE_SYY] + total[LANE_VYY]);
	head->stress[2] = 0.0;
	head->stress[3] = -v * (total[LANE_SXY] + total[LANE_VXY]);
	for (int k = 0; k < 3; k++)
		head->conductivity[k] = total[LANE_LXX + k] * v / c->resistance;
	real n40 = total[LANE_N40] * v, n04 = total[LANE_N04] * v, n22 = total[LANE_N22] * v;
	real n31 = total[LANE_N31] * v, n13 = total[LANE_N13] * v;
	head->tensor[0] = c->kn * n40 + c->ks * n22;
	head->tensor[1] = c->kn * n04 + c->ks * n22;
	head->tensor[2] = (c->kn - c->ks) * n22;
	head->tensor[3] = c->kn * n22 + 0.25 * c->ks * (n40 + n04 - 2.0 * n22);
	head->tensor[4] = c->kn * n31 - 0.5 * c->ks * (n31 - n13);
	head->tensor[5] = c->kn * n13 + 0.5 * c->ks * (n31 - n13);
	head->modulus = stiffest(head->tensor);
	head->contacts = total[LANE_CONTACTS];
	head->sliding = total[LANE_SLIDING];
	head->max_overlap = total[LANE_OVERLAP];
	head->unbalanced =
		total[LANE_FORCE] > 0.0 ? total[LANE_UNBALANCED] / n * total[LANE_CONTACTS] / total[LANE_FORCE] : 0.0;
	head->bonds_intact = (int)total[LANE_BONDS];
	head->total_sub_steps += call->sub_steps;
	head->sub_steps = call->sub_steps;
}

#endif
