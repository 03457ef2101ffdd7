/* CPU time of the parts of a Newton iteration, which the kernel's public face does not show.
 * speed.py compiles this together with the kernel's sources and calls it with one of its scenes. */
#define _POSIX_C_SOURCE 199309L
#include "element.h"
#include "solver.h"

#include <time.h>

static double cpu_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Mean CPU time [us] of one execution of the statement. */
#define TIME(microseconds, calls, statement)                                                       \
    do {                                                                                           \
        const double began = cpu_seconds();                                                        \
        for (int call = 0; call < (calls); call++) {                                               \
            statement;                                                                             \
        }                                                                                          \
        (microseconds) = 1e6 * (cpu_seconds() - began) / (calls);                                  \
    } while (0)

/* Result that speed.py reads, in this order. */
typedef struct {
    double forces, ice, aerodynamics, tangent, solution; /* [us] a call */
    double step;                                         /* [us] a time step */
    double iterations, refactorisations;                 /* a step */
} parts;

/* Runs until `settled` [s], then times `calls` of each part in that motion, and `steps` whole
 * steps. */
GALLOP_API int kernel_parts(const gallop_scene *scene, double settled, int calls, int steps,
                            parts *out)
{
    gallop_model *model;
    gallop_report report;
    if (gallop_model_create(scene, &model, &report)) return 1;
    void *memory = malloc(gallop_state_size(model) + VECTOR);
    gallop_state *state = memory ? base_first_vector(memory) : NULL;
    int failed = !state || gallop_state_init(model, state, 0.0, NULL, &report) ||
                 gallop_advance(model, state, NULL, settled, &report);
    if (!failed) {
        const state_view at = state_view_of(model, state);
        const double h = scene->settings.time_step;
        const tangent_weights mix = {1.0, 2.0 / h,
                                     4.0 / (h * h)}; /* Newmark, beta 1/4, gamma 1/2 */
        const motion y = {at.u, at.v, at.a};
        conditions calm = at.stage[0];
        conditions_copy(model, &calm, &at.now);
        calm.wind[0] = 0.0;
        monitor seen;
        element_monitor_start(&seen);
#define RESIDUAL(now, slopes)                                                                      \
    element_sum_residual(model, settled, now, &at.sections, y, slopes, at.residual, &seen)
        double all, without_wind, without_ice;
        TIME(all, calls, RESIDUAL(&at.now, false));
        TIME(without_wind, calls, RESIDUAL(&calm, false));
        model->section[0].eccentric = false;
        TIME(without_ice, calls, RESIDUAL(&calm, false));
        model->section[0].eccentric = true;
        out->forces = without_ice;
        out->ice = without_wind - without_ice;
        out->aerodynamics = all - without_wind;
        RESIDUAL(&at.now, true); /* leaves the slopes that the tangent needs */
        TIME(out->tangent, calls,
             solver_factor(model, &at.now, &at, y, mix, SOLVER_JUNCTIONS_AS_IN_SCENE));
        TIME(out->solution, calls,
             solver_solve(model, &at, SOLVER_JUNCTIONS_AS_IN_SCENE, at.residual));

        const int64_t iterations = state->iterations, refactorisations = state->refactorisations;
        const double began = cpu_seconds();
        failed = gallop_advance(model, state, NULL, settled + steps * h, &report);
        out->step = 1e6 * (cpu_seconds() - began) / steps;
        out->iterations = (double)(state->iterations - iterations) / steps;
        out->refactorisations = (double)(state->refactorisations - refactorisations) / steps;
    }
    free(memory);
    gallop_model_free(model);
    return failed;
}
