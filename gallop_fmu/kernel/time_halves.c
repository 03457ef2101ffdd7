/* What integrators do to the arrays of unknowns of each half of a line. */
#include "time_integration.h"

void time_copy_half(const gallop_model *model, int half, const double *from, double *to)
{
    const int *node = model->half[half].node;
    const size_t first = 4 * (size_t)node[0], count = 4 * (size_t)(node[1] - node[0]);
    memcpy(to + first, from + first, count * sizeof(double));
}

void time_keep_half(const gallop_model *model, const state_view *at, int half)
{
    if (model->halves == 1) { /* u v a lie side by side, as do u0 v0 a0 */
        memcpy(at->u0, at->u, 12 * (size_t)model->nodes * sizeof(double));
        return;
    }
    time_copy_half(model, half, at->u, at->u0);
    time_copy_half(model, half, at->v, at->v0);
    time_copy_half(model, half, at->a, at->a0);
}

double time_larger_size(const double size[2], int halves)
{
    double larger = size[0];
    for (int h = 1; h < halves; h++) larger = size[h] <= larger ? larger : size[h];
    return larger;
}

/* A sub-step that was found. */
typedef struct {
    const gallop_model *model;
    const state_view *at;
    double turn[2]; /* largest one of a node in each half [rad] */
} found_step;

static void find_turn(void *task, int half)
{
    found_step *f = task;
    const int *node = f->model->half[half].node;
    const double *u = f->at->u, *u0 = f->at->u0;
    double largest = 0.0;
    for (int n = 4 * node[0] + 3; n < 4 * node[1]; n += 4) {
        const double turn = fabs(u[n] - u0[n]);
        if (turn > largest) largest = turn;
    }
    f->turn[half] = largest;
}

void time_remember_turn(const gallop_model *model, gallop_state *state, const state_view *at)
{
    found_step found = {.model = model, .at = at};
    team_share(at->team, model->halves, find_turn, &found);
    for (int h = 0; h < model->halves; h++)
        if (found.turn[h] > state->largest_turn) state->largest_turn = found.turn[h];
}
