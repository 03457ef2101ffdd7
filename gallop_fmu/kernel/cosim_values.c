/* Parameters, inputs and outputs of an instance by value reference. */
#include "cosim_values.h"

#include "cosim_message.h"
#include "cosim_span.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

const resource_variable *cosim_find(gallop_cosim *c, uint32_t reference, bool whole)
{
    const resource_variable *v = resource_variables(&c->parameters);
    if (reference < resource_variable_count(&c->parameters) && (v[reference].whole != 0) == whole)
        return &v[reference];
    cosim_refuse(c,
                 "there is no %s variable with value reference %u; use those of "
                 "modelDescription.xml",
                 whole ? "Integer" : "Real", reference);
    return NULL;
}

static double parameter_stored(const gallop_cosim *c, const resource_variable *v)
{
    const char *at = resource_place(&c->parameters, v);
    return v->whole ? *(const int32_t *)at : *(const double *)at;
}

static void store_parameter(gallop_cosim *c, const resource_variable *v, double stored)
{
    char *at = resource_place(&c->parameters, v);
    if (v->whole)
        *(int32_t *)at = (int32_t)stored;
    else
        *(double *)at = stored;
}

void cosim_copy_parameters(const gallop_cosim *c, double *stored)
{
    const resource_variable *v = resource_variables(&c->parameters);
    for (uint32_t i = 0; i < resource_variable_count(&c->parameters); i++)
        if (v[i].origin == RESOURCE_PARAMETER) *stored++ = parameter_stored(c, &v[i]);
}

void cosim_set_parameters(gallop_cosim *c, const double *stored)
{
    const resource_variable *v = resource_variables(&c->parameters);
    for (uint32_t i = 0; i < resource_variable_count(&c->parameters); i++)
        if (v[i].origin == RESOURCE_PARAMETER) store_parameter(c, &v[i], *stored++);
    cosim_copy_parameters(c, c->stored);
}

bool cosim_parameters_are_possible(const gallop_cosim *c, const double *stored)
{
    const resource_variable *v = resource_variables(&c->parameters);
    for (uint32_t i = 0; i < resource_variable_count(&c->parameters); i++) {
        if (v[i].origin != RESOURCE_PARAMETER) continue;
        const double number = *stored++;
        if (!isfinite(number) || !resource_allows(&v[i], number, v[i].factor) ||
            (v[i].whole && !(fabs(number) <= INT32_MAX)))
            return false;
    }
    return true;
}

/* The value that was stored as factor * value; of the several that round to it, the one with at
 * most 15 digits, so that the host reads 15 degrees and not 15.000000000000002. */
static double unscaled(double stored, double factor)
{
    const double quotient = stored / factor;
    char text[32];
    snprintf(text, sizeof text, "%.15g", quotient);
    const double typed = strtod(text, NULL);
    return factor * typed == stored ? typed : quotient;
}

static bool is_force(const resource_variable *v)
{
    return v->origin == RESOURCE_SPAN && v->index >= RESOURCE_LEFT_FORCE &&
           v->index < RESOURCE_SYSTEM;
}

/* The probe of an output, from its origin and number. */
static gallop_probe probe_of(const gallop_cosim *c, int32_t origin, int32_t number)
{
    const int32_t last = (int32_t)c->parameters.section[RESOURCE_JUNCTIONS].count - 1;
    if (origin == RESOURCE_NODE)
        return (gallop_probe){
            .object = GALLOP_PROBE_NODE, .index = gallop_middle(c->span.model), .channel = number};
    if (number >= RESOURCE_SYSTEM)
        return (gallop_probe){.object = GALLOP_PROBE_SYSTEM, .channel = number - RESOURCE_SYSTEM};
    if (number >= RESOURCE_RIGHT_FORCE)
        return (gallop_probe){.object = GALLOP_PROBE_JUNCTION,
                              .index = last,
                              .channel = number - RESOURCE_RIGHT_FORCE};
    if (number >= RESOURCE_LEFT_FORCE)
        return (gallop_probe){.object = GALLOP_PROBE_JUNCTION,
                              .channel = number - RESOURCE_LEFT_FORCE};
    return (gallop_probe){.object = GALLOP_PROBE_FIELD, .channel = GALLOP_WIND_SPEED};
}

