/* FMI: communication steps, and derivatives of inputs and outputs. */
#include "fmi2_instance.h"

#define DERIVATIVE_STEP 1e-4      /* of the largest seed, in the unit of the input */
#define DERIVATIVE_SHARPNESS 1e-3 /* factor on the Newton tolerance for differences */

#define LONGEST_STEP                                                                               \
    1e6 /* [s]; whoever asks for more has mixed up his units, and would wait for ever */

/* The host's clock may be off by this much of a step, and by round-off. */
#define CLOCK_OF_STEP 1e-6
#define CLOCK_OF_TIME 1e-13

/* The kernel's inputs over a step of size h from `time`. */
static void step_inputs(const double input[INPUTS], const double rate[INPUTS],
                        const double reached[6], double time, double h, gallop_inputs *in)
{
    held_inputs(input, time, in);
    in->wind_speed_rate = rate[0];
    in->attack_angle_rate = rate[1];
    for (int i = 0; i < 6; i++) {
        in->support[i / 3][i % 3] = reached[i];
        in->support_rate[i / 3][i % 3] = (input[2 + i] + rate[2 + i] * h - reached[i]) / h;
    }
}

static fmi2Status check_step(instance *c, double time, double h)
{
    const double clock = CLOCK_OF_STEP * h + CLOCK_OF_TIME * fabs(time);
    if (!isfinite(time) || !isfinite(h) || !(h > 0.0))
        return say(c, fmi2Error, "fmi2DoStep: the step size %s s must be positive",
                   numeral_of(6, h).text);
    if (h > LONGEST_STEP)
        return say(c, fmi2Error, "fmi2DoStep: a step of %s s is too long; at most %s s",
                   numeral_of(6, h).text, numeral_of(6, LONGEST_STEP).text);
    if (fabs(time - c->now.time) > clock)
        return say(c, fmi2Error, "fmi2DoStep: the step starts at %s s, but the FMU is at %s s",
                   numeral_of(12, time).text, numeral_of(12, c->now.time).text);
    if (!(time + h > c->now.time) || !isfinite(time + h))
        return say(c, fmi2Error, "fmi2DoStep: at %s s a step of %s s is lost in round-off",
                   numeral_of(12, time).text, numeral_of(6, h).text);
    if (time + h > c->now.stop + clock)
        return say(c, fmi2Error, "fmi2DoStep: the step ends at %s s, after the stop time %s s",
                   numeral_of(12, time + h).text, numeral_of(12, c->now.stop).text);
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component component, fmi2Real time, fmi2Real h, fmi2Boolean no_return)
{
    (void)no_return;
    ALLOW(STEPPING);
    if (check_step(c, time, h) != fmi2OK) return fmi2Error;
    const double until = time + h, own = until - c->now.time;
    double rate[INPUTS];
    gallop_inputs in;
    gallop_report report;
    memcpy(rate, c->now.rate, sizeof rate);
    if (c->now.input[0] + rate[0] * own < 0.0)
        rate[0] = -c->now.input[0] / own; /* the wind dies, it does not turn */
    step_inputs(c->now.input, rate, c->now.reached, c->now.time, own, &in);
    c->now.status = gallop_advance(c->span.model, c->span.state, &in, until, &report);
    if (c->now.status) {
        if (c->before.kind == LAST_STEP)
            c->before.kind = NOTHING; /* the kernel has forgotten its beginning */
        return tell(c, "the step could not be carried out", &report);
    }
    c->before.kind = LAST_STEP;
    c->before.step = own;
    memcpy(c->before.input, c->now.input, sizeof c->before.input);
    memcpy(c->before.rate, rate, sizeof c->before.rate);
    memcpy(c->before.reached, c->now.reached, sizeof c->before.reached);
    for (int i = 0; i < 6; i++) c->now.reached[i] = c->now.input[2 + i] + rate[2 + i] * own;
    memset(c->now.rate, 0, sizeof c->now.rate);
    c->now.time = until;
    forget_observations(c);
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
    ALLOW(STEPPING | TERMINATED);
    return say(c, fmi2Discard, "fmi2GetStatus: steps are carried out at once, none is pending");
}

