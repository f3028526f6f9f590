/* Short vectors for the packed RVE kernel (packed.h): the one place that knows instruction sets.
 *
 * A block of LANE_COUNT numbers (64 bytes) is worked on in BLOCK_PARTS vectors of the processor's own width.  Every
 * lane sees the same IEEE operations in the same order whatever that width is, never contracted, so that the bits are
 * the same on AVX-512, AVX2, SSE2 and on processors without any of these.  + - * / are operators.
 *
 * Compile with RVE_FLOAT for single precision, with RVE_PORTABLE for what other processors than x86 do
 * (tests/unit/test_rve_portable.c). */
#ifndef TMDEMPM_RVE_VECTOR_H
#define TMDEMPM_RVE_VECTOR_H

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "rve/dialect.h"

#if defined(__x86_64__) && defined(__SSE2__) && !defined(RVE_PORTABLE)
#include <immintrin.h>
#define VECTOR_X86
#endif

#ifndef VECTOR_X86
#define VECTOR_BYTES 16
#elif defined(__AVX512F__) && defined(__AVX512DQ__) && defined(__AVX512VL__)
#define VECTOR_512
#define VECTOR_BYTES 64
#elif defined(__AVX2__)
#define VECTOR_256
#define VECTOR_BYTES 32
#else
#define VECTOR_BYTES 16
#endif

#ifdef RVE_FLOAT
typedef float num;
typedef int32_t coord; /* place along a cell vector in 2^-32 of it: wrapping around is the nearest image */
typedef int32_t mask_lane;
#define VECTOR_PICK(of_double, of_float) of_float
#else
typedef double num;
typedef double coord; /* in cell vectors */
typedef int64_t mask_lane;
#define VECTOR_PICK(of_double, of_float) of_double
#endif

enum {
	LANE_COUNT = 64 / sizeof(num),
	VECTOR_WIDTH = VECTOR_BYTES / sizeof(num),
	BLOCK_PARTS = 64 / VECTOR_BYTES,
	RECORD = 4, /* numbers in the record of a disc: x, y, r, w; and in that of its forces: x, y, torque */
	VELOCITY = VECTOR_PICK(2, 4) /* in that of its velocity: x, y; 16 bytes */
};

typedef num vec __attribute__((vector_size(VECTOR_BYTES), may_alias));
typedef mask_lane ivec __attribute__((vector_size(VECTOR_BYTES), may_alias));
typedef uint32_t wrapping __attribute__((vector_size(VECTOR_BYTES), may_alias)); /* of coordinates: overflow is meant */
typedef real32 vec32 __attribute__((vector_size(VECTOR_WIDTH * 4), may_alias));
typedef unsigned char flags __attribute__((vector_size(VECTOR_WIDTH), may_alias));

#ifdef VECTOR_512
typedef VECTOR_PICK(__mmask8, __mmask16) mask;
#else
typedef ivec mask;
#endif

#define VECFN static inline __attribute__((always_inline))

VECFN vec vec_set(num x) { return x - (vec){0}; }
VECFN vec vec_load(const num *p) { return *(const vec *)p; }
VECFN void vec_store(num *p, vec x) { *(vec *)p = x; }

/* Single precision in memory. */
#ifdef RVE_FLOAT
VECFN vec vec_load32(const real32 *p) { return *(const vec *)p; }
VECFN void vec_store32(real32 *p, vec x) { *(vec *)p = x; }
#elif defined(VECTOR_512)
VECFN vec vec_load32(const real32 *p) { return (vec)_mm512_cvtps_pd(_mm256_load_ps(p)); }
VECFN void vec_store32(real32 *p, vec x) { _mm256_store_ps(p, _mm512_cvtpd_ps((__m512d)x)); }
#elif defined(VECTOR_256)
VECFN vec vec_load32(const real32 *p) { return (vec)_mm256_cvtps_pd(_mm_load_ps(p)); }
VECFN void vec_store32(real32 *p, vec x) { _mm_store_ps(p, _mm256_cvtpd_ps((__m256d)x)); }
#else
VECFN vec vec_load32(const real32 *p) { return __builtin_convertvector(*(const vec32 *)p, vec); }
VECFN void vec_store32(real32 *p, vec x) { *(vec32 *)p = __builtin_convertvector(x, vec32); }
#endif

