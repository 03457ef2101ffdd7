/* Reads the resource file of an unpacked FMU, as fmi2Instantiate does. */
#ifndef FUZZING_READ_RESOURCE_H
#define FUZZING_READ_RESOURCE_H

#include "fmi_location.h"
#include "gallop_cosim.h"
#include "resource.h"

#include <stdlib.h>

/* The problem, or NULL; `location` is the URI or the path of the FMU's folder of resources. */
static inline const char *read_resource(resource *r, const char *location, const char *guid)
{
    char *bytes = NULL, *path = fmi_location_path(location, "model.bin");
    size_t size = 0;
    r->bytes = NULL;
    const char *problem =
        path ? resource_file_read(path, &bytes, &size) : "there is not enough memory";
    free(path);
    if (!problem) problem = resource_open(r, bytes, size, guid);
    free(bytes);
    return problem;
}

#endif
