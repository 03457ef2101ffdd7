/* Functions for analyses outside of the kernel: residual and tangent of any motion, wind load on
 * any section, geometry of the elements. */
#include "base_math.h"
#include "check.h"
#include "device.h"
#include "element.h"
#include "gallop_analysis.h"
#include "time_integration.h"

/* Whether residual and tangent of this motion can be taken: of finite numbers. */
static bool computable(const gallop_model *model, const gallop_state *work, double time,
                       const gallop_inputs *inputs, const double *const given[3], const double *out)
{
    gallop_report report;
    if (check_room(model, work, time, &report) || !base_pointer_usable(out, WORD)) return false;
    for (int i = 0; i < 3; i++)
        if (!base_pointer_usable(given[i], WORD) ||
            !check_finite(given[i], 4 * (size_t)model->nodes))
            return false;
    return check_inputs(model, inputs, time, &report) == GALLOP_COMPLETED;
}

/* A caller's own motion may move what the scene leaves at rest, so that everything is computed. */
static conditions any_motion(const gallop_model *model, const state_view *view, double time,
                             const gallop_inputs *inputs)
{
    conditions now = view->stage[0];
    conditions_at(model, time, inputs, &now);
    now.everything = true;
    now.fallen = model->shedding_time; /* `work` need not be a state */
    return now;
}

/* The blocks of an element tangent as a matrix of 12 rows. */
static void unfold(double block[6][16], double matrix[144])
{
    static const int block_of[3][3] = {{LEFT_LEFT, LEFT_MIDDLE, LEFT_RIGHT},
                                       {LEFT_MIDDLE, MIDDLE_MIDDLE, MIDDLE_RIGHT},
                                       {LEFT_RIGHT, MIDDLE_RIGHT, RIGHT_RIGHT}};
    for (int n = 0; n < 3; n++)
        for (int b = 0; b < 3; b++)
            for (int i = 0; i < 4; i++)
                for (int j = 0; j < 4; j++)
                    matrix[12 * (4 * n + i) + 4 * b + j] = block[block_of[n][b]][4 * i + j];
}

int gallop_residual(const gallop_model *model, gallop_state *work, double time,
                    const gallop_inputs *inputs, const double *u, const double *v, const double *a,
                    double *residual)
{
    const double *const given[3] = {u, v, a};
    if (!computable(model, work, time, inputs, given, residual)) return GALLOP_BAD_CALL;
    state_view at = state_view_of(model, work);
    conditions now = any_motion(model, &at, time, inputs);
    monitor seen;
    element_monitor_start(&seen);
    element_sum_residual(model, time, &now, &at.sections, (motion){u, v, a}, false, residual,
                         &seen);
    return GALLOP_COMPLETED;
}

int gallop_tangent(const gallop_model *model, gallop_state *work, double time,
                   const gallop_inputs *inputs, const double *u, const double *v, const double *a,
                   double k, double c, double m, double *tangent)
{
    const double *const given[3] = {u, v, a};
    if (!computable(model, work, time, inputs, given, tangent)) return GALLOP_BAD_CALL;
    if (!isfinite(k) || !isfinite(c) || !isfinite(m)) return GALLOP_BAD_CALL;
    state_view at = state_view_of(model, work);
    conditions now = any_motion(model, &at, time, inputs);
    const motion y = {u, v, a};
    monitor seen;
    element_monitor_start(&seen);
    element_sum_residual(model, time, &now, &at.sections, y, true, at.residual, &seen);
    for (int i = 0; i < model->interval_count; i++) { /* the sections hold the slopes now */
        const interval *of = &model->interval[i];
        const exposure on = conditions_on(model, &now, of);
        for (int e = 0; e < of->elements; e++) {
            double block[6][16], *out = tangent + 144 * (size_t)(of->first_element + e);
            element_tangent(of, e, &on, &at.sections, u + 4 * of->first_node + 8 * e,
                            (tangent_weights){k, c, m}, block);
            unfold(block, out);
        }
    }
    return GALLOP_COMPLETED;
}

