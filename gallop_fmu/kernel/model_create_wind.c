/* Places in varied fields of wind: stations of gusts, and the factor of the profile. */
#include "model_create.h"

#include "base_glibc.h"
#include "element.h"
#include "report.h"

bool model_create_is_varied(const gallop_scene *s)
{
    bool varied = false;
    for (int i = 0; i < s->field_count; i++)
        varied = varied || s->field[i].kind == GALLOP_FIELD_VARIED;
    return varied;
}

/* Of x that increase: the point before `at` and the next one, and the weight of the latter; held
 * outside. */
static void between(const double *x, int count, double at, int point[2], double *weight)
{
    point[0] = point[1] = at <= x[0] ? 0 : count - 1;
    *weight = 0.0;
    if (at <= x[0] || at >= x[count - 1]) return;
    point[0] = law_point_before(x, count, at);
    point[1] = point[0] + 1;
    *weight = (at - x[point[0]]) / (x[point[1]] - x[point[0]]);
}

static double height_above_ground(const gallop_field *f, const double *number, const double x[2])
{
    const double *x1 = number + f->first_ground, *x2 = x1 + f->ground_points;
    int point[2];
    double weight;
    between(x1, f->ground_points, x[0], point, &weight);
    return x[1] - (x2[point[0]] + weight * (x2[point[1]] - x2[point[0]]));
}

/* The place at x1 and x2 in the initial equilibrium. */
static int place_in_field(const gallop_field *f, const double *number, const double x[2],
                          const double normal[2], wind_place *place, gallop_report *report)
{
    int station[2] = {0, 0};
    *place = (wind_place){.factor = 1.0, .normal = {normal[0], normal[1]}};
    if (f->stations > 0)
        between(number + f->first_gust, f->stations, x[0], station, &place->weight);
    place->station = station[0];
    place->next = station[1];
    if (f->profile == GALLOP_PROFILE_NONE) return GALLOP_COMPLETED;

    const bool is_power = f->profile == GALLOP_PROFILE_POWER;
    const double height = height_above_ground(f, number, x), parameter = f->profile_parameter,
                 lowest = is_power ? 0.0 : parameter;
    if (!(height > lowest))
        return report_invalid(report, "height of a conductor above ground, for the wind profile",
                              height, lowest);
    place->factor = is_power ? pow(height / f->reference_height, parameter)
                             : log(height / parameter) / log(f->reference_height / parameter);
    return GALLOP_COMPLETED;
}

/* Lanes beyond the last element repeat it. */
static int place_sections(gallop_model *m, const interval *c, const gallop_field *f,
                          gallop_report *report)
{
    wind_place *place = m->section_place + 3 * LANES * (size_t)c->first_strip;
    for (int k = 0; k < 3 * LANES * c->strips; k++) {
        const int lane = k % LANES, q = k / LANES % 3, own = k / (3 * LANES) * LANES + lane;
        const int e = own < c->elements ? own : c->elements - 1;
        const double *shape = element_shape3[q], *x = c->x + 6 * e;
        const double at[2] = {shape[0] * x[0] + shape[1] * x[3] + shape[2] * x[6],
                              shape[0] * x[1] + shape[1] * x[4] + shape[2] * x[7]};
        const int outcome =
            place_in_field(f, m->scene.number, at, c->geometry[e].normal[q], &place[k], report);
        if (outcome) return outcome;
    }
    return GALLOP_COMPLETED;
}

int model_create_wind_places(gallop_model *m, gallop_report *report)
{
    int outcome = GALLOP_COMPLETED;
    for (int i = 0; i < m->interval_count && !outcome; i++) {
        const interval *c = &m->interval[i];
        const gallop_field *f = &m->scene.field[c->field];
        if (f->kind != GALLOP_FIELD_VARIED) continue;
        outcome = place_sections(m, c, f, report);
        for (int n = c->first_node; n < c->first_node + c->nodes && !outcome; n++)
            outcome = place_in_field(f, m->scene.number, m->x + 3 * n, m->normal + 2 * n,
                                     &m->node_place[n], report);
    }
    return outcome;
}
