/* Three-node cable element with twist and eccentric ice (Liu et al. 2009, eq. 5-18), updated Lagrangian: everything is
 * evaluated on the current configuration x = X + u; the tension carries the total axial Green strain from the initial
 * equilibrium, so it cannot drift. */
#include "elementary.h"
#include "internal.h"

#define ROOT_3_5 0.77459666924148337704
#define ROOT_1_3 0.57735026918962576451

const double gauss2[2] = {-ROOT_1_3, ROOT_1_3};
static const double gauss3[3] = {-ROOT_3_5, 0.0, ROOT_3_5};
static const double gauss3_weight[3] = {5.0 / 9.0, 8.0 / 9.0, 5.0 / 9.0};

/* N = (xi (xi - 1) / 2, 1 - xi^2, xi (xi + 1) / 2), paper eq. (5), at the three-point Gauss abscissae */
const double shape3[3][3] = {{0.5 * (0.6 + ROOT_3_5), 0.4, 0.5 * (0.6 - ROOT_3_5)},
                             {0.0, 1.0, 0.0},
                             {0.5 * (0.6 - ROOT_3_5), 0.4, 0.5 * (0.6 + ROOT_3_5)}};

static double tangent_at(const double x[9], double xi, double shape_slope[3], double direction[3])
{
    const double slope[3] = {xi - 0.5, -2.0 * xi, xi + 0.5};
    double square = 0.0;
    for (int i = 0; i < 3; i++) {
        direction[i] = slope[0] * x[i] + slope[1] * x[3 + i] + slope[2] * x[6 + i];
        square += direction[i] * direction[i];
    }
    double stretch = sqrt(square);   /* dS/dxi */
    for (int i = 0; i < 3; i++) {
        shape_slope[i] = slope[i] / stretch;
        direction[i] /= stretch;
    }
    return stretch;
}

void geometry_from_nodes(geometry *g, const double x[9], const double tension[2])
{
    double slope[3], direction[3];
    for (int q = 0; q < 2; q++) {
        g->stiffness_weight[q] = tangent_at(x, gauss2[q], g->shape_slope[q], g->slope[q]);
        g->tension[q] = tension[q];
    }
    memset(g->shape_product, 0, sizeof g->shape_product);
    for (int q = 0; q < 3; q++) {
        double w = gauss3_weight[q] * tangent_at(x, gauss3[q], slope, direction);
        g->inertia_weight[q] = w;
        for (int a = 0; a < 3; a++)
            for (int b = 0; b < 3; b++) g->shape_product[a][b] += w * shape3[q][a] * shape3[q][b];
    }
}

static inline void slope_of(const double n[3], const double u[12], double out[4])
{
    for (int i = 0; i < 4; i++) out[i] = n[0] * u[i] + n[1] * u[4 + i] + n[2] * u[8 + i];
}

/* Green strain from the initial equilibrium: eps = X'.u' + u'.u'/2; T = T0 + EA eps */
static inline double tension_of(const geometry *g, int q, double axial_stiffness, const double du[4])
{
    double strain = 0.0;
    for (int i = 0; i < 3; i++) strain += du[i] * (g->slope[q][i] + 0.5 * du[i]);
    return g->tension[q] + axial_stiffness * strain;
}

void element_tension(const gallop_model *model, int e, const double u[12], double tension[2])
{
    const geometry *g = &model->geometry[e];
    for (int q = 0; q < 2; q++) {
        double du[4], square = 0.0;
        slope_of(g->shape_slope[q], u, du);
        for (int i = 0; i < 3; i++) square += (g->slope[q][i] + du[i]) * (g->slope[q][i] + du[i]);
        /* T acts on p, whose length is the stretch: the force in the cable is T |p| */
        tension[q] = tension_of(g, q, model->scene.axial_stiffness, du) * sqrt(square);
    }
}

void watch_start(watch *seen)
{
    *seen = (watch){INFINITY, 0.0, 0.0, -1, -1};
}

TWO_PATHS static void gather(const double *u, const double *v, const double *a, const sections *at, int first, int count)
{
    for (int e = first; e < first + count; e++)
        for (int q = 0; q < 3; q++) {
            const double *n = shape3[q];
            const int i = 3 * e + q, k = 8 * e;
#define MIX(y, dof) (n[0] * (y)[k + (dof)] + n[1] * (y)[k + 4 + (dof)] + n[2] * (y)[k + 8 + (dof)])
            at->theta[i] = MIX(u, 3);
            at->omega[i] = MIX(v, 3);
            at->omega_rate[i] = MIX(a, 3);
            at->v2[i] = MIX(v, 1);
            at->v3[i] = MIX(v, 2);
            at->a2[i] = MIX(a, 1);
            at->a3[i] = MIX(a, 2);
#undef MIX
        }
}

