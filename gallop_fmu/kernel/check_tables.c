/* Checks of functions of time, fields of wind and coefficient curves. */
#include "check_tables.h"

bool check_is_positive(double x)
{
    return isfinite(x) && x > 0.0;
}

int check_all_finite(const named_number *number, size_t count, gallop_report *report)
{
    for (size_t i = 0; i < count; i++)
        if (!isfinite(number[i].value))
            return report_invalid(report, number[i].name, number[i].value, 0.0);
    return GALLOP_COMPLETED;
}

int check_all_positive(const named_number *number, size_t count, gallop_report *report)
{
    for (size_t i = 0; i < count; i++)
        if (!check_is_positive(number[i].value))
            return report_invalid(report, number[i].name, number[i].value, 0.0);
    return GALLOP_COMPLETED;
}

int check_index(int32_t index, int32_t least, int32_t count, const char *name,
                gallop_report *report)
{
    if (index < least || index >= count)
        return report_invalid(report, name, index, (double)count - 1.0);
    return GALLOP_COMPLETED;
}

int check_numbers(const gallop_scene *s, int64_t first, int64_t count, bool increasing,
                  const char *name, gallop_report *report)
{
    if (first < 0 || count > s->number_count || first > s->number_count - count)
        return report_invalid(report, name, (double)first, (double)(s->number_count - count));
    const double *value = s->number + first;
    for (int64_t i = 0; i < count; i++)
        if (!isfinite(value[i]) || (increasing && i > 0 && !(value[i] > value[i - 1])))
            return report_invalid(report, name, value[i], i > 0 && increasing ? value[i - 1] : 0.0);
    return GALLOP_COMPLETED;
}

/* To repeat, times need a period. */
static bool may_repeat(int32_t repeat, int32_t times)
{
    return repeat == 0 || (repeat == 1 && times > 1);
}

static int check_law(const gallop_scene *s, const gallop_law *l, const char *name,
                     gallop_report *report)
{
    const named_number number[] = {
        {name, l->initial},
        {name, l->peak},
        {name, l->amplitude},
        {name, l->start},
        {name, l->rise},
        {name, l->fall},
        {name, l->frequency},
        {name, l->phase},
        {name, 40.0 * l->frequency * l->frequency * l->amplitude}, /* second derivative */
        {name, isnan(l->fall_start) ? NAN : 0.0}}; /* infinite: it stays at the peak */
    if (l->kind < GALLOP_LAW_CONSTANT || l->kind > GALLOP_LAW_TABLE)
        return report_invalid(report, name, l->kind, GALLOP_LAW_TABLE);
    if (l->kind != GALLOP_LAW_TABLE) return check_all_finite(number, COUNT(number), report);
    if (l->count < 1) return report_invalid(report, name, l->count, 1.0);
    if (!may_repeat(l->repeat, l->count)) return report_invalid(report, name, l->repeat, 1.0);
    const int outcome = check_numbers(s, l->first, l->count, true, name, report);
    return outcome ? outcome
                   : check_numbers(s, (int64_t)l->first + l->count, l->count, false, name, report);
}

int check_law_of(const gallop_scene *s, int32_t index, int32_t least, const char *name,
                 gallop_report *report)
{
    const int outcome = check_index(index, least, s->law_count, name, report);
    return outcome || index < 0 ? outcome : check_law(s, &s->law[index], name, report);
}

