/* A model: the scene, its mesh and its initial equilibrium. */
#ifndef GALLOP_MODEL_H
#define GALLOP_MODEL_H

#include "base_lanes.h"
#include "gallop.h"
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* One element in the initial equilibrium, S its arc length.  Two Gauss points for stiffness (full
 * integration locks), three for inertia and aerodynamics. */
typedef struct {
    double slope[2][3];       /* p0 = dX/dS */
    double shape_slope[2][3]; /* dN_a/dS */
    double stiffness_weight[2];
    double tension[2]; /* T0 [N] */
    double inertia_weight[3];
    double normal[3]
                 [2]; /* n2 of the section's plane, along x1 and x2, where inertia is integrated */
    double shape_product[3][3]; /* int N_a N_b dS [m] */
} geometry;

/* A loaded point: which load, and where. */
typedef struct {
    int load, element;
    double shape[3];
} load_place;

/* Bins of equal width over an aerodynamic curve of several pieces: where the search for a piece
 * begins. */
#define PIECE_BINS 256

struct gallop_model {
    uint64_t magic, identity; /* identity: models of the same scene share it */
    gallop_scene scene;       /* its pointers lead into this block */
    gallop_derived derived;
    int elements, nodes, strips;
    /* what the scene needs; the rest is not computed (see choose_parts) */
    int unknowns; /* leading ones of each node that can move: 4 or 2 */
    bool eccentric, aerodynamic;
    bool tension_only;            /* in motion; statics have the law of the taut cable */
    double mass, inertia, c2, c3; /* mu, I with ice; first moments at the scene's attack angle */
    double radius;                /* r of the relative wind */
    bool fixed[2][4];             /* prescribed unknowns at the ends */
    double stiffness[2][4];       /* support springs */
    double static_force[2][3];    /* of the support on the cable, in equilibrium */
    double curve_centre, curve_first,
        curve_last; /* validity range of the aerodynamic curve [rad] */
    size_t saved_size,
        state_size;         /* what must be copied to save a state, and with scratch memory */
    geometry *geometry;     /* (elements), */
    strip *strip;           /* (strips) and once more side by side */
    double *x;              /* (nodes, 3) initial positions */
    double *normal;         /* (nodes, 2) n2 of the section's plane, along x1 and x2 */
    double *constant_force; /* (nodes, 4) balances the initial state */
    int *piece_near;   /* (PIECE_BINS) piece at the start of each bin of the aerodynamic curve */
    load_place *place; /* (load_count) */
    int load_count;    /* loaded points */
};

static inline bool model_by_gauss(const gallop_model *model)
{
    return model->scene.integrator == GALLOP_GAUSS6;
}

static inline bool model_by_alpha(const gallop_model *model)
{
    return model->scene.integrator == GALLOP_GENERALISED_ALPHA;
}

static inline bool model_by_tolerance(const gallop_model *model)
{
    return model->scene.tolerance > 0.0;
}

#endif