/* a > b ? a : b and a < b ? a : b, lane by lane: b where either is not a number */
#ifdef VECTOR_512
VECFN vec vec_max(vec a, vec b) { return (vec)VECTOR_PICK(_mm512_max_pd, _mm512_max_ps)(a, b); }
VECFN vec vec_min(vec a, vec b) { return (vec)VECTOR_PICK(_mm512_min_pd, _mm512_min_ps)(a, b); }
VECFN vec vec_sqrt(vec a) { return (vec)VECTOR_PICK(_mm512_sqrt_pd, _mm512_sqrt_ps)(a); }
VECFN mask mask_above(vec a, vec b) { return VECTOR_PICK(_mm512_cmp_pd_mask, _mm512_cmp_ps_mask)(a, b, _CMP_GT_OQ); }
VECFN mask mask_different(vec a, vec b)
{
	return VECTOR_PICK(_mm512_cmp_pd_mask, _mm512_cmp_ps_mask)(a, b, _CMP_NEQ_UQ);
}
VECFN int mask_any(mask m) { return !VECTOR_PICK(_kortestz_mask8_u8, _kortestz_mask16_u8)(m, m); }
VECFN mask mask_or(mask a, mask b) { return VECTOR_PICK(_kor_mask8, _kor_mask16)(a, b); }
VECFN vec vec_select(mask m, vec a, vec b)
{
	return (vec)VECTOR_PICK(_mm512_mask_blend_pd, _mm512_mask_blend_ps)(m, b, a);
}
VECFN vec vec_where(mask m, vec a) { return (vec)VECTOR_PICK(_mm512_maskz_mov_pd, _mm512_maskz_mov_ps)(m, a); }
VECFN mask mask_flags(const unsigned char *p, unsigned char value)
{
#ifdef RVE_FLOAT
	return _mm_cmpeq_epi8_mask(_mm_load_si128((const __m128i *)p), _mm_set1_epi8((char)value));
#else
	return (mask)_mm_cmpeq_epi8_mask(_mm_loadl_epi64((const __m128i *)p), _mm_set1_epi8((char)value));
#endif
}
#else
VECFN vec vec_select(mask m, vec a, vec b) { return (vec)(((ivec)a & m) | ((ivec)b & ~m)); }
VECFN vec vec_where(mask m, vec a) { return (vec)((ivec)a & m); }
VECFN mask mask_or(mask a, mask b) { return a | b; }
VECFN mask mask_above(vec a, vec b) { return (mask)(a > b); }
VECFN mask mask_different(vec a, vec b) { return (mask)(a != b); }
VECFN mask mask_flags(const unsigned char *p, unsigned char value)
{
	mask m;
	for (int k = 0; k < VECTOR_WIDTH; k++)
		m[k] = p[k] == value ? -1 : 0;
	return m;
}
#ifdef VECTOR_256
VECFN vec vec_max(vec a, vec b) { return (vec)VECTOR_PICK(_mm256_max_pd, _mm256_max_ps)(a, b); }
VECFN vec vec_min(vec a, vec b) { return (vec)VECTOR_PICK(_mm256_min_pd, _mm256_min_ps)(a, b); }
VECFN vec vec_sqrt(vec a) { return (vec)VECTOR_PICK(_mm256_sqrt_pd, _mm256_sqrt_ps)(a); }
VECFN int mask_any(mask m) { return VECTOR_PICK(_mm256_movemask_pd((__m256d)m), _mm256_movemask_ps((__m256)m)) != 0; }
#elif defined(VECTOR_X86)
VECFN vec vec_max(vec a, vec b) { return (vec)VECTOR_PICK(_mm_max_pd, _mm_max_ps)(a, b); }
VECFN vec vec_min(vec a, vec b) { return (vec)VECTOR_PICK(_mm_min_pd, _mm_min_ps)(a, b); }
VECFN vec vec_sqrt(vec a) { return (vec)VECTOR_PICK(_mm_sqrt_pd, _mm_sqrt_ps)(a); }
VECFN int mask_any(mask m) { return VECTOR_PICK(_mm_movemask_pd((__m128d)m), _mm_movemask_ps((__m128)m)) != 0; }
#else
VECFN vec vec_max(vec a, vec b) { return vec_select((mask)(a > b), a, b); }
VECFN vec vec_min(vec a, vec b) { return vec_select((mask)(a < b), a, b); }
VECFN vec vec_sqrt(vec a)
{
	for (int k = 0; k < VECTOR_WIDTH; k++)
		a[k] = VECTOR_PICK(sqrt, sqrtf)(a[k]);
	return a;
}
VECFN int mask_any(mask m)
{
	mask_lane any = 0;
	for (int k = 0; k < VECTOR_WIDTH; k++)
		any |= m[k];
	return any != 0;
}
#endif
#endif

