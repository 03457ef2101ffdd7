/* Direct solver of a chain of elements: one text for real and complex tangents.  The file that
 * includes it defines before
 *     PARTS        parts of a number: 1 if they are real, 2 if they are complex
 *     ENTRY(name)  name of an entry, as solver.h declares it
 *
 * First the middle nodes of the elements are eliminated, LANES elements at a time.  What remains is
 * block tridiagonal in the corners, and is eliminated from both ends towards the corner where they
 * meet, by two recursions that do not wait for each other:
 *
 *     right-hand side:  inwards                       solution:  outwards
 *
 *        carry    carry        carry    carry          back     back         back     back
 *      0 -----> 1 -----> ... m ... <----- e-1 <----- e      the same corners, arrows reversed
 *      |<----- left half ----->|<---- right half ---->|
 *
 * A_kk is the block of corner k, n its neighbour towards m = e / 2, A_nk that of the row of n and
 * the column of k.  The elimination of corner k leaves
 *     inverse = A_kk^-1,   carry = A_nk A_kk^-1,   back = A_kk^-1 A_kn,   A_nn less A_nk back;
 * then  b_n -= carry b_k  takes a right-hand side inwards, and  x_k = inverse b_k - back x_n  the
 * solution outwards.  Work and memory grow linearly with the number of elements.
 *
 * There is no row exchange: the blocks are dominated by their symmetric positive part.  A complex
 * tangent blends k, c and m with numbers that lie within a right angle of each other, so it is
 * dominated by such a part once it is turned by half of that angle. */
#include "solver.h"
#include "solver_numbers.h"

/* A corner; before its elimination the parts are A_kk, A_nk and A_kn. */
typedef struct {
    block inverse, carry, back;
} corner;

/* The middle nodes of a strip: n x n numbers by rows; the couplings with the left and the right
 * nodes, whose blocks of row and column are equal. */
typedef struct {
    strip_number inverse[16], left[16], right[16];
} strip_factor;

/* Elements between two kept corners of a chain, or all of them if none is kept. */
typedef struct {
    int first, elements, meeting; /* meeting: the corner of the segment where two recursions meet */
    corner *corner;     /* (elements + 1); that of a kept one has what its own side adds */
    block (*by_end)[2]; /* (elements + 1) if corners are kept: see reduce */
} segment;

/* A chain's factors in their store. */
typedef struct {
    int elements, strips, segments, unknowns;
    bool fused;
    const int *strip_start;
    const kept_corner *kept; /* NULL: none */
    rotation turn;           /* of a complex tangent */
    strip_factor *strip;     /* (strips) */
    corner *corner;          /* (elements + segments) */
    block (*by_end)[2];      /* (elements + segments) if corners are kept */
} factors;

INLINE factors factors_in(const double *store, const solver_chain *c)
{
    factors f = {.elements = c->elements,
                 .strips = c->strips,
                 .segments = c->kept ? c->kept_corners - 1 : 1,
                 .unknowns = c->unknowns,
                 .fused = c->fused,
                 .strip_start = c->strip_start,
                 .kept = c->kept,
                 .turn = {1.0, 0.0}};
    f.strip = (strip_factor *)store;
    f.corner = (corner *)(f.strip + f.strips);
    f.by_end = (block(*)[2])(f.corner + f.elements + f.segments);
    return f;
}

INLINE segment segment_of(const factors *f, int index)
{
    segment s = {.first = 0, .elements = f->elements};
    if (f->kept) {
        s.first = f->kept[index].corner;
        s.elements = f->kept[index + 1].corner - s.first;
    }
    s.meeting = s.elements / 2;
    s.corner = f->corner + s.first + index;
    s.by_end = f->by_end + s.first + index;
    return s;
}

/* ---- Stages of a factorisation. ---- */

