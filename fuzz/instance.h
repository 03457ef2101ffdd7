/* Shared by the targets that work on an instance: a logger that insists on a text, and a bound on
 * the work. */
#ifndef FUZZING_INSTANCE_H
#define FUZZING_INSTANCE_H

#include "input.h"
#include "read_resource.h"

#include <fmi2Functions.h>
#include <stdarg.h>
#include <stdbool.h>

static inline void insist_on_text(void *environment, fmi2String instance, fmi2Status status,
                                  fmi2String category, fmi2String format, ...)
{
    char text[2048];
    va_list arguments;
    REQUIRE(instance && category && (status == fmi2Error || status == fmi2Discard));
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    REQUIRE(strlen(text) > 10);
    if (environment) ++*(long *)environment;
}

/* Skip a million steps or elements, for which changed parameters may ask. */
static inline bool cheap(fmi2Component c, const resource *table)
{
    for (uint32_t i = 0; i < resource_variable_count(table); i++) {
        const resource_variable *v = &resource_variables(table)[i];
        fmi2Real step;
        fmi2Integer whole;
        if (!strcmp(v->name, "numerics.time_step") && fmi2GetReal(c, &i, 1, &step) == fmi2OK &&
            !(step > 1e-3))
            return false;
        if (strncmp(v->name, "numerics.", 9) != 0 || !v->whole) continue;
        if (fmi2GetInteger(c, &i, 1, &whole) == fmi2OK && whole > 50) return false;
    }
    return true;
}

/* The resource that RESOURCES and GUID of the environment name. */
static inline void read_table(resource *table)
{
    const char *wrong = read_resource(table, getenv("RESOURCES"), getenv("GUID"));
    if (!wrong) return;
    fprintf(stderr, "set RESOURCES and GUID to those of an unpacked FMU: %s\n", wrong);
    abort();
}

#endif
