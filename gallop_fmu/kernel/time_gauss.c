/* Gauss's collocation method with three stages: order 6, A-stable, symmetric and symplectic.  The
 * acceleration over a step is the parabola through its values a_j at the times c_j h, and the
 * velocity its integral; the displacement is the integral of the parabola through the velocities at
 * these times, v(x h) = v0 + h sum_j v_j(x) a_j,    u(x h) = u0 + x h v0 + h^2 sum_i v_i(x) sum_j
 * v_j(c_i) a_j, and the equations of motion hold at the times c_j h.  The acceleration at the begin
 * of a step does not enter: a jump of the load does no harm there, and the axial modes of a fine
 * mesh, which no step resolves, do not pass it on.
 *
 * Newton's iteration takes one tangent for all stages.  In the eigenvectors of the matrix v_j(c_i)
 * = T diag(l) T^-1 they separate into systems K + C / (h l) + M / (h l)^2: a real one, and one for
 * a complex conjugate pair (E. Hairer, G. Wanner, Solving Ordinary Differential Equations II,
 * section IV.8; c in table IV.5.2). */
#include "base_glibc.h"
#include "junction.h"
#include "solver.h"
#include "system.h"
#include "time_integration.h"

#define STAGES GAUSS_STAGES
#define ROOT_15 3.8729833462074168852

#define MAX_REUSE_RATE                                                                             \
    0.6 /* a factorisation is renewed when the observed convergence rate is worse */

static const double node[STAGES] = {0.5 - ROOT_15 / 10.0, 0.5, 0.5 + ROOT_15 / 10.0}; /* c */

/* Lagrange's parabolas through the nodes, in powers of x. */
static const double lagrange[STAGES][3] = {
    {(5.0 + ROOT_15) / 6.0, -(10.0 + ROOT_15) / 3.0, 10.0 / 3.0},
    {-2.0 / 3.0, 20.0 / 3.0, -20.0 / 3.0},
    {(5.0 - ROOT_15) / 6.0, -(10.0 - ROOT_15) / 3.0, 10.0 / 3.0}};

/* Eigenvalues l, columns of T, rows of T^-1: the real one, and real and imaginary part of one of
 * the pair. */
static const double eigenvalue[3] = {0.21531442311611217824, 0.14234278844194391088,
                                     0.13579992570815380307};
static const double column[3][STAGES] = {{0.072151852055200170321, 0.11883257874127780707, 1.0},
                                         {-0.082241230573630670649, 0.053065090742061395046, 1.0},
                                         {-0.060120738619308501731, 0.31620505113229157322, 0.0}};
static const double row[3][STAGES] = {
    {5.9916980849378007756, 1.1392142951557354446, 0.43231211378385838557},
    {-2.9958490424689003878, -0.56960714757786772228, 0.28384394310807080722},
    {0.62310663679311570541, -1.4627798230961568313, 0.12886760063671624617}};

/* What the stages' accelerations contribute at the time x h of a step. */
typedef struct {
    double u[STAGES], v[STAGES], a[STAGES];
} weights;

static double integral(int j, double x)
{
    const double *l = lagrange[j];
    return x * (l[0] + x * (l[1] / 2.0 + x * l[2] / 3.0));
}

static weights weights_at(double x)
{
    weights w;
    for (int j = 0; j < STAGES; j++) {
        const double *l = lagrange[j];
        w.a[j] = l[0] + x * (l[1] + x * l[2]);
        w.v[j] = integral(j, x);
        w.u[j] = 0.0;
        for (int i = 0; i < STAGES; i++) w.u[j] += integral(i, x) * integral(j, node[i]);
    }
    return w;
}

/* Values of a half in an array of `values`, from the first one to that behind the last one. */
typedef struct {
    int first, end, values;
} range;

static range range_of(const gallop_model *model, int half)
{
    const line_half *own = &model->half[half];
    return (range){4 * own->node[0], 4 * own->node[1], 4 * model->nodes};
}

