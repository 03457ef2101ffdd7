/* The table of what lies where in the flat block of a state. */
#include "state.h"

/* An array of a state: where its pointer is in a state_view, and how many doubles it has. */
typedef struct {
    size_t pointer, count;
} array;

enum { SAVED_ARRAYS = 13, ARRAYS = SAVED_ARRAYS + 15 + 24 + 1 };

#define ARRAY(name, count) {offsetof(state_view, name), count}
#define SECTION(name) {offsetof(state_view, sections.name), abscissae}

/* Kept from step to step beside u v a, in arrays of one value an unknown. */
static size_t history_arrays(const gallop_model *model)
{
    return model_by_gauss(model) ? GAUSS_ARRAYS : NEWMARK_HISTORY;
}

/* The one table: saved arrays first, then scratch memory, in their order in the block. */
static void list_arrays(const gallop_model *model, array list[ARRAYS])
{
    const size_t values = 4 * (size_t)model->nodes, block = conditions_count(model);
    const size_t abscissae = 3 * LANES * (size_t)model->strips;
    const size_t stages = model_by_gauss(model) ? GAUSS_STAGES : 0;
    const size_t history = history_arrays(model);
    const size_t sets = model_by_alpha(model) ? 1 : stages;    /* instants within a step */
    const size_t unknowns = 8 * (size_t)model->junction_count; /* two parts each */
    const array saved[SAVED_ARRAYS] = {
        ARRAY(u, values),
        ARRAY(v, values),
        ARRAY(a, values),
        ARRAY(a_before, stages ? 0 : history * values),
        ARRAY(stage_before, stages * values),
        ARRAY(begin, stages ? (history - stages) * values : 0),
        ARRAY(factors, model->factor_room),
        ARRAY(complex_factors, stages ? 2 * model->factor_room : 0),
        ARRAY(factored, stages ? values : 0),
        ARRAY(now_block, block),
        ARRAY(looked_from_block, block),
        ARRAY(lost, 2 * (size_t)model->shedding_count),
        ARRAY(fallen, model->shedding_count),
    };
    const array scratch[ARRAYS - SAVED_ARRAYS] = {
        ARRAY(u0, values),
        ARRAY(v0, values),
        ARRAY(a0, values),
        ARRAY(residual, values),
        ARRAY(first, (3 + history) * values),
        ARRAY(stage_u, sets * values),
        ARRAY(stage_v, sets * values),
        ARRAY(stage_a, sets * values),
        ARRAY(stage_residual, stages * values),
        ARRAY(complex_residual, stages ? 2 * values : 0),
        ARRAY(along, stages * values),
        ARRAY(junction_rhs, model->coupled ? unknowns : 0),
        ARRAY(stage_block[0], block),
        ARRAY(stage_block[1], block),
        ARRAY(stage_block[2], block),
        SECTION(theta),
        SECTION(omega),
        SECTION(omega_rate),
        SECTION(v2),
        SECTION(v3),
        SECTION(a2),
        SECTION(a3),
        SECTION(gravity),
        SECTION(c2),
        SECTION(c3),
        SECTION(angle),
        SECTION(excess),
        SECTION(force[0]),
        SECTION(force[1]),
        SECTION(force[2]),
        SECTION(by_theta[0]),
        SECTION(by_theta[1]),
        SECTION(by_theta[2]),
        SECTION(by_v2[0]),
        SECTION(by_v2[1]),
        SECTION(by_v2[2]),
        SECTION(by_v3[0]),
        SECTION(by_v3[1]),
        SECTION(by_v3[2]),
        ARRAY(saved, model->saved_size / sizeof(double)),
    };
    memcpy(list, saved, sizeof saved);
    memcpy(list + SAVED_ARRAYS, scratch, sizeof scratch);
}

/* Values from the start of an array to that of the next one. */
static size_t room(const array *of)
{
    return base_whole_vectors(of->count * sizeof(double)) / sizeof(double);
}

void state_measure(gallop_model *model)
{
    array list[ARRAYS];
    size_t count = 0;
    list_arrays(model, list);
    for (int i = 0; i < SAVED_ARRAYS; i++) count += room(&list[i]);
    model->saved_size = offsetof(gallop_state, values) + count * sizeof(double);
    list_arrays(model, list); /* the copy of the saved part has a size now */
    for (int i = SAVED_ARRAYS; i < ARRAYS; i++) count += room(&list[i]);
    model->state_size = offsetof(gallop_state, values) + count * sizeof(double);
}

state_view state_view_of(const gallop_model *model, gallop_state *state)
{
    array list[ARRAYS];
    state_view view;
    double *next = state->values;
    view.team = NULL;
    list_arrays(model, list);
    for (int i = 0; i < ARRAYS; i++) {
        memcpy((char *)&view + list[i].pointer, &next, sizeof next);
        next += room(&list[i]);
    }
    view.now = conditions_in(model, view.now_block);
    view.looked_from = conditions_in(model, view.looked_from_block);
    for (int i = 0; i < GAUSS_STAGES; i++)
        view.stage[i] = conditions_in(model, view.stage_block[i]);
    view.now.time = view.looked_from.time = state->time;
    view.now.fallen = view.looked_from.fallen = view.fallen;
    for (int i = 0; i < GAUSS_STAGES; i++) view.stage[i].fallen = view.fallen;
    return view;
}

size_t state_motion_bytes(const gallop_model *model)
{
    return (3 + history_arrays(model)) * 4 * (size_t)model->nodes * sizeof(double);
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
