/* Direct solver for the chain: the middle node of each element is condensed, LANES elements at a time; what remains is
 * block tridiagonal in the corner nodes, and is eliminated from both ends towards the middle: two recursions that do not
 * wait for each other.  Work and memory grow linearly with the number of elements.  Everything is compiled for blocks of
 * 4, 3 and 2 unknowns: the leading ones, the others stay as they are. */
#include "internal.h"

/* Where a factorisation lies in its block of memory.  Of a strip: the inverse of its middle blocks and the couplings of
 * the middle with the left and the right node, LANES (in the last strip: as many as there are elements) values of each
 * entry side by side.  Of a corner, by columns: inverse; carry, which takes its right-hand side to the neighbour towards
 * the middle of the span; back, which takes the neighbour's solution back to it. */
enum { MIDDLE_INVERSE, COUPLED_LEFT, COUPLED_RIGHT };
enum { INVERSE, CARRY, BACK };

INLINE size_t strip_part(int e, int count, int part, int size) { return (size_t)(3 * e + part * count) * size; }

INLINE size_t corner_part(int elements, int corner) { return 3 * (size_t)(elements + corner); }

INLINE void put(double *store, int entry, int count, const lanes *value)
{
    if (count >= LANES) *(lanes *)(store + LANES * entry) = *value;
    else
        for (int k = 0; k < count; k++) store[count * entry + k] = LANE(*value, k);
}

INLINE void get(const double *store, int entry, int count, lanes *value)
{
    if (count >= LANES) *value = *(const lanes *)(store + LANES * entry);
    else
        for (int k = 0; k < LANES; k++) LANE(*value, k) = store[count * entry + (k < count ? k : 0)];
}

/* Gauss-Jordan without row exchange: the blocks are dominated by their symmetric positive part, and a pivot that is not
 * a positive finite number means the tangent has lost it. */
#define GAUSS_JORDAN(type, a, size, judge)                                                                            \
    for (int k = 0; k < (size); k++) {                                                                                \
        const type pivot = (a)[(size) * k + k], inverse = 1.0 / pivot;                                                \
        type column[4];                                                                                               \
        judge;                                                                                                        \
        for (int i = 0; i < (size); i++) column[i] = (a)[(size) * i + k];                                             \
        for (int j = 0; j < (size); j++) (a)[(size) * k + j] *= inverse;                                              \
        (a)[(size) * k + k] = inverse;                                                                                \
        for (int i = 0; i < (size); i++) {                                                                            \
            if (i == k) continue;                                                                                     \
            (a)[(size) * i + k] = (type){0.0};                                                                        \
            for (int j = 0; j < (size); j++) (a)[(size) * i + j] -= column[i] * (a)[(size) * k + j];                  \
        }                                                                                                             \
    }

INLINE bool invert(double *restrict a, int n)
{
    bool good = true;
    GAUSS_JORDAN(double, a, n, good = good && pivot > 0.0 && isfinite(pivot))
    return good;
}

INLINE bool invert_lanes(lanes *a, int n)
{
    lanes worst = {0.0};   /* not a number in lanes with a pivot that is no positive finite number */
    GAUSS_JORDAN(lanes, a, n, worst += PICK(pivot > 0.0 * pivot, 0.0 * pivot, 0.0 * pivot + NAN))
    bool good = true;
    for (int k = 0; k < LANES; k++) good = good && LANE(worst, k) == 0.0;
    return good;
}

/* out = a b by rows, and out -= a b */
INLINE void multiply_lanes(const lanes *a, const lanes *b, int n, lanes *out)
{
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            lanes sum = a[n * i] * b[j];
            for (int k = 1; k < n; k++) sum += a[n * i + k] * b[n * k + j];
            out[n * i + j] = sum;
        }
}

INLINE void subtract_lanes(const lanes *a, const lanes *b, int n, lanes *out)
{
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            lanes sum = a[n * i] * b[j];
            for (int k = 1; k < n; k++) sum += a[n * i + k] * b[n * k + j];
            out[n * i + j] -= sum;
        }
}

