/* Cost of the FMI layer: times the functions of a native FMU's library and the kernel's own
 * in the same library. Compiled and called by fmu_cost.py. */
#include <dlfcn.h>
#include <fmi2FunctionTypes.h>
#include <gallop.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define STEP 0.01
#define SETTLE 2000 /* steps before the clock is read */
#define STEPS 4000
#define SAVES 20000
#define INSTANCES 4

typedef struct {
    double advance, step, save_restore,
        copy;                         /* [us]; copy: two copies of the kernel's state by memcpy */
    double first_step;                /* [ms] from fmi2Instantiate to the end of the first step */
    double one_thread, two_threads;   /* [ms] for the same instances */
    double one_counter, two_counters; /* [ms] for mere arithmetic: what the machine has to give */
    double state_bytes;
} costs;

#define FUNCTIONS(of)                                                                              \
    of(Instantiate) of(FreeInstance) of(SetupExperiment) of(EnterInitializationMode)               \
        of(ExitInitializationMode) of(DoStep) of(GetFMUstate) of(SetFMUstate) of(FreeFMUstate)
#define DECLARE(name) static fmi2##name##TYPE *name;
FUNCTIONS(DECLARE)

static const char *resources, *guid;

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static fmi2Component start(void)
{
    static const fmi2CallbackFunctions call = {NULL, calloc, free, NULL, NULL};
    fmi2Component c =
        Instantiate("span", fmi2CoSimulation, guid, resources, &call, fmi2False, fmi2False);
    if (!c) return NULL;
    SetupExperiment(c, fmi2False, 0.0, 0.0, fmi2False, 0.0);
    EnterInitializationMode(c);
    ExitInitializationMode(c);
    return c;
}

static int run(fmi2Component c, int first, int count)
{
    int failed = 0;
    for (int k = first; k < first + count; k++)
        failed |= DoStep(c, k * STEP, STEP, fmi2True) != fmi2OK;
    return failed;
}

static void *half(void *instances)
{
    for (int i = 0; i < INSTANCES / 2; i++) run(((fmi2Component *)instances)[i], 0, STEPS);
    return NULL;
}

static void time_threads(costs *r)
{
    for (int threads = 1; threads <= 2; threads++) {
        fmi2Component c[INSTANCES];
        pthread_t other;
        for (int i = 0; i < INSTANCES; i++) c[i] = start();
        double began = now();
        if (threads == 2) pthread_create(&other, NULL, half, c + INSTANCES / 2);
        half(c);
        if (threads == 2)
            pthread_join(other, NULL);
        else
            half(c + INSTANCES / 2);
        *(threads == 1 ? &r->one_thread : &r->two_threads) = 1e3 * (now() - began);
        for (int i = 0; i < INSTANCES; i++) FreeInstance(c[i]);
    }
}

static void *count(void *given)
{
    volatile double *x = given; /* volatile, or the compiler leaves the work out */
    for (int i = 0; i < 5000000; i++) *x = *x * 0.999999 + 1e-6;
    return NULL;
}

static void time_machine(costs *r)
{
    pthread_t other;
    static double sum[64];
    double began = now();
    count(&sum[0]), count(&sum[32]); /* apart, in lines of the cache of their own */
    r->one_counter = 1e3 * (now() - began);
    began = now();
    pthread_create(&other, NULL, count, &sum[0]);
    count(&sum[32]);
    pthread_join(other, NULL);
    r->two_counters = 1e3 * (now() - began);
}

/* Returns 0, or the number of what failed. */
int fmu_costs(const char *library_path, const char *resource_location, const char *id,
              const gallop_scene *scene, costs *r)
{
    void *library = dlopen(library_path, RTLD_NOW | RTLD_LOCAL);
    if (!library) return 1;
#define LOAD(name)                                                                                 \
    if (!(*(void **)&name = dlsym(library, "fmi2" #name))) return 2;
    FUNCTIONS(LOAD)
    __typeof__(gallop_model_create) *create;
    __typeof__(gallop_advance) *advance;
    __typeof__(gallop_state_size) *state_size, *saved_size;
    __typeof__(gallop_state_init) *init;
    __typeof__(gallop_model_free) *release;
    *(void **)&create = dlsym(library, "gallop_model_create");
    *(void **)&advance = dlsym(library, "gallop_advance");
    *(void **)&state_size = dlsym(library, "gallop_state_size");
    *(void **)&saved_size = dlsym(library, "gallop_saved_size");
    *(void **)&init = dlsym(library, "gallop_state_init");
    *(void **)&release = dlsym(library, "gallop_model_free");
    resources = resource_location;
    guid = id;

    double began = now();
    fmi2Component c = start();
    if (!c || run(c, 0, 1)) return 3;
    r->first_step = 1e3 * (now() - began);

    gallop_model *model;
    gallop_report report;
    const double wind[2] = {scene->law[scene->field[0].law].initial, 0.0};
    gallop_inputs in = {
        .attack_angle = scene->cross_section[0].attack_angle, .fields = 1, .wind = wind};
    if (create(scene, &model, &report)) return 4;
    gallop_state *state = malloc(state_size(model)), *copy = malloc(state_size(model));
    if (init(model, state, 0.0, &in, &report)) return 5;
    for (int k = 0; k < SETTLE; k++) advance(model, state, &in, (k + 1) * STEP, &report);
    if (run(c, 1, SETTLE - 1)) return 6;
    r->step = r->advance = 0.0;
    for (int part = 0; part < 40; part++) { /* by turns, so that both see the same machine */
        const int first = SETTLE + part * STEPS / 40, count = STEPS / 40;
        began = now();
        for (int k = first; k < first + count; k++) {
            in.time = k * STEP;
            if (advance(model, state, &in, k * STEP + STEP, &report)) return 7;
        }
        double between = now();
        if (run(c, first, count)) return 8;
        r->advance += 1e6 * (between - began) / STEPS;
        r->step += 1e6 * (now() - between) / STEPS;
    }

    fmi2FMUstate saved = NULL;
    began = now();
    for (int i = 0; i < SAVES; i++)
        if (GetFMUstate(c, &saved) != fmi2OK || SetFMUstate(c, saved) != fmi2OK) return 9;
    r->save_restore = 1e6 * (now() - began) / SAVES;
    FreeFMUstate(c, &saved);
    FreeInstance(c);
    r->state_bytes = (double)saved_size(model);
    began = now();
    for (int i = 0; i < SAVES; i++) {
        memcpy(copy, state, saved_size(model));
        __asm__ volatile("" : : "r"(copy) : "memory");
        memcpy(state, copy, saved_size(model));
        __asm__ volatile("" : : "r"(state) : "memory");
    }
    r->copy = 1e6 * (now() - began) / SAVES;
    free(state), free(copy);
    release(model);
    time_threads(r);
    time_machine(r);
    return 0;
}
