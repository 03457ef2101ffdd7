/* Calls that move values: variables, derivatives, and what the FMU has none of. */
#include "sequence.h"

/* Mostly near the start value of a variable, so that spans stay spans. */
static double value_for(const resource_variable *v)
{
    uint8_t b = byte();
    if (v->origin == RESOURCE_INPUT && b > 32)
        switch (resource_first_target(&table, v->index)->kind) {
        case RESOURCE_WIND: return b / 16.0;
        case RESOURCE_ATTACK_ANGLE: return 3.14159 + (b - 144) / 400.0;
        default: return (b - 144) / 2000.0;
        }
    if (v->origin != RESOURCE_PARAMETER || b < 32) return number();
    const char *at = resource_place(&table, v);
    if (v->whole) return *(const int32_t *)at + b % 3;
    return *(const double *)at / v->factor * (1.0 + (b - 144) / 4000.0);
}

static bool settable(const slot *s, const resource_variable *v, double value)
{
    bool parameter = v->origin == RESOURCE_PARAMETER, input = v->origin == RESOURCE_INPUT;
    const int modes = input ? SETTABLE : parameter ? INSTANTIATED | INITIALIZING : 0;
    if (!(s->is.mode & modes)) return false;
    return isfinite(value) && resource_allows(v, value, 1.0);
}

void set_values(slot *s, bool whole)
{
    fmi2ValueReference r[MOST];
    fmi2Real real[MOST];
    fmi2Integer integer[MOST];
    fmi2Status status;
    const size_t count = byte() % (MOST + 1);
    bool good = s->is.mode & SETTABLE;
    for (size_t i = 0; i < count; i++) {
        r[i] = reference();
        const resource_variable *v = variable(r[i]);
        real[i] = v ? value_for(v) : 0.0;
        integer[i] = fabs(real[i]) < 1e6 ? (fmi2Integer)real[i] : -7;
        good =
            good && v && (v->whole != 0) == whole && settable(s, v, whole ? integer[i] : real[i]);
    }
    if (byte() == 7) {
        verdict expected = count || !(s->is.mode & SETTABLE) ? REFUSED : ACCEPTED;
        JUDGE(s, expected, true, fmi2SetReal(s->c, NULL, count, NULL));
    } else if (whole) {
        JUDGE(s, good ? ACCEPTED : REFUSED, true, fmi2SetInteger(s->c, r, count, integer));
    } else {
        JUDGE(s, good ? ACCEPTED : REFUSED, true, fmi2SetReal(s->c, r, count, real));
    }
}

void get_values(slot *s, bool whole)
{
    fmi2ValueReference r[MOST];
    fmi2Real real[MOST];
    fmi2Integer integer[MOST];
    fmi2Status status;
    const size_t count = byte() % (MOST + 1);
    bool good = s->is.mode & ANY, open = false;
    for (size_t i = 0; i < count; i++) {
        r[i] = reference();
        const resource_variable *v = variable(r[i]);
        good = good && v && (v->whole != 0) == whole;
        if (!good || v->origin <= RESOURCE_INPUT) continue;
        if (s->is.mode == INSTANTIATED) good = false;
        if (s->is.mode == INITIALIZING) open = true; /* there may be no initial state */
    }
    verdict expected = !good ? REFUSED : open ? EITHER : ACCEPTED;
    if (whole)
        JUDGE(s, expected, s->is.mode != INITIALIZING, fmi2GetInteger(s->c, r, count, integer));
    else
        JUDGE(s, expected, s->is.mode != INITIALIZING, fmi2GetReal(s->c, r, count, real));
    for (size_t i = 0; status == fmi2OK && !whole && !s->is.forged && i < count; i++)
        REQUIRE(isfinite(real[i]));
}

void derive(slot *s, uint8_t what)
{
    fmi2ValueReference unknown[MOST], known[MOST];
    fmi2Integer order[MOST];
    fmi2Real value[MOST], found[MOST];
    fmi2Status status;
    const size_t count = byte() % (MOST + 1), other = byte() % (MOST + 1);
    bool inputs = true, outputs = true;
    for (size_t i = 0; i < MOST; i++) {
        known[i] = reference(), unknown[i] = byte() < 200 ? 8u + byte() % 16u : reference();
        order[i] = byte() < 230 ? 1 : (fmi2Integer)byte() - 100;
        value[i] = byte() < 230 ? (byte() - 128) / 100.0 : number();
    }
#if defined(FMI3)
    if (what == 0) return; /* FMI 3.0 has no derivatives of inputs */
#endif
    const size_t many = what == 2 ? other : count;
    for (size_t i = 0; i < many; i++) {
        const resource_variable *v = variable(known[i]);
        inputs = inputs && v && v->origin == RESOURCE_INPUT && isfinite(value[i]) &&
                 (what == 2 || order[i] == 1);
    }
    for (size_t i = 0; i < count; i++) {
        const resource_variable *v = variable(unknown[i]);
        outputs = outputs && v && !v->whole &&
                  (v->origin == RESOURCE_SUM || v->origin == RESOURCE_TURN ||
                   v->origin == RESOURCE_STATIC) &&
                  (what == 2 || order[i] == 1);
    }
    if (what == 0) {
#if !defined(FMI3)
        JUDGE(s, s->is.mode & SETTABLE && inputs ? ACCEPTED : REFUSED, true,
              fmi2SetRealInputDerivatives(s->c, known, count, order, value));
#endif
    } else if (what == 1) {
        verdict expected = s->is.looks_back ? ACCEPTED : EITHER;
        if (!(s->is.mode & (STEPPING | TERMINATED)) || !outputs) expected = REFUSED;
        JUDGE(s, expected, true, fmi2GetRealOutputDerivatives(s->c, unknown, count, order, found));
    } else {
        const bool allowed = s->is.mode & (INITIALIZING | STEPPING | TERMINATED);
        if (s->is.forged && !cheap(s->c, &table)) return;
        JUDGE(s, allowed && inputs && outputs ? EITHER : REFUSED, s->is.mode != INITIALIZING,
              fmi2GetDirectionalDerivative(s->c, unknown, count, known, other, value, found));
    }
}
