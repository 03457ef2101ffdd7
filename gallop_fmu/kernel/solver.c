/* The tangent equations of all chains and devices.
 *
 * Where no junction joins two chains or devices, each chain is solved by itself, its ends fixed or
 * held by devices.  Otherwise every chain is reduced to its two end nodes, and what remains is a
 * banded system of the junctions in their order; its band is as wide as the farthest junctions
 * that a chain or a device joins.  A real tangent has one part, a complex one two. */
#include "solver.h"

#include "device.h"
#include "junction.h"
#include "solver_band.h"

enum { REAL = 1, COMPLEX = 2 };

static int larger(int a, int b)
{
    return a > b ? a : b;
}

void solver_measure(gallop_model *model)
{
    model->coupled = model->tie_count > 0;
    for (int i = 0; i < model->chain_count; i++) {
        const chain *c = &model->chain[i];
        if (c->kept_corners > 2) model->coupled = true;
        for (int k = 1; k < c->kept_corners; k++)
            model->junction_reach =
                larger(model->junction_reach, abs(c->kept[k].junction - c->kept[k - 1].junction));
    }
    for (int i = 0; i < model->device_count; i++) {
        const device *d = &model->device[i];
        if (d->junctions > 1) model->coupled = true;
        for (int k = 1; k < d->junctions; k++)
            for (int n = 0; n < k; n++)
                model->junction_reach =
                    larger(model->junction_reach, abs(d->junction[k] - d->junction[n]));
    }
    for (int j = 0; j < model->junction_count; j++)
        if (model->junction[j].body) model->coupled = true;
    for (int i = 0; i < model->chain_count; i++) {
        chain *c = &model->chain[i];
        const int segments = model->coupled ? c->kept_corners - 1 : 1;
        c->first_factor = model->chain_factors;
        model->chain_factors += solver_room(c->elements, c->strips, segments, model->coupled);
    }
    const int rows = 4 * model->junction_count, half = 4 * model->junction_reach + 3;
    model->factor_room = model->chain_factors + (model->coupled ? solver_band_room(rows, half) : 0);
}

/* A tangent to be factored. */
typedef struct {
    const gallop_model *model;
    const conditions *now;
    const state_view *view;
    motion y;
    const tangent_weights *weights; /* (parts) */
    int parts;
} system_tangent;

static double *store_of(const gallop_model *model, const state_view *view, int index, int parts)
{
    const size_t first = (size_t)parts * model->chain[index].first_factor;
    return (parts == REAL ? view->factors : view->complex_factors) + first;
}

/* Where the tangent of a chain is taken. */
typedef struct {
    const system_tangent *tangent;
    const chain *chain;
} chain_motion;

/* The blocks of a strip of a chain, which lies in one of its intervals. */
static void blocks_of(const void *source, int index, tangent_weights weights, lanes block[6][16])
{
    const chain_motion *m = source;
    const system_tangent *t = m->tangent;
    const interval *of = &t->model->interval[m->chain->first_interval];
    const int place = m->chain->first_strip + index;
    while (place >= of->first_strip + of->strips) of++;
    const exposure now = conditions_on(t->model, t->now, of);
    element_strip_tangent(of, place - of->first_strip, &now, &t->view->sections,
                          t->y.u + 4 * of->first_node, weights, block);
}

static solver_chain solver_chain_of(const gallop_model *model, const chain *c)
{
    return (solver_chain){.elements = c->elements,
                          .unknowns = model->unknowns,
                          .strips = c->strips,
                          .strip_start = c->strip_start,
                          .blocks = blocks_of};
}

/* ---- Chains by themselves. ---- */

/* Which unknowns of the ends of a chain are prescribed. */
static void find_fixed(const gallop_model *model, const chain *c, solver_junctions junctions,
                       chain_ends *ends)
{
    for (int end = 0; end < 2; end++)
        for (int i = 0; i < 4; i++)
            ends->fixed[end][i] =
                junctions == SOLVER_JUNCTIONS_FIXED || model->junction[c->junction[end]].fixed[i];
}

/* Adds the tangents of the devices at the ends of a chain. */
static void add_devices(const system_tangent *t, const chain *c, chain_ends *ends)
{
    for (int i = 0; i < t->model->device_count; i++) {
        const device *d = &t->model->device[i];
        for (int end = 0; end < 2; end++) {
            if (d->junction[0] != c->junction[end]) continue;
            for (int part = 0; part < t->parts; part++) {
                device_block tangent[GALLOP_DEVICE_JUNCTIONS * GALLOP_DEVICE_JUNCTIONS];
                device_tangent(t->model, d, t->now, t->y, t->weights[part], tangent);
                for (int k = 0; k < 16; k++) ends->tangent[end][part][k] += tangent[0][k];
            }
        }
    }
}

