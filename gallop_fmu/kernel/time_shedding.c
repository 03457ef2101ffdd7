/* Ice that falls: at a time of the scene or by a limit of acceleration, at the end of a step.
 * Position and velocity are continuous; the acceleration jumps. */
#include "check.h"
#include "observe.h"
#include "time_integration.h"

/* Part of a time step by which ice may fall early: no step is shorter. */
#define MIN_PART 1e-9

static double negligible(const gallop_model *model)
{
    return MIN_PART * model->scene.settings.time_step;
}

void time_start_sheddings(const gallop_model *model, const state_view *at)
{
    for (int i = 0; i < model->shedding_count; i++) at->fallen[i] = INFINITY;
}

double time_next_shedding(const gallop_model *model, const state_view *at, double t, double end)
{
    const double least = negligible(model);
    double next = INFINITY;
    for (int i = 0; i < model->shedding_count; i++)
        if (!(at->fallen[i] < INFINITY) && model->shedding_time[i] > t + least)
            next = fmin(next, model->shedding_time[i]);
    return next < end - least ? next : INFINITY;
}

static void energies(const gallop_model *model, const gallop_state *state, const state_view *at,
                     double energy[2])
{
    const gallop_probe both[2] = {
        {.object = GALLOP_PROBE_SYSTEM, .channel = GALLOP_KINETIC_ENERGY},
        {.object = GALLOP_PROBE_SYSTEM, .channel = GALLOP_POTENTIAL_ENERGY}};
    observe_probes(model, state, at, both, 2, energy);
}

/* The ice of an item falls at time t; the energy that the motion then has less is that of the ice.
 */
static void shed(const gallop_model *model, const gallop_state *state, const state_view *at, int i,
                 double t)
{
    double before[2], after[2];
    energies(model, state, at, before);
    at->fallen[i] = t;
    energies(model, state, at, after);
    for (int k = 0; k < 2; k++) at->lost[2 * i + k] = before[k] - after[k];
}

bool time_shed_by_time(const gallop_model *model, const gallop_state *state, const state_view *at,
                       double t)
{
    bool any = false;
    for (int i = 0; i < model->shedding_count; i++) {
        if (at->fallen[i] < INFINITY || model->shedding_time[i] > t + negligible(model)) continue;
        shed(model, state, at, i, t);
        any = true;
    }
    return any;
}

/* The largest acceleration of a node of an interval across the conductor, squared. */
static double largest_across(const gallop_model *model, const interval *c, const double *a)
{
    double largest = 0.0;
    for (int n = c->first_node; n < c->first_node + c->nodes; n++) {
        const double *of_node = a + 4 * n, *n2 = model->normal + 2 * n;
        const double up = n2[0] * of_node[0] + n2[1] * of_node[1];
        largest = fmax(largest, up * up + of_node[2] * of_node[2]);
    }
    return largest;
}

static bool shed_by_acceleration(const gallop_model *model, const gallop_state *state,
                                 const state_view *at, double t)
{
    bool any = false;
    for (int i = 0; i < model->interval_count; i++) {
        const interval *c = &model->interval[i];
        if (c->shedding < 0 || at->fallen[c->shedding] < INFINITY) continue;
        const double limit = model->scene.shedding[c->shedding].acceleration;
        if (!(limit < INFINITY) || !(largest_across(model, c, at->a) > limit * limit)) continue;
        shed(model, state, at, c->shedding, t);
        any = true;
    }
    return any;
}

int time_shed(const gallop_model *model, gallop_state *state, state_view *at, gallop_report *report)
{
    if (model->shedding_count == 0) return GALLOP_COMPLETED;
    at->now.time = state->time;
    const bool by_acceleration = shed_by_acceleration(model, state, at, state->time);
    if (!time_shed_by_time(model, state, at, state->time) && !by_acceleration)
        return GALLOP_COMPLETED;

    /* the accelerations before do not continue in those that follow */
    state->step_before = INFINITY;
    state->equal_steps = 0;
    return time_accelerate(model, state, at, report);
}

void time_round_sheddings(const gallop_model *model, const state_view *at, double t)
{
    for (int i = 0; i < model->shedding_count; i++)
        if (at->fallen[i] < INFINITY) at->fallen[i] = fmin(at->fallen[i], t);
}

int gallop_shedding_energies(const gallop_model *model, const gallop_state *state, double *energy)
{
    gallop_report report;
    if (check_state(model, state, &report) || !base_pointer_usable(energy, WORD))
        return GALLOP_BAD_CALL;
    const state_view view = state_view_of(model, (gallop_state *)state); /* only read */
    memcpy(energy, view.lost, 2 * (size_t)model->shedding_count * sizeof *energy);
    return GALLOP_COMPLETED;
}

int gallop_shedding_times(const gallop_model *model, const gallop_state *state, double *time)
{
    gallop_report report;
    if (check_state(model, state, &report) || !base_pointer_usable(time, WORD))
        return GALLOP_BAD_CALL;
    const state_view view = state_view_of(model, (gallop_state *)state); /* only read */
    memcpy(time, view.fallen, (size_t)model->shedding_count * sizeof *time);
    return GALLOP_COMPLETED;
}
