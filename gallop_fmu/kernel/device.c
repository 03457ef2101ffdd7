/* Devices at junctions: the list of their kinds, and loops over those of a scene. */
#include "device.h"

#define KINDS (GALLOP_DEVICE_BAR + 1)

static const device_kind *const kinds[KINDS] = {
    [GALLOP_DEVICE_SPRING] = &device_spring,
    [GALLOP_DEVICE_ADJACENT_SPAN] = &device_adjacent_span,
    [GALLOP_DEVICE_STRING] = &device_string,
    [GALLOP_DEVICE_V_STRING] = &device_v_string,
    [GALLOP_DEVICE_FRAME] = &device_frame,
    [GALLOP_DEVICE_YOKE] = &device_yoke,
    [GALLOP_DEVICE_POINT_MASS] = &device_point_mass,
    [GALLOP_DEVICE_PENDULUM] = &device_pendulum,
    [GALLOP_DEVICE_DAMPER] = &device_damper,
    [GALLOP_DEVICE_BAR] = &device_interphase_spacer,
};

/* The junctions of a device are different ones, as many as its kind has. */
static int check_junctions(const gallop_device *d, gallop_report *report)
{
    const device_kind *kind = kinds[d->kind];
    if (d->junctions < kind->least || d->junctions > kind->most)
        return report_invalid(report, "number of junctions of a device", d->junctions, kind->most);
    for (int i = 0; i < GALLOP_DEVICE_JUNCTIONS; i++) {
        const bool own = i < d->junctions;
        if (own != (d->junction[i] >= 0))
            return report_invalid(report, "junction of a device", d->junction[i], -1.0);
        for (int k = 0; k < i && own; k++)
            if (d->junction[k] == d->junction[i])
                return report_invalid(report, "junction of a device, which is given twice",
                                      d->junction[i], -1.0);
    }
    return GALLOP_COMPLETED;
}

int device_check_all(const gallop_scene *s, gallop_report *report)
{
    int outcome = GALLOP_COMPLETED;
    for (int32_t i = 0; i < s->device_count && !outcome; i++) {
        const gallop_device *d = &s->device[i];
        if (d->kind < 0 || d->kind >= KINDS)
            return report_invalid(report, "kind of a device", d->kind, KINDS - 1.0);
        outcome = check_junctions(d, report);
        if (!outcome) outcome = kinds[d->kind]->check(d, report);
    }
    return outcome;
}

void device_create_all(gallop_model *model)
{
    for (int i = 0; i < model->device_count; i++) {
        const gallop_device *from = &model->scene.device[i];
        device *d = &model->device[i];
        d->kind = kinds[from->kind];
        d->junctions = from->junctions;
        memcpy(d->junction, from->junction, sizeof d->junction);
        d->gravity = model->scene.settings.gravity;
    }
}

void device_prepare_all(gallop_model *model)
{
    for (int i = 0; i < model->device_count; i++) {
        device *d = &model->device[i];
        d->kind->prepare(model, &model->scene.device[i], d);
    }
}

bool device_leaves_plane(const gallop_model *model)
{
    for (int i = 0; i < model->device_count; i++)
        if (model->device[i].kind->leaves_plane) return true;
    return false;
}

/* ---- the motion of a device ---- */

static const double at_rest[4] = {0.0, 0.0, 0.0, 0.0};

static void motion_of(const gallop_model *model, const device *d, const conditions *now, motion y,
                      device_motion of[GALLOP_DEVICE_JUNCTIONS])
{
    for (int k = 0; k < d->junctions; k++) {
        const junction *j = &model->junction[d->junction[k]];
        const int node = 4 * j->node, axis = 3 * d->junction[k];
        of[k] = (device_motion){
            .u = y.u + node,
            .v = y.v + node,
            .a = y.a + node,
            .moved = j->moved,
            .tower = now->position + axis,
            .tower_velocity = now->velocity + axis,
            .tower_acceleration = now->acceleration + axis,
        };
    }
}

/* At rest in the initial equilibrium, as are the towers. */
static void rest_of(const gallop_model *model, const device *d,
                    device_motion of[GALLOP_DEVICE_JUNCTIONS])
{
    for (int k = 0; k < d->junctions; k++)
        of[k] = (device_motion){at_rest, at_rest, at_rest, model->junction[d->junction[k]].moved,
                                at_rest, at_rest, at_rest};
}

/* ---- all devices ---- */

void device_force(const gallop_model *model, const device *d, const conditions *now, motion y,
                  double force[GALLOP_DEVICE_JUNCTIONS][4])
{
    device_motion of[GALLOP_DEVICE_JUNCTIONS];
    memset(force, 0, (size_t)d->junctions * sizeof *force);
    motion_of(model, d, now, y, of);
    d->kind->add_force(d, of, force);
}

void device_add_forces(const gallop_model *model, int half, const conditions *now, motion y,
                       double *residual)
{
    for (int i = 0; i < model->device_count; i++) {
        const device *d = &model->device[i];
        double force[GALLOP_DEVICE_JUNCTIONS][4];
        if (!(d->halves & 1 << half)) continue;
        device_force(model, d, now, y, force);
        for (int k = 0; k < d->junctions; k++) {
            const int node = model->junction[d->junction[k]].node;
            if (model_half_of_node(model, node) != half) continue;
            for (int n = 0; n < 4; n++) residual[4 * node + n] += force[k][n];
        }
    }
}

