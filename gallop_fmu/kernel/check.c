/* Checks of the arguments of exported functions, before they compute anything; none is in a loop
 * over time. */
#include "base_math.h"
#include "check.h"
#include "report.h"

#define MODEL_MAGIC 0x4c45444f4d4c4147ULL /* "GALMODEL" */
#define STATE_MAGIC 0x0032504f4c4c4147ULL /* "GALLOP2" */
#define FNV_START 1469598103934665603ULL
#define FNV_FACTOR 1099511628211ULL

/* The formulas round by adding a large number, and test for NaN and infinity: compilers and hosts
 * can spoil both. */
const char *gallop_arithmetic_fault(void)
{
    static const double number[4] = {0.75, 0.25, -0.75, -0.25}, rounded[4] = {1.0, 0.0, -1.0, 0.0};
    volatile double infinite = INFINITY;
    const double difference = infinite - infinite;
    for (int i = 0; i < 4; i++) {
        volatile double x = number[i];
        if (nearest(x) != rounded[i])
            return "the processor's rounding mode, which must be to nearest (or the library was "
                   "compiled with "
                   "-ffast-math or for an x87 processor)";
    }
    if (isfinite(infinite) || !isnan(difference))
        return "the library, which was compiled with -ffinite-math-only: compile it without";
    return NULL;
}

/* FNV-1a, over eight bytes at a time. */
static uint64_t mixed_with(uint64_t hash, const void *bytes, size_t size)
{
    for (size_t i = 0; i + sizeof hash <= size; i += sizeof hash) {
        uint64_t word;
        memcpy(&word, (const char *)bytes + i, sizeof word);
        hash = (hash ^ word) * FNV_FACTOR;
        hash ^= hash >> 32;
    }
    return hash;
}

/* A number that models of the same scene share, wherever they were made: of all tables. */
static uint64_t identity_of(const gallop_scene *s)
{
    const struct {
        const void *items;
        size_t count, size;
    } table[] = {{s->cross_section, (size_t)s->cross_section_count, sizeof *s->cross_section},
                 {s->curve, (size_t)s->curve_count, sizeof *s->curve},
                 {s->field, (size_t)s->field_count, sizeof *s->field},
                 {s->junction, (size_t)s->junction_count, sizeof *s->junction},
                 {s->chain, (size_t)s->chain_count, sizeof *s->chain},
                 {s->station, (size_t)s->station_count, sizeof *s->station},
                 {s->device, (size_t)s->device_count, sizeof *s->device},
                 {s->load, (size_t)s->load_count, sizeof *s->load},
                 {s->law, (size_t)s->law_count, sizeof *s->law},
                 {s->shedding, (size_t)s->shedding_count, sizeof *s->shedding},
                 {s->number, (size_t)s->number_count, sizeof *s->number}};
    uint64_t hash = mixed_with(FNV_START, &s->settings, sizeof s->settings);
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        const uint64_t count = table[i].count;
        hash = mixed_with(hash, &count, sizeof count);
        if (count) hash = mixed_with(hash, table[i].items, table[i].count * table[i].size);
    }
    return hash;
}

void check_mark_model(gallop_model *model)
{
    model->magic = MODEL_MAGIC;
    model->identity = identity_of(&model->scene);
}

void check_mark_state(const gallop_model *model, gallop_state *state)
{
    state->magic = STATE_MAGIC;
    state->size = model->saved_size;
    state->identity = model->identity;
}

bool check_is_model(const gallop_model *model)
{
    return base_pointer_usable(model, WORD) && model->magic == MODEL_MAGIC;
}

bool check_is_state_of(const gallop_model *model, const gallop_state *state)
{
    return base_pointer_usable(state, WORD) && state->magic == STATE_MAGIC &&
           state->size == model->saved_size && state->identity == model->identity;
}

bool check_is_started(const gallop_state *state)
{
    return base_pointer_usable(state, WORD) && state->magic == STATE_MAGIC;
}

bool check_finite(const double *values, size_t count)
{
    bool ok = true;
    for (size_t i = 0; i < count; i++) ok = ok && isfinite(values[i]);
    return ok;
}

/* Model and room for a state, whatever is in it. */
int check_room(const gallop_model *model, const gallop_state *state, double time,
               gallop_report *report)
{
    if (!report_start(report, time)) return GALLOP_BAD_CALL;
    if (!check_is_model(model)) return report_refused(report, NOT_USABLE(model), NAN, NAN);
    if (!base_pointer_usable(state, WORD))
        return report_refused(report, NOT_USABLE(state), NAN, NAN);
    const char *fault = gallop_arithmetic_fault();
    if (fault) return report_refused(report, fault, NAN, NAN);
    if (!isfinite(time)) return report_refused(report, "time, which must be finite", time, NAN);
    return GALLOP_COMPLETED;
}

/* A model and a state of it that was started; the report says what the state has behind it. */
int check_state(const gallop_model *model, const gallop_state *state, gallop_report *report)
{
    const int outcome = check_room(model, state, 0.0, report);
    if (outcome) return outcome;
    if (!check_is_state_of(model, state))
        return report_refused(report, "state, which was not started or belongs to another model",
                              NAN, NAN);
    report->time = state->time;
    state_report_work(state, report);
    return GALLOP_COMPLETED;
}

