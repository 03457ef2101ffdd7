/* Insulator strings: one from a point of the tower, or two in a V from points on either side.
 *
 * A string is a uniform straight bar: half of its weight hangs at each end, and its mass M acts as
 * M/3 and M/6 (consistent mass of a linear velocity) on the accelerations of the two ends. */
#include "device_string.h"

#include "base_math.h"

/* ---- one bar ---- */

void device_string_vector(const insulator *s, const insulator_motion *y, double r[3])
{
    for (int i = 0; i < 3; i++) r[i] = s->strung[i] + y->place[i] - y->tower[i];
}

static void read_string(const insulator *s, const insulator_motion *y, double r[3], double rate[3])
{
    device_string_vector(s, y, r);
    for (int i = 0; i < 3; i++) rate[i] = y->velocity[i] - y->tower_velocity[i];
}

void device_string_force(const insulator *s, const insulator_motion *y, double force[3])
{
    double r[3], rate[3], along[3];
    read_string(s, y, r, rate);
    const double pull = device_bar_pull(&s->bar, r, rate, along);
    for (int i = 0; i < 3; i++)
        force[i] =
            pull * along[i] + s->mass / 6.0 * (2.0 * y->acceleration[i] + y->tower_acceleration[i]);
    force[1] += 0.5 * s->weight;
}

void device_string_slopes(const insulator *s, const insulator_motion *y, double by_place[9],
                          double by_velocity[9])
{
    double r[3], rate[3];
    read_string(s, y, r, rate);
    device_bar_slopes(&s->bar, r, rate, by_place, by_velocity);
}

void device_string_add_energy(const insulator *s, const insulator_motion *y, double *kinetic,
                              double *potential)
{
    double r[3];
    device_string_vector(s, y, r);
    *potential += device_bar_energy(&s->bar, r) + 0.5 * s->weight * (y->place[1] + y->tower[1]);
    for (int i = 0; i < 3; i++) {
        const double v = y->velocity[i], tower = y->tower_velocity[i];
        *kinetic += s->mass / 6.0 * (v * v + v * tower + tower * tower);
    }
}

void device_string_add_on_tower(const insulator *s, const insulator_motion *y, double force[3])
{
    double r[3], rate[3], along[3];
    read_string(s, y, r, rate);
    const double pull = device_bar_pull(&s->bar, r, rate, along);
    for (int i = 0; i < 3; i++)
        force[i] +=
            pull * along[i] - s->mass / 6.0 * (y->acceleration[i] + 2.0 * y->tower_acceleration[i]);
    force[1] -= 0.5 * s->weight;
}

double device_string_pull(const insulator *s, const insulator_motion *y)
{
    double r[3], rate[3], along[3];
    read_string(s, y, r, rate);
    return device_bar_pull(&s->bar, r, rate, along);
}

double device_string_lean(const double r[3], int channel)
{
    return arctangent(r[channel == GALLOP_LEAN_ALONG ? 0 : 2], -r[1]);
}

/* ---- strings at a junction: one, or two ---- */

enum {
    BARS,   /* 1 or 2 */
    LENGTH, /* of each bar: */
    WEIGHT,
    STIFFNESS,
    DAMPING,
    STRUNG,                      /* of the first bar, then of the second: 3 numbers each */
    CLAMP_STIFFNESS = STRUNG + 6 /* torsional, against the lean across the line [N m/rad] */
};

static int bars_of(const device *d)
{
    return d->constant[BARS] > 1.5 ? 2 : 1;
}

static insulator insulator_of(const device *d, int index)
{
    const double *c = d->constant, *strung = c + STRUNG + 3 * index;
    return (insulator){{c[LENGTH], c[STIFFNESS], c[DAMPING]},
                       c[WEIGHT],
                       c[WEIGHT] / d->gravity,
                       {strung[0], strung[1], strung[2]}};
}

/* The lower end is the junction; `place` is room for its displacement from the strung state. */
static insulator_motion motion_of(const device_motion *y, double place[3])
{
    for (int i = 0; i < 3; i++) place[i] = y->moved[i] + y->u[i];
    return (insulator_motion){
        place, y->v, y->a, y->tower, y->tower_velocity, y->tower_acceleration};
}

