/* The model and the state of an instance, built from its present parameters and inputs. */
#ifndef GALLOP_COSIM_SPAN_H
#define GALLOP_COSIM_SPAN_H

#include "cosim_instance.h"

/* Builds model and empty states of the present parameters; on failure `span` is empty. */
gallop_cosim_status cosim_span_build(gallop_cosim *c, cosim_span *span);
void cosim_span_free(cosim_span *span);

/* Frees the span of the instance, whose parameters have changed. */
void cosim_span_drop(gallop_cosim *c);

/* Until stepping begins: builds what is missing for the present parameters and inputs. */
gallop_cosim_status cosim_span_make_current(gallop_cosim *c);

/* The kernel's inputs over a step of `size` from `time`: values and rates of the inputs, tower
 * points on their way from where they are to their new places, which they reach after the time
 * `ramp`.  Size 0: constant inputs.  They hold until the next call. */
gallop_inputs cosim_linear_inputs(gallop_cosim *c, const cosim_inputs *with, double time,
                                  double size, double ramp);

/* Where the point is after such a step that an input moves. */
double cosim_place_after(const gallop_cosim *c, const cosim_inputs *with, uint32_t input,
                         double size, double ramp);

/* The velocity at which such a step leaves the point that an input moves. */
double cosim_trend_after(const gallop_cosim *c, const cosim_inputs *with, uint32_t input,
                         double size, double ramp);

void cosim_copy_inputs(const gallop_cosim *c, cosim_inputs *to, const cosim_inputs *from);

/* Forgets the stored observations: the state has changed. */
void cosim_forget_observations(gallop_cosim *c);

#endif
