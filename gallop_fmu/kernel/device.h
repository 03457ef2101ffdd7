/* Devices: what acts at junctions.  A kind of device is one record: how many junctions it has, and
 * its force, tangent and energy. */
#ifndef GALLOP_DEVICE_H
#define GALLOP_DEVICE_H

#include "element.h"

/* The motion of a junction of a device, from the initial equilibrium. */
typedef struct {
    const double *u, *v, *a; /* (4) [m, rad] and per s, s^2 */
    const double *tower;     /* (3) displacement of the tower's point at the junction [m] */
} device_motion;

typedef struct device_kind {
    const char *name;
    int junctions; /* 1 or 2 */
    /* Checks the parameters, which are finite. */
    int (*check)(const gallop_device *from, gallop_report *report);
    /* Sets the constants of a device from its parameters; the chains are known. */
    void (*prepare)(const gallop_model *model, const gallop_device *from, device *d);
    /* Adds the forces [N, N m] that move the device so, at each junction. */
    void (*add_force)(const device *d, const device_motion y[2], double force[2][4]);
    /* Adds weights.k dF/du + weights.c dF/dv + weights.m dF/da: block (row junction, column
     * junction), by rows. */
    void (*add_tangent)(const device *d, const device_motion y[2], tangent_weights weights,
                        double tangent[2][2][16]);
    /* Energy stored since the initial equilibrium [J]. */
    double (*energy)(const device *d, const device_motion y[2]);
} device_kind;

/* Checks the devices of a scene whose tables can be read. */
int device_check_all(const gallop_scene *s, gallop_report *report);

/* The devices of the scene; its chains are known. */
void device_create_all(gallop_model *model);

/* Adds the forces of all devices to the residual. */
void device_add_forces(const gallop_model *model, const conditions *now, motion y,
                       double *residual);

/* The forces of the devices at one junction [N, N m]. */
void device_forces_at(const gallop_model *model, int index, const conditions *now, motion y,
                      double force[4]);

/* The tangent of one device. */
void device_tangent(const gallop_model *model, const device *d, const conditions *now, motion y,
                    tangent_weights weights, double tangent[2][2][16]);

/* Whether a device resists a displacement of a junction from the initial equilibrium. */
bool device_holds(const gallop_model *model, int index, int unknown);

/* Energy of all devices [J]. */
double device_energy(const gallop_model *model, const conditions *now, motion y);

#endif
