/* The functions of FMI 2.0 for co-simulation: an adapter of its types to gallop_cosim.h.
 *
 * A call that is refused or fails returns fmi2Error, and its message goes to the host's logger.
 * fmi2Fatal is never returned.  Variables of type Boolean or String do not exist, and steps are
 * never pending: what asks for them is answered here. */
#include "fmi_host.h"
#include "gallop_cosim.h"

#include <fmi2Functions.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    gallop_cosim *cosim;
    fmi2CallbackFunctions call;
    char *name;
} fmi2_instance;

/* The logger takes a format of printf, but some hosts show it as it is: so the whole text is the
 * format, % doubled. */
static fmi2Status log_message(const fmi2_instance *f, fmi2Status status, const char *text)
{
    char escaped[2 * GALLOP_COSIM_MESSAGE_SIZE], *to = escaped;
    for (size_t i = 0; text[i] && i < GALLOP_COSIM_MESSAGE_SIZE - 1; i++) {
        if (text[i] == '%') *to++ = '%';
        *to++ = text[i];
    }
    *to = '\0';
    if (f->call.logger) {
        const char *category = status == fmi2Discard ? "logStatusDiscard" : "logStatusError";
        f->call.logger(f->call.componentEnvironment, f->name, status, category, escaped);
    }
    return status;
}

static fmi2Status refuse(const fmi2_instance *f, const char *text)
{
    return f ? log_message(f, fmi2Error, text) : fmi2Error;
}

/* The status for the host; a message goes to its log. */
static fmi2Status returned(const fmi2_instance *f, gallop_cosim_status status)
{
    if (status == GALLOP_COSIM_OK) return fmi2OK;
    if (!f) return fmi2Error;
    return log_message(f, status == GALLOP_COSIM_WARNING ? fmi2Warning : fmi2Error,
                       gallop_cosim_message(f->cosim));
}

static gallop_cosim *cosim_of(const fmi2_instance *f)
{
    return f ? f->cosim : NULL;
}

const char *fmi2GetTypesPlatform(void)
{
    return fmi2TypesPlatform;
}

const char *fmi2GetVersion(void)
{
    return fmi2Version;
}

/* ---------------------------------------------------------------------------------- instances */

static void release(fmi2_instance *f)
{
    gallop_cosim_free(f->cosim);
    free(f->name);
    free(f);
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String location,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                              fmi2Boolean logging)
{
    (void)visible;
    (void)logging; /* errors are always logged; there are no other messages */
    fmi2_instance *f = calloc(1, sizeof *f);
    if (!f) return NULL;
    if (functions) f->call = *functions;
    f->name = calloc(1, name ? strlen(name) + 1 : 1);
    if (!f->name) {
        release(f);
        return NULL;
    }
    if (name) strcpy(f->name, name);

    char message[GALLOP_COSIM_MESSAGE_SIZE] = "";
    if (!name || !*name)
        strcpy(message, "an instance needs a name; give one");
    else if (type != fmi2CoSimulation)
        strcpy(message, "this FMU is for co-simulation only; instantiate it as fmi2CoSimulation");
    else if (!guid)
        strcpy(message, "the GUID is missing; give that of modelDescription.xml");
    else if (!location)
        strcpy(message, "the resource location is missing; give the URI of the folder");
    else if ((f->cosim = fmi_host_open(location, guid, message)) != NULL)
        return f;
    log_message(f, fmi2Error, message);
    release(f);
    return NULL;
}

void fmi2FreeInstance(fmi2Component component)
{
    if (component) release(component);
}

fmi2Status fmi2SetDebugLogging(fmi2Component component, fmi2Boolean logging, size_t count,
                               const fmi2String categories[])
{
    (void)logging;
    const char *unknown = "the log category is unknown; use those of the standard";
    if (!component) return fmi2Error;
    for (size_t i = 0; i < count; i++)
        if (!categories || !fmi_host_knows_category(categories[i]))
            return refuse(component, unknown);
    return fmi2OK;
}

/* ------------------------------------------------------------------------------- phases, steps */

fmi2Status fmi2SetupExperiment(fmi2Component component, fmi2Boolean tolerance_defined,
                               fmi2Real tolerance, fmi2Real start, fmi2Boolean stop_defined,
                               fmi2Real stop)
{
    (void)tolerance_defined;
    (void)tolerance;
    return returned(
        component, gallop_cosim_set_up(cosim_of(component), start, stop_defined ? stop : INFINITY));
}

fmi2Status fmi2EnterInitializationMode(fmi2Component component)
{
    return returned(component, gallop_cosim_enter_initialization(cosim_of(component)));
}

fmi2Status fmi2ExitInitializationMode(fmi2Component component)
{
    return returned(component, gallop_cosim_exit_initialization(cosim_of(component)));
}

fmi2Status fmi2Terminate(fmi2Component component)
{
    return returned(component, gallop_cosim_terminate(cosim_of(component)));
}

