/* Scene: what a model is created of, as tables of kinds.  One table refers to another by index,
 * from 0.  Units are SI and radians; gallop.h describes the axes. */
#ifndef GALLOP_SCENE_H
#define GALLOP_SCENE_H

#include <stdint.h>

/* Kinds of functions of time. */
typedef enum {
    GALLOP_LAW_CONSTANT = 0, /* initial */
    GALLOP_LAW_PULSE = 1, /* initial to peak by a smooth step over [start, start + rise], back over
                             [fall_start, fall_start + fall]; fall_start infinite: stays at the
                             peak */
    GALLOP_LAW_HARMONIC = 2, /* initial + amplitude sin(2 pi frequency (t - start) + phase), initial
                                before start */
    GALLOP_LAW_TABLE = 3     /* linear between points; held outside, or repeated */
} gallop_law_kind;

typedef struct {
    int32_t kind, count; /* a gallop_law_kind; points of a table, else 0 */
    int32_t first;       /* index in `number` of the first time of a table; the times increase, and
                            the values follow them */
    int32_t repeat;      /* of a table outside of its times: 0: it is held; 1: it repeats with the
                            period from the first to the last time, at which it has the value of the
                            first */
    double initial, peak, amplitude;      /* in the unit of the quantity */
    double start, rise, fall_start, fall; /* [s]; rise or fall 0: a jump */
    double frequency, phase;              /* [Hz], [rad] */
} gallop_law;

/* Attack angles outside of a curve: the run ends, the curve continues with the values at its ends,
 * or it repeats every full turn. */
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

/* Tension that would fall below zero: the run ends, or the tension is max(0, T0 + EA eps). */
typedef enum { GALLOP_SLACK_ERROR = 0, GALLOP_SLACK_TENSION_ONLY = 1 } gallop_slack;

/* A conductor with its ice.  Numbers of the conductor are positive; those of the ice may be 0. */
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
    double thermal_expansion;           /* [1/K] */
    gallop_damping translation_damping; /* of u1 u2 u3 */
    gallop_damping twist_damping;       /* of theta */
    int32_t curve;                      /* index; -1: no aerodynamic load */
    int32_t slack;                      /* a gallop_slack */
} gallop_cross_section;

/* Kinds of wind fields: everywhere the same wind towards +x3 (negative speed: -x3), or wind with a
 * direction, a profile and gusts. */
typedef enum { GALLOP_FIELD_UNIFORM = 0, GALLOP_FIELD_VARIED = 1 } gallop_field_kind;

/* Factor f on the speed at the height z above the ground, of the conductor in the initial
 * equilibrium: 1; (z / reference)^exponent; ln(z / roughness) / ln(reference / roughness). */
typedef enum {
    GALLOP_PROFILE_NONE = 0,
    GALLOP_PROFILE_POWER = 1,
    GALLOP_PROFILE_LOGARITHMIC = 2
} gallop_profile;

/* A varied field with the speed U, direction psi (yaw of the wind from +x3 towards +x1), factor f
 * of the profile, and relative gusts gu along the wind, gv horizontally across it (towards +x1 at
 * psi = 0) and gw upwards has the wind
 *
 *     W1 = U f [(1 + gu) sin psi + gv cos psi],    W2 = U f gw,
 *     W3 = U f [(1 + gu) cos psi - gv sin psi].
 *
 * Gusts are given at stations, by x1 of the initial equilibrium, and at times; between, they are
 * linear in both.  Before the first station and beyond the last one they are held. */
typedef struct {
    int32_t kind, law; /* a gallop_field_kind; index: the wind speed [m/s], negative: from the other
                          side.  Of a uniform field the rest is not read */
    int32_t direction; /* index: psi [rad]; -1: 0 */
    int32_t profile;   /* a gallop_profile */
    double profile_parameter; /* exponent, 0 or more; or roughness length [m] */
    double reference_height;  /* at which the speed is given [m], above the roughness length */
    int32_t ground_points;    /* of the ground, 1 or more with a profile; else 0 */
    int32_t first_ground;     /* index in `number`: x1 of each point [m], which increase, then x2 of
                                 each [m]; linear between, held outside */
    int32_t stations, times;  /* of the gusts; 0 stations: there are no gusts */
    int32_t components;       /* of a gust: 1 (gu) or 3 (gu, gv, gw) */
    int32_t first_gust;       /* index in `number`: x1 of each station [m], each time [s], which
                                 increase, then the gusts, (times, stations, components) */
    int32_t repeat;           /* outside of the times: as `repeat` of a gallop_law */
    int32_t reserved;         /* 0 */
} gallop_field;

