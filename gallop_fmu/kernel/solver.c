/* The tangent equations of all chains and devices.
 *
 * A chain whose ends are coupled to nothing that moves is solved by itself. */
#include "solver.h"

#include "device.h"

/* Where the factors of a chain lie in the state. */
static double *real_store(const gallop_model *model, const state_view *view, int index)
{
    const size_t before = (size_t)model->chain[index].first_element + 2 * (size_t)index;
    return view->factors + before * sizeof(chain_factor) / sizeof(double);
}

static double *complex_store(const gallop_model *model, const state_view *view, int index)
{
    const size_t before = (size_t)model->chain[index].first_element + 2 * (size_t)index;
    return view->complex_factors + before * sizeof(complex_factor) / sizeof(double);
}

/* Where the tangent of a chain is taken. */
typedef struct {
    const chain *chain;
    exposure now;
    const sections *at;
    const double *u;
} chain_motion;

static void blocks_of(const void *source, int index, tangent_weights weights, lanes block[6][16])
{
    const chain_motion *m = source;
    element_strip_tangent(m->chain, index, &m->now, m->at, m->u, weights, block);
}

/* Which unknowns of the ends of a chain are prescribed. */
static void find_fixed(const gallop_model *model, const chain *c, solver_junctions junctions,
                       chain_ends *ends)
{
    for (int end = 0; end < 2; end++)
        for (int i = 0; i < 4; i++)
            ends->fixed[end][i] =
                junctions == SOLVER_JUNCTIONS_FIXED || model->junction[c->junction[end]].fixed[i];
}

/* Adds the tangents of the devices at the ends of a chain; part: 0 real, 1 imaginary. */
static void add_devices(const gallop_model *model, const chain *c, const conditions *now, motion y,
                        tangent_weights weights, int part, chain_ends *ends)
{
    for (int i = 0; i < model->device_count; i++) {
        const device *d = &model->device[i];
        for (int end = 0; end < 2; end++) {
            if (d->junction[0] != c->junction[end]) continue;
            double tangent[2][2][16];
            device_tangent(model, d, now, y, weights, tangent);
            for (int k = 0; k < 16; k++) ends->tangent[end][part][k] += tangent[0][0][k];
        }
    }
}

bool solver_factor(const gallop_model *model, const conditions *now, const state_view *view,
                   motion y, tangent_weights weights, solver_junctions junctions)
{
    for (int i = 0; i < model->chain_count; i++) {
        const chain *c = &model->chain[i];
        const chain_motion here = {c, conditions_on(model, now, c), &view->sections,
                                   y.u + 4 * c->first_node};
        chain_ends ends = {.tangent = {{{0.0}}}};
        const solver_chain alone = {c->elements, model->unknowns, &ends, blocks_of, &here};
        find_fixed(model, c, junctions, &ends);
        add_devices(model, c, now, y, weights, 0, &ends);
        if (!solver_real_factor(&alone, &weights, real_store(model, view, i))) return false;
    }
    return true;
}

void solver_solve(const gallop_model *model, const state_view *view, solver_junctions junctions,
                  double *rhs)
{
    for (int i = 0; i < model->chain_count; i++) {
        const chain *c = &model->chain[i];
        chain_ends ends;
        const solver_chain alone = {c->elements, model->unknowns, &ends, NULL, NULL};
        find_fixed(model, c, junctions, &ends);
        solver_real_solve(&alone, real_store(model, view, i), rhs + 4 * c->first_node);
    }
}

bool solver_factor_complex(const gallop_model *model, const conditions *now, const state_view *view,
                           motion y, const tangent_weights weights[2])
{
    for (int i = 0; i < model->chain_count; i++) {
        const chain *c = &model->chain[i];
        const chain_motion here = {c, conditions_on(model, now, c), &view->sections,
                                   y.u + 4 * c->first_node};
        chain_ends ends = {.tangent = {{{0.0}}}};
        const solver_chain alone = {c->elements, model->unknowns, &ends, blocks_of, &here};
        find_fixed(model, c, SOLVER_JUNCTIONS_AS_IN_SCENE, &ends);
        for (int part = 0; part < 2; part++)
            add_devices(model, c, now, y, weights[part], part, &ends);
        if (!solver_complex_factor(&alone, weights, complex_store(model, view, i))) return false;
    }
    return true;
}

void solver_solve_complex(const gallop_model *model, const state_view *view, double *rhs)
{
    for (int i = 0; i < model->chain_count; i++) {
        const chain *c = &model->chain[i];
        chain_ends ends;
        const solver_chain alone = {c->elements, model->unknowns, &ends, NULL, NULL};
        find_fixed(model, c, SOLVER_JUNCTIONS_AS_IN_SCENE, &ends);
        solver_complex_solve(&alone, complex_store(model, view, i), rhs + 8 * c->first_node);
    }
}
