/* The whole public C face of the galloping kernel.
 *
 * A span is described by one gallop_scene (plain numbers, SI, radians).  gallop_model_create turns
 * it into an immutable model (mesh, initial equilibrium, aerodynamic curve); any number of states
 * can run on one model, from any number of threads, each state by one thread at a time.  A state is
 * one flat block without pointers: copying its first gallop_saved_size bytes saves it, copying them
 * back restores it, bit for bit; the rest is scratch memory.
 *
 * Rules: no globals, no allocation after create, no printing, caller's arrays are never kept. Every
 * call checks its arguments and returns a gallop_outcome: GALLOP_BAD_CALL, and nothing is changed,
 * for a pointer that is null or not aligned (a model, a state, structures and numbers: to 8 bytes),
 * an index or count out of range, a number that is not finite, a state that was not started or
 * belongs to another model.  Only lengths of arrays cannot be checked.  A report is filled in
 * whatever the outcome.  The processor must round to nearest, its default.
 *
 * Axes: x1 along the span, x2 up, x3 horizontal; wind blows towards +x3; twist is right-handed
 * about x1.  Four unknowns a node, interleaved: u1 u2 u3 theta.  A mesh of n elements has 2 n + 1
 * nodes; all can be observed where only half of the span is computed, too.
 */
#ifndef GALLOP_H
#define GALLOP_H

#include <stddef.h>
#include <stdint.h>

#if defined(_WIN32)
#define GALLOP_API __declspec(dllexport)
#else
#define GALLOP_API __attribute__((visibility("default")))
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef enum {
    GALLOP_COMPLETED = 0,
    GALLOP_NEWTON_STALLED = 1, /* no convergence although the step was halved as often as allowed */
    GALLOP_NON_FINITE = 2,     /* a displacement became infinite or not a number */
    GALLOP_ANGLE_OUT_OF_RANGE =
        3,            /* attack angle left the validity range of the aerodynamic curve */
    GALLOP_SLACK = 4, /* a cable cannot carry compression: tension fell below zero */
    GALLOP_EQUILIBRIUM_NOT_FOUND =
        5,                    /* static Newton iteration failed although the load was stepped */
    GALLOP_INVALID_SCENE = 6, /* a number of the scene is impossible; report.value holds it */
    GALLOP_OUT_OF_MEMORY = 7,
    GALLOP_BAD_CALL = 8 /* an argument cannot be used; report.field says which one and why */
} gallop_outcome;

/* What a call has to say: filled in by every function that takes one. */
typedef struct {
    int32_t outcome;
    int32_t element;       /* 0-based, -1 where none */
    double time;           /* [s] */
    double value, limit;   /* the offending value and what is allowed */
    const char *field;     /* which number of an invalid scene or argument of a bad call, a constant
                              text; else NULL */
    double lowest_tension; /* [N] since the start of the state; NaN where there is no state */
    double largest_turn;   /* [rad] of a node about the span within one sub-step, since the start of
                              the state */
    int64_t steps, substeps, iterations, refactorisations, halvings,
        rejections; /* since the start of the state */
} gallop_report;

/* ---- The scene: tables of kinds.  One table refers to another by index. ---- */

/* A quantity in time. */
typedef enum {
    GALLOP_LAW_CONSTANT = 0, /* initial */
    GALLOP_LAW_PULSE = 1, /* initial to peak by a smooth step over [start, start + rise], back over
                             [fall_start, fall_start + fall]; fall_start infinite: stays at the
                             peak */
    GALLOP_LAW_HARMONIC = 2, /* initial + amplitude sin(2 pi frequency (t - start) + phase), initial
                                before start */
    GALLOP_LAW_TABLE = 3     /* linear between points, held outside */
} gallop_law_kind;

typedef struct {
    int32_t kind, count; /* a gallop_law_kind; points of a table, else 0 */
    int32_t first;       /* index in `number` of the first time of a table; the times increase, and
                            the values follow them */
    int32_t reserved;    /* 0 */
    double initial, peak, amplitude;      /* in the unit of the quantity */
    double start, rise, fall_start, fall; /* [s]; rise or fall 0: a jump */
    double frequency, phase;              /* [Hz], [rad] */
} gallop_law;

/* What holds for attack angles outside of a curve: the run ends, the curve goes on with the values
 * at its ends, or it repeats every full turn. */
typedef enum {
    GALLOP_OUTSIDE_ERROR = 0,
    GALLOP_OUTSIDE_HOLD = 1,
    GALLOP_OUTSIDE_PERIODIC = 2
} gallop_outside;

