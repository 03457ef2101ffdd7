/* Tangent of the element (Liu et al. 2009, eq. 11, 14, 18, and the aerodynamic terms), LANES
 * elements at once. */
#include "element.h"

/* Rows f2, f3, moment; columns n2, n3, theta of k dR/du + c dR/dv + m dR/da at the sections `i` to
 * i + LANES - 1. */
INLINE void section_tangent(const sections *at, int i, const exposure *now, tangent_weights mix,
                            lanes g[3][3])
{
#define AT(array) (*(const lanes *)(at->array + i))
    for (int row = 0; row < 3; row++)
        for (int column = 0; column < 3; column++) g[row][column] = (lanes){0.0};
    if (now->section->eccentric) {
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
        g[k][2] -= mix.k * AT(by_theta[k]) + mix.c * now->section->radius * AT(by_v2[k]);
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
INLINE void add_sections(const strip *s, const sections *at, int first, const exposure *now,
                         tangent_weights mix, lanes block[6][16])
{
    for (int q = 0; q < 3; q++) {
        lanes g[3][3], along[4][4];
        section_tangent(at, first + LANES * q, now, mix, g);
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

/* What is evaluated: the tangent of a strip, whose sections are those from `first` on. */
typedef struct {
    const strip *strip;
    const sections *at;
    int first;
    const exposure *now;
    tangent_weights mix;
} evaluation;

/* The cross-section of the conductor at a stiffness point: axial force by dR/d(u') = axial p p^T +
 * geometric I for the displacements, torsion for the twist; see eq. (11) and (14). */
typedef struct {
    lanes p[3], axial, geometric;
    double damping_axial, torsional;
} point_stiffness;

INLINE void stiffness_at(const evaluation *of, int q, lanes u[3][4], int unknowns,
                         point_stiffness *k)
{
    const cross_section *c = of->now->section;
    const strip *s = of->strip;
    const tangent_weights mix = of->mix;
    const double ea = c->axial_stiffness, damping = mix.c * c->translation_damping[1];
    const int axes = unknowns < 3 ? unknowns : 3;
    const lanes *n = s->shape_slope[q], *p0 = s->slope[q];
    lanes strain = {0.0};
    for (int i = 0; i < axes; i++) {
        const lanes du = n[0] * (u[0][i] - u[1][i]) + n[1] * (u[2][i] - u[1][i]);
        k->p[i] = p0[i] + du;
        strain += du * (p0[i] + 0.5 * du);
    }
    lanes tension = s->tension[q] + ea * strain;
    k->axial = (lanes){0.0} + ea * mix.k;
    if (of->now->tension_only) {
        k->axial = PICK(tension > 0.0, k->axial, (lanes){0.0});
        tension = PICK(tension > 0.0, tension, (lanes){0.0});
    }
    k->geometric = mix.k * tension + damping * s->tension[q];
    k->damping_axial = ea * damping;
    k->torsional = c->torsional_stiffness * (mix.k + mix.c * c->twist_damping[1]);
}

/* Adds the stiffness of point q to the upper triangles of the blocks of the corner nodes. */
INLINE void add_stiffness(const strip *s, int q, const point_stiffness *at, int unknowns,
                          lanes block[6][16])
{
    const int axes = unknowns < 3 ? unknowns : 3;
    const lanes *n = s->shape_slope[q], *p0 = s->slope[q], *p = at->p;
    const lanes left = s->pull[q][0] * n[0], across = s->pull[q][0] * n[1],
                right = s->pull[q][1] * n[1];
    for (int i = 0; i < unknowns; i++)
        for (int j = i; j < (i < 3 ? axes : 4); j++) {
            lanes k = {0.0};
            if (i < 3) k = at->axial * (p[i] * p[j]) + at->damping_axial * (p0[i] * p0[j]);
            if (i < 3 && i == j) k += at->geometric;
            if (i == 3) k += at->torsional;
            block[LEFT_LEFT][unknowns * i + j] += left * k;
            block[LEFT_RIGHT][unknowns * i + j] += across * k;
            block[RIGHT_RIGHT][unknowns * i + j] += right * k;
        }
}

/* Fills in the blocks of the middle node, as the slopes of the three shape functions add up to
 * nothing, and the lower triangles, as the stiffness is symmetric. */
INLINE void complete_blocks(int unknowns, lanes block[6][16])
{
    for (int i = 0; i < unknowns; i++)
        for (int j = i; j < unknowns; j++) {
            const int upper = unknowns * i + j, lower = unknowns * j + i;
            block[LEFT_MIDDLE][upper] = -(block[LEFT_LEFT][upper] + block[LEFT_RIGHT][upper]);
            block[MIDDLE_RIGHT][upper] = -(block[LEFT_RIGHT][upper] + block[RIGHT_RIGHT][upper]);
            block[MIDDLE_MIDDLE][upper] = -(block[LEFT_MIDDLE][upper] + block[MIDDLE_RIGHT][upper]);
            for (int k = 0; k < 6; k++) block[k][lower] = block[k][upper];
        }
}

/* Adds the mass, and the damping in proportion to it. */
INLINE void add_mass(const cross_section *c, const strip *s, tangent_weights mix, int unknowns,
                     lanes block[6][16])
{
    const double translation = c->mass * (mix.m + mix.c * c->translation_damping[0]);
    const double twist = c->inertia * (mix.m + mix.c * c->twist_damping[0]);
    for (int k = 0; k < 6; k++)
        for (int i = 0; i < unknowns; i++)
            block[k][unknowns * i + i] += s->product[k] * (i < 3 ? translation : twist);
}

/* Blocks of `unknowns` rows and columns. */
INLINE void tangent_of(const evaluation *of, lanes u[3][4], int unknowns, lanes block[6][16])
{
    const cross_section *c = of->now->section;
    for (int p = 0; p < 6; p++)
        for (int i = 0; i < unknowns * unknowns; i++) block[p][i] = (lanes){0.0};
    for (int q = 0; q < 2; q++) {
        point_stiffness k;
        stiffness_at(of, q, u, unknowns, &k);
        add_stiffness(of->strip, q, &k, unknowns, block);
    }
    complete_blocks(unknowns, block);
    add_mass(c, of->strip, of->mix, unknowns, block);
    if (unknowns == 4 && (c->eccentric || of->now->blows))
        add_sections(of->strip, of->at, of->first, of->now, of->mix, block);
}

INLINE void strip_of_2(const evaluation *of, const double *u, int count, lanes block[6][16])
{
    lanes nodes[3][4];
    for (int n = 0; n < 3; n++) read_nodes(u, n, count, nodes[n]);
    tangent_of(of, nodes, 2, block);
}
PATHS(strip_of_2, (const evaluation *of, const double *u, int count, lanes block[6][16]),
      (of, u, count, block))

INLINE void strip_of_4(const evaluation *of, const double *u, int count, lanes block[6][16])
{
    lanes nodes[3][4];
    for (int n = 0; n < 3; n++) read_nodes(u, n, count, nodes[n]);
    tangent_of(of, nodes, 4, block);
}
PATHS(strip_of_4, (const evaluation *of, const double *u, int count, lanes block[6][16]),
      (of, u, count, block))

static evaluation at_strip(const interval *c, int index, const exposure *now, const sections *at,
                           tangent_weights mix)
{
    return (evaluation){&c->strip[index], at, 3 * LANES * (c->first_strip + index), now, mix};
}

/* The blocks of a strip, as many rows and columns each as the model has unknowns at a node; `at`
 * holds the section forces, with slopes, of the motion whose displacements along the chain are u.
 */
void element_strip_tangent(const interval *c, int index, const exposure *now, const sections *at,
                           const double *u, tangent_weights mix, lanes block[6][16])
{
    const evaluation of = at_strip(c, index, now, at, mix);
    const int e = LANES * index, count = c->elements - e;
    if (now->unknowns == 2)
        ON_PATH(now->fused, strip_of_2)(&of, u + 8 * e, count, block);
    else
        ON_PATH(now->fused, strip_of_4)(&of, u + 8 * e, count, block);
}

/* tangent: the 4 x 4 blocks left-left, left-middle, ... of one element, of all unknowns; u are its
 * own displacements. */
void element_tangent(const interval *c, int e, const exposure *now, const sections *at,
                     const double u[12], tangent_weights mix, double tangent[6][16])
{
    const evaluation of = at_strip(c, e / LANES, now, at, mix);
    lanes block[6][16];
    ON_PATH(now->fused, strip_of_4)(&of, u, 1, block);
    for (int p = 0; p < 6; p++)
        for (int i = 0; i < 16; i++) tangent[p][i] = LANE(block[p][i], e % LANES);
}
