/* Accelerations that follow from displacements and velocities: at the start, and where they jump.
 */
#include "junction.h"
#include "solver.h"
#include "system.h"
#include "time_integration.h"

int time_accelerate(const gallop_model *model, gallop_state *state, state_view *at,
                    gallop_report *report)
{
    const size_t bytes = 4 * (size_t)model->nodes * sizeof(double);
    const tangent_weights inertia = {0.0, 0.0, 1.0};
    const motion y = {at->u, at->v, at->a};
    monitor seen = {0};
    element_monitor_start(&seen);
    memset(at->a, 0, bytes);
    junction_prescribe(model, &at->now, NULL, NULL, at->a);
    system_residual(model, state->time, &at->now, at, y, true, at->residual, &seen);
    if (!solver_factor(model, &at->now, at, y, inertia, SOLVER_JUNCTIONS_AS_IN_SCENE))
        return report_failure(report, GALLOP_NON_FINITE, -1, state->time, model->section[0].inertia,
                              0.0);
    solver_solve(model, at, SOLVER_JUNCTIONS_AS_IN_SCENE, at->residual);
    for (int i = 0; i < 4 * model->nodes; i++) at->a[i] -= at->residual[i];
    state->factored_step = 0.0;
    state->rate = 1.0;
    if (seen.worst_excess > 0.0) return time_angle_failure(&seen, state->time, report);
    state->lowest_tension = fmin(state->lowest_tension, seen.lowest_tension);
    if (seen.lowest_tension < 0.0)
        return report_failure(report, GALLOP_SLACK, seen.slack_element, state->time,
                              seen.lowest_tension, 0.0);
    return isfinite(time_correction_size(at->a, 4 * model->nodes))
             ? GALLOP_COMPLETED
             : report_failure(report, GALLOP_NON_FINITE, -1, state->time, NAN, 0.0);
}
