/* Quasi-steady aerodynamic load along the span (Liu et al. 2009, eq. 20-21), and its derivatives.
 *
 * The load acts in the plane of the section, normal to the conductor's tangent t in the initial
 * equilibrium: the part of the relative wind along t exerts no force.  n3 = e3 is horizontal, n2 =
 * n3 x t points upwards; on a level conductor n2 = e2.  Velocities v2 and forces F2 of a section
 * are components along n2, and v3, F3 along n3.  In a varied field the velocities count from the
 * air, and the wind is 0. */
#include "base_math.h"
#include "element.h"

/* alpha = alpha0 + theta + atan2(w2, w3) with the relative wind w2 = -v2 - r omega, w3 = U - v3; v2
 * and v3 lie in the section's plane, along n2 and n3. */
double element_attack_angle(double theta, double v2, double v3, double omega, double wind,
                            double attack, double radius)
{
    double w2 = -v2 - radius * omega, w3 = wind - v3;
    return attack + theta + arctangent(w2, w3);
}

/* What the loops along the span need, as numbers of their own: stores into arrays cannot change
 * them. */
typedef struct {
    double wind, attack, radius, centre, half, pressure, diameter; /* pressure: rho d / 2 */
} airflow;

static airflow airflow_of(const interval *c, const exposure *now)
{
    return (airflow){now->wind,
                     now->attack,
                     now->section->radius,
                     now->section->curve->centre,
                     0.5 * (now->section->curve->last - now->section->curve->first),
                     0.5 * c->air_density * now->section->diameter,
                     now->section->diameter};
}

/* Attack angles of the sections.  A loop of its own: the chain of operations of an arctangent is
 * long, and a processor works on more of them at once if the iterations are short. */
INLINE void attack_angles(const airflow *air, const sections *at, int first, int last)
{
    INDEPENDENT
    for (int i = first; i < last; i++) {
        const double w2 = -at->v2[i] - air->radius * at->omega[i], w3 = air->wind - at->v3[i];
        at->angle[i] = air->attack + at->theta[i] + arctangent(w2, w3);
    }
}

/* How far the attack angle of a section is out of the curve's range, and where on the curve to
 * read: reduced to the turn centred on the range, and held at its ends.  "error" holds as well, so
 * that a stray Newton iterate stays finite: the step is judged once it has converged. */
INLINE double place_on_curve(const airflow *air, const sections *at, int i)
{
    double offset = at->angle[i] - air->centre;
    offset -= 2.0 * PI * nearest(offset * (0.5 / PI));
    double size = offset < 0.0 ? -offset : offset, over = size - air->half;
    double held = offset < 0.0 ? -air->half : air->half;
    at->excess[i] = over > 0.0 ? over : 0.0;
    return air->centre + (over > 0.0 ? held : offset);
}

/* CL, CD, CM of a section into by_v2, their slopes, where asked for, into by_v3: the cubic with
 * coefficients k at the distance s from its origin. */
INLINE void read_section(const double *k, double s, const sections *at, int i, bool slopes)
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

/* F2 = q (CL w3 + CD w2), F3 = q (-CL w2 + CD w3), M = q Ur d CM, q = rho d Ur / 2, taken from the
 * section's force. */
INLINE void subtract_load(const airflow *air, const sections *at, int i)
{
    const double lift = at->by_v2[0][i], drag = at->by_v2[1][i];
    double w2 = -at->v2[i] - air->radius * at->omega[i], w3 = air->wind - at->v3[i];
    double square = w2 * w2 + w3 * w3, q = air->pressure * sqrt(square);
    at->force[0][i] -= q * (lift * w3 + drag * w2);
    at->force[1][i] -= q * (drag * w3 - lift * w2);
    at->force[2][i] -= air->pressure * air->diameter * square * at->by_v2[2][i];
}

/* A polynomial needs no search. */
INLINE void polynomial_loads(const interval *c, const exposure *now, sections at, int first,
                             int last)
{
    const airflow air = airflow_of(c, now);
    const double origin = now->section->curve->origin[0];
    double k[12];
    memcpy(k, now->section->curve->coefficient, sizeof k);
    attack_angles(&air, &at, first, last);
    INDEPENDENT
    for (int i = first; i < last; i++) {
        read_section(k, place_on_curve(&air, &at, i) - origin, &at, i, false);
        subtract_load(&air, &at, i);
    }
}

