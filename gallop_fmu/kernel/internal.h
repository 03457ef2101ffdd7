/* What the kernel's files share and nobody else sees. */
#ifndef GALLOP_INTERNAL_H
#define GALLOP_INTERNAL_H

#include "gallop.h"
#include "strip.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846
#define MOST_STEPS 1e12 /* in one call: more would not end */

/* Before a function that works along the span: it is compiled twice, for AVX2 and for any x86-64,
 * and the loader picks. Both give the same bits, as there is no fused multiply-add.  Elsewhere,
 * under sanitizers, and by clang before 18, which does not link such functions across files, once.
 */
#if defined(__clang__) && __clang_major__ < 18 && !defined(GALLOP_ONE_PATH)
#define GALLOP_ONE_PATH
#endif
#if defined(__GNUC__) && defined(__x86_64__) && defined(__linux__) && defined(__GLIBC__) &&        \
    !defined(__SANITIZE_ADDRESS__) && !defined(GALLOP_ONE_PATH)
#define TWO_PATHS __attribute__((target_clones("avx2", "default")))
#else
#define TWO_PATHS
#endif

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

extern const double gauss2[2];    /* +-1/sqrt(3) */
extern const double shape3[3][3]; /* N_a at the three-point Gauss abscissae: shape3[point][a] */

/* A loaded point: which load, and where. */
typedef struct {
    int load, element;
    double shape[3];
} load_place;

