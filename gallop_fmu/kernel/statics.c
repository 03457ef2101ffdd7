/* Statics: the initial equilibrium under gravity (from sag, from horizontal tension, or both held),
 * and equilibrium under wind, loads and support displacement by Newton-Raphson with load stepping.
 */
#include "device.h"
#include "solver.h"
#include "statics.h"
#include "time_integration.h"

typedef struct {
    double scale, lowest, total, shift;
} catenary; /* c = H/w, x1 of the lowest point, length */

/* y = c (cosh((x - x0)/c) - cosh(x0/c)) through (0, 0) and (length, height) */
static catenary catenary_of(double length, double height, double c)
{
    double x0 = 0.5 * length - c * asinh(height / (2.0 * c * sinh(length / (2.0 * c))));
    double shift = sinh(x0 / c);
    return (catenary){c, x0, c * (sinh((length - x0) / c) + shift), shift};
}

static double catenary_sag(const catenary *k, double length, double height)
{
    double y =
        k->scale * (cosh((0.5 * length - k->lowest) / k->scale) - cosh(k->lowest / k->scale));
    return 0.5 * height - y;
}

/* p in sag ~ c^-p near c: 1 on the parabola, about length/(2 c) where the conductor hangs deep */
static double sag_exponent(const gallop_scene *s, double c)
{
    const double step = 1e-4;
    catenary less = catenary_of(s->length, s->height_difference, c * (1.0 - step));
    catenary more = catenary_of(s->length, s->height_difference, c * (1.0 + step));
    double p = log(catenary_sag(&less, s->length, s->height_difference) /
                   catenary_sag(&more, s->length, s->height_difference)) /
               (2.0 * step);
    return p > 1.5 ? p : 1.0;
}

static void place_on_catenary(gallop_model *m, double c)
{
    const gallop_scene *s = &m->scene;
    catenary k = catenary_of(s->length, s->height_difference, c);
    for (int n = 0; n < m->nodes; n++) { /* nodes equally spaced along the conductor */
        double arc = k.total * n / (m->nodes - 1), x = k.lowest + c * asinh(arc / c - k.shift);
        m->x[3 * n] = x;
        m->x[3 * n + 1] = c * (cosh((x - k.lowest) / c) - cosh(k.lowest / c));
        m->x[3 * n + 2] = 0.0;
    }
}

static void place_on_parabola(gallop_model *m)
{
    const gallop_scene *s = &m->scene;
    for (int n = 0; n < m->nodes; n++) { /* nodes equally spaced in x1 */
        double f = (double)n / (m->nodes - 1);
        m->x[3 * n] = f * s->length;
        m->x[3 * n + 1] = f * s->height_difference - 4.0 * s->sag * f * (1.0 - f);
        m->x[3 * n + 2] = 0.0;
    }
}

/* T0 = H / (dx1/dS) at the Gauss points */
static void tension_from_horizontal(gallop_model *m, double horizontal)
{
    for (int e = 0; e < m->elements; e++) {
        geometry *g = &m->geometry[e];
        const double none[2] = {0.0, 0.0};
        element_geometry_from_nodes(g, m->x + 6 * e, none);
        for (int q = 0; q < 2; q++) g->tension[q] = horizontal / g->slope[q][0];
    }
    element_fill_strips(m);
}

static void gravity_forces(const gallop_model *m, double *force)
{
    memset(force, 0, 4 * (size_t)m->nodes * sizeof(double));
    for (int e = 0; e < m->elements; e++) {
        const geometry *g = &m->geometry[e];
        for (int n = 0; n < 3; n++) {
            const double *row = g->shape_product[n]; /* sum over b of int N_a N_b dS = int N_a dS */
            force[8 * e + 4 * n + 1] -= m->mass * m->scene.gravity * (row[0] + row[1] + row[2]);
        }
    }
}

/* The current position becomes the reference; the second Piola-Kirchhoff tension T on p becomes T
 * |p| on p / |p|. */
static void rebase(gallop_model *m, double *u)
{
    for (int e = 0; e < m->elements; e++) {
        double tension[2], x[9];
        element_tension(m, e, u + 8 * e, tension);
        for (int n = 0; n < 3; n++)
            for (int i = 0; i < 3; i++)
                x[3 * n + i] = m->x[6 * e + 3 * n + i] + u[8 * e + 4 * n + i];
        element_geometry_from_nodes(&m->geometry[e], x, tension);
    }
    element_fill_strips(m);
    for (int n = 0; n < m->nodes; n++)
        for (int i = 0; i < 3; i++) m->x[3 * n + i] += u[4 * n + i];
    memset(u, 0, 4 * (size_t)m->nodes * sizeof(double));
}

