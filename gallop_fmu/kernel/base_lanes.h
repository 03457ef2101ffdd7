/* A strip: LANES elements side by side, so that one instruction works on all of them.  Vectors of
 * gcc and clang become AVX2 or pairs of SSE2 registers with the same arithmetic, so the same bits;
 * other compilers take one element at a time.  Vectors are passed by address only: what passing one
 * by value means depends on the processor. */
#ifndef GALLOP_BASE_LANES_H
#define GALLOP_BASE_LANES_H

#include "base_arithmetic.h"
#include <stdbool.h>
#include <stdlib.h> /* defines __GLIBC__, which TWO_PATHS asks for */

#if defined(__GNUC__) && !defined(GALLOP_ONE_LANE) /* to measure what lanes give */
#define LANES 4
#define INLINE static inline __attribute__((always_inline))
typedef double lanes __attribute__((vector_size(32), aligned(8), may_alias));
#else
#define LANES 1
#define INLINE static inline
typedef double lanes;
#endif

/* Paths: a function that works along the span is compiled for several processors.
 *
 * TWO_PATHS before it: twice, for AVX2 and for any x86-64, and the loader picks. Both give the same
 * bits, as there is no fused multiply-add.  Elsewhere, under sanitizers, and by clang before 18,
 * which does not link such functions across files, once.
 *
 * PATHS(name, (parameters), (arguments)) after an INLINE function makes name_portable, with
 * TWO_PATHS, and name_fused, for AVX-512 with fused multiply-add, whose bits differ.
 * ON_PATH(fused, name) picks; `fused` is that of the model.  VALUE_PATHS is for a function that
 * returns a value.  Only gcc makes the fused path: others do not contract the expressions of a
 * single function. */
#if defined(__clang__) && __clang_major__ < 18 && !defined(GALLOP_ONE_PATH)
#define GALLOP_ONE_PATH
#endif
#if defined(__GNUC__) && defined(__x86_64__) && defined(__linux__) && defined(__GLIBC__) &&        \
    !defined(__SANITIZE_ADDRESS__) && !defined(GALLOP_ONE_PATH)
#define TWO_PATHS __attribute__((target_clones("avx2", "default")))
#if !defined(__clang__) && __GNUC__ >= 9 && !defined(GALLOP_PORTABLE)
#define FUSED                                                                                      \
    __attribute__((target("avx2,fma,avx512f,avx512vl,avx512dq"), optimize("fp-contract=fast")))
#endif
#else
#define TWO_PATHS
#endif

