/* Changes from cycle to cycle of a history: its envelope, and what does not repeat. */
#include "base_glibc.h"
#include "base_math.h"
#include "history.h"

#define SAMPLES_PER_CYCLE 64 /* least number for extremes by a parabola */
#define MIN_PERIOD 5.0       /* [samples] of a cycle that is described */
#define MIN_SAMPLES 8        /* of a history that is interpolated */
#define MAX_BLOCKS 18        /* of the trend, unless it takes blocks of more than MAX_CYCLES */
#define MAX_CYCLES 4         /* in a block */
#define MIN_BLOCKS 3         /* one for each third */
#define OVERLAP 0.25         /* [cycles] of blocks */
#define TINY 1e-300          /* keeps a logarithm finite */

bool history_has_cycles(const double *numbers, int64_t samples)
{
    double frequency = numbers[GALLOP_HISTORY_FREQUENCY];
    return numbers[GALLOP_HISTORY_HIGHEST] > numbers[GALLOP_HISTORY_LOWEST] &&
           frequency * MIN_PERIOD <= 1.0 && frequency * (double)samples >= 1.0;
}

/* `values` less `middle`, times `scale`. */
TWO_PATHS static void scaled(const double *values, int64_t count, double middle, double scale,
                             double *out)
{
    for (int64_t i = 0; i < count; i++) out[i] = (values[i] - middle) / scale;
}

/* Every value from the third to the fourth last, each before the one midway to the next: by the
 * polynomial through six values. */
TWO_PATHS static void doubled(const double *y, int64_t count, double *out)
{
    INDEPENDENT
    for (int64_t i = 0; i < count - 5; i++) {
        double outer = y[i] + y[i + 5], next = y[i + 1] + y[i + 4], inner = y[i + 2] + y[i + 3];
        out[2 * i] = y[i + 2];
        out[2 * i + 1] = (3.0 * outer - 25.0 * next + 150.0 * inner) / 256.0;
    }
}

history_fine history_refine(const history_room *room, const double *values, const double *numbers)
{
    double low = numbers[GALLOP_HISTORY_LOWEST], high = numbers[GALLOP_HISTORY_HIGHEST];
    double period = 1.0 / numbers[GALLOP_HISTORY_FREQUENCY];
    int64_t count = room->count;
    int from = 0;
    scaled(values, count, 0.5 * low + 0.5 * high, 0.5 * (high - low), room->finer[from]);
    while (period < SAMPLES_PER_CYCLE && count > MIN_SAMPLES) {
        doubled(room->finer[from], count, room->finer[!from]);
        count = 2 * (count - 5);
        period *= 2.0;
        from = !from;
    }
    return (history_fine){room->finer[from], count, period};
}

/* The maximum at a place of a block, of values times `sign`: that of the parabola through it and
 * its neighbours if it lies between. */
static double peak(const double *y, int64_t count, int64_t at, double sign)
{
    double largest = sign * y[at];
    at = at < 1 ? 1 : at > count - 2 ? count - 2 : at;
    double below = sign * y[at - 1], top = sign * y[at], above = sign * y[at + 1];
    double curvature = below - 2.0 * top + above, slope = 0.5 * (above - below);
    bool is_inside = curvature < 0.0 && fabs(slope) <= -curvature;
    double refined = is_inside ? top - 0.5 * slope * slope / curvature : top;
    return refined > largest ? refined : largest;
}

int64_t history_envelope(const history_fine *fine, int cycles, double *envelope)
{
    int64_t size = (int64_t)ceil((cycles + OVERLAP) * fine->period) + 1;
    double step = cycles * fine->period;
    double blocks = ceil(((double)(fine->count - size) + 0.5) / step);
    if (!(blocks >= MIN_BLOCKS)) return 0;
    for (int64_t b = 0; b < (int64_t)blocks; b++) {
        const double *block = fine->values + (int64_t)((double)b * step);
        history_range range = history_range_of(block, size);
        envelope[b] = 0.5 * (peak(block, size, range.highest_at, 1.0) +
                             peak(block, size, range.lowest_at, -1.0));
    }
    return (int64_t)blocks;
}

/* First value of a third, of which the first ones are longer. */
static int64_t start_of_third(int64_t count, int third)
{
    return third * (count / 3) + (third < count % 3 ? third : count % 3);
}

/* Share of the variance of equally spaced values that a parabola explains. */
static double share_of_parabola(const double *values, int64_t count)
{
    double n = (double)count, mean = history_sum(values, count, 0.0, false) / n, mean_square = 0.0;
    for (int64_t i = 0; i < count; i++) {
        double x = -1.0 + 2.0 * (double)i / (n - 1.0);
        mean_square += x * x / n;
    }
    double by[2] = {0.0, 0.0}, size[2] = {0.0, 0.0}, variance = 0.0;
    for (int64_t i = 0; i < count; i++) {
        double x = -1.0 + 2.0 * (double)i / (n - 1.0), own = values[i] - mean;
        const double form[2] = {x, x * x - mean_square}; /* orthogonal to 1 and to each other */
        for (int f = 0; f < 2; f++) {
            by[f] += form[f] * own;
            size[f] += form[f] * form[f];
        }
        variance += own * own;
    }
    return (by[0] * by[0] / size[0] + by[1] * by[1] / size[1]) / variance;
}

