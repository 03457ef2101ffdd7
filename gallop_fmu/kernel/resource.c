/* Reads resources/model.bin.  Every field is validated, even if the checksum matches. */
#include "resource.h"

#include "check.h"
#include "device.h"
#include "law.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MANY 10000000

#define SECTION(id, type, min_count, max_count)                                                    \
    {id, sizeof(type), min_count, max_count,                                                       \
     "resources/model.bin has no section " id "; export the scene again"}

/* The table of sections.  A parameter may be in those of the scene only. */
static const resource_kind known_sections[RESOURCE_SECTIONS] = {
    [RESOURCE_IDENTITY] = SECTION("IDEN", resource_identification, 1, 1),
    [RESOURCE_SETTINGS] = SECTION("SETT", gallop_settings, 1, 1),
    [RESOURCE_CROSS_SECTIONS] = SECTION("SECT", gallop_cross_section, 1, MANY),
    [RESOURCE_CURVES] = SECTION("CURV", gallop_curve, 0, MANY),
    [RESOURCE_FIELDS] = SECTION("FIEL", gallop_field, 1, MANY),
    [RESOURCE_JUNCTIONS] = SECTION("JUNC", gallop_junction, 2, MANY),
    [RESOURCE_CHAINS] = SECTION("CHAI", gallop_chain, 1, MANY),
    [RESOURCE_STATIONS] = SECTION("STAT", gallop_station, 0, MANY),
    [RESOURCE_DEVICES] = SECTION("DEVI", gallop_device, 0, MANY),
    [RESOURCE_LOADS] = SECTION("LOAD", gallop_load, 0, MANY),
    [RESOURCE_LAWS] = SECTION("LAWS", gallop_law, 0, MANY),
    [RESOURCE_SHEDDINGS] = SECTION("SHED", gallop_shedding, 0, MANY),
    [RESOURCE_NUMBERS] = SECTION("NUMB", double, 0, MANY),
    [RESOURCE_VARIABLES] = SECTION("VARS", resource_variable, 1, MANY),
    [RESOURCE_PLACES] = SECTION("PLCS", resource_also, 0, MANY),
    [RESOURCE_TARGETS] = SECTION("INPT", resource_target, 1, MANY),
    [RESOURCE_TERMS] = SECTION("TERM", resource_term, 0, MANY),
    [RESOURCE_LABELS] = SECTION("NAME", resource_label, 0, MANY),
    [RESOURCE_OUTCOMES] = SECTION("OUTC", resource_outcome, 0, MANY),
};

static bool holds_parameters(int section)
{
    return section >= RESOURCE_SETTINGS && section <= RESOURCE_NUMBERS;
}

static bool is_terminated(const char *text, size_t room)
{
    return memchr(text, 0, room) != NULL;
}

static char *place_in(const resource *r, const char id[4], uint32_t index, uint32_t field,
                      bool whole)
{
    const size_t width = whole ? sizeof(int32_t) : sizeof(double);
    for (int i = 0; i < RESOURCE_SECTIONS; i++) {
        const resource_section *s = &r->section[i];
        if (!holds_parameters(i) || memcmp(id, known_sections[i].id, 4) != 0) continue;
        if (index >= s->count || field % width || field > s->item_size - width) return NULL;
        return s->items + (size_t)index * s->item_size + field;
    }
    return NULL;
}

char *resource_place(const resource *r, const resource_variable *v)
{
    return place_in(r, v->section, v->index, v->field, v->whole);
}

static const resource_also *also_of(const resource *r)
{
    return (const resource_also *)r->section[RESOURCE_PLACES].items;
}

static void store_at(char *at, bool whole, double stored)
{
    if (whole)
        *(int32_t *)at = (int32_t)stored;
    else
        *(double *)at = stored;
}

void resource_store(const resource *r, const resource_variable *v, double stored)
{
    const uint32_t variable = (uint32_t)(v - resource_variables(r));
    const resource_also *also = also_of(r);
    store_at(resource_place(r, v), v->whole, stored);
    for (uint32_t i = 0; i < r->section[RESOURCE_PLACES].count; i++)
        if (also[i].variable == variable)
            store_at(place_in(r, also[i].section, also[i].index, also[i].field, v->whole), v->whole,
                     stored);
}

