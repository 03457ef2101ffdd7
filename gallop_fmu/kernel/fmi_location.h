/* What the adapters to all versions of FMI share: the folder of the resources, and the categories
 * of log messages. */
#ifndef GALLOP_FMI_LOCATION_H
#define GALLOP_FMI_LOCATION_H

#include "gallop_cosim.h"

#include <stdbool.h>

/* Path (UTF-8) of a file in the folder that a URI (percent-encoded UTF-8, FMI 2.0) or a plain path
 * (FMI 3.0) gives, for the caller to free; NULL: there is not enough memory. */
char *fmi_location_path(const char *location, const char *name);

/* The co-simulation instance of the resource in a folder; NULL, with a message of
 * GALLOP_COSIM_MESSAGE_SIZE bytes: there is none. */
gallop_cosim *fmi_location_open(const char *location, const char *guid, char *message);

/* True for the categories that the standard names, also those without messages here. */
bool fmi_location_knows_category(const char *category);

#endif
