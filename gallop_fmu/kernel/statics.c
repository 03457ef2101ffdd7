/* Equilibrium at rest by Newton-Raphson, with load stepping under wind, loads and displaced
 * supports. */
#include "statics.h"

#include "base_math.h"
#include "device.h"
#include "junction.h"
#include "report.h"
#include "system.h"
#include "time_integration.h"

/* Newton-Raphson at rest. */
#define STATIC_TOLERANCE 1e-3      /* of the Newton tolerance of a step */
#define MAX_STATIC_CORRECTION 0.05 /* of the shortest span */
#define MAX_STATIC_ITERATIONS 60

/* Of the length of a bar: how far a correction may move its clamp.  A longer move would turn it
 * over on the way to an equilibrium near by. */
#define MAX_SWING 0.3

double statics_shortest_span(const gallop_model *m)
{
    double shortest = INFINITY;
    for (int i = 0; i < m->chain_count; i++) shortest = fmin(shortest, m->chain[i].span);
    return shortest;
}

/* The factor that keeps a correction of this size small against spans and bars. */
static double correction_scale(const gallop_model *m, const double *correction, double size)
{
    const double longest = MAX_STATIC_CORRECTION * statics_shortest_span(m);
    double scale = size > longest ? longest / size : 1.0;
    for (int i = 0; i < m->device_count; i++) {
        const device *d = &m->device[i];
        if (!(d->reach > 0.0)) continue;
        for (int k = 0; k < d->junctions; k++) {
            const double *move = correction + 4 * m->junction[d->junction[k]].node;
            const double length = sqrt(move[0] * move[0] + move[1] * move[1] + move[2] * move[2]);
            if (scale * length > MAX_SWING * d->reach) scale = MAX_SWING * d->reach / length;
        }
    }
    return scale;
}

/* Bars that swing have no stiffness across them before they are under pull, and a negative one in
 * compression.  There the tangent gets a multiple of the mass [1/s^2], as in a backward step in
 * time: so the iteration goes down to a stable equilibrium. */
#define FIRST_MASS 1.0
#define MORE_MASS 100.0
#define LARGEST_MASS 1e8

static bool has_bars(const gallop_model *m)
{
    for (int i = 0; i < m->device_count; i++)
        if (m->device[i].reach > 0.0) return true;
    return false;
}

/* Factors the stiffness with as much of `mass` as makes it positive. */
static bool factor_stiffness(const gallop_model *m, const conditions *now,
                             solver_junctions junctions, const state_view *at, double *mass)
{
    const motion y = {at->u, at->v0, at->v0};
    const bool bars = junctions == SOLVER_JUNCTIONS_AS_IN_SCENE && has_bars(m);
    while (!solver_factor(m, now, at, y, (tangent_weights){1.0, 0.0, *mass}, junctions)) {
        *mass = *mass > 0.0 ? MORE_MASS * *mass : FIRST_MASS;
        if (!bars || *mass > LARGEST_MASS) return false;
    }
    return true;
}

