/* Parameters, inputs and outputs of an instance by value reference. */
#ifndef GALLOP_COSIM_VALUES_H
#define GALLOP_COSIM_VALUES_H

#include "cosim_instance.h"

/* The variable with a value reference and a type; NULL, with a message, if there is none. */
const resource_variable *cosim_find(gallop_cosim *c, uint32_t reference, bool whole);

/* Parameters as they are stored in the scene: factor times the value of the variable. */
void cosim_copy_parameters(const gallop_cosim *c, double *stored);
void cosim_set_parameters(gallop_cosim *c, const double *stored);
bool cosim_parameters_are_possible(const gallop_cosim *c, const double *stored);

/* An output in the present state; it returns a gallop_outcome. */
int cosim_observe(gallop_cosim *c, const resource_variable *v, double *value);

/* An output in any state of the span. */
int cosim_observe_in(const gallop_cosim *c, gallop_state *state, const resource_variable *v,
                     double *value);

/* The time derivative of an output that consists of motions, in the present state. */
bool cosim_has_exact_rate(const gallop_cosim *c, const resource_variable *v);
int cosim_observe_rate(gallop_cosim *c, const resource_variable *v, double *rate);

/* The message for an output that could not be computed. */
gallop_cosim_status cosim_fail_to_observe(gallop_cosim *c, const resource_variable *v);

#endif
