/* Three-node cable element with twist and eccentric ice (Liu et al. 2009, eq. 5-18), updated Lagrangian: everything is
 * evaluated on the current configuration x = X + u; the tension carries the total axial Green strain from the initial
 * equilibrium, so it cannot drift. */
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

typedef struct { double theta, omega, omega_rate, v2, v3, a2, a3; } section;

static inline section section_at(int q, const double *u, const double *v, const double *a)
{
    const double *n = shape3[q];
#define MIX(y, i) (n[0] * (y)[i] + n[1] * (y)[4 + (i)] + n[2] * (y)[8 + (i)])
    return (section){MIX(u, 3), MIX(v, 3), MIX(a, 3), MIX(v, 1), MIX(v, 2), MIX(a, 1), MIX(a, 2)};
#undef MIX
}

void watch_start(watch *seen)
{
    *seen = (watch){INFINITY, 0.0, 0.0, -1, -1};
}

static void section_residual(const gallop_model *model, int e, const instant *now, const double *u, const double *v,
                             const double *a, double r[12], watch *seen)
{
    const geometry *g = &model->geometry[e];
    const bool windy = model->aerodynamic && now->wind != 0.0;
    for (int q = 0; q < 3; q++) {
        section s = section_at(q, u, v, a);
        double f[3] = {0.0, 0.0, 0.0};
        if (model->eccentric) {
            /* first mass moments turn with the section; the omega^2 terms, missing in the paper, conserve energy */
            double sine = sin(s.theta), cosine = cos(s.theta), w2 = s.omega * s.omega;
            double c2 = model->c2 * cosine - model->c3 * sine, c3 = model->c2 * sine + model->c3 * cosine;
            f[0] = -c3 * s.omega_rate - c2 * w2;
            f[1] = c2 * s.omega_rate - c3 * w2;
            f[2] = -c3 * s.a2 + c2 * s.a3 - model->scene.gravity * (c3 - model->c3);
        }
        if (windy) {
            air_load load;
            double excess, angle;
            aero_load(model, now, s.theta, s.v2, s.v3, s.omega, false, &load, &excess, &angle);
            for (int i = 0; i < 3; i++) f[i] -= load.force[i];
            if (excess > seen->worst_excess) {
                seen->worst_excess = excess;
                seen->worst_angle = angle;
                seen->angle_element = e;
            }
        }
        for (int n = 0; n < 3; n++) {
            double w = g->inertia_weight[q] * shape3[q][n];
            for (int i = 0; i < 3; i++) r[4 * n + 1 + i] += w * f[i];
        }
    }
}

void element_residual(const gallop_model *model, int e, const instant *now, const double u[12], const double v[12],
                      const double a[12], double r[12], watch *seen)
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
    if (model->eccentric || (model->aerodynamic && now->wind != 0.0)) section_residual(model, e, now, u, v, a, r, seen);
}

/* Rows f2, f3, moment; columns 2, 3, theta of k dR/du + c dR/dv + m dR/da at one section. */
static void section_tangent(const gallop_model *model, const instant *now, const section *s, blend mix, double g[3][3])
{
    memset(g, 0, 9 * sizeof(double));
    if (model->eccentric) {
        double sine = sin(s->theta), cosine = cos(s->theta), w = s->omega;
        double c2 = model->c2 * cosine - model->c3 * sine, c3 = model->c2 * sine + model->c3 * cosine;
        g[0][2] += mix.k * (-c2 * s->omega_rate + c3 * w * w) - mix.c * 2.0 * c2 * w - mix.m * c3;
        g[1][2] += mix.k * (-c3 * s->omega_rate - c2 * w * w) - mix.c * 2.0 * c3 * w + mix.m * c2;
        g[2][2] += mix.k * (-c2 * s->a2 - c3 * s->a3 - model->scene.gravity * c2);
        g[2][0] -= mix.m * c3;
        g[2][1] += mix.m * c2;
    }
    if (model->aerodynamic && now->wind != 0.0) {
        air_load load;
        double excess, angle, radius = model->scene.reference_radius;
        aero_load(model, now, s->theta, s->v2, s->v3, s->omega, true, &load, &excess, &angle);
        for (int i = 0; i < 3; i++) {
            g[i][0] -= mix.c * load.by_v2[i];
            g[i][1] -= mix.c * load.by_v3[i];
            g[i][2] -= mix.k * load.by_theta[i] + mix.c * radius * load.by_v2[i];
        }
    }
}

