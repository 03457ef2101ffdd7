/* resources/model.bin of an FMU: the tables of its scene, the table of variables, and the texts for
 * outcomes.  gallop_fmu/fmu/model_bin.py writes it. */
#ifndef GALLOP_RESOURCE_H
#define GALLOP_RESOURCE_H

#include "gallop.h"
#include "resource_file.h"

#include <stdbool.h>

#define RESOURCE_INPUTS 8 /* wind speed, attack angle, left x1 x2 x3, right x1 x2 x3 */

/* Sections, in the order of the table in resource.c. */
enum {
    RESOURCE_IDENTITY,
    RESOURCE_SETTINGS,
    RESOURCE_CROSS_SECTIONS,
    RESOURCE_CURVES,
    RESOURCE_FIELDS,
    RESOURCE_JUNCTIONS,
    RESOURCE_CHAINS,
    RESOURCE_STATIONS,
    RESOURCE_DEVICES,
    RESOURCE_LOADS,
    RESOURCE_LAWS,
    RESOURCE_NUMBERS,
    RESOURCE_VARIABLES,
    RESOURCE_OUTCOMES,
    RESOURCE_SECTIONS
};

/* Item of IDEN. */
typedef struct {
    char guid[48], version[16];
} resource_identification;

/* Outputs of the span by number: forces along x1, x2, x3 at both ends, then those of the kernel's
 * gallop_system_channel. */
enum {
    RESOURCE_WIND_SPEED,
    RESOURCE_LEFT_FORCE,
    RESOURCE_RIGHT_FORCE = RESOURCE_LEFT_FORCE + GALLOP_JUNCTION_CHANNELS,
    RESOURCE_SYSTEM = RESOURCE_RIGHT_FORCE + GALLOP_JUNCTION_CHANNELS,
    RESOURCE_SPAN_OUTPUTS = RESOURCE_SYSTEM + GALLOP_SYSTEM_CHANNELS
};

typedef enum {
    RESOURCE_PARAMETER = 0,
    RESOURCE_INPUT = 1,
    RESOURCE_NODE = 2,
    RESOURCE_SPAN = 3,
    RESOURCE_STATUS = 4
} resource_origin;

#define RESOURCE_MINIMUM_EXCLUDED 1u
#define RESOURCE_MAXIMUM_EXCLUDED 2u

/* Item of VARS; its index is the value reference. */
typedef struct {
    char name[64];
    int32_t origin, whole;           /* a resource_origin; 1: an Integer, 0: a Real */
    char section[4];                 /* of a parameter: the section that holds it, */
    uint32_t index;                  /* the item there; else, the number of the input or channel */
    uint32_t field;                  /* of a parameter: its place in the item [bytes] */
    uint32_t excluded;               /* bounds that are not allowed themselves */
    double factor, minimum, maximum; /* stored = factor * value; bounds of the value */
} resource_variable;

/* Item of OUTC. */
typedef struct {
    int32_t code, reserved; /* a gallop_outcome */
    char sentence[128], remedy[184];
} resource_outcome;

typedef struct {
    char *bytes; /* NULL: none */
    size_t size;
    resource_section section[RESOURCE_SECTIONS];
} resource;

/* Copies and verifies the content of a resource file; the problem, a constant text, or NULL. */
const char *resource_open(resource *r, const void *bytes, size_t size, const char *guid);
void resource_close(resource *r);

/* Puts the bytes back that were read. */
void resource_restore(resource *r, const char *original);

static inline const resource_identification *resource_identity(const resource *r)
{
    return (const resource_identification *)r->section[RESOURCE_IDENTITY].items;
}
static inline const resource_variable *resource_variables(const resource *r)
{
    return (const resource_variable *)r->section[RESOURCE_VARIABLES].items;
}
static inline uint32_t resource_variable_count(const resource *r)
{
    return r->section[RESOURCE_VARIABLES].count;
}

/* Where the value of a parameter is stored; NULL: at no place that a parameter may have. */
char *resource_place(const resource *r, const resource_variable *v);

/* Texts for an outcome; NULL: there are none. */
const resource_outcome *resource_find_outcome(const resource *r, int outcome);

/* True if a number is within `scale` times the bounds of a variable; NaN never is. */
bool resource_allows(const resource_variable *v, double number, double scale);

/* The scene; its pointers lead into the resource. */
gallop_scene resource_scene(const resource *r);

/* The inputs before the host sets them: those of the scene at t = 0. */
void resource_start_inputs(const resource *r, double input[RESOURCE_INPUTS]);

#endif
