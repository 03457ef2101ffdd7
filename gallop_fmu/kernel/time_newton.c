/* Newton's iteration as all integrators use it: how large a correction is, whether to go on, and
 * whether a converged step can be accepted.  The factorised tangent is reused while it converges
 * well. */
#include "base_math.h"
#include "time_integration.h"

/* A better rate than this is not relied on: it was measured on other steps, or on components that
 * converge faster. */
#define MIN_ASSUMED_RATE 0.1

#define MAX_REUSE_RATE                                                                             \
    0.3 /* a factorisation is renewed when the observed convergence rate is worse */

TWO_PATHS static double largest_size(const double *du, int values)
{
    correction_size seen = {{{0.0}}, {{0.0}}};
    for (int n = 0; n < values; n += 4)
        for (int i = 0; i < LANE_GROUPS; i++)
            time_note_size(&seen, i, (const lanes *)(du + n + LANES * i));
    return time_size_of(&seen);
}

double time_correction_size(const double *du, int values)
{
    return largest_size(du, values);
}

/* After a correction of `size`, `before` the one before it (0: none) with the same tangent.  The
 * rate of convergence is remembered from step to step; where it is bad, a new
 * factorisation costs less than more iterations. */
newton_action time_newton_next(gallop_state *state, double size, double before, bool fresh,
                               double tolerance)
{
    if (before > 0.0) {
        double rate = size / before;
        state->rate = fmax(MIN_ASSUMED_RATE, fmax(rate, 0.3 * state->rate));
        if (rate > 2.0 && fresh) return NEWTON_DIVERGED;
    }
    /* what is left of the error after this correction, were it to shrink at the observed rate */
    double left = state->rate < 0.9 ? size * state->rate / (1.0 - state->rate) : size;
    if (left < tolerance || size < 1e-3 * tolerance) return NEWTON_CONVERGED;
    return before > 0.0 && state->rate > MAX_REUSE_RATE && !fresh ? NEWTON_REFACTORISE
                                                                  : NEWTON_CONTINUE;
}

/* The angle is reported within the turn centred on the curve's range, so that it lies beyond the
 * end that it left. */
int time_angle_failure(const monitor *seen, double t, gallop_report *report)
{
    const curve *k = seen->curve;
    double offset = seen->worst_angle - k->centre;
    offset -= 2.0 * PI * nearest(offset * (0.5 / PI));
    return report_failure(report, GALLOP_ANGLE_OUT_OF_RANGE, seen->angle_element, t,
                          k->centre + offset, offset > 0.0 ? k->last : k->first);
}

/* A converged step is refused where its motion is impossible. */
int time_newton_accept(gallop_state *state, const monitor *seen, double t, gallop_report *report)
{
    if (seen->worst_excess > 0.0) return time_angle_failure(seen, t, report);
    if (seen->lowest_tension < state->lowest_tension) state->lowest_tension = seen->lowest_tension;
    if (seen->lowest_tension < 0.0)
        return report_failure(report, GALLOP_SLACK, seen->slack_element, t, seen->lowest_tension,
                              0.0);
    return GALLOP_COMPLETED;
}
