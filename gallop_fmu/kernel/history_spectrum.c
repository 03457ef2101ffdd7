/* The largest line in the spectrum of a history: Hann's window, fourfold zero padding, and a
 * parabola through the logarithms of the three largest lines.
 *
 * A fast transform of another length, a power of two, finds the maxima of the spectrum; the padded
 * lines are summed up at these only. */
#include "base_glibc.h"
#include "base_math.h"
#include "history.h"

#define PADDING 4   /* lines in one of the samples alone */
#define MAX_PEAKS 8 /* maxima of the transform that are followed */
#define PEAK_POWER                                                                                 \
    0.5             /* [1] least power of such a maximum over the largest: Ehlich, Zeller 1964,    \
                       bound the spectrum between the values of a transform of twice the           \
                       samples by sqrt(2) times the largest */
#define MAX_MOVES 8 /* from a maximum to the nearest of the padded lines; 2 are usual */
#define ROW 32      /* exact values of a table of cosines */
#define TINY 1e-300 /* keeps a logarithm finite */

/* A line of each of LANES histories with its neighbours. */
typedef struct {
    int64_t line[LANES];
    lanes power[3]; /* below, at and above */
} peaks;

/* Cosines and sines of start + i step, each a product of two of few exact ones. */
TWO_PATHS static void fill_circle(double start, double step, int64_t count, double *cosine,
                                  double *sine)
{
    double c[ROW], s[ROW];
    for (int i = 0; i < ROW; i++) sine_cosine(step * i, s + i, c + i);
    for (int64_t row = 0; row < count; row += ROW) {
        double row_c, row_s;
        int64_t length = count - row < ROW ? count - row : ROW;
        sine_cosine(start + step * (double)row, &row_s, &row_c);
        INDEPENDENT
        for (int64_t i = 0; i < length; i++) {
            cosine[row + i] = row_c * c[i] - row_s * s[i];
            sine[row + i] = row_s * c[i] + row_c * s[i];
        }
    }
}

void history_window(int64_t count, double *window, double *scratch)
{
    fill_circle(-PI, 2.0 * PI / (double)(count - 1), count, window, scratch);
    for (int64_t i = 0; i < count; i++) window[i] = 0.5 + 0.5 * window[i];
}

void history_prepare_lines(const history_room *room)
{
    history_window(room->count, room->window, room->envelope);
    fill_circle(0.0, 2.0 * PI / (double)room->size, room->size / 2, room->cosine, room->sine);
}

/* Four values of a stage, whose transforms of length 4 are turned by three powers of `turn`. */
INLINE void butterfly(const lanes *x, const lanes *y, int64_t apart, lanes *u, lanes *v,
                      int64_t stride, const double turn[2][3])
{
    lanes sum_x = x[0] + x[2 * apart], sum_y = y[0] + y[2 * apart];
    lanes less_x = x[0] - x[2 * apart], less_y = y[0] - y[2 * apart];
    lanes odd_x = x[apart] + x[3 * apart], odd_y = y[apart] + y[3 * apart];
    lanes gap_x = x[apart] - x[3 * apart], gap_y = y[apart] - y[3 * apart];
    const lanes part_x[3] = {less_x + gap_y, sum_x - odd_x, less_x - gap_y};
    const lanes part_y[3] = {less_y - gap_x, sum_y - odd_y, less_y + gap_x};
    u[0] = sum_x + odd_x, v[0] = sum_y + odd_y;
    for (int k = 0; k < 3; k++) {
        u[(k + 1) * stride] = part_x[k] * turn[0][k] + part_y[k] * turn[1][k];
        v[(k + 1) * stride] = part_y[k] * turn[0][k] - part_x[k] * turn[1][k];
    }
}

