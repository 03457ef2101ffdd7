/* The equations of motion of all chains and devices. */
#ifndef GALLOP_SYSTEM_H
#define GALLOP_SYSTEM_H

#include "element.h"

/* Out-of-balance forces of a motion, (nodes, 4); followers of a tie have none.  With slopes the
 * sections of the view are left for the tangent at this motion. */
void system_residual(const gallop_model *model, double t, const conditions *now,
                     const state_view *view, motion y, bool slopes, double *residual,
                     monitor *seen);

#endif