uint32_t resource_input_count(const resource *r)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < r->section[RESOURCE_TARGETS].count; i++)
        if (resource_targets(r)[i].input >= count) count = resource_targets(r)[i].input + 1;
    return count;
}

const resource_target *resource_first_target(const resource *r, uint32_t input)
{
    const resource_target *t = resource_targets(r);
    while (t->input != input) t++;
    return t;
}

int32_t resource_velocity_input(const resource *r, uint32_t input)
{
    const resource_target *of = resource_first_target(r, input), *t = resource_targets(r);
    if (of->kind != RESOURCE_MOTION) return -1;
    for (uint32_t i = 0; i < r->section[RESOURCE_TARGETS].count; i++)
        if (t[i].kind == RESOURCE_VELOCITY && t[i].index == of->index && t[i].axis == of->axis)
            return (int32_t)t[i].input;
    return -1;
}

/* A whole number has the factor 1: another one could make it too large for its 32 bits. */
static bool has_possible_factor(const resource_variable *v)
{
    return v->whole ? v->factor == 1.0 : isfinite(v->factor) && v->factor > 0.0;
}

static bool has_possible_bounds(const resource_variable *v)
{
    return v->excluded <= (RESOURCE_MINIMUM_EXCLUDED | RESOURCE_MAXIMUM_EXCLUDED) &&
           !isnan(v->minimum) && !isnan(v->maximum);
}

static const char *const unknown_variable =
    "resources/model.bin is damaged: a variable is unknown; export the scene again";
static const char *const no_place =
    "resources/model.bin is damaged: a parameter has no place; export the scene again";

/* The number of an input, or the terms of an output. */
static bool refers_to_what_there_is(const resource *r, uint32_t inputs, const resource_variable *v)
{
    const uint32_t terms = r->section[RESOURCE_TERMS].count;
    switch (v->origin) {
    case RESOURCE_INPUT: return v->index < inputs && !v->whole;
    case RESOURCE_SUM:
    case RESOURCE_TURN:
    case RESOURCE_STATIC:
        return v->index <= terms && v->field <= terms - v->index && v->field > 0 &&
               (v->origin != RESOURCE_TURN || v->field % 2 == 0);
    case RESOURCE_STATUS: return true;
    default: return false;
    }
}

static const char *check_variable(const resource *r, uint32_t inputs, const resource_variable *v)
{
    if (!is_terminated(v->name, sizeof v->name) || !has_possible_bounds(v) ||
        !has_possible_factor(v))
        return unknown_variable;
    if (v->origin != RESOURCE_PARAMETER)
        return refers_to_what_there_is(r, inputs, v) ? NULL : unknown_variable;
    return resource_place(r, v) ? NULL : no_place;
}

static int axes_of(int32_t kind)
{
    return kind == RESOURCE_MOTION || kind == RESOURCE_VELOCITY ? 3 : 1;
}

/* Every input below the highest one sets something, of one kind. */
static const char *check_targets(const resource *r)
{
    const char *damaged =
        "resources/model.bin is damaged: an input sets nothing; export the scene again";
    const resource_target *t = resource_targets(r);
    const uint32_t count = r->section[RESOURCE_TARGETS].count;
    const uint32_t most[] = {
        r->section[RESOURCE_FIELDS].count, 1, r->section[RESOURCE_JUNCTIONS].count,
        r->section[RESOURCE_FIELDS].count, r->section[RESOURCE_JUNCTIONS].count};
    uint32_t next = 0; /* the next new input */
    for (uint32_t i = 0; i < count; i++) {
        if (t[i].kind < RESOURCE_WIND || t[i].kind > RESOURCE_VELOCITY) return damaged;
        const int axes = axes_of(t[i].kind);
        if (t[i].index < 0 || (uint32_t)t[i].index >= most[t[i].kind] || t[i].axis < 0 ||
            t[i].axis >= axes || t[i].input > next)
            return damaged;
        if (t[i].input == next)
            next++;
        else if (t[i].input + 1 != next || t[i].kind != t[i - 1].kind)
            return damaged;
    }
    return NULL;
}