/* The same by columns. */
INLINE void multiply(const double *restrict a, const double *restrict b, int n, double *restrict out)
{
    for (int j = 0; j < n; j++)
        for (int i = 0; i < n; i++) {
            double sum = a[i] * b[n * j];
            for (int k = 1; k < n; k++) sum += a[n * k + i] * b[n * j + k];
            out[n * j + i] = sum;
        }
}

/* y -= a x, a by columns */
INLINE void subtract_apply(const double *restrict a, const double *restrict x, int n, double *restrict y)
{
    for (int i = 0; i < n; i++) {
        double sum = a[i] * x[0];
        for (int k = 1; k < n; k++) sum += a[n * k + i] * x[k];
        y[i] -= sum;
    }
}

INLINE void apply(const double *restrict a, double *restrict x, int n)
{
    double out[4];
    for (int i = 0; i < n; i++) {
        out[i] = a[i] * x[0];
        for (int k = 1; k < n; k++) out[i] += a[n * k + i] * x[k];
    }
    for (int i = 0; i < n; i++) x[i] = out[i];
}

/* Condenses the middle nodes of a strip: what is left goes to the places of its corners, raw. */
INLINE bool condense(const gallop_model *model, int e, int count, lanes block[6][16], int n, double *store)
{
    const int elements = model->elements, meeting = elements / 2, size = n * n;
    lanes *inverse = block[MIDDLE_MIDDLE], to_left[16], to_right[16], back_coupling[16];
    if (!invert_lanes(inverse, n)) return false;
    multiply_lanes(inverse, block[LEFT_MIDDLE], n, to_left);
    multiply_lanes(inverse, block[MIDDLE_RIGHT], n, to_right);
    memcpy(back_coupling, block[LEFT_RIGHT], sizeof back_coupling);
    subtract_lanes(block[LEFT_MIDDLE], to_left, n, block[LEFT_LEFT]);
    subtract_lanes(block[LEFT_MIDDLE], to_right, n, block[LEFT_RIGHT]);     /* row of the left node, column of the right */
    subtract_lanes(block[MIDDLE_RIGHT], to_left, n, back_coupling);         /* the other way round */
    subtract_lanes(block[MIDDLE_RIGHT], to_right, n, block[RIGHT_RIGHT]);
    for (int i = 0; i < size; i++) {
        put(store + strip_part(e, count, MIDDLE_INVERSE, size), i, count, &inverse[i]);
        put(store + strip_part(e, count, COUPLED_LEFT, size), i, count, &block[LEFT_MIDDLE][i]);
        put(store + strip_part(e, count, COUPLED_RIGHT, size), i, count, &block[MIDDLE_RIGHT][i]);
    }
    for (int k = 0; k < count; k++) {
        const bool right_half = e + k >= meeting;
        double *left = store + corner_part(elements, e + k) * size, *right = left + 3 * size;
        double *coupled = right_half ? right : left;
        const lanes *carry = right_half ? block[LEFT_RIGHT] : back_coupling;
        const lanes *back = right_half ? back_coupling : block[LEFT_RIGHT];
        for (int i = 0; i < n; i++)
            for (int j = 0; j < n; j++) {
                const int row = n * i + j, column = n * j + i;
                left[column] += LANE(block[LEFT_LEFT][row], k);
                right[column] = LANE(block[RIGHT_RIGHT][row], k);
                coupled[CARRY * size + column] = LANE(carry[row], k);
                coupled[BACK * size + column] = LANE(back[row], k);
            }
    }
    return true;
}

