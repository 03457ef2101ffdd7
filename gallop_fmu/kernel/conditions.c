/* What acts at one instant, from the laws of the scene or from a host. */
#include "conditions.h"

#include "base_math.h"
#include "law.h"

#include <string.h>

size_t conditions_count(const gallop_model *model)
{
    const size_t sections = 3 * LANES * (size_t)model->strips;
    return (size_t)model->field_count + 3 * (size_t)model->section_count +
           9 * (size_t)model->junction_count +
           (model->varied ? (size_t)model->field_count + 2 * sections : 0);
}

conditions conditions_in(const gallop_model *model, double *block)
{
    const size_t fields = (size_t)model->field_count, sections = (size_t)model->section_count;
    const size_t axes = 3 * (size_t)model->junction_count;
    conditions now = {.load_factor = 1.0, .fallen = model->shedding_time};
    now.wind = block;
    now.attack = now.wind + fields;
    now.c2 = now.attack + sections;
    now.c3 = now.c2 + sections;
    now.position = now.c3 + sections;
    now.velocity = now.position + axes;
    now.acceleration = now.velocity + axes;
    now.direction = now.acceleration + axes;
    now.air = now.direction + fields;
    return now;
}

void conditions_copy(const gallop_model *model, conditions *to, const conditions *from)
{
    memcpy(to->wind, from->wind, conditions_count(model) * sizeof(double));
    to->time = from->time;
    to->load_factor = from->load_factor;
    to->taut = from->taut;
    to->everything = from->everything;
}

void conditions_rotate_moments(const cross_section *section, double attack, double *c2, double *c3)
{
    double sine, cosine;
    sine_cosine(attack - section->moment_angle, &sine, &cosine);
    *c2 = section->moment[0] * cosine - section->moment[1] * sine;
    *c3 = section->moment[0] * sine + section->moment[1] * cosine;
}

/* A host sets the wind speed of each field, the attack angle of the first cross-section, by whose
 * change the others turn as well, and the motion of the tower's points at all junctions. */
static void from_inputs(const gallop_model *model, double t, const gallop_inputs *inputs,
                        conditions *now)
{
    const double dt = t - inputs->time;
    const double attack = inputs->attack_angle + inputs->attack_angle_rate * dt;
    const double *wind_rate = inputs->wind + inputs->fields;
    for (int f = 0; f < model->field_count; f++) now->wind[f] = inputs->wind[f] + wind_rate[f] * dt;
    for (int s = 0; s < model->section_count; s++) {
        now->attack[s] =
            s == 0 ? attack : model->section[s].attack + (attack - model->section[0].attack);
        conditions_rotate_moments(&model->section[s], now->attack[s], &now->c2[s], &now->c3[s]);
    }
    memset(now->position, 0, 9 * (size_t)model->junction_count * sizeof(double));
    const int axes = 3 * inputs->junctions;
    for (int i = 0; i < axes; i++) {
        const double rate = inputs->motion[axes + i];
        now->position[i] = inputs->motion[i] + rate * dt;
        now->velocity[i] = rate;
    }
}

/* Those that a host does not set follow the laws. */
static void set_directions(const gallop_model *model, double t, const gallop_inputs *inputs,
                           conditions *now)
{
    const double *given = inputs ? inputs->direction : NULL;
    for (int f = 0; f < model->field_count; f++) {
        const law *of = model->direction[f];
        now->direction[f] = given ? given[f] + given[inputs->fields + f] * (t - inputs->time)
                          : of    ? law_value(of, t)
                                  : 0.0;
    }
}

static void from_laws(const gallop_model *model, double t, conditions *now)
{
    for (int f = 0; f < model->field_count; f++) now->wind[f] = law_value(model->wind[f], t);
    for (int s = 0; s < model->section_count; s++) {
        now->attack[s] = model->section[s].attack;
        now->c2[s] = model->section[s].c2;
        now->c3[s] = model->section[s].c3;
    }
    for (int j = 0; j < model->junction_count; j++)
        for (int i = 0; i < 3; i++) {
            const law *motion = model->junction[j].motion[i];
            now->position[3 * j + i] = motion ? law_value(motion, t) : 0.0;
            now->velocity[3 * j + i] = motion ? law_rate(motion, t) : 0.0;
            now->acceleration[3 * j + i] = motion ? law_second(motion, t) : 0.0;
        }
}

void conditions_at(const gallop_model *model, double t, const gallop_inputs *inputs,
                   conditions *now)
{
    now->time = t;
    now->load_factor = 1.0;
    now->taut = now->everything = false;
    if (inputs)
        from_inputs(model, t, inputs, now);
    else
        from_laws(model, t, now);
    if (!model->varied) return;
    set_directions(model, t, inputs, now);
    conditions_blow(model, true, now);
}

bool conditions_are_finite(const gallop_model *model, const conditions *now)
{
    bool finite = isfinite(now->load_factor);
    const size_t count = conditions_count(model);
    for (size_t i = 0; i < count; i++) finite = finite && isfinite(now->wind[i]);
    return finite;
}
