/* Quasi-steady aerodynamic load along the span (Liu et al. 2009, eq. 20-21), and its derivatives. */
#include "elementary.h"
#include "internal.h"

/* alpha = alpha0 + theta + atan2(w2, w3) with the relative wind w2 = -v2 - r omega, w3 = U - v3. */
double aero_angle(double theta, double v2, double v3, double omega, double wind, double attack, double radius)
{
    double w2 = -v2 - radius * omega, w3 = wind - v3;
    return attack + theta + arctangent(w2, w3);
}

/* Attack angles, how far they are out of the curve's range, and where on the curve to read: reduced to the turn centred
 * on the range, and held at its ends.  "error" holds as well, so that a stray Newton iterate stays finite: the step is
 * judged once it has converged. */
TWO_PATHS static void attack_angles(const gallop_model *model, const instant *now, const sections *at, int first, int last)
{
    const double radius = model->radius, wind = now->wind, attack = now->attack;
    const double centre = model->curve_centre, half = 0.5 * (model->curve_last - model->curve_first);
    const double *theta = at->theta, *omega = at->omega, *v2 = at->v2, *v3 = at->v3;
    double *angle = at->angle, *excess = at->excess, *read = at->by_theta[0];
    INDEPENDENT
    for (int i = first; i < last; i++) {
        double w2 = -v2[i] - radius * omega[i], w3 = wind - v3[i];
        double alpha = attack + theta[i] + arctangent(w2, w3), offset = alpha - centre;
        offset -= 2.0 * PI * nearest(offset * (0.5 / PI));
        double size = offset < 0.0 ? -offset : offset, over = size - half;
        double held = offset < 0.0 ? -half : half;
        angle[i] = alpha;
        excess[i] = over > 0.0 ? over : 0.0;
        read[i] = centre + (over > 0.0 ? held : offset);
    }
}

static int piece_of(const double *breakpoint, int pieces, double alpha)
{
    int low = 0, high = pieces;
    while (high - low > 1) {
        int middle = (low + high) / 2;
        if (alpha < breakpoint[middle]) high = middle; else low = middle;
    }
    return low;
}

/* Section i reads the cubic with coefficients k at the distance s from its origin. */
static inline void read_section(const double *k, double s, const sections *at, int i, bool slopes)
{
    double inside = at->excess[i] > 0.0 ? 0.0 : 1.0;
    at->by_v2[0][i] = k[0] + s * (k[1] + s * (k[2] + s * k[3]));
    at->by_v2[1][i] = k[4] + s * (k[5] + s * (k[6] + s * k[7]));
    at->by_v2[2][i] = k[8] + s * (k[9] + s * (k[10] + s * k[11]));
    if (!slopes) return;
    at->by_v3[0][i] = inside * (k[1] + s * (2.0 * k[2] + 3.0 * s * k[3]));
    at->by_v3[1][i] = inside * (k[5] + s * (2.0 * k[6] + 3.0 * s * k[7]));
    at->by_v3[2][i] = inside * (k[9] + s * (2.0 * k[10] + 3.0 * s * k[11]));
}

/* CL, CD, CM into by_v2 at the angles that attack_angles left in by_theta[0]; their slopes, where asked for, into by_v3. */
TWO_PATHS static void read_curve(const gallop_model *model, const sections *at, int first, int last, bool slopes)
{
    const double *breakpoint = model->scene.breakpoint, *origin = model->scene.origin;
    const double *coefficient = model->scene.coefficient;
    if (model->scene.pieces == 1) {   /* a polynomial: no search */
        double k[12];
        memcpy(k, coefficient, sizeof k);
        INDEPENDENT
        for (int i = first; i < last; i++) read_section(k, at->by_theta[0][i] - origin[0], at, i, slopes);
        return;
    }
    for (int i = first; i < last; i++) {
        int piece = piece_of(breakpoint, model->scene.pieces, at->by_theta[0][i]);
        read_section(coefficient + 12 * piece, at->by_theta[0][i] - origin[piece], at, i, slopes);
    }
}

/* F2 = q (CL w3 + CD w2), F3 = q (-CL w2 + CD w3), M = q Ur d CM, q = rho d Ur / 2, taken from the section forces. */
TWO_PATHS static void subtract_loads(const gallop_model *model, const instant *now, const sections *at, int first, int last)
{
    const double radius = model->radius, d = model->scene.diameter, wind = now->wind;
    const double k = 0.5 * model->scene.air_density * d;
    const double *omega = at->omega, *v2 = at->v2, *v3 = at->v3;
    const double *lift = at->by_v2[0], *drag = at->by_v2[1], *moment = at->by_v2[2];
    double *f2 = at->force[0], *f3 = at->force[1], *twist = at->force[2];
    INDEPENDENT
    for (int i = first; i < last; i++) {
        double w2 = -v2[i] - radius * omega[i], w3 = wind - v3[i], square = w2 * w2 + w3 * w3, q = k * sqrt(square);
        f2[i] -= q * (lift[i] * w3 + drag[i] * w2);
        f3[i] -= q * (drag[i] * w3 - lift[i] * w2);
        twist[i] -= k * d * square * moment[i];
    }
}

/* Derivatives of F2, F3, M by theta, v2 and v3 (that by omega is r times that by v2), from
 * dUr/dw2 = w2/Ur, d alpha/dw2 = w3/Ur^2, d alpha/dw3 = -w2/Ur^2, dw/dv = -1.  Replaces the coefficients. */
TWO_PATHS static void load_slopes(const gallop_model *model, const instant *now, const sections *at, int first, int last)
{
    const double radius = model->radius, d = model->scene.diameter, wind = now->wind;
    const double k = 0.5 * model->scene.air_density * d;
    INDEPENDENT
    for (int i = first; i < last; i++) {
        double w2 = -at->v2[i] - radius * at->omega[i], w3 = wind - at->v3[i], ur = sqrt(w2 * w2 + w3 * w3);
        double per = 1.0 / (ur + 1e-300);   /* no relative wind: no load */
        double cl = at->by_v2[0][i], cd = at->by_v2[1][i], cm = at->by_v2[2][i];
        double cl_slope = at->by_v3[0][i], cd_slope = at->by_v3[1][i], cm_slope = at->by_v3[2][i];
        double a2 = cl * w3 + cd * w2, a3 = cd * w3 - cl * w2;
        double s2 = cl_slope * w3 + cd_slope * w2, s3 = cd_slope * w3 - cl_slope * w2;
        at->by_theta[0][i] = k * ur * s2;
        at->by_theta[1][i] = k * ur * s3;
        at->by_theta[2][i] = k * d * ur * ur * cm_slope;
        at->by_v2[0][i] = -k * (w2 * a2 * per + ur * cd + s2 * w3 * per);
        at->by_v2[1][i] = -k * (w2 * a3 * per - ur * cl + s3 * w3 * per);
        at->by_v2[2][i] = -k * d * (2.0 * w2 * cm + cm_slope * w3);
        at->by_v3[0][i] = -k * (w3 * a2 * per + ur * cl - s2 * w2 * per);
        at->by_v3[1][i] = -k * (w3 * a3 * per + ur * cd - s3 * w2 * per);
        at->by_v3[2][i] = -k * d * (2.0 * w3 * cm - cm_slope * w2);
    }
}

void aero_loads(const gallop_model *model, const instant *now, const sections *at, int first, int count, bool slopes)
{
    const int last = first + count;
    attack_angles(model, now, at, first, last);
    read_curve(model, at, first, last, slopes);
    subtract_loads(model, now, at, first, last);
    if (slopes) load_slopes(model, now, at, first, last);
}
