/* Whether a scene's numbers are finite and its laws, curve and loads can be read: before a model
 * copies them. */
#include "check.h"

#define MAX_LOADED_POINTS 10000000 /* of all loads together */

typedef struct {
    const char *name;
    double value;
} named;

static int all_finite(const named *number, size_t count, gallop_report *report)
{
    for (size_t i = 0; i < count; i++)
        if (!isfinite(number[i].value))
            return report_invalid(report, number[i].name, number[i].value, 0.0);
    return GALLOP_COMPLETED;
}
#define ALL_FINITE(numbers, report) all_finite(numbers, sizeof(numbers) / sizeof *(numbers), report)

static int check_numbers(const gallop_scene *s, gallop_report *report)
{
    const named number[] = {{"sag", s->sag},
                            {"horizontal tension", s->horizontal_tension},
                            {"mass of ice", s->ice_mass},
                            {"inertia of ice", s->ice_torsional_inertia},
                            {"first mass moment of the ice", s->first_moment_x2},
                            {"first mass moment of the ice", s->first_moment_x3},
                            {"density of air", s->air_density},
                            {"attack angle", s->attack_angle},
                            {"angle of the first moments", s->first_moment_angle},
                            {"tolerance", s->tolerance},
                            {"reference radius", s->reference_radius},
                            {"damping ratio", s->translation_damping.low_ratio},
                            {"damping ratio", s->translation_damping.high_ratio},
                            {"frequency of damping", s->translation_damping.high_frequency},
                            {"damping ratio", s->twist_damping.low_ratio},
                            {"damping ratio", s->twist_damping.high_ratio},
                            {"frequency of damping", s->twist_damping.high_frequency},
                            {"vertical seed", s->seed_vertical},
                            {"horizontal seed", s->seed_horizontal},
                            {"seed of the twist", s->seed_twist}};
    return ALL_FINITE(number, report);
}

static int check_array(const double *values, int32_t count, bool increasing, const char *name,
                       gallop_report *report)
{
    for (int32_t i = 0; i < count; i++)
        if (!isfinite(values[i]) || (increasing && i > 0 && !(values[i] > values[i - 1])))
            return report_invalid(report, name, values[i],
                                  i > 0 && increasing ? values[i - 1] : 0.0);
    return GALLOP_COMPLETED;
}

static int check_law(const gallop_law *law, const char *name, gallop_report *report)
{
    const named number[] = {
        {name, law->initial},
        {name, law->peak},
        {name, law->amplitude},
        {name, law->start},
        {name, law->rise},
        {name, law->fall},
        {name, law->frequency},
        {name, law->phase},
        {name, 40.0 * law->frequency * law->frequency * law->amplitude}, /* second derivative */
        {name, isnan(law->fall_start) ? NAN : 0.0}}; /* infinite: it stays at the peak */
    if (law->kind < GALLOP_LAW_CONSTANT || law->kind > GALLOP_LAW_TABLE)
        return report_invalid(report, name, law->kind, GALLOP_LAW_TABLE);
    if (law->kind != GALLOP_LAW_TABLE) return ALL_FINITE(number, report);
    if (law->count < 1) return report_invalid(report, name, law->count, 1.0);
    if (!base_pointer_usable(law->time, WORD))
        return report_refused(report, NOT_USABLE(law.time), NAN, NAN);
    if (!base_pointer_usable(law->value, WORD))
        return report_refused(report, NOT_USABLE(law.value), NAN, NAN);
    const int outcome = check_array(law->time, law->count, true, name, report);
    return outcome ? outcome : check_array(law->value, law->count, false, name, report);
}

static int check_curve(const gallop_scene *s, gallop_report *report)
{
    if (s->outside < GALLOP_OUTSIDE_ERROR || s->outside > GALLOP_OUTSIDE_PERIODIC)
        return report_invalid(report, "what holds outside the aerodynamic curve", s->outside,
                              GALLOP_OUTSIDE_PERIODIC);
    if (s->pieces < 0 || s->pieces > INT32_MAX / 12)
        return report_invalid(report, "number of pieces of the aerodynamic curve", s->pieces, 0.0);
    if (s->pieces == 0) return GALLOP_COMPLETED;
    if (!base_pointer_usable(s->breakpoint, WORD))
        return report_refused(report, NOT_USABLE(scene.breakpoint), NAN, NAN);
    if (s->origin && !base_pointer_usable(s->origin, WORD))
        return report_refused(report, NOT_USABLE(scene.origin), NAN, NAN);
    if (!base_pointer_usable(s->coefficient, WORD))
        return report_refused(report, NOT_USABLE(scene.coefficient), NAN, NAN);
    int outcome = check_array(s->breakpoint, s->pieces + 1, true,
                              "breakpoint of the aerodynamic curve", report);
    if (!outcome && s->origin)
        outcome =
            check_array(s->origin, s->pieces, false, "origin of an aerodynamic piece", report);
    return outcome ? outcome
                   : check_array(s->coefficient, 12 * s->pieces, false, "aerodynamic coefficient",
                                 report);
}

static int check_load(const gallop_load *load, gallop_report *report)
{
    const named number[] = {{"force of a load", load->force[0]},
                            {"force of a load", load->force[1]},
                            {"force of a load", load->force[2]},
                            {"torque of a load", load->torque}};
    if (load->evenly_spaced < 0)
        return report_invalid(report, "number of evenly spaced loads", load->evenly_spaced, 0.0);
    if (load->evenly_spaced == 0 && !(load->position >= 0.0 && load->position <= 1.0))
        return report_invalid(report, "position of a load", load->position, 1.0);
    const int outcome = ALL_FINITE(number, report);
    return outcome ? outcome : check_law(&load->law, "history of a load", report);
}

static int check_loads(const gallop_scene *s, gallop_report *report)
{
    int64_t points = 0;
    if (s->load_count < 0) return report_invalid(report, "number of loads", s->load_count, 0.0);
    if (s->load_count > 0 && !base_pointer_usable(s->load, WORD))
        return report_refused(report, NOT_USABLE(scene.load), NAN, NAN);
    for (int32_t i = 0; i < s->load_count; i++) {
        const int outcome = check_load(&s->load[i], report);
        if (outcome) return outcome;
        points += s->load[i].evenly_spaced > 0 ? s->load[i].evenly_spaced : 1;
    }
    if (points > MAX_LOADED_POINTS)
        return report_invalid(report, "number of loaded points", (double)points, MAX_LOADED_POINTS);
    return GALLOP_COMPLETED;
}

int check_scene_tables(const gallop_scene *s, gallop_report *report)
{
    int outcome = check_numbers(s, report);
    if (!outcome) outcome = check_curve(s, report);
    if (!outcome) outcome = check_law(&s->wind, "wind speed", report);
    for (int end = 0; end < 2 && !outcome; end++) {
        const int32_t kind = s->support[end].kind;
        if (kind < GALLOP_SUPPORT_RIGID || kind > GALLOP_SUPPORT_ADJACENT_SPAN)
            outcome =
                report_invalid(report, "kind of a support", kind, GALLOP_SUPPORT_ADJACENT_SPAN);
        for (int i = 0; i < 3 && !outcome; i++)
            outcome = check_law(&s->support[end].motion[i], "motion of a support", report);
    }
    return outcome ? outcome : check_loads(s, report);
}