#ifdef FUSED
#define FUSED_PATH(code) code
#define ON_PATH(fused, name) ((fused) ? name##_fused : name##_portable)
#else
#define FUSED_PATH(code)
#define ON_PATH(fused, name) ((void)(fused), name##_portable)
#endif
#define PATHS(name, parameters, arguments)                                                         \
    TWO_PATHS static void name##_portable parameters                                               \
    {                                                                                              \
        name arguments;                                                                            \
    }                                                                                              \
    FUSED_PATH(FUSED static void name##_fused parameters { name arguments; })
#define VALUE_PATHS(type, name, parameters, arguments)                                             \
    TWO_PATHS static type name##_portable parameters                                               \
    {                                                                                              \
        return name arguments;                                                                     \
    }                                                                                              \
    FUSED_PATH(FUSED static type name##_fused parameters { return name arguments; })

/* Whether the processor has what the fused path needs. */
static inline bool base_has_fused_path(void)
{
#ifdef FUSED
    return __builtin_cpu_supports("fma") && __builtin_cpu_supports("avx512f") &&
           __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq");
#else
    return false;
#endif
}

#define LANE_GROUPS (4 / LANES) /* vectors for the four unknowns of a node */
#define LANE(x, k) (((double *)&(x))[k])
#define LANES_AT(p) (*(lanes *)(p)) /* LANES values that lie side by side */

/* Lane by lane: a where the comparison `if_true` holds, else b. */
#if LANES == 4
typedef long long lane_bits __attribute__((vector_size(32)));
#define PICK(if_true, a, b)                                                                        \
    ((lanes)(((lane_bits)(if_true) & (lane_bits)(a)) | (~(lane_bits)(if_true) & (lane_bits)(b))))
#define MAGNITUDE(x) ((lanes)((lane_bits)(x) & 0x7fffffffffffffffLL))
#else
#define PICK(if_true, a, b) ((if_true) ? (a) : (b))
#define MAGNITUDE(x) fabs(x)
#endif

/* The constants of a strip; lanes beyond the last element repeat it. */
typedef struct strip {
    lanes slope[2][3];       /* p0 = dX/dS at two stiffness points */
    lanes shape_slope[2][2]; /* dN/dS of the left and the right node; the middle one has minus their
                                sum */
    lanes pull[2][2];        /* that times the weight of the point */
    lanes tension[2];        /* T0 [N] */
    lanes product[6];        /* int N_a N_b dS [m], in the order of the blocks of a tangent */
    lanes share[3][3];       /* weight times N_a at three sections */
    lanes normal[3][2];      /* n2 of the sections' planes, along x1 and x2 */
    lanes stiffness_weight[2],
        inertia_weight[3]; /* lengths [m] of the points; 0 beyond the last element */
} strip;

/* Four unknowns of LANES nodes become LANES values of four unknowns, and back. */
INLINE void transpose(lanes x[4])
{
#if LANES == 4
#if defined(__clang__)
#define MERGE(a, b, i, j, k, l) __builtin_shufflevector(a, b, i, j, k, l)
#else
#define MERGE(a, b, i, j, k, l) __builtin_shuffle(a, b, (lane_bits){i, j, k, l})
#endif
    lanes a = MERGE(x[0], x[1], 0, 4, 2, 6), b = MERGE(x[0], x[1], 1, 5, 3, 7);
    lanes c = MERGE(x[2], x[3], 0, 4, 2, 6), d = MERGE(x[2], x[3], 1, 5, 3, 7);
    x[0] = MERGE(a, c, 0, 1, 4, 5);
    x[1] = MERGE(b, d, 0, 1, 4, 5);
    x[2] = MERGE(a, c, 2, 3, 6, 7);
    x[3] = MERGE(b, d, 2, 3, 6, 7);
#else
    (void)x;
#endif
}

/* Four values at each of `count` places from y on, `apart` values from one to the next; those of
 * the last place again in lanes beyond. */
INLINE void gather_lanes(const double *y, int apart, int count, lanes out[4])
{
#if LANES == 4
    for (int k = 0; k < LANES; k++)
        out[k] = *(const lanes *)(y + apart * (k < count ? k : count - 1));
    transpose(out);
#else
    (void)apart, (void)count;
    for (int i = 0; i < 4; i++) out[i] = y[i];
#endif
}

INLINE void scatter_lanes(double *y, int apart, int count, lanes x[4])
{
#if LANES == 4
    transpose(x);
    for (int k = 0; k < LANES; k++)
        if (k < count) *(lanes *)(y + apart * k) = x[k];
#else
    (void)apart, (void)count;
    for (int i = 0; i < 4; i++) y[i] = x[i];
#endif
}

/* As scatter_lanes, added to what is there. */
INLINE void scatter_add_lanes(double *y, int apart, int count, lanes x[4])
{
#if LANES == 4
    transpose(x);
    for (int k = 0; k < LANES; k++)
        if (k < count) *(lanes *)(y + apart * k) += x[k];
#else
    (void)apart, (void)count;
    for (int i = 0; i < 4; i++) y[i] += x[i];
#endif
}

/* The unknowns of node `n` (0 left, 1 middle, 2 right) of `count` elements whose left nodes stand
 * at y. */
INLINE void read_nodes(const double *y, int n, int count, lanes out[4])
{
    gather_lanes(y + 4 * n, 8, count, out);
}

INLINE void add_to_nodes(double *y, int n, int count, lanes x[4])
{
    scatter_add_lanes(y + 4 * n, 8, count, x);
}

#endif
