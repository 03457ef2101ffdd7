/* Calls that move an instance on: from instantiation to termination, steps, and saved states. */
#include "sequence.h"

void do_step(slot *s)
{
    static const double size[] = {0.01, 0.01,  0.01, 0.02,     0.005, 0.037, 1e-7,
                                  0.0,  -0.01, NAN,  INFINITY, 1e-30, 1e300};
    static const double off[] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, NAN, -1e-3, 1e300};
    fmi2Status status;
    const uint8_t which = byte() % 26;
    const double h = size[which < 13 ? which : 0], shift = off[byte() % 10],
                 time = s->is.time + shift;
    const bool possible =
        h > 0.0 && h < 1e9 && time + h > s->is.time && !(time + h > s->is.stop + 1e-9);
    const bool good = s->is.mode == STEPPING && possible && shift == 0.0;
    if (s->is.forged && !cheap(s->c, &table)) return;
    JUDGE(s, good ? EITHER : REFUSED, !good, fmi2DoStep(s->c, time, h, byte() % 2));
    if (!good || s->is.forged) return;
    fmi2Real reached;
    if (status == fmi2OK) s->is.time = time + h;
    s->is.looks_back = status == fmi2OK || (s->is.looks_back && s->is.time == 0.0);
    REQUIRE(fmi2GetRealStatus(s->c, fmi2LastSuccessfulTime, &reached) == fmi2OK &&
            reached == s->is.time);
}

void instantiate(slot *s)
{
    if (s->c) return;
    const uint8_t b = byte();
    const char *name = b == 1 ? NULL : b == 2 ? "" : "%s%n"; /* a name is no format */
    const char *id = b == 3 ? NULL : b == 4 ? "{other}" : guid;
    const char *where = b == 5 ? NULL : b == 6 ? "file:///no" : forgery ? forgery : resources;
    s->c = fmi2Instantiate(name, b == 7 ? fmi2ModelExchange : fmi2CoSimulation, id, where,
                           b == 8   ? NULL
                           : b == 9 ? &silent
                                    : &with,
                           b % 2, b % 3 == 0);
    calls++;
    REQUIRE(forgery || (s->c != NULL) == !(b >= 1 && b <= 7));
    if (s->c && (b == 8 || b == 9)) { /* who cannot speak is not judged */
        fmi2FreeInstance(s->c);
        s->c = NULL;
    }
    s->is = (model){s->c ? INSTANTIATED : GONE, forgery != NULL, false, 0.0, INFINITY};
}

void release(slot *s)
{
    fmi2FreeInstance(s->c);
    calls++;
    s->c = NULL;
    s->is.mode = GONE;
}

void move_on(slot *s, uint8_t what)
{
    fmi2Status status;
    if (what == 0) {
        const double start = byte() < 200 ? 0.0 : number(), stop = byte() < 128 ? 0.5 : number();
        const bool with_stop = byte() % 2;
        const bool good =
            s->is.mode == INSTANTIATED && isfinite(start) && (!with_stop || stop > start);
        if (start > 1e6 || start < 0.0)
            return; /* steps would be lost in round-off, which do_step does not predict */
#if defined(FMI3)
        /* Good times go with the call that begins initialization. */
        if (!good)
            JUDGE(
                s, REFUSED, true,
                (fmi2Status)fmi3EnterInitializationMode(s->c, false, 0.0, start, with_stop, stop));
#else
        JUDGE(s, good ? ACCEPTED : REFUSED, true,
              fmi2SetupExperiment(s->c, fmi2False, 0.0, start, with_stop, stop));
#endif
        if (!good) return;
        s->is.time = start;
        s->is.stop = with_stop ? stop : INFINITY;
    } else if (what == 1) {
        JUDGE(s, when(s, INSTANTIATED), true, fmi2EnterInitializationMode(s->c));
        if (status == fmi2OK) s->is.mode = INITIALIZING;
    } else if (what == 2) {
        if (s->is.forged && !cheap(s->c, &table)) return;
        const bool open = s->is.mode == INITIALIZING;
        JUDGE(s, open ? EITHER : REFUSED, !open, fmi2ExitInitializationMode(s->c));
        if (status != fmi2OK) return;
        s->is.mode = STEPPING;
        s->is.looks_back = false; /* true unless a state was restored meanwhile: not judged before
                                     the first step */
    } else if (what == 3) {
        JUDGE(s, when(s, STEPPING), true, fmi2Terminate(s->c));
        if (status == fmi2OK) s->is.mode = TERMINATED;
    } else {
        JUDGE(s, when(s, ANY), true, fmi2Reset(s->c));
        if (status == fmi2OK) s->is = (model){INSTANTIATED, forgery != NULL, false, 0.0, INFINITY};
    }
}

void keep(slot *s, keeper *k)
{
    fmi2Status status;
    if (k->is.forged && !forgery) return;
    JUDGE(s, when(s, ANY), false, fmi2GetFMUstate(s->c, &k->state));
    if (status != fmi2OK) return;
    k->is = s->is;
    JUDGE(s, REFUSED, true, fmi2GetFMUstate(s->c, NULL));
}

void put_back(slot *s, keeper *k)
{
    fmi2Status status;
    if (k->is.forged && s->is.mode == GONE) return;
    verdict expected = k->is.forged ? EITHER : k->state && s->is.mode != GONE ? ACCEPTED : REFUSED;
    JUDGE(s, expected, true, fmi2SetFMUstate(s->c, k->state));
    if (status != fmi2OK) return;
    s->is = k->is;
}

void forget(slot *s, keeper *k)
{
    fmi2Status status;
    if (!s->c) return;
    JUDGE(s, ACCEPTED, true, fmi2FreeFMUstate(s->c, &k->state));
    REQUIRE(k->state == NULL);
    k->is.forged = false;
}

/* Through bytes: as they are, corrupted, or forged with a right checksum. */
void transport(slot *s, keeper *k)
{
    fmi2Status status;
    fmi2FMUstate copy = NULL;
    size_t size = 0;
    if (!s->c || !k->state || (k->is.forged && !forgery)) return;
    REQUIRE(fmi2SerializedFMUstateSize(s->c, k->state, &size) == fmi2OK);
    char *bytes = malloc(size);
    JUDGE(s, REFUSED, true, fmi2SerializeFMUstate(s->c, k->state, bytes, size - 1));
    JUDGE(s, ACCEPTED, true, fmi2SerializeFMUstate(s->c, k->state, bytes, size));
    const uint8_t how = byte() % 4;
    if (how == 1) size -= 1 + byte() % (size - 1);
    if (how >= 2) {
        for (int i = byte() % 4; i >= 0; i--) {
            size_t at = ((size_t)byte() * 256 + byte()) % size;
            if (byte() % 2) at %= 400; /* the head */
            bytes[at] ^= (char)(1 + byte() % 255);
        }
    }
    if (how == 3) {
        const uint64_t checksum = resource_file_checksum(bytes + 24, size - 24);
        memcpy(bytes + 16, &checksum, sizeof checksum);
    }
    verdict expected = how == 0 ? ACCEPTED : how == 3 ? EITHER : REFUSED;
    if (how == 2) expected = EITHER; /* two changes may cancel out */
    JUDGE(s, expected, true, fmi2DeSerializeFMUstate(s->c, bytes, size, &copy));
    free(bytes);
    if (status != fmi2OK) return;
    REQUIRE(fmi2FreeFMUstate(s->c, &k->state) == fmi2OK);
    k->state = copy;
    k->is.forged = how != 0 || forgery;
}
