/* Devices at junctions: the list of their kinds, and loops over those of a scene. */
#include "device.h"

/* ---- springs to the tower: of a support, or of the adjacent span and its insulator string ---- */

enum { SPRING_STIFFNESS = 0 }; /* constant[0..2]: along x1, x2, x3 [N/m] */

static void spring_add_force(const device *d, const device_motion y[2], double force[2][4])
{
    const double *stiffness = d->constant + SPRING_STIFFNESS;
    for (int i = 0; i < 3; i++) force[0][i] += stiffness[i] * (y[0].u[i] - y[0].tower[i]);
}

static void spring_add_tangent(const device *d, const device_motion y[2], tangent_weights weights,
                               double tangent[2][2][16])
{
    const double *stiffness = d->constant + SPRING_STIFFNESS;
    (void)y;
    for (int i = 0; i < 3; i++) tangent[0][0][5 * i] += weights.k * stiffness[i];
}

static double spring_energy(const device *d, const device_motion y[2])
{
    const double *stiffness = d->constant + SPRING_STIFFNESS;
    double energy = 0.0;
    for (int i = 0; i < 3; i++) {
        const double stretch = y[0].u[i] - y[0].tower[i];
        energy += 0.5 * stiffness[i] * stretch * stretch;
    }
    return energy;
}

static const device_kind spring = {"spring", 1, spring_add_force, spring_add_tangent,
                                   spring_energy};

/* Springs given, or of the adjacent span and its insulator string (Liu et al. 2009, eq. 23-24). */
static void support_stiffness(const gallop_scene *s, const gallop_support *support, double k[2])
{
    k[0] = support->stiffness_x1;
    k[1] = support->stiffness_x3;
    if (support->kind != GALLOP_SUPPORT_ADJACENT_SPAN) return;
    const double lx = support->adjacent_span, h = support->adjacent_tension;
    const double weight = (s->mass + s->ice_mass) * s->gravity;
    const double span =
        1.0 / (lx / s->axial_stiffness + weight * weight * lx * lx * lx / (12.0 * h * h * h));
    const double string =
        (weight * s->length + 0.5 * support->insulator_weight) / support->insulator_length;
    k[0] = span + string;
    k[1] = string + 2.0 * h / lx;
}

void device_create_all(gallop_model *model)
{
    for (int end = 0; end < 2; end++) {
        const gallop_support *support = &model->scene.support[end];
        if (support->kind == GALLOP_SUPPORT_RIGID) continue;
        double *derived = model->derived.support_stiffness[end];
        device *d = &model->device[model->device_count++];
        support_stiffness(&model->scene, support, derived);
        *d = (device){.kind = &spring, .junction = {end, -1}};
        d->constant[SPRING_STIFFNESS] = derived[0];
        d->constant[SPRING_STIFFNESS + 2] = derived[1];
    }
}

/* ---- all devices ---- */

static const double at_rest[4] = {0.0, 0.0, 0.0, 0.0};

static void motion_of(const gallop_model *model, const device *d, const conditions *now, motion y,
                      device_motion of[2])
{
    for (int k = 0; k < 2; k++) {
        of[k] = (device_motion){at_rest, at_rest, at_rest, at_rest};
        if (k >= d->kind->junctions) continue;
        const int node = 4 * model->junction[d->junction[k]].node;
        of[k] =
            (device_motion){y.u + node, y.v + node, y.a + node, now->position + 3 * d->junction[k]};
    }
}

void device_add_forces(const gallop_model *model, const conditions *now, motion y, double *residual)
{
    for (int i = 0; i < model->device_count; i++) {
        const device *d = &model->device[i];
        double force[2][4] = {{0.0}, {0.0}};
        device_motion of[2];
        motion_of(model, d, now, y, of);
        d->kind->add_force(d, of, force);
        for (int k = 0; k < d->kind->junctions; k++) {
            double *node = residual + 4 * model->junction[d->junction[k]].node;
            for (int n = 0; n < 4; n++) node[n] += force[k][n];
        }
    }
}

void device_forces_at(const gallop_model *model, int index, const conditions *now, motion y,
                      double force[4])
{
    for (int n = 0; n < 4; n++) force[n] = 0.0;
    for (int i = 0; i < model->device_count; i++) {
        const device *d = &model->device[i];
        for (int k = 0; k < d->kind->junctions; k++) {
            if (d->junction[k] != index) continue;
            double all[2][4] = {{0.0}, {0.0}};
            device_motion of[2];
            motion_of(model, d, now, y, of);
            d->kind->add_force(d, of, all);
            for (int n = 0; n < 4; n++) force[n] += all[k][n];
        }
    }
}

void device_tangent(const gallop_model *model, const device *d, const conditions *now, motion y,
                    tangent_weights weights, double tangent[2][2][16])
{
    device_motion of[2];
    memset(tangent, 0, 2 * 2 * 16 * sizeof(double));
    motion_of(model, d, now, y, of);
    d->kind->add_tangent(d, of, weights, tangent);
}

double device_energy(const gallop_model *model, const conditions *now, motion y)
{
    double energy = 0.0;
    for (int i = 0; i < model->device_count; i++) {
        const device *d = &model->device[i];
        device_motion of[2];
        motion_of(model, d, now, y, of);
        energy += d->kind->energy(d, of);
    }
    return energy;
}