static const char *check_terms(const resource *r)
{
    const resource_term *t = resource_terms(r);
    const uint32_t count = r->section[RESOURCE_TERMS].count;
    const uint32_t chains = r->section[RESOURCE_CHAINS].count;
    for (uint32_t i = 0; i < count; i++) {
        const gallop_probe *p = &t[i].probe;
        const bool point = p->object == RESOURCE_POINT;
        if (!isfinite(t[i].weight) || !isfinite(p->station) || p->object < RESOURCE_CONSTANT ||
            p->object > GALLOP_PROBE_DEVICE || p->index < 0 || p->channel < 0 ||
            (point && ((uint32_t)p->index >= chains || p->channel >= GALLOP_NODE_CHANNELS ||
                       !(p->station >= 0.0) || !(p->station <= 1.0))))
            return "resources/model.bin is damaged: an output is unknown; export the scene again";
    }
    return NULL;
}

/* Further places are those of parameters. */
static const char *check_places(const resource *r)
{
    const resource_also *also = also_of(r);
    for (uint32_t i = 0; i < r->section[RESOURCE_PLACES].count; i++) {
        if (also[i].variable >= resource_variable_count(r)) return no_place;
        const resource_variable *v = &resource_variables(r)[also[i].variable];
        if (v->origin != RESOURCE_PARAMETER ||
            !place_in(r, also[i].section, also[i].index, also[i].field, v->whole))
            return no_place;
    }
    return NULL;
}

static const char *check_variables(const resource *r)
{
    const char *problem = check_targets(r);
    if (!problem) problem = check_terms(r);
    const uint32_t inputs = problem ? 0 : resource_input_count(r);
    for (uint32_t i = 0; i < resource_variable_count(r) && !problem; i++)
        problem = check_variable(r, inputs, &resource_variables(r)[i]);
    return problem ? problem : check_places(r);
}

static const resource_outcome *outcomes_of(const resource *r)
{
    return (const resource_outcome *)r->section[RESOURCE_OUTCOMES].items;
}

static const resource_label *labels_of(const resource *r)
{
    return (const resource_label *)r->section[RESOURCE_LABELS].items;
}

static const char *check(resource *r, const char *guid)
{
    const char *problem = resource_file_check(r->bytes, r->size);
    if (!problem)
        problem = resource_file_find(r->bytes, known_sections, RESOURCE_SECTIONS, r->section);
    if (problem) return problem;

    const resource_identification *identity = resource_identity(r);
    if (!is_terminated(identity->guid, sizeof identity->guid) ||
        !is_terminated(identity->version, sizeof identity->version))
        return "resources/model.bin is damaged: its identity is not text; export the scene again";
    if (strcmp(guid, identity->guid) != 0)
        return "the GUID of modelDescription.xml is not that of resources/model.bin: the FMU was "
               "put together from two; export the scene again";

    problem = check_variables(r);
    if (problem) return problem;
    const resource_outcome *o = outcomes_of(r);
    for (uint32_t i = 0; i < r->section[RESOURCE_OUTCOMES].count; i++)
        if (!is_terminated(o[i].sentence, sizeof o[i].sentence) ||
            !is_terminated(o[i].remedy, sizeof o[i].remedy))
            return "resources/model.bin is damaged: an outcome is not text; export the scene again";
    for (uint32_t i = 0; i < r->section[RESOURCE_LABELS].count; i++)
        if (!is_terminated(labels_of(r)[i].text, sizeof labels_of(r)[i].text))
            return "resources/model.bin is damaged: a name is not text; export the scene again";

    const gallop_scene scene = resource_scene(r);
    gallop_report report;
    report_start(&report, 0.0);
    return check_scene(&scene, &report) || device_check_all(&scene, &report)
             ? "resources/model.bin is damaged: its scene is impossible; export the scene again"
             : NULL;
}

const char *resource_open(resource *r, const void *bytes, size_t size, const char *guid)
{
    r->bytes = malloc(size + 1);
    if (!r->bytes) return "there is not enough memory for resources/model.bin";
    r->size = size;
    memcpy(r->bytes, bytes, size);
    const char *problem = check(r, guid);
    if (problem) resource_close(r);
    return problem;
}

void resource_restore(resource *r, const char *original)
{
    memcpy(r->bytes, original, r->size);
}

