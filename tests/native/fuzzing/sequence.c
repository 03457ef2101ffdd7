/* Reads bytes as sequences of FMI calls, legal and illegal, on up to four instances of an FMU, and aborts unless each
 * call is accepted or refused as the state machine of FMI 2.0 for co-simulation has it, a refused call says why, and
 * changes nothing.  Compiled with the kernel's sources and the sanitizers.
 *
 *     sequence RESOURCES GUID < batch             each sequence: its length in two bytes, then its bytes
 *     sequence RESOURCES GUID FOLDER < batch      the same on forged copies of model.bin, whose checksum is right:
 *                                                 anything may be accepted, but nothing may break
 *
 * With -DLIBFUZZER, clang's libFuzzer calls LLVMFuzzerTestOneInput; RESOURCES and GUID come from the environment. */
#include "resource.h"

#include <fmi2Functions.h>
#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SLOTS 4
#define MOST 3   /* variables in one call */
#define REQUIRE(condition) \
    do { \
        if (condition) break; \
        fprintf(stderr, "%s:%d: not so: %s\n", __FILE__, __LINE__, #condition); \
        abort(); \
    } while (0)

typedef enum { GONE = 0, INSTANTIATED = 1, INITIALIZING = 2, STEPPING = 4, TERMINATED = 8 } mode;
enum { SETTABLE = INSTANTIATED | INITIALIZING | STEPPING, ANY = SETTABLE | TERMINATED };
typedef enum { REFUSED, ACCEPTED, EITHER } verdict;

/* What the standard lets one know of an instance or of a saved state. */
typedef struct {
    mode mode;
    bool hostile;         /* holds a forged state: anything may be accepted, but nothing may break */
    bool looks_back;      /* a step, or the initial state, that derivatives can be taken of */
    double time, stop;
} model;

typedef struct { fmi2Component c; model is; } slot;
typedef struct { fmi2FMUstate state; model is; } keeper;

static slot slots[SLOTS];
static keeper kept[SLOTS];
static const char *resources, *guid, *forgery;
static resource table;
static long calls, messages;
static const uint8_t *next_byte, *last_byte;

static uint8_t byte(void) { return next_byte < last_byte ? *next_byte++ : 0; }

static void logger(void *environment, fmi2String instance, fmi2Status status, fmi2String category,
                   fmi2String format, ...)
{
    char text[2048];
    va_list arguments;
    (void)environment;
    REQUIRE(instance && category && (status == fmi2Error || status == fmi2Discard));
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    REQUIRE(strlen(text) > 10);
    messages++;
}

/* The bytes of an instance's state; NULL: there is no instance. */
static char *image(fmi2Component c, size_t *size)
{
    fmi2FMUstate state = NULL;
    if (!c) return NULL;
    REQUIRE(fmi2GetFMUstate(c, &state) == fmi2OK && fmi2SerializedFMUstateSize(c, state, size) == fmi2OK);
    char *bytes = malloc(*size);
    REQUIRE(fmi2SerializeFMUstate(c, state, bytes, *size) == fmi2OK);
    REQUIRE(fmi2FreeFMUstate(c, &state) == fmi2OK && state == NULL);
    return bytes;
}

/* Judges a call.  `steady`: what is refused leaves no trace. */
#define JUDGE(s, expected, steady, call) \
    do { \
        size_t before_size = 0, after_size = 0; \
        char *before = (steady) ? image((s)->c, &before_size) : NULL; \
        long said = messages; \
        status = (call); \
        calls++; \
        judge((s), (expected), status, said, #call); \
        if (before && status != fmi2OK) { \
            char *after = image((s)->c, &after_size); \
            REQUIRE(before_size == after_size && memcmp(before, after, after_size) == 0); \
            free(after); \
        } \
        free(before); \
    } while (0)

static void judge(const slot *s, verdict expected, fmi2Status status, long said, const char *call)
{
    REQUIRE(status == fmi2OK || status == fmi2Error || status == fmi2Discard);
    if (s->c && status != fmi2OK) REQUIRE(messages > said);
    if (s->is.hostile && s->c) return;
    if (expected == EITHER || (status == fmi2OK) == (expected == ACCEPTED)) return;
    fprintf(stderr, "%s gave %d in mode %d\n", call, status, s->is.mode);
    abort();
}

static verdict when(const slot *s, int modes) { return s->is.mode & modes ? ACCEPTED : REFUSED; }

static double number(void)
{
    static const double odd[] = {NAN, INFINITY, -INFINITY, 0.0, -1.0, 1e300, -1e-300, 1e9};
    uint8_t b = byte();
    return b < 16 ? odd[b % 8] : (b - 128) / 64.0;
}

/* Mostly near the start value of a variable, so that spans stay spans. */
static double value_for(const resource_variable *v)
{
    uint8_t b = byte();
    if (v->origin == ORIGIN_INPUT && v->place == 0 && b > 32) return b / 16.0;
    if (v->origin == ORIGIN_INPUT && v->place == 1 && b > 32) return 3.14159 + (b - 144) / 400.0;
    if (v->origin == ORIGIN_INPUT && b > 32) return (b - 144) / 2000.0;
    if (v->origin != ORIGIN_PARAMETER || b < 32) return number();
    const char *at = table.bytes + v->place;
    if (v->whole) return *(const int32_t *)at + b % 3;
    return *(const double *)at / v->factor * (1.0 + (b - 144) / 4000.0);
}

static const resource_variable *variable(fmi2ValueReference r)
{
    return r < resource_head(&table)->variable_count ? &resource_table(&table)[r] : NULL;
}

static fmi2ValueReference reference(void)
{
    uint8_t b = byte();
    uint32_t count = resource_head(&table)->variable_count;
    if (b == 255) return 4000000000u;
    return b < 100 ? b % 8u : b % (count + 2u);
}

static bool settable(const slot *s, const resource_variable *v, double value)
{
    bool parameter = v->origin == ORIGIN_PARAMETER, input = v->origin == ORIGIN_INPUT;
    const int modes = input ? SETTABLE : parameter ? INSTANTIATED | INITIALIZING : 0;
    if (!(s->is.mode & modes)) return false;
    return isfinite(value) && value >= v->minimum && value <= v->maximum;
}

static void set_values(slot *s, bool whole)
{
    fmi2ValueReference r[MOST];
    fmi2Real real[MOST];
    fmi2Integer integer[MOST];
    fmi2Status status;
    const size_t count = byte() % (MOST + 1);
    bool good = s->is.mode & SETTABLE;
    for (size_t i = 0; i < count; i++) {
        r[i] = reference();
        const resource_variable *v = variable(r[i]);
        real[i] = v ? value_for(v) : 0.0;
        integer[i] = fabs(real[i]) < 1e6 ? (fmi2Integer)real[i] : -7;
        good = good && v && (v->whole != 0) == whole && settable(s, v, whole ? integer[i] : real[i]);
    }
    if (byte() == 7) {
        verdict expected = count || !(s->is.mode & SETTABLE) ? REFUSED : ACCEPTED;
        JUDGE(s, expected, true, fmi2SetReal(s->c, NULL, count, NULL));
    } else if (whole) {
        JUDGE(s, good ? ACCEPTED : REFUSED, true, fmi2SetInteger(s->c, r, count, integer));
    } else {
        JUDGE(s, good ? ACCEPTED : REFUSED, true, fmi2SetReal(s->c, r, count, real));
    }
}

static void get_values(slot *s, bool whole)
{
    fmi2ValueReference r[MOST];
    fmi2Real real[MOST];
    fmi2Integer integer[MOST];
    fmi2Status status;
    const size_t count = byte() % (MOST + 1);
    bool good = s->is.mode & ANY, open = false;
    for (size_t i = 0; i < count; i++) {
        r[i] = reference();
        const resource_variable *v = variable(r[i]);
        good = good && v && (v->whole != 0) == whole;
        if (!good || v->origin <= ORIGIN_INPUT) continue;
        if (s->is.mode == INSTANTIATED) good = false;
        if (s->is.mode == INITIALIZING) open = true;   /* there may be no initial state */
    }
    verdict expected = !good ? REFUSED : open ? EITHER : ACCEPTED;
    if (whole) JUDGE(s, expected, s->is.mode != INITIALIZING, fmi2GetInteger(s->c, r, count, integer));
    else JUDGE(s, expected, s->is.mode != INITIALIZING, fmi2GetReal(s->c, r, count, real));
    for (size_t i = 0; status == fmi2OK && !whole && !s->is.hostile && i < count; i++) REQUIRE(isfinite(real[i]));
}

/* Nobody waits for a million steps: forged states may ask for them. */
static bool cheap(fmi2Component c)
{
    if (!c) return true;
    for (uint32_t i = 0; i < resource_head(&table)->variable_count; i++) {
        const resource_variable *v = variable(i);
        fmi2Real step;
        fmi2Integer whole;
        if (!strcmp(v->name, "numerics.time_step") && fmi2GetReal(c, &i, 1, &step) == fmi2OK && !(step > 1e-3))
            return false;
        if (strncmp(v->name, "numerics.", 9) != 0 || !v->whole) continue;
        if (fmi2GetInteger(c, &i, 1, &whole) == fmi2OK && whole > 50) return false;
    }
    return true;
}

static void do_step(slot *s)
{
    static const double size[] = {0.01, 0.01, 0.01, 0.02, 0.005, 0.037, 1e-7, 0.0, -0.01, NAN, INFINITY, 1e-30, 1e300};
    static const double off[] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, NAN, -1e-3, 1e300};
    fmi2Status status;
    const uint8_t which = byte() % 26;
    const double h = size[which < 13 ? which : 0], shift = off[byte() % 10], time = s->is.time + shift;
    const bool possible = h > 0.0 && h < 1e9 && time + h > s->is.time && !(time + h > s->is.stop + 1e-9);
    const bool good = s->is.mode == STEPPING && possible && shift == 0.0;
    if (s->is.hostile && !cheap(s->c)) return;
    JUDGE(s, good ? EITHER : REFUSED, !good, fmi2DoStep(s->c, time, h, byte() % 2));
    if (!good || s->is.hostile) return;
    fmi2Real reached;
    if (status == fmi2OK) s->is.time = time + h;
    s->is.looks_back = status == fmi2OK || (s->is.looks_back && s->is.time == 0.0);
    REQUIRE(fmi2GetRealStatus(s->c, fmi2LastSuccessfulTime, &reached) == fmi2OK && reached == s->is.time);
}

static void instantiate(slot *s)
{
    static const fmi2CallbackFunctions with = {logger, calloc, free, NULL, NULL};
    static const fmi2CallbackFunctions silent = {NULL, calloc, free, NULL, NULL};
    if (s->c) return;
    const uint8_t b = byte();
    const char *name = b == 1 ? NULL : b == 2 ? "" : "%s%n";   /* a name is no format */
    const char *id = b == 3 ? NULL : b == 4 ? "{other}" : guid;
    const char *where = b == 5 ? NULL : b == 6 ? "file:///no" : forgery ? forgery : resources;
    s->c = fmi2Instantiate(name, b == 7 ? fmi2ModelExchange : fmi2CoSimulation, id, where,
                           b == 8 ? NULL : b == 9 ? &silent : &with, b % 2, b % 3 == 0);
    calls++;
    REQUIRE(forgery || (s->c != NULL) == !(b >= 1 && b <= 7));
    if (s->c && (b == 8 || b == 9)) {   /* who cannot speak is not judged */
        fmi2FreeInstance(s->c);
        s->c = NULL;
    }
    s->is = (model){s->c ? INSTANTIATED : GONE, forgery != NULL, false, 0.0, INFINITY};
}

static void release(slot *s)
{
    fmi2FreeInstance(s->c);
    calls++;
    s->c = NULL;
    s->is.mode = GONE;
}

static void move_on(slot *s, uint8_t what)
{
    fmi2Status status;
    if (what == 0) {
        const double start = byte() < 200 ? 0.0 : number(), stop = byte() < 128 ? 0.5 : number();
        const bool with_stop = byte() % 2;
        const bool good = s->is.mode == INSTANTIATED && isfinite(start) && (!with_stop || stop > start);
        if (start > 1e6 || start < 0.0) return;   /* steps would be lost in round-off, which do_step does not foresee */
        JUDGE(s, good ? ACCEPTED : REFUSED, true, fmi2SetupExperiment(s->c, fmi2False, 0.0, start, with_stop, stop));
        if (status != fmi2OK || !good) return;
        s->is.time = start;
        s->is.stop = with_stop ? stop : INFINITY;
    } else if (what == 1) {
        JUDGE(s, when(s, INSTANTIATED), true, fmi2EnterInitializationMode(s->c));
        if (status == fmi2OK) s->is.mode = INITIALIZING;
    } else if (what == 2) {
        if (s->is.hostile && !cheap(s->c)) return;
        const bool open = s->is.mode == INITIALIZING;
        JUDGE(s, open ? EITHER : REFUSED, !open, fmi2ExitInitializationMode(s->c));
        if (status != fmi2OK) return;
        s->is.mode = STEPPING;
        s->is.looks_back = false;   /* true unless a state was restored meanwhile: not judged before the first step */
    } else if (what == 3) {
        JUDGE(s, when(s, STEPPING), true, fmi2Terminate(s->c));
        if (status == fmi2OK) s->is.mode = TERMINATED;
    } else {
        JUDGE(s, when(s, ANY), true, fmi2Reset(s->c));
        if (status == fmi2OK) s->is = (model){INSTANTIATED, forgery != NULL, false, 0.0, INFINITY};
    }
}

static void keep(slot *s, keeper *k)
{
    fmi2Status status;
    if (k->is.hostile && !forgery) return;
    JUDGE(s, when(s, ANY), false, fmi2GetFMUstate(s->c, &k->state));
    if (status != fmi2OK) return;
    k->is = s->is;
    JUDGE(s, REFUSED, true, fmi2GetFMUstate(s->c, NULL));
}

static void put_back(slot *s, keeper *k)
{
    fmi2Status status;
    if (k->is.hostile && s->is.mode == GONE) return;
    verdict expected = k->is.hostile ? EITHER : k->state && s->is.mode != GONE ? ACCEPTED : REFUSED;
    JUDGE(s, expected, true, fmi2SetFMUstate(s->c, k->state));
    if (status != fmi2OK) return;
    s->is = k->is;
    s->is.looks_back = false;
}

static void forget(slot *s, keeper *k)
{
    fmi2Status status;
    if (!s->c) return;
    JUDGE(s, ACCEPTED, true, fmi2FreeFMUstate(s->c, &k->state));
    REQUIRE(k->state == NULL);
    k->is.hostile = false;
}

/* Through bytes: as they are, spoilt, or forged with a right checksum. */
static void transport(slot *s, keeper *k)
{
    fmi2Status status;
    fmi2FMUstate copy = NULL;
    size_t size = 0;
    if (!s->c || !k->state || (k->is.hostile && !forgery)) return;
    REQUIRE(fmi2SerializedFMUstateSize(s->c, k->state, &size) == fmi2OK);
    char *bytes = malloc(size);
    JUDGE(s, REFUSED, true, fmi2SerializeFMUstate(s->c, k->state, bytes, size - 1));
    JUDGE(s, ACCEPTED, true, fmi2SerializeFMUstate(s->c, k->state, bytes, size));
    const uint8_t how = byte() % 4;
    if (how == 1) size -= 1 + byte() % (size - 1);
    if (how >= 2) {
        for (int i = byte() % 4; i >= 0; i--) {
            size_t at = ((size_t)byte() * 256 + byte()) % size;
            if (byte() % 2) at %= 400;   /* the head */
            bytes[at] ^= (char)(1 + byte() % 255);
        }
    }
    if (how == 3) {
        const uint64_t checksum = resource_checksum(bytes + 24, size - 24);
        memcpy(bytes + 16, &checksum, sizeof checksum);
    }
    verdict expected = how == 0 ? ACCEPTED : how == 3 ? EITHER : REFUSED;
    if (how == 2) expected = EITHER;   /* two changes may cancel out */
    JUDGE(s, expected, true, fmi2DeSerializeFMUstate(s->c, bytes, size, &copy));
    free(bytes);
    if (status != fmi2OK) return;
    REQUIRE(fmi2FreeFMUstate(s->c, &k->state) == fmi2OK);
    k->state = copy;
    k->is.hostile = how != 0 || forgery;
}

static void derive(slot *s, uint8_t what)
{
    fmi2ValueReference unknown[MOST], known[MOST];
    fmi2Integer order[MOST];
    fmi2Real value[MOST], found[MOST];
    fmi2Status status;
    const size_t count = byte() % (MOST + 1), other = byte() % (MOST + 1);
    bool inputs = true, outputs = true;
    for (size_t i = 0; i < MOST; i++) {
        known[i] = reference(), unknown[i] = byte() < 200 ? 8u + byte() % 16u : reference();
        order[i] = byte() < 230 ? 1 : (fmi2Integer)byte() - 100;
        value[i] = byte() < 230 ? (byte() - 128) / 100.0 : number();
    }
    const size_t many = what == 2 ? other : count;
    for (size_t i = 0; i < many; i++) {
        const resource_variable *v = variable(known[i]);
        inputs = inputs && v && v->origin == ORIGIN_INPUT && isfinite(value[i]) && (what == 2 || order[i] == 1);
    }
    for (size_t i = 0; i < count; i++) {
        const resource_variable *v = variable(unknown[i]);
        outputs = outputs && v && !v->whole && (v->origin == ORIGIN_NODE || v->origin == ORIGIN_SPAN) &&
                  (what == 2 || order[i] == 1);
    }
    if (what == 0) {
        JUDGE(s, s->is.mode & SETTABLE && inputs ? ACCEPTED : REFUSED, true,
              fmi2SetRealInputDerivatives(s->c, known, count, order, value));
    } else if (what == 1) {
        verdict expected = s->is.looks_back ? ACCEPTED : EITHER;
        if (!(s->is.mode & (STEPPING | TERMINATED)) || !outputs) expected = REFUSED;
        JUDGE(s, expected, true, fmi2GetRealOutputDerivatives(s->c, unknown, count, order, found));
    } else {
        const bool allowed = s->is.mode & (INITIALIZING | STEPPING | TERMINATED);
        if (s->is.hostile && !cheap(s->c)) return;
        JUDGE(s, allowed && inputs && outputs ? EITHER : REFUSED, s->is.mode != INITIALIZING,
              fmi2GetDirectionalDerivative(s->c, unknown, count, known, other, value, found));
    }
}

static void others(slot *s, uint8_t what)
{
    const fmi2ValueReference r[1] = {0};
    const fmi2String category[] = {byte() % 2 ? "logStatusError" : "nonsense"};
    const verdict known = s->is.mode & (STEPPING | TERMINATED) ? ACCEPTED : REFUSED;
    fmi2Boolean truth[1] = {0};
    fmi2String text[1] = {""};
    fmi2Status status, given;
    fmi2Integer integer;
    fmi2Real real;
    const fmi2StatusKind kind = (fmi2StatusKind)(byte() % 4);
    switch (what) {
    case 0: JUDGE(s, REFUSED, true, fmi2CancelStep(s->c)); break;
    case 1: JUDGE(s, REFUSED, true, fmi2GetStatus(s->c, kind, &given)); break;
    case 2:
        JUDGE(s, kind == fmi2LastSuccessfulTime ? known : REFUSED, true, fmi2GetRealStatus(s->c, kind, &real));
        break;
    case 3: JUDGE(s, REFUSED, true, fmi2GetIntegerStatus(s->c, kind, &integer)); break;
    case 4: JUDGE(s, kind == fmi2Terminated ? known : REFUSED, true, fmi2GetBooleanStatus(s->c, kind, truth)); break;
    case 5: JUDGE(s, REFUSED, true, fmi2GetStringStatus(s->c, kind, text)); break;
    case 6: JUDGE(s, REFUSED, true, fmi2SetBoolean(s->c, r, 1, truth)); break;
    case 7: JUDGE(s, REFUSED, true, fmi2GetBoolean(s->c, r, 1, truth)); break;
    case 8: JUDGE(s, REFUSED, true, fmi2SetString(s->c, r, 1, text)); break;
    case 9: JUDGE(s, REFUSED, true, fmi2GetString(s->c, r, 1, text)); break;
    case 10: JUDGE(s, when(s, ANY), true, fmi2GetString(s->c, NULL, 0, NULL)); break;
    default:
        JUDGE(s, category[0][0] == 'l' ? when(s, ANY) : REFUSED, true,
              fmi2SetDebugLogging(s->c, fmi2True, 1, category));
    }
}

static void one_call(void)
{
    slot *s = &slots[byte() % SLOTS];
    keeper *k = &kept[byte() % SLOTS];
    const uint8_t b = byte();
    if (s->is.mode == GONE && b % 8) {   /* else most sequences would speak to nobody */
        instantiate(s);
        return;
    }
    if (s->is.mode < STEPPING && b % 4 == 3) move_on(s, s->is.mode == INSTANTIATED ? 1 : 2);
    else if (b < 4) instantiate(s);
    else if (b < 7) release(s);
    else if (b < 25) move_on(s, b % 5);
    else if (b < 60) set_values(s, b % 4 == 0);
    else if (b < 85) get_values(s, b % 4 == 0);
    else if (b < 150) do_step(s);
    else if (b < 165) keep(s, k);
    else if (b < 185) put_back(s, k);
    else if (b < 190) forget(s, k);
    else if (b < 205) transport(s, k);
    else if (b < 235) derive(s, b % 3);
    else others(s, b % 12);
}

/* A copy of model.bin with a few changes: bytes anywhere, or one of the values that programs stumble over. */
static void forge(void)
{
    static const uint32_t odd[] = {0, 1, 8, 0x7fffffff, 0x80000000, 0xffffffff, 0x7ff80000, 0xfff00000};
    char *bytes = malloc(table.size), name[1024];
    memcpy(bytes, table.bytes, table.size);
    for (int i = byte() % 4; i >= 0; i--) {
        const uint8_t where = byte() % 4;
        const resource_header *head = resource_head(&table);
        const size_t from = where == 0 ? 88 : where == 1 ? head->scene : head->variables;
        const size_t room = where == 0 ? 24 : where == 1 ? head->variables - from : 6000;
        const size_t at = from + ((size_t)byte() * 256 + byte()) % room / 4 * 4;
        if (byte() % 2) memcpy(bytes + at, &odd[byte() % 8], sizeof *odd);
        else bytes[at + byte() % 4] ^= (char)(1 << byte() % 8);
    }
    const uint64_t checksum = resource_checksum(bytes + 24, table.size - 24);
    memcpy(bytes + 16, &checksum, sizeof checksum);
    snprintf(name, sizeof name, "%s/model.bin", forgery);
    FILE *file = fopen(name, "wb");
    REQUIRE(file && fwrite(bytes, 1, table.size, file) == table.size && fclose(file) == 0);
    free(bytes);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (!table.bytes) {
        resources = resources ? resources : getenv("RESOURCES");
        guid = guid ? guid : getenv("GUID");
        REQUIRE(guid && resource_read(&table, resources, guid) == NULL);
    }
    next_byte = data;
    last_byte = data + size;
    if (forgery) forge();
    while (next_byte < last_byte) one_call();
    fmi2Component any = fmi2Instantiate("any", fmi2CoSimulation, guid, resources, NULL, fmi2False, fmi2False);
    for (int i = 0; i < SLOTS; i++) {
        fmi2FreeFMUstate(any, &kept[i].state);
        kept[i].is.hostile = false;
        release(&slots[i]);
        slots[i].is.hostile = false;
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
    resource_free(&table);
    printf("%ld calls, %ld messages\n", calls, messages);
    return 0;
}
#endif
