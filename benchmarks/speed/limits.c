/* Peak rates of one core: multiplications and additions without memory, and reading memory of a
 * given size. */
#define _POSIX_C_SOURCE 199309L
#include "element.h"
#include "solver.h"

#include <time.h>

#define CHAINS                                                                                     \
    14 /* of both kinds together: more than latency times units, and with two constants sixteen    \
          registers */

static double cpu_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Floating-point operations a second, half of them additions, half multiplications; fused ones are
 * not used here, as they are not in the kernel.  `sink` keeps the compiler from leaving the work
 * out. */
GALLOP_API TWO_PATHS double peak_rate(int rounds, double *sink)
{
    lanes sum[CHAINS / 2], product[CHAINS / 2], tiny = {0.0}, one = {0.0};
    for (int k = 0; k < LANES; k++) {
        LANE(tiny, k) = 1e-9;
        LANE(one, k) = 1.0 + 1e-12;
    }
    for (int i = 0; i < CHAINS / 2; i++) {
        sum[i] = one;
        product[i] = one;
    }
    const double began = cpu_seconds();
    for (int round = 0; round < rounds; round++)
        for (int i = 0; i < CHAINS / 2; i++) {
            sum[i] += tiny;
            product[i] *= one;
        }
    const double seconds = cpu_seconds() - began;
    for (int i = 0; i < CHAINS / 2; i++)
        for (int k = 0; k < LANES; k++) *sink += LANE(sum[i], k) + LANE(product[i], k);
    return (double)rounds * CHAINS * LANES / seconds;
}

/* Bytes a second read from an array of `count` numbers, in `rounds` passes. */
GALLOP_API TWO_PATHS double read_rate(const double *y, size_t count, int rounds, double *sink)
{
    lanes sum[8];
    for (int i = 0; i < 8; i++) sum[i] = (lanes){0.0};
    const double began = cpu_seconds();
    for (int round = 0; round < rounds; round++)
        for (size_t i = 0; i + 8 * LANES <= count; i += 8 * LANES)
            for (int k = 0; k < 8; k++) sum[k] += *(const lanes *)(y + i + (size_t)LANES * k);
    const double seconds = cpu_seconds() - began;
    for (int i = 0; i < 8; i++)
        for (int k = 0; k < LANES; k++) *sink += LANE(sum[i], k);
    return (double)rounds * (double)(count * sizeof *y) / seconds;
}
