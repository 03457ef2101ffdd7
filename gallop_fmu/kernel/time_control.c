/* Steps as long as a tolerance allows.  The local error is estimated from the accelerations: what
 * Gauss's parabolas miss is the cubic part, and that is seen in the difference between the parabola
 * of the step before, continued, and the one found.  Step sizes are powers of sqrt(2), so that a
 * factorised tangent serves for many steps.  Steps end where a law has a kink; between, the motion
 * is read off a quintic. */
#include "base_glibc.h"
#include "base_math.h"
#include "law.h"
#include "time_integration.h"

/* Error of a step in units of the cubic part of h^2 a.  Calibrated so that the error of whole runs
 * stays within three tolerances where these are 1e-3 to 1e-7 (tests/convergence/test_tolerance.py).
 */
#define ERROR_CONSTANT 0.01

#define SAFETY_FACTOR 0.8  /* on the step size that the estimate allows */
#define MAX_STEP_RATIO 4.0 /* of the step size */
#define GROWTH_ITERATION_LIMIT                                                                     \
    6 /* a step that took so many does not grow: it would cost more than it gains */
#define NEWTON_TOLERANCE_SHARE 0.01 /* of the tolerance, left to Newton's iteration */
#define MIN_NEWTON_TOLERANCE 1e-13  /* [m], above round-off */

#define EQUALISE_BELOW_STEPS 8.0 /* to a limit */
#define MIN_STEP 1e-10           /* step [s], and part of the time, that is still a step */

/* An error of fast twist counts for more: where its frequency is above so many times that of the
 * span's swing, and up to so many times more.  Calibrated likewise. */
#define FAST_TWIST_RATIO 8.0
#define MAX_TWIST_WEIGHT 30.0

/* Motion smaller than this is not resolved to the tolerance: in diameters, and in rad. */
#define SMALL_DISPLACEMENT 0.01
#define SMALL_TWIST 0.01

/* Root mean square of one unknown over the nodes. */
static double mean_size(const gallop_model *model, const double *y, int unknown)
{
    double sum = 0.0;
    for (int n = 0; n < model->nodes; n++) sum += y[4 * n + unknown] * y[4 * n + unknown];
    return sqrt(sum / model->nodes);
}

static double scale_of(const gallop_model *model, const gallop_state *state, int unknown)
{
    return fmax(state->largest[unknown],
                unknown < 3 ? SMALL_DISPLACEMENT * model->section[0].diameter : SMALL_TWIST);
}

static void grow_scales(const gallop_model *model, gallop_state *state, const double *u)
{
    for (int i = 1; i < 4; i++) state->largest[i] = fmax(state->largest[i], mean_size(model, u, i));
}

double time_newton_tolerance(const gallop_model *model, const gallop_state *state)
{
    if (!model_by_tolerance(model)) {
        const double given = model->scene.settings.newton_tolerance;
        return fmax(given * state->sharpness, fmin(given, MIN_NEWTON_TOLERANCE));
    }
    double smallest = INFINITY;
    for (int i = 1; i < model->unknowns; i++) smallest = fmin(smallest, scale_of(model, state, i));
    return fmax(NEWTON_TOLERANCE_SHARE * model->scene.settings.tolerance * smallest *
                    state->sharpness,
                MIN_NEWTON_TOLERANCE);
}

/* Circular frequency of the slowest swing, of a taut string between the junctions [1/s]. */
static double lowest_swing(const gallop_model *model)
{
    double lowest = INFINITY;
    for (int i = 0; i < model->chain_count; i++) {
        const chain *c = &model->chain[i];
        lowest = fmin(lowest, PI / c->span * sqrt(c->horizontal_tension / c->mass));
    }
    return lowest;
}

/* What an error of the twist counts for.  While a span swings once it may twist to and fro sixty
 * times, and errors of phase add up.  The frequency of the part of the motion that the step misses
 * is seen in its fifth derivative over the third; that of the swing is a taut string's. */
static double twist_weight(const gallop_model *model, const state_view *at, double h,
                           double cubic_part)
{
    const double swing = lowest_swing(model);
    const double turning = sqrt(6.0 * cubic_part / time_gauss_linear_part(model, at, h, 3)) / h;
    return fmin(fmax(turning / (FAST_TWIST_RATIO * swing), 1.0), MAX_TWIST_WEIGHT);
}

