/* The folder of an FMU's resources, which FMI 2.0 gives as a URI. */
#ifndef GALLOP_FMI_LOCATION_H
#define GALLOP_FMI_LOCATION_H

/* Path (UTF-8) of a file in the folder that a URI (percent-encoded UTF-8) or a plain path gives,
 * for the caller to free; NULL: there is not enough memory. */
char *fmi_location_path(const char *location, const char *name);

#endif
