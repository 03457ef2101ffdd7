/* A file of tables.  Every field is validated, even if the checksum matches. */
#include "resource_file.h"

#include "gallop_cosim.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if defined(_WIN32)
#include <windows.h>
#else
#include <fcntl.h>
#include <unistd.h>
#endif

#define MAGIC "GALLOPRF"
#define FORMAT 1

#define MAX_FILE_SIZE (64l << 20)
#define MAX_SECTIONS 1000
#define CHECKED_FROM offsetof(resource_header, size)

uint64_t resource_file_checksum(const void *bytes, size_t size)
{
    const uint8_t *byte = bytes;
    uint64_t hash = 1469598103934665603ULL;
    for (size_t i = 0; i < size; i++) hash = (hash ^ byte[i]) * 1099511628211ULL;
    return hash;
}

/* Only what has a position is read: a pipe or a terminal could block.  (glibc has no stat() that
 * older releases have, too.) */
static FILE *open_regular_file(const char *path)
{
#if defined(_WIN32)
    wchar_t wide[4096];
    if (!MultiByteToWideChar(CP_UTF8, 0, path, -1, wide, 4096)) return NULL;
    return _wfopen(wide, L"rb");
#else
    const int file = open(path, O_RDONLY | O_NONBLOCK);
    if (file < 0) return NULL;
    const bool has_position = lseek(file, 0, SEEK_END) >= 0;
    close(file);
    return has_position ? fopen(path, "rb") : NULL;
#endif
}

const char *resource_file_read(const char *path, char **bytes, size_t *size)
{
    FILE *file = open_regular_file(path);
    if (!file)
        return "resources/model.bin cannot be opened, or is not a regular file; unpack the FMU "
               "again";
    const char *problem = "resources/model.bin cannot be read; unpack the FMU again";
    char *content = NULL;
    if (fseek(file, 0, SEEK_END) == 0) {
        const long length = ftell(file);
        if (length > MAX_FILE_SIZE || length < (long)sizeof(resource_header)) {
            problem = "resources/model.bin is cut off, or too large to be genuine; unpack the FMU "
                      "again";
        } else if ((content = malloc((size_t)length)) == NULL) {
            problem = "there is not enough memory for resources/model.bin";
        } else if (fseek(file, 0, SEEK_SET) == 0) {
            *size = (size_t)length;
            if (fread(content, 1, *size, file) == *size) problem = NULL;
        }
    }
    fclose(file);
    if (problem)
        free(content);
    else
        *bytes = content;
    return problem;
}

int gallop_cosim_seal(void *resource, size_t size)
{
    if (!resource || size < sizeof(resource_header)) return GALLOP_BAD_CALL;
    resource_header head;
    memcpy(&head, resource, sizeof head);
    memcpy(head.magic, MAGIC, sizeof head.magic);
    head.size = size;
    head.format = FORMAT;
    memcpy(resource, &head, sizeof head);
    head.checksum =
        resource_file_checksum((const char *)resource + CHECKED_FROM, size - CHECKED_FROM);
    memcpy(resource, &head, sizeof head);
    return GALLOP_COMPLETED;
}

static const resource_entry *directory_of(const char *bytes)
{
    return (const resource_entry *)(bytes + sizeof(resource_header));
}

/* Each section begins behind the end of the one before and ends within the file. */
static const char *check_directory(const char *bytes, size_t size)
{
    const char *damaged =
        "resources/model.bin is damaged: its sections do not fit; export the scene again";
    const uint32_t sections = ((const resource_header *)bytes)->sections;
    uint64_t end = sizeof(resource_header) + sections * sizeof(resource_entry);
    if (sections > MAX_SECTIONS || end > size) return damaged;
    const resource_entry *entry = directory_of(bytes);
    for (uint32_t i = 0; i < sections; i++) {
        const uint64_t start = entry[i].offset;
        if (start % 8 || start < end || start > size || entry[i].item_size == 0 ||
            entry[i].count > (size - start) / entry[i].item_size)
            return damaged;
        end = start + entry[i].count * entry[i].item_size;
    }
    return NULL;
}

const char *resource_file_check(const char *bytes, size_t size)
{
    const resource_header *head = (const resource_header *)bytes;
    if (size < sizeof *head) return "resources/model.bin is cut off; unpack the FMU again";
    if (memcmp(head->magic, MAGIC, sizeof head->magic) != 0)
        return "resources/model.bin is not a file of this program, or of an older version; export "
               "the scene again";
    if (head->size != size)
        return "resources/model.bin is cut off, or has grown; unpack the FMU again";
    if (head->checksum != resource_file_checksum(bytes + CHECKED_FROM, size - CHECKED_FROM))
        return "resources/model.bin is damaged: its checksum is wrong; unpack the FMU again";
    if (head->format != FORMAT)
        return "resources/model.bin has the format of another version; export the scene again";
    return check_directory(bytes, size);
}

const char *resource_file_find(char *bytes, const resource_kind kind[], int kinds,
                               resource_section found[])
{
    const resource_entry *entry = directory_of(bytes);
    const uint32_t sections = ((const resource_header *)bytes)->sections;
    for (int k = 0; k < kinds; k++) {
        found[k] = (resource_section){NULL, 0, kind[k].item_size};
        for (uint32_t i = 0; i < sections; i++) {
            if (memcmp(entry[i].id, kind[k].id, sizeof entry[i].id) != 0) continue;
            if (found[k].items)
                return "resources/model.bin is damaged: it has a section twice; export the scene "
                       "again";
            if (entry[i].item_size != kind[k].item_size)
                return "a section of resources/model.bin has items of another size; export the "
                       "scene again with this version";
            if (entry[i].count < kind[k].min_count || entry[i].count > kind[k].max_count)
                return "resources/model.bin is damaged: a section has an impossible number of "
                       "items; export the scene again";
            found[k].items = bytes + entry[i].offset;
            found[k].count = (uint32_t)entry[i].count;
        }
        if (!found[k].items && kind[k].min_count > 0) return kind[k].missing;
    }
    return NULL;
}
