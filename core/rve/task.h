/* What travels between the engine and a device for one RVE and one call: both ways in the same record. */
#ifndef TMDEMPM_RVE_TASK_H
#define TMDEMPM_RVE_TASK_H

#include "rve/state.h"

struct rve_task {
	struct rve_head head; /* in, out: of the state, whose arrays stay where they are */
	struct rve_call call; /* in */
	int place;            /* in: which of the device's states */
	int status;           /* out: enum rve_kernel_status */
};

/* Of all RVEs of a model. */
struct rve_task_model {
	struct rve_layout layout;
	struct rve_constants constants;
};

#endif
