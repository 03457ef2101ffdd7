/* The folder of an FMU's resources. */
#include "fmi_location.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#if defined(_WIN32)
#define HAS_DRIVES true
#else
#define HAS_DRIVES false
#endif

static int hexadecimal_digit(char c)
{
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

static bool is_letter(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

/* C: or C| at the start */
static bool starts_with_drive(const char *text)
{
    return is_letter(text[0]) && (text[1] == ':' || text[1] == '|');
}

static bool is_uri(const char *location)
{
    const char *scheme = "file:";
    for (int i = 0; scheme[i]; i++)
        if (location[i] != scheme[i] && location[i] != scheme[i] - 'a' + 'A') return false;
    return true;
}

/* Decodes percent-encoded bytes in place, but for %00, which a path cannot hold. */
static void decode(char *text)
{
    char *to = text;
    for (const char *from = text; *from; to++) {
        const int high = *from == '%' ? hexadecimal_digit(from[1]) : -1;
        const int low = high >= 0 ? hexadecimal_digit(from[2]) : -1;
        const bool encoded = low >= 0 && 16 * high + low > 0;
        *to = encoded ? (char)(16 * high + low) : *from;
        from += encoded ? 3 : 1;
    }
    *to = '\0';
}

/* The path in what follows file:, for file:///x, file://localhost/x, file:/x; with drives
 * file:///C:/x, file:///C|/x, and the faulty file://C:/x.  With drives a host is a server, whose
 * path begins with //. */
static const char *file_part(const char *from, bool drives)
{
    if (strncmp(from, "//", 2) == 0) {
        const char *host = from + 2, *end = host;
        while (*end && *end != '/') end++;
        const bool is_local =
            end == host || (end - host == 9 && strncmp(host, "localhost", 9) == 0);
        if (drives && starts_with_drive(host))
            from = host;
        else if (is_local || !drives)
            from = end;
    }
    return drives && from[0] == '/' && starts_with_drive(from + 1) ? from + 1 : from;
}

/* As fmi_location_path, with or without drives. */
static char *path_of(const char *location, const char *name, bool drives)
{
    const bool uri = is_uri(location);
    char *path = malloc(strlen(location) + strlen(name) + 2);
    if (!path) return NULL;
    strcpy(path, location);
    if (uri) {
        decode(path);
        const char *file = file_part(path + strlen("file:"), drives);
        memmove(path, file, strlen(file) + 1);
        if (drives && starts_with_drive(path)) path[1] = ':';
    }
    const size_t length = strlen(path);
    if (length > 0 && path[length - 1] != '/') strcat(path, "/");
    strcat(path, name);
    return path;
}

char *fmi_location_path(const char *location, const char *name)
{
    return path_of(location, name, HAS_DRIVES);
}
