/* FMI: values of parameters, inputs and outputs. */
#include "fmi2_instance.h"

#include <stdio.h>

const resource_variable *find(instance *c, fmi2ValueReference reference, bool whole,
                              const char *function)
{
    const resource_header *head = resource_head(&c->parameters);
    const resource_variable *v = resource_table(&c->parameters);
    if (reference < head->variable_count && (v[reference].whole != 0) == whole)
        return &v[reference];
    const char *type = whole ? "Integer" : "Real";
    say(c, fmi2Error, "%s: there is no %s variable with value reference %u", function, type,
        reference);
    return NULL;
}

double parameter_stored(const instance *c, const resource_variable *v)
{
    const char *at = c->parameters.bytes + v->place;
    return v->whole ? *(const int32_t *)at : *(const double *)at;
}

void store_parameter(instance *c, const resource_variable *v, double stored)
{
    char *at = c->parameters.bytes + v->place;
    if (v->whole)
        *(int32_t *)at = (int32_t)stored;
    else
        *(double *)at = stored;
}

void list_parameters(instance *c)
{
    const resource_variable *v = resource_table(&c->parameters);
    double *to = c->stored;
    for (uint32_t i = 0; i < resource_head(&c->parameters)->variable_count; i++)
        if (v[i].origin == ORIGIN_PARAMETER) *to++ = parameter_stored(c, &v[i]);
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

/* An output in any state of the span. */
int observed_in(const instance *c, gallop_state *state, const resource_variable *v, double *value)
{
    double node[GALLOP_NODE_CHANNELS], forces[6], all[GALLOP_SPAN_CHANNELS];
    const gallop_model *model = c->span.model;
    const bool at_node = v->origin == ORIGIN_NODE,
               force = v->place >= GALLOP_LEFT_F1 && v->place <= GALLOP_RIGHT_F3;
    const int outcome = at_node ? gallop_observe_node(model, state, gallop_middle(model), node)
                      : force   ? gallop_support_forces(model, state, forces)
                                : gallop_observe_span(model, state, all);
    if (!outcome)
        *value = at_node ? node[v->place]
               : force   ? forces[v->place - GALLOP_LEFT_F1]
                         : all[v->place];
    return outcome;
}

/* The same in the present state.  Hosts read one output after the other: what was calculated for
 * one serves the next. */
int observed(instance *c, const resource_variable *v, double *value)
{
    const gallop_model *model = c->span.model;
    int outcome = GALLOP_COMPLETED;
    if (v->origin == ORIGIN_NODE) {
        if (!c->node_known)
            outcome = gallop_observe_node(model, c->span.state, gallop_middle(model), c->node);
        c->node_known = !outcome;
        if (!outcome) *value = c->node[v->place];
        return outcome;
    }
    if (v->place >= GALLOP_LEFT_F1 && v->place <= GALLOP_RIGHT_F3) {
        if (!c->forces_known) outcome = gallop_support_forces(model, c->span.state, c->forces);
        c->forces_known = !outcome;
        if (!outcome) *value = c->forces[v->place - GALLOP_LEFT_F1];
        return outcome;
    }
    return observed_in(c, c->span.state, v, value);
}

fmi2Status cannot_observe(instance *c, const resource_variable *v, const char *function)
{
    const char *fault = gallop_arithmetic_fault();
    return say(c, fmi2Error, "%s: %s cannot be computed; check %s", function, v->name,
               fault ? fault : "the state");
}

static fmi2Status get_one(instance *c, const resource_variable *v, double *value,
                          const char *function)
{
    switch (v->origin) {
    case ORIGIN_PARAMETER:
        *value =
            v->factor == 1.0 ? parameter_stored(c, v) : unscaled(parameter_stored(c, v), v->factor);
        return fmi2OK;
    case ORIGIN_INPUT: *value = c->now.input[v->place]; return fmi2OK;
    default:
        if (c->now.mode == INSTANTIATED)
            return say(c, fmi2Error, "%s: %s is not known before initialization", function,
                       v->name);
        if (v->origin == ORIGIN_STATUS) {
            *value = c->now.status;
            return fmi2OK;
        }
        if (c->now.mode == INITIALIZING && make_current(c) != fmi2OK) return fmi2Error;
        return observed(c, v, value) ? cannot_observe(c, v, function) : fmi2OK;
    }
}

/* What is allowed, in the words of Variable.allowed in gallop_fmu/fmu/variables.py. */
static phrase bounds_of(const resource_variable *v)
{
    phrase out = {""};
    const bool low = isfinite(v->minimum), high = isfinite(v->maximum);
    snprintf(out.text, sizeof out.text, "%s%s%s%s%s",
             !low                             ? ""
             : v->excluded & MINIMUM_EXCLUDED ? "greater than "
                                              : "at least ",
             low ? numeral_of(6, v->minimum).text : "", low && high ? " and " : "",
             !high                            ? ""
             : v->excluded & MAXIMUM_EXCLUDED ? "less than "
                                              : "at most ",
             high ? numeral_of(6, v->maximum).text : "");
    return out;
}

/* Checks a value without taking it. */
static fmi2Status check_one(instance *c, const resource_variable *v, double value,
                            const char *function)
{
    if (v->origin != ORIGIN_PARAMETER && v->origin != ORIGIN_INPUT)
        return say(c, fmi2Error, "%s: %s is an output and cannot be set", function, v->name);
    if (v->origin == ORIGIN_PARAMETER && c->now.mode == STEPPING)
        return say(c, fmi2Error,
                   "%s: %s is a fixed parameter; it can be set until initialization ends", function,
                   v->name);
    if (!isfinite(value))
        return say(c, fmi2Error, "%s: %s must be a finite number", function, v->name);
    if (!resource_allows(v, value, 1.0))
        return say(c, fmi2Error, "%s: %s = %s is refused: it must be %s", function, v->name,
                   numeral_of(6, value).text, bounds_of(v).text);
    return fmi2OK;
}

static void take_one(instance *c, const resource_variable *v, double value)
{
    if (v->origin == ORIGIN_INPUT) {
        if (c->now.input[v->place] != value && c->now.mode != STEPPING) c->started = false;
        c->now.input[v->place] = value;
        return;
    }
    const double stored = v->factor * value;
    if (parameter_stored(c, v) == stored) return;
    store_parameter(c, v, stored);
    list_parameters(c);
    drop_span(c);
}

fmi2Status fmi2GetReal(fmi2Component component, const fmi2ValueReference reference[], size_t count,
                       fmi2Real value[])
{
    ALLOW(ANY);
    if (count && (!reference || !value))
        return say(c, fmi2Error, "%s: an array is missing", __func__);
    for (size_t i = 0; i < count; i++) {
        const resource_variable *v = find(c, reference[i], false, __func__);
        if (!v || get_one(c, v, &value[i], __func__) != fmi2OK) return fmi2Error;
    }
    return fmi2OK;
}

fmi2Status fmi2GetInteger(fmi2Component component, const fmi2ValueReference reference[],
                          size_t count, fmi2Integer value[])
{
    ALLOW(ANY);
    if (count && (!reference || !value))
        return say(c, fmi2Error, "%s: an array is missing", __func__);
    for (size_t i = 0; i < count; i++) {
        const resource_variable *v = find(c, reference[i], true, __func__);
        double number = 0.0;
        if (!v || get_one(c, v, &number, __func__) != fmi2OK) return fmi2Error;
        value[i] = fabs(number) < INT32_MAX ? (fmi2Integer)number : INT32_MAX;
    }
    return fmi2OK;
}

/* All values are taken, or none. */
fmi2Status fmi2SetReal(fmi2Component component, const fmi2ValueReference reference[], size_t count,
                       const fmi2Real value[])
{
    ALLOW(SETTABLE);
    if (count && (!reference || !value))
        return say(c, fmi2Error, "%s: an array is missing", __func__);
    for (size_t i = 0; i < count; i++) {
        const resource_variable *v = find(c, reference[i], false, __func__);
        if (!v || check_one(c, v, value[i], __func__) != fmi2OK) return fmi2Error;
    }
    for (size_t i = 0; i < count; i++)
        take_one(c, &resource_table(&c->parameters)[reference[i]], value[i]);
    return fmi2OK;
}

fmi2Status fmi2SetInteger(fmi2Component component, const fmi2ValueReference reference[],
                          size_t count, const fmi2Integer value[])
{
    ALLOW(SETTABLE);
    if (count && (!reference || !value))
        return say(c, fmi2Error, "%s: an array is missing", __func__);
    for (size_t i = 0; i < count; i++) {
        const resource_variable *v = find(c, reference[i], true, __func__);
        if (!v || check_one(c, v, value[i], __func__) != fmi2OK) return fmi2Error;
    }
    for (size_t i = 0; i < count; i++)
        take_one(c, &resource_table(&c->parameters)[reference[i]], value[i]);
    return fmi2OK;
}

/* There are no Boolean and no String variables. */
static fmi2Status none(instance *c, size_t count, const char *function)
{
    return count == 0 ? fmi2OK
                      : say(c, fmi2Error, "%s: this FMU has no variable of that type", function);
}

fmi2Status fmi2GetBoolean(fmi2Component component, const fmi2ValueReference reference[],
                          size_t count, fmi2Boolean value[])
{
    (void)reference;
    (void)value;
    ALLOW(ANY);
    return none(c, count, __func__);
}

fmi2Status fmi2GetString(fmi2Component component, const fmi2ValueReference reference[],
                         size_t count, fmi2String value[])
{
    (void)reference;
    (void)value;
    ALLOW(ANY);
    return none(c, count, __func__);
}

fmi2Status fmi2SetBoolean(fmi2Component component, const fmi2ValueReference reference[],
                          size_t count, const fmi2Boolean value[])
{
    (void)reference;
    (void)value;
    ALLOW(SETTABLE);
    return none(c, count, __func__);
}

fmi2Status fmi2SetString(fmi2Component component, const fmi2ValueReference reference[],
                         size_t count, const fmi2String value[])
{
    (void)reference;
    (void)value;
    ALLOW(SETTABLE);
    return none(c, count, __func__);
}
