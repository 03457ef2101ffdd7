/* Parts of the equation of motion at a motion that the caller gives, for tests and for analyses
 * outside the kernel: residual and tangent. */
#include "check.h"
#include "element.h"

/* Whether residual and tangent of this motion can be taken: of finite numbers. */
static bool computable(const gallop_model *model, const gallop_state *work, double time,
                       const gallop_inputs *inputs, const double *const given[3], const double *out)
{
    gallop_report report;
    if (check_room(model, work, time, &report) || !base_pointer_usable(out, WORD)) return false;
    for (int i = 0; i < 3; i++)
        if (!base_pointer_usable(given[i], WORD) ||
            !check_finite(given[i], 4 * (size_t)model->nodes))
            return false;
    return check_inputs(model, inputs, time, &report) == GALLOP_COMPLETED;
}

/* A caller's own motion may move what the scene leaves at rest, so that everything is computed. */
static conditions any_motion(const gallop_model *model, const state_view *view, double time,
                             const gallop_inputs *inputs)
{
    conditions now = view->stage[0];
    conditions_at(model, time, inputs, &now);
    now.everything = true;
    return now;
}

/* The blocks of an element tangent as a matrix of 12 rows. */
static void unfold(double block[6][16], double matrix[144])
{
    static const int block_of[3][3] = {{LEFT_LEFT, LEFT_MIDDLE, LEFT_RIGHT},
                                       {LEFT_MIDDLE, MIDDLE_MIDDLE, MIDDLE_RIGHT},
                                       {LEFT_RIGHT, MIDDLE_RIGHT, RIGHT_RIGHT}};
    for (int n = 0; n < 3; n++)
        for (int b = 0; b < 3; b++)
            for (int i = 0; i < 4; i++)
                for (int j = 0; j < 4; j++)
                    matrix[12 * (4 * n + i) + 4 * b + j] = block[block_of[n][b]][4 * i + j];
}

int gallop_residual(const gallop_model *model, gallop_state *work, double time,
                    const gallop_inputs *inputs, const double *u, const double *v, const double *a,
                    double *residual)
{
    const double *const given[3] = {u, v, a};
    if (!computable(model, work, time, inputs, given, residual)) return GALLOP_BAD_CALL;
    state_view at = state_view_of(model, work);
    conditions now = any_motion(model, &at, time, inputs);
    monitor seen;
    element_monitor_start(&seen);
    element_sum_residual(model, time, &now, &at.sections, (motion){u, v, a}, false, residual,
                         &seen);
    return GALLOP_COMPLETED;
}

int gallop_tangent(const gallop_model *model, gallop_state *work, double time,
                   const gallop_inputs *inputs, const double *u, const double *v, const double *a,
                   double k, double c, double m, double *tangent)
{
    const double *const given[3] = {u, v, a};
    if (!computable(model, work, time, inputs, given, tangent)) return GALLOP_BAD_CALL;
    if (!isfinite(k) || !isfinite(c) || !isfinite(m)) return GALLOP_BAD_CALL;
    state_view at = state_view_of(model, work);
    conditions now = any_motion(model, &at, time, inputs);
    const motion y = {u, v, a};
    monitor seen;
    element_monitor_start(&seen);
    element_sum_residual(model, time, &now, &at.sections, y, true, at.residual, &seen);
    for (int i = 0; i < model->chain_count; i++) { /* the sections hold the slopes now */
        const chain *of = &model->chain[i];
        const exposure on = conditions_on(model, &now, of);
        for (int e = 0; e < of->elements; e++) {
            double block[6][16], *out = tangent + 144 * (size_t)(of->first_element + e);
            element_tangent(of, e, &on, &at.sections, u + 4 * of->first_node + 8 * e,
                            (tangent_weights){k, c, m}, block);
            unfold(block, out);
        }
    }
    return GALLOP_COMPLETED;
}
