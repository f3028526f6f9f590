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
 *  5. Where threads meet (SYNC) on condition, the condition is the same for all and stands in BLOCK_IF; nothing returns
 *     from there.
 *  6. Arithmetic is + - * / sqrt of IEEE, never contracted or re-associated.  exp, sin and the like come
 *     from the host.  Argument structs are plain numbers.
 *
 * Serial C is the reference: a block is a loop.  FOR_THREADS carries `ivdep`, which promises the compiler
 * exactly rule 1, so that it may use SIMD.  OpenCL C (1.2 and later) and CUDA are the devices' languages (gpu/);
 * RVE_EMULATION is C once more with a POSIX thread for every thread of a block, for a tool that looks for races. */
#ifndef TMDEMPM_RVE_DIALECT_H
#define TMDEMPM_RVE_DIALECT_H

#if defined(__OPENCL_VERSION__)

#pragma OPENCL EXTENSION cl_khr_fp64 : enable
#pragma OPENCL FP_CONTRACT OFF

typedef long int64;
#define GLOBAL __global
#define LOCAL __global
#define SHARED __local
#define RESTRICT restrict
#define BLOCKFN static inline __attribute__((always_inline))
#define THREADFN static inline __attribute__((always_inline))
#define FOR_THREADS(i, n) for (int i = (int)get_local_id(0); i < (n); i += (int)get_local_size(0))
#define ONE_THREAD if (get_local_id(0) == 0)
#define SYNC() barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE)
/* A loop that ends after one turn, which the compiler cannot know: PoCL writes what follows an `if` with a barrier in it
 * twice, and what follows several of them 2^n times. */
#define BLOCK_IF(condition) for (int go_ = (condition) ? 1 : 0; go_; go_ = at->layout->bytes < 0)
#define ENTRY __kernel void
#define SHARED_STRUCT(type, name) __local type name
#define BLOCK_NUMBER ((int)get_group_id(0))
#define BLOCK_COUNT ((int)get_num_groups(0))
#define SPECIALISED 0
#define MEASURES 0

#elif defined(__CUDACC__)

typedef long long int64;
#define GLOBAL
#define LOCAL
#define SHARED
#define RESTRICT __restrict__
#define BLOCKFN static __device__ __forceinline__
#define THREADFN static __device__ __forceinline__
#define FOR_THREADS(i, n) for (int i = (int)threadIdx.x; i < (n); i += (int)blockDim.x)
#define ONE_THREAD if (threadIdx.x == 0)
#define SYNC() __syncthreads()
#define BLOCK_IF(condition) if (condition)
#define ENTRY extern "C" __global__ void
#define SHARED_STRUCT(type, name) __shared__ type name
#define BLOCK_NUMBER ((int)blockIdx.x)
#define BLOCK_COUNT ((int)gridDim.x)
#define SPECIALISED 0
#define MEASURES 0

#else

#include <math.h>

typedef long long int64;
#define GLOBAL /* memory of states and tables */
#define LOCAL  /* scratch memory of a block */
#define SHARED /* the one struct that the block shares */
#define RESTRICT restrict
#define BLOCKFN static inline __attribute__((always_inline))  /* called by all threads of a block together */
#define THREADFN static inline __attribute__((always_inline)) /* called by one thread, inside FOR_THREADS */

#ifdef RVE_EMULATION
extern _Thread_local int emulated_thread;
extern int emulated_threads;
void emulated_sync(void);
#define FOR_THREADS(i, n) for (int i = emulated_thread; i < (n); i += emulated_threads)
#define ONE_THREAD if (emulated_thread == 0)
#define SYNC() emulated_sync()
#else
#define DIALECT_PRAGMA_(x) _Pragma(#x)
#define FOR_THREADS(i, n) DIALECT_PRAGMA_(GCC ivdep) for (int i = 0; i < (n); i++)
#define ONE_THREAD /* the statement that follows is done by one thread */
#define SYNC() ((void)0)
#endif

/* The entry point, one name for each instruction set (kernel_base.c and its sisters). */
#define DIALECT_JOIN_(a, b) a##b
#define DIALECT_JOIN(a, b) DIALECT_JOIN_(a, b)
#define KERNEL(name) void DIALECT_JOIN(name, RVE_KERNEL_SUFFIX)
#define BLOCK_IF(condition) if (condition)
#define SPECIALISED 1 /* inner loops once for each kind of contacts: faster, but long to compile and many registers */
#define MEASURES 1 /* calls without sub-steps and for a state without lists: not on devices, whose code stays small so */
#define RVE_HOST /* the entry points of this processor are declared */

#endif

typedef double real;
typedef float real32;           /* where single precision is enough by far */
typedef unsigned short index16; /* discs and slots in a state */

enum { LANES = 128 };

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