/* u and v at the time x h of a step that starts from u0, v0; a (3, nodes, 4) are the stages'
 * accelerations. */

INLINE void integrate(const state_view *at, const double *restrict a, range of, double h, double x,
                      double *restrict u, double *restrict v)
{
    const weights w = weights_at(x);
    const int values = of.values;
    for (int n = of.first; n < of.end; n++) {
        const double a0 = a[n], a1 = a[values + n], a2 = a[2 * values + n];
        u[n] = at->u0[n] + h * (x * at->v0[n] + h * (w.u[0] * a0 + w.u[1] * a1 + w.u[2] * a2));
        v[n] = at->v0[n] + h * (w.v[0] * a0 + w.v[1] * a1 + w.v[2] * a2);
    }
}
PATHS(integrate,
      (const state_view *at, const double *restrict a, range of, double h, double x,
       double *restrict u, double *restrict v),
      (at, a, of, h, x, u, v))

/* The acceleration at the time x h of a step. */
TWO_PATHS static void accelerate(const double *restrict a, range of, double x, double *restrict out)
{
    const weights w = weights_at(x);
    const int values = of.values;
    for (int n = of.first; n < of.end; n++)
        out[n] = w.a[0] * a[n] + w.a[1] * a[values + n] + w.a[2] * a[2 * values + n];
}

static motion stage_motion(const gallop_model *model, const state_view *at, int i)
{
    const size_t first = 4 * (size_t)i * model->nodes;
    return (motion){at->stage_u + first, at->stage_v + first, at->stage_a + first};
}

/* A step at work; its two halves are computed by up to two threads. */
typedef struct {
    const gallop_model *model;
    const gallop_state *state;
    state_view *at;
    double h;
    system_forces forces[STAGES];
    double size[2];  /* of the correction in each half */
    monitor seen[2]; /* at the end of the step */
} gauss_step;

/* The start of the step is kept.  The parabola of the sub-step before is continued; the ends follow
 * their prescribed motion. */
static void predict_half(void *task, int half)
{
    const gauss_step *s = task;
    const gallop_model *model = s->model;
    const state_view *at = s->at;
    const double h = s->h;
    const range own = range_of(model, half);
    time_keep_half(model, at, half);
    for (int i = 0; i < STAGES; i++) {
        double *a = at->stage_a + (size_t)i * own.values;
        if (isfinite(s->state->step_before))
            accelerate(at->stage_before, own, 1.0 + node[i] * h / s->state->step_before, a);
        else
            time_copy_half(model, half, at->a0, a);
    }
    for (int i = 0; i < STAGES; i++) {
        const size_t first = (size_t)i * own.values;
        ON_PATH(model->fused, integrate)
        (at, at->stage_a, own, h, node[i], at->stage_u + first, at->stage_v + first);
        junction_prescribe_half(model, &at->stage[i], half, at->stage_u + first,
                                at->stage_v + first, at->stage_a + first);
    }
}

/* The stages' residuals in the eigenvectors: the real system's into at->residual, the pair's into
 * at->pair_residual. */
INLINE void separate(const state_view *at, range of)
{
    const int values = of.values;
    const double *restrict r0 = at->stage_residual, *restrict r1 = r0 + values,
                           *restrict r2 = r1 + values;
    double *restrict real = at->residual, *restrict pair = at->complex_residual;
    for (int n = of.first; n < of.end; n += 4)
        for (int k = 0; k < 4; k++) {
            const double x = r0[n + k], y = r1[n + k], z = r2[n + k];
            real[n + k] = row[0][0] * x + row[0][1] * y + row[0][2] * z;
            pair[2 * n + k] = row[1][0] * x + row[1][1] * y + row[1][2] * z;
            pair[2 * n + 4 + k] = row[2][0] * x + row[2][1] * y + row[2][2] * z;
        }
}
PATHS(separate, (const state_view *at, range of), (at, of))

