/* Fuzzing target: every exported function of gallop.h and gallop_analysis.h, with models, states,
 * reports, arrays, indices, counts and numbers that are right or wrong, as the input says.  Lengths
 * of arrays alone are always right: no callee can check them.
 *
 * Every call ends in a typed outcome and fills in its report; one that is refused changes no state;
 * what is computed is finite. */
#include "gallop_analysis.h"
#include "input.h"
#include "scene.h"

#include <stdbool.h>

#define MODELS 4
#define STATES 5
#define INDICES 8 /* of an array of indices */
#define RECORDS 3
#define WORDS 16384 /* room of any output */

static gallop_model *model[MODELS];
static gallop_state
    *state[STATES]; /* as many models have one, no longer than it needs, and one is blank */
static size_t size_of[STATES]; /* [bytes] */
static double room[WORDS], motion[3][WORDS];

static void clean_up(void)
{
    for (int i = 0; i < MODELS; i++) gallop_model_free(model[i]);
    for (int i = 0; i < STATES; i++) free(state[i]);
}

/* Models that differ in size, in a number, in what they compute, and in how they step. */
static void set_up(void)
{
    for (int i = 0; i < MODELS; i++) {
        gallop_scene scene;
        input nothing = {NULL, NULL};
        gallop_report report;
        scene_of(&nothing, &scene);
        chain.elements = i == 0 ? 2 : 4;
        chain.horizontal_tension = 0.0;
        scene.settings.laws_only = i == 2;
        scene.settings.integrator = i == 3 ? GALLOP_GAUSS6 : GALLOP_NEWMARK;
        scene.settings.tolerance = i == 3 ? 1e-3 : 0.0;
        REQUIRE(gallop_model_create(&scene, &model[i], &report) == GALLOP_COMPLETED);
        size_of[i] = gallop_state_size(model[i]);
    }
    size_of[STATES - 1] = size_of[1];
    for (int i = 0; i < STATES; i++) state[i] = malloc(size_of[i]);
    atexit(clean_up);
}

/* One of several pointers, or one that is wrong. */
static void *pointer_of(input *in, void *right)
{
    const uint8_t b = byte_of(in);
    if (b < 246) return right;
    return b < 250 ? NULL : (char *)right + (b % 2 ? 1 : 4);
}

static const gallop_model *model_from(input *in)
{
    static double junk[512];
    const uint8_t b = byte_of(in);
    return pointer_of(in, b < 240 ? (void *)model[b % MODELS] : junk);
}

static gallop_state *state_from(input *in)
{
    return pointer_of(in, state[byte_of(in) % STATES]);
}

/* A block that has room for a state of the model, whatever is in it. */
static gallop_state *room_from(input *in, const gallop_model *of)
{
    int i = byte_of(in) % STATES;
    while (size_of[i] < gallop_state_size(of)) i = (i + 1) % STATES;
    return pointer_of(in, state[i]);
}

static int32_t count_from(input *in)
{
    static const int32_t count[] = {0, 1, 2, INDICES, -1, INT32_MIN};
    return count[byte_of(in) % 6];
}

static int32_t index_from(input *in)
{
    static const int32_t odd[] = {-1, INT32_MIN, INT32_MAX, 9, 40, 99};
    const uint8_t b = byte_of(in);
    return b < 200 ? b % 9 : odd[b % 6];
}

static int64_t whole_from(input *in)
{
    static const int64_t whole[] = {
        0, 1, 2, RECORDS, -1, INT64_MIN, INT64_MAX, INT64_MAX / 2, 10000000000000};
    return whole[byte_of(in) % 9];
}

static gallop_inputs inputs_from(input *in)
{
    static double array[2 + 12]; /* wind, motion */
    gallop_inputs inputs = {.attack_angle = 3.14159, .fields = 1, .junctions = 2};
    memset(array, 0, sizeof array);
    array[0] = 5.5;
    for (uint8_t left = byte_of(in) % 4; left; left--) {
        double *const number[] = {&inputs.time, &inputs.attack_angle, &inputs.attack_angle_rate};
        const uint8_t which = byte_of(in) % 19;
        if (which < 17)
            *(which < 3 ? number[which] : &array[which - 3]) = number_of(in);
        else if (which == 17)
            inputs.fields = count_from(in);
        else
            inputs.junctions = count_from(in);
    }
    inputs.wind = pointer_of(in, array);
    inputs.motion = pointer_of(in, array + 2);
    return inputs;
}

