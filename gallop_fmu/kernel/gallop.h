/* C interface of the galloping kernel.
 *
 * A gallop_scene describes conductors, their supports and what acts on them, as tables of numbers
 * in SI units and radians.  gallop_model_create makes a model of it: mesh, initial equilibrium and
 * coefficient curves.  A model does not change afterwards.  A state is the motion of a model at one
 * instant: one flat block of memory without pointers, which the caller provides.  Its first
 * gallop_saved_size bytes are the whole motion; copied elsewhere and back they restore it bit for
 * bit.  The remaining bytes are scratch memory.
 *
 * Threads: any number of threads may use one model at a time, each with a state of its own.  One
 * thread at a time may use a state, also where it is passed as const.  Two threads may share the
 * runs of one long line: see gallop_run_in_team.
 *
 * Rules: no globals, no printing; memory is allocated by gallop_model_create only.  Arrays of the
 * caller are not kept.  Every function checks its arguments and returns a gallop_outcome, unless
 * stated otherwise.  It returns GALLOP_BAD_CALL and changes nothing but the report for
 * - a pointer that is null or not aligned to its type (models, states, structures and numbers: to
 *   8 bytes), unless null is allowed;
 * - an index or a count that is out of range;
 * - a number that is not finite;
 * - a state that was not started, or belongs to another model;
 * - a processor that does not round to nearest, its default.
 * The lengths of arrays cannot be checked.  A report that is passed is filled in for each outcome.
 *
 * Axes: x1 along the span, x2 up, x3 horizontal.  Wind blows towards +x3.  Twist is right-handed
 * about x1.  A node has four unknowns, one after the other: u1, u2, u3, theta.  A chain of n
 * elements has 2 n + 1 nodes: ends and middles of its elements, from its first junction to its
 * second one.  Indices of nodes and elements start at 0 and count over all chains, in the order of
 * the scene.  `nodes` and `elements` below are the totals.
 */
#ifndef GALLOP_H
#define GALLOP_H

#include "gallop_scene.h"

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

/* Result of a call. */
typedef enum {
    GALLOP_COMPLETED = 0,
    /* Newton's iteration did not converge, although the step was halved as often as allowed */
    GALLOP_NEWTON_STALLED = 1,
    /* a displacement became infinite or not a number */
    GALLOP_NON_FINITE = 2,
    /* an attack angle left the range of its coefficient curve */
    GALLOP_ANGLE_OUT_OF_RANGE = 3,
    /* the tension fell below zero, and the cross-section does not allow slack */
    GALLOP_SLACK = 4,
    /* no static equilibrium was found, although the load was applied in steps */
    GALLOP_EQUILIBRIUM_NOT_FOUND = 5,
    /* a number of the scene is impossible; report.field and report.value give it */
    GALLOP_INVALID_SCENE = 6,
    GALLOP_OUT_OF_MEMORY = 7,
    /* an argument cannot be used; report.field states which one and why */
    GALLOP_BAD_CALL = 8
} gallop_outcome;

/* Result of a call in detail, with the work since the start of the state. */
typedef struct {
    int32_t outcome; /* a gallop_outcome */
    int32_t element; /* where the failure occurred; -1: at no single element */
    int32_t device;  /* the device that has no equilibrium; -1: no single device */
    int32_t reserved;
    double time;           /* of the failure; after success, of the state [s] */
    double value;          /* the value that is out of range, in its unit; 0 or NaN: none */
    double limit;          /* the bound that it exceeds */
    const char *field;     /* the number of an invalid scene, the argument of a bad call, or the
                              quantity of the device; a constant text; NULL: none */
    double lowest_tension; /* of all elements [N]; NaN without a state */
    double largest_turn;   /* rotation of a node about x1 within one sub-step [rad] */
    int64_t steps;         /* completed steps */
    int64_t substeps;      /* their parts, where steps were halved; else the steps */
    int64_t iterations;    /* Newton iterations */
    int64_t refactorisations, halvings;
    int64_t rejections; /* steps that were repeated because their error exceeded the tolerance */
} gallop_report;

