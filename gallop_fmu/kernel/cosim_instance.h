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

/* Longest step [s]; longer ones are almost certainly a unit error. */
#define COSIM_MAX_STEP 1e6

/* Progress of the run; part of a saved state, as is what the host has set. */
typedef struct {
    int32_t phase, status;    /* a cosim_phase, a gallop_outcome */
    double time, start, stop; /* [s]; stop infinite: not given */
} cosim_run;

/* Numbers of the inputs, one of each for every input. */
typedef struct {
    double *value;
    double *rate;    /* during one step [unit/s] */
    double *reached; /* by a motion at the start of the step */
    double *trend;   /* of a motion: its velocity as the last steps show it [unit/s] */
    double *given;   /* 1: the host gives this rate in the step, or this velocity in every step */
} cosim_inputs;

#define COSIM_INPUT_ARRAYS 5 /* of cosim_inputs */

/* What the present outputs can be compared with to take derivatives. */
typedef enum {
    COSIM_DERIV_UNKNOWN,  /* no last step: there is no state, or a step failed */
    COSIM_DERIV_AT_START, /* no step yet: the outputs are those of the initial state */
    COSIM_DERIV_LAST_STEP
} cosim_deriv_base;

/* The last step and its inputs; before the first one, the inputs of the initial state. */
typedef struct {
    cosim_deriv_base base;
    double size; /* [s] */
    double ramp; /* time [s] in which towers reach their new places; 0 before the first step */
    cosim_inputs with;
} cosim_last_step;

/* Model and states that belong to the present parameters. */
typedef struct {
    gallop_model *model; /* NULL: none */
    gallop_state *state, *work;
    void *allocated; /* the memory in which both lie */
} cosim_span;

struct gallop_cosim {
    resource parameters; /* the resource with the parameters that the host has set */
    char *original;      /* the same bytes as they were read */
    double *stored;      /* the parameters once more, in order, to save and compare at once */
    uint32_t parameter_count, input_count, term_count;
    cosim_span span;
    bool started; /* the state belongs to the present inputs */
    cosim_run run;
    cosim_inputs in; /* set by the host; rates until the end of the next step */
    cosim_last_step last_step;
    /* Of inputs: room for a direction, for other values, and for the rates of a step. */
    double *direction, *other, *step_rate;
    double *wind, *wind_direction, *motion; /* room for gallop_inputs */
    gallop_probe *probe;                    /* (terms), */
    double *observed; /* their values in the present state, if known; and those elsewhere */
    double *observed_elsewhere;
    bool observed_known[2]; /* of terms that are not of nodes, and of those that are */
    double *numbers;        /* the block that holds the arrays of numbers */
    int32_t *velocity;      /* of each input: the input with the velocity of what it moves, or -1 */
    char message[GALLOP_COSIM_MESSAGE_SIZE];
};

/* Bytes of an array of all inputs. */
static inline size_t cosim_input_bytes(const gallop_cosim *c)
{
    return c->input_count * sizeof(double);
}

#endif
