/* Wall time of an iteration's forces and solution of a line, by the kernel in one thread and by two
 * threads that share the chains and the devices, with the same bits.  line_threads.py compiles this
 * together with the kernel's sources, and shows the figures. */
#define _POSIX_C_SOURCE 200112L
#define solver_measure own_measure
#define solver_factor own_factor
#define solver_solve own_solve
#define solver_factor_complex own_factor_complex
#define solver_solve_complex own_solve_complex

#include "solver.c"

#undef solver_factor
#undef solver_solve
#include "system.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <time.h>

bool solver_factor(const gallop_model *model, const conditions *now, const state_view *view,
                   motion y, tangent_weights weights, solver_junctions junctions);
void solver_solve(const gallop_model *model, const state_view *view, solver_junctions junctions,
                  double *rhs);

#define ROUNDS 12 /* of a sample, which takes the mean of them */
#define STEPS 50  /* of a sample */
#define SPINS 100000

static double wall_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* The least mean time [us] of a statement so far. */
#define TIME(microseconds, statement)                                                              \
    do {                                                                                           \
        const double began = wall_seconds();                                                       \
        for (int round = 0; round < ROUNDS; round++) {                                             \
            statement;                                                                             \
        }                                                                                          \
        (microseconds) = fmin(microseconds, 1e6 * (wall_seconds() - began) / ROUNDS);              \
    } while (0)

/* ---- Two threads. ---- */

typedef struct line_halves line_halves;
typedef void half_work(line_halves *line, int half);

typedef struct {
    atomic_long begun, ended;
    half_work *work; /* NULL: no more work */
    line_halves *line;
} team;

static void wait_for(atomic_long *count, long value)
{
    int spins = 0;
    while (atomic_load_explicit(count, memory_order_acquire) != value)
        if (++spins > SPINS)
            sched_yield();
        else
            __builtin_ia32_pause();
}

static void *second_thread(void *argument)
{
    team *of = argument;
    for (long call = 1;; call++) {
        wait_for(&of->begun, call);
        if (!of->work) return NULL;
        of->work(of->line, 1);
        atomic_store_explicit(&of->ended, call, memory_order_release);
    }
}

static void in_two_threads(team *of, half_work *work, line_halves *line)
{
    const long call = atomic_load_explicit(&of->begun, memory_order_relaxed) + 1;
    of->work = work;
    of->line = line;
    atomic_store_explicit(&of->begun, call, memory_order_release);
    if (!work) return;
    work(line, 0);
    wait_for(&of->ended, call);
}

static void in_one_thread(team *of, half_work *work, line_halves *line)
{
    (void)of;
    work(line, 0);
    work(line, 1);
}

typedef void way_to_work(team *of, half_work *work, line_halves *line);

/* ---- The halves of a line. ---- */

typedef double device_forces[GALLOP_DEVICE_JUNCTIONS][4];

struct line_halves {
    const gallop_model *model;
    gallop_model
        half[2]; /* with its own chains and intervals; those count nodes as the line does */
    int first_node[3], first_device[3];
    sections at[2]; /* section forces without slopes, in places of their own */
    const state_view *view;
    motion y;
    tangent_weights mix;
    device_forces *force; /* (devices) */
    double *rhs;
    bool slopes, good[2];
};

static void split(line_halves *line, const gallop_model *model, const state_view *view)
{
    int cut = 0, elements = 0;
    while (cut < model->chain_count && 2 * elements < model->elements)
        elements += model->chain[cut++].elements;
    const chain *second = &model->chain[cut < model->chain_count ? cut : 0];
    const int first_interval =
        cut < model->chain_count ? second->first_interval : model->interval_count;
    line->model = model;
    line->half[0] = line->half[1] = *model;
    line->half[0].nodes = line->half[1].nodes = 0; /* no constant forces */
    line->half[0].chain_count = cut;
    line->half[0].interval_count = first_interval;
    line->half[1].chain += cut;
    line->half[1].chain_count -= cut;
    line->half[1].interval += first_interval;
    line->half[1].interval_count -= first_interval;
    line->first_node[1] = second->first_node;
    line->first_node[2] = model->nodes; /* bodies behind the chains included */
    line->first_device[1] = model->device_count / 2;
    line->first_device[2] = model->device_count;
    line->at[0] = line->at[1] = view->sections;
    double **array = (double **)&line->at[1];
    for (size_t i = 0; i < sizeof(sections) / sizeof(double *); i++)
        array[i] += 3 * LANES * second->first_strip;
    line->view = view;
    line->y = (motion){view->u, view->v, view->a};
}

