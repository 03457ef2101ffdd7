/* FMI: saving, restoring and serialising the state of an instance. */
#include "fmi2_instance.h"

#define STATE_MAGIC "GALLOPF2"

/* Followed by the parameters, as stored in the scene, and by the kernel's state. */
typedef struct {
    char magic[8];
    uint64_t size, checksum; /* of everything; FNV-1a of all that follows this field, in bytes */
    char guid[48];
    kept now;
    uint64_t parameters, state; /* how many numbers, how many bytes */
    uint64_t foreign;           /* 1: came as bytes, and its content is not believed */
} saved;

/* What a host gives back to the functions below; no more can be told of a pointer. */
static bool is_saved(const saved *s)
{
    return s && (uintptr_t)s % sizeof(uint64_t) == 0 &&
           memcmp(s->magic, STATE_MAGIC, sizeof s->magic) == 0;
}

static const double *parameters_in(const saved *s)
{
    return (const double *)(s + 1);
}

static const char *state_in(const saved *s)
{
    return (const char *)(parameters_in(s) + s->parameters);
}

static size_t saved_size(uint64_t parameters, uint64_t state)
{
    return sizeof(saved) + (size_t)parameters * sizeof(double) + (size_t)state;
}

static size_t parameter_bytes(const instance *c)
{
    return c->parameter_count * sizeof(double);
}

static bool possible_parameters(const instance *c, const double *from)
{
    const resource_variable *v = resource_table(&c->parameters);
    for (uint32_t i = 0; i < resource_head(&c->parameters)->variable_count; i++) {
        if (v[i].origin != ORIGIN_PARAMETER) continue;
        const double stored = *from++;
        if (!isfinite(stored) || !resource_allows(&v[i], stored, v[i].factor) ||
            (v[i].whole && !(fabs(stored) <= INT32_MAX)))
            return false;
    }
    return true;
}

static void take_parameters(instance *c, const double *from)
{
    const resource_variable *v = resource_table(&c->parameters);
    for (uint32_t i = 0; i < resource_head(&c->parameters)->variable_count; i++)
        if (v[i].origin == ORIGIN_PARAMETER) store_parameter(c, &v[i], *from++);
    list_parameters(c);
}

static bool all_finite(const double *values, int count)
{
    for (int i = 0; i < count; i++)
        if (!isfinite(values[i])) return false;
    return true;
}

static bool possible(const kept *k, bool has_state)
{
    const bool before = k->mode == INSTANTIATED || k->mode == INITIALIZING;
    if (!before && k->mode != STEPPING && k->mode != TERMINATED) return false;
    return (before || has_state) && all_finite(&k->time, 1) && all_finite(&k->start, 1) &&
           !isnan(k->stop) && all_finite(k->input, INPUTS) && all_finite(k->rate, INPUTS) &&
           all_finite(k->reached, 6);
}

fmi2Status fmi2GetFMUstate(fmi2Component component, fmi2FMUstate *state)
{
    ALLOW(ANY);
    if (!state) return say(c, fmi2Error, "%s: no place for the state was given", __func__);
    const size_t kernel = c->started ? gallop_saved_size(c->span.model) : 0;
    const size_t size = saved_size(c->parameter_count, kernel);
    saved *s = *state;
    if (!s || s->size != size) {
        s = malloc(size);
        if (!s)
            return say(c, fmi2Error, "%s: there is not enough memory: %lu bytes", __func__,
                       (unsigned long)size);
        free(*state);
        *state = s;
    }
    memcpy(s->magic, STATE_MAGIC, sizeof s->magic);
    memcpy(s->guid, resource_head(&c->parameters)->guid, sizeof s->guid);
    s->size = size;
    s->checksum = s->foreign = 0;
    s->now = c->now;
    s->parameters = c->parameter_count;
    s->state = kernel;
    memcpy(s + 1, c->stored, parameter_bytes(c));
    if (kernel) memcpy((char *)(s + 1) + parameter_bytes(c), c->span.state, kernel);
    return fmi2OK;
}

/* Puts the kernel's state into place, if it is one of this model. */
static bool take_state(span *into, const saved *s)
{
    if (!s->state) return true;
    if (s->state != gallop_saved_size(into->model)) return false;
    if (s->foreign) {
        memcpy(into->work, state_in(s), s->state);
        if (gallop_state_check(into->model, into->work) != GALLOP_COMPLETED) return false;
        if (gallop_state_time(into->work) != s->now.time) return false;
    }
    memcpy(into->state, state_in(s), s->state);
    return true;
}

