/* The initial equilibrium under gravity: from sag, from horizontal tension, or both held. */
#include "statics.h"

#include "base_glibc.h"
#include "base_math.h"
#include "device.h"
#include "report.h"
#include "time_integration.h"

#define BISECTIONS 60 /* more than a double has bits */

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
static double sag_exponent(const chain *s, double c)
{
    const double step = 1e-4;
    catenary less = catenary_of(s->span, s->rise, c * (1.0 - step));
    catenary more = catenary_of(s->span, s->rise, c * (1.0 + step));
    double p = log(catenary_sag(&less, s->span, s->rise) / catenary_sag(&more, s->span, s->rise)) /
               (2.0 * step);
    return p > 1.5 ? p : 1.0;
}

/* Places the nodes from corner `from` to corner `to`, equally spaced along the conductor between
 * two fractions of its length. */
static void place_part(chain *s, const catenary *k, const double origin[3], const int corner[2],
                       const double fraction[2])
{
    const int first = 2 * corner[0], last = 2 * corner[1];
    const double start = k->total * fraction[0], length = k->total * (fraction[1] - fraction[0]);
    for (int n = first; n <= last; n++) {
        const double arc = start + length * (n - first) / (last - first);
        const double x = k->lowest + k->scale * asinh(arc / k->scale - k->shift);
        s->x[3 * n] = origin[0] + x;
        s->x[3 * n + 1] =
            origin[1] + k->scale * (cosh((x - k->lowest) / k->scale) - cosh(k->lowest / k->scale));
        s->x[3 * n + 2] = origin[2];
    }
}

static void place_on_catenary(const gallop_model *m, chain *s, double c)
{
    const int index = (int)(s - m->chain);
    const double *origin = m->junction[s->junction[0]].position;
    const catenary k = catenary_of(s->span, s->rise, c);
    int corner[2] = {0, 0};
    double fraction[2] = {0.0, 0.0};
    for (int i = 0; i < m->scene.station_count; i++) {
        const gallop_station *station = &m->scene.station[i];
        if (station->chain != index) continue;
        corner[1] = station->corner;
        fraction[1] = station->position;
        place_part(s, &k, origin, corner, fraction);
        corner[0] = corner[1];
        fraction[0] = fraction[1];
    }
    corner[1] = s->elements;
    fraction[1] = 1.0;
    place_part(s, &k, origin, corner, fraction);
}

/* Length of the parabola from its start to the fraction f of the span: its slope at f is
 * (rise - 4 sag (1 - 2 f)) / span, and the length to a slope p from the lowest point is
 * (p sqrt(1 + p^2) + asinh p) span^2 / (16 sag). */
static double parabola_length(const chain *s, double f)
{
    double length = 0.0;
    for (int end = 0; end < 2; end++) {
        const double p = (s->rise - 4.0 * s->target_sag * (1.0 - 2.0 * (end ? f : 0.0))) / s->span;
        const double to = p * sqrt(1.0 + p * p) + asinh(p);
        length += end ? to : -to;
    }
    return length * s->span * s->span / (16.0 * s->target_sag);
}

/* The fraction of the span at a fraction of the parabola's length. */
static double parabola_place(const chain *s, double fraction)
{
    const double wanted = fraction * parabola_length(s, 1.0);
    double low = 0.0, high = 1.0;
    for (int i = 0; i < BISECTIONS; i++) {
        const double middle = 0.5 * (low + high);
        if (parabola_length(s, middle) < wanted)
            low = middle;
        else
            high = middle;
    }
    return 0.5 * (low + high);
}

/* Places the nodes from corner `from` to corner `to`, equally spaced in x1 between two fractions
 * of the span. */
static void place_part_on_parabola(chain *s, const double origin[3], const int corner[2],
                                   const double fraction[2])
{
    const int first = 2 * corner[0], last = 2 * corner[1];
    for (int n = first; n <= last; n++) {
        const double f =
            fraction[0] + (fraction[1] - fraction[0]) * (double)(n - first) / (last - first);
        s->x[3 * n] = origin[0] + f * s->span;
        s->x[3 * n + 1] = origin[1] + f * s->rise - 4.0 * s->target_sag * f * (1.0 - f);
        s->x[3 * n + 2] = origin[2];
    }
}

static void place_on_parabola(const gallop_model *m, chain *s)
{
    const double *origin = m->junction[s->junction[0]].position;
    const int index = (int)(s - m->chain);
    int corner[2] = {0, 0};
    double fraction[2] = {0.0, 0.0};
    for (int i = 0; i < m->scene.station_count; i++) {
        const gallop_station *station = &m->scene.station[i];
        if (station->chain != index) continue;
        corner[1] = station->corner;
        fraction[1] = parabola_place(s, station->position);
        place_part_on_parabola(s, origin, corner, fraction);
        corner[0] = corner[1];
        fraction[0] = fraction[1];
    }
    corner[1] = s->elements;
    fraction[1] = 1.0;
    place_part_on_parabola(s, origin, corner, fraction);
}

