/* Reads resources/model.bin: nothing in it is believed before it is checked. */
#include "resource.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if defined(_WIN32)
#include <windows.h>
#endif

#define LARGEST_FILE (64u << 20)

uint64_t resource_checksum(const char *bytes, size_t size)
{
    uint64_t hash = 1469598103934665603ULL;
    for (size_t i = 0; i < size; i++) hash = (hash ^ (uint8_t)bytes[i]) * 1099511628211ULL;
    return hash;
}

static int hexadecimal(char c)
{
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

/* file:///x, file://localhost/x, file:/x or a plain path; percent-encoded UTF-8.  Returns a path of the caller's. */
static char *path_of(const char *location, const char *name)
{
    const char *from = location;
    if (strncmp(from, "file:", 5) == 0) {
        from += 5;
        if (strncmp(from, "//", 2) == 0) {
            from += 2;
            while (*from && *from != '/') from++;   /* a host name, most often none */
        }
#if defined(_WIN32)
        if (from[0] == '/' && from[1] && (from[2] == ':' || from[2] == '|')) from++;
#endif
    }
    char *path = malloc(strlen(from) + strlen(name) + 2), *to = path;
    if (!path) return NULL;
    while (*from) {
        int high = *from == '%' ? hexadecimal(from[1]) : -1, low = high >= 0 ? hexadecimal(from[2]) : -1;
        *to++ = low >= 0 ? (char)(16 * high + low) : *from;
        from += low >= 0 ? 3 : 1;
    }
    if (to > path && to[-1] != '/') *to++ = '/';
    strcpy(to, name);
    return path;
}

static FILE *open_file(const char *path)
{
#if defined(_WIN32)
    wchar_t wide[4096];
    if (!MultiByteToWideChar(CP_UTF8, 0, path, -1, wide, 4096)) return NULL;
    return _wfopen(wide, L"rb");
#else
    return fopen(path, "rb");
#endif
}

static bool inside(const resource *r, uint64_t offset, uint64_t count, size_t item)
{
    return offset % 8 == 0 && offset <= r->size && count <= (r->size - offset) / item;
}

static bool terminated(const char *text, size_t room) { return memchr(text, 0, room) != NULL; }

static const char *check(const resource *r, const char *guid)
{
    const resource_header *head = resource_head(r);
    const size_t covered = offsetof(resource_header, guid);
    if (r->size < sizeof *head) return "resources/model.bin is cut off";
    if (memcmp(head->magic, RESOURCE_MAGIC, 8) != 0) return "resources/model.bin is not a file of this program, or of another version";
    if (head->size != r->size) return "resources/model.bin is cut off or has grown";
    if (head->checksum != resource_checksum(r->bytes + covered, r->size - covered)) return "resources/model.bin is damaged: its checksum is wrong";
    if (!terminated(head->guid, sizeof head->guid) || !terminated(head->version, sizeof head->version)) return "resources/model.bin is damaged: its header is not text";
    if (guid && strcmp(guid, head->guid) != 0) return "the GUID of modelDescription.xml is not that of resources/model.bin: the FMU was put together from two";
    if (!inside(r, head->scene, 1, sizeof(gallop_scene)) || !inside(r, head->variables, head->variable_count, sizeof(resource_variable)) ||
        !inside(r, head->outcomes, head->outcome_count, sizeof(resource_outcome)))
        return "resources/model.bin is damaged: its parts do not fit";
    const resource_variable *v = resource_table(r);
    for (uint32_t i = 0; i < head->variable_count; i++) {
        if (!terminated(v[i].name, sizeof v[i].name) || v[i].origin < ORIGIN_PARAMETER || v[i].origin > ORIGIN_STATUS)
            return "resources/model.bin is damaged: a variable is unknown";
        size_t width = v[i].whole ? sizeof(int32_t) : sizeof(double);
        if (v[i].origin == ORIGIN_PARAMETER && (v[i].place % width != 0 || v[i].place < head->scene || v[i].place > r->size - width))
            return "resources/model.bin is damaged: a parameter lies outside";
        if ((v[i].origin == ORIGIN_INPUT && v[i].place >= 8) || (v[i].origin == ORIGIN_NODE && v[i].place >= GALLOP_NODE_CHANNELS) ||
            (v[i].origin == ORIGIN_SPAN && v[i].place >= GALLOP_SPAN_CHANNELS))
            return "resources/model.bin is damaged: a variable is unknown";
    }
    const resource_outcome *o = (const resource_outcome *)(r->bytes + head->outcomes);
    for (uint32_t i = 0; i < head->outcome_count; i++)
        if (!terminated(o[i].sentence, sizeof o[i].sentence) || !terminated(o[i].cure, sizeof o[i].cure))
            return "resources/model.bin is damaged: an outcome is not text";
    return NULL;
}

const char *resource_read(resource *r, const char *resource_location, const char *guid)
{
    r->bytes = NULL;
    r->size = 0;
    if (!resource_location) return "no resource location was given";
    char *path = path_of(resource_location, "model.bin");
    if (!path) return "there is not enough memory";
    FILE *file = open_file(path);
    free(path);
    if (!file) return "resources/model.bin cannot be opened";
    const char *wrong = "resources/model.bin cannot be read";
    if (fseek(file, 0, SEEK_END) == 0) {
        long size = ftell(file);
        if (size > (long)LARGEST_FILE || size < (long)sizeof(resource_header)) {
            wrong = "resources/model.bin is cut off, or too large to be genuine";
        } else if (fseek(file, 0, SEEK_SET) == 0 && (r->bytes = malloc((size_t)size)) != NULL) {
            r->size = (size_t)size;
            if (fread(r->bytes, 1, r->size, file) == r->size) wrong = check(r, guid);
        }
    }
    fclose(file);
    if (wrong) resource_free(r);
    return wrong;
}

void resource_free(resource *r)
{
    free(r->bytes);
    r->bytes = NULL;
    r->size = 0;
}

/* An array of numbers that must be finite, and increase where asked for. */
static bool lead(const resource *r, const double **pointer, int64_t count, bool increasing)
{
    uint64_t offset = (uint64_t)(uintptr_t)*pointer;
    if (count <= 0 || !inside(r, offset, (uint64_t)count, sizeof(double)) || offset == 0) return 0;
    *pointer = (const double *)(r->bytes + offset);
    for (int64_t i = 0; i < count; i++)
        if (!isfinite((*pointer)[i]) || (increasing && i > 0 && !((*pointer)[i] > (*pointer)[i - 1]))) return 0;
    return 1;
}

static bool lead_law(const resource *r, gallop_law *law)
{
    if (law->kind < GALLOP_LAW_CONSTANT || law->kind > GALLOP_LAW_TABLE) return 0;
    if (law->kind != GALLOP_LAW_TABLE) return 1;
    return lead(r, &law->time, law->count, 1) && lead(r, &law->value, law->count, 0);
}

const char *resource_scene(const resource *r, gallop_scene *scene, gallop_load **load)
{
    const char *damaged = "resources/model.bin is damaged: a table does not fit";
    *load = NULL;
    memcpy(scene, r->bytes + resource_head(r)->scene, sizeof *scene);
    if (scene->pieces < 0 || scene->pieces > 1000000 || scene->load_count < 0 || scene->load_count > 1000000) return damaged;
    if (scene->pieces > 0 && (!lead(r, &scene->breakpoint, (int64_t)scene->pieces + 1, 1) || !lead(r, &scene->origin, scene->pieces, 0) ||
                              !lead(r, &scene->coefficient, 12 * (int64_t)scene->pieces, 0)))
        return damaged;
    if (!lead_law(r, &scene->wind)) return damaged;
    for (int end = 0; end < 2; end++)
        for (int i = 0; i < 3; i++)
            if (!lead_law(r, &scene->support[end].motion[i])) return damaged;
    if (scene->load_count > 0) {
        uint64_t offset = (uint64_t)(uintptr_t)scene->load;
        if (!inside(r, offset, (uint64_t)scene->load_count, sizeof(gallop_load))) return damaged;
        *load = malloc((size_t)scene->load_count * sizeof(gallop_load));
        if (!*load) return "there is not enough memory";
        memcpy(*load, r->bytes + offset, (size_t)scene->load_count * sizeof(gallop_load));
        for (int i = 0; i < scene->load_count; i++)
            if (!lead_law(r, &(*load)[i].law) || (*load)[i].evenly_spaced > 100000) return damaged;
    }
    scene->load = *load;
    return NULL;
}
