/* Shared by the files of the sequence fuzzer: the model of an instance that calls are checked by,
 * and the bytes. */
#ifndef FUZZING_SEQUENCE_H
#define FUZZING_SEQUENCE_H

#if defined(FMI3)
#include "as_fmi3.h"
#else
#include "instance.h"
#endif

#define SLOTS 4
#define MOST 3 /* variables in one call */

typedef enum { GONE = 0, INSTANTIATED = 1, INITIALIZING = 2, STEPPING = 4, TERMINATED = 8 } mode;
enum { SETTABLE = INSTANTIATED | INITIALIZING | STEPPING, ANY = SETTABLE | TERMINATED };
typedef enum { REFUSED, ACCEPTED, EITHER } verdict;

/* What the standard says about an instance or a saved state. */
typedef struct {
    mode mode;
    bool forged;     /* holds a forged state: anything may be accepted, but nothing may break */
    bool looks_back; /* a step, or the initial state, that derivatives can be taken of */
    double time, stop;
} model;

typedef struct {
    fmi2Component c;
    model is;
} slot;
typedef struct {
    fmi2FMUstate state;
    model is;
} keeper;

/* sequence.c */
extern const char *resources, *guid, *forgery;
extern resource table;
extern long calls, messages;
uint8_t byte(void);

/* sequence_judge.c */
extern const fmi2CallbackFunctions with, silent;
char *image(fmi2Component c, size_t *size);
void judge(const slot *s, verdict expected, fmi2Status status, long said, const char *call);
verdict when(const slot *s, int modes);
double number(void);
const resource_variable *variable(fmi2ValueReference r);
fmi2ValueReference reference(void);

/* sequence_values.c */
void set_values(slot *s, bool whole);
void get_values(slot *s, bool whole);
void derive(slot *s, uint8_t what);

/* sequence_others.c */
void others(slot *s, uint8_t what);

/* sequence_life.c */
void instantiate(slot *s);
void release(slot *s);
void move_on(slot *s, uint8_t what);
void do_step(slot *s);
void keep(slot *s, keeper *k);
void put_back(slot *s, keeper *k);
void forget(slot *s, keeper *k);
void transport(slot *s, keeper *k);

/* Judges a call.  `steady`: what is refused leaves no trace. */
#define JUDGE(s, expected, steady, call)                                                           \
    do {                                                                                           \
        size_t before_size = 0, after_size = 0;                                                    \
        char *before = (steady) ? image((s)->c, &before_size) : NULL;                              \
        long said = messages;                                                                      \
        status = (call);                                                                           \
        calls++;                                                                                   \
        judge((s), (expected), status, said, #call);                                               \
        if (before && status != fmi2OK) {                                                          \
            char *after = image((s)->c, &after_size);                                              \
            REQUIRE(before_size == after_size && memcmp(before, after, after_size) == 0);          \
            free(after);                                                                           \
        }                                                                                          \
        free(before);                                                                              \
    } while (0)

#endif
