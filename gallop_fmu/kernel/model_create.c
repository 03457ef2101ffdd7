/* Creation of a model: checks, copies into one block, formulas that turn the scene into numbers. */
#include "base_math.h"
#include "check.h"
#include "conditions.h"
#include "law.h"
#include "statics.h"

void gallop_struct_sizes(size_t sizes[7])
{
    if (!base_pointer_usable(sizes, WORD)) return;
    sizes[0] = sizeof(gallop_scene);
    sizes[1] = sizeof(gallop_law);
    sizes[2] = sizeof(gallop_support);
    sizes[3] = sizeof(gallop_load);
    sizes[4] = sizeof(gallop_report);
    sizes[5] = sizeof(gallop_inputs);
    sizes[6] = sizeof(gallop_derived);
}

const char *gallop_build(void)
{
#if defined(__clang__)
    return "clang " __clang_version__;
#elif defined(__GNUC__)
    return "gcc " __VERSION__;
#elif defined(_MSC_VER)
    return "Microsoft C";
#else
    return "unknown compiler";
#endif
}

/* Two ratios at two frequencies (Liu et al. eq. 28 as printed holds only for equal ratios):
 * b1 = 2 w1 w2 (x1 w2 - x2 w1) / (w2^2 - w1^2), b2 = 2 (x2 w2 - x1 w1) / (w2^2 - w1^2) */
static void rayleigh(const gallop_damping *pair, double b[2])
{
    double w1 = 2.0 * PI * pair->low_frequency, w2 = 2.0 * PI * pair->high_frequency;
    double x1 = pair->low_ratio, x2 = pair->high_ratio, square = w2 * w2 - w1 * w1;
    b[0] = b[1] = 0.0;
    if (!(square > 0.0)) return;
    b[0] = 2.0 * w1 * w2 * (x1 * w2 - x2 * w1) / square;
    b[1] = 2.0 * (x2 * w2 - x1 * w1) / square;
}

/* Springs given, or of the adjacent span and its insulator string (eq. 23-24). */
static void support_stiffness(const gallop_scene *s, const gallop_support *support, double k[2])
{
    k[0] = support->stiffness_x1;
    k[1] = support->stiffness_x3;
    if (support->kind != GALLOP_SUPPORT_ADJACENT_SPAN) return;
    double lx = support->adjacent_span, h = support->adjacent_tension,
           weight = (s->mass + s->ice_mass) * s->gravity;
    double span =
        1.0 / (lx / s->axial_stiffness + weight * weight * lx * lx * lx / (12.0 * h * h * h));
    double string =
        (weight * s->length + 0.5 * support->insulator_weight) / support->insulator_length;
    k[0] = span + string;
    k[1] = string + 2.0 * h / lx;
}

#define SAG_TENSION_AGREEMENT                                                                      \
    0.05 /* largest relative difference of a sag and a tension that are both held */

static bool positive(double x)
{
    return isfinite(x) && x > 0.0;
}

static int check_positive(const gallop_scene *s, gallop_report *report)
{
    const struct {
        const char *name;
        double value;
    } number[] = {{"length of the span", s->length},
                  {"diameter", s->diameter},
                  {"mass", s->mass},
                  {"axial stiffness", s->axial_stiffness},
                  {"torsional stiffness", s->torsional_stiffness},
                  {"torsional inertia", s->torsional_inertia},
                  {"gravity", s->gravity},
                  {"time step", s->time_step},
                  {"Newton tolerance", s->newton_tolerance}};
    for (size_t i = 0; i < sizeof number / sizeof *number; i++)
        if (!positive(number[i].value))
            return report_invalid(report, number[i].name, number[i].value, 0.0);
    if (!(s->sag > 0.0) && !(s->horizontal_tension > 0.0))
        return report_invalid(report, "sag or horizontal tension", s->sag, 0.0);
    if (!(s->ice_mass >= 0.0)) return report_invalid(report, "mass of ice", s->ice_mass, 0.0);
    if (!(s->ice_torsional_inertia >= 0.0))
        return report_invalid(report, "inertia of ice", s->ice_torsional_inertia, 0.0);
    return GALLOP_COMPLETED;
}

