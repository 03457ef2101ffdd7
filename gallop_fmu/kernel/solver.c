/* The tangent equations of all chains and devices.
 *
 * Where no junction joins two chains or devices, each chain is solved by itself, its ends fixed or
 * held by devices.  Otherwise every chain is reduced to its corners at which junctions lie, and
 * what remains is a banded system of the junctions in their order; its band is as wide as the
 * farthest junctions that a chain or a device joins.  A real tangent has one part, a complex one
 * two. */
#include "solver.h"

#include "device.h"
#include "junction.h"

enum { REAL = SOLVER_REAL, COMPLEX = SOLVER_COMPLEX };

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
    model->factor_room = model->chain_factors;
    if (model->coupled)
        model->factor_room += solver_junction_room(model->junction_count, model->junction_reach);
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
                          .fused = model->fused,
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

/* Equations at work, half by half. */
typedef struct {
    const gallop_model *model;
    const state_view *view;
    solver_junctions junctions;
    const solver_equations *equations;
    int count;
    const solver_frame *frame;
    bool good[2]; /* the tangents of the half could be factored */
} solution;

static bool factor_one_alone(const system_tangent *t, int index, solver_junctions junctions)
{
    const chain *c = &t->model->chain[index];
    const chain_motion here = {t, c};
    chain_ends ends = {.tangent = {{{0.0}}}};
    solver_chain alone = solver_chain_of(t->model, c);
    double *store = store_of(t->model, t->view, index, t->parts);
    alone.ends = &ends;
    alone.source = &here;
    find_fixed(t->model, c, junctions, &ends);
    if (junctions == SOLVER_JUNCTIONS_AS_IN_SCENE) add_devices(t, c, &ends);
    return t->parts == REAL ? solver_real_factor(&alone, t->weights, store)
                            : solver_complex_factor(&alone, t->weights, store);
}

static bool factor_half_alone(const system_tangent *t, int half, solver_junctions junctions)
{
    const int *range = t->model->half[half].chain;
    for (int i = range[0]; i < range[1]; i++)
        if (!factor_one_alone(t, i, junctions)) return false;
    return true;
}

static void solve_half_alone(const solution *s, const solver_equations *e, int half)
{
    const int *range = s->model->half[half].chain;
    for (int i = range[0]; i < range[1]; i++) {
        const chain *c = &s->model->chain[i];
        const double *store = store_of(s->model, s->view, i, e->parts);
        double *of_chain = e->rhs + 4 * e->parts * c->first_node;
        chain_ends ends;
        solver_chain alone = solver_chain_of(s->model, c);
        alone.ends = &ends;
        find_fixed(s->model, c, s->junctions, &ends);
        if (e->parts == REAL)
            solver_real_solve(&alone, store, of_chain);
        else
            solver_complex_solve(&alone, store, of_chain);
    }
}

/* ---- Chains that junctions couple. ---- */

/* The matrix of the junctions lies behind the factors of the chains. */
static solver_junction_system junctions_in(const gallop_model *model, const state_view *view,
                                           int parts)
{
    double *store = parts == REAL ? view->factors : view->complex_factors;
    return (solver_junction_system){model->junction_count, model->junction_reach, model->unknowns,
                                    model->fused, store + (size_t)parts * model->chain_factors};
}

static void add_block(const system_tangent *t, const solver_junction_system *s, const int at[2],
                      int part, const double values[16])
{
    (t->parts == REAL ? solver_real_junctions_add : solver_complex_junctions_add)(s, at[0], at[1],
                                                                                  part, values);
}

static solver_chain reduced_chain_of(const gallop_model *model, const chain *c)
{
    return (solver_chain){.elements = c->elements,
                          .unknowns = model->unknowns,
                          .fused = model->fused,
                          .strips = c->strips,
                          .strip_start = c->strip_start,
                          .kept_corners = c->kept_corners,
                          .kept = c->kept,
                          .blocks = blocks_of};
}

