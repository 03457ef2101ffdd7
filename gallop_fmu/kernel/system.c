/* The equations of motion of all chains and devices. */
#include "system.h"

#include "device.h"
#include "junction.h"

/* Forces of both halves of a line: those of the chains are added to the residual, those of the
 * devices stay apart, as a device may join both halves. */
typedef struct {
    const gallop_model *model;
    const conditions *now;
    const state_view *view;
    motion y;
    bool slopes;
    double *residual;
    monitor seen[2];
} line_forces;

typedef double device_forces[GALLOP_DEVICE_JUNCTIONS][4];

static void find_forces(void *task, int half)
{
    line_forces *f = task;
    const line_half *own = &f->model->half[half];
    device_forces *force = (device_forces *)f->view->device_force;
    element_monitor_start(&f->seen[half]);
    element_sum_half(f->model, own, f->now, &f->view->sections, f->y, f->slopes, f->residual,
                     &f->seen[half]);
    for (int i = own->device[0]; i < own->device[1]; i++)
        device_force(f->model, &f->model->device[i], f->now, f->y, force[i]);
}

void system_residual(const gallop_model *model, double t, const conditions *now,
                     const state_view *view, motion y, bool slopes, double *residual, monitor *seen)
{
    if (model->halves == 1) {
        element_sum_residual(model, t, now, &view->sections, y, slopes, residual, seen);
        device_add_forces(model, now, y, residual);
    } else {
        line_forces forces = {.model = model,
                              .now = now,
                              .view = view,
                              .y = y,
                              .slopes = slopes,
                              .residual = residual};
        device_forces *force = (device_forces *)view->device_force;
        team_share(view->team, 2, find_forces, &forces);
        for (int h = 0; h < 2; h++) element_monitor_add(seen, &forces.seen[h]);
        element_subtract_loads(model, t, now, residual);
        for (int i = 0; i < model->device_count; i++)
            device_add_force(model, &model->device[i], force[i], residual);
    }
    junction_gather(model, residual, 4);
}
