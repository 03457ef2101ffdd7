/* Direct solver for the chain: the middle node of each element is condensed, LANES elements at a
 * time; what remains is block tridiagonal in the corner nodes, and is eliminated from both ends
 * towards the middle: two recursions that do not wait for each other.  Work and memory grow
 * linearly with the number of elements.  Everything is compiled for blocks of 4, 3 and 2 unknowns:
 * the leading ones, the others stay as they are. */
#include "solver.h"

/* Where a factorisation lies in its block of memory.  Of a strip: the inverse of its middle blocks
 * and the couplings of the middle with the left and the right node, LANES values of each entry side
 * by side.  Of a corner, by columns: inverse; carry, which takes its right-hand side to the
 * neighbour towards the middle of the span; back, which takes the neighbour's solution back to it.
 */
enum { MIDDLE_INVERSE, COUPLED_LEFT, COUPLED_RIGHT };
enum { INVERSE, CARRY, BACK };

INLINE lanes *strip_part(double *store, int index, int part, int size)
{
    return (lanes *)store + (size_t)(3 * index + part) * size;
}

INLINE const lanes *strip_part_read(const double *store, int index, int part, int size)
{
    return (const lanes *)store + (size_t)(3 * index + part) * size;
}

/* Three unknowns take the room of four in a column, to fill a vector. */
#define STRIDE(n) ((n) == 3 && LANES == 4 ? 4 : (n))
#define VECTOR(n) (LANES == 4 && STRIDE(n) == 4)

INLINE size_t corner_part(int strips, int corner, int n)
{
    return (size_t)3 * (LANES * strips * n + corner * STRIDE(n)) * n;
}

/* Gauss-Jordan without row exchange: the blocks are dominated by their symmetric positive part, and
 * a pivot that is not a positive finite number means the tangent has lost it. */
INLINE bool invert(double *a, int n)
{
    const int wide = STRIDE(n);
    bool good = true;
    for (int k = 0; k < n; k++) {
        const double pivot = a[wide * k + k], inverse = 1.0 / pivot;
        double column[4], row[4];
        good = good && pivot > 0.0 && isfinite(pivot);
        for (int i = 0; i < n; i++) column[i] = i == k ? 0.0 : a[wide * i + k];
        for (int j = 0; j < wide; j++) row[j] = (j == k ? 1.0 : a[wide * k + j]) * inverse;
        for (int i = 0; i < n; i++) {
            a[wide * i + k] = 0.0;
            if (VECTOR(n))
                *(lanes *)(a + wide * i) -= column[i] * *(lanes *)row;
            else
                for (int j = 0; j < n; j++) a[wide * i + j] -= column[i] * row[j];
        }
        for (int j = 0; j < wide; j++) a[wide * k + j] = row[j];
    }
    return good;
}