/* Eliminate the middle nodes of a strip, and place what is left at its corners. */
INLINE bool condense(const factors *f, int index, strip_number tangent[6][16], int n,
                     int *segment_index)
{
    strip_factor *s = &f->strip[index];
    segment of = segment_of(f, *segment_index);
    strip_number *inverse = tangent[MIDDLE_MIDDLE], to_left[16], to_right[16], right_left[16];
    if (!invert_strip(inverse, n, &f->turn)) return false;
    for (int i = 0; i < n * n; i++) {
        s->inverse[i] = inverse[i];
        s->left[i] = tangent[LEFT_MIDDLE][i];
        s->right[i] = tangent[MIDDLE_RIGHT][i];
        right_left[i] = tangent[LEFT_RIGHT][i];
    }
    multiply_strip(inverse, tangent[LEFT_MIDDLE], n, to_left);
    multiply_strip(inverse, tangent[MIDDLE_RIGHT], n, to_right);
    subtract_strip(tangent[LEFT_MIDDLE], to_left, n, tangent[LEFT_LEFT]);
    subtract_strip(tangent[LEFT_MIDDLE], to_right, n, tangent[LEFT_RIGHT]);
    subtract_strip(tangent[MIDDLE_RIGHT], to_left, n, right_left);
    subtract_strip(tangent[MIDDLE_RIGHT], to_right, n, tangent[RIGHT_RIGHT]);

    /* An element's coupling belongs to that of its corners which is eliminated first. */
    const int e = f->strip_start[index], count = f->strip_start[index + 1] - e;
    for (int k = 0; k < count; k++) {
        if (e + k == of.first + of.elements) of = segment_of(f, ++*segment_index);
        const bool right_half = e + k - of.first >= of.meeting;
        corner *left = &of.corner[e + k - of.first], *right = left + 1,
               *coupled = right_half ? right : left;
        const strip_number *carry = right_half ? tangent[LEFT_RIGHT] : right_left;
        const strip_number *back = right_half ? right_left : tangent[LEFT_RIGHT];
        ROLLED
        for (int j = 0; j < n; j++)
            for (int i = 0; i < n; i++)
                for (int p = 0; p < PARTS; p++) {
                    const int entry = n * i + j;
                    left->inverse.value[j][p][i] += LANE(tangent[LEFT_LEFT][entry].part[p], k);
                    right->inverse.value[j][p][i] = LANE(tangent[RIGHT_RIGHT][entry].part[p], k);
                    coupled->carry.value[j][p][i] = LANE(carry[entry].part[p], k);
                    coupled->back.value[j][p][i] = LANE(back[entry].part[p], k);
                }
    }
    return true;
}

/* Take the tangent of all strips, and eliminate their middle nodes. */
INLINE bool condense_strips(const factors *f, const solver_chain *c, const tangent_weights *weights,
                            int n)
{
    int segment_index = 0;
    memset(f->corner, 0, (size_t)(f->elements + f->segments) * sizeof *f->corner);
    for (int index = 0; index < f->strips; index++) {
        strip_number blocks[6][16];
        for (int p = 0; p < PARTS; p++) {
            lanes part[6][16];
            c->blocks(c->source, index, weights[p], part);
            for (int b = 0; b < 6; b++)
                for (int i = 0; i < n * n; i++) blocks[b][i].part[p] = part[b][i];
        }
        if (!condense(f, index, blocks, n, &segment_index)) return false;
    }
    return true;
}

/* Eliminate a corner; A_nn of its neighbour lies in `neighbour`. */
INLINE bool eliminate(corner *k, block *neighbour, int n, const factors *f)
{
    const block carry = k->carry, back = k->back;
    if (!invert(&k->inverse, n, &f->turn)) return false;
    for (int j = 0; j < n; j++) {
        apply(&k->inverse, back.value[j][0], n, k->back.value[j][0]);
        apply(&carry, k->inverse.value[j][0], n, k->carry.value[j][0]);
    }
    for (int j = 0; j < n; j++)
        subtract_apply(&carry, k->back.value[j][0], n, neighbour->value[j][0]);
    return true;
}

/* Eliminate the corners of a segment, but for `kept` ones at each end. */
INLINE bool eliminate_segment(const factors *f, const segment *s, int kept, int n)
{
    const int last = s->elements, meeting = s->meeting;
    for (int k = kept; k < last - meeting; k++) {
        corner *left = &s->corner[k], *right = &s->corner[last - k];
        bool good = k >= meeting || eliminate(left, &left[1].inverse, n, f);
        good = eliminate(right, &right[-1].inverse, n, f) && good;
        if (!good) return false;
    }
    return invert(&s->corner[meeting].inverse, n, &f->turn);
}