/* Error of the step just found in units of the tolerance: of the transverse displacements and the
 * twist, each relative to its largest motion so far.  Axial displacements are small, follow the
 * others, and are full of unresolved modes. */
static double error_of(const gallop_model *model, const gallop_state *state, state_view *at,
                       double h)
{
    double largest = 0.0;
    time_gauss_cubic_part(model, state, at, h, at->residual);
    for (int i = 1; i < model->unknowns; i++) {
        const double size = mean_size(model, at->residual, i),
                     weight = i == 3 ? twist_weight(model, at, h, size) : 1.0;
        largest = fmax(largest, weight * size / scale_of(model, state, i));
    }
    return ERROR_CONSTANT * largest / model->scene.settings.tolerance;
}

/* The largest power of sqrt(2) not above h [s]; above zero, however close a limit or a host's step
 * may be. */
static double floor_to_sqrt2_grid(double h)
{
    return exp2(0.5 * floor(2.0 * log2(fmax(h, MIN_STEP * MIN_STEP)) + 1e-6));
}

static double allowed_step(double h, double error)
{
    const double ratio = SAFETY_FACTOR * pow(fmax(error, 1e-12), -0.2);
    return floor_to_sqrt2_grid(h * fmin(fmax(ratio, 1.0 / MAX_STEP_RATIO), MAX_STEP_RATIO));
}

void time_control_start(const gallop_model *model, gallop_state *state, const double *u)
{
    memset(state->largest, 0, sizeof state->largest);
    grow_scales(model, state, u);
    state->wanted_step = floor_to_sqrt2_grid(model->scene.settings.time_step);
}

/* What follows from a step of size h that was found, or (outcome) was not: whether it stands, and
 * the next size. */
static bool accept_step(const gallop_model *model, gallop_state *state, state_view *at, double h,
                        int outcome)
{
    if (outcome) {
        state->factored_step = 0.0;
        state->halvings++;
        state->wanted_step = floor_to_sqrt2_grid(0.5 * h);
        return false;
    }
    const double error = error_of(model, state, at, h), allowed = allowed_step(h, error);
    if (!(error <= 1.0)) {
        state->rejections++;
        state->wanted_step = fmin(allowed, floor_to_sqrt2_grid(0.8 * h));
        return false;
    }
    if (allowed > state->wanted_step && state->last_iterations < GROWTH_ITERATION_LIMIT)
        state->wanted_step = allowed;
    return true;
}

/* Size of the next step where `left` remains to a limit: few steps to it are equal, as then one
 * tangent serves for all and, with a host's steady steps, for those that follow.  Round-off in the
 * host's clock does not count. */
static double next_size(const gallop_state *state, double left)
{
    double h = state->wanted_step;
    if (left < EQUALISE_BELOW_STEPS * h) h = left / fmax(1.0, ceil(left / h - 1e-6));
    return fabs(h - state->factored_step) < 1e-9 * h ? state->factored_step : h;
}

/* One step, as long as the tolerance allows, but not beyond `limit`.  On failure the motion is what
 * it was. */
static int step_within_tolerance(const gallop_model *model, gallop_state *state, state_view *at,
                                 const gallop_inputs *inputs, double limit, gallop_report *report)
{
    const size_t bytes = 4 * (size_t)model->nodes * sizeof(double);
    const double left = limit - state->time;
    int failures = 0;
    state->last_iterations = state->last_substeps = 0;
    for (;;) {
        const double h = next_size(state, left),
                     t = h > left * (1.0 - 1e-8) ? limit : state->time + h;
        state->last_substeps++;
        const int outcome =
            time_gauss(model, state, at, inputs, t, h, time_newton_tolerance(model, state), report);
        if (outcome &&
            (!time_may_halve(outcome) || failures++ == model->scene.settings.max_halvings)) {
            memcpy(at->u, at->u0, 3 * bytes);
            return outcome;
        }
        if (accept_step(model, state, at, h, outcome)) {
            time_gauss_commit(model, state, at, h);
            grow_scales(model, state, at->u);
            state->time = t;
            state->steps++;
            state->substeps += state->last_substeps;
            return GALLOP_COMPLETED;
        }
        memcpy(at->u, at->u0, 3 * bytes);
        if (h < MIN_STEP * fmax(1.0, fabs(state->time)))
            return report_failure(report, GALLOP_NEWTON_STALLED, -1, state->time, h,
                                  model->scene.settings.tolerance);
    }
}

