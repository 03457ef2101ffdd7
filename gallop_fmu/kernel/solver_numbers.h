/* Arithmetic of the block solver, for real and for complex numbers: PARTS is 1 or 2 (see
 * solver_block.h).  C's own complex type would be neither vector code nor known to every compiler.
 * Blocks have n rows and columns, 2 or 4, a constant wherever the functions are called. */
#include "base_lanes.h"

#include <math.h>
#include <stdbool.h>

/* One number, and one for each of LANES elements. */
typedef struct {
    double part[PARTS];
} number;
typedef struct {
    lanes part[PARTS];
} strip_number;

/* A block of a corner, by columns, so that four rows make a vector.  A column is arranged as the
 * unknowns of a node in a right-hand side; of two unknowns, the last two rows stay zero. */
typedef struct {
    double value[4][PARTS][4]; /* [column][part][row] */
} block;

/* Brings the pivots of a complex tangent to the right half plane. */
typedef struct {
    double cosine, sine;
} rotation;

/* `out = a b`, `out += a b`, `out -= a b` of numbers of either kind; the inverse of a pivot; its
 * size, which tells whether it is finite; and its part that must be positive. */
#if PARTS == 1
#define PRODUCT(out, sign, a, b) ((out).part[0] sign(a).part[0] * (b).part[0])
#define INVERSE(out, pivot) ((out).part[0] = 1.0 / (pivot).part[0])
#define SIZE(pivot) ((pivot).part[0])
#define UPRIGHT(pivot, turn) ((void)(turn), (pivot).part[0])
#else
#define PRODUCT(out, sign, a, b)                                                                   \
    ((out).part[0] sign(a).part[0] * (b).part[0] - (a).part[1] * (b).part[1],                      \
     (out).part[1] sign(a).part[0] * (b).part[1] + (a).part[1] * (b).part[0])
#define INVERSE(out, pivot)                                                                        \
    ((out).part[0] = (pivot).part[0] / SIZE(pivot), (out).part[1] = -(pivot).part[1] / SIZE(pivot))
#define SIZE(pivot) ((pivot).part[0] * (pivot).part[0] + (pivot).part[1] * (pivot).part[1])
#define UPRIGHT(pivot, turn) ((pivot).part[0] * (turn)->cosine - (pivot).part[1] * (turn)->sine)
#endif

/* Before a loop that gains nothing from being written out. */
#if defined(__GNUC__) && !defined(__clang__)
#define ROLLED _Pragma("GCC unroll 1")
#else
#define ROLLED
#endif

/* ---- Strips: LANES elements at once. ---- */

/* Gauss-Jordan.  The tangent is not positive definite any more if a pivot is not a finite number
 * with a positive upright part. */
INLINE bool invert_strip(strip_number *a, int n, const rotation *turn)
{
    lanes doubt = {0.0}; /* not a number in lanes with a bad pivot */
    for (int k = 0; k < n; k++) {
        const strip_number pivot = a[n * k + k];
        strip_number inverse, column[4];
        INVERSE(inverse, pivot);
        doubt += PICK(UPRIGHT(pivot, turn) > 0.0 * SIZE(pivot), 0.0 * SIZE(pivot),
                      0.0 * SIZE(pivot) + NAN);
        for (int i = 0; i < n; i++) column[i] = a[n * i + k];
        for (int j = 0; j < n; j++) {
            const strip_number entry = a[n * k + j];
            PRODUCT(a[n * k + j], =, entry, inverse);
        }
        a[n * k + k] = inverse;
        for (int i = 0; i < n; i++) {
            if (i == k) continue;
            for (int p = 0; p < PARTS; p++) a[n * i + k].part[p] = (lanes){0.0};
            for (int j = 0; j < n; j++) PRODUCT(a[n * i + j], -=, column[i], a[n * k + j]);
        }
    }
    bool good = true;
    for (int k = 0; k < LANES; k++) good = good && LANE(doubt, k) == 0.0;
    return good;
}

/* Row a times a column of b, whose entries lie `step` numbers apart. */
INLINE void dot(const strip_number *a, const strip_number *b, int step, int n, strip_number *sum)
{
    PRODUCT(*sum, =, a[0], b[0]);
    for (int k = 1; k < n; k++) PRODUCT(*sum, +=, a[k], b[step * k]);
}

/* out = a b by rows, and out -= a b */
INLINE void multiply_strip(const strip_number *a, const strip_number *b, int n, strip_number *out)
{
    ROLLED
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) dot(a + n * i, b + j, n, n, out + n * i + j);
}

INLINE void subtract_strip(const strip_number *a, const strip_number *b, int n, strip_number *out)
{
    ROLLED
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            strip_number sum;
            dot(a + n * i, b + j, n, n, &sum);
            for (int p = 0; p < PARTS; p++) out[n * i + j].part[p] -= sum.part[p];
        }
}

