/* Three-node cable element with twist and eccentric ice (Liu et al. 2009, eq. 5-18), updated
 * Lagrangian: everything is evaluated on the current configuration x = X + u; the tension carries
 * the total axial Green strain from the initial equilibrium, so it cannot drift. */
#include "base_math.h"
#include "element.h"
#include "law.h"

#define ROOT_3_5 0.77459666924148337704
#define ROOT_1_3 0.57735026918962576451

#define STRIPS_AT_ONCE 8 /* whose intermediate results stay in the first-level cache */

const double element_gauss2[2] = {-ROOT_1_3, ROOT_1_3};
const double element_gauss3[3] = {-ROOT_3_5, 0.0, ROOT_3_5};
const double element_gauss3_weight[3] = {5.0 / 9.0, 8.0 / 9.0, 5.0 / 9.0};

/* N = (xi (xi - 1) / 2, 1 - xi^2, xi (xi + 1) / 2), paper eq. (5), at the three-point Gauss
 * abscissae */
const double element_shape3[3][3] = {{0.5 * (0.6 + ROOT_3_5), 0.4, 0.5 * (0.6 - ROOT_3_5)},
                                     {0.0, 1.0, 0.0},
                                     {0.5 * (0.6 - ROOT_3_5), 0.4, 0.5 * (0.6 + ROOT_3_5)}};

void element_tension(const interval *c, int e, bool tension_only, const double u[12],
                     double tension[2])
{
    const geometry *g = &c->geometry[e];
    for (int q = 0; q < 2; q++) {
        const double *n = g->shape_slope[q];
        double strain = 0.0, square = 0.0;
        for (int i = 0; i < 3; i++) {
            double du = n[0] * u[i] + n[1] * u[4 + i] + n[2] * u[8 + i];
            strain += du * (g->slope[q][i] + 0.5 * du);
            square += (g->slope[q][i] + du) * (g->slope[q][i] + du);
        }
        tension[q] = g->tension[q] + c->section->axial_stiffness * strain;
        if (tension_only) tension[q] = fmax(tension[q], 0.0);
        tension[q] *= sqrt(
            square); /* T acts on p, whose length is the stretch: the force in the cable is T |p| */
    }
}

/* Tensions at u, where forces were balanced elsewhere. */
void element_monitor_tensions(const gallop_model *model, int half, const conditions *now,
                              const double *u, monitor *seen)
{
    const int *range = model->half[half].interval;
    for (int i = range[0]; i < range[1]; i++) {
        const interval *c = &model->interval[i];
        const exposure on = conditions_on(model, now, c);
        for (int e = 0; e < c->elements; e++) {
            double tension[2];
            element_tension(c, e, on.tension_only, u + 4 * c->first_node + 8 * e, tension);
            const double lowest = fmin(tension[0], tension[1]);
            if (!(lowest < seen->lowest_tension)) continue;
            seen->lowest_tension = lowest;
            seen->slack_element = c->first_element + e;
        }
    }
}

void element_monitor_start(monitor *seen)
{
    *seen = (monitor){INFINITY, 0.0, 0.0, -1, -1, NULL};
}

void element_monitor_add(monitor *seen, const monitor *later)
{
    if (later->lowest_tension < seen->lowest_tension) {
        seen->lowest_tension = later->lowest_tension;
        seen->slack_element = later->slack_element;
    }
    if (later->worst_excess > seen->worst_excess) {
        seen->worst_excess = later->worst_excess;
        seen->worst_angle = later->worst_angle;
        seen->angle_element = later->angle_element;
        seen->curve = later->curve;
    }
}

/* First mass moments turn with the section, in its plane; the omega^2 terms, missing in the paper,
 * conserve energy.  Two loops, as for attack_angles. */
INLINE void ice_inertia(const exposure *now, const sections *at, int first, int last)
{
    const double m2 = now->c2, m3 = now->c3;
    const double *theta = at->theta, *omega = at->omega, *omega_rate = at->omega_rate,
                 *gravity = at->gravity;
    const double *a2 = at->a2, *a3 = at->a3;
    double *c2 = at->c2, *c3 = at->c3;
    double *f2 = at->force[0], *f3 = at->force[1], *twist = at->force[2];
    INDEPENDENT
    for (int i = first; i < last; i++) {
        double sine, cosine;
        sine_cosine(theta[i], &sine, &cosine);
        c2[i] = m2 * cosine - m3 * sine;
        c3[i] = m2 * sine + m3 * cosine;
    }
    INDEPENDENT
    for (int i = first; i < last; i++) {
        const double square = omega[i] * omega[i];
        f2[i] = -c3[i] * omega_rate[i] - c2[i] * square;
        f3[i] = c2[i] * omega_rate[i] - c3[i] * square;
        twist[i] = c2[i] * a3[i] - c3[i] * a2[i] - gravity[i] * (c3[i] - m3);
    }
}
PATHS(ice_inertia, (const exposure *now, const sections *at, int first, int last),
      (now, at, first, last))

