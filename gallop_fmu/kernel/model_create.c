/* Creation of a model: checks, copies into one block, formulas that turn the scene into numbers. */
#include "base_math.h"
#include "check.h"
#include "conditions.h"
#include "law.h"
#include "device.h"
#include "report.h"
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

/* ---- one block of memory for all arrays of a model ---- */

/* Hands out memory from a block one after another; without a block it counts what is needed. */
typedef struct {
    char *block; /* NULL: count only */
    size_t used;
} arena;

static void *arena_take(arena *a, size_t count, size_t size)
{
    void *taken = a->block ? a->block + a->used : NULL;
    a->used += (count * size + 15) & ~(size_t)15;
    return taken;
}

#define TAKE(a, count, type) ((type *)arena_take(a, (size_t)(count), sizeof(type)))

static const double *arena_copy(arena *a, const double *from, size_t count)
{
    double *copy = TAKE(a, count, double);
    if (copy && count) memcpy(copy, from, count * sizeof(double));
    return copy;
}

/* The points of a table; `to` is the copy of the law. */
static void arena_copy_law(arena *a, const gallop_law *from, gallop_law *to)
{
    if (from->kind != GALLOP_LAW_TABLE) return;
    const double *time = arena_copy(a, from->time, (size_t)from->count);
    const double *value = arena_copy(a, from->value, (size_t)from->count);
    if (!to) return;
    to->time = time;
    to->value = value;
}

static int points_of(const gallop_load *load)
{
    return load->evenly_spaced > 0 ? load->evenly_spaced : 1;
}

/* The arrays of a model, in one place: called without a block to count, then with one to fill.
 * m is NULL while it counts. */
static void lay_out(arena *a, const gallop_scene *s, gallop_model *m)
{
    gallop_model unused = {0};
    gallop_model *to = m ? m : &unused;
    const size_t pieces = (size_t)s->pieces, loads = (size_t)s->load_count;
    const int elements = s->elements, strips = (elements + LANES - 1) / LANES;
    const int nodes = 2 * elements + 1;
    int points = 0;
    for (size_t i = 0; i < loads; i++) points += points_of(&s->load[i]);

    to->curve = TAKE(a, 1, curve);
    to->section = TAKE(a, 1, cross_section);
    to->chain = TAKE(a, 1, chain);
    to->junction = TAKE(a, 2, junction);
    to->device = TAKE(a, 2, device);
    to->wind = TAKE(a, 1, const gallop_law *);
    to->place = TAKE(a, points, load_place);
    to->x = TAKE(a, 3 * nodes, double);
    to->normal = TAKE(a, 2 * nodes, double);
    to->constant_force = TAKE(a, 4 * nodes, double);
    geometry *of_elements = TAKE(a, elements, geometry);
    strip *of_strips = TAKE(a, strips, strip);
    int *piece_near = TAKE(a, PIECE_BINS, int);

    gallop_load *load = TAKE(a, loads, gallop_load);
    const double *breakpoint = arena_copy(a, s->breakpoint, pieces ? pieces + 1 : 0);
    const double *origin = arena_copy(a, s->origin ? s->origin : s->breakpoint, pieces);
    const double *coefficient = arena_copy(a, s->coefficient, 12 * pieces);
    if (m && loads) memcpy(load, s->load, loads * sizeof *load);
    arena_copy_law(a, &s->wind, m ? &m->scene.wind : NULL);
    for (size_t i = 0; i < loads; i++) arena_copy_law(a, &s->load[i].law, m ? &load[i].law : NULL);
    for (int end = 0; end < 2; end++)
        for (int i = 0; i < 3; i++)
            arena_copy_law(a, &s->support[end].motion[i],
                           m ? &m->scene.support[end].motion[i] : NULL);
    if (!m) return;
    m->scene.load = load;
    m->scene.breakpoint = breakpoint;
    m->scene.origin = origin;
    m->scene.coefficient = coefficient;
    m->curve[0].piece_near = piece_near;
    m->chain[0].geometry = of_elements;
    m->chain[0].strip = of_strips;
    m->chain[0].x = m->x;
    m->chain[0].normal = m->normal;
}

/* ---- tables of kinds from the scene ---- */

/* The piece of the curve at the start of each bin. */
static void list_pieces(curve *k)
{
    for (int bin = 0, piece = 0; bin < PIECE_BINS; bin++) {
        const double start = k->first + bin * ((k->last - k->first) / PIECE_BINS);
        while (piece < k->pieces - 1 && start >= k->breakpoint[piece + 1]) piece++;
        k->piece_near[bin] = piece;
    }
}

static void create_curve(gallop_model *m)
{
    const gallop_scene *s = &m->scene;
    curve *k = &m->curve[0];
    if (s->pieces == 0) return;
    m->curve_count = 1;
    k->pieces = s->pieces;
    k->outside = s->outside;
    k->breakpoint = s->breakpoint;
    k->origin = s->origin;
    k->coefficient = s->coefficient;
    k->first = k->breakpoint[0];
    k->last = k->breakpoint[k->pieces];
    k->centre = 0.5 * (k->first + k->last);
    list_pieces(k);
}