/* Newton-Raphson at rest.  Returns 0, or an outcome with u as it was. */
static int newton_at_rest(const gallop_model *m, double t, const conditions *now,
                          const bool fixed[2][4], state_view *at, gallop_report *report)
{
    const size_t values = 4 * (size_t)m->nodes;
    const double tolerance = 1e-3 * m->scene.newton_tolerance, longest = 0.05 * m->scene.length;
    const tangent_weights stiffness = {1.0, 0.0, 0.0};
    double size = 0.0, before = INFINITY;
    monitor seen;
    memcpy(at->u0, at->u, values * sizeof(double));
    memset(at->v0, 0, values * sizeof(double));
    for (int iteration = 0; iteration < 60; iteration++) {
        element_monitor_start(&seen);
        element_sum_residual(m, t, now, &at->sections, at->u, at->v0, at->v0, true, at->residual,
                             &seen);
        device_add_springs(m, now, at->u, at->residual);
        if (!solver_factor(m, now, &at->sections, at->u, stiffness, fixed, at->factors)) break;
        solver_solve(m, at->factors, fixed, at->residual);
        size = time_correction_size(m, at->residual);
        if (!isfinite(size)) break;
        double scale = size > longest ? longest / size : 1.0;
        for (size_t i = 0; i < values; i++) at->u[i] -= scale * at->residual[i];
        /* quadratic convergence ends in round-off: accept when it no longer improves */
        if (size < tolerance || (size < 10.0 * m->scene.newton_tolerance && size > 0.5 * before)) {
            if (seen.worst_excess > 0.0) {
                memcpy(at->u, at->u0, values * sizeof(double));
                return time_angle_failure(m, seen.angle_element, seen.worst_angle, t, report);
            }
            return GALLOP_COMPLETED;
        }
        before = size;
    }
    memcpy(at->u, at->u0, values * sizeof(double));
    return report_failure(report, GALLOP_EQUILIBRIUM_NOT_FOUND, seen.slack_element, t, size,
                          tolerance);
}

#define DIFFERENCE_DISPLACEMENT                                                                    \
    1e-6 /* [m] for the derivative of the residual along a displacement of the ends */

/* The ends go to their places, and the nodes between follow by the tangent: an end that moved alone
 * would push its element slack. */
static void place_ends(const gallop_model *m, double t, const conditions *now, state_view *at)
{
    const tangent_weights stiffness = {1.0, 0.0, 0.0};
    const int values = 4 * m->nodes;
    double *move = at->first + values, *before = at->first + 2 * values, largest = 0.0;
    memset(move, 0, (size_t)values * sizeof(double));
    for (int end = 0; end < 2; end++)
        for (int i = 0; i < 3; i++) {
            const int n = (end ? values - 4 : 0) + i;
            if (m->fixed[end][i]) move[n] = now->position[end][i] - at->u[n];
            largest = fmax(largest, fabs(move[n]));
        }
    if (largest == 0.0) return;
    const double part = DIFFERENCE_DISPLACEMENT / largest;
    monitor seen;
    element_monitor_start(&seen);
    memset(at->v0, 0, (size_t)values * sizeof(double));
    element_sum_residual(m, t, now, &at->sections, at->u, at->v0, at->v0, true, before, &seen);
    const bool solvable =
        solver_factor(m, now, &at->sections, at->u, stiffness, m->fixed, at->factors);
    for (int n = 0; n < values; n++) at->u0[n] = at->u[n] + part * move[n];
    element_sum_residual(m, t, now, &at->sections, at->u0, at->v0, at->v0, false, at->residual,
                         &seen);
    for (int n = 0; n < values; n++) at->residual[n] = (at->residual[n] - before[n]) / part;
    if (solvable) solver_solve(m, at->factors, m->fixed, at->residual);
    for (int n = 0; n < values; n++) at->u[n] += move[n] - (solvable ? at->residual[n] : 0.0);
    for (int end = 0; end < 2; end++) /* exactly */
        for (int i = 0; i < 3; i++)
            if (m->fixed[end][i]) at->u[(end ? values - 4 : 0) + i] = now->position[end][i];
}

/* Loads, support displacement and wind pressure (so the square of the speed) grow in steps that
 * halve on failure. Nothing that has weight rests slack, so the way there is taken with the law of
 * the taut cable, whose tangent is never empty; an arch in compression is not found, as its tangent
 * is not positive. */
