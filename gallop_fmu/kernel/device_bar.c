/* A bar with ball joints; the interphase spacer is one between two conductors. */
#include "device_bar.h"

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Length and unit vector of r; a vector without length has no direction. */
static double direction(const double r[3], double along[3])
{
    const double length = sqrt(dot(r, r));
    for (int i = 0; i < 3; i++) along[i] = length > 0.0 ? r[i] / length : 0.0;
    return length;
}

double device_bar_pull(const bar *b, const double r[3], const double rate[3], double along[3])
{
    const double length = direction(r, along);
    return b->stiffness * (length - b->length) + b->damping * dot(along, rate);
}

/* With e along r, |r| = l, P = I - e e^T, and pull N = k (l - l0) + c e.r':
 * d(N e)/dr = k e e^T + N/l P + c/l e (P r')^T,  d(N e)/dr' = c e e^T. */
void device_bar_slopes(const bar *b, const double r[3], const double rate[3], double by_r[9],
                       double by_rate[9])
{
    double e[3];
    const double length = direction(r, e), lengthening = dot(e, rate);
    const double pull = device_bar_pull(b, r, rate, e);
    const double per_length = length > 0.0 ? 1.0 / length : 0.0;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            const double across = (i == j) - e[i] * e[j];
            by_r[3 * i + j] = b->stiffness * e[i] * e[j] + pull * per_length * across +
                              b->damping * per_length * e[i] * (rate[j] - lengthening * e[j]);
            by_rate[3 * i + j] = b->damping * e[i] * e[j];
        }
}

double device_bar_energy(const bar *b, const double r[3])
{
    double along[3];
    const double stretch = direction(r, along) - b->length;
    return 0.5 * b->stiffness * stretch * stretch;
}

/* ---- The interphase spacer: half of its mass at each of its two junctions. ---- */

enum { LENGTH, STIFFNESS, DAMPING, MASS, STRUNG }; /* STRUNG: r in the strung state, 3 numbers */

static bar bar_of(const device *d)
{
    return (bar){d->constant[LENGTH], d->constant[STIFFNESS], d->constant[DAMPING]};
}

static void read_bar(const device *d, const device_motion *y, double r[3], double rate[3])
{
    for (int i = 0; i < 3; i++) {
        r[i] = d->constant[STRUNG + i] + (y[1].moved[i] - y[0].moved[i]) + (y[1].u[i] - y[0].u[i]);
        rate[i] = y[1].v[i] - y[0].v[i];
    }
}

static int check(const gallop_device *d, gallop_report *report)
{
    static const device_parameter all[] = {{"stiffness of an interphase spacer", true},
                                           {"mass of an interphase spacer", false},
                                           {"damping of an interphase spacer", false}};
    return device_check_parameters(d, all, 3, report);
}

static void prepare(const gallop_model *model, const gallop_device *from, device *d)
{
    const double *first = model->junction[d->junction[0]].position;
    const double *second = model->junction[d->junction[1]].position;
    double along[3];
    for (int i = 0; i < 3; i++) d->constant[STRUNG + i] = second[i] - first[i];
    d->constant[LENGTH] = direction(d->constant + STRUNG, along);
    d->constant[STIFFNESS] = from->parameter[0];
    d->constant[MASS] = from->parameter[1];
    d->constant[DAMPING] = from->parameter[2];
}

static void add_force(const device *d, const device_motion *y, double force[][4])
{
    const bar b = bar_of(d);
    const double half = 0.5 * d->constant[MASS];
    double r[3], rate[3], along[3];
    read_bar(d, y, r, rate);
    const double pull = device_bar_pull(&b, r, rate, along);
    for (int i = 0; i < 3; i++) {
        force[0][i] += half * y[0].a[i] - pull * along[i];
        force[1][i] += half * y[1].a[i] + pull * along[i];
    }
    force[0][1] += half * d->gravity;
    force[1][1] += half * d->gravity;
}

static void add_tangent(const device *d, const device_motion *y, tangent_weights weights,
                        device_block *tangent)
{
    const bar b = bar_of(d);
    double r[3], rate[3], by_r[9], by_rate[9];
    read_bar(d, y, r, rate);
    device_bar_slopes(&b, r, rate, by_r, by_rate);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            const double slope = weights.k * by_r[3 * i + j] + weights.c * by_rate[3 * i + j];
            for (int k = 0; k < 4; k++) tangent[k][4 * i + j] += k == 0 || k == 3 ? slope : -slope;
        }
    for (int i = 0; i < 3; i++) {
        tangent[0][5 * i] += 0.5 * weights.m * d->constant[MASS];
        tangent[3][5 * i] += 0.5 * weights.m * d->constant[MASS];
    }
}

static void add_energy(const device *d, const device_motion *y, double *kinetic, double *potential)
{
    const bar b = bar_of(d);
    const double half = 0.5 * d->constant[MASS];
    double r[3], rate[3];
    read_bar(d, y, r, rate);
    *potential += device_bar_energy(&b, r);
    for (int k = 0; k < 2; k++) {
        *kinetic += 0.5 * half * dot(y[k].v, y[k].v);
        *potential += half * d->gravity * (y[k].u[1] + y[k].moved[1]);
    }
}

static double observe(const device *d, const device_motion *y, int channel)
{
    const bar b = bar_of(d);
    double r[3], rate[3], along[3];
    if (channel != GALLOP_PULL) return 0.0;
    read_bar(d, y, r, rate);
    return device_bar_pull(&b, r, rate, along);
}

const device_kind device_interphase_spacer = {
    .name = "interphase spacer",
    .least = 2,
    .most = 2,
    .leaves_plane = true,
    .check = check,
    .prepare = prepare,
    .add_force = add_force,
    .add_tangent = add_tangent,
    .add_energy = add_energy,
    .observe = observe,
};
