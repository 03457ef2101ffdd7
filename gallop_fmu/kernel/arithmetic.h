/* Stops compilers whose options would spoil the arithmetic; what they do not report, gallop_arithmetic_fault finds. */
#ifndef GALLOP_ARITHMETIC_H
#define GALLOP_ARITHMETIC_H

#if defined(__FAST_MATH__) || defined(_M_FP_FAST) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)
#error "results would be wrong: compile without -ffast-math, -Ofast, -ffinite-math-only, /fp:fast (or with -fno-fast-math)"
#endif
#if defined(__FLT_EVAL_METHOD__) && __FLT_EVAL_METHOD__ != 0 && __FLT_EVAL_METHOD__ != 16
#error "double must not be computed in a longer format, as x87 does: compile with -msse2 -mfpmath=sse"
#endif

#endif
