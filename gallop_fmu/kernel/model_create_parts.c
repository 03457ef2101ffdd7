/* What a scene needs of the equations; the rest stays zero and is not computed. */
#include "model_create.h"

#include "device.h"
#include "law.h"

static bool laws_only(const gallop_model *m)
{
    return m->scene.settings.laws_only != 0;
}

static bool has_wind(const gallop_model *m, const interval *c)
{
    return c->section->curve && !(laws_only(m) && law_always_zero(m->wind[c->field]));
}

static bool has_moment(const curve *k)
{
    for (int i = 0; i < k->pieces; i++)
        for (int power = 0; power < 4; power++)
            if (k->coefficient[12 * i + 8 + power] != 0.0) return true;
    return false;
}

/* Twist starts from rest between ends that do not turn: it stays at rest if there is no torque, no
 * eccentric ice, and no aerodynamic moment. */
static bool twists(const gallop_model *m)
{
    bool torque = m->scene.settings.seed_twist != 0.0;
    for (int i = 0; i < m->interval_count; i++) {
        const interval *c = &m->interval[i];
        torque =
            torque || c->section->eccentric || (c->aerodynamic && has_moment(c->section->curve));
    }
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

void model_create_parts(gallop_model *m)
{
    int32_t parts = 0;
    for (int i = 0; i < m->interval_count; i++) {
        interval *c = &m->interval[i];
        c->aerodynamic = has_wind(m, c);
        if (c->aerodynamic) parts |= GALLOP_AERODYNAMICS;
        if (c->section->eccentric) parts |= GALLOP_ECCENTRIC_ICE;
    }
    m->unknowns = twists(m) || moves_sideways(m) || device_leaves_plane(m)
                    ? 4
                    : 2; /* u1 u2 alone, in the vertical plane */
    if (m->unknowns == 4) parts |= GALLOP_TWIST | GALLOP_LATERAL;
    m->derived.parts = parts;
}
