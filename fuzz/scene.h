/* Shared by the targets that make a model: a scene whose numbers, coefficient table, laws and
 * loads come from the input, mostly those of example 3. */
#ifndef FUZZING_SCENE_H
#define FUZZING_SCENE_H

#include "gallop.h"
#include "input.h"

#include <stdbool.h>
#include <stddef.h>

#define MOST 4 /* pieces, points of a table, loads */

enum {
    LAWS = 10,
    CURVE_NUMBERS = 14 * MOST + 1,
    WIND_NUMBERS = 2 * MOST + 2 * MOST + 3 * MOST * MOST, /* ground, stations, times, gusts */
    FIRST_OF_WIND = CURVE_NUMBERS + 2 * MOST * LAWS,
    NUMBERS = FIRST_OF_WIND + WIND_NUMBERS
};

static double number[NUMBERS]; /* the curve, a table of each law, then those of the wind */
static gallop_cross_section cross_section;
static gallop_curve curve;
static gallop_field field;
static gallop_junction junction[2];
static gallop_chain chain;
static gallop_device device[2];
static gallop_load load[MOST];
static gallop_law law[LAWS]; /* wind, motion of the left and the right end, loads, direction */

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

/* Mostly the right index. */
static inline int32_t index_of(input *in, int32_t usual)
{
    const uint8_t b = byte_of(in);
    return b < 250 ? usual : b - 253;
}

static inline void law_of(input *in, int which, double usual)
{
    gallop_law *l = &law[which];
    const uint8_t kind = byte_of(in);
    double *time = number + CURVE_NUMBERS + 2 * MOST * which, *value;
    *l = (gallop_law){.kind = kind < 128 ? GALLOP_LAW_CONSTANT
                            : kind < 250 ? kind % 4
                                         : kind - 252};
    l->initial = l->peak = l->amplitude = usual;
    l->rise = l->fall = l->frequency = 0.1;
    l->fall_start = 0.2;
    l->first = (int32_t)(time - number);
    if (l->kind != GALLOP_LAW_CONSTANT) {
        double *of_law[] = {&l->peak,       &l->amplitude, &l->start,     &l->rise,
                            &l->fall_start, &l->fall,      &l->frequency, &l->phase};
        for (size_t i = 0; i < sizeof of_law / sizeof *of_law; i++) change(in, of_law[i]);
        l->count = count_of(in, 3);
        value = time + (l->count > 0 && l->count <= MOST ? l->count : MOST);
        for (int i = 0; i < MOST; i++) {
            double at[2] = {0.05 * i, usual * (1.0 + 0.1 * i)};
            change(in, &at[0]);
            change(in, &at[1]);
            time[i] = at[0];
            value[i] = at[1];
        }
        for (int i = 0; i < l->count && i < MOST; i++) time[i] = 0.05 * i + 1e-3 * time[i];
    }
    change(in, &l->initial);
}

static inline void curve_of(input *in)
{
    static const double usual[12] = {0.0, -4.5, 0.0, 3.0, 1.0, 0.0, 0.5, 0.0, 0.0, -0.3, 0.0, 0.2};
    curve = (gallop_curve){.pieces = count_of(in, 1), .outside = byte_of(in) % 4};
    const int pieces = curve.pieces > 0 && curve.pieces <= MOST ? curve.pieces : MOST;
    double *origin = number + pieces + 1, *coefficient = origin + pieces;
    for (int i = 0; i <= pieces; i++) {
        number[i] = 1.75 + 2.8 * i;
        change(in, &number[i]);
    }
    for (int i = 0; i < pieces; i++) {
        origin[i] = 3.14159;
        change(in, &origin[i]);
        memcpy(coefficient + 12 * i, usual, sizeof usual);
        for (int k = 0; k < 12; k++) change(in, &coefficient[12 * i + k]);
    }
}

/* An end of the span, and the device that holds it. */
static inline void support_of(input *in, gallop_scene *s, int end)
{
    static const double usual[2][4] = {{7.6e4, 0.0, 1.4e3, 0.0}, {120.0, 1.5e4, 2.0, 300.0}};
    const uint8_t kind = byte_of(in);
    const bool rigid = kind < 128;
    junction[end] = (gallop_junction){.position = {end ? 125.9 : 0.0, 0.0, 0.0},
                                      .fixed = {rigid, 1, rigid, 1},
                                      .motion = {-1, -1, -1}};
    if (end)
        for (int i = 0; i < 2; i++) change(in, &junction[1].position[i]);
    if (!rigid) {
        gallop_device *d = &device[s->device_count++];
        *d = (gallop_device){.kind = kind % 3, .junction = {index_of(in, end), index_of(in, -1)}};
        memcpy(d->parameter, usual[kind % 2], sizeof usual[0]);
        for (int i = 0; i < 4; i++) change(in, &d->parameter[i]);
    }
    for (int i = 0; i < 3; i++) {
        law_of(in, 1 + 3 * end + i, 0.0);
        junction[end].motion[i] = index_of(in, 1 + 3 * end + i);
    }
}

