/* A model: what the scene describes as tables of kinds, with its mesh and initial equilibrium.
 *
 * A chain is a line of elements between two junctions.  Its nodes lie side by side in the arrays of
 * unknowns, both ends included; further junctions may lie at its corners.  Where several chains
 * meet in one junction, each has an end node of its own there; a tie makes the others follow the
 * first (see junction.c).  The nodes of bodies come after those of all chains. */
#ifndef GALLOP_MODEL_H
#define GALLOP_MODEL_H

#include "base_lanes.h"
#include "gallop.h"
#include "law.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
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
    double normal[3][2]; /* n2 of the section's plane, along x1 and x2, at the three points */
    double shape_product[3][3]; /* int N_a N_b dS [m] */
} geometry;

/* Bins of equal width over an aerodynamic curve of several pieces: where the search for a piece
 * begins. */
#define PIECE_BINS 256

/* A coefficient curve: cubics on intervals of the attack angle. */
typedef struct {
    int pieces, outside; /* outside: a gallop_outside */
    const double *breakpoint, *origin, *coefficient;
    double centre, first, last; /* validity range [rad] */
    int *piece_near;            /* (PIECE_BINS) piece at the start of each bin */
} curve;

/* A conductor with its ice. */
typedef struct {
    double diameter, mass, inertia; /* [m], mu [kg/m], I [kg m]: with ice */
    double strung_mass;             /* in the strung state [kg/m] */
    double axial_stiffness, torsional_stiffness;
    double thermal_expansion;                        /* [1/K] */
    double translation_damping[2], twist_damping[2]; /* Rayleigh b1 [1/s], b2 [s] */
    double attack, moment_angle, moment[2]; /* alpha0 [rad]; first moments, given at an angle */
    double c2, c3;                          /* first moments at alpha0 [kg] */
    double radius;                          /* r of the relative wind [m] */
    bool eccentric, tension_only;           /* tension_only: in motion; statics are taut */
    const curve *curve;                     /* NULL: no aerodynamic load */
} cross_section;

/* Elements of a chain that lie side by side and have one cross-section.  The node between two
 * intervals belongs to both. */
typedef struct {
    const cross_section *section;
    const cross_section *section_after; /* once its ice has fallen, */
    int section_index, index_after;
    int shedding; /* index; -1: it keeps its ice */
    int field;
    int elements, nodes, strips, first_node, first_element, first_strip;
    bool aerodynamic; /* it has a curve, with or without its ice, and its wind can blow */
    double gravity, air_density;
    geometry *geometry; /* (elements), */
    strip *strip;       /* (strips) and once more side by side */
    double *x;          /* (nodes, 3) initial positions */
} interval;

/* A corner of a chain at which a junction lies. */
typedef struct {
    int corner, junction;
} kept_corner;

typedef struct {
    int junction[2];
    int first_interval, intervals;
    int elements, nodes, strips, first_node, first_element, first_strip;
    int kept_corners;        /* both ends included */
    const kept_corner *kept; /* (kept_corners), in order along the chain */
    const int *strip_start;  /* (strips + 1) first element of each strip, then `elements` */
    size_t first_factor;     /* place of its factors in those of all chains [doubles], real */
    double weight;           /* in the strung state, of its first interval [N/m] */
    double mass;             /* of its first interval, with ice [kg/m] */
    double span, rise;       /* of the chord in the strung state, along x1 and x2 [m] */
    double target_sag, target_tension;      /* 0: not given */
    double parameter;                       /* of its catenary, H / w [m] */
    double sag, horizontal_tension, length; /* of the initial equilibrium */
    double end_force[2][3];                 /* of the chain on its ends there, along x1 x2 x3 [N] */
    geometry *geometry;                     /* (elements) */
    double *x;                              /* (nodes, 3) initial positions */
    double *normal; /* (nodes, 2) n2 of the section's plane, along x1 and x2 */
} chain;

/* Where a varied field of wind acts: a section or a node in the initial equilibrium. */
typedef struct {
    int station, next; /* of gusts: the last one before it, and the one after it, which may be the
                          same one */
    double weight;     /* of the latter */
    double factor;     /* of the profile on the speed */
    double normal[2];  /* n2, along x1 and x2 */
} wind_place;

/* A point where chains end, where stations lie, and devices act. */
typedef struct {
    double position[3];     /* in the strung state [m] */
    double moved[3];        /* from there to the initial equilibrium [m] */
    bool fixed[4];          /* prescribed: u1 u2 u3 follow `motion`, theta is zero */
    bool body;              /* no chain ends here, and no station lies here */
    const law *motion[3];   /* NULL: at rest */
    int node;               /* the end node of the first chain that ends here, or its own */
    double static_force[3]; /* of the support on the chains, in equilibrium [N]; of a strung line,
                               of the springs in the strung state */
} junction;

