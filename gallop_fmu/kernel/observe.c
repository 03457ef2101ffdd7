/* Observation of a state: quantities of nodes, junctions, fields and the system. */
#include "observe.h"

#include "base_math.h"
#include "check.h"
#include "device.h"
#include "law.h"

/* Linear through the two Gauss points (xi = +-1/sqrt 3), which are the accurate ones; averaged at
 * corner nodes. */
static double node_tension(const gallop_model *model, const chain *c, const double *u, int node)
{
    double sum = 0.0, lowest = -INFINITY;
    int count = 0;
    for (int side = 0; side < 2; side++) {
        int e = node % 2 ? node / 2 : node / 2 - 1 + side;
        if (e < 0 || e >= c->elements || (side && node % 2)) continue;
        const interval *of = model_interval_of_element(model, c->first_element + e);
        const bool tension_only = of->section->tension_only;
        double xi = (double)(node - 2 * e - 1), t[2];
        element_tension(of, c->first_element + e - of->first_element, tension_only, u + 8 * e, t);
        sum += 0.5 * (t[0] + t[1]) + xi * (t[1] - t[0]) / (element_gauss2[1] - element_gauss2[0]);
        if (tension_only) lowest = 0.0;
        count++;
    }
    return fmax(sum / count, lowest);
}

/* Attack angle of the relative wind at a node; between two intervals, on the left one. */
static double node_angle(const gallop_model *model, const state_view *view, const chain *c,
                         int node)
{
    const int own = node - c->first_node, e = own > 0 ? (own - 1) / 2 : 0;
    const interval *of = model_interval_of_element(model, c->first_element + e);
    const exposure now = conditions_on(model, &view->now, of);
    const double *u = view->u + 4 * node, *v = view->v + 4 * node;
    const double *n2 = model->normal + 2 * node;
    double wind[2];
    const wind_place *place = model->varied ? &model->node_place[node] : NULL;
    conditions_wind_at(model, &view->now, of->field, place, wind);
    return element_attack_angle(u[3], n2[0] * v[0] + n2[1] * v[1] - wind[0], v[2], v[3], wind[1],
                                now.attack, now.section->radius);
}

static double node_value(const gallop_model *model, const state_view *view, int node, int channel)
{
    if (channel < GALLOP_V1) return view->u[4 * node + channel - GALLOP_U1];
    if (channel < GALLOP_A1) return view->v[4 * node + channel - GALLOP_V1];
    if (channel < GALLOP_TENSION) return view->a[4 * node + channel - GALLOP_A1];
    const chain *last = &model->chain[model->chain_count - 1];
    if (node >= last->first_node + last->nodes) return 0.0; /* of a body */
    const chain *c = model_chain_of_node(model, node);
    return channel == GALLOP_TENSION
             ? node_tension(model, c, view->u + 4 * c->first_node, node - c->first_node)
             : node_angle(model, view, c, node);
}

/* Subtracts the loads on an element from its forces at one end. */
static void subtract_end_loads(const gallop_model *model, const gallop_state *state,
                               const conditions *now, int index, int end, double r[3])
{
    const int e = end ? model->chain[index].elements - 1 : 0;
    for (int l = 0; l < model->load_count; l++) {
        const load_place *place = &model->place[l];
        const gallop_load *load = &model->scene.load[place->load];
        if (place->chain != index || place->element != e) continue;
        const double amplitude = now->load_factor * law_value(&model->law[load->law], state->time);
        for (int i = 0; i < 3; i++) r[i] -= amplitude * place->shape[end ? 2 : 0] * load->force[i];
    }
}

/* The force that moves the end of a chain so, beyond the static one. */
static void chain_end_force(const gallop_model *model, const gallop_state *state,
                            const state_view *view, int index, int end, double force[3])
{
    const chain *c = &model->chain[index];
    const int first = 4 * c->first_node, e = end ? c->elements - 1 : 0, own = end ? 8 : 0;
    const int node = first + (end ? 4 * (c->nodes - 1) : 0);
    const interval *of = model_interval_of_element(model, c->first_element + e);
    const exposure now = conditions_on(model, &view->now, of);
    const int from = 4 * of->first_node;
    const motion y = {view->u + from, view->v + from, view->a + from};
    double r[12];
    element_residual(of, c->first_element + e - of->first_element, &now, &view->sections, y, r);
    subtract_end_loads(model, state, &view->now, index, end, r + own);
    for (int i = 0; i < 3; i++) force[i] = r[own + i] - model->constant_force[node + i];
}

