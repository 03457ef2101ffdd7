/* CPU time of an iteration's forces and solution: one scene, whose vectors hold four elements, and
 * four scenes, whose vectors hold one element of each.  scene_lanes.py compiles this together with
 * the kernel's sources.  The forces of four scenes are those of the kernel's own source, with other
 * functions to read and write nodes; the solution is written out.  The four scenes share all
 * numbers of the cross-section and the wind, so the result is an upper bound of the gain. */
#define _POSIX_C_SOURCE 199309L
#define element_gauss2 scenes_gauss2
#define element_gauss3 scenes_gauss3
#define element_gauss3_weight scenes_gauss3_weight
#define element_shape3 scenes_shape3
#define element_tension scenes_tension
#define element_monitor_tensions scenes_monitor_tensions
#define element_monitor_start scenes_monitor_start
#define element_residual scenes_residual
#define element_add_lost_forces scenes_add_lost_forces
#define element_sum_residual scenes_sum_residual
#define element_attack_angle scenes_attack_angle
#define element_aero_loads scenes_aero_loads
#define element_wind_matters scenes_wind_matters

#include "base_lanes.h"
#if LANES != 4
#error scenes in lanes need gcc or clang
#endif

/* Nodes of four scenes: [node][unknown][scene].  The kernel finds element e of a strip of four at
 * y + 8 e; here that is the left node of the element of all four. */
INLINE void read_scenes(const double *y, int n, lanes out[4])
{
    for (int i = 0; i < 4; i++) out[i] = LANES_AT(y + LANES * (4 * n + i));
}

INLINE void add_to_scenes(double *y, int n, const lanes x[4])
{
    for (int i = 0; i < 4; i++) LANES_AT(y + LANES * (4 * n + i)) += x[i];
}
#define read_nodes(y, n, count, out) read_scenes(y, n, out)
#define add_to_nodes(y, n, count, x) add_to_scenes(y, n, x)

#include "element_cable.c"

#include "element_aero.c"

#undef element_sum_residual
void element_sum_residual(const gallop_model *model, double t, const conditions *now,
                          const sections *at, motion y, bool slopes, double *residual,
                          monitor *seen);
#include "solver.h"

#include <time.h>

#define MAX_ELEMENTS 64
#define VALUES (4 * (2 * MAX_ELEMENTS + 1))
#define ROUNDS 400

static double cpu_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

#define TIME(microseconds, statement)                                                              \
    do {                                                                                           \
        const double began = cpu_seconds();                                                        \
        for (int round = 0; round < ROUNDS; round++) {                                             \
            statement;                                                                             \
        }                                                                                          \
        (microseconds) = 1e6 * (cpu_seconds() - began) / ROUNDS;                                   \
    } while (0)

/* ---- Four scenes. ---- */

typedef struct {
    lanes inverse[16], left[16], right[16];
} middle_factor;
typedef struct {
    lanes inverse[16], carry[16], back[16];
} corner_factor;

static struct {
    int elements;
    interval chain;
    sections sections;
    _Alignas(64) strip strip[MAX_ELEMENTS];
    _Alignas(64) middle_factor middle[MAX_ELEMENTS];
    _Alignas(64) corner_factor corner[MAX_ELEMENTS + 1];
    _Alignas(64) double arrays[32][3 * LANES * STRIPS_AT_ONCE];
    _Alignas(64) double u[VALUES * LANES], v[VALUES * LANES], a[VALUES * LANES],
        force[VALUES * LANES], rhs[VALUES * LANES], solution[VALUES * LANES];
} four;

static void four_times(const double *from, int values, double *to)
{
    for (int i = 0; i < values; i++)
        for (int k = 0; k < LANES; k++) to[LANES * i + k] = from[i];
}