/* Values that replace the scene's laws, each linear in time: value + rate * (t - time). */
typedef struct {
    double time;              /* to which the values belong [s] */
    double attack_angle;      /* of the first cross-section at theta = 0 [rad]; its ice, and the
                                 other cross-sections with theirs, turn by the same change */
    double attack_angle_rate; /* [rad/s] */
    int32_t fields;           /* as many as the scene has */
    int32_t junctions;        /* as many as the scene has; 0: all are at rest */
    const double *wind;       /* (2, fields): wind speeds [m/s], of either sign, then their rates
                                 [m/s^2] */
    const double *direction;  /* (2, fields): direction of the wind [rad], then their rates
                                 [rad/s], of varied fields; NULL: the scene's laws hold */
    const double *motion;     /* (2, junctions, 3): displacement of the tower's point at each
                                 junction along x1, x2, x3 [m], then their rates [m/s]; NULL
                                 without junctions */
} gallop_inputs;

/* Terms that a scene may not need.  A model computes a term if anything in the scene, or a host's
 * inputs, can activate it. */
typedef enum {
    GALLOP_AERODYNAMICS = 1, /* wind on a coefficient curve */
    GALLOP_ECCENTRIC_ICE = 2,
    GALLOP_TWIST = 4,  /* the unknown theta */
    GALLOP_LATERAL = 8 /* the unknown u3 */
} gallop_part;

/* Numbers that a model derives from its scene. */
typedef struct {
    /* of the first chain in the initial equilibrium: [m] below the chord at mid-span, [N], [m]
     * along the conductor */
    double sag, horizontal_tension, length;
    double support_force[2][3];     /* static force of the chains on the tower at the first and at
                                       the last junction, along x1, x2, x3 [N] */
    double support_stiffness[2][2]; /* of the devices there, along x1 and x3; 0: rigid [N/m] */
    double translation_damping[2], twist_damping[2]; /* first chain: Rayleigh b1 [1/s], b2 [s] */
    double imbalance; /* largest nodal force that balances an initial state of which both sag and
                         tension were given [N]; else the residual of the equilibrium, of a
                         strung line also at its junctions */
    int32_t parts;    /* active terms, gallop_part flags */
    int32_t threads;  /* that can share a run: see gallop_run_in_team; 1 or 2 */
} gallop_derived;

/* Numbers that a model derives for a chain, in the initial equilibrium. */
typedef struct {
    double sag;                /* [m] below the chord at mid-span */
    double horizontal_tension; /* [N] at the first end */
    double length;             /* [m] along the conductor */
    double end_force[2][3];    /* of the chain on its first and its second end, along x1, x2, x3,
                                  its weight included [N] */
} gallop_derived_chain;

typedef struct gallop_model gallop_model;
typedef struct gallop_state gallop_state;

/* Quantities of a node.  gallop_fmu/foundation/channels.py lists them in the same order. */
typedef enum {
    GALLOP_U1, /* displacement from the initial equilibrium [m], [rad] */
    GALLOP_U2,
    GALLOP_U3,
    GALLOP_THETA,
    GALLOP_V1, /* velocity [m/s], [rad/s] */
    GALLOP_V2,
    GALLOP_V3,
    GALLOP_OMEGA,
    GALLOP_A1, /* acceleration [m/s^2], [rad/s^2] */
    GALLOP_A2,
    GALLOP_A3,
    GALLOP_OMEGA_RATE,
    GALLOP_TENSION,         /* [N] */
    GALLOP_ANGLE_OF_ATTACK, /* of the relative wind [rad] */
    GALLOP_NODE_CHANNELS
} gallop_node_channel;

/* Quantities of a junction: force of the chains on the tower there along x1, x2, x3 [N]. */
typedef enum { GALLOP_F1, GALLOP_F2, GALLOP_F3, GALLOP_JUNCTION_CHANNELS } gallop_junction_channel;