fmi2Status fmi2Reset(fmi2Component component)
{
    return returned(component, gallop_cosim_reset(cosim_of(component)));
}

fmi2Status fmi2DoStep(fmi2Component component, fmi2Real time, fmi2Real step, fmi2Boolean no_return)
{
    (void)no_return;
    return returned(component, gallop_cosim_step(cosim_of(component), time, step));
}

fmi2Status fmi2CancelStep(fmi2Component component)
{
    return refuse(component,
                  "no step is pending, as each step ends before its call returns; do not cancel");
}

/* Refuses a question in the phases in which it is not allowed; else, the answer is that there is
 * none. */
static fmi2Status discard(const fmi2_instance *f, const char *text)
{
    double time;
    const fmi2Status status = returned(f, gallop_cosim_time(cosim_of(f), &time));
    return status == fmi2OK ? log_message(f, fmi2Discard, text) : status;
}

fmi2Status fmi2GetStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Status *value)
{
    (void)kind;
    (void)value;
    return discard(component, "a step ends before its call returns, so none is pending");
}

fmi2Status fmi2GetRealStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Real *value)
{
    if (kind != fmi2LastSuccessfulTime || !value)
        return discard(component, "the only Real status is fmi2LastSuccessfulTime; ask for that");
    return returned(component, gallop_cosim_time(cosim_of(component), value));
}

fmi2Status fmi2GetIntegerStatus(fmi2Component component, const fmi2StatusKind kind,
                                fmi2Integer *value)
{
    (void)kind;
    (void)value;
    return discard(component, "there is no Integer status");
}

fmi2Status fmi2GetBooleanStatus(fmi2Component component, const fmi2StatusKind kind,
                                fmi2Boolean *value)
{
    double time;
    if (kind != fmi2Terminated || !value)
        return discard(component, "the only Boolean status is fmi2Terminated; ask for that");
    const fmi2Status status = returned(component, gallop_cosim_time(cosim_of(component), &time));
    if (status == fmi2OK) *value = fmi2False;
    return status;
}

fmi2Status fmi2GetStringStatus(fmi2Component component, const fmi2StatusKind kind,
                               fmi2String *value)
{
    (void)kind;
    (void)value;
    return discard(component, "there is no String status");
}

/* -------------------------------------------------------------------------------------- values */

fmi2Status fmi2GetReal(fmi2Component component, const fmi2ValueReference reference[], size_t count,
                       fmi2Real value[])
{
    return returned(component, gallop_cosim_get_real(cosim_of(component), reference, count, value));
}

fmi2Status fmi2GetInteger(fmi2Component component, const fmi2ValueReference reference[],
                          size_t count, fmi2Integer value[])
{
    return returned(component,
                    gallop_cosim_get_integer(cosim_of(component), reference, count, value));
}

fmi2Status fmi2SetReal(fmi2Component component, const fmi2ValueReference reference[], size_t count,
                       const fmi2Real value[])
{
    return returned(component, gallop_cosim_set_real(cosim_of(component), reference, count, value));
}

fmi2Status fmi2SetInteger(fmi2Component component, const fmi2ValueReference reference[],
                          size_t count, const fmi2Integer value[])
{
    return returned(component,
                    gallop_cosim_set_integer(cosim_of(component), reference, count, value));
}

static fmi2Status refuse_type(const fmi2_instance *f, size_t count)
{
    const char *text = "this FMU has no Boolean and no String variables; use Reals and Integers";
    return f && count == 0 ? fmi2OK : refuse(f, text);
}

fmi2Status fmi2GetBoolean(fmi2Component component, const fmi2ValueReference reference[],
                          size_t count, fmi2Boolean value[])
{
    (void)reference;
    (void)value;
    return refuse_type(component, count);
}

fmi2Status fmi2GetString(fmi2Component component, const fmi2ValueReference reference[],
                         size_t count, fmi2String value[])
{
    (void)reference;
    (void)value;
    return refuse_type(component, count);
}

/* Setting nothing is allowed where setting Reals is. */
static fmi2Status refuse_to_set_type(const fmi2_instance *f, size_t count)
{
    const fmi2Status status = returned(f, gallop_cosim_set_real(cosim_of(f), NULL, 0, NULL));
    return status == fmi2OK ? refuse_type(f, count) : status;
}

fmi2Status fmi2SetBoolean(fmi2Component component, const fmi2ValueReference reference[],
                          size_t count, const fmi2Boolean value[])
{
    (void)reference;
    (void)value;
    return refuse_to_set_type(component, count);
}

fmi2Status fmi2SetString(fmi2Component component, const fmi2ValueReference reference[],
                         size_t count, const fmi2String value[])
{
    (void)reference;
    (void)value;
    return refuse_to_set_type(component, count);
}

/* --------------------------------------------------------------------------------- derivatives */

