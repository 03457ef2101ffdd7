/* Spacer frame and yoke: subconductors held at the arms of a frame that is rigid in the plane of x2
 * and x3.
 *
 * The frame has no unknowns of its own.  r_i are the places of its n clamps from their centre in
 * the strung state, x_i where the clamps are now, X their centre, p_i = x_i - X.  Its turn phi is
 * the one that fits best, the maximum of sum p_i . R(phi) r_i: with complex numbers x2 + i x3
 *
 *     z = sum conj(r_i) x_i = rho e^(i phi),    log z = log rho + i phi.
 *
 * At this turn the arms have the energy k_a/2 sum |p_i - R r_i|^2 = k_a/2 (sum |p_i|^2 + |r_i|^2)
 * - k_a rho, the clamps k_c/2 sum (theta_i - phi)^2; damping of the arms acts on the rates of
 * p_i - R r_i, with the dissipation c_a/2 (sum |p_i'|^2 + phi'^2 (sum |r_i|^2 - 2 rho)), that of
 * the clamps on the rates of theta_i - phi.
 *
 * So all but |p_i|^2 and |p_i'|^2 depends on the linear sums X and z of the clamps, their rates,
 * and the theta_i; forces and tangent are found in X and z.  A yoke hangs from a string at
 * the point P = X + h (cos phi, sin phi), whose force f adds f to the force in X, and the moment
 * b . f about phi, b = dP/dphi.
 *
 * Whole turns: phi is the one closest to the mean of the theta_i, so that a bundle may turn as
 * often as it does. */
#include "base_math.h"
#include "device_string.h"

#define MOST GALLOP_DEVICE_JUNCTIONS

enum {
    MASS, /* of the whole frame [kg] */
    ARM_STIFFNESS,
    ARM_DAMPING,
    CLAMP_STIFFNESS,
    CLAMP_DAMPING,
    HEIGHT, /* of the point at which a yoke hangs, above the centre [m] */
    LENGTH, /* of the string of a yoke; 0: a spacer, which hangs from none */
    WEIGHT,
    STIFFNESS,
    DAMPING,
    SQUARES,                /* sum of |r_i|^2 [m^2] */
    OFFSET,                 /* r_i along x2 and x3 [m] */
    END = OFFSET + 2 * MOST /* of the constants */
};

_Static_assert(END <= DEVICE_CONSTANTS, "room for the constants of a frame");

/* ---- complex numbers ---- */

typedef struct {
    double re, im;
} complex_number;

