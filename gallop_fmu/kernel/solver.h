/* Direct solver of the tangent equations of all chains and devices. */
#ifndef GALLOP_SOLVER_H
#define GALLOP_SOLVER_H

#include "element.h"

/* Which junctions can move: as the scene says, or none (statics of the single spans). */
typedef enum { SOLVER_JUNCTIONS_AS_IN_SCENE, SOLVER_JUNCTIONS_FIXED } solver_junctions;

/* Factors the tangent weights.k dR/du + weights.c dR/dv + weights.m dR/da into the state; the
 * sections of the view hold the section forces, with slopes, of the motion y.  False: the tangent
 * is not positive definite. */
bool solver_factor(const gallop_model *model, const conditions *now, const state_view *view,
                   motion y, tangent_weights weights, solver_junctions junctions);

/* rhs (nodes, 4) becomes the solution; entries of prescribed unknowns become zero. */
void solver_solve(const gallop_model *model, const state_view *view, solver_junctions junctions,
                  double *rhs);

/* The same with complex weights, real part and imaginary part; rhs (nodes, 8): four real parts
 * before four imaginary ones. */
bool solver_complex_factor(const gallop_model *model, const conditions *now, const state_view *view,
                           motion y, const tangent_weights weights[2]);
void solver_complex_solve(const gallop_model *model, const state_view *view, double *rhs);

/* ---- one chain whose ends are coupled to nothing else (solver_chain.c, solver_complex.c) ---- */

typedef struct {
    bool fixed[2][4];
    double tangent[2][2][16]; /* of what acts at an end: [end][real, imaginary part], by rows */
} chain_ends;

bool solver_chain_factor(const chain *c, const exposure *now, const sections *at, const double *u,
                         tangent_weights weights, const chain_ends *ends, double *store);
void solver_chain_solve(const chain *c, int unknowns, const double *store, const chain_ends *ends,
                        double *rhs);
bool solver_chain_complex_factor(const chain *c, const exposure *now, const sections *at,
                                 const double *u, const tangent_weights weights[2],
                                 const chain_ends *ends, complex_factor *factors);
void solver_chain_complex_solve(const chain *c, const complex_factor *factors,
                                const chain_ends *ends, double *rhs);

#endif