/* The search begins at the piece in which the bin begins. */
static inline int piece_at(const curve *k, double alpha)
{
    const double bins = PIECE_BINS / (k->last - k->first), x = (alpha - k->first) * bins;
    int bin = x > 0.0 ? (x < PIECE_BINS - 1 ? (int)x : PIECE_BINS - 1) : 0,
        piece = k->piece_near[bin];
    while (piece > 0 && alpha < k->breakpoint[piece]) piece--; /* round-off in x */
    while (piece < k->pieces - 1 && alpha >= k->breakpoint[piece + 1]) piece++;
    return piece;
}

INLINE void table_loads(const interval *c, const exposure *now, sections at, int first, int last,
                        bool slopes)
{
    const airflow air = airflow_of(c, now);
    const curve *k = now->section->curve;
    double *place = at.by_theta[0];
    attack_angles(&air, &at, first, last);
    INDEPENDENT
    for (int i = first; i < last; i++) place[i] = place_on_curve(&air, &at, i);
    for (int i = first; i < last; i++) {
        const int piece = piece_at(k, place[i]);
        read_section(k->coefficient + 12 * piece, place[i] - k->origin[piece], &at, i, slopes);
    }
    INDEPENDENT
    for (int i = first; i < last; i++) subtract_load(&air, &at, i);
}

INLINE void loads(const interval *c, const exposure *now, const sections *at, int first, int last)
{
    if (now->section->curve->pieces == 1)
        polynomial_loads(c, now, *at, first, last);
    else
        table_loads(c, now, *at, first, last, false);
}
PATHS(loads, (const interval *c, const exposure *now, const sections *at, int first, int last),
      (c, now, at, first, last))

INLINE void loads_with_slopes(const interval *c, const exposure *now, const sections *at, int first,
                              int last)
{
    table_loads(c, now, *at, first, last, true);
}
PATHS(loads_with_slopes,
      (const interval *c, const exposure *now, const sections *at, int first, int last),
      (c, now, at, first, last))

/* Derivatives of F2, F3, M by theta, v2 and v3 (that by omega is r times that by v2), from
 * dUr/dw2 = w2/Ur, d alpha/dw2 = w3/Ur^2, d alpha/dw3 = -w2/Ur^2, dw/dv = -1.  Replaces the
 * coefficients. */
INLINE void load_slopes(const interval *c, const exposure *now, const sections *at, int first,
                        int last)
{
    const double radius = now->section->radius, d = now->section->diameter, wind = now->wind;
    const double k = 0.5 * c->air_density * d;
    INDEPENDENT
    for (int i = first; i < last; i++) {
        double w2 = -at->v2[i] - radius * at->omega[i], w3 = wind - at->v3[i],
               ur = sqrt(w2 * w2 + w3 * w3);
        double per = 1.0 / (ur + 1e-300); /* no relative wind: no load */
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
PATHS(load_slopes,
      (const interval *c, const exposure *now, const sections *at, int first, int last),
      (c, now, at, first, last))

/* Whether the wind on a section can matter: rho d Ur^2 / 2, the force per metre of a coefficient of
 * one, exceeds that part of the weight.  In nearly still air the section's own creeping motion
 * turns the relative wind by any angle. */
#define MIN_WIND_FORCE 1e-6

bool element_wind_matters(const interval *c, const exposure *now, const sections *at, int i)
{
    const double w2 = -at->v2[i] - now->section->radius * at->omega[i], w3 = now->wind - at->v3[i];
    const double force = 0.5 * c->air_density * now->section->diameter * (w2 * w2 + w3 * w3);
    return force > MIN_WIND_FORCE * now->section->mass * c->gravity;
}

void element_aero_loads(const interval *c, const exposure *now, const sections *at, int first,
                        int count, bool slopes)
{
    const int last = first + count;
    if (!slopes) {
        ON_PATH(now->fused, loads)(c, now, at, first, last);
        return;
    }
    ON_PATH(now->fused, loads_with_slopes)(c, now, at, first, last);
    ON_PATH(now->fused, load_slopes)(c, now, at, first, last);
}
