/* Direct solver of the system of the junctions that couple chains and devices: one text for real
 * and complex tangents, after solver_block.h in the file that includes it.
 *
 * The matrix has a block for each pair of junctions no farther apart than `reach` in their order;
 * the block of row i and column j is at [i (2 reach + 1) + j - i + reach].  Factors take its place:
 * L below the diagonal, the inverses of the pivots on it, U above.  There is no exchange of rows:
 * see solver_block.h.  Work and memory grow linearly with the number of junctions. */

INLINE block *junction_block(const solver_junction_system *s, int row, int column)
{
    block *const first = (block *)s->store;
    return first + (size_t)row * (size_t)(2 * s->reach + 1) + (column - row + s->reach);
}

/* The last junction that junction k is coupled to, at most. */
INLINE int last_coupled(const solver_junction_system *s, int k)
{
    return k + s->reach < s->count ? k + s->reach : s->count - 1;
}

INLINE bool is_zero(const block *b, int n)
{
    for (int j = 0; j < n; j++)
        for (int p = 0; p < PARTS; p++)
            for (int i = 0; i < n; i++)
                if (b->value[j][p][i] != 0.0) return false;
    return true;
}

/* Subtracts L_ik U_kj from the blocks of row i. */
INLINE void eliminate_row(const solver_junction_system *s, int k, int i, int n)
{
    block *const lower = junction_block(s, i, k), own = *lower;
    if (is_zero(&own, n)) return;
    for (int j = 0; j < n; j++)
        apply(&own, junction_block(s, k, k)->value[j][0], n, lower->value[j][0]);
    for (int j = k + 1; j <= last_coupled(s, k); j++) {
        const block *upper = junction_block(s, k, j);
        block *to = junction_block(s, i, j);
        for (int c = 0; c < n; c++) subtract_apply(lower, upper->value[c][0], n, to->value[c][0]);
    }
}

INLINE bool factor_junctions(const solver_junction_system *s, const rotation *turn, int n)
{
    for (int k = 0; k < s->count; k++) {
        if (!invert(junction_block(s, k, k), n, turn)) return false;
        for (int i = k + 1; i <= last_coupled(s, k); i++) eliminate_row(s, k, i, n);
    }
    return true;
}

/* x (junctions) are right-hand sides, arranged as those of nodes. */
INLINE void solve_junctions(const solver_junction_system *s, double *x, int n)
{
    for (int k = 0; k < s->count; k++)
        for (int i = k + 1; i <= last_coupled(s, k); i++)
            subtract_apply(junction_block(s, i, k), x + 4 * PARTS * k, n, x + 4 * PARTS * i);
    for (int k = s->count - 1; k >= 0; k--) {
        const int first = k > s->reach ? k - s->reach : 0;
        transform(junction_block(s, k, k), n, x + 4 * PARTS * k);
        for (int i = first; i < k; i++)
            subtract_apply(junction_block(s, i, k), x + 4 * PARTS * k, n, x + 4 * PARTS * i);
    }
}

INLINE bool run_factor_junctions(const solver_junction_system *s, rotation turn)
{
    return s->unknowns == 2 ? factor_junctions(s, &turn, 2) : factor_junctions(s, &turn, 4);
}
VALUE_PATHS(bool, run_factor_junctions, (const solver_junction_system *s, rotation turn), (s, turn))

INLINE void run_solve_junctions(const solver_junction_system *s, double *x)
{
    s->unknowns == 2 ? solve_junctions(s, x, 2) : solve_junctions(s, x, 4);
}
PATHS(run_solve_junctions, (const solver_junction_system *s, double *x), (s, x))

void ENTRY(junctions_clear)(const solver_junction_system *s)
{
    memset(s->store, 0, PARTS * solver_junction_room(s->count, s->reach) * sizeof(double));
}

void ENTRY(junctions_add)(const solver_junction_system *s, int row, int column, int part,
                          const double values[16])
{
    block *to = junction_block(s, row, column);
    for (int i = 0; i < s->unknowns; i++)
        for (int j = 0; j < s->unknowns; j++) to->value[j][part][i] += values[4 * i + j];
}

void ENTRY(junctions_fix)(const solver_junction_system *s, int row, int unknown)
{
    const int first = row > s->reach ? row - s->reach : 0;
    for (int column = first; column <= last_coupled(s, row); column++)
        for (int j = 0; j < s->unknowns; j++)
            for (int p = 0; p < PARTS; p++)
                junction_block(s, row, column)->value[j][p][unknown] =
                    column == row && j == unknown && p == 0 ? 1.0 : 0.0;
}

bool ENTRY(junctions_factor)(const solver_junction_system *s, const tangent_weights *weights)
{
    return ON_PATH(s->fused, run_factor_junctions)(s, turn_of(weights));
}

void ENTRY(junctions_solve)(const solver_junction_system *s, double *x)
{
    ON_PATH(s->fused, run_solve_junctions)(s, x);
}
