/* Private to rve/: quiet RVEs.
 *
 * While little happens to an RVE its discs wait.  The motion adds up; the stress follows the elastic tensor that the
 * last DEM step measured (eq. 58), turned with the cell; nothing slides, nothing breaks.  Once the stress has changed
 * by params.quiet_change of its scale, the next call takes the whole motion in DEM steps.  What an RVE does lies
 * between nothing and what its affine tensor says, which no disc relaxes: so the bound on the change bounds the error.
 *
 * Energy: while it waits, the work of the followed stress is stored as elastic.  When the discs have caught up, their
 * own work takes its place; what the scene has worked beyond that, or less, is booked as discarded. */
#ifndef TMDEMPM_RVE_QUIET_H
#define TMDEMPM_RVE_QUIET_H

#include "rve/model.h"

/* What stands open between a call that catches up and its end. */
struct quiet_debt {
	int open;
	double stress[4];       /* Pa, at the begin of the call */
	double predicted[4];    /* Pa, by the tensor, for its end */
	double work, expansion; /* J, of the ledger */
	struct rve_motion call; /* without what had waited */
};

/* An RVE that neither flies nor is frozen, whose F has moved with the call.  1: it waits, and the call is done.  0: the
 * discs must move, by *motion, which is now the call and all that has waited. */
int quiet_hold(const struct rve_model *model, struct rve_head *head, struct rve_motion *motion,
			   struct quiet_debt *debt);

/* After the discs have moved by that. */
void quiet_settle(const struct rve_model *model, struct rve_head *head, const struct quiet_debt *debt);

/* Instead of that, for a cell that cannot follow: forgets what has waited.  The caller goes on with debt->call. */
void quiet_forget(struct rve_head *head);

#endif
