/* FMI: saving, restoring and serialising the state of an instance. */
#include "fmi2_instance.h"

#define STATE_MAGIC "GALLOPF1"

typedef struct {
    char magic[8];
    uint64_t size, checksum;   /* FNV-1a of all that follows this field */
    kept now;
    uint64_t parameters, state;   /* bytes of each that follow */
} saved;

static size_t state_bytes(const instance *c) { return c->model && c->started ? gallop_saved_size(c->model) : 0; }

static saved *snapshot(instance *c, saved *into)
{
    size_t parameters = c->parameters.size, state = state_bytes(c), size = sizeof(saved) + parameters + state;
    if (!into || into->size != size) {
        free(into);
        into = malloc(size);
        if (!into) return NULL;
    }
    memcpy(into->magic, STATE_MAGIC, 8);
    into->size = size;
    into->checksum = 0;   /* filled in when it leaves the process */
    into->now = c->now;
    into->parameters = parameters;
    into->state = state;
    memcpy(into + 1, c->parameters.bytes, parameters);
    if (state) memcpy((char *)(into + 1) + parameters, c->state, state);
    return into;
}

fmi2Status fmi2GetFMUstate(fmi2Component component, fmi2FMUstate *state)
{
    ALLOW(ANY);
    if (!state) return say(c, fmi2Error, "%s: no place for the state was given", __func__);
    saved *s = snapshot(c, *state);
    if (!s) {
        *state = NULL;
        return say(c, fmi2Error, "%s: there is not enough memory", __func__);
    }
    *state = s;
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component component, fmi2FMUstate state)
{
    ALLOW(ANY);
    const saved *s = state;
    if (!s || memcmp(s->magic, STATE_MAGIC, 8) != 0 || s->parameters != c->parameters.size)
        return say(c, fmi2Error, "%s: this is not a state of this FMU", __func__);
    const char *parameters = (const char *)(s + 1);
    const bool same = memcmp(parameters, c->parameters.bytes, s->parameters) == 0;
    if (!same) {
        memcpy(c->parameters.bytes, parameters, s->parameters);
        drop_model(c);
    }
    if (s->state && !c->model && build_model(c) != fmi2OK) return fmi2Error;
    if (s->state && s->state != gallop_saved_size(c->model)) return say(c, fmi2Error, "%s: the state is of another size", __func__);
    c->now = s->now;
    c->now.last_step = 0.0;   /* the step before is not part of a state */
    c->started = s->state > 0;
    if (s->state) memcpy(c->state, parameters + s->parameters, s->state);
    c->nodes_known = c->forces_known = false;
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
    if (!state || !size) return say(c, fmi2Error, "%s: no state, or no place for its size, was given", __func__);
    *size = ((const saved *)state)->size;
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component component, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    ALLOW(ANY);
    const saved *s = state;
    if (!s || !bytes || size < s->size) return say(c, fmi2Error, "%s: the state needs %lu bytes", __func__, s ? (unsigned long)s->size : 0ul);
    memcpy(bytes, s, s->size);
    const size_t covered = offsetof(saved, now);
    uint64_t checksum = resource_checksum((const char *)bytes + covered, s->size - covered);
    memcpy(bytes + offsetof(saved, checksum), &checksum, sizeof checksum);
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component component, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
{
    ALLOW(ANY);
    saved head;
    const size_t covered = offsetof(saved, now);
    if (!bytes || !state || size < sizeof head) return say(c, fmi2Error, "%s: the bytes are cut off", __func__);
    memcpy(&head, bytes, sizeof head);
    if (memcmp(head.magic, STATE_MAGIC, 8) != 0) return say(c, fmi2Error, "%s: the bytes are not a state of this program, or of another version", __func__);
    if (head.size != size || head.parameters != c->parameters.size || head.state > size || sizeof head + head.parameters + head.state != size)
        return say(c, fmi2Error, "%s: the bytes are cut off, or of another FMU", __func__);
    if (head.checksum != resource_checksum((const char *)bytes + covered, size - covered))
        return say(c, fmi2Error, "%s: the bytes are damaged, their checksum is wrong", __func__);
    if (head.parameters < sizeof(resource_header) ||
        memcmp(bytes + sizeof head + offsetof(resource_header, guid), resource_head(&c->parameters)->guid, sizeof resource_head(&c->parameters)->guid) != 0)
        return say(c, fmi2Error, "%s: the bytes are a state of another FMU", __func__);
    saved *copy = malloc(size);
    if (!copy) return say(c, fmi2Error, "%s: there is not enough memory", __func__);
    memcpy(copy, bytes, size);
    free(*state);
    *state = copy;
    return fmi2OK;
}