/* Force of the chains on the tower at a junction: minus that of the support, which is the static
 * one plus what moves the chains' ends where they are prescribed, and minus the force of the
 * devices to the tower where they are not. */
static void support_force(const gallop_model *model, const gallop_state *state,
                          const state_view *view, int index, double force[3])
{
    const junction *j = &model->junction[index];
    const motion y = {view->u, view->v, view->a};
    double of_devices[3], of_chains[3] = {0.0, 0.0, 0.0};
    device_tower_force(model, index, &view->now, y, of_devices);
    for (int k = 0; k < model->chain_count; k++)
        for (int end = 0; end < 2; end++) {
            double of_end[3];
            if (model->chain[k].junction[end] != index) continue;
            chain_end_force(model, state, view, k, end, of_end);
            for (int i = 0; i < 3; i++) of_chains[i] += of_end[i];
        }
    for (int i = 0; i < 3; i++)
        force[i] = -(j->static_force[i] + (j->fixed[i] ? of_chains[i] : -of_devices[i]));
}

/* Kinetic and potential energy of the elements of a strip: see energies. */
INLINE void strip_energies(const interval *c, const exposure *now, const strip *s, lanes u[3][4],
                           lanes v[3][4], lanes *kinetic, lanes *potential)
{
    const double ea = now->section->axial_stiffness, gj = now->section->torsional_stiffness;
    double theta[3 * LANES], sine[3 * LANES], cosine[3 * LANES];
    for (int q = 0; q < 3; q++)
        LANES_AT(theta + LANES * q) = element_shape3[q][0] * u[0][3] +
                                      element_shape3[q][1] * u[1][3] +
                                      element_shape3[q][2] * u[2][3];
    if (now->section->eccentric)
        for (int i = 0; i < 3 * LANES; i++) sine_cosine(theta[i], sine + i, cosine + i);
    for (int q = 0; q < 3; q++) {
        const double *n = element_shape3[q];
        lanes velocity[4];
        for (int i = 0; i < 4; i++) velocity[i] = n[0] * v[0][i] + n[1] * v[1][i] + n[2] * v[2][i];
        const lanes square =
            velocity[0] * velocity[0] + velocity[1] * velocity[1] + velocity[2] * velocity[2];
        const lanes w = velocity[3], weight = s->inertia_weight[q];
        *kinetic +=
            weight * (0.5 * now->section->mass * square + 0.5 * now->section->inertia * w * w);
        if (!now->section->eccentric) continue;
        const lanes sin_q = LANES_AT(sine + LANES * q), cos_q = LANES_AT(cosine + LANES * q);
        const lanes c2 = now->c2 * cos_q - now->c3 * sin_q, c3 = now->c2 * sin_q + now->c3 * cos_q;
        const lanes v2 = s->normal[q][0] * velocity[0] + s->normal[q][1] * velocity[1];
        *kinetic += weight * w * (c2 * velocity[2] - c3 * v2);
        *potential += weight * c->gravity * s->normal[q][1] *
                      (c2 - now->c2 + now->c3 * LANES_AT(theta + LANES * q));
    }
    for (int q = 0; q < 2; q++) {
        const lanes *n = s->shape_slope[q];
        lanes strain = {0.0}, du[4];
        for (int i = 0; i < 4; i++) du[i] = n[0] * (u[0][i] - u[1][i]) + n[1] * (u[2][i] - u[1][i]);
        for (int i = 0; i < 3; i++) strain += du[i] * (s->slope[q][i] + 0.5 * du[i]);
        const lanes slack = s->tension[q] / -ea; /* beyond, no more energy is released */
        if (now->tension_only) strain = PICK(strain > slack, strain, slack);
        const lanes axial = strain * (s->tension[q] + 0.5 * ea * strain),
                    torsional = 0.5 * gj * du[3] * du[3];
        *potential += s->stiffness_weight[q] * (axial + torsional);
    }
}

/* Work of the change of the constant forces of an interval whose ice has fallen. */
static double lost_work(const interval *c, const exposure *now, const double *u)
{
    double work = 0.0;
    for (int e = 0; e < c->elements; e++) {
        const double *of_element = u + 4 * c->first_node + 8 * e;
        double force[12] = {0.0};
        element_add_lost_forces(c, e, now, 1.0, force);
        for (int i = 0; i < 12; i++) work += force[i] * of_element[i];
    }
    return work;
}