/* A point where chains end, where stations lie, and devices act.  One at which no chain ends and no
 * station lies is a body: a device gives it mass. */
typedef struct {
    double position[3]; /* in the strung state [m]; of a station it is computed */
    int32_t fixed[4];   /* 1: u1, u2, u3 follow `motion`, theta is 0; 0: free */
    int32_t motion[3];  /* index of a law: displacement of the tower's point [m]; -1: at rest */
    int32_t reserved;
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

/* A point of a chain between its ends, at the left corner of an element.  Stations of a chain
 * follow each other; nodes between two of them, or an end, are equally spaced along the conductor.
 */
typedef struct {
    int32_t chain;    /* index; increases along the table */
    int32_t corner;   /* number of elements of the chain before it; increases along the chain */
    int32_t junction; /* index of the junction there; -1: none */
    int32_t cross_section; /* index, from here to the next station; -1: as before */
    double position;       /* fraction of the conductor's length in the strung state, 0 to 1 */
} gallop_station;

/* What acts at junctions.  Parameters of a
 * spring to the tower: stiffness along x1, x2, x3 [N/m];
 * adjacent span with its insulator string (Liu et al. 2009, eq. 23-24): span [m], tension [N],
 * length [m] and weight [N] of the string;
 * string, a uniform bar with ball joints from the tower's point: unstretched length [m], weight
 * [N], axial stiffness [N/m] and damping [N s/m], torsional stiffness of the clamp against the lean
 * across the line [N m/rad]; place of the tower's point from the clamp in the strung state, along
 * x1, x2, x3 [m], all 0: straight above at the length;
 * V-string, two bars from points of the tower on either side: of each length [m], weight [N],
 * stiffness [N/m] and damping [N s/m]; distance of each point from the middle along x3 [m];
 * frame, rigid in its plane, with arms and clamps at 2 to 8 junctions: mass [kg], stiffness [N/m]
 * and damping [N s/m] of an arm, torsional stiffness [N m/rad] and damping [N m s/rad] of a clamp;
 * yoke, a frame that hangs from a string: the five of a frame, the first four of a string, height
 * of its suspension point above the centre of the frame [m], which may be negative;
 * point mass: mass [kg];
 * pendulum clamped to the conductor: mass [kg], arm [m], angle from straight down towards +x3 at
 * theta = 0 [rad] (theta turns x2 towards x3, so that the arm is then at the angle less theta);
 * damper to the tower's point, or between two junctions: damping along x1, x2, x3 [N s/m],
 * stiffness along x1, x2, x3 [N/m];
 * bar with ball joints between two junctions, unstretched in the strung state, half of its mass at
 * each: stiffness [N/m], mass [kg], damping [N s/m].
 * Springs, dampers and bars count their length from the strung state. */
typedef enum {
    GALLOP_DEVICE_SPRING = 0,
    GALLOP_DEVICE_ADJACENT_SPAN = 1,
    GALLOP_DEVICE_STRING = 2,
    GALLOP_DEVICE_V_STRING = 3,
    GALLOP_DEVICE_FRAME = 4,
    GALLOP_DEVICE_YOKE = 5,
    GALLOP_DEVICE_POINT_MASS = 6,
    GALLOP_DEVICE_PENDULUM = 7,
    GALLOP_DEVICE_DAMPER = 8,
    GALLOP_DEVICE_BAR = 9
} gallop_device_kind;

#define GALLOP_DEVICE_JUNCTIONS 8
#define GALLOP_DEVICE_PARAMETERS 16

typedef struct {
    int32_t kind, junctions;                    /* a gallop_device_kind; number of junctions */
    int32_t junction[GALLOP_DEVICE_JUNCTIONS];  /* indices; -1 beyond */
    double parameter[GALLOP_DEVICE_PARAMETERS]; /* 0 beyond those of the kind */
} gallop_device;

typedef struct {
    int32_t chain, law;              /* indices; the law is a factor on force and torque */
    int32_t evenly_spaced, reserved; /* n points at k / (n + 1) of the conductor's length, or 0: one
                                        at `position` */
    double position;                 /* fraction of the conductor's length, 0 to 1 */
    double force[3], torque;         /* [N], [N m] */
} gallop_load;

/* An interval of a chain that loses its ice: at a time, or at the end of the first step after which
 * a node of it accelerates across the conductor by more than a limit.  From then on it has another
 * cross-section of the same conductor, with less ice; position and velocity are continuous.  Each
 * interval loses its ice once at most. */
typedef struct {
    int32_t chain, corner; /* index; the interval begins at this corner of the chain: 0, or a
                              station that has a cross-section */
    int32_t cross_section; /* index: what the interval has afterwards */
    int32_t reserved;      /* 0 */
    double time;           /* [s]; infinite: not at a time */
    double acceleration;   /* along n2 and n3, above 0 [m/s^2]; infinite: by none */
} gallop_shedding;

/* Time integration: Newmark (beta 1/4, gamma 1/2), Gauss collocation with three stages (order 6),
 * or the generalised alpha method (Chung, Hulbert 1993). */
typedef enum {
    GALLOP_NEWMARK = 0,
    GALLOP_GAUSS6 = 1,
    GALLOP_GENERALISED_ALPHA = 2
} gallop_integrator;

/* Settings of the whole scene. */
typedef struct {
    double gravity;     /* [m/s^2] */
    double air_density; /* [kg/m^3] */
    double seed_vertical, seed_horizontal,
        seed_twist;          /* amplitude of cos(pi x1 / L) on every chain,
                                x1 from its middle [m], [m], [rad] */
    double time_step;        /* [s] */
    double newton_tolerance; /* [m] */
    double tolerance;        /* 0: equal steps; else relative error by which the steps are chosen,
                                Gauss only */
    double spectral_radius;  /* 0 to 1, generalised alpha: factor per step on motion that the step
                                does not resolve */
    int32_t max_newton_iterations; /* 1 or more */
    int32_t max_halvings;          /* 0 to 30 */
    int32_t integrator;            /* a gallop_integrator */
    int32_t start_in_mean_wind;    /* 1: static equilibrium under the wind at t = 0 */
    int32_t laws_only; /* 1: calls with gallop_inputs are refused, and terms that the laws leave
                          inactive are not computed */
    int32_t strung; /* 0: sag and tension are those of the initial equilibrium, with ice; 1: those
                       of a strung state without devices, from which ice, temperature and devices
                       lead to the initial equilibrium */
    int32_t strung_with_ice; /* 1: the strung state has the ice */
    int32_t portable; /* 1: arithmetic without fused multiply-add, which gives the same bits on
                         every x86-64 processor; 0: the fastest that the processor has */
    double strung_temperature, temperature; /* of the strung state; of the equilibrium [degC] */
} gallop_settings;

/* Tables with their counts; NULL where the count is 0.  At least one cross-section, field of wind
 * and chain, and two junctions, the first and the last in line order.  Where one chain ends, each
 * unknown is fixed or held by a device; where several end, the junction couples them.  Memory and
 * work grow with the distance in this table of junctions that a chain or a device joins. */
typedef struct {
    gallop_settings settings;
    int32_t cross_section_count, curve_count, field_count, junction_count, chain_count,
        station_count, device_count, load_count, law_count, shedding_count;
    int64_t number_count;
    const gallop_cross_section *cross_section;
    const gallop_curve *curve;
    const gallop_field *field;
    const gallop_junction *junction;
    const gallop_chain *chain;
    const gallop_station *station;
    const gallop_device *device;
    const gallop_load *load;
    const gallop_law *law;
    const gallop_shedding *shedding;
    const double *number; /* of tables and curves */
} gallop_scene;

#endif
