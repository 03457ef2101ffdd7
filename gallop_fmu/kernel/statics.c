/* Equilibrium at rest by Newton-Raphson, with load stepping under wind, loads and displaced
 * supports. */
#include "statics.h"

#include "junction.h"
#include "report.h"
#include "system.h"
#include "time_integration.h"

/* Newton-Raphson at rest. */
#define STATIC_TOLERANCE 1e-3      /* of the Newton tolerance of a step */
#define MAX_STATIC_CORRECTION 0.05 /* of the shortest span */
#define MAX_STATIC_ITERATIONS 60

double statics_shortest_span(const gallop_model *m)
{
    double shortest = INFINITY;
    for (int i = 0; i < m->chain_count; i++) shortest = fmin(shortest, m->chain[i].span);
    return shortest;
}

/* Returns 0, or an outcome with u as it was. */
int statics_newton(const gallop_model *m, double t, const conditions *now,
                   solver_junctions junctions, const state_view *at, gallop_report *report)
{
    const size_t values = 4 * (size_t)m->nodes;
    const double tolerance = STATIC_TOLERANCE * m->scene.settings.newton_tolerance;
    const double longest = MAX_STATIC_CORRECTION * statics_shortest_span(m);
    const tangent_weights stiffness = {1.0, 0.0, 0.0};
    const motion y = {at->u, at->v0, at->v0};
    double size = 0.0, before = INFINITY;
    monitor seen = {0};
    memcpy(at->u0, at->u, values * sizeof(double));
    memset(at->v0, 0, values * sizeof(double));
    for (int iteration = 0; iteration < MAX_STATIC_ITERATIONS; iteration++) {
        element_monitor_start(&seen);
        if (junctions == SOLVER_JUNCTIONS_FIXED) /* the single spans, without devices */
            element_sum_residual(m, t, now, &at->sections, y, true, at->residual, &seen);
        else
            system_residual(m, t, now, at, y, true, at->residual, &seen);
        if (!solver_factor(m, now, at, y, stiffness, junctions)) break;
        solver_solve(m, at, junctions, at->residual);
        size = time_correction_size(m, at->residual);
        if (!isfinite(size)) break;
        const double scale = size > longest ? longest / size : 1.0;
        for (size_t i = 0; i < values; i++) at->u[i] -= scale * at->residual[i];
        /* quadratic convergence ends in round-off: accept when it no longer improves */
        if (size < tolerance ||
            (size < 10.0 * m->scene.settings.newton_tolerance && size > 0.5 * before)) {
            if (!(seen.worst_excess > 0.0)) return GALLOP_COMPLETED;
            memcpy(at->u, at->u0, values * sizeof(double));
            return time_angle_failure(m, seen.angle_element, seen.worst_angle, t, report);
        }
        before = size;
    }
    memcpy(at->u, at->u0, values * sizeof(double));
    return report_failure(report, GALLOP_EQUILIBRIUM_NOT_FOUND, seen.slack_element, t, size,
                          tolerance);
}

/* [m] for the derivative of the residual along a displacement of the ends */
#define DIFFERENCE_DISPLACEMENT 1e-6

/* The ends go to their places, and the nodes between follow by the tangent: an end that moved alone
 * would push its element slack. */
static void move_ends(const gallop_model *m, double t, const conditions *now, const state_view *at)
{
    const tangent_weights stiffness = {1.0, 0.0, 0.0};
    const int values = 4 * m->nodes;
    const motion from = {at->u, at->v0, at->v0}, to = {at->u0, at->v0, at->v0};
    double *move = at->first + values, *before = at->first + 2 * values, largest = 0.0;
    memcpy(move, at->u, (size_t)values * sizeof(double));
    junction_prescribe(m, now, move, NULL, NULL);
    for (int n = 0; n < values; n++) {
        move[n] -= at->u[n];
        largest = fmax(largest, fabs(move[n]));
    }
    if (largest == 0.0) return;

    const double part = DIFFERENCE_DISPLACEMENT / largest;
    monitor seen = {0};
    element_monitor_start(&seen);
    memset(at->v0, 0, (size_t)values * sizeof(double));
    element_sum_residual(m, t, now, &at->sections, from, true, before, &seen);
    const bool solvable = solver_factor(m, now, at, from, stiffness, SOLVER_JUNCTIONS_AS_IN_SCENE);
    for (int n = 0; n < values; n++) at->u0[n] = at->u[n] + part * move[n];
    element_sum_residual(m, t, now, &at->sections, to, false, at->residual, &seen);
    for (int n = 0; n < values; n++) at->residual[n] = (at->residual[n] - before[n]) / part;
    junction_gather(m, at->residual, 4);
    if (solvable) solver_solve(m, at, SOLVER_JUNCTIONS_AS_IN_SCENE, at->residual);
    for (int n = 0; n < values; n++) at->u[n] += move[n] - (solvable ? at->residual[n] : 0.0);
    junction_prescribe(m, now, at->u, NULL, NULL); /* exactly */
}

#define MIN_LOAD_STEP (1.0 / 1024.0)

/* Loads, support displacement and wind pressure (so the square of the speed) grow in steps that
 * halve on failure. Nothing that has weight rests slack, so the way there is taken with the law of
 * the taut cable, whose tangent is never empty; an arch in compression is not found, as its tangent
 * is not positive. */
int statics_equilibrium(const gallop_model *m, double t, bool calm, const state_view *at,
                        gallop_report *report)
{
    const size_t values = 4 * (size_t)m->nodes;
    const conditions *target = &at->now;
    conditions now = at->stage[0];
    double done = 0.0, step = 1.0;
    memset(at->u, 0, values * sizeof(double));
    while (done < 1.0) {
        const double part = done + step < 1.0 ? done + step : 1.0;
        conditions_copy(m, &now, target);
        now.taut = true;
        now.load_factor = calm ? 0.0 : part;
        for (int f = 0; f < m->field_count; f++)
            now.wind[f] = calm ? 0.0 : target->wind[f] * sqrt(part);
        for (int i = 0; i < 3 * m->junction_count; i++) now.position[i] *= part;
        memcpy(at->first, at->u, values * sizeof(double));
        move_ends(m, t, &now, at);
        const int outcome = statics_newton(m, t, &now, SOLVER_JUNCTIONS_AS_IN_SCENE, at, report);
        if (outcome == GALLOP_COMPLETED) {
            done = part;
            continue;
        }
        memcpy(at->u, at->first, values * sizeof(double));
        if (outcome != GALLOP_EQUILIBRIUM_NOT_FOUND) return outcome;
        step *= 0.5;
        if (step < MIN_LOAD_STEP) return outcome;
    }
    return report_completed(report, t); /* without the load steps that failed on the way */
}
