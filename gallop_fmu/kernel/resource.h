/* resources/model.bin of a native FMU: the scene's numbers, the table of variables, and the words
 * for outcomes.
 *
 * All offsets count bytes from the start of the file; in the scene, pointers are stored as such
 * offsets (0: none). Its parts follow in this order: header, scene with loads and arrays,
 * variables, outcomes. Little-endian, 64 bit: the layout of linux64, win64 and darwin64 alike. */
#ifndef GALLOP_RESOURCE_H
#define GALLOP_RESOURCE_H

#include "gallop.h"

#include <stdbool.h>

#define RESOURCE_MAGIC "GALLOPM4"

#define RESOURCE_INPUTS 8 /* wind speed, attack angle, left x1 x2 x3, right x1 x2 x3 */

#define RESOURCE_IDENTITY_SIZE 48

typedef enum {
    RESOURCE_PARAMETER = 0,
    RESOURCE_INPUT = 1,
    RESOURCE_NODE = 2,
    RESOURCE_SPAN = 3,
    RESOURCE_STATUS = 4
} resource_origin;

typedef struct {
    char magic[8];
    uint64_t size, checksum; /* of the whole file; FNV-1a of all that follows this field */
    char identity[RESOURCE_IDENTITY_SIZE], version[16];
    uint32_t scene, variables, variable_count, outcomes, outcome_count, reserved;
} resource_header;

#define RESOURCE_MINIMUM_EXCLUDED 1u
#define RESOURCE_MAXIMUM_EXCLUDED 2u

/* Index in the table = value reference. */
typedef struct {
    char name[64];
    int32_t origin, whole; /* whole: an Integer, else a Real */
    uint32_t place;    /* parameter: offset in the file; else the number of the input or channel */
    uint32_t excluded; /* bounds that are not allowed themselves */
    double factor, minimum, maximum; /* stored = factor * value; bounds of the value */
} resource_variable;

typedef struct {
    int32_t code, reserved;
    char sentence[128], remedy[184];
} resource_outcome;

typedef struct {
    char *bytes; /* NULL: none */
    size_t size;
} resource;

/* Reads a regular file, whose path is UTF-8, into memory that the caller frees; the problem, or
 * NULL. */
const char *resource_read_file(const char *path, char **bytes, size_t *size);

/* Copies and verifies the content of a resource file; the problem, a constant text, or NULL. */
const char *resource_open(resource *r, const void *bytes, size_t size, const char *identity);
void resource_close(resource *r);
uint64_t resource_checksum(const char *bytes, size_t size);

static inline const resource_header *resource_head(const resource *r)
{
    return (const resource_header *)r->bytes;
}

/* GUID of the model description, RESOURCE_IDENTITY_SIZE bytes. */
static inline const char *resource_identity(const resource *r)
{
    return resource_head(r)->identity;
}
static inline const resource_variable *resource_variables(const resource *r)
{
    return (const resource_variable *)(r->bytes + resource_head(r)->variables);
}
static inline uint32_t resource_variable_count(const resource *r)
{
    return resource_head(r)->variable_count;
}

/* Where the value of a parameter is stored. */
static inline char *resource_place(const resource *r, const resource_variable *v)
{
    return r->bytes + v->place;
}

/* Puts the bytes back that were read. */
void resource_restore(resource *r, const char *original);

/* Texts for an outcome; NULL: there are none. */
const resource_outcome *resource_find_outcome(const resource *r, int outcome);

/* True if a number is within `scale` times the bounds of a variable; NaN never is. */
bool resource_allows(const resource_variable *v, double number, double scale);

/* The scene with its pointers into the resource.  `load` is a copy of the loads, which the caller
 * frees in any case; the problem, or NULL. */
const char *resource_scene(const resource *r, gallop_scene *scene, gallop_load **load);

/* The inputs before the host sets them: those of the scene at t = 0. */
void resource_start_inputs(const resource *r, double input[RESOURCE_INPUTS]);

#endif
