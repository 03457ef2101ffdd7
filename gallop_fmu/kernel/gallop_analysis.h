/* Functions for analyses outside of the kernel, such as modal analysis, which therefore need no
 * formulas of their own: residual and tangent of any motion, wind load on any section, geometry of
 * the elements.  The rules of gallop.h hold: threads, checks of arguments, axes, indices.  Ice that
 * falls by its time is gone from then on; other ice is there.
 */
#ifndef GALLOP_ANALYSIS_H
#define GALLOP_ANALYSIS_H

#include "gallop.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Out-of-balance forces of a given motion: internal + inertia + damping - aerodynamic - applied
 * forces, without devices and prescribed motion of junctions.  All terms are computed, also those
 * that the scene leaves inactive.
 *
 * @param model     Model
 * @param work      gallop_state_size bytes, of which scratch memory is used; a state in them is
 * kept
 * @param time      Time at which laws and inputs are read [s], finite
 * @param inputs    Values that replace the scene's laws; NULL: the laws hold
 * @param u         (nodes, 4): displacement from the initial equilibrium [m], [rad]
 * @param v         (nodes, 4): velocity [m/s], [rad/s]
 * @param a         (nodes, 4): acceleration [m/s^2], [rad/s^2]
 * @param residual  Output, (nodes, 4): forces and moment [N], [N m]
 * @return          GALLOP_COMPLETED; GALLOP_BAD_CALL
 */
GALLOP_API int gallop_residual(const gallop_model *model, gallop_state *work, double time,
                               const gallop_inputs *inputs, const double *u, const double *v,
                               const double *a, double *residual);

/* Element matrices k dR/du + c dR/dv + m dR/da of the residual R of gallop_residual.
 *
 * @param model    Model
 * @param work     gallop_state_size bytes, of which scratch memory is used; a state in them is kept
 * @param time     Time at which laws and inputs are read [s], finite
 * @param inputs   Values that replace the scene's laws; NULL: the laws hold
 * @param u, v, a  (nodes, 4): motion, as for gallop_residual
 * @param k, c, m  Factors [1], [1/s], [1/s^2], finite
 * @param tangent  Output, (elements, 12, 12): rows and columns are the left, middle and right node,
 *                 each u1, u2, u3, theta; only this array is written
 * @return         GALLOP_COMPLETED; GALLOP_BAD_CALL
 */
GALLOP_API int gallop_tangent(const gallop_model *model, gallop_state *work, double time,
                              const gallop_inputs *inputs, const double *u, const double *v,
                              const double *a, double k, double c, double m, double *tangent);

/* Forces of one device in a given motion: of its stiffness, damping and mass, and against its
 * weight.  With those of all devices, the residual of gallop_residual is that of the whole system.
 *
 * @param model    Model
 * @param work     gallop_state_size bytes, of which scratch memory is used; a state in them is kept
 * @param time     Time at which laws and inputs are read [s], finite
 * @param inputs   Values that replace the scene's laws; NULL: the laws hold
 * @param u, v, a  (nodes, 4): motion, as for gallop_residual; read at the nodes of
 *                 gallop_junction_nodes
 * @param index    Index of the device, 0 to devices - 1
 * @param force    Output, (junctions of the device, 4): forces and moment [N], [N m]
 * @param energy   Output, (2): kinetic energy, and potential energy from the initial equilibrium
 *                 [J]; NULL: not computed
 * @return         GALLOP_COMPLETED; GALLOP_BAD_CALL
 */
GALLOP_API int gallop_device_force(const gallop_model *model, gallop_state *work, double time,
                                   const gallop_inputs *inputs, const double *u, const double *v,
                                   const double *a, int32_t index, double *force, double energy[2]);

