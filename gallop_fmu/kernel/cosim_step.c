/* Communication steps. */
#include "cosim_step.h"

#include "cosim_message.h"
#include "cosim_span.h"
#include "cosim_values.h"

#include <math.h>
#include <string.h>

/* Differences between the host's clock and the instance's that are put down to round-off: as a
 * fraction of the step, and of the time. */
#define CLOCK_OF_STEP 1e-6
#define CLOCK_OF_TIME 1e-13

static gallop_cosim_status check_step(gallop_cosim *c, double time, double step)
{
    const double clock = CLOCK_OF_STEP * step + CLOCK_OF_TIME * fabs(time);
    if (!isfinite(time) || !isfinite(step) || !(step > 0.0))
        return cosim_refuse(c, "the step size %s s at %s s must be positive; both must be finite",
                            cosim_number_text(6, step).text, cosim_number_text(12, time).text);
    if (step > COSIM_MAX_STEP)
        return cosim_refuse(c, "a step of %s s is too long; at most %s s are allowed",
                            cosim_number_text(6, step).text,
                            cosim_number_text(6, COSIM_MAX_STEP).text);
    if (fabs(time - c->run.time) > clock)
        return cosim_refuse(
            c, "the step starts at %s s, but the FMU is at %s s; start it where the last one ended",
            cosim_number_text(12, time).text, cosim_number_text(12, c->run.time).text);
    if (!(time + step > c->run.time) || !isfinite(time + step))
        return cosim_refuse(c, "at %s s a step of %s s is lost in round-off; take longer steps",
                            cosim_number_text(12, time).text, cosim_number_text(6, step).text);
    if (time + step > c->run.stop + clock)
        return cosim_refuse(
            c, "the step ends at %s s, after the stop time %s s; set a later stop time",
            cosim_number_text(12, time + step).text, cosim_number_text(12, c->run.stop).text);
    return GALLOP_COSIM_OK;
}

/* The rates that the host gave; a wind speed may become 0 within the step, but keeps its side. */
static void choose_rates(const gallop_cosim *c, double size, double *rate)
{
    memcpy(rate, c->in.rate, cosim_input_bytes(c));
    for (uint32_t i = 0; i < c->input_count; i++) {
        if (resource_first_target(&c->parameters, i)->kind != RESOURCE_WIND) continue;
        const double value = c->in.value[i], reached = value + rate[i] * size;
        if (value < 0.0 ? reached > 0.0 : reached < 0.0) rate[i] = -value / size;
    }
}

/* A host may set all inputs that it does not use to zero. Velocities count as given from the first
 * one on that is not zero. */
static void note_velocities(gallop_cosim *c)
{
    for (uint32_t i = 0; i < c->input_count; i++) {
        const int32_t k = c->velocity[i];
        if (k >= 0 && c->in.value[k] != 0.0) c->in.given[k] = 1.0;
    }
}

/* Time in which towers reach their places: the step, or what is left of the time of a longer step
 * before.  The way that a late host gives still belongs to that step, and would need a velocity
 * without bound. */
static double ramp_of_step(const gallop_cosim *c, double size)
{
    return fmax(size, c->last_step.ramp - size);
}

gallop_cosim_status gallop_cosim_step(gallop_cosim *c, double time, double step)
{
    if (!cosim_is_allowed(c, COSIM_STEPPING, "a step")) return GALLOP_COSIM_REFUSED;
    if (check_step(c, time, step) != GALLOP_COSIM_OK) return GALLOP_COSIM_REFUSED;

    /* From the instance's own time, so that differences of the clocks do not add up. */
    const double until = time + step, size = until - c->run.time;
    const cosim_inputs with = {c->in.value, c->step_rate, c->in.reached, c->in.trend, c->in.given};
    choose_rates(c, size, with.rate);
    note_velocities(c);

    gallop_report report;
    const double ramp = ramp_of_step(c, size);
    const gallop_inputs in = cosim_linear_inputs(c, &with, c->run.time, size, ramp);
    c->run.status = gallop_advance(c->span.model, c->span.state, &in, until, &report);
    if (c->run.status) {
        /* The kernel no longer has the state at the start of the last step. */
        if (c->last_step.base == COSIM_DERIV_LAST_STEP) c->last_step.base = COSIM_DERIV_UNKNOWN;
        return cosim_fail_with_report(c, "the step could not be carried out", &report);
    }

    c->last_step.base = COSIM_DERIV_LAST_STEP;
    c->last_step.size = size;
    c->last_step.ramp = ramp;
    cosim_copy_inputs(c, &c->last_step.with, &with);
    for (uint32_t i = 0; i < c->input_count; i++) {
        c->in.reached[i] = cosim_place_after(c, &c->last_step.with, i, size, ramp);
        c->in.trend[i] = cosim_trend_after(c, &c->last_step.with, i, size, ramp);
    }
    memset(c->in.rate, 0, cosim_input_bytes(c));
    for (uint32_t i = 0; i < c->input_count; i++)
        if (c->velocity[i] >= 0) c->in.given[i] = 0.0; /* the rate of a place holds for a step */
    c->run.time = until;
    cosim_forget_observations(c);
    return GALLOP_COSIM_OK;
}

gallop_cosim_status gallop_cosim_time(gallop_cosim *c, double *time)
{
    if (!cosim_is_allowed(c, COSIM_WITH_TIME, "reading the time")) return GALLOP_COSIM_REFUSED;
    if (!time) return cosim_refuse(c, "there is no place for the time; give one");
    *time = c->run.time;
    return GALLOP_COSIM_OK;
}

const resource_variable *cosim_find_input(gallop_cosim *c, uint32_t reference)
{
    const resource_variable *v = cosim_find(c, reference, false);
    if (v && v->origin != RESOURCE_INPUT) {
        cosim_refuse(c, "%s is not an input; give value references of inputs", v->name);
        return NULL;
    }
    return v;
}

/* They hold until the end of the next step, whether the value is set before or after the rate. */
gallop_cosim_status gallop_cosim_set_input_rates(gallop_cosim *c, const uint32_t reference[],
                                                 size_t count, const double rate[])
{
    if (!cosim_is_allowed(c, COSIM_BEFORE_TERMINATION, "setting derivatives of inputs"))
        return GALLOP_COSIM_REFUSED;
    if (count && (!reference || !rate))
        return cosim_refuse(c, "an array is a null pointer; give arrays for all values");
    for (size_t i = 0; i < count; i++) {
        const resource_variable *v = cosim_find_input(c, reference[i]);
        if (!v) return GALLOP_COSIM_REFUSED;
        if (!isfinite(rate[i]))
            return cosim_refuse(c, "the derivative of %s must be a finite number", v->name);
    }
    for (size_t i = 0; i < count; i++) {
        const uint32_t input = resource_variables(&c->parameters)[reference[i]].index;
        c->in.rate[input] = rate[i];
        c->in.given[input] = 1.0;
    }
    return GALLOP_COSIM_OK;
}