/* Transform of size / 2 complex values (Stockham, radix 4); returns which buffer has it. */
TWO_PATHS static int transform(const history_room *room)
{
    int64_t length = room->size / 2, stride = 1;
    int from = 0;
    for (; length >= 4; length /= 4, stride *= 4, from = !from) {
        const lanes *x = room->real[from], *y = room->imaginary[from];
        lanes *u = room->real[!from], *v = room->imaginary[!from];
        int64_t quarter = length / 4, step = room->size / length;
        for (int64_t p = 0; p < quarter; p++) {
            double c = room->cosine[p * step], s = room->sine[p * step];
            double c2 = room->cosine[2 * p * step], s2 = room->sine[2 * p * step];
            const double turn[2][3] = {{c, c2, c * c2 - s * s2}, {s, s2, c * s2 + s * c2}};
            for (int64_t q = 0; q < stride; q++)
                butterfly(x + q + stride * p, y + q + stride * p, stride * quarter,
                          u + q + 4 * stride * p, v + q + 4 * stride * p, stride, turn);
        }
    }
    if (length == 2) {
        const lanes *x = room->real[from], *y = room->imaginary[from];
        lanes *u = room->real[!from], *v = room->imaginary[!from];
        for (int64_t q = 0; q < stride; q++) {
            u[q] = x[q] + x[q + stride], v[q] = y[q] + y[q + stride];
            u[q + stride] = x[q] - x[q + stride], v[q + stride] = y[q] - y[q + stride];
        }
        from = !from;
    }
    return from;
}

/* Powers of the real transform, size / 2 + 1 of them, from that of even samples as real parts and
 * odd samples as imaginary parts. */
TWO_PATHS static void untangle(const history_room *room, int from, lanes *power, lanes *largest)
{
    const lanes *x = room->real[from], *y = room->imaginary[from];
    const int64_t half = room->size / 2;
    lanes most = x[0] - x[0];
    for (int64_t k = 0; k <= half; k++) {
        int64_t here = k == half ? 0 : k, there = k == 0 ? 0 : half - k;
        double c = k == half ? -1.0 : room->cosine[k], s = k == half ? 0.0 : room->sine[k];
        lanes even_x = 0.5 * (x[here] + x[there]), even_y = 0.5 * (y[here] - y[there]);
        lanes odd_x = 0.5 * (y[here] + y[there]), odd_y = 0.5 * (x[there] - x[here]);
        lanes real = even_x + odd_x * c + odd_y * s, imaginary = even_y + odd_y * c - odd_x * s;
        power[k] = real * real + imaginary * imaginary;
        most = PICK(power[k] > most, power[k], most);
    }
    *largest = most;
}

/* The padded line next to a value of the transform; neither the first nor the last. */
static int64_t nearest_line(const history_room *room, int64_t value)
{
    int64_t lines = PADDING * room->count;
    int64_t line = (int64_t)nearest((double)value * (double)lines / (double)room->size);
    return line < 1 ? 1 : line > lines / 2 - 1 ? lines / 2 - 1 : line;
}

/* The padded lines next to the maxima of a transform, from the largest on; returns how many. */
static int maxima(const history_room *room, const lanes *power, int lane, double largest,
                  int64_t line[MAX_PEAKS])
{
    const int64_t half = room->size / 2;
    double found[MAX_PEAKS];
    int count = 0;
    for (int64_t k = 0; k <= half; k++) {
        double here = LANE(power[k], lane);
        if (here < PEAK_POWER * largest) continue;
        if ((k > 0 && LANE(power[k - 1], lane) > here) ||
            (k < half && LANE(power[k + 1], lane) > here))
            continue;
        int place = count;
        while (place > 0 && found[place - 1] < here) place--;
        if (place == MAX_PEAKS) continue;
        count += count < MAX_PEAKS;
        for (int j = count - 1; j > place; j--) {
            found[j] = found[j - 1];
            line[j] = line[j - 1];
        }
        found[place] = here;
        line[place] = nearest_line(room, k);
    }
    return count;
}

/* Powers of the padded lines and their neighbours, each summed up over the samples. */
TWO_PATHS static void sum_lines(const history_room *room, peaks *at)
{
    lanes c[3], s[3], step_c[3], step_s[3], real[3], imaginary[3];
    const double angle = 2.0 * PI / (double)(PADDING * room->count);
    for (int j = 0; j < 3; j++) {
        for (int k = 0; k < LANES; k++) {
            double sine, cosine;
            sine_cosine(angle * (double)(at->line[k] + j - 1), &sine, &cosine);
            LANE(step_c[j], k) = cosine, LANE(step_s[j], k) = sine;
        }
        real[j] = imaginary[j] = s[j] = step_c[j] - step_c[j];
        c[j] = s[j] + 1.0;
    }
    for (int64_t i = 0; i < room->count; i++) {
        lanes x = room->windowed[i];
        for (int j = 0; j < 3; j++) {
            real[j] += x * c[j];
            imaginary[j] += x * s[j];
            lanes turned = c[j] * step_c[j] - s[j] * step_s[j];
            s[j] = s[j] * step_c[j] + c[j] * step_s[j];
            c[j] = turned;
        }
    }
    for (int j = 0; j < 3; j++) at->power[j] = real[j] * real[j] + imaginary[j] * imaginary[j];
}

