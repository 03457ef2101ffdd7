/* What the files of the FMI layer share: the instance, and how it speaks. */
#ifndef GALLOP_FMI2_INSTANCE_H
#define GALLOP_FMI2_INSTANCE_H

#include "resource.h"

#include <fmi2Functions.h>

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#define INPUTS 8

typedef enum { INSTANTIATED = 1, INITIALIZING = 2, STEPPING = 4, TERMINATED = 8 } mode;

/* What a saved FMU state holds besides the kernel's state and the parameters. */
typedef struct {
    int32_t mode, status;
    double time, start, last_step;           /* last_step 0: none to look back on */
    double input[INPUTS], rate[INPUTS];      /* wind speed, attack angle, left x1 x2 x3, right x1 x2 x3 */
    double reached[6];                       /* where the tower points are */
    double before_input[INPUTS], before_rate[INPUTS], before_reached[6];   /* of the last step */
} kept;

typedef struct {
    fmi2CallbackFunctions call;
    char *name;
    resource parameters;       /* as the host has set them, */
    char *original;            /* and as they were exported */
    gallop_model *model;       /* NULL: parameters changed */
    gallop_state *state, *work;
    bool started;              /* state belongs to the present inputs */
    bool nodes_known, forces_known;
    double nodes[GALLOP_NODE_CHANNELS], forces[6], counts[2];
    kept now;
} instance;

/* fmi2.c */
fmi2Status say(instance *c, fmi2Status status, const char *format, ...);
fmi2Status tell(instance *c, const char *what, const gallop_report *report);   /* a failure of the kernel */
bool allowed(instance *c, int modes, const char *function);
void drop_model(instance *c);
fmi2Status build_model(instance *c);
fmi2Status make_current(instance *c);
void held_inputs(const double input[INPUTS], double time, gallop_inputs *in);

/* fmi2_values.c */
const resource_variable *find(instance *c, fmi2ValueReference reference, bool whole, const char *function);
double observed(instance *c, const resource_variable *v);

#define ALLOW(modes) \
    instance *c = component; \
    if (!allowed(c, modes, __func__)) return fmi2Error
#define ANY (INSTANTIATED | INITIALIZING | STEPPING | TERMINATED)

#endif