/* A coefficient curve: cubics on pieces of the attack angle.  In `number`, from `first` on:
 * pieces + 1 breakpoints that increase [rad]; the origin of each piece [rad]; 12 coefficients of
 * each piece, 4 c + k for the power k of (alpha - origin), c = 0 lift, 1 drag, 2 moment. */
typedef struct {
    int32_t pieces, outside; /* 1 or more; a gallop_outside */
    int32_t first, reserved;
} gallop_curve;

/* Two damping ratios at two frequencies [Hz], the first the lower one; frequencies 0: undamped. */
typedef struct {
    double low_ratio, low_frequency, high_ratio, high_frequency;
} gallop_damping;

/* What follows where the tension would fall below zero: the run ends, or T = max(0, T0 + EA eps).
 */
typedef enum { GALLOP_SLACK_ERROR = 0, GALLOP_SLACK_TENSION_ONLY = 1 } gallop_slack;

/* A conductor with its ice; all positive, but those of the ice, which may be 0. */
typedef struct {
    double diameter;                    /* [m] */
    double mass;                        /* [kg/m] without ice */
    double axial_stiffness;             /* [N] */
    double torsional_stiffness;         /* [N m^2] */
    double torsional_inertia;           /* [kg m] without ice */
    double ice_mass;                    /* [kg/m] */
    double ice_torsional_inertia;       /* [kg m] */
    double first_moment_x2;             /* int rho x2 dA (S_x3 of Liu et al. 2009) [kg] */
    double first_moment_x3;             /* int rho x3 dA (S_x2) [kg] */
    double first_moment_angle;          /* attack angle at which these are given [rad] */
    double attack_angle;                /* of the ice at theta = 0 [rad] */
    double reference_radius;            /* r of eq. (21) [m]; 0: half the diameter */
    gallop_damping translation_damping; /* of u1 u2 u3 */
    gallop_damping twist_damping;       /* of theta */
    int32_t curve;                      /* index; -1: no aerodynamic load */
    int32_t slack;                      /* a gallop_slack */
} gallop_cross_section;

/* A field of wind towards +x3. */
typedef enum { GALLOP_FIELD_UNIFORM = 0 } gallop_field_kind;

typedef struct {
    int32_t kind; /* a gallop_field_kind */
    int32_t law;  /* index: the wind speed [m/s] */
} gallop_field;

/* A point where chains end and devices act. */
typedef struct {
    double position[3]; /* in the initial equilibrium [m] */
    int32_t fixed[3];   /* 1: u1, u2, u3 follow `motion`; theta is always fixed at 0 */
    int32_t
        motion[3]; /* index of a law: displacement of the tower's point [m]; -1: it is at rest */
} gallop_junction;

/* A conductor between two junctions, the first one at the smaller x1.  Of sag and horizontal
 * tension at least one is positive; if both are, the parabola with both is held as initial state.
 */
typedef struct {
    int32_t cross_section, field; /* indices */
    int32_t junction[2];          /* indices */
    int32_t elements;             /* 2 to 1000000 */
    int32_t reserved;
    double sag;                /* below the chord at its middle [m]; 0: not given */
    double horizontal_tension; /* [N]; 0: not given */
} gallop_chain;

/* What acts at junctions.  Parameters of a
 * spring to the tower: stiffness along x1, x2, x3 [N/m];
 * adjacent span with its insulator string (Liu et al. 2009, eq. 23-24): span [m], tension [N],
 * length [m] and weight [N] of the string. */
typedef enum { GALLOP_DEVICE_SPRING = 0, GALLOP_DEVICE_ADJACENT_SPAN = 1 } gallop_device_kind;

#define GALLOP_DEVICE_PARAMETERS 12

typedef struct {
    int32_t kind, reserved; /* a gallop_device_kind */
    int32_t junction[2];    /* indices; the second is -1 where the kind has one */
    double parameter[GALLOP_DEVICE_PARAMETERS]; /* 0 beyond those of the kind */
} gallop_device;

typedef struct {
    int32_t chain, law;              /* indices; the law is a factor on force and torque */
    int32_t evenly_spaced, reserved; /* n points at k / (n + 1) of the conductor's length, or 0: one
                                        at `position` */
    double position;                 /* fraction of the conductor's length, 0 to 1 */
    double force[3], torque;         /* [N], [N m] */
} gallop_load;