static inline void loads_of(input *in, gallop_scene *s)
{
    s->load_count = count_of(in, 0);
    memset(load, 0, sizeof load);
    for (int i = 0; i < MOST && i < s->load_count; i++) {
        load[i].evenly_spaced = count_of(in, 3);
        load[i].position = 0.5;
        load[i].force[1] = 10.0;
        double *of_load[] = {&load[i].position, &load[i].force[0], &load[i].force[1],
                             &load[i].force[2], &load[i].torque};
        for (size_t k = 0; k < sizeof of_load / sizeof *of_load; k++) change(in, of_load[k]);
        law_of(in, 7 + i % 2, 1.0);
        load[i].law = index_of(in, 7 + i % 2);
    }
}

static inline void cross_section_of(input *in)
{
    gallop_cross_section *c = &cross_section;
    *c = (gallop_cross_section){.diameter = 0.0188,
                                .mass = 1.53,
                                .axial_stiffness = 13.3e6,
                                .torsional_stiffness = 101.0,
                                .torsional_inertia = 3.3e-4,
                                .attack_angle = 3.14159,
                                .translation_damping = {0.016, 0.378, 0.016, 0.695},
                                .twist_damping = {0.057, 3.93, 0.057, 7.87},
                                .ice_mass = 0.1,
                                .ice_torsional_inertia = 1e-5,
                                .first_moment_x2 = 1e-4,
                                .first_moment_x3 = 1e-4,
                                .curve = index_of(in, 0)};
    double *of_section = &c->diameter; /* numbers alone, up to the index of the curve */
    const size_t count = offsetof(gallop_cross_section, curve) / sizeof(double);
    for (size_t i = 0; i < count; i++) change(in, of_section + i);
}

static inline void settings_of(input *in, gallop_settings *s)
{
    *s = (gallop_settings){.gravity = 9.81,
                           .air_density = 1.2929,
                           .time_step = 0.01,
                           .newton_tolerance = 1e-9,
                           .seed_vertical = 1e-3,
                           .seed_horizontal = 1e-3,
                           .spectral_radius = 0.8};
    const uint8_t how = byte_of(in); /* mostly an integrator that there is */
    s->integrator = how < 240 ? how % 3 : how - 242;
    cross_section.slack = how / 16 % 2;
    s->laws_only = how / 2 % 2;
    if (how / 4 % 4 == 3) s->tolerance = 1e-3;
    double *of_settings = &s->gravity;
    const size_t count = offsetof(gallop_settings, max_newton_iterations) / sizeof(double);
    for (size_t i = 0; i < count; i++) change(in, of_settings + i);
}

/* Direction, profile and gusts; times and places mostly increase. */
static inline void wind_of(input *in)
{
    double *ground = number + FIRST_OF_WIND, *gust = ground + 2 * MOST;
    if (byte_of(in) < 128) return;
    law_of(in, 9, 0.5);
    field.kind = index_of(in, GALLOP_FIELD_VARIED);
    field.direction = index_of(in, 9);
    field.profile = byte_of(in) % 4;
    field.profile_parameter = 0.2;
    field.reference_height = 10.0;
    field.ground_points = count_of(in, 2);
    field.first_ground = index_of(in, FIRST_OF_WIND);
    field.stations = count_of(in, 3);
    field.times = count_of(in, 4);
    field.components = count_of(in, 3);
    field.first_gust = index_of(in, FIRST_OF_WIND + 2 * MOST);
    field.repeat = byte_of(in) % 4;
    change(in, &field.profile_parameter);
    change(in, &field.reference_height);
    const int points =
        field.ground_points > 0 && field.ground_points < MOST ? field.ground_points : MOST;
    const int stations = field.stations > 0 && field.stations < MOST ? field.stations : MOST;
    const int rest = WIND_NUMBERS - 2 * MOST;
    for (int i = 0; i < 2 * MOST; i++) ground[i] = i < points ? 90.0 * i : -20.0;
    for (int i = 0; i < rest; i++)
        gust[i] = i < stations        ? 50.0 * i
                : i < stations + MOST ? 0.012 * (i - stations)
                                      : 0.1 * (i % 5 - 2);
    for (int i = 0; i < 2 * MOST; i++) change(in, &ground[i]);
    for (int i = 0; i < rest; i++) change(in, &gust[i]);
}

static inline void scene_of(input *in, gallop_scene *s)
{
    *s = (gallop_scene){.cross_section_count = 1,
                        .curve_count = 1,
                        .field_count = 1,
                        .junction_count = 2,
                        .chain_count = 1,
                        .law_count = LAWS,
                        .number_count = NUMBERS,
                        .cross_section = &cross_section,
                        .curve = &curve,
                        .field = &field,
                        .junction = junction,
                        .chain = &chain,
                        .device = device,
                        .load = load,
                        .law = law,
                        .number = number};
    memset(law, 0, sizeof law);
    cross_section_of(in);
    settings_of(in, &s->settings);
    chain = (gallop_chain){.junction = {index_of(in, 0), index_of(in, 1)}, .sag = 2.12};
    chain.horizontal_tension = byte_of(in) % 2 ? 0.0 : 1.5e4;
    change(in, &chain.sag);
    change(in, &chain.horizontal_tension);
    curve_of(in);
    law_of(in, 0, 5.5);
    field = (gallop_field){.law = index_of(in, 0)};
    for (int end = 0; end < 2; end++) support_of(in, s, end);
    loads_of(in, s);
    chain.elements = count_of(in, 3);
    s->settings.start_in_mean_wind = byte_of(in) > 128;
    s->settings.max_newton_iterations = count_of(in, 20);
    s->settings.max_halvings = count_of(in, 1);
    wind_of(in);
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
