/* Check of a call against the standard, and choices made from the bytes. */
#include "sequence.h"

const fmi2CallbackFunctions with = {insist_on_text, calloc, free, NULL, &messages};
const fmi2CallbackFunctions silent = {NULL, calloc, free, NULL, NULL};

/* The bytes of an instance's state; NULL: there is no instance. */
char *image(fmi2Component c, size_t *size)
{
    fmi2FMUstate state = NULL;
    if (!c) return NULL;
    REQUIRE(fmi2GetFMUstate(c, &state) == fmi2OK &&
            fmi2SerializedFMUstateSize(c, state, size) == fmi2OK);
    char *bytes = malloc(*size);
    REQUIRE(fmi2SerializeFMUstate(c, state, bytes, *size) == fmi2OK);
    REQUIRE(fmi2FreeFMUstate(c, &state) == fmi2OK && state == NULL);
    return bytes;
}

void judge(const slot *s, verdict expected, fmi2Status status, long said, const char *call)
{
    REQUIRE(status == fmi2OK || status == fmi2Error || status == fmi2Discard);
    if (s->c && status != fmi2OK) REQUIRE(messages > said);
    if (s->is.forged && s->c) return;
    if (expected == EITHER || (status == fmi2OK) == (expected == ACCEPTED)) return;
    fprintf(stderr, "%s gave %d in mode %d\n", call, status, s->is.mode);
    abort();
}

verdict when(const slot *s, int modes)
{
    return s->is.mode & modes ? ACCEPTED : REFUSED;
}

double number(void)
{
    static const double odd[] = {NAN, INFINITY, -INFINITY, 0.0, -1.0, 1e300, -1e-300, 1e9};
    uint8_t b = byte();
    return b < 16 ? odd[b % 8] : (b - 128) / 64.0;
}

const resource_variable *variable(fmi2ValueReference r)
{
    return r < resource_variable_count(&table) ? &resource_variables(&table)[r] : NULL;
}

fmi2ValueReference reference(void)
{
    uint8_t b = byte();
    uint32_t count = resource_variable_count(&table);
    if (b == 255) return 4000000000u;
    return b < 100 ? b % 8u : b % (count + 2u);
}