/* Appends to `to` the numbers at `from` whose lanes are in `in`, with `mark` set where they are in `marked` too; how
 * many. Writes up to VECTOR_WIDTH numbers. */
VECFN int ints_pick(int *to, const int *from, mask in, mask marked, int mark)
{
#if defined(VECTOR_512) && defined(RVE_FLOAT)
	__m512i x = _mm512_loadu_si512(from);
	x = _mm512_mask_or_epi32(x, marked, x, _mm512_set1_epi32(mark));
	_mm512_storeu_si512(to, _mm512_maskz_compress_epi32(in, x));
	return __builtin_popcount(in);
#elif defined(VECTOR_512)
	__m256i x = _mm256_loadu_si256((const __m256i *)from);
	x = _mm256_mask_or_epi32(x, marked, x, _mm256_set1_epi32(mark));
	_mm256_storeu_si256((__m256i *)to, _mm256_maskz_compress_epi32(in, x));
	return __builtin_popcount(in);
#else
	int count = 0;
	for (int k = 0; k < VECTOR_WIDTH; k++) {
		to[count] = from[k] | (marked[k] ? mark : 0);
		count -= (int)in[k];
	}
	return count;
#endif
}

/* The first n lanes. */
VECFN mask mask_first(int n)
{
#ifdef VECTOR_512
	return n >= VECTOR_WIDTH ? (mask)-1 : (mask)((1u << n) - 1u);
#else
	mask m;
	for (int k = 0; k < VECTOR_WIDTH; k++)
		m[k] = k < n ? -1 : 0;
	return m;
#endif
}

VECFN vec vec_loadu(const num *p)
{
	vec x;
	memcpy(&x, p, sizeof x);
	return x;
}

VECFN vec vec_size(vec a) { return vec_max(a, -a); }

/* ---- places along a cell vector ---- */