/* Eliminates a corner; `neighbour` is the inverse-to-be of the next one towards the middle. */
INLINE bool eliminate(double *corner, double *neighbour, int n)
{
    const int size = n * n;
    double raw[2][16];
    double *inverse = corner, *carry = corner + CARRY * size, *back = corner + BACK * size;
    if (!invert(inverse, n)) return false;
    memcpy(raw[0], carry, sizeof(double) * size);
    memcpy(raw[1], back, sizeof(double) * size);
    multiply(inverse, raw[1], n, back);
    multiply(raw[0], inverse, n, carry);
    for (int j = 0; j < n; j++) subtract_apply(raw[0], back + n * j, n, neighbour + n * j);
    return true;
}

static void fix_rows(const bool fixed[4], double *corner, int n)
{
    for (int i = 0; i < n; i++) {
        if (!fixed[i]) continue;
        for (int j = 0; j < n; j++) {
            corner[n * j + i] = i == j ? 1.0 : 0.0;
            corner[(BACK * n + j) * n + i] = 0.0;
        }
    }
}

INLINE bool factor_all(const gallop_model *model, const instant *now, const sections *at, const double *u, blend mix,
                       const bool fixed[2][4], int n, double *store)
{
    const int elements = model->elements, meeting = elements / 2, size = n * n;
    double *first = store + corner_part(elements, 0) * size;
    double *last = store + corner_part(elements, elements) * size;
    for (int i = 0; i < size; i++) first[i] = 0.0;
    for (int index = 0; index < model->strips; index++) {
        const int e = LANES * index, left = elements - e;
        lanes block[6][16];
        strip_tangent(model, index, now, at, u, mix, block);
        if (!condense(model, e, left < LANES ? left : LANES, block, n, store)) return false;
    }
    for (int i = 0; i < n; i++) {
        first[(n + 1) * i] += mix.k * model->stiffness[0][i];
        last[(n + 1) * i] += mix.k * model->stiffness[1][i];
    }
    fix_rows(fixed[0], first, n);
    fix_rows(fixed[1], last, n);
    for (int k = 0; k < elements - meeting; k++) {
        double *left = first + 3 * size * k, *right = last - 3 * size * k;
        bool good = k >= meeting || eliminate(left, left + 3 * size, n);
        good = eliminate(right, right - 3 * size, n) && good;
        if (!good) return false;
    }
    return invert(first + 3 * size * meeting, n);
}

INLINE void strip_couplings(const double *store, int count, const lanes x[4], int n, lanes y[4])
{
    for (int i = 0; i < n; i++) y[i] = (lanes){0.0};
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            lanes a;
            get(store, n * i + j, count, &a);
            y[i] += a * x[j];
        }
}

/* Middle nodes: their part of the solution as if the corners were at rest, taken to the corners. */
INLINE void solve_middles(const double *store, int e, int count, int n, double *rhs)
{
    const int size = n * n;
    lanes middle[4], own[4], corner[4];
    read_nodes(rhs + 8 * e, 1, count, middle);
    strip_couplings(store + strip_part(e, count, MIDDLE_INVERSE, size), count, middle, n, own);
    for (int side = 0; side < 2; side++) {
        strip_couplings(store + strip_part(e, count, side ? COUPLED_RIGHT : COUPLED_LEFT, size), count, own, n, corner);
        for (int i = 0; i < n; i++) corner[i] = -corner[i];
        for (int i = n; i < 4; i++) corner[i] = (lanes){0.0};
        add_to_nodes(rhs + 8 * e, 2 * side, count, corner);
    }
    for (int i = n; i < 4; i++) own[i] = (lanes){0.0};
    write_nodes(rhs + 8 * e, 1, count, own);
}

INLINE void correct_middles(const double *store, int e, int count, int n, double *rhs)
{
    const int size = n * n;
    lanes left[4], right[4], from_left[4], from_right[4], change[4];
    read_nodes(rhs + 8 * e, 0, count, left);
    read_nodes(rhs + 8 * e, 2, count, right);
    strip_couplings(store + strip_part(e, count, COUPLED_LEFT, size), count, left, n, from_left);
    strip_couplings(store + strip_part(e, count, COUPLED_RIGHT, size), count, right, n, from_right);
    for (int i = 0; i < n; i++) from_left[i] += from_right[i];
    strip_couplings(store + strip_part(e, count, MIDDLE_INVERSE, size), count, from_left, n, change);
    for (int i = 0; i < n; i++) change[i] = -change[i];
    for (int i = n; i < 4; i++) change[i] = (lanes){0.0};
    add_to_nodes(rhs + 8 * e, 1, count, change);
}

