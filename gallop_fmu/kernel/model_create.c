/* Creation of a model: checks, copies into one block, formulas that turn the scene into numbers. */
#include "base_math.h"
#include "check.h"
#include "conditions.h"
#include "law.h"
#include "device.h"
#include "model_create.h"
#include "report.h"
#include "solver.h"
#include "statics.h"

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

/* ---- one block of memory for all arrays of a model ---- */

/* Hands out memory from a block one after another; without a block it counts what is needed. */
typedef struct {
    char *block; /* NULL: count only */
    size_t used;
} arena;

static void *arena_take(arena *a, size_t count, size_t size)
{
    void *taken = a->block ? a->block + a->used : NULL;
    a->used += base_whole_vectors(count * size);
    return taken;
}

#define TAKE(a, count, type) ((type *)arena_take(a, (size_t)(count), sizeof(type)))

/* A copy of a table of the scene; NULL while memory is only counted. */
static void *arena_copy(arena *a, const void *from, int64_t count, size_t size)
{
    void *copy = arena_take(a, (size_t)count, size);
    if (copy && count) memcpy(copy, from, (size_t)count * size);
    return copy;
}

#define COPY(a, s, name) arena_copy(a, (s)->name, (s)->name##_count, sizeof *(s)->name)

static int points_of(const gallop_load *load)
{
    return load->evenly_spaced > 0 ? load->evenly_spaced : 1;
}

/* Values of a nodal load: of the whole chain, or of one element. */
static int load_values(const gallop_scene *s, const gallop_load *load)
{
    return load->evenly_spaced > 0 ? 4 * (2 * s->chain[load->chain].elements + 1) : 12;
}

static int strips_of(int elements)
{
    return (elements + LANES - 1) / LANES;
}

/* Elements of a chain of the scene with one cross-section. */
typedef struct {
    int cross_section, first, elements;
} part;

/* Finds the end of a part of a chain that begins at its station before `*station`, which becomes
 * the one behind that end.  Returns the cross-section of the next part; -1: there is none. */
static int end_part(const gallop_scene *s, int index, int *station, part *now)
{
    int next = -1;
    now->elements = s->chain[index].elements - now->first;
    while (next < 0 && *station < s->station_count && s->station[*station].chain == index) {
        const gallop_station *at = &s->station[(*station)++];
        if (at->cross_section < 0) continue;
        next = at->cross_section;
        now->elements = at->corner - now->first;
    }
    return next;
}

/* A junction at which no chain ends and no station lies. */
static bool is_body(const gallop_scene *s, int index)
{
    for (int i = 0; i < s->chain_count; i++)
        if (s->chain[i].junction[0] == index || s->chain[i].junction[1] == index) return false;
    for (int i = 0; i < s->station_count; i++)
        if (s->station[i].junction == index) return false;
    return true;
}

/* Counts that follow from the scene. */
static void count_all(const gallop_scene *s, gallop_model *m)
{
    m->curve_count = s->curve_count;
    m->section_count = s->cross_section_count;
    m->field_count = s->field_count;
    m->chain_count = s->chain_count;
    m->junction_count = s->junction_count;
    m->device_count = s->device_count;
    m->law_count = s->law_count;
    m->shedding_count = s->shedding_count;
    m->varied = model_create_is_varied(s);
    for (int i = 0; i < s->load_count; i++) m->load_count += points_of(&s->load[i]);
    for (int i = 0, station = 0; i < s->chain_count; i++) {
        part now = {.first = 0};
        for (int next = 0; next >= 0; now.first += now.elements) {
            next = end_part(s, i, &station, &now);
            m->interval_count++;
            m->strips += strips_of(now.elements);
        }
        m->elements += s->chain[i].elements;
        m->nodes += 2 * s->chain[i].elements + 1;
    }
    for (int j = 0; j < s->junction_count; j++) m->nodes += is_body(s, j);
}

/* Arrays of elements, strips, corners and bins, which chains and curves share. */
typedef struct {
    geometry *geometry;
    strip *strip;
    kept_corner *kept;
    int *strip_start, *piece_near;
    double *load_force;
} shared;

/* The arrays of a model with its counts, in one place: called without a block to count the memory,
 * then with one. */
