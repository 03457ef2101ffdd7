/* Observation of the initial equilibrium. */
#include "check.h"
#include "device.h"

/* The force of the chains on the tower: directly where the junction is fixed, else by devices. */
static double tower_force(const gallop_model *model, int index, int axis)
{
    const junction *j = &model->junction[index];
    double force = 0.0;
    if (!j->fixed[axis])
        return device_tower_force_at_rest(model, index, axis) - j->static_force[axis];
    for (int k = 0; k < model->chain_count; k++)
        for (int end = 0; end < 2; end++)
            if (model->chain[k].junction[end] == index)
                force += model->chain[k].end_force[end][axis];
    return force;
}

int gallop_observe_equilibrium(const gallop_model *model, const gallop_probe *probe, int32_t probes,
                               double *values)
{
    gallop_report report; /* the caller gets none */
    if (!check_is_model(model) || check_probes(model, probe, probes, &report) ||
        (probes > 0 && !base_pointer_usable(values, WORD)))
        return GALLOP_BAD_CALL;
    for (int32_t i = 0; i < probes; i++)
        if (probe[i].object != GALLOP_PROBE_JUNCTION && probe[i].object != GALLOP_PROBE_DEVICE)
            return GALLOP_BAD_CALL;
    for (int32_t i = 0; i < probes; i++) {
        const gallop_probe *p = &probe[i];
        values[i] = p->object == GALLOP_PROBE_DEVICE
                      ? device_value_at_rest(model, p->index, p->channel)
                      : tower_force(model, p->index, p->channel);
    }
    return GALLOP_COMPLETED;
}
