/* March in time: whole steps, halved where they do not converge, to the times that are asked for;
 * initial states. */
#include "base_math.h"
#include "check.h"
#include "junction.h"
#include "observe.h"
#include "statics.h"
#include "time_integration.h"

/* One step of size h from the state's time, halved where it does not converge; on failure the
 * motion is as before. */
static int whole_step(const gallop_model *model, gallop_state *state, state_view *at,
                      const gallop_inputs *inputs, double h, gallop_report *report)
{
    const size_t bytes =
        4 * (size_t)model->nodes * sizeof(double); /* u v a lie side by side, as do u0 v0 a0 */
    const int deepest = model->scene.settings.max_halvings;
    const uint64_t whole = (uint64_t)1 << deepest;
    const double step_before = state->step_before;
    const int64_t equal_steps = state->equal_steps, newest = state->newest;
    uint64_t done = 0;
    int level = 0;
    state->last_iterations = state->last_substeps = 0;
    while (done < whole) {
        uint64_t unit = whole >> level;
        double part = h / (double)((uint64_t)1 << level);
        double t = state->time + h * (double)(done + unit) / (double)whole;
        const double tolerance = time_newton_tolerance(model, state);
        int outcome = model_by_gauss(model)
                        ? time_gauss(model, state, at, inputs, t, part, tolerance, report)
                        : time_newmark(model, state, at, inputs, t, part, tolerance, report);
        if (outcome == GALLOP_COMPLETED) {
            done += unit;
            state->last_substeps++;
            if (model->unknowns == 4) time_remember_turn(model, state, at);
            if (model_by_gauss(model))
                time_gauss_commit(model, state, at, part);
            else
                time_newmark_commit(model, state, at, part);
            if (level > 0 && done % (whole >> (level - 1)) == 0) level--;
            continue;
        }
        state->factored_step = 0.0;
        memcpy(at->u, at->u0, 3 * bytes);
        if (!time_may_halve(outcome) || level == deepest) {
            if (level == 0) return outcome;
            memcpy(at->u, at->first, state_motion_bytes(model));
            state->step_before = step_before;
            state->equal_steps = equal_steps;
            state->newest = newest;
            return outcome;
        }
        if (level == 0) memcpy(at->first, at->u, state_motion_bytes(model));
        level++;
        state->halvings++;
    }
    state->substeps += state->last_substeps;
    state->steps++;
    return GALLOP_COMPLETED;
}

/* By tolerance, to `until` or not before it. */
static int march_by_tolerance(const gallop_model *model, gallop_state *state, state_view *at,
                              const gallop_inputs *inputs, double until, bool exactly,
                              gallop_report *report)
{
    const int outcome = time_controlled_march(model, state, at, inputs, until, exactly, report);
    if (!outcome) report_completed(report, fmin(state->time, until));
    state_report_work(state, report);
    return outcome;
}

/* One step of size h to the time `end`; it is split where ice falls. */
static int step_to(const gallop_model *model, gallop_state *state, state_view *at,
                   const gallop_inputs *inputs, double h, double end, gallop_report *report)
{
    double next;
    int outcome;
    while ((next = time_next_shedding(model, at, state->time, end)) < end) {
        outcome = whole_step(model, state, at, inputs, next - state->time, report);
        if (outcome) return outcome;
        state->time = next;
        outcome = time_shed(model, state, at, report);
        if (outcome) return outcome;
        h = end - next;
    }
    outcome = whole_step(model, state, at, inputs, h, report);
    if (outcome) return outcome;
    state->time = end;
    return time_shed(model, state, at, report);
}

/* `count` steps of size h, the first being number `before` + 1 since `origin`. */
typedef struct {
    double origin, h;
    int64_t before, count;
} equal_steps;

/* Times are products, so that round-off neither adds up nor depends on where a run is interrupted
 * to record. */
