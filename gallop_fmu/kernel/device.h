/* What acts at single points: the springs of the supports. */
#ifndef GALLOP_DEVICE_H
#define GALLOP_DEVICE_H

#include "state.h"

void device_add_springs(const gallop_model *model, const conditions *now, const double *u,
                        double *residual);

#endif