/* Outputs of one origin by consecutive numbers, GALLOP_NODE_CHANNELS at most. */
static int observe_several(const gallop_cosim *c, int32_t origin, int32_t first, int32_t count,
                           double *values)
{
    gallop_probe probe[GALLOP_NODE_CHANNELS];
    for (int32_t i = 0; i < count; i++) probe[i] = probe_of(c, origin, first + i);
    return gallop_observe(c->span.model, c->span.state, probe, count, values);
}

int cosim_observe_in(const gallop_cosim *c, gallop_state *state, const resource_variable *v,
                     double *value)
{
    const gallop_probe probe = probe_of(c, v->origin, (int32_t)v->index);
    return gallop_observe(c->span.model, state, &probe, 1, value);
}

/* Hosts read one output after the other: what was computed for one is kept for the next. */
int cosim_observe(gallop_cosim *c, const resource_variable *v, double *value)
{
    int outcome = GALLOP_COMPLETED;
    if (v->origin == RESOURCE_NODE) {
        if (!c->node_known)
            outcome = observe_several(c, RESOURCE_NODE, 0, GALLOP_NODE_CHANNELS, c->node);
        c->node_known = !outcome;
        if (!outcome) *value = c->node[v->index];
        return outcome;
    }
    if (is_force(v)) {
        if (!c->forces_known)
            outcome = observe_several(c, RESOURCE_SPAN, RESOURCE_LEFT_FORCE,
                                      RESOURCE_SYSTEM - RESOURCE_LEFT_FORCE, c->forces);
        c->forces_known = !outcome;
        if (!outcome) *value = c->forces[v->index - RESOURCE_LEFT_FORCE];
        return outcome;
    }
    return cosim_observe_in(c, c->span.state, v, value);
}

gallop_cosim_status cosim_fail_to_observe(gallop_cosim *c, const resource_variable *v)
{
    const char *fault = gallop_arithmetic_fault();
    return cosim_fail(c, "%s cannot be computed; check %s", v->name, fault ? fault : "the state");
}

static gallop_cosim_status get_one(gallop_cosim *c, const resource_variable *v, double *value)
{
    switch (v->origin) {
    case RESOURCE_PARAMETER:
        *value =
            v->factor == 1.0 ? parameter_stored(c, v) : unscaled(parameter_stored(c, v), v->factor);
        return GALLOP_COSIM_OK;
    case RESOURCE_INPUT: *value = c->run.input[v->index]; return GALLOP_COSIM_OK;
    default: break;
    }

    /* An output: it needs a state, but for the status of the last computation. */
    if (c->run.phase == COSIM_INSTANTIATED)
        return cosim_refuse(c, "%s is not known before initialization; initialize first", v->name);
    if (v->origin == RESOURCE_STATUS) {
        *value = c->run.status;
        return GALLOP_COSIM_OK;
    }
    if (c->run.phase == COSIM_INITIALIZING) {
        const gallop_cosim_status status = cosim_span_make_current(c);
        if (status != GALLOP_COSIM_OK) return status;
    }
    return cosim_observe(c, v, value) ? cosim_fail_to_observe(c, v) : GALLOP_COSIM_OK;
}

/* The bounds in words, as Variable.allowed in gallop_fmu/fmu/variables.py writes them. */
static cosim_phrase bounds_of(const resource_variable *v)
{
    cosim_phrase out = {""};
    const bool low = isfinite(v->minimum), high = isfinite(v->maximum);
    const char *above = v->excluded & RESOURCE_MINIMUM_EXCLUDED ? "greater than " : "at least ";
    const char *below = v->excluded & RESOURCE_MAXIMUM_EXCLUDED ? "less than " : "at most ";
    snprintf(out.text, sizeof out.text, "%s%s%s%s%s", low ? above : "",
             low ? cosim_number_text(6, v->minimum).text : "", low && high ? " and " : "",
             high ? below : "", high ? cosim_number_text(6, v->maximum).text : "");
    return out;
}

