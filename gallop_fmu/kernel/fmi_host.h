/* What the adapters to all versions of FMI share. */
#ifndef GALLOP_FMI_HOST_H
#define GALLOP_FMI_HOST_H

#include "gallop_cosim.h"

#include <stdbool.h>

/* The co-simulation instance of the resource in a folder, as fmi_location_path takes it; NULL, with
 * a message of GALLOP_COSIM_MESSAGE_SIZE bytes: there is none. */
gallop_cosim *fmi_host_open(const char *location, const char *guid, char *message);

/* True for the categories that the standard names, also those without messages here. */
bool fmi_host_knows_category(const char *category);

#endif
