/* The cable element: forces, tangent, aerodynamic load.  Functions that take an interval count its
 * elements, nodes and unknowns from its own first one. */
#ifndef GALLOP_ELEMENT_H
#define GALLOP_ELEMENT_H

#include "state.h"

extern const double element_gauss2[2]; /* abscissae of the two-point Gauss rule, weights 1 */
extern const double element_gauss3[3], element_gauss3_weight[3];
extern const double element_shape3[3][3]; /* N_a at the three-point Gauss abscissae: [point][a] */

/* Displacement, velocity and acceleration, (nodes, 4) each. */
typedef struct {
    const double *u, *v, *a;
} motion;

/* What an evaluation noticed on its way along the chains; elements count from the first of all. */
typedef struct {
    double lowest_tension, worst_angle, worst_excess;
    int slack_element, angle_element;
    const curve *curve; /* beyond which the worst angle is */
} monitor;

/* Factors of the effective tangent k dR/du + c dR/dv + m dR/da. */
typedef struct {
    double k, c, m;
} tangent_weights;

/* Blocks of an element tangent: the shape functions enter as products N_a N_b, so block (a, b)
 * equals block (b, a), although the block itself need not be symmetric. */
enum { LEFT_LEFT, LEFT_MIDDLE, LEFT_RIGHT, MIDDLE_MIDDLE, MIDDLE_RIGHT, RIGHT_RIGHT };

/* element_aero.c */
double element_attack_angle(double theta, double v2, double v3, double omega, double wind,
                            double attack, double radius);
void element_aero_loads(const interval *c, const exposure *now, const sections *at, int first,
                        int count, bool slopes);
bool element_wind_matters(const interval *c, const exposure *now, const sections *at, int i);

/* element_geometry.c */
void element_geometry_from_nodes(geometry *g, const double x[9], const double tension[2]);
void element_fill_strips(interval *c); /* after every change of the geometry */
void element_normals_at_nodes(chain *c);

/* element_cable.c */
void element_tension(const interval *c, int e, bool tension_only, const double u[12],
                     double tension[2]);
void element_residual(const interval *c, int e, const exposure *now, const sections *at, motion y,
                      double r[12]);
/* Inertia and weight of rotated ice on the first `count` sections, into their forces. */
void element_ice_inertia(const exposure *now, const sections *at, int count);
/* Adds the change of the constant forces of an element, of which ice has fallen: its weight and
 * the moment of the weight, which the initial equilibrium balances. */
void element_add_lost_forces(const interval *c, int e, const exposure *now, double factor,
                             double force[12]);
/* What forces follow from: with slopes the sections are left for the tangent at this motion. */
typedef struct {
    const conditions *now;
    const sections *at;
    motion y;
    bool slopes;
} element_state;

/* Forces of a half; of all. */
void element_sum_half(const gallop_model *model, int half, double t, const element_state *at,
                      double *residual, monitor *seen);
void element_sum_residual(const gallop_model *model, double t, const conditions *now,
                          const sections *at, motion y, bool slopes, double *residual,
                          monitor *seen);
void element_monitor_start(monitor *seen);
/* What was noticed on chains behind those before. */
void element_monitor_add(monitor *seen, const monitor *later);
/* Tensions of a half. */
void element_monitor_tensions(const gallop_model *model, int half, const conditions *now,
                              const double *u, monitor *seen);

/* element_tangent.c */
void element_tangent(const interval *c, int e, const exposure *now, const sections *at,
                     const double u[12], tangent_weights mix, double tangent[6][16]);
void element_strip_tangent(const interval *c, int index, const exposure *now, const sections *at,
                           const double *u, tangent_weights mix, lanes block[6][16]);

#endif
