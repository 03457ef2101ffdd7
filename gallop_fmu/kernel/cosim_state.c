/* Saving, restoring and serialising the state of an instance. */
#include "cosim_message.h"
#include "cosim_span.h"
#include "cosim_values.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define STATE_MAGIC "GALLOPF4"

/* Followed by values, rates and reached places of the inputs, by the parameters, as stored in the
 * scene, and by the kernel's state.  Without gaps: it is written as bytes. */
struct gallop_cosim_saved {
    char magic[8];
    uint64_t size, checksum; /* of everything; of all bytes that follow this field */
    resource_identification identity;
    cosim_run run;
    uint64_t inputs, parameters, state; /* how many, how many numbers, how many bytes */
    uint64_t deserialised;              /* 1: validate before use */
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

static const double *parameters_in(const saved_state *s)
{
    return inputs_in(s) + 3 * s->inputs;
}

static const char *state_in(const saved_state *s)
{
    return (const char *)(parameters_in(s) + s->parameters);
}

static size_t saved_size(uint64_t inputs, uint64_t parameters, uint64_t state)
{
    return sizeof(saved_state) + (size_t)(3 * inputs + parameters) * sizeof(double) + (size_t)state;
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

gallop_cosim_status gallop_cosim_save(gallop_cosim *c, gallop_cosim_saved **saved)
{
    if (!c) return GALLOP_COSIM_REFUSED;
    if (!saved) return cosim_refuse(c, "there is no place for the state; give one");

    /* Reuse the caller's block if its size fits. */
    const size_t kernel = c->started ? gallop_saved_size(c->span.model) : 0;
    const size_t size = saved_size(c->input_count, c->parameter_count, kernel);
    saved_state *s = *saved;
    if (!s || s->size != size) {
        s = malloc(size);
        if (!s)
            return cosim_fail(c,
                              "there is not enough memory to save the state: %lu bytes; free "
                              "saved states",
                              (unsigned long)size);
        free(*saved);
        *saved = s;
    }

    memcpy(s->magic, STATE_MAGIC, sizeof s->magic);
    s->identity = *resource_identity(&c->parameters);
    s->size = size;
    s->checksum = s->deserialised = 0;
    s->run = c->run;
    s->inputs = c->input_count;
    s->parameters = c->parameter_count;
    s->state = kernel;
    char *to = (char *)(s + 1);
    memcpy(to, c->in.value, 3 * cosim_input_bytes(c));
    memcpy(to + 3 * cosim_input_bytes(c), c->stored, parameter_bytes(c));
    if (kernel) memcpy(to + 3 * cosim_input_bytes(c) + parameter_bytes(c), c->span.state, kernel);
    return GALLOP_COSIM_OK;
}

/* Copies the kernel's state into a span; false if it cannot be a state of its model. */
static bool copy_state(cosim_span *span, const saved_state *s)
{
    if (!s->state) return true;
    if (s->state != gallop_saved_size(span->model)) return false;
    if (s->deserialised) {
        memcpy(span->work, state_in(s), s->state);
        if (gallop_state_check(span->model, span->work) != GALLOP_COMPLETED) return false;
        if (gallop_state_time(span->work) != s->run.time) return false;
    }
    memcpy(span->state, state_in(s), s->state);
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
    cosim_span span = {NULL, NULL, NULL};
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
    memcpy(c->in.value, inputs_in(saved), 3 * cosim_input_bytes(c));
    c->started = saved->state > 0;
    c->last_step.base = COSIM_DERIV_UNKNOWN; /* the last step is not part of a state */
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

/* The problem of the bytes of a state; NULL: none is visible before the parameters are read. */
static const char *check_bytes(const gallop_cosim *c, const void *bytes, size_t size)
{
    saved_state head;
    if (!bytes || size < sizeof head)
        return "the bytes are cut off, a state has more; serialize the state again";
    memcpy(&head, bytes, sizeof head);
    if (memcmp(head.magic, STATE_MAGIC, sizeof head.magic) != 0)
        return "the bytes are not a state of this program, or of another version; use states of "
               "this version";
    if (!is_of_this_resource(c, &head))
        return "the bytes are a state of another FMU; use states of this one";
    if (head.size != size || head.state > size ||
        saved_size(head.inputs, head.parameters, head.state) != size)
        return "the bytes are cut off, or more than the state has; serialize the state again";
    if (head.checksum != checksum_of(bytes, size))
        return "the bytes are damaged, their checksum is wrong; serialize the state again";
    if (!run_is_possible(&head.run, head.state > 0))
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
    if (!all_finite(inputs_in(s), 3 * s->inputs)) wrong = "an input is not finite";
    if (wrong) {
        free(s);
        return cosim_refuse(c, "the bytes are damaged: %s; serialize the state again", wrong);
    }
    *saved = s;
    return GALLOP_COSIM_OK;
}
