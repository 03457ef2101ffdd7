/* Devices at junctions: the list of their kinds, and loops over those of a scene. */
#include "device.h"

#include "report.h"

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

static int spring_check(const gallop_device *d, gallop_report *report)
{
    for (int i = 0; i < 3; i++)
        if (!(d->parameter[i] >= 0.0))
            return report_invalid(report, "stiffness of a support", d->parameter[i], 0.0);
    return GALLOP_COMPLETED;
}

static void spring_prepare(const gallop_model *model, const gallop_device *from, device *d)
{
    (void)model;
    memcpy(d->constant, from->parameter, sizeof d->constant);
}

static int adjacent_span_check(const gallop_device *d, gallop_report *report)
{
    static const char *const name[] = {"adjacent span", "adjacent tension", "insulator length"};
    for (int i = 0; i < 3; i++)
        if (!(d->parameter[i] > 0.0)) return report_invalid(report, name[i], d->parameter[i], 0.0);
    if (!(d->parameter[3] >= 0.0))
        return report_invalid(report, "insulator weight", d->parameter[3], 0.0);
    return GALLOP_COMPLETED;
}

/* The chain that ends at a junction. */
static const chain *chain_at(const gallop_model *model, int junction_index)
{
    const chain *c = model->chain;
    while (c->junction[0] != junction_index && c->junction[1] != junction_index) c++;
    return c;
}

/* The adjacent span and its insulator string as springs (Liu et al. 2009, eq. 23-24). */
static void adjacent_span_prepare(const gallop_model *model, const gallop_device *from, device *d)
{
    const chain *c = chain_at(model, from->junction[0]);
    const double lx = from->parameter[0], h = from->parameter[1];
    const double length = from->parameter[2], string_weight = from->parameter[3];
    const double weight = c->section->mass * c->gravity;
    const double span = 1.0 / (lx / c->section->axial_stiffness +
                               weight * weight * lx * lx * lx / (12.0 * h * h * h));
    const double string = (weight * c->span + 0.5 * string_weight) / length;
    d->constant[SPRING_STIFFNESS] = span + string;
    d->constant[SPRING_STIFFNESS + 2] = string + 2.0 * h / lx;
}

/* ---- the kinds, by gallop_device_kind ---- */

static const device_kind kinds[] = {
    [GALLOP_DEVICE_SPRING] = {"spring", 1, spring_check, spring_prepare, spring_add_force,
                              spring_add_tangent, spring_energy},
    [GALLOP_DEVICE_ADJACENT_SPAN] = {"adjacent span", 1, adjacent_span_check, adjacent_span_prepare,
                                     spring_add_force, spring_add_tangent, spring_energy},
};

int device_check_all(const gallop_scene *s, gallop_report *report)
{
    const int32_t count = sizeof kinds / sizeof *kinds;
    int outcome = GALLOP_COMPLETED;
    for (int32_t i = 0; i < s->device_count && !outcome; i++) {
        const gallop_device *d = &s->device[i];
        if (d->kind < 0 || d->kind >= count)
            return report_invalid(report, "kind of a device", d->kind, count - 1.0);
        const bool second = kinds[d->kind].junctions == 2;
        if (second != (d->junction[1] >= 0) || d->junction[1] == d->junction[0])
            return report_invalid(report, "second junction of a device", d->junction[1], -1.0);
        outcome = kinds[d->kind].check(d, report);
    }
    return outcome;
}

void device_create_all(gallop_model *model)
{
    for (int i = 0; i < model->device_count; i++) {
        const gallop_device *from = &model->scene.device[i];
        device *d = &model->device[i];
        d->kind = &kinds[from->kind];
        d->junction[0] = from->junction[0];
        d->junction[1] = from->junction[1];
        d->kind->prepare(model, from, d);
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

bool device_holds(const gallop_model *model, int index, int unknown)
{
    const tangent_weights stiffness = {1.0, 0.0, 0.0};
    for (int i = 0; i < model->device_count; i++) {
        const device *d = &model->device[i];
        const device_motion rest[2] = {{at_rest, at_rest, at_rest, at_rest},
                                       {at_rest, at_rest, at_rest, at_rest}};
        double tangent[2][2][16] = {{{0.0}}};
        d->kind->add_tangent(d, rest, stiffness, tangent);
        for (int k = 0; k < d->kind->junctions; k++)
            if (d->junction[k] == index && tangent[k][k][5 * unknown] > 0.0) return true;
    }
    return false;
}