/* Checks a value without setting it. */
static gallop_cosim_status check_one(gallop_cosim *c, const resource_variable *v, double value)
{
    if (v->origin != RESOURCE_PARAMETER && v->origin != RESOURCE_INPUT)
        return cosim_refuse(c, "%s is an output and cannot be set; set inputs and parameters only",
                            v->name);
    if (v->origin == RESOURCE_PARAMETER && c->run.phase == COSIM_STEPPING)
        return cosim_refuse(
            c, "%s is a fixed parameter; it can be set until initialization ends, or after a reset",
            v->name);
    if (!isfinite(value)) return cosim_refuse(c, "%s must be a finite number", v->name);
    if (!resource_allows(v, value, 1.0))
        return cosim_refuse(c, "%s = %s is refused: it must be %s", v->name,
                            cosim_number_text(6, value).text, bounds_of(v).text);
    return GALLOP_COSIM_OK;
}

static void set_one(gallop_cosim *c, const resource_variable *v, double value)
{
    if (v->origin == RESOURCE_INPUT) {
        if (c->run.input[v->index] != value && c->run.phase != COSIM_STEPPING) c->started = false;
        c->run.input[v->index] = value;
        return;
    }
    const double stored = v->factor * value;
    if (parameter_stored(c, v) == stored) return;
    store_parameter(c, v, stored);
    cosim_copy_parameters(c, c->stored);
    cosim_span_drop(c);
}

static const char *const array_is_null = "an array is a null pointer; give arrays for all values";

gallop_cosim_status gallop_cosim_get_real(gallop_cosim *c, const uint32_t reference[], size_t count,
                                          double value[])
{
    if (!c) return GALLOP_COSIM_REFUSED;
    if (count && (!reference || !value)) return cosim_refuse(c, "%s", array_is_null);
    for (size_t i = 0; i < count; i++) {
        const resource_variable *v = cosim_find(c, reference[i], false);
        if (!v) return GALLOP_COSIM_REFUSED;
        const gallop_cosim_status status = get_one(c, v, &value[i]);
        if (status != GALLOP_COSIM_OK) return status;
    }
    return GALLOP_COSIM_OK;
}

gallop_cosim_status gallop_cosim_get_integer(gallop_cosim *c, const uint32_t reference[],
                                             size_t count, int32_t value[])
{
    if (!c) return GALLOP_COSIM_REFUSED;
    if (count && (!reference || !value)) return cosim_refuse(c, "%s", array_is_null);
    for (size_t i = 0; i < count; i++) {
        const resource_variable *v = cosim_find(c, reference[i], true);
        if (!v) return GALLOP_COSIM_REFUSED;
        double number = 0.0;
        const gallop_cosim_status status = get_one(c, v, &number);
        if (status != GALLOP_COSIM_OK) return status;
        value[i] = fabs(number) < INT32_MAX ? (int32_t)number : INT32_MAX;
    }
    return GALLOP_COSIM_OK;
}

/* All values are checked before the first one is set. */
gallop_cosim_status gallop_cosim_set_real(gallop_cosim *c, const uint32_t reference[], size_t count,
                                          const double value[])
{
    if (!cosim_is_allowed(c, COSIM_BEFORE_TERMINATION, "setting values"))
        return GALLOP_COSIM_REFUSED;
    if (count && (!reference || !value)) return cosim_refuse(c, "%s", array_is_null);
    for (size_t i = 0; i < count; i++) {
        const resource_variable *v = cosim_find(c, reference[i], false);
        if (!v || check_one(c, v, value[i]) != GALLOP_COSIM_OK) return GALLOP_COSIM_REFUSED;
    }
    for (size_t i = 0; i < count; i++)
        set_one(c, &resource_variables(&c->parameters)[reference[i]], value[i]);
    return GALLOP_COSIM_OK;
}

gallop_cosim_status gallop_cosim_set_integer(gallop_cosim *c, const uint32_t reference[],
                                             size_t count, const int32_t value[])
{
    if (!cosim_is_allowed(c, COSIM_BEFORE_TERMINATION, "setting values"))
        return GALLOP_COSIM_REFUSED;
    if (count && (!reference || !value)) return cosim_refuse(c, "%s", array_is_null);
    for (size_t i = 0; i < count; i++) {
        const resource_variable *v = cosim_find(c, reference[i], true);
        if (!v || check_one(c, v, value[i]) != GALLOP_COSIM_OK) return GALLOP_COSIM_REFUSED;
    }
    for (size_t i = 0; i < count; i++)
        set_one(c, &resource_variables(&c->parameters)[reference[i]], value[i]);
    return GALLOP_COSIM_OK;
}
