/* Quasi-steady aerodynamic load on a section (Liu et al. 2009, eq. 20-21), and its derivatives. */
#include "internal.h"

typedef struct { double value, slope; } reading;

/* Reduce alpha to the turn centred on the curve's range; outside the range report the excess and, for "hold",
 * clamp.  "error" clamps as well, so that a stray Newton iterate stays finite: the step is judged once converged. */
static double inside(const gallop_model *model, double alpha, double *excess)
{
    alpha -= 2.0 * PI * floor((alpha - model->curve_centre) / (2.0 * PI) + 0.5);
    *excess = 0.0;
    if (alpha < model->curve_first) {
        *excess = model->curve_first - alpha;
        return model->curve_first;
    }
    if (alpha > model->curve_last) {
        *excess = alpha - model->curve_last;
        return model->curve_last;
    }
    return alpha;
}

static void read_curve(const gallop_model *model, double alpha, bool held, reading out[3])
{
    const double *x = model->scene.breakpoint;
    int low = 0, high = model->scene.pieces;
    while (high - low > 1) {
        int middle = (low + high) / 2;
        if (alpha < x[middle]) high = middle; else low = middle;
    }
    const double *k = model->scene.coefficient + 12 * low;
    double s = alpha - x[low];
    for (int c = 0; c < 3; c++, k += 4) {
        out[c].value = k[0] + s * (k[1] + s * (k[2] + s * k[3]));
        out[c].slope = held ? 0.0 : k[1] + s * (2.0 * k[2] + 3.0 * s * k[3]);
    }
}

/* alpha = alpha0 + theta + atan2(w2, w3) with the relative wind w2 = -v2 - r omega, w3 = U - v3. */
double aero_angle(double theta, double v2, double v3, double omega, double wind, double attack, double radius)
{
    double w2 = -v2 - radius * omega, w3 = wind - v3;
    return attack + theta + (w2 != 0.0 || w3 != 0.0 ? atan2(w2, w3) : 0.0);
}

/* F2 = q (CL w3 + CD w2), F3 = q (-CL w2 + CD w3), M = q Ur d CM, q = rho d Ur / 2.
 * by_v2 and by_v3 are the derivatives by v2 and v3; that by omega is r by_v2. */
void aero_load(const gallop_model *model, const instant *now, double theta, double v2, double v3, double omega,
               bool slopes, air_load *load, double *excess, double *angle)
{
    const double radius = model->scene.reference_radius, d = model->scene.diameter;
    const double k = 0.5 * model->scene.air_density * d;
    const double w2 = -v2 - radius * omega, w3 = now->wind - v3;
    const double speed = sqrt(w2 * w2 + w3 * w3);
    if (speed == 0.0) {
        memset(load, 0, sizeof *load);
        *excess = 0.0;
        *angle = now->attack + theta;
        return;
    }
    *angle = now->attack + theta + atan2(w2, w3);
    double alpha = inside(model, *angle, excess);
    reading c[3];
    read_curve(model, alpha, *excess > 0.0, c);
    const double cl = c[0].value, cd = c[1].value, cm = c[2].value;
    const double a2 = cl * w3 + cd * w2, a3 = -cl * w2 + cd * w3;
    load->force[0] = k * speed * a2;
    load->force[1] = k * speed * a3;
    load->force[2] = k * d * speed * speed * cm;
    if (!slopes) return;
    const double s2 = c[0].slope * w3 + c[1].slope * w2, s3 = -c[0].slope * w2 + c[1].slope * w3;
    load->by_theta[0] = k * speed * s2;
    load->by_theta[1] = k * speed * s3;
    load->by_theta[2] = k * d * speed * speed * c[2].slope;
    /* dUr/dw2 = w2/Ur, d alpha/dw2 = w3/Ur^2, d alpha/dw3 = -w2/Ur^2, dw/dv = -1 */
    load->by_v2[0] = -k * (w2 * a2 / speed + speed * cd + s2 * w3 / speed);
    load->by_v2[1] = -k * (w2 * a3 / speed - speed * cl + s3 * w3 / speed);
    load->by_v2[2] = -k * d * (2.0 * w2 * cm + c[2].slope * w3);
    load->by_v3[0] = -k * (w3 * a2 / speed + speed * cl - s2 * w2 / speed);
    load->by_v3[1] = -k * (w3 * a3 / speed + speed * cd - s3 * w2 / speed);
    load->by_v3[2] = -k * d * (2.0 * w3 * cm - c[2].slope * w2);
}
