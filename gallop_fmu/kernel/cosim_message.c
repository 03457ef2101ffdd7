/* Messages of the co-simulation layer. */
#include "cosim_message.h"

#include <ctype.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

cosim_number cosim_number_text(int digits, double value)
{
    cosim_number out;
    char *to = out.text;
    snprintf(out.text, sizeof out.text, "%.*g", digits, value);

    /* What is no digit, letter or sign is a byte of the locale's decimal mark. */
    for (const char *from = out.text; *from; from++) {
        const bool plain = *from > 0 && (isalnum(*from) || *from == '-' || *from == '+');
        if (plain)
            *to++ = *from;
        else if (to == out.text || to[-1] != '.')
            *to++ = '.';
    }
    *to = '\0';
    return out;
}

gallop_cosim_status cosim_refuse(gallop_cosim *c, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(c->message, sizeof c->message, format, arguments);
    va_end(arguments);
    return GALLOP_COSIM_REFUSED;
}

gallop_cosim_status cosim_fail(gallop_cosim *c, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(c->message, sizeof c->message, format, arguments);
    va_end(arguments);
    return GALLOP_COSIM_FAILED;
}

static cosim_phrase angle_detail(const gallop_report *report)
{
    cosim_phrase out;
    const double degrees = 180.0 / 3.14159265358979323846, over = report->value - report->limit;
    snprintf(out.text, sizeof out.text, ": %s deg, %s deg %s limit of %s deg",
             cosim_number_text(6, degrees * report->value).text,
             cosim_number_text(2, degrees * fabs(over)).text,
             over < 0.0 ? "below the curve's lower" : "above the curve's upper",
             cosim_number_text(6, degrees * report->limit).text);
    return out;
}

/* "value 3, limit 2", or the one of them that there is. */
static cosim_phrase numbers_of(const gallop_report *report)
{
    cosim_phrase out = {""};
    const bool has_value = !isnan(report->value), has_limit = !isnan(report->limit);
    const cosim_number value = cosim_number_text(4, report->value);
    const cosim_number limit = cosim_number_text(4, report->limit);
    if (has_value && has_limit)
        snprintf(out.text, sizeof out.text, "value %s, limit %s", value.text, limit.text);
    else if (has_value)
        snprintf(out.text, sizeof out.text, "value %s", value.text);
    else if (has_limit)
        snprintf(out.text, sizeof out.text, "limit %s", limit.text);
    return out;
}

/* The numbers of a failure; Report._detail in gallop_fmu/foundation/outcome.py writes the same. */
static cosim_phrase detail_of(const gallop_report *report)
{
    cosim_phrase out = {""};
    if (report->outcome == GALLOP_ANGLE_OUT_OF_RANGE) return angle_detail(report);
    if (report->outcome == GALLOP_SLACK) {
        snprintf(out.text, sizeof out.text, ": %s N", cosim_number_text(4, report->value).text);
        return out;
    }
    if (!report->field && !isfinite(report->value)) return out;
    const cosim_phrase numbers = numbers_of(report);
    const char *open = numbers.text[0] ? " (" : "", *close = numbers.text[0] ? ")" : "";
    snprintf(out.text, sizeof out.text, "%s%.160s%s%.80s%s", report->field ? ": " : "",
             report->field ? report->field : "", open, numbers.text, close);
    return out;
}

/* Where it failed; LineMap.place_of in gallop_fmu/engine/line_map.py writes the same. */
static cosim_phrase place_of(const gallop_cosim *c, const gallop_report *report)
{
    cosim_phrase out = {""};
    const gallop_scene scene = resource_scene(&c->parameters);
    const char *device = resource_find_label(&c->parameters, RESOURCE_OF_DEVICE, report->device);
    if (report->device >= 0 && device) {
        snprintf(out.text, sizeof out.text, " %s", device);
        return out;
    }
    if (report->element < 0) return out;
    int32_t own = report->element, k = 0;
    while (k < scene.chain_count - 1 && own >= scene.chain[k].elements)
        own -= scene.chain[k++].elements;
    const char *chain = resource_find_label(&c->parameters, RESOURCE_OF_CHAIN, k);
    if (chain)
        snprintf(out.text, sizeof out.text, " %s, element %d of %d", chain, own + 1,
                 scene.chain[k].elements);
    else
        snprintf(out.text, sizeof out.text, " in element %d (counted from the left)",
                 report->element + 1);
    return out;
}

gallop_cosim_status cosim_fail_with_report(gallop_cosim *c, const char *what,
                                           const gallop_report *report)
{
    const resource_outcome *o = resource_find_outcome(&c->parameters, report->outcome);
    const char *sentence = o ? o->sentence : "it could not be carried out";
    const char *remedy = o ? o->remedy : "check the parameters";
    return cosim_fail(c, "%s: at %s s%s %s%s. What to do: %s.", what,
                      cosim_number_text(6, report->time).text, place_of(c, report).text, sentence,
                      detail_of(report).text, remedy);
}

static const char *phase_text(int phase)
{
    switch (phase) {
    case COSIM_INSTANTIATED: return "before initialization";
    case COSIM_INITIALIZING: return "in initialization";
    case COSIM_STEPPING: return "while stepping";
    default: return "after termination";
    }
}

bool cosim_is_allowed(gallop_cosim *c, int phases, const char *action)
{
    if (!c) return false;
    if (c->run.phase & phases) return true;

    char allowed[128] = "";
    for (int phase = COSIM_INSTANTIATED; phase <= COSIM_TERMINATED; phase *= 2) {
        if (!(phases & phase)) continue;
        if (allowed[0]) strcat(allowed, " or ");
        strcat(allowed, phase_text(phase));
    }
    cosim_refuse(c, "%s is not allowed %s; it is allowed %s", action, phase_text(c->run.phase),
                 allowed);
    return false;
}
