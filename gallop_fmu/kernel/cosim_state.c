/* Saving, restoring and serialising the state of an instance. */
#include "cosim_message.h"
#include "cosim_span.h"
#include "cosim_values.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define STATE_MAGIC "GALLOPFA" /* the last character is the version of the format */

/* Followed by the arrays of `cosim_inputs`, the same of the last step, the parameters, as stored in
 * the scene, the kernel's state, and its state at the start of the last step.  Without gaps: it is
 * written as bytes. */
struct gallop_cosim_saved {
    char magic[8];
    uint64_t size, checksum; /* of everything; of all bytes that follow this field */
    resource_identification identity;
    cosim_run run;
    uint64_t inputs, parameters; /* how many */
    uint64_t state, before;      /* how many bytes; 0: there is none */
    double last_size;            /* of the last step [s]; 0 without one */
    double ramp;                 /* of the last step [s] */
    uint64_t has_last_inputs;    /* 1: derivatives can be taken, of the last step or at the start */
    uint64_t deserialised;       /* 1: validate before use */
};
typedef struct gallop_cosim_saved saved_state;

#define CHECKED_FROM offsetof(saved_state, identity)

/* A guard against other pointers. */
static bool is_saved(const saved_state *s)
{
    return s && (uintptr_t)s % sizeof(uint64_t) == 0 &&
           memcmp(s->magic, STATE_MAGIC, sizeof s->magic) == 0;
}

static const double *inputs_in(const saved_state *s)
{
    return (const double *)(s + 1);
}

static const double *last_inputs_in(const saved_state *s)
{
    return inputs_in(s) + COSIM_INPUT_ARRAYS * s->inputs;
}

static const double *parameters_in(const saved_state *s)
{
    return last_inputs_in(s) + COSIM_INPUT_ARRAYS * s->inputs;
}

static const char *state_in(const saved_state *s)
{
    return (const char *)(parameters_in(s) + s->parameters);
}

static const char *before_in(const saved_state *s)
{
    return state_in(s) + s->state;
}

static size_t saved_size(uint64_t inputs, uint64_t parameters, uint64_t states)
{
    return sizeof(saved_state) +
           (size_t)(2 * COSIM_INPUT_ARRAYS * inputs + parameters) * sizeof(double) + (size_t)states;
}

static size_t parameter_bytes(const gallop_cosim *c)
{
    return c->parameter_count * sizeof(double);
}

static bool is_of_this_resource(const gallop_cosim *c, const saved_state *s)
{
    return memcmp(&s->identity, resource_identity(&c->parameters), sizeof s->identity) == 0 &&
           s->inputs == c->input_count && s->parameters == c->parameter_count;
}

static char *append(char *to, const void *from, size_t size)
{
    if (size) memcpy(to, from, size);
    return to + size;
}

/* Room for a saved state, the caller's if its size fits; false: there is not enough memory. */
static bool provide_room(gallop_cosim_saved **saved, size_t size)
{
    if (*saved && (*saved)->size == size) return true;
    saved_state *s = malloc(size);
    if (!s) return false;
    free(*saved);
    *saved = s;
    return true;
}

gallop_cosim_status gallop_cosim_save(gallop_cosim *c, gallop_cosim_saved **saved)
{
    if (!c) return GALLOP_COSIM_REFUSED;
    if (!saved) return cosim_refuse(c, "there is no place for the state; give one");

    const cosim_last_step *last = &c->last_step;
    const bool has_step = c->started && last->base == COSIM_DERIV_LAST_STEP;
    const bool has_last_inputs = c->started && last->base != COSIM_DERIV_UNKNOWN;
    const size_t kernel = c->started ? gallop_saved_size(c->span.model) : 0;
    const size_t before = has_step ? kernel : 0;
    const size_t size = saved_size(c->input_count, c->parameter_count, kernel + before);
    if (!provide_room(saved, size))
        return cosim_fail(c,
                          "there is not enough memory to save the state: %lu bytes; free saved "
                          "states",
                          (unsigned long)size);

    saved_state *s = *saved;
    *s = (saved_state){.size = size,
                       .identity = *resource_identity(&c->parameters),
                       .run = c->run,
                       .inputs = c->input_count,
                       .parameters = c->parameter_count,
                       .state = kernel,
                       .before = before,
                       .last_size = has_step ? last->size : 0.0,
                       .ramp = last->ramp,
                       .has_last_inputs = has_last_inputs};
    memcpy(s->magic, STATE_MAGIC, sizeof s->magic);
    const size_t inputs = COSIM_INPUT_ARRAYS * cosim_input_bytes(c);
    char *to = append((char *)(s + 1), c->in.value, inputs);
    if (has_last_inputs)
        memcpy(to, last->with.value, inputs);
    else
        memset(to, 0, inputs);
    to = append(to + inputs, c->stored, parameter_bytes(c));
    to = append(to, c->span.state, kernel);
    if (before) memcpy(to, gallop_state_before(c->span.model, c->span.state), before);
    return GALLOP_COSIM_OK;
}