INLINE bool eliminate_corners(const factors *f, int n)
{
    for (int i = 0; i < f->segments; i++) {
        const segment s = segment_of(f, i);
        const int kept = f->kept ? 1 : 0;
        if (s.elements <= kept) continue; /* no corner lies between */
        if (!eliminate_segment(f, &s, kept, n)) return false;
    }
    return true;
}

/* ---- Stages of a solution. ---- */

/* Middle nodes: their solution as if the corners were at rest; what it does to the corners. */
INLINE void solve_middles(const factors *f, double *rhs, int n)
{
    for (int index = 0; index < f->strips; index++) {
        const strip_factor *s = &f->strip[index];
        const int e = f->strip_start[index], count = f->strip_start[index + 1] - e;
        double *y = rhs + (size_t)8 * PARTS * e;
        strip_number middle[4], own[4], force[4];
        read_strip(y, 1, count, middle);
        apply_strip(s->inverse, middle, n, own);
        for (int side = 0; side < 2; side++) {
            apply_strip(side ? s->right : s->left, own, n, force);
            negate(force, n);
            write_strip(y, 2 * side, count, force, n, true);
        }
        write_strip(y, 1, count, own, n, false);
    }
}

/* Middle nodes: add what the motion of their corners does to them. */
INLINE void correct_middles(const factors *f, double *rhs, int n)
{
    for (int index = 0; index < f->strips; index++) {
        const strip_factor *s = &f->strip[index];
        const int e = f->strip_start[index], count = f->strip_start[index + 1] - e;
        double *y = rhs + (size_t)8 * PARTS * e;
        strip_number left[4], right[4], by_left[4], by_right[4], change[4];
        read_strip(y, 0, count, left);
        read_strip(y, 2, count, right);
        apply_strip(s->left, left, n, by_left);
        apply_strip(s->right, right, n, by_right);
        for (int i = 0; i < n; i++)
            for (int p = 0; p < PARTS; p++) by_left[i].part[p] += by_right[i].part[p];
        apply_strip(s->inverse, by_left, n, change);
        negate(change, n);
        write_strip(y, 1, count, change, n, true);
    }
}

/* One column for each corner of a segment, `step` values apart: the solution of the corners as if
 * the `kept` ones at each end were at rest; then what that does to those. */
INLINE void solve_segment(const segment *s, int kept, double *first, int step, int n)
{
    const int last = s->elements, meeting = s->meeting;
    const corner *at = s->corner;
    double *const end = first + (size_t)step * last, *x = first + step * kept,
                  *y = end - step * kept;
    for (int k = kept; k < last - meeting; k++, x += step, y -= step) {
        if (k < meeting) subtract_apply(&at[k].carry, x, n, x + step);
        subtract_apply(&at[last - k].carry, y, n, y - step);
    }
    transform(&at[meeting].inverse, n, y);
    for (int k = last - meeting - 1; k >= kept; k--) {
        x = first + (size_t)step * k;
        y = end - (size_t)step * k;
        if (k < meeting) {
            transform(&at[k].inverse, n, x);
            subtract_apply(&at[k].back, x + step, n, x);
        }
        transform(&at[last - k].inverse, n, y);
        subtract_apply(&at[last - k].back, y - step, n, y);
    }
    if (!kept) return;
    subtract_apply(&at[0].back, first + step, n, first);
    subtract_apply(&at[last].back, end - step, n, end);
}

INLINE void solve_corners(const factors *f, double *rhs, int n)
{
    for (int i = 0; i < f->segments; i++) {
        const segment s = segment_of(f, i);
        const int kept = f->kept ? 1 : 0;
        if (s.elements <= kept) continue;
        solve_segment(&s, kept, rhs + (size_t)8 * PARTS * s.first, 8 * PARTS, n);
    }
}

