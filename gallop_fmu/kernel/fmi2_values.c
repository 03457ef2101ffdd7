/* FMI: values of parameters, inputs and outputs. */
#include "fmi2_instance.h"

const resource_variable *find(instance *c, fmi2ValueReference reference, bool whole, const char *function)
{
    const resource_header *head = resource_head(&c->parameters);
    const resource_variable *v = resource_table(&c->parameters);
    if (reference < head->variable_count && (v[reference].whole != 0) == whole) return &v[reference];
    say(c, fmi2Error, "%s: there is no %s variable with value reference %u", function, whole ? "Integer" : "Real", reference);
    return NULL;
}

double observed(instance *c, const resource_variable *v)
{
    if (v->origin == ORIGIN_STATUS) return c->now.status;
    bool force = v->origin == ORIGIN_SPAN && v->place >= GALLOP_LEFT_F1 && v->place <= GALLOP_RIGHT_F3;
    if (v->origin == ORIGIN_NODE) {
        if (!c->nodes_known) gallop_observe_node(c->model, c->state, gallop_middle(c->model), c->nodes);
        c->nodes_known = true;
        return c->nodes[v->place];
    }
    if (force) {
        if (!c->forces_known) gallop_support_forces(c->model, c->state, c->forces);
        c->forces_known = true;
        return c->forces[v->place - GALLOP_LEFT_F1];
    }
    double values[GALLOP_SPAN_CHANNELS];
    gallop_observe_span(c->model, c->state, values);
    return values[v->place];
}

static fmi2Status get(instance *c, const fmi2ValueReference reference[], size_t count, bool whole, fmi2Real real[],
                      fmi2Integer integer[], const char *function)
{
    if (count && (!reference || (whole ? !integer : !real))) return say(c, fmi2Error, "%s: an array is missing", function);
    for (size_t i = 0; i < count; i++) {
        const resource_variable *v = find(c, reference[i], whole, function);
        if (!v) return fmi2Error;
        double value;
        if (v->origin == ORIGIN_PARAMETER) {
            const char *at = c->parameters.bytes + v->place;
            value = v->whole ? *(const int32_t *)at : *(const double *)at / v->factor;
        } else if (v->origin == ORIGIN_INPUT) {
            value = c->now.input[v->place];
        } else {
            if (c->now.mode == INSTANTIATED) return say(c, fmi2Error, "%s: %s is not known before initialization", function, v->name);
            if (c->now.mode == INITIALIZING && make_current(c) != fmi2OK) return fmi2Error;
            if (!c->model) return say(c, fmi2Error, "%s: %s is not known, the FMU was not initialized", function, v->name);
            value = observed(c, v);
        }
        if (whole) integer[i] = (fmi2Integer)value;
        else real[i] = value;
    }
    return fmi2OK;
}

static fmi2Status set_one(instance *c, const resource_variable *v, double value, const char *function)
{
    if (!isfinite(value)) return say(c, fmi2Error, "%s: %s must be a finite number", function, v->name);
    if (v->origin != ORIGIN_PARAMETER && v->origin != ORIGIN_INPUT)
        return say(c, fmi2Error, "%s: %s is an output and cannot be set", function, v->name);
    if (value < v->minimum || value > v->maximum)
        return say(c, fmi2Error, "%s: %s = %g is not allowed; it must lie between %g and %g", function, v->name, value,
                   v->minimum, v->maximum);
    if (v->origin == ORIGIN_INPUT) {
        c->now.rate[v->place] = 0.0;
        if (c->now.input[v->place] != value && c->now.mode != STEPPING) c->started = false;
        c->now.input[v->place] = value;
        return fmi2OK;
    }
    if (!(c->now.mode & (INSTANTIATED | INITIALIZING)))
        return say(c, fmi2Error, "%s: %s is a fixed parameter; it can be set until initialization ends", function, v->name);
    char *at = c->parameters.bytes + v->place;
    if (v->whole) *(int32_t *)at = (int32_t)value;
    else *(double *)at = v->factor * value;
    drop_model(c);
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component component, const fmi2ValueReference reference[], size_t count, fmi2Real value[])
{
    ALLOW(ANY);
    return get(c, reference, count, false, value, NULL, __func__);
}

fmi2Status fmi2GetInteger(fmi2Component component, const fmi2ValueReference reference[], size_t count, fmi2Integer value[])
{
    ALLOW(ANY);
    return get(c, reference, count, true, NULL, value, __func__);
}

fmi2Status fmi2SetReal(fmi2Component component, const fmi2ValueReference reference[], size_t count, const fmi2Real value[])
{
    ALLOW(INSTANTIATED | INITIALIZING | STEPPING);
    if (count && (!reference || !value)) return say(c, fmi2Error, "%s: an array is missing", __func__);
    for (size_t i = 0; i < count; i++) {
        const resource_variable *v = find(c, reference[i], false, __func__);
        if (!v || set_one(c, v, value[i], __func__) != fmi2OK) return fmi2Error;
    }
    return fmi2OK;
}

fmi2Status fmi2SetInteger(fmi2Component component, const fmi2ValueReference reference[], size_t count, const fmi2Integer value[])
{
    ALLOW(INSTANTIATED | INITIALIZING | STEPPING);
    if (count && (!reference || !value)) return say(c, fmi2Error, "%s: an array is missing", __func__);
    for (size_t i = 0; i < count; i++) {
        const resource_variable *v = find(c, reference[i], true, __func__);
        if (!v || set_one(c, v, value[i], __func__) != fmi2OK) return fmi2Error;
    }
    return fmi2OK;
}

/* There are no Boolean and no String variables. */
static fmi2Status none(instance *c, size_t count, const char *function)
{
    return count == 0 ? fmi2OK : say(c, fmi2Error, "%s: this FMU has no variable of that type", function);
}

fmi2Status fmi2GetBoolean(fmi2Component component, const fmi2ValueReference reference[], size_t count, fmi2Boolean value[])
{
    (void)reference;
    (void)value;
    ALLOW(ANY);
    return none(c, count, __func__);
}

fmi2Status fmi2GetString(fmi2Component component, const fmi2ValueReference reference[], size_t count, fmi2String value[])
{
    (void)reference;
    (void)value;
    ALLOW(ANY);
    return none(c, count, __func__);
}

fmi2Status fmi2SetBoolean(fmi2Component component, const fmi2ValueReference reference[], size_t count, const fmi2Boolean value[])
{
    (void)reference;
    (void)value;
    ALLOW(ANY);
    return none(c, count, __func__);
}

fmi2Status fmi2SetString(fmi2Component component, const fmi2ValueReference reference[], size_t count, const fmi2String value[])
{
    (void)reference;
    (void)value;
    ALLOW(ANY);
    return none(c, count, __func__);
}