static bool is_device(const gallop_model *model, int32_t index)
{
    return index >= 0 && index < model->device_count;
}

int gallop_device_force(const gallop_model *model, gallop_state *work, double time,
                        const gallop_inputs *inputs, const double *u, const double *v,
                        const double *a, int32_t index, double *force, double energy[2])
{
    const double *const given[3] = {u, v, a};
    if (!computable(model, work, time, inputs, given, force)) return GALLOP_BAD_CALL;
    if (!is_device(model, index) || (energy && !base_pointer_usable(energy, WORD)))
        return GALLOP_BAD_CALL;
    const state_view at = state_view_of(model, work);
    const conditions now = any_motion(model, &at, time, inputs);
    const motion y = {u, v, a};
    double all[GALLOP_DEVICE_JUNCTIONS][4];
    device_force(model, &model->device[index], &now, y, all);
    memcpy(force, all, (size_t)model->device[index].junctions * sizeof *all);
    if (!energy) return GALLOP_COMPLETED;
    energy[GALLOP_KINETIC_ENERGY] = energy[GALLOP_POTENTIAL_ENERGY] = 0.0;
    device_add_energy(model, &model->device[index], &now, y, &energy[GALLOP_KINETIC_ENERGY],
                      &energy[GALLOP_POTENTIAL_ENERGY]);
    return GALLOP_COMPLETED;
}

int gallop_device_tangent(const gallop_model *model, gallop_state *work, double time,
                          const gallop_inputs *inputs, const double *u, const double *v,
                          const double *a, double k, double c, double m, int32_t index,
                          double *tangent)
{
    const double *const given[3] = {u, v, a};
    if (!computable(model, work, time, inputs, given, tangent)) return GALLOP_BAD_CALL;
    if (!isfinite(k) || !isfinite(c) || !isfinite(m)) return GALLOP_BAD_CALL;
    if (!is_device(model, index)) return GALLOP_BAD_CALL;
    const state_view at = state_view_of(model, work);
    const conditions now = any_motion(model, &at, time, inputs);
    const int count = model->device[index].junctions;
    device_block all[GALLOP_DEVICE_JUNCTIONS * GALLOP_DEVICE_JUNCTIONS];
    device_tangent(model, &model->device[index], &now, (motion){u, v, a},
                   (tangent_weights){k, c, m}, all);
    memcpy(tangent, all, (size_t)(count * count) * sizeof *all);
    return GALLOP_COMPLETED;
}

int gallop_device_load(const gallop_model *model, int32_t index, int32_t count, const double *u,
                       const double *v, double *force, double *by_u, double *by_v)
{
    if (!check_is_model(model) || !is_device(model, index) || count < 0) return GALLOP_BAD_CALL;
    const device *d = &model->device[index];
    const size_t of_motion = 4 * (size_t)d->junctions, of_slope = of_motion * of_motion;
    const double *const given[2] = {u, v}, *const out[3] = {force, by_u, by_v};
    for (int i = 0; i < 2; i++)
        if (!base_pointer_usable(given[i], WORD) ||
            !check_finite(given[i], of_motion * (size_t)count))
            return GALLOP_BAD_CALL;
    for (int i = 0; i < 3; i++)
        if (!base_pointer_usable(out[i], WORD)) return GALLOP_BAD_CALL;
    for (size_t i = 0; i < (size_t)count; i++)
        device_load(model, d, u + of_motion * i, v + of_motion * i, force + of_motion * i,
                    (device_block *)(by_u + of_slope * i), (device_block *)(by_v + of_slope * i));
    return GALLOP_COMPLETED;
}

int gallop_junction_nodes(const gallop_model *model, int32_t *node, int32_t *leader)
{
    if (!check_is_model(model) || !base_pointer_usable(node, sizeof *node) ||
        !base_pointer_usable(leader, sizeof *leader))
        return GALLOP_BAD_CALL;
    for (int j = 0; j < model->junction_count; j++) node[j] = model->junction[j].node;
    for (int n = 0; n < model->nodes; n++) leader[n] = n;
    for (int t = 0; t < model->tie_count; t++)
        leader[model->tie[t].follower] = model->tie[t].leader;
    return GALLOP_COMPLETED;
}