/* Next time from t on at which speed, direction or gusts of a field have a kink or a jump.  Gusts
 * are linear between their times, as laws by table: steps that end there need no more time, and
 * miss less, than steps that an estimate of the error must shorten. */
static double next_kink_of_field(const gallop_model *model, int field, const gallop_inputs *inputs,
                                 double t)
{
    const gallop_field *f = &model->scene.field[field];
    const law *direction = inputs && inputs->direction ? NULL : model->direction[field];
    double next = inputs ? INFINITY : law_next_kink(model->wind[field], t);
    if (direction) next = fmin(next, law_next_kink(direction, t));
    if (f->kind == GALLOP_FIELD_VARIED && f->stations > 0) {
        const double *time = model->scene.number + f->first_gust + f->stations;
        next = fmin(next, law_next_time(time, f->times, f->repeat != 0, t));
    }
    return next;
}

/* Next time after t at which a law has a kink or a jump, or ice falls; infinite: none.  A host's
 * inputs replace all but the loads, gusts, and directions that they do not give. */
static double next_kink(const gallop_model *model, const state_view *at,
                        const gallop_inputs *inputs, double t)
{
    const gallop_scene *s = &model->scene;
    const double after = t + 1e-12 * (1.0 + fabs(t));
    double next = time_next_shedding(model, at, t, INFINITY);
    for (int i = 0; i < s->load_count; i++)
        next = fmin(next, law_next_kink(&model->law[s->load[i].law], after));
    for (int f = 0; f < model->field_count; f++)
        next = fmin(next, next_kink_of_field(model, f, inputs, after));
    if (inputs) return next;
    for (int j = 0; j < model->junction_count; j++)
        for (int i = 0; i < 3; i++) {
            const law *l = model->junction[j].motion[i];
            if (l) next = fmin(next, law_next_kink(l, after));
        }
    return next;
}

/* After a kink the accelerations before it say nothing about those that follow. */
static void forget_before(gallop_state *state)
{
    state->step_before = INFINITY;
}

/* Whether what a host sets differs from what acted before, or moves at another rate. */
static bool inputs_jump(const gallop_model *model, const conditions *before, const conditions *now)
{
    bool jump = before->attack[0] != now->attack[0];
    for (int f = 0; f < model->field_count; f++) jump = jump || before->wind[f] != now->wind[f];
    for (int f = 0; model->varied && f < model->field_count; f++)
        jump = jump || before->direction[f] != now->direction[f];
    for (int i = 0; i < 3 * model->junction_count; i++)
        jump = jump || before->velocity[i] != now->velocity[i];
    return jump;
}

/* Steps until the state's time is `until` (`exactly`), or not before it. */
int time_controlled_march(const gallop_model *model, gallop_state *state, state_view *at,
                          const gallop_inputs *inputs, double until, bool exactly,
                          gallop_report *report)
{
    if (inputs) {
        conditions_at(model, state->time, inputs, &at->stage[0]);
        if (inputs_jump(model, &at->now, &at->stage[0])) forget_before(state);
    }
    while (state->time < until) {
        const double kink = next_kink(model, at, inputs, state->time);
        int outcome = step_within_tolerance(model, state, at, inputs,
                                            exactly ? fmin(kink, until) : kink, report);
        if (outcome) return outcome;
        if (state->time == kink) forget_before(state);
        outcome = time_shed(model, state, at, report);
        if (outcome) return outcome;
    }
    return GALLOP_COMPLETED;
}

/* The motion at a time within the last step, until control_return: a quintic through displacement,
 * velocity and acceleration at both ends of the step. */
void time_control_look(const gallop_model *model, gallop_state *state, state_view *at, double t)
{
    const size_t bytes = 4 * (size_t)model->nodes * sizeof(double);
    memcpy(at->first, at->u, 3 * bytes);
    conditions_copy(model, &at->looked_from, &at->now);
    if (t == state->time) return;
    conditions_at(model, t, NULL, &at->now);
    time_gauss_read(model, state, at, t);
}

void time_control_return(const gallop_model *model, state_view *at)
{
    memcpy(at->u, at->first, 3 * 4 * (size_t)model->nodes * sizeof(double));
    conditions_copy(model, &at->now, &at->looked_from);
}