struct gallop_model {
    uint64_t magic, identity; /* identity: models of the same scene share it */
    gallop_scene scene;       /* its pointers lead into this block */
    gallop_derived derived;
    int elements, nodes, strips;
    /* what the scene needs; the rest is not computed (see choose_parts) */
    int unknowns; /* leading ones of each node that can move: 4, 3 or 2 */
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

/* The inputs at one instant. */
typedef struct {
    double wind, attack;
    double c2, c3;      /* first mass moments of the ice at theta = 0, turned to the attack angle */
    double load_factor; /* 1 but while a static load is stepped up */
    double position[2][3], velocity[2][3], acceleration[2][3];
} instant;

/* What an evaluation noticed on its way along the span. */
typedef struct {
    double lowest_tension, worst_angle, worst_excess;
    int slack_element, angle_element;
} watch;

/* Factors of the effective tangent k dR/du + c dR/dv + m dR/da. */
typedef struct {
    double k, c, m;
} blend;

/* Blocks of an element tangent: the shape functions enter as products N_a N_b, so block (a, b)
 * equals block (b, a), although the block itself need not be symmetric. */
enum { LEFT_LEFT, LEFT_MIDDLE, LEFT_RIGHT, MIDDLE_MIDDLE, MIDDLE_RIGHT, RIGHT_RIGHT };

/* Room for the factorised effective tangent of an element and its left corner; solver.c arranges
 * it. */
typedef struct {
    double value[96];
} factor;

/* One for each element, and the last corner and the lanes beyond the last element. */
static inline size_t factor_count(int elements)
{
    return (size_t)elements + 2;
}

/* Bins of equal width over an aerodynamic curve of several pieces: where the search for a piece
 * begins. */
#define PIECE_BINS 256

/* The same with complex blocks, by columns: see pair_solver.c. */
typedef struct {
    double re[16], im[16];
} pair_block;
typedef struct {
    pair_block middle_inverse, left_middle, right_middle, corner_inverse, next_previous,
        previous_next;
} pair_factor;

#define NEWMARK_HISTORY 4
#define GAUSS_STAGES 3
#define GAUSS_ARRAYS (GAUSS_STAGES + 2) /* kept from step to step: stage_before, begin */

struct gallop_state {
    uint64_t magic, size, identity; /* identity: the model's */
    double time;
    double factored_step; /* step size of the stored factorisation, 0: none */
    double
        step_before; /* size of the sub-step before, for extrapolation; infinite: there is none */
    int64_t
        newest; /* Newmark: place of the acceleration before in the ring of those that are kept */
    int64_t equal_steps; /* Newmark: how many sub-steps before were of that size, NEWMARK_HISTORY at
                            most */
    double last_step;    /* of the last step under a tolerance; what the state can be read within */
    double wanted_step;  /* under a tolerance: the step size to try next */
    double run_origin;   /* time from which the records of gallop_run count */
    double largest[4]; /* largest motion so far, root mean square over the nodes: u1 u2 u3 theta */
    double rate;       /* last observed convergence rate of the stored factorisation */
    double sharpness;  /* factor on the Newton tolerance */
    double lowest_tension, largest_turn;
    int64_t steps, substeps, iterations, refactorisations, halvings, rejections;
    int64_t last_iterations, last_substeps;
    instant now,
        looked_from; /* of the motion; and where to return to from a look into the last step */
    double values[]; /* u v a a_before, or stage_before begin; factors pair_factors | scratch: see
                        layout */
};

/* Section forces along the span, structure of arrays: one entry a three-point Gauss abscissa, in
 * the order strip, point, lane.  With slopes the arrays hold the whole span; without, the elements
 * just at work, from the start of the arrays. */
typedef struct {
    double *theta, *omega, *omega_rate, *v2, *v3, *a2,
        *a3;                /* motion of the section: along n2 and n3, see aero.c */
    double *gravity;        /* component against n2 */
    double *c2, *c3;        /* turned first mass moments */
    double *angle, *excess; /* attack angle, and by how much it is out of range */
    double *force[3];       /* f2, f3 along n2 and n3, moment: inertia of the ice - aerodynamics */
    double *by_theta[3], *by_v2[3], *by_v3[3]; /* derivatives of the aerodynamic load */
} sections;
#define SECTION_ARRAYS 24

/* Pointers into a state; made afresh by every call. */
typedef struct {
    double *u, *v, *a;    /* (nodes, 4) */
    double *a_before;     /* (NEWMARK_HISTORY, nodes, 4) Newmark: accelerations before, in a ring */
    double *stage_before; /* (stages, nodes, 4) Gauss: accelerations of the sub-step before, */
    double *begin;        /* (2, nodes, 4) and u v at its begin */
    factor *factors;      /* (factor_count) */
    pair_factor
        *pair_factors; /* (elements), and the last corner: for the complex pair of Gauss's stages */
    double *u0, *v0, *a0; /* scratch: start of the sub-step, */
    double *residual;     /* out-of-balance forces, then the correction, */
    double *first; /* u v a a_before, or stage_before begin, at the start of a halved whole step */
    double *stage_u, *stage_v,
        *stage_a;           /* (stages, nodes, 4); generalised alpha: one, within the step */
    double *stage_residual; /* (stages, nodes, 4) */
    double *pair_residual;  /* (nodes, 8) */
    sections sections;
    char *saved; /* the state at the start of gallop_advance */
} layout;

/* check.c */
bool finite_instant(const instant *now);
#define WORD                                                                                       \
    8 /* [bytes] alignment of all that exported functions are given, but for arrays of int32_t */
#define NOT_USABLE(pointer) #pointer ", a pointer that is null or not aligned to its type"
bool usable(const void *pointer, size_t alignment);
bool finite_numbers(const double *values, size_t count);
void mark_model(gallop_model *model);
void mark_state(const gallop_model *model, gallop_state *state);
bool is_model(const gallop_model *model);
bool is_started(const gallop_state *state);
bool is_state_of(const gallop_model *model, const gallop_state *state);
bool report_start(gallop_report *report, double time);
void report_work(const gallop_state *state, gallop_report *report);
int refuse(gallop_report *report, const char *field, double value, double limit);
int check_room(const gallop_model *model, const gallop_state *state, double time,
               gallop_report *report);
int check_state(const gallop_model *model, const gallop_state *state, gallop_report *report);
int check_inputs(const gallop_model *model, const gallop_inputs *inputs, double until,
                 gallop_report *report);
int check_indices(const int32_t *index, int32_t count, int32_t end, const char *const field[3],
                  gallop_report *report);

/* state.c */
layout state_layout(const gallop_model *model, gallop_state *state);

/* law.c */
bool law_always_zero(const gallop_law *law);
double law_value(const gallop_law *law, double t);
double law_rate(const gallop_law *law, double t);
double law_second(const gallop_law *law, double t);
double law_next_kink(const gallop_law *law, double t);
void instant_at(const gallop_model *model, double t, const gallop_inputs *inputs, instant *now);
void turn_moments(const gallop_scene *scene, double attack, double *c2, double *c3);

/* aero.c */
double aero_angle(double theta, double v2, double v3, double omega, double wind, double attack,
                  double radius);
void aero_loads(const gallop_model *model, const instant *now, const sections *at, int first,
                int count, bool slopes);
bool wind_matters(const gallop_model *model, const instant *now, const sections *at, int i);

/* element.c */
static inline bool windy(const gallop_model *model, const instant *now)
{
    return model->aerodynamic && now->wind != 0.0;
}
void geometry_from_nodes(geometry *g, const double x[9], const double tension[2]);
void lay_side_by_side(gallop_model *model); /* after every change of the geometry */
void normals_at_nodes(gallop_model *model);
void element_tension(const gallop_model *model, int e, const double u[12], double tension[2]);
void element_residual(const gallop_model *model, int e, const instant *now, const sections *at,
                      const double *u, const double *v, const double *a, double r[12]);
void span_residual(const gallop_model *model, double t, const instant *now, const sections *at,
                   const double *u, const double *v, const double *a, bool slopes, double *residual,
                   watch *seen);
void watch_start(watch *seen);
void watch_tensions(const gallop_model *model, const double *u, watch *seen);

/* tangent.c */
void element_tangent(const gallop_model *model, int e, const instant *now, const sections *at,
                     const double u[12], blend mix, double tangent[6][16]);
void strip_tangent(const gallop_model *model, int index, const instant *now, const sections *at,
                   const double *u, blend mix, lanes block[6][16]);

/* solver.c */
bool solver_factor(const gallop_model *model, const instant *now, const sections *at,
                   const double *u, blend mix, const bool fixed[2][4], factor *factors);
void solver_solve(const gallop_model *model, const factor *factors, const bool fixed[2][4],
                  double *rhs);

/* pair_solver.c: mix[0] and mix[1] are real and imaginary part of the blend */
bool pair_factor_span(const gallop_model *model, const instant *now, const sections *at,
                      const double *u, const blend mix[2], pair_factor *factors);
void pair_solve(const gallop_model *model, const pair_factor *factors, double *rhs);

/* static.c */
int initial_equilibrium(gallop_model *model, gallop_report *report);
int static_equilibrium(const gallop_model *model, double t, const instant *target, layout *at,
                       gallop_report *report);

/* newton.c: what all integrators share in solving for a step */
typedef enum { NEWTON_GOES_ON, NEWTON_RENEWS, NEWTON_CONVERGED, NEWTON_DIVERGED } newton_course;
void add_springs(const gallop_model *model, const instant *now, const double *u, double *residual);
double correction_size(const gallop_model *model, const double *du);
newton_course newton_judge(gallop_state *state, double size, double before, bool fresh, double slow,
                           double tolerance);
int newton_accept(const gallop_model *model, gallop_state *state, const watch *seen, double t,
                  gallop_report *report);
int angle_failure(const gallop_model *model, int element, double angle, double t,
                  gallop_report *report);

/* newmark.c, gauss.c: one step from u0 v0 a0 at t - h to u v a at t; commit: it is the one before
 * from now on */
int newmark(const gallop_model *model, gallop_state *state, layout *at, const gallop_inputs *inputs,
            double t, double h, double tolerance, gallop_report *report);
void newmark_commit(const gallop_model *model, gallop_state *state, layout *at, double h);
int gauss(const gallop_model *model, gallop_state *state, layout *at, const gallop_inputs *inputs,
          double t, double h, double tolerance, gallop_report *report);
void gauss_commit(const gallop_model *model, gallop_state *state, layout *at, double h);
void gauss_cubic_part(const gallop_model *model, const gallop_state *state, const layout *at,
                      double h, double *part);
double gauss_linear_part(const gallop_model *model, const layout *at, double h, int unknown);
void gauss_read(const gallop_model *model, const gallop_state *state, layout *at, double t);
static inline bool by_gauss(const gallop_model *model)
{
    return model->scene.integrator == GALLOP_GAUSS6;
}
static inline bool by_alpha(const gallop_model *model)
{
    return model->scene.integrator == GALLOP_GENERALISED_ALPHA;
}

/* control.c */
static inline bool by_tolerance(const gallop_model *model)
{
    return model->scene.tolerance > 0.0;
}
static inline bool may_halve(int outcome)
{
    return outcome == GALLOP_NEWTON_STALLED || outcome == GALLOP_NON_FINITE;
}
double newton_tolerance(const gallop_model *model, const gallop_state *state);
void control_start(const gallop_model *model, gallop_state *state, const double *u);
int controlled_march(const gallop_model *model, gallop_state *state, const gallop_inputs *inputs,
                     double until, bool exactly, gallop_report *report);
void control_look(const gallop_model *model, gallop_state *state, layout *at, double t);
void control_return(const gallop_model *model, gallop_state *state, layout *at);

/* tables.c */
int check_tables(const gallop_scene *s, gallop_report *report);

/* observe.c: one node; the span channels whose bits are set in `asked`, the others are left alone
 */
void observe_node(const gallop_model *model, const gallop_state *state, int32_t node,
                  double values[GALLOP_NODE_CHANNELS]);
void observe_span(const gallop_model *model, gallop_state *state, uint32_t asked,
                  double values[GALLOP_SPAN_CHANNELS]);

/* failure.c */
int invalid(gallop_report *report, const char *field, double value, double limit);
int fail(gallop_report *report, int outcome, int element, double time, double value, double limit);

#endif