INLINE bool invert_lanes(lanes *a, int n)
{
    lanes doubt = {0.0}; /* not a number in lanes with a pivot that is no positive finite number */
    for (int k = 0; k < n; k++) {
        const lanes pivot = a[n * k + k], inverse = 1.0 / pivot;
        lanes column[4];
        doubt += PICK(pivot > 0.0 * pivot, 0.0 * pivot, 0.0 * pivot + NAN);
        for (int i = 0; i < n; i++) column[i] = a[n * i + k];
        for (int j = 0; j < n; j++) a[n * k + j] *= inverse;
        a[n * k + k] = inverse;
        for (int i = 0; i < n; i++) {
            if (i == k) continue;
            a[n * i + k] = (lanes){0.0};
            for (int j = 0; j < n; j++) a[n * i + j] -= column[i] * a[n * k + j];
        }
    }
    bool good = true;
    for (int k = 0; k < LANES; k++) good = good && LANE(doubt, k) == 0.0;
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

/* a x, a by columns */
INLINE void product(const double *a, const double *x, int n, double *out)
{
    if (VECTOR(n)) {
        const lanes *column = (const lanes *)a;
        lanes sum = column[0] * x[0] + column[1] * x[1];
        if (n == 3) sum += column[2] * x[2];
        if (n == 4) sum += column[2] * x[2] + column[3] * x[3];
        *(lanes *)out = sum;
        return;
    }
    for (int i = 0; i < n; i++) {
        double sum = a[i] * x[0] + a[n + i] * x[1];
        if (n == 3) sum += a[2 * n + i] * x[2];
        if (n == 4) sum += a[2 * n + i] * x[2] + a[3 * n + i] * x[3];
        out[i] = sum;
    }
}

INLINE void multiply(const double *a, const double *b, int n, double *out)
{
    for (int j = 0; j < n; j++) product(a, b + STRIDE(n) * j, n, out + STRIDE(n) * j);
}

/* y -= a x */
INLINE void subtract_apply(const double *a, const double *x, int n, double *y)
{
    double change[4];
    product(a, x, n, change);
    if (VECTOR(n))
        *(lanes *)y -= *(lanes *)change;
    else
        for (int i = 0; i < n; i++) y[i] -= change[i];
}

INLINE void apply(const double *a, double *x, int n)
{
    double out[4];
    product(a, x, n, out);
    for (int i = 0; i < n; i++) x[i] = out[i];
}

/* Condenses the middle nodes of a strip: what is left goes to the places of its corners, raw. */
INLINE bool condense(const chain *c, int index, lanes block[6][16], int n, double *store)
{
    const int e = LANES * index, left_over = c->elements - e,
              count = left_over < LANES ? left_over : LANES;
    const int meeting = c->elements / 2, size = n * n, wide = STRIDE(n), room = n * wide;
    lanes *inverse = block[MIDDLE_MIDDLE], to_left[16], to_right[16], back_coupling[16];
    if (!invert_lanes(inverse, n)) return false;
    multiply_lanes(inverse, block[LEFT_MIDDLE], n, to_left);
    multiply_lanes(inverse, block[MIDDLE_RIGHT], n, to_right);
    for (int i = 0; i < size; i++) back_coupling[i] = block[LEFT_RIGHT][i];
    subtract_lanes(block[LEFT_MIDDLE], to_left, n, block[LEFT_LEFT]);
    subtract_lanes(block[LEFT_MIDDLE], to_right, n,
                   block[LEFT_RIGHT]); /* row: left node, column: right */
    subtract_lanes(block[MIDDLE_RIGHT], to_left, n, back_coupling); /* the other way round */
    subtract_lanes(block[MIDDLE_RIGHT], to_right, n, block[RIGHT_RIGHT]);
    for (int i = 0; i < size; i++) {
        strip_part(store, index, MIDDLE_INVERSE, size)[i] = inverse[i];
        strip_part(store, index, COUPLED_LEFT, size)[i] = block[LEFT_MIDDLE][i];
        strip_part(store, index, COUPLED_RIGHT, size)[i] = block[MIDDLE_RIGHT][i];
    }
    for (int k = 0; k < count; k++) {
        const bool right_half = e + k >= meeting;
        double *left = store + corner_part(c->strips, e + k, n), *right = left + 3 * room;
        double *coupled = right_half ? right : left;
        const lanes *carry = right_half ? block[LEFT_RIGHT] : back_coupling;
        const lanes *back = right_half ? back_coupling : block[LEFT_RIGHT];
        for (int i = 0; i < n; i++)
            for (int j = 0; j < n; j++) {
                const int row = n * i + j, column = wide * j + i;
                left[column] += LANE(block[LEFT_LEFT][row], k);
                right[column] = LANE(block[RIGHT_RIGHT][row], k);
                coupled[CARRY * room + column] = LANE(carry[row], k);
                coupled[BACK * room + column] = LANE(back[row], k);
            }
    }
    return true;
}

/* Eliminates a corner; `neighbour` is the inverse-to-be of the next one towards the middle. */
INLINE bool eliminate(double *corner, double *neighbour, int n)
{
    const int size = n * STRIDE(n);
    double raw[2][16];
    double *inverse = corner, *carry = corner + CARRY * size, *back = corner + BACK * size;
    if (!invert(inverse, n)) return false;
    for (int i = 0; i < size; i++) {
        raw[0][i] = carry[i];
        raw[1][i] = back[i];
    }
    multiply(inverse, raw[1], n, back);
    multiply(raw[0], inverse, n, carry);
    for (int j = 0; j < n; j++)
        subtract_apply(raw[0], back + STRIDE(n) * j, n, neighbour + STRIDE(n) * j);
    return true;
}

static void fix_rows(const bool fixed[4], double *corner, int n)
{
    for (int i = 0; i < n; i++) {
        if (!fixed[i]) continue;
        for (int j = 0; j < n; j++) {
            corner[STRIDE(n) * j + i] = i == j ? 1.0 : 0.0;
            corner[STRIDE(n) * (BACK * n + j) + i] = 0.0;
        }
    }
}

/* Adds the tangent of what acts at an end, by rows, to its corner, by columns. */
INLINE void add_end(const double tangent[16], double *corner, int n)
{
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) corner[STRIDE(n) * j + i] += tangent[4 * i + j];
}