/* Time integration: Newmark (beta 1/4, gamma 1/2), Gauss collocation with three stages (order 6),
 * or the generalised alpha method (Chung, Hulbert 1993). */
typedef enum {
    GALLOP_NEWMARK = 0,
    GALLOP_GAUSS6 = 1,
    GALLOP_GENERALISED_ALPHA = 2
} gallop_integrator;

/* What is one for the whole scene. */
typedef struct {
    double gravity;     /* [m/s^2] */
    double air_density; /* [kg/m^3] */
    double seed_vertical, seed_horizontal,
        seed_twist;          /* amplitude of cos(pi x1 / L) on every chain,
                                x1 from its middle [m], [m], [rad] */
    double time_step;        /* [s] */
    double newton_tolerance; /* [m] */
    double tolerance;        /* 0: equal steps; else relative error that the steps are chosen for,
                                Gauss only */
    double spectral_radius;  /* 0 to 1, generalised alpha: factor a step on motion that no step
                                resolves */
    int32_t max_newton_iterations; /* 1 or more */
    int32_t max_halvings;          /* 0 to 30 */
    int32_t integrator;            /* a gallop_integrator */
    int32_t start_in_mean_wind;    /* 1: static equilibrium under the wind at t = 0 */
    int32_t laws_only; /* 1: a call with gallop_inputs is refused, and what the laws leave at rest
                          is not computed */
    int32_t reserved;
} gallop_settings;

/* Arrays with their counts; NULL where the count is 0.  One chain, its junctions 0 and 1, at least
 * one cross-section and one field. */
typedef struct {
    gallop_settings settings;
    int32_t cross_section_count, curve_count, field_count, junction_count, chain_count,
        device_count, load_count, law_count;
    int64_t number_count;
    const gallop_cross_section *cross_section;
    const gallop_curve *curve;
    const gallop_field *field;
    const gallop_junction *junction;
    const gallop_chain *chain;
    const gallop_device *device;
    const gallop_load *load;
    const gallop_law *law;
    const double *number; /* of tables and curves */
} gallop_scene;

/* Inputs that a co-simulation host sets instead of the scene's laws: value + rate * (t - time). */
typedef struct {
    double time;
    double wind_speed, attack_angle, support[2][3];
    double wind_speed_rate, attack_angle_rate, support_rate[2][3];
} gallop_inputs;

/* What a scene may not need.  A model computes a part if anything in the scene, or a host's inputs,
 * can wake it. */
typedef enum {
    GALLOP_AERODYNAMICS = 1, /* wind on a coefficient curve */
    GALLOP_ECCENTRIC_ICE = 2,
    GALLOP_TWIST = 4,  /* the unknown theta */
    GALLOP_LATERAL = 8 /* the unknown u3 */
} gallop_part;

/* Numbers that the model derived from the scene. */
typedef struct {
    double sag, horizontal_tension,
        length;                 /* of the initial equilibrium: [m], [N], [m] along the conductor */
    double support_force[2][3]; /* static force of the cable on the tower [N] */
    double support_stiffness[2][2];                  /* x1, x3; 0 where rigid [N/m] */
    double translation_damping[2], twist_damping[2]; /* Rayleigh b1 [1/s], b2 [s] */
    double imbalance;        /* largest nodal force that holds a 'held' initial state [N] */
    int32_t parts, reserved; /* gallop_part flags of what is computed */
} gallop_derived;

typedef struct gallop_model gallop_model;
typedef struct gallop_state gallop_state;

/* What can be observed at a node, and once per state.  The order is the contract with the binding.
 */
typedef enum {
    GALLOP_U1,
    GALLOP_U2,
    GALLOP_U3,
    GALLOP_THETA,
    GALLOP_V1,
    GALLOP_V2,
    GALLOP_V3,
    GALLOP_OMEGA,
    GALLOP_A1,
    GALLOP_A2,
    GALLOP_A3,
    GALLOP_OMEGA_RATE,
    GALLOP_TENSION,
    GALLOP_ANGLE_OF_ATTACK,
    GALLOP_NODE_CHANNELS
} gallop_node_channel;

typedef enum {
    GALLOP_WIND_SPEED,
    GALLOP_LEFT_F1,
    GALLOP_LEFT_F2,
    GALLOP_LEFT_F3,
    GALLOP_RIGHT_F1,
    GALLOP_RIGHT_F2,
    GALLOP_RIGHT_F3,
    GALLOP_KINETIC_ENERGY,
    GALLOP_POTENTIAL_ENERGY,
    GALLOP_NEWTON_ITERATIONS,
    GALLOP_SUBSTEPS,
    GALLOP_SPAN_CHANNELS
} gallop_span_channel;

