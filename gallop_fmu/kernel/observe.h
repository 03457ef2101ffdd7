/* What can be read off a state. */
#ifndef GALLOP_OBSERVE_H
#define GALLOP_OBSERVE_H

#include "state.h"

/* All channels of one node. */
void observe_node(const gallop_model *model, const state_view *view, int32_t node,
                  double values[GALLOP_NODE_CHANNELS]);

/* The span channels whose bits are set in `asked`; others that cost work are left alone. */
void observe_span(const gallop_model *model, const gallop_state *state, const state_view *view,
                  uint32_t asked, double values[GALLOP_SPAN_CHANNELS]);

#endif