static void fill_strips(gallop_model *m, const chain *c)
{
    for (int i = 0; i < c->intervals; i++) element_fill_strips(&m->interval[c->first_interval + i]);
}

/* T0 = H / (dx1/dS) at the Gauss points */
static void tension_from_horizontal(gallop_model *m, chain *c, double horizontal)
{
    for (int e = 0; e < c->elements; e++) {
        geometry *g = &c->geometry[e];
        const double none[2] = {0.0, 0.0};
        element_geometry_from_nodes(g, c->x + 6 * e, none);
        for (int q = 0; q < 2; q++) g->tension[q] = horizontal / g->slope[q][0];
    }
    fill_strips(m, c);
}

#define MAX_REFERENCE_ROUNDS 6
#define SETTLED 1e-13 /* of the shortest span */

/* Solve, rebase, repeat until the reference itself is the equilibrium. */
static int iterate_reference(gallop_model *m, const state_view *at, gallop_report *report)
{
    conditions calm = at->stage[0];
    statics_calm(m, &calm);
    for (int round = 0; round < MAX_REFERENCE_ROUNDS; round++) {
        statics_weights(m, 0.0, m->constant_force);
        memset(at->u, 0, 4 * (size_t)m->nodes * sizeof(double));
        const int outcome = statics_newton(m, 0.0, &calm, SOLVER_JUNCTIONS_FIXED, at, report);
        if (outcome) return outcome;
        const double moved = time_correction_size(at->u, 4 * m->nodes);
        statics_rebase(m, at->u);
        if (moved < SETTLED * statics_shortest_span(m)) break;
    }
    return GALLOP_COMPLETED;
}

/* The catenary's parameter for the target of a chain. */
static double first_parameter(const chain *c)
{
    if (!(c->target_sag > 0.0)) return c->target_tension / c->weight;
    double parameter = c->span * hypotenuse(c->span, c->rise) / (8.0 * c->target_sag);
    for (int i = 0; i < BISECTIONS; i++) {
        catenary k = catenary_of(c->span, c->rise, parameter);
        parameter *= pow(catenary_sag(&k, c->span, c->rise) / c->target_sag,
                         1.0 / sag_exponent(c, parameter));
    }
    return parameter;
}

#define MAX_TARGET_ROUNDS 12
#define TARGET_MET 1e-12
#define TARGET_NEARLY_MET 1e-9 /* good enough after half of the rounds */

/* The factor by which the mesh of a chain is away from its target; 1: met. */
static double miss_ratio(const gallop_model *m, const chain *c, const double *force)
{
    return c->target_sag > 0.0 ? statics_mesh_sag(m, c) / c->target_sag
                               : c->target_tension / fabs(force[4 * c->first_node]);
}

/* Improves the parameter of a chain's catenary; returns how far the mesh was away from the target,
 * infinite where there is no such number. */
static double improve_parameter(const gallop_model *m, chain *c, const double *force)
{
    const double ratio = miss_ratio(m, c, force), miss = fabs(ratio - 1.0);
    if (!isfinite(ratio) || !(ratio > 0.0)) return INFINITY;
    if (miss < TARGET_MET) return miss;
    c->parameter *= c->target_sag > 0.0 ? pow(ratio, 1.0 / sag_exponent(c, c->parameter)) : ratio;
    return miss;
}

/* Places the chains on catenaries whose meshes have the targets of sag or tension; catenary and
 * mesh differ only by the mesh error. */
static int solve_for_targets(gallop_model *m, const state_view *at, gallop_report *report)
{
    const chain *worst = m->chain;
    for (int i = 0; i < m->chain_count; i++) m->chain[i].parameter = first_parameter(&m->chain[i]);
    for (int round = 0; round < MAX_TARGET_ROUNDS; round++) {
        for (int i = 0; i < m->chain_count; i++) {
            chain *c = &m->chain[i];
            place_on_catenary(m, c, c->parameter);
            tension_from_horizontal(m, c, c->parameter * c->weight);
        }
        const int outcome = iterate_reference(m, at, report);
        if (outcome) return outcome;
        statics_internal_forces(m, at->residual);
        double largest = 0.0;
        for (int i = 0; i < m->chain_count; i++) {
            const double miss = improve_parameter(m, &m->chain[i], at->residual);
            if (miss > largest) worst = &m->chain[i];
            largest = fmax(largest, miss);
        }
        if (!isfinite(largest)) break;
        if (largest < TARGET_MET) return GALLOP_COMPLETED;
        if (round > MAX_TARGET_ROUNDS / 2 && largest < TARGET_NEARLY_MET) return GALLOP_COMPLETED;
    }
    return report_failure(report, GALLOP_EQUILIBRIUM_NOT_FOUND, -1, 0.0,
                          worst->parameter * worst->weight,
                          worst->target_sag > 0.0 ? worst->target_sag : worst->target_tension);
}

