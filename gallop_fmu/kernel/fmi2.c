/* The FMI 2.0 co-simulation functions.  No physics here: they move numbers between the host and the
 * kernel.
 *
 * wind_speed and attack_angle hold their value over a communication step, or change at the rate
 * that fmi2SetRealInputDerivatives gives; the tower points move linearly to their new places, which
 * they reach at its end. A call that is not allowed is refused with a message and changes nothing;
 * a step that cannot be carried out returns fmi2Error and leaves the state as it was.  fmi2Fatal is
 * never returned. */
#include "fmi2_instance.h"

#include <ctype.h>
#include <stdarg.h>
#include <stdio.h>

/* A number as %g writes it, with a decimal point whatever the host's locale. */
numeral numeral_of(int digits, double value)
{
    numeral out;
    char *to = out.text;
    snprintf(out.text, sizeof out.text, "%.*g", digits, value);
    for (const char *from = out.text; *from; from++) {
        const bool plain = *from > 0 && (isalnum(*from) || *from == '-' || *from == '+');
        if (plain)
            *to++ = *from;
        else if (to == out.text || to[-1] != '.')
            *to++ = '.'; /* one or more bytes of a locale's decimal sign */
    }
    *to = '\0';
    return out;
}

/* The logger takes a format of printf, but some hosts show it as it is: so the whole text is the
 * format, % doubled. */
fmi2Status say(instance *c, fmi2Status status, const char *format, ...)
{
    char text[1024], escaped[2 * sizeof text], *to = escaped;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    for (const char *from = text; *from; from++) {
        if (*from == '%') *to++ = '%';
        *to++ = *from;
    }
    *to = '\0';
    if (c->call.logger) {
        const char *category = status == fmi2Discard ? "logStatusDiscard" : "logStatusError";
        c->call.logger(c->call.componentEnvironment, c->name, status, category, escaped);
    }
    return status;
}

bool allowed(instance *c, int modes, const char *function)
{
    if (c && (c->now.mode & modes)) return true;
    if (c) {
        const char *where = c->now.mode == INSTANTIATED ? "before initialization"
                          : c->now.mode == INITIALIZING ? "in initialization mode"
                          : c->now.mode == STEPPING     ? "while stepping"
                                                        : "after termination";
        say(c, fmi2Error, "%s is not allowed %s", function, where);
    }
    return false;
}

/* The numbers of a failure; Report._detail in gallop_fmu/foundation/outcome.py writes the same. */
static phrase detail_of(const gallop_report *report)
{
    phrase out = {""};
    const double degrees = 180.0 / 3.14159265358979323846, over = report->value - report->limit;
    const numeral value = numeral_of(4, report->value), limit = numeral_of(4, report->limit);
    const bool valued = !isnan(report->value), limited = !isnan(report->limit),
               any = valued || limited;
    if (report->outcome == GALLOP_ANGLE_OUT_OF_RANGE)
        snprintf(out.text, sizeof out.text, ": %s deg, %s deg %s limit of %s deg",
                 numeral_of(6, degrees * report->value).text,
                 numeral_of(2, degrees * fabs(over)).text,
                 over < 0.0 ? "below the curve's lower" : "above the curve's upper",
                 numeral_of(6, degrees * report->limit).text);
    else if (report->outcome == GALLOP_SLACK)
        snprintf(out.text, sizeof out.text, ": %s N", value.text);
    else if (report->field || isfinite(report->value))
        snprintf(out.text, sizeof out.text, "%s%.160s%s%s%s%s%s%s%s", report->field ? ": " : "",
                 report->field ? report->field : "", any ? " (" : "", valued ? "value " : "",
                 valued ? value.text : "", valued && limited ? ", " : "", limited ? "limit " : "",
                 limited ? limit.text : "", any ? ")" : "");
    return out;
}

