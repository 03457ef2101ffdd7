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
    double load_factor;                         /* 1 but while a static load is stepped up */
    bool taut;                                  /* compression is computed, as statics need */
    bool everything; /* also the unknowns and the wind that the scene does not need */
} conditions;

/* Count of the numbers. */
size_t conditions_count(const gallop_model *model);

/* Conditions in a block of memory; nothing is acted on by its contents. */
conditions conditions_in(const gallop_model *model, double *block);

void conditions_copy(const gallop_model *model, conditions *to, const conditions *from);

/* From the laws of the scene, or from a host's inputs (not NULL). */
void conditions_at(const gallop_model *model, double t, const gallop_inputs *inputs,
                   conditions *now);

/* The first mass moments of the ice turn with it; the scene gives them at one angle. */
void conditions_rotate_moments(const cross_section *section, double attack, double *c2, double *c3);

bool conditions_are_finite(const gallop_model *model, const conditions *now);

/* What an interval needs of them. */
typedef struct {
    const cross_section *section; /* which the interval has now */
    double wind, attack, c2, c3;
    int unknowns;
    bool blows, tension_only; /* blows: there is an aerodynamic load */
} exposure;

static inline exposure conditions_on(const gallop_model *model, const conditions *now,
                                     const interval *c)
{
    const int s = c->section_index;
    const cross_section *section = c->section;
    const double wind = now->wind[c->field];
    const bool aerodynamic = now->everything ? section->curve != NULL : c->aerodynamic;
    return (exposure){section,
                      wind,
                      now->attack[s],
                      now->c2[s],
                      now->c3[s],
                      now->everything ? 4 : model->unknowns,
                      aerodynamic && wind != 0.0,
                      section->tension_only && !now->taut};
}

#endif
