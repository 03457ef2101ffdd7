/* Direct solver of a banded system, real or complex.  Without row exchange, as the matrix is
 * dominated by its symmetric positive part, or is so when it is turned: see solver_block.h. */
#include "solver_band.h"

#include "base_lanes.h"

#include <math.h>

/* to -= factor from, for `count` numbers; factor and imaginary parts may be complex. */
INLINE void subtract_row(const double factor[2], const double *from_re, const double *from_im,
                         int count, double *restrict to_re, double *restrict to_im)
{
    if (!from_im) {
        for (int j = 0; j < count; j++) to_re[j] -= factor[0] * from_re[j];
        return;
    }
    for (int j = 0; j < count; j++) {
        to_re[j] -= factor[0] * from_re[j] - factor[1] * from_im[j];
        to_im[j] -= factor[0] * from_im[j] + factor[1] * from_re[j];
    }
}

/* (re, im) = (re, im) / pivot */
static void divide(double *re, double *im, double pivot_re, double pivot_im)
{
    if (!im) {
        *re /= pivot_re;
        return;
    }
    const double square = pivot_re * pivot_re + pivot_im * pivot_im, x = *re, y = *im;
    *re = (x * pivot_re + y * pivot_im) / square;
    *im = (y * pivot_re - x * pivot_im) / square;
}

static int smaller(int a, int b)
{
    return a < b ? a : b;
}

TWO_PATHS static bool factor(const band *m, const double turn[2])
{
    for (int k = 0; k < m->rows; k++) {
        const size_t pivot = solver_band_place(m, k, k);
        const int reach = smaller(m->half, m->rows - 1 - k);
        const double re = m->re[pivot], im = m->im ? m->im[pivot] : 0.0;
        if (!(re * turn[0] - im * turn[1] > 0.0) || !isfinite(re * re + im * im)) return false;
        for (int i = k + 1; i <= k + reach; i++) {
            const size_t lead = solver_band_place(m, i, k);
            double *of_im = m->im ? m->im + lead : NULL;
            divide(m->re + lead, of_im, re, im);
            const double factor[2] = {m->re[lead], of_im ? *of_im : 0.0};
            subtract_row(factor, m->re + pivot + 1, m->im ? m->im + pivot + 1 : NULL, reach,
                         m->re + lead + 1, m->im ? m->im + lead + 1 : NULL);
        }
    }
    return true;
}

/* sum over j of row[j] x[j], subtracted from one number. */
INLINE void subtract_product(const double *row_re, const double *row_im, const double *x_re,
                             const double *x_im, int count, double *re, double *im)
{
    for (int j = 0; j < count; j++) {
        *re -= row_re[j] * x_re[j];
        if (!im || !row_im) continue; /* real numbers */
        *re += row_im[j] * x_im[j];
        *im -= row_re[j] * x_im[j] + row_im[j] * x_re[j];
    }
}

TWO_PATHS static void solve(const band *m, double *re, double *im)
{
    for (int i = 0; i < m->rows; i++) {
        const int reach = smaller(m->half, i);
        const size_t first = solver_band_place(m, i, i - reach);
        subtract_product(m->re + first, m->im ? m->im + first : NULL, re + i - reach,
                         im ? im + i - reach : NULL, reach, re + i, im ? im + i : NULL);
    }
    for (int i = m->rows - 1; i >= 0; i--) {
        const int reach = smaller(m->half, m->rows - 1 - i);
        const size_t pivot = solver_band_place(m, i, i);
        subtract_product(m->re + pivot + 1, m->im ? m->im + pivot + 1 : NULL, re + i + 1,
                         im ? im + i + 1 : NULL, reach, re + i, im ? im + i : NULL);
        divide(re + i, im ? im + i : NULL, m->re[pivot], m->im ? m->im[pivot] : 0.0);
    }
}

bool solver_band_factor(const band *m, const double turn[2])
{
    return factor(m, turn);
}

void solver_band_solve(const band *m, double *re, double *im)
{
    solve(m, re, im);
}
