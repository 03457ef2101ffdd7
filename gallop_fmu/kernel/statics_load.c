/* From the strung state to the initial equilibrium of a line.
 *
 * The junctions are released, the devices get their weight; then ice and change of temperature grow
 * in steps where one step does not lead to an equilibrium.  The tension follows
 * N = EA (L / L0 - 1), of which EA + N is proportional to the length L: so it becomes the reference
 * of the next round, until nothing moves any more. */
#include "statics.h"

#include "device.h"
#include "report.h"
#include "system.h"
#include "time_integration.h"

void statics_weights(const gallop_model *m, double part, double *force)
{
    memset(force, 0, 4 * (size_t)m->nodes * sizeof(double));
    for (int i = 0; i < m->interval_count; i++) {
        const interval *c = &m->interval[i];
        const double mass = (1.0 - part) * c->section->strung_mass + part * c->section->mass;
        double *of_interval = force + 4 * c->first_node;
        for (int e = 0; e < c->elements; e++)
            for (int n = 0; n < 3; n++) { /* sum over b of int N_a N_b dS = int N_a dS */
                const double *row = c->geometry[e].shape_product[n];
                of_interval[8 * e + 4 * n + 1] -= mass * c->gravity * (row[0] + row[1] + row[2]);
            }
    }
}

/* The tension at the Gauss points by the law N = EA (L / L0 - 1). */
static void linear_tension(const interval *c, int e, const double u[12], double tension[2])
{
    const geometry *g = &c->geometry[e];
    const double ea = c->section->axial_stiffness;
    for (int q = 0; q < 2; q++) {
        const double *n = g->shape_slope[q];
        double square = 0.0;
        for (int i = 0; i < 3; i++) {
            const double p = g->slope[q][i] + n[0] * u[i] + n[1] * u[4 + i] + n[2] * u[8 + i];
            square += p * p;
        }
        tension[q] = (ea + g->tension[q]) * sqrt(square) - ea;
    }
}

/* Makes the position of an element its reference. */
static void rebase_element(interval *c, int e, const double u[12], const double tension[2])
{
    double x[9];
    for (int n = 0; n < 3; n++)
        for (int k = 0; k < 3; k++) x[3 * n + k] = c->x[6 * e + 3 * n + k] + u[4 * n + k];
    element_geometry_from_nodes(&c->geometry[e], x, tension);
}

static void move_nodes(gallop_model *m, double *u)
{
    for (int n = 0; n < m->nodes; n++)
        for (int k = 0; k < 3; k++) m->x[3 * n + k] += u[4 * n + k];
    memset(u, 0, 4 * (size_t)m->nodes * sizeof(double));
}

/* The second Piola-Kirchhoff tension T on p becomes T |p| on p / |p|. */
void statics_rebase(gallop_model *m, double *u)
{
    for (int i = 0; i < m->interval_count; i++) {
        interval *c = &m->interval[i];
        for (int e = 0; e < c->elements; e++) {
            const double *of_element = u + 4 * c->first_node + 8 * e;
            double tension[2];
            element_tension(c, e, false, of_element, tension);
            rebase_element(c, e, of_element, tension);
        }
        element_fill_strips(c);
    }
    move_nodes(m, u);
}

/* The same by the linear law; the lengths of conductor that have mass and face the wind stay those
 * of the strung state. */
static void rebase_loaded(gallop_model *m, double *u)
{
    for (int i = 0; i < m->interval_count; i++) {
        interval *c = &m->interval[i];
        for (int e = 0; e < c->elements; e++) {
            const double *of_element = u + 4 * c->first_node + 8 * e;
            const geometry before = c->geometry[e];
            geometry *g = &c->geometry[e];
            double tension[2];
            linear_tension(c, e, of_element, tension);
            rebase_element(c, e, of_element, tension);
            memcpy(g->inertia_weight, before.inertia_weight, sizeof g->inertia_weight);
            memcpy(g->shape_product, before.shape_product, sizeof g->shape_product);
        }
        element_fill_strips(c);
    }
    for (int j = 0; j < m->junction_count; j++)
        for (int k = 0; k < 3; k++) m->junction[j].moved[k] += u[4 * m->junction[j].node + k];
    move_nodes(m, u);
}

/* The unstretched length grows from its factor 1 + a from to 1 + a to, where a is the thermal
 * strain of the whole change of temperature: EA + N changes by the inverse factor. */
static void heat(gallop_model *m, double from, double to)
{
    const gallop_settings *s = &m->scene.settings;
    for (int i = 0; i < m->interval_count; i++) {
        interval *c = &m->interval[i];
        const double ea = c->section->axial_stiffness;
        const double a = c->section->thermal_expansion * (s->temperature - s->strung_temperature);
        if (a == 0.0) continue;
        const double factor = (1.0 + a * from) / (1.0 + a * to);
        for (int e = 0; e < c->elements; e++)
            for (int q = 0; q < 2; q++) {
                double *tension = &c->geometry[e].tension[q];
                *tension = (ea + *tension) * factor - ea;
            }
        element_fill_strips(c);
    }
}

