/* Distances of the points of a path from an ellipse, after D. Eberly, "Distance from a Point to an
 * Ellipse, an Ellipsoid, or a Hyperellipsoid" (2013), with Newton's method in place of bisection:
 * the function is convex and decreases, so that iterates from below increase to the root. */
#include "base_math.h"
#include "base_memory.h"
#include "history.h"

#define BLOCK 64           /* points that are iterated together */
#define MAX_ITERATIONS 100 /* a point near the major axis needs at most 70, others about 6 */
#define CONVERGED 1e-15    /* [1] relative change of the root in the last iteration */
#define NEAR_AXIS 1e-12    /* [1] least distance from the major axis over the half minor axis */

/* Up to BLOCK points along the major and the minor axis, from the centre. */
typedef struct {
    double along[BLOCK], across[BLOCK], pull[BLOCK], push[BLOCK], root[BLOCK];
} points;

/* One step of Newton's method; returns how many roots still change. */
INLINE double improve(points *p, int count, double excess)
{
    double changing = 0.0;
    for (int i = 0; i < count; i++) {
        double shifted = p->root[i] + excess, pulled = p->pull[i] / shifted;
        double pushed = p->push[i] / p->root[i], first = pulled * pulled, second = pushed * pushed;
        double slope = first / shifted + second / p->root[i];
        double step = 0.5 * (first + second - 1.0) / slope;
        p->root[i] += step > 0.0 ? step : 0.0;
        changing += step > CONVERGED * p->root[i] ? 1.0 : 0.0;
    }
    return changing;
}

/* Distances of the points; along and across are not negative. */
TWO_PATHS static void distances(points *p, int count, double a, double b, double *distance)
{
    const double ratio = (a / b) * (a / b), excess = ratio - 1.0;
    double inside[BLOCK];
    for (int i = 0; i < count; i++) {
        double x = p->along[i] / a, y = p->across[i] / b;
        inside[i] = x * x + y * y <= 1.0 ? -1.0 : 1.0;
        p->across[i] = p->across[i] > NEAR_AXIS * b ? p->across[i] : NEAR_AXIS * b;
        p->pull[i] = ratio * p->along[i] / a, p->push[i] = p->across[i] / b;
        double from = p->pull[i] - excess; /* each term alone is at most 1 */
        p->root[i] = p->push[i] > from ? p->push[i] : from;
    }
    for (int n = 0; n < MAX_ITERATIONS && improve(p, count, excess) > 0.0; n++) continue;
    for (int i = 0; i < count; i++) {
        double x = ratio * p->along[i] / (p->root[i] + excess) - p->along[i];
        double y = p->across[i] / p->root[i] - p->across[i];
        distance[i] = inside[i] * sqrt(x * x + y * y);
    }
}

int gallop_history_distances(int64_t count, const double *x, const double *y,
                             const double ellipse[GALLOP_ELLIPSE_NUMBERS], double *distance)
{
    if (count < 0 || !base_pointer_usable(x, WORD) || !base_pointer_usable(y, WORD) ||
        !base_pointer_usable(ellipse, WORD) || !base_pointer_usable(distance, WORD))
        return GALLOP_BAD_CALL;
    const double a = ellipse[GALLOP_ELLIPSE_HALF_MAJOR], b = ellipse[GALLOP_ELLIPSE_HALF_MINOR];
    if (!(a >= b && b > 0.0 && isfinite(a))) return GALLOP_BAD_CALL;
    const double c = ellipse[GALLOP_ELLIPSE_COSINE], s = ellipse[GALLOP_ELLIPSE_SINE];
    points p;
    for (int64_t start = 0; start < count; start += BLOCK) {
        int length = count - start < BLOCK ? (int)(count - start) : BLOCK;
        for (int i = 0; i < length; i++) {
            double dx = x[start + i] - ellipse[GALLOP_ELLIPSE_X];
            double dy = y[start + i] - ellipse[GALLOP_ELLIPSE_Y];
            p.along[i] = fabs(dy * c - dx * s), p.across[i] = fabs(dx * c + dy * s);
        }
        distances(&p, length, a, b, distance + start);
    }
    return GALLOP_COMPLETED;
}