/* Quantities of a device; those that its kind does not have are 0. */
typedef enum {
    GALLOP_TOWER_FORCE_1, /* force of the device on the tower along x1, x2, x3 [N] */
    GALLOP_TOWER_FORCE_2,
    GALLOP_TOWER_FORCE_3,
    GALLOP_PULL,        /* along a string or bar, positive in tension [N]; of a V-string the smaller
                           one of both */
    GALLOP_LEAN_ALONG,  /* of a string, from straight down towards +x1 [rad] */
    GALLOP_LEAN_ACROSS, /* towards +x3 [rad] */
    GALLOP_TURN,        /* of a frame about x1 [rad] */
    GALLOP_DEVICE_CHANNELS
} gallop_device_channel;

/* Quantities of a field. */
typedef enum {
    GALLOP_WIND_SPEED, /* U of a field, without profile and gusts [m/s] */
    GALLOP_FIELD_CHANNELS
} gallop_field_channel;

/* Quantities of the whole system. */
typedef enum {
    GALLOP_KINETIC_ENERGY,    /* [J] */
    GALLOP_POTENTIAL_ENERGY,  /* from the initial equilibrium [J] */
    GALLOP_NEWTON_ITERATIONS, /* of the last step */
    GALLOP_SUBSTEPS,          /* of the last step */
    GALLOP_SYSTEM_CHANNELS
} gallop_system_channel;

/* Objects of which quantities can be observed. */
typedef enum {
    GALLOP_PROBE_NODE = 0,
    GALLOP_PROBE_JUNCTION = 1,
    GALLOP_PROBE_FIELD = 2,
    GALLOP_PROBE_SYSTEM = 3,
    GALLOP_PROBE_DEVICE = 4
} gallop_probe_object;

/* A quantity that a run records or a host reads. */
typedef struct {
    int32_t object;   /* a gallop_probe_object */
    int32_t index;    /* of the node, junction, field or device; 0 of the system */
    int32_t channel;  /* a gallop_node_channel, gallop_junction_channel, ... of the object */
    int32_t reserved; /* 0 */
    double station;   /* x1 at which a field is read [m]; 0 of other objects */
} gallop_probe;

/* ---- The library ---- */

/* Increases when a structure or a function of this header changes. */
#define GALLOP_API_VERSION 6

/* API version of the library.
 *
 * @return  GALLOP_API_VERSION of the header with which it was compiled
 */
GALLOP_API int32_t gallop_api_version(void);

/* Describes a field of the structures of this header, for a binding to compare its own.
 *
 * @param index      Number of the entry: 0, 1, ... over all fields of all structures
 * @param structure  Output: name of the structure, a constant text
 * @param field      Output: name of the field, a constant text; NULL: the entry is the structure
 * @param offset     Output: place in the structure [bytes]
 * @param size       Output: size of the field, or of the structure [bytes]
 * @return           GALLOP_COMPLETED; GALLOP_BAD_CALL beyond the last entry
 */
GALLOP_API int gallop_structure_field(int32_t index, const char **structure, const char **field,
                                      size_t *offset, size_t *size);

/* Compiler that built the library.
 *
 * @return  Its name and version, a constant text
 */
GALLOP_API const char *gallop_build(void);

/* Whether scenes that do not ask for portable arithmetic are computed with AVX-512 and fused
 * multiply-add.
 *
 * @return  1 if the library has that path and the processor can take it, else 0
 */
GALLOP_API int32_t gallop_has_fused_path(void);

/* Checks that the floating-point arithmetic of the calling thread is the one that the kernel needs:
 * rounding to nearest, infinities and NaN.
 *
 * @return  NULL if it is; else what differs, a constant text
 */
GALLOP_API const char *gallop_arithmetic_fault(void);

/* ---- Models ---- */

/* Creates a model: checks the scene, copies it, builds the mesh, finds the initial equilibrium.
 *
 * @param scene   Scene; it is not needed afterwards
 * @param model   Output: the model, for gallop_model_free; NULL if the scene is refused or fails
 * @param report  Output
 * @return        GALLOP_COMPLETED; GALLOP_INVALID_SCENE for an impossible number;
 *                GALLOP_EQUILIBRIUM_NOT_FOUND; GALLOP_OUT_OF_MEMORY; GALLOP_BAD_CALL
 */
GALLOP_API int gallop_model_create(const gallop_scene *scene, gallop_model **model,
                                   gallop_report *report);