static void create_section(gallop_model *m)
{
    const gallop_scene *s = &m->scene;
    cross_section *c = &m->section[0];
    m->section_count = 1;
    c->diameter = s->diameter;
    c->mass = s->mass + s->ice_mass;
    c->inertia = s->torsional_inertia + s->ice_torsional_inertia;
    c->axial_stiffness = s->axial_stiffness;
    c->torsional_stiffness = s->torsional_stiffness;
    rayleigh(&s->translation_damping, c->translation_damping);
    rayleigh(&s->twist_damping, c->twist_damping);
    c->attack = s->attack_angle;
    c->moment_angle = s->first_moment_angle;
    c->moment[0] = s->first_moment_x2;
    c->moment[1] = s->first_moment_x3;
    conditions_rotate_moments(c, c->attack, &c->c2, &c->c3);
    c->radius = s->reference_radius > 0.0 ? s->reference_radius : 0.5 * s->diameter;
    c->eccentric = s->first_moment_x2 != 0.0 || s->first_moment_x3 != 0.0;
    c->tension_only = s->slack == GALLOP_SLACK_TENSION_ONLY;
    c->curve = s->pieces > 0 ? &m->curve[0] : NULL;
    memcpy(m->derived.translation_damping, c->translation_damping, sizeof c->translation_damping);
    memcpy(m->derived.twist_damping, c->twist_damping, sizeof c->twist_damping);
}

static void create_chain(gallop_model *m)
{
    const gallop_scene *s = &m->scene;
    chain *c = &m->chain[0];
    m->chain_count = 1;
    c->section = &m->section[0];
    c->junction[1] = 1;
    c->elements = s->elements;
    c->nodes = 2 * c->elements + 1;
    c->strips = (c->elements + LANES - 1) / LANES;
    c->gravity = s->gravity;
    c->air_density = s->air_density;
    c->span = s->length;
    c->rise = s->height_difference;
    c->target_sag = s->sag;
    c->target_tension = s->horizontal_tension;
    m->elements = c->elements;
    m->nodes = c->nodes;
    m->strips = c->strips;
}

static void create_junctions(gallop_model *m)
{
    const gallop_scene *s = &m->scene;
    m->junction_count = 2;
    for (int end = 0; end < 2; end++) {
        const bool rigid = s->support[end].kind == GALLOP_SUPPORT_RIGID;
        junction *j = &m->junction[end];
        j->node = end ? m->nodes - 1 : 0;
        j->position[0] = end ? s->length : 0.0;
        j->position[1] = end ? s->height_difference : 0.0;
        j->fixed[0] = j->fixed[2] = rigid;
        j->fixed[1] = j->fixed[3] = true;
        for (int i = 0; i < 3; i++) {
            const gallop_law *law = &s->support[end].motion[i];
            j->motion[i] = law_always_zero(law) ? NULL : law;
        }
    }
}

static void create_load_places(gallop_model *m)
{
    const gallop_scene *s = &m->scene;
    for (int i = 0; i < s->load_count; i++)
        for (int k = 1; k <= points_of(&s->load[i]); k++) {
            load_place *place = &m->place[m->load_count++];
            place->load = i;
            place->fraction = s->load[i].evenly_spaced > 0
                                ? (double)k / (points_of(&s->load[i]) + 1)
                                : s->load[i].position;
        }
}

/* ---- what the scene needs ---- */

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
    m->chain[0].aerodynamic = has_wind(s);
    m->unknowns = twists(s) || moves_sideways(s) ? 4 : 2; /* u1 u2 alone, in the vertical plane */
    m->derived.parts = (m->chain[0].aerodynamic ? GALLOP_AERODYNAMICS : 0) |
                       (m->section[0].eccentric ? GALLOP_ECCENTRIC_ICE : 0) |
                       (m->unknowns == 4 ? GALLOP_TWIST | GALLOP_LATERAL : 0);
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

    arena memory = {NULL, 0};
    TAKE(&memory, 1, gallop_model);
    lay_out(&memory, scene, NULL);
    const size_t bytes = memory.used;
    memory = (arena){calloc(1, bytes), 0};
    if (!memory.block)
        return report_failure(report, GALLOP_OUT_OF_MEMORY, -1, 0.0, (double)bytes, 0.0);
    gallop_model *m = TAKE(&memory, 1, gallop_model);
    m->scene = *scene;
    lay_out(&memory, scene, m);

    create_curve(m);
    create_section(m);
    create_chain(m);
    create_junctions(m);
    create_load_places(m);
    m->field_count = 1;
    m->wind[0] = &m->scene.wind;
    device_create_all(m);
    choose_parts(m);
    state_measure(m);
    outcome = statics_initial(m, report);
    if (outcome) {
        gallop_model_free(m);
        return outcome;
    }
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
