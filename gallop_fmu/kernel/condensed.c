/* The condensed span: a few coupled modes, tension constant along the span, wind and turning ice at a few sections.
 *
 * In modal coordinates q, whose derivation stands in gallop_fmu/condensed.py,
 *
 *     q'' + d q' + w^2 q = f(t, q, q', q''),
 *     f = - k (Q e + (e.q + r Q) G q)     tension H0 + k (e.q + r Q) with Q = q.G q / 2, beyond its linear part
 *         - damping of the stretching beyond its linear part, and between modes
 *         + wind - turning ice beyond its linear part, integrated over the sections, + loads.
 *
 * The left side is solved exactly and f by a Runge-Kutta scheme of order four (Cox, Matthews 2002, J. Comput. Phys.
 * 176, 430-455, eq. 26-29), so that a step is bounded by how fast f changes, not by the highest mode. */
#include "elementary.h"
#include "internal.h"

#define MODES GALLOP_CONDENSED_MODES
#define SECTIONS GALLOP_CONDENSED_SECTIONS

/* What one mode makes of its state and of forces at the stages of a step, for position and velocity. */
typedef struct {
    double stay[2][MODES], move[2][MODES];   /* factors of q and v */
    double held[2][MODES];                   /* of a constant force */
    double first[2][MODES], inner[2][MODES], last[2][MODES];   /* of the forces at start, middle (twice) and end */
} propagator;

/* Scratch memory of an evaluation. */
typedef struct {
    double array[SECTION_ARRAYS][SECTIONS];
    sections at;
    double stretched[MODES], coupled[MODES], estimate[MODES];   /* G q; damping beside the diagonal; see evaluate */
    double q[2][MODES], v[2][MODES], f[3][MODES];   /* stages of a step */
} bench;

static void prepare(bench *work)
{
    sections *at = &work->at;
    double **name[SECTION_ARRAYS] = {   /* the three forces lie one behind the other, for `project` */
        &at->force[0], &at->force[1], &at->force[2], &at->theta, &at->omega, &at->omega_rate, &at->v2, &at->v3, &at->a2,
        &at->a3, &at->c2, &at->c3, &at->angle, &at->excess, &at->by_theta[0], &at->by_theta[1], &at->by_theta[2],
        &at->by_v2[0], &at->by_v2[1], &at->by_v2[2], &at->by_v3[0], &at->by_v3[1], &at->by_v3[2]};
    memset(work, 0, sizeof *work);
    for (int i = 0; i < SECTION_ARRAYS; i++) *name[i] = work->array[i];
}

/* Products of a matrix with one or more vectors.  In all of them the outer loop becomes vector code, for which
 * compilers want known lengths, arrays that they know to be apart, and sums that need not wait for each other. */

/* out = shapes y at the sections; `shapes` (MODES, SECTIONS). */
TWO_PATHS static void at_sections(const double *restrict shapes, const double *restrict y, double *restrict out)
{
    const double *restrict upper = shapes + MODES / 2 * SECTIONS;
    for (int i = 0; i < SECTIONS; i++) {
        double low = 0.0, high = 0.0;
        for (int m = 0; m < MODES / 2; m++) {
            low += shapes[m * SECTIONS + i] * y[m];
            high += upper[m * SECTIONS + i] * y[MODES / 2 + m];
        }
        out[i] = low + high;
    }
}

/* out = matrix y; `matrix` (MODES, MODES) symmetric. */
TWO_PATHS static void modal_product(const double *restrict matrix, const double *restrict y, double *restrict out)
{
    const double *restrict lower = matrix + MODES / 2 * MODES;
    for (int m = 0; m < MODES; m++) {
        double first = 0.0, last = 0.0;
        for (int k = 0; k < MODES / 2; k++) {
            first += matrix[k * MODES + m] * y[k];
            last += lower[k * MODES + m] * y[MODES / 2 + k];
        }
        out[m] = first + last;
    }
}

/* force -= int shapes . load dS; `weighted` (3, SECTIONS, MODES), `load` (3, SECTIONS). */
TWO_PATHS static void project(const double *restrict weighted, const double *restrict load, double *restrict force)
{
    enum { PART = SECTIONS * MODES };
    for (int m = 0; m < MODES; m++) {
        double by_f2 = 0.0, by_f3 = 0.0, by_moment = 0.0;
        for (int i = 0; i < SECTIONS; i++) {
            by_f2 += weighted[i * MODES + m] * load[i];
            by_f3 += weighted[PART + i * MODES + m] * load[SECTIONS + i];
            by_moment += weighted[2 * PART + i * MODES + m] * load[2 * SECTIONS + i];
        }
        force[m] -= by_f2 + by_f3 + by_moment;
    }
}

