/* Quantities in time: value and derivatives of a law. */
#ifndef GALLOP_LAW_H
#define GALLOP_LAW_H

#include "gallop.h"

#include <stdbool.h>

/* A law of a scene, and the points of its table. */
typedef struct {
    gallop_law of;
    const double *time, *value; /* (of.count) */
} law;

/* `number`: the numbers of the scene. */
law law_from(const gallop_law *of, const double *number);

bool law_always_zero(const law *l);
double law_value(const law *l, double t);
double law_rate(const law *l, double t);
double law_second(const law *l, double t);

/* First time from t on at which the law or a derivative of it jumps; infinite: none. */
double law_next_kink(const law *l, double t);

#endif