/* ---- The work of a half. ---- */

TWO_PATHS static void negate_values(const double *restrict from, int values, double *restrict to)
{
    for (int i = 0; i < values; i++) to[i] = -from[i];
}

static void add_elements(line_halves *line, int half)
{
    const int first = 4 * line->first_node[half], end = 4 * line->first_node[half + 1];
    monitor seen;
    element_monitor_start(&seen);
    negate_values(line->model->constant_force + first, end - first, line->rhs + first);
    element_sum_residual(&line->half[half], 0.0, &line->view->now,
                         line->slopes ? &line->view->sections : &line->at[half], line->y,
                         line->slopes, line->rhs, &seen);
}

static void find_device_forces(line_halves *line, int half)
{
    for (int i = line->first_device[half]; i < line->first_device[half + 1]; i++)
        device_force(line->model, &line->model->device[i], &line->view->now, line->y,
                     line->force[i]);
}

static void find_forces(line_halves *line, int half)
{
    add_elements(line, half);
    find_device_forces(line, half);
}

static void reduce_chains(line_halves *line, int half)
{
    const gallop_model *own = &line->half[half];
    const system_tangent t = {line->model, &line->view->now, line->view, line->y, &line->mix, REAL};
    line->good[half] = true;
    for (int i = 0; i < own->chain_count && line->good[half]; i++) {
        const chain *c = &own->chain[i];
        const chain_motion here = {&t, c};
        solver_chain reduced = reduced_chain_of(own, c);
        reduced.source = &here;
        line->good[half] =
            solver_real_reduce(&reduced, &line->mix, store_of(own, line->view, i, REAL));
    }
}

static void take_to_ends(line_halves *line, int half)
{
    const gallop_model *own = &line->half[half];
    for (int i = 0; i < own->chain_count; i++) {
        const solver_chain kept = reduced_chain_of(own, &own->chain[i]);
        solver_real_to_ends(&kept, store_of(own, line->view, i, REAL),
                            line->rhs + 4 * own->chain[i].first_node);
    }
}

static void take_from_ends(line_halves *line, int half)
{
    const gallop_model *own = &line->half[half];
    for (int i = 0; i < own->chain_count; i++) {
        const solver_chain kept = reduced_chain_of(own, &own->chain[i]);
        solver_real_from_ends(&kept, store_of(own, line->view, i, REAL),
                              line->rhs + 4 * own->chain[i].first_node);
    }
}

static void do_nothing(line_halves *line, int half)
{
    (void)line, (void)half;
}

/* ---- The work between, by one thread. ---- */

static void add_device_forces(line_halves *line)
{
    const gallop_model *model = line->model;
    for (int i = 0; i < model->device_count; i++) {
        const device *d = &model->device[i];
        for (int k = 0; k < d->junctions; k++) {
            double *node = line->rhs + 4 * model->junction[d->junction[k]].node;
            for (int n = 0; n < 4; n++) node[n] += line->force[i][k][n];
        }
    }
    junction_gather(model, line->rhs, 4);
}

static void couple(line_halves *line)
{
    junction_gather(line->model, line->rhs, 4);
    solve_junctions(line->model, line->view, REAL, line->rhs);
    junction_spread(line->model, line->rhs, 4);
}