/* One sentence with time, element and cure. */
fmi2Status tell(instance *c, const char *what, const gallop_report *report)
{
    const resource_header *head = resource_head(&c->parameters);
    const resource_outcome *o = (const resource_outcome *)(c->parameters.bytes + head->outcomes);
    const char *sentence = "it could not be carried out", *cure = "check the parameters";
    for (uint32_t i = 0; i < head->outcome_count; i++)
        if (o[i].code == report->outcome) {
            sentence = o[i].sentence;
            cure = o[i].cure;
        }
    char place[64] = "";
    if (report->element >= 0)
        snprintf(place, sizeof place, " in element %d (counted from the left)",
                 report->element + 1);
    return say(c, fmi2Error, "%s: at %s s%s %s%s. What to do: %s.", what,
               numeral_of(6, report->time).text, place, sentence, detail_of(report).text, cure);
}

static bool copy_text(char **to, const char *from)
{
    size_t size = strlen(from) + 1;
    *to = malloc(size);
    if (*to) memcpy(*to, from, size);
    return *to != NULL;
}

void span_free(span *s)
{
    gallop_model_free(s->model);
    free(s->state);
    free(s->work);
    memset(s, 0, sizeof *s);
}

void forget_observations(instance *c)
{
    c->node_known = c->forces_known = false;
}

void drop_span(instance *c)
{
    span_free(&c->span);
    c->started = false;
    forget_observations(c);
}

/* Model and empty states of the present parameters; on failure `s` is empty. */
fmi2Status build_span(instance *c, span *s)
{
    gallop_scene scene;
    gallop_load *load;
    gallop_report report = {.element = -1};
    memset(s, 0, sizeof *s);
    const char *wrong = resource_scene(&c->parameters, &scene, &load);
    int outcome = wrong ? GALLOP_INVALID_SCENE : gallop_model_create(&scene, &s->model, &report);
    free(load);
    if (wrong) return say(c, fmi2Error, "%s", wrong);
    if (outcome) return tell(c, "the parameters do not make a span", &report);
    const size_t size = gallop_state_size(s->model);
    s->state = calloc(1, size);
    s->work = calloc(1, size);
    if (s->state && s->work) return fmi2OK;
    span_free(s);
    return say(c, fmi2Error, "there is not enough memory for the state: %lu bytes",
               (unsigned long)size);
}

void held_inputs(const double input[INPUTS], double time, gallop_inputs *in)
{
    memset(in, 0, sizeof *in);
    in->time = time;
    in->wind_speed = input[0];
    in->attack_angle = input[1];
    memcpy(in->support, input + 2, sizeof in->support);
}

/* Until stepping begins, model and state follow parameters and inputs when somebody looks. */
fmi2Status make_current(instance *c)
{
    if (c->started) return fmi2OK;
    if (!c->span.model && build_span(c, &c->span) != fmi2OK) {
        c->now.status = GALLOP_INVALID_SCENE;
        return fmi2Error;
    }
    gallop_inputs in;
    gallop_report report;
    held_inputs(c->now.input, c->now.start, &in);
    forget_observations(c);
    c->now.status = gallop_state_init(c->span.model, c->span.state, c->now.start, &in, &report);
    if (c->now.status) return tell(c, "there is no initial state", &report);
    memcpy(c->now.reached, c->now.input + 2, sizeof c->now.reached);
    memcpy(c->before.input, c->now.input, sizeof c->now.input);
    c->before.kind = BEGINNING;
    c->now.time = c->now.start;
    c->started = true;
    return fmi2OK;
}

const char *fmi2GetTypesPlatform(void)
{
    return fmi2TypesPlatform;
}

const char *fmi2GetVersion(void)
{
    return fmi2Version;
}

/* As it is when the host gets it: the parameters and inputs of the scene, and no state. */
static void begin(instance *c)
{
    memcpy(c->parameters.bytes, c->original, c->parameters.size);
    list_parameters(c);
    drop_span(c);
    memset(&c->now, 0, sizeof c->now);
    memset(&c->before, 0, sizeof c->before);
    c->now.mode = INSTANTIATED;
    c->now.stop = INFINITY;
    resource_start_inputs(&c->parameters, c->now.input);
}

