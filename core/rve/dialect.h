/* The dialect of the RVE kernel: block-synchronous C.
 *
 * kernel.h is written once for blocks of threads that work on one RVE together, and compiled for each
 * target by this header.  A target says what the words below mean; the rules that make the same text
 * right, and its bits equal, everywhere:
 *
 *  1. Iterations of FOR_THREADS are independent and in no order.  What one iteration writes, another may
 *     read only after SYNC().
 *  2. No variable of an iteration lives on after it.  Plain locals of a BLOCKFN hold the same value in
 *     every thread.
 *  3. Sums over discs or contacts go through LANES fixed virtual lanes (item k belongs to lane k % LANES) and a
 *     fixed tree, so that their order does not depend on how many threads there are.
 *  4. Contact forces go to slots of their own and are gathered by disc through an index: no atomics.
 *  5. Arithmetic is + - * / sqrt of IEEE, never contracted or re-associated.  exp, sin and the like come
 *     from the host.  Argument structs are plain numbers.
 *
 * Serial C is the reference: a block is a loop.  FOR_THREADS carries `ivdep`, which promises the compiler
 * exactly rule 1, so that it may use SIMD. */
#ifndef TMDEMPM_RVE_DIALECT_H
#define TMDEMPM_RVE_DIALECT_H

#include <math.h>

typedef double real;
typedef float real32;           /* where single precision is enough by far */
typedef unsigned short index16; /* discs and slots in a state */

enum { LANES = 128 };

#define GLOBAL /* memory of states and tables */
#define LOCAL  /* scratch memory of a block */
#define SHARED /* the one struct that the block shares */
#define RESTRICT restrict
#define BLOCKFN static inline __attribute__((always_inline))  /* called by all threads of a block together */
#define THREADFN static inline __attribute__((always_inline)) /* called by one thread, inside FOR_THREADS */

#define DIALECT_PRAGMA_(x) _Pragma(#x)
#define FOR_THREADS(i, n) DIALECT_PRAGMA_(GCC ivdep) for (int i = 0; i < (n); i++)
#define ONE_THREAD /* the statement that follows is done by one thread */
#define SYNC() ((void)0)

/* The entry point, one name for each instruction set (kernel_base.c and its sisters). */
#define DIALECT_JOIN_(a, b) a##b
#define DIALECT_JOIN(a, b) DIALECT_JOIN_(a, b)
#define KERNEL(name) void DIALECT_JOIN(name, RVE_KERNEL_SUFFIX)

THREADFN real real_sqrt(real x) { return sqrt(x); }
/* Where a is not a number, b. */
THREADFN real real_max(real a, real b) { return a > b ? a : b; }
THREADFN real real_min(real a, real b) { return a < b ? a : b; }

/* The nearest whole number, by rounding in the last place: needs no instruction of its own. */
THREADFN real real_nearest(real x)
{
	const real big = 6755399441055744.0; /* 1.5 * 2^52 */
	return (x + big) - big;
}

#endif