/* Logarithms of the envelope of the whole window; returns the cycles in a block. */
static int trend(const history_room *room, const history_fine *fine, double *numbers)
{
    int64_t fitting = (int64_t)((double)fine->count / (MAX_BLOCKS * fine->period));
    int cycles = fitting < 1 ? 1 : fitting > MAX_CYCLES ? MAX_CYCLES : (int)fitting;
    int64_t blocks = history_envelope(fine, cycles, room->envelope);
    numbers[GALLOP_HISTORY_BLOCKS] = (double)blocks;
    if (!blocks) return cycles;

    numbers[GALLOP_HISTORY_SPACING] = cycles * fine->period / (double)(fine->count - 1);
    double *logs = room->logarithm;
    for (int64_t b = 0; b < blocks; b++)
        logs[b] = log(room->envelope[b] > TINY ? room->envelope[b] : TINY);
    for (int third = 0; third < 3; third++) {
        int64_t start = start_of_third(blocks, third), stop = start_of_third(blocks, third + 1);
        numbers[GALLOP_HISTORY_LOG_1 + third] =
            history_sum(logs + start, stop - start, 0.0, false) / (double)(stop - start);
    }
    numbers[GALLOP_HISTORY_TREND] = share_of_parabola(logs, blocks);
    return cycles;
}

/* Evenness of the envelope, with longer blocks if single cycles differ.  The room has the envelope
 * of blocks of `done` cycles. */
static void evenness(const history_room *room, const history_fine *fine, int done, double even,
                     double *numbers)
{
    int64_t blocks = (int64_t)numbers[GALLOP_HISTORY_BLOCKS];
    double least = INFINITY;
    for (int cycles = 1; cycles <= MAX_CYCLES && least > even; cycles++) {
        bool fits = (double)fine->count >= (3.0 * cycles + OVERLAP) * fine->period + 2.0;
        if (cycles > 1 && !fits) break;
        if (cycles != done) blocks = history_envelope(fine, cycles, room->envelope);
        if (!blocks) break;
        done = cycles;
        history_range range = history_range_of(room->envelope, blocks);
        if (cycles == 1) numbers[GALLOP_HISTORY_FALL] = 1.0 - range.lowest / range.highest;
        double mean = history_sum(room->envelope, blocks, 0.0, false) / (double)blocks;
        if (fits) least = fmin(least, (range.highest - range.lowest) / mean);
    }
    numbers[GALLOP_HISTORY_RANGE] = least;
}

/* Differences from one period to the next: cubic interpolation in four samples, at `share` between
 * the second and the third. */
TWO_PATHS static void differences(const double *y, int64_t count, int64_t whole, double share,
                                  double *out)
{
    INDEPENDENT
    for (int64_t i = 0; i < count; i++) {
        double before = y[whole + i], here = y[whole + i + 1];
        double after = y[whole + i + 2], beyond = y[whole + i + 3];
        double third = 3.0 * (here - after) + beyond - before;
        double second = 2.0 * before - 5.0 * here + 4.0 * after - beyond;
        double later = here + 0.5 * share * (after - before + share * (second + share * third));
        out[i] = later - y[i + 1];
    }
}

static void hidden_part(const history_room *room, const history_fine *fine, double *numbers)
{
    int64_t whole = (int64_t)fine->period, count = fine->count - whole - 3;
    double *difference = room->finer[fine->values == room->finer[0]];
    differences(fine->values, count, whole, fine->period - (double)whole, difference);
    for (int third = 0; third < 3; third++) {
        int64_t start = start_of_third(count, third), stop = start_of_third(count, third + 1);
        double squares = history_sum(difference + start, stop - start, 0.0, true);
        numbers[GALLOP_HISTORY_HIDDEN_1 + third] = sqrt(0.5 * squares / (double)(stop - start));
    }
}

void history_cycles(const history_room *room, const double *values, double even, double *numbers)
{
    history_fine fine = history_refine(room, values, numbers);
    int cycles = trend(room, &fine, numbers);
    if (numbers[GALLOP_HISTORY_BLOCKS] == 0.0) return;
    evenness(room, &fine, cycles, even, numbers);
    hidden_part(room, &fine, numbers);
    int64_t half = (fine.count + 1) / 2;
    history_range first = history_range_of(fine.values, half);
    history_range second = history_range_of(fine.values + half, fine.count - half);
    numbers[GALLOP_HISTORY_HALF_1] = 0.5 * (first.highest - first.lowest);
    numbers[GALLOP_HISTORY_HALF_2] = 0.5 * (second.highest - second.lowest);
}