/* Sections whose load is computed at once: their intermediate results stay in the first-level
 * cache. */
#define SECTIONS_AT_ONCE 64

/* Room for the arrays of `sections` that ice and wind load read and write. */
typedef struct {
    double theta[SECTIONS_AT_ONCE], omega[SECTIONS_AT_ONCE], omega_rate[SECTIONS_AT_ONCE],
        v2[SECTIONS_AT_ONCE], v3[SECTIONS_AT_ONCE], a2[SECTIONS_AT_ONCE], a3[SECTIONS_AT_ONCE],
        gravity[SECTIONS_AT_ONCE], c2[SECTIONS_AT_ONCE], c3[SECTIONS_AT_ONCE],
        angle[SECTIONS_AT_ONCE], excess[SECTIONS_AT_ONCE];
    double force[3][SECTIONS_AT_ONCE], by_theta[3][SECTIONS_AT_ONCE], by_v2[3][SECTIONS_AT_ONCE],
        by_v3[3][SECTIONS_AT_ONCE];
} section_room;

static sections sections_in(section_room *room)
{
    sections at = {.theta = room->theta,
                   .omega = room->omega,
                   .omega_rate = room->omega_rate,
                   .v2 = room->v2,
                   .v3 = room->v3,
                   .a2 = room->a2,
                   .a3 = room->a3,
                   .gravity = room->gravity,
                   .c2 = room->c2,
                   .c3 = room->c3,
                   .angle = room->angle,
                   .excess = room->excess};
    for (int i = 0; i < 3; i++) {
        at.force[i] = room->force[i];
        at.by_theta[i] = room->by_theta[i];
        at.by_v2[i] = room->by_v2[i];
        at.by_v3[i] = room->by_v3[i];
    }
    return at;
}

/* By how much the attack angle of a section is beyond the last breakpoint (positive) or before the
 * first one (negative), where a simulation would refuse it; else 0. */
static double refused_excess(const interval *c, const exposure *now, const sections *at, int i)
{
    const bool refuses = now->section->curve->outside == GALLOP_OUTSIDE_ERROR;
    if (!refuses || !(at->excess[i] > 0.0)) return 0.0;
    if (!element_wind_matters(c, now, at, i)) return 0.0;
    double offset = at->angle[i] - now->section->curve->centre;
    offset -= 2.0 * PI * nearest(offset * (0.5 / PI));
    return offset < 0.0 ? -at->excess[i] : at->excess[i];
}

/* The wind speed of a section enters by v3 alone, as U - v3: so the exposure has no wind, and v3 is
 * relative to the air. */
static void read_sections(const double *given, size_t stride, int count, section_room *room)
{
    memset(room->force, 0, sizeof room->force);
    for (int i = 0; i < count; i++) {
        room->theta[i] = given[i];
        room->v2[i] = given[stride + i];
        room->v3[i] = given[2 * stride + i] - given[4 * stride + i];
        room->omega[i] = given[3 * stride + i];
    }
}

/* The results of gallop_aero_load, from one section on. */
typedef struct {
    double *load, *slopes, *angle, *excess;
} load_arrays;

/* Writes section `i` of the room to place `i` of the arrays, whose rows are `stride` apart. */
static void write_section(const section_room *room, int i, double radius, bool blows, size_t stride,
                          load_arrays out)
{
    for (int row = 0; row < 3; row++) {
        out.load[row * stride + i] = blows ? -room->force[row][i] : 0.0;
        if (!out.slopes) continue;
        const double by[4] = {room->by_theta[row][i], room->by_v2[row][i], room->by_v3[row][i],
                              radius * room->by_v2[row][i]};
        for (int k = 0; k < 4; k++) out.slopes[(3 * k + row) * stride + i] = blows ? by[k] : 0.0;
    }
}