static shared lay_out(arena *a, const gallop_scene *s, gallop_model *m)
{
    m->curve = TAKE(a, m->curve_count, curve);
    m->section = TAKE(a, m->section_count, cross_section);
    m->chain = TAKE(a, m->chain_count, chain);
    m->interval = TAKE(a, m->interval_count, interval);
    m->junction = TAKE(a, m->junction_count, junction);
    m->tie = TAKE(a, 2 * m->chain_count + s->station_count, tie);
    m->device = TAKE(a, m->device_count, device);
    m->law = TAKE(a, m->law_count, law);
    m->wind = TAKE(a, m->field_count, const law *);
    m->direction = TAKE(a, m->field_count, const law *);
    m->section_place = TAKE(a, m->varied ? 3 * LANES * (size_t)m->strips : 0, wind_place);
    m->node_place = TAKE(a, m->varied ? m->nodes : 0, wind_place);
    m->shedding_time = TAKE(a, m->shedding_count, double);
    m->place = TAKE(a, m->load_count, load_place);
    m->nodal_load = TAKE(a, s->load_count, nodal_load);
    m->x = TAKE(a, 3 * (size_t)m->nodes, double);
    m->normal = TAKE(a, 2 * (size_t)m->nodes, double);
    m->constant_force = TAKE(a, 4 * (size_t)m->nodes, double);
    m->chord = TAKE(a, 4 * (size_t)m->nodes, double);
    m->chord_inverse = TAKE(a, 4 * (size_t)m->nodes, double);
    m->scene.cross_section = COPY(a, s, cross_section);
    m->scene.curve = COPY(a, s, curve);
    m->scene.field = COPY(a, s, field);
    m->scene.junction = COPY(a, s, junction);
    m->scene.chain = COPY(a, s, chain);
    m->scene.station = COPY(a, s, station);
    m->scene.device = COPY(a, s, device);
    m->scene.load = COPY(a, s, load);
    m->scene.law = COPY(a, s, law);
    m->scene.shedding = COPY(a, s, shedding);
    m->scene.number = COPY(a, s, number);
    size_t load_force = 0;
    for (int i = 0; i < s->load_count; i++) load_force += (size_t)load_values(s, &s->load[i]);
    return (shared){TAKE(a, m->elements, geometry),
                    TAKE(a, m->strips, strip),
                    TAKE(a, 2 * (size_t)m->chain_count + (size_t)s->station_count, kept_corner),
                    TAKE(a, (size_t)m->strips + (size_t)m->chain_count, int),
                    TAKE(a, (size_t)PIECE_BINS * (size_t)m->curve_count, int),
                    TAKE(a, load_force, double)};
}

/* ---- tables of kinds from the scene ---- */

static void create_laws(gallop_model *m)
{
    const gallop_scene *s = &m->scene;
    for (int i = 0; i < m->law_count; i++) m->law[i] = law_from(&s->law[i], s->number);
    for (int i = 0; i < m->field_count; i++) {
        const gallop_field *f = &s->field[i];
        const bool turns = f->kind == GALLOP_FIELD_VARIED && f->direction >= 0;
        m->wind[i] = &m->law[f->law];
        m->direction[i] = turns ? &m->law[f->direction] : NULL;
    }
}

/* The piece of the curve at the start of each bin. */
static void list_pieces(curve *k)
{
    for (int bin = 0, piece = 0; bin < PIECE_BINS; bin++) {
        const double start = k->first + bin * ((k->last - k->first) / PIECE_BINS);
        while (piece < k->pieces - 1 && start >= k->breakpoint[piece + 1]) piece++;
        k->piece_near[bin] = piece;
    }
}

static void create_curves(gallop_model *m, int *piece_near)
{
    for (int i = 0; i < m->curve_count; i++) {
        const gallop_curve *from = &m->scene.curve[i];
        curve *k = &m->curve[i];
        k->pieces = from->pieces;
        k->outside = from->outside;
        k->breakpoint = m->scene.number + from->first;
        k->origin = k->breakpoint + k->pieces + 1;
        k->coefficient = k->origin + k->pieces;
        k->first = k->breakpoint[0];
        k->last = k->breakpoint[k->pieces];
        k->centre = 0.5 * (k->first + k->last);
        k->piece_near = piece_near + (size_t)i * PIECE_BINS;
        list_pieces(k);
    }
}

static void create_sections(gallop_model *m)
{
    const gallop_settings *settings = &m->scene.settings;
    for (int i = 0; i < m->section_count; i++) {
        const gallop_cross_section *from = &m->scene.cross_section[i];
        cross_section *c = &m->section[i];
        c->diameter = from->diameter;
        c->mass = from->mass + from->ice_mass;
        c->strung_mass = settings->strung && !settings->strung_with_ice ? from->mass : c->mass;
        c->thermal_expansion = from->thermal_expansion;
        c->inertia = from->torsional_inertia + from->ice_torsional_inertia;
        c->axial_stiffness = from->axial_stiffness;
        c->torsional_stiffness = from->torsional_stiffness;
        rayleigh(&from->translation_damping, c->translation_damping);
        rayleigh(&from->twist_damping, c->twist_damping);
        c->attack = from->attack_angle;
        c->moment_angle = from->first_moment_angle;
        c->moment[0] = from->first_moment_x2;
        c->moment[1] = from->first_moment_x3;
        conditions_rotate_moments(c, c->attack, &c->c2, &c->c3);
        c->radius = from->reference_radius > 0.0 ? from->reference_radius : 0.5 * from->diameter;
        c->eccentric = from->first_moment_x2 != 0.0 || from->first_moment_x3 != 0.0;
        c->tension_only = from->slack == GALLOP_SLACK_TENSION_ONLY;
        c->curve = from->curve >= 0 ? &m->curve[from->curve] : NULL;
    }
}

