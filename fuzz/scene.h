/* Shared by the targets that make a model: a scene whose numbers, coefficient table, laws and
 * loads come from the input, mostly those of example 3. */
#ifndef FUZZING_SCENE_H
#define FUZZING_SCENE_H

#include "gallop.h"
#include "input.h"

#define MOST 4 /* pieces, points of a table, loads */

static double breakpoint[MOST + 1], origin[MOST], coefficient[12 * MOST];
static double table_time[9][MOST], table_value[9][MOST];
static gallop_load load[MOST];

/* Mostly as it is, or near. */
static inline void change(input *in, double *number)
{
    const uint8_t b = byte_of(in);
    if (b < 128) return;
    if (b < 224)
        *number *= 1.0 + (b - 176) / 100.0;
    else
        *number = number_of(in);
}

static inline int32_t count_of(input *in, int32_t usual)
{
    static const int32_t odd[] = {0, -1, INT32_MIN, 1, 2, MOST};
    const uint8_t b = byte_of(in);
    return b < 128 ? usual : odd[b % 6];
}

static inline void law_of(input *in, gallop_law *law, int which, double usual)
{
    const uint8_t kind = byte_of(in);
    law->kind = kind < 128 ? GALLOP_LAW_CONSTANT : kind < 250 ? kind % 4 : kind - 252;
    law->initial = law->peak = law->amplitude = usual;
    law->rise = law->fall = law->frequency = 0.1;
    law->fall_start = 0.2;
    if (law->kind != GALLOP_LAW_CONSTANT) {
        double *number[] = {&law->peak,       &law->amplitude, &law->start,     &law->rise,
                            &law->fall_start, &law->fall,      &law->frequency, &law->phase};
        for (size_t i = 0; i < sizeof number / sizeof *number; i++) change(in, number[i]);
        law->count = count_of(in, 3);
        for (int i = 0; i < MOST; i++) {
            table_time[which][i] = 0.05 * i;
            table_value[which][i] = usual * (1.0 + 0.1 * i);
            change(in, &table_time[which][i]);
            change(in, &table_value[which][i]);
        }
    }
    law->time = table_time[which];
    law->value = table_value[which];
    change(in, &law->initial);
}

static inline void aerodynamics_of(input *in, gallop_scene *s)
{
    static const double usual[12] = {0.0, -4.5, 0.0, 3.0, 1.0, 0.0, 0.5, 0.0, 0.0, -0.3, 0.0, 0.2};
    s->pieces = count_of(in, 1);
    s->outside = byte_of(in) % 4;
    for (int i = 0; i <= MOST; i++) {
        breakpoint[i] = 1.75 + 2.8 * i;
        change(in, &breakpoint[i]);
    }
    for (int i = 0; i < MOST; i++) {
        origin[i] = 3.14159;
        change(in, &origin[i]);
        memcpy(coefficient + 12 * i, usual, sizeof usual);
        for (int k = 0; k < 12; k++) change(in, &coefficient[12 * i + k]);
    }
    s->breakpoint = breakpoint;
    s->origin = byte_of(in) == 255 ? NULL : origin;
    s->coefficient = coefficient;
}

static inline void support_of(input *in, gallop_support *support, int which)
{
    const uint8_t kind = byte_of(in);
    support->kind = kind < 128 ? GALLOP_SUPPORT_RIGID : kind % 4;
    support->stiffness_x1 = 7.6e4;
    support->stiffness_x3 = 1.4e3;
    support->adjacent_span = 120.0;
    support->adjacent_tension = 1.5e4;
    support->insulator_length = 2.0;
    support->insulator_weight = 300.0;
    double *number[] = {&support->stiffness_x1,     &support->stiffness_x3,
                        &support->adjacent_span,    &support->adjacent_tension,
                        &support->insulator_length, &support->insulator_weight};
    for (size_t i = 0; i < sizeof number / sizeof *number; i++) change(in, number[i]);
    for (int i = 0; i < 3; i++) law_of(in, &support->motion[i], 1 + which * 3 + i, 0.0);
}

