/* The model and the state of an instance. */
#include "cosim_span.h"

#include "cosim_message.h"

#include <stdlib.h>
#include <string.h>

void cosim_span_free(cosim_span *span)
{
    gallop_model_free(span->model);
    free(span->state);
    free(span->work);
    memset(span, 0, sizeof *span);
}

void cosim_forget_observations(gallop_cosim *c)
{
    c->node_known = c->forces_known = false;
}

void cosim_span_drop(gallop_cosim *c)
{
    cosim_span_free(&c->span);
    c->started = false;
    cosim_forget_observations(c);
}

gallop_cosim_status cosim_span_build(gallop_cosim *c, cosim_span *span)
{
    const gallop_scene scene = resource_scene(&c->parameters);
    gallop_report report = {.element = -1};
    memset(span, 0, sizeof *span);
    const int outcome = gallop_model_create(&scene, &span->model, &report);
    if (outcome) return cosim_fail_with_report(c, "the parameters do not make a span", &report);

    const size_t size = gallop_state_size(span->model);
    span->state = calloc(1, size);
    span->work = calloc(1, size);
    if (span->state && span->work) return GALLOP_COSIM_OK;
    cosim_span_free(span);
    return cosim_fail(c, "there is not enough memory for the state: %lu bytes; use fewer elements",
                      (unsigned long)size);
}

void cosim_constant_inputs(const double input[RESOURCE_INPUTS], double time, gallop_inputs *in)
{
    memset(in, 0, sizeof *in);
    in->time = time;
    in->wind_speed = input[0];
    in->attack_angle = input[1];
    memcpy(in->support, input + 2, sizeof in->support);
}

gallop_cosim_status cosim_span_make_current(gallop_cosim *c)
{
    if (c->started) return GALLOP_COSIM_OK;
    if (!c->span.model && cosim_span_build(c, &c->span) != GALLOP_COSIM_OK) {
        c->run.status = GALLOP_INVALID_SCENE;
        return GALLOP_COSIM_FAILED;
    }

    gallop_inputs in;
    gallop_report report;
    cosim_constant_inputs(c->run.input, c->run.start, &in);
    cosim_forget_observations(c);
    c->run.status = gallop_state_init(c->span.model, c->span.state, c->run.start, &in, &report);
    if (c->run.status) return cosim_fail_with_report(c, "there is no initial state", &report);

    memcpy(c->run.tower, c->run.input + 2, sizeof c->run.tower);
    memcpy(c->last_step.input, c->run.input, sizeof c->run.input);
    c->last_step.base = COSIM_DERIV_AT_START;
    c->run.time = c->run.start;
    c->started = true;
    return GALLOP_COSIM_OK;
}