static int march(const gallop_model *model, gallop_state *state, state_view *at,
                 const gallop_inputs *inputs, const equal_steps *steps, gallop_report *report)
{
    for (int64_t i = 1; i <= steps->count; i++) {
        const double end = steps->origin + steps->h * (double)(steps->before + i);
        const int outcome = step_to(model, state, at, inputs, steps->h, end, report);
        if (outcome) {
            state_report_work(state, report);
            return outcome;
        }
    }
    report_completed(report, state->time); /* without sub-steps that failed on the way */
    state_report_work(state, report);
    return GALLOP_COMPLETED;
}

/* gallop_rewind returns to what gallop_advance saved, unless the state has gone on otherwise. */
static void forget_saved(const state_view *at)
{
    memset(at->saved, 0, sizeof(gallop_state));
}

int gallop_advance(const gallop_model *model, gallop_state *state, const gallop_inputs *inputs,
                   double until, gallop_report *report)
{
    int outcome = check_state(model, state, report);
    if (!outcome) outcome = check_inputs(model, inputs, until, report);
    if (outcome) return outcome;
    const double dt = model->scene.settings.time_step, origin = state->time, span = until - origin;
    if (!isfinite(until) || !(span > 0.0))
        return report_refused(report, "time, which must be finite and after the state's", until,
                              origin);
    if (span / dt > MAX_STEPS)
        return report_refused(report, "number of steps", span / dt, MAX_STEPS);
    int64_t count = (int64_t)ceil(span / dt - 1e-6);
    if (count < 1) count = 1;
    double h = span / (double)count;
    /* round-off in the host's clock must not cost a factorisation */
    if (fabs(h - dt) < 1e-9 * dt)
        h = dt;
    else if (fabs(h - state->step_before) < 1e-9 * h)
        h = state->step_before;
    state_view at = state_view_of(model, state);
    memcpy(at.saved, state, model->saved_size);
    outcome = model_by_tolerance(model)
                ? march_by_tolerance(model, state, &at, inputs, until, true, report)
                : march(model, state, &at, inputs, &(equal_steps){origin, h, 0, count}, report);
    if (outcome == GALLOP_COMPLETED) {
        state->time = until;
        time_round_sheddings(model, &at, until);
    } else {
        memcpy(state, at.saved, model->saved_size);
        forget_saved(&at);
    }
    return outcome;
}

/* The records are possible. */
static int check_records(const gallop_model *model, const gallop_state *state, int64_t first,
                         int64_t records, int64_t every, gallop_report *report)
{
    if (every < 1)
        return report_refused(report, "every, which must be positive", (double)every, 1.0);
    if (first < 0)
        return report_refused(report, "first, which must not be negative", (double)first, 0.0);
    if (records < 0) return report_refused(report, "number of records", (double)records, 0.0);
    const int64_t most = (int64_t)MAX_STEPS / every;
    if (first > most || records > most - first)
        return report_refused(report, "number of steps",
                              ((double)first + (double)records) * (double)every, MAX_STEPS);
    if (!(state->time + model->scene.settings.time_step > state->time))
        return report_refused(report, "time step, which is lost in the round-off of the time",
                              model->scene.settings.time_step, NAN);
    return GALLOP_COMPLETED;
}

int gallop_run(const gallop_model *model, gallop_state *state, int64_t first, int64_t records,
               int64_t every, const gallop_probe *probe, int32_t probes, double *values,
               int64_t *done, gallop_report *report)
{
    return gallop_run_in_team(model, state, first, records, every, probe, probes, values, done,
                              NULL, report);
}

