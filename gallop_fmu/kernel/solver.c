/* Direct solver for the chain: the mid-side node of each element is condensed, what remains is block tridiagonal in the
 * corner nodes with 4 x 4 blocks.  Work and memory grow linearly with the number of elements. */
#include "internal.h"

static inline void multiply(const double *restrict a, const double *restrict b, double *restrict out)
{
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            out[4 * i + j] = a[4 * i] * b[j] + a[4 * i + 1] * b[4 + j] + a[4 * i + 2] * b[8 + j] + a[4 * i + 3] * b[12 + j];
}

static inline void subtract_product(const double *restrict a, const double *restrict b, double *restrict out)
{
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            out[4 * i + j] -= a[4 * i] * b[j] + a[4 * i + 1] * b[4 + j] + a[4 * i + 2] * b[8 + j] + a[4 * i + 3] * b[12 + j];
}

static inline void apply(const double *restrict a, const double *restrict x, double *restrict out)
{
    for (int i = 0; i < 4; i++) out[i] = a[4 * i] * x[0] + a[4 * i + 1] * x[1] + a[4 * i + 2] * x[2] + a[4 * i + 3] * x[3];
}

static inline void subtract_apply(const double *restrict a, const double *restrict x, double *restrict out)
{
    for (int i = 0; i < 4; i++) out[i] -= a[4 * i] * x[0] + a[4 * i + 1] * x[1] + a[4 * i + 2] * x[2] + a[4 * i + 3] * x[3];
}

/* Gauss-Jordan without row exchange: the blocks are dominated by their symmetric positive part, and a pivot that is not
 * a positive finite number means the tangent has lost it. */
static bool invert(double *restrict a)
{
    for (int k = 0; k < 4; k++) {
        double pivot = a[5 * k];
        if (!(pivot > 0.0) || !isfinite(pivot)) return false;
        double inverse = 1.0 / pivot, column[4];
        for (int i = 0; i < 4; i++) column[i] = a[4 * i + k];
        for (int j = 0; j < 4; j++) a[4 * k + j] *= inverse;
        a[5 * k] = inverse;
        for (int i = 0; i < 4; i++) {
            if (i == k) continue;
            a[4 * i + k] = 0.0;
            for (int j = 0; j < 4; j++) a[4 * i + j] -= column[i] * a[4 * k + j];
        }
    }
    return true;
}

static void fix_rows(const bool fixed[4], double *corner, double *coupling)
{
    for (int i = 0; i < 4; i++) {
        if (!fixed[i]) continue;
        for (int j = 0; j < 4; j++) {
            corner[4 * i + j] = i == j ? 1.0 : 0.0;
            if (coupling) coupling[4 * i + j] = 0.0;
        }
    }
}

/* `at` holds the section forces, with slopes, of the motion whose displacements are u. */
TWO_PATHS bool solver_factor(const gallop_model *model, const instant *now, const sections *at, const double *u, blend mix,
                   const bool fixed[2][4], factor *factors)
{
    double corner[16] = {0.0};
    for (int i = 0; i < 4; i++) corner[5 * i] = mix.k * model->stiffness[0][i];
    for (int e = 0; e < model->elements; e++) {
        double block[6][16], middle_left[16], middle_right[16], previous_next[16], next_previous[16];
        double *left = block[LEFT_LEFT], *right = block[RIGHT_RIGHT], *across = block[LEFT_RIGHT];
        factor *f = &factors[e];
        element_tangent(model, e, now, at, u + 8 * e, mix, block);
        memcpy(f->middle_inverse, block[MIDDLE_MIDDLE], sizeof block[MIDDLE_MIDDLE]);
        if (!invert(f->middle_inverse)) return false;
        memcpy(f->left_middle, block[LEFT_MIDDLE], sizeof block[LEFT_MIDDLE]);
        memcpy(f->right_middle, block[MIDDLE_RIGHT], sizeof block[MIDDLE_RIGHT]);
        multiply(f->middle_inverse, f->left_middle, middle_left);
        multiply(f->middle_inverse, f->right_middle, middle_right);
        memcpy(previous_next, across, sizeof previous_next);
        memcpy(next_previous, across, sizeof next_previous);
        subtract_product(f->left_middle, middle_left, left);
        subtract_product(f->left_middle, middle_right, previous_next);
        subtract_product(f->right_middle, middle_left, next_previous);
        subtract_product(f->right_middle, middle_right, right);

        for (int i = 0; i < 16; i++) corner[i] += left[i];
        if (e == 0) fix_rows(fixed[0], corner, previous_next);
        if (!invert(corner)) return false;
        memcpy(f->corner_inverse, corner, sizeof corner);
        memcpy(f->next_previous, next_previous, sizeof next_previous);
        multiply(corner, previous_next, f->previous_next);
        subtract_product(next_previous, f->previous_next, right);
        memcpy(corner, right, sizeof corner);
    }
    for (int i = 0; i < 4; i++) corner[5 * i] += mix.k * model->stiffness[1][i];
    fix_rows(fixed[1], corner, NULL);
    if (!invert(corner)) return false;
    memcpy(factors[model->elements].corner_inverse, corner, sizeof corner);
    return true;
}

/* rhs (nodes, 4) becomes the solution; entries of fixed unknowns become zero. */
TWO_PATHS void solver_solve(const gallop_model *model, const factor *factors, const bool fixed[2][4], double *rhs)
{
    const int last = model->elements;
    double work[4];
    for (int i = 0; i < 4; i++)
        if (fixed[0][i]) rhs[i] = 0.0;
    for (int e = 0; e < last; e++) {
        const factor *f = &factors[e];
        double *left = rhs + 8 * e, *middle = left + 4, *right = left + 8;
        apply(f->middle_inverse, middle, work);
        subtract_apply(f->left_middle, work, left);
        subtract_apply(f->right_middle, work, right);
        if (e == 0)
            for (int i = 0; i < 4; i++)
                if (fixed[0][i]) left[i] = 0.0;
        apply(f->corner_inverse, left, work);
        memcpy(left, work, sizeof work);
        subtract_apply(f->next_previous, left, right);
    }
    double *end = rhs + 8 * last;
    for (int i = 0; i < 4; i++)
        if (fixed[1][i]) end[i] = 0.0;
    apply(factors[last].corner_inverse, end, work);
    memcpy(end, work, sizeof work);
    for (int e = last - 1; e >= 0; e--) {
        const factor *f = &factors[e];
        double *left = rhs + 8 * e, *middle = left + 4, *right = left + 8;
        subtract_apply(f->previous_next, right, left);
        subtract_apply(f->left_middle, left, middle);
        subtract_apply(f->right_middle, right, middle);
        apply(f->middle_inverse, middle, work);
        memcpy(middle, work, sizeof work);
    }
}
