/* Messages of the co-simulation layer: a fact, then its remedy, kept in the instance. */
#ifndef GALLOP_COSIM_MESSAGE_H
#define GALLOP_COSIM_MESSAGE_H

#include "cosim_instance.h"

/* Parts of a message, by value: they last as long as the call that they are arguments of. */
typedef struct {
    char text[32];
} cosim_number;
typedef struct {
    char text[320];
} cosim_phrase;

/* `value` as %.{digits}g writes it, with a decimal point in every locale. */
cosim_number cosim_number_text(int digits, double value);

/* Store a message, in the manner of printf, and return the status that goes with it. */
gallop_cosim_status cosim_refuse(gallop_cosim *c, const char *format, ...);
gallop_cosim_status cosim_fail(gallop_cosim *c, const char *format, ...);

/* The same for a failure of the kernel: time, element, values and remedy follow `what`. */
gallop_cosim_status cosim_fail_with_report(gallop_cosim *c, const char *what,
                                           const gallop_report *report);

/* True in one of the phases; else, the message says that `action` is not allowed now. */
bool cosim_is_allowed(gallop_cosim *c, int phases, const char *action);

#endif
