/* The functions of FMI 3.0 for co-simulation: an adapter of its types to gallop_cosim.h.
 *
 * As in FMI 2.0, a call that is refused or fails returns fmi3Error, and its message goes to the
 * host's logger; fmi3Fatal is never returned.  Variables are scalars of type Float64 and, read as
 * Int32 or Int64, whole numbers and enumerations.  Functions for what this FMU does not have are in
 * fmi3_absent.c. */
#include "fmi3_instance.h"
#include "fmi_host.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static fmi3Status log_message(const fmi3_instance *f, fmi3Status status, const char *text)
{
    if (f->log) f->log(f->environment, status, "logStatusError", text);
    return status;
}

fmi3Status fmi3_refuse(const fmi3_instance *f, const char *text)
{
    return f ? log_message(f, fmi3Error, text) : fmi3Error;
}

/* The status for the host; a message goes to its log. */
static fmi3Status returned(const fmi3_instance *f, gallop_cosim_status status)
{
    if (status == GALLOP_COSIM_OK) return fmi3OK;
    if (!f) return fmi3Error;
    return log_message(f, status == GALLOP_COSIM_WARNING ? fmi3Warning : fmi3Error,
                       gallop_cosim_message(f->cosim));
}

static gallop_cosim *cosim_of(const fmi3_instance *f)
{
    return f ? f->cosim : NULL;
}

const char *fmi3GetVersion(void)
{
    return fmi3Version;
}

/* ---------------------------------------------------------------------------------- instances */

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String location,
                                         fmi3Boolean visible, fmi3Boolean logging,
                                         fmi3Boolean event_mode, fmi3Boolean early_return,
                                         const fmi3ValueReference intermediate[],
                                         size_t intermediates, fmi3InstanceEnvironment environment,
                                         fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update)
{
    (void)visible;
    (void)logging; /* errors are always logged; there are no other messages */
    (void)early_return;
    (void)intermediate;
    (void)update;
    fmi3_instance *f = calloc(1, sizeof *f);
    if (!f) return NULL;
    f->log = log;
    f->environment = environment;

    char message[GALLOP_COSIM_MESSAGE_SIZE] = "";
    if (!name || !*name)
        strcpy(message, "an instance needs a name; give one");
    else if (!token)
        strcpy(message, "the instantiation token is missing; give that of modelDescription.xml");
    else if (!location)
        strcpy(message, "the resource path is missing; give the folder of the resources");
    else if (event_mode)
        strcpy(message, "this FMU has no event mode; instantiate it without");
    else if (intermediates)
        strcpy(message, "this FMU has no intermediate update; require no intermediate variables");
    else if ((f->cosim = fmi_host_open(location, token, message)) != NULL)
        return f;
    log_message(f, fmi3Error, message);
    free(f);
    return NULL;
}

void fmi3FreeInstance(fmi3Instance instance)
{
    fmi3_instance *f = instance;
    if (f) gallop_cosim_free(f->cosim);
    free(f);
}

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean logging, size_t count,
                               const fmi3String categories[])
{
    (void)logging;
    const char *unknown = "the log category is unknown; use those of the standard";
    if (!instance) return fmi3Error;
    for (size_t i = 0; i < count; i++)
        if (!categories || !fmi_host_knows_category(categories[i]))
            return fmi3_refuse(instance, unknown);
    return fmi3OK;
}

/* ------------------------------------------------------------------------------- phases, steps */

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean tolerance_defined,
                                       fmi3Float64 tolerance, fmi3Float64 start,
                                       fmi3Boolean stop_defined, fmi3Float64 stop)
{
    (void)tolerance_defined;
    (void)tolerance;
    gallop_cosim *cosim = cosim_of(instance);
    gallop_cosim_status status = gallop_cosim_set_up(cosim, start, stop_defined ? stop : INFINITY);
    if (status == GALLOP_COSIM_OK) status = gallop_cosim_enter_initialization(cosim);
    return returned(instance, status);
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance)
{
    return returned(instance, gallop_cosim_exit_initialization(cosim_of(instance)));
}

fmi3Status fmi3Terminate(fmi3Instance instance)
{
    return returned(instance, gallop_cosim_terminate(cosim_of(instance)));
}

fmi3Status fmi3Reset(fmi3Instance instance)
{
    return returned(instance, gallop_cosim_reset(cosim_of(instance)));
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 time, fmi3Float64 step,
                      fmi3Boolean no_return, fmi3Boolean *event, fmi3Boolean *terminate,
                      fmi3Boolean *early, fmi3Float64 *reached)
{
    (void)no_return;
    const fmi3Status status = returned(instance, gallop_cosim_step(cosim_of(instance), time, step));
    if (event) *event = false;
    if (terminate) *terminate = false;
    if (early) *early = false;
    if (reached) gallop_cosim_time(cosim_of(instance), reached);
    return status;
}

/* -------------------------------------------------------------------------------------- values */

/* Refuses values of which there is not one for each variable. */
static bool is_scalar(const fmi3_instance *f, size_t references, size_t values)
{
    if (references == values) return true;
    fmi3_refuse(f, "all variables of this FMU are scalars; give one value for each reference");
    return false;
}

fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference reference[], size_t count,
                          fmi3Float64 value[], size_t values)
{
    if (!is_scalar(instance, count, values)) return fmi3Error;
    return returned(instance, gallop_cosim_get_real(cosim_of(instance), reference, count, value));
}

fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference reference[], size_t count,
                          const fmi3Float64 value[], size_t values)
{
    if (!is_scalar(instance, count, values)) return fmi3Error;
    return returned(instance, gallop_cosim_set_real(cosim_of(instance), reference, count, value));
}

fmi3Status fmi3GetInt32(fmi3Instance instance, const fmi3ValueReference reference[], size_t count,
                        fmi3Int32 value[], size_t values)
{
    if (!is_scalar(instance, count, values)) return fmi3Error;
    return returned(instance,
                    gallop_cosim_get_integer(cosim_of(instance), reference, count, value));
}

fmi3Status fmi3SetInt32(fmi3Instance instance, const fmi3ValueReference reference[], size_t count,
                        const fmi3Int32 value[], size_t values)
{
    if (!is_scalar(instance, count, values)) return fmi3Error;
    return returned(instance,
                    gallop_cosim_set_integer(cosim_of(instance), reference, count, value));
}

/* FMI 3.0 has enumerations of 64 bits. */
fmi3Status fmi3GetInt64(fmi3Instance instance, const fmi3ValueReference reference[], size_t count,
                        fmi3Int64 value[], size_t values)
{
    if (!is_scalar(instance, count, values)) return fmi3Error;
    if (count && (!reference || !value))
        return fmi3_refuse(instance, "an array is a null pointer; give arrays for all values");
    gallop_cosim_status status = gallop_cosim_get_integer(cosim_of(instance), NULL, 0, NULL);
    for (size_t i = 0; status == GALLOP_COSIM_OK && i < count; i++) {
        int32_t number;
        status = gallop_cosim_get_integer(cosim_of(instance), &reference[i], 1, &number);
        if (status == GALLOP_COSIM_OK) value[i] = number;
    }
    return returned(instance, status);
}

fmi3Status fmi3SetInt64(fmi3Instance instance, const fmi3ValueReference reference[], size_t count,
                        const fmi3Int64 value[], size_t values)
{
    if (!is_scalar(instance, count, values)) return fmi3Error;
    if (count && (!reference || !value))
        return fmi3_refuse(instance, "an array is a null pointer; give arrays for all values");
    for (size_t i = 0; i < count; i++)
        if (value[i] > INT32_MAX || value[i] < INT32_MIN)
            return fmi3_refuse(instance,
                               "a whole number needs more than 32 bits; give smaller ones");
    int32_t *number = malloc(count * sizeof *number + 1);
    if (!number) return fmi3_refuse(instance, "there is not enough memory");
    for (size_t i = 0; i < count; i++) number[i] = (int32_t)value[i];
    const gallop_cosim_status status =
        gallop_cosim_set_integer(cosim_of(instance), reference, count, number);
    free(number);
    return returned(instance, status);
}

/* --------------------------------------------------------------------------------- derivatives */

fmi3Status fmi3GetOutputDerivatives(fmi3Instance instance, const fmi3ValueReference reference[],
                                    size_t count, const fmi3Int32 order[], fmi3Float64 value[],
                                    size_t values)
{
    if (!is_scalar(instance, count, values)) return fmi3Error;
    if (count && !order)
        return fmi3_refuse(instance, "the array of orders is a null pointer; give orders of 1");
    for (size_t i = 0; i < count; i++)
        if (order[i] != 1)
            return fmi3_refuse(instance, "only first derivatives are supported; give orders of 1");
    return returned(instance,
                    gallop_cosim_get_output_rates(cosim_of(instance), reference, count, value));
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknown[],
                                        size_t unknowns, const fmi3ValueReference known[],
                                        size_t knowns, const fmi3Float64 seed[], size_t seeds,
                                        fmi3Float64 derivative[], size_t derivatives)
{
    if (!is_scalar(instance, knowns, seeds) || !is_scalar(instance, unknowns, derivatives))
        return fmi3Error;
    return returned(instance,
                    gallop_cosim_directional_derivative(cosim_of(instance), unknown, unknowns,
                                                        known, knowns, seed, derivative));
}

/* -------------------------------------------------------------------------------- saved states */

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *state)
{
    gallop_cosim_saved *saved = state ? *state : NULL;
    const fmi3Status status =
        returned(instance, gallop_cosim_save(cosim_of(instance), state ? &saved : NULL));
    if (state && status == fmi3OK) *state = saved;
    return status;
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState state)
{
    return returned(instance, gallop_cosim_restore(cosim_of(instance), state));
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *state)
{
    if (!instance) return fmi3Error;
    if (!state) return fmi3OK;
    gallop_cosim_free_saved(*state);
    *state = NULL;
    return fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState state, size_t *size)
{
    return returned(instance, gallop_cosim_serialized_size(cosim_of(instance), state, size));
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState state, fmi3Byte bytes[],
                                 size_t size)
{
    return returned(instance, gallop_cosim_serialize(cosim_of(instance), state, bytes, size));
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte bytes[], size_t size,
                                   fmi3FMUState *state)
{
    gallop_cosim_saved *saved = NULL;
    const fmi3Status status = returned(
        instance, gallop_cosim_deserialize(cosim_of(instance), bytes, size, state ? &saved : NULL));
    if (state && status == fmi3OK) *state = saved;
    return status;
}