/* From the middle of the tower's points to the junction. */
static void vector_of(const device *d, const device_motion *y, double r[3])
{
    double place[3], more[3];
    const insulator_motion at = motion_of(y, place);
    const insulator first = insulator_of(d, 0), last = insulator_of(d, bars_of(d) - 1);
    device_string_vector(&first, &at, r);
    device_string_vector(&last, &at, more);
    for (int i = 0; i < 3; i++) r[i] = 0.5 * (r[i] + more[i]);
}

/* By how much the clamp is turned against the string, which leans by `lean` towards +x3 where the
 * conductor would turn by -lean; whole turns are not counted. */
static double clamp_twist(const double r[3], double theta)
{
    const double twist = theta + device_string_lean(r, GALLOP_LEAN_ACROSS);
    return twist - 2.0 * PI * nearest(twist / (2.0 * PI));
}

/* Gradient of the lean across by x2 and x3; its second derivatives by x2 x2, x2 x3, x3 x3. */
static void lean_slopes(const double r[3], double first[2], double second[3])
{
    const double square = r[1] * r[1] + r[2] * r[2];
    first[0] = r[2] / square;
    first[1] = -r[1] / square;
    second[0] = -2.0 * r[1] * r[2] / (square * square);
    second[1] = (r[1] * r[1] - r[2] * r[2]) / (square * square);
    second[2] = -second[0];
}

/* Force and moment of the clamp's stiffness on the junction; the tower has the opposite force. */
static void clamp_force(const device *d, const device_motion *y, double force[4])
{
    double r[3], first[2], second[3];
    for (int i = 0; i < 4; i++) force[i] = 0.0;
    if (d->constant[CLAMP_STIFFNESS] == 0.0) return;
    vector_of(d, y, r);
    lean_slopes(r, first, second);
    const double moment = d->constant[CLAMP_STIFFNESS] * clamp_twist(r, y->u[3]);
    force[1] = moment * first[0];
    force[2] = moment * first[1];
    force[3] = moment;
}

static void add_force(const device *d, const device_motion *y, double force[][4])
{
    double place[3];
    const insulator_motion at = motion_of(y, place);
    for (int b = 0; b < bars_of(d); b++) {
        const insulator s = insulator_of(d, b);
        double of_bar[3];
        device_string_force(&s, &at, of_bar);
        for (int i = 0; i < 3; i++) force[0][i] += of_bar[i];
    }
    double of_clamp[4];
    clamp_force(d, y, of_clamp);
    for (int i = 0; i < 4; i++) force[0][i] += of_clamp[i];
}

static void add_clamp_tangent(const device *d, const device_motion *y, double k, double *tangent)
{
    double r[3], first[2], second[3];
    vector_of(d, y, r);
    lean_slopes(r, first, second);
    const double stiffness = k * d->constant[CLAMP_STIFFNESS];
    const double moment = stiffness * clamp_twist(r, y->u[3]);
    const double gradient[3] = {first[0], first[1], 1.0}; /* of the twist, by x2, x3, theta */
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            const double bend = i < 2 && j < 2 ? second[i + j] : 0.0;
            tangent[4 * (i + 1) + j + 1] += stiffness * gradient[i] * gradient[j] + moment * bend;
        }
}

static void add_tangent(const device *d, const device_motion *y, tangent_weights weights,
                        device_block *tangent)
{
    double place[3];
    const insulator_motion at = motion_of(y, place);
    for (int b = 0; b < bars_of(d); b++) {
        const insulator s = insulator_of(d, b);
        double by_place[9], by_velocity[9];
        device_string_slopes(&s, &at, by_place, by_velocity);
        for (int i = 0; i < 3; i++) {
            for (int j = 0; j < 3; j++)
                tangent[0][4 * i + j] +=
                    weights.k * by_place[3 * i + j] + weights.c * by_velocity[3 * i + j];
            tangent[0][5 * i] += weights.m * s.mass / 3.0;
        }
    }
    if (d->constant[CLAMP_STIFFNESS] != 0.0) add_clamp_tangent(d, y, weights.k, tangent[0]);
}

