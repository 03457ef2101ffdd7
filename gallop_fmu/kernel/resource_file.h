/* A file of tables: header, directory, and one section for each table.
 *
 *     header | entry, entry, ... | items of section 1 | items of section 2 | ...
 *
 * A section is known by its id.  Readers skip ids that they do not know, so that a file can hold
 * more than this version reads; a section that they need must be there, and its items must have
 * the expected size.  Items refer to one another by index, never by address.  Sections begin at
 * multiples of 8 bytes and follow one another in the order of the directory, so that none can
 * reach into another.  Little-endian, 64 bit: the layout of linux64, win64 and darwin64 alike. */
#ifndef GALLOP_RESOURCE_FILE_H
#define GALLOP_RESOURCE_FILE_H

#include <stddef.h>
#include <stdint.h>

typedef struct {
    char magic[8];
    uint64_t checksum, size;   /* of all that follows this field; bytes of the whole file */
    uint32_t format, sections; /* version of the format; entries in the directory */
} resource_header;

typedef struct {
    char id[4];
    uint32_t item_size;     /* bytes */
    uint64_t offset, count; /* from the start of the file; items */
} resource_entry;

/* A section that a reader knows. */
typedef struct {
    char id[5];
    uint32_t item_size;
    uint32_t min_count, max_count; /* min_count 0: the section may be missing */
    const char *missing;           /* the problem if it is */
} resource_kind;

/* A section that was found; no items: it is missing. */
typedef struct {
    char *items;
    uint32_t count, item_size;
} resource_section;

/* FNV-1a, 64 bit. */
uint64_t resource_file_checksum(const void *bytes, size_t size);

/* Reads a regular file, whose path is UTF-8, into memory that the caller frees.  This and the
 * functions below return the problem, a constant text, or NULL. */
const char *resource_file_read(const char *path, char **bytes, size_t *size);

/* Verifies header, checksum and directory; `bytes` must be aligned to 8. */
const char *resource_file_check(const char *bytes, size_t size);

/* Finds the known sections of a verified file. */
const char *resource_file_find(char *bytes, const resource_kind kind[], int kinds,
                               resource_section found[]);

#endif