/* First mass moments turn with the section; the omega^2 terms, missing in the paper, conserve energy. */
TWO_PATHS static void ice_inertia(const gallop_model *model, const sections *at, int first, int last)
{
    const double m2 = model->c2, m3 = model->c3, gravity = model->scene.gravity;
    const double *theta = at->theta, *omega = at->omega, *omega_rate = at->omega_rate;
    const double *a2 = at->a2, *a3 = at->a3;
    double *c2 = at->c2, *c3 = at->c3;
    double *f2 = at->force[0], *f3 = at->force[1], *twist = at->force[2];
    INDEPENDENT
    for (int i = first; i < last; i++) {
        double sine, cosine, square = omega[i] * omega[i];
        sine_cosine(theta[i], &sine, &cosine);
        c2[i] = m2 * cosine - m3 * sine;
        c3[i] = m2 * sine + m3 * cosine;
        f2[i] = -c3[i] * omega_rate[i] - c2[i] * square;
        f3[i] = c2[i] * omega_rate[i] - c3[i] * square;
        twist[i] = c2[i] * a3[i] - c3[i] * a2[i] - gravity * (c3[i] - m3);
    }
}

/* Forces at the sections of `count` elements from `first`: inertia of the eccentric ice minus aerodynamics. */
void evaluate_sections(const gallop_model *model, const instant *now, const double *u, const double *v, const double *a,
                       const sections *at, int first, int count, bool slopes)
{
    const bool wind = windy(model, now);
    if (!model->eccentric && !wind) return;
    gather(u, v, a, at, first, count);
    if (model->eccentric) {
        ice_inertia(model, at, 3 * first, 3 * (first + count));
    } else {
        for (int i = 0; i < 3; i++) memset(at->force[i] + 3 * first, 0, 3 * (size_t)count * sizeof(double));
    }
    if (wind) aero_loads(model, now, at, 3 * first, 3 * count, slopes);
}

/* `at` holds the section forces of the same motion (evaluate_sections). */
TWO_PATHS void element_residual(const gallop_model *model, int e, const instant *now, const sections *at, const double u[12],
                      const double v[12], const double a[12], double r[12], watch *seen)
{
    const geometry *g = &model->geometry[e];
    const double ea = model->scene.axial_stiffness, gj = model->scene.torsional_stiffness;
    const double *b = model->derived.translation_damping, *bt = model->derived.twist_damping;
    const double mass[4] = {model->mass, model->mass, model->mass, model->inertia};
    const double drag[4] = {b[0], b[0], b[0], bt[0]};

    double rate[12];
    for (int n = 0; n < 3; n++)
        for (int i = 0; i < 4; i++) rate[4 * n + i] = mass[i] * (a[4 * n + i] + drag[i] * v[4 * n + i]);
    for (int n = 0; n < 3; n++) {
        const double *m = g->shape_product[n];
        for (int i = 0; i < 4; i++) r[4 * n + i] = m[0] * rate[i] + m[1] * rate[4 + i] + m[2] * rate[8 + i];
    }
    for (int q = 0; q < 2; q++) {
        double du[4], dv[4], s[4];
        slope_of(g->shape_slope[q], u, du);
        slope_of(g->shape_slope[q], v, dv);
        double tension = tension_of(g, q, ea, du);
        double axial = b[1] * ea * (g->slope[q][0] * dv[0] + g->slope[q][1] * dv[1] + g->slope[q][2] * dv[2]);
        double lateral = b[1] * g->tension[q];
        for (int i = 0; i < 3; i++)
            s[i] = tension * (g->slope[q][i] + du[i]) + axial * g->slope[q][i] + lateral * dv[i];
        s[3] = gj * (du[3] + bt[1] * dv[3]);
        for (int n = 0; n < 3; n++) {
            double w = g->stiffness_weight[q] * g->shape_slope[q][n];
            for (int i = 0; i < 4; i++) r[4 * n + i] += w * s[i];
        }
        if (tension < seen->lowest_tension) {
            seen->lowest_tension = tension;
            seen->slack_element = e;
        }
    }
    const bool wind = windy(model, now);
    if (!model->eccentric && !wind) return;
    for (int q = 0; q < 3; q++) {
        const int i = 3 * e + q;
        for (int n = 0; n < 3; n++) {
            double w = g->inertia_weight[q] * shape3[q][n];
            for (int k = 0; k < 3; k++) r[4 * n + 1 + k] += w * at->force[k][i];
        }
        if (wind && at->excess[i] > seen->worst_excess) {
            seen->worst_excess = at->excess[i];
            seen->worst_angle = at->angle[i];
            seen->angle_element = e;
        }
    }
}

