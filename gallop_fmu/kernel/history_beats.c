/* Beats of a history: the share of its envelope's variance that a spectral line explains. */
#include "base_math.h"
#include "base_memory.h"
#include "history.h"

#define UNKNOWNS 5       /* mean, and sine and cosine of the line and of its double */
#define FEWEST_BEATS 1.5 /* in the window */
#define BEATS_APART 0.25 /* lines of the search */
#define STRONGEST 3      /* lines of the search that are fitted, with some beside each */
#define DEPENDENT 1e-12  /* [1] rest of a wave that is a sum of others */

/* The three strongest lines of values times a window, weakest first. */
static void search(const double *values, int64_t count, double strongest[STRONGEST])
{
    double power[STRONGEST];
    const double end = fmax((double)count / 3.0, FEWEST_BEATS + 0.1);
    for (int i = 0; i < STRONGEST; i++) power[i] = -1.0, strongest[i] = 0.0;
    int64_t lines = (int64_t)ceil((end - FEWEST_BEATS) / BEATS_APART);
    for (int64_t i = 0; i < lines; i++) {
        double beats = FEWEST_BEATS + BEATS_APART * (double)i,
               angle = 2.0 * PI * beats / (double)count;
        double step_c, step_s, c = 1.0, s = 0.0, real = 0.0, imaginary = 0.0;
        sine_cosine(angle, &step_s, &step_c);
        for (int64_t k = 0; k < count; k++) {
            real += values[k] * c, imaginary += values[k] * s;
            double turned = c * step_c - s * step_s;
            s = s * step_c + c * step_s, c = turned;
        }
        double own = real * real + imaginary * imaginary;
        for (int place = STRONGEST - 1; place >= 0; place--) {
            if (!(own > power[place])) continue;
            for (int j = 0; j < place; j++)
                power[j] = power[j + 1], strongest[j] = strongest[j + 1];
            power[place] = own, strongest[place] = beats;
            break;
        }
    }
}

static double product(const double *x, const double *y, int64_t count)
{
    double sum = 0.0;
    for (int64_t k = 0; k < count; k++) sum += x[k] * y[k];
    return sum;
}

static void subtract(double factor, const double *x, int64_t count, double *y)
{
    for (int64_t k = 0; k < count; k++) y[k] -= factor * x[k];
}

/* The waves of a line as orthogonal unit vectors; returns how many are not sums of others. */
static int waves(double beats, int64_t count, double *wave)
{
    int found = 0;
    for (int w = 0; w < UNKNOWNS; w++) {
        double *own = wave + found * count;
        for (int64_t k = 0; k < count; k++) {
            double sine, cosine, turns = beats * (double)k / (double)count * (w > 2 ? 2.0 : 1.0);
            sine_cosine(2.0 * PI * turns, &sine, &cosine);
            own[k] = w == 0 ? 1.0 : w % 2 ? cosine : sine;
        }
        double whole = sqrt((double)count);
        for (int repeat = 0; repeat < 2; repeat++) /* the second time for what rounding left */
            for (int j = 0; j < found; j++)
                subtract(product(wave + j * count, own, count), wave + j * count, count, own);
        double rest = sqrt(product(own, own, count));
        if (rest <= DEPENDENT * whole) continue;
        for (int64_t k = 0; k < count; k++) own[k] /= rest;
        found++;
    }
    return found;
}

/* Variance of what the waves of a line leave of values. */
static double variance_left(double beats, const double *values, int64_t count, double *wave)
{
    int found = waves(beats, count, wave);
    double *left = wave + UNKNOWNS * count;
    for (int64_t k = 0; k < count; k++) left[k] = values[k];
    for (int j = 0; j < found; j++)
        subtract(product(wave + j * count, values, count), wave + j * count, count, left);
    double n = (double)count, mean = history_sum(left, count, 0.0, false) / n;
    return history_sum(left, count, mean, true) / n;
}

static double share_of_beats(const history_room *room, const double *envelope, int64_t count)
{
    static const double beside[] = {0.5, 0.97, 1.0, 1.03};
    double n = (double)count, mean = history_sum(envelope, count, 0.0, false) / n;
    double *centred = room->finer[0], *windowed = centred + count, *wave = windowed + count;
    history_window(count, windowed, wave);
    for (int64_t k = 0; k < count; k++) {
        centred[k] = envelope[k] - mean;
        windowed[k] *= centred[k];
    }
    double strongest[STRONGEST], least = INFINITY;
    search(windowed, count, strongest);
    for (int i = 0; i < STRONGEST; i++)
        for (size_t j = 0; j < sizeof beside / sizeof *beside; j++) {
            double beats = strongest[i] * beside[j];
            if (beats >= FEWEST_BEATS)
                least = fmin(least, variance_left(beats, centred, count, wave));
        }
    double centre = history_sum(centred, count, 0.0, false) / n;
    double best = 1.0 - least / (history_sum(centred, count, centre, true) / n);
    return 1.0 - (1.0 - best) * (n - 1.0) / (n - UNKNOWNS - 1.0);
}

int gallop_history_beats(int64_t samples, const double *values, const double *numbers, void *work,
                         double *share)
{
    if (!gallop_history_size(samples) || !base_pointer_usable(values, WORD) ||
        !base_pointer_usable(numbers, WORD) || !base_pointer_usable(work, WORD) ||
        !base_pointer_usable(share, WORD) || !history_has_cycles(numbers, samples))
        return GALLOP_BAD_CALL;
    history_room room = history_room_in(work, samples);
    history_fine fine = history_refine(&room, values, numbers);
    int64_t cycles = history_envelope(&fine, 1, room.envelope);
    *share = cycles > UNKNOWNS + 1 ? share_of_beats(&room, room.envelope, cycles) : 0.0;
    return GALLOP_COMPLETED;
}
