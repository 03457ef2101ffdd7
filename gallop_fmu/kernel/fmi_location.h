/* The folder of an FMU's resources. */
#ifndef GALLOP_FMI_LOCATION_H
#define GALLOP_FMI_LOCATION_H

/* Path (UTF-8) of a file in the folder that a URI (percent-encoded UTF-8, FMI 2.0) or a plain path
 * (FMI 3.0) gives, for the caller to free; NULL: there is not enough memory. */
char *fmi_location_path(const char *location, const char *name);

#endif