void element_ice_inertia(const exposure *now, const sections *at, int count)
{
    ON_PATH(now->fused, ice_inertia)(now, at, 0, count);
}

/* One unknown of the nodes at the three sections of a strip; the second one lies at the middle
 * node. */
INLINE void interpolate(lanes y[3][4], int unknown, double *out)
{
    const lanes left = y[0][unknown], middle = y[1][unknown], right = y[2][unknown];
    for (int q = 0; q < 3; q += 2)
        *(lanes *)(out + LANES * q) = element_shape3[q][0] * left + element_shape3[q][1] * middle +
                                      element_shape3[q][2] * right;
    *(lanes *)(out + LANES) = middle;
}

/* The component along n2 at the three sections of a strip. */
INLINE void along_normal(const strip *s, lanes y[3][4], double *out)
{
    double along[2][3 * LANES];
    for (int i = 0; i < 2; i++) interpolate(y, i, along[i]);
    for (int q = 0; q < 3; q++)
        *(lanes *)(out + LANES * q) = s->normal[q][0] * LANES_AT(along[0] + LANES * q) +
                                      s->normal[q][1] * LANES_AT(along[1] + LANES * q);
}

/* Motion of the nodes of a strip. */
typedef struct {
    lanes u[3][4], v[3][4], a[3][4];
} strip_motion;

INLINE void read_motion(motion y, int count, strip_motion *of)
{
    for (int n = 0; n < 3; n++) {
        read_nodes(y.u, n, count, of->u[n]);
        read_nodes(y.v, n, count, of->v[n]);
        read_nodes(y.a, n, count, of->a[n]);
    }
}

/* From then on the velocities of the sections of a strip are those relative to the air. */
INLINE void subtract_air(const interval *c, const exposure *now, const strip *s, const sections *at,
                         int first)
{
    const ptrdiff_t own = 3 * LANES * (s - c->strip);
    for (int q = 0; q < 3 * LANES; q += LANES) {
        *(lanes *)(at->v2 + first + q) -= *(const lanes *)(now->air[0] + own + q);
        *(lanes *)(at->v3 + first + q) -= *(const lanes *)(now->air[1] + own + q);
    }
}

INLINE void section_motion(const interval *c, const exposure *now, const strip *s,
                           const sections *at, int first, strip_motion *y)
{
    along_normal(s, y->v, at->v2 + first);
    interpolate(y->v, 2, at->v3 + first);
    if (now->air[0]) subtract_air(c, now, s, at, first);
    interpolate(y->u, 3, at->theta + first);
    interpolate(y->v, 3, at->omega + first);
    if (!now->section->eccentric) return;
    along_normal(s, y->a, at->a2 + first);
    interpolate(y->a, 2, at->a3 + first);
    interpolate(y->a, 3, at->omega_rate + first);
    for (int q = 0; q < 3; q++)
        *(lanes *)(at->gravity + first + LANES * q) = c->gravity * s->normal[q][1];
}

/* Lowest tension so far, lane by lane, and the first element of the strip where it was; `element`:
 * that of the strip at work. */
typedef struct {
    lanes tension, where;
    double element;
} lowest;

/* Inertia and the damping in proportion to it. */
INLINE void add_inertia(const cross_section *c, const strip *s, lanes v[3][4], lanes a[3][4],
                        int unknowns, lanes r[3][4])
{
    const double *b = c->translation_damping, *bt = c->twist_damping;
    for (int i = 0; i < unknowns; i++) {
        const double mass = i < 3 ? c->mass : c->inertia, drag = i < 3 ? b[0] : bt[0];
        lanes rate[3];
        for (int n = 0; n < 3; n++) rate[n] = mass * (a[n][i] + drag * v[n][i]);
        r[0][i] = s->product[0] * rate[0] + s->product[1] * rate[1] + s->product[2] * rate[2];
        r[1][i] = s->product[1] * rate[0] + s->product[3] * rate[1] + s->product[4] * rate[2];
        r[2][i] = s->product[2] * rate[0] + s->product[4] * rate[1] + s->product[5] * rate[2];
    }
}

