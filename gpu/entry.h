/* The entry point of the RVE kernel on a device, for OpenCL and CUDA alike: one block of threads works on one RVE at a
 * time.  There may be fewer blocks than tasks; each block has scratch memory of its own. */
#include "rve/kernel.h"
#include "rve/task.h"

/* Host and device must agree on what lies where. */
#define SAME_SIZE(name, type, bytes) typedef char name[sizeof(type) == (bytes) ? 1 : -1]
SAME_SIZE(rve_task_size, struct rve_task, RVE_TASK_BYTES);
SAME_SIZE(rve_task_model_size, struct rve_task_model, RVE_TASK_MODEL_BYTES);

ENTRY rve_device_advance(GLOBAL struct rve_task *tasks, int n, GLOBAL const struct rve_task_model *model,
						 GLOBAL const real *tables, GLOBAL unsigned char *states, GLOBAL unsigned char *scratch)
{
	SHARED_STRUCT(struct rve_block, block);
	const struct rve_layout layout = model->layout;
	const struct rve_constants constants = model->constants;
	LOCAL unsigned char *mine = scratch + (int64)BLOCK_NUMBER * layout.scratch;
	for (int k = BLOCK_NUMBER; k < n; k += BLOCK_COUNT) {
		GLOBAL struct rve_task *task = tasks + k;
		GLOBAL unsigned char *state = states + (int64)task->place * layout.bytes;
		GLOBAL const real *table = tables + (int64)task->head.variant * TABLE_FIELDS * layout.stride;
		const struct rve_call call = task->call;
		block_advance(&layout, &constants, &call, table, &task->head, state, &block, mine, &task->status);
	}
}
