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

/* [rad] of a section of a strung line: it would wind itself up by whole turns otherwise. */
#define MAX_TURN 0.5

/* The factor that keeps a correction of this size small against spans, turns and bars. */
static double correction_scale(const gallop_model *m, const double *correction, double size)
{
    const double longest = MAX_STATIC_CORRECTION * statics_shortest_span(m);
    double scale = size > longest ? longest / size : 1.0;
    if (!m->scene.settings.strung) return scale;
    for (int n = 3; n < 4 * m->nodes; n += 4)
        if (scale * fabs(correction[n]) > MAX_TURN) scale = MAX_TURN / fabs(correction[n]);
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

/* A strung line may have no stiffness where it starts: bars across them before they are under pull;
 * and a negative one on its way.  There the tangent gets a multiple of the mass [1/s^2], as in a
 * backward step in time: so the iteration goes down to a stable equilibrium. */
#define FIRST_MASS 1.0
#define MORE_MASS 4.0
#define LARGEST_MASS 1e8
#define MAX_MASS_ITERATIONS 30

/* Newton-Raphson at rest. */
typedef struct {
    const gallop_model *m;
    const conditions *now;
    const state_view *at;
    solver_junctions junctions;
    bool strung;
    double mass; /* multiple of it in the tangent */
    double size; /* of the last correction, and */
    double before;
    int with_mass; /* iterations that needed mass */
    monitor seen;
} rest_search;

/* Takes the tangent, with as much mass as makes it positive. */
static bool factor_stiffness(rest_search *s)
{
    const motion y = {s->at->u, s->at->v0, s->at->v0};
    while (!solver_factor(s->m, s->now, s->at, y, (tangent_weights){1.0, 0.0, s->mass},
                          s->junctions)) {
        s->mass = s->mass > 0.0 ? MORE_MASS * s->mass : FIRST_MASS;
        if (!s->strung || s->mass > LARGEST_MASS) return false;
    }
    return true;
}

/* The next correction of u. */
static bool correct(rest_search *s, double t)
{
    const state_view *at = s->at;
    const motion y = {at->u, at->v0, at->v0};
    element_monitor_start(&s->seen);
    if (s->junctions == SOLVER_JUNCTIONS_FIXED) /* the single spans, without devices */
        element_sum_residual(s->m, t, s->now, &at->sections, y, true, at->residual, &s->seen);
    else
        system_residual(s->m, t, s->now, at, y, true, at->residual, &s->seen);
    if (!factor_stiffness(s)) return false;
    solver_solve(s->m, at, s->junctions, at->residual);
    s->size = time_correction_size(at->residual, 4 * s->m->nodes);
    if (!isfinite(s->size)) return false;
    const double scale = correction_scale(s->m, at->residual, s->size);
    for (int i = 0; i < 4 * s->m->nodes; i++) at->u[i] -= scale * at->residual[i];
    return true;
}

/* Quadratic convergence ends in round-off: accept when it no longer improves. */
static bool has_converged(const rest_search *s, double tolerance)
{
    const double given = s->m->scene.settings.newton_tolerance;
    return s->mass == 0.0 &&
           (s->size < tolerance || (s->size < 10.0 * given && s->size > 0.5 * s->before));
}

#define INVERSE_ITERATIONS 40

/* The element that moves farthest in the lowest mode of stiffness and mass, by the tangent that was
 * factored last; -1: a body does. */
static int softest_element(rest_search *s, double t)
{
    const gallop_model *m = s->m;
    const int values = 4 * m->nodes;
    double *mode = s->at->first + values, *still = s->at->first + 2 * values;
    const chain *last = &m->chain[m->chain_count - 1];
    int farthest = 0;
    system_residual(m, t, s->now, s->at, (motion){s->at->u, s->at->v0, s->at->v0}, false, still,
                    &s->seen);
    for (int i = 0; i < values; i++) mode[i] = 1.0;
    for (int k = 0; k < INVERSE_ITERATIONS; k++) {
        double *inertia = s->at->residual;
        system_residual(m, t, s->now, s->at, (motion){s->at->u, s->at->v0, mode}, false, inertia,
                        &s->seen);
        for (int i = 0; i < values; i++) inertia[i] -= still[i];
        solver_solve(m, s->at, s->junctions, inertia);
        const double largest = time_correction_size(inertia, 4 * m->nodes);
        for (int i = 0; i < values; i++) mode[i] = inertia[i] / largest;
    }
    for (int i = 0; i < values; i++)
        if (fabs(mode[i]) > fabs(mode[farthest])) farthest = i;
    const int node = farthest / 4;
    if (node >= last->first_node + last->nodes) return -1;
    const chain *c = model_chain_of_node(m, node);
    const int e = (node - c->first_node) / 2;
    return c->first_element + (e < c->elements ? e : c->elements - 1);
}

/* The bar that is pushed most explains why no equilibrium was found; else the place that is soft.
 */
static int explain(rest_search *s, double t, double tolerance, gallop_report *report)
{
    const motion y = {s->at->u, s->at->v0, s->at->v0};
    int worst = -1;
    double lowest = 0.0;
    for (int i = 0; i < s->m->device_count && s->strung; i++) {
        if (!(s->m->device[i].reach > 0.0)) continue;
        const double pull = device_value(s->m, i, s->now, y, GALLOP_PULL);
        if (!(pull < lowest)) continue;
        lowest = pull;
        worst = i;
    }
    if (worst >= 0)
        return report_device(report, worst, t,
                             "a string would be pushed (uplift), pull of a string [N]", lowest,
                             0.0);
    if (s->mass > 0.0 && s->mass <= LARGEST_MASS)
        return report_unstable(report, softest_element(s, t), t);
    return report_failure(report, GALLOP_EQUILIBRIUM_NOT_FOUND, s->seen.slack_element, t, s->size,
                          tolerance);
}

/* Returns 0, or an outcome with u as it was. */
int statics_newton(const gallop_model *m, double t, const conditions *now,
                   solver_junctions junctions, const state_view *at, gallop_report *report)
{
    const size_t bytes = 4 * (size_t)m->nodes * sizeof(double);
    const double tolerance = STATIC_TOLERANCE * m->scene.settings.newton_tolerance;
    const bool strung = m->scene.settings.strung && junctions == SOLVER_JUNCTIONS_AS_IN_SCENE;
    rest_search s = {.m = m, .now = now, .at = at, .junctions = junctions, .strung = strung};
    s.mass = strung ? FIRST_MASS : 0.0;
    s.before = INFINITY;
    memcpy(at->u0, at->u, bytes);
    memset(at->v0, 0, bytes);
    for (int iteration = 0; iteration < MAX_STATIC_ITERATIONS; iteration++) {
        if (!correct(&s, t)) break;
        if (has_converged(&s, tolerance)) {
            if (!(s.seen.worst_excess > 0.0)) return GALLOP_COMPLETED;
            memcpy(at->u, at->u0, bytes);
            return time_angle_failure(&s.seen, t, report);
        }
        s.before = s.mass > 0.0 ? INFINITY : s.size;
        if (s.mass > 0.0 && ++s.with_mass > MAX_MASS_ITERATIONS) break;
        s.mass = s.mass > FIRST_MASS ? s.mass / MORE_MASS : 0.0;
    }
    const int outcome = explain(&s, t, tolerance, report);
    memcpy(at->u, at->u0, bytes);
    return outcome;
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
    junction_gather_all(m, at->residual, 4);
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
        if (step < MIN_LOAD_STEP) return outcome;
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
    conditions_blow(m, false, &load->now);
    for (int i = 0; i < 3 * m->junction_count; i++) load->now.position[i] *= part;
    move_ends(m, own->t, &load->now, at);
}

int statics_equilibrium(const gallop_model *m, double t, bool calm, const state_view *at,
                        gallop_report *report)
{
    wind_load own = {{apply_wind, at->stage[0]}, m, t, calm};
    return statics_in_steps(m, t, at, &own.load, report);
}
