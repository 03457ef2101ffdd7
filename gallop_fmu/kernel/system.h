/* The equations of motion of all chains and devices. */
#ifndef GALLOP_SYSTEM_H
#define GALLOP_SYSTEM_H

#include "element.h"

/* Out-of-balance forces of a motion, as they are found half by half. */
typedef struct {
    const gallop_model *model;
    double time;
    element_state of;
    double *residual; /* (nodes, 4) */
    monitor seen[2];
} system_forces;

/* Those of a half; followers of a tie between the halves keep theirs. */
void system_find_forces(system_forces *f, int half);

/* What was noticed on the way. */
void system_notice(const system_forces *f, monitor *seen);

/* Out-of-balance forces of a motion, (nodes, 4); followers of a tie have none.  With slopes the
 * sections of the view are left for the tangent at this motion. */
void system_residual(const gallop_model *model, double t, const conditions *now,
                     const state_view *view, motion y, bool slopes, double *residual,
                     monitor *seen);

#endif