/* The load on `count` sections, no more than SECTIONS_AT_ONCE. */
static void load_block(const interval *c, const exposure *now, const double *given, int count,
                       size_t stride, load_arrays out)
{
    section_room room;
    const sections at = sections_in(&room);
    const cross_section *section = now->section;
    read_sections(given, stride, count, &room);
    if (section->curve) element_aero_loads(c, now, &at, 0, count, out.slopes != NULL);
    for (int i = 0; i < count; i++) {
        const bool blows = section->curve && given[4 * stride + i] != 0.0;
        write_section(&room, i, section->radius, blows, stride, out);
        out.angle[i] = section->curve ? room.angle[i]
                                      : element_attack_angle(room.theta[i], room.v2[i], room.v3[i],
                                                             room.omega[i], now->wind, now->attack,
                                                             section->radius);
        out.excess[i] = blows ? refused_excess(c, now, &at, i) : 0.0;
    }
}

static bool all_usable(const double *const pointer[], int count)
{
    for (int i = 0; i < count; i++)
        if (!base_pointer_usable(pointer[i], WORD)) return false;
    return true;
}

int gallop_aero_load(const gallop_model *model, int32_t element, double attack_angle, int32_t count,
                     const double *given, double *load, double *slopes, double *angle,
                     double *excess)
{
    const double *const arrays[5] = {given, load, angle, excess, slopes ? slopes : load};
    if (!check_is_model(model) || gallop_arithmetic_fault()) return GALLOP_BAD_CALL;
    if (element < 0 || element >= model->elements || count < 0) return GALLOP_BAD_CALL;
    if (!isfinite(attack_angle) || !all_usable(arrays, 5)) return GALLOP_BAD_CALL;
    const size_t stride = (size_t)count;
    if (!check_finite(given, 5 * stride)) return GALLOP_BAD_CALL;
    const interval *c = model_interval_of_element(model, element);
    const exposure now = {.section = c->section,
                          .attack = attack_angle,
                          .unknowns = 4,
                          .blows = true,
                          .fused = model->fused};
    for (int32_t first = 0; first < count; first += SECTIONS_AT_ONCE) {
        const int left = count - first, some = left < SECTIONS_AT_ONCE ? left : SECTIONS_AT_ONCE;
        const load_arrays out = {load + first, slopes ? slopes + first : NULL, angle + first,
                                 excess + first};
        load_block(c, &now, given + first, some, stride, out);
    }
    return GALLOP_COMPLETED;
}

/* A motion in shapes, and the load collected by them; see gallop_shape_load. */
typedef struct {
    int sections, modes;
    size_t count; /* of instants: the length of the rows of motion and force */
    const double *table, *shape, *weight, *motion;
    double *force;
} shape_motion;

/* Row `row` of a section's numbers: attack angle, first moments, gravity, wind. */
enum { OF_ATTACK, OF_M2, OF_M3, OF_GRAVITY, OF_AIR2, OF_AIR3, SECTION_ROWS };

static double of_section(const shape_motion *m, int row, int section)
{
    return m->table[row * m->sections + section];
}

/* Displacement, velocity or acceleration (part 0, 1, 2) of a section along one of its directions,
 * of `some` instants: the sum over the shapes. */
INLINE void section_moves(const shape_motion *m, int part, int direction, int section, size_t first,
                          int some, double *restrict out)
{
    for (int i = 0; i < some; i++) out[i] = 0.0;
    for (int k = 0; k < m->modes; k++) {
        const double by = m->shape[(direction * m->modes + k) * m->sections + section];
        const double *restrict y = m->motion + (size_t)(part * m->modes + k) * m->count + first;
        for (int i = 0; i < some; i++) out[i] += by * y[i];
    }
}

