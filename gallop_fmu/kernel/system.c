/* The equations of motion of all chains and devices. */
#include "system.h"

#include "device.h"
#include "junction.h"

void system_residual(const gallop_model *model, double t, const conditions *now,
                     const state_view *view, motion y, bool slopes, double *residual, monitor *seen)
{
    element_sum_residual(model, t, now, &view->sections, y, slopes, residual, seen);
    device_add_forces(model, now, y, residual);
    junction_gather(model, residual, 4);
}