/* Values and rates of an array of inputs are finite from their time to `until`. */
static int check_linear(const double *values, size_t count, double duration, const char *not_finite,
                        gallop_report *report)
{
    for (size_t i = 0; i < 2 * count; i++)
        if (!isfinite(values[i])) return report_refused(report, not_finite, values[i], NAN);
    for (size_t i = 0; i < count; i++)
        if (!isfinite(values[i] + values[count + i] * duration))
            return report_refused(report, "inputs, whose rates lead to infinity", NAN, NAN);
    return GALLOP_COMPLETED;
}

static int check_input_arrays(const gallop_inputs *inputs, gallop_report *report)
{
    if (!base_pointer_usable(inputs->wind, WORD))
        return report_refused(
            report, "inputs.wind, a pointer that is null or not aligned to its type", NAN, NAN);
    if (inputs->direction && !base_pointer_usable(inputs->direction, WORD))
        return report_refused(report, "inputs.direction, a pointer that is not aligned to its type",
                              NAN, NAN);
    if (inputs->junctions && !base_pointer_usable(inputs->motion, WORD))
        return report_refused(
            report, "inputs.motion, a pointer that is null or not aligned to its type", NAN, NAN);
    return GALLOP_COMPLETED;
}

int check_inputs(const gallop_model *model, const gallop_inputs *inputs, double until,
                 gallop_report *report)
{
    if (!inputs) return GALLOP_COMPLETED;
    if (model->scene.settings.laws_only)
        return report_refused(report, "inputs, which a model of the laws only does not take", NAN,
                              NAN);
    if (!base_pointer_usable(inputs, WORD))
        return report_refused(report, NOT_USABLE(inputs), NAN, NAN);
    const int32_t fields = model->field_count, junctions = model->junction_count;
    if (inputs->fields != fields)
        return report_refused(report, "inputs.fields, which must be as many as the scene has",
                              inputs->fields, fields);
    if (inputs->junctions != junctions && inputs->junctions != 0)
        return report_refused(report,
                              "inputs.junctions, which must be 0 or as many as the scene has",
                              inputs->junctions, junctions);
    int outcome = check_input_arrays(inputs, report);
    if (outcome) return outcome;
    if (!isfinite(inputs->time))
        return report_refused(report, "inputs.time, which must be finite", inputs->time, NAN);
    if (!isfinite(inputs->attack_angle_rate))
        return report_refused(report, "inputs.attack_angle_rate, which must be finite",
                              inputs->attack_angle_rate, NAN);

    const double duration = until - inputs->time;
    const double attack[2] = {inputs->attack_angle, inputs->attack_angle_rate};
    outcome =
        check_linear(attack, 1, duration, "inputs.attack_angle, which must be finite", report);
    if (!outcome)
        outcome = check_linear(inputs->wind, (size_t)fields, duration,
                               "inputs.wind, which must be finite", report);
    if (!outcome && inputs->direction)
        outcome = check_linear(inputs->direction, (size_t)fields, duration,
                               "inputs.direction, which must be finite", report);
    if (!outcome)
        outcome = check_linear(inputs->motion, 3 * (size_t)inputs->junctions, duration,
                               "inputs.motion, which must be finite", report);
    return outcome;
}

static int check_probe(const gallop_model *model, const gallop_probe *p, gallop_report *report)
{
    const struct {
        int32_t indices, channels;
    } of[] = {[GALLOP_PROBE_NODE] = {model->nodes, GALLOP_NODE_CHANNELS},
              [GALLOP_PROBE_JUNCTION] = {model->junction_count, GALLOP_JUNCTION_CHANNELS},
              [GALLOP_PROBE_FIELD] = {model->field_count, GALLOP_FIELD_CHANNELS},
              [GALLOP_PROBE_SYSTEM] = {1, GALLOP_SYSTEM_CHANNELS},
              [GALLOP_PROBE_DEVICE] = {model->device_count, GALLOP_DEVICE_CHANNELS}};
    if (p->object < 0 || p->object > GALLOP_PROBE_DEVICE)
        return report_refused(report, "object of a probe", p->object, GALLOP_PROBE_DEVICE);
    if (p->index < 0 || p->index >= of[p->object].indices)
        return report_refused(report, "index of a probe", p->index, of[p->object].indices - 1);
    if (p->channel < 0 || p->channel >= of[p->object].channels)
        return report_refused(report, "channel of a probe", p->channel, of[p->object].channels - 1);
    if (!isfinite(p->station) || (p->station != 0.0 && p->object != GALLOP_PROBE_FIELD))
        return report_refused(report, "station of a probe", p->station, 0.0);
    return GALLOP_COMPLETED;
}

int check_probes(const gallop_model *model, const gallop_probe *probe, int32_t probes,
                 gallop_report *report)
{
    if (probes < 0) return report_refused(report, "number of probes", probes, 0.0);
    if (probes > 0 && !base_pointer_usable(probe, WORD))
        return report_refused(report, NOT_USABLE(probe), NAN, NAN);
    int outcome = GALLOP_COMPLETED;
    for (int32_t i = 0; i < probes && !outcome; i++)
        outcome = check_probe(model, &probe[i], report);
    return outcome;
}
