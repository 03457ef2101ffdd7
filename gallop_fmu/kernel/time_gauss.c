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
#include "time_turn.h"

#define STAGES GAUSS_STAGES
#define NEWTON_SHARE 0.1 /* of the Newton tolerance: what is left acts through three stages */
#define ROOT_15 3.8729833462074168852

static const double node[STAGES] = {0.5 - ROOT_15 / 10.0, 0.5, 0.5 + ROOT_15 / 10.0}; /* c */

/* Lagrange's parabolas through the nodes, in powers of x. */
static const double lagrange[STAGES][3] = {
    {(5.0 + ROOT_15) / 6.0, -(10.0 + ROOT_15) / 3.0, 10.0 / 3.0},
    {-2.0 / 3.0, 20.0 / 3.0, -20.0 / 3.0},
    {(5.0 - ROOT_15) / 6.0, -(10.0 - ROOT_15) / 3.0, 10.0 / 3.0}};

/* The inverse of v_j(c_i), and its square: velocity and acceleration of the stages by h and h^2
 * from their displacements. */
static const double derivative[STAGES][STAGES] = {
    {5.0, 1.1639777949432225136, -0.16397779494322251357},
    {-5.727486121839514071, 2.0, 0.72748612183951407098},
    {10.163977794943222514, -9.1639777949432225136, 5.0}};
static const double second[STAGES][STAGES] = {
    {16.666666666666666667, 9.6505334363260017481, -0.79300025748167103692},
    {-32.698250064370417759, -9.3333333333333333333, 6.0315833977037510926},
    {154.12633359081500437, -52.317200102992668415, 16.666666666666666667}};

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
INLINE void integrate(const state_view *at, const double *a, range of, double h, double x,
                      double *u, double *v)
{
    const weights w = weights_at(x);
    const int values = of.values;
    const double x_h = x * h, by_u[STAGES] = {h * h * w.u[0], h * h * w.u[1], h * h * w.u[2]};
    const double by_v[STAGES] = {h * w.v[0], h * w.v[1], h * w.v[2]};
    for (int n = of.first; n < of.end; n += LANES) {
        const lanes a0 = LANES_AT(a + n), a1 = LANES_AT(a + values + n),
                    a2 = LANES_AT(a + 2 * values + n), v0 = LANES_AT(at->v0 + n);
        LANES_AT(u + n) =
            LANES_AT(at->u0 + n) + x_h * v0 + (by_u[0] * a0 + by_u[1] * a1 + by_u[2] * a2);
        LANES_AT(v + n) = v0 + (by_v[0] * a0 + by_v[1] * a1 + by_v[2] * a2);
    }
}
PATHS(integrate,
      (const state_view *at, const double *a, range of, double h, double x, double *u, double *v),
      (at, a, of, h, x, u, v))

/* The acceleration at the time x h of a step. */
INLINE void accelerate(const double *a, range of, double x, double *out)
{
    const weights w = weights_at(x);
    for (int n = of.first; n < of.end; n += LANES)
        LANES_AT(out + n) = w.a[0] * LANES_AT(a + n) + w.a[1] * LANES_AT(a + of.values + n) +
                            w.a[2] * LANES_AT(a + 2 * of.values + n);
}
PATHS(accelerate, (const double *a, range of, double x, double *out), (a, of, x, out))

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
    bool renew; /* the tangent is factorised with the next correction */
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
        if (isfinite(s->state->step_before)) {
            ON_PATH(model->fused, accelerate)
            (at->stage_before, own, 1.0 + node[i] * h / s->state->step_before, a);
        } else {
            time_copy_half(model, half, at->a0, a);
        }
    }
    for (int i = 0; i < STAGES; i++) {
        const size_t first = (size_t)i * own.values;
        ON_PATH(model->fused, integrate)
        (at, at->stage_a, own, h, node[i], at->stage_u + first, at->stage_v + first);
        junction_prescribe_half(model, &at->stage[i], half, at->stage_u + first,
                                at->stage_v + first, at->stage_a + first);
    }
}

/* The stages' residuals, turned, in the eigenvectors: the real system's into at->residual, the
 * pair's into at->complex_residual.  The first and the last node are junctions. */
INLINE void separate(const gallop_model *model, const state_view *at, range of)
{
    const int values = of.values;
    const double *residual = at->stage_residual, *u = at->stage_u;
    const turning turned = turn_of(model, at);
    double *real = at->residual, *complex = at->complex_residual;
    for (int n = of.first; n < of.end; n += 4) {
        const bool end = n == 0 || n == values - 4;
        lanes r[STAGES][LANE_GROUPS];
        for (int k = 0; k < STAGES; k++) {
            for (int i = 0; i < LANE_GROUPS; i++)
                r[k][i] = LANES_AT(residual + k * values + n + LANES * i);
            if (!end) turn_force(&turned, u + k * values, k * values, n, r[k]);
        }
        for (int i = 0; i < LANE_GROUPS; i++) {
            const int m = n + LANES * i;
            const lanes x = r[0][i], y = r[1][i], z = r[2][i];
            double *pair = complex + n + m; /* four real parts, four imaginary ones */
            LANES_AT(real + m) = row[0][0] * x + row[0][1] * y + row[0][2] * z;
            LANES_AT(pair) = row[1][0] * x + row[1][1] * y + row[1][2] * z;
            LANES_AT(pair + 4) = row[2][0] * x + row[2][1] * y + row[2][2] * z;
        }
    }
}
PATHS(separate, (const gallop_model *model, const state_view *at, range of), (model, at, of))