static bool factor_alone(const system_tangent *t, solver_junctions junctions)
{
    for (int i = 0; i < t->model->chain_count; i++) {
        const chain *c = &t->model->chain[i];
        const chain_motion here = {t, c};
        chain_ends ends = {.tangent = {{{0.0}}}};
        solver_chain alone = solver_chain_of(t->model, c);
        double *store = store_of(t->model, t->view, i, t->parts);
        alone.ends = &ends;
        alone.source = &here;
        find_fixed(t->model, c, junctions, &ends);
        if (junctions == SOLVER_JUNCTIONS_AS_IN_SCENE) add_devices(t, c, &ends);
        const bool good = t->parts == REAL ? solver_real_factor(&alone, t->weights, store)
                                           : solver_complex_factor(&alone, t->weights, store);
        if (!good) return false;
    }
    return true;
}

static void solve_alone(const gallop_model *model, const state_view *view,
                        solver_junctions junctions, int parts, double *rhs)
{
    for (int i = 0; i < model->chain_count; i++) {
        const chain *c = &model->chain[i];
        const double *store = store_of(model, view, i, parts);
        double *of_chain = rhs + 4 * parts * c->first_node;
        chain_ends ends;
        solver_chain alone = solver_chain_of(model, c);
        alone.ends = &ends;
        find_fixed(model, c, junctions, &ends);
        if (parts == REAL)
            solver_real_solve(&alone, store, of_chain);
        else
            solver_complex_solve(&alone, store, of_chain);
    }
}

/* ---- Chains that junctions couple. ---- */

/* The matrix of the junctions lies behind the factors of the chains. */
static band junctions_in(const gallop_model *model, const state_view *view, int parts)
{
    double *store = parts == REAL ? view->factors : view->complex_factors;
    double *matrix = store + (size_t)parts * model->chain_factors;
    const int rows = 4 * model->junction_count, half = 4 * model->junction_reach + 3;
    return (band){rows, half, matrix, parts == REAL ? NULL : matrix + solver_band_room(rows, half)};
}

/* Adds a block of four rows and columns, by rows, to that of two junctions. */
static void add_block(const band *m, int row, int column, const double *block, double *matrix)
{
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            matrix[solver_band_place(m, 4 * row + i, 4 * column + j)] += block[4 * i + j];
}

static solver_chain reduced_chain_of(const gallop_model *model, const chain *c)
{
    solver_chain reduced = solver_chain_of(model, c);
    reduced.kept_corners = c->kept_corners;
    reduced.kept = c->kept;
    return reduced;
}

/* What a chain has between two kept corners, the second one being number `index`. */
static void add_segment(const system_tangent *t, const band *m, const chain *c,
                        const solver_chain *reduced, const double *store, int index)
{
    const kept_corner *at = &c->kept[index - 1];
    double ends[2][2][2][4][4];
    if (t->parts == REAL)
        solver_real_ends(reduced, store, index - 1, ends);
    else
        solver_complex_ends(reduced, store, index - 1, ends);
    for (int part = 0; part < t->parts; part++)
        for (int k = 0; k < 4; k++)
            add_block(m, at[k / 2].junction, at[k % 2].junction, ends[part][k / 2][k % 2][0],
                      part ? m->im : m->re);
}

static bool add_chains(const system_tangent *t, const band *m)
{
    for (int i = 0; i < t->model->chain_count; i++) {
        const chain *c = &t->model->chain[i];
        const chain_motion here = {t, c};
        solver_chain reduced = reduced_chain_of(t->model, c);
        double *store = store_of(t->model, t->view, i, t->parts);
        reduced.source = &here;
        const bool good = t->parts == REAL ? solver_real_reduce(&reduced, t->weights, store)
                                           : solver_complex_reduce(&reduced, t->weights, store);
        if (!good) return false;
        for (int k = 1; k < c->kept_corners; k++) add_segment(t, m, c, &reduced, store, k);
    }
    return true;
}

static void add_coupling_devices(const system_tangent *t, const band *m)
{
    for (int i = 0; i < t->model->device_count; i++) {
        const device *d = &t->model->device[i];
        const int count = d->junctions;
        for (int part = 0; part < t->parts; part++) {
            device_block tangent[GALLOP_DEVICE_JUNCTIONS * GALLOP_DEVICE_JUNCTIONS];
            device_tangent(t->model, d, t->now, t->y, t->weights[part], tangent);
            for (int k = 0; k < count * count; k++)
                add_block(m, d->junction[k / count], d->junction[k % count], tangent[k],
                          part ? m->im : m->re);
        }
    }
}

/* Rows of prescribed unknowns, and of those that the scene does not need, say that they are zero.
 */
