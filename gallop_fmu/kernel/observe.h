/* Observation of a state by probes. */
#ifndef GALLOP_OBSERVE_H
#define GALLOP_OBSERVE_H

#include "state.h"

/* The values of the probes, which were checked. */
void observe_probes(const gallop_model *model, const gallop_state *state, const state_view *view,
                    const gallop_probe *probe, int32_t probes, double *values);

#endif
