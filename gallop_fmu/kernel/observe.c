/* What can be seen of a state: node and span channels. */
#include "observe.h"

#include "base_math.h"
#include "check.h"
#include "device.h"
#include "law.h"

/* Linear through the two Gauss points (xi = +-1/sqrt 3), which are the accurate ones; averaged at
 * corner nodes. */
static double node_tension(const chain *c, const double *u, int node)
{
    const bool tension_only = c->section->tension_only;
    double sum = 0.0;
    int count = 0;
    for (int side = 0; side < 2; side++) {
        int e = node % 2 ? node / 2 : node / 2 - 1 + side;
        if (e < 0 || e >= c->elements || (side && node % 2)) continue;
        double xi = (double)(node - 2 * e - 1), t[2];
        element_tension(c, e, tension_only, u + 8 * e, t);
        sum += 0.5 * (t[0] + t[1]) + xi * (t[1] - t[0]) / (element_gauss2[1] - element_gauss2[0]);
        count++;
    }
    return tension_only ? fmax(sum / count, 0.0) : sum / count;
}

void observe_node(const gallop_model *model, const state_view *view, int32_t node,
                  double values[GALLOP_NODE_CHANNELS])
{
    const chain *c = model_chain_of_node(model, node);
    const exposure now = conditions_on(model, &view->now, c);
    const double *u = view->u + 4 * node, *v = view->v + 4 * node, *a = view->a + 4 * node;
    const double *n2 = model->normal + 2 * node;
    for (int i = 0; i < 4; i++) {
        values[GALLOP_U1 + i] = u[i];
        values[GALLOP_V1 + i] = v[i];
        values[GALLOP_A1 + i] = a[i];
    }
    values[GALLOP_TENSION] = node_tension(c, view->u + 4 * c->first_node, node - c->first_node);
    values[GALLOP_ANGLE_OF_ATTACK] = element_attack_angle(
        u[3], n2[0] * v[0] + n2[1] * v[1], v[2], v[3], now.wind, now.attack, c->section->radius);
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
    const exposure now = conditions_on(model, &view->now, c);
    const int first = 4 * c->first_node, e = end ? c->elements - 1 : 0, own = end ? 8 : 0;
    const int node = first + (end ? 4 * (c->nodes - 1) : 0);
    const motion y = {view->u + first, view->v + first, view->a + first};
    double r[12];
    element_residual(c, e, &now, &view->sections, y, r);
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
    double of_devices[4], of_chains[3] = {0.0, 0.0, 0.0};
    device_forces_at(model, index, &view->now, y, of_devices);
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
INLINE void strip_energies(const chain *c, const exposure *now, const strip *s, lanes u[3][4],
                           lanes v[3][4], lanes *kinetic, lanes *potential)
{
    const double ea = c->section->axial_stiffness, gj = c->section->torsional_stiffness;
    double theta[3 * LANES], sine[3 * LANES], cosine[3 * LANES];
    for (int q = 0; q < 3; q++)
        LANES_AT(theta + LANES * q) = element_shape3[q][0] * u[0][3] +
                                      element_shape3[q][1] * u[1][3] +
                                      element_shape3[q][2] * u[2][3];
    if (c->section->eccentric)
        for (int i = 0; i < 3 * LANES; i++) sine_cosine(theta[i], sine + i, cosine + i);
    for (int q = 0; q < 3; q++) {
        const double *n = element_shape3[q];
        lanes velocity[4];
        for (int i = 0; i < 4; i++) velocity[i] = n[0] * v[0][i] + n[1] * v[1][i] + n[2] * v[2][i];
        const lanes square =
            velocity[0] * velocity[0] + velocity[1] * velocity[1] + velocity[2] * velocity[2];
        const lanes w = velocity[3], weight = s->inertia_weight[q];
        *kinetic += weight * (0.5 * c->section->mass * square + 0.5 * c->section->inertia * w * w);
        if (!c->section->eccentric) continue;
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

/* Kinetic: mu v.v/2 + w (c2 v3 - c3 v2) + I w^2/2, with v2 and v3 in the section's plane.
 * Potential: axial and torsional strain energy from the initial state, gravity, the constant
 * forces, and the devices. */
TWO_PATHS static void energies(const gallop_model *model, const state_view *view, double *kinetic,
                               double *potential)
{
    const motion y = {view->u, view->v, view->a};
    double k = 0.0, p = 0.0;
    for (int i = 0; i < model->chain_count; i++) {
        const chain *c = &model->chain[i];
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
    }
    for (int i = 0; i < 4 * model->nodes; i++) p -= model->constant_force[i] * view->u[i];
    *kinetic = k;
    *potential = p + device_energy(model, &view->now, y);
}

/* Whether the arguments of an observation can be used; who observes gets no report. */
static bool observable(const gallop_model *model, const gallop_state *state, const double *values)
{
    gallop_report report;
    return check_state(model, state, &report) == GALLOP_COMPLETED &&
           base_pointer_usable(values, WORD);
}

int gallop_observe_node(const gallop_model *model, const gallop_state *state, int32_t node,
                        double values[GALLOP_NODE_CHANNELS])
{
    if (!observable(model, state, values)) return GALLOP_BAD_CALL;
    if (node < 0 || node >= model->nodes) return GALLOP_BAD_CALL;
    const state_view view = state_view_of(model, (gallop_state *)state); /* only read */
    observe_node(model, &view, node, values);
    return GALLOP_COMPLETED;
}

int gallop_support_forces(const gallop_model *model, gallop_state *state, double force[6])
{
    if (!observable(model, state, force)) return GALLOP_BAD_CALL;
    const state_view view = state_view_of(model, state);
    support_force(model, state, &view, 0, force);
    support_force(model, state, &view, model->junction_count - 1, force + 3);
    return GALLOP_COMPLETED;
}

void observe_span(const gallop_model *model, const gallop_state *state, const state_view *view,
                  uint32_t asked, double values[GALLOP_SPAN_CHANNELS])
{
    const uint32_t left = 7u << GALLOP_LEFT_F1, right = 7u << GALLOP_RIGHT_F1;
    const uint32_t energy = 1u << GALLOP_KINETIC_ENERGY | 1u << GALLOP_POTENTIAL_ENERGY;
    values[GALLOP_WIND_SPEED] = view->now.wind[0];
    if (asked & left) support_force(model, state, view, 0, values + GALLOP_LEFT_F1);
    if (asked & right)
        support_force(model, state, view, model->junction_count - 1, values + GALLOP_RIGHT_F1);
    if (asked & energy)
        energies(model, view, &values[GALLOP_KINETIC_ENERGY], &values[GALLOP_POTENTIAL_ENERGY]);
    values[GALLOP_NEWTON_ITERATIONS] = (double)state->last_iterations;
    values[GALLOP_SUBSTEPS] = (double)state->last_substeps;
}

int gallop_observe_span(const gallop_model *model, gallop_state *state,
                        double values[GALLOP_SPAN_CHANNELS])
{
    if (!observable(model, state, values)) return GALLOP_BAD_CALL;
    const state_view view = state_view_of(model, state);
    observe_span(model, state, &view, ~0u, values);
    return GALLOP_COMPLETED;
}
