/* Junctions: prescribed motion, and corners of several chains that are one point. */
#include "junction.h"

static void prescribe_node(const junction *j, const conditions *now, int index, double *node[3])
{
    const double *motion[3] = {now->position, now->velocity, now->acceleration};
    for (int k = 0; k < 3; k++) {
        if (!node[k]) continue;
        for (int i = 0; i < 4; i++)
            if (j->fixed[i]) node[k][i] = i < 3 ? motion[k][3 * index + i] : 0.0;
    }
}

void junction_prescribe_half(const gallop_model *model, const conditions *now, int half, double *u,
                             double *v, double *a)
{
    const line_half *own = &model->half[half];
    for (int k = own->chain[0]; k < own->chain[1]; k++)
        for (int i = 0; i < model->chain[k].kept_corners; i++) {
            const chain *c = &model->chain[k];
            const int node = 4 * (c->first_node + 2 * c->kept[i].corner);
            const int index = c->kept[i].junction;
            double *of_node[3] = {u ? u + node : NULL, v ? v + node : NULL, a ? a + node : NULL};
            prescribe_node(&model->junction[index], now, index, of_node);
        }
    if (own->node[1] < model->nodes) return;
    for (int j = 0; j < model->junction_count; j++) {
        if (!model->junction[j].body) continue;
        const int node = 4 * model->junction[j].node;
        double *of_node[3] = {u ? u + node : NULL, v ? v + node : NULL, a ? a + node : NULL};
        prescribe_node(&model->junction[j], now, j, of_node);
    }
}

void junction_prescribe(const gallop_model *model, const conditions *now, double *u, double *v,
                        double *a)
{
    for (int h = 0; h < model->halves; h++) junction_prescribe_half(model, now, h, u, v, a);
}

void junction_gather(const gallop_model *model, int half, double *force, int width)
{
    for (int t = 0; t < model->tie_count; t++) {
        if (model->tie[t].half != half) continue;
        double *from = force + width * model->tie[t].follower;
        double *to = force + width * model->tie[t].leader;
        for (int i = 0; i < width; i++) {
            to[i] += from[i];
            from[i] = 0.0;
        }
    }
}

void junction_gather_all(const gallop_model *model, double *force, int width)
{
    for (int half = 0; half <= BETWEEN; half++) junction_gather(model, half, force, width);
}

void junction_spread(const gallop_model *model, int half, double *values, int width)
{
    for (int t = 0; t < model->tie_count; t++) {
        const tie *own = &model->tie[t];
        if (model_half_of_node(model, own->follower) == half)
            memcpy(values + width * own->follower, values + width * own->leader,
                   (size_t)width * sizeof(double));
    }
}