int statics_equilibrium(const gallop_model *model, double t, const conditions *target,
                        state_view *at, gallop_report *report)
{
    gallop_model taut = *model;
    taut.tension_only = false;
    const gallop_model *m = &taut;
    const size_t values = 4 * (size_t)m->nodes;
    double done = 0.0, step = 1.0;
    memset(at->u, 0, values * sizeof(double));
    while (done < 1.0) {
        double part = done + step < 1.0 ? done + step : 1.0;
        conditions now = *target;
        now.load_factor = part;
        now.wind = target->wind * sqrt(part);
        for (int end = 0; end < 2; end++)
            for (int i = 0; i < 3; i++) now.position[end][i] *= part;
        memcpy(at->first, at->u, values * sizeof(double));
        place_ends(m, t, &now, at);
        int outcome = newton_at_rest(m, t, &now, m->fixed, at, report);
        if (outcome == GALLOP_COMPLETED) {
            done = part;
            continue;
        }
        memcpy(at->u, at->first, values * sizeof(double));
        if (outcome != GALLOP_EQUILIBRIUM_NOT_FOUND) return outcome;
        step *= 0.5;
        if (step < 1.0 / 1024.0) return outcome;
    }
    return report_failure(report, GALLOP_COMPLETED, -1, t, 0.0,
                          0.0); /* forget load steps that failed on the way */
}

/* Solve, rebase, repeat until the reference itself is the equilibrium. */
static int iterate_reference(gallop_model *m, state_view *at, gallop_report *report)
{
    static const bool rigid[2][4] = {{true, true, true, true}, {true, true, true, true}};
    conditions calm;
    memset(&calm, 0, sizeof calm);
    calm.load_factor = 0.0;
    calm.c2 = m->c2;
    calm.c3 = m->c3;
    for (int round = 0; round < 6; round++) {
        gravity_forces(m, m->constant_force);
        memset(at->u, 0, 4 * (size_t)m->nodes * sizeof(double));
        int outcome = newton_at_rest(m, 0.0, &calm, rigid, at, report);
        if (outcome) return outcome;
        double moved = time_correction_size(m, at->u);
        rebase(m, at->u);
        if (moved < 1e-13 * m->scene.length) break;
    }
    return GALLOP_COMPLETED;
}

/* int N'^T T0 X' dS: what the constant forces have to balance in the initial state */
static void internal_forces(const gallop_model *m, double *force)
{
    memset(force, 0, 4 * (size_t)m->nodes * sizeof(double));
    for (int e = 0; e < m->elements; e++) {
        const geometry *g = &m->geometry[e];
        for (int q = 0; q < 2; q++)
            for (int n = 0; n < 3; n++) {
                double w = g->stiffness_weight[q] * g->shape_slope[q][n] * g->tension[q];
                for (int i = 0; i < 3; i++) force[8 * e + 4 * n + i] += w * g->slope[q][i];
            }
    }
}

/* Depth of the mesh below the middle of the chord. */
static double mesh_sag(const gallop_model *m)
{
    const double wanted = 0.5 * m->scene.length;
    int e = 0;
    while (e < m->elements - 1 && m->x[6 * e + 6] < wanted) e++;
    const double *x = m->x + 6 * e;
    double low = -1.0, high = 1.0;
    for (int i = 0; i < 60; i++) {
        double xi = 0.5 * (low + high);
        double at =
            0.5 * xi * (xi - 1.0) * x[0] + (1.0 - xi * xi) * x[3] + 0.5 * xi * (xi + 1.0) * x[6];
        if (at < wanted)
            low = xi;
        else
            high = xi;
    }
    double xi = 0.5 * (low + high);
    return 0.5 * m->scene.height_difference -
           (0.5 * xi * (xi - 1.0) * x[1] + (1.0 - xi * xi) * x[4] + 0.5 * xi * (xi + 1.0) * x[7]);
}

