/* FMI: communication steps, and derivatives of inputs and outputs. */
#include "fmi2_instance.h"

#define DERIVATIVE_STEP 1e-4        /* of the largest seed, in the unit of the input */
#define DERIVATIVE_SHARPNESS 1e-3   /* factor on the Newton tolerance for differences */

/* The kernel's inputs over a step of size h from `time`. */
static void step_inputs(const double input[INPUTS], const double rate[INPUTS], const double reached[6], double time, double h,
                        gallop_inputs *in)
{
    held_inputs(input, time, in);
    in->wind_speed_rate = input[0] + rate[0] * h < 0.0 ? -input[0] / h : rate[0];   /* the wind dies, it does not turn */
    in->attack_angle_rate = rate[1];
    for (int i = 0; i < 6; i++) {
        in->support[i / 3][i % 3] = reached[i];
        in->support_rate[i / 3][i % 3] = (input[2 + i] + rate[2 + i] * h - reached[i]) / h;
    }
}

fmi2Status fmi2DoStep(fmi2Component component, fmi2Real time, fmi2Real h, fmi2Boolean no_return)
{
    (void)no_return;
    ALLOW(STEPPING);
    if (!isfinite(time) || !isfinite(h) || !(h > 0.0))
        return say(c, fmi2Error, "fmi2DoStep: the step size %g s must be positive", h);
    if (fabs(time - c->now.time) > 1e-9 * fmax(1.0, fabs(time)) + 1e-3 * h)
        return say(c, fmi2Error, "fmi2DoStep: the step starts at %.12g s, but the FMU is at %.12g s", time, c->now.time);
    const double until = time + h, own = until - c->now.time;
    gallop_inputs in;
    gallop_report report;
    step_inputs(c->now.input, c->now.rate, c->now.reached, c->now.time, own, &in);
    if (gallop_advance(c->model, c->state, &in, until, &report)) return tell(c, "the step could not be carried out", &report);
    memcpy(c->now.before_input, c->now.input, sizeof c->now.input);
    memcpy(c->now.before_rate, c->now.rate, sizeof c->now.rate);
    memcpy(c->now.before_reached, c->now.reached, sizeof c->now.reached);
    for (int i = 0; i < 6; i++) c->now.reached[i] = in.support[i / 3][i % 3] + in.support_rate[i / 3][i % 3] * own;
    memset(c->now.rate, 0, sizeof c->now.rate);
    c->now.time = until;
    c->now.last_step = own;
    c->now.status = 0;
    c->nodes_known = c->forces_known = false;
    return fmi2OK;
}

fmi2Status fmi2CancelStep(fmi2Component component)
{
    ALLOW(ANY);
    return say(c, fmi2Error, "fmi2CancelStep: no step is under way, steps are carried out at once");
}

fmi2Status fmi2GetStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Status *value)
{
    (void)kind;
    (void)value;
    ALLOW(ANY);
    return say(c, fmi2Discard, "fmi2GetStatus: steps are carried out at once, none is pending");
}

fmi2Status fmi2GetRealStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Real *value)
{
    ALLOW(ANY);
    if (kind != fmi2LastSuccessfulTime || !value) return say(c, fmi2Discard, "fmi2GetRealStatus: only fmi2LastSuccessfulTime is known");
    *value = c->now.time;
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Integer *value)
{
    (void)kind;
    (void)value;
    ALLOW(ANY);
    return say(c, fmi2Discard, "fmi2GetIntegerStatus: nothing is known");
}

fmi2Status fmi2GetBooleanStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Boolean *value)
{
    ALLOW(ANY);
    if (kind != fmi2Terminated || !value) return say(c, fmi2Discard, "fmi2GetBooleanStatus: only fmi2Terminated is known");
    *value = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component component, const fmi2StatusKind kind, fmi2String *value)
{
    (void)kind;
    (void)value;
    ALLOW(ANY);
    return say(c, fmi2Discard, "fmi2GetStringStatus: nothing is known");
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component component, const fmi2ValueReference reference[], size_t count,
                                       const fmi2Integer order[], const fmi2Real value[])
{
    ALLOW(INITIALIZING | STEPPING);
    if (count && (!reference || !order || !value)) return say(c, fmi2Error, "%s: an array is missing", __func__);
    for (size_t i = 0; i < count; i++) {
        const resource_variable *v = find(c, reference[i], false, __func__);
        if (!v) return fmi2Error;
        if (v->origin != ORIGIN_INPUT) return say(c, fmi2Error, "%s: %s is not an input", __func__, v->name);
        if (order[i] != 1) return say(c, fmi2Error, "%s: only the first derivative of %s is taken, not that of order %d", __func__, v->name, order[i]);
        if (!isfinite(value[i])) return say(c, fmi2Error, "%s: the derivative of %s must be a finite number", __func__, v->name);
        c->now.rate[v->place] = value[i];
    }
    return fmi2OK;
}

/* Channel whose value is the time derivative of a mid-span channel; -1 where a difference over the last step must do. */
static int rate_channel(const resource_variable *v)
{
    return v->origin == ORIGIN_NODE && v->place <= GALLOP_OMEGA ? (int)v->place + GALLOP_V1 - GALLOP_U1 : -1;
}