static void fill_four(const gallop_model *model, const state_view *at, const double *rhs)
{
    const interval *c = &model->interval[0];
    const int values = 4 * c->nodes;
    four.elements = c->elements;
    four.chain = *c;
    four.chain.elements = LANES * c->elements; /* of all four */
    four.chain.strips = c->elements;
    four.chain.strip = four.strip;
    for (int e = 0; e < c->elements; e++) { /* a strip is a table of lanes */
        const lanes *own = (const lanes *)&c->strip[e / LANES];
        lanes *all = (lanes *)&four.strip[e];
        for (size_t i = 0; i < sizeof(strip) / sizeof(lanes); i++)
            all[i] = (lanes){0.0} + LANE(own[i], e % LANES);
    }
    four_times(at->u, values, four.u);
    four_times(at->v, values, four.v);
    four_times(at->a, values, four.a);
    four_times(rhs, values, four.rhs);
    double **array = (double **)&four.sections;
    for (size_t i = 0; i < sizeof(sections) / sizeof(double *); i++) array[i] = four.arrays[i];

    /* the factors of one chain, as solver_block.h stores them */
    const int strips = c->strips;
    const double *corner = at->factors + 48 * LANES * (size_t)strips;
    for (int e = 0; e < c->elements; e++)
        for (int i = 0; i < 48; i++)
            ((lanes *)&four.middle[e])[i] =
                (lanes){0.0} + at->factors[LANES * (48 * (e / LANES) + i) + e % LANES];
    for (int e = 0; e <= c->elements; e++)
        for (int b = 0; b < 3; b++)
            for (int i = 0; i < 16; i++) /* columns become rows */
                ((lanes *)&four.corner[e])[16 * b + 4 * (i % 4) + i / 4] =
                    (lanes){0.0} + corner[48 * e + 16 * b + i];
}

INLINE void four_forces(const gallop_model *model, const exposure *on, monitor *seen)
{
    const double *constant = model->constant_force;
    for (int i = 0; i < 4 * four.chain.nodes; i++)
        LANES_AT(four.force + LANES * i) = (lanes){0.0} - constant[i];
    const evaluation of = {.interval = &four.chain,
                           .now = on,
                           .at = &four.sections,
                           .y = {four.u, four.v, four.a},
                           .slopes = false,
                           .residual = four.force,
                           .seen = seen};
    interval_residual(&of, 4);
}
PATHS(four_forces, (const gallop_model *model, const exposure *on, monitor *seen),
      (model, on, seen))

INLINE void multiply(const lanes a[16], const lanes x[4], lanes out[4])
{
    for (int i = 0; i < 4; i++)
        out[i] = a[4 * i] * x[0] + a[4 * i + 1] * x[1] + a[4 * i + 2] * x[2] + a[4 * i + 3] * x[3];
}

/* node `to` -= a x */
INLINE void take_from(double *y, int to, const lanes a[16], const lanes x[4])
{
    lanes change[4];
    multiply(a, x, change);
    for (int i = 0; i < 4; i++) change[i] = -change[i];
    add_to_scenes(y, to, change);
}

INLINE void write_scenes(double *y, int n, const lanes x[4])
{
    for (int i = 0; i < 4; i++) LANES_AT(y + LANES * (4 * n + i)) = x[i];
}

/* corner k = inverse x_k - back x_next */
INLINE void settle(double *y, int k, int next)
{
    lanes x[4], out[4];
    read_scenes(y, 2 * k, x);
    multiply(four.corner[k].inverse, x, out);
    write_scenes(y, 2 * k, out);
    if (next == k) return;
    read_scenes(y, 2 * next, x);
    take_from(y, 2 * k, four.corner[k].back, x);
}

/* The algorithm of solver_block.h for a chain with fixed ends. */
INLINE void four_solutions(double *y)
{
    const int elements = four.elements, meeting = elements / 2;
    const lanes zero[4] = {{0.0}, {0.0}, {0.0}, {0.0}};
    lanes x[4], own[4];
    for (int e = 0; e < elements; e++) {
        read_scenes(y, 2 * e + 1, x);
        multiply(four.middle[e].inverse, x, own);
        write_scenes(y, 2 * e + 1, own);
        take_from(y, 2 * e, four.middle[e].left, own);
        take_from(y, 2 * e + 2, four.middle[e].right, own);
    }
    write_scenes(y, 0, zero);
    write_scenes(y, 2 * elements, zero);
    for (int k = 0; k < elements - meeting; k++) {
        const int right = elements - k;
        if (k < meeting) {
            read_scenes(y, 2 * k, x);
            take_from(y, 2 * k + 2, four.corner[k].carry, x);
        }
        read_scenes(y, 2 * right, x);
        take_from(y, 2 * right - 2, four.corner[right].carry, x);
    }
    settle(y, meeting, meeting);
    for (int k = elements - meeting - 1; k >= 0; k--) {
        if (k < meeting) settle(y, k, k + 1);
        settle(y, elements - k, elements - k - 1);
    }
    for (int e = 0; e < elements; e++) {
        lanes left[4], right[4];
        read_scenes(y, 2 * e, x);
        multiply(four.middle[e].left, x, left);
        read_scenes(y, 2 * e + 2, x);
        multiply(four.middle[e].right, x, right);
        for (int i = 0; i < 4; i++) left[i] += right[i];
        take_from(y, 2 * e + 1, four.middle[e].inverse, left);
    }
}
PATHS(four_solutions, (double *y), (y))