/* The motion of a section relative to the air. */
INLINE void move_section(const shape_motion *m, int section, size_t first, int some,
                         section_room *room)
{
    const double *restrict wind = m->motion + (size_t)(3 * m->modes) * m->count + first;
    const double air2 = of_section(m, OF_AIR2, section), air3 = of_section(m, OF_AIR3, section);
    section_moves(m, 0, 2, section, first, some, room->theta);
    section_moves(m, 1, 0, section, first, some, room->v2);
    section_moves(m, 1, 1, section, first, some, room->v3);
    section_moves(m, 1, 2, section, first, some, room->omega);
    section_moves(m, 2, 0, section, first, some, room->a2);
    section_moves(m, 2, 1, section, first, some, room->a3);
    section_moves(m, 2, 2, section, first, some, room->omega_rate);
    for (int i = 0; i < some; i++) {
        room->v2[i] -= air2 * wind[i];
        room->v3[i] -= air3 * wind[i];
        room->gravity[i] = of_section(m, OF_GRAVITY, section);
    }
}

/* Adds the load on a section to the forces, without the part of the ice that is linear about rest:
 * f2 = -m3 omega', f3 = m2 omega', M = m2 a3 - m3 a2 - g m2 theta. */
INLINE void collect_section(const shape_motion *m, int section, size_t first, int some,
                            section_room *room)
{
    const double m2 = of_section(m, OF_M2, section), m3 = of_section(m, OF_M3, section);
    double *restrict f2 = room->force[0], *restrict f3 = room->force[1],
                     *restrict twist = room->force[2];
    for (int i = 0; i < some; i++) {
        f2[i] += m3 * room->omega_rate[i];
        f3[i] -= m2 * room->omega_rate[i];
        twist[i] -= m2 * room->a3[i] - m3 * room->a2[i] - room->gravity[i] * m2 * room->theta[i];
    }
    for (int k = 0; k < m->modes; k++) {
        const double *weight = m->weight + (size_t)k * m->sections + section;
        const size_t row = (size_t)m->modes * m->sections;
        double *restrict force = m->force + (size_t)k * m->count + first;
        for (int i = 0; i < some; i++)
            force[i] += weight[0] * f2[i] + weight[row] * f3[i] + weight[2 * row] * twist[i];
    }
}
PATHS(move_section,
      (const shape_motion *m, int section, size_t first, int some, section_room *room),
      (m, section, first, some, room))
PATHS(collect_section,
      (const shape_motion *m, int section, size_t first, int some, section_room *room),
      (m, section, first, some, room))

/* Takes the wind load from the forces of a section, but at instants without wind. */
static void take_air(const interval *c, const exposure *now, const double *wind, int some,
                     section_room *room)
{
    const sections at = sections_in(room);
    double before[3][SECTIONS_AT_ONCE];
    memcpy(before, room->force, sizeof before);
    element_aero_loads(c, now, &at, 0, some, false);
    for (int i = 0; i < some; i++)
        for (int row = 0; row < 3 && wind[i] == 0.0; row++) room->force[row][i] = before[row][i];
}

static void shape_block(const gallop_model *model, const int32_t *element, const shape_motion *m,
                        size_t first, int some)
{
    section_room room;
    const sections at = sections_in(&room);
    const double *wind = m->motion + (size_t)(3 * m->modes) * m->count + first;
    for (int s = 0; s < m->sections; s++) {
        const interval *c = model_interval_of_element(model, element[s]);
        const exposure now = {.section = c->section,
                              .attack = of_section(m, OF_ATTACK, s),
                              .c2 = of_section(m, OF_M2, s),
                              .c3 = of_section(m, OF_M3, s),
                              .unknowns = 4,
                              .blows = true,
                              .fused = model->fused};
        ON_PATH(model->fused, move_section)(m, s, first, some, &room);
        element_ice_inertia(&now, &at, some);
        if (now.section->curve) take_air(c, &now, wind, some, &room);
        ON_PATH(model->fused, collect_section)(m, s, first, some, &room);
    }
}