INLINE void solve_all(const gallop_model *model, const double *store, const bool fixed[2][4], int n, double *rhs)
{
    const int elements = model->elements, meeting = elements / 2, size = n * n, full = elements / LANES * LANES;
    const double *first = store + corner_part(elements, 0) * size;
    double *x = rhs, *y = rhs + 8 * elements;
    const double *last = store + corner_part(elements, elements) * size;
    for (int e = 0; e < full; e += LANES) solve_middles(store, e, LANES, n, rhs);
    if (full < elements) solve_middles(store, full, elements - full, n, rhs);
    for (int i = 0; i < 4; i++) {
        if (fixed[0][i]) x[i] = 0.0;
        if (fixed[1][i]) y[i] = 0.0;
    }
    for (int k = 0; k < elements - meeting; k++, x += 8, y -= 8) {
        if (k < meeting) subtract_apply(first + (3 * k + CARRY) * size, x, n, x + 8);
        subtract_apply(last - (3 * k - CARRY) * size, y, n, y - 8);
    }
    apply(first + 3 * size * meeting, rhs + 8 * meeting, n);
    for (int k = elements - meeting - 1; k >= 0; k--) {
        x = rhs + 8 * k;
        y = rhs + 8 * (elements - k);
        if (k < meeting) {
            apply(first + 3 * k * size, x, n);
            subtract_apply(first + (3 * k + BACK) * size, x + 8, n, x);
        }
        apply(last - 3 * k * size, y, n);
        subtract_apply(last - (3 * k - BACK) * size, y - 8, n, y);
    }
    for (int e = 0; e < full; e += LANES) correct_middles(store, e, LANES, n, rhs);
    if (full < elements) correct_middles(store, full, elements - full, n, rhs);
}

#define SOLVER_OF(unknowns)                                                                                           \
    TWO_PATHS static bool factor_##unknowns(const gallop_model *model, const instant *now, const sections *at,        \
                                            const double *u, blend mix, const bool fixed[2][4], factor *factors)      \
    {                                                                                                                 \
        return factor_all(model, now, at, u, mix, fixed, unknowns, factors->value);                                         \
    }                                                                                                                 \
    TWO_PATHS static void solve_##unknowns(const gallop_model *model, const factor *factors, const bool fixed[2][4],  \
                                           double *rhs)                                                               \
    {                                                                                                                 \
        solve_all(model, factors->value, fixed, unknowns, rhs);                                                             \
    }
SOLVER_OF(2)
SOLVER_OF(3)
SOLVER_OF(4)

/* `at` holds the section forces, with slopes, of the motion whose displacements are u. */
bool solver_factor(const gallop_model *model, const instant *now, const sections *at, const double *u, blend mix,
                   const bool fixed[2][4], factor *factors)
{
    if (model->unknowns == 2) return factor_2(model, now, at, u, mix, fixed, factors);
    if (model->unknowns == 3) return factor_3(model, now, at, u, mix, fixed, factors);
    return factor_4(model, now, at, u, mix, fixed, factors);
}

/* rhs (nodes, 4) becomes the solution; entries of fixed unknowns become zero. */
void solver_solve(const gallop_model *model, const factor *factors, const bool fixed[2][4], double *rhs)
{
    if (model->unknowns == 2) solve_2(model, factors, fixed, rhs);
    else if (model->unknowns == 3) solve_3(model, factors, fixed, rhs);
    else solve_4(model, factors, fixed, rhs);
}