/* A time that is soon reached from the state's, or one that must be refused. */
static double time_from(input *in, double now)
{
    const uint8_t b = byte_of(in);
    if (b < 160) return now + b / 2000.0;
    const double time = number_of(in);
    return isfinite(time) && fabs(time - now) < 1e11 ? now - 1.0 : time;
}

typedef struct {
    gallop_report report, *given;
    char *before;
    gallop_state *state;
} call;

/* Fills the report with what no call leaves in it, and remembers the state. */
static call begin(gallop_state *of)
{
    call c = {.state = of};
    memset(&c.report, 0xa5, sizeof c.report);
    for (int i = 0; i < STATES; i++)
        if (of == state[i]) c.before = memcpy(malloc(size_of[i]), of, size_of[i]);
    return c;
}

static void end(call *c, const void *given, int outcome)
{
    const gallop_report *r = &c->report;
    REQUIRE(outcome >= GALLOP_COMPLETED && outcome <= GALLOP_BAD_CALL);
    if (given == r) {
        REQUIRE(r->outcome == outcome && r->element >= -1 && r->element < 4);
        REQUIRE(r->steps >= 0 && r->substeps >= 0 && r->iterations >= 0 &&
                r->refactorisations >= 0);
        REQUIRE(r->halvings >= 0 && r->rejections >= 0 && !(r->largest_turn < 0.0));
        REQUIRE(outcome == GALLOP_BAD_CALL ? r->field != NULL : r->field == NULL);
    }
    for (int i = 0; i < STATES && outcome == GALLOP_BAD_CALL; i++)
        if (c->state == state[i]) REQUIRE(memcmp(c->before, c->state, size_of[i]) == 0);
    free(c->before);
}

static void start(input *in)
{
    const gallop_model *m = model_from(in);
    gallop_state *s = room_from(in, m);
    const gallop_inputs inputs = inputs_from(in);
    const void *at = byte_of(in) < 128 ? NULL : pointer_of(in, (void *)&inputs);
    const uint8_t which = byte_of(in);
    const double time = which < 200 ? 0.0 : number_of(in);
    call c = begin(s);
    gallop_report *report = pointer_of(in, &c.report);
    end(&c, report,
        which % 2 ? gallop_state_init(m, s, time, at, report)
                  : gallop_equilibrium(m, s, time, at, report));
}

static void advance(input *in)
{
    const gallop_model *m = model_from(in);
    gallop_state *s = state_from(in);
    const gallop_inputs inputs = inputs_from(in);
    const void *at = byte_of(in) < 128 ? NULL : pointer_of(in, (void *)&inputs);
    const double now = gallop_state_time(s), until = time_from(in, isnan(now) ? 0.0 : now);
    call c = begin(s);
    gallop_report *report = pointer_of(in, &c.report);
    end(&c, report, gallop_advance(m, s, at, until, report));
}

/* A probe that each model has, or one with a number that is wrong. */
static gallop_probe probe_from(input *in)
{
    static const int32_t indices[] = {5, 2, 1, 1};
    static const int32_t channels[] = {GALLOP_NODE_CHANNELS, GALLOP_JUNCTION_CHANNELS,
                                       GALLOP_FIELD_CHANNELS, GALLOP_SYSTEM_CHANNELS};
    const uint8_t b = byte_of(in), object = b % 4;
    gallop_probe p = {.object = object,
                      .index = byte_of(in) % indices[object],
                      .channel = byte_of(in) % channels[object]};
    int32_t *const number[] = {&p.object, &p.index, &p.channel};
    if (b >= 240) *number[b % 3] = index_from(in);
    if (b >= 250) p.station = number_of(in);
    return p;
}

static void run(input *in)
{
    gallop_probe list[INDICES];
    for (int i = 0; i < INDICES; i++) list[i] = probe_from(in);
    const gallop_model *m = model_from(in);
    gallop_state *s = state_from(in);
    const int64_t first = whole_from(in), records = whole_from(in), every = whole_from(in);
    const int32_t probes = count_from(in);
    const gallop_probe *probe = pointer_of(in, list);
    double *values = pointer_of(in, room);
    int64_t made = -1, *done = pointer_of(in, &made);
    call c = begin(s);
    gallop_report *report = pointer_of(in, &c.report);
    const int outcome =
        gallop_run(m, s, first, records, every, probe, probes, values, done, report);
    if (outcome == GALLOP_COMPLETED) REQUIRE(made == records && records <= RECORDS);
    if (outcome == GALLOP_BAD_CALL) REQUIRE(made == -1 || made == 0);
    for (int64_t i = 0; outcome == GALLOP_COMPLETED && i < records * probes; i++)
        REQUIRE(isfinite(values[i]));
    end(&c, report, outcome);
}

