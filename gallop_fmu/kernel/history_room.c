/* Memory, sums and extremes of the functions for histories. */
#include "base_math.h"
#include "base_memory.h"
#include "history.h"

#define MAX_DOUBLINGS 4 /* of 5 samples in a cycle, to 64 or more */
#define TABLES 7
#define CHUNK 64 /* values whose extremes are found before their places */

/* Doubles of each table of a room. */
static void lengths(int64_t count, int64_t size, int64_t length[TABLES])
{
    int64_t transform = 2 * LANES * size, finer = 2 * (count << MAX_DOUBLINGS);
    const int64_t each[TABLES] = {
        count, size / 2, size / 2, LANES * count, transform > finer ? transform : finer,
        count, count,
    };
    for (int i = 0; i < TABLES; i++) length[i] = (each[i] + 3) / 4 * 4; /* whole vectors */
}

/* At least twice the number of samples: no line is then between two values of the transform. */
static int64_t transform_size(int64_t count)
{
    int64_t size = 16;
    while (size < 2 * count) size *= 2;
    return size;
}

size_t history_room_size(int64_t count)
{
    int64_t length[TABLES], sum = 0;
    lengths(count, transform_size(count), length);
    for (int i = 0; i < TABLES; i++) sum += length[i];
    return (size_t)sum * sizeof(double) + VECTOR;
}

history_room history_room_in(void *work, int64_t count)
{
    int64_t size = transform_size(count), length[TABLES];
    double *at[TABLES], *next = base_first_vector(work);
    lengths(count, size, length);
    for (int i = 0; i < TABLES; i++) {
        at[i] = next;
        next += length[i];
    }
    lanes *transform = (lanes *)at[4];
    return (history_room){
        .count = count,
        .size = size,
        .window = at[0],
        .cosine = at[1],
        .sine = at[2],
        .windowed = (lanes *)at[3],
        .real = {transform, transform + size / 2},
        .imaginary = {transform + size, transform + 3 * (size / 2)},
        .finer = {at[4], at[4] + (count << MAX_DOUBLINGS)},
        .envelope = at[5],
        .logarithm = at[6],
    };
}

/* Sum of at most 128 values, by eight sums of every eighth. */
INLINE double short_sum(const double *values, int64_t count, double shift, bool squared)
{
    double part[8] = {0.0}, sum = 0.0;
    int64_t whole = count < 8 ? 0 : count - count % 8;
    for (int64_t i = 0; i < whole; i += 8)
        for (int k = 0; k < 8; k++) {
            double x = values[i + k] - shift;
            part[k] += squared ? x * x : x;
        }
    if (whole)
        sum = ((part[0] + part[1]) + (part[2] + part[3])) +
              ((part[4] + part[5]) + (part[6] + part[7]));
    for (int64_t i = whole; i < count; i++) {
        double x = values[i] - shift;
        sum += squared ? x * x : x;
    }
    return sum;
}

TWO_PATHS static double plain_sum(const double *values, int64_t count, double shift)
{
    return short_sum(values, count, shift, false);
}

TWO_PATHS static double square_sum(const double *values, int64_t count, double shift)
{
    return short_sum(values, count, shift, true);
}

double history_sum(const double *values, int64_t count, double shift, bool squared)
{
    if (count <= 128)
        return squared ? square_sum(values, count, shift) : plain_sum(values, count, shift);
    int64_t half = count / 2;
    half -= half % 8;
    return history_sum(values, half, shift, squared) +
           history_sum(values + half, count - half, shift, squared);
}

/* Smallest and largest of CHUNK values, or of fewer. */
INLINE void chunk_extremes(const double *values, int64_t count, double *lowest, double *highest)
{
    if (count < LANES) {
        *lowest = *highest = values[0];
        for (int64_t i = 1; i < count; i++) {
            *lowest = values[i] < *lowest ? values[i] : *lowest;
            *highest = values[i] > *highest ? values[i] : *highest;
        }
        return;
    }
    lanes low = LANES_AT(values), high = low;
    for (int64_t i = LANES; i < count; i += LANES) {
        lanes x = LANES_AT(values + (i + LANES <= count ? i : count - LANES));
        low = PICK(x < low, x, low);
        high = PICK(x > high, x, high);
    }
    *lowest = LANE(low, 0), *highest = LANE(high, 0);
    for (int k = 1; k < LANES; k++) {
        *lowest = LANE(low, k) < *lowest ? LANE(low, k) : *lowest;
        *highest = LANE(high, k) > *highest ? LANE(high, k) : *highest;
    }
}

/* The first of some values that equals `value`, which is one of them. */
static int64_t place_of(const double *values, int64_t count, int64_t from, double value)
{
    while (from < count - 1 && values[from] != value) from++;
    return from;
}

TWO_PATHS static history_range range_of(const double *values, int64_t count)
{
    history_range range = {INFINITY, -INFINITY, 0, 0};
    for (int64_t i = 0; i < count; i += CHUNK) {
        double low, high;
        chunk_extremes(values + i, count - i < CHUNK ? count - i : CHUNK, &low, &high);
        if (low < range.lowest) range.lowest = low, range.lowest_at = i;
        if (high > range.highest) range.highest = high, range.highest_at = i;
    }
    return range;
}

history_range history_range_of(const double *values, int64_t count)
{
    history_range range = range_of(values, count);
    range.lowest_at = place_of(values, count, range.lowest_at, range.lowest);
    range.highest_at = place_of(values, count, range.highest_at, range.highest);
    return range;
}
