/* Reads resources/model.bin.  Every field is validated, even if the checksum matches. */
#include "resource.h"

#include "law.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if defined(_WIN32)
#include <windows.h>
#else
#include <sys/stat.h>
#endif

#define MAX_FILE_SIZE (64l << 20)
#define MAX_PIECES 1000000
#define MAX_LOADS 1000000
#define MOST_LOADED_POINTS 10000000 /* of all loads together */

uint64_t resource_checksum(const char *bytes, size_t size)
{
    uint64_t hash = 1469598103934665603ULL;
    for (size_t i = 0; i < size; i++) hash = (hash ^ (uint8_t)bytes[i]) * 1099511628211ULL;
    return hash;
}

static FILE *open_file(const char *path)
{
#if defined(_WIN32)
    wchar_t wide[4096];
    if (!MultiByteToWideChar(CP_UTF8, 0, path, -1, wide, 4096)) return NULL;
    return _wfopen(wide, L"rb");
#else
    struct stat about; /* a pipe would be waited for */
    return stat(path, &about) == 0 && S_ISREG(about.st_mode) ? fopen(path, "rb") : NULL;
#endif
}

/* Whether `count` items at an offset lie between `first` and `end`. */
static bool is_inside(uint64_t first, uint64_t end, uint64_t offset, uint64_t count, size_t item)
{
    return offset % 8 == 0 && offset >= first && offset <= end && count <= (end - offset) / item;
}

static bool is_terminated(const char *text, size_t room)
{
    return memchr(text, 0, room) != NULL;
}

/* The parts follow one another: header, scene with its arrays, variables, outcomes.  So no
 * parameter can reach into the tables that say what may be reached. */
static bool parts_fit(const resource_header *head, size_t size)
{
    return is_inside(sizeof *head, head->variables, head->scene, 1, sizeof(gallop_scene)) &&
           is_inside(sizeof *head, head->outcomes, head->variables, head->variable_count,
                     sizeof(resource_variable)) &&
           is_inside(sizeof *head, size, head->outcomes, head->outcome_count,
                     sizeof(resource_outcome));
}

static const char *check_variable(const resource_header *head, const resource_variable *v)
{
    const char *unknown = "resources/model.bin is damaged: a variable is unknown";
    const size_t width = v->whole ? sizeof(int32_t) : sizeof(double);
    if (v->whole && v->factor != 1.0)
        return unknown; /* what a host sets must fit into an int32_t */
    if (v->excluded > (RESOURCE_MINIMUM_EXCLUDED | RESOURCE_MAXIMUM_EXCLUDED)) return unknown;
    if (!is_terminated(v->name, sizeof v->name) || isnan(v->minimum) || isnan(v->maximum))
        return unknown;
    switch (v->origin) {
    case RESOURCE_PARAMETER:
        if (v->place % width || v->place < head->scene || v->place > head->variables - width)
            return "resources/model.bin is damaged: a parameter lies outside";
        return isfinite(v->factor) && v->factor > 0.0 ? NULL : unknown;
    case RESOURCE_INPUT: return v->place < RESOURCE_INPUTS ? NULL : unknown;
    case RESOURCE_NODE: return v->place < GALLOP_NODE_CHANNELS ? NULL : unknown;
    case RESOURCE_SPAN: return v->place < GALLOP_SPAN_CHANNELS ? NULL : unknown;
    default: return v->origin == RESOURCE_STATUS ? NULL : unknown;
    }
}

bool resource_allows(const resource_variable *v, double number, double scale)
{
    const double low = scale * v->minimum, high = scale * v->maximum;
    return (v->excluded & RESOURCE_MINIMUM_EXCLUDED ? number > low : number >= low) &&
           (v->excluded & RESOURCE_MAXIMUM_EXCLUDED ? number < high : number <= high);
}

static const char *check(const resource *r, const char *identity)
{
    const resource_header *head = resource_head(r);
    const size_t covered = offsetof(resource_header, identity);
    if (r->size < sizeof *head) return "resources/model.bin is cut off";
    if (memcmp(head->magic, RESOURCE_MAGIC, sizeof head->magic) != 0)
        return "resources/model.bin is not a file of this program, or of another version";
    if (head->size != r->size) return "resources/model.bin is cut off or has grown";
    if (head->checksum != resource_checksum(r->bytes + covered, r->size - covered))
        return "resources/model.bin is damaged: its checksum is wrong";
    if (!is_terminated(head->identity, sizeof head->identity) ||
        !is_terminated(head->version, sizeof head->version))
        return "resources/model.bin is damaged: its header is not text";
    if (strcmp(identity, head->identity) != 0)
        return "the GUID of modelDescription.xml is not that of resources/model.bin: the FMU was "
               "put together from two";
    if (!parts_fit(head, r->size)) return "resources/model.bin is damaged: its parts do not fit";
    const resource_variable *v = resource_variables(r);
    for (uint32_t i = 0; i < head->variable_count; i++) {
        const char *wrong = check_variable(head, &v[i]);
        if (wrong) return wrong;
    }
    const resource_outcome *o = (const resource_outcome *)(r->bytes + head->outcomes);
    for (uint32_t i = 0; i < head->outcome_count; i++)
        if (!is_terminated(o[i].sentence, sizeof o[i].sentence) ||
            !is_terminated(o[i].remedy, sizeof o[i].remedy))
            return "resources/model.bin is damaged: an outcome is not text";
    gallop_scene scene;
    gallop_load *load;
    const char *wrong = resource_scene(r, &scene, &load);
    free(load);
    return wrong;
}

