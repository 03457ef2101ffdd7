/* What acts at single points: the springs of the supports. */
#include "device.h"

void device_add_springs(const gallop_model *model, const conditions *now, const double *u,
                        double *residual)
{
    for (int end = 0; end < 2; end++) {
        const size_t node = end ? 4 * (size_t)(model->nodes - 1) : 0;
        for (int i = 0; i < 3; i++)
            residual[node + i] += model->stiffness[end][i] * (u[node + i] - now->position[end][i]);
    }
}
