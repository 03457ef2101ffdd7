/* Checks of ice that falls, in a scene whose other tables were checked. */
#include "check.h"

/* The cross-section of the interval that begins at a corner of a chain; -1: none begins there. */
static int32_t section_from(const gallop_scene *s, int32_t index, int32_t corner)
{
    if (corner == 0) return s->chain[index].cross_section;
    for (int32_t i = 0; i < s->station_count; i++)
        if (s->station[i].chain == index && s->station[i].corner == corner)
            return s->station[i].cross_section;
    return -1;
}

static bool same_damping(const gallop_damping *a, const gallop_damping *b)
{
    return a->low_ratio == b->low_ratio && a->low_frequency == b->low_frequency &&
           a->high_ratio == b->high_ratio && a->high_frequency == b->high_frequency;
}

/* Only ice falls: the conductor stays, and no ice is added. */
static int check_lost(const gallop_cross_section *before, const gallop_cross_section *after,
                      gallop_report *report)
{
    const bool same = before->diameter == after->diameter && before->mass == after->mass &&
                      before->axial_stiffness == after->axial_stiffness &&
                      before->torsional_stiffness == after->torsional_stiffness &&
                      before->torsional_inertia == after->torsional_inertia &&
                      before->thermal_expansion == after->thermal_expansion &&
                      before->slack == after->slack &&
                      same_damping(&before->translation_damping, &after->translation_damping) &&
                      same_damping(&before->twist_damping, &after->twist_damping);
    if (!same)
        return report_invalid(report, "conductor of an interval that loses ice, which changes",
                              after->mass, before->mass);
    if (!(after->ice_mass < before->ice_mass))
        return report_invalid(report, "mass of ice left on an interval that loses it",
                              after->ice_mass, before->ice_mass);
    return GALLOP_COMPLETED;
}

int check_shedding(const gallop_scene *s, int32_t index, gallop_report *report)
{
    const gallop_shedding *own = &s->shedding[index];
    if (own->chain < 0 || own->chain >= s->chain_count)
        return report_invalid(report, "span of ice that falls", own->chain, s->chain_count - 1.0);
    if (own->cross_section < 0 || own->cross_section >= s->cross_section_count)
        return report_invalid(report, "cross-section of a span whose ice has fallen",
                              own->cross_section, s->cross_section_count - 1.0);
    const int32_t before = section_from(s, own->chain, own->corner);
    if (before < 0)
        return report_invalid(report, "corner of ice that falls, where no interval begins",
                              own->corner, 0.0);
    for (int32_t k = 0; k < index; k++)
        if (s->shedding[k].chain == own->chain && s->shedding[k].corner == own->corner)
            return report_invalid(report, "corner of ice that falls, which falls twice",
                                  own->corner, 0.0);
    if (isnan(own->time) || own->time == -INFINITY)
        return report_invalid(report, "time at which ice falls", own->time, 0.0);
    if (!(own->acceleration > 0.0))
        return report_invalid(report, "acceleration at which ice falls", own->acceleration, 0.0);
    return check_lost(&s->cross_section[before], &s->cross_section[own->cross_section], report);
}