int gallop_run_in_team(const gallop_model *model, gallop_state *state, int64_t first,
                       int64_t records, int64_t every, const gallop_probe *probe, int32_t probes,
                       double *values, int64_t *done, gallop_team *team, gallop_report *report)
{
    int refused = check_state(model, state, report);
    if (refused) return refused;
    if (!base_pointer_usable(done, WORD)) return report_refused(report, NOT_USABLE(done), NAN, NAN);
    *done = 0;
    refused = check_records(model, state, first, records, every, report);
    if (!refused) refused = check_probes(model, probe, probes, report);
    if (refused) return refused;
    if (records > 0 && probes > 0 && !base_pointer_usable(values, WORD))
        return report_refused(report, NOT_USABLE(values), NAN, NAN);
    if (team && !base_pointer_usable(team, WORD))
        return report_refused(report, NOT_USABLE(team), NAN, NAN);
    const double dt = model->scene.settings.time_step,
                 start = state->time - (double)(first * every) * dt;
    const bool free = model_by_tolerance(model);
    const double began = state->time;
    state_view at = state_view_of(model, state);
    at.team = team;
    conditions_copy(model, &at.looked_from, &at.now);
    forget_saved(&at);
    if (free && first == 0) state->run_origin = state->time;
    for (int64_t r = 0; r < records; r++) {
        const double when = state->run_origin + (double)((first + r + 1) * every) * dt;
        const int outcome =
            free ? march_by_tolerance(model, state, &at, NULL, when, false, report)
                 : march(model, state, &at, NULL,
                         &(equal_steps){start, dt, (first + r) * every, every}, report);
        if (outcome) { /* the failed step has left its own wind and tower motion */
            if (state->time == began)
                conditions_copy(model, &at.now, &at.looked_from);
            else
                conditions_at(model, state->time, NULL, &at.now);
            return outcome;
        }
        at.now.time = state->time;
        if (free) time_control_look(model, state, &at, when);
        observe_probes(model, state, &at, probe, probes, values + (size_t)r * (size_t)probes);
        if (free) time_control_return(model, &at);
        *done = r + 1;
    }
    return GALLOP_COMPLETED;
}

/* Accelerations from rest, but for the towers. */
static int start_motion(const gallop_model *model, gallop_state *state, state_view *at,
                        gallop_report *report)
{
    memset(at->v, 0, 4 * (size_t)model->nodes * sizeof(double));
    junction_prescribe(model, &at->now, NULL, at->v, NULL);
    return time_accelerate(model, state, at, report);
}

static void clear(const gallop_model *model, gallop_state *state, double time,
                  const gallop_inputs *inputs)
{
    memset(state, 0, model->state_size);
    state->time = time;
    state->last_substeps = 1;
    state->sharpness = 1.0;
    state->step_before = INFINITY; /* no acceleration before the first to extrapolate from */
    state->lowest_tension = INFINITY;
    const state_view at = state_view_of(model, state);
    time_start_sheddings(model, &at);
    conditions now = at.now;
    conditions_at(model, time, inputs, &now);
}

/* A block that holds an initial state is a state of the model from now on; after a failure it is
 * none. */
static int started(const gallop_model *model, gallop_state *state, int outcome,
                   gallop_report *report)
{
    if (outcome) return outcome;
    check_mark_state(model, state);
    state_report_work(state, report);
    return GALLOP_COMPLETED;
}

int gallop_equilibrium(const gallop_model *model, gallop_state *state, double time,
                       const gallop_inputs *inputs, gallop_report *report)
{
    int outcome = check_room(model, state, time, report);
    if (!outcome) outcome = check_inputs(model, inputs, time, report);
    if (outcome) return outcome;
    clear(model, state, time, inputs);
    state_view at = state_view_of(model, state);
    time_shed_by_time(model, state, &at, time);
    outcome = statics_equilibrium(model, time, false, &at, report);
    time_control_start(model, state, at.u);
    if (!outcome) outcome = start_motion(model, state, &at, report);
    return started(model, state, outcome, report);
}

int gallop_settle(const gallop_model *model, gallop_state *state, gallop_report *report)
{
    int outcome = check_state(model, state, report);
    if (outcome) return outcome;
    state_view at = state_view_of(model, state);
    memcpy(at.saved, state, model->saved_size);
    conditions_at(model, state->time, NULL, &at.now);
    outcome = statics_equilibrium(model, state->time, true, &at, report);
    for (int f = 0; f < model->field_count; f++) at.now.wind[f] = 0.0;
    conditions_blow(model, false, &at.now);
    at.now.load_factor = 0.0;
    if (!outcome) outcome = start_motion(model, state, &at, report);
    if (outcome) {
        memcpy(state, at.saved, model->saved_size);
    } else {
        state->step_before = INFINITY;
        state->equal_steps = 0;
    }
    forget_saved(&at);
    return outcome;
}

