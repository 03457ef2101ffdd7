/* Checks of a scene before a model is made of it: its tables can be read, and its numbers can be.
 * The binding refuses bad numbers field by field; this guards the kernel against any other caller,
 * and against parameters of an FMU that contradict each other. */
#include "base_math.h"
#include "check_tables.h"

#include <limits.h>

#define MAX_LOADED_POINTS 10000000 /* of all loads together */
#define MAX_PARTS 10000            /* of another table */
#define MAX_ELEMENTS 1000000       /* of all chains together */

#define SAG_TENSION_AGREEMENT 0.05 /* largest relative difference of a sag and a tension given */

/* ---- tables and indices ---- */

typedef struct {
    const void *items;
    int32_t count, least, most;
    const char *of_count, *of_items;
} table;

static int check_table(const table *t, gallop_report *report)
{
    if (t->count < t->least || t->count > t->most)
        return report_invalid(report, t->of_count, t->count,
                              t->count < t->least ? t->least : t->most);
    if (t->count > 0 && !base_pointer_usable(t->items, WORD))
        return report_refused(report, t->of_items, NAN, NAN);
    return GALLOP_COMPLETED;
}

#define TABLE(s, name, least, most)                                                                \
    {(s)->name,                                                                                    \
     (s)->name##_count,                                                                            \
     least,                                                                                        \
     most,                                                                                         \
     "number of items of scene." #name,                                                            \
     NOT_USABLE(scene.name)}

static int check_tables(const gallop_scene *s, gallop_report *report)
{
    const table tables[] = {
        TABLE(s, cross_section, 1, MAX_PARTS), TABLE(s, curve, 0, MAX_PARTS),
        TABLE(s, field, 1, MAX_PARTS),         TABLE(s, junction, 2, MAX_PARTS),
        TABLE(s, chain, 1, MAX_PARTS),         TABLE(s, device, 0, MAX_PARTS),
        TABLE(s, station, 0, MAX_PARTS),       TABLE(s, load, 0, MAX_ITEMS),
        TABLE(s, law, 0, MAX_ITEMS),           TABLE(s, shedding, 0, MAX_PARTS)};
    int outcome = GALLOP_COMPLETED;
    for (size_t i = 0; i < COUNT(tables) && !outcome; i++)
        outcome = check_table(&tables[i], report);
    if (outcome) return outcome;
    if (s->number_count < 0 || s->number_count > INT_MAX)
        return report_invalid(report, "number of items of scene.number", (double)s->number_count,
                              INT_MAX);
    if (s->number_count > 0 && !base_pointer_usable(s->number, WORD))
        return report_refused(report, NOT_USABLE(scene.number), NAN, NAN);
    return GALLOP_COMPLETED;
}

/* ---- conductors ---- */

static int check_damping(const gallop_damping *pair, gallop_report *report)
{
    const named_number number[] = {{"damping ratio", pair->low_ratio},
                                   {"damping ratio", pair->high_ratio},
                                   {"frequency of damping", pair->low_frequency},
                                   {"frequency of damping", pair->high_frequency}};
    const int outcome = check_all_finite(number, COUNT(number), report);
    if (outcome) return outcome;
    if (pair->low_frequency == 0.0 && pair->high_frequency == 0.0)
        return GALLOP_COMPLETED; /* undamped */
    if (!check_is_positive(pair->low_frequency))
        return report_invalid(report, "low frequency of damping", pair->low_frequency, 0.0);
    if (!(pair->high_frequency > pair->low_frequency))
        return report_invalid(report, "high frequency of damping", pair->high_frequency,
                              pair->low_frequency);
    return GALLOP_COMPLETED;
}

static int check_ice(const gallop_cross_section *c, gallop_report *report)
{
    const named_number number[] = {{"mass of ice", c->ice_mass},
                                   {"inertia of ice", c->ice_torsional_inertia},
                                   {"first mass moment of the ice", c->first_moment_x2},
                                   {"first mass moment of the ice", c->first_moment_x3},
                                   {"attack angle of the first moments", c->first_moment_angle},
                                   {"attack angle", c->attack_angle},
                                   {"reference radius", c->reference_radius},
                                   {"thermal expansion", c->thermal_expansion}};
    const int outcome = check_all_finite(number, COUNT(number), report);
    if (outcome) return outcome;
    if (!(c->ice_mass >= 0.0)) return report_invalid(report, "mass of ice", c->ice_mass, 0.0);
    if (!(c->ice_torsional_inertia >= 0.0))
        return report_invalid(report, "inertia of ice", c->ice_torsional_inertia, 0.0);
    const double moment =
        c->first_moment_x2 * c->first_moment_x2 + c->first_moment_x3 * c->first_moment_x3;
    const double mass = c->mass + c->ice_mass,
                 inertia = c->torsional_inertia + c->ice_torsional_inertia;
    if (!(mass * inertia > moment))
        return report_invalid(report, "first mass moments of the ice, squared", moment,
                              mass * inertia);
    return GALLOP_COMPLETED;
}

