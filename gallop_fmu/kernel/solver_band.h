/* Direct solver of a banded system: the junctions that couple chains and devices. */
#ifndef GALLOP_SOLVER_BAND_H
#define GALLOP_SOLVER_BAND_H

#include <stdbool.h>
#include <stddef.h>

/* A square matrix whose entries lie no further than `half` from its diagonal.  The entry of row i
 * and column j is at [i (2 half + 1) + j - i + half]. */
typedef struct {
    int rows, half;
    double *re, *im; /* im NULL: real */
} band;

static inline size_t solver_band_room(int rows, int half)
{
    return (size_t)rows * (2 * (size_t)half + 1);
}

static inline size_t solver_band_place(const band *m, int row, int column)
{
    return (size_t)row * (2 * (size_t)m->half + 1) + (size_t)(column - row + m->half);
}

/* LU factors in place of the matrix, without row exchange.  False: the real part of a pivot, turned
 * by (cosine, sine), is not a positive finite number. */
bool solver_band_factor(const band *m, const double turn[2]);

/* The right-hand side (rows) becomes the solution; im as in the matrix. */
void solver_band_solve(const band *m, double *re, double *im);

#endif