void time_add_seed(const gallop_model *model, double *u)
{
    static const bool nothing_fixed[4] = {false};
    const gallop_settings *s = &model->scene.settings;
    const double seed[4] = {0.0, s->seed_vertical, s->seed_horizontal, s->seed_twist};
    for (int i = 0; i < model->chain_count; i++) {
        const chain *c = &model->chain[i];
        const junction *left = &model->junction[c->junction[0]];
        const junction *right = &model->junction[c->junction[1]];
        const double start = left->position[0] + left->moved[0];
        const double span = c->span + right->moved[0] - left->moved[0];
        const kept_corner *kept = c->kept + 1; /* of the nodes from n on */
        for (int n = 1; n <= c->nodes - 2; n++) {
            const double shape = sin(PI * (c->x[3 * n] - start) / span);
            const bool *fixed =
                n == 2 * kept->corner ? model->junction[kept++->junction].fixed : nothing_fixed;
            double *node = u + 4 * (c->first_node + n);
            for (int k = 1; k < 4; k++)
                if (!fixed[k]) node[k] += seed[k] * shape;
        }
    }
}

int gallop_state_init(const gallop_model *model, gallop_state *state, double start,
                      const gallop_inputs *inputs, gallop_report *report)
{
    int outcome = check_room(model, state, start, report);
    if (!outcome) outcome = check_inputs(model, inputs, start, report);
    if (outcome) return outcome;
    const gallop_scene *s = &model->scene;
    clear(model, state, start, inputs);
    state_view at = state_view_of(model, state);
    bool displaced = false;
    for (int i = 0; i < 3 * model->junction_count; i++)
        displaced = displaced || at.now.position[i] != 0.0;
    if (s->settings.start_in_mean_wind || s->settings.strung || displaced) {
        outcome = statics_equilibrium(model, start, !s->settings.start_in_mean_wind, &at, report);
        if (outcome) return outcome;
    }
    time_add_seed(model, at.u);
    time_control_start(model, state, at.u);
    time_shed_by_time(model, state, &at, start);
    outcome = start_motion(model, state, &at, report);
    return started(model, state, outcome, report);
}

int gallop_state_place(const gallop_model *model, gallop_state *state, double start,
                       const gallop_inputs *inputs, const double *u, const double *v,
                       gallop_report *report)
{
    int outcome = check_room(model, state, start, report);
    if (!outcome) outcome = check_inputs(model, inputs, start, report);
    if (outcome) return outcome;
    const size_t values = 4 * (size_t)model->nodes;
    if (!base_pointer_usable(u, WORD) || !check_finite(u, values))
        return report_refused(report, "u, which must be finite numbers", NAN, NAN);
    if (!base_pointer_usable(v, WORD) || !check_finite(v, values))
        return report_refused(report, "v, which must be finite numbers", NAN, NAN);
    clear(model, state, start, inputs);
    state_view at = state_view_of(model, state);
    memcpy(at.u, u, values * sizeof(double));
    memcpy(at.v, v, values * sizeof(double));
    junction_prescribe(model, &at.now, at.u, at.v, NULL);
    time_control_start(model, state, at.u);
    time_shed_by_time(model, state, &at, start);
    outcome = time_accelerate(model, state, &at, report);
    return started(model, state, outcome, report);
}

gallop_state *gallop_state_before(const gallop_model *model, gallop_state *state)
{
    gallop_report report;
    if (check_state(model, state, &report)) return NULL;
    return (gallop_state *)state_view_of(model, state).saved;
}

int gallop_rewind(const gallop_model *model, gallop_state *state, double sharpness)
{
    gallop_report report;
    const int outcome = check_state(model, state, &report);
    if (outcome || !(sharpness > 0.0 && sharpness <= 1.0)) return GALLOP_BAD_CALL;
    const state_view at = state_view_of(model, state);
    if (!check_is_state_of(model, (const gallop_state *)at.saved)) return GALLOP_BAD_CALL;
    memcpy(state, at.saved, model->saved_size);
    state->sharpness = sharpness;
    return GALLOP_COMPLETED;
}

double gallop_state_time(const gallop_state *state)
{
    return check_is_started(state) ? state->time : NAN;
}
