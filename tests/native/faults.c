/* Makes the n-th allocation of the library fail, for all n, and insists on a clean refusal and, by
 * the leak checker at the end, on no leak.  Linked with -Wl,--wrap for malloc and calloc.
 *
 *     faults RESOURCES GUID */
#include "gallop.h"
#include "read_resource.h"

#include <fmi2Functions.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);

static long left = -1; /* allocations until one fails; negative: none does */
static int failed, messages;
static char last_message[2048];

static int fails(void)
{
    if (left < 0 || left-- > 0) return 0;
    failed = 1;
    return 1;
}

void *__wrap_malloc(size_t size)
{
    return fails() ? NULL : __real_malloc(size);
}
void *__wrap_calloc(size_t count, size_t size)
{
    return fails() ? NULL : __real_calloc(count, size);
}

static void require(int ok, const char *what, long n)
{
    if (ok) return;
    fprintf(stderr, "allocation %ld: not so: %s (last message: %s)\n", n, what, last_message);
    exit(1);
}
#define REQUIRE(condition) require((condition), #condition, n)

static void logger(void *environment, fmi2String instance, fmi2Status status, fmi2String category,
                   fmi2String format, ...)
{
    va_list arguments;
    (void)environment, (void)instance, (void)status, (void)category;
    va_start(arguments, format);
    vsnprintf(last_message, sizeof last_message, format, arguments);
    va_end(arguments);
    messages++;
}

static const fmi2CallbackFunctions with = {logger, calloc, free, NULL, NULL};
static const char *resources, *guid;

static fmi2Component new_instance(void)
{
    return fmi2Instantiate("span", fmi2CoSimulation, guid, resources, &with, fmi2False, fmi2False);
}

/* An instance that has made three steps. */
static fmi2Component stepping(void)
{
    fmi2Component c = new_instance();
    require(c && fmi2SetupExperiment(c, fmi2False, 0.0, 0.0, fmi2False, 0.0) == fmi2OK &&
                fmi2EnterInitializationMode(c) == fmi2OK && fmi2ExitInitializationMode(c) == fmi2OK,
            "an instance", -1);
    for (int k = 0; k < 3; k++)
        require(fmi2DoStep(c, k * 0.01, 0.01, fmi2True) == fmi2OK, "a step", -1);
    return c;
}

/* Calls with the n-th allocation failing, n = 0, 1, ..., until none failed; how many could fail. */
static long every(void (*attempt)(long n))
{
    for (long n = 0;; n++) {
        messages = failed = 0;
        attempt(n);
        left = -1;
        if (!failed) return n;
    }
}

static void create(long n)
{
    resource table;
    gallop_model *model;
    gallop_report report;
    REQUIRE(read_resource(&table, resources, guid) == NULL);
    const gallop_scene scene = resource_scene(&table);
    left = n;
    const int outcome = gallop_model_create(&scene, &model, &report);
    REQUIRE(outcome == (failed ? GALLOP_OUT_OF_MEMORY : GALLOP_COMPLETED) &&
            report.outcome == outcome);
    REQUIRE((model == NULL) == failed);
    gallop_model_free(model);
    resource_close(&table);
}

static void read_file(long n)
{
    resource table;
    left = n;
    const char *wrong = read_resource(&table, resources, guid);
    REQUIRE((wrong != NULL) == failed && (table.bytes == NULL) == failed);
    if (wrong) REQUIRE(strstr(wrong, "memory") != NULL);
    resource_close(&table);
}

static void instantiate(long n)
{
    left = n;
    fmi2Component c = new_instance();
    REQUIRE((c == NULL) == failed);
    /* Without memory for the instance and its name there is no logger. */
    if (failed && n > 1) REQUIRE(messages == 1 && strstr(last_message, "memory"));
    fmi2FreeInstance(c);
}

static void initialise(long n)
{
    fmi2Component c = new_instance();
    REQUIRE(c && fmi2SetupExperiment(c, fmi2False, 0.0, 0.0, fmi2False, 0.0) == fmi2OK);
    REQUIRE(fmi2EnterInitializationMode(c) == fmi2OK);
    left = n;
    REQUIRE(fmi2ExitInitializationMode(c) == (failed ? fmi2Error : fmi2OK));
    left = -1;
    REQUIRE(messages == failed);
    if (failed) REQUIRE(fmi2ExitInitializationMode(c) == fmi2OK); /* there is memory again */
    REQUIRE(fmi2DoStep(c, 0.0, 0.01, fmi2True) == fmi2OK);
    fmi2FreeInstance(c);
}