/* The same for stresses on the slopes; `weighted` (2, SECTIONS, MODES), `stress` (2, SECTIONS). */
TWO_PATHS static void project_stress(const double *restrict weighted, const double *restrict stress,
                                     double *restrict force)
{
    enum { PART = SECTIONS * MODES };
    for (int m = 0; m < MODES; m++) {
        double by_u2 = 0.0, by_u3 = 0.0;
        for (int i = 0; i < SECTIONS; i++) {
            by_u2 += weighted[i * MODES + m] * stress[i];
            by_u3 += weighted[PART + i * MODES + m] * stress[SECTIONS + i];
        }
        force[m] -= by_u2 + by_u3;
    }
}

/* What turning the ice by theta changes in its inertia and weight; d2, d3 are left in at->c2, c3. */
static inline void turned_ice(const gallop_model *model, const sections *at)
{
    const double m2 = model->c2, m3 = model->c3, gravity = model->scene.gravity;
    INDEPENDENT
    for (int i = 0; i < SECTIONS; i++) {
        double sine, cosine, square = at->omega[i] * at->omega[i];
        sine_cosine(at->theta[i], &sine, &cosine);
        double c2 = m2 * cosine - m3 * sine, c3 = m2 * sine + m3 * cosine;
        at->c2[i] = c2 - m2;
        at->c3[i] = c3 - m3;
        at->force[0][i] = -c2 * square;
        at->force[1][i] = -c3 * square;
        at->force[2][i] = -gravity * (c3 - m3 - m2 * at->theta[i]);
    }
}

/* ... and of that the part which the accelerations of the sections bring. */
static inline void accelerated_ice(const sections *at)
{
    INDEPENDENT
    for (int i = 0; i < SECTIONS; i++) {
        at->force[0][i] = -at->c3[i] * at->omega_rate[i];
        at->force[1][i] = at->c2[i] * at->omega_rate[i];
        at->force[2][i] = at->c2[i] * at->a3[i] - at->c3[i] * at->a2[i];
    }
}

static inline void accelerations(const gallop_condensed *c, const double *q, const double *v, const double *f,
                                 double *a)
{
    for (int m = 0; m < MODES; m++) a[m] = f[m] - c->damping[m] * v[m] - c->frequency[m] * c->frequency[m] * q[m];
}

/* Rayleigh damping acts on the strain that is linear in the displacements: the true one less s = u'.u'/2, whose rate
 * is H'/EA - s'.  Its dissipation b2 EA int (H'/EA - s')^2 dS / 2, derived by the velocities, less what is linear. */
static void stretching_damping(const gallop_condensed *c, const double *q, const double *v, double *f, bench *work)
{
    const sections *at = &work->at;
    const double *stretched = work->stretched;
    double linear = 0.0, square = 0.0;
    at_sections(c->slope, q, at->a2);
    at_sections(c->slope + MODES * SECTIONS, q, at->a3);
    at_sections(c->slope, v, at->v2);
    at_sections(c->slope + MODES * SECTIONS, v, at->v3);
    for (int i = 0; i < SECTIONS; i++) {
        double rate = at->a2[i] * at->v2[i] + at->a3[i] * at->v3[i];
        at->force[0][i] = rate * at->a2[i];
        at->force[1][i] = rate * at->a3[i];
    }
    project_stress(c->slope_weighted, at->force[0], f);
    for (int m = 0; m < MODES; m++) {
        linear += c->elongation[m] * v[m];
        square += stretched[m] * v[m];
    }
    const double factor = c->damping_time * c->stiffness, r = c->remaining, tension_rate = linear + r * square;
    const double all = factor * (square - c->share * tension_rate), bent = factor * tension_rate;
    const double straight = factor * c->share * linear;
    for (int m = 0; m < MODES; m++)
        f[m] += (all + straight) * c->elongation[m] + (r * all + bent) * stretched[m];
}

/* f(t, q, v, a).  The turned ice makes the forces depend on the accelerations: those in `a`, of the stage before, give
 * a first estimate, and the ones that follow from it the forces.  That is enough, as the accelerations of the
 * translations hardly depend on those of the twist.  Returns the horizontal tension. */
