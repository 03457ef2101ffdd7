/* The inputs at one instant: wind, attack angle, motion of the supports. */
#ifndef GALLOP_CONDITIONS_H
#define GALLOP_CONDITIONS_H

#include "model.h"

/* The inputs at one instant. */
typedef struct {
    double wind, attack;
    double c2, c3;      /* first mass moments of the ice at theta = 0, turned to the attack angle */
    double load_factor; /* 1 but while a static load is stepped up */
    double position[2][3], velocity[2][3], acceleration[2][3];
} conditions;

void conditions_at(const gallop_model *model, double t, const gallop_inputs *inputs,
                   conditions *now);
void conditions_rotate_moments(const gallop_scene *scene, double attack, double *c2, double *c3);
bool conditions_are_finite(const conditions *now);

#endif
