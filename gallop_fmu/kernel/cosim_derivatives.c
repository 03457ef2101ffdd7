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
    if (v && v->origin != RESOURCE_SUM && v->origin != RESOURCE_TURN &&
        v->origin != RESOURCE_STATIC) {
        cosim_refuse(c, "%s is not an output; give value references of outputs", v->name);
        return NULL;
    }
    return v;
}

static void copy_state_to_work(gallop_cosim *c)
{
    memcpy(c->span.work, c->span.state, gallop_state_size(c->span.model));
}

static gallop_cosim_status refuse_without_step(gallop_cosim *c)
{
    return cosim_refuse(c,
                        "derivatives are known only after a step, not after a failed one; make a "
                        "step first");
}

/* The rate of an output that has no channel for it: its difference over the last step.  `work`
 * holds the state at the start of that step once `*rewound` is true. */
static gallop_cosim_status difference_rate(gallop_cosim *c, const resource_variable *v,
                                           bool *rewound, double *rate)
{
    if (c->last_step.base == COSIM_DERIV_UNKNOWN) return refuse_without_step(c);
    *rate = 0.0;
    if (c->last_step.base == COSIM_DERIV_AT_START || v->origin == RESOURCE_STATIC)
        return GALLOP_COSIM_OK;
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
        if (cosim_has_exact_rate(c, v)) {
            if (cosim_observe_rate(c, v, &rate[i])) return cosim_fail_to_observe(c, v);
            continue;
        }
        const gallop_cosim_status status = difference_rate(c, v, &rewound, &rate[i]);
        if (status != GALLOP_COSIM_OK) return status;
    }
    return GALLOP_COSIM_OK;
}

/* Repeats the last step, or the computation of the initial state, with other inputs; `work` holds
 * the result.  Returns a gallop_outcome. */
static int repeat_with(gallop_cosim *c, double *input, gallop_report *report)
{
    const gallop_model *model = c->span.model;
    const cosim_inputs with = {input, c->last_step.with.rate, c->last_step.with.reached,
                               c->last_step.with.trend, c->last_step.with.given};
    if (c->last_step.base == COSIM_DERIV_LAST_STEP) {
        copy_state_to_work(c);
        const int outcome = gallop_rewind(model, c->span.work, NEWTON_FACTOR);
        if (outcome) {
            *report = (gallop_report){
                .outcome = outcome, .element = -1, .device = -1, .time = c->run.time};
            report->value = report->limit = NAN;
            return outcome;
        }
        const double start = gallop_state_time(c->span.work);
        const gallop_inputs in =
            cosim_linear_inputs(c, &with, start, c->last_step.size, c->last_step.ramp);
        return gallop_advance(model, c->span.work, &in, c->run.time, report);
    }
    const gallop_inputs in = cosim_linear_inputs(c, &with, c->run.start, 0.0, 0.0);
    return gallop_state_init(model, c->span.work, c->run.start, &in, report);
}

/* The direction in the space of all inputs: the sum of the seeds given for each. */
static gallop_cosim_status add_seeds(gallop_cosim *c, const uint32_t input[], size_t inputs,
                                     const double seed[], double *direction)
{
    memset(direction, 0, cosim_input_bytes(c));
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
                                           const double *direction, double largest,
                                           double derivative[])
{
    const double *base = c->run.phase == COSIM_INITIALIZING ? c->in.value : c->last_step.with.value;
    double *input = c->other;
    for (int sign = -1; sign <= 1; sign += 2) {
        gallop_report report;
        for (uint32_t i = 0; i < c->input_count; i++)
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

    double *direction = c->direction, largest = 0.0;
    gallop_cosim_status status = add_seeds(c, input, inputs, seed, direction);
    if (status == GALLOP_COSIM_OK) status = check_outputs(c, output, outputs);
    if (status == GALLOP_COSIM_OK) status = require_base(c);
    if (status != GALLOP_COSIM_OK) return status;

    for (uint32_t i = 0; i < c->input_count; i++) largest = fmax(largest, fabs(direction[i]));
    for (size_t i = 0; i < outputs; i++) derivative[i] = 0.0;
    if (largest == 0.0) return GALLOP_COSIM_OK;
    return add_differences(c, output, outputs, direction, largest, derivative);
}
