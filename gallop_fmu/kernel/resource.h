/* resources/model.bin of an FMU: the tables of its scene, the table of variables with what they set
 * and observe, and the texts for outcomes.  gallop_fmu/fmu/model_bin.py writes it. */
#ifndef GALLOP_RESOURCE_H
#define GALLOP_RESOURCE_H

#include "gallop.h"
#include "resource_file.h"

#include <stdbool.h>

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
    RESOURCE_SHEDDINGS,
    RESOURCE_NUMBERS,
    RESOURCE_VARIABLES,
    RESOURCE_PLACES,
    RESOURCE_TARGETS,
    RESOURCE_TERMS,
    RESOURCE_LABELS,
    RESOURCE_OUTCOMES,
    RESOURCE_SECTIONS
};

/* Item of IDEN. */
typedef struct {
    char guid[48], version[16];
} resource_identification;

typedef enum {
    RESOURCE_PARAMETER = 0,
    RESOURCE_INPUT = 1,
    RESOURCE_SUM = 2,  /* output: the sum of its terms */
    RESOURCE_TURN = 3, /* output: atan2 of the sums of the first and the second half of its terms
                          [rad] */
    RESOURCE_STATUS = 4,
    RESOURCE_STATIC = 5 /* output: the sum of its terms in the initial equilibrium, in still air */
} resource_origin;

#define RESOURCE_MINIMUM_EXCLUDED 1u
#define RESOURCE_MAXIMUM_EXCLUDED 2u

/* Item of VARS; its index is the value reference. */
typedef struct {
    char name[64];
    int32_t origin, whole;           /* a resource_origin; 1: an Integer, 0: a Real */
    char section[4];                 /* of a parameter: the section that holds it, */
    uint32_t index;                  /* the item there; of an output: its first term; else, the
                                        number of the input */
    uint32_t field;                  /* of a parameter: its place in the item [bytes]; of an output:
                                        the number of its terms */
    uint32_t excluded;               /* bounds that are not allowed themselves */
    double factor, minimum, maximum; /* stored = factor * value; bounds of the value */
} resource_variable;

/* Item of PLCS: a further place of a parameter; they are in the order of the variables. */
typedef struct {
    uint32_t variable; /* index of the parameter */
    char section[4];
    uint32_t index, field; /* as of a variable */
} resource_also;

/* What an input sets. */
typedef enum {
    RESOURCE_WIND = 0,           /* the speed of the field `index` */
    RESOURCE_ATTACK_ANGLE = 1,   /* of the first cross-section, by whose change the others turn */
    RESOURCE_MOTION = 2,         /* the tower's point at the junction `index`, along axis 0, 1, 2 */
    RESOURCE_WIND_DIRECTION = 3, /* of the field `index`: all fields have one, or none */
    RESOURCE_VELOCITY = 4        /* of a tower's point, as motion */
} resource_target_kind;

/* Item of INPT.  Several items can have one input: it sets all of them. */
typedef struct {
    uint32_t input; /* number of the input */
    int32_t kind;   /* a resource_target_kind */
    int32_t index;
    int32_t axis; /* 0 but for motion and velocity */
} resource_target;

/* Objects of a term beyond those of gallop_probe_object. */
enum {
    RESOURCE_POINT = -1,   /* the node nearest to `station` of the chain `index`, a fraction of its
                              nodes */
    RESOURCE_CONSTANT = -2 /* 1 */
};

/* Item of TERM: weight times the value of a probe. */
typedef struct {
    gallop_probe probe;
    double weight;
} resource_term;

/* What a label is of. */
enum { RESOURCE_OF_CHAIN = 0, RESOURCE_OF_DEVICE = 1 };

/* Item of NAME: where a chain or a device is, in words, for messages. */
typedef struct {
    int32_t object, index;
    char text[56];
} resource_label;

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

static inline const resource_target *resource_targets(const resource *r)
{
    return (const resource_target *)r->section[RESOURCE_TARGETS].items;
}
static inline const resource_term *resource_terms(const resource *r)
{
    return (const resource_term *)r->section[RESOURCE_TERMS].items;
}

/* Number of inputs: those that targets name. */
uint32_t resource_input_count(const resource *r);

/* What an input sets: its first target. */
const resource_target *resource_first_target(const resource *r, uint32_t input);

/* The input with the velocity of the point that an input moves, or -1. */
int32_t resource_velocity_input(const resource *r, uint32_t input);

/* Where the value of a parameter is stored; NULL: at no place that a parameter may have. */
char *resource_place(const resource *r, const resource_variable *v);

/* Stores the value of a parameter, at all its places. */
void resource_store(const resource *r, const resource_variable *v, double stored);

/* The kernel's probe of a term; that of a constant is any. */
gallop_probe resource_probe(const resource *r, const resource_term *term);

/* Where a chain or a device is, in words; NULL: there are none. */
const char *resource_find_label(const resource *r, int32_t object, int32_t index);

/* Texts for an outcome; NULL: there are none. */
const resource_outcome *resource_find_outcome(const resource *r, int outcome);

/* True if a number is within `scale` times the bounds of a variable; NaN never is. */
bool resource_allows(const resource_variable *v, double number, double scale);

/* The scene; its pointers lead into the resource. */
gallop_scene resource_scene(const resource *r);

/* The inputs before the host sets them: those of the scene at t = 0. */
void resource_start_inputs(const resource *r, double *input);

#endif