static uint32_t count_parameters(const resource *r)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < resource_head(r)->variable_count; i++)
        count += resource_table(r)[i].origin == ORIGIN_PARAMETER;
    return count;
}

static void release(instance *c)
{
    drop_span(c);
    resource_free(&c->parameters);
    free(c->original);
    free(c->stored);
    free(c->name);
    free(c);
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String location,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                              fmi2Boolean logging)
{
    (void)visible;
    (void)logging; /* errors are always told, and there is nothing else to tell */
    instance *c = calloc(1, sizeof *c);
    if (!c) return NULL;
    if (functions) c->call = *functions;
    const char *wrong = NULL;
    const char *fault = gallop_arithmetic_fault();
    if (!copy_text(&c->name, name ? name : ""))
        wrong = "there is not enough memory";
    else if (!name || !*name)
        wrong = "an instance needs a name";
    else if (type != fmi2CoSimulation)
        wrong = "this FMU is for co-simulation only";
    else if (!guid)
        wrong = "no GUID was given";
    else if (!fault)
        wrong = resource_read(&c->parameters, location, guid);
    if (!wrong && !fault) {
        c->parameter_count = count_parameters(&c->parameters);
        c->original = malloc(c->parameters.size);
        c->stored = malloc(c->parameter_count * sizeof *c->stored + 1);
        if (!c->original || !c->stored) wrong = "there is not enough memory";
    }
    if (wrong || fault) {
        if (wrong && c->name)
            say(c, fmi2Error, "%s", wrong);
        else if (c->name)
            say(c, fmi2Error, "this FMU cannot compute; check %s", fault);
        release(c);
        return NULL;
    }
    memcpy(c->original, c->parameters.bytes, c->parameters.size);
    begin(c);
    return c;
}

void fmi2FreeInstance(fmi2Component component)
{
    if (component) release(component);
}

static bool known_category(const char *category)
{
    return category &&
           (strcmp(category, "logStatusError") == 0 || strcmp(category, "logStatusDiscard") == 0);
}

fmi2Status fmi2SetDebugLogging(fmi2Component component, fmi2Boolean logging, size_t count,
                               const fmi2String categories[])
{
    (void)logging;
    ALLOW(ANY);
    for (size_t i = 0; i < count; i++)
        if (!categories || !known_category(categories[i]))
            return say(
                c, fmi2Error,
                "the log category is unknown; there are logStatusError and logStatusDiscard");
    return fmi2OK;
}

fmi2Status fmi2SetupExperiment(fmi2Component component, fmi2Boolean tolerance_defined,
                               fmi2Real tolerance, fmi2Real start, fmi2Boolean stop_defined,
                               fmi2Real stop)
{
    (void)tolerance_defined;
    (void)tolerance;
    ALLOW(INSTANTIATED);
    if (!isfinite(start)) return say(c, fmi2Error, "the start time must be a number");
    if (stop_defined && !(stop > start))
        return say(c, fmi2Error, "the stop time %s s must lie after the start time %s s",
                   numeral_of(6, stop).text, numeral_of(6, start).text);
    c->now.start = c->now.time = start;
    c->now.stop = stop_defined ? stop : INFINITY;
    c->started = false;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component component)
{
    ALLOW(INSTANTIATED);
    c->now.mode = INITIALIZING;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component component)
{
    ALLOW(INITIALIZING);
    fmi2Status status = make_current(c);
    if (status == fmi2OK) c->now.mode = STEPPING;
    return status;
}

fmi2Status fmi2Terminate(fmi2Component component)
{
    ALLOW(STEPPING);
    c->now.mode = TERMINATED;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component component)
{
    ALLOW(ANY);
    begin(c);
    return fmi2OK;
}