/* ---- Functions ---- */

/* Increases when a structure or a function of this header changes. */
#define GALLOP_API_VERSION 2

/* The API version that the library was compiled with. */
GALLOP_API int32_t gallop_api_version(void);

/* Describes a field of the structures of this header, for a binding to compare its own.
 *
 * index      counts from 0 over all fields of all structures
 * structure  out: name of the structure
 * field      out: name of the field; NULL for an entry that gives the size of the structure
 * offset     out: place in the structure [bytes]
 * size       out: size of the field, or of the structure [bytes]
 *
 * Returns GALLOP_COMPLETED; GALLOP_BAD_CALL beyond the last field, or if a pointer is NULL. */
GALLOP_API int gallop_structure_field(int32_t index, const char **structure, const char **field,
                                      size_t *offset, size_t *size);

GALLOP_API const char *gallop_build(void); /* compiler and its version */
/* Why floating-point numbers do not work as the formulas need: a constant text; NULL: they do. */
GALLOP_API const char *gallop_arithmetic_fault(void);

GALLOP_API int gallop_model_create(const gallop_scene *scene, gallop_model **model,
                                   gallop_report *report);
GALLOP_API void gallop_model_free(gallop_model *model);
GALLOP_API int gallop_model_derived(const gallop_model *model, gallop_derived *derived);
GALLOP_API int gallop_model_nodes(const gallop_model *model,
                                  double *x); /* (nodes, 3) initial positions [m] */

/* -1 or 0 where the model is none. */
GALLOP_API int32_t gallop_middle(const gallop_model *model);    /* index of the mid-span node */
GALLOP_API size_t gallop_state_size(const gallop_model *model); /* bytes that the caller provides */
GALLOP_API size_t
gallop_saved_size(const gallop_model *model); /* of them, those that save a state */

/* The state at t = start: equilibrium, seed, consistent accelerations.  inputs NULL: the scene's
 * laws. */
GALLOP_API int gallop_state_init(const gallop_model *model, gallop_state *state, double start,
                                 const gallop_inputs *inputs, gallop_report *report);
GALLOP_API double
gallop_state_time(const gallop_state *state); /* NaN where the state was not started */
/* GALLOP_BAD_CALL unless the first gallop_saved_size bytes can be a state of this model: for bytes
 * from elsewhere. */
GALLOP_API int gallop_state_check(const gallop_model *model, const gallop_state *state);

/* Steps to `until` in equal steps no longer than the scene's, or by its tolerance; on failure the
 * state is what it was before. */
GALLOP_API int gallop_advance(const gallop_model *model, gallop_state *state,
                              const gallop_inputs *inputs, double until, gallop_report *report);

/* The motion at the start of the last gallop_advance, which must have been completed;
 * GALLOP_BAD_CALL if none was since the state was started or gallop_run went on with it.  A
 * `sharpness` below 1 (and above 0) tightens the Newton tolerance from here on, for differences of
 * two runs. */
GALLOP_API int gallop_rewind(const gallop_model *model, gallop_state *state, double sharpness);

/* `records` times: advance by `every` time steps of the scene and observe, at (first + i + 1) *
 * every * time_step. Under a tolerance the steps end where they like, the records are read within
 * them, and the state is left at or after the last record. node_values (records, channels, nodes),
 * span_values (records, span_channels); *done counts what is filled.  Energies and support forces
 * are computed for records that ask for them. */
GALLOP_API int gallop_run(const gallop_model *model, gallop_state *state, int64_t first,
                          int64_t records, int64_t every, const int32_t *channel, int32_t channels,
                          const int32_t *node, int32_t nodes, const int32_t *span_channel,
                          int32_t span_channels, double *node_values, double *span_values,
                          int64_t *done, gallop_report *report);

GALLOP_API int gallop_observe_node(const gallop_model *model, const gallop_state *state,
                                   int32_t node, double values[GALLOP_NODE_CHANNELS]);
/* Force of the cable on the left tower along x1, x2, x3, then on the right one [N]. */
GALLOP_API int gallop_support_forces(const gallop_model *model, gallop_state *state,
                                     double force[6]);
GALLOP_API int gallop_observe_span(const gallop_model *model, gallop_state *state,
                                   double values[GALLOP_SPAN_CHANNELS]);

