/* Fuzzing target: the bytes of a saved state, changed as the input says, read and stepped on from.
 * The first byte is as in resource_target.c.
 *
 * What is refused leaves no trace, and the good state can be restored afterwards, bit for bit. */
#include "instance.h"

#define STEP 0.01
#define HEAD 24 /* bytes in front of what the checksum covers: magic, size, checksum */

static resource table;
static fmi2Component c;
static fmi2FMUstate good;
static char *original;
static size_t original_size;
static long messages;
static const fmi2CallbackFunctions with = {insist_on_text, calloc, free, NULL, &messages};

static char *image(size_t *size)
{
    fmi2FMUstate state = NULL;
    REQUIRE(fmi2GetFMUstate(c, &state) == fmi2OK &&
            fmi2SerializedFMUstateSize(c, state, size) == fmi2OK);
    char *bytes = malloc(*size);
    REQUIRE(fmi2SerializeFMUstate(c, state, bytes, *size) == fmi2OK);
    REQUIRE(fmi2FreeFMUstate(c, &state) == fmi2OK);
    return bytes;
}

static void require_original(void)
{
    size_t size;
    char *now = image(&size);
    REQUIRE(size == original_size && memcmp(now, original, size) == 0);
    free(now);
}

static void clean_up(void)
{
    fmi2FreeFMUstate(c, &good);
    fmi2FreeInstance(c);
    free(original);
    resource_close(&table);
}

static void set_up(void)
{
    read_table(&table);
    c = fmi2Instantiate("fuzzed", fmi2CoSimulation, getenv("GUID"), getenv("RESOURCES"), &with,
                        fmi2False, fmi2False);
    REQUIRE(c && fmi2SetupExperiment(c, fmi2False, 0.0, 0.0, fmi2False, 0.0) == fmi2OK);
    REQUIRE(fmi2EnterInitializationMode(c) == fmi2OK && fmi2ExitInitializationMode(c) == fmi2OK);
    for (int k = 0; k < 3; k++) REQUIRE(fmi2DoStep(c, k * STEP, STEP, fmi2True) == fmi2OK);
    REQUIRE(fmi2GetFMUstate(c, &good) == fmi2OK);
    original = image(&original_size);
    atexit(clean_up);
}

static void go_on(void)
{
    fmi2Real time, value;
    fmi2Integer whole;
    if (!cheap(c, &table)) return;
    if (fmi2GetRealStatus(c, fmi2LastSuccessfulTime, &time) == fmi2OK) {
        REQUIRE(isfinite(time));
        fmi2DoStep(c, time, STEP, fmi2True);
    } else {
        fmi2ExitInitializationMode(c);
    }
    for (fmi2ValueReference i = 0; i < resource_variable_count(&table); i++)
        if (resource_variables(&table)[i].whole)
            fmi2GetInteger(c, &i, 1, &whole);
        else
            fmi2GetReal(c, &i, 1, &value);
    size_t size;
    free(image(&size));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (!c) set_up();
    input in = {data, data + size};
    const uint8_t how = byte_of(&in);
    const size_t left = how & 1 ? word_of(&in) % (original_size + 1) : original_size;
    char *bytes = malloc(left + 1);
    memcpy(bytes, original, left);
    edit(&in, bytes, left);
    if (!(how & 2) && left >= HEAD) {
        const uint64_t whole = left, checksum = resource_file_checksum(bytes + HEAD, left - HEAD);
        memcpy(bytes + 8, &whole, sizeof whole);
        memcpy(bytes + 16, &checksum, sizeof checksum);
    }
    fmi2FMUstate state = NULL;
    const long said = messages;
    if (fmi2DeSerializeFMUstate(c, bytes, left, &state) == fmi2OK) {
        REQUIRE(state != NULL && left == original_size);
        if (fmi2SetFMUstate(c, state) == fmi2OK) {
            if (how < 64) go_on();
            REQUIRE(fmi2SetFMUstate(c, good) == fmi2OK);
        } else {
            REQUIRE(messages > said);
        }
        REQUIRE(fmi2FreeFMUstate(c, &state) == fmi2OK);
    } else {
        REQUIRE(state == NULL && messages > said);
    }
    free(bytes);
    require_original();
    return 0;
}
