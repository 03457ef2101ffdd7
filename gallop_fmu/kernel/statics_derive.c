/* What follows from the initial equilibrium: sag, tension, length and end forces of the chains,
 * forces on the towers, the forces that stay constant from here on. */
#include "statics.h"

#include "base_memory.h"
#include "check.h"
#include "device.h"
#include "system.h"

#define BISECTIONS 60 /* more than a double has bits */

void statics_internal_forces(const gallop_model *m, double *force)
{
    memset(force, 0, 4 * (size_t)m->nodes * sizeof(double));
    for (int k = 0; k < m->chain_count; k++) {
        const chain *c = &m->chain[k];
        double *of_chain = force + 4 * c->first_node;
        for (int e = 0; e < c->elements; e++)
            for (int q = 0; q < 2; q++)
                for (int n = 0; n < 3; n++) {
                    const geometry *g = &c->geometry[e];
                    const double w = g->stiffness_weight[q] * g->shape_slope[q][n] * g->tension[q];
                    for (int i = 0; i < 3; i++) of_chain[8 * e + 4 * n + i] += w * g->slope[q][i];
                }
    }
}

double statics_mesh_sag(const gallop_model *m, const chain *c)
{
    const junction *left = &m->junction[c->junction[0]], *right = &m->junction[c->junction[1]];
    const double span = c->span + right->moved[0] - left->moved[0];
    const double rise = c->rise + right->moved[1] - left->moved[1];
    const double wanted = left->position[0] + left->moved[0] + 0.5 * span;
    int e = 0;
    while (e < c->elements - 1 && c->x[6 * e + 6] < wanted) e++;
    const double *x = c->x + 6 * e;
    double low = -1.0, high = 1.0;
    for (int i = 0; i < BISECTIONS; i++) {
        const double xi = 0.5 * (low + high);
        const double at =
            0.5 * xi * (xi - 1.0) * x[0] + (1.0 - xi * xi) * x[3] + 0.5 * xi * (xi + 1.0) * x[6];
        if (at < wanted)
            low = xi;
        else
            high = xi;
    }
    const double xi = 0.5 * (low + high);
    return left->position[1] + left->moved[1] + 0.5 * rise -
           (0.5 * xi * (xi - 1.0) * x[1] + (1.0 - xi * xi) * x[4] + 0.5 * xi * (xi + 1.0) * x[7]);
}

bool statics_is_held(const chain *c)
{
    return c->target_sag > 0.0 && c->target_tension > 0.0;
}

/* Length of the conductor in the initial equilibrium. */
static double length_of(const chain *c)
{
    const double none[2] = {0.0, 0.0};
    double length = 0.0;
    for (int e = 0; e < c->elements; e++) {
        geometry now;
        element_geometry_from_nodes(&now, c->x + 6 * e, none);
        length += now.inertia_weight[0] + now.inertia_weight[1] + now.inertia_weight[2];
    }
    return length;
}

/* Sag, tension, length and end forces of a chain; its ends are held by `holding`. */
static void derive_chain(const gallop_model *m, chain *c, const double *holding)
{
    c->sag = statics_mesh_sag(m, c);
    c->length = length_of(c);
    for (int end = 0; end < 2; end++)
        for (int k = 0; k < 3; k++)
            c->end_force[end][k] = -holding[4 * (c->first_node + (end ? c->nodes - 1 : 0)) + k];
    c->horizontal_tension = statics_is_held(c) ? c->target_tension : fabs(c->end_force[0][0]);
    element_normals_at_nodes(c);
}

/* What the chains at a junction need beyond their weight. */
static void sum_holding(const gallop_model *m, int index, double force[3])
{
    for (int k = 0; k < 3; k++) force[k] = 0.0;
    for (int i = 0; i < m->chain_count; i++)
        for (int end = 0; end < 2; end++)
            for (int k = 0; k < 3; k++)
                if (m->chain[i].junction[end] == index) force[k] -= m->chain[i].end_force[end][k];
}

/* ---- sag and tension are those of the initial equilibrium ---- */