static inline void loads_of(input *in, gallop_scene *s)
{
    s->load_count = count_of(in, 0);
    s->load = load;
    memset(load, 0, sizeof load);
    for (int i = 0; i < MOST && i < s->load_count; i++) {
        load[i].evenly_spaced = count_of(in, 3);
        load[i].position = 0.5;
        load[i].force[1] = 10.0;
        double *number[] = {&load[i].position, &load[i].force[0], &load[i].force[1],
                            &load[i].force[2], &load[i].torque};
        for (size_t k = 0; k < sizeof number / sizeof *number; k++) change(in, number[k]);
        law_of(in, &load[i].law, 7 + i % 2, 1.0);
    }
}

static inline void scene_of(input *in, gallop_scene *s)
{
    *s = (gallop_scene){.length = 125.9,
                        .sag = 2.12,
                        .horizontal_tension = 1.5e4,
                        .gravity = 9.81,
                        .diameter = 0.0188,
                        .mass = 1.53,
                        .axial_stiffness = 13.3e6,
                        .torsional_stiffness = 101.0,
                        .torsional_inertia = 3.3e-4,
                        .air_density = 1.2929,
                        .attack_angle = 3.14159,
                        .time_step = 0.01,
                        .newton_tolerance = 1e-9,
                        .seed_vertical = 1e-3,
                        .seed_horizontal = 1e-3,
                        .translation_damping = {0.016, 0.378, 0.016, 0.695},
                        .twist_damping = {0.057, 3.93, 0.057, 7.87},
                        .ice_mass = 0.1,
                        .ice_torsional_inertia = 1e-5,
                        .first_moment_x2 = 1e-4,
                        .first_moment_x3 = 1e-4};
    if (byte_of(in) % 2) s->horizontal_tension = 0.0;
    const uint8_t how = byte_of(in); /* mostly an integrator that there is */
    s->integrator = how < 240 ? how % 3 : how - 242;
    s->spectral_radius = 0.8;
    s->slack = how / 16 % 2;
    s->laws_only = how / 2 % 2;
    if (how / 4 % 4 == 3) s->tolerance = 1e-3;
    double *number[] = {&s->length,
                        &s->height_difference,
                        &s->sag,
                        &s->horizontal_tension,
                        &s->gravity,
                        &s->diameter,
                        &s->mass,
                        &s->axial_stiffness,
                        &s->torsional_stiffness,
                        &s->torsional_inertia,
                        &s->ice_mass,
                        &s->ice_torsional_inertia,
                        &s->first_moment_x2,
                        &s->first_moment_x3,
                        &s->air_density,
                        &s->attack_angle,
                        &s->reference_radius,
                        &s->translation_damping.low_ratio,
                        &s->translation_damping.low_frequency,
                        &s->translation_damping.high_ratio,
                        &s->translation_damping.high_frequency,
                        &s->twist_damping.low_ratio,
                        &s->twist_damping.low_frequency,
                        &s->twist_damping.high_ratio,
                        &s->twist_damping.high_frequency,
                        &s->seed_vertical,
                        &s->seed_horizontal,
                        &s->seed_twist,
                        &s->time_step,
                        &s->newton_tolerance,
                        &s->tolerance,
                        &s->spectral_radius};
    for (size_t i = 0; i < sizeof number / sizeof *number; i++) change(in, number[i]);
    aerodynamics_of(in, s);
    law_of(in, &s->wind, 0, 5.5);
    for (int end = 0; end < 2; end++) support_of(in, &s->support[end], end);
    loads_of(in, s);
    s->elements = count_of(in, 3);
    s->start_in_mean_wind = byte_of(in) > 128;
    s->max_newton_iterations = count_of(in, 20);
    s->max_halvings = count_of(in, 1);
}

/* The model of a scene from the input, or NULL, in which case the refusal is a typed one. */
static inline gallop_model *model_of(input *in, gallop_scene *scene)
{
    gallop_model *model;
    gallop_report report;
    scene_of(in, scene);
    const int outcome = gallop_model_create(scene, &model, &report);
    REQUIRE(outcome == report.outcome && outcome >= GALLOP_COMPLETED && outcome <= GALLOP_BAD_CALL);
    REQUIRE((outcome == GALLOP_COMPLETED) == (model != NULL));
    REQUIRE((outcome == GALLOP_INVALID_SCENE) == (report.field != NULL));
    return model;
}

#endif