#ifdef RVE_FLOAT
#define COORD_UNIT 2.3283064365386963e-10 /* 2^-32 */
VECFN ivec coord_load(const coord *p) { return *(const ivec *)p; }
VECFN void coord_store(coord *p, ivec x) { *(ivec *)p = x; }
/* b - a to the nearest image, in COORD_UNIT */
VECFN vec coord_way(ivec b, ivec a) { return __builtin_convertvector((ivec)((wrapping)b - (wrapping)a), vec); }
VECFN vec coord_branch(vec b, vec a) { return coord_way((ivec)b, (ivec)a); }
VECFN coord coord_apart(coord b, coord a) { return (coord)((uint32_t)b - (uint32_t)a); } /* of one */
VECFN ivec coord_moved(ivec a, ivec by) { return (ivec)((wrapping)a + (wrapping)by); }
/* The nearest whole numbers. */
VECFN ivec vec_whole(vec x)
{
#ifdef VECTOR_512
	return (ivec)_mm512_cvtps_epi32(x);
#elif defined(VECTOR_256)
	return (ivec)_mm256_cvtps_epi32(x);
#elif defined(VECTOR_X86)
	return (ivec)_mm_cvtps_epi32(x);
#else
	ivec whole;
	for (int k = 0; k < VECTOR_WIDTH; k++)
		whole[k] = (int32_t)lrintf(x[k]);
	return whole;
#endif
}
#else
#define COORD_UNIT 1.0
VECFN vec vec_nearest(vec x)
{
#ifdef VECTOR_512
	return (vec)_mm512_roundscale_pd(x, _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC);
#elif defined(VECTOR_256)
	return (vec)_mm256_round_pd(x, _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC);
#else
	const vec big = vec_set(6755399441055744.0); /* 1.5 * 2^52: rounds in the last place */
	return (x + big) - big;
#endif
}
VECFN vec coord_branch(vec b, vec a)
{
	vec d = b - a;
	return d - vec_nearest(d);
}
#endif

/* ---- records: one disc's numbers side by side, fetched for a vector of discs ---- */

/* Numbers k and k + 1 of the records that p[] point at (16-byte aligned). */
VECFN void vec_fetch2(const num *const p[VECTOR_WIDTH], int k, vec *a, vec *b)
{
#ifndef RVE_FLOAT
#if defined(VECTOR_512)
#define PLACE(d) _mm_load_pd(p[d] + k)
#define COUPLE(d, e) _mm256_insertf128_pd(_mm256_castpd128_pd256(PLACE(d)), PLACE(e), 1)
	__m512d even = _mm512_insertf64x4(_mm512_castpd256_pd512(COUPLE(0, 2)), COUPLE(4, 6), 1);
	__m512d odd = _mm512_insertf64x4(_mm512_castpd256_pd512(COUPLE(1, 3)), COUPLE(5, 7), 1);
	*a = (vec)_mm512_unpacklo_pd(even, odd);
	*b = (vec)_mm512_unpackhi_pd(even, odd);
#undef PLACE
#undef COUPLE
#elif defined(VECTOR_256)
#define PLACE(d) _mm_load_pd(p[d] + k)
#define COUPLE(d, e) _mm256_insertf128_pd(_mm256_castpd128_pd256(PLACE(d)), PLACE(e), 1)
	__m256d even = COUPLE(0, 2), odd = COUPLE(1, 3);
	*a = (vec)_mm256_unpacklo_pd(even, odd);
	*b = (vec)_mm256_unpackhi_pd(even, odd);
#undef PLACE
#undef COUPLE
#elif defined(VECTOR_X86)
	__m128d even = _mm_load_pd(p[0] + k), odd = _mm_load_pd(p[1] + k);
	*a = (vec)_mm_unpacklo_pd(even, odd);
	*b = (vec)_mm_unpackhi_pd(even, odd);
#else
	vec first = {0}, second = {0};
	for (int d = 0; d < VECTOR_WIDTH; d++)
		first[d] = p[d][k], second[d] = p[d][k + 1];
	*a = first, *b = second;
#endif
#else
#if defined(VECTOR_512)
#define PLACE(d) _mm_load_ps(p[d] + k)
#define COUPLE(d, e) _mm256_insertf128_ps(_mm256_castps128_ps256(PLACE(d)), PLACE(e), 1)
#define FOUR(d) _mm512_insertf32x8(_mm512_castps256_ps512(COUPLE(d, d + 4)), COUPLE(d + 8, d + 12), 1)
	__m512 low = _mm512_unpacklo_ps(FOUR(0), FOUR(1)), high = _mm512_unpacklo_ps(FOUR(2), FOUR(3));
	*a = (vec)_mm512_unpacklo_pd((__m512d)low, (__m512d)high);
	*b = (vec)_mm512_unpackhi_pd((__m512d)low, (__m512d)high);
#undef PLACE
#undef COUPLE
#undef FOUR
#elif defined(VECTOR_256)
#define PLACE(d) _mm_load_ps(p[d] + k)
#define COUPLE(d, e) _mm256_insertf128_ps(_mm256_castps128_ps256(PLACE(d)), PLACE(e), 1)
	__m256 low = _mm256_unpacklo_ps(COUPLE(0, 4), COUPLE(1, 5)), high = _mm256_unpacklo_ps(COUPLE(2, 6), COUPLE(3, 7));
	*a = (vec)_mm256_unpacklo_pd((__m256d)low, (__m256d)high);
	*b = (vec)_mm256_unpackhi_pd((__m256d)low, (__m256d)high);
#undef PLACE
#undef COUPLE
#else
	vec first = {0}, second = {0};
	for (int d = 0; d < VECTOR_WIDTH; d++)
		first[d] = p[d][k], second[d] = p[d][k + 1];
	*a = first, *b = second;
#endif
#endif
}

