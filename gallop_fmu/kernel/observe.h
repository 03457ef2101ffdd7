/* What can be read off a state. */
#ifndef GALLOP_OBSERVE_H
#define GALLOP_OBSERVE_H

#include "state.h"

/* One node; the span channels whose bits are set in `asked`, the others are left alone. */
void observe_node(const gallop_model *model, const gallop_state *state, int32_t node,
                  double values[GALLOP_NODE_CHANNELS]);
void observe_span(const gallop_model *model, gallop_state *state, uint32_t asked,
                  double values[GALLOP_SPAN_CHANNELS]);

#endif
