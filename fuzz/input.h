/* Shared by the fuzzing targets: bytes as a source of choices, and a condition that must hold. */
#ifndef FUZZING_INPUT_H
#define FUZZING_INPUT_H

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define REQUIRE(condition)                                                                         \
    do {                                                                                           \
        if (condition) break;                                                                      \
        fprintf(stderr, "%s:%d: not so: %s\n", __FILE__, __LINE__, #condition);                    \
        abort();                                                                                   \
    } while (0)

typedef struct {
    const uint8_t *next, *last;
} input;

static inline uint8_t byte_of(input *in)
{
    return in->next < in->last ? *in->next++ : 0;
}

static inline uint32_t word_of(input *in)
{
    uint32_t low = byte_of(in);
    return low + 256u * byte_of(in);
}

/* A number as it comes, or one that programs stumble over. */
static inline double number_of(input *in)
{
    static const double odd[] = {NAN,   INFINITY, -INFINITY, 0.0,    -0.0, -1.0,
                                 1e300, -1e300,   1e-300,    5e-324, 1e9,  1e16};
    const uint8_t b = byte_of(in);
    double number;
    uint8_t bytes[sizeof number];
    if (b < 48) return odd[b % 12];
    if (b < 160) return (b - 104) / 8.0;
    for (size_t i = 0; i < sizeof bytes; i++) bytes[i] = byte_of(in);
    memcpy(&number, bytes, sizeof number);
    return number;
}

/* Changes bytes as long as there is input: one byte, one of the whole numbers that programs stumble
 * over, a number, or a copy of bytes from elsewhere. */
static inline void edit(input *in, char *bytes, size_t size)
{
    static const uint32_t odd[] = {0,          1,          8,          0x7fffffff,
                                   0x80000000, 0xffffffff, 0x7ff80000, 0xfff00000};
    while (in->next < in->last && size >= 8) {
        const uint8_t how = byte_of(in);
        size_t at = word_of(in) % (how & 8 ? 512 : size); /* often in the head */
        if (at > size - 8) at = size - 8;
        if (how % 4 == 0)
            bytes[at] ^= (char)byte_of(in);
        else if (how % 4 == 1)
            memcpy(bytes + at / 4 * 4, &odd[byte_of(in) % 8], sizeof *odd);
        else if (how % 4 == 2)
            memcpy(bytes + at / 8 * 8, &(double){number_of(in)}, sizeof(double));
        else
            memmove(bytes + at / 8 * 8, bytes + word_of(in) % (size / 8) * 8, 8);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

#endif
