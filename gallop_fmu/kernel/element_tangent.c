/* Tangent of the element (Liu et al. 2009, eq. 11, 14, 18, and the aerodynamic terms), LANES
 * elements at once. */
#include "element.h"

/* Rows f2, f3, moment; columns n2, n3, theta of k dR/du + c dR/dv + m dR/da at the sections `i` to
 * i + LANES - 1. */
INLINE void section_tangent(const chain *c, const sections *at, int i, const exposure *now,
                            tangent_weights mix, lanes g[3][3])
{
#define AT(array) (*(const lanes *)(at->array + i))
    for (int row = 0; row < 3; row++)
        for (int column = 0; column < 3; column++) g[row][column] = (lanes){0.0};
    if (c->section->eccentric) {
        const lanes c2 = AT(c2), c3 = AT(c3), w = AT(omega), rate = AT(omega_rate);
        g[0][2] = mix.k * (c3 * w * w - c2 * rate) - mix.c * 2.0 * c2 * w - mix.m * c3;
        g[1][2] = -mix.k * (c3 * rate + c2 * w * w) - mix.c * 2.0 * c3 * w + mix.m * c2;
        g[2][2] = -mix.k * (c2 * AT(a2) + c3 * AT(a3) + AT(gravity) * c2);
        g[2][0] = -mix.m * c3;
        g[2][1] = mix.m * c2;
    }
    for (int k = 0; k < 3 && now->blows; k++) {
        g[k][0] -= mix.c * AT(by_v2[k]);
        g[k][1] -= mix.c * AT(by_v3[k]);
        g[k][2] -= mix.k * AT(by_theta[k]) + mix.c * c->section->radius * AT(by_v2[k]);
    }
#undef AT
}

/* Rows and columns n2, n3, theta become u1, u2, u3, theta: n2 has parts along x1 and x2. */
INLINE void turn_to_axes(const lanes normal[2], lanes g[3][3], lanes along[4][4])
{
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            along[i][j] = g[i < 2 ? 0 : i - 1][j < 2 ? 0 : j - 1];
            if (i < 2) along[i][j] *= normal[i];
            if (j < 2) along[i][j] *= normal[j];
        }
}

/* Adds the eccentric ice and the wind at the sections from `first` on to the blocks. */
INLINE void add_sections(const chain *c, const strip *s, const sections *at, int first,
                         const exposure *now, tangent_weights mix, lanes block[6][16])
{
    for (int q = 0; q < 3; q++) {
        lanes g[3][3], along[4][4];
        section_tangent(c, at, first + LANES * q, now, mix, g);
        turn_to_axes(s->normal[q], g, along);
        for (int n = 0, p = 0; n < 3; n++)
            for (int m = n; m < 3; m++, p++) {
                if (q == 1 && p != MIDDLE_MIDDLE)
                    continue; /* the second section lies at the middle node */
                const lanes w = s->share[q][n] * element_shape3[q][m];
                for (int i = 0; i < 4; i++)
                    for (int j = 0; j < 4; j++) block[p][4 * i + j] += w * along[i][j];
            }
    }
}

