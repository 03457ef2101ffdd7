/* The model and the state of an instance. */
#include "cosim_span.h"

#include "base_memory.h"
#include "cosim_message.h"

#include <stdlib.h>
#include <string.h>

void cosim_span_free(cosim_span *span)
{
    gallop_model_free(span->model);
    free(span->allocated);
    memset(span, 0, sizeof *span);
}

void cosim_forget_observations(gallop_cosim *c)
{
    c->observed_known[false] = c->observed_known[true] = false;
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
    gallop_report report = {.element = -1, .device = -1};
    memset(span, 0, sizeof *span);
    const int outcome = gallop_model_create(&scene, &span->model, &report);
    if (outcome) return cosim_fail_with_report(c, "the parameters do not make a span", &report);

    const size_t size = gallop_state_size(span->model);
    const size_t room = base_whole_vectors(size);
    span->allocated = calloc(1, 2 * room + VECTOR);
    if (span->allocated) {
        char *const first = base_first_vector(span->allocated);
        span->state = (gallop_state *)first;
        span->work = (gallop_state *)(first + room);
        return GALLOP_COSIM_OK;
    }
    cosim_span_free(span);
    return cosim_fail(c, "there is not enough memory for the state: %lu bytes; use fewer elements",
                      (unsigned long)size);
}

/* Rate of an input in a step, that of its own velocity input included. */
static double given_rate(const gallop_cosim *c, const cosim_inputs *with, uint32_t input,
                         double size)
{
    const int32_t k = c->velocity[input];
    if (k < 0) return with->rate[input];
    return with->rate[input] + (with->value[k] + 0.5 * size * with->rate[k]);
}

/* True if the host gives the velocity of a tower's point, which may be zero. */
static bool is_given(const gallop_cosim *c, const cosim_inputs *with, uint32_t input)
{
    const int32_t k = c->velocity[input];
    return with->given[input] != 0.0 || (k >= 0 && with->given[k] != 0.0);
}

/* Velocity of a tower's point without the part that a ramp adds: the given velocity; if none is
 * given, the velocity of the last longer step (trend). */
static double steady_rate(const gallop_cosim *c, const cosim_inputs *with, uint32_t input,
                          double size)
{
    return is_given(c, with, input) ? given_rate(c, with, input, size) : with->trend[input];
}

/* Velocity of a tower's point in a step.  It reaches the given place at the end of the step; in a
 * step shorter than the ramp it moves steadily, and what is missing takes the time `ramp`. */
static double motion_rate_of(const gallop_cosim *c, const cosim_inputs *with, uint32_t input,
                             double size, double ramp)
{
    const double way =
        with->value[input] + given_rate(c, with, input, size) * size - with->reached[input];
    if (ramp <= size) return way / size;
    const double steady = steady_rate(c, with, input, size);
    return steady + (way - steady * size) / ramp;
}

double cosim_trend_after(const gallop_cosim *c, const cosim_inputs *with, uint32_t input,
                         double size, double ramp)
{
    const double steady = steady_rate(c, with, input, size);
    const double moved = motion_rate_of(c, with, input, size, ramp);
    if (is_given(c, with, input)) return steady;
    return ramp > size ? steady + (moved - steady) * (size / ramp) : moved;
}

double cosim_place_after(const gallop_cosim *c, const cosim_inputs *with, uint32_t input,
                         double size, double ramp)
{
    if (ramp > size)
        return with->reached[input] + motion_rate_of(c, with, input, size, ramp) * size;
    return with->value[input] + given_rate(c, with, input, size) * size;
}

gallop_inputs cosim_linear_inputs(gallop_cosim *c, const cosim_inputs *with, double time,
                                  double size, double ramp)
{
    const resource *r = &c->parameters;
    const resource_target *t = resource_targets(r);
    const int32_t fields = (int32_t)r->section[RESOURCE_FIELDS].count;
    const int32_t junctions = (int32_t)r->section[RESOURCE_JUNCTIONS].count;
    double *wind_rate = c->wind + fields, *turn_rate = c->wind_direction + fields,
           *motion_rate = c->motion + 3 * junctions;
    gallop_inputs in = {.time = time,
                        .fields = fields,
                        .junctions = junctions,
                        .wind = c->wind,
                        .motion = c->motion};
    memset(c->wind, 0, 2 * (size_t)fields * sizeof *c->wind);
    memset(c->wind_direction, 0, 2 * (size_t)fields * sizeof *c->wind_direction);
    memset(c->motion, 0, 6 * (size_t)junctions * sizeof *c->motion);
    for (uint32_t i = 0; i < r->section[RESOURCE_TARGETS].count; i++) {
        const uint32_t k = t[i].input;
        const double rate = size > 0.0 ? with->rate[k] : 0.0;
        const int32_t at = t[i].index, axis = 3 * at + t[i].axis;
        if (t[i].kind == RESOURCE_WIND) {
            c->wind[at] = with->value[k];
            wind_rate[at] = rate;
        } else if (t[i].kind == RESOURCE_WIND_DIRECTION) {
            in.direction = c->wind_direction;
            c->wind_direction[at] = with->value[k];
            turn_rate[at] = rate;
        } else if (t[i].kind == RESOURCE_ATTACK_ANGLE) {
            in.attack_angle = with->value[k];
            in.attack_angle_rate = rate;
        } else if (t[i].kind == RESOURCE_MOTION) {
            c->motion[axis] = size > 0.0 ? with->reached[k] : with->value[k];
            motion_rate[axis] = size > 0.0 ? motion_rate_of(c, with, k, size, ramp) : 0.0;
        }
    }
    return in;
}

void cosim_copy_inputs(const gallop_cosim *c, cosim_inputs *to, const cosim_inputs *from)
{
    memcpy(to->value, from->value, cosim_input_bytes(c));
    memcpy(to->rate, from->rate, cosim_input_bytes(c));
    memcpy(to->reached, from->reached, cosim_input_bytes(c));
    memcpy(to->trend, from->trend, cosim_input_bytes(c));
    memcpy(to->given, from->given, cosim_input_bytes(c));
}

gallop_cosim_status cosim_span_make_current(gallop_cosim *c)
{
    if (c->started) return GALLOP_COSIM_OK;
    if (!c->span.model && cosim_span_build(c, &c->span) != GALLOP_COSIM_OK) {
        c->run.status = GALLOP_INVALID_SCENE;
        return GALLOP_COSIM_FAILED;
    }

    gallop_report report;
    const gallop_inputs in = cosim_linear_inputs(c, &c->in, c->run.start, 0.0, 0.0);
    cosim_forget_observations(c);
    c->run.status = gallop_state_init(c->span.model, c->span.state, c->run.start, &in, &report);
    if (c->run.status) return cosim_fail_with_report(c, "there is no initial state", &report);

    memcpy(c->in.reached, c->in.value, cosim_input_bytes(c));
    memset(c->in.trend, 0, cosim_input_bytes(c));
    cosim_copy_inputs(c, &c->last_step.with, &c->in);
    c->last_step.base = COSIM_DERIV_AT_START;
    c->last_step.ramp = 0.0;
    c->run.time = c->run.start;
    c->started = true;
    return GALLOP_COSIM_OK;
}
