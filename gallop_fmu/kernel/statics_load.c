/* From the strung state to the initial equilibrium of a line. */
#include "statics.h"

#include "report.h"
#include "time_integration.h"

/* The weight of the conductors in the strung state, or as it is now. */
void statics_weights(const gallop_model *m, bool strung, double *force)
{
    memset(force, 0, 4 * (size_t)m->nodes * sizeof(double));
    for (int i = 0; i < m->interval_count; i++) {
        const interval *c = &m->interval[i];
        const double mass = strung ? c->section->strung_mass : c->section->mass;
        double *of_interval = force + 4 * c->first_node;
        for (int e = 0; e < c->elements; e++)
            for (int n = 0; n < 3; n++) { /* sum over b of int N_a N_b dS = int N_a dS */
                const double *row = c->geometry[e].shape_product[n];
                of_interval[8 * e + 4 * n + 1] -= mass * c->gravity * (row[0] + row[1] + row[2]);
            }
    }
}

/* The current position becomes the reference; the second Piola-Kirchhoff tension T on p becomes T
 * |p| on p / |p|. */
void statics_rebase(gallop_model *m, double *u)
{
    for (int i = 0; i < m->interval_count; i++) {
        interval *c = &m->interval[i];
        const double *of_interval = u + 4 * c->first_node;
        for (int e = 0; e < c->elements; e++) {
            double tension[2], x[9];
            element_tension(c, e, false, of_interval + 8 * e, tension);
            for (int n = 0; n < 3; n++)
                for (int k = 0; k < 3; k++)
                    x[3 * n + k] = c->x[6 * e + 3 * n + k] + of_interval[8 * e + 4 * n + k];
            element_geometry_from_nodes(&c->geometry[e], x, tension);
        }
        element_fill_strips(c);
    }
    for (int n = 0; n < m->nodes; n++)
        for (int k = 0; k < 3; k++) m->x[3 * n + k] += u[4 * n + k];
    memset(u, 0, 4 * (size_t)m->nodes * sizeof(double));
}

/* The tension N = EA (L / L0 - 1) of a conductor whose unstretched length L0 grows by the factor
 * 1 + a, at its length: (N - a EA) / (1 + a). */
static void heat(gallop_model *m, double change)
{
    for (int i = 0; i < m->interval_count; i++) {
        interval *c = &m->interval[i];
        const double ea = c->section->axial_stiffness, a = c->section->thermal_expansion * change;
        if (a == 0.0) continue;
        for (int e = 0; e < c->elements; e++)
            for (int q = 0; q < 2; q++) {
                double *tension = &c->geometry[e].tension[q];
                *tension = (*tension - a * ea) / (1.0 + a);
            }
        element_fill_strips(c);
    }
}

/* The junctions are where the displacements took them. */
static void move_junctions(gallop_model *m, const double *u)
{
    for (int j = 0; j < m->junction_count; j++)
        for (int k = 0; k < 3; k++) m->junction[j].moved[k] += u[4 * m->junction[j].node + k];
}

/* The largest displacement in the plane of the line. */
static double largest_in_plane(const gallop_model *m, const double *u)
{
    double largest = 0.0;
    for (int n = 0; n < m->nodes; n++)
        largest = fmax(largest, fmax(fabs(u[4 * n]), fabs(u[4 * n + 1])));
    return largest;
}

#define MAX_ROUNDS 12
#define SETTLED 1e-12 /* of the shortest span */

int statics_load(gallop_model *m, const state_view *at, gallop_report *report)
{
    conditions calm = at->stage[0];
    conditions_at(m, 0.0, NULL, &calm);
    for (int f = 0; f < m->field_count; f++) calm.wind[f] = 0.0;
    for (int i = 0; i < 3 * m->junction_count; i++) calm.position[i] = 0.0;
    calm.load_factor = 0.0;
    calm.taut = true;
    heat(m, m->scene.settings.temperature_change);
    for (int round = 0; round < MAX_ROUNDS; round++) {
        statics_weights(m, false, m->constant_force);
        memset(at->u, 0, 4 * (size_t)m->nodes * sizeof(double));
        const int outcome = statics_newton(m, 0.0, &calm, SOLVER_JUNCTIONS_AS_IN_SCENE, at, report);
        if (outcome) return outcome;
        for (int n = 0; n < m->nodes; n++) at->u[4 * n + 2] = at->u[4 * n + 3] = 0.0;
        const double moved = largest_in_plane(m, at->u);
        move_junctions(m, at->u);
        statics_rebase(m, at->u);
        if (moved < SETTLED * statics_shortest_span(m)) break;
    }
    return GALLOP_COMPLETED;
}
