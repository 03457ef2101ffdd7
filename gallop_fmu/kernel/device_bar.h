/* A straight elastic bar with ball joints between two points.  Its vector r leads from the first
 * point to the second. */
#ifndef GALLOP_DEVICE_BAR_H
#define GALLOP_DEVICE_BAR_H

#include "device.h"

typedef struct {
    double length;             /* unstretched [m] */
    double stiffness, damping; /* along it [N/m], [N s/m] */
} bar;

/* Pull (tension) [N] for r and its rate, and the unit vector along r. */
double device_bar_pull(const bar *b, const double r[3], const double rate[3], double along[3]);

/* Derivatives of pull * along by r and by its rate, (3, 3) by rows. */
void device_bar_slopes(const bar *b, const double r[3], const double rate[3], double by_r[9],
                       double by_rate[9]);

/* Strain energy [J]. */
double device_bar_energy(const bar *b, const double r[3]);

#endif