static int check_cross_section(const gallop_scene *s, const gallop_cross_section *c,
                               gallop_report *report)
{
    const named_number number[] = {{"diameter", c->diameter},
                                   {"mass", c->mass},
                                   {"axial stiffness", c->axial_stiffness},
                                   {"torsional stiffness", c->torsional_stiffness},
                                   {"torsional inertia", c->torsional_inertia}};
    int outcome = check_all_positive(number, COUNT(number), report);
    if (!outcome) outcome = check_ice(c, report);
    if (!outcome) outcome = check_damping(&c->translation_damping, report);
    if (!outcome) outcome = check_damping(&c->twist_damping, report);
    if (!outcome)
        outcome =
            check_index(c->curve, -1, s->curve_count, "aerodynamic curve of a conductor", report);
    if (outcome) return outcome;
    if (c->slack < GALLOP_SLACK_ERROR || c->slack > GALLOP_SLACK_TENSION_ONLY)
        return report_invalid(report, "what follows where a conductor is slack", c->slack,
                              GALLOP_SLACK_TENSION_ONLY);
    return GALLOP_COMPLETED;
}

/* ---- junctions, chains and what acts on them ---- */

static int check_junction(const gallop_scene *s, const gallop_junction *j, gallop_report *report)
{
    const named_number place[] = {{"position of a junction", j->position[0]},
                                  {"position of a junction", j->position[1]},
                                  {"position of a junction", j->position[2]}};
    int outcome = check_all_finite(place, COUNT(place), report);
    for (int i = 0; i < 4 && !outcome; i++)
        if (j->fixed[i] < 0 || j->fixed[i] > 1)
            outcome = report_invalid(report, "what is fixed at a junction", j->fixed[i], 1.0);
    for (int i = 0; i < 3 && !outcome; i++)
        outcome = check_law_of(s, j->motion[i], -1, "motion of a support", report);
    return outcome;
}

/* A sag and a tension that are both given agree with m g L^2 / 8H, along the chord; a strung state
 * has one of them. */
static int check_agreement(const gallop_scene *s, const gallop_chain *c, const double chord[2],
                           gallop_report *report)
{
    const gallop_cross_section *section = &s->cross_section[c->cross_section];
    const double gravity = s->settings.gravity;
    if (!(c->sag > 0.0 && c->horizontal_tension > 0.0)) return GALLOP_COMPLETED;
    if (s->settings.strung)
        return report_invalid(report, "sag of a strung span, which has a horizontal tension",
                              c->sag, 0.0);
    const double mass = section->mass + section->ice_mass;
    const double parabola =
        mass * gravity * chord[0] * hypotenuse(chord[0], chord[1]) / (8.0 * c->horizontal_tension);
    if (fabs(c->sag - parabola) > SAG_TENSION_AGREEMENT * parabola)
        return report_invalid(report, "sag, which contradicts the horizontal tension", c->sag,
                              parabola);
    return GALLOP_COMPLETED;
}

static int check_chain(const gallop_scene *s, const gallop_chain *c, gallop_report *report)
{
    const named_number number[] = {{"sag", c->sag}, {"horizontal tension", c->horizontal_tension}};
    int outcome = check_all_finite(number, COUNT(number), report);
    if (!outcome)
        outcome =
            check_index(c->cross_section, 0, s->cross_section_count, "conductor of a span", report);
    if (!outcome) outcome = check_index(c->field, 0, s->field_count, "wind of a span", report);
    for (int end = 0; end < 2 && !outcome; end++)
        outcome = check_index(c->junction[end], 0, s->junction_count, "end of a span", report);
    if (outcome) return outcome;
    const double *left = s->junction[c->junction[0]].position;
    const double *right = s->junction[c->junction[1]].position;
    const double chord[2] = {right[0] - left[0], right[1] - left[1]};
    if (!check_is_positive(chord[0]))
        return report_invalid(report, "length of the span", chord[0], 0.0);
    if (!(fabs(chord[1]) < chord[0]))
        return report_invalid(report, "height difference", chord[1], chord[0]);
    if (right[2] != left[2])
        return report_invalid(report, "place of the end of a span across the line", right[2],
                              left[2]);
    if (c->elements < 2 || c->elements > MAX_ELEMENTS)
        return report_invalid(report, "number of elements", c->elements, 2.0);
    if (!(c->sag > 0.0) && !(c->horizontal_tension > 0.0))
        return report_invalid(report, "sag or horizontal tension", c->sag, 0.0);
    return check_agreement(s, c, chord, report);
}

