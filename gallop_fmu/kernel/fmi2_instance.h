/* What the files of the FMI layer share: the instance, and how it speaks. */
#ifndef GALLOP_FMI2_INSTANCE_H
#define GALLOP_FMI2_INSTANCE_H

#include "resource.h"

#include <fmi2Functions.h>

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#define INPUTS RESOURCE_INPUTS

typedef enum { INSTANTIATED = 1, INITIALIZING = 2, STEPPING = 4, TERMINATED = 8 } mode;

/* What a saved FMU state holds besides the kernel's state and the parameters. */
typedef struct {
    int32_t mode, status;
    double time, start, stop;           /* stop infinite: not given */
    double input[INPUTS], rate[INPUTS]; /* rate: until the end of the next step */
    double reached[6];                  /* where the tower points are */
} kept;

/* What present outputs can be compared with to take derivatives. */
typedef enum {
    NOTHING,   /* the step before is not known: a state was restored, or a step failed */
    BEGINNING, /* no step yet: the outputs are those of the initial state */
    LAST_STEP
} lookback;

typedef struct {
    lookback kind;
    double step; /* of the last step, */
    double input[INPUTS], rate[INPUTS],
        reached[6]; /* and what it was given; before it: of the initial state */
} history;

/* What is built from the parameters. */
typedef struct {
    gallop_model *model; /* NULL: none */
    gallop_state *state, *work;
} span;

typedef struct {
    fmi2CallbackFunctions call;
    char *name;
    resource parameters; /* as the host has set them, */
    char *original;      /* and as they were exported */
    double *stored; /* the parameters once more, one after the other, to save and compare at once */
    uint32_t parameter_count;
    span span;    /* belongs to the present parameters */
    bool started; /* state belongs to the present inputs */
    bool node_known, forces_known;
    double node[GALLOP_NODE_CHANNELS], forces[6];
    kept now;
    history before;
} instance;

/* Parts of a message, by value: they last as long as the call that they are arguments of. */
typedef struct {
    char text[32];
} numeral;
typedef struct {
    char text[320];
} phrase;

/* fmi2.c */
numeral numeral_of(int digits, double value);
fmi2Status say(instance *c, fmi2Status status, const char *format, ...);
fmi2Status tell(instance *c, const char *what,
                const gallop_report *report); /* a failure of the kernel */
bool allowed(instance *c, int modes, const char *function);
void span_free(span *s);
void drop_span(instance *c);
fmi2Status build_span(instance *c, span *s);
fmi2Status make_current(instance *c);
void held_inputs(const double input[INPUTS], double time, gallop_inputs *in);
void forget_observations(instance *c);

/* fmi2_values.c */
const resource_variable *find(instance *c, fmi2ValueReference reference, bool whole,
                              const char *function);
int observed(instance *c, const resource_variable *v, double *value);
int observed_in(const instance *c, gallop_state *state, const resource_variable *v, double *value);
fmi2Status cannot_observe(instance *c, const resource_variable *v, const char *function);
double parameter_stored(const instance *c, const resource_variable *v);
void store_parameter(instance *c, const resource_variable *v, double stored);
void list_parameters(instance *c); /* after the last of several store_parameter */

#define ALLOW(modes)                                                                               \
    instance *c = component;                                                                       \
    if (!allowed(c, modes, __func__)) return fmi2Error
#define SETTABLE (INSTANTIATED | INITIALIZING | STEPPING)
#define ANY (SETTABLE | TERMINATED)

#endif
