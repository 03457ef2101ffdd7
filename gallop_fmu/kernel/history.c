/* Numbers of histories: size, mean and deviation; the other files have the rest. */
#include "history.h"
#include "base_math.h"
#include "base_memory.h"

#include <float.h>

#define SAME_VALUE 1e-12 /* [1] range over size of a history without motion */
#define MIN_SAMPLES 8    /* of a spectral line */

/* The numbers up to GALLOP_HISTORY_DEVIATION. */
static void set_sizes(const double *values, int64_t count, double *numbers)
{
    for (int i = 0; i <= GALLOP_HISTORY_DEVIATION; i++) numbers[i] = NAN;
    for (int64_t i = 0; i < count; i++)
        if (isnan(values[i])) return;

    history_range range = history_range_of(values, count);
    numbers[GALLOP_HISTORY_LOWEST] = range.lowest;
    numbers[GALLOP_HISTORY_HIGHEST] = range.highest;
    double n = (double)count, mean = history_sum(values, count, 0.0, false) / n;
    numbers[GALLOP_HISTORY_MEAN] = mean;
    numbers[GALLOP_HISTORY_DEVIATION] = sqrt(history_sum(values, count, mean, true) / n);
}

/* The same, the others NaN, and no blocks. */
static void start_numbers(const double *values, int64_t count, double *numbers)
{
    for (int i = 0; i < GALLOP_HISTORY_NUMBERS; i++) numbers[i] = NAN;
    numbers[GALLOP_HISTORY_BLOCKS] = 0.0;
    set_sizes(values, count, numbers);
}

/* Whether a history moves, and its range is finite. */
static bool moves(const double *numbers)
{
    double low = numbers[GALLOP_HISTORY_LOWEST], high = numbers[GALLOP_HISTORY_HIGHEST];
    double range = high - low;
    return range > SAME_VALUE * fmax(1.0, fmax(-low, high)) && range <= DBL_MAX;
}

/* Lines and cycles of up to LANES histories. */
static void describe(const history_room *room, int histories, const double *const values[],
                     double even, double *const numbers[])
{
    history_lines(room, histories, values, numbers);
    for (int k = 0; k < histories && !isnan(even); k++)
        if (history_has_cycles(numbers[k], room->count))
            history_cycles(room, values[k], even, numbers[k]);
}

size_t gallop_history_size(int64_t samples)
{
    return samples < 1 || samples > GALLOP_HISTORY_MAX_SAMPLES ? 0 : history_room_size(samples);
}

int gallop_history_numbers(int64_t samples, int32_t histories, const double *values, double even,
                           void *work, double *numbers)
{
    if (!gallop_history_size(samples) || histories < 1 || !base_pointer_usable(values, WORD) ||
        !base_pointer_usable(work, WORD) || !base_pointer_usable(numbers, WORD))
        return GALLOP_BAD_CALL;
    history_room room = history_room_in(work, samples);
    if (samples >= MIN_SAMPLES) history_prepare_lines(&room);

    const double *moving[LANES];
    double *own[LANES];
    int found = 0;
    for (int64_t i = 0; i < histories; i++) {
        moving[found] = values + i * samples;
        own[found] = numbers + i * GALLOP_HISTORY_NUMBERS;
        start_numbers(moving[found], samples, own[found]);
        found += samples >= MIN_SAMPLES && moves(own[found]);
        if (found == LANES || (found && i == histories - 1)) {
            describe(&room, found, moving, even, own);
            found = 0;
        }
    }
    return GALLOP_COMPLETED;
}

int gallop_history_sizes(int64_t samples, int32_t histories, const double *values, double *sizes)
{
    if (samples < 1 || histories < 1 || !base_pointer_usable(values, WORD) ||
        !base_pointer_usable(sizes, WORD))
        return GALLOP_BAD_CALL;
    for (int64_t i = 0; i < histories; i++)
        set_sizes(values + i * samples, samples, sizes + i * (GALLOP_HISTORY_DEVIATION + 1));
    return GALLOP_COMPLETED;
}

int64_t gallop_history_energy_line(int64_t lines, int32_t spectra, const double *values,
                                   double share)
{
    if (lines < 1 || spectra < 1 || !base_pointer_usable(values, WORD)) return -1;
    double whole = 0.0;
    for (int pass = 0; pass < 2; pass++) { /* the whole energy, then a share of it */
        double above = 0.0;
        for (int64_t k = lines - 1; k >= 0; k--) {
            double squares = 0.0;
            for (int64_t i = 0; i < spectra; i++) {
                const double *line = values + 2 * (i * lines + k);
                squares += line[0] * line[0] + line[1] * line[1];
            }
            above += squares * ((double)k * (double)k);
            if (pass && above >= share * whole) return k;
        }
        whole = above;
    }
    return 0;
}