/* NULL, or why derivatives of these orders cannot be used. */
static const char *check_orders(const fmi2Integer order[], size_t count)
{
    if (count && !order) return "the array of orders is a null pointer; give orders of 1";
    for (size_t i = 0; i < count; i++)
        if (order[i] != 1) return "only first derivatives are supported; give orders of 1";
    return NULL;
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component component,
                                       const fmi2ValueReference reference[], size_t count,
                                       const fmi2Integer order[], const fmi2Real value[])
{
    const char *problem = check_orders(order, count);
    if (problem) return refuse(component, problem);
    return returned(component,
                    gallop_cosim_set_input_rates(cosim_of(component), reference, count, value));
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component component,
                                        const fmi2ValueReference reference[], size_t count,
                                        const fmi2Integer order[], fmi2Real value[])
{
    const char *problem = check_orders(order, count);
    if (problem) return refuse(component, problem);
    return returned(component,
                    gallop_cosim_get_output_rates(cosim_of(component), reference, count, value));
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component component, const fmi2ValueReference unknown[],
                                        size_t unknowns, const fmi2ValueReference known[],
                                        size_t knowns, const fmi2Real seed[], fmi2Real derivative[])
{
    return returned(component,
                    gallop_cosim_directional_derivative(cosim_of(component), unknown, unknowns,
                                                        known, knowns, seed, derivative));
}

/* -------------------------------------------------------------------------------- saved states */

fmi2Status fmi2GetFMUstate(fmi2Component component, fmi2FMUstate *state)
{
    gallop_cosim_saved *saved = state ? *state : NULL;
    const fmi2Status status =
        returned(component, gallop_cosim_save(cosim_of(component), state ? &saved : NULL));
    if (state && status == fmi2OK) *state = saved;
    return status;
}

fmi2Status fmi2SetFMUstate(fmi2Component component, fmi2FMUstate state)
{
    return returned(component, gallop_cosim_restore(cosim_of(component), state));
}

fmi2Status fmi2FreeFMUstate(fmi2Component component, fmi2FMUstate *state)
{
    if (!component) return fmi2Error;
    if (!state) return fmi2OK;
    gallop_cosim_free_saved(*state);
    *state = NULL;
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component component, fmi2FMUstate state, size_t *size)
{
    return returned(component, gallop_cosim_serialized_size(cosim_of(component), state, size));
}

fmi2Status fmi2SerializeFMUstate(fmi2Component component, fmi2FMUstate state, fmi2Byte bytes[],
                                 size_t size)
{
    return returned(component, gallop_cosim_serialize(cosim_of(component), state, bytes, size));
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component component, const fmi2Byte bytes[], size_t size,
                                   fmi2FMUstate *state)
{
    gallop_cosim_saved *saved = NULL;
    const fmi2Status status =
        returned(component,
                 gallop_cosim_deserialize(cosim_of(component), bytes, size, state ? &saved : NULL));
    if (state && status == fmi2OK) *state = saved;
    return status;
}

/* ----------------------------------------------------------------------------- model exchange */

/* This FMU has no model exchange; some hosts bind its functions of any FMU. */
static fmi2Status refuse_model_exchange(const fmi2_instance *f)
{
    return refuse(f, "this FMU is for co-simulation only; do not call functions of model exchange");
}

fmi2Status fmi2EnterEventMode(fmi2Component component)
{
    return refuse_model_exchange(component);
}

fmi2Status fmi2NewDiscreteStates(fmi2Component component, fmi2EventInfo *info)
{
    (void)info;
    return refuse_model_exchange(component);
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component component)
{
    return refuse_model_exchange(component);
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component component, fmi2Boolean unchanged,
                                       fmi2Boolean *enter_event_mode, fmi2Boolean *terminate)
{
    (void)unchanged;
    (void)enter_event_mode;
    (void)terminate;
    return refuse_model_exchange(component);
}

fmi2Status fmi2SetTime(fmi2Component component, fmi2Real time)
{
    (void)time;
    return refuse_model_exchange(component);
}

fmi2Status fmi2SetContinuousStates(fmi2Component component, const fmi2Real x[], size_t count)
{
    (void)x;
    (void)count;
    return refuse_model_exchange(component);
}

fmi2Status fmi2GetDerivatives(fmi2Component component, fmi2Real derivative[], size_t count)
{
    (void)derivative;
    (void)count;
    return refuse_model_exchange(component);
}

fmi2Status fmi2GetEventIndicators(fmi2Component component, fmi2Real indicator[], size_t count)
{
    (void)indicator;
    (void)count;
    return refuse_model_exchange(component);
}

fmi2Status fmi2GetContinuousStates(fmi2Component component, fmi2Real x[], size_t count)
{
    (void)x;
    (void)count;
    return refuse_model_exchange(component);
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component component, fmi2Real nominal[],
                                             size_t count)
{
    (void)nominal;
    (void)count;
    return refuse_model_exchange(component);
}