/* The part of a chain whose elements follow those of the interval before. */
static void create_interval(gallop_model *m, const chain *c, int field, const part *from,
                            int first_strip, interval *to)
{
    to->section_index = from->cross_section;
    to->section = &m->section[from->cross_section];
    to->field = field;
    to->elements = from->elements;
    to->nodes = 2 * from->elements + 1;
    to->strips = strips_of(from->elements);
    to->first_node = c->first_node + 2 * from->first;
    to->first_element = c->first_element + from->first;
    to->first_strip = first_strip;
    to->gravity = m->scene.settings.gravity;
    to->air_density = m->scene.settings.air_density;
    to->geometry = c->geometry + from->first;
    to->x = c->x + 6 * from->first;
}

/* How far the tables of intervals, strips and corners are filled. */
typedef struct {
    int station, interval, strip, kept;
} filled;

static void create_intervals(gallop_model *m, int index, const shared *arrays, filled *so_far)
{
    const gallop_chain *from = &m->scene.chain[index];
    chain *c = &m->chain[index];
    part now = {.cross_section = from->cross_section};
    int *start = arrays->strip_start + so_far->strip + index;
    c->first_interval = so_far->interval;
    c->first_strip = so_far->strip;
    c->strip_start = start;
    for (int next = 0; next >= 0; now = (part){next, now.first + now.elements, 0}) {
        interval *to = &m->interval[so_far->interval++];
        next = end_part(&m->scene, index, &so_far->station, &now);
        create_interval(m, c, from->field, &now, so_far->strip, to);
        to->strip = arrays->strip + so_far->strip;
        for (int k = 0; k < to->strips; k++) *start++ = now.first + LANES * k;
        so_far->strip += to->strips;
    }
    *start = c->elements;
    c->intervals = so_far->interval - c->first_interval;
    c->strips = so_far->strip - c->first_strip;
}

/* The corners of a chain at which junctions lie; its stations are those from `station` on. */
static void create_kept(gallop_model *m, int index, int station, kept_corner *kept)
{
    const gallop_scene *s = &m->scene;
    chain *c = &m->chain[index];
    c->kept = kept;
    *kept++ = (kept_corner){0, c->junction[0]};
    for (int i = station; i < s->station_count && s->station[i].chain == index; i++)
        if (s->station[i].junction >= 0)
            *kept++ = (kept_corner){s->station[i].corner, s->station[i].junction};
    *kept++ = (kept_corner){c->elements, c->junction[1]};
    c->kept_corners = (int)(kept - c->kept);
}

static void create_chains(gallop_model *m, const shared *arrays)
{
    int node = 0, element = 0;
    filled so_far = {0};
    for (int i = 0; i < m->chain_count; i++) {
        const gallop_chain *from = &m->scene.chain[i];
        const cross_section *section = &m->section[from->cross_section];
        const double *left = m->scene.junction[from->junction[0]].position;
        const double *right = m->scene.junction[from->junction[1]].position;
        chain *c = &m->chain[i];
        memcpy(c->junction, from->junction, sizeof c->junction);
        c->elements = from->elements;
        c->nodes = 2 * c->elements + 1;
        c->first_node = node;
        c->first_element = element;
        c->weight = section->strung_mass * m->scene.settings.gravity;
        c->mass = section->mass;
        c->span = right[0] - left[0];
        c->rise = right[1] - left[1];
        c->target_sag = from->sag;
        c->target_tension = from->horizontal_tension;
        c->geometry = arrays->geometry + element;
        c->x = m->x + 3 * node;
        c->normal = m->normal + 2 * node;
        create_kept(m, i, so_far.station, arrays->kept + so_far.kept);
        create_intervals(m, i, arrays, &so_far);
        so_far.kept += c->kept_corners;
        node += c->nodes;
        element += c->elements;
    }
}

/* Junctions at which no chain has a corner get nodes of their own. */
static void create_bodies(gallop_model *m)
{
    int node = 0;
    for (int i = 0; i < m->chain_count; i++) node += m->chain[i].nodes;
    for (int i = 0; i < m->junction_count; i++) {
        junction *j = &m->junction[i];
        j->body = j->node < 0;
        if (!j->body) continue;
        memcpy(m->x + 3 * node, j->position, sizeof j->position);
        j->node = node++;
    }
}

