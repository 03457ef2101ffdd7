/* Communication steps. */
#ifndef GALLOP_COSIM_STEP_H
#define GALLOP_COSIM_STEP_H

#include "cosim_instance.h"

/* An input among the Reals; NULL, with a message, if the reference is of something else. */
const resource_variable *cosim_find_input(gallop_cosim *c, uint32_t reference);

/* The kernel's inputs over a step of `size` from `time`: values and rates of the inputs, tower
 * points on their way from `tower` to their new places. */
void cosim_step_inputs(const double input[RESOURCE_INPUTS], const double rate[RESOURCE_INPUTS],
                       const double tower[6], double time, double size, gallop_inputs *in);

#endif
