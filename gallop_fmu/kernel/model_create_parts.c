/* What a scene needs of the equations; the rest stays zero and is not computed. */
#include "model_create.h"

#include "device.h"
#include "law.h"

static void create_sheddings(gallop_model *m)
{
    for (int i = 0; i < m->interval_count; i++) m->interval[i].shedding = -1;
    for (int i = 0; i < m->shedding_count; i++) {
        const gallop_shedding *from = &m->scene.shedding[i];
        const chain *c = &m->chain[from->chain];
        interval *of = &m->interval[c->first_interval];
        while (of->first_element < c->first_element + from->corner) of++;
        of->shedding = i;
        of->index_after = from->cross_section;
        of->section_after = &m->section[from->cross_section];
        m->shedding_time[i] = from->time;
    }
}

static bool laws_only(const gallop_model *m)
{
    return m->scene.settings.laws_only != 0;
}

/* The cross-sections that an interval can have: as it is, and once its ice has fallen. */
static int sections_of(const interval *c, const cross_section *section[2])
{
    section[0] = c->section;
    section[1] = c->section_after;
    return c->section_after ? 2 : 1;
}

static bool has_wind(const gallop_model *m, const interval *c)
{
    const cross_section *section[2];
    if (laws_only(m) && law_always_zero(m->wind[c->field])) return false;
    for (int k = sections_of(c, section); k-- > 0;)
        if (section[k]->curve) return true;
    return false;
}

static bool is_eccentric(const interval *c)
{
    return c->section->eccentric || (c->section_after && c->section_after->eccentric);
}

static bool has_moment(const curve *k)
{
    for (int i = 0; i < k->pieces; i++)
        for (int power = 0; power < 4; power++)
            if (k->coefficient[12 * i + 8 + power] != 0.0) return true;
    return false;
}

/* An aerodynamic moment or eccentric ice can twist an interval. */
static bool has_torque(const interval *c)
{
    const cross_section *section[2];
    bool torque = is_eccentric(c);
    for (int k = sections_of(c, section); k-- > 0 && c->aerodynamic;)
        torque = torque || (section[k]->curve && has_moment(section[k]->curve));
    return torque;
}

/* Twist starts from rest between ends that do not turn: it stays at rest if there is no torque, no
 * eccentric ice, and no aerodynamic moment. */
static bool twists(const gallop_model *m)
{
    bool torque = m->scene.settings.seed_twist != 0.0;
    for (int i = 0; i < m->interval_count; i++) torque = torque || has_torque(&m->interval[i]);
    for (int i = 0; i < m->scene.load_count; i++) {
        const gallop_load *load = &m->scene.load[i];
        torque = torque || (load->torque != 0.0 && !law_always_zero(&m->law[load->law]));
    }
    return torque;
}

/* The chains hang in a vertical plane, and stay in it if nothing acts across. */
static bool moves_sideways(const gallop_model *m)
{
    bool across = !laws_only(m) || m->scene.settings.seed_horizontal != 0.0;
    for (int i = 0; i < m->interval_count; i++) across = across || m->interval[i].aerodynamic;
    for (int i = 0; i < m->junction_count; i++) across = across || m->junction[i].motion[2];
    for (int i = 0; i < m->scene.load_count; i++) {
        const gallop_load *load = &m->scene.load[i];
        across = across || (load->force[2] != 0.0 && !law_always_zero(&m->law[load->law]));
    }
    return across;
}

/* A line with fewer elements is not worth to be shared by two threads (benchmarks/speed). */
#define MIN_SHARED_ELEMENTS 60

/* The halves of a line with as equal numbers of elements as whole chains allow. */
static void create_halves(gallop_model *m)
{
    int cut = 0, elements = 0;
    while (2 * elements + m->chain[cut].elements < m->elements)
        elements += m->chain[cut++].elements;
    m->half[0] = (line_half){{0, m->chain_count}, {0, m->interval_count}, {0, m->nodes}, 0};
    m->half[1] = m->half[0];
    m->halves = cut > 0 && m->elements >= MIN_SHARED_ELEMENTS ? 2 : 1;
    m->derived.threads = m->halves;
    if (m->halves == 2) {
        const chain *c = &m->chain[cut];
        m->half[0].chain[1] = m->half[1].chain[0] = cut;
        m->half[0].interval[1] = m->half[1].interval[0] = c->first_interval;
        m->half[0].node[1] = m->half[1].node[0] = c->first_node;
        m->half[1].first_strip = c->first_strip;
    }
    for (int i = 0; i < m->tie_count; i++) {
        tie *t = &m->tie[i];
        const int leading = model_half_of_node(m, t->leader);
        t->half = leading == model_half_of_node(m, t->follower) ? leading : BETWEEN;
    }
    for (int i = 0; i < m->device_count; i++) {
        device *d = &m->device[i];
        for (int k = 0; k < d->junctions; k++)
            d->halves |= 1 << model_half_of_node(m, m->junction[d->junction[k]].node);
    }
}

void model_create_parts(gallop_model *m)
{
    int32_t parts = 0;
    create_sheddings(m);
    for (int i = 0; i < m->interval_count; i++) {
        interval *c = &m->interval[i];
        c->aerodynamic = has_wind(m, c);
        if (c->aerodynamic) parts |= GALLOP_AERODYNAMICS;
        if (is_eccentric(c)) parts |= GALLOP_ECCENTRIC_ICE;
    }
    m->unknowns = twists(m) || moves_sideways(m) || device_leaves_plane(m)
                    ? 4
                    : 2; /* u1 u2 alone, in the vertical plane */
    m->fused = !m->scene.settings.portable && base_has_fused_path();
    if (m->unknowns == 4) parts |= GALLOP_TWIST | GALLOP_LATERAL;
    m->derived.parts = parts;
    create_halves(m);
}