/* The derivative along S of the unknowns of the nodes y at stiffness point q. */
INLINE void slopes_of(const strip *s, int q, lanes y[3][4], int unknowns, lanes slope[4])
{
    const lanes *n = s->shape_slope[q];
    for (int i = 0; i < unknowns; i++)
        slope[i] = n[0] * (y[0][i] - y[1][i]) + n[1] * (y[2][i] - y[1][i]);
}

/* Adds the damping in proportion to the stiffness of the initial state. */
INLINE void add_stiffness_damping(const cross_section *c, const strip *s, int q, lanes v[3][4],
                                  int unknowns, lanes force[4])
{
    const double ea = c->axial_stiffness, gj = c->torsional_stiffness;
    const double *b = c->translation_damping, *bt = c->twist_damping;
    const int axes = unknowns < 3 ? unknowns : 3;
    const lanes *p0 = s->slope[q];
    lanes dv[4], axial = {0.0};
    slopes_of(s, q, v, unknowns, dv);
    for (int i = 0; i < axes; i++) axial += p0[i] * dv[i];
    axial *= b[1] * ea;
    for (int i = 0; i < axes; i++) force[i] += axial * p0[i] + b[1] * s->tension[q] * dv[i];
    if (unknowns == 4) force[3] += gj * bt[1] * dv[3];
}

/* From the initial equilibrium: eps = X'.u' + u'.u'/2; T = T0 + EA eps */
INLINE void green_strain(const lanes p0[3], const lanes du[3], int axes, lanes *strain)
{
    *strain = (lanes){0.0};
    for (int i = 0; i < axes; i++) *strain += du[i] * (p0[i] + 0.5 * du[i]);
}

INLINE void note_tension(const lanes *tension, lowest *low)
{
    low->where = PICK(*tension < low->tension, low->element + (lanes){0.0}, low->where);
    low->tension = PICK(*tension < low->tension, *tension, low->tension);
}

/* Inertia, damping, tension and torsion of the elements of a strip. */
INLINE void strip_forces(const exposure *now, const strip *s, strip_motion *y, int unknowns,
                         lanes r[3][4], lowest *low)
{
    const double ea = now->section->axial_stiffness, gj = now->section->torsional_stiffness;
    const int axes = unknowns < 3 ? unknowns : 3;
    add_inertia(now->section, s, y->v, y->a, unknowns, r);
    for (int q = 0; q < 2; q++) {
        const lanes *p0 = s->slope[q];
        lanes du[4], force[4], strain, tension;
        slopes_of(s, q, y->u, unknowns, du);
        green_strain(p0, du, axes, &strain);
        tension = s->tension[q] + ea * strain;
        if (now->tension_only) tension = PICK(tension > 0.0, tension, (lanes){0.0});
        note_tension(&tension, low);
        for (int i = 0; i < axes; i++) force[i] = tension * (p0[i] + du[i]);
        if (unknowns == 4) force[3] = gj * du[3];
        add_stiffness_damping(now->section, s, q, y->v, unknowns, force);
        for (int i = 0; i < unknowns; i++) {
            const lanes left = s->pull[q][0] * force[i], right = s->pull[q][1] * force[i];
            r[0][i] += left;
            r[1][i] -= left + right;
            r[2][i] += right;
        }
    }
}

INLINE void add_section_forces(const strip *s, const sections *at, int first, lanes r[3][4])
{
    for (int i = 0; i < 4; i++) {
        lanes f[3];
        for (int q = 0; q < 3; q++) {
            f[q] = *(const lanes *)(at->force[i < 2 ? 0 : i - 1] + first + LANES * q);
            if (i < 2) f[q] *= s->normal[q][i];
        }
        r[0][i] += s->share[0][0] * f[0] + s->share[2][0] * f[2];
        r[1][i] += s->share[0][1] * f[0] + s->share[1][1] * f[1] + s->share[2][1] * f[2];
        r[2][i] += s->share[0][2] * f[0] + s->share[2][2] * f[2];
    }
}

/* Forces at sections whose motion is known: inertia of the eccentric ice minus aerodynamics. */
static void section_forces(const interval *c, const exposure *now, const sections *at, int first,
                           int last, bool slopes)
{
    if (now->section->eccentric)
        ON_PATH(now->fused, ice_inertia)(now, at, first, last);
    else
        for (int i = 0; i < 3; i++)
            memset(at->force[i] + first, 0, (size_t)(last - first) * sizeof(double));
    if (now->blows) element_aero_loads(c, now, at, first, last - first, slopes);
}