/* The first four numbers. */
VECFN void vec_fetch4(const num *const p[VECTOR_WIDTH], vec *a, vec *b, vec *c, vec *d)
{
#if defined(RVE_FLOAT) && defined(VECTOR_512)
#define PLACE(k) _mm_load_ps(p[k])
#define COUPLE(k, l) _mm256_insertf128_ps(_mm256_castps128_ps256(PLACE(k)), PLACE(l), 1)
#define FOUR(k) _mm512_insertf32x8(_mm512_castps256_ps512(COUPLE(k, k + 4)), COUPLE(k + 8, k + 12), 1)
	__m512 q0 = FOUR(0), q1 = FOUR(1), q2 = FOUR(2), q3 = FOUR(3);
	__m512d t0 = (__m512d)_mm512_unpacklo_ps(q0, q1), t1 = (__m512d)_mm512_unpacklo_ps(q2, q3);
	__m512d t2 = (__m512d)_mm512_unpackhi_ps(q0, q1), t3 = (__m512d)_mm512_unpackhi_ps(q2, q3);
	*a = (vec)_mm512_unpacklo_pd(t0, t1), *b = (vec)_mm512_unpackhi_pd(t0, t1);
	*c = (vec)_mm512_unpacklo_pd(t2, t3), *d = (vec)_mm512_unpackhi_pd(t2, t3);
#undef PLACE
#undef COUPLE
#undef FOUR
#elif defined(RVE_FLOAT) && defined(VECTOR_256)
#define PLACE(k) _mm_load_ps(p[k])
#define COUPLE(k, l) _mm256_insertf128_ps(_mm256_castps128_ps256(PLACE(k)), PLACE(l), 1)
	__m256 q0 = COUPLE(0, 4), q1 = COUPLE(1, 5), q2 = COUPLE(2, 6), q3 = COUPLE(3, 7);
	__m256d t0 = (__m256d)_mm256_unpacklo_ps(q0, q1), t1 = (__m256d)_mm256_unpacklo_ps(q2, q3);
	__m256d t2 = (__m256d)_mm256_unpackhi_ps(q0, q1), t3 = (__m256d)_mm256_unpackhi_ps(q2, q3);
	*a = (vec)_mm256_unpacklo_pd(t0, t1), *b = (vec)_mm256_unpackhi_pd(t0, t1);
	*c = (vec)_mm256_unpacklo_pd(t2, t3), *d = (vec)_mm256_unpackhi_pd(t2, t3);
#undef PLACE
#undef COUPLE
#else
	vec_fetch2(p, 0, a, b);
	vec_fetch2(p, 2, c, d);
#endif
}