/* The tangent is that of the middle stage, whose sections are evaluated last. */
enum { MIDDLE = 1 };
static const int order[STAGES] = {0, 2, MIDDLE};

/* A new tangent has the directions of the middle stage. */
INLINE void note_directions(const gallop_model *model, const state_view *at, range of)
{
    const turning turned = turn_of(model, at);
    const int last = of.values - 4;
    turn_note(&turned, at->stage_u + MIDDLE * of.values, of.first > 0 ? of.first : 4,
              of.end < last ? of.end : last, at->factored);
}
PATHS(note_directions, (const gallop_model *model, const state_view *at, range of), (model, at, of))

static void find_forces(void *task, int half)
{
    gauss_step *s = task;
    const range own = range_of(s->model, half);
    for (int k = 0; k < STAGES; k++) system_find_forces(&s->forces[order[k]], half);
    if (s->renew) ON_PATH(s->model->fused, note_directions)(s->model, s->at, own);
    ON_PATH(s->model->fused, separate)(s->model, s->at, own);
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

/* Takes the corrections that the solved systems mean from u, v, a of the stages; returns the size
 * of those of u. */
INLINE double correct(const gallop_model *model, const state_view *at, range of, double h)
{
    const int values = of.values;
    const double by_v = 1.0 / h, by_a = by_v * by_v;
    const double *real = at->residual, *complex = at->complex_residual;
    const turning turned = turn_of(model, at);
    double *u = at->stage_u, *v = at->stage_v, *a = at->stage_a;
    correction_size seen = {{{0.0}}, {{0.0}}};
    for (int n = of.first; n < of.end; n += 4) {
        const bool end = n == 0 || n == values - 4;
        lanes du[STAGES][LANE_GROUPS];
        for (int k = 0; k < STAGES; k++) {
            const double re = 2.0 * column[1][k], im = 2.0 * column[2][k];
            for (int i = 0; i < LANE_GROUPS; i++) {
                const double *pair = complex + 2 * n + LANES * i;
                du[k][i] = column[0][k] * LANES_AT(real + n + LANES * i) + re * LANES_AT(pair) -
                           im * LANES_AT(pair + 4);
            }
            if (!end) turn_back(&turned, k * values, n, du[k]);
        }
        for (int i = 0; i < LANE_GROUPS; i++)
            for (int k = 0; k < STAGES; k++) {
                const int place = k * values + n + LANES * i;
                const lanes x = du[0][i], y = du[1][i], z = du[2][i];
                LANES_AT(u + place) -= du[k][i];
                LANES_AT(v + place) -=
                    by_v * (derivative[k][0] * x + derivative[k][1] * y + derivative[k][2] * z);
                LANES_AT(a + place) -=
                    by_a * (second[k][0] * x + second[k][1] * y + second[k][2] * z);
                time_note_size(&seen, i, &du[k][i]);
            }
    }
    return time_size_of(&seen);
}
VALUE_PATHS(double, correct, (const gallop_model *model, const state_view *at, range of, double h),
            (model, at, of, h))

static void correct_half(void *task, int half)
{
    gauss_step *s = task;
    s->size[half] =
        ON_PATH(s->model->fused, correct)(s->model, s->at, range_of(s->model, half), s->h);
}

/* The end of a step that was found. */
static void end_half(void *task, int half)
{
    gauss_step *s = task;
    const state_view *at = s->at;
    const range own = range_of(s->model, half);
    ON_PATH(s->model->fused, integrate)(at, at->stage_a, own, s->h, 1.0, at->u, at->v);
    ON_PATH(s->model->fused, accelerate)(at->stage_a, own, 1.0, at->a);
    junction_prescribe_half(s->model, &at->now, half, at->u, at->v, at->a);
    element_monitor_start(&s->seen[half]);
    element_monitor_tensions(s->model, half, &at->now, at->u, &s->seen[half]);
}

/* An iteration.  False: one is not positive definite. */
static bool iterate(gauss_step *s, monitor *seen)
{
    const state_view *at = s->at;
    const motion middle = stage_motion(s->model, at, MIDDLE);
    const double real = 1.0 / (s->h * eigenvalue[0]);
    const number inverse = pair_inverse(s->h), square = times(inverse, inverse);
    const tangent_weights mix = {1.0, real, real * real},
                          pair[2] = {{1.0, inverse.re, square.re}, {0.0, inverse.im, square.im}};
    const solver_equations equations[2] = {
        {SOLVER_REAL, &at->stage[MIDDLE], middle, s->renew ? &mix : NULL, at->residual},
        {SOLVER_COMPLEX, &at->stage[MIDDLE], middle, s->renew ? pair : NULL, at->complex_residual}};
    const solver_frame frame = {find_forces, correct_half, s};
    for (int i = 0; i < STAGES; i++) s->forces[i].of.slopes = s->renew;
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
        step.renew = renew;
        if (!iterate(&step, &seen))
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
        switch (time_newton_next(state, size, before, fresh, NEWTON_SHARE * tolerance)) {
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