/* Matrix k dF/du + c dF/dv + m dF/da of the forces F of gallop_device_force.
 *
 * @param model    Model
 * @param work     gallop_state_size bytes, of which scratch memory is used; a state in them is kept
 * @param time     Time at which laws and inputs are read [s], finite
 * @param inputs   Values that replace the scene's laws; NULL: the laws hold
 * @param u, v, a  (nodes, 4): motion, as for gallop_device_force
 * @param k, c, m  Factors [1], [1/s], [1/s^2], finite
 * @param index    Index of the device, 0 to devices - 1
 * @param tangent  Output, (junctions, junctions, 4, 4) of the device: junction of the force,
 *                 junction of the motion, rows and columns u1, u2, u3, theta
 * @return         GALLOP_COMPLETED; GALLOP_BAD_CALL
 */
GALLOP_API int gallop_device_tangent(const gallop_model *model, gallop_state *work, double time,
                                     const gallop_inputs *inputs, const double *u, const double *v,
                                     const double *a, double k, double c, double m, int32_t index,
                                     double *tangent);

/* Forces F of one device in many motions of its junctions, without inertia, towers at rest.
 *
 * @param model  Model
 * @param index  Index of the device, 0 to devices - 1
 * @param count  Number of motions, 0 or more
 * @param u      (count, junctions of the device, 4): displacement from the initial equilibrium [m],
 *               [rad], finite
 * @param v      (count, junctions, 4): velocity [m/s], [rad/s], finite
 * @param force  Output, (count, junctions, 4): forces and moment [N], [N m]
 * @param by_u   Output, (count, junctions, junctions, 4, 4): dF/du, as of gallop_device_tangent
 * @param by_v   Output, of the same shape: dF/dv
 * @return       GALLOP_COMPLETED; GALLOP_BAD_CALL
 */
GALLOP_API int gallop_device_load(const gallop_model *model, int32_t index, int32_t count,
                                  const double *u, const double *v, double *force, double *by_u,
                                  double *by_v);

/* Nodes of the junctions, and nodes that are the same point.
 *
 * @param model   Model
 * @param node    Output, (junctions): index of the node whose motion is that of the junction
 * @param leader  Output, (nodes): index of the node whose motion a node has: at junctions where
 *                several chains end, that of the first of them; elsewhere its own
 * @return        GALLOP_COMPLETED; GALLOP_BAD_CALL
 */
GALLOP_API int gallop_junction_nodes(const gallop_model *model, int32_t *node, int32_t *leader);

/* Quasi-steady aerodynamic load per unit length on sections in any motion (Liu et al. 2009, eq.
 * 20-21), and its derivatives.  With the relative wind w2 = -v2 - r omega, w3 = U - v3, Ur^2 = w2^2
 * + w3^2, the attack angle alpha = alpha0 + theta + atan2(w2, w3), and q = rho d Ur / 2,
 *
 *     F2 = q (CL w3 + CD w2),    F3 = q (CD w3 - CL w2),    M = q Ur d CM.
 *
 * A section lies in the plane of the conductor's upward normal n2 and of x3.  Air density rho,
 * diameter d, radius r and the coefficient curve are those of the scene.  There is no load where U
 * = 0, and none without a curve.
 *
 * @param model         Model
 * @param element       Element whose conductor and curve apply, 0 to elements - 1
 * @param attack_angle  alpha0 [rad], finite
 * @param count         Number of sections, 0 or more
 * @param given         (5, count): theta [rad], v2 along n2 [m/s], v3 along x3 [m/s], omega
 *                      [rad/s], U [m/s]; all finite
 * @param load          Output, (3, count): F2 along n2 [N/m], F3 along x3 [N/m], M about x1 [N]
 * @param slopes        Output, (4, 3, count): derivatives of the load by theta, v2, v3 and omega
 *                      (by U: minus that by v3); NULL: they are not computed
 * @param angle         Output, (count): attack angle alpha [rad]
 * @param excess        Output, (count): by how much [rad] alpha, less whole turns, is beyond the
 *                      last breakpoint of the curve (positive) or before the first one (negative),
 *                      where a simulation would end with GALLOP_ANGLE_OUT_OF_RANGE; else 0
 * @return              GALLOP_COMPLETED; GALLOP_BAD_CALL
 */
GALLOP_API int gallop_aero_load(const gallop_model *model, int32_t element, double attack_angle,
                                int32_t count, const double *given, double *load, double *slopes,
                                double *angle, double *excess);

