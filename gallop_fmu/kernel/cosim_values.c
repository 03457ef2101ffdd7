/* Parameters, inputs and outputs of an instance by value reference. */
#include "cosim_values.h"

#include "base_math.h"
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
        if (v[i].origin == RESOURCE_PARAMETER) resource_store(&c->parameters, &v[i], *stored++);
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

/* The sum of terms whose probes have these values; `one` is the value of a constant. */
static double sum_of(const resource_term *term, uint32_t count, const double *value, double one)
{
    double sum = -0.0; /* adding to it changes no number */
    for (uint32_t i = 0; i < count; i++)
        sum += term[i].weight * (term[i].probe.object == RESOURCE_CONSTANT ? one : value[i]);
    return sum;
}

static double value_of(const gallop_cosim *c, const resource_variable *v, const double *observed)
{
    const resource_term *term = resource_terms(&c->parameters) + v->index;
    const double *value = observed + v->index;
    const uint32_t half = v->field / 2;
    if (v->origin == RESOURCE_SUM) return sum_of(term, v->field, value, 1.0);
    return arctangent(sum_of(term, half, value, 1.0), sum_of(term + half, half, value + half, 1.0));
}

/* Observes the terms [first, first + count), of channels that are `shift` further. */
static int observe(const gallop_cosim *c, gallop_state *state, uint32_t first, uint32_t count,
                   int32_t shift, double *values)
{
    const resource_term *term = resource_terms(&c->parameters);
    for (uint32_t i = first; i < first + count; i++) {
        c->probe[i] = resource_probe(&c->parameters, &term[i]);
        if (term[i].probe.object != RESOURCE_CONSTANT) c->probe[i].channel += shift;
    }
    return gallop_observe(c->span.model, state, c->probe + first, (int32_t)count, values + first);
}

/* The sum of terms in the initial equilibrium, which only the parameters change. */
static int observe_static(const gallop_cosim *c, const resource_variable *v, double *value)
{
    const resource_term *term = resource_terms(&c->parameters) + v->index;
    double *values = c->observed_elsewhere + v->index;
    for (uint32_t i = 0; i < v->field; i++) c->probe[i] = resource_probe(&c->parameters, &term[i]);
    const int outcome =
        gallop_observe_equilibrium(c->span.model, c->probe, (int32_t)v->field, values);
    if (!outcome) *value = sum_of(term, v->field, values, 1.0);
    return outcome;
}

int cosim_observe_in(const gallop_cosim *c, gallop_state *state, const resource_variable *v,
                     double *value)
{
    if (v->origin == RESOURCE_STATIC) return observe_static(c, v, value);
    const int outcome = observe(c, state, v->index, v->field, 0, c->observed_elsewhere);
    if (!outcome) *value = value_of(c, v, c->observed_elsewhere);
    return outcome;
}

static bool is_of_node(const resource_term *term)
{
    return term->probe.object == RESOURCE_POINT || term->probe.object == GALLOP_PROBE_NODE;
}

/* Hosts read one output after the other: with the first one of a node all of nodes are computed,
 * with the first other one, such as a force, all others. */
static int observe_group(gallop_cosim *c, bool nodes)
{
    const resource_term *term = resource_terms(&c->parameters);
    double *values = c->observed_elsewhere;
    int32_t count = 0;
    for (uint32_t i = 0; i < c->term_count; i++)
        if (is_of_node(&term[i]) == nodes)
            c->probe[count++] = resource_probe(&c->parameters, &term[i]);
    const int outcome = gallop_observe(c->span.model, c->span.state, c->probe, count, values);
    if (outcome) return outcome;
    for (uint32_t i = 0; i < c->term_count; i++)
        if (is_of_node(&term[i]) == nodes) c->observed[i] = *values++;
    c->observed_known[nodes] = true;
    return GALLOP_COMPLETED;
}

int cosim_observe(gallop_cosim *c, const resource_variable *v, double *value)
{
    if (v->origin == RESOURCE_STATIC) return observe_static(c, v, value);
    const resource_term *term = resource_terms(&c->parameters) + v->index;
    for (uint32_t i = 0; i < v->field; i++) {
        const bool of_node = is_of_node(&term[i]);
        if (c->observed_known[of_node]) continue;
        const int outcome = observe_group(c, of_node);
        if (outcome) return outcome;
    }
    *value = value_of(c, v, c->observed);
    return GALLOP_COMPLETED;
}

/* A term that is a displacement or a velocity of a node. */
static bool has_rate(const resource_term *term)
{
    return term->probe.object == RESOURCE_CONSTANT ||
           (is_of_node(term) && term->probe.channel <= GALLOP_OMEGA);
}

bool cosim_has_exact_rate(const gallop_cosim *c, const resource_variable *v)
{
    const resource_term *term = resource_terms(&c->parameters) + v->index;
    for (uint32_t i = 0; i < v->field; i++)
        if (!has_rate(&term[i])) return false;
    return true;
}

int cosim_observe_rate(gallop_cosim *c, const resource_variable *v, double *rate)
{
    double value;
    int outcome = cosim_observe(c, v, &value);
    if (!outcome)
        outcome = observe(c, c->span.state, v->index, v->field, GALLOP_V1 - GALLOP_U1,
                          c->observed_elsewhere);
    if (outcome) return outcome;
    const resource_term *term = resource_terms(&c->parameters) + v->index;
    const double *at = c->observed + v->index, *rates = c->observed_elsewhere + v->index;
    const uint32_t half = v->field / 2;
    if (v->origin == RESOURCE_SUM) {
        *rate = sum_of(term, v->field, rates, 0.0);
        return GALLOP_COMPLETED;
    }
    const double y = sum_of(term, half, at, 1.0), x = sum_of(term + half, half, at + half, 1.0);
    const double y_rate = sum_of(term, half, rates, 0.0);
    const double x_rate = sum_of(term + half, half, rates + half, 0.0);
    *rate = (y_rate * x - y * x_rate) / (x * x + y * y);
    return GALLOP_COMPLETED;
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
    case RESOURCE_INPUT: *value = c->in.value[v->index]; return GALLOP_COSIM_OK;
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
        if (c->in.value[v->index] != value && c->run.phase != COSIM_STEPPING) c->started = false;
        c->in.value[v->index] = value;
        return;
    }
    const double stored = v->factor * value;
    if (parameter_stored(c, v) == stored) return;
    resource_store(&c->parameters, v, stored);
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
        if (reference[i] == GALLOP_COSIM_TIME) {
            value[i] = c->run.time;
            continue;
        }
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
