/* Derivatives of outputs: in time, and by the inputs of the last communication step. */
#include "cosim_message.h"
#include "cosim_span.h"
#include "cosim_step.h"
#include "cosim_values.h"

#include <math.h>
#include <string.h>

/* Central differences: change of the input with the largest seed, in its unit, and the factor on
 * the Newton tolerance of the two repetitions. */
#define INPUT_CHANGE 1e-4
#define NEWTON_FACTOR 1e-3

static const resource_variable *find_output(gallop_cosim *c, uint32_t reference)
{
    const resource_variable *v = cosim_find(c, reference, false);
    if (v && v->origin != RESOURCE_NODE && v->origin != RESOURCE_SPAN) {
        cosim_refuse(c, "%s is not an output; give value references of outputs", v->name);
        return NULL;
    }
    return v;
}

/* Channel whose value is the time derivative of a mid-span channel; -1: there is none. */
static int rate_channel(const resource_variable *v)
{
    return v->origin == RESOURCE_NODE && v->index <= GALLOP_OMEGA
             ? (int)v->index + GALLOP_V1 - GALLOP_U1
             : -1;
}

static void copy_state_to_work(gallop_cosim *c)
{
    memcpy(c->span.work, c->span.state, gallop_state_size(c->span.model));
}

static gallop_cosim_status refuse_without_step(gallop_cosim *c)
{
    return cosim_refuse(c, "derivatives are known only after a step, not after a restored state or "
                           "a failed step; make a step first");
}

/* The rate of an output that has no channel for it: its difference over the last step.  `work`
 * holds the state at the start of that step once `*rewound` is true. */
static gallop_cosim_status difference_rate(gallop_cosim *c, const resource_variable *v,
                                           bool *rewound, double *rate)
{
    if (c->last_step.base == COSIM_DERIV_UNKNOWN) return refuse_without_step(c);
    *rate = 0.0;
    if (c->last_step.base == COSIM_DERIV_AT_START) return GALLOP_COSIM_OK;
    if (!*rewound) {
        copy_state_to_work(c);
        if (gallop_rewind(c->span.model, c->span.work, 1.0)) return cosim_fail_to_observe(c, v);
        *rewound = true;
    }
    double now, before;
    if (cosim_observe(c, v, &now) || cosim_observe_in(c, c->span.work, v, &before))
        return cosim_fail_to_observe(c, v);
    *rate = (now - before) / c->last_step.size;
    return GALLOP_COSIM_OK;
}

gallop_cosim_status gallop_cosim_get_output_rates(gallop_cosim *c, const uint32_t reference[],
                                                  size_t count, double rate[])
{
    if (!cosim_is_allowed(c, COSIM_WITH_TIME, "reading derivatives of outputs"))
        return GALLOP_COSIM_REFUSED;
    if (count && (!reference || !rate))
        return cosim_refuse(c, "an array is a null pointer; give arrays for all values");
    bool rewound = false;
    for (size_t i = 0; i < count; i++) {
        const resource_variable *v = find_output(c, reference[i]);
        if (!v) return GALLOP_COSIM_REFUSED;
        const int channel = rate_channel(v);
        if (channel < 0) {
            const gallop_cosim_status status = difference_rate(c, v, &rewound, &rate[i]);
            if (status != GALLOP_COSIM_OK) return status;
            continue;
        }
        resource_variable of_rate = *v;
        of_rate.index = (uint32_t)channel;
        if (cosim_observe(c, &of_rate, &rate[i])) return cosim_fail_to_observe(c, v);
    }
    return GALLOP_COSIM_OK;
}

/* Repeats the last step, or the computation of the initial state, with other inputs; `work` holds
 * the result.  Returns a gallop_outcome. */
static int repeat_with(gallop_cosim *c, const double input[RESOURCE_INPUTS], gallop_report *report)
{
    const gallop_model *model = c->span.model;
    gallop_inputs in;
    if (c->last_step.base == COSIM_DERIV_LAST_STEP) {
        copy_state_to_work(c);
        const int outcome = gallop_rewind(model, c->span.work, NEWTON_FACTOR);
        if (outcome) {
            *report = (gallop_report){.outcome = outcome, .element = -1, .time = c->run.time};
            report->value = report->limit = NAN;
            return outcome;
        }
        const double start = gallop_state_time(c->span.work);
        cosim_step_inputs(input, c->last_step.rate, c->last_step.tower, start, c->last_step.size,
                          &in);
        return gallop_advance(model, c->span.work, &in, c->run.time, report);
    }
    cosim_constant_inputs(input, c->run.start, &in);
    return gallop_state_init(model, c->span.work, c->run.start, &in, report);
}