/* ---- the load path ---- */

typedef struct {
    static_load load;
    gallop_model *model;
    double heated; /* part of the change of temperature that the reference has */
} ice_and_heat;

void statics_add_spring_forces(const gallop_model *m, double *force)
{
    for (int j = 0; j < m->junction_count; j++)
        for (int k = 0; k < 3; k++)
            force[4 * m->junction[j].node + k] += m->junction[j].static_force[k];
}

static void apply_ice_and_heat(static_load *load, double part, const state_view *at)
{
    ice_and_heat *own = (ice_and_heat *)load;
    gallop_model *m = own->model;
    (void)at;
    heat(m, own->heated, part);
    own->heated = part;
    statics_weights(m, part, m->constant_force);
    statics_add_spring_forces(m, m->constant_force);
}

/* Calm air, and towers at their places. */
void statics_calm(const gallop_model *m, conditions *now)
{
    conditions_at(m, 0.0, NULL, now);
    for (int f = 0; f < m->field_count; f++) now->wind[f] = 0.0;
    conditions_blow(m, false, now);
    for (int i = 0; i < 9 * m->junction_count; i++) now->position[i] = 0.0;
    now->load_factor = 0.0;
    now->taut = true;
}

/* Springs carry for ever what holds the strung state at their junctions. */
static void prestress_springs(gallop_model *m, const conditions *now, const state_view *at)
{
    const motion rest = {at->v0, at->v0, at->v0};
    monitor seen;
    element_monitor_start(&seen);
    memset(at->v0, 0, 4 * (size_t)m->nodes * sizeof(double));
    statics_weights(m, 0.0, m->constant_force);
    system_residual(m, 0.0, now, at, rest, false, at->residual, &seen);
    for (int i = 0; i < m->device_count; i++) {
        const device *d = &m->device[i];
        junction *j = &m->junction[d->junction[0]];
        for (int k = 0; k < 3 && d->kind->prestressed; k++)
            if (!j->fixed[k]) j->static_force[k] = at->residual[4 * j->node + k];
    }
}

/* ---- the initial equilibrium ---- */

#define MAX_ROUNDS 12
#define SETTLED 1e-12 /* of the shortest span */

/* The largest displacement in the plane of the line. */
static double largest_in_plane(const gallop_model *m, const double *u)
{
    double largest = 0.0;
    for (int n = 0; n < m->nodes; n++)
        largest = fmax(largest, fmax(fabs(u[4 * n]), fabs(u[4 * n + 1])));
    return largest;
}

/* The position in the plane of the line becomes the reference; u keeps what is across. */
static void rebase_in_plane(gallop_model *m, const state_view *at)
{
    memcpy(at->first, at->u, 4 * (size_t)m->nodes * sizeof(double));
    for (int n = 0; n < m->nodes; n++) at->u[4 * n + 2] = at->u[4 * n + 3] = 0.0;
    rebase_loaded(m, at->u);
    for (int n = 0; n < m->nodes; n++)
        for (int k = 2; k < 4; k++) at->u[4 * n + k] = at->first[4 * n + k];
}

/* Until the reference itself is the equilibrium. */
static int settle(gallop_model *m, const conditions *now, const state_view *at,
                  gallop_report *report)
{
    for (int round = 0; round < MAX_ROUNDS; round++) {
        const double moved = largest_in_plane(m, at->u);
        rebase_in_plane(m, at);
        statics_weights(m, 1.0, m->constant_force);
        statics_add_spring_forces(m, m->constant_force);
        if (round > 0 && moved < SETTLED * statics_shortest_span(m)) break;
        const int outcome = statics_newton(m, 0.0, now, SOLVER_JUNCTIONS_AS_IN_SCENE, at, report);
        if (outcome) return outcome;
    }
    return GALLOP_COMPLETED;
}

/* Compression is no equilibrium of a cable. */
static int check_tension(const gallop_model *m, const conditions *now, const state_view *at,
                         gallop_report *report)
{
    monitor seen;
    element_monitor_start(&seen);
    for (int h = 0; h < m->halves; h++) element_monitor_tensions(m, h, now, at->u, &seen);
    return seen.lowest_tension < 0.0 ? report_failure(report, GALLOP_SLACK, seen.slack_element, 0.0,
                                                      seen.lowest_tension, 0.0)
                                     : GALLOP_COMPLETED;
}

int statics_load(gallop_model *m, const state_view *at, gallop_report *report)
{
    ice_and_heat own = {{apply_ice_and_heat, at->stage[0]}, m, 0.0};
    statics_calm(m, &own.load.now);
    prestress_springs(m, &own.load.now, at);
    int outcome = statics_in_steps(m, 0.0, at, &own.load, report);
    if (!outcome) outcome = settle(m, &own.load.now, at, report);
    return outcome ? outcome : check_tension(m, &own.load.now, at, report);
}
