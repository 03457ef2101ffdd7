/* Reads resources/model.bin: nothing in it is believed before it is checked, whatever its checksum.
 */
#include "resource.h"

#include "law.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if defined(_WIN32)
#include <windows.h>
#define DRIVES true
#else
#include <sys/stat.h>
#define DRIVES false
#endif

#define LARGEST_FILE (64l << 20)
#define MOST_PIECES 1000000
#define MOST_LOADS 1000000
#define MOST_LOADED_POINTS 10000000 /* of all loads together */

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

static bool letter(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

/* C: or C| at the start */
static bool drive(const char *text)
{
    return letter(text[0]) && (text[1] == ':' || text[1] == '|');
}

static bool is_uri(const char *location)
{
    const char *scheme = "file:";
    for (int i = 0; scheme[i]; i++)
        if (location[i] != scheme[i] && location[i] != scheme[i] - 'a' + 'A') return false;
    return true;
}

/* Percent-encoded bytes become what they stand for; %00 stays, a path cannot hold it. */
static void decode(char *text)
{
    char *to = text;
    for (const char *from = text; *from; to++) {
        int high = *from == '%' ? hexadecimal(from[1]) : -1,
            low = high >= 0 ? hexadecimal(from[2]) : -1;
        bool encoded = low >= 0 && 16 * high + low > 0;
        *to = encoded ? (char)(16 * high + low) : *from;
        from += encoded ? 3 : 1;
    }
    *to = '\0';
}

/* What follows file: and names a file: file:///x, file://localhost/x, file:/x; with drives
 * file:///C:/x, file:///C|/x, and the faulty file://C:/x.  With drives a host is a server, whose
 * path begins with //. */
static const char *file_part(const char *from, bool drives)
{
    if (strncmp(from, "//", 2) == 0) {
        const char *host = from + 2, *end = host;
        while (*end && *end != '/') end++;
        const bool here = end == host || (end - host == 9 && strncmp(host, "localhost", 9) == 0);
        if (drives && drive(host))
            from = host;
        else if (here || !drives)
            from = end;
    }
    return drives && from[0] == '/' && drive(from + 1) ? from + 1 : from;
}

/* The path of a file in the folder that a URI (percent-encoded UTF-8) or a plain path gives.  The
 * caller frees it. */
static char *path_of(const char *location, const char *name, bool drives)
{
    const bool uri = is_uri(location);
    char *path = malloc(strlen(location) + strlen(name) + 2);
    if (!path) return NULL;
    strcpy(path, location);
    if (uri) {
        decode(path);
        const char *file = file_part(path + strlen("file:"), drives);
        memmove(path, file, strlen(file) + 1);
        if (drives && drive(path)) path[1] = ':';
    }
    const size_t length = strlen(path);
    if (length > 0 && path[length - 1] != '/') strcat(path, "/");
    strcat(path, name);
    return path;
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
static bool inside(uint64_t first, uint64_t end, uint64_t offset, uint64_t count, size_t item)
{
    return offset % 8 == 0 && offset >= first && offset <= end && count <= (end - offset) / item;
}

static bool terminated(const char *text, size_t room)
{
    return memchr(text, 0, room) != NULL;
}

/* The parts follow one another: header, scene with its arrays, variables, outcomes.  So no
 * parameter can reach into the tables that say what may be reached. */
static bool parts_fit(const resource_header *head, size_t size)
{
    return inside(sizeof *head, head->variables, head->scene, 1, sizeof(gallop_scene)) &&
           inside(sizeof *head, head->outcomes, head->variables, head->variable_count,
                  sizeof(resource_variable)) &&
           inside(sizeof *head, size, head->outcomes, head->outcome_count,
                  sizeof(resource_outcome));
}

static const char *check_variable(const resource_header *head, const resource_variable *v)
{
    const char *unknown = "resources/model.bin is damaged: a variable is unknown";
    const size_t width = v->whole ? sizeof(int32_t) : sizeof(double);
    if (v->whole && v->factor != 1.0)
        return unknown; /* what a host sets must fit into an int32_t */
    if (v->excluded > (MINIMUM_EXCLUDED | MAXIMUM_EXCLUDED)) return unknown;
    if (!terminated(v->name, sizeof v->name) || isnan(v->minimum) || isnan(v->maximum))
        return unknown;
    switch (v->origin) {
    case ORIGIN_PARAMETER:
        if (v->place % width || v->place < head->scene || v->place > head->variables - width)
            return "resources/model.bin is damaged: a parameter lies outside";
        return isfinite(v->factor) && v->factor > 0.0 ? NULL : unknown;
    case ORIGIN_INPUT: return v->place < RESOURCE_INPUTS ? NULL : unknown;
    case ORIGIN_NODE: return v->place < GALLOP_NODE_CHANNELS ? NULL : unknown;
    case ORIGIN_SPAN: return v->place < GALLOP_SPAN_CHANNELS ? NULL : unknown;
    default: return v->origin == ORIGIN_STATUS ? NULL : unknown;
    }
}

bool resource_allows(const resource_variable *v, double number, double scale)
{
    const double low = scale * v->minimum, high = scale * v->maximum;
    return (v->excluded & MINIMUM_EXCLUDED ? number > low : number >= low) &&
           (v->excluded & MAXIMUM_EXCLUDED ? number < high : number <= high);
}

static const char *check(const resource *r, const char *guid)
{
    const resource_header *head = resource_head(r);
    const size_t covered = offsetof(resource_header, guid);
    if (r->size < sizeof *head) return "resources/model.bin is cut off";
    if (memcmp(head->magic, RESOURCE_MAGIC, sizeof head->magic) != 0)
        return "resources/model.bin is not a file of this program, or of another version";
    if (head->size != r->size) return "resources/model.bin is cut off or has grown";
    if (head->checksum != resource_checksum(r->bytes + covered, r->size - covered))
        return "resources/model.bin is damaged: its checksum is wrong";
    if (!terminated(head->guid, sizeof head->guid) ||
        !terminated(head->version, sizeof head->version))
        return "resources/model.bin is damaged: its header is not text";
    if (strcmp(guid, head->guid) != 0)
        return "the GUID of modelDescription.xml is not that of resources/model.bin: the FMU was "
               "put together from two";
    if (!parts_fit(head, r->size)) return "resources/model.bin is damaged: its parts do not fit";
    const resource_variable *v = resource_table(r);
    for (uint32_t i = 0; i < head->variable_count; i++) {
        const char *wrong = check_variable(head, &v[i]);
        if (wrong) return wrong;
    }
    const resource_outcome *o = (const resource_outcome *)(r->bytes + head->outcomes);
    for (uint32_t i = 0; i < head->outcome_count; i++)
        if (!terminated(o[i].sentence, sizeof o[i].sentence) ||
            !terminated(o[i].cure, sizeof o[i].cure))
            return "resources/model.bin is damaged: an outcome is not text";
    gallop_scene scene;
    gallop_load *load;
    const char *wrong = resource_scene(r, &scene, &load);
    free(load);
    return wrong;
}

const char *resource_read(resource *r, const char *resource_location, const char *guid)
{
    r->bytes = NULL;
    r->size = 0;
    if (!resource_location) return "no resource location was given";
    char *path = path_of(resource_location, "model.bin", DRIVES);
    if (!path) return "there is not enough memory";
    FILE *file = open_file(path);
    free(path);
    if (!file) return "resources/model.bin cannot be opened, or is not a regular file";
    const char *wrong = "resources/model.bin cannot be read";
    if (fseek(file, 0, SEEK_END) == 0) {
        long size = ftell(file);
        if (size > LARGEST_FILE || size < (long)sizeof(resource_header)) {
            wrong = "resources/model.bin is cut off, or too large to be genuine";
        } else if ((r->bytes = malloc((size_t)size)) == NULL) {
            wrong = "there is not enough memory for resources/model.bin";
        } else if (fseek(file, 0, SEEK_SET) == 0) {
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

/* Whether so many items lie in the scene's part of the file. */
static bool in_scene(const resource *r, uint64_t offset, uint64_t count, size_t item)
{
    const resource_header *head = resource_head(r);
    return inside(head->scene, head->variables, offset, count, item);
}

/* Turns an offset into a pointer to numbers that must be finite, and increase where asked for. */
static bool lead(const resource *r, const double **pointer, int64_t count, bool increasing)
{
    uint64_t offset = (uint64_t)(uintptr_t)*pointer;
    if (count <= 0 || !in_scene(r, offset, (uint64_t)count, sizeof(double))) return false;
    const double *number = *pointer = (const double *)(r->bytes + offset);
    for (int64_t i = 0; i < count; i++)
        if (!isfinite(number[i]) || (increasing && i > 0 && !(number[i] > number[i - 1])))
            return false;
    return true;
}

static bool lead_law(const resource *r, gallop_law *law)
{
    if (law->kind < GALLOP_LAW_CONSTANT || law->kind > GALLOP_LAW_TABLE) return false;
    if (law->kind != GALLOP_LAW_TABLE) return true;
    return lead(r, &law->time, law->count, true) && lead(r, &law->value, law->count, false);
}

static bool lead_loads(const resource *r, gallop_load *load, int count)
{
    int64_t points = 0;
    for (int i = 0; i < count; i++) {
        points += load[i].evenly_spaced > 0 ? load[i].evenly_spaced : 1;
        if (!lead_law(r, &load[i].law)) return false;
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
    if (pieces < 0 || pieces > MOST_PIECES || scene->load_count < 0 ||
        scene->load_count > MOST_LOADS)
        return damaged;
    if (pieces > 0 &&
        !(lead(r, &scene->breakpoint, pieces + 1, true) && lead(r, &scene->origin, pieces, false) &&
          lead(r, &scene->coefficient, 12 * pieces, false)))
        return damaged;
    if (!lead_law(r, &scene->wind)) return damaged;
    for (int end = 0; end < 2; end++)
        for (int i = 0; i < 3; i++)
            if (!lead_law(r, &scene->support[end].motion[i])) return damaged;
    if (scene->load_count > 0) {
        const uint64_t offset = (uint64_t)(uintptr_t)scene->load;
        const size_t size = (size_t)scene->load_count * sizeof(gallop_load);
        if (!in_scene(r, offset, (uint64_t)scene->load_count, sizeof(gallop_load))) return damaged;
        *load = malloc(size);
        if (!*load) return "there is not enough memory";
        memcpy(*load, r->bytes + offset, size);
        if (!lead_loads(r, *load, scene->load_count)) return damaged;
    }
    scene->load = *load;
    return NULL;
}

void resource_start_inputs(const resource *r, double input[RESOURCE_INPUTS])
{
    gallop_scene scene;
    memcpy(&scene, r->bytes + resource_head(r)->scene, sizeof scene);
    memset(input, 0, RESOURCE_INPUTS * sizeof *input);
    lead_law(r, &scene.wind); /* was checked when the file was read, and is no parameter */
    input[0] = law_value(&scene.wind, 0.0);
    input[1] = scene.attack_angle;
}
