/* Newmark's method (beta 1/4, gamma 1/2) with Newton-Raphson (Liu et al. 2009, section 2.5), and
 * its generalisation that balances forces within the step, at t - alpha_f h with accelerations of t
 * - alpha_m h (Chung, Hulbert 1993, J. Appl. Mech. 60, 371-375): motion that no step resolves, as
 * axial modes of fine meshes, decays instead of ringing on. */
#include "junction.h"
#include "solver.h"
#include "system.h"
#include "time_integration.h"

typedef struct {
    double alpha_m, alpha_f, beta, gamma;
} weights;

/* Chung and Hulbert's choice for a spectral radius of infinitely fast motion: second order,
 * unconditionally stable, and the least damping of slow motion. */
static weights weights_of(const gallop_model *model)
{
    if (!model_by_alpha(model)) return (weights){0.0, 0.0, 0.25, 0.5};
    const double radius = model->scene.settings.spectral_radius;
    const double m = (2.0 * radius - 1.0) / (radius + 1.0), f = radius / (radius + 1.0),
                 more = 1.0 - m + f;
    return (weights){m, f, 0.25 * more * more, 0.5 - m + f};
}

/* Ways to extrapolate the acceleration by one of equal steps: factors of a0 and of those before it.
 * A straight line, a parabola, a cubic, and a straight line on which lies a motion that changes
 * sign at every step: that is what this method makes of axial modes that the step does not resolve,
 * and smooth curves through it lead far off. */
enum { LINE, PARABOLA, CUBIC, ALTERNATING, WAYS };
static const double extrapolation[WAYS][NEWMARK_HISTORY] = {
    {2.0, -1.0, 0.0, 0.0}, {3.0, -3.0, 1.0, 0.0}, {4.0, -6.0, 4.0, -1.0}, {1.0, 1.0, -1.0, 0.0}};

/* The acceleration of so many steps before the last; they follow each other in a ring. */
static double *before(const gallop_model *model, const gallop_state *state, const state_view *at,
                      int steps)
{
    return at->a_before +
           (size_t)((state->newest + steps - 1) % NEWMARK_HISTORY) * 4 * (size_t)model->nodes;
}

/* A step at work; its two halves are computed by up to two threads. */
typedef struct {
    const gallop_model *model;
    const gallop_state *state;
    state_view *at;
    weights w;
    bool within; /* forces are balanced within the step */
    double h, per_v, per_a;
    const double *past[NEWMARK_HISTORY + 1]; /* accelerations: a0 and those before it */
    bool extrapolates;                       /* by one of the ways */
    double missed[2][WAYS][4]; /* of each half: squares of what each would have missed */
    double weight[NEWMARK_HISTORY][4];
    system_forces forces;
    double size[2]; /* of the correction in each half */
} newmark_step;

/* Squares of what each way would have missed a0 by, for each unknown. */
INLINE void sum_misses(const double *const a[NEWMARK_HISTORY + 1], int first, int end,
                       double missed[WAYS][4])
{
    const double *a0 = a[0], *a1 = a[1], *a2 = a[2], *a3 = a[3], *a4 = a[4];
    for (int i = 0; i < 4; i += LANES) {
        lanes line = {0.0}, parabola = {0.0}, cubic = {0.0}, alternating = {0.0};
        for (int j = first + i; j < end; j += 4) {
            const lanes x0 = LANES_AT(a0 + j), x1 = LANES_AT(a1 + j), x2 = LANES_AT(a2 + j),
                        x3 = LANES_AT(a3 + j);
            const lanes x4 = LANES_AT(a4 + j);
            const lanes bend = x0 - 2.0 * x1 + x2, bend_before = x1 - 2.0 * x2 + x3;
            const lanes miss = bend - bend_before, sum = bend + bend_before;
            const lanes miss_before = bend_before - (x2 - 2.0 * x3 + x4);
            line += bend * bend;
            parabola += miss * miss;
            cubic += (miss - miss_before) * (miss - miss_before);
            alternating += sum * sum;
        }
        LANES_AT(missed[LINE] + i) = line;
        LANES_AT(missed[PARABOLA] + i) = parabola;
        LANES_AT(missed[CUBIC] + i) = cubic;
        LANES_AT(missed[ALTERNATING] + i) = alternating;
    }
}
PATHS(sum_misses,
      (const double *const a[NEWMARK_HISTORY + 1], int first, int end, double missed[WAYS][4]),
      (a, first, end, missed))

/* For each unknown that way which would have led from the steps before closest to a0. */
static void choose(const newmark_step *s, double weight[NEWMARK_HISTORY][4])
{
    for (int i = 0; i < 4; i++) {
        int best = LINE;
        double least = INFINITY;
        for (int way = 0; way < WAYS; way++) {
            double missed = s->missed[0][way][i];
            for (int h = 1; h < s->model->halves; h++) missed += s->missed[h][way][i];
            if (way > 0 && !(missed < least)) continue;
            best = way;
            least = missed;
        }
        for (int k = 0; k < NEWMARK_HISTORY; k++) weight[k][i] = extrapolation[best][k];
    }
}