/* Frees a model.  No thread may use it any more.  States remain valid for other models of the same
 * scene.
 *
 * @param model  Model from gallop_model_create that was not freed yet; NULL: nothing is done
 */
GALLOP_API void gallop_model_free(gallop_model *model);

/* Numbers that the model derives from its scene.
 *
 * @param model    Model
 * @param derived  Output
 * @return         GALLOP_COMPLETED; GALLOP_BAD_CALL
 */
GALLOP_API int gallop_model_derived(const gallop_model *model, gallop_derived *derived);

/* Numbers that the model derives for one chain.
 *
 * @param model    Model
 * @param chain    Index of the chain
 * @param derived  Output
 * @return         GALLOP_COMPLETED; GALLOP_BAD_CALL
 */
GALLOP_API int gallop_chain_derived(const gallop_model *model, int32_t chain,
                                    gallop_derived_chain *derived);

/* Positions of the nodes in the initial equilibrium.
 *
 * @param model  Model
 * @param x      Output, (nodes, 3): coordinates x1, x2, x3 [m]
 * @return       GALLOP_COMPLETED; GALLOP_BAD_CALL
 */
GALLOP_API int gallop_model_nodes(const gallop_model *model, double *x);

/* Node at mid-span, for a scene of one chain.
 *
 * @param model  Model
 * @return       Its index, which is the number of elements; -1 for a pointer that is no model
 */
GALLOP_API int32_t gallop_middle(const gallop_model *model);

/* Size of a state.  The caller provides the memory, aligned to 8 bytes; its content does not matter
 * before gallop_state_init or gallop_equilibrium.  Steps are fastest if it is aligned to 32 bytes.
 *
 * @param model  Model
 * @return       Size [bytes]; 0 for a pointer that is no model
 */
GALLOP_API size_t gallop_state_size(const gallop_model *model);

/* Size of the part of a state that determines its future.
 *
 * @param model  Model
 * @return       Size [bytes], at most gallop_state_size; 0 for a pointer that is no model
 */
GALLOP_API size_t gallop_saved_size(const gallop_model *model);

/* ---- States ---- */

/* Starts a state: the initial equilibrium, or the static equilibrium if the scene starts in mean
 * wind or a tower's point is displaced; then the seed, and accelerations that satisfy the equations
 * of motion.  Ice whose time is not after `start` falls at the start, from that equilibrium. Static
 * equilibria have the wind without its gusts, accelerations with them.
 *
 * @param model   Model
 * @param state   Output: gallop_state_size bytes; after a failure they are no state
 * @param start   Time [s], finite
 * @param inputs  Values that replace the scene's laws; NULL: the laws hold
 * @param report  Output
 * @return        GALLOP_COMPLETED; GALLOP_BAD_CALL; GALLOP_EQUILIBRIUM_NOT_FOUND, GALLOP_SLACK,
 *                GALLOP_ANGLE_OUT_OF_RANGE or GALLOP_NON_FINITE if there is no such motion
 */
GALLOP_API int gallop_state_init(const gallop_model *model, gallop_state *state, double start,
                                 const gallop_inputs *inputs, gallop_report *report);

/* Starts a state at rest in the static equilibrium under wind, loads and displaced towers, which is
 * found by applying them in steps.  The seed is not added; ice whose time is not after `time` is
 * gone.
 *
 * @param model   Model
 * @param state   Output: gallop_state_size bytes; after a failure they are no state
 * @param time    Time at which laws and inputs are read [s], finite
 * @param inputs  Values that replace the scene's laws; NULL: the laws hold
 * @param report  Output
 * @return        As gallop_state_init
 */
GALLOP_API int gallop_equilibrium(const gallop_model *model, gallop_state *state, double time,
                                  const gallop_inputs *inputs, gallop_report *report);

