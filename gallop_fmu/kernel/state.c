/* The layout of the flat block of a state. */
#include "state.h"

state_view state_view_of(const gallop_model *model, gallop_state *state)
{
    const size_t values = 4 * (size_t)model->nodes, all = 3 * LANES * (size_t)model->strips;
    double *p = state->values;
    state_view at;
    at.u = p;
    at.v = p + values;
    at.a = p + 2 * values;
    const size_t stages = model_by_gauss(model) ? GAUSS_STAGES : 0,
                 history = stages ? GAUSS_ARRAYS : NEWMARK_HISTORY;
    at.a_before = at.stage_before = p + 3 * values;
    at.begin = at.stage_before + stages * values;
    at.factors = (chain_factor *)(p + (3 + history) * values);
    at.complex_factors = (complex_factor *)(at.factors + chain_factor_count(model->elements));
    p = (double *)(at.complex_factors + (stages ? model->elements + 1 : 0));
    at.u0 = p;
    at.v0 = p + values;
    at.a0 = p + 2 * values;
    at.residual = p + 3 * values;
    at.first = p + 4 * values;
    p = at.first + (3 + history) * values;
    const size_t sets = model_by_alpha(model)
                          ? 1
                          : stages; /* generalised alpha looks at one instant within the step */
    at.stage_u = p;
    at.stage_v = p + sets * values;
    at.stage_a = p + 2 * sets * values;
    at.stage_residual = p + 3 * sets * values;
    at.complex_residual = at.stage_residual + stages * values;
    p = at.complex_residual + (stages ? 2 * values : 0);
    double **array[] = {&at.sections.theta, &at.sections.omega,   &at.sections.omega_rate,
                        &at.sections.v2,    &at.sections.v3,      &at.sections.a2,
                        &at.sections.a3,    &at.sections.gravity, &at.sections.c2,
                        &at.sections.c3,    &at.sections.angle,   &at.sections.excess};
    for (size_t i = 0; i < sizeof array / sizeof *array; i++, p += all) *array[i] = p;
    for (int k = 0; k < 3; k++) {
        at.sections.force[k] = p;
        at.sections.by_theta[k] = p + all;
        at.sections.by_v2[k] = p + 2 * all;
        at.sections.by_v3[k] = p + 3 * all;
        p += 4 * all;
    }
    at.saved = (char *)p;
    return at;
}

void state_report_work(const gallop_state *state, gallop_report *report)
{
    report->lowest_tension = state->lowest_tension;
    report->largest_turn = state->largest_turn;
    report->steps = state->steps;
    report->substeps = state->substeps;
    report->iterations = state->iterations;
    report->refactorisations = state->refactorisations;
    report->halvings = state->halvings;
    report->rejections = state->rejections;
}
