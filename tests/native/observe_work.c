/* Counts the work of an observation: observe.c with functions in place of the elements and devices
 * that count their calls.  Prints a line for each table of probes: how often forces at a junction,
 * energies, tensions and attack angles were computed. */
#include "observe.c"

#include <stdio.h>

static int forces, energy_sums, tensions, angles;

const double element_shape3[3][3], element_gauss2[2] = {-0.5, 0.5};

void device_tower_force(const gallop_model *model, int index, const conditions *now, motion y,
                        double force[3])
{
    (void)model, (void)now, (void)y;
    forces++;
    for (int i = 0; i < 3; i++) force[i] = 10.0 * index + i;
}

void device_add_energies(const gallop_model *model, const conditions *now, motion y,
                         double *kinetic, double *potential)
{
    (void)model, (void)now, (void)y, (void)kinetic;
    energy_sums++;
    *potential += 7.0;
}

double device_value(const gallop_model *model, int index, const conditions *now, motion y,
                    int channel)
{
    (void)model, (void)index, (void)now, (void)y, (void)channel;
    abort();
}

void element_tension(const interval *c, int e, bool tension_only, const double u[12], double t[2])
{
    (void)c, (void)e, (void)tension_only, (void)u;
    tensions++;
    t[0] = t[1] = 3.0;
}

double element_attack_angle(double theta, double v2, double v3, double omega, double wind,
                            double attack, double radius)
{
    (void)theta, (void)v2, (void)v3, (void)omega, (void)wind, (void)radius;
    angles++;
    return attack;
}

void conditions_wind_at(const gallop_model *model, const conditions *now, int field,
                        const wind_place *place, double wind[2])
{
    (void)model, (void)now, (void)field, (void)place;
    wind[0] = wind[1] = 0.0;
}

/* Not reached: no ice has fallen from the model below, no chain ends at a junction of it, and
 * nothing is checked. */
void element_add_lost_forces(const interval *c, int e, const exposure *now, double factor,
                             double force[12])
{
    (void)c, (void)e, (void)now, (void)factor, (void)force;
    abort();
}

void element_residual(const interval *c, int e, const exposure *now, const sections *at, motion y,
                      double r[12])
{
    (void)c, (void)e, (void)now, (void)at, (void)y, (void)r;
    abort();
}

double law_value(const law *l, double t)
{
    (void)l, (void)t;
    abort();
}

int check_state(const gallop_model *model, const gallop_state *state, gallop_report *report)
{
    (void)model, (void)state, (void)report;
    abort();
}

int check_probes(const gallop_model *model, const gallop_probe *probe, int32_t probes,
                 gallop_report *report)
{
    (void)model, (void)probe, (void)probes, (void)report;
    abort();
}

state_view state_view_of(const gallop_model *model, gallop_state *state)
{
    (void)model, (void)state;
    abort();
}

/* A chain of two elements and three junctions. */
static double numbers[20], residual[20], attack[1];
static cross_section section;
static interval conductor = {.shedding = -1, .section = &section, .elements = 2, .nodes = 5};
static chain line = {.junction = {-1, -1}, .intervals = 1, .elements = 2, .nodes = 5};
static junction point[3];
static const gallop_field field; /* of uniform wind */
static gallop_model model = {.nodes = 5,
                             .scene = {.field = &field},
                             .elements = 2,
                             .chain_count = 1,
                             .junction_count = 3,
                             .interval_count = 1,
                             .chain = &line,
                             .interval = &conductor,
                             .junction = point,
                             .normal = numbers,
                             .constant_force = numbers};

static void count(const gallop_probe *probe, int32_t probes)
{
    const state_view view = {
        .u = numbers,
        .v = numbers,
        .a = numbers,
        .residual = residual,
        .now = {.wind = numbers, .attack = attack, .c2 = numbers, .c3 = numbers}};
    gallop_state state = {.last_iterations = 3, .last_substeps = 1};
    double values[8];
    for (int i = 0; i < 20; i++) residual[i] = NAN;
    forces = energy_sums = tensions = angles = 0;
    observe_probes(&model, &state, &view, probe, probes, values);
    for (int32_t i = 0; i < probes; i++)
        if (isnan(values[i])) abort();
    printf("%d %d %d %d\n", forces, energy_sums, tensions, angles);
}

#define COUNT_WORK(...)                                                                            \
    do {                                                                                           \
        const gallop_probe probe[] = {__VA_ARGS__};                                                \
        count(probe, (int32_t)(sizeof probe / sizeof *probe));                                     \
    } while (0)

#define NODE(n, quantity) {.object = GALLOP_PROBE_NODE, .index = n, .channel = quantity}
#define JUNCTION(j, quantity) {.object = GALLOP_PROBE_JUNCTION, .index = j, .channel = quantity}
#define WIND {.object = GALLOP_PROBE_FIELD}
#define SYSTEM(quantity) {.object = GALLOP_PROBE_SYSTEM, .channel = quantity}

int main(void)
{
    COUNT_WORK(NODE(0, GALLOP_U1), NODE(2, GALLOP_OMEGA), NODE(4, GALLOP_OMEGA_RATE), WIND,
               SYSTEM(GALLOP_NEWTON_ITERATIONS), SYSTEM(GALLOP_SUBSTEPS));
    COUNT_WORK(NODE(1, GALLOP_TENSION), NODE(1, GALLOP_U2));
    COUNT_WORK(NODE(1, GALLOP_ANGLE_OF_ATTACK), NODE(1, GALLOP_U2));
    COUNT_WORK(JUNCTION(0, GALLOP_F1), JUNCTION(2, GALLOP_F1), JUNCTION(0, GALLOP_F3),
               JUNCTION(2, GALLOP_F2));
    COUNT_WORK(JUNCTION(1, GALLOP_F3));
    COUNT_WORK(SYSTEM(GALLOP_POTENTIAL_ENERGY), WIND, SYSTEM(GALLOP_KINETIC_ENERGY),
               SYSTEM(GALLOP_POTENTIAL_ENERGY));
    return 0;
}