/* For tests and the modal toolkit, of a whole span: the free-body residual (no supports) of a
 * motion u, v, a (4 a node), and the element tangents k dR/du + c dR/dv + m dR/da as (elements, 12,
 * 12).  Of `work` only scratch memory is used. */
GALLOP_API int gallop_residual(const gallop_model *model, gallop_state *work, double time,
                               const gallop_inputs *inputs, const double *u, const double *v,
                               const double *a, double *residual);
GALLOP_API int gallop_tangent(const gallop_model *model, gallop_state *work, double time,
                              const gallop_inputs *inputs, const double *u, const double *v,
                              const double *a, double k, double c, double m, double *tangent);

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
 * @param model         The span.
 * @param element       Element whose conductor and curve apply, 0 to elements - 1.
 * @param attack_angle  alpha0 [rad], finite.
 * @param count         Number of sections, 0 or more.
 * @param given         (5, count): theta [rad], v2 along n2 [m/s], v3 along x3 [m/s], omega
 *                      [rad/s], U [m/s]; all finite.
 * @param load          Output, (3, count): F2 along n2 [N/m], F3 along x3 [N/m], M about x1 [N].
 * @param slopes        Output, (4, 3, count): derivatives of the load by theta, v2, v3 and omega
 *                      (by U: minus that by v3); NULL: they are not computed.
 * @param angle         Output, (count): attack angle alpha [rad].
 * @param excess        Output, (count): by how much [rad] alpha, less whole turns, is beyond the
 *                      last breakpoint of the curve (positive) or before the first one (negative),
 *                      where a simulation would end with GALLOP_ANGLE_OUT_OF_RANGE; else 0.
 * @return              GALLOP_COMPLETED; GALLOP_BAD_CALL for an argument that cannot be used.
 */
GALLOP_API int gallop_aero_load(const gallop_model *model, int32_t element, double attack_angle,
                                int32_t count, const double *given, double *load, double *slopes,
                                double *angle, double *excess);

/* Sections at which inertia, ice and wind are integrated: the three-point Gauss abscissae of each
 * element, from left to right.
 *
 * @param model   The span.
 * @param shape   Output, (3, 3): shape function of each node at each abscissa of an element.
 * @param length  Output, (elements, 3): length of conductor [m] that belongs to each section, its
 *                weight in an integral over the arc length.
 * @param normal  Output, (elements, 3, 2): n2 = e3 x t, the upward normal of the conductor in its
 *                vertical plane, along x1 and x2.
 * @return        GALLOP_COMPLETED; GALLOP_BAD_CALL for an argument that cannot be used.
 */
GALLOP_API int gallop_sections(const gallop_model *model, double shape[9], double *length,
                               double *normal);

/* Points at which tension and twisting moment are integrated: the two-point Gauss abscissae of each
 * element, from left to right.
 *
 * @param model        The span.
 * @param length       Output, (elements, 2): length of conductor [m] that belongs to each point.
 * @param tangent      Output, (elements, 2, 3): unit tangent dX/dS of the initial equilibrium.
 * @param shape_slope  Output, (elements, 2, 3): derivative of each node's shape function by the arc
 *                     length S [1/m].
 * @return             GALLOP_COMPLETED; GALLOP_BAD_CALL for an argument that cannot be used.
 */
GALLOP_API int gallop_strain_points(const gallop_model *model, double *length, double *tangent,
                                    double *shape_slope);

/* Upward normal of the conductor at the nodes, of the mean direction where two elements meet: the
 * direction of the v2 from which the attack angle at a node follows.
 *
 * @param model   The span.
 * @param normal  Output, (nodes, 2): n2 along x1 and x2.
 * @return        GALLOP_COMPLETED; GALLOP_BAD_CALL for an argument that cannot be used.
 */
GALLOP_API int gallop_node_normals(const gallop_model *model, double *normal);

/* Initial disturbance of the scene, which gallop_state_init adds to the equilibrium.
 *
 * @param model  The span.
 * @param u      Output, (nodes, 4): displacements u1 u2 u3 [m] and twist [rad].
 * @return       GALLOP_COMPLETED; GALLOP_BAD_CALL for an argument that cannot be used.
 */
GALLOP_API int gallop_seed(const gallop_model *model, double *u);

/* Puts the state at rest into static equilibrium under the inputs at `time`, found by load
 * stepping. */
GALLOP_API int gallop_equilibrium(const gallop_model *model, gallop_state *state, double time,
                                  const gallop_inputs *inputs, gallop_report *report);

#ifdef __cplusplus
}
#endif
#endif