TWO_PATHS static double evaluate(const gallop_model *model, const gallop_condensed *c, double t, const double *q,
                                 const double *v, double *a, double *f, bench *work)
{
    const sections *at = &work->at;
    instant now = {.wind = law_value(&model->scene.wind, t), .attack = model->scene.attack_angle};
    const bool wind = windy(model, &now);

    double linear = 0.0, square = 0.0, *stretched = work->stretched;
    modal_product(c->stretch, q, stretched);
    modal_product(c->coupling, v, work->coupled);
    for (int m = 0; m < MODES; m++) {
        linear += c->elongation[m] * q[m];
        square += 0.5 * stretched[m] * q[m];
    }
    for (int m = 0; m < MODES; m++)
        f[m] = -c->stiffness * (square * c->elongation[m] + (linear + c->remaining * square) * stretched[m]) -
               work->coupled[m];
    if (c->damping_time > 0.0) stretching_damping(c, q, v, f, work);
    for (int l = 0; l < c->loads; l++) {
        double factor = law_value(&model->scene.load[l].law, t);
        for (int m = 0; m < MODES; m++) f[m] += factor * c->load[l * MODES + m];
    }
    if (wind || model->eccentric) {
        at_sections(c->shape + 2 * MODES * SECTIONS, q, at->theta);
        at_sections(c->shape + 2 * MODES * SECTIONS, v, at->omega);
        if (model->eccentric) {
            turned_ice(model, at);
        } else {
            for (int i = 0; i < 3 * SECTIONS; i++) at->force[0][i] = 0.0;
        }
        if (wind) {
            at_sections(c->shape, v, at->v2);
            at_sections(c->shape + MODES * SECTIONS, v, at->v3);
            aero_loads(model, &now, at, 0, SECTIONS, false);
        }
        project(c->weighted, at->force[0], f);
    }
    if (!wind)
        for (int i = 0; i < SECTIONS; i++) at->excess[i] = 0.0;
    if (model->eccentric) {
        double *estimate = work->estimate;
        for (int round = 0; round < 2; round++) {
            at_sections(c->shape, a, at->a2);
            at_sections(c->shape + MODES * SECTIONS, a, at->a3);
            at_sections(c->shape + 2 * MODES * SECTIONS, a, at->omega_rate);
            accelerated_ice(at);
            double *out = round ? f : estimate;
            if (!round) memcpy(estimate, f, MODES * sizeof(double));
            project(c->weighted, at->force[0], out);
            accelerations(c, q, v, out, a);
        }
    } else {
        accelerations(c, q, v, f, a);
    }
    return c->horizontal_tension + c->stiffness * (linear + c->remaining * square);
}

/* Responses of x'' + c x' + w^2 x = f from rest at time t: x[k + 2] to f = t^k / k!, x[1] to an impulse, x[0] its rate.
 * The rate of a response is the response one earlier, so that w^2 x_k = t^k / k! - c x_(k-1) - x_(k-2). */
static void responses(double w, double c, double t, double x[5])
{
    const double half = 0.5 * c, inner = w * w - half * half, rate = sqrt(fabs(inner)), decay = exp(-half * t);
    double swing, carry;   /* sin(rate t) / rate and cos(rate t), or their hyperbolic kin */
    if (rate * t < 1e-6) {
        swing = t;
        carry = 1.0;
    } else if (inner > 0.0) {
        swing = sin(rate * t) / rate;
        carry = cos(rate * t);
    } else {
        swing = sinh(rate * t) / rate;
        carry = cosh(rate * t);
    }
    x[1] = decay * swing;
    x[0] = decay * carry - half * x[1];
    double power = 1.0;
    for (int k = 0; k < 3; k++) {
        x[k + 2] = (power - c * x[k + 1] - x[k]) / (w * w);
        power *= t / (k + 1);
    }
}

static void make_propagator(const gallop_condensed *c, double t, propagator *p)
{
    for (int m = 0; m < MODES; m++) {
        const double w = c->frequency[m];
        double x[5];
        responses(w, c->damping[m], t, x);
        p->stay[0][m] = 1.0 - w * w * x[2];
        p->stay[1][m] = -w * w * x[1];
        p->move[0][m] = x[1];
        p->move[1][m] = x[0];
        for (int i = 0; i < 2; i++) {
            double constant = x[2 - i], slope = x[3 - i] / t, curvature = x[4 - i] / (t * t);
            p->held[i][m] = constant;
            p->first[i][m] = constant - 3.0 * slope + 4.0 * curvature;
            p->inner[i][m] = 2.0 * slope - 4.0 * curvature;
            p->last[i][m] = 4.0 * curvature - slope;
        }
    }
}