static bool factor_rest(line_halves *line)
{
    const gallop_model *model = line->model;
    const system_tangent t = {model, &line->view->now, line->view, line->y, &line->mix, REAL};
    const solver_junction_system s = junctions_in(model, line->view, REAL);
    solver_real_junctions_clear(&s);
    for (int i = 0; i < model->chain_count; i++) {
        const chain *c = &model->chain[i];
        const solver_chain reduced = reduced_chain_of(model, c);
        for (int k = 1; k < c->kept_corners; k++)
            add_segment(&t, &s, c, &reduced, store_of(model, line->view, i, REAL), k);
    }
    add_coupling_devices(&t, &s);
    fix_rows(&t, &s);
    return solver_real_junctions_factor(&s, &line->mix);
}

/* ---- An iteration, and a factorisation. ---- */

static void iterate(team *of, way_to_work *share, line_halves *line)
{
    share(of, find_forces, line);
    add_device_forces(line);
    share(of, take_to_ends, line);
    couple(line);
    share(of, take_from_ends, line);
}

static bool factorise(team *of, way_to_work *share, line_halves *line)
{
    share(of, reduce_chains, line);
    return line->good[0] && line->good[1] && factor_rest(line);
}

static void iterate_by_kernel(line_halves *line)
{
    monitor seen;
    element_monitor_start(&seen);
    system_residual(line->model, 0.0, &line->view->now, line->view, line->y, line->slopes,
                    line->rhs, &seen);
    solver_solve(line->model, line->view, SOLVER_JUNCTIONS_AS_IN_SCENE, line->rhs);
}

static bool factorise_by_kernel(line_halves *line)
{
    return solver_factor(line->model, &line->view->now, line->view, line->y, line->mix,
                         SOLVER_JUNCTIONS_AS_IN_SCENE);
}

/* A whole line for each thread, to see what the machine can do at once. */
static void iterate_own_line(line_halves *pair, int half)
{
    iterate_by_kernel(&pair[half]);
}

/* ---- Comparison. ---- */

/* Result that line_threads.py reads, in this order: least times [us]. */
typedef struct {
    double iteration, factorisation; /* of the kernel, in one thread */
    double iteration_by_two, factorisation_by_two;
    double elements, devices, to_ends, from_ends, reduction; /* parts that can be shared, */
    double between, factorisation_between;                   /* and those that cannot */
    double step, iterations, refactorisations; /* of the fastest steps, with their counts */
    double hand_over, two_lines; /* a call of both threads; an iteration of two lines at once */
    double different;            /* 1: two threads had other bits than the kernel */
} comparison;

/* A model in a motion, and room for a right-hand side and device forces. */
typedef struct {
    gallop_model *model;
    gallop_state *state;
    state_view view;
    void *memory;
} moving_line;

static bool start_line(moving_line *one, const gallop_scene *scene, double settled)
{
    gallop_report report;
    *one = (moving_line){0};
    if (gallop_model_create(scene, &one->model, &report)) return false;
    one->memory = malloc(gallop_state_size(one->model) + VECTOR);
    if (!one->memory) return false;
    one->state = base_first_vector(one->memory);
    if (gallop_state_init(one->model, one->state, 0.0, NULL, &report)) return false;
    if (gallop_advance(one->model, one->state, NULL, settled, &report)) return false;
    one->view = state_view_of(one->model, one->state);
    return one->model->coupled && one->model->load_count == 0;
}

static bool has_same_bits(team *of, line_halves *line, double *copy)
{
    const gallop_model *model = line->model;
    const size_t bytes = 4 * (size_t)model->nodes * sizeof(double);
    const size_t factor_bytes = model->factor_room * sizeof(double);
    double *factors = malloc(factor_bytes);
    if (!factors) return false;
    line->slopes = true;
    bool good = (iterate_by_kernel(line), factorise_by_kernel(line));
    memcpy(factors, line->view->factors, factor_bytes);
    iterate_by_kernel(line);
    memcpy(copy, line->rhs, bytes);
    memset(line->rhs, 0, bytes);
    iterate(of, in_two_threads, line);
    good = good && factorise(of, in_two_threads, line) &&
           memcmp(factors, line->view->factors, factor_bytes) == 0;
    memset(line->rhs, 0, bytes);
    line->slopes = false;
    iterate(of, in_two_threads, line);
    free(factors);
    return good && memcmp(copy, line->rhs, bytes) == 0;
}

