/* Reads bytes as sequences of FMI calls, legal and illegal, on up to four instances of an FMU, and
 * aborts unless each call is accepted or refused as the state machine of FMI 2.0 for co-simulation
 * has it, a refused call says why, and changes nothing.  Compiled with the kernel's sources and the
 * sanitizers.
 *
 *     sequence RESOURCES GUID < batch             each sequence: its length in two bytes, then its
 * bytes sequence RESOURCES GUID FOLDER < batch      the same on forged copies of model.bin, whose
 * checksum is right: anything may be accepted, but nothing may break
 *
 * With -DLIBFUZZER, clang's libFuzzer calls LLVMFuzzerTestOneInput; RESOURCES and GUID come from
 * the environment. */
#include "sequence.h"

const char *resources, *guid, *forgery;
resource table;
long calls, messages;

static slot slots[SLOTS];
static keeper kept[SLOTS];
static const uint8_t *next_byte, *last_byte;

uint8_t byte(void)
{
    return next_byte < last_byte ? *next_byte++ : 0;
}

static void one_call(void)
{
    slot *s = &slots[byte() % SLOTS];
    keeper *k = &kept[byte() % SLOTS];
    const uint8_t b = byte();
    if (s->is.mode == GONE && b % 8) { /* else most sequences would have no instance */
        instantiate(s);
        return;
    }
    if (s->is.mode < STEPPING && b % 4 == 3)
        move_on(s, s->is.mode == INSTANTIATED ? 1 : 2);
    else if (b < 4)
        instantiate(s);
    else if (b < 7)
        release(s);
    else if (b < 25)
        move_on(s, b % 5);
    else if (b < 60)
        set_values(s, b % 4 == 0);
    else if (b < 85)
        get_values(s, b % 4 == 0);
    else if (b < 150)
        do_step(s);
    else if (b < 165)
        keep(s, k);
    else if (b < 185)
        put_back(s, k);
    else if (b < 190)
        forget(s, k);
    else if (b < 205)
        transport(s, k);
    else if (b < 235)
        derive(s, b % 3);
    else
        others(s, b % 12);
}

/* A copy of model.bin with a few changes: bytes anywhere, or one of the values that programs
 * stumble over. */
static void forge(void)
{
    static const uint32_t odd[] = {0,          1,          8,          0x7fffffff,
                                   0x80000000, 0xffffffff, 0x7ff80000, 0xfff00000};
    char *bytes = malloc(table.size), name[1024];
    memcpy(bytes, table.bytes, table.size);
    for (int i = byte() % 4; i >= 0; i--) {
        /* Header and directory, or the first bytes of a section. */
        const uint8_t where = byte() % (RESOURCE_SECTIONS + 1);
        const resource_section *s = &table.section[where % RESOURCE_SECTIONS];
        const size_t from =
            where < RESOURCE_SECTIONS && s->items ? (size_t)(s->items - table.bytes) : 24;
        const size_t left = table.size - from, room = left < 6000 ? left : 6000;
        const size_t at = from + ((size_t)byte() * 256 + byte()) % room / 4 * 4;
        if (byte() % 2)
            memcpy(bytes + at, &odd[byte() % 8], sizeof *odd);
        else
            bytes[at + byte() % 4] ^= (char)(1 << byte() % 8);
    }
    gallop_cosim_seal(bytes, table.size);
    snprintf(name, sizeof name, "%s/model.bin", forgery);
    FILE *file = fopen(name, "wb");
    REQUIRE(file && fwrite(bytes, 1, table.size, file) == table.size && fclose(file) == 0);
    free(bytes);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (!table.bytes) {
        resources = resources ? resources : getenv("RESOURCES");
        guid = guid ? guid : getenv("GUID");
        REQUIRE(guid && read_resource(&table, resources, guid) == NULL);
    }
    next_byte = data;
    last_byte = data + size;
    if (forgery) forge();
    while (next_byte < last_byte) one_call();
    fmi2Component any =
        fmi2Instantiate("any", fmi2CoSimulation, guid, resources, NULL, fmi2False, fmi2False);
    for (int i = 0; i < SLOTS; i++) {
        fmi2FreeFMUstate(any, &kept[i].state);
        kept[i].is.forged = false;
        release(&slots[i]);
        slots[i].is.forged = false;
    }
    fmi2FreeInstance(any);
    return 0;
}

#if !defined(LIBFUZZER)
int main(int count, char **argument)
{
    static uint8_t data[1 << 16];
    REQUIRE(count == 3 || count == 4);
    resources = argument[1];
    guid = argument[2];
    forgery = argument[3];
    for (int low = getchar(); low != EOF; low = getchar()) {
        const size_t size = (size_t)low + 256 * (size_t)getchar();
        REQUIRE(fread(data, 1, size, stdin) == size);
        LLVMFuzzerTestOneInput(data, size);
    }
    resource_close(&table);
    printf("%ld calls, %ld messages\n", calls, messages);
    return 0;
}
#endif