void device_tower_force(const gallop_model *model, int index, const conditions *now, motion y,
                        double force[3])
{
    for (int n = 0; n < 3; n++) force[n] = 0.0;
    for (int i = 0; i < model->device_count; i++) {
        const device *d = &model->device[i];
        double of_device[3];
        device_motion of[GALLOP_DEVICE_JUNCTIONS];
        if (d->junction[0] != index || !d->kind->on_tower) continue;
        motion_of(model, d, now, y, of);
        d->kind->on_tower(d, of, of_device);
        for (int n = 0; n < 3; n++) force[n] += of_device[n];
    }
}

void device_tangent(const gallop_model *model, const device *d, const conditions *now, motion y,
                    tangent_weights weights,
                    device_block tangent[GALLOP_DEVICE_JUNCTIONS * GALLOP_DEVICE_JUNCTIONS])
{
    device_motion of[GALLOP_DEVICE_JUNCTIONS];
    memset(tangent, 0, (size_t)(d->junctions * d->junctions) * sizeof *tangent);
    motion_of(model, d, now, y, of);
    d->kind->add_tangent(d, of, weights, tangent);
}

void device_load(const gallop_model *model, const device *d, const double *u, const double *v,
                 double *force, device_block *by_u, device_block *by_v)
{
    device_motion of[GALLOP_DEVICE_JUNCTIONS];
    double sum[GALLOP_DEVICE_JUNCTIONS][4] = {{0.0}};
    const size_t blocks = (size_t)d->junctions * (size_t)d->junctions;
    rest_of(model, d, of);
    for (int k = 0; k < d->junctions; k++) {
        of[k].u = u + 4 * k;
        of[k].v = v + 4 * k;
    }
    d->kind->add_force(d, of, sum);
    memcpy(force, sum, (size_t)d->junctions * sizeof *sum);
    memset(by_u, 0, blocks * sizeof *by_u);
    memset(by_v, 0, blocks * sizeof *by_v);
    d->kind->add_tangent(d, of, (tangent_weights){1.0, 0.0, 0.0}, by_u);
    d->kind->add_tangent(d, of, (tangent_weights){0.0, 1.0, 0.0}, by_v);
}

void device_add_energy(const gallop_model *model, const device *d, const conditions *now, motion y,
                       double *kinetic, double *potential)
{
    device_motion of[GALLOP_DEVICE_JUNCTIONS];
    double none = 0.0, at_start = 0.0;
    rest_of(model, d, of);
    d->kind->add_energy(d, of, &none, &at_start);
    motion_of(model, d, now, y, of);
    d->kind->add_energy(d, of, kinetic, potential);
    *potential -= at_start;
}

void device_add_energies(const gallop_model *model, const conditions *now, motion y,
                         double *kinetic, double *potential)
{
    for (int i = 0; i < model->device_count; i++)
        device_add_energy(model, &model->device[i], now, y, kinetic, potential);
}

/* What devices contribute to the diagonal of the tangent at a junction, at rest in the initial
 * equilibrium. */
static double diagonal_at(const gallop_model *model, int index, int unknown,
                          tangent_weights weights)
{
    double sum = 0.0;
    for (int i = 0; i < model->device_count; i++) {
        const device *d = &model->device[i];
        device_motion rest[GALLOP_DEVICE_JUNCTIONS];
        device_block tangent[GALLOP_DEVICE_JUNCTIONS * GALLOP_DEVICE_JUNCTIONS] = {{0.0}};
        for (int k = 0; k < d->junctions; k++) {
            if (d->junction[k] != index) continue;
            rest_of(model, d, rest);
            d->kind->add_tangent(d, rest, weights, tangent);
            sum += tangent[(d->junctions + 1) * k][5 * unknown];
        }
    }
    return sum;
}

bool device_holds(const gallop_model *model, int index, int unknown)
{
    const tangent_weights stiffness = {1.0, 0.0, 0.0};
    for (int i = 0; i < model->device_count; i++) {
        const device *d = &model->device[i];
        for (int k = 0; k < d->junctions; k++)
            if (d->junction[k] == index && d->kind->holds && unknown < 3) return true;
    }
    return diagonal_at(model, index, unknown, stiffness) > 0.0;
}

bool device_gives_mass(const gallop_model *model, int index, int unknown)
{
    const tangent_weights mass = {0.0, 0.0, 1.0};
    return diagonal_at(model, index, unknown, mass) > 0.0;
}

static double value_of(const device *d, const device_motion *of, int channel)
{
    double force[3] = {0.0, 0.0, 0.0};
    if (channel > GALLOP_TOWER_FORCE_3)
        return d->kind->observe ? d->kind->observe(d, of, channel) : 0.0;
    if (d->kind->on_tower) d->kind->on_tower(d, of, force);
    return force[channel];
}

double device_value(const gallop_model *model, int index, const conditions *now, motion y,
                    int channel)
{
    device_motion of[GALLOP_DEVICE_JUNCTIONS];
    motion_of(model, &model->device[index], now, y, of);
    return value_of(&model->device[index], of, channel);
}

double device_value_at_rest(const gallop_model *model, int index, int channel)
{
    device_motion of[GALLOP_DEVICE_JUNCTIONS];
    rest_of(model, &model->device[index], of);
    return value_of(&model->device[index], of, channel);
}

double device_tower_force_at_rest(const gallop_model *model, int index, int axis)
{
    double force = 0.0;
    for (int i = 0; i < model->device_count; i++)
        if (model->device[i].junction[0] == index)
            force += device_value_at_rest(model, i, GALLOP_TOWER_FORCE_1 + axis);
    return force;
}