/* Repeated solutions shrink; they begin with normal numbers. */
#define TIME_SOLUTION(microseconds, statement)                                                     \
    do {                                                                                           \
        iterate_by_kernel(line);                                                                   \
        TIME(microseconds, statement);                                                             \
    } while (0)

static void take_sample(team *of, line_halves pair[2], gallop_state *running, comparison *out)
{
    line_halves *line = &pair[0];
    bool good = true;
    TIME(out->iteration, iterate_by_kernel(line));
    TIME(out->iteration_by_two, iterate(of, in_two_threads, line));
    TIME(out->hand_over, in_two_threads(of, do_nothing, line));
    TIME(out->two_lines, in_two_threads(of, iterate_own_line, pair));
    TIME(out->elements, in_one_thread(of, add_elements, line));
    TIME(out->devices, in_one_thread(of, find_device_forces, line));
    TIME_SOLUTION(out->to_ends, in_one_thread(of, take_to_ends, line));
    TIME_SOLUTION(out->from_ends, in_one_thread(of, take_from_ends, line));
    TIME_SOLUTION(out->between, (add_device_forces(line), couple(line)));
    line->slopes = true;
    iterate_by_kernel(line); /* leaves the slopes that the tangent needs */
    line->slopes = false;
    TIME(out->factorisation, good = factorise_by_kernel(line) && good);
    TIME(out->factorisation_by_two, good = factorise(of, in_two_threads, line) && good);
    TIME(out->reduction, in_one_thread(of, reduce_chains, line));
    TIME(out->factorisation_between, good = factor_rest(line) && good);
    if (!good) out->different = 1.0;

    const int64_t before[2] = {running->iterations, running->refactorisations};
    const double h = line->model->scene.settings.time_step;
    gallop_report report;
    const double began = wall_seconds();
    if (gallop_advance(line->model, running, NULL, running->time + STEPS * h, &report))
        out->different = 1.0;
    const double step = 1e6 * (wall_seconds() - began) / STEPS;
    if (step >= out->step) return;
    out->step = step;
    out->iterations = (double)(running->iterations - before[0]) / STEPS;
    out->refactorisations = (double)(running->refactorisations - before[1]) / STEPS;
}

/* Runs a line until `settled` [s], and compares in so many samples. */
GALLOP_API int line_threads(const gallop_scene *scene, double settled, int samples, comparison *out)
{
    moving_line one[3]; /* of the shared line, of the second line, and of the one that runs on */
    line_halves pair[2] = {{0}};
    team of = {0};
    pthread_t thread;
    bool good = true;
    for (int k = 0; k < 3; k++) good = start_line(&one[k], scene, settled) && good;
    for (int k = 0; k < 2 && good; k++) {
        const gallop_model *model = one[k].model;
        const double h = scene->settings.time_step;
        split(&pair[k], model, &one[k].view);
        pair[k].mix = (tangent_weights){1.0, 2.0 / h, 4.0 / (h * h)}; /* Newmark */
        pair[k].rhs = one[k].view.residual;
        pair[k].force = malloc((size_t)model->device_count * sizeof *pair[k].force);
        good = pair[k].force != NULL;
    }
    if (good && !pthread_create(&thread, NULL, second_thread, &of)) {
        double *values = (double *)out;
        for (size_t i = 0; i < sizeof *out / sizeof(double); i++) values[i] = INFINITY;
        out->different = has_same_bits(&of, &pair[0], one[0].view.first) ? 0.0 : 1.0;
        iterate_by_kernel(&pair[1]);
        for (int i = 0; i < samples; i++) take_sample(&of, pair, one[2].state, out);
        in_two_threads(&of, NULL, NULL);
        pthread_join(thread, NULL);
    } else {
        good = false;
    }
    for (int k = 0; k < 2; k++) free(pair[k].force);
    for (int k = 0; k < 3; k++) {
        free(one[k].memory);
        gallop_model_free(one[k].model);
    }
    return !good;
}
