/* Point mass, pendulum, damper. */
#include "base_math.h"
#include "device.h"

/* ---- point mass ---- */

enum { MASS };

static int mass_check(const gallop_device *d, gallop_report *report)
{
    static const device_parameter all[] = {{"mass of a point mass", true}};
    return device_check_parameters(d, all, 1, report);
}

/* The constants are the parameters. */
static void prepare(const gallop_model *model, const gallop_device *from, device *d)
{
    (void)model;
    memcpy(d->constant, from->parameter, sizeof from->parameter);
}

static void mass_add_force(const device *d, const device_motion *y, double force[][4])
{
    const double mass = d->constant[MASS];
    for (int i = 0; i < 3; i++) force[0][i] += mass * y->a[i];
    force[0][1] += mass * d->gravity;
}

static void mass_add_tangent(const device *d, const device_motion *y, tangent_weights weights,
                             device_block *tangent)
{
    (void)y;
    for (int i = 0; i < 3; i++) tangent[0][5 * i] += weights.m * d->constant[MASS];
}

static void mass_add_energy(const device *d, const device_motion *y, double *kinetic,
                            double *potential)
{
    const double mass = d->constant[MASS];
    for (int i = 0; i < 3; i++) *kinetic += 0.5 * mass * y->v[i] * y->v[i];
    *potential += mass * d->gravity * (y->u[1] + y->moved[1]);
}

const device_kind device_point_mass = {
    .name = "point mass",
    .least = 1,
    .most = 1,
    .check = mass_check,
    .prepare = prepare,
    .add_force = mass_add_force,
    .add_tangent = mass_add_tangent,
    .add_energy = mass_add_energy,
};

/* ---- pendulum ----
 *
 * A mass m at the end of an arm l that is clamped to the conductor.  At theta = 0 the arm hangs at
 * the angle beta from straight down, towards +x3.  The conductor turns x2 towards x3, so that the
 * mass is at b = l (-cos psi, sin psi) along x2 and x3 from the conductor, psi = beta - theta. With
 * t = db/dtheta = -l (sin psi, cos psi) and dt/dtheta = -b its acceleration is
 * a + t theta'' - b theta'^2; a force f on it makes the moment t.f. */

enum { ARM = MASS + 1, ANGLE };

typedef struct {
    double b[2], t[2]; /* along x2 and x3 [m] */
    double force[3];   /* that moves the mass so [N] */
} pendulum;

static pendulum pendulum_of(const device *d, const device_motion *y)
{
    const double mass = d->constant[MASS], arm = d->constant[ARM];
    double sine, cosine;
    pendulum p;
    sine_cosine(d->constant[ANGLE] - y->u[3], &sine, &cosine);
    p.b[0] = -arm * cosine;
    p.b[1] = arm * sine;
    p.t[0] = -arm * sine;
    p.t[1] = -arm * cosine;
    p.force[0] = mass * y->a[0];
    for (int i = 0; i < 2; i++)
        p.force[i + 1] = mass * (y->a[i + 1] + p.t[i] * y->a[3] - p.b[i] * y->v[3] * y->v[3]);
    p.force[1] += mass * d->gravity;
    return p;
}

static int pendulum_check(const gallop_device *d, gallop_report *report)
{
    static const device_parameter all[] = {{"mass of a pendulum", true},
                                           {"arm of a pendulum", true}};
    return device_check_parameters(d, all, 2, report);
}

static void pendulum_add_force(const device *d, const device_motion *y, double force[][4])
{
    const pendulum p = pendulum_of(d, y);
    for (int i = 0; i < 3; i++) force[0][i] += p.force[i];
    force[0][3] += p.t[0] * p.force[1] + p.t[1] * p.force[2];
}

static void pendulum_add_tangent(const device *d, const device_motion *y, tangent_weights weights,
                                 device_block *tangent)
{
    const pendulum p = pendulum_of(d, y);
    const double mass = d->constant[MASS], rate = y->v[3];
    double *rows = tangent[0];
    for (int i = 0; i < 3; i++) rows[5 * i] += weights.m * mass;
    for (int i = 0; i < 2; i++) {
        const double by_theta = mass * (-p.b[i] * y->a[3] - p.t[i] * rate * rate);
        const double by_rate = -2.0 * mass * p.b[i] * rate, by_rate2 = mass * p.t[i];
        rows[4 * (i + 1) + 3] += weights.k * by_theta + weights.c * by_rate + weights.m * by_rate2;
        rows[12 + i + 1] += weights.m * by_rate2;
        rows[15] += weights.k * (p.t[i] * by_theta - p.b[i] * p.force[i + 1]) +
                    p.t[i] * (weights.c * by_rate + weights.m * by_rate2);
    }
}