fmi2Status fmi2GetRealStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Real *value)
{
    ALLOW(STEPPING | TERMINATED);
    if (kind != fmi2LastSuccessfulTime || !value)
        return say(c, fmi2Discard, "fmi2GetRealStatus: only fmi2LastSuccessfulTime is known");
    *value = c->now.time;
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component component, const fmi2StatusKind kind,
                                fmi2Integer *value)
{
    (void)kind;
    (void)value;
    ALLOW(STEPPING | TERMINATED);
    return say(c, fmi2Discard, "fmi2GetIntegerStatus: nothing is known");
}

fmi2Status fmi2GetBooleanStatus(fmi2Component component, const fmi2StatusKind kind,
                                fmi2Boolean *value)
{
    ALLOW(STEPPING | TERMINATED);
    if (kind != fmi2Terminated || !value)
        return say(c, fmi2Discard, "fmi2GetBooleanStatus: only fmi2Terminated is known");
    *value = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component component, const fmi2StatusKind kind,
                               fmi2String *value)
{
    (void)kind;
    (void)value;
    ALLOW(STEPPING | TERMINATED);
    return say(c, fmi2Discard, "fmi2GetStringStatus: nothing is known");
}

static const resource_variable *find_input(instance *c, fmi2ValueReference reference,
                                           const char *function)
{
    const resource_variable *v = find(c, reference, false, function);
    if (v && v->origin != ORIGIN_INPUT) {
        say(c, fmi2Error, "%s: %s is not an input", function, v->name);
        return NULL;
    }
    return v;
}

static const resource_variable *find_output(instance *c, fmi2ValueReference reference,
                                            const char *function)
{
    const resource_variable *v = find(c, reference, false, function);
    if (v && v->origin != ORIGIN_NODE && v->origin != ORIGIN_SPAN) {
        say(c, fmi2Error, "%s: %s is not an output", function, v->name);
        return NULL;
    }
    return v;
}

/* All rates are taken, or none; they hold until the end of the next step, in whatever order value
 * and rate come. */
fmi2Status fmi2SetRealInputDerivatives(fmi2Component component,
                                       const fmi2ValueReference reference[], size_t count,
                                       const fmi2Integer order[], const fmi2Real value[])
{
    ALLOW(SETTABLE);
    if (count && (!reference || !order || !value))
        return say(c, fmi2Error, "%s: an array is missing", __func__);
    for (size_t i = 0; i < count; i++) {
        const resource_variable *v = find_input(c, reference[i], __func__);
        if (!v) return fmi2Error;
        if (order[i] != 1)
            return say(c, fmi2Error,
                       "%s: only the first derivative of %s is taken, not that of order %d",
                       __func__, v->name, order[i]);
        if (!isfinite(value[i]))
            return say(c, fmi2Error, "%s: the derivative of %s must be a finite number", __func__,
                       v->name);
    }
    for (size_t i = 0; i < count; i++)
        c->now.rate[resource_table(&c->parameters)[reference[i]].place] = value[i];
    return fmi2OK;
}

/* Channel whose value is the time derivative of a mid-span channel; -1 where a difference over the
 * step must do. */
static int rate_channel(const resource_variable *v)
{
    return v->origin == ORIGIN_NODE && v->place <= GALLOP_OMEGA
             ? (int)v->place + GALLOP_V1 - GALLOP_U1
             : -1;
}

static void copy_to_work(instance *c)
{
    memcpy(c->span.work, c->span.state, gallop_state_size(c->span.model));
}

static fmi2Status not_known(instance *c, const char *function)
{
    return say(c, fmi2Error,
               "%s: known only after a step, not after a restored state or a failed one", function);
}

/* At the beginning, where there is no step to take a difference over, forces and tension are held:
 * their rate is 0. */
