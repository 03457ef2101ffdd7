/* Communication steps. */
#ifndef GALLOP_COSIM_STEP_H
#define GALLOP_COSIM_STEP_H

#include "cosim_instance.h"

/* An input among the Reals; NULL, with a message, if the reference is of something else. */
const resource_variable *cosim_find_input(gallop_cosim *c, uint32_t reference);

#endif
