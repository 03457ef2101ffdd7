/* The chain's direct solver of solver_chain.c once more, for a complex blend of the matrices: two
 * of a collocation method's stages have one complex conjugate pair of eigenvalues between them.
 * Real and imaginary parts stand apart and blocks are stored by columns, so that four rows make one
 * vector; C's own complex type would be neither vector code nor known to every compiler.
 *
 * Without row exchange: for the methods here k, c and m of the blend lie within a right angle of
 * each other, so that turned by half of it the symmetric part of the matrix is positive definite,
 * as in solver_chain.c. */
#include "solver.h"

typedef complex_block block;

/* Before a loop over four rows: kept as a loop until it has become one vector. */
#if defined(__GNUC__) && !defined(__clang__)
#define TOGETHER _Pragma("GCC unroll 1")
#else
#define TOGETHER
#endif

/* Entry i of the product of a with a column: real parts x, imaginary parts y. */
#define REAL_PART(a, i, x, y)                                                                      \
    ((a)->re[i] * (x)[0] - (a)->im[i] * (y)[0] + (a)->re[4 + (i)] * (x)[1] -                       \
     (a)->im[4 + (i)] * (y)[1] + (a)->re[8 + (i)] * (x)[2] - (a)->im[8 + (i)] * (y)[2] +           \
     (a)->re[12 + (i)] * (x)[3] - (a)->im[12 + (i)] * (y)[3])
#define IMAGINARY_PART(a, i, x, y)                                                                 \
    ((a)->re[i] * (y)[0] + (a)->im[i] * (x)[0] + (a)->re[4 + (i)] * (y)[1] +                       \
     (a)->im[4 + (i)] * (x)[1] + (a)->re[8 + (i)] * (y)[2] + (a)->im[8 + (i)] * (x)[2] +           \
     (a)->re[12 + (i)] * (y)[3] + (a)->im[12 + (i)] * (x)[3])

static inline void multiply(const block *restrict a, const block *restrict b, block *restrict out)
{
    for (int j = 0; j < 16; j += 4) {
        TOGETHER
        for (int i = 0; i < 4; i++) out->re[j + i] = REAL_PART(a, i, b->re + j, b->im + j);
        TOGETHER
        for (int i = 0; i < 4; i++) out->im[j + i] = IMAGINARY_PART(a, i, b->re + j, b->im + j);
    }
}

static inline void subtract_product(const block *restrict a, const block *restrict b,
                                    block *restrict out)
{
    for (int j = 0; j < 16; j += 4) {
        TOGETHER
        for (int i = 0; i < 4; i++) out->re[j + i] -= REAL_PART(a, i, b->re + j, b->im + j);
        TOGETHER
        for (int i = 0; i < 4; i++) out->im[j + i] -= IMAGINARY_PART(a, i, b->re + j, b->im + j);
    }
}

/* x and out: four real parts, then four imaginary ones. */
static inline void apply(const block *restrict a, const double *restrict x, double *restrict out)
{
    TOGETHER
    for (int i = 0; i < 4; i++) out[i] = REAL_PART(a, i, x, x + 4);
    TOGETHER
    for (int i = 0; i < 4; i++) out[4 + i] = IMAGINARY_PART(a, i, x, x + 4);
}

static inline void subtract_apply(const block *restrict a, const double *restrict x,
                                  double *restrict out)
{
    TOGETHER
    for (int i = 0; i < 4; i++) out[i] -= REAL_PART(a, i, x, x + 4);
    TOGETHER
    for (int i = 0; i < 4; i++) out[4 + i] -= IMAGINARY_PART(a, i, x, x + 4);
}

/* Gauss-Jordan; `turn` (cosine, sine) brings the pivots to the right half plane, which they leave
 * only where the tangent is not positive definite any more. */
static bool invert(block *a, const double turn[2])
{
    for (int k = 0; k < 4; k++) {
        const double re = a->re[5 * k], im = a->im[5 * k], square = re * re + im * im;
        if (!(re * turn[0] - im * turn[1] > 0.0) || !isfinite(square)) return false;
        const double inverse[2] = {re / square, -im / square};
        double column[8];
        for (int i = 0; i < 4; i++) {
            column[i] = a->re[4 * k + i];
            column[4 + i] = a->im[4 * k + i];
            a->re[4 * k + i] = a->im[4 * k + i] = 0.0;
        }
        a->re[5 * k] = 1.0;
        column[k] = column[4 + k] = 0.0;
        for (int j = 0; j < 4; j++) {
            const double x = a->re[4 * j + k], y = a->im[4 * j + k];
            const double row[2] = {x * inverse[0] - y * inverse[1],
                                   x * inverse[1] + y * inverse[0]};
            TOGETHER
            for (int i = 0; i < 4; i++) {
                a->re[4 * j + i] -= column[i] * row[0] - column[4 + i] * row[1];
                a->im[4 * j + i] -= column[i] * row[1] + column[4 + i] * row[0];
            }
            a->re[4 * j + k] = row[0];
            a->im[4 * j + k] = row[1];
        }
    }
    return true;
}

static void fix_rows(const bool fixed[4], block *corner, block *coupling)
{
    for (int i = 0; i < 4; i++) {
        if (!fixed[i]) continue;
        for (int j = 0; j < 4; j++) {
            corner->re[4 * j + i] = i == j ? 1.0 : 0.0;
            corner->im[4 * j + i] = 0.0;
            if (coupling) coupling->re[4 * j + i] = coupling->im[4 * j + i] = 0.0;
        }
    }
}