/* What a chain has between two kept corners, the second one being number `index`. */
static void add_segment(const system_tangent *t, const solver_junction_system *s, const chain *c,
                        const solver_chain *reduced, const double *store, int index)
{
    const kept_corner *at = &c->kept[index - 1];
    double ends[2][2][2][4][4];
    if (t->parts == REAL)
        solver_real_ends(reduced, store, index - 1, ends);
    else
        solver_complex_ends(reduced, store, index - 1, ends);
    for (int part = 0; part < t->parts; part++)
        for (int k = 0; k < 4; k++) {
            const int junctions[2] = {at[k / 2].junction, at[k % 2].junction};
            add_block(t, s, junctions, part, ends[part][k / 2][k % 2][0]);
        }
}

static bool reduce_half(const system_tangent *t, int half)
{
    const int *range = t->model->half[half].chain;
    for (int i = range[0]; i < range[1]; i++) {
        const chain *c = &t->model->chain[i];
        const chain_motion here = {t, c};
        solver_chain reduced = reduced_chain_of(t->model, c);
        double *store = store_of(t->model, t->view, i, t->parts);
        reduced.source = &here;
        const bool good = t->parts == REAL ? solver_real_reduce(&reduced, t->weights, store)
                                           : solver_complex_reduce(&reduced, t->weights, store);
        if (!good) return false;
    }
    return true;
}

static void add_chains(const system_tangent *t, const solver_junction_system *s)
{
    for (int i = 0; i < t->model->chain_count; i++) {
        const chain *c = &t->model->chain[i];
        const solver_chain reduced = reduced_chain_of(t->model, c);
        const double *store = store_of(t->model, t->view, i, t->parts);
        for (int k = 1; k < c->kept_corners; k++) add_segment(t, s, c, &reduced, store, k);
    }
}

static void add_coupling_devices(const system_tangent *t, const solver_junction_system *s)
{
    for (int i = 0; i < t->model->device_count; i++) {
        const device *d = &t->model->device[i];
        const int count = d->junctions;
        for (int part = 0; part < t->parts; part++) {
            device_block tangent[GALLOP_DEVICE_JUNCTIONS * GALLOP_DEVICE_JUNCTIONS];
            device_tangent(t->model, d, t->now, t->y, t->weights[part], tangent);
            for (int k = 0; k < count * count; k++) {
                const int junctions[2] = {d->junction[k / count], d->junction[k % count]};
                add_block(t, s, junctions, part, tangent[k]);
            }
        }
    }
}

/* Rows of prescribed unknowns say that they are zero; an unknown that the scene does not need has
 * none. */
static void fix_rows(const system_tangent *t, const solver_junction_system *s)
{
    for (int j = 0; j < s->count; j++)
        for (int i = 0; i < s->unknowns; i++) {
            if (!t->model->junction[j].fixed[i]) continue;
            (t->parts == REAL ? solver_real_junctions_fix : solver_complex_junctions_fix)(s, j, i);
        }
}

static bool factor_junctions(const system_tangent *t)
{
    const solver_junction_system s = junctions_in(t->model, t->view, t->parts);
    (t->parts == REAL ? solver_real_junctions_clear : solver_complex_junctions_clear)(&s);
    add_chains(t, &s);
    add_coupling_devices(t, &s);
    fix_rows(t, &s);
    return (t->parts == REAL ? solver_real_junctions_factor
                             : solver_complex_junctions_factor)(&s, t->weights);
}

/* The right-hand sides of the junctions, which are at their leading nodes, become solutions. */
static void solve_junctions(const gallop_model *model, const state_view *view, int parts,
                            double *rhs)
{
    const solver_junction_system s = junctions_in(model, view, parts);
    const size_t width = 4 * (size_t)parts;
    double *x = view->junction_rhs;
    for (int j = 0; j < s.count; j++) {
        const junction *at = &model->junction[j];
        const double *from = rhs + width * at->node;
        double *to = x + width * j;
        for (int part = 0; part < parts; part++, from += 4, to += 4)
            for (int i = 0; i < 4; i++) to[i] = at->fixed[i] || i >= s.unknowns ? 0.0 : from[i];
    }
    (parts == REAL ? solver_real_junctions_solve : solver_complex_junctions_solve)(&s, x);
    for (int j = 0; j < s.count; j++)
        memcpy(rhs + width * model->junction[j].node, x + width * j, width * sizeof *x);
}