static void pendulum_add_energy(const device *d, const device_motion *y, double *kinetic,
                                double *potential)
{
    const pendulum p = pendulum_of(d, y);
    const double mass = d->constant[MASS];
    const double v2 = y->v[1] + p.t[0] * y->v[3], v3 = y->v[2] + p.t[1] * y->v[3];
    *kinetic += 0.5 * mass * (y->v[0] * y->v[0] + v2 * v2 + v3 * v3);
    *potential += mass * d->gravity * (y->u[1] + y->moved[1] + p.b[0]);
}

/* The arm leans across the line. */
static double pendulum_observe(const device *d, const device_motion *y, int channel)
{
    return channel == GALLOP_LEAN_ACROSS ? d->constant[ANGLE] - y->u[3] : 0.0;
}

const device_kind device_pendulum = {
    .name = "pendulum",
    .least = 1,
    .most = 1,
    .leaves_plane = true,
    .check = pendulum_check,
    .prepare = prepare,
    .add_force = pendulum_add_force,
    .add_tangent = pendulum_add_tangent,
    .add_energy = pendulum_add_energy,
    .observe = pendulum_observe,
};

/* ---- damper: a dashpot and a spring side by side, along each axis; from the tower's point to the
 * junction, or from the second junction to the first ---- */

enum { DAMPING = 0, STIFFNESS = 3 };

/* From the strung state. */
static double damper_stretch(const device *d, const device_motion *y, int i)
{
    const double other = d->junctions > 1 ? y[1].u[i] + y[1].moved[i] : y[0].tower[i];
    return y[0].u[i] + y[0].moved[i] - other;
}

static double damper_rate(const device *d, const device_motion *y, int i)
{
    return y[0].v[i] - (d->junctions > 1 ? y[1].v[i] : y[0].tower_velocity[i]);
}

static double damper_force(const device *d, const device_motion *y, int i)
{
    return d->constant[STIFFNESS + i] * damper_stretch(d, y, i) +
           d->constant[DAMPING + i] * damper_rate(d, y, i);
}

static int damper_check(const gallop_device *d, gallop_report *report)
{
    static const device_parameter damping = {"damping of a damper", false},
                                  stiffness = {"stiffness of a damper", false};
    const device_parameter all[] = {damping, damping, damping, stiffness, stiffness, stiffness};
    return device_check_parameters(d, all, 6, report);
}

static void damper_add_force(const device *d, const device_motion *y, double force[][4])
{
    for (int i = 0; i < 3; i++) {
        const double f = damper_force(d, y, i);
        force[0][i] += f;
        if (d->junctions > 1) force[1][i] -= f;
    }
}

static void damper_add_tangent(const device *d, const device_motion *y, tangent_weights weights,
                               device_block *tangent)
{
    const int blocks = d->junctions * d->junctions;
    (void)y;
    for (int i = 0; i < 3; i++) {
        const double slope =
            weights.k * d->constant[STIFFNESS + i] + weights.c * d->constant[DAMPING + i];
        for (int k = 0; k < blocks; k++) tangent[k][5 * i] += k == 0 || k == 3 ? slope : -slope;
    }
}

static void damper_add_energy(const device *d, const device_motion *y, double *kinetic,
                              double *potential)
{
    (void)kinetic;
    for (int i = 0; i < 3; i++) {
        const double stretch = damper_stretch(d, y, i);
        *potential += 0.5 * d->constant[STIFFNESS + i] * stretch * stretch;
    }
}

static void damper_on_tower(const device *d, const device_motion *y, double force[3])
{
    for (int i = 0; i < 3; i++) force[i] = d->junctions > 1 ? 0.0 : damper_force(d, y, i);
}

const device_kind device_damper = {
    .name = "damper",
    .least = 1,
    .most = 2,
    .check = damper_check,
    .prepare = prepare,
    .add_force = damper_add_force,
    .add_tangent = damper_add_tangent,
    .add_energy = damper_add_energy,
    .on_tower = damper_on_tower,
};
