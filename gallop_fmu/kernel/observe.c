/* What can be seen of a state: node and span channels. */
#include "base_math.h"
#include "check.h"
#include "element.h"
#include "law.h"
#include "observe.h"

static const double *motion(const gallop_model *model, const gallop_state *state, int which)
{
    return state->values + (size_t)which * 4 * (size_t)model->nodes;
}

/* Linear through the two Gauss points (xi = +-1/sqrt 3), which are the accurate ones; averaged at
 * corner nodes. */
static double node_tension(const gallop_model *model, const double *u, int node)
{
    double sum = 0.0;
    int count = 0;
    for (int side = 0; side < 2; side++) {
        int e = node % 2 ? node / 2 : node / 2 - 1 + side;
        if (e < 0 || e >= model->elements || (side && node % 2)) continue;
        double xi = (double)(node - 2 * e - 1), t[2];
        element_tension(model, e, u + 8 * e, t);
        sum += 0.5 * (t[0] + t[1]) + xi * (t[1] - t[0]) / (element_gauss2[1] - element_gauss2[0]);
        count++;
    }
    return model->tension_only ? fmax(sum / count, 0.0) : sum / count;
}

void observe_node(const gallop_model *model, const gallop_state *state, int32_t node,
                  double values[GALLOP_NODE_CHANNELS])
{
    const double *u = motion(model, state, 0), *v = motion(model, state, 1),
                 *a = motion(model, state, 2);
    const double *n2 = model->normal + 2 * node;
    for (int i = 0; i < 4; i++) {
        values[GALLOP_U1 + i] = u[4 * node + i];
        values[GALLOP_V1 + i] = v[4 * node + i];
        values[GALLOP_A1 + i] = a[4 * node + i];
    }
    values[GALLOP_TENSION] = node_tension(model, u, node);
    values[GALLOP_ANGLE_OF_ATTACK] = element_attack_angle(
        u[4 * node + 3], n2[0] * v[4 * node] + n2[1] * v[4 * node + 1], v[4 * node + 2],
        v[4 * node + 3], state->now.wind, state->now.attack, model->radius);
}

/* Force of the cable on the tower: minus that of the support on the cable, which is the static one
 * plus the residual of the free body where the unknown is prescribed, and minus the spring's
 * elongation where it is not. */
static void support_force(const gallop_model *model, gallop_state *state, int end, double force[3])
{
    const double *u = motion(model, state, 0), *v = motion(model, state, 1),
                 *a = motion(model, state, 2);
    const int node = end ? model->nodes - 1 : 0, e = end ? model->elements - 1 : 0,
              own = end ? 8 : 0;
    const conditions *now = &state->now;
    double r[12];
    state_view at = state_view_of(model, state);
    element_residual(model, e, now, &at.sections, u, v, a, r);
    for (int l = 0; l < model->load_count; l++) {
        const load_place *place = &model->place[l];
        if (place->element != e) continue;
        double amplitude =
            now->load_factor * law_value(&model->scene.load[place->load].law, state->time);
        for (int i = 0; i < 3; i++)
            r[own + i] -=
                amplitude * place->shape[end ? 2 : 0] * model->scene.load[place->load].force[i];
    }
    for (int i = 0; i < 3; i++) {
        double extra = model->fixed[end][i]
                         ? r[own + i] - model->constant_force[4 * node + i]
                         : -model->stiffness[end][i] * (u[4 * node + i] - now->position[end][i]);
        force[i] = -(model->static_force[end][i] + extra);
    }
}

