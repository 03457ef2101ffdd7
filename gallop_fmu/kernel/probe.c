/* Parts of the equation of motion at a motion that the caller gives, for tests and for analyses
 * outside the kernel: residual and tangent. */
#include "check.h"
#include "element.h"

/* Whoever brings a motion of his own may move what the scene leaves at rest. */
static gallop_model with_everything(const gallop_model *model)
{
    gallop_model all = *model;
    all.unknowns = 4;
    all.aerodynamic = model->scene.pieces > 0;
    return all;
}

/* Whether residual and tangent of this motion can be taken: of finite numbers. */
static bool computable(const gallop_model *model, const gallop_state *work, double time,
                       const gallop_inputs *inputs, const double *const motion[3],
                       const double *out)
{
    gallop_report report;
    if (check_room(model, work, time, &report) || !base_pointer_usable(out, WORD)) return false;
    for (int i = 0; i < 3; i++)
        if (!base_pointer_usable(motion[i], WORD) ||
            !check_finite(motion[i], 4 * (size_t)model->nodes))
            return false;
    return check_inputs(model, inputs, time, &report) == GALLOP_COMPLETED;
}

int gallop_residual(const gallop_model *model, gallop_state *work, double time,
                    const gallop_inputs *inputs, const double *u, const double *v, const double *a,
                    double *residual)
{
    const double *const motion[3] = {u, v, a};
    if (!computable(model, work, time, inputs, motion, residual)) return GALLOP_BAD_CALL;
    const gallop_model all = with_everything(model);
    state_view at = state_view_of(model, work);
    conditions now;
    monitor seen;
    conditions_at(model, time, inputs, &now);
    element_monitor_start(&seen);
    element_sum_residual(&all, time, &now, &at.sections, u, v, a, false, residual, &seen);
    return GALLOP_COMPLETED;
}

int gallop_tangent(const gallop_model *model, gallop_state *work, double time,
                   const gallop_inputs *inputs, const double *u, const double *v, const double *a,
                   double k, double c, double m, double *tangent)
{
    static const int block_of[3][3] = {{LEFT_LEFT, LEFT_MIDDLE, LEFT_RIGHT},
                                       {LEFT_MIDDLE, MIDDLE_MIDDLE, MIDDLE_RIGHT},
                                       {LEFT_RIGHT, MIDDLE_RIGHT, RIGHT_RIGHT}};
    const double *const motion[3] = {u, v, a};
    if (!computable(model, work, time, inputs, motion, tangent)) return GALLOP_BAD_CALL;
    if (!isfinite(k) || !isfinite(c) || !isfinite(m)) return GALLOP_BAD_CALL;
    const gallop_model all = with_everything(model);
    state_view at = state_view_of(model, work);
    conditions now;
    monitor seen;
    conditions_at(model, time, inputs, &now);
    element_monitor_start(&seen);
    element_sum_residual(&all, time, &now, &at.sections, u, v, a, true, at.residual,
                         &seen); /* leaves the slopes */
    for (int e = 0; e < model->elements; e++) {
        double block[6][16], *out = tangent + 144 * (size_t)e;
        element_tangent(&all, e, &now, &at.sections, u + 8 * e, (tangent_weights){k, c, m}, block);
        for (int n = 0; n < 3; n++)
            for (int b = 0; b < 3; b++)
                for (int i = 0; i < 4; i++)
                    for (int j = 0; j < 4; j++)
                        out[12 * (4 * n + i) + 4 * b + j] = block[block_of[n][b]][4 * i + j];
    }
    return GALLOP_COMPLETED;
}