static void observe(input *in)
{
    const gallop_model *m = model_from(in);
    gallop_state *s = state_from(in);
    const uint8_t which = byte_of(in);
    gallop_probe list[INDICES];
    for (int i = 0; i < INDICES; i++) list[i] = probe_from(in);
    const int32_t probes = count_from(in);
    const gallop_probe *probe = pointer_of(in, list);
    double *values = pointer_of(in, room);
    const double sharpness = which < 100 ? 1.0 : number_of(in);
    call c = begin(s);
    int outcome = GALLOP_BAD_CALL;
    switch (which % 6) {
    case 0:
    case 1:
    case 2: outcome = gallop_observe(m, s, probe, probes, values); break;
    case 3: outcome = gallop_rewind(m, s, sharpness); break;
    case 4: outcome = gallop_state_check(m, s); break;
    default: gallop_state_time(s); break;
    }
    end(&c, NULL, outcome);
}

static void evaluate(input *in)
{
    const gallop_model *m = model_from(in);
    gallop_state *s = room_from(in, m);
    const gallop_inputs inputs = inputs_from(in);
    const void *at = byte_of(in) < 128 ? NULL : pointer_of(in, (void *)&inputs);
    for (int i = 0; i < 3; i++) {
        memset(motion[i], 0, 512);
        if (byte_of(in) > 128) motion[i][byte_of(in) % 64] = number_of(in);
    }
    const double *u = pointer_of(in, motion[0]), *v = pointer_of(in, motion[1]),
                 *a = pointer_of(in, motion[2]);
    double *out = pointer_of(in, room);
    const uint8_t which = byte_of(in);
    const double time = which < 128 ? 0.0 : number_of(in), k = which % 3 ? 1.0 : number_of(in);
    call c = begin(s);
    end(&c, NULL,
        which % 2 ? gallop_residual(m, s, time, at, u, v, a, out)
                  : gallop_tangent(m, s, time, at, u, v, a, k, 1.0, 1.0, out));
}

static void ask(input *in)
{
    const gallop_model *m = model_from(in);
    const bool right = m == model[0] || m == model[1] || m == model[2] || m == model[3];
    REQUIRE((gallop_state_size(m) > 0) == right && (gallop_saved_size(m) > 0) == right);
    REQUIRE((gallop_middle(m) > 0) == right);
    void *out = pointer_of(in, room);
    const int derived = gallop_model_derived(m, out), nodes = gallop_model_nodes(m, out);
    REQUIRE(derived == (right && out == room ? GALLOP_COMPLETED : GALLOP_BAD_CALL) &&
            nodes == derived);
    const char *names[2];
    size_t places[2];
    gallop_structure_field(number_of(in) > 0.0 ? 1 : -1, pointer_of(in, &names[0]),
                           pointer_of(in, &names[1]), pointer_of(in, &places[0]),
                           pointer_of(in, &places[1]));
}

static void create(input *in)
{
    gallop_scene scene;
    input nothing = {NULL, NULL};
    gallop_model *made = NULL;
    scene_of(&nothing, &scene);
    chain.horizontal_tension = 0.0;
    scene.load_count = byte_of(in) % 2;
    scene.load = pointer_of(in, load);
    scene.curve = pointer_of(in, &curve);
    scene.junction = pointer_of(in, junction);
    scene.number = pointer_of(in, number);
    call c = begin(NULL);
    gallop_report *report = pointer_of(in, &c.report);
    gallop_model **to = pointer_of(in, &made);
    const int outcome = gallop_model_create(pointer_of(in, &scene), to, report);
    REQUIRE((outcome == GALLOP_COMPLETED) == (made != NULL));
    if (outcome != GALLOP_INVALID_SCENE) end(&c, report, outcome);
    gallop_model_free(made);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (!model[0]) set_up();
    input in = {data, data + size};
    for (int i = 0; i < STATES; i++) memset(state[i], 0, size_of[i]);
    for (int i = 0; i < MODELS; i++) {
        gallop_report report;
        REQUIRE(gallop_state_init(model[i], state[i], 0.0, NULL, &report) == GALLOP_COMPLETED);
    }
    for (int calls = 0; calls < 40 && in.next < in.last; calls++) {
        static void (*const act[])(input *) = {start,   advance, advance,  run, run,
                                               observe, observe, evaluate, ask, create};
        act[byte_of(&in) % 10](&in);
    }
    return 0;
}
