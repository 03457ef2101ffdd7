/* Pointers that exported functions are given, and where memory begins. */
#ifndef GALLOP_BASE_MEMORY_H
#define GALLOP_BASE_MEMORY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define WORD 8 /* [bytes] alignment of all of them, but for arrays of int32_t */
#define NOT_USABLE(pointer) #pointer ", a pointer that is null or not aligned to its type"

/* [bytes] A vector at a multiple of its size lies within one cache line.  Those that lie across two
 * take longer to read and to write, so arrays begin at such places. */
#define VECTOR 32

/* The smallest multiple of a vector that is not below a size. */
static inline size_t base_whole_vectors(size_t bytes)
{
    return (bytes + VECTOR - 1) / VECTOR * VECTOR;
}

/* The first place for a vector in memory that is VECTOR bytes larger than needed. */
static inline void *base_first_vector(void *memory)
{
    return (char *)memory + (VECTOR - (uintptr_t)memory % VECTOR) % VECTOR;
}

static inline bool base_pointer_usable(const void *pointer, size_t alignment)
{
    return pointer && (uintptr_t)pointer % alignment == 0;
}

#endif
