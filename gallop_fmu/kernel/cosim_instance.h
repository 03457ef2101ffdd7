/* What an instance of the co-simulation layer holds. */
#ifndef GALLOP_COSIM_INSTANCE_H
#define GALLOP_COSIM_INSTANCE_H

#include "gallop_cosim.h"
#include "resource.h"

#include <stdbool.h>

/* Phases as bits, so that a call can name all those in which it is allowed. */
typedef enum {
    COSIM_INSTANTIATED = 1,
    COSIM_INITIALIZING = 2,
    COSIM_STEPPING = 4,
    COSIM_TERMINATED = 8
} cosim_phase;

enum {
    COSIM_BEFORE_TERMINATION = COSIM_INSTANTIATED | COSIM_INITIALIZING | COSIM_STEPPING,
    COSIM_WITH_TIME = COSIM_STEPPING | COSIM_TERMINATED
};

/* Progress of the run and what the host has set; part of a saved state. */
typedef struct {
    int32_t phase, status;    /* a cosim_phase, a gallop_outcome */
    double time, start, stop; /* [s]; stop infinite: not given */
    double input[RESOURCE_INPUTS];
    double rate[RESOURCE_INPUTS]; /* of the inputs, until the end of the next step */
    double tower[6];              /* present displacement of the tower points [m] */
} cosim_run;

/* What the present outputs can be compared with to take derivatives. */
typedef enum {
    COSIM_DERIV_UNKNOWN,  /* no last step: a state was restored, or a step failed */
    COSIM_DERIV_AT_START, /* no step yet: the outputs are those of the initial state */
    COSIM_DERIV_LAST_STEP
} cosim_deriv_base;

/* The last step and its inputs; before the first one, the inputs of the initial state. */
typedef struct {
    cosim_deriv_base base;
    double size; /* [s] */
    double input[RESOURCE_INPUTS], rate[RESOURCE_INPUTS];
    double tower[6]; /* displacement of the tower points at its start [m] */
} cosim_last_step;

/* Model and states that belong to the present parameters. */
typedef struct {
    gallop_model *model; /* NULL: none */
    gallop_state *state, *work;
} cosim_span;

struct gallop_cosim {
    resource parameters; /* the resource with the parameters that the host has set */
    char *original;      /* the same bytes as they were read */
    double *stored;      /* the parameters once more, in order, to save and compare at once */
    uint32_t parameter_count;
    cosim_span span;
    bool started; /* the state belongs to the present inputs */
    bool node_known, forces_known;
    double node[GALLOP_NODE_CHANNELS], forces[6]; /* last observations, where known */
    cosim_run run;
    cosim_last_step last_step;
    char message[GALLOP_COSIM_MESSAGE_SIZE];
};

#endif