static void fix_rows(const gallop_model *model, const band *m)
{
    for (int row = 0; row < m->rows; row++) {
        if (!model->junction[row / 4].fixed[row % 4] && row % 4 < model->unknowns) continue;
        for (int k = 0; k < 2 * m->half + 1; k++) {
            const size_t place = (size_t)row * (2 * (size_t)m->half + 1) + (size_t)k;
            m->re[place] = k == m->half ? 1.0 : 0.0;
            if (m->im) m->im[place] = 0.0;
        }
    }
}

/* The number that turns k, c and m of complex weights (k real) to either side of the real axis. */
static void half_turn(const system_tangent *t, double turn[2])
{
    const double angle = t->parts == REAL ? 0.0 : -0.5 * atan2(t->weights[1].m, t->weights[0].m);
    turn[0] = cos(angle);
    turn[1] = sin(angle);
}

static bool factor_coupled(const system_tangent *t)
{
    const band m = junctions_in(t->model, t->view, t->parts);
    double turn[2];
    memset(m.re, 0, (size_t)t->parts * solver_band_room(m.rows, m.half) * sizeof(double));
    if (!add_chains(t, &m)) return false;
    add_coupling_devices(t, &m);
    fix_rows(t->model, &m);
    half_turn(t, turn);
    return solver_band_factor(&m, turn);
}

/* The right-hand sides of the junctions, which are at their leading nodes, become solutions. */
static void solve_junctions(const gallop_model *model, const state_view *view, int parts,
                            double *rhs)
{
    const band m = junctions_in(model, view, parts);
    double *re = view->junction_rhs, *im = parts == REAL ? NULL : re + m.rows;
    for (int row = 0; row < m.rows; row++) {
        const junction *j = &model->junction[row / 4];
        const double *node = rhs + 4 * parts * j->node + row % 4;
        const bool moves = !j->fixed[row % 4] && row % 4 < model->unknowns;
        re[row] = moves ? node[0] : 0.0;
        if (im) im[row] = moves ? node[4] : 0.0;
    }
    solver_band_solve(&m, re, im);
    for (int row = 0; row < m.rows; row++) {
        double *node = rhs + 4 * parts * model->junction[row / 4].node + row % 4;
        node[0] = re[row];
        if (im) node[4] = im[row];
    }
}

static void solve_coupled(const gallop_model *model, const state_view *view, int parts, double *rhs)
{
    for (int i = 0; i < model->chain_count; i++) {
        const chain *c = &model->chain[i];
        const solver_chain kept = reduced_chain_of(model, c);
        const double *store = store_of(model, view, i, parts);
        (parts == REAL ? solver_real_to_ends
                       : solver_complex_to_ends)(&kept, store, rhs + 4 * parts * c->first_node);
    }
    junction_gather(model, rhs, 4 * parts);
    solve_junctions(model, view, parts, rhs);
    junction_spread(model, rhs, 4 * parts);
    for (int i = 0; i < model->chain_count; i++) {
        const chain *c = &model->chain[i];
        const solver_chain kept = reduced_chain_of(model, c);
        const double *store = store_of(model, view, i, parts);
        (parts == REAL ? solver_real_from_ends
                       : solver_complex_from_ends)(&kept, store, rhs + 4 * parts * c->first_node);
    }
}

/* ---- All of it. ---- */

static bool is_coupled(const gallop_model *model, solver_junctions junctions)
{
    return model->coupled && junctions == SOLVER_JUNCTIONS_AS_IN_SCENE;
}

bool solver_factor(const gallop_model *model, const conditions *now, const state_view *view,
                   motion y, tangent_weights weights, solver_junctions junctions)
{
    const system_tangent t = {model, now, view, y, &weights, REAL};
    return is_coupled(model, junctions) ? factor_coupled(&t) : factor_alone(&t, junctions);
}

void solver_solve(const gallop_model *model, const state_view *view, solver_junctions junctions,
                  double *rhs)
{
    if (is_coupled(model, junctions))
        solve_coupled(model, view, REAL, rhs);
    else
        solve_alone(model, view, junctions, REAL, rhs);
}

bool solver_factor_complex(const gallop_model *model, const conditions *now, const state_view *view,
                           motion y, const tangent_weights weights[2])
{
    const system_tangent t = {model, now, view, y, weights, COMPLEX};
    return is_coupled(model, SOLVER_JUNCTIONS_AS_IN_SCENE)
             ? factor_coupled(&t)
             : factor_alone(&t, SOLVER_JUNCTIONS_AS_IN_SCENE);
}

void solver_solve_complex(const gallop_model *model, const state_view *view, double *rhs)
{
    if (is_coupled(model, SOLVER_JUNCTIONS_AS_IN_SCENE))
        solve_coupled(model, view, COMPLEX, rhs);
    else
        solve_alone(model, view, SOLVER_JUNCTIONS_AS_IN_SCENE, COMPLEX, rhs);
}