/* Time of a state of the span's model that came as bytes; NaN: it is none.  Writes over `work`. */
static double checked_time(const cosim_span *span, const char *bytes)
{
    memcpy(span->work, bytes, gallop_saved_size(span->model));
    const bool good = gallop_state_check(span->model, span->work) == GALLOP_COMPLETED;
    return good ? gallop_state_time(span->work) : NAN;
}

/* Copies the kernel's states into a span; false if they cannot be states of its model. */
static bool copy_state(cosim_span *span, const saved_state *s)
{
    if (!s->state) return true;
    if (s->state != gallop_saved_size(span->model)) return false;
    if (s->deserialised) {
        const double time = s->run.time;
        if (checked_time(span, state_in(s)) != time) return false;
        if (s->before && time - checked_time(span, before_in(s)) != s->last_size) return false;
    }
    memcpy(span->state, state_in(s), s->state);
    if (s->before) memcpy(gallop_state_before(span->model, span->state), before_in(s), s->before);
    return true;
}

static gallop_cosim_status restore_with_present_parameters(gallop_cosim *c, const saved_state *s)
{
    if (s->state && !c->span.model) {
        const gallop_cosim_status status = cosim_span_build(c, &c->span);
        if (status != GALLOP_COSIM_OK) return status;
    }
    if (copy_state(&c->span, s)) return GALLOP_COSIM_OK;
    return cosim_refuse(c, "the state is not one of this span; restore one that it saved");
}

/* Builds a span of the saved parameters; it replaces the present one unless something is wrong. */
static gallop_cosim_status restore_with_saved_parameters(gallop_cosim *c, const saved_state *s)
{
    double *present = malloc(parameter_bytes(c) + 1);
    if (!present)
        return cosim_fail(c, "there is not enough memory to restore the state; free saved states");
    cosim_span span = {NULL, NULL, NULL, NULL};
    const int32_t status = c->run.status;
    memcpy(present, c->stored, parameter_bytes(c));
    cosim_set_parameters(c, parameters_in(s));

    gallop_cosim_status result = s->state ? cosim_span_build(c, &span) : GALLOP_COSIM_OK;
    if (result == GALLOP_COSIM_OK && !copy_state(&span, s))
        result = cosim_refuse(c, "the state does not fit the parameters saved with it; restore one "
                                 "that was saved by this program");
    if (result == GALLOP_COSIM_OK) {
        cosim_span_drop(c);
        c->span = span;
    } else {
        cosim_set_parameters(c, present);
        c->run.status = status;
        cosim_span_free(&span);
    }
    free(present);
    return result;
}

gallop_cosim_status gallop_cosim_restore(gallop_cosim *c, const gallop_cosim_saved *saved)
{
    if (!c) return GALLOP_COSIM_REFUSED;
    if (!is_saved(saved) || !is_of_this_resource(c, saved))
        return cosim_refuse(c, "this is not a state of this FMU; restore one that it saved");
    const bool same = memcmp(parameters_in(saved), c->stored, parameter_bytes(c)) == 0;
    const gallop_cosim_status status =
        same ? restore_with_present_parameters(c, saved) : restore_with_saved_parameters(c, saved);
    if (status != GALLOP_COSIM_OK) return status;

    c->run = saved->run;
    memcpy(c->in.value, inputs_in(saved), COSIM_INPUT_ARRAYS * cosim_input_bytes(c));
    c->started = saved->state > 0;
    memcpy(c->last_step.with.value, last_inputs_in(saved),
           COSIM_INPUT_ARRAYS * cosim_input_bytes(c));
    c->last_step.size = saved->last_size;
    c->last_step.ramp = saved->ramp;
    c->last_step.base = saved->before          ? COSIM_DERIV_LAST_STEP
                      : saved->has_last_inputs ? COSIM_DERIV_AT_START
                                               : COSIM_DERIV_UNKNOWN;
    cosim_forget_observations(c);
    return GALLOP_COSIM_OK;
}

void gallop_cosim_free_saved(gallop_cosim_saved *saved)
{
    free(saved);
}

gallop_cosim_status gallop_cosim_serialized_size(gallop_cosim *c, const gallop_cosim_saved *saved,
                                                 size_t *size)
{
    if (!c) return GALLOP_COSIM_REFUSED;
    if (!is_saved(saved) || !size)
        return cosim_refuse(c, "a saved state and a place for its size are needed; give both");
    *size = saved->size;
    return GALLOP_COSIM_OK;
}

