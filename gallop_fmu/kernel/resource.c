/* Reads resources/model.bin.  Every field is validated, even if the checksum matches. */
#include "resource.h"

#include "law.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MANY 10000000

#define SECTION(id, type, min_count, max_count)                                                    \
    {id, sizeof(type), min_count, max_count,                                                       \
     "resources/model.bin has no section " id "; export the scene again"}

/* The table of sections.  A parameter may be in those of the scene only. */
static const resource_kind sections[RESOURCE_SECTIONS] = {
    [RESOURCE_IDENTITY] = SECTION("IDEN", resource_identification, 1, 1),
    [RESOURCE_SCENE] = SECTION("SCEN", gallop_scene, 1, 1),
    [RESOURCE_LOADS] = SECTION("LOAD", gallop_load, 0, MANY),
    [RESOURCE_NUMBERS] = SECTION("NUMB", double, 0, MANY),
    [RESOURCE_VARIABLES] = SECTION("VARS", resource_variable, 1, MANY),
    [RESOURCE_OUTCOMES] = SECTION("OUTC", resource_outcome, 0, MANY),
};

static bool holds_parameters(int section)
{
    return section >= RESOURCE_SCENE && section <= RESOURCE_NUMBERS;
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
        if (!holds_parameters(i) || memcmp(v->section, sections[i].id, sizeof v->section) != 0)
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
    case RESOURCE_SPAN: return GALLOP_SPAN_CHANNELS;
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
    if (!problem) problem = resource_file_find(r->bytes, sections, RESOURCE_SECTIONS, r->section);
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

    gallop_scene scene;
    gallop_load *load;
    problem = resource_scene(r, &scene, &load);
    free(load);
    return problem;
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

/* In the file a pointer to numbers is 1 + the index of the first in NUMB, or 0.  Resolves it to
 * numbers that must be finite, and increase if asked for. */
static bool resolve_pointer(const resource *r, const double **pointer, int64_t count,
                            bool increasing)
{
    const resource_section *s = &r->section[RESOURCE_NUMBERS];
    const uint64_t first = (uint64_t)(uintptr_t)*pointer - 1;
    if (count <= 0 || first >= s->count || (uint64_t)count > s->count - first) return false;
    const double *number = *pointer = (const double *)s->items + first;
    for (int64_t i = 0; i < count; i++)
        if (!isfinite(number[i]) || (increasing && i > 0 && !(number[i] > number[i - 1])))
            return false;
    return true;
}

static bool resolve_law(const resource *r, gallop_law *law)
{
    if (law->kind < GALLOP_LAW_CONSTANT || law->kind > GALLOP_LAW_TABLE) return false;
    if (law->kind != GALLOP_LAW_TABLE) return true;
    return resolve_pointer(r, &law->time, law->count, true) &&
           resolve_pointer(r, &law->value, law->count, false);
}

static bool resolve_curve(const resource *r, gallop_scene *scene)
{
    const int64_t pieces = scene->pieces;
    if (pieces == 0) return true;
    return pieces > 0 && resolve_pointer(r, &scene->breakpoint, pieces + 1, true) &&
           resolve_pointer(r, &scene->origin, pieces, false) &&
           resolve_pointer(r, &scene->coefficient, 12 * pieces, false);
}

const char *resource_scene(const resource *r, gallop_scene *scene, gallop_load **load)
{
    const char *damaged = "resources/model.bin is damaged, or parameters contradict each other: a "
                          "table does not fit; check the parameters, or export the scene again";
    const resource_section *loads = &r->section[RESOURCE_LOADS];
    *load = NULL;
    memcpy(scene, r->section[RESOURCE_SCENE].items, sizeof *scene);
    if (!resolve_curve(r, scene) || !resolve_law(r, &scene->wind)) return damaged;
    for (int end = 0; end < 2; end++)
        for (int i = 0; i < 3; i++)
            if (!resolve_law(r, &scene->support[end].motion[i])) return damaged;

    scene->load = NULL;
    scene->load_count = (int32_t)loads->count;
    if (loads->count == 0) return NULL;
    *load = malloc(loads->count * sizeof **load);
    if (!*load) return "there is not enough memory for the loads";
    memcpy(*load, loads->items, loads->count * sizeof **load);
    for (uint32_t i = 0; i < loads->count; i++)
        if (!resolve_law(r, &(*load)[i].law)) return damaged;
    scene->load = *load;
    return NULL;
}

void resource_start_inputs(const resource *r, double input[RESOURCE_INPUTS])
{
    gallop_scene scene;
    memcpy(&scene, r->section[RESOURCE_SCENE].items, sizeof scene);
    memset(input, 0, RESOURCE_INPUTS * sizeof *input);
    resolve_law(r, &scene.wind); /* was checked when the file was read, and is no parameter */
    input[0] = law_value(&scene.wind, 0.0);
    input[1] = scene.attack_angle;
}
