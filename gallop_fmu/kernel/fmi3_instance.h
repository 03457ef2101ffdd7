/* An instance of FMI 3.0, and how its calls are answered. */
#ifndef GALLOP_FMI3_INSTANCE_H
#define GALLOP_FMI3_INSTANCE_H

#include "gallop_cosim.h"

#include <fmi3Functions.h>

typedef struct {
    gallop_cosim *cosim;
    fmi3LogMessageCallback log;
    fmi3InstanceEnvironment environment;
} fmi3_instance;

/* fmi3Error, with a message; the instance may be NULL. */
fmi3Status fmi3_refuse(const fmi3_instance *f, const char *text);

#endif
