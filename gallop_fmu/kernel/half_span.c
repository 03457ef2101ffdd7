/* Half of a span that is symmetric about its middle, on request.
 *
 * The mesh is cut at mid-span.  There a plane of symmetry holds the conductor along the span and lets it move up and
 * across and turn, as the middle node of the whole span does while both halves do the same.  Gravity, wind, ice and the
 * twist about x1 are the same on both sides; x1 changes its sign.  The initial equilibrium is that of the whole mesh.
 * What is observed is of the whole span.
 *
 * Antisymmetric motion (an even number of loops) cannot appear, and neither can its instability; only who asks for it
 * gets half a span. */
#include "internal.h"

#define AT_MIDDLE 1e-9   /* [elements] round-off in the place of a load */

static bool at_rest(const gallop_support *support)
{
    return law_always_zero(&support->motion[0]) && law_always_zero(&support->motion[1]) &&
           law_always_zero(&support->motion[2]);
}

int check_half_span(const gallop_scene *s, gallop_report *report)
{
    if (!s->half_span) return GALLOP_COMPLETED;
    if (!s->laws_only) return invalid(report, "half span, which inputs could move unevenly", s->half_span, 0.0);
    if (s->elements % 2 || s->elements < 4)
        return invalid(report, "number of elements, not even or below 4, for half a span", s->elements, 4.0);
    if (s->height_difference != 0.0)
        return invalid(report, "height difference on half a span", s->height_difference, 0.0);
    if (memcmp(&s->support[0], &s->support[1], offsetof(gallop_support, motion)) != 0)
        return invalid(report, "right support on half a span, unlike the left", s->support[1].kind, s->support[0].kind);
    if (!at_rest(&s->support[0]) || !at_rest(&s->support[1]))
        return invalid(report, "motion of a support on half a span", 1.0, 0.0);
    for (int i = 0; i < s->load_count; i++) {
        const gallop_load *load = &s->load[i];
        if (load->force[0] != 0.0) return invalid(report, "force of a load along half a span", load->force[0], 0.0);
        if (load->evenly_spaced <= 0 && load->position != 0.5)
            return invalid(report, "position of a load on half a span", load->position, 0.5);
    }
    return GALLOP_COMPLETED;
}

/* Loads beyond mid-span go, one there counts by half. */
static void keep_left_loads(gallop_model *m)
{
    const int all = m->load_count;
    m->load_count = 0;
    for (int l = 0; l < all; l++) {
        load_place place = m->place[l];
        const double beyond = place.element + 0.5 * (1.0 + place.shape[2] - place.shape[0]) - m->elements;
        if (beyond > AT_MIDDLE) continue;
        if (beyond > -AT_MIDDLE) place = (load_place){place.load, m->elements - 1, {0.0, 0.0, 0.5}};
        m->place[m->load_count++] = place;
    }
}

void keep_left_half(gallop_model *m)
{
    m->elements /= 2;
    m->nodes = 2 * m->elements + 1;
    m->strips = (m->elements + LANES - 1) / LANES;
    for (int i = 0; i < 4; i++) {
        m->fixed[1][i] = i == 0;
        m->stiffness[1][i] = 0.0;
        m->constant_force[4 * (m->nodes - 1) + i] *= 0.5;   /* the other half is the other element's */
    }
    keep_left_loads(m);
    lay_side_by_side(m);   /* lanes beyond the last element repeat it */
}