/* Corners between kept ones: add what the motion of the kept ones does to them. */
INLINE void correct_corners(const factors *f, double *rhs, int n)
{
    for (int index = 0; index < f->segments; index++) {
        const segment s = segment_of(f, index);
        double end[2][4 * PARTS], *const first = rhs + (size_t)8 * PARTS * s.first;
        memcpy(end[0], first, sizeof end[0]); /* copies, which stay in registers */
        memcpy(end[1], first + (size_t)8 * PARTS * s.elements, sizeof end[1]);
        for (int k = 1; k < s.elements; k++) {
            double change[2][PARTS][4], *x = first + (size_t)8 * PARTS * k;
            for (int side = 0; side < 2; side++)
                apply(&s.by_end[k][side], end[side], n, change[side][0]);
            for (int p = 0; p < PARTS; p++)
                for (int i = 0; i < n; i += LANES)
                    LANES_AT(x + 4 * p + i) = LANES_AT(x + 4 * p + i) - LANES_AT(change[0][p] + i) -
                                              LANES_AT(change[1][p] + i);
        }
    }
}

/* The columns of the tangent that belong to the two kept corners of a segment are right-hand sides
 * to what lies between.  They become, at a kept corner, its share in the system of those, and at a
 * corner between, what the motion of the kept ones takes from its solution with those at rest. */
INLINE void reduce_segment(const segment *s, int n)
{
    const int last = s->elements, at[2] = {0, last}, next[2] = {1, last - 1};
    for (int end = 0; end < 2; end++) /* not eliminated: the corners still have A_kk, A_nk, A_kn */
        s->by_end[at[end]][end] = s->corner[at[end]].inverse;
    if (last == 1) { /* the coupling of a single element belongs to its right corner */
        s->by_end[0][1] = s->corner[1].carry;
        s->by_end[1][0] = s->corner[1].back;
        return;
    }
    for (int end = 0; end < 2; end++) {
        s->by_end[next[end]][end] = s->corner[at[end]].carry;
        for (int j = 0; j < n; j++)
            solve_segment(s, 1, s->by_end[0][end].value[j][0], 32 * PARTS, n);
    }
}

INLINE void reduce_segments(const factors *f, int n)
{
    memset(f->by_end, 0, (size_t)(f->elements + f->segments) * sizeof *f->by_end);
    for (int i = 0; i < f->segments; i++) {
        const segment s = segment_of(f, i);
        reduce_segment(&s, n);
    }
}

/* ---- The stages for two unknowns and for four, compiled for both paths. ---- */

INLINE bool run_condense_strips(const factors *f, const solver_chain *c,
                                const tangent_weights *weights)
{
    return f->unknowns == 2 ? condense_strips(f, c, weights, 2) : condense_strips(f, c, weights, 4);
}
VALUE_PATHS(bool, run_condense_strips,
            (const factors *f, const solver_chain *c, const tangent_weights *weights),
            (f, c, weights))

INLINE bool run_eliminate_corners(const factors *f)
{
    return f->unknowns == 2 ? eliminate_corners(f, 2) : eliminate_corners(f, 4);
}
VALUE_PATHS(bool, run_eliminate_corners, (const factors *f), (f))

INLINE void run_reduce_segments(const factors *f)
{
    f->unknowns == 2 ? reduce_segments(f, 2) : reduce_segments(f, 4);
}
PATHS(run_reduce_segments, (const factors *f), (f))

INLINE void run_solve_middles(const factors *f, double *rhs)
{
    f->unknowns == 2 ? solve_middles(f, rhs, 2) : solve_middles(f, rhs, 4);
}
PATHS(run_solve_middles, (const factors *f, double *rhs), (f, rhs))

INLINE void run_solve_corners(const factors *f, double *rhs)
{
    f->unknowns == 2 ? solve_corners(f, rhs, 2) : solve_corners(f, rhs, 4);
}
PATHS(run_solve_corners, (const factors *f, double *rhs), (f, rhs))

INLINE void run_correct_corners(const factors *f, double *rhs)
{
    f->unknowns == 2 ? correct_corners(f, rhs, 2) : correct_corners(f, rhs, 4);
}
PATHS(run_correct_corners, (const factors *f, double *rhs), (f, rhs))

