/* Fuzzing target: resources/model.bin of an FMU, changed as the input says, read and used.
 *
 * The first byte: whether the file is cut off, whether its checksum and size are set right again,
 * so that the checks behind them are reached, and whether what was read is also stepped. */
#include "instance.h"

#include <unistd.h>

static const fmi2ValueReference HUGE_REFERENCE = 4000000000u;
static resource table;
static char folder[] = "/tmp/fuzzXXXXXX", file_name[64];

static void clean_up(void)
{
    unlink(file_name);
    rmdir(folder);
    resource_close(&table);
}

static void set_up(void)
{
    read_table(&table);
    REQUIRE(mkdtemp(folder));
    snprintf(file_name, sizeof file_name, "%s/model.bin", folder);
    atexit(clean_up);
}

static void use(fmi2Component c, const resource *r)
{
    fmi2Real real;
    fmi2Integer whole;
    for (fmi2ValueReference i = 0; i < resource_variable_count(r); i++) {
        fmi2GetReal(c, &i, 1, &real);
        fmi2GetInteger(c, &i, 1, &whole);
    }
    REQUIRE(fmi2GetReal(c, &HUGE_REFERENCE, 1, &real) == fmi2Error);
    if (!cheap(c, r)) return;
    if (fmi2SetupExperiment(c, fmi2False, 0.0, 0.0, fmi2False, 0.0) != fmi2OK) return;
    if (fmi2EnterInitializationMode(c) != fmi2OK || fmi2ExitInitializationMode(c) != fmi2OK) return;
    fmi2DoStep(c, 0.0, 0.02, fmi2True);
    for (fmi2ValueReference i = 0; i < resource_variable_count(r); i++)
        fmi2GetReal(c, &i, 1, &real);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const fmi2CallbackFunctions with = {insist_on_text, calloc, free, NULL, NULL};
    if (!table.bytes) set_up();
    input in = {data, data + size};
    const uint8_t how = byte_of(&in);
    size_t left = how & 1 ? word_of(&in) % (table.size + 1) : table.size;
    char *bytes = malloc(left + 1);
    memcpy(bytes, table.bytes, left);
    edit(&in, bytes, left);
    if (!(how & 2)) gallop_cosim_seal(bytes, left);
    FILE *file = fopen(file_name, "wb");
    REQUIRE(file && fwrite(bytes, 1, left, file) == left && fclose(file) == 0);
    free(bytes);

    resource read;
    const char *guid = resource_identity(&table)->guid, *wrong = read_resource(&read, folder, guid);
    REQUIRE((wrong == NULL) == (read.bytes != NULL));
    fmi2Component c =
        fmi2Instantiate("fuzzed", fmi2CoSimulation, guid, folder, &with, fmi2False, fmi2False);
    REQUIRE((wrong == NULL) == (c != NULL));
    if (c && how < 64) use(c, &read);
    fmi2FreeInstance(c);
    resource_close(&read);
    return 0;
}