/* Adds (x, y, t) to the first three numbers of the records that p[] point at (32 bytes each in double precision, 16 in
 * single), one lane after the other: records may coincide.  The fourth number stays. */
VECFN void vec_add3(num *const p[VECTOR_WIDTH], vec x, vec y, vec t)
{
#if !defined(RVE_FLOAT) && defined(VECTOR_512)
	const __m512i first = _mm512_setr_epi64(0, 1, 8, 9, 2, 3, 10, 11),
				  second = _mm512_setr_epi64(4, 5, 12, 13, 6, 7, 14, 15);
	const __m512d none = _mm512_setzero_pd();
	__m512d xy0 = _mm512_unpacklo_pd(x, y), xy1 = _mm512_unpackhi_pd(x, y);
	__m512d t0 = _mm512_unpacklo_pd(t, none), t1 = _mm512_unpackhi_pd(t, none);
	__m512d a = _mm512_permutex2var_pd(xy0, first, t0), b = _mm512_permutex2var_pd(xy1, first, t1);
	__m512d c = _mm512_permutex2var_pd(xy0, second, t0), d = _mm512_permutex2var_pd(xy1, second, t1);
#define ADD(k, v) _mm256_store_pd(p[k], _mm256_add_pd(_mm256_load_pd(p[k]), v))
	ADD(0, _mm512_castpd512_pd256(a));
	ADD(1, _mm512_castpd512_pd256(b));
	ADD(2, _mm512_extractf64x4_pd(a, 1));
	ADD(3, _mm512_extractf64x4_pd(b, 1));
	ADD(4, _mm512_castpd512_pd256(c));
	ADD(5, _mm512_castpd512_pd256(d));
	ADD(6, _mm512_extractf64x4_pd(c, 1));
	ADD(7, _mm512_extractf64x4_pd(d, 1));
#undef ADD
#elif !defined(RVE_FLOAT) && defined(VECTOR_256)
	const __m256d none = _mm256_setzero_pd();
	__m256d xy0 = _mm256_unpacklo_pd(x, y), xy1 = _mm256_unpackhi_pd(x, y);
	__m256d t0 = _mm256_unpacklo_pd(t, none), t1 = _mm256_unpackhi_pd(t, none);
#define ADD(k, v) _mm256_store_pd(p[k], _mm256_add_pd(_mm256_load_pd(p[k]), v))
	ADD(0, _mm256_permute2f128_pd(xy0, t0, 0x20));
	ADD(1, _mm256_permute2f128_pd(xy1, t1, 0x20));
	ADD(2, _mm256_permute2f128_pd(xy0, t0, 0x31));
	ADD(3, _mm256_permute2f128_pd(xy1, t1, 0x31));
#undef ADD
#elif defined(RVE_FLOAT) && defined(VECTOR_512)
	const __m512 none = _mm512_setzero_ps();
	__m512d xy0 = (__m512d)_mm512_unpacklo_ps(x, y), xy1 = (__m512d)_mm512_unpackhi_ps(x, y);
	__m512d t0 = (__m512d)_mm512_unpacklo_ps(t, none), t1 = (__m512d)_mm512_unpackhi_ps(t, none);
	__m512 a = (__m512)_mm512_unpacklo_pd(xy0, t0), b = (__m512)_mm512_unpackhi_pd(xy0, t0);
	__m512 c = (__m512)_mm512_unpacklo_pd(xy1, t1), d = (__m512)_mm512_unpackhi_pd(xy1, t1);
#define ADD(k, v) _mm_store_ps(p[k], _mm_add_ps(_mm_load_ps(p[k]), v))
#define ADD4(k, part)                                                                                                  \
	ADD(k, _mm512_extractf32x4_ps(a, part));                                                                           \
	ADD(k + 1, _mm512_extractf32x4_ps(b, part));                                                                       \
	ADD(k + 2, _mm512_extractf32x4_ps(c, part));                                                                       \
	ADD(k + 3, _mm512_extractf32x4_ps(d, part))
	ADD4(0, 0);
	ADD4(4, 1);
	ADD4(8, 2);
	ADD4(12, 3);
#undef ADD
#undef ADD4
#elif defined(RVE_FLOAT) && defined(VECTOR_256)
	const __m256 none = _mm256_setzero_ps();
	__m256d xy0 = (__m256d)_mm256_unpacklo_ps(x, y), xy1 = (__m256d)_mm256_unpackhi_ps(x, y);
	__m256d t0 = (__m256d)_mm256_unpacklo_ps(t, none), t1 = (__m256d)_mm256_unpackhi_ps(t, none);
	__m256 a = (__m256)_mm256_unpacklo_pd(xy0, t0), b = (__m256)_mm256_unpackhi_pd(xy0, t0);
	__m256 c = (__m256)_mm256_unpacklo_pd(xy1, t1), d = (__m256)_mm256_unpackhi_pd(xy1, t1);
#define ADD(k, v) _mm_store_ps(p[k], _mm_add_ps(_mm_load_ps(p[k]), v))
#define ADD4(k, part)                                                                                                  \
	ADD(k, _mm256_extractf128_ps(a, part));                                                                            \
	ADD(k + 1, _mm256_extractf128_ps(b, part));                                                                        \
	ADD(k + 2, _mm256_extractf128_ps(c, part));                                                                        \
	ADD(k + 3, _mm256_extractf128_ps(d, part))
	ADD4(0, 0);
	ADD4(4, 1);
#undef ADD
#undef ADD4
#else
	for (int k = 0; k < VECTOR_WIDTH; k++)
		p[k][0] += x[k], p[k][1] += y[k], p[k][2] += t[k];
#endif
}