/* The worst angle outside the curve's range, of the sections on which the wind matters. */
static void look_at_angles(const interval *c, const exposure *now, const sections *at, int first,
                           int last, int first_element, monitor *seen)
{
    if (now->section->curve->outside != GALLOP_OUTSIDE_ERROR) return;
    lanes all = {0.0};
    double sum = 0.0;
    for (int i = first; i < last; i += LANES) all += *(const lanes *)(at->excess + i);
    for (int k = 0; k < LANES; k++) sum += LANE(all, k);
    if (!(sum > 0.0)) return;
    for (int i = first; i < last; i++) {
        const int e = first_element + (i - first) / (3 * LANES) * LANES + i % LANES;
        if (!(at->excess[i] > seen->worst_excess) || e >= c->elements) continue;
        if (!element_wind_matters(c, now, at, i)) continue;
        seen->worst_excess = at->excess[i];
        seen->worst_angle = at->angle[i];
        seen->angle_element = c->first_element + e;
        seen->curve = now->section->curve;
    }
}

/* What is evaluated: the forces of an interval, added to `residual`. */
typedef struct {
    const interval *interval;
    const exposure *now;
    const sections *at;
    motion y;
    bool slopes;
    int slot; /* without slopes: strip of `at` whose place is used */
    double *residual;
    monitor *seen;
} evaluation;

/* `strips` strips from `start`, no more than STRIPS_AT_ONCE.  Section forces go to the arrays of
 * `at`: with slopes to the place of the strip, as the tangent reads them, else to that of `slot`.
 */
INLINE void strips_residual(const evaluation *of, int start, int strips, int unknowns, lowest *low)
{
    const interval *c = of->interval;
    const exposure *now = of->now;
    const sections *at = of->at;
    const int slot = of->slopes ? c->first_strip + start : of->slot;
    const bool sectional = unknowns == 4 && (now->section->eccentric || now->blows);
    lanes r[STRIPS_AT_ONCE][3][4];

    /* inertia, damping and tension; the motion of the sections */
    for (int k = 0; k < strips; k++) {
        const int e = LANES * (start + k), count = c->elements - e;
        const strip *s = &c->strip[start + k];
        const motion of_strip = {of->y.u + 8 * e, of->y.v + 8 * e, of->y.a + 8 * e};
        strip_motion y;
        read_motion(of_strip, count, &y);
        low->element = e;
        strip_forces(now, s, &y, unknowns, r[k], low);
        if (sectional) section_motion(c, now, s, at, 3 * LANES * (slot + k), &y);
    }

    if (sectional) {
        const int first = 3 * LANES * slot, last = first + 3 * LANES * strips;
        section_forces(c, now, at, first, last, of->slopes);
        if (now->blows) look_at_angles(c, now, at, first, last, LANES * start, of->seen);
    }

    for (int k = 0; k < strips; k++) {
        const int e = LANES * (start + k), count = c->elements - e;
        if (sectional) add_section_forces(&c->strip[start + k], at, 3 * LANES * (slot + k), r[k]);
        for (int n = 0; n < 3; n++) {
            for (int i = unknowns; i < 4; i++) r[k][n][i] = (lanes){0.0};
            add_to_nodes(of->residual + 8 * e, n, count, r[k][n]);
        }
    }
}

INLINE void interval_residual(const evaluation *of, int unknowns)
{
    const interval *c = of->interval;
    monitor *seen = of->seen;
    lowest low;
    for (int k = 0; k < LANES; k++) LANE(low.tension, k) = LANE(low.where, k) = INFINITY;
    for (int start = 0; start < c->strips; start += STRIPS_AT_ONCE) {
        const int left = c->strips - start;
        strips_residual(of, start, left < STRIPS_AT_ONCE ? left : STRIPS_AT_ONCE, unknowns, &low);
    }
    for (int k = 0; k < LANES; k++)
        if (LANE(low.tension, k) < seen->lowest_tension) {
            const int e = (int)LANE(low.where, k) + k;
            seen->lowest_tension = LANE(low.tension, k);
            seen->slack_element = c->first_element + (e < c->elements ? e : c->elements - 1);
        }
}

INLINE void interval_of_2(const evaluation *of)
{
    interval_residual(of, 2);
}
PATHS(interval_of_2, (const evaluation *of), (of))

INLINE void interval_of_4(const evaluation *of)
{
    interval_residual(of, 4);
}
PATHS(interval_of_4, (const evaluation *of), (of))

void element_add_lost_forces(const interval *c, int e, const exposure *now, double factor,
                             double force[12])
{
    const geometry *g = &c->geometry[e];
    for (int n = 0; n < 3; n++) {
        const double *row = g->shape_product[n]; /* sum over b of int N_a N_b dS = int N_a dS */
        force[4 * n + 1] += factor * now->lost_weight * (row[0] + row[1] + row[2]);
        for (int q = 0; q < 3; q++)
            force[4 * n + 3] -= factor * now->lost_moment * g->normal[q][1] * g->inertia_weight[q] *
                                element_shape3[q][n];
    }
}