static int check_support(const gallop_support *support, gallop_report *report)
{
    const bool springs = support->kind == GALLOP_SUPPORT_SPRINGS;
    if (springs && !(positive(support->stiffness_x1) && positive(support->stiffness_x3)))
        return report_invalid(report, "stiffness of a support",
                              fmin(support->stiffness_x1, support->stiffness_x3), 0.0);
    if (support->kind != GALLOP_SUPPORT_ADJACENT_SPAN) return GALLOP_COMPLETED;
    if (!positive(support->adjacent_span))
        return report_invalid(report, "adjacent span", support->adjacent_span, 0.0);
    if (!positive(support->adjacent_tension))
        return report_invalid(report, "adjacent tension", support->adjacent_tension, 0.0);
    if (!positive(support->insulator_length))
        return report_invalid(report, "insulator length", support->insulator_length, 0.0);
    if (!(support->insulator_weight >= 0.0))
        return report_invalid(report, "insulator weight", support->insulator_weight, 0.0);
    return GALLOP_COMPLETED;
}

static int check_damping(const gallop_damping *pair, gallop_report *report)
{
    if (pair->low_frequency == 0.0 && pair->high_frequency == 0.0)
        return GALLOP_COMPLETED; /* undamped */
    if (!positive(pair->low_frequency))
        return report_invalid(report, "low frequency of damping", pair->low_frequency, 0.0);
    if (!(pair->high_frequency > pair->low_frequency))
        return report_invalid(report, "high frequency of damping", pair->high_frequency,
                              pair->low_frequency);
    return GALLOP_COMPLETED;
}

/* The binding refuses bad numbers field by field; this guards the kernel against any other caller,
 * and against parameters of an FMU that do not go together. */
static int check(const gallop_scene *s, gallop_report *report)
{
    int outcome = check_positive(s, report);
    for (int end = 0; end < 2 && !outcome; end++) outcome = check_support(&s->support[end], report);
    if (!outcome) outcome = check_damping(&s->translation_damping, report);
    if (!outcome) outcome = check_damping(&s->twist_damping, report);
    if (!outcome) outcome = check_scene_tables(s, report);
    if (outcome) return outcome;
    if (!(fabs(s->height_difference) < s->length))
        return report_invalid(report, "height difference", s->height_difference, s->length);
    if (s->elements < 2 || s->elements > 1000000)
        return report_invalid(report, "number of elements", s->elements, 2.0);
    if (s->max_halvings < 0 || s->max_halvings > 30)
        return report_invalid(report, "number of halvings", s->max_halvings, 30.0);
    if (s->integrator < GALLOP_NEWMARK || s->integrator > GALLOP_GENERALISED_ALPHA)
        return report_invalid(report, "number of the integrator", s->integrator,
                              GALLOP_GENERALISED_ALPHA);
    if (s->integrator == GALLOP_GENERALISED_ALPHA &&
        !(s->spectral_radius >= 0.0 && s->spectral_radius <= 1.0))
        return report_invalid(report, "spectral radius", s->spectral_radius, 1.0);
    if (!(s->tolerance >= 0.0) || (s->tolerance > 0.0 && s->integrator != GALLOP_GAUSS6))
        return report_invalid(report, "tolerance, which Gauss's method alone can keep",
                              s->tolerance, 0.0);
    if (s->max_newton_iterations < 1)
        return report_invalid(report, "number of Newton iterations", s->max_newton_iterations, 1.0);
    double moment =
        s->first_moment_x2 * s->first_moment_x2 + s->first_moment_x3 * s->first_moment_x3;
    double mass = s->mass + s->ice_mass, inertia = s->torsional_inertia + s->ice_torsional_inertia;
    if (!(mass * inertia > moment))
        return report_invalid(report, "first mass moments of the ice, squared", moment,
                              mass * inertia);
    if (s->sag > 0.0 && s->horizontal_tension > 0.0) { /* m g L^2 / 8H, along the chord */
        double chord = hypot(s->length, s->height_difference);
        double parabola = mass * s->gravity * s->length * chord / (8.0 * s->horizontal_tension);
        if (fabs(s->sag - parabola) > SAG_TENSION_AGREEMENT * parabola)
            return report_invalid(report, "sag, which contradicts the horizontal tension", s->sag,
                                  parabola);
    }
    return GALLOP_COMPLETED;
}

