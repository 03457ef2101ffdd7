/* How a failure gets into a report. */
#include "internal.h"

int fail(gallop_report *report, int outcome, int element, double time, double value, double limit)
{
    if (report) {
        report->outcome = outcome;
        report->element = element;
        report->time = time;
        report->value = value;
        report->limit = limit;
        report->field = NULL;
    }
    return outcome;
}

int invalid(gallop_report *report, const char *field, double value, double limit)
{
    fail(report, GALLOP_INVALID_SCENE, -1, 0.0, value, limit);
    report->field = field;
    return GALLOP_INVALID_SCENE;
}