/* Residuals begin with the constant forces. */
TWO_PATHS static void start_residual(const double *restrict constant, int values,
                                     double *restrict residual)
{
    for (int i = 0; i < values; i++) residual[i] = -constant[i];
}

TWO_PATHS static void subtract_multiple(const double *restrict force, int values, double factor,
                                        double *restrict residual)
{
    for (int i = 0; i < values; i++) residual[i] -= factor * force[i];
}

static void subtract_loads(const gallop_model *model, const line_half *half, double t,
                           const conditions *now, double *residual)
{
    for (int l = 0; l < model->scene.load_count; l++) {
        const gallop_load *load = &model->scene.load[l];
        const nodal_load *nodal = &model->nodal_load[l];
        if (load->chain < half->chain[0] || load->chain >= half->chain[1]) continue;
        const double amplitude = now->load_factor * law_value(&model->law[load->law], t);
        if (amplitude != 0.0)
            subtract_multiple(nodal->force, nodal->values, amplitude, residual + nodal->first);
    }
}

/* Internal forces, inertia, damping and aerodynamic forces of a half, less constant forces. */
static void sum_half(const gallop_model *model, const line_half *half, const element_state *at,
                     double *residual, monitor *seen)
{
    const int first_value = 4 * half->node[0], values = 4 * half->node[1] - first_value;
    start_residual(model->constant_force + first_value, values, residual + first_value);
    for (int i = half->interval[0]; i < half->interval[1]; i++) {
        const interval *c = &model->interval[i];
        const exposure on = conditions_on(model, at->now, c);
        const int first = 4 * c->first_node;
        const evaluation of = {
            .interval = c,
            .now = &on,
            .at = at->at,
            .y = {at->y.u + first, at->y.v + first, at->y.a + first},
            .slopes = at->slopes,
            .slot = half->first_strip,
            .residual = residual + first,
            .seen = seen,
        };
        if (on.unknowns == 2)
            ON_PATH(on.fused, interval_of_2)(&of);
        else
            ON_PATH(on.fused, interval_of_4)(&of);
        if (on.section != c->section)
            for (int e = 0; e < c->elements; e++)
                element_add_lost_forces(c, e, &on, -1.0, residual + first + 8 * e);
    }
}

/* Out-of-balance forces of the free body: internal + inertia + damping - aerodynamics - loads -
 * constant forces. */
void element_sum_half(const gallop_model *model, int half, double t, const element_state *at,
                      double *residual, monitor *seen)
{
    const line_half *own = &model->half[half];
    sum_half(model, own, at, residual, seen);
    subtract_loads(model, own, t, at->now, residual);
}

void element_sum_residual(const gallop_model *model, double t, const conditions *now,
                          const sections *at, motion y, bool slopes, double *residual,
                          monitor *seen)
{
    const element_state all = {now, at, y, slopes};
    for (int h = 0; h < model->halves; h++) element_sum_half(model, h, t, &all, residual, seen);
}

/* Forces of one element alone. */
INLINE void one_element(const interval *c, int e, const exposure *now, const sections *at, motion y,
                        double r[12])
{
    const strip *s = &c->strip[e / LANES];
    const motion of_element = {y.u + 8 * e, y.v + 8 * e, y.a + 8 * e};
    strip_motion in_all_lanes;
    lanes force[3][4];
    lowest low = {.element = e};
    read_motion(of_element, 1, &in_all_lanes);
    for (int k = 0; k < LANES; k++) LANE(low.tension, k) = LANE(low.where, k) = INFINITY;
    strip_forces(now, s, &in_all_lanes, 4, force, &low);
    if (now->section->eccentric || now->blows) {
        section_motion(c, now, s, at, 0, &in_all_lanes);
        section_forces(c, now, at, 0, 3 * LANES, false);
        add_section_forces(s, at, 0, force);
    }
    for (int n = 0; n < 3; n++)
        for (int i = 0; i < 4; i++) r[4 * n + i] = LANE(force[n][i], e % LANES);
}
PATHS(one_element,
      (const interval *c, int e, const exposure *now, const sections *at, motion y, double r[12]),
      (c, e, now, at, y, r))

void element_residual(const interval *c, int e, const exposure *now, const sections *at, motion y,
                      double r[12])
{
    ON_PATH(now->fused, one_element)(c, e, now, at, y, r);
    if (now->section != c->section) element_add_lost_forces(c, e, now, -1.0, r);
}
