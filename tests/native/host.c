/* A host of our own: loads an FMU's library and uses it as a master would, without a line of
 * Python.
 *
 *     host run     LIBRARY RESOURCES GUID STEPS REFERENCE...   every output after every step, as
 * hexadecimal numbers host threads LIBRARY RESOURCES GUID STEPS REFERENCE...   instances side by
 * side give what they give alone host states  LIBRARY RESOURCES GUID STEPS REFERENCE...   rollback
 * and restoring elsewhere repeat every bit host save    LIBRARY RESOURCES GUID STEPS FILE the state
 * after so many steps host resume  LIBRARY RESOURCES GUID STEPS FILE REFERENCE...   as run, from a
 * saved state on
 */
#include <dlfcn.h>
#include <fmi2FunctionTypes.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define STEP 0.01
#define MOST 32
#define INSTANCES 4
enum { WIND, ATTACK }; /* value references of the inputs */

#define FUNCTIONS(of)                                                                              \
    of(Instantiate) of(FreeInstance) of(SetupExperiment) of(EnterInitializationMode)               \
        of(ExitInitializationMode) of(SetReal) of(GetReal) of(DoStep) of(GetFMUstate)              \
            of(SetFMUstate) of(FreeFMUstate) of(SerializedFMUstateSize) of(SerializeFMUstate)      \
                of(DeSerializeFMUstate) of(Terminate)
#define DECLARE(name) static fmi2##name##TYPE *name;
FUNCTIONS(DECLARE)

static const char *resources, *guid;
static fmi2ValueReference reference[MOST];
static size_t references;
static int steps;

static void check(int ok, const char *what)
{
    if (ok) return;
    fprintf(stderr, "failed: %s\n", what);
    exit(1);
}
#define OK(call) check((call) == fmi2OK, #call)

static void log_to_stderr(void *environment, fmi2String instance, fmi2Status status,
                          fmi2String category, fmi2String format, ...)
{
    va_list arguments;
    (void)environment;
    fprintf(stderr, "%s %d %s: ", instance, status, category);
    va_start(arguments, format);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fputc('\n', stderr);
}

static fmi2Component start(double wind)
{
    static const fmi2CallbackFunctions call = {log_to_stderr, calloc, free, NULL, NULL};
    const fmi2ValueReference where = WIND;
    fmi2Component c =
        Instantiate("span", fmi2CoSimulation, guid, resources, &call, fmi2False, fmi2False);
    check(c != NULL, "Instantiate");
    OK(SetupExperiment(c, fmi2False, 0.0, 0.0, fmi2False, 0.0));
    OK(EnterInitializationMode(c));
    OK(SetReal(c, &where, 1, &wind));
    OK(ExitInitializationMode(c));
    return c;
}

static void stop(fmi2Component c)
{
    OK(Terminate(c));
    FreeInstance(c);
}

/* Steps first + 1 to last; the outputs after each into rows, unless that is NULL. */
static void advance(fmi2Component c, int first, int last, double *rows)
{
    for (int k = first; k < last; k++) {
        OK(DoStep(c, k * STEP, STEP, fmi2True));
        if (rows) OK(GetReal(c, reference, references, rows + (size_t)(k - first) * references));
    }
}

static double *new_rows(void)
{
    return calloc((size_t)steps * references, sizeof(double));
}

static int equal(const double *a, const double *b, int count)
{
    return memcmp(a, b, (size_t)count * references * sizeof(double)) == 0;
}

static void print(const double *rows)
{
    for (int k = 0; k < steps; k++)
        for (size_t i = 0; i < references; i++)
            printf("%a%c", rows[(size_t)k * references + i], i + 1 < references ? ' ' : '\n');
}

static void run(fmi2Component c, int first)
{
    double *rows = new_rows();
    advance(c, first, first + steps, rows);
    print(rows);
    free(rows);
    stop(c);
}

typedef struct {
    double wind, *rows;
} task;

static void *work(void *given)
{
    task *t = given;
    for (int repeat = 0; repeat < 3; repeat++) {
        fmi2Component c = start(t->wind);
        advance(c, 0, steps, t->rows);
        stop(c);
    }
    return NULL;
}

static void threads(void)
{
    pthread_t thread[INSTANCES];
    task alone[INSTANCES], together[INSTANCES];
    for (int i = 0; i < INSTANCES; i++) {
        alone[i] = (task){4.0 + i / 2, new_rows()}; /* two of each kind */
        together[i] = (task){alone[i].wind, new_rows()};
        work(&alone[i]);
    }
    for (int i = 0; i < INSTANCES; i++)
        check(!pthread_create(&thread[i], NULL, work, &together[i]), "thread");
    for (int i = 0; i < INSTANCES; i++) pthread_join(thread[i], NULL);
    for (int i = 0; i < INSTANCES; i++)
        check(equal(alone[i].rows, together[i].rows, steps), "threads differ");
    check(!equal(alone[0].rows, alone[2].rows, steps), "two wind speeds give the same");
    for (int i = 0; i < INSTANCES; i++) free(alone[i].rows), free(together[i].rows);
}

