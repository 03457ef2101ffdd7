/* Steps in time: Newton's iteration, the integrators, and the choice of step sizes. */
#ifndef GALLOP_TIME_INTEGRATION_H
#define GALLOP_TIME_INTEGRATION_H

#include "element.h"
#include "report.h"

/* time_newton.c: what all integrators share in solving for a step */
typedef enum {
    NEWTON_CONTINUE,
    NEWTON_REFACTORISE,
    NEWTON_CONVERGED,
    NEWTON_DIVERGED
} newton_action;
/* Largest correction, in m and rad alike: a twist of 1 rad matters to the wind load as much as a
 * motion of metres.  NaN if one is not finite. */
double time_correction_size(const double *du, int values);

/* The same for a loop that also does something else; by unknown, so that the four need not wait for
 * each other. */
typedef struct {
    lanes largest[LANE_GROUPS], sum[LANE_GROUPS];
} correction_size;

/* Corrections of group `i` of the unknowns of a node. */
INLINE void time_note_size(correction_size *seen, int i, const lanes *corrections)
{
    const lanes x = *corrections, size = MAGNITUDE(x);
    seen->largest[i] = PICK(size > seen->largest[i], size, seen->largest[i]);
    seen->sum[i] += x; /* the maximum lets NaN pass */
}

INLINE double time_size_of(const correction_size *seen)
{
    double most = 0.0, all = 0.0;
    for (int i = 0; i < LANE_GROUPS; i++)
        for (int k = 0; k < LANES; k++) {
            most = fmax(most, LANE(seen->largest[i], k));
            all += LANE(seen->sum[i], k);
        }
    return isfinite(all) ? most : NAN;
}

newton_action time_newton_next(gallop_state *state, double size, double before, bool fresh,
                               double tolerance);
int time_newton_accept(gallop_state *state, const monitor *seen, double t, gallop_report *report);
int time_angle_failure(const monitor *seen, double t, gallop_report *report);

/* time_halves.c: copies the values of a half; keeps u v a of a half as u0 v0 a0; the larger of the
 * sizes of the halves, NaN if one is; the largest turn of a node within a sub-step that was found:
 * the forces of wind and eccentric ice turn with a section, and a sub-step in which it turns far
 * cannot follow them */
void time_copy_half(const gallop_model *model, int half, const double *from, double *to);
void time_keep_half(const gallop_model *model, const state_view *at, int half);
double time_larger_size(const double size[2], int halves);
void time_remember_turn(const gallop_model *model, gallop_state *state, const state_view *at);

/* time_newmark.c, time_gauss.c: one step from u0 v0 a0 at t - h to u v a at t; commit: it is the
 * one before from now on */
int time_newmark(const gallop_model *model, gallop_state *state, state_view *at,
                 const gallop_inputs *inputs, double t, double h, double tolerance,
                 gallop_report *report);
void time_newmark_commit(const gallop_model *model, gallop_state *state, state_view *at, double h);
int time_gauss(const gallop_model *model, gallop_state *state, state_view *at,
               const gallop_inputs *inputs, double t, double h, double tolerance,
               gallop_report *report);
void time_gauss_commit(const gallop_model *model, gallop_state *state, state_view *at, double h);
void time_gauss_cubic_part(const gallop_model *model, const gallop_state *state,
                           const state_view *at, double h, double *part);
double time_gauss_linear_part(const gallop_model *model, const state_view *at, double h,
                              int unknown);
void time_gauss_read(const gallop_model *model, const gallop_state *state, state_view *at,
                     double t);

/* time_accelerate.c: accelerations that satisfy the equations of motion at u and v */
int time_accelerate(const gallop_model *model, gallop_state *state, state_view *at,
                    gallop_report *report);

/* time_shedding.c: no ice has fallen yet; next time between t and `end` at which ice
 * falls by the scene (infinite: none); marks what has fallen by t (false: nothing); what falls at
 * the end of a step; times of falls are not after t */
void time_start_sheddings(const gallop_model *model, const state_view *at);
double time_next_shedding(const gallop_model *model, const state_view *at, double t, double end);
bool time_shed_by_time(const gallop_model *model, const gallop_state *state, const state_view *at,
                       double t);
int time_shed(const gallop_model *model, gallop_state *state, state_view *at,
              gallop_report *report);
void time_round_sheddings(const gallop_model *model, const state_view *at, double t);

/* time_march.c: adds the seed of every chain to u, cos(pi x1/L) with x1 from its mid-span */
void time_add_seed(const gallop_model *model, double *u);

/* time_control.c */
static inline bool time_may_halve(int outcome)
{
    return outcome == GALLOP_NEWTON_STALLED || outcome == GALLOP_NON_FINITE;
}
double time_newton_tolerance(const gallop_model *model, const gallop_state *state);
void time_control_start(const gallop_model *model, gallop_state *state, const double *u);
int time_controlled_march(const gallop_model *model, gallop_state *state, state_view *at,
                          const gallop_inputs *inputs, double until, bool exactly,
                          gallop_report *report);
void time_control_look(const gallop_model *model, gallop_state *state, state_view *at, double t);
void time_control_return(const gallop_model *model, state_view *at);

#endif
