/* Fuzzing target: the condensed model on a scene from the input, with hostile numbers, arrays, starts and lengths.
 * Arrays are no longer than gallop.h asks for, so that the sanitizers see every access beyond.  Every run must end in a
 * typed outcome; what it recorded, and where a completed one ended, must be finite, and no recorded tension below the
 * lowest one that it reports. */
#include "scene.h"

#include <stdbool.h>

#define MODES GALLOP_CONDENSED_MODES
#define SECTIONS GALLOP_CONDENSED_SECTIONS
#define MOST_RECORDS 64
#define ARRAYS 10
#define MOST_CHANGES 16

/* Arrays by name, with their lengths but for the loads', and a copy of each of exactly that length. */
typedef struct {
    const double **array[ARRAYS];
    size_t length[ARRAYS];
    double *own[ARRAYS];
} arrays;

static arrays arrays_of(gallop_condensed *c)
{
    return (arrays){
        {&c->frequency, &c->damping, &c->elongation, &c->coupling, &c->stretch, &c->shape, &c->weighted, &c->slope,
         &c->slope_weighted, &c->load},
        {MODES, MODES, MODES, MODES * MODES, MODES * MODES, 3 * MODES * SECTIONS, 3 * MODES * SECTIONS,
         2 * MODES * SECTIONS, 2 * MODES * SECTIONS, (size_t)c->loads * MODES},
        {NULL}};
}

/* Sine waves of a taut string in u2, u3 and twist in turn, of unit mass. */
static void fill(double *own[ARRAYS], const gallop_scene *s, size_t loads)
{
    const double wave = sqrt(s->horizontal_tension / s->mass), step = s->length / SECTIONS;
    double *frequency = own[0], *damping = own[1], *elongation = own[2], *coupling = own[3], *stretch = own[4];
    double *shape = own[5], *weighted = own[6], *slope = own[7], *slope_weighted = own[8], *load = own[9];
    for (int m = 0; m < MODES; m++) {
        const int component = m % 3, loops = m / 3 + 1;
        const double number = 3.14159265 * loops / s->length, inertia = component < 2 ? s->mass : s->torsional_inertia;
        const double size = sqrt(2.0 / (inertia * s->length));
        frequency[m] = component < 2 ? number * wave : 25.0 * loops;
        damping[m] = 0.02 * frequency[m];
        coupling[m * MODES + m] = 0.0;
        elongation[m] = component == 0 && loops % 2 ? 0.05 * size / loops : 0.0;
        stretch[m * MODES + m] = component < 2 ? 0.5 * size * size * number * number * s->length : 0.0;
        for (int i = 0; i < SECTIONS; i++) {
            const double x = (i + 0.5) * step, value = size * sin(number * x), rise = size * number * cos(number * x);
            shape[(component * MODES + m) * SECTIONS + i] = value;
            weighted[(component * SECTIONS + i) * MODES + m] = value * step;
            if (component == 2) continue;
            slope[(component * MODES + m) * SECTIONS + i] = rise;
            slope_weighted[(component * SECTIONS + i) * MODES + m] = 100.0 * rise * step;
        }
        for (size_t l = 0; l < loads; l++) load[l * MODES + m] = 1.0 / loops;
    }
}

static int64_t length_of(input *in, int64_t usual)
{
    static const int64_t odd[] = {0, -1, INT64_MIN, INT64_MAX, 1, 2, (int64_t)1 << 53, 1000000};
    const uint8_t b = byte_of(in);
    return b < 128 ? usual : b < 192 ? odd[b % 8] : (int64_t)(b - 192);
}

static void require_finite(const double *values, size_t count)
{
    for (size_t i = 0; i < count; i++) REQUIRE(isfinite(values[i]));
}