/* Rows f2, f3, moment; columns 2, 3, theta of k dR/du + c dR/dv + m dR/da at section i, added to a 4 x 4 block. */
static void section_tangent(const gallop_model *model, const sections *at, int i, bool wind, blend mix, double g[16])
{
    if (model->eccentric) {
        const double c2 = at->c2[i], c3 = at->c3[i], w = at->omega[i], rate = at->omega_rate[i];
        g[7] = mix.k * (-c2 * rate + c3 * w * w) - mix.c * 2.0 * c2 * w - mix.m * c3;
        g[11] = mix.k * (-c3 * rate - c2 * w * w) - mix.c * 2.0 * c3 * w + mix.m * c2;
        g[15] = mix.k * (-c2 * at->a2[i] - c3 * at->a3[i] - model->scene.gravity * c2);
        g[13] = -mix.m * c3;
        g[14] = mix.m * c2;
    }
    if (!wind) return;
    for (int k = 0; k < 3; k++) {
        double *row = g + 4 * (k + 1);
        row[1] -= mix.c * at->by_v2[k][i];
        row[2] -= mix.c * at->by_v3[k][i];
        row[3] -= mix.k * at->by_theta[k][i] + mix.c * model->radius * at->by_v2[k][i];
    }
}

/* tangent: the 4 x 4 blocks left-left, left-middle, ... (paper eq. 11, 14, 18 and the aerodynamic terms); `at` holds the
 * section forces of the same motion with their slopes. */
TWO_PATHS void element_tangent(const gallop_model *model, int e, const instant *now, const sections *at, const double u[12],
                     blend mix, double tangent[6][16])
{
    static const int pair[6][2] = {{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}};
    const geometry *g = &model->geometry[e];
    const double ea = model->scene.axial_stiffness, gj = model->scene.torsional_stiffness;
    const double *b = model->derived.translation_damping, *bt = model->derived.twist_damping;
    const double translation = model->mass * (mix.m + mix.c * b[0]), twist = model->inertia * (mix.m + mix.c * bt[0]);

    double part[5][16];   /* at two stiffness points and three sections */
    memset(part, 0, sizeof part);
    for (int q = 0; q < 2; q++) {
        double du[4], now_slope[3], *s = part[q], damping = mix.c * b[1];
        slope_of(g->shape_slope[q], u, du);
        double tension = tension_of(g, q, ea, du), geometric = mix.k * tension + damping * g->tension[q];
        for (int i = 0; i < 3; i++) now_slope[i] = g->slope[q][i] + du[i];
        for (int i = 0; i < 3; i++) {
            for (int j = 0; j < 3; j++)
                s[4 * i + j] = ea * (mix.k * now_slope[i] * now_slope[j] + damping * g->slope[q][i] * g->slope[q][j]);
            s[5 * i] += geometric;
        }
        s[15] = gj * (mix.k + mix.c * bt[1]);
    }
    const bool wind = windy(model, now), sectional = model->eccentric || wind;
    for (int q = 0; q < 3 && sectional; q++) section_tangent(model, at, 3 * e + q, wind, mix, part[2 + q]);
    for (int p = 0; p < 6; p++) {
        const int n = pair[p][0], m = pair[p][1];
        double *block = tangent[p], w[5], mass = g->shape_product[n][m];
        for (int q = 0; q < 2; q++) w[q] = g->stiffness_weight[q] * g->shape_slope[q][n] * g->shape_slope[q][m];
        for (int q = 0; q < 3; q++) w[2 + q] = g->inertia_weight[q] * shape3[q][n] * shape3[q][m];
        for (int i = 0; i < 16; i++) block[i] = w[0] * part[0][i] + w[1] * part[1][i];
        for (int i = 0; i < 16 && sectional; i++) block[i] += w[2] * part[2][i] + w[3] * part[3][i] + w[4] * part[4][i];
        for (int i = 0; i < 3; i++) block[5 * i] += mass * translation;
        block[15] += mass * twist;
    }
}

/* Out-of-balance forces of the free body: internal + inertia + damping - aerodynamics - loads - constant forces. */
void span_residual(const gallop_model *model, double t, const instant *now, const sections *at, const double *u,
                   const double *v, const double *a, bool slopes, double *residual, watch *seen)
{
    const int values = 4 * model->nodes;
    evaluate_sections(model, now, u, v, a, at, 0, model->elements, slopes);
    for (int i = 0; i < values; i++) residual[i] = -model->constant_force[i];
    for (int e = 0; e < model->elements; e++) {
        double r[12];
        element_residual(model, e, now, at, u + 8 * e, v + 8 * e, a + 8 * e, r, seen);
        for (int i = 0; i < 12; i++) residual[8 * e + i] += r[i];
    }
    for (int l = 0; l < model->load_count; l++) {
        const load_place *place = &model->place[l];
        const gallop_load *load = &model->scene.load[place->load];
        double amplitude = now->load_factor * law_value(&load->law, t);
        if (amplitude == 0.0) continue;
        for (int n = 0; n < 3; n++) {
            double *r = residual + 8 * place->element + 4 * n, w = amplitude * place->shape[n];
            for (int i = 0; i < 3; i++) r[i] -= w * load->force[i];
            r[3] -= w * load->torque;
        }
    }
}