/* Starts a state in a given motion, with accelerations that satisfy the equations of motion.  The
 * seed is not added; ice whose time is not after `start` is gone.
 *
 * @param model   Model
 * @param state   Output: gallop_state_size bytes; after a failure they are no state
 * @param start   Time [s], finite
 * @param inputs  Values that replace the scene's laws; NULL: the laws hold
 * @param u       Displacements from the initial equilibrium (nodes, 4) [m, rad], finite; where
 *                junctions or the scene prescribe the motion, that is used
 * @param v       Velocities (nodes, 4) [m/s, rad/s]
 * @param report  Output
 * @return        GALLOP_COMPLETED; GALLOP_BAD_CALL; GALLOP_SLACK, GALLOP_ANGLE_OUT_OF_RANGE or
 *                GALLOP_NON_FINITE if there is no such motion
 */
GALLOP_API int gallop_state_place(const gallop_model *model, gallop_state *state, double start,
                                  const gallop_inputs *inputs, const double *u, const double *v,
                                  gallop_report *report);

/* Puts a state at rest in the static equilibrium in still air, without loads, with the ice that it
 * still has and the towers where they are.  Compared with the initial equilibrium, this is how far
 * the ice that has fallen moves the conductors.  After a failure the state is the one before the
 * call.
 *
 * @param model   Model
 * @param state   Started state; its time stays
 * @param report  Output
 * @return        As gallop_state_init
 */
GALLOP_API int gallop_settle(const gallop_model *model, gallop_state *state, gallop_report *report);

/* Time of a state.
 *
 * @param state  State
 * @return       Time [s]; NaN for a block that is no started state
 */
GALLOP_API double gallop_state_time(const gallop_state *state);

/* Times at which the ice of a state fell.
 *
 * @param model  Model
 * @param state  Started state
 * @param time   Output, one for each item of scene.shedding [s]; infinite: the ice has not fallen
 * @return       GALLOP_COMPLETED; GALLOP_BAD_CALL
 */
GALLOP_API int gallop_shedding_times(const gallop_model *model, const gallop_state *state,
                                     double *time);

/* Energy of the ice of a state when it fell, by which the energy of the state was reduced.
 *
 * @param model   Model
 * @param state   Started state
 * @param energy  Output, two for each item of scene.shedding: kinetic and potential energy [J], as
 *                those of a state; 0 if the ice has not fallen
 * @return        GALLOP_COMPLETED; GALLOP_BAD_CALL
 */
GALLOP_API int gallop_shedding_energies(const gallop_model *model, const gallop_state *state,
                                        double *energy);

/* Checks bytes from elsewhere: that they are a state of this model, and that every number in it is
 * in its range.
 *
 * @param model  Model
 * @param state  The first gallop_saved_size bytes of a state
 * @return       GALLOP_COMPLETED if they are; else GALLOP_BAD_CALL
 */
GALLOP_API int gallop_state_check(const gallop_model *model, const gallop_state *state);

/* Advances a state to a given time: in equal steps no longer than the scene's, or by its tolerance.
 * A step that does not converge is halved, as often as the scene allows.  After a failure the state
 * is the one before the call.
 *
 * @param model   Model
 * @param state   Started state
 * @param inputs  Values that replace the scene's laws; NULL: the laws hold
 * @param until   Time to reach [s], finite and after that of the state; at most 1e12 steps away
 * @param report  Output
 * @return        GALLOP_COMPLETED; GALLOP_BAD_CALL; GALLOP_NEWTON_STALLED, GALLOP_NON_FINITE,
 *                GALLOP_ANGLE_OUT_OF_RANGE or GALLOP_SLACK for a step that fails
 */
GALLOP_API int gallop_advance(const gallop_model *model, gallop_state *state,
                              const gallop_inputs *inputs, double until, gallop_report *report);

/* The motion before the last gallop_advance, which gallop_rewind returns to: a state within the
 * block of another.  To save it with the state, copy its first gallop_saved_size bytes; to put it
 * back, write over them, with bytes that gallop_state_check accepts.
 *
 * @param model  Model
 * @param state  Started state
 * @return       The state, possibly one that is not started; NULL: one of the two is no such thing
 */
GALLOP_API gallop_state *gallop_state_before(const gallop_model *model, gallop_state *state);

/* Returns to the motion before the last gallop_advance, which must have been completed.
 *
 * @param model      Model
 * @param state      State that has not been started again or advanced by gallop_run since
 * @param sharpness  Factor on the Newton tolerance from here on, above 0 and at most 1; values
 *                   below 1 suit differences of two runs
 * @return           GALLOP_COMPLETED; GALLOP_BAD_CALL, also without such an advance
 */