/* Every use of states; what fails leaves the instance as it was, and goes through when there is
 * memory again. */
static void states(long n)
{
    fmi2Component c = stepping();
    fmi2FMUstate state = NULL, copy = NULL;
    size_t size;
    static char before[1 << 20], after[1 << 20];
    REQUIRE(fmi2GetFMUstate(c, &state) == fmi2OK &&
            fmi2SerializedFMUstateSize(c, state, &size) == fmi2OK);
    REQUIRE(size <= sizeof before && fmi2SerializeFMUstate(c, state, before, size) == fmi2OK);
    left = n;
    const fmi2Status got = fmi2GetFMUstate(c, &copy);
    REQUIRE((got == fmi2Error) == failed && (copy == NULL) == failed);
    if (!failed) REQUIRE(fmi2FreeFMUstate(c, &copy) == fmi2OK);
    const int refused = failed;
    const fmi2Status read = refused ? fmi2OK : fmi2DeSerializeFMUstate(c, before, size, &copy);
    if (!refused) REQUIRE((read == fmi2Error) == failed && (copy == NULL) == failed);
    left = -1;
    if (failed) REQUIRE(messages == 1 && strstr(last_message, "memory"));
    REQUIRE(fmi2FreeFMUstate(c, &copy) == fmi2OK &&
            fmi2DeSerializeFMUstate(c, before, size, &copy) == fmi2OK);
    REQUIRE(fmi2SetFMUstate(c, copy) == fmi2OK &&
            fmi2SerializeFMUstate(c, state, after, size) == fmi2OK);
    REQUIRE(memcmp(before, after, size) == 0);
    REQUIRE(fmi2FreeFMUstate(c, &copy) == fmi2OK && fmi2FreeFMUstate(c, &state) == fmi2OK);
    fmi2FreeInstance(c);
}

/* A state with other parameters, for which a span is built: if that fails, the present one stays.
 */
static void exchange(long n)
{
    static const fmi2ValueReference wind = 0;
    resource table;
    fmi2Real value;
    fmi2FMUstate other = NULL;
    REQUIRE(read_resource(&table, resources, guid) == NULL);
    fmi2Component c = new_instance(), present = stepping();
    for (fmi2ValueReference r = 0; r < resource_variable_count(&table); r++)
        if (!strcmp(resource_variables(&table)[r].name, "conductor.axial_stiffness"))
            REQUIRE(fmi2GetReal(c, &r, 1, &value) == fmi2OK &&
                    (value *= 1.01, fmi2SetReal(c, &r, 1, &value)) == fmi2OK);
    REQUIRE(fmi2SetupExperiment(c, fmi2False, 0.0, 0.0, fmi2False, 0.0) == fmi2OK &&
            fmi2EnterInitializationMode(c) == fmi2OK && fmi2ExitInitializationMode(c) == fmi2OK &&
            fmi2GetFMUstate(c, &other) == fmi2OK);
    left = n;
    const fmi2Status status = fmi2SetFMUstate(present, other);
    left = -1;
    REQUIRE(status == (failed ? fmi2Error : fmi2OK) && messages == failed);
    REQUIRE(fmi2GetReal(present, &wind, 1, &value) == fmi2OK);
    REQUIRE(fmi2DoStep(present, failed ? 0.03 : 0.0, 0.01, fmi2True) == fmi2OK);
    fmi2FreeFMUstate(c, &other);
    fmi2FreeInstance(c);
    fmi2FreeInstance(present);
    resource_close(&table);
}

int main(int count, char **argument)
{
    require(count == 3, "two arguments", -1);
    resources = argument[1];
    guid = argument[2];
    printf("create %ld\n", every(create));
    printf("resource %ld\n", every(read_file));
    printf("instantiate %ld\n", every(instantiate));
    printf("initialise %ld\n", every(initialise));
    printf("states %ld\n", every(states));
    printf("exchange %ld\n", every(exchange));
    return 0;
}
