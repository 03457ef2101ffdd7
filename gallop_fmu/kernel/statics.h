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

/* What is applied in steps; the first member of a structure with what `apply` needs. */
typedef struct static_load {
    /* Sets what acts, `now` included, to a part of it, above 0 and at most 1. */
    void (*apply)(struct static_load *load, double part, const state_view *view);
    conditions now;
} static_load;

/* Leaves in u the equilibrium under the whole load, which grows in steps that halve on failure. */
int statics_in_steps(const gallop_model *model, double t, const state_view *view, static_load *load,
                     gallop_report *report);

/* Calm air, no loads, and towers at their places. */
void statics_calm(const gallop_model *model, conditions *now);

/* Sets what follows from the initial equilibrium: the reference, and u of the view across it. */
void statics_derive(gallop_model *model, const state_view *view);

/* int N'^T T0 X' dS: what the constant forces have to balance in the reference, (nodes, 4). */
void statics_internal_forces(const gallop_model *model, double *force);

/* Depth of the mesh of a chain below the middle of its chord [m]. */
double statics_mesh_sag(const gallop_model *model, const chain *c);

/* Sag and tension are both given: the parabola with both is the initial state. */
bool statics_is_held(const chain *c);

/* [m] */
double statics_shortest_span(const gallop_model *model);

/* From the strung state to the initial equilibrium: temperature, ice, devices, in still air.  It
 * becomes the reference of the displacements. */
int statics_load(gallop_model *m, const state_view *at, gallop_report *report);

/* The weight of the conductors at the nodes: that of the strung state (part 0), that of the initial
 * equilibrium (1), or between. */
void statics_weights(const gallop_model *m, double part, double *force);

/* Adds the forces of the springs that hold the strung state, (nodes, 4). */
void statics_add_spring_forces(const gallop_model *m, double *force);

/* The current position becomes the reference; u becomes 0. */
void statics_rebase(gallop_model *m, double *u);

#endif
