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

bool solver_factor(const gallop_model *model, const instant *now, const double *u, const double *v, const double *a,
                   blend mix, const bool fixed[2][4], factor *factors)
{
    double corner[16] = {0.0};
    for (int i = 0; i < 4; i++) corner[5 * i] = mix.k * model->stiffness[0][i];
    for (int e = 0; e < model->elements; e++) {
        double block[9][16];
        enum { LL, LM, LR, ML, MM, MR, RL, RM, RR };
        factor *f = &factors[e];
        element_tangent(model, e, now, u + 8 * e, v + 8 * e, a + 8 * e, mix, block);
        memcpy(f->middle_inverse, block[MM], sizeof block[MM]);
        if (!invert(f->middle_inverse)) return false;
        memcpy(f->left_middle, block[LM], sizeof block[LM]);
        memcpy(f->right_middle, block[RM], sizeof block[RM]);
        multiply(f->middle_inverse, block[ML], f->middle_left);
        multiply(f->middle_inverse, block[MR], f->middle_right);
        subtract_product(block[LM], f->middle_left, block[LL]);
        subtract_product(block[LM], f->middle_right, block[LR]);
        subtract_product(block[RM], f->middle_left, block[RL]);
        subtract_product(block[RM], f->middle_right, block[RR]);

        for (int i = 0; i < 16; i++) corner[i] += block[LL][i];
        if (e == 0) fix_rows(fixed[0], corner, block[LR]);
        if (!invert(corner)) return false;
        memcpy(f->corner_inverse, corner, sizeof corner);
        memcpy(f->next_previous, block[RL], sizeof block[RL]);
        multiply(corner, block[LR], f->previous_next);
        subtract_product(block[RL], f->previous_next, block[RR]);
        memcpy(corner, block[RR], sizeof corner);
    }
    for (int i = 0; i < 4; i++) corner[5 * i] += mix.k * model->stiffness[1][i];
    fix_rows(fixed[1], corner, NULL);
    if (!invert(corner)) return false;
    memcpy(factors[model->elements].corner_inverse, corner, sizeof corner);
    return true;
}

/* rhs (nodes, 4) becomes the solution; entries of fixed unknowns become zero. */
void solver_solve(const gallop_model *model, const factor *factors, const bool fixed[2][4], double *rhs)
{
    const int last = model->elements;
    double work[4];
    for (int i = 0; i < 4; i++)
        if (fixed[0][i]) rhs[i] = 0.0;
    for (int e = 0; e < last; e++) {
        const factor *f = &factors[e];
        double *left = rhs + 8 * e, *middle = left + 4, *right = left + 8;
        apply(f->middle_inverse, middle, work);
        memcpy(middle, work, sizeof work);
        subtract_apply(f->left_middle, middle, left);
        subtract_apply(f->right_middle, middle, right);
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
        subtract_apply(f->middle_left, left, middle);
        subtract_apply(f->middle_right, right, middle);
    }
}
