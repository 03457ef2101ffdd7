/* Quantities in time: value and derivatives of a law. */
#ifndef GALLOP_LAW_H
#define GALLOP_LAW_H

#include "gallop.h"
#include <stdbool.h>

bool law_always_zero(const gallop_law *law);
double law_value(const gallop_law *law, double t);
double law_rate(const gallop_law *law, double t);
double law_second(const gallop_law *law, double t);

/* First time from t on at which the law or a derivative of it jumps; infinite: none. */
double law_next_kink(const gallop_law *law, double t);

#endif
