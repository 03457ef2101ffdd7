/* Geometry of the elements in the initial equilibrium: slopes, shape functions, weights, normals.
 */
#include "element.h"

#include "base_math.h"

static double tangent_at(const double x[9], double xi, double shape_slope[3], double direction[3])
{
    const double slope[3] = {xi - 0.5, -2.0 * xi, xi + 0.5};
    double square = 0.0;
    for (int i = 0; i < 3; i++) {
        direction[i] = slope[0] * x[i] + slope[1] * x[3 + i] + slope[2] * x[6 + i];
        square += direction[i] * direction[i];
    }
    double stretch = sqrt(square); /* dS/dxi */
    for (int i = 0; i < 3; i++) {
        shape_slope[i] = slope[i] / stretch;
        direction[i] /= stretch;
    }
    return stretch;
}

/* n2 = e3 x t of a conductor that hangs in the plane of x1 and x2: its components along x1 and x2.
 */
static void normal_to(const double tangent[3], double normal[2])
{
    const double length = hypotenuse(tangent[0], tangent[1]);
    normal[0] = -tangent[1] / length;
    normal[1] = tangent[0] / length;
}

/* Normals at the nodes; where two elements meet, of their mean direction. */
void element_normals_at_nodes(chain *c)
{
    for (int n = 0; n < c->nodes; n++) {
        const int first = n % 2 || n == 0 ? n / 2 : n / 2 - 1,
                  last = n / 2 < c->elements ? n / 2 : first;
        double sum[3] = {0.0}, slope[3], direction[3];
        for (int e = first; e <= last; e++) {
            tangent_at(c->x + 6 * e, n - 2 * e - 1, slope, direction);
            for (int i = 0; i < 3; i++) sum[i] += direction[i];
        }
        normal_to(sum, c->normal + 2 * n);
    }
}

void element_geometry_from_nodes(geometry *g, const double x[9], const double tension[2])
{
    double slope[3], direction[3];
    for (int q = 0; q < 2; q++) {
        g->stiffness_weight[q] = tangent_at(x, element_gauss2[q], g->shape_slope[q], g->slope[q]);
        g->tension[q] = tension[q];
    }
    memset(g->shape_product, 0, sizeof g->shape_product);
    for (int q = 0; q < 3; q++) {
        double w = element_gauss3_weight[q] * tangent_at(x, element_gauss3[q], slope, direction);
        g->inertia_weight[q] = w;
        normal_to(direction, g->normal[q]);
        for (int a = 0; a < 3; a++)
            for (int b = 0; b < 3; b++)
                g->shape_product[a][b] += w * element_shape3[q][a] * element_shape3[q][b];
    }
}

void element_fill_strips(interval *c)
{
    for (int k = 0; k < LANES * c->strips; k++) {
        const geometry *g = &c->geometry[k < c->elements ? k : c->elements - 1];
        strip *s = &c->strip[k / LANES];
        const int lane = k % LANES;
        const double there = k < c->elements ? 1.0 : 0.0;
        for (int q = 0; q < 2; q++) {
            LANE(s->stiffness_weight[q], lane) = there * g->stiffness_weight[q];
            for (int i = 0; i < 3; i++) LANE(s->slope[q][i], lane) = g->slope[q][i];
            for (int side = 0; side < 2; side++) {
                LANE(s->shape_slope[q][side], lane) = g->shape_slope[q][2 * side];
                LANE(s->pull[q][side], lane) = g->stiffness_weight[q] * g->shape_slope[q][2 * side];
            }
            LANE(s->tension[q], lane) = g->tension[q];
        }
        for (int a = 0, p = 0; a < 3; a++)
            for (int b = a; b < 3; b++, p++) LANE(s->product[p], lane) = g->shape_product[a][b];
        for (int q = 0; q < 3; q++) {
            LANE(s->inertia_weight[q], lane) = there * g->inertia_weight[q];
            for (int n = 0; n < 3; n++)
                LANE(s->share[q][n], lane) = g->inertia_weight[q] * element_shape3[q][n];
            for (int i = 0; i < 2; i++) LANE(s->normal[q][i], lane) = g->normal[q][i];
        }
    }
}