INLINE bool factor_all(const chain *c, const exposure *now, const sections *at, const double *u,
                       tangent_weights mix, const chain_ends *ends, int n, double *store)
{
    const int elements = c->elements, meeting = elements / 2;
    const int size = n * STRIDE(n), corners = 3 * size * (elements + 1);
    double *first = store + corner_part(c->strips, 0, n);
    double *last = store + corner_part(c->strips, elements, n);
    for (int i = 0; i < corners; i++) first[i] = 0.0;
    for (int index = 0; index < c->strips; index++) {
        lanes block[6][16];
        element_strip_tangent(c, index, now, at, u, mix, block);
        if (!condense(c, index, block, n, store)) return false;
    }
    add_end(ends->tangent[0][0], first, n);
    add_end(ends->tangent[1][0], last, n);
    fix_rows(ends->fixed[0], first, n);
    fix_rows(ends->fixed[1], last, n);
    for (int k = 0; k < elements - meeting; k++) {
        double *left = first + 3 * size * k, *right = last - 3 * size * k;
        bool good = k >= meeting || eliminate(left, left + 3 * size, n);
        good = eliminate(right, right - 3 * size, n) && good;
        if (!good) return false;
    }
    return invert(first + 3 * size * meeting, n);
}

INLINE void apply_lanes(const lanes *a, const lanes *x, int n, lanes *y)
{
    for (int i = 0; i < n; i++) {
        y[i] = a[n * i] * x[0];
        for (int j = 1; j < n; j++) y[i] += a[n * i + j] * x[j];
    }
}

/* Middle nodes: their part of the solution as if the corners were at rest, taken to the corners. */
INLINE void solve_middles(const double *store, int e, int count, int n, double *rhs)
{
    const int size = n * n;
    lanes middle[4], own[4], corner[4];
    read_nodes(rhs + 8 * e, 1, count, middle);
    apply_lanes(strip_part_read(store, e / LANES, MIDDLE_INVERSE, size), middle, n, own);
    for (int side = 0; side < 2; side++) {
        apply_lanes(strip_part_read(store, e / LANES, side ? COUPLED_RIGHT : COUPLED_LEFT, size),
                    own, n, corner);
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
    apply_lanes(strip_part_read(store, e / LANES, COUPLED_LEFT, size), left, n, from_left);
    apply_lanes(strip_part_read(store, e / LANES, COUPLED_RIGHT, size), right, n, from_right);
    for (int i = 0; i < n; i++) from_left[i] += from_right[i];
    apply_lanes(strip_part_read(store, e / LANES, MIDDLE_INVERSE, size), from_left, n, change);
    for (int i = 0; i < n; i++) change[i] = -change[i];
    for (int i = n; i < 4; i++) change[i] = (lanes){0.0};
    add_to_nodes(rhs + 8 * e, 1, count, change);
}

INLINE void solve_all(const chain *c, const double *store, const bool fixed[2][4], int n,
                      double *rhs)
{
    const int elements = c->elements, meeting = elements / 2, size = n * STRIDE(n);
    const double *first = store + corner_part(c->strips, 0, n);
    double *x = rhs, *y = rhs + 8 * elements;
    const double *last = store + corner_part(c->strips, elements, n);
    for (int e = 0; e < elements; e += LANES) solve_middles(store, e, elements - e, n, rhs);
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
    for (int e = 0; e < elements; e += LANES) correct_middles(store, e, elements - e, n, rhs);
}

TWO_PATHS static bool factor_2(const chain *c, const exposure *now, const sections *at,
                               const double *u, tangent_weights mix, const chain_ends *ends,
                               double *store)
{
    return factor_all(c, now, at, u, mix, ends, 2, store);
}

TWO_PATHS static bool factor_4(const chain *c, const exposure *now, const sections *at,
                               const double *u, tangent_weights mix, const chain_ends *ends,
                               double *store)
{
    return factor_all(c, now, at, u, mix, ends, 4, store);
}

TWO_PATHS static void solve_2(const chain *c, const double *store, const chain_ends *ends,
                              double *rhs)
{
    solve_all(c, store, ends->fixed, 2, rhs);
}

TWO_PATHS static void solve_4(const chain *c, const double *store, const chain_ends *ends,
                              double *rhs)
{
    solve_all(c, store, ends->fixed, 4, rhs);
}

bool solver_chain_factor(const chain *c, const exposure *now, const sections *at, const double *u,
                         tangent_weights weights, const chain_ends *ends, double *store)
{
    return (now->unknowns == 2 ? factor_2 : factor_4)(c, now, at, u, weights, ends, store);
}

void solver_chain_solve(const chain *c, int unknowns, const double *store, const chain_ends *ends,
                        double *rhs)
{
    (unknowns == 2 ? solve_2 : solve_4)(c, store, ends, rhs);
}