/* The start of the step is kept. */
static void begin_half(void *task, int half)
{
    newmark_step *s = task;
    const line_half *own = &s->model->half[half];
    time_keep_half(s->model, s->at, half);
    if (s->extrapolates) ON_PATH(s->model->fused, sum_misses)
    (s->past, 4 * own->node[0], 4 * own->node[1], s->missed[half]);
}

/* The acceleration is extrapolated from the last ones.  Without enough of them by equal steps their
 * mean must do: it is not led astray by what changes sign. */
INLINE void predict(const newmark_step *s, int first, int end)
{
    const state_view *at = s->at;
    const weights w = s->w;
    const double h = s->h, *u0 = at->u0, *v0 = at->v0;
    const double *a0 = s->past[0], *a1 = s->past[1], *a2 = s->past[2], *a3 = s->past[3];
    double *u = at->u, *v = at->v, *a = at->a;
    const double u_by_a0 = h * h * (0.5 - w.beta), u_by_a = h * h * w.beta;
    const double v_by_a0 = h * (1.0 - w.gamma), v_by_a = h * w.gamma;
    for (int i = 0; i < 4; i += LANES) {
        const lanes by_a0 = LANES_AT(s->weight[0] + i), by_a1 = LANES_AT(s->weight[1] + i);
        const lanes by_a2 = LANES_AT(s->weight[2] + i), by_a3 = LANES_AT(s->weight[3] + i);
        for (int j = first + i; j < end; j += 4) {
            const lanes x0 = LANES_AT(a0 + j);
            const lanes x1 = LANES_AT(a1 + j), x2 = LANES_AT(a2 + j), x3 = LANES_AT(a3 + j);
            const lanes guess = by_a0 * x0 + by_a1 * x1 + by_a2 * x2 + by_a3 * x3;
            LANES_AT(u + j) =
                LANES_AT(u0 + j) + h * LANES_AT(v0 + j) + u_by_a0 * x0 + u_by_a * guess;
            LANES_AT(v + j) = LANES_AT(v0 + j) + v_by_a0 * x0 + v_by_a * guess;
            LANES_AT(a + j) = guess;
        }
    }
}
PATHS(predict, (const newmark_step *s, int first, int end), (s, first, end))

/* The motion at which forces are balanced. */
TWO_PATHS static void interpolate_alpha(const state_view *at, weights w, int first, int end)
{
    for (int i = first; i < end; i++) {
        at->stage_u[i] = at->u[i] + w.alpha_f * (at->u0[i] - at->u[i]);
        at->stage_v[i] = at->v[i] + w.alpha_f * (at->v0[i] - at->v[i]);
        at->stage_a[i] = at->a[i] + w.alpha_m * (at->a0[i] - at->a[i]);
    }
}

/* The ends follow their prescribed motion. */
static void predict_half(void *task, int half)
{
    const newmark_step *s = task;
    const line_half *own = &s->model->half[half];
    const state_view *at = s->at;
    const int first = 4 * own->node[0], end = 4 * own->node[1];
    ON_PATH(s->model->fused, predict)(s, first, end);
    junction_prescribe_half(s->model, &at->now, half, at->u, at->v, at->a);
    if (s->within) interpolate_alpha(at, s->w, first, end);
}

/* Keeps the start of the step, and predicts its end. */
static void start(newmark_step *s)
{
    static const double mean[2] = {0.5, 0.5};
    const gallop_state *state = s->state;
    s->past[0] = s->at->a0;
    for (int k = 1; k <= NEWMARK_HISTORY; k++) s->past[k] = before(s->model, state, s->at, k);
    if (!isfinite(state->step_before)) s->past[1] = s->at->a0;
    s->extrapolates = s->h == state->step_before && state->equal_steps == NEWMARK_HISTORY;
    for (int k = 0; k < NEWMARK_HISTORY; k++)
        for (int i = 0; i < 4; i++) s->weight[k][i] = k < 2 ? mean[k] : 0.0;
    team_share(s->at->team, s->model->halves, begin_half, s);
    if (s->extrapolates) choose(s, s->weight);
    team_share(s->at->team, s->model->halves, predict_half, s);
}

/* A step that was found. */
typedef struct {
    const gallop_model *model;
    const state_view *at;
    double *kept; /* place of its a0 */
} found_step;

static void keep_acceleration(void *task, int half)
{
    const found_step *f = task;
    time_copy_half(f->model, half, f->at->a0, f->kept);
}

/* The step just found is the one before from now on. */
void time_newmark_commit(const gallop_model *model, gallop_state *state, state_view *at, double h)
{
    state->newest = (state->newest + NEWMARK_HISTORY - 1) % NEWMARK_HISTORY;
    found_step found = {model, at, before(model, state, at, 1)};
    team_share(at->team, model->halves, keep_acceleration, &found);
    if (h != state->step_before) state->equal_steps = 0;
    if (state->equal_steps < NEWMARK_HISTORY) state->equal_steps++;
    state->step_before = h;
}

