/* The passes of kernel.h.  Included by kernel_*.c only, each with a MPM_KERNEL of its own. */
#include <math.h>
#include <string.h>

#include "base/lanes.h"
#include "base/mat2.h"
#include "mpm/kernel.h"
#include "mpm/point.h"

#include "mpm/kernel_shape.h"

#include "mpm/kernel_transfer.h"

#include "mpm/kernel_heat.h"

const struct mpm_kernel MPM_KERNEL = {
	.fill = {linear_fill, ugimp_fill, cpdi_fill},
	.scatter_stripe = scatter_stripe_any,
	.gather_block = gather_block_any,
	.flow_stripe = flow_stripe_any,
};