GALLOP_API int gallop_rewind(const gallop_model *model, gallop_state *state, double sharpness);

/* Advances a state and observes it, as gallop_observe does: `records` times, each after `every`
 * time steps of the scene. Record i is at the time (first + i + 1) * every * time_step since the
 * start of the run.  With a tolerance the steps end at other times; the records are interpolated
 * within them, and the state is left at or after the last record.  The scene's laws hold.  After a
 * failure the state is the one at the last step that was completed.
 *
 * @param model    Model
 * @param state    Started state
 * @param first    Number of records that earlier calls of this run have made, 0 or more
 * @param records  Number of records, 0 or more
 * @param every    Time steps per record, 1 or more; all records together have at most 1e12
 * @param probe    (probes): quantities to record
 * @param probes   Their number, 0 or more
 * @param values   Output, (records, probes)
 * @param done     Output: number of records made
 * @param report   Output
 * @return         As gallop_advance
 */
GALLOP_API int gallop_run(const gallop_model *model, gallop_state *state, int64_t first,
                          int64_t records, int64_t every, const gallop_probe *probe, int32_t probes,
                          double *values, int64_t *done, gallop_report *report);

/* Two threads that share runs of one line: memory of the caller, filled with zeros at first.  The
 * kernel starts no thread.  A second thread calls gallop_assist before or while the first one calls
 * gallop_run_in_team, once or several times; then the first one calls gallop_dismiss, and joins the
 * second one before the memory is used for anything else. */
typedef struct {
    uint64_t content[32];
} gallop_team;

/* As gallop_run, with the same bits, in up to two threads.  A model can share its runs where
 * derived.threads is 2: a line of several conductors that is long enough.  Else, or while no second
 * thread assists, one thread computes all.
 *
 * @param team  The two threads; NULL: one thread
 */
GALLOP_API int gallop_run_in_team(const gallop_model *model, gallop_state *state, int64_t first,
                                  int64_t records, int64_t every, const gallop_probe *probe,
                                  int32_t probes, double *values, int64_t *done, gallop_team *team,
                                  gallop_report *report);

/* Computes what the other thread of a team shares, until gallop_dismiss.  Between pieces of work it
 * waits without rest, so it needs a processor of its own to be of use.
 *
 * @param team  The team
 * @return      Number of pieces of which this thread has computed a half; -1: the pointer cannot be
 *              used
 */
GALLOP_API int64_t gallop_assist(gallop_team *team);

/* Ends gallop_assist in the other thread.  No run may be under way.
 *
 * @param team  The team
 * @return      GALLOP_COMPLETED; GALLOP_BAD_CALL
 */
GALLOP_API int gallop_dismiss(gallop_team *team);

/* Observes a state.  Only quantities that a probe names are computed.  The force of a junction and
 * the energies are computed once for all of their probes.
 *
 * @param model   Model
 * @param state   Started state; its scratch memory is used
 * @param probe   (probes): quantities to observe
 * @param probes  Their number, 0 or more
 * @param values  Output, (probes)
 * @return        GALLOP_COMPLETED; GALLOP_BAD_CALL, also for a probe of an object, an index or a
 *                channel that does not exist, or with a station that its object does not have
 */
GALLOP_API int gallop_observe(const gallop_model *model, gallop_state *state,
                              const gallop_probe *probe, int32_t probes, double *values);

/* Observes the initial equilibrium of a model: in still air, without loads, all towers at rest.
 *
 * @param model   Model
 * @param probe   (probes): quantities of junctions and devices
 * @param probes  Their number, 0 or more
 * @param values  Output, (probes)
 * @return        GALLOP_COMPLETED; GALLOP_BAD_CALL, also for a probe of another object, or of an
 *                index or a channel that does not exist
 */
GALLOP_API int gallop_observe_equilibrium(const gallop_model *model, const gallop_probe *probe,
                                          int32_t probes, double *values);

#ifdef __cplusplus
}
#endif
#endif
