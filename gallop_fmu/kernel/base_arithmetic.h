/* Stops compilers whose options would spoil the arithmetic; what they do not report,
 * gallop_arithmetic_fault finds. */
#ifndef GALLOP_BASE_ARITHMETIC_H
#define GALLOP_BASE_ARITHMETIC_H

#if defined(__FAST_MATH__) || defined(_M_FP_FAST) ||                                               \
    (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)
#error "fast floating-point options give wrong results: compile without -ffast-math"
#endif
#if defined(__FLT_EVAL_METHOD__) && __FLT_EVAL_METHOD__ != 0 && __FLT_EVAL_METHOD__ != 16
#error "x87 rounds double twice: compile with -msse2 -mfpmath=sse"
#endif

#endif