/* Writes the first four numbers, or the first two, of VECTOR_WIDTH records side by side. */
VECFN void vec_put4(num *record, vec a, vec b, vec c, vec d)
{
#if !defined(RVE_FLOAT) && defined(VECTOR_512)
	const __m512i first = _mm512_setr_epi64(0, 1, 8, 9, 2, 3, 10, 11),
				  second = _mm512_setr_epi64(4, 5, 12, 13, 6, 7, 14, 15);
	__m512d ab0 = _mm512_unpacklo_pd(a, b), ab1 = _mm512_unpackhi_pd(a, b);
	__m512d cd0 = _mm512_unpacklo_pd(c, d), cd1 = _mm512_unpackhi_pd(c, d);
	__m512d even0 = _mm512_permutex2var_pd(ab0, first, cd0), odd0 = _mm512_permutex2var_pd(ab1, first, cd1);
	__m512d even1 = _mm512_permutex2var_pd(ab0, second, cd0), odd1 = _mm512_permutex2var_pd(ab1, second, cd1);
	_mm256_store_pd(record, _mm512_castpd512_pd256(even0));
	_mm256_store_pd(record + 4, _mm512_castpd512_pd256(odd0));
	_mm256_store_pd(record + 8, _mm512_extractf64x4_pd(even0, 1));
	_mm256_store_pd(record + 12, _mm512_extractf64x4_pd(odd0, 1));
	_mm256_store_pd(record + 16, _mm512_castpd512_pd256(even1));
	_mm256_store_pd(record + 20, _mm512_castpd512_pd256(odd1));
	_mm256_store_pd(record + 24, _mm512_extractf64x4_pd(even1, 1));
	_mm256_store_pd(record + 28, _mm512_extractf64x4_pd(odd1, 1));
#elif !defined(RVE_FLOAT) && defined(VECTOR_256)
	__m256d ab0 = _mm256_unpacklo_pd(a, b), ab1 = _mm256_unpackhi_pd(a, b);
	__m256d cd0 = _mm256_unpacklo_pd(c, d), cd1 = _mm256_unpackhi_pd(c, d);
	_mm256_store_pd(record, _mm256_permute2f128_pd(ab0, cd0, 0x20));
	_mm256_store_pd(record + 4, _mm256_permute2f128_pd(ab1, cd1, 0x20));
	_mm256_store_pd(record + 8, _mm256_permute2f128_pd(ab0, cd0, 0x31));
	_mm256_store_pd(record + 12, _mm256_permute2f128_pd(ab1, cd1, 0x31));
#elif defined(RVE_FLOAT) && (defined(VECTOR_512) || defined(VECTOR_256))
#ifdef VECTOR_512
	__m512d ab0 = (__m512d)_mm512_unpacklo_ps(a, b), ab1 = (__m512d)_mm512_unpackhi_ps(a, b);
	__m512d cd0 = (__m512d)_mm512_unpacklo_ps(c, d), cd1 = (__m512d)_mm512_unpackhi_ps(c, d);
	__m512d abcd[4] = {_mm512_unpacklo_pd(ab0, cd0), _mm512_unpackhi_pd(ab0, cd0), _mm512_unpacklo_pd(ab1, cd1),
					   _mm512_unpackhi_pd(ab1, cd1)};
#define PUT(n, part) _mm_store_ps(record + RECORD * ((n) + 4 * (part)), _mm512_extractf32x4_ps((__m512)abcd[n], part))
#else
	__m256d ab0 = (__m256d)_mm256_unpacklo_ps(a, b), ab1 = (__m256d)_mm256_unpackhi_ps(a, b);
	__m256d cd0 = (__m256d)_mm256_unpacklo_ps(c, d), cd1 = (__m256d)_mm256_unpackhi_ps(c, d);
	__m256d abcd[4] = {_mm256_unpacklo_pd(ab0, cd0), _mm256_unpackhi_pd(ab0, cd0), _mm256_unpacklo_pd(ab1, cd1),
					   _mm256_unpackhi_pd(ab1, cd1)};
#define PUT(n, part) _mm_store_ps(record + RECORD * ((n) + 4 * (part)), _mm256_extractf128_ps((__m256)abcd[n], part))
#endif
#define PUT4(part)                                                                                                     \
	PUT(0, part);                                                                                                      \
	PUT(1, part);                                                                                                      \
	PUT(2, part);                                                                                                      \
	PUT(3, part)
	PUT4(0);
	PUT4(1);
#ifdef VECTOR_512
	PUT4(2);
	PUT4(3);
#endif
#undef PUT
#undef PUT4
#else
	for (int k = 0; k < VECTOR_WIDTH; k++) {
		num *p = record + RECORD * k;
		p[0] = a[k], p[1] = b[k], p[2] = c[k], p[3] = d[k];
	}
#endif
}

VECFN void vec_put2(num *velocity, vec a, vec b)
{
#ifdef RVE_FLOAT
	vec_put4(velocity, a, b, vec_set(0), vec_set(0));
#elif defined(VECTOR_512)
	const __m512i first = _mm512_setr_epi64(0, 8, 1, 9, 2, 10, 3, 11),
				  second = _mm512_setr_epi64(4, 12, 5, 13, 6, 14, 7, 15);
	_mm512_store_pd(velocity, _mm512_permutex2var_pd(a, first, b));
	_mm512_store_pd(velocity + 8, _mm512_permutex2var_pd(a, second, b));
#elif defined(VECTOR_256)
	__m256d even = _mm256_unpacklo_pd(a, b), odd = _mm256_unpackhi_pd(a, b);
	_mm256_store_pd(velocity, _mm256_permute2f128_pd(even, odd, 0x20));
	_mm256_store_pd(velocity + 4, _mm256_permute2f128_pd(even, odd, 0x31));
#else
	for (int k = 0; k < VECTOR_WIDTH; k++)
		velocity[VELOCITY * k] = a[k], velocity[VELOCITY * k + 1] = b[k];
#endif
}

#endif