/* ---- Both. ---- */

static double largest_difference(const double *one, const double *all, int values)
{
    double most = 0.0, size = 0.0;
    for (int i = 0; i < values; i++) {
        size = fmax(size, fabs(one[i]));
        for (int k = 0; k < LANES; k++) most = fmax(most, fabs(all[LANES * i + k] - one[i]));
    }
    return most / size;
}

/* Result that scene_lanes.py reads, in this order; times in us for a scene. */
typedef struct {
    double forces, solution, four_forces, four_solution, step, iterations;
    double force_difference, solution_difference; /* relative to the largest value */
} comparison;

/* Runs the scene, a span of up to MAX_ELEMENTS elements, until `settled` [s], and compares. */
GALLOP_API int scene_lanes(const gallop_scene *scene, double settled, int fused, comparison *out)
{
    gallop_model *model;
    gallop_report report;
    if (gallop_model_create(scene, &model, &report)) return 1;
    void *memory = malloc(gallop_state_size(model) + VECTOR);
    gallop_state *state = memory ? base_first_vector(memory) : NULL;
    int failed = model->elements > MAX_ELEMENTS || model->interval_count != 1 || !state ||
                 gallop_state_init(model, state, 0.0, NULL, &report) ||
                 gallop_advance(model, state, NULL, settled, &report);
    if (!failed) {
        const state_view at = state_view_of(model, state);
        const double h = scene->settings.time_step;
        const tangent_weights mix = {1.0, 2.0 / h, 4.0 / (h * h)}; /* Newmark */
        const motion y = {at.u, at.v, at.a};
        const int values = 4 * model->nodes;
        const size_t bytes = (size_t)values * sizeof(double);
        static double rhs[VALUES], own[VALUES], force[VALUES];
        monitor seen;
        scenes_monitor_start(&seen);
        model->fused = fused && base_has_fused_path();
        element_sum_residual(model, settled, &at.now, &at.sections, y, true, at.residual, &seen);
        failed = !solver_factor(model, &at.now, &at, y, mix, SOLVER_JUNCTIONS_AS_IN_SCENE);
        for (int i = 0; i < values; i++) rhs[i] = sin(i);
        fill_four(model, &at, rhs);
        const exposure on = conditions_on(model, &at.now, &model->interval[0]);
        TIME(out->forces,
             element_sum_residual(model, settled, &at.now, &at.sections, y, false, force, &seen));
        TIME(out->four_forces, ON_PATH(model->fused, four_forces)(model, &on, &seen));
        TIME(out->solution, (memcpy(own, rhs, bytes),
                             solver_solve(model, &at, SOLVER_JUNCTIONS_AS_IN_SCENE, own)));
        TIME(out->four_solution, (memcpy(four.solution, four.rhs, LANES * bytes),
                                  ON_PATH(model->fused, four_solutions)(four.solution)));
        out->four_forces /= LANES;
        out->four_solution /= LANES;
        out->force_difference = largest_difference(force, four.force, values);
        out->solution_difference = largest_difference(own, four.solution, values);
        const int64_t iterations = state->iterations;
        const double began = cpu_seconds();
        failed = failed || gallop_advance(model, state, NULL, settled + ROUNDS * h, &report);
        out->step = 1e6 * (cpu_seconds() - began) / ROUNDS;
        out->iterations = (double)(state->iterations - iterations) / ROUNDS;
    }
    free(memory);
    gallop_model_free(model);
    return failed;
}