static void add_energy(const device *d, const device_motion *y, double *kinetic, double *potential)
{
    double place[3], r[3];
    const insulator_motion at = motion_of(y, place);
    for (int b = 0; b < bars_of(d); b++) {
        const insulator s = insulator_of(d, b);
        device_string_add_energy(&s, &at, kinetic, potential);
    }
    vector_of(d, y, r);
    const double twist = clamp_twist(r, y->u[3]);
    *potential += 0.5 * d->constant[CLAMP_STIFFNESS] * twist * twist;
}

static void on_tower(const device *d, const device_motion *y, double force[3])
{
    double place[3], of_clamp[4];
    const insulator_motion at = motion_of(y, place);
    clamp_force(d, y, of_clamp);
    for (int i = 0; i < 3; i++) force[i] = of_clamp[i];
    for (int b = 0; b < bars_of(d); b++) {
        const insulator s = insulator_of(d, b);
        device_string_add_on_tower(&s, &at, force);
    }
}

/* The pull of two bars is the smaller one, of the bar that is the first to be pushed. */
static double observe(const device *d, const device_motion *y, int channel)
{
    double place[3], r[3];
    if (channel == GALLOP_PULL) {
        const insulator_motion at = motion_of(y, place);
        const insulator first = insulator_of(d, 0), last = insulator_of(d, bars_of(d) - 1);
        return fmin(device_string_pull(&first, &at), device_string_pull(&last, &at));
    }
    if (channel != GALLOP_LEAN_ALONG && channel != GALLOP_LEAN_ACROSS) return 0.0;
    vector_of(d, y, r);
    return device_string_lean(r, channel);
}

static const device_parameter string_parameters[] = {
    {"length of a string", true},
    {"weight of a string", false},
    {"stiffness of a string", true},
    {"damping of a string", false},
    {"torsional stiffness of the clamp of a string", false},
};

static int string_check(const gallop_device *d, gallop_report *report)
{
    return device_check_parameters(d, string_parameters, 5, report);
}

static void prepare_bars(const gallop_device *from, device *d, int bars)
{
    d->constant[BARS] = bars;
    memcpy(d->constant + LENGTH, from->parameter, 4 * sizeof(double));
    memset(d->constant + STRUNG, 0, 6 * sizeof(double));
}

static void string_prepare(const gallop_model *model, const gallop_device *from, device *d)
{
    const double *tower = from->parameter + 5; /* its point, seen from the clamp */
    const bool above = tower[0] == 0.0 && tower[1] == 0.0 && tower[2] == 0.0;
    (void)model;
    prepare_bars(from, d, 1);
    for (int i = 0; i < 3; i++) d->constant[STRUNG + i] = -tower[i];
    if (above) d->constant[STRUNG + 1] = -from->parameter[0];
    d->constant[CLAMP_STIFFNESS] = from->parameter[4];
    d->reach = from->parameter[0];
}

const device_kind device_string = {
    .name = "string",
    .least = 1,
    .most = 1,
    .holds = true,
    .check = string_check,
    .prepare = string_prepare,
    .add_force = add_force,
    .add_tangent = add_tangent,
    .add_energy = add_energy,
    .on_tower = on_tower,
    .observe = observe,
};

static int v_string_check(const gallop_device *d, gallop_report *report)
{
    const int outcome = device_check_parameters(d, string_parameters, 4, report);
    if (outcome) return outcome;
    if (!(d->parameter[4] > 0.0 && d->parameter[4] < d->parameter[0]))
        return report_invalid(report, "half the spread of a V-string", d->parameter[4],
                              d->parameter[0]);
    return GALLOP_COMPLETED;
}

static void v_string_prepare(const gallop_model *model, const gallop_device *from, device *d)
{
    const double length = from->parameter[0], half = from->parameter[4];
    const double height = sqrt(length * length - half * half);
    (void)model;
    prepare_bars(from, d, 2);
    for (int b = 0; b < 2; b++) {
        double *strung = d->constant + STRUNG + 3 * b;
        strung[1] = -height;
        strung[2] = b ? -half : half;
    }
    d->constant[CLAMP_STIFFNESS] = 0.0;
    d->reach = height;
}

const device_kind device_v_string = {
    .name = "V-string",
    .least = 1,
    .most = 1,
    .holds = true,
    .check = v_string_check,
    .prepare = v_string_prepare,
    .add_force = add_force,
    .add_tangent = add_tangent,
    .add_energy = add_energy,
    .on_tower = on_tower,
    .observe = observe,
};
