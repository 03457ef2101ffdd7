/* CPU time of the parts of one Newton iteration and of whole steps, for the galloping span of example 3.
 * speed.py compiles this together with the kernel's sources, because the parts are not in the library's public face.
 *
 * usage: kernel_parts elements time_step repeats
 * prints one line a repeat: us per call of forces, inertia of the ice, aerodynamics, tangent and factorisation,
 * solution; us per step; iterations, refactorisations per step; simulated seconds per CPU second. */
#define _POSIX_C_SOURCE 199309L
#include "internal.h"

#include <stdio.h>
#include <time.h>

#define SETTLED 900.0   /* [s] by then the swing has reached its steady amplitude */

static double cpu_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Coefficients (powers of alpha - pi) moved to the first breakpoint, h away from pi. */
static void set_curve(gallop_scene *s, double breakpoint[2], double coefficient[12])
{
    const double h = -80.0 * PI / 180.0;
    const double cubic[3][4] = {{0.0, -4.5, 0.0, 3.0}, {1.0, 0.0, 0.5, 0.0}, {0.0, -0.3, 0.0, 0.2}};
    for (int c = 0; c < 3; c++) {
        const double *k = cubic[c];
        double *moved = coefficient + 4 * c;
        moved[0] = k[0] + h * (k[1] + h * (k[2] + h * k[3]));
        moved[1] = k[1] + h * (2.0 * k[2] + h * 3.0 * k[3]);
        moved[2] = k[2] + 3.0 * h * k[3];
        moved[3] = k[3];
    }
    breakpoint[0] = PI + h;
    breakpoint[1] = PI - h;
    s->pieces = 1;
    s->breakpoint = breakpoint;
    s->coefficient = coefficient;
}

static gallop_scene example3(int elements, double time_step)
{
    gallop_scene s = {0};
    s.length = 125.88;
    s.sag = 2.12;
    s.horizontal_tension = 15000.0;
    s.gravity = 9.81;
    s.diameter = 0.0235;
    s.mass = 1.66;
    s.axial_stiffness = 25.53e6;
    s.torsional_stiffness = 153.0;
    s.torsional_inertia = 1.56e-4;
    s.first_moment_x2 = -0.830e-3;
    s.first_moment_x3 = 2.722e-3;
    s.air_density = 1.2929;
    s.attack_angle = PI;
    s.reference_radius = 0.5 * s.diameter;
    s.wind.offset = 5.5;
    s.translation_damping = (gallop_damping){0.016, 0.378, 0.016, 0.695};
    s.twist_damping = (gallop_damping){0.057, 3.93, 0.057, 7.87};
    s.seed_vertical = s.seed_horizontal = 1e-3;
    s.elements = elements;
    s.time_step = time_step;
    s.newton_tolerance = 1e-9;
    s.max_newton_iterations = 20;
    s.max_halvings = 8;
    return s;
}

/* The mean of `calls` calls [us]. */
#define TIME(microseconds, calls, statement)                            \
    do {                                                                \
        double began = cpu_seconds();                                   \
        for (int call = 0; call < (calls); call++) { statement; }       \
        microseconds = 1e6 * (cpu_seconds() - began) / (calls);         \
    } while (0)

int main(int count, char **argument)
{
    if (count != 4) return 2;
    const int elements = atoi(argument[1]), repeats = atoi(argument[3]);
    const double h = atof(argument[2]);
    double breakpoint[2], coefficient[12];
    gallop_scene scene = example3(elements, h);
    set_curve(&scene, breakpoint, coefficient);
    gallop_model *model;
    gallop_report report;
    if (gallop_model_create(&scene, &model, &report)) return 1;
    gallop_state *state = malloc(gallop_state_size(model));
    if (!state || gallop_state_init(model, state, 0.0, NULL, &report)) return 1;
    /* long spans of many elements start from the seed: their iterations are those of the growing oscillation */
    const double warm_up = elements > 60 ? 2.0 : SETTLED;
    if (gallop_advance(model, state, NULL, warm_up, &report)) return 1;
    const layout at = state_layout(model, state);
    const blend mix = {1.0, 2.0 / h, 4.0 / (h * h)};
    const int calls = 300000 / elements + 1, steps = 150000 / elements + 1;
    const bool eccentric = model->eccentric;
    instant windy_now = state->now, calm = state->now;
    calm.wind = 0.0;
    watch seen;
    watch_start(&seen);
    for (int repeat = 0; repeat < repeats; repeat++) {
        double with_wind, with_ice, forces, tangent, solution;
        TIME(with_wind, calls,
             span_residual(model, 0.0, &windy_now, &at.sections, at.u, at.v, at.a, false, at.residual, &seen));
        TIME(with_ice, calls, span_residual(model, 0.0, &calm, &at.sections, at.u, at.v, at.a, false, at.residual, &seen));
        model->eccentric = false;
        TIME(forces, calls, span_residual(model, 0.0, &calm, &at.sections, at.u, at.v, at.a, false, at.residual, &seen));
        model->eccentric = eccentric;
        span_residual(model, 0.0, &windy_now, &at.sections, at.u, at.v, at.a, true, at.residual, &seen);
        TIME(tangent, calls / 10 + 1,
             solver_factor(model, &windy_now, &at.sections, at.u, mix, model->fixed, at.factors));
        TIME(solution, calls, solver_solve(model, at.factors, model->fixed, at.residual));
        state->factored_step = 0.0;   /* the factorisation above belongs to another instant */

        const int64_t iterations = state->iterations, renewals = state->refactorisations;
        const double origin = state->time, began = cpu_seconds();
        if (gallop_advance(model, state, NULL, origin + steps * h, &report)) return 1;
        const double spent = cpu_seconds() - began;
        printf("%g %g %g %g %g %g %g %g %g\n", forces, with_ice - forces, with_wind - with_ice, tangent, solution,
               1e6 * spent / steps, (double)(state->iterations - iterations) / steps,
               (double)(state->refactorisations - renewals) / steps, steps * h / spent);
    }
    free(state);
    gallop_model_free(model);
    return 0;
}