static double observed_in(instance *c, gallop_state *state, const resource_variable *v)
{
    double values[GALLOP_NODE_CHANNELS], forces[6];
    if (v->origin == ORIGIN_NODE) {
        gallop_observe_node(c->model, state, gallop_middle(c->model), values);
        return values[v->place];
    }
    gallop_support_forces(c->model, state, forces);
    return forces[v->place - GALLOP_LEFT_F1];
}

static void copy_to_work(instance *c) { memcpy(c->work, c->state, gallop_state_size(c->model)); }

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component component, const fmi2ValueReference reference[], size_t count,
                                        const fmi2Integer order[], fmi2Real value[])
{
    ALLOW(STEPPING | TERMINATED);
    if (count && (!reference || !order || !value)) return say(c, fmi2Error, "%s: an array is missing", __func__);
    bool rewound = false;
    for (size_t i = 0; i < count; i++) {
        const resource_variable *v = find(c, reference[i], false, __func__);
        if (!v) return fmi2Error;
        if (v->origin != ORIGIN_NODE && v->origin != ORIGIN_SPAN) return say(c, fmi2Error, "%s: %s is not an output", __func__, v->name);
        if (order[i] != 1) return say(c, fmi2Error, "%s: only the first derivative of %s is known", __func__, v->name);
        int channel = rate_channel(v);
        if (channel >= 0) {
            double values[GALLOP_NODE_CHANNELS];
            gallop_observe_node(c->model, c->state, gallop_middle(c->model), values);
            value[i] = values[channel];
            continue;
        }
        if (c->now.last_step <= 0.0) {
            value[i] = 0.0;   /* before the first step there is nothing to take a difference from */
            continue;
        }
        if (!rewound) {
            copy_to_work(c);
            gallop_rewind(c->model, c->work, 1.0);
            rewound = true;
        }
        value[i] = (observed(c, v) - observed_in(c, c->work, v)) / c->now.last_step;
    }
    return fmi2OK;
}

/* The last communication step once more with changed inputs, its end left in `work`. */
static int step_again(instance *c, const double input[INPUTS], gallop_report *report)
{
    gallop_inputs in;
    copy_to_work(c);
    if (c->now.last_step > 0.0) {
        const double start = c->now.time - c->now.last_step;
        gallop_rewind(c->model, c->work, DERIVATIVE_SHARPNESS);
        step_inputs(input, c->now.before_rate, c->now.before_reached, gallop_state_time(c->work), c->now.time - start, &in);
        return gallop_advance(c->model, c->work, &in, c->now.time, report);
    }
    held_inputs(input, c->now.start, &in);
    return gallop_state_init(c->model, c->work, c->now.start, &in, report);
}

/* Derivatives of the outputs at the end of the last communication step by the inputs of that step: what a master needs
 * to iterate on it.  Central differences of two repetitions of the step, converged to round-off. */
fmi2Status fmi2GetDirectionalDerivative(fmi2Component component, const fmi2ValueReference unknown[], size_t unknowns,
                                        const fmi2ValueReference known[], size_t knowns, const fmi2Real seed[],
                                        fmi2Real derivative[])
{
    ALLOW(INITIALIZING | STEPPING);
    if ((unknowns && (!unknown || !derivative)) || (knowns && (!known || !seed))) return say(c, fmi2Error, "%s: an array is missing", __func__);
    if (c->now.mode == INITIALIZING && make_current(c) != fmi2OK) return fmi2Error;
    double direction[INPUTS] = {0.0}, largest = 0.0;
    for (size_t i = 0; i < knowns; i++) {
        const resource_variable *v = find(c, known[i], false, __func__);
        if (!v) return fmi2Error;
        if (v->origin != ORIGIN_INPUT) return say(c, fmi2Error, "%s: %s is not an input", __func__, v->name);
        if (!isfinite(seed[i])) return say(c, fmi2Error, "%s: the seed of %s must be a finite number", __func__, v->name);
        direction[v->place] += seed[i];
        largest = fmax(largest, fabs(direction[v->place]));
    }
    for (size_t i = 0; i < unknowns; i++) {
        const resource_variable *v = find(c, unknown[i], false, __func__);
        if (!v) return fmi2Error;
        if (v->origin != ORIGIN_NODE && v->origin != ORIGIN_SPAN) return say(c, fmi2Error, "%s: %s is not an output", __func__, v->name);
        derivative[i] = 0.0;
    }
    if (largest == 0.0) return fmi2OK;
    const double *base = c->now.last_step > 0.0 ? c->now.before_input : c->now.input;
    for (int sign = -1; sign <= 1; sign += 2) {
        double input[INPUTS];
        gallop_report report;
        for (int i = 0; i < INPUTS; i++) input[i] = base[i] + sign * DERIVATIVE_STEP / largest * direction[i];
        if (step_again(c, input, &report)) return tell(c, "the directional derivative could not be taken", &report);
        for (size_t i = 0; i < unknowns; i++) {
            const resource_variable *v = &resource_table(&c->parameters)[unknown[i]];
            derivative[i] += sign * observed_in(c, c->work, v) * largest / (2.0 * DERIVATIVE_STEP);
        }
    }
    return fmi2OK;
}