/* Takes the solution from u, v and a; returns its size. */
INLINE double correct(const newmark_step *s, int first, int end)
{
    const double per_v = s->per_v, per_a = s->per_a, *restrict change = s->at->residual;
    double *restrict u = s->at->u, *restrict v = s->at->v, *restrict a = s->at->a;
    correction_size seen = {{{0.0}}, {{0.0}}};
    for (int n = first; n < end; n += 4)
        for (int i = n; i < n + 4; i += LANES) {
            const lanes x = LANES_AT(change + i);
            LANES_AT(u + i) -= x;
            LANES_AT(v + i) -= per_v * x;
            LANES_AT(a + i) -= per_a * x;
            time_note_size(&seen, (i - n) / LANES, &x);
        }
    return time_size_of(&seen);
}
VALUE_PATHS(double, correct, (const newmark_step *s, int first, int end), (s, first, end))

static void find_forces(void *task, int half)
{
    newmark_step *s = task;
    system_find_forces(&s->forces, half);
}

static void correct_half(void *task, int half)
{
    newmark_step *s = task;
    const line_half *own = &s->model->half[half];
    const int first = 4 * own->node[0], end = 4 * own->node[1];
    s->size[half] = ON_PATH(s->model->fused, correct)(s, first, end);
    if (s->within) interpolate_alpha(s->at, s->w, first, end);
}

/* An iteration, with a new tangent if its weights are given.  False: it is not positive definite.
 */
static bool iterate(newmark_step *s, const tangent_weights *mix, monitor *seen)
{
    const system_forces *f = &s->forces;
    const solver_equations equations = {SOLVER_REAL, f->of.now, f->of.y, mix, f->residual};
    const solver_frame frame = {find_forces, correct_half, s};
    s->forces.of.slopes = mix != NULL;
    element_monitor_start(seen);
    const bool solved =
        solver_run(s->model, s->at, SOLVER_JUNCTIONS_AS_IN_SCENE, &equations, 1, &frame);
    system_notice(f, seen);
    return solved;
}

/* Tensions at the end of a step within which forces are balanced. */
static void notice_end(const newmark_step *s, monitor *seen)
{
    for (int half = 0; half < s->model->halves; half++)
        element_monitor_tensions(s->model, half, &s->at->now, s->at->u, seen);
}

/* One step from u0 v0 a0 at t - h to u v a at t. */
int time_newmark(const gallop_model *model, gallop_state *state, state_view *at,
                 const gallop_inputs *inputs, double t, double h, double tolerance,
                 gallop_report *report)
{
    const weights w = weights_of(model);
    const double per_v = w.gamma / (w.beta * h), per_a = 1.0 / (w.beta * h * h);
    const tangent_weights mix = {1.0 - w.alpha_f, (1.0 - w.alpha_f) * per_v,
                                 (1.0 - w.alpha_m) * per_a};
    const bool within = model_by_alpha(model);
    const motion y = within ? (motion){at->stage_u, at->stage_v, at->stage_a}
                            : (motion){at->u, at->v, at->a}; /* where forces are balanced */
    conditions *now = within ? &at->stage[0] : &at->now;
    const double balanced = t - w.alpha_f * h;
    bool renew = state->factored_step != h, fresh = false;
    double size_before = 0.0;
    monitor seen = {0};
    newmark_step step; /* not all of it is used */
    step.model = model;
    step.state = state;
    step.at = at;
    step.w = w;
    step.within = within;
    step.h = h;
    step.per_v = per_v;
    step.per_a = per_a;
    step.forces.model = model;
    step.forces.time = balanced;
    step.forces.of = (element_state){now, &at->sections, y, false};
    step.forces.residual = at->residual;
    conditions_at(model, t, inputs, &at->now);
    start(&step);
    if (within) conditions_at(model, balanced, inputs, now);
    for (int iteration = 1; iteration <= model->scene.settings.max_newton_iterations; iteration++) {
        if (renew) state->factored_step = 0.0;
        if (!iterate(&step, renew ? &mix : NULL, &seen))
            return report_failure(report, GALLOP_NEWTON_STALLED, seen.slack_element, t, NAN,
                                  tolerance);
        if (renew) {
            state->factored_step = h;
            state->rate = 1.0;
            state->refactorisations++;
            renew = false;
            fresh = true;
            size_before = 0.0;
        }
        const double size = time_larger_size(step.size, model->halves);
        state->iterations++;
        state->last_iterations++;
        if (!isfinite(size)) return report_failure(report, GALLOP_NON_FINITE, -1, t, size, 0.0);
        switch (time_newton_next(state, size, size_before, fresh, tolerance)) {
        case NEWTON_CONVERGED:
            if (within) notice_end(&step, &seen);
            return time_newton_accept(state, &seen, t, report);
        case NEWTON_DIVERGED:
            return report_failure(report, GALLOP_NEWTON_STALLED, seen.slack_element, t, size,
                                  tolerance);
        case NEWTON_REFACTORISE: renew = true; break;
        case NEWTON_CONTINUE: break;
        }
        size_before = size;
    }
    return report_failure(report, GALLOP_NEWTON_STALLED, seen.slack_element, t, size_before,
                          tolerance);
}
