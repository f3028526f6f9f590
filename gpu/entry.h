/* The entry point of the RVE kernel on a device, for OpenCL and CUDA alike: one block of threads works on one RVE at a
 * time.  There may be fewer blocks than tasks; each block has scratch memory of its own. */
#include "rve/kernel.h"
#include "rve/task.h"

/* Host and device must agree on what lies where. */
#define SAME_SIZE(name, type, bytes) typedef char name[sizeof(type) == (bytes) ? 1 : -1]
SAME_SIZE(rve_task_size, struct rve_task, RVE_TASK_BYTES);
SAME_SIZE(rve_task_model_size, struct rve_task_model, RVE_TASK_MODEL_BYTES);

/* What a block shares.  Sizes, constants, motion and where things are as well: they would take a hundred registers of
 * every thread. */
struct rve_device_block {
	struct rve_block block;
	struct rve_task_model model;
	struct rve_call call;
	struct rve_place place;
};

ENTRY rve_device_advance(GLOBAL struct rve_task *tasks, int n, GLOBAL const struct rve_task_model *model,
						 GLOBAL const real *tables, GLOBAL unsigned char *states, GLOBAL unsigned char *scratch)
{
	SHARED_STRUCT(struct rve_device_block, shared);
	SHARED struct rve_place *place = &shared.place;
	SHARED const struct rve_layout *layout = &shared.model.layout;
	ONE_THREAD
	{
		shared.model = *model;
		place->layout = layout, place->constants = &shared.model.constants;
		place->call = &shared.call, place->block = &shared.block;
		place_scratch(place, scratch + (int64)BLOCK_NUMBER * layout->scratch);
	}
	for (int k = BLOCK_NUMBER; k < n; k += BLOCK_COUNT) {
		GLOBAL struct rve_task *task = tasks + k;
		ONE_THREAD
		{
			shared.call = task->call;
			place->table = tables + (int64)task->head.variant * TABLE_FIELDS * layout->stride;
			place->head = &task->head;
			place->state = states + (int64)task->place * layout->bytes;
		}
		SYNC();
		block_advance(place, &task->status);
	}
}