static int solve_for_target(gallop_model *m, state_view *at, gallop_report *report)
{
    const gallop_scene *s = &m->scene;
    const double weight = m->mass * s->gravity;
    const bool by_sag = s->sag > 0.0;
    const double target = by_sag ? s->sag : s->horizontal_tension;
    double c = by_sag ? s->length * hypot(s->length, s->height_difference) / (8.0 * s->sag)
                      : s->horizontal_tension / weight;
    for (int i = 0; by_sag && i < 60; i++) {
        catenary k = catenary_of(s->length, s->height_difference, c);
        c *= pow(catenary_sag(&k, s->length, s->height_difference) / target,
                 1.0 / sag_exponent(s, c));
    }
    /* the catenary's parameter that gives the mesh its target: the two differ only by the mesh
     * error */
    for (int round = 0; round < 12; round++) {
        place_on_catenary(m, c);
        tension_from_horizontal(m, c * weight);
        int outcome = iterate_reference(m, at, report);
        if (outcome) return outcome;
        internal_forces(m, at->residual);
        double ratio = by_sag ? mesh_sag(m) / target : target / fabs(at->residual[0]);
        if (!isfinite(ratio) || !(ratio > 0.0)) break;
        if (fabs(ratio - 1.0) < 1e-12) return GALLOP_COMPLETED;
        c *= by_sag ? pow(ratio, 1.0 / sag_exponent(s, c)) : ratio;
        if (round > 6 && fabs(ratio - 1.0) < 1e-9) return GALLOP_COMPLETED;
    }
    return report_failure(report, GALLOP_EQUILIBRIUM_NOT_FOUND, -1, 0.0, c * weight, target);
}

static double partial_length(const double x[9], double xi)
{
    double length = 0.0; /* from -1 to xi, three-point Gauss */
    const double point[3] = {-0.77459666924148337704, 0.0, 0.77459666924148337704};
    const double weight[3] = {5.0 / 9.0, 8.0 / 9.0, 5.0 / 9.0};
    for (int q = 0; q < 3; q++) {
        double at = -1.0 + 0.5 * (xi + 1.0) * (1.0 + point[q]), square = 0.0;
        for (int i = 0; i < 3; i++) {
            double d = (at - 0.5) * x[i] - 2.0 * at * x[3 + i] + (at + 0.5) * x[6 + i];
            square += d * d;
        }
        length += 0.5 * (xi + 1.0) * weight[q] * sqrt(square);
    }
    return length;
}

static void place_loads(gallop_model *m)
{
    for (int l = 0; l < m->load_count; l++) {
        double wanted = m->place[l].shape[0] * m->derived.length,
               passed = 0.0; /* fraction left by model_create.c */
        int e = 0;
        for (; e < m->elements - 1; e++) {
            double own = partial_length(m->x + 6 * e, 1.0);
            if (passed + own >= wanted) break;
            passed += own;
        }
        double low = -1.0, high = 1.0;
        for (int i = 0; i < 60; i++) {
            double middle = 0.5 * (low + high);
            if (passed + partial_length(m->x + 6 * e, middle) < wanted)
                low = middle;
            else
                high = middle;
        }
        double xi = 0.5 * (low + high);
        m->place[l] = (load_place){
            m->place[l].load, e, {0.5 * xi * (xi - 1.0), 1.0 - xi * xi, 0.5 * xi * (xi + 1.0)}};
    }
}

int statics_initial(gallop_model *m, gallop_report *report)
{
    const gallop_scene *s = &m->scene;
    const bool held = s->sag > 0.0 && s->horizontal_tension > 0.0;
    const int last = m->nodes - 1;
    gallop_state *work = calloc(1, m->state_size); /* still within create */
    if (!work)
        return report_failure(report, GALLOP_OUT_OF_MEMORY, -1, 0.0, (double)m->state_size, 0.0);
    state_view at = state_view_of(m, work);
    int outcome = GALLOP_COMPLETED;
    if (held) {
        place_on_parabola(m);
        tension_from_horizontal(m, s->horizontal_tension);
    } else {
        outcome = solve_for_target(m, &at, report);
    }
    if (outcome == GALLOP_COMPLETED) {
        gallop_derived *d = &m->derived;
        gravity_forces(m, at.residual);
        internal_forces(m, m->constant_force);
        for (int i = 4; i < 4 * last; i++)
            d->imbalance = fmax(d->imbalance, fabs(m->constant_force[i] - at.residual[i]));
        for (int i = 0; i < 3; i++) {
            m->static_force[0][i] = m->constant_force[i] - at.residual[i];
            m->static_force[1][i] = m->constant_force[4 * last + i] - at.residual[4 * last + i];
            d->support_force[0][i] = -m->static_force[0][i];
            d->support_force[1][i] = -m->static_force[1][i];
        }
        d->sag = mesh_sag(m);
        d->horizontal_tension = held ? s->horizontal_tension : fabs(m->static_force[0][0]);
        for (int e = 0; e < m->elements; e++) {
            const double *part = m->geometry[e].inertia_weight;
            d->length += part[0] + part[1] + part[2];
        }
        place_loads(m);
        element_normals_at_nodes(m);
    }
    free(work);
    return outcome;
}