int gallop_shape_load(const gallop_model *model, int32_t places, const int32_t *element,
                      const double *table, int32_t modes, const double *shape, const double *weight,
                      int32_t count, const double *moves, double *force)
{
    const double *const arrays[5] = {table, shape, weight, moves, force};
    if (!check_is_model(model) || gallop_arithmetic_fault()) return GALLOP_BAD_CALL;
    if (places < 0 || modes < 0 || count < 0 || !all_usable(arrays, 5)) return GALLOP_BAD_CALL;
    if (!base_pointer_usable(element, sizeof *element)) return GALLOP_BAD_CALL;
    for (int s = 0; s < places; s++)
        if (element[s] < 0 || element[s] >= model->elements) return GALLOP_BAD_CALL;
    const size_t shapes = 3 * (size_t)modes, columns = (size_t)count;
    if (!check_finite(table, SECTION_ROWS * (size_t)places) ||
        !check_finite(shape, shapes * (size_t)places) ||
        !check_finite(weight, shapes * (size_t)places) ||
        !check_finite(moves, (shapes + 1) * columns))
        return GALLOP_BAD_CALL;
    const shape_motion m = {places, modes, columns, table, shape, weight, moves, force};
    memset(force, 0, (size_t)modes * columns * sizeof *force);
    for (size_t first = 0; first < columns; first += SECTIONS_AT_ONCE) {
        const size_t left = columns - first;
        shape_block(model, element, &m, first,
                    (int)(left < SECTIONS_AT_ONCE ? left : SECTIONS_AT_ONCE));
    }
    return GALLOP_COMPLETED;
}

int gallop_sections(const gallop_model *model, double shape[9], double *length, double *normal)
{
    const double *const out[3] = {shape, length, normal};
    if (!check_is_model(model) || !all_usable(out, 3)) return GALLOP_BAD_CALL;
    memcpy(shape, element_shape3, sizeof element_shape3);
    for (int e = 0; e < model->elements; e++) {
        const interval *c = model_interval_of_element(model, e);
        const geometry *g = &c->geometry[e - c->first_element];
        memcpy(length + 3 * (size_t)e, g->inertia_weight, sizeof g->inertia_weight);
        memcpy(normal + 6 * (size_t)e, g->normal, sizeof g->normal);
    }
    return GALLOP_COMPLETED;
}

int gallop_strain_points(const gallop_model *model, double *length, double *tangent,
                         double *shape_slope)
{
    const double *const out[3] = {length, tangent, shape_slope};
    if (!check_is_model(model) || !all_usable(out, 3)) return GALLOP_BAD_CALL;
    for (int e = 0; e < model->elements; e++) {
        const interval *c = model_interval_of_element(model, e);
        const geometry *g = &c->geometry[e - c->first_element];
        memcpy(length + 2 * (size_t)e, g->stiffness_weight, sizeof g->stiffness_weight);
        memcpy(tangent + 6 * (size_t)e, g->slope, sizeof g->slope);
        memcpy(shape_slope + 6 * (size_t)e, g->shape_slope, sizeof g->shape_slope);
    }
    return GALLOP_COMPLETED;
}

int gallop_node_normals(const gallop_model *model, double *normal)
{
    if (!check_is_model(model) || !base_pointer_usable(normal, WORD)) return GALLOP_BAD_CALL;
    memcpy(normal, model->normal, 2 * (size_t)model->nodes * sizeof *normal);
    return GALLOP_COMPLETED;
}

int gallop_free_unknowns(const gallop_model *model, int32_t *is_free)
{
    if (!check_is_model(model) || !base_pointer_usable(is_free, sizeof *is_free))
        return GALLOP_BAD_CALL;
    for (int i = 0; i < 4 * model->nodes; i++) is_free[i] = 1;
    for (int j = 0; j < model->junction_count; j++)
        for (int i = 0; i < 4; i++)
            is_free[4 * model->junction[j].node + i] = !model->junction[j].fixed[i];
    for (int t = 0; t < model->tie_count; t++)
        for (int i = 0; i < 4; i++) is_free[4 * model->tie[t].follower + i] = 0;
    return GALLOP_COMPLETED;
}

int gallop_seed(const gallop_model *model, double *u)
{
    if (!check_is_model(model) || !base_pointer_usable(u, WORD)) return GALLOP_BAD_CALL;
    memset(u, 0, 4 * (size_t)model->nodes * sizeof *u);
    time_add_seed(model, u);
    return GALLOP_COMPLETED;
}