static inline void drift(const propagator *p, const double *q, const double *v, const double *f, double *q1, double *v1)
{
    for (int m = 0; m < MODES; m++) {
        double x = p->stay[0][m] * q[m] + p->move[0][m] * v[m] + p->held[0][m] * f[m];
        v1[m] = p->stay[1][m] * q[m] + p->move[1][m] * v[m] + p->held[1][m] * f[m];
        q1[m] = x;
    }
}

/* One step from t; f0 are the forces at its start. */
TWO_PATHS static void step(const gallop_model *model, const gallop_condensed *c, double t, const propagator *half,
                           const propagator *whole, double *q, double *v, double *a, const double *f0, bench *work)
{
    double *qa = work->q[0], *va = work->v[0], *qb = work->q[1], *vb = work->v[1];
    double *fa = work->f[0], *fb = work->f[1], *fc = work->f[2];
    drift(half, q, v, f0, qa, va);
    evaluate(model, c, t + 0.5 * c->time_step, qa, va, a, fa, work);
    drift(half, q, v, fa, qb, vb);
    evaluate(model, c, t + 0.5 * c->time_step, qb, vb, a, fb, work);
    for (int m = 0; m < MODES; m++) fc[m] = 2.0 * fb[m] - f0[m];
    drift(half, qa, va, fc, qb, vb);
    evaluate(model, c, t + c->time_step, qb, vb, a, fc, work);
    for (int m = 0; m < MODES; m++) {
        double inner = fa[m] + fb[m], x = q[m];
        q[m] = whole->stay[0][m] * x + whole->move[0][m] * v[m] + whole->first[0][m] * f0[m] +
               whole->inner[0][m] * inner + whole->last[0][m] * fc[m];
        v[m] = whole->stay[1][m] * x + whole->move[1][m] * v[m] + whole->first[1][m] * f0[m] +
               whole->inner[1][m] * inner + whole->last[1][m] * fc[m];
    }
}

int gallop_condensed_forces(const gallop_model *model, const gallop_condensed *c, double time, const double *q,
                            const double *v, double *a, double *f)
{
    bench work;
    if (c->loads != model->scene.load_count) return GALLOP_BAD_CALL;
    prepare(&work);
    for (int round = 0; round < 3; round++) evaluate(model, c, time, q, v, a, f, &work);
    return GALLOP_COMPLETED;
}

/* The worst section, if an attack angle left the curve's range at the last evaluation. */
static int outside(const gallop_model *model, const sections *at)
{
    int worst = -1;
    if (!model->aerodynamic || model->scene.outside != GALLOP_OUTSIDE_ERROR) return -1;
    for (int i = 0; i < SECTIONS; i++)
        if (at->excess[i] > 0.0 && (worst < 0 || at->excess[i] > at->excess[worst])) worst = i;
    return worst;
}

static double horizontal_tension(const gallop_condensed *c, const double *q)
{
    double stretched[MODES], linear = 0.0, square = 0.0;
    modal_product(c->stretch, q, stretched);
    for (int m = 0; m < MODES; m++) {
        linear += c->elongation[m] * q[m];
        square += 0.5 * stretched[m] * q[m];
    }
    return c->horizontal_tension + c->stiffness * (linear + c->remaining * square);
}

/* Quintic Hermite polynomials between the start (q, v, a) and the end of a step h, at the fraction x of it. */
static void between(const double *start[3], const double *end[3], double h, double x, double *q, double *v)
{
    const double x2 = x * x, x3 = x2 * x, y = 1.0 - x;
    const double to_end = x3 * (10.0 - 15.0 * x + 6.0 * x2), rate = 30.0 * x2 * y * y / h;
    const double v0 = h * (x - 6.0 * x3 + 8.0 * x3 * x - 3.0 * x3 * x2);
    const double v1 = h * (-4.0 * x3 + 7.0 * x3 * x - 3.0 * x3 * x2);
    const double v0_rate = 1.0 - 18.0 * x2 + 32.0 * x3 - 15.0 * x2 * x2;
    const double v1_rate = -12.0 * x2 + 28.0 * x3 - 15.0 * x2 * x2;
    const double a0 = 0.5 * h * h * x2 * y * y * y, a1 = 0.5 * h * h * x3 * y * y;
    const double a0_rate = 0.5 * h * x * y * y * (2.0 - 5.0 * x), a1_rate = 0.5 * h * x2 * y * (3.0 - 5.0 * x);
    for (int m = 0; m < MODES; m++) {
        double way = end[0][m] - start[0][m];
        q[m] = start[0][m] + to_end * way + v0 * start[1][m] + v1 * end[1][m] + a0 * start[2][m] + a1 * end[2][m];
        v[m] = rate * way + v0_rate * start[1][m] + v1_rate * end[1][m] + a0_rate * start[2][m] + a1_rate * end[2][m];
    }
}