static size_t arena_align(size_t bytes)
{
    return (bytes + 15) & ~(size_t)15;
}

static void *arena_take(char **next, size_t bytes)
{
    void *here = *next;
    *next += arena_align(bytes);
    return here;
}

static const double *arena_copy(char **next, const double *from, size_t count)
{
    double *copy = arena_take(next, count * sizeof(double));
    if (count) memcpy(copy, from, count * sizeof(double));
    return copy;
}

static size_t arena_law_bytes(const gallop_law *law)
{
    return law->kind == GALLOP_LAW_TABLE ? 2 * arena_align((size_t)law->count * sizeof(double)) : 0;
}

static void arena_copy_law(char **next, gallop_law *law)
{
    if (law->kind != GALLOP_LAW_TABLE) return;
    law->time = arena_copy(next, law->time, (size_t)law->count);
    law->value = arena_copy(next, law->value, (size_t)law->count);
}

static bool has_wind(const gallop_scene *s)
{
    return s->pieces > 0 && !(s->laws_only && law_always_zero(&s->wind));
}

/* Twist starts from rest between ends that do not turn: it stays at rest if there is no torque, no
 * eccentric ice, and no aerodynamic moment. */
static bool twists(const gallop_scene *s)
{
    bool moment = false,
         torque = s->seed_twist != 0.0 || s->first_moment_x2 != 0.0 || s->first_moment_x3 != 0.0;
    for (int i = 0; i < s->pieces && has_wind(s); i++)
        for (int k = 0; k < 4; k++) moment = moment || s->coefficient[12 * i + 8 + k] != 0.0;
    for (int i = 0; i < s->load_count; i++)
        torque = torque || (s->load[i].torque != 0.0 && !law_always_zero(&s->load[i].law));
    return moment || torque;
}

/* The span hangs in the vertical plane of its ends, and stays in it if nothing acts across. */
static bool moves_sideways(const gallop_scene *s)
{
    bool across = !s->laws_only || has_wind(s) || s->seed_horizontal != 0.0;
    for (int end = 0; end < 2; end++)
        across = across || !law_always_zero(&s->support[end].motion[2]);
    for (int i = 0; i < s->load_count; i++)
        across = across || (s->load[i].force[2] != 0.0 && !law_always_zero(&s->load[i].law));
    return across;
}

/* The one place that decides what is computed; parameters of an FMU make a new model, and so a new
 * decision. */
static void choose_parts(gallop_model *m)
{
    const gallop_scene *s = &m->scene;
    m->aerodynamic = has_wind(s);
    m->eccentric = s->first_moment_x2 != 0.0 || s->first_moment_x3 != 0.0;
    m->unknowns = twists(s) || moves_sideways(s) ? 4 : 2; /* u1 u2 alone, in the vertical plane */
    m->derived.parts = (m->aerodynamic ? GALLOP_AERODYNAMICS : 0) |
                       (m->eccentric ? GALLOP_ECCENTRIC_ICE : 0) |
                       (m->unknowns == 4 ? GALLOP_TWIST | GALLOP_LATERAL : 0);
}

/* The piece of the aerodynamic curve at the start of each bin. */
static void list_pieces(gallop_model *m)
{
    for (int bin = 0, piece = 0; bin < PIECE_BINS; bin++) {
        const double start = m->curve_first + bin * ((m->curve_last - m->curve_first) / PIECE_BINS);
        while (piece < m->scene.pieces - 1 && start >= m->scene.breakpoint[piece + 1]) piece++;
        m->piece_near[bin] = piece;
    }
}