static int check_profile(const gallop_scene *s, const gallop_field *f, gallop_report *report)
{
    const bool is_power = f->profile == GALLOP_PROFILE_POWER;
    const double parameter = f->profile_parameter, lowest = is_power ? 0.0 : parameter;
    if (f->profile < GALLOP_PROFILE_NONE || f->profile > GALLOP_PROFILE_LOGARITHMIC)
        return report_invalid(report, "profile of the wind", f->profile,
                              GALLOP_PROFILE_LOGARITHMIC);
    if (f->profile == GALLOP_PROFILE_NONE) return GALLOP_COMPLETED;
    if (is_power && !(isfinite(parameter) && parameter >= 0.0))
        return report_invalid(report, "exponent of the wind profile", parameter, 0.0);
    if (!is_power && !check_is_positive(parameter))
        return report_invalid(report, "roughness length of the wind profile", parameter, 0.0);
    if (!(isfinite(f->reference_height) && f->reference_height > lowest))
        return report_invalid(report, "reference height of the wind profile", f->reference_height,
                              lowest);
    if (f->ground_points < 1)
        return report_invalid(report, "number of points of the ground", f->ground_points, 1.0);
    const int outcome = check_numbers(s, f->first_ground, f->ground_points, true,
                                      "x1 of a point of the ground", report);
    return outcome ? outcome
                   : check_numbers(s, (int64_t)f->first_ground + f->ground_points, f->ground_points,
                                   false, "height of a point of the ground", report);
}

static int check_gusts(const gallop_scene *s, const gallop_field *f, gallop_report *report)
{
    if (f->stations < 0 || f->stations > MAX_ITEMS)
        return report_invalid(report, "number of stations of gusts", f->stations, MAX_ITEMS);
    if (f->stations == 0) return GALLOP_COMPLETED;
    if (f->times < 1) return report_invalid(report, "number of times of gusts", f->times, 1.0);
    if (f->components != 1 && f->components != 3)
        return report_invalid(report, "number of components of a gust", f->components, 3.0);
    if (!may_repeat(f->repeat, f->times))
        return report_invalid(report, "whether gusts repeat", f->repeat, 1.0);
    const int64_t of_station = (int64_t)f->times * f->components;
    if (of_station > s->number_count / f->stations)
        return report_invalid(report, "number of gusts", (double)of_station * f->stations,
                              (double)s->number_count);
    const int64_t time = (int64_t)f->first_gust + f->stations, gust = time + f->times;
    int outcome = check_numbers(s, f->first_gust, f->stations, true, "station of gusts", report);
    if (!outcome) outcome = check_numbers(s, time, f->times, true, "time of gusts", report);
    return outcome ? outcome
                   : check_numbers(s, gust, of_station * f->stations, false, "gust", report);
}

int check_field(const gallop_scene *s, const gallop_field *f, gallop_report *report)
{
    if (f->kind < GALLOP_FIELD_UNIFORM || f->kind > GALLOP_FIELD_VARIED)
        return report_invalid(report, "kind of a field of wind", f->kind, GALLOP_FIELD_VARIED);
    int outcome = check_law_of(s, f->law, 0, "wind speed", report);
    if (outcome || f->kind == GALLOP_FIELD_UNIFORM) return outcome;
    outcome = check_law_of(s, f->direction, -1, "direction of the wind", report);
    if (!outcome) outcome = check_profile(s, f, report);
    return outcome ? outcome : check_gusts(s, f, report);
}

int check_curve(const gallop_scene *s, const gallop_curve *k, gallop_report *report)
{
    if (k->outside < GALLOP_OUTSIDE_ERROR || k->outside > GALLOP_OUTSIDE_PERIODIC)
        return report_invalid(report, "what holds outside the aerodynamic curve", k->outside,
                              GALLOP_OUTSIDE_PERIODIC);
    if (k->pieces < 1 || k->pieces > MAX_ITEMS)
        return report_invalid(report, "number of pieces of the aerodynamic curve", k->pieces, 1.0);
    const int64_t origin = (int64_t)k->first + k->pieces + 1, coefficient = origin + k->pieces;
    int outcome = check_numbers(s, k->first, (int64_t)k->pieces + 1, true,
                                "breakpoint of the aerodynamic curve", report);
    if (!outcome)
        outcome =
            check_numbers(s, origin, k->pieces, false, "origin of an aerodynamic piece", report);
    return outcome ? outcome
                   : check_numbers(s, coefficient, 12 * (int64_t)k->pieces, false,
                                   "aerodynamic coefficient", report);
}
