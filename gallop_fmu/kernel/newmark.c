/* Newmark's method (beta 1/4, gamma 1/2) with Newton-Raphson (Liu et al. 2009, section 2.5). */
#include "internal.h"

#define BETA 0.25
#define GAMMA 0.5

#define SLOW_RATE 0.3   /* a factorisation is renewed when the observed convergence rate is worse */

/* The acceleration is extrapolated from the last two; the ends follow their prescribed motion. */
static void predict(const gallop_model *model, layout *at, const instant *now, double h, double h_before)
{
    const int values = 4 * model->nodes;
    const double ahead = h / h_before;
    for (int i = 0; i < values; i++) {
        double guess = at->a0[i] + ahead * (at->a0[i] - at->a_before[i]);
        at->u[i] = at->u0[i] + h * at->v0[i] + h * h * ((0.5 - BETA) * at->a0[i] + BETA * guess);
        at->v[i] = at->v0[i] + h * ((1.0 - GAMMA) * at->a0[i] + GAMMA * guess);
        at->a[i] = guess;
    }
    for (int end = 0; end < 2; end++) {
        const int node = end ? 4 * (model->nodes - 1) : 0;
        for (int i = 0; i < 4; i++) {
            if (!model->fixed[end][i]) continue;
            at->u[node + i] = i < 3 ? now->position[end][i] : 0.0;
            at->v[node + i] = i < 3 ? now->velocity[end][i] : 0.0;
            at->a[node + i] = i < 3 ? now->acceleration[end][i] : 0.0;
        }
    }
}

/* One Newmark step from u0 v0 a0 at t - h to u v a at t. */
int newmark(const gallop_model *model, gallop_state *state, layout *at, const gallop_inputs *inputs, double t, double h,
            gallop_report *report)
{
    const int values = 4 * model->nodes;
    const double tolerance = model->scene.newton_tolerance * state->sharpness;
    const blend mix = {1.0, GAMMA / (BETA * h), 1.0 / (BETA * h * h)};
    bool renew = state->factored_step != h, fresh = false;
    double before = 0.0;
    watch seen;
    instant_at(model, t, inputs, &state->now);
    predict(model, at, &state->now, h, state->step_before);
    for (int iteration = 1; iteration <= model->scene.max_newton_iterations; iteration++) {
        watch_start(&seen);
        span_residual(model, t, &state->now, &at->sections, at->u, at->v, at->a, renew, at->residual, &seen);
        add_springs(model, &state->now, at->u, at->residual);
        if (renew) {
            state->factored_step = 0.0;
            if (!solver_factor(model, &state->now, &at->sections, at->u, mix, model->fixed, at->factors))
                return fail(report, GALLOP_NEWTON_STALLED, seen.slack_element, t, NAN, tolerance);
            state->factored_step = h;
            state->rate = 1.0;
            state->refactorisations++;
            renew = false;
            fresh = true;
            before = 0.0;
        }
        solver_solve(model, at->factors, model->fixed, at->residual);
        for (int i = 0; i < values; i++) {
            double du = -at->residual[i];
            at->u[i] += du;
            at->v[i] += mix.c * du;
            at->a[i] += mix.m * du;
        }
        state->iterations++;
        state->last_iterations++;
        double size = correction_size(model, at->residual);
        if (!isfinite(size)) return fail(report, GALLOP_NON_FINITE, -1, t, size, 0.0);
        switch (newton_judge(state, size, before, fresh, SLOW_RATE, tolerance)) {
        case NEWTON_CONVERGED: return newton_accept(model, state, &seen, t, report);
        case NEWTON_DIVERGED: return fail(report, GALLOP_NEWTON_STALLED, seen.slack_element, t, size, tolerance);
        case NEWTON_RENEWS: renew = true; break;
        case NEWTON_GOES_ON: break;
        }
        before = size;
    }
    return fail(report, GALLOP_NEWTON_STALLED, seen.slack_element, t, before, tolerance);
}