/* The direction in the space of all inputs: the sum of the seeds given for each. */
static gallop_cosim_status add_seeds(gallop_cosim *c, const uint32_t input[], size_t inputs,
                                     const double seed[], double direction[RESOURCE_INPUTS])
{
    memset(direction, 0, RESOURCE_INPUTS * sizeof *direction);
    for (size_t i = 0; i < inputs; i++) {
        const resource_variable *v = cosim_find_input(c, input[i]);
        if (!v) return GALLOP_COSIM_REFUSED;
        direction[v->index] += seed[i];
        if (!isfinite(direction[v->index]))
            return cosim_refuse(c, "the seed of %s must be a finite number", v->name);
    }
    return GALLOP_COSIM_OK;
}

/* Central difference along `direction`, whose largest component is `largest`. */
static gallop_cosim_status add_differences(gallop_cosim *c, const uint32_t output[], size_t outputs,
                                           const double direction[RESOURCE_INPUTS], double largest,
                                           double derivative[])
{
    const double *base = c->run.phase == COSIM_INITIALIZING ? c->run.input : c->last_step.input;
    for (int sign = -1; sign <= 1; sign += 2) {
        double input[RESOURCE_INPUTS];
        gallop_report report;
        for (int i = 0; i < RESOURCE_INPUTS; i++)
            input[i] = base[i] + sign * INPUT_CHANGE * (direction[i] / largest);
        if (repeat_with(c, input, &report))
            return cosim_fail_with_report(c, "the directional derivative could not be computed",
                                          &report);
        for (size_t i = 0; i < outputs; i++) {
            const resource_variable *v = &resource_variables(&c->parameters)[output[i]];
            double value;
            if (cosim_observe_in(c, c->span.work, v, &value)) return cosim_fail_to_observe(c, v);
            derivative[i] += sign * value / (2.0 * INPUT_CHANGE) * largest;
        }
    }
    return GALLOP_COSIM_OK;
}

/* Builds or finds the state whose derivatives are asked for. */
static gallop_cosim_status require_base(gallop_cosim *c)
{
    if (c->run.phase == COSIM_INITIALIZING) return cosim_span_make_current(c);
    return c->last_step.base == COSIM_DERIV_UNKNOWN ? refuse_without_step(c) : GALLOP_COSIM_OK;
}

static gallop_cosim_status check_outputs(gallop_cosim *c, const uint32_t output[], size_t outputs)
{
    for (size_t i = 0; i < outputs; i++)
        if (!find_output(c, output[i])) return GALLOP_COSIM_REFUSED;
    return GALLOP_COSIM_OK;
}

gallop_cosim_status gallop_cosim_directional_derivative(gallop_cosim *c, const uint32_t output[],
                                                        size_t outputs, const uint32_t input[],
                                                        size_t inputs, const double seed[],
                                                        double derivative[])
{
    const int phases = COSIM_INITIALIZING | COSIM_STEPPING | COSIM_TERMINATED;
    if (!cosim_is_allowed(c, phases, "a directional derivative")) return GALLOP_COSIM_REFUSED;
    if ((outputs && (!output || !derivative)) || (inputs && (!input || !seed)))
        return cosim_refuse(c, "an array is a null pointer; give arrays for all values");

    double direction[RESOURCE_INPUTS], largest = 0.0;
    gallop_cosim_status status = add_seeds(c, input, inputs, seed, direction);
    if (status == GALLOP_COSIM_OK) status = check_outputs(c, output, outputs);
    if (status == GALLOP_COSIM_OK) status = require_base(c);
    if (status != GALLOP_COSIM_OK) return status;

    for (int i = 0; i < RESOURCE_INPUTS; i++) largest = fmax(largest, fabs(direction[i]));
    for (size_t i = 0; i < outputs; i++) derivative[i] = 0.0;
    if (largest == 0.0) return GALLOP_COSIM_OK;
    return add_differences(c, output, outputs, direction, largest, derivative);
}
