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

/* Of times that increase: the last point at or before t that has one after it; 0: there is none. */
int law_point_before(const double *time, int count, double t);

/* t less whole periods, in the period that begins with the first of two or more times. */
double law_fold(const double *time, int count, double t);

/* First of the times, which may repeat, from t on; infinite: there is none. */
double law_next_time(const double *time, int count, bool repeat, double t);

#endif