/* Returns 0, or an outcome with u as it was. */
int statics_newton(const gallop_model *m, double t, const conditions *now,
                   solver_junctions junctions, const state_view *at, gallop_report *report)
{
    const size_t values = 4 * (size_t)m->nodes;
    const double tolerance = STATIC_TOLERANCE * m->scene.settings.newton_tolerance;
    const motion y = {at->u, at->v0, at->v0};
    const bool bars = junctions == SOLVER_JUNCTIONS_AS_IN_SCENE && has_bars(m);
    double size = 0.0, before = INFINITY, mass = bars ? FIRST_MASS : 0.0;
    monitor seen = {0};
    memcpy(at->u0, at->u, values * sizeof(double));
    memset(at->v0, 0, values * sizeof(double));
    for (int iteration = 0; iteration < MAX_STATIC_ITERATIONS; iteration++) {
        element_monitor_start(&seen);
        if (junctions == SOLVER_JUNCTIONS_FIXED) /* the single spans, without devices */
            element_sum_residual(m, t, now, &at->sections, y, true, at->residual, &seen);
        else
            system_residual(m, t, now, at, y, true, at->residual, &seen);
        if (!factor_stiffness(m, now, junctions, at, &mass)) break;
        solver_solve(m, at, junctions, at->residual);
        size = time_correction_size(m, at->residual);
        if (!isfinite(size)) break;
        const double scale = correction_scale(m, at->residual, size);
        for (size_t i = 0; i < values; i++) at->u[i] -= scale * at->residual[i];
        /* quadratic convergence ends in round-off: accept when it no longer improves */
        if (mass > 0.0)
            size = INFINITY;
        else if (size < tolerance ||
                 (size < 10.0 * m->scene.settings.newton_tolerance && size > 0.5 * before)) {
            if (!(seen.worst_excess > 0.0)) return GALLOP_COMPLETED;
            memcpy(at->u, at->u0, values * sizeof(double));
            return time_angle_failure(m, seen.angle_element, seen.worst_angle, t, report);
        }
        before = size;
        mass = mass > FIRST_MASS ? mass / MORE_MASS : 0.0;
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

/* cos of 90 degrees is 0: of a bar that has turned so far, the clamp has moved by sqrt(2) lengths.
 */
static int check_bars(const gallop_model *m, double t, const conditions *now, const double *u,
                      gallop_report *report)
{
    for (int i = 0; i < m->device_count; i++) {
        const device *d = &m->device[i];
        if (!(d->reach > 0.0)) continue;
        const junction *j = &m->junction[d->junction[0]];
        double square = 0.0;
        for (int k = 0; k < 3; k++) {
            const double move =
                j->moved[k] + u[4 * j->node + k] - now->position[3 * d->junction[0] + k];
            square += move * move;
        }
        const double cosine = 1.0 - 0.5 * square / (d->reach * d->reach);
        if (!(cosine > 0.0))
            return report_device(report, i, t, "turn of a string [rad]", acos(fmax(cosine, -1.0)),
                                 0.5 * PI);
    }
    return GALLOP_COMPLETED;
}

/* Where no equilibrium was found beyond a state, the bar that is in compression there is the
 * reason. */
static int no_equilibrium(const gallop_model *m, double t, const conditions *now,
                          const state_view *at, int outcome, gallop_report *report)
{
    const motion y = {at->u, at->v0, at->v0};
    int worst = -1;
    double lowest = 0.0;
    if (report->device >= 0) return outcome;
    memset(at->v0, 0, 4 * (size_t)m->nodes * sizeof(double));
    for (int i = 0; i < m->device_count; i++) {
        if (!(m->device[i].reach > 0.0)) continue;
        const double pull = device_value(m, i, now, y, GALLOP_PULL);
        if (!(pull < lowest)) continue;
        lowest = pull;
        worst = i;
    }
    if (worst < 0) return outcome;
    return report_device(report, worst, t, "pull of a string [N]", lowest, 0.0);
}

#define MIN_LOAD_STEP (1.0 / 1024.0)

int statics_in_steps(const gallop_model *m, double t, const state_view *at, static_load *load,
                     gallop_report *report)
{
    const size_t values = 4 * (size_t)m->nodes;
    double done = 0.0, step = 1.0;
    memset(at->u, 0, values * sizeof(double));
    while (done < 1.0) {
        const double part = done + step < 1.0 ? done + step : 1.0;
        memcpy(at->first, at->u, values * sizeof(double));
        load->apply(load, part, at);
        int outcome = statics_newton(m, t, &load->now, SOLVER_JUNCTIONS_AS_IN_SCENE, at, report);
        if (!outcome) outcome = check_bars(m, t, &load->now, at->u, report);
        if (outcome == GALLOP_COMPLETED) {
            done = part;
            continue;
        }
        memcpy(at->u, at->first, values * sizeof(double));
        if (outcome != GALLOP_EQUILIBRIUM_NOT_FOUND) return outcome;
        step *= 0.5;
        if (step < MIN_LOAD_STEP) return no_equilibrium(m, t, &load->now, at, outcome, report);
    }
    return report_completed(report, t); /* without the load steps that failed on the way */
}

/* Loads, support displacement and wind pressure (so the square of the speed) grow.  Nothing that
 * has weight rests slack, so the way there is taken with the law of the taut cable, whose tangent
 * is never empty; an arch in compression is not found, as its tangent is not positive. */
typedef struct {
    static_load load;
    const gallop_model *model;
    double t;
    bool calm;
} wind_load;

static void apply_wind(static_load *load, double part, const state_view *at)
{
    const wind_load *own = (const wind_load *)load;
    const gallop_model *m = own->model;
    conditions_copy(m, &load->now, &at->now);
    load->now.taut = true;
    load->now.load_factor = own->calm ? 0.0 : part;
    for (int f = 0; f < m->field_count; f++)
        load->now.wind[f] = own->calm ? 0.0 : at->now.wind[f] * sqrt(part);
    for (int i = 0; i < 3 * m->junction_count; i++) load->now.position[i] *= part;
    move_ends(m, own->t, &load->now, at);
}

int statics_equilibrium(const gallop_model *m, double t, bool calm, const state_view *at,
                        gallop_report *report)
{
    wind_load own = {{apply_wind, at->stage[0]}, m, t, calm};
    return statics_in_steps(m, t, at, &own.load, report);
}