/* Load of ice and wind on a conductor that moves in a few shapes, collected by the shapes: the part
 * of the inertia and weight of rotated ice that is not linear about rest, less the aerodynamic load
 * of gallop_aero_load.  It is the force on each shape's coordinate, as in gallop_residual.
 *
 * @param model     Model
 * @param places    Number of sections, 0 or more
 * @param element   (places): element whose conductor and curve apply, 0 to elements - 1
 * @param table     (6, places): attack angle alpha0 [rad]; first moments m2, m3 of the ice at
 * that angle [kg]; gravity against n2 [m/s^2]; wind along n2 and x3 per m/s [1]
 * @param modes     Number of shapes, 0 or more
 * @param shape     (3, modes, places): motion of a section along n2, along x3, and its twist, per
 *                  unit coordinate
 * @param weight    (3, modes, places): the same times the length of conductor of the section [m]
 * @param count     Number of instants, 0 or more
 * @param moves     (3 modes + 1, count): coordinates, their velocities, their accelerations, wind
 *                  speed [m/s]; where it is 0, there is no aerodynamic load
 * @param force     Output, (modes, count)
 * @return          GALLOP_COMPLETED; GALLOP_BAD_CALL, also for a number that is not finite
 */
GALLOP_API int gallop_shape_load(const gallop_model *model, int32_t places, const int32_t *element,
                                 const double *table, int32_t modes, const double *shape,
                                 const double *weight, int32_t count, const double *moves,
                                 double *force);

/* Sections at which inertia, ice and wind are integrated: the three-point Gauss abscissae of each
 * element, in the direction of its chain.
 *
 * @param model   Model
 * @param shape   Output, (3, 3): shape function of each node at each abscissa of an element
 * @param length  Output, (elements, 3): length of conductor that belongs to each section, its
 *                weight in an integral over the arc length [m]
 * @param normal  Output, (elements, 3, 2): n2 = e3 x t, the upward normal of the conductor in its
 *                vertical plane, along x1 and x2
 * @return        GALLOP_COMPLETED; GALLOP_BAD_CALL
 */
GALLOP_API int gallop_sections(const gallop_model *model, double shape[9], double *length,
                               double *normal);

/* Points at which tension and twisting moment are integrated: the two-point Gauss abscissae of each
 * element, in the direction of its chain.
 *
 * @param model        Model
 * @param length       Output, (elements, 2): length of conductor that belongs to each point [m]
 * @param tangent      Output, (elements, 2, 3): unit tangent dX/dS of the initial equilibrium
 * @param shape_slope  Output, (elements, 2, 3): derivative of each node's shape function by the arc
 *                     length S [1/m]
 * @return             GALLOP_COMPLETED; GALLOP_BAD_CALL
 */
GALLOP_API int gallop_strain_points(const gallop_model *model, double *length, double *tangent,
                                    double *shape_slope);

/* Upward normal of the conductor at the nodes, of the mean direction where two elements meet.  The
 * attack angle at a node follows from the velocity along it.
 *
 * @param model   Model
 * @param normal  Output, (nodes, 2): n2 along x1 and x2
 * @return        GALLOP_COMPLETED; GALLOP_BAD_CALL
 */
GALLOP_API int gallop_node_normals(const gallop_model *model, double *normal);

/* Unknowns that the equations of motion determine.
 *
 * @param model    Model
 * @param is_free  Output, (nodes, 4): 1; 0 for an unknown that is prescribed (motion of a support,
 *                 twist at a junction), and at the end of a chain that follows another one
 * @return         GALLOP_COMPLETED; GALLOP_BAD_CALL
 */
GALLOP_API int gallop_free_unknowns(const gallop_model *model, int32_t *is_free);

/* Initial disturbance of the scene, which gallop_state_init adds to the equilibrium.
 *
 * @param model  Model
 * @param u      Output, (nodes, 4): displacement [m], [rad]
 * @return       GALLOP_COMPLETED; GALLOP_BAD_CALL
 */
GALLOP_API int gallop_seed(const gallop_model *model, double *u);

#ifdef __cplusplus
}
#endif
#endif