/* The tangent is that of the middle stage, whose sections are evaluated last. */
static const int order[STAGES] = {0, 2, 1};

static void find_forces(void *task, int half)
{
    gauss_step *s = task;
    for (int k = 0; k < STAGES; k++) system_find_forces(&s->forces[order[k]], half);
    ON_PATH(s->model->fused, separate)(s->at, range_of(s->model, half));
}

/* A complex factor: of the pair's solution only twice the real part is asked for, as its conjugate
 * adds the same. */
typedef struct {
    double re, im;
} number;

static number times(number a, number b)
{
    return (number){a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}

/* 1 / (h l) of the pair */
static number pair_inverse(double h)
{
    const double re = eigenvalue[1], im = eigenvalue[2], square = h * (re * re + im * im);
    return (number){re / square, -im / square};
}

/* Takes the correction that the solved systems mean for stage i from its u, v, a; leaves that of u
 * in its residual. */
INLINE void correct(const state_view *at, range of, int i, double h)
{
    const double *restrict y = at->residual, *restrict pair = at->complex_residual;
    const size_t first = (size_t)i * of.values;
    double *restrict du = at->stage_residual + first, *restrict u = at->stage_u + first;
    double *restrict v = at->stage_v + first, *restrict a = at->stage_a + first;
    const double real = 1.0 / (h * eigenvalue[0]), to_u = column[0][i], to_v = to_u * real,
                 to_a = to_v * real;
    const number inverse = pair_inverse(h), p = {2.0 * column[1][i], 2.0 * column[2][i]};
    const number q = times(p, inverse), r = times(q, inverse);
    for (int n = of.first; n < of.end; n += 4)
        for (int k = 0; k < 4; k++) {
            const double x = y[n + k], re = pair[2 * n + k], im = pair[2 * n + 4 + k];
            du[n + k] = to_u * x + p.re * re - p.im * im;
            u[n + k] -= du[n + k];
            v[n + k] -= to_v * x + q.re * re - q.im * im;
            a[n + k] -= to_a * x + r.re * re - r.im * im;
        }
}
PATHS(correct, (const state_view *at, range of, int i, double h), (at, of, i, h))

static void correct_half(void *task, int half)
{
    gauss_step *s = task;
    const range own = range_of(s->model, half);
    double size = 0.0;
    for (int i = 0; i < STAGES; i++) {
        ON_PATH(s->model->fused, correct)(s->at, own, i, s->h);
        const double *du = s->at->stage_residual + (size_t)i * own.values;
        const double of_stage = time_correction_size(du + own.first, own.end - own.first);
        size = of_stage <= size ? size : of_stage; /* lets NaN pass */
    }
    s->size[half] = size;
}

/* The end of a step that was found. */
static void end_half(void *task, int half)
{
    gauss_step *s = task;
    const state_view *at = s->at;
    const range own = range_of(s->model, half);
    ON_PATH(s->model->fused, integrate)(at, at->stage_a, own, s->h, 1.0, at->u, at->v);
    accelerate(at->stage_a, own, 1.0, at->a);
    junction_prescribe_half(s->model, &at->now, half, at->u, at->v, at->a);
    element_monitor_start(&s->seen[half]);
    element_monitor_tensions(s->model, half, &at->now, at->u, &s->seen[half]);
}

/* An iteration, with new tangents or not.  False: one is not positive definite. */
static bool iterate(gauss_step *s, bool renew, monitor *seen)
{
    const state_view *at = s->at;
    const motion middle = stage_motion(s->model, at, 1);
    const double real = 1.0 / (s->h * eigenvalue[0]);
    const number inverse = pair_inverse(s->h), square = times(inverse, inverse);
    const tangent_weights mix = {1.0, real, real * real},
                          pair[2] = {{1.0, inverse.re, square.re}, {0.0, inverse.im, square.im}};
    const solver_equations equations[2] = {
        {SOLVER_REAL, &at->stage[1], middle, renew ? &mix : NULL, at->residual},
        {SOLVER_COMPLEX, &at->stage[1], middle, renew ? pair : NULL, at->complex_residual}};
    const solver_frame frame = {find_forces, correct_half, s};
    for (int i = 0; i < STAGES; i++) s->forces[i].of.slopes = renew;
    element_monitor_start(seen);
    const bool solved =
        solver_run(s->model, at, SOLVER_JUNCTIONS_AS_IN_SCENE, equations, 2, &frame);
    for (int k = 0; k < STAGES; k++) system_notice(&s->forces[order[k]], seen);
    return solved;
}

/* One step from u0 v0 at t - h to u v at t; its a is that of the parabola's end, of third order. */
int time_gauss(const gallop_model *model, gallop_state *state, state_view *at,
               const gallop_inputs *inputs, double t, double h, double tolerance,
               gallop_report *report)
{
    bool renew = state->factored_step != h, fresh = false;
    double before = 0.0;
    monitor seen = {0};
    gauss_step step;
    step.model = model;
    step.state = state;
    step.at = at;
    step.h = h;
    for (int i = 0; i < STAGES; i++) {
        system_forces *f = &step.forces[i];
        f->model = model;
        f->time = t - h * (1.0 - node[i]);
        f->of = (element_state){&at->stage[i], &at->sections, stage_motion(model, at, i), false};
        f->residual = at->stage_residual + 4 * (size_t)i * (size_t)model->nodes;
        conditions_at(model, f->time, inputs, &at->stage[i]);
    }
    conditions_at(model, t, inputs, &at->now);
    team_share(at->team, model->halves, predict_half, &step);
    for (int iteration = 1; iteration <= model->scene.settings.max_newton_iterations; iteration++) {
        if (renew) state->factored_step = 0.0;
        if (!iterate(&step, renew, &seen))
            return report_failure(report, GALLOP_NEWTON_STALLED, seen.slack_element, t, NAN,
                                  tolerance);
        if (renew) {
            state->factored_step = h;
            state->rate = 1.0;
            state->refactorisations++;
            renew = false;
            fresh = true;
            before = 0.0;
        }
        const double size = time_larger_size(step.size, model->halves);
        state->iterations++;
        state->last_iterations++;
        if (!isfinite(size)) return report_failure(report, GALLOP_NON_FINITE, -1, t, size, 0.0);
        switch (time_newton_next(state, size, before, fresh, MAX_REUSE_RATE, tolerance)) {
        case NEWTON_CONVERGED:
            team_share(at->team, model->halves, end_half, &step);
            for (int half = 0; half < model->halves; half++)
                element_monitor_add(&seen, &step.seen[half]);
            return time_newton_accept(state, &seen, t, report);
        case NEWTON_DIVERGED:
            return report_failure(report, GALLOP_NEWTON_STALLED, seen.slack_element, t, size,
                                  tolerance);
        case NEWTON_REFACTORISE: renew = true; break;
        case NEWTON_CONTINUE: break;
        }
        before = size;
    }
    return report_failure(report, GALLOP_NEWTON_STALLED, seen.slack_element, t, before, tolerance);
}

static void keep_half(void *task, int half)
{
    const gauss_step *s = task;
    const state_view *at = s->at;
    const size_t values = 4 * (size_t)s->model->nodes;
    for (size_t i = 0; i < STAGES; i++)
        time_copy_half(s->model, half, at->stage_a + i * values, at->stage_before + i * values);
    time_copy_half(s->model, half, at->u0, at->begin);
    time_copy_half(s->model, half, at->v0, at->begin + values);
}

/* The step just found is the one before from now on. */
void time_gauss_commit(const gallop_model *model, gallop_state *state, state_view *at, double h)
{
    gauss_step step = {.model = model, .at = at};
    team_share(at->team, model->halves, keep_half, &step);
    state->step_before = state->last_step = h;
}

/* The cubic part c of h^2 a = ... + c x^3 over the step just found, from the difference at its last
 * stage between the displacement and what the parabola of the step before makes of it; without a
 * step before, the quadratic part. */
void time_gauss_cubic_part(const gallop_model *model, const gallop_state *state,
                           const state_view *at, double h, double *part)
{
    const int values = 4 * model->nodes;
    const double *now = at->stage_a, *old = at->stage_before;
    double after[STAGES], before[STAGES] = {0.0};
    if (isfinite(state->step_before)) {
        const weights reach = weights_at(node[STAGES - 1]);
        const double ahead = h / state->step_before;
        double unit = 0.0; /* what the difference would be for x^3 */
        for (int j = 0; j < STAGES; j++) {
            const weights continued = weights_at(1.0 + node[j] * ahead);
            after[j] = reach.u[j];
            for (int k = 0; k < STAGES; k++) before[k] -= reach.u[j] * continued.a[k];
        }
        for (int j = 0; j < STAGES; j++)
            unit += after[j] * pow(node[j], 3.0) + before[j] * pow((node[j] - 1.0) / ahead, 3.0);
        for (int j = 0; j < STAGES; j++) {
            after[j] *= h * h / unit;
            before[j] *= h * h / unit;
        }
    } else {
        for (int j = 0; j < STAGES; j++) after[j] = h * h * lagrange[j][2];
    }
    for (int n = 0; n < values; n++)
        part[n] = after[0] * now[n] + after[1] * now[values + n] + after[2] * now[2 * values + n] +
                  before[0] * old[n] + before[1] * old[values + n] +
                  before[2] * old[2 * values + n];
}

/* The linear part of h^2 a over the step just found, root mean square of one unknown over the
 * nodes. */
double time_gauss_linear_part(const gallop_model *model, const state_view *at, double h,
                              int unknown)
{
    const double *first = at->stage_a, *last = first + 4 * (size_t)(STAGES - 1) * model->nodes;
    double sum = 0.0;
    for (int n = unknown; n < 4 * model->nodes; n += 4)
        sum += (last[n] - first[n]) * (last[n] - first[n]);
    return h * h * sqrt(sum / model->nodes) / (node[STAGES - 1] - node[0]);
}

/* u v a at a time within the last step: the quintic through u, v, a at its ends. */
void time_gauss_read(const gallop_model *model, const gallop_state *state, state_view *at, double t)
{
    const int values = 4 * model->nodes;
    const double h = state->last_step, x = 1.0 + (t - state->time) / h, *k = at->stage_before;
    const double *u0 = at->begin, *v0 = at->begin + values;
    const weights start = weights_at(0.0), end = weights_at(1.0);
    for (int n = 0; n < values; n++) {
        const double a0 =
            start.a[0] * k[n] + start.a[1] * k[values + n] + start.a[2] * k[2 * values + n];
        const double a1 = end.a[0] * k[n] + end.a[1] * k[values + n] + end.a[2] * k[2 * values + n];
        /* u = u0 + x (h v0 + x (h^2 a0 / 2 + x (c3 + x (c4 + x c5)))) */
        const double p = at->u[n] - u0[n] - h * (v0[n] + 0.5 * h * a0),
                     q = h * (at->v[n] - v0[n] - h * a0);
        const double r = h * h * (a1 - a0);
        const double c3 = 10.0 * p - 4.0 * q + 0.5 * r, c4 = -15.0 * p + 7.0 * q - r,
                     c5 = 6.0 * p - 3.0 * q + 0.5 * r;
        at->u[n] = u0[n] + x * (h * v0[n] + x * (0.5 * h * h * a0 + x * (c3 + x * (c4 + x * c5))));
        at->v[n] = v0[n] + x * (h * a0 + x * (3.0 * c3 + x * (4.0 * c4 + x * 5.0 * c5)) / h);
        at->a[n] = a0 + x * (6.0 * c3 + x * (12.0 * c4 + x * 20.0 * c5)) / (h * h);
    }
    junction_prescribe(model, &at->now, at->u, at->v, at->a);
}
