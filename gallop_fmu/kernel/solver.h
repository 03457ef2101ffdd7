/* Direct solvers of the chain of elements. */
#ifndef GALLOP_SOLVER_H
#define GALLOP_SOLVER_H

#include "element.h"

bool solver_factor(const gallop_model *model, const conditions *now, const sections *at,
                   const double *u, tangent_weights mix, const bool fixed[2][4],
                   chain_factor *factors);
void solver_solve(const gallop_model *model, const chain_factor *factors, const bool fixed[2][4],
                  double *rhs);

/* mix[0] and mix[1]: real and imaginary part of the weights */
bool solver_complex_factor(const gallop_model *model, const conditions *now, const sections *at,
                           const double *u, const tangent_weights mix[2], complex_factor *factors);
void solver_complex_solve(const gallop_model *model, const complex_factor *factors, double *rhs);

#endif