static complex_number product(complex_number a, complex_number b)
{
    return (complex_number){a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}

static complex_number scaled(double factor, complex_number a)
{
    return (complex_number){factor * a.re, factor * a.im};
}

static complex_number sum(complex_number a, complex_number b)
{
    return (complex_number){a.re + b.re, a.im + b.im};
}

/* Gradient of Im(g z) by the parts of z. */
static void gradient_of(complex_number g, double gradient[2])
{
    gradient[0] = g.im;
    gradient[1] = g.re;
}

/* ---- the motion of the frame ---- */

/* What the clamps make together: the turn and its rates, the centre and its rates. */
typedef struct {
    double rho, phi, phi_rate, phi_rate2;
    double sine, cosine;
    complex_number z, inverse, by_rate, by_rate2;   /* 1/z, z'/z, z''/z */
    double centre[3], velocity[3], acceleration[3]; /* centre: from the strung state */
    double sum_theta, sum_theta_rate;
} frame;

/* sum conj(r_i) w_i for a motion w of the clamps, along x2 and x3. */
static void add_to(complex_number *z, const double r[2], double w2, double w3)
{
    z->re += r[0] * w2 + r[1] * w3;
    z->im += r[0] * w3 - r[1] * w2;
}

static frame frame_of(const device *d, const device_motion *y)
{
    const double part = 1.0 / d->junctions;
    complex_number rate = {0.0, 0.0}, rate2 = {0.0, 0.0};
    frame f = {.z = {d->constant[SQUARES], 0.0}};
    for (int k = 0; k < d->junctions; k++) {
        const double *r = d->constant + OFFSET + 2 * k;
        for (int i = 0; i < 3; i++) {
            f.centre[i] += part * (y[k].moved[i] + y[k].u[i]);
            f.velocity[i] += part * y[k].v[i];
            f.acceleration[i] += part * y[k].a[i];
        }
        add_to(&f.z, r, y[k].moved[1] + y[k].u[1], y[k].moved[2] + y[k].u[2]);
        add_to(&rate, r, y[k].v[1], y[k].v[2]);
        add_to(&rate2, r, y[k].a[1], y[k].a[2]);
        f.sum_theta += y[k].u[3];
        f.sum_theta_rate += y[k].v[3];
    }
    const double square = f.z.re * f.z.re + f.z.im * f.z.im;
    const double phi = arctangent(f.z.im, f.z.re);
    f.rho = sqrt(square);
    f.cosine = f.z.re / f.rho;
    f.sine = f.z.im / f.rho;
    f.phi = phi + 2.0 * PI * nearest((part * f.sum_theta - phi) / (2.0 * PI));
    f.inverse = (complex_number){f.z.re / square, -f.z.im / square};
    f.by_rate = product(rate, f.inverse);
    f.by_rate2 = product(rate2, f.inverse);
    f.phi_rate = f.by_rate.im;
    f.phi_rate2 = f.by_rate2.im - product(f.by_rate, f.by_rate).im;
    return f;
}

/* ---- the string of a yoke ---- */

static bool hangs(const device *d)
{
    return d->constant[LENGTH] > 0.0;
}

static insulator insulator_of(const device *d)
{
    const double *c = d->constant;
    return (insulator){{c[LENGTH], c[STIFFNESS], c[DAMPING]},
                       c[WEIGHT],
                       c[WEIGHT] / d->gravity,
                       {0.0, -c[LENGTH], 0.0}};
}

/* The point at which the frame hangs: h (cos phi, sin phi) from the centre along x2 and x3. */
typedef struct {
    double arm[2], b[2]; /* arm from the centre, b = d arm / d phi; db/dphi = -arm */
    double place[3], velocity[3], acceleration[3];
} suspension;

static insulator_motion suspension_of(const device *d, const frame *f, const device_motion *y,
                                      suspension *at)
{
    const double h = d->constant[HEIGHT], rate = f->phi_rate;
    at->arm[0] = h * f->cosine;
    at->arm[1] = h * f->sine;
    at->b[0] = -at->arm[1];
    at->b[1] = at->arm[0];
    memcpy(at->place, f->centre, sizeof at->place);
    memcpy(at->velocity, f->velocity, sizeof at->velocity);
    memcpy(at->acceleration, f->acceleration, sizeof at->acceleration);
    at->place[1] -= h;
    for (int i = 0; i < 2; i++) {
        at->place[i + 1] += at->arm[i];
        at->velocity[i + 1] += at->b[i] * rate;
        at->acceleration[i + 1] += at->b[i] * f->phi_rate2 - at->arm[i] * rate * rate;
    }
    return (insulator_motion){at->place, at->velocity,      at->acceleration,
                              y->tower,  y->tower_velocity, y->tower_acceleration};
}

/* ---- forces ---- */

/* Force in X, and moment about phi from all but the arms' stiffness. */
static double frame_moment(const device *d, const frame *f, const device_motion *y, double force[3])
{
    const double *c = d->constant;
    const int n = d->junctions;
    double moment = c[ARM_DAMPING] * (c[SQUARES] - 2.0 * f->rho) * f->phi_rate -
                    c[CLAMP_STIFFNESS] * (f->sum_theta - n * f->phi) -
                    c[CLAMP_DAMPING] * (f->sum_theta_rate - n * f->phi_rate);
    for (int i = 0; i < 3; i++) force[i] = 0.0;
    if (!hangs(d)) return moment;
    const insulator s = insulator_of(d);
    suspension at;
    const insulator_motion of = suspension_of(d, f, y, &at);
    device_string_force(&s, &of, force);
    return moment + at.b[0] * force[1] + at.b[1] * force[2];
}

static void add_force(const device *d, const device_motion *y, double force[][4])
{
    const double *c = d->constant, part = 1.0 / d->junctions;
    const frame f = frame_of(d, y);
    double of_centre[3], by_z[2];
    const double moment = frame_moment(d, &f, y, of_centre);
    gradient_of(scaled(moment, f.inverse), by_z);
    by_z[0] -= c[ARM_STIFFNESS] * f.cosine;
    by_z[1] -= c[ARM_STIFFNESS] * f.sine;
    for (int k = 0; k < d->junctions; k++) {
        const double *r = c + OFFSET + 2 * k;
        const double turned[2] = {by_z[0] * r[0] - by_z[1] * r[1], by_z[0] * r[1] + by_z[1] * r[0]};
        for (int i = 0; i < 3; i++) force[k][i] += part * (c[MASS] * y[k].a[i] + of_centre[i]);
        force[k][1] += part * c[MASS] * d->gravity;
        for (int i = 0; i < 2; i++)
            force[k][i + 1] +=
                turned[i] +
                c[ARM_STIFFNESS] * (r[i] + y[k].moved[i + 1] + y[k].u[i + 1] - f.centre[i + 1]) +
                c[ARM_DAMPING] * (y[k].v[i + 1] - f.velocity[i + 1]);
        force[k][3] +=
            c[CLAMP_STIFFNESS] * (y[k].u[3] - f.phi) + c[CLAMP_DAMPING] * (y[k].v[3] - f.phi_rate);
    }
}

/* ---- tangent ---- */

#define X_AND_Z 5 /* rows and columns X1 X2 X3 and the parts of z */

/* Derivatives of phi, phi' and phi'' by the parts of z, weighted: weights.k by z, weights.c by z',
 * weights.m by z''. */
static void phi_slopes(const frame *f, tangent_weights weights, double by_z[3][2])
{
    const complex_number one = f->inverse;
    const complex_number rate = product(f->by_rate, one); /* z'/z^2 */
    const complex_number bend =
        sum(scaled(2.0, product(f->by_rate, rate)), scaled(-1.0, product(f->by_rate2, one)));
    const complex_number slope[3] = {
        scaled(weights.k, one), sum(scaled(-weights.k, rate), scaled(weights.c, one)),
        sum(sum(scaled(weights.k, bend), scaled(-2.0 * weights.c, rate)), scaled(weights.m, one))};
    for (int i = 0; i < 3; i++) gradient_of(slope[i], by_z[i]);
}

/* Derivatives of the moment about phi by phi, phi', phi'' and by rho. */
typedef struct {
    double by_phi[3], by_rho;
} moment_slopes;

/* Adds what the string of a yoke has: to the tangent in X and z, and to the moment's slopes. */
static void add_string_slopes(const device *d, const frame *f, const device_motion *y,
                              tangent_weights weights, double phi[3][2], moment_slopes *moment,
                              double tangent[X_AND_Z][X_AND_Z])
{
    const insulator s = insulator_of(d);
    const double rate = f->phi_rate, third = s.mass / 3.0;
    double k[9], c[9], force[3], normal[2], by_phi[3][3];
    suspension at;
    const insulator_motion of = suspension_of(d, f, y, &at);
    device_string_force(&s, &of, force);
    device_string_slopes(&s, &of, k, c);
    gradient_of(f->inverse, normal);
    for (int i = 0; i < 3; i++) { /* force at P by phi, phi', phi'' */
        const double own_b = i ? at.b[i - 1] : 0.0, own_arm = i ? at.arm[i - 1] : 0.0;
        const double k_b = k[3 * i + 1] * at.b[0] + k[3 * i + 2] * at.b[1];
        const double c_b = c[3 * i + 1] * at.b[0] + c[3 * i + 2] * at.b[1];
        const double c_arm = c[3 * i + 1] * at.arm[0] + c[3 * i + 2] * at.arm[1];
        by_phi[0][i] = k_b - c_arm * rate - third * (own_arm * f->phi_rate2 + own_b * rate * rate);
        by_phi[1][i] = c_b - 2.0 * third * own_arm * rate;
        by_phi[2][i] = third * own_b;
    }
    for (int i = 0; i < 3; i++) {
        double mixed[3], across = 0.0;
        for (int j = 0; j < 3; j++) {
            mixed[j] = weights.k * k[3 * i + j] + weights.c * c[3 * i + j];
            if (i == j) mixed[j] += weights.m * third;
            tangent[i][j] += mixed[j];
        }
        for (int j = 0; j < 2; j++)
            for (int p = 0; p < 3; p++) tangent[i][3 + j] += by_phi[p][i] * phi[p][j];
        for (int j = 0; j < 2; j++) { /* b . (force at P by X) */
            const int row = 3 * (j + 1) + i;
            across += at.b[j] * (weights.k * k[row] + weights.c * c[row] +
                                 (i == j + 1 ? weights.m * third : 0.0));
        }
        for (int j = 0; j < 2; j++) tangent[3 + j][i] += normal[j] * across;
    }
    for (int p = 0; p < 3; p++)
        moment->by_phi[p] += at.b[0] * by_phi[p][1] + at.b[1] * by_phi[p][2];
    moment->by_phi[0] -= at.arm[0] * force[1] + at.arm[1] * force[2];
}

/* The tangent in X and z of all but |p_i|^2, |p_i'|^2 and the mass. */
static void tangent_in_z(const device *d, const frame *f, const device_motion *y,
                         tangent_weights weights, double phi[3][2],
                         double tangent[X_AND_Z][X_AND_Z])
{
    const double *c = d->constant;
    const int n = d->junctions;
    const double along[2] = {f->cosine, f->sine}; /* of rho, by z */
    const complex_number bend = scaled(-1.0, product(f->inverse, f->inverse));
    const double phi_bend[2][2] = {{bend.im, bend.re}, {bend.re, -bend.im}};
    double force[3], normal[2];
    const double moment = frame_moment(d, f, y, force);
    moment_slopes of = {
        .by_phi = {n * c[CLAMP_STIFFNESS],
                   c[ARM_DAMPING] * (c[SQUARES] - 2.0 * f->rho) + n * c[CLAMP_DAMPING], 0.0},
        .by_rho = -2.0 * c[ARM_DAMPING] * f->phi_rate};
    memset(tangent, 0, X_AND_Z * sizeof *tangent);
    if (hangs(d)) add_string_slopes(d, f, y, weights, phi, &of, tangent);
    gradient_of(f->inverse, normal);
    for (int i = 0; i < 2; i++)
        for (int j = 0; j < 2; j++) {
            const double rho_bend = ((i == j) - along[i] * along[j]) / f->rho;
            double by_z = weights.k * of.by_rho * along[j];
            for (int p = 0; p < 3; p++) by_z += of.by_phi[p] * phi[p][j];
            tangent[3 + i][3 + j] += normal[i] * by_z + weights.k * (moment * phi_bend[i][j] -
                                                                     c[ARM_STIFFNESS] * rho_bend);
        }
}

/* X and z by the place of a clamp. */
static void clamp_in_z(const device *d, int k, double by_clamp[X_AND_Z][3])
{
    const double *r = d->constant + OFFSET + 2 * k;
    memset(by_clamp, 0, X_AND_Z * sizeof *by_clamp);
    for (int i = 0; i < 3; i++) by_clamp[i][i] = 1.0 / d->junctions;
    by_clamp[3][1] = by_clamp[4][2] = r[0];
    by_clamp[3][2] = r[1];
    by_clamp[4][1] = -r[1];
}

/* What is not in X and z: of p_i, of the mass, and of the clamps themselves. */
static void add_direct(const device *d, int row, int column, tangent_weights weights, double *block)
{
    const double *c = d->constant, part = 1.0 / d->junctions;
    const double own = row == column ? 1.0 : 0.0;
    const double arm = weights.k * c[ARM_STIFFNESS] + weights.c * c[ARM_DAMPING];
    for (int i = 0; i < 3; i++) {
        block[5 * i] += own * weights.m * part * c[MASS];
        if (i > 0) block[5 * i] += (own - part) * arm;
    }
    block[15] += own * (weights.k * c[CLAMP_STIFFNESS] + weights.c * c[CLAMP_DAMPING]);
}

/* The block of two clamps: their places, and what the turn phi couples. */
static void add_block(double tangent[X_AND_Z][X_AND_Z], const double normal[2],
                      const double turn[2], double row[X_AND_Z][3], double column[X_AND_Z][3],
                      double clamp, double *block)
{
    for (int j = 0; j < 3; j++) {
        double times[X_AND_Z];
        for (int p = 0; p < X_AND_Z; p++) {
            times[p] = 0.0;
            for (int q = 0; q < X_AND_Z; q++) times[p] += tangent[p][q] * column[q][j];
        }
        for (int i = 0; i < 3; i++)
            for (int p = 0; p < X_AND_Z; p++) block[4 * i + j] += row[p][i] * times[p];
        block[12 + j] -= turn[0] * column[3][j] + turn[1] * column[4][j];
    }
    for (int i = 0; i < 3; i++)
        block[4 * i + 3] -= clamp * (normal[0] * row[3][i] + normal[1] * row[4][i]);
}

static void add_tangent(const device *d, const device_motion *y, tangent_weights weights,
                        device_block *tangent)
{
    const double *c = d->constant;
    const int n = d->junctions;
    const frame f = frame_of(d, y);
    const double clamp = weights.k * c[CLAMP_STIFFNESS] + weights.c * c[CLAMP_DAMPING];
    double phi[3][2], in_z[X_AND_Z][X_AND_Z], by_clamp[MOST][X_AND_Z][3], normal[2], turn[2];
    phi_slopes(&f, weights, phi);
    tangent_in_z(d, &f, y, weights, phi, in_z);
    gradient_of(f.inverse, normal);
    for (int i = 0; i < 2; i++) /* moment of a clamp on the frame, by z */
        turn[i] = c[CLAMP_STIFFNESS] * phi[0][i] + c[CLAMP_DAMPING] * phi[1][i];
    for (int k = 0; k < n; k++) clamp_in_z(d, k, by_clamp[k]);
    for (int row = 0; row < n; row++)
        for (int column = 0; column < n; column++) {
            double *block = tangent[n * row + column];
            add_direct(d, row, column, weights, block);
            add_block(in_z, normal, turn, by_clamp[row], by_clamp[column], clamp, block);
        }
}

/* ---- energy, observation ---- */

static void add_energy(const device *d, const device_motion *y, double *kinetic, double *potential)
{
    const double *c = d->constant, part = 1.0 / d->junctions;
    const frame f = frame_of(d, y);
    for (int k = 0; k < d->junctions; k++) {
        const double *r = c + OFFSET + 2 * k;
        const double twist = y[k].u[3] - f.phi;
        double apart[2] = {r[0] - (f.cosine * r[0] - f.sine * r[1]),
                           r[1] - (f.sine * r[0] + f.cosine * r[1])};
        for (int i = 0; i < 2; i++) apart[i] += y[k].moved[i + 1] + y[k].u[i + 1] - f.centre[i + 1];
        for (int i = 0; i < 3; i++) *kinetic += 0.5 * part * c[MASS] * y[k].v[i] * y[k].v[i];
        *potential += 0.5 * c[ARM_STIFFNESS] * (apart[0] * apart[0] + apart[1] * apart[1]) +
                      0.5 * c[CLAMP_STIFFNESS] * twist * twist;
    }
    *potential += c[MASS] * d->gravity * f.centre[1];
    if (!hangs(d)) return;
    const insulator s = insulator_of(d);
    suspension at;
    const insulator_motion of = suspension_of(d, &f, y, &at);
    device_string_add_energy(&s, &of, kinetic, potential);
}

static void on_tower(const device *d, const device_motion *y, double force[3])
{
    const frame f = frame_of(d, y);
    const insulator s = insulator_of(d);
    suspension at;
    const insulator_motion of = suspension_of(d, &f, y, &at);
    for (int i = 0; i < 3; i++) force[i] = 0.0;
    device_string_add_on_tower(&s, &of, force);
}

static double observe(const device *d, const device_motion *y, int channel)
{
    const frame f = frame_of(d, y);
    if (channel == GALLOP_TURN) return f.phi;
    if (!hangs(d)) return 0.0;
    const insulator s = insulator_of(d);
    suspension at;
    double r[3];
    const insulator_motion of = suspension_of(d, &f, y, &at);
    if (channel == GALLOP_PULL) return device_string_pull(&s, &of);
    device_string_vector(&s, &of, r);
    return device_string_lean(r, channel);
}

/* ---- spacer and yoke ---- */

static const device_parameter parameters[] = {
    {"mass of a frame", false},
    {"stiffness of an arm of a frame", true},
    {"damping of an arm of a frame", false},
    {"torsional stiffness of a clamp of a frame", false},
    {"torsional damping of a clamp of a frame", false},
    {"length of a string", true},
    {"weight of a string", false},
    {"stiffness of a string", true},
    {"damping of a string", false},
};

static int frame_check(const gallop_device *d, gallop_report *report)
{
    return device_check_parameters(d, parameters, 5, report);
}

static int yoke_check(const gallop_device *d, gallop_report *report)
{
    return device_check_parameters(d, parameters, 9, report);
}

static void frame_prepare(const gallop_model *model, const gallop_device *from, device *d)
{
    double *c = d->constant, centre[2] = {0.0, 0.0};
    memcpy(c + MASS, from->parameter, 5 * sizeof(double));
    for (int k = 0; k < d->junctions; k++)
        for (int i = 0; i < 2; i++)
            centre[i] += model->junction[d->junction[k]].position[i + 1] / d->junctions;
    c[SQUARES] = 0.0;
    for (int k = 0; k < d->junctions; k++)
        for (int i = 0; i < 2; i++) {
            double *r = c + OFFSET + 2 * k + i;
            *r = model->junction[d->junction[k]].position[i + 1] - centre[i];
            c[SQUARES] += *r * *r;
        }
    c[LENGTH] = 0.0;
}

static void yoke_prepare(const gallop_model *model, const gallop_device *from, device *d)
{
    frame_prepare(model, from, d);
    memcpy(d->constant + LENGTH, from->parameter + 5, 4 * sizeof(double));
    d->constant[HEIGHT] = from->parameter[9];
    d->reach = from->parameter[5];
}

const device_kind device_frame = {
    .name = "frame",
    .least = 2,
    .most = MOST,
    .leaves_plane = true,
    .check = frame_check,
    .prepare = frame_prepare,
    .add_force = add_force,
    .add_tangent = add_tangent,
    .add_energy = add_energy,
    .observe = observe,
};

const device_kind device_yoke = {
    .name = "yoke",
    .least = 2,
    .most = MOST,
    .leaves_plane = true,
    .holds = true,
    .check = yoke_check,
    .prepare = yoke_prepare,
    .add_force = add_force,
    .add_tangent = add_tangent,
    .add_energy = add_energy,
    .on_tower = on_tower,
    .observe = observe,
};
