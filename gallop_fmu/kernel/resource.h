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

typedef enum {
    ORIGIN_PARAMETER = 0,
    ORIGIN_INPUT = 1,
    ORIGIN_NODE = 2,
    ORIGIN_SPAN = 3,
    ORIGIN_STATUS = 4
} resource_origin;

typedef struct {
    char magic[8];
    uint64_t size, checksum; /* of the whole file; FNV-1a of all that follows this field */
    char guid[48], version[16];
    uint32_t scene, variables, variable_count, outcomes, outcome_count, reserved;
} resource_header;

#define MINIMUM_EXCLUDED 1u
#define MAXIMUM_EXCLUDED 2u

/* Index in the table = value reference. */
typedef struct {
    char name[64];
    int32_t origin, whole; /* whole: an Integer, else a Real */
    uint32_t place; /* parameter: offset in the file; else the number of the input or channel */
    uint32_t
        excluded; /* bounds that are not allowed themselves: MINIMUM_EXCLUDED, MAXIMUM_EXCLUDED */
    double factor, minimum, maximum; /* stored = factor * value; bounds of the value */
} resource_variable;

typedef struct {
    int32_t code, reserved;
    char sentence[128], cure[184];
} resource_outcome;

typedef struct {
    char *bytes; /* NULL: none */
    size_t size;
} resource;

/* Reads and verifies the file; on failure returns what is wrong, in a constant text. */
const char *resource_read(resource *r, const char *resource_location, const char *guid);
void resource_free(resource *r);
uint64_t resource_checksum(const char *bytes, size_t size);

static inline const resource_header *resource_head(const resource *r)
{
    return (const resource_header *)r->bytes;
}
static inline const resource_variable *resource_table(const resource *r)
{
    return (const resource_variable *)(r->bytes + resource_head(r)->variables);
}

/* Whether `scale` times the bounds of a variable include a number; none includes NaN. */
bool resource_allows(const resource_variable *v, double number, double scale);

/* The scene with its pointers leading into the resource.  `load` is the caller's copy of the loads,
 * who frees it whatever is returned: NULL, or what is wrong. */
const char *resource_scene(const resource *r, gallop_scene *scene, gallop_load **load);
/* What the inputs are before the host sets them: the scene's at t = 0. */
void resource_start_inputs(const resource *r, double input[RESOURCE_INPUTS]);

#endif
