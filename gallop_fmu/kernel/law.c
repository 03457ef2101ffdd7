/* Quantities in time: value and first two derivatives of a law. */
#include "base_math.h"
#include "law.h"

#include <math.h>

law law_from(const gallop_law *of, const double *number)
{
    law l = {*of, NULL, NULL};
    if (of->kind == GALLOP_LAW_TABLE) {
        l.time = number + of->first;
        l.value = l.time + of->count;
    }
    return l;
}

/* s(x) = x^3 (10 - 15 x + 6 x^2) clamped to [0, 1], with zero slope and curvature at both ends. */
static double smooth_step(double x, int derivative)
{
    if (x <= 0.0) return 0.0;
    if (x >= 1.0) return derivative == 0 ? 1.0 : 0.0;
    if (derivative == 0) return x * x * x * (10.0 + x * (-15.0 + 6.0 * x));
    if (derivative == 1) return 30.0 * x * x * (1.0 + x * (-2.0 + x));
    return 60.0 * x * (1.0 + x * (-3.0 + 2.0 * x));
}

/* A flank that takes less is a jump: derivatives of it are none that a span could follow, and could
 * overflow. */
#define SHORTEST_FLANK 1e-9 /* [s] */

static double flank(double t, double start, double duration, int derivative)
{
    if (duration < SHORTEST_FLANK) return derivative == 0 && t >= start ? 1.0 : 0.0;
    double scale = derivative == 0 ? 1.0
                 : derivative == 1 ? 1.0 / duration
                                   : 1.0 / (duration * duration);
    return scale * smooth_step((t - start) / duration, derivative);
}

int law_point_before(const double *time, int count, double t)
{
    int low = 0, high = count - 1;
    while (high - low > 1) {
        int middle = (low + high) / 2;
        if (t < time[middle])
            high = middle;
        else
            low = middle;
    }
    return low;
}

double law_fold(const double *time, int count, double t)
{
    const double first = time[0], last = time[count - 1], period = last - first;
    const double folded = t - period * floor((t - first) / period);
    return folded >= first && folded < last ? folded : first; /* round-off */
}

static double table(const law *l, double t, int derivative)
{
    const double *x = l->time, *y = l->value;
    const int last = l->of.count - 1;
    if (l->of.repeat)
        t = law_fold(x, l->of.count, t);
    else if (t <= x[0] || last == 0)
        return derivative == 0 ? y[0] : 0.0;
    else if (t >= x[last])
        return derivative == 0 ? y[last] : 0.0;
    const int low = law_point_before(x, l->of.count, t), high = low + 1;
    double gap = x[high] - x[low], slope = (y[high] - y[low]) / gap;
    if (derivative == 0) return y[low] + slope * (t - x[low]);
    return derivative == 1 && gap >= SHORTEST_FLANK ? slope : 0.0;
}

/* The law (derivative 0) or its first or second time derivative. */
static double evaluate(const law *l, double t, int derivative)
{
    const double initial = derivative == 0 ? l->of.initial : 0.0;
    switch (l->of.kind) {
    case GALLOP_LAW_PULSE: {
        double shape = flank(t, l->of.start, l->of.rise, derivative);
        if (isfinite(l->of.fall_start)) shape -= flank(t, l->of.fall_start, l->of.fall, derivative);
        return initial + (l->of.peak - l->of.initial) * shape;
    }
    case GALLOP_LAW_HARMONIC: {
        double omega = 2.0 * PI * l->of.frequency, angle = omega * (t - l->of.start) + l->of.phase;
        if (t < l->of.start) return initial;
        double wave = derivative == 0 ? sin(angle)
                    : derivative == 1 ? omega * cos(angle)
                                      : -omega * omega * sin(angle);
        return initial + l->of.amplitude * wave;
    }
    case GALLOP_LAW_TABLE: return table(l, t, derivative);
    default: return initial;
    }
}

bool law_always_zero(const law *l)
{
    bool zero = l->of.initial == 0.0;
    if (l->of.kind == GALLOP_LAW_PULSE) zero = zero && l->of.peak == 0.0;
    if (l->of.kind == GALLOP_LAW_HARMONIC) zero = zero && l->of.amplitude == 0.0;
    if (l->of.kind != GALLOP_LAW_TABLE) return zero;
    for (int i = 0; i < l->of.count; i++)
        if (l->value[i] != 0.0) return false;
    return true;
}

double law_value(const law *l, double t)
{
    return evaluate(l, t, 0);
}

double law_rate(const law *l, double t)
{
    return evaluate(l, t, 1);
}

double law_second(const law *l, double t)
{
    return evaluate(l, t, 2);
}

/* The first point that is not before t, or the last one. */
static int point_from(const double *time, int count, double t)
{
    int low = -1, high = count - 1; /* time[low] < t <= time[high] */
    while (high - low > 1) {
        const int middle = (low + high) / 2;
        if (time[middle] < t)
            low = middle;
        else
            high = middle;
    }
    return high;
}

/* Folded times and their periods add up to t but for round-off: the next point may be wanted. */
double law_next_time(const double *time, int count, bool repeat, double t)
{
    const double period = time[count - 1] - time[0];
    if (!repeat) return time[count - 1] >= t ? time[point_from(time, count, t)] : INFINITY;
    double start = period * floor((t - time[0]) / period);
    int next = point_from(time, count, t - start);
    for (int tries = 0; tries < count; tries++) {
        if (start + time[next] >= t) return start + time[next];
        if (next < count - 1) {
            next++;
        } else {
            next = 1; /* the last time of a period is the first of the one after */
            start += period;
        }
    }
    return INFINITY; /* the times are lost in the round-off of t */
}

double law_next_kink(const law *l, double t)
{
    double next = INFINITY;
    if (l->of.kind == GALLOP_LAW_HARMONIC && l->of.start >= t) next = l->of.start;
    if (l->of.kind == GALLOP_LAW_PULSE) {
        const double kink[4] = {l->of.start, l->of.start + l->of.rise, l->of.fall_start,
                                l->of.fall_start + l->of.fall};
        for (int i = 0; i < 4; i++)
            if (kink[i] >= t) next = fmin(next, kink[i]);
    }
    if (l->of.kind == GALLOP_LAW_TABLE && l->of.count > 0)
        next = law_next_time(l->time, l->of.count, l->of.repeat != 0, t);
    return next;
}
