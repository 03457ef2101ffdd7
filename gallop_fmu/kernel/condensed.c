/* The condensed span: a few coupled modes, tension constant along the span, wind and turning ice at a few sections.
 *
 * In modal coordinates q, whose derivation stands in gallop_fmu/condensed.py,
 *
 *     q'' + c q' + omega^2 q = f(t, q, q', q''),
 *     f = - k (Q e + (e.q + Q) G q)      tension H = H0 + k (e.q + Q), Q = q.G q / 2, beyond its linear part
 *         + int (wind - ice) shapes dS + loads,
 *
 * with the ice's inertia and weight beyond their linear parts, which are in omega and the shapes.  The left side is
 * solved exactly and f by a Runge-Kutta scheme of order four (Cox, Matthews 2002, J. Comput. Phys. 176, 430-455,
 * eq. 26-29), so that a step is bounded by how fast f changes, not by the highest mode. */
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
    double stretched[MODES], estimate[MODES];   /* G q; forces before accelerations are known */
    double q[2][MODES], v[2][MODES], f[3][MODES];   /* stages of a step */
} bench;

static void prepare(bench *work)
{
    sections *at = &work->at;
    double **name[SECTION_ARRAYS] = {
        &at->theta, &at->omega, &at->omega_rate, &at->v2, &at->v3, &at->a2, &at->a3, &at->c2, &at->c3, &at->angle,
        &at->excess, &at->force[0], &at->force[1], &at->force[2], &at->by_theta[0], &at->by_theta[1], &at->by_theta[2],
        &at->by_v2[0], &at->by_v2[1], &at->by_v2[2], &at->by_v3[0], &at->by_v3[1], &at->by_v3[2]};
    memset(work, 0, sizeof *work);
    for (int i = 0; i < SECTION_ARRAYS; i++) *name[i] = work->array[i];
}

/* Motion of the sections: component 0 u2, 1 u3, 2 theta of the shapes times coordinates. */
static inline void at_sections(const gallop_condensed *c, const double *shapes, int component, const double *y, double *out)
{
    const double *shape = shapes + (size_t)component * (size_t)(c->modes * c->sections);
    for (int i = 0; i < c->sections; i++) out[i] = 0.0;
    for (int m = 0; m < c->modes; m++, shape += c->sections)
        for (int i = 0; i < c->sections; i++) out[i] += shape[i] * y[m];
}

/* force -= int shapes . load dS */
static inline void project(const gallop_condensed *c, const double *weighted, int components, const sections *at,
                           double *force)
{
    for (int component = 0; component < components; component++) {
        for (int i = 0; i < c->sections; i++, weighted += c->modes)
            for (int m = 0; m < c->modes; m++) force[m] -= weighted[m] * at->force[component][i];
    }
}