/* Kinetic: mu v.v/2 + w (c2 v3 - c3 v2) + I w^2/2, with v2 and v3 in the section's plane.
 * Potential: axial and torsional strain energy from the initial state, gravity, the constant
 * forces, and the devices. */
TWO_PATHS static void energies(const gallop_model *model, const state_view *view, double *kinetic,
                               double *potential)
{
    const motion y = {view->u, view->v, view->a};
    double k = 0.0, p = 0.0;
    for (int i = 0; i < model->interval_count; i++) {
        const interval *c = &model->interval[i];
        const exposure now = conditions_on(model, &view->now, c);
        lanes kinetic_of = {0.0}, potential_of = {0.0};
        for (int index = 0; index < c->strips; index++) {
            const int e = LANES * index, count = c->elements - e, first = 4 * c->first_node + 8 * e;
            lanes ue[3][4], ve[3][4];
            for (int n = 0; n < 3; n++) {
                read_nodes(view->u + first, n, count, ue[n]);
                read_nodes(view->v + first, n, count, ve[n]);
            }
            strip_energies(c, &now, &c->strip[index], ue, ve, &kinetic_of, &potential_of);
        }
        for (int lane = 0; lane < LANES; lane++) {
            k += LANE(kinetic_of, lane);
            p += LANE(potential_of, lane);
        }
        if (now.section != c->section) p -= lost_work(c, &now, view->u);
    }
    for (int i = 0; i < 4 * model->nodes; i++) p -= model->constant_force[i] * view->u[i];
    *kinetic = k;
    *potential = p;
    device_add_energies(model, &view->now, y, kinetic, potential);
}

/* What several probes of one observation share. */
typedef struct {
    bool has_forces; /* the marks of the forces are set, */
    bool has_energies;
    double energy[2]; /* kinetic, potential [J] */
} shared_values;

/* Force of the chains on the tower at a junction.  Forces that are known lie in the scratch array
 * of residual forces, which has room for more nodes than there are junctions: three components, and
 * a mark, 1 if they are known. */
static double junction_value(const gallop_model *model, const gallop_state *state,
                             const state_view *view, int index, int channel, shared_values *shared)
{
    if (!shared->has_forces)
        for (int j = 0; j < model->junction_count; j++) view->residual[4 * j + 3] = 0.0;
    shared->has_forces = true;
    double *force = view->residual + 4 * index;
    if (force[3] == 0.0) support_force(model, state, view, index, force);
    force[3] = 1.0;
    return force[channel];
}

static double system_value(const gallop_model *model, const gallop_state *state,
                           const state_view *view, int channel, shared_values *shared)
{
    if (channel == GALLOP_NEWTON_ITERATIONS) return (double)state->last_iterations;
    if (channel == GALLOP_SUBSTEPS) return (double)state->last_substeps;
    if (!shared->has_energies)
        energies(model, view, &shared->energy[GALLOP_KINETIC_ENERGY],
                 &shared->energy[GALLOP_POTENTIAL_ENERGY]);
    shared->has_energies = true;
    return shared->energy[channel];
}

void observe_probes(const gallop_model *model, const gallop_state *state, const state_view *view,
                    const gallop_probe *probe, int32_t probes, double *values)
{
    shared_values shared = {0};
    for (int32_t i = 0; i < probes; i++) {
        const gallop_probe *p = &probe[i];
        switch (p->object) {
        case GALLOP_PROBE_NODE: values[i] = node_value(model, view, p->index, p->channel); break;
        case GALLOP_PROBE_JUNCTION:
            values[i] = junction_value(model, state, view, p->index, p->channel, &shared);
            break;
        case GALLOP_PROBE_DEVICE:
            values[i] = device_value(model, p->index, &view->now,
                                     (motion){view->u, view->v, view->a}, p->channel);
            break;
        case GALLOP_PROBE_FIELD: values[i] = view->now.wind[p->index]; break;
        default: values[i] = system_value(model, state, view, p->channel, &shared); break;
        }
    }
}

int gallop_observe(const gallop_model *model, gallop_state *state, const gallop_probe *probe,
                   int32_t probes, double *values)
{
    gallop_report report; /* the caller gets none */
    int outcome = check_state(model, state, &report);
    if (!outcome) outcome = check_probes(model, probe, probes, &report);
    if (outcome || (probes > 0 && !base_pointer_usable(values, WORD))) return GALLOP_BAD_CALL;
    const state_view view = state_view_of(model, state);
    observe_probes(model, state, &view, probe, probes, values);
    return GALLOP_COMPLETED;
}
