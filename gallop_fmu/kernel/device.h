/* Devices: what acts at junctions.  A kind of device is one record: how many junctions it has, and
 * its force, tangent and energy.  device_KIND.c has each kind. */
#ifndef GALLOP_DEVICE_H
#define GALLOP_DEVICE_H

#include "element.h"
#include "report.h"

/* The motion of a junction of a device, from the initial equilibrium. */
typedef struct {
    const double *u, *v, *a; /* (4) [m, rad] and per s, s^2 */
    const double *moved;     /* (3) from the strung state to the initial equilibrium [m] */
    /* (3) displacement of the tower's point at the junction [m], and per s, s^2 */
    const double *tower, *tower_velocity, *tower_acceleration;
} device_motion;

/* A block of the tangent: rows and columns u1 u2 u3 theta, by rows. */
typedef double device_block[16];

typedef struct device_kind {
    const char *name;  /* NULL: there is no such kind */
    int least, most;   /* number of junctions */
    bool leaves_plane; /* it can move a junction across the line or turn it */
    bool prestressed;  /* it has no displacement under what it holds in the strung state */
    bool holds;        /* it holds its junctions whatever its pull is */
    /* Checks the parameters, which are finite. */
    int (*check)(const gallop_device *from, gallop_report *report);
    /* Sets the constants of a device from its parameters; the strung state is known. */
    void (*prepare)(const gallop_model *model, const gallop_device *from, device *d);
    /* Adds the forces [N, N m] that move the device so, at each junction: those of its stiffness,
     * its damping and its mass, and against its weight. */
    void (*add_force)(const device *d, const device_motion *y, double force[][4]);
    /* Adds weights.k dF/du + weights.c dF/dv + weights.m dF/da: blocks by row junction, then by
     * column junction. */
    void (*add_tangent)(const device *d, const device_motion *y, tangent_weights weights,
                        device_block *tangent);
    /* Kinetic energy, and potential energy stored since the strung state [J]; each is added. */
    void (*add_energy)(const device *d, const device_motion *y, double *kinetic, double *potential);
    /* Force on the tower along x1 x2 x3 [N]; of a prestressed device without the part that holds
     * the strung state.  NULL: it does not reach the tower. */
    void (*on_tower)(const device *d, const device_motion *y, double force[3]);
    /* A gallop_device_channel beyond those of the tower; NULL: it has none. */
    double (*observe)(const device *d, const device_motion *y, int channel);
} device_kind;

/* The kinds, in files of their own. */
extern const device_kind device_spring, device_adjacent_span, device_string, device_v_string,
    device_frame, device_yoke, device_point_mass, device_pendulum, device_damper,
    device_interphase_spacer;

/* A parameter of a kind: what it is called, and whether it may be 0; it is not negative. */
typedef struct {
    const char *name;
    bool positive;
} device_parameter;

/* Checks the first parameters of a device. */
static inline int device_check_parameters(const gallop_device *d, const device_parameter *parameter,
                                          int count, gallop_report *report)
{
    for (int i = 0; i < count; i++) {
        const double value = d->parameter[i];
        if (parameter[i].positive ? !(value > 0.0) : !(value >= 0.0))
            return report_invalid(report, parameter[i].name, value, 0.0);
    }
    return GALLOP_COMPLETED;
}

/* Checks the devices of a scene whose tables can be read. */
int device_check_all(const gallop_scene *s, gallop_report *report);

/* The devices of the scene; its chains are known. */
void device_create_all(gallop_model *model);

/* Sets the constants of all devices; the chains are in the strung state. */
void device_prepare_all(gallop_model *model);

/* Whether a device needs the unknowns u3 and theta. */
bool device_leaves_plane(const gallop_model *model);

/* Adds the forces of all devices to the residual of a half. */
void device_add_forces(const gallop_model *model, int half, const conditions *now, motion y,
                       double *residual);

/* The forces of one device [N, N m]. */
void device_force(const gallop_model *model, const device *d, const conditions *now, motion y,
                  double force[GALLOP_DEVICE_JUNCTIONS][4]);

/* The force of the devices on the tower at one junction [N]. */
void device_tower_force(const gallop_model *model, int index, const conditions *now, motion y,
                        double force[3]);

/* The tangent of one device: junctions x junctions blocks. */
void device_tangent(const gallop_model *model, const device *d, const conditions *now, motion y,
                    tangent_weights weights,
                    device_block tangent[GALLOP_DEVICE_JUNCTIONS * GALLOP_DEVICE_JUNCTIONS]);

/* Forces (junctions, 4) of one device in a motion u, v (junctions, 4) of its junctions, the towers
 * at rest, and their derivatives by u and v. */
void device_load(const gallop_model *model, const device *d, const double *u, const double *v,
                 double *force, device_block *by_u, device_block *by_v);

/* Whether a device resists a displacement of a junction from the initial equilibrium. */
bool device_holds(const gallop_model *model, int index, int unknown);

/* Whether a device gives mass to a junction. */
bool device_gives_mass(const gallop_model *model, int index, int unknown);

/* Adds the energy of one device since the initial equilibrium [J]. */
void device_add_energy(const gallop_model *model, const device *d, const conditions *now, motion y,
                       double *kinetic, double *potential);

/* Adds the energy of all devices since the initial equilibrium [J]. */
void device_add_energies(const gallop_model *model, const conditions *now, motion y,
                         double *kinetic, double *potential);

/* A gallop_device_channel of one device. */
double device_value(const gallop_model *model, int index, const conditions *now, motion y,
                    int channel);

/* The same in the initial equilibrium. */
double device_value_at_rest(const gallop_model *model, int index, int channel);

/* The force of the devices on the tower at one junction in the initial equilibrium [N]. */
double device_tower_force_at_rest(const gallop_model *model, int index, int axis);

#endif