fmi2Status fmi2GetRealOutputDerivatives(fmi2Component component,
                                        const fmi2ValueReference reference[], size_t count,
                                        const fmi2Integer order[], fmi2Real value[])
{
    ALLOW(STEPPING | TERMINATED);
    if (count && (!reference || !order || !value))
        return say(c, fmi2Error, "%s: an array is missing", __func__);
    bool rewound = false;
    for (size_t i = 0; i < count; i++) {
        const resource_variable *v = find_output(c, reference[i], __func__);
        if (!v) return fmi2Error;
        if (order[i] != 1)
            return say(c, fmi2Error, "%s: only the first derivative of %s is known", __func__,
                       v->name);
        const int channel = rate_channel(v);
        if (channel >= 0) {
            double node[GALLOP_NODE_CHANNELS];
            if (gallop_observe_node(c->span.model, c->span.state, gallop_middle(c->span.model),
                                    node))
                return cannot_observe(c, v, __func__);
            value[i] = node[channel];
            continue;
        }
        if (c->before.kind == NOTHING) return not_known(c, __func__);
        value[i] = 0.0;
        if (c->before.kind == BEGINNING) continue;
        if (!rewound) {
            copy_to_work(c);
            if (gallop_rewind(c->span.model, c->span.work, 1.0))
                return cannot_observe(c, v, __func__);
            rewound = true;
        }
        double now, then;
        if (observed(c, v, &now) || observed_in(c, c->span.work, v, &then))
            return cannot_observe(c, v, __func__);
        value[i] = (now - then) / c->before.step;
    }
    return fmi2OK;
}

/* The last communication step, or the initial state, once more with changed inputs; `work` holds
 * what comes of it. */
static int once_more(instance *c, const double input[INPUTS], gallop_report *report)
{
    const gallop_model *model = c->span.model;
    gallop_inputs in;
    if (c->before.kind == LAST_STEP) {
        copy_to_work(c);
        const int outcome = gallop_rewind(model, c->span.work, DERIVATIVE_SHARPNESS);
        if (outcome) return outcome;
        const double start = gallop_state_time(c->span.work);
        step_inputs(input, c->before.rate, c->before.reached, start, c->before.step, &in);
        return gallop_advance(model, c->span.work, &in, c->now.time, report);
    }
    held_inputs(input, c->now.start, &in);
    return gallop_state_init(model, c->span.work, c->now.start, &in, report);
}

/* Derivatives of the outputs at the end of the last communication step by the inputs of that step:
 * what a master needs to iterate on it; before the first step, of the initial state by its inputs.
 * Central differences of two repetitions, converged to round-off. */
fmi2Status fmi2GetDirectionalDerivative(fmi2Component component, const fmi2ValueReference unknown[],
                                        size_t unknowns, const fmi2ValueReference known[],
                                        size_t knowns, const fmi2Real seed[], fmi2Real derivative[])
{
    ALLOW(INITIALIZING | STEPPING | TERMINATED);
    if ((unknowns && (!unknown || !derivative)) || (knowns && (!known || !seed)))
        return say(c, fmi2Error, "%s: an array is missing", __func__);
    double direction[INPUTS] = {0.0}, largest = 0.0;
    for (size_t i = 0; i < knowns; i++) {
        const resource_variable *v = find_input(c, known[i], __func__);
        if (!v) return fmi2Error;
        direction[v->place] += seed[i];
        if (!isfinite(direction[v->place]))
            return say(c, fmi2Error, "%s: the seed of %s must be a finite number", __func__,
                       v->name);
    }
    for (int i = 0; i < INPUTS; i++) largest = fmax(largest, fabs(direction[i]));
    for (size_t i = 0; i < unknowns; i++)
        if (!find_output(c, unknown[i], __func__)) return fmi2Error;
    if (c->now.mode == INITIALIZING) {
        if (make_current(c) != fmi2OK) return fmi2Error;
    } else if (c->before.kind == NOTHING) {
        return not_known(c, __func__);
    }
    for (size_t i = 0; i < unknowns; i++) derivative[i] = 0.0;
    if (largest == 0.0) return fmi2OK;
    for (int sign = -1; sign <= 1; sign += 2) {
        double input[INPUTS];
        gallop_report report;
        for (int i = 0; i < INPUTS; i++)
            input[i] = (c->now.mode == INITIALIZING ? c->now.input : c->before.input)[i] +
                       sign * DERIVATIVE_STEP * (direction[i] / largest);
        if (once_more(c, input, &report))
            return tell(c, "the directional derivative could not be taken", &report);
        for (size_t i = 0; i < unknowns; i++) {
            const resource_variable *v = &resource_table(&c->parameters)[unknown[i]];
            double value;
            if (observed_in(c, c->span.work, v, &value)) return cannot_observe(c, v, __func__);
            derivative[i] += sign * value / (2.0 * DERIVATIVE_STEP) * largest;
        }
    }
    return fmi2OK;
}
