/* Equilibria: the initial one, and that under wind, loads and displaced supports. */
#ifndef GALLOP_STATICS_H
#define GALLOP_STATICS_H

#include "solver.h"

/* Finds the initial equilibrium of a model: positions, tensions, forces of the supports. */
int statics_initial(gallop_model *model, gallop_report *report);

/* Leaves in u the equilibrium under the conditions `now` of the view; calm: without wind and
 * loads. */
int statics_equilibrium(const gallop_model *model, double t, bool calm, const state_view *view,
                        gallop_report *report);

/* Newton-Raphson at rest from u of the view; returns an outcome, on failure with u as it was. */
int statics_newton(const gallop_model *model, double t, const conditions *now,
                   solver_junctions junctions, const state_view *view, gallop_report *report);

/* [m] */
double statics_shortest_span(const gallop_model *model);

/* From the strung state to the initial equilibrium: temperature, ice, devices, in still air.  It
 * becomes the reference of the displacements. */
int statics_load(gallop_model *m, const state_view *at, gallop_report *report);

/* The weight of the conductors at the nodes, in the strung state or as it is now. */
void statics_weights(const gallop_model *m, bool strung, double *force);

/* The current position becomes the reference. */
void statics_rebase(gallop_model *m, double *u);

#endif