/* Kinetic and potential energy of the elements of a strip: see energies. */
INLINE void strip_energies(const gallop_model *model, const conditions *now, const strip *s,
                           lanes u[3][4], lanes v[3][4], lanes *kinetic, lanes *potential)
{
    const double ea = model->scene.axial_stiffness, gj = model->scene.torsional_stiffness;
    double theta[3 * LANES], sine[3 * LANES], cosine[3 * LANES];
    for (int q = 0; q < 3; q++)
        LANES_AT(theta + LANES * q) = element_shape3[q][0] * u[0][3] +
                                      element_shape3[q][1] * u[1][3] +
                                      element_shape3[q][2] * u[2][3];
    if (model->eccentric)
        for (int i = 0; i < 3 * LANES; i++) sine_cosine(theta[i], sine + i, cosine + i);
    for (int q = 0; q < 3; q++) {
        const double *n = element_shape3[q];
        lanes velocity[4];
        for (int i = 0; i < 4; i++) velocity[i] = n[0] * v[0][i] + n[1] * v[1][i] + n[2] * v[2][i];
        const lanes square =
            velocity[0] * velocity[0] + velocity[1] * velocity[1] + velocity[2] * velocity[2];
        const lanes w = velocity[3], weight = s->inertia_weight[q];
        *kinetic += weight * (0.5 * model->mass * square + 0.5 * model->inertia * w * w);
        if (!model->eccentric) continue;
        const lanes sin_q = LANES_AT(sine + LANES * q), cos_q = LANES_AT(cosine + LANES * q);
        const lanes c2 = now->c2 * cos_q - now->c3 * sin_q, c3 = now->c2 * sin_q + now->c3 * cos_q;
        const lanes v2 = s->normal[q][0] * velocity[0] + s->normal[q][1] * velocity[1];
        *kinetic += weight * w * (c2 * velocity[2] - c3 * v2);
        *potential += weight * model->scene.gravity * s->normal[q][1] *
                      (c2 - now->c2 + now->c3 * LANES_AT(theta + LANES * q));
    }
    for (int q = 0; q < 2; q++) {
        const lanes *n = s->shape_slope[q];
        lanes strain = {0.0}, du[4];
        for (int i = 0; i < 4; i++) du[i] = n[0] * (u[0][i] - u[1][i]) + n[1] * (u[2][i] - u[1][i]);
        for (int i = 0; i < 3; i++) strain += du[i] * (s->slope[q][i] + 0.5 * du[i]);
        const lanes slack = s->tension[q] / -ea; /* beyond, no more energy is released */
        if (model->tension_only) strain = PICK(strain > slack, strain, slack);
        const lanes axial = strain * (s->tension[q] + 0.5 * ea * strain),
                    torsional = 0.5 * gj * du[3] * du[3];
        *potential += s->stiffness_weight[q] * (axial + torsional);
    }
}

/* Kinetic: mu v.v/2 + w (c2 v3 - c3 v2) + I w^2/2, with v2 and v3 in the section's plane.
 * Potential: axial and torsional strain energy from the initial state, gravity, the constant
 * forces, and the springs. */
TWO_PATHS static void energies(const gallop_model *model, const gallop_state *state,
                               double *kinetic, double *potential)
{
    const double *u = motion(model, state, 0), *v = motion(model, state, 1);
    lanes kinetic_of = {0.0}, potential_of = {0.0};
    double k = 0.0, p = 0.0;
    for (int index = 0; index < model->strips; index++) {
        const int e = LANES * index, count = model->elements - e;
        lanes ue[3][4], ve[3][4];
        for (int n = 0; n < 3; n++) {
            read_nodes(u + 8 * e, n, count, ue[n]);
            read_nodes(v + 8 * e, n, count, ve[n]);
        }
        strip_energies(model, &state->now, &model->strip[index], ue, ve, &kinetic_of,
                       &potential_of);
    }
    for (int lane = 0; lane < LANES; lane++) {
        k += LANE(kinetic_of, lane);
        p += LANE(potential_of, lane);
    }
    for (int i = 0; i < 4 * model->nodes; i++) p -= model->constant_force[i] * u[i];
    for (int end = 0; end < 2; end++)
        for (int i = 0; i < 3; i++) {
            double stretch =
                u[(end ? 4 * (model->nodes - 1) : 0) + i] - state->now.position[end][i];
            p += 0.5 * model->stiffness[end][i] * stretch * stretch;
        }
    *kinetic = k;
    *potential = p;
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
    observe_node(model, state, node, values);
    return GALLOP_COMPLETED;
}

int gallop_support_forces(const gallop_model *model, gallop_state *state, double force[6])
{
    if (!observable(model, state, force)) return GALLOP_BAD_CALL;
    support_force(model, state, 0, force);
    support_force(model, state, 1, force + 3);
    return GALLOP_COMPLETED;
}

void observe_span(const gallop_model *model, gallop_state *state, uint32_t asked,
                  double values[GALLOP_SPAN_CHANNELS])
{
    const uint32_t left = 7u << GALLOP_LEFT_F1, right = 7u << GALLOP_RIGHT_F1;
    values[GALLOP_WIND_SPEED] = state->now.wind;
    if (asked & left) support_force(model, state, 0, values + GALLOP_LEFT_F1);
    if (asked & right) support_force(model, state, 1, values + GALLOP_RIGHT_F1);
    if (asked & (1u << GALLOP_KINETIC_ENERGY | 1u << GALLOP_POTENTIAL_ENERGY))
        energies(model, state, &values[GALLOP_KINETIC_ENERGY], &values[GALLOP_POTENTIAL_ENERGY]);
    values[GALLOP_NEWTON_ITERATIONS] = (double)state->last_iterations;
    values[GALLOP_SUBSTEPS] = (double)state->last_substeps;
}

int gallop_observe_span(const gallop_model *model, gallop_state *state,
                        double values[GALLOP_SPAN_CHANNELS])
{
    if (!observable(model, state, values)) return GALLOP_BAD_CALL;
    observe_span(model, state, ~0u, values);
    return GALLOP_COMPLETED;
}