/* Sizes of a state on the mesh as it is; state_layout says what lies in it. */
static void measure_state(gallop_model *m)
{
    const size_t elements = (size_t)m->elements, strips = (size_t)m->strips,
                 values = 4 * (size_t)m->nodes;
    const size_t stages = model_by_gauss(m) ? GAUSS_STAGES : 0;
    const size_t arrays = 3 + (stages ? GAUSS_ARRAYS : NEWMARK_HISTORY);
    m->saved_size = offsetof(gallop_state, values) + arrays * values * sizeof(double) +
                    chain_factor_count(m->elements) * sizeof(chain_factor) +
                    (stages ? elements + 1 : 0) * sizeof(complex_factor);
    const size_t scratch = (4 + arrays) * values +
                           (stages              ? 4 * stages + 2
                            : model_by_alpha(m) ? 3
                                                : 0) *
                               values +
                           3 * SECTION_ARRAYS * LANES * strips;
    m->state_size = 2 * m->saved_size + scratch * sizeof(double);
}

int gallop_model_create(const gallop_scene *scene, gallop_model **out, gallop_report *report)
{
    if (!report_start(report, 0.0)) return GALLOP_BAD_CALL;
    if (!base_pointer_usable(out, WORD)) return report_refused(report, NOT_USABLE(model), NAN, NAN);
    *out = NULL;
    const char *fault = gallop_arithmetic_fault();
    if (fault) return report_refused(report, fault, NAN, NAN);
    if (!base_pointer_usable(scene, WORD))
        return report_refused(report, NOT_USABLE(scene), NAN, NAN);
    int outcome = check(scene, report);
    if (outcome) return outcome;

    const size_t elements = (size_t)scene->elements, nodes = 2 * elements + 1,
                 loads = (size_t)scene->load_count;
    const size_t pieces = (size_t)scene->pieces;
    size_t points = 0;
    for (size_t i = 0; i < loads; i++)
        points += scene->load[i].evenly_spaced > 0 ? (size_t)scene->load[i].evenly_spaced : 1;
    const size_t strips = (elements + LANES - 1) / LANES;
    size_t bytes =
        arena_align(sizeof(gallop_model)) + arena_align(elements * sizeof(geometry)) +
        arena_align(strips * sizeof(strip)) + arena_align(PIECE_BINS * sizeof(int)) +
        arena_align(3 * nodes * sizeof(double)) + arena_align(2 * nodes * sizeof(double)) +
        arena_align(4 * nodes * sizeof(double)) + arena_align(loads * sizeof(gallop_load)) +
        arena_align(points * sizeof(load_place)) + 2 * arena_align((pieces + 1) * sizeof(double)) +
        arena_align(12 * pieces * sizeof(double)) + arena_law_bytes(&scene->wind);
    for (size_t i = 0; i < loads; i++) bytes += arena_law_bytes(&scene->load[i].law);
    for (int end = 0; end < 2; end++)
        for (int i = 0; i < 3; i++) bytes += arena_law_bytes(&scene->support[end].motion[i]);
    char *next = calloc(1, bytes);
    if (!next) return report_failure(report, GALLOP_OUT_OF_MEMORY, -1, 0.0, (double)bytes, 0.0);

    gallop_model *m = arena_take(&next, sizeof *m);
    m->scene = *scene;
    m->elements = scene->elements;
    m->nodes = (int)nodes;
    m->strips = (int)strips;
    m->geometry = arena_take(&next, elements * sizeof(geometry));
    m->strip = arena_take(&next, strips * sizeof(strip));
    m->piece_near = arena_take(&next, PIECE_BINS * sizeof(int));
    m->x = arena_take(&next, 3 * nodes * sizeof(double));
    m->normal = arena_take(&next, 2 * nodes * sizeof(double));
    m->constant_force = arena_take(&next, 4 * nodes * sizeof(double));
    m->place = arena_take(&next, points * sizeof(load_place));
    gallop_load *load = arena_take(&next, loads * sizeof(gallop_load));
    if (loads) memcpy(load, scene->load, loads * sizeof *load);
    m->scene.load = load;
    m->scene.breakpoint = arena_copy(&next, scene->breakpoint, pieces ? pieces + 1 : 0);
    m->scene.origin = arena_copy(&next, scene->origin ? scene->origin : scene->breakpoint, pieces);
    m->scene.coefficient = arena_copy(&next, scene->coefficient, 12 * pieces);
    arena_copy_law(&next, &m->scene.wind);
    for (size_t i = 0; i < loads; i++) arena_copy_law(&next, &load[i].law);
    for (int end = 0; end < 2; end++)
        for (int i = 0; i < 3; i++) arena_copy_law(&next, &m->scene.support[end].motion[i]);

    for (size_t i = 0; i < loads;
         i++) { /* place_loads turns the fraction of the length into an element */
        int count = load[i].evenly_spaced > 0 ? load[i].evenly_spaced : 1;
        for (int k = 1; k <= count; k++) {
            load_place *place = &m->place[m->load_count++];
            place->load = (int)i;
            place->shape[0] =
                load[i].evenly_spaced > 0 ? (double)k / (count + 1) : load[i].position;
        }
    }
    m->mass = scene->mass + scene->ice_mass;
    m->inertia = scene->torsional_inertia + scene->ice_torsional_inertia;
    m->radius = scene->reference_radius > 0.0 ? scene->reference_radius : 0.5 * scene->diameter;
    conditions_rotate_moments(scene, scene->attack_angle, &m->c2, &m->c3);
    if (pieces) {
        m->curve_first = m->scene.breakpoint[0];
        m->curve_last = m->scene.breakpoint[pieces];
        m->curve_centre = 0.5 * (m->curve_first + m->curve_last);
        list_pieces(m);
    }
    rayleigh(&scene->translation_damping, m->derived.translation_damping);
    rayleigh(&scene->twist_damping, m->derived.twist_damping);
    choose_parts(m);
    for (int end = 0; end < 2; end++) {
        bool rigid = scene->support[end].kind == GALLOP_SUPPORT_RIGID;
        if (!rigid)
            support_stiffness(scene, &scene->support[end], m->derived.support_stiffness[end]);
        m->stiffness[end][0] = m->derived.support_stiffness[end][0];
        m->stiffness[end][2] = m->derived.support_stiffness[end][1];
        m->fixed[end][0] = m->fixed[end][2] = rigid;
        m->fixed[end][1] = m->fixed[end][3] = true;
    }
    measure_state(m);
    outcome = statics_initial(m, report);
    if (outcome) {
        gallop_model_free(m);
        return outcome;
    }
    m->tension_only = scene->slack == GALLOP_SLACK_TENSION_ONLY;
    check_mark_model(m);
    *out = m;
    return GALLOP_COMPLETED;
}

void gallop_model_free(gallop_model *model)
{
    free(model);
}

int gallop_model_derived(const gallop_model *model, gallop_derived *derived)
{
    if (!check_is_model(model) || !base_pointer_usable(derived, WORD)) return GALLOP_BAD_CALL;
    *derived = model->derived;
    return GALLOP_COMPLETED;
}

int gallop_model_nodes(const gallop_model *model, double *x)
{
    if (!check_is_model(model) || !base_pointer_usable(x, WORD)) return GALLOP_BAD_CALL;
    memcpy(x, model->x, 3 * (size_t)model->nodes * sizeof(double));
    return GALLOP_COMPLETED;
}

int32_t gallop_middle(const gallop_model *model)
{
    return check_is_model(model) ? model->elements : -1;
}

size_t gallop_state_size(const gallop_model *model)
{
    return check_is_model(model) ? model->state_size : 0;
}

size_t gallop_saved_size(const gallop_model *model)
{
    return check_is_model(model) ? model->saved_size : 0;
}