/* tangent[3 n + m]: the 4 x 4 block of node n by node m (paper eq. 11, 14, 18 and the aerodynamic terms). */
void element_tangent(const gallop_model *model, int e, const instant *now, const double u[12], const double v[12],
                     const double a[12], blend mix, double tangent[9][16])
{
    const geometry *g = &model->geometry[e];
    const double ea = model->scene.axial_stiffness, gj = model->scene.torsional_stiffness;
    const double *b = model->derived.translation_damping, *bt = model->derived.twist_damping;
    const double translation = model->mass * (mix.m + mix.c * b[0]), twist = model->inertia * (mix.m + mix.c * bt[0]);

    for (int n = 0; n < 3; n++)
        for (int m = 0; m < 3; m++) {
            double *block = tangent[3 * n + m], w = g->shape_product[n][m];
            memset(block, 0, 16 * sizeof(double));
            block[0] = block[5] = block[10] = w * translation;
            block[15] = w * twist;
        }
    for (int q = 0; q < 2; q++) {
        double du[4], s[16] = {0.0};
        slope_of(g->shape_slope[q], u, du);
        double tension = tension_of(g, q, ea, du), damping = mix.c * b[1];
        for (int i = 0; i < 3; i++) {
            double p = g->slope[q][i] + du[i];
            for (int j = 0; j < 3; j++)
                s[4 * i + j] = ea * (mix.k * p * (g->slope[q][j] + du[j]) + damping * g->slope[q][i] * g->slope[q][j]);
            s[5 * i] += mix.k * tension + damping * g->tension[q];
        }
        s[15] = gj * (mix.k + mix.c * bt[1]);
        for (int n = 0; n < 3; n++)
            for (int m = 0; m < 3; m++) {
                double w = g->stiffness_weight[q] * g->shape_slope[q][n] * g->shape_slope[q][m];
                double *block = tangent[3 * n + m];
                for (int i = 0; i < 16; i++) block[i] += w * s[i];
            }
    }
    if (!model->eccentric && !(model->aerodynamic && now->wind != 0.0)) return;
    for (int q = 0; q < 3; q++) {
        section s = section_at(q, u, v, a);
        double part[3][3];
        section_tangent(model, now, &s, mix, part);
        for (int n = 0; n < 3; n++)
            for (int m = 0; m < 3; m++) {
                double w = g->inertia_weight[q] * shape3[q][n] * shape3[q][m];
                double *block = tangent[3 * n + m];
                for (int i = 0; i < 3; i++)
                    for (int j = 0; j < 3; j++) block[4 * (i + 1) + j + 1] += w * part[i][j];
            }
    }
}

/* Out-of-balance forces of the free body: internal + inertia + damping - aerodynamics - loads - constant forces. */
void span_residual(const gallop_model *model, double t, const instant *now, const double *u, const double *v,
                   const double *a, double *residual, watch *seen)
{
    const int values = 4 * model->nodes;
    for (int i = 0; i < values; i++) residual[i] = -model->constant_force[i];
    for (int e = 0; e < model->elements; e++) {
        double r[12];
        element_residual(model, e, now, u + 8 * e, v + 8 * e, a + 8 * e, r, seen);
        for (int i = 0; i < 12; i++) residual[8 * e + i] += r[i];
    }
    for (int l = 0; l < model->scene.load_count; l++) {
        const gallop_load *load = &model->scene.load[l];
        const load_place *place = &model->place[l];
        double amplitude = now->load_factor * law_value(&load->law, t);
        if (amplitude == 0.0) continue;
        for (int n = 0; n < 3; n++) {
            double *r = residual + 8 * place->element + 4 * n, w = amplitude * place->shape[n];
            for (int i = 0; i < 3; i++) r[i] -= w * load->force[i];
            r[3] -= w * load->torque;
        }
    }
}