void resource_close(resource *r)
{
    free(r->bytes);
    memset(r, 0, sizeof *r);
}

const resource_outcome *resource_find_outcome(const resource *r, int outcome)
{
    const resource_outcome *o = outcomes_of(r);
    for (uint32_t i = 0; i < r->section[RESOURCE_OUTCOMES].count; i++)
        if (o[i].code == outcome) return &o[i];
    return NULL;
}

bool resource_allows(const resource_variable *v, double number, double scale)
{
    const double low = scale * v->minimum, high = scale * v->maximum;
    return (v->excluded & RESOURCE_MINIMUM_EXCLUDED ? number > low : number >= low) &&
           (v->excluded & RESOURCE_MAXIMUM_EXCLUDED ? number < high : number <= high);
}

#define TABLE(r, scene, name, number)                                                              \
    do {                                                                                           \
        (scene).name##_count = (int32_t)(r)->section[number].count;                                \
        (scene).name = (const void *)(r)->section[number].items;                                   \
    } while (0)

gallop_scene resource_scene(const resource *r)
{
    gallop_scene scene = {.settings = *(gallop_settings *)r->section[RESOURCE_SETTINGS].items};
    TABLE(r, scene, cross_section, RESOURCE_CROSS_SECTIONS);
    TABLE(r, scene, curve, RESOURCE_CURVES);
    TABLE(r, scene, field, RESOURCE_FIELDS);
    TABLE(r, scene, junction, RESOURCE_JUNCTIONS);
    TABLE(r, scene, chain, RESOURCE_CHAINS);
    TABLE(r, scene, station, RESOURCE_STATIONS);
    TABLE(r, scene, device, RESOURCE_DEVICES);
    TABLE(r, scene, load, RESOURCE_LOADS);
    TABLE(r, scene, law, RESOURCE_LAWS);
    TABLE(r, scene, shedding, RESOURCE_SHEDDINGS);
    TABLE(r, scene, number, RESOURCE_NUMBERS);
    return scene;
}

gallop_probe resource_probe(const resource *r, const resource_term *term)
{
    gallop_probe probe = term->probe;
    if (probe.object == RESOURCE_CONSTANT)
        return (gallop_probe){.object = GALLOP_PROBE_SYSTEM, .channel = GALLOP_SUBSTEPS};
    if (probe.object != RESOURCE_POINT) return probe;
    const gallop_scene scene = resource_scene(r);
    double node = floor(2.0 * scene.chain[probe.index].elements * probe.station + 0.5);
    for (int32_t k = 0; k < probe.index; k++) node += 2.0 * scene.chain[k].elements + 1.0;
    probe.object = GALLOP_PROBE_NODE;
    probe.index = node < INT32_MAX ? (int32_t)node : INT32_MAX;
    probe.station = 0.0;
    return probe;
}

const char *resource_find_label(const resource *r, int32_t object, int32_t index)
{
    const resource_label *label = labels_of(r);
    for (uint32_t i = 0; i < r->section[RESOURCE_LABELS].count; i++)
        if (label[i].object == object && label[i].index == index) return label[i].text;
    return NULL;
}

static double direction_at_start(const gallop_scene *s, int32_t field)
{
    if (s->field[field].direction < 0) return 0.0;
    const law direction = law_from(&s->law[s->field[field].direction], s->number);
    return law_value(&direction, 0.0);
}

void resource_start_inputs(const resource *r, double *input)
{
    const gallop_scene scene = resource_scene(r);
    const resource_target *t = resource_targets(r);
    for (uint32_t i = r->section[RESOURCE_TARGETS].count; i-- > 0;) { /* the first target counts */
        double start = 0.0;
        if (t[i].kind == RESOURCE_WIND) {
            const law wind = law_from(&scene.law[scene.field[t[i].index].law], scene.number);
            start = law_value(&wind, 0.0);
        } else if (t[i].kind == RESOURCE_WIND_DIRECTION) {
            start = direction_at_start(&scene, t[i].index);
        } else if (t[i].kind == RESOURCE_ATTACK_ANGLE) {
            start = scene.cross_section[0].attack_angle;
        }
        input[t[i].input] = start;
    }
}