/* The first corner of a chain at a junction leads; the others follow. */
static void create_junctions(gallop_model *m)
{
    for (int i = 0; i < m->junction_count; i++) {
        const gallop_junction *from = &m->scene.junction[i];
        junction *j = &m->junction[i];
        memcpy(j->position, from->position, sizeof j->position);
        j->node = -1;
        j->fixed[3] = from->fixed[3] != 0;
        for (int k = 0; k < 3; k++) {
            const law *moved = from->motion[k] >= 0 ? &m->law[from->motion[k]] : NULL;
            j->motion[k] = moved && !law_always_zero(moved) ? moved : NULL;
            j->fixed[k] = from->fixed[k] != 0;
        }
    }
    for (int i = 0; i < m->chain_count; i++)
        for (int k = 0; k < m->chain[i].kept_corners; k++) {
            const chain *c = &m->chain[i];
            junction *j = &m->junction[c->kept[k].junction];
            const int node = c->first_node + 2 * c->kept[k].corner;
            if (j->node < 0)
                j->node = node;
            else
                m->tie[m->tie_count++] = (tie){node, j->node, 0};
        }
    create_bodies(m);
}

static void create_load_places(gallop_model *m, double *load_force)
{
    const gallop_scene *s = &m->scene;
    int place = 0;
    for (int i = 0; i < s->load_count; i++) {
        const int values = load_values(s, &s->load[i]);
        m->nodal_load[i] = (nodal_load){0, values, load_force};
        load_force += values;
        for (int k = 1; k <= points_of(&s->load[i]); k++)
            m->place[place++] = (load_place){
                .load = i,
                .chain = s->load[i].chain,
                .fraction = s->load[i].evenly_spaced > 0 ? (double)k / (points_of(&s->load[i]) + 1)
                                                         : s->load[i].position};
    }
}

/* What a caller sees of the first conductor and the devices at the first and last junction. */
static void derive_constants(gallop_model *m)
{
    const cross_section *c = m->interval[0].section;
    memcpy(m->derived.translation_damping, c->translation_damping, sizeof c->translation_damping);
    memcpy(m->derived.twist_damping, c->twist_damping, sizeof c->twist_damping);
    for (int i = 0; i < m->device_count; i++) {
        const device *d = &m->device[i];
        const int last = d->junction[0] == m->junction_count - 1;
        if (!d->kind->prestressed || (d->junction[0] != 0 && !last)) continue;
        m->derived.support_stiffness[last][0] += d->constant[0];
        m->derived.support_stiffness[last][1] += d->constant[2];
    }
}

/* A junction at which one span ends, or none, is fixed, or a device holds it. */
static int check_held(const gallop_model *m, gallop_report *report)
{
    for (int i = 0; i < m->junction_count; i++) {
        int spans = 0; /* elements that hold the junction on both sides count twice */
        for (int c = 0; c < m->chain_count; c++)
            for (int k = 0; k < m->chain[c].kept_corners; k++) {
                const bool inside = k > 0 && k < m->chain[c].kept_corners - 1;
                if (m->chain[c].kept[k].junction == i) spans += inside ? 2 : 1;
            }
        for (int k = 0; k < 4 && spans < 2; k++) {
            if (m->junction[i].fixed[k]) continue;
            if (!device_holds(m, i, k))
                return report_invalid(report, "stiffness of a support", 0.0, 0.0);
            if (m->junction[i].body && !device_gives_mass(m, i, k))
                return report_invalid(report, "mass of a body, which no span gives it", 0.0, 0.0);
        }
    }
    return GALLOP_COMPLETED;
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
    int outcome = check_scene(scene, report);
    if (!outcome) outcome = device_check_all(scene, report);
    if (outcome) return outcome;

    gallop_model counted = {.scene = *scene};
    arena memory = {NULL, 0};
    count_all(scene, &counted);
    TAKE(&memory, 1, gallop_model);
    lay_out(&memory, scene, &counted);
    const size_t bytes = memory.used;
    void *allocated = calloc(1, bytes + VECTOR);
    if (!allocated)
        return report_failure(report, GALLOP_OUT_OF_MEMORY, -1, 0.0, (double)bytes, 0.0);
    memory = (arena){base_first_vector(allocated), 0};
    gallop_model *m = TAKE(&memory, 1, gallop_model);
    *m = counted;
    m->allocated = allocated;
    const shared arrays = lay_out(&memory, scene, m);

    create_laws(m);
    create_curves(m, arrays.piece_near);
    create_sections(m);
    create_chains(m, &arrays);
    create_junctions(m);
    create_load_places(m, arrays.load_force);
    device_create_all(m);
    device_prepare_all(m);
    derive_constants(m);
    model_create_parts(m);
    solver_measure(m);
    state_measure(m);
    outcome = check_held(m, report);
    if (!outcome) outcome = statics_initial(m, report);
    if (!outcome) outcome = model_create_wind_places(m, report);
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
    if (model) free(model->allocated);
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
