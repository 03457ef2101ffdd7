/* Sine, cosine and arctangent without branches and tables, so that a compiler can evaluate several
 * sections at once, and the hypotenuse: every platform gives the same bits.  Errors are below 2
 * units in the last place (tests/unit). */
#ifndef GALLOP_BASE_MATH_H
#define GALLOP_BASE_MATH_H

#include "base_arithmetic.h"

#include <math.h>

#define PI 3.14159265358979323846

/* Before a loop whose iterations are independent although its arrays come through a structure. */
#if defined(__clang__)
#define INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#elif defined(__GNUC__)
#define INDEPENDENT _Pragma("GCC ivdep")
#else
#define INDEPENDENT
#endif

/* Nearest whole number for |x| < 2^51: adding 1.5 * 2^52 leaves no room for a fraction. */
static inline double nearest(double x)
{
    const double shift = 6755399441055744.0;
    return (x + shift) - shift;
}

/* x = k pi/2 + r with |r| <= pi/4 (pi/2 in three parts), then polynomials in r: those of k_sin and
 * k_cos in fdlibm (Sun Microsystems). */
static inline void sine_cosine(double x, double *sine, double *cosine)
{
    double k = nearest(x * 0.63661977236758134308);
    double r = ((x - k * 1.57079632673412561417) - k * 6.07710050630396597660e-11) -
               k * 2.02226624879595063154e-21;
    double z = r * r;
    double s =
        r +
        r * z *
            (-1.66666666666666324348e-01 +
             z * (8.33333333332248946124e-03 +
                  z * (-1.98412698298579493134e-04 +
                       z * (2.75573137070700676789e-06 +
                            z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)))));
    double c =
        1.0 - 0.5 * z +
        z * z *
            (4.16666666666666019037e-02 +
             z * (-1.38888888888741095749e-03 +
                  z * (2.48015872894767294178e-05 +
                       z * (-2.75573143513906633035e-07 +
                            z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11)))));
    double turn = k - 4.0 * nearest(0.25 * k),
           quarter = turn < 0.0 ? turn + 4.0 : turn; /* 0, 1, 2, 3 */
    double odd = (quarter - 2.0) * (quarter - 2.0), middle = (quarter - 1.5) * (quarter - 1.5);
    double first = odd == 1.0 ? c : s, second = odd == 1.0 ? s : c;
    *sine = quarter > 1.5 ? -first : first;
    *cosine = middle < 0.5 ? -second : second;
}

/* atan2(y, x): the smaller over the larger is at most 1, folded about tan(pi/8); rational function
 * of S. Moshier (Cephes).  atan2(0, 0) = 0. */
static inline double arctangent(double y, double x)
{
    double ay = y < 0.0 ? -y : y, ax = x < 0.0 ? -x : x;
    double low = ay < ax ? ay : ax, high = ay < ax ? ax : ay;
    double fold = low > 0.41421356237309503 * high ? 1.0 : 0.0;
    double t = (low - fold * high) / (high + fold * low + 1e-300), z = t * t;
    double p = z * (-6.485021904942025371773e1 +
                    z * (-1.228866684490136173410e2 +
                         z * (-7.500855792314704667340e1 +
                              z * (-1.615753718733365076637e1 + z * -8.750608600031904122785e-1))));
    double q = 1.945506571482613964425e2 +
               z * (4.853903996359136964868e2 +
                    z * (4.328810604912902668951e2 +
                         z * (1.650270098316988542046e2 + z * (2.485846490142306297962e1 + z))));
    double angle = fold * 0.78539816339744830962 + (t + t * (p / q));
    angle = ay > ax ? 1.57079632679489661923 - angle : angle;
    angle = x < 0.0 ? 3.14159265358979323846 - angle : angle;
    return y < 0.0 ? -angle : angle;
}

/* sqrt(x^2 + y^2) for arguments whose squares neither overflow nor underflow, with at most 1 unit
 * in the last place of error: C. F. Borges, An improved algorithm for hypot(a, b), 2019, without
 * fused multiply-add. */
static inline double hypotenuse(double x, double y)
{
    const double ax = fabs(x), ay = fabs(y);
    const double a = ax > ay ? ax : ay, b = ax > ay ? ay : ax;
    if (b <= 1.1102230246251565e-16 * a) return a + b;
    const double h = sqrt(a * a + b * b);
    double error; /* h^2 - a^2 - b^2 */
    if (h <= 2.0 * b) {
        const double rest = h - b;
        error = a * (2.0 * rest - a) + (rest - 2.0 * (a - b)) * rest;
    } else {
        const double rest = h - a;
        error = 2.0 * rest * (a - 2.0 * b) + ((4.0 * rest - b) * b + rest * rest);
    }
    return h - error / (2.0 * h);
}

#endif