/* A step that fails: the wind comes from behind, outside of the coefficients' range. */
static void fail(fmi2Component c, int k, double attack)
{
    const fmi2ValueReference where = ATTACK;
    const double behind = 0.0;
    OK(SetReal(c, &where, 1, &behind));
    check(DoStep(c, k * STEP, STEP, fmi2True) == fmi2Error,
          "a step beyond the coefficients was made");
    OK(SetReal(c, &where, 1, &attack));
}

static void states(void)
{
    const int saves[] = {0, 1, steps / 3, steps - 1};
    double *wanted = new_rows(), *found = new_rows(), attack;
    const fmi2ValueReference where = ATTACK;
    fmi2Component plain = start(5.5);
    OK(GetReal(plain, &where, 1, &attack));
    advance(plain, 0, steps, wanted);
    for (size_t i = 0; i < sizeof saves / sizeof *saves; i++) {
        const int k = saves[i], rest = steps - k;
        const double *expected = wanted + (size_t)k * references;
        fmi2FMUstate state = NULL;
        fmi2Component c = start(5.5), other = start(9.0), failed;
        advance(c, 0, k, NULL);
        OK(GetFMUstate(c, &state));
        advance(c, k, steps, found);
        check(equal(found, expected, rest), "saving disturbs");
        OK(SetFMUstate(c, state));
        advance(c, k, steps, found);
        check(equal(found, expected, rest), "rollback");
        OK(SetFMUstate(c, state));
        fail(c, k, attack);
        advance(c, k, steps, found);
        check(equal(found, expected, rest), "going on after a failed step");
        OK(SetFMUstate(c, state));
        fail(c, k, attack);
        OK(SetFMUstate(c, state));
        advance(c, k, steps, found);
        check(equal(found, expected, rest), "rollback after a failed step");
        advance(other, 0, 7, NULL);
        OK(SetFMUstate(other, state));
        advance(other, k, steps, found);
        check(equal(found, expected, rest), "restoring into a running instance");
        failed = start(9.0);
        fail(failed, 0, attack);
        OK(SetFMUstate(failed, state));
        advance(failed, k, steps, found);
        check(equal(found, expected, rest), "restoring into an instance that failed");
        OK(FreeFMUstate(c, &state));
        check(state == NULL, "FreeFMUstate");
        stop(c), stop(other), stop(failed);
    }
    stop(plain);
    free(wanted), free(found);
}

static void save(const char *name)
{
    fmi2FMUstate state = NULL;
    fmi2Component c = start(5.5);
    size_t size;
    FILE *file = fopen(name, "wb");
    advance(c, 0, steps, NULL);
    OK(GetFMUstate(c, &state));
    OK(SerializedFMUstateSize(c, state, &size));
    char *bytes = malloc(size);
    OK(SerializeFMUstate(c, state, bytes, size));
    check(file && fwrite(bytes, 1, size, file) == size && fclose(file) == 0, "writing");
    OK(FreeFMUstate(c, &state));
    free(bytes);
    stop(c);
}

/* The file says after how many steps it was saved: its name is FILE.<steps>. */
static void resume(const char *name)
{
    static char bytes[1 << 22];
    fmi2FMUstate state = NULL;
    fmi2Component c = start(9.0);
    FILE *file = fopen(name, "rb");
    check(file != NULL, "opening");
    size_t size = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    OK(DeSerializeFMUstate(c, bytes, size, &state));
    OK(SetFMUstate(c, state));
    OK(FreeFMUstate(c, &state));
    run(c, atoi(strrchr(name, '.') + 1));
}

int main(int count, char **argument)
{
    check(count >= 6, "arguments");
    const char *what = argument[1];
    const int with_file = !strcmp(what, "save") || !strcmp(what, "resume");
    void *library = dlopen(argument[2], RTLD_NOW | RTLD_LOCAL);
    check(library != NULL, dlerror());
#define LOAD(name) check((*(void **)&name = dlsym(library, "fmi2" #name)) != NULL, #name);
    FUNCTIONS(LOAD)
    resources = argument[3];
    guid = argument[4];
    steps = atoi(argument[5]);
    for (int i = 6 + with_file; i < count && references < MOST; i++)
        reference[references++] = (fmi2ValueReference)atoi(argument[i]);
    if (!strcmp(what, "run"))
        run(start(5.5), 0);
    else if (!strcmp(what, "threads"))
        threads();
    else if (!strcmp(what, "states"))
        states();
    else if (!strcmp(what, "save"))
        save(argument[6]);
    else if (!strcmp(what, "resume"))
        resume(argument[6]);
    else
        check(0, "unknown command");
    return 0;
}
