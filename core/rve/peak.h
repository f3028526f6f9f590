/* Multiplications and additions that do not wait for each other, apart as the kernels make them, in the vectors of
 * vector.h: what `tmdempm bench rve` holds the kernels against.  Included by packed64_*.c. */
#include "rve/vector.h"

/* `rounds` times some; how many operations on numbers that is.  `sum` takes what comes out. */
double DIALECT_JOIN(rve_peak, RVE_KERNEL_SUFFIX)(int rounds, double *sum)
{
	enum { CHAINS = 6 };
	vec product[CHAINS], added[CHAINS];
	const vec factor = vec_set((num)0.999999), step = vec_set((num)1e-6);
#pragma GCC unroll 8
	for (int k = 0; k < CHAINS; k++)
		product[k] = vec_set((num)k), added[k] = vec_set((num)(k + 1));
	for (int r = 0; r < rounds; r++) {
#pragma GCC unroll 8
		for (int k = 0; k < CHAINS; k++) {
			product[k] = product[k] * factor;
			added[k] = added[k] + step;
		}
	}
#pragma GCC unroll 8
	for (int k = 0; k < CHAINS; k++)
		*sum += (double)product[k][0] + (double)added[k][0];
	return 2.0 * CHAINS * VECTOR_WIDTH * rounds;
}
