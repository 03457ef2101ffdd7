/* What the adapters to all versions of FMI share. */
#include "fmi_host.h"

#include "fmi_location.h"
#include "resource_file.h"

#include <stdlib.h>
#include <string.h>

gallop_cosim *fmi_host_open(const char *location, const char *guid, char *message)
{
    gallop_cosim *cosim = NULL;
    char *bytes = NULL;
    size_t size = 0;
    char *path = fmi_location_path(location, "model.bin");
    const char *problem =
        path ? resource_file_read(path, &bytes, &size) : "there is not enough memory";
    free(path);
    if (problem)
        strcpy(message, problem);
    else
        cosim = gallop_cosim_create(bytes, size, guid, message);
    free(bytes);
    return cosim;
}

bool fmi_host_knows_category(const char *category)
{
    static const char *const known[] = {"logEvents",           "logSingularLinearSystems",
                                        "logNonlinearSystems", "logDynamicStateSelection",
                                        "logStatusWarning",    "logStatusDiscard",
                                        "logStatusError",      "logStatusFatal",
                                        "logStatusPending",    "logAll"};
    for (size_t i = 0; category && i < sizeof known / sizeof *known; i++)
        if (strcmp(category, known[i]) == 0) return true;
    return false;
}