/* What is common to all kinds; device.c checks the rest. */
static int check_device(const gallop_scene *s, const gallop_device *d, gallop_report *report)
{
    int outcome = GALLOP_COMPLETED;
    for (int i = 0; i < GALLOP_DEVICE_JUNCTIONS && !outcome; i++)
        outcome = check_index(d->junction[i], i ? -1 : 0, s->junction_count, "junction of a device",
                              report);
    for (int i = 0; i < GALLOP_DEVICE_PARAMETERS && !outcome; i++)
        if (!isfinite(d->parameter[i]))
            outcome = report_invalid(report, "parameter of a device", d->parameter[i], 0.0);
    return outcome;
}

static int check_load(const gallop_scene *s, const gallop_load *load, gallop_report *report)
{
    const named_number number[] = {{"force of a load", load->force[0]},
                                   {"force of a load", load->force[1]},
                                   {"force of a load", load->force[2]},
                                   {"torque of a load", load->torque}};
    int outcome = check_index(load->chain, 0, s->chain_count, "span of a load", report);
    if (outcome) return outcome;
    if (load->evenly_spaced < 0)
        return report_invalid(report, "number of evenly spaced loads", load->evenly_spaced, 0.0);
    if (load->evenly_spaced == 0 && !(load->position >= 0.0 && load->position <= 1.0))
        return report_invalid(report, "position of a load", load->position, 1.0);
    outcome = check_all_finite(number, COUNT(number), report);
    return outcome ? outcome : check_law_of(s, load->law, 0, "history of a load", report);
}

/* A station lies behind the one before it, on the same chain or a later one. */
static int check_station(const gallop_scene *s, int32_t index, gallop_report *report)
{
    const gallop_station *station = &s->station[index];
    const gallop_station *before = index > 0 ? station - 1 : NULL;
    int outcome = check_index(station->chain, 0, s->chain_count, "span of a station", report);
    if (outcome) return outcome;
    const gallop_chain *c = &s->chain[station->chain];
    const bool follows = before && before->chain == station->chain;
    const int32_t corner = follows ? before->corner : 0;
    const double position = follows ? before->position : 0.0;
    if (before && before->chain > station->chain)
        return report_invalid(report, "span of a station", station->chain, before->chain);
    if (station->corner <= corner || station->corner >= c->elements)
        return report_invalid(report, "corner of a station", station->corner, corner);
    if (!(station->position > position && station->position < 1.0))
        return report_invalid(report, "position of a station", station->position, position);
    outcome =
        check_index(station->junction, -1, s->junction_count, "junction of a station", report);
    if (outcome) return outcome;
    return check_index(station->cross_section, -1, s->cross_section_count,
                       "cross-section of a station", report);
}

/* Junctions are different points: at most one station lies at each, and no chain ends there. */
static int check_station_junctions(const gallop_scene *s, gallop_report *report)
{
    for (int32_t i = 0; i < s->station_count; i++) {
        const int32_t own = s->station[i].junction;
        if (own < 0) continue;
        for (int32_t k = 0; k < i; k++)
            if (s->station[k].junction == own)
                return report_invalid(report, "junction of a station, which has another one", own,
                                      -1.0);
        for (int32_t k = 0; k < s->chain_count; k++)
            if (s->chain[k].junction[0] == own || s->chain[k].junction[1] == own)
                return report_invalid(report, "junction of a station, where a span ends", own,
                                      -1.0);
    }
    return GALLOP_COMPLETED;
}

/* ---- settings ---- */