/* Blocks of `unknowns` rows and columns. */
INLINE void tangent_of(const chain *c, const strip *s, const sections *at, int first,
                       const exposure *now, lanes u[3][4], tangent_weights mix, int unknowns,
                       lanes block[6][16])
{
    const double ea = c->section->axial_stiffness, gj = c->section->torsional_stiffness;
    const double *b = c->section->translation_damping, *bt = c->section->twist_damping;
    const double translation = c->section->mass * (mix.m + mix.c * b[0]),
                 twist = c->section->inertia * (mix.m + mix.c * bt[0]);
    const double damping = mix.c * b[1], damping_axial = ea * damping;
    const int axes = unknowns < 3 ? unknowns : 3, size = unknowns * unknowns;
    for (int p = 0; p < 6; p++)
        for (int i = 0; i < size; i++) block[p][i] = (lanes){0.0};
    for (int q = 0; q < 2; q++) {
        const lanes *n = s->shape_slope[q], *p0 = s->slope[q];
        lanes du[3], p[3], strain = {0.0};
        for (int i = 0; i < axes; i++) {
            du[i] = n[0] * (u[0][i] - u[1][i]) + n[1] * (u[2][i] - u[1][i]);
            p[i] = p0[i] + du[i];
            strain += du[i] * (p0[i] + 0.5 * du[i]);
        }
        lanes tension = s->tension[q] + ea * strain, axial = (lanes){0.0} + ea * mix.k;
        if (now->tension_only) {
            axial = PICK(tension > 0.0, axial, (lanes){0.0});
            tension = PICK(tension > 0.0, tension, (lanes){0.0});
        }
        const lanes geometric = mix.k * tension + damping * s->tension[q];
        const lanes left = s->pull[q][0] * n[0], across = s->pull[q][0] * n[1],
                    right = s->pull[q][1] * n[1];
        for (int i = 0; i < unknowns; i++)
            for (int j = i; j < (i < 3 ? axes : 4); j++) {
                lanes k = {0.0};
                if (i < 3) k = axial * (p[i] * p[j]) + damping_axial * (p0[i] * p0[j]);
                if (i < 3 && i == j) k += geometric;
                if (i == 3) k += gj * (mix.k + mix.c * bt[1]);
                block[LEFT_LEFT][unknowns * i + j] += left * k;
                block[LEFT_RIGHT][unknowns * i + j] += across * k;
                block[RIGHT_RIGHT][unknowns * i + j] += right * k;
            }
    }
    /* the slopes of the three shape functions add up to nothing */
    for (int i = 0; i < unknowns; i++)
        for (int j = i; j < unknowns; j++) {
            const int upper = unknowns * i + j, lower = unknowns * j + i;
            block[LEFT_MIDDLE][upper] = -(block[LEFT_LEFT][upper] + block[LEFT_RIGHT][upper]);
            block[MIDDLE_RIGHT][upper] = -(block[LEFT_RIGHT][upper] + block[RIGHT_RIGHT][upper]);
            block[MIDDLE_MIDDLE][upper] = -(block[LEFT_MIDDLE][upper] + block[MIDDLE_RIGHT][upper]);
            for (int k = 0; k < 6; k++) block[k][lower] = block[k][upper];
        }
    for (int k = 0; k < 6; k++)
        for (int i = 0; i < unknowns; i++)
            block[k][unknowns * i + i] += s->product[k] * (i < 3 ? translation : twist);
    if (unknowns == 4 && (c->section->eccentric || now->blows))
        add_sections(c, s, at, first, now, mix, block);
}

#define STRIP_OF(unknowns)                                                                         \
    TWO_PATHS static void strip_of_##unknowns(const chain *c, const strip *s, const sections *at,  \
                                              int first, const exposure *now, const double *u,     \
                                              int count, tangent_weights mix, lanes block[6][16])  \
    {                                                                                              \
        lanes nodes[3][4];                                                                         \
        for (int n = 0; n < 3; n++) read_nodes(u, n, count, nodes[n]);                             \
        tangent_of(c, s, at, first, now, nodes, mix, unknowns, block);                             \
    }
STRIP_OF(2)
STRIP_OF(4)

/* The blocks of a strip, as many rows and columns each as the model has unknowns at a node; `at`
 * holds the section forces, with slopes, of the motion whose displacements along the span are u. */
void element_strip_tangent(const chain *c, int index, const exposure *now, const sections *at,
                           const double *u, tangent_weights mix, lanes block[6][16])
{
    const strip *s = &c->strip[index];
    const int e = LANES * index, count = c->elements - e,
              first = 3 * LANES * (c->first_strip + index);
    if (now->unknowns == 2)
        strip_of_2(c, s, at, first, now, u + 8 * e, count, mix, block);
    else
        strip_of_4(c, s, at, first, now, u + 8 * e, count, mix, block);
}

/* tangent: the 4 x 4 blocks left-left, left-middle, ... of one element, of all unknowns; u are its
 * own displacements. */
void element_tangent(const chain *c, int e, const exposure *now, const sections *at,
                     const double u[12], tangent_weights mix, double tangent[6][16])
{
    lanes block[6][16];
    strip_of_4(c, &c->strip[e / LANES], at, 3 * LANES * (c->first_strip + e / LANES), now, u, 1,
               mix, block);
    for (int p = 0; p < 6; p++)
        for (int i = 0; i < 16; i++) tangent[p][i] = LANE(block[p][i], e % LANES);
}
