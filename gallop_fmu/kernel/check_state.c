/* Check of a state that came as bytes: every number that the kernel reads is within its range. */
#include "check.h"

#define MAX_COUNT ((int64_t)1 << 53) /* counts are observed as doubles, and grow from here */

static bool counts_in_range(const gallop_state *state)
{
    const int64_t count[] = {
        state->steps,    state->substeps,   state->iterations,      state->refactorisations,
        state->halvings, state->rejections, state->last_iterations, state->last_substeps};
    for (size_t i = 0; i < sizeof count / sizeof *count; i++)
        if (count[i] < 0 || count[i] > MAX_COUNT) return false;
    return true;
}

/* Time, the steps so far and the next one. */
static bool steps_in_range(const gallop_state *state)
{
    return isfinite(state->time) && isfinite(state->run_origin) && state->factored_step >= 0.0 &&
           state->step_before > 0.0 && isfinite(state->last_step) && isfinite(state->wanted_step) &&
           state->wanted_step > 0.0;
}

/* Newton's iteration, and the history of Newmark's predictor. */
static bool history_in_range(const gallop_state *state)
{
    return state->rate >= 0.0 && state->sharpness > 0.0 && state->sharpness <= 1.0 &&
           state->newest >= 0 && state->newest < NEWMARK_HISTORY && state->equal_steps >= 0 &&
           state->equal_steps <= NEWMARK_HISTORY;
}

/* What a run reports: the lowest tension, the largest turn and the largest motions. */
static bool extremes_in_range(const gallop_state *state)
{
    bool ok = !isnan(state->lowest_tension) && isfinite(state->largest_turn) &&
              state->largest_turn >= 0.0;
    for (int i = 0; i < 4; i++) ok = ok && isfinite(state->largest[i]) && state->largest[i] >= 0.0;
    return ok;
}

/* Motion and its history; an unknown that the model leaves out is zero. */
static bool motion_in_range(const gallop_model *model, const gallop_state *state)
{
    const size_t count = state_motion_bytes(model) / sizeof(double);
    for (size_t i = 0; i < count; i++)
        if (!isfinite(state->values[i]) ||
            ((int)(i % 4) >= model->unknowns && state->values[i] != 0.0))
            return false;
    return true;
}

/* Ice has not fallen yet, or by now. */
static bool falls_in_range(const gallop_model *model, const gallop_state *state,
                           const state_view *view)
{
    for (int i = 0; i < model->shedding_count; i++) {
        const double fallen = view->fallen[i];
        if (isnan(fallen) || (fallen > state->time && fallen < INFINITY)) return false;
        if (!isfinite(view->lost[2 * i]) || !isfinite(view->lost[2 * i + 1])) return false;
    }
    return true;
}

int gallop_state_check(const gallop_model *model, const gallop_state *state)
{
    if (!check_is_model(model) || !check_is_state_of(model, state)) return GALLOP_BAD_CALL;
    const bool ok = counts_in_range(state) && steps_in_range(state) && history_in_range(state) &&
                    extremes_in_range(state) && motion_in_range(model, state);
    if (!ok) return GALLOP_BAD_CALL;
    const state_view view = state_view_of(model, (gallop_state *)state); /* only read */
    return conditions_are_finite(model, &view.now) && falls_in_range(model, state, &view)
             ? GALLOP_COMPLETED
             : GALLOP_BAD_CALL;
}
