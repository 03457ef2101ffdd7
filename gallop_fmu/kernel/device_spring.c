/* Springs to the tower: of a support, or of the adjacent span and its insulator string. */
#include "device.h"

enum { STIFFNESS = 0 }; /* constant[0..2]: along x1, x2, x3 [N/m] */

/* From the strung state. */
static double stretch(const device_motion *y, int i)
{
    return y->u[i] + y->moved[i] - y->tower[i];
}

static void add_force(const device *d, const device_motion *y, double force[][4])
{
    const double *stiffness = d->constant + STIFFNESS;
    for (int i = 0; i < 3; i++) force[0][i] += stiffness[i] * stretch(y, i);
}

static void add_tangent(const device *d, const device_motion *y, tangent_weights weights,
                        device_block *tangent)
{
    const double *stiffness = d->constant + STIFFNESS;
    (void)y;
    for (int i = 0; i < 3; i++) tangent[0][5 * i] += weights.k * stiffness[i];
}

static void add_energy(const device *d, const device_motion *y, double *kinetic, double *potential)
{
    const double *stiffness = d->constant + STIFFNESS;
    (void)kinetic;
    for (int i = 0; i < 3; i++) *potential += 0.5 * stiffness[i] * stretch(y, i) * stretch(y, i);
}

static void on_tower(const device *d, const device_motion *y, double force[3])
{
    const double *stiffness = d->constant + STIFFNESS;
    for (int i = 0; i < 3; i++) force[i] = stiffness[i] * stretch(y, i);
}

static int spring_check(const gallop_device *d, gallop_report *report)
{
    static const device_parameter stiffness = {"stiffness of a support", false};
    const device_parameter all[] = {stiffness, stiffness, stiffness};
    return device_check_parameters(d, all, 3, report);
}

static void spring_prepare(const gallop_model *model, const gallop_device *from, device *d)
{
    (void)model;
    memcpy(d->constant, from->parameter, sizeof from->parameter);
}

const device_kind device_spring = {
    .name = "spring",
    .least = 1,
    .most = 1,
    .prestressed = true,
    .check = spring_check,
    .prepare = spring_prepare,
    .add_force = add_force,
    .add_tangent = add_tangent,
    .add_energy = add_energy,
    .on_tower = on_tower,
};

static int adjacent_span_check(const gallop_device *d, gallop_report *report)
{
    static const device_parameter all[] = {{"adjacent span", true},
                                           {"adjacent tension", true},
                                           {"insulator length", true},
                                           {"insulator weight", false}};
    return device_check_parameters(d, all, 4, report);
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
    const cross_section *section = model->interval[c->first_interval].section;
    const double lx = from->parameter[0], h = from->parameter[1];
    const double length = from->parameter[2], string_weight = from->parameter[3];
    const double weight = section->mass * d->gravity;
    const double span =
        1.0 / (lx / section->axial_stiffness + weight * weight * lx * lx * lx / (12.0 * h * h * h));
    const double string = (weight * c->span + 0.5 * string_weight) / length;
    d->constant[STIFFNESS] = span + string;
    d->constant[STIFFNESS + 2] = string + 2.0 * h / lx;
}

const device_kind device_adjacent_span = {
    .name = "adjacent span",
    .least = 1,
    .most = 1,
    .prestressed = true,
    .check = adjacent_span_check,
    .prepare = adjacent_span_prepare,
    .add_force = add_force,
    .add_tangent = add_tangent,
    .add_energy = add_energy,
    .on_tower = on_tower,
};