/* y = a x */
INLINE void apply_strip(const strip_number *a, const strip_number *x, int n, strip_number *y)
{
    for (int i = 0; i < n; i++) dot(a + n * i, x, 1, n, y + i);
}

/* The unknowns of node `node` (0 left, 1 middle, 2 right) of `count` elements; the left node of the
 * first one at y. */
INLINE void read_strip(const double *y, int node, int count, strip_number out[4])
{
    for (int p = 0; p < PARTS; p++) {
        lanes x[4];
        gather_lanes(y + 4 * (PARTS * node + p), 8 * PARTS, count, x);
        for (int i = 0; i < 4; i++) out[i].part[p] = x[i];
    }
}

/* Write to the nodes, or add to what they have; unknowns from n on are zero. */
INLINE void write_strip(double *y, int node, int count, const strip_number *in, int n, bool add)
{
    for (int p = 0; p < PARTS; p++) {
        lanes x[4];
        for (int i = 0; i < 4; i++) x[i] = i < n ? in[i].part[p] : (lanes){0.0};
        if (add)
            scatter_add_lanes(y + 4 * (PARTS * node + p), 8 * PARTS, count, x);
        else
            scatter_lanes(y + 4 * (PARTS * node + p), 8 * PARTS, count, x);
    }
}

INLINE void negate(strip_number *x, int n)
{
    for (int i = 0; i < n; i++)
        for (int p = 0; p < PARTS; p++) x[i].part[p] = -x[i].part[p];
}

/* ---- Corners: a column of four rows at once. ---- */

/* The rows from i on that make a vector. */
#if LANES == 4
#define ROWS(i) ((lanes){0.0, 1.0, 2.0, 3.0} + (double)(i))
#else
#define ROWS(i) ((lanes)(i))
#endif

/* Gauss-Jordan on the columns as if they were rows, as the transposed inverse is the inverse of the
 * transpose. */
INLINE bool invert(block *a, int n, const rotation *turn)
{
    const lanes zero = {0.0};
    bool good = true;
    for (int k = 0; k < n; k++) {
        number pivot, inverse, factor[4];
        for (int p = 0; p < PARTS; p++) pivot.part[p] = a->value[k][p][k];
        for (int i = 0; i < n; i++)
            for (int p = 0; p < PARTS; p++) factor[i].part[p] = a->value[i][p][k];
        good = good && UPRIGHT(pivot, turn) > 0.0 && isfinite(SIZE(pivot));
        INVERSE(inverse, pivot);
        for (int j = 0; j < n; j += LANES) {
            strip_number own, row, change;
            for (int p = 0; p < PARTS; p++)
                own.part[p] =
                    PICK(ROWS(j) == (double)k, zero + (p == 0), LANES_AT(a->value[k][p] + j));
            PRODUCT(row, =, own, inverse);
            for (int i = 0; i < n; i++) {
                PRODUCT(change, =, factor[i], row);
                for (int p = 0; p < PARTS; p++) {
                    const lanes rest =
                        PICK(ROWS(j) == (double)k, zero, LANES_AT(a->value[i][p] + j));
                    LANES_AT(a->value[i][p] + j) = rest - change.part[p];
                    if (i == k) LANES_AT(a->value[i][p] + j) = row.part[p];
                }
            }
        }
    }
    return good;
}

/* out = a x, of columns */
INLINE void apply(const block *a, const double *x, int n, double *out)
{
    for (int i = 0; i < n; i += LANES) {
        strip_number term[4];
        for (int j = 0; j < n; j++) {
            strip_number column;
            number entry;
            for (int p = 0; p < PARTS; p++) {
                column.part[p] = LANES_AT(a->value[j][p] + i);
                entry.part[p] = x[4 * p + j];
            }
            PRODUCT(term[j], =, column, entry);
        }
        for (int p = 0; p < PARTS; p++) {
            lanes sum = term[0].part[p] + term[1].part[p];
            if (n == 4) sum += term[2].part[p] + term[3].part[p];
            LANES_AT(out + 4 * p + i) = sum;
        }
    }
}

/* y -= a x */
INLINE void subtract_apply(const block *a, const double *x, int n, double *y)
{
    double change[PARTS][4];
    apply(a, x, n, change[0]);
    for (int p = 0; p < PARTS; p++)
        for (int i = 0; i < n; i += LANES) LANES_AT(y + 4 * p + i) -= LANES_AT(change[p] + i);
}

/* x = a x */
INLINE void transform(const block *a, int n, double *x)
{
    double out[PARTS][4];
    apply(a, x, n, out[0]);
    for (int p = 0; p < PARTS; p++)
        for (int i = 0; i < n; i += LANES) LANES_AT(x + 4 * p + i) = LANES_AT(out[p] + i);
}
