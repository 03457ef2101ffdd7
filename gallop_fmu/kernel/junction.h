/* Junctions: where chains end and devices act. */
#ifndef GALLOP_JUNCTION_H
#define GALLOP_JUNCTION_H

#include "state.h"

/* Sets the prescribed unknowns to the motion of `now`; theta is fixed at zero.  Each array may be
 * NULL. */
void junction_prescribe(const gallop_model *model, const conditions *now, double *u, double *v,
                        double *a);
/* Those of a half. */
void junction_prescribe_half(const gallop_model *model, const conditions *now, int half, double *u,
                             double *v, double *a);

/* Forces on followers go to their leaders; (nodes, width): of ties in a half, or BETWEEN them; of
 * all. */
void junction_gather(const gallop_model *model, int half, double *force, int width);
void junction_gather_all(const gallop_model *model, double *force, int width);

/* Followers in a half get the values of their leaders; (nodes, width). */
void junction_spread(const gallop_model *model, int half, double *values, int width);

#endif