/* Room for what the lengths ask for; lengths that nobody would wait for, or has the room for, are left alone. */
static void run(const gallop_model *model, const gallop_condensed *c, double *q, double *v, const int64_t length[4])
{
    const int64_t first = length[0], steps = length[1], every = length[2], within = length[3];
    const int64_t ends = steps > 0 && every > 0 ? steps / every : 0;
    if (steps > 200 && steps < (int64_t)1 << 50) return;
    if (ends > 0 && steps <= 200 && within > MOST_RECORDS / ends) return;
    const bool fits = ends > 0 && steps <= 200 && within > 0 && within <= MOST_RECORDS;
    const size_t room = fits ? (size_t)(ends * within) : 0;
    double *history = malloc(room * 2 * MODES * sizeof *history), *tension = malloc(room * sizeof *tension);
    gallop_report report = {.element = -1, .lowest_tension = INFINITY};
    int64_t records = -1;
    const int outcome =
        gallop_condensed_run(model, c, q, v, first, steps, every, within, history, tension, &records, &report);
    REQUIRE(outcome == report.outcome && outcome >= GALLOP_COMPLETED && outcome <= GALLOP_BAD_CALL);
    REQUIRE(records >= 0 && (size_t)records <= room);
    if (outcome == GALLOP_COMPLETED) {
        REQUIRE((size_t)records == room && report.steps == steps && isfinite(report.time));
        require_finite(q, MODES);
        require_finite(v, MODES);
    }
    require_finite(history, (size_t)records * 2 * MODES);
    require_finite(tension, (size_t)records);
    for (int64_t i = 0; i < records; i++) REQUIRE(tension[i] >= 0.0 && tension[i] >= report.lowest_tension);
    free(history);
    free(tension);
}

/* A number to come into an array, or into the start. */
typedef struct { int array; size_t place; double value; } change_of_entry;

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    input in = {data, data + size};
    gallop_condensed c = {.time_step = 0.05, .horizontal_tension = 1.5e4, .stiffness = 9e4, .remaining = 0.9,
                          .damping_time = 1e-3, .share = 0.9};
    const int64_t length[4] = {length_of(&in, 0), length_of(&in, 8), length_of(&in, 1), length_of(&in, 1)};
    const double time = number_of(&in);
    double *number[] = {&c.time_step, &c.horizontal_tension, &c.stiffness, &c.remaining, &c.damping_time, &c.share};
    for (size_t i = 0; i < sizeof number / sizeof *number; i++) change(&in, number[i]);
    change_of_entry changes[MOST_CHANGES];
    const int count = byte_of(&in) % MOST_CHANGES;
    for (int i = 0; i < count; i++) {
        changes[i].array = byte_of(&in) % (ARRAYS + 2);
        changes[i].place = word_of(&in);
        changes[i].value = number_of(&in);
    }
    const uint8_t other_loads = byte_of(&in);
    gallop_scene scene;
    gallop_model *model = model_of(&in, &scene);
    if (!model) return 0;

    c.loads = scene.load_count;
    arrays every = arrays_of(&c);
    double q[MODES] = {0.1, 0.1, 0.01}, v[MODES] = {0.0}, a[MODES] = {0.0}, f[MODES];
    for (int k = 0; k < ARRAYS; k++) *every.array[k] = every.own[k] = calloc(every.length[k], sizeof(double));
    fill(every.own, &scene, (size_t)c.loads);
    if (other_loads > 240) c.loads += other_loads - 248;
    for (int i = 0; i < count; i++) {
        const int k = changes[i].array;
        const size_t entries = k < ARRAYS ? every.length[k] : MODES;
        if (entries) (k < ARRAYS ? every.own[k] : k == ARRAYS ? q : v)[changes[i].place % entries] = changes[i].value;
    }

    const int outcome = gallop_condensed_forces(model, &c, time, q, v, a, f);
    REQUIRE(outcome == (c.loads == scene.load_count ? GALLOP_COMPLETED : GALLOP_BAD_CALL));
    run(model, &c, q, v, length);
    for (int k = 0; k < ARRAYS; k++) free(every.own[k]);
    gallop_model_free(model);
    return 0;
}
