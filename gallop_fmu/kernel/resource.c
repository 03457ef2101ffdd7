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
    [RESOURCE_NUMBERS] = SECTION("NUMB", double, 0, MANY),
    [RESOURCE_VARIABLES] = SECTION("VARS", resource_variable, 1, MANY),
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

char *resource_place(const resource *r, const resource_variable *v)
{
    const size_t width = v->whole ? sizeof(int32_t) : sizeof(double);
    for (int i = 0; i < RESOURCE_SECTIONS; i++) {
        const resource_section *s = &r->section[i];
        if (!holds_parameters(i) ||
            memcmp(v->section, known_sections[i].id, sizeof v->section) != 0)
            continue;
        if (v->index >= s->count || v->field % width || v->field > s->item_size - width)
            return NULL;
        return s->items + (size_t)v->index * s->item_size + v->field;
    }
    return NULL;
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

/* How many inputs or channels of an origin there are; 0: the origin is unknown. */
static uint32_t count_of_origin(int32_t origin)
{
    switch (origin) {
    case RESOURCE_INPUT: return RESOURCE_INPUTS;
    case RESOURCE_NODE: return GALLOP_NODE_CHANNELS;
    case RESOURCE_SPAN: return RESOURCE_SPAN_OUTPUTS;
    case RESOURCE_STATUS: return 1;
    default: return 0;
    }
}

static const char *check_variable(const resource *r, const resource_variable *v)
{
    const char *unknown =
        "resources/model.bin is damaged: a variable is unknown; export the scene again";
    if (!is_terminated(v->name, sizeof v->name) || !has_possible_bounds(v) ||
        !has_possible_factor(v))
        return unknown;
    if (v->origin != RESOURCE_PARAMETER)
        return v->index < count_of_origin(v->origin) ? NULL : unknown;
    return resource_place(r, v)
             ? NULL
             : "resources/model.bin is damaged: a parameter has no place; export the scene again";
}

static const resource_outcome *outcomes_of(const resource *r)
{
    return (const resource_outcome *)r->section[RESOURCE_OUTCOMES].items;
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

    for (uint32_t i = 0; i < resource_variable_count(r); i++) {
        problem = check_variable(r, &resource_variables(r)[i]);
        if (problem) return problem;
    }
    const resource_outcome *o = outcomes_of(r);
    for (uint32_t i = 0; i < r->section[RESOURCE_OUTCOMES].count; i++)
        if (!is_terminated(o[i].sentence, sizeof o[i].sentence) ||
            !is_terminated(o[i].remedy, sizeof o[i].remedy))
            return "resources/model.bin is damaged: an outcome is not text; export the scene again";

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
    TABLE(r, scene, number, RESOURCE_NUMBERS);
    return scene;
}

void resource_start_inputs(const resource *r, double input[RESOURCE_INPUTS])
{
    const gallop_scene scene = resource_scene(r);
    const gallop_chain *first = &scene.chain[0];
    const law wind = law_from(&scene.law[scene.field[first->field].law], scene.number);
    memset(input, 0, RESOURCE_INPUTS * sizeof *input);
    input[0] = law_value(&wind, 0.0);
    input[1] = scene.cross_section[first->cross_section].attack_angle;
}