/* A span of other parameters takes the place of the present one, unless something is wrong. */
static fmi2Status restore_with_parameters(instance *c, const saved *s)
{
    double *present = malloc(parameter_bytes(c) + 1);
    if (!present) return say(c, fmi2Error, "fmi2SetFMUstate: there is not enough memory");
    span other = {NULL, NULL, NULL};
    const int32_t status = c->now.status;
    memcpy(present, c->stored, parameter_bytes(c));
    take_parameters(c, parameters_in(s));
    fmi2Status result = s->state ? build_span(c, &other) : fmi2OK;
    if (result == fmi2OK && !take_state(&other, s))
        result = say(c, fmi2Error,
                     "fmi2SetFMUstate: the state does not fit the parameters saved with it");
    if (result == fmi2OK) {
        drop_span(c);
        c->span = other;
    } else {
        take_parameters(c, present);
        c->now.status = status;
        span_free(&other);
    }
    free(present);
    return result;
}

static fmi2Status restore(instance *c, const saved *s)
{
    if (s->state && !c->span.model && build_span(c, &c->span) != fmi2OK) return fmi2Error;
    if (take_state(&c->span, s)) return fmi2OK;
    return say(c, fmi2Error, "fmi2SetFMUstate: the state is not one of this span");
}

static bool of_this_fmu(const instance *c, const saved *s)
{
    return memcmp(s->guid, resource_head(&c->parameters)->guid, sizeof s->guid) == 0 &&
           s->parameters == c->parameter_count;
}

fmi2Status fmi2SetFMUstate(fmi2Component component, fmi2FMUstate state)
{
    ALLOW(ANY);
    const saved *s = state;
    if (!is_saved(s) || !of_this_fmu(c, s))
        return say(c, fmi2Error, "%s: this is not a state of this FMU", __func__);
    const bool same = memcmp(parameters_in(s), c->stored, parameter_bytes(c)) == 0;
    const fmi2Status result = same ? restore(c, s) : restore_with_parameters(c, s);
    if (result != fmi2OK) return result;
    c->now = s->now;
    c->started = s->state > 0;
    c->before.kind = NOTHING; /* the step before is not part of a state */
    forget_observations(c);
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component component, fmi2FMUstate *state)
{
    ALLOW(ANY);
    if (!state) return fmi2OK;
    free(*state);
    *state = NULL;
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component component, fmi2FMUstate state, size_t *size)
{
    ALLOW(ANY);
    if (!is_saved(state) || !size)
        return say(c, fmi2Error, "%s: no state, or no place for its size, was given", __func__);
    *size = ((const saved *)state)->size;
    return fmi2OK;
}

static uint64_t checksum_of(const fmi2Byte bytes[], size_t size)
{
    return resource_checksum((const char *)bytes + offsetof(saved, guid),
                             size - offsetof(saved, guid));
}

fmi2Status fmi2SerializeFMUstate(fmi2Component component, fmi2FMUstate state, fmi2Byte bytes[],
                                 size_t size)
{
    ALLOW(ANY);
    const saved *s = state;
    if (!is_saved(s) || !bytes)
        return say(c, fmi2Error, "%s: no state, or no place for it, was given", __func__);
    if (size < s->size)
        return say(c, fmi2Error, "%s: the state needs %lu bytes, not %lu", __func__,
                   (unsigned long)s->size, (unsigned long)size);
    saved head = *s;
    memcpy(bytes, s, s->size);
    head.foreign = 0;
    memcpy(bytes, &head, sizeof head);
    head.checksum = checksum_of(bytes, s->size);
    memcpy(bytes, &head, sizeof head);
    return fmi2OK;
}

/* What is wrong with the bytes of a state; NULL: nothing. */
static const char *check_bytes(const instance *c, const fmi2Byte bytes[], size_t size)
{
    saved head;
    if (!bytes || size < sizeof head) return "the bytes are cut off";
    memcpy(&head, bytes, sizeof head);
    if (memcmp(head.magic, STATE_MAGIC, sizeof head.magic) != 0)
        return "the bytes are not a state of this program, or of another version";
    if (!of_this_fmu(c, &head)) return "the bytes are a state of another FMU";
    if (head.size != size || head.state > size || saved_size(head.parameters, head.state) != size)
        return "the bytes are cut off, or have grown";
    if (head.checksum != checksum_of(bytes, size))
        return "the bytes are damaged, their checksum is wrong";
    return possible(&head.now, head.state > 0) ? NULL
                                               : "the bytes are damaged: no such state is possible";
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component component, const fmi2Byte bytes[], size_t size,
                                   fmi2FMUstate *state)
{
    ALLOW(ANY);
    if (!state) return say(c, fmi2Error, "%s: no place for the state was given", __func__);
    const char *wrong = check_bytes(c, bytes, size);
    if (wrong) return say(c, fmi2Error, "%s: %s", __func__, wrong);
    saved *copy = malloc(size);
    if (!copy)
        return say(c, fmi2Error, "%s: there is not enough memory: %lu bytes", __func__,
                   (unsigned long)size);
    memcpy(copy, bytes, size);
    copy->foreign = 1;
    if (!possible_parameters(c, parameters_in(copy))) {
        free(copy);
        return say(c, fmi2Error, "%s: the bytes are damaged: a parameter is out of its bounds",
                   __func__);
    }
    *state = copy;
    return fmi2OK;
}
