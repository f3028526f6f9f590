/* The dialect of the RVE kernel: block-synchronous C.
 *
 * kernel.h is written once for blocks of threads that work on one RVE together, and compiled for each
 * target by this header.  A target says what the words below mean; the rules that make the same text
 * right, and its bits equal, everywhere:
 *
 *  1. A kernel is a program of PHASEs (block_advance).  Threads meet at the end of a phase and nowhere else, so that the
 *     functions of phases (BLOCKFN) know nothing of meeting; the program is plain control flow on values that are the
 *     same in all threads.  What may be left out is left out within its phase, as far as that can be: PoCL copies all that
 *     follows a phase that may be left out, and what follows n of them 2^n times.
 *  2. Iterations of FOR_THREADS are independent and in no order; number i is the same thread's in each of them, and
 *     ONE_THREAD is always the same.  What one thread writes, another may read only in a later phase.  No variable of
 *     an iteration lives on after it.
 *  3. Sums over discs or contacts go through LANES fixed virtual lanes (item k belongs to lane k % LANES) and a
 *     fixed tree, so that their order does not depend on how many threads there are.
 *  4. Contact forces go to slots of their own and are gathered by disc through an index: no atomics.
 *  5. Arithmetic is + - * / sqrt of IEEE, never contracted or re-associated.  exp, sin and the like come
 *     from the host.  Argument structs are plain numbers.
 *
 * Serial C is the reference: a block is a loop.  FOR_THREADS carries `ivdep`, which promises the compiler
 * exactly rule 2, so that it may use SIMD.  OpenCL C (1.2 and later) and CUDA are the devices' languages (gpu/);
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
#define THREAD ((int)get_local_id(0))
#define THREADS ((int)get_local_size(0))
#define SYNC() barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE)
#define ENTRY __kernel void
#define SHARED_STRUCT(type, name) __local type name
#define BLOCK_NUMBER ((int)get_group_id(0))
#define BLOCK_COUNT ((int)get_num_groups(0))
#define SPECIALISED 0

#elif defined(__CUDACC__)

typedef long long int64;
#define GLOBAL
#define LOCAL
#define SHARED
#define RESTRICT __restrict__
#define BLOCKFN static __device__ __forceinline__
#define THREADFN static __device__ __forceinline__
#define THREAD ((int)threadIdx.x)
#define THREADS ((int)blockDim.x)
#define SYNC() __syncthreads()
#define ENTRY extern "C" __global__ void
#define SHARED_STRUCT(type, name) __shared__ type name
#define BLOCK_NUMBER ((int)blockIdx.x)
#define BLOCK_COUNT ((int)gridDim.x)
#define SPECIALISED 0

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
/* what the tool defines; it runs one block at a time */
extern _Thread_local int emulated_thread, emulated_block;
extern int emulated_threads, emulated_blocks;
void emulated_sync(void);
#define THREAD emulated_thread
#define THREADS emulated_threads
#define SYNC() emulated_sync()
#define ENTRY void
#define SHARED_STRUCT(type, name) static type name
#define BLOCK_NUMBER emulated_block
#define BLOCK_COUNT emulated_blocks
#define SPECIALISED 0
#else
#define SPECIALISED 1 /* inner loops once for each kind of contacts: faster, but long to compile and many registers */
#define DIALECT_PRAGMA_(x) _Pragma(#x)
#define FOR_THREADS_FROM(i, first, n) DIALECT_PRAGMA_(GCC ivdep) for (int i = (first); i < (n); i++)
#define FOR_THREADS(i, n) FOR_THREADS_FROM(i, 0, n)
#define ONE_THREAD /* the statement that follows is done by one thread */
#define SYNC() ((void)0)
#endif

/* The entry point, one name for each instruction set (kernel_base.c and its sisters). */
#define DIALECT_JOIN_(a, b) a##b
#define DIALECT_JOIN(a, b) DIALECT_JOIN_(a, b)
#define KERNEL(name) void DIALECT_JOIN(name, RVE_KERNEL_SUFFIX)
#define RVE_HOST /* the entry points of this processor are declared */

#endif

#ifdef THREADS
#define FOR_THREADS(i, n) for (int i = THREAD; i < (n); i += THREADS)
#define FOR_THREADS_FROM(i, first, n) \
	for (int i = (first) + (THREAD + THREADS - (first) % THREADS) % THREADS; i < (n); i += THREADS)
#define ONE_THREAD if (THREAD == 0)
#endif

#define PHASE(...)   \
	do {             \
		__VA_ARGS__; \
		SYNC();      \
	} while (0)

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