/* Go to larger neighbours until there are none. */
static void climb(const history_room *room, peaks *at)
{
    const int64_t last = PADDING * room->count / 2 - 1;
    for (int move = 0; move < MAX_MOVES; move++) {
        bool moved = false;
        sum_lines(room, at);
        for (int k = 0; k < LANES; k++) {
            double below = LANE(at->power[0], k), here = LANE(at->power[1], k);
            double above = LANE(at->power[2], k);
            int way = below > here && below >= above ? -1 : above > here;
            int64_t next = at->line[k] + way;
            if (way == 0 || next < 1 || next > last) continue;
            at->line[k] = next;
            moved = true;
        }
        if (!moved) return;
    }
    sum_lines(room, at);
}

/* The place of the maximum of a parabola through three logarithms; NaN without a maximum. */
static double interpolated(double line, double below, double top, double above)
{
    below = log(sqrt(below) + TINY), top = log(sqrt(top) + TINY), above = log(sqrt(above) + TINY);
    double curvature = below - 2.0 * top + above;
    /* no maximum: motion at the ends only, where the window is zero */
    return curvature < 0.0 ? line + 0.5 * (below - above) / curvature : NAN;
}

/* Samples less their mean, over their range, times the window. */
TWO_PATHS static void fill_windowed(const history_room *room, int histories,
                                    const double *const values[], double *const numbers[])
{
    for (int k = 0; k < LANES; k++) {
        const int h = k < histories ? k : 0;
        const double *own = values[h], *number = numbers[h];
        double mean = number[GALLOP_HISTORY_MEAN];
        double scale = 1.0 / (number[GALLOP_HISTORY_HIGHEST] - number[GALLOP_HISTORY_LOWEST]);
        for (int64_t i = 0; i < room->count; i++)
            LANE(room->windowed[i], k) = (own[i] - mean) * scale * room->window[i];
    }
}

TWO_PATHS static void fill_transform(const history_room *room)
{
    lanes zero = room->windowed[0] - room->windowed[0];
    for (int64_t i = 0; i < room->size / 2; i++) {
        room->real[0][i] = 2 * i < room->count ? room->windowed[2 * i] : zero;
        room->imaginary[0][i] = 2 * i + 1 < room->count ? room->windowed[2 * i + 1] : zero;
    }
}

void history_lines(const history_room *room, int histories, const double *const values[],
                   double *const numbers[])
{
    int64_t line[LANES][MAX_PEAKS];
    int count[LANES], most = 1;
    lanes largest;
    fill_windowed(room, histories, values, numbers);
    fill_transform(room);
    int from = transform(room);
    /* one value longer than the buffer: the last one overwrites the first of the next buffer, which
     * is no longer needed then */
    lanes *power = room->real[!from];
    untangle(room, from, power, &largest);
    for (int k = 0; k < LANES; k++) {
        count[k] = maxima(room, power, k, LANE(largest, k), line[k]);
        most = count[k] > most ? count[k] : most;
    }

    double best[LANES] = {0.0};
    for (int p = 0; p < most; p++) {
        peaks at;
        for (int k = 0; k < LANES; k++) at.line[k] = count[k] ? line[k][p < count[k] ? p : 0] : 1;
        climb(room, &at);
        for (int k = 0; k < histories; k++) {
            double top = LANE(at.power[1], k);
            if (!(top > best[k])) continue;
            best[k] = top;
            numbers[k][GALLOP_HISTORY_FREQUENCY] =
                interpolated((double)at.line[k], LANE(at.power[0], k), top, LANE(at.power[2], k)) /
                (double)(PADDING * room->count);
        }
    }
}