INLINE void run_correct_middles(const factors *f, double *rhs)
{
    f->unknowns == 2 ? correct_middles(f, rhs, 2) : correct_middles(f, rhs, 4);
}
PATHS(run_correct_middles, (const factors *f, double *rhs), (f, rhs))

/* ---- Entries. ---- */

/* Half of the angle between k, which is real, and m, which is farthest off. */
static rotation turn_of(const tangent_weights *weights)
{
#if PARTS == 2
    const double half = -0.5 * atan2(weights[1].m, weights[0].m);
    return (rotation){cos(half), sin(half)};
#else
    (void)weights;
    return (rotation){1.0, 0.0};
#endif
}

/* Take the tangent, with the middle nodes eliminated. */
static bool take_tangent(factors *f, const solver_chain *c, const tangent_weights *weights)
{
    f->turn = turn_of(weights);
    return ON_PATH(f->fused, run_condense_strips)(f, c, weights);
}

/* Add the tangent of what acts at an end; the row of a fixed unknown says that it is zero. */
static void close_end(const chain_ends *ends, int end, corner *at, int n)
{
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            for (int p = 0; p < PARTS; p++) {
                double *entry = &at->inverse.value[j][p][i];
                *entry += ends->tangent[end][p][4 * i + j];
                if (!ends->fixed[end][i]) continue;
                *entry = i == j && p == 0 ? 1.0 : 0.0;
                at->back.value[j][p][i] = 0.0;
            }
}

bool ENTRY(factor)(const solver_chain *c, const tangent_weights *weights, double *store)
{
    factors f = factors_in(store, c);
    if (!take_tangent(&f, c, weights)) return false;
    close_end(c->ends, 0, &f.corner[0], f.unknowns);
    close_end(c->ends, 1, &f.corner[f.elements], f.unknowns);
    return ON_PATH(f.fused, run_eliminate_corners)(&f);
}

void ENTRY(solve)(const solver_chain *c, const double *store, double *rhs)
{
    const factors f = factors_in(store, c);
    double *const node[2] = {rhs, rhs + (size_t)8 * PARTS * f.elements};
    ON_PATH(f.fused, run_solve_middles)(&f, rhs);
    for (int end = 0; end < 2; end++)
        for (int i = 0; i < 4; i++)
            for (int p = 0; p < PARTS && c->ends->fixed[end][i]; p++) node[end][4 * p + i] = 0.0;
    ON_PATH(f.fused, run_solve_corners)(&f, rhs);
    ON_PATH(f.fused, run_correct_middles)(&f, rhs);
}

bool ENTRY(reduce)(const solver_chain *c, const tangent_weights *weights, double *store)
{
    factors f = factors_in(store, c);
    if (!take_tangent(&f, c, weights) || !ON_PATH(f.fused, run_eliminate_corners)(&f)) return false;
    ON_PATH(f.fused, run_reduce_segments)(&f);
    return true;
}

void ENTRY(ends)(const solver_chain *c, const double *store, int index,
                 double ends[PARTS][2][2][4][4])
{
    const factors f = factors_in(store, c);
    const segment s = segment_of(&f, index);
    const int at[2] = {0, s.elements}, n = f.unknowns;
    memset(ends, 0, PARTS * sizeof *ends);
    for (int k = 0; k < 4 * PARTS; k++)
        for (int i = 0; i < n; i++)
            for (int j = 0; j < n; j++) {
                const int row = k % 2, column = k / 2 % 2, p = k / 4;
                ends[p][row][column][i][j] = s.by_end[at[row]][column].value[j][p][i];
            }
}

void ENTRY(to_ends)(const solver_chain *c, const double *store, double *rhs)
{
    const factors f = factors_in(store, c);
    ON_PATH(f.fused, run_solve_middles)(&f, rhs);
    ON_PATH(f.fused, run_solve_corners)(&f, rhs);
}

void ENTRY(from_ends)(const solver_chain *c, const double *store, double *rhs)
{
    const factors f = factors_in(store, c);
    ON_PATH(f.fused, run_correct_corners)(&f, rhs);
    ON_PATH(f.fused, run_correct_middles)(&f, rhs);
}
