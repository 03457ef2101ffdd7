/* The wind of varied fields: see gallop_field. */
#include "base_math.h"
#include "conditions.h"

/* A field at one instant. */
typedef struct {
    double speed, sine, cosine;   /* of the direction */
    int components;               /* of the gusts; 0: there are none */
    const double *before, *after; /* rows of gusts (stations, components), and */
    double weight;                /* that of the later one */
} field_now;

/* The rows of gusts between which the time lies, found by bisection: nothing needs to be stored. */
static void find_rows(const gallop_field *f, const double *number, double t, field_now *air)
{
    const double *time = number + f->first_gust + f->stations, *row = time + f->times;
    const int last = f->times - 1;
    const size_t size = (size_t)f->stations * (size_t)f->components;
    if (f->repeat) t = law_fold(time, f->times, t);
    air->components = f->components;
    if (t <= time[0] || t >= time[last]) { /* held outside; also the only row */
        air->before = air->after = row + (t <= time[0] ? 0 : size * (size_t)last);
        return;
    }
    const int low = law_point_before(time, f->times, t);
    air->before = row + size * (size_t)low;
    air->after = air->before + size;
    air->weight = (t - time[low]) / (time[low + 1] - time[low]);
}

static field_now field_at(const gallop_model *model, const conditions *now, int field,
                          bool with_gusts)
{
    const gallop_field *f = &model->scene.field[field];
    field_now air = {.speed = now->wind[field]};
    sine_cosine(now->direction[field], &air.sine, &air.cosine);
    if (with_gusts && f->stations > 0) find_rows(f, model->scene.number, now->time, &air);
    return air;
}

/* A component of the gust at a place, linear in time and place. */
static inline double gust_at(const field_now *air, const wind_place *at, int component)
{
    const int left = at->station * air->components + component,
              right = at->next * air->components + component;
    const double here = air->before[left] + air->weight * (air->after[left] - air->before[left]),
                 next = air->before[right] + air->weight * (air->after[right] - air->before[right]);
    return here + at->weight * (next - here);
}

/* W2 and W3 along n2 and n3 = e3; see gallop_field. */
static inline void wind_across(const field_now *air, const wind_place *at, double wind[2])
{
    const double speed = air->speed * at->factor;
    double along = speed, across = 0.0, up = 0.0;
    if (air->components > 0) along = speed * (1.0 + gust_at(air, at, 0));
    if (air->components > 1) {
        across = speed * gust_at(air, at, 1);
        up = speed * gust_at(air, at, 2);
    }
    wind[0] = at->normal[0] * (along * air->sine + across * air->cosine) + at->normal[1] * up;
    wind[1] = along * air->cosine - across * air->sine;
}

void conditions_blow(const gallop_model *model, bool with_gusts, conditions *now)
{
    if (!model->varied) return;
    double *n2 = now->air, *n3 = n2 + 3 * LANES * (size_t)model->strips;
    field_now air = {0};
    for (int i = 0, known = -1; i < model->interval_count; i++) {
        const interval *c = &model->interval[i];
        const size_t first = 3 * LANES * (size_t)c->first_strip;
        const size_t end = first + 3 * LANES * (size_t)c->strips;
        if (model->scene.field[c->field].kind != GALLOP_FIELD_VARIED) continue;
        if (c->field != known) air = field_at(model, now, c->field, with_gusts);
        known = c->field;
        for (size_t k = first; k < end; k++) {
            double wind[2];
            wind_across(&air, &model->section_place[k], wind);
            n2[k] = wind[0];
            n3[k] = wind[1];
        }
    }
}

void conditions_wind_at(const gallop_model *model, const conditions *now, int field,
                        const wind_place *place, double wind[2])
{
    wind[0] = 0.0;
    wind[1] = now->wind[field];
    if (model->scene.field[field].kind != GALLOP_FIELD_VARIED) return;
    const field_now air = field_at(model, now, field, true);
    wind_across(&air, place, wind);
}