static int check_settings(const gallop_settings *s, gallop_report *report)
{
    const named_number positive[] = {{"gravity", s->gravity},
                                     {"time step", s->time_step},
                                     {"Newton tolerance", s->newton_tolerance}};
    const named_number finite[] = {{"density of air", s->air_density},
                                   {"tolerance", s->tolerance},
                                   {"temperature of the strung state", s->strung_temperature},
                                   {"temperature", s->temperature},
                                   {"vertical seed", s->seed_vertical},
                                   {"horizontal seed", s->seed_horizontal},
                                   {"seed of the twist", s->seed_twist}};
    int outcome = check_all_positive(positive, COUNT(positive), report);
    if (!outcome) outcome = check_all_finite(finite, COUNT(finite), report);
    if (outcome) return outcome;
    if (s->max_halvings < 0 || s->max_halvings > 30)
        return report_invalid(report, "number of halvings", s->max_halvings, 30.0);
    if (s->max_newton_iterations < 1)
        return report_invalid(report, "number of Newton iterations", s->max_newton_iterations, 1.0);
    if (s->integrator < GALLOP_NEWMARK || s->integrator > GALLOP_GENERALISED_ALPHA)
        return report_invalid(report, "number of the integrator", s->integrator,
                              GALLOP_GENERALISED_ALPHA);
    if (s->integrator == GALLOP_GENERALISED_ALPHA &&
        !(s->spectral_radius >= 0.0 && s->spectral_radius <= 1.0))
        return report_invalid(report, "spectral radius", s->spectral_radius, 1.0);
    if (!(s->tolerance >= 0.0) || (s->tolerance > 0.0 && s->integrator != GALLOP_GAUSS6))
        return report_invalid(report, "tolerance, which Gauss's method alone can keep",
                              s->tolerance, 0.0);
    return GALLOP_COMPLETED;
}

/* ---- all of it ---- */

static int check_totals(const gallop_scene *s, gallop_report *report)
{
    int64_t points = 0, elements = 0;
    for (int32_t i = 0; i < s->load_count; i++)
        points += s->load[i].evenly_spaced > 0 ? s->load[i].evenly_spaced : 1;
    for (int32_t i = 0; i < s->chain_count; i++) elements += s->chain[i].elements;
    if (points > MAX_LOADED_POINTS)
        return report_invalid(report, "number of loaded points", (double)points, MAX_LOADED_POINTS);
    if (elements > MAX_ELEMENTS)
        return report_invalid(report, "number of elements", (double)elements, MAX_ELEMENTS);
    return GALLOP_COMPLETED;
}

static int check_conductors(const gallop_scene *s, gallop_report *report)
{
    int outcome = GALLOP_COMPLETED;
    for (int32_t i = 0; i < s->cross_section_count && !outcome; i++)
        outcome = check_cross_section(s, &s->cross_section[i], report);
    for (int32_t i = 0; i < s->curve_count && !outcome; i++)
        outcome = check_curve(s, &s->curve[i], report);
    for (int32_t i = 0; i < s->field_count && !outcome; i++)
        outcome = check_field(s, &s->field[i], report);
    return outcome;
}

static int check_line(const gallop_scene *s, gallop_report *report)
{
    int outcome = GALLOP_COMPLETED;
    for (int32_t i = 0; i < s->junction_count && !outcome; i++)
        outcome = check_junction(s, &s->junction[i], report);
    for (int32_t i = 0; i < s->chain_count && !outcome; i++)
        outcome = check_chain(s, &s->chain[i], report);
    for (int32_t i = 0; i < s->station_count && !outcome; i++)
        outcome = check_station(s, i, report);
    for (int32_t i = 0; i < s->shedding_count && !outcome; i++)
        outcome = check_shedding(s, i, report);
    return outcome ? outcome : check_station_junctions(s, report);
}

/* Devices and loads: what acts on the line. */
static int check_actions(const gallop_scene *s, gallop_report *report)
{
    int outcome = GALLOP_COMPLETED;
    for (int32_t i = 0; i < s->device_count && !outcome; i++)
        outcome = check_device(s, &s->device[i], report);
    for (int32_t i = 0; i < s->load_count && !outcome; i++)
        outcome = check_load(s, &s->load[i], report);
    return outcome;
}

int check_scene(const gallop_scene *s, gallop_report *report)
{
    int outcome = check_tables(s, report);
    if (!outcome) outcome = check_settings(&s->settings, report);
    if (!outcome) outcome = check_conductors(s, report);
    if (!outcome) outcome = check_actions(s, report);
    if (!outcome) outcome = check_line(s, report);
    return outcome ? outcome : check_totals(s, report);
}
