/* What acts at one instant: wind, attack angles, motion of the junctions. */
#ifndef GALLOP_CONDITIONS_H
#define GALLOP_CONDITIONS_H

#include "model.h"

/* The numbers lie in a block of memory that belongs to the state. */
typedef struct {
    double *wind;                               /* (fields) [m/s] */
    double *attack, *c2, *c3;                   /* (cross-sections) alpha0 [rad]; first mass moments
                                                   of the ice at theta = 0, turned by it */
    double *position, *velocity, *acceleration; /* (junctions, 3) prescribed motion */
    double *direction;                          /* (fields) of the wind [rad], and */
    double *air;          /* (2, 3 LANES strips) wind along n2 and n3 at the sections [m/s], in the
                             order of `sections`: both if a field is varied */
    const double *fallen; /* (sheddings) time at which the ice fell; infinite: it has not [s] */
    double time;          /* [s] */
    double load_factor;   /* 1 but while a static load is stepped up */
    bool taut;            /* compression is computed, as statics need */
    bool everything;      /* also the unknowns and the wind that the scene does not need */
} conditions;

/* Count of the numbers. */
size_t conditions_count(const gallop_model *model);

/* Conditions in a block of memory; nothing is acted on by its contents.  Ice falls at the times of
 * the scene, unless the caller gives other ones. */
conditions conditions_in(const gallop_model *model, double *block);

void conditions_copy(const gallop_model *model, conditions *to, const conditions *from);

/* From the laws of the scene, or from a host's inputs (not NULL). */
void conditions_at(const gallop_model *model, double t, const gallop_inputs *inputs,
                   conditions *now);

/* The wind at the sections from the speeds and directions of varied fields; static equilibria have
 * none of the gusts. */
void conditions_blow(const gallop_model *model, bool with_gusts, conditions *now);

/* The wind along n2 and n3 at a place of a field [m/s]. */
void conditions_wind_at(const gallop_model *model, const conditions *now, int field,
                        const wind_place *place, double wind[2]);

/* The first mass moments of the ice turn with it; the scene gives them at one angle. */
void conditions_rotate_moments(const cross_section *section, double attack, double *c2, double *c3);

bool conditions_are_finite(const gallop_model *model, const conditions *now);

/* What an interval needs of them. */
typedef struct {
    const cross_section *section; /* which the interval has now */
    const double *air[2]; /* wind along n2 and n3 at its sections, from which the motion is then
                             counted; NULL: `wind` along n3 */
    double wind, attack, c2, c3;
    int unknowns;
    bool blows, tension_only; /* blows: there is an aerodynamic load */
    bool fused;               /* see PATHS */
    /* of the ice that has fallen: weight [N/m], and moment of the weight at theta = 0 [N] */
    double lost_weight, lost_moment;
} exposure;

static inline bool conditions_have_shed(const conditions *now, const interval *c)
{
    return c->shedding >= 0 && now->fallen[c->shedding] <= now->time;
}

static inline exposure conditions_on(const gallop_model *model, const conditions *now,
                                     const interval *c)
{
    const bool shed = conditions_have_shed(now, c);
    const int s = shed ? c->index_after : c->section_index;
    const cross_section *section = shed ? c->section_after : c->section;
    const double wind = now->wind[c->field];
    const bool aerodynamic = section->curve && (now->everything || c->aerodynamic);
    exposure on = {.section = section,
                   .wind = wind,
                   .attack = now->attack[s],
                   .c2 = now->c2[s],
                   .c3 = now->c3[s],
                   .unknowns = now->everything ? 4 : model->unknowns,
                   .blows = aerodynamic && wind != 0.0,
                   .tension_only = section->tension_only && !now->taut,
                   .fused = model->fused};
    if (model->scene.field[c->field].kind == GALLOP_FIELD_VARIED) {
        on.wind = 0.0;
        on.air[0] = now->air + 3 * LANES * (size_t)c->first_strip;
        on.air[1] = on.air[0] + 3 * LANES * (size_t)model->strips;
    }
    if (shed) {
        on.lost_weight = (c->section->mass - section->mass) * c->gravity;
        on.lost_moment = (now->c3[c->section_index] - on.c3) * c->gravity;
    }
    return on;
}

#endif