/* What turning the ice by theta changes in its inertia and weight; d2, d3 are left in at->c2, c3. */
static inline void turned_ice(const gallop_model *model, int count, const sections *at)
{
    const double m2 = model->c2, m3 = model->c3, gravity = model->scene.gravity;
    INDEPENDENT
    for (int i = 0; i < count; i++) {
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
static inline void accelerated_ice(int count, const sections *at)
{
    INDEPENDENT
    for (int i = 0; i < count; i++) {
        at->force[0][i] = -at->c3[i] * at->omega_rate[i];
        at->force[1][i] = at->c2[i] * at->omega_rate[i];
        at->force[2][i] = at->c2[i] * at->a3[i] - at->c3[i] * at->a2[i];
    }
}

static inline void accelerations(const gallop_condensed *c, const double *q, const double *v, const double *f, double *a)
{
    for (int m = 0; m < c->modes; m++) a[m] = f[m] - c->damping[m] * v[m] - c->frequency[m] * c->frequency[m] * q[m];
}

/* Rayleigh damping acts on the strain rate linear in the displacements, which is the true one less the rate of
 * s = u'.u'/2: e' = H'/EA - s'.  Its dissipation b2 EA int e'^2 dS / 2, derived by the velocities, less what is linear. */
static inline void stretching_damping(const gallop_condensed *c, const double *q, const double *v, double *f, bench *work)
{
    const sections *at = &work->at;
    const double *stretched = work->stretched;
    double linear = 0.0, square = 0.0;
    at_sections(c, c->slope, 0, q, at->a2);
    at_sections(c, c->slope, 1, q, at->a3);
    at_sections(c, c->slope, 0, v, at->v2);
    at_sections(c, c->slope, 1, v, at->v3);
    for (int i = 0; i < c->sections; i++) {
        double rate = at->a2[i] * at->v2[i] + at->a3[i] * at->v3[i];
        at->force[0][i] = rate * at->a2[i];
        at->force[1][i] = rate * at->a3[i];
    }
    project(c, c->slope_weighted, 2, at, f);
    for (int m = 0; m < c->modes; m++) {
        linear += c->elongation[m] * v[m];
        square += stretched[m] * v[m];
    }
    const double factor = c->damping_time * c->stiffness;
    const double all = factor * (square - c->share * (linear + square)), bent = factor * (linear + square);
    const double straight = factor * c->share * linear;
    for (int m = 0; m < c->modes; m++)
        f[m] += (all + straight) * c->elongation[m] + (all + bent) * stretched[m];
}

/* f(t, q, v, a).  The turned ice makes the forces depend on the accelerations: those in `a` are taken for a first
 * estimate, and the ones that follow from it for the forces.  One round is enough, as the accelerations of the
 * translations hardly depend on the twist.  Returns the horizontal tension. */
TWO_PATHS static double evaluate(const gallop_model *model, const gallop_condensed *c, double t, const double *q,
                                 const double *v, double *a, double *f, bench *work)
{
    const sections *at = &work->at;
    const int n = c->modes, count = c->sections;
    instant now = {.wind = law_value(&model->scene.wind, t), .attack = model->scene.attack_angle};
    const bool wind = windy(model, &now);

    double linear = 0.0, square = 0.0, *stretched = work->stretched;
    for (int m = 0; m < n; m++) stretched[m] = 0.0;
    for (int k = 0; k < n; k++)
        for (int m = 0; m < n; m++) stretched[m] += c->stretch[k * n + m] * q[k];
    for (int m = 0; m < n; m++) {
        linear += c->elongation[m] * q[m];
        square += 0.5 * stretched[m] * q[m];
    }
    for (int m = 0; m < n; m++)
        f[m] = -c->stiffness * (square * c->elongation[m] + (linear + square) * stretched[m]);
    if (c->damping_time > 0.0) stretching_damping(c, q, v, f, work);
    for (int k = 0; k < n; k++)
        for (int m = 0; m < n; m++) f[m] -= c->coupling[k * n + m] * v[k];
    for (int l = 0; l < c->loads; l++) {
        double factor = law_value(&model->scene.load[l].law, t);
        for (int m = 0; m < n; m++) f[m] += factor * c->load[l * n + m];
    }
    if (wind || model->eccentric) {
        at_sections(c, c->shape, 2, q, at->theta);
        at_sections(c, c->shape, 2, v, at->omega);
        for (int k = 0; k < 3; k++) memset(at->force[k], 0, (size_t)count * sizeof(double));
        if (model->eccentric) turned_ice(model, count, at);
        if (wind) {
            at_sections(c, c->shape, 0, v, at->v2);
            at_sections(c, c->shape, 1, v, at->v3);
            aero_loads(model, &now, at, 0, count, false);
        }
        project(c, c->weighted, 3, at, f);
    }
    if (!wind) memset(at->excess, 0, (size_t)count * sizeof(double));
    if (model->eccentric) {
        double *estimate = work->estimate;
        for (int round = 0; round < 2; round++) {
            at_sections(c, c->shape, 0, a, at->a2);
            at_sections(c, c->shape, 1, a, at->a3);
            at_sections(c, c->shape, 2, a, at->omega_rate);
            accelerated_ice(count, at);
            double *out = round ? f : estimate;
            if (!round) memcpy(estimate, f, (size_t)n * sizeof(double));
            project(c, c->weighted, 3, at, out);
            accelerations(c, q, v, out, a);
        }
    } else {
        accelerations(c, q, v, f, a);
    }
    return c->horizontal_tension + c->stiffness * (linear + square);
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
    for (int m = 0; m < c->modes; m++) {
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

static inline void drift(const propagator *p, int n, const double *q, const double *v, const double *f, double *q1, double *v1)
{
    for (int m = 0; m < n; m++) {
        double x = p->stay[0][m] * q[m] + p->move[0][m] * v[m] + p->held[0][m] * f[m];
        v1[m] = p->stay[1][m] * q[m] + p->move[1][m] * v[m] + p->held[1][m] * f[m];
        q1[m] = x;
    }
}

/* One step from t; f0 are the forces at its start. */
TWO_PATHS static void step(const gallop_model *model, const gallop_condensed *c, double t, const propagator *half,
                           const propagator *whole, double *q, double *v, double *a, const double *f0, bench *work)
{
    const int n = c->modes;
    double *qa = work->q[0], *va = work->v[0], *qb = work->q[1], *vb = work->v[1];
    double *fa = work->f[0], *fb = work->f[1], *fc = work->f[2];
    drift(half, n, q, v, f0, qa, va);
    evaluate(model, c, t + 0.5 * c->time_step, qa, va, a, fa, work);
    drift(half, n, q, v, fa, qb, vb);
    evaluate(model, c, t + 0.5 * c->time_step, qb, vb, a, fb, work);
    for (int m = 0; m < n; m++) fc[m] = 2.0 * fb[m] - f0[m];
    drift(half, n, qa, va, fc, qb, vb);
    evaluate(model, c, t + c->time_step, qb, vb, a, fc, work);
    for (int m = 0; m < n; m++) {
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
    if (c->modes > MODES || c->sections > SECTIONS) return GALLOP_BAD_CALL;
    prepare(&work);
    evaluate(model, c, time, q, v, a, f, &work);
    return GALLOP_COMPLETED;
}

/* The worst section, if an attack angle left the curve's range at the last evaluation. */
static int outside(const gallop_model *model, int count, const sections *at)
{
    int worst = -1;
    if (!model->aerodynamic || model->scene.outside != GALLOP_OUTSIDE_ERROR) return -1;
    for (int i = 0; i < count; i++)
        if (at->excess[i] > 0.0 && (worst < 0 || at->excess[i] > at->excess[worst])) worst = i;
    return worst;
}

int gallop_condensed_run(const gallop_model *model, const gallop_condensed *c, double *q, double *v, int64_t first,
                         int64_t records, int64_t every, double *history, int64_t *done, gallop_report *report)
{
    const int n = c->modes, count = c->sections;
    const size_t bytes = (size_t)n * sizeof(double);
    double f[MODES], a[MODES] = {0.0};
    propagator half, whole;
    bench work;
    *done = 0;
    if (n > MODES || count > SECTIONS || every < 1 || records < 0)
        return fail(report, GALLOP_BAD_CALL, -1, 0.0, 0.0, 0.0);
    prepare(&work);
    make_propagator(c, 0.5 * c->time_step, &half);
    make_propagator(c, c->time_step, &whole);
    evaluate(model, c, (double)(first * every) * c->time_step, q, v, a, f, &work);   /* accelerations to start from */
    for (; *done < records; history += 2 * n) {
        for (int64_t k = 0; k < every; k++) {
            double t = (double)((first + *done) * every + k) * c->time_step;
            double tension = evaluate(model, c, t, q, v, a, f, &work);
            int worst = outside(model, count, &work.at);
            if (!isfinite(tension)) return fail(report, GALLOP_NON_FINITE, -1, t, tension, 0.0);
            if (tension < report->lowest_tension) report->lowest_tension = tension;
            if (tension < 0.0) return fail(report, GALLOP_SLACK, -1, t, tension, 0.0);
            if (worst >= 0)
                return fail(report, GALLOP_ANGLE_OUT_OF_RANGE, -1, t, work.at.angle[worst],
                            work.at.angle[worst] > model->curve_centre ? model->curve_last : model->curve_first);
            step(model, c, t, &half, &whole, q, v, a, f, &work);
            report->steps++;
        }
        memcpy(history, q, bytes);
        memcpy(history + n, v, bytes);
        (*done)++;
        report->time = (double)((first + *done) * every) * c->time_step;
    }
    return GALLOP_COMPLETED;
}