/* The largest force that no equilibrium balances: it is held as a constant force. */
static double held_force(const gallop_model *m, const double *holding)
{
    double largest = 0.0;
    for (int i = 0; i < m->chain_count; i++) {
        const chain *c = &m->chain[i];
        const int first = 4 * c->first_node, last = first + 4 * (c->nodes - 1);
        for (int n = first + 4; n < last; n++) largest = fmax(largest, fabs(holding[n]));
    }
    for (int i = 0; i < m->junction_count; i++)
        for (int k = 0; k < 3; k++)
            if (!m->junction[i].fixed[k] && !device_holds(m, i, k))
                largest = fmax(largest, fabs(m->junction[i].static_force[k]));
    return largest;
}

/* The initial state is balanced by constant forces, at the junctions too. */
static void derive_given(gallop_model *m, const state_view *at)
{
    double *holding = at->residual;
    statics_weights(m, 1.0, holding);
    statics_internal_forces(m, m->constant_force);
    for (int n = 0; n < 4 * m->nodes; n++) holding[n] = m->constant_force[n] - holding[n];
    for (int i = 0; i < m->chain_count; i++) derive_chain(m, &m->chain[i], holding);
    for (int i = 0; i < m->junction_count; i++) sum_holding(m, i, m->junction[i].static_force);
    for (int end = 0; end < 2; end++)
        for (int k = 0; k < 3; k++)
            m->derived.support_force[end][k] =
                -m->junction[end ? m->junction_count - 1 : 0].static_force[k];
    m->derived.imbalance = held_force(m, holding);
}

/* ---- they are those of the strung state ---- */

/* The largest residual force of the equilibrium. */
static double residual_force(const gallop_model *m, const double *residual)
{
    double largest = 0.0;
    for (int i = 0; i < m->chain_count; i++) {
        const chain *c = &m->chain[i];
        for (int n = 1; n < c->nodes - 1; n++)
            for (int k = 0; k < 3; k++)
                largest = fmax(largest, fabs(residual[4 * (c->first_node + n) + k]));
    }
    for (int i = 0; i < m->junction_count; i++) {
        const junction *j = &m->junction[i];
        for (int k = 0; k < 3; k++)
            if (!j->fixed[k]) largest = fmax(largest, fabs(residual[4 * j->node + k]));
    }
    return largest;
}

/* Constant are the weight and what springs hold; u of the view is the equilibrium. */
static void derive_strung(gallop_model *m, const state_view *at)
{
    conditions calm = at->stage[0];
    const motion y = {at->u, at->v0, at->v0};
    double *holding = at->residual;
    monitor seen;
    element_monitor_start(&seen);
    statics_calm(m, &calm);
    memset(at->v0, 0, 4 * (size_t)m->nodes * sizeof(double));
    statics_weights(m, 1.0, m->constant_force);
    element_sum_residual(m, 0.0, &calm, &at->sections, y, false, holding, &seen);
    for (int i = 0; i < m->chain_count; i++) derive_chain(m, &m->chain[i], holding);
    statics_add_spring_forces(m, m->constant_force);
    system_residual(m, 0.0, &calm, at, y, false, holding, &seen);
    m->derived.imbalance = residual_force(m, holding);
    for (int end = 0; end < 2; end++) {
        const int index = end ? m->junction_count - 1 : 0;
        const junction *j = &m->junction[index];
        double chains[3], devices[3];
        sum_holding(m, index, chains);
        device_tower_force(m, index, &calm, y, devices);
        for (int k = 0; k < 3; k++)
            m->derived.support_force[end][k] =
                j->fixed[k] ? -chains[k] : devices[k] - j->static_force[k];
    }
}

void statics_derive(gallop_model *m, const state_view *at)
{
    gallop_derived *d = &m->derived;
    if (m->scene.settings.strung)
        derive_strung(m, at);
    else
        derive_given(m, at);
    d->sag = m->chain[0].sag;
    d->horizontal_tension = m->chain[0].horizontal_tension;
    d->length = m->chain[0].length;
}

int gallop_chain_derived(const gallop_model *model, int32_t index, gallop_derived_chain *derived)
{
    if (!check_is_model(model) || !base_pointer_usable(derived, WORD)) return GALLOP_BAD_CALL;
    if (index < 0 || index >= model->chain_count) return GALLOP_BAD_CALL;
    const chain *c = &model->chain[index];
    *derived = (gallop_derived_chain){c->sag, c->horizontal_tension, c->length, {{0.0}}};
    memcpy(derived->end_force, c->end_force, sizeof derived->end_force);
    return GALLOP_COMPLETED;
}