/* Adds the tangent of what acts at an end, by rows, to its corner, by columns. */
static void add_end(const double tangent[2][16], block *corner)
{
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            corner->re[4 * j + i] += tangent[0][4 * i + j];
            corner->im[4 * j + i] += tangent[1][4 * i + j];
        }
}

static void pair_tangent(const chain *c, int e, const exposure *now, const sections *at,
                         const double *u, const tangent_weights mix[2], block out[6])
{
    double re[6][16], im[6][16];
    element_tangent(c, e, now, at, u, mix[0], re);
    element_tangent(c, e, now, at, u, mix[1], im);
    for (int b = 0; b < 6; b++)
        for (int i = 0; i < 4; i++)
            for (int j = 0; j < 4; j++) {
                out[b].re[4 * j + i] = re[b][4 * i + j];
                out[b].im[4 * j + i] = im[b][4 * i + j];
            }
}

/* Argument of the number that turns k, c and m of the blend (k real) to either side of the real
 * axis. */
static void half_turn(const tangent_weights mix[2], double turn[2])
{
    const double angle = -0.5 * atan2(mix[1].m, mix[0].m);
    turn[0] = cos(angle);
    turn[1] = sin(angle);
}

TWO_PATHS bool solver_chain_complex_factor(const chain *c, const exposure *now, const sections *at,
                                           const double *u, const tangent_weights mix[2],
                                           const chain_ends *ends, complex_factor *factors)
{
    double turn[2];
    half_turn(mix, turn);
    block corner = {{0.0}, {0.0}};
    add_end(ends->tangent[0], &corner);
    for (int e = 0; e < c->elements; e++) {
        block tangent[6], middle_left, middle_right, previous_next, next_previous;
        block *left = &tangent[LEFT_LEFT], *right = &tangent[RIGHT_RIGHT];
        complex_factor *f = &factors[e];
        pair_tangent(c, e, now, at, u + 8 * e, mix, tangent);
        f->middle_inverse = tangent[MIDDLE_MIDDLE];
        if (!invert(&f->middle_inverse, turn)) return false;
        f->left_middle = tangent[LEFT_MIDDLE];
        f->right_middle = tangent[MIDDLE_RIGHT];
        multiply(&f->middle_inverse, &f->left_middle, &middle_left);
        multiply(&f->middle_inverse, &f->right_middle, &middle_right);
        previous_next = next_previous = tangent[LEFT_RIGHT];
        subtract_product(&f->left_middle, &middle_left, left);
        subtract_product(&f->left_middle, &middle_right, &previous_next);
        subtract_product(&f->right_middle, &middle_left, &next_previous);
        subtract_product(&f->right_middle, &middle_right, right);

        for (int i = 0; i < 16; i++) {
            corner.re[i] += left->re[i];
            corner.im[i] += left->im[i];
        }
        if (e == 0) fix_rows(ends->fixed[0], &corner, &previous_next);
        if (!invert(&corner, turn)) return false;
        f->corner_inverse = corner;
        f->next_previous = next_previous;
        multiply(&corner, &previous_next, &f->previous_next);
        subtract_product(&next_previous, &f->previous_next, right);
        corner = *right;
    }
    add_end(ends->tangent[1], &corner);
    fix_rows(ends->fixed[1], &corner, NULL);
    if (!invert(&corner, turn)) return false;
    factors[c->elements].corner_inverse = corner;
    return true;
}

static void clear_fixed(const bool fixed[4], double *node)
{
    for (int i = 0; i < 4; i++)
        if (fixed[i]) node[i] = node[4 + i] = 0.0;
}

/* rhs (nodes, 8), a node's four real parts before its imaginary ones, becomes the solution. */
TWO_PATHS void solver_chain_complex_solve(const chain *c, const complex_factor *factors,
                                          const chain_ends *ends, double *rhs)
{
    const int last = c->elements;
    double work[8];
    clear_fixed(ends->fixed[0], rhs);
    for (int e = 0; e < last; e++) {
        const complex_factor *f = &factors[e];
        double *left = rhs + 16 * e, *middle = left + 8, *right = left + 16;
        apply(&f->middle_inverse, middle, work);
        subtract_apply(&f->left_middle, work, left);
        subtract_apply(&f->right_middle, work, right);
        if (e == 0) clear_fixed(ends->fixed[0], left);
        apply(&f->corner_inverse, left, work);
        memcpy(left, work, sizeof work);
        subtract_apply(&f->next_previous, left, right);
    }
    double *end = rhs + 16 * last;
    clear_fixed(ends->fixed[1], end);
    apply(&factors[last].corner_inverse, end, work);
    memcpy(end, work, sizeof work);
    for (int e = last - 1; e >= 0; e--) {
        const complex_factor *f = &factors[e];
        double *left = rhs + 16 * e, *middle = left + 8, *right = left + 16;
        subtract_apply(&f->previous_next, right, left);
        subtract_apply(&f->left_middle, left, middle);
        subtract_apply(&f->right_middle, right, middle);
        apply(&f->middle_inverse, middle, work);
        memcpy(middle, work, sizeof work);
    }
}