/* What a motion must satisfy whose horizontal tension is `tension`: where a coordinate is not finite, nor is that. */
static int judge_motion(double t, double tension, const double *v, gallop_report *report)
{
    double none = 0.0;
    for (int m = 0; m < MODES; m++) none += 0.0 * v[m];   /* not a number if one is not finite */
    report->time = t;
    if (!isfinite(tension) || isnan(none)) return fail(report, GALLOP_NON_FINITE, -1, t, tension, 0.0);
    if (tension < report->lowest_tension) report->lowest_tension = tension;
    return tension < 0.0 ? fail(report, GALLOP_SLACK, -1, t, tension, 0.0) : GALLOP_COMPLETED;
}

/* The same and what else a state must satisfy, `tension` and work->at being those of its evaluation. */
static int judge(const gallop_model *model, double t, double tension, const double *v, const bench *work,
                 gallop_report *report)
{
    const int outcome = judge_motion(t, tension, v, report), worst = outside(model, &work->at);
    if (outcome || worst < 0) return outcome;
    double angle = work->at.angle[worst];
    return fail(report, GALLOP_ANGLE_OUT_OF_RANGE, -1, t, angle,
                angle > model->curve_centre ? model->curve_last : model->curve_first);
}

int gallop_condensed_run(const gallop_model *model, const gallop_condensed *c, double *q, double *v, int64_t first,
                         int64_t steps, int64_t every, int64_t within, double *history, double *tension_history,
                         int64_t *records, gallop_report *report)
{
    const size_t bytes = MODES * sizeof(double);
    double f[MODES], a[MODES] = {0.0}, before[3][MODES];
    const double *start[3] = {before[0], before[1], before[2]}, *end[3] = {q, v, a};
    propagator half, whole;
    bench work;
    *records = 0;
    if (c->loads != model->scene.load_count)
        return fail(report, GALLOP_BAD_CALL, -1, 0.0, c->loads, model->scene.load_count);
    if (every < 1 || within < 1 || steps < 0 || steps > MOST_STEPS || first < 0 || first > INT64_MAX - steps)
        return fail(report, GALLOP_BAD_CALL, -1, 0.0, (double)steps, MOST_STEPS);
    if (!(c->time_step > 0.0) || !isfinite((double)(first + steps) * c->time_step) || !isfinite(c->time_step))
        return fail(report, GALLOP_BAD_CALL, -1, 0.0, c->time_step, 0.0);
    prepare(&work);
    make_propagator(c, 0.5 * c->time_step, &half);
    make_propagator(c, c->time_step, &whole);
    double t = (double)first * c->time_step, tension = 0.0;
    for (int round = 0; round < 2; round++) tension = evaluate(model, c, t, q, v, a, f, &work);   /* finds a as well */
    int outcome = judge(model, t, tension, v, &work, report);
    for (int64_t k = 1; k <= steps && !outcome; k++) {
        memcpy(before[0], q, bytes);
        memcpy(before[1], v, bytes);
        memcpy(before[2], a, bytes);
        step(model, c, t, &half, &whole, q, v, a, f, &work);
        t = (double)(first + k) * c->time_step;
        tension = evaluate(model, c, t, q, v, a, f, &work);
        report->steps++;
        outcome = judge(model, t, tension, v, &work, report);
        if (outcome || k % every) continue;
        for (int64_t j = 1; j <= within && !outcome; j++, history += 2 * MODES, tension_history++) {
            double *q_then = history, *v_then = history + MODES;
            if (j < within) {
                between(start, end, c->time_step, (double)j / (double)within, q_then, v_then);
            } else {
                memcpy(q_then, q, bytes);
                memcpy(v_then, v, bytes);
            }
            *tension_history = horizontal_tension(c, q_then);
            const double then = t - (double)(within - j) / (double)within * c->time_step;
            outcome = judge_motion(then, *tension_history, v_then, report);
            if (!outcome) ++*records;
        }
    }
    return outcome;
}