const char *resource_read_file(const char *path, char **bytes, size_t *size)
{
    FILE *file = open_file(path);
    if (!file) return "resources/model.bin cannot be opened, or is not a regular file";
    const char *problem = "resources/model.bin cannot be read";
    char *content = NULL;
    if (fseek(file, 0, SEEK_END) == 0) {
        const long length = ftell(file);
        if (length > MAX_FILE_SIZE || length < (long)sizeof(resource_header)) {
            problem = "resources/model.bin is cut off, or too large to be genuine";
        } else if ((content = malloc((size_t)length)) == NULL) {
            problem = "there is not enough memory for resources/model.bin";
        } else if (fseek(file, 0, SEEK_SET) == 0) {
            *size = (size_t)length;
            if (fread(content, 1, *size, file) == *size) problem = NULL;
        }
    }
    fclose(file);
    if (problem)
        free(content);
    else
        *bytes = content;
    return problem;
}

const char *resource_open(resource *r, const void *bytes, size_t size, const char *identity)
{
    r->bytes = malloc(size + 1);
    if (!r->bytes) return "there is not enough memory for resources/model.bin";
    r->size = size;
    memcpy(r->bytes, bytes, size);
    const char *problem = check(r, identity);
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
    r->bytes = NULL;
    r->size = 0;
}

const resource_outcome *resource_find_outcome(const resource *r, int outcome)
{
    const resource_header *head = resource_head(r);
    const resource_outcome *o = (const resource_outcome *)(r->bytes + head->outcomes);
    for (uint32_t i = 0; i < head->outcome_count; i++)
        if (o[i].code == outcome) return &o[i];
    return NULL;
}

/* Whether so many items lie in the scene's part of the file. */
static bool in_scene(const resource *r, uint64_t offset, uint64_t count, size_t item)
{
    const resource_header *head = resource_head(r);
    return is_inside(head->scene, head->variables, offset, count, item);
}

/* Turns an offset into a pointer to numbers that must be finite, and increase where asked for. */
static bool resolve_pointer(const resource *r, const double **pointer, int64_t count,
                            bool increasing)
{
    uint64_t offset = (uint64_t)(uintptr_t)*pointer;
    if (count <= 0 || !in_scene(r, offset, (uint64_t)count, sizeof(double))) return false;
    const double *number = *pointer = (const double *)(r->bytes + offset);
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

static bool resolve_loads(const resource *r, gallop_load *load, int count)
{
    int64_t points = 0;
    for (int i = 0; i < count; i++) {
        points += load[i].evenly_spaced > 0 ? load[i].evenly_spaced : 1;
        if (!resolve_law(r, &load[i].law)) return false;
    }
    return points <= MOST_LOADED_POINTS;
}

const char *resource_scene(const resource *r, gallop_scene *scene, gallop_load **load)
{
    const char *damaged =
        "resources/model.bin is damaged, or parameters contradict each other: a table does not fit";
    *load = NULL;
    memcpy(scene, r->bytes + resource_head(r)->scene, sizeof *scene);
    const int64_t pieces = scene->pieces;
    if (pieces < 0 || pieces > MAX_PIECES || scene->load_count < 0 || scene->load_count > MAX_LOADS)
        return damaged;
    if (pieces > 0 && !(resolve_pointer(r, &scene->breakpoint, pieces + 1, true) &&
                        resolve_pointer(r, &scene->origin, pieces, false) &&
                        resolve_pointer(r, &scene->coefficient, 12 * pieces, false)))
        return damaged;
    if (!resolve_law(r, &scene->wind)) return damaged;
    for (int end = 0; end < 2; end++)
        for (int i = 0; i < 3; i++)
            if (!resolve_law(r, &scene->support[end].motion[i])) return damaged;
    if (scene->load_count > 0) {
        const uint64_t offset = (uint64_t)(uintptr_t)scene->load;
        const size_t size = (size_t)scene->load_count * sizeof(gallop_load);
        if (!in_scene(r, offset, (uint64_t)scene->load_count, sizeof(gallop_load))) return damaged;
        *load = malloc(size);
        if (!*load) return "there is not enough memory";
        memcpy(*load, r->bytes + offset, size);
        if (!resolve_loads(r, *load, scene->load_count)) return damaged;
    }
    scene->load = *load;
    return NULL;
}

void resource_start_inputs(const resource *r, double input[RESOURCE_INPUTS])
{
    gallop_scene scene;
    memcpy(&scene, r->bytes + resource_head(r)->scene, sizeof scene);
    memset(input, 0, RESOURCE_INPUTS * sizeof *input);
    resolve_law(r, &scene.wind); /* was checked when the file was read, and is no parameter */
    input[0] = law_value(&scene.wind, 0.0);
    input[1] = scene.attack_angle;
}