/* Node `follower` is the same point as node `leader`. */
typedef struct {
    int follower, leader;
    int half; /* in which both lie; BETWEEN: one in each */
} tie;

#define DEVICE_CONSTANTS 40

struct device_kind;

typedef struct {
    const struct device_kind *kind;
    int junctions, junction[GALLOP_DEVICE_JUNCTIONS];
    double gravity;
    int halves;                        /* of the line in which it has junctions: 1, 2 or 3 */
    double reach;                      /* length of a bar that may swing [m]; 0: none */
    double constant[DEVICE_CONSTANTS]; /* of the kind, prepared from the scene */
} device;

/* Half of a line, which one of two threads can compute: chains that follow each other, with their
 * intervals and nodes; those of bodies are in the last one.  From the first one to that behind the
 * last one. */
typedef struct {
    int chain[2], interval[2], node[2];
    int first_strip;
} line_half;

/* In place of a half: what lies in both. */
#define BETWEEN 2

/* A loaded point: which load, and where. */
typedef struct {
    int load, chain, element;
    double fraction; /* of the conductor's length */
    double shape[3];
} load_place;

/* The forces of a load at its full amplitude on the nodes of its elements. */
typedef struct {
    int first, values; /* of the unknowns of all nodes */
    double *force;     /* [N], [N m] */
} nodal_load;

struct gallop_model {
    uint64_t magic, identity; /* identity: models of the same scene share it */
    void *allocated;          /* the memory in which the model lies */
    gallop_scene scene;       /* its pointers lead into this block */
    gallop_derived derived;
    int nodes, elements, strips; /* of all chains */
    int halves;                  /* 2, or 1 of what is not worth to be shared, */
    line_half half[2];           /* in which the first one is everything */
    /* what the scene needs; the rest is not computed (see model_create_parts.c) */
    int unknowns; /* leading ones of each node that can move: 4 or 2 */
    bool fused;   /* the fused path is taken: see PATHS */
    int curve_count, section_count, field_count, chain_count, interval_count, junction_count,
        tie_count, device_count, law_count, load_count, shedding_count;
    curve *curve;
    cross_section *section;
    chain *chain;
    interval *interval;
    junction *junction;
    tie *tie;
    device *device;
    load_place *place;      /* (load_count) loaded points */
    nodal_load *nodal_load; /* of each load of the scene */
    law *law;
    const law **wind;          /* (field_count) wind speed, */
    const law **direction;     /* direction; NULL: 0 */
    bool varied;               /* a field is varied: there are */
    wind_place *section_place; /* (3 LANES strips) places of sections, in the order of
                                  `sections`, and */
    wind_place *node_place;    /* (nodes of all chains) of nodes */
    double *shedding_time;     /* (shedding_count) [s] by the scene; infinite: not at a time */
    double *x, *normal;        /* of all chains */
    double *constant_force;    /* (nodes, 4) balances the initial state */
    double *chord;             /* (nodes, 4) from the node before to the one after in the initial
                                  equilibrium [m], */
    double *chord_inverse;     /* (nodes, 4) and 1 / length; 0 at junctions: see time_turn.h */
    bool coupled;              /* junctions join chains or devices: see solver.c */
    int junction_reach;        /* farthest junctions that a chain or a device joins */
    size_t chain_factors;      /* room for the factors of all chains, [doubles] of real ones, */
    size_t factor_room;        /* and with the matrix of the junctions */
    size_t saved_size, state_size; /* to save a state, and with its scratch memory [bytes] */
};

/* The chain to which a node belongs; it is not the node of a body. */
static inline const chain *model_chain_of_node(const gallop_model *model, int node)
{
    const chain *c = model->chain;
    while (node >= c->first_node + c->nodes) c++;
    return c;
}

/* The interval to which an element belongs. */
static inline const interval *model_interval_of_element(const gallop_model *model, int element)
{
    const interval *of = model->interval;
    while (element >= of->first_element + of->elements) of++;
    return of;
}

static inline int model_half_of_node(const gallop_model *model, int node)
{
    return node < model->half[0].node[1] ? 0 : 1;
}

static inline bool model_by_gauss(const gallop_model *model)
{
    return model->scene.settings.integrator == GALLOP_GAUSS6;
}

static inline bool model_by_alpha(const gallop_model *model)
{
    return model->scene.settings.integrator == GALLOP_GENERALISED_ALPHA;
}

static inline bool model_by_tolerance(const gallop_model *model)
{
    return model->scene.settings.tolerance > 0.0;
}

#endif
