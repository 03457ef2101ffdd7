/* An insulator string: a uniform bar with ball joints that hangs from a point of the tower. */
#ifndef GALLOP_DEVICE_STRING_H
#define GALLOP_DEVICE_STRING_H

#include "device_bar.h"

typedef struct {
    bar bar;
    double weight, mass; /* [N], [kg] */
    double strung[3];    /* its lower end less the tower's point, in the strung state [m] */
} insulator;

/* The lower end and the tower's point: displacement from the strung state, velocity, acceleration.
 */
typedef struct {
    const double *place, *velocity, *acceleration;
    const double *tower, *tower_velocity, *tower_acceleration;
} insulator_motion;

/* Force that moves the lower end so [N]. */
void device_string_force(const insulator *s, const insulator_motion *y, double force[3]);

/* Derivatives of that force by place and by velocity, (3, 3) by rows; the one by acceleration is a
 * third of the mass. */
void device_string_slopes(const insulator *s, const insulator_motion *y, double by_place[9],
                          double by_velocity[9]);

void device_string_add_energy(const insulator *s, const insulator_motion *y, double *kinetic,
                              double *potential);

/* Adds the force on the tower [N]. */
void device_string_add_on_tower(const insulator *s, const insulator_motion *y, double force[3]);

/* From the tower's point to the lower end [m]. */
void device_string_vector(const insulator *s, const insulator_motion *y, double r[3]);

/* Pull [N]. */
double device_string_pull(const insulator *s, const insulator_motion *y);

/* Lean along or across the line (a gallop_device_channel) of a vector from straight down [rad]. */
double device_string_lean(const double r[3], int channel);

#endif
