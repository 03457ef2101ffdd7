/* The equations of motion of all chains and devices. */
#include "system.h"

#include "device.h"
#include "junction.h"

void system_find_forces(system_forces *f, int half)
{
    element_monitor_start(&f->seen[half]);
    element_sum_half(f->model, half, f->time, &f->of, f->residual, &f->seen[half]);
    device_add_forces(f->model, half, f->of.now, f->of.y, f->residual);
    junction_gather(f->model, half, f->residual, 4);
}

void system_notice(const system_forces *f, monitor *seen)
{
    for (int h = 0; h < f->model->halves; h++) element_monitor_add(seen, &f->seen[h]);
}

static void find_forces(void *task, int half)
{
    system_find_forces(task, half);
}

void system_residual(const gallop_model *model, double t, const conditions *now,
                     const state_view *view, motion y, bool slopes, double *residual, monitor *seen)
{
    system_forces forces;
    forces.model = model;
    forces.time = t;
    forces.of = (element_state){now, &view->sections, y, slopes};
    forces.residual = residual;
    team_share(view->team, model->halves, find_forces, &forces);
    junction_gather(model, BETWEEN, residual, 4);
    system_notice(&forces, seen);
}