/* Length of the part of an element from xi = -1 on [m]. */
static double partial_length(const double x[9], double xi)
{
    double length = 0.0;
    for (int q = 0; q < 3; q++) {
        const double at = -1.0 + 0.5 * (xi + 1.0) * (1.0 + element_gauss3[q]);
        double square = 0.0;
        for (int i = 0; i < 3; i++) {
            const double d = (at - 0.5) * x[i] - 2.0 * at * x[3 + i] + (at + 0.5) * x[6 + i];
            square += d * d;
        }
        length += 0.5 * (xi + 1.0) * element_gauss3_weight[q] * sqrt(square);
    }
    return length;
}

/* The directions of the cable at its nodes; none where junctions lie. */
static void measure_chords(gallop_model *m)
{
    for (int i = 0; i < m->chain_count; i++) {
        const chain *c = &m->chain[i];
        int next = 0;
        for (int n = 0; n < c->nodes; n++) {
            double *chord = m->chord + 4 * (size_t)(c->first_node + n), square = 0.0;
            double *inverse = m->chord_inverse + 4 * (size_t)(c->first_node + n);
            if (n == 2 * c->kept[next].corner) {
                next++;
                continue;
            }
            for (int k = 0; k < 3; k++) {
                chord[k] = c->x[3 * (n + 1) + k] - c->x[3 * (n - 1) + k];
                square += chord[k] * chord[k];
            }
            for (int k = 0; k < 3; k++) inverse[k] = 1.0 / sqrt(square);
        }
    }
}

/* Adds a loaded point to the nodal forces of its load. */
static void add_point(gallop_model *m, const load_place *place)
{
    const gallop_load *load = &m->scene.load[place->load];
    nodal_load *of = &m->nodal_load[place->load];
    const int node = m->chain[place->chain].first_node;
    const int own = 4 * (node + 2 * place->element);
    of->first = load->evenly_spaced > 0 ? 4 * node : own;
    double *force = of->force + (own - of->first);
    for (int n = 0; n < 3; n++) {
        for (int i = 0; i < 3; i++) force[4 * n + i] += place->shape[n] * load->force[i];
        force[4 * n + 3] += place->shape[n] * load->torque;
    }
}

/* The fraction of the conductor's length at which a loaded point lies becomes an element and its
 * shape functions. */
static void place_loads(gallop_model *m)
{
    for (int l = 0; l < m->load_count; l++) {
        load_place *place = &m->place[l];
        const chain *c = &m->chain[place->chain];
        const double wanted = place->fraction * c->length;
        double passed = 0.0;
        int e = 0;
        for (; e < c->elements - 1; e++) {
            const double own = partial_length(c->x + 6 * e, 1.0);
            if (passed + own >= wanted) break;
            passed += own;
        }
        double low = -1.0, high = 1.0;
        for (int i = 0; i < BISECTIONS; i++) {
            const double middle = 0.5 * (low + high);
            if (passed + partial_length(c->x + 6 * e, middle) < wanted)
                low = middle;
            else
                high = middle;
        }
        const double xi = 0.5 * (low + high);
        place->element = e;
        place->shape[0] = 0.5 * xi * (xi - 1.0);
        place->shape[1] = 1.0 - xi * xi;
        place->shape[2] = 0.5 * xi * (xi + 1.0);
        add_point(m, place);
    }
}

/* Stations are where the strung chains put them. */
static void place_stations(gallop_model *m)
{
    for (int i = 0; i < m->chain_count; i++)
        for (int k = 1; k < m->chain[i].kept_corners - 1; k++) {
            const chain *c = &m->chain[i];
            memcpy(m->junction[c->kept[k].junction].position, c->x + 6 * c->kept[k].corner,
                   3 * sizeof(double));
        }
}

int statics_initial(gallop_model *m, gallop_report *report)
{
    gallop_state *work = calloc(1, m->state_size); /* still within create */
    if (!work)
        return report_failure(report, GALLOP_OUT_OF_MEMORY, -1, 0.0, (double)m->state_size, 0.0);
    const state_view at = state_view_of(m, work);
    time_start_sheddings(m, &at);
    int outcome = GALLOP_COMPLETED;
    if (statics_is_held(&m->chain[0]))
        for (int i = 0; i < m->chain_count; i++) {
            chain *c = &m->chain[i];
            place_on_parabola(m, c);
            tension_from_horizontal(m, c, c->target_tension);
        }
    else
        outcome = solve_for_targets(m, &at, report);
    if (!outcome) {
        place_stations(m);
        device_prepare_all(m);
        if (m->scene.settings.strung) outcome = statics_load(m, &at, report);
    }
    if (!outcome) {
        statics_derive(m, &at);
        place_loads(m);
        measure_chords(m);
    }
    free(work);
    return outcome;
}
