/* Pointers that exported functions are given. */
#ifndef GALLOP_BASE_MEMORY_H
#define GALLOP_BASE_MEMORY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define WORD 8 /* [bytes] alignment of all of them, but for arrays of int32_t */
#define NOT_USABLE(pointer) #pointer ", a pointer that is null or not aligned to its type"

static inline bool base_pointer_usable(const void *pointer, size_t alignment)
{
    return pointer && (uintptr_t)pointer % alignment == 0;
}

#endif