static void take_to_ends(const solution *s, const solver_equations *e, int half)
{
    const int *range = s->model->half[half].chain;
    for (int i = range[0]; i < range[1]; i++) {
        const chain *c = &s->model->chain[i];
        const solver_chain kept = reduced_chain_of(s->model, c);
        const double *store = store_of(s->model, s->view, i, e->parts);
        double *of_chain = e->rhs + 4 * e->parts * c->first_node;
        (e->parts == REAL ? solver_real_to_ends : solver_complex_to_ends)(&kept, store, of_chain);
    }
    junction_gather(s->model, half, e->rhs, 4 * e->parts);
}

static void take_from_ends(const solution *s, const solver_equations *e, int half)
{
    const int *range = s->model->half[half].chain;
    junction_spread(s->model, half, e->rhs, 4 * e->parts);
    for (int i = range[0]; i < range[1]; i++) {
        const chain *c = &s->model->chain[i];
        const solver_chain kept = reduced_chain_of(s->model, c);
        const double *store = store_of(s->model, s->view, i, e->parts);
        double *of_chain = e->rhs + 4 * e->parts * c->first_node;
        (e->parts == REAL ? solver_real_from_ends : solver_complex_from_ends)(&kept, store,
                                                                              of_chain);
    }
}

/* ---- All of it. ---- */

static bool is_coupled(const gallop_model *model, solver_junctions junctions)
{
    return model->coupled && junctions == SOLVER_JUNCTIONS_AS_IN_SCENE;
}

static system_tangent tangent_of(const solution *s, const solver_equations *e)
{
    return (system_tangent){s->model, e->now, s->view, e->y, e->weights, e->parts};
}

/* Right-hand side of a half, factors of its chains, and what they leave to the junctions; of chains
 * by themselves the solution. */
static void begin_half(void *task, int half)
{
    solution *s = task;
    const bool coupled = is_coupled(s->model, s->junctions);
    if (s->frame) s->frame->before(s->frame->task, half);
    s->good[half] = true;
    for (int i = 0; i < s->count && s->good[half]; i++) {
        const system_tangent t = tangent_of(s, &s->equations[i]);
        if (t.weights)
            s->good[half] =
                coupled ? reduce_half(&t, half) : factor_half_alone(&t, half, s->junctions);
    }
    if (!s->good[half]) return;
    for (int i = 0; i < s->count; i++) {
        if (!s->equations[i].rhs) continue;
        if (coupled)
            take_to_ends(s, &s->equations[i], half);
        else
            solve_half_alone(s, &s->equations[i], half);
    }
    if (!coupled && s->frame) s->frame->after(s->frame->task, half);
}

static void end_half(void *task, int half)
{
    const solution *s = task;
    for (int i = 0; i < s->count; i++)
        if (s->equations[i].rhs) take_from_ends(s, &s->equations[i], half);
    if (s->frame) s->frame->after(s->frame->task, half);
}

bool solver_run(const gallop_model *model, const state_view *view, solver_junctions junctions,
                const solver_equations *equations, int count, const solver_frame *frame)
{
    solution s = {model, view, junctions, equations, count, frame, {true, true}};
    team_share(view->team, model->halves, begin_half, &s);
    if (!s.good[0] || !s.good[1]) return false;
    if (!is_coupled(model, junctions)) return true;
    for (int i = 0; i < count; i++) {
        const solver_equations *e = &equations[i];
        const system_tangent t = tangent_of(&s, e);
        if (t.weights && !factor_junctions(&t)) return false;
        if (!e->rhs) continue;
        junction_gather(model, BETWEEN, e->rhs, 4 * e->parts);
        solve_junctions(model, view, e->parts, e->rhs);
    }
    team_share(view->team, model->halves, end_half, &s);
    return true;
}

bool solver_factor(const gallop_model *model, const conditions *now, const state_view *view,
                   motion y, tangent_weights weights, solver_junctions junctions)
{
    const solver_equations e = {REAL, now, y, &weights, NULL};
    return solver_run(model, view, junctions, &e, 1, NULL);
}

void solver_solve(const gallop_model *model, const state_view *view, solver_junctions junctions,
                  double *rhs)
{
    const solver_equations e = {.parts = REAL, .rhs = rhs};
    solver_run(model, view, junctions, &e, 1, NULL);
}
