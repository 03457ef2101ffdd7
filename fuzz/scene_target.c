/* Fuzzing target: gallop_model_create and a few steps on a scene from the input, by every
 * integrator; then the saved state, changed as the input says, checked and stepped on from.  Every
 * call must end in a typed outcome, and a completed one in finite numbers. */
#include "scene.h"

#include <stdbool.h>

#define RECORDS 3

static void require_finite(const double *values, size_t count)
{
    for (size_t i = 0; i < count; i++) REQUIRE(isfinite(values[i]));
}

/* Inputs of a host, mostly calm ones. */
static gallop_inputs inputs_of(input *in, double time)
{
    static double wind[2], direction[2], motion[2][2][3];
    gallop_inputs inputs = {.time = time,
                            .attack_angle = 3.14159,
                            .fields = 1,
                            .junctions = 2,
                            .wind = wind,
                            .motion = &motion[0][0][0]};
    double *number[] = {&inputs.time,
                        &wind[0],
                        &inputs.attack_angle,
                        &wind[1],
                        &inputs.attack_angle_rate,
                        &motion[0][0][1],
                        &motion[0][1][2],
                        &motion[1][0][0],
                        &motion[1][1][1]};
    memset(motion, 0, sizeof motion);
    wind[0] = 5.5;
    wind[1] = 0.0;
    for (size_t i = 0; i < sizeof number / sizeof *number; i++) change(in, number[i]);
    if (byte_of(in) >= 128) inputs.direction = direction;
    for (int i = 0; i < 2; i++) {
        direction[i] = 0.5 - i;
        change(in, &direction[i]);
    }
    return inputs;
}

/* Foreign bytes are refused or stepped on from; a failure leaves the state unchanged.
 */
static void go_on_from_elsewhere(const gallop_model *model, gallop_state *state, double step,
                                 input *in)
{
    gallop_report report;
    const size_t size = gallop_saved_size(model);
    const bool hosted = byte_of(in) < 128;
    const gallop_inputs inputs = inputs_of(in, gallop_state_time(state));
    edit(in, (char *)state, size);
    if (gallop_state_check(model, state) != GALLOP_COMPLETED) return;
    char *before = malloc(size);
    memcpy(before, state, size);
    const double until = gallop_state_time(state) + 2.0 * step;
    const int outcome = gallop_advance(model, state, hosted ? &inputs : NULL, until, &report);
    REQUIRE(outcome == report.outcome && outcome >= GALLOP_COMPLETED && outcome <= GALLOP_BAD_CALL);
    if (outcome)
        REQUIRE(memcmp(before, state, size) == 0);
    else
        REQUIRE(gallop_state_check(model, state) == GALLOP_COMPLETED);
    free(before);
}

/* Every quantity of two nodes, of both junctions, of the first field and of the system. */
enum {
    OF_NODES = 2 * GALLOP_NODE_CHANNELS,
    OF_JUNCTIONS = 2 * GALLOP_JUNCTION_CHANNELS,
    PROBES = OF_NODES + OF_JUNCTIONS + GALLOP_FIELD_CHANNELS + GALLOP_SYSTEM_CHANNELS
};

static void list_probes(int32_t middle, gallop_probe probe[PROBES])
{
    const struct {
        int32_t object, index, channels;
    } of[] = {{GALLOP_PROBE_NODE, middle, GALLOP_NODE_CHANNELS},
              {GALLOP_PROBE_NODE, 2 * middle, GALLOP_NODE_CHANNELS},
              {GALLOP_PROBE_JUNCTION, 0, GALLOP_JUNCTION_CHANNELS},
              {GALLOP_PROBE_JUNCTION, 1, GALLOP_JUNCTION_CHANNELS},
              {GALLOP_PROBE_FIELD, 0, GALLOP_FIELD_CHANNELS},
              {GALLOP_PROBE_SYSTEM, 0, GALLOP_SYSTEM_CHANNELS}};
    for (size_t i = 0, at = 0; i < sizeof of / sizeof *of; i++)
        for (int32_t k = 0; k < of[i].channels; k++)
            probe[at++] =
                (gallop_probe){.object = of[i].object, .index = of[i].index, .channel = k};
}

static void run(const gallop_model *model, double step, input *in)
{
    gallop_report report;
    gallop_derived derived;
    gallop_model_derived(model, &derived);
    gallop_state *state = calloc(1, gallop_state_size(model));
    int outcome = gallop_state_init(model, state, 0.0, NULL, &report);
    REQUIRE(outcome == report.outcome && outcome >= GALLOP_COMPLETED && outcome <= GALLOP_BAD_CALL);
    if (!outcome) {
        gallop_probe probe[PROBES];
        double values[RECORDS * PROBES];
        int64_t done;
        list_probes(gallop_middle(model), probe);
        REQUIRE(gallop_state_check(model, state) == GALLOP_COMPLETED);
        outcome = gallop_run(model, state, 0, RECORDS, 1, probe, PROBES, values, &done, &report);
        REQUIRE(outcome == report.outcome && outcome >= GALLOP_COMPLETED &&
                outcome <= GALLOP_BAD_CALL);
        REQUIRE(done >= 0 && done <= RECORDS && (done == RECORDS) == (outcome == GALLOP_COMPLETED));
        for (int64_t i = 0; i < done * PROBES; i++) /* displacements and velocities */
            if (i % PROBES < OF_NODES && i % GALLOP_NODE_CHANNELS <= GALLOP_OMEGA)
                REQUIRE(isfinite(values[i]));
        REQUIRE(gallop_state_check(model, state) == GALLOP_COMPLETED);
        if (in->next < in->last) go_on_from_elsewhere(model, state, step, in);
    }
    free(state);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    gallop_scene scene;
    input in = {data, data + size};
    gallop_model *model = model_of(&in, &scene);
    if (!model) return 0;
    double x[3 * (2 * MOST + 1)];
    REQUIRE(chain.elements <= MOST);
    gallop_model_nodes(model, x);
    require_finite(x, 3 * (2 * (size_t)chain.elements + 1));
    /* Skip records further apart than a scene may ask for, where steps are as short as a
     * tolerance wants. */
    const bool endless = scene.settings.tolerance > 0.0 && scene.settings.time_step > 1.0;
    if (byte_of(&in) < 64 && !endless) run(model, scene.settings.time_step, &in);
    gallop_model_free(model);
    return 0;
}
