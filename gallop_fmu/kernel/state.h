/* A state: one flat block of memory, and where what lies in it. */
#ifndef GALLOP_STATE_H
#define GALLOP_STATE_H

#include "base_memory.h"
#include "conditions.h"
#include "team.h"

#define NEWMARK_HISTORY 4
#define GAUSS_STAGES 3
#define GAUSS_ARRAYS (GAUSS_STAGES + 2) /* kept from step to step: stage_before, begin */

struct gallop_state {
    uint64_t magic, size, identity; /* identity: the model's */
    double time;
    double factored_step; /* step size of the stored factorisation, 0: none */
    double
        step_before; /* size of the sub-step before, for extrapolation; infinite: there is none */
    int64_t newest;  /* Newmark: place of the acceleration before in the ring of those kept */
    int64_t equal_steps; /* Newmark: sub-steps before of that size, NEWMARK_HISTORY at most */
    double last_step;    /* of the last step under a tolerance; what the state can be read within */
    double wanted_step;  /* under a tolerance: the step size to try next */
    double run_origin;   /* time from which the records of gallop_run count */
    double largest[4]; /* largest motion so far, root mean square over the nodes: u1 u2 u3 theta */
    double rate;       /* last observed convergence rate of the stored factorisation */
    double sharpness;  /* factor on the Newton tolerance */
    double lowest_tension, largest_turn;
    int64_t steps, substeps, iterations, refactorisations, halvings, rejections;
    int64_t last_iterations, last_substeps;
    int64_t unused;  /* 0; then the arrays begin at a place for vectors, see base_memory.h */
    double values[]; /* the arrays of a state_view */
};
_Static_assert(offsetof(gallop_state, values) % VECTOR == 0, "see `unused`");

/* Section forces along the chains, structure of arrays: one entry a three-point Gauss abscissa, in
 * the order strip, point, lane.  With slopes the arrays hold all chains; without, the elements just
 * at work, from the start of the arrays. */
typedef struct {
    double *theta, *omega, *omega_rate; /* motion of the section, along n2 and n3: */
    double *v2, *v3, *a2, *a3;          /* see element_aero.c; in a varied field v2 and v3 are
                                           relative to the air */
    double *gravity;                    /* component against n2 */
    double *c2, *c3;                    /* turned first mass moments */
    double *angle, *excess;             /* attack angle, and by how much it is out of range */
    double *force[3]; /* f2, f3 along n2 and n3, moment: inertia of the ice - aerodynamics */
    double *by_theta[3], *by_v2[3], *by_v3[3]; /* derivatives of the aerodynamic load */
} sections;

/* Pointers into a state; made afresh by every call.  state.c has the table of their sizes. */
typedef struct {
    /* saved */
    double *u, *v, *a;    /* (nodes, 4) */
    double *a_before;     /* (NEWMARK_HISTORY, nodes, 4) Newmark: accelerations before, in a ring */
    double *stage_before; /* (stages, nodes, 4) Gauss: accelerations of the sub-step before, */
    double *begin;        /* (2, nodes, 4) and u v at its begin */
    double *factors;      /* of all chains, see solver.h */
    double *complex_factors; /* Gauss: of the complex pair of its stages, */
    double *factored;        /* (nodes, 4) and directions of the cable for which both were made */
    double *now_block, *looked_from_block;
    double *lost;   /* (sheddings, 2) kinetic and potential energy of the ice that fell [J] */
    double *fallen; /* (sheddings) time at which the ice fell; infinite: it has not [s] */
    /* scratch */
    double *u0, *v0, *a0; /* start of the sub-step, */
    double *residual;     /* out-of-balance forces, then the correction, */
    double *first; /* u v a a_before, or stage_before begin, at the start of a halved whole step */
    double *stage_u, *stage_v, *stage_a; /* (stages, nodes, 4); generalised alpha: one instant */
    double *stage_residual;              /* (stages, nodes, 4) */
    double *complex_residual;            /* (nodes, 8) */
    double *along;                       /* (stages, nodes, 4) Gauss: directions of the cable now */
    double *junction_rhs;                /* (parts, junctions, 4) if junctions are coupled */
    double *stage_block[GAUSS_STAGES];
    sections sections;
    double *saved; /* the state at the start of gallop_advance */
    /* in the blocks above */
    conditions now, looked_from; /* of the motion; before a look into the last step */
    conditions stage[GAUSS_STAGES];
    gallop_team *team; /* NULL: one thread */
} state_view;

/* Sizes of a state [bytes]. */
void state_measure(gallop_model *model);

state_view state_view_of(const gallop_model *model, gallop_state *state);

/* Bytes of the motion that a step changes: u v a and what is kept of the steps before. */
size_t state_motion_bytes(const gallop_model *model);

/* Copies the counts of a state into a report. */
void state_report_work(const gallop_state *state, gallop_report *report);

#endif
