/* Life of an instance: creation, phases, reset. */
#include "cosim_message.h"
#include "cosim_span.h"
#include "cosim_values.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The state after creation: parameters and inputs of the resource, no model and no state. */
static void return_to_start(gallop_cosim *c)
{
    resource_restore(&c->parameters, c->original);
    cosim_copy_parameters(c, c->stored);
    cosim_span_drop(c);
    memset(&c->run, 0, sizeof c->run);
    c->last_step.base = COSIM_DERIV_UNKNOWN;
    c->last_step.ramp = 0.0;
    c->run.phase = COSIM_INSTANTIATED;
    c->run.stop = INFINITY;
    memset(c->in.rate, 0, cosim_input_bytes(c));
    memset(c->in.reached, 0, cosim_input_bytes(c));
    memset(c->in.trend, 0, cosim_input_bytes(c));
    memset(c->in.given, 0, cosim_input_bytes(c));
    resource_start_inputs(&c->parameters, c->in.value);
}

static uint32_t count_parameters(const resource *r)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < resource_variable_count(r); i++)
        count += resource_variables(r)[i].origin == RESOURCE_PARAMETER;
    return count;
}

/* Takes `count` numbers from a block; returns where they begin. */
static double *take(double **block, size_t count)
{
    double *from = *block;
    *block += count;
    return from;
}

/* The arrays lie side by side. */
static cosim_inputs take_inputs(double **block, size_t count)
{
    double *first = take(block, COSIM_INPUT_ARRAYS * count);
    return (cosim_inputs){first, first + count, first + 2 * count, first + 3 * count,
                          first + 4 * count};
}

/* Allocates the arrays whose lengths the resource gives; false: there is not enough memory. */
static bool allocate_arrays(gallop_cosim *c)
{
    const resource *r = &c->parameters;
    c->input_count = resource_input_count(r);
    c->term_count = r->section[RESOURCE_TERMS].count;
    const size_t inputs = c->input_count, terms = c->term_count;
    const size_t fields = r->section[RESOURCE_FIELDS].count;
    const size_t junctions = r->section[RESOURCE_JUNCTIONS].count;
    double *block =
        calloc((2 * COSIM_INPUT_ARRAYS + 3) * inputs + 4 * fields + 6 * junctions + 2 * terms,
               sizeof *block);
    c->numbers = block;
    c->probe = malloc(terms * sizeof *c->probe + 1);
    c->velocity = malloc(inputs * sizeof *c->velocity + 1);
    if (!block || !c->probe || !c->velocity) return false;
    for (uint32_t i = 0; i < inputs; i++) c->velocity[i] = resource_velocity_input(r, i);
    c->in = take_inputs(&block, inputs);
    c->last_step.with = take_inputs(&block, inputs);
    c->direction = take(&block, inputs);
    c->other = take(&block, inputs);
    c->step_rate = take(&block, inputs);
    c->wind = take(&block, 2 * fields);
    c->wind_direction = take(&block, 2 * fields);
    c->motion = take(&block, 6 * junctions);
    c->observed = take(&block, terms);
    c->observed_elsewhere = take(&block, terms);
    return true;
}

/* Reads the resource and allocates the rest; the problem, or NULL. */
static const char *fill_in(gallop_cosim *c, const void *bytes, size_t size, const char *identity)
{
    if (!bytes) return "the content of resources/model.bin is missing; give it";
    if (!identity) return "the GUID is missing; give that of modelDescription.xml";
    const char *problem = resource_open(&c->parameters, bytes, size, identity);
    if (problem) return problem;
    c->parameter_count = count_parameters(&c->parameters);
    c->original = malloc(c->parameters.size);
    c->stored = malloc(c->parameter_count * sizeof *c->stored + 1);
    if (!c->original || !c->stored || !allocate_arrays(c)) return "there is not enough memory";
    memcpy(c->original, c->parameters.bytes, c->parameters.size);
    return NULL;
}

gallop_cosim *gallop_cosim_create(const void *bytes, size_t size, const char *identity,
                                  char *message)
{
    const char *fault = gallop_arithmetic_fault(), *problem = NULL;
    gallop_cosim *c = fault ? NULL : calloc(1, sizeof *c);
    if (!fault) problem = c ? fill_in(c, bytes, size, identity) : "there is not enough memory";
    if (!fault && !problem) {
        return_to_start(c);
        return c;
    }
    if (message)
        snprintf(message, GALLOP_COSIM_MESSAGE_SIZE, "%s%s",
                 fault ? "this FMU cannot compute; check " : "", fault ? fault : problem);
    gallop_cosim_free(c);
    return NULL;
}

void gallop_cosim_free(gallop_cosim *c)
{
    if (!c) return;
    cosim_span_drop(c);
    resource_close(&c->parameters);
    free(c->original);
    free(c->stored);
    free(c->numbers);
    free(c->probe);
    free(c->velocity);
    free(c);
}

const char *gallop_cosim_message(const gallop_cosim *c)
{
    return c ? c->message : "there is no instance; create one";
}

gallop_cosim_status gallop_cosim_reset(gallop_cosim *c)
{
    if (!c) return GALLOP_COSIM_REFUSED;
    return_to_start(c);
    return GALLOP_COSIM_OK;
}

gallop_cosim_status gallop_cosim_set_up(gallop_cosim *c, double start, double stop)
{
    if (!cosim_is_allowed(c, COSIM_INSTANTIATED, "setting the start time"))
        return GALLOP_COSIM_REFUSED;
    if (!isfinite(start)) return cosim_refuse(c, "the start time must be a finite number");
    if (!(stop > start))
        return cosim_refuse(c, "the stop time %s s must be after the start time %s s",
                            cosim_number_text(6, stop).text, cosim_number_text(6, start).text);
    c->run.start = c->run.time = start;
    c->run.stop = stop;
    c->started = false;
    return GALLOP_COSIM_OK;
}

gallop_cosim_status gallop_cosim_enter_initialization(gallop_cosim *c)
{
    if (!cosim_is_allowed(c, COSIM_INSTANTIATED, "beginning initialization"))
        return GALLOP_COSIM_REFUSED;
    c->run.phase = COSIM_INITIALIZING;
    return GALLOP_COSIM_OK;
}

gallop_cosim_status gallop_cosim_exit_initialization(gallop_cosim *c)
{
    if (!cosim_is_allowed(c, COSIM_INITIALIZING, "ending initialization"))
        return GALLOP_COSIM_REFUSED;
    const gallop_cosim_status status = cosim_span_make_current(c);
    if (status == GALLOP_COSIM_OK) c->run.phase = COSIM_STEPPING;
    return status;
}

gallop_cosim_status gallop_cosim_terminate(gallop_cosim *c)
{
    if (!cosim_is_allowed(c, COSIM_STEPPING, "termination")) return GALLOP_COSIM_REFUSED;
    c->run.phase = COSIM_TERMINATED;
    return GALLOP_COSIM_OK;
}