static uint64_t checksum_of(const void *bytes, size_t size)
{
    return resource_file_checksum((const char *)bytes + CHECKED_FROM, size - CHECKED_FROM);
}

gallop_cosim_status gallop_cosim_serialize(gallop_cosim *c, const gallop_cosim_saved *saved,
                                           void *bytes, size_t size)
{
    if (!c) return GALLOP_COSIM_REFUSED;
    if (!is_saved(saved) || !bytes)
        return cosim_refuse(c, "a saved state and a place for its bytes are needed; give both");
    if (size < saved->size)
        return cosim_refuse(c,
                            "there is room for %lu bytes, but the state needs %lu; ask for its "
                            "size first",
                            (unsigned long)size, (unsigned long)saved->size);
    saved_state head = *saved;
    memcpy(bytes, saved, saved->size);
    head.deserialised = 0;
    memcpy(bytes, &head, sizeof head);
    head.checksum = checksum_of(bytes, saved->size);
    memcpy(bytes, &head, sizeof head);
    return GALLOP_COSIM_OK;
}

static bool all_finite(const double *values, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (!isfinite(values[i])) return false;
    return true;
}

static bool run_is_possible(const cosim_run *run, bool has_state)
{
    const bool early = run->phase == COSIM_INSTANTIATED || run->phase == COSIM_INITIALIZING;
    if (!early && run->phase != COSIM_STEPPING && run->phase != COSIM_TERMINATED) return false;
    return (early || has_state) && all_finite(&run->time, 1) && all_finite(&run->start, 1) &&
           !isnan(run->stop);
}

static bool last_step_is_possible(const saved_state *s)
{
    if (!(s->ramp >= 0.0) || s->ramp > COSIM_MAX_STEP) return false;
    if (s->has_last_inputs > 1 || (s->has_last_inputs && !s->state)) return false;
    if (!s->before) return s->last_size == 0.0;
    return s->has_last_inputs && s->last_size > 0.0 && s->last_size <= COSIM_MAX_STEP;
}

/* The problem of the bytes of a state; NULL: none is visible before the parameters are read. */
static const char *check_bytes(const gallop_cosim *c, const void *bytes, size_t size)
{
    saved_state head;
    if (!bytes || size < sizeof head)
        return "the bytes are cut off, a state has more; serialize the state again";
    memcpy(&head, bytes, sizeof head);
    if (memcmp(head.magic, STATE_MAGIC, sizeof head.magic - 1) != 0)
        return "the bytes are not a state of this program; use states that it serialized";
    if (memcmp(head.magic, STATE_MAGIC, sizeof head.magic) != 0)
        return "the bytes are a state in the format of another version of gallop-fmu; use states "
               "of this version, or the FMU that saved them";
    if (!is_of_this_resource(c, &head))
        return "the bytes are a state of another FMU; use states of this one";
    const bool sizes_fit =
        head.state <= size && (head.before == 0 || head.before == head.state) &&
        saved_size(head.inputs, head.parameters, head.state + head.before) == size;
    if (head.size != size || !sizes_fit)
        return "the bytes are cut off, or more than the state has; serialize the state again";
    if (head.checksum != checksum_of(bytes, size))
        return "the bytes are damaged, their checksum is wrong; serialize the state again";
    if (!run_is_possible(&head.run, head.state > 0) || !last_step_is_possible(&head))
        return "the bytes are damaged: no such state is possible; serialize the state again";
    return NULL;
}

gallop_cosim_status gallop_cosim_deserialize(gallop_cosim *c, const void *bytes, size_t size,
                                             gallop_cosim_saved **saved)
{
    if (!c) return GALLOP_COSIM_REFUSED;
    if (!saved) return cosim_refuse(c, "there is no place for the state; give one");
    const char *problem = check_bytes(c, bytes, size);
    if (problem) return cosim_refuse(c, "%s", problem);

    saved_state *s = malloc(size);
    if (!s)
        return cosim_fail(c,
                          "there is not enough memory to read the state: %lu bytes; free saved "
                          "states",
                          (unsigned long)size);
    memcpy(s, bytes, size);
    s->deserialised = 1;
    const char *wrong = NULL;
    if (!cosim_parameters_are_possible(c, parameters_in(s)))
        wrong = "a parameter is out of its bounds";
    if (!all_finite(inputs_in(s), 2 * COSIM_INPUT_ARRAYS * s->inputs))
        wrong = "an input is not finite";
    if (wrong) {
        free(s);
        return cosim_refuse(c, "the bytes are damaged: %s; serialize the state again", wrong);
    }
    *saved = s;
    return GALLOP_COSIM_OK;
}
